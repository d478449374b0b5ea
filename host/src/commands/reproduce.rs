//! `oneiro reproduce`: a paper's whole study.

use oneiro_base::console::Console;
use oneiro_base::exit::Result;
use oneiro_studies::{Findings, miglino1995, odowd2014};

use crate::cli::{Paper, Reproduce};

/// Runs the requested study.
pub(crate) fn run(arguments: &Reproduce, console: Console) -> Result {
    let found = match &arguments.study {
        Paper::Miglino1995(arguments) => miglino1995::run(arguments, console),
        Paper::Odowd2014(arguments) => odowd2014::run(arguments, console),
    };
    match found? {
        Findings::Claims(answer) => console.print_answer(&answer),
        Findings::Table(text) => console.print_plain(text),
    }
}
