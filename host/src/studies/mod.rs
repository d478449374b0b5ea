//! Whole studies of papers, from one command to a report. Experiments and claims stand in files under `experiments`;
//! only the arithmetic of judging is here.

pub(crate) mod assumptions;
pub(crate) mod claims;
mod directory;
pub(crate) mod file;
pub(crate) mod miglino1995;
pub(crate) mod odowd2014;
mod verdicts;

/// The claims of the papers.
const MIGLINO1995_CLAIMS: &str = include_str!("../../../experiments/miglino1995/claims.toml");
const ODOWD2014_CLAIMS: &str = include_str!("../../../experiments/odowd2014/claims.toml");
