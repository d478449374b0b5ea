//! `oneiro guard`: a separate process that owns a robot's link, for a program that drives.

use oneiro_base::exit::{Failure, Result};
use oneiro_robots::guard::process::{self, Options};
use oneiro_robots::guard::values::Values;
use oneiro_robots::guard::wheels::Wanted;

use super::robot;
use crate::cli::GuardProcess;

/// Guards a robot until the program at the other end of standard input is gone, or a signal comes.
pub(crate) fn run(arguments: GuardProcess) -> Result {
    let code = match options(arguments) {
        Ok(options) => process::run(options)
            .map_err(|error| Failure::failed(format_args!("the guard can't listen for signals: {error}")))?,
        Err(refusal) => process::refuse(&refusal),
    };
    // Whatever went wrong has been reported, and a thread may still wait for the link.
    std::process::exit(code.into())
}

fn options(GuardProcess { guard, odometry }: GuardProcess) -> Result<Options> {
    Ok(Options {
        wire: robot::wire(&guard.link.address)?,
        values: Values::of(&guard.values).map_err(Failure::input)?,
        recording: guard.link.record.as_deref().map(robot::recording).transpose()?,
        wanted: Wanted {
            kinds: guard.kinds,
            odometry,
        },
    })
}
