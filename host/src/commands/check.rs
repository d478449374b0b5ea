//! `oneiro check`: validates and summarises an experiment, counts what its cycles cost, or explains a rule that its parts keep.

use oneiro_base::console::Console;
use oneiro_base::exit::Result;
use oneiro_base::files;
use oneiro_base::progress::meanwhile;
use oneiro_lab::runs::{self, Experiment};
use oneiro_lab::sweep::estimate::{Devices, Estimate, Timed, estimates, fastest};

use super::places::settings_typed;
use super::sweep::time;
use super::{cost, rules};
use crate::cli::{ALL_RULES, Check};

/// Reads the experiment and prints a summary; without one, explains a rule.
pub(crate) fn run(arguments: &Check, console: Console) -> Result {
    let Some(path) = &arguments.experiment else {
        return console.print_answer(&rules::explain(arguments.explain.as_deref().unwrap_or(ALL_RULES))?);
    };
    if let Some(out) = &arguments.out {
        files::must_be_svg("--out", out)?;
    }
    let experiment = meanwhile("reading the experiment", console.bars(), || {
        runs::read(path, &arguments.set)
    })?;
    console.warn(experiment.warnings());
    if arguments.episodes > 0 {
        let checked = meanwhile("checking numbers", console.bars(), || {
            experiment.check_lives(arguments.episodes)
        });
        console.say(checked?);
    }
    if arguments.cost {
        console.print_answer(&cost::answer(&experiment.sample()?, console.bars())?)?;
    } else {
        console.print_answer(&experiment.check(arguments.out.as_deref())?)?;
        say_how_long(&*experiment, console)?;
    }
    let path = files::for_shell(&path.display().to_string());
    let set = settings_typed(&arguments.set);
    console.next(match experiment.seed() {
        Some(_) => format!("oneiro run {path}{set}"),
        None => format!("oneiro run {path}{set} --seed 1"),
    });
    Ok(())
}

/// Says how long a run takes on this machine. It is timed on GPUs only if it takes long without one.
fn say_how_long(experiment: &dyn Experiment, console: Console) -> Result {
    /// Seconds.
    const LONG: f64 = 20.0;
    if console.quiet() {
        return Ok(());
    }
    if let Some(time) = experiment.robot_time() {
        console.say(format!("on robots: {time}"));
        return Ok(());
    }
    let work = Timed::of(experiment, 1)?;
    // Without a device the experiment is still valid.
    let timed = |devices| estimates(&work, &[devices], None, console.bars()).unwrap_or_default();
    let mut all = timed(Devices::Cpu);
    if fastest(&all).is_none_or(|own| own.seconds > LONG) {
        all.extend(timed(Devices::Gpus));
    }
    if let Some(Estimate { seconds, name, .. }) = fastest(&all) {
        let device = name.split_once(", ").map_or(&**name, |(_, device)| device);
        console.say(format!("a run takes about {} here on {device}", time(*seconds)));
    }
    Ok(())
}
