//! `oneiro`: evolves robot controllers, and evaluates, replays, audits and measures them.

use std::process::ExitCode;

#[cfg(all(no_unwinding, panic = "unwind"))]
compile_error!(
    "the profile `robot` leaves out the tables for unwinding (no-unwinding.ld), so that its panics have to abort"
);

/// One thread creates a sweep's jobs, and others continue them. With the system's allocator, threads that free or grow memory of other
/// threads wait for each other: sweeps of many short runs took a third longer.
#[cfg(feature = "mimalloc")]
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> ExitCode {
    oneiro_host::main()
}
