//! Whole studies of papers, from one command to a report. Experiments and claims stand in files under `experiments`;
//! only the arithmetic of judging is here.

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

use std::collections::BTreeMap;

use claims::Claim;
use serde::Serialize;
use serde_json::{Map, Value};

pub(crate) mod assumptions;
mod claims;
mod contrasts;
mod directory;
pub mod file;
pub mod miglino1995;
pub mod odowd2014;
mod sweep_results;
mod verdict;
mod verdicts;

pub use directory::Request;

/// What a study answers.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum Findings {
    /// The verdicts on its claims.
    Claims(Vec<Claim>),
    /// Tables by the names of their files, without `.csv`.
    Tables(BTreeMap<String, Vec<Row>>),
}

/// A row of a table by its columns, with numbers where they are finite.
type Row = Map<String, Value>;

/// The files of any directory of the 1995 study and of the 2014 study, and of their second editions.
#[cfg(any(test, feature = "testing"))]
pub fn all_contents() -> [Vec<oneiro_base::contents::Entry>; 4] {
    let of = |entries| directory::contents(entries, true);
    let [of_1995, of_2014] = [miglino1995::contents(true, true, true), odowd2014::contents(true)].map(of);
    [
        of_1995,
        miglino1995::contents_of_second(),
        of_2014,
        odowd2014::contents_of_second(),
    ]
}

/// The claims of the papers.
const MIGLINO1995_CLAIMS: &str = oneiro_experiments::MIGLINO1995.claims;
const ODOWD2014_CLAIMS: &str = oneiro_experiments::ODOWD2014.claims;

#[cfg(test)]
#[allow(dead_code, reason = "other tests use the rest")]
#[path = "../../../tests/scratch/mod.rs"]
mod scratch;
