//! `oneiro guard` and `oneiro robot drive` against robots that keep their last speeds for ever: whatever happens to the
//! program that drives, the wheels stand in time.
#![cfg(unix)]

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::process::CommandExt;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use serialport::SerialPort;

use crate::peers::{self, Body, EPuck2, Manner, machine_is_late, wait};
use crate::place::{Place, Ran};
use crate::robots;

/// From an event to wheels that stand.
const LIMIT: Duration = Duration::from_millis(500);
/// For what has no limit but must happen.
const LONG: Duration = Duration::from_secs(20);

/// A robot of each kind of link: a serial port, Aseba over TCP, and the e-puck2's Wi-Fi.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Khepera,
    Thymio,
    EPuck2,
}

const KINDS: [Kind; 3] = [Kind::Khepera, Kind::Thymio, Kind::EPuck2];

/// Starts a robot with turning wheels. Returns its address.
fn start(kind: Kind, body: &Body) -> String {
    match kind {
        Kind::Khepera => robots::khepera(body),
        Kind::Thymio => robots::thymio(body),
        Kind::EPuck2 => EPuck2(body.clone()).start(),
    }
}

/// Waits until the wheels turn as they are driven: alike, and at speed.
#[track_caller]
fn wait_for_speed(body: &Body) {
    wait("full speed", LONG, || {
        let ([left, right], since) = body.wheels();
        left > 0 && left == right && since.elapsed() > Duration::from_millis(150)
    });
}

/// Checks that the wheels stand soon after an event, and go on standing. Returns how soon.
#[track_caller]
fn stopped(what: &str, body: &Body, event: Instant) -> Duration {
    wait(what, LONG, || body.stands());
    let since = body.wheels().1;
    assert!(since > event, "{what}: the wheels stood already");
    let took = since - event;
    assert!(took <= LIMIT, "{what}: the wheels stood after {took:?}");
    thread::sleep(Duration::from_millis(400));
    assert!(body.stands(), "{what}: the wheels turn again");
    took
}

fn signal(name: &str, id: &str) {
    // "--" for the ids of groups, which are negative.
    let status = Command::new("kill").args([name, "--", id]).status().unwrap();
    assert!(status.success(), "kill {name} {id}");
}

/// A program that drives: `oneiro robot drive` with a file that goes straight on for a minute. It leads a group of its own,
/// as a shell's job does.
struct Drive {
    place: Place,
    program: Child,
}

impl Drive {
    fn start(name: &str, address: &str, more: &[&str]) -> Self {
        let place = Place::new(name);
        place.write("straight.txt", "60 80 80\n");
        let arguments = [&["robot", "drive", address, "--commands", "straight.txt"], more].concat();
        let mut command = place.command(&arguments);
        let program = command
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .process_group(0)
            .spawn()
            .unwrap();
        Self { place, program }
    }

    fn id(&self) -> String {
        self.program.id().to_string()
    }

    /// The process of its guard.
    fn guard(&self) -> String {
        let list = Command::new("ps").args(["-e", "-o", "pid=,ppid="]).output().unwrap();
        let list = String::from_utf8(list.stdout).unwrap();
        let mut pairs = list.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
        let guard = pairs.find(|pair| pair[1] == self.id()).unwrap();
        guard[0].to_owned()
    }

    fn end(self) -> Ran {
        let ran = Ran::new(&["robot", "drive"], &self.program.wait_with_output().unwrap());
        drop(self.place);
        ran
    }
}

fn is_alive(id: &str) -> bool {
    // A zombie is none of ours: its parent may be gone or stopped.
    let state = Command::new("ps").args(["-o", "stat=", "-p", id]).output().unwrap();
    let state = String::from_utf8(state.stdout).unwrap();
    !state.trim().is_empty() && !state.starts_with('Z')
}

/// Maximum between two stops if the robot has confirmed none.
const BETWEEN: Duration = Duration::from_millis(250);

/// A robot whose wheels turn; returns its address.
type Starts = fn(&Body) -> String;

/// Every driver, over each kind of link that it has.
const DRIVERS: [(&str, Starts); 7] = [
    ("Khepera, serial port", robots::khepera),
    ("Khepera, TCP", robots::khepera_over_tcp),
    ("e-puck, serial port", robots::epuck),
    ("e-puck, TCP", robots::epuck_over_tcp),
    ("e-puck2, Wi-Fi", |body| EPuck2(body.clone()).start()),
    ("Thymio II, cable", robots::thymio_at_a_port),
    ("Thymio II, TCP", robots::thymio),
];

/// The longest time between an event and another one in which a robot was not told to stop.
fn longest_pause(body: &Body, event: Instant, end: Instant) -> Duration {
    let stops = body.stops.lock().unwrap();
    let between = stops.iter().copied().filter(|at| (event..end).contains(at));
    let mut times: Vec<Instant> = std::iter::once(event).chain(between).collect();
    times.push(end);
    times.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap()
}

/// Whatever a robot does instead of confirming a stop, the guard repeats it within 250 ms; and once the robot is as before, the stop is
/// confirmed.
#[test]
fn a_stop_is_repeated_until_it_is_confirmed() {
    const WATCHED: Duration = Duration::from_millis(2500);
    const TRIES: u32 = 3;
    let is_over = AtomicBool::new(false);
    thread::scope(|scope| {
        let machine = scope.spawn(|| {
            peers::with_a_processor_of_its_own();
            machine_is_late(&is_over)
        });
        let of_driver = |(name, start): (&'static str, Starts)| {
            let body = Body::default();
            let mut program = Program::start("repeated", &start(&body), &[]);
            let mut pauses = Vec::new();
            for manner in [
                Some(Manner::Silent),
                Some(Manner::Late(Duration::from_millis(120))),
                Some(Manner::Late(Duration::from_millis(400))),
                Some(Manner::Endless),
                None,
            ] {
                // A machine that stalls does so once; a driver that waits too long does so each time.
                let mut pause = Duration::MAX;
                for _ in 0..TRIES {
                    if pause <= BETWEEN {
                        break;
                    }
                    program.reach_speed(&body);
                    match manner {
                        Some(manner) => body.answer(manner),
                        None => body.is_mad.store(true, Ordering::SeqCst),
                    }
                    let event = Instant::now();
                    program.send("\"stop\"");
                    // It keeps sending commands to drive. A slow robot may confirm the stop.
                    program.drive_until("the end", LONG, |program| {
                        let has_moved = event.elapsed() > Duration::from_millis(50);
                        event.elapsed() > WATCHED || has_moved && program.state()["state"] == "standing"
                    });
                    pause = pause.min(longest_pause(&body, event, Instant::now()));
                    body.answer(Manner::Plain);
                    body.is_mad.store(false, Ordering::SeqCst);
                    wait("a stop that is confirmed", LONG, || {
                        program.state()["state"] == "standing"
                    });
                    program.stands_in_spite_of_commands(&body);
                    program.send("\"resume\"");
                }
                pauses.push((manner, pause));
            }
            program.exits(0);
            (name, pauses)
        };
        let drivers = DRIVERS.map(|driver| scope.spawn(move || of_driver(driver)));
        let all = drivers.map(thread::ScopedJoinHandle::join);
        is_over.store(true, Ordering::Relaxed);
        let machine = machine.join().unwrap();
        eprintln!("milliseconds between two stops, at most; a thread that waits was late by {machine:.1?}");
        for (name, pauses) in all.map(Result::unwrap) {
            for (manner, pause) in pauses {
                let manner = manner.map_or("nonsense".to_owned(), |manner| format!("{manner:?}"));
                eprintln!("{name}, {manner}: {}", pause.as_millis());
                assert!(pause <= BETWEEN + machine, "{name}, {manner}: {pause:?}, {machine:?}");
            }
        }
    });
}

/// A robot that reads nothing, behind a port whose buffer is full: the guard says in time that it can't stop it, and the stop is confirmed
/// once the robot reads again. A Thymio II may not: half a message puts it out of step, and its protocol has no way back.
#[cfg(target_os = "linux")]
#[test]
fn a_robot_that_reads_nothing_does_not_hold_the_guard() {
    use std::os::unix::fs::OpenOptionsExt;

    use libc::{O_NOCTTY, O_NONBLOCK};

    let no_wait = O_NONBLOCK | O_NOCTTY;
    for (name, start) in [DRIVERS[0], DRIVERS[2]] {
        let body = Body::default();
        let address = start(&body);
        let path = address.trim_start_matches("serial:").split('@').next().unwrap();
        // Another hand on the port, which is opened before the guard's.
        let mut other = File::options().write(true).custom_flags(no_wait).open(path).unwrap();
        let mut program = Program::start("full", &address, &[]);
        program.reach_speed(&body);
        body.is_deaf.store(true, Ordering::SeqCst);
        let mut filled = 0;
        while let Ok(count) = other.write(&[0; 64]) {
            filled += count;
        }
        assert!(filled > 1000, "{name}: {filled} bytes");
        let event = Instant::now();
        program.send("\"stop\"");
        program.drive_until("that it can't be stopped", LONG, |program| {
            program.state()["cannot_stop"] == true
        });
        let took = event.elapsed();
        // Twice what is documented, on a busy machine.
        assert!(took < Duration::from_secs(1), "{name}: {took:?}");
        program.drive_until("two seconds", LONG, |_| event.elapsed() > Duration::from_secs(2));
        body.is_deaf.store(false, Ordering::SeqCst);
        program.drive_until("a stop that is confirmed", LONG, |program| {
            program.state()["state"] == "standing"
        });
        assert!(body.stands(), "{name}");
        program.exits(0);
    }
}

/// For each kind of robot and each thing that can happen to the program or the guard: the time until the wheels stand.
#[test]
fn the_wheels_stand_in_time_whatever_happens_to_the_program() {
    let mut table = String::from("milliseconds until the wheels stand\n");
    for kind in KINDS {
        for what in [
            "kill -9 of the program",
            "kill -9 of the program's group",
            "SIGSTOP of the program",
            "Ctrl-C",
            "SIGTERM of the guard",
            "SIGHUP of the guard",
            "nonsense on the line",
        ] {
            let body = Body::default();
            let mut drive = Drive::start("drive", &start(kind, &body), &[]);
            wait_for_speed(&body);
            let (id, guard) = (drive.id(), drive.guard());
            let event = Instant::now();
            match what {
                "kill -9 of the program" => signal("-KILL", &id),
                "kill -9 of the program's group" => signal("-KILL", &format!("-{id}")),
                "SIGSTOP of the program" => signal("-STOP", &id),
                "Ctrl-C" => signal("-INT", &format!("-{id}")),
                "SIGTERM of the guard" => signal("-TERM", &guard),
                "SIGHUP of the guard" => signal("-HUP", &guard),
                _ => body.is_mad.store(true, Ordering::SeqCst),
            }
            let took = stopped(&format!("{kind:?}, {what}"), &body, event);
            writeln!(table, "{kind:?}, {what}: {}", took.as_millis()).unwrap();
            match what {
                "SIGSTOP of the program" => {
                    // It goes on with what it was doing, and the robot too: a fresh command comes.
                    signal("-CONT", &id);
                    wait_for_speed(&body);
                    signal("-KILL", &id);
                }
                "Ctrl-C" => {
                    drive.end().exits(75).says(&["stopped before the end of the commands"]);
                    continue;
                }
                "nonsense on the line" => body.is_mad.store(false, Ordering::SeqCst),
                _ => {}
            }
            wait("the end of the program and its guard", LONG, || {
                // A guard that was told to end is gone, and the program notices.
                drive.program.try_wait().unwrap().is_some() && !is_alive(&guard)
            });
            assert!(body.stands(), "{kind:?}, {what}");
        }
    }
    eprint!("{table}");
}

/// What remains: nothing on these robots stops them without the guard. A program that is still there does, later.
#[test]
fn without_the_guard_the_wheels_turn_on() {
    for kind in KINDS {
        let body = Body::default();
        let drive = Drive::start("unguarded", &start(kind, &body), &[]);
        wait_for_speed(&body);
        let (id, guard) = (drive.id(), drive.guard());
        signal("-STOP", &id);
        signal("-KILL", &guard);
        thread::sleep(Duration::from_secs(1));
        assert!(!body.stands(), "{kind:?}");
        let event = Instant::now();
        signal("-CONT", &id);
        drive.end().exits(4).says(&["the guard is gone", "stopped without it"]);
        assert!(body.stands(), "{kind:?}");
        let took = body.wheels().1 - event;
        eprintln!("{kind:?}, stopped by the program without its guard: {took:.1?}");
    }
}

/// A guard that hangs is killed by the program, which then stops the robot.
#[test]
fn a_guard_that_hangs_is_replaced() {
    let body = Body::default();
    let drive = Drive::start("hung", &start(Kind::Thymio, &body), &[]);
    wait_for_speed(&body);
    signal("-STOP", &drive.guard());
    drive.end().exits(4).says(&["the guard hangs", "stopped without it"]);
    assert!(body.stands());
}

/// A program that uses the guard itself.
struct Program {
    guard: Child,
    requests: Option<ChildStdin>,
    reports: Receiver<Value>,
    sequence: u64,
    /// The newest report of the state.
    state: Value,
    _place: Place,
}

impl Program {
    fn start(name: &str, address: &str, settings: &[&str]) -> Self {
        let place = Place::new(name);
        let mut arguments = vec!["guard", address];
        for setting in settings {
            arguments.extend(["--guard", setting]);
        }
        Self::of(place, &arguments)
    }

    fn of(place: Place, arguments: &[&str]) -> Self {
        let mut command = place.command(arguments);
        let mut guard = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let stdout = BufReader::new(guard.stdout.take().unwrap());
        let (sender, reports) = mpsc::channel();
        thread::spawn(move || {
            for line in stdout.lines() {
                let report = serde_json::from_str(&line.unwrap()).unwrap();
                if sender.send(report).is_err() {
                    return;
                }
            }
        });
        let mut program = Self {
            requests: guard.stdin.take(),
            guard,
            reports,
            sequence: 0,
            state: Value::Null,
            _place: place,
        };
        program.send(&json!({ "hello": { "version": 1 } }).to_string());
        program
    }

    fn send(&mut self, line: &str) {
        let requests = self.requests.as_mut().unwrap();
        writeln!(requests, "{line}").unwrap();
    }

    fn command(&mut self, left: f64, right: f64) {
        self.sequence += 1;
        let command = json!({ "sequence": self.sequence, "left_mm_s": left, "right_mm_s": right });
        self.send(&json!({ "command": command }).to_string());
    }

    /// The newest state.
    fn state(&mut self) -> &Value {
        for report in self.reports.try_iter() {
            if let Some(state) = report.get("state") {
                self.state = state.clone();
            }
        }
        &self.state
    }

    /// Drives straight on until something is so.
    #[track_caller]
    fn drive_until(&mut self, what: &str, limit: Duration, mut done: impl FnMut(&mut Self) -> bool) {
        let start = Instant::now();
        while !done(self) {
            assert!(start.elapsed() < limit, "{what} did not happen: {}", self.state);
            self.command(80.0, 80.0);
            thread::sleep(Duration::from_millis(20));
        }
    }

    /// Drives until the robot goes at speed.
    #[track_caller]
    fn reach_speed(&mut self, body: &Body) {
        self.drive_until("full speed", LONG, |_| {
            let ([left, right], since) = body.wheels();
            left > 0 && left == right && since.elapsed() > Duration::from_millis(150)
        });
    }

    /// Goes on sending commands for a while, in which the wheels must stand.
    #[track_caller]
    fn stands_in_spite_of_commands(&mut self, body: &Body) {
        let start = Instant::now();
        self.drive_until("the end", LONG, |_| {
            assert!(body.stands());
            start.elapsed() > Duration::from_millis(600)
        });
    }

    #[track_caller]
    fn has_reason(&mut self, reason: &str) {
        self.drive_until(reason, LONG, |program| {
            let state = program.state();
            state["reasons"]
                .as_array()
                .is_some_and(|reasons| reasons.contains(&reason.into()))
        });
    }

    #[track_caller]
    fn exits(mut self, code: i32) {
        self.requests = None;
        assert_eq!(self.guard.wait().unwrap().code(), Some(code));
    }
}

/// What stops a robot until somebody resumes: the event, its reason, and its end.
#[test]
fn what_needs_a_resume_stops_the_robot_until_it_comes() {
    type Event = fn(&mut Program, &Body);
    let cases: [(&str, Event, Event, Duration); 5] = [
        ("operator", |program, _| program.send("\"stop\""), |_, _| {}, LIMIT),
        (
            "tracker",
            |program, _| program.send(r#"{"tracker":{"lost":true}}"#),
            |program, _| program.send(r#"{"tracker":{"lost":false}}"#),
            LIMIT,
        ),
        (
            "messages",
            |program, _| (0..3).for_each(|_| program.send(r#"{"command":{"sequence":"#)),
            |_, _| {},
            LIMIT,
        ),
        (
            "lifted",
            |_, body| body.is_lifted.store(true, Ordering::SeqCst),
            |_, body| body.is_lifted.store(false, Ordering::SeqCst),
            LIMIT,
        ),
        (
            // It is read once a second, and twice.
            "battery",
            |_, body| body.is_low.store(true, Ordering::SeqCst),
            |_, body| body.is_low.store(false, Ordering::SeqCst),
            Duration::from_millis(2500),
        ),
    ];
    for kind in KINDS {
        // A Khepera senses neither.
        let count = if kind == Kind::Khepera { 3 } else { 5 };
        let body = Body::default();
        let mut program = Program::start("resume", &start(kind, &body), &[]);
        for (reason, begin, end, limit) in &cases[..count] {
            let case = format!("{kind:?}, {reason}");
            program.reach_speed(&body);
            let event = Instant::now();
            begin(&mut program, &body);
            program.drive_until(&case, LONG, |_| body.stands());
            let since = body.wheels().1;
            assert!(since > event, "{case}: the wheels stood already");
            let took = since - event;
            assert!(took <= *limit, "{case}: {took:?}");
            eprintln!("{case}: {took:.1?}");
            program.has_reason(reason);
            // Neither commands nor the end of it are enough, nor is a resume before it has ended.
            if !matches!(*reason, "operator" | "messages") {
                program.send("\"resume\"");
            }
            program.stands_in_spite_of_commands(&body);
            end(&mut program, &body);
            program.stands_in_spite_of_commands(&body);
            if *reason == "battery" {
                thread::sleep(Duration::from_secs(1));
            }
            program.send("\"resume\"");
        }
        program.reach_speed(&body);
        program.exits(0);
        assert!(body.stands(), "{kind:?}");
    }
}

/// A program that says nothing more, but lives: the commands expire. Those of an older program that come late do not count.
#[test]
fn commands_expire() {
    let body = Body::default();
    let mut program = Program::start("expiry", &start(Kind::Khepera, &body), &["expiry_ms=150"]);
    program.reach_speed(&body);
    let took = stopped("expiry", &body, Instant::now());
    assert!(took < Duration::from_millis(300), "{took:?}");
    program.sequence -= 10;
    for _ in 0..2 {
        program.command(80.0, 80.0);
    }
    thread::sleep(Duration::from_millis(200));
    assert!(body.stands());
    // A fresh one does.
    program.sequence += 10;
    program.reach_speed(&body);
    program.exits(0);
}

/// How far the wheels have turned is reported where it is wanted, and the robot can tell.
#[test]
fn travel_is_reported_where_it_is_wanted() {
    for (kind, wanted) in [(Kind::Khepera, true), (Kind::Khepera, false), (Kind::Thymio, true)] {
        let body = Body::default();
        let place = Place::new("travel");
        let address = start(kind, &body);
        let arguments = ["guard", &address, "--kinds", "proximity", "--odometry"];
        let mut program = Program::of(place, &arguments[..if wanted { 5 } else { 4 }]);
        program.reach_speed(&body);
        let before = body.turned();
        program.reports.try_iter().for_each(drop);
        program.drive_until("half a second", LONG, |_| body.turned()[0] > before[0] + 5.0);
        let reports: Vec<Value> = program.reports.try_iter().collect();
        let travels: Vec<&Value> = reports.iter().filter_map(|report| report.get("travel")).collect();
        if kind == Kind::Thymio || !wanted {
            assert_eq!(travels, Vec::<&Value>::new());
            continue;
        }
        // Pulses of 1/12 mm, one in 10 ms for a unit of speed. Readings are some ms old.
        let expected = (body.turned()[0] - before[0]) * 100.0 / 12.0;
        let way = |wheel| travels[travels.len() - 1][wheel].as_f64().unwrap() - travels[0][wheel].as_f64().unwrap();
        assert!(
            (way("left_mm") - expected).abs() < 15.0,
            "{} of {expected} mm",
            way("left_mm")
        );
        let count = 1.001 / 12.0;
        assert!((way("left_mm") - way("right_mm")).abs() <= count);
        assert!(travels.len() >= 8, "{} in half a second", travels.len());
        program.exits(0);
    }
}

/// The radio is lost while it drives: nothing can stop it, which is said in time; and it is stopped when the radio is back.
#[test]
fn a_link_that_does_not_carry_the_stop_is_said_in_time() {
    for kind in KINDS {
        let body = Body::default();
        let mut program = Program::start("lost", &start(kind, &body), &[]);
        program.reach_speed(&body);
        body.is_deaf.store(true, Ordering::SeqCst);
        let event = Instant::now();
        program.drive_until("cannot stop", LONG, |program| program.state()["cannot_stop"] == true);
        let took = event.elapsed();
        assert!(took <= LIMIT, "{kind:?}: said after {took:?}");
        eprintln!("{kind:?}, cannot stop said: {} ms", took.as_millis());
        assert!(!body.stands());
        thread::sleep(Duration::from_millis(700));
        body.is_deaf.store(false, Ordering::SeqCst);
        wait("the stop", LONG, || body.stands());
        // It keeps on trying until the robot confirms.
        wait("the confirmation", LONG, || program.state()["state"] == "standing");
        assert_eq!(program.state()["cannot_stop"], false);
        program.exits(0);
        assert!(body.stands());
    }
}

/// A robot that never obeys: the guard tries for as long as it is told to, then says so.
#[test]
fn a_guard_that_can_not_stop_the_robot_ends_with_4() {
    let body = Body::default();
    let mut program = Program::start("runaway", &start(Kind::EPuck2, &body), &["give_up_s=5"]);
    program.reach_speed(&body);
    body.is_runaway.store(true, Ordering::SeqCst);
    let event = Instant::now();
    program.requests = None;
    assert_eq!(program.guard.wait().unwrap().code(), Some(4));
    assert!(event.elapsed() > Duration::from_secs(5));
    let last = program.reports.iter().last().unwrap();
    assert_eq!(last["failed"]["code"], 4);
    let message = last["failed"]["message"].as_str().unwrap();
    assert!(message.starts_with("cannot stop: "), "{message}");
    assert!(!body.stands());
}

/// A terminal in which keys are pressed: standard input is a pseudo-terminal.
#[test]
fn keys_drive_while_they_are_held() {
    let body = Body::default();
    let place = Place::new("keys");
    let address = start(Kind::Thymio, &body);
    let (mut terminal, mut slave) = serialport::TTYPort::pair().unwrap();
    let path = slave.name().unwrap();
    slave.set_exclusive(false).unwrap();
    let modes = || {
        let list = Command::new("stty").args(["-a", "-F", &path]).output().unwrap();
        String::from_utf8(list.stdout).unwrap()
    };
    // As a shell has it: whole lines, which are shown.
    let sane = Command::new("stty").args(["-F", &path, "sane"]).status().unwrap();
    assert!(sane.success());
    let before = modes();
    let input = File::options().read(true).write(true).open(&path).unwrap();
    let mut command = place.command(&["robot", "drive", &address, "--json", "--speed", "60%"]);
    let program = command
        .stdin(input)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let mut program = program.unwrap();
    // The first line comes when the robot is connected.
    program.stdout.as_mut().unwrap().read_exact(&mut [0]).unwrap();
    wait("standing", LONG, || body.stands());
    assert_ne!(modes(), before);
    let held = |terminal: &mut serialport::TTYPort, key: &[u8]| {
        for _ in 0..25 {
            terminal.write_all(key).unwrap();
            thread::sleep(Duration::from_millis(40));
        }
        Instant::now()
    };
    let released = held(&mut terminal, b"\x1b[A");
    // 60 % of 199 mm/s, in units of 0.332 mm/s.
    assert_eq!(body.wheels().0, [360, 360]);
    let took = stopped("the release of a key", &body, released);
    eprintln!("release of a key: {} ms", took.as_millis());
    held(&mut terminal, b"d");
    assert_eq!(body.wheels().0, [180, -180]);
    // Space stops at once, and keys do nothing until R.
    held(&mut terminal, b"w");
    let event = Instant::now();
    terminal.write_all(b" ").unwrap();
    stopped("space", &body, event);
    held(&mut terminal, b"w");
    assert!(body.stands());
    terminal.write_all(b"r").unwrap();
    held(&mut terminal, b"w");
    assert_eq!(body.wheels().0, [360, 360]);
    let event = Instant::now();
    terminal.write_all(b"q").unwrap();
    stopped("Q", &body, event);
    let ran = Ran::new(&["robot", "drive"], &program.wait_with_output().unwrap());
    ran.exits(0);
    assert_eq!(modes(), before);
    drop(slave);
}

#[test]
fn a_dry_run_says_what_would_be_sent_and_opens_nothing() {
    let place = Place::new("dry");
    place.write("commands.txt", "0.1 40 -40\n0.1 5 5 # slower\n0.1 0 0\n");
    // Nobody is there.
    let address = "tcp:127.0.0.1:9";
    let arguments = ["robot", "drive", address, "--commands", "commands.txt", "--dry-run"];
    let text = place.good(&arguments);
    let expected = "  0.000 s: left    8.0 mm/s, right   -8.0 mm/s
  0.020 s: left   16.0 mm/s, right  -16.0 mm/s
  0.040 s: left   24.0 mm/s, right  -24.0 mm/s
  0.060 s: left   32.0 mm/s, right  -32.0 mm/s
  0.080 s: left   40.0 mm/s, right  -40.0 mm/s
  0.100 s: left    5.0 mm/s, right    5.0 mm/s
  0.200 s: left    0.0 mm/s, right    0.0 mm/s
";
    assert_eq!(text, expected);
    let text = place.good(&[&arguments[..], &["--json", "--guard", "speed_mm_s=10"]].concat());
    let first: Value = serde_json::from_str(text.lines().next().unwrap()).unwrap();
    assert_eq!(first, json!({ "time_s": 0.0, "left_mm_s": 8, "right_mm_s": -8 }));
    let second: Value = serde_json::from_str(text.lines().nth(1).unwrap()).unwrap();
    assert_eq!(second["left_mm_s"], 10);
}

#[test]
fn a_file_is_driven_to_its_end_and_recorded() {
    let place = Place::new("file");
    place.write("commands.txt", "0.6 30 30\n");
    let body = Body::default();
    let address = start(Kind::Khepera, &body);
    let arguments = [
        "robot",
        "drive",
        &address,
        "--commands",
        "commands.txt",
        "--record",
        "link.txt",
    ];
    let text = place.good(&[&arguments[..], &["--kinds", "proximity"]].concat());
    assert!(body.stands());
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let fastest = lines
        .iter()
        .filter_map(|line| line["left_mm_s"].as_f64())
        .fold(0.0, f64::max);
    assert_eq!(fastest, 30.0);
    let last = lines.last().unwrap();
    assert_eq!((&last["state"], &last["left_mm_s"]), (&json!("standing"), &json!(0)));
    let values = last["values"].as_object().unwrap();
    assert_eq!(values.len(), 8);
    assert_eq!(values["proximity_left_90"], 11);
    // D,4,4: 30 mm/s in units of 8.2 mm/s.
    let recorded = place.text("link.txt");
    assert!(recorded.starts_with("oneiro link recording 1\n"));
    assert!(recorded.contains(" > 442c342c340d\n"), "{recorded}");
}

/// To connect takes longer than the file.
#[test]
fn a_file_begins_when_the_robot_is_ready() {
    let place = Place::new("short");
    place.write("short.txt", "0.2 30 30\n");
    let body = Body::default();
    let address = start(Kind::Thymio, &body);
    let program = place
        .command(&["robot", "drive", &address, "--commands", "short.txt"])
        .spawn();
    // 30 mm/s in units of 0.332 mm/s.
    wait("driving", LONG, || body.wheels().0 == [90, 90]);
    assert!(program.unwrap().wait().unwrap().success());
    assert!(body.stands());
}

#[test]
fn what_can_not_be_driven_is_refused() {
    let place = Place::new("refusals");
    place.write("bad.txt", "1 50 50\n1 50\n");
    place.write("good.txt", "1 50 50\n");
    place.write("mine.txt", "mine");
    let nobody = "tcp:127.0.0.1:9";
    let body = Body::default();
    let robot = start(Kind::Khepera, &body);
    for (arguments, code, words) in [
        (&[nobody][..], 3, &["standard input is no terminal", "--commands"][..]),
        (&[nobody, "--dry-run"], 3, &["standard input is no terminal"]),
        (
            &[nobody, "--commands", "bad.txt"],
            3,
            &["bad.txt: line 2: \"1 50\" is no command; allowed: SECONDS LEFT RIGHT"],
        ),
        (&[nobody, "--commands", "none.txt"], 3, &["none.txt"]),
        (
            &["surrogate:1", "--commands", "good.txt"],
            3,
            &["a surrogate has no link"],
        ),
        (
            &[nobody, "--commands", "good.txt", "--guard", "expiry_ms=700"],
            3,
            &["guard expiry_ms: `700` is out of range; allowed: 100 to 500 ms"],
        ),
        (&[nobody, "--commands", "good.txt"], 4, &["can't be opened"]),
        (
            &[&robot, "--commands", "good.txt", "--kinds", "ground"],
            3,
            &["Khepera has no sensors of ground; allowed: proximity, light, wheel_speed"],
        ),
        (
            &[&robot, "--commands", "good.txt", "--record", "mine.txt"],
            3,
            &["mine.txt: exists already"],
        ),
        (&[nobody, "--speed", "0"], 2, &["allowed: 1 to 1100 mm/s"]),
        (&[nobody, "--speed", "101%"], 2, &["1% to 100% of the maximum"]),
        (&[nobody, "--dry-run", "--record", "x"], 2, &["--dry-run"]),
    ] {
        let ran = place.run(&[&["robot", "drive"], arguments].concat());
        ran.exits(code).says(words);
    }
    // The guard says everything on standard output.
    let ran = place.run(&["guard", "tcp:localhost"]).exits(3);
    assert!(
        ran.stdout.contains(r#"{"failed":{"code":3,"#) && ran.stdout.contains("has no port"),
        "{}",
        ran.stdout
    );
}
