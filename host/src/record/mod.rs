//! A run's directory: what is in it, how it gets there, and how it is read again. [`contents`] lists what is there of every
//! run; besides it has the tables and the results of its kind of experiment, see [`crate::runs`].

mod directories;
mod done;
mod meta;
mod recorder;
mod saved;
mod single;
#[cfg(test)]
mod tests;

pub(crate) use directories::{Directories, RunPlace};
pub(crate) use done::{Done, result_of, verify};
pub(crate) use meta::{Meta, Session, Status};
pub(crate) use recorder::{Recorder, Standing, standing};
pub(crate) use saved::{SavedRun, State, is_locked, is_run};
pub(crate) use single::SingleRun;

use crate::contents::Entry;
use crate::disk::LOCK;
use crate::experiment::INPUTS;
use crate::files::directory::Form;

/// A run's directory: with its configuration it is a run, and can be resumed.
pub(crate) const FORM: Form<'_> = Form {
    mark: CONFIG,
    before: &[INPUTS],
    option: "--out",
};

const CONFIG: &str = "config.toml";
const META: &str = "meta.json";
const DONE: &str = "DONE";

/// The files of a run's directory: those of its kind, among those that every run has.
pub(crate) fn contents(own: Vec<Entry>, has_inputs: bool) -> Vec<Entry> {
    let config = "the complete experiment: every value written out, and the seed";
    let mut all = vec![Entry::file(CONFIG, config)];
    if has_inputs {
        all.push(Entry::file(
            format!("{INPUTS}/"),
            "copies of the files that the experiment names",
        ));
    }
    all.extend(own);
    let meta = "provenance, not part of the results: program, devices, times, status, progress, and the best so far";
    let done =
        "written last, when the run is finished: BLAKE3 hashes of each file, of the experiment and of the results";
    all.extend([
        Entry::file(META, meta),
        Entry::file(
            "checkpoint-N",
            "the two newest checkpoints, from which `oneiro resume` continues; N is the generation, or the minute of a swarm",
        ),
        Entry::file(LOCK, "locked by the process that is writing"),
        Entry::file(DONE, done),
    ]);
    all
}
