//! `oneiro verify`: checks that a run's files are as they were written, and prints the hash of its results.

use serde_json::json;

use super::list;
use crate::cli::Verify;
use crate::console::{Console, counted};
use crate::exit::Result;
use crate::record;

/// Checks a run, or each run of a directory. Stops at the first damaged one.
pub(crate) fn run(arguments: &Verify, console: Console) -> Result {
    let mut verified = Vec::new();
    for directory in list::runs(&arguments.run_dir)? {
        let done = record::verify(&directory)?;
        if !console.json() {
            console.data(format!("{}  {}", done.result, directory.display()))?;
        }
        verified.push(json!({
            "directory": directory.display().to_string(),
            "result": done.result,
            "experiment": done.experiment,
            "files": done.files.len(),
        }));
    }
    if console.json() {
        console.json_data(&verified)?;
    }
    console.say(format!(
        "{} intact",
        counted(verified.len() as u32, "run is", "runs are")
    ));
    Ok(())
}
