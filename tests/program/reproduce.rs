//! `oneiro robot sample` and `oneiro reproduce` as programs: the same bytes on every device and after any stop, and their
//! refusals.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::place::{Place, Ran};
use crate::skips::skipped;

/// How often a study is killed, at moments that divide it into equal parts.
const KILLS: u32 = 2;

/// Whether more than a few seconds are available: in `tests/long.sh`.
fn is_long() -> bool {
    std::env::var_os("ONEIRO_LONG").is_some()
}

impl Place {
    /// Samples a robot into a directory with that name.
    fn sample(&self, out: &str, more: &[&str]) -> Ran {
        self.run(&[&["robot", "sample", "--backend", "cpu", "--out", out], more].concat())
    }

    /// Starts a command and kills it after a while.
    #[cfg(unix)]
    fn kill_after(&self, time: Duration, arguments: &[&str]) {
        let mut command = self.command(arguments);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(time);
        child.kill().unwrap();
        child.wait().unwrap();
    }

    /// Writes a shorter study of 1995 and names it; `tests/long.sh` takes the whole one.
    fn short_study(&self) -> &'static [&'static str] {
        if is_long() {
            return &[];
        }
        let experiments = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments");
        let mut study = fs::read_to_string(experiments.join("miglino1995/study.toml")).unwrap();
        let path = experiments.join("khepera-avoidance.toml");
        for (old, new) in [
            ("\"../khepera-avoidance.toml\"", format!("\"{}\"", path.display())),
            ("\n[set]\n", "\n[set]\nevolution.generations = 10\n".to_owned()),
            ("\ngenerations = 20\n", "\ngenerations = 3\n".to_owned()),
        ] {
            assert_eq!(study.matches(old).count(), 1, "{old}");
            study = study.replace(old, &new);
        }
        self.write("short.toml", study);
        &["--study", "short.toml"]
    }

    /// All files below a directory, with their bytes.
    fn files(&self, directory: &str) -> Vec<(PathBuf, Vec<u8>)> {
        fn collect(root: &Path, at: &Path, files: &mut Vec<(PathBuf, Vec<u8>)>) {
            for entry in fs::read_dir(at).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    collect(root, &path, files);
                } else {
                    files.push((path.strip_prefix(root).unwrap().to_owned(), fs::read(&path).unwrap()));
                }
            }
        }
        let mut files = Vec::new();
        let root = self.at(directory);
        collect(&root, &root, &mut files);
        files.sort();
        files
    }

    fn assert_same_files(&self, one: &str, other: &str) {
        let (one, other) = (self.files(one), self.files(other));
        let names = |files: &[(PathBuf, Vec<u8>)]| files.iter().map(|(path, _)| path.clone()).collect::<Vec<_>>();
        assert_eq!(names(&one), names(&other));
        for ((path, one), (_, other)) in one.iter().zip(&other) {
            assert!(one == other, "{} differs", path.display());
        }
    }
}

#[test]
fn a_sampled_robot_is_one_that_runs_take() {
    let place = Place::new("sample");
    place.sample("seven", &["--robot", "surrogate:7", "--quiet"]).exits(0);
    place.good(&["robot", "tables", "show", "seven/wall.sam"]);
    let motors = place.text("seven/motor.sam");
    assert_eq!(motors.lines().count(), 42, "21 speeds, turns and displacements");
    place.good(&["new", "own"]);
    let tables = "robot.tables=[\"seven/wall.sam\",\"seven/round.sam\"]";
    let motors = "robot.motors=\"seven/motor.sam\"";
    place.good(&["check", "own.toml", "--set", tables, "--set", motors]);

    // The same on one thread as on all, and different for another robot.
    place
        .sample("again", &["--robot", "surrogate:7", "--threads", "1"])
        .exits(0);
    place.assert_same_files("seven", "again");
    place.sample("eight", &["--robot", "surrogate:8"]).exits(0);
    assert_ne!(place.files("seven"), place.files("eight"));
}

/// An experiment that names a surrogate has the tables that the command writes, and its runs keep them.
#[test]
fn a_surrogates_tables_are_those_that_are_sampled() {
    let place = Place::new("block");
    let experiments = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments");
    let objects = "wall,round,block";
    place
        .sample("one", &["--robot", "surrogate:1", "--objects", objects])
        .exits(0);
    let experiment = experiments.join("khepera-block.toml");
    let short = [
        "--set",
        "evolution.generations=3",
        "--set",
        "cycles=100",
        "--seed",
        "1",
        "--backend",
        "cpu",
    ];
    let arguments = ["run", experiment.to_str().unwrap(), "--out", "run"];
    place.good(&[&arguments[..], &short].concat());
    for name in ["wall.sam", "round.sam", "block.sam", "motor.sam"] {
        assert!(
            place.read(format!("run/inputs/{name}")) == place.read(format!("one/{name}")),
            "{name}"
        );
    }
}

#[test]
fn invalid_samplings_are_refused() {
    let place = Place::new("refused");
    for (arguments, words) in [
        (
            ["--robot", "khepera:1"],
            "or surrogate:SEED for a simulated Khepera, or FILE.toml",
        ),
        (
            ["--robot", "surrogate:x"],
            "`x` is no seed; allowed: whole numbers from 0",
        ),
        (["--severity", "3"], "--severity: is 3; allowed: a number from 0 to 2"),
        (["--objects", "wall,cube"], "allowed: wall, round"),
        (["--objects", "wall,wall"], "is given twice"),
    ] {
        place.sample("none", &arguments).exits(3).says(&[words]);
    }
    place.sample("one", &["--quiet"]).exits(0);
    place
        .sample("one", &["--robot", "surrogate:2"])
        .exits(3)
        .says(&["holds samples of another robot"]);
}

#[test]
fn invalid_studies_are_refused() {
    let place = Place::new("studies");
    fs::create_dir(place.at("full")).unwrap();
    place.write("full/own.txt", "mine");
    place.write("wall.sam", "8 180 20 5 2\n");
    for (arguments, words) in [
        (
            &["--severity=-1"][..],
            "--severity: is -1; allowed: a number from 0 to 2",
        ),
        (&["--robot", "mine"], "or surrogate:SEED for a simulated Khepera"),
        (
            &["--out", "full"],
            "full: exists and holds other files, and nothing is overwritten",
        ),
        (
            &["--arm", "severity-1", "--severity", "1.75"],
            "--severity 1.75: is given with --arm severity-1, which sets it; allowed: one of the two",
        ),
        (&["--tables", "wall.sam,none.sam"], "wall.sam"),
        (&["--tables", "none.sam"], "none.sam"),
    ] {
        let mut all = vec!["reproduce", "miglino1995", "--backend", "cpu"];
        all.extend(arguments);
        place.run(&all).exits(3).says(&[words]);
    }
    assert_eq!(place.text("full/own.txt"), "mine");
    for runs in ["0", "1", "1001"] {
        place
            .run(&["reproduce", "miglino1995", "--runs", runs, "--out", "few"])
            .exits(3)
            .says(&["allowed: 2 to 1000"]);
        assert!(!place.at("few").exists(), "nothing was begun");
    }
}

/// Arms belong to an edition, and a file without an edition's values does not have it.
#[test]
fn editions_have_their_arms() {
    let place = Place::new("editions");
    let reproduce = |more: &[&str]| place.run(&[&["reproduce", "miglino1995", "--out", "none"], more].concat());
    reproduce(&["--arm", "square"]).exits(2).says(&[
        "--arm square: is an arm of the first edition; allowed: --edition first, or of the second: main, undo, keep-turn",
    ]);
    reproduce(&["--edition", "first", "--arm", "undo"]).exits(2).says(&[
        "--arm undo: is an arm of the second edition; allowed: --edition second, or of the first: main, square",
    ]);
    let experiments = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments");
    let study = fs::read_to_string(experiments.join("miglino1995/study.toml")).unwrap();
    let study = study.replace("experiment = \"../khepera-avoidance.toml\"", "");
    place.write("own.toml", study.replace("[editions.first]", "[editions.zeroth]"));
    reproduce(&["--study", "own.toml", "--edition", "first"])
        .exits(3)
        .says(&[
            "own.toml",
            "editions.first: is missing; allowed: a table, as in the shipped file",
        ]);
    let listed = |edition| {
        let ran = place
            .run(&["reproduce", "miglino1995", "--arm", "list", "--edition", edition])
            .exits(0);
        ran.stdout.lines().count()
    };
    assert_eq!((listed("first"), listed("second")), (1 + 1 + 41, 1 + 1 + 5));
    assert!(!place.at("none").exists(), "nothing was begun");
}

/// What only a surrogate has, and what a robot on a wire needs, is said before anything is connected or begun.
#[test]
fn studies_that_a_wire_can_not_have_are_refused() {
    const ROBOT: &str = "serial:/dev/none@9600";
    let place = Place::new("wire");
    place.sample("own", &["--quiet"]).exits(0);
    let tables = "--tables=own/wall.sam,own/round.sam,own/motor.sam";
    for (arguments, code, words) in [
        (
            &[][..],
            3,
            "lacks --tables, the samples that its simulator is made from; take them with `oneiro robot sample --robot \
             serial:/dev/none@9600 --objects wall,round --out samples`",
        ),
        (
            &[tables, "--severity=1"],
            3,
            "--severity: is given with --robot serial:",
        ),
        (&[tables, "--full"], 3, "--full: is given with --robot serial:"),
        (
            &[tables, "--sensitivity"],
            3,
            "--sensitivity: is given with --robot serial:",
        ),
        (
            &["--calibrate"],
            2,
            "'--robot <ROBOT>' cannot be used with '--calibrate'",
        ),
        (
            &[tables, "--edition=first", "--arm=half-severity"],
            3,
            "--arm half-severity: changes reality.severity_factor, which is given with --robot serial:",
        ),
        (
            &[tables, "--edition=first", "--arm=ten-readings"],
            3,
            "changes samples.turns",
        ),
        (&[tables, "--arm=undo"], 3, "changes reality.severity"),
        (&[tables, "--runs=0"], 3, "allowed: 1 to 1000"),
    ] {
        let study = [
            "reproduce",
            "miglino1995",
            "--backend=cpu",
            "--robot",
            ROBOT,
            "--out=none",
        ];
        let study = if code == 2 { &study[..5] } else { &study };
        place.run(&[study, arguments].concat()).exits(code).says(&[words]);
        assert!(!place.at("none").exists(), "nothing was begun");
    }
}

/// Recorded tables replace samples: another robot's, or a real one's if its recordings are there.
#[test]
fn a_study_takes_recordings() {
    let place = Place::new("recordings");
    let short = place.short_study();
    let study = |tables: &str, out: &str| {
        let study = ["reproduce", "miglino1995", "--runs", "2", "--backend", "cpu"];
        place.run(&[&study[..], short, &["--tables", tables, "--out", out]].concat())
    };
    place.sample("eight", &["--robot", "surrogate:8", "--quiet"]).exits(0);
    study("eight/wall.sam", "none")
        .exits(3)
        .says(&["no sensor table for `round`"]);

    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/khepera");
    let real = std::env::var_os("ONEIRO_RECORDINGS").map_or(beside, PathBuf::from);
    let mut folders = vec![PathBuf::from("eight")];
    if real.join("wall.sam").exists() {
        folders.push(real);
    } else {
        skipped("recordings", "a study of a real robot's tables");
    }
    for (number, folder) in folders.iter().enumerate() {
        let files =
            ["wall", "round", "motor"].map(|name| folder.join(name).with_extension("sam").display().to_string());
        let out = number.to_string();
        study(&files.join(","), &out).exits(0);
        let report = place.text(format!("{out}/report.html"));
        assert!(report.contains("the simulator is made from recordings of another robot"));
        assert!(!place.at(format!("{out}/robot")).exists(), "nothing is sampled");
    }

    // Equal tables are reported.
    fs::copy(place.at("eight/wall.sam"), place.at("round.sam")).unwrap();
    study("eight/wall.sam,round.sam", "equal").exits(0).says(&["warning"]);
}

/// Results of consecutive real lives don't depend on threads and stops either.
#[cfg(unix)]
#[test]
fn lives_in_sequence_are_a_function_of_the_settings() {
    let place = Place::new("sequence");
    let short = place.short_study();
    let study = |out, more: &[&'static str]| {
        let study = [
            "reproduce",
            "miglino1995",
            "--runs",
            "2",
            "--backend",
            "cpu",
            "--out",
            out,
        ];
        [&study[..], short, more].concat()
    };
    let of_arm = |out, threads| {
        let arm = [
            "--edition",
            "first",
            "--arm",
            "real-starts-walk",
            "--quiet",
            "--threads",
            threads,
        ];
        study(out, &arm)
    };
    let begun = Instant::now();
    place.good(&of_arm("whole", "2"));
    place.kill_after(begun.elapsed() / 2, &of_arm("killed", "1"));
    place.good(&of_arm("killed", "1"));
    place.assert_same_files("whole", "killed");
    // Another arm is another study.
    place
        .run(&study("whole", &["--edition", "first"]))
        .exits(3)
        .says(&["another study's"]);
}

/// A study that is killed at several moments and restarted ends in the same files as an undisturbed one, also on one
/// thread and on another backend.
#[cfg(unix)]
#[test]
fn a_study_is_a_function_of_its_settings() {
    let place = Place::new("study");
    let short = place.short_study();
    let study = |out, more: &[&'static str]| {
        let mut arguments = vec!["reproduce", "miglino1995", "--runs", "2", "--quiet", "--out", out];
        arguments.extend(short);
        arguments.extend(more);
        arguments
    };
    let begun = Instant::now();
    place.good(&study("whole", &["--backend", "cpu"]));
    let whole = begun.elapsed();
    let claims: serde_json::Value = serde_json::from_slice(&place.read("whole/claims.json")).unwrap();
    let ids: Vec<&str> = claims
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|claim| claim["id"].as_str())
        .collect();
    assert_eq!(ids.len(), 13);
    assert!(place.at("whole/report.html").is_file());

    for kill in 1..=KILLS {
        let moment = whole * kill / (KILLS + 1) + Duration::from_millis(3);
        place.kill_after(moment, &study("killed", &["--backend", "cpu", "--threads", "1"]));
    }
    place.good(&study("killed", &["--backend", "cpu", "--threads", "1"]));
    place.assert_same_files("whole", "killed");

    let more = ["reproduce", "miglino1995", "--runs", "3", "--backend", "cpu"];
    place
        .run(&[&more[..], short, &["--out", "whole"]].concat())
        .exits(3)
        .says(&["another study's"]);

    if cfg!(feature = "gpu") {
        place.good(&study("gpu", &["--backend", "gpu:0"]));
        place.assert_same_files("whole", "gpu");
    }
}

/// The 2014 study, killed and restarted, on one thread, and on another device, ends in the same files.
#[cfg(unix)]
#[test]
fn a_study_of_swarms_is_a_function_of_its_settings() {
    let place = Place::new("swarms");
    let study = |out, scale, more: &[&'static str]| {
        let mut arguments = vec!["reproduce", "odowd2014", "--runs", "2", "--only-cases", "--quiet"];
        arguments.extend(["--credit", "matched", "--scale", scale, "--out", out]);
        arguments.extend(more);
        arguments
    };
    // `tests/long.sh` takes another mutation scale as well.
    let (scales, cohort) = if is_long() {
        ("0.2,2", "2-matched-0000")
    } else {
        ("0.2", "0.2-matched-0000")
    };
    let begun = Instant::now();
    place.good(&study("whole", scales, &["--backend", "cpu"]));
    let whole = begun.elapsed();
    let claims: serde_json::Value = serde_json::from_slice(&place.read("whole/claims.json")).unwrap();
    assert_eq!(claims.as_array().unwrap().len(), 19);
    let report = place.text("whole/report.html");
    for figure in 1..=10 {
        assert!(report.contains(&format!("Figure {figure}")), "figure {figure}");
    }
    for kill in 1..=KILLS {
        let moment = whole * kill / (KILLS + 1) + Duration::from_millis(3);
        place.kill_after(
            moment,
            &study("killed", scales, &["--backend", "cpu", "--threads", "1"]),
        );
    }
    place.good(&study("killed", scales, &["--backend", "cpu", "--threads", "1"]));
    place.assert_same_files("whole", "killed");
    if cfg!(feature = "gpu") {
        place.good(&study("gpu", scales, &["--backend", "gpu:0"]));
        place.assert_same_files("whole", "gpu");
    }

    // Saved files are never trusted unchecked.
    let file = format!("whole/cohorts/{cohort}");
    let mut bytes = place.read(&file);
    bytes[1000] ^= 1;
    fs::write(place.at(&file), bytes).unwrap();
    place
        .run(&study("whole", scales, &["--backend", "cpu"]))
        .exits(5)
        .says(&[cohort]);
    for (arguments, words) in [
        (&["--scale", "0"][..], "allowed: above 0"),
        (&["--scale", "0.2,2,0.2"], "is given twice"),
        (&["--credit", "lagged,lagged"], "is given twice"),
        (&["--runs", "1"], "allowed: 2 to 400"),
    ] {
        let all = [&["reproduce", "odowd2014", "--out", "none"], arguments].concat();
        place.run(&all).exits(3).says(&[words]);
        assert!(!place.at("none").exists(), "nothing was begun");
    }
}
