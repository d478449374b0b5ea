//! The engine: jobs of all kinds share the devices. It knows no kind of job by name.
//!
//! | file | content |
//! |---|---|
//! | [`job`] | what a job is, and what it exchanges with the engine |
//! | [`scheduler`] | the loop: which jobs share a batch, and when they take their steps |
//! | [`handle`] | the engine for those who use it: an evaluator on a thread of its own |
//! | [`queue`] | batches on their way to the device and back |
//! | [`watcher`] | what shows how far jobs are, and stops them |
//! | [`checkpoint`] | jobs as they are saved |
//! | [`disk`], [`log`] | files that a power cut can't tear; files that only grow |

pub(crate) mod checkpoint;
pub(crate) mod disk;
pub(crate) mod handle;
pub(crate) mod job;
pub(crate) mod log;
mod queue;
pub(crate) mod scheduler;
pub(crate) mod watcher;
