//! Combinations of levels, best first.

use oneiro_base::contents::Column;
use oneiro_report::csv::{Csv, known};
use oneiro_report::numbers::{count, shown};
use oneiro_report::page::{self, Head, Row, Section, list, paragraph, table};
use oneiro_statistics::mean;

use super::champions::target;
use super::effects::LEAST;
use super::runs::{Cell, Runs};
use super::sample::Sample;
use super::{DIGITS, Tables};

/// Number of cells on the page.
const SHOWN: usize = 200;
/// Number of runs on the page.
pub(super) const LISTED: usize = 600;

/// All cells.
pub(super) struct Cells<'a> {
    /// Cells by mean outcome, the best first, those without one last. Equal ones are in the order of their runs.
    pub(super) ranked: Vec<Ranked<'a>>,
}

/// A cell with its outcomes.
pub(super) struct Ranked<'a> {
    pub(super) cell: &'a Cell,
    pub(super) sample: Sample,
}

impl<'a> Cells<'a> {
    /// Ranks the cells.
    pub(super) fn of(runs: &'a Runs) -> Self {
        let ranked = |cell: &'a Cell| {
            let sample = runs.sample(&cell.runs);
            (sample.merit(), Ranked { cell, sample })
        };
        let mut ranked: Vec<(f64, Ranked<'a>)> = runs.cells.iter().map(ranked).collect();
        ranked.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        Self {
            ranked: ranked.into_iter().map(|(_, cell)| cell).collect(),
        }
    }

    /// Fewest and most runs of a cell.
    pub(super) fn runs(&self) -> (usize, usize) {
        let counts = || self.ranked.iter().map(|ranked| ranked.cell.runs.len());
        (counts().min().unwrap_or(0), counts().max().unwrap_or(0))
    }

    /// Number of the best cells whose runs are on the page.
    pub(super) fn listed(&self) -> usize {
        let runs = self.ranked.iter().take(SHOWN).scan(0, |sum, ranked| {
            *sum += ranked.cell.runs.len();
            Some(*sum)
        });
        runs.take_while(|sum| *sum <= LISTED).count()
    }

    /// Table of the best cells.
    pub(super) fn section(&self, tables: &Tables<'_>, runs: &Runs) -> Section {
        let all = self.ranked.len();
        let words = format!(
            "A cell is a combination of levels. {} by the mean of {}, best first{}; n is the number of runs whose outcome \
             is a number. A cell\u{2019}s number leads to its runs. The mean of few runs is uncertain, and that of the best of many cells is more likely too high \
             than too low.",
            if all > SHOWN {
                format!("The best {SHOWN} of {} cells", count(all as u64))
            } else {
                "All cells".to_owned()
            },
            tables.outcome.1,
            if all > SHOWN { ": cells.csv has all of them" } else { "" },
        );
        let without = tables
            .unfinished
            .as_ref()
            .map_or(&[][..], |unfinished| &unfinished.without_runs);
        let without = if without.is_empty() {
            String::new()
        } else {
            paragraph("No run is finished yet of these cells:")
                + &list(&without.iter().take(SHOWN).map(String::as_str).collect::<Vec<_>>())
        };
        let mut head = vec![Head::Number("Cell")];
        head.extend(runs.factors.iter().map(|factor| Head::Text(&factor.name)));
        head.extend(["n", "mean", "s.d.", "median", "minimum", "maximum"].map(Head::Number));
        let listed = self.listed() as u64;
        let rows: Vec<Row> = self
            .ranked
            .iter()
            .zip(1_u64..)
            .take(SHOWN)
            .map(|(ranked, rank)| {
                let Ranked { cell, sample } = ranked;
                let [least, _, median, _, greatest] = sample.quartiles();
                let first = cell
                    .runs
                    .first()
                    .filter(|_| rank <= listed)
                    .map(|&run| target(&runs.all[run]));
                let link = first.map_or_else(|| rank.to_string(), |run| format!("<a href=\"#{run}\">{rank}</a>"));
                let mut cells = vec![page::Cell::number(link)];
                cells.extend(runs.texts(&cell.levels).map(page::Cell::name));
                cells.push(page::Cell::number(self.counted(tables, sample)));
                let figures = [sample.mean(), sample.deviation(), median, least, greatest];
                cells.extend(figures.map(|figure| page::Cell::number(shown(figure, DIGITS))));
                cells.into()
            })
            .collect();
        Section::new(
            "cells",
            "Cells",
            format!("{}{}{without}", paragraph(&words), table("", "", &head, &rows)),
        )
    }

    /// Number of a cell's outcomes, of how many if the sweep is unfinished, and whether they are too few to compare.
    fn counted(&self, tables: &Tables<'_>, sample: &Sample) -> String {
        let of = tables.unfinished.as_ref().map_or_else(String::new, |unfinished| {
            format!(" of {}", count(unfinished.runs_a_cell as u64))
        });
        let few = if sample.values.len() < LEAST && self.ranked.len() > 1 {
            " <span class=\"small\">too few to test</span>"
        } else {
            ""
        };
        counted(sample) + &of + few
    }

    /// All cells as CSV, with the means of the other outcomes if they are numbers.
    pub(super) fn csv(&self, tables: &Tables<'_>, runs: &Runs) -> String {
        let column = |name: String| Column::number("", "", "").named(name);
        let factors: Vec<Column> = runs.factors.iter().map(|factor| column(factor.name.clone())).collect();
        let others: Vec<Column> = tables
            .others
            .iter()
            .map(|other| column(format!("mean_{other}")))
            .collect();
        let mut table = Csv::new(&columns(&factors, &others));
        for (Ranked { cell, sample }, rank) in self.ranked.iter().zip(1_u64..) {
            let [least, _, median, _, greatest] = sample.quartiles();
            let mut row = vec![rank.to_string()];
            row.extend(runs.texts(&cell.levels).map(str::to_owned));
            row.extend([cell.runs.len(), sample.values.len()].map(|n| n.to_string()));
            row.extend([sample.mean(), sample.deviation(), median, least, greatest].map(known));
            row.extend((0..tables.others.len()).map(|other| {
                let numbers = cell.runs.iter().map(|&run| runs.all[run].others[other].parse::<f64>());
                let finite: Vec<f64> = numbers
                    .filter_map(|number| number.ok().filter(|x| x.is_finite()))
                    .collect();
                known(mean(&finite))
            }));
            table.row(row);
        }
        table.text()
    }
}

/// The columns of the table of cells, with those of what was swept and of other outcomes.
pub(super) fn columns(factors: &[Column], others: &[Column]) -> Vec<Column> {
    let outcome = [
        Column::whole("runs", "", "the number of runs in the cell"),
        Column::whole(
            "n",
            "",
            "the number of runs whose outcome is a number; the columns below are computed from these",
        ),
        Column::number(
            "mean",
            "",
            "the outcome's mean (`--outcome`; the unit is the outcome's)",
        ),
        Column::number("sd", "", "its standard deviation"),
        Column::number("median", "", "its median"),
        Column::number("min", "", "the lowest"),
        Column::number("max", "", "the highest"),
    ];
    let cell = Column::whole("cell", "", "its number, from 1, best first");
    [&[cell], factors, &outcome, others].concat()
}

/// Number of outcomes, and of runs without one.
pub(super) fn counted(sample: &Sample) -> String {
    let n = count(sample.values.len() as u64);
    match sample.not_numbers {
        0 => n,
        not_numbers => format!("{n} <span class=\"small\">(+{} NaN)</span>", count(not_numbers as u64)),
    }
}
