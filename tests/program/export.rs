//! `oneiro export`: of runs, of their files and of other genomes; of all shipped experiments; the page's program; refusals.

use std::fs;
use std::path::Path;
use std::process::Command;

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
    place.write(
        "main.c",
        format!("int {name}_check(void);\nint main(void)\n{{\n    return {name}_check();\n}}\n"),
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
    // Its file and its genome are the same controller; only where they are from differs.
    let genome = |file: &str, name: &str| {
        place.good(&["export", file, "--to", "c", "--out", name, "--name", "small"]);
        let text = place.text(name);
        let lines = text.lines().filter(|line| !line.contains("Genome: "));
        lines.map(str::to_owned).collect::<Vec<_>>()
    };
    let of_run: Vec<_> = text.lines().filter(|line| !line.contains("Genome: ")).collect();
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
        ("ros2", "small/small/controller.py"),
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
        // An ONNX model has no checks.
        place
            .run(&["export", "out", "--to", target, "--checks", "3"])
            .exits(if target == "onnx" { 0 } else { 3 })
            .says(if target == "onnx" { &[] } else { &["small", "exists"] });
        // Each target in a folder of its own.
        if !file.starts_with("small.") {
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
    refused(2, &["out", "--to", "c", "--name", "2b"], &["2b", "a letter first"]);
    refused(3, &["out", "--to", "c", "--out", "small.txt"], &["ends in .c"]);
    refused(
        3,
        &["out", "--to", "c", "--number", "1"],
        &["robot: is 1; allowed: 0 to 0"],
    );
    refused(2, &["out", "--to", "c", "--checks", "0"], &["from 1 to 1000"]);
    assert!(!place.at("small.c").exists());
}

/// Every controller that ships has its simulator's bits in an episode, and its file finds nothing that differs.
#[test]
fn all_experiments_that_ship_are_exported() {
    let place = Place::new("shipped");
    let is_long = std::env::var_os("ONEIRO_LONG").is_some();
    let mut names: Vec<String> = fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        // The foraging study's controllers are behaviours.
        .filter(|name| Path::new(name).extension().is_some_and(|extension| extension == "toml"))
        .filter(|name| !name.starts_with("odowd2014") && name != "Cargo.toml")
        .collect();
    names.sort();
    assert!(names.len() > 20);
    let mut cycles = 0;
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
            "export", &out, "--to", "c", "--out", &file, "--checks", "1000", "--name", "taken", "--json",
        ]);
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        cycles += json["cycles"].as_u64().unwrap();
        if let Some(code) = checked(&place, &file, "taken") {
            assert_eq!(code, 0, "{name}");
        }
    }
    println!("{cycles} cycles");
    assert!(cycles > 2000);
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
