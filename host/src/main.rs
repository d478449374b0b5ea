//! `oneiro`: evolves robot controllers, and evaluates, replays, audits and measures them.

use std::process::ExitCode;

#[cfg(all(no_unwinding, panic = "unwind"))]
compile_error!(
    "the profile `robot` leaves out the tables for unwinding (no-unwinding.ld), so that its panics have to abort"
);

#[global_allocator]
static ALLOCATOR: oneiro_host::Allocator = oneiro_host::ALLOCATOR;

fn main() -> ExitCode {
    oneiro_host::main()
}
