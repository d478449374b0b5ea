//! `oneiro reproduce`: a paper's whole study.

use oneiro_base::console::Console;
use oneiro_base::exit::Result;
use oneiro_studies::{miglino1995, odowd2014};

use crate::cli::{Paper, Reproduce};

/// Runs the requested study.
pub(crate) fn run(arguments: &Reproduce, console: Console) -> Result {
    match &arguments.study {
        Paper::Miglino1995(arguments) => miglino1995::run(arguments, console),
        Paper::Odowd2014(arguments) => odowd2014::run(arguments, console),
    }
}
