//! Evolutions of single robots.
//!
//! | file | contents |
//! |---|---|
//! | [`job`] | the state machine: generations, reality, the champion's trace |
//! | [`mod@outcomes`] | a run's values in a sweep's table |
//! | [`mod@rows`], [`individuals`], [`mod@champion`], [`trace`], [`pictures`], [`mod@report`] | the files of a run |
//! | [`on_board`] | the same evolution on a robot's computer, while the robot runs |
//! | [`scene`] | what `oneiro watch` shows of a generation |
//! | [`check`], [`replay`] with [`elites`], [`audit`] | `oneiro check`, `replay` and `verify --recompute` for such runs |

mod archive;
mod arithmetic;
mod audit;
mod behaviour;
mod champion;
mod check;
mod elites;
mod individuals;
pub mod job;
mod learning;
#[cfg(all(unix, feature = "compose"))]
pub mod on_board;
mod outcomes;
mod pictures;
pub(crate) mod race;
mod realities;
mod replay;
mod report;
mod rows;
mod scene;
mod together;
pub mod trace;
mod transferred;

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::sync::{Arc, OnceLock};

use oneiro::automode::Form;
use oneiro::batch::{WorldKind, Worlds};
use oneiro::world::{Noise, Start, World, WorldSpec};
use oneiro_base::answer::Answer;
use oneiro_base::console::{Bars, counted, decimal};
use oneiro_base::contents::{self, Column, Entry};
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_base::plain;
use oneiro_evolve::{Champion, Kind, Population};
use oneiro_report::numbers::significant;
use serde_json::json;

use super::{Audit, CHAMPION_MEAN, Reality, Recorded, Recording, Replay, Robots, Scene, Shown, Summary, Table, Work};
use crate::engine::handle::Engine;
use crate::engine::job::{Job, Place};
use crate::experiment::kinds::CHAMPION_GENES;
use crate::experiment::source::LeftOut;
use crate::experiment::{Experiment, Identities, Input};
use crate::genomes;
use crate::lives::worlds::{self, WorldTable};
use crate::reality::site::{LIVES, Site};
use crate::reality::wired::Time;
use champion::IndividualFile;
use individuals::Individuals;
use job::Evolving;
use rows::Row;
use trace::TraceTable;

const GENERATIONS: &str = "generations.csv";
/// The second of two populations, and the best of both in each generation.
const SECOND: &str = "second.csv";
pub const HALL: &str = "hall-of-fame.npy";
pub const TOURNAMENT: &str = "tournament.csv";
pub const TOURNAMENT_PICTURE: &str = "tournament.svg";
pub const TOURNAMENT_PROGRESS: &str = "tournament-progress.svg";
const INDIVIDUALS: &str = "individuals.npy";
const CHAMPION: &str = "champion.json";
/// A state machine's text.
const CHAMPION_TEXT: &str = "champion.txt";
const LUCKIEST_TEXT: &str = "luckiest.txt";
const LUCKIEST: &str = "luckiest.json";
const LUCKIEST_GENES: &str = "luckiest.npy";
const POPULATION: &str = "population.npy";
const FITNESS: &str = "fitness.npy";
const TRACE: &str = "trace.csv";
const COVERAGE: &str = "coverage.csv";
const BEHAVIOUR: &str = "behaviour.csv";
const ARCHIVE: &str = "archive.csv";
const ARCHIVE_GENES: &str = "archive.npy";
const ARCHIVE_PAGE: &str = "archive.html";
/// Files of a replay, without the episode's number and the extension.
const REPLAY: &str = "replay";

/// The files of a run's directory.
fn files(world: &World, has_finalists: bool, has_individuals: bool, has_trace: bool) -> Vec<Entry> {
    let mut all = vec![
        Entry::table(GENERATIONS, "one row per generation", &rows::COLUMNS),
        Entry::file(
            CHAMPION,
            "the champion: its score (as a number and as bits), the mean of its new episodes with a 95 % confidence interval, its \
             generation and index, the keys of its random numbers, and its genes; with their names if the run has finalists",
        ),
        Entry::file(CHAMPION_GENES, "its genes (f32)"),
    ];
    if has_finalists {
        let luckiest = "the same for the individual with the highest single score; only if there are finalists";
        all.push(Entry::file(LUCKIEST, luckiest));
        all.push(Entry::file(LUCKIEST_GENES, "its genes (f32)"));
    }
    all.push(Entry::file(
        POPULATION,
        "the last generation's genes (f32, individuals x genes)",
    ));
    all.push(Entry::file(FITNESS, "the last generation's fitness (f32)"));
    if has_individuals {
        all.push(Entry::file(
            INDIVIDUALS,
            "every individual of the run, with `record.individuals` (f32, generations x individuals x (genes + 1); the last number \
             is its fitness)",
        ));
    }
    if has_trace {
        let record =
            "the champion's first episode: one row per cycle, or per Nth cycle of an episode of more than 10,000";
        all.push(Entry::table(TRACE, record, TraceTable::new(world).columns()));
    }
    all
}

/// The texts of state machines and behaviour trees in a run's directory.
fn texts(has_finalists: bool) -> Vec<Entry> {
    let text = "with `controller.kind = \"state-machine\"` or `\"behaviour-tree\"`: the champion's text in AutoMoDe's form, also for `--genomes`";
    let mut all = vec![Entry::file(CHAMPION_TEXT, text)];
    if has_finalists {
        all.push(Entry::file(LUCKIEST_TEXT, "with it: the luckiest's text"));
    }
    all
}

/// The files of a run with an archive of elites.
fn archive_files(columns: &[Column]) -> [Entry; 4] {
    [
        Entry::table(
            COVERAGE,
            "the archive's growth: one row per generation",
            &archive::GROWTH,
        ),
        Entry::table(
            ARCHIVE,
            "the archive: one row per elite, with its behaviour in the last columns",
            columns,
        ),
        Entry::file(ARCHIVE_GENES, "its genes (f32, elites x genes), in the same order"),
        Entry::file(
            ARCHIVE_PAGE,
            "written by `oneiro replay --elites`: a page that shows the archive, and plays an episode of the clicked elite",
        ),
    ]
}

/// The file of a run whose optimiser uses behaviour.
fn behaviour_file() -> Entry {
    let about = "with `evolution.kind = \"map-elites\"` or `\"novelty\"`: individuals without a behaviour, one row per generation";
    Entry::table(BEHAVIOUR, about, &behaviour::COLUMNS)
}

/// The files of a run of two populations.
fn coevolution_files() -> [Entry; 5] {
    [
        Entry::table(
            SECOND,
            "with `evolution.kind = \"coevolution\"`: the second population, one row per generation; `generations.csv` has the first",
            &rows::COLUMNS,
        ),
        Entry::file(
            HALL,
            "with it: the best of both populations in each generation (f32, generations x genes), also for `--genomes`",
        ),
        Entry::file(
            TOURNAMENT,
            "written by `oneiro evaluate --tournament`: the first population's mean score of each pair; a row for each of its generations, and a \
             column `second_G` for each generation G of the second",
        ),
        Entry::file(TOURNAMENT_PICTURE, "written by it: a picture of that table"),
        Entry::file(
            TOURNAMENT_PROGRESS,
            "written by it: a picture of the mean score of each generation of both populations against all of the other",
        ),
    ]
}

/// The folder of a run that ends on a connected robot.
fn lives() -> Entry {
    let about =
        "every episode on a connected robot, with a `README.md`; only with `reality.robot`. `oneiro verify` ignores it";
    Entry::file(LIVES, about)
}

/// The files that `oneiro replay` adds, for one episode or for each of several.
fn replays(has_several: bool) -> [Entry; 6] {
    let (name, life) = if has_several {
        (format!("{REPLAY}-K"), "episode K of several, from 0")
    } else {
        (REPLAY.to_owned(), "the replayed episode")
    };
    let table = format!("written by `oneiro replay`: {life}, with the columns of `{TRACE}`");
    let picture = "written by `oneiro replay`: a picture of that episode";
    [
        Entry::file(
            format!("{name}.html"),
            format!("written by `oneiro replay`: a page that plays {life}"),
        ),
        Entry::file(format!("{name}.csv"), table),
        Entry::file(format!("{name}.svg"), picture),
        Entry::file(
            format!("{name}-WHAT.csv"),
            format!(
                "written by `oneiro replay` for another episode than the champion's recorded one: WHAT is `elite-CELL`, `generation-N`, \
                 `individual-K`, `genome-NAME`, `start-X_Y_HEADING`, `seed-N` and `test`, of the given options; with the columns of `{TRACE}`"
            ),
        ),
        Entry::file(format!("{name}-WHAT.svg"), picture),
        Entry::file(
            format!("{name}-WHAT.html"),
            "written by it: a page that plays that episode",
        ),
    ]
}

/// The page that it adds with recorded individuals.
fn learning_page() -> Entry {
    let page = "written by `oneiro replay --generations`: a page on which the bests of several generations drive from the same start";
    Entry::file(learning::LEARNING, page)
}

/// The table that it adds for swarms.
fn replays_together() -> Entry {
    let table = "written by `oneiro replay` of a swarm: one row per robot, with what it did in that episode";
    Entry::table("replay-robots.csv", table, &together::COLUMNS)
}

/// The files of the directory of any run.
#[cfg(any(test, feature = "testing"))]
pub fn all_contents() -> Vec<Entry> {
    let world = World::new(WorldSpec::miglino1995()).expect("it is the paper's");
    [
        &files(&world, true, true, true)[..],
        &pictures::entries(None).collect::<Vec<_>>(),
        &[super::report::entry()],
        &texts(true),
        &archive_files(&archive::ELITES),
        &[behaviour_file(), race::entry(), worlds::entry(&worlds::first_columns())],
        &coevolution_files(),
        &[lives()],
        &replays(false),
        &replays(true),
        &[replays_together(), learning_page()],
    ]
    .concat()
}

/// The columns of a run's table of steps.
#[cfg(any(test, feature = "testing"))]
pub fn all_steps() -> &'static [Column] {
    &rows::COLUMNS
}

/// The columns of runs' values in a sweep's table of results, for any sweep.
#[cfg(any(test, feature = "testing"))]
pub fn all_outcomes() -> Vec<Column> {
    outcomes::all()
}

/// An experiment with single robots.
#[derive(Debug)]
pub struct Single {
    experiment: Experiment,
    /// The robot that evaluates the last generations.
    robot: Option<Site>,
    /// Robots that evaluate the last offspring in reality.
    sites: Vec<Site>,
    /// Whether the robot's first generation is compared with its episodes in the simulator.
    is_compared: bool,
    /// Made when the first run begins.
    places: OnceLock<Arc<Places>>,
}

/// The worlds of runs.
#[derive(Debug)]
struct Places {
    simulator: Place,
    /// The world of the last generations, if it is another one.
    transfer: Option<Place>,
    /// One world for each robot that evaluates the last offspring.
    reality: Vec<Place>,
    /// Worlds that the robot's first generation is compared in, if it is.
    compared: Option<Compared>,
}

/// Further worlds of the robot's first generation.
#[derive(Debug)]
struct Compared {
    /// The simulator without noise.
    quiet: Place,
    /// The same, and reality, with one start for all episodes.
    quiet_path: Place,
    real_path: Place,
}

impl Single {
    pub(super) fn new(experiment: Experiment, reality: Option<Reality<'_>>) -> Self {
        let (sites, is_compared) = match reality.map(|reality| reality.robots) {
            None => (Vec::new(), false),
            Some(Robots::Others(sites)) => (sites, false),
            Some(Robots::Own) => (Vec::new(), true),
        };
        Self {
            robot: experiment.site(),
            experiment,
            sites,
            is_compared,
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
            transfer: match &self.robot {
                Some(site) if !site.is_wired() => Some(real(site)?),
                _ => None,
            },
            reality: self.sites.iter().map(real).collect::<Result<_>>()?,
            compared: match &self.robot {
                Some(site) if self.is_compared => Some(self.compared(site)?),
                _ => None,
            },
            simulator: Place {
                key,
                world: Arc::new(simulator.clone()),
            },
        };
        Ok(Arc::clone(self.places.get_or_init(|| Arc::new(places))))
    }

    /// The worlds that the first generation on a robot is compared in.
    fn compared(&self, site: &Site) -> Result<Compared> {
        let key = self.experiment.world_identity();
        let [x, y, heading] = transferred::START;
        let quiet = WorldSpec {
            noise: Noise::NONE,
            ..self.experiment.world().spec().clone()
        };
        let at_start = WorldSpec {
            start: Start::At { x, y, heading },
            ..quiet.clone()
        };
        let place = |what: &[u8], world: World| Place {
            key: blake3::hash(&[key.as_bytes(), site.hash().as_bytes(), what].concat()),
            world: Arc::new(world),
        };
        Ok(Compared {
            real_path: place(b"real path", site.world(&at_start)?),
            quiet_path: place(b"quiet path", World::new(at_start)?),
            quiet: place(b"quiet", World::new(quiet)?),
        })
    }

    /// The world of a generation's episodes.
    ///
    /// # Errors
    /// Exit 3 for a value that the world of the robot doesn't allow.
    fn world_of(&self, generation: u32) -> Result<World> {
        let simulator = self.experiment.world();
        let is_real = self.experiment.first_real().is_some_and(|first| generation >= first);
        match self.robot.as_ref().filter(|_| is_real) {
            Some(robot) => Ok(robot.world(simulator.spec())?),
            None => Ok(simulator.clone()),
        }
    }

    /// Whether a connected robot evaluates the last generation: its episodes can't be repeated.
    fn ends_outside(&self) -> bool {
        self.robot.as_ref().is_some_and(Site::is_wired)
    }

    fn has_reality(&self) -> bool {
        !self.sites.is_empty()
    }
}

/// Reads the champion of a finished run.
///
/// # Errors
/// Exit 5 if the files aren't what was written.
pub fn champion(run: &Recorded<'_>, experiment: &Experiment) -> Result<Champion> {
    let layout = experiment.world().gene_layout();
    champion::read(run.directory, [CHAMPION, CHAMPION_GENES], layout)
}

/// The genomes that a finished run has recorded and the files that have them: the champion, the luckiest if there are finalists,
/// and the last generation, or every individual instead of it.
///
/// # Errors
/// As [`champion()`]; exit 1 where individuals are wanted and were not recorded.
pub fn all_genomes(
    run: &Recorded<'_>,
    experiment: &Experiment,
    individuals: bool,
) -> Result<Vec<(&'static str, Population)>> {
    let layout = experiment.world().gene_layout();
    let mut all = vec![(CHAMPION_GENES, champion(run, experiment)?.alone())];
    if experiment.finalists() > 0 {
        let luckiest = champion::read(run.directory, [LUCKIEST, LUCKIEST_GENES], layout)?;
        all.push((LUCKIEST_GENES, luckiest.alone()));
    }
    if experiment.settings().evolution.has_archive() {
        let elites = genomes::recorded(&run.directory.join(ARCHIVE_GENES), layout)?;
        all.push((ARCHIVE_GENES, elites));
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
pub fn population(run: &Recorded<'_>, experiment: &Experiment) -> Result<Population> {
    let layout = experiment.world().gene_layout();
    genomes::recorded(&run.directory.join(POPULATION), layout)
}

/// The number of individuals that have a measure that is NaN. Older runs didn't count them.
///
/// # Errors
/// Exit 5 if the table isn't what was written.
fn unmeasured(directory: &Path) -> Result<u64> {
    let path = directory.join(BEHAVIOUR);
    let Some(bytes) = disk::read_if_there(&path)? else {
        return Ok(0);
    };
    let mut table = csv::Reader::from_reader(&bytes[..]);
    let rows = table.deserialize::<BTreeMap<String, u64>>();
    let sum = rows.map(|row| row.ok()?.get("nan").copied()).sum::<Option<u64>>();
    sum.ok_or_else(|| Failure::corrupt(format_args!("{}: is not what was written", path.display())))
}

/// The best fitness of each generation of a run.
///
/// # Errors
/// Exit 5 if the table isn't what was written.
pub(crate) fn best_by_generation(directory: &Path) -> Result<Vec<f64>> {
    Ok(rows(directory)?.iter().map(|row| row.best.into()).collect())
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

    fn left_out(&self) -> &LeftOut {
        self.experiment.left_out()
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
        // The last offspring's further episodes in the simulator and in reality; or those of the robot's first generation in two
        // simulators.
        let reality = match self.sites.len() as u64 {
            0 if self.is_compared => 2,
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
        self.experiment.bytes()
    }

    fn robot_time(&self) -> Option<Time> {
        self.experiment.robot_time()
    }

    fn check_sweep(&self) -> Result {
        if self.ends_outside() {
            return Err(Failure::input(
                "reality.robot: is a connected robot; allowed: with `oneiro run`, which does one run at a time",
            ));
        }
        if self.is_compared {
            let Some(robot) = &self.robot else {
                return Err(Failure::input(
                    "reality.robots: is \"own\", and the experiment has no reality.robot; allowed: with one, a surrogate",
                ));
            };
            self.compared(robot).map_err(|failure| {
                let [x, y, _] = transferred::START;
                failure.at(&format!(
                    "reality.robots: is \"own\", where paths start at {x} and {y} mm"
                ))
            })?;
        }
        Ok(())
    }

    fn sample(&self) -> Result<Worlds> {
        Ok(Worlds::new(std::slice::from_ref(self.experiment.world()))?)
    }

    fn work(&self) -> Result<Vec<Work>> {
        let (places, settings) = (self.places()?, self.experiment.settings());
        let at_a_time = u64::from(settings.evolution.genomes_per_generation()) * u64::from(settings.trials);
        let world = self.experiment.world();
        let of_generation = at_a_time * u64::from(world.cycles()) * u64::from(world.robots());
        let work = |place: &Place, at_a_time: u64, steps: u64| -> Result<Work> {
            Ok(Work {
                worlds: Worlds::new(&[&*place.world as &dyn WorldKind])?,
                at_a_time,
                steps,
            })
        };
        // The generations on a surrogate are some of all.
        let generations = settings.reality.generations.filter(|_| places.transfer.is_some());
        let transferred = of_generation * u64::from(generations.unwrap_or_default());
        let simulated = self.steps().saturating_sub(transferred);
        let mut all = vec![work(&places.simulator, at_a_time, simulated)?];
        if let Some(place) = &places.transfer {
            all.push(work(place, at_a_time, transferred)?);
        }
        if let [place, ..] = &places.reality[..] {
            // The last generation again, in each of them.
            let realities = places.reality.len() as u64;
            all.push(work(place, at_a_time * realities, of_generation * realities)?);
        }
        Ok(all)
    }

    fn job(self: Arc<Self>, seed: u64, recording: Recording<'_>) -> Result<Box<dyn Job>> {
        Ok(Box::new(Evolving::new(self, seed, recording)?))
    }

    fn restored(self: Arc<Self>, seed: u64, recording: Recording<'_>, saved: &[u8]) -> Result<Box<dyn Job>> {
        Ok(Box::new(Evolving::new(self, seed, recording)?.restored(saved)?))
    }

    fn extended(&self, earlier: &dyn super::Experiment, seed: u64, saved: &[u8]) -> Result<Vec<u8>> {
        let earlier = earlier
            .single()
            .ok_or_else(|| Failure::failed("is no run of single robots"))?;
        job::extended(&self.experiment, earlier, seed, saved)
    }

    fn tables(&self, recording: Recording<'_>) -> Vec<Table> {
        let mut tables = vec![Table {
            file: GENERATIONS,
            head: contents::head(&rows::COLUMNS).into_bytes(),
        }];
        if self.experiment.settings().evolution.is_coevolution() {
            tables.push(Table {
                file: SECOND,
                head: contents::head(&rows::COLUMNS).into_bytes(),
            });
        }
        if matches!(recording, Recording::Directory { .. }) && self.experiment.settings().record.individuals {
            tables.push(Table {
                file: INDIVIDUALS,
                head: Individuals::header(&self.experiment),
            });
        }
        if matches!(recording, Recording::Directory { .. }) && self.experiment.settings().evolution.has_archive() {
            tables.push(Table {
                file: COVERAGE,
                head: contents::head(&archive::GROWTH).into_bytes(),
            });
        }
        if matches!(recording, Recording::Directory { .. }) && self.experiment.settings().evolution.uses_behaviour() {
            tables.push(Table {
                file: BEHAVIOUR,
                head: contents::head(&behaviour::COLUMNS).into_bytes(),
            });
        }
        if matches!(recording, Recording::Directory { .. }) && self.experiment.settings().evolution.kind == Kind::Race {
            tables.push(Table {
                file: race::FILE,
                head: race::head(),
            });
        }
        tables
    }

    fn results(&self) -> Vec<&'static str> {
        let evolution = &self.experiment.settings().evolution;
        let own: &[&str] = if evolution.has_archive() {
            &[ARCHIVE, ARCHIVE_GENES]
        } else if evolution.is_coevolution() {
            &[SECOND, HALL]
        } else {
            &[]
        };
        let all = [GENERATIONS, CHAMPION, CHAMPION_GENES, POPULATION, FITNESS];
        let luckiest: &[&str] = match self.experiment.finalists() {
            0 => &[],
            _ => &[LUCKIEST, LUCKIEST_GENES],
        };
        [own, &all, luckiest].concat()
    }

    fn contents(&self) -> Vec<Entry> {
        let settings = self.experiment.settings();
        let has_finalists = self.experiment.finalists() > 0;
        let (has_individuals, has_trace) = (settings.record.individuals, !self.ends_outside());
        let world = self.experiment.world();
        let mut files = files(world, has_finalists, has_individuals, has_trace);
        files.extend(pictures::entries(Some(self)));
        files.push(super::report::entry());
        if Form::of(world.gene_layout()).is_some() {
            files.extend(texts(has_finalists));
        }
        if settings.evolution.has_archive() {
            files.extend(archive_files(&archive::columns(&self.experiment)));
        }
        if settings.evolution.uses_behaviour() {
            files.push(behaviour_file());
        }
        files.extend(WorldTable::new(world).map(|table| worlds::entry(&table.columns())));
        if settings.evolution.kind == Kind::Race {
            files.push(race::entry());
        }
        if settings.evolution.is_coevolution() {
            files.extend(coevolution_files());
        }
        if self.ends_outside() {
            [files, vec![lives()]].concat()
        } else {
            if world.robots() > 1 {
                files.push(replays_together());
            }
            if settings.record.individuals && !settings.evolution.is_coevolution() {
                files.push(learning_page());
            }
            [&files[..], &replays(settings.trials > 1)].concat()
        }
    }

    fn outcomes(&self) -> Vec<Column> {
        self.outcome_columns()
    }

    fn columns(&self) -> &'static [Column] {
        &rows::COLUMNS
    }

    fn shown(&self) -> Shown {
        let by = if self.has_reality() {
            ("real", "mean fitness of the last offspring in reality")
        } else if self.is_compared {
            ("real", "mean fitness of the first generation in reality")
        } else if self.experiment.finalists() > 0 {
            (CHAMPION_MEAN, "mean fitness of the champion's new episodes")
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
        let warning = format!(
            "{}: {} NaN; they ranked last",
            run.directory.display(),
            counted(nan, "score was", "scores were")
        );
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
            let lives = counted(lives, "new episode", "new episodes");
            let appraised = if mean == "NaN" {
                format!("no mean of {lives}: the fitness of some is not a number (NaN)")
            } else {
                format!("mean {mean} of {lives} (95 %: {low} to {high})")
            };
            line = format!(
                "{appraised}, {who}\nluckiest  fitness {}, individual {} of \
                 generation {}",
                luckiest.fitness.unwrap_or(f32::NAN),
                luckiest.individual,
                luckiest.generation
            );
            cells.insert(0, ("mean", mean));
        }
        let mut warnings = Vec::from_iter((nan > 0).then_some(warning));
        if self.experiment.settings().evolution.uses_behaviour() {
            let unmeasured = unmeasured(run.directory)?;
            values.push(("nan_measures", json!(unmeasured)));
            warnings.extend((unmeasured > 0).then(|| {
                let individuals = counted(unmeasured, "individual has", "individuals have");
                format!(
                    "{}: {individuals} a measure that is NaN: no behaviour, no place in an archive, no novelty",
                    run.directory.display()
                )
            }));
        }
        // The trace of an episode that ended before its first cycle has only its header.
        let trace = plain::open(&run.directory.join(TRACE)).map(|trace| BufReader::new(trace.take(1 << 20)));
        if trace.is_ok_and(|trace| trace.lines().take(2).count() == 1) {
            let problem = "the champion's episode ended before its first cycle: its task ended it at once";
            warnings.push(format!("{}: {problem}", run.directory.display()));
        }
        Ok(Summary {
            line: ("champion", line),
            values,
            cells,
            warnings,
        })
    }

    fn progress(&self, run: &Recorded<'_>) -> Result<(u32, Option<f32>)> {
        let rows = if run.is_done {
            rows(run.directory)?
        } else {
            // A killed run may lack its table, or the end of the table's last line.
            let text = disk::read_text(&run.directory.join(GENERATIONS)).unwrap_or_default();
            Row::parse(files::whole_lines(&text)).unwrap_or_default()
        };
        let numbers = rows.iter().map(|row| row.best).filter(|best| !best.is_nan());
        Ok((rows.len() as u32, numbers.reduce(f32::max)))
    }

    fn check(&self, picture: Option<&Path>) -> Result<Answer> {
        check::run(&self.experiment, picture)
    }

    fn check_lives(&self, lives: u32) -> Result<String> {
        arithmetic::check(&self.experiment, lives)
    }

    fn replay(&self, run: &Recorded<'_>, replay: &Replay<'_>, engine: &Engine, _: Bars) -> Result<Answer> {
        replay::run(self, run, replay, engine)
    }

    fn audit(&self, run: &Recorded<'_>, share: f64, engine: &Engine, bars: Bars) -> Result<Audit> {
        audit::run(self, run, share, engine, bars)
    }

    fn scene(
        self: Arc<Self>,
        run: &Recorded<'_>,
        generation: Option<u32>,
        checkpoint: &dyn Fn() -> Option<Vec<u8>>,
        engine: &Engine,
    ) -> Result<Option<Scene>> {
        scene::of(&self, run, generation, checkpoint, engine)
    }
}
