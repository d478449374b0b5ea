//! `oneiro watch`: a page about runs, sweeps and fleets, read from what they write.
//!
//! A separate process that writes nothing, so results can't depend on it. It simulates episodes again from the genomes that runs record:
//! the same seed also gives the same bits here.
//!
//! | file | content |
//! |---|---|
//! | `sources` | the directories, and what is known of each |
//! | `curve` | a table of generations while it grows, in bounded memory |
//! | `sweeps` | a sweep's cells |
//! | `scenes` | episodes of the newest best |
//! | `edit` | an experiment that the page may change and run |
//! | `request` | what a browser may ask for, and who may ask |
//! | `server` | connections |
//! | `pages` | the page's parts |
//! | `view` | the page without a server |

// Only this workspace uses it.
#![allow(
    missing_docs,
    clippy::missing_errors_doc,
    clippy::missing_panics_doc,
    reason = "items whose names do not say everything are documented"
)]
// `clippy.toml` says what has one place only.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

mod curve;
mod edit;
mod pages;
mod request;
mod scenes;
mod server;
mod sources;
mod sweeps;
mod view;

pub use server::Server;
pub use view::{View, snapshot};
