//! Parts as nobody would write them: those of `oneiro new` and of the classics, with a few tokens deleted, doubled, swapped
//! or replaced. Each is refused with a place in it, or its lives end; nothing panics.

use std::sync::Arc;
use std::time::{Duration, Instant};

use oneiro::batch::{Batch, Rollout};
use oneiro::compose::{Kind, OwnPart, OwnParts, Part};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::{Key, pcg4d};
use oneiro::world::{Controller, Task, World, WorldSpec};

const PARTS: [(Kind, &str); 8] = [
    (Kind::Sensor, include_str!("../host/src/experiment/parts/sensor.wgsl")),
    (Kind::Sensor, include_str!("../experiments/homing/sensors.wgsl")),
    (
        Kind::Controller,
        include_str!("../host/src/experiment/parts/controller.wgsl"),
    ),
    (Kind::Controller, include_str!("../experiments/road-sign/ctrnn.wgsl")),
    (Kind::Task, include_str!("../host/src/experiment/parts/task.wgsl")),
    (Kind::Task, include_str!("../experiments/road-sign/task.wgsl")),
    (Kind::Task, include_str!("../experiments/discrimination/task.wgsl")),
    (Kind::Task, include_str!("../experiments/wall-following/task.wgsl")),
];

/// Tokens that kernels don't expect.
const ODD: [&str; 24] = [
    "0u",
    "1u",
    "4294967295u",
    "-2147483647i",
    "65535u",
    "3.4e38f",
    "0x1p-126f",
    "0.0f",
    "i32",
    "u32",
    "f32",
    "bool",
    "vec2<f32>",
    "array<u32, 70000>",
    "array<f32, 3>",
    "&",
    "*",
    "loop",
    "while",
    "for",
    "continue",
    "return",
    "life",
    "before",
];

/// How long lives of one mutant may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(30);

/// Mutants that are tried however long it takes.
const LEAST: u32 = 300;

/// Words, numbers, blanks and single signs.
fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let is_word = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
        let end = if is_word(first) {
            rest.find(|c: char| !is_word(c)).unwrap_or(rest.len())
        } else {
            first.len_utf8()
        };
        tokens.push(&rest[..end]);
        rest = &rest[end..];
    }
    tokens
}

fn mutant(text: &str, seed: u32) -> String {
    let mut tokens = tokens(text);
    for change in 0..=seed % 3 {
        let [kind, a, b, _] = pcg4d([seed, change, 1, 2]);
        let place = |word: u32| {
            let words: Vec<usize> = (0..tokens.len()).filter(|at| !tokens[*at].trim().is_empty()).collect();
            words[word as usize % words.len()]
        };
        let (a, other) = (place(a), place(b));
        match kind % 5 {
            0 => _ = tokens.remove(a),
            1 => tokens.insert(a, tokens[a]),
            2 => tokens.swap(a, other),
            3 => tokens[a] = tokens[other],
            _ => tokens[a] = ODD[b as usize % ODD.len()],
        }
    }
    tokens.concat()
}

/// Makes a world of a mutant and lets some live in it. Returns whether it was accepted.
fn live(kind: Kind, text: &str) -> Result<(), String> {
    let part = Part::new(kind, "mutant.wgsl", text).map_err(|refused| refused.to_string())?;
    let own = OwnPart::new(Arc::new(part), &[]).map_err(|invalid| invalid.to_string())?;
    let mut spec = WorldSpec {
        cycles: 20,
        own: OwnParts::from([own]),
        ..WorldSpec::miglino1995()
    };
    match kind {
        Kind::Sensor => {}
        Kind::Controller => spec.controller = Controller::Own,
        Kind::Task => spec.task = Task::Own,
    }
    let world = World::new(spec).map_err(|invalid| invalid.to_string())?;
    let genes: Vec<f32> = (0..world.genes()).map(|gene| (gene % 7) as f32 - 3.0).collect();
    let rollouts: Vec<_> = (0..20)
        .map(|life| Rollout {
            world: 0,
            genes: &genes,
            key: Key::rollout(1, 0, life, 0),
        })
        .collect();
    let batch = Batch::new(&[world], &rollouts, None).map_err(|invalid| invalid.to_string())?;
    let begin = Instant::now();
    let outcome = Cpu::new(Some(1)).unwrap().evaluate(&batch, &Control::new());
    outcome.map_err(|error| error.to_string())?;
    assert!(
        begin.elapsed() < PATIENCE,
        "twenty lives took {:?}:\n{text}",
        begin.elapsed()
    );
    Ok(())
}

/// Whether a message names the part with a line and a column, or something that has none.
fn is_placed(message: &str) -> bool {
    let is_place = |after: &str| {
        let mut numbers = after.split(':').map(str::parse::<u32>);
        numbers.next().is_some_and(|line| line.is_ok()) && numbers.next().is_some_and(|column| column.is_ok())
    };
    let has_place = message.split(".wgsl:").skip(1).any(is_place);
    let has_none = ["mutant.wgsl: has no", "in a cycle; allowed"];
    message.contains("mutant.wgsl") && has_place || has_none.iter().any(|words| message.contains(words))
}

#[test]
fn mutants_are_refused_or_live() {
    let times = if std::env::var_os("ONEIRO_LONG").is_some() {
        40
    } else {
        1
    };
    let (begin, patience) = (Instant::now(), Duration::from_secs(10) * times);
    let (mut taken, mut refused, mut problems) = (0, 0, Vec::new());
    for seed in 0..2_000 * times {
        if seed >= LEAST && begin.elapsed() > patience {
            break;
        }
        let (kind, text) = PARTS[seed as usize % PARTS.len()];
        let text = mutant(text, seed);
        match live(kind, &text) {
            Ok(()) => taken += 1,
            Err(message) => {
                refused += 1;
                // No mistake in a part breaks a rule of Oneiro's own files.
                if !is_placed(&message) || !message.ends_with(']') || message.contains("[internal]") {
                    problems.push(format!("seed {seed}: {message}\n{text}"));
                }
            }
        }
    }
    eprintln!(
        "{taken} mutants lived, {refused} were refused, in {:.1?}",
        begin.elapsed()
    );
    assert!(problems.is_empty(), "{}", problems.join("\n"));
    assert!(taken > 20 && refused > 100, "{taken} lived, {refused} were refused");
}
