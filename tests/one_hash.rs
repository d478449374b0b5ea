//! Whatever is accepted has one result: parts as users might write them, drawn at random or changed at random, live the same lives
//! however many threads there are, however work is cut, whoever lives beside them, by whatever code.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use oneiro::backend::Specialise;
use oneiro::batch::{Rollout, TraceRequest, Worlds};
use oneiro::compose::{Kind, OwnPart, OwnParts, Part};
use oneiro::cpu::Cpu;
use oneiro::differential::Build;
use oneiro::evaluator::{Control, Error, Evaluator};
use oneiro::foraging::Forager;
use oneiro::random::Key;
use oneiro::world::{Controller, Noise, Task, World, WorldSpec};

#[path = "one_hash/generator.rs"]
mod generator;
#[path = "hostile/world.rs"]
mod hostile;
mod mutations;

use generator::{Draw, Setting};
use hostile::described;
use mutations::mutant;

/// Parts that ship, to be changed at random.
const SHIPPED: [(Kind, &str); 5] = [
    (Kind::Sensor, include_str!("../experiments/homing/sensors.wgsl")),
    (Kind::Controller, include_str!("../experiments/road-sign/ctrnn.wgsl")),
    (Kind::Task, include_str!("../experiments/road-sign/task.wgsl")),
    (Kind::Task, include_str!("../experiments/discrimination/task.wgsl")),
    (Kind::Task, include_str!("../experiments/wall-following/task.wgsl")),
];

/// What a change puts into a part: above all what could reach another episode.
const ODD: [&str; 26] = [
    "life",
    "Life",
    "gene",
    "0u",
    "4294967295u",
    "-1.0f",
    "3.4e38f",
    "0x1p-126f",
    "var",
    "let",
    "const",
    "array<f32, 3>",
    "bitcast<u32>",
    "bitcast<f32>",
    "random",
    "reading",
    "readings",
    "now",
    "before",
    "robot_pose",
    "inputs",
    "state",
    "&",
    "*",
    "_",
    "alias",
];

/// Parts to try in `tests/all.sh`, and where `ONEIRO_LONG` is set.
const PARTS: [u32; 2] = [300, 10_000];
/// Of how many parts one is also tried on a GPU, if there is one.
const GPU_SHARE: [u32; 2] = [30, 50];

/// Lives of a part, in two worlds.
const LIVES: usize = 70;
/// Of these, those that are traced, and that the interpreter lives.
const FEW: usize = 9;
const CYCLES: u32 = 12;

/// A part that is tried: with its kind, where, and what it must be the same as.
struct Subject {
    spec: WorldSpec,
    parts: Vec<(Kind, String)>,
    /// Whether it was drawn, and not changed at random.
    is_drawn: bool,
}

/// Noise that the kernels that ship don't have too.
fn noise(draw: &mut Draw, is_sampled: bool) -> Noise {
    match draw.below(if is_sampled { 4 } else { 2 }) {
        0 => Noise::NONE,
        1 => Noise::SENSOR,
        2 => Noise::CONSERVATIVE,
        _ => Noise {
            delay: Some(1.0),
            gain: Some(0.1),
            ..Noise::SENSOR
        },
    }
}

/// The subject of a seed, with arrays of so many elements that change nothing.
fn subject(seed: u32, filler: u32) -> Subject {
    let mut draw = Draw::new(seed ^ 0x5eed_0000);
    let (setting, mut spec) = match seed % 8 {
        0..3 => (Setting::Alone, WorldSpec::miglino1995()),
        3 => (Setting::Alone, described(None)),
        4 | 5 => (Setting::Swarm, described(Some(3))),
        6 => (Setting::Forager, WorldSpec::foraging(Forager::ODOWD2014)),
        _ => {
            let (kind, text) = SHIPPED[draw.below(SHIPPED.len() as u32) as usize];
            let text = match draw.below(3) {
                0 => mutant(text, &ODD, seed),
                1 => mutant(&generator::part(kind, Setting::Alone, seed, filler), &ODD, seed),
                _ => {
                    let all = hostile::all(std::path::Path::new(concat!(
                        env!("CARGO_MANIFEST_DIR"),
                        "/../tests/hostile"
                    )));
                    let one = &all[draw.below(all.len() as u32) as usize];
                    let (kind, spec) = one.world();
                    return Subject {
                        spec,
                        parts: vec![(kind, mutant(&one.text, &ODD, seed))],
                        is_drawn: false,
                    };
                }
            };
            return Subject {
                spec: WorldSpec::miglino1995(),
                parts: vec![(kind, text)],
                is_drawn: false,
            };
        }
    };
    if setting != Setting::Forager {
        spec.noise = noise(&mut draw, spec.robot.build == Build::Sampled);
    }
    let mut kinds = vec![[Kind::Task, Kind::Controller, Kind::Sensor][draw.below(3) as usize]];
    if setting == Setting::Swarm {
        kinds = vec![Kind::Task];
    }
    for other in [Kind::Sensor, Kind::Controller, Kind::Task] {
        if !kinds.contains(&other) && draw.one_in(3) {
            kinds.push(other);
        }
    }
    let part = |kind| {
        (
            kind,
            generator::part(kind, setting, seed, if kind == kinds[0] { filler } else { 0 }),
        )
    };
    Subject {
        spec,
        parts: kinds.iter().map(|kind| part(*kind)).collect(),
        is_drawn: true,
    }
}

impl Subject {
    /// Two worlds that differ in what their parts are given and in how long lives take; `path` is what the parts' files are called.
    fn worlds(&self, path: &str) -> Result<[World; 2], String> {
        let world = |cycles| {
            let mut spec = WorldSpec {
                cycles,
                ..self.spec.clone()
            };
            let mut all = OwnParts::default();
            for (kind, text) in &self.parts {
                let path = format!("{path}-{}.wgsl", kind.word());
                let part = Part::new(*kind, &path, text).map_err(|refused| refused.to_string())?;
                let values: Vec<_> = part.values().iter().map(|value| value.name.clone()).collect();
                let weight = values.iter().any(|name| name == "weight" && cycles < CYCLES);
                let values: &[(&str, f64)] = if weight { &[("weight", 1.25)] } else { &[] };
                let own = OwnPart::new(Arc::new(part), values).map_err(|invalid| invalid.to_string())?;
                all.insert(Arc::new(own));
                match kind {
                    Kind::Sensor => {}
                    Kind::Controller => spec.controller = Controller::Own,
                    Kind::Task => spec.task = Task::Own,
                }
            }
            spec.own = all;
            World::new(spec).map_err(|invalid| invalid.to_string())
        };
        Ok([world(CYCLES)?, world(CYCLES - 5)?])
    }
}

/// Fitness and traces, as bits.
type Bits = (Vec<u32>, Vec<Vec<u32>>);

/// Lives of worlds by a device.
fn live(device: &mut dyn Evaluator, worlds: &[World; 2], lives: &[usize], traced: bool) -> Result<Bits, Error> {
    let genes = |life: usize| -> Vec<f32> {
        let value = |gene: usize| ((life * 31 + gene * 7) % 41) as f32 / 10.0 - 2.0;
        (0..worlds[0].genes()).map(value).collect()
    };
    let genes: Vec<_> = lives.iter().map(|life| genes(*life)).collect();
    let rollouts: Vec<_> = lives
        .iter()
        .zip(&genes)
        .map(|(life, genes)| Rollout {
            world: life % 2,
            genes,
            key: Key::rollout(3, 0, *life as u64, 0),
        })
        .collect();
    let worlds = Worlds::new(worlds).expect("they have one kernel");
    let batch = worlds
        .batch(&rollouts, traced.then_some(TraceRequest { every: 1 }))
        .unwrap();
    let outcome = device.evaluate(&batch, &Control::new())?;
    let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
    let traces = outcome.traces.iter().map(|trace| trace.words().collect());
    Ok((bits(&outcome.fitness), traces.collect()))
}

/// Devices of one thread of this test.
struct Devices {
    alone: Cpu,
    three: Cpu,
    sixteen: Cpu,
    by_cycle: Cpu,
    by_seven: Cpu,
    special: Cpu,
    interpreter: Cpu,
    checking: Cpu,
    #[cfg(feature = "gpu")]
    gpu: Option<oneiro::gpu::Gpu>,
}

impl Devices {
    fn new() -> Self {
        let cpu = |threads| Cpu::new(Some(threads)).unwrap();
        Self {
            alone: cpu(1).with_specialise(Specialise::Never),
            three: cpu(3),
            sixteen: cpu(16),
            by_cycle: cpu(1).with_chunk(1),
            by_seven: cpu(1).with_chunk(7),
            special: cpu(1).with_specialise(Specialise::Always),
            interpreter: cpu(1).with_variant("interpretedx1").unwrap(),
            checking: cpu(1).checking(),
            #[cfg(feature = "gpu")]
            gpu: oneiro::gpu::Gpu::open(&oneiro::gpu::Choice::Best)
                .ok()
                .filter(|gpu| gpu.why_inexact().is_none()),
        }
    }
}

/// What was tried.
#[derive(Default)]
struct Tally {
    accepted: AtomicU32,
    changed: AtomicU32,
    inexact: AtomicU32,
    on_gpu: AtomicU32,
    refused: AtomicU32,
}

/// Tries the subject of a seed in every way.
fn compare(seed: u32, devices: &mut Devices, share: u32, tally: &Tally) -> Result<(), String> {
    let count = |of: &AtomicU32| _ = of.fetch_add(1, Ordering::Relaxed);
    let subject = subject(seed, 0);
    let worlds = match subject.worlds("first") {
        Ok(worlds) => worlds,
        Err(refused) if subject.is_drawn => return Err(format!("it is refused: {refused}")),
        Err(_) => {
            count(&tally.refused);
            return Ok(());
        }
    };
    count(if subject.is_drawn {
        &tally.accepted
    } else {
        &tally.changed
    });
    let all: Vec<usize> = (0..LIVES).collect();
    let few: Vec<usize> = (0..FEW).map(|at| at * 7).collect();
    let at = |device: &mut dyn Evaluator, lives: &[usize], traced| {
        live(device, &worlds, lives, traced).map_err(|error| format!("it can't be run: {error}"))
    };
    let clock = Instant::now();
    let lap = |what: &str| {
        if std::env::var_os("LAPS").is_some() {
            eprintln!("LAP {what} {:?}", clock.elapsed())
        }
    };
    let expected = at(&mut devices.alone, &all, false)?;
    lap("alone");
    let traced = at(&mut devices.alone, &few, true)?;
    let same = |found: &Bits, expected: &Bits, how: &str| {
        if found == expected {
            Ok(())
        } else {
            Err(format!("{how}: {found:x?}, not {expected:x?}"))
        }
    };
    let of_few: Vec<u32> = few.iter().map(|life| expected.0[*life]).collect();
    same(
        &(traced.0.clone(), Vec::new()),
        &(of_few, Vec::new()),
        "beside fewer others",
    )?;
    lap("beside fewer others");
    same(&at(&mut devices.three, &all, false)?, &expected, "3 threads")?;
    same(&at(&mut devices.sixteen, &all, false)?, &expected, "16 threads")?;
    lap("16 threads");
    same(&at(&mut devices.by_cycle, &few, true)?, &traced, "cycle by cycle")?;
    lap("cycle by cycle");
    same(
        &at(&mut devices.by_seven, &all, false)?,
        &expected,
        "in pieces of seven cycles",
    )?;
    lap("in pieces of seven cycles");
    let reversed: Vec<usize> = all.iter().rev().copied().collect();
    let mut found = at(&mut devices.three, &reversed, false)?;
    found.0.reverse();
    same(&found, &expected, "in another order")?;
    lap("in another order");
    for life in [0, 33] {
        let found = at(&mut devices.alone, &[life], false)?;
        same(&found, &(vec![expected.0[life]], Vec::new()), "alone")?;
    }
    same(&at(&mut devices.interpreter, &few, true)?, &traced, "interpreted")?;
    lap("interpreted");
    if seed % 4 == 1 {
        same(
            &at(&mut devices.special, &all, false)?,
            &expected,
            "by code for its world",
        )?;
        // Another name has another kernel, whose code is in the cache now.
        let again = subject.worlds("second")?;
        let found = live(&mut devices.three, &again, &all, false).map_err(|error| error.to_string())?;
        same(&found, &expected, "by code from the cache")?;
    }
    if seed % 16 == 2 && subject.is_drawn {
        // 8 lanes, and 4.
        for filler in [5_000, 16_000] {
            let large = self::subject(seed, filler).worlds("large")?;
            let found = live(&mut devices.alone, &large, &all, false).map_err(|error| error.to_string())?;
            same(&found, &expected, &format!("with an array of {filler}"))?;
        }
    }
    let is_exact = match live(&mut devices.checking, &worlds, &few, false) {
        Ok(found) => same(&found, &(traced.0.clone(), Vec::new()), "checked").map(|()| true)?,
        Err(Error::Inexact { place, what }) if subject.is_drawn => {
            return Err(format!("it is inexact: {place}: {what}"));
        }
        Err(Error::Inexact { .. }) => {
            count(&tally.inexact);
            false
        }
        Err(error) => return Err(error.to_string()),
    };
    #[cfg(feature = "gpu")]
    if let Some(gpu) = devices.gpu.as_mut().filter(|_| is_exact && seed % share == 0) {
        count(&tally.on_gpu);
        same(&at(gpu, &few, true)?, &traced, "on a GPU")?;
    }
    Ok(())
}

#[test]
fn whatever_is_accepted_has_one_result() {
    let long = usize::from(std::env::var_os("ONEIRO_LONG").is_some());
    let given = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<u32>().ok());
    let (first, parts, share) = (given("ONEIRO_SEED").unwrap_or(0), PARTS[long], GPU_SHARE[long]);
    let parts = if given("ONEIRO_SEED").is_some() {
        first + 1
    } else {
        parts
    };
    let (tally, next, begin) = (Tally::default(), AtomicU32::new(first), Instant::now());
    let work = || {
        let mut devices = Devices::new();
        let mut problems = Vec::new();
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= parts {
                return problems;
            }
            if let Err(problem) = compare(seed, &mut devices, share, &tally) {
                let texts: Vec<_> = subject(seed, 0).parts.into_iter().map(|(_, text)| text).collect();
                problems.push(format!("seed {seed}: {problem}\n{}", texts.join("\n// another part\n")));
            }
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let problems: Vec<String> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        threads
            .into_iter()
            .flat_map(|thread| thread.join().expect("the message is above"))
            .collect()
    });
    let [accepted, changed, inexact, on_gpu, refused] = [
        tally.accepted,
        tally.changed,
        tally.inexact,
        tally.on_gpu,
        tally.refused,
    ]
    .map(AtomicU32::into_inner);
    eprintln!(
        "{accepted} drawn parts and {changed} changed ones have one result, {inexact} of these with inexact operations, {on_gpu} on a GPU; \
         {refused} changed ones are refused; {:.1?}",
        begin.elapsed()
    );
    assert!(
        problems.is_empty(),
        "{} problems:\n{}",
        problems.len(),
        problems.iter().take(3).cloned().collect::<Vec<_>>().join("\n\n")
    );
    let _ = Duration::ZERO;
}
