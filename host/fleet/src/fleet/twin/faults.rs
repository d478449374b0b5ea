//! Faults by script and seed.
//!
//! ```toml
//! seed = 1                    # of all random numbers; 0 unless given
//!
//! [[packets]]                 # datagrams to these robots; of several tables that fit, the first counts
//! robots = [0, 1]             # receivers; all and the operator unless given
//! channel = "radio"           # of robots and of the operator, or "tracker"; "radio" unless given
//! from_s = 0.0                # of the experiment's time; from the beginning to the end unless given
//! to_s = 600.0
//! latency_ms = [1.0, 5.0]     # minimum and maximum delay; 0 unless given
//! lost = 0.3                  # fraction of datagrams, 0 unless given
//! reordered = 0.1             # come up to 250 ms late, after others that were sent later
//! duplicated = 0.1
//! corrupted = 0.05            # a bit differs, the end is missing, or bytes were added
//! forged = 2.0                # datagrams a second and receiver that nobody has sent: random, changed or recorded earlier
//!
//! [[kill]]                    # SIGKILL of the daemon
//! robots = [3]                # all unless given
//! at_s = 100.0                # or times = N, at N moments from from_s to to_s, each time one of the robots
//! for_s = 5.0                 # started again after as long; never unless given
//!
//! [[pause]]                   # SIGSTOP of the daemon, SIGCONT after for_s
//! [[serial]]                  # the serial line carries nothing for for_s
//! [[disk]]                    # the disk of the daemon's directory is full for for_s
//! [[operator]]                # the operator says nothing for for_s; without robots
//!
//! [[clock]]                   # the clock of the robot's computer
//! robots = [5]
//! at_s = 0.0
//! ppm = 200.0                 # how much faster it runs from then on, -1000 to 1000
//! jump_s = 1.5                # how far it jumps forward, 0 to 3600
//! ```
//!
//! The fate of a datagram is drawn by the seed, its sender, its receiver and how many it has sent there before, so that no fault changes
//! those of other datagrams.

use std::path::Path;

use oneiro::random::pcg4d;
use oneiro_base::exit::Result;
use oneiro_base::files;
use oneiro_lab::experiment::source::{Parsed, Source};
use serde::{Deserialize, Serialize};

/// A second, ns.
pub(super) const SECOND: u64 = 1_000_000_000;
/// How late a datagram comes at most that others overtake, ns.
const OVERTAKEN: u64 = SECOND / 4;
/// The sender of forged datagrams, and of the tracker's.
pub(super) const FORGER: u32 = 0x1_0000;
pub(super) const TRACKER: u32 = 0x1_0001;
/// The operator, as a sender and as a receiver.
pub(super) const OPERATOR: u32 = 0xffff;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    #[serde(default)]
    seed: u64,
    #[serde(default)]
    packets: Vec<WrittenPackets>,
    #[serde(default)]
    kill: Vec<WrittenEvent>,
    #[serde(default)]
    pause: Vec<WrittenEvent>,
    #[serde(default)]
    serial: Vec<WrittenEvent>,
    #[serde(default)]
    disk: Vec<WrittenEvent>,
    #[serde(default)]
    operator: Vec<WrittenEvent>,
    #[serde(default)]
    clock: Vec<WrittenEvent>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenPackets {
    robots: Option<Vec<u32>>,
    #[serde(default)]
    channel: Carrier,
    from_s: Option<f64>,
    to_s: Option<f64>,
    #[serde(default)]
    latency_ms: [f64; 2],
    #[serde(default)]
    lost: f64,
    #[serde(default)]
    reordered: f64,
    #[serde(default)]
    duplicated: f64,
    #[serde(default)]
    corrupted: f64,
    #[serde(default)]
    forged: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenEvent {
    robots: Option<Vec<u32>>,
    at_s: Option<f64>,
    times: Option<u32>,
    from_s: Option<f64>,
    to_s: Option<f64>,
    for_s: Option<f64>,
    ppm: Option<f64>,
    jump_s: Option<f64>,
}

/// A datagram's channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Carrier {
    /// Robots and the operator.
    #[default]
    Radio,
    /// The tracker.
    Tracker,
}

/// What befalls datagrams.
#[derive(Clone, Debug, PartialEq)]
struct Rule {
    robots: Vec<u32>,
    channel: Carrier,
    /// From when to when, ns of the experiment's time.
    from: u64,
    to: u64,
    /// Minimum and maximum delay, ns.
    latency: [u64; 2],
    lost: f64,
    reordered: f64,
    duplicated: f64,
    corrupted: f64,
    /// Datagrams a second.
    forged: f64,
}

/// What happens at a moment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "fault")]
pub(super) enum What {
    /// The daemon is killed, and started again after as many ns, if ever.
    Kill {
        #[serde(rename = "for_ns")]
        time: Option<u64>,
    },
    /// The daemon is stopped for as many ns.
    Pause {
        #[serde(rename = "for_ns")]
        time: u64,
    },
    /// The serial line carries nothing for as many ns.
    Serial {
        #[serde(rename = "for_ns")]
        time: u64,
    },
    /// The disk is full for as many ns.
    Disk {
        #[serde(rename = "for_ns")]
        time: u64,
    },
    /// The operator is silent for as many ns.
    Operator {
        #[serde(rename = "for_ns")]
        time: u64,
    },
    /// The clock runs faster by `ppm` from now on, and jumps forward.
    Clock { ppm: f64, jump_ns: u64 },
}

impl What {
    /// Its name in the script.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Kill { .. } => "kill",
            Self::Pause { .. } => "pause",
            Self::Serial { .. } => "serial",
            Self::Disk { .. } => "disk",
            Self::Operator { .. } => "operator",
            Self::Clock { .. } => "clock",
        }
    }
}

/// A fault of the script.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Event {
    /// When, ns of the experiment's time.
    pub(super) at: u64,
    /// Whom it befalls; none if it is the operator.
    pub(super) robot: Option<u32>,
    #[serde(flatten)]
    pub(super) what: What,
}

/// A script with its random numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Faults {
    seed: u64,
    rules: Vec<Rule>,
    /// In the order of time.
    pub(super) events: Vec<Event>,
}

/// What happens to a copy of a datagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Copy {
    /// How long it is under way, ns.
    pub(super) time: u64,
    /// How it is changed, if it is.
    pub(super) damage: Option<u32>,
}

/// The fate of a datagram: one copy arrives as a rule, none if it is lost, or two.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Fate {
    pub(super) copies: [Option<Copy>; 2],
    pub(super) reordered: bool,
}

impl Faults {
    /// Reads a script for as many robots and seconds.
    ///
    /// # Errors
    /// Exit 3: the file, the line and column in it, the key, and what is allowed.
    pub fn read(path: &Path, robots: u32, seconds: u32) -> Result<Self> {
        let text = files::text(path)?;
        Self::of(&Parsed::new(path.display().to_string(), &text)?, robots, seconds)
    }

    fn of(file: &Parsed<'_>, robots: u32, seconds: u32) -> Result<Self> {
        let (written, source): (Written, _) = Source::read(file, &[])?;
        let script = Script {
            source: &source,
            seed: written.seed,
            robots,
            seconds: f64::from(seconds),
        };
        let mut rules = Vec::new();
        for (index, packets) in written.packets.iter().enumerate() {
            rules.push(script.rule(packets, &format!("packets[{index}]"))?);
        }
        let mut events = Vec::new();
        let tables = [
            ("kill", &written.kill),
            ("pause", &written.pause),
            ("serial", &written.serial),
            ("disk", &written.disk),
            ("operator", &written.operator),
            ("clock", &written.clock),
        ];
        for (kind, (table, events_of_table)) in (0..).zip(tables) {
            for (index, event) in (0..).zip(events_of_table) {
                let place = format!("{table}[{index}]");
                let what = script.what(table, event, &place)?;
                let moments = script.moments(event, kind << 16 | index, table == "operator", &place)?;
                events.extend(moments.into_iter().map(|(at, robot)| Event { at, robot, what }));
            }
        }
        // Stable: those of one moment keep the order of the tables.
        events.sort_by_key(|event| (event.at, event.robot));
        let seed = written.seed;
        Ok(Self { seed, rules, events })
    }

    fn rule(&self, receiver: u32, channel: Carrier, at: u64) -> Option<&Rule> {
        self.rules.iter().find(|rule| {
            rule.channel == channel && (rule.from..rule.to).contains(&at) && rule.robots.contains(&receiver)
        })
    }

    /// The fate of a datagram to a receiver, of which the sender has sent there as many before.
    pub(super) fn fate(&self, sender: u32, receiver: u32, count: u64, channel: Carrier, at: u64) -> Fate {
        let whole = Copy { time: 0, damage: None };
        let Some(rule) = self.rule(receiver, channel, at) else {
            return Fate {
                copies: [Some(whole), None],
                reordered: false,
            };
        };
        let mut draws = Draws::new(self.seed, sender, receiver, count);
        let lost = draws.is(rule.lost);
        let reordered = draws.is(rule.reordered);
        let duplicated = draws.is(rule.duplicated);
        let mut copy = || {
            let [least, greatest] = rule.latency;
            let time = least + draws.below(greatest - least + 1);
            let late = draws.below(OVERTAKEN);
            let damaged = draws.is(rule.corrupted);
            let damage = draws.word();
            Copy {
                time: time + if reordered { late } else { 0 },
                damage: damaged.then_some(damage),
            }
        };
        let copies = [copy(), copy()];
        Fate {
            copies: [(!lost).then_some(copies[0]), (!lost && duplicated).then_some(copies[1])],
            reordered,
        }
    }

    /// The datagrams that are forged for a receiver in a second of the experiment's time: when in it, ns, and what they are drawn from.
    pub(super) fn forged(&self, receiver: u32, second: u64) -> Vec<(u64, u32)> {
        let Some(rule) = self.rule(receiver, Carrier::Radio, second * SECOND) else {
            return Vec::new();
        };
        let mut draws = Draws::new(self.seed, FORGER, receiver, second);
        let count = rule.forged as u64 + u64::from(draws.is(rule.forged.fract()));
        (0..count).map(|_| (draws.below(SECOND), draws.word())).collect()
    }

    /// Whether the tracker loses a robot in a cycle, by chance.
    pub(super) fn is_unseen(&self, robot: u32, cycle: u64, chance: f64) -> bool {
        Draws::new(self.seed, TRACKER, robot | 1 << 31, cycle).is(chance)
    }
}

/// A datagram with the damage of a word.
pub(super) fn damaged(datagram: &[u8], damage: u32) -> Vec<u8> {
    let mut bytes = datagram.to_vec();
    let place = (damage >> 8) as usize;
    match damage & 3 {
        0 => bytes.truncate(place % bytes.len().max(1)),
        1 => bytes.extend(damage.to_le_bytes()),
        _ if bytes.is_empty() => bytes.push(place as u8),
        _ => {
            let at = place % bytes.len();
            bytes[at] ^= 1 << (damage >> 2 & 7);
        }
    }
    bytes
}

/// A forged datagram, drawn from a word: random bytes, or an earlier datagram, unchanged or changed.
pub(super) fn forgery(word: u32, said: &[Vec<u8>]) -> Vec<u8> {
    /// The longest of random bytes.
    const LONGEST: u64 = 200;
    let mut draws = Draws::new(u64::from(word), FORGER, FORGER, 0);
    let random = |draws: &mut Draws| {
        (0..=draws.below(LONGEST))
            .map(|_| draws.word() as u8)
            .collect::<Vec<u8>>()
    };
    let kind = draws.below(3);
    let Some(old) = said
        .get(draws.below(said.len().max(1) as u64) as usize)
        .filter(|_| kind > 0)
    else {
        return random(&mut draws);
    };
    if kind == 1 {
        old.clone()
    } else {
        damaged(old, draws.word())
    }
}

/// A stream of random numbers.
struct Draws {
    key: [u32; 4],
    next: u32,
    words: [u32; 4],
}

impl Draws {
    fn new(seed: u64, sender: u32, receiver: u32, count: u64) -> Self {
        let first = pcg4d([seed as u32, (seed >> 32) as u32, sender, receiver]);
        let [a, b, c, d] = first;
        Self {
            key: pcg4d([a ^ count as u32, b ^ (count >> 32) as u32, c, d]),
            next: 0,
            words: [0; 4],
        }
    }

    fn word(&mut self) -> u32 {
        let index = (self.next % 4) as usize;
        if index == 0 {
            let [a, b, c, d] = self.key;
            self.words = pcg4d([a ^ self.next, b, c, d]);
        }
        self.next += 1;
        self.words[index]
    }

    /// Yes with this probability.
    fn is(&mut self, chance: f64) -> bool {
        f64::from(self.word()) < chance * 2.0_f64.powi(32)
    }

    /// A number below `end`, which is 1 or more.
    fn below(&mut self, end: u64) -> u64 {
        let word = u64::from(self.word()) << 32 | u64::from(self.word());
        ((u128::from(word) * u128::from(end)) >> 64) as u64
    }
}

/// A script that is being read.
struct Script<'a> {
    source: &'a Source<'a>,
    seed: u64,
    robots: u32,
    seconds: f64,
}

impl Script<'_> {
    /// A value in a range, with its key and unit.
    fn within(&self, key: &str, value: f64, least: f64, greatest: f64, unit: &str) -> Result<f64> {
        if (least..=greatest).contains(&value) {
            return Ok(value);
        }
        let allowed = format!("{least} to {greatest} {unit}");
        let allowed = allowed.trim_end();
        Err(self.source.invalid(key, format_args!("is {value}; allowed: {allowed}")))
    }

    /// A time of the experiment, ns.
    fn time(&self, place: &str, key: &str, value: f64) -> Result<u64> {
        let seconds = self.within(&format!("{place}.{key}"), value, 0.0, self.seconds, "s")?;
        Ok((seconds * SECOND as f64).round() as u64)
    }

    /// A stretch of the experiment, ns.
    fn stretch(&self, place: &str, from: Option<f64>, to: Option<f64>) -> Result<[u64; 2]> {
        let from = self.time(place, "from_s", from.unwrap_or_default())?;
        let to = self.time(place, "to_s", to.unwrap_or(self.seconds))?;
        if from < to {
            return Ok([from, to]);
        }
        Err(self.source.invalid(
            &format!("{place}.to_s"),
            "is not after from_s; allowed: a later time of the experiment",
        ))
    }

    fn robots(&self, place: &str, robots: Option<&[u32]>) -> Result<Vec<u32>> {
        let all: Vec<u32> = (0..self.robots).collect();
        let robots = robots.unwrap_or(&all);
        let last = self.robots.saturating_sub(1);
        let key = format!("{place}.robots");
        if robots.is_empty() {
            return Err(self
                .source
                .invalid(&key, format_args!("is empty; allowed: numbers from 0 to {last}")));
        }
        match robots.iter().find(|robot| **robot > last) {
            Some(robot) => Err(self
                .source
                .invalid(&key, format_args!("has {robot}; allowed: 0 to {last}"))),
            None => Ok(robots.to_vec()),
        }
    }

    fn rule(&self, packets: &WrittenPackets, place: &str) -> Result<Rule> {
        /// Ours: as long as the operator's beacons last.
        const SLOWEST_MS: f64 = 1000.0;
        /// Ours: ten times as many as a robot hears of ten others and the operator.
        const MOST: f64 = 1000.0;
        let [from, to] = self.stretch(place, packets.from_s, packets.to_s)?;
        let key = |key: &str| format!("{place}.{key}");
        let share = |name: &str, value: f64| self.within(&key(name), value, 0.0, 1.0, "");
        let [least, greatest] = packets.latency_ms;
        for value in packets.latency_ms {
            self.within(&key("latency_ms"), value, 0.0, SLOWEST_MS, "ms")?;
        }
        if least > greatest {
            return Err(self.source.invalid(
                &key("latency_ms"),
                format_args!("is [{least}, {greatest}]; allowed: the minimum, then the maximum"),
            ));
        }
        let mut robots = self.robots(place, packets.robots.as_deref())?;
        robots.extend(packets.robots.is_none().then_some(OPERATOR));
        Ok(Rule {
            robots,
            channel: packets.channel,
            from,
            to,
            latency: packets.latency_ms.map(|ms| (ms * 1e6) as u64),
            lost: share("lost", packets.lost)?,
            reordered: share("reordered", packets.reordered)?,
            duplicated: share("duplicated", packets.duplicated)?,
            corrupted: share("corrupted", packets.corrupted)?,
            forged: self.within(&key("forged"), packets.forged, 0.0, MOST, "a second")?,
        })
    }

    /// An event's kind, by its table.
    fn what(&self, table: &str, event: &WrittenEvent, place: &str) -> Result<What> {
        let key = |key: &str| format!("{place}.{key}");
        let is_clock = table == "clock";
        for (name, is_given) in [("ppm", event.ppm.is_some()), ("jump_s", event.jump_s.is_some())] {
            if is_given && !is_clock {
                return Err(self
                    .source
                    .invalid_key(&key(name), "applies only to clocks; allowed: in a table [[clock]]"));
            }
        }
        if is_clock {
            if event.for_s.is_some() {
                let problem = "is not allowed for clocks, whose changes are permanent; allowed: ppm, jump_s";
                return Err(self.source.invalid_key(&key("for_s"), problem));
            }
            let ppm = self.within(&key("ppm"), event.ppm.unwrap_or_default(), -1000.0, 1000.0, "")?;
            let jump = self.within(&key("jump_s"), event.jump_s.unwrap_or_default(), 0.0, 3600.0, "s")?;
            let jump_ns = (jump * SECOND as f64) as u64;
            return Ok(What::Clock { ppm, jump_ns });
        }
        let time = event.for_s.map(|time| self.time(place, "for_s", time)).transpose()?;
        if table == "kill" {
            return Ok(What::Kill { time });
        }
        let Some(time) = time else {
            let problem = format!("for_s is missing; allowed: 0 to {} s", self.seconds);
            return Err(self.source.invalid(place, problem));
        };
        Ok(match table {
            "pause" => What::Pause { time },
            "serial" => What::Serial { time },
            "disk" => What::Disk { time },
            _ => What::Operator { time },
        })
    }

    /// When it happens, and to whom.
    fn moments(
        &self,
        event: &WrittenEvent,
        table: u32,
        operator: bool,
        place: &str,
    ) -> Result<Vec<(u64, Option<u32>)>> {
        /// Ours: of a table.
        const MOST: u32 = 100_000;
        let key = |key: &str| format!("{place}.{key}");
        if operator && event.robots.is_some() {
            let problem = "does not apply to the operator; allowed: without it";
            return Err(self.source.invalid_key(&key("robots"), problem));
        }
        let robots = self.robots(place, event.robots.as_deref())?;
        match (event.at_s, event.times) {
            (Some(at), None) if event.from_s.is_none() && event.to_s.is_none() => {
                let at = self.time(place, "at_s", at)?;
                let whom = if operator {
                    vec![None]
                } else {
                    robots.into_iter().map(Some).collect()
                };
                Ok(whom.into_iter().map(|robot| (at, robot)).collect())
            }
            (None, Some(times)) => {
                if !(1..=MOST).contains(&times) {
                    let problem = format!("is {times}; allowed: 1 to {MOST}");
                    return Err(self.source.invalid(&key("times"), problem));
                }
                let [from, to] = self.stretch(place, event.from_s, event.to_s)?;
                let draw = |count: u32| {
                    let mut draws = Draws::new(self.seed, u32::MAX, table, u64::from(count));
                    let at = from + draws.below(to - from);
                    let robot = robots[draws.below(robots.len() as u64) as usize];
                    (at, (!operator).then_some(robot))
                };
                Ok((0..times).map(draw).collect())
            }
            _ => Err(self.source.invalid(
                place,
                "has no time, or two kinds of it; allowed: at_s alone, or times with from_s and to_s",
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(text: &str) -> Result<Faults> {
        Faults::of(&Parsed::new("faults.toml".into(), text)?, 10, 600)
    }

    const ALL: &str = "seed = 7\n[[packets]]\nlatency_ms = [1.0, 5.0]\nlost = 0.3\nreordered = 0.2\nduplicated = 0.1\n\
                       corrupted = 0.05\nforged = 2.5\n[[kill]]\ntimes = 100\nfor_s = 2.0\n[[pause]]\nrobots = [2]\n\
                       at_s = 30\nfor_s = 3\n[[clock]]\nrobots = [5]\nat_s = 0\nppm = -200\njump_s = 1.5\n\
                       [[operator]]\nat_s = 500\nfor_s = 10\n";

    /// The fates of many datagrams, all that is forged, and all events.
    fn list(faults: &Faults) -> String {
        let fates = |sender| move |count| faults.fate(sender, (sender + 1) % 10, count, Carrier::Radio, count * SECOND);
        let fates: Vec<Fate> = (0..10).flat_map(|sender| (0..200).map(fates(sender))).collect();
        let forged: Vec<_> = (0..100).map(|second| faults.forged(3, second)).collect();
        format!("{fates:?}{forged:?}{:?}", faults.events)
    }

    #[test]
    fn the_same_seed_and_script_give_the_same_faults() {
        let one = faults(ALL).unwrap();
        assert_eq!(list(&one), list(&faults(ALL).unwrap()));
        let other = faults(&ALL.replace("seed = 7", "seed = 8")).unwrap();
        assert_ne!(list(&one), list(&other));
        assert_eq!(one.events.len(), 103);
        assert!(one.events.is_sorted_by_key(|event| event.at));
    }

    /// Changing a fraction changes no other random number, nor do datagrams to others.
    #[test]
    fn one_fault_does_not_shift_others() {
        let one = faults(ALL).unwrap();
        let other = faults(&ALL.replace("duplicated = 0.1", "duplicated = 0.9")).unwrap();
        for count in 0..500 {
            let fates = [&one, &other].map(|faults| faults.fate(1, 2, count, Carrier::Radio, SECOND));
            assert_eq!(fates[0].copies[0], fates[1].copies[0]);
        }
        assert_eq!(one.forged(1, 9), other.forged(1, 9));
        let killed = |faults: &Faults| faults.events.iter().filter(|event| event.what.name() == "kill").count();
        assert_eq!(killed(&one), 100);
    }

    #[test]
    fn shares_are_as_written() {
        const COUNT: u64 = 20_000;
        let faults = faults(ALL).unwrap();
        let fates: Vec<Fate> = (0..COUNT)
            .map(|count| faults.fate(1, 2, count, Carrier::Radio, SECOND))
            .collect();
        let share = |is: &dyn Fn(&Fate) -> bool| fates.iter().filter(|fate| is(fate)).count() as f64 / COUNT as f64;
        let near = |found: f64, expected: f64| {
            // Four standard errors.
            let error = 4.0 * (expected * (1.0 - expected) / COUNT as f64).sqrt();
            assert!((found - expected).abs() < error, "{found}, expected {expected}");
        };
        near(share(&|fate| fate.copies[0].is_none()), 0.3);
        near(share(&|fate| fate.reordered), 0.2);
        near(share(&|fate| fate.copies[1].is_some()), 0.7 * 0.1);
        near(
            share(&|fate| fate.copies[0].is_some_and(|copy| copy.damage.is_some())),
            0.7 * 0.05,
        );
        let forged: usize = (0..400).map(|second| faults.forged(3, second).len()).sum();
        near(forged as f64 / 400.0 - 2.0, 0.5);
        for fate in fates {
            for copy in fate.copies.into_iter().flatten() {
                let greatest = if fate.reordered { OVERTAKEN } else { 0 } + 5_000_000;
                assert!((1_000_000..=greatest).contains(&copy.time));
            }
        }
        // The tracker's lines are another channel.
        let whole = faults.fate(1, 2, 0, Carrier::Tracker, SECOND);
        assert_eq!(whole.copies, [Some(Copy { time: 0, damage: None }), None]);
    }

    #[test]
    fn damage_is_always_seen() {
        for damage in 0..4096_u32 {
            let word = damage.wrapping_mul(0x9e37_79b9);
            for datagram in [&b""[..], b"a", b"a datagram"] {
                let changed = damaged(datagram, word);
                assert!(
                    changed != datagram || datagram.is_empty() && word.trailing_zeros() >= 2,
                    "{word:x}"
                );
            }
        }
        let said = vec![b"one".to_vec(), b"two".to_vec()];
        let forgeries: Vec<_> = (0..300).map(|word| forgery(word, &said)).collect();
        assert!(forgeries.contains(&said[0]) && forgeries.contains(&said[1]));
        assert!(forgeries.iter().filter(|forgery| said.contains(forgery)).count() < 200);
    }

    #[test]
    fn what_is_not_allowed_is_refused_with_its_place() {
        for (text, words) in [
            (
                "[[packets]]\nlost = 1.5",
                "faults.toml:2:8: packets[0].lost: is 1.5; allowed: 0 to 1",
            ),
            ("[[packets]]\nlost = nan", "packets[0].lost: is NaN; allowed: 0 to 1"),
            (
                "[[packets]]\nlatency_ms = [5.0, 1.0]",
                "allowed: the minimum, then the maximum",
            ),
            (
                "[[packets]]\nfrom_s = 20\nto_s = 20",
                "packets[0].to_s: is not after from_s",
            ),
            (
                "[[packets]]\nchannel = \"light\"",
                "faults.toml:2:11: packets[0].channel: ",
            ),
            ("[[packets]]\nlots = 1", "faults.toml:2:1: "),
            (
                "[[kill]]\nat_s = 601",
                "faults.toml:2:8: kill[0].at_s: is 601; allowed: 0 to 600 s",
            ),
            (
                "[[kill]]\nrobots = [10]\nat_s = 1",
                "kill[0].robots: has 10; allowed: 0 to 9",
            ),
            (
                "[[kill]]\nrobots = []\nat_s = 1",
                "kill[0].robots: is empty; allowed: numbers from 0 to 9",
            ),
            (
                "[[kill]]",
                "kill[0]: has no time, or two kinds of it; allowed: at_s alone",
            ),
            (
                "[[kill]]\nat_s = 1\nto_s = 2",
                "allowed: at_s alone, or times with from_s and to_s",
            ),
            ("[[kill]]\ntimes = 0", "kill[0].times: is 0; allowed: 1 to 100000"),
            ("[[pause]]\nat_s = 1", "pause[0]: for_s is missing; allowed: 0 to 600 s"),
            (
                "[[serial]]\nat_s = 1\nfor_s = 1\nppm = 3",
                "serial[0].ppm: applies only to clocks",
            ),
            (
                "[[clock]]\nat_s = 1\njump_s = -1",
                "clock[0].jump_s: is -1; allowed: 0 to 3600 s",
            ),
            (
                "[[clock]]\nat_s = 1\nfor_s = 1",
                "clock[0].for_s: is not allowed for clocks",
            ),
            (
                "[[operator]]\nrobots = [1]\nat_s = 1\nfor_s = 1",
                "operator[0].robots: does not apply to the operator",
            ),
        ] {
            let refusal = faults(text).unwrap_err();
            assert_eq!(refusal.code(), 3);
            assert!(refusal.to_string().contains(words), "{text}: {refusal}");
        }
    }
}
