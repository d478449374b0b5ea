//! Tests: each accepted value has an effect on results.

mod bases;
mod ends;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock, Mutex};
use std::thread;

use oneiro::cpu::Cpu;
use oneiro::parameter::Parameter;
use oneiro_base::exit::Result;
use toml::{Table, Value};

use super::source::{Parsed, Setting};
use super::tried::{names_a_key, others};
use super::values::{self, Described};
use super::{Files, settings, swarm};
use crate::engine::handle::Engine;
use crate::engine::job::{Job, Step};
use crate::engine::scheduler::{Record, Runs, UnderWay, Waiting};
use crate::runs::{self, Experiment, Recording};
use crate::scratch::Scratch;
use crate::sweep::Sweep;
use bases::BASES;

/// A run in memory.
struct Whole {
    experiment: Arc<dyn Experiment>,
    hash: Option<blake3::Hash>,
}

#[derive(Default)]
struct Tables(BTreeMap<&'static str, Vec<u8>>);

impl Record<Box<dyn Job>> for Tables {
    fn add(&mut self, _: &Box<dyn Job>, step: Step) -> Result {
        for added in step.added {
            self.0.entry(added.file).or_default().extend(added.bytes);
        }
        Ok(())
    }
}

impl Runs for Whole {
    type Job = Box<dyn Job>;
    type Record = Tables;

    fn begin(&mut self, _: usize) -> Result<(Self::Job, Tables)> {
        let mut tables = Tables::default();
        for table in self.experiment.tables(Recording::Tables) {
            tables.0.insert(table.file, table.head);
        }
        let seed = self.experiment.seed().unwrap_or(0);
        Ok((Arc::clone(&self.experiment).job(seed, Recording::Tables)?, tables))
    }

    fn finish(&mut self, finished: Vec<UnderWay<Self>>) -> Result {
        for mut own in finished {
            let first = self.experiment.tables(Recording::Tables)[0].file;
            let table = String::from_utf8(own.record.0[first].clone()).expect("a table is text");
            let done = own.job.finish(&table)?;
            let mut hasher = blake3::Hasher::new();
            for (file, bytes) in &own.record.0 {
                hasher.update(file.as_bytes()).update(bytes);
            }
            for (file, bytes) in &done.files {
                hasher.update(file.as_bytes()).update(bytes);
            }
            hasher.update(format!("{:?}", done.outcomes).as_bytes());
            self.hash = Some(hasher.finalize());
        }
        Ok(())
    }

    fn end(&mut self, _: Vec<&mut UnderWay<Self>>) -> Result {
        Ok(())
    }

    fn stopped(&self) -> String {
        String::new()
    }
}

/// Hash of the results of a run.
fn result(experiment: &Arc<dyn Experiment>) -> Result<blake3::Hash> {
    // Interpreting a few cycles is faster than compiling a kernel.
    let is_composed = experiment
        .single()
        .is_some_and(|own| own.world().kernel().variants.is_empty());
    let cpu = Cpu::new(Some(1)).unwrap();
    let cpu = if is_composed && experiment.steps() < 5_000 {
        cpu.with_variant("interpretedx1").unwrap()
    } else {
        cpu
    };
    let engine = Engine::new(Box::new(cpu), Arc::new(AtomicBool::new(false)));
    let mut whole = Whole {
        experiment: Arc::clone(experiment),
        hash: None,
    };
    let waiting = vec![Waiting {
        run: 0,
        kernel: experiment.kernel(),
    }];
    engine.run(waiting, 1, &mut whole, &mut ())?;
    Ok(whole.hash.expect("the run is finished"))
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments/base.toml")
}

fn read(text: &str, set: &[Setting]) -> Result<Arc<dyn Experiment>> {
    static FILES: LazyLock<Files> = LazyLock::new(Files::default);
    let parsed = Parsed::new("base.toml".into(), text)?;
    runs::of(&folder(), &parsed, set, &FILES, None)
}

/// Keys that have no effect on results, with the reason.
const NEVER: &[(&str, &str)] = &[
    ("name", "names files"),
    ("files", "hashes are only compared: each is of a named file, or refused"),
    (
        "test",
        "of `oneiro evaluate --test`, which tests/program/champions.rs has",
    ),
    ("record.checkpoint_every", "when a run is saved"),
    ("record.individuals", "whether every individual is recorded"),
    ("robot.sensors[].name", "names a reading"),
    (
        "reality.starts",
        "of connected robots, which tests/program/real_time/wired.rs has",
    ),
    ("reality.speed_mm_s", "of connected robots"),
    ("reality.walk_s", "of connected robots"),
    ("reality.sensors", "of connected robots"),
    ("reality.tracker", "of connected robots"),
    ("reality.tracker_age_ms", "of connected robots"),
    ("reality.guard", "of connected robots"),
];

/// Keys, or tables with a dot and lists with `[]`, that have no effect in some bases, or in any for the same reason, and the reason.
const SAME: &[(&str, &[&str], &str)] = &[
    (
        "arena.walls[].class",
        &[],
        "an arena is the same whatever robot is in it; only sampled sensors tell classes apart",
    ),
    ("arena.obstacles[].class", &[], "likewise"),
    ("arena.blocks[].class", &[], "likewise"),
    (
        "evolution.limits",
        &[],
        "a bound: it has an effect only on genes that would pass it",
    ),
    (
        "evolution.episodes",
        &["grid"],
        "a bound: a grid of nine genomes needs fewer episodes",
    ),
    (
        "arena.open",
        &["khepera", "parametric"],
        "with listed walls it only says that a robot may leave the arena",
    ),
    (
        "evolution.strategy.restarts",
        &["cma-es", "sep-cma-es", "genes with ranges"],
        "a strategy restarts only after many generations",
    ),
    (
        "evolution.crossover.kind",
        &[],
        "of two generations few children have two parents, and these may differ in no gene that is exchanged",
    ),
    (
        "controller.kind",
        &["files"],
        "a network without layers is a perceptron",
    ),
    (
        "arena.",
        &["flat", "flat, diagonal"],
        "in two cycles no robot finds food",
    ),
    ("robot.", &["flat", "flat, diagonal"], "likewise"),
    (
        "arena.width_mm",
        &["nest"],
        "in four seconds no robot gets from its nest to the wall on the right",
    ),
    (
        "cycles",
        &["flat", "flat, diagonal", "forager with a network"],
        "likewise",
    ),
    (
        "evolution.common_random_numbers",
        &["flat", "flat, diagonal"],
        "likewise",
    ),
    (
        "swarm.messages.line_of_sight",
        &["two cases", "random case", "right simulators", "no light"],
        "of few robots none is between others",
    ),
    (
        "swarm.simulators.pairs",
        &["two cases", "right simulators", "no light"],
        "the best of two and of three pairs is mostly the same",
    ),
    (
        "swarm.simulators.key",
        &["foragers", "two cases", "right simulators"],
        "in a few minutes no robot hears the same pair again, and simulators that are set follow none",
    ),
    (
        "sensor.part",
        &["genes with ranges"],
        "whether a custom controller reads the sensors can't be told",
    ),
    (
        "robot.model",
        &["genes with ranges"],
        "no sensor that the model describes",
    ),
    (
        "robot.signal_range_mm",
        &["state machine"],
        "all robots are within the shortest range",
    ),
    (
        "robot.sensors[].range_mm",
        &["genes with ranges"],
        "all robots are within the shortest range",
    ),
    (
        "arena.start_radius_mm",
        &["model"],
        "the task counts robots on patches, which a millimetre rarely changes",
    ),
    ("arena.height_mm", &["swarm"], "likewise"),
    ("arena.", &["vast"], "no robot gets near its sides"),
    ("start.", &["vast"], "likewise"),
    ("noise.", &["vast"], "likewise"),
    ("robot.", &["nest"], "two robots that meet neither each other nor walls"),
    (
        "arena.floor",
        &["coevolution", "genes with ranges"],
        "only ground sensors see it",
    ),
    (
        "arena.picture.",
        &["coevolution", "genes with ranges"],
        "only ground sensors see it",
    ),
    (
        "arena.patches[]",
        &["parametric"],
        "no robot drives over an edge of them",
    ),
    (
        "sensor.part",
        &["state machine"],
        "whether a custom task reads the sensors can't be told",
    ),
    (
        "evolution.common_random_numbers",
        &["start"],
        "an episode without noise from a given start draws nothing",
    ),
    (
        "robot.collision",
        &["open-es", "recurrent", "parametric surrogate", "custom"],
        "no robot collides in a few cycles",
    ),
    (
        "swarm.arena.food_items",
        &["random case"],
        "in two minutes few items are found",
    ),
    ("swarm.arena.food_scales", &["random case"], "likewise"),
    (
        "swarm.robot.greatest_speed_mm_s",
        &["random case"],
        "robots that search drive slower",
    ),
    (
        "swarm.clock.interval_s",
        &["random case"],
        "only exchanges have intervals",
    ),
    (
        "swarm.messages.heard",
        &["two cases", "right simulators", "no light"],
        "few robots hear each other often enough",
    ),
    (
        "swarm.light_moves_minute",
        &["foragers", "random case"],
        "food before and after it is the same wherever nobody finds any",
    ),
    (
        "swarm.controllers.boundary",
        &["two cases", "right simulators", "no light"],
        "no gene gets to a boundary in three minutes",
    ),
    ("swarm.simulators.boundary", &["no light"], "likewise"),
    ("swarm.controllers.guests", &["no light"], "few robots hear each other"),
    (
        "swarm.simulators.credit",
        &["right simulators"],
        "all simulators are the same",
    ),
    ("robot.contact", &["polygon"], "no robots meet in a few cycles"),
    (
        "reality.differences.slip",
        &["sampled from reality"],
        "no robot collides in a few cycles",
    ),
];

/// All values of an experiment, with its seed or the default one of these tests.
fn resolved(experiment: &Arc<dyn Experiment>) -> String {
    experiment.resolved_toml(experiment.seed().unwrap_or(0))
}

/// The default that a row's text states, if it is a value.
fn stated<T: Described>(row: &Parameter<T>) -> Option<Value> {
    let (_, text) = row.about.split_once("default: ")?;
    let text = text.split(';').next()?.trim_end_matches('.');
    let is_word = text.chars().all(|c| c.is_ascii_lowercase() || "_-".contains(c));
    let line = match text {
        "true" | "false" => format!("x = {text}"),
        word if is_word => format!("x = '{word}'"),
        other => format!("x = {other}"),
    };
    let table: Table = line.parse().ok()?;
    table.get("x").cloned().filter(|value| value.as_str() != Some("none"))
}

/// The effect of a changed value of a key.
#[derive(Clone, Debug)]
enum Found {
    /// No other value was tried.
    Nothing,
    /// Every other value is refused.
    Refused,
    /// Every other value that is allowed gives the same results; one of them.
    Same(String),
    /// It changes results.
    Effect,
}

/// A base, and its results.
struct Base {
    name: &'static str,
    text: &'static str,
    values: Table,
    resolved: String,
    result: blake3::Hash,
}

impl Base {
    fn new(&(name, text): &(&'static str, &'static str)) -> Self {
        let base = read(text, &[]).unwrap_or_else(|failure| panic!("{name}: {failure}"));
        let resolved = resolved(&base);
        Self {
            name,
            text,
            values: resolved.parse().unwrap(),
            resolved,
            result: result(&base).unwrap(),
        }
    }

    fn is_swarm(&self) -> bool {
        self.text.contains("[swarm]")
    }

    /// Changes a row's value, in the elements of a list one after the other, until that has an effect.
    fn walk<T: Described>(&self, row: &Parameter<T>, two: &str) -> Found {
        let count = match row.key.split_once("[]") {
            Some((list, _)) => values::at(&self.values, list)
                .and_then(Value::as_array)
                .map_or(0, Vec::len),
            None => 1,
        };
        let is_listed = reason(row.key, self.name).is_some();
        let mut found = Found::Nothing;
        for path in (0..count).map(|index| row.name(index)) {
            let now = values::at(&self.values, &path);
            let default = stated(row).filter(|_| now.is_none());
            for value in default.iter().cloned().chain(others(row, now)) {
                let value = match value.as_str() {
                    Some("TWO") => two.into(),
                    _ => value,
                };
                let words = format!("{path} = {value}");
                let next = match read(self.text, &[Setting::at("SET".into(), &path, &value)]) {
                    Err(failure) => {
                        let message = failure.to_string();
                        assert!(
                            names_a_key::<T>(&message),
                            "{}: {words} names no key: {message}",
                            self.name
                        );
                        Found::Refused
                    }
                    Ok(other) if resolved(&other) == self.resolved => continue,
                    Ok(other) => {
                        let after =
                            result(&other).unwrap_or_else(|failure| panic!("{}: {words}: {failure}", self.name));
                        if default.as_ref() == Some(&value) {
                            assert_eq!(after, self.result, "{}: {words} is said to be the default", self.name);
                            continue;
                        }
                        if after != self.result {
                            return Found::Effect;
                        }
                        Found::Same(words)
                    }
                };
                if matches!((&found, &next), (Found::Nothing, _) | (Found::Refused, Found::Same(_))) {
                    found = next;
                }
                if is_listed && matches!(found, Found::Same(_)) {
                    return found;
                }
            }
        }
        found
    }
}

/// Why a key may have no effect in a base.
fn reason(key: &str, base: &str) -> Option<&'static str> {
    let never = NEVER.iter().find(|(own, _)| *own == key).map(|(_, reason)| *reason);
    let is_of = |own: &str| own == key || own.ends_with(['.', ']']) && key.starts_with(own);
    let here = SAME
        .iter()
        .find(|(own, bases, _)| is_of(own) && (bases.is_empty() || bases.contains(&base)));
    never.or(here.map(|(.., reason)| *reason))
}

/// Does the same with all items, on as many threads as there are processors. A pool's threads would do other items' work while they
/// wait.
fn each<I: Sync, O: Send>(items: &[I], work: impl Fn(&I) -> O + Sync) -> Vec<O> {
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::new());
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(item) = items.get(index) else {
                        break;
                    };
                    let output = work(item);
                    done.lock().unwrap().push((index, output));
                }
            });
        }
    });
    let mut done = done.into_inner().unwrap();
    done.sort_by_key(|(index, _)| *index);
    done.into_iter().map(|(_, output)| output).collect()
}

/// Every key has an effect on the results in one of the bases, and in each base it has one, or is refused by name. Both lists have
/// the exceptions. All pairs of a key and a base with `ONEIRO_LONG`, else those up to a key's first effect and a sample of the others.
#[test]
fn what_is_accepted_has_an_effect() {
    const SAMPLED: usize = 30;
    fn walk<T: Described>(bases: &[Base], two: &str, is_long: bool) -> Vec<String> {
        let rows: Vec<_> = T::rows()
            .iter()
            .filter(|row| !NEVER.iter().any(|(key, _)| *key == row.key))
            .collect();
        let of_row = |(number, row): &(usize, &&Parameter<T>)| {
            let (mut has_effect, mut wrong) = (false, Vec::new());
            for (index, base) in bases.iter().enumerate() {
                if has_effect && !is_long && (number + index) % SAMPLED != 0 {
                    continue;
                }
                let found = base.walk(row, two);
                match found {
                    Found::Effect => has_effect = true,
                    Found::Same(value) if reason(row.key, base.name).is_none() => {
                        wrong.push(format!("{}: {value} is accepted and has no effect", base.name));
                    }
                    Found::Refused | Found::Same(_) | Found::Nothing => (),
                }
            }
            if !has_effect {
                wrong.push(format!("{} has an effect in no base", row.key));
            }
            wrong
        };
        let numbered: Vec<_> = rows.iter().enumerate().collect();
        each(&numbered, of_row).concat()
    }
    let scratch = Scratch::new("effects");
    let genome = |first: usize| {
        (0..18)
            .map(|gene| format!("0.{}", gene + first))
            .collect::<Vec<_>>()
            .join(",")
    };
    let two = scratch.write("two.csv", [genome(3), genome(1)].join("\n"));
    let two = two.to_str().unwrap();
    let bases = each(&BASES, Base::new);
    let (swarms, single): (Vec<_>, Vec<_>) = bases.into_iter().partition(Base::is_swarm);
    let is_long = std::env::var_os("ONEIRO_LONG").is_some();
    let keys = settings::Settings::rows().len() + swarm::File::rows().len();
    println!("{keys} keys, {} bases", single.len() + swarms.len());
    let mut wrong = walk::<settings::Settings>(&single, two, is_long);
    wrong.extend(walk::<swarm::File>(&swarms, two, is_long));
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A value with absolute paths of its files, so that it means the same wherever it is given.
fn absolute(value: &Value) -> Value {
    let is_file = |text: &str| [".wgsl", ".sam", ".csv"].iter().any(|ending| text.ends_with(ending));
    match value {
        Value::String(text) if is_file(text) => folder().with_file_name(text).to_str().unwrap().into(),
        Value::Array(list) => list.iter().map(absolute).collect::<Vec<_>>().into(),
        other => other.clone(),
    }
}

/// A key has the same effect in a file, by `--set`, and in each table of a sweep; or it is refused by name in all. Python sets values as
/// `--set` does.
#[test]
fn each_place_takes_a_key_alike() {
    /// The result of reading an experiment: all its values, or the key that its refusal names.
    fn told(read: Result<Arc<dyn Experiment>>) -> std::result::Result<String, String> {
        read.map(|own| own.resolved_toml(0))
            .map_err(|failure| failure.to_string())
    }

    fn walk<T: Described>(bases: &[(&str, &str)], two: &str) -> [u32; 2] {
        let of_row = |row: &Parameter<T>| {
            // The first base that takes the key, or else the last one.
            let mut tried = None;
            for (name, text) in bases {
                let values: Table = read(text, &[]).unwrap().resolved_toml(0).parse().unwrap();
                let path = row.name(0);
                let now = values::at(&values, &path);
                for value in others(row, now).into_iter().take(3) {
                    let value = absolute(&if value.as_str() == Some("TWO") {
                        two.into()
                    } else {
                        value
                    });
                    let is_taken = read(text, &[Setting::at("SET".into(), &path, &value)]).is_ok();
                    tried = Some((*name, *text, path.clone(), value));
                    if is_taken {
                        return everywhere(&tried.unwrap());
                    }
                }
            }
            tried.map_or(0, |tried| everywhere(&tried))
        };
        let rows: Vec<_> = T::rows()
            .iter()
            .filter(|row| !["name", "seed"].contains(&row.key))
            .collect();
        let places = each(&rows, |row| of_row(row));
        [rows.len() as u32, places.into_iter().sum()]
    }

    /// Gives a value in each place, and returns how many there were.
    fn everywhere((name, text, path, value): &(&str, &str, String, Value)) -> u32 {
        let scratch = Scratch::new(&format!("places-{}", path.replace(['[', ']'], "-")));
        let folder = folder().with_file_name("");
        let mut text = (*text).to_owned();
        for part in ["homing/", "evostick/", "predator-prey/"] {
            text = text.replace(&format!("'{part}"), &format!("'{}{part}", folder.display()));
        }
        let text = &text;
        let own = scratch.write("base.toml", text);
        let in_toml = path.replace('[', ".").replace(']', "");
        let typed = format!("{in_toml}={value}");
        let by_setting = told(runs::read(&own, std::slice::from_ref(&typed)));
        let mut all = vec![("--set", by_setting)];
        let mut in_file: Table = text.parse().unwrap();
        if !path.contains('[') {
            match value {
                Value::Table(table) => table
                    .iter()
                    .for_each(|(key, value)| values::put(&mut in_file, &format!("{path}.{key}"), value.clone())),
                value => values::put(&mut in_file, path, value.clone()),
            }
            let changed = scratch.write("changed.toml", in_file.to_string());
            let in_file = told(runs::read(&changed, &[]));
            // A setting may make a value of the file needless; one file with both is refused.
            if all[0].1.is_err() || in_file.is_ok() {
                all.push(("file", in_file));
            }
        }
        let table = |head: &str, value: &str| {
            format!("experiment = 'base.toml'\nseeds = [1]\n{head}\n\"{in_toml}\" = {value}\n")
        };
        for (place, text) in [
            ("set", table("[set]", &value.to_string())),
            ("grid", table("[grid]", &format!("[{value}]"))),
            ("list", table("[[list]]", &value.to_string())),
        ] {
            let file = scratch.write("sweep.toml", text);
            let cell = Sweep::read(&file).and_then(|sweep| sweep.cell(0));
            all.push((place, told(cell)));
        }
        let (_, first) = all[0].clone();
        for (place, told) in &all {
            match (&first, told) {
                (Ok(first), Ok(told)) => {
                    let without_name = |text: &str| text.lines().skip(1).collect::<Vec<_>>().join("\n");
                    assert_eq!(without_name(first), without_name(told), "{name}: {typed} in {place}");
                }
                (Err(_), Err(refused)) => {
                    let last = path.rsplit(['.', ']']).find(|part| !part.is_empty()).unwrap_or(path);
                    assert!(refused.contains(last), "{name}: {typed} in {place}: {refused}");
                }
                other => panic!("{name}: {typed} in {place}: {other:?}"),
            }
        }
        all.len() as u32
    }

    let scratch = Scratch::new("places");
    let genome = |first: usize| {
        (0..18)
            .map(|gene| format!("0.{}", gene + first))
            .collect::<Vec<_>>()
            .join(",")
    };
    let two = scratch.write("two.csv", [genome(3), genome(1)].join("\n"));
    let (swarms, single): (Vec<_>, Vec<_>) = BASES.iter().partition(|(_, text)| text.contains("[swarm]"));
    let single: Vec<_> = single.into_iter().filter(|(_, text)| !text.contains("../")).collect();
    let [keys, places] = walk::<settings::Settings>(&single, two.to_str().unwrap());
    let [swarm_keys, swarm_places] = walk::<swarm::File>(&swarms, two.to_str().unwrap());
    println!("{} keys, {} places", keys + swarm_keys, places + swarm_places);
    assert!(places + swarm_places > 6 * 200);
}
