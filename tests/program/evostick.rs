//! EvoStick's missions: published networks lived again beside their recorded scores, each mission's score beside a second program's, and
//! a short run.

use std::fs;
use std::path::{Path, PathBuf};

use crate::place::Place;
use crate::skips::skipped;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The published networks of a mission, as genomes of `epuck-rm1.2`, and the score that was recorded for each. `None` if they are not
/// there.
fn published(mission: &str) -> Option<(String, Vec<f64>)> {
    let text = fs::read_to_string(root().join("../shared/data/evostick/genomes.csv")).ok()?;
    let quarters = |of: &str| [45, 135, 225, 315].map(|degrees| format!("{of}_{degrees}"));
    let (near, bright, drawn) = (quarters("prox"), quarters("light"), quarters("attraction"));
    let scalars = ["ground", "neighbours"].map(str::to_owned);
    let inputs = [&near[..], &bright, &scalars, &drawn].concat();
    let weights = inputs
        .iter()
        .flat_map(|input| ["left", "right"].map(|wheel| format!("{input}_to_{wheel}")));
    let names: Vec<_> = weights.chain(["bias_left".into(), "bias_right".into()]).collect();
    let mut genomes = names.join(",") + "\n";
    let mut scores = Vec::new();
    for line in text.lines().skip(1) {
        let fields: Vec<_> = line.split(',').collect();
        if fields[1] == mission {
            scores.push(fields[3].parse().unwrap());
            genomes += &(fields[4..].join(",") + "\n");
        }
    }
    Some((genomes, scores))
}

/// Mean scores of genomes in an experiment of `tests/evostick`, changed so.
fn replayed(name: &str, genomes: &str, change: impl Fn(String) -> String) -> Vec<f64> {
    let place = Place::new(&format!("replay-{name}"));
    let text = fs::read_to_string(root().join(format!("tests/evostick/replay-{name}.toml"))).unwrap();
    place.write("replay.toml", change(text));
    let part = root().join(format!("experiments/evostick/{name}.wgsl"));
    fs::copy(part, place.at(format!("{name}.wgsl"))).unwrap();
    place.write("genomes.csv", genomes);
    let table = place.good(&[
        "evaluate",
        "replay.toml",
        "--genomes",
        "genomes.csv",
        "--trials",
        "16",
        "--seed",
        "1",
        "--summary",
        "--quiet",
        "--backend",
        "cpu",
    ]);
    let mean = |line: &str| line.split(',').nth(2).unwrap().parse().unwrap();
    table.lines().skip(1).map(mean).collect()
}

fn mean(numbers: &[f64]) -> f64 {
    numbers.iter().sum::<f64>() / numbers.len() as f64
}

/// Kendall's tau.
fn tau(a: &[f64], b: &[f64]) -> f64 {
    let pairs = (0..a.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let (mut sum, mut count) = (0.0, 0.0);
    for (i, j) in pairs {
        sum += ((a[i] - a[j]) * (b[i] - b[j])).signum();
        count += 1.0;
    }
    sum / count
}

/// With the wheels' limit of the reference model, 120 mm/s, the published networks score far more than was recorded; with 50 mm/s, and
/// black spots of 150 mm in foraging, what was recorded within a tenth: docs/evostick.md.
#[test]
fn published_networks_live_again() {
    for (name, mission) in [("cues", "aggregation"), ("foraging", "foraging")] {
        let Some((genomes, recorded)) = published(mission) else {
            return skipped(
                "networks",
                "published networks beside the scores that were recorded for them",
            );
        };
        assert_eq!(recorded.len(), 10);
        let as_stated = replayed(name, &genomes, |text| text);
        let slower = |text: String| {
            text.replace("count = 20\n", "count = 20\ngreatest_speed_mm_s = 50.0\n")
                .replace("radius_mm = 250.0", "radius_mm = 150.0")
        };
        let slow = replayed(name, &genomes, slower);
        let shares = [&as_stated, &slow].map(|scores| mean(scores) / mean(&recorded));
        let taus = [&as_stated, &slow].map(|scores| tau(scores, &recorded));
        println!(
            "{name}: recorded {:.2}; {shares:.3?} of it, tau {taus:.2?}",
            mean(&recorded)
        );
        assert!((shares[1] - 1.0).abs() < 0.1, "{name}: {shares:?}");
        assert!(taus[1] > 0.0, "{name}: {taus:?}");
        // The difference shows: were it gone, the document would be wrong.
        assert!(shares[0] > 1.2, "{name}: {shares:?}");
    }
}

type Poses = Vec<[f64; 2]>;

/// The grey of a mission's floor, as its experiment has it.
fn grey(name: &str, [x, y]: [f64; 2]) -> f64 {
    let disc = |cx: f64, cy: f64, radius: f64| (x - cx).hypot(y - cy) < radius;
    let (black, white) = match name {
        "aggregation" => (disc(-550.0, 0.0, 300.0) || disc(550.0, 0.0, 300.0), false),
        "foraging" => (disc(-750.0, 0.0, 150.0) || disc(750.0, 0.0, 150.0), y < -600.0),
        "cues" => (disc(0.0, 600.0, 300.0), disc(0.0, -600.0, 300.0)),
        "shelter" => (
            disc(-800.0, -100.0, 300.0) || disc(800.0, -100.0, 300.0),
            x.abs() <= 300.0 && y.abs() <= 75.0,
        ),
        "coverage" => (
            disc(500.0, 500.0, 300.0) || disc(500.0, -500.0, 300.0) || disc(-500.0, 0.0, 300.0),
            false,
        ),
        _ => (false, false),
    };
    match (black, white) {
        (true, _) => 0.0,
        (_, true) => 1.0,
        _ => 0.5,
    }
}

/// A mission's score, from the poses after each cycle.
fn score(name: &str, cycles: &[Poses]) -> f64 {
    let last = &cycles[cycles.len() - 1];
    let on = |poses: &Poses, shade: f64| poses.iter().filter(|at| grey(name, **at) == shade).count() as f64;
    match name {
        "aggregation" => {
            let side = |sign: f64| {
                last.iter()
                    .filter(|at| grey(name, **at) == 0.0 && sign * at[0] > 0.0)
                    .count()
            };
            side(1.0).max(side(-1.0)) as f64 / 20.0
        }
        "foraging" => {
            let (mut items, mut brought) = ([false; 20], 0.0);
            for poses in cycles {
                for (item, at) in items.iter_mut().zip(poses) {
                    match grey(name, *at) {
                        0.0 => *item = true,
                        1.0 => {
                            brought += f64::from(u8::from(*item));
                            *item = false;
                        }
                        _ => (),
                    }
                }
            }
            brought
        }
        "cues" => cycles.iter().map(|poses| on(poses, 0.0)).sum(),
        "shelter" => cycles.iter().map(|poses| on(poses, 1.0)).sum(),
        "network" => network(last),
        "coverage" => {
            let mut total = 0.0;
            for ring in 0..24 {
                for angle in 0..48 {
                    let distance = 1200.0 * (f64::from(ring) + 0.5) / 24.0;
                    let turned = std::f64::consts::TAU * (f64::from(angle) + 0.5) / 48.0;
                    let at = [distance * turned.cos(), distance * turned.sin()];
                    let free = last.iter().filter(|own| grey(name, **own) > 0.0);
                    total += free
                        .map(|own| (own[0] - at[0]).hypot(own[1] - at[1]))
                        .fold(2500.0, f64::min);
                }
            }
            (100.0 * (2.5 - total / 1152.0 / 1000.0)).max(0.0)
        }
        _ => {
            let (mut ages, mut sum) = ([[0_u32; 10]; 10], 0);
            for poses in cycles {
                for at in poses {
                    let [x, y] = at.map(|part| (10.0 * (part / 2500.01 + 0.5)).floor() as usize);
                    ages[x][y] = 0;
                }
                sum += ages.iter().flatten().sum::<u32>();
                ages.iter_mut().flatten().for_each(|age| *age += 1);
            }
            -f64::from(sum) / 100.0
        }
    }
}

/// The area of the largest group's network, groups found one from another.
fn network(last: &Poses) -> f64 {
    let near = |a: [f64; 2], b: [f64; 2], reach: f64| (a[0] - b[0]).hypot(a[1] - b[1]) < reach;
    let mut left: Poses = last.clone();
    let mut largest = Poses::new();
    while let Some(first) = left.first().copied() {
        let mut group = vec![first];
        left.remove(0);
        while let Some(next) = left
            .iter()
            .position(|at| group.iter().any(|own| near(*own, *at, 350.0)))
        {
            group.push(left.remove(next));
        }
        if group.len() > largest.len() {
            largest = group;
        }
    }
    let mut covered = 0;
    for row in 0..48 {
        for column in 0..48 {
            let at = [column, row].map(|index| (f64::from(index) + 0.5) * 50.0 - 1200.0);
            covered += i32::from(near(at, [0.0, 0.0], 1200.0) && largest.iter().any(|own| near(*own, at, 250.0)));
        }
    }
    0.0025 * f64::from(covered)
}

/// Each mission's score is that of a second program, from the poses of the same lives.
#[test]
fn scores_are_those_of_the_second_program() {
    for name in [
        "aggregation",
        "foraging",
        "cues",
        "shelter",
        "network",
        "coverage",
        "exploration",
    ] {
        let place = Place::new(name);
        let experiment = root()
            .join(format!("experiments/evostick-{name}.toml"))
            .display()
            .to_string();
        let cycles = if name == "foraging" { 900 } else { 300 };
        let lived = |cycles: u32, more: &[&str]| {
            let set = format!("cycles={cycles}");
            let mut arguments = vec![
                "evaluate",
                &experiment,
                "--random",
                "6",
                "--trials",
                "1",
                "--seed",
                "3",
                "--set",
                &set,
            ];
            arguments.extend(["--quiet", "--backend", "cpu"]);
            arguments.extend(more);
            place.good(&arguments)
        };
        let fitness = lived(cycles, &[]);
        // A trace has the poses before each cycle: one cycle more has those after the last.
        lived(cycles + 1, &["--traces", "traces"]);
        let mut moved = 0;
        for (genome, line) in fitness.lines().skip(1).enumerate() {
            let found: f64 = line.split(',').nth(2).unwrap().parse().unwrap();
            let trace = place.text(format!("traces/trace-{genome}-0.csv"));
            let mut lines = trace.lines();
            let head: Vec<_> = lines.next().unwrap().split(',').collect();
            let column = |name: &str| head.iter().position(|own| *own == name).unwrap();
            let mut columns = vec![[column("x_mm"), column("y_mm")]];
            columns.extend((1..20).map(|robot| ["x", "y"].map(|part| column(&format!("robot_{robot}.{part}")))));
            let pose = |line: &str| -> Poses {
                let fields: Vec<_> = line.split(',').collect();
                columns
                    .iter()
                    .map(|own| own.map(|at| fields[at].parse().unwrap()))
                    .collect()
            };
            let all: Vec<_> = lines.map(pose).collect();
            assert_eq!(all.len(), cycles as usize + 1, "{name}");
            let expected = score(name, &all[1..]);
            // A robot on an edge to the sixth digit may count or not.
            let most = 1e-3 * expected.abs()
                + if name == "cues" || name == "shelter" {
                    1.0
                } else {
                    0.006
                };
            assert!(
                (found - expected).abs() <= most,
                "{name} {genome}: {found}, not {expected}"
            );
            // The poses one cycle before are others.
            moved += u32::from(score(name, &all[..all.len() - 1]) != expected);
        }
        assert!(moved > 0 || ["aggregation", "foraging"].contains(&name), "{name}");
    }
}

/// What robots bring on their own adds up to what the swarm brings.
#[test]
fn robots_that_forage_have_scores_of_their_own() {
    let place = Place::new("own-scores");
    let experiment = root().join("experiments/evostick-foraging.toml").display().to_string();
    let text = place.good(&[
        "evaluate",
        &experiment,
        "--random",
        "6",
        "--trials",
        "1",
        "--seed",
        "1",
        "--measures",
        "--backend",
        "cpu",
    ]);
    let mut table = csv::Reader::from_reader(text.as_bytes());
    let head = table.headers().unwrap().clone();
    let (mut robots, mut brought) = (0, 0.0);
    for life in table.records() {
        let life = life.unwrap();
        let numbers = |of: fn(&str) -> bool| -> Vec<f64> {
            let cells = head.iter().zip(&life).filter(|(name, _)| of(name));
            cells.map(|(_, cell)| cell.parse().unwrap()).collect()
        };
        let own = numbers(|name| name.starts_with("score_robot_"));
        assert_eq!(numbers(|name| name == "fitness"), [own.iter().sum::<f64>()]);
        robots = own.len();
        brought += own.iter().sum::<f64>();
    }
    assert!(robots == 20 && brought > 0.0, "{text}");
}

/// Two generations of EvoStick, whose elite lives again.
#[test]
fn a_run_keeps_its_elite() {
    let place = Place::new("run");
    let experiment = root().join("experiments/evostick-cues.toml").display().to_string();
    let small = [
        "cycles=30",
        "trials=2",
        "evolution.generations=2",
        "evolution.finalists=0",
    ];
    let set = small.iter().flat_map(|value| ["--set", value]);
    let run = [
        "run",
        &experiment,
        "--seed",
        "1",
        "--out",
        "run",
        "--quiet",
        "--backend",
        "cpu",
    ];
    place.good(&run.into_iter().chain(set).collect::<Vec<_>>());
    let table = place.text("run/generations.csv");
    assert_eq!(table.lines().count(), 3, "{table}");
    place.good(&["verify", "run"]);
}
