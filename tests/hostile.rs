//! Parts that try to reach other episodes, or to have other bits on another device: each is refused by the rule that its first line
//! names. `src/compose/part/hostile.rs` refuses them by their compiled form alone.

use std::path::Path;
use std::sync::Arc;

use oneiro::compose::{OwnPart, OwnParts, Part, Rule};
use oneiro::world::World;

#[allow(dead_code, reason = "other tests use the rest")]
#[path = "hostile/world.rs"]
mod world;
use world::{Hostile, all};

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
    let all = all(&Path::new(env!("CARGO_MANIFEST_DIR")).join("hostile"));
    let mut problems = Vec::new();
    for hostile in &all {
        let Hostile { name, rule, .. } = hostile;
        assert!(
            Rule::ALL.iter().any(|known| known.name() == rule),
            "{name}: {rule} is no rule"
        );
        match refused(hostile) {
            None => problems.push(format!("{name}: accepted")),
            Some(message) if !message.contains(&format!("[{rule}]")) => problems.push(format!("{name}: {message}")),
            Some(_) => {}
        }
    }
    assert!(all.len() > 200, "{} parts", all.len());
    assert!(
        problems.is_empty(),
        "{} of {}:\n{}",
        problems.len(),
        all.len(),
        problems.join("\n")
    );
}
