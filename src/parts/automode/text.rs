//! What the text forms of state machines and behaviour trees share: options with a value each, in any order.

use std::collections::BTreeMap;
use std::fmt;

use super::{Behaviour, Condition, Crowd, MODULES, NEIGHBOURS, PROBABILITIES, STEEPNESSES, STRENGTHS, TURNS};

/// A text that is no such controller: the place of the word, from 1, its problem, and what is allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("word {word}: {problem}")]
pub struct BadText {
    /// The word's number in the text.
    pub word: usize,
    /// The word, what is wrong with it, and what is allowed.
    pub problem: String,
}

fn bad<T>(word: usize, problem: impl Into<String>) -> Result<T, BadText> {
    Err(BadText {
        word,
        problem: problem.into(),
    })
}

/// The words of a kind of text.
#[derive(Clone, Copy)]
pub(super) struct Words {
    /// May stand before the options.
    pub(super) may_begin: &'static str,
    /// The first options.
    pub(super) such_as: &'static str,
    /// All options: without a number after them, and before one.
    pub(super) whole: &'static [&'static str],
    pub(super) numbered: &'static [&'static str],
    /// Between the digits of two numbers.
    pub(super) between: Option<char>,
    /// The part of a text that an option doesn't belong to, and the allowed ones, as in `tree; allowed: options of its branches`.
    pub(super) kind: &'static str,
}

impl Words {
    /// Whether such texts have an option of this name.
    fn has(self, option: &str) -> bool {
        let name = option.strip_prefix("--").unwrap_or(option);
        let letters = name.find(|c: char| c.is_ascii_digit()).unwrap_or(name.len());
        let (letters, place) = name.split_at(letters);
        let is_place = place.chars().all(|c| c.is_ascii_digit() || Some(c) == self.between);
        if place.is_empty() {
            self.whole.contains(&letters)
        } else {
            is_place && self.numbered.contains(&letters)
        }
    }
}

/// The values of options that have not been taken yet, each with the option's place.
pub(super) struct Options<'a> {
    words: Words,
    values: BTreeMap<&'a str, (usize, &'a str)>,
    /// The place after the last word.
    end: usize,
}

impl<'a> Options<'a> {
    /// Reads a text. An option that no such text has is refused before any that is missing.
    pub(super) fn read(text: &'a str, kind: Words) -> Result<Self, BadText> {
        let Words { may_begin, such_as, .. } = kind;
        let mut words = (1..).zip(text.split_whitespace()).peekable();
        words.next_if(|(_, word)| *word == may_begin);
        let mut options = Self {
            words: kind,
            values: BTreeMap::new(),
            end: 1,
        };
        while let Some((place, option)) = words.next() {
            if !option.starts_with("--") {
                return bad(
                    place,
                    format!("`{option}` is no option; allowed: {such_as}, each with its value"),
                );
            }
            if !kind.has(option) {
                return foreign(place, option, kind);
            }
            options.end = place + 1;
            let Some((_, value)) = words.next_if(|(_, word)| !word.starts_with("--")) else {
                return bad(options.end, format!("`{option}` has no value; allowed: one number"));
            };
            options.end += 1;
            if options.values.insert(option, (place, value)).is_some() {
                return bad(place, format!("`{option}` is given twice; allowed: once"));
            }
        }
        Ok(options)
    }

    /// The place and the value of an option.
    fn take(&mut self, option: &str) -> Result<(usize, &'a str), BadText> {
        match self.values.remove(option) {
            Some((place, value)) => Ok((place + 1, value)),
            None => bad(
                self.end,
                format!("`{option}` is missing; allowed: given with its value"),
            ),
        }
    }

    /// Whether an option has not been taken yet.
    pub(super) fn has(&self, option: &str) -> bool {
        self.values.contains_key(option)
    }

    /// Takes an option whose value is a whole number of a range.
    pub(super) fn whole(&mut self, option: &str, [least, greatest]: [u32; 2]) -> Result<u32, BadText> {
        let (place, value) = self.take(option)?;
        match value.parse() {
            Ok(number) if (least..=greatest).contains(&number) => Ok(number),
            _ => bad(
                place,
                if least == greatest {
                    format!("`{option}` is `{value}`; allowed: {least}")
                } else {
                    format!("`{option}` is `{value}`; allowed: {least} to {greatest}, whole")
                },
            ),
        }
    }

    fn number(&mut self, option: &str, [least, greatest]: [f32; 2]) -> Result<f32, BadText> {
        let (place, value) = self.take(option)?;
        match value.parse::<f32>() {
            // Zero has one sign.
            Ok(number) if (least..=greatest).contains(&number) => Ok(number + 0.0),
            _ => bad(
                place,
                format!("`{option}` is `{value}`; allowed: {least} to {greatest}"),
            ),
        }
    }

    /// Takes a behaviour: its number is the value of `option`, and its values' options end with `place`.
    pub(super) fn behaviour(&mut self, option: &str, place: &str) -> Result<Behaviour, BadText> {
        Ok(match self.whole(option, MODULES)? {
            0 => Behaviour::Exploration {
                turning: self.whole(&format!("--rwm{place}"), TURNS)?,
            },
            1 => Behaviour::Stop,
            2 => Behaviour::Phototaxis,
            3 => Behaviour::AntiPhototaxis,
            4 => Behaviour::Attraction {
                strength: self.number(&format!("--att{place}"), STRENGTHS)?,
            },
            _ => Behaviour::Repulsion {
                strength: self.number(&format!("--rep{place}"), STRENGTHS)?,
            },
        })
    }

    /// Takes a condition, whose options end with `place`.
    pub(super) fn condition(&mut self, place: &str) -> Result<Condition, BadText> {
        let kind = self.whole(&format!("--c{place}"), MODULES)?;
        let p = format!("--p{place}");
        Ok(match kind {
            0 => Condition::BlackFloor(self.number(&p, PROBABILITIES)?),
            1 => Condition::GreyFloor(self.number(&p, PROBABILITIES)?),
            2 => Condition::WhiteFloor(self.number(&p, PROBABILITIES)?),
            3 | 4 => {
                let crowd = Crowd {
                    neighbours: self.whole(&p, NEIGHBOURS)?,
                    steepness: self.number(&format!("--w{place}"), STEEPNESSES)?,
                };
                if kind == 3 {
                    Condition::NeighbourCount(crowd)
                } else {
                    Condition::InvertedNeighbourCount(crowd)
                }
            }
            _ => Condition::FixedProbability(self.number(&p, PROBABILITIES)?),
        })
    }

    /// Returns an error for the first unused option.
    pub(super) fn finished(self) -> Result<(), BadText> {
        match self.values.into_iter().min_by_key(|(_, (place, _))| *place) {
            None => Ok(()),
            Some((option, (place, _))) => foreign(place, option, self.words),
        }
    }
}

fn foreign<T>(place: usize, option: &str, words: Words) -> Result<T, BadText> {
    bad(place, format!("`{option}` is not of this {}", words.kind))
}

/// Writes what [`Options::behaviour`] takes.
pub(super) fn write_behaviour(
    f: &mut fmt::Formatter<'_>,
    option: &str,
    place: &str,
    behaviour: Behaviour,
) -> fmt::Result {
    write!(f, " {option} {}", behaviour.number())?;
    match behaviour {
        Behaviour::Exploration { turning } => write!(f, " --rwm{place} {turning}"),
        Behaviour::Attraction { strength } => write!(f, " --att{place} {strength}"),
        Behaviour::Repulsion { strength } => write!(f, " --rep{place} {strength}"),
        Behaviour::Stop | Behaviour::Phototaxis | Behaviour::AntiPhototaxis => Ok(()),
    }
}

/// Writes what [`Options::condition`] takes.
pub(super) fn write_condition(f: &mut fmt::Formatter<'_>, place: &str, condition: Condition) -> fmt::Result {
    write!(f, " --c{place} {}", condition.number())?;
    match condition {
        Condition::BlackFloor(p)
        | Condition::GreyFloor(p)
        | Condition::WhiteFloor(p)
        | Condition::FixedProbability(p) => {
            write!(f, " --p{place} {p}")
        }
        Condition::NeighbourCount(crowd) | Condition::InvertedNeighbourCount(crowd) => {
            write!(f, " --p{place} {} --w{place} {}", crowd.neighbours, crowd.steepness)
        }
    }
}
