//! `oneiro`: evolves robot controllers, and evaluates, replays, audits and measures them.

use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: oneiro_host::Allocator = oneiro_host::ALLOCATOR;

fn main() -> ExitCode {
    oneiro_host::main()
}
