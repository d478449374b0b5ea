//! The 1995 study with somebody else's world as reality: controllers evolve for a Thymio II or an e-puck that was sampled in Aseba's simulator, with the
//! paper's three kinds of noise, then live and evolve on in that simulator. studies/preregistration-1995-elsewhere.md has the rules, and
//! studies/elsewhere.py judges the table.
#![cfg(target_os = "linux")]

use std::fs::{self, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use npyz::NpyFile;
use rand::SeedableRng;
use rand_pcg::Pcg64;
use serde_json::Value;

use crate::aseba::crowd::{EPUCK, Kind, Pose, THYMIO, children};
use crate::aseba::in_a_network;
use crate::place::Place;

/// Names of noises, and what `--set` needs for them.
type Noises = &'static [(&'static str, &'static [&'static str])];

/// The study of a robot.
struct Study {
    /// Its name, also that of its experiment.
    name: &'static str,
    kind: &'static Kind,
    /// Collision rules of our simulator. What evolves on is under the first.
    rules: &'static [&'static str],
    /// What the simulator adds: nothing, noise of single sensors, displacements.
    noises: Noises,
    seeds: u64,
    /// What evolves on: with the first noises.
    on_seeds: u64,
    on_noises: usize,
    on_generations: u32,
}

const NONE: (&str, &[&str]) = ("none", &[]);
const SENSOR: (&str, &[&str]) = ("sensor", &["noise.sensor=[0.0,0.4]"]);
static OF_THYMIO: Study = Study {
    name: "thymio",
    kind: &THYMIO,
    rules: &["slide", "undo"],
    // The displacement of the paper, and one three times as large.
    noises: &[
        NONE,
        SENSOR,
        ("conservative", &["noise.walk_range_mm=90", "noise.walk_step_mm=4.5"]),
        ("conservative-30", &["noise.walk_range_mm=30"]),
    ],
    seeds: 10,
    on_seeds: 5,
    on_noises: 3,
    on_generations: 10,
};
static OF_EPUCK: Study = Study {
    name: "epuck",
    kind: &EPUCK,
    rules: &["slide"],
    noises: &[NONE, SENSOR, ("conservative", &["noise.walk_range_mm=30"])],
    seeds: 6,
    on_seeds: 3,
    on_noises: 3,
    on_generations: 3,
};

const PARENTS: usize = 20;
/// Share of late cycles from which on lives are repeated, and how often they are.
const LATE: f64 = 0.01;
const REPEATS: u32 = 5;
const HEAD: &str = "rule,noise,seed,where,generation,mean,sd,best_20,late\n";

/// One row: a population, and where it lived.
struct Row<'a> {
    of: &'a str,
    place: &'a str,
    generation: u32,
    fitness: Vec<f64>,
    late: f64,
}

impl Row<'_> {
    fn text(&self) -> String {
        let mut sorted = self.fitness.clone();
        sorted.sort_by(f64::total_cmp);
        let mean = |some: &[f64]| some.iter().sum::<f64>() / some.len() as f64;
        let whole = mean(&sorted);
        let variance = sorted.iter().map(|each| (each - whole).powi(2)).sum::<f64>() / (sorted.len() - 1) as f64;
        format!(
            "{},{},{},{whole:.3},{:.3},{:.3},{:.5}\n",
            self.of,
            self.place,
            self.generation,
            variance.sqrt(),
            mean(&sorted[sorted.len() - 20..]),
            self.late
        )
    }
}

/// The table so far. What it has is not done again.
struct Table {
    path: PathBuf,
    text: String,
}

impl Table {
    fn open(path: PathBuf) -> Self {
        let text = fs::read_to_string(&path).unwrap_or_default();
        let mut table = Self { path, text };
        if table.text.is_empty() {
            table.add(HEAD);
        }
        table
    }

    fn has(&self, of: &str, place: &str) -> bool {
        self.text.contains(&format!("\n{of},{place},"))
    }

    fn add(&mut self, rows: &str) {
        self.text += rows;
        let mut file = OpenOptions::new().create(true).append(true).open(&self.path).unwrap();
        file.write_all(rows.as_bytes()).unwrap();
    }
}

/// Evolves in our simulator, into a directory for each seed.
fn evolve(place: &Place, study: &Study, rule: &str, noise: usize) -> PathBuf {
    let (name, values) = study.noises[noise];
    let (rule_set, seeds) = (format!("robot.collision={rule}"), format!("1..{}", study.seeds));
    let out = place.at(format!("{rule}-{name}"));
    let experiment = Path::new(env!("CARGO_MANIFEST_DIR")).join("../studies/miglino1995/elsewhere");
    let experiment = experiment.join(study.name).with_extension("toml");
    let mut arguments = vec![
        "run",
        experiment.to_str().unwrap(),
        "--seeds",
        &seeds,
        "--set",
        &rule_set,
    ];
    for value in values {
        arguments.extend(["--set", value]);
    }
    arguments.extend(["--out", out.to_str().unwrap(), "--backend", "cpu", "--quiet"]);
    place.good(&arguments);
    out
}

fn population(kind: &Kind, run: &Path) -> Vec<Vec<f64>> {
    let bytes = fs::read(run.join("population.npy")).unwrap();
    let genes: Vec<f32> = NpyFile::new(&bytes[..]).unwrap().into_vec().unwrap();
    genes
        .chunks(kind.genes())
        .map(|genes| genes.iter().map(|gene| f64::from(*gene)).collect())
        .collect()
}

/// Fitness of a run's last generation in our simulator, in lives that its evolution has not seen.
fn simulated(place: &Place, run: &Path, noise: &str) -> Vec<f64> {
    let run = run.to_str().unwrap();
    let json = place.good(&[
        "evaluate",
        "--genomes",
        run,
        "--population",
        "--trials",
        "1",
        "--seed",
        "1000",
        "--noise",
        noise,
        "--backend",
        "cpu",
        "--json",
    ]);
    let rows: Vec<Value> = serde_json::from_str(&json).unwrap();
    rows.iter().map(|row| row["fitness"].as_f64().unwrap()).collect()
}

/// Fitness in Aseba's simulator, each from a start of its own, and the share of late cycles.
fn real(kind: &'static Kind, population: &[Vec<f64>], random: &mut Pcg64) -> (Vec<f64>, f64) {
    let subjects: Vec<(&[f64], Pose)> = population
        .iter()
        .map(|genes| (&genes[..], kind.start(random)))
        .collect();
    let mut lived = kind.lives(&subjects);
    for _ in 0..REPEATS {
        if lived.late < LATE {
            break;
        }
        eprintln!("{:.3} of the cycles were late: once more", lived.late);
        lived = kind.lives(&subjects);
    }
    (lived.fitness, lived.late)
}

/// Random numbers of the starts and the mutations of a run in Aseba's simulator.
fn random_of(seed: u64, generation: u32) -> Pcg64 {
    Pcg64::seed_from_u64(1_000 * seed + u64::from(generation))
}

fn run(test: &str, study: &'static Study) {
    if !in_a_network(test, "the 1995 study in Aseba's simulator") {
        return;
    }
    let place = Place::new(test);
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("elsewhere-{}.csv", study.name));
    eprintln!("{}", path.display());
    let mut table = Table::open(path);
    for rule in study.rules {
        for (noise, (name, _)) in study.noises.iter().enumerate() {
            let runs = evolve(&place, study, rule, noise);
            for seed in 1..=study.seeds {
                carry_over(
                    &place,
                    study.kind,
                    &mut table,
                    &format!("{rule},{name},{seed}"),
                    seed,
                    &runs,
                );
            }
        }
    }
    for seed in 1..=study.on_seeds {
        for (name, _) in &study.noises[..study.on_noises] {
            let rule = study.rules[0];
            let run = place.at(format!("{rule}-{name}")).join(format!("seed-{seed}"));
            evolve_on(study, &mut table, &format!("{rule},{name},{seed}"), seed, &run);
        }
    }
}

#[test]
#[ignore = "a measurement, in real time for 71 minutes, with no result to compare: studies/miglino1995/README.md has the command; tests/long.sh judges the table that it made"]
fn the_1995_study_in_the_simulator_of_others() {
    run("the_1995_study_in_the_simulator_of_others", &OF_THYMIO);
}

#[test]
#[ignore = "a measurement, in real time for an hour, with no result to compare: studies/miglino1995/README.md has the command; tests/long.sh judges the table that it made"]
fn the_1995_study_with_the_epuck_of_others() {
    run("the_1995_study_with_the_epuck_of_others", &OF_EPUCK);
}

/// A run's last generation in our simulator with its noise, without, and in Aseba's.
fn carry_over(place: &Place, kind: &'static Kind, table: &mut Table, of: &str, seed: u64, runs: &Path) {
    if table.has(of, "real") {
        return;
    }
    let run = runs.join(format!("seed-{seed}"));
    let row = |place, (fitness, late)| {
        Row {
            of,
            place,
            generation: 0,
            fitness,
            late,
        }
        .text()
    };
    let rows = [
        row("simulated", (simulated(place, &run, "on"), 0.0)),
        row("quiet", (simulated(place, &run, "off"), 0.0)),
        row("real", real(kind, &population(kind, &run), &mut random_of(seed, 0))),
    ]
    .concat();
    eprint!("{rows}");
    table.add(&rows);
}

/// Generations of a run's population in Aseba's simulator. The first has the fitness of being carried over, lived again.
fn evolve_on(study: &Study, table: &mut Table, of: &str, seed: u64, run: &Path) {
    if table.has(of, "on") {
        return;
    }
    let (mut rows, mut population) = (String::new(), population(study.kind, run));
    for generation in 0..=study.on_generations {
        let mut random = random_of(seed, 100 + generation);
        let (fitness, late) = real(study.kind, &population, &mut random);
        population = children(&population, &fitness, PARENTS, &mut random);
        let row = Row {
            of,
            place: "on",
            generation,
            fitness,
            late,
        }
        .text();
        eprint!("{row}");
        rows += &row;
    }
    table.add(&rows);
}
