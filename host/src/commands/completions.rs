//! `oneiro completions`: a completion script for a shell.

use oneiro_base::console::Console;
use oneiro_base::exit::{Failure, Result};

use crate::cli::{self, Completions};

/// Prints the script.
pub(crate) fn run(arguments: &Completions, console: Console) -> Result {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut cli::command(), "oneiro", &mut script);
    let script = String::from_utf8(script).map_err(Failure::failed)?;
    console.print_plain(script)
}
