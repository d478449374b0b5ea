//! `oneiro export`: of runs, of their files and of other genomes; of all shipped experiments; the page's program; a simulated Thymio II that
//! runs what is written for it; refusals.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use oneiro::foraging::Light;
use oneiro_lab::runs;
use oneiro_lab::runs::swarm::acting;

use crate::aseba::{FIRST_PORT, in_a_network, live, world};
use crate::exported::chips::compared_on_all;
use crate::exported::{Subject, compared_here};
use crate::place::Place;
use crate::skips::skipped;

/// An experiment whose run is quick.
const SMALL: &str = "cycles = 60\n[evolution]\npopulation = 20\nparents = 4\ngenerations = 2\n";

fn shipped(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments").join(name);
    path.canonicalize().unwrap().display().to_string()
}

/// What a file's check returns, or nothing without a compiler.
fn checked(place: &Place, file: &str, name: &str) -> Option<i32> {
    checked_by(place, file, &format!("{name}_check"))
}

/// The same of this function.
fn checked_by(place: &Place, file: &str, check: &str) -> Option<i32> {
    place.write(
        "main.c",
        format!("int {check}(void);\nint main(void)\n{{\n    return {check}();\n}}\n"),
    );
    compiled(
        place,
        &[
            "-Wall",
            "-Wextra",
            "-pedantic",
            "-Wconversion",
            "-Werror",
            "main.c",
            file,
        ],
    )
    .then(|| {
        let ended = Command::new(place.at("program")).status().unwrap();
        ended.code().unwrap()
    })
}

fn compiled(place: &Place, arguments: &[&str]) -> bool {
    let Ok(output) = Command::new("gcc")
        .args(["-O2", "-o", "program"])
        .args(arguments)
        .current_dir(place.at(""))
        .output()
    else {
        skipped("compilers", "exported controllers by gcc");
        return false;
    };
    let messages = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {messages}");
    // Another compiler has other warnings.
    if let Ok(output) = Command::new("clang")
        .arg("-fsyntax-only")
        .args(arguments)
        .current_dir(place.at(""))
        .output()
    {
        let messages = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "clang {arguments:?}: {messages}");
    }
    true
}

#[test]
fn a_run_names_its_champion() {
    let place = Place::new("run");
    place.write("small.toml", SMALL);
    place.evolved("small.toml", "3", "out", &[]);
    let said = place.run(&["export", "out", "--to", "c"]).exits(0);
    assert!(said.stdout.contains("wrote small.c: 8 inputs") || said.stderr.contains("wrote small.c: 8 inputs"));
    let text = place.text("small.c");
    // The same again is written already; another file is never overwritten.
    place.good(&["export", "out", "--to", "c"]);
    place
        .run(&["export", "out", "--to", "c", "--checks", "3"])
        .exits(3)
        .says(&["small.c", "exists"]);
    let done: serde_json::Value = serde_json::from_str(&place.text("out/DONE")).unwrap();
    let result = &done["result"].as_str().unwrap()[..16];
    assert!(text.contains(&format!(", the champion of the run with the result {result}\n")));
    assert!(text.contains("\n * Made by: oneiro export out --to c\n"));
    let is_of_origin = |line: &str| line.contains("Genome: ") || line.contains("Made by: ");
    // Its file and its genome are the same controller; only where they are from differs.
    let genome = |file: &str, name: &str| {
        place.good(&["export", file, "--to", "c", "--out", name, "--name", "small"]);
        let text = place.text(name);
        let lines = text.lines().filter(|line| !is_of_origin(line));
        lines.map(str::to_owned).collect::<Vec<_>>()
    };
    let of_run: Vec<_> = text.lines().filter(|line| !is_of_origin(line)).collect();
    assert_eq!(genome("out/champion.json", "file.c"), of_run);
    assert!(text.contains("left_90_to_left = ") && text.contains("small (with seed 3: "));
    if let Some(code) = checked(&place, "small.c", "small") {
        assert_eq!(code, 0);
        place.write("wrong.c", text.replacen(" + ", " - ", 1));
        assert_ne!(checked(&place, "wrong.c", "small"), Some(0));
    }
    let json = place.good(&[
        "export", "out", "--to", "c", "--out", "other.c", "--name", "other", "--json",
    ]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!([&json["cycles"], &json["checked"], &json["genes"]], [60, 16, 18]);
    // A program may include several, and have functions with the helpers' plain names.
    place.write(
        "both.c",
        "#include \"small.c\"\n#include \"other.c\"\n\nstatic int truncated(int x)\n{\n    return x;\n}\n\n\
         int main(void)\n{\n    return small_check() + truncated(other_check());\n}\n",
    );
    if compiled(&place, &["-Wall", "-Wextra", "-pedantic", "-Werror", "both.c"]) {
        assert!(Command::new(place.at("program")).status().unwrap().success());
    }
    assert_eq!(json["draws"], false);
}

/// Every target is written where it is told, or by the experiment's name, and nothing that exists is overwritten.
#[test]
fn every_target_is_written() {
    let place = Place::new("targets");
    place.write("small.toml", SMALL);
    place.evolved("small.toml", "3", "out", &[]);
    for (target, file) in [
        ("c", "small.c"),
        ("cpp", "small.hpp"),
        ("arduino", "small/src/small.h"),
        ("rust", "small.rs"),
        ("javascript", "small.mjs"),
        ("python", "small.py"),
        ("lua", "small.lua"),
        ("ros2", "small_ros2/small/controller.py"),
        ("onnx", "small.onnx"),
    ] {
        place.good(&["export", "out", "--to", target]);
        let text = String::from_utf8_lossy(&place.read(file)).into_owned();
        assert!(
            text.contains("small (with seed 3: ") && text.contains("left_90_to_left = "),
            "{file}"
        );
        let has_place = text.contains("@head@") || text.contains("@constants@");
        assert!(!has_place, "{file}");
        // The same again is there already.
        place.good(&["export", "out", "--to", target]);
        place
            .run(&["export", "out", "--to", target, "--checks", "3"])
            .exits(3)
            .says(&["small", "exists"]);
        // The folder of the library would hold the files of others.
        if target == "arduino" {
            fs::rename(place.at("small"), place.at(target)).unwrap();
        }
    }
    for target in ["argos", "webots"] {
        place
            .run(&["export", "out", "--to", target])
            .exits(3)
            .says(&["robot: was sampled", "allowed for", target]);
    }
    assert!(place.text("arduino/library.properties").starts_with("name=small\n"));
    place
        .run(&["export", "out", "--to", "arduino", "--out", "small.c"])
        .exits(3)
        .says(&["small.c", "is a file"]);
}

#[test]
fn what_cannot_be_exported_is_refused() {
    let place = Place::new("refused");
    place.write("small.toml", SMALL);
    place.write("other.csv", "left\n0.5\n");
    place.write("wrong.json", "{}");
    let refused = |code, arguments: &[&str], words: &[&str]| {
        place
            .run(&[&["export"][..], arguments].concat())
            .exits(code)
            .says(words);
    };
    refused(3, &["none", "--to", "c"], &["none"]);
    refused(2, &["small.toml"], &["--to", "missing; allowed: c (", "; lua ("]);
    refused(
        2,
        &["small.toml", "--to", "cobol"],
        &["cobol", "allowed: c (", "; lua ("],
    );
    refused(2, &["small.toml", "--to", "c"], &["small.toml", "--genome"]);
    refused(3, &["small.toml", "--to", "c", "--genome", "other.csv"], &["other.csv"]);
    refused(
        3,
        &["small.toml", "--to", "c", "--genome", "wrong.json"],
        &["wrong.json"],
    );
    refused(3, &["wrong.json", "--to", "c"], &[]);
    place.evolved("small.toml", "1", "out", &[]);
    for (target, name) in [
        ("c", "2b"),
        ("c", "int"),
        ("cpp", "class"),
        ("python", "struct"),
        ("ros2", "Robot"),
        ("ros2", "a__b"),
    ] {
        refused(
            2,
            &["out", "--to", target, "--name", name],
            &[name, target, "a letter first"],
        );
    }
    // An experiment's name may be such a word.
    place.write("int.toml", SMALL);
    place.evolved("int.toml", "1", "reserved", &[]);
    place.good(&["export", "reserved", "--to", "c"]);
    assert!(place.text("int_controller.c").contains("int_controller_step("));
    refused(3, &["out", "--to", "c", "--out", "small.txt"], &["ends in .c"]);
    refused(
        3,
        &["out", "--to", "c", "--number", "1"],
        &["--number: is 1; allowed: 0, as there is one robot"],
    );
    refused(2, &["out", "--to", "c", "--checks", "0"], &["from 1 to 1000"]);
    refused(
        2,
        &["out", "--to", "c", "--with", "motors"],
        &["motors", "sensors, task"],
    );
    refused(
        3,
        &["out", "--to", "python", "--with", "task"],
        &["--with: is not for python; allowed for: c"],
    );
    assert!(!place.at("small.c").exists());
}

/// The experiments that ship.
fn all_that_ship() -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| Path::new(name).extension().is_some_and(|extension| extension == "toml"))
        .filter(|name| name != "Cargo.toml")
        .collect();
    names.sort();
    assert!(names.len() > 30);
    names
}

/// Whether it is of the foraging study, whose robots' worlds are not printed.
fn is_of_study(name: &str) -> bool {
    name.starts_with("odowd2014")
}

/// Every controller that ships has its simulator's bits in an episode, and its file finds nothing that differs.
#[test]
fn all_experiments_that_ship_are_exported() {
    let place = Place::new("shipped");
    let is_long = std::env::var_os("ONEIRO_LONG").is_some();
    let names: Vec<_> = all_that_ship().into_iter().filter(|name| !is_of_study(name)).collect();
    let (mut cycles, mut episodes) = (0, 0);
    for (number, name) in names.iter().enumerate() {
        if !is_long && number % 4 != 1 && !name.starts_with("automode-a") {
            continue;
        }
        let out = format!("run-{number}");
        let mut set = vec!["evolution.generations=1", "evolution.finalists=0"];
        if name.starts_with("automode") {
            set.push("evolution.kind=random");
        }
        let set: Vec<&str> = set.iter().flat_map(|set| ["--set", set]).collect();
        place.evolved(&shipped(name), "1", &out, &set);
        let file = format!("taken_{number}.c");
        let json = place.good(&[
            "export",
            &out,
            "--to",
            "c",
            "--out",
            &file,
            "--checks",
            "1000",
            "--name",
            "taken",
            "--with",
            "sensors,task",
            "--json",
        ]);
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        cycles += json["cycles"].as_u64().unwrap();
        if let Some(code) = checked(&place, &file, "taken") {
            assert_eq!(code, 0, "{name}");
        }
        // Its world too, in a whole episode.
        let has_episode = place.text(&file).contains("int taken_check_world(void)");
        episodes += u32::from(has_episode);
        if has_episode && let Some(code) = checked_by(&place, &file, "taken_check_world") {
            assert_eq!(code, 0, "the world of {name}");
        }
    }
    println!("{cycles} cycles, {episodes} episodes");
    assert!(cycles > 2000 && episodes > 3);
}

/// All experiments that ship have their controllers' bits in 10,000 cycles, by all compilers and on all processors.
#[test]
#[ignore = "compiles 38 controllers by 17 compilers and for nine processors, 25 minutes: tests/long.sh runs it"]
fn all_that_ships_has_its_bits_on_every_processor() {
    const CYCLES: usize = 10_000;
    let subject = |name: &String| {
        let path = shipped(name);
        let experiment = runs::read(Path::new(&path), &[]).unwrap();
        let own = name.trim_end_matches(".toml").replace(['-', '.'], "_");
        if let Some(study) = experiment.swarm() {
            let world = acting::simulator(study, Light::OppositeNest).unwrap();
            return Subject::new(own, &world, &[0.9, 0.4], 0, CYCLES);
        }
        let single = experiment.single().unwrap();
        let genome = single.random_genomes(1, 1);
        Subject::new(own, single.world(), genome.values(), 0, CYCLES)
    };
    let subjects: Vec<_> = all_that_ship().iter().map(subject).collect();
    compared_here("shipped", &subjects);
    compared_on_all("shipped", &subjects, CYCLES);
}

/// The cycles that a file checks are those that fused products would change, if any are.
#[test]
fn a_file_finds_fused_products_wherever_they_matter() {
    #[cfg(target_arch = "x86_64")]
    if !std::arch::is_x86_feature_detected!("fma") {
        skipped("fma", "exported controllers with fused products");
        return;
    }
    if Command::new("clang").arg("--version").output().is_err() {
        skipped("compilers", "exported controllers with fused products by clang");
        return;
    }
    let place = Place::new("fused");
    let quick = ["--set", "evolution.generations=1", "--set", "evolution.finalists=0"];
    place.evolved(
        &shipped("odowd2014-over.toml"),
        "1",
        "foragers",
        &["--set", "swarm.minutes=2"],
    );
    place.evolved(
        &shipped("automode-aggregation.toml"),
        "1",
        "machine",
        &[&quick[..], &["--set", "evolution.kind=random"]].concat(),
    );
    place.evolved(&shipped("khepera-avoidance.toml"), "1", "perceptron", &quick);
    let robots: Vec<String> = (0..10).map(|robot| robot.to_string()).collect();
    let foragers = robots.iter().map(|robot| ("foragers", &**robot));
    let mut found = 0;
    for (run, robot) in foragers.chain([("machine", "0"), ("perceptron", "0")]) {
        let file = format!("{run}_{robot}.c");
        place.good(&[
            "export", run, "--to", "c", "--out", &file, "--name", "own", "--number", robot,
        ]);
        place.write(
            "main.c",
            format!("#include \"{file}\"\nint main(void)\n{{\n    return own_check();\n}}\n"),
        );
        let checked = |options: &[&str]| {
            let fma: &[&str] = if cfg!(target_arch = "x86_64") { &["-mfma"] } else { &[] };
            let mut command = Command::new("clang");
            command.args(["-O2", "-o", "program", "main.c"]).args(fma).args(options);
            assert!(command.current_dir(place.at("")).status().unwrap().success());
            Command::new(place.at("program")).status().unwrap().code().unwrap()
        };
        assert_eq!(checked(&[]), 0, "{file}");
        assert_ne!(checked(&["-ffp-contract=fast"]), 0, "{file}");
        found += 1;
    }
    assert_eq!(found, 12);
}

/// A run of the foraging study has a controller for each robot and interval, chosen by numbers.
#[test]
fn a_foraging_run_has_controllers_too() {
    let place = Place::new("foraging");
    let experiment = shipped("odowd2014-over.toml");
    place.evolved(&experiment, "1", "out", &["--set", "swarm.minutes=3"]);
    let mut table = csv::Reader::from_path(place.at("out/intervals.csv")).unwrap();
    let head = table.headers().unwrap().clone();
    let rows: Vec<_> = table.records().map(|row| row.unwrap()).collect();
    let genes = |robot: usize, interval: usize| {
        let row = rows
            .iter()
            .find(|row| row[0] == interval.to_string() && row[1] == robot.to_string());
        let row = row.unwrap();
        let value = |name: &str| row[head.iter().position(|column| column == name).unwrap()].to_owned();
        [value("g0"), value("g1")]
    };
    for (options, robot, interval) in [
        (&[][..], 0, 2),
        (&["--number", "9"], 9, 2),
        (&["--number", "4", "--interval", "0"], 4, 0),
    ] {
        let file = format!("own_{robot}.c");
        let arguments = [
            &["export", "out", "--to", "c", "--name", "own", "--out", &file],
            options,
        ]
        .concat();
        let said = place.run(&arguments).exits(0);
        assert!(
            said.stderr
                .contains("13 inputs; it has the simulator's bits in 600 cycles"),
            "{}",
            said.stderr
        );
        let text = place.text(&file);
        let [with_food, without_food] = genes(robot, interval);
        assert!(
            text.contains(&format!(
                "with_food = {with_food}\n *   without_food = {without_food}\n"
            )),
            "{text}"
        );
        assert!(text.contains(&format!("out, robot {robot} in interval {interval}, fitness ")));
        assert!(
            text.contains("), of the run with the result ") && text.contains("carries, 1 if the robot carries food")
        );
        if let Some(code) = checked(&place, &file, "own") {
            assert_eq!(code, 0, "{file}");
        }
    }
    let refused = |arguments: &[&str], words: &[&str]| {
        place.run(&[&["export"], arguments].concat()).exits(3).says(words);
    };
    refused(
        &["out", "--to", "c", "--number", "10"],
        &["--number: is 10; allowed: 0 to 9"],
    );
    refused(
        &["out", "--to", "c", "--interval", "3"],
        &["--interval: is 3; allowed: 0 to 2"],
    );
    refused(
        &["out", "--to", "c", "--with", "task"],
        &["--with: the world of out, ", " is of foragers"],
    );
    for target in ["argos", "webots"] {
        refused(&["out", "--to", target], &["is a forager", "allowed for", target]);
    }
    place.good(&["export", "out", "--to", "ros2", "--name", "robot"]);
    let node = place.text("robot_ros2/robot/node.py");
    assert!(
        node.contains("\"wheel_base_m\", 0.053)") && node.contains("\"full_speed_m_s\", 0.1288"),
        "{node}"
    );
    // Another genome, for a run or an experiment.
    place.write("genes.csv", "with_food,without_food\n0.99,0.5\n");
    for subject in ["out", &experiment] {
        let file = format!("other_{}.c", subject.len());
        place.good(&["export", subject, "--genome", "genes.csv", "--to", "c", "--out", &file]);
        assert!(place.text(&file).contains("with_food = 0.99\n"));
        place
            .run(&[
                "export",
                subject,
                "--genome",
                "genes.csv",
                "--to",
                "c",
                "--interval",
                "1",
            ])
            .exits(2)
            .says(&["--interval: is given for "]);
    }
    refused(
        &[&experiment, "--genome", "genes.csv", "--to", "c", "--number", "1"],
        &["--number"],
    );
    place.evolved(
        &shipped("odowd2014-random.toml"),
        "1",
        "random",
        &["--set", "swarm.minutes=3"],
    );
    refused(&["random", "--to", "c"], &["random", "nothing evolves"]);
    place.write("small.toml", SMALL);
    place.evolved("small.toml", "3", "single", &[]);
    place
        .run(&["export", "single", "--to", "c", "--interval", "1"])
        .exits(2)
        .says(&["--interval: is given for a run that has a champion"]);
}

/// The cycles and the world are those of `--trial`, where starts differ from trial to trial.
#[test]
fn another_trial_begins_elsewhere() {
    let place = Place::new("trials");
    let set = ["--set", "evolution.generations=1", "--set", "evolution.finalists=0"];
    place.evolved(&shipped("five-starts.toml"), "1", "out", &set);
    let table = place.good(&[
        "evaluate",
        "--genomes",
        "out",
        "--seed",
        "7",
        "--trials",
        "7",
        "--traces",
        "traces",
    ]);
    // Each of five worlds has a start, in turns.
    assert!(table.starts_with("genome,trial,fitness,bits,world\n"), "{table}");
    let mut starts = Vec::new();
    for (trial, row) in table.lines().skip(1).enumerate() {
        assert!(row.ends_with(&format!(",{}", trial % 5)), "{row}");
        let trace = place.text(format!("traces/trace-0-{trial}.csv"));
        let first = trace.lines().nth(1).unwrap().split(',').skip(1).take(3);
        starts.push(first.collect::<Vec<_>>().join(","));
    }
    assert_eq!((&starts[0], &starts[1]), (&starts[5], &starts[6]));
    assert!(starts[0] != starts[1] && starts[1] != starts[4]);
    let mut all = std::collections::BTreeSet::new();
    for trial in ["0", "1", "3"] {
        let file = format!("trial_{trial}.c");
        let options = [
            "--name",
            "own",
            "--seed",
            "7",
            "--trial",
            trial,
            "--with",
            "sensors,task",
        ];
        place.good(&[&["export", "out", "--to", "c", "--out", &file][..], &options].concat());
        let row = table
            .lines()
            .find(|line| line.starts_with(&format!("0,{trial},")))
            .unwrap();
        let bits = row.split(',').nth(3).unwrap();
        assert!(place.text(&file).contains(&format!("!= 0x{bits}u")), "{trial}: {bits}");
        all.insert(bits.to_owned());
        if let Some(code) = checked_by(&place, &file, "own_check_world") {
            assert_eq!(code, 0, "{trial}");
        }
    }
    assert_eq!(all.len(), 3);
}

/// The program on the page compiles and runs.
#[test]
fn the_page_is_right() {
    let place = Place::new("page");
    let page = include_str!("../../docs/export.md");
    let (_, program) = page.split_once("```c\n").unwrap();
    let (program, _) = program.split_once("```").unwrap();
    place.evolved(
        &shipped("khepera-avoidance.toml"),
        "1",
        "runs/khepera-avoidance-1",
        &["--set", "evolution.generations=1"],
    );
    place.good(&["export", "khepera-avoidance-1", "--to", "c"]);
    place.write("robot.c", program);
    if compiled(
        &place,
        &["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "robot.c"],
    ) {
        let output = Command::new(place.at("program")).output().unwrap();
        assert!(output.status.success());
        let speeds = String::from_utf8(output.stdout).unwrap();
        let speeds: Vec<f64> = speeds.split_whitespace().map(|speed| speed.parse().unwrap()).collect();
        assert!(
            speeds.len() == 2 && speeds.iter().all(|speed| speed.abs() <= 1.0),
            "{speeds:?}"
        );
    }
}

/// The cycles of an episode's trace: the readings of the sensors with these names, and the two outputs.
fn traced(place: &Place, experiment: &str, champion: &str, sensors: &[String]) -> Vec<(Vec<f32>, [f32; 2])> {
    let traces = format!("traces-of-{}", champion.replace('/', "-"));
    let shown = ["--trials", "1", "--seed", "1", "--traces", &traces];
    place.good(&[&["evaluate", experiment, "--genomes", champion], &shown[..]].concat());
    let files = fs::read_dir(place.at(&traces))
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let trace = files
        .into_iter()
        .find(|path| path.to_str().unwrap().ends_with("trace.csv") || path.to_str().unwrap().contains("trace-"));
    let mut table = csv::Reader::from_path(trace.expect("a trace")).unwrap();
    let head = table.headers().unwrap().clone();
    let column = |name: &str| {
        let found = head.iter().position(|column| column == name);
        found.unwrap_or_else(|| panic!("{name} of {head:?}"))
    };
    let places: Vec<_> = sensors.iter().map(|name| column(&format!("sensor_{name}"))).collect();
    let outputs = ["output_left", "output_right"].map(column);
    let rows = table.records().map(|row| {
        let row = row.unwrap();
        let number = |column: usize| row[column].parse().unwrap();
        (places.iter().map(|place| number(*place)).collect(), outputs.map(number))
    });
    rows.collect()
}

/// The example of a firmware, in an emulated STM32F4 at the end of a serial line, drives in step with the simulator: all bits of an episode.
#[test]
fn firmware_drives_in_step_with_the_simulator() {
    let place = Place::new("firmware");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware");
    for file in fs::read_dir(folder).unwrap() {
        let path = file.unwrap().path();
        place.write(path.file_name().unwrap().to_str().unwrap(), fs::read(&path).unwrap());
    }
    place.write("robot.toml", thymio(NETWORKS[1]));
    place.evolved("robot.toml", "1", "run", &[]);
    let exported = place.good(&["export", "run", "--to", "c", "--out", "robot.c", "--json"]);
    let exported: serde_json::Value = serde_json::from_str(&exported).unwrap();
    let names = |input: &serde_json::Value| input.as_str().unwrap().to_owned();
    let inputs: Vec<String> = exported["inputs"].as_array().unwrap().iter().map(names).collect();
    let missing = ["make", "arm-none-eabi-gcc", "qemu-system-arm"];
    let missing = missing
        .iter()
        .find(|tool| Command::new(tool).arg("--version").output().is_err());
    if let Some(tool) = missing {
        skipped("microcontrollers", &format!("firmware, for want of {tool}"));
        return;
    }
    let made = Command::new("make")
        .arg("CONTROLLER=robot.c")
        .current_dir(place.at(""))
        .output()
        .unwrap();
    let messages = String::from_utf8_lossy(&made.stderr).into_owned();
    assert!(made.status.success() && !messages.contains("warning"), "{messages}");
    let mut robot = Command::new("qemu-system-arm")
        .args([
            "-M",
            "netduinoplus2",
            "-nographic",
            "-monitor",
            "none",
            "-serial",
            "stdio",
            "-kernel",
            "firmware.elf",
        ])
        .current_dir(place.at(""))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let (mut to, from) = (robot.stdin.take().unwrap(), robot.stdout.take().unwrap());
    let mut lines = BufReader::new(from).lines();
    let mut answer = || lines.next().unwrap().unwrap();
    assert_eq!(answer(), "check 0");
    let words = |numbers: &[f32]| {
        let words: Vec<_> = numbers
            .iter()
            .map(|number| format!("{:08x}", number.to_bits()))
            .collect();
        words.join(" ")
    };
    let cycles = traced(&place, "robot.toml", "run/champion.json", &inputs);
    assert!(cycles.len() > 20);
    for (cycle, (readings, outputs)) in cycles.iter().enumerate() {
        writeln!(to, "{}", words(readings)).unwrap();
        let answer = answer();
        assert_eq!(answer[..17], words(outputs), "cycle {cycle}");
    }
    // Any other line stops the wheels.
    for line in ["3f000000", "zz", ""] {
        writeln!(to, "{line}").unwrap();
        assert_eq!(answer(), "3f000000 3f000000 00000000 00000000");
    }
    robot.kill().unwrap();
    robot.wait().unwrap();
}

/// A Thymio II with a network.
fn thymio(network: &str) -> String {
    format!(
        "cycles = 30\n[robot]\npreset = 'thymio2'\n[arena]\nwidth_mm = 1000.0\nheight_mm = 1000.0\n{network}\n\
         [evolution]\npopulation = 8\nparents = 2\ngenerations = 1\n"
    )
}

const NETWORKS: [&str; 4] = [
    "",
    "[controller]\nkind = 'network'\nactivation = 'tanh'\n[[controller.layers]]\nkind = 'elman'\nunits = 4\nactivation = 'tanh'\nslope = 0.5",
    "[controller]\nkind = 'network'\nactivation = 'linear'\nslope = 0.2\n[[controller.layers]]\nunits = 3\nactivation = 'relu'\nbiases = false",
    "[controller]\nkind = 'recurrent'",
];

/// Aseba's compiler and its bridge to the web, for a robot of the playground.
struct Bridge(Child);

impl Bridge {
    const PORT: u16 = 35000;

    /// `place` gets the locale that the compiler asks for by its name.
    fn start(place: &Place) -> Self {
        let locale = place.at("en_US.UTF-8");
        let mut made = Command::new("localedef");
        let made = made.args(["-i", "en_US", "-f", "UTF-8"]).arg(&locale).output();
        assert!(locale.exists(), "tests/tools.sh installs the package locales: {made:?}");
        let process = Command::new("asebahttp")
            .args(["-p", &Self::PORT.to_string(), "-s", "35001"])
            .arg(format!("tcp:host=127.0.0.1;port={FIRST_PORT}"))
            .env("LOCPATH", locale.parent().unwrap())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        let bridge = Self(process.unwrap());
        let start = Instant::now();
        while !Bridge::ask("GET", "nodes", "").contains("thymio-II") {
            assert!(start.elapsed() < Duration::from_secs(20), "the bridge does not start");
            thread::sleep(Duration::from_millis(50));
        }
        bridge
    }

    /// The body of an answer.
    fn ask(method: &str, path: &str, body: &str) -> String {
        let Ok(mut stream) = TcpStream::connect(("127.0.0.1", Self::PORT)) else {
            return String::new();
        };
        stream.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
        write!(
            stream,
            "{method} /{path} HTTP/1.1\r\nHost: robot\r\nConnection: close\r\nContent-Length: {}\r\n\r\n{body}",
            body.len()
        )
        .unwrap();
        let (mut answer, mut piece) = (Vec::new(), [0; 4096]);
        loop {
            let text = String::from_utf8_lossy(&answer).into_owned();
            if let Some((head, found)) = text.split_once("\r\n\r\n") {
                let length = head.lines().find_map(|line| line.strip_prefix("Content-Length: "));
                if found.len() >= length.map_or(usize::MAX, |length| length.trim().parse().unwrap()) {
                    return found.to_owned();
                }
            }
            match stream.read(&mut piece) {
                Ok(count) if count > 0 => answer.extend_from_slice(&piece[..count]),
                _ => {
                    return text
                        .split_once("\r\n\r\n")
                        .map_or_else(String::new, |(_, found)| found.to_owned());
                }
            }
        }
    }

    /// A variable of the robot's, once it is as wanted.
    fn variable(name: &str, is_wanted: impl Fn(&[i64]) -> bool) -> Vec<i64> {
        let start = Instant::now();
        loop {
            let text = Self::ask("GET", &format!("nodes/thymio-II/{name}"), "");
            if let Ok(numbers) = serde_json::from_str::<Vec<i64>>(&text)
                && is_wanted(&numbers)
            {
                return numbers;
            }
            assert!(start.elapsed() < Duration::from_secs(10), "{name}: {text}");
        }
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// In Aseba's own virtual machine, the outputs are as near the simulator's as the file says.
#[test]
fn a_thymio_computes_what_its_program_says() {
    if !in_a_network(
        "a_thymio_computes_what_its_program_says",
        "programs of a Thymio II in Aseba's simulator",
    ) {
        return;
    }
    let robot = format!(
        "<robot type=\"thymio2\" x=\"60\" y=\"60\" angle=\"0\" port=\"{FIRST_PORT}\" name=\"r1\" nodeId=\"1\"/>"
    );
    live(&world(120.0, 120.0, &robot), 1, 1, |_| {
        let place = Place::new("thymio");
        let _bridge = Bridge::start(&place);
        for (number, network) in NETWORKS.iter().enumerate() {
            let (file, run) = (format!("robot-{number}.toml"), format!("run-{number}"));
            place.write(&file, thymio(network));
            place.evolved(&file, "1", &run, &[]);
            let program = format!("robot-{number}.aesl");
            place.good(&["export", &run, "--to", "aseba", "--out", &program]);
            let text = place.text(&program);
            let (_, stated) = text.split_once("at most ").expect("it says how near it is");
            let stated: f64 = stated.split(' ').next().unwrap().parse().unwrap();
            assert!(stated > 0.0 && stated < 0.02, "{network}: {stated}");
            // The readings are given, and the robot stays where it is.
            let text = text
                .replace("prox.horizontal[", "near[")
                .replace("prox.ground.delta[", "grey[")
                .replace("motor.left.target", "speeds[0]")
                .replace("motor.right.target", "speeds[1]")
                .replace("onevent prox", "onevent next\n    done = done + 1")
                .replace(
                    "\nvar one =",
                    "\nvar near[7]\nvar grey[2]\nvar speeds[2]\nvar done = 0\nvar one =",
                )
                .replacen("<node ", "<event size=\"0\" name=\"next\"/>\n<node ", 1);
            assert_eq!(Bridge::ask("PUT", "nodes/thymio-II", &text), "", "{network}");
            Bridge::variable("done", |done| done == [0]);
            // An episode's readings, in the robot's units, and the commands for them.
            let sensors = (0..7).map(|sensor| format!("prox_{sensor}"));
            let sensors: Vec<_> = sensors
                .chain(["ground_left", "ground_right"].map(str::to_owned))
                .collect();
            let cycles = traced(&place, &file, &format!("{run}/champion.json"), &sensors);
            let mut farthest = 0.0_f64;
            for (cycle, (readings, outputs)) in cycles.iter().enumerate() {
                let (near, grey) = readings.split_at(7);
                for (name, most, readings) in [("near", 4500.0, near), ("grey", 1024.0, grey)] {
                    let set = |path, reading: &f32| format!("{path}/{}", (most * reading).round());
                    Bridge::ask("GET", &readings.iter().fold(format!("nodes/thymio-II/{name}"), set), "");
                }
                Bridge::ask("GET", "nodes/thymio-II/next", "");
                Bridge::variable("done", |done| done == [cycle as i64 + 1]);
                let speeds = Bridge::variable("speeds", |_| true);
                for (speed, output) in speeds.iter().zip(outputs) {
                    farthest = farthest.max((0.5 + *speed as f64 / 1000.0 - f64::from(*output)).abs());
                }
            }
            // A reading and a speed are each a whole number.
            assert!(farthest < stated + 0.003, "{network}: {farthest}, stated {stated}");
        }
    });
}

/// A written world ends an episode by itself, not when the controller would end it.
#[test]
fn a_controller_that_ends_episodes_has_no_world() {
    let place = Place::new("export-end");
    let controller = "const CONTROLLER_GENES: u32 = INPUTS;
        struct ControllerState { cycles: u32 }
        fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
            return Command(vec2<f32>(logistic(weighed(episode, 0u, readings)), 0.5), ControllerState(before.cycles + 1u));
        }
        fn controller_ends(episode: Episode, memory: ControllerState) -> bool { return memory.cycles == 9u; }";
    place.write("ends.wgsl", controller);
    place.write(
        "ends.toml",
        "cycles = 20\ncontroller.kind = \"own\"\ncontroller.part = \"ends.wgsl\"\n",
    );
    place.write("genes.json", format!("{{\"genome\": [{}]}}", ["0.5"; 8].join(", ")));
    let export = ["export", "ends.toml", "--genome", "genes.json", "--to", "c", "--out"];
    place.good(&[&export[..], &["alone.c"]].concat());
    let words = "has `controller_ends`, while a written world ends by itself; allowed: the controller alone";
    place
        .run(&[&export[..], &["both.c", "--with", "sensors,task"]].concat())
        .exits(3)
        .says(&[words]);
}
