//! `oneiro check`: an experiment validated and summarised.

use crate::cli::Check;
use crate::console::Console;
use crate::exit::Result;
use crate::runs;

/// Reads the experiment, and prints what it amounts to.
pub(crate) fn run(arguments: &Check, console: Console) -> Result {
    let experiment = runs::read(&arguments.experiment, &arguments.set)?;
    for warning in experiment.warnings() {
        console.say(format!("warning: {warning}"));
    }
    experiment.check(arguments.out.as_deref(), console)
}
