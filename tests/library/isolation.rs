//! Parts that try to reach other episodes, or to have other bits on another device: each is refused by the rule that its first line
//! names. `src/parts/compose/part/hostile.rs` refuses them by their compiled form alone.

use std::path::Path;
use std::sync::Arc;

use oneiro::compose::{OwnPart, OwnParts, Part, Rule};
use oneiro::world::World;

use crate::hostile::{Hostile, each};

/// The message with which a part is refused.
fn refused(hostile: &Hostile) -> Option<String> {
    let (kind, mut spec) = hostile.world();
    let part = match Part::new(kind, "hostile.wgsl", &hostile.text) {
        Ok(part) => part,
        Err(refused) => return Some(refused.to_string()),
    };
    let own = OwnPart::new(Arc::new(part), &[]).expect("it has no values");
    spec.own = OwnParts::from([own]);
    World::new(spec).err().map(|invalid| invalid.to_string())
}

#[test]
fn each_is_refused_by_its_rule() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("hostile");
    each(&folder, |hostile| {
        let rule = &hostile.rule;
        if !Rule::ALL.iter().any(|known| known.name() == rule) {
            return Some("is no rule".into());
        }
        match refused(hostile) {
            None => Some("accepted".into()),
            Some(message) => (!message.contains(&format!("[{rule}]"))).then_some(message),
        }
    });
}
