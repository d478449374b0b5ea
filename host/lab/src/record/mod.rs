//! A run's directory: its contents, how they are written, and how they are read again. [`contents`] lists the files of every run;
//! each kind of experiment adds its tables and results, see [`crate::runs`].

mod directories;
mod done;
mod extend;
mod memory;
mod meta;
mod recorder;
mod saved;
mod single;
#[cfg(test)]
mod tests;

pub use directories::{Directories, RunPlace};
pub(crate) use done::result_of;
pub use done::{Done, verify};
pub use extend::{Budget, Extension, complete};
pub use memory::{Finished, InMemory};
pub use meta::{Meta, Session, Status};
pub use recorder::{Begun, Recorder, Standing, named, standing};
pub use saved::{SavedRun, State, is_locked};
pub use single::SingleRun;

use crate::experiment::INPUTS;
use crate::experiment::kinds::{CONFIG, DONE};
use oneiro_base::contents::Entry;
use oneiro_base::disk::LOCK;
use oneiro_base::files::directory::Form;

/// A run's directory: with its configuration it is a run, and can be resumed.
pub const FORM: Form<'_> = Form {
    mark: CONFIG,
    before: &[INPUTS],
    option: "--out",
};

const META: &str = "meta.json";

/// The files of a run's directory: those of its kind, among those that every run has.
pub fn contents(own: Vec<Entry>, has_inputs: bool) -> Vec<Entry> {
    let config = "the complete experiment: every value written out, and the seed";
    let mut all = vec![Entry::file(CONFIG, config)];
    if has_inputs {
        all.push(Entry::file(
            format!("{INPUTS}/"),
            "copies of the files that the experiment names",
        ));
    }
    all.extend(own);
    let meta = "provenance, not part of the results: program, devices, times, status, progress, the best so far, origins of files, and extensions";
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
