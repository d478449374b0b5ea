//! Whole studies of papers, from one command to a report.

pub(crate) mod assumptions;
pub(crate) mod claims;
mod directory;
pub(crate) mod miglino1995;
pub(crate) mod odowd2014;
mod verdicts;
