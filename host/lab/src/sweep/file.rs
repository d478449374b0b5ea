//! Sweep files: the keys and values to sweep, and the seeds.
//!
//! ```toml
//! name = "noise"                              # default: the file's name
//! experiment = "khepera-avoidance.toml"       # relative to this file
//! seeds = "1..20"                             # or a list
//!
//! [set]                                       # values that replace the experiment's in all runs
//! evolution.generations = 100
//!
//! [grid]                                      # every combination of these
//! noise.sensor = [[0.0, 0.0], [0.0, 0.4]]
//! evolution.population = [20, 100]
//! "evolution.initial, evolution.limits" = [[-1.0, 1.0], [-5.0, 5.0]]      # one value for both keys
//!
//! [[list]]                                    # combined with each of these rows, whose keys may differ
//! evolution.parents = 5
//! evolution.elite = 1
//!
//! [random]                                    # and with each random draw from these ranges
//! samples = 50
//! seed = 1
//! [random.ranges]
//! evolution.mutation.rate = { from = 0.0, to = 0.5 }
//! evolution.mutation.amount = { from = 0.01, to = 10.0, scale = "log" }
//!
//! [reality]                                   # episodes of each run's last offspring in surrogates of the robot
//! robots = [1]
//! severity = 1.75
//! ```

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use oneiro_base::exit::{Failure, Result};
use oneiro_evolve::random::{Stream, Uniform, logarithm, stream};
use rand::distr::Distribution;
use serde::Deserialize;
use toml::{Table, Value};

use crate::experiment::degrees::in_turns;
use crate::experiment::kinds::FileKind;
use crate::experiment::settings::Settings;
use crate::experiment::source::{Parsed, Setting, Source};
use crate::experiment::{GREATEST_SEED, check_name};
use crate::reality::site::SEVERITY;
use crate::threads;

/// Maximum number of runs in a sweep.
pub const GREATEST_RUNS: u64 = 10_000_000;
/// Maximum number of seeds, and of draws from ranges.
const GREATEST_COUNT: u64 = 1_000_000;

/// Keys of a sweep file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    #[serde(default)]
    name: String,
    // Both must be given; a file that lacks one is refused with this program's own message.
    experiment: Option<String>,
    seeds: Option<Value>,
    seeds_by: Option<String>,
    #[serde(default)]
    set: Table,
    #[serde(default)]
    grid: Table,
    #[serde(default)]
    list: Vec<Table>,
    random: Option<WrittenRandom>,
    reality: Option<Reality>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenRandom {
    samples: u32,
    #[serde(default)]
    seed: u64,
    ranges: Table,
}

/// The reality of each run's last offspring: surrogates of the sampled robot, as in the 1995 study.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reality {
    /// The robots.
    pub robots: Robots,
    /// How much surrogates differ from the simulator, if given.
    severity: Option<f32>,
}

impl Reality {
    /// How much numbered surrogates differ from the simulator.
    pub fn severity(&self) -> f32 {
        self.severity.unwrap_or(SEVERITY)
    }
}

/// The robots of reality.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(
    untagged,
    expecting = "is of another type; allowed: \"own\" or a list of whole numbers"
)]
pub enum Robots {
    /// Numbers of surrogates, each of them another robot in other surroundings.
    Numbered(Vec<u64>),
    /// `"own"`: for each run, the robot of its last generations.
    Own(Own),
}

/// The word `"own"`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Own {
    Own,
}

/// Some keys and the values they take in cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Keys in the order of the file.
    pub keys: Vec<String>,
    /// Whether all keys always share one value, and so count as one factor.
    pub is_shared: bool,
    /// For each level, the value of each key, if it has that.
    pub levels: Vec<Vec<Option<Placed>>>,
}

/// A value and its place in the file.
pub type Placed = (Value, String);

impl Axis {
    /// The keys that distinguish its levels.
    pub fn factors(&self) -> &[String] {
        if self.is_shared { &self.keys[..1] } else { &self.keys }
    }
}

/// A sweep file, checked as far as possible without the experiment.
#[derive(Debug)]
pub struct SweepFile {
    pub name: String,
    /// The experiment as the file names it, and the place where it does.
    pub experiment: String,
    pub(crate) experiment_place: String,
    pub seeds: Vec<u64>,
    pub seeds_place: String,
    /// The axis whose levels have different seeds, and what is added to each level's seeds.
    seeds_by: Option<(usize, Vec<u64>)>,
    /// Values that all runs share.
    set: Vec<Setting>,
    /// The sweep's cells are all combinations of their levels; the last axis varies fastest.
    pub axes: Vec<Axis>,
    pub reality: Option<Reality>,
    pub(crate) reality_place: String,
    /// Folder of the files that its values name.
    folder: PathBuf,
}

impl SweepFile {
    /// Reads and checks a sweep file. The files that its values name are in `folder`.
    ///
    /// # Errors
    /// Exit 3: the file, the line and column in it, the problem and the allowed values.
    pub(crate) fn read(path: &Path, folder: &Path) -> Result<Self> {
        // All threads will work on the cells.
        threads::prepare();
        let text = FileKind::Sweep.text(path)?;
        let file = FileKind::Sweep.parsed(path, &text)?;
        Self::of(&file, &path.file_stem().unwrap_or_default().to_string_lossy(), folder)
    }

    /// Checks a file's values; the sweep is called `name` if the file doesn't name it.
    fn of(file: &Parsed<'_>, name: &str, folder: &Path) -> Result<Self> {
        let (written, source): (Written, _) = Source::read(file, &[])?;
        let lacks = |key: &str, example: &str| {
            let file = source.place_of(key);
            Failure::input(format_args!(
                "{file}: the sweep lacks `{key}`; allowed: {key} = {example}"
            ))
        };
        let experiment = written.experiment.ok_or_else(|| lacks("experiment", "\"FILE.toml\""))?;
        let seeds = written.seeds.ok_or_else(|| lacks("seeds", "\"1..20\", or a list"))?;
        let seeds = self::seeds(&seeds, &source)?;
        let set = leaves("set", &written.set, &source)?;
        let mut axes = Vec::new();
        axes.extend(list(&written.list, &source)?);
        for leaf in leaves("grid", &written.grid, &source)? {
            axes.push(axis(leaf, &source)?);
        }
        if let Some(random) = &written.random {
            axes.push(drawn(random, &source)?);
        }
        conflicts(&set, &axes)?;
        let seeds_by = written.seeds_by.as_deref();
        let seeds_by = seeds_by.map(|key| blocks(key, &axes, &seeds, &source)).transpose()?;
        if let Some(reality) = &written.reality {
            check_reality(reality, &source)?;
        }
        let cells = axes
            .iter()
            .try_fold(1_u64, |cells, axis| cells.checked_mul(axis.levels.len() as u64));
        let runs = cells.and_then(|cells| cells.checked_mul(seeds.len() as u64));
        if runs.is_none_or(|runs| runs > GREATEST_RUNS) {
            let count = runs.map_or_else(|| "more than can be counted".into(), |runs| runs.to_string());
            return Err(source.invalid(
                "seeds",
                format_args!("make {count} runs with all combinations of values; allowed: up to {GREATEST_RUNS}"),
            ));
        }
        let name = if written.name.is_empty() {
            name.to_owned()
        } else {
            written.name
        };
        check_name(&name).map_err(|problem| source.invalid("name", problem))?;
        Ok(Self {
            name,
            experiment_place: source.place_of("experiment"),
            experiment,
            seeds,
            seeds_place: source.place_of("seeds"),
            seeds_by,
            set: set
                .iter()
                .map(|leaf| Setting::at(leaf.place.clone(), &leaf.key, &leaf.value).in_folder(folder))
                .collect(),
            axes,
            reality: written.reality,
            reality_place: source.place_of("reality"),
            folder: folder.to_owned(),
        })
    }

    /// The values that a cell changes in the experiment.
    pub(crate) fn settings(&self, cell: usize) -> Vec<Setting> {
        let swept = self.keys().zip(self.values(cell));
        let setting = |(key, value): (&str, Option<&Placed>)| {
            let (value, place) = value?;
            Some(Setting::at(place.clone(), key, value).in_folder(&self.folder).swept())
        };
        let swept = swept.filter_map(setting);
        self.set.iter().cloned().chain(swept).collect()
    }

    /// The seeds of a cell's runs.
    pub(crate) fn seeds_of(&self, cell: usize) -> impl Iterator<Item = u64> {
        let block = self.seeds_by.as_ref().map_or(0, |(axis, blocks)| {
            let after: usize = self.axes[axis + 1..].iter().map(|axis| axis.levels.len()).product();
            blocks[cell / after % self.axes[*axis].levels.len()]
        });
        self.seeds.iter().map(move |seed| seed + block)
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.axes.iter().map(|axis| axis.levels.len()).product()
    }

    /// Place of a swept key's value in a cell.
    pub(crate) fn place_in(&self, cell: usize, key: &str) -> Option<&str> {
        let (_, value) = self.keys().zip(self.values(cell)).find(|(own, _)| *own == key)?;
        value.map(|(_, place)| place.as_str())
    }

    /// Number of cells that have a swept key's value from this place.
    pub(crate) fn cells_with(&self, key: &str, place: &str) -> usize {
        let cells = 0..self.cells();
        cells.filter(|cell| self.place_in(*cell, key) == Some(place)).count()
    }

    /// The swept keys, in the order of the axes.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        self.axes.iter().flat_map(|axis| &axis.keys).map(String::as_str)
    }

    /// Values of the swept keys in a cell, in the order of [`SweepFile::keys`]; none for keys that only other rows of a list have.
    pub(crate) fn values(&self, cell: usize) -> Vec<Option<&Placed>> {
        let mut rest = cell;
        let mut levels = vec![0; self.axes.len()];
        for (level, axis) in levels.iter_mut().zip(&self.axes).rev() {
            *level = rest % axis.levels.len();
            rest /= axis.levels.len();
        }
        self.axes
            .iter()
            .zip(levels)
            .flat_map(|(axis, level)| &axis.levels[level])
            .map(Option::as_ref)
            .collect()
    }
}

/// A key of an experiment with its value, from a table with dotted, quoted or nested keys.
#[derive(Clone, Debug)]
struct Leaf {
    key: String,
    value: Value,
    place: String,
}

/// The values below a table of the file, in the order of the file.
fn leaves(table: &str, values: &Table, source: &Source<'_>) -> Result<Vec<Leaf>> {
    type IsLeaf<'a> = &'a dyn Fn(&str, &Table) -> bool;
    fn collect(prefix: &str, values: &Table, is_leaf: IsLeaf<'_>, leaves: &mut Vec<(String, Value)>) {
        for (key, value) in values {
            let key = if prefix.is_empty() {
                key.clone()
            } else {
                format!("{prefix}.{key}")
            };
            match value {
                Value::Table(table) if !is_leaf(&key, table) => collect(&key, table, is_leaf, leaves),
                _ => leaves.push((key, value.clone())),
            }
        }
    }
    let is_leaf = |key: &str, values: &Table| {
        let is_range = table == RANGES && values.contains_key("from");
        is_range || BY_KEY.contains(&key)
    };
    let mut found = Vec::new();
    collect("", values, &is_leaf, &mut found);
    let mut leaves: Vec<(Option<usize>, Leaf)> = found
        .into_iter()
        .map(|(key, value)| {
            let path = format!("{table}.{key}");
            let place = source.place_of(&path);
            (source.start_of(&path), Leaf { key, value, place })
        })
        .collect();
    leaves.sort_by_key(|(start, _)| *start);
    for (_, leaf) in &leaves {
        let is_meant = |(key, _): &&(&str, &str)| leaf.key.split(',').any(|own| own.trim() == *key);
        if let Some((_, meant)) = RESERVED.iter().find(is_meant) {
            return Err(source.invalid(&format!("{table}.{}", leaf.key), meant));
        }
    }
    Ok(leaves.into_iter().map(|(_, leaf)| leaf).collect())
}

/// Keys of experiments that have another place in a sweep file.
const RESERVED: [(&str, &str); 2] = [
    (
        "seed",
        "can't be set or swept; allowed: the key seeds, above all tables",
    ),
    ("name", "can't be set or swept; allowed: the experiment's own name"),
];
const RANGES: &str = "random.ranges";
/// Keys whose values are tables of an experiment's other keys.
const BY_KEY: [&str; 2] = ["worlds.vary", "worlds.choose"];

fn seeds(seeds: &Value, source: &Source<'_>) -> Result<Vec<u64>> {
    let refused = |problem: String| Err(source.invalid("seeds", problem));
    match seeds {
        Value::String(text) => {
            let ends = text.split_once("..").and_then(|(first, last)| {
                let number = |text: &str| text.trim().parse::<u64>().ok().filter(|&seed| seed <= GREATEST_SEED);
                Some((number(first)?, number(last)?))
            });
            match ends {
                Some((first, last)) if first <= last && last - first < GREATEST_COUNT => Ok((first..=last).collect()),
                Some((first, last)) if first > last => refused(format!(
                    "is \"{text}\", an empty range; allowed: the smaller seed first"
                )),
                _ => refused(format!(
                    "is \"{text}\"; allowed: \"A..B\", both included, at most {GREATEST_COUNT} seeds up to {GREATEST_SEED}"
                )),
            }
        }
        Value::Array(list) => {
            if list.is_empty() {
                return refused("is empty; allowed: one seed and more".into());
            }
            let mut known = BTreeSet::new();
            let seed = |(index, value): (usize, &Value)| {
                let seed = value.as_integer().and_then(|seed| u64::try_from(seed).ok());
                let problem = match seed {
                    Some(seed) if known.insert(seed) => return Ok(seed),
                    Some(seed) => format!("is {seed} a second time; allowed: each seed once"),
                    None => format!("is {value}; allowed: a whole number from 0"),
                };
                Err(source.invalid(&format!("seeds[{index}]"), problem))
            };
            list.iter().enumerate().map(seed).collect()
        }
        other => refused(format!("is {other}; allowed: \"A..B\" or a list of whole numbers")),
    }
}

/// The axis of a key whose values have different seeds, and what is added to each level's seeds.
fn blocks(key: &str, axes: &[Axis], seeds: &[u64], source: &Source<'_>) -> Result<(usize, Vec<u64>)> {
    let place = |axis: &Axis| axis.keys.iter().position(|own| own == key);
    let Some((axis, index)) = axes
        .iter()
        .enumerate()
        .find_map(|(axis, own)| Some((axis, place(own)?)))
    else {
        let swept: Vec<&str> = axes.iter().flat_map(|axis| &axis.keys).map(String::as_str).collect();
        let problem = format!("is {key:?}, which is not swept; allowed: {}", swept.join(", "));
        return Err(source.invalid("seeds_by", problem));
    };
    let (least, greatest) = (seeds.iter().min().unwrap_or(&0), seeds.iter().max().unwrap_or(&0));
    let mut values: Vec<String> = Vec::new();
    let mut block = |level: &Vec<Option<Placed>>| {
        let value = level[index]
            .as_ref()
            .map_or_else(String::new, |(value, _)| value.to_string());
        let known = values.iter().position(|known| *known == value).unwrap_or(values.len());
        if known == values.len() {
            values.push(value);
        }
        (greatest - least + 1).checked_mul(known as u64)
    };
    let blocks: Option<Vec<u64>> = axes[axis].levels.iter().map(&mut block).collect();
    let is_known = |blocks: &Vec<u64>| {
        let last = blocks.iter().max().and_then(|block| greatest.checked_add(*block));
        last.is_some_and(|last| last <= GREATEST_SEED)
    };
    let blocks = blocks.filter(is_known).ok_or_else(|| {
        let problem = format!("makes seeds beyond {GREATEST_SEED}; allowed: smaller seeds, or fewer values of {key}");
        source.invalid("seeds_by", problem)
    })?;
    Ok((axis, blocks))
}

/// The axis of a grid key.
fn axis(leaf: Leaf, source: &Source<'_>) -> Result<Axis> {
    let path = format!("grid.{}", leaf.key);
    let Value::Array(values) = leaf.value else {
        return Err(source.invalid(&path, "is one value; allowed: a list of them, or the table [set]"));
    };
    if values.is_empty() {
        return Err(source.invalid(&path, "is empty; allowed: a list of values"));
    }
    let mut known = BTreeSet::new();
    for (index, value) in values.iter().enumerate() {
        if !known.insert(value.to_string()) {
            return Err(source.invalid(
                &format!("{path}[{index}]"),
                format_args!("is {value} a second time; allowed: each value once"),
            ));
        }
    }
    let keys: Vec<String> = leaf.key.split(',').map(|key| key.trim().to_owned()).collect();
    let level = |(index, value): (usize, Value)| {
        let place = source.place_of(&format!("{path}[{index}]"));
        vec![Some((value, place)); keys.len()]
    };
    Ok(Axis {
        is_shared: true,
        levels: values.into_iter().enumerate().map(level).collect(),
        keys,
    })
}

/// The axis of the rows of `[[list]]`, if there are any: its keys are those of all rows.
fn list(rows: &[Table], source: &Source<'_>) -> Result<Option<Axis>> {
    let mut keys: Vec<String> = Vec::new();
    let mut levels: Vec<Vec<Option<Placed>>> = Vec::new();
    for (index, row) in rows.iter().enumerate() {
        let table = format!("list[{index}]");
        let leaves = leaves(&table, row, source)?;
        if leaves.is_empty() {
            return Err(source.invalid(&table, "is empty; allowed: keys with a value each"));
        }
        let mut level = vec![None; keys.len()];
        for Leaf { key, value, place } in leaves {
            if let Some(known) = keys.iter().position(|known| *known == key) {
                level[known] = Some((value, place));
            } else {
                keys.push(key);
                level.push(Some((value, place)));
            }
        }
        // Rows above may lack the last keys.
        let value = |level: &[Option<Placed>], key: usize| Some(level.get(key)?.as_ref()?.0.clone());
        if levels
            .iter()
            .any(|other| (0..keys.len()).all(|key| value(other, key) == value(&level, key)))
        {
            return Err(source.invalid(&table, "is there a second time; allowed: each row once"));
        }
        levels.push(level);
    }
    for level in &mut levels {
        level.resize(keys.len(), None);
    }
    Ok((!levels.is_empty()).then_some(Axis {
        keys,
        is_shared: false,
        levels,
    }))
}

/// A range to draw from.
#[derive(Clone, Copy, Debug)]
enum Range {
    Whole(i64, i64),
    Linear(f64, f64),
    Log(f64, f64),
}

impl Range {
    fn read(value: &Value) -> std::result::Result<Self, String> {
        let allowed = "allowed: { from = A, to = B } with A below B, and scale = \"linear\" or \"log\"";
        let Value::Table(table) = value else {
            return Err(format!("is {value}; {allowed}"));
        };
        if let Some(key) = table
            .keys()
            .find(|key| !["from", "to", "scale"].contains(&key.as_str()))
        {
            return Err(format!("has a key {key}; {allowed}"));
        }
        let number = |key| match table.get(key) {
            Some(Value::Integer(number)) => Some(*number as f64),
            Some(Value::Float(number)) if number.is_finite() => Some(*number),
            _ => None,
        };
        let (Some(from), Some(to)) = (number("from"), number("to")) else {
            return Err(format!("is {value}; {allowed}"));
        };
        if from >= to {
            return Err(format!("is an empty range, {from} to {to}; {allowed}"));
        }
        let scale = match table.get("scale") {
            None => "linear",
            Some(scale) => scale.as_str().unwrap_or_default(),
        };
        match (scale, table.get("from"), table.get("to")) {
            ("log", ..) if from <= 0.0 => Err(format!("begins with {from}; allowed: above 0 where scale is \"log\"")),
            ("log", ..) => Ok(Self::Log(from, to)),
            ("linear", Some(Value::Integer(from)), Some(Value::Integer(to))) => Ok(Self::Whole(*from, *to)),
            ("linear", ..) => Ok(Self::Linear(from, to)),
            _ => Err(format!("has another scale; {allowed}")),
        }
    }

    /// Draws a number: integers include both ends, other numbers have six significant digits.
    fn draw(self, random: &mut rand_pcg::Pcg64) -> Value {
        let mut within = |low, high| Uniform { low, high }.sample(random);
        let number = match self {
            Self::Whole(from, to) => {
                let drawn = within(from as f64, to as f64 + 1.0).floor() as i64;
                return Value::Integer(drawn.min(to));
            }
            Self::Linear(from, to) => within(from, to),
            Self::Log(from, to) => oneiro::exact::exponential(within(logarithm(from), logarithm(to))),
        };
        let short = format!("{number:.5e}").parse().unwrap_or(number);
        let (Self::Linear(from, to) | Self::Log(from, to)) = self else {
            return Value::Float(short);
        };
        Value::Float(short.clamp(from, to))
    }
}

/// The axis of random draws.
fn drawn(random: &WrittenRandom, source: &Source<'_>) -> Result<Axis> {
    if !(1..=GREATEST_COUNT).contains(&u64::from(random.samples)) {
        let problem = format!("is {}; allowed: 1 to {GREATEST_COUNT}", random.samples);
        return Err(source.invalid("random.samples", problem));
    }
    let leaves = leaves(RANGES, &random.ranges, source)?;
    if leaves.is_empty() {
        return Err(source.invalid(RANGES, "is empty; allowed: keys with { from = A, to = B } each"));
    }
    let ranges = leaves
        .iter()
        .map(|leaf| {
            Range::read(&leaf.value).map_err(|problem| source.invalid(&format!("{RANGES}.{}", leaf.key), problem))
        })
        .collect::<Result<Vec<_>>>()?;
    let mut numbers = stream(random.seed, Stream::Samples, 0);
    let mut known = BTreeSet::new();
    let mut levels = Vec::with_capacity(random.samples as usize);
    // Repeated draws, which are likely in small integer ranges, are drawn again.
    for _ in 0..100 * u64::from(random.samples) {
        if levels.len() == random.samples as usize {
            break;
        }
        let level: Vec<Value> = ranges.iter().map(|range| range.draw(&mut numbers)).collect();
        if known.insert(format!("{level:?}")) {
            levels.push(
                level
                    .into_iter()
                    .zip(&leaves)
                    .map(|(value, leaf)| Some((value, leaf.place.clone())))
                    .collect(),
            );
        }
    }
    if levels.len() < random.samples as usize {
        let problem = format!(
            "is {}, but only {} different draws were found; allowed: as many as the ranges hold",
            random.samples,
            levels.len()
        );
        return Err(source.invalid("random.samples", problem));
    }
    Ok(Axis {
        keys: leaves.into_iter().map(|leaf| leaf.key).collect(),
        is_shared: false,
        levels,
    })
}

/// Refuses keys that occur twice, or together with a part of them.
fn conflicts(set: &[Leaf], axes: &[Axis]) -> Result {
    let swept = axes.iter().flat_map(|axis| {
        axis.keys.iter().enumerate().filter_map(|(index, key)| {
            let (_, place) = axis.levels.iter().find_map(|level| level[index].as_ref())?;
            Some((key, place))
        })
    });
    let all = set.iter().map(|leaf| (&leaf.key, &leaf.place)).chain(swept);
    // Degrees and turns are one key.
    let all: Vec<(String, &String)> = all
        .map(|(key, place)| (in_turns::<Settings>(key).unwrap_or_else(|| key.clone()), place))
        .collect();
    for (index, (key, place)) in all.iter().enumerate() {
        let holds = |outer: &str, inner: &str| {
            inner
                .strip_prefix(outer)
                .is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        if let Some((other, first)) = all[..index]
            .iter()
            .find(|(other, _)| holds(other, key) || holds(key, other))
        {
            return Err(Source::conflict(key, place, other, first));
        }
    }
    Ok(())
}

fn check_reality(reality: &Reality, source: &Source<'_>) -> Result {
    let Robots::Numbered(robots) = &reality.robots else {
        if reality.severity.is_some() {
            let problem = "is given with robots = \"own\"; allowed: the experiment's reality.severity";
            return Err(source.invalid("reality.severity", problem));
        }
        return Ok(());
    };
    if robots.is_empty() {
        return Err(source.invalid(
            "reality.robots",
            "is empty; allowed: numbers of surrogates, such as [1]",
        ));
    }
    if let Some(twice) = (1..robots.len()).find(|&index| robots[..index].contains(&robots[index])) {
        return Err(source.invalid(
            &format!("reality.robots[{twice}]"),
            "is there a second time; allowed: each once",
        ));
    }
    if !(0.0..=10.0).contains(&reality.severity()) {
        let problem = format!("is {}; allowed: 0 to 10", reality.severity());
        return Err(source.invalid("reality.severity", problem));
    }
    Ok(())
}

#[cfg(test)]
mod tests {

    use super::*;

    fn read(text: &str) -> Result<SweepFile> {
        let text = format!("experiment = \"e.toml\"\n{text}");
        SweepFile::of(&Parsed::new("s.toml".into(), &text)?, "s", Path::new("/sweeps"))
    }

    fn refusal(text: &str) -> String {
        read(text).map(|_| ()).unwrap_err().to_string()
    }

    /// The last axis varies fastest: lists, then the grid in the order of the file, then random draws.
    #[test]
    fn cells_are_all_combinations_in_the_order_of_the_file() {
        let file = read(
            "seeds = \"3..4\"\n[grid]\nnoise.motor = [0.1, 0.2]\n\"a.x, a.y\" = [1, 2, 3]\n\
             [[list]]\nb = \"u\"\nc.d = 1\n[[list]]\nc = { d = 2 }\nb = \"v\"\n",
        )
        .unwrap();
        assert_eq!(file.seeds, [3, 4]);
        assert_eq!(
            file.keys().collect::<Vec<_>>(),
            ["b", "c.d", "noise.motor", "a.x", "a.y"]
        );
        assert_eq!(file.cells(), 12);
        let values = |cell| {
            let values = file.values(cell).into_iter();
            let words: Vec<String> = values
                .map(|value| value.map_or("-".into(), |(value, _)| value.to_string()))
                .collect();
            words.join(" ")
        };
        assert_eq!(values(0), "\"u\" 1 0.1 1 1");
        assert_eq!(values(1), "\"u\" 1 0.1 2 2");
        assert_eq!(values(3), "\"u\" 1 0.2 1 1");
        assert_eq!(values(11), "\"v\" 2 0.2 3 3");
        let factors: Vec<&String> = file.axes.iter().flat_map(Axis::factors).collect();
        assert_eq!(factors, ["b", "c.d", "noise.motor", "a.x"]);
    }

    #[test]
    fn rows_of_a_list_may_have_different_keys() {
        let text = "seeds = [1]\nseeds_by = \"b\"\n[[list]]\na = 1\nb = 2\n[[list]]\nc = 3\nb = 3\n[[list]]\na = 1\n";
        let file = read(text).unwrap();
        assert_eq!(file.keys().collect::<Vec<_>>(), ["a", "b", "c"]);
        let values = |cell| {
            file.values(cell)
                .into_iter()
                .map(|value| value?.0.as_integer())
                .collect::<Vec<_>>()
        };
        let rows = [
            [Some(1), Some(2), None],
            [None, Some(3), Some(3)],
            [Some(1), None, None],
        ];
        assert!((0..3).all(|cell| values(cell) == rows[cell]));
        assert_eq!(
            (0..3).map(|cell| file.settings(cell).len()).collect::<Vec<_>>(),
            [2, 2, 1]
        );
        // A row without the key has seeds of its own.
        assert_eq!(
            (0..3)
                .map(|cell| file.seeds_of(cell).next().unwrap())
                .collect::<Vec<_>>(),
            [1, 2, 3]
        );
        for (more, refused) in [
            ("[[list]]\na = 1\n", "list[3]: is there a second time"),
            ("[[list]]\nd = 1\n[grid]\nd.e = [1]\n", "d.e: is already given, as d"),
        ] {
            let found = refusal(&format!("{text}{more}"));
            assert!(found.contains(refused), "{found}");
        }
    }

    /// All levels of the same value share seeds, whatever else is swept.
    #[test]
    fn values_of_a_key_have_seeds_of_their_own() {
        let text = "seeds = [5, 3]\nseeds_by = \"b\"\n[grid]\na = [1, 2]\n[[list]]\nb = \"u\"\nc = 1\n[[list]]\nb = \"v\"\nc = 1\n\
                    [[list]]\nb = \"u\"\nc = 2\n";
        let file = read(text).unwrap();
        let seeds: Vec<Vec<u64>> = (0..6).map(|cell| file.seeds_of(cell).collect()).collect();
        assert_eq!(seeds, [[5, 3], [5, 3], [8, 6], [8, 6], [5, 3], [5, 3]]);
        let refused = refusal(&text.replace("\"b\"\n", "\"d\"\n"));
        assert!(
            refused.contains("s.toml:3:12: seeds_by: is \"d\", which is not swept; allowed: b, c, a"),
            "{refused}"
        );
        let refused = refusal(&text.replace("[5, 3]", "[9223372036854775806, 3]"));
        assert!(
            refused.contains("seeds_by: makes seeds beyond 9223372036854775807"),
            "{refused}"
        );
    }

    #[test]
    fn the_robot_of_each_run_needs_no_severity() {
        let own = |more: &str| read(&format!("seeds = [1]\n[reality]\nrobots = \"own\"\n{more}"));
        assert!(matches!(own("").unwrap().reality.unwrap().robots, Robots::Own(_)));
        let refused = own("severity = 1.0").unwrap_err().to_string();
        assert!(
            refused.contains("s.toml:5:12: reality.severity: is given with robots = \"own\""),
            "{refused}"
        );
    }

    /// Changing these draws would change every sweep that has any.
    #[test]
    fn draws_are_known_and_within_their_ranges() {
        let file = read(
            "seeds = [1]\n[random]\nsamples = 1000\nseed = 7\n[random.ranges]\n\
             a = { from = -1.0, to = 2.0 }\nb = { from = 0.001, to = 1000.0, scale = \"log\" }\nc = { from = 1, to = 3 }\n",
        )
        .unwrap();
        let draws: Vec<[f64; 3]> = (0..1000)
            .map(|cell| {
                let values = file.values(cell);
                std::array::from_fn(|key| match &values[key].unwrap().0 {
                    Value::Integer(whole) => *whole as f64,
                    other => other.as_float().unwrap(),
                })
            })
            .collect();
        assert!(draws.iter().all(|[a, b, c]| {
            (-1.0..=2.0).contains(a) && (0.001..=1000.0).contains(b) && [1.0, 2.0, 3.0].contains(c)
        }));
        let share = |is: &dyn Fn(&[f64; 3]) -> bool| draws.iter().filter(|draw| is(draw)).count();
        // Half of the logarithmic draws are below the middle of the exponents, and every integer occurs.
        assert!((440..560).contains(&share(&|draw| draw[1] < 1.0)));
        assert!((440..560).contains(&share(&|draw| draw[0] < 0.5)));
        assert!((1..=3).all(|whole| (270..400).contains(&share(&|draw| draw[2] == f64::from(whole)))));
        assert_eq!(format!("{:?}", draws[0]), "[1.18352, 92.2018, 2.0]");
    }

    #[test]
    fn few_whole_numbers_are_each_drawn_once() {
        let text = "seeds = [1]\n[random]\nsamples = 4\n[random.ranges]\na = { from = 1, to = 4 }\n";
        let file = read(text).unwrap();
        let mut drawn: Vec<i64> = (0..4)
            .filter_map(|cell| file.values(cell)[0].unwrap().0.as_integer())
            .collect();
        drawn.sort_unstable();
        assert_eq!(drawn, [1, 2, 3, 4]);
        let refused = refusal(&text.replace("samples = 4", "samples = 5"));
        assert!(refused.contains("only 4 different draws"), "{refused}");
    }

    /// The example in docs/sweeps.md has every key: one that is added here must be added there.
    #[test]
    fn every_key_is_documented() {
        let page = include_str!("../../../../docs/sweeps.md");
        let (_, text) = page.split_once("```toml\n").unwrap();
        let (text, _) = text.split_once("```").unwrap();
        let file = Parsed::new("docs/sweeps.md".into(), text).unwrap();
        SweepFile::of(&file, "", Path::new("")).unwrap();
        let (written, _): (Written, _) = Source::read(&file, &[]).unwrap();
        let Written {
            name,
            experiment: Some(_),
            seeds: Some(Value::String(_)),
            seeds_by: Some(_),
            set,
            grid,
            list,
            random:
                Some(WrittenRandom {
                    samples: _,
                    seed,
                    ranges,
                }),
            reality:
                Some(Reality {
                    robots: Robots::Numbered(_),
                    severity: Some(severity),
                }),
        } = written
        else {
            panic!("{written:?}");
        };
        assert!(!name.is_empty() && seed > 0 && severity > 0.0 && text.contains("severity = "));
        assert!(!set.is_empty() && !grid.is_empty() && !list.is_empty() && !ranges.is_empty());
    }

    #[test]
    fn errors_name_their_place() {
        for (text, expected) in [
            ("seeds = \"5..1\"", "s.toml:2:9: seeds: is \"5..1\", an empty range"),
            ("seeds = []", "s.toml:2:9: seeds: is empty"),
            ("seeds = [1, 2, 1]", "s.toml:2:16: seeds[2]: is 1 a second time"),
            ("seeds = 3", "s.toml:2:9: seeds: is 3; allowed: \"A..B\""),
            ("", "lacks `seeds`"),
            ("seeds = [1]\nfoo = 1", "s.toml:3:1: foo: unknown key `foo`"),
            ("seeds = [1]\n[grid]\na = 1", "s.toml:4:5: grid.a: is one value"),
            ("seeds = [1]\n[grid]\na = []", "s.toml:4:5: grid.a: is empty"),
            (
                "seeds = [1]\n[grid]\na = [1, 1]",
                "s.toml:4:9: grid.a[1]: is 1 a second time",
            ),
            (
                "seeds = [1]\n[grid]\nseed = [1, 2]",
                "s.toml:4:8: grid.seed: can't be set or swept",
            ),
            (
                "seeds = [1]\n[set]\na.b = 1\n[grid]\na = [1]",
                "s.toml:6:6: a: is already given, as a.b (s.toml:4:7)",
            ),
            (
                "seeds = [1]\n[[list]]\na = 1\n[[list]]\na = 1",
                "list[1]: is there a second time",
            ),
            (
                "seeds = [1]\n[random]\nsamples = 2\n[random.ranges]\na = { from = 1.0, to = 1.0 }",
                "s.toml:6:5: random.ranges.a: is an empty range, 1 to 1",
            ),
            (
                "seeds = [1]\n[random]\nsamples = 2\n[random.ranges]\na = { from = 0.0, to = 1.0, scale = \"log\" }",
                "begins with 0; allowed: above 0",
            ),
            (
                "seeds = [1]\n[reality]\nrobots = []",
                "s.toml:4:10: reality.robots: is empty",
            ),
            ("name = \"a/b\"\nseeds = [1]", "s.toml:2:8: name: is \"a/b\""),
            (
                "seeds = \"1..1000000\"\n[grid]\na = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]",
                "make 11000000 runs with all combinations",
            ),
        ] {
            let refused = refusal(text);
            assert!(refused.contains(expected), "{text}\n{refused}");
        }
    }
}
