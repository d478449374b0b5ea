//! Whatever a kill leaves can be continued. Each command that writes is killed at its changes of files, and in `tests/long.sh` at each of
//! them and at hundreds of other times; then the same command goes on, to what it writes when nobody disturbs it.

#![cfg(all(target_os = "linux", target_env = "gnu"))]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::faults::{Fault, Faults};
use crate::fixtures::{SMALL, copy, episode, experiments, fleet, foragers, said, study};
use crate::place::{Place, Ran};
use serde_json::Value;

/// A command that writes.
struct Case {
    /// Its words, as `--help` lists it.
    command: &'static str,
    /// Its other words, in the directory of [`Bench::work`]; WORK is that directory's path.
    more: &'static str,
    /// Files that are different each time: they must only be there.
    drawn: &'static [&'static str],
    /// Whether its file or directory stays once it is complete, so that the same command refuses to write it again: it may be killed
    /// when all is written, before it ends.
    stays: bool,
    /// Whether it starts other processes, which are killed a moment later than it.
    has_children: bool,
    /// How many kills it gets before it may go on to its end, without those at its changes of files.
    kills: u32,
    /// Only in `tests/long.sh`.
    is_slow: bool,
}

impl Case {
    const fn new(command: &'static str, more: &'static str) -> Self {
        Self {
            command,
            more,
            drawn: &[],
            stays: false,
            has_children: false,
            kills: 5,
            is_slow: false,
        }
    }
}

const CASES: [Case; 37] = [
    Case::new("run", "small.toml --seed 1 --out WORK/out"),
    Case::new("run", "inputs.toml --seeds 1..3 --out WORK/out"),
    Case::new("run", "foragers.toml --seed 1 --out WORK/out"),
    Case::new("adopt", "small.toml --genomes done --seed 2 --out WORK/out"),
    Case::new("resume", "WORK/stopped"),
    Case::new("resume", "WORK/done --generations 9"),
    Case::new("sweep run", "sweep.toml --out WORK/out --checkpoint-every 0.001s"),
    Case::new("sweep merge", "swept --out WORK/out"),
    Case::new("sweep report", "WORK/swept"),
    Case::new("sweep extract", "swept 4 --out WORK/out"),
    Case::new("compare", "swept --out WORK/out"),
    Case {
        stays: true,
        ..Case::new("evaluate", "small.toml --random 3 --traces WORK/out")
    },
    Case {
        stays: true,
        ..Case::new("evaluate", "small.toml --random 3 --out WORK/out.csv")
    },
    Case::new("replay", "WORK/done"),
    Case::new("replay", "WORK/archive --elites"),
    Case::new("replay", "foraged --out WORK/out"),
    Case {
        stays: true,
        ..Case::new("evaluate", "--best --genomes done --trials 3 --out WORK/out.json")
    },
    Case::new("evaluate", "--tournament --genomes WORK/duel --trials 1"),
    Case {
        kills: 20,
        ..Case::new("reproduce miglino1995", "--study miglino.toml --runs 2 --out WORK/out")
    },
    Case {
        kills: 20,
        ..Case::new(
            "reproduce odowd2014",
            "--study odowd.toml --runs 2 --only-cases --out WORK/out",
        )
    },
    Case {
        stays: true,
        ..Case::new("export", "done --to c --out WORK/out.c")
    },
    Case::new("robot sample", "--objects wall --out WORK/out"),
    Case::new("robot sample", "--robot described.toml --out WORK/out"),
    Case {
        stays: true,
        ..Case::new("robot calibrate", "small.toml --log lives --out WORK/out")
    },
    Case::new("robot tables convert", "wall.sam WORK/out.sample"),
    Case::new("robot tables export", "--builtin motor WORK/out.sam"),
    Case::new("robot tables show", "wall --out WORK/out.svg"),
    Case::new("new", "other --sensor sensors --task task"),
    Case::new("new", "--example gather"),
    Case::new("import", "maze.txt --out WORK/out.toml"),
    Case::new("check", "small.toml --out WORK/out.svg"),
    Case::new("man", "WORK/out"),
    Case {
        drawn: &["out.json"],
        stays: true,
        is_slow: true,
        ..Case::new(
            "device bench",
            "small.toml --quick --rollouts 256 --share WORK/out.json",
        )
    },
    Case {
        drawn: &["key"],
        stays: true,
        ..Case::new("fleet key", "WORK/key")
    },
    Case {
        has_children: true,
        ..Case::new("fleet collect", "fleet.toml")
    },
    Case::new("fleet replay", "fleet.toml"),
    Case {
        has_children: true,
        stays: true,
        kills: 20,
        is_slow: true,
        ..Case::new("fleet twin", "fleet.toml --out WORK/out")
    },
];

/// Commands that write nothing.
const READERS: [&str; 16] = [
    "completions",
    "device list",
    "device test",
    "fleet compare",
    "fleet plan",
    "fleet status",
    "fleet stop",
    "list",
    "robot light",
    "robot list",
    "robot ping",
    "robot stop",
    "robot watch",
    "sweep plan",
    "sweep status",
    "verify",
];

/// Commands that are killed by other tests, or of which nothing is to be continued.
const ELSEWHERE: [(&str, &str); 4] = [
    (
        "watch",
        "it reads; its snapshot is one file, which is renamed when it is whole",
    ),
    (
        "fleet deploy",
        "each file is written by the robot's computer, whole or not at all: host/fleet/src/fleet/tests.rs",
    ),
    (
        "fleet start",
        "needs robots in real time: tests/program/real_time/fleets.rs",
    ),
    (
        "robot drive",
        "needs a robot in real time: tests/program/real_time/guard.rs",
    ),
];

/// Options that name what is written, except for recordings of links, which are kept and not overwritten.
const WRITING: [&str; 5] = [
    "--out <",
    "--traces <",
    "--share <FILE",
    "--log <DIR",
    "--snapshot <FILE",
];

#[test]
fn each_command_is_killed_or_writes_nothing() {
    fn leaves(place: &Place, words: &str, all: &mut BTreeMap<String, String>) {
        let arguments: Vec<&str> = words.split_whitespace().chain(["--help"]).collect();
        let help = place.good(&arguments);
        let below = help
            .lines()
            .take_while(|line| *line != "Options:")
            .filter(|line| line.starts_with("  ") && line[2..].starts_with(|c: char| c.is_ascii_lowercase()));
        let below: Vec<&str> = below.filter_map(|line| line.split_whitespace().next()).collect();
        for name in below.iter().filter(|name| **name != "help") {
            leaves(place, format!("{words} {name}").trim(), all);
        }
        if below.is_empty() {
            all.insert(words.to_owned(), help);
        }
    }
    let mut all = BTreeMap::new();
    leaves(&Place::new("commands"), "", &mut all);
    for (command, help) in &all {
        let is_killed = CASES.iter().any(|case| case.command == command);
        let is_reader = READERS.contains(&&**command);
        let is_elsewhere = ELSEWHERE.iter().any(|(name, _)| name == command);
        assert_eq!(
            [is_killed, is_reader, is_elsewhere]
                .into_iter()
                .filter(|is| *is)
                .count(),
            1,
            "oneiro {command}: is in no list of this test, or in two"
        );
        let writes = WRITING.iter().any(|option| help.contains(&format!(" {option}")));
        assert!(
            !(writes && is_reader),
            "oneiro {command}: has an option for what it writes"
        );
    }
    let is_command = |name: &str| all.contains_key(name);
    assert!(CASES.iter().all(|case| is_command(case.command)));
    assert!(READERS.iter().all(|name| is_command(name)));
    assert!(ELSEWHERE.iter().all(|(name, _)| is_command(name)));
}

fn is_long() -> bool {
    std::env::var_os("ONEIRO_LONG").is_some()
}

/// A daemon's log without its host's time.
fn without_times(log: &[u8]) -> Vec<u8> {
    let line = |line: &str| {
        let mut entry: serde_json::Map<String, Value> = serde_json::from_str(line).unwrap();
        entry.retain(|key, _| !["utc", "taken_s", "worked_s"].contains(&key.as_str()));
        serde_json::to_string(&entry).unwrap() + "\n"
    };
    std::str::from_utf8(log)
        .unwrap()
        .lines()
        .map(line)
        .collect::<String>()
        .into_bytes()
}

/// Where commands are killed.
struct Bench {
    place: Place,
    /// The folder before each command.
    before: PathBuf,
    /// Where it works, from a copy of that.
    work: PathBuf,
}

type Files = BTreeMap<PathBuf, Vec<u8>>;

impl Bench {
    fn new(name: &str) -> Self {
        let place = Place::new(name);
        let root = fs::canonicalize(place.at(".")).unwrap();
        let [before, work] = ["before", "work"].map(|name| root.join(name));
        fs::create_dir(&before).unwrap();
        Self { place, before, work }
    }

    fn command(&self, words: &[String]) -> Command {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let mut command = self.place.command(&words);
        command
            .current_dir(&self.work)
            .env("XDG_CACHE_HOME", self.place.at("cache"));
        command
    }

    /// A case's command.
    fn words(&self, case: &Case) -> Vec<String> {
        let work = self.work.display().to_string();
        let all = case
            .command
            .split(' ')
            .chain(case.more.split(' ').filter(|word| !word.is_empty()));
        let evaluates = [
            "run",
            "adopt",
            "resume",
            "sweep",
            "evaluate",
            "replay",
            "reproduce",
            "robot",
        ];
        let first = case.command.split(' ').next().unwrap();
        let is_cpu = evaluates.contains(&first)
            && !["sweep merge", "sweep report"].contains(&case.command)
            && !case.command.starts_with("robot tables");
        let backend: &[&str] = if is_cpu {
            &["--backend", "cpu", "--threads", "1"]
        } else {
            &[]
        };
        all.chain(backend.iter().copied())
            .map(|word| word.replace("WORK", &work))
            .collect()
    }

    /// Begins anew.
    fn fresh(&self) {
        if self.work.exists() {
            fs::remove_dir_all(&self.work).unwrap();
        }
        copy(&self.before, &self.work);
    }

    /// The files now, without what tells when they were written.
    fn files(&self, case: &Case) -> Files {
        let mut files = Files::new();
        collect(&self.work, &self.work, &mut files);
        for (path, bytes) in &mut files {
            // What says who computed it, and when.
            let is_provenance = ["meta.json", "sessions.json", "stderr"]
                .iter()
                .any(|name| path.ends_with(name));
            if is_provenance || case.drawn.iter().any(|name| path == Path::new(name)) {
                assert!(
                    !bytes.is_empty() || !case.drawn.contains(&path.to_str().unwrap()),
                    "{}",
                    path.display()
                );
                bytes.clear();
            }
            if path.ends_with("log.jsonl") && case.command == "fleet twin" {
                *bytes = without_times(bytes);
            }
        }
        files.retain(|path, _| {
            let name = path.file_name().unwrap().to_str().unwrap();
            // A sweep's checkpoints are numbered by the processes that worked on it.
            let is_of_shard = name.starts_with("checkpoint-") && path.to_str().unwrap().contains("shard-");
            !is_of_shard && !["lock", "sessions.json", "sessions.json.tmp"].contains(&name)
        });
        files
    }

    /// Lets the command go on to its end.
    fn ends(&self, case: &Case, words: &[String], expected: &Files, when: &str) {
        let output = self.command(words).output().unwrap();
        self.has_ended(case, words, &output, expected, when);
        let own = match case.command {
            "resume" => words[1].rsplit('/').next().unwrap(),
            _ => "out",
        };
        if self.work.join(own).join("config.toml").exists() {
            self.states(own, true);
        }
    }

    fn has_ended(&self, case: &Case, words: &[String], output: &Output, expected: &Files, when: &str) {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        let ran = Ran::new(&words, output);
        let is_refused = case.stays && ran.code == Some(3) && ran.stderr.contains("nothing is overwritten");
        if !is_refused {
            ran.exits(0);
        }
        let files = self.files(case);
        let more = |files: &Files, than: &Files| {
            files
                .keys()
                .filter(|name| !than.contains_key(*name))
                .cloned()
                .collect::<Vec<_>>()
        };
        let (new, lost) = (more(&files, expected), more(expected, &files));
        assert!(
            new.is_empty() && lost.is_empty(),
            "oneiro {}, {when}: {new:?} are new, {lost:?} are missing",
            words.join(" ")
        );
        for (path, bytes) in &files {
            assert!(
                *bytes == expected[path],
                "oneiro {}, {when}: {}",
                words.join(" "),
                path.display()
            );
        }
    }

    /// Asserts that `list` and `verify` tell the truth about runs.
    fn states(&self, name: &str, is_done: bool) {
        let path = self.work.join(name);
        let ask = |words: &[&str]| {
            let output = self
                .command(&words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>())
                .output()
                .unwrap();
            Ran::new(words, &output)
        };
        let listed = ask(&["list", path.to_str().unwrap(), "--json"]);
        if listed.code == Some(3) {
            // A kill before there is a run.
            assert!(!is_done && !path.join("config.toml").exists(), "{}", listed.stderr);
            return;
        }
        let runs: Value = serde_json::from_str(&listed.exits(0).stdout).unwrap();
        for run in runs.as_array().unwrap() {
            let directory = Path::new(run["directory"].as_str().unwrap());
            let has_ended = directory.join("DONE").exists();
            let state = run["state"].as_str().unwrap();
            let is_true = if has_ended {
                state == "done"
            } else {
                ["interrupted", "stopped"].contains(&state)
            };
            assert!(is_true && (has_ended || !is_done), "{run}");
            ask(&["verify", directory.to_str().unwrap()]).exits(i32::from(!has_ended));
        }
    }

    /// Kills a command at its changes of files and at other times, and returns how often.
    fn kill(&self, case: &Case) -> u32 {
        let words = self.words(case);
        let what = words.join(" ");
        self.fresh();
        let begun = Instant::now();
        let faults = Faults::below(&self.place, &self.work);
        let (output, calls) = if case.has_children {
            (self.command(&words).output().unwrap(), 0)
        } else {
            faults.counted(self.command(&words))
        };
        let whole = begun.elapsed();
        let arguments: Vec<&str> = words.iter().map(String::as_str).collect();
        Ran::new(&arguments, &output).exits(0);
        let expected = self.files(case);
        assert!(
            case.has_children || calls > 0,
            "oneiro {what} changes no file below {}",
            self.work.display()
        );
        let mut kills = 0;
        // In one piece each, or in the short test one after the other.
        let at: Vec<u32> = if is_long() {
            (1..=calls.min(250)).collect()
        } else {
            vec![1, calls.div_ceil(2)]
        };
        self.fresh();
        for (number, &call) in at.iter().enumerate().filter(|_| calls > 0) {
            let output = faults.at(self.command(&words), call, Fault::Kill).output().unwrap();
            if output.status.code().is_some() {
                self.has_ended(case, &words, &output, &expected, "with fewer calls");
            } else {
                kills += 1;
            }
            if self.work.join("out/config.toml").exists() && number % 8 == 0 {
                self.states("out", false);
            }
            if is_long() {
                self.ends(
                    case,
                    &words,
                    &expected,
                    &format!("after a kill at call {call} of {calls}"),
                );
                self.fresh();
            }
        }
        if !is_long() {
            self.ends(case, &words, &expected, "after two kills");
            return kills;
        }
        // Half of them in the first 100 ms, in which most is begun.
        for (times, span) in [(LONG, whole.min(Duration::from_millis(100))), (LONG, whole)] {
            kills += self.kill_at_times(case, &words, &expected, times, span);
        }
        println!("{kills:5} kills in {:6.1?}: oneiro {what}", begun.elapsed());
        kills
    }

    /// Kills a command so many times, at moments of a time from its start.
    fn kill_at_times(&self, case: &Case, words: &[String], expected: &Files, times: u32, mut span: Duration) -> u32 {
        let mut kills = 0;
        let mut since = 0;
        // Multiples of the golden section cover all moments evenly.
        let mut moments = std::iter::successors(Some(0.0), |moment| Some((moment + 0.618_034_f64) % 1.0));
        self.fresh();
        while kills < times {
            let mut command = self.command(words);
            let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
            thread::sleep(span.mul_f64(moments.next().unwrap()));
            let has_ended = child.try_wait().unwrap().is_some();
            child.kill().unwrap();
            let output = child.wait_with_output().unwrap();
            if case.has_children {
                thread::sleep(Duration::from_millis(100));
            }
            if has_ended || output.status.code().is_some() {
                self.has_ended(case, words, &output, expected, "by itself");
                self.fresh();
                since = 0;
                // It may take less time than when that was measured.
                span = span.mul_f64(0.97);
            } else {
                kills += 1;
                since += 1;
            }
            if since == case.kills {
                self.ends(case, words, expected, &format!("after {since} kills"));
                self.fresh();
                since = 0;
            }
        }
        self.ends(case, words, expected, "in the end");
        kills
    }
}

/// Kills at other times than at changes of files, of each half.
const LONG: u32 = 60;

fn collect(root: &Path, at: &Path, files: &mut Files) {
    for entry in fs::read_dir(at).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(root, &path, files);
        } else {
            files.insert(path.strip_prefix(root).unwrap().to_owned(), fs::read(&path).unwrap());
        }
    }
}

impl Bench {
    /// Writes a file of what is there before.
    fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        let path = self.before.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    /// Runs a command there.
    fn good(&self, words: &str) {
        let words: Vec<&str> = words.split_whitespace().collect();
        let mut command = self.place.command(&words);
        command
            .current_dir(&self.before)
            .env("XDG_CACHE_HOME", self.place.at("cache"));
        Ran::new(&words, &command.output().unwrap()).exits(0);
    }

    /// What all commands start from.
    fn prepare(&self) {
        self.write("small.toml", SMALL);
        self.write(
            "maze.txt",
            "4\n20 20\n0\n80 80\n0 0 100 0\n100 0 100 100\n100 100 0 100\n0 100 0 0\n",
        );
        self.write("inputs.toml", format!("robot.motors = \"motor.sam\"\n{SMALL}"));
        self.write(
            "sweep.toml",
            "experiment = \"small.toml\"\nseeds = \"1..3\"\n[grid]\nnoise.motor = [0.0, 0.1]\n",
        );
        self.good("robot tables export --builtin motor motor.sam");
        self.good("robot tables export --builtin wall wall.sam");
        self.write("foragers.toml", foragers(4, ""));
    }

    fn prepare_runs(&self) {
        self.good("run small.toml --seed 1 --backend cpu --out done");
        copy(&self.before.join("done"), &self.before.join("stopped"));
        // As a kill leaves it before its end.
        for name in ["DONE", "champion.json", "champion.npy", "checkpoint-6", "checkpoint-5"] {
            let _ = fs::remove_file(self.before.join("stopped").join(name));
        }
        self.good("sweep run sweep.toml --backend cpu --out swept");
        self.good("run foragers.toml --seed 1 --backend cpu --out foraged");
        let experiments = experiments();
        let shipped = experiments.display();
        self.good(&format!(
            "run {shipped}/predator-prey.toml --seed 3 --backend cpu --out duel --set cycles=20 --set evolution.generations=3 \
             --set evolution.population=6 --set evolution.parents=3 --set evolution.opponents.generations=2 \
             --set evolution.opponents.contests=2 --set evolution.finalist_lives=2"
        ));
        self.good(&format!(
            "run {shipped}/kheperax-elites.toml --seed 3 --backend cpu --out archive --set cycles=20 --set evolution.generations=3 \
             --set evolution.population=8"
        ));
    }

    fn prepare_others(&self) {
        let miglino = [
            (
                "\n[set]\n",
                "\n[set]\nevolution.generations = 2\nevolution.population = 10\nevolution.parents = 2\ncycles = 50\n",
            ),
            ("\ngenerations = 20\n", "\ngenerations = 1\n"),
        ];
        self.write("miglino.toml", study("miglino1995", &miglino));
        let odowd = [
            (
                "\n[set]\n",
                "\n[set]\nswarm.minutes = 4\nswarm.light_moves_minute = 2\n",
            ),
            ("scales = [2.0, 0.2, 0.02]", "scales = [0.2]"),
            ("credits = [\"lagged\", \"matched\"]", "credits = [\"lagged\"]"),
        ];
        self.write("odowd.toml", study("odowd2014", &odowd));
        self.good("new described --robot khepera");
        self.good("new own --task task");
        for (name, text) in episode() {
            self.write(&format!("lives/{name}"), text);
        }
        // A fleet of two, what its robots' computers have, and what its robots said.
        let short = foragers(1, "clock.interval_s = 20\nclock.installed_s = 10\n");
        self.write("fleet.experiment", short.replace("robots = 10", "robots = 2"));
        self.write("fleet.toml", fleet("fleet.experiment", 2, &self.work, "record"));
        self.write("sh", fs::read("/bin/sh").unwrap());
        self.good("fleet key fleet.key");
        for robot in 0..2 {
            let state = format!("host-{robot}/oneiro/robot-{robot}/state");
            let log: String = (0..400).map(|second| said(robot, second)).collect();
            self.write(&format!("{state}/log.jsonl"), log);
            self.write(&format!("{state}/best.npy"), vec![7; 5000]);
        }
        let row = |second: u32| {
            let x = 300 + second;
            format!("{second},0,living,0.1,0,0.5,0.5,0.5,0,,0,0,{x},400,0.25,,\n{second},1,away,,,,,,,,,,,,,,\n")
        };
        let head =
            "second,robot,state,age_s,interval,s0,g0,g1,real,simulated,brought,carries,x,y,heading,volts,problems\n";
        let rows: String = (0..20).map(row).collect();
        self.write("record/statuses.csv", head.to_owned() + &rows);
    }

    /// Kills all cases of some commands.
    fn kill_all(&self, is_own: impl Fn(&str) -> bool) {
        let only = std::env::var("ONEIRO_COMMAND").ok();
        let own = CASES
            .iter()
            .filter(|case| is_own(case.command) && (is_long() || !case.is_slow))
            .filter(|case| only.as_ref().is_none_or(|only| case.command == only));
        let kills: u32 = own.map(|case| self.kill(case)).sum();
        println!("{kills} kills");
    }
}

/// The first word of commands that are tested together.
const RUNS: [&str; 9] = [
    "run", "adopt", "resume", "sweep", "compare", "evaluate", "replay", "export", "check",
];

fn is_of_runs(command: &str) -> bool {
    RUNS.contains(&command.split(' ').next().unwrap())
}

#[test]
fn runs_and_sweeps_go_on_after_kills() {
    let bench = Bench::new("runs");
    bench.prepare();
    bench.prepare_runs();
    bench.kill_all(is_of_runs);
}

#[test]
fn studies_samples_and_fleets_go_on_after_kills() {
    let bench = Bench::new("others");
    bench.prepare();
    bench.prepare_others();
    bench.kill_all(|command| !is_of_runs(command));
}

/// Unfinished files alone are no reason to refuse a directory; anything else is.
#[test]
fn what_a_kill_leaves_is_no_others() {
    let bench = Bench::new("left");
    bench.prepare();
    bench.prepare_others();
    for (words, unfinished) in [
        (
            "reproduce odowd2014 --study odowd.toml --runs 2 --only-cases --backend cpu --out out",
            "study.json.tmp",
        ),
        ("run small.toml --seed 1 --backend cpu --out out", "config.toml.tmp"),
        ("sweep run sweep.toml --backend cpu --out out", "sweep.json.tmp"),
    ] {
        let words: Vec<String> = words.split(' ').map(str::to_owned).collect();
        let ran = || {
            let arguments: Vec<&str> = words.iter().map(String::as_str).collect();
            Ran::new(&arguments, &bench.command(&words).output().unwrap())
        };
        for (name, code) in [(unfinished, 0), ("notes.tmp", 3), ("README.md", 3), (".hidden", 3)] {
            bench.fresh();
            fs::create_dir(bench.work.join("out")).unwrap();
            fs::write(bench.work.join("out").join(name), "").unwrap();
            let ran = ran().exits(code);
            if code == 3 {
                ran.says(&[
                    "out: exists and holds other files, and nothing is overwritten",
                    name,
                    "--out",
                ]);
                assert_eq!(fs::read_dir(bench.work.join("out")).unwrap().count(), 1);
            }
        }
    }
    // A directory that one command fills is no other command's, and one that fails before leaves nothing.
    bench.fresh();
    let evaluate = |count: &str| {
        let words = [
            "evaluate",
            "small.toml",
            "--random",
            count,
            "--backend",
            "cpu",
            "--traces",
            "out",
        ];
        let words: Vec<String> = words.into_iter().map(str::to_owned).collect();
        let arguments: Vec<&str> = words.iter().map(String::as_str).collect();
        Ran::new(&arguments, &bench.command(&words).output().unwrap())
    };
    fs::create_dir(bench.work.join("out")).unwrap();
    fs::write(
        bench.work.join("out/unfinished"),
        "oneiro evaluate small.toml --random 2 --backend cpu --traces out\n",
    )
    .unwrap();
    fs::write(bench.work.join("out/trace-0-0.csv"), "torn").unwrap();
    evaluate("1")
        .exits(3)
        .says(&["--traces out: is unfinished", "`oneiro evaluate small.toml --random 2 "]);
    evaluate("2").exits(0);
    assert!(!bench.work.join("out/unfinished").exists());
    evaluate("2").exits(3).says(&["--traces out: exists and is not empty"]);
    let words = [
        "robot",
        "calibrate",
        "wall.sam",
        "--log",
        "lives",
        "--out",
        "calibrated",
    ]
    .map(str::to_owned);
    assert_eq!(bench.command(&words).output().unwrap().status.code(), Some(3));
    assert!(!bench.work.join("calibrated").exists());
}
