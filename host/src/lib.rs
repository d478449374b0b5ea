//! The program `oneiro`: evolves robot controllers, and evaluates, replays, audits and measures them. Other programs use the
//! same through [`api`], as the Python package does.

// `clippy.toml` says what has one place only.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

pub use ending::Ending;
use std::process::ExitCode;

pub mod api;
mod calibrate;
mod cli;
mod columns;
mod commands;
mod console;
mod contents;
mod daemon;
mod device;
mod disk;
#[cfg(test)]
mod documented;
mod ending;
mod engine;
mod evolve;
mod exchange;
mod exit;
mod experiment;
mod files;
mod fleet;
mod genomes;
mod kinds;
mod lives;
#[cfg(test)]
#[path = "../../tests/mutations/mod.rs"]
mod mutations;
mod npy;
mod numbers;
#[cfg(test)]
#[path = "../../tests/pinned/mod.rs"]
mod pinned;
mod progress;
mod reality;
mod record;
mod report;
mod robots;
mod runs;
#[cfg(test)]
#[path = "../../tests/scratch/mod.rs"]
mod scratch;
mod sealed;
#[cfg(test)]
#[path = "../../tests/skips/mod.rs"]
mod skips;
mod statistics;
mod studies;
mod swarm;
mod sweep;
mod threads;
mod utc;
mod workload;

/// Does what the command line says, prints what there is to say, and returns the exit code.
pub fn main() -> ExitCode {
    ending::prepare();
    device::quiet_drivers();
    let (output, command) = match cli::Cli::typed() {
        Ok(typed) => typed,
        Err(error) => return ExitCode::from(console::usage(&error)),
    };
    let console = console::Console::new(output);
    ending::end(ending::code_of(console, || {
        command.and_then(|command| commands::run(command, console))
    }))
}
