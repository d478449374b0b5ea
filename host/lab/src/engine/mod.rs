//! The engine: jobs of all kinds share the devices. It doesn't depend on any kind of job.
//!
//! | file | contents |
//! |---|---|
//! | [`job`] | jobs, and their exchange with the engine |
//! | [`scheduler`] | the loop: which jobs share a batch, and when they take their steps |
//! | [`handle`] | the engine's interface: an evaluator on a separate thread, or on the loop's for short batches |
//! | [`queue`] | batches on their way to the device and back |
//! | [`watcher`] | shows the progress of jobs, and stops them |
//! | [`signals`] | signals that stop the work |
//! | [`alone`] | the requests of one job, without threads |
//! | [`checkpoint`] | saved jobs |
//! | [`log`] | append-only files |

pub(crate) mod alone;
pub(crate) mod checkpoint;
pub mod handle;
pub mod job;
pub(crate) mod log;
pub(crate) mod queue;
pub mod scheduler;
#[cfg_attr(target_family = "wasm", path = "signals/absent.rs")]
pub mod signals;
pub mod watcher;
