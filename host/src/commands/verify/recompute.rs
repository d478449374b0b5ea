//! `oneiro verify --recompute`: evaluates recorded individuals again on this machine and compares the bits.

use std::path::PathBuf;

use oneiro_base::console::Console;
use oneiro_base::exit::{Code, Failure, Result};
use oneiro_lab::device;
use oneiro_lab::record::{self, SavedRun};
use serde_json::json;

use crate::cli::Verify;

/// Checks the files of finished runs, and recomputes a fraction of the individuals of all; fails if anything differs. What is damaged
/// is recomputed too, which tells where.
pub(super) fn run(arguments: &Verify, directories: &[PathBuf], console: Console) -> Result {
    let engine = arguments.backend.engine()?;
    let mut values = Vec::new();
    let mut problems = Vec::new();
    let mut damaged = false;
    for directory in directories {
        let run = SavedRun::open(directory)?;
        let recorded = run.recorded()?;
        let mut result = None;
        if recorded.is_done {
            match record::verify(directory) {
                Ok(done) => result = Some(done.result),
                Err(failure) if failure.code() == Code::Corrupt as u8 => {
                    damaged = true;
                    problems.push(failure.to_string());
                }
                Err(failure) => return Err(failure),
            }
        }
        let audit = run
            .experiment()
            .audit(&recorded, arguments.fraction, &engine, console.bars())?;
        if let Some(result) = &result {
            console.print_text(format!("{}  {}", console.hash(result), directory.display()))?;
        }
        console.print_text(audit.answer.text)?;
        let mut value = audit.answer.value;
        value["result"] = result.into();
        values.push(value);
        let problem = audit.problem;
        problems.extend(problem.map(|problem| format!("{}: {problem}", directory.display())));
    }
    let device = engine.name();
    device::close(engine, console);
    console.print_json(&json!({ "device": device, "runs": values }))?;
    match (problems.is_empty(), damaged) {
        (true, _) => Ok(()),
        (false, true) => Err(Failure::corrupt(problems.join("; "))),
        (false, false) => Err(Failure::failed(problems.join("; "))),
    }
}
