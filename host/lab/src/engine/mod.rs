//! The engine: jobs of all kinds share the devices. It doesn't depend on any kind of job.
//!
//! | file | contents |
//! |---|---|
//! | [`job`] | jobs, and their exchange with the engine |
//! | [`scheduler`] | the loop: which jobs share a batch, and when they take their steps |
//! | [`handle`] | the engine's interface: an evaluator on a separate thread, or on the loop's for short batches |
//! | [`queue`] | batches on their way to the device and back |
//! | [`watcher`] | shows the progress of jobs, and stops them |
//! | [`checkpoint`] | saved jobs |
//! | [`log`] | append-only files |

pub(crate) mod checkpoint;
pub mod handle;
pub mod job;
pub(crate) mod log;
pub(crate) mod queue;
pub mod scheduler;
pub mod watcher;
