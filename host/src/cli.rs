//! The command line: its commands, arguments and help texts. `commands` runs them.

mod choices;
mod device;
mod groups;
pub(crate) mod man;
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
use oneiro_base::program;
use oneiro_lab::OF_WORLD;
use oneiro_lab::experiment::{self, SEED, reference, robots};
use oneiro_lab::import;
use oneiro_lab::reality::site::SEVERITY;
use oneiro_lab::reality::wired::{self, Starts};
use oneiro_lab::sweep::store::Shard;
use oneiro_robots::{Kind, tracker};

use self::choices::choice;
pub(crate) use self::device::Backend;
use self::numbers::{number, of_key, out_of_range, seed, whole};
pub(crate) use self::reproduce::{ALL_ARMS, Miglino1995, Odowd2014, Paper, Reproduce};

/// The first line of the program's help.
const ABOUT: &str = "Evolve robot controllers in simulation; the same seed gives the same bits on every device.";

/// The last line of the program's help.
const FIRST: &str = "First: `oneiro new NAME`, then `oneiro run NAME.toml --seed 1`. Each command has --help.";

/// The program's name.
const PROGRAM: &str = "oneiro";

/// The command line.
#[derive(Debug, Parser)]
#[command(about = ABOUT, name = PROGRAM, version, propagate_version = true, after_help = FIRST)]
pub(crate) struct Cli {
    /// Print data as JSON
    #[arg(long, global = true, display_order = 900)]
    json: bool,
    /// Show errors only; no progress bar
    #[arg(long, short, global = true, display_order = 901)]
    quiet: bool,
    /// Show whole hashes instead of 12 digits
    #[arg(long, short, global = true, display_order = 902)]
    verbose: bool,
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

/// Options of [`Backend`].
const DEVICE: [&str; 4] = ["backend", "threads", "recheck", "specialise"];

/// The whole command line.
pub(crate) fn command() -> clap::Command {
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
    wrapped(numbers::with_hyphens(groups::grouped(program)))
}

/// A command whose help is in lines that fit a terminal of 100 columns, with the device's options under a heading.
fn wrapped(command: clap::Command) -> clap::Command {
    /// Columns of a terminal.
    const WIDTH: usize = 100;
    /// Columns for a tab, a short option and a gap, in addition to an option's name.
    const BESIDE: usize = 8;
    let has_device = command.get_arguments().any(|argument| argument.get_id() == "recheck");
    let command = command.mut_args(|argument| {
        let is_of_device = has_device && DEVICE.contains(&argument.get_id().as_str());
        if is_of_device {
            argument.help_heading("Device")
        } else {
            argument
        }
    });
    // Clap formats arguments only when the command is built.
    let width = |argument: &clap::Arg| {
        let name = argument.get_long().map_or(0, |long| "--".len() + long.len());
        let names = argument.get_value_names().unwrap_or_default().iter();
        let names = names.filter(|_| argument.get_action().takes_values());
        let values: usize = names.map(|name| " <>".len() + name.len()).sum();
        let range = argument.get_num_args().unwrap_or_default();
        let more =
            if range.max_values() > 1 { "...".len() } else { 0 } + if range.min_values() == 0 { "[]".len() } else { 0 };
        name + values + more + BESIDE
    };
    let mut taken: Vec<(Option<String>, usize)> = Vec::new();
    let group = |argument: &clap::Arg| {
        let positional = argument.is_positional().then(|| "Arguments".to_owned());
        positional.or_else(|| argument.get_help_heading().map(str::to_owned))
    };
    for argument in command.get_arguments().filter(|argument| !argument.is_hide_set()) {
        let (group, width) = (group(argument), width(argument));
        match taken.iter_mut().find(|(known, _)| *known == group) {
            Some((_, widest)) => *widest = width.max(*widest),
            None => taken.push((group, width)),
        }
    }
    let command = command.mut_args(|argument| {
        let Some(help) = argument.get_help().map(ToString::to_string) else {
            return argument;
        };
        let beside = taken.iter().find(|(known, _)| *known == group(&argument));
        let text = help + &values(&argument);
        let lines = filled(&text, WIDTH - beside.map_or(0, |(_, widest)| *widest));
        let takes_values = argument.get_action().takes_values();
        argument
            .help(lines)
            .hide_default_value(takes_values)
            .hide_possible_values(takes_values)
    });
    command.mut_subcommands(wrapped)
}

/// The default and the allowed words of an option, as its help has them.
fn values(argument: &clap::Arg) -> String {
    let defaults = argument
        .get_default_values()
        .iter()
        .map(|value| value.to_string_lossy());
    let defaults: Vec<_> = defaults.filter(|_| argument.get_action().takes_values()).collect();
    let words = argument.get_possible_values();
    let words: Vec<&str> = words.iter().map(clap::builder::PossibleValue::get_name).collect();
    let is_listed = argument.get_action().takes_values() && !argument.is_hide_possible_values_set();
    let mut text = String::new();
    if !defaults.is_empty() {
        text.extend([" [default: ", &defaults.join(","), "]"]);
    }
    if is_listed && !words.is_empty() {
        text.extend([" [possible values: ", &words.join(", "), "]"]);
    }
    text
}

/// A text in lines of a width.
fn filled(text: &str, width: usize) -> String {
    let mut lines = String::new();
    let mut column = 0;
    for word in text.split(' ') {
        let is_first = lines.is_empty();
        let is_over = !is_first && column + 1 + word.len() > width;
        lines.push_str(if is_over {
            "\n"
        } else if is_first {
            ""
        } else {
            " "
        });
        lines.push_str(word);
        column = word.len() + if is_over || is_first { 0 } else { column + 1 };
    }
    lines
}

impl Cli {
    /// Parses the command line. The command is a refusal if an option names a file where a directory belongs, or has a number
    /// out of the range of a key.
    ///
    /// # Errors
    /// Help, and mistakes of usage.
    pub(crate) fn typed() -> Result<(Output, exit::Result<Command>), clap::Error> {
        let mut command = command();
        let typed = command.try_get_matches_from_mut(program::words());
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
            verbose: cli.verbose,
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
const OTHER_WORDS: [(&str, &str); 21] = [
    ("device", "--backend NAME"),
    ("gpu", "--backend gpu"),
    ("cuda", "--backend gpu"),
    ("cpu", "--backend cpu"),
    ("output", "--out PATH"),
    ("runs", "--seeds 1..N"),
    ("workers", "--threads N"),
    ("share", "--fraction F"),
    ("lives", "--episodes N"),
    ("lives", "--log DIR"),
    ("set", "--guard KEY=VALUE"),
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
    let words: Vec<String> = program::words()
        .iter()
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
    /// Write an experiment to start from, or list all keys
    New(New),
    /// Make an experiment from a file of another simulator or from a map
    Import(Import),
    /// Check an experiment, summarise it and draw its arena
    Check(Check),
    /// Evolve controllers from one seed or from many
    Run(Run),
    /// Make a run of genomes from elsewhere
    Adopt(Adopt),
    /// Finish a run that was stopped, or extend a run
    Resume(Resume),
    /// Run many evolutions as one job: a grid of values, many seeds each
    Sweep(Sweep),
    /// Repeat a paper's study and judge its claims
    Reproduce(Reproduce),
    /// List runs and their state
    List(List),
    /// Watch runs, sweeps and fleets in a browser while they evolve
    Watch(Watch),
    /// Replay a run's champion: its path, its trace, a page
    Replay(Replay),
    /// Evaluate genomes, find the best, or play a tournament
    Evaluate(Evaluate),
    /// Write a controller in C or another language
    Export(Export),
    /// Compare experiments: scores, tests and figures in one report
    Compare(Compare),
    /// Check a run's files; recompute its results and compare the bits
    Verify(Verify),
    /// Find, watch, drive and stop a robot; sample and calibrate it
    Robot(Robot),
    /// Install, start, watch and stop robots with on-board computers
    Fleet(Fleet),
    /// List this machine's devices; test their bits and their speed
    Device(Device),
    /// Print a completion script for a shell
    Completions(Completions),
    /// Write a man page for each command into a directory
    Man(Man),
    /// Run on a robot's computer: control it while evolving in its simulator
    #[command(hide = true)]
    OnBoard(OnBoard),
    /// Drive a robot for another program, and stop its wheels if that dies, hangs or is late
    #[command(hide = true)]
    Guard(GuardProcess),
}

/// `oneiro new`
#[derive(Args, Debug)]
pub(crate) struct New {
    /// The experiment's name: writes NAME.toml and never overwrites a file
    #[arg(required_unless_present_any = ["example", "keys"])]
    pub(crate) name: Option<String>,
    /// A swarm of ten e-pucks with a mission, NAME.wgsl, for you to edit
    #[arg(long, conflicts_with = "forager")]
    pub(crate) swarm: bool,
    /// An e-puck that brings food to its nest
    #[arg(long)]
    pub(crate) forager: bool,
    #[arg(
        long,
        value_name = "NAME",
        conflicts_with = "forager",
        help = format!("A parametric robot: {}", robots::names())
    )]
    pub(crate) robot: Option<String>,
    /// Also write NAME.wgsl, a custom sensor file for you to edit
    #[arg(long, value_name = "NAME")]
    pub(crate) sensor: Option<String>,
    /// Also write NAME.wgsl, a custom controller
    #[arg(long, value_name = "NAME")]
    pub(crate) controller: Option<String>,
    /// Also write NAME.wgsl, a custom task (with --swarm: its mission), or a copy of the task with this name: reach, visit, collect, cover, follow-line, follow-wall, stay-together, phototaxis, gather-pucks or bring-pucks
    #[arg(long, value_name = "NAME")]
    pub(crate) task: Option<String>,
    /// Write all keys, each with its meaning and allowed values
    #[arg(long)]
    pub(crate) all_keys: bool,
    /// Write an experiment that ships with Oneiro, and its parts; without NAME, list them
    #[arg(
        long,
        value_name = "NAME",
        num_args = 0..=1,
        default_missing_value = "",
        conflicts_with_all = ["name", "swarm", "forager", "robot", "sensor", "controller", "task", "all_keys"]
    )]
    pub(crate) example: Option<String>,
    /// Folder to write into [default: the current folder]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    /// List all keys, or those that contain PART, such as noise: default, allowed values, meaning
    #[arg(
        long,
        value_name = "PART",
        num_args = 0..=1,
        default_missing_value = "",
        conflicts_with_all = ["name", "swarm", "forager", "robot", "sensor", "controller", "task", "all_keys", "example", "out"]
    )]
    pub(crate) keys: Option<String>,
}

/// `oneiro import`
#[derive(Args, Debug)]
pub(crate) struct Import {
    /// ARGoS (.argos, .xml), an Aseba playground (.playground), mazes of Kheperax (.py), a maze as text (.txt), evorobotpy (.ini), a map
    /// of ROS (.yaml, .yml) or as picture (.png, .pgm)
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) file: PathBuf,
    /// The experiment to write; a file that exists is never overwritten [default: FILE's name with .toml, in the current folder]
    #[arg(long, value_name = "EXPERIMENT.toml", value_hint = ValueHint::FilePath)]
    pub(crate) out: Option<PathBuf>,
    /// Which maze of a file with several
    #[arg(long, value_name = "NAME")]
    pub(crate) maze: Option<String>,
    /// Side of a pixel of a map that is a picture, 0.01 to 10000 mm
    #[arg(long, value_name = "MM", value_parser = number::<f64>(import::PIXELS_MM[0]..=import::PIXELS_MM[1]))]
    pub(crate) mm_per_pixel: Option<f64>,
    /// How far a map's walls may be from where they are in the picture, 0 to 10000 mm [default: the side of a pixel]
    #[arg(long, value_name = "MM", value_parser = number::<f64>(import::TOLERANCES_MM[0]..=import::TOLERANCES_MM[1]))]
    pub(crate) tolerance: Option<f64>,
    /// The grey from which on pixels of a map that is a picture are free, from 0 (black) to 1 (white) [default: 0.5]
    #[arg(long, value_name = "GREY", value_parser = number::<f64>(0.0..=1.0))]
    pub(crate) threshold: Option<f64>,
}

/// Instead of a rule's name, lists all of them.
pub(crate) const ALL_RULES: &str = "list";

/// `oneiro check`
#[derive(Args, Debug)]
pub(crate) struct Check {
    /// The experiment's TOML file
    #[arg(value_hint = ValueHint::FilePath, required_unless_present = "explain")]
    pub(crate) experiment: Option<PathBuf>,
    /// Explain a rule for custom parts (the name at the end of each error); without a name, list all
    #[arg(long, value_name = "RULE", num_args = 0..=1, default_missing_value = ALL_RULES)]
    #[arg(conflicts_with_all = ["experiment", "set", "out"])]
    pub(crate) explain: Option<String>,
    /// Change a value, such as noise.sensor=[0.0,0.4]; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = setting)]
    pub(crate) set: Vec<String>,
    /// Draw the arena into this file (SVG)
    #[arg(long, value_name = "FILE.svg", value_hint = ValueHint::FilePath)]
    pub(crate) out: Option<PathBuf>,
    /// Simulate N episodes of random genomes, and check that all numbers are finite and normal
    #[arg(long, value_name = "N", default_value_t = 0, conflicts_with = "explain", value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub(crate) episodes: u32,
    /// Count a cycle's operations on a GPU, and the maximum steps per second of known cards
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
    /// One run for each seed from A to B, both included
    #[arg(long, value_name = "A..B", value_parser = seeds)]
    pub(crate) seeds: Option<std::ops::RangeInclusive<u64>>,
    /// The device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
    /// Change a value, such as noise.sensor=[0.0,0.4]; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = setting)]
    pub(crate) set: Vec<String>,
    /// The run's directory, with --seeds the directory of all runs [default: runs/NAME-SEED, or -b, -c.. after it if
    /// another run has that name]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    /// Its page.
    #[command(flatten)]
    pub(crate) beside: Beside,
}

/// `oneiro adopt`
#[derive(Args, Debug)]
pub(crate) struct Adopt {
    /// The experiment's TOML file; its optimiser is not used
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) experiment: PathBuf,
    /// .npy (f4 or f8, rows x genes), .csv (a genome per row), .json or .txt of machines and trees, or a run's directory (its champion)
    #[arg(long, value_name = "FILE|DIR", value_hint = ValueHint::AnyPath)]
    pub(crate) genomes: PathBuf,
    /// Episodes of each genome, 2 to 10000; the best mean is the champion [default: 100]
    #[arg(long, value_name = "K", value_parser = whole::<u32>(2..=10_000))]
    pub(crate) trials: Option<u32>,
    /// Seed of starts and noise [default: the experiment's, else a random one]
    #[arg(long, value_name = "N", value_parser = seed())]
    pub(crate) seed: Option<u64>,
    /// The device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
    /// Change a value, such as noise.sensor=[0.0,0.4]; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = setting)]
    pub(crate) set: Vec<String>,
    /// The run's directory [default: runs/NAME-SEED, or -b, -c.. after it if another run has that name]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
}

impl Adopt {
    /// Episodes of each genome without `--trials`.
    pub(crate) const EPISODES: u32 = 100;
}

/// `oneiro resume`
#[derive(Args, Debug)]
pub(crate) struct Resume {
    /// The run: its directory, its name in runs/ or the beginning of that; or a directory of runs [default: the newest run]
    #[arg(value_hint = ValueHint::DirPath)]
    pub(crate) run_dir: Option<PathBuf>,
    /// Extend the run, finished or not, to N generations in all
    #[arg(long, value_name = "N", conflicts_with = "episodes", value_parser = whole::<u32>(1..=1_000_000))]
    pub(crate) generations: Option<u32>,
    /// Extend the run, finished or not, to the generations that N episodes make
    #[arg(long, value_name = "N", value_parser = whole::<u64>(1..=1_000_000_000_000))]
    pub(crate) episodes: Option<u64>,
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
    /// The experiment's TOML file, before --genomes [default: that of the runs in --genomes]
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) experiment: Option<PathBuf>,
    /// .npy (f4 or f8, rows x genes), .csv (a genome per row), champion.json, directories of runs or sweeps (their champions)
    #[arg(long, value_name = "FILE|DIR", required_unless_present = "random", num_args = 1.., value_hint = ValueHint::AnyPath)]
    pub(crate) genomes: Vec<PathBuf>,
    /// Add N random genomes, drawn by --seed from the initial range
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=100_000))]
    pub(crate) random: Option<u32>,
    /// Take the last generations of runs instead of the champions
    #[arg(long)]
    pub(crate) population: bool,
    /// Seed of starts and noise; use one that the run did not use [default: the experiment's; 1 for runs]
    #[arg(long, value_name = "N", value_parser = seed())]
    pub(crate) seed: Option<u64>,
    /// Episodes of each genome [default: the experiment's; with --best 100], or of each pair in a tournament [default: 10; at most
    /// 10000]
    #[arg(long, value_name = "K", value_parser = whole::<u32>(1..=1_000_000))]
    pub(crate) trials: Option<u32>,
    /// Give all genomes the same starts and the same noise
    #[arg(long)]
    pub(crate) common_starts: bool,
    /// Start episodes at a file's poses (`x_mm`, `y_mm`, `heading_turns`)
    #[arg(long, value_name = "FILE.csv", value_hint = ValueHint::FilePath, conflicts_with = "trials")]
    pub(crate) starts: Option<PathBuf>,
    /// The experiment's noise, or none (custom parts, foragers' proximity, messages keep it)
    #[arg(long, value_name = "on|off", value_enum, default_value_t = Noise::On)]
    pub(crate) noise: Noise,
    /// Evaluate with the values of the experiment's table [test]
    #[arg(long)]
    pub(crate) test: bool,
    /// Change a value, such as noise.sensor=[0.0,0.4]; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = setting)]
    pub(crate) set: Vec<String>,
    /// File for the results (.csv, .npy) or - for standard output; with --best: for the best genome (.json)
    #[arg(long, value_name = "FILE", default_value = "-", value_hint = ValueHint::FilePath)]
    pub(crate) out: PathBuf,
    /// Write a trace of each episode into this directory (new or empty)
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) traces: Option<PathBuf>,
    /// Rows and columns of the results.
    #[command(flatten)]
    pub(crate) rows: Rows,
    /// The device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
    /// Episodes on a robot instead.
    #[command(flatten)]
    pub(crate) on_robot: OnRobot,
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
    "log",
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
    /// Re-evaluate champions, luckiest individuals and last generations on the same new episodes, and report the best. Another --seed
    /// gives its unbiased mean
    #[arg(long, conflicts_with_all = USUAL)]
    pub(crate) best: bool,
    /// Take all individuals of the runs instead of the last generations
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
    /// Play the bests of two populations against each other (coevolution only); writes tournament.csv and pictures into the run
    #[arg(long, conflicts_with_all = USUAL, conflicts_with_all = ["experiment", "test", "set", "out", "best"])]
    pub(crate) tournament: bool,
    /// Take every Nth generation only
    #[arg(long, value_name = "N", default_value_t = 1, requires = "tournament", value_parser = whole::<u32>(1..=u32::MAX.into()))]
    pub(crate) every: u32,
}

/// Rows and columns of results, of `oneiro evaluate`.
#[derive(Args, Debug)]
#[command(next_help_heading = "Output")]
pub(crate) struct Rows {
    /// One row per genome: mean fitness, standard deviation, 95 % confidence interval
    #[arg(long)]
    pub(crate) summary: bool,
    /// Add measures of behaviour, such as the distance driven (docs/measures.md)
    #[arg(long)]
    pub(crate) measures: bool,
}

/// Episodes on a robot, of `oneiro evaluate`.
#[derive(Args, Debug)]
#[command(next_help_heading = "On a robot")]
pub(crate) struct OnRobot {
    /// Evaluate on this robot (`oneiro robot list`) or surrogate, such as `surrogate:1`; repeatable: robots divide the episodes
    #[arg(long = "robot", value_name = "ADDRESS", conflicts_with_all = ["starts", "noise", "measures", "traces"])]
    pub(crate) robots: Vec<String>,
    /// Log episodes in this directory; completed episodes are not repeated
    #[arg(long, value_name = "DIR", requires = "robots", value_hint = ValueHint::DirPath)]
    pub(crate) log: Option<PathBuf>,
    /// Start: walk (random drive) or hand (you place it)
    #[arg(long, value_name = "HOW", value_parser = choice::<Starts>(), hide_possible_values = true, default_value = Starts::default().word(), requires = "log")]
    pub(crate) between: Starts,
    /// Time of that random drive, 0 to 600 s; 0: no drive
    #[arg(long, value_name = "SECONDS", default_value_t = wired::WALK_S, requires = "log", value_parser = number::<f64>(0.0..=wired::LONGEST_WALK_S))]
    pub(crate) walk: f64,
    /// Wheel speed at maximum output, mm/s [default: the experiment's, or 80]
    #[arg(long, value_name = "MM_S", requires = "log", value_parser = number::<f64>(wired::SPEEDS_MM_S[0]..=wired::SPEEDS_MM_S[1]))]
    pub(crate) speed: Option<f64>,
    /// A sensor's name on the robot, such as `left_90=prox_5`; repeatable
    #[arg(long = "sensor", value_name = "NAME=NAME", requires = "log", value_parser = pair)]
    pub(crate) sensors: Vec<(String, String)>,
    /// Tracker of the robot's pose, such as `udp:0.0.0.0:5005#1` for its robot 1; repeatable, in the robots' order [default:
    /// odometry]
    #[arg(long = "tracker", value_name = "ADDRESS", requires = "log")]
    pub(crate) trackers: Vec<String>,
    /// Maximum age of a pose, 50 to 2000 ms, or the robot stops
    #[arg(long, value_name = "MS", default_value_t = tracker::AGE_MS, requires = "trackers",
        value_parser = whole::<u64>(tracker::AGES_MS))]
    pub(crate) tracker_age: u64,
    /// Set a value of the guard, such as `expiry_ms=200`; repeatable
    #[arg(long, value_name = "KEY=VALUE", requires = "log")]
    pub(crate) guard: Vec<String>,
    #[arg(
        long,
        value_name = "LAMBDA",
        requires = "robots",
        conflicts_with = "log",
        value_parser = of_key::<f32>("reality.severity"),
        help = format!(
            "How much a surrogate differs from its simulator, 0 to 2 [default: {}]",
            SEVERITY
        )
    )]
    pub(crate) severity: Option<f32>,
}

/// Whether episodes have their experiment's noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Noise {
    // The help lists the words without meanings.
    On,
    Off,
}

/// `oneiro replay`
#[derive(Args, Debug)]
pub(crate) struct Replay {
    /// The run: its directory, its name in runs/ or the beginning of that [default: the newest run]
    #[arg(value_hint = ValueHint::DirPath)]
    pub(crate) run_dir: Option<PathBuf>,
    /// The device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
    /// Directory for replay.html, replay.svg and replay.csv; for a swarm also replay-robots.csv [default: the run's directory]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    /// Which of the champion's trials, from 0
    #[arg(long, value_name = "K", default_value_t = 0, value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub(crate) trial: u32,
    /// Start at another pose: x and y in mm, heading in turns, such as 100,90,0.125
    #[arg(long, value_name = "X,Y,HEADING", value_parser = pose, allow_hyphen_values = true)]
    pub(crate) start: Option<[f32; 3]>,
    /// Other starts and noise: those of `oneiro evaluate --seed N`
    #[arg(long, value_name = "N", value_parser = seed())]
    pub(crate) seed: Option<u64>,
    /// An episode with the values of the experiment's table [test]
    #[arg(long, conflicts_with_all = ["elites", "generations", "robot"])]
    pub(crate) test: bool,
    /// Replay the best of this generation instead, from 0
    #[arg(long, value_name = "N", conflicts_with_all = ["elite", "elites", "genome"], value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub(crate) generation: Option<u32>,
    /// Replay this individual of the generation, from 0
    #[arg(long, value_name = "K", requires = "generation", value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub(crate) individual: Option<u32>,
    /// See a robot or a swarm learn: the bests of these generations from the same start on one page, learning.html, such as 0,3,10,199
    #[arg(long, value_name = "N,..", value_delimiter = ',', conflicts_with_all = ["elite", "elites", "genome", "generation", "start"],
        value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub(crate) generations: Vec<u32>,
    /// Also replay it on this surrogate, such as surrogate:1, and show both robots on one page, replay-surrogate-1.html
    #[arg(long, value_name = "ROBOT", conflicts_with_all = ["elites", "generations"])]
    pub(crate) robot: Option<String>,
    #[arg(
        long,
        value_name = "LAMBDA",
        requires = "robot",
        value_parser = of_key::<f32>("reality.severity"),
        help = format!(
            "How much the surrogate differs from its simulator, 0 to 2 [default: as in the run if this is its surrogate, else {}]",
            SEVERITY
        )
    )]
    pub(crate) severity: Option<f32>,
    /// Replay the elite of this archive cell instead (archive.csv lists them)
    #[arg(long, value_name = "CELL", conflicts_with = "genome", value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub(crate) elite: Option<u32>,
    /// Replay all elites, compare them with the record, and write a page, archive.html
    #[arg(long, conflicts_with_all = ["elite", "genome", "start", "seed"])]
    pub(crate) elites: bool,
    /// Replay this genome instead, such as one from `oneiro evaluate --best --out`; --seed is then 1 by default
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) genome: Option<PathBuf>,
    /// Record every Nth cycle
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u32>(1..=u32::MAX.into()))]
    pub(crate) every: u32,
    /// Also draw a moment of the episode to this file, an SVG or a PNG
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with = "elites")]
    pub(crate) picture: Option<PathBuf>,
    /// The moment, 0 to 1000000 s from the start [default: the end]
    #[arg(long, value_name = "SECONDS", requires = "picture", value_parser = number::<f64>(0.0..=1e6))]
    pub(crate) at: Option<f64>,
    /// Also film the episode to this file, a GIF
    #[arg(long, value_name = "FILE.gif", value_hint = ValueHint::FilePath, conflicts_with = "elites")]
    pub(crate) film: Option<PathBuf>,
    /// How many times as fast as in reality the film is, 0.1 to 10000 [default: so that it takes 20 s]
    #[arg(long, value_name = "X", requires = "film", value_parser = number::<f64>(0.1..=10_000.0))]
    pub(crate) speed: Option<f64>,
}

/// `oneiro export`
#[derive(Args, Debug)]
pub(crate) struct Export {
    /// The run whose champion it is: its directory, its name in runs/ or the beginning of that, or its champion.json; or with --genome
    /// an experiment's TOML file [default: the newest run]
    #[arg(value_hint = ValueHint::AnyPath)]
    pub(crate) champion: Option<PathBuf>,
    /// What to write: c (a C99 file), cpp (a C++ header), arduino (a library, a folder), rust, javascript, python, lua, argos (a script for
    /// its e-puck), webots (a controller in C), ros2 (a package, a folder), aseba (for a
    /// Thymio II), or onnx (a network)
    #[arg(long, value_name = "TARGET")]
    pub(crate) to: Option<String>,
    /// The file or folder to write; files that exist are never overwritten [default: the experiment's name, in the current folder]
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) out: Option<PathBuf>,
    /// What the names in the file begin with: letters, digits and _ [default: the experiment's name]
    #[arg(long, value_name = "NAME")]
    pub(crate) name: Option<String>,
    /// Also print its world, for c: the sensors (what they read at a pose), the task (how a cycle moves the robot, and what the task gives),
    /// of a swarm both
    #[arg(long, value_name = "WHAT,..", value_delimiter = ',', value_parser = OF_WORLD)]
    pub(crate) with: Vec<String>,
    /// Export this genome instead, such as one from `oneiro evaluate --best --out`
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) genome: Option<PathBuf>,
    /// Change a value, such as robot.count=5; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = setting)]
    pub(crate) set: Vec<String>,
    /// The number of the robot in a swarm, from 0: with several genomes, robots differ
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub(crate) number: u32,
    /// The interval at whose end the controller acted, from 0, in a run of the foraging study [default: the last]
    #[arg(long, value_name = "I", value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub(crate) interval: Option<u32>,
    /// Cycles that the file checks itself by, 1 to 1000
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = whole::<u32>(1..=1000))]
    pub(crate) checks: u32,
    /// Seed of the episode that these cycles are from [default: that of the run or the experiment, or 1]
    #[arg(long, value_name = "N", value_parser = seed())]
    pub(crate) seed: Option<u64>,
    /// Its trial, from 0
    #[arg(long, value_name = "K", default_value_t = 0, value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub(crate) trial: u32,
}

/// `oneiro verify`
#[derive(Args, Debug)]
pub(crate) struct Verify {
    /// The directory of a run, of several runs or of a sweep, its name in runs/ or sweeps/, or the beginning of that
    /// [default: the newest run]
    #[arg(value_hint = ValueHint::DirPath)]
    pub(crate) run_dir: Option<PathBuf>,
    /// Also re-evaluate a fraction of each run's individuals, and compare the bits; of the foraging study, everything
    #[arg(long)]
    pub(crate) recompute: bool,
    /// Fraction of the individuals to re-evaluate, above 0 and up to 1
    #[arg(long, value_name = "FRACTION", default_value_t = 0.01, requires = "recompute", value_parser = fraction)]
    pub(crate) fraction: f64,
    /// The device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
}

/// `oneiro list`
#[derive(Args, Debug)]
pub(crate) struct List {
    /// A directory of runs; the newest run comes first [default: runs]
    #[arg(value_hint = ValueHint::DirPath)]
    pub(crate) dir: Option<PathBuf>,
}

/// `oneiro watch`
#[derive(Args, Debug)]
pub(crate) struct Watch {
    /// Runs, sweeps and fleets, or directories of some [default: runs and sweeps, also those that begin later]
    #[arg(value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) dirs: Vec<PathBuf>,
    /// The port of this machine; 0: any [default: 8645, or the next that is free]
    #[arg(long, value_name = "N", value_parser = whole::<u16>(0..=65_535))]
    pub(crate) port: Option<u16>,
    /// Open the page in the browser
    #[arg(long)]
    pub(crate) open: bool,
    /// Let the page change the main values of this experiment and evolve again, into runs/
    #[arg(long, value_name = "EXPERIMENT.toml", value_hint = ValueHint::FilePath)]
    pub(crate) edit: Option<PathBuf>,
    /// Write the current page to a file that needs no server, and end
    #[arg(long, value_name = "FILE.html", value_hint = ValueHint::FilePath, conflicts_with_all = ["port", "open", "edit"])]
    pub(crate) snapshot: Option<PathBuf>,
    /// End with the standard input: another command has started this one.
    #[arg(long, hide = true)]
    pub(crate) beside: bool,
}

/// The page of a command that evolves.
#[derive(Args, Debug, Default)]
pub(crate) struct Beside {
    /// Serve a page that shows the evolution while it runs, and print its address
    #[arg(long)]
    pub(crate) watch: bool,
    /// With --watch: open the page in the browser
    #[arg(long, requires = "watch")]
    pub(crate) open: bool,
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
    /// List this machine's devices, and whether each is bit-exact
    List(DeviceList),
    /// Check that this machine computes the same bits as every other
    Test(DeviceTest),
    /// Measure robot-steps per second
    Bench(DeviceBench),
}

/// `oneiro device list`
#[derive(Args, Debug)]
pub(crate) struct DeviceList {
    /// Compile all kernels for each adapter, and print registers and instruction counts from its driver
    #[arg(long)]
    pub(crate) explain: bool,
}

/// `oneiro device test`
#[derive(Args, Debug)]
pub(crate) struct DeviceTest {
    /// What to check: all, cpu, gpu (every adapter), gpu:NAME or gpu:INDEX
    #[arg(long, value_name = "BACKEND", default_value = "all")]
    pub(crate) backend: String,
    /// Episodes of 500 cycles for each controller and kind of world; a 20th for surrogates
    #[arg(long, value_name = "N", default_value_t = 4000, value_parser = whole::<u32>(1000..=1_000_000))]
    pub(crate) rollouts: u32,
    /// Sensor tables instead of the built-in ones, such as wall.sam,round.sam
    #[arg(long, value_name = "FILE,..", value_delimiter = ',', value_hint = ValueHint::FilePath)]
    pub(crate) tables: Vec<PathBuf>,
}

/// `oneiro device bench`
#[derive(Args, Debug)]
pub(crate) struct DeviceBench {
    /// An experiment to time, by its first 500 cycles [default: the Khepera of the 1995 paper]
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) experiment: Option<PathBuf>,
    /// Change a value, such as noise.sensor=[0.0,0.4]; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = setting, requires = "experiment")]
    pub(crate) set: Vec<String>,
    /// Batch sizes [default: 1000,10000,100000,1000000, as far as time allows]
    #[arg(long, value_name = "N,..", value_delimiter = ',', value_parser = whole::<u32>(1..=16_777_216))]
    pub(crate) rollouts: Vec<u32>,
    /// Measure for seconds instead of minutes
    #[arg(long)]
    pub(crate) quick: bool,
    /// What to measure: all, cpu, gpu (every adapter), gpu:NAME or gpu:INDEX
    #[arg(long, value_name = "BACKEND", default_value = "all")]
    pub(crate) backend: String,
    /// When to compile kernels for this world: auto, always or never
    #[arg(long, value_name = "WHEN", default_value = "auto", value_parser = Specialise::from_str)]
    pub(crate) specialise: Specialise,
    /// Write figures, devices and drivers to this file, for others (.json, never overwritten)
    #[arg(long, value_name = "FILE.json", value_hint = ValueHint::FilePath)]
    pub(crate) share: Option<PathBuf>,
    /// Measure the host instead: individuals per second that a sweep records, with a device that takes no time
    #[arg(long, conflicts_with_all = ["experiment", "rollouts", "quick", "backend", "specialise", "share"])]
    pub(crate) host: bool,
    /// With --host: approximate time for each number of processors [default: 10]
    #[arg(long, value_name = "N", conflicts_with_all = ["rollouts", "quick"], value_parser = whole::<u32>(1..=3600))]
    pub(crate) seconds: Option<u32>,
    /// With --host: numbers of processors [default: from 1 to all]
    #[arg(long, value_name = "N,..", value_delimiter = ',', conflicts_with_all = ["rollouts", "quick"], value_parser = whole::<u16>(1..=1024))]
    pub(crate) processors: Vec<u16>,
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
    /// Connect to a robot, stop its wheels, and print its type, sensors and response time
    Ping(RobotLink),
    /// Stop a robot's wheels and show its sensors until Ctrl-C (JSON lines in a pipe)
    Watch(RobotWatch),
    /// Drive a robot by keys or from a file; a guard stops it if this program dies or hangs
    #[command(
        after_help = "Keys: arrows or W, A, S, D drive forwards, turn left, drive backwards and turn right while held;
+ and - change the speed; space stops, R resumes, Q quits."
    )]
    Drive(RobotDrive),
    /// Switch a robot's lights on or off, with its wheels stopped
    Light(RobotLight),
    /// Stop a robot's wheels, and report whether it confirmed that
    Stop(RobotLink),
    /// Sample a robot's sensors and motors into tables
    Sample(RobotSample),
    /// Compare a simulator with recorded episodes of the robot, and print matching settings
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
    /// The robot's address, such as `serial:/dev/ttyUSB0` or `tcp:192.168.1.7:1000`; `oneiro robot list` has all forms
    #[arg(value_name = "ADDRESS")]
    pub(crate) address: String,
    /// Record all bytes of the link in this file, for a bug report (never overwritten)
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
    /// Readings per second, 0.1 to 100; slow links give fewer
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
    On,
    Off,
}

/// `oneiro robot drive`
#[derive(Args, Debug)]
pub(crate) struct RobotDrive {
    /// The robot, and the guard's values.
    #[command(flatten)]
    pub(crate) guard: Guard,
    /// Initial speed: 1 to 1100 mm/s, or 1% to 100% of the allowed maximum
    #[arg(long, value_name = "SPEED", default_value = "50", value_parser = speed)]
    pub(crate) speed: Speed,
    /// Drive from this file: each line has a time in s and the left and right wheel speeds in mm/s
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) commands: Option<PathBuf>,
    /// Dry run: print what would be sent, and open nothing
    #[arg(long, conflicts_with = "record")]
    pub(crate) dry_run: bool,
}

/// `oneiro robot sample`
#[derive(Args, Debug)]
pub(crate) struct RobotSample {
    /// surrogate:SEED, FILE.toml (an experiment's parametric robot), or an address, such as `serial:/dev/ttyUSB0` (`oneiro robot list`)
    #[arg(long, value_name = "ROBOT", default_value = "surrogate:1")]
    pub(crate) robot: String,
    #[arg(
        long,
        value_name = "LAMBDA",
        value_parser = of_key::<f32>("reality.severity"),
        help = format!(
            "How much a surrogate differs from its simulator, 0 to 2 [default: {}]",
            SEVERITY
        )
    )]
    pub(crate) severity: Option<f32>,
    /// Objects: wall, round, block, or custom ones in mm: CLASS:wall, CLASS:round:RADIUS or CLASS:block:LENGTHxWIDTH, such as
    /// can:round:33
    #[arg(long, value_name = "OBJECT,..", value_delimiter = ',', default_value = "wall,round")]
    pub(crate) objects: Vec<String>,
    /// The device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
    /// Directory for tables and pictures; an interrupted sampling continues there
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: PathBuf,
    /// Options for a connected robot.
    #[command(flatten)]
    pub(crate) wired: SampleWired,
}

/// Options of `oneiro robot sample` for connected robots.
#[derive(Args, Debug)]
#[command(next_help_heading = "Connected robots")]
pub(crate) struct SampleWired {
    /// Ask for no key press: a machine places the robot or the object
    #[arg(long)]
    pub(crate) yes: bool,
    /// Turns before an object, 1 to 20; readings are averaged [default: 1]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=20))]
    pub(crate) turns: Option<u32>,
    /// Gap between robot and object in the first row, 0 to 10000 mm [default: 5]
    #[arg(long, value_name = "MM", value_parser = number::<f32>(0.0..=10_000.0))]
    pub(crate) nearest: Option<f32>,
    /// Distance from one row to the next, 0.01 to 1000 mm [default: 2]
    #[arg(long, value_name = "MM", value_parser = number::<f32>(0.01..=1000.0))]
    pub(crate) spacing: Option<f32>,
    /// Number of rows, 1 to 1000 [default: 20]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=1000))]
    pub(crate) rows: Option<u32>,
    /// Wheel speed in the state 10 of -10 to 10, 1 to 1100 mm/s [default: ten robot units if they are a 20th of its maximum, as for a
    /// Khepera, else the guard's maximum]
    #[arg(long, value_name = "MM_S", value_parser = number::<f64>(wired::SPEEDS_MM_S[0]..=wired::SPEEDS_MM_S[1]))]
    pub(crate) full_speed: Option<f64>,
    /// Sample no motors
    #[arg(long, conflicts_with = "full_speed")]
    pub(crate) no_motors: bool,
    /// Set a value of the guard, such as `link_ms=400`; repeatable
    #[arg(long = "guard", value_name = "KEY=VALUE")]
    pub(crate) values: Vec<String>,
    /// Record all bytes of the link in this file, for a bug report (never overwritten)
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
            (!self.values.is_empty(), "--guard"),
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
    /// Directories of episodes logged by `oneiro evaluate --robot` or by runs with `[reality]` on a connected robot
    #[arg(long, value_name = "DIR", required = true, num_args = 1.., value_hint = ValueHint::DirPath)]
    pub(crate) log: Vec<PathBuf>,
    /// Directory for a page, a table of errors and the resulting settings; must be empty or new
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: PathBuf,
    /// Change a value, such as noise.sensor=[0.0,0.4]; repeatable
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
    /// Convert between .sam (integers) and .sample (fractions of 1023)
    Convert {
        /// The table to read
        #[arg(value_hint = ValueHint::FilePath)]
        from: PathBuf,
        /// The file to write (never overwritten); its extension selects the format
        #[arg(value_hint = ValueHint::FilePath)]
        to: PathBuf,
    },
    /// Write a built-in table to a file
    Export {
        /// wall, round or motor
        #[arg(long, value_name = "TABLE")]
        builtin: String,
        /// The file to write (never overwritten); its extension selects the format
        #[arg(value_hint = ValueHint::FilePath)]
        to: PathBuf,
    },
}

/// `oneiro on-board`
#[derive(Args, Debug)]
pub(crate) struct OnBoard {
    /// The robot's TOML file (docs/fleet.md)
    #[arg(value_name = "ROBOT.toml", value_hint = ValueHint::FilePath)]
    pub(crate) file: PathBuf,
    /// Run in the twin at this socket instead of on a robot
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
    /// Also read the odometers, and report the wheels' turns
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
    /// Set a value of the guard, such as `expiry_ms=200`; repeatable
    #[arg(long = "guard", value_name = "KEY=VALUE")]
    pub(crate) values: Vec<String>,
}

/// A speed on the command line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Speed {
    /// In mm/s.
    MmPerS(f64),
    /// A fraction of the maximum, 0 to 1.
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
    /// Create the secret key that robots and operator share
    Key {
        /// File for the key (never overwritten; only its owner can read it)
        #[arg(value_hint = ValueHint::FilePath)]
        file: PathBuf,
    },
    /// Dry run: check a fleet's file, and print what the other commands would do
    Plan(FleetFile),
    /// Copy program, experiment, robot.toml and key to the robots, and install the daemon
    Deploy(FleetWork),
    /// Start the daemons; a swarm stops when this command ends, single robots continue
    Start(FleetStart),
    /// Show by ssh whether each daemon runs, and its log's last line
    Status(FleetStatus),
    /// Stop the daemons, and report for each robot whether its log confirms stopped wheels
    Stop(FleetWork),
    /// Copy the robots' records to this machine, and merge a swarm's logs into one timeline
    Collect(FleetWork),
    /// Run all daemons on this machine, with emulated e-pucks in a simulated arena
    #[cfg(all(unix, feature = "twin"))]
    Twin(Twin),
    /// Compare records of a fleet or its twins with batched runs: food, simulators, genes
    Compare(FleetCompare),
    /// Write a page that plays what robots reported during `start`, or a twin's record
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
    /// Only robots with these numbers
    #[arg(long, value_name = "N,..", value_delimiter = ',', value_parser = whole::<u32>(0..=u32::MAX.into()))]
    pub(crate) robots: Vec<u32>,
}

/// `oneiro fleet start`
#[derive(Args, Debug)]
pub(crate) struct FleetStart {
    /// The fleet's TOML file
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) fleet: PathBuf,
    /// Start when N robots are ready [default: all]
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
    /// Listen to the robots for this time instead, such as 3s, without sending a beacon
    #[arg(long, value_name = "TIME", value_parser = duration, conflicts_with = "robots")]
    pub(crate) listen: Option<Duration>,
}

/// Work on a fleet's robots.
#[derive(Args, Debug)]
pub(crate) struct FleetWork {
    /// The fleet.
    #[command(flatten)]
    pub(crate) file: FleetFile,
    /// Exit with 0 if it worked for at least N robots [default: all]
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
    /// A script of faults: lost packets, killed daemons, hanging links, drifting clocks, full disks
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) faults: Option<PathBuf>,
    /// A seed instead of the fleet's
    #[arg(long, value_name = "N", value_parser = seed())]
    pub(crate) seed: Option<u64>,
    /// The twin's directory, which must be empty or new
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: PathBuf,
    /// Maximum speed-up over real time, 0.1 to 10000 [default: as fast as possible]
    #[arg(long, value_name = "X", value_parser = number::<f64>(0.1..=10_000.0))]
    pub(crate) speed: Option<f64>,
    /// Program for the daemons instead of this one, such as a script that runs a robot's build under an emulator
    #[arg(long, value_name = "FILE", value_hint = ValueHint::ExecutablePath)]
    pub(crate) program: Option<PathBuf>,
}

/// `oneiro fleet compare`
#[derive(Args, Debug)]
pub(crate) struct FleetCompare {
    /// The fleet's TOML file
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) fleet: PathBuf,
    /// Directories of twins, or of fleets after `oneiro fleet collect`, with this experiment and any seeds [default: the fleet's]
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
    /// Check a sweep's file, list its runs, and estimate their time on this machine
    Plan(SweepPlan),
    /// Run all unfinished runs; repeat the command to continue after an interruption
    Run(SweepRun),
    /// Show a sweep's progress, also while it runs
    Status {
        /// The sweep's directory [default: the newest in sweeps/]
        #[arg(value_hint = ValueHint::DirPath)]
        dir: Option<PathBuf>,
    },
    /// Join the results of shards from any machines into one table
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
        /// The sweep's directory [default: the newest in sweeps/]. If the sweep is unfinished, the report is of its finished runs, and
        /// lists the others
        #[arg(value_hint = ValueHint::DirPath)]
        dir: Option<PathBuf>,
        /// The column of results.csv to compare cells by; higher is better, but of times less [default: `champion_mean`; peak without finalists; real with
        /// `[reality]`; rate for the foraging study]
        #[arg(long, value_name = "COLUMN")]
        outcome: Option<String>,
        /// Write report.html and its tables into this directory [default: the sweep's directory]
        #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
        out: Option<PathBuf>,
    },
    /// Repeat one run in a separate directory, for replays, and compare the results
    Extract {
        /// The sweep's directory
        #[arg(value_hint = ValueHint::DirPath)]
        dir: PathBuf,
        /// The run's number, or the beginning of its id
        run: String,
        /// The run's directory [default: DIR/runs/run-NUMBER]
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
    /// The device to time, as in `oneiro sweep run` [default: the CPU and each exact GPU, without software drivers]
    #[arg(long, value_name = "BACKEND")]
    pub(crate) backend: Option<String>,
    /// CPU threads, 1 to 1024 [default: one per processor]
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Also print the minimum time on known cards that this machine doesn't have
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
    /// Run every N-th run, starting with the I-th; shards may run at the same time [default: the Slurm array task's shard, else all
    /// runs]
    #[arg(long, value_name = "I/N")]
    pub(crate) shard: Option<Shard>,
    /// Save a checkpoint and stop with exit code 75 after this time, such as 90s, 30m or 1h30m
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub(crate) time_budget: Option<Duration>,
    /// Time between checkpoints, the maximum loss in a power cut
    #[arg(long, value_name = "TIME", default_value = "10s", value_parser = duration)]
    pub(crate) checkpoint_every: Duration,
    /// Maximum number of runs at a time [default: as many as keep the device busy]
    #[arg(long, value_name = "K", value_parser = whole::<u32>(1..=1_000_000))]
    pub(crate) jobs: Option<u32>,
    /// Allow more than 10,000 runs
    #[arg(long)]
    pub(crate) yes: bool,
    /// The device that evaluates.
    #[command(flatten)]
    pub(crate) backend: Backend,
    /// Print a Slurm job array that runs the sweep, and run nothing
    #[arg(long, conflicts_with = "watch")]
    pub(crate) print_slurm: bool,
    /// With --print-slurm: number of array tasks, at most one for each run [default: 8]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=100_000))]
    pub(crate) shards: Option<u32>,
    /// Its page.
    #[command(flatten)]
    pub(crate) beside: Beside,
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

/// `oneiro man`
#[derive(Args, Debug)]
pub(crate) struct Man {
    /// The pages' directory, such as ~/.local/share/man/man1; older pages are replaced
    #[arg(value_hint = ValueHint::DirPath)]
    pub(crate) dir: PathBuf,
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

/// Parses a speed in mm/s, 1 to 1100, or as a percentage of the maximum, 1 % to 100 %.
fn speed(text: &str) -> Result<Speed, String> {
    let (number, is_share) = match text.strip_suffix('%') {
        Some(number) => (number, true),
        None => (text, false),
    };
    match number.trim_end().parse::<f64>() {
        Ok(share) if is_share && (1.0..=100.0).contains(&share) => Ok(Speed::Share(share / 100.0)),
        Ok(speed) if !is_share && (1.0..=1100.0).contains(&speed) => Ok(Speed::MmPerS(speed)),
        _ => Err("allowed: 1 to 1100 mm/s, such as 50, or 1% to 100% of the maximum, such as 25%".to_owned()),
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

    #[test]
    fn command_line_is_consistent() {
        command().debug_assert();
    }

    /// A new option of `oneiro evaluate` has an effect with `--best` and `--tournament`, or is refused there.
    #[test]
    fn options_of_evaluations_are_refused_where_they_have_no_effect() {
        const OTHERS: &str = "experiment genomes seed trials test set out best individuals all tournament every backend threads recheck \
                            specialise json quiet verbose help version";
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

    /// Lines of a help text on a terminal of 100 columns.
    fn lines(help: &str) -> usize {
        help.lines().map(|line| line.chars().count().max(1).div_ceil(100)).sum()
    }

    /// The program's help fits one screen, and that of each command two. Short and long help are the same.
    #[test]
    fn each_help_fits_its_screens() {
        let help = |path: &str, flag: &str| {
            let words = path.split(' ').chain([flag]);
            command().try_get_matches_from(words).unwrap_err().to_string()
        };
        let mut commands = vec![(PROGRAM.to_owned(), command())];
        let mut count = 0;
        while let Some((path, command)) = commands.pop() {
            let long = help(&path, "--help");
            let allowed = if path == PROGRAM { 24..=40 } else { 1..=70 };
            assert!(
                allowed.contains(&lines(&long)),
                "{path}: {} lines\n{long}",
                lines(&long)
            );
            assert_eq!(help(&path, "-h"), long, "{path}");
            assert_eq!(lines(&long), long.lines().count(), "{path}: over 100 columns\n{long}");
            count += 1;
            let inner = command.get_subcommands();
            commands.extend(inner.map(|own| (format!("{path} {}", own.get_name()), own.clone())));
        }
        assert!(count > 45, "{count}");
    }

    /// Control: a line longer than the terminal counts as several.
    #[test]
    fn long_lines_are_counted() {
        assert_eq!(lines(&format!("{}\n\n{}", "a".repeat(100), "b".repeat(101))), 4);
    }
}
