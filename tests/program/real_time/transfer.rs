//! Controllers evolved for a Thymio II and an e-puck that were sampled in Aseba's simulator live in that simulator. With `ONEIRO_LONG`
//! (`tests/long.sh`) the robots are sampled whole, and champions live beside others that evolved in the simulator; docs/measurements.md has the figures.
#![cfg(target_os = "linux")]

use std::env;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use oneiro::tables::SensorTables;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::Value;

use crate::aseba::crowd::{EPUCK, Kind, Pose, THYMIO, Things, cell, children};
use crate::aseba::in_a_network;
use crate::place::Place;

/// A robot that is sampled: its experiment in `tests/transfer`, with its tables beside it; its tables' rows from the rim on and mm between them, and the measured speed of a wheel in mm/s
/// at the greatest target and distance between the wheels in mm.
struct Sampled {
    kind: &'static Kind,
    experiment: &'static str,
    rows: usize,
    spacing: f64,
    wheels: [f64; 2],
    /// The sensor that looks ahead, what it reads where `wheels` notes the time, and the distance from the wall at which a robot turns.
    ahead: (usize, f64, f64),
    /// What share of the fitness of champions that evolved there those of the samples must have.
    share: Option<f64>,
}

const SAMPLED_THYMIO: Sampled = Sampled {
    kind: &THYMIO,
    experiment: "thymio.toml",
    rows: 15,
    spacing: 10.0,
    wheels: [166.0, 94.0],
    ahead: (2, 2500.0, 120.0),
    share: Some(0.9),
};
const SAMPLED_EPUCK: Sampled = Sampled {
    kind: &EPUCK,
    experiment: "epuck/epuck.toml",
    rows: 20,
    spacing: 3.0,
    wheels: [128.0, 51.0],
    ahead: (0, 200.0, 45.0),
    // studies/miglino1995/README.md: much is lost.
    share: None,
};
const BEARINGS: usize = 72;

impl Sampled {
    /// Where the experiment and its tables are.
    fn folder(&self) -> PathBuf {
        let experiment = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../tests/transfer")
            .join(self.experiment);
        experiment.parent().unwrap().to_owned()
    }
}
const SEEDS: u64 = 3;

/// Whether tests take as long as they need.
fn is_long() -> bool {
    env::var_os("ONEIRO_LONG").is_some()
}

/// Readings for some cells of a table, from 0 to 1023: each of a robot of its own, before a wall or a cylinder of its own, in the
/// middle of the cell. Cells are numbered row by row.
fn sample(of: &Sampled, is_round: bool, cells: &[usize]) -> Vec<Vec<u16>> {
    const CELL: f64 = 700.0;
    const ROBOTS: usize = 120;
    let (kind, mut table) = (of.kind, Vec::new());
    for part in cells.chunks(ROBOTS) {
        let (mut things, mut side) = (Things::new(kind), 0.0);
        for (index, number) in part.iter().enumerate() {
            let (row, bearing) = (number / BEARINGS, number % BEARINGS);
            let (corner, whole) = cell(index, part.len(), CELL);
            side = whole;
            let [x, y] = corner.map(|corner| corner + CELL / 2.0);
            let distance = kind.body + (row as f64 + 0.5) * of.spacing;
            // The object is in the direction of the x axis, and bearings are clockwise from the heading.
            things.robot([x, y, (bearing as f64 + 0.5) / BEARINGS as f64 * TAU]);
            if is_round {
                things.cylinder([x + distance + kind.cylinder, y]);
            } else {
                things.wall([x + distance + 5.0, y], [10.0, 600.0]);
            }
        }
        table.extend(things.live([side; 2], |robots| {
            // An odd number: the simulator doubles a reading now and then, which the median leaves out.
            const READINGS: usize = 5;
            let mut seen = vec![vec![[0.0; READINGS]; kind.sensors]; robots.len()];
            for number in 0..READINGS {
                let last = kind.sense(robots)[0].0;
                // Another step, with other noise.
                while kind.sense(robots)[0].0 < last + 4 {}
                for (seen, (_, readings)) in seen.iter_mut().zip(kind.sense(robots)) {
                    (0..kind.sensors).for_each(|sensor| seen[sensor][number] = readings[sensor]);
                }
            }
            let median = |mut readings: [f64; READINGS]| {
                readings.sort_by(f64::total_cmp);
                (readings[READINGS / 2] / kind.touch * 1023.0).round().min(1023.0) as u16
            };
            seen.into_iter()
                .map(|own| own.into_iter().map(median).collect())
                .collect::<Vec<_>>()
        }));
    }
    table
}

/// A table as a file has it.
fn sam(of: &Sampled, table: &[Vec<u16>]) -> String {
    let mut text = format!("{} {BEARINGS} {} 0 {}\n", of.kind.sensors, of.rows, of.spacing);
    for (row, lines) in table.chunks(BEARINGS).enumerate() {
        writeln!(text, "TURN {row}").unwrap();
        for line in lines {
            let words: Vec<String> = line.iter().map(u16::to_string).collect();
            writeln!(text, "{}", words.join(" ")).unwrap();
        }
    }
    text + "END\n"
}

/// When a sensor's reading passes a threshold upwards, in s, between two readings. Noise may pass it several times: in between
/// it must have fallen far below. The simulator doubles a reading now and then: the next one must be above it, too.
fn crossings(seen: &[(usize, f64)], threshold: f64) -> Vec<f64> {
    let (mut crossings, mut is_low) = (Vec::new(), true);
    for some in seen.windows(3) {
        let [(before, low), (after, high), (_, next)] = [some[0], some[1], some[2]];
        is_low |= low < threshold / 3.0;
        if is_low && low < threshold && high.min(next) >= threshold {
            let share = (threshold - low) / (high - low);
            crossings.push((before as f64 + share * (after - before) as f64) / 100.0);
            is_low = false;
        }
    }
    crossings
}

/// Speeds of a wheel in mm/s and distances between the wheels in mm, for some targets: two robots drive towards a wall from
/// places 300 mm apart, and a third one turns before a wall.
fn wheels(of: &Sampled, targets: &[f64]) -> Vec<[f64; 2]> {
    const LANE: f64 = 800.0;
    let (kind, (ahead, near, turning)) = (of.kind, of.ahead);
    let mut things = Things::new(kind);
    for (index, _) in targets.iter().enumerate() {
        let y = LANE * (index as f64 + 0.5);
        for (column, distance) in [300.0, 600.0, turning].into_iter().enumerate() {
            let x = 1000.0 * (column as f64 + 1.0);
            things.robot([x - distance, y, 0.0]);
            things.wall([x + 5.0, y], [10.0, 600.0]);
        }
    }
    let size = [3100.0, LANE * targets.len() as f64];
    things.live(size, |robots| {
        for (robots, target) in robots.chunks_mut(3).zip(targets) {
            let ways = [[*target; 2], [*target; 2], [-target, *target]];
            robots
                .iter_mut()
                .zip(ways)
                .for_each(|(robot, way)| kind.drive(robot, way));
        }
        // Each has a clock of its own.
        let first: Vec<usize> = kind.sense(robots).into_iter().map(|(clock, _)| clock).collect();
        let mut seen = vec![Vec::new(); robots.len()];
        while seen[0].last().is_none_or(|(clock, _)| *clock < 4000) {
            for ((seen, first), (clock, readings)) in seen.iter_mut().zip(&first).zip(kind.sense(robots)) {
                let clock = clock - first;
                if seen.last().is_none_or(|(last, _)| *last < clock) {
                    seen.push((clock, readings[ahead]));
                }
            }
        }
        let measured = seen.chunks(3).map(|seen| {
            let [first, second] = [0, 1].map(|robot| crossings(&seen[robot], near)[0]);
            let turns = crossings(&seen[2], near);
            // The median, since a busy client misses a turn now and then.
            let mut periods: Vec<f64> = turns.windows(2).map(|turn| turn[1] - turn[0]).collect();
            periods.sort_by(f64::total_cmp);
            let period = periods[periods.len() / 2];
            let speed = 300.0 / (second - first);
            [speed, 2.0 * speed * period / TAU]
        });
        measured.collect()
    })
}

/// Random genes.
fn genes(kind: &Kind, random: &mut Pcg64) -> Vec<f64> {
    (0..kind.genes()).map(|_| 2.0 * random.random::<f64>() - 1.0).collect()
}

/// Evolves in the simulator with the experiment's budget and its genetic algorithm. Returns the individual of the highest
/// fitness, as the experiment does.
fn evolve(kind: &'static Kind, seed: u64) -> Vec<f64> {
    const GENERATIONS: usize = 30;
    const POPULATION: usize = 40;
    const PARENTS: usize = 8;
    let mut random = Pcg64::seed_from_u64(seed);
    let mut population: Vec<Vec<f64>> = (0..POPULATION).map(|_| genes(kind, &mut random)).collect();
    let mut champion = (f64::MIN, Vec::new());
    for generation in 0..GENERATIONS {
        let subjects: Vec<(&[f64], Pose)> = population
            .iter()
            .map(|genes| (&genes[..], kind.start(&mut random)))
            .collect();
        let lived = kind.lives(&subjects);
        let best = (0..POPULATION)
            .max_by(|a, b| lived.fitness[*a].total_cmp(&lived.fitness[*b]))
            .unwrap();
        if lived.fitness[best] > champion.0 {
            champion = (lived.fitness[best], population[best].clone());
        }
        let mean = lived.fitness.iter().sum::<f64>() / POPULATION as f64;
        eprintln!(
            "seed {seed}, generation {generation}: best {:.1}, mean {mean:.1}; cycles up to {} ms",
            lived.fitness[best], lived.longest
        );
        population = children(&population, &lived.fitness, PARENTS, &mut random);
    }
    champion.1
}

/// Champions that evolved for the sampled robot, one for each seed.
fn evolved_for_samples(place: &Place, robot: &Sampled, collision: &str, seeds: u64) -> Vec<Vec<f64>> {
    let count = seeds as usize;
    let (set, seeds) = (format!("robot.collision={collision}"), format!("1..{seeds}"));
    place.good(&[
        "run",
        "robot.toml",
        "--seeds",
        &seeds,
        "--set",
        &set,
        "--out",
        collision,
        "--quiet",
    ]);
    let mut runs: Vec<_> = fs::read_dir(place.at(collision))
        .unwrap()
        .map(|run| run.unwrap().path())
        .collect();
    runs.retain(|run| run.join("champion.json").exists());
    runs.sort();
    assert_eq!(runs.len(), count);
    let genes = |run: &Path| {
        let champion: Value = serde_json::from_slice(&fs::read(run.join("champion.json")).unwrap()).unwrap();
        let genes: Vec<f64> = champion["genome"]
            .as_array()
            .unwrap()
            .iter()
            .map(|gene| gene.as_f64().unwrap())
            .collect();
        assert_eq!(genes.len(), robot.kind.genes());
        eprintln!("{collision}: {} in its own world", champion["fitness"]);
        genes
    };
    runs.iter().map(|run| genes(run)).collect()
}

/// The tables are those that the experiment has: in some cells, with `ONEIRO_LONG` in all. With `ONEIRO_ACCEPT` they are written.
fn samples(test: &str, robot: &Sampled) {
    if !in_a_network(test, "a robot sampled in Aseba's simulator") {
        return;
    }
    let accepts = env::var_os("ONEIRO_ACCEPT").is_some();
    // All bearings and rows come up in turn.
    let every = if is_long() || accepts { 1 } else { 37 };
    let cells: Vec<usize> = (0..robot.rows * BEARINGS).step_by(every).collect();
    for (name, is_round) in [("wall", false), ("round", true)] {
        let start = Instant::now();
        let table = sample(robot, is_round, &cells);
        eprintln!("{name}: {} cells in {:.0?}", table.len(), start.elapsed());
        let path = robot.folder().join(format!("{name}.sam"));
        if accepts {
            fs::write(path, sam(robot, &table)).unwrap();
            continue;
        }
        let kept = SensorTables::read(&[path]).unwrap().table;
        let differences = cells.iter().zip(&table).flat_map(|(cell, found)| {
            let kept = kept.classes[0].cell(*cell);
            kept.iter().zip(found).map(|(kept, found)| kept.abs_diff(*found))
        });
        let worst = differences.max().unwrap();
        eprintln!("{name}: readings differ from the file's by {worst} of 1023 at most");
        // Of noise, no reading may be off by much.
        assert!(worst <= 10, "{name}: {worst}");
    }
}

#[test]
fn samples_of_the_simulators_thymio() {
    samples("samples_of_the_simulators_thymio", &SAMPLED_THYMIO);
}

#[test]
fn samples_of_the_simulators_epuck() {
    samples("samples_of_the_simulators_epuck", &SAMPLED_EPUCK);
}

/// The wheels are those that the experiment describes. A busy client misses what the robots report, so one of three measurements is
/// enough; wheels that are otherwise are so each time.
fn measured_wheels(test: &str, robot: &Sampled) {
    if !in_a_network(test, "wheels measured in Aseba's simulator") {
        return;
    }
    let (full, [speed, base]) = (robot.kind.greatest, robot.wheels);
    let targets = [0.4, 0.6, 0.8, 1.0].map(|share| share * full);
    let is_as_described = |_| {
        let mut found = targets.iter().zip(wheels(robot, &targets));
        found.all(|(target, [found, apart])| {
            let greatest = found * full / target;
            eprintln!("target {target}: {found:.1} mm/s, which is {greatest:.1} at {full}; wheels {apart:.1} mm apart");
            (greatest / speed - 1.0).abs() < 0.018 && (apart / base - 1.0).abs() < 0.04
        })
    };
    assert!((0..3).any(is_as_described));
}

#[test]
fn wheels_of_the_simulators_thymio() {
    measured_wheels("wheels_of_the_simulators_thymio", &SAMPLED_THYMIO);
}

#[test]
fn wheels_of_the_simulators_epuck() {
    measured_wheels("wheels_of_the_simulators_epuck", &SAMPLED_EPUCK);
}

/// Mean fitness of a controller's lives from these starts.
fn mean_of(robot: &Sampled, kind: &str, genes: &[f64], starts: &[Pose]) -> f64 {
    let subjects: Vec<(&[f64], Pose)> = starts.iter().map(|start| (genes, *start)).collect();
    let lived = robot.kind.lives(&subjects);
    let mean = lived.fitness.iter().sum::<f64>() / lived.fitness.len() as f64;
    eprintln!(
        "{kind}: mean {mean:.1}; cycles up to {} ms, {:.2} % late",
        lived.longest,
        100.0 * lived.late
    );
    mean
}

/// Champions of the sampled robot live in the simulator: better than random controllers do and, with `ONEIRO_LONG`, at least as
/// well as a share says of champions that evolved there.
fn champions(test: &str, robot: &'static Sampled) {
    if !in_a_network(test, "transfer to Aseba's simulator") {
        return;
    }
    let place = Place::new(test);
    let experiment = Path::new(robot.experiment).file_name().unwrap();
    place.write("robot.toml", fs::read(robot.folder().join(experiment)).unwrap());
    for table in ["wall.sam", "round.sam"] {
        place.write(table, fs::read(robot.folder().join(table)).unwrap());
    }
    // All champions from the same starts.
    let mut random = Pcg64::seed_from_u64(1000);
    let starts: Vec<Pose> = (0..20).map(|_| robot.kind.start(&mut random)).collect();
    let Some(share) = robot.share.filter(|_| is_long()) else {
        let champion = mean_of(
            robot,
            "undo",
            &evolved_for_samples(&place, robot, "undo", 1)[0],
            &starts,
        );
        let genes = genes(robot.kind, &mut random);
        let other = mean_of(robot, "random", &genes, &starts);
        assert!(champion > 2.0 * other, "{champion} {other}");
        return;
    };
    let mut kinds: Vec<(&str, Vec<Vec<f64>>)> = ["undo", "slide"]
        .into_iter()
        .map(|collision| (collision, evolved_for_samples(&place, robot, collision, SEEDS)))
        .collect();
    kinds.push((
        "evolved in the simulator",
        (1..=SEEDS).map(|seed| evolve(robot.kind, seed)).collect(),
    ));
    let mut means = Vec::new();
    for (kind, champions) in &kinds {
        let all: Vec<f64> = champions
            .iter()
            .map(|genes| mean_of(robot, kind, genes, &starts))
            .collect();
        means.push(all.iter().sum::<f64>() / all.len() as f64);
    }
    let [undo, slide, own] = means[..] else { unreachable!() };
    eprintln!("undo {undo:.1}, slide {slide:.1}, evolved in the simulator {own:.1}");
    eprintln!("shares of the last: undo {:.3}, slide {:.3}", undo / own, slide / own);
    assert!(undo.min(slide) >= share * own);
}

#[test]
fn champions_of_the_sampled_robot_live_in_the_simulator() {
    champions("champions_of_the_sampled_robot_live_in_the_simulator", &SAMPLED_THYMIO);
}

#[test]
fn champions_of_the_sampled_epuck_live_in_the_simulator() {
    champions("champions_of_the_sampled_epuck_live_in_the_simulator", &SAMPLED_EPUCK);
}
