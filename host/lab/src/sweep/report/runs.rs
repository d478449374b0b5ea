//! The table of runs, read completely.

use std::collections::{BTreeMap, BTreeSet};

use oneiro_base::exit::Result;

use super::levels::Factor;
use super::sample::Sample;
use super::table::Table;
use super::{Compared, Tables};

/// Letters shown of an identifier or a hash.
const SHORT: usize = 12;

/// All runs.
pub(super) struct Runs {
    pub(super) factors: Vec<Factor>,
    /// By number.
    pub(super) all: Vec<Run>,
    /// Combinations of levels that were run, in the order of their first runs.
    pub(super) cells: Vec<Cell>,
    /// Whether less of the outcome is better.
    is_less_better: bool,
}

/// One run.
pub(super) struct Run {
    pub(super) number: u64,
    /// Beginnings of its identifier and of its result's hash.
    pub(super) id: Box<str>,
    pub(super) result: Box<str>,
    pub(super) seed: u64,
    /// Level of each factor.
    pub(super) levels: Box<[u32]>,
    /// NaN if it isn't a finite number.
    pub(super) outcome: f64,
    /// The other outcomes, as text.
    pub(super) others: Box<[Box<str>]>,
}

/// The runs of one combination of levels.
pub(super) struct Cell {
    pub(super) levels: Box<[u32]>,
    /// Indices of its runs.
    pub(super) runs: Vec<usize>,
}

impl Runs {
    /// Reads the table.
    ///
    /// # Errors
    /// Exit 3 if there is none, exit 5 with the invalid line, exit 6 if reading fails.
    pub(super) fn read(tables: &Tables<'_>) -> Result<Self> {
        let mut table = Table::open(tables.results)?;
        let [number, id, seed, result, outcome] =
            ["run", "id", "seed", "result", tables.outcome.0].map(|name| table.column(name));
        let (number, id, seed, result, outcome) = (number?, id?, seed?, result?, outcome?);
        let (factors, others) = (table.columns(tables.factors)?, table.columns(tables.others)?);
        // Texts of each factor's levels in the order of their first occurrence.
        let mut texts: Vec<BTreeMap<String, u32>> = vec![BTreeMap::new(); factors.len()];
        let mut known = BTreeSet::new();
        let mut runs = Vec::new();
        while table.advance()? {
            let run = Run {
                number: table.whole(number)?,
                id: short(table.cell(id)),
                result: short(table.cell(result)),
                seed: table.whole(seed)?,
                levels: factors
                    .iter()
                    .zip(&mut texts)
                    .map(|(&column, texts)| place(texts, table.cell(column)))
                    .collect(),
                outcome: table.number(outcome)?,
                others: others.iter().map(|&column| table.cell(column).into()).collect(),
            };
            if !known.insert(run.number) {
                return Err(table.corrupt(format_args!("run {} stands in the table already", run.number)));
            }
            runs.push(run);
        }
        runs.sort_by_key(|run| run.number);
        let factors = tables.factors.iter().zip(texts).enumerate();
        let factors = factors.map(|(place, (name, texts))| factor(name, tables.compared, texts, place, &mut runs));
        Ok(Self {
            factors: factors.collect(),
            cells: cells(&runs),
            all: runs,
            is_less_better: tables.is_less_better,
        })
    }

    /// The better, the greater: by a run's outcome.
    pub(super) fn merit(&self, run: &Run) -> f64 {
        if self.is_less_better { -run.outcome } else { run.outcome }
    }

    /// Outcomes of the runs with some indices.
    pub(super) fn sample(&self, places: &[usize]) -> Sample {
        let runs = places.iter().map(|&place| &self.all[place]);
        Sample::new(runs.map(|run| (run.seed, run.outcome)), self.is_less_better)
    }

    /// Outcomes of each group of a factor's levels.
    pub(super) fn samples(&self, factor: usize) -> Vec<Sample> {
        let mut groups = vec![Vec::new(); self.factors[factor].groups.len()];
        for run in &self.all {
            groups[self.group(run, factor)].push((run.seed, run.outcome));
        }
        let sample = |group| Sample::new(group, self.is_less_better);
        groups.into_iter().map(sample).collect()
    }

    /// Outcomes of all runs.
    pub(super) fn outcomes(&self) -> Sample {
        Sample::new(self.all.iter().map(|run| (run.seed, run.outcome)), self.is_less_better)
    }

    /// Group of a factor's levels that a run belongs to.
    pub(super) fn group(&self, run: &Run, factor: usize) -> usize {
        self.factors[factor].group(run.levels[factor])
    }

    /// The first factor with which this one always changes, as the keys of a sweep's `[[list]]` do: what they do can't be told apart, so
    /// that only that one is tested.
    pub(super) fn tested_as(&self, factor: usize) -> Option<usize> {
        let groups = |of: usize| self.factors[of].groups.len();
        (0..factor).find(|&first| {
            let mut partners = vec![None; groups(first)];
            let mut is_partner = |run: &Run| {
                let own = self.group(run, factor);
                *partners[self.group(run, first)].get_or_insert(own) == own
            };
            groups(factor) > 1 && groups(first) == groups(factor) && self.all.iter().all(&mut is_partner)
        })
    }

    /// Texts of a run's or a cell's levels.
    pub(super) fn texts<'a>(&'a self, levels: &'a [u32]) -> impl Iterator<Item = &'a str> {
        let levels = self.factors.iter().zip(levels);
        levels.map(|(factor, &level)| factor.levels[level as usize].text.as_str())
    }

    /// Index of the run with a number.
    pub(super) fn place(&self, number: u64) -> Option<usize> {
        self.all.binary_search_by_key(&number, |run| run.number).ok()
    }
}

fn short(text: &str) -> Box<str> {
    text.chars().take(SHORT).collect()
}

/// Index of a text in the order of first occurrence.
fn place(texts: &mut BTreeMap<String, u32>, text: &str) -> u32 {
    if let Some(&place) = texts.get(text) {
        return place;
    }
    let place = texts.len() as u32;
    texts.insert(text.to_owned(), place);
    place
}

/// Makes a factor with ordered levels, and updates the runs' levels to that order.
fn factor(name: &str, compared: Compared, texts: BTreeMap<String, u32>, place: usize, runs: &mut [Run]) -> Factor {
    let mut sorted = vec![String::new(); texts.len()];
    for (text, place) in texts {
        sorted[place as usize] = text;
    }
    let mut levels: Vec<u32> = runs.iter().map(|run| run.levels[place]).collect();
    let factor = Factor::new(name, compared, sorted, &mut levels);
    for (run, level) in runs.iter_mut().zip(levels) {
        run.levels[place] = level;
    }
    factor
}

fn cells(runs: &[Run]) -> Vec<Cell> {
    let mut places: BTreeMap<&[u32], usize> = BTreeMap::new();
    let mut cells: Vec<Cell> = Vec::new();
    for (run, Run { levels, .. }) in runs.iter().enumerate() {
        let next = cells.len();
        let place = *places.entry(levels).or_insert(next);
        if place == next {
            cells.push(Cell {
                levels: levels.clone(),
                runs: Vec::new(),
            });
        }
        cells[place].runs.push(run);
    }
    cells
}
