//! A run reads again everything that it writes: both ends of every range, and odd texts.

use std::cell::RefCell;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use oneiro::parameter::{Allowed, Parameter};
use toml::{Table, Value};

use super::bases::BASES;
use super::{each, folder, names_a_key, read};
use crate::experiment::source::Setting;
use crate::experiment::values::{self, Described};
use crate::experiment::{GREATEST_SEED, settings, swarm};
use crate::runs::{self, Experiment};
use crate::scratch::Scratch;
use crate::sweep::Sweep;

/// A run that ends on a connected robot, in addition to the other bases.
const WIRED: (&str, &str) = (
    "wired",
    "
cycles = 40
[evolution]
population = 4
parents = 2
generations = 3
[reality]
robot = 'tcp:localhost:1000'
generations = 1
starts = 'walk'
walk_s = 10
speed_mm_s = 40
tracker = 'udp:127.0.0.1:5005'
tracker_age_ms = 100
",
);

/// A swarm of foragers whose clock leaves room for short intervals.
const BRIEF: (&str, &str) = (
    "brief clock",
    "
[swarm]
case = 'over'
robots = 4
minutes = 2
clock = { interval_s = 20, offset_s = 0, installed_s = 1 }
",
);

/// Writes an experiment as a run's directory has it, reads it, and returns whether it is the same.
fn is_read_again(experiment: &Arc<dyn Experiment>, seed: u64, scratch: &Scratch) -> Result<(), String> {
    let text = experiment.resolved_toml(seed);
    for input in experiment.single().iter().flat_map(|own| own.inputs()) {
        scratch.write(&input.name, &input.content.bytes);
    }
    let config = scratch.write("config.toml", &text);
    let again = runs::recorded(&config).map_err(|failure| failure.to_string())?;
    let identity = |own: &Arc<dyn Experiment>| own.identities().of(seed).to_hex();
    if again.resolved_toml(seed) == text && identity(&again) == identity(experiment) {
        Ok(())
    } else {
        Err(format!("{text}\nbecomes\n{}", again.resolved_toml(seed)))
    }
}

/// Minimum and maximum of a row; `None` if it has no range, or if the value that it depends on is not given.
fn ends<T>(row: &Parameter<T>, values: &Table) -> Option<[Value; 2]> {
    let whole = |ends: [u64; 2]| Some(ends.map(|end| Value::Integer(end.try_into().expect("TOML has such a number"))));
    match row.allowed {
        Allowed::Whole(least, greatest) => whole([least, greatest]),
        Allowed::WholeUpTo(least, key) => {
            let greatest = values::at(values, key)?.as_integer()?;
            whole([least, greatest.try_into().ok()?])
        }
        Allowed::Number(least, greatest) => Some([least, greatest].map(Value::Float)),
        Allowed::NumberUpTo(least, factor, key) => {
            let limit = values::at(values, key)?;
            let limit = limit.as_float().or(limit.as_integer().map(|limit| limit as f64))?;
            Some([least, factor * limit].map(Value::Float))
        }
        Allowed::Any | Allowed::Text(_) => None,
    }
}

/// An end of a row, alone and in the lists that a key may take.
fn forms(ends: &[Value; 2], end: usize) -> [Value; 4] {
    let alone = &ends[end];
    [
        alone.clone(),
        vec![alone.clone(); 2].into(),
        ends.to_vec().into(),
        vec![alone.clone(); 18].into(),
    ]
}

/// The value between one that is accepted and an end that is not, both excluded; `None` if they are next to each other.
fn between(accepted: &Value, refused: &Value) -> Option<Value> {
    let number = |value: &Value| value.as_float().or(value.as_integer().map(|whole| whole as f64));
    if let (Value::Integer(low), Value::Integer(high)) = (accepted, refused) {
        let middle = low.midpoint(*high);
        return (middle != *low && middle != *high).then(|| middle.into());
    }
    let [low, high] = [number(accepted)?, number(refused)?];
    let middle = 0.5 * (low + high);
    ((middle - low).abs() > 1e-4 * low.abs().max(1e-3)).then(|| middle.into())
}

/// Sets both ends of each row in the first base that takes them, or, where other values are in the way, goes as near to the end as
/// these let it. Returns how many ends were read again, and how many only nearly, and what is wrong.
fn walk<T: Described>(bases: &[(&str, &str)]) -> ([usize; 2], Vec<String>) {
    let bases: Vec<(&str, &str, Table)> = bases
        .iter()
        .map(|(name, text)| (*name, *text, read(text, &[]).unwrap().resolved_toml(0).parse().unwrap()))
        .collect();
    let is_of_range = |row: &&Parameter<T>| !matches!(row.allowed, Allowed::Any | Allowed::Text(_));
    let rows: Vec<_> = T::rows().iter().filter(is_of_range).collect();
    let of_row = |row: &&Parameter<T>| {
        let scratch = Scratch::new(&format!("ends-{}", row.key.replace(['[', ']'], "-")));
        let wrong = RefCell::new(Vec::new());
        let taken = |name: &str, text: &str, path: &str, value: &Value| {
            let words = format!("{name}: {path} = {value}");
            match read(text, &[Setting::at("SET".into(), path, value)]) {
                Err(failure) => {
                    let message = failure.to_string();
                    if failure.code() != 3 || !names_a_key::<T>(&message) {
                        wrong.borrow_mut().push(format!("{words}: {message}"));
                    }
                    false
                }
                Ok(experiment) => {
                    let seed = experiment.seed().unwrap_or(GREATEST_SEED);
                    let again = is_read_again(&experiment, seed, &scratch);
                    wrong
                        .borrow_mut()
                        .extend(again.err().map(|why| format!("{words}: {why}")));
                    true
                }
            }
        };
        // Bases that give the value come first.
        let paths: Vec<Vec<String>> = bases
            .iter()
            .map(|(_, _, values)| {
                let given = |path: &String| values::at(values, path).is_some();
                let mut paths: Vec<String> = (0..8).map(|index| row.name(index)).filter(given).collect();
                paths.dedup();
                paths
            })
            .collect();
        let (mut reached, mut nearly) = (0, 0);
        for end in 0..2 {
            let given = bases
                .iter()
                .zip(&paths)
                .flat_map(|(base, paths)| paths.iter().map(move |path| (base, path.clone())));
            let others = bases.iter().map(|base| (base, row.name(0)));
            let found = given.clone().chain(others).any(|((name, text, values), path)| {
                ends(row, values)
                    .is_some_and(|ends| forms(&ends, end).iter().any(|value| taken(name, text, &path, value)))
            });
            if found {
                reached += 1;
                continue;
            }
            let near = given.clone().any(|((name, text, values), path)| {
                let Some(ends) = ends(row, values) else {
                    return false;
                };
                let (mut accepted, mut refused) = (
                    values::at(values, &path).expect("it is given").clone(),
                    ends[end].clone(),
                );
                let mut is_near = false;
                while let Some(middle) = between(&accepted, &refused) {
                    if taken(name, text, &path, &middle) {
                        (accepted, is_near) = (middle, true);
                    } else {
                        refused = middle;
                    }
                }
                is_near
            });
            nearly += usize::from(near);
            if !near {
                let why = format!("{}: no base takes end {end}, nor another value next to it", row.key);
                wrong.borrow_mut().push(why);
            }
        }
        ([reached, nearly], wrong.into_inner())
    };
    let (mut counts, mut wrong) = ([0; 2], Vec::new());
    for (of_row, more) in each(&rows, of_row) {
        counts = [counts[0] + of_row[0], counts[1] + of_row[1]];
        wrong.extend(more);
    }
    (counts, wrong)
}

#[test]
fn both_ends_of_every_range_are_read_again() {
    let (mut swarms, mut single): (Vec<_>, Vec<_>) = BASES.iter().partition(|(_, text)| text.contains("[swarm]"));
    single.push(WIRED);
    swarms.push(BRIEF);
    let (single, mut wrong) = walk::<settings::Settings>(&single);
    let (swarms, of_swarms) = walk::<swarm::File>(&swarms);
    wrong.extend(of_swarms);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let [reached, nearly] = [single[0] + swarms[0], single[1] + swarms[1]];
    println!("{reached} ends, and {nearly} nearly");
    assert!(reached > 250 && nearly < 60, "{reached} {nearly}");
}

/// The seeds of a sweep, and values in its tables, at both ends.
#[test]
fn the_ends_of_a_sweep_are_read_again() {
    let scratch = Scratch::new("ends-of-sweeps");
    scratch.write(
        "base.toml",
        "cycles = 10\n[evolution]\npopulation = 4\nparents = 2\ngenerations = 2\n",
    );
    scratch.write("foragers.toml", "[swarm]\nrobots = 6\nminutes = 2\n");
    let greatest = GREATEST_SEED;
    for (experiment, key, values) in [
        ("base.toml", "evolution.elite", "0, 2"),
        ("foragers.toml", "swarm.robots", "2, 4"),
    ] {
        for seeds in [
            format!("[0, {greatest}]"),
            "\"0..1\"".to_owned(),
            format!("\"{}..{greatest}\"", greatest - 1),
        ] {
            let text = format!("experiment = '{experiment}'\nseeds = {seeds}\n[grid]\n{key} = [{values}]\n");
            let file = scratch.write("sweep.toml", text);
            let sweep = Sweep::read(&file).unwrap();
            for cell in 0..2 {
                for seed in [0, greatest] {
                    is_read_again(&sweep.cell(cell).unwrap(), seed, &scratch).unwrap();
                }
            }
        }
    }
    for (seeds, random) in [
        (format!("\"0..{}\"", greatest.wrapping_add(1)), ""),
        ("[-1]".to_owned(), ""),
        ("[9223372036854775808]".to_owned(), ""),
        (
            "[1]".to_owned(),
            "[random]\nsamples = 0\nranges.trials = { from = 1, to = 2 }",
        ),
        (
            "[1]".to_owned(),
            "[random]\nsamples = 1\nseed = -1\nranges.trials = { from = 1, to = 2 }",
        ),
        ("[1]".to_owned(), "[reality]\nrobots = [1]\nseverity = -0.1"),
    ] {
        let text = format!("experiment = 'base.toml'\nseeds = {seeds}\n{random}\n");
        let refused = Sweep::read(&scratch.write("sweep.toml", text)).map(|_| ()).unwrap_err();
        assert_eq!(refused.code(), 3, "{refused}");
    }
}

/// Names and files of odd but allowed characters.
#[test]
fn odd_texts_are_read_again() {
    let scratch = Scratch::new("odd-texts");
    let part = fs::read(folder().with_file_name("homing/sensors.wgsl")).unwrap();
    let genomes = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/resolved/genomes.csv")).unwrap();
    for odd in [
        "a b",
        "it's \"so\"",
        "back\\slash",
        "\u{e9}\u{3a9}\u{1f916}",
        "%20;$HOME",
        "-x",
        "..y",
        "#1 = [2]",
    ] {
        scratch.write(&format!("{odd}.wgsl"), &part);
        scratch.write(&format!("{odd}/{odd}.csv"), &genomes);
        let quoted = |text: String| Value::from(text).to_string();
        let part = format!("cycles = 5\n[sensor]\npart = {}\n", quoted(format!("{odd}.wgsl")));
        let init = format!(
            "cycles = 5\n[evolution]\ninit = {}\npopulation = 2\nparents = 1\nelite = 1\ngenerations = 2\n",
            quoted(format!("{odd}/{odd}.csv"))
        );
        for text in [part, init] {
            let again = runs::read(&scratch.write("odd.toml", &text), &[]).map_err(|failure| failure.to_string());
            let again = again.and_then(|experiment| is_read_again(&experiment, 1, &scratch));
            again.unwrap_or_else(|why| panic!("{odd}: {why}"));
        }
        let sensor = quoted(odd.to_owned());
        let text = format!("robot.preset = 'khepera'\nrobot.sensors = [{{ name = {sensor}, range_mm = 60 }}]\n");
        if let Ok(experiment) = runs::read(&scratch.write("sensor.toml", text), &[]) {
            is_read_again(&experiment, 1, &scratch).unwrap();
        }
    }
    for name in ["a", "1.2-3_4", "\u{e9}\u{3a9}", &"x".repeat(100)] {
        let experiment = read(&format!("name = '{name}'"), &[]).unwrap();
        is_read_again(&experiment, 1, &scratch).unwrap();
    }
}
