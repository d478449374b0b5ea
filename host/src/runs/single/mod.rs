//! Evolutions of single robots.
//!
//! | file | contents |
//! |---|---|
//! | [`job`] | the state machine: generations, reality, the champion's trace |
//! | [`mod@rows`], [`individuals`], [`mod@champion`], [`trace`], [`pictures`] | the files of a run |
//! | [`check`], [`replay`], [`audit`] | the commands of these names for such runs |

mod audit;
mod champion;
mod check;
mod individuals;
pub(crate) mod job;
mod pictures;
mod replay;
mod rows;
pub(crate) mod trace;

use std::path::Path;
use std::sync::{Arc, OnceLock};

use oneiro::batch::Worlds;
use serde_json::json;

use super::{Audit, Column, Holds, Reality, Recorded, Recording, Replay, Shown, Summary, Table};
use crate::console::{Console, decimal};
use crate::engine::disk;
use crate::engine::handle::Engine;
use crate::engine::job::{Job, Place};
use crate::evolve::{Champion, Population};
use crate::exit::{Failure, Result};
use crate::experiment::{Experiment, Identities, Input};
use crate::genomes;
use crate::reality::site::Site;
use crate::report::numbers::significant;
use champion::IndividualFile;
use individuals::Individuals;
use job::Evolving;
use rows::Row;

const GENERATIONS: &str = "generations.csv";
const INDIVIDUALS: &str = "individuals.npy";
const CHAMPION: &str = "champion.json";
const CHAMPION_GENES: &str = "champion.npy";
const LUCKIEST: &str = "luckiest.json";
const LUCKIEST_GENES: &str = "luckiest.npy";
const POPULATION: &str = "population.npy";
const FITNESS: &str = "fitness.npy";
const TRACE: &str = "trace.csv";
const PATH: &str = "path.svg";
const LEARNING_CURVE: &str = "learning-curve.svg";

/// Best single score of the run and the individual that reached it; of the last generation, the mean score of the
/// parents and of all; the number of NaN scores in the whole run; the champion's mean, its 95 % confidence interval,
/// and its number. Without finalists the champion's cells are empty: it has the best score.
const OUTCOMES: [Column; 11] = [
    ("best", Holds::Number),
    ("best_generation", Holds::Whole),
    ("best_individual", Holds::Whole),
    ("peak", Holds::Number),
    ("mean", Holds::Number),
    ("nan", Holds::Whole),
    ("champion_mean", Holds::Number),
    ("champion_low", Holds::Number),
    ("champion_high", Holds::Number),
    ("champion_generation", Holds::Whole),
    ("champion_individual", Holds::Whole),
];
/// Of the last offspring, which were never selected: mean fitness in the simulator, mean and best fitness in reality.
const OUTCOMES_OF_REALITY: [Column; 3] = [
    ("simulated", Holds::Number),
    ("real", Holds::Number),
    ("real_best", Holds::Number),
];
const COLUMNS: [Column; 9] = [
    ("generation", Holds::Whole),
    ("best", Holds::Number),
    ("peak", Holds::Number),
    ("mean", Holds::Number),
    ("least", Holds::Number),
    ("deviation", Holds::Number),
    ("individual", Holds::Whole),
    ("nan", Holds::Whole),
    ("best_bits", Holds::Text),
];

/// An experiment with single robots.
#[derive(Debug)]
pub(crate) struct Single {
    experiment: Experiment,
    /// Robots that evaluate the last offspring in reality.
    sites: Vec<Site>,
    /// Made when the first run begins.
    places: OnceLock<Arc<Places>>,
}

/// The worlds of runs.
#[derive(Debug)]
struct Places {
    simulator: Place,
    /// One world for each robot.
    reality: Vec<Place>,
}

impl Single {
    pub(super) fn new(experiment: Experiment, reality: Option<Reality<'_>>) -> Self {
        Self {
            experiment,
            sites: reality.map_or_else(Vec::new, |reality| reality.sites),
            places: OnceLock::new(),
        }
    }

    fn places(&self) -> Result<Arc<Places>> {
        if let Some(places) = self.places.get() {
            return Ok(Arc::clone(places));
        }
        let key = self.experiment.world_identity();
        let simulator = self.experiment.world();
        let real = |site: &Site| {
            Ok(Place {
                key: blake3::hash(&[*key.as_bytes(), *site.hash().as_bytes()].concat()),
                world: Arc::new(site.world(simulator.spec())?),
            })
        };
        let places = Places {
            reality: self.sites.iter().map(real).collect::<Result<_>>()?,
            simulator: Place {
                key,
                world: Arc::new(simulator.clone()),
            },
        };
        Ok(Arc::clone(self.places.get_or_init(|| Arc::new(places))))
    }

    fn has_reality(&self) -> bool {
        !self.sites.is_empty()
    }
}

/// Reads the champion of a finished run.
///
/// # Errors
/// Exit 5 if the files aren't what was written.
pub(crate) fn champion(run: &Recorded<'_>, experiment: &Experiment) -> Result<Champion> {
    let controller = experiment.world().spec().controller;
    champion::read(run.directory, [CHAMPION, CHAMPION_GENES], controller)
}

/// The genomes that a finished run has recorded and the files that have them: the champion, the luckiest if there are
/// finalists, and the last generation, or instead of it every individual that ever lived.
///
/// # Errors
/// As [`champion()`]; exit 1 where individuals are wanted and were not recorded.
pub(crate) fn all_genomes(
    run: &Recorded<'_>,
    experiment: &Experiment,
    individuals: bool,
) -> Result<Vec<(&'static str, Population)>> {
    let controller = experiment.world().spec().controller;
    let mut all = vec![(CHAMPION_GENES, champion(run, experiment)?.alone())];
    if experiment.finalists() > 0 {
        let luckiest = champion::read(run.directory, [LUCKIEST, LUCKIEST_GENES], controller)?;
        all.push((LUCKIEST_GENES, luckiest.alone()));
    }
    all.push(if individuals {
        let individuals = Individuals::read(run.directory, experiment)?;
        (INDIVIDUALS, individuals.genomes())
    } else {
        (POPULATION, population(run, experiment)?)
    });
    Ok(all)
}

/// Reads the last generation of a finished run.
///
/// # Errors
/// As [`champion()`].
pub(crate) fn population(run: &Recorded<'_>, experiment: &Experiment) -> Result<Population> {
    let controller = experiment.world().spec().controller;
    genomes::read(&run.directory.join(POPULATION), controller).map_err(Failure::corrupt)
}

/// Reads a run's table of generations.
fn rows(directory: &Path) -> Result<Vec<Row>> {
    let path = directory.join(GENERATIONS);
    let rows = Row::parse(&disk::read_text(&path)?);
    rows.map_err(|problem| Failure::corrupt(format_args!("{}: {problem}", path.display())))
}

impl super::Experiment for Single {
    fn name(&self) -> &str {
        self.experiment.name()
    }

    fn single(&self) -> Option<&Experiment> {
        Some(&self.experiment)
    }

    fn seed(&self) -> Option<u64> {
        self.experiment.settings().seed
    }

    fn warnings(&self) -> &[String] {
        self.experiment.warnings()
    }

    fn inputs(&self) -> &[Input] {
        self.experiment.inputs()
    }

    fn resolved_toml(&self, seed: u64) -> String {
        self.experiment.resolved_toml(seed)
    }

    fn identities(&self) -> Identities {
        self.experiment.identities()
    }

    fn length(&self) -> u32 {
        self.experiment.settings().evolution.generations
    }

    fn steps(&self) -> u64 {
        let settings = self.experiment.settings();
        let generation = u64::from(settings.evolution.population) * u64::from(settings.world.cycles);
        // The last offspring live once more in the simulator, and in reality.
        let reality = match self.sites.len() as u64 {
            0 => 0,
            robots => 1 + robots,
        };
        self.experiment
            .steps()
            .saturating_add(generation.saturating_mul(reality))
    }

    fn kernel(&self) -> &'static str {
        self.experiment.world().kernel().name
    }

    fn bytes(&self) -> u64 {
        let evolution = &self.experiment.settings().evolution;
        let genes = self.experiment.world().genes() as u64;
        // Parents, offspring and a batch's inputs, and one row of the table per generation.
        3 * u64::from(evolution.population) * genes * 4 + u64::from(evolution.generations) * 64
    }

    fn sample(&self) -> Result<Worlds> {
        Ok(Worlds::new(std::slice::from_ref(self.experiment.world()))?)
    }

    fn job(self: Arc<Self>, seed: u64, recording: Recording) -> Result<Box<dyn Job>> {
        Ok(Box::new(Evolving::new(self, seed, recording)?))
    }

    fn restored(self: Arc<Self>, seed: u64, recording: Recording, saved: &[u8]) -> Result<Box<dyn Job>> {
        Ok(Box::new(Evolving::new(self, seed, recording)?.restored(saved)?))
    }

    fn tables(&self, recording: Recording) -> Vec<Table> {
        let mut tables = vec![Table {
            file: GENERATIONS,
            head: Row::HEAD.into(),
        }];
        if recording == Recording::Directory && self.experiment.settings().record.individuals {
            tables.push(Table {
                file: INDIVIDUALS,
                head: Individuals::header(&self.experiment),
            });
        }
        tables
    }

    fn results(&self) -> &'static [&'static str] {
        const ALL: [&str; 7] = [
            GENERATIONS,
            CHAMPION,
            CHAMPION_GENES,
            POPULATION,
            FITNESS,
            LUCKIEST,
            LUCKIEST_GENES,
        ];
        match self.experiment.finalists() {
            0 => &ALL[..5],
            _ => &ALL,
        }
    }

    fn outcomes(&self) -> Vec<Column> {
        let reality: &[Column] = if self.has_reality() { &OUTCOMES_OF_REALITY } else { &[] };
        [&OUTCOMES, reality].concat()
    }

    fn columns(&self) -> &'static [Column] {
        &COLUMNS
    }

    fn shown(&self) -> Shown {
        let by = if self.has_reality() {
            ("real", "mean fitness of the last offspring in reality")
        } else {
            ("peak", "mean fitness of the last generation's parents")
        };
        Shown {
            by,
            time: ("generation", "generation"),
            value: ("peak", "mean fitness of the parents"),
        }
    }

    fn summary(&self, run: &Recorded<'_>) -> Result<Summary> {
        let file = champion::read_file(run.directory, CHAMPION)?;
        let fitness = file.score(run.directory)?;
        let IndividualFile {
            mean,
            interval,
            lives,
            generation,
            individual,
            ..
        } = file;
        let nan: u64 = rows(run.directory)?.iter().map(|row| u64::from(row.nan)).sum();
        let bits = format!("{:08x}", fitness.to_bits());
        let warning = format!("{}: {nan} scores were NaN; they ranked last", run.directory.display());
        let mut values = vec![
            ("fitness", decimal(fitness)),
            ("bits", json!(bits)),
            ("generation", json!(generation)),
            ("individual", json!(individual)),
            ("nan", json!(nan)),
        ];
        let who = format!("individual {individual} of generation {generation}");
        let mut line = format!("fitness {fitness} (bits {bits}), {who}");
        let mut cells = vec![("fitness", fitness.to_string()), ("generation", generation.to_string())];
        if let Some(lives) = lives {
            let luckiest = champion::read_file(run.directory, LUCKIEST)?;
            values.push(("mean", json!(mean)));
            values.push(("interval", json!(interval)));
            values.push(("lives", json!(lives)));
            values.push(("luckiest", json!(luckiest.fitness.map(decimal))));
            let shown = |number: Option<f64>| number.map_or_else(|| "NaN".to_owned(), |number| significant(number, 6));
            let [low, high] = interval.map_or([None; 2], |bounds| bounds.map(Some)).map(shown);
            let mean = shown(mean);
            line = format!(
                "mean {mean} of {lives} lives (95 %: {low} to {high}), {who}\nluckiest  fitness {}, individual {} of \
                 generation {}",
                luckiest.fitness.unwrap_or(f32::NAN),
                luckiest.individual,
                luckiest.generation
            );
            cells.insert(0, ("mean", mean));
        }
        Ok(Summary {
            line: ("champion", line),
            values,
            cells,
            warnings: if nan > 0 { vec![warning] } else { Vec::new() },
        })
    }

    fn progress(&self, run: &Recorded<'_>) -> Result<(u32, Option<f32>)> {
        let rows = rows(run.directory)?;
        let numbers = rows.iter().map(|row| row.best).filter(|best| !best.is_nan());
        Ok((rows.len() as u32, numbers.reduce(f32::max)))
    }

    fn check(&self, picture: Option<&Path>, console: Console) -> Result {
        check::run(&self.experiment, picture, console)
    }

    fn replay(&self, run: &Recorded<'_>, replay: &Replay<'_>, engine: &Engine, console: Console) -> Result {
        replay::run(&self.experiment, run, replay, engine, console)
    }

    fn audit(&self, run: &Recorded<'_>, share: f64, engine: &Engine, console: Console) -> Result<Audit> {
        audit::run(&self.experiment, run, share, engine, console)
    }
}
