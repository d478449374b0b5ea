//! `oneiro replay`: evaluates a finished run's best again.

use oneiro_base::console::Console;
use oneiro_base::exit::Result;
use oneiro_lab::device;
use oneiro_lab::record::SavedRun;
use oneiro_lab::runs::Replay;

use super::list;
use crate::cli;

/// Evaluates the best again, compares it with the record, and draws it.
pub(crate) fn run(arguments: &cli::Replay, console: Console) -> Result {
    let run = SavedRun::open(&list::one(&arguments.run_dir)?)?;
    let recorded = run.finished()?;
    let replay = Replay {
        out: arguments.out.as_deref().unwrap_or(run.directory()),
        trial: arguments.trial,
        every: arguments.every,
        start: arguments.start,
        seed: arguments.seed,
        elite: arguments.elite,
        elites: arguments.elites,
        genome: arguments.genome.as_deref(),
    };
    let engine = arguments.backend.engine()?;
    let answer = run.experiment().replay(&recorded, &replay, &engine, console.bars())?;
    console.print_answer(&answer)?;
    device::close(engine, console);
    Ok(())
}
