//! A Khepera, emulated from descriptions of its serial protocol: K-Team's answers to frequent questions, and what Player,
//! kMatlab, `KiKS` and `RoadNarrows`' client send and expect. It shares nothing with the program's own driver.
//!
//! It is a state machine over time, so it runs on a virtual clock as well as in real time: bytes go in and come out with the
//! times that they take on a serial line. It keeps its last speeds for ever.

#![allow(unreachable_pub, reason = "tests of several crates use it")]

use std::collections::VecDeque;
use std::time::Duration;

#[path = "khepera/surrogate.rs"]
pub mod surrogate;

/// What is moved by an emulated robot's wheels and read by its sensors.
pub trait Body: Send {
    /// The greatest speed of its wheels, pulses / 10 ms.
    fn greatest(&self) -> i32 {
        Khepera::<Self>::GREATEST as i32
    }

    /// Lives on for some time with its wheels at these speeds, left and right, pulses / 10 ms.
    fn advance(&mut self, time: Duration, speeds: [i32; 2]);

    /// Infra-red light reflected by objects, 0 to 1023, clockwise from the left.
    fn proximity(&self) -> [u16; 8];

    /// Ambient light in the same order: the brighter, the lower.
    fn light(&self) -> [u16; 8];
}

/// A body that rolls on an endless floor, and senses what it is told to.
#[derive(Clone, Debug)]
pub struct Rolling {
    /// x and y in mm, and the heading in radians, counter-clockwise.
    pub pose: [f64; 3],
    pub proximity: [u16; 8],
    pub light: [u16; 8],
}

impl Default for Rolling {
    fn default() -> Self {
        Self {
            pose: [0.0; 3],
            proximity: [0; 8],
            // About what it reads in the dark.
            light: [500; 8],
        }
    }
}

impl Body for Rolling {
    fn advance(&mut self, time: Duration, speeds: [i32; 2]) {
        // A pulse is 1/12 mm (Player, kMatlab), and the wheels are 53 mm apart (KiKS).
        let [left, right] = speeds.map(|speed| f64::from(speed) / 12.0 * time.as_secs_f64() / 0.01);
        let turn = (right - left) / 53.0;
        let chord = 0.5
            * (left + right)
            * if turn == 0.0 {
                1.0
            } else {
                (0.5 * turn).sin() / (0.5 * turn)
            };
        let [x, y, heading] = &mut self.pose;
        *x += chord * (*heading + 0.5 * turn).cos();
        *y += chord * (*heading + 0.5 * turn).sin();
        *heading += turn;
    }

    fn proximity(&self) -> [u16; 8] {
        self.proximity
    }

    fn light(&self) -> [u16; 8] {
        self.light
    }
}

/// How firmware differs.
#[derive(Clone, Copy, Debug)]
pub struct Firmware {
    /// Its answer to a command that it does not know.
    pub unknown: &'static str,
    /// The end of its lines.
    pub end: &'static str,
}

impl Firmware {
    /// All combinations that are described.
    pub const ALL: [Self; 4] = [
        Self::new("Command not found", "\r\n"),
        Self::new(PROTOCOL_ERROR, "\r\n"),
        Self::new("Command not found", "\n"),
        Self::new(PROTOCOL_ERROR, "\n"),
    ];

    const fn new(unknown: &'static str, end: &'static str) -> Self {
        Self { unknown, end }
    }
}

const PROTOCOL_ERROR: &str = "z,Protocol error";

/// What the wheels are to do.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    /// Turn at speeds, pulses / 10 ms.
    Speed([i32; 2]),
    /// Turn to positions, pulses.
    Position([i64; 2]),
    /// Take shares of the battery's voltage, in 1/255.
    Power([i32; 2]),
}

/// What a reset brings back.
#[derive(Clone, Debug, PartialEq)]
struct Settings {
    mode: Mode,
    speed_gains: [i64; 3],
    position_gains: [i64; 3],
    /// Greatest speed and acceleration of the left, then of the right wheel on their way to a position.
    profile: [i64; 4],
    /// Travel of the wheels, [`Settings::PULSE`] to a pulse. What is read has 32 bits.
    travel: [i64; 2],
    lights: [bool; 2],
}

impl Settings {
    /// A pulse / 10 ms for as many ns is a pulse.
    const PULSE: i64 = 10_000_000;

    fn counters(&self) -> [i32; 2] {
        self.travel.map(|travel| travel.div_euclid(Self::PULSE) as i32)
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            mode: Mode::Speed([0; 2]),
            speed_gains: [3800, 800, 100],
            position_gains: [3000, 20, 4000],
            profile: [20, 64, 20, 64],
            travel: [0; 2],
            lights: [false; 2],
        }
    }
}

/// The robot.
pub struct Khepera<B: ?Sized> {
    firmware: Firmware,
    baud: u32,
    settings: Settings,
    /// Memory of the extension bus.
    bus: [u8; 64],
    /// What the inputs of the A/D converter read, of 1023, which is 4.096 V.
    pub inputs: [u16; 6],
    /// How long it takes to answer, beyond the time on the line.
    pub delay: Duration,
    /// After as many bytes it restarts, if it does.
    pub restarts_after: Option<usize>,
    /// Until when it has lived.
    now: Duration,
    /// The command that is not complete yet.
    line: Vec<u8>,
    /// When the last byte that was sent to it has arrived, and when the last one that it sends has.
    heard: Duration,
    said: Duration,
    /// What it sends, with the times of arrival.
    answers: VecDeque<(Duration, u8)>,
    pub body: B,
}

impl<B: ?Sized> Khepera<B> {
    /// The greatest speed that is obeyed, pulses / 10 ms.
    pub const GREATEST: i64 = 127;
    /// The farthest position that is obeyed, pulses.
    const FARTHEST: i64 = (1 << 23) - 2;
    /// What it sends when it starts.
    pub const BANNER: [&str; 2] = [
        "ROM of minirobot KHEPERA, author, firm, date, Rev. 5.01",
        "Serial Communication Protocol",
    ];
    /// Longer commands are none.
    const LONGEST: usize = 128;
    const TICK: Duration = Duration::from_millis(10);
}

impl<B: Body> Khepera<B> {
    /// A robot that is switched on, and has said so already.
    pub fn new(body: B, firmware: Firmware, baud: u32) -> Self {
        Self {
            firmware,
            baud,
            settings: Settings::default(),
            bus: [0; 64],
            inputs: [0; 6],
            delay: Duration::ZERO,
            restarts_after: None,
            now: Duration::ZERO,
            line: Vec::new(),
            heard: Duration::ZERO,
            said: Duration::ZERO,
            answers: VecDeque::new(),
            body,
        }
    }

    /// Takes bytes that begin to be sent to it now.
    pub fn receive(&mut self, bytes: &[u8], now: Duration) {
        for byte in bytes {
            self.heard = self.heard.max(now) + self.byte_time();
            self.live(self.heard);
            match byte {
                b'\r' | b'\n' => {
                    let line = std::mem::take(&mut self.line);
                    if !line.is_empty() {
                        let answer = self.obey(&String::from_utf8_lossy(&line));
                        self.say(&answer, self.heard + self.delay);
                    }
                }
                _ if self.line.len() <= Self::LONGEST => self.line.push(*byte),
                _ => {}
            }
        }
    }

    /// Bytes that it sends and that have arrived by now.
    pub fn send(&mut self, now: Duration) -> Vec<u8> {
        self.live(now);
        let count = self.answers.partition_point(|(at, _)| *at <= now);
        self.answers.drain(..count).map(|(_, byte)| byte).collect()
    }

    /// All bytes that it sends, with the times when they will have arrived.
    pub fn timed(&mut self) -> Vec<(Duration, u8)> {
        self.answers.drain(..).collect()
    }

    /// Restarts: by its button, or since its battery was low for a moment. What it has not sent yet is lost.
    pub fn restart(&mut self, now: Duration) {
        self.live(now);
        self.answers.clear();
        self.said = now;
        self.begin();
    }

    /// Forgets everything, and says what it is.
    fn begin(&mut self) {
        self.restarts_after = None;
        self.settings = Settings::default();
        self.line.clear();
        for line in Self::BANNER {
            self.say(line, self.now);
        }
    }

    /// Lives until a time.
    pub fn live(&mut self, until: Duration) {
        while self.now < until {
            let left = until.saturating_sub(self.now);
            // On the way to a position, speeds change.
            let step = if matches!(self.settings.mode, Mode::Position(_)) {
                left.min(Self::TICK)
            } else {
                left
            };
            let speeds = self.speeds();
            for (travel, speed) in self.settings.travel.iter_mut().zip(speeds) {
                *travel += i64::from(speed) * step.as_nanos() as i64;
            }
            self.body.advance(step, speeds);
            self.now += step;
        }
    }

    /// Speeds that the wheels have, pulses / 10 ms.
    pub fn speeds(&self) -> [i32; 2] {
        let greatest = self.body.greatest();
        let speeds = match self.settings.mode {
            Mode::Speed(speeds) => speeds,
            Mode::Position(targets) => [0, 1].map(|wheel| {
                // Acceleration takes no time here: no description says in which unit it is.
                let most = self.settings.profile[2 * wheel];
                (targets[wheel] - i64::from(self.counters()[wheel])).clamp(-most, most) as i32
            }),
            // How fast a wheel turns is not described; it may depend on the battery and on the load.
            Mode::Power(shares) => shares.map(|share| share * Self::GREATEST as i32 / 255),
        };
        speeds.map(|speed| speed.clamp(-greatest, greatest))
    }

    /// Counters of the wheels, pulses.
    pub fn counters(&self) -> [i32; 2] {
        self.settings.counters()
    }

    /// Sets the counters, as `G` does.
    pub fn set_counters(&mut self, pulses: [i32; 2]) {
        self.settings.travel = pulses.map(|pulses| i64::from(pulses) * Settings::PULSE);
    }

    /// Whether each light is on.
    pub fn lights(&self) -> [bool; 2] {
        self.settings.lights
    }

    /// Time of a byte on the line: a start bit, 8 bits, no parity, 2 stop bits.
    pub fn byte_time(&self) -> Duration {
        Duration::from_nanos(11 * 1_000_000_000 / u64::from(self.baud))
    }

    /// Sends a line from a time on.
    fn say(&mut self, line: &str, from: Duration) {
        for byte in line.bytes().chain(self.firmware.end.bytes()) {
            match &mut self.restarts_after {
                Some(0) => return self.begin(),
                Some(left) => *left -= 1,
                None => {}
            }
            self.said = self.said.max(from) + self.byte_time();
            self.answers.push_back((self.said, byte));
        }
    }

    /// Obeys a command, and returns the answer.
    fn obey(&mut self, line: &str) -> String {
        let (letter, rest) = line.split_once(',').unwrap_or((line, ""));
        if letter == "T" {
            let is_message = rest.split_once(',').is_some_and(|(id, _)| id.parse::<u8>().is_ok());
            return if is_message {
                format!("t,{rest}")
            } else {
                PROTOCOL_ERROR.into()
            };
        }
        let fields = line.split(',').skip(1).map(|field| field.parse().ok());
        let Some(numbers) = fields.collect::<Option<Vec<i64>>>() else {
            return self.refusal(letter);
        };
        let own = &mut self.settings;
        let clamp = |values: [i64; 2], most: i64| values.map(|value| value.clamp(-most, most));
        match (letter, &numbers[..]) {
            ("A", &[p, i, d]) => own.speed_gains = [p, i, d],
            ("C", &[left, right]) => own.mode = Mode::Position(clamp([left, right], Self::FARTHEST)),
            ("D", &[left, right]) => {
                own.mode = Mode::Speed(clamp([left, right], Self::GREATEST).map(|speed| speed as i32));
            }
            ("F", &[p, i, d]) => own.position_gains = [p, i, d],
            ("G", &[left, right]) => {
                own.travel = [left, right].map(|pulses| i64::from(pulses as i32) * Settings::PULSE);
            }
            ("J", &[vl, al, vr, ar]) => own.profile = [vl, al, vr, ar].map(|value| value.clamp(0, Self::FARTHEST)),
            ("L", &[light, action]) => match (light, action) {
                (0 | 1, 0) => own.lights[light as usize] = false,
                (0 | 1, 1) => own.lights[light as usize] = true,
                (0 | 1, 2) => own.lights[light as usize] ^= true,
                (0 | 1, _) => return "z,This LED action is not possible.".into(),
                _ => return "z,This LED does not exist.".into(),
            },
            ("P", &[left, right]) => own.mode = Mode::Power(clamp([left, right], 255).map(|share| share as i32)),
            ("W", &[byte @ 0..=255, address @ 0..=63]) => self.bus[address as usize] = byte as u8,
            _ => return self.read(letter, &numbers).unwrap_or_else(|| self.refusal(letter)),
        }
        letter.to_lowercase()
    }

    /// The answer to a command that reads; none if it is not one.
    fn read(&self, letter: &str, numbers: &[i64]) -> Option<String> {
        let values: Vec<i64> = match (letter, numbers) {
            ("B", []) => return Some("b,5.01,5.00".into()),
            ("E", []) => self.speeds().map(i64::from).into(),
            ("H", []) => self.counters().map(i64::from).into(),
            ("I", [channel @ 0..=5]) => vec![i64::from(self.inputs[*channel as usize])],
            ("K", []) => self.status(),
            ("N", []) => self.body.proximity().map(i64::from).into(),
            ("O", []) => self.body.light().map(i64::from).into(),
            ("R", [address @ 0..=63]) => vec![i64::from(self.bus[*address as usize])],
            _ => return None,
        };
        let fields = values.iter().map(|value| format!(",{value}"));
        Some(letter.to_lowercase() + &fields.collect::<String>())
    }

    /// Of each wheel whether it is at its target, whether its speed is controlled, and how far it is from its target.
    fn status(&self) -> Vec<i64> {
        let of = |wheel: usize| match self.settings.mode {
            Mode::Position(targets) => {
                let error = targets[wheel] - i64::from(self.counters()[wheel]);
                [i64::from(error == 0), 0, error]
            }
            Mode::Speed(speeds) => [0, 1, i64::from(speeds[wheel] - self.speeds()[wheel])],
            Mode::Power(_) => [0, 1, 0],
        };
        [of(0), of(1)].concat()
    }

    fn refusal(&self, letter: &str) -> String {
        let is_known = letter.len() == 1 && "ABCDEFGHIJKLNOPRTW".contains(letter);
        if is_known {
            PROTOCOL_ERROR
        } else {
            self.firmware.unknown
        }
        .into()
    }
}

/// What a serial port hears at one rate of what is sent at another: bytes of 8 bits without parity, sent one after the other
/// with 2 stop bits. A byte without a stop bit is dropped.
pub fn resampled(bytes: &[u8], sent_at: u32, heard_at: u32) -> Vec<u8> {
    let bits: Vec<bool> = bytes
        .iter()
        .flat_map(|byte| {
            let data = (0..8).map(move |bit| byte >> bit & 1 == 1);
            [false].into_iter().chain(data).chain([true; 2])
        })
        .collect();
    // The level at a time, in bits of the receiver's.
    let level = |time: f64| {
        let bit = (time * f64::from(sent_at) / f64::from(heard_at)) as usize;
        bits.get(bit).copied().unwrap_or(true)
    };
    let end = bits.len() as f64 * f64::from(heard_at) / f64::from(sent_at);
    // Receivers look for a start bit 16 times a bit.
    let (mut heard, mut time, step) = (Vec::new(), 0.0, 1.0 / 16.0);
    while time < end {
        if level(time) {
            time += step;
            continue;
        }
        let byte = (0..8).fold(0, |byte, bit| {
            byte | u8::from(level(time + 1.5 + f64::from(bit))) << bit
        });
        if level(time + 9.5) {
            heard.push(byte);
        }
        time += 9.5;
        // After a missing stop bit it waits for the line to be free.
        while time < end && !level(time) {
            time += step;
        }
    }
    heard
}
