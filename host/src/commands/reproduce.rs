//! `oneiro reproduce`: a paper's whole study.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, columns};
use oneiro_base::exit::Result;
use oneiro_lab::reality::site;
use oneiro_studies::file::{Edition, MIGLINO1995, ODOWD2014, Shipped, StudyFile};
use oneiro_studies::{Findings, Request, miglino1995, odowd2014};
use serde_json::json;

use super::places::{SWEEPS, found};
use crate::cli::{ALL_ARMS, Miglino1995, Odowd2014, Paper, Reproduce};

/// Runs the requested study.
pub(crate) fn run(arguments: &Reproduce, console: Console) -> Result {
    let found = match &arguments.study {
        Paper::Miglino1995(arguments) => of_1995(arguments, console),
        Paper::Odowd2014(arguments) => of_2014(arguments, console),
    };
    console.print_answer(&found?)
}

/// The directories of sweeps that are named.
fn sweeps(named: &[PathBuf], console: Console) -> Result<Vec<PathBuf>> {
    named.iter().map(|sweep| found(sweep, &[SWEEPS], console)).collect()
}

fn of_1995(arguments: &Miglino1995, console: Console) -> Result<Answer<Findings>> {
    let (file, out) = (arguments.study.as_deref(), arguments.out.as_deref());
    let backend = &arguments.backend.resolve();
    if arguments.arm == ALL_ARMS {
        return arms(&MIGLINO1995, file, arguments.edition);
    }
    if !arguments.sweeps.is_empty() {
        return miglino1995::judge_sweeps(&sweeps(&arguments.sweeps, console)?, out);
    }
    if arguments.calibrate {
        return miglino1995::calibrate(file, arguments.seed, backend, console);
    }
    let asked = miglino1995::settings::Asked {
        seed: arguments.seed,
        runs: arguments.runs,
        robot: site::address(&arguments.robot)?,
        severity: arguments.severity,
        full: arguments.full,
        tables: Vec::new(),
    };
    let request = Request {
        file,
        edition: arguments.edition,
        arm: &arguments.arm,
        sensitivity: arguments.sensitivity,
        out,
        backend,
    };
    miglino1995::run(&asked, &arguments.tables, &request, console)
}

fn of_2014(arguments: &Odowd2014, console: Console) -> Result<Answer<Findings>> {
    let out = arguments.out.as_deref();
    if arguments.arm == ALL_ARMS {
        return arms(&ODOWD2014, arguments.study.as_deref(), Edition::default());
    }
    if !arguments.sweeps.is_empty() {
        return odowd2014::judge_sweeps(&sweeps(&arguments.sweeps, console)?, out);
    }
    let asked = odowd2014::Asked {
        seed: arguments.seed,
        runs: arguments.runs,
        scales: arguments.scale.clone(),
        credits: arguments.credit.clone(),
        only_cases: arguments.only_cases,
        questions: arguments.questions,
    };
    let request = Request {
        file: arguments.study.as_deref(),
        edition: Edition::default(),
        arm: &arguments.arm,
        sensitivity: arguments.sensitivity,
        out,
        backend: &arguments.backend.resolve(),
    };
    odowd2014::run(&asked, &request, console)
}

/// The arms of a study with their assumptions.
fn arms(shipped: &'static Shipped, file: Option<&Path>, edition: Edition) -> Result<Answer<Findings>> {
    let arms = StudyFile::open(shipped, file)?.in_edition(edition)?.arms()?;
    let words: Vec<_> = arms
        .iter()
        .map(|arm| vec![arm.name.clone(), arm.words.clone()])
        .collect();
    let rows = arms
        .iter()
        .map(|arm| [("arm", &arm.name), ("assumption", &arm.words)])
        .map(|row| {
            row.into_iter()
                .map(|(column, cell)| (column.to_owned(), json!(cell)))
                .collect()
        })
        .collect();
    let tables = Findings::Tables(BTreeMap::from([("arms".to_owned(), rows)]));
    Ok(Answer::new(columns(&["arm", "assumption"], &words), tables))
}
