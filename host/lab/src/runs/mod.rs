//! Kinds of runs. All differences between kinds of experiments are behind one trait, [`Experiment`]: what the engine runs, what a
//! run's directory and a sweep's tables hold, and what commands report.
//!
//! | folder | contents |
//! |---|---|
//! | [`single`] | evolutions of single robots |
//! | [`swarm`] | swarms whose on-board simulators evolve |
//! | [`taken`] | pictures and films of replayed episodes |
//! | [`report`] | what the pages of finished runs have in common |

pub(crate) mod report;
pub mod single;
pub mod swarm;
mod taken;

use std::fmt::Debug;
use std::path::Path;
use std::sync::Arc;

use oneiro::batch::Worlds;
use oneiro_base::answer::Answer;
use oneiro_base::console::{Bars, Console};
use oneiro_base::contents::{Column, Entry};
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use serde_json::Value;

use crate::engine::handle::Engine;
use crate::engine::job::Job;
use crate::experiment::kinds::FileKind;
use crate::experiment::source::{LeftOut, Parsed, Setting};
use crate::experiment::swarm::SwarmExperiment;
use crate::experiment::{self, Files, Identities, Input};
use crate::reality::site::Site;
use crate::reality::wired::Time;

/// Episodes of a run in some worlds.
#[derive(Debug)]
pub struct Work {
    pub worlds: Worlds,
    /// Episodes that a device gets at a time, at most.
    pub at_a_time: u64,
    /// Robot-steps of all of them.
    pub steps: u64,
}

/// An experiment of any kind, as needed to run it.
pub trait Experiment: Debug + Send + Sync {
    /// Name of the experiment.
    fn name(&self) -> &str;
    /// Its values if it has single robots, whose controllers can be evaluated one by one.
    fn single(&self) -> Option<&experiment::Experiment>;
    /// Itself, if it has a swarm.
    fn swarm(&self) -> Option<&SwarmExperiment> {
        None
    }
    /// The seed in its file, if any.
    fn seed(&self) -> Option<u64>;
    /// Warnings about its files.
    fn warnings(&self) -> &[String];
    /// Settings that have no effect because of others.
    fn left_out(&self) -> &LeftOut;
    /// The files that it names, for a run's directory.
    fn inputs(&self) -> &[Input];
    /// The experiment of a run as TOML, with every default written out.
    fn resolved_toml(&self, seed: u64) -> String;
    /// Everything that decides the results of its runs, hashed.
    fn identities(&self) -> Identities;

    /// Number of steps of a run in the user's units: generations or minutes.
    fn length(&self) -> u32;
    /// Robot-steps of a run, excluding its trace.
    fn steps(&self) -> u64;
    /// Episodes of a run: its budget if it has one, else those that its values make; none for swarms of the foraging study.
    fn episodes(&self) -> Option<u64> {
        let own = self.single()?;
        Some(
            own.settings()
                .evolution
                .budget
                .unwrap_or_else(|| own.episodes().total()),
        )
    }
    /// What a run makes of its budget of episodes, in words, if it has one.
    fn budget(&self) -> Option<String> {
        self.single().and_then(experiment::Experiment::budget)
    }
    /// Kernel that its runs begin with.
    fn kernel(&self) -> &'static str;
    /// Approximate memory of a run in progress, in bytes.
    fn bytes(&self) -> u64;
    /// Time that a run takes connected robots, if it ends on any.
    fn robot_time(&self) -> Option<Time> {
        None
    }
    /// Checks that its runs can be those of a sweep.
    ///
    /// # Errors
    /// Exit 3 with the obstacle.
    fn check_sweep(&self) -> Result {
        Ok(())
    }
    /// Worlds for measuring a device's speed.
    ///
    /// # Errors
    /// Errors of packing them.
    fn sample(&self) -> Result<Worlds>;
    /// What a device does for a run, by the worlds that it does it in.
    ///
    /// # Errors
    /// Errors of packing them.
    fn work(&self) -> Result<Vec<Work>> {
        Ok(vec![Work {
            worlds: self.sample()?,
            at_a_time: u64::MAX,
            steps: self.steps(),
        }])
    }

    /// Makes the job of a run.
    ///
    /// # Errors
    /// Exit 3 for a value that the world doesn't allow.
    fn job(self: Arc<Self>, seed: u64, recording: Recording<'_>) -> Result<Box<dyn Job>>;
    /// Restores the job of a saved run.
    ///
    /// # Errors
    /// Exit 5 if the bytes aren't what a job of this run saves.
    fn restored(self: Arc<Self>, seed: u64, recording: Recording<'_>, saved: &[u8]) -> Result<Box<dyn Job>>;

    /// The saved job of a run with more generations, given that of a run of `earlier`, which differs only in having fewer.
    ///
    /// # Errors
    /// Exit 5 if the bytes aren't what a job of that run saves.
    fn extended(&self, earlier: &dyn Experiment, seed: u64, saved: &[u8]) -> Result<Vec<u8>>;

    /// Tables that runs append to, the table of steps first.
    fn tables(&self, recording: Recording<'_>) -> Vec<Table>;
    /// Files of a run that contain only results, in the order in which they are hashed.
    fn results(&self) -> Vec<&'static str>;
    /// The files of a run's directory that other kinds of runs don't have.
    fn contents(&self) -> Vec<Entry>;

    /// Columns of a run's results in a sweep's table.
    fn outcomes(&self) -> Vec<Column>;
    /// Columns of its table of steps.
    fn columns(&self) -> &'static [Column];
    /// Columns that a sweep's report shows by default.
    fn shown(&self) -> Shown;

    /// Summarises a finished run.
    ///
    /// # Errors
    /// Exit 5 if its files aren't what was written.
    fn summary(&self, run: &Recorded<'_>) -> Result<Summary>;
    /// Finished steps of a run, and its best fitness so far.
    ///
    /// # Errors
    /// Exit 5 if its files aren't what was written.
    fn progress(&self, run: &Recorded<'_>) -> Result<(u32, Option<f32>)>;

    /// `oneiro check`: summarises the experiment, and draws it if a file is named.
    ///
    /// # Errors
    /// As the command says.
    fn check(&self, picture: Option<&Path>) -> Result<Answer>;
    /// `oneiro check --episodes`: checks each operation in episodes of random genomes, and says that all are exact.
    ///
    /// # Errors
    /// Exit 3: the operations that devices may compute in different ways, each with its place.
    fn check_lives(&self, lives: u32) -> Result<String>;
    /// `oneiro replay`: evaluates a finished run's champion again and draws it.
    ///
    /// # Errors
    /// As the command says.
    fn replay(&self, run: &Recorded<'_>, replay: &Replay<'_>, engine: &Engine, bars: Bars) -> Result<Answer>;
    /// `oneiro verify --recompute`: evaluates a part of a recorded run again and compares the results.
    ///
    /// # Errors
    /// Errors of the evaluator, and files that aren't what was written. Differences aren't errors.
    fn audit(&self, run: &Recorded<'_>, share: f64, engine: &Engine, bars: Bars) -> Result<Audit>;
    /// `oneiro watch`: simulates the best of a generation, or of the newest complete one, of a run that may still evolve. `checkpoint`
    /// reads the newest saved job. `None` if there is no such generation, or its individuals can't be simulated.
    ///
    /// # Errors
    /// Errors of the evaluator, and of reading the run's files.
    fn scene(
        self: Arc<Self>,
        _run: &Recorded<'_>,
        _generation: Option<u32>,
        _checkpoint: &dyn Fn() -> Option<Vec<u8>>,
        _engine: &Engine,
    ) -> Result<Option<Scene>> {
        Ok(None)
    }
}

/// A generation of a run to look at.
#[derive(Debug)]
pub struct Scene {
    /// The shown individual, the best of its generation, and its recorded score.
    pub generation: u32,
    pub individual: u32,
    pub fitness: f32,
    /// A page that plays its first episode.
    pub page: String,
    /// A picture of the paths of individuals of this generation, for single robots.
    pub paths: Option<String>,
    /// A picture of the archive, if the optimiser keeps one: of the newest checkpoint while the run evolves.
    pub archive: Option<String>,
}

/// A recorded run of an experiment.
#[derive(Clone, Copy, Debug)]
pub struct Recorded<'a> {
    pub directory: &'a Path,
    pub seed: u64,
    pub is_done: bool,
}

/// A request to draw a run's best again.
#[derive(Clone, Copy, Debug)]
pub struct Replay<'a> {
    /// Output directory.
    pub out: &'a Path,
    /// Number of the champion's episode, from 0.
    pub trial: u32,
    /// Cycles between records.
    pub every: u32,
    /// A start other than the champion's: x and y in mm, heading in turns.
    pub start: Option<[f32; 3]>,
    /// A seed for random numbers other than the champion's.
    pub seed: Option<u64>,
    /// Whether the experiment has its values of tests.
    pub test: bool,
    /// The cell of an elite that replaces the champion.
    pub elite: Option<u32>,
    /// Whether to replay all elites instead, on a page.
    pub elites: bool,
    /// A generation whose best replaces the champion, or whose individual of this number does.
    pub generation: Option<u32>,
    pub individual: Option<u32>,
    /// Generations whose bests are shown on one page instead.
    pub generations: &'a [u32],
    /// The file of a genome other than the champion's.
    pub genome: Option<&'a Path>,
    /// Files for a picture of a moment (SVG or PNG), by default the last one, in s from the start, and for a film (GIF), which is so many
    /// times as fast as real time.
    pub picture: Option<&'a Path>,
    pub at: Option<f64>,
    pub film: Option<&'a Path>,
    pub speed: Option<f64>,
    /// The seed and the severity of a surrogate that is shown next to the simulator.
    pub surrogate: Option<(u64, Option<f32>)>,
}

impl Replay<'_> {
    /// Refuses an episode that an individual of so many trials has not.
    fn check_trial(&self, trials: u32) -> Result {
        if self.trial < trials {
            return Ok(());
        }
        let (trial, last) = (self.trial, trials - 1);
        Err(Failure::input(format_args!(
            "--trial {trial}: no such episode; allowed: 0 to {last}"
        )))
    }
}

/// Where a run is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recording<'a> {
    /// In a directory, with every individual, a trace and pictures.
    Directory {
        /// The directory.
        path: &'a Path,
        /// Where a connected robot reports what it does and what a person has to do.
        console: Console,
    },
    /// In a sweep's tables.
    Tables,
}

/// An append-only file of a run.
#[derive(Debug)]
pub struct Table {
    /// File name in the run's directory.
    pub file: &'static str,
    /// Its first bytes.
    pub head: Vec<u8>,
}

/// Columns that a sweep's report shows, with their names for readers.
#[derive(Clone, Copy, Debug)]
pub struct Shown {
    /// Outcome by which cells are compared.
    pub by: (&'static str, &'static str),
    /// Columns of the table of steps for the axes of learning curves.
    pub time: (&'static str, &'static str),
    pub value: (&'static str, &'static str),
}

/// The outcome that compares runs with finalists: the mean of the champion's new episodes, which neither evolution nor
/// the choice among finalists has used.
pub(crate) const CHAMPION_MEAN: &str = "champion_mean";

impl Shown {
    /// Whether runs without finalists lack the outcome.
    pub(crate) fn needs_finalists(self) -> bool {
        self.by.0 == CHAMPION_MEAN
    }
}

/// A finished run in a few values.
#[derive(Debug)]
pub struct Summary {
    /// Names and values, for JSON.
    pub values: Vec<(&'static str, Value)>,
    /// A label and a line of text with the same values.
    pub line: (&'static str, String),
    /// Cells of a list of runs, by column.
    pub cells: Vec<(&'static str, String)>,
    /// Warnings for the user.
    pub warnings: Vec<String>,
}

/// Result of the audit of a run.
#[derive(Debug)]
pub struct Audit {
    pub answer: Answer,
    /// Description of the differences, if any.
    pub problem: Option<String>,
}

/// The comparison of a sweep's runs in their simulator and in reality.
#[derive(Debug)]
pub struct Reality<'a> {
    /// The robots.
    pub robots: Robots,
    /// Place in the sweep's file, for messages.
    pub place: &'a str,
}

/// The robots that a sweep's runs are compared in.
#[derive(Debug)]
pub enum Robots {
    /// Some that evaluate the last offspring, in addition to their simulator.
    Others(Vec<Site>),
    /// For each run, the robot of its last generations. The first of them is also simulated.
    Own,
}

/// Reads an experiment's file, with `key=value` settings that override it. Files that it names are relative to its
/// directory.
///
/// # Errors
/// Exit 3: the file and the line and column in it (or the setting), the key, the value found, and the values allowed.
pub fn read(path: &Path, set: &[String]) -> Result<Arc<dyn Experiment>> {
    let text = FileKind::Experiment.text(path)?;
    in_text(path, &text, set, &Files::default())
}

/// Reads the text of an experiment's file. The files that it names come from `files`, by their paths, if they are there.
///
/// # Errors
/// As [`read`].
pub fn in_text(path: &Path, text: &str, set: &[String], files: &Files) -> Result<Arc<dyn Experiment>> {
    let values = FileKind::Experiment.parsed(path, text)?;
    of(path, &values, &Setting::all_typed(set)?, files, None)
}

/// Reads the experiment of a run's directory. Older runs without finalists don't mention them.
///
/// # Errors
/// As [`read`].
pub fn recorded(config: &Path) -> Result<Arc<dyn Experiment>> {
    recorded_with(config, &[])
}

/// Reads the experiment of a run's directory, with settings that override its values.
///
/// # Errors
/// As [`read`].
pub(crate) fn recorded_with(config: &Path, set: &[Setting]) -> Result<Arc<dyn Experiment>> {
    const FINALISTS: &str = "evolution.finalists";
    let text = files::text(config)?;
    let values = Parsed::new(config.display().to_string(), &text)?.recorded();
    let is_older = !values.has("swarm") && !values.has(FINALISTS);
    let none = Setting::at(config.display().to_string(), FINALISTS, &0.into()).ranked(0);
    let missing = if is_older { vec![none] } else { Vec::new() };
    of(config, &values, &[&missing, set].concat(), &Files::default(), None)
}

/// Reads the values of an experiment's file. Files that other experiments have already named come from `files`.
///
/// # Errors
/// As [`read`].
pub fn of(
    path: &Path,
    values: &Parsed<'_>,
    set: &[Setting],
    files: &Files,
    reality: Option<Reality<'_>>,
) -> Result<Arc<dyn Experiment>> {
    if values.has("swarm") {
        if let Some(Reality { place, .. }) = reality {
            return Err(Failure::input(format_args!(
                "{place}: reality: is given for the foraging study, whose arena is its reality; allowed: with other \
                 experiments"
            )));
        }
        return Ok(Arc::new(SwarmExperiment::of(path, values, set)?));
    }
    let experiment = experiment::Experiment::of(path, values, set, files)?;
    if !values.is_recorded() {
        experiment.check_test()?;
    }
    Ok(Arc::new(single::Single::new(experiment, reality)))
}
