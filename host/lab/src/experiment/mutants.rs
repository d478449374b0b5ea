//! Unusual experiments and sweeps: those that ship, with mistakes in their files and odd values for their keys. Each is refused with
//! its place and the allowed values, or is read, packed, and simulated for some cycles.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use oneiro::batch::{Rollout, Worlds};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::{Key, pcg4d};
use oneiro_base::exit::Result;
use oneiro_base::files;

use super::settings::Settings;
use super::source::Parsed;
use super::swarm;
use super::values::Described;
use crate::mutations::{Spent, alone, mutant, peak};
use crate::runs::{self, Experiment};
use crate::scratch::Scratch;
use crate::sweep::Sweep;

/// Values that few keys have a use for.
const ODD: [&str; 25] = [
    "nan",
    "-inf",
    "-1",
    "0",
    "0.0",
    "1",
    "7",
    "1000000",
    "4294967295",
    "9223372036854775807",
    "1e-40",
    "1e-6",
    "100000.0",
    "1e308",
    "true",
    "''",
    "'x'",
    "'own'",
    "'homing/task.wgsl'",
    "'/dev/zero'",
    "[]",
    "{}",
    "[nan, 1.0]",
    "[[0.0, 0.0], [1.0, nan]]",
    "1979-05-27",
];

/// Texts with a middle that is repeated until they are as long as a file may be.
const LONG: [[&str; 3]; 14] = [
    ["name = '", "a", "'"],
    ["", "a", " = 1"],
    ["", "a.", "a = 1"],
    ["[", "a.", "a]"],
    ["cycles = ", "1", ""],
    ["trials = ", "[", ""],
    ["trials = [", "1,", "]"],
    ["task = ", "{ a = ", ""],
    ["files = { ", "'\u{e9}' = '', ", "}"],
    ["arena = { width_mm = 9, height_mm = 9, walls = [", "{},", "] }"],
    ["robot.sensors = [", "{ name = 'a' },", "]\nrobot.kind = 'differential'"],
    [
        "robot.sensors = [{ response = [",
        "[1,1],",
        "] }]\nrobot.kind = 'differential'",
    ],
    [
        "controller.layers = [",
        "{ units = 64 },",
        "]\ncontroller.kind = 'network'",
    ],
    ["experiment = 'homing.toml'\nseeds = [", "1,", "]"],
];

/// Maximum time for one; the slowest take a second, to compile EvoStick's exploration.
const PATIENCE: Duration = Duration::from_secs(20);
/// Maximum memory of the process that reads them all one after the other, KB: twice the measured amount, of which 370 MB are the
/// process itself. 450 MB are for compiling EvoStick's exploration, which has no mistake but remembers a hundred cells.
const MEMORY: u64 = 1640 << 10;
/// Longest message, bytes.
const MESSAGE: usize = 4_000;
/// Minimum number of mutants, however long they take.
const LEAST: u32 = 200;

/// A folder with all files that ship, and the text of each experiment and sweep with the folder of its mutants.
fn shipped(scratch: &Scratch) -> Vec<(PathBuf, String)> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut texts = Vec::new();
    let mut folders = vec![(root.join("experiments"), PathBuf::new())];
    while let Some((from, to)) = folders.pop() {
        for entry in fs::read_dir(from).unwrap() {
            let path = entry.unwrap().path();
            let name = to.join(path.file_name().unwrap());
            if path.is_dir() {
                folders.push((path, name));
                continue;
            }
            let content = fs::read(&path).unwrap();
            scratch.write(name.to_str().unwrap(), &content);
            // The studies' files are not experiments.
            let is_experiment = to.as_os_str().is_empty() || to.ends_with("sweeps");
            let is_toml =
                path.extension().is_some_and(|extension| extension == "toml") && !path.ends_with("Cargo.toml");
            if is_experiment && is_toml {
                texts.push((to.clone(), String::from_utf8(content).unwrap()));
            }
        }
    }
    // With all their values.
    for name in ["khepera-choices", "khepera-own-arena", "kheperax", "swarm-values"] {
        let text = fs::read_to_string(root.join(format!("tests/resolved/{name}.toml"))).unwrap();
        texts.push((PathBuf::new(), text));
    }
    for name in ["khepera", "epuck", "thymio2"] {
        let text = fs::read_to_string(root.join(format!("host/lab/src/experiment/robots/{name}.toml"))).unwrap();
        let room = "\n[arena]\nwidth_mm = 1000.0\nheight_mm = 1000.0\nlights = [{ x_mm = 1.0, y_mm = 1.0 }]\n";
        texts.push((PathBuf::new(), text + room));
    }
    texts.sort();
    texts
}

/// A key of an experiment with an odd value, as typed.
fn odd_setting(seed: u32) -> String {
    let keys = || {
        let swarm = swarm::File::rows().iter().map(|row| row.key);
        Settings::rows().iter().map(|row| row.key).chain(swarm)
    };
    let [key, value, ..] = pcg4d([seed, 1, 2, 3]);
    let key = keys().nth(key as usize % keys().count()).unwrap();
    format!("{}={}", key.replace("[]", ""), ODD[value as usize % ODD.len()])
}

/// Reads an experiment, or the first cell of a sweep; packs its worlds, and simulates some episodes there.
fn read(path: &Path, set: &[String]) -> Result {
    let text = fs::read_to_string(path).unwrap();
    let is_sweep = Parsed::new("mutant.toml".into(), &text).is_ok_and(|file| file.has("experiment"));
    let experiment = if is_sweep {
        Sweep::read(path)?.cell(0)?
    } else {
        runs::read(path, set)?
    };
    assert!(experiment.bytes() <= 5 << 30, "needs {} bytes", experiment.bytes());
    live(&*experiment, &experiment.sample()?);
    let resolved = experiment.resolved_toml(1);
    if experiment.inputs().is_empty() {
        // Without a name in it, the experiment is named after its file.
        let again = path.with_file_name("again.toml");
        fs::write(&again, &resolved).unwrap();
        assert_eq!(runs::read(&again, &[])?.resolved_toml(1), resolved);
    }
    Ok(())
}

fn live(experiment: &dyn Experiment, worlds: &Worlds) {
    let genes: Vec<f32> = (0..worlds.genes()[0]).map(|gene| (gene % 7) as f32 - 3.0).collect();
    let lives = [0, 1].map(|life| Rollout {
        world: 0,
        genes: &genes,
        key: Key::rollout(1, 0, life, 0),
    });
    let batch = worlds.stretch(&lives, 0..3, &[], None).unwrap();
    let outcome = Cpu::new(Some(1)).unwrap().evaluate(&batch, &Control::new()).unwrap();
    assert_eq!(outcome.fitness.len(), 2, "{}", experiment.name());
}

/// The flaw of a refusal, if it has one.
fn flaw(code: u8, message: &str, is_toml: bool) -> Option<&'static str> {
    let has_place = ["mutant.toml:", "--set ", ".toml:", ".wgsl:"]
        .iter()
        .any(|place| message.contains(place));
    let says_what = [
        "allowed",
        "No such file",
        "lacks",
        "is a sweep",
        "name too long",
        ".wgsl:",
    ];
    [
        (code != 3, "has another code than 3"),
        (!has_place, "has no place"),
        (message.len() > MESSAGE, "is too long"),
        (
            is_toml && !says_what.iter().any(|words| message.contains(words)),
            "doesn't say what is allowed",
        ),
    ]
    .into_iter()
    .find_map(|(is_so, words)| is_so.then_some(words))
}

#[test]
fn mutants_are_refused_or_lived_in() {
    if !alone(concat!(module_path!(), "::mutants_are_refused_or_lived_in")) {
        return;
    }
    let is_long = std::env::var_os("ONEIRO_LONG").is_some();
    let patience = Duration::from_secs(if is_long { 600 } else { 4 });
    let scratch = Scratch::new("mutants");
    let texts = shipped(&scratch);
    let mut problems = Vec::new();
    for [head, middle, tail] in LONG {
        let copies = (files::GREATEST_TEXT - head.len() - tail.len()) / middle.len();
        let text = [head, &middle.repeat(copies), tail].concat();
        let spent = Spent::by("self");
        let failure = read(&scratch.write("mutant.toml", &text), &[]).unwrap_err();
        let time = spent.time();
        assert_eq!(
            (failure.code(), time < PATIENCE, peak() < MEMORY),
            (3, true, true),
            "{head}{middle}: {failure}, {time:.1?}, {} KB",
            peak()
        );
        assert!(failure.to_string().len() < MESSAGE, "{failure}");
    }
    let (spent, mut taken, mut refused) = (Spent::by("self"), 0, 0);
    let mut slowest = (Duration::ZERO, 0);
    for seed in 0.. {
        if seed >= LEAST && spent.time() > patience {
            break;
        }
        let (folder, text) = &texts[seed as usize % texts.len()];
        // Half of them have the mistake in the file, the others in a setting.
        let is_typed = pcg4d([seed, 4, 5, 6])[0].is_multiple_of(2);
        let set: Vec<_> = is_typed.then(|| odd_setting(seed)).into_iter().collect();
        let text = if is_typed {
            text.clone()
        } else {
            mutant(text, &ODD, seed)
        };
        let path = scratch.write(folder.join("mutant.toml").to_str().unwrap(), &text);
        let own = Spent::by("self");
        let found = read(&path, &set);
        let time = own.time();
        slowest = slowest.max((time, seed));
        let is_toml = Parsed::new("mutant.toml".into(), &text).is_ok();
        let flaw = match &found {
            Err(failure) => flaw(failure.code(), &failure.to_string(), is_toml),
            Ok(()) => None,
        };
        match found {
            Ok(()) => taken += 1,
            Err(_) => refused += 1,
        }
        // The first that takes more is the culprit.
        let flaw = flaw
            .or((peak() > MEMORY).then_some("needs too much memory"))
            .or((time > PATIENCE).then_some("takes too long"));
        if let Some(flaw) = flaw {
            let message = found
                .err()
                .map_or_else(|| "taken".to_owned(), |failure| failure.to_string());
            problems.push(format!("seed {seed} {set:?} {flaw} ({time:.1?}): {message:.300}"));
        }
    }
    eprintln!(
        "{taken} mutants were read, {refused} were refused, in {:.1?}, each within {:.1?} (seed {}); at most {} MB",
        spent.time(),
        slowest.0,
        slowest.1,
        peak() >> 10
    );
    assert!(problems.is_empty(), "{}", problems.join("\n"));
    assert!(taken > 20 && refused > 50, "{taken} were read, {refused} were refused");
}
