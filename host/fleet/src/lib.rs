//! Fleets of robots: what the operator does, the daemon on each robot, and a twin of all of it on a virtual clock.

// Only this workspace uses it.
#![allow(
    missing_docs,
    clippy::missing_errors_doc,
    clippy::missing_panics_doc,
    clippy::return_self_not_must_use,
    rustdoc::private_intra_doc_links,
    reason = "items whose names do not say everything are documented"
)]
// `clippy.toml` says what has one place only.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

pub mod daemon;
pub mod fleet;
#[cfg(test)]
#[path = "../../../tests/skips/mod.rs"]
mod skips;
