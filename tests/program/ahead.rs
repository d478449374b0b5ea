//! `oneiro device compile`: kernels composed at run time and compiled ahead of time have the bits of those compiled at run time, later
//! commands use them by themselves, and what can't be used is named and replaced.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::place::{Place, Ran};

/// Lanes compiled at run time, with which all others are compared.
const REFERENCE: &str = "native128x16";

/// An experiment with a kernel of its own.
const EXPERIMENT: &str = "kheperax";

fn experiment(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../experiments/{name}.toml"));
    path.display().to_string()
}

/// A place with a cache of its own.
struct Cached(Place);

impl Cached {
    fn new(name: &str) -> Self {
        Self(Place::new(name))
    }

    fn run(&self, arguments: &[&str], variables: &[(&str, &str)]) -> Ran {
        let mut command = self.0.command(arguments);
        command.env("XDG_CACHE_HOME", self.0.at("cache")).env_remove("RUSTC");
        let output = command.envs(variables.iter().copied()).output().unwrap();
        Ran::new(arguments, &output)
    }

    fn compile(&self, name: &str, more: &[&str]) -> Ran {
        let path = experiment(name);
        self.run(&[&["device", "compile", path.as_str()], more].concat(), &[])
    }

    /// A line for each life of random genomes, by a backend.
    fn lines(&self, backend: &str, seed: &str) -> Ran {
        let path = experiment(EXPERIMENT);
        let random = ["evaluate", &path, "--random", "100", "--trials", "1", "--seed", seed];
        self.run(&[&random[..], &["--backend", backend, "--measures"]].concat(), &[])
            .exits(0)
    }

    /// Files of compiled kernels.
    fn kernels(&self) -> Vec<PathBuf> {
        let Ok(files) = fs::read_dir(self.0.at("cache/oneiro/kernels")) else {
            return Vec::new();
        };
        files.map(|file| file.unwrap().path()).collect()
    }

    /// Those by a toolchain.
    fn libraries(&self) -> Vec<PathBuf> {
        let mut kernels = self.kernels();
        kernels.retain(|path| path.extension().is_some_and(|extension| extension == "lanes"));
        kernels
    }
}

/// A long kernel has code for a few lanes at first. The program ends when that for all of them is also in the cache.
#[test]
fn the_code_of_a_long_kernel_is_there_the_next_time() {
    let place = Cached::new("long");
    let path = experiment("evostick-foraging");
    let short = [
        "evaluate", &path, "--random", "1", "--trials", "1", "--seed", "1", "--set", "cycles=2",
    ];
    for _ in 0..2 {
        let backend = format!("cpu:{REFERENCE}");
        place
            .run(&[&short[..], &["--backend", &backend]].concat(), &[])
            .exits(0);
        assert_eq!(place.kernels().len(), 2);
    }
}

#[test]
fn kernels_compiled_ahead_have_the_same_bits() {
    let place = Cached::new("same");
    let expected = place.lines("cpu", "7").stdout;
    let ran = place
        .compile(EXPERIMENT, &["--json"])
        .exits(0)
        .says(&["compiling life_", "comparing 256 episodes"]);
    let report: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert!(
        report["seconds"].as_f64().unwrap() > 0.1 && report["bytes"].as_u64().unwrap() > 10_000,
        "{report}"
    );
    assert_eq!(report["ships"], false);
    let codes: Vec<&str> = report["lane_codes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|code| code.as_str().unwrap())
        .collect();
    assert!(!codes.is_empty() && codes[0] != REFERENCE, "{report}");
    assert_eq!(place.libraries().len(), 1);
    // The fastest of its own accord, each by its name, and that compiled at run time.
    for code in codes.iter().copied().chain([REFERENCE, "interpretedx1"]) {
        assert_eq!(place.lines(&format!("cpu:{code}"), "7").stdout, expected, "{code}");
    }
    let ran = place.lines("cpu", "7");
    assert_eq!(ran.stdout, expected);
    assert!(!ran.stderr.contains("warning"), "{}", ran.stderr);
    ran.says(&[&format!("on cpu ({}, ", codes[0])]);
    assert_ne!(place.lines("cpu", "8").stdout, expected);

    let again = place.compile(EXPERIMENT, &[]).exits(0);
    assert!(
        again.stdout.contains("was compiled before") && again.stdout.contains(codes[0]),
        "{}",
        again.stdout
    );
    assert!(!again.stderr.contains("compiling"), "{}", again.stderr);

    // The bench times each of them, and what runs without them is the measure.
    let bench = [
        "device",
        "bench",
        &experiment(EXPERIMENT),
        "--backend",
        "cpu",
        "--quick",
        "--rollouts",
        "64",
        "--json",
    ];
    let timed: Value = serde_json::from_str(&place.run(&bench, &[]).exits(0).stdout).unwrap();
    assert_eq!(timed["experiment"], EXPERIMENT);
    assert_eq!(timed["cycles"], 250);
    let cells = timed["cells"].as_array().unwrap();
    for code in codes.iter().copied().chain([REFERENCE]) {
        let device = format!("cpu {code}");
        let cell = cells
            .iter()
            .find(|cell| cell["device"] == device && cell["threads"] == 1);
        let cell = cell.unwrap_or_else(|| panic!("{code} of {timed}"));
        assert_eq!(cell["robot_steps"], 64 * 250);
        assert_eq!(cell["ratio"] == 1.0, code == REFERENCE, "{cell}");
    }

    // What is damaged is named, and isn't used.
    let library = &place.libraries()[0];
    let mut bytes = fs::read(library).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(library, bytes).unwrap();
    let ran = place.lines("cpu", "7").says(&[
        "warning: the library ",
        "is damaged",
        "`oneiro device compile` compiles it ahead again",
    ]);
    assert_eq!(ran.stdout, expected);
}

#[test]
fn what_cannot_be_compiled_is_refused() {
    let place = Cached::new("refused");
    let path = experiment(EXPERIMENT);
    let without = |rustc: &str| place.run(&["device", "compile", &path], &[("RUSTC", rustc)]);
    without("no-such-compiler").exits(3).says(&[
        "`no-such-compiler` can't be started",
        "install Rust 1.95 or newer",
        "RUSTC",
    ]);
    // It answers, but isn't a compiler.
    without("true")
        .exits(3)
        .says(&["doesn't tell a version of Rust; allowed: "]);
    assert!(place.libraries().is_empty());
    place.compile("no-such-experiment", &[]).exits(3);
    let ships = place
        .compile("khepera-avoidance", &["--json"])
        .exits(0)
        .says(&["there is nothing to compile"]);
    assert!(ships.stdout.contains("\"ships\": true"), "{}", ships.stdout);
}
