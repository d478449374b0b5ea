//! Runs, stopped and resumed, through the program.

use std::fs;
use std::path::Path;
use std::process::{Child, Command};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::place::{Place, wait_for};

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
const RESULTS: [&str; 11] = [
    "champion.json",
    "champion.npy",
    "config.toml",
    "fitness.npy",
    "generations.csv",
    "individuals.npy",
    "learning-curve.svg",
    "path.svg",
    "population.npy",
    "report.html",
    "trace.csv",
];

impl Place {
    /// A place with an experiment in it.
    fn with_experiment(name: &str, experiment: &str) -> Self {
        let place = Self::new(name);
        place.write("small.toml", experiment);
        place
    }

    /// Hash of a finished run's results.
    fn hash(&self, run: &str) -> String {
        self.json(run, "DONE")["result"].as_str().unwrap().to_owned()
    }

    fn assert_same_run(&self, run: &str, other: &str) {
        for file in RESULTS {
            assert!(
                self.read(Path::new(run).join(file)) == self.read(Path::new(other).join(file)),
                "{file} of {run} and {other} differ"
            );
        }
        assert_eq!(self.hash(run), self.hash(other));
    }
}

/// A robot's computer needs no driver of GPUs, and nothing that this program doesn't use.
#[test]
fn the_program_for_a_robot_has_neither_gpus_nor_an_async_runtime() {
    let packages = |features: &str| -> Vec<String> {
        let tree = ["tree", "--offline", "--locked", "--edges", "normal", "--prefix", "none"];
        let build = [
            "--package",
            "oneiro-host",
            "--no-default-features",
            "--features",
            features,
        ];
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(tree).args(build).current_dir(env!("CARGO_MANIFEST_DIR"));
        let output = cargo.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8(output.stdout).unwrap();
        let names = text.lines().filter_map(|line| line.split(' ').next());
        names.map(str::to_owned).collect()
    };
    let is_refused = |name: &String| {
        let runtimes = ["tokio", "smol", "pollster", "futures-executor"];
        ["wgpu", "ash", "async-"].iter().any(|start| name.starts_with(start)) || runtimes.contains(&&**name)
    };
    for features in ["", "compose", "native"] {
        let packages = packages(features);
        assert!(packages.iter().any(|name| name == "serialport"), "{packages:?}");
        let refused: Vec<&String> = packages.iter().filter(|name| is_refused(name)).collect();
        assert!(refused.is_empty(), "with `{features}`: {refused:?}");
    }
    assert!(packages("gpu").iter().any(is_refused));
}

#[test]
fn a_run_is_the_same_however_it_is_computed() {
    let place = Place::with_experiment("same", EXPERIMENT);
    let run = |out, more: &[&str]| {
        let run = ["run", "small.toml", "--seed", "5", "--out", out];
        place.good(&[&run[..], more].concat());
    };
    run("one", &["--threads", "1", "--backend", "cpu"]);
    run("two", &["--threads", "2", "--backend", "cpu"]);
    place.assert_same_run("one", "two");
    run("scalar", &["--backend", "cpu:scalarx1"]);
    place.assert_same_run("one", "scalar");
    // Together with other runs, and from the resolved configuration.
    place.good(&["run", "small.toml", "--seeds", "3..7", "--out", "many"]);
    place.assert_same_run("one", "many/seed-5");
    place.good(&["run", "one/config.toml", "--out", "again"]);
    place.assert_same_run("one", "again");
    // Another seed makes another run, and so does another experiment.
    assert_ne!(place.hash("one"), place.hash("many/seed-6"));
    assert_ne!(
        place.read("one/generations.csv"),
        place.read("many/seed-6/generations.csv")
    );
    run("other", &["--set", "cycles=41"]);
    assert_ne!(place.hash("one"), place.hash("other"));
}

#[test]
fn a_finished_run_is_whole_and_is_not_run_again() {
    let place = Place::with_experiment("whole", EXPERIMENT);
    let json = ["run", "small.toml", "--seed", "1", "--json"];
    let output = place.good(&json);
    let report: Value = serde_json::from_str(&output).unwrap();
    let run = report["directory"].as_str().unwrap();
    assert_eq!(run, "runs/small-1");
    assert_eq!(report["result"], place.hash(run));
    let champion = place.json(run, "champion.json");
    assert_eq!(report["bits"], champion["fitness_bits"]);
    assert_eq!(champion["genome"].as_array().unwrap().len(), 18);

    let rows = place.text(format!("{run}/generations.csv"));
    assert_eq!(rows.lines().count(), 31);
    let best = |line: &str| line.split(',').nth(1).unwrap().parse::<f32>().unwrap();
    let bests: Vec<f32> = rows.lines().skip(1).map(best).collect();
    assert_eq!(
        report["luckiest"].as_f64().unwrap() as f32,
        bests.iter().copied().fold(f32::MIN, f32::max)
    );
    assert_eq!(
        place.read(format!("{run}/individuals.npy")).len() % 128,
        (30 * 20 * 19 * 4) % 128
    );
    assert_eq!(place.checkpoints(run).len(), 2);
    assert_eq!(place.json(run, "meta.json")["status"], "done");

    // The page has what was set, and not where or when it was made.
    let page = place.text(format!("{run}/report.html"));
    for part in [
        "<td class=\"short\">evolution.<wbr/>parents</td><td><code>4</code></td><td><code>20</code></td>",
        "data-series=\"best\"",
    ] {
        assert!(page.contains(part), "{part} in {page}");
    }
    assert!(!page.contains(run) && !page.contains(" src="));

    // Again: no work is done, and the report is the same, but for what the work was done by.
    let times = |file: &str| fs::metadata(place.at(run).join(file)).unwrap().modified().unwrap();
    let before = (times("DONE"), times("meta.json"));
    let done = output.replace(",\n  \"specialised\": 0.0\n", "\n");
    assert_ne!(done, output);
    assert_eq!(place.good(&json), done);
    assert_eq!(place.good(&["resume", run, "--json"]), done);
    assert_eq!(before, (times("DONE"), times("meta.json")));
    place.good(&["verify", run]);
}

#[test]
fn nothing_is_overwritten() {
    let place = Place::with_experiment("overwrite", EXPERIMENT);
    place.good(&["run", "small.toml", "--seed", "1", "--out", "run"]);
    place
        .run(&["run", "small.toml", "--seed", "2", "--out", "run"])
        .exits(3)
        .says(&["run: holds the run of another experiment or seed"]);
    fs::create_dir(place.at("mine")).unwrap();
    place.write("mine/thesis.tex", "");
    place
        .run(&["run", "small.toml", "--out", "mine"])
        .exits(3)
        .says(&["mine: exists and holds other files"]);
    assert_eq!(fs::read_dir(place.at("mine")).unwrap().count(), 1);
    place.run(&["resume", "mine"]).exits(3).says(&["mine"]);
    place.run(&["resume", "nowhere"]).exits(3);
    // One of several directories is taken: none of the runs begins.
    fs::create_dir_all(place.at("many/seed-3")).unwrap();
    place.write("many/seed-3/notes", "");
    place
        .run(&["run", "small.toml", "--seeds", "1..4", "--out", "many"])
        .exits(3);
    assert_eq!(fs::read_dir(place.at("many")).unwrap().count(), 1);
}

#[test]
fn bad_experiments_are_refused_with_their_place() {
    let place = Place::with_experiment("bad", "");
    for (text, words) in [
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
        place.write("small.toml", text);
        place.run(&["run", "small.toml", "--seed", "1"]).exits(3).says(&[words]);
    }
    place.write("small.toml", [0xff, 0xfe, 0x00]);
    place.run(&["run", "small.toml"]).exits(3);
    place.run(&["run", "none.toml"]).exits(3);
    place.write("small.toml", "");
    place
        .run(&["run", "small.toml", "--set", "noise.motor=2"])
        .exits(3)
        .says(&["--set noise.motor=2: noise.motor: is 2; allowed: 0 to 1"]);
    place.run(&["run", "small.toml", "--set", "noise.motor"]).exits(2);
    place
        .run(&["run", "small.toml", "--backend", "abacus", "--out", "no-device"])
        .exits(4);
    assert_eq!(fs::read_dir(place.at(".")).unwrap().count(), 1, "nothing was written");
}

/// Killed again and again at any moment, a run ends with the same results.
#[test]
fn a_run_survives_being_killed() {
    let kills_in_all = if std::env::var_os("ONEIRO_LONG").is_some() {
        500
    } else {
        25
    };
    let experiment = EXPERIMENT
        .replace("generations = 30", "generations = 300")
        .replace("every = 4", "every = 10");
    let place = Place::with_experiment("kill", &experiment);
    let whole = Instant::now();
    place.good(&["run", "small.toml", "--seed", "9", "--out", "whole"]);
    let whole = whole.elapsed();
    let run = ["run", "small.toml", "--seed", "9", "--out", "killed"];
    let mut kills = 0;
    // Multiples of the golden section cover all moments of a run evenly.
    let mut moment = 0.0;
    while kills < kills_in_all {
        moment = (moment + 0.618_034) % 1.0_f64;
        let arguments = if place.at("killed/config.toml").exists() {
            &["resume", "killed"][..]
        } else {
            &run
        };
        let mut child = place.start(arguments);
        thread::sleep(whole.mul_f64(0.4 * moment));
        if child.try_wait().unwrap().is_none() {
            child.kill().unwrap();
            kills += 1;
        }
        child.wait().unwrap();
        if place.at("killed/DONE").exists() {
            place.assert_same_run("whole", "killed");
            fs::remove_dir_all(place.at("killed")).unwrap();
        }
    }
    if !place.at("killed/config.toml").exists() {
        place.good(&run);
    }
    place.good(&["resume", "killed"]);
    place.assert_same_run("whole", "killed");
}

/// A run that gets a larger budget is, file by file, the run that had it from the start.
#[test]
fn a_run_is_extended() {
    let place = Place::with_experiment("extend-run", EXPERIMENT);
    let run = |out: &str, set: &str| {
        place.good(&["run", "small.toml", "--seed", "4", "--out", out, "--set", set]);
    };
    run("whole", "evolution.generations=30");
    // Finished with checkpoints and without any.
    for (name, generations, from) in [("long", 11, 8), ("short", 3, 0)] {
        run(name, &format!("evolution.generations={generations}"));
        let before = place.hash(name);
        place.good(&["resume", name, "--generations", "30"]);
        place.assert_same_run("whole", name);
        place.good(&["verify", name]);
        place.good(&["verify", "--recompute", name]);
        place.good(&["replay", name]);
        let meta = place.json(name, "meta.json");
        let extended = &meta["extended"][0];
        assert_eq!(extended["result"], before);
        assert_eq!(extended["generations"], serde_json::json!([generations, 30]));
        assert_eq!(extended["from_generation"], from);
        assert_eq!((&meta["generations"], &meta["status"]), (&30.into(), &"done".into()));
        // The same again does nothing; a run is not shortened.
        place.good(&["resume", name, "--generations", "30"]);
        assert_eq!(place.json(name, "meta.json"), meta);
        place
            .run(&["resume", name, "--generations", "20"])
            .exits(3)
            .says(&["--generations 20", "has 30 generations; allowed: more"]);
        place.good(&["verify", name]);
    }
    // Episodes: 20 individuals of a generation, and those of finalists.
    run("budget", "evolution.episodes=2700");
    run("spent", "evolution.episodes=2300");
    place.good(&["resume", "spent", "--episodes", "2700"]);
    place.assert_same_run("budget", "spent");
    // One option or the other, and twice.
    run("twice", "evolution.generations=5");
    place.good(&["resume", "twice", "--generations", "9"]);
    place.good(&["resume", "twice", "--generations", "30"]);
    place.assert_same_run("whole", "twice");
    place
        .run(&["resume", "twice", "--generations", "40", "--episodes", "1"])
        .exits(2);
    // A race plans its episodes from the budget.
    place.good(&[
        "run",
        "small.toml",
        "--seed",
        "4",
        "--out",
        "race",
        "--set",
        "evolution.kind=race",
        "--set",
        "evolution.race.lives=400",
    ]);
    place
        .run(&["resume", "race", "--episodes", "5000"])
        .exits(3)
        .says(&["race: its optimiser, race, plans all its episodes from the budget"]);
    place.good(&["verify", "race"]);
}

/// Killed at any moment, an extended run ends with the same results.
#[test]
fn an_extended_run_survives_being_killed() {
    let place = Place::with_experiment("extend-kill", EXPERIMENT);
    let run = |out: &str, generations: &str| {
        let set = format!("evolution.generations={generations}");
        place.good(&["run", "small.toml", "--seed", "9", "--out", out, "--set", &set]);
    };
    run("whole", "60");
    run("killed", "20");
    let extend = ["resume", "killed", "--generations", "60"];
    let mut kills = 0;
    for step in 0..40 {
        let mut child = place.start(&extend);
        thread::sleep(Duration::from_millis(2 + 3 * step));
        if child.try_wait().unwrap().is_none() {
            child.kill().unwrap();
            kills += 1;
        }
        child.wait().unwrap();
        // Without the option, what is there is finished: the earlier run or the extended one.
        if step % 4 == 3 {
            place.good(&["resume", "killed"]);
            let generations = place.text("killed/generations.csv").lines().count() - 1;
            assert!([20, 60].contains(&generations), "{generations}");
            place.good(&["verify", "killed"]);
            fs::remove_dir_all(place.at("killed")).unwrap();
            run("killed", "20");
        }
    }
    assert!(kills > 0);
    place.good(&extend);
    place.assert_same_run("whole", "killed");
    place.good(&["verify", "killed"]);
    // What others put there is not moved.
    #[cfg(unix)]
    {
        fs::create_dir(place.at("mine")).unwrap();
        place.write("mine/thesis.tex", "");
        std::os::unix::fs::symlink("../mine", place.at("killed/extension")).unwrap();
        for command in [&extend[..], &["resume", "killed"]] {
            let refusal = ["killed/extension: is not what `oneiro resume --generations` writes"];
            place.run(command).exits(3).says(&refusal);
        }
        assert!(place.at("mine/thesis.tex").exists());
        place.good(&["verify", "killed"]);
    }
}

/// A new run goes on from another's champion, or from its last generation, and keeps a copy of what it began with.
#[test]
fn a_run_begins_with_genomes_of_another() {
    let place = Place::with_experiment("warm", EXPERIMENT);
    place.good(&["run", "small.toml", "--seed", "1", "--out", "first"]);
    let run = |out: &str, more: &[&str]| {
        let run = [
            "run",
            "small.toml",
            "--seed",
            "2",
            "--out",
            out,
            "--set",
            "evolution.generations=5",
        ];
        place.good(&[&run[..], more].concat());
    };
    let init = "evolution.init=first";
    for kind in ["genetic", "cma-es", "sep-cma-es", "open-es", "differential-evolution"] {
        let set = format!("evolution.kind={kind}");
        run(kind, &["--set", &set, "--set", init]);
        place.good(&["verify", kind]);
        place.good(&["verify", "--recompute", kind]);
        let copy = place.json(kind, "inputs/first.json");
        assert_eq!(copy["genome"], place.json("first", "champion.json")["genome"]);
        assert_eq!(copy["result"], place.hash("first"));
        let input = &place.json(kind, "meta.json")["inputs"][0];
        assert_eq!(
            (&input["file"], &input["from"]),
            (&"inputs/first.json".into(), &"first".into())
        );
        assert_eq!(
            input["blake3"],
            blake3::hash(&place.read(format!("{kind}/inputs/first.json")))
                .to_hex()
                .as_str()
        );
        // Its copy alone makes it again.
        place.good(&["run", &format!("{kind}/config.toml"), "--out", &format!("{kind}-again")]);
        assert_eq!(place.hash(kind), place.hash(&format!("{kind}-again")));
        place.good(&["resume", kind, "--generations", "7"]);
        place.good(&["verify", kind]);
    }
    run("last", &["--set", "evolution.init=first/population.npy"]);
    let (last, individuals) = (place.read("first/population.npy"), place.read("last/individuals.npy"));
    assert_eq!(
        last[last.len() - 4 * 20 * 18..][..72],
        individuals[individuals.len() - 4 * 5 * 20 * 19..][..72]
    );
    place.run(&["check", "small.toml", "--set", init]).exits(0).says(&[]);
    let shown = place.good(&["check", "small.toml", "--set", init]);
    assert!(
        shown.contains("begins with 1 genome of first: the first individuals; the others are mutated copies"),
        "{shown}"
    );

    // Refusals: no effect, other genes, a run that is not finished, one that was changed.
    let refused = |more: &[&str], words: &[&str]| {
        place
            .run(&[&["check", "small.toml"][..], more].concat())
            .exits(3)
            .says(words);
    };
    refused(
        &["--set", init, "--set", "evolution.kind=random"],
        &["evolution.init: is given, but with random all genomes are random; allowed: only with kind = \"genetic\""],
    );
    refused(
        &["--set", init, "--set", "controller.kind=recurrent"],
        &["first/champion.json: has genomes of 18 genes with other names"],
    );
    refused(
        &[
            "--set",
            "evolution.init=first/population.npy",
            "--set",
            "evolution.population=10",
            "--set",
            "evolution.parents=5",
        ],
        &["first/population.npy holds 20 genomes; allowed: 1 to 10, evolution.population"],
    );
    fs::remove_file(place.at("first/DONE")).unwrap();
    refused(&["--set", init], &["first: is not finished"]);
    place.write("genetic/inputs/first.json", "{\"genome\": []}");
    place
        .run(&["verify", "genetic"])
        .exits(3)
        .says(&["inputs/first.json has changed"]);
}

/// Of two processes on one run, only one works.
#[test]
fn a_run_has_one_writer() {
    let place = Place::with_experiment(
        "writer",
        &EXPERIMENT.replace("generations = 30", "generations = 1000000"),
    );
    let mut child = place.start(&["run", "small.toml", "--seed", "1", "--out", "run"]);
    wait_for(|| !place.checkpoints("run").is_empty());
    place
        .run(&["resume", "run"])
        .exits(3)
        .says(&["another process is working on this run"]);
    place
        .run(&["run", "small.toml", "--seed", "1", "--out", "run"])
        .exits(3);
    child.kill().unwrap();
    child.wait().unwrap();
}

#[cfg(unix)]
mod unix {
    use super::*;

    fn signal(child: &Child, name: &str) {
        let sent = Command::new("kill")
            .args([name, &child.id().to_string()])
            .status()
            .unwrap();
        assert!(sent.success());
    }

    /// Ctrl-C and SIGTERM stop a run at a checkpoint, whatever its interval, exit 75.
    #[test]
    fn a_run_is_stopped_and_resumed() {
        let experiment = EXPERIMENT
            .replace("generations = 30", "generations = 3000")
            .replace("every = 4", "every = 1000000");
        let place = Place::with_experiment("stop", &experiment);
        place.good(&["run", "small.toml", "--seeds", "1..2", "--out", "whole"]);
        let mut arguments = vec!["run", "small.toml", "--seeds", "1..2", "--out", "stopped"];
        let mut stops = 0;
        for name in ["-INT", "-TERM"] {
            let child = place.start(&arguments);
            // From then on it handles signals. A fast machine may have finished already.
            let has_begun = || {
                let meta = fs::read_to_string(place.at("stopped/seed-2/meta.json")).unwrap_or_default();
                meta.contains("\"running\"") || meta.contains("\"done\"")
            };
            wait_for(has_begun);
            thread::sleep(Duration::from_millis(100));
            signal(&child, name);
            let output = child.wait_with_output().unwrap();
            let said = String::from_utf8(output.stderr).unwrap();
            if output.status.code() == Some(75) {
                assert!(said.contains("oneiro resume stopped"), "{said}");
                // A run without a finished generation has nothing to keep.
                let unborn = said.contains("stopped/seed-1  (generation 0)");
                assert!(unborn || !place.checkpoints("stopped/seed-1").is_empty(), "{said}");
                stops += 1;
            } else {
                assert_eq!(output.status.code(), Some(0), "{said}");
            }
            arguments = vec!["resume", "stopped"];
        }
        assert!(stops > 0, "the run was too short to be stopped");
        place.good(&["resume", "stopped"]);
        for seed in ["seed-1", "seed-2"] {
            let (whole, stopped) = (format!("whole/{seed}"), format!("stopped/{seed}"));
            place.assert_same_run(&whole, &stopped);
        }
    }
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod disks {
    use super::*;
    use crate::faults::{Fault, Faults};
    use crate::place::Ran;

    /// Runs a command on a disk that is full for a file, which must be said.
    fn full(place: &Place, faults: &Faults, arguments: &[&str], file: &str) {
        let mut command = faults.named(place.command(arguments), file, Fault::Full);
        let words = format!("{}: No space left on device", file.strip_suffix(".tmp").unwrap_or(file));
        Ran::new(arguments, &command.output().unwrap())
            .exits(6)
            .says(&[words.trim_start_matches('/')]);
    }

    fn faults(place: &Place) -> Faults {
        Faults::below(place, &fs::canonicalize(place.at(".")).unwrap())
    }

    /// A damaged checkpoint is reported and skipped in favour of the one before; without a good one, exit 5.
    #[test]
    fn a_damaged_checkpoint_is_not_used() {
        let place = Place::with_experiment("damaged", EXPERIMENT);
        place.good(&["run", "small.toml", "--seed", "1", "--out", "whole"]);
        let faults = faults(&place);
        // Nothing can be written after the run's last checkpoint.
        let interrupted = |name: &str| {
            let out = fs::canonicalize(place.at(".")).unwrap().join(name);
            let run = ["run", "small.toml", "--seed", "1", "--out", out.to_str().unwrap()];
            full(&place, &faults, &run, "/champion.json.tmp");
            let checkpoints = place.checkpoints(name);
            assert_eq!(checkpoints.len(), 2);
            checkpoints
        };
        let checkpoints = interrupted("cut");
        let content = fs::read(&checkpoints[0]).unwrap();
        fs::write(&checkpoints[0], &content[..content.len() - 1]).unwrap();
        place
            .run(&["resume", "cut"])
            .exits(0)
            .says(&["checkpoint-28: is cut off or damaged; it is not used"]);
        place.assert_same_run("whole", "cut");

        for checkpoint in interrupted("flipped") {
            let mut content = fs::read(&checkpoint).unwrap();
            let middle = content.len() / 2;
            content[middle] ^= 1;
            fs::write(&checkpoint, content).unwrap();
        }
        place
            .run(&["resume", "flipped"])
            .exits(5)
            .says(&["this run has no intact checkpoint"]);

        // The files that a checkpoint relies on are checked too.
        interrupted("rows");
        let rows = place.text("rows/generations.csv");
        place.write("rows/generations.csv", rows.replacen("\n3,", "\n33,", 1));
        place
            .run(&["resume", "rows"])
            .exits(5)
            .says(&["generations.csv is not what it was then"]);
        interrupted("edited");
        let config = place.text("edited/config.toml");
        place.write("edited/config.toml", config.replace("cycles = 40", "cycles = 41"));
        place
            .run(&["resume", "edited"])
            .exits(5)
            .says(&["belongs to another experiment than config.toml"]);
    }

    /// If any file can't be written for lack of space: exit 6, and once there is space again the run resumes and ends
    /// with the same results.
    #[test]
    fn a_full_disk_costs_nothing_but_time() {
        let place = Place::with_experiment("full", EXPERIMENT);
        let faults = faults(&place);
        place.good(&["run", "small.toml", "--seed", "1", "--out", "whole"]);
        let files = ["config.toml", "meta.json", "checkpoint-4", "checkpoint-28"];
        for file in files.into_iter().chain(RESULTS.into_iter().filter(|file| {
            // These are append-only, and not written at once.
            !["config.toml", "generations.csv", "individuals.npy"].contains(file)
        })) {
            let name = format!("run-{file}");
            let out = fs::canonicalize(place.at(".")).unwrap().join(&name);
            let run = ["run", "small.toml", "--seed", "1", "--out", out.to_str().unwrap()];
            full(&place, &faults, &run, &format!("/{file}.tmp"));
            assert!(!out.join(format!("{file}.tmp")).exists());
            let is_run = out.join("config.toml").exists();
            if is_run {
                assert!(place.good(&["list", &name]).contains(" interrupted "));
                place
                    .run(&["verify", &name])
                    .exits(1)
                    .says(&["is not finished", "oneiro resume"]);
            }
            let resume = ["resume", &*name];
            place.good(if is_run { &resume[..] } else { &run });
            place.assert_same_run("whole", &name);
        }
        // And if append-only files can't be written.
        for file in ["generations.csv", "individuals.npy"] {
            let name = format!("run-{file}");
            fs::create_dir(place.at(&name)).unwrap();
            fs::copy(place.at("whole/config.toml"), place.at(&name).join("config.toml")).unwrap();
            let out = fs::canonicalize(place.at(&name)).unwrap();
            full(&place, &faults, &["resume", out.to_str().unwrap()], &format!("/{file}"));
            assert!(place.good(&["list", &name]).contains(" interrupted "));
            place.good(&["resume", &name]);
            place.assert_same_run("whole", &name);
        }
    }
}
