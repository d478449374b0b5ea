//! Fuzzing of all parsers of received bytes: valid streams that are damaged, cut and merged at random, and random bytes.
//! Nothing panics, every call returns, and no impossible reading is returned.
//!
//! A failure names its seed. With `ONEIRO_LONG` each of these tests has minutes of a processor.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use super::address::Address;
use super::aseba::tests::{from, head, named, words};
use super::aseba::{Message, Messages};
use super::emulated::khepera::{Firmware, Khepera, Rolling};
use super::error::{Error, Result};
use super::guard::message::Request;
use super::link::{Clock, Link};
use super::recording::Recording;
use super::recording::replay::Replay;
use super::script::Random;
use super::tracker::{Seen, lines};
use super::{Kind, Robot, epuck, epuck2, recognise, thymio};
use crate::mutations::for_seeds;

/// A robot's answer to bytes received at a time.
pub(super) type Answer = Box<dyn FnMut(&[u8], Duration) -> Vec<Vec<u8>> + Send>;

/// What a working robot sends: its answers to the bytes that it receives, and what it sends unasked every 20 ms.
pub(super) struct Valid {
    pub(super) answer: Answer,
    pub(super) unasked: Option<Box<dyn FnMut() -> Vec<u8> + Send>>,
}

impl Valid {
    fn new(answer: impl FnMut(&[u8], Duration) -> Vec<Vec<u8>> + Send + 'static) -> Self {
        Self {
            answer: Box::new(answer),
            unasked: None,
        }
    }
}

/// The air between a program and a robot.
struct Air {
    now: Duration,
    /// How many percent of what the robot sends are spoilt.
    spoilt: usize,
    /// Calls to the link since the last call to the driver.
    calls: u32,
    random: Random,
    valid: Valid,
    /// When the robot sends unasked next; none before it has heard anything.
    next: Option<Duration>,
    coming: VecDeque<(Duration, u8)>,
    /// Some of what was sent before.
    old: Vec<Vec<u8>>,
}

impl Air {
    const CYCLE: Duration = Duration::from_millis(20);

    /// Counts a call, which takes a moment, so that no loop of calls can last for ever.
    fn call(&mut self) {
        self.calls += 1;
        assert!(self.calls < 1_000_000, "a loop without an end");
        self.now += Duration::from_micros(1);
    }

    /// Sends bytes, a part of them spoilt and late.
    fn send(&mut self, bytes: Vec<u8>, from: Duration) {
        let is_spoilt = self.random.below(100) < self.spoilt;
        let late = self.random.below(if is_spoilt { 400_000 } else { 2000 });
        let sent = if is_spoilt { self.spoil(&bytes) } else { bytes.clone() };
        if self.old.len() < 16 {
            self.old.push(bytes);
        } else {
            let place = self.random.below(16);
            self.old[place] = bytes;
        }
        let mut at = from + Duration::from_micros(late as u64);
        // Where it is cut, it pauses.
        let cut = self.random.below(sent.len() + 1);
        for (index, byte) in sent.into_iter().enumerate() {
            if index == cut {
                at += Duration::from_micros(self.random.below(if is_spoilt { 100_000 } else { 5000 }) as u64);
            }
            let last = self.coming.back().map_or(at, |(last, _)| *last);
            self.coming.push_back((at.max(last), byte));
        }
    }

    fn spoil(&mut self, bytes: &[u8]) -> Vec<u8> {
        let random = &mut self.random;
        let old = match self.old.len() {
            0 => Vec::new(),
            count => self.old[random.below(count)].clone(),
        };
        match random.below(9) {
            0 => Vec::new(),
            1 | 2 => random.mutated(bytes),
            3 => [random.bytes(20), bytes.to_vec()].concat(),
            4 => [bytes, bytes].concat(),
            5 => bytes[..random.below(bytes.len() + 1)].to_vec(),
            6 => old,
            7 => [random.mutated(&old), bytes.to_vec()].concat(),
            _ => random.bytes(3000),
        }
    }

    /// Lets the robot send unasked until a time.
    fn live(&mut self, until: Duration) {
        while let (Some(next), Some(unasked)) = (self.next, &mut self.valid.unasked)
            && next <= until
        {
            let bytes = unasked();
            self.send(bytes, next);
            self.next = Some(next + Self::CYCLE);
        }
    }
}

/// A link through the air.
#[derive(Clone)]
struct Hostile(Arc<Mutex<Air>>);

impl Hostile {
    fn new(seed: u64, valid: Valid) -> Self {
        Self(Arc::new(Mutex::new(Air {
            now: Duration::from_secs(100),
            spoilt: 0,
            calls: 0,
            random: Random(seed),
            valid,
            next: None,
            coming: VecDeque::new(),
            old: Vec::new(),
        })))
    }

    fn air(&self) -> MutexGuard<'_, Air> {
        self.0.lock().unwrap()
    }
}

impl Clock for Hostile {
    fn now(&self) -> Duration {
        self.air().now
    }
}

impl Link for Hostile {
    fn name(&self) -> &'static str {
        "air"
    }

    fn read(&mut self, buffer: &mut [u8], until: Duration) -> Result<usize> {
        let mut air = self.air();
        air.call();
        if until <= air.now {
            return Ok(0);
        }
        if air.random.below(400) < air.spoilt {
            let (bytes, now) = (air.random.bytes(40), air.now);
            air.send(bytes, now);
        }
        air.live(until);
        let next = air.coming.front().map(|(at, _)| *at).filter(|at| *at < until);
        air.now = next.map_or(until, |at| at.max(air.now));
        drop(air);
        if next.is_some() { self.waiting(buffer) } else { Ok(0) }
    }

    fn waiting(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let mut air = self.air();
        air.call();
        let now = air.now;
        air.live(now);
        let come = air.coming.iter().take_while(|(at, _)| *at <= now).count();
        let most = come.min(buffer.len());
        // Now and then fewer than there are.
        let count = if most > 1 && air.random.below(4) == 0 {
            1 + air.random.below(most)
        } else {
            most
        };
        for (place, (_, byte)) in buffer.iter_mut().zip(air.coming.drain(..count)) {
            *place = byte;
        }
        Ok(count)
    }

    fn write(&mut self, bytes: &[u8], _: Duration) -> Result {
        let mut air = self.air();
        air.call();
        let now = air.now;
        air.next = air.next.or(Some(now));
        let is_spoilt = air.random.below(200) < air.spoilt;
        let heard = if is_spoilt {
            air.random.mutated(bytes)
        } else {
            bytes.to_vec()
        };
        for answer in (air.valid.answer)(&heard, now) {
            air.send(answer, now);
        }
        Ok(())
    }

    fn reopen(&mut self) -> Result {
        let mut air = self.air();
        air.call();
        air.coming.clear();
        air.next = None;
        Ok(())
    }
}

/// The emulated Khepera.
pub(super) fn khepera(seed: u64) -> Valid {
    let mut robot = Khepera::new(Rolling::default(), Firmware::ALL[seed as usize % 4], 115_200);
    Valid::new(move |bytes, now| {
        robot.receive(bytes, now);
        let said: Vec<u8> = robot.timed().into_iter().map(|(_, byte)| byte).collect();
        said.split_inclusive(|byte| *byte == b'\n')
            .map(<[u8]>::to_vec)
            .collect()
    })
}

/// Answers of an e-puck to a line of text.
fn epuck_line(line: &str, version: &str, speeds: &mut [i16; 2]) -> Option<String> {
    let fields: Vec<i16> = line.split(',').skip(1).filter_map(|field| field.parse().ok()).collect();
    let letter = line.chars().next()?;
    Some(match (letter, &fields[..]) {
        ('D', &[left, right]) => {
            *speeds = [left, right];
            "d\r\n".into()
        }
        ('E', _) => format!("e,{},{}\r\n", speeds[0], speeds[1]),
        ('V', _) => version.into(),
        ('N' | 'O', _) => format!("{},1,2,3,4,5,6,7,4095\r\n", letter.to_lowercase()),
        ('A' | 'U', _) => format!("{},2048,2000,2900\r\n", letter.to_lowercase()),
        ('Q', _) => "q,5,-6\r\n".into(),
        ('b', _) => "b,1\r\n".into(),
        ('L' | 'B' | 'F', _) => format!("{}\r\n", letter.to_lowercase()),
        _ => return None,
    })
}

/// The length of a chain of binary commands with its end, and the answer; none if it is not whole.
fn epuck_chain(heard: &[u8], speeds: &mut [i16; 2]) -> Option<(usize, Vec<u8>)> {
    let (mut at, mut answer) = (0, Vec::new());
    loop {
        let code = heard.get(at)?.wrapping_neg();
        at += 1;
        let count = match code {
            b'D' => 4,
            b'L' => 2,
            _ => 0,
        };
        let arguments = heard.get(at..at + count)?;
        at += count;
        let values: Vec<i16> = match code {
            0 => return Some((at, answer)),
            b'D' => {
                let word = |at: usize| i16::from_le_bytes([arguments[at], arguments[at + 1]]);
                *speeds = [word(0), word(2)];
                Vec::new()
            }
            b'N' | b'O' => vec![7; 8],
            b'E' => speeds.to_vec(),
            b'Q' => vec![300, -300],
            b'a' | b'u' | b'g' => vec![1, 2, 3],
            b'M' => vec![4; 4],
            0x0d => vec![5],
            _ => Vec::new(),
        };
        answer.extend(values.into_iter().flat_map(i16::to_le_bytes));
    }
}

/// An e-puck, or an e-puck2, whose firmware understands binary commands or not.
pub(super) fn epuck(version: &'static str, is_binary: bool) -> Valid {
    let (mut heard, mut speeds) = (Vec::new(), [0; 2]);
    Valid::new(move |bytes, _| {
        heard.extend_from_slice(bytes);
        let mut answers = Vec::new();
        loop {
            match heard.first() {
                None => return answers,
                Some(128..) if is_binary => {
                    let Some((count, answer)) = epuck_chain(&heard, &mut speeds) else {
                        return answers;
                    };
                    heard.drain(..count);
                    answers.push(answer);
                }
                Some(0 | 128..) => drop(heard.remove(0)),
                Some(_) => {
                    let Some(end) = heard.iter().position(|byte| *byte == b'\r') else {
                        return answers;
                    };
                    let line: Vec<u8> = heard.drain(..=end).collect();
                    let line = String::from_utf8_lossy(&line[..end]);
                    answers.extend(epuck_line(&line, version, &mut speeds).map(String::into_bytes));
                }
            }
        }
    })
}

/// An e-puck2 on Wi-Fi.
pub(super) fn wifi() -> Valid {
    Valid {
        unasked: Some(Box::new(|| epuck2::tests::answer([1, 2]))),
        ..Valid::new(|_, _| Vec::new())
    }
}

/// A Thymio II that describes itself whole, or a variable at a time.
pub(super) fn thymio_of(version: u16) -> Valid {
    const NAMES: [(&str, u16); 9] = [
        ("_id", 1),
        ("_vbat", 2),
        ("motor.left.target", 1),
        ("motor.right.target", 1),
        ("motor.left.speed", 1),
        ("motor.right.speed", 1),
        ("prox.horizontal", 7),
        ("prox.ground.delta", 2),
        ("acc", 3),
    ];
    let mut memory = [7_u16; 64];
    Valid::new(move |bytes, _| {
        let head = || head(1, "thymio-II", version, 586, [NAMES.len() as u16, 0, 0]);
        let variable = |index: usize| NAMES.get(index).map(|(name, size)| named(1, *size, name));
        // Commands come whole, and of one that is spoilt nothing is kept: a node has its own ways to get back in step.
        let heard = Messages::default().push(bytes).unwrap_or_default();
        let answer = |Message { kind, payload, .. }| -> Option<Vec<u8>> {
            let said: Vec<u16> = payload.as_chunks().0.iter().copied().map(u16::from_le_bytes).collect();
            match (kind, &said[..]) {
                (0xa011, _) => Some(from(1, 0x900c, &words(&[version]))),
                (0xa010, _) => Some(
                    (0..NAMES.len())
                        .filter_map(variable)
                        .fold(head(), |all, one| [all, one].concat()),
                ),
                (0xa015, [_, _, 0xffff]) => Some(head()),
                (0xa015, [_, _, index]) => variable((*index).into()),
                (0xa007, _) => Some(from(1, 0x900a, &words(&[0, 2]))),
                (0xa00b, [_, start, count]) => {
                    let end = usize::from(*start) + usize::from(*count);
                    let values = memory.get(usize::from(*start)..end)?;
                    Some(from(1, 0x9005, &words(&[&[*start], values].concat())))
                }
                (0xa00c, [_, address, values @ ..]) => {
                    let first = usize::from(*address);
                    memory.get_mut(first..first + values.len())?.copy_from_slice(values);
                    None
                }
                _ => None,
            }
        };
        heard.into_iter().filter_map(answer).collect()
    })
}

/// No call takes longer on the robot's clock.
const LIMIT: Duration = Duration::from_secs(20);

/// Uses a robot as a program might. Returns how many readings it gave.
fn used(robot: &mut dyn Robot, air: &Hostile, random: &mut Random, has_check: bool) -> usize {
    let mut readings = 0;
    for _ in 0..20 {
        air.air().calls = 0;
        let start = air.now();
        let groups = robot.description().sensors.clone();
        match random.below(9) {
            0 => drop(robot.drive(random.below(4000) as i32 - 2000, 5)),
            1 => drop(robot.stop()),
            2 => drop(robot.stop_briefly()),
            3 => drop(robot.light(random.below(11), true)),
            4 => {
                let volts = robot.battery().ok().and_then(|battery| battery.volts);
                assert!(volts.is_none_or(f64::is_finite), "{volts:?}");
            }
            5 => drop(robot.lifted()),
            6 => drop(robot.odometry()),
            7 => drop(robot.reconnect()),
            _ if groups.is_empty() => {}
            _ => {
                let chosen: Vec<_> = (0..=random.below(3))
                    .map(|_| groups[random.below(groups.len())])
                    .collect();
                let kinds: Vec<Kind> = chosen.iter().map(|group| group.kind).collect();
                if let Ok(reading) = robot.sense(&kinds) {
                    let mut rest = &reading.values[..];
                    for group in chosen {
                        let (of_group, next) = rest.split_at(group.names.len());
                        assert!(!has_check || group.accepts(of_group), "{reading:?}");
                        rest = next;
                    }
                    assert!(rest.is_empty(), "{reading:?}");
                    assert!(reading.at <= air.now() && reading.values.iter().all(|value| value.is_finite()));
                    readings += 1;
                }
            }
        }
        let took = air.now().saturating_sub(start);
        assert!(took < LIMIT, "{took:?}");
    }
    readings
}

type Open = fn(Box<dyn Link>) -> Result<Option<Box<dyn Robot>>>;

/// Uses a driver with peers that are well when it connects, or never are.
fn fuzzed(seeds: u64, open: Open, has_check: bool, valid: impl Fn(u64) -> Valid) {
    let (mut found, mut readings) = (0, 0);
    for_seeds(seeds, |seed| {
        let mut random = Random(seed ^ 0x5eed);
        let air = Hostile::new(seed, valid(seed));
        let spoilt = [1, 5, 20, 60, 100][random.below(5)];
        let is_well_first = random.below(4) > 0;
        if !is_well_first {
            air.air().spoilt = spoilt;
        }
        let opened = open(Box::new(air.clone()));
        assert!(air.now() < Duration::from_secs(200));
        assert!(!is_well_first || matches!(&opened, Ok(Some(_))), "{:?}", opened.err());
        let Ok(Some(mut robot)) = opened else { return };
        found += 1;
        air.air().spoilt = spoilt;
        readings += used(&mut *robot, &air, &mut random, has_check);
        // However it was treated, it is well again when the robot is.
        air.air().spoilt = 0;
        air.air().now += Duration::from_secs(5);
        air.air().calls = 0;
        let again = robot.reconnect().or_else(|_| robot.reconnect());
        assert!(again.is_ok() || is_other(again.as_ref().err()), "{again:?}");
    });
    assert!(found > seeds as usize / 2 && readings > 0, "{found} {readings}");
}

/// A link that was taken for another robot's is not found again.
fn is_other(error: Option<&Error>) -> bool {
    matches!(error, Some(Error::Unknown { .. }))
}

const SEEDS: u64 = 400;

#[test]
fn a_khepera_may_send_anything() {
    fuzzed(SEEDS, recognise, true, khepera);
}

#[test]
fn an_e_puck_may_send_anything() {
    let kinds = [
        (epuck::tests::VERSION_1, false),
        (epuck::tests::VERSION_1, true),
        (epuck::tests::VERSION_2, true),
    ];
    fuzzed(3 * SEEDS, recognise, true, |seed| {
        let (version, is_binary) = kinds[seed as usize % 3];
        epuck(version, is_binary)
    });
}

#[test]
fn an_e_puck2_on_wifi_may_send_anything() {
    let open: Open = |link| Ok(epuck2::EPuck2::connect(link)?.map(|robot| Box::new(robot) as Box<dyn Robot>));
    fuzzed(SEEDS, open, true, |_| wifi());
}

/// The readings are a node's variables, which may have any value: cables and TCP have checks.
#[test]
fn a_thymio_may_send_anything() {
    let open: Open = |link| Ok(Some(Box::new(thymio::Thymio::connect(link, None)?)));
    fuzzed(SEEDS, open, false, |seed| thymio_of(if seed % 2 == 0 { 5 } else { 9 }));
}

/// A network on which ever more nodes answer.
#[test]
fn a_network_without_an_end_is_given_up() {
    let mut id = 0_u16;
    let valid = Valid {
        unasked: Some(Box::new(move || {
            id = id.wrapping_add(1);
            from(id, 0x900c, &words(&[5]))
        })),
        ..Valid::new(|_, _| Vec::new())
    };
    let air = Hostile::new(1, valid);
    let outcome = thymio::Thymio::connect(Box::new(air.clone()), None);
    assert!(outcome.is_err());
    assert!(air.now() < Duration::from_secs(100) + LIMIT);
}

/// A node that describes itself without an end: a thousand variables, of which each has to be asked for three times.
#[test]
fn a_description_without_an_end_is_given_up() {
    let mut asked = 0_u32;
    let valid = Valid::new(move |bytes, _| {
        let heard = Messages::default().push(bytes).unwrap_or_default();
        let kind = heard.first().map_or(0, |message| message.kind);
        asked += u32::from(kind == 0xa015);
        match kind {
            0xa011 => vec![from(1, 0x900c, &words(&[9]))],
            0xa015 if asked == 1 => vec![head(1, "thymio-II", 9, 2000, [1000, 0, 0])],
            0xa015 if asked.is_multiple_of(3) => vec![named(1, 1, "x")],
            _ => Vec::new(),
        }
    });
    let air = Hostile::new(1, valid);
    let outcome = thymio::Thymio::connect(Box::new(air.clone()), None);
    assert!(outcome.is_err());
    let took = air.now().checked_sub(Duration::from_secs(100)).unwrap();
    assert!(
        (Duration::from_secs(30)..Duration::from_secs(40)).contains(&took),
        "{took:?}"
    );
}

/// Valid addresses are shown unchanged in meaning.
#[test]
fn an_address_may_be_anything() {
    let known = [
        "serial:/dev/ttyUSB0@38400",
        "serial:COM3",
        "tcp:[fe80::1]:1000",
        "tcp:192.168.1.7:1000",
        "aseba:localhost:33333#2",
        "aseba:tcp:serial:33333",
        "tcp:[[a]]:1",
        "aseba:serial:/dev/ttyACM0@115200#33084",
        "surrogate:18446744073709551615",
    ];
    let mut accepted = 0;
    for_seeds(50_000, |seed| {
        let mut random = Random(seed);
        let known = known[random.below(known.len())].as_bytes();
        let bytes = if random.below(8) == 0 {
            random.bytes(60)
        } else {
            random.mutated(known)
        };
        let text = String::from_utf8_lossy(&bytes);
        match text.parse::<Address>() {
            Ok(address) => {
                accepted += 1;
                assert_eq!(address.to_string().parse(), Ok(address), "{text:?}");
            }
            Err(refusal) => assert!(refusal.to_string().contains(&format!("robot {text}: ")), "{refusal}"),
        }
    });
    assert!(accepted > 1000, "{accepted}");
}

/// A message that the guard accepts has numbers only, and is written unchanged in meaning.
#[test]
fn a_message_to_the_guard_may_be_anything() {
    let valid = [
        r#"{"hello":{"version":1}}"#,
        r#"{"command":{"sequence":18446744073709551615,"left_mm_s":50.0,"right_mm_s":-5e-1}}"#,
        r#"{"tracker":{"lost":true}}"#,
        r#""stop""#,
        r#""resume""#,
        r#""end""#,
    ];
    let mut accepted = 0;
    for_seeds(50_000, |seed| {
        let mut random = Random(seed);
        let known = valid[random.below(valid.len())].as_bytes();
        let bytes = if random.below(8) == 0 {
            random.bytes(200)
        } else {
            random.mutated(known)
        };
        let Ok(request) = serde_json::from_slice::<Request>(&bytes) else {
            return;
        };
        accepted += 1;
        if let Request::Command {
            left_mm_s, right_mm_s, ..
        } = request
        {
            assert!(left_mm_s.is_finite() && right_mm_s.is_finite(), "{request:?}");
        }
        let line = serde_json::to_string(&request).unwrap();
        assert_eq!(serde_json::from_str::<Request>(&line).unwrap(), request);
    });
    assert!(accepted > 100, "{accepted}");
    // Nothing is nested so deep that it can't be read.
    for open in ["[", "{\"command\":"] {
        assert!(serde_json::from_str::<Request>(&open.repeat(4096 / open.len())).is_err());
    }
}

/// A tracker's line that counts is a robot's, with numbers only.
#[test]
fn a_line_of_a_tracker_may_be_anything() {
    let valid = [
        r#"{"id":1,"t":12.3,"x":350.0,"y":-2e1,"heading":0.25}"#,
        r#"{"id":1,"t":12.3,"x":350.0,"y":200.0,"heading":-0.25,"carries":true,"brought":4,"heard":[0,7,127,128]}"#,
        r#"{"id":1,"t":12.3,"x":350.0,"y":200.0,"heading":7,"carries":null,"heard":[],"more":{"a":[1,"b"]}}"#,
    ];
    let mut accepted = 0;
    for_seeds(20_000, |seed| {
        let mut random = Random(seed);
        let known = valid[random.below(valid.len())].as_bytes();
        let line = match random.below(8) {
            0 => random.bytes(200),
            1 => [known, b"\n", known].concat(),
            _ => random.mutated(known),
        };
        let mut seen = Seen::new(1, 200.0, Duration::from_millis(300));
        // As often as it takes to be certain, by a clock that goes on.
        for time in 0..3 {
            let text = String::from_utf8_lossy(&line).replace("12.3", &format!("12.{time}"));
            for line in lines(text.as_bytes()) {
                let Some(sighting) = seen.take(line, Duration::from_millis(time)) else {
                    continue;
                };
                accepted += 1;
                let [x, y, heading] = sighting.pose();
                assert!(
                    x.is_finite() && y.is_finite() && (0.0..=1.0).contains(&heading),
                    "{sighting:?}"
                );
            }
        }
    });
    assert!(accepted > 1000, "{accepted}");
    let nested = "[".repeat(2000);
    let mut seen = Seen::new(1, 200.0, Duration::from_millis(300));
    assert_eq!(
        seen.take(format!("{{\"id\":1,\"heard\":{nested}").as_bytes(), Duration::ZERO),
        None
    );
}

/// A recording that is spoilt is refused by its line, or plays back to errors.
#[test]
fn a_recording_may_be_anything() {
    let path = std::env::temp_dir().join(format!("oneiro-fuzz-{}", std::process::id()));
    // Left by an earlier test of the same number.
    let _ = std::fs::remove_file(&path);
    let recording = Recording::create(&path).unwrap();
    let air = Hostile::new(0, khepera(0));
    let mut robot = recognise(recording.of(Box::new(air))).unwrap().unwrap();
    let played = |robot: &mut dyn Robot| {
        let outcomes = [
            robot
                .sense(&[Kind::Proximity])
                .map(|reading| assert_eq!(reading.values.len(), 8)),
            robot.drive(3, 4),
            robot.odometry().map(drop),
            robot.reconnect(),
        ];
        outcomes.iter().filter(|outcome| outcome.is_ok()).count()
    };
    assert_eq!(played(&mut *robot), 4);
    drop(robot);
    assert_eq!(recording.finish(), None);
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    let (mut refused, mut done) = (0, 0);
    for_seeds(4000, |seed| {
        let mut random = Random(seed);
        let bytes = random.mutated(text.as_bytes());
        match Replay::parse(&String::from_utf8_lossy(&bytes)) {
            Err(problem) => {
                assert!(problem.starts_with("line "), "{problem}");
                refused += 1;
            }
            Ok(replays) => {
                for replay in replays {
                    if let Ok(Some(mut robot)) = recognise(Box::new(replay)) {
                        done += played(&mut *robot);
                    }
                }
            }
        }
    });
    assert!(refused > 100 && done > 100, "{refused} {done}");
}
