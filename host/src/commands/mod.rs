//! One file a command.

use crate::cli::Command;
use crate::console::Console;
use crate::exit::Result;

mod completions;
mod resume;
mod run;

/// Does what was typed.
pub(crate) fn run(command: Command, console: Console) -> Result {
    match command {
        Command::Run(arguments) => run::run(arguments, console),
        Command::Resume(arguments) => resume::run(arguments, console),
        Command::Completions(arguments) => completions::run(&arguments, console),
        _ => todo!(),
    }
}
