//! What a test can't do here, since something is not there that not every machine has: said, and kept for the summary
//! of `tests/all.sh`, which fails unless `ONEIRO_MAY_SKIP` names it.

use std::io::Write;
use std::{env, fs};

/// Says that a part of the calling test is skipped: what is missing, by the word that `ONEIRO_MAY_SKIP` has for it, and
/// what is not tested without it.
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
