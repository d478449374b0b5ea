//! `oneiro replay`: evaluates a finished run's best again.

use oneiro_base::console::Console;
use oneiro_base::exit::{Failure, Result};
use oneiro_lab::device;
use oneiro_lab::experiment::GREATEST_SEED;
use oneiro_lab::reality::site::Robots;
use oneiro_lab::record::SavedRun;
use oneiro_lab::runs::Replay;

use super::list;
use super::places::{RUNS, named_or_newest, typed};
use crate::cli;

/// Evaluates the best again, compares it with the record, and draws it.
pub(crate) fn run(arguments: &cli::Replay, console: Console) -> Result {
    let surrogate = arguments.robot.as_deref().map(surrogate).transpose()?;
    let named = named_or_newest(arguments.run_dir.as_deref(), &[RUNS], console)?;
    let run = SavedRun::open(&list::one(&named)?)?;
    let recorded = run.finished()?;
    let replay = Replay {
        out: arguments.out.as_deref().unwrap_or(run.directory()),
        trial: arguments.trial,
        every: arguments.every,
        start: arguments.start,
        seed: arguments.seed,
        test: arguments.test,
        elite: arguments.elite,
        elites: arguments.elites,
        generation: arguments.generation,
        individual: arguments.individual,
        generations: &arguments.generations,
        genome: arguments.genome.as_deref(),
        picture: arguments.picture.as_deref(),
        at: arguments.at,
        film: arguments.film.as_deref(),
        speed: arguments.speed,
        surrogate: surrogate.map(|seed| (seed, arguments.severity)),
    };
    let engine = arguments.backend.engine()?;
    let answer = run.experiment().replay(&recorded, &replay, &engine, console.bars())?;
    console.print_answer(&answer)?;
    device::close(engine, console);
    let name = typed(run.directory());
    console.next(match run.experiment().single() {
        Some(single) if single.settings().evolution.is_coevolution() => {
            format!("oneiro evaluate --tournament --genomes {name}")
        }
        Some(_) => format!(
            "oneiro evaluate --genomes {name} --trials 100 --seed {} --summary",
            seed_of_others(run.seed())
        ),
        None => format!("oneiro verify {name} --recompute"),
    });
    Ok(())
}

/// The seed of a surrogate by its address.
fn surrogate(address: &str) -> Result<u64> {
    match Robots::at(&[address.to_owned()]) {
        Ok(Robots::Surrogate(seed)) => Ok(seed),
        Ok(Robots::Wired(_)) => Err(Failure::input(format_args!(
            "--robot {address}: is a connected robot; allowed: a surrogate, such as surrogate:1"
        ))),
        Err(problem) => Err(Failure::input(format_args!("--robot: {problem}"))),
    }
}

/// A seed that a run has not seen.
pub(super) fn seed_of_others(seed: u64) -> u64 {
    if seed == GREATEST_SEED { seed - 1 } else { seed + 1 }
}
