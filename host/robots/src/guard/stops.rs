//! Stops that a robot does not confirm: the time between them, for each driver and all answers of its robot. On a
//! virtual clock.

use std::collections::VecDeque;
use std::fmt::Write;
use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use super::wheels::{Event, Hands, News, Pace, Wanted};
use super::{Brake, Order};
use crate::error::{Error, Result};
use crate::fuzz::{self, Valid};
use crate::link::{Clock, Link};
use crate::script::Random;
use crate::{Kind, Robot, epuck, epuck2, recognise, thymio};

/// What is promised.
const MOST: Duration = Duration::from_millis(250);
/// How long a robot continues.
const LONG: Duration = Duration::from_secs(5);

/// What a robot does from a moment on.
#[derive(Clone, Debug, PartialEq)]
enum Mode {
    /// It answers.
    Well,
    /// It receives, and sends nothing.
    Silent,
    /// It answers after a time.
    Slow(Duration),
    /// It sends random bytes.
    Mad,
    /// It sends the same without a pause.
    Endless(&'static [u8]),
    /// It reads nothing: the link takes no bytes.
    Full,
    /// It hangs up whenever somebody connects.
    Gone,
    /// Its link can't be opened.
    Away,
}

const BANNERS: [&[u8]; 2] = [
    b"WELCOME to the SerCom protocol on e-Puck\r\n",
    b"ROM of minirobot KHEPERA, Version 5\r\n",
];

fn modes() -> Vec<Mode> {
    let slow = [20, 90, 140, 160, 210, 260, 400, 700].map(|ms| Mode::Slow(Duration::from_millis(ms)));
    let endless = [
        &b"d\r\n"[..],
        b"\r",
        b"e,5,5\r\n",
        &[0],
        &[3],
        &[1],
        &[2],
        &[255],
        BANNERS[0],
        BANNERS[1],
    ];
    let others = [Mode::Silent, Mode::Mad, Mode::Full, Mode::Gone, Mode::Away];
    slow.into_iter()
        .chain(endless.map(Mode::Endless))
        .chain(others)
        .collect()
}

/// A robot and its line.
struct Line {
    now: Duration,
    mode: Mode,
    valid: Valid,
    random: Random,
    /// When it next sends something unasked.
    next: Option<Duration>,
    coming: VecDeque<(Duration, u8)>,
    /// Whether bytes are a stop, and when it received a stop.
    is_stop: fn(&[u8]) -> bool,
    stops: Vec<Duration>,
    is_open: bool,
    calls: u32,
}

impl Line {
    const CYCLE: Duration = Duration::from_millis(20);

    /// Counts a call, which takes a moment.
    fn call(&mut self) -> Result {
        self.calls += 1;
        self.now += Duration::from_micros(1);
        if !self.is_open || matches!(self.mode, Mode::Gone | Mode::Away) {
            return Err(closed());
        }
        Ok(())
    }

    fn say(&mut self, bytes: &[u8], at: Duration) {
        let (late, bytes) = match self.mode {
            Mode::Well => (Duration::from_millis(2), bytes.to_vec()),
            Mode::Slow(time) => (time, bytes.to_vec()),
            Mode::Mad => (Duration::from_millis(2), self.random.bytes(60)),
            _ => return,
        };
        let last = self.coming.back().map_or(Duration::ZERO, |(last, _)| *last);
        let at = last.max(at + late);
        self.coming.extend(bytes.into_iter().map(|byte| (at, byte)));
    }

    fn live(&mut self, until: Duration) {
        while let (Some(next), Some(unasked)) = (self.next, &mut self.valid.unasked)
            && next <= until
        {
            let bytes = unasked();
            self.say(&bytes, next);
            self.next = Some(next + Self::CYCLE);
        }
    }
}

fn closed() -> Error {
    Error::Disconnected {
        link: "line".into(),
        cause: "hung up".into(),
    }
}

#[derive(Clone)]
struct Peer(Arc<Mutex<Line>>);

impl Peer {
    fn line(&self) -> MutexGuard<'_, Line> {
        self.0.lock().unwrap()
    }
}

impl Clock for Peer {
    fn now(&self) -> Duration {
        self.line().now
    }
}

impl Pace for Peer {
    fn rest(&self, _: Duration) {
        self.line().now += Duration::from_millis(5);
    }

    fn pause(&self, time: Duration) {
        self.line().now += time;
    }
}

impl Link for Peer {
    fn name(&self) -> &'static str {
        "line"
    }

    fn read(&mut self, buffer: &mut [u8], until: Duration) -> Result<usize> {
        let mut line = self.line();
        line.call()?;
        if until <= line.now {
            return Ok(0);
        }
        if matches!(line.mode, Mode::Endless(_)) {
            drop(line);
            return self.waiting(buffer);
        }
        line.live(until);
        let next = line.coming.front().map(|(at, _)| *at).filter(|at| *at < until);
        line.now = next.map_or(until, |at| at.max(line.now));
        drop(line);
        if next.is_some() { self.waiting(buffer) } else { Ok(0) }
    }

    fn waiting(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let mut line = self.line();
        line.call()?;
        if let Mode::Endless(said) = line.mode {
            for (place, byte) in buffer.iter_mut().zip(said.iter().cycle()) {
                *place = *byte;
            }
            // A megabyte in a second.
            line.now += Duration::from_micros(buffer.len() as u64);
            return Ok(buffer.len());
        }
        let now = line.now;
        line.live(now);
        let come = line.coming.iter().take_while(|(at, _)| *at <= now).count();
        let count = come.min(buffer.len());
        for (place, (_, byte)) in buffer.iter_mut().zip(line.coming.drain(..count)) {
            *place = byte;
        }
        Ok(count)
    }

    fn write(&mut self, bytes: &[u8], until: Duration) -> Result {
        let mut line = self.line();
        line.call()?;
        let now = line.now;
        if (line.is_stop)(bytes) {
            line.stops.push(now);
        }
        if line.mode == Mode::Full {
            let limit = until.saturating_sub(now);
            line.now = until.max(now);
            return Err(Error::Unsent {
                bytes: bytes.len(),
                limit,
            });
        }
        line.next = line.next.or(Some(now));
        for answer in (line.valid.answer)(bytes, now) {
            line.say(&answer, now);
        }
        Ok(())
    }

    fn reopen(&mut self) -> Result {
        let mut line = self.line();
        line.calls += 1;
        line.now += Duration::from_millis(1);
        line.coming.clear();
        line.next = None;
        line.is_open = line.mode != Mode::Away;
        if line.is_open {
            return Ok(());
        }
        Err(Error::Unavailable {
            link: "line".into(),
            cause: "no such port".into(),
            advice: "plug it in".into(),
        })
    }
}

type Open = fn(Box<dyn Link>) -> Result<Box<dyn Robot>>;

/// A driver, its robot, and what of its bytes are a stop.
struct Case {
    name: &'static str,
    open: Open,
    valid: fn() -> Valid,
    is_stop: fn(&[u8]) -> bool,
    /// Maximum delay of its answers for a confirmed stop, ms: the guard repeats it in that time.
    patience: u64,
}

fn is_line(bytes: &[u8]) -> bool {
    bytes.windows(6).any(|part| part == b"D,0,0\r")
}

fn is_command(bytes: &[u8]) -> bool {
    bytes.len() == 21 && bytes[3..7] == [0; 4]
}

/// A message that sets the variables 3 and 4, the motors' targets of the emulated node, to 0.
fn is_message(bytes: &[u8]) -> bool {
    let message = [8, 0, 0, 0, 0x0c, 0xa0, 1, 0, 3, 0, 0, 0, 0, 0];
    bytes.windows(message.len()).any(|part| part == message)
}

/// Each driver, and each way in which its robot talks.
fn cases() -> [Case; 7] {
    let lines = |link| recognise(link).map(Option::unwrap);
    let case = |name, open, valid, is_stop, patience| Case {
        name,
        open,
        valid,
        is_stop,
        patience,
    };
    [
        case("Khepera", lines, || fuzz::khepera(0), is_line, 140),
        case(
            "e-puck, text",
            lines,
            || fuzz::epuck(epuck::tests::VERSION_1, false),
            is_line,
            400,
        ),
        case(
            "e-puck",
            lines,
            || fuzz::epuck(epuck::tests::VERSION_1, true),
            is_line,
            400,
        ),
        case(
            "e-puck2, serial",
            lines,
            || fuzz::epuck(epuck::tests::VERSION_2, true),
            is_line,
            400,
        ),
        case(
            "e-puck2, Wi-Fi",
            |link| Ok(Box::new(epuck2::EPuck2::connect(link)?.unwrap())),
            fuzz::wifi,
            is_command,
            700,
        ),
        case(
            "Thymio II",
            |link| Ok(Box::new(thymio::Thymio::connect(link, None)?)),
            || fuzz::thymio_of(5),
            is_message,
            260,
        ),
        case(
            "Thymio II, newer",
            |link| Ok(Box::new(thymio::Thymio::connect(link, None)?)),
            || fuzz::thymio_of(9),
            is_message,
            260,
        ),
    ]
}

/// A robot that drives, in the guard's hands.
struct Held<T> {
    peer: Peer,
    brake: Brake,
    hands: Hands<Peer, T>,
    told: Receiver<Event>,
}

fn held(case: &Case) -> Held<impl Fn(Event) + use<>> {
    let peer = Peer(Arc::new(Mutex::new(Line {
        now: Duration::from_secs(100),
        mode: Mode::Well,
        valid: (case.valid)(),
        random: Random(7),
        next: None,
        coming: VecDeque::new(),
        is_stop: case.is_stop,
        stops: Vec::new(),
        is_open: true,
        calls: 0,
    })));
    let brake = Brake::default();
    let robot = (case.open)(brake.on(Box::new(peer.clone()), None)).unwrap();
    let (sender, told) = mpsc::channel();
    let wanted = Wanted {
        kinds: vec![Kind::Proximity],
        odometry: false,
    };
    let tell = move |event| drop(sender.send(event));
    let mut held = Held {
        hands: Hands::new(robot, wanted, peer.clone(), brake.clone(), tell),
        peer,
        brake,
        told,
    };
    assert!(held.stops(1, Duration::from_secs(2)), "{}", case.name);
    let until = held.peer.now() + Duration::from_millis(300);
    while held.peer.now() < until {
        held.hands.turn(Order::Drive([40.0, 40.0]));
    }
    held
}

impl<T: Fn(Event)> Held<T> {
    /// Orders a stop for a time, or until it is confirmed. Returns whether it is.
    fn stops(&mut self, number: u64, time: Duration) -> bool {
        let until = self.peer.now() + time;
        while self.peer.now() < until {
            self.brake.release(None);
            self.hands.turn(Order::Stop(number));
            let is_it = |event: Event| matches!(event.news, News::Stopped(confirmed) if confirmed == number);
            if self.told.try_iter().any(is_it) {
                return true;
            }
        }
        false
    }
}

/// The longest time between two stops, beginning when it was ordered and ending with the last.
fn widest(ordered: Duration, stops: &[Duration]) -> Duration {
    let times = std::iter::once(ordered).chain(stops.iter().copied());
    let (times, next) = (times.clone(), times.skip(1));
    times
        .zip(next)
        .map(|(one, next)| next.checked_sub(one).unwrap())
        .max()
        .unwrap()
}

/// For each driver and each way in which its robot may fail to confirm the stop: the stops continue, at most 250 ms
/// apart, and the stop is confirmed once the robot works again.
#[test]
fn stops_are_repeated_whatever_the_robot_answers() {
    let mut table = String::from("milliseconds between two stops, at most, and what the robot did\n");
    for case in cases() {
        let mut worst = (Duration::ZERO, Mode::Well);
        for mode in modes() {
            let mut held = held(&case);
            {
                let mut line = held.peer.line();
                (line.mode, line.calls) = (mode.clone(), 0);
                line.stops.clear();
            }
            // As the guard finds out by the answers that are missing.
            held.brake.release(Some(held.peer.now() + MOST));
            held.hands.turn(Order::Drive([50.0, 50.0]));
            let ordered = held.peer.now();
            held.brake.press();
            let is_confirmed = held.stops(2, LONG);
            let (stops, calls, end) = {
                let line = held.peer.line();
                let after = line.stops.iter().copied().filter(|at| *at >= ordered);
                (after.collect::<Vec<_>>(), line.calls, line.now)
            };
            let what = format!("{}, {mode:?}", case.name);
            if !matches!(mode, Mode::Gone | Mode::Away) {
                let widest = if is_confirmed {
                    widest(ordered, &stops)
                } else {
                    widest(ordered, &[&stops[..], &[end]].concat())
                };
                assert!(widest <= MOST, "{what}: {widest:?}");
                if widest > worst.0 {
                    worst = (widest, mode.clone());
                }
            }
            // Nothing turns round without a pause: a processor would be lost.
            let is_endless = matches!(mode, Mode::Endless(_));
            assert!(calls < 20_000 || is_endless, "{what}: {calls} calls");
            assert!(stops.len() < 1000, "{what}: {} stops", stops.len());
            if matches!(mode, Mode::Slow(time) if time <= Duration::from_millis(case.patience)) {
                assert!(is_confirmed, "{what}");
            }
            {
                let mut line = held.peer.line();
                line.mode = Mode::Well;
                line.coming.clear();
            }
            assert!(
                is_confirmed || held.stops(2, LONG),
                "{what}: not confirmed by a robot that is well"
            );
        }
        let ms = 1000.0 * worst.0.as_secs_f64();
        writeln!(table, "{}: {ms:.1}, {:?}", case.name, worst.1).unwrap();
    }
    eprint!("{table}");
}
