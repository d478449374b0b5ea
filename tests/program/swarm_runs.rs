//! Experiments with a swarm through the program: records are the same on every device, and invalid values are refused
//! by key.

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::thread;
use std::time::Duration;

use serde_json::Value;

use crate::place::Place;

const CASES: [&str; 6] = [
    "no-light",
    "over",
    "opposite",
    "over-then-opposite",
    "opposite-then-over",
    "random",
];

fn experiment(case: &str) -> String {
    let experiments = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments");
    experiments.join(format!("odowd2014-{case}.toml")).display().to_string()
}

#[test]
fn each_case_is_an_experiment() {
    let place = Place::new("cases");
    for case in CASES {
        let file = experiment(case);
        let said = place.good(&["check", &file]);
        let evolves = "  method      as the paper\n  messages    encounters, migration 1\n";
        assert_eq!(said.contains(evolves), case != "random", "{said}");
        let mut set = vec!["--set", "swarm.minutes=4"];
        if case.contains("-then-") {
            set.extend(["--set", "swarm.light_moves_minute=2"]);
        }
        let out = ["--seed", "3", "--backend", "cpu", "--out", case];
        place.good(&[&["run", &file][..], &set, &out].concat());
        place.good(&["verify", case]);
        place.good(&["verify", "--recompute", case, "--backend", "cpu", "--threads", "1"]);
        let lines = place.text(format!("{case}/intervals.csv")).lines().count();
        assert_eq!(lines, if case == "random" { 1 } else { 1 + 4 * 10 }, "{case}");
        assert_eq!(place.text(format!("{case}/food.csv")).lines().count(), 1 + 240);
    }
    place.good(&["list", "."]);
    // The same seed elsewhere gives the same bytes; another seed gives different ones.
    let file = experiment("over");
    let again = |seed, out| {
        place.good(&[
            "run",
            &file,
            "--backend",
            "cpu",
            "--seed",
            seed,
            "--out",
            out,
            "--set",
            "swarm.minutes=4",
        ]);
    };
    again("3", "same");
    again("4", "other");
    assert!(place.read("over/intervals.csv") == place.read("same/intervals.csv"));
    assert!(place.read("over/intervals.csv") != place.read("other/intervals.csv"));
    place.good(&["replay", "over", "--backend", "cpu"]);
    assert!(place.text("over/replay.html").contains("<canvas"));
    // The picture and the film are of the same replay.
    let taken = ["--picture", "at.svg", "--at", "30", "--film", "a.gif", "--speed", "60"];
    let answer = place.answer(&[&["replay", "over", "--backend", "cpu", "--json"], &taken[..]].concat());
    assert_eq!([&answer["picture"], &answer["film"]], ["at.svg", "a.gif"]);
    assert!(place.text("at.svg").contains(">30 s of ") && place.text("at.svg").contains("lamp</title>"));
    let food = answer["brought"].as_u64().unwrap();
    place.good(&["replay", "over", "--backend", "cpu", "--picture", "end.svg"]);
    assert!(place.text("end.svg").contains(&format!(", food {food}</text>")));
    assert_eq!(&place.read("a.gif")[..6], b"GIF89a");
    place
        .run(&["replay", "over", "--picture", "b.svg", "--at", "100000"])
        .exits(3)
        .says(&["--at 100000: is after the end of the episode; allowed: 0 to "]);
}

#[test]
fn stopped_runs_are_repeated_and_changed_ones_are_detected() {
    let place = Place::new("changed");
    let file = experiment("over");
    let short = [
        "--set",
        "swarm.minutes=4",
        "--seeds",
        "1..3",
        "--backend",
        "cpu",
        "--out",
        "runs",
    ];
    place.good(&[&["run", &file][..], &short].concat());
    // The state that a killed process leaves.
    for name in ["DONE", "intervals.csv", "food.csv"] {
        fs::remove_file(place.at(format!("runs/seed-2/{name}"))).unwrap();
    }
    place
        .run(&["verify", "runs/seed-2"])
        .exits(1)
        .says(&["oneiro resume runs/seed-2"]);
    place
        .run(&[&["run", &file][..], &short].concat())
        .exits(0)
        .says(&["2 of 3 runs are already done", "1 of 3 runs is continued"]);
    place.good(&["verify", "runs"]);
    place.good(&[&["run", &file][..], &short].concat());

    let path = "runs/seed-1/intervals.csv";
    let text = place.text(path).replacen(",0.", ",1.", 1);
    fs::write(place.at(path), text).unwrap();
    place.run(&["verify", "runs/seed-1"]).exits(5).says(&["intervals.csv"]);
    place
        .run(&["verify", "--recompute", "runs/seed-1", "--backend", "cpu"])
        .exits(5)
        .says(&["intervals.csv is not what this device computes"]);
}

/// A killed swarm continues from its last checkpoint and ends with the same results.
#[test]
fn a_killed_swarm_continues_from_its_checkpoint() {
    let place = Place::new("killed");
    let file = experiment("over-then-opposite");
    let minutes = ["--set", "swarm.minutes=120", "--seed", "7", "--backend", "cpu"];
    let run = |out| [&["run", &file, "--out", out][..], &minutes].concat();
    place.good(&run("whole"));
    let mut child = place
        .command(&run("killed"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while !place.at("killed/checkpoint-20").exists() && child.try_wait().unwrap().is_none() {
        thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!place.at("killed/DONE").exists(), "the run was too short to be killed");
    place.good(&["resume", "killed", "--backend", "cpu"]);
    for name in ["intervals.csv", "food.csv", "DONE"] {
        assert!(
            place.read(format!("whole/{name}")) == place.read(format!("killed/{name}")),
            "{name}"
        );
    }
    let meta: Value = serde_json::from_str(&place.text("killed/meta.json")).unwrap();
    let from = meta["sessions"][1]["from_generation"].as_u64().unwrap();
    assert!(from >= 10, "it began again at minute {from}");
}

/// Runs of several kinds in one directory: resumed together, and each command prints one JSON document.
#[test]
fn kinds_of_runs_may_share_a_directory() {
    let place = Place::new("mixed");
    let file = experiment("over");
    let swarm = ["--set", "swarm.minutes=3", "--seed", "1", "--backend", "cpu"];
    place.good(&[&["run", &file, "--out", "runs/swarm"][..], &swarm].concat());
    place.write(
        "single.toml",
        "cycles = 20\n[evolution]\npopulation = 8\nparents = 2\ngenerations = 3\n",
    );
    place.good(&["run", "single.toml", "--seed", "1", "--out", "runs/single"]);
    let done = [place.read("runs/single/DONE"), place.read("runs/swarm/DONE")];
    for name in ["single", "swarm"] {
        fs::remove_file(place.at(format!("runs/{name}/DONE"))).unwrap();
    }
    let document = |arguments: &[&str]| -> Value { serde_json::from_str(&place.good(arguments)).unwrap() };
    let resumed = document(&["resume", "runs", "--backend", "cpu", "--json"]);
    assert_eq!(resumed[0]["directory"], "runs/single");
    assert!(resumed[0]["fitness"].is_number() && resumed[1]["brought"].is_number());
    assert_eq!(done, [place.read("runs/single/DONE"), place.read("runs/swarm/DONE")]);
    let audited = document(&["verify", "--recompute", "runs", "--backend", "cpu", "--json"]);
    assert_eq!(audited["runs"].as_array().unwrap().len(), 2);
    for command in ["list", "verify"] {
        assert_eq!(document(&[command, "runs", "--json"]).as_array().unwrap().len(), 2);
    }
}

#[test]
fn invalid_values_are_refused_by_key() {
    let place = Place::new("refused");
    let file = experiment("over");
    for (set, words) in [
        ("swarm.robots=0", "swarm.robots: is 0; allowed: 1 to 128"),
        ("swarm.minutes=1667", "swarm.minutes: is 1667; allowed: 1 to 1666"),
        ("swarm.light_moves_minute=2000", "allowed: 0 to 1666"),
        ("swarm.case=under", "allowed: no-light"),
        (
            "swarm.arena.food_items=65",
            "swarm.arena.food_items: is 65; allowed: 0 to 64",
        ),
        (
            "swarm.arena.food_scales=with_area swarm.arena.radius_mm=2000.0",
            "swarm.arena.food_scales: makes 78 items of food; allowed: at most 64, with fewer swarm.arena.food_items",
        ),
        ("swarm.messages.heard=2", "swarm.messages.heard: is 2; allowed: 0 to 1"),
        ("swarm.simulators.credit=mine", "allowed: lagged or matched"),
        ("swarm.simulators.pair=3", "unknown key"),
        (
            "swarm.clock.installed_s=3",
            "swarm.clock.installed_s: is 3; allowed: 5 to 60",
        ),
        (
            "swarm.controllers.parents=11",
            "swarm.controllers.parents: is 11; allowed: 1 to 10",
        ),
        (
            "swarm.control=embodied",
            "swarm.clock.offset_s: is 5; allowed: 0 with this swarm.control",
        ),
        (
            "swarm.control=embodied swarm.clock.offset_s=0 swarm.clock.interval_s=120",
            "swarm.clock.installed_s: is 60; allowed: 120, swarm.clock.interval_s, with this swarm.control",
        ),
        (
            "swarm.control=embodied swarm.clock.offset_s=0 swarm.controllers.population=5",
            "swarm.controllers.population: is 5, which has no effect; allowed: only with simulators",
        ),
        (
            "swarm.control=heard-by-all swarm.messages.range_mm=100",
            "swarm.messages.range_mm: is 100, which has no effect; allowed: only with another swarm.control",
        ),
        (
            "swarm.messages.topology=ring swarm.messages.heard=0.2",
            "swarm.messages.heard: is 0.2, which has no effect; allowed: only with swarm.messages.topology = \"encounters\"",
        ),
        ("swarm.messages.topology=star", "allowed: encounters, all, ring, torus"),
        (
            "swarm.messages.migration=1.5",
            "swarm.messages.migration: is 1.5; allowed: 0 to 1",
        ),
        (
            "swarm.control=central",
            "swarm.clock.offset_s: is 5; allowed: 0 with this swarm.control",
        ),
        (
            "swarm.control=central swarm.clock.offset_s=0 swarm.messages.range_mm=100",
            "swarm.messages.range_mm: is 100, which has no effect; allowed: only with another swarm.control: there robots exchange nothing",
        ),
        (
            "swarm.control=heard-by-all swarm.messages.migration=0.5",
            "swarm.messages.migration: is 0.5, which has no effect",
        ),
        ("cycles=5", "unknown key"),
        // No effect in these cases.
        (
            "swarm.case=random swarm.messages.range_mm=325",
            "swarm.messages.range_mm: is 325, which has no effect",
        ),
        (
            "swarm.case=random swarm.robot.phototaxis_gain=4",
            "neither see a light nor send anything",
        ),
        (
            "swarm.case=random swarm.controllers.mutation_scale=0.3",
            "in which nothing evolves",
        ),
        (
            "swarm.case=no-light swarm.differences.shadows=0.9",
            "only with a swarm.case that has a light",
        ),
    ] {
        let set: Vec<&str> = set.split(' ').flat_map(|set| ["--set", set]).collect();
        place
            .run(&[&["run", &file][..], &set, &["--out", "none"]].concat())
            .exits(3)
            .says(&[words]);
        assert!(!place.at("none").exists(), "{set:?}");
    }
    place.write("own.toml", "[swarm]\nrobots = 10\nminutes = 0\n");
    place
        .run(&["check", "own.toml"])
        .exits(3)
        .says(&["own.toml:3:11", "swarm.minutes"]);
}
