//! Sweeps: many runs of one experiment, with different values and seeds, as one job.
//!
//! A sweep is a list of runs: each cell, a point of its grid, from each seed. A run's id is the hash of its resolved
//! experiment and its seed, as in a run directory, so finished runs are recognised wherever they were done.
//!
//! | file | contents |
//! |---|---|
//! | [`mod@file`] | sweep files in TOML |
//! | [`estimate`] | duration on each device of this machine |
//! | [`work`] | a shard's runs, for the engine |
//! | [`journal`] | finished work of one process, on disk |
//! | [`store`] | a sweep's directory: its origin, and its shards' journals |
//! | [`tables`], `parquet` | the runs of all shards in one table |
//! | [`mod@champions`] | recorded champions |
//! | [`report`] | the page: curves, heat maps, champions, differences between cells |

pub mod champions;
pub mod contents;
pub mod estimate;
pub mod file;
pub mod journal;
#[cfg(feature = "parquet")]
mod parquet;
pub mod report;
pub mod store;
pub mod tables;
pub mod work;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use oneiro::world::GeneLayout;
use oneiro_base::contents::Column;
use oneiro_base::exit::{Failure, Result};
use rayon::prelude::*;

use crate::experiment::kinds::FileKind;
use crate::experiment::source::{Parsed, Setting};
use crate::experiment::{self, Content, Files};
use crate::reality::site::Site;
use crate::reality::wired::Time;
use crate::runs::{self, Experiment, Reality, Recording, Robots, Shown, Table};
use file::SweepFile;

/// Index of a run: by cell, then by seed.
pub type RunIndex = u32;

/// A sweep and its experiment.
#[derive(Debug)]
pub struct Sweep {
    path: PathBuf,
    file: SweepFile,
    /// Path and text of the experiment's file.
    experiment: PathBuf,
    text: String,
    files: Files,
}

/// All runs of a sweep in brief.
#[derive(Debug)]
pub struct Plan {
    /// Id of each run.
    pub ids: Vec<blake3::Hash>,
    /// Robot-steps of one run of each cell.
    pub steps: Vec<u64>,
    /// Episodes of one run of each cell: the budget if there is one, else those that its values make; none for swarms of the foraging
    /// study.
    pub episodes: Vec<Option<u64>>,
    /// Those of its evolution alone, without finalists.
    pub spent: Vec<Option<u64>>,
    /// First kernel of each cell's runs.
    pub kernels: Vec<&'static str>,
    /// Maximum memory of a run of any cell, in bytes.
    pub bytes: u64,
    /// Columns of the results of runs: those of the first cell, then those that only others have.
    pub outcomes: Vec<Column>,
    /// Each run's table of steps, and its columns.
    pub table: Table,
    pub columns: &'static [Column],
    /// Genes of each cell's controllers; `None` for swarms.
    pub(crate) layouts: Vec<Option<GeneLayout>>,
    /// Columns that reports show.
    pub shown: Shown,
    /// Time that all runs take connected robots, if any end there.
    pub robot_time: Option<Time>,
}

impl Plan {
    /// Total robot-steps of some runs.
    pub fn steps(&self, sweep: &Sweep, runs: impl Iterator<Item = RunIndex>) -> u64 {
        runs.map(|run| self.steps[sweep.cell_of(run)])
            .fold(0, u64::saturating_add)
    }
}

impl Sweep {
    /// Reads a sweep file and the experiment that it names.
    ///
    /// # Errors
    /// Exit 3: the file, the line and column in it, the problem and the allowed values.
    pub fn read(path: &Path) -> Result<Self> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let file = SweepFile::read(path, folder)?;
        let experiment = folder.join(&file.experiment);
        Self::of(path, file, experiment)
    }

    /// Reads a moved sweep: `name` is its former name, `experiment` its experiment's path, and `folder` has the other files that
    /// it names.
    ///
    /// # Errors
    /// As [`Sweep::read`].
    pub fn moved(name: &str, path: &Path, experiment: PathBuf, folder: &Path) -> Result<Self> {
        let mut file = SweepFile::read(path, folder)?;
        file.name = name.into();
        Self::of(path, file, experiment)
    }

    fn of(path: &Path, file: SweepFile, experiment: PathBuf) -> Result<Self> {
        let at = |failure: Failure| failure.at(&format!("{}: experiment", file.experiment_place));
        let text = FileKind::Experiment.text(&experiment).map_err(at)?;
        // Not TOML at all is refused where its values are read.
        if let Ok(values) = Parsed::new(String::new(), &text) {
            FileKind::Experiment.must_be(&experiment, &values).map_err(at)?;
        }
        Ok(Self {
            path: path.to_owned(),
            file,
            experiment,
            text,
            files: Files::default(),
        })
    }

    /// Name of the sweep.
    pub fn name(&self) -> &str {
        &self.file.name
    }

    /// Path of its file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Contents of its file.
    pub fn file(&self) -> &SweepFile {
        &self.file
    }

    /// Path and text of the experiment's file.
    pub fn experiment(&self) -> (&Path, &str) {
        (&self.experiment, &self.text)
    }

    /// Files that cells have named so far: those of the sweep's file, or those of the experiment's.
    pub fn files(&self, of_sweep: bool) -> Vec<(String, Arc<Content>)> {
        self.files.named(of_sweep)
    }

    /// Number of runs.
    pub fn runs(&self) -> usize {
        self.file.cells() * self.file.seeds.len()
    }

    /// A run's cell.
    pub fn cell_of(&self, run: RunIndex) -> usize {
        run as usize / self.file.seeds.len()
    }

    /// A run's seed.
    pub fn seed_of(&self, run: RunIndex) -> u64 {
        let index = run as usize % self.file.seeds.len();
        let mut seeds = self.file.seeds_of(self.cell_of(run));
        seeds.nth(index).expect("a cell has as many seeds as the file")
    }

    /// Loads the experiment of a cell.
    ///
    /// # Errors
    /// Exit 3 with the place of the value that isn't allowed, in the sweep's file or in the experiment's.
    pub fn cell(&self, cell: usize) -> Result<Arc<dyn Experiment>> {
        self.cell_of_file(&self.parsed()?, cell)
    }

    /// Loads the experiment of a cell as for a single run: without reality.
    ///
    /// # Errors
    /// As [`Sweep::cell`].
    pub fn experiment_of(&self, cell: usize) -> Result<Arc<dyn Experiment>> {
        runs::of(
            &self.experiment,
            &self.parsed()?,
            &self.file.settings(cell),
            &self.files,
            None,
        )
    }

    /// Loads the experiment of a cell of single robots, with settings that override its values.
    ///
    /// # Errors
    /// As [`Sweep::cell`].
    pub fn single_of(&self, cell: usize, set: &[Setting]) -> Result<experiment::Experiment> {
        let all = [&self.file.settings(cell), set].concat();
        experiment::Experiment::of(&self.experiment, &self.parsed()?, &all, &self.files)
    }

    /// Parses the experiment's values.
    fn parsed(&self) -> Result<Parsed<'_>> {
        Parsed::new(self.experiment.display().to_string(), &self.text)
    }

    fn cell_of_file(&self, experiment: &Parsed<'_>, cell: usize) -> Result<Arc<dyn Experiment>> {
        let reality = self.file.reality.as_ref().map(|reality| Reality {
            robots: match &reality.robots {
                file::Robots::Own(_) => Robots::Own,
                file::Robots::Numbered(robots) => {
                    let drawn = robots.iter().map(|&robot| Site::drawn(robot, reality.severity()));
                    Robots::Others(drawn.collect())
                }
            },
            place: &self.file.reality_place,
        });
        runs::of(
            &self.experiment,
            experiment,
            &self.file.settings(cell),
            &self.files,
            reality,
        )
    }

    /// Checks all cells and lists all runs.
    ///
    /// # Errors
    /// Exit 3: the first value that isn't allowed, or two equal runs.
    pub fn plan(&self) -> Result<Plan> {
        self.plan_of(|own| own.check_sweep())
    }

    /// As [`Self::plan`], but also for runs that end on connected robots, which can't run as a sweep.
    ///
    /// # Errors
    /// As [`Sweep::plan`].
    pub fn plan_on_robots(&self) -> Result<Plan> {
        self.plan_of(|own| match own.robot_time() {
            Some(_) => Ok(()),
            None => own.check_sweep(),
        })
    }

    fn plan_of(&self, check: impl Fn(&dyn Experiment) -> Result + Sync) -> Result<Plan> {
        let cells = self.file.cells();
        let experiment = self.parsed()?;
        let of_cell = |cell: usize| {
            let own = self.cell_of_file(&experiment, cell)?;
            check(&*own)?;
            let identities = own.identities();
            let ids: Vec<_> = self.file.seeds_of(cell).map(|seed| identities.of(seed)).collect();
            let layout = own.single().map(|single| single.world().gene_layout().clone());
            let outcomes = own.outcomes();
            let left_out = own.left_out().clone();
            Ok((
                ids,
                own.steps(),
                own.kernel(),
                own.bytes(),
                layout,
                own.shown(),
                outcomes,
                left_out,
                own.robot_time(),
                own.episodes(),
                own.single().map(|single| single.episodes().generations),
            ))
        };
        // All are collected first, so that the error is always the first one, whichever thread found it.
        let all: Vec<Result<_>> = (0..cells).into_par_iter().map(of_cell).collect();
        let first = self.cell_of_file(&experiment, 0)?;
        let mut plan = Plan {
            ids: Vec::with_capacity(self.runs()),
            steps: Vec::with_capacity(cells),
            episodes: Vec::with_capacity(cells),
            spent: Vec::with_capacity(cells),
            kernels: Vec::with_capacity(cells),
            bytes: 0,
            outcomes: first.outcomes(),
            columns: first.columns(),
            table: first.tables(Recording::Tables).swap_remove(0),
            layouts: Vec::with_capacity(cells),
            shown: first.shown(),
            robot_time: None,
        };
        // Why values were left out, and in how many of the cells that have them.
        let mut unused: BTreeMap<_, (String, usize)> = BTreeMap::new();
        for (cell, of_cell) in all.into_iter().enumerate() {
            let (ids, steps, kernel, bytes, layout, shown, outcomes, left_out, robots, episodes, spent) = of_cell?;
            for (path, refusal) in left_out {
                let place = self.file.place_in(cell, &path);
                unused.entry((path, place)).or_insert((refusal, 0)).1 += 1;
            }
            if let Some(time) = robots {
                plan.robot_time = Some(plan.robot_time.unwrap_or_default().and(ids.len(), time));
            }
            for column in outcomes {
                if plan.outcomes.iter().all(|known| known.name != column.name) {
                    plan.outcomes.push(column);
                }
            }
            if shown.by != plan.shown.by && !shown.needs_finalists() {
                // Not all cells have the outcome of the first.
                plan.shown = shown;
            }
            plan.ids.extend(ids);
            plan.steps.push(steps);
            plan.episodes.push(episodes);
            plan.spent.push(spent);
            plan.kernels.push(kernel);
            plan.layouts.push(layout);
            plan.bytes = plan.bytes.max(bytes);
        }
        let having = |path: &str, place: Option<&str>| place.map_or(cells, |place| self.file.cells_with(path, place));
        let unused = unused
            .into_iter()
            .find(|((path, place), (_, unused))| *unused >= having(path, *place));
        if let Some((_, (refusal, _))) = unused {
            return Err(Failure::input(format_args!("{refusal}; no cell of the sweep uses it")));
        }
        self.refuse_twins(&plan)?;
        Ok(plan)
    }

    /// Refuses equal cells, such as those of 20 and 20.0.
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
            .into_iter()
            .flatten()
            .next()
            .map(|(_, place)| place.clone());
        Err(Failure::input(format_args!(
            "{}: {} and {} are one experiment; allowed: cells that differ",
            place.unwrap_or_else(|| self.path.display().to_string()),
            values(one),
            values(other)
        )))
    }

    /// Description of a cell: its keys and their values.
    pub fn described(&self, cell: usize) -> String {
        let values = self.file.keys().zip(self.file.values(cell));
        let words = values.filter_map(|(key, value)| Some(format!("{key} = {}", value?.0)));
        words.collect::<Vec<_>>().join(", ")
    }
}
