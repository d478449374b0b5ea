//! Well-known experiments: the bits of their lives on every device, and rewards in traces beside those of the rules that
//! `docs/classics` gives, written again in double precision.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use oneiro::random::pcg4d;

use crate::pinned;
use crate::place::{Place, Ran};

const GENOMES: usize = 30;

/// The classics, and the avoidance that has lane code compiled ahead.
const EXPERIMENTS: [&str; 8] = [
    "homing",
    "kheperax",
    "road-sign",
    "discrimination",
    "wall-following",
    "phototaxis",
    "predator-prey",
    "khepera-avoidance",
];

/// Lanes compiled at run time, with which all others are compared.
const REFERENCE: &str = "cpu:native128x16";

/// Random genomes of an experiment, one life each.
struct Lives {
    place: Place,
    experiment: String,
    /// Where compiled kernels are kept.
    cache: PathBuf,
    /// The program that lives them; by default the one that was built with the tests.
    program: Option<PathBuf>,
}

impl Lives {
    /// The first generation of a run.
    fn new(experiment: &str, count: usize, cache: &Path) -> Self {
        let place = Place::new(&format!("{experiment}-{count}"));
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../experiments/{experiment}.toml"));
        let experiment = path.display().to_string();
        // Whichever optimiser the experiment has, its first genomes are random.
        let values = [
            "evolution.kind=random".to_owned(),
            format!("evolution.population={count}"),
            "evolution.generations=1".to_owned(),
            "evolution.finalists=0".to_owned(),
        ];
        let set = values.iter().flat_map(|value| ["--set", value]);
        let run = [
            "run",
            &experiment,
            "--seed",
            "1",
            "--out",
            "run",
            "--quiet",
            "--backend",
            REFERENCE,
        ];
        place.good(&run.into_iter().chain(set).collect::<Vec<_>>());
        let cache = cache.to_owned();
        Self {
            place,
            experiment,
            cache,
            program: None,
        }
    }

    /// Runs a command that must succeed, and returns its standard output.
    fn good(&self, arguments: &[&str]) -> String {
        let mut command = match &self.program {
            None => self.place.command(arguments),
            Some(program) => {
                let mut command = Command::new(program);
                command.args(arguments).current_dir(self.place.at(""));
                command
            }
        };
        let output = command.env("XDG_CACHE_HOME", &self.cache).output().unwrap();
        Ran::new(arguments, &output).exits(0).stdout
    }

    /// A line for each life on a device: the fitness and its bits, and the measures of behaviour if they are asked for, which are
    /// made of all cycles.
    fn lines(&self, genomes: &str, measured: bool, device: &str) -> Vec<String> {
        let mut arguments = vec![
            "evaluate",
            &self.experiment,
            "--genomes",
            genomes,
            "--trials",
            "1",
            "--seed",
            "1",
        ];
        arguments.extend(["--backend", device, "--quiet"]);
        arguments.extend(measured.then_some("--measures"));
        self.good(&arguments).lines().skip(1).map(str::to_owned).collect()
    }

    /// Changes all genes by a two-thousandth or less, in a file beside the genomes: 4,096 units in the last place. Motors have few
    /// speeds, so that a smaller change is seldom seen.
    fn change_genes(&self) {
        let mut genomes = self.place.read(GENOMES_FILE);
        let first = genomes.iter().position(|byte| *byte == b'\n').unwrap() + 1;
        genomes[first..].chunks_exact_mut(4).for_each(|gene| gene[1] ^= 16);
        self.place.write(CHANGED_FILE, genomes);
    }
}

/// The genomes of lives.
const GENOMES_FILE: &str = "run/population.npy";
/// The same, a little changed.
const CHANGED_FILE: &str = "changed.npy";

/// In how many lines two differ.
fn differences(some: &[String], others: &[String]) -> usize {
    assert_eq!(some.len(), others.len());
    some.iter().zip(others).filter(|(one, other)| one != other).count()
}

/// Numbers of lives that are compared.
struct Counts {
    /// By their fitness.
    plain: usize,
    /// By their measures.
    measured: usize,
    /// By their measures, in the interpreter.
    interpreted: usize,
}

/// Episodes by code compiled at run time for any processor are those of the code for this one, of code compiled ahead, of lavapipe, and
/// of the interpreter; and they are those that are pinned. Genes that are off by a two-thousandth or less are noticed.
#[test]
fn the_same_bits_on_every_device() {
    let is_long = std::env::var_os("ONEIRO_LONG").is_some();
    let cache = Place::new("cache");
    let mut rows = pinned::Rows::default();
    let counts = if is_long {
        Counts {
            plain: 100_000,
            measured: 10_000,
            interpreted: 1_000,
        }
    } else {
        Counts {
            plain: 300,
            measured: 50,
            interpreted: 10,
        }
    };
    for experiment in EXPERIMENTS {
        // Each begins on it in `shipped`.
        let gpu = (is_long && cfg!(feature = "gpu")).then_some("gpu:llvmpipe");
        let ahead = (experiment == "khepera-avoidance").then_some("cpu:scalarx1");
        let others: Vec<&str> = ["cpu"].into_iter().chain(gpu).chain(ahead).collect();
        for (count, measured, others) in [
            (counts.plain, false, &others[..]),
            (counts.measured, true, &others[..]),
            (counts.interpreted, true, &["cpu:interpretedx1"]),
        ] {
            let lives = Lives::new(experiment, count, &cache.at(""));
            let expected = lives.lines(GENOMES_FILE, measured, REFERENCE);
            assert_eq!(expected.len(), count);
            rows.bytes(&format!("{count} lives"), experiment, expected.join("\n").as_bytes());
            for device in others {
                let begin = Instant::now();
                let found = lives.lines(GENOMES_FILE, measured, device);
                println!(
                    "{experiment}: {count} lives on {device} in {:.1?}, measured: {measured}",
                    begin.elapsed()
                );
                assert_eq!(differences(&found, &expected), 0, "{experiment} on {device}");
            }
            if !measured {
                lives.change_genes();
                let changed = lives.lines(CHANGED_FILE, measured, REFERENCE);
                let noticed = differences(&changed, &expected);
                println!("{experiment}: {noticed} of {count} lives notice genes that are off by a two-thousandth");
                assert!(noticed > 0, "{experiment}: other genes change nothing");
            }
        }
    }
    if !is_long {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/goldens/composed/classics.rows");
        pinned::check(&path, &rows.to_string());
    }
}

/// A thousand lives of each by code compiled at run time on an emulated processor of 64-bit ARM are those of this machine, by fitness
/// and by measures, and so are those by its lane code compiled ahead. A changed genome is noticed there too.
#[test]
#[ignore = "takes ten minutes and needs a build of the program for 64-bit ARM, which tests/long.sh makes before it runs this"]
fn the_same_bits_on_emulated_arm() {
    let program = std::env::var_os("ONEIRO_ARM_PROGRAM").expect("ONEIRO_ARM_PROGRAM is the path of the program");
    let (cache, count) = (Place::new("arm-cache"), 1_000);
    for experiment in EXPERIMENTS {
        let mut lives = Lives::new(experiment, count, &cache.at(""));
        lives.change_genes();
        let here = |genomes| [false, true].map(|measured| lives.lines(genomes, measured, REFERENCE));
        let (expected, changed) = (here(GENOMES_FILE), here(CHANGED_FILE));
        lives.program = Some(program.clone().into());
        let ahead = (experiment == "khepera-avoidance").then_some("cpu:neonx16");
        for device in [REFERENCE].into_iter().chain(ahead) {
            let begin = Instant::now();
            let found = [false, true].map(|measured| lives.lines(GENOMES_FILE, measured, device));
            let compare = |others: &[Vec<String>; 2]| [0, 1].map(|index| differences(&found[index], &others[index]));
            let (different, noticed) = (compare(&expected), compare(&changed));
            println!(
                "{experiment}: of {count} lives on {device} of 64-bit ARM {} differ by their fitness and {} by their measures, {} and {} from those of \
                 changed genes, in {:.1?}",
                different[0],
                different[1],
                noticed[0],
                noticed[1],
                begin.elapsed()
            );
            assert_eq!(different, [0, 0], "{experiment} on {device}");
            assert!(
                noticed.iter().all(|count| *count > 0),
                "{experiment}: other genes change nothing"
            );
        }
    }
}

/// A row of a trace.
struct Row {
    /// Pose before the cycle: mm, and the heading in turns.
    pose: [f64; 3],
    /// Mean speed of both wheels, as a share of the greatest.
    speed: f64,
    collided: bool,
    reward: f64,
}

/// Traces of [`GENOMES`] random genomes, one life each, with genes between minus and plus `range`.
fn traces(name: &str, genes: u32, range: f64) -> Vec<Vec<Row>> {
    let place = Place::new(name);
    let mut genomes = String::new();
    for genome in 0..GENOMES as u32 {
        let genes = (0..genes).map(|gene| {
            let [word, ..] = pcg4d([genome, gene, 5, 3]);
            (range * (f64::from(word) / f64::from(u32::MAX) * 2.0 - 1.0)).to_string()
        });
        let _ = writeln!(genomes, "{}", genes.collect::<Vec<_>>().join(","));
    }
    place.write("genomes.csv", genomes);
    let experiment = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../experiments/{name}.toml"));
    let experiment = experiment.display().to_string();
    let checked = place.good(&["check", &experiment]);
    assert!(checked.contains(&format!("; {genes} genes")), "{checked}");
    let evaluated = place.run(&[
        "evaluate",
        &experiment,
        "--genomes",
        "genomes.csv",
        "--trials",
        "1",
        "--seed",
        "1",
        "--traces",
        "traces",
        "--backend",
        "cpu",
    ]);
    evaluated.exits(0).says(&[&format!("{GENOMES} genomes, 1 trial,")]);
    (0..GENOMES)
        .map(|genome| rows(&place.text(format!("traces/trace-{genome}-0.csv"))))
        .collect()
}

fn rows(trace: &str) -> Vec<Row> {
    let mut lines = trace.lines();
    let head: Vec<_> = lines.next().unwrap().split(',').collect();
    lines
        .map(|line| {
            let numbers = line.split(',').map(|number| number.parse::<f64>().unwrap());
            let row: HashMap<_, _> = head.iter().copied().zip(numbers).collect();
            Row {
                pose: ["x_mm", "y_mm", "heading_turns"].map(|column| row[column]),
                speed: 0.5 * (row["speed_left"] + row["speed_right"]),
                collided: row["collided"] != 0.0,
                reward: row["reward"],
            }
        })
        .collect()
}

/// A cycle near the cylinder earns 1 once the robot has been away from it, and a collision is the last thing in a life.
#[test]
fn discrimination_earns_near_the_cylinder() {
    let (mut earned, mut unearned, mut collisions) = (0, 0, 0);
    for life in traces("discrimination", 742, 1.0) {
        let near = |row: &Row| (row.pose[0] - 200.0).hypot(row.pose[1] - 150.0) < 100.0;
        let mut was_away = !near(&life[0]);
        for cycle in life.windows(2) {
            let near = near(&cycle[1]);
            let expected = near && was_away && !cycle[0].collided;
            assert_eq!(cycle[0].reward, f64::from(u8::from(expected)), "{:?}", cycle[0].pose);
            assert!(!cycle[0].collided, "a life goes on after a collision");
            earned += u32::from(expected);
            unearned += u32::from(near && !was_away);
            was_away |= !near;
        }
        let last = life.last().unwrap();
        assert!(last.collided || life.len() == 500, "a life of {} cycles", life.len());
        collisions += u32::from(last.collided);
    }
    println!("{earned} cycles earn, {unearned} near the cylinder don't; {collisions} lives end by collisions");
    assert!(earned > 100 && unearned > 100 && collisions > 10);
}

/// Distance along a ray in the arena of `wall-following.toml`, at most 120 mm.
fn distance([x, y]: [f64; 2], turns: f64) -> f64 {
    let (sine, cosine) = (turns * std::f64::consts::TAU).sin_cos();
    // Sides of the field and of both blocks: the axis that they are square to, where they are on it, and their ends.
    let sides = [
        (0, 0.0, [0.0, 900.0]),
        (0, 1200.0, [0.0, 900.0]),
        (1, 0.0, [0.0, 1200.0]),
        (1, 900.0, [0.0, 1200.0]),
        (0, 300.0, [0.0, 200.0]),
        (0, 600.0, [0.0, 200.0]),
        (1, 200.0, [300.0, 600.0]),
        (0, 900.0, [600.0, 900.0]),
        (1, 600.0, [900.0, 1200.0]),
    ];
    sides.iter().fold(120.0_f64, |least, &(axis, place, [from, to])| {
        let [(at, along), (other, aside)] = if axis == 0 {
            [(x, cosine), (y, sine)]
        } else {
            [(y, sine), (x, cosine)]
        };
        let far = (place - at) / along;
        let is_hit = far >= 0.0 && (from..=to).contains(&(other + far * aside));
        if is_hit { least.min(far) } else { least }
    })
}

/// A cycle earns the speed forward times how near the wall on the right is to the set distance, and nothing in a collision. A
/// distance that is off by a hundredth of a millimetre is noticed.
#[test]
fn wall_following_earns_speed_at_the_distance() {
    let (mut earned, mut noticed, mut collisions) = (0, 0, 0);
    for life in traces("wall-following", 12, 5.0) {
        for cycle in life.windows(2) {
            let [x, y, heading] = cycle[1].pose;
            let aside = distance([x, y], heading - 0.25);
            let error = |set: f64| {
                let near = (1.0 - (aside - set).abs() / 40.0).max(0.0);
                let earned = near * cycle[0].speed.max(0.0) / 600.0;
                (cycle[0].reward - if cycle[0].collided { 0.0 } else { earned }).abs()
            };
            assert!(error(80.0) < 2e-8, "{} {aside} {}", cycle[0].reward, error(80.0));
            earned += u32::from(cycle[0].reward > 0.0);
            noticed += u32::from(cycle[0].reward > 0.0 && error(80.01) > 2e-8);
            collisions += u32::from(cycle[0].collided);
        }
        assert_eq!(life.len(), 600);
    }
    println!("{earned} cycles earn, of which {noticed} notice; {collisions} collisions");
    assert!(earned > 200 && noticed > 200 && collisions > 200);
}
