//! `oneiro replay`: a finished run's best again.

use crate::cli::Replay;
use crate::console::Console;
use crate::exit::Result;
use crate::record::SavedRun;

/// Evaluates it again, compares it with what was recorded, and draws it.
pub(crate) fn run(arguments: &Replay, console: Console) -> Result {
    let run = SavedRun::open(&arguments.run_dir)?;
    run.experiment().replay(&run.finished()?, arguments, console)
}
