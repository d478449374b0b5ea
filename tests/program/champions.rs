//! Champions evaluated again: with measures and traces, from other starts, by every way to name them.

use std::fs;

use oneiro::batch::{Batch, Rollout};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::Key;
use oneiro::world::{Noise, World, WorldSpec};
use serde_json::Value;

use crate::place;
use crate::place::Place;

const SMALL: &str = "cycles = 300
trials = 2
noise.sensor = [0.0, 0.4]

[evolution]
population = 20
parents = 4
generations = 5
";

impl Place {
    /// Finished runs of a small experiment, with seeds 2 and 10, in `runs/`.
    fn two_runs(&self) {
        self.write("small.toml", SMALL);
        for seed in ["2", "10"] {
            let out = format!("runs/run-{seed}");
            self.good(&[
                "run",
                "small.toml",
                "--seed",
                seed,
                "--out",
                &out,
                "--backend",
                "cpu",
                "--quiet",
            ]);
        }
    }

    fn evaluate(&self, arguments: &[&str]) -> Vec<Value> {
        let all = [&["evaluate"], arguments, &["--json", "--backend", "cpu", "--quiet"]].concat();
        serde_json::from_str(&self.good(&all)).unwrap()
    }
}

/// Splits a CSV table into its header and rows of cells.
fn table(text: &str) -> (Vec<&str>, Vec<Vec<&str>>) {
    let mut lines = text.lines().map(|line| line.split(',').collect());
    (lines.next().unwrap(), lines.collect())
}

/// Genomes of other programs become a run: by their names, in any order, and the best mean of all is the champion.
#[test]
fn genomes_of_others_become_a_run() {
    let place = Place::new("adopted");
    place.two_runs();
    let champion: Value = serde_json::from_str(&place.text("runs/run-2/champion.json")).unwrap();
    let names: Vec<&str> = champion["gene_names"]
        .as_array()
        .unwrap()
        .iter()
        .map(|name| name.as_str().unwrap())
        .collect();
    let genes: Vec<f64> = champion["genome"]
        .as_array()
        .unwrap()
        .iter()
        .map(|gene| gene.as_f64().unwrap())
        .collect();
    let row = |of: &dyn Fn(f64) -> f64| {
        genes
            .iter()
            .rev()
            .map(|gene| of(*gene).to_string())
            .collect::<Vec<_>>()
            .join(",")
    };
    let backwards: Vec<&str> = names.iter().rev().copied().collect();
    let rows = [row(&|_| 0.0), row(&|gene| gene), row(&|gene| -gene)];
    place.write("others.csv", format!("{}\n{}\n", backwards.join(","), rows.join("\n")));
    let adopt = |genomes: &str, out: &str| {
        let command = [
            "adopt",
            "small.toml",
            "--genomes",
            genomes,
            "--trials",
            "20",
            "--seed",
            "7",
            "--out",
            out,
            "--backend",
            "cpu",
        ];
        place.run(&command)
    };
    adopt("others.csv", "adopted").exits(0);
    let adopted: Value = serde_json::from_str(&place.text("adopted/champion.json")).unwrap();
    assert_eq!(adopted["genome"], champion["genome"]);
    assert_eq!(
        (adopted["lives"].as_u64(), adopted["individual"].as_u64()),
        (Some(20), Some(1))
    );
    // Other commands take it like any run.
    for command in ["verify", "replay", "resume"] {
        place.good(&[command, "adopted"]);
    }
    // A run's directory stands for its champion. Other names are refused.
    adopt("runs/run-2", "one").exits(0);
    let one: Value = serde_json::from_str(&place.text("one/champion.json")).unwrap();
    assert_eq!(one["genome"], champion["genome"]);
    place.write(
        "wrong.csv",
        format!("{}\n{}\n", backwards.join(",").replace("bias", "basis"), rows[0]),
    );
    adopt("wrong.csv", "none").exits(3).says(&["wrong.csv", "bias_left"]);
    let set = ["--seed", "1", "--set", "evolution.kind=\"race\""];
    place
        .run(&[&["adopt", "small.toml", "--genomes", "others.csv"][..], &set].concat())
        .exits(3)
        .says(&["--set evolution.kind=\"race\": has no effect, as the given genomes are the only generation"]);
    assert!(!place.at("none").exists());
}

fn bits(rows: &[Value]) -> Vec<&str> {
    rows.iter().map(|row| row["bits"].as_str().unwrap()).collect()
}

/// A champion is the same by its directory, its file of genes, its JSON, and as CSV with and without a header.
#[test]
fn a_champion_by_every_name() {
    let place = Place::new("names");
    place.two_runs();
    let champion: Value = serde_json::from_str(&place.text("runs/run-2/champion.json")).unwrap();
    let genome: Vec<String> = champion["genome"]
        .as_array()
        .unwrap()
        .iter()
        .map(ToString::to_string)
        .collect();
    place.write("plain.csv", format!("{}\n", genome.join(",")));
    // By the names of their columns, in any order, among other columns.
    let checked: Value = serde_json::from_str(&place.good(&["check", "small.toml", "--json"])).unwrap();
    let names = checked["gene_names"]
        .as_array()
        .unwrap()
        .iter()
        .map(|name| name.as_str().unwrap());
    let mut columns: Vec<(&str, &str)> = names.zip(genome.iter().map(String::as_str)).collect();
    columns.push(("note", "best"));
    columns.reverse();
    let (names, cells): (Vec<&str>, Vec<&str>) = columns.into_iter().unzip();
    place.write("named.csv", format!("{}\n{}\n", names.join(","), cells.join(",")));
    let here = place.evaluate(&["small.toml", "--genomes", "runs/run-2", "--trials", "5"]);
    assert_eq!(here.len(), 5);
    for name in [
        "runs/run-2/champion.npy",
        "runs/run-2/champion.json",
        "plain.csv",
        "named.csv",
    ] {
        let other = place.evaluate(&["small.toml", "--genomes", name, "--trials", "5"]);
        assert_eq!(other, here, "{name}");
    }
    // The run's experiment is known; its seed doesn't matter.
    assert_eq!(place.evaluate(&["--genomes", "runs/run-2", "--trials", "5"]), here);
    let otherwise = ["--genomes", "runs/run-2", "--trials", "5", "--seed", "2"];
    assert_ne!(place.evaluate(&otherwise), here);

    // Several at once, ordered by number; genomes have numbers of their own.
    let both = place.evaluate(&["--genomes", "runs"]);
    assert_eq!(both.len(), 4);
    let sources: Vec<&str> = both
        .iter()
        .map(|row| row["source"].as_str().unwrap_or_default())
        .collect();
    assert_eq!(sources, ["runs/run-2", "runs/run-2", "runs/run-10", "runs/run-10"]);
    assert_eq!(bits(&both)[..2], bits(&here)[..2]);

    let last = place.evaluate(&["--genomes", "runs", "--population"]);
    assert_eq!(last.len(), 2 * 20 * 2);
    assert_eq!(last[41]["source"], "runs/run-10[0]");
    let population = place.evaluate(&["small.toml", "--genomes", "runs/run-2/population.npy"]);
    assert_eq!(bits(&population), bits(&last)[..40]);
}

/// With common starts, a genome lives as if it were the first; without, every life is different.
#[test]
fn common_starts_are_the_first_genomes() {
    let place = Place::new("common");
    place.two_runs();
    let both = ["--genomes", "runs/run-2", "runs/run-10", "--trials", "3"];
    let own = place.evaluate(&both);
    let common = place.evaluate(&[&both[..], &["--common-starts"]].concat());
    let alone = place.evaluate(&["--genomes", "runs/run-10", "--trials", "3"]);
    assert_eq!(bits(&common)[3..], bits(&alone));
    assert_eq!(bits(&common)[..3], bits(&own)[..3]);
    assert_ne!(bits(&common)[3..], bits(&own)[3..]);
    place.good(
        &[
            &["evaluate"],
            &both[..],
            &["--common-starts", "--traces", "traces", "--quiet"],
        ]
        .concat(),
    );
    assert!(place.text("traces/README.md").contains("`trace-GENOME-TRIAL.csv`"));
    for trial in 0..3 {
        let start = |genome: usize| {
            let text = place.text(format!("traces/trace-{genome}-{trial}.csv"));
            let first = text.lines().nth(1).unwrap();
            first.split(',').take(4).map(str::to_owned).collect::<Vec<_>>()
        };
        assert_eq!(start(0), start(1));
    }
}

/// Measures agree with the traces, fitness has the same bits as without them, and a life starts where requested.
#[test]
fn measures_are_those_of_the_traces() {
    let place = Place::new("measures");
    place.two_runs();
    place.write(
        "starts.csv",
        "x_mm,y_mm,heading_turns\n100,90,0.125\n\n500,250,0.75\n60,60,0\n",
    );
    // A genome that turns on the spot.
    let spin = |gene| match gene {
        8 => "10",
        17 => "-10",
        _ => "0",
    };
    place.write("spin.csv", (0..18).map(spin).collect::<Vec<_>>().join(","));
    let own = ["small.toml", "--genomes", "runs", "spin.csv", "--starts", "starts.csv"];
    let plain = place.evaluate(&own);
    let measured = place.evaluate(&[&own[..], &["--measures", "--traces", "traces"]].concat());
    assert_eq!(plain.len(), 9);
    assert_eq!(bits(&measured), bits(&plain));
    for row in &measured {
        let text = place.text(format!("traces/trace-{}-{}.csv", row["genome"], row["trial"]));
        let (names, lines) = table(&text);
        assert_eq!(lines.len(), 300);
        let column = |name: &str| {
            let index = names.iter().position(|own| *own == name).unwrap();
            lines
                .iter()
                .map(|line| line[index].parse::<f64>().unwrap())
                .collect::<Vec<_>>()
        };
        let (x, y) = (column("x_mm"), column("y_mm"));
        let start = [[100.0, 90.0], [500.0, 250.0], [60.0, 60.0]][row["trial"].as_u64().unwrap() as usize];
        assert_eq!([x[0], y[0]], start);
        let fitness = column("fitness");
        assert_eq!(Some(fitness[299]), row["fitness"].as_f64());
        let collisions = column("collided").iter().filter(|collided| **collided > 0.0).count();
        assert_eq!(row["collisions"].as_u64(), Some(collisions as u64));
        let mut cells: Vec<_> = x
            .iter()
            .zip(&y)
            .map(|(x, y)| ((x / 50.0) as u32, (y / 50.0) as u32))
            .collect();
        cells.sort_unstable();
        cells.dedup();
        assert_eq!(row["cells"].as_u64(), Some(cells.len() as u64));
        let measure = |name: &str| row[name].as_f64().unwrap();
        let near = |name: &str, expected: f64| {
            let own = measure(name);
            assert!(
                (own - expected).abs() < 2e-5 * expected.abs().max(1.0),
                "{name}: {own} {expected}"
            );
        };
        // The last cycle's move ends after the trace; a cycle goes 8.2 mm at most.
        let (x, y) = (
            [&x[..], &[measure("end_x_mm")]].concat(),
            [&y[..], &[measure("end_y_mm")]].concat(),
        );
        let moves: Vec<f64> = (1..=300).map(|i| (x[i] - x[i - 1]).hypot(y[i] - y[i - 1])).collect();
        assert!(moves[299] < 8.21, "{row}");
        near("distance_mm", moves.iter().sum());
        near("mean_speed_mm_s", moves.iter().sum::<f64>() / 30.0);
        let is_stuck = |of: usize| {
            let mut around = of.saturating_sub(98)..=of.min(201);
            around.any(|first| moves[first..first + 99].iter().sum::<f64>() < 50.0)
        };
        near("stuck_s", (0..300).filter(|of| is_stuck(*of)).count() as f64 / 10.0);
        assert_eq!(row["stuck_s"] == 30.0, row["source"] == "spin.csv", "{row}");
        let heading = column("heading_turns");
        let turns = (1..300).map(|i| (heading[i] - heading[i - 1]).abs());
        let turned: f64 = turns.map(|turn| turn.min(1.0 - turn)).sum();
        // The turn of the last cycle isn't in the trace.
        let turning = measure("mean_turning_turns_s") * 30.0;
        assert!((turned - 0.001..turned + 0.1).contains(&turning), "{turning} {turned}");
        let room = |(x, y): (&f64, &f64)| {
            let walls = x.min(600.0 - x).min(*y).min(350.0 - y);
            let round = [180.0, 300.0, 420.0].map(|centre| (x - centre).hypot(y - 175.0) - 27.5);
            (round.into_iter().fold(walls, f64::min) - 27.5).max(0.0)
        };
        near(
            "wall_distance_mm",
            x[..300].iter().zip(&y).map(room).sum::<f64>() / 300.0,
        );
    }
    // A trace also serves as a list of starts.
    let along = place.evaluate(&["--genomes", "runs/run-2", "--starts", "traces/trace-0-0.csv"]);
    assert_eq!(along.len(), 300);
}

/// Columns of a trace, by their names.
fn columns<const N: usize>(text: &str, names: [&str; N]) -> Vec<[f32; N]> {
    let (all, lines) = table(text);
    let places = names.map(|name| {
        all.iter()
            .position(|own| *own == name)
            .unwrap_or_else(|| panic!("{name}"))
    });
    let numbers = |line: Vec<&str>| places.map(|place| line[place].parse().unwrap());
    lines.into_iter().map(numbers).collect()
}

/// Eight activations of each cycle: those whose names begin so.
fn activations(text: &str, kind: &str) -> Vec<[f32; 8]> {
    let names: [String; 8] = std::array::from_fn(|sensor| format!("{kind}_{sensor}"));
    columns(text, names.each_ref().map(String::as_str))
}

/// The rewards of a life by equation 1, as `docs/khepera.md` has it, from the speeds and some activations of its trace.
fn rewards(text: &str, kind: &str) -> Vec<f32> {
    let moves = columns(text, ["speed_left", "speed_right", "collided"]);
    let reward = |(&[left, right, collided], near): (&[f32; 3], [f32; 8])| {
        let (speed, apart) = (0.5 * (left.abs() + right.abs()), 0.5 * (left - right).abs());
        let earned = speed * (1.0 - apart.sqrt()) * (1.0 - near.into_iter().fold(0.0, f32::max));
        if collided == 1.0 { 0.0 } else { earned }
    };
    moves.iter().zip(activations(text, kind)).map(reward).collect()
}

/// With sensor noise and conservative noise, the fitness of a life follows from its trace alone; and with the readings as
/// perceived in place of those that count, another does.
#[test]
fn the_fitness_of_a_noisy_life_follows_from_its_trace() {
    let place = Place::new("noisy");
    for (activation, counts, other) in [("real", "real", "sensor"), ("perceived", "sensor", "real")] {
        place.write(
            format!("{activation}.toml"),
            format!(
                "task.activation = \"{activation}\"
noise = {{ sensor = [0.0, 0.4], walk_range_mm = 30.0, walk_step_mm = 1.5 }}
evolution = {{ population = 20, parents = 4, generations = 5 }}
"
            ),
        );
        let experiment = format!("{activation}.toml");
        let run = ["run", &experiment, "--seed", "3", "--out", activation];
        place.good(&[&run[..], &["--backend", "cpu", "--quiet"]].concat());
        let text = place.text(format!("{activation}/trace.csv"));
        let champion: Value = serde_json::from_str(&place.text(format!("{activation}/champion.json"))).unwrap();
        let fitness = champion["fitness"].as_f64().unwrap() as f32;

        // What is recorded adds up to the fitness, to its last bit.
        let recorded = columns(&text, ["reward", "fitness"]);
        let mut sum = 0.0;
        for &[reward, so_far] in &recorded {
            sum += reward;
            assert_eq!(so_far, sum);
        }
        assert_eq!(sum, fitness);

        // And each reward is that of the readings, to the kernel's square root, which has an error of 2e-7.
        let computed = rewards(&text, counts);
        assert_eq!(computed.len(), 500);
        for (cycle, (computed, [reward, _])) in computed.iter().zip(&recorded).enumerate() {
            assert!(
                (computed - reward).abs() < 4e-7,
                "{activation}, cycle {cycle}: {computed}, {reward}"
            );
        }
        let six = |fitness: f32| format!("{fitness:.5e}");
        assert_eq!(six(computed.iter().sum()), six(fitness));
        assert!((rewards(&text, other).iter().sum::<f32>() - fitness).abs() > 1.0);

        // A replay records the same.
        place.good(&["replay", activation, "--backend", "cpu", "--quiet"]);
        assert_eq!(place.text(format!("{activation}/replay.csv")), text);
    }
}

/// The activations before sensor noise are those of a life without noise that starts at the same pose. Conservative noise
/// displaces them, as far as it may.
#[test]
fn traces_say_what_noise_does() {
    let place = Place::new("seen");
    place.two_runs();
    let text = place.text("runs/run-2/trace.csv");
    let along = [
        "evaluate",
        "--genomes",
        "runs/run-2",
        "--starts",
        "runs/run-2/trace.csv",
        "--quiet",
    ];
    place.good(
        &[
            &along[..],
            &["--noise", "off", "--set", "cycles=1", "--traces", "without"],
        ]
        .concat(),
    );
    let (real, perceived) = (activations(&text, "real"), activations(&text, "sensor"));
    assert_eq!(real.len(), 300);
    for (cycle, real) in real.iter().enumerate() {
        let alone = place.text(format!("without/trace-0-{cycle}.csv"));
        assert_eq!(activations(&alone, "sensor"), [*real], "cycle {cycle}");
        assert_eq!(activations(&alone, "real"), [*real], "cycle {cycle}");
        let noise = perceived[cycle]
            .iter()
            .zip(real)
            .map(|(perceived, real)| perceived - real);
        assert!(
            noise.clone().all(|noise| (-1e-6..0.400_001).contains(&noise)),
            "cycle {cycle}"
        );
        assert!(noise.fold(0.0, f32::max) > 0.0, "cycle {cycle}");
    }
    let shifts = |text: &str| -> Vec<[f32; 2]> {
        let places = columns(text, ["x_mm", "y_mm", "seen_x_mm", "seen_y_mm"]);
        places
            .into_iter()
            .map(|[x, y, seen_x, seen_y]| [seen_x - x, seen_y - y])
            .collect()
    };
    assert!(shifts(&text).iter().all(|shift| *shift == [0.0; 2]));

    let walk = [
        "--set",
        "noise.walk_range_mm=30",
        "--set",
        "noise.walk_step_mm=1.5",
        "--traces",
        "walked",
    ];
    place.good(&[&["evaluate", "--genomes", "runs/run-2", "--quiet"], &walk[..]].concat());
    let walked = shifts(&place.text("walked/trace-0-0.csv"));
    let greatest = |numbers: &mut dyn Iterator<Item = f32>| numbers.fold(0.0, |most: f32, x| most.max(x.abs()));
    assert!((1.5..30.001).contains(&greatest(&mut walked.iter().copied().flatten())));
    for axis in [0, 1] {
        let steps = walked.windows(2).map(|pair| pair[1][axis] - pair[0][axis]);
        assert!((1.0..1.501).contains(&greatest(&mut steps.into_iter())));
    }
}

/// A robot among drawn obstacles.
const DRAWN: &str = "cycles = 60
trials = 2
[robot]
preset = \"epuck\"
[arena]
width_mm = 1000.0
height_mm = 700.0
obstacles = [{ x_mm = 400.0, y_mm = 350.0, radius_mm = 40.0 }, { x_mm = 600.0, y_mm = 350.0, radius_mm = 40.0 }]
[start]
kind = \"zone\"
x_mm = 100.0
y_mm = 100.0
radius_mm = 40.0
[worlds]
count = 5
[worlds.vary]
\"arena.obstacles[].x_mm\" = [250.0, 400.0]
\"noise.sensor\" = [[-0.05, 0.0], [0.0, 0.05]]
[evolution]
population = 4
generations = 2
finalists = 0
";

/// Drawn noise is also left out; a setting of a drawn number would have no effect.
#[test]
fn drawn_noise_is_noise_and_drawn_numbers_are_not_set() {
    let place = Place::new("drawn");
    place.write("varied.toml", DRAWN);
    let bits = |more: &[&str]| {
        let table = place.good(
            &[
                &[
                    "evaluate",
                    "varied.toml",
                    "--random",
                    "4",
                    "--trials",
                    "6",
                    "--seed",
                    "2",
                ],
                more,
            ]
            .concat(),
        );
        let rows = table
            .lines()
            .skip(1)
            .map(|row| row.split(',').nth(3).unwrap().to_owned());
        rows.collect::<Vec<_>>()
    };
    let nothing = "worlds.vary={\"noise.sensor\"=[[0.0, 0.0], [0.0, 0.0]]}";
    let without = bits(&["--noise", "off"]);
    assert_eq!(without, bits(&["--set", nothing]));
    assert_ne!(without, bits(&[]));
    for set in ["noise.sensor=[0.0, 0.1]", "arena.obstacles[1].x_mm=300.0"] {
        let key = set.split('=').next().unwrap();
        place
            .run(&["check", "varied.toml", "--set", nothing, "--set", set])
            .exits(3)
            .says(&[&format!("{key}: has no effect, as worlds.vary draws ")]);
    }
    let said = place.good(&["check", "varied.toml"]);
    assert!(said.contains("; noise.sensor drawn for each world"), "{said}");
}

#[test]
fn a_test_has_values_of_its_own() {
    let place = Place::new("test");
    let test =
        "[test]\n\"worlds.vary\" = { \"arena.obstacles[].x_mm\" = [400.0, 750.0] }\n\"worlds.seed\" = 7\ncycles = 50\n";
    place.write("plain.toml", DRAWN);
    place.write("tested.toml", format!("{DRAWN}{test}"));
    let run =
        |file: &str, out: &str| place.good(&["run", file, "--seed", "3", "--out", out, "--quiet", "--set", "name=a"]);
    run("plain.toml", "plain");
    run("tested.toml", "tested");
    // Values of tests are no part of the results.
    let same = ["generations.csv", "champion.json", "worlds.csv"];
    for file in same {
        assert_eq!(
            place.read(format!("plain/{file}")),
            place.read(format!("tested/{file}"))
        );
    }
    let bits = |arguments: &[&str]| {
        let with = ["--seed", "2", "--trials", "9", "--measures"];
        place.evaluate(&[arguments, &with].concat())
    };
    let tested = bits(&["--genomes", "tested", "--test"]);
    let sets = [
        "worlds.vary={\"arena.obstacles[].x_mm\"=[400.0, 750.0]}",
        "worlds.seed=7",
        "cycles=50",
    ];
    let set: Vec<&str> = sets.iter().flat_map(|set| ["--set", *set]).collect();
    assert_eq!(tested, bits(&[&["--genomes", "plain"][..], &set].concat()));
    assert_ne!(tested, bits(&["--genomes", "tested"]));
    // Settings override it.
    let short = bits(&["--genomes", "tested", "--test", "--set", "cycles=20"]);
    assert_eq!(
        short,
        bits(&[&["--genomes", "plain"][..], &set, &["--set", "cycles=20"]].concat())
    );
    // A sweep's own values don't.
    place.write(
        "sweep.toml",
        "experiment = \"tested.toml\"\nseeds = [3]\n[grid]\ncycles = [60, 40]\n",
    );
    place.good(&["sweep", "run", "sweep.toml", "--out", "sweep", "--quiet"]);
    let champions = bits(&["--genomes", "sweep", "--test"]);
    assert_eq!(champions.len(), 18);
    assert_eq!(champions[0]["bits"], tested[0]["bits"]);
    let replayed = place.good(&["replay", "tested", "--test", "--seed", "2", "--trial", "1", "--json"]);
    let replayed: Value = serde_json::from_str(&replayed).unwrap();
    assert_eq!(replayed["trial_bits"], tested[1]["bits"]);
    assert!(place.at("tested/replay-1-seed-2-test.html").exists());
    for (arguments, words) in [
        (
            &["evaluate", "--genomes", "plain", "--test"][..],
            " has no table [test]; allowed: one",
        ),
        (&["replay", "plain", "--test"], " has no table [test]; allowed: one"),
    ] {
        place.run(arguments).exits(3).says(&[words]);
    }
    place.write("tested.toml", format!("{DRAWN}[test]\ncycles = 60\n"));
    place
        .run(&["check", "tested.toml"])
        .exits(0)
        .says(&["warning: tested.toml:23:1: test: changes nothing"]);
    // Settings that a test has too, or that go only with the evolution, are for those who don't ask for the test.
    let drawn =
        "[test]\n\"noise.motor\" = 0.2\n\"worlds.choose\" = { \"arena.obstacles[0].radius_mm\" = [20.0, 40.0] }\n";
    place.write("apart.toml", format!("{DRAWN}{drawn}"));
    for set in ["noise.motor=0.2", "arena.obstacles[0].radius_mm=30.0"] {
        bits(&["apart.toml", "--random", "1", "--set", set]);
    }
    place.write("one.toml", format!("{DRAWN}[test]\n\"noise.motor\" = 0.2\n"));
    place.good(&[
        "run",
        "one.toml",
        "--seed",
        "3",
        "--out",
        "one",
        "--quiet",
        "--set",
        "noise.motor=0.2",
    ]);
    assert_eq!(bits(&["--genomes", "one"]), bits(&["--genomes", "one", "--test"]));
    for (test, words) in [
        (
            "name = \"b\"",
            "tested.toml:23:1: test: has \"name\"; allowed: keys of arena, cycles",
        ),
        (
            "\"evolution.population\" = 8",
            "test: has \"evolution.population\"; allowed",
        ),
        ("\"noise.motr\" = 0.2", "tested.toml:24:16: test: noise.motr: "),
        ("cycles = -1", "tested.toml:24:10: test: cycles: "),
        ("\"robot.sensors\" = []", "test: changes the genes"),
        (
            "\"noise.motor\" = 0.1\nnoise.motor = 0.2",
            "test: has noise.motor twice; allowed: each key once",
        ),
        (
            "\"arena.obstacles[].radius_mm\" = 30.0",
            "allowed: the number of an element",
        ),
        (
            "\"start.radius_mm\" = 900.0",
            "tested.toml:9:1, tested.toml:24:21: test: start: reaches from ",
        ),
        (
            "\"arena.height_mm\" = 120.0",
            "tested.toml:23:1: test: makes another experiment, which is refused: tested.toml:9:1: start: reaches from ",
        ),
    ] {
        place.write("tested.toml", format!("{DRAWN}[test]\n{test}\n"));
        place.run(&["check", "tested.toml"]).exits(3).says(&[words]);
    }
}

/// A table next to the traces has the numbers of the episodes' worlds.
#[test]
fn drawn_numbers_are_written_with_traces() {
    let place = Place::new("drawn-numbers");
    place.write("drawn.toml", DRAWN);
    let trials = ["--trials", "6", "--seed", "2", "--traces", "traces"];
    let rows = place.evaluate(&[&["drawn.toml", "--random", "2"], &trials[..]].concat());
    let text = place.text("traces/worlds.csv");
    let (head, worlds) = table(&text);
    assert_eq!(
        head,
        [
            "world",
            "arena.obstacles[0].x_mm",
            "arena.obstacles[1].x_mm",
            "noise.sensor[0]",
            "noise.sensor[1]"
        ]
    );
    assert_eq!(worlds.len(), 5);
    for (number, world) in worlds.iter().enumerate() {
        assert_eq!(world[0], number.to_string());
        let ranges = [250.0..=400.0, 250.0..=400.0, -0.05..=0.0, 0.0..=0.05];
        for (range, value) in ranges.iter().zip(&world[1..]) {
            assert!(range.contains(&value.parse::<f32>().unwrap()), "{world:?}");
        }
    }
    // An episode in a world that has these numbers, and nothing drawn, is the same.
    let plain = DRAWN.split("[worlds]").next().unwrap();
    place.write("plain.toml", plain);
    let (trial, row) = (4, &rows[4]);
    let own = &worlds[row["world"].as_u64().unwrap() as usize];
    let [x, other] = [1, 2].map(|at| format!("arena.obstacles[{}].x_mm={}", at - 1, own[at]));
    let noise = format!("noise.sensor=[{}, {}]", own[3], own[4]);
    let set = [
        "--set", &x, "--set", &other, "--set", &noise, "--seed", "2", "--trials", "6",
    ];
    let again = place.evaluate(&[&["plain.toml", "--random", "2"], &set[..]].concat());
    assert_eq!(again[trial]["bits"], row["bits"]);
    // Starts that vary have their number.
    let poses = "cycles = 20\n[robot]\npreset = \"epuck\"\n[arena]\nwidth_mm = 500.0\nheight_mm = 500.0\n\
                 [start]\nkind = \"poses\"\nposes = [[100.0, 100.0, 0.0], [300.0, 100.0, 0.5]]\n";
    place.write("poses.toml", poses);
    place.evaluate(&["poses.toml", "--random", "1", "--trials", "2", "--traces", "poses"]);
    assert_eq!(place.text("poses/worlds.csv"), "world,poses\n0,0\n1,1\n");
}

/// Without noise, lives from the same start are identical; with noise they differ.
#[test]
fn noise_can_be_switched_off() {
    let place = Place::new("noise");
    place.two_runs();
    place.write("starts.csv", "100,90,0.125\n".repeat(3));
    let own = ["--genomes", "runs/run-2", "--starts", "starts.csv"];
    let with = place.evaluate(&own);
    let without = place.evaluate(&[&own[..], &["--noise", "off"]].concat());
    assert_eq!(without[0]["bits"], without[1]["bits"]);
    assert_ne!(with[0]["bits"], with[1]["bits"]);
    let named = place.evaluate(&[&own[..], &["--set", "noise.sensor=[0.0,0.0]"]].concat());
    assert_eq!(named, without);
}

#[test]
fn what_does_not_fit_is_refused_with_its_place() {
    let place = Place::new("refused");
    place.two_runs();
    place.write("hidden.toml", format!("controller.kind = \"hidden\"\n{SMALL}"));
    place.good(&[
        "run",
        "hidden.toml",
        "--seed",
        "1",
        "--out",
        "hidden",
        "--backend",
        "cpu",
        "--quiet",
    ]);
    fs::create_dir(place.at("empty")).unwrap();
    place.write("wall.csv", "100,90,0\n3,3,0\n");
    place.write("few.csv", "100,90\n");
    place.write("turns.csv", "x_mm,heading_turns,y_mm\n100,1.5,90\n");
    place.write("none.csv", "x_mm,y_mm,heading_turns\n");
    place.write("some.csv", "left_90_to_left,bias_left\n0,0\n");
    place.write("long.json", "{\"genome\": [1, 2,\n 3]}");
    place.write("not.json", "{\"genome\":\n [1, \"2\"]}");
    let runs = ["--genomes", "runs"];
    for (code, arguments, words) in [
        (
            3,
            &["--genomes", "hidden", "runs"][..],
            &["hidden", "run-2", "one experiment", "before --genomes"][..],
        ),
        (
            3,
            &["small.toml", "--genomes", "hidden"],
            &["hidden", "46 genes", "allowed: 18"],
        ),
        (3, &["--genomes", "empty"], &["empty", "allowed"]),
        (
            2,
            &["--genomes", "runs/run-2/champion.npy"],
            &["champion.npy", "before --genomes"],
        ),
        (
            2,
            &["--genomes", "runs", "--starts", "wall.csv", "--trials", "2"],
            &["--trials"],
        ),
        (2, &["--genomes", "runs", "--noise", "maybe"], &["on", "off"]),
        (
            2,
            &["--genomes", "runs", "--measures", "--out", "a.npy"],
            &["--measures", ".csv"],
        ),
        (
            3,
            &[runs[0], runs[1], "--starts", "wall.csv"],
            &["wall.csv: line 2: start", "allowed"],
        ),
        (
            3,
            &[runs[0], runs[1], "--starts", "few.csv"],
            &["few.csv: line 1", "2 numbers", "allowed: 3"],
        ),
        (
            3,
            &[runs[0], runs[1], "--starts", "turns.csv"],
            &["turns.csv: line 2: start.heading", "1.5", "allowed"],
        ),
        (
            3,
            &[runs[0], runs[1], "--starts", "none.csv"],
            &["none.csv", "x_mm, y_mm, heading_turns"],
        ),
        (
            3,
            &["small.toml", "--genomes", "some.csv"],
            &["some.csv: line 1", "none is called `left_45_to_left`", "allowed"],
        ),
        (
            3,
            &["small.toml", "--genomes", "long.json"],
            &["long.json", "3 numbers", "18"],
        ),
        (
            3,
            &["small.toml", "--genomes", "not.json"],
            &["not.json", "line 2 column", "allowed"],
        ),
        (
            3,
            &["small.toml", "--genomes", "small.toml"],
            &["small.toml", "allowed: .npy, .csv, .json"],
        ),
        (
            3,
            &[runs[0], runs[1], "--traces", "runs"],
            &["runs", "nothing is overwritten"],
        ),
    ] {
        place.run(&[&["evaluate"], arguments].concat()).exits(code).says(words);
    }
    assert!(!place.at("a.npy").exists());
}

/// If a directory is given instead of a file, the error names the file to give.
#[test]
fn directories_in_place_of_files_are_refused_with_what_to_name() {
    let place = Place::new("directories");
    place.two_runs();
    fs::create_dir(place.at("experiments")).unwrap();
    place.write("experiments/mine.toml", SMALL);
    place.write("experiments/table.sam", "");
    place.write("init.toml", format!("{SMALL}init = \"runs\"\n"));
    place.write("tables.toml", format!("robot.tables = [\"experiments\"]\n{SMALL}"));
    place.write("starts.csv", "100,90,0\n");
    for (arguments, words) in [
        (
            &["check", "runs/run-2"][..],
            &[
                "runs/run-2: is a run's directory, not an experiment",
                "runs/run-2/config.toml",
            ][..],
        ),
        (&["run", "experiments"], &["experiments/mine.toml"]),
        (&["run", "runs/run-10", "--out", "x"], &["runs/run-10/config.toml"]),
        (
            &["evaluate", "runs/run-2", "--genomes", "runs/run-2"],
            &["runs/run-2/config.toml"],
        ),
        (
            &["evaluate", "--genomes", "runs", "--starts", "experiments"],
            &["experiments: is a directory"],
        ),
        (
            &["check", "init.toml"],
            &["init.toml:9", "evolution.init", "is a directory, but no run's"],
        ),
        (&["check", "tables.toml"], &["tables.toml:1", "experiments/table.sam"]),
        (&["robot", "tables", "show", "experiments"], &["experiments/table.sam"]),
        (
            &["robot", "tables", "convert", "experiments", "a.sam"],
            &["experiments/table.sam"],
        ),
        (&["sweep", "plan", "experiments"], &["experiments/mine.toml"]),
        (&["list", "small.toml"], &["small.toml: is a file", "allowed"]),
        (&["replay", "small.toml"], &["small.toml: is a file"]),
    ] {
        place.run(arguments).exits(3).says(words);
    }
}

/// Another start or other random numbers: the same as `evaluate`, without a comparison.
#[test]
fn a_champion_lives_from_another_start() {
    let place = Place::new("elsewhere");
    place.two_runs();
    place.write("starts.csv", "100,90,0.125\n");
    let replay = |more: &[&str]| -> Value {
        let all = [
            &["replay", "runs/run-2", "--json", "--backend", "cpu", "--out", "again"],
            more,
        ]
        .concat();
        serde_json::from_str(&place.good(&all)).unwrap()
    };
    let recorded = replay(&[]);
    assert_eq!(recorded["compared"], true);
    let recorded_life = place.text("again/replay-0.csv");
    let other = replay(&["--seed", "5"]);
    assert_eq!(other["compared"], false);
    assert_ne!(other["bits"], recorded["bits"]);
    let lives = place.evaluate(&["--genomes", "runs/run-2", "--seed", "5"]);
    let [one, two] = [0, 1].map(|trial: usize| lives[trial]["fitness"].as_f64().unwrap() as f32);
    let mean = f64::from(one).midpoint(f64::from(two)) as f32;
    assert_eq!(other["bits"], format!("{:08x}", mean.to_bits()));

    let moved = replay(&["--start", "100,90,0.125"]);
    assert_eq!(moved["compared"], false);
    let trace = place.text("again/replay-0-start-100_90_0.125.csv");
    assert!(trace.lines().nth(1).unwrap().starts_with("0,100,90,0.125,"), "{trace}");
    // The files of the recorded life are still its own.
    assert_eq!(place.text("again/replay-0.csv"), recorded_life);
    let both = replay(&["--start", "100,90,0.125", "--seed", "5", "--trial", "1"]);
    assert_ne!(both["bits"], moved["bits"]);
    // Each trial has files and a fitness of its own, beside that of all.
    assert_eq!(place.text("again/replay-0-start-100_90_0.125.csv"), trace);
    assert!(place.at("again/replay-1-start-100_90_0.125-seed-5.svg").exists());
    let fitness = |trial: &str| replay(&["--seed", "5", "--trial", trial])["trial_fitness"].as_f64();
    assert_eq!(
        [fitness("0"), fitness("1")],
        [0, 1].map(|trial: usize| lives[trial]["fitness"].as_f64())
    );
    let words = place.good(&["replay", "runs/run-2", "--seed", "5", "--out", "again"]);
    assert!(words.contains("not compared"), "{words}");
    assert!(
        words.contains(" of 2 episodes (mean) (bits ") && words.contains("\nepisode 0: fitness "),
        "{words}"
    );
    place
        .run(&["replay", "runs/run-2", "--start", "3,3,0"])
        .exits(3)
        .says(&["--start 3,3,0", "allowed"]);
    place
        .run(&["replay", "runs/run-2", "--start", "3,3"])
        .exits(2)
        .says(&["allowed"]);
}

/// Runs are verified, audited and resumed in the order of their seeds.
#[test]
fn runs_are_in_the_order_of_their_numbers() {
    let place = Place::new("order");
    place.two_runs();
    let ordered = |text: &str| {
        let places = ["run-2", "run-10"].map(|name| text.find(name).unwrap_or_else(|| panic!("{text}")));
        assert!(places[0] < places[1], "{text}");
    };
    for command in [&["verify"][..], &["verify", "--recompute"], &["resume"]] {
        ordered(&place.good(&[command, &["runs"]].concat()));
        ordered(&place.good(&[command, &["runs", "--json"]].concat()));
    }
    ordered(&place.good(&["evaluate", "--genomes", "runs"]));
}

/// Messages that drivers print by themselves, such as Mesa's without a desktop, don't reach the user.
#[cfg(feature = "gpu")]
#[test]
fn drivers_are_quiet_without_a_desktop() {
    let place = Place::new("drivers");
    place.write("small.toml", SMALL);
    for arguments in [
        &["device", "list"][..],
        &[
            "run",
            "small.toml",
            "--seed",
            "1",
            "--out",
            "run",
            "--quiet",
            "--backend",
            "gpu:0",
        ],
        &["verify", "--recompute", "run", "--quiet", "--backend", "gpu:0"],
    ] {
        let output = place
            .command(arguments)
            .env_remove("XDG_RUNTIME_DIR")
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("DISPLAY")
            .output()
            .unwrap();
        let ran = place::Ran::new(arguments, &output).exits(0);
        assert_eq!(ran.stderr, "", "oneiro {}", ran.arguments);
    }
}

/// Who the champion is follows from episodes that are the same for all finalists, who are the luckiest of the run and the best others of
/// the last generation; its mean is of others, simulated after that. Both are computed here with the library alone.
#[test]
fn a_champion_is_the_finalist_with_the_best_mean() {
    const LIVES: u64 = 100;
    let place = Place::new("finalists");
    place.two_runs();
    let read = |file: &str| -> Value { serde_json::from_str(&place.text(format!("runs/run-2/{file}"))).unwrap() };
    let npy = |file: &str| {
        let bytes = place.read(format!("runs/run-2/{file}"));
        npyz::NpyFile::new(&bytes[..]).unwrap().into_vec::<f32>().unwrap()
    };
    let (champion, luckiest) = (read("champion.json"), read("luckiest.json"));
    let who = |file: &Value| {
        (
            file["generation"].as_u64().unwrap(),
            file["individual"].as_u64().unwrap(),
        )
    };
    let generations = place.text("runs/run-2/generations.csv");
    let (names, lines) = table(&generations);
    let column = |name: &str| {
        let index = names.iter().position(|own| *own == name).unwrap();
        lines
            .iter()
            .map(|line| line[index].parse::<f64>().unwrap())
            .collect::<Vec<_>>()
    };
    let best = column("best").into_iter().fold(f64::MIN, f64::max);
    assert_eq!(
        luckiest["fitness"].as_f64(),
        Some(best),
        "the luckiest is what the champion was"
    );

    let (population, fitness) = (npy("population.npy"), npy("fitness.npy"));
    let mut ranking: Vec<usize> = (0..20).collect();
    ranking.sort_by(|&a, &b| fitness[b].total_cmp(&fitness[a]));
    let others = ranking.into_iter().map(|individual| (4, individual as u64));
    let others = others.filter(|other| *other != who(&luckiest)).take(20);
    let finalists: Vec<(u64, u64)> = std::iter::once(who(&luckiest)).chain(others).collect();
    let genes = |&(_, individual): &(u64, u64), index: usize| match index {
        0 => npy("luckiest.npy"),
        _ => population[individual as usize * 18..][..18].to_vec(),
    };
    let genomes: Vec<Vec<f32>> = finalists
        .iter()
        .zip(0..)
        .map(|(who, index)| genes(who, index))
        .collect();
    let world = World::new(WorldSpec {
        cycles: 300,
        noise: Noise::SENSOR,
        ..WorldSpec::miglino1995()
    })
    .unwrap();
    let worlds = [world];
    let episodes = |genomes: &[Vec<f32>], generation: u64| {
        let rollouts: Vec<Rollout<'_>> = genomes
            .iter()
            .flat_map(|genes| {
                (0..LIVES).map(move |life| Rollout {
                    world: 0,
                    genes,
                    key: Key::rollout(2, generation, 0, life),
                })
            })
            .collect();
        let batch = Batch::new(&worlds, &rollouts, None).unwrap();
        Cpu::new(Some(1))
            .unwrap()
            .evaluate(&batch, &Control::new())
            .unwrap()
            .fitness
    };
    let lives = episodes(&genomes, 1 << 32);
    let mean = |lives: &[f32]| lives.iter().map(|life| f64::from(*life)).sum::<f64>() / lives.len() as f64;
    let means: Vec<f64> = lives.chunks(LIVES as usize).map(mean).collect();
    let most = (0..means.len()).fold(0, |most, index| if means[index] > means[most] { index } else { most });
    assert_eq!(who(&champion), finalists[most]);
    assert_eq!(npy("champion.npy"), genomes[most]);
    let near = |value: &Value, expected: f64| (value.as_f64().unwrap() - expected).abs() < 1e-6;
    let own = episodes(&genomes[most..=most], (1 << 32) + 2);
    let tested = mean(&own);
    assert!(near(&champion["mean"], tested) && near(&luckiest["mean"], means[0]));
    assert!((tested - means[most]).abs() > 1e-3, "other episodes have another mean");
    assert!(
        most > 0 && means[most] > means[0] + 1.0,
        "here luck is not enough: {means:?}"
    );
    let squares: f64 = own.iter().map(|life| (f64::from(*life) - tested).powi(2)).sum();
    // Student's t with 99 degrees of freedom.
    let reach = 1.984_217 * (squares / 99.0 / 100.0).sqrt();
    assert!(near(&champion["interval"][0], tested - reach) && near(&champion["interval"][1], tested + reach));
    assert_eq!(
        (
            champion["lives"].as_u64(),
            champion["gene_names"].as_array().unwrap().len()
        ),
        (Some(LIVES), 18)
    );

    let checked: Value = serde_json::from_str(&place.good(&["check", "small.toml", "--json"])).unwrap();
    assert_eq!(
        checked["robot_steps"].as_u64(),
        Some((20 * 5 * 2 + 21 * LIVES + LIVES) * 300)
    );
    let shown = place.good(&["resume", "runs/run-2"]);
    assert!(
        shown.contains("of 100 new episodes (95 %: ") && shown.contains("luckiest  fitness"),
        "{shown}"
    );
}

/// Without finalists a run is the same as before they existed, except for two lines of its configuration.
#[test]
fn without_finalists_the_champion_is_the_luckiest() {
    let place = Place::new("off");
    place.two_runs();
    let off = [
        "--set",
        "evolution.finalists=0",
        "--seed",
        "2",
        "--out",
        "off",
        "--backend",
        "cpu",
    ];
    place.good(&[&["run", "small.toml"], &off[..]].concat());
    assert!(!place.at("off/luckiest.json").exists());
    for file in ["generations.csv", "individuals.npy", "population.npy", "fitness.npy"] {
        assert_eq!(
            place.read(format!("off/{file}")),
            place.read(format!("runs/run-2/{file}")),
            "{file}"
        );
    }
    assert_eq!(place.read("off/champion.npy"), place.read("runs/run-2/luckiest.npy"));
    let champion: Value = serde_json::from_str(&place.text("off/champion.json")).unwrap();
    assert!(champion.get("mean").is_none() && champion.get("gene_names").is_none());
    // A run as version 0.1 wrote it is still valid.
    let config = place.text("off/config.toml");
    let older = config.replace("finalists = 0\nfinalist_lives = 100\n", "");
    assert_eq!(older.lines().count() + 2, config.lines().count());
    place.write("off/config.toml", &older);
    let verified = place
        .run(&["verify", "off"])
        .exits(5)
        .says(&["config.toml is not what was recorded"]);
    assert!(
        !verified.stderr.contains("experiment is another"),
        "{}",
        verified.stderr
    );
    assert!(place.good(&["replay", "off", "--out", "again"]).contains("as recorded"));
    place
        .run(&["check", "small.toml", "--set", "evolution.finalists=10001"])
        .exits(3)
        .says(&["1000"]);
    place
        .run(&[
            "check",
            "small.toml",
            "--set",
            "evolution.finalists=10000",
            "--set",
            "evolution.finalist_lives=1000",
        ])
        .exits(3)
        .says(&["evolution.finalist_lives", "1000000 episodes"]);
}

/// A sweep of cells that differ in their evolution alone, and its directory `sweep/`.
fn small_sweep(place: &Place, grid: &str) {
    place.write("small.toml", SMALL);
    place.write(
        "s.toml",
        format!("experiment = \"small.toml\"\nseeds = [2, 10]\n{grid}"),
    );
    place.good(&[
        "sweep",
        "run",
        "s.toml",
        "--out",
        "sweep",
        "--backend",
        "cpu",
        "--quiet",
    ]);
}

fn best(place: &Place, arguments: &[&str]) -> Value {
    let all = [
        &["evaluate", "--best"],
        arguments,
        &["--json", "--backend", "cpu", "--quiet"],
    ]
    .concat();
    serde_json::from_str(&place.good(&all)).unwrap()
}

/// The best has the best mean, worked out here with the library alone; the genome with the highest single life is another.
#[test]
fn the_best_of_what_was_recorded_has_the_best_mean() {
    const LIVES: usize = 30;
    let place = Place::new("best");
    place.two_runs();
    let found = best(
        &place,
        &[
            "--genomes",
            "runs",
            "--trials",
            "30",
            "--seed",
            "4",
            "--out",
            "best.json",
        ],
    );
    let npy = |file: &str| {
        let bytes = place.read(format!("runs/{file}"));
        npyz::NpyFile::new(&bytes[..]).unwrap().into_vec::<f32>().unwrap()
    };
    // Each genome once, by the name that comes first.
    let mut genomes: Vec<(String, Vec<f32>)> = Vec::new();
    for run in ["run-2", "run-10"] {
        for file in ["champion.npy", "luckiest.npy", "population.npy"] {
            let all = npy(&format!("{run}/{file}"));
            for (row, genome) in all.chunks(18).enumerate() {
                let row = if all.len() > 18 {
                    format!("[{row}]")
                } else {
                    String::new()
                };
                if genomes.iter().all(|(_, known)| known != genome) {
                    genomes.push((format!("runs/{run}/{file}{row}"), genome.to_vec()));
                }
            }
        }
    }
    assert!((40..44).contains(&genomes.len()), "{}", genomes.len());
    let world = World::new(WorldSpec {
        cycles: 300,
        noise: Noise::SENSOR,
        ..WorldSpec::miglino1995()
    })
    .unwrap();
    let rollouts: Vec<Rollout<'_>> = genomes
        .iter()
        .flat_map(|(_, genes)| {
            (0..LIVES as u64).map(move |life| Rollout {
                world: 0,
                genes,
                key: Key::rollout(4, (1 << 32) + 1, 0, life),
            })
        })
        .collect();
    let batch = Batch::new(&[world], &rollouts, None).unwrap();
    let lives = Cpu::new(Some(1)).unwrap().evaluate(&batch, &Control::new()).unwrap();
    let mean = |lives: &[f32]| lives.iter().map(|life| f64::from(*life)).sum::<f64>() / lives.len() as f64;
    let highest = |lives: &[f32]| lives.iter().copied().fold(f32::MIN, f32::max);
    let mut known: Vec<(&str, f64, f32, &[f32])> = genomes
        .iter()
        .zip(lives.fitness.chunks(LIVES))
        .map(|((source, _), lives)| (source.as_str(), mean(lives), highest(lives), lives))
        .collect();
    known.sort_by(|a, b| b.1.total_cmp(&a.1));
    let luckiest = known.iter().max_by(|a, b| a.2.total_cmp(&b.2)).unwrap();
    assert_ne!(luckiest.0, known[0].0, "here the best life is not the best genome's");

    let rows = found["genomes"].as_array().unwrap();
    assert_eq!(rows.len(), known.len());
    let near = |value: &Value, expected: f64| (value.as_f64().unwrap() - expected).abs() < 1e-6;
    for (row, (source, mean, highest, lives)) in rows.iter().zip(&known) {
        assert_eq!(row["source"], *source);
        assert!(near(&row["mean"], *mean));
        assert_eq!(row["highest"].as_f64().unwrap() as f32, *highest);
        let lowest = lives.iter().copied().fold(f32::MAX, f32::min);
        assert_eq!(row["lowest"].as_f64().unwrap() as f32, lowest);
        let squares: f64 = lives.iter().map(|life| (f64::from(*life) - mean).powi(2)).sum();
        let deviation = (squares / 29.0).sqrt();
        assert!(near(&row["deviation"], deviation));
        // t of 29 degrees of freedom.
        let reach = 2.045_23 * deviation / 30.0_f64.sqrt();
        assert!((row["interval"][0].as_f64().unwrap() - (mean - reach)).abs() < 1e-3);
    }
    assert_eq!(found["best"]["source"], known[0].0);
    assert_eq!(place.text("best.json").parse::<Value>().unwrap(), found["best"]);
    assert_ne!(
        best(&place, &["--genomes", "runs", "--trials", "30"])["best"]["mean"],
        found["best"]["mean"]
    );

    // For people: the best is marked, and the first of all.
    let shown = place.good(&[
        "evaluate",
        "--best",
        "--genomes",
        "runs",
        "--trials",
        "30",
        "--seed",
        "4",
    ]);
    let lines: Vec<&str> = shown.lines().collect();
    assert!(
        lines[1].starts_with(known[0].0) && lines[1].ends_with("  best"),
        "{shown}"
    );
    assert!(lines.len() == 22 && lines[21].contains("more; --all"), "{shown}");
    let all = place.good(&[
        "evaluate",
        "--best",
        "--genomes",
        "runs",
        "--trials",
        "30",
        "--seed",
        "4",
        "--all",
    ]);
    assert_eq!(all.lines().count(), known.len() + 1);

    // Other commands accept the written file, also beside run directories.
    let one = place.evaluate(&["small.toml", "--genomes", "best.json", "--trials", "1", "--seed", "9"]);
    let replay = |more: &[&str]| -> Value {
        let all = [
            "replay",
            "runs/run-2",
            "--json",
            "--genome",
            "best.json",
            "--out",
            "again",
        ];
        serde_json::from_str(&place.good(&[&all[..], more].concat())).unwrap()
    };
    let drawn = replay(&["--seed", "9"]);
    assert_eq!(
        (&drawn["compared"], &drawn["individual"]),
        (&Value::Bool(false), &Value::Null)
    );
    let trace = place.text("again/replay-0-genome-best-seed-9.csv");
    let (names, lines) = table(&trace);
    let fitness = names.iter().position(|name| *name == "fitness").unwrap();
    assert_eq!(lines[299][fitness].parse::<f64>().ok(), one[0]["fitness"].as_f64());
    // The picture's title has the fitness to six digits, however small it is.
    let picture = place.text("again/replay-0-genome-best-seed-9.svg");
    let (_, title) = picture.split_once("fitness ").unwrap();
    let shown: f64 = title[..title.find('<').unwrap()].parse().unwrap();
    let lived = one[0]["fitness"].as_f64().unwrap();
    assert!((shown - lived).abs() <= 5e-6 * lived.abs(), "{shown}, {lived}");
    assert_ne!(replay(&[])["bits"], drawn["bits"]);
    let again = best(
        &place,
        &["--genomes", "best.json", "runs/run-10", "--trials", "30", "--seed", "4"],
    );
    assert_eq!(again["best"]["source"], "best.json");
    assert_eq!(again["best"]["mean"], found["best"]["mean"]);

    let individuals = best(&place, &["--genomes", "runs/run-2", "--trials", "2", "--individuals"]);
    let names: Vec<&str> = individuals["genomes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| row["source"].as_str().unwrap())
        .collect();
    assert!(names.len() > 90 && names.iter().any(|name| name.starts_with("runs/run-2/individuals.npy[")));
}

/// A sweep records its champions: those that its runs have by themselves, whatever the other tables are called.
#[test]
fn the_best_of_a_sweep() {
    let place = Place::new("best-sweep");
    small_sweep(&place, "[grid]\nevolution.elite = [0, 1]\n");
    let champions = place.text("sweep/champions.csv");
    let (names, lines) = table(&champions);
    assert_eq!(
        (names[0], names[1], names.len(), lines.len()),
        ("run", "left_90_to_left", 19, 4)
    );
    place.good(&[
        "sweep",
        "extract",
        "sweep",
        "3",
        "--out",
        "run",
        "--backend",
        "cpu",
        "--quiet",
    ]);
    let bytes = place.read("run/champion.npy");
    let genome = npyz::NpyFile::new(&bytes[..]).unwrap().into_vec::<f32>().unwrap();
    let own: Vec<f32> = lines[3][1..].iter().map(|gene| gene.parse().unwrap()).collect();
    assert_eq!(own, genome);

    let found = best(&place, &["--genomes", "sweep", "--trials", "50"]);
    let rows = found["genomes"].as_array().unwrap();
    assert_eq!(rows.len(), 4);
    let last = rows
        .iter()
        .find(|row| row["source"] == "sweep/champions.csv[3]")
        .unwrap();
    let alone = best(
        &place,
        &["small.toml", "--genomes", "run/champion.npy", "--trials", "50"],
    );
    assert_eq!(alone["best"]["mean"], last["mean"]);
    // The same genome by another name is there once.
    let with = best(&place, &["--genomes", "sweep", "run/champion.npy", "--trials", "50"]);
    assert_eq!(with, found);
    assert_eq!(place.evaluate(&["--genomes", "sweep", "--trials", "3"]).len(), 12);

    // Shards bring theirs along.
    for shard in ["1/2", "2/2"] {
        let out = format!("shard-{}", &shard[..1]);
        let all = [
            "sweep",
            "run",
            "s.toml",
            "--out",
            &out,
            "--shard",
            shard,
            "--backend",
            "cpu",
            "--quiet",
        ];
        place.good(&all);
    }
    place
        .run(&["evaluate", "--best", "--genomes", "shard-1"])
        .exits(3)
        .says(&["shard-1", "has no champions.csv yet", "sweep merge"]);
    place.good(&["sweep", "merge", "shard-1", "shard-2", "--out", "merged"]);
    assert_eq!(place.text("merged/champions.csv"), champions);
}

#[test]
fn incomparable_genomes_are_refused_with_the_key() {
    let place = Place::new("best-refused");
    place.two_runs();
    let run = |name: &str, set: &str| {
        let all = [
            "run",
            "small.toml",
            "--seed",
            "1",
            "--set",
            set,
            "--out",
            name,
            "--backend",
            "cpu",
            "--quiet",
        ];
        place.good(&all);
    };
    run("hidden", "controller.kind=\"hidden\"");
    run("quiet", "noise.sensor=[0.0,0.0]");
    small_sweep(&place, "[grid]\nnoise.sensor = [[0.0, 0.0], [0.0, 0.4]]\n");
    place.write(
        "mixed.toml",
        "experiment = \"small.toml\"\nseeds = [1]\n[grid]\ncontroller.kind = [\"perceptron\", \"recurrent\"]\n",
    );
    place.good(&[
        "sweep",
        "run",
        "mixed.toml",
        "--out",
        "mixed",
        "--backend",
        "cpu",
        "--quiet",
    ]);
    let mixed = place.text("mixed/champions.csv");
    let (names, lines) = table(&mixed);
    assert_eq!(names.len(), 1 + 18 + 4);
    assert_eq!(lines[0].iter().filter(|cell| cell.is_empty()).count(), 4);
    assert!(lines[1].iter().all(|cell| !cell.is_empty()));
    fs::create_dir(place.at("unfinished")).unwrap();
    fs::copy(place.at("quiet/config.toml"), place.at("unfinished/config.toml")).unwrap();
    fs::create_dir(place.at("empty")).unwrap();
    place.write("swarm.toml", "[swarm]\nminutes = 3\n");
    place.write("swarms.toml", "experiment = \"swarm.toml\"\nseeds = [1]\n");
    place.good(&[
        "sweep",
        "run",
        "swarms.toml",
        "--out",
        "swarms",
        "--backend",
        "cpu",
        "--quiet",
    ]);
    assert!(!place.at("swarms/champions.csv").exists());
    for (code, arguments, words) in [
        (3, &["runs", "--trials", "1"][..], &["--trials 1", "allowed: 2 to"][..]),
        (
            3,
            &["runs", "quiet"],
            &[
                "run-2",
                "quiet",
                "come from different experiments (noise.sensor: ",
                "[0.0, 0.4]",
                "an experiment before --genomes",
                "--set noise.sensor=VALUE",
            ],
        ),
        (
            3,
            &["runs", "hidden"],
            &["different experiments (controller.kind: \"perceptron\" / \"hidden\")"],
        ),
        (
            3,
            &["sweep"],
            &["noise.sensor = [0.0, 0.0]", "different experiments (noise.sensor: "],
        ),
        (3, &["mixed"], &["different experiments (controller.kind: "]),
        (3, &["mixed", "--best", "small.toml"], &["22 genes", "allowed: 18"]),
        (3, &["hidden", "--best", "small.toml"], &["46 genes", "allowed: 18"]),
        (3, &["swarms"], &["swarms", "allowed: sweeps of other experiments"]),
        (
            3,
            &["unfinished"],
            &["unfinished: is not finished", "there are no genomes yet", "allowed"],
        ),
        (3, &["empty"], &["empty", "allowed"]),
        (3, &["nothing.npy", "--best", "small.toml"], &["nothing.npy"]),
        (
            2,
            &["runs/run-2/champion.npy"],
            &["champion.npy", "an experiment before --genomes"],
        ),
        (3, &["runs", "--out", "best.npy"], &["--out best.npy", ".json"]),
        (3, &["runs", "--out", "runs/run-2/champion.json"], &["exists already"]),
        (2, &[], &["FILE|DIR"]),
    ] {
        // An experiment follows --best.
        let best: &[&str] = if arguments.contains(&"--best") {
            &[]
        } else {
            &["--best"]
        };
        let all = [&["evaluate", "--genomes"], arguments, best].concat();
        place.run(&all).exits(code).says(words);
    }
    // One world for all, by a setting or by an experiment; unfinished runs are left out.
    for more in [&["--set", "noise.sensor=[0.0,0.4]"][..], &["small.toml"]] {
        let genomes = [
            "--genomes",
            "sweep",
            "quiet",
            "runs/run-2",
            "unfinished",
            "--trials",
            "3",
        ];
        let all = [more, &genomes].concat();
        assert!(best(&place, &all)["genomes"].as_array().unwrap().len() > 20);
    }
}

/// A network of as many genes and as many units as there may be evolves, goes on after a stop with the bits of a run without one, and can be
/// computed again from its files.
#[test]
fn the_largest_genomes_evolve_and_are_read_again() {
    let place = Place::new("largest");
    let sensor = |index: u32| {
        format!(
            "{{ name = 's{index}', range_mm = 100, heading_turns = {} }}",
            f64::from(index) / 62.0 - 0.5
        )
    };
    let sensors: Vec<_> = (0..62).map(sensor).collect();
    let layers = "[{ units = 1024, biases = false, activation = 'tanh' }, { units = 2, biases = false }]";
    let text = format!(
        "cycles = 10\nrobot = {{ preset = 'khepera', sensors = [{}] }}
controller = {{ kind = 'network', outputs = 'first_two', layers = {layers} }}
evolution = {{ population = 4, parents = 2, generations = 3, finalists = 0 }}\n",
        sensors.join(", ")
    );
    place.write("largest.toml", text);
    let genes = "65536 genes";
    assert!(place.good(&["check", "largest.toml"]).contains(genes));
    place.evolved("largest.toml", "1", "whole", &[]);
    place.evolved("largest.toml", "1", "extended", &["--set", "evolution.generations=2"]);
    place.good(&[
        "resume",
        "extended",
        "--generations",
        "3",
        "--backend",
        "cpu",
        "--quiet",
    ]);
    for file in ["champion.npy", "individuals.npy"] {
        assert_eq!(
            place.read(format!("whole/{file}")),
            place.read(format!("extended/{file}"))
        );
    }
    let champion = place.json("whole", "champion.json");
    assert_eq!(champion["genome"].as_array().unwrap().len(), 65_536);
    place.good(&["verify", "whole", "--recompute", "--backend", "cpu"]);
    let [whole, npy] = [
        &["--genomes", "whole"][..],
        &["largest.toml", "--genomes", "whole/champion.npy"],
    ]
    .map(|genomes| place.evaluate(&[genomes, &["--trials", "2"]].concat()));
    assert_eq!(bits(&whole), bits(&npy));
    place
        .run(&[
            "run",
            "largest.toml",
            "--seed",
            "1",
            "--set",
            "evolution.kind=\"cma-es\"",
        ])
        .exits(3)
        .says(&[genes, "allowed: up to 100, or sep-cma-es"]);
}

/// An experiment whose run is quick.
const FEW: &str =
    "cycles = 60\n[evolution]\npopulation = 20\nparents = 4\ngenerations = 2\nfinalists = 2\nfinalist_lives = 2\n";

/// The command that is printed last replays the first episode of the table with the same bits, or is no replay.
#[test]
fn the_next_command_replays_the_first_episode() {
    let place = Place::new("next");
    place.write("small.toml", FEW);
    place.evolved("small.toml", "1", "run", &[]);
    place.write("starts.csv", "x_mm,y_mm,heading_turns\n100,90,0.125\n300,300,0.25\n");
    for options in [
        &["--trials", "2"][..],
        &["--starts", "starts.csv"],
        &["--starts", "starts.csv", "--set", "seed=7"],
    ] {
        let seed: &[&str] = if options.contains(&"--set") {
            &[]
        } else {
            &["--seed", "5"]
        };
        let said = place
            .run(&[&["evaluate", "--genomes", "run"], options, seed].concat())
            .exits(0);
        let next = said.stderr.lines().find_map(|line| line.strip_prefix("next: oneiro "));
        let bits = said.stdout.lines().nth(1).unwrap().split(',').nth(3).unwrap();
        let next: Vec<&str> = next.unwrap().split(' ').collect();
        assert_eq!(next[..2], ["replay", "run"], "{next:?}");
        let replayed = place.good(&[&next[..], &["--json"]].concat());
        let replayed: Value = serde_json::from_str(&replayed).unwrap();
        assert_eq!(replayed["trial_bits"], bits, "{next:?}");
    }
    for other in [&["--population"][..], &["--noise", "off"], &["--set", "cycles=50"]] {
        let said = place
            .run(&[&["evaluate", "--genomes", "run", "--seed", "5"], other].concat())
            .exits(0);
        assert!(!said.stderr.contains("next: oneiro replay"), "{}", said.stderr);
    }
    // The parser forgets these needs where another option excludes what is needed.
    for (option, needed) in [
        (&["--individuals"][..], "--best"),
        (&["--all"], "--best"),
        (&["--every", "2"], "--tournament"),
    ] {
        for others in [&["--starts", "starts.csv"][..], &["--trials", "2"], &[]] {
            place
                .run(&[&["evaluate", "--genomes", "run"], option, others].concat())
                .exits(2)
                .says(&[needed]);
        }
    }
}

/// A run of others' genomes is of the same experiment as any.
#[test]
fn adopted_runs_are_evaluated_beside_others() {
    let place = Place::new("adopted");
    place.write("small.toml", FEW);
    place.evolved("small.toml", "1", "run", &[]);
    place.good(&[
        "adopt",
        "small.toml",
        "--genomes",
        "run",
        "--trials",
        "2",
        "--seed",
        "1",
        "--out",
        "adopted",
    ]);
    let table = place.good(&[
        "evaluate",
        "--genomes",
        "run",
        "adopted",
        "--seed",
        "3",
        "--common-starts",
    ]);
    let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|row| row.split(',').collect()).collect();
    assert_eq!(rows.len(), 2);
    assert_eq!(rows[0][3], rows[1][3]);
    place
        .run(&["adopt", "small.toml", "--genomes", "nothing", "--out", "other"])
        .exits(3)
        .says(&["nothing"]);
}
