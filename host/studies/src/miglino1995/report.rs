//! The study as a page: an abstract, methods, results by question, limits and a glossary in one file, and the underlying
//! numbers as CSV. Both depend only on their input, byte for byte.

use oneiro::arena::Arena;
use oneiro::tables::SensorTables;
use oneiro_report::page;

use super::results::{Condition, Results, Run};
use crate::MIGLINO1995_CLAIMS;
use crate::claims::{Claim, Table};
use crate::file::Edition;
use crate::verdicts::{self, Sensitivity};

mod background;
mod behaviour;
mod csv;
mod evolution;
mod others;
mod paper;
mod robot;
#[cfg(test)]
pub(super) mod tests;

pub(super) use csv::{contents, csv_files};

/// Input of a report.
pub(super) struct Report<'a> {
    pub results: &'a Results,
    /// Claims with their verdicts. Tables 1 and 2 show the tests of C3 and C6 whose statistic is `F` and whose name
    /// starts with the condition's [title](Condition::title).
    pub claims: &'a [Claim],
    /// The sampled sensors.
    pub sensors: &'a SensorTables,
    /// Arena of the robots.
    pub arena: &'a Arena,
    /// The robot's radius, mm.
    pub body_radius: f32,
    /// One-line description of the sampled robot.
    pub robot: &'a str,
    /// Seed of all random numbers.
    pub seed: u64,
    pub edition: Edition,
    /// The claims under each arm, if requested.
    pub arms: Option<&'a Sensitivity>,
}

/// The report as one self-contained HTML file.
pub(super) fn html(study: &Report<'_>) -> String {
    let (table, claims) = (Table::in_edition(MIGLINO1995_CLAIMS, study.edition), study.claims);
    let mut sections = vec![
        verdicts::summary(&table, claims, background::ABOUT),
        background::methods(study),
    ];
    sections.extend(verdicts::by_question(&table, claims, |question| {
        evidence(study, question)
    }));
    sections.extend([background::limits(study), verdicts::glossary(&table)]);
    page::document("Miglino, Lund and Nolfi (1995), reproduced", "", &sections)
}

/// The figures and tables of a question.
fn evidence(study: &Report<'_>, question: &str) -> String {
    let results = study.results;
    match question {
        "sensors" => robot::sensors(study),
        "transfer" => evolution::html(study),
        "reality" => evolution::second_table(study) + &others::controls(results),
        "behaviour" => behaviour::html(study),
        "noise" => others::variants(results),
        "cost" => background::cost(study),
        other => unreachable!("no question is called {other}"),
    }
}

fn runs_of(results: &Results, condition: Condition) -> impl Iterator<Item = &Run> {
    results.runs.iter().filter(move |run| run.condition == condition)
}

/// Full and light colour of a condition.
fn colours(condition: Condition) -> (&'static str, &'static str) {
    match condition {
        Condition::None => ("#2b3a8f", "#8791c9"),
        Condition::Sensor => ("#c8374f", "#e495a1"),
        Condition::Conservative => ("#1f8a7d", "#83c4bb"),
    }
}

/// The paper's letter for a run, or a number when letters run out.
fn run_name(number: u32) -> String {
    match u8::try_from(number) {
        Ok(place @ 0..26) => char::from(b'a' + place).to_string(),
        _ => (u64::from(number) + 1).to_string(),
    }
}

/// Number of the last generation that lived in reality.
fn last_generation(results: &Results) -> u32 {
    (results.simulated_generations + results.real_generations).saturating_sub(1)
}

/// Duration of a real episode in seconds, at 100 ms per cycle.
fn episode_seconds(results: &Results) -> f64 {
    f64::from(results.cycles) * 0.1
}
