//! `oneiro`: evolves robot controllers, and evaluates, replays, audits and measures them.

use std::process::ExitCode;

#[cfg(all(no_unwinding, panic = "unwind"))]
compile_error!(
    "the profile `robot` leaves out the tables for unwinding (no-unwinding.ld), so that its panics have to abort"
);

/// Jobs of a sweep are made by one thread and go on in others. With the system's allocator, threads that free and grow what others
/// have allocated wait for each other: sweeps of many short runs took a third longer.
#[cfg(feature = "mimalloc")]
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    oneiro_host::main()
}
