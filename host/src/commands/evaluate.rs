//! `oneiro evaluate`: fitness and measures of genomes, the best of many, and tournaments.

use std::io::Write;
use std::path::{Path, PathBuf};

use oneiro::batch::{Trace, WorldKind};
use oneiro::differential::Build;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::world::{self, Start, World, WorldSpec};
use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, counted, decimal};
use oneiro_base::contents::{Column, Entry, README, describe};
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_base::files::directory::Filling;
use oneiro_base::npy::npy;
use oneiro_base::plain;
use oneiro_base::progress;
use oneiro_evolve::appraisal::Appraisal;
use oneiro_lab::device;
use oneiro_lab::experiment::Experiment;
use oneiro_lab::lives::measures::{Descriptor, Measures, descriptors};
use oneiro_lab::lives::worlds::{self as drawn, WorldTable};
use oneiro_lab::lives::{Keys, LifeIndex, Lines, Lives, scores, starts};
use oneiro_lab::record::SingleRun;
use oneiro_lab::runs::single::trace::TraceTable;
use oneiro_report::csv::Csv;
use oneiro_report::numbers::{significant, unsigned_zero};
use serde::{Serialize, Serializer};
use serde_json::{Value, json};

use super::places::{settings_typed, typed};
use super::replay::seed_of_others;
use super::subjects::{Common, Named, Subjects, Which};
use crate::cli::{Evaluate, Noise};

mod best;
mod on_robot;
mod tournament;

/// Most cycles of a world.
const MOST_CYCLES: u32 = 1_000_000;

/// Evaluates, and prints or writes one row for each genome and trial; or finds the best genome, or plays a tournament.
pub(crate) fn run(arguments: &Evaluate, console: Console) -> Result {
    let is_experiment = |path: &&PathBuf| path.extension().is_some_and(|extension| extension == "toml");
    if let Some(path) = arguments.genomes.iter().find(is_experiment) {
        let path = path.display();
        return Err(Failure::input(format_args!(
            "--genomes {path}: isn't a file of genomes; allowed: .npy, .csv, .json; an experiment goes before --genomes"
        )));
    }
    if arguments.ranked.best {
        return best::run(arguments, console);
    }
    // The parser asks for no option that another given one excludes.
    let (ranked, played) = (&arguments.ranked, &arguments.played);
    for (option, is_given, needed) in [
        ("--individuals", ranked.individuals, "--best"),
        ("--all", ranked.all, "--best"),
        ("--every", played.every != 1 && !played.tournament, "--tournament"),
    ] {
        if is_given {
            return Err(Failure::usage(format_args!(
                "{option}: is given; allowed: with {needed}"
            )));
        }
    }
    if arguments.played.tournament {
        return tournament::run(arguments, console);
    }
    let sink = Sink::of(arguments)?;
    let named = Named::all(&arguments.genomes, console)?;
    let (experiment, seed) = experiment_and_seed(arguments, &named, true)?;
    let settings = experiment.settings();
    let mut spec = experiment.world().spec().clone();
    let cycles = spec.cycles;
    if arguments.noise == Noise::Off
        && let Some(kept) = without_noise(&mut spec)
    {
        console.say(format!("warning: --noise off: {kept}"));
    }
    let watched = arguments.rows.measures || arguments.traces.is_some();
    if watched && cycles < MOST_CYCLES {
        spec = spec.seen_to_its_end();
    }
    let which = if arguments.population {
        Which::LastGeneration
    } else {
        Which::Champion
    };
    let mut subjects = Subjects::read(&named, experiment.world().gene_layout(), which, console)?;
    let is_of_run = |own: &Named| matches!(own, Named::Run(run) if run.seed() == seed);
    if named.iter().any(is_of_run) && arguments.on_robot.robots.is_empty() && arguments.starts.is_none() {
        console.warn([format!(
            "seed {seed} is also the run's, whose first generation had some of these episodes; --seed {} has new ones",
            seed_of_others(seed)
        )]);
    }
    if let Some(count) = arguments.random {
        subjects = subjects.with_random(&experiment.random_genomes(count, seed));
    }
    let files = named.len() + usize::from(arguments.random.is_some());
    let worlds = match &arguments.starts {
        Some(path) => starts::read(path, &spec, |word| console.say(word))?,
        None => vec![World::new(spec.clone())?],
    };
    let trials = if arguments.starts.is_some() {
        worlds.len()
    } else {
        arguments.trials.unwrap_or(settings.trials) as usize
    };
    if arguments.rows.summary && trials < 2 {
        let problem = "--summary: one episode of each genome has no interval; allowed: with --trials 2 or more";
        return Err(Failure::usage(problem));
    }
    let lives = Lives {
        worlds: &worlds,
        genomes: &subjects.genomes,
        count: trials,
        keys: Keys {
            common: arguments.common_starts,
            ..Keys::of_seed(seed)
        },
    };
    if !arguments.on_robot.robots.is_empty() {
        let results = on_robot::lived(arguments, &lives, console)?;
        let table = Table {
            sources: Some(subjects.sources).filter(|_| files > 1),
            summary: arguments.rows.summary,
            trials,
            results: results
                .into_iter()
                .map(|fitness| (fitness, Measures::default()))
                .collect(),
            worlds: lives.variants(),
            measures: Vec::new(),
        };
        sink.take(&table, console)?;
        if let (Some(experiment), Some(lives)) = (&arguments.experiment, &arguments.on_robot.log) {
            let [experiment, lives] = [experiment, lives].map(|path| shell(path));
            console.next(format_args!(
                "oneiro robot calibrate {experiment} --log {lives} --out calibration"
            ));
        }
        return Ok(());
    }
    let mut evaluator = arguments.backend.open()?;
    console.say(format!(
        "{}, {}, seed {seed}, on {}",
        counted(subjects.genomes.len(), "genome", "genomes"),
        counted(trials, "trial", "trials"),
        device::name_for(evaluator.as_ref(), worlds[0].kernel())
    ));
    if subjects.genomes.len() > 1 && arguments.starts.is_none() && !arguments.common_starts {
        let what = if spec.start.is_drawn() {
            "starts and random numbers"
        } else {
            "random numbers"
        };
        console.say(format!(
            "each genome has different {what}; --common-starts gives all the same"
        ));
    }

    let is_trace = |name: &str| name == README || name == drawn::FILE || name.starts_with("trace-");
    let begin = |directory| Filling::begin("--traces", directory, is_trace);
    let traces = arguments.traces.as_deref().map(begin).transpose()?;
    let control = Control::new();
    let measures = if arguments.rows.measures {
        descriptors(experiment.world())
    } else {
        Vec::new()
    };
    let threads = arguments.backend.threads.map(usize::from);
    let each = if arguments.rows.measures {
        scores::descriptors(&lives)
    } else {
        Vec::new()
    };
    let mut results = vec![(f32::NAN, Measures::default()); subjects.genomes.len() * trials];
    progress::watched(lives.steps(), "evaluating", console.bars(), &control, || -> Result {
        let evaluator: &mut dyn Evaluator = evaluator.as_mut();
        if !watched {
            let fitness = lives.fitness(evaluator, &control)?;
            results.iter_mut().zip(fitness).for_each(|(own, life)| own.0 = life);
            return Ok(());
        }
        let table = TraceTable::new(&worlds[0]);
        let width = worlds[0].record_words();
        let trace = arguments.traces.as_ref().map(|directory| {
            let table = &table;
            move |life: LifeIndex, first: u32, words: &[u32]| {
                write_trace(directory, table, life, first, &Trace::read(words, width as usize))
            }
        });
        let trace = trace.as_ref().map(|trace| trace as Lines<'_>);
        let mut ended = |life: LifeIndex, fitness: f32, own: &Measures| {
            results[life.genome * trials + life.number] = (fitness, own.clone());
        };
        lives.measured(evaluator, &control, cycles, &measures, trace, &mut ended)?;
        if !each.is_empty() {
            let scores = scores::by_robot(&lives, cycles, threads, &control)?;
            results
                .iter_mut()
                .zip(scores)
                .for_each(|(life, own)| life.1.scores = own);
        }
        Ok(())
    })?;
    let table = Table {
        sources: Some(subjects.sources).filter(|_| files > 1),
        summary: arguments.rows.summary,
        trials,
        results,
        worlds: lives.variants(),
        measures: [measures, each].concat(),
    };
    device::tell_warnings(evaluator.as_ref(), console);
    sink.take(&table, console)?;
    if let Some((directory, traces)) = arguments.traces.as_deref().zip(traces) {
        let about = "an episode of a genome: one row per cycle";
        let entry = Entry::table("trace-GENOME-TRIAL.csv", about, TraceTable::new(&worlds[0]).columns());
        let mut entries = vec![entry];
        if let Some(table) = WorldTable::new(&worlds[0]) {
            entries.push(drawn::entry(&table.columns()));
            disk::note(&directory.join(drawn::FILE), table.csv().as_bytes())?;
        }
        describe(directory, "Traces of oneiro", &entries)?;
        traces.finish()?;
    }
    // A replay has the run's own experiment and noise, and its champion.
    let is_replayed = |run: &SingleRun| {
        let is_own = |own: &Experiment| {
            let own = if arguments.test { own.tested_in() } else { Ok(own) };
            own.is_ok_and(|own| experiment.difference(own, false).is_none())
        };
        arguments.noise == Noise::On && !arguments.population && run.experiment().is_ok_and(is_own)
    };
    let test = test_typed(arguments);
    let start = match worlds[0].spec().start {
        Start::At { x, y, heading } if arguments.starts.is_some() => format!(" --start {x},{y},{heading}"),
        _ => String::new(),
    };
    let first = named.first().and_then(|own| match own {
        Named::Run(run) if !is_replayed(run) => None,
        Named::Run(run) => Some(format!(
            "oneiro replay {}{test} --seed {seed}{start}",
            typed(run.directory())
        )),
        Named::Sweep(champions) => Some(format!("oneiro sweep report {}", typed(champions.path().parent()?))),
        Named::File(_) => None,
    });
    console.next(
        first.unwrap_or_else(|| match (&arguments.experiment, &arguments.genomes[..]) {
            (Some(experiment), []) => format!(
                "oneiro run {}{} --seed 1",
                shell(experiment),
                settings_typed(&arguments.set)
            ),
            _ => format!("oneiro evaluate {}", retyped(arguments)),
        }),
    );
    Ok(())
}

fn shell(path: &Path) -> String {
    files::for_shell(&path.display().to_string())
}

/// The option of tests, if it is given.
fn test_typed(arguments: &Evaluate) -> &'static str {
    if arguments.test { " --test" } else { "" }
}

/// The arguments that name the best of the same genomes.
fn retyped(arguments: &Evaluate) -> String {
    let experiment = arguments
        .experiment
        .as_ref()
        .map(|path| shell(path) + " ")
        .unwrap_or_default();
    let genomes: Vec<String> = arguments.genomes.iter().map(|path| shell(path)).collect();
    format!(
        "{experiment}--best{}{} --genomes {}",
        test_typed(arguments),
        settings_typed(&arguments.set),
        genomes.join(" ")
    )
}

/// The experiment of the command line, or the one that all runs and sweeps share, and the seed of the rollouts. `scores`: whether the
/// combination of several rollouts must agree, too.
fn experiment_and_seed(arguments: &Evaluate, named: &[Named], scores: bool) -> Result<(Experiment, u64)> {
    let common = Common {
        scores,
        test: arguments.test,
    };
    let experiment = match &arguments.experiment {
        Some(path) => common.of(Experiment::read(path, &arguments.set)?)?,
        None => common.experiment(named, &arguments.set)?,
    };
    // Runs have the seeds of their evolution.
    let sets_seed = || {
        arguments
            .set
            .iter()
            .any(|set| set.split('=').next().map(str::trim) == Some("seed"))
    };
    let is_own = arguments.experiment.is_some() || sets_seed();
    let own_seed = experiment.settings().seed.filter(|_| is_own);
    let seed = arguments.seed.or(own_seed).unwrap_or(1);
    Ok((experiment, seed))
}

/// Takes the noise out of a world, and names what keeps some.
fn without_noise(spec: &mut WorldSpec) -> Option<String> {
    spec.noise = world::Noise::NONE;
    spec.varied.retain(|key| !world::Noise::is_key(key));
    let mut kept = Vec::new();
    if spec.varied.keys().any(|(_, key)| key.starts_with("robot.grey_")) {
        kept.push("drawn robot.grey_ readings keep their deviations");
    }
    match &mut spec.robot.build {
        Build::Sampled => (),
        Build::Differential(own) => {
            own.wheel_noise = own.wheel_noise.map(|_| 0.0);
            if own.model.is_some() {
                own.reference = own.reference.without_noise();
                kept.push("robots still lose messages as robot.signal_loss says");
            }
        }
        Build::Forager(own) => {
            own.foraging.light_noise = 0.0;
            own.foraging.wheel_noise = 0.0;
            kept.push("a forager's proximity sensors keep their measured noise");
        }
    }
    if !spec.own.is_empty() {
        kept.push("custom parts keep the noise that they draw");
    }
    (!kept.is_empty()).then(|| kept.join("; "))
}

/// Writes the next lines of a life's trace.
fn write_trace(directory: &Path, table: &TraceTable, life: LifeIndex, first: u32, trace: &Trace) -> Result {
    let path = directory.join(format!("trace-{}-{}.csv", life.genome, life.number));
    let lines = table.lines(trace, first, 1);
    let (file, lines) = if first == 0 {
        (plain::create(&path), table.head() + &lines)
    } else {
        (plain::append(&path), lines)
    };
    file.and_then(|mut file| file.write_all(lines.as_bytes()))
        .map_err(|error| Failure::storage(&path, &error))
}

/// Destination of the rows.
enum Sink {
    Stdout,
    Csv(PathBuf),
    Npy(PathBuf),
}

impl Sink {
    /// The destination on the command line; an invalid one is refused before anything is computed.
    fn of(arguments: &Evaluate) -> Result<Self> {
        let Some(out) = arguments.file() else {
            return Ok(Self::Stdout);
        };
        files::must_be_new(out)?;
        match out.extension().and_then(|extension| extension.to_str()) {
            Some("csv") => Ok(Self::Csv(out.to_owned())),
            Some("npy") if arguments.rows.summary => Err(Failure::usage(format_args!(
                "--out {}: has the fitness of each episode; allowed with --summary: .csv, or - for standard output",
                out.display()
            ))),
            Some("npy") if arguments.rows.measures => Err(Failure::usage(format_args!(
                "--out {}: has fitness only; allowed with --measures: .csv, or - for standard output",
                out.display()
            ))),
            Some("npy") => Ok(Self::Npy(out.to_owned())),
            _ => Err(Failure::input(format_args!(
                "--out {}: has an unknown extension; allowed: .csv, .npy, or - for standard output",
                out.display()
            ))),
        }
    }

    /// Prints or writes a table.
    fn take(&self, table: &Table, console: Console) -> Result {
        match self {
            Self::Stdout => console.print_answer(&Answer::new(table.csv(), table)),
            Self::Csv(path) => files::write_new(path, table.csv().as_bytes()),
            Self::Npy(path) => {
                let fitness: Vec<f32> = table.results.iter().map(|(fitness, _)| *fitness).collect();
                files::write_new(path, &npy(&[fitness.len() / table.trials, table.trials], &fitness))
            }
        }?;
        if let Self::Csv(path) | Self::Npy(path) = self {
            console.say(format!("wrote {}", path.display()));
        }
        if let Some(span) = table.span().filter(|_| table.summary) {
            console.say(span);
        }
        Ok(())
    }
}

/// A life's fitness and measures.
type Lived = (f32, Measures);

/// Results of lives, by genome.
struct Table {
    /// Source of each genome, if they come from several files.
    sources: Option<Vec<String>>,
    /// Whether it has a row for each genome instead of one for each rollout.
    summary: bool,
    trials: usize,
    results: Vec<Lived>,
    /// The world of each, if worlds vary.
    worlds: Option<Vec<usize>>,
    /// Measures that were requested.
    measures: Vec<Descriptor>,
}

static OWN: [Column; 4] = [
    Column::whole("genome", "", "its number, from 0"),
    Column::whole("trial", "", "the number of its episode, from 0"),
    Column::number("fitness", "", "the episode's fitness"),
    Column::text("bits", "the fitness as its 32 bits, in hex"),
];
static SUMMARY: [Column; 6] = [
    Column::whole("genome", "", "its number, from 0"),
    Column::whole("episodes", "", "how many it had"),
    Column::number("mean", "", "their mean fitness"),
    Column::number("deviation", "", "the standard deviation of their fitness"),
    Column::number(
        "low",
        "",
        "the lower end of the mean's 95 % confidence interval, by Student's t",
    ),
    Column::number("high", "", "its upper end"),
];
static WORLD: Column = Column::whole(
    "world",
    "",
    "the number of its world, from 0, where worlds or starts vary from trial to trial",
);
static SOURCE: Column = Column::text("source", "the file that has the genome");

impl Table {
    fn rows(&self) -> impl Iterator<Item = (usize, usize, &Lived)> {
        let place = |index| (index / self.trials, index % self.trials);
        self.results.iter().enumerate().map(move |(index, lived)| {
            let (genome, trial) = place(index);
            (genome, trial, lived)
        })
    }

    /// The mean fitness of each genome.
    fn appraisals(&self) -> impl Iterator<Item = Appraisal> {
        self.results.chunks(self.trials).map(|lives| {
            let fitness: Vec<f32> = lives.iter().map(|(fitness, _)| *fitness).collect();
            Appraisal::of(&fitness)
        })
    }

    /// The mean of each measure, of a genome's lives.
    fn means(&self, genome: usize) -> impl Iterator<Item = f64> {
        let lives = &self.results[genome * self.trials..][..self.trials];
        self.measures.iter().map(move |own| {
            let sum: f64 = lives.iter().map(|(_, measures)| own.value(measures)).sum();
            unsigned_zero(sum / lives.len() as f64)
        })
    }

    /// The columns of these means.
    fn columns_of_means(&self) -> Vec<Column> {
        let mean = |own: &Descriptor| own.column.clone().named(format!("mean_{}", own.column.name));
        self.measures.iter().map(mean).collect()
    }

    /// The median and the greatest of the genomes' mean fitness, if there are several.
    fn span(&self) -> Option<String> {
        let mut means: Vec<(f64, usize)> = self.appraisals().map(|own| own.mean).zip(0..).collect();
        means.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (greatest, genome) = *means.last().filter(|_| means.len() > 1)?;
        let middle = means.len() / 2;
        let median = f64::midpoint(means[(means.len() - 1) / 2].0, means[middle].0);
        let [median, greatest] = [median, greatest].map(|number| significant(number, 6));
        Some(format!(
            "mean fitness of {} genomes: median {median}, maximum {greatest} (genome {genome})",
            means.len()
        ))
    }

    /// A row for each genome.
    fn json_summary(&self) -> impl Iterator<Item = Value> {
        let columns = self.columns_of_means();
        let row = move |(genome, own): (usize, Appraisal)| {
            let mut row = json!({
                "genome": genome,
                "episodes": own.lives,
                "mean": unsigned_zero(own.mean),
                "deviation": own.deviation,
                "interval": own.interval().map(unsigned_zero),
            });
            for (column, mean) in columns.iter().zip(self.means(genome)) {
                row[&*column.name] = mean.into();
            }
            if let Some(sources) = &self.sources {
                row["source"] = sources[genome].as_str().into();
            }
            row
        };
        self.appraisals().enumerate().map(row)
    }

    /// The same as CSV, to six digits.
    fn csv_summary(&self) -> String {
        let means = self.columns_of_means();
        let mut csv = Csv::new(SUMMARY.iter().chain(&means).chain(self.sources.iter().map(|_| &SOURCE)));
        for (genome, own) in self.appraisals().enumerate() {
            let [low, high] = own.interval();
            let numbers = [own.mean, own.deviation, low, high]
                .into_iter()
                .chain(self.means(genome));
            let numbers = numbers.map(|number| significant(number, 6));
            let source = self.sources.iter().map(|sources| sources[genome].clone());
            csv.row(
                [genome.to_string(), own.lives.to_string()]
                    .into_iter()
                    .chain(numbers)
                    .chain(source),
            );
        }
        csv.text()
    }

    /// A row for each rollout.
    fn json_lives(&self) -> impl Iterator<Item = Value> {
        let row = |(genome, trial, (fitness, measures)): (usize, usize, &Lived)| {
            let mut row = json!({
                "genome": genome,
                "trial": trial,
                "fitness": decimal(*fitness),
                "bits": format!("{:08x}", fitness.to_bits()),
            });
            if let Some(worlds) = &self.worlds {
                row[&*WORLD.name] = worlds[genome * self.trials + trial].into();
            }
            for descriptor in &self.measures {
                row[&*descriptor.column.name] = serde_json::from_str(&descriptor.cell(measures)).unwrap_or_default();
            }
            if let Some(sources) = &self.sources {
                row["source"] = sources[genome].as_str().into();
            }
            row
        };
        self.rows().map(row)
    }

    /// Formats fitness as the shortest decimal that reads back as the same number, with its bits; measures to six
    /// digits,
    /// and what a task remembers in full.
    fn csv(&self) -> String {
        if self.summary {
            return self.csv_summary();
        }
        let measures = self.measures.iter().map(|descriptor| &descriptor.column);
        let source = self.sources.iter().map(|_| &SOURCE);
        let world = self.worlds.iter().map(|_| &WORLD);
        let mut csv = Csv::new(OWN.iter().chain(world).chain(measures).chain(source));
        for (genome, trial, (fitness, measures)) in self.rows() {
            let worlds = self.worlds.iter();
            let world = worlds.map(|worlds| worlds[genome * self.trials + trial].to_string());
            let own = [
                genome.to_string(),
                trial.to_string(),
                fitness.to_string(),
                format!("{:08x}", fitness.to_bits()),
            ];
            let numbers = self.measures.iter().map(|descriptor| descriptor.cell(measures));
            let source = self.sources.iter().map(|sources| sources[genome].clone());
            csv.row(own.into_iter().chain(world).chain(numbers).chain(source));
        }
        csv.text()
    }
}

impl Serialize for Table {
    /// Row by row, since there may be millions.
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        if self.summary {
            serializer.collect_seq(self.json_summary())
        } else {
            serializer.collect_seq(self.json_lives())
        }
    }
}

#[cfg(test)]
mod tests {
    use oneiro::world::WorldSpec;

    use super::*;

    fn table(measures: bool) -> Table {
        let world = World::new(WorldSpec::miglino1995()).unwrap();
        let own = Measures {
            collisions: 3,
            cells: 12,
            distance: 1234.5678,
            speed: 24.691_356,
            stuck: 9.9,
            turning: 0.25,
            end: [100.5, 20.0],
            wall_distance: 33.333_333,
            memory: Vec::new(),
            scores: Vec::new(),
        };
        Table {
            sources: measures.then(|| vec!["a.npy".into(), "a, b.npy[3]".into()]),
            summary: false,
            trials: 2,
            results: [1.5, -0.1, 0.0, 3.0].map(|fitness| (fitness, own.clone())).into(),
            worlds: None,
            measures: if measures { descriptors(&world) } else { Vec::new() },
        }
    }

    #[test]
    fn rows_are_genomes_by_trials() {
        assert_eq!(
            table(false).csv(),
            "genome,trial,fitness,bits\n0,0,1.5,3fc00000\n0,1,-0.1,bdcccccd\n1,0,0,00000000\n1,1,3,40400000\n"
        );
        let text = table(true).csv();
        assert!(text.starts_with(
            "genome,trial,fitness,bits,collisions,cells,distance_mm,mean_speed_mm_s,stuck_s,mean_turning_turns_s,end_x_mm,end_y_mm,wall_distance_mm,source\n\
             0,0,1.5,3fc00000,3,12,1234.57,24.6914,9.9,0.25,100.5,20,33.3333,a.npy\n"
        ));
        assert!(text.ends_with("1,1,3,40400000,3,12,1234.57,24.6914,9.9,0.25,100.5,20,33.3333,\"a, b.npy[3]\"\n"));
        let summary = |measures| Table {
            summary: true,
            ..table(measures)
        };
        assert_eq!(
            summary(false).csv(),
            "genome,episodes,mean,deviation,low,high\n0,2,0.7,1.13137,-9.46496,10.865\n1,2,1.5,2.12132,-17.5593,20.5593\n"
        );
        let text = summary(true).csv();
        assert!(
            text.starts_with("genome,episodes,mean,deviation,low,high,mean_collisions,mean_cells,mean_distance_mm,")
        );
        assert!(text.ends_with("-17.5593,20.5593,3,12,1234.57,24.6914,9.9,0.25,100.5,20,33.3333,\"a, b.npy[3]\"\n"));
        let mut unequal = summary(true);
        unequal.results[3].1.collisions = 6;
        assert!(unequal.csv().contains("20.5593,4.5,12,"));
        assert_eq!(json!(unequal)[1]["mean_collisions"], 4.5);
        assert_eq!(
            summary(false).span().unwrap(),
            "mean fitness of 2 genomes: median 1.1, maximum 1.5 (genome 1)"
        );
        assert_eq!(json!(summary(true))[1]["mean"], 1.5);
        let mut zero = summary(true);
        zero.results.iter_mut().for_each(|own| own.0 = -0.0);
        assert_eq!(json!(zero)[0]["mean"].to_string(), "0.0");
        assert!(zero.csv().contains("\n0,2,0,0,0,0,"));
        assert_eq!(json!(summary(true))[1]["source"], "a, b.npy[3]");
        assert_eq!(json!(table(true))[3]["distance_mm"], 1234.57);
        assert_eq!(json!(table(true))[3]["collisions"], 3);
    }
}
