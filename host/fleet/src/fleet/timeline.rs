//! All logs of a fleet as one timeline. Each start of a daemon has a clock that counts from that start; robots'
//! messages tie the clocks together.
//!
//! A message that robot A sent at `a` by its clock and B received at `b` by B's clock took `b - a`, less the time that
//! B's clock is ahead. Of two messages, one each way, half the difference of these times is the clocks' offset, if both
//! took equally long, and half their sum is that offset's maximum error. In each minute the fastest message of each
//! direction counts, since waiting only adds. All such pairs make a system of equations for the clocks' offsets and
//! rates (one rate a robot, since its starts share a crystal), which is solved by weighted least squares. The fastest
//! messages depend on the rates, so that is repeated several times.

mod solve;

use std::collections::BTreeMap;

use oneiro_base::contents::Column;
use oneiro_report::numbers::fixed;
use serde_json::{Map, Value, json};

use solve::{Equation, Term, solve_least_squares};

/// How long clocks may be apart by chance while they drift: pairs of messages are looked for within this, ms.
const WINDOW_MS: f64 = 60_000.0;
/// Relative standard deviation of crystals: the drift that is assumed where messages don't show it.
const CRYSTALS: f64 = 1e-4;
/// Minimum error of a pair of messages, ms: logs have whole milliseconds.
const ROUNDING_MS: f64 = 1.0;
/// How often the fastest messages are chosen again.
const PASSES: usize = 4;

/// A line of a robot's log.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    pub robot: u32,
    /// Number of the daemon's start.
    pub(crate) boot: u32,
    /// Time since that start, ms.
    pub(crate) at_ms: f64,
    /// The experiment's time as the robot knew it, ms.
    pub(crate) experiment_ms: Option<f64>,
    /// All that the line has.
    values: Map<String, Value>,
}

impl Line {
    /// Latest time of a log, either way, ms: about thirty years.
    const LATEST: f64 = 1e12;

    /// Reads a line of a robot's log, unless it is torn or lacks its times.
    pub fn read(robot: u32, text: &str) -> Option<Self> {
        let Ok(Value::Object(values)) = serde_json::from_str(text) else {
            return None;
        };
        let number = |key: &str| values.get(key)?.as_f64().filter(|time| time.abs() <= Self::LATEST);
        Some(Self {
            robot,
            boot: u32::try_from(values.get("boot")?.as_u64()?).ok()?,
            at_ms: number("at_ms")?,
            experiment_ms: number("experiment_ms"),
            values,
        })
    }

    fn is(&self, event: &str) -> bool {
        self.values.get("event").is_some_and(|name| name == event)
    }

    fn whole(&self, key: &str) -> Option<u64> {
        self.values.get(key)?.as_u64()
    }

    /// The line with its place in the timeline before all else; null if that is not known.
    pub fn placed(&self, time_ms: Option<f64>) -> Value {
        let time_ms = time_ms.map(|time| (1000.0 * time).round() / 1000.0);
        let mut placed = Map::from_iter([
            ("time_ms".to_owned(), json!(time_ms)),
            ("robot".to_owned(), json!(self.robot)),
        ]);
        placed.extend(self.values.clone());
        Value::Object(placed)
    }
}

/// What a clock was aligned by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// It is the one that others are aligned to.
    Reference,
    /// Messages with other robots.
    Contacts,
    /// Only the operator's beacon, which has the experiment's time: it was in contact with no robot.
    Beacon,
    /// It heard nobody.
    Nothing,
}

impl By {
    fn word(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Contacts => "contacts",
            Self::Beacon => "beacon",
            Self::Nothing => "nothing",
        }
    }
}

/// The clock of one start of a daemon.
#[derive(Clone, Debug, PartialEq)]
pub struct Clock {
    pub robot: u32,
    pub(crate) boot: u32,
    pub by: By,
    lines: usize,
    /// What is added to its time at `pivot`, ms.
    shift: f64,
    /// How much too slow it is, as a share.
    pub drift: f64,
    /// Middle of its lines by its own time, ms.
    pivot: f64,
    /// Pairs of messages by which it was aligned.
    pub pairs: usize,
    /// Root mean square of these pairs' remaining errors, and the maximum, ms. For the beacon: of the experiment's
    /// time.
    pub residual: f64,
    greatest: f64,
    /// Mean of half the time that a message and one back took, ms: by so much the clock may be off if they were slow in one direction
    /// only.
    pub bound: f64,
}

/// The table of clocks: its file, and its columns.
pub const CLOCKS: &str = "clocks.csv";
pub(crate) static CLOCKS_COLUMNS: [Column; 11] = [
    Column::whole("robot", "", "its number"),
    Column::whole("boot", "", "number of the daemon's start; each has another clock"),
    Column::text(
        "by",
        "what the clock was aligned by: `contacts`, messages between robots; `reference`, the clock that these were \
         aligned to; `beacon`, only the experiment's time as the robot received it, since it was in contact with no \
         other; `nothing`",
    ),
    Column::whole("lines", "", "lines of its log"),
    Column::number(
        "shift",
        "ms",
        "what is added to its time in the middle of its log; empty if unknown",
    ),
    Column::number("drift", "ppm", "by how much it is too slow"),
    Column::number("pivot", "ms", "the middle of its log, by this clock"),
    Column::whole(
        "pairs",
        "",
        "pairs of messages, one each way within a minute, by which it was aligned",
    ),
    Column::number(
        "residual",
        "ms",
        "root mean square error of these pairs after the alignment; of `beacon`: of the experiment's times in its log",
    ),
    Column::number("greatest", "ms", "the maximum of these"),
    Column::number(
        "bound",
        "ms",
        "mean of half the time of a message and its answer: the maximum error of the clock, if one direction took all \
         of it",
    ),
];

impl Clock {
    /// The timeline's time of a time of this clock, ms.
    pub fn time(&self, at_ms: f64) -> Option<f64> {
        (self.by != By::Nothing).then(|| self.moved(at_ms))
    }

    fn moved(&self, at_ms: f64) -> f64 {
        at_ms + self.shift + self.drift * (at_ms - self.pivot)
    }

    /// Its row in the table of clocks.
    pub fn row(&self) -> String {
        let known = self.by != By::Nothing;
        let number = |value: f64, known: bool| if known { fixed(value, 3) } else { String::new() };
        let is_fit = self.by == By::Contacts || self.by == By::Reference;
        let cells = [
            self.robot.to_string(),
            self.boot.to_string(),
            self.by.word().to_owned(),
            self.lines.to_string(),
            number(self.shift, known),
            number(1e6 * self.drift, known),
            number(self.pivot, true),
            self.pairs.to_string(),
            number(self.residual, known),
            number(self.greatest, known),
            number(self.bound, is_fit),
        ];
        cells.join(",") + "\n"
    }
}

/// A message from one clock to another, each by its number.
struct Message {
    from: usize,
    to: usize,
    said: f64,
    heard: f64,
}

/// Most clocks that are aligned: ten daemons that start again every other minute for half a day.
pub(crate) const MOST_CLOCKS: usize = 4096;

/// The clocks of some logs, in the order of robots and starts, aligned to the experiment's time; at most
/// [`MOST_CLOCKS`].
pub fn align(lines: &[Line]) -> Vec<Clock> {
    let mut clocks = clocks(lines);
    let number: BTreeMap<(u32, u32), usize> = (0..)
        .zip(&clocks)
        .map(|(at, clock)| ((clock.robot, clock.boot), at))
        .collect();
    let heard = messages(lines, &number);
    let members = most_tied(&clocks, &heard);
    if let Some(&reference) = members
        .iter()
        .max_by_key(|&&member| (clocks[member].lines, usize::MAX - member))
    {
        for &member in &members {
            clocks[member].by = By::Contacts;
        }
        clocks[reference].by = By::Reference;
        // A first guess, since clocks begin hours apart and the fastest messages could not be found otherwise.
        guess(&mut clocks, reference, &heard);
        let mut equations = Vec::new();
        for _ in 0..PASSES {
            equations = pairs(&clocks, &heard);
            fit(&mut clocks, reference, &equations);
        }
        judge(&mut clocks, &equations);
    }
    to_experiment(&mut clocks, lines, &number);
    clocks
}

/// The clocks that the lines have, not aligned.
fn clocks(lines: &[Line]) -> Vec<Clock> {
    let mut spans: BTreeMap<(u32, u32), (usize, f64, f64)> = BTreeMap::new();
    for line in lines {
        let span = spans
            .entry((line.robot, line.boot))
            .or_insert((0, f64::INFINITY, f64::NEG_INFINITY));
        *span = (span.0 + 1, span.1.min(line.at_ms), span.2.max(line.at_ms));
    }
    let clock = |((robot, boot), (lines, first, last)): ((u32, u32), (usize, f64, f64))| Clock {
        robot,
        boot,
        by: By::Nothing,
        lines,
        shift: 0.0,
        drift: 0.0,
        pivot: f64::midpoint(first, last),
        pairs: 0,
        residual: 0.0,
        greatest: 0.0,
        bound: 0.0,
    };
    spans.into_iter().map(clock).collect()
}

/// All messages of which the logs have both ends. Numbers of messages never repeat, in no start of a sender.
fn messages(lines: &[Line], number: &BTreeMap<(u32, u32), usize>) -> Vec<Message> {
    let clock = |line: &Line| number[&(line.robot, line.boot)];
    let said = lines.iter().filter(|line| line.is("said"));
    let said: BTreeMap<(u64, u64), &Line> = said
        .filter_map(|line| Some(((u64::from(line.robot), line.whole("sequence")?), line)))
        .collect();
    let of = |line: &Line| {
        let said = said.get(&(line.whole("sender")?, line.whole("sequence")?))?;
        (said.robot != line.robot).then(|| Message {
            from: clock(said),
            to: clock(line),
            said: said.at_ms,
            heard: line.at_ms,
        })
    };
    lines.iter().filter(|line| line.is("heard")).filter_map(of).collect()
}

/// The clocks that messages in both directions tie together; of several such groups the one with the most lines.
fn most_tied(clocks: &[Clock], heard: &[Message]) -> Vec<usize> {
    let ways: std::collections::BTreeSet<(usize, usize)> =
        heard.iter().map(|message| (message.from, message.to)).collect();
    let mut group: Vec<usize> = (0..clocks.len()).collect();
    for &(from, to) in ways.iter().filter(|(from, to)| ways.contains(&(*to, *from))) {
        let (kept, left) = (group[from].min(group[to]), group[from].max(group[to]));
        group
            .iter_mut()
            .filter(|root| **root == left)
            .for_each(|root| *root = kept);
    }
    let members = |of: usize| (0..clocks.len()).filter(|&at| group[at] == of).collect::<Vec<_>>();
    let groups = (0..clocks.len()).map(members).filter(|members| members.len() > 1);
    let lines = |members: &Vec<usize>| members.iter().map(|&member| clocks[member].lines).sum::<usize>();
    groups.max_by_key(lines).unwrap_or_default()
}

/// Sets all offsets by the fastest message of each direction of the whole time, from neighbour to neighbour.
fn guess(clocks: &mut [Clock], reference: usize, heard: &[Message]) {
    let mut fastest: BTreeMap<(usize, usize), f64> = BTreeMap::new();
    for message in heard {
        let took = fastest.entry((message.from, message.to)).or_insert(f64::INFINITY);
        *took = took.min(message.heard - message.said);
    }
    let (mut known, mut next) = (vec![false; clocks.len()], vec![reference]);
    known[reference] = true;
    while let Some(at) = next.pop() {
        let shift = clocks[at].shift;
        for (other, clock) in clocks.iter_mut().enumerate() {
            let both = fastest.get(&(at, other)).zip(fastest.get(&(other, at)));
            if let (false, Some((there, back))) = (known[other], both) {
                clock.shift = shift - (there - back) / 2.0;
                known[other] = true;
                next.push(other);
            }
        }
    }
}

/// An equation for each window in which two clocks heard each other: how far they are apart by the fastest message of each direction.
fn pairs(clocks: &[Clock], heard: &[Message]) -> Vec<Equation> {
    type Fastest<'a> = [Option<(f64, &'a Message)>; 2];
    let mut windows: BTreeMap<(usize, usize, i64), Fastest<'_>> = BTreeMap::new();
    for message in heard
        .iter()
        .filter(|message| clocks[message.from].by != By::Nothing && clocks[message.to].by != By::Nothing)
    {
        let is_back = message.from > message.to;
        let (first, by_first) = if is_back {
            (message.to, message.heard)
        } else {
            (message.from, message.said)
        };
        let window = (clocks[first].moved(by_first) / WINDOW_MS).floor() as i64;
        let fastest = windows
            .entry((message.from.min(message.to), message.from.max(message.to), window))
            .or_default();
        let took = clocks[message.to].moved(message.heard) - clocks[message.from].moved(message.said);
        let best = &mut fastest[usize::from(is_back)];
        if best.is_none_or(|(least, _)| took < least) {
            *best = Some((took, message));
        }
    }
    let equation = |((a, b, _), [there, back]): ((usize, usize, i64), Fastest<'_>)| {
        let ((there_took, there), (back_took, back)) = (there?, back?);
        let bound = (there_took + back_took).abs() / 2.0;
        Some(Equation {
            terms: [
                Term {
                    clock: a,
                    sign: 1.0,
                    at: f64::midpoint(there.said, back.heard),
                },
                Term {
                    clock: b,
                    sign: -1.0,
                    at: f64::midpoint(there.heard, back.said),
                },
            ],
            value: ((there.heard - there.said) - (back.heard - back.said)) / 2.0,
            error: bound.max(ROUNDING_MS),
            bound,
        })
    };
    windows.into_iter().filter_map(equation).collect()
}

/// Fits offsets and rates to the equations. The reference keeps its offset 0 and its rate.
fn fit(clocks: &mut [Clock], reference: usize, equations: &[Equation]) {
    let of_reference = clocks[reference].robot;
    let mut unknowns = 0;
    let mut next = || {
        unknowns += 1;
        unknowns - 1
    };
    let shifts: Vec<Option<usize>> = (0..clocks.len())
        .map(|at| (clocks[at].by == By::Contacts).then(&mut next))
        .collect();
    let mut robots: BTreeMap<u32, usize> = BTreeMap::new();
    for clock in clocks
        .iter()
        .filter(|clock| clock.by == By::Contacts && clock.robot != of_reference)
    {
        robots.entry(clock.robot).or_insert_with(&mut next);
    }
    let rates: Vec<Option<usize>> = clocks.iter().map(|clock| robots.get(&clock.robot).copied()).collect();
    let rows = equations.iter().map(|equation| {
        let weight = 1.0 / equation.error;
        let coefficients = equation.terms.iter().flat_map(|term| {
            let shift = shifts[term.clock].map(|at| (at, weight * term.sign));
            // Rates in units of crystals' drift, so that all unknowns are of one size.
            let span = CRYSTALS * (term.at - clocks[term.clock].pivot);
            let rate = rates[term.clock].map(|at| (at, weight * term.sign * span));
            shift.into_iter().chain(rate)
        });
        (coefficients.collect::<Vec<_>>(), weight * equation.value)
    });
    // Without other data, each rate is 0 with the standard deviation of crystals.
    let crystals = robots.values().map(|&rate| (vec![(rate, 1.0)], 0.0));
    let solution = solve_least_squares(unknowns, &rows.chain(crystals).collect::<Vec<_>>());
    for (at, clock) in clocks
        .iter_mut()
        .enumerate()
        .filter(|(_, clock)| clock.by != By::Nothing)
    {
        clock.shift = shifts[at].map_or(0.0, |unknown| solution[unknown]);
        clock.drift = rates[at].map_or(0.0, |unknown| CRYSTALS * solution[unknown]);
    }
}

/// Sets of each clock how well the equations that it is in are met.
fn judge(clocks: &mut [Clock], equations: &[Equation]) {
    let apart = |clocks: &[Clock], term: &Term| term.sign * (clocks[term.clock].moved(term.at) - term.at);
    for equation in equations {
        let off = (equation.value - equation.terms.iter().map(|term| apart(clocks, term)).sum::<f64>()).abs();
        for term in &equation.terms {
            let clock = &mut clocks[term.clock];
            clock.pairs += 1;
            clock.residual += off * off;
            clock.greatest = clock.greatest.max(off);
            clock.bound += equation.bound;
        }
    }
    for clock in clocks.iter_mut().filter(|clock| clock.pairs > 0) {
        clock.residual = (clock.residual / clock.pairs as f64).sqrt();
        clock.bound /= clock.pairs as f64;
    }
}

/// Moves the clocks that are tied together to the experiment's time, by the median of what their logs say of it; each of the others by its
/// own.
fn to_experiment(clocks: &mut [Clock], lines: &[Line], number: &BTreeMap<(u32, u32), usize>) {
    let mut tied = Vec::new();
    let mut alone: Vec<Vec<f64>> = vec![Vec::new(); clocks.len()];
    for line in lines {
        if let Some(experiment) = line.experiment_ms {
            let at = number[&(line.robot, line.boot)];
            let off = experiment - clocks[at].moved(line.at_ms);
            if clocks[at].by == By::Nothing {
                alone[at].push(off);
            } else {
                tied.push(off);
            }
        }
    }
    let common = median(&mut tied).unwrap_or(0.0);
    for (clock, mut off) in clocks.iter_mut().zip(alone) {
        if clock.by != By::Nothing {
            clock.shift += common;
        } else if let Some(middle) = median(&mut off) {
            clock.by = By::Beacon;
            clock.shift = middle;
            let squares: f64 = off.iter().map(|off| (off - middle) * (off - middle)).sum();
            clock.residual = (squares / off.len() as f64).sqrt();
            clock.greatest = off.iter().map(|off| (off - middle).abs()).fold(0.0, f64::max);
        }
    }
}

fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    let upper = *values.get(middle)?;
    Some(if values.len().is_multiple_of(2) {
        f64::midpoint(values[middle - 1], upper)
    } else {
        upper
    })
}

#[cfg(test)]
mod tests;
