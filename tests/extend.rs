//! A stranger's task, with the program alone: every step of docs/extend.md, in a directory of its own.

use std::collections::BTreeSet;
use std::fs;

mod place;
use place::Place;

const CPU: [&str; 3] = ["--backend", "cpu", "--quiet"];

/// The first block of a page in a language that contains some words.
fn block(language: &str, words: &str) -> String {
    let page = include_str!("../docs/extend.md");
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

#[test]
fn the_five_minutes() {
    let place = Place::new("five-minutes");
    for line in block("sh", "oneiro new").lines() {
        let arguments: Vec<&str> = line.split_whitespace().skip(1).collect();
        place.good(&arguments);
    }
    let task = place.text("corridor-task.wgsl");
    assert!(task.contains("fn task_cycle"));
    // Neither file is overwritten.
    place
        .run(&["new", "corridor", "--task", "other"])
        .exits(3)
        .says(&["exists already"]);
    place
        .run(&["new", "other", "--task", "corridor-task"])
        .exits(3)
        .says(&["exists already"]);
    assert_eq!(place.text("corridor-task.wgsl"), task);
    assert!(!place.at("other.wgsl").exists() && !place.at("other.toml").exists());
    place
        .run(&["new", "third", "--task", "../elsewhere"])
        .exits(3)
        .says(&["--task", "allowed"]);
    place.run(&["new", "third", "--task", "own", "--swarm"]).exits(2);
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
        place.good(&["audit", name]);
        tables.insert(place.text(format!("{name}/generations.csv")));
    }
    assert_eq!(tables.len(), some.len(), "each part changes what evolves");
    let genes = place.good(&["check", "all/config.toml", "--json"]);
    assert!(genes.contains("\"genes\": 22") && genes.contains("gene_21"), "{genes}");
    let genes = place.good(&["check", "one/config.toml"]);
    assert!(genes.contains("ahead_to_left"), "{genes}");
    let range =
        "sensor.values.range = 300 mm: greatest distance that it measures (default: 300; allowed: 1 to 2000 mm)\n";
    assert!(genes.contains(range), "{genes}");
    let new = place.text("all.toml");
    let goal = "# goal = 250.0 # 10 to 10000 mm: distance from the start at which the life is over\n";
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
#[test]
fn examples_are_written_with_their_parts() {
    let place = Place::new("examples");
    let listed = place.good(&["new", "--example"]);
    let names: Vec<&str> = listed
        .lines()
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert_eq!(names, ["homing", "road-sign", "kheperax", "phototaxis"]);
    let shipped = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments");
    for name in names {
        place.good(&["new", "--example", name]);
        let experiment = format!("{name}.toml");
        assert_eq!(place.read(&experiment), fs::read(shipped.join(&experiment)).unwrap());
        place.good(&["check", &experiment]);
    }
    place
        .run(&["new", "--example", "homing"])
        .exits(3)
        .says(&["homing.toml: exists already"]);
    // All or none.
    fs::remove_file(place.at("homing.toml")).unwrap();
    place
        .run(&["new", "--example", "homing"])
        .exits(3)
        .says(&["homing/sensors.wgsl: exists already"]);
    assert!(!place.at("homing.toml").exists());
    place
        .run(&["new", "--example", "moon"])
        .exits(3)
        .says(&["--example moon: is unknown; allowed: homing, road-sign, kheperax, phototaxis"]);
    place.run(&["new", "mine", "--example", "homing"]).exits(2);
    place.run(&["new"]).exits(2);
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
    place.good(&["audit", "cpu"]);
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
        .run(&["audit", "cpu"])
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
        ("sensor.values.range=3", &["sensor.values", "only with `sensor.part`"]),
        ("task.part=circles.toml", &["has no function `task_cycle`"]),
    ] {
        place.run(&["check", "circles.toml", "--set", set]).exits(3).says(words);
    }
    place.write("bare.toml", "[task]\nkind = \"own\"\n");
    place
        .run(&["check", "bare.toml"])
        .exits(3)
        .says(&["bare.toml:1:1: task: lacks `part`; allowed: the file of the task, .wgsl"]);
    place.write("circles.wgsl", task.replace("root(", "sqrt("));
    for command in ["check", "run"] {
        let ran = place.run(&[command, "circles.toml"]).exits(3);
        ran.says(&["circles.wgsl:18:19: `sqrt` is not on the list", "write `root(x)`"]);
    }
    place.write("circles.wgsl", "struct TaskState { a: f32 }\n".repeat(2));
    place.run(&["check", "circles.toml"]).exits(3).says(&["circles.wgsl"]);
}

/// Machine code is kept in the user's cache, and made again where that is damaged.
#[test]
fn machine_code_is_cached() {
    let place = Place::new("own-cache");
    circles(&place);
    let entries = || {
        let folder = fs::read_dir(place.at("cache/oneiro/kernels")).unwrap();
        folder.map(|entry| entry.unwrap().path()).collect::<Vec<_>>()
    };
    let first = run(&place, "first", "cpu");
    let [entry] = &entries()[..] else {
        panic!("one kernel is kept: {:?}", entries());
    };
    let code = fs::read(entry).unwrap();
    let written = || fs::metadata(entry).unwrap().modified().unwrap();
    let before = written();
    assert_eq!(first, run(&place, "again", "cpu"));
    assert_eq!(before, written(), "the kernel is not compiled again");
    let mut damaged = code.clone();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    fs::write(entry, &damaged).unwrap();
    assert_eq!(first, run(&place, "repaired", "cpu"));
    assert_eq!(code, fs::read(entry).unwrap());
}
