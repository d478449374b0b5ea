//! How the program ends where it can't go on, or is stopped: always with an exit code and a sentence, soon, and nothing that was
//! recorded is lost.
#![cfg(unix)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Output};
use std::thread;
use std::time::{Duration, Instant};

use crate::peers::EPuck2;
use crate::place::{Place, Ran, wait_for};

const EXPERIMENT: &str = "\
cycles = 60
[evolution]
generations = 6
finalists = 2
finalist_lives = 3
[record]
checkpoint_every = 2
";
const SWEEP: &str = "experiment = \"small.toml\"\nseeds = \"1..3\"\n";

/// Commands under limits: a name, which begins with that of the command, and the arguments, in which `OUT` is a new path.
const COMMANDS: [(&str, &[&str]); 47] = [
    ("new", &["new", "OUT.toml"]),
    ("import", &["import", "maze.txt", "--out", "OUT.toml"]),
    (
        "import a map",
        &["import", "map.pgm", "--mm-per-pixel", "20", "--out", "OUT.toml"],
    ),
    ("check", &["check", "small.toml"]),
    ("check a picture", &["check", "line-follower.toml"]),
    ("check parts", &["check", "parts.toml"]),
    ("new keys", &["new", "--keys"]),
    ("run", &["run", "small.toml", "--seed", "1", "--out", "OUT"]),
    (
        "run on a GPU",
        &[
            "run",
            "small.toml",
            "--seed",
            "1",
            "--out",
            "OUT",
            "--backend",
            "gpu:llvmpipe",
        ],
    ),
    ("run parts", &["run", "parts.toml", "--seed", "1", "--out", "OUT"]),
    ("run a swarm", &["run", "swarm.toml", "--seed", "1", "--out", "OUT"]),
    (
        "adopt",
        &["adopt", "small.toml", "--genomes", "run", "--seed", "1", "--out", "OUT"],
    ),
    ("resume", &["resume", "run"]),
    (
        "evaluate",
        &["evaluate", "--genomes", "run", "--measures", "--trials", "50"],
    ),
    ("evaluate the best", &["evaluate", "--best", "--genomes", "run"]),
    ("watch", &["watch", "run", "--snapshot", "OUT.html"]),
    ("replay", &["replay", "run"]),
    ("export", &["export", "run", "--to", "c", "--out", "OUT.c"]),
    (
        "replay as a film",
        &["replay", "run", "--film", "OUT.gif", "--picture", "OUT.png"],
    ),
    (
        "evaluate a tournament",
        &["evaluate", "--tournament", "--genomes", "pair"],
    ),
    ("verify again", &["verify", "run", "--recompute", "--fraction", "1"]),
    ("verify", &["verify", "run"]),
    ("list", &["list", "."]),
    (
        "compare",
        &["compare", "run", "random", "--trials", "2", "--out", "OUT"],
    ),
    ("device list", &["device", "list"]),
    ("device list explained", &["device", "list", "--explain"]),
    (
        "device test",
        &["device", "test", "--backend", "cpu", "--rollouts", "1000"],
    ),
    ("device bench", &["device", "bench", "--quick", "--backend", "cpu"]),
    ("robot tables", &["robot", "tables", "show", "wall"]),
    (
        "robot sample",
        &["robot", "sample", "--robot", "surrogate:1", "--out", "OUT"],
    ),
    (
        "robot calibrate",
        &["robot", "calibrate", "small.toml", "--log", "run", "--out", "OUT"],
    ),
    ("robot", &["robot", "list"]),
    ("robot ping", &["robot", "ping", "tcp:127.0.0.1:9"]),
    ("on-board", &["on-board", "OUT-robot.toml"]),
    ("fleet plan", &["fleet", "plan", "fleet.toml"]),
    ("fleet twin", &["fleet", "twin", "fleet.toml", "--out", "OUT"]),
    (
        "reproduce",
        &[
            "reproduce",
            "odowd2014",
            "--runs",
            "2",
            "--scale",
            "0.01",
            "--out",
            "OUT",
        ],
    ),
    (
        "reproduce 1995",
        &["reproduce", "miglino1995", "--runs", "2", "--out", "OUT"],
    ),
    ("sweep plan", &["sweep", "plan", "sweep.toml"]),
    ("sweep run", &["sweep", "run", "sweep.toml", "--out", "OUT"]),
    ("sweep status", &["sweep", "status", "sweep"]),
    ("sweep merge", &["sweep", "merge", "sweep"]),
    ("sweep report", &["sweep", "report", "sweep"]),
    ("sweep extract", &["sweep", "extract", "sweep", "0", "--out", "OUT"]),
    ("completions", &["completions", "bash"]),
    ("man", &["man", "OUT"]),
    ("help", &["help"]),
];
/// Commands that take many seconds where there is enough memory.
const SLOW: [&str; 6] = [
    "on-board",
    "device test",
    "device bench",
    "fleet twin",
    "reproduce",
    "reproduce 1995",
];
/// What the list of commands leaves out: robots' computers run it.
const HIDDEN: [&str; 1] = ["on-board"];

impl Place {
    /// Everything that the commands need.
    fn prepared(name: &str) -> Self {
        let place = Self::new(name);
        let experiments = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments");
        let shipped = |file: &str| experiments.join(file).display().to_string();
        place.write("small.toml", EXPERIMENT);
        place.write("sweep.toml", SWEEP);
        place.write(
            "maze.txt",
            "4\n20 20\n0\n80 80\n0 0 100 0\n100 0 100 100\n100 100 0 100\n0 100 0 0\n",
        );
        place.write("map.pgm", format!("P2 40 30 9\n{}", "9 ".repeat(40 * 30)));
        fs::create_dir(place.at("line-follower")).unwrap();
        for file in ["line-follower.toml", "line-follower/track.png"] {
            place.write(file, fs::read(experiments.join(file)).unwrap());
        }
        let shortened = |out: &str, file: &str, set: &[&str]| {
            let set: Vec<&str> = set.iter().flat_map(|&set| ["--set", set]).collect();
            let run = [&["run", file, "--seed", "1", "--out", out][..], &set].concat();
            place.good(&run);
        };
        shortened("run", "small.toml", &[]);
        shortened("random", "small.toml", &["evolution.kind=random"]);
        place.good(&["sweep", "run", "sweep.toml", "--out", "sweep"]);
        let few = ["cycles=30", "evolution.generations=2", "evolution.finalists=0"];
        let parents = [
            "evolution.population=10",
            "evolution.parents=5",
            "evolution.opponents.contests=2",
        ];
        shortened("pair", &shipped("predator-prey.toml"), &[&few[..], &parents].concat());
        shortened("parts", &shipped("homing.toml"), &few);
        place.copy("parts/config.toml", "parts.toml");
        let folder = place.at("parts/inputs");
        for input in fs::read_dir(folder).unwrap() {
            let name = input.unwrap().file_name();
            fs::create_dir_all(place.at("inputs")).unwrap();
            place.copy(Path::new("parts/inputs").join(&name), Path::new("inputs").join(&name));
        }
        let swarm = fs::read_to_string(shipped("odowd2014-over.toml")).unwrap();
        let values = "[swarm]\nminutes = 1\nlight_moves_minute = 0\n";
        place.write(
            "swarm.toml",
            swarm.replace("[swarm]\n", values).replace("robots = 10", "robots = 2"),
        );
        place.good(&["fleet", "key", "experiment.key"]);
        let robots = (0..2).map(|robot| {
            format!("[[robots]]\nnumber = {robot}\nhost = \"pi@10.0.1.{robot}\"\naddress = \"serial:/dev/rfcomm0\"\n")
        });
        let fleet = format!(
            "experiment = \"swarm.toml\"\nseed = 5\nkey = \"experiment.key\"\noperator = \"10.0.0.1:4711\"\nbinary = {:?}\n\
             [tracker]\nlisten = \"0.0.0.0:5005\"\n",
            env!("CARGO_BIN_EXE_oneiro")
        );
        place.write("fleet.toml", fleet + &robots.collect::<String>());
        let walls = "[robot]\npreset = \"epuck\"\n[arena]\nwidth_mm = 900\nheight_mm = 900\n";
        let evolution = "cycles = 5\n[evolution]\npopulation = 20\nparents = 4\ngenerations = 6\n";
        place.write("on-board.toml", evolution.to_owned() + walls);
        place
    }

    fn copy(&self, from: impl AsRef<Path>, to: impl AsRef<Path>) {
        fs::copy(self.at(from), self.at(to)).unwrap();
    }

    /// The program under a limit of the shell's.
    fn limited(&self, limit: &str, arguments: &[&str]) -> Output {
        let program = self.command(arguments);
        let mut shell = Command::new("sh");
        shell
            .args([
                "-c",
                &format!("{limit} && exec \"$0\" \"$@\""),
                env!("CARGO_BIN_EXE_oneiro"),
            ])
            .args(program.get_args())
            .current_dir(self.at(""))
            .stdin(std::process::Stdio::null())
            .output()
            .unwrap()
    }

    /// What is wrong with how a command ended.
    fn flaw(ended: &Output, wanted: &[i32]) -> Option<String> {
        let said = String::from_utf8_lossy(&ended.stderr);
        let code = ended.status.code();
        let has_sentence = code == Some(0) || said.lines().any(|line| line.starts_with("oneiro: "));
        if code.is_some_and(|code| wanted.contains(&code)) && has_sentence && !said.contains("panicked") {
            return None;
        }
        let tail: String = said
            .chars()
            .rev()
            .take(400)
            .collect::<Vec<_>>()
            .into_iter()
            .rev()
            .collect();
        Some(format!("exit {code:?}, signal {:?}: {tail}", ended.status.signal()))
    }
}

#[test]
fn all_commands_are_tried() {
    let place = Place::new("help");
    let help = place.good(&["--help"]);
    let named = |line: &&str| line.starts_with("  ") && !line.starts_with("   ") && !line.starts_with("  -");
    let known: BTreeSet<&str> = help
        .lines()
        .filter(named)
        .filter_map(|line| line.split_whitespace().next())
        .chain(HIDDEN)
        .chain(["help"])
        .collect();
    let tried = COMMANDS.iter().map(|(name, _)| name.split(' ').next().unwrap());
    let tried: BTreeSet<&str> = tried.collect();
    assert_eq!(tried, known);
}

/// Under little address space and few descriptors, small files and a small stack, every command ends with an exit code and a sentence, and what it has recorded is
/// continued with more of either to the results that a command without limits has.
#[test]
fn short_means_end_with_a_sentence() {
    let is_long = std::env::var_os("ONEIRO_LONG").is_some();
    let place = Place::prepared("limits");
    let memory: &[u32] = if is_long {
        &[60, 80, 100, 120, 150, 180, 200, 220, 250, 300, 350, 400, 450, 500]
    } else {
        &[120, 200, 400]
    };
    let files: &[u32] = if is_long {
        &[3, 4, 5, 6, 7, 8, 9, 10, 11, 12]
    } else {
        &[4, 7, 12]
    };
    let memory = memory.iter().map(|mb| format!("ulimit -v {}", mb * 1024));
    // Also small files and stacks.
    let others = ["ulimit -f 1", "ulimit -f 20", "ulimit -s 100"].map(str::to_owned);
    let limits: Vec<String> = memory
        .chain(files.iter().map(|files| format!("ulimit -n {files}")))
        .chain(others)
        .collect();
    let done = |directory: &str| {
        let done = Path::new(directory).join("DONE");
        let done = place.at(&done).exists().then(|| place.text(&done))?;
        serde_json::from_str::<serde_json::Value>(&done).unwrap()["result"]
            .as_str()
            .map(str::to_owned)
    };
    let whole = done("run");
    let robot = EPuck2::default().start();
    let (mut tried, mut problems) = (0, Vec::new());
    let mut codes = BTreeMap::new();
    for (number, limit) in std::iter::once("true")
        .chain(limits.iter().map(String::as_str))
        .enumerate()
    {
        // The system itself must be able to load the program.
        if matches!(place.limited(limit, &["--version"]).status.code(), None | Some(127)) {
            println!("{limit}: the program can't be loaded");
            continue;
        }
        for (name, arguments) in COMMANDS {
            let is_turn = is_long && number.is_multiple_of(5);
            if SLOW.contains(&name) && !is_turn {
                continue;
            }
            let out = format!("out-{number}-{}", name.replace(' ', "-"));
            let arguments: Vec<String> = arguments.iter().map(|own| own.replace("OUT", &out)).collect();
            let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
            let on_board = format!(
                "experiment = \"on-board.toml\"\naddress = \"{robot}\"\nseed = 3\ndirectory = \"{out}\"\n[transfers]\n\
                 generations = 1\nleast_lives = 2\nfinal_lives = 1\n[lives]\nwalk_s = 0\n[guard]\nlink_ms = 400\n"
            );
            place.write(format!("{out}-robot.toml"), on_board);
            let ended = place.limited(limit, &arguments);
            let Some(usual) = codes.get(name) else {
                // The first time without limits. Two commands lack what they ask for.
                let code = ended.status.code();
                let wanted = if matches!(name, "robot calibrate" | "robot ping") {
                    &[3, 4][..]
                } else {
                    &[0]
                };
                assert_eq!(Place::flaw(&ended, wanted), None, "{name}");
                codes.insert(name, code.unwrap());
                continue;
            };
            tried += 1;
            // Devices and robots may be out of reach; files can't be opened; memory is short.
            if let Some(flaw) = Place::flaw(&ended, &[*usual, 4, 6, 7]) {
                problems.push(format!("{name}, {limit}: {flaw}"));
            }
            if matches!(name, "run" | "sweep run") && ended.status.code() != Some(0) && place.at(&out).exists() {
                // Without a run in its directory, the same command begins.
                let has_begun = name == "run" && place.at(&out).join("config.toml").exists();
                let again = if has_begun {
                    place.run(&["resume", &out])
                } else {
                    place.run(&arguments)
                };
                let same = match name {
                    "run" => done(&out) == whole,
                    _ => place.read(Path::new(&out).join("results.csv")) == place.read("sweep/results.csv"),
                };
                if again.code != Some(0) || !same {
                    problems.push(format!("{name}, {limit}, continued: {:?} {}", again.code, again.stderr));
                }
            }
        }
    }
    println!("{tried} commands under {} limits", limits.len());
    assert!(
        problems.is_empty(),
        "{} of {tried}:\n{}",
        problems.len(),
        problems.join("\n")
    );
    assert!(tried > 100, "{tried}");
}

/// Where no thread can be started at all, that is said.
#[test]
fn without_threads_the_program_says_so() {
    let place = Place::new("threads");
    place.write("small.toml", EXPERIMENT);
    let mut command = place.command(&["run", "small.toml", "--seed", "1", "--out", "run"]);
    // More than any address space has.
    let ended = command
        .env("RUST_MIN_STACK", (1_u64 << 60).to_string())
        .output()
        .unwrap();
    Ran::new(&[], &ended)
        .exits(7)
        .says(&["oneiro: not enough memory or threads"]);
}

/// Signals of crashes also end it with a code and a sentence.
#[test]
fn crashes_end_with_a_sentence() {
    let place = Place::new("crashes");
    place.write(
        "small.toml",
        EXPERIMENT.replace("generations = 6", "generations = 1000000"),
    );
    for signal in ["-SEGV", "-ABRT", "-BUS"] {
        let out = signal.trim_start_matches('-');
        let mut program = place.start(&["run", "small.toml", "--seed", "1", "--out", out]);
        wait_for(|| place.at(out).join("meta.json").exists());
        kill(program.id(), signal);
        let began = Instant::now();
        while program.try_wait().unwrap().is_none() && began.elapsed().as_secs() < 60 {
            thread::sleep(Duration::from_millis(5));
        }
        // A program that goes on ends here, and by another way than it should.
        program.kill().unwrap();
        let ended = program.wait_with_output().unwrap();
        assert_eq!(Place::flaw(&ended, &[70]), None);
    }
}

fn kill(process: u32, signal: &str) {
    assert!(
        Command::new("kill")
            .args([signal, &process.to_string()])
            .status()
            .unwrap()
            .success()
    );
}

#[cfg(feature = "gpu")]
mod stops {
    use super::*;

    /// Whether a process has handlers for SIGINT (2) and SIGTERM (15).
    fn handles_signals(process: u32) -> bool {
        let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
        let caught = u64::from_str_radix(caught.trim(), 16).unwrap();
        [2, 15].iter().all(|signal| caught >> (signal - 1) & 1 == 1)
    }

    /// Most time from a signal to the end, on a very busy machine; on others it is half a second. The driver compiles for half a minute
    /// or more.
    const SOON: Duration = Duration::from_secs(12);

    /// A signal ends a run and a sweep within seconds, with a message, whatever they are doing in their first seconds: reading files,
    /// opening the device, or waiting for a driver that compiles a kernel for a minute.
    #[test]
    fn a_signal_is_obeyed_while_a_driver_compiles() {
        let place = Place::new("signals");
        let experiments = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments");
        let slow = experiments.join("evostick-exploration.toml").display().to_string();
        place.write("sweep.toml", format!("experiment = {slow:?}\nseeds = \"1..2\"\n"));
        let mut slowest = Duration::ZERO;
        for (number, wait) in [0, 100, 250, 500, 900, 2_000].into_iter().enumerate() {
            for signal in ["-TERM", "-INT"] {
                let out = format!("out-{number}{signal}");
                let arguments = match number % 2 {
                    0 => vec!["run", &slow, "--seed", "1", "--out", &out],
                    _ => vec!["sweep", "run", "sweep.toml", "--out", &out],
                };
                let arguments = [&arguments[..], &["--backend", "gpu:llvmpipe"]].concat();
                let mut command = place.command(&arguments);
                // So that it compiles each time.
                command
                    .env("MESA_SHADER_CACHE_DISABLE", "true")
                    .env("MESA_GLSL_CACHE_DISABLE", "true");
                command
                    .stdout(std::process::Stdio::piped())
                    .stderr(std::process::Stdio::piped());
                let program = command.spawn().unwrap();
                // Until then a signal ends it as it ends any program, and nothing has begun.
                wait_for(|| handles_signals(program.id()));
                thread::sleep(Duration::from_millis(wait));
                let began = Instant::now();
                kill(program.id(), signal);
                let ended = program.wait_with_output().unwrap();
                slowest = slowest.max(began.elapsed());
                println!("{signal} after {wait} ms: {:.1?}", began.elapsed());
                assert_eq!(Place::flaw(&ended, &[75]), None, "{signal} after {wait} ms");
            }
        }
        println!("the slowest end took {slowest:.1?}");
        assert!(slowest < SOON, "{slowest:?}");
    }
}
