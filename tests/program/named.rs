//! Runs that a person can name: the directories that they get, the names by which commands find them, and what to type next.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use crate::fixtures::{SMALL, episode, foragers, study};
use crate::place::{Place, Ran};

impl Place {
    /// A place with a small experiment and a sweep of it.
    fn with_small(name: &str) -> Self {
        let place = Self::new(name);
        place.write("small.toml", SMALL);
        place.write(
            "sweep.toml",
            "experiment = \"small.toml\"\nseeds = \"1..2\"\n[grid]\nnoise.motor = [0.0, 0.1]\n",
        );
        place
    }

    /// Runs the small experiment.
    #[track_caller]
    fn run_small(&self, more: &[&str]) -> Ran {
        self.run(&[&["run", "small.toml", "--backend", "cpu"], more].concat())
            .exits(0)
    }

    /// The names in `runs`.
    fn run_names(&self) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(self.at("runs"))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

#[test]
fn a_run_has_its_experiments_name_and_its_seed_and_a_letter_if_that_is_another_runs() {
    let place = Place::with_small("names");
    let first = place.run_small(&["--seed", "1"]);
    assert!(first.stdout.contains("runs/small-1\n"), "{}", first.stdout);
    assert!(!first.stderr.contains("small-1-b"), "{}", first.stderr);
    place.run_small(&["--seed", "1"]).says(&["the run is already done"]);
    // What is recorded changes no result.
    place
        .run_small(&["--seed", "1", "--set", "record.checkpoint_every=2"])
        .says(&["the run is already done"]);
    assert_eq!(place.run_names(), ["small-1"]);
    let wide = ["--seed", "1", "--set", "cycles=30"];
    let why =
        "runs/small-1 holds a run with other settings (cycles: 20 there, 30 here), so this goes to runs/small-1-b";
    place.run_small(&wide).says(&[why]);
    let again = place.run_small(&wide).says(&["the run is already done"]);
    assert!(again.stdout.contains("runs/small-1-b\n"), "{}", again.stdout);
    // An edited file.
    place.write("small.toml", SMALL.replace("generations = 6", "generations = 5"));
    let edited = "(evolution.generations: 6 there, 5 here), so this goes to runs/small-1-c";
    place.run_small(&["--seed", "1"]).says(&[edited]);
    assert_eq!(place.run_names(), ["small-1", "small-1-b", "small-1-c"]);
    place.write("small.toml", SMALL);
    // A run with a letter is found although the one before it is gone, and goes on.
    for name in ["runs/small-1", "runs/small-1-c"] {
        fs::remove_dir_all(place.at(name)).unwrap();
    }
    let result = place.text("runs/small-1-b/DONE");
    fs::remove_file(place.at("runs/small-1-b/DONE")).unwrap();
    let resumed = place.run_small(&wide).says(&["continued"]);
    assert!(resumed.stdout.contains("runs/small-1-b\n"), "{}", resumed.stdout);
    assert_eq!(place.text("runs/small-1-b/DONE"), result);
    // Somebody else's files, and a file.
    fs::create_dir(place.at("runs/small-2")).unwrap();
    place.write("runs/small-2/notes.txt", "mine");
    place.write("runs/small-3", "mine");
    place.run_small(&["--seeds", "2..4"]).says(&[
        "runs/small-2 holds other files, such as notes.txt, so this goes to runs/small-2-b",
        "runs/small-3 is something else, so this goes to runs/small-3-b",
        "wrote 3 runs: runs/small-2-b to runs/small-4",
        "next: oneiro list",
    ]);
    // A finished run that was changed since is not begun anew under another name.
    let config = place.text("runs/small-4/config.toml");
    place.write("runs/small-4/config.toml", config.replace("cycles = 20", "cycles = 21"));
    place
        .run(&["run", "small.toml", "--seed", "4"])
        .exits(5)
        .says(&["was changed since the run was finished"]);
    // A directory that is named is used or refused.
    place
        .run(&["run", "small.toml", "--seed", "7", "--out", "runs/small-1-b"])
        .exits(3)
        .says(&["name another directory with --out"]);
}

/// Processes that begin at once with one name and different settings each get a directory of their own.
#[test]
fn processes_that_begin_at_once_share_no_directory() {
    const PROCESSES: u32 = 6;
    let place = Place::with_small("race");
    for round in 1..=3 {
        let seed = round.to_string();
        let begun: Vec<_> = (0..PROCESSES)
            .map(|own| {
                let set = format!("cycles={}", 20 + own);
                let arguments = ["run", "small.toml", "--seed", &seed, "--set", &set, "--backend", "cpu"];
                place.start(&arguments)
            })
            .collect();
        let mut directories = BTreeSet::new();
        for (own, child) in begun.into_iter().enumerate() {
            let ran = Ran::ended(&["run"], child).exits(0);
            let (_, directory) = ran.stdout.trim_end().rsplit_once(' ').unwrap();
            let config = place.text(format!("{directory}/config.toml"));
            assert!(config.contains(&format!("\ncycles = {}\n", 20 + own)), "{directory}");
            directories.insert(directory.to_owned());
        }
        let letters = ["", "-b", "-c", "-d", "-e", "-f"];
        let expected: BTreeSet<String> = letters.map(|own| format!("runs/small-{seed}{own}")).into();
        assert_eq!(directories, expected);
    }
}

#[test]
fn a_study_has_its_papers_name_and_its_seed_and_a_letter_if_that_is_another_studys() {
    let place = Place::new("study");
    let short = [
        (
            "\n[set]\n",
            "\n[set]\nswarm.minutes = 4\nswarm.light_moves_minute = 2\n",
        ),
        ("scales = [2.0, 0.2, 0.02]", "scales = [0.2]"),
        ("credits = [\"lagged\", \"matched\"]", "credits = [\"lagged\"]"),
    ];
    place.write("odowd.toml", study("odowd2014", &short));
    let reproduce = |runs: &str| {
        let words = [
            "reproduce",
            "odowd2014",
            "--study",
            "odowd.toml",
            "--only-cases",
            "--backend",
            "cpu",
        ];
        place.run(&[&words[..], &["--runs", runs]].concat()).exits(0)
    };
    reproduce("2").says(&["wrote runs/odowd2014-1: report.html, claims.json"]);
    reproduce("2");
    assert_eq!(place.run_names(), ["odowd2014-1"]);
    let why = "runs/odowd2014-1 holds the study with other arguments, so this goes to runs/odowd2014-1-b";
    reproduce("3").says(&[why, "wrote runs/odowd2014-1-b"]);
    assert_eq!(place.run_names(), ["odowd2014-1", "odowd2014-1-b"]);
}

#[test]
fn a_name_its_beginning_or_nothing_means_a_run() {
    let place = Place::with_small("found");
    for command in ["replay", "verify", "resume", "list"] {
        place
            .run(&[command])
            .exits(3)
            .says(&["runs: has no runs yet; `oneiro run EXPERIMENT.toml --seed 1` makes one"]);
    }
    place.write("other.toml", SMALL);
    place.good(&["run", "other.toml", "--seed", "9", "--quiet"]);
    place.run_small(&["--seeds", "1..12", "--quiet"]);
    let verified = |words: &[&str]| place.good(&[&["verify"], words].concat());
    let of_other = verified(&["runs/other-9"]);
    for words in ["other-9", "oth", "runs/oth", "./runs/other-9"] {
        let directory = if words.starts_with("./") { words } else { "runs/other-9" };
        assert_eq!(
            verified(&[words]),
            of_other.replace("runs/other-9", directory),
            "{words}"
        );
    }
    // A whole name is not the beginning of others.
    assert!(verified(&["small-1"]).ends_with("  runs/small-1\n"));
    let several = "small-: is the beginning of 12 names: runs/small-1, runs/small-2, runs/small-3, runs/small-4, runs/small-5 and 7 more";
    place.run(&["replay", "small-"]).exits(3).says(&[several]);
    place
        .run(&["evaluate", "--genomes", "small-1"])
        .exits(0)
        .says(&["next: oneiro replay small-1 --seed"]);
    for command in ["replay", "resume", "verify"] {
        place
            .run(&[command, "smal-12"])
            .exits(3)
            .says(&["smal-12: does not exist; did you mean runs/small-12?"]);
    }
    place
        .run(&["verify", "zebra"])
        .exits(3)
        .says(&["zebra: does not exist; `oneiro list` shows the runs here"]);
    // The newest is the one that was begun last, whatever was written since.
    place.good(&["run", "other.toml", "--seed", "3", "--quiet"]);
    place.good(&["replay", "small-2"]);
    for command in ["replay", "resume", "verify"] {
        let ran = place.run(&[command]).exits(0).says(&["the newest run is runs/other-3"]);
        assert!(!ran.stdout.contains("newest"), "{}", ran.stdout);
    }
    let listed = place.good(&["list"]);
    let names: Vec<&str> = listed.lines().map(|line| line.split(' ').next().unwrap()).collect();
    assert_eq!(names[..2], ["run", "other-3"]);
    assert_eq!((names.len(), *names.last().unwrap()), (15, "other-9"));
    // What is in this folder comes first.
    place.good(&["run", "other.toml", "--seed", "5", "--out", "other-9", "--quiet"]);
    assert!(verified(&["other-9"]).ends_with("  other-9\n"));
    assert!(place.good(&["list"]).contains("\nruns/other-9 "));
    // Sweeps too.
    place.good(&["sweep", "run", "sweep.toml", "--quiet", "--backend", "cpu"]);
    assert!(verified(&["swee"]).ends_with("  sweeps/sweep\n"));
    place
        .run(&["sweep", "status", "sw"])
        .exits(0)
        .says(&["next: oneiro sweep report sweep"]);
    place
        .run(&["sweep", "report", "sweeep"])
        .exits(3)
        .says(&["did you mean sweeps/sweep?"]);
    for command in ["status", "report"] {
        place
            .run(&["sweep", command])
            .exits(0)
            .says(&["the newest sweep is sweeps/sweep"]);
    }
    // Experiments and their folders.
    fs::create_dir(place.at("experiments")).unwrap();
    place.write("experiments/gather.toml", SMALL);
    for (typed, meant) in [
        ("experimets/gather.toml", "experiments/gather.toml"),
        ("experiments/gahter.toml", "experiments/gather.toml"),
        ("experimets/gahter", "experiments/gather.toml"),
        ("gather.toml", "experiments/gather.toml"),
        ("smal.toml", "small.toml"),
    ] {
        for command in ["run", "check"] {
            let hint = format!("did you mean {meant}?");
            place.run(&[command, typed]).exits(3).says(&[&hint]);
        }
    }
}

#[test]
fn lists_fit_a_hundred_characters() {
    let place = Place::new("wide");
    let name = format!("{}-arena", "long-".repeat(5));
    place.write(format!("{name}.toml"), SMALL);
    place.write("small.toml", SMALL);
    let file = format!("{name}.toml");
    place.good(&["run", &file, "--seed", "1", "--quiet"]);
    place.good(&["run", &file, "--seed", "2", "--out", "runs/also", "--quiet"]);
    place.good(&["run", "small.toml", "--seed", "1", "--quiet"]);
    for more in [&[][..], &["runs"], &["runs/also"], &["runs/also", "--verbose"]] {
        let text = place.good(&[&["list"], more].concat());
        let longest = text.lines().map(|line| line.chars().count()).max().unwrap();
        // A whole hash has 64 digits.
        let most = if more.contains(&"--verbose") { 152 } else { 100 };
        assert!(longest <= most, "{longest}\n{text}");
    }
    let text = place.good(&["list", "runs"]);
    assert!(
        text.contains("\nalso ") && text.contains(&format!("\n{name}-1 ")),
        "{text}"
    );
}

#[test]
fn hashes_have_twelve_digits_unless_all_are_wanted() {
    let place = Place::with_small("hashes");
    let digits = |text: &str| -> Vec<usize> {
        let words = text.split(|c: char| !c.is_ascii_alphanumeric());
        let is_hash = |word: &&str| word.len() >= 12 && word.chars().all(|c| "0123456789abcdef".contains(c));
        words.filter(is_hash).map(str::len).collect()
    };
    for (seed, more, count) in [("1", &[][..], 12), ("2", &["-v"], 64), ("3", &["--verbose"], 64)] {
        let name = format!("small-{seed}");
        let ran = place.run_small(&[&["--seed", seed], more].concat());
        assert_eq!(digits(&ran.stdout), [count]);
        for command in [
            &["verify", &name][..],
            &["verify", "--recompute", &name],
            &["list", &name],
        ] {
            assert_eq!(digits(&place.good(&[command, more].concat())), [count], "{command:?}");
        }
        let json = place.good(&["verify", &name, "--json"]);
        assert_eq!(digits(&json), [64, 64], "{json}");
    }
    for (out, more, count) in [("a", &[][..], 12), ("b", &["-v"], 64)] {
        let run = ["sweep", "run", "sweep.toml", "--backend", "cpu", "--out", out];
        assert_eq!(digits(&place.good(&[&run, more].concat())), [count]);
        for command in [
            &["verify", out][..],
            &["sweep", "merge", out],
            &["sweep", "extract", out, "0"],
        ] {
            assert_eq!(digits(&place.good(&[command, more].concat())), [count], "{command:?}");
        }
    }
}

#[test]
fn checks_and_plans_say_how_long() {
    let place = Place::with_small("long");
    let checked = place.run(&["check", "small.toml"]).exits(0);
    let took = checked
        .stderr
        .lines()
        .find(|line| line.starts_with("a run takes about "));
    assert!(
        took.is_some_and(|line| line.contains(" s here on cpu (")),
        "{}",
        checked.stderr
    );
    assert_eq!(place.run(&["check", "small.toml", "--quiet"]).exits(0).stderr, "");
    let equal = place.run(&["sweep", "plan", "sweep.toml"]).exits(0);
    assert!(!equal.stderr.contains("unequal"), "{}", equal.stderr);
    place.write(
        "unequal.toml",
        "experiment = \"small.toml\"\nseeds = \"1..3\"\n[grid]\nevolution.generations = [6, 60]\ntrials = [1, 2]\n",
    );
    let plan = place.run(&["sweep", "plan", "unequal.toml"]).exits(0).says(&[
        "the cells have unequal budgets: 71 (evolution.generations = 6, trials = 1) to 755 (evolution.generations = 60, trials = 2) \
         episodes a run",
        "next: oneiro sweep run unequal.toml",
    ]);
    let cells: Vec<Vec<&str>> = plan
        .stdout
        .lines()
        .skip_while(|line| !line.starts_with("cell "))
        .map(|line| line.split_whitespace().collect())
        .take(5)
        .collect();
    assert_eq!(cells[0][..3], ["cell", "evolution.generations", "trials"]);
    let episodes: Vec<&str> = cells[1..].iter().map(|row| row[3]).collect();
    assert_eq!(episodes, ["71", "107", "395", "755"]);
    let value: serde_json::Value =
        serde_json::from_str(&place.good(&["sweep", "plan", "unequal.toml", "--json"])).unwrap();
    let device = &value["devices"][0];
    let seconds = |value: &serde_json::Value| value.as_f64().unwrap();
    let cells: Vec<f64> = device["cells"].as_array().unwrap().iter().map(seconds).collect();
    let sum: f64 = cells.iter().sum();
    assert_eq!(cells.len(), 4);
    assert!(
        cells.iter().all(|own| *own > 0.0) && (sum / seconds(&device["seconds"]) - 1.0).abs() < 1e-9,
        "{device}"
    );
    assert_eq!(value["runs"][11]["episodes"], 755);
    // Swarms with on-board simulators have no such budget.
    place.write("swarm.toml", foragers(2, ""));
    place.write(
        "swarms.toml",
        "experiment = \"swarm.toml\"\nseeds = \"1..2\"\n[grid]\nswarm.minutes = [2, 3]\n",
    );
    let plan = place.run(&["sweep", "plan", "swarms.toml"]).exits(0);
    assert!(!plan.stderr.contains("unequal"), "{}", plan.stderr);
    place
        .run(&["check", "swarm.toml"])
        .exits(0)
        .says(&["a run takes about "]);
}

/// Commands that make or check something say what to type next; that is typed here, and what it says next too.
#[test]
fn what_is_next_can_be_typed() {
    let place = Place::with_small("next");
    place.write("swarm.toml", foragers(2, ""));
    fs::create_dir(place.at("lives")).unwrap();
    for (name, text) in episode() {
        place.write(format!("lives/{name}"), text);
    }
    let mut todo: Vec<String> = [
        "new mine",
        "check small.toml --set cycles=30",
        "check small.toml --cost",
        "run small.toml --seeds 1..2 --out many",
        "run small.toml --seeds 3..4",
        "run swarm.toml --seed 1",
        "resume small-3",
        "verify many",
        "sweep plan sweep.toml",
        "sweep run sweep.toml --shard 1/2 --out shards",
        "sweep run sweep.toml --shard 2/2 --out shards",
        "evaluate small.toml --random 3",
        "evaluate --genomes small-3 --trials 3",
        "evaluate small.toml --genomes small-3 --best --trials 3",
        "evaluate small.toml --genomes runs/small-3/champion.npy",
        "evaluate small.toml --genomes sweeps/sweep",
        "robot sample --objects wall --out samples",
        "robot calibrate small.toml --log lives --out calibration",
    ]
    .map(str::to_owned)
    .into();
    // A new experiment's run is short.
    todo.reverse();
    let mut typed = BTreeSet::new();
    let mut with_next: BTreeMap<String, u32> = BTreeMap::new();
    while let Some(command) = todo.pop() {
        if !typed.insert(command.clone()) {
            continue;
        }
        let words: Vec<&str> = command.split(' ').collect();
        let ran = place.run(&words).exits(0);
        if words[0] == "new" {
            let text = place.text("mine.toml");
            place.write("mine.toml", text.replace("generations = 200", "generations = 2"));
        }
        let groups = ["sweep", "robot"];
        let name = words[..=usize::from(groups.contains(&words[0]))].join(" ");
        for line in ran.stderr.lines() {
            let Some((_, next)) = line.split_once("next: ") else {
                continue;
            };
            for command in next.split(", then ") {
                let command = command.strip_prefix("oneiro ").unwrap_or_else(|| panic!("{line}"));
                todo.push(command.to_owned());
                *with_next.entry(name.clone()).or_default() += 1;
            }
        }
        // Once, and last.
        let after = ran.stderr.split_once("\nnext: ").map_or("", |(_, after)| after);
        assert!(after.trim_end().lines().count() <= 1, "{}", ran.stderr);
    }
    let commands: Vec<&str> = with_next.keys().map(String::as_str).collect();
    assert_eq!(
        commands,
        [
            "check",
            "evaluate",
            "new",
            "replay",
            "resume",
            "robot calibrate",
            "robot sample",
            "run",
            "sweep extract",
            "sweep merge",
            "sweep plan",
            "sweep report",
            "sweep run",
            "verify"
        ],
        "{typed:?}"
    );
    assert!(typed.len() > 35, "{typed:?}");
    // Nothing of it is data, and whoever wants silence has it.
    let json: serde_json::Value = serde_json::from_str(&place.good(&["verify", "small-3", "--json"])).unwrap();
    assert!(json.is_array());
    assert_eq!(place.run(&["verify", "small-3", "--quiet"]).exits(0).stderr, "");
}
