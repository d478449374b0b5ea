//! Report of a sweep: one page with figures, tables and tests, and the underlying numbers as CSV. All of it depends
//! only on the sweep's tables, byte for byte.

use std::path::Path;

use oneiro_base::contents::{Column, Entry};
use oneiro_base::exit::Result;
use oneiro_report::numbers::{Digits, count, probability};
use oneiro_report::page;

use super::RunIndex;

mod cells;
mod champions;
mod comparisons;
pub(crate) mod conditions;
pub(crate) mod curves;
mod effects;
mod factors;
mod json;
mod levels;
mod pairs;
mod pictures;
mod runs;
mod sample;
pub(crate) mod table;
#[cfg(test)]
mod tests;

use cells::Cells;
use curves::Curves;
use effects::Effects;
use runs::Runs;
use sample::Sample;

/// Significant digits of outcomes.
const DIGITS: Digits = Digits::Four;

/// The files of a report.
pub const PAGE: &str = "report.html";
pub const CELLS: &str = "cells.csv";
pub const EFFECTS: &str = "effects.csv";

/// The same with descriptions; `factors` are the columns of the swept keys.
pub(super) fn contents(factors: &[Column]) -> Vec<Entry> {
    let others = Column::number(
        "mean_OUTCOME",
        "",
        "the mean of another outcome, one column per outcome",
    );
    let cells = cells::columns(factors, std::slice::from_ref(&others));
    vec![
        Entry::file(PAGE, "written by `oneiro sweep report`: figures, tables and tests"),
        Entry::file(
            format!("{}/", page::FIGURES),
            format!("written by it: {}", page::FIGURES_ABOUT),
        ),
        Entry::table(
            CELLS,
            "written by `oneiro sweep report`: one row per cell, best first",
            &cells,
        ),
        Entry::table(
            EFFECTS,
            "written by `oneiro sweep report`: one row per pair of levels or cells compared",
            &comparisons::COLUMNS,
        ),
    ]
}

/// Input of a report.
#[derive(Debug)]
pub struct Tables<'a> {
    /// Title of the sweep.
    pub title: &'a str,
    /// The table of runs: `run`, `id`, the factors, `seed`, the outcomes and `result`, in any order.
    pub results: &'a Path,
    /// The table of generations: `run`, a time and a value. The rows of a run are contiguous and in order of time.
    pub generations: &'a Path,
    /// Swept columns of the table of runs, in order.
    pub factors: &'a [String],
    pub compared: Compared,
    /// Outcome by which cells are compared: its column, and its name with unit for readers.
    pub outcome: (&'a str, &'a str),
    /// Whether less of it is better.
    pub is_less_better: bool,
    /// Other outcomes that tables show.
    pub others: &'a [String],
    /// What the tables lack, if the sweep is unfinished.
    pub unfinished: Option<Unfinished>,
    /// Column of integer times in the table of generations, and the name of its axis.
    pub time: (&'a str, &'a str),
    /// Column of values that lines show, and the name of its axis.
    pub value: (&'a str, &'a str),
    /// Episodes that runs may spend, if lines also show the best score so far by them: the table of generations then has `best`.
    pub spent: Option<Spent<'a>>,
}

/// Episodes that the evolution of each run may spend.
#[derive(Debug)]
pub struct Spent<'a> {
    /// By the run's number.
    pub ends: &'a [u64],
    /// Whether lines by episodes are shown first, since runs have different generations.
    pub is_first: bool,
}

/// What a report compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compared {
    /// The levels of a sweep's keys.
    Levels,
    /// Conditions, in the order of their runs.
    Conditions,
}

impl Compared {
    /// Their name, singular and plural.
    fn names(self) -> [&'static str; 2] {
        match self {
            Self::Levels => ["level", "levels"],
            Self::Conditions => ["condition", "conditions"],
        }
    }
}

/// What the tables of an unfinished sweep lack.
#[derive(Debug)]
pub struct Unfinished {
    /// Number of planned runs, in all and in each cell.
    pub runs: usize,
    pub runs_a_cell: usize,
    /// Planned runs that aren't finished, in ascending order.
    pub missing: Vec<RunIndex>,
    /// Cells of which no run is finished: their keys and values.
    pub without_runs: Vec<String>,
}

impl Unfinished {
    /// How many runs there are, and which are missing.
    pub fn words(&self) -> String {
        const SHOWN: usize = 12;
        let there = self.runs - self.missing.len();
        let stretches: Vec<&[RunIndex]> = self.missing.chunk_by(|a, b| a + 1 == *b).collect();
        let stretch = |runs: &&[RunIndex]| match runs {
            [first, .., last] => format!("{first} to {last}"),
            _ => runs[0].to_string(),
        };
        let shown: Vec<String> = stretches.iter().take(SHOWN).map(stretch).collect();
        let rest: usize = stretches.iter().skip(SHOWN).map(|runs| runs.len()).sum();
        let more = if rest > 0 {
            format!(" and {rest} more")
        } else {
            String::new()
        };
        format!("{there} of {} runs; missing: {}{more}", self.runs, shown.join(", "))
    }
}

/// A report.
#[derive(Debug, PartialEq)]
pub struct Report {
    /// The page, self-contained.
    pub html: String,
    /// All comparisons of levels and cells, as CSV.
    pub effects_csv: String,
    /// All cells, best first, as CSV.
    pub cells_csv: String,
    /// A shorter version as JSON.
    pub json: serde_json::Value,
    /// The number of the run with the best outcome, the first of equal ones.
    pub best: u64,
}

/// Reads a sweep's tables and makes the report. The table of generations may have any length: only sums are kept.
///
/// # Errors
/// Exit 3 if a table is missing. Exit 5, with file and line, if it lacks a column, or if a row is cut short, has a cell
/// of the wrong type, occurs twice or belongs to no run. Exit 6 if reading fails.
pub fn report(tables: &Tables<'_>) -> Result<Report> {
    let runs = Runs::read(tables)?;
    let curves = Curves::read(tables, &runs)?;
    let samples: Vec<Vec<Sample>> = (0..runs.factors.len()).map(|factor| runs.samples(factor)).collect();
    let cells = Cells::of(&runs);
    let effects = Effects::of(&runs, &samples, &cells);
    let mut sections = vec![
        factors::overview(tables, &runs, &samples, &effects),
        factors::one_by_one(tables, &runs, &curves, &samples, &effects),
    ];
    sections.extend(pairs::section(tables, &runs, &effects));
    sections.extend([
        cells.section(tables, &runs),
        champions::section(tables, &runs),
        champions::by_cell(tables, &runs, &cells),
        comparisons::section(tables, &runs, &cells, &effects),
    ]);
    Ok(Report {
        best: champions::champions(&runs).first().map_or(0, |run| run.number),
        html: page::document(tables.title, &facts(tables, &runs, &cells), &sections),
        effects_csv: comparisons::csv(&runs, &effects),
        cells_csv: cells.csv(tables, &runs),
        json: json::json(tables, &runs, &samples, &cells, &effects),
    })
}

/// Facts below the title.
fn facts(tables: &Tables<'_>, runs: &Runs, cells: &Cells<'_>) -> String {
    let number = |n: usize| count(n as u64);
    let all = runs.outcomes();
    let runs_words = tables
        .unfinished
        .as_ref()
        .map_or_else(|| number(runs.all.len()), Unfinished::words);
    let mut facts = vec![("runs", runs_words)];
    if all.not_numbers > 0 {
        let runs = if all.not_numbers == 1 { "run has" } else { "runs have" };
        let words = format!(
            "{} {runs} an outcome that is no number, left out of all else",
            number(all.not_numbers)
        );
        facts.push(("NaN", words));
    }
    let all_cells = tables
        .unfinished
        .as_ref()
        .map_or(0, |unfinished| unfinished.without_runs.len())
        + cells.ranked.len();
    facts.push(("cells", number(all_cells)));
    let (fewest, most) = cells.runs();
    let each = if fewest == most {
        number(most)
    } else {
        format!("{} to {}", number(fewest), number(most))
    };
    facts.push(("runs a cell", each + &limit(cells.ranked.len(), most)));
    let factors: Vec<(&str, String)> = runs
        .factors
        .iter()
        .map(|factor| (factor.name.as_str(), factors::levels(factor)))
        .collect();
    facts.extend(factors);
    let better = if tables.is_less_better { "less" } else { "more" };
    facts.push(("outcome", format!("{}; {better} is better", tables.outcome.1)));
    let lead = if runs.factors.is_empty() {
        "Evolutions that differ in their seeds alone: how they went, and what came out.".to_owned()
    } else {
        let keys = if runs.factors.len() == 1 { "key does" } else { "keys do" };
        format!("Evolutions side by side: what the swept {keys}, which settings are best, and how sure that is.")
    };
    let unfinished = tables.unfinished.as_ref().map_or_else(String::new, |unfinished| {
        format!(
            "<p><b>Unfinished: {}.</b> This report is of the runs that are finished.</p>\n",
            unfinished.words()
        )
    });
    format!("<p class=\"lead\">{lead}</p>\n{unfinished}{}", page::facts(&facts))
}

/// A note if cells have so few runs that no two of them can differ by the test of Mann and Whitney, whatever their outcomes.
fn limit(cells: usize, runs: usize) -> String {
    // Of all ways to rank the runs of two cells, two put those of one before all others.
    let ways: f64 = (1..=runs).map(|run| (runs + run) as f64 / run as f64).product();
    let least = 2.0 / ways;
    if cells < 2 || runs == 0 || least < effects::LEVEL {
        return String::new();
    }
    format!(
        "; two cells of so few can't differ with p below {}: take more seeds",
        probability(least)
    )
}

/// A corrected probability, highlighted if it is low.
fn marked(p: f64) -> String {
    if p < effects::LEVEL {
        format!("<b>{}\u{a0}*</b>", probability(p))
    } else {
        probability(p)
    }
}
