//! An e-puck at the end of a serial line, emulated from descriptions of its firmware's protocol (`SerCom`) and from what its clients
//! send and expect. It shares nothing with the program's driver, and keeps its last speeds for ever.
//!
//! It is a state machine over time, in ns: bytes take their time on the line, 10 bits each at 115200 baud.

use std::collections::VecDeque;

use crate::daemon::epuck::Raw;

/// Time of a byte on the line, ns: a start bit, 8 bits, a stop bit.
const BYTE: u64 = 10 * 1_000_000_000 / 115_200;
/// Maximum speed that is obeyed, steps / s.
const GREATEST: i16 = 1000;
/// Travel of a wheel by a step, mm: 1000 steps to a turn of a wheel of 20.5 mm radius.
pub(super) const STEP_MM: f64 = 0.128_805;
/// A step / s for as many ns is a step.
const STEP: i64 = 1_000_000_000;
/// Longer lines are cut.
const LONGEST: usize = 80;
/// Its message after a reset.
const BANNER: &str =
    "\x0c\x07WELCOME to the SerCom protocol on e-Puck\r\nthe EPFL education robot type \"H\" for help\r\n";
const VERSION: &str = "v,Version 1.2.2 August 2008 GCtronic\r\nHW version: FFFF\r\n";
/// Of the accelerometer on a level floor, and of the microphones in a quiet room.
const LEVEL: [i16; 3] = [2048, 2048, 2800];
const QUIET: [i16; 3] = [12, 12, 12];

/// The state of its reader of bytes.
enum Mode {
    /// Waits for a command.
    Idle,
    /// Reads a line, which CR or LF ends.
    Text(Vec<u8>),
    /// Reads a chain of commands, which 0 ends: the command whose arguments are read, these, and the chain's answers so far.
    Binary {
        command: Option<u8>,
        arguments: Vec<u8>,
        answers: Vec<u8>,
    },
}

/// The robot and its line.
pub(super) struct EPuck {
    /// What its sensors read.
    pub(super) readings: Raw,
    mode: Mode,
    /// Speeds of the left and of the right wheel, steps / s.
    speeds: [i16; 2],
    /// Since when both are 0, none while a wheel turns; and when both were set to 0 last.
    standing: Option<u64>,
    stood: u64,
    /// Travel of the wheels, [`STEP`] to a step. Its readings have 16 bits.
    travel: [i64; 2],
    now: u64,
    /// Bytes on their way to it, and from it, with the times of their arrival.
    coming: VecDeque<(u64, u8)>,
    going: VecDeque<(u64, u8)>,
    /// Arrival of the last of them.
    heard: u64,
    said: u64,
}

impl EPuck {
    /// A robot that is switched on, and has sent its banner.
    pub(super) fn new() -> Self {
        Self {
            readings: [0; 16],
            mode: Mode::Idle,
            speeds: [0; 2],
            standing: Some(0),
            stood: 0,
            travel: [0; 2],
            now: 0,
            coming: VecDeque::new(),
            going: VecDeque::new(),
            heard: 0,
            said: 0,
        }
    }

    /// Speeds of the left and of the right wheel now, mm/s.
    pub(super) fn speeds_mm_s(&self) -> [f64; 2] {
        self.speeds.map(|speed| f64::from(speed) * STEP_MM)
    }

    /// The moment from which both wheels stand still; none while one turns.
    pub(super) fn standing(&self) -> Option<u64> {
        self.standing
    }

    /// The moment from which both wheels stand still, or stood still last.
    pub(super) fn stood(&self) -> u64 {
        self.stood
    }

    /// Takes bytes that begin to be sent to it now.
    pub(super) fn receive(&mut self, bytes: &[u8], now: u64) {
        for byte in bytes {
            self.heard = self.heard.max(now) + BYTE;
            self.coming.push_back((self.heard, *byte));
        }
    }

    /// When the last byte that is on its way to it arrives.
    pub(super) fn next(&self) -> Option<u64> {
        self.coming.back().map(|(at, _)| *at)
    }

    /// When the last byte that it has sent arrives.
    pub(super) fn answered(&self) -> Option<u64> {
        self.going.back().map(|(at, _)| *at)
    }

    /// Bytes that have come from it by now.
    pub(super) fn take(&mut self, now: u64) -> Vec<u8> {
        let count = self.going.partition_point(|(at, _)| *at <= now);
        self.going.drain(..count).map(|(_, byte)| byte).collect()
    }

    /// Holds all bytes back that are under way or come later, until a moment.
    pub(super) fn hang(&mut self, until: u64) {
        for (at, _) in self.coming.iter_mut().chain(&mut self.going) {
            *at = until.max(*at);
        }
        (self.heard, self.said) = (self.heard.max(until), self.said.max(until));
    }

    /// Loses all bytes that are under way, as where a line is closed and opened again.
    pub(super) fn reopen(&mut self) {
        self.coming.clear();
        self.going.clear();
    }

    /// Runs until a time.
    pub(super) fn live(&mut self, until: u64) {
        while let Some((at, byte)) = self.coming.front().copied().filter(|(at, _)| *at <= until) {
            self.coming.pop_front();
            self.turn(at);
            self.hear(byte);
        }
        self.turn(until);
    }

    /// Turns its wheels until a time.
    fn turn(&mut self, until: u64) {
        let time = until.saturating_sub(self.now) as i64;
        for (travel, speed) in self.travel.iter_mut().zip(self.speeds) {
            *travel += i64::from(speed) * time;
        }
        self.now = self.now.max(until);
    }

    fn counters(&self) -> [i16; 2] {
        self.travel.map(|travel| travel.div_euclid(STEP) as i16)
    }

    fn drive(&mut self, speeds: [i16; 2]) {
        self.speeds = speeds.map(|speed| speed.clamp(-GREATEST, GREATEST));
        self.standing = match self.speeds {
            [0, 0] => self.standing.or(Some(self.now)),
            _ => None,
        };
        self.stood = self.standing.unwrap_or(self.stood);
    }

    fn hear(&mut self, byte: u8) {
        self.mode = match (std::mem::replace(&mut self.mode, Mode::Idle), byte) {
            (Mode::Idle, 0) => Mode::Idle,
            (Mode::Idle, 0x80..) => self.chained(None, Vec::new(), Vec::new(), byte),
            // After a line's end, any byte begins a line.
            (Mode::Idle, b'\r' | b'\n') => Mode::Text(Vec::new()),
            (Mode::Idle, byte) => Mode::Text(vec![byte]),
            (Mode::Text(line), b'\r' | b'\n') if line.is_empty() => Mode::Text(line),
            (Mode::Text(line), b'\r' | b'\n') => {
                let answer = self.obey(&String::from_utf8_lossy(&line));
                self.say(answer.as_bytes());
                Mode::Idle
            }
            (Mode::Text(mut line), byte) => {
                if line.len() < LONGEST {
                    line.push(byte);
                }
                Mode::Text(line)
            }
            (
                Mode::Binary {
                    command,
                    arguments,
                    answers,
                },
                byte,
            ) => self.chained(command, arguments, answers, byte),
        };
    }

    /// Takes a byte of a chain of commands.
    fn chained(&mut self, command: Option<u8>, mut arguments: Vec<u8>, mut answers: Vec<u8>, byte: u8) -> Mode {
        let mut command = command;
        match command {
            Some(_) => arguments.push(byte),
            None if byte == 0 => {
                self.say(&answers);
                return Mode::Idle;
            }
            None => command = Some(byte.wrapping_neg()),
        }
        let wanted = match command {
            Some(b'D' | b'P') => 4,
            Some(b'L') => 2,
            _ => 0,
        };
        if let Some(known) = command.filter(|_| arguments.len() == wanted) {
            answers.extend(self.answer(known, &arguments).into_iter().flat_map(i16::to_le_bytes));
            (command, arguments) = (None, Vec::new());
        }
        Mode::Binary {
            command,
            arguments,
            answers,
        }
    }

    /// Obeys a command of a chain. Unknown ones are skipped.
    fn answer(&mut self, command: u8, arguments: &[u8]) -> Vec<i16> {
        let words: Vec<i16> = arguments
            .as_chunks()
            .0
            .iter()
            .map(|word| i16::from_le_bytes(*word))
            .collect();
        match (command, &words[..]) {
            (b'D', &[left, right]) => self.drive([left, right]),
            (b'P', &[left, right]) => self.count(left, right),
            (b'N', _) => return self.read(0),
            (b'O', _) => return self.read(8),
            (b'E', _) => return self.speeds.to_vec(),
            (b'Q', _) => return self.counters().to_vec(),
            (b'a', _) => return LEVEL.to_vec(),
            (b'u', _) => return QUIET.to_vec(),
            _ => {}
        }
        Vec::new()
    }

    /// Eight readings.
    fn read(&self, first: usize) -> Vec<i16> {
        self.readings[first..first + 8]
            .iter()
            .map(|reading| *reading as i16)
            .collect()
    }

    /// Sets the counters.
    fn count(&mut self, left: i16, right: i16) {
        self.travel = [left, right].map(|steps| i64::from(steps) * STEP);
    }

    /// Obeys a line, and returns the answer.
    fn obey(&mut self, line: &str) -> String {
        let mut fields = line.split(',');
        let letter = fields.next().unwrap_or_default();
        // Like the firmware's `atoi`: a field that is no number is 0.
        let numbers: Vec<i16> = fields.map(|field| field.trim().parse().unwrap_or_default()).collect();
        let number = |index: usize| numbers.get(index).copied().unwrap_or_default();
        let listed = |letter: &str, values: &[i16]| {
            let fields: Vec<String> = values.iter().map(i16::to_string).collect();
            let comma = if fields.is_empty() { "" } else { "," };
            format!("{letter}{comma}{}\r\n", fields.join(","))
        };
        // Of the letters only `b` differs from the capital.
        match letter {
            "b" => return "b,1\r\n".into(),
            letter if letter.len() != 1 => return "z,Command not found\r\n".into(),
            _ => {}
        }
        match letter.to_ascii_uppercase().as_str() {
            "D" => {
                self.drive([number(0), number(1)]);
                listed("d", &[])
            }
            "S" => {
                self.drive([0; 2]);
                listed("s", &[])
            }
            "P" => {
                self.count(number(0), number(1));
                listed("p", &[])
            }
            "E" => listed("e", &self.speeds),
            "Q" => listed("q", &self.counters()),
            "N" => listed("n", &self.read(0)),
            "O" => listed("o", &self.read(8)),
            "A" => listed("a", &LEVEL),
            "U" => listed("u", &QUIET),
            "L" => listed("l", &[]),
            "B" => listed("b", &[]),
            "F" => listed("f", &[]),
            "V" => VERSION.into(),
            "R" => {
                self.drive([0; 2]);
                self.count(0, 0);
                BANNER.into()
            }
            _ => "z,Command not found\r\n".into(),
        }
    }

    /// Sends bytes from now on.
    fn say(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.said = self.said.max(self.now) + BYTE;
            self.going.push_back((self.said, *byte));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Its answer to bytes, and when the last byte of it has arrived.
    fn said(robot: &mut EPuck, bytes: &[u8], now: u64) -> (Vec<u8>, u64) {
        robot.receive(bytes, now);
        robot.live(robot.next().unwrap_or(now));
        let at = robot.answered().unwrap_or(now);
        (robot.take(at), at)
    }

    fn line(robot: &mut EPuck, text: &str) -> String {
        let now = robot.now;
        String::from_utf8(said(robot, text.as_bytes(), now).0).unwrap()
    }

    #[test]
    fn lines_are_answered_as_documented() {
        let mut robot = EPuck::new();
        robot.readings = std::array::from_fn(|index| 100 * index as u16);
        for (command, answer) in [
            ("D,500,-1200\r", "d\r\n"),
            ("e\n", "e,500,-1000\r\n"),
            ("N\r", "n,0,100,200,300,400,500,600,700\r\n"),
            ("\r\n\rO\r", "o,800,900,1000,1100,1200,1300,1400,1500\r\n"),
            ("b\r", "b,1\r\n"),
            ("B,0\r", "b\r\n"),
            ("L,3,1\r", "l\r\n"),
            ("x\r", "z,Command not found\r\n"),
            ("D,0,0\rE\r", "d\r\ne,0,0\r\n"),
            ("V\r", VERSION),
        ] {
            assert_eq!(line(&mut robot, command), answer, "{command:?}");
        }
    }

    /// Codes by hand: N is b2, D bc, E bb, Q af. 18 bytes of answer.
    #[test]
    fn chains_are_answered_together_and_bytes_take_their_time() {
        let mut robot = EPuck::new();
        robot.readings[7] = 4095;
        let (answer, at) = said(&mut robot, &[0xb2, 0xbc, 0xf4, 0x01, 0x0c, 0xfe, 0xbb, 0], 1000);
        let words = [0, 0, 0, 0, 0, 0, 0, 4095, 500, -500];
        assert_eq!(
            answer,
            words.into_iter().flat_map(i16::to_le_bytes).collect::<Vec<u8>>()
        );
        assert_eq!(at, 1000 + (8 + 20) * BYTE);
        // 1 s after the speeds were set, whose last byte was the sixth.
        robot.live(1000 + 6 * BYTE + 1_000_000_000);
        assert_eq!(robot.counters(), [500, -500]);
        robot.live(1000 + 6 * BYTE + 70_000_000_000);
        assert_eq!(
            robot.counters(),
            [35_000_i64 as i16, -35_000_i64 as i16],
            "16 bits wrap"
        );
        assert_eq!(robot.standing(), None);
    }

    /// Half a command swallows what follows until zeros complete it; after a line's end, text is text.
    #[test]
    fn half_a_command_waits_for_its_rest() {
        let mut robot = EPuck::new();
        assert_eq!(line(&mut robot, "D,300,300\r"), "d\r\n");
        let now = robot.now;
        assert!(said(&mut robot, &[0xbc, 0xf4], now).0.is_empty());
        let (answer, at) = said(&mut robot, &[&[0; 21][..], b"\rD,0,0\rV\r"].concat(), now);
        assert_eq!(answer, [b"d\r\n", VERSION.as_bytes()].concat());
        assert!(robot.standing().unwrap() < at);
    }

    #[test]
    fn a_line_that_hangs_holds_bytes_back_both_ways() {
        let mut robot = EPuck::new();
        robot.receive(b"D,100,100\r", 0);
        robot.live(1_000_000);
        assert_eq!((robot.take(10_000_000), robot.standing()), (b"d\r\n".to_vec(), None));
        robot.receive(b"D,0,0\r", 20_000_000);
        robot.hang(3_000_000_000);
        robot.receive(b"E\r", 30_000_000);
        robot.live(2_999_999_999);
        assert_eq!((robot.take(2_999_999_999), robot.standing()), (Vec::new(), None));
        robot.live(robot.next().unwrap());
        assert_eq!(robot.standing(), Some(3_000_000_000));
        assert_eq!(robot.take(u64::MAX), b"d\r\ne,0,0\r\n");
    }
}
