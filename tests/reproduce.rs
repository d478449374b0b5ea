//! `oneiro sample` and `oneiro reproduce`, by the program itself: the same bytes on every device and after any stop,
//! and what they refuse.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// A directory of its own, removed when the test ends.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("oneiro-reproduce-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_oneiro"));
        command.current_dir(&self.0).args(arguments).stdin(Stdio::null());
        command
    }

    fn oneiro(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Runs the program, which must end with a code. What it said to the user.
    fn expect(&self, code: i32, arguments: &[&str]) -> String {
        let output = self.oneiro(arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
        said
    }

    /// Every file below a directory, with its bytes.
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
        let root = self.0.join(directory);
        collect(&root, &root, &mut files);
        files.sort();
        files
    }

    fn assert_same(&self, one: &str, other: &str) {
        let (one, other) = (self.files(one), self.files(other));
        let names = |files: &[(PathBuf, Vec<u8>)]| files.iter().map(|(path, _)| path.clone()).collect::<Vec<_>>();
        assert_eq!(names(&one), names(&other));
        for ((path, one), (_, other)) in one.iter().zip(&other) {
            assert!(one == other, "{} differs", path.display());
        }
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn a_sampled_robot_is_one_that_runs_take() {
    let place = Scratch::new("sample");
    place.expect(
        0,
        &[
            "sample",
            "--robot",
            "surrogate:7",
            "--backend",
            "cpu",
            "--out",
            "seven",
            "--quiet",
        ],
    );
    place.expect(0, &["tables", "show", "seven/wall.sam"]);
    let motors = fs::read_to_string(place.0.join("seven/motor.sam")).unwrap();
    assert_eq!(motors.lines().count(), 42, "21 speeds, turns and displacements");
    place.expect(0, &["new", "own"]);
    let tables = "robot.tables=[\"seven/wall.sam\",\"seven/round.sam\"]";
    let motors = "robot.motors=\"seven/motor.sam\"";
    place.expect(0, &["check", "own.toml", "--set", tables, "--set", motors]);

    // On one thread as on all, and not as another robot.
    place.expect(
        0,
        &[
            "sample",
            "--robot",
            "surrogate:7",
            "--backend",
            "cpu",
            "--threads",
            "1",
            "--out",
            "again",
        ],
    );
    place.assert_same("seven", "again");
    place.expect(
        0,
        &["sample", "--robot", "surrogate:8", "--backend", "cpu", "--out", "eight"],
    );
    assert_ne!(place.files("seven"), place.files("eight"));
}

/// The experiment with a block runs on samples that this machine takes again, to the last bit.
#[test]
fn the_shipped_samples_are_those_of_their_robot() {
    let place = Scratch::new("block");
    let experiments = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments");
    let objects = "wall,round,block";
    place.expect(
        0,
        &[
            "sample",
            "--robot",
            "surrogate:1",
            "--objects",
            objects,
            "--backend",
            "cpu",
            "--out",
            "one",
        ],
    );
    for name in ["wall.sam", "round.sam", "block.sam", "motor.sam"] {
        let shipped = fs::read(experiments.join("surrogate-1").join(name)).unwrap();
        assert!(shipped == fs::read(place.0.join("one").join(name)).unwrap(), "{name}");
    }
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
    place.expect(0, &[&arguments[..], &short].concat());
}

#[test]
fn what_can_not_be_sampled_is_refused() {
    let place = Scratch::new("refused");
    for (arguments, words) in [
        (["--robot", "khepera:1"], "allowed: surrogate:SEED"),
        (["--robot", "surrogate:x"], "allowed: surrogate:SEED"),
        (["--severity", "3"], "surrogate.severity: is 3; allowed: 0 to 2"),
        (["--objects", "wall,cube"], "allowed: wall, round"),
        (["--objects", "wall,wall"], "is there twice"),
    ] {
        let said = place.expect(
            3,
            &[
                "sample",
                arguments[0],
                arguments[1],
                "--backend",
                "cpu",
                "--out",
                "none",
            ],
        );
        assert!(said.contains(words), "{arguments:?}: {said}");
    }
    place.expect(0, &["sample", "--backend", "cpu", "--out", "one", "--quiet"]);
    let said = place.expect(
        3,
        &["sample", "--robot", "surrogate:2", "--backend", "cpu", "--out", "one"],
    );
    assert!(said.contains("holds samples of another robot"), "{said}");
}

#[test]
fn studies_that_can_not_be_are_refused() {
    let place = Scratch::new("studies");
    fs::create_dir(place.0.join("full")).unwrap();
    fs::write(place.0.join("full/own.txt"), "mine").unwrap();
    fs::write(place.0.join("wall.sam"), "8 180 20 5 2\n").unwrap();
    for (arguments, words) in [
        (&["--severity=-1"][..], "allowed: 0 to 2"),
        (&["--robot", "mine"], "allowed: surrogate:SEED"),
        (&["--out", "full"], "is not empty and holds no study"),
        (&["--tables", "wall.sam,none.sam"], "wall.sam"),
        (&["--tables", "none.sam"], "none.sam"),
    ] {
        let mut all = vec!["reproduce", "miglino1995", "--backend", "cpu"];
        all.extend(arguments);
        let said = place.expect(3, &all);
        assert!(said.contains(words), "{arguments:?}: {said}");
    }
    assert_eq!(fs::read_to_string(place.0.join("full/own.txt")).unwrap(), "mine");
    for runs in ["0", "1", "1001"] {
        let said = place.expect(3, &["reproduce", "miglino1995", "--runs", runs, "--out", "few"]);
        assert!(said.contains("allowed: 2 to 1000"), "{said}");
        assert!(!place.0.join("few").exists(), "nothing was begun");
    }
}

/// Tables of another robot in place of samples, those of a real one where its recordings are.
#[test]
fn a_study_takes_recordings() {
    fn study<'a>(tables: &'a str, out: &'a str) -> Vec<&'a str> {
        let study = ["reproduce", "miglino1995", "--runs", "2", "--backend", "cpu"];
        [&study[..], &["--tables", tables, "--out", out]].concat()
    }

    let place = Scratch::new("recordings");
    place.expect(
        0,
        &[
            "sample",
            "--robot",
            "surrogate:8",
            "--backend",
            "cpu",
            "--out",
            "eight",
            "--quiet",
        ],
    );
    let said = place.expect(3, &study("eight/wall.sam", "none"));
    assert!(said.contains("no sensor table for `round`"), "{said}");

    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/khepera");
    let real = std::env::var_os("ONEIRO_RECORDINGS").map_or(beside, PathBuf::from);
    let mut folders = vec![PathBuf::from("eight")];
    if real.join("wall.sam").exists() {
        folders.push(real);
    } else {
        eprintln!("no recordings in {} (set ONEIRO_RECORDINGS)", real.display());
    }
    for (number, folder) in folders.iter().enumerate() {
        let files =
            ["wall", "round", "motor"].map(|name| folder.join(name).with_extension("sam").display().to_string());
        let out = number.to_string();
        place.expect(0, &study(&files.join(","), &out));
        let report = fs::read_to_string(place.0.join(&out).join("report.html")).unwrap();
        assert!(report.contains("the simulator is made from recordings of another robot"));
        assert!(!place.0.join(&out).join("robot").exists(), "nothing is sampled");
    }

    // Equal tables are told.
    fs::copy(place.0.join("eight/wall.sam"), place.0.join("round.sam")).unwrap();
    let said = place.expect(0, &study("eight/wall.sam,round.sam", "equal"));
    assert!(said.contains("warning"), "{said}");
}

/// Real lives that follow one another are as little a matter of threads and stops.
#[cfg(unix)]
#[test]
fn lives_in_sequence_are_a_function_of_the_settings() {
    let place = Scratch::new("sequence");
    let study = |out, threads| {
        let arm = ["reproduce", "miglino1995", "--arm", "real-starts-walk"];
        let rest = [
            "--runs",
            "2",
            "--quiet",
            "--backend",
            "cpu",
            "--threads",
            threads,
            "--out",
            out,
        ];
        [&arm[..], &rest].concat()
    };
    let begun = Instant::now();
    place.expect(0, &study("whole", "2"));
    let whole = begun.elapsed();
    let mut child = place
        .command(&study("killed", "1"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(whole / 2);
    child.kill().unwrap();
    child.wait().unwrap();
    place.expect(0, &study("killed", "1"));
    place.assert_same("whole", "killed");
    let said = place.expect(
        3,
        &[
            "reproduce",
            "miglino1995",
            "--runs",
            "2",
            "--backend",
            "cpu",
            "--out",
            "whole",
        ],
    );
    assert!(said.contains("another study's"), "another arm is: {said}");
}

/// Killed at some moments and begun again, a study ends in the same files as one that was let alone; on one thread
/// too, and under another backend.
#[cfg(unix)]
#[test]
fn a_study_is_a_function_of_its_settings() {
    let place = Scratch::new("study");
    let study = |out, more: &[&'static str]| {
        let mut arguments = vec!["reproduce", "miglino1995", "--runs", "2", "--quiet", "--out", out];
        arguments.extend(more);
        arguments
    };
    let begun = Instant::now();
    place.expect(0, &study("whole", &["--backend", "cpu"]));
    let whole = begun.elapsed();
    let claims: serde_json::Value =
        serde_json::from_slice(&fs::read(place.0.join("whole/claims.json")).unwrap()).unwrap();
    let ids: Vec<&str> = claims
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|claim| claim["id"].as_str())
        .collect();
    assert_eq!(ids.len(), 12);
    assert!(place.0.join("whole/report.html").is_file());

    for kill in 1..=6_u32 {
        let mut child = place
            .command(&study("killed", &["--backend", "cpu", "--threads", "1"]))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(whole * kill / 7 + Duration::from_millis(3));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    place.expect(0, &study("killed", &["--backend", "cpu", "--threads", "1"]));
    place.assert_same("whole", "killed");

    let said = place.expect(
        3,
        &[
            "reproduce",
            "miglino1995",
            "--runs",
            "3",
            "--backend",
            "cpu",
            "--out",
            "whole",
        ],
    );
    assert!(said.contains("another study's"), "{said}");

    if cfg!(feature = "gpu") {
        place.expect(0, &study("gpu", &["--backend", "gpu:0"]));
        place.assert_same("whole", "gpu");
    }
}
