//! `oneiro check`: validates and summarises an experiment, counts what its cycles cost, or explains a rule that its parts keep.

use oneiro_base::console::Console;
use oneiro_base::exit::Result;
use oneiro_base::files;
use oneiro_lab::runs;

use super::{cost, rules};
use crate::cli::{ALL_RULES, Check};

/// Reads the experiment and prints a summary; without one, explains a rule.
pub(crate) fn run(arguments: &Check, console: Console) -> Result {
    let Some(experiment) = &arguments.experiment else {
        return console.print_answer(&rules::explain(arguments.explain.as_deref().unwrap_or(ALL_RULES))?);
    };
    if let Some(out) = &arguments.out {
        files::must_be_svg("--out", out)?;
    }
    let experiment = runs::read(experiment, &arguments.set)?;
    console.warn(experiment.warnings());
    if arguments.lives > 0 {
        console.say(experiment.check_lives(arguments.lives)?);
    }
    if arguments.cost {
        return console.print_answer(&cost::answer(&experiment.sample()?, console.bars())?);
    }
    console.print_answer(&experiment.check(arguments.out.as_deref())?)
}
