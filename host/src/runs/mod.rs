//! Kinds of runs. All that differs from one kind of experiment to another is behind one trait, [`Experiment`]: what
//! the engine runs for it, what a run's directory and a sweep's tables hold of it, and what commands say of it.
//!
//! | folder | content |
//! |---|---|
//! | [`single`] | evolutions of single robots |
//! | [`swarm`] | swarms whose on-board simulators evolve |

pub(crate) mod single;
pub(crate) mod swarm;

use std::fmt::Debug;
use std::path::Path;
use std::sync::Arc;

use serde_json::Value;

use crate::console::Console;
use crate::engine::handle::Engine;
use crate::engine::job::Job;
use crate::exit::{Failure, Result};
use crate::experiment::source::{Parsed, Setting};
use crate::experiment::swarm::SwarmExperiment;
use crate::experiment::{self, Files, Identities, Input};
use crate::files;
use crate::reality::site::Site;
use oneiro::batch::Worlds;

/// An experiment of any kind, as far as running it goes.
pub(crate) trait Experiment: Debug + Send + Sync {
    /// Its name.
    fn name(&self) -> &str;
    /// Its values, if it is one with single robots, whose controllers can be evaluated alone.
    fn single(&self) -> Option<&experiment::Experiment>;
    /// The seed of its file, if it names one.
    fn seed(&self) -> Option<u64>;
    /// What the user should know of its files, although they are allowed.
    fn warnings(&self) -> &[String];
    /// The files that it names, for a run's directory.
    fn inputs(&self) -> &[Input];
    /// The experiment of a run with every default written out, as TOML.
    fn resolved_toml(&self, seed: u64) -> String;
    /// What decides the results of its runs.
    fn identities(&self) -> Identities;

    /// Steps of a run that people count: generations, or minutes.
    fn length(&self) -> u32;
    /// Robot-steps of a run, but for its trace.
    fn steps(&self) -> u64;
    /// The kernel that its runs begin with.
    fn kernel(&self) -> &'static str;
    /// Bytes that a run needs while it is under way, about.
    fn bytes(&self) -> u64;
    /// Worlds to time a device with.
    ///
    /// # Errors
    /// As packing them says.
    fn sample(&self) -> Result<Worlds>;

    /// The job of a run.
    ///
    /// # Errors
    /// Exit 3 for a value that a world does not allow.
    fn job(self: Arc<Self>, seed: u64, recording: Recording) -> Result<Box<dyn Job>>;
    /// The job of a run that was saved.
    ///
    /// # Errors
    /// Exit 5 when the bytes are not what a job of this run saves.
    fn restored(self: Arc<Self>, seed: u64, recording: Recording, saved: &[u8]) -> Result<Box<dyn Job>>;

    /// The tables that runs add to, the table of steps first.
    fn tables(&self, recording: Recording) -> Vec<Table>;
    /// The files of a run that are results and nothing else, in the order in which they are hashed.
    fn results(&self) -> &'static [&'static str];

    /// The columns of what a run gives in a sweep's table of results.
    fn outcomes(&self) -> Vec<Column>;
    /// The columns of its table of steps.
    fn columns(&self) -> &'static [Column];
    /// What a sweep's report shows where nobody names something else.
    fn shown(&self) -> Shown;

    /// A finished run in a few values.
    ///
    /// # Errors
    /// Exit 5 when its files are not what was written.
    fn summary(&self, run: &Recorded<'_>) -> Result<Summary>;
    /// How far a run is, and the best of it so far.
    ///
    /// # Errors
    /// Exit 5 when its files are not what was written.
    fn progress(&self, run: &Recorded<'_>) -> Result<(u32, Option<f32>)>;

    /// `oneiro check`: prints what the experiment amounts to, and draws it if a file is named.
    ///
    /// # Errors
    /// As the command says.
    fn check(&self, picture: Option<&Path>, console: Console) -> Result;
    /// `oneiro replay`: evaluates a finished run's best again, and draws it.
    ///
    /// # Errors
    /// As the command says.
    fn replay(&self, run: &Recorded<'_>, replay: &Replay<'_>, engine: &Engine, console: Console) -> Result;
    /// `oneiro audit`: evaluates a part of a recorded run again, and compares.
    ///
    /// # Errors
    /// Errors of the evaluator, and files that are not what was written; differences are no error.
    fn audit(&self, run: &Recorded<'_>, share: f64, engine: &Engine, console: Console) -> Result<Audit>;
}

/// A recorded run of an experiment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Recorded<'a> {
    /// Its directory.
    pub(crate) directory: &'a Path,
    /// Its seed.
    pub(crate) seed: u64,
    /// Whether it is finished.
    pub(crate) is_done: bool,
}

/// What is drawn of a run again, and where.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Replay<'a> {
    /// The directory of its files.
    pub(crate) out: &'a Path,
    /// Which of the champion's lives, from 0.
    pub(crate) trial: u32,
    /// Cycles from one record to the next.
    pub(crate) every: u32,
    /// Another start than the champion's own: x and y in mm, heading in turns.
    pub(crate) start: Option<[f32; 3]>,
    /// A seed of other random numbers than the champion's own.
    pub(crate) seed: Option<u64>,
    /// The file of a genome other than the champion's.
    pub(crate) genome: Option<&'a Path>,
}

/// Where a run is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Recording {
    /// In a directory of its own, with every individual, a trace and pictures.
    Directory,
    /// In a sweep's tables.
    Tables,
}

/// A file of a run that grows as the run goes on.
#[derive(Debug)]
pub(crate) struct Table {
    /// Its name in the run's directory.
    pub(crate) file: &'static str,
    /// What it begins with.
    pub(crate) head: Vec<u8>,
}

/// What the cells of a column hold. An empty cell holds nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Holds {
    /// Whole numbers from -2^63 to 2^63 - 1.
    Whole,
    /// Numbers as f64 holds them, NaN and infinities among them.
    Number,
    /// Words.
    Text,
}

/// A column's name and what it holds.
pub(crate) type Column = (&'static str, Holds);

/// What reports show of a sweep: columns, and what readers call them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shown {
    /// The outcome that cells are compared by; higher is better.
    pub(crate) by: (&'static str, &'static str),
    /// Of the table of steps, along the axes of learning curves.
    pub(crate) time: (&'static str, &'static str),
    pub(crate) value: (&'static str, &'static str),
}

/// A finished run in a few values.
#[derive(Debug)]
pub(crate) struct Summary {
    /// Names and values, for programs.
    pub(crate) values: Vec<(&'static str, Value)>,
    /// The same in a line for people, and what it is called.
    pub(crate) line: (&'static str, String),
    /// Cells of a list of runs, by their columns.
    pub(crate) cells: Vec<(&'static str, String)>,
    /// What the user should know of it.
    pub(crate) warnings: Vec<String>,
}

/// What the audit of a run found.
#[derive(Debug)]
pub(crate) struct Audit {
    /// For people.
    pub(crate) text: String,
    /// For programs.
    pub(crate) value: Value,
    /// What differs, in words; nothing if nothing does.
    pub(crate) problem: Option<String>,
}

/// Where the last offspring of a sweep's runs are evaluated besides their simulator.
#[derive(Debug)]
pub(crate) struct Reality<'a> {
    /// The robots.
    pub(crate) sites: Vec<Site>,
    /// Where the sweep's file says so, for messages.
    pub(crate) place: &'a str,
}

/// Reads an experiment's file, with `key=value` settings that go before what it says. Files that it names are looked
/// for from where it lies.
///
/// # Errors
/// Exit 3: the file and the line and column in it (or the setting), the key, what it is, and what is allowed.
pub(crate) fn read(path: &Path, set: &[String]) -> Result<Arc<dyn Experiment>> {
    let text = files::text(path)?;
    let values = Parsed::new(path.display().to_string(), &text)?;
    of(path, &values, &Setting::all_typed(set)?, &Files::default(), None)
}

/// Reads the experiment of a run's directory. Before there were finalists runs had none, and did not say so.
///
/// # Errors
/// As [`read`].
pub(crate) fn recorded(config: &Path) -> Result<Arc<dyn Experiment>> {
    const FINALISTS: &str = "evolution.finalists";
    let text = files::text(config)?;
    let values = Parsed::new(config.display().to_string(), &text)?;
    let is_older = !values.has("swarm") && !values.has(FINALISTS);
    let none = Setting::at(config.display().to_string(), FINALISTS, &0.into());
    let missing = if is_older { vec![none] } else { Vec::new() };
    of(config, &values, &missing, &Files::default(), None)
}

/// Reads the values of an experiment's file. What other experiments named already is taken from `files`.
///
/// # Errors
/// As [`read`].
pub(crate) fn of(
    path: &Path,
    values: &Parsed<'_>,
    set: &[Setting],
    files: &Files,
    reality: Option<Reality<'_>>,
) -> Result<Arc<dyn Experiment>> {
    if values.has("swarm") {
        if let Some(Reality { place, .. }) = reality {
            return Err(Failure::input(format_args!(
                "{place}: reality: is given for a swarm, whose arena is its reality; allowed: with experiments of single \
                 robots"
            )));
        }
        return Ok(Arc::new(SwarmExperiment::of(path, values, set)?));
    }
    let experiment = experiment::Experiment::of(path, values, set, files)?;
    Ok(Arc::new(single::Single::new(experiment, reality)))
}
