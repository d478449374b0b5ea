//! `AutoMoDe`'s text form: `--nstates 2 --s0 0 --rwm0 50 --n0 1 --n0x0 0 --c0x0 3 --p0x0 8 --w0x0 2.5 --s1 1 ..`.

use std::collections::BTreeMap;
use std::fmt::{self, Display};

use super::{
    Behaviour, Condition, Crowd, GREATEST_STATES, GREATEST_TRANSITIONS, MODULES, Machine, NEIGHBOURS, PROBABILITIES,
    STEEPNESSES, STRENGTHS, State, TURNS, Transition,
};

/// A text that is no machine: the place of the word, from 1, its problem, and what is allowed.
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

/// Reads a machine. Options may be in any order, and `--fsm-config` may stand before them.
///
/// # Errors
/// The first word that is no option with its value, is given twice, is not of this machine, or not allowed; or the option that is
/// missing, at the word after the last.
pub fn parse(text: &str) -> Result<Machine, BadText> {
    let mut options = Options::read(text)?;
    let count = options.whole("--nstates", [1, GREATEST_STATES as u32])?;
    let others = count as usize - 1;
    let states = (0..count)
        .map(|state| options.state(state, others))
        .collect::<Result<_, _>>()?;
    options.finished()?;
    Ok(Machine { states })
}

/// The values of options that have not been taken yet, each with the option's place.
struct Options<'a> {
    values: BTreeMap<&'a str, (usize, &'a str)>,
    /// The place after the last word.
    end: usize,
}

impl<'a> Options<'a> {
    fn read(text: &'a str) -> Result<Self, BadText> {
        let mut words = (1..).zip(text.split_whitespace()).peekable();
        words.next_if(|(_, word)| *word == "--fsm-config");
        let mut own = Self {
            values: BTreeMap::new(),
            end: 1,
        };
        while let Some((place, option)) = words.next() {
            if !option.starts_with("--") {
                return bad(
                    place,
                    format!("`{option}` is no option; allowed: --nstates, --s0, .., each with its value"),
                );
            }
            own.end = place + 1;
            let Some((_, value)) = words.next_if(|(_, word)| !word.starts_with("--")) else {
                return bad(own.end, format!("`{option}` has no value; allowed: one number"));
            };
            own.end += 1;
            if own.values.insert(option, (place, value)).is_some() {
                return bad(place, format!("`{option}` is given twice; allowed: once"));
            }
        }
        Ok(own)
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

    fn whole(&mut self, option: &str, [least, greatest]: [u32; 2]) -> Result<u32, BadText> {
        let (place, value) = self.take(option)?;
        match value.parse() {
            Ok(number) if (least..=greatest).contains(&number) => Ok(number),
            _ => bad(
                place,
                format!("`{option}` is `{value}`; allowed: {least} to {greatest}, whole"),
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

    fn state(&mut self, state: u32, others: usize) -> Result<State, BadText> {
        let strength = |own: &mut Self, name: &str| own.number(&format!("--{name}{state}"), STRENGTHS);
        let behaviour = match self.whole(&format!("--s{state}"), MODULES)? {
            0 => Behaviour::Exploration {
                turning: self.whole(&format!("--rwm{state}"), TURNS)?,
            },
            1 => Behaviour::Stop,
            2 => Behaviour::Phototaxis,
            3 => Behaviour::AntiPhototaxis,
            4 => Behaviour::Attraction {
                strength: strength(self, "att")?,
            },
            _ => Behaviour::Repulsion {
                strength: strength(self, "rep")?,
            },
        };
        let count = format!("--n{state}");
        let count = if others > 0 && self.values.contains_key(count.as_str()) {
            self.whole(&count, [0, GREATEST_TRANSITIONS as u32])?
        } else {
            0
        };
        let transition = |transition| self.transition(&format!("{state}x{transition}"), others);
        Ok(State {
            behaviour,
            transitions: (0..count).map(transition).collect::<Result<_, _>>()?,
        })
    }

    fn transition(&mut self, place: &str, others: usize) -> Result<Transition, BadText> {
        let to = self.whole(&format!("--n{place}"), [0, others as u32 - 1])?;
        let kind = self.whole(&format!("--c{place}"), MODULES)?;
        let p = format!("--p{place}");
        let condition = match kind {
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
        };
        Ok(Transition {
            to: to as usize,
            condition,
        })
    }

    /// Refuses what is left.
    fn finished(self) -> Result<(), BadText> {
        match self.values.into_iter().min_by_key(|(_, (place, _))| *place) {
            None => Ok(()),
            Some((option, (place, _))) => bad(
                place,
                format!(
                    "`{option}` is not of this machine; allowed: options of its states, their behaviours, transitions and conditions"
                ),
            ),
        }
    }
}

/// The text that [`parse`] reads, with the fewest digits that give the same numbers.
impl Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "--nstates {}", self.states.len())?;
        for (state, own) in self.states.iter().enumerate() {
            write!(f, " --s{state} {}", own.behaviour.number())?;
            match own.behaviour {
                Behaviour::Exploration { turning } => write!(f, " --rwm{state} {turning}")?,
                Behaviour::Attraction { strength } => write!(f, " --att{state} {strength}")?,
                Behaviour::Repulsion { strength } => write!(f, " --rep{state} {strength}")?,
                Behaviour::Stop | Behaviour::Phototaxis | Behaviour::AntiPhototaxis => {}
            }
            if self.states.len() > 1 {
                write!(f, " --n{state} {}", own.transitions.len())?;
            }
            for (transition, Transition { to, condition }) in own.transitions.iter().enumerate() {
                let place = format!("{state}x{transition}");
                write!(f, " --n{place} {to} --c{place} {}", condition.number())?;
                match condition {
                    Condition::BlackFloor(p)
                    | Condition::GreyFloor(p)
                    | Condition::WhiteFloor(p)
                    | Condition::FixedProbability(p) => write!(f, " --p{place} {p}")?,
                    Condition::NeighbourCount(crowd) | Condition::InvertedNeighbourCount(crowd) => {
                        write!(f, " --p{place} {} --w{place} {}", crowd.neighbours, crowd.steepness)?;
                    }
                }
            }
        }
        Ok(())
    }
}
