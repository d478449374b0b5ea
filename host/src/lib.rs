//! The program `oneiro`: evolves robot controllers, and evaluates, replays, audits and measures them. Other programs use the
//! same through [`api`], as the Python package does.

// `clippy.toml` says what has one place only.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use oneiro_base::ending::Ending;
use oneiro_base::{console, ending, program};
use oneiro_lab::device;

pub mod api;
mod cli;
mod commands;
#[cfg(test)]
mod documented;
mod examples;
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

/// One thread creates a sweep's jobs, and others continue them. With the system's allocator, threads that free or grow memory of other
/// threads wait for each other: sweeps of many short runs took a third longer.
#[cfg(feature = "mimalloc")]
type Memory = mimalloc::MiMalloc;
#[cfg(feature = "mimalloc")]
const MEMORY: Memory = mimalloc::MiMalloc;
#[cfg(not(feature = "mimalloc"))]
type Memory = std::alloc::System;
#[cfg(not(feature = "mimalloc"))]
const MEMORY: Memory = std::alloc::System;

/// The program's allocator.
pub type Allocator = Ending<Memory>;
/// It.
pub const ALLOCATOR: Allocator = Ending(MEMORY);

/// Does what the command line says, prints what there is to say, and returns the exit code.
pub fn main() -> ExitCode {
    ExitCode::from(run())
}

/// The same for a program that this one is a part of, such as Python's interpreter: `path` is an executable file that starts it, `words` are
/// those of the command line, the program's name first.
pub fn main_within(path: PathBuf, words: Vec<OsString>) -> u8 {
    program::called_by(path, words);
    run()
}

fn run() -> u8 {
    ending::prepare();
    device::quiet_drivers();
    let (output, command) = match cli::Cli::typed() {
        Ok(typed) => typed,
        Err(error) => return cli::show(&error),
    };
    let console = console::Console::new(output);
    let code = ending::code_of(console, || command.and_then(|command| commands::run(command, console)));
    ending::end(code, oneiro::background::settle)
}
