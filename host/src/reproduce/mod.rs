//! Whole studies of papers, from one command to a report.

#[cfg_attr(not(test), expect(dead_code, reason = "the study's command is what will call it"))]
pub(crate) mod miglino1995;
