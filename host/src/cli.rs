//! The command line: its commands, arguments and help texts. What they do is in `commands`.

mod choices;
mod device;
mod groups;
mod moved;
mod numbers;
mod reproduce;

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{ArgMatches, Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum, ValueHint};
use oneiro::backend::Specialise;
use oneiro::parameter::{self, Choice};
use oneiro_base::console::{Console, Output, shown};
use oneiro_base::exit;
use oneiro_base::files;
use oneiro_lab::experiment::{self, SEED, reference};
use oneiro_lab::reality::site::SEVERITY;
use oneiro_lab::reality::wired::{self, Starts};
use oneiro_lab::sweep::store::Shard;
use oneiro_robots::{Kind, tracker};

use self::choices::choice;
pub(crate) use self::device::Backend;
use self::numbers::{number, of_key, out_of_range, seed, whole};
pub(crate) use self::reproduce::{Miglino1995, Odowd2014, Paper, Reproduce};

/// The program's name.
const PROGRAM: &str = "oneiro";

/// Evolves robot controllers in simulated lives, bit for bit the same on every device.
///
/// Data go to standard output, messages to standard error. Exit codes: 0 done, 1 failed, 2 usage,
/// 3 configuration or input invalid, 4 no usable device or robot, 5 data corrupt, 6 disk full or I/O, 7 not enough memory, 70 a mistake in Oneiro,
/// 75 stopped early and resumable, 130 aborted.
#[derive(Debug, Parser)]
#[command(name = PROGRAM, version, propagate_version = true)]
pub(crate) struct Cli {
    /// Print data as JSON
    #[arg(long, global = true, display_order = 900)]
    json: bool,
    /// Hide all messages but errors, and the progress bar
    #[arg(long, short, global = true, display_order = 901)]
    quiet: bool,
    /// The command.
    #[command(subcommand)]
    command: Command,
}

/// Prints an error of the command line as clap does, its words escaped, or what the command line asks clap for. Returns the exit
/// code.
pub(crate) fn show(error: &clap::Error) -> u8 {
    let text = error.render().to_string();
    match shown(&text) {
        // In colours, where there are some. If the output is closed, there is nobody to read it.
        Cow::Borrowed(_) => drop(error.print()),
        Cow::Owned(text) => Console::default().ask(text.trim_end()),
    }
    error.exit_code() as u8
}

/// The whole command line.
pub(crate) fn command() -> clap::Command {
    /// Options of [`Backend`].
    const DEVICE: [&str; 4] = ["backend", "threads", "recheck", "specialise"];
    let for_recomputing = |argument: clap::Arg| {
        if DEVICE.contains(&argument.get_id().as_str()) {
            argument.requires("recompute")
        } else {
            argument
        }
    };
    let program = Cli::command().mut_subcommands(|command| match command.get_name() {
        "verify" => command.mut_args(for_recomputing),
        _ => command,
    });
    numbers::with_hyphens(groups::grouped(program))
}

impl Cli {
    /// Parses the command line. The command is a refusal if an option names a file where a directory belongs, or has a number
    /// out of the range of a key.
    ///
    /// # Errors
    /// Help, and mistakes of usage.
    pub(crate) fn typed() -> Result<(Output, exit::Result<Command>), clap::Error> {
        let mut command = command();
        let typed = command.try_get_matches_from_mut(std::env::args_os());
        let parsed = typed.and_then(|matches| Ok((Self::from_arg_matches(&matches)?, matches)));
        let (cli, matches) = match parsed {
            Ok(parsed) => parsed,
            Err(error) => {
                let refusal = out_of_range(&error).ok_or_else(|| advised(error, &command))?;
                return Ok((Output::default(), Err(refusal)));
            }
        };
        let output = Output {
            json: cli.json,
            quiet: cli.quiet,
        };
        Ok((output, directories(&command, &matches).map(|()| cli.command)))
    }
}

/// Checks all directories that the options of a command line name.
fn directories(command: &clap::Command, matches: &ArgMatches) -> exit::Result {
    if let Some((name, matches)) = matches.subcommand()
        && let Some(command) = command.find_subcommand(name)
    {
        return directories(command, matches);
    }
    for argument in command
        .get_opts()
        .filter(|own| own.get_value_hint() == ValueHint::DirPath)
    {
        for path in matches.get_raw(argument.get_id().as_str()).into_iter().flatten() {
            let option = argument.get_long().unwrap_or_default();
            let refused = |failure: exit::Failure| exit::Failure::input(format_args!("--{option} {failure}"));
            files::must_not_be_file(Path::new(path)).map_err(refused)?;
        }
    }
    Ok(())
}

/// Words that other programs have for this one's options, and for its commands.
const OTHER_WORDS: [(&str, &str); 18] = [
    ("device", "--backend NAME"),
    ("gpu", "--backend gpu"),
    ("cuda", "--backend gpu"),
    ("cpu", "--backend cpu"),
    ("output", "--out PATH"),
    ("runs", "--seeds 1..N"),
    ("workers", "--threads N"),
    ("share", "--fraction F"),
    ("contests", "--trials N"),
    ("evolve", "run"),
    ("train", "run"),
    ("optimize", "run"),
    ("validate", "check"),
    ("init", "new"),
    ("create", "new"),
    ("plot", "replay"),
    ("draw", "replay"),
    ("version", "--version"),
];

/// An error of the parser with tips that lead further than its own: these are by another measure of likeness, and to pass an unknown
/// option as a value, which no command takes.
fn advised(mut error: clap::Error, program: &clap::Command) -> clap::Error {
    let (unknown, theirs) = match error.kind() {
        ErrorKind::UnknownArgument => (ContextKind::InvalidArg, ContextKind::SuggestedArg),
        ErrorKind::InvalidSubcommand => (ContextKind::InvalidSubcommand, ContextKind::SuggestedSubcommand),
        _ => return error,
    };
    error.remove(ContextKind::Suggested);
    error.remove(theirs);
    let words: Vec<String> = std::env::args_os()
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    let mut command = program;
    for word in words.iter().skip(1).filter(|word| !word.starts_with('-')) {
        match command.find_subcommand(word) {
            Some(own) => command = own,
            None => break,
        }
    }
    let tip = match error.get(unknown) {
        Some(ContextValue::String(word)) if unknown == ContextKind::InvalidArg => option_tip(word, &words, command),
        Some(ContextValue::String(word)) => command_tip(word, command, program),
        _ => None,
    };
    if let Some(tip) = tip {
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
    error
}

/// What to type instead of a word that a command doesn't know.
fn option_tip(unknown: &str, words: &[String], command: &clap::Command) -> Option<String> {
    let is_apart = |words: &&[String]| words[0] == "--set" && !words[1].contains('=') && words[2] == unknown;
    if let Some([_, key, value]) = words.windows(3).find(is_apart) {
        return Some(format!("a key and its value are one word: '--set {key}={value}'"));
    }
    let name = unknown.strip_prefix("--")?;
    let has = |name: &str| {
        command
            .get_arguments()
            .any(|own| own.get_id() == name || own.get_long() == Some(name))
    };
    if has("sweep") && ["set", "seed", "seeds"].contains(&name) {
        return Some("a sweep's seeds and values are in its file: seeds, [set] and [grid] (docs/sweeps.md)".to_owned());
    }
    let meant = |option: &str| format!("did you mean '{option}'?");
    if let Some(own) = parameter::nearest(command.get_arguments().filter_map(clap::Arg::get_long), name) {
        return Some(meant(&format!("--{own}")));
    }
    let is_own = |option: &str| {
        option
            .strip_prefix("--")
            .and_then(|own| own.split(' ').next())
            .is_some_and(has)
    };
    if let Some((_, option)) = OTHER_WORDS
        .iter()
        .find(|(other, option)| *other == name && is_own(option))
    {
        return Some(meant(option));
    }
    let name = name.replace('-', "_");
    let keys = reference::single()
        .into_iter()
        .chain(reference::swarm())
        .map(|entry| entry.key);
    let keys: Vec<&str> = keys.filter(|key| key.rsplit('.').next() == Some(&name)).collect();
    let key = keys
        .iter()
        .find(|key| key.starts_with("evolution."))
        .or(keys.first())
        .filter(|_| has("set"))?;
    Some(format!("a value of the experiment is set by '--set {key}=VALUE'"))
}

/// What to type instead of an unknown command: its new name, that of the same name elsewhere, one that is much like it, or
/// this program's word for it.
fn command_tip(unknown: &str, command: &clap::Command, program: &clap::Command) -> Option<String> {
    fn of_name(command: &clap::Command, name: &str, path: &str, found: &mut Vec<String>) {
        for own in command.get_subcommands().filter(|own| !own.is_hide_set()) {
            let path = format!("{path} {}", own.get_name());
            if own.get_name() == name {
                found.push(path.clone());
            }
            of_name(own, name, &path, found);
        }
    }
    if let Some(tip) = moved::tip(unknown) {
        return Some(tip);
    }
    let mut found = Vec::new();
    of_name(program, unknown, program.get_name(), &mut found);
    if found.is_empty() {
        let shown = command.get_subcommands().filter(|own| !own.is_hide_set());
        let names: Vec<&str> = shown.map(clap::Command::get_name).collect();
        let begun = names
            .iter()
            .copied()
            .find(|name| unknown.len() > 2 && name.starts_with(unknown));
        let other = || {
            OTHER_WORDS
                .iter()
                .find(|(other, _)| *other == unknown)
                .map(|(_, own)| *own)
        };
        let name = begun
            .or_else(|| parameter::nearest(names.into_iter(), unknown))
            .or_else(other)?;
        found.push(format!(
            "{} {name}",
            command.get_bin_name().unwrap_or_else(|| command.get_name())
        ));
    }
    Some(format!("did you mean '{}'?", found.join("' or '")))
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Write an experiment to start from, or list what it may set
    New(New),
    /// Validate an experiment, summarise it and draw its arena
    Check(Check),
    /// Evolve controllers from one seed or from many
    Run(Run),
    /// Finish a run that was stopped
    Resume(Resume),
    /// Run many evolutions as one job: a grid of values, many seeds each
    Sweep(Sweep),
    /// Repeat a paper's whole study and judge its claims
    Reproduce(Reproduce),
    /// List runs and their state
    List(List),
    /// Simulate a run's champion again, and write its path and trace
    Replay(Replay),
    /// Score genomes, find the best of many, or play a tournament
    Evaluate(Evaluate),
    /// Compare experiments: scores, tests and figures in one report
    Compare(Compare),
    /// Check a run's files; recompute its results and compare the bits
    Verify(Verify),
    /// Find, watch, drive and stop a robot; sample and calibrate it
    Robot(Robot),
    /// Install, start, watch and stop robots with a computer each
    Fleet(Fleet),
    /// List this machine's devices; test their bits and their speed
    Device(Device),
    /// Print a completion script for a shell
    Completions(Completions),
    /// Run on a robot's computer: control it while evolving in its simulator, by itself or as a member of a swarm
    #[command(hide = true)]
    OnBoard(OnBoard),
    /// Own a robot's link for a program that drives, and stop the wheels when it dies, hangs or misses something
    #[command(hide = true)]
    Guard(GuardProcess),
}

/// `oneiro new`
#[derive(Args, Debug)]
pub(crate) struct New {
    /// The experiment's name. Writes NAME.toml, and never overwrites a file
    #[arg(required_unless_present_any = ["example", "keys"])]
    pub(crate) name: Option<String>,
    /// Write an experiment with a swarm
    #[arg(long)]
    pub(crate) swarm: bool,
    /// Write an experiment with a single e-puck that brings food to its nest
    #[arg(long, conflicts_with = "swarm")]
    pub(crate) forager: bool,
    /// Write an experiment with a robot that is described by numbers, here those of khepera, epuck, thymio2 or kheperax
    #[arg(long, value_name = "NAME", conflicts_with_all = ["swarm", "forager"])]
    pub(crate) robot: Option<String>,
    /// Write an experiment with sensors of your own, and the sensors, NAME.wgsl, to change as you like
    #[arg(long, value_name = "NAME", conflicts_with = "swarm")]
    pub(crate) sensor: Option<String>,
    /// The same with a controller
    #[arg(long, value_name = "NAME", conflicts_with = "swarm")]
    pub(crate) controller: Option<String>,
    /// The same with a task
    #[arg(long, value_name = "NAME", conflicts_with = "swarm")]
    pub(crate) task: Option<String>,
    /// Write an experiment that ships with Oneiro, with its parts; without a name, list them
    #[arg(
        long,
        value_name = "NAME",
        num_args = 0..=1,
        default_missing_value = "",
        conflicts_with_all = ["name", "swarm", "forager", "robot", "sensor", "controller", "task"]
    )]
    pub(crate) example: Option<String>,
    /// List the keys of experiments with their defaults, allowed values and meanings: those that contain PART, such as noise, or all
    #[arg(
        long,
        value_name = "PART",
        num_args = 0..=1,
        default_missing_value = "",
        conflicts_with_all = ["name", "swarm", "forager", "robot", "sensor", "controller", "task", "example"]
    )]
    pub(crate) keys: Option<String>,
}

/// In place of a rule's name, lists all of them.
pub(crate) const ALL_RULES: &str = "list";

/// `oneiro check`
#[derive(Args, Debug)]
pub(crate) struct Check {
    /// The experiment's TOML file
    #[arg(value_hint = ValueHint::FilePath, required_unless_present = "explain")]
    pub(crate) experiment: Option<PathBuf>,
    /// Explain a rule that parts of your own keep, such as no-division: refusals end with its name. Without a name, list
    /// all rules
    #[arg(long, value_name = "RULE", num_args = 0..=1, default_missing_value = ALL_RULES)]
    #[arg(conflicts_with_all = ["experiment", "set", "out"])]
    pub(crate) explain: Option<String>,
    /// Change a value of the experiment, such as noise.sensor=[0.0,0.4]. May be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = setting)]
    pub(crate) set: Vec<String>,
    /// Draw the arena into this file (SVG)
    #[arg(long, value_name = "FILE.svg", value_hint = ValueHint::FilePath)]
    pub(crate) out: Option<PathBuf>,
    /// Interpret this many lives of random genomes, and check that no number in them becomes infinite, subnormal or not a
    /// number, which devices may treat in different ways
    #[arg(long, value_name = "N", default_value_t = 0, conflicts_with = "explain", value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub(crate) lives: u32,
    /// Count the operations of a cycle on a GPU, with and without a kernel of its own for this world, and the steps per second that cards
    /// can do at most
    #[arg(long, conflicts_with = "explain")]
    pub(crate) cost: bool,
}

/// `oneiro run`
#[derive(Args, Debug)]
pub(crate) struct Run {
    /// The experiment's TOML file
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) experiment: PathBuf,
    /// The run's seed [default: the experiment's, else a random one]
    #[arg(long, value_name = "N", conflicts_with = "seeds", value_parser = seed())]
    pub(crate) seed: Option<u64>,
    /// Do one run for each seed from A to B, both included
    #[arg(long, value_name = "A..B", value_parser = seeds)]
    pub(crate) seeds: Option<std::ops::RangeInclusive<u64>>,
    /// The device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
    /// Change a value of the experiment, such as noise.sensor=[0.0,0.4]. May be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = setting)]
    pub(crate) set: Vec<String>,
    /// The run's directory, or with --seeds the directory of the runs [default: runs/NAME-SEED-HASH]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
}

/// `oneiro resume`
#[derive(Args, Debug)]
pub(crate) struct Resume {
    /// The run's directory, or a directory of runs
    #[arg(value_hint = ValueHint::DirPath)]
    pub(crate) run_dir: PathBuf,
    /// The device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
}

/// `oneiro evaluate`
#[derive(Args, Debug)]
#[command(override_usage = "oneiro evaluate [OPTIONS] [EXPERIMENT] --genomes <FILE|DIR>...
       oneiro evaluate [OPTIONS] <EXPERIMENT> --random <N>
       oneiro evaluate [OPTIONS] [EXPERIMENT] --best --genomes <FILE|DIR>...
       oneiro evaluate [OPTIONS] --tournament --genomes <DIR>...")]
pub(crate) struct Evaluate {
    /// The experiment's TOML file, given before --genomes [default: that of the runs in --genomes]
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) experiment: Option<PathBuf>,
    /// .npy (f4 or f8, rows x genes), .csv (a genome per row), a run's champion.json, a run's directory (its champion), a
    /// directory of runs, or a sweep's directory (its champions). Any number of them. Genes are found by name; without names,
    /// as in .npy, they are in the controller's order
    #[arg(long, value_name = "FILE|DIR", required_unless_present = "random", num_args = 1.., value_hint = ValueHint::AnyPath)]
    pub(crate) genomes: Vec<PathBuf>,
    /// Add N random genomes, each gene drawn by --seed from the range that an evolution's first generation has
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=100_000))]
    pub(crate) random: Option<u32>,
    /// Of runs, take the whole last generation instead of the champion
    #[arg(long)]
    pub(crate) population: bool,
    /// Seed of the rollouts' random numbers. With a run's own seed, genome G meets the starts and the random numbers of
    /// individual G of that run's first generation: for lives that its evolution has not seen, take another [default: the
    /// experiment's, else 1; 1 if only runs are given]
    #[arg(long, value_name = "N", value_parser = seed())]
    pub(crate) seed: Option<u64>,
    /// Rollouts of each genome [default: the experiment's; 100 with --best], or contests of each pair of a tournament, at most 10000
    /// [default: 10]
    #[arg(long, value_name = "K", value_parser = whole::<u32>(1..=1_000_000))]
    pub(crate) trials: Option<u32>,
    /// Give all genomes the same starts and the same random numbers, so that they can be compared trial by trial
    #[arg(long)]
    pub(crate) common_starts: bool,
    /// Start one episode of each genome at each of these poses, one per line: x and y in mm, heading in turns. A header names
    /// its columns (`x_mm`, `y_mm`, `heading_turns`) in any order
    #[arg(long, value_name = "FILE.csv", value_hint = ValueHint::FilePath, conflicts_with = "trials")]
    pub(crate) starts: Option<PathBuf>,
    /// The experiment's noise, or none: neither that of the table `noise` nor that of wheels and light. What a part of your
    /// own draws stays, and so does that of a forager's proximity sensors
    #[arg(long, value_name = "on|off", value_enum, default_value_t = Noise::On)]
    pub(crate) noise: Noise,
    /// What is written of the rollouts.
    #[command(flatten)]
    pub(crate) rows: Rows,
    /// Write a trace of each rollout into this directory, which must be empty or new
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) traces: Option<PathBuf>,
    /// The device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
    /// Lives on a robot instead.
    #[command(flatten)]
    pub(crate) on_robot: OnRobot,
    /// Change a value of the experiment, such as noise.sensor=[0.0,0.4]. May be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = setting)]
    pub(crate) set: Vec<String>,
    /// Write the results to this file (.csv or .npy, never overwritten); - is standard output. With --best: write the best genome to
    /// it (.json), as champion.json has it
    #[arg(long, value_name = "FILE", default_value = "-", value_hint = ValueHint::FilePath)]
    pub(crate) out: PathBuf,
    /// The best genome instead.
    #[command(flatten)]
    pub(crate) ranked: Ranked,
    /// A tournament instead.
    #[command(flatten)]
    pub(crate) played: Played,
}

impl Evaluate {
    /// The file to write, unless the results go to standard output.
    pub(crate) fn file(&self) -> Option<&Path> {
        (self.out.as_os_str() != "-").then_some(self.out.as_path())
    }
}

/// Options of `oneiro evaluate` that have no effect on the best of many genomes, nor on a tournament.
const USUAL: [&str; 18] = [
    "random",
    "population",
    "common_starts",
    "starts",
    "noise",
    "traces",
    "summary",
    "measures",
    "robots",
    "lives",
    "between",
    "walk",
    "speed",
    "sensors",
    "trackers",
    "tracker_age",
    "guard",
    "severity",
];

/// The best of many genomes, of `oneiro evaluate`.
#[derive(Args, Debug)]
#[command(next_help_heading = "Comparing genomes")]
pub(crate) struct Ranked {
    /// Re-evaluate the genomes on the same new episodes, list them from the best mean to the worst, and report the best. Of each run
    /// in --genomes, the champion, the luckiest and the last generation take part; of a sweep, each run's champion. The best of many
    /// genomes was also lucky: another --seed shows its true mean
    #[arg(long, conflicts_with_all = USUAL)]
    pub(crate) best: bool,
    /// Of runs, take every individual that was evaluated, not only the last generation
    #[arg(long, requires = "best")]
    pub(crate) individuals: bool,
    /// List all genomes, not only the best ones
    #[arg(long, requires = "best")]
    pub(crate) all: bool,
}

/// A tournament, of `oneiro evaluate`.
#[derive(Args, Debug)]
#[command(next_help_heading = "Comparing genomes")]
pub(crate) struct Played {
    /// Play the best of each generation of two populations against each other, with the same starts for all pairs. --genomes names
    /// runs with `evolution.kind = "coevolution"`. The results are written there: tournament.csv, and the pictures tournament.svg and
    /// tournament-progress.svg
    #[arg(long, conflicts_with_all = USUAL, conflicts_with_all = ["experiment", "set", "out", "best"])]
    pub(crate) tournament: bool,
    /// Let every Nth generation take part
    #[arg(long, value_name = "N", default_value_t = 1, requires = "tournament", value_parser = whole::<u32>(1..=u32::MAX.into()))]
    pub(crate) every: u32,
}

/// Rows and columns of results, of `oneiro evaluate`.
#[derive(Args, Debug)]
pub(crate) struct Rows {
    /// One row for each genome instead of each rollout: mean fitness, standard deviation and the mean's 95 % confidence
    /// interval; with --measures also the mean of each measure
    #[arg(long)]
    pub(crate) summary: bool,
    /// Add measures of behaviour, such as the distance driven, the mean distance to walls, and what a task of your own
    /// remembers at the end: docs/measures.md lists them
    #[arg(long)]
    pub(crate) measures: bool,
}

/// Lives on a robot, of `oneiro evaluate`.
#[derive(Args, Debug)]
pub(crate) struct OnRobot {
    /// Evaluate on a robot instead of in the simulation: at an address as `oneiro robot list` has them, such as
    /// `serial:/dev/ttyUSB0`, or on the surrogate of a Khepera, such as `surrogate:1`. Repeat it for several robots, which share the lives
    #[arg(long = "robot", value_name = "ADDRESS", conflicts_with_all = ["starts", "noise", "measures", "traces"])]
    pub(crate) robots: Vec<String>,
    /// Record lives on a robot in this directory. Those that are complete there are not lived again
    #[arg(long, value_name = "DIR", requires = "robots", value_hint = ValueHint::DirPath)]
    pub(crate) lives: Option<PathBuf>,
    /// How each life on a robot gets its start
    #[arg(long, value_name = "HOW", value_parser = choice::<Starts>(), default_value = Starts::default().word(), requires = "lives")]
    pub(crate) between: Starts,
    /// How long a robot drives about at random before each life, 0 to 600 s; 0: a life starts where the last one has ended
    #[arg(long, value_name = "SECONDS", default_value_t = wired::WALK_S, requires = "lives", value_parser = number::<f64>(0.0..=wired::LONGEST_WALK_S))]
    pub(crate) walk: f64,
    /// Speed of a robot's wheel at the controller's greatest output, mm/s [default: the experiment's; 80 for sampled motors]
    #[arg(long, value_name = "MM_S", requires = "lives", value_parser = number::<f64>(wired::SPEEDS_MM_S[0]..=wired::SPEEDS_MM_S[1]))]
    pub(crate) speed: Option<f64>,
    /// Read a sensor of the experiment from one of the robot that has another name, such as `left_90=prox_5`. May be repeated
    #[arg(long = "sensor", value_name = "NAME=NAME", requires = "lives", value_parser = pair)]
    pub(crate) sensors: Vec<(String, String)>,
    /// Listen at this address to a tracker that reports where the robot is, such as `udp:0.0.0.0:5005#1` for its robot 1. Repeat it for
    /// several robots, in their order [default: poses from the odometers]
    #[arg(long = "tracker", value_name = "ADDRESS", requires = "lives")]
    pub(crate) trackers: Vec<String>,
    /// Age of the tracker's last sighting at which the robot counts as lost and is stopped, 50 to 2000 ms
    #[arg(long, value_name = "MS", default_value_t = tracker::AGE_MS, requires = "trackers",
        value_parser = whole::<u64>(tracker::AGES_MS))]
    pub(crate) tracker_age: u64,
    /// Set a value of the guard, such as `expiry_ms=200`. May be repeated; docs/robots-on-the-wire.md lists them
    #[arg(long, value_name = "KEY=VALUE", requires = "lives")]
    pub(crate) guard: Vec<String>,
    #[arg(
        long,
        value_name = "LAMBDA",
        requires = "robots",
        conflicts_with = "lives",
        value_parser = of_key::<f32>("reality.severity"),
        help = format!(
            "How much a surrogate differs from the simulator made from its samples, 0 to 2 [default: {}]",
            SEVERITY
        )
    )]
    pub(crate) severity: Option<f32>,
}

/// Whether lives have their experiment's noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Noise {
    /// As the experiment says
    On,
    /// None
    Off,
}

/// `oneiro replay`
#[derive(Args, Debug)]
pub(crate) struct Replay {
    /// The run's directory
    #[arg(value_hint = ValueHint::DirPath)]
    pub(crate) run_dir: PathBuf,
    /// The device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
    /// Write replay.svg and replay.csv into this directory; with several trials, replay-K.svg and replay-K.csv of trial K. The
    /// names of other lives say what they have of their own, such as replay-seed-5.svg. Of robots that live together also
    /// replay.html, a page that plays them, and replay-robots.csv, a row for each [default: the run's directory]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    /// Which of the champion's trials to draw, from 0
    #[arg(long, value_name = "K", default_value_t = 0, value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub(crate) trial: u32,
    /// Start elsewhere: x and y in mm, heading in turns, such as 100,90,0.125. The record has no such life, so nothing
    /// is compared
    #[arg(long, value_name = "X,Y,HEADING", value_parser = pose, allow_hyphen_values = true)]
    pub(crate) start: Option<[f32; 3]>,
    /// Draw other random numbers, for starts and noise: those of `oneiro evaluate --seed N`. The record has no such life,
    /// so nothing is compared
    #[arg(long, value_name = "N", value_parser = seed())]
    pub(crate) seed: Option<u64>,
    /// Draw the elite of this cell of the run's archive instead of the champion: `archive.csv` lists them
    #[arg(long, value_name = "CELL", conflicts_with = "genome", value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub(crate) elite: Option<u32>,
    /// Let all elites of the run's archive live again, compare each with the record, and write a page that shows the archive and
    /// plays a life of the elite that is clicked: archive.html
    #[arg(long, conflicts_with_all = ["elite", "genome", "start", "seed"])]
    pub(crate) elites: bool,
    /// Draw this genome instead of the champion, such as one written by `oneiro evaluate --best --out`. Its random numbers are
    /// those of --seed, 1 if not given, and nothing is compared
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) genome: Option<PathBuf>,
    /// Record every Nth cycle
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u32>(1..=u32::MAX.into()))]
    pub(crate) every: u32,
}

/// `oneiro verify`
#[derive(Args, Debug)]
pub(crate) struct Verify {
    /// The directory of a run, of several runs, or of a sweep
    #[arg(value_hint = ValueHint::DirPath)]
    pub(crate) run_dir: PathBuf,
    /// Also evaluate a part of each run's individuals again on this machine, and compare the bits with the record. Of a swarm,
    /// everything is simulated again
    #[arg(long)]
    pub(crate) recompute: bool,
    /// Fraction of the recorded individuals to evaluate again, above 0 and up to 1
    #[arg(long, value_name = "FRACTION", default_value_t = 0.01, requires = "recompute", value_parser = fraction)]
    pub(crate) fraction: f64,
    /// The device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
}

/// `oneiro list`
#[derive(Args, Debug)]
pub(crate) struct List {
    /// A directory of runs [default: runs]
    #[arg(value_hint = ValueHint::DirPath)]
    pub(crate) dir: Option<PathBuf>,
}

/// `oneiro device`
#[derive(Args, Debug)]
pub(crate) struct Device {
    /// Subcommand to run.
    #[command(subcommand)]
    pub(crate) command: DeviceCommand,
}

/// Commands for this machine's devices.
#[derive(Debug, Subcommand)]
pub(crate) enum DeviceCommand {
    /// List this machine's devices, and whether each is exact
    List(DeviceList),
    /// Check that this machine computes the same bits as every other
    Test(DeviceTest),
    /// Measure robot-steps per second
    Bench(DeviceBench),
    /// Compile an experiment's kernel at the full width of this machine, with an installed Rust toolchain
    #[cfg(all(feature = "ahead", any(target_arch = "x86_64", target_arch = "aarch64")))]
    Compile(DeviceCompile),
}

/// `oneiro device list`
#[derive(Args, Debug)]
pub(crate) struct DeviceList {
    /// Compile every kernel for each adapter, and print what its driver tells of the machine code: registers, instructions and the like
    #[arg(long)]
    pub(crate) explain: bool,
}

/// `oneiro device test`
#[derive(Args, Debug)]
pub(crate) struct DeviceTest {
    /// What to check: all, cpu, gpu (every adapter), gpu:NAME or gpu:INDEX
    #[arg(long, value_name = "BACKEND", default_value = "all")]
    pub(crate) backend: String,
    /// Rollouts of 500 cycles for each controller, in worlds of every kind. Surrogates get a 20th of that
    #[arg(long, value_name = "N", default_value_t = 4000, value_parser = whole::<u32>(1000..=1_000_000))]
    pub(crate) rollouts: u32,
    /// Sensor tables to use instead of the built-in ones, such as wall.sam,round.sam
    #[arg(long, value_name = "FILE,..", value_delimiter = ',', value_hint = ValueHint::FilePath)]
    pub(crate) tables: Vec<PathBuf>,
}

/// `oneiro device bench`
#[derive(Args, Debug)]
pub(crate) struct DeviceBench {
    /// An experiment's TOML file, to time the first 500 cycles of its lives instead of a Khepera's [default: the Khepera of the 1995
    /// paper]
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) experiment: Option<PathBuf>,
    /// Change a value of the experiment, such as noise.sensor=[0.0,0.4]. May be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = setting, requires = "experiment")]
    pub(crate) set: Vec<String>,
    /// Batch sizes [default: 1000,10000,100000,1000000, without those that take too long]
    #[arg(long, value_name = "N,..", value_delimiter = ',', value_parser = whole::<u32>(1..=16_777_216))]
    pub(crate) rollouts: Vec<u32>,
    /// Take seconds instead of minutes: smaller batches and fewer repetitions
    #[arg(long)]
    pub(crate) quick: bool,
    /// What to measure: all, cpu, gpu (every adapter), gpu:NAME or gpu:INDEX; null is the same as --host
    #[arg(long, value_name = "BACKEND", default_value = "all")]
    pub(crate) backend: String,
    /// When kernels of GPUs, and those compiled at run time, are compiled again for the world: auto, always or never
    #[arg(long, value_name = "WHEN", default_value = "auto", value_parser = Specialise::from_str)]
    pub(crate) specialise: Specialise,
    /// Write the figures, the devices and their drivers into this file (.json, never overwritten), to send to others
    #[arg(long, value_name = "FILE.json", value_hint = ValueHint::FilePath)]
    pub(crate) share: Option<PathBuf>,
    /// Measure the host instead: individuals per second of a sweep on a device that answers at once, with all that a sweep
    /// records, in a temporary directory
    #[arg(long, conflicts_with_all = ["experiment", "rollouts", "quick", "backend", "specialise", "share"])]
    pub(crate) host: bool,
    /// With --host: approximate time for each number of processors [default: 10]
    #[arg(long, value_name = "N", conflicts_with_all = ["rollouts", "quick"], value_parser = whole::<u32>(1..=3600))]
    pub(crate) seconds: Option<u32>,
    /// With --host: numbers of processors [default: from 1 to all]
    #[arg(long, value_name = "N,..", value_delimiter = ',', conflicts_with_all = ["rollouts", "quick"], value_parser = whole::<u16>(1..=1024))]
    pub(crate) processors: Vec<u16>,
}

/// `oneiro device compile`
#[cfg(all(feature = "ahead", any(target_arch = "x86_64", target_arch = "aarch64")))]
#[derive(Args, Debug)]
pub(crate) struct DeviceCompile {
    /// The experiment's TOML file
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) experiment: PathBuf,
    /// Change a value of the experiment, such as noise.sensor=[0.0,0.4]. May be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = setting)]
    pub(crate) set: Vec<String>,
    /// Compile it even if this version of Rust has compiled it before
    #[arg(long)]
    pub(crate) again: bool,
}

/// `oneiro robot`
#[derive(Args, Debug)]
pub(crate) struct Robot {
    /// Subcommand to run.
    #[command(subcommand)]
    pub(crate) command: RobotCommand,
}

/// Commands for robots, and for the samples and recordings of them.
#[derive(Debug, Subcommand)]
pub(crate) enum RobotCommand {
    /// List this machine's serial ports and the forms of addresses
    List,
    /// Connect to a robot, which stops its wheels, and print what it is, what it has and how fast it answers
    Ping(RobotLink),
    /// Show a robot's sensors live until Ctrl-C, its wheels stopped: bars on a terminal, else a line of JSON per reading
    Watch(RobotWatch),
    /// Drive a robot by keys or by a file, under a guard that stops the wheels when this program dies or hangs
    ///
    /// Keys: arrows or W, A, S, D drive forwards, turn left, drive backwards and turn right while one is held; + and - set
    /// the speed; space stops, and R resumes; Q quits.
    Drive(RobotDrive),
    /// Switch lights of a robot on or off, its wheels stopped
    Light(RobotLight),
    /// Stop a robot's wheels, and say whether it confirmed that
    Stop(RobotLink),
    /// Sample a robot's sensors and motors into tables
    Sample(RobotSample),
    /// Compare an experiment's simulator with recorded lives of the robot, and print the noise and the settings that follow
    Calibrate(RobotCalibrate),
    /// Show, convert and export sampled sensor and motor tables
    Tables {
        /// Subcommand to run.
        #[command(subcommand)]
        command: RobotTables,
    },
}

/// A robot on the command line.
#[derive(Args, Debug)]
pub(crate) struct RobotLink {
    /// Where the robot is, such as `serial:/dev/ttyUSB0`, `tcp:192.168.1.7:1000` or `aseba:serial:/dev/ttyACM0`.
    /// `oneiro robot list` has all forms
    #[arg(value_name = "ADDRESS")]
    pub(crate) address: String,
    /// Record all bytes of the link in this file, never overwritten, for a bug report
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) record: Option<PathBuf>,
}

/// `oneiro robot watch`
#[derive(Args, Debug)]
pub(crate) struct RobotWatch {
    /// The robot.
    #[command(flatten)]
    pub(crate) link: RobotLink,
    /// Kinds of sensors [default: all that the robot has]
    #[arg(long, value_name = "KIND,..", value_delimiter = ',', value_parser = choice::<Kind>())]
    pub(crate) kinds: Vec<Kind>,
    /// Readings per second, 0.1 to 100. Slow links give fewer
    #[arg(long, value_name = "N", default_value_t = 10.0, value_parser = number::<f64>(0.1..=100.0))]
    pub(crate) hz: f64,
    /// End after N readings
    #[arg(long, value_name = "N", value_parser = whole::<u64>(1..=u64::MAX))]
    pub(crate) cycles: Option<u64>,
}

/// `oneiro robot light`
#[derive(Args, Debug)]
pub(crate) struct RobotLight {
    /// The robot.
    #[command(flatten)]
    pub(crate) link: RobotLink,
    /// The lights, such as `led_1`; `oneiro robot ping` lists a robot's lights
    #[arg(value_name = "LIGHT,..", value_delimiter = ',', num_args = 1, required = true)]
    pub(crate) lights: Vec<String>,
    /// What they do
    pub(crate) state: Switch,
}

/// What a light does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Switch {
    /// It shines.
    On,
    /// It does not.
    Off,
}

/// `oneiro robot drive`
#[derive(Args, Debug)]
pub(crate) struct RobotDrive {
    /// The robot, and the guard's values.
    #[command(flatten)]
    pub(crate) guard: Guard,
    /// Initial speed: mm/s, 1 to 1100, or a share of the greatest allowed, 1% to 100%
    #[arg(long, value_name = "SPEED", default_value = "50", value_parser = speed)]
    pub(crate) speed: Speed,
    /// Drive by a file instead of keys. Each of its lines has seconds and the speeds of the left and the right wheel, mm/s
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) commands: Option<PathBuf>,
    /// Print what would be sent, and open nothing
    #[arg(long, conflicts_with = "record")]
    pub(crate) dry_run: bool,
}

/// `oneiro robot sample`
#[derive(Args, Debug)]
pub(crate) struct RobotSample {
    /// Which robot: surrogate:SEED, the described robot of an experiment, FILE.toml, or a robot on a wire, such as
    /// `serial:/dev/ttyUSB0`. `oneiro robot list` has all forms
    #[arg(long, value_name = "ROBOT", default_value = "surrogate:1")]
    pub(crate) robot: String,
    #[arg(
        long,
        value_name = "LAMBDA",
        value_parser = of_key::<f32>("reality.severity"),
        help = format!(
            "How much a surrogate differs from the simulator made from its samples, 0 to 2 [default: {}]",
            SEVERITY
        )
    )]
    pub(crate) severity: Option<f32>,
    /// The objects to sample: wall, round, block, or your own: CLASS:wall, CLASS:round:RADIUS or
    /// CLASS:block:LENGTHxWIDTH, in mm, such as can:round:33
    #[arg(long, value_name = "OBJECT,..", value_delimiter = ',', default_value = "wall,round")]
    pub(crate) objects: Vec<String>,
    /// The device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
    /// Write tables and pictures into this directory. A sampling that was stopped continues there
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: PathBuf,
    /// Options for a robot on a wire.
    #[command(flatten)]
    pub(crate) wired: SampleWired,
}

/// Options of `oneiro robot sample` for robots on a wire.
#[derive(Args, Debug)]
#[command(next_help_heading = "Robots on a wire")]
pub(crate) struct SampleWired {
    /// Wait for nobody: a machine places the robot, or the object
    #[arg(long)]
    pub(crate) yes: bool,
    /// Turns before an object, 1 to 20; a reading is their rounded mean [default: 1]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=20))]
    pub(crate) turns: Option<u32>,
    /// Gap between the robot's rim and the object in the first row, 0 to 10000 mm [default: 5]
    #[arg(long, value_name = "MM", value_parser = number::<f32>(0.0..=10_000.0))]
    pub(crate) nearest: Option<f32>,
    /// Distance from one row to the next, 0.01 to 1000 mm [default: 2]
    #[arg(long, value_name = "MM", value_parser = number::<f32>(0.01..=1000.0))]
    pub(crate) spacing: Option<f32>,
    /// Number of rows, 1 to 1000 [default: 20]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=1000))]
    pub(crate) rows: Option<u32>,
    /// Speed of a wheel in the state 10 of -10 to 10, 1 to 1100 mm/s [default: ten of the robot's own units if they are a
    /// twentieth of its greatest speed, as a Khepera's, else the greatest that the guard allows]
    #[arg(long, value_name = "MM_S", value_parser = number::<f64>(wired::SPEEDS_MM_S[0]..=wired::SPEEDS_MM_S[1]))]
    pub(crate) full_speed: Option<f64>,
    /// Sample no motors
    #[arg(long, conflicts_with = "full_speed")]
    pub(crate) no_motors: bool,
    /// Set a value of the guard, such as `link_ms=400`. May be repeated; docs/robots-on-the-wire.md lists them
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Record all bytes of the link in this file, never overwritten, for a bug report
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) record: Option<PathBuf>,
}

impl SampleWired {
    /// The first option that is given.
    pub(crate) fn given(&self) -> Option<&'static str> {
        let given = [
            (self.yes, "--yes"),
            (self.turns.is_some(), "--turns"),
            (self.nearest.is_some(), "--nearest"),
            (self.spacing.is_some(), "--spacing"),
            (self.rows.is_some(), "--rows"),
            (self.full_speed.is_some(), "--full-speed"),
            (self.no_motors, "--no-motors"),
            (!self.set.is_empty(), "--set"),
            (self.record.is_some(), "--record"),
        ];
        given.into_iter().find_map(|(is_given, name)| is_given.then_some(name))
    }
}

/// `oneiro robot calibrate`
#[derive(Args, Debug)]
pub(crate) struct RobotCalibrate {
    /// The experiment's TOML file
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) experiment: PathBuf,
    /// Directories of lives that `oneiro evaluate --robot`, or a run with `[reality]` on a wire, has written; any number of them
    #[arg(long, value_name = "DIR", required = true, num_args = 1.., value_hint = ValueHint::DirPath)]
    pub(crate) lives: Vec<PathBuf>,
    /// Write a page with figures, the errors as a table, and the settings that follow into this directory, which must be empty or new
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: PathBuf,
    /// Change a value of the experiment, such as noise.sensor=[0.0,0.4]. May be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = setting)]
    pub(crate) set: Vec<String>,
    /// The device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
}

/// `oneiro robot tables`
#[derive(Debug, Subcommand)]
pub(crate) enum RobotTables {
    /// Print a table's key figures, and draw it
    Show {
        /// A .sam or .sample file, or the name of a built-in table
        #[arg(value_hint = ValueHint::FilePath)]
        table: PathBuf,
        /// Draw the table into this file (SVG)
        #[arg(long, value_name = "FILE.svg", value_hint = ValueHint::FilePath)]
        out: Option<PathBuf>,
    },
    /// Convert between .sam (integers) and .sample (shares of 1023)
    Convert {
        /// The table to read
        #[arg(value_hint = ValueHint::FilePath)]
        from: PathBuf,
        /// The file to write, never overwritten. Its extension names the format
        #[arg(value_hint = ValueHint::FilePath)]
        to: PathBuf,
    },
    /// Write a built-in table to a file
    Export {
        /// wall, round or motor
        #[arg(long, value_name = "TABLE")]
        builtin: String,
        /// The file to write, never overwritten. Its extension names the format
        #[arg(value_hint = ValueHint::FilePath)]
        to: PathBuf,
    },
}

/// `oneiro on-board`
#[derive(Args, Debug)]
pub(crate) struct OnBoard {
    /// The daemon's file
    #[arg(value_name = "ROBOT.toml", value_hint = ValueHint::FilePath)]
    pub(crate) file: PathBuf,
    /// Live in the twin that conducts at this socket, instead of on a robot
    #[cfg(unix)]
    #[arg(long, value_name = "PATH", hide = true)]
    pub(crate) conductor: Option<PathBuf>,
}

/// `oneiro guard`
#[derive(Args, Debug)]
pub(crate) struct GuardProcess {
    /// The robot, and the guard's values.
    #[command(flatten)]
    pub(crate) guard: Guard,
    /// Read the odometers too, and report how far the wheels have turned
    #[arg(long)]
    pub(crate) odometry: bool,
}

/// A guarded robot on the command line.
#[derive(Args, Debug)]
pub(crate) struct Guard {
    /// The robot.
    #[command(flatten)]
    pub(crate) link: RobotLink,
    /// Kinds of sensors to read [default: all that the robot has]
    #[arg(long, value_name = "KIND,..", value_delimiter = ',', value_parser = choice::<Kind>())]
    pub(crate) kinds: Vec<Kind>,
    /// Set a value of the guard, such as `expiry_ms=200`. May be repeated; docs/robots-on-the-wire.md lists them
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
}

/// A speed on the command line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Speed {
    /// In mm/s.
    MmPerS(f64),
    /// A share of the greatest, 0 to 1.
    Share(f64),
}

/// `oneiro fleet`
#[derive(Args, Debug)]
pub(crate) struct Fleet {
    /// Subcommand to run.
    #[command(subcommand)]
    pub(crate) command: FleetCommand,
}

/// Commands for fleets.
#[derive(Debug, Subcommand)]
pub(crate) enum FleetCommand {
    /// Make the key that the robots of an experiment and the operator share
    Key {
        /// File to write it to, never overwritten; only its owner can read it
        #[arg(value_hint = ValueHint::FilePath)]
        file: PathBuf,
    },
    /// Check a fleet's file, and print what the other commands would do; nothing is done
    Plan(FleetFile),
    /// Copy the program, the experiment, robot.toml and a swarm's key to the robots' computers, and install the daemon there
    Deploy(FleetWork),
    /// Start the daemons, and let a swarm's robots live as long as this command runs: they stand without its beacon. Robots that live by
    /// themselves need no beacon, and the command ends at once
    Start(FleetStart),
    /// Ask each computer by ssh whether its daemon runs, and what its log says last
    Status(FleetStatus),
    /// Stop the daemons, and say of each robot whether its log confirms that its wheels stand
    Stop(FleetWork),
    /// Copy the robots' records to this machine, and merge the logs of a swarm into one timeline
    Collect(FleetWork),
    /// Let the daemons of all robots live on this machine, with emulated e-pucks in one simulated arena, on a virtual clock
    #[cfg(all(unix, feature = "twin"))]
    Twin(Twin),
    /// Compare records of a fleet or of its twins with batched runs of the experiment: food, simulators, genes
    Compare(FleetCompare),
    /// Write a page that plays what robots said while `start` ran, or what a twin recorded
    Replay {
        /// The fleet's TOML file, or the directory of a twin
        #[arg(value_name = "FLEET.toml|DIR", value_hint = ValueHint::AnyPath)]
        record: PathBuf,
    },
}

/// A fleet's file, and some of its robots.
#[derive(Args, Debug)]
pub(crate) struct FleetFile {
    /// The fleet's TOML file; docs/fleet.md has its keys
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) fleet: PathBuf,
    /// Only the robots of these numbers
    #[arg(long, value_name = "N,..", value_delimiter = ',', value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub(crate) robots: Vec<u32>,
}

/// `oneiro fleet start`
#[derive(Args, Debug)]
pub(crate) struct FleetStart {
    /// The fleet's TOML file
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) fleet: PathBuf,
    /// Begin when N robots are ready [default: all]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=u32::MAX.into()))]
    pub(crate) min: Option<u32>,
    /// How long to wait for them, such as 90s or 5m
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = duration)]
    pub(crate) wait: Duration,
}

/// `oneiro fleet status`
#[derive(Args, Debug)]
pub(crate) struct FleetStatus {
    /// The fleet.
    #[command(flatten)]
    pub(crate) file: FleetFile,
    /// Listen to what robots say for this long instead, such as 3s, without a beacon
    #[arg(long, value_name = "TIME", value_parser = duration, conflicts_with = "robots")]
    pub(crate) listen: Option<Duration>,
}

/// Work on a fleet's robots.
#[derive(Args, Debug)]
pub(crate) struct FleetWork {
    /// The fleet.
    #[command(flatten)]
    pub(crate) file: FleetFile,
    /// End with exit code 0 if it worked for N robots or more [default: all]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=u32::MAX.into()))]
    pub(crate) min: Option<u32>,
}

/// `oneiro fleet twin`
#[cfg(all(unix, feature = "twin"))]
#[derive(Args, Debug)]
pub(crate) struct Twin {
    /// The fleet's TOML file
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) fleet: PathBuf,
    /// A script of faults: packets lost, daemons killed, lines that hang, clocks that drift, full disks
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) faults: Option<PathBuf>,
    /// Another seed than the fleet's
    #[arg(long, value_name = "N", value_parser = seed())]
    pub(crate) seed: Option<u64>,
    /// The twin's directory, which must be empty or new
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: PathBuf,
    /// How many times faster than in reality time passes at most, 0.1 to 10000 [default: as fast as possible]
    #[arg(long, value_name = "X", value_parser = number::<f64>(0.1..=10_000.0))]
    pub(crate) speed: Option<f64>,
    /// What daemons run instead of this program: one for robots, or a script that runs that under an emulator
    #[arg(long, value_name = "FILE", value_hint = ValueHint::ExecutablePath)]
    pub(crate) program: Option<PathBuf>,
}

/// `oneiro fleet compare`
#[derive(Args, Debug)]
pub(crate) struct FleetCompare {
    /// The fleet's TOML file
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) fleet: PathBuf,
    /// Directories of twins, or of fleets after `oneiro fleet collect`, all of this experiment with any seeds [default: the fleet's own]
    #[arg(value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) records: Vec<PathBuf>,
    /// Seeds of the batched runs, both included
    #[arg(long, value_name = "A..B", value_parser = seeds, default_value = "1001..1020")]
    pub(crate) seeds: std::ops::RangeInclusive<u64>,
    /// The device that evaluates them.
    #[command(flatten)]
    pub(crate) backend: Backend,
}

/// `oneiro compare`
#[derive(Args, Debug)]
pub(crate) struct Compare {
    /// Directories of runs, folders that hold runs, and sweeps, each of whose cells is a condition
    #[arg(value_name = "RUNS_OR_SWEEP", required = true, value_hint = ValueHint::DirPath)]
    pub(crate) sources: Vec<PathBuf>,
    /// Write compare.html, its figures and its tables into this directory [default: compare]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    /// New episodes of each champion, the same for all [default: 100]
    #[arg(long, value_name = "K", value_parser = whole::<u32>(1..=1_000_000))]
    pub(crate) trials: Option<u32>,
    /// Seed of the new episodes [default: 1]
    #[arg(long, value_name = "N", value_parser = seed())]
    pub(crate) seed: Option<u64>,
    /// Change a value of all experiments for the new episodes, such as noise.sensor=[0.0,0.4]. May be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = setting)]
    pub(crate) set: Vec<String>,
    /// Compare the champions' recorded scores; simulate nothing
    #[arg(long, conflicts_with_all = ["trials", "seed", "set"])]
    pub(crate) recorded: bool,
    /// The device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
}

/// `oneiro sweep`
#[derive(Args, Debug)]
pub(crate) struct Sweep {
    /// Subcommand to run.
    #[command(subcommand)]
    pub(crate) command: SweepCommand,
}

/// Commands for sweeps.
#[derive(Debug, Subcommand)]
pub(crate) enum SweepCommand {
    /// Check a sweep's file, list its runs, and estimate how long they take on this machine
    Plan(SweepPlan),
    /// Do all runs that are not finished. Repeat the command to continue after any interruption
    Run(SweepRun),
    /// Show the progress of a sweep, also while it runs
    Status {
        /// The sweep's directory
        #[arg(value_hint = ValueHint::DirPath)]
        dir: PathBuf,
    },
    /// Join the results of shards, from any machines, into one table
    Merge {
        /// Directories of one sweep
        #[arg(required = true, value_hint = ValueHint::DirPath)]
        dirs: Vec<PathBuf>,
        /// Write the tables into this directory [default: the first directory]
        #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
        out: Option<PathBuf>,
    },
    /// Write a report: learning curves, heat maps, tables, and tests of which cells differ
    Report {
        /// The sweep's directory. If the sweep is unfinished, the report is of its finished runs, and lists the others
        #[arg(value_hint = ValueHint::DirPath)]
        dir: PathBuf,
        /// The column of results.csv to compare cells by, higher being better [default: `champion_mean`, the mean of the
        /// champion's fresh lives; `peak`, the last parents' mean, if there are cells without finalists; `real` with the
        /// sweep's `[reality]`; `rate` of swarms]
        #[arg(long, value_name = "COLUMN")]
        outcome: Option<String>,
        /// Write report.html and its tables into this directory [default: the sweep's directory]
        #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
        out: Option<PathBuf>,
    },
    /// Repeat one run in a directory of its own, which can be replayed, and compare the results
    Extract {
        /// The sweep's directory
        #[arg(value_hint = ValueHint::DirPath)]
        dir: PathBuf,
        /// The run's number, or the beginning of its id
        run: String,
        /// The run's directory [default: DIR/runs/NAME-SEED-ID]
        #[arg(long, value_name = "RUN_DIR", value_hint = ValueHint::DirPath)]
        out: Option<PathBuf>,
        /// The device that evaluates.
        #[command(flatten)]
        backend: Backend,
    },
}

/// `oneiro sweep plan`
#[derive(Args, Debug)]
pub(crate) struct SweepPlan {
    /// The sweep's TOML file
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) sweep: PathBuf,
    /// List all runs, not only the first ones
    #[arg(long)]
    pub(crate) all: bool,
    /// Skip the timing of devices
    #[arg(long, conflicts_with_all = ["backend", "threads"])]
    pub(crate) no_estimate: bool,
    /// The device that is timed, as `oneiro sweep run` takes it [default: the CPU and each exact GPU, without software drivers]
    #[arg(long, value_name = "BACKEND")]
    pub(crate) backend: Option<String>,
    /// CPU threads, 1 to 1024 [default: one per processor]
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Also say how long cards that are not here would take at least
    #[arg(long)]
    pub(crate) cards: bool,
}

/// `oneiro sweep run`
#[derive(Args, Debug)]
pub(crate) struct SweepRun {
    /// The sweep's TOML file
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) sweep: PathBuf,
    /// The sweep's directory [default: sweeps/NAME, by the sweep's name]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    /// Do every N-th run, beginning with the I-th. Any number of shards may run at once [default: in a Slurm array the
    /// task's shard, else all runs]
    #[arg(long, value_name = "I/N")]
    pub(crate) shard: Option<Shard>,
    /// Save a checkpoint and stop with exit code 75 after this time, such as 90s, 30m, 2h or 1h30m
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub(crate) time_budget: Option<Duration>,
    /// Time between checkpoints: the most work that a power cut can cost
    #[arg(long, value_name = "TIME", default_value = "10s", value_parser = duration)]
    pub(crate) checkpoint_every: Duration,
    /// Most runs at a time [default: as many as keep the device busy]
    #[arg(long, value_name = "K", value_parser = whole::<u32>(1..=1_000_000))]
    pub(crate) jobs: Option<u32>,
    /// Allow more than 10,000 runs
    #[arg(long)]
    pub(crate) yes: bool,
    /// The device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
    /// Print a Slurm job array that runs the sweep, and run nothing
    #[arg(long)]
    pub(crate) print_slurm: bool,
    /// With --print-slurm: number of tasks of the array, at most one for each run [default: 8]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=100_000))]
    pub(crate) shards: Option<u32>,
}

/// Parses a time such as `90s`, `1.5s`, `30m`, `2h` or `1h30m`.
fn duration(text: &str) -> Result<Duration, String> {
    let allowed = "allowed: a time above 0 and up to 1000h, such as 90s, 30m, 2h or 1h30m";
    let mut seconds = 0.0;
    let mut number = String::new();
    for c in text.chars() {
        let unit = match c {
            '0'..='9' | '.' => {
                number.push(c);
                continue;
            }
            'h' => 3600.0,
            'm' => 60.0,
            's' => 1.0,
            _ => return Err(allowed.into()),
        };
        seconds += unit * number.parse::<f64>().map_err(|_| allowed)?;
        number.clear();
    }
    if number.is_empty() && seconds > 0.0 && seconds <= 3.6e6 {
        Ok(Duration::from_secs_f64(seconds))
    } else {
        Err(allowed.into())
    }
}

/// `oneiro completions`
#[derive(Args, Debug)]
pub(crate) struct Completions {
    /// The shell
    pub(crate) shell: clap_complete::Shell,
}

/// Parses `A..B`, both included.
fn seeds(text: &str) -> Result<std::ops::RangeInclusive<u64>, String> {
    let number = |text: &str| {
        let seed = text.trim().parse().ok();
        seed.filter(|seed: &u64| experiment::allows(SEED, seed).0)
    };
    let ends = text
        .split_once("..")
        .and_then(|(first, last)| Some((number(first)?, number(last)?)));
    let range = ends.filter(|(first, last)| first <= last && last - first < 1_000_000);
    range.map(|(first, last)| first..=last).ok_or_else(|| {
        let (_, seed) = experiment::allows(SEED, &0_u64);
        format!("allowed: A..B with A <= B, at most 1000000 seeds, such as 1..20; each is {seed}")
    })
}

/// Parses `X,Y,HEADING`.
fn pose(text: &str) -> Result<[f32; 3], String> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    let pose = numbers.and_then(|numbers| <[f32; 3]>::try_from(numbers).ok());
    pose.ok_or_else(|| "allowed: x and y in mm and a heading in turns, such as 100,90,0.125".to_owned())
}

/// Parses a speed in mm/s, 1 to 1100, or as a share of the greatest, 1 % to 100 %.
fn speed(text: &str) -> Result<Speed, String> {
    let (number, is_share) = match text.strip_suffix('%') {
        Some(number) => (number, true),
        None => (text, false),
    };
    match number.trim_end().parse::<f64>() {
        Ok(share) if is_share && (1.0..=100.0).contains(&share) => Ok(Speed::Share(share / 100.0)),
        Ok(speed) if !is_share && (1.0..=1100.0).contains(&speed) => Ok(Speed::MmPerS(speed)),
        _ => Err("allowed: 1 to 1100 mm/s, such as 50, or 1% to 100% of the greatest, such as 25%".to_owned()),
    }
}

/// Checks that a setting has a key and a value.
fn setting(text: &str) -> Result<String, String> {
    match text.split_once('=') {
        Some(_) => Ok(text.to_owned()),
        None => Err("allowed: KEY=VALUE, such as noise.motor=0.1".to_owned()),
    }
}

/// Parses two names.
fn pair(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((own, robots)) if !own.is_empty() && !robots.is_empty() => Ok((own.into(), robots.into())),
        _ => Err("allowed: the experiment's name, =, and the robot's, such as left_90=prox_5".to_owned()),
    }
}

/// Parses a number above 0 and up to 1.
fn fraction(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(fraction) if fraction > 0.0 && fraction <= 1.0 => Ok(fraction),
        _ => Err("allowed: a number above 0 and up to 1, such as 0.01".to_owned()),
    }
}

#[cfg(test)]
mod documented;

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use oneiro_studies::file::{MIGLINO1995, ODOWD2014, StudyFile};

    #[test]
    fn command_line_is_consistent() {
        command().debug_assert();
    }

    /// A new option of `oneiro evaluate` has an effect with `--best` and `--tournament`, or is refused there.
    #[test]
    fn options_of_evaluations_are_refused_where_they_have_no_effect() {
        const OTHERS: &str = "experiment genomes seed trials set out best individuals all tournament every backend threads recheck \
                            specialise json quiet help version";
        let mut program = command();
        program.build();
        let evaluate = program.find_subcommand("evaluate").unwrap();
        let ids = evaluate.get_arguments().map(|argument| argument.get_id().as_str());
        let effects: BTreeSet<&str> = ids.filter(|id| !USUAL.contains(id)).collect();
        assert_eq!(effects, OTHERS.split_whitespace().collect());
    }

    #[test]
    fn seeds_are_ranges() {
        assert_eq!(seeds("3..7"), Ok(3..=7));
        assert_eq!(seeds("5..5"), Ok(5..=5));
        for wrong in ["", "3", "7..3", "a..b", "-1..2", "0..1000000", "1..2..3"] {
            assert!(seeds(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn poses_have_three_numbers() {
        assert_eq!(pose("100, -90.5,0.125"), Ok([100.0, -90.5, 0.125]));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,x", "1;2;3"] {
            assert!(pose(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn fractions_are_above_nothing() {
        assert_eq!(fraction("1"), Ok(1.0));
        for wrong in ["0", "-0.1", "1.1", "nan", "x"] {
            assert!(fraction(wrong).is_err(), "{wrong}");
        }
    }

    /// `--help` has one line for each arm, with its assumption.
    #[test]
    fn help_lists_every_arm() {
        let mut command = Cli::command();
        command.build();
        let reproduce = command.find_subcommand_mut("reproduce").unwrap();
        let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        for (name, shipped) in [("miglino1995", &MIGLINO1995), ("odowd2014", &ODOWD2014)] {
            let study = reproduce.find_subcommand_mut(name).unwrap();
            let help = words(&study.render_long_help().to_string());
            for arm in StudyFile::open(shipped, None)
                .unwrap()
                .groups()
                .unwrap()
                .into_iter()
                .flat_map(|group| group.arms)
            {
                let line = words(&format!("- {}: {}", arm.name, arm.words));
                assert!(help.contains(&line), "{line}");
            }
        }
    }
}
