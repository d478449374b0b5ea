//! `oneiro new`: a commented experiment to start from.

use std::path::Path;

use crate::cli::New;
use crate::console::Console;
use crate::exit::{Failure, Result};
use crate::files;

/// The experiment that the README begins with; its comments explain every value.
const EXAMPLE: &str = include_str!("../../../experiments/khepera-avoidance.toml");
/// Its name, which becomes the new one's.
const EXAMPLE_NAME: &str = "name = \"khepera-avoidance\"";

/// Writes `NAME.toml`.
pub(crate) fn run(arguments: &New, console: Console) -> Result {
    let name = arguments.name.strip_suffix(".toml").unwrap_or(&arguments.name);
    let allowed = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if name.is_empty() || name.len() > 64 || name.starts_with(['-', '.']) || !name.chars().all(allowed) {
        return Err(Failure::input(format_args!(
            "NAME: `{name}` can't name an experiment; allowed: up to 64 letters, digits, -, _ and ., not beginning with - or ."
        )));
    }
    let path = format!("{name}.toml");
    let text = EXAMPLE.replacen(EXAMPLE_NAME, &format!("name = \"{name}\""), 1);
    files::write_new(Path::new(&path), text.as_bytes())?;
    console.say(format!(
        "wrote {path}; next: oneiro check {path}, then oneiro run {path}"
    ));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_example_has_its_name_once() {
        assert_eq!(EXAMPLE.matches(EXAMPLE_NAME).count(), 1);
    }
}
