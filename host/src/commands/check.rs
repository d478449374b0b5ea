//! `oneiro check`: validates and summarises an experiment.

use crate::cli::Check;
use crate::console::Console;
use crate::exit::Result;
use crate::runs;

/// Reads the experiment and prints a summary.
pub(crate) fn run(arguments: &Check, console: Console) -> Result {
    let experiment = runs::read(&arguments.experiment, &arguments.set)?;
    for warning in experiment.warnings() {
        console.say(format!("warning: {warning}"));
    }
    experiment.check(arguments.out.as_deref(), console)
}
