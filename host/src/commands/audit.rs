//! `oneiro audit`: evaluates a share of recorded individuals again on this machine and compares them bit for bit.

use oneiro_base::console::Console;
use oneiro_base::exit::{Failure, Result};
use oneiro_lab::device;
use oneiro_lab::record::SavedRun;
use serde_json::json;

use super::list;
use crate::cli::Audit;

/// Audits a run, or each run of a directory; fails if a single bit differs.
pub(crate) fn run(arguments: &Audit, console: Console) -> Result {
    let directories = list::runs(&arguments.run_dir)?;
    let engine = device::engine(&arguments.backend)?;
    let mut values = Vec::new();
    let mut problems = Vec::new();
    for directory in directories {
        let run = SavedRun::open(&directory)?;
        let audit = run
            .experiment()
            .audit(&run.recorded()?, arguments.share, &engine, console)?;
        if !console.json() {
            console.data(audit.text)?;
        }
        values.push(audit.value);
        let problem = audit.problem;
        problems.extend(problem.map(|problem| format!("{}: {problem}", directory.display())));
    }
    let device = engine.name();
    device::close(engine, console);
    if console.json() {
        console.json_data(&json!({ "device": device, "runs": values }))?;
    }
    if problems.is_empty() {
        return Ok(());
    }
    Err(Failure::failed(problems.join("; ")))
}
