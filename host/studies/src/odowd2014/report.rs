//! The study as a page: an abstract, methods, results by question, limits and a glossary in one file, and the underlying
//! numbers as CSV. Both depend only on their input, byte for byte.

use oneiro::swarm::Swarm;
use oneiro_report::figures::escaped;
use oneiro_report::numbers::{Digits, shown};
use oneiro_report::page::{self, Cell, joined};
use serde::Serialize;
use serde_json::Value;

use super::results::{Case, Combination, Credit, Kind, Results};
use crate::ODOWD2014_CLAIMS;
use crate::assumptions::Assumption;
use crate::claims::{Claim, Table};
use crate::verdicts::{self, Sensitivity};

mod background;
mod csv;
mod encounters;
mod foraging;
mod genes;
mod interventions;
mod measures;
mod overview;
mod paper;
mod questions;
mod summary;
mod system;
#[cfg(test)]
mod tests;

pub(crate) use csv::{contents, csv_files};
pub(crate) use summary::summary;

/// Input of a report.
pub(crate) struct Report<'a> {
    pub results: &'a Results,
    /// Claims with their verdicts.
    pub claims: &'a [Claim],
    /// The arena and the robots in it.
    pub foragers: &'a Swarm,
    /// Values in force.
    pub(crate) assumptions: &'a [Assumption],
    /// Seed of all random numbers.
    pub seed: u64,
    /// The claims under each arm, if requested.
    pub arms: Option<&'a Sensitivity>,
}

/// The report as one self-contained HTML file.
pub(crate) fn html(study: &Report<'_>) -> String {
    let (table, claims) = (Table::of(ODOWD2014_CLAIMS), study.claims);
    let mut sections = vec![
        verdicts::summary(&table, claims, background::ABOUT),
        background::methods(study),
    ];
    sections.extend(verdicts::by_question(&table, claims, |question| {
        evidence(study.results, question)
    }));
    sections.extend([background::limits(study), verdicts::glossary(&table)]);
    page::document("O\u{2019}Dowd, Studley and Winfield (2014), reproduced", "", &sections)
}

/// The figures and tables of a question: of all combinations of mutation scale and credit, and of each.
fn evidence(results: &Results, question: &str) -> String {
    let each = |html: &dyn Fn(&Combination) -> String| {
        joined(&results.combinations, |combination| match html(combination) {
            html if html.is_empty() => html,
            html => format!("<h3>{}</h3>\n{html}", escaped(&title(combination))),
        })
    };
    match question {
        "foraging" => overview::rates(results) + &each(&|combination| foraging::html(results, combination)),
        "simulators" => overview::right(results) + &each(&|combination| genes::fixed_lights(results, combination)),
        "moves" => each(&|combination| genes::moving_lights(results, combination)),
        "causes" => each(&interventions::html),
        "swarm" => each(&|combination| encounters::html(results, combination)) + &questions::html(results),
        "cost" => String::new(),
        other => unreachable!("no question is called {other}"),
    }
}

/// A combination's name for readers.
fn title(combination: &Combination) -> String {
    format!(
        "Mutations of s.d. {}, {}",
        shown(combination.scale, DIGITS),
        credit_words(combination.credit)
    )
}

fn credit_words(credit: Credit) -> &'static str {
    match credit {
        Credit::Lagged => "lagged credit",
        Credit::Matched => "matched credit",
    }
}

/// Name of a figure or table in a combination, unique on the page.
fn named(what: &str, combination: &Combination) -> String {
    format!(
        "{what}, s.d. {}, {}",
        shown(combination.scale, DIGITS),
        credit_words(combination.credit)
    )
}

/// Significant digits of numbers on the page.
const DIGITS: Digits = Digits::Four;

/// Name of a case, a kind or a rule of credit in files and arguments.
pub(super) fn name(value: &impl Serialize) -> String {
    match serde_json::to_value(value) {
        Ok(Value::String(name)) => name,
        other => unreachable!("{other:?} is no name"),
    }
}

/// A case's name where space is short.
fn short_title(case: Case) -> &'static str {
    match case {
        Case::NoLight => "no light",
        Case::Over => "over",
        Case::Opposite => "opposite",
        Case::OverThenOpposite => "over \u{2192} opposite",
        Case::OppositeThenOver => "opposite \u{2192} over",
        Case::Random => "random",
    }
}

fn colour(case: Case) -> &'static str {
    match case {
        Case::NoLight => "#7c818c",
        Case::Over => "#d98e04",
        Case::Opposite => "#2b3a8f",
        Case::OverThenOpposite => "#c8374f",
        Case::OppositeThenOver => "#1f8a7d",
        Case::Random => "#26282e",
    }
}

/// A case's name in its colour, as HTML.
fn case_name(case: Case) -> String {
    page::dotted(colour(case), case.title())
}

/// A kind in one line.
fn kind_name(kind: Kind) -> Cell {
    Cell::html(format!("<span class=\"condition\">{}</span>", escaped(kind.title())))
}

/// The cases in which anything evolves.
fn evolving_cases() -> impl Iterator<Item = Case> {
    Case::ALL.into_iter().filter(|&case| case != Case::Random)
}

/// Whether the light moves.
fn moves(case: Case) -> bool {
    let [first, then] = case.lights();
    first != then
}

/// The kinds other than the paper's own that have runs.
fn other_kinds(combination: &Combination) -> impl Iterator<Item = Kind> {
    let kinds = Kind::OF_STUDY.into_iter().filter(|&kind| kind != Kind::Evolved);
    kinds.filter(|&kind| combination.runs.iter().any(|run| run.kind == kind))
}
