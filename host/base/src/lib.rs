//! What all other crates of the program use: exit codes, messages, files that survive a power cut, tables and their documentation.

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

pub mod answer;
pub mod columns;
pub mod console;
pub mod contents;
pub mod disk;
pub mod ending;
pub mod exit;
pub mod files;
pub mod npy;
pub mod plain;
pub mod program;
#[cfg_attr(target_family = "wasm", path = "progress/absent.rs")]
pub mod progress;
pub mod sealed;
pub mod utc;
