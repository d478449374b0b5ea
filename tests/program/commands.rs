//! The program from outside: what it prints, writes and refuses, and its exit codes.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::contents;
use crate::fixtures::copy;
use crate::place;
use crate::place::Place;

impl Place {
    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.at(".")).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    /// What a command that must succeed prints.
    pub(crate) fn answer(&self, arguments: &[&str]) -> Value {
        serde_json::from_str(&self.good(arguments)).unwrap()
    }

    /// Writes an experiment that takes no time.
    fn small_experiment(&self) {
        self.write("small.toml", SMALL);
    }

    /// Makes a finished run of it in `run/`.
    fn small_run(&self) {
        self.small_experiment();
        self.evolved("small.toml", "7", "run", &[]);
    }
}

const SMALL: &str = "cycles = 60
trials = 2
noise.sensor = [0.0, 0.4]

[evolution]
population = 20
parents = 4
generations = 5
";

fn npy(values: &[f32], shape: &[u64]) -> Vec<u8> {
    use npyz::WriterBuilder;
    let mut bytes = Vec::new();
    let options = npyz::WriteOptions::new()
        .default_dtype()
        .shape(shape)
        .writer(&mut bytes);
    let mut writer = options.begin_nd().unwrap();
    writer.extend(values.iter().copied()).unwrap();
    writer.finish().unwrap();
    bytes
}

/// Three genomes of 18 genes.
fn three_genomes() -> Vec<f32> {
    (0_u8..54).map(|i| f32::from(i) * 0.07 - 1.5).collect()
}

fn csv(values: &[f32], columns: usize) -> String {
    let row = |row: &[f32]| row.iter().map(f32::to_string).collect::<Vec<_>>().join(",") + "\n";
    values.chunks(columns).map(row).collect()
}

#[test]
fn help_is_quick() {
    let place = Place::new("help");
    // Other tests use the processors meanwhile.
    let mut least = Duration::MAX;
    for _ in 0..400 {
        if least < Duration::from_millis(20) {
            break;
        }
        let start = Instant::now();
        let text = place.good(&["--help"]);
        least = least.min(start.elapsed());
        for command in [
            "new", "check", "run", "resume", "evaluate", "replay", "verify", "list", "device", "robot",
        ] {
            assert!(text.contains(command), "{text}");
        }
    }
    assert!(least < Duration::from_millis(20), "{least:?}");
}

#[test]
fn a_command_line_that_makes_no_sense_exits_with_2() {
    let place = Place::new("usage");
    place.small_experiment();
    for arguments in [
        &["fly"][..],
        &[],
        &["run"],
        &["run", "small.toml", "--sed", "1"],
        &["run", "small.toml", "--seed", "-1"],
        &["run", "small.toml", "--seeds", "5..1"],
        &["run", "small.toml", "--seed", "1", "--seeds", "1..2"],
        &["run", "small.toml", "--threads", "0"],
        &["run", "small.toml", "--set", "cycles"],
        &["verify", "run", "--recompute", "--fraction", "0"],
        &["verify", "run", "--recompute", "--fraction", "1.5"],
        &["verify", "run", "--fraction", "0.5"],
        &["verify", "run", "--backend", "cpu"],
        &["evaluate", "small.toml", "--random", "2", "--best"],
        &["evaluate", "--best", "--genomes", "run", "--summary"],
        &["evaluate", "--best", "--genomes", "run", "--log", "30"],
        &["evaluate", "--best", "--genomes", "run", "--walk", "30"],
        &["evaluate", "--tournament", "--genomes", "run", "--set", "cycles=5"],
        &["evaluate", "--genomes", "run", "--every", "2"],
        &["new", "name", "--keys"],
        &["replay", "run", "--every", "0"],
        &["completions", "dos"],
    ] {
        place.run(arguments).exits(2);
    }
    place
        .run(&["audit", "run", "--share", "0.1"])
        .exits(2)
        .says(&["it is now 'oneiro verify RUN_DIR --recompute --fraction"]);
    place
        .run(&["verify", "run", "--recompute", "--share", "0.1"])
        .exits(2)
        .says(&["did you mean '--fraction F'?"]);
    assert_eq!(place.names(), ["small.toml"]);
}

#[test]
fn experiments_that_are_not_allowed_exit_with_3_and_say_where() {
    let place = Place::new("experiments");
    for (text, words) in [
        ("cycle = 5\n", &["bad.toml:1:1", "cycle", "allowed"][..]),
        (
            "cycles = 500\n[noise]\nsensors = [0, 1]\n",
            &["bad.toml:3:1", "sensors", "allowed"],
        ),
        ("cycles = \"many\"\n", &["bad.toml:1:", "cycles", "allowed"]),
        ("cycles = 0\n", &["bad.toml:1:", "cycles", "allowed"]),
        ("cycles = 2000000\n", &["bad.toml:1:", "cycles", "1000000"]),
        (
            "[noise]\nsensor = [0.4, 0.0]\n",
            &["bad.toml:2:", "noise.sensor", "allowed"],
        ),
        (
            "[noise]\nsensor = [0.0, nan]\n",
            &["bad.toml:2:", "noise.sensor", "allowed"],
        ),
        (
            "[controller]\nkind = \"brain\"\n",
            &["bad.toml:2:", "controller.kind", "allowed"],
        ),
        (
            "[controller]\nkind = \"hidden\"\nunits = 1000\n",
            &["bad.toml:3:", "controller.units", "allowed"],
        ),
        (
            "[arena]\npreset = \"moon\"\n",
            &["bad.toml:2:", "arena.preset", "miglino1995"],
        ),
        (
            "[arena]\nwidth_mm = -5\nheight_mm = 100\n",
            &["bad.toml:2:", "arena.width_mm", "allowed"],
        ),
        (
            "[evolution]\npopulation = 10\nparents = 20\n",
            &["bad.toml:", "evolution.", "allowed"],
        ),
        (
            "[evolution]\ninit = \"none.npy\"\n",
            &["bad.toml:2:", "evolution.init", "none.npy"],
        ),
        (
            "[robot]\ntables = [\"none.sam\"]\n",
            &["bad.toml:2:", "robot.tables", "none.sam"],
        ),
        (
            "[noise]\nsensor = [0.02, -0.02]\n",
            &["noise.sensor: is [0.02, -0.02]; allowed: [0, 0] or [minimum"],
        ),
        (
            "[evolution]\ngenerations = 40.0\n",
            &["bad.toml:2:15: evolution.generations: is 40.0; allowed: a whole number from 1 to 1000000, such as 40"],
        ),
        (
            "[evoluton]\npopulation = 10\n",
            &["bad.toml:1:2: evoluton: unknown key", "; did you mean evolution?"],
        ),
        (
            "[evolution.mutatoin]\nrate = 0.1\n",
            &["evolution.mutatoin: unknown key", "; did you mean evolution.mutation?"],
        ),
        (
            "[start]\nkind = \"at\"\ny_mm = 90\nheading_turns = 0\n",
            &["bad.toml:1:1: start: lacks `x_mm`; allowed: a number from -100000 to 100000 (mm)"],
        ),
        (
            "experiment = \"small.toml\"\nseeds = \"1..3\"\n",
            &[
                "bad.toml: is a sweep's file, not an experiment; ",
                "`oneiro sweep run bad.toml` runs it",
            ],
        ),
        ("cycles = \n", &["bad.toml:1:"]),
        ("[noise\n", &["bad.toml:1:"]),
        ("cycles = 1\ncycles = 2\n", &["bad.toml:2:"]),
    ] {
        place.write("bad.toml", text);
        place.run(&["check", "bad.toml"]).exits(3).says(words);
        place
            .run(&["run", "bad.toml", "--seed", "1", "--out", "run"])
            .exits(3)
            .says(words);
    }
    place.small_experiment();
    place
        .run(&["check", "small.toml", "--set", "cycles=0"])
        .exits(3)
        .says(&["--set cycles=0", "allowed"]);
    place
        .run(&["check", "small.toml", "--set", "noise.wind=1"])
        .exits(3)
        .says(&["--set noise.wind=1", "wind"]);
    let none = place.run(&["check", "none.toml"]).exits(3);
    assert_eq!(
        none.stderr,
        "oneiro: none.toml: No such file or directory; `oneiro new NAME` writes an experiment\n"
    );
    place
        .run(&["check", "part.wgsl"])
        .exits(3)
        .says(&["part.wgsl: is a part, not an experiment"]);
    place
        .run(&["sweep", "run", "small.toml", "--out", "sweep"])
        .exits(3)
        .says(&[
            "small.toml: is an experiment, not a sweep's file",
            "`oneiro run small.toml` runs it",
        ]);
    place
        .run(&["evaluate", "--genomes", "genes.npy", "small.toml"])
        .exits(3)
        .says(&[
            "--genomes small.toml: isn't a file of genomes",
            "an experiment goes before --genomes",
        ]);
    place.run(&["check", "."]).exits(3);
    place.write("bytes.toml", [0xff, 0xfe, 0x00, 0x80]);
    place.run(&["check", "bytes.toml"]).exits(3).says(&["bytes.toml"]);
    assert_eq!(place.names(), ["bad.toml", "bytes.toml", "small.toml"]);
}

/// Mistakes that people make, and the messages that answer them.
#[test]
fn mistakes_are_told_with_what_to_do_instead() {
    let place = Place::new("mistakes");
    place.small_run();
    place.write("afile", "");
    place.write("swarm.toml", "[swarm]\nrobots = 2\n");
    let robots = SLIPPING.replace("wheel_noise = 0.3", "count = 2");
    place.write("robots.toml", format!("{robots}finalists = 0\n"));
    place.write(
        "mission.wgsl",
        "fn mission_cycle(episode: Episode, step: u32) -> f32 { return f32(step); }\n",
    );
    let run = [
        "run",
        "robots.toml",
        "--seed",
        "1",
        "--out",
        "robots",
        "--backend",
        "cpu",
    ];
    place.good(&run);
    for (code, arguments, words) in [
        (
            3,
            &["run", "small.toml", "--seed", "1", "--out", "afile"][..],
            &["afile: is a file; allowed: a directory's name"][..],
        ),
        (
            3,
            &["new", "--keys", "noize"],
            &["no key contains `noize`; did you mean noise?"],
        ),
        (
            3,
            &["new", "--keys", "zzzzz"],
            &["no key contains `zzzzz`; allowed: a part of a key, such as noise"],
        ),
        (
            3,
            &["new", "--example", "odowd2014"],
            &["is unknown; did you mean odowd2014-over?"],
        ),
        (
            3,
            &["list"],
            &["runs: has no runs yet; `oneiro run EXPERIMENT.toml --seed 1` makes one"],
        ),
        (3, &["evaluate", "--genomes", "runs"], &["runs: does not exist"]),
        (
            3,
            &["evaluate", "swarm.toml", "--random", "3"],
            &["swarm.toml: is the foraging study; allowed: experiments with one robot, or with robot.count"],
        ),
        (
            3,
            &["replay", "robots", "--start", "100,100,0"],
            &["--start: is given for a swarm, which starts as its experiment says; allowed: with single robots"],
        ),
        (
            3,
            &["check", "robots.toml", "--set", "robot.sensors[1].range_mm=100"],
            &["--set robot.sensors[1].range_mm=100: robot.sensors.1: is no element of the list; allowed: 0 to 0"],
        ),
        (
            3,
            &["check", "robots.toml", "--set", "robot.sensors.0.range_mm=-1"],
            &["--set robot.sensors.0.range_mm=-1: robot.sensors[0].range_mm: is -1"],
        ),
        (
            3,
            &["check", "small.toml", "--out", "arena.png"],
            &["--out arena.png: the picture is an SVG; allowed: a name that ends in .svg"],
        ),
        (
            3,
            &["check", "small.toml", "--set", "cycels=3"],
            &["unknown key `cycels`; did you mean cycles? (allowed: name, seed, cycles, "],
        ),
    ] {
        let ran = place.run(arguments).exits(code).says(words);
        assert!(ran.stdout.is_empty(), "{}", ran.stdout);
    }
    assert!(!place.at("arena.png").exists() && place.read("afile").is_empty());
    fs::remove_file(place.at("run/fitness.npy")).unwrap();
    place
        .run(&["verify", "run"])
        .exits(5)
        .says(&["run: fitness.npy is missing"]);
}

#[test]
fn genomes_that_are_not_allowed_exit_with_3_and_say_where() {
    let place = Place::new("genomes");
    place.small_experiment();
    let good = npy(&three_genomes(), &[3, 18]);
    let mut with_nan = three_genomes();
    with_nan[18 + 5] = f32::NAN;
    place.write("nan.npy", npy(&with_nan, &[3, 18]));
    place.write("nan.csv", csv(&with_nan, 18));
    place.write("narrow.npy", npy(&three_genomes(), &[6, 9]));
    place.write("ragged.csv", format!("{}1,2,3\n", csv(&three_genomes(), 18)));
    place.write("huge.csv", csv(&[2e6; 18], 18));
    place.write("cut.npy", &good[..good.len() - 1]);
    place.write("cut-header.npy", &good[..40]);
    place.write("empty.csv", "");
    place.write("noise.npy", [0x93; 200]);
    place.write("genomes.txt", "1,2");
    for (file, words) in [
        ("nan.npy", &["nan.npy", "row 2, gene 6", "NaN", "allowed"][..]),
        ("nan.csv", &["nan.csv", "line 2, column 6", "NaN", "allowed"]),
        ("narrow.npy", &["narrow.npy", "(6, 9)", "18"]),
        ("ragged.csv", &["ragged.csv", "line 4", "3 numbers", "18"]),
        ("huge.csv", &["huge.csv", "line 1, column 1", "allowed"]),
        ("cut.npy", &["cut.npy", "215 bytes", "216"]),
        ("cut-header.npy", &["cut-header.npy", "allowed"]),
        ("empty.csv", &["empty.csv", "allowed"]),
        ("noise.npy", &["noise.npy", "allowed"]),
        ("genomes.txt", &["genomes.txt", ".npy", ".csv"]),
        ("none.npy", &["none.npy"]),
        (".", &["oneiro: .: "]),
    ] {
        let before = place.names();
        place
            .run(&["evaluate", "small.toml", "--genomes", file, "--out", "out.csv"])
            .exits(3)
            .says(words);
        assert_eq!(place.names(), before);
    }
}

#[test]
fn a_missing_device_exits_with_4() {
    let place = Place::new("devices-none");
    place.small_experiment();
    place.write("genomes.csv", csv(&three_genomes(), 18));
    for backend in ["gpu:no such adapter", "abacus", "cpu:abacus", "pool:cpu+abacus"] {
        place
            .run(&[
                "evaluate",
                "small.toml",
                "--genomes",
                "genomes.csv",
                "--backend",
                backend,
            ])
            .exits(4)
            .says(&["oneiro: "]);
        let ran = place
            .run(&["run", "small.toml", "--out", "run", "--backend", backend])
            .exits(4);
        assert!(!ran.stderr.contains("seed"), "{}", ran.stderr);
    }
    place
        .run(&["device", "test", "--backend", "abacus"])
        .exits(4)
        .says(&["allowed"]);
    place
        .run(&["device", "bench", "--backend", "gpu:no such adapter"])
        .exits(4);
    assert_eq!(place.names(), ["genomes.csv", "small.toml"]);
}

#[test]
fn nothing_is_overwritten() {
    let place = Place::new("overwrite");
    place.small_experiment();
    place.write("genomes.csv", csv(&three_genomes(), 18));
    for name in ["kept.toml", "kept.csv", "kept.svg", "kept.sam", "kept.npy"] {
        place.write(name, "kept");
    }
    let evaluate = ["evaluate", "small.toml", "--genomes", "genomes.csv", "--out"];
    for arguments in [
        &["new", "kept"][..],
        &["check", "small.toml", "--out", "kept.svg"],
        &[&evaluate[..], &["kept.csv"]].concat(),
        &[&evaluate[..], &["kept.npy"]].concat(),
        &["robot", "tables", "export", "--builtin", "wall", "kept.sam"],
        &["robot", "tables", "show", "wall", "--out", "kept.svg"],
    ] {
        place.run(arguments).exits(3).says(&["kept", "nothing is overwritten"]);
    }
    for name in ["kept.toml", "kept.csv", "kept.svg", "kept.sam", "kept.npy"] {
        assert_eq!(place.text(name), "kept");
    }
    place.run(&["new", "../elsewhere"]).exits(3).says(&["allowed"]);
    place
        .run(&["check", "small.toml", "--out", "none/picture.svg"])
        .exits(3)
        .says(&["none/picture.svg"]);
}

#[test]
fn from_a_new_experiment_to_its_champion() {
    let place = Place::new("story");
    place.good(&["new", "mine"]);
    assert!(place.text("mine.toml").contains("name = \"mine\""));
    let summary = place.good(&["check", "mine.toml", "--out", "arena.svg"]);
    assert!(
        summary.contains("mine is valid") && summary.contains("18 genes"),
        "{summary}"
    );
    let picture = place.text("arena.svg");
    assert!(picture.starts_with("<svg ") && picture.ends_with("</svg>\n"));

    let small = [
        "--set",
        "cycles=50",
        "--set",
        "evolution.generations=3",
        "--set",
        "evolution.population=40",
    ];
    let run = [
        &[
            "run",
            "mine.toml",
            "--seeds",
            "3..4",
            "--out",
            "runs",
            "--backend",
            "cpu",
        ],
        &small[..],
    ]
    .concat();
    place.good(&run);
    let listed = place.answer(&["list", "runs", "--json"]);
    let listed = listed.as_array().unwrap();
    assert_eq!(listed.len(), 2);
    for (run, seed) in listed.iter().zip([4, 3]) {
        assert_eq!(
            (run["seed"].as_u64(), run["state"].as_str()),
            (Some(seed), Some("done"))
        );
        assert_eq!(
            (run["generation"].as_u64(), run["generations"].as_u64()),
            (Some(3), Some(3))
        );
    }
    let verified = place.good(&["verify", "runs"]);
    let audited = place.good(&[
        "verify",
        "--recompute",
        "runs",
        "--fraction",
        "1",
        "--backend",
        "cpu:scalarx1",
    ]);
    assert_eq!(
        audited
            .matches("120 of 120 individuals audited, 0 with other bits")
            .count(),
        2,
        "{audited}"
    );
    for run in listed {
        let directory = run["directory"].as_str().unwrap();
        assert!(
            verified.contains(&format!("{}  {directory}\n", &run["result"].as_str().unwrap()[..12])),
            "{verified}"
        );
        let replay = place.answer(&["replay", directory, "--json", "--every", "5"]);
        let champion: Value = serde_json::from_str(&place.text(format!("{directory}/champion.json"))).unwrap();
        assert_eq!(replay["bits"], champion["fitness_bits"]);
        assert_eq!(replay["generation"], champion["generation"]);
        let trace = place.text(format!("{directory}/replay.csv"));
        assert_eq!(trace.lines().count(), 1 + 50 / 5, "{trace}");
        assert!(place.text(format!("{directory}/replay.svg")).contains("</svg>"));
        assert!(place.text(format!("{directory}/replay.html")).contains("<canvas"));
        // Each recorded individual can be seen, a generation's best without a number.
        let table = place.text(format!("{directory}/generations.csv"));
        for (generation, row) in table.lines().skip(1).enumerate() {
            let generation = generation.to_string();
            let best = place.answer(&["replay", directory, "--json", "--generation", &generation]);
            assert_eq!(best["compared"], true);
            assert_eq!(
                Some(best["fitness"].to_string().as_str()),
                row.split(',').nth(1),
                "{row}"
            );
            let number = best["individual"].to_string();
            let same = ["--generation", &generation, "--individual", &number];
            assert_eq!(
                place.answer(&[&["replay", directory, "--json"], &same[..]].concat())["bits"],
                best["bits"]
            );
        }
        let all = place.answer(&["replay", directory, "--json", "--generations", "1,0", "--seed", "4"]);
        let order: Vec<_> = all["generations"]
            .as_array()
            .unwrap()
            .iter()
            .map(|own| &own["generation"])
            .collect();
        assert_eq!(order, [1, 0]);
        assert!(
            place
                .text(format!("{directory}/learning.html"))
                .contains("how it learned")
        );
    }
    for (more, words) in [
        (
            &["--generation", "99"][..],
            "--generation 99: is not recorded; allowed: 0 to",
        ),
        (
            &["--film", "a.webm"],
            "--film a.webm: its ending says no kind of file; allowed: FILE.gif",
        ),
        (
            &["--picture", "a"],
            "--picture a: its ending says no kind of file; allowed: FILE.svg or FILE.png",
        ),
        (
            &["--generation", "0", "--individual", "999"],
            "--individual 999: no such individual; allowed: 0 to",
        ),
        (&["--generations", "0,99"], "--generation 99: is not recorded"),
    ] {
        let run = listed[0]["directory"].as_str().unwrap();
        place.run(&[&["replay", run], more].concat()).exits(3).says(&[words]);
    }
    // The replay's own files aren't part of the run.
    assert_eq!(place.good(&["verify", "runs"]), verified);
}

/// The picture of a moment has the robot where the trace has it, and a film's last frame where the episode ends.
#[test]
fn an_episode_is_a_picture_and_a_film() {
    let place = Place::new("film");
    place.small_experiment();
    place.good(&["run", "small.toml", "--seed", "1", "--out", "run", "--quiet"]);
    let pictures = ["--picture", "at.svg", "--at", "2", "--film", "a.gif"];
    let answer = place.answer(&[&["replay", "run", "--json"], &pictures[..]].concat());
    assert_eq!([&answer["picture"], &answer["film"]], ["at.svg", "a.gif"]);
    let trace = place.text("run/replay-0.csv");
    let cycle = trace.lines().nth(1 + 20).unwrap();
    let [x, y] = ["x_mm", "y_mm"].map(|name| {
        let column = trace.lines().next().unwrap().split(',').position(|own| own == name);
        cycle.split(',').nth(column.unwrap()).unwrap().parse::<f64>().unwrap()
    });
    let picture = place.text("at.svg");
    // The arena of 600 by 350 mm has a margin of 3 % of its length in 880 pixels; rows count from the top.
    let (scale, margin) = (880.0 / (1.06 * 600.0), 0.03 * 600.0);
    let number = |text: &str| text.parse::<f64>().unwrap();
    let (_, robot) = picture.split_once("translate(").unwrap();
    let (left, rest) = robot.split_once(' ').unwrap();
    let (top, _) = rest.split_once(')').unwrap();
    assert!((number(left) - scale * (x + margin)).abs() < 0.01, "{left} {x}");
    assert!((number(top) - scale * (350.0 + margin - y)).abs() < 0.01, "{top} {y}");
    assert!(picture.contains("2 s of "));
    let film = fs::read(place.at("a.gif")).unwrap();
    assert_eq!(&film[..6], b"GIF89a");
    let all = [
        "replay",
        "run",
        "--generations",
        "0,1",
        "--film",
        "b.gif",
        "--picture",
        "b.png",
    ];
    place.good(&all);
    assert_eq!(fs::read(place.at("b.png")).unwrap()[1..4], *b"PNG");
    // A film of the same episode has the same bytes.
    place.good(&["replay", "run", "--film", "c.gif"]);
    assert_eq!(fs::read(place.at("c.gif")).unwrap(), film);
    let last = number(picture.split_once("2 s of ").unwrap().1.split(' ').next().unwrap());
    let after = (last + 0.1).to_string();
    for (more, words) in [
        (
            &["--film", "none/a.gif"][..],
            "--film none/a.gif: there is no folder none; allowed: a file in a folder that exists".to_owned(),
        ),
        (
            &["--picture", "d.svg", "--at", &after],
            format!("--at {after}: is after the end of the episode; allowed: 0 to {last}"),
        ),
        (
            &["--picture", "d.svg", "--at", &after, "--generations", "0,1"],
            format!("allowed: 0 to {last}"),
        ),
    ] {
        place
            .run(&[&["replay", "run", "--out", "refused"][..], more].concat())
            .exits(3)
            .says(&[&*words]);
    }
    assert!(!place.at("refused").exists() && !place.at("d.svg").exists());
    place.good(&["replay", "run", "--picture", "d.svg", "--at", &last.to_string()]);
    // By whichever path it is named twice.
    for twice in ["run", "./run/", "run/../run"] {
        place
            .run(&["evaluate", "--genomes", "run", twice])
            .exits(3)
            .says(&[" is named twice; allowed: each file, run and sweep once"]);
    }
}

/// The surrogate's episode is the recorded one, and the simulator's that of a run without reality.
#[test]
fn a_champion_is_seen_in_the_simulator_and_on_a_surrogate() {
    let place = Place::new("realities");
    place.small_experiment();
    let real = [
        "--set",
        "reality.robot=\"surrogate:3\"",
        "--set",
        "reality.generations=2",
        "--set",
        "reality.severity=0.5",
    ];
    place.evolved("small.toml", "7", "real", &real);
    place.evolved("small.toml", "7", "simulated", &[]);
    let replay = |run: &str, more: &[&str]| place.answer(&[&["replay", run, "--json"], more].concat());
    let both = |more: &[&str]| {
        let told = replay("real", more);
        assert_eq!(
            [0, 1].map(|own| &told["realities"][own]["name"]),
            ["simulator", "surrogate"]
        );
        [0, 1].map(|own| told["realities"][own]["fitness"].as_f64().unwrap())
    };
    let own = both(&["--robot", "surrogate:3", "--trial", "1"]);
    let recorded = replay("real", &["--trial", "1"]);
    assert_eq!(recorded["compared"], true);
    assert_eq!(recorded["trial_fitness"], own[1]);
    assert_eq!(
        both(&["--robot", "surrogate:3", "--trial", "1", "--severity", "0.5"]),
        own
    );
    for other in [&["surrogate:3", "--severity", "1.5"][..], &["surrogate:4"]] {
        let other = both(&[&["--trial", "1", "--robot"], other].concat());
        assert!(other[0] == own[0] && other[1] != own[1], "{other:?}");
    }
    let drawn = both(&["--robot", "surrogate:3", "--seed", "4"]);
    let simulated = replay("simulated", &["--genome", "real/champion.npy", "--seed", "4"]);
    assert_eq!(simulated["trial_fitness"], drawn[0]);
    let page = place.text("real/replay-0-seed-4-surrogate-3.html");
    assert!(
        page.contains(
            "The same controller in the simulator and the surrogate, each alone from the same start, for 6 s"
        )
    );
    // Generations of different worlds are also on one page.
    assert_eq!(
        replay("real", &["--generations", "0,4"])["generations"][1]["generation"],
        4
    );
    place
        .run(&["replay", "real", "--robot", "surrogate:3", "--generations", "0"])
        .exits(2);
}

#[test]
fn fitness_is_the_same_by_every_way_in_and_out() {
    let place = Place::new("evaluate");
    place.small_experiment();
    let genomes = three_genomes();
    place.write("genomes.npy", npy(&genomes, &[3, 18]));
    place.write("genomes.csv", csv(&genomes, 18));
    let evaluate = |genomes: &str, more: &[&str]| {
        let own = [
            "evaluate",
            "small.toml",
            "--genomes",
            genomes,
            "--seed",
            "3",
            "--backend",
            "cpu",
        ];
        place.run(&[&own[..], more].concat()).exits(0).stdout
    };
    let table = evaluate("genomes.npy", &[]);
    let lines: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(lines[0], ["genome", "trial", "fitness", "bits"]);
    assert_eq!(lines.len(), 1 + 3 * 2);
    for (row, line) in lines[1..].iter().enumerate() {
        assert_eq!((line[0], line[1]), (&*(row / 2).to_string(), &*(row % 2).to_string()));
        let bits = u32::from_str_radix(line[3], 16).unwrap();
        assert_eq!(line[2].parse::<f32>().unwrap().to_bits(), bits);
    }
    // The trials start in different places, and the genomes behave differently.
    let mut bits: Vec<&str> = lines[1..].iter().map(|line| line[3]).collect();
    bits.sort_unstable();
    bits.dedup();
    assert!(bits.len() > 3, "{table}");

    assert_eq!(evaluate("genomes.csv", &[]), table);
    assert_eq!(evaluate("genomes.npy", &["--threads", "1"]), table);
    assert_eq!(evaluate("genomes.npy", &["--trials", "1"]).lines().count(), 1 + 3);
    assert_ne!(evaluate("genomes.npy", &["--set", "noise.sensor=[0.0, 0.1]"]), table);
    assert_eq!(evaluate("genomes.npy", &["--out", "out.csv"]), "");
    assert_eq!(place.text("out.csv"), table);
    evaluate("genomes.npy", &["--out", "out.npy"]);
    let bytes = place.read("out.npy");
    let array = npyz::NpyFile::new(&bytes[..]).unwrap();
    assert_eq!(array.shape(), [3, 2]);
    let values: Vec<String> = array
        .into_vec::<f32>()
        .unwrap()
        .iter()
        .map(|value| format!("{:08x}", value.to_bits()))
        .collect();
    let json: Value = serde_json::from_str(&evaluate("genomes.npy", &["--json"])).unwrap();
    for (row, line) in lines[1..].iter().enumerate() {
        assert_eq!(line[3], values[row]);
        assert_eq!(json[row]["fitness"].as_f64(), line[2].parse().ok());
        assert_eq!(json[row]["bits"], line[3]);
    }
}

/// A robot with noise of its wheels.
const SLIPPING: &str = "cycles = 40
[robot]
kind = \"differential\"
body_radius_mm = 27
wheel_base_mm = 52
greatest_speed_mm_s = 80
wheel_noise = 0.3
sensors = [{ name = \"front\", range_mm = 60 }]
[noise]
sensor = [0.0, 0.4]
[evolution]
population = 20
parents = 4
generations = 2
";

#[test]
fn without_noise_wheels_have_none_either() {
    let place = Place::new("noise-off");
    place.write("slipping.toml", SLIPPING);
    let lived = |more: &[&str]| {
        let own = [
            "evaluate",
            "slipping.toml",
            "--random",
            "4",
            "--seed",
            "3",
            "--backend",
            "cpu",
        ];
        place.good(&[&own[..], more].concat())
    };
    let sensors_off = ["--set", "noise.sensor=[0.0, 0.0]"];
    let without = lived(&["--set", "noise.sensor=[0.0, 0.0]", "--set", "robot.wheel_noise=0.0"]);
    assert_eq!(lived(&["--noise", "off"]), without);
    assert_ne!(lived(&sensors_off), without);
    let noise = |more: &[&str]| {
        let summary = place.good(&[&["check", "slipping.toml"], more].concat());
        let line = summary.lines().find(|line| line.starts_with("  noise "));
        line.unwrap().to_owned()
    };
    assert!(noise(&sensors_off).ends_with("  each wheel's speed varies by a fraction of 0.3"));
    assert!(noise(&["--set", "robot.wheel_noise=0", sensors_off[0], sensors_off[1]]).ends_with("  none"));

    place.good(&["new", "parts", "--task", "mine"]);
    let parts = place.good(&["check", "parts.toml"]);
    assert!(parts.contains("none; custom parts may add noise"), "{parts}");
    place
        .run(&[
            "evaluate",
            "parts.toml",
            "--random",
            "2",
            "--noise",
            "off",
            "--set",
            "cycles=10",
        ])
        .exits(0)
        .says(&["custom parts keep the noise that they draw"]);
}

#[test]
fn a_summary_has_the_means_of_measures_and_ends_with_their_span() {
    let place = Place::new("summary");
    place.small_experiment();
    let own = [
        "evaluate",
        "small.toml",
        "--random",
        "5",
        "--trials",
        "4",
        "--backend",
        "cpu",
        "--measures",
    ];
    let lives = place.good(&own);
    let lives: Vec<Vec<&str>> = lives.lines().map(|line| line.split(',').collect()).collect();
    let column = |name: &str| lives[0].iter().position(|own| *own == name).unwrap();
    let ran = place.run(&[&own[..], &["--summary"]].concat()).exits(0);
    let rows: Vec<Vec<&str>> = ran.stdout.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 1 + 5);
    for (genome, row) in rows[1..].iter().enumerate() {
        for (name, mean) in [("fitness", row[2]), ("cells", row[7])] {
            let values = lives[1 + 4 * genome..][..4]
                .iter()
                .map(|life| life[column(name)].parse::<f64>().unwrap());
            let expected = values.sum::<f64>() / 4.0;
            assert!(
                (mean.parse::<f64>().unwrap() / expected - 1.0).abs() < 1e-5,
                "{name}: {row:?}"
            );
        }
    }
    assert_eq!(rows[0][7], "mean_cells");
    let mut means: Vec<(f64, usize)> = rows[1..].iter().map(|row| row[2].parse().unwrap()).zip(0..).collect();
    means.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (greatest, genome) = means[4];
    ran.says(&[&format!(
        "mean fitness of 5 genomes: median {}, maximum {greatest} (genome {genome})",
        means[2].0
    )]);
}

/// A run's first generation has the same lives as `evaluate` gives the same genomes.
#[test]
fn a_run_and_an_evaluation_agree() {
    let place = Place::new("agree");
    place.small_run();
    let bytes = place.read("run/individuals.npy");
    let individuals = npyz::NpyFile::new(&bytes[..]).unwrap();
    assert_eq!(individuals.shape(), [5, 20, 19]);
    let values = individuals.into_vec::<f32>().unwrap();
    let first: Vec<&[f32]> = values.chunks(19).take(20).collect();
    let genomes: Vec<f32> = first.iter().flat_map(|individual| &individual[..18]).copied().collect();
    place.write("first.npy", npy(&genomes, &[20, 18]));
    let table = place.good(&[
        "evaluate",
        "run/config.toml",
        "--genomes",
        "first.npy",
        "--backend",
        "cpu:scalarx1",
    ]);
    let lives: Vec<f64> = table
        .lines()
        .skip(1)
        .map(|line| {
            f64::from(f32::from_bits(
                u32::from_str_radix(line.rsplit(',').next().unwrap(), 16).unwrap(),
            ))
        })
        .collect();
    assert_eq!(lives.len(), 40);
    for (individual, lives) in first.iter().zip(lives.chunks(2)) {
        assert_eq!(individual[18].to_bits(), (lives[0].midpoint(lives[1]) as f32).to_bits());
    }
}

#[test]
fn damage_is_found() {
    let place = Place::new("damage");
    place.small_run();
    place.good(&["verify", "run"]);

    let champion = place.text("run/champion.json");
    let bits = champion.split("\"fitness_bits\": \"").nth(1).unwrap()[..8].to_owned();
    let other = format!("{:08x}", u32::from_str_radix(&bits, 16).unwrap() ^ 1);
    place.write("run/champion.json", champion.replace(&bits, &other));
    place.run(&["verify", "run"]).exits(5).says(&["champion.json"]);
    place.run(&["replay", "run"]).exits(1).says(&[&bits, &other]);
    place.write("run/champion.json", &champion[..champion.len() / 2]);
    place.run(&["replay", "run"]).exits(5).says(&["champion.json"]);
    place.write("run/champion.json", &champion);

    let mut individuals = place.read("run/individuals.npy");
    // The lowest bit of the last score.
    let low = individuals.len() - 4;
    individuals[low] ^= 1;
    place.write("run/individuals.npy", &individuals);
    place.run(&["verify", "run"]).exits(5).says(&["individuals.npy"]);
    let audit = place.run(&["verify", "--recompute", "run", "--fraction", "1"]).exits(5);
    assert!(
        audit
            .stdout
            .contains("100 of 100 individuals audited, 1 with other bits"),
        "{}",
        audit.stdout
    );
    assert!(audit.stdout.contains("generation 4, individual 19"), "{}", audit.stdout);
    // Without checksums, the bits alone tell.
    let sums = place.read("run/DONE");
    fs::remove_file(place.at("run/DONE")).unwrap();
    let recomputed = place.run(&["verify", "--recompute", "run", "--fraction", "1"]).exits(1);
    recomputed.says(&["run: 1 individual has other bits"]);
    place.write("run/DONE", sums);
    individuals[low] ^= 1;
    place.write("run/individuals.npy", &individuals);
    place.good(&["verify", "run"]);

    let done = place.text("run/DONE");
    place.write("run/DONE", done.replacen('a', "b", 1));
    place.run(&["verify", "run"]).exits(5);
    place.write("run/DONE", "{");
    place.run(&["verify", "run"]).exits(5).says(&["DONE"]);
    fs::remove_file(place.at("run/DONE")).unwrap();
    place.run(&["verify", "run"]).exits(1).says(&["not finished"]);

    place.run(&["verify", "nowhere"]).exits(3);
    place
        .run(&["replay", "."])
        .exits(3)
        .says(&[".: holds runs; allowed: the directory of one, such as ./run"]);
    fs::create_dir(place.at("empty")).unwrap();
    place.run(&["list", "empty"]).exits(3).says(&["is not a run directory"]);
}

#[test]
fn tables_come_and_go_without_a_change() {
    let place = Place::new("tables");
    for table in ["wall", "round", "motor"] {
        place.good(&["robot", "tables", "export", "--builtin", table, &format!("{table}.sam")]);
    }
    place.good(&["robot", "tables", "convert", "wall.sam", "wall.sample"]);
    fs::create_dir(place.at("back")).unwrap();
    place.good(&["robot", "tables", "convert", "wall.sample", "back/wall.sam"]);
    assert_eq!(place.read("back/wall.sam"), place.read("wall.sam"));
    let shown = place.answer(&["robot", "tables", "show", "wall.sam", "--out", "wall.svg", "--json"]);
    assert_eq!(shown, place.answer(&["robot", "tables", "show", "wall", "--json"]));
    assert_eq!(shown["sensors"].as_array().unwrap().len(), 8);
    assert!(place.text("wall.svg").contains("</svg>"));
    assert!(
        place
            .good(&["robot", "tables", "show", "motor.sam"])
            .contains("25 x 25")
    );

    // An experiment that names the exported tables equals the built-in one.
    place.small_experiment();
    place.write(
        "tables.toml",
        format!("robot.tables = [\"wall.sam\", \"round.sam\"]\nrobot.motors = \"motor.sam\"\n{SMALL}"),
    );
    place.write("genomes.csv", csv(&three_genomes(), 18));
    let evaluate = |experiment| place.good(&["evaluate", experiment, "--genomes", "genomes.csv", "--backend", "cpu"]);
    assert_eq!(evaluate("tables.toml"), evaluate("small.toml"));

    let whole = place.text("wall.sam");
    let cut = whole.lines().count() / 2;
    place.write("cut.sam", whole.lines().take(cut).collect::<Vec<_>>().join("\n"));
    place
        .run(&["robot", "tables", "show", "cut.sam"])
        .exits(3)
        .says(&["cut.sam", "line"]);
    place.write("wrong.sam", whole.replacen("1023", "1024", 1));
    place
        .run(&["robot", "tables", "show", "wrong.sam"])
        .exits(3)
        .says(&["wrong.sam", "line", "1023"]);
    place
        .run(&["robot", "tables", "show", "lamp"])
        .exits(3)
        .says(&["lamp", "wall, round, motor"]);
    place
        .run(&["robot", "tables", "export", "--builtin", "lamp", "lamp.sam"])
        .exits(3)
        .says(&["wall, round, motor"]);
    place
        .run(&["robot", "tables", "export", "--builtin", "wall", "wall.txt"])
        .exits(3)
        .says(&[".sam, .sample"]);
    place
        .run(&["robot", "tables", "convert", "motor.sam", "motor.sample"])
        .exits(3)
        .says(&[".sam"]);
    place.write("cut.toml", format!("robot.tables = [\"cut.sam\"]\n{SMALL}"));
    place
        .run(&["check", "cut.toml"])
        .exits(3)
        .says(&["cut.toml:1", "robot.tables", "cut.sam", "line"]);
}

#[test]
fn words_go_where_they_belong() {
    let place = Place::new("words");
    place.small_run();
    place.write("genomes.csv", csv(&three_genomes(), 18));
    for arguments in [
        &["check", "small.toml"][..],
        &["evaluate", "small.toml", "--genomes", "genomes.csv", "--backend", "cpu"],
        &["run", "small.toml", "--seed", "1", "--out", "one", "--backend", "cpu"],
        &["list", "."],
        &["verify", "run"],
        &["verify", "--recompute", "run", "--backend", "cpu"],
        &["replay", "run", "--backend", "cpu"],
        &["robot", "tables", "show", "wall"],
    ] {
        let quiet = place.run(&[arguments, &["--quiet"]].concat()).exits(0);
        assert_eq!(quiet.stderr, "", "oneiro {}", quiet.arguments);
        assert!(!quiet.stdout.is_empty(), "oneiro {}", quiet.arguments);
        let json = [arguments, &["--json"]].concat();
        serde_json::from_str::<Value>(&place.good(&json)).unwrap_or_else(|error| panic!("{json:?}: {error}"));
        let loud = place.run(arguments).exits(0);
        assert!(
            !format!("{}{}", loud.stdout, loud.stderr).contains('\u{1b}'),
            "no terminal, no colours"
        );
    }
    let failed = place.run(&["check", "none.toml", "--quiet"]).exits(3);
    assert!(failed.stdout.is_empty() && failed.stderr.starts_with("oneiro: "));
}

#[test]
fn a_closed_pipe_is_no_error() {
    let place = Place::new("pipe");
    place.small_experiment();
    // More rows than fit into a pipe.
    place.write("genomes.csv", csv(&three_genomes().repeat(1000), 18));
    let arguments = [
        "evaluate",
        "small.toml",
        "--genomes",
        "genomes.csv",
        "--backend",
        "cpu",
        "--quiet",
    ];
    let mut child = place.start(&arguments);
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(output.stderr, b"");
}

/// A limit on file sizes is as close to a full disk as a test without privileges can get.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_exits_with_6_and_leaves_nothing_half_written() {
    let place = Place::new("full");
    place.small_experiment();
    place.write("genomes.csv", csv(&three_genomes().repeat(1000), 18));
    let program = env!("CARGO_BIN_EXE_oneiro");
    let script = format!(
        "trap '' XFSZ; ulimit -f 8; exec '{program}' evaluate small.toml --genomes genomes.csv --backend cpu --out out.csv"
    );
    let output = std::process::Command::new("bash")
        .args(["-c", &script])
        .current_dir(place.at("."))
        .output()
        .unwrap();
    place::Ran::new(&["evaluate"], &output).exits(6).says(&["out.csv"]);
    assert_eq!(place.names(), ["genomes.csv", "small.toml"]);
}

#[test]
fn every_shell_has_its_completions() {
    let place = Place::new("completions");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        assert!(place.good(&["completions", shell]).contains("recompute"), "{shell}");
    }
}

/// Pages of an older program are replaced.
#[test]
fn each_command_has_a_man_page() {
    let place = Place::new("man");
    for _ in 0..2 {
        place.good(&["man", "man1"]);
        for name in ["oneiro.1", "oneiro-run.1", "oneiro-sweep-report.1"] {
            assert!(place.at("man1").join(name).is_file(), "{name}");
        }
        assert!(!place.at("man1/oneiro-guard.1").exists());
        let page = fs::read_to_string(place.at("man1/oneiro-run.1")).unwrap();
        for words in ["oneiro run", "\\-\\-seed", "\\-\\-quiet"] {
            assert!(page.contains(words), "{words} in {page}");
        }
        let sweep = fs::read_to_string(place.at("man1/oneiro-sweep.1")).unwrap();
        assert!(!sweep.contains("-help(1)"), "{sweep}");
        place.write("man1/oneiro-run.1", "an older page");
        place.good(&["man", "man1"]);
        assert!(fs::read_to_string(place.at("man1/oneiro-run.1")).unwrap() == page);
    }
    place.write("file", "");
    place.run(&["man", "file"]).exits(3);
}

#[test]
fn the_selftest_passes_and_its_controls_are_caught() {
    let place = Place::new("selftest");
    let report = place.answer(&[
        "device",
        "test",
        "--backend",
        "cpu",
        "--rollouts",
        "1000",
        "--json",
        "--quiet",
    ]);
    assert_eq!(report["passed"], true);
    let checks = report["checks"].as_array().unwrap();
    let of = |verdict: &str| checks.iter().filter(|check| check["verdict"] == verdict).count();
    assert_eq!(of("same") + of("caught"), checks.len());
    assert!(of("caught") >= 6, "{report}");
    assert!(
        checks.iter().any(|check| check["compared"].as_u64() > Some(10_000)),
        "traces are compared"
    );
    assert!(!report["throughput"].as_array().unwrap().is_empty());
}

#[test]
fn the_bench_measures_against_the_scalar_code() {
    let place = Place::new("bench");
    let report = place.answer(&[
        "device",
        "bench",
        "--backend",
        "cpu",
        "--quick",
        "--rollouts",
        "64,200",
        "--json",
        "--quiet",
    ]);
    let cells = report["cells"].as_array().unwrap();
    let scalar = |cell: &&Value| cell["device"] == "cpu scalarx1" && cell["threads"] == 1;
    assert_eq!(cells.iter().filter(scalar).count(), 2);
    for cell in cells.iter().filter(scalar) {
        assert_eq!(cell["ratio"], 1.0);
        assert_eq!(
            cell["robot_steps"].as_u64().unwrap(),
            500 * cell["rollouts"].as_u64().unwrap()
        );
    }
    assert!(cells.iter().all(|cell| cell["steps_per_second"].as_f64() > Some(0.0)));
    assert!(cells.iter().any(|cell| cell["device"] != "cpu scalarx1"));
}

fn quick_bench<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let quick = [
        "device",
        "bench",
        "gather.toml",
        "--backend",
        "cpu",
        "--quick",
        "--rollouts",
        "16",
    ];
    [&quick, more].concat()
}

/// Long lives are cut, and each robot's steps count.
#[test]
fn the_bench_times_an_experiment() {
    let place = Place::new("own-bench");
    place.good(&["new", "--example", "gather", "--quiet"]);
    let report = place.answer(&quick_bench(&["--json", "--quiet"]));
    let cells = report["cells"].as_array().unwrap();
    assert!(!cells.is_empty(), "{report}");
    for cell in cells {
        assert_eq!(cell["robot_steps"], 16 * 10 * 500, "{cell}");
    }
    assert!(cells.iter().any(|cell| cell["ratio"] == 1.0), "{report}");
    let short = place.answer(&quick_bench(&["--set", "cycles=70", "--json", "--quiet"]));
    assert_eq!(short["cycles"], 70);
    let text = place.good(&quick_bench(&[]));
    assert!(
        text.contains("gather.toml, random genes, 500 cycles an episode."),
        "{text}"
    );

    place
        .run(&["device", "bench", "none.toml"])
        .exits(3)
        .says(&["none.toml"]);
    place.run(&["device", "bench", "--set", "cycles=70"]).exits(2);
    place.run(&["device", "bench", "gather.toml", "--host"]).exits(2);
}

#[test]
fn figures_are_shared_in_a_file() {
    let place = Place::new("share");
    let bench = [
        "device",
        "bench",
        "--backend",
        "cpu",
        "--quick",
        "--rollouts",
        "64",
        "--share",
        "share.json",
    ];
    place.good(&bench);
    let shared: Value = serde_json::from_str(&fs::read_to_string(place.at("share.json")).unwrap()).unwrap();
    assert_eq!(shared["oneiro"], env!("CARGO_PKG_VERSION"));
    assert_eq!(shared["devices"]["cpu"]["exact"], true);
    assert!(!shared["bench"]["cells"].as_array().unwrap().is_empty(), "{shared}");
    place.run(&bench).exits(3).says(&["share.json: exists already"]);
}

/// A kernel of its own takes fewer operations in every class, and the sum is that of the classes.
#[cfg(feature = "gpu")]
#[test]
fn a_cycle_s_operations_are_counted() {
    let place = Place::new("cost");
    place.small_experiment();
    let cost = place.answer(&["check", "small.toml", "--cost", "--json"]);
    let of = |kernel: &str| {
        let all = cost[kernel]["operations"].as_f64().unwrap();
        let classes = cost[kernel]["by_class"].as_object().unwrap();
        let sum: f64 = classes.values().map(|count| count.as_f64().unwrap()).sum();
        assert!((all - sum).abs() < 1e-6, "{cost}");
        all
    };
    let (any, this) = (of("any_world"), of("this_world"));
    assert!(300.0 < this && this < 0.7 * any, "{this} and {any}");
    for card in cost["at_most"].as_array().unwrap() {
        let steps = card["steps_per_second"].as_f64().unwrap();
        assert!((1e9..1e12).contains(&steps), "{card}");
    }
    place.good(&["new", "mine", "--task", "own", "--quiet"]);
    let mine = place.answer(&["check", "mine.toml", "--cost", "--json"]);
    let lines = mine["lines"].as_array().unwrap();
    let own = |line: &&Value| line["place"].as_str().unwrap().starts_with("own.wgsl:");
    let dearest = lines.iter().find(own).unwrap();
    assert!(dearest["operations"].as_f64() > Some(5.0), "{dearest}");
    place.good(&["new", "swarm", "--swarm", "--quiet"]);
    assert!(place.good(&["check", "swarm.toml", "--cost"]).contains("at most"));
    place.write("sweep.toml", "experiment = \"small.toml\"\nseeds = \"1..3\"\n");
    let plan = ["sweep", "plan", "sweep.toml", "--no-estimate"];
    let with_cards = place.good(&[&plan[..], &["--cards"]].concat());
    assert!(with_cards.contains("maximum of a card"), "{with_cards}");
    assert!(!place.good(&plan).contains("maximum of a card"));
}

#[test]
fn a_sweep_has_a_directory_by_its_name() {
    let place = Place::new("sweep-name");
    place.small_experiment();
    place.write("noise.toml", "experiment = \"small.toml\"\nseeds = \"1..2\"\n");
    let run = ["sweep", "run", "noise.toml", "--backend", "cpu", "--quiet"];
    place.good(&run);
    assert!(place.at("sweeps/noise/results.csv").exists());
    // Once more, nothing is left to do.
    place.good(&run);
    place.write("noise.toml", "experiment = \"small.toml\"\nseeds = \"1..3\"\n");
    place.run(&run).exits(3).says(&["name another directory with --out"]);
}

#[test]
fn the_bench_measures_the_host() {
    let place = Place::new("bench-host");
    let temporary = place.at("temporary");
    fs::create_dir(&temporary).unwrap();
    let mut command = place.command(&[
        "device",
        "bench",
        "--host",
        "--processors",
        "1",
        "--seconds",
        "1",
        "--json",
        "--quiet",
    ]);
    let ran = command.env("TMPDIR", &temporary).output().unwrap();
    assert!(ran.status.success(), "{ran:?}");
    let report: Value = serde_json::from_slice(&ran.stdout).unwrap();
    assert_eq!(
        (&report["individuals"], &report["generations"]),
        (&100.into(), &200.into())
    );
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 1);
    assert_eq!((&rows[0]["processors"], &rows[0]["ratio"]), (&1.into(), &1.0.into()));
    assert!(rows[0]["individuals_per_second"].as_f64() > Some(0.0));
    let shares = rows[0]["shares"].as_object().unwrap();
    let of_thread = shares.iter().filter(|(name, _)| *name != "place");
    let sum: f64 = of_thread.map(|(_, share)| share.as_f64().unwrap()).sum();
    // What other programs take of its time is in none of them.
    assert!((0.1..=1.0).contains(&sum), "{report}");
    assert_eq!(
        fs::read_dir(&temporary).unwrap().count(),
        0,
        "what it records is removed"
    );

    place
        .run(&["device", "bench", "--backend", "null", "--processors", "1024"])
        .exits(3)
        .says(&["--processors 1024", "allowed: 1 to "]);
    place.run(&["device", "bench", "--host", "--rollouts", "64"]).exits(2);
    place
        .run(&["device", "bench", "--seconds", "3"])
        .exits(2)
        .says(&["--host"]);
}

/// Nothing lives on it: each command that records or reports fitness refuses it, and leaves nothing behind.
#[test]
fn the_device_that_answers_at_once_is_for_the_bench_alone() {
    let place = Place::new("null");
    place.small_experiment();
    place.write("genomes.csv", csv(&three_genomes(), 18));
    place.write("sweep.toml", "experiment = \"small.toml\"\nseeds = \"1..2\"\n");
    let names = place.names();
    for command in [
        &["run", "small.toml", "--seed", "1"][..],
        &["run", "small.toml", "--seeds", "1..2"],
        &["sweep", "run", "sweep.toml", "--out", "out"],
        &["sweep", "run", "sweep.toml", "--out", "out", "--print-slurm"],
        &["evaluate", "small.toml", "--genomes", "genomes.csv"],
        &["reproduce", "miglino1995", "--out", "out"],
        &["reproduce", "odowd2014", "--out", "out"],
        &["robot", "sample", "--robot", "surrogate:1", "--out", "out"],
        &["device", "test"],
    ] {
        place
            .run(&[command, &["--backend", "null"]].concat())
            .exits(3)
            .says(&["--backend null: answers without simulating anything; allowed: with `oneiro device bench`"]);
        assert_eq!(place.names(), names, "{command:?}");
    }
}

#[test]
fn the_cpu_is_a_device_and_exact() {
    let place = Place::new("devices");
    let devices = place.answer(&["device", "list", "--json"]);
    assert_eq!(devices["cpu"]["exact"], true);
    let lanes = devices["cpu"]["lane_codes"].as_array().unwrap();
    assert!(lanes.iter().any(|lane| lane == "scalarx1"), "{devices}");
    // Each driver says what it made of the kernels, or why it doesn't.
    let explained = place.answer(&["device", "list", "--explain", "--json"]);
    for adapter in explained["adapters"].as_array().unwrap() {
        assert!(!adapter["machine_code"].as_object().unwrap().is_empty(), "{adapter}");
    }
}

/// Fails without an adapter: a software one is enough, and the test command installs it.
#[cfg(feature = "gpu")]
#[test]
fn every_exact_adapter_gives_the_cpu_s_bits() {
    let place = Place::new("adapters");
    place.small_experiment();
    place.write("genomes.csv", csv(&three_genomes().repeat(40), 18));
    let evaluate = |backend: &str| {
        place.good(&[
            "evaluate",
            "small.toml",
            "--genomes",
            "genomes.csv",
            "--backend",
            backend,
            "--recheck",
            "1",
        ])
    };
    let devices = place.answer(&["device", "list", "--json"]);
    let adapters = devices["adapters"].as_array().unwrap();
    let exact: Vec<&Value> = adapters.iter().filter(|adapter| adapter["exact"] == true).collect();
    assert!(!exact.is_empty(), "no exact adapter: {devices}");
    let here = evaluate("cpu");
    for adapter in exact {
        let backend = format!("gpu:{}", adapter["index"]);
        assert_eq!(evaluate(&backend), here, "{adapter}");
        for (specialise, share) in [("never", 0.0), ("always", 1.0)] {
            let ran = place.answer(&[
                "run",
                "small.toml",
                "--backend",
                &backend,
                "--specialise",
                specialise,
                "--out",
                &format!("{specialise}-{}", adapter["index"]),
                "--json",
            ]);
            assert_eq!(ran["specialised"], share, "{adapter}");
        }
    }
}

/// What a directory holds is what its README says: with everything that runs can have, and with as little as they can.
#[test]
fn directories_say_what_is_in_them() {
    let place = Place::new("readme");
    place.small_experiment();
    place.write("genes.npy", npy(&vec![0.25; 20 * 18], &[20, 18]));
    let run = |arguments: &[&str]| {
        place.good(&[arguments, &["--backend", "cpu", "--quiet"]].concat());
    };
    let one = |out, more: &[&str]| {
        let own = [
            "run",
            "small.toml",
            "--seed",
            "7",
            "--set",
            "record.checkpoint_every=2",
            "--out",
            out,
        ];
        run(&[&own[..], more].concat());
        run(&["replay", out]);
        run(&["replay", out, "--seed", "5"]);
        if place.at(out).join("individuals.npy").exists() {
            run(&["replay", out, "--generations", "0,1"]);
        }
        contents::check(&place.at(out));
    };
    one("all", &["--set", "evolution.init=genes.npy"]);
    one(
        "few",
        &["--set", "evolution.finalists=0", "--set", "record.individuals=false"],
    );
    assert!(place.at("all/inputs").exists() && !place.at("few/individuals.npy").exists());

    place.write("swarm.toml", "[swarm]\nrobots = 2\nminutes = 12\n");
    run(&["run", "swarm.toml", "--seed", "7", "--out", "swarm"]);
    run(&["replay", "swarm"]);
    contents::check(&place.at("swarm"));

    let sweep = |name: &str, text: &str| {
        place.write(format!("{name}.toml"), text);
        for shard in ["1/2", "2/2"] {
            run(&["sweep", "run", &format!("{name}.toml"), "--out", name, "--shard", shard]);
        }
        place.good(&["sweep", "merge", name]);
        place.good(&["sweep", "report", name]);
        run(&["sweep", "extract", name, "0"]);
        contents::check(&place.at(name));
    };
    let grid =
        "[grid]\n\"evolution.parents, evolution.elite\" = [2, 4]\ncontroller.kind = [\"perceptron\", \"recurrent\"]\n";
    let reality = "[reality]\nrobots = [1]\nseverity = 1.0\n";
    sweep(
        "single",
        &format!("experiment = \"small.toml\"\nseeds = [1, 2]\n{grid}{reality}"),
    );
    sweep(
        "files",
        "experiment = \"small.toml\"\nseeds = [1, 2]\n[set]\nevolution.init = \"genes.npy\"\n",
    );
    assert!(place.at("files/sweep/genes.npy").exists());
    place.good(&["sweep", "merge", "files", "--out", "joined"]);
    assert!(place.at("joined/sweep/genes.npy").exists());
    let grid = "[grid]\nswarm.arena.radius_mm = [500, 600]\n";
    sweep(
        "swarms",
        &format!("experiment = \"swarm.toml\"\nseeds = [1, 2]\n{grid}"),
    );
    place.good(&["sweep", "merge", "single", "--out", "merged"]);
    let readme = place.text("merged/README.md");
    assert_eq!(readme, place.text("single/README.md"));
}

/// Directories of version 0.1.0: what is finished can be read, and what is not is refused by version and left as it is.
#[test]
fn directories_of_the_first_version() {
    let place = Place::new("first");
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/first");
    for name in ["finished", "stopped", "sweep"] {
        copy(&kept.join(name), &place.at(name));
    }

    assert!(place.good(&["list", "finished"]).contains("done"));
    place.good(&["verify", "finished"]);
    place.good(&["verify", "--recompute", "finished"]);
    let champion: Value = serde_json::from_str(&place.text("finished/champion.json")).unwrap();
    assert_eq!(
        place.answer(&["replay", "finished", "--json"])["bits"],
        champion["fitness_bits"]
    );
    place.good(&["evaluate", "--genomes", "finished"]);
    place.good(&["evaluate", "--best", "--genomes", "finished", "--trials", "2"]);

    place.run(&["resume", "stopped"]).exits(3).says(&[
        "its checkpoints were written by another version",
        "begin anew in another directory",
    ]);
    fs::copy(place.at("sweep/experiment/long.toml"), place.at("long.toml")).unwrap();
    fs::copy(place.at("sweep/sweep.toml"), place.at("sweep.toml")).unwrap();
    for arguments in [
        &["sweep", "run", "sweep.toml", "--out", "sweep", "--shard", "1/2"][..],
        &["sweep", "status", "sweep"],
        &["sweep", "merge", "sweep"],
    ] {
        place.run(arguments).exits(3).says(&[
            "is of version 1 of the format \"oneiro sweep\"; allowed: version 4",
            "begin again in another directory",
        ]);
    }
    for name in [
        "stopped/checkpoint-13",
        "stopped/generations.csv",
        "sweep/shard-1-of-2/checkpoint-0",
    ] {
        assert!(
            place.read(name) == fs::read(kept.join(name)).unwrap(),
            "{name} was changed"
        );
    }
}

/// Three robots behind a script in the place of ssh, one of whose computers is off: commands name it, end with 4, and with 0 where two
/// are enough.
#[cfg(unix)]
#[test]
fn a_fleet_is_planned_deployed_stopped_and_collected_without_a_robot_that_is_off() {
    let place = Place::new("fleet");
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap();
    let mut text = format!(
        "experiment = \"{root}/experiments/odowd2014-over.toml\"\nseed = 1\nkey = \"key\"\noperator = \"10.0.0.1:4711\"\n\
         binary = \"daemon\"\nservice = \"process\"\n[ssh]\nprogram = \"{root}/tests/fleet/ssh\"\noptions = [\"-F\", \"{own}\"]\n",
        root = root.display(),
        own = place.at("").display(),
    );
    for robot in 0..3 {
        let number = format!("number = {robot}\nhost = \"host-{robot}\"\nradio = \"10.0.0.1{robot}:4711\"");
        writeln!(text, "[[robots]]\n{number}\naddress = \"tcp:10.0.1.{robot}:1000\"").unwrap();
        fs::create_dir(place.at(format!("host-{robot}"))).unwrap();
    }
    place.write("fleet.toml", text);
    place
        .run(&["fleet", "plan", "fleet.toml"])
        .exits(3)
        .says(&["daemon: No such file"]);
    fs::copy("/bin/sh", place.at("daemon")).unwrap();
    place
        .run(&["fleet", "plan", "fleet.toml"])
        .exits(3)
        .says(&["key: No such file"]);
    place.run(&["fleet", "key", "key"]).exits(0).says(&["key: a new key"]);
    place
        .run(&["fleet", "key", "key"])
        .exits(3)
        .says(&["key: exists already"]);
    let plan = place.answer(&["fleet", "plan", "fleet.toml", "--json"]);
    assert_eq!(
        (&plan["minutes"], &plan["robot_minutes"]),
        (&Value::from(50), &Value::from(150.0))
    );
    assert_eq!(plan["robots"][2]["files"][3]["bytes"], 65);
    let text = place.good(&["fleet", "plan", "fleet.toml"]);
    assert!(
        text.contains("3 robots for 50 min, 150 robot-minutes")
            && text.contains("7 of the experiment's robots are absent"),
        "{text}"
    );
    assert!(!text.contains(place.text("key").trim()), "a key is never printed");
    place.write("host-1/.state", "down");
    let deployed = place.run(&["fleet", "deploy", "fleet.toml", "--json"]).exits(4);
    deployed.says(&["deploy: 1 of 3 robots failed"]);
    place
        .run(&["fleet", "deploy", "fleet.toml", "--min", "3"])
        .exits(4)
        .says(&["and --min asks for 3"]);
    let text = place.good(&["fleet", "deploy", "fleet.toml", "--min", "2"]);
    assert!(
        text.contains("1      host-1    FAILED: ssh: ") && text.contains("2      host-2    unchanged"),
        "{text}"
    );
    place.good(&["fleet", "deploy", "fleet.toml", "--robots", "0,2"]);
    place
        .run(&["fleet", "deploy", "fleet.toml", "--robots", "3"])
        .exits(2)
        .says(&["--robots 3: is not in the fleet; allowed: 0, 1, 2"]);
    for robot in ["0", "2"] {
        let state = format!("host-{robot}/oneiro/robot-{robot}/state");
        fs::create_dir(place.at(&state)).unwrap();
        place.write(
            format!("{state}/log.jsonl"),
            "{\"at_ms\":5,\"experiment_ms\":null,\"boot\":1,\"event\":\"end\",\"utc\":\"2026-01-01T00:00:00Z\",\"stopped\":true}\n",
        );
    }
    let text = place.run(&["fleet", "status", "fleet.toml"]).exits(4).stdout;
    assert!(
        text.contains("stopped; last event `end` at 2026-01-01T00:00:00Z"),
        "{text}"
    );
    let text = place.good(&["fleet", "stop", "fleet.toml", "--min", "2"]);
    assert!(text.contains("stopped, wheels confirmed"), "{text}");
    place
        .run(&["fleet", "collect", "fleet.toml", "--min", "2"])
        .exits(0)
        .says(&["robot 0, boot 1: was in contact with no other"]);
    assert_eq!(place.text("fleet/timeline.jsonl").lines().count(), 2);
    assert_eq!(place.text("fleet/clocks.csv").lines().count(), 3);

    place
        .run(&["fleet", "replay", "fleet.toml"])
        .exits(3)
        .says(&["statuses.csv: is missing"]);
    place.write(
        "fleet/statuses.csv",
        "second,robot,state,age_s,interval,s0,g0,g1,real,simulated,brought,carries,x,y,heading,volts,problems\n\
         7,2,living,0.5,0,0.25,0.5,0.75,1.5,,3,1,10,20,0.5,,\n",
    );
    let page = place.good(&["fleet", "replay", "fleet.toml"]);
    assert_eq!(page.trim(), "fleet/replay.html");
    let page = place.text("fleet/replay.html");
    assert!(
        page.contains("\"times\":[70]") && page.contains("3 e-pucks forage"),
        "{page}"
    );
    place
        .run(&["fleet", "replay", "fleet"])
        .exits(3)
        .says(&["fleet: has no twin.csv and robots/0.toml; allowed: a fleet's file, or the directory of a twin"]);
}
