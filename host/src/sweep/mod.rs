//! Sweeps: many runs of one experiment, with other values and from several seeds, as one job.
//!
//! A sweep is a list of runs: each cell, a point of its grid, from each seed. A run's id is the hash of its resolved
//! experiment and its seed, the same that a run's directory has, so that what is done is known wherever it was done.
//!
//! | file | what |
//! |---|---|
//! | [`mod@file`] | what a sweep's TOML says |
//! | [`estimate`] | how long it takes on each device here |
//! | [`lockstep`] | the loop: generations of many runs in one batch |
//! | [`swarms`] | the same for swarms, whose runs are whole lives |
//! | [`outcome`] | what a run gave: columns of tables |
//! | [`journal`] | what one process has done, on the disk |
//! | [`store`] | a sweep's directory: whose it is, and its shards' journals |
//! | [`tables`], [`table`], `parquet` | the runs of all shards in one table |
//! | [`report`] | the page: curves, heat maps, champions, which cells differ |
//! | [`slurm`] | the job array that does it |

pub(crate) mod estimate;
pub(crate) mod file;
pub(crate) mod journal;
pub(crate) mod lockstep;
pub(crate) mod outcome;
#[cfg(feature = "parquet")]
mod parquet;
pub(crate) mod report;
pub(crate) mod slurm;
pub(crate) mod store;
pub(crate) mod swarms;
pub(crate) mod table;
pub(crate) mod tables;

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::exit::{Failure, Result};
use crate::experiment::source::{Parsed, Setting};
use crate::experiment::swarm::{SwarmExperiment, is_swarm_text};
use crate::experiment::{Experiment, Files, Identities};
use crate::{files, swarm};
use file::SweepFile;

/// Which of a sweep's runs: cell by cell, in each cell seed by seed.
pub(crate) type RunIndex = u32;

/// A sweep, and the experiment that it is of.
#[derive(Debug)]
pub(crate) struct Sweep {
    path: PathBuf,
    file: SweepFile,
    /// The experiment's file, as it is and where.
    experiment: PathBuf,
    text: String,
    is_swarm: bool,
    files: Files,
}

/// The experiment of one cell.
#[derive(Debug)]
pub(crate) enum Cell {
    /// A population of single robots.
    Khepera(Box<Experiment>),
    /// A swarm.
    Swarm(Box<SwarmExperiment>),
}

impl Cell {
    /// What decides the results of its runs.
    fn identities(&self) -> Identities {
        match self {
            Self::Khepera(experiment) => experiment.identities(),
            Self::Swarm(experiment) => experiment.identities(),
        }
    }

    /// Robot-steps of one of its runs.
    fn steps(&self, sweep: &Sweep) -> u64 {
        match self {
            Self::Khepera(experiment) => {
                let settings = experiment.settings();
                let evolution = &settings.evolution;
                let generation = u64::from(evolution.population) * u64::from(settings.cycles);
                let lives = u64::from(evolution.generations) * u64::from(settings.trials);
                // The last offspring live in the simulator once more, and in reality.
                let reality = sweep
                    .file
                    .reality
                    .as_ref()
                    .map_or(0, |reality| 1 + reality.robots.len() as u64);
                generation.saturating_mul(lives + reality)
            }
            Self::Swarm(experiment) => swarm::steps(&experiment.plan(0)),
        }
    }

    /// The kernel that its runs begin with.
    fn kernel(&self) -> &'static str {
        match self {
            Self::Khepera(experiment) => experiment.world().kernel().name,
            Self::Swarm(_) => oneiro_shaders::SWARM.name,
        }
    }

    /// Bytes that a run needs while it is under way, about.
    fn bytes(&self) -> u64 {
        match self {
            Self::Khepera(experiment) => {
                let evolution = &experiment.settings().evolution;
                let genes = experiment.world().genes() as u64;
                // Parents, offspring and a batch's inputs; a line of the table for each generation.
                3 * u64::from(evolution.population) * genes * 4 + u64::from(evolution.generations) * 64
            }
            Self::Swarm(experiment) => {
                let settings = experiment.settings();
                u64::from(settings.robots) * u64::from(settings.seconds()) * 64
            }
        }
    }
}

/// All runs of a sweep in a few values each.
#[derive(Debug)]
pub(crate) struct Plan {
    /// The id of each run.
    pub(crate) ids: Vec<blake3::Hash>,
    /// Robot-steps of a run of each cell.
    pub(crate) steps: Vec<u64>,
    /// The kernel that each cell's runs begin with.
    pub(crate) kernels: Vec<&'static str>,
    /// Bytes that a run of any cell needs at most.
    pub(crate) bytes: u64,
}

impl Plan {
    /// Robot-steps of some runs.
    pub(crate) fn steps(&self, sweep: &Sweep, runs: impl Iterator<Item = RunIndex>) -> u64 {
        runs.map(|run| self.steps[sweep.cell_of(run)])
            .fold(0, u64::saturating_add)
    }
}

impl Sweep {
    /// Reads a sweep's file, and the experiment that it names.
    ///
    /// # Errors
    /// Exit 3: the file, the line and column in it, what is wrong and what is allowed.
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let file = SweepFile::read(path)?;
        let experiment = path.parent().unwrap_or(Path::new("")).join(&file.experiment);
        Self::of(path, file, experiment)
    }

    /// Reads the sweep of a file that was called otherwise, and whose experiment lies somewhere else by now.
    ///
    /// # Errors
    /// As [`Sweep::read`].
    pub(crate) fn moved(name: &str, path: &Path, experiment: PathBuf) -> Result<Self> {
        let file = SweepFile {
            name: name.into(),
            ..SweepFile::read(path)?
        };
        Self::of(path, file, experiment)
    }

    fn of(path: &Path, file: SweepFile, experiment: PathBuf) -> Result<Self> {
        let text = files::text(&experiment)
            .map_err(|failure| failure.at(&format!("{}: experiment", file.experiment_place)))?;
        let is_swarm = is_swarm_text(&text);
        if is_swarm && file.reality.is_some() {
            return Err(Failure::input(format_args!(
                "{}: reality: is given for a swarm, whose arena is its reality; allowed: with experiments of single robots",
                file.reality_place
            )));
        }
        Ok(Self {
            path: path.to_owned(),
            file,
            experiment,
            text,
            is_swarm,
            files: Files::default(),
        })
    }

    /// What it is called.
    pub(crate) fn name(&self) -> &str {
        &self.file.name
    }

    /// Its file.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// What its file says.
    pub(crate) fn file(&self) -> &SweepFile {
        &self.file
    }

    /// The experiment's file, its text, and the files that experiments named so far.
    pub(crate) fn experiment(&self) -> (&Path, &str, &Files) {
        (&self.experiment, &self.text, &self.files)
    }

    /// Whether its runs are swarms'.
    pub(crate) fn is_swarm(&self) -> bool {
        self.is_swarm
    }

    /// How many runs it has.
    pub(crate) fn runs(&self) -> usize {
        self.file.cells() * self.file.seeds.len()
    }

    /// A run's cell.
    pub(crate) fn cell_of(&self, run: RunIndex) -> usize {
        run as usize / self.file.seeds.len()
    }

    /// A run's seed.
    pub(crate) fn seed_of(&self, run: RunIndex) -> u64 {
        self.file.seeds[run as usize % self.file.seeds.len()]
    }

    /// The experiment of a cell.
    ///
    /// # Errors
    /// Exit 3 with the place of the value that is not allowed, in the sweep's file or in the experiment's.
    pub(crate) fn cell(&self, cell: usize) -> Result<Cell> {
        self.cell_of_file(&self.parsed()?, cell)
    }

    /// The experiment's values.
    fn parsed(&self) -> Result<Parsed<'_>> {
        Parsed::new(self.experiment.display().to_string(), &self.text)
    }

    fn cell_of_file(&self, experiment: &Parsed<'_>, cell: usize) -> Result<Cell> {
        let swept = self
            .file
            .keys()
            .zip(self.file.values(cell))
            .map(|(key, (value, place))| Setting::at(place.clone(), key, value));
        let set: Vec<Setting> = self.file.set.iter().cloned().chain(swept).collect();
        let path = &self.experiment;
        Ok(if self.is_swarm {
            Cell::Swarm(Box::new(SwarmExperiment::of(path, experiment, &set)?))
        } else {
            Cell::Khepera(Box::new(Experiment::of(path, experiment, &set, &self.files)?))
        })
    }

    /// Checks all cells, and lists all runs.
    ///
    /// # Errors
    /// Exit 3: the first value that is not allowed, or two runs that are the same.
    pub(crate) fn plan(&self) -> Result<Plan> {
        let cells = self.file.cells();
        let experiment = self.parsed()?;
        let of_cell = |cell: usize| {
            let own = self.cell_of_file(&experiment, cell)?;
            let identities = own.identities();
            let ids: Vec<_> = self.file.seeds.iter().map(|&seed| identities.of(seed)).collect();
            Ok((ids, own.steps(self), own.kernel(), own.bytes()))
        };
        // All are kept, so that the first that is wrong is told, whichever thread found it.
        let all: Vec<Result<_>> = (0..cells).into_par_iter().map(of_cell).collect();
        let mut plan = Plan {
            ids: Vec::with_capacity(self.runs()),
            steps: Vec::with_capacity(cells),
            kernels: Vec::with_capacity(cells),
            bytes: 0,
        };
        for cell in all {
            let (ids, steps, kernel, bytes) = cell?;
            plan.ids.extend(ids);
            plan.steps.push(steps);
            plan.kernels.push(kernel);
            plan.bytes = plan.bytes.max(bytes);
        }
        self.refuse_twins(&plan)?;
        Ok(plan)
    }

    /// Cells that come out equal, such as those of 20 and 20.0.
    fn refuse_twins(&self, plan: &Plan) -> Result {
        let mut order: Vec<RunIndex> = (0..plan.ids.len() as RunIndex).collect();
        order.par_sort_unstable_by_key(|&run| (*plan.ids[run as usize].as_bytes(), run));
        let is_twin = |pair: &&[RunIndex]| plan.ids[pair[0] as usize] == plan.ids[pair[1] as usize];
        let Some(&[one, other]) = order.array_windows().find(|pair| is_twin(&pair.as_slice())) else {
            return Ok(());
        };
        let values = |run| self.described(self.cell_of(run));
        let place = self
            .file
            .values(self.cell_of(other))
            .first()
            .map(|(_, place)| place.clone());
        Err(Failure::input(format_args!(
            "{}: {} and {} are one experiment; allowed: cells that differ",
            place.unwrap_or_else(|| self.path.display().to_string()),
            values(one),
            values(other)
        )))
    }

    /// A cell in words: its keys and their values.
    pub(crate) fn described(&self, cell: usize) -> String {
        let values = self.file.keys().zip(self.file.values(cell));
        let words: Vec<String> = values.map(|(key, (value, _))| format!("{key} = {value}")).collect();
        words.join(", ")
    }
}
