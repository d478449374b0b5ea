//! Whole studies of papers, from one command to a report.

pub(crate) mod miglino1995;
