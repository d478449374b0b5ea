//! The worlds that an experiment has if numbers or starts of it vary.

use std::collections::BTreeSet;

use crate::batch::Variants;
use crate::parameter::{self, Allowed, Datum, Invalid};
use crate::random::pcg4d;
use crate::world::Build;
use crate::world::arena::Arena;
use crate::world::differential::Starts;
use crate::world::parameters::PARAMETERS;
use crate::world::spec::WorldSpec;
use crate::world::start::{Poses, Start};
use crate::world::varied::Varied;

/// Most worlds in all.
const GREATEST_VARIANTS: usize = 4096;
/// Drawn worlds unless an experiment says how many.
const DRAWN: u32 = 100;
/// The keys of drawn numbers begin with one of these.
const TABLES: [&str; 5] = ["arena.", "noise.", "pucks.", "robot.", "start."];
/// The lists of ranges, and of values.
const VARY: &str = "worlds.vary";
const CHOOSE: &str = "worlds.choose";

impl WorldSpec {
    /// Whether its numbers or its fixed starts differ between episodes.
    pub fn varies(&self) -> bool {
        !self.varied.is_empty() || matches!(self.start, Start::Poses(_))
    }

    /// How many worlds an experiment has, of which each episode takes one.
    ///
    /// # Errors
    /// More than kernels can be given at once; a number of worlds that nothing makes differ.
    pub(super) fn variants(&self) -> Result<Variants, Invalid> {
        let starts = match &self.start {
            Start::Poses(poses) => {
                let (poses, robots) = (poses.0.len() as u32, self.robot.count());
                if !poses.is_multiple_of(robots) {
                    let problem = format!(
                        "has {poses} poses; allowed: a pose for each of {robots} robots, once or several times"
                    );
                    return Err(Invalid::new("start.poses", problem));
                }
                poses / robots
            }
            _ => 1,
        };
        let drawn = if self.varied.is_empty() {
            for (key, is_given) in [
                ("count", self.varied.count.is_some()),
                ("seed", self.varied.seed.is_some()),
            ] {
                if is_given {
                    let problem = "is given, but no number is drawn; allowed: with worlds.vary or worlds.choose";
                    return Err(Invalid::new(format!("worlds.{key}"), problem));
                }
            }
            1
        } else {
            self.varied.count.unwrap_or(DRAWN)
        };
        let variants = Variants { starts, drawn };
        if variants.count() > GREATEST_VARIANTS {
            let problem = format!("are {drawn} drawn with {starts} starts each; allowed: {GREATEST_VARIANTS} in all");
            return Err(Invalid::new("worlds.count", problem));
        }
        Ok(variants)
    }

    /// One of its worlds, which itself doesn't vary.
    ///
    /// # Errors
    /// A key that no number of this world has, and ranges and lists that don't fit it.
    pub(super) fn variant(&self, variants: Variants, index: usize) -> Result<Self, Invalid> {
        self.variant_and_drawn(variants, index).map(|(spec, _)| spec)
    }

    /// The keys of its drawn numbers, each with the number of its element.
    ///
    /// # Errors
    /// As [`WorldSpec::variant`].
    pub(super) fn drawn(&self, variants: Variants) -> Result<BTreeSet<String>, Invalid> {
        self.variant_and_drawn(variants, 0).map(|(_, drawn)| drawn)
    }

    /// The number that it has for such a key, or a pair of numbers, and its unit.
    pub(super) fn number_of(&self, key: &str) -> Option<(Datum, &'static str)> {
        let (pattern, index) = pattern(key);
        let row = PARAMETERS.iter().find(|row| row.key == pattern)?;
        let datum = (row.field)(&mut self.clone(), index.unwrap_or(0))?.get()?;
        Some((datum, row.unit))
    }

    /// One of its worlds, and the keys of its drawn numbers.
    fn variant_and_drawn(&self, variants: Variants, index: usize) -> Result<(Self, BTreeSet<String>), Invalid> {
        let mut spec = Self {
            varied: Varied::default(),
            ..self.clone()
        };
        if let Start::Poses(poses) = &self.start {
            spec.start_at(poses, index % variants.starts as usize);
        }
        if let Build::Forager(_) = spec.robot.build {
            // It follows from the forager's numbers.
            spec.arena = Arena::default();
        }
        let world = (index / variants.starts as usize) as u32;
        let mut drawn = BTreeSet::new();
        let lists = [(VARY, &self.varied.vary), (CHOOSE, &self.varied.choose)];
        for (list, key, values) in lists
            .into_iter()
            .flat_map(|(list, by_key)| by_key.0.iter().map(move |(key, values)| (list, key, values)))
        {
            if list == CHOOSE && self.varied.vary.0.iter().any(|(other, _)| other == key) {
                let problem = format!("has {key:?}, which {VARY} has too; allowed: either");
                return Err(Invalid::new(CHOOSE, problem));
            }
            let seed = self.varied.seed.unwrap_or(0);
            spec.draw((list, key), values, &mut drawn, |name| unit(seed, world, name))?;
        }
        Ok((spec, drawn))
    }

    /// Begins with a pose of a list, or with one for each robot of a swarm.
    fn start_at(&mut self, poses: &Poses, start: usize) {
        let robots = self.robot.count() as usize;
        let own = &poses.0[start * robots..][..robots];
        self.start = match &mut self.robot.build {
            Build::Differential(robot) if robot.count.is_some() => {
                robot.starts = Some(Starts(own.iter().map(|[x, y, _]| [*x, *y]).collect()));
                robot.headings = own.iter().map(|[.., heading]| *heading).collect();
                Start::Random
            }
            _ => {
                let [x, y, heading] = own[0];
                Start::At { x, y, heading }
            }
        };
    }

    /// Draws the numbers with a list's key, given a number from 0 to less than 1 for each name, of which none may be `drawn` already.
    fn draw(
        &mut self,
        (list, key): (&str, &str),
        values: &Datum,
        drawn: &mut BTreeSet<String>,
        unit: impl Fn(&str) -> f64,
    ) -> Result<(), Invalid> {
        let refused = |problem: String| Err(Invalid::new(list, format!("has {key:?}, {problem}")));
        let (pattern, only) = pattern(key);
        let row = PARAMETERS.iter().find(|row| {
            let is_number = matches!(row.allowed, Allowed::Number(..) | Allowed::NumberUpTo(..));
            row.key == pattern && is_number && TABLES.iter().any(|table| key.starts_with(table))
        });
        let Some(row) = row else {
            let keys = PARAMETERS
                .iter()
                .map(|row| row.key)
                .filter(|key| TABLES.iter().any(|table| key.starts_with(table)));
            if PARAMETERS.iter().any(|row| row.key == pattern) {
                return refused(
                    "which is no number with a fraction; allowed: others, or runs or a sweep for each value".to_owned(),
                );
            }
            let meant =
                parameter::nearest(keys, &pattern).map_or_else(String::new, |meant| format!("; did you mean {meant}?"));
            return refused(format!(
                "which is no number of a world that can be drawn{meant}; allowed: keys of numbers of the tables arena, noise, pucks, robot and start, such as \
                 \"arena.obstacles[0].x_mm\""
            ));
        };
        let indices = match only {
            Some(index) => index..index + 1,
            None if pattern.contains("[]") => 0..usize::MAX,
            None => 0..1,
        };
        let first = indices.start;
        for index in indices {
            let name = row.name(index);
            let Some(field) = (row.field)(self, index) else {
                if index == first {
                    return refused(
                        "which this world doesn't have; allowed: keys of what the experiment describes".to_owned(),
                    );
                }
                break;
            };
            if drawn.contains(&name) {
                return refused(format!(
                    "whose {name} another key also draws; allowed: one key for each number"
                ));
            }
            let value = if list == VARY {
                within(values, &name, &unit)
            } else {
                one_of(values, unit(&name))
            };
            if !value.is_some_and(|value| field.set(&value)) {
                let allowed = if list == VARY {
                    "[minimum, maximum], and a list of two such ranges for a pair of numbers"
                } else {
                    "a list of values that the key may have"
                };
                return refused(format!("which is {values}; allowed: {allowed}"));
            }
            drawn.insert(name);
        }
        Ok(())
    }
}

/// A key as a row has it, and the number of the element that it names.
fn pattern(key: &str) -> (String, Option<usize>) {
    if let Some((list, rest)) = key.split_once('[')
        && let Some((index, rest)) = rest.split_once(']')
    {
        return (format!("{list}[]{rest}"), index.parse().ok());
    }
    (key.to_owned(), None)
}

/// A number from 0 to less than 1 for a name in a drawn world: others don't change it.
fn unit(seed: u64, world: u32, name: &str) -> f64 {
    let mut words = [seed as u32, (seed >> u32::BITS) as u32, world, 0];
    for byte in name.bytes() {
        words[3] ^= u32::from(byte);
        words = pcg4d(words);
    }
    f64::from(words[0]) / (f64::from(u32::MAX) + 1.0)
}

/// A number of a range, or a pair of numbers of two ranges.
fn within(ranges: &Datum, name: &str, unit: &impl Fn(&str) -> f64) -> Option<Datum> {
    let Datum::List(list) = ranges else { return None };
    let [first, second] = &list[..] else { return None };
    if let (Datum::List(_), Datum::List(_)) = (first, second) {
        let of_two = |(index, range): (usize, &Datum)| within(range, &format!("{name}[{index}]"), unit);
        let pair: Option<Vec<_>> = list.iter().enumerate().map(of_two).collect();
        return pair.map(Datum::List);
    }
    let (least, greatest) = (first.number()?, second.number()?);
    (least <= greatest).then(|| Datum::Single((least + unit(name) * (greatest - least)) as f32))
}

/// A value of a list.
fn one_of(values: &Datum, unit: f64) -> Option<Datum> {
    let Datum::List(list) = values else { return None };
    list.get((unit * list.len() as f64) as usize).cloned()
}
