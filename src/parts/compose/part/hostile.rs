//! Hostile parts are refused by the compiled form alone, whatever the checks of their text say.

use std::path::Path;
use std::sync::Arc;

use oneiro_shader_compiler as compiler;
use oneiro_shader_compiler::{Isolation, check_compiled};

use super::{Part, interface, kernel};
use crate::parts::compose::{OwnPart, OwnParts};

#[path = "../../../../tests/hostile/world.rs"]
mod world;
use world::{Hostile, each};

/// What is said of a part whose text nobody looks at.
fn refused(hostile: &Hostile) -> Option<String> {
    let (kind, spec) = hostile.world();
    let source = compiler::Part {
        path: "hostile.wgsl".into(),
        text: hostile.text.clone(),
    };
    let (part, _) = Part::read(kind, &source);
    let parts = OwnParts::from([OwnPart::new(Arc::new(part), &[]).expect("it has no values")]);
    let assembled = kernel::unchecked(&parts, &spec.unchecked_owner());
    let isolation = Isolation {
        episode: interface::EPISODE,
        users: &assembled.users,
    };
    let refusals = check_compiled(&assembled.parts, &isolation).err()?;
    Some(refusals.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
}

#[test]
fn each_is_refused_by_its_compiled_form() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/hostile");
    each(&folder, |hostile| {
        let found = refused(hostile);
        (found.is_none() != hostile.passes.is_some()).then(|| format!("{found:?}"))
    });
}
