//! A stranger's task, with the program alone: every step of docs/extend.md, in a directory of its own.

use std::collections::BTreeSet;
use std::fs;

mod given;
mod shipped;
use crate::place::Place;

const CPU: [&str; 3] = ["--backend", "cpu", "--quiet"];

/// The first block of a page in a language that contains some words.
fn block(language: &str, words: &str) -> String {
    let page = include_str!("../../docs/extend.md");
    let fence = format!("```{language}\n");
    let blocks = page.split(&fence).skip(1).filter_map(|block| block.split("```").next());
    let found = blocks.into_iter().find(|block| block.contains(words));
    found
        .unwrap_or_else(|| panic!("no block of {language} has {words}"))
        .to_owned()
}

/// The files of the page's example with values.
fn circles(place: &Place) {
    place.write("circles.wgsl", block("wgsl", "radius: f32"));
    let own = block("toml", "radius = 200.0");
    place.write(
        "circles.toml",
        format!("cycles = 100\nevolution.generations = 4\n{own}"),
    );
}

/// The result hash of a run.
fn result(place: &Place, run: &str) -> String {
    let printed = place.good(&["verify", run]);
    printed.split_whitespace().next().unwrap().to_owned()
}

/// Runs the page's example into a directory, with its own cache of machine code, and returns the result hash.
fn run(place: &Place, out: &str, backend: &str) -> String {
    let arguments = [
        "run",
        "circles.toml",
        "--seed",
        "1",
        "--out",
        out,
        "--backend",
        backend,
        "--quiet",
    ];
    let mut command = place.command(&arguments);
    let output = command.env("XDG_CACHE_HOME", place.at("cache")).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    result(place, out)
}

/// Arithmetic that devices may do in different ways is found with its line, in a user's part and in what it calls.
#[test]
fn inexact_arithmetic_is_named_with_its_line() {
    let place = Place::new("inexact");
    let part = |body: &str| {
        format!(
            "struct TaskState {{
    heat: f32,
}}
fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {{
    return TaskState(1.0f);
}}
fn share(x: f32) -> f32 {{
    return reciprocal(x);
}}
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {{
{body}
}}
"
        )
    };
    place.write(
        "own.toml",
        "cycles = 200\n[task]\nkind = \"own\"\npart = \"own.wgsl\"\n",
    );
    let check = ["check", "own.toml", "--episodes", "6"];
    for (body, words) in [
        (
            "    let heat = 0.5f * before.heat;\n    return Reward(heat, TaskState(heat));",
            &["own.wgsl:11:16: 0.5f * 1.1754944e-38f is 5.877472e-39f, which is subnormal, in 6 of 6 episodes"][..],
        ),
        (
            "    let heat = before.heat *\n        (1e30f + now.start.x);\n    return Reward(0.0f, TaskState(heat));",
            &["own.wgsl:11:16: 1e30f * 1e30f is inff, which is infinite, in 6 of 6 episodes"],
        ),
        (
            "    return Reward(share(max(now.moved.left - 2.0f, 0.0f)), before);",
            &[
                "own.wgsl:8:12: reciprocal(0.0f) is out of its range",
                "in 6 of 6 episodes",
            ],
        ),
        (
            "    let step = u32(now.start.x - 1e6f);\n    return Reward(f32(step), before);",
            &["own.wgsl:11:16: u32(-999", "which is out of range"],
        ),
        (
            "    return Reward(root(now.moved.left - 2.0f), before);",
            &[
                "own.wgsl:11:19: root(-",
                "f) is out of its range, which is 0, and from 8e-31, in 6 of 6 episodes; allowed: ",
            ],
        ),
        (
            "    return Reward(1.0 / (0.0 * now.start.x) + share(1.0f), before);",
            &["own.wgsl:11:19: x / (0.0f) is out of its range, which is from 1.2e-38, of both signs, in 6"],
        ),
        (
            "    return Reward(f32(7 / i32(0.0 * now.start.x)), before);",
            &["own.wgsl:11:23: x / (0) is a division by 0, in 6 of 6"],
        ),
        (
            "    return Reward(f32(7 % i32(0.0 * now.start.x)), before);",
            &["own.wgsl:11:23: x % (0) is a division by 0, in 6 of 6"],
        ),
        (
            "    return Reward(sqrt(now.moved.left - 2.0), before);",
            &[
                "own.wgsl:11:19: sqrt(-",
                "f) is out of its range, which is 0, and from 1.2e-38, in 6 of 6",
            ],
        ),
        (
            "    return Reward(acos(now.moved.left + 2.0), before);",
            &[
                "own.wgsl:11:19: acos(",
                "f) is out of its range, which is -1 to 1, in 6 of 6",
            ],
        ),
        (
            "    return Reward(share(0.0f), before);",
            &[
                "own.wgsl:8:12: reciprocal(0.0f) is out of its range, which is from 1.2e-38 to 8e37, of both signs, in 6",
            ],
        ),
        (
            "    let x = 0.0f * now.start.x;\n    return Reward(logarithm(x) + reciprocal_root(x), before);",
            &["own.wgsl:12:19: logarithm(0.0f) is out of its range, which is from 1.2e-38, in 6"],
        ),
        (
            "    return Reward(cosine_sine(1e8f).x, before);",
            &[
                "own.wgsl:11:19: cosine_sine(100000000.0f) is out of its range, which is up to 8 million turns, of both signs, in 6",
            ],
        ),
    ] {
        place.write("own.wgsl", part(body));
        place.good(&["check", "own.toml"]);
        place.run(&check).exits(3).says(words);
    }
    place.write("own.wgsl", part("    return Reward(now.start.x, before);"));
    place.run(&check).exits(0).says(&["6 episodes: all numbers are exact"]);
    // So are those of the page's parts, of what ships, and of a described robot's surrogate.
    circles(&place);
    place.write("described.toml", "cycles = 100\n[robot]\npreset = \"epuck\"\n");
    place.write("plain.toml", "cycles = 100\n[controller]\nkind = \"hidden\"\n");
    for file in ["circles.toml", "described.toml", "plain.toml"] {
        place
            .run(&["check", file, "--episodes", "4"])
            .exits(0)
            .says(&["4 episodes: all numbers are exact"]);
    }
}

#[test]
fn the_five_minutes() {
    let place = Place::new("five-minutes");
    for line in block("sh", "oneiro new").lines() {
        let arguments: Vec<&str> = line.split_whitespace().skip(1).collect();
        place.good(&arguments);
    }
    let task = place.text("corridor-task.wgsl") + "// Changed.\n";
    assert!(task.contains("fn task_cycle"));
    place.write("corridor-task.wgsl", &task);
    // Neither file is overwritten.
    place
        .run(&["new", "corridor", "--task", "other"])
        .exits(3)
        .says(&["exists already"]);
    // One that is as it would be written stays, and an edited one is in the way.
    let edited = format!("{task}// Edited.\n");
    place.write("corridor-task.wgsl", &edited);
    place
        .run(&["new", "other", "--task", "corridor-task"])
        .exits(3)
        .says(&["exists already"]);
    assert_eq!(place.text("corridor-task.wgsl"), edited);
    assert!(!place.at("other.wgsl").exists() && !place.at("other.toml").exists());
    place
        .run(&["new", "third", "--task", "../elsewhere"])
        .exits(3)
        .says(&["--task", "allowed"]);
    place
        .run(&["new", "third", "--task", "own", "--swarm", "--forager"])
        .exits(2);
}

/// Lives that a task ends early have their fitness and measures.
#[test]
fn lives_that_end_early_are_evaluated_and_measured() {
    let place = Place::new("own-ends");
    place.good(&["new", "far", "--task", "far-away"]);
    let set = ["--set", "evolution.generations=5", "--set", "task.values.goal=100"];
    place.good(&[&["run", "far.toml", "--seed", "1", "--out", "run"][..], &set, &CPU].concat());
    let lives = ["--genomes", "run", "--trials", "20", "--seed", "3"];
    let plain = place.good(&[&["evaluate"][..], &lives, &CPU].concat());
    let traced = place.good(&[&["evaluate", "--measures", "--traces", "traces"][..], &lives, &CPU].concat());
    let lines = |text: &str| text.lines().skip(1).map(str::to_owned).collect::<Vec<_>>();
    let (plain, traced) = (lines(&plain), lines(&traced));
    assert_eq!((plain.len(), traced.len()), (20, 20));
    let mut ended = 0;
    for (trial, (plain, traced)) in plain.iter().zip(&traced).enumerate() {
        assert!(traced.starts_with(plain.as_str()), "{plain}\n{traced}");
        let cells: Vec<&str> = traced.split(',').collect();
        let distance: f64 = cells[6].parse().unwrap();
        assert!(distance > 50.0, "{traced}");
        let cycles = place.text(format!("traces/trace-0-{trial}.csv")).lines().count() - 1;
        ended += u32::from(cycles < 500);
    }
    assert!(ended > 10, "{ended} of 20 lives arrive");
}

/// What a task remembers at the end of a life is a measure, to the last bit, and so in its trace.
#[test]
fn what_a_task_remembers_is_measured() {
    let place = Place::new("own-measures");
    let task = "
struct TaskState {
    cycles: u32,
    below: i32,
    sum: f32,
    place: vec2<f32>,
}
fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    return TaskState(4000000000u, -2000000000, 0.0f, vec2<f32>(pose.x, pose.y));
}
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let sum = before.sum + 0.1f;
    let place = vec2<f32>(now.start.x, now.start.y);
    return Reward(sum, TaskState(before.cycles + 1u, before.below - 1, sum, place));
}
fn task_ends(episode: Episode, own: TaskState) -> bool {
    return own.cycles >= 4000000050u && random(episode, STREAM_TASK, own.cycles, 0u).x < 0.02f;
}
";
    place.write("counts.wgsl", task);
    place.write(
        "counts.toml",
        "cycles = 100\n[task]\nkind = \"own\"\npart = \"counts.wgsl\"\n",
    );
    place.write("genomes.csv", "2,".repeat(17) + "-1\n");
    let lives = [
        "evaluate",
        "counts.toml",
        "--genomes",
        "genomes.csv",
        "--trials",
        "30",
        "--measures",
    ];
    let table = place.good(&[&lives[..], &["--traces", "traces"], &CPU].concat());
    let split = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
    let head = split(table.lines().next().unwrap());
    let at = |head: &[String], name: &str| {
        head.iter()
            .position(|own| own == name)
            .unwrap_or_else(|| panic!("{name}"))
    };
    let mut lengths = BTreeSet::new();
    for (trial, row) in table.lines().skip(1).enumerate() {
        let row = split(row);
        let trace = place.text(format!("traces/trace-0-{trial}.csv"));
        let columns = split(trace.lines().next().unwrap());
        let lived = trace.lines().count() - 1;
        let last = split(trace.lines().last().unwrap());
        for name in ["cycles", "below", "sum", "place.x", "place.y"] {
            let measure = &row[at(&head, &format!("end_task_{name}"))];
            assert_eq!(
                *measure,
                last[at(&columns, &format!("task.{name}"))],
                "{name} in life {trial}"
            );
        }
        let sum = (0..lived).fold(0.0_f32, |sum, _| sum + 0.1);
        assert_eq!(
            row[at(&head, "end_task_cycles")],
            (4_000_000_000 + lived as u64).to_string()
        );
        assert_eq!(
            row[at(&head, "end_task_below")],
            (-2_000_000_000 - lived as i64).to_string()
        );
        assert_eq!(row[at(&head, "end_task_sum")], sum.to_string());
        assert_eq!(row[at(&head, "end_task_place.x")], last[at(&columns, "x_mm")]);
        lengths.insert(lived);
    }
    assert!(lengths.len() > 5 && lengths.contains(&100), "{lengths:?}");
    let json = place.good(&[&lives[..], &CPU, &["--json"]].concat());
    let rows: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert!(rows[0]["end_task_cycles"].as_u64() > Some(4_000_000_049), "{json}");
}

/// Every kind of part that `oneiro new` writes, together and alone.
#[test]
fn each_part_runs_as_it_is_written() {
    let place = Place::new("own-parts");
    let parts = ["--sensor", "eyes", "--controller", "brain", "--task", "goal"];
    place.good(&["new", "none"]);
    let mut tables = BTreeSet::new();
    let some = [
        ("all", &parts[..]),
        ("one", &parts[..2]),
        ("two", &parts[2..4]),
        ("none", &[]),
    ];
    for (name, parts) in some {
        for file in ["eyes.wgsl", "brain.wgsl", "goal.wgsl"] {
            let _ = fs::remove_file(place.at(file));
        }
        if !parts.is_empty() {
            place.good(&[&["new", name], parts].concat());
        }
        let experiment = format!("{name}.toml");
        place.good(&["check", &experiment]);
        let set = ["--set", "evolution.generations=3", "--set", "cycles=100", "--seed", "1"];
        place.good(&[&["run", &experiment, "--out", name][..], &set, &CPU].concat());
        #[cfg(feature = "gpu")]
        {
            let gpu = format!("{name}-gpu");
            place.good(
                &[
                    &["run", &experiment, "--out", &gpu, "--backend", "gpu:0", "--quiet"][..],
                    &set,
                ]
                .concat(),
            );
            assert_eq!(result(&place, name), result(&place, &gpu));
        }
        place.good(&["verify", "--recompute", name]);
        tables.insert(place.text(format!("{name}/generations.csv")));
    }
    assert_eq!(tables.len(), some.len(), "each part changes what evolves");
    let genes = place.good(&["check", "all/config.toml", "--json"]);
    for words in ["\"genes\": 22", "\"to_left_ahead\"", "\"paces_1\""] {
        assert!(genes.contains(words), "{genes}");
    }
    let listed = place.good(&["check", "all/config.toml"]);
    assert!(
        listed.contains("     19  biases_1\n     20  paces_0, 0.02 to 1\n"),
        "{listed}"
    );
    // Genes start in their range, and stay there.
    let champion: serde_json::Value = serde_json::from_str(&place.text("all/champion.json")).unwrap();
    let genome = champion["genome"].as_array().unwrap();
    assert_eq!(champion["gene_names"][20], "paces_0");
    assert!(
        genome[20..]
            .iter()
            .all(|gene| (0.02..=1.0).contains(&gene.as_f64().unwrap())),
        "{champion}"
    );
    let genes = place.good(&["check", "one/config.toml"]);
    assert!(genes.contains("ahead_to_left"), "{genes}");
    let range =
        "sensor.values.range = 300 mm: greatest distance that it measures (default: 300; allowed: 1 to 2000 mm)\n";
    assert!(genes.contains(range), "{genes}");
    place.good(&[&["new", "again", "--all-keys"], &parts[..]].concat());
    let new = place.text("again.toml");
    let goal = "# goal = 250.0 # 10 to 10000 mm: distance from the start at which the episode is over\n";
    assert!(new.contains("\n[task.values]\n") && new.contains(goal), "{new}");
    // A value's line can be taken as it stands.
    place.write("set.toml", new.replace(goal, &goal[2..]).replace("250.0", "40.0"));
    let set: serde_json::Value = serde_json::from_str(&place.good(&["check", "set.toml", "--json"])).unwrap();
    let goal = &set["part_values"].as_array().unwrap()[2];
    assert_eq!(
        (goal["key"].as_str(), goal["value"].as_f64()),
        (Some("task.values.goal"), Some(40.0))
    );
    assert_eq!(
        (goal["allowed"].as_str(), goal["default"].as_f64()),
        (Some("10 to 10000"), Some(250.0))
    );
    let champion = place.text("one/champion.json");
    assert!(champion.contains("ahead_to_right"), "{champion}");
    place
        .run(&["new", "four", "--sensor", "same", "--task", "same"])
        .exits(3)
        .says(&["same.wgsl is named twice"]);
}

/// The experiments that ship are in the program: each is written with its parts, and is what the repository has.
/// The page's forager, and what `oneiro new --forager` writes: everything that other experiments can do.
#[test]
fn a_forager_takes_parts() {
    let place = Place::new("own-forager");
    place.write("bring.wgsl", block("wgsl", "is_new_way"));
    place.write("bring.toml", block("toml", "\"forager\""));
    let new = ["new", "forage", "--forager", "--controller", "brain", "--task", "goal"];
    place.good(&new);
    place.good(&["new", "study", "--forager"]);
    let set = [
        "--set",
        "evolution.generations=3",
        "--set",
        "evolution.finalists=5",
        "--seed",
        "1",
    ];
    for (name, genes) in [("bring", 2), ("forage", 30), ("study", 2)] {
        let experiment = format!("{name}.toml");
        let checked = place.good(&["check", &experiment]);
        assert!(checked.contains(&format!("; {genes} genes\n")), "{checked}");
        place.good(&[&["run", &experiment, "--out", name][..], &set, &CPU].concat());
        #[cfg(feature = "gpu")]
        {
            let gpu = format!("{name}-gpu");
            let arguments = ["run", &experiment, "--out", &gpu, "--backend", "gpu:0", "--quiet"];
            place.good(&[&arguments[..], &set].concat());
            assert_eq!(result(&place, name), result(&place, &gpu));
        }
        // Its copies of the files are enough.
        let again = format!("{name}-again");
        let config = format!("{name}/config.toml");
        place.good(&[&["run", &config, "--out", &again][..], &CPU].concat());
        assert_eq!(result(&place, name), result(&place, &again));
        place.good(&["verify", "--recompute", name]);
        place.good(&["replay", name]);
        let head = place.text(format!("{name}/trace.csv"));
        assert!(
            head.starts_with("cycle,x_mm,y_mm,heading_turns,sensor_near_left_17,"),
            "{head}"
        );
    }
    for (name, columns) in [
        (
            "bring",
            &["sensor_carries", "real_carries", "task.carries", "task.way"][..],
        ),
        ("forage", &["task.brought", "controller.sums.x"]),
    ] {
        let trace = place.text(format!("{name}/trace.csv"));
        let names: Vec<&str> = trace.lines().next().unwrap().split(',').collect();
        assert!(columns.iter().all(|column| names.contains(column)), "{names:?}");
    }
    let measured = place.good(&["evaluate", "--genomes", "forage", "--measures", "--backend", "cpu"]);
    assert!(
        measured.contains(",end_task_brought,end_task_carries,end_task_way\n"),
        "{measured}"
    );
    place.write(
        "sweep.toml",
        "experiment = \"forage.toml\"\nseeds = \"1..2\"\n[set]\nevolution.generations = 2\n\
         [grid]\ntask.values.way = [0.0, 0.1]\narena.light = [\"over_nest\", \"nowhere\"]\n",
    );
    place.good(&[&["sweep", "run", "sweep.toml", "--out", "all", "--yes"], &CPU[..]].concat());
    let table = place.text("all/results.csv");
    assert_eq!(table.lines().count(), 9, "{table}");
    for (set, problem) in [
        (
            "arena.preset=\"open\"",
            "arena: has a preset, sides or objects; allowed: none of them, a forager's arena is round",
        ),
        ("noise.motor=0.1", "noise: is not zero for a forager"),
        ("robot.collision=\"slide\"", "robot.collision: is given; allowed: none"),
        ("arena.nest_radius_mm=601", "arena.nest_radius_mm: is 601"),
        (
            "reality.robot=\"surrogate:1\"",
            "is `forager` in a surrogate's episode; allowed: another kind",
        ),
        (
            "reality.robot=\"serial:/dev/ttyUSB0\"",
            "reality.robot: can't run this experiment: robot.kind is `forager`",
        ),
        ("robot.kind=\"sampled\"", "only with"),
    ] {
        place
            .run(&["check", "bring.toml", "--set", set])
            .exits(3)
            .says(&[problem]);
    }
    place.write("khepera.toml", "task.kind = \"foraging\"");
    place
        .run(&["check", "khepera.toml"])
        .exits(3)
        .says(&["task.kind: is `foraging`; allowed: only with robot.kind = \"forager\""]);
    place.write("light.toml", "arena.light = \"nowhere\"");
    place
        .run(&["check", "light.toml"])
        .exits(3)
        .says(&["arena.light: is given; allowed: only with robot.kind = \"forager\""]);
    let goal = place.text("bring.wgsl");
    place.write(
        "bring.wgsl",
        goal.replace("now.to_food, now.to_nest", "nest_of(0u).x, now.to_nest"),
    );
    place.run(&["check", "bring.toml"]).exits(3).says(&[
        "bring.wgsl:8:22: `nest_of` can't be called from here",
        "[allowed-calls]",
    ]);
}

#[test]
fn examples_are_written_with_their_parts() {
    let place = Place::new("examples");
    let listed = place.good(&["new", "--example"]);
    let names: Vec<&str> = listed
        .lines()
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    let shipped = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments");
    // All that ship.
    let mut all = Vec::new();
    for folder in ["", "sweeps/"] {
        for entry in fs::read_dir(shipped.join(folder)).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            if let Some(name) = name.strip_suffix(".toml").filter(|name| *name != "Cargo") {
                all.push(format!("{folder}{name}"));
            }
        }
    }
    all.sort();
    let mut sorted = names.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, all);
    assert_eq!(names[0], "khepera-avoidance");
    for name in &names {
        // In a folder without others' files.
        place.good(&["new", "--example", name, "--out", "all"]);
        let experiment = format!("{name}.toml");
        let written = format!("all/{experiment}");
        assert_eq!(place.read(&written), fs::read(shipped.join(&experiment)).unwrap());
        if name.starts_with("sweeps/") {
            // What they name is a shipped experiment with its files, checked below or above.
            let text = place.text(&written);
            let named: Vec<&str> = text.split('"').filter(|word| word.starts_with("../")).collect();
            assert!(!named.is_empty(), "{name}");
            for named in named {
                assert!(place.at(format!("all/sweeps/{named}")).exists(), "{name}: {named}");
            }
        } else {
            place.good(&["check", &written]);
        }
        fs::remove_dir_all(place.at("all")).unwrap();
    }
    place
        .run(&["new", "--example", "sweeps/small", "--out", "swept"])
        .exits(0)
        .says(&["next: oneiro sweep plan swept/sweeps/small.toml, then oneiro sweep run swept/sweeps/small.toml"]);
    place.good(&["sweep", "plan", "swept/sweeps/small.toml"]);
    place.good(&["new", "--example", "homing"]);
    // Files that are as they would be written stay, of all or of some: experiments share parts.
    place
        .run(&["new", "--example", "homing"])
        .exits(0)
        .says(&["homing.toml is already there, unchanged; next: oneiro check homing.toml"]);
    place.write("homing.toml", "# another's");
    place
        .run(&["new", "--example", "homing"])
        .exits(3)
        .says(&["homing.toml: exists already", "write into another folder: --out DIR"]);
    assert_eq!(place.text("homing.toml"), "# another's");
    fs::remove_file(place.at("homing.toml")).unwrap();
    place.good(&["new", "--example", "homing"]);
    // All or none.
    fs::remove_file(place.at("homing.toml")).unwrap();
    place.write("homing/sensors.wgsl", "// another's");
    place
        .run(&["new", "--example", "homing"])
        .exits(3)
        .says(&["homing/sensors.wgsl: exists already"]);
    assert!(!place.at("homing.toml").exists());
    let all = format!("--example moon: is unknown; allowed: {}", names.join(", "));
    place.run(&["new", "--example", "moon"]).exits(3).says(&[&all]);
    place
        .run(&["new", "--example", "agregation"])
        .exits(3)
        .says(&["is unknown; did you mean aggregation? (allowed: khepera-avoidance, "]);
    place.run(&["new", "mine", "--example", "homing"]).exits(2);
    // Another folder is made.
    place.good(&["new", "--example", "homing", "--out", "other"]);
    assert!(place.at("other/homing/task.wgsl").exists());
    place.good(&["check", "other/homing.toml"]);
    place.run(&["new"]).exits(2);
}

/// A gene with a range of its own starts in it, also from a file.
#[test]
fn first_genes_out_of_their_own_range_are_refused() {
    let place = Place::new("init-range");
    // One unit with 8 readings, itself, a bias and a time constant; two outputs with a weight and a bias each.
    let genome = |time_constant: f32| {
        let mut genes = vec!["1.0".to_owned(); 15];
        genes[10] = time_constant.to_string();
        genes.join(",") + "\n"
    };
    place.write(
        "net.toml",
        "[controller]\nkind = \"network\"\nlayers = [{ kind = \"ctrnn\", units = 1 }]\n\
         [evolution]\npopulation = 2\nparents = 1\ninit = \"init.csv\"\n",
    );
    place.write("init.csv", genome(0.0) + &genome(1.0));
    place.good(&["check", "net.toml"]);
    place.write("init.csv", genome(0.5) + &genome(1.5));
    place.run(&["check", "net.toml"]).exits(3).says(&[
        "net.toml:7",
        "evolution.init",
        "time_constant_layer_0_unit_0 of genome 1 is 1.5; allowed: 0 to 1",
    ]);
}

#[test]
fn a_task_runs_on_all_devices_with_the_same_bits() {
    let place = Place::new("own-task");
    circles(&place);
    let own = run(&place, "cpu", "cpu");
    #[cfg(feature = "gpu")]
    assert_eq!(own, run(&place, "gpu", "gpu:0"));
    // The run has all that it needs.
    fs::remove_file(place.at("circles.wgsl")).unwrap();
    fs::remove_file(place.at("circles.toml")).unwrap();
    let config = place.text("cpu/config.toml");
    assert!(config.contains("part = \"inputs/circles.wgsl\""), "{config}");
    assert!(
        config.contains("radius = 200.0\nwidth = 30.0"),
        "every value is written out: {config}"
    );
    place.good(&["verify", "--recompute", "cpu"]);
    place.good(&["replay", "cpu"]);
    place.good(&[
        "run",
        "cpu/config.toml",
        "--out",
        "again",
        "--backend",
        "cpu",
        "--quiet",
    ]);
    assert_eq!(own, result(&place, "again"));
    place.good(&[
        "evaluate",
        "cpu/config.toml",
        "--genomes",
        "cpu",
        "--backend",
        "cpu",
        "--quiet",
    ]);
    // A task that has changed is another experiment.
    let text = place.text("cpu/inputs/circles.wgsl").replace("near * speed", "near");
    place.write("cpu/inputs/circles.wgsl", text);
    place
        .run(&["verify", "--recompute", "cpu"])
        .exits(3)
        .says(&["task.part", "has changed"]);
}

#[test]
fn values_of_a_task_are_swept() {
    let place = Place::new("own-values");
    circles(&place);
    place.write("sweep.toml", block("toml", "task.values.radius"));
    place.good(&[&["sweep", "run", "sweep.toml", "--out", "all", "--yes"], &CPU[..]].concat());
    let table = place.text("all/results.csv");
    assert_eq!(table.lines().count(), 7, "{table}");
    let head = table.lines().next().unwrap();
    assert!(head.contains("task.values.radius"), "{head}");
    // A run of the sweep is that of the program.
    let of = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
    let (names, cells) = (of(head), of(table.lines().nth(4).unwrap()));
    let cell = |name: &str| cells[names.iter().position(|own| own == name).unwrap()].clone();
    let radius = format!("task.values.radius={}", cell("task.values.radius"));
    place.good(&[
        "run",
        "circles.toml",
        "--seed",
        &cell("seed"),
        "--set",
        &radius,
        "--set",
        "evolution.generations=3",
        "--out",
        "one",
        "--backend",
        "cpu",
        "--quiet",
    ]);
    assert!(table.contains(&result(&place, "one")), "{table}");
}

#[test]
fn mistakes_name_the_file_and_the_place() {
    let place = Place::new("own-mistakes");
    circles(&place);
    let task = place.text("circles.wgsl");
    for (set, words) in [
        (
            "task.values.radus=3",
            &["task.values.radus", "isn't a value of", "radius, width"][..],
        ),
        (
            "task.values.radius=3",
            &["task.values.radius: is 3; allowed: 50 to 1000"],
        ),
        (
            "task.values.radius=\"far\"",
            &["task.values.radius: is \"far\"; allowed: numbers"],
        ),
        ("task.speed=signed", &["task.speed", "only with kind = \"avoidance\""]),
        ("task.part=none.wgsl", &["task.part", "none.wgsl"]),
        (
            "sensor.values.range=3",
            &["sensor.values", "allowed: only with sensor.part"],
        ),
        ("task.part=circles.toml", &["has no function `task_cycle`"]),
    ] {
        place.run(&["check", "circles.toml", "--set", set]).exits(3).says(words);
    }
    place.write("bare.toml", "[task]\nkind = \"own\"\n");
    place
        .run(&["check", "bare.toml"])
        .exits(3)
        .says(&["bare.toml:1:1: task: lacks `part`; allowed: the file of the task, .wgsl"]);
    place.write("circles.wgsl", task.replacen("abs(", "quantizeToF16(", 1));
    for command in ["check", "run"] {
        let ran = place.run(&[command, "circles.toml"]).exits(3);
        ran.says(&[
            "circles.wgsl:17:15: `quantizeToF16` is not on the list",
            "write its argument, since floats have 32 bits [exact-functions]\n",
        ]);
    }
    place.write("circles.wgsl", "struct TaskState { a: f32 }\n".repeat(2));
    place.run(&["check", "circles.toml"]).exits(3).says(&["circles.wgsl"]);
}

/// The files of a short evolution of the task that `oneiro new` writes.
fn corridor(place: &Place) {
    place.good(&["new", "corridor", "--task", "corridor-task"]);
    let mut text = place.text("corridor.toml");
    for (long, short) in [
        ("\ngenerations = 200", "\ngenerations = 2"),
        ("\npopulation = 100", "\npopulation = 20"),
        ("\nparents = 20", "\nparents = 4"),
        ("\ncycles = 500", "\ncycles = 40"),
    ] {
        assert!(text.contains(long), "{long}");
        text = text.replace(long, short);
    }
    place.write("corridor.toml", text);
}

#[test]
fn what_comes_after_a_run_is_as_the_page_says() {
    let place = Place::new("afterwards");
    corridor(&place);
    let sweep = "experiment = \"corridor.toml\"\nseeds = \"1..2\"\n[grid]\nevolution.mutation.rate = [0.1, 0.2]\n";
    place.write("sweep.toml", sweep);
    let mut printed = Vec::new();
    for line in block("sh", "oneiro sweep report").lines() {
        let line = line.split('#').next().unwrap();
        let arguments: Vec<&str> = line.split_whitespace().skip(1).collect();
        printed.push((line.trim().to_owned(), place.good(&arguments)));
    }
    let of = |words: &str| {
        let found = printed.iter().find(|(line, _)| line.contains(words));
        found.unwrap_or_else(|| panic!("{words}")).1.lines().collect::<Vec<_>>()
    };
    assert_eq!(of("--genomes corridor").len(), 1 + 5);
    let random = of("--random 200");
    assert_eq!(random.len(), 1 + 200);
    assert_eq!(random[0], "genome,episodes,mean,deviation,low,high");
    // Cells are compared by what no selection has seen, and two runs are too few to differ.
    let page = place.text("sweep/report.html");
    for words in [
        "<dd>mean fitness of the champion's new episodes; more is better</dd>",
        "<dd>2; two cells of so few can't differ with p below 0.333: take more seeds</dd>",
    ] {
        assert!(page.contains(words), "{page}");
    }
}

/// Random genomes are those of the first generation of a run with the same seed.
#[test]
fn random_genomes_are_evaluated_and_summed_up() {
    let place = Place::new("random-genomes");
    corridor(&place);
    let evaluate = |more: &[&str]| {
        let fixed = [
            "evaluate",
            "corridor.toml",
            "--random",
            "20",
            "--seed",
            "3",
            "--trials",
            "1",
            "--quiet",
        ];
        place.good(&[&fixed[..], more].concat())
    };
    let rows = evaluate(&[]);
    let best = rows
        .lines()
        .skip(1)
        .map(|row| row.split(',').nth(2).unwrap().parse::<f32>().unwrap());
    let best = best.fold(f32::MIN, f32::max);
    place.good(&[&["run", "corridor.toml", "--seed", "3", "--out", "run"], &CPU[..]].concat());
    let first = place.text("run/generations.csv").lines().nth(1).unwrap().to_owned();
    assert_eq!(
        first.split(',').nth(1).unwrap().parse::<f32>().unwrap(),
        best,
        "{first}"
    );
    place
        .run(&[
            "evaluate",
            "corridor.toml",
            "--random",
            "3",
            "--trials",
            "1",
            "--summary",
        ])
        .exits(2)
        .says(&["--summary: one episode of each genome has no interval; allowed: with --trials 2 or more"]);
    place.run(&["evaluate", "corridor.toml"]).exits(2).says(&["--genomes"]);
    let noted = place
        .run(&["evaluate", "corridor.toml", "--random", "2", "--trials", "2"])
        .exits(0);
    noted.says(&["each genome has different starts and random numbers; --common-starts gives all the same"]);
}

/// An optimiser that uses behaviour counts individuals that have none, in its run, in its list and in a sweep's table.
#[test]
fn measures_that_are_not_a_number_are_counted() {
    let place = Place::new("nan-measures");
    let task = "struct TaskState { mark: f32, }
fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState { return TaskState(0.0f); }
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let infinite = reciprocal(0.0f * now.end.x);
    return Reward(1.0f, TaskState(MARK));
}
";
    let experiment = |part: &str| {
        format!(
            "cycles = 10\ntrials = 2\n[task]\nkind = \"own\"\npart = \"{part}\"\n[evolution]\npopulation = 12\nparents = 3\n\
             generations = 3\nfinalists = 2\nfinalist_lives = 2\ndescriptors = [{{ measure = \"end_task_mark\", least = 0.0, greatest = 1.0 }}]\n"
        )
    };
    for (name, mark) in [("nan", "0.0f * infinite"), ("number", "0.5f")] {
        place.write(format!("{name}.wgsl"), task.replace("MARK", mark));
        place.write(format!("{name}.toml"), experiment(&format!("{name}.wgsl")));
    }
    for kind in ["map-elites", "novelty"] {
        for (name, expected) in [("nan", 36), ("number", 0)] {
            let (file, out, set) = (
                format!("{name}.toml"),
                format!("{name}-{kind}"),
                format!("evolution.kind=\"{kind}\""),
            );
            let run = [
                "run",
                &file,
                "--set",
                &set,
                "--seed",
                "1",
                "--out",
                &out,
                "--backend",
                "cpu",
            ];
            let said = place.run(&run).exits(0).stderr;
            let warning = format!("warning: {out}: 36 individuals have a measure that is NaN: no behaviour");
            assert_eq!(said.contains(&warning), expected > 0, "{said}");
            let rows = (0..3).map(|generation| format!("{generation},{}\n", expected / 3));
            assert_eq!(
                place.text(format!("{out}/behaviour.csv")),
                "generation,nan\n".to_owned() + &rows.collect::<String>()
            );
            if kind == "map-elites" {
                // The sum over no elites has no sign.
                let last = if expected > 0 { "2,0,0,0,NaN" } else { "2,1,0.05," };
                let coverage = place.text(format!("{out}/coverage.csv"));
                assert!(coverage.lines().last().unwrap().starts_with(last), "{coverage}");
            }
            let sweep = format!("{out}-sweep");
            place.write(
                format!("{sweep}.toml"),
                format!(
                    "experiment = \"{file}\"\nseeds = [1]\n[set]\n{}\n",
                    set.replace('=', " = ")
                ),
            );
            let run = [
                "sweep",
                "run",
                &format!("{sweep}.toml"),
                "--out",
                &sweep,
                "--yes",
                "--backend",
                "cpu",
                "--quiet",
            ];
            place.good(&run);
            let table = place.text(format!("{sweep}/results.csv"));
            let mut lines = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
            let (head, row) = (lines.next().unwrap(), lines.next().unwrap());
            let column = head.iter().position(|name| *name == "nan_measures").unwrap();
            assert_eq!(row[column], expected.to_string(), "{sweep}");
        }
    }
}

#[test]
fn parts_are_shown_and_what_hardly_is_meant_is_told() {
    let place = Place::new("shown-parts");
    corridor(&place);
    let checked = place.good(&["check", "corridor.toml"]);
    let line = "  task        corridor-task.wgsl: task_cycle, task_begin, task_ends, task_score; remembers start.x, start.y, farthest, arrived\n";
    assert!(checked.contains(line), "{checked}");
    // A refusal has the place in the part alone.
    let task = place.text("corridor-task.wgsl");
    place.write("corridor-task.wgsl", task.replace("fn task_ends", "fn task_end"));
    let refused = place.run(&["check", "corridor.toml"]).exits(3);
    assert!(
        refused.stderr.starts_with("oneiro: corridor-task.wgsl:"),
        "{}",
        refused.stderr
    );
    // A life that ends at once, and one whose fitness is not a number.
    for (from, to, words) in [
        (
            "own.arrived != 0u",
            "true",
            "warning: run: the champion's episode ended before its first cycle: its task ended it at once",
        ),
        (
            "return Reward(",
            "return Reward(reciprocal(0.0f * pose_of(now)) + ",
            "no mean of 100 new episodes: the fitness of some is not a number (NaN)",
        ),
    ] {
        let helper = "fn pose_of(now: Experience) -> f32 { return now.end.x; }\n";
        place.write("corridor-task.wgsl", helper.to_owned() + &task.replace(from, to));
        let ran = place
            .run(&[
                "run",
                "corridor.toml",
                "--seed",
                "1",
                "--out",
                "run",
                "--backend",
                "cpu",
            ])
            .exits(0);
        assert!(
            format!("{}{}", ran.stdout, ran.stderr).contains(words),
            "{}{}",
            ran.stdout,
            ran.stderr
        );
        fs::remove_dir_all(place.at("run")).unwrap();
    }
}

/// What only the file's kind has is left out if a setting has another; what a setting says beside it is refused.
#[test]
fn a_kind_that_is_set_replaces_the_files() {
    let place = Place::new("replaced-kind");
    place.write("hidden.toml", "[controller]\nkind = \"hidden\"\nunits = 4\n");
    let recurrent = ["check", "hidden.toml", "--set", "controller.kind=recurrent"];
    assert!(place.good(&recurrent).contains("recurrent; "));
    let refused = [&recurrent[..], &["--set", "controller.units=3"]].concat();
    place
        .run(&refused)
        .exits(3)
        .says(&["controller.units: is given; allowed: only with kind = \"hidden\""]);
    place.write("hidden.toml", "[controller]\nkind = \"recurrent\"\nunits = 4\n");
    place
        .run(&["check", "hidden.toml"])
        .exits(3)
        .says(&["hidden.toml:3:9: controller.units: is given"]);
}

#[test]
fn the_problems_of_all_parts_are_shown_at_once() {
    let place = Place::new("own-problems");
    place.good(&[
        "new",
        "all",
        "--sensor",
        "eyes",
        "--controller",
        "brain",
        "--task",
        "goal",
    ]);
    let change = |file: &str, from: &str, to: &str| {
        let text = place.text(file);
        assert!(text.contains(from), "{text}");
        place.write(file, text.replacen(from, to, 1));
    };
    // What each file declares.
    change("eyes.wgsl", "ahead: f32", "ahead: u32");
    change("brain.wgsl", "sums: vec2<f32>", "sums: bool");
    change("goal.wgsl", "// 250, 10 to", "// 10 to");
    let refused = place.run(&["check", "all.toml"]).exits(3);
    let refused = refused.says(&["eyes.wgsl:", "[reading-form]", "brain.wgsl:", "[state-types]"]);
    assert_eq!(refused.says(&["goal.wgsl:", "[value-form]"]).stderr.lines().count(), 3);
    // What shows when they are compiled together.
    change("eyes.wgsl", "ahead: u32", "ahead: f32");
    change("brain.wgsl", "sums: bool", "sums: vec2<f32>");
    change("goal.wgsl", "// 10 to", "// 250, 10 to");
    place.good(&["check", "all.toml"]);
    change("eyes.wgsl", "/ own.range", "* 1e-40");
    change(
        "brain.wgsl",
        "let left = ",
        "for (var i = 0u; i < step; i = i) {} let left = ",
    );
    change("goal.wgsl", "{\n    let", "{\n    let unused = cos(0.5);\n    let");
    let refused = place.run(&["check", "all.toml"]).exits(3);
    let refused = refused.says(&[
        "eyes.wgsl:",
        "[finite-constants]",
        "brain.wgsl:",
        "[loop-without-bound]",
    ]);
    assert_eq!(
        refused
            .says(&["goal.wgsl:", "[exact-functions]"])
            .stderr
            .lines()
            .count(),
        3
    );
}

#[test]
fn rules_are_explained() {
    let place = Place::new("rules");
    let one = place.good(&["check", "--explain", "exact-functions"]);
    for words in [
        "exact-functions: No `pack4x8unorm`",
        "each device computes",
        "\n\nWrong:\n\n    const QUARTER",
        "= sin(0.25);",
        "\nRight:\n",
    ] {
        assert!(one.contains(words), "no `{words}` in\n{one}");
    }
    assert!(one.lines().all(|line| line.chars().count() <= 100), "{one}");
    assert_eq!(
        one,
        place.good(&["check", "--explain", "[exact-functions]"]),
        "as a refusal shows it"
    );
    let list = place.good(&["check", "--explain"]);
    assert_eq!(list, place.good(&["check", "--explain", "list"]));
    let names: Vec<&str> = list
        .lines()
        .skip(1)
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    for name in &names {
        assert!(
            place
                .good(&["check", "--explain", name])
                .starts_with(&format!("{name}: "))
        );
    }
    assert!(names.len() > 25 && names.contains(&"loop-without-bound"), "{list}");
    let document: serde_json::Value =
        serde_json::from_str(&place.good(&["check", "--explain", "exact-functions", "--json"])).unwrap();
    assert_eq!(document["rule"], "exact-functions");
    assert!(document["wrong"].as_str().unwrap().contains("sin(0.25)") && document["why"].is_string());
    let all: serde_json::Value = serde_json::from_str(&place.good(&["--json", "check", "--explain"])).unwrap();
    let known: Vec<_> = all
        .as_array()
        .unwrap()
        .iter()
        .map(|rule| rule["rule"].as_str().unwrap())
        .collect();
    assert_eq!(known, names);
    // An unknown name is answered with all, the nearest first.
    let unknown = place.run(&["check", "--explain", "exact-function"]).exits(3);
    let unknown =
        unknown.says(&["--explain: there is no rule `exact-function`; did you mean exact-functions? (allowed: "]);
    // Whatever is asked, the rules are in one order.
    let order = |ran: &str| {
        ran[ran.find("allowed: ").unwrap()..]
            .trim_end()
            .trim_end_matches(')')
            .to_owned()
    };
    let other = place.run(&["check", "--explain", "zzz"]).exits(3);
    assert_eq!(order(&other.stderr), order(&unknown.stderr));
    assert!(!other.stderr.contains("did you mean"), "{}", other.stderr);
    unknown.says(&names);
    place.run(&["check"]).exits(2);
    place
        .run(&["check", "some.toml", "--explain", "exact-functions"])
        .exits(2);
}

/// Machine code is kept in the user's cache, and made again where that is damaged.
#[test]
fn machine_code_is_cached() {
    let place = Place::new("own-cache");
    circles(&place);
    // Of the one code that every processor has; with AVX-512 there are several, by the number of episodes.
    let backend = "cpu:native128x16";
    let entries = || {
        let folder = fs::read_dir(place.at("cache/oneiro/kernels")).unwrap();
        folder.map(|entry| entry.unwrap().path()).collect::<Vec<_>>()
    };
    let first = run(&place, "first", backend);
    let [entry] = &entries()[..] else {
        panic!("one kernel is kept: {:?}", entries());
    };
    let code = fs::read(entry).unwrap();
    let written = || fs::metadata(entry).unwrap().modified().unwrap();
    let before = written();
    assert_eq!(first, run(&place, "again", backend));
    assert_eq!(before, written(), "the kernel is not compiled again");
    let mut damaged = code.clone();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    fs::write(entry, &damaged).unwrap();
    assert_eq!(first, run(&place, "repaired", backend));
    assert_eq!(code, fs::read(entry).unwrap());
}
