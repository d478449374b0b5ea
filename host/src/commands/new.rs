//! `oneiro new`: a commented experiment to start from.

use std::path::Path;

use crate::cli::New;
use crate::console::Console;
use crate::exit::{Failure, Result};
use crate::experiment::reference;
use crate::files;

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
    let text = reference::example(name, arguments.swarm);
    files::write_new(Path::new(&path), text.as_bytes())?;
    console.say(format!(
        "wrote {path}; next: oneiro check {path}, then oneiro run {path}"
    ));
    Ok(())
}
