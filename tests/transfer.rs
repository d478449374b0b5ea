//! Controllers evolved for a robot that was sampled in Aseba's simulator live in that simulator. With `ONEIRO_LONG` (`tests/long.sh`)
//! the robot is sampled whole, and champions live beside others that evolved in the simulator; docs/measurements.md has the figures.
#![cfg(target_os = "linux")]

use std::env;
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::time::Instant;

use oneiro::tables::SensorTables;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::Value;

#[allow(dead_code, reason = "other tests use the rest")]
mod aseba;
#[allow(dead_code, reason = "other tests use the rest")]
mod place;
mod skips;
use aseba::client::Client;
use aseba::{FIRST_PORT, in_a_network, live, world};
use place::Place;

/// How much faster than real time the simulator runs.
const SPEED: u32 = 10;
/// Readings of a sensor that is touched.
const TOUCH: f64 = 4500.0;
/// Radius of the body in the tables, and of cylinders, mm.
const BODY: f64 = 80.0;
const CYLINDER: f64 = 40.0;
/// Tables: rows from the rim on, 10 mm apart, and bearings.
const ROWS: usize = 15;
const SPACING: f64 = 10.0;
const BEARINGS: usize = 72;
/// Robots in a world.
const CROWD: usize = 40;
/// Side of an arena, mm.
const SIDE: f64 = 1000.0;
/// A life, in cycles of 100 ms.
const CYCLES: usize = 500;
const SENSORS: usize = 7;
const GENES: usize = 2 * (SENSORS + 1);
const GREATEST: f64 = 500.0;
const SEEDS: u64 = 3;

/// A place in mm and a heading in rad.
type Pose = [f64; 3];

/// Elements of a world, whose lengths are in cm.
#[derive(Default)]
struct Things(String, usize);

impl Things {
    fn robot(&mut self, [x, y, heading]: Pose) {
        let (index, port) = (self.1, FIRST_PORT + self.1 as u16);
        writeln!(
            self.0,
            r#"<robot type="thymio2" x="{}" y="{}" angle="{heading}" port="{port}" name="r{index}" nodeId="{}"/>"#,
            x / 10.0,
            y / 10.0,
            index + 1
        )
        .unwrap();
        self.1 += 1;
    }

    /// A wall of these sides along the axes, about a place.
    fn wall(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2]) {
        let [x, y, width, height] = [x, y, width, height].map(|length| length / 10.0);
        writeln!(
            self.0,
            r#"<wall x="{x}" y="{y}" l1="{width}" l2="{height}" h="10" angle="0" color="white"/>"#
        )
        .unwrap();
    }

    fn cylinder(&mut self, [x, y]: [f64; 2]) {
        writeln!(
            self.0,
            r#"<cylinder x="{}" y="{}" r="{}" h="10" color="white"/>"#,
            x / 10.0,
            y / 10.0,
            CYLINDER / 10.0
        )
        .unwrap();
    }

    /// Starts the simulator with these, and connects to all robots. Each counts steps of 10 ms as its clock.
    fn live<T>(&self, [width, height]: [f64; 2], scenario: impl Fn(&mut Vec<Client>) -> T) -> T {
        let world = world(width / 10.0, height / 10.0, &self.0);
        live(&world, self.1 as u16, SPEED, |_| {
            let ports = FIRST_PORT..FIRST_PORT + self.1 as u16;
            let mut robots: Vec<Client> = ports.map(Client::connect).collect();
            for robot in &mut robots {
                robot.count("motor", "clock");
            }
            scenario(&mut robots)
        })
    }
}

/// What robots sense at about one time: the clock in units of 10 ms, and the sensors of proximity.
fn sense(robots: &mut [Client]) -> Vec<(usize, [f64; SENSORS])> {
    for robot in robots.iter_mut() {
        robot.ask_all("prox.horizontal", "clock");
    }
    let answer = |robot: &mut Client| {
        let words = robot.answer();
        let clock = *words.last().unwrap() as u16;
        (usize::from(clock), [0, 1, 2, 3, 4, 5, 6].map(|at| f64::from(words[at])))
    };
    robots.iter_mut().map(answer).collect()
}

/// Sets the targets of the wheels.
fn drive(robot: &mut Client, targets: [f64; 2]) {
    let words = targets.map(|target| target.round() as i16);
    robot.set("motor.left.target", &words);
}

/// The place of the cell of this index in a square of `count` cells of a size, and the square's side.
fn cell(index: usize, count: usize, size: f64) -> ([f64; 2], f64) {
    let columns = (count as f64).sqrt().ceil() as usize;
    let corner = [index % columns, index / columns].map(|at| at as f64 * size);
    (corner, columns as f64 * size)
}

/// Whether tests take as long as they need.
fn is_long() -> bool {
    env::var_os("ONEIRO_LONG").is_some()
}

/// Readings for some cells of a table, from 0 to 1023: each of a robot of its own, before a wall or a cylinder of its own, in the
/// middle of the cell. Cells are numbered row by row.
fn sample(is_round: bool, cells: &[usize]) -> Vec<[u16; SENSORS]> {
    const CELL: f64 = 700.0;
    const ROBOTS: usize = 120;
    let mut table = Vec::new();
    for part in cells.chunks(ROBOTS) {
        let (mut things, mut side) = (Things::default(), 0.0);
        for (index, number) in part.iter().enumerate() {
            let (row, bearing) = (number / BEARINGS, number % BEARINGS);
            let (corner, whole) = cell(index, part.len(), CELL);
            side = whole;
            let [x, y] = corner.map(|corner| corner + CELL / 2.0);
            let distance = BODY + (row as f64 + 0.5) * SPACING;
            // The object is in the direction of the x axis, and bearings are clockwise from the heading.
            things.robot([x, y, (bearing as f64 + 0.5) / BEARINGS as f64 * TAU]);
            if is_round {
                things.cylinder([x + distance + CYLINDER, y]);
            } else {
                things.wall([x + distance + 5.0, y], [10.0, 600.0]);
            }
        }
        table.extend(things.live([side; 2], |robots| {
            // An odd number: the simulator doubles a reading now and then, which the median leaves out.
            const READINGS: usize = 5;
            let mut seen = vec![[[0.0; READINGS]; SENSORS]; robots.len()];
            for number in 0..READINGS {
                let last = sense(robots)[0].0;
                // Another step, with other noise.
                while sense(robots)[0].0 < last + 4 {}
                for (seen, (_, readings)) in seen.iter_mut().zip(sense(robots)) {
                    (0..SENSORS).for_each(|sensor| seen[sensor][number] = readings[sensor]);
                }
            }
            let median = |mut readings: [f64; READINGS]| {
                readings.sort_by(f64::total_cmp);
                (readings[READINGS / 2] / TOUCH * 1023.0).round().min(1023.0) as u16
            };
            seen.into_iter().map(|own| own.map(median)).collect::<Vec<_>>()
        }));
    }
    table
}

/// A table as a file has it.
fn sam(table: &[[u16; SENSORS]]) -> String {
    let mut text = format!("{SENSORS} {BEARINGS} {ROWS} 0 {SPACING}\n");
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
/// it must have fallen to nearly nothing. The simulator doubles a reading now and then: the next one must be above it, too.
fn crossings(seen: &[(usize, f64)], threshold: f64) -> Vec<f64> {
    let (mut crossings, mut is_low) = (Vec::new(), true);
    for some in seen.windows(3) {
        let [(before, low), (after, high), (_, next)] = [some[0], some[1], some[2]];
        is_low |= low < threshold / 10.0;
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
fn wheels(targets: &[f64]) -> Vec<[f64; 2]> {
    const LANE: f64 = 800.0;
    const NEAR: f64 = 2500.0;
    let mut things = Things::default();
    for (index, _) in targets.iter().enumerate() {
        let y = LANE * (index as f64 + 0.5);
        for (column, distance) in [300.0, 600.0, 120.0].into_iter().enumerate() {
            let x = 1000.0 * (column as f64 + 1.0);
            things.robot([x - distance, y, 0.0]);
            things.wall([x + 5.0, y], [10.0, 600.0]);
        }
    }
    let size = [3100.0, LANE * targets.len() as f64];
    things.live(size, |robots| {
        for (robots, target) in robots.chunks_mut(3).zip(targets) {
            let ways = [[*target; 2], [*target; 2], [-target, *target]];
            robots.iter_mut().zip(ways).for_each(|(robot, way)| drive(robot, way));
        }
        // Each has a clock of its own.
        let first: Vec<usize> = sense(robots).into_iter().map(|(clock, _)| clock).collect();
        let mut seen = vec![Vec::new(); robots.len()];
        while seen[0].last().is_none_or(|(clock, _)| *clock < 4000) {
            for ((seen, first), (clock, readings)) in seen.iter_mut().zip(&first).zip(sense(robots)) {
                let clock = clock - first;
                if seen.last().is_none_or(|(last, _)| *last < clock) {
                    seen.push((clock, readings[2]));
                }
            }
        }
        let measured = seen.chunks(3).map(|seen| {
            let [near, far] = [0, 1].map(|robot| crossings(&seen[robot], NEAR)[0]);
            let turns = crossings(&seen[2], NEAR);
            let period = (turns.last().unwrap() - turns[0]) / (turns.len() - 1) as f64;
            let speed = 300.0 / (far - near);
            [speed, 2.0 * speed * period / TAU]
        });
        measured.collect()
    })
}

/// A free pose in the arena.
fn start(random: &mut Pcg64) -> Pose {
    loop {
        let mut within = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let [x, y] = [(); 2].map(|()| within(BODY, SIDE - BODY));
        let heading = within(-PI, PI);
        if (x - SIDE / 2.0).hypot(y - SIDE / 2.0) >= BODY + CYLINDER {
            return [x, y, heading];
        }
    }
}

/// What a perceptron's two wheels do, from -1 to 1, for readings from 0 to 1.
fn decide(genes: &[f64], readings: [f64; SENSORS]) -> [f64; 2] {
    let wheel = |genes: &[f64]| {
        let sum: f64 = genes.iter().zip(readings).map(|(gene, reading)| gene * reading).sum();
        2.0 / (1.0 + (-sum - genes[SENSORS]).exp()) - 1.0
    };
    [wheel(&genes[..=SENSORS]), wheel(&genes[SENSORS + 1..])]
}

/// Lives in the simulator, up to `CROWD` at once, each in a walled arena of its own: fitness of each, by equation 1 without its
/// rule for collisions, which no client sees; and the longest cycle in ms.
fn lives(of: &[(&[f64], Pose)]) -> (Vec<f64>, usize) {
    const WALL: f64 = 10.0;
    let (mut fitness, mut longest) = (Vec::new(), 0);
    for part in of.chunks(CROWD) {
        let (mut things, mut side) = (Things::default(), 0.0);
        for (index, (_, [x, y, heading])) in part.iter().enumerate() {
            let ([left, below], whole) = cell(index, part.len(), SIDE + WALL);
            side = whole + WALL;
            let [left, below] = [left + WALL, below + WALL];
            things.robot([left + x, below + y, *heading]);
            let [middle, half, long] = [SIDE / 2.0, WALL / 2.0, SIDE + 2.0 * WALL];
            for (x, y, size) in [
                (-half, middle, [WALL, long]),
                (SIDE + half, middle, [WALL, long]),
                (middle, -half, [long, WALL]),
                (middle, SIDE + half, [long, WALL]),
            ] {
                things.wall([left + x, below + y], size);
            }
            things.cylinder([left + middle, below + middle]);
        }
        let (part, cycle) = things.live([side; 2], |robots| {
            let first: Vec<usize> = sense(robots).into_iter().map(|(clock, _)| clock).collect();
            let mut sums = vec![0.0; part.len()];
            let mut done = vec![(0_usize, 0_usize); part.len()];
            let mut longest = 0;
            while done.iter().any(|(cycles, _)| *cycles < CYCLES) {
                for (index, (clock, readings)) in sense(robots).into_iter().enumerate() {
                    let (cycles, last) = &mut done[index];
                    let now = clock - first[index];
                    if *cycles == CYCLES || now < 10 * *cycles {
                        continue;
                    }
                    longest = longest.max(10 * (now - *last));
                    (*cycles, *last) = (*cycles + 1, now);
                    let readings = readings.map(|reading| (reading / TOUCH).clamp(0.0, 1.0));
                    let [left, right] = decide(part[index].0, readings);
                    drive(&mut robots[index], [left, right].map(|speed| speed * GREATEST));
                    let nearest = readings.into_iter().fold(0.0, f64::max);
                    let straight = 1.0 - ((left - right).abs() / 2.0).sqrt();
                    sums[index] += f64::midpoint(left.abs(), right.abs()) * straight * (1.0 - nearest);
                }
            }
            (sums, longest)
        });
        fitness.extend(part);
        longest = longest.max(cycle);
    }
    (fitness, longest)
}

/// Evolves in the simulator with the experiment's budget and its genetic algorithm. Returns the individual of the highest
/// fitness, as the experiment does.
fn evolve(seed: u64) -> Vec<f64> {
    const GENERATIONS: usize = 30;
    const PARENTS: usize = 8;
    let mut random = Pcg64::seed_from_u64(seed);
    let within = |random: &mut Pcg64| 2.0 * random.random::<f64>() - 1.0;
    let mut population: Vec<Vec<f64>> = (0..CROWD)
        .map(|_| (0..GENES).map(|_| within(&mut random)).collect())
        .collect();
    let mut champion = (f64::MIN, Vec::new());
    for generation in 0..GENERATIONS {
        let subjects: Vec<(&[f64], Pose)> = population
            .iter()
            .map(|genes| (&genes[..], start(&mut random)))
            .collect();
        let (fitness, longest) = lives(&subjects);
        let mut order: Vec<usize> = (0..CROWD).collect();
        order.sort_by(|a, b| fitness[*b].total_cmp(&fitness[*a]));
        let best = order[0];
        if fitness[best] > champion.0 {
            champion = (fitness[best], population[best].clone());
        }
        let mean = fitness.iter().sum::<f64>() / CROWD as f64;
        eprintln!(
            "seed {seed}, generation {generation}: best {:.1}, mean {mean:.1}; cycles up to {longest} ms",
            fitness[best]
        );
        let mut child = |parent: &usize| {
            let mutate = |gene: &f64| {
                let change = within(&mut random);
                if random.random::<f64>() < 0.25 {
                    gene + change
                } else {
                    *gene
                }
            };
            population[*parent].iter().map(mutate).collect::<Vec<f64>>()
        };
        population = (0..CROWD).map(|index| child(&order[index % PARENTS])).collect();
    }
    champion.1
}

/// Champions that evolved for the sampled robot, one for each seed.
fn evolved_for_samples(place: &Place, collision: &str, seeds: u64) -> Vec<Vec<f64>> {
    let count = seeds as usize;
    let (set, seeds) = (format!("robot.collision={collision}"), format!("1..{seeds}"));
    place.good(&[
        "run",
        "thymio.toml",
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
        assert_eq!(genes.len(), GENES);
        eprintln!("{collision}: {} in its own world", champion["fitness"]);
        genes
    };
    runs.iter().map(|run| genes(run)).collect()
}

/// Where the experiment and its tables are.
fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/transfer")
}

/// The tables are those that the experiment has: in some cells, with `ONEIRO_LONG` in all. With `ONEIRO_ACCEPT` they are written.
#[test]
fn samples_of_the_simulators_thymio() {
    if !in_a_network(
        "samples_of_the_simulators_thymio",
        "a robot sampled in Aseba's simulator",
    ) {
        return;
    }
    let accepts = env::var_os("ONEIRO_ACCEPT").is_some();
    // All bearings and rows come up in turn.
    let every = if is_long() || accepts { 1 } else { 37 };
    let cells: Vec<usize> = (0..ROWS * BEARINGS).step_by(every).collect();
    for (name, is_round) in [("wall", false), ("round", true)] {
        let start = Instant::now();
        let table = sample(is_round, &cells);
        eprintln!("{name}: {} cells in {:.0?}", table.len(), start.elapsed());
        let path = folder().join(format!("{name}.sam"));
        if accepts {
            fs::write(path, sam(&table)).unwrap();
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

/// The wheels are those that the experiment describes.
#[test]
fn wheels_of_the_simulators_thymio() {
    if !in_a_network(
        "wheels_of_the_simulators_thymio",
        "wheels measured in Aseba's simulator",
    ) {
        return;
    }
    let targets = [200.0, 300.0, 400.0, 500.0];
    for (target, [speed, base]) in targets.iter().zip(wheels(&targets)) {
        let greatest = speed * GREATEST / target;
        eprintln!("target {target}: {speed:.1} mm/s, which is {greatest:.1} at {GREATEST}; wheels {base:.1} mm apart");
        assert!((greatest - 166.0).abs() < 3.0 && (base - 94.0).abs() < 4.0);
    }
}

/// Mean fitness of a controller's lives from these starts.
fn mean_of(kind: &str, genes: &[f64], starts: &[Pose]) -> f64 {
    let subjects: Vec<(&[f64], Pose)> = starts.iter().map(|start| (genes, *start)).collect();
    let (fitness, longest) = lives(&subjects);
    let mean = fitness.iter().sum::<f64>() / fitness.len() as f64;
    eprintln!("{kind}: mean {mean:.1}; cycles up to {longest} ms");
    mean
}

/// Champions of the sampled robot live in the simulator: better than random controllers do and, with `ONEIRO_LONG`, at least 0.9
/// as well as champions that evolved there.
#[test]
fn champions_of_the_sampled_robot_live_in_the_simulator() {
    if !in_a_network(
        "champions_of_the_sampled_robot_live_in_the_simulator",
        "transfer to Aseba's simulator",
    ) {
        return;
    }
    let place = Place::new("transfer");
    for file in ["thymio.toml", "wall.sam", "round.sam"] {
        place.write(file, fs::read(folder().join(file)).unwrap());
    }
    // All champions from the same starts.
    let mut random = Pcg64::seed_from_u64(1000);
    let starts: Vec<Pose> = (0..20).map(|_| start(&mut random)).collect();
    if !is_long() {
        let champion = mean_of("undo", &evolved_for_samples(&place, "undo", 1)[0], &starts);
        let genes: Vec<f64> = (0..GENES).map(|_| 2.0 * random.random::<f64>() - 1.0).collect();
        let other = mean_of("random", &genes, &starts);
        assert!(champion > 2.0 * other, "{champion} {other}");
        return;
    }
    let mut kinds: Vec<(&str, Vec<Vec<f64>>)> = ["undo", "slide"]
        .into_iter()
        .map(|collision| (collision, evolved_for_samples(&place, collision, SEEDS)))
        .collect();
    kinds.push(("evolved in the simulator", (1..=SEEDS).map(evolve).collect()));
    let mut means = Vec::new();
    for (kind, champions) in &kinds {
        let all: Vec<f64> = champions.iter().map(|genes| mean_of(kind, genes, &starts)).collect();
        means.push(all.iter().sum::<f64>() / all.len() as f64);
    }
    let [undo, slide, own] = means[..] else { unreachable!() };
    eprintln!("undo {undo:.1}, slide {slide:.1}, evolved in the simulator {own:.1}");
    eprintln!("shares of the last: undo {:.3}, slide {:.3}", undo / own, slide / own);
    assert!(undo.min(slide) >= 0.9 * own);
}
