//! Refusals, which leave everything unchanged.

use super::*;

/// Runs a command that must be refused with this exit code and these words, without changing any file.
#[track_caller]
fn refused(place: &Place, arguments: &[&str], code: i32, words: &[&str]) {
    let before = files(&place.at("."));
    let ran = place.run(arguments).exits(code).says(words);
    assert!(ran.stdout.is_empty(), "{}", ran.stdout);
    let after = files(&place.at("."));
    let names = |files: &Files| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&after), names(&before), "oneiro {}", arguments.join(" "));
    assert!(after == before, "oneiro {}: a file has changed", arguments.join(" "));
}

#[test]
fn leave_directories_of_other_sweeps_as_they_are() {
    let place = Place::with_sweep("others", SWEEP);
    place.swept("out", &[]);
    for (from, to, words) in [
        (
            "1..3",
            "1..4",
            "out: is of another sweep, of 12 runs in 4 cells; this one has 16 in 4",
        ),
        (
            "1..3",
            "2..4",
            "out: is of another sweep: as many runs, but of other values, seeds or files",
        ),
        ("0.4]", "0.5]", "out: is of another sweep: as many runs"),
        ("signed", "unsigned", "out: is of another sweep: as many runs"),
        (
            "[set]",
            "[reality]\nrobots = [1]\n[set]",
            "out: is of another sweep: as many runs",
        ),
    ] {
        place.write("sweep.toml", SWEEP.replacen(from, to, 1));
        refused(&place, &sweep("out", &[]), 3, &[words, "--out"]);
        refused(&place, &sweep("out", &["--shard", "1/2"]), 3, &[words]);
    }
    place.write("sweep.toml", SWEEP);
    place.write("small.toml", EXPERIMENT.replace("cycles = 40", "cycles = 41"));
    refused(&place, &sweep("out", &[]), 3, &["out: is of another sweep"]);
    place.write("small.toml", EXPERIMENT);

    // Made by another program.
    let made = place.text("out/sweep.json");
    let content: Value = serde_json::from_str(&made).unwrap();
    let version = env!("CARGO_PKG_VERSION");
    for (key, value, words) in [
        (
            "program",
            Value::from("0.0.9"),
            format!("out: was made by oneiro 0.0.9; this is {version}"),
        ),
        (
            "kernels",
            Value::from("f00dé"),
            "out: was made with other kernels (f00dé".into(),
        ),
        (
            "kernels",
            Value::from("ééééé"),
            "out: was made with other kernels (é".into(),
        ),
        (
            "kernels",
            Value::from("aéééé"),
            "out: was made with other kernels (aé".into(),
        ),
        ("format", Value::from("oneiro swap"), "\"oneiro swap\"".into()),
        (
            "version",
            Value::from(1),
            "out: is of version 1 of the format \"oneiro sweep\"; allowed: version 4".into(),
        ),
    ] {
        let mut other = content.clone();
        other[key] = value;
        place.write("out/sweep.json", other.to_string());
        refused(&place, &sweep("out", &[]), 3, &[&words]);
        refused(&place, &["sweep", "extract", "out", "0"], 3, &[&words]);
        refused(&place, &["sweep", "merge", "out"], 3, &[&words]);
    }
    place.write("out/sweep.json", &made[..made.len() / 2]);
    refused(&place, &sweep("out", &[]), 5, &["out/sweep.json"]);
    // A control: in its original state it is accepted.
    place.write("out/sweep.json", made);
    place.swept("out", &[]);
}

#[test]
fn leave_what_is_no_sweep_as_it_is() {
    let place = Place::with_sweep("mine", SWEEP);
    for name in [
        "mine/thesis.tex",
        "dot/.hidden",
        "own/sweep.toml",
        "named/experiment/small.toml",
        "locked/lock/key",
    ] {
        fs::create_dir_all(place.at(name).parent().unwrap()).unwrap();
        place.write(name, "written in years");
    }
    for out in ["mine", "dot", "own", "named", "locked", "."] {
        let words = format!("{out}: exists and holds other files, and nothing is overwritten");
        refused(&place, &sweep(out, &[]), 3, &[&words, "--out"]);
    }
    refused(
        &place,
        &sweep("small.toml", &[]),
        3,
        &["small.toml: is a file; allowed: a directory's name"],
    );
    for out in ["mine", "nowhere", "small.toml"] {
        for command in [&["status", out][..], &["merge", out], &["extract", out, "0"]] {
            refused(&place, &[&["sweep"], command].concat(), 3, &[out]);
        }
    }
    // An empty directory, and one whose creation was interrupted, are accepted.
    fs::create_dir(place.at("empty")).unwrap();
    place.swept("empty", &[]);
    fs::create_dir_all(place.at("begun/experiment")).unwrap();
    for name in ["lock", "sweep.toml", "experiment/small.toml"] {
        fs::copy(place.at("empty").join(name), place.at("begun").join(name)).unwrap();
    }
    place.write("begun/sweep.json.tmp", "{");
    place.swept("begun", &[]);
    place.assert_same_tables("empty", "begun");
}

#[test]
fn of_shards_that_do_not_fit_together_say_why() {
    let place = Place::with_sweep("fit", SWEEP);
    place.good(&sweep("one", &["--shard", "1/2"]));
    place.good(&sweep("third", &["--shard", "3/3"]));
    let merge = |dirs: &[&'static str]| [&["sweep", "merge"], dirs].concat();
    for (dirs, words) in [
        (&["one"][..], "6 of 12 runs are missing: 1, 3, 5, 7, 9, 11;"),
        (&["one", "third"], "4 of 12 runs are missing: 1, 3, 7, 9;"),
        (&["third"], "8 of 12 runs are missing: 0, 1, 3, 4, 6, 7, 9, 10;"),
    ] {
        refused(&place, &merge(dirs), 1, &[words, "`oneiro sweep run`"]);
    }
    place.write("sweep.toml", SWEEP.replace("0.4", "0.5"));
    place.good(&sweep("other", &["--shard", "2/2"]));
    place.write("sweep.toml", SWEEP.replace("1..3", "1..2"));
    place.good(&sweep("fewer", &["--shard", "2/2"]));
    for (other, words) in [
        ("other", "other: is of another sweep: as many runs"),
        (
            "fewer",
            "fewer: is of another sweep, of 8 runs in 4 cells; this one has 12 in 4",
        ),
    ] {
        refused(
            &place,
            &merge(&["one", other]),
            3,
            &[words, "allowed: shards of the sweep in one"],
        );
    }
    refused(&place, &merge(&["one", "nowhere"]), 3, &["nowhere"]);
    refused(&place, &["sweep", "merge"], 2, &[]);
    refused(
        &place,
        &["sweep", "extract", "one", "0", "--out", "third"],
        3,
        &["third: exists and holds other files", "name another directory"],
    );

    // Two machines disagree about a run.
    place.write("sweep.toml", SWEEP);
    place.good(&sweep("two", &["--shard", "2/2"]));
    place.good(&sweep("lie", &[]));
    let log = journal("lie", "results.log");
    let lie = |line: &str| {
        let (_, json) = line.split_once(' ').unwrap();
        let mut line: Value = serde_json::from_str(json).unwrap();
        if line["run"] == 4 {
            line["outcomes"]["best"] = "1000".into();
        }
        let json = line.to_string();
        format!("{} {json}", &blake3::hash(json.as_bytes()).to_hex()[..16])
    };
    let mut lied: Vec<String> = place.text(&log).lines().map(lie).collect();
    lied.push(String::new());
    place.write(log, lied.join("\n"));
    refused(
        &place,
        &merge(&["one", "lie", "two"]),
        5,
        &["run 4 has the result", "one/shard-1-of-2", "lie/shard-1-of-1"],
    );
    place.good(&merge(&["one", "two"]));
    place
        .run(&merge(&["third", "--out", "all"]))
        .exits(1)
        .says(&["8 of 12 runs are missing"]);
}

/// A valid sweep.
const GOOD: &str = r#"experiment = "small.toml"
seeds = "1..3"
[grid]
noise.motor = [0.0, 0.1]
"#;

/// Changes of it, and words of the error messages. A change is the text to replace and its replacement, or begins with
/// `+` for lines before the grid, or with `~` for ranges to draw from there; `/` is the end of a line.
const REFUSED: &str = r#"
# What is not in a sweep.
seeds => sedes
sweep.toml:2:1: | sedes: unknown key | allowed: | seeds
[grid] => [gird]
sweep.toml:3:2: | gird: unknown key | grid
seeds = "1..3" => 
sweep.toml: the sweep lacks `seeds`; allowed: seeds = "1..20", or a list
experiment = "small.toml" => 
sweep.toml: the sweep lacks `experiment`; allowed: experiment = "FILE.toml"
+ [reality] / robots = [1] / number = 3
sweep.toml:5:1: reality.number: unknown key
+ [random] / samples = 1 / seeds = 3
sweep.toml:5:1: random.seeds: unknown key
# What is not in the experiment, or not within its bounds.
noise.motor => noise.moter
sweep.toml:4: | noise.moter: unknown key | allowed: | motor
+ [set] / cycels = 3
sweep.toml:4: | cycels: unknown key | allowed: | cycles
0.1] => 1.5]
sweep.toml:4:21: noise.motor: is 1.5; allowed: 0 to 1
0.1] => "much"]
sweep.toml:4:21: noise.motor: | allowed: a number
0.1] => nan]
sweep.toml:4:21: noise.motor: is NaN; allowed: 0 to 1
+ [set] / cycles = 0
sweep.toml:4:10: cycles: is 0; allowed: 1 to 1000000
+ [set] / evolution.parents = 3
sweep.toml:4:21: evolution.parents:
+ [[list]] / cycles = 9 / [[list]] / cycles = -9
sweep.toml:6:10: cycles: | -9
+ [set] / seed = 3
sweep.toml:4:8: set.seed: | allowed: | seeds
[grid] => [grid] / name = ["a", "b"]
sweep.toml:4:8: grid.name: can't be set or swept; allowed:
small.toml => bad.toml
bad.toml:1:10: cycles: is 0; allowed: 1 to 1000000
small.toml => unknown.toml
unknown.toml:3:1: noise.motr: unknown key
small.toml => none.toml
sweep.toml:1:14: experiment: | none.toml: No such file
"small.toml" => ""
sweep.toml:1:14: experiment:
small.toml => sweep.toml
experiment: sweep.toml: is a sweep's file, not an experiment
[grid] => [gird]
sweep.toml:3:2: gird: unknown key `gird`; did you mean grid? (allowed: name, experiment, seeds, 
+ [random] / sample = 2
sweep.toml:4:1: random.sample: unknown key `sample`; did you mean samples? (allowed: samples, seed, ranges)
# Seeds.
"1..3" => "3..1"
sweep.toml:2:9: seeds: is "3..1", an empty range; allowed: the smaller seed first
"1..3" => []
sweep.toml:2:9: seeds: is empty; allowed: one seed and more
"1..3" => [1, 2, 1]
sweep.toml:2:16: seeds[2]: is 1 a second time; allowed: each seed once
"1..3" => [1, -2]
sweep.toml:2:13: seeds[1]: is -2; allowed: a whole number from 0
"1..3" => [1, 2.5]
sweep.toml:2:13: seeds[1]: is 2.5; allowed: a whole number from 0
"1..3" => 3
sweep.toml:2:9: seeds: is 3; allowed: "A..B" or a list of whole numbers
"1..3" => "1-3"
sweep.toml:2:9: seeds: is "1-3"; allowed: "A..B"
"1..3" => ".."
sweep.toml:2:9: seeds: is ".."; allowed: "A..B"
"1..3" => "1..9999999"
sweep.toml:2:9: seeds: | allowed: | at most 1000000
"1..3" => "1..9223372036854775808"
sweep.toml:2:9: seeds: | 9223372036854775807
# Values.
[0.0, 0.1] => []
sweep.toml:4:15: grid.noise.motor: is empty; allowed: a list of values
[0.0, 0.1] => 0.1
sweep.toml:4:15: grid.noise.motor: is one value; allowed: a list of them, or the table [set]
0.1] => 0.0]
sweep.toml:4:21: grid.noise.motor[1]: is 0.0 a second time; allowed: each value once
0.1] => 0]
sweep.toml:4:21: | noise.motor = 0.0 and noise.motor = 0 are one experiment; allowed: cells that differ
noise.motor = [0.0, 0.1] => cycles = [20, 20.0]
sweep.toml:4:15:
# Values that no cell uses.
+ [[list]] / evolution.kind = "genetic" / evolution.strategy.sigma = 0.5 / [[list]] / evolution.kind = "random" / evolution.strategy.sigma = 0.5
sweep.toml:5:28: evolution.strategy.sigma: is given; allowed: only with | cma-es | no cell of the sweep uses it
+ [set] / evolution.strategy.sigma = 0.5 / [[list]] / evolution.kind = "genetic" / [[list]] / evolution.kind = "random"
sweep.toml:4:28: evolution.strategy.sigma: is given; allowed: only with | cma-es | no cell of the sweep uses it
# Keys that are given twice.
+ [set] / noise.motor = 0.2
sweep.toml:6:16: noise.motor: is already given, as noise.motor (sweep.toml:4:15); allowed: each key once
+ [[list]] / noise.motor = 0.2
sweep.toml:6: | noise.motor: is already given, as noise.motor (sweep.toml:4:15)
+ [random] / samples = 1 / [random.ranges] / noise.motor = { from = 0, to = 1 }
noise.motor: is already given, as noise.motor (sweep.toml:
+ [set] / "noise.motor" = 0.2
noise.motor: is already given, as noise.motor (sweep.toml:4:
noise.motor = [0.0, 0.1] => noise.motor = [0.0] / "noise.motor" = [0.5]
sweep.toml:4:16: noise.motor: is already given, as noise.motor (sweep.toml:4:16)
noise.motor = [0.0, 0.1] => noise = [{ motor = 0.1 }] / [set] / noise.motor = 0.2
noise: is already given, as noise.motor (sweep.toml:6:15); allowed: each key once
+ [[list]] / noise = [0.1]
sweep.toml:6: | noise.motor: is already given, as noise (sweep.toml:4:9); allowed: each key once
noise.motor = [0.0, 0.1] => noise.motor = [0.0] / noise.motor = [0.5]
sweep.toml:5:
# Rows.
+ [[list]] / evolution.kind = "cma-es" / [[list]] / evolution.kind = "random" / evolution.strategy.sigma = 0.5
sweep.toml:7:28: evolution.strategy.sigma: is given; allowed: only with | cma-es | no cell of the sweep uses it
+ [[list]] / evolution.kind = "cma-es" / evolution.strategy.sigma = 0.5 / [[list]] / evolution.kind = "random" / evolution.strategy.sigma = 0.5
sweep.toml:8:28: evolution.strategy.sigma: is given; allowed: only with | cma-es | no cell of the sweep uses it
+ [[list]] / evolution.generations = 2 / evolution.episodes = 9000
sweep.toml:4:25: evolution.generations: is given beside evolution.episodes; allowed: one of them
+ [[list]] / cycles = 1 / [[list]] / cycles = 1
sweep.toml:5:1: list[1]: is there a second time; allowed: each row once
+ [[list]]
sweep.toml:3:1: list[0]: is empty; allowed: keys with a value each
+ [list] / cycles = 1
sweep.toml:3: | list: | allowed: a list
# Ranges.
~ cycles = { from = 3, to = 3 }
sweep.toml:6:10: random.ranges.cycles: is an empty range, 3 to 3; allowed:
~ cycles = { from = 4, to = 3 }
sweep.toml:6:10: random.ranges.cycles: is an empty range, 4 to 3; allowed:
~ noise.walk_range_mm = { from = 0.0, to = 3.0, scale = "log" }
sweep.toml:6:23: random.ranges.noise.walk_range_mm: begins with 0; allowed: above 0
~ cycles = { from = 1, to = 3, scale = "square" }
sweep.toml:6:10: random.ranges.cycles: | allowed: | "linear" or "log"
~ cycles = { from = 1, to = 3, scale = 7 }
sweep.toml:6:10: random.ranges.cycles: | allowed:
~ cycles = { from = 1, to = 3, step = 7 }
random.ranges.cycles: has a key step; allowed:
~ cycles = { from = 1 }
sweep.toml:6:10: random.ranges.cycles: | allowed: { from = A, to = B }
~ cycles = { to = 1 }
sweep.toml:6: | random.ranges.cycles | allowed: { from = A, to = B }
~ cycles = { from = 0.0, to = inf }
sweep.toml:6:10: random.ranges.cycles: | allowed:
~ cycles = 7
sweep.toml:6:10: random.ranges.cycles: is 7; allowed:
+ [random] / samples = 2 / [random.ranges]
random.ranges: is empty; allowed:
+ [random] / samples = 2
sweep.toml:3: | lacks `ranges`
+ [random] / samples = 0 / [random.ranges] / cycles = { from = 1, to = 3 }
sweep.toml:4:11: random.samples: is 0; allowed: 1 to 1000000
~ cycles = { from = 1, to = 3 }
sweep.toml:4:11: random.samples: is 9, but only 3 different draws were found; allowed:
~ noise.sensor = { from = 0.0, to = 1.0 }
sweep.toml:6:16: noise.sensor:
~ task.new_cell = { from = -9.0, to = 1.0 }
sweep.toml:6:17: task.new_cell: is - | allowed:
# Reality.
small.toml" => swarm.toml"
sweep.toml:4:16: noise: unknown key
+ [reality] / robots = []
sweep.toml:4:10: reality.robots: is empty; allowed:
+ [reality] / robots = [1, 2, 2]
sweep.toml:4:17: reality.robots[2]: is there a second time; allowed: each once
+ [reality] / robots = [-1]
sweep.toml:4:10: reality.robots: is of another type; allowed: "own" or a list of whole numbers
+ [reality] / robots = [1] / severity = 11
sweep.toml:5:12: reality.severity: is 11; allowed: 0 to 10
+ [reality] / robots = [1] / severity = nan
sweep.toml:5:12: reality.severity: is NaN; allowed: 0 to 10
# What is no TOML.
[grid] => [grid
sweep.toml:3:
small.toml" => small.toml
sweep.toml:1:
"#;

#[test]
fn of_sweeps_say_where_and_what_is_allowed() {
    let place = Place::with_sweep("bad", GOOD);
    place.write("swarm.toml", "[swarm]\ncase = \"over\"\nrobots = 4\n");
    place.write("bad.toml", "cycles = 0\n");
    place.write("unknown.toml", "cycles = 10\n[noise]\nmotr = 2.0\n");
    place.good(&["sweep", "plan", "sweep.toml", "--no-estimate"]);
    let mut lines = REFUSED
        .lines()
        .filter(|line| !line.is_empty() && !line.starts_with('#'));
    while let (Some(change), Some(words)) = (lines.next(), lines.next()) {
        let broken = change.replace(" / ", "\n");
        let text = if let Some(table) = broken.strip_prefix("+ ") {
            GOOD.replace("[grid]", &format!("{table}\n[grid]"))
        } else if let Some(range) = broken.strip_prefix("~ ") {
            GOOD.replace(
                "[grid]",
                &format!("[random]\nsamples = 9\n[random.ranges]\n{range}\n[grid]"),
            )
        } else {
            let (from, to) = broken.split_once(" => ").unwrap();
            assert!(GOOD.contains(from), "{change}");
            GOOD.replacen(from, to, 1)
        };
        place.write("sweep.toml", &text);
        let words: Vec<&str> = words.trim().split(" | ").collect();
        refused_with(&place, &text, &words);
    }
    // A value that some cells use is left out in others.
    let kinds = "[set]\nevolution.strategy.sigma = 0.5\n[[list]]\nevolution.kind = \"genetic\"\n[[list]]\nevolution.kind = \"cma-es\"\n";
    place.write("sweep.toml", GOOD.replace("[grid]", &format!("{kinds}[grid]")));
    place.good(&["sweep", "plan", "sweep.toml", "--no-estimate"]);
    place.write(
        "sweep.toml",
        "experiment = \"swarm.toml\"\nseeds = [1]\n[reality]\nrobots = [1]\n",
    );
    refused_with(
        &place,
        "a swarm in reality",
        &["sweep.toml:3:1: reality: is given for the foraging study", "allowed: "],
    );
    let list = |count: u32| format!("{:?}", (1..=count).collect::<Vec<_>>());
    let keys = [
        "trials",
        "cycles",
        "noise.walk_step_mm",
        "noise.walk_range_mm",
        "task.new_cell",
        "evolution.mutation.amount",
    ];
    let grid: Vec<String> = keys.iter().map(|key| format!("{key} = {}", list(12))).collect();
    place.write(
        "sweep.toml",
        GOOD.replace("[grid]", &format!("[grid]\n{}", grid.join("\n"))),
    );
    let words = ["sweep.toml:2:9: seeds: make 17915904 runs", "allowed: up to 10000000"];
    refused_with(&place, "too many runs", &words);
    place.write("sweep.toml", GOOD.replace("[grid]", "\0"));
    refused_with(&place, "no letter", &["sweep.toml:3:"]);
    place.write("sweep.toml", [0xff, 0xfe, 0]);
    refused_with(&place, "no text", &["sweep.toml"]);
    fs::remove_file(place.at("sweep.toml")).unwrap();
    refused_with(&place, "nothing", &["sweep.toml: No such file"]);
}

/// Planning a sweep gives the same error as running it, and nothing is begun.
#[track_caller]
fn refused_with(place: &Place, text: &str, words: &[&str]) {
    for arguments in [
        &["sweep", "plan", "sweep.toml", "--no-estimate"][..],
        &sweep("out", &["--yes"]),
    ] {
        let ran = place.run(arguments);
        assert_eq!(ran.code, Some(3), "{text}\n{}{}", ran.stdout, ran.stderr);
        assert!(
            words.iter().all(|word| ran.stderr.contains(word)),
            "{text}\n{words:?}\n{}",
            ran.stderr
        );
        assert!(
            !ran.stderr.contains("panicked") && ran.stdout.is_empty(),
            "{text}\n{}",
            ran.stderr
        );
        assert!(!place.at("out").exists(), "{text}");
    }
}

#[test]
fn of_too_many_runs_can_be_overruled() {
    let many = GOOD.replace("1..3", "1..5001");
    let place = Place::with_sweep("many", &many);
    let words = ["sweep.toml:2:9: has 10002 runs; allowed: up to 10000 without --yes"];
    refused(&place, &sweep("out", &[]), 3, &words);
    refused(&place, &sweep("out", &["--shard", "1/5001"]), 3, &words);
    // One shard of them has two runs.
    place.good(&sweep("out", &["--shard", "1/5001", "--yes"]));
    place.good(&["sweep", "plan", "sweep.toml", "--no-estimate"]);
    place.write("sweep.toml", GOOD.replace("1..3", "1..5000"));
    place.good(&sweep("ten-thousand", &["--shard", "1/5000"]));
}

#[test]
fn of_command_lines_say_what_is_allowed() {
    let place = Place::with_sweep("typed", GOOD);
    for (option, value, words) in [
        ("--shard", "0/3", "allowed: I/N"),
        ("--shard", "4/3", "allowed: I/N"),
        ("--shard", "1", "allowed: I/N"),
        ("--shard", "1/100001", "allowed: I/N"),
        ("--time-budget", "5", "allowed: a time"),
        ("--time-budget", "0s", "allowed: a time"),
        ("--time-budget", "-1s", ""),
        ("--time-budget", "1e3s", "allowed: a time"),
        ("--time-budget", "1001h", "allowed: a time"),
        ("--time-budget", ".s", "allowed: a time"),
        ("--checkpoint-every", "", "allowed: a time"),
        ("--checkpoint-every", "1h30", "allowed: a time"),
        ("--jobs", "0", "1"),
        ("--jobs", "all", "all"),
        ("--threads", "0", "0"),
    ] {
        refused(&place, &sweep("out", &[option, value]), 2, &[words]);
    }
    place
        .run(&sweep("out", &["--backend", "abacus"]))
        .exits(4)
        .says(&["abacus"]);
}

/// A file cut at any length, or with any of its bytes changed, is a valid sweep or is refused with its name.
#[test]
fn of_any_bytes_are_words() {
    let place = Place::new("fuzz");
    let sweeps = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments/sweeps");
    let whole = fs::read(sweeps.join("small.toml")).unwrap();
    fs::create_dir(place.at("sweeps")).unwrap();
    place.write(
        "khepera-avoidance.toml",
        fs::read(sweeps.join("../khepera-avoidance.toml")).unwrap(),
    );
    // The contents of comments don't matter.
    let first = whole.windows(4).position(|here| here == b"name").unwrap();
    let cut = (first..=whole.len()).map(|length| whole[..length].to_vec());
    let changed = (first..whole.len())
        .zip(b"\"'[]{}=.,#\n\0\\9-e\xff".iter().cycle())
        .step_by(3)
        .map(|(at, &byte)| {
            let mut bytes = whole.clone();
            bytes[at] = byte;
            bytes
        });
    let (mut good, mut bad) = (0, 0);
    for bytes in cut.chain(changed) {
        place.write("sweeps/small.toml", &bytes);
        let ran = place.run(&["sweep", "plan", "sweeps/small.toml", "--no-estimate"]);
        let text = String::from_utf8_lossy(&bytes);
        match ran.code {
            Some(0) => good += 1,
            Some(3) => {
                assert!(ran.stderr.contains("small.toml"), "{text}\n{}", ran.stderr);
                bad += 1;
            }
            _ => panic!("{text}\n{:?}\n{}", ran.code, ran.stderr),
        }
    }
    assert!(good > 20 && bad > 100, "{good} sweeps, {bad} refused");
}
