//! Runs, stopped and resumed, by the program itself.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// A small experiment that checkpoints often.
const EXPERIMENT: &str = "
    cycles = 40
    [evolution]
    population = 20
    parents = 4
    generations = 30
    [record]
    checkpoint_every = 4
";

/// Files that have the same bytes wherever and however a run was computed.
const RESULTS: [&str; 10] = [
    "champion.json",
    "champion.npy",
    "config.toml",
    "fitness.npy",
    "generations.csv",
    "individuals.npy",
    "learning-curve.svg",
    "path.svg",
    "population.npy",
    "trace.csv",
];

/// A directory of its own with an experiment in it, removed when the test ends.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str, experiment: &str) -> Self {
        let path = std::env::temp_dir().join(format!("oneiro-run-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        fs::write(path.join("small.toml"), experiment).unwrap();
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

    fn start(&self, arguments: &[&str]) -> Child {
        self.command(arguments)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap()
    }

    /// The result's hash of a finished run.
    fn hash(&self, run: &str) -> String {
        let done = fs::read_to_string(self.0.join(run).join("DONE")).unwrap();
        let done: serde_json::Value = serde_json::from_str(&done).unwrap();
        done["result"].as_str().unwrap().to_owned()
    }

    fn read(&self, file: impl AsRef<Path>) -> Vec<u8> {
        let path = self.0.join(file);
        fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    }

    fn assert_same(&self, run: &str, other: &str) {
        for file in RESULTS {
            assert!(
                self.read(Path::new(run).join(file)) == self.read(Path::new(other).join(file)),
                "{file} of {run} and {other} differ"
            );
        }
        assert_eq!(self.hash(run), self.hash(other));
    }

    /// A run's newest checkpoints, the newest first.
    fn checkpoints(&self, run: &str) -> Vec<PathBuf> {
        let entries = fs::read_dir(self.0.join(run))
            .unwrap()
            .map(|entry| entry.unwrap().path());
        let number = |path: &PathBuf| {
            path.file_name()
                .unwrap()
                .to_str()
                .unwrap()
                .strip_prefix("checkpoint-")
                .and_then(|end| end.parse::<u32>().ok())
        };
        let mut checkpoints: Vec<PathBuf> = entries.filter(|path| number(path).is_some()).collect();
        checkpoints.sort_by_key(|path| std::cmp::Reverse(number(path)));
        checkpoints
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What is left in the system's directory for such files does no harm.
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn a_run_is_the_same_however_it_is_computed() {
    let scratch = Scratch::new("same", EXPERIMENT);
    scratch.expect(
        0,
        &[
            "run",
            "small.toml",
            "--seed",
            "5",
            "--out",
            "one",
            "--threads",
            "1",
            "--backend",
            "cpu",
        ],
    );
    scratch.expect(
        0,
        &[
            "run",
            "small.toml",
            "--seed",
            "5",
            "--out",
            "two",
            "--threads",
            "2",
            "--backend",
            "cpu",
        ],
    );
    scratch.assert_same("one", "two");
    scratch.expect(
        0,
        &[
            "run",
            "small.toml",
            "--seed",
            "5",
            "--out",
            "scalar",
            "--backend",
            "cpu:scalarx1",
        ],
    );
    scratch.assert_same("one", "scalar");
    // In lockstep with others, and from the resolved configuration.
    scratch.expect(0, &["run", "small.toml", "--seeds", "3..7", "--out", "many"]);
    scratch.assert_same("one", "many/seed-5");
    scratch.expect(0, &["run", "one/config.toml", "--out", "again"]);
    scratch.assert_same("one", "again");
    // Another seed is another run, and so is another experiment.
    assert_ne!(scratch.hash("one"), scratch.hash("many/seed-6"));
    assert_ne!(
        scratch.read("one/generations.csv"),
        scratch.read("many/seed-6/generations.csv")
    );
    scratch.expect(
        0,
        &[
            "run",
            "small.toml",
            "--seed",
            "5",
            "--out",
            "other",
            "--set",
            "cycles=41",
        ],
    );
    assert_ne!(scratch.hash("one"), scratch.hash("other"));
}

#[test]
fn a_finished_run_is_whole_and_is_not_run_again() {
    let scratch = Scratch::new("whole", EXPERIMENT);
    let output = scratch.oneiro(&["run", "small.toml", "--seed", "1", "--json"]);
    assert_eq!(output.status.code(), Some(0));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let run = report["directory"].as_str().unwrap();
    assert!(run.starts_with("runs/small-1-"), "{run}");
    assert_eq!(report["result"], scratch.hash(run));
    let champion: serde_json::Value =
        serde_json::from_slice(&scratch.read(Path::new(run).join("champion.json"))).unwrap();
    assert_eq!(report["bits"], champion["fitness_bits"]);
    assert_eq!(champion["genome"].as_array().unwrap().len(), 18);

    let rows = String::from_utf8(scratch.read(Path::new(run).join("generations.csv"))).unwrap();
    assert_eq!(rows.lines().count(), 31);
    let best = |line: &str| line.split(',').nth(1).unwrap().parse::<f32>().unwrap();
    let bests: Vec<f32> = rows.lines().skip(1).map(best).collect();
    assert_eq!(
        report["fitness"].as_f64().unwrap() as f32,
        bests.iter().copied().fold(f32::MIN, f32::max)
    );
    assert_eq!(
        scratch.read(Path::new(run).join("individuals.npy")).len() % 128,
        (30 * 20 * 19 * 4) % 128
    );
    assert_eq!(scratch.checkpoints(run).len(), 2);
    let meta: serde_json::Value = serde_json::from_slice(&scratch.read(Path::new(run).join("meta.json"))).unwrap();
    assert_eq!(meta["status"], "done");

    // Again: nothing is done, and the report is the same.
    let times = |file: &str| {
        fs::metadata(scratch.0.join(run).join(file))
            .unwrap()
            .modified()
            .unwrap()
    };
    let before = (times("DONE"), times("meta.json"));
    let again = scratch.oneiro(&["run", "small.toml", "--seed", "1", "--json"]);
    assert_eq!((again.status.code(), again.stdout), (Some(0), output.stdout.clone()));
    assert_eq!(scratch.oneiro(&["resume", run, "--json"]).stdout, output.stdout);
    assert_eq!(before, (times("DONE"), times("meta.json")));
    scratch.expect(0, &["verify", run]);
}

#[test]
fn nothing_is_overwritten() {
    let scratch = Scratch::new("overwrite", EXPERIMENT);
    scratch.expect(0, &["run", "small.toml", "--seed", "1", "--out", "run"]);
    let said = scratch.expect(3, &["run", "small.toml", "--seed", "2", "--out", "run"]);
    assert!(
        said.contains("run: holds the run of another experiment or seed"),
        "{said}"
    );
    fs::create_dir(scratch.0.join("mine")).unwrap();
    fs::write(scratch.0.join("mine/thesis.tex"), "").unwrap();
    let said = scratch.expect(3, &["run", "small.toml", "--out", "mine"]);
    assert!(said.contains("mine: exists and holds other files"), "{said}");
    assert_eq!(fs::read_dir(scratch.0.join("mine")).unwrap().count(), 1);
    let said = scratch.expect(3, &["resume", "mine"]);
    assert!(said.contains("mine"), "{said}");
    scratch.expect(3, &["resume", "nowhere"]);
    // One of several places is taken: none of the runs begins.
    fs::create_dir_all(scratch.0.join("many/seed-3")).unwrap();
    fs::write(scratch.0.join("many/seed-3/notes"), "").unwrap();
    scratch.expect(3, &["run", "small.toml", "--seeds", "1..4", "--out", "many"]);
    assert_eq!(fs::read_dir(scratch.0.join("many")).unwrap().count(), 1);
}

#[test]
fn bad_experiments_are_refused_with_their_place() {
    let scratch = Scratch::new("bad", "");
    for (text, place) in [
        ("cycles = 0", "small.toml:1:10: cycles: is 0; allowed: 1 to 1000000"),
        ("\n[task]\nsped = \"signed\"", "small.toml:3:1: task.sped: unknown key"),
        (
            "[noise]\nmotor = 2",
            "small.toml:2:9: noise.motor: is 2; allowed: 0 to 1",
        ),
        (
            "[robot]\ntables = [\"a.sam\"]",
            "small.toml:2:11: robot.tables[0]: a.sam",
        ),
        ("cycles = [", "small.toml:1:1"),
        ("\u{0}", "small.toml:1:"),
    ] {
        fs::write(scratch.0.join("small.toml"), text).unwrap();
        let said = scratch.expect(3, &["run", "small.toml", "--seed", "1"]);
        assert!(said.contains(place), "{text}: {said}");
    }
    fs::write(scratch.0.join("small.toml"), [0xff, 0xfe, 0x00]).unwrap();
    scratch.expect(3, &["run", "small.toml"]);
    scratch.expect(3, &["run", "none.toml"]);
    fs::write(scratch.0.join("small.toml"), "").unwrap();
    let said = scratch.expect(3, &["run", "small.toml", "--set", "noise.motor=2"]);
    assert!(
        said.contains("--set noise.motor=2: noise.motor: is 2; allowed: 0 to 1"),
        "{said}"
    );
    scratch.expect(2, &["run", "small.toml", "--set", "noise.motor"]);
    scratch.expect(4, &["run", "small.toml", "--backend", "abacus", "--out", "no-device"]);
    assert_eq!(fs::read_dir(&scratch.0).unwrap().count(), 1, "nothing was written");
}

/// Killed again and again at any moment, a run ends as if nothing had been.
#[test]
fn a_run_survives_being_killed() {
    const KILLS: usize = 25;
    let experiment = EXPERIMENT
        .replace("generations = 30", "generations = 300")
        .replace("every = 4", "every = 10");
    let scratch = Scratch::new("kill", &experiment);
    let whole = Instant::now();
    scratch.expect(0, &["run", "small.toml", "--seed", "9", "--out", "whole"]);
    let whole = whole.elapsed();
    let run = ["run", "small.toml", "--seed", "9", "--out", "killed"];
    let mut kills = 0;
    // A step through the golden section's multiples, which meets all of a run's moments.
    let mut moment = 0.0;
    while kills < KILLS {
        moment = (moment + 0.618_034) % 1.0_f64;
        let arguments = if scratch.0.join("killed/config.toml").exists() {
            &["resume", "killed"][..]
        } else {
            &run
        };
        let mut child = scratch.start(arguments);
        thread::sleep(whole.mul_f64(0.4 * moment));
        if child.try_wait().unwrap().is_none() {
            child.kill().unwrap();
            kills += 1;
        }
        child.wait().unwrap();
        if scratch.0.join("killed/DONE").exists() {
            scratch.assert_same("whole", "killed");
            fs::remove_dir_all(scratch.0.join("killed")).unwrap();
        }
    }
    if !scratch.0.join("killed/config.toml").exists() {
        scratch.expect(0, &run);
    }
    scratch.expect(0, &["resume", "killed"]);
    scratch.assert_same("whole", "killed");
}

/// Of two processes on one run, one works.
#[test]
fn a_run_has_one_writer() {
    let scratch = Scratch::new(
        "writer",
        &EXPERIMENT.replace("generations = 30", "generations = 1000000"),
    );
    let mut child = scratch.start(&["run", "small.toml", "--seed", "1", "--out", "run"]);
    wait_for(|| !scratch.0.join("run").exists() || scratch.checkpoints("run").is_empty());
    let said = scratch.expect(3, &["resume", "run"]);
    assert!(said.contains("another process works on this run"), "{said}");
    scratch.expect(3, &["run", "small.toml", "--seed", "1", "--out", "run"]);
    child.kill().unwrap();
    child.wait().unwrap();
}

/// Waits until something is not so any more.
fn wait_for(mut is_so: impl FnMut() -> bool) {
    let begun = Instant::now();
    while is_so() {
        assert!(begun.elapsed() < Duration::from_mins(1), "waited for a minute");
        thread::sleep(Duration::from_millis(2));
    }
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::os::unix::fs::symlink;

    fn signal(child: &Child, name: &str) {
        let sent = Command::new("kill")
            .args([name, &child.id().to_string()])
            .status()
            .unwrap();
        assert!(sent.success());
    }

    /// Ctrl-C and SIGTERM stop a run at a checkpoint, whatever its interval, exit 75.
    #[test]
    fn a_run_is_stopped_and_goes_on() {
        let experiment = EXPERIMENT
            .replace("generations = 30", "generations = 3000")
            .replace("every = 4", "every = 1000000");
        let scratch = Scratch::new("stop", &experiment);
        scratch.expect(0, &["run", "small.toml", "--seeds", "1..2", "--out", "whole"]);
        let mut arguments = vec!["run", "small.toml", "--seeds", "1..2", "--out", "stopped"];
        let mut stops = 0;
        for name in ["-INT", "-TERM"] {
            let child = scratch
                .command(&arguments)
                .stdout(Stdio::piped())
                .stderr(Stdio::piped())
                .spawn()
                .unwrap();
            // From then on it listens. A fast machine may be through with it by now.
            let has_begun = || {
                let meta = fs::read_to_string(scratch.0.join("stopped/seed-2/meta.json")).unwrap_or_default();
                meta.contains("\"running\"") || meta.contains("\"done\"")
            };
            wait_for(|| !has_begun());
            thread::sleep(Duration::from_millis(100));
            signal(&child, name);
            let output = child.wait_with_output().unwrap();
            let said = String::from_utf8(output.stderr).unwrap();
            if output.status.code() == Some(75) {
                assert!(said.contains("oneiro resume stopped"), "{said}");
                // A run that no generation has lived in yet has nothing to keep.
                let unborn = said.contains("stopped/seed-1  (generation 0)");
                assert!(unborn || !scratch.checkpoints("stopped/seed-1").is_empty(), "{said}");
                stops += 1;
            } else {
                assert_eq!(output.status.code(), Some(0), "{said}");
            }
            arguments = vec!["resume", "stopped"];
        }
        assert!(stops > 0, "the run was too short to be stopped");
        scratch.expect(0, &["resume", "stopped"]);
        for seed in ["seed-1", "seed-2"] {
            let (whole, stopped) = (format!("whole/{seed}"), format!("stopped/{seed}"));
            scratch.assert_same(&whole, &stopped);
        }
    }

    /// A damaged checkpoint is told and not used, the one before it is; without a good one, exit 5.
    #[test]
    fn a_damaged_checkpoint_is_not_used() {
        let scratch = Scratch::new("damaged", EXPERIMENT);
        scratch.expect(0, &["run", "small.toml", "--seed", "1", "--out", "whole"]);
        // Everything that a run writes after its last checkpoint fails.
        let interrupted = |name: &str| {
            fs::create_dir(scratch.0.join(name)).unwrap();
            symlink("/dev/full", scratch.0.join(name).join("champion.json.tmp")).unwrap();
            scratch.expect(6, &["run", "small.toml", "--seed", "1", "--out", name]);
            fs::remove_file(scratch.0.join(name).join("champion.json.tmp")).unwrap();
            let checkpoints = scratch.checkpoints(name);
            assert_eq!(checkpoints.len(), 2);
            checkpoints
        };
        let checkpoints = interrupted("cut");
        let content = fs::read(&checkpoints[0]).unwrap();
        fs::write(&checkpoints[0], &content[..content.len() - 1]).unwrap();
        let said = scratch.expect(0, &["resume", "cut"]);
        assert!(
            said.contains("checkpoint-28: is cut off or damaged; it is not used"),
            "{said}"
        );
        scratch.assert_same("whole", "cut");

        for checkpoint in interrupted("flipped") {
            let mut content = fs::read(&checkpoint).unwrap();
            let middle = content.len() / 2;
            content[middle] ^= 1;
            fs::write(&checkpoint, content).unwrap();
        }
        let said = scratch.expect(5, &["resume", "flipped"]);
        assert!(said.contains("no checkpoint of this run is good"), "{said}");

        // What a checkpoint counts on is checked too.
        interrupted("rows");
        let rows = scratch.0.join("rows/generations.csv");
        let text = fs::read_to_string(&rows).unwrap();
        fs::write(&rows, text.replacen("\n3,", "\n33,", 1)).unwrap();
        let said = scratch.expect(5, &["resume", "rows"]);
        assert!(said.contains("generations.csv is not what it was then"), "{said}");
        interrupted("edited");
        let config = scratch.0.join("edited/config.toml");
        let text = fs::read_to_string(&config).unwrap();
        fs::write(&config, text.replace("cycles = 40", "cycles = 41")).unwrap();
        let said = scratch.expect(5, &["resume", "edited"]);
        assert!(
            said.contains("belongs to another experiment than config.toml"),
            "{said}"
        );
    }

    /// Whatever can't be written, for want of space: exit 6, and when there is space again the run goes on and ends
    /// as if nothing had been.
    #[test]
    fn a_full_disk_costs_nothing_but_time() {
        let scratch = Scratch::new("full", EXPERIMENT);
        scratch.expect(0, &["run", "small.toml", "--seed", "1", "--out", "whole"]);
        let files = ["config.toml", "meta.json", "checkpoint-4", "checkpoint-28"];
        for file in files.into_iter().chain(RESULTS.into_iter().filter(|file| {
            // These grow, and are not written at once.
            !["config.toml", "generations.csv", "individuals.npy"].contains(file)
        })) {
            let name = format!("run-{file}");
            let full = scratch.0.join(&name).join(format!("{file}.tmp"));
            fs::create_dir(scratch.0.join(&name)).unwrap();
            symlink("/dev/full", &full).unwrap();
            let run = ["run", "small.toml", "--seed", "1", "--out", &name];
            let said = scratch.expect(6, &run);
            assert!(
                said.contains(&format!("{file}: No space left on device")),
                "{file}: {said}"
            );
            fs::remove_file(&full).unwrap();
            let resume = ["resume", &name];
            scratch.expect(
                0,
                if scratch.0.join(&name).join("config.toml").exists() {
                    &resume
                } else {
                    &run
                },
            );
            scratch.assert_same("whole", &name);
        }
        // And when what grows can't.
        for file in ["generations.csv", "individuals.npy"] {
            let name = format!("run-{file}");
            fs::create_dir(scratch.0.join(&name)).unwrap();
            fs::copy(
                scratch.0.join("whole/config.toml"),
                scratch.0.join(&name).join("config.toml"),
            )
            .unwrap();
            symlink("/dev/full", scratch.0.join(&name).join(file)).unwrap();
            let said = scratch.expect(6, &["resume", &name]);
            assert!(
                said.contains(&format!("{file}: No space left on device")),
                "{file}: {said}"
            );
            fs::remove_file(scratch.0.join(&name).join(file)).unwrap();
            scratch.expect(0, &["resume", &name]);
            scratch.assert_same("whole", &name);
        }
    }
}
