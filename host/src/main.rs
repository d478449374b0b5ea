//! `oneiro`: evolves robot controllers, and evaluates, replays, audits and measures them.

use std::process::ExitCode;

#[cfg(all(no_unwinding, panic = "unwind"))]
compile_error!(
    "the profile `robot` leaves out the tables for unwinding (no-unwinding.ld), so that its panics have to abort"
);

/// One thread creates a sweep's jobs, and others continue them. With the system's allocator, threads that free or grow memory of other
/// threads wait for each other: sweeps of many short runs took a third longer.
#[cfg(feature = "mimalloc")]
type Allocator = mimalloc::MiMalloc;
#[cfg(feature = "mimalloc")]
const MEMORY: Allocator = mimalloc::MiMalloc;
#[cfg(not(feature = "mimalloc"))]
type Allocator = std::alloc::System;
#[cfg(not(feature = "mimalloc"))]
const MEMORY: Allocator = std::alloc::System;

#[global_allocator]
static ALLOCATOR: oneiro_host::Ending<Allocator> = oneiro_host::Ending(MEMORY);

fn main() -> ExitCode {
    oneiro_host::main()
}
