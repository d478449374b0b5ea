//! `oneiro robot sample` of a Khepera that is scripted here, over TCP and in real time: it turns before a wall as its wheels do, and
//! reads the built-in table.

#![cfg(unix)]

use std::f64::consts::TAU;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use oneiro::tables::{SensorTable, SensorTables};
use serde_json::{Value, json};
use serialport::SerialPort;

use crate::peers::listen;
use crate::place::Place;

/// How it turns, as another sampling has measured it.
const TURNING: &str = r#"{"wheel_mm_s":8.2,"apparent":1.0188679245283019}"#;

/// Where the robot is, and how its wheels turn.
struct State {
    since: Instant,
    speeds: [i32; 2],
    /// Counts of the wheels' odometers.
    counts: [f64; 2],
    /// Turns counter-clockwise.
    heading: f64,
    row: usize,
}

#[derive(Clone)]
struct Khepera(Arc<Mutex<State>>);

impl Khepera {
    fn new() -> Self {
        Self(Arc::new(Mutex::new(State {
            since: Instant::now(),
            speeds: [0; 2],
            counts: [0.0; 2],
            heading: 0.0,
            row: 0,
        })))
    }

    /// Serves a client after the other.
    fn start(&self) -> String {
        let robot = self.clone();
        listen(move |mut stream| {
            let (mut heard, mut byte) = (Vec::new(), [0]);
            while let Ok(1) = stream.read(&mut byte) {
                if !matches!(byte[0], b'\r' | b'\n') {
                    heard.push(byte[0]);
                    continue;
                }
                let line = String::from_utf8_lossy(&std::mem::take(&mut heard)).into_owned();
                if stream.write_all(robot.answer(&line).as_bytes()).is_err() {
                    return;
                }
            }
        })
    }

    /// Puts it before the wall.
    fn put(&self, row: usize) {
        let mut state = self.0.lock().unwrap();
        (state.heading, state.row) = (0.0, row);
    }

    fn speeds(&self) -> [i32; 2] {
        self.0.lock().unwrap().speeds
    }

    fn answer(&self, line: &str) -> String {
        let mut state = self.0.lock().unwrap();
        let passed = state.since.elapsed().as_secs_f64();
        state.since = Instant::now();
        let [left, right] = state.speeds.map(f64::from);
        // A pulse in 10 ms is 8.2 mm/s, and the wheels are 54 mm apart.
        state.heading += passed * 8.2 * (right - left) / (TAU * 54.0);
        // Its odometers count 12 pulses in a mm.
        state.counts[0] += passed * 8.2 * 12.0 * left;
        state.counts[1] += passed * 8.2 * 12.0 * right;
        let fields: Vec<&str> = line.split(',').collect();
        match fields[..] {
            [""] => String::new(),
            ["B"] => "b,5.02,5.01\r\n".into(),
            ["D", left, right] => {
                state.speeds = [left, right].map(|speed| speed.parse().unwrap());
                "d\r\n".into()
            }
            ["N"] => {
                let bearing = (state.heading.rem_euclid(1.0) * 180.0) as usize % 180;
                let cell = SensorTables::khepera().classes[0]
                    .cell(state.row * 180 + bearing)
                    .to_vec();
                let fields: Vec<String> = cell.iter().map(u16::to_string).collect();
                format!("n,{}\r\n", fields.join(","))
            }
            ["E"] => format!("e,{},{}\r\n", state.speeds[0], state.speeds[1]),
            ["H"] => format!("h,{},{}\r\n", state.counts[0].floor(), state.counts[1].floor()),
            _ => "z,Protocol error\r\n".into(),
        }
    }
}

/// Asserts that each cell of a row is one of the built-in table at most two bearings aside: one for the time between a reading
/// and that of the odometers, and one for where an interval begins.
fn assert_row(table: &SensorTable, row: usize, of: usize) {
    let known = &SensorTables::khepera().classes[0];
    for bearing in 0..180 {
        let cell = table.cell(row * 180 + bearing);
        let mut near = (0..5).map(|aside| known.cell(of * 180 + (bearing + 178 + aside) % 180));
        assert!(near.any(|near| near == cell), "row {row} at {bearing}: {cell:?}");
    }
}

/// The command that samples some rows of an object, without a directory.
fn sample<'a>(address: &'a str, object: &'a str, rows: &'a str) -> [&'a str; 9] {
    [
        "robot",
        "sample",
        "--robot",
        address,
        "--objects",
        object,
        "--rows",
        rows,
        "--no-motors",
    ]
}

/// How far apart its wheels are, what is read and what is written, without a person.
#[test]
fn a_robot_alone_is_sampled() {
    let place = Place::new("alone");
    let robot = Khepera::new();
    let address = robot.start();
    let sample = sample(&address, "wall", "1");
    let ran = place
        .run(&[&sample[..], &["--yes", "--json", "--out", "out"]].concat())
        .exits(0);
    let lines: Vec<Value> = ran
        .stdout
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(lines.len(), 2, "{}", ran.stdout);
    assert_eq!(
        (&lines[0]["row"], &lines[0]["gap_mm"]),
        (&"wall-00".into(), &5.0.into())
    );
    assert!(lines[0]["drift_degrees"].as_f64().unwrap().abs() < 4.0, "{}", lines[0]);
    assert_eq!(lines[1], json!({ "tables": ["out/wall.sam"], "motors": null }));
    ran.says(&["row 1 of 1, 1 min left: put the robot's rim 5 mm from the wall"]);
    assert_eq!(robot.speeds(), [0, 0]);
    let table = SensorTable::read(place.at("out/wall.sam")).unwrap().table;
    assert_eq!((table.sensors, table.rows, table.nearest), (8, 1, 5.0));
    assert_row(&table, 0, 0);
    // Its wheels are 54 mm apart, not 53.
    let turning: Value = serde_json::from_str(&place.text("out/rows/turning.json")).unwrap();
    let apparent = turning["apparent"].as_f64().unwrap();
    assert!((apparent - 54.0 / 53.0).abs() < 0.003, "{apparent}");
    // All is there: it ends at once.
    let start = Instant::now();
    place.good(&[&sample[..], &["--yes", "--out", "out"]].concat());
    assert!(start.elapsed().as_secs() < 15);
    place
        .run(&[&sample[..], &["--out", "elsewhere"]].concat())
        .exits(3)
        .says(&["standard input is no terminal", "--yes"]);
}

/// A program with a person at its terminal.
struct Session {
    program: Child,
    terminal: serialport::TTYPort,
    lines: BufReader<std::process::ChildStderr>,
    said: String,
}

impl Session {
    fn start(place: &Place, arguments: &[&str]) -> Self {
        let (terminal, mut slave) = serialport::TTYPort::pair().unwrap();
        let path = slave.name().unwrap();
        slave.set_exclusive(false).unwrap();
        // As a shell has it.
        assert!(
            Command::new("stty")
                .args(["-F", &path, "sane"])
                .status()
                .unwrap()
                .success()
        );
        let input = File::options().read(true).write(true).open(&path).unwrap();
        let mut command = place.command(arguments);
        let command = command.stdin(input).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut program = command.spawn().unwrap();
        let lines = BufReader::new(program.stderr.take().unwrap());
        Self {
            program,
            terminal,
            lines,
            said: String::new(),
        }
    }

    /// Reads until a line has these words.
    fn hears(&mut self, words: &str) {
        loop {
            let mut line = String::new();
            assert!(
                self.lines.read_line(&mut line).unwrap() > 0,
                "no `{words}` in\n{}",
                self.said
            );
            self.said += &line;
            if line.contains(words) {
                return;
            }
        }
    }

    fn types(&mut self, keys: &str) {
        // What is typed before a question is no answer to it.
        thread::sleep(Duration::from_millis(300));
        self.terminal.write_all(keys.as_bytes()).unwrap();
    }

    fn exits(mut self, code: i32) -> String {
        self.lines.read_to_string(&mut self.said).unwrap();
        assert_eq!(self.program.wait().unwrap().code(), Some(code), "{}", self.said);
        self.said
    }
}

/// A person at a terminal places the robot; Ctrl-C in the middle of a row stops its wheels and keeps the rows before.
#[test]
fn a_person_places_a_robot_and_goes_on_after_ctrl_c() {
    let place = Place::new("placed");
    fs::create_dir_all(place.at("out/rows")).unwrap();
    place.write("out/rows/turning.json", TURNING);
    let robot = Khepera::new();
    let address = robot.start();
    let sample = [&sample(&address, "shelf:wall", "2")[..], &["--out", "out"]].concat();
    let mut session = Session::start(&place, &sample);
    session.hears("row 1 of 2, 1 min left: put the robot's rim 5 mm from the shelf, a wall, heading straight at it");
    session.hears("Enter: continue   S: repeat the previous row   Q: quit");
    robot.put(0);
    session.types("?\n");
    session.hears("Q: quit");
    session.types("\n");
    session.hears("proximity_back_left |");
    session.hears("whole turn: ");
    session.hears("row 2 of 2, 1 min left: put the robot's rim 7 mm");
    session.hears("Q: quit");
    robot.put(1);
    session.types("\n");
    thread::sleep(Duration::from_secs(4));
    assert_ne!(robot.speeds(), [0, 0]);
    let id = session.program.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let said = session.exits(75);
    assert!(said.contains("run the same command again to continue"), "{said}");
    assert_eq!(robot.speeds(), [0, 0]);
    assert!(place.text("out/shelf.svg").contains("Readings of eight sensors"));

    let mut session = Session::start(&place, &sample);
    session.hears("row 2 of 2");
    session.hears("Q: quit");
    robot.put(1);
    session.types("\n");
    let said = session.exits(0);
    assert!(said.contains("wrote 1 table of sensors to out"), "{said}");
    assert_eq!(robot.speeds(), [0, 0]);
    let table = SensorTable::read(place.at("out/shelf.sam")).unwrap().table;
    assert_eq!((table.class.as_str(), table.rows), ("shelf", 2));
    assert_row(&table, 0, 0);
    assert_row(&table, 1, 1);
}

#[test]
fn what_can_not_be_sampled_is_refused() {
    let place = Place::new("refused");
    let sample = ["robot", "sample", "--backend", "cpu", "--out", "out"];
    for (arguments, code, words) in [
        (
            &["--robot", "surrogate:1", "--turns", "2"][..],
            3,
            "--turns: is given with --robot surrogate:1; allowed: with",
        ),
        (&["--yes"], 3, "--yes: is given"),
        (
            &["--robot", "tcp:127.0.0.1:9", "--yes", "--objects", "can:round"],
            3,
            "`round` is no shape",
        ),
        (
            &["--robot", "tcp:127.0.0.1:9", "--yes", "--guard", "speed=1"],
            3,
            "speed",
        ),
        (
            &["--robot", "tcp:127.0.0.1:9", "--yes"],
            4,
            "tcp:127.0.0.1:9: can't be opened",
        ),
        (&["--robot", "tcp:127.0.0.1:9", "--rows", "0"], 2, "--rows"),
        (
            &["--robot", "tcp:127.0.0.1:9", "--spacing", "0"],
            2,
            "allowed: a number from 0.01 to 1000",
        ),
        (
            &["--robot", "tcp:127.0.0.1:9", "--full-speed", "9", "--no-motors"],
            2,
            "--no-motors",
        ),
    ] {
        place.run(&[&sample[..], arguments].concat()).exits(code).says(&[words]);
    }
    let robot = Khepera::new();
    let address = robot.start();
    place
        .run(&[&sample[..], &["--robot", &address, "--yes", "--full-speed", "250"]].concat())
        .exits(3)
        .says(&["--full-speed 250: is more than the guard allows; allowed: up to 200 mm/s"]);
    assert_eq!(robot.speeds(), [0, 0]);
}
