//! The program `oneiro`: evolves robot controllers, and evaluates, replays, audits and measures them. Other programs use the
//! same through [`api`], as the Python package does.

// `clippy.toml` says what has one place only.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

use std::process::ExitCode;

pub use oneiro_base::ending::Ending;
use oneiro_base::{console, ending};
use oneiro_lab::device;

pub mod api;
mod cli;
mod commands;
#[cfg(test)]
mod documented;
#[cfg(test)]
#[allow(dead_code, reason = "other tests use the rest")]
#[path = "../../tests/mutations/mod.rs"]
mod mutations;
#[cfg(test)]
#[allow(dead_code, reason = "other tests use the rest")]
#[path = "../../tests/scratch/mod.rs"]
mod scratch;

/// The commit that it was built from, `-modified` if files differed.
const COMMIT: &str = env!("ONEIRO_COMMIT");

/// Does what the command line says, prints what there is to say, and returns the exit code.
pub fn main() -> ExitCode {
    ending::prepare();
    device::quiet_drivers();
    let (output, command) = match cli::Cli::typed() {
        Ok(typed) => typed,
        Err(error) => return ExitCode::from(cli::show(&error)),
    };
    let console = console::Console::new(output);
    let code = ending::code_of(console, || command.and_then(|command| commands::run(command, console)));
    ending::end(code, oneiro::background::settle)
}
