//! Experiments, runs, sweeps, calibrations, episodes in reality, and the foraging study of 2014.

// Only this workspace uses it.
#![allow(
    missing_docs,
    clippy::missing_errors_doc,
    clippy::missing_panics_doc,
    clippy::return_self_not_must_use,
    rustdoc::private_intra_doc_links,
    reason = "items whose names do not say everything are documented"
)]
// `clippy.toml` lists functions that only one place may call.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

pub mod calibrate;
pub mod compare;
pub mod device;
pub mod engine;
pub mod exchange;
pub mod experiment;
#[cfg(feature = "compose")]
pub mod exported;
pub mod genomes;
pub mod import;
pub mod lives;
#[cfg(test)]
#[allow(dead_code, reason = "other tests use the rest")]
#[path = "../../../tests/mutations/mod.rs"]
mod mutations;
mod pixels;
pub mod reality;
pub mod record;
pub mod runs;
#[cfg(test)]
#[path = "../../../tests/scratch/mod.rs"]
mod scratch;
pub mod swarm;
pub mod sweep;
mod threads;
pub mod workload;

/// What of a world can be printed with an exported controller.
pub const OF_WORLD: [&str; 2] = ["sensors", "task"];
