//! A run's directory: what is in it, how it gets there, and how it is read again. Besides what follows it has the tables
//! and the results of its kind of experiment, see [`crate::runs`].
//!
//! | file | content |
//! |---|---|
//! | `config.toml` | the experiment with every default written out, and the seed |
//! | `inputs/` | copies of the files that the experiment names |
//! | `checkpoint-N` | the two newest, see [`crate::engine::checkpoint`] |
//! | `meta.json` | what is no result: program, device, times, status, see [`Meta`] |
//! | `lock` | held by the one process that writes |
//! | `DONE` | written last: the files' hashes and the result's, see [`Done`] |

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
pub(crate) use meta::{Meta, Session, Status, now};
pub(crate) use recorder::{Recorder, Standing, standing, try_lock};
pub(crate) use saved::{SavedRun, State, is_locked, is_run};
pub(crate) use single::SingleRun;

const CONFIG: &str = "config.toml";
const META: &str = "meta.json";
const LOCK: &str = "lock";
const DONE: &str = "DONE";
