//! Examples, by their names.

use oneiro::parameter::nearest;
use oneiro_base::exit::{Failure, Result};
use oneiro_experiments::{EXAMPLES, Example};
use oneiro_lab::experiment::values::instead;

/// The example with this name, among those that are allowed. `argument` is what asks for it, for the message.
pub(crate) fn named(argument: &str, name: &str, is_allowed: impl Fn(&Example) -> bool) -> Result<&'static Example> {
    let mut allowed = EXAMPLES.iter().filter(|example| is_allowed(example));
    if let Some(found) = allowed.clone().find(|example| example.name == name) {
        return Ok(found);
    }
    let names: Vec<&str> = allowed.clone().map(|example| example.name).collect();
    let begun = allowed.find(|example| example.name.starts_with(name));
    let meant = begun
        .map(|example| example.name)
        .or_else(|| nearest(names.iter().copied(), name));
    let instead = instead(meant, &names.join(", "));
    Err(Failure::input(format_args!("{argument} {name}: is unknown{instead}")))
}
