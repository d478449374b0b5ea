//! Whatever is accepted has one result: parts as users might write them, drawn at random or changed at random, live the same lives
//! however many threads there are, however work is cut, whichever episodes run next to them, by whatever code.

use std::num::NonZero;
use std::panic::{self, AssertUnwindSafe};
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, LazyLock};
use std::time::Instant;

use oneiro::backend::Specialise;
use oneiro::batch::{Rollout, TraceRequest, Worlds};
use oneiro::compose::{Kind, OwnPart, OwnParts, Part};
use oneiro::cpu::Cpu;
use oneiro::differential::Build;
use oneiro::evaluator::{Control, Error, Evaluator};
use oneiro::foraging::Forager;
use oneiro::random::Key;
use oneiro::world::{Controller, Noise, Task, World, WorldSpec};

mod generator;

use crate::hostile::{self, Hostile, described};
use crate::mutations::mutant;
use crate::place::Place;
use generator::{Draw, Setting};

const KINDS: [Kind; 3] = [Kind::Task, Kind::Controller, Kind::Sensor];

/// Parts that ship, to be changed at random.
const SHIPPED: [(Kind, &str); 5] = [
    (Kind::Sensor, include_str!("../../experiments/homing/sensors.wgsl")),
    (Kind::Controller, include_str!("../../experiments/road-sign/ctrnn.wgsl")),
    (Kind::Task, include_str!("../../experiments/road-sign/task.wgsl")),
    (Kind::Task, include_str!("../../experiments/discrimination/task.wgsl")),
    (Kind::Task, include_str!("../../experiments/wall-following/task.wgsl")),
];

/// What a change puts into a part: above all what could reach another episode.
const ODD: [&str; 26] = [
    "life",
    "Episode",
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
const GPU_SHARE: [u32; 2] = [36, 50];

/// How large parts are: most of the time goes into compiling them.
fn size() -> u32 {
    if is_long() { 2 } else { 1 }
}

fn is_long() -> bool {
    std::env::var_os("ONEIRO_LONG").is_some()
}

/// How often a part is changed in another way, if what comes of it is refused.
const ATTEMPTS: u32 = 6;

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

/// Noise, also of kinds that the shipped kernels don't have.
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

/// The subject of a seed; its first part has arrays of so many elements that change nothing.
fn subject(seed: u32, filler: u32) -> Subject {
    let (setting, mut spec) = match seed % 8 {
        0..3 => (Setting::Alone, WorldSpec::miglino1995()),
        3 => (Setting::Alone, described(None)),
        4 | 5 => (Setting::Swarm, described(Some(3))),
        6 => (Setting::Forager, WorldSpec::foraging(Forager::ODOWD2014)),
        _ => return changed(seed),
    };
    let mut draw = Draw::new(seed ^ 0x5eed_0000);
    if setting != Setting::Forager {
        spec.noise = noise(&mut draw, spec.robot.build == Build::Sampled);
    }
    let first = match setting {
        Setting::Swarm => Kind::Task,
        _ => KINDS[draw.below(3) as usize],
    };
    let others = KINDS.into_iter().filter(|kind| *kind != first && draw.one_in(3));
    let part = |kind| {
        let filler = if kind == first { filler } else { 0 };
        (kind, generator::part(kind, setting, seed, filler, size()))
    };
    Subject {
        parts: [first].into_iter().chain(others).map(part).collect(),
        spec,
        is_drawn: true,
    }
}

/// A part that ships, was drawn or is hostile, with changes at random: of some attempts the first that is accepted.
fn changed(seed: u32) -> Subject {
    static HOSTILE: LazyLock<Vec<Hostile>> =
        LazyLock::new(|| hostile::all(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/hostile")));
    let attempt = |attempt: u32| {
        let mut draw = Draw::new(seed ^ (attempt << 24));
        let (kind, spec, text) = match draw.below(3) {
            0 => {
                let (kind, text) = SHIPPED[draw.below(SHIPPED.len() as u32) as usize];
                (kind, WorldSpec::miglino1995(), text.to_owned())
            }
            1 => {
                let kind = KINDS[draw.below(3) as usize];
                (
                    kind,
                    WorldSpec::miglino1995(),
                    generator::part(kind, Setting::Alone, seed, 0, size()),
                )
            }
            _ => {
                let one = &HOSTILE[draw.below(HOSTILE.len() as u32) as usize];
                let (kind, spec) = one.world();
                (kind, spec, one.text.clone())
            }
        };
        Subject {
            spec,
            parts: vec![(kind, mutant(&text, &ODD, seed + attempt))],
            is_drawn: false,
        }
    };
    let attempts: Vec<_> = (0..ATTEMPTS).map(attempt).collect();
    let accepted = attempts.iter().position(|subject| subject.worlds("tried").is_ok());
    attempts.into_iter().nth(accepted.unwrap_or(0)).expect("there are some")
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
    drawn: AtomicU32,
    changed: AtomicU32,
    inexact: AtomicU32,
    refused: AtomicU32,
    on_gpu: AtomicU32,
}

/// Tries the subject of a seed in every way; those that take long, not with each subject.
fn compare(seed: u32, devices: &mut Devices, gpu_share: u32, tally: &Tally) -> Result<(), String> {
    let count = |of: &AtomicU32| _ = of.fetch_add(1, Ordering::Relaxed);
    let subject = subject(seed, 0);
    let worlds = match subject.worlds("first") {
        Ok(worlds) => worlds,
        // A constant that overflows is drawn now and then.
        Err(refused) if subject.is_drawn && !refused.contains("overflowed") => {
            return Err(format!("it is refused: {refused}"));
        }
        Err(_) => {
            count(&tally.refused);
            return Ok(());
        }
    };
    count(if subject.is_drawn { &tally.drawn } else { &tally.changed });
    let all: Vec<usize> = (0..LIVES).collect();
    let few: Vec<usize> = (0..FEW).map(|at| at * 7).collect();
    let at = |device: &mut dyn Evaluator, worlds: &[World; 2], lives: &[usize], traced| {
        live(device, worlds, lives, traced).map_err(|error| format!("it can't be run: {error}"))
    };
    let same = |found: &Bits, expected: &Bits, how: &str| {
        if found == expected {
            Ok(())
        } else {
            Err(format!("{how}: {found:x?}, not {expected:x?}"))
        }
    };
    let expected = at(&mut devices.alone, &worlds, &all, false)?;
    let traced = at(&mut devices.alone, &worlds, &few, true)?;
    let untraced = (few.iter().map(|life| expected.0[*life]).collect(), Vec::new());
    same(&(traced.0.clone(), Vec::new()), &untraced, "beside fewer others")?;
    same(&at(&mut devices.three, &worlds, &all, false)?, &expected, "3 threads")?;
    same(
        &at(&mut devices.by_cycle, &worlds, &few, true)?,
        &traced,
        "cycle by cycle",
    )?;
    same(
        &at(&mut devices.by_seven, &worlds, &all, false)?,
        &expected,
        "in pieces of seven cycles",
    )?;
    let reversed: Vec<usize> = all.iter().rev().copied().collect();
    let mut found = at(&mut devices.sixteen, &worlds, &reversed, false)?;
    found.0.reverse();
    same(&found, &expected, "16 threads, in another order")?;
    for life in [0, 33] {
        let found = at(&mut devices.alone, &worlds, &[life], false)?;
        same(&found, &(vec![expected.0[life]], Vec::new()), "alone")?;
    }
    let is_turn = |share: u32, of: u32| seed / 8 % share == of % share;
    if is_turn(4, 0) {
        same(
            &at(&mut devices.interpreter, &worlds, &few, true)?,
            &traced,
            "interpreted",
        )?;
    }
    if is_turn(32, 1) {
        same(
            &at(&mut devices.special, &worlds, &all, false)?,
            &expected,
            "by code for its world",
        )?;
        // A kernel of another name has its code in the cache now.
        let again = subject.worlds("second")?;
        same(
            &at(&mut devices.three, &again, &all, false)?,
            &expected,
            "by code from the cache",
        )?;
    }
    if is_turn(36, 2) && subject.is_drawn {
        // 8 lanes, and 4.
        for filler in [5_000, 16_000] {
            let large = self::subject(seed, filler).worlds("large")?;
            let how = format!("with an array of {filler}");
            same(&at(&mut devices.alone, &large, &all, false)?, &expected, &how)?;
        }
    }
    let is_for_gpu = is_turn(gpu_share, 3);
    if !is_for_gpu && !is_turn(12, 4) {
        return Ok(());
    }
    match live(&mut devices.checking, &worlds, &few, false) {
        Ok(found) => same(&found, &untraced, "checked")?,
        Err(Error::Inexact { place, what }) if subject.is_drawn => {
            return Err(format!("it is inexact: {place}: {what}"));
        }
        // The documents say so, and `check --episodes` finds it.
        Err(Error::Inexact { .. }) => {
            count(&tally.inexact);
            return Ok(());
        }
        Err(error) => return Err(error.to_string()),
    }
    #[cfg(feature = "gpu")]
    if let Some(gpu) = devices.gpu.as_mut().filter(|_| is_for_gpu) {
        count(&tally.on_gpu);
        same(&at(gpu, &worlds, &few, true)?, &traced, "on a GPU")?;
    }
    Ok(())
}

/// The first subject of a process that tries some; and how many it tries.
const BLOCK: &str = "ONEIRO_BLOCK";
const BLOCK_SIZE: u32 = 500;

/// Tries subjects in several processes, one after the other: a process keeps all kernels that it has had.
fn in_blocks(parts: u32) {
    for first in (0..parts).step_by(BLOCK_SIZE as usize) {
        let mut block = Command::new(std::env::current_exe().unwrap());
        block
            .args(["whatever_is_accepted", "--nocapture"])
            .env(BLOCK, first.to_string());
        assert!(block.status().unwrap().success(), "parts from {first} on");
    }
}

/// `ONEIRO_SEED` tries one subject alone.
#[test]
fn whatever_is_accepted_has_one_result() {
    let is_long = usize::from(is_long());
    let one: Option<u32> = std::env::var("ONEIRO_SEED")
        .ok()
        .map(|seed| seed.parse().expect("a number"));
    let block: Option<u32> = std::env::var(BLOCK).ok().map(|first| first.parse().expect("a number"));
    if is_long == 1 && one.is_none() && block.is_none() {
        return in_blocks(PARTS[is_long]);
    }
    let seeds = match (one, block) {
        (Some(seed), _) => seed..seed + 1,
        (_, Some(first)) => first..first + BLOCK_SIZE,
        _ => 0..PARTS[is_long],
    };
    let (tally, next, begin) = (Tally::default(), AtomicU32::new(seeds.start), Instant::now());
    count_failures();
    let work = || {
        let mut devices = Devices::new();
        let mut problems = Vec::new();
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if !seeds.contains(&seed) {
                return problems;
            }
            let tried = panic::catch_unwind(AssertUnwindSafe(|| {
                compare(seed, &mut devices, GPU_SHARE[is_long], &tally)
            }));
            if let Err(problem) = tried.unwrap_or_else(|_| Err("the program failed, see above".to_owned())) {
                let texts: Vec<_> = subject(seed, 0).parts.into_iter().map(|(_, text)| text).collect();
                problems.push((format!("seed {seed}: {problem}"), texts));
            }
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, NonZero::get);
    let problems: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        threads
            .into_iter()
            .flat_map(|thread| thread.join().expect("the message is above"))
            .collect()
    });
    let Tally {
        drawn,
        changed,
        inexact,
        refused,
        on_gpu,
    } = &tally;
    eprintln!(
        "{drawn:?} drawn parts and {changed:?} changed ones were accepted, {inexact:?} of these with inexact operations, and {on_gpu:?} \
         tried on a GPU; {refused:?} were refused; {:.1?}",
        begin.elapsed()
    );
    let heads: Vec<_> = problems
        .iter()
        .map(|(head, _)| head.lines().next().unwrap_or_default())
        .collect();
    let first = problems
        .first()
        .map(|(_, texts)| texts.join("\n// The next part:\n"))
        .unwrap_or_default();
    assert!(problems.is_empty(), "{}\nThe first:\n{first}", heads.join("\n"));
    let failed = FAILED.load(Ordering::Relaxed);
    assert!(failed == 0, "Oneiro's own code failed {failed} times, see above");
}

/// How often code of Oneiro's has panicked, on any thread.
static FAILED: AtomicU32 = AtomicU32::new(0);

/// Counts that from now on: a thread that compiles better code during episodes may be abandoned before anyone asks how it ended.
fn count_failures() {
    let before = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        let is_own = |file: &str| ["src/", "shaders/"].iter().any(|folder| file.starts_with(folder));
        if info.location().is_some_and(|place| is_own(place.file())) {
            FAILED.fetch_add(1, Ordering::Relaxed);
        }
        before(info);
    }));
}

/// The results of a sweep by the program, as it writes them: by a number of jobs, in shards, with its cache of kernels empty or filled.
#[test]
fn a_sweep_of_drawn_parts_has_one_result() {
    let place = Place::new("one-hash");
    let run = |arguments: &[&str], cache: &str| {
        let all = [&["sweep", "run", "sweep.toml", "--quiet"], arguments].concat();
        let output = place
            .command(&all)
            .env("XDG_CACHE_HOME", place.at(cache))
            .output()
            .unwrap();
        assert!(output.status.success(), "{all:?}: {output:?}");
    };
    place.write(
        "sweep.toml",
        "experiment = \"drawn.toml\"\nseeds = \"1..3\"\n[grid]\ntask.values.weight = [0.5, 1.25]\n",
    );
    place.write(
        "drawn.toml",
        "cycles = 20\nevolution.generations = 2\n[task]\nkind = \"own\"\npart = \"drawn.wgsl\"\n",
    );
    let texts = (0..).map(|seed| generator::part(Kind::Task, Setting::Alone, seed, 0, 1));
    for (number, text) in texts.filter(|text| text.contains("TaskValues")).take(3).enumerate() {
        place.write("drawn.wgsl", text);
        let out = |how: &str| format!("{number}-{how}");
        let first = out("first");
        run(&["--out", &first, "--jobs", "1"], &out("cache"));
        let results = place.read(format!("{first}/results.csv"));
        for jobs in ["3", "16"] {
            let again = out(jobs);
            run(&["--out", &again, "--jobs", jobs], &out("cache"));
            assert!(
                place.read(format!("{again}/results.csv")) == results,
                "part {number}, {jobs} jobs"
            );
        }
        let shards = [out("one"), out("other")];
        for (shard, out) in ["1/2", "2/2"].iter().zip(&shards) {
            run(&["--out", out, "--shard", shard], out);
        }
        place.good(&["sweep", "merge", &shards[0], &shards[1]]);
        assert!(
            place.read(format!("{}/results.csv", shards[0])) == results,
            "part {number}, in shards"
        );
    }
}
