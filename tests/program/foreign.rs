//! Directories and files from somebody else. A pipe, a device, a socket, a directory or a link may stand behind any name that the program
//! knows: each command ends at once with a message, and writes through no link. Names and texts may have anything: nothing acts on the
//! terminal, and no cell is a formula.

#![cfg(unix)]

use std::fs;
use std::os::unix::fs::symlink;
use std::os::unix::net::UnixListener;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::fixtures::{SMALL, copy, episode, experiments, fleet, foragers, said, study};
use crate::place::{Place, Ran};

/// A command that waits for a pipe, or reads without end, is not over then.
const AT_ONCE: Duration = Duration::from_mins(1);

fn is_long() -> bool {
    std::env::var_os("ONEIRO_LONG").is_some()
}

/// The names that `docs/files.md` has of a kind of directory, which a test compares with the program's, with a number for what it
/// leaves open; folders end with `/`.
fn names(title: &str) -> Vec<String> {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/files.md");
    let page = fs::read_to_string(page).unwrap();
    let (_, section) = page
        .split_once(&format!("\n## {title}\n"))
        .unwrap_or_else(|| panic!("{title}"));
    let section = section.split("\n## ").next().unwrap().split("\n### ").next().unwrap();
    let rows = section.lines().filter_map(|line| line.strip_prefix("| `"));
    let names: Vec<String> = rows
        .map(|row| {
            let name = row.split('`').next().unwrap();
            let words = [
                ("checkpoint-N", "checkpoint-6"),
                ("shard-I-of-N", "shard-1-of-1"),
                ("robot-N", "robot-0"),
                ("replay-K-WHAT", "replay-0-seed-5"),
                ("replay-WHAT", "replay-seed-5"),
                ("replay-K", "replay-0"),
                ("life-NUMBER", "life-1"),
                ("genome-HASH", "genome-0123456789abcdef"),
                ("log-N", "log-1"),
            ];
            words
                .iter()
                .fold(name.to_owned(), |name, (open, known)| name.replace(open, known))
        })
        .collect();
    assert!(names.len() > 2, "{title}: {names:?}");
    names
}

/// What somebody put behind a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Plant {
    /// A pipe, and behind the name of the unfinished file a link to the victim.
    Pipe,
    /// A link to the victim.
    Link,
    /// A second name of the victim.
    SecondName,
    /// A link to a pipe.
    LinkToPipe,
    /// A link to a device without end.
    Device,
    Directory,
    Socket,
}

const PLANTS: [Plant; 7] = [
    Plant::Pipe,
    Plant::Link,
    Plant::SecondName,
    Plant::LinkToPipe,
    Plant::Device,
    Plant::Directory,
    Plant::Socket,
];

fn pipe(path: &Path) {
    let made = Command::new("mkfifo").arg(path).status().unwrap();
    assert!(made.success());
}

fn remove(path: &Path) {
    match path.symlink_metadata() {
        Ok(known) if known.is_dir() => fs::remove_dir_all(path).unwrap(),
        Ok(_) => fs::remove_file(path).unwrap(),
        Err(_) => (),
    }
}

/// Files of a user, elsewhere.
struct Victim {
    file: PathBuf,
    folder: PathBuf,
}

const TREASURE: &str = "written in years\n";

impl Victim {
    fn new(place: &Place) -> Self {
        let root = fs::canonicalize(place.at(".")).unwrap();
        let own = Self {
            file: root.join("victim"),
            folder: root.join("victims"),
        };
        fs::create_dir(&own.folder).unwrap();
        own.restore();
        own
    }

    fn restore(&self) {
        fs::write(&self.file, TREASURE).unwrap();
    }

    #[track_caller]
    fn is_intact(&self, what: &str) {
        assert_eq!(fs::read_to_string(&self.file).unwrap(), TREASURE, "{what}");
        assert_eq!(
            fs::read_dir(&self.folder).unwrap().count(),
            0,
            "{what}: wrote behind a link"
        );
    }
}

impl Plant {
    /// Plants it, and says whether there is anything to try.
    fn at(self, path: &Path, is_folder: bool, victim: &Victim) -> bool {
        if path.parent().is_none_or(|parent| !parent.is_dir()) {
            return false;
        }
        remove(path);
        match self {
            Self::Pipe => {
                pipe(path);
                if !is_folder {
                    let mut unfinished = path.as_os_str().to_owned();
                    unfinished.push(".tmp");
                    symlink(&victim.file, unfinished).unwrap();
                }
            }
            Self::Link if is_folder => symlink(&victim.folder, path).unwrap(),
            Self::Link => symlink(&victim.file, path).unwrap(),
            Self::SecondName => fs::hard_link(&victim.file, path).unwrap(),
            Self::LinkToPipe => {
                let place = victim.file.with_file_name("pipe");
                if !place.exists() {
                    pipe(&place);
                }
                symlink(place, path).unwrap();
            }
            Self::Device => symlink("/dev/zero", path).unwrap(),
            Self::Directory if is_folder => return false,
            Self::Directory => fs::create_dir(path).unwrap(),
            Self::Socket => drop(UnixListener::bind(path).unwrap()),
        }
        true
    }
}

/// Runs a command that must end at once, and not by a panic.
#[track_caller]
fn ends(place: &Place, arguments: &[&str], what: &str) -> Ran {
    let mut command = place.command(arguments);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > AT_ONCE {
            child.kill().unwrap();
            panic!("oneiro {}: goes on and on with {what}", arguments.join(" "));
        }
        thread::sleep(Duration::from_millis(2));
    }
    let output = child.wait_with_output().unwrap();
    let code = output
        .status
        .code()
        .unwrap_or_else(|| panic!("oneiro {}: was killed with {what}", arguments.join(" ")));
    let ran = Ran::new(arguments, &output);
    assert!(
        code <= 6 || code == 75,
        "{code}: oneiro {} with {what}: {}",
        arguments.join(" "),
        ran.stderr
    );
    assert!(
        code == 0 || ran.stderr.contains("oneiro: "),
        "oneiro {} with {what}: says nothing",
        arguments.join(" ")
    );
    ran
}

/// Plants something behind each name of a kind of directory, and runs commands in a copy each. `DIR` in their words is the directory.
fn planted(place: &Place, title: &str, directory: &str, commands: &[&str]) {
    let victim = Victim::new(place);
    let copied = place.at("planted");
    let mut tried = 0;
    for (number, name) in names(title).iter().enumerate() {
        let is_folder = name.ends_with('/') || name == "lives" || name == "robots";
        for (index, command) in commands.iter().enumerate() {
            for (kind, plant) in PLANTS.iter().enumerate() {
                // In the short test one of them, every second time a pipe, and for the next name and the next command another.
                let turn = number + index;
                let chosen = if turn.is_multiple_of(2) {
                    0
                } else {
                    1 + turn / 2 % (PLANTS.len() - 1)
                };
                if !is_long() && kind != chosen {
                    continue;
                }
                remove(&copied);
                copy(&place.at(directory), &copied);
                let path = copied.join(name.trim_end_matches('/'));
                let what = format!("{plant:?} at {name}");
                if *plant == Plant::SecondName && is_folder || !plant.at(&path, is_folder, &victim) {
                    continue;
                }
                let words = command.replace("DIR", "planted");
                ends(place, &words.split_whitespace().collect::<Vec<_>>(), &what);
                victim.is_intact(&format!("oneiro {words} with {what}"));
                tried += 1;
            }
        }
    }
    println!("{title}: {tried} commands");
}

/// A place with a run of a small experiment.
fn with_run(name: &str) -> Place {
    let place = Place::new(name);
    place.write("small.toml", format!("robot.motors = \"motor.sam\"\n{SMALL}"));
    place.good(&["robot", "tables", "export", "--builtin", "motor", "motor.sam"]);
    place.good(&["run", "small.toml", "--seed", "1", "--backend", "cpu", "--out", "run"]);
    place
}

const RUN: &str = "A run of a single robot";

#[test]
fn pipes_and_links_in_runs() {
    let place = with_run("runs");
    planted(
        &place,
        RUN,
        "run",
        &[
            "verify DIR",
            "list DIR",
            "resume DIR --backend cpu",
            "replay DIR --backend cpu --seed 5",
            "replay DIR --backend cpu",
            "verify DIR --recompute --backend cpu",
            "evaluate --best --genomes DIR --trials 2 --individuals --backend cpu",
            "evaluate --genomes DIR --population --backend cpu",
            "evaluate --tournament --genomes DIR --backend cpu",
            "run small.toml --seed 1 --out DIR --backend cpu",
        ],
    );
}

#[test]
fn pipes_and_links_in_runs_that_go_on() {
    let place = with_run("goes-on");
    // As a kill leaves it.
    for name in ["DONE", "champion.json", "checkpoint-6", "checkpoint-5"] {
        remove(&place.at("run").join(name));
    }
    planted(
        &place,
        RUN,
        "run",
        &[
            "resume DIR --backend cpu",
            "verify DIR",
            "list DIR",
            "run small.toml --seed 1 --out DIR --backend cpu",
        ],
    );
    // And before it is a run.
    for name in fs::read_dir(place.at("run"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
    {
        if name != "lock" && name != "inputs" {
            remove(&place.at("run").join(name));
        }
    }
    fs::remove_dir(place.at("victims")).unwrap();
    planted(&place, RUN, "run", &["run small.toml --seed 1 --out DIR --backend cpu"]);
}

/// One run that can't be read keeps no other from being listed.
#[test]
fn a_list_goes_on_with_the_others() {
    let place = with_run("list");
    let victim = Victim::new(&place);
    for (number, plant) in PLANTS.iter().enumerate() {
        let root = place.at(format!("all-{number}"));
        fs::create_dir(&root).unwrap();
        for name in [
            "config.toml",
            "DONE",
            "meta.json",
            "generations.csv",
            "champion.json",
            "lock",
        ] {
            let own = root.join(format!("of-{name}"));
            copy(&place.at("run"), &own);
            assert!(plant.at(&own.join(name), false, &victim));
            victim.is_intact("planting");
        }
        copy(&place.at("run"), &root.join("good"));
        let root = root.file_name().unwrap().to_str().unwrap();
        let listed = ends(&place, &["list", root, "--json"], &format!("{plant:?}")).exits(0);
        let runs: Value = serde_json::from_str(&listed.stdout).unwrap();
        let state = |name: &str| {
            let run = runs
                .as_array()
                .unwrap()
                .iter()
                .find(|run| run["directory"] == format!("{root}/{name}"));
            run.unwrap_or_else(|| panic!("{name}: {runs}"))["state"]
                .as_str()
                .unwrap()
                .to_owned()
        };
        assert_eq!(state("good"), "done");
        for name in ["config.toml", "DONE"] {
            let state = state(&format!("of-{name}"));
            assert!(["unreadable", "changed"].contains(&&*state), "{plant:?}: {state}");
        }
        for name in ["generations.csv", "champion.json"] {
            assert_eq!(state(&format!("of-{name}")), "changed", "{plant:?}");
        }
        // Nothing depends on these.
        for name in ["meta.json", "lock"] {
            assert_eq!(state(&format!("of-{name}")), "done", "{plant:?}");
        }
    }
}

#[test]
fn pipes_and_links_in_swarms_and_studies() {
    let place = Place::new("swarms");
    place.write("swarm.toml", foragers(4, ""));
    place.good(&["run", "swarm.toml", "--seed", "1", "--backend", "cpu", "--out", "run"]);
    planted(
        &place,
        "A run of a swarm",
        "run",
        &[
            "verify DIR",
            "list DIR",
            "resume DIR --backend cpu",
            "replay DIR --backend cpu",
            "verify DIR --recompute --backend cpu",
        ],
    );
    fs::remove_dir(place.at("victims")).unwrap();
    place.write(
        "study.toml",
        study(
            "odowd2014",
            &[(
                "\n[set]\n",
                "\n[set]\nswarm.minutes = 4\nswarm.light_moves_minute = 2\n",
            )],
        ),
    );
    let reproduce = "reproduce odowd2014 --study study.toml --runs 2 --scale 0.2 --credit lagged --only-cases --backend cpu --out DIR";
    place.good(&reproduce.replace("DIR", "study").split_whitespace().collect::<Vec<_>>());
    planted(&place, "The 2014 study", "study", &[reproduce]);
}

#[test]
fn pipes_and_links_in_sweeps() {
    let place = with_run("sweeps");
    place.write(
        "sweep.toml",
        "experiment = \"small.toml\"\nseeds = \"1..2\"\n[grid]\nnoise.motor = [0.0, 0.1]\n",
    );
    place.good(&["sweep", "run", "sweep.toml", "--backend", "cpu", "--out", "swept"]);
    planted(
        &place,
        "A sweep of single robots",
        "swept",
        &[
            "verify DIR",
            "list DIR",
            "sweep status DIR",
            "sweep report DIR",
            "sweep merge DIR",
            "sweep merge DIR --out joined",
            "sweep extract DIR 0 --backend cpu",
            "sweep run sweep.toml --backend cpu --out DIR",
            "evaluate --best --genomes DIR --trials 2 --backend cpu --set noise.motor=0",
            "evaluate --genomes DIR --backend cpu --set noise.motor=0",
        ],
    );
}

#[test]
fn pipes_and_links_in_sweeps_that_go_on() {
    let place = with_run("sweeps-go-on");
    place.write(
        "sweep.toml",
        "experiment = \"small.toml\"\nseeds = \"1..2\"\n[grid]\nnoise.motor = [0.0, 0.1]\n",
    );
    place.good(&[
        "sweep",
        "run",
        "sweep.toml",
        "--backend",
        "cpu",
        "--out",
        "swept",
        "--shard",
        "1/1",
    ]);
    let log = place.text("swept/shard-1-of-1/results.log");
    let lines: Vec<&str> = log.split_inclusive('\n').collect();
    place.write("swept/shard-1-of-1/results.log", lines[..2].concat());
    for name in [
        "results.csv",
        "generations.csv",
        "champions.csv",
        "tables.json",
        "results.parquet",
        "generations.parquet",
        "champions.parquet",
    ] {
        remove(&place.at("swept").join(name));
    }
    planted(
        &place,
        "A sweep of single robots",
        "swept",
        &[
            "sweep run sweep.toml --backend cpu --out DIR",
            "sweep status DIR",
            "sweep report DIR",
        ],
    );
}

#[test]
fn pipes_and_links_in_lives_fleets_and_samples() {
    let place = Place::new("others");
    place.write("small.toml", SMALL);
    fs::create_dir(place.at("lives")).unwrap();
    for (name, text) in episode() {
        place.write(format!("lives/{name}"), text);
    }
    planted(
        &place,
        "Episodes on a robot",
        "lives",
        &["robot calibrate small.toml --log DIR --out calibrated --backend cpu"],
    );

    // A calibration that a kill has left.
    fs::remove_dir(place.at("victims")).unwrap();
    remove(&place.at("calibrated"));
    place.good(&[
        "robot",
        "calibrate",
        "small.toml",
        "--log",
        "lives",
        "--out",
        "calibrated",
        "--backend",
        "cpu",
    ]);
    place.write(
        "calibrated/unfinished",
        "oneiro robot calibrate small.toml --log lives --out planted --backend cpu\n",
    );
    planted(
        &place,
        "A calibration",
        "calibrated",
        &["robot calibrate small.toml --log lives --out DIR --backend cpu"],
    );

    fs::remove_dir(place.at("victims")).unwrap();
    fs::create_dir_all(place.at("host-0/oneiro/robot-0/state")).unwrap();
    place.write("host-0/oneiro/robot-0/state/log.jsonl", said(0, 1));
    place.good(&["fleet", "key", "fleet.key"]);
    fs::copy("/bin/sh", place.at("sh")).unwrap();
    place.write("fleet.experiment", foragers(1, ""));
    let hosts = fs::canonicalize(place.at(".")).unwrap();
    place.write("fleet.toml", fleet("fleet.experiment", 1, &hosts, "planted"));
    fs::create_dir(place.at("record")).unwrap();
    planted(
        &place,
        "A fleet",
        "record",
        &[
            "fleet collect fleet.toml",
            "fleet replay fleet.toml",
            "fleet compare fleet.toml --seeds 1..2",
        ],
    );

    // Directories of samples have no page.
    let victim = Victim {
        file: place.at("victim"),
        folder: place.at("victims"),
    };
    for name in [
        "rows/",
        "rows/robot.txt",
        "rows/wall-00.json",
        "wall.sam",
        "wall.svg",
        "motor.sam",
    ] {
        for plant in PLANTS {
            remove(&place.at("planted"));
            fs::create_dir_all(place.at("planted").join(if name == "rows/" { "" } else { "rows" })).unwrap();
            let is_folder = name.ends_with('/');
            if plant == Plant::SecondName && is_folder
                || !plant.at(
                    &place.at("planted").join(name.trim_end_matches('/')),
                    is_folder,
                    &victim,
                )
            {
                continue;
            }
            ends(
                &place,
                &[
                    "robot",
                    "sample",
                    "--objects",
                    "wall",
                    "--backend",
                    "cpu",
                    "--out",
                    "planted",
                ],
                &format!("{plant:?} at {name}"),
            );
            victim.is_intact(&format!("{plant:?} at {name}"));
        }
    }
}

/// Files that the command line or an experiment names.
#[test]
fn pipes_and_devices_as_input() {
    let place = with_run("input");
    let victim = Victim::new(&place);
    let commands = [
        "check X.toml",
        "run X.toml",
        "sweep plan X.toml",
        "evaluate small.toml --random 1 --starts X.csv",
        "evaluate small.toml --genomes X.npy",
        "evaluate small.toml --genomes X.csv",
        "evaluate small.toml --genomes X.json",
        "evaluate small.toml --best --genomes X.json",
        "replay run --genome X.json",
        "robot tables show X.sam",
        "robot tables convert X.sam new.sam",
        "device test --tables X.sam,X.sam --backend cpu",
        "check small.toml --set robot.motors=\"X.sam\"",
        "check small.toml --set robot.tables=[\"X.sam\",\"X.sam\"]",
        "check small.toml --set evolution.init=\"X.npy\"",
        "check small.toml --set controller.kind=\"own\" --set controller.part=\"X.wgsl\"",
        "robot drive serial:/dev/null --commands X.csv --dry-run",
        "fleet plan X.toml",
        "fleet twin X.toml --out twin",
        "on-board X.toml",
        "reproduce miglino1995 --study X.toml --out study",
        "reproduce miglino1995 --tables X.sam,X.sam --out study",
        "robot sample --robot X.toml --out sampled",
        "robot calibrate X.toml --log run --out calibrated",
    ];
    for plant in [
        Plant::Pipe,
        Plant::LinkToPipe,
        Plant::Device,
        Plant::Socket,
        Plant::Directory,
    ] {
        for command in commands {
            for name in ["X.toml", "X.csv", "X.npy", "X.json", "X.sam", "X.wgsl"] {
                remove(&place.at(name));
                remove(&place.at(format!("{name}.tmp")));
                plant.at(&place.at(name), false, &victim);
            }
            let ran = ends(
                &place,
                &command.split_whitespace().collect::<Vec<_>>(),
                &format!("{plant:?}"),
            );
            assert!(
                [Some(2), Some(3)].contains(&ran.code),
                "oneiro {command} with {plant:?}: {:?}: {}",
                ran.code,
                ran.stderr
            );
            victim.is_intact(command);
        }
    }
}

/// Files that the command line names for writing are new, and written whole.
#[test]
fn new_files_go_through_no_link() {
    let place = with_run("new");
    let victim = Victim::new(&place);
    for command in [
        "check small.toml --out new.svg",
        "evaluate --best --genomes run --trials 2 --out new.json",
        "evaluate small.toml --random 1 --out new.csv",
        "evaluate small.toml --random 1 --out new.npy",
        "robot tables export --builtin wall new.sam",
        "robot tables show wall --out new.svg",
        "fleet key new",
        "new new",
        "evaluate small.toml --random 1 --traces new",
        "run small.toml --seed 1 --out new",
        "sweep run small.toml --out new",
    ] {
        let words: Vec<&str> = command.split_whitespace().collect();
        let name = words
            .iter()
            .rfind(|word| word.starts_with("new") && **word != command)
            .unwrap();
        let name = if command == "new new" { "new.toml" } else { name };
        for (link, target) in [
            (name.to_owned(), &victim.file),
            (format!(".{name}.tmp"), &victim.file),
            (name.to_owned(), &victim.file.with_file_name("nothing")),
        ] {
            for old in [
                "new", "new.svg", "new.json", "new.csv", "new.npy", "new.sam", "new.toml",
            ] {
                remove(&place.at(old));
                remove(&place.at(format!(".{old}.tmp")));
            }
            symlink(target, place.at(&link)).unwrap();
            ends(&place, &words, &link);
            victim.is_intact(command);
            assert!(!place.at("nothing").exists(), "oneiro {command} wrote behind {link}");
        }
    }
}

/// What would act on a terminal.
const ACTS: &str = "\u{1b}[2J\u{9b}31m\u{7}\u{7f}\u{8}\r\u{202e}\u{2066}\u{200f}\u{2028}";

fn acts(text: &str) -> bool {
    let is_mark = |c: char| !c.is_ascii() && ACTS.contains(c);
    text.chars()
        .any(|c| (c.is_control() && !"\n\t".contains(c)) || is_mark(c))
}

#[test]
fn nothing_acts_on_the_terminal() {
    let place = with_run("terminal");
    let named = |end: &str| format!("a{ACTS}z{end}");
    let (toml, runs, npy) = (named(".toml"), named(""), named(".npy"));
    place.write(&toml, SMALL);
    fs::create_dir(place.at(&runs)).unwrap();
    copy(&place.at("run"), &place.at(&runs).join(&runs));
    fs::copy(place.at("run/champion.npy"), place.at(&npy)).unwrap();
    let escaped = "\"\\u001b[2J\\u009b31m\\u0007\\u202e\\u2028\"";
    place.write("key.toml", format!("{escaped} = 1\n"));
    place.write("value.toml", format!("robot.collision = {escaped}\n"));
    place.write("name.toml", format!("name = {escaped}\n{SMALL}"));
    place.write("comment.toml", format!("cycles = 0 # {ACTS}\n"));
    place.write("torn.toml", format!("cycles = [ # {ACTS}\n"));
    place.write("part.wgsl", format!("fn {ACTS}() {{}} // {ACTS}\n"));
    place.write(
        "sweep.toml",
        format!("experiment = \"small.toml\"\nseeds = \"1..2\"\n[grid]\n{escaped} = [1]\n"),
    );
    let set = format!("{}=1", named(""));
    for arguments in [
        &["check", &toml][..],
        &["check", "key.toml"],
        &["check", "value.toml"],
        &["check", "name.toml"],
        &["check", "comment.toml"],
        &["check", "torn.toml"],
        &["check", "small.toml", "--set", &set],
        &[
            "check",
            "small.toml",
            "--set",
            "controller.kind=\"own\"",
            "--set",
            "controller.part=\"part.wgsl\"",
        ],
        &["check", &named("")],
        &["sweep", "plan", "sweep.toml", "--no-estimate"],
        &["run", &toml, "--seed", "2", "--backend", "cpu", "--out", &named("-out")],
        &["run", "name.toml", "--seed", "2", "--backend", "cpu"],
        &["run", &toml, "--seed", &named("")],
        &["run", "small.toml", &named("")],
        &["run", "small.toml", &format!("--{}", named(""))],
        &[&*named("")],
        &["list", &runs],
        &["list", &runs, "--json"],
        &["verify", &runs],
        &["verify", &runs, "--json"],
        &["resume", &runs, "--backend", "cpu"],
        &["verify", "--recompute", &runs, "--backend", "cpu"],
        &["evaluate", "small.toml", "--genomes", &npy, &npy, "--backend", "cpu"],
        &[
            "evaluate",
            "small.toml",
            "--genomes",
            &npy,
            &npy,
            "--backend",
            "cpu",
            "--json",
        ],
        &["evaluate", "small.toml", "--genomes", &named(".csv")],
        &["evaluate", "small.toml", "--random", "1", "--backend", &named("")],
        &[
            "evaluate",
            "--best",
            "--genomes",
            &runs,
            &npy,
            "--trials",
            "2",
            "--backend",
            "cpu",
            "--all",
        ],
        &["replay", "run", "--genome", &npy, "--backend", "cpu"],
        &["new", &named("")],
        &["new", "--example", &named("")],
        &["new", "--keys", &named("")],
        &["fleet", "plan", &toml],
        &["robot", "ping", &named("")],
        &["robot", "sample", "--robot", &named(""), "--out", "sampled"],
        &["robot", "sample", "--objects", &named(""), "--out", "sampled"],
    ] {
        let output = place.command(arguments).output().unwrap();
        for (bytes, of) in [(&output.stdout, "data"), (&output.stderr, "messages")] {
            let text = String::from_utf8(bytes.clone()).unwrap();
            assert!(
                !acts(&text),
                "oneiro {arguments:?}: its {of} act on the terminal: {text:?}"
            );
        }
        assert!(output.status.code().is_some_and(|code| code != 101), "{arguments:?}");
    }
    // JSON says the same as before.
    let listed: Value = serde_json::from_str(&place.good(&["list", &runs, "--json"])).unwrap();
    assert_eq!(listed[0]["directory"], format!("{runs}/{runs}"));
    // A name is within its line.
    copy(&place.at("run"), &place.at(&runs).join("run-1\nrun-2  small  2  done"));
    assert_eq!(place.good(&["list", &runs]).lines().count(), 3);
}

/// Spreadsheets run cells that begin like formulas.
#[test]
fn no_cell_is_a_formula() {
    let place = with_run("formula");
    let part = fs::read_to_string(experiments().join("kheperax/network.wgsl")).unwrap();
    let names = ["=cmd|x!A0.wgsl", "+x.wgsl", "-x.wgsl", "@SUM(A1).wgsl"];
    for name in names {
        place.write(name, &part);
    }
    let shipped = fs::read_to_string(experiments().join("kheperax-elites.toml")).unwrap();
    let shipped = shipped.replace(
        "part = \"kheperax/",
        &format!("part = \"{}/kheperax/", experiments().display()),
    );
    place.write("elites.toml", shipped);
    let list: Vec<String> = names.iter().map(|name| format!("{name:?}")).collect();
    place.write(
        "sweep.toml",
        format!(
            "experiment = \"elites.toml\"\nseeds = \"1..2\"\n[grid]\ncontroller.part = [{}]\nnoise.motor = [-0.0, 0.1]\n\
             [set]\ncycles = 10\nevolution.generations = 2\nevolution.population = 4\n",
            list.join(", ")
        ),
    );
    place.good(&["sweep", "run", "sweep.toml", "--backend", "cpu", "--out", "swept"]);
    place.good(&["sweep", "report", "swept"]);
    for name in ["=1+1.npy", "=1+2.npy"] {
        fs::copy(place.at("run/champion.npy"), place.at(name)).unwrap();
    }
    place.write("small.toml", SMALL);
    place.good(&[
        "evaluate",
        "small.toml",
        "--genomes",
        "=1+1.npy",
        "=1+2.npy",
        "--backend",
        "cpu",
        "--out",
        "fitness.csv",
    ]);
    let mut texts = 0;
    for table in [
        "swept/results.csv",
        "swept/cells.csv",
        "swept/effects.csv",
        "fitness.csv",
    ] {
        let text = place.text(table);
        let mut rows = csv::ReaderBuilder::new()
            .has_headers(false)
            .from_reader(text.as_bytes());
        for cell in rows
            .records()
            .flat_map(|row| row.unwrap().iter().map(str::to_owned).collect::<Vec<_>>())
        {
            let begins = cell.starts_with(['=', '+', '-', '@', '\t', '\r']);
            assert!(!begins || cell.parse::<f64>().is_ok(), "{table}: {cell}");
            texts += u32::from(names.iter().any(|name| cell == format!("'{name}")) || cell.contains("'=1+"));
        }
    }
    assert!(texts > 16, "{texts}");
}

/// A hash that is printed was computed.
#[test]
fn hashes_are_those_of_what_is_there() {
    let place = with_run("hashes");
    place.write("sweep.toml", "experiment = \"small.toml\"\nseeds = \"1..2\"\n");
    let swept = place.good(&[
        "sweep",
        "run",
        "sweep.toml",
        "--backend",
        "cpu",
        "--out",
        "swept",
        "--json",
    ]);
    let swept: Value = serde_json::from_str(&swept).unwrap();
    let hash = swept["hash"].as_str().unwrap();
    assert!(place.good(&["verify", "swept"]).starts_with(&hash[..12]));
    let other: String = hash.chars().map(|c| if c == 'a' { 'b' } else { c }).collect();
    let sums = place.text("swept/tables.json");
    place.write("swept/tables.json", sums.replace(hash, &other));
    let verified = place
        .run(&["verify", "swept"])
        .exits(5)
        .says(&["swept: the hash in tables.json is another"]);
    assert!(verified.stdout.is_empty(), "{}", verified.stdout);
    let mut listed: Value = serde_json::from_str(&sums).unwrap();
    for (name, words) in [
        ("results.csv", "results.csv is not listed"),
        ("generations.csv", "generations.csv is not listed"),
    ] {
        let mut less = listed.clone();
        less["files"].as_object_mut().unwrap().remove(name);
        place.write("swept/tables.json", less.to_string());
        place.run(&["verify", "swept"]).exits(5).says(&[words]);
    }
    listed["files"]["../small.toml"] = "00".into();
    place.write("swept/tables.json", listed.to_string());
    place.run(&["verify", "swept"]).exits(5).says(&["../small.toml"]);

    // A run's: in its record, its configuration and its results.
    let done = place.text("run/DONE");
    let result = serde_json::from_str::<Value>(&done).unwrap()["result"]
        .as_str()
        .unwrap()
        .to_owned();
    let other: String = result.chars().map(|c| if c == 'a' { 'b' } else { c }).collect();
    for (name, from, to) in [
        ("DONE", &*result, &*other),
        ("config.toml", "cycles = 20", "cycles = 21"),
        ("config.toml", "\n", "\n# Edited.\n"),
        ("champion.json", "\"generation\"", "\"generation\" "),
    ] {
        let before = place.text(format!("run/{name}"));
        place.write(format!("run/{name}"), before.replacen(from, to, 1));
        for command in [
            &["verify", "run"][..],
            &["resume", "run", "--backend", "cpu"],
            &["run", "small.toml", "--seed", "1", "--backend", "cpu", "--out", "run"],
        ] {
            let ran = place
                .run(command)
                .exits(5)
                .says(&["this was changed since the run was finished"]);
            assert!(
                !ran.stdout.contains(&result) && !ran.stdout.contains(&other),
                "{}",
                ran.stdout
            );
        }
        let listed = place.good(&["list", "run"]);
        assert!(
            listed.contains(" changed ") && !listed.contains(&result[..12]),
            "{listed}"
        );
        place.write(format!("run/{name}"), before);
    }
    place.good(&["verify", "run"]);
}
