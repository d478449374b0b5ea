//! State machines, behaviour trees and races through the program: champions as texts, texts as genomes, records that are the same however a run went
//! on, and refusals.

use std::path::Path;

mod place;
use place::Place;

fn experiment() -> String {
    let experiments = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments");
    experiments.join("automode-aggregation.toml").display().to_string()
}

/// Few robots, for a second.
const SHORT: [&str; 10] = [
    "--set",
    "cycles=20",
    "--set",
    "robot.count=3",
    "--set",
    "evolution.race.lives=400",
    "--set",
    "evolution.finalist_lives=4",
    "--set",
    "record.checkpoint_every=1",
];

#[test]
fn a_champion_is_a_text_that_lives_as_its_genes_do() {
    check_champion("state-machine", "--nstates ");
}

#[test]
fn so_is_a_behaviour_trees() {
    check_champion("behaviour-tree", "--nroot 3 --nchildroot ");
}

fn check_champion(controller: &str, begins: &str) {
    let place = Place::new(controller);
    let file = experiment();
    let kind = format!("controller.kind={controller}");
    let short = [&SHORT[..], &["--set", &kind]].concat();
    place.good(&[&["run", &file, "--seed", "2", "--out", "run"][..], &short].concat());
    place.good(&["verify", "run"]);
    let generations = place.text("run/generations.csv").lines().count() - 1;
    assert!(generations > 12, "{generations}");
    for name in ["champion", "luckiest"] {
        let text = place.text(format!("run/{name}.txt"));
        assert!(text.starts_with(begins) && text.lines().count() == 1, "{text}");
        let lived = |genomes: &str| {
            let lives = ["--trials", "5", "--seed", "9", "--common-starts"];
            place.good(&[&["evaluate", &file, "--genomes", genomes][..], &short, &lives].concat())
        };
        assert_eq!(
            lived(&format!("run/{name}.txt")),
            lived(&format!("run/{name}.npy")),
            "{name}"
        );
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let place = Place::new("machines-refused");
    let file = experiment();
    place.write("bad.txt", "--nstates 1 --s0 1\n--nstates 1 --s0 9\n");
    place
        .run(&["evaluate", &file, "--genomes", "bad.txt", "--trials", "1"])
        .exits(3)
        .says(&["bad.txt: line 2, word 4: `--s0` is `9`; allowed: 0 to 5, whole"]);
    let network = file.replace("automode", "evostick");
    place
        .run(&["evaluate", &network, "--genomes", "bad.txt", "--trials", "1"])
        .exits(3)
        .says(&["bad.txt: is a text, which only state machines and behaviour trees have"]);
    for (set, message) in [
        (
            "robot.model=rm1.1",
            "controller.kind: is `state-machine`; allowed: only with robot.model = \"rm1.1-vectors\"",
        ),
        (
            "evolution.common_random_numbers=false",
            "is false; allowed: true with race",
        ),
        ("record.individuals=true", "is true; allowed: false with race"),
        (
            "evolution.population=8",
            "is 8; allowed: more than 8, which may survive a race of 97 genes",
        ),
        (
            "evolution.race.confidence=2",
            "evolution.race.confidence: is 2.0; allowed: 0.5 to 0.999999",
        ),
        (
            "controller.slowest_wheel=-2",
            "controller.slowest_wheel: is -2; allowed: -1 to 1",
        ),
    ] {
        place.run(&["check", &file, "--set", set]).exits(3).says(&[message]);
    }
}
