//! Datagrams that are good, and those that were damaged, repeated, delayed or forged.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use oneiro_robots::script::Random;

use super::limits::TOLERANCE;
use super::*;
use crate::mutations::for_seeds_within;

const LIMITS: Limits = Limits {
    robots: 10,
    interval: 60,
    offset: 5,
    lag: 0,
    fitness: 9000.0,
    seconds: 50_100,
    food: 1000,
};
const EXPERIMENT: [u8; 32] = [0xe1; 32];
/// The number of the operator's start.
const START: u64 = 0x0807_0605_0403_0201;
const NOW: Duration = Duration::from_secs(1000);

fn radio(own: u16, boots: u32) -> Radio {
    Radio::new(own, LIMITS, &Key::of(1), EXPERIMENT, boots)
}

fn message(sender: u16, interval: u32) -> Message {
    Message {
        sender: sender.into(),
        interval,
        simulator: 0.5,
        fitness: 123.25,
        controller: [0.0, 0.99],
    }
}

fn pair(sender: u16, second: u32, interval: u32) -> Packet {
    Packet::Pair {
        second,
        message: message(sender, interval),
    }
}

fn beacon(milliseconds: i64) -> Packet {
    Packet::Beacon {
        milliseconds,
        go: true,
        start: START,
    }
}

fn hello() -> Packet {
    Packet::Hello {
        program: "0.2.0".into(),
        experiment: EXPERIMENT,
        start: START,
    }
}

fn status() -> Status {
    Status {
        start: START,
        milliseconds: 200_123,
        state: 3,
        interval: 3,
        simulator: 0.25,
        real: 30.5,
        simulated: -1.0,
        controller: [0.125, 0.75],
        brought: 7,
        carries: true,
        pose: [-350.0, 20.5, 0.75],
        volts: 3.75,
        problems: 0b101,
        ignored: 9,
    }
}

/// A datagram with another body and the right tag.
fn retagged(radio: &Radio, datagram: &[u8], change: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut bytes = datagram[..datagram.len() - TAG].to_vec();
    change(&mut bytes);
    let tag = radio.tag(&bytes);
    bytes.extend_from_slice(&tag);
    bytes
}

#[test]
fn packets_arrive_as_they_were_sealed() {
    let (mut robot, mut operator) = (radio(3, 2), radio(OPERATOR, 9));
    let mut receiver = radio(5, 1);
    let packets = [pair(3, 200, 3), Packet::Status(status()), hello()];
    for (packet, number) in packets.into_iter().zip(1..) {
        let datagram = robot.seal(&packet);
        assert_eq!(robot.sequence(), 2 << 32 | number);
        let received = receiver.open(&datagram, NOW, Some(200)).unwrap();
        assert_eq!((received.sender, received.sequence), (3, robot.sequence()));
        assert_eq!(received.packet, packet);
    }
    for go in [true, false] {
        let packet = Packet::Beacon {
            milliseconds: -1,
            go,
            start: START,
        };
        let received = receiver.open(&operator.seal(&packet), NOW, None).unwrap();
        assert_eq!((received.sender, received.packet), (OPERATOR, packet));
    }
    // A long name is cut where a character ends.
    let long = Packet::Hello {
        program: "\u{e9}".repeat(20),
        experiment: EXPERIMENT,
        start: u64::MAX,
    };
    let datagram = robot.seal(&long);
    assert_eq!(datagram.len(), LONGEST);
    let received = receiver.open(&datagram, NOW, None).unwrap();
    assert!(matches!(received.packet, Packet::Hello { program, .. } if program == "\u{e9}".repeat(16)));
    assert_eq!(receiver.refused(), &Refused::default());
}

fn in_hex(bytes: &[u8]) -> String {
    let digits: Vec<String> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    digits.concat()
}

/// The bytes match the description, written out by hand.
#[test]
fn bytes_are_as_described() {
    let datagram = radio(OPERATOR, 2).seal(&beacon(0x0102_0304));
    let hex = in_hex(&datagram[..datagram.len() - TAG]);
    let expected = [
        "314f4e45",
        "0200",
        "02",
        "ffff",
        "e1e1e1e1e1e1e1e1",
        "0100000002000000",
        "0403020100000000",
        "01",
        "0102030405060708",
    ];
    assert_eq!(hex, expected.concat());
    let datagram = radio(7, 0).seal(&pair(7, 0x0201, 8));
    let hex = in_hex(&datagram[25..datagram.len() - TAG]);
    let expected = ["01020000", "08000000", "0000003f", "0080f642", "00000000", "a4707d3f"];
    assert_eq!(hex, expected.concat());
    // The tag is the first half of a keyed hash.
    let key = blake3::derive_key("Oneiro 2026 tags of datagrams between robots", &[1; 32]);
    let (sealed, tag) = datagram.split_at(datagram.len() - TAG);
    assert_eq!(tag, &blake3::keyed_hash(&key, sealed).as_bytes()[..16]);
}

#[test]
fn each_refusal_names_its_reason() {
    let mut receiver = radio(5, 1);
    let good = radio(3, 0).seal(&pair(3, 200, 3));
    let mut other_key = Radio::new(3, LIMITS, &Key::of(2), EXPERIMENT, 0);
    let mut elsewhere = Radio::new(300, LIMITS, &Key::of(1), [0xe2; 32], 0);
    let there = |program: Option<&str>| Refusal::OtherExperiment {
        sender: 300,
        hash: [0xe2; 8],
        program: program.map(str::to_owned),
    };
    let says_hello = Packet::Hello {
        program: "0.3.0".into(),
        experiment: [0xe2; 32],
        start: 0,
    };
    // Their header has this experiment's bytes, and only the rest of the hash shows that it is another.
    let mut twin = EXPERIMENT;
    twin[31] = 0;
    let twin_hello = Packet::Hello {
        program: "0.2.0".into(),
        experiment: twin,
        start: 0,
    };
    let newer = [&good[..4], &[3, 0], &good[6..]].concat();
    let cases = [
        (b"1ONF and more".to_vec(), Refusal::NotOurs),
        (good[..30].to_vec(), Refusal::NotOurs),
        ([&good[..], &[0; LONGEST]].concat(), Refusal::NotOurs),
        (newer, Refusal::OtherVersion(3)),
        (b"1ONE\x07\x00".to_vec(), Refusal::OtherVersion(7)),
        (elsewhere.seal(&pair(300, 200, 3)), there(None)),
        (elsewhere.seal(&says_hello), there(Some("0.3.0"))),
        (other_key.seal(&pair(3, 200, 3)), Refusal::Forged),
        (radio(5, 0).seal(&pair(5, 200, 3)), Refusal::Own),
        (radio(10, 0).seal(&hello()), Refusal::OutOfRange("sender")),
        (
            radio(4, 0).seal(&twin_hello),
            Refusal::OtherExperiment {
                sender: 4,
                hash: [0xe1; 8],
                program: Some("0.2.0".into()),
            },
        ),
        (radio(3, 0).seal(&beacon(0)), Refusal::OutOfRange("kind")),
    ];
    for (datagram, refusal) in cases {
        assert_eq!(receiver.open(&datagram, NOW, Some(200)), Err(refusal));
    }
    // The beacon of robot 3 was its first datagram.
    assert_eq!(receiver.open(&good, NOW, Some(200)), Err(Refusal::Replayed));
    let counts: Vec<u64> = receiver.refused().counts().map(|(_, count)| count).collect();
    assert_eq!(counts, [3, 2, 3, 1, 1, 0, 2, 1]);
    assert_eq!(Refusal::Forged.reason(), "forged");
    let words = there(Some("0.3.0")).to_string();
    assert_eq!(
        words,
        "sender 300 runs another experiment, e2e2e2e2e2e2e2e2, with program 0.3.0"
    );
    assert_eq!(
        Refusal::OtherVersion(1).to_string(),
        "has version 1 of datagrams; allowed: 2"
    );
}

/// Packets that a robot or the operator may not send, each with the name of the bad value, in second 200 of the receiver.
fn out_of_range() -> Vec<(u16, Packet, &'static str)> {
    const GENES: [f32; 8] = [
        f32::NAN,
        f32::INFINITY,
        -0.01,
        -0.0,
        1e-40,
        0.990_000_1,
        1.0,
        f32::NEG_INFINITY,
    ];
    const NUMBERS: [f32; 4] = [f32::NAN, f32::INFINITY, -2.0, 9000.5];
    let mut all = vec![
        (OPERATOR, pair(OPERATOR, 200, 3), "kind"),
        (3, beacon(200_000), "kind"),
        (OPERATOR, Packet::Status(status()), "kind"),
        (OPERATOR, beacon(i64::MAX), "milliseconds"),
        (OPERATOR, beacon(i64::MIN), "milliseconds"),
        (OPERATOR, beacon(-86_400_001), "milliseconds"),
        (OPERATOR, beacon(50_100_000 + 3_600_001), "milliseconds"),
        (3, Packet::Call { start: START }, "kind"),
        (3, pair(3, 203, 3), "second"),
        (3, pair(3, 197, 3), "second"),
        (3, pair(3, u32::MAX, 3), "second"),
        (3, pair(3, 200, 2), "interval"),
        (3, pair(3, 200, 4), "interval"),
        (3, pair(3, 200, u32::MAX), "interval"),
    ];
    let mut pairs = |name, change: &dyn Fn(&mut Message)| {
        let mut message = message(3, 3);
        change(&mut message);
        all.push((3, Packet::Pair { second: 200, message }, name));
    };
    for gene in GENES {
        pairs("simulator", &|message| message.simulator = gene);
        pairs("controller", &|message| message.controller[0] = gene);
        pairs("controller", &|message| message.controller[1] = gene);
    }
    for number in NUMBERS {
        pairs("fitness", &|message| message.fitness = number);
    }
    let mut statuses = |name, change: &dyn Fn(&mut Status)| {
        let mut status = status();
        change(&mut status);
        all.push((3, Packet::Status(status), name));
    };
    statuses("milliseconds", &|status| status.milliseconds = 1 << 42);
    for gene in GENES {
        statuses("simulator", &|status| status.simulator = gene);
        statuses("controller", &|status| status.controller[1] = gene);
    }
    for number in NUMBERS {
        statuses("real", &|status| status.real = number);
        statuses("simulated", &|status| status.simulated = number);
    }
    for number in [f32::NAN, f32::INFINITY] {
        statuses("pose", &|status| status.pose[2] = number);
        statuses("volts", &|status| status.volts = number);
    }
    for volts in [-0.5, 100.5] {
        statuses("volts", &|status| status.volts = volts);
    }
    statuses("interval", &|status| status.interval = 836);
    for brought in [1001, u32::MAX] {
        statuses("brought", &|status| status.brought = brought);
    }
    for (part, number) in [(0, 1e6), (1, -1.1e5), (0, f32::NAN), (1, f32::NAN), (2, -0.1), (2, 1.5)] {
        statuses("pose", &|status| status.pose[part] = number);
    }
    all
}

type Change = fn(&mut Vec<u8>);

/// Bodies that can't be read, with the right tag.
fn unreadable(radio: &Radio, datagram: &[u8], choice: usize) -> Vec<u8> {
    retagged(radio, datagram, |bytes| match choice {
        0 => bytes[6] = 0,
        1 => bytes[6] = 6,
        2 => drop(bytes.pop()),
        3 => bytes.push(0),
        _ => bytes.truncate(25),
    })
}

#[test]
fn values_out_of_range_are_refused_by_their_names() {
    for (sender, packet, name) in out_of_range() {
        let datagram = radio(sender, 1).seal(&packet);
        let opened = radio(5, 0).open(&datagram, NOW, Some(200));
        assert_eq!(opened, Err(Refusal::OutOfRange(name)), "{packet:?}");
    }
    // Values just within the limits, and values that are not checked if the second is unknown.
    let mut sender = radio(3, 1);
    let mut receiver = radio(5, 0);
    for (second, interval) in [(202, 3), (198, 3)] {
        receiver
            .open(&sender.seal(&pair(3, second, interval)), NOW, Some(200))
            .unwrap();
    }
    receiver.open(&sender.seal(&pair(3, 50_000, 833)), NOW, None).unwrap();
    // From 240 on robots that were switched on at 0 are in interval 4; until 244 others are in 3.
    for (second, interval, is_valid) in [
        (239, 4, false),
        (240, 3, true),
        (240, 4, true),
        (244, 3, true),
        (245, 3, false),
    ] {
        let opened = radio(5, 0).open(&sender.seal(&pair(3, second, interval)), NOW, Some(second));
        assert_eq!(opened.is_ok(), is_valid, "{second} {interval}");
    }
    // Robots that report their last whole interval.
    let limits = Limits { lag: 1, ..LIMITS };
    for (interval, is_valid) in [(2, true), (3, false)] {
        let mut receiver = Radio::new(5, limits, &Key::of(1), EXPERIMENT, 0);
        let opened = receiver.open(&sender.seal(&pair(3, 200, interval)), NOW, Some(200));
        assert_eq!(opened.is_ok(), is_valid, "{interval}");
    }
    let mut sender = radio(3, 7);
    let status = sender.seal(&Packet::Status(status()));
    for choice in 0..5 {
        let name = if choice < 2 { "kind" } else { "length" };
        let opened = radio(5, 0).open(&unreadable(&sender, &status, choice), NOW, None);
        assert_eq!(opened, Err(Refusal::OutOfRange(name)));
    }
    let hello = sender.seal(&hello());
    let spoilt: [(&[u8], &str, Change); 5] = [
        (&status, "carries", |bytes| bytes[25 + 45] = 2),
        (&hello, "program", |bytes| bytes[34] = b'\x1b'),
        (&hello, "program", |bytes| bytes[34] = 0xff),
        (&hello, "program", |bytes| bytes[33] = 33),
        (&hello, "length", |bytes| bytes[33] = 4),
    ];
    for (datagram, name, change) in spoilt {
        let opened = radio(5, 0).open(&retagged(&sender, datagram, change), NOW, None);
        assert_eq!(opened, Err(Refusal::OutOfRange(name)));
    }
}

/// A datagram is never taken twice: not while the receiver runs, and not after a restart with saved windows.
#[test]
fn restarts_let_nothing_be_taken_twice() {
    let mut sender = radio(3, 1);
    let mut receiver = radio(5, 0);
    let open = |receiver: &mut Radio, datagram: &[u8], seconds: u64| {
        let now = NOW + Duration::from_secs(seconds);
        receiver.open(datagram, now, None).map(drop)
    };
    let old: Vec<Vec<u8>> = (0..8).map(|_| sender.seal(&hello())).collect();
    for datagram in &old[..4] {
        assert_eq!(open(&mut receiver, datagram, 0), Ok(()));
        assert_eq!(open(&mut receiver, datagram, 0), Err(Refusal::Replayed));
    }
    let saved = serde_json::to_string(receiver.windows()).unwrap();
    assert_eq!(open(&mut receiver, &old[4], 1), Ok(()));
    // The receiver restarts: datagrams received after its windows were saved are taken once more, as the module says.
    let mut receiver = radio(5, 1);
    receiver.restore(serde_json::from_str(&saved).unwrap());
    for datagram in &old[..4] {
        assert_eq!(open(&mut receiver, datagram, 2), Err(Refusal::Replayed));
    }
    assert_eq!(open(&mut receiver, &old[4], 2), Ok(()));
    assert_eq!(open(&mut receiver, &old[4], 2), Err(Refusal::Replayed));
    // The sender restarts. Its numbers go on, and its earlier datagrams are old.
    let mut sender = radio(3, 2);
    assert_eq!(open(&mut receiver, &old[5], 3), Ok(()));
    assert_eq!(open(&mut receiver, &sender.seal(&hello()), 4), Ok(()));
    assert_eq!(open(&mut receiver, &old[6], 5), Err(Refusal::Replayed));
    // It has lost count.
    assert_eq!(
        open(&mut receiver, &radio(3, 1).seal(&hello()), 6),
        Err(Refusal::Replayed)
    );
    // A robot of the same number in another experiment under the same key does not disturb this one.
    let mut elsewhere = Radio::new(3, LIMITS, &Key::of(1), [0xe2; 32], 900);
    assert!(matches!(
        open(&mut receiver, &elsewhere.seal(&hello()), 7),
        Err(Refusal::OtherExperiment { program: Some(_), .. })
    ));
    assert_eq!(open(&mut receiver, &sender.seal(&hello()), 8), Ok(()));
    // Without its windows a receiver takes recorded datagrams.
    assert_eq!(open(&mut radio(5, 2), &old[0], 9), Ok(()));
}

/// A robot that sends too much is limited, and no other; a flood of forged datagrams costs no more than its limit, and uses up nothing
/// of a robot's budget.
#[test]
fn floods_are_cut_short() {
    let mut receiver = radio(5, 0);
    let (mut chatty, mut calm, mut operator) = (radio(3, 1), radio(4, 1), radio(OPERATOR, 1));
    let mut taken = [0; 3];
    for time in 0..10_000_u32 {
        let now = NOW + Duration::from_millis(time.into());
        taken[0] += u32::from(receiver.open(&chatty.seal(&hello()), now, None).is_ok());
        if time % 500 == 0 {
            taken[1] += u32::from(receiver.open(&calm.seal(&hello()), now, None).is_ok());
        }
        if time % 50 == 0 {
            taken[2] += u32::from(receiver.open(&operator.seal(&beacon(time.into())), now, None).is_ok());
        }
    }
    assert_eq!(taken, [10 + 49, 20, 200]);
    // A hundred a millisecond, for a second, in the name of the calm one and of the operator.
    let mut receiver = radio(5, 0);
    let [mut forger, mut other] = [4, OPERATOR].map(|own| Radio::new(own, LIMITS, &Key::of(2), EXPERIMENT, 9));
    let forged = [forger.seal(&hello()), other.seal(&beacon(0))];
    for time in 0..1000 {
        let now = NOW + Duration::from_millis(time);
        for _ in 0..50 {
            for datagram in &forged {
                receiver.open(datagram, now, None).unwrap_err();
            }
        }
    }
    let counts: BTreeMap<&str, u64> = receiver.refused().counts().collect();
    assert_eq!((counts["forged"], counts["too_many"]), (500 + 1998, 100_000 - 2498));
    let later = NOW + Duration::from_millis(1001);
    assert!(receiver.open(&calm.seal(&hello()), later, None).is_ok());
    assert!(
        receiver
            .open(&operator.seal(&beacon(0)), later + Duration::from_millis(1), None)
            .is_ok()
    );
}

/// Robots, the operator, and somebody who records, damages, delays, repeats and makes datagrams on their way to robot 5.
struct Attack {
    random: Random,
    now: Duration,
    receiver: Radio,
    senders: Vec<Radio>,
    /// Radios with another key, and with the right key in another experiment.
    forgers: Vec<Radio>,
    elsewhere: Vec<Radio>,
    /// Good datagrams, and those that are still held back.
    good: HashMap<Vec<u8>, (u16, Packet)>,
    held: Vec<Vec<u8>>,
    recorded: Vec<Vec<u8>>,
    /// Numbers of each sender that have been authenticated.
    seen: BTreeMap<u16, BTreeSet<u64>>,
    taken: HashSet<(u16, u64)>,
    wrong: Vec<(u16, Packet, &'static str)>,
    /// Bad ones by what was done to them.
    offered: BTreeMap<&'static str, u64>,
}

impl Attack {
    const NUMBERS: [u16; 10] = [0, 1, 2, 3, 4, 6, 7, 8, 9, OPERATOR];

    fn new(seed: u64) -> Self {
        let with = |key: u8, experiment| {
            Self::NUMBERS
                .map(|own| Radio::new(own, LIMITS, &Key::of(key), experiment, 3))
                .into()
        };
        // Of an earlier start.
        let first = radio(0, 2).seal(&hello());
        Self {
            random: Random(seed),
            now: NOW,
            receiver: radio(5, 3),
            senders: with(1, EXPERIMENT),
            forgers: with(2, EXPERIMENT),
            elsewhere: with(1, [0xe2; 32]),
            good: HashMap::from([(first.clone(), (0, hello()))]),
            held: Vec::new(),
            recorded: vec![first],
            seen: BTreeMap::new(),
            taken: HashSet::new(),
            wrong: out_of_range(),
            offered: BTreeMap::new(),
        }
    }

    fn second(&self) -> u32 {
        self.now.as_secs() as u32
    }

    /// A packet that a sender may send now.
    fn packet(&mut self, sender: u16) -> Packet {
        let random = &mut self.random;
        let (second, gene) = (self.now.as_secs() as u32, random.below(100) as f32 / 101.0);
        match random.below(4) {
            0 => Packet::Hello {
                program: "0.2.0".into(),
                experiment: EXPERIMENT,
                start: START,
            },
            _ if sender == OPERATOR => Packet::Beacon {
                milliseconds: self.now.as_millis() as i64,
                go: random.below(2) == 0,
                start: random.next(),
            },
            1 => Packet::Status(Status {
                simulator: gene,
                brought: random.below(1001) as u32,
                ..status()
            }),
            _ => Packet::Pair {
                second,
                message: Message {
                    simulator: gene,
                    ..message(sender, (second - random.below(6) as u32) / 60)
                },
            },
        }
    }

    /// Offers a datagram. Whether it is taken follows from what is good, has not come yet and is not too old.
    fn offer(&mut self, kind: &'static str, datagram: &[u8]) -> Option<Refusal> {
        let second = self.second();
        let opened = self.receiver.open(datagram, self.now, Some(second));
        let number = |sender: u16, radio: &Self| {
            let sequence = u64::from_le_bytes(*datagram[17..].first_chunk().unwrap());
            let numbers = radio.seen.get(&sender);
            let is_new = numbers.is_none_or(|numbers| {
                let newest = numbers.last().copied().unwrap_or(0);
                !numbers.contains(&sequence) && sequence + 64 > newest
            });
            (sequence, is_new)
        };
        let Some((sender, packet)) = self.good.get(datagram).cloned() else {
            // With the right tag, its number has been used.
            if let (Some(tag), "out of range") = (datagram.len().checked_sub(TAG), kind)
                && let Ok(Datagram { sender, sequence, .. }) = Datagram::of(datagram)
                && datagram[tag..] == self.receiver.tag(&datagram[..tag])
            {
                self.seen.entry(sender).or_default().insert(sequence);
            }
            *self.offered.entry(kind).or_default() += 1;
            return Some(opened.expect_err(kind));
        };
        let (sequence, is_new) = number(sender, self);
        let is_in_time = match packet {
            Packet::Pair { second: at, .. } => at.abs_diff(second) <= TOLERANCE,
            _ => true,
        };
        if is_new {
            self.seen.entry(sender).or_default().insert(sequence);
        }
        if is_new && is_in_time {
            let received = opened.expect(kind);
            assert_eq!(
                (received.sender, received.sequence, received.packet),
                (sender, sequence, packet)
            );
            assert!(self.taken.insert((sender, sequence)), "{sender} {sequence}");
            return None;
        }
        *self
            .offered
            .entry(if is_new { "late" } else { "replayed" })
            .or_default() += 1;
        let expected = if is_new {
            Refusal::OutOfRange("second")
        } else {
            Refusal::Replayed
        };
        assert_eq!(opened, Err(expected), "{kind}");
        None
    }

    /// Offers a bad datagram that must be refused for one reason.
    fn refuse(&mut self, kind: &'static str, datagram: &[u8], reason: &str) {
        let refusal = self.offer(kind, datagram);
        assert_eq!(refusal.as_ref().map(Refusal::reason), Some(reason), "{kind}");
    }

    /// A datagram with the right tag that can't be read, or has a value out of range.
    fn wrong(&mut self) -> Vec<u8> {
        let choice = self.random.below(self.wrong.len() + 1);
        let Some((sender, mut packet, name)) = self.wrong.get(choice).cloned() else {
            let status = self.senders[0].seal(&Packet::Status(status()));
            return unreadable(&self.senders[0], &status, self.random.below(5));
        };
        if let Packet::Pair { second, message } = &mut packet
            && !["second", "interval"].contains(&name)
        {
            *second = self.now.as_secs() as u32;
            message.interval = *second / 60;
        }
        let index = Self::NUMBERS.iter().position(|number| *number == sender).unwrap();
        self.senders[index].seal(&packet)
    }

    fn step(&mut self) {
        self.now += Duration::from_millis(500);
        let index = self.random.below(Self::NUMBERS.len());
        let sender = Self::NUMBERS[index];
        let packet = self.packet(sender);
        let good = self.senders[index].seal(&packet);
        self.good.insert(good.clone(), (sender, packet.clone()));
        let old = self.recorded[self.random.below(self.recorded.len())].clone();
        let number = self.senders[index].sequence();
        // Datagrams that were not sealed by holders of the key.
        self.forgers[index].sequence = number + self.random.below(3) as u64;
        let forged = self.forgers[index].seal(&packet);
        self.refuse("other key", &forged, "forged");
        let body = self.random.bytes(LONGEST - 25);
        let mut random = [&good[..25], &body[..]].concat();
        random.resize(random.len().max(25 + TAG), 0);
        self.refuse("random bytes", &random, "forged");
        self.refuse(
            "other version",
            &[&good[..4], &[1, 0], &good[6..]].concat(),
            "other_version",
        );
        let retagged = retagged(&self.senders[index], &good, |bytes| bytes[4] = 0);
        self.refuse("other version", &retagged, "other_version");
        let elsewhere = self.elsewhere[index].seal(&packet);
        self.refuse("other experiment", &elsewhere, "other_experiment");
        self.refuse("no datagram", &body, "not_ours");
        // Damaged datagrams.
        for datagram in [&good, &old] {
            let mut flipped = datagram.clone();
            for _ in 0..=self.random.below(3) {
                let bit = self.random.below(8 * flipped.len());
                flipped[bit / 8] ^= 1 << (bit % 8);
            }
            self.offer("flipped", &flipped);
            let cut = self.random.below(datagram.len());
            self.offer("cut", &datagram[..cut]);
            self.offer("cut", &datagram[cut.max(1)..]);
            let mutated = self.random.mutated(datagram);
            self.offer("mutated", &mutated);
        }
        let cut = self.random.below(good.len());
        self.offer("merged", &[&good[..cut], &old[cut.min(old.len())..]].concat());
        self.offer("merged", &[&good[..], &old[..]].concat());
        self.offer("merged", &[&good[..25], &old[25..]].concat());
        self.offer("merged", &[&old[..25], &good[25..]].concat());
        // With the key, values that nobody may send.
        let wrong = self.wrong();
        self.refuse("out of range", &wrong, "out_of_range");
        // Good ones: at once, or later and in any order; and again.
        if self.random.below(4) == 0 {
            self.held.push(good.clone());
        } else {
            assert_eq!(self.offer("good", &good), None);
        }
        if self.held.len() > 6 {
            let place = self.random.below(self.held.len());
            let held = self.held.swap_remove(place);
            self.offer("held", &held);
        }
        if !self.held.contains(&old) {
            self.offer("replayed", &old);
        }
        if self.recorded.len() < 400 {
            self.recorded.push(good);
        } else {
            let place = self.random.below(400);
            self.recorded[place] = good;
        }
    }
}

/// A hundred thousand bad datagrams, or with `ONEIRO_LONG` more than a million: none is taken, and all good ones are taken, once.
#[test]
fn no_bad_datagram_is_taken_and_all_good_ones_are() {
    let bad = if std::env::var_os("ONEIRO_LONG").is_some() {
        2_000_000
    } else {
        100_000
    };
    let mut attack = Attack::new(1);
    while attack.offered.values().sum::<u64>() < bad {
        attack.step();
    }
    let good = attack.good.len();
    println!(
        "{} of {good} good ones taken; bad: {:?}",
        attack.taken.len(),
        attack.offered
    );
    println!("{:?}", attack.receiver.refused().counts().collect::<Vec<_>>());
    // The rest was held back for too long.
    assert!(attack.taken.len() > good * 8 / 10);
    assert_eq!(attack.offered.len(), 12);
    assert!(
        attack.offered.values().all(|count| *count > bad / 1000),
        "{:?}",
        attack.offered
    );
    let counts: BTreeMap<&str, u64> = attack.receiver.refused().counts().collect();
    assert_eq!(counts["too_many"], 0, "a limit would hide what is refused for itself");
}

/// Ten minutes of processor time with `ONEIRO_LONG`. An accepted datagram is within its limits, and sealed again it has the same bytes.
#[test]
fn anything_may_come_by_radio() {
    let mut senders = [3, OPERATOR].map(|own| radio(own, 1));
    let (mut taken, mut authentic) = (0, 0);
    for_seeds_within(Duration::from_mins(10), 40_000, |seed| {
        let mut random = Random(seed);
        let sender = random.below(2);
        let packet = match random.below(4) {
            0 => pair(3, 200, 3),
            1 => Packet::Status(status()),
            2 => beacon(random.next() as i64 >> random.below(64)),
            _ => hello(),
        };
        let sealed = senders[sender].seal(&packet);
        let datagram = match random.below(4) {
            0 => random.bytes(200),
            1 => random.mutated(&sealed),
            // Datagrams that only somebody with the key could make.
            2 => retagged(&senders[sender], &sealed, |bytes| {
                let body = random.mutated(&bytes[25..]);
                bytes.truncate(25);
                bytes.extend(body);
            }),
            _ => retagged(&senders[sender], &sealed, |bytes| {
                bytes.truncate(25);
                bytes[6] = 1 + random.below(6) as u8;
                bytes.extend(random.bytes(LONGEST - 25 - TAG));
            }),
        };
        let second = (random.below(2) == 0).then_some(200);
        let mut receiver = radio(5, 0);
        match receiver.open(&datagram, NOW, second) {
            Ok(Received {
                sender,
                sequence,
                packet,
            }) => {
                taken += 1;
                let written = format::sealed(&packet, sender, [0xe1; 8], sequence);
                assert_eq!(written, datagram[..datagram.len() - TAG], "{packet:?}");
                assert_eq!(LIMITS.check(&packet, sender, second), Ok(()));
            }
            Err(Refusal::OutOfRange(_)) => authentic += 1,
            Err(_) => {}
        }
    });
    assert!(taken > 300 && authentic > 1000, "{taken} {authentic}");
}
