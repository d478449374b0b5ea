//! The engine: jobs of all kinds share the devices.
//!
//! | file | content |
//! |---|---|
//! | [`job`] | what a job is, and what it exchanges with the engine |

pub(crate) mod job;
