//! Output for readers: pages, figures, tables, numbers and CSV files. It does not depend on studies, sweeps or runs.

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

pub mod bundle;
pub mod csv;
pub mod figures;
pub mod numbers;
pub mod page;
#[cfg(feature = "film")]
pub mod raster;

#[cfg(any(test, feature = "testing"))]
#[cfg_attr(
    not(test),
    allow(clippy::disallowed_methods, clippy::print_stderr, reason = "for tests")
)]
#[path = "../../../tests/skips/mod.rs"]
mod skips;
