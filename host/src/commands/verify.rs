//! `oneiro verify`: checks that the files of a run, or the tables of a sweep, are as they were written, and prints the hash of the
//! results; and compares them with those of this machine.

use std::path::{Path, PathBuf};

use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, counted};
use oneiro_base::exit::Result;
use oneiro_lab::experiment::kinds::is_sweep;
use oneiro_lab::record;
use oneiro_lab::sweep::tables::{self, Sums};
use serde_json::json;

use super::list;
use super::places::{RUNS, SWEEPS, named_or_newest, typed};
use crate::cli::Verify;

mod recompute;

/// Checks a run, or each run of a directory. Stops at the first damaged one.
pub(crate) fn run(arguments: &Verify, console: Console) -> Result {
    let named = named_or_newest(arguments.run_dir.as_deref(), &[RUNS, SWEEPS], console)?;
    let name = typed(&named);
    if arguments.recompute {
        let runs = list::runs(&named)?;
        recompute::run(arguments, &runs, console)?;
        console.next(match &runs[..] {
            [run] if *run == named => format!("oneiro replay {name}"),
            _ => format!("oneiro list {name}"),
        });
        return Ok(());
    }
    if is_sweep(&named) {
        sweep(&named, console)?;
        console.next(format_args!("oneiro sweep report {name}"));
        return Ok(());
    }
    let mut verified = Vec::new();
    let runs = list::runs(&named)?;
    for directory in &runs {
        let done = record::verify(directory)?;
        console.print_text(format!("{}  {}", console.hash(&done.result), directory.display()))?;
        verified.push(json!({
            "directory": directory.display().to_string(),
            "result": done.result,
            "experiment": done.experiment,
            "files": done.files.len(),
        }));
    }
    console.print_json(&verified)?;
    console.say(format!("{} intact", counted(verified.len(), "run is", "runs are")));
    // It needs each individual, which a race doesn't record.
    let has_all = |directory: &PathBuf| {
        let run = record::SavedRun::open(directory);
        run.is_ok_and(|run| {
            run.experiment()
                .single()
                .is_none_or(|own| own.settings().record.individuals)
        })
    };
    let command = if runs.iter().all(has_all) {
        format!("verify {name} --recompute")
    } else {
        format!("evaluate --best --genomes {name} --trials 100")
    };
    console.next(format_args!("oneiro {command}"));
    Ok(())
}

/// Checks the tables of a sweep.
fn sweep(directory: &Path, console: Console) -> Result {
    let Sums { hash, files } = tables::verify(directory)?;
    console.print_answer(&Answer::new(
        format!("{}  {}", console.hash(&hash), directory.display()),
        json!([{
            "directory": directory.display().to_string(),
            "result": hash,
            "files": files.len(),
        }]),
    ))?;
    console.say(format!("{} intact", counted(files.len(), "table is", "tables are")));
    Ok(())
}
