//! State machines, behaviour trees and races through the program: champions as texts, texts as genomes, records that are the same however a
//! run went on, and refusals; the table of each robot of a swarm.

use std::collections::BTreeMap;
use std::path::Path;

use crate::place::Place;

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

/// However it went on, a race says who survived, and its page shows that; a comparison draws its best where its episodes were spent.
#[test]
fn a_race_records_its_survivors() {
    let place = Place::new("survivors");
    let file = experiment();
    for (confidence, out) in [("0.95", "race"), ("0.9", "other")] {
        let confidence = format!("evolution.race.confidence={confidence}");
        let one = ["run", &file, "--seed", "2", "--out", out, "--set", &confidence];
        place.good(&[&one[..], &SHORT].concat());
    }
    let rounds = place.table_of("race/race.csv");
    assert_eq!(rounds.len(), place.table_of("race/generations.csv").len());
    let number = |round: &BTreeMap<String, String>, name: &str| round[name].parse::<u64>().unwrap();
    let mut spent = 0;
    for (generation, round) in (0..).zip(&rounds) {
        spent += number(round, "candidates");
        assert_eq!(
            (number(round, "generation"), number(round, "episodes")),
            (generation, spent)
        );
    }
    assert!((300..=400).contains(&spent), "{spent}");
    let page = place.text("race/report.html");
    let last = number(rounds.last().unwrap(), "race");
    assert!(last > 1 && page.contains(&format!("<td class=\"number\">{last}</td>")) && page.contains("id=\"races\""));
    assert!(page.contains(&place.text("race/race.svg")));
    // Episodes of the last generation end the curve.
    let ends = format!("data-across=\"0 {spent}\"");
    assert_eq!(page.matches(&ends).count(), 2, "{ends}");

    place.good(&["compare", "race", "other", "--recorded", "--out", "compared"]);
    let curves = place.table_of("compared/curves.csv");
    let first = number(&rounds[0], "episodes");
    assert!(
        number(&curves[0], "episodes") >= first && number(&curves[0], "episodes") < first + 3,
        "{:?}",
        curves[0]
    );
    assert!(!place.text("compared/compare.html").contains("as if these were equal"));
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
fn robots_with_machines_of_their_own_have_a_line_each() {
    let place = Place::new("machines-of-their-own");
    let file = experiment();
    let set = [
        "--set",
        "robot.genomes=heterogeneous",
        "--set",
        "evolution.kind=genetic",
    ];
    let short = [
        "--set",
        "evolution.generations=2",
        "--set",
        "evolution.population=8",
        "--set",
        "evolution.parents=2",
    ];
    let few = [
        "--set",
        "cycles=20",
        "--set",
        "robot.count=3",
        "--set",
        "evolution.finalist_lives=4",
    ];
    let set = [&set[..], &short, &few].concat();
    place.good(&[&["run", &file, "--seed", "2", "--out", "run"][..], &set].concat());
    place.good(&["verify", "run"]);
    let champion = place.text("run/champion.json");
    for name in ["robot_0.state_0_behaviour", "robot_2.state_0_behaviour"] {
        assert!(champion.contains(name), "{name} in {champion}");
    }
    let text = place.text("run/champion.txt");
    assert_eq!(text.lines().count(), 3, "{text}");
    let lived = |genomes: &str| {
        let lives = ["--trials", "5", "--seed", "9", "--common-starts"];
        place.good(&[&["evaluate", &file, "--genomes", genomes][..], &set, &lives].concat())
    };
    assert_eq!(lived("run/champion.txt"), lived("run/champion.npy"));
    // Each robot's states are those of its own line.
    place.good(&["replay", "run"]);
    let robots = place.text("run/replay-robots.csv");
    for (states, line) in column(&robots, "states").into_iter().zip(text.lines()) {
        let count = line.split(' ').nth(1).unwrap();
        assert_eq!(states.split(' ').count().to_string(), count, "{states} of {line}");
    }
    let two = text.lines().take(2).collect::<Vec<_>>().join("\n");
    place.write("two.txt", &two);
    place
        .run(&[&["evaluate", &file, "--genomes", "two.txt", "--trials", "1"][..], &set].concat())
        .exits(3)
        .says(&["two.txt: has 2 lines; allowed: 3 for each genome"]);
}

/// Names of genes in what is printed and written, files of genomes with these names, and what is refused.
#[test]
fn teams_have_genes_by_name() {
    let place = Place::new("teams");
    place.good(&["new", "--example", "gather", "--quiet"]);
    let set = ["--set", "robot.genomes=[0,0,0,0,0,1,1,1,1,1]", "--set", "cycles=30"];
    let checked = place.good(&[&["check", "gather.toml"][..], &set].concat());
    assert!(
        checked.contains("20 genes") && checked.contains("team_1.bias_right"),
        "{checked}"
    );
    let short = [
        "--set",
        "evolution.generations=2",
        "--set",
        "evolution.finalist_lives=2",
    ];
    place.good(&[&["run", "gather.toml", "--seed", "1", "--out", "run"][..], &set, &short].concat());
    assert!(place.text("run/champion.json").contains("team_0.floor_to_left"));
    place.good(&["replay", "run"]);
    // Each generation's best has the same start, and the fitness of its episode alone.
    let all = place.answer(&["replay", "run", "--generations", "1,0", "--seed", "4", "--json"]);
    for generation in [1, 0] {
        let one = ["--seed", "4", "--json", "--generation", &generation.to_string()];
        let alone = place.answer(&[&["replay", "run"][..], &one].concat());
        assert_eq!(all["generations"][1 - generation]["fitness"], alone["trial_fitness"]);
    }
    let page = place.text("run/learning.html");
    assert!(
        page.contains("The bests of 2 generations, each with 10 robots in one world, from the same start, for 3 s")
    );
    // A table whose columns are in another order.
    let names = |team: u32| {
        let of =
            |to: &str| ["floor", "sees", "front_left", "front_right"].map(|from| format!("team_{team}.{from}_to_{to}"));
        [
            &of("left")[..],
            &[format!("team_{team}.bias_left")],
            &of("right"),
            &[format!("team_{team}.bias_right")],
        ]
        .concat()
    };
    let ordered = [names(0), names(1)].concat();
    let turned = [names(1), names(0)].concat();
    let values: Vec<String> = (0..20).map(|gene| format!("{}", f64::from(gene) / 4.0 - 2.0)).collect();
    let swapped = [&values[10..], &values[..10]].concat();
    place.write("ordered.csv", format!("{}\n{}\n", ordered.join(","), values.join(",")));
    place.write("turned.csv", format!("{}\n{}\n", turned.join(","), swapped.join(",")));
    let lived = |genomes: &str| {
        place.good(
            &[
                &[
                    "evaluate",
                    "gather.toml",
                    "--genomes",
                    genomes,
                    "--trials",
                    "4",
                    "--seed",
                    "1",
                ][..],
                &set,
            ]
            .concat(),
        )
    };
    assert_eq!(lived("ordered.csv"), lived("turned.csv"));
    for (value, message) in [
        ("[0,1]", "robot.genomes: has 2 teams; allowed: one for each robot, 10"),
        ("[0,0,0,0,0,2,2,2,2,2]", "robot.genomes: has no robot in team 1"),
        (
            "each",
            "robot.genomes: is \"each\"; allowed: homogeneous, heterogeneous, or a list with the team of each robot, from 0",
        ),
        ("[0,0.5]", "robot.genomes: is [0, 0.5]; allowed: homogeneous"),
        ("[-1]", "robot.genomes: is [-1]; allowed: homogeneous"),
    ] {
        let value = format!("robot.genomes={value}");
        place
            .run(&["check", "gather.toml", "--set", &value])
            .exits(3)
            .says(&[message]);
    }
}

/// A page and tables of a life that its mission ends have its cycles and no more.
#[test]
fn a_life_that_ends_early_is_played_to_its_end() {
    let place = Place::new("ends");
    place.good(&["new", "--example", "gather", "--quiet"]);
    let mission = |cycles: u32| {
        let text = format!(
            "struct MissionState {{ cycles: u32 }}
            fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {{
                return Tally(1.0f, MissionState(step + 1u));
            }}
            fn mission_ends(episode: Episode, own: MissionState) -> bool {{ return own.cycles == {cycles}u; }}"
        );
        place.write("gather/mission.wgsl", &text);
        let short = [
            "--set",
            "cycles=30",
            "--set",
            "evolution.generations=1",
            "--set",
            "evolution.finalists=0",
        ];
        let out = format!("run-{cycles}");
        place.good(
            &[
                &["run", "gather.toml", "--seed", "1", "--set", "trials=1", "--out", &out][..],
                &short,
            ]
            .concat(),
        );
        let replayed = place.run(&["replay", &out]).exits(0);
        (out, replayed)
    };
    let (out, replayed) = mission(7);
    assert!(replayed.stdout.contains("fitness 7 "), "{}", replayed.stdout);
    let page = place.text(format!("{out}/replay.html"));
    assert!(page.contains("10 robots in one world for 0.7 s, recorded every 0.1 s."));
    assert_eq!(place.text(format!("{out}/replay.csv")).lines().count(), 8);
    let (out, replayed) = mission(0);
    replayed.says(&["warning: there is no page that plays the episode: it ends before its first cycle"]);
    assert!(!place.at(format!("{out}/replay.html")).exists());
    // Its trace has no lines.
    place.good(&[
        "evaluate",
        "--genomes",
        &out,
        "--trials",
        "2",
        "--seed",
        "1",
        "--traces",
        "traces",
    ]);
    let trace = place.text("traces/trace-0-1.csv");
    assert!(trace.starts_with("cycle,x_mm,"), "{trace}");
    assert_eq!(trace.lines().count(), 1, "{trace}");
    place.run(&["replay", &out, "--generations", "0"]).exits(3).says(&[
        "--generations: there is no page of generation 0's best: it ends before its first cycle; allowed: other generations",
    ]);
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

/// A column of a table without quoted cells.
fn column<'a>(table: &'a str, name: &str) -> Vec<&'a str> {
    let mut lines = table.lines();
    let place = lines.next().unwrap().split(',').position(|own| own == name).unwrap();
    lines.map(|line| line.split(',').nth(place).unwrap()).collect()
}

#[test]
fn a_replay_plays_all_robots_and_has_a_row_for_each() {
    let place = Place::new("together");
    let file = experiment();
    place.good(&[&["run", &file, "--seed", "2", "--out", "run"][..], &SHORT].concat());
    let said = place.good(&["replay", "run"]);
    for file in [
        "run/replay.svg",
        "run/replay.csv",
        "run/replay.html",
        "run/replay-robots.csv",
    ] {
        assert!(said.lines().any(|line| line == file), "{file} in {said}");
    }
    assert!(
        place
            .text("run/replay.html")
            .contains("3 robots in one world for 2 s, recorded every 0.1 s.")
    );
    let robots = place.text("run/replay-robots.csv");
    assert_eq!(column(&robots, "robot"), ["0", "1", "2"]);
    assert_eq!(column(&robots, "score"), ["", "", ""], "AGG scores the swarm");
    for states in column(&robots, "states") {
        let cycles = states.split(' ').map(|own| own.parse::<u32>().unwrap());
        assert_eq!(cycles.sum::<u32>(), 20);
    }
    // The first robot's path is that of the trace.
    let trace = place.text("run/replay.csv");
    let [xs, ys] = ["x_mm", "y_mm"]
        .map(|name| -> Vec<f64> { column(&trace, name).iter().map(|own| own.parse().unwrap()).collect() });
    let way: f64 = (1..20)
        .map(|cycle| (xs[cycle] - xs[cycle - 1]).hypot(ys[cycle] - ys[cycle - 1]))
        .sum();
    let told: f64 = column(&robots, "distance_mm")[0].parse().unwrap();
    assert!((way - told).abs() < 1e-5 * way, "{way}, not {told}");

    place.good(&["replay", "run", "--every", "4", "--seed", "5"]);
    assert!(place.text("run/replay-seed-5.html").contains("recorded every 0.4 s."));
}

#[test]
fn robots_that_a_task_scores_have_a_score_each() {
    let place = Place::new("scores");
    place.write(
        "few.toml",
        "name = \"few\"\ncycles = 40\ntrials = 2\n\n[robot]\nkind = \"differential\"\nbody_radius_mm = 37.0\nwheel_base_mm = 51.0\n\
         greatest_speed_mm_s = 128.0\ncount = 4\n\n[[robot.sensors]]\nname = \"ahead\"\nkind = \"proximity\"\nrange_mm = 80.0\n\n\
         [arena]\nwidth_mm = 600.0\nheight_mm = 500.0\n\n[evolution]\npopulation = 8\nparents = 2\ngenerations = 2\nfinalists = 0\n",
    );
    place.good(&["run", "few.toml", "--seed", "1", "--out", "run"]);
    place.good(&["replay", "run", "--seed", "9"]);
    let robots = place.text("run/replay-0-seed-9-robots.csv");
    // The same life: the champion's first with the random numbers of that seed.
    let measured = place.good(&[
        "evaluate",
        "few.toml",
        "--genomes",
        "run",
        "--seed",
        "9",
        "--trials",
        "2",
        "--measures",
    ]);
    let mut sum = 0.0;
    for (robot, score) in column(&robots, "score").into_iter().enumerate() {
        assert_eq!(column(&measured, &format!("score_robot_{robot}"))[0], score);
        sum += score.parse::<f32>().unwrap();
    }
    let fitness: f32 = column(&measured, "fitness")[0].parse().unwrap();
    assert!(
        fitness > 0.0 && (sum - fitness).abs() < 1e-4 * fitness,
        "{sum}, not {fitness}"
    );
    let summary = place.good(&[
        "evaluate",
        "few.toml",
        "--genomes",
        "run",
        "--trials",
        "2",
        "--measures",
        "--summary",
    ]);
    assert_eq!(column(&summary, "mean_score_robot_3").len(), 1);
    // Missions score the swarm.
    let file = experiment();
    let mission = [
        &["evaluate", &file, "--random", "1", "--trials", "1", "--measures"][..],
        &SHORT,
    ]
    .concat();
    assert!(!place.good(&mission).contains("score_robot"));
}
