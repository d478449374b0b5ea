//! Genomes given on the command line: files, runs and sweeps.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use oneiro::world::GeneLayout;
use oneiro_base::console::Console;
use oneiro_base::exit::{Failure, Result};
use oneiro_evolve::Population;
use oneiro_lab::experiment::kinds::is_sweep;
use oneiro_lab::experiment::source::Setting;
use oneiro_lab::experiment::{Difference, Experiment};
use oneiro_lab::genomes;
use oneiro_lab::record::SingleRun;
use oneiro_lab::sweep::champions::Champions;
use rayon::prelude::*;

use super::list;
use super::places::{RUNS, SWEEPS, found};

/// Genomes and their sources.
pub(super) struct Subjects {
    pub(super) genomes: Population,
    /// Paths, with the row if there are several: `genomes.npy[3]`.
    pub(super) sources: Vec<String>,
}

/// A kind of source.
pub(super) enum Named {
    /// A file of genomes.
    File(PathBuf),
    /// A run of single robots.
    Run(Box<SingleRun>),
    /// A sweep of single robots.
    Sweep(Box<Champions>),
}

/// The genomes to take from a run; from a sweep, always the champions.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Which {
    Champion,
    LastGeneration,
    /// The champion, the luckiest and the last generation, or every individual that ever lived.
    All {
        individuals: bool,
    },
}

impl Named {
    /// Examines paths: a directory is a run's, a sweep's, or one that holds runs, which are then taken in the order of
    /// their numbers.
    ///
    /// # Errors
    /// Exit 3: a directory without a run, a sweep that has no tables yet, something with swarms, or the same thing twice.
    pub(super) fn all(paths: &[PathBuf], console: Console) -> Result<Vec<Self>> {
        let mut all = Vec::new();
        for path in paths {
            // A missing one is refused before it is asked which experiment it is of.
            let path = found(path, &[RUNS, SWEEPS], console)?;
            if is_sweep(&path) {
                all.push(Self::Sweep(Box::new(Champions::open(&path)?)));
            } else if path.is_dir() {
                for directory in list::runs(&path)? {
                    all.push(Self::Run(Box::new(SingleRun::open(&directory)?)));
                }
            } else {
                fs::metadata(&path).map_err(|error| Failure::unreadable(&path, &error))?;
                all.push(Self::File(path));
            }
        }
        let mut known = BTreeSet::new();
        for path in all.iter().map(Self::path) {
            if !known.insert(path.canonicalize().unwrap_or_else(|_| path.to_owned())) {
                return Err(Failure::input(format_args!(
                    "--genomes: {} is named twice; allowed: each file, run and sweep once",
                    path.display()
                )));
            }
        }
        Ok(all)
    }

    fn path(&self) -> &Path {
        match self {
            Self::File(path) => path,
            Self::Run(run) => run.directory(),
            Self::Sweep(champions) => champions.path(),
        }
    }
}

/// Values that experiments must share.
#[derive(Clone, Copy)]
pub(super) struct Common {
    /// Whether the combination of several lives must agree, too.
    pub(super) scores: bool,
    /// Whether they have their values of tests.
    pub(super) test: bool,
}

impl Common {
    /// The experiment that runs and sweeps share, with settings that override its values.
    ///
    /// # Errors
    /// Exit 2 if there is no run and no sweep; exit 3 if their experiments differ, with the key.
    pub(super) fn experiment(self, named: &[Named], set: &[String]) -> Result<Experiment> {
        let typed = Setting::all_typed(set)?;
        let mut first: Option<(String, Experiment)> = None;
        for named in named {
            let (name, own) = match named {
                Named::File(_) => continue,
                Named::Run(run) => (
                    run.directory().display().to_string(),
                    self.of(Experiment::read(&run.config(), set)?)?,
                ),
                Named::Sweep(champions) => self.of_sweep(champions, &typed)?,
            };
            let Some((known, experiment)) = &first else {
                first = Some((name, own));
                continue;
            };
            if let Some(difference) = experiment.difference(&own, self.scores) {
                return Err(Self::refused(known, &name, &difference));
            }
        }
        match (first, named) {
            (Some((_, experiment)), _) => Ok(experiment),
            (None, [Named::File(path), ..]) => Err(Failure::usage(format_args!(
                "{}: does not name its experiment; allowed: genomes from run directories, or an experiment before --genomes",
                path.display()
            ))),
            (None, _) => Err(Failure::usage("nothing is named")),
        }
    }

    /// An experiment as these genomes are evaluated in it.
    ///
    /// # Errors
    /// As [`Experiment::tested_in`].
    pub(super) fn of(self, experiment: Experiment) -> Result<Experiment> {
        if self.test {
            experiment.tested_in().cloned()
        } else {
            Ok(experiment)
        }
    }

    /// The experiment that the cells of a sweep share, and the name of the first cell.
    fn of_sweep(self, champions: &Champions, set: &[Setting]) -> Result<(String, Experiment)> {
        let sweep = &champions.sweep;
        let of_cell = |cell| self.of(sweep.single_of(cell, set)?);
        let first = of_cell(0)?;
        let path = champions.path().display();
        let compared = |cell| Ok(first.difference(&of_cell(cell)?, self.scores));
        // All are collected first, so that the error is always the first difference, whichever thread found it.
        let differences: Vec<Result<_>> = (1..sweep.file().cells()).into_par_iter().map(compared).collect();
        for (difference, cell) in differences.into_iter().zip(1..) {
            if let Some(difference) = difference? {
                let [one, other] = [0, cell].map(|cell| format!("({})", sweep.described(cell)));
                return Err(Self::refused(&format!("{path}: the cells {one}"), &other, &difference));
            }
        }
        let name = match sweep.described(0) {
            words if words.is_empty() => path.to_string(),
            words => format!("{path} ({words})"),
        };
        Ok((name, first))
    }

    fn refused(one: &str, other: &str, Difference { key, values: [a, b] }: &Difference) -> Failure {
        Failure::input(format_args!(
            "{one} and {other} come from different experiments ({key}: {a} / {b}); allowed: runs of one experiment, an experiment \
             before --genomes, or --set {key}=VALUE"
        ))
    }
}

impl Subjects {
    /// Reads the genomes for a controller, by the names of their genes where they have any.
    ///
    /// # Errors
    /// As [`genomes::read`]; exit 3 if a run's controller has other genes; as [`SingleRun::champion`].
    pub(super) fn read(named: &[Named], layout: &GeneLayout, which: Which, console: Console) -> Result<Self> {
        let genes = layout.genes();
        let (mut values, mut sources) = (Vec::new(), Vec::new());
        let mut add = |path: &Path, population: &Population| {
            let path = path.display();
            match population.len() {
                1 => sources.push(path.to_string()),
                rows => sources.extend((0..rows).map(|row| format!("{path}[{row}]"))),
            }
            values.extend_from_slice(population.values());
        };
        for named in named {
            match named {
                Named::File(path) => add(path, &genomes::read(path, layout, |word| console.say(word))?),
                Named::Sweep(champions) => add(champions.path(), &champions.genomes(layout)?),
                Named::Run(run) => {
                    let directory = run.directory();
                    let all = match which {
                        Which::Champion => vec![(directory.to_owned(), run.champion()?.alone())],
                        Which::LastGeneration => vec![(directory.to_owned(), run.population()?)],
                        Which::All { individuals } => {
                            let all = run.all_genomes(individuals)?.into_iter();
                            all.map(|(file, population)| (directory.join(file), population))
                                .collect()
                        }
                    };
                    let own = run.experiment()?.world().gene_layout();
                    for (path, population) in all {
                        add(&path, &genomes::by_name(&path, own, population, layout)?);
                    }
                }
            }
        }
        Ok(Self {
            genomes: Population::new(genes, values),
            sources,
        })
    }

    /// Adds random genomes.
    pub(super) fn with_random(mut self, random: &Population) -> Self {
        self.sources
            .extend((0..random.len()).map(|row| format!("random[{row}]")));
        let values = [self.genomes.values(), random.values()].concat();
        self.genomes = Population::new(random.genes(), values);
        self
    }

    /// Removes duplicate genomes, keeping the first source of each.
    pub(super) fn distinct(self) -> Self {
        let mut known = BTreeSet::new();
        let bits = |genome: &[f32]| genome.iter().map(|gene| gene.to_bits()).collect::<Vec<_>>();
        let genomes = self.genomes.genomes().zip(self.sources);
        let (values, sources): (Vec<&[f32]>, _) = genomes.filter(|(genome, _)| known.insert(bits(genome))).unzip();
        Self {
            genomes: Population::new(self.genomes.genes(), values.concat()),
            sources,
        }
    }
}
