//! Sweeps of swarms, and of robots that meet reality.

use super::*;

/// Six runs of a shipped swarm experiment, three minutes each.
const SWARMS: &str = r#"
    experiment = "odowd2014-over.toml"
    seeds = "1..3"
    [set]
    swarm.minutes = 3
    [grid]
    swarm.robots = [4, 5]
    [[list]]
    swarm.controllers.mutation_scale = 0.1
"#;

/// The sweep in `sweep.toml` gives the same with one thread, one run at a time, in shards, and after kills.
fn is_the_same_however_it_is_done(place: &Place, kills: u32) {
    let begun = Instant::now();
    let known = place.swept("known", &["--threads", "2"]);
    let whole = begun.elapsed();
    for (out, more) in [
        ("one", ["--threads", "1"]),
        ("each", ["--jobs", "1"]),
        ("scalar", ["--backend", "cpu:scalarx1"]),
    ] {
        assert_eq!(place.swept(out, &more), known, "{more:?}");
        place.assert_same_tables("known", out);
    }
    for shard in ["2/2", "1/2"] {
        place.good(&sweep("shards", &["--shard", shard]));
    }
    assert_eq!(place.data(&["sweep", "merge", "shards"])["hash"], known);

    let arguments = sweep("killed", &["--jobs", "2", "--checkpoint-every", "0.001s"]);
    let killed = place.killed(&arguments, kills, whole.mul_f64(0.7), "known");
    assert!(killed.resumed > 0, "no process has gone on from what others had done");
    assert_eq!(place.swept("killed", &[]), known);
    place.assert_same_tables("known", "killed");
}

#[test]
fn of_swarms_are_the_same_however_they_are_done() {
    let place = Place::with_sweep("swarms", SWARMS);
    let experiments = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments");
    place.write(
        "odowd2014-over.toml",
        fs::read(experiments.join("odowd2014-over.toml")).unwrap(),
    );
    is_the_same_however_it_is_done(&place, 12);
    // A run of its own has the same result, and a line for each robot in each interval.
    let results = place.column("known/results.csv", "result");
    let extract = ["sweep", "extract", "known", "4", "--backend", "cpu", "--out", "four"];
    assert_eq!(place.data(&extract)["result"], results[4]);
    place.good(&["verify", "four"]);
    let own = place.text("four/intervals.csv");
    let table = place.text("known/generations.csv");
    let rows: Vec<&str> = table.lines().filter_map(|row| row.strip_prefix("4,")).collect();
    assert_eq!(own.lines().skip(1).collect::<Vec<_>>(), rows);
    assert_eq!(rows.len(), 3 * 5);
    let set = [
        "swarm.minutes=3",
        "swarm.robots=5",
        "swarm.controllers.mutation_scale=0.1",
    ];
    let run = [
        "run",
        "odowd2014-over.toml",
        "--backend",
        "cpu",
        "--seed",
        "2",
        "--out",
        "own",
    ];
    place.good(&[&run[..], &set.iter().flat_map(|set| ["--set", set]).collect::<Vec<_>>()].concat());
    assert!(place.text("own/DONE").contains(&results[4]));
    // Another seed gives different results.
    assert!(results[3] != results[4]);
}

/// The first generation in reality is compared with its lives in the simulator, also after an interruption.
#[test]
fn in_their_own_reality_are_the_same_however_they_are_done() {
    let sweep = r#"
        experiment = "small.toml"
        seeds = "1..6"
        seeds_by = "reality.robot"
        [set]
        evolution.generations = 50
        robot.tables = "reality"
        robot.motors = "reality"
        reality.generations = 6
        [grid]
        reality.robot = ["surrogate:1", "surrogate:2"]
        noise.sensor = [[0.0, 0.0], [0.0, 0.4]]
        robot.collision = ["undo", "slide"]
        [reality]
        robots = "own"
    "#;
    let place = Place::with_sweep("own-reality", sweep);
    is_the_same_however_it_is_done(&place, 12);
    let column = |name| place.column("known/results.csv", name);
    let numbers = |name| {
        column(name)
            .iter()
            .map(|cell| cell.parse().unwrap())
            .collect::<Vec<f64>>()
    };
    let seeds = column("seed");
    assert_eq!(
        (&*seeds[0], &*seeds[5], &*seeds[24], &*seeds[47]),
        ("1", "6", "7", "12")
    );
    let noisy: Vec<bool> = column("noise.sensor").iter().map(|noise| noise.contains('4')).collect();
    let [simulated, quiet, real, last] = ["simulated", "quiet", "real", "last"].map(numbers);
    for run in 0..48 {
        // Without noise both simulators are one, and the same individuals begin at the same places.
        assert_eq!(simulated[run] == quiet[run], !noisy[run], "run {run}");
        assert!(real[run] != quiet[run] && real[run] != last[run], "run {run}");
    }
    let [gap, repeat] = ["path_gap_mm", "path_repeat_mm"].map(numbers);
    assert!(gap.iter().chain(&repeat).all(|sum| (0.0..1e6).contains(sum)));
    assert!(gap.iter().any(|sum| *sum > 0.0) && gap != repeat);
    // What was compared is the first generation in reality.
    let rows = place.text("known/generations.csv");
    let first = rows.lines().find(|row| row.starts_with("0,44,")).unwrap();
    assert_eq!(first.split(',').nth(4), Some(&*column("real")[0]));
}

#[test]
fn in_reality_and_of_drawn_values_are_the_same_however_they_are_done() {
    let sweep = r#"
        experiment = "small.toml"
        seeds = "3..4"
        [set]
        evolution.generations = 40
        [[list]]
        controller = { kind = "perceptron" }
        [[list]]
        controller = { kind = "recurrent" }
        [random]
        samples = 3
        [random.ranges]
        cycles = { from = 100, to = 300 }
        trials = { from = 1, to = 3 }
        evolution.mutation.amount = { from = 0.01, to = 10.0, scale = "log" }
        [reality]
        robots = [1, 2]
    "#;
    let place = Place::with_sweep("reality", sweep);
    is_the_same_however_it_is_done(&place, 12);
    let column = |name| place.column("known/results.csv", name);
    let [simulated, real, best] = ["simulated", "real", "real_best"].map(column);
    for ((simulated, real), best) in simulated.iter().zip(&real).zip(&best) {
        let [simulated, real, best] = [simulated, real, best].map(|cell| cell.parse::<f64>().unwrap());
        assert!(simulated != real && real <= best, "{simulated}, {real}, {best}");
    }
    // Another robot changes reality but not the evolution.
    place.write("sweep.toml", sweep.replace("[1, 2]", "[1, 3]"));
    place.swept("other", &[]);
    let other = |name| place.column("other/results.csv", name);
    assert_eq!(other("result"), column("result"));
    assert_eq!(other("simulated"), simulated);
    assert_ne!(other("real"), real);
}
