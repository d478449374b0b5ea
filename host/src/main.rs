//! `oneiro`: evolves robot controllers, and evaluates, replays, audits and measures them.

use std::process::ExitCode;

fn main() -> ExitCode {
    oneiro_host::main()
}
