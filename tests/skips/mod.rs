//! Reports tests that can't run here because something is missing that not every machine has. The summary of
//! `tests/all.sh` fails unless `ONEIRO_MAY_SKIP` names it.

use std::io::Write;
use std::{env, fs};

/// Reports that a part of the calling test is skipped: the missing thing, by its word in `ONEIRO_MAY_SKIP`, and what
/// remains untested without it.
#[track_caller]
pub(crate) fn skipped(missing: &str, untested: &str) {
    let file = std::panic::Location::caller().file();
    let line = format!("{missing}: {untested} ({file})\n");
    eprint!("skipped for want of {line}");
    if let Some(summary) = env::var_os("ONEIRO_SKIPPED") {
        let mut summary = fs::OpenOptions::new()
            .create(true)
            .append(true)
            .open(summary)
            .expect("a file to add to");
        summary.write_all(line.as_bytes()).expect("a line is added");
    }
}
