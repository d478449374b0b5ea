//! Finished runs of several experiments, from their directories and from sweeps.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use oneiro::world::GeneLayout;
use oneiro_base::console::counted;
use oneiro_base::exit::{Failure, Result};

use crate::experiment::Experiment;
use crate::experiment::source::Setting;
use crate::record::SavedRun;
use crate::runs::CHAMPION_MEAN;
use crate::runs::single::{best_by_generation, champion, race};
use crate::sweep::file::Axis;
use crate::sweep::report::table::Table;
use crate::sweep::store::Store;
use crate::sweep::tables::Readable;
use crate::sweep::{Plan, Sweep, contents};

/// The finished runs of one experiment, from any seeds.
#[derive(Debug)]
pub struct Condition {
    /// The experiment's name, or a sweep's with the values of a cell.
    pub name: String,
    /// What was named for its first run: the run, a directory of runs or a sweep.
    place: String,
    /// With the settings that override its values.
    pub experiment: Experiment,
    pub runs: Vec<Run>,
}

/// A finished run.
#[derive(Debug)]
pub struct Run {
    /// Hash of the experiment and the seed.
    pub id: String,
    pub seed: u64,
    /// Its directory, or its sweep's with its number.
    pub source: String,
    /// Its directory, or its sweep's, and its number there.
    pub(super) place: (PathBuf, Option<u32>),
    pub(super) champion: Vec<f32>,
    /// Recorded mean of the champion's new episodes; `None` without finalists.
    pub(super) mean: Option<f64>,
    /// The highest score of any individual in its generation.
    pub(super) fitness: f64,
    /// The best score of each generation.
    pub(super) best: Vec<f64>,
    /// Episodes spent after each generation, if it is a race that recorded them.
    pub(super) spent: Option<Vec<u64>>,
    pub(super) result: String,
}

/// Conditions, in the order in which they were named.
#[derive(Debug, Default)]
pub struct Sources {
    conditions: Vec<Condition>,
    /// Positions by the hash of the experiment.
    known: HashMap<blake3::Hash, usize>,
    /// Ids of all runs.
    ids: BTreeSet<String>,
    pub warnings: Vec<String>,
}

impl Sources {
    /// Adds the run of a directory, which was named by itself or with a directory of runs. An unfinished one is left out, with a warning.
    ///
    /// # Errors
    /// Exit 3 if it can't be compared; exit 5 if its files aren't what was written.
    pub fn add_run(&mut self, directory: &Path, named: &Path, set: &[String]) -> Result {
        let run = SavedRun::open(directory)?;
        let place = directory.display().to_string();
        let recorded = run.recorded()?;
        if !recorded.is_done {
            self.warnings.push(format!(
                "{place}: is not finished, so it is left out; `oneiro resume {place}` continues it"
            ));
            return Ok(());
        }
        let done = run.done()?.map(|done| done.result).unwrap_or_default();
        let experiment = run.experiment().single();
        let own = comparable(experiment, &place)?;
        let values = run.experiment().summary(&recorded)?.values;
        let value = |name: &str| values.iter().find(|(own, _)| *own == name).map(|(_, value)| value);
        let number = |name: &str| value(name).map(|value| value.as_f64().unwrap_or(f64::NAN));
        let champion = champion(&recorded, own)?;
        let finished = Run {
            id: run.identity().to_hex().to_string(),
            seed: run.seed(),
            source: place.clone(),
            place: (directory.to_owned(), None),
            mean: number("mean"),
            fitness: number("luckiest").unwrap_or(champion.fitness.into()),
            champion: champion.genome,
            best: best_by_generation(directory)?,
            spent: race::recorded(directory)?,
            result: done,
        };
        let key = run.experiment().identities().of(0);
        let (name, config) = (own.name().to_owned(), run.config());
        let named = named.display().to_string();
        let condition = self.condition(key, name, &named, || {
            if set.is_empty() {
                Ok(own.clone())
            } else {
                Experiment::read(&config, set)
            }
        })?;
        self.add(condition, finished);
        Ok(())
    }

    /// Adds the finished runs of a sweep, a condition for each cell. As long as it has no tables, they are read from its shards, by
    /// temporary files in `beside`.
    ///
    /// # Errors
    /// Exit 3 if it can't be compared, or if no run is finished; exit 5 if its files aren't what was written; exit 6.
    pub fn add_sweep(&mut self, directory: &Path, set: &[String], beside: &Path) -> Result {
        let store = Store::open(directory)?;
        let (sweep, plan) = store.sweep()?;
        let place = directory.display().to_string();
        let set = Setting::all_typed(set)?;
        if plan.layouts.contains(&None) {
            return Err(refused(&place));
        }
        let readable = Readable::of(&store, &sweep, &plan, beside)?;
        self.warnings.extend(readable.problems.iter().cloned());
        if !readable.missing.is_empty() {
            let missing = counted(readable.missing.len(), "run is", "runs are");
            self.warnings
                .push(format!("{place}: is unfinished: {missing} missing of {}", sweep.runs()));
        }
        let all = results(&readable, &plan, &sweep, &place)?;
        let mut conditions: BTreeMap<usize, usize> = BTreeMap::new();
        for (number, run) in all {
            let cell = sweep.cell_of(number);
            let condition = if let Some(known) = conditions.get(&cell) {
                *known
            } else {
                let own = sweep.experiment_of(cell)?;
                comparable(own.single(), &place)?;
                let (key, name) = (own.identities().of(0), cell_name(&sweep, cell));
                let new = self.condition(key, name, &place, || sweep.single_of(cell, &set))?;
                conditions.insert(cell, new);
                new
            };
            self.add(condition, run);
        }
        Ok(())
    }

    /// The position of an experiment's condition, which is made if there is none.
    fn condition(
        &mut self,
        key: blake3::Hash,
        name: String,
        place: &str,
        experiment: impl FnOnce() -> Result<Experiment>,
    ) -> Result<usize> {
        if let Some(known) = self.known.get(&key) {
            return Ok(*known);
        }
        self.conditions.push(Condition {
            name,
            place: place.to_owned(),
            experiment: experiment()?,
            runs: Vec::new(),
        });
        self.known.insert(key, self.conditions.len() - 1);
        Ok(self.conditions.len() - 1)
    }

    /// Adds a run, unless it was named before.
    fn add(&mut self, condition: usize, run: Run) {
        if self.ids.insert(run.id.clone()) {
            self.conditions[condition].runs.push(run);
        } else {
            self.warnings.push(format!(
                "{}: the same run was named before, and counts once",
                run.source
            ));
        }
    }

    /// All conditions, with different names.
    ///
    /// # Errors
    /// Exit 3 if there are not two.
    pub fn finish(self) -> Result<(Vec<Condition>, Vec<String>)> {
        let Self {
            mut conditions,
            warnings,
            ..
        } = self;
        match &conditions[..] {
            [] => {
                return Err(Failure::input(
                    "there is no finished run; allowed: runs and sweeps of two or more experiments",
                ));
            }
            [one] => {
                return Err(Failure::input(format_args!(
                    "all finished runs are of one experiment, {}; allowed: runs of two or more experiments, or a sweep with two or \
                     more cells",
                    one.name
                )));
            }
            _ => (),
        }
        let names: Vec<String> = conditions.iter().map(|own| own.name.clone()).collect();
        for condition in &mut conditions {
            if names.iter().filter(|name| **name == condition.name).count() > 1 {
                condition.name = format!("{} ({})", condition.name, condition.place);
            }
            condition.runs.sort_by_key(|run| run.seed);
        }
        Ok((conditions, warnings))
    }
}

/// An experiment whose champions can be compared.
///
/// # Errors
/// Exit 3 if it is one of the foraging study, or one of two populations.
fn comparable<'a>(experiment: Option<&'a Experiment>, place: &str) -> Result<&'a Experiment> {
    let experiment = experiment.ok_or_else(|| refused(place))?;
    if experiment.settings().evolution.is_coevolution() {
        return Err(Failure::input(format_args!(
            "{place}: has two populations, whose scores depend on each other; allowed: runs of one population; `oneiro evaluate \
             --tournament` compares these"
        )));
    }
    Ok(experiment)
}

fn refused(place: &str) -> Failure {
    Failure::input(format_args!(
        "{place}: is of the foraging study, whose swarms have no champion; allowed: runs that have one; `oneiro sweep report` compares \
         the cells of a sweep"
    ))
}

/// The sweep's name, with the values in which its cells differ.
fn cell_name(sweep: &Sweep, cell: usize) -> String {
    let file = sweep.file();
    let varied = file
        .axes
        .iter()
        .filter(|axis| axis.levels.len() > 1)
        .flat_map(Axis::factors);
    let varied: BTreeSet<&String> = varied.collect();
    let keys: Vec<&str> = file.keys().collect();
    let values = keys.iter().zip(sweep.levels(cell));
    let values = values.filter(|(key, _)| varied.iter().any(|own| own == *key));
    let words: Vec<String> = values.map(|(key, value)| format!("{key} = {value}")).collect();
    if words.is_empty() {
        sweep.name().to_owned()
    } else {
        format!("{}: {}", sweep.name(), words.join(", "))
    }
}

/// The finished runs of a sweep's tables, by number.
fn results(readable: &Readable, plan: &Plan, sweep: &Sweep, place: &str) -> Result<BTreeMap<u32, Run>> {
    let mut runs = BTreeMap::new();
    let path = readable.table(contents::RESULTS);
    let mut table = Table::open(&path)?;
    let [number, id, seed, fitness, result] = ["run", "id", "seed", "best", "result"].map(|name| table.column(name));
    let (number, id, seed, fitness, result) = (number?, id?, seed?, fitness?, result?);
    let (mean, champion_generation) = (table.column(CHAMPION_MEAN)?, table.column("champion_generation")?);
    while table.advance()? {
        let run = number_of(&table, number, sweep)?;
        let has_finalists = !table.cell(champion_generation).is_empty();
        let own = Run {
            id: table.cell(id).to_owned(),
            seed: table.whole(seed)?,
            source: format!("{place}, run {run}"),
            place: (PathBuf::from(place), Some(run)),
            champion: Vec::new(),
            mean: has_finalists.then(|| table.number(mean)).transpose()?,
            fitness: table.number(fitness)?,
            best: Vec::new(),
            spent: None,
            result: table.cell(result).to_owned(),
        };
        runs.insert(run, own);
    }
    let path = readable.table(contents::GENERATIONS);
    let mut table = Table::open(&path)?;
    let (number, best) = (table.column("run")?, table.column("best")?);
    while table.advance()? {
        let run = number_of(&table, number, sweep)?;
        let best = table.number(best)?;
        runs.entry(run).and_modify(|run| run.best.push(best));
    }
    let path = readable.table(contents::CHAMPIONS);
    let mut table = Table::open(&path)?;
    let number = table.column("run")?;
    // The columns of each controller's genes: a sweep has few controllers and many runs.
    let mut known: Vec<(&GeneLayout, Vec<usize>)> = Vec::new();
    while table.advance()? {
        let run = number_of(&table, number, sweep)?;
        let Some(layout) = &plan.layouts[sweep.cell_of(run)] else {
            continue;
        };
        if known.iter().all(|(other, _)| *other != layout) {
            known.push((layout, table.columns(&layout.names())?));
        }
        let columns = known.iter().find(|(other, _)| *other == layout);
        let columns = columns.map_or(&[][..], |(_, columns)| columns);
        let genes: Result<Vec<f32>> = columns.iter().map(|column| table.gene(*column)).collect();
        let genes = genes?;
        runs.entry(run).and_modify(|run| run.champion = genes);
    }
    if let Some((number, _)) = runs.iter().find(|(_, run)| run.champion.is_empty()) {
        return Err(Failure::corrupt(format_args!("{}: lacks run {number}", path.display())));
    }
    Ok(runs)
}

/// A row's run.
fn number_of(table: &Table<'_>, column: usize, sweep: &Sweep) -> Result<u32> {
    let number = table.whole(column)?;
    let run = u32::try_from(number).ok().filter(|run| (*run as usize) < sweep.runs());
    run.ok_or_else(|| table.corrupt(format_args!("run {number} is none of this sweep's")))
}
