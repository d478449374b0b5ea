//! A fleet in real time: the operator's program and daemons, each with its guard and a scripted e-puck2, all on this machine. How late
//! their cycles are, how long generations on board take, and how much of a processor and of memory that takes; and what others send
//! who have no key: floods, lies, and what they have recorded. `ONEIRO_ON_BOARD` names another program for the daemons, such as the
//! small one of the profile `robot`.

use std::fmt::Write as _;
use std::fs;
use std::net::UdpSocket;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::peers::{Body, EPuck2, wait};
use crate::place::{Place, Ran};

/// A robot, its ports for the tracker and for datagrams, and its folder on its computer.
struct Robot {
    body: Body,
    tracker: u16,
    radio: u16,
    home: PathBuf,
}

fn free_port() -> u16 {
    UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// Deploys a fleet whose computers are folders on this machine. Its robots also send all that they say to `recorders`.
fn deployed(place: &Place, robots: u32, interval_s: u32, recorders: &[u16]) -> Vec<Robot> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap();
    let clock = format!("[swarm]\nclock.interval_s = {interval_s}\nclock.installed_s = {interval_s}\n");
    let text = fs::read_to_string(root.join("experiments/odowd2014-over.toml")).unwrap();
    let text = text.replace("robots = 10", &format!("robots = {robots}"));
    place.write("experiment.toml", text.replace("[swarm]\n", &clock));
    place.good(&["fleet", "key", "experiment.key"]);
    // A shell, which takes `on-board` for a script.
    fs::copy("/bin/sh", place.at("shell")).unwrap();
    let operator = free_port();
    let mut file = format!(
        "experiment = \"experiment.toml\"\nseed = 1\nkey = \"experiment.key\"\noperator = \"127.0.0.1:{}\"\nbinary = \"shell\"\n\
         service = \"process\"\n[ssh]\nprogram = \"{}/tests/fleet/ssh\"\noptions = [\"-F\", \"{}\"]\n[tracker]\nlisten = \"127.0.0.1:1\"\n",
        operator,
        root.display(),
        place.at("").display(),
    );
    let radios: Vec<u16> = (0..robots).map(|_| free_port()).collect();
    let fleet: Vec<Robot> = (0..robots)
        .zip(&radios)
        .map(|(number, &radio)| {
            let (epuck, tracker) = (EPuck2::default(), free_port());
            let others = radios.iter().filter(|other| **other != radio);
            let peers = others.chain([&operator]).chain(recorders);
            let peers: Vec<String> = peers.map(|port| format!("\"127.0.0.1:{port}\"")).collect();
            fs::create_dir(place.at(format!("host-{number}"))).unwrap();
            writeln!(
                file,
                "[[robots]]\nnumber = {number}\nhost = \"host-{number}\"\nradio = \"127.0.0.1:{radio}\"\naddress = \"{}\"\n\
                 set.radio.listen = \"127.0.0.1:{radio}\"\nset.radio.peers = [{}]\nset.tracker.listen = \"127.0.0.1:{tracker}\"",
                epuck.start(),
                peers.join(", ")
            )
            .unwrap();
            Robot {
                body: epuck.0,
                tracker,
                radio,
                home: place.at(format!("host-{number}/oneiro/robot-{number}")),
            }
        })
        .collect();
    place.write("fleet.toml", &file);
    place.good(&["fleet", "deploy", "fleet.toml"]);
    let program = std::env::var("ONEIRO_ON_BOARD").unwrap_or_else(|_| env!("CARGO_BIN_EXE_oneiro").to_owned());
    for robot in &fleet {
        robot.runs(&format!("exec {program} on-board \"$@\"\n"));
    }
    fleet
}

impl Robot {
    /// Sets what runs as its daemon.
    fn runs(&self, script: &str) {
        let path = self.home.join("on-board");
        fs::write(&path, script).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    }
}

/// The operator's port.
fn operator_of(place: &Place) -> u16 {
    let file: toml::Table = place.text("fleet.toml").parse().unwrap();
    let address = file["operator"].as_str().unwrap();
    address.rsplit_once(':').unwrap().1.parse().unwrap()
}

/// Sends each robot ten sightings a second, by which it hears all others, until it is over.
fn track(fleet: &[Robot], is_over: &AtomicBool) {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let begun = Instant::now();
    while !is_over.load(Ordering::Relaxed) {
        for (id, robot) in fleet.iter().enumerate() {
            let others: Vec<usize> = (0..fleet.len()).filter(|other| *other != id).collect();
            let (t, x) = (begun.elapsed().as_secs_f64(), 200 + 60 * id);
            let line = json!({ "id": id, "t": t, "x": x, "y": 500, "heading": 0.25, "carries": false, "brought": 0, "heard": others });
            // A daemon that does not listen yet misses it.
            let _ = socket.send_to(line.to_string().as_bytes(), ("127.0.0.1", robot.tracker));
        }
        thread::sleep(Duration::from_millis(100));
    }
}

/// Events of a kind in a daemon's log.
fn events(robot: &Robot, kind: &str) -> Vec<Value> {
    let log = fs::read_to_string(robot.home.join("state/log.jsonl")).unwrap_or_default();
    let events = log.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    events.filter(|event| event["event"] == kind).collect()
}

fn number(event: &Value, key: &str) -> f64 {
    event[key].as_f64().unwrap_or_else(|| panic!("no {key} in {event}"))
}

/// What the system says of a daemon and of the guard that it has started: processor time, s, and the most memory that each had, kB.
fn used(robot: &Robot) -> (f64, Vec<u64>) {
    let daemon = fs::read_to_string(robot.home.join("pid")).unwrap();
    let daemon = daemon.trim();
    let (mut ticks, mut memory) = (0, Vec::new());
    for process in fs::read_dir("/proc").unwrap().flatten() {
        let read = |name: &str| fs::read_to_string(process.path().join(name)).unwrap_or_default();
        // The name, in brackets, may have blanks.
        let stat = read("stat");
        let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
        if fields.get(1) == Some(&daemon) || process.file_name() == daemon {
            ticks += fields[11].parse::<u64>().unwrap() + fields[12].parse::<u64>().unwrap();
            let status = read("status");
            let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
            memory.extend(peak.map(|peak| peak.trim().trim_end_matches(" kB").parse::<u64>().unwrap()));
        }
    }
    // Of ticks there are 100 a second on Linux.
    (ticks as f64 / 100.0, memory)
}

/// Ends the operator's program, and daemons that a failed test has left.
struct Operator<'a> {
    program: Option<Child>,
    place: &'a Place,
    is_over: &'a AtomicBool,
}

impl<'a> Operator<'a> {
    /// Starts the operator's program.
    fn start(place: &'a Place, is_over: &'a AtomicBool) -> Self {
        // Nobody reads what it says: in a pipe that would hold it up, and robots would stand.
        let mut start = place.command(&["fleet", "start", "fleet.toml"]);
        let program = start.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        Self {
            program: Some(program),
            place,
            is_over,
        }
    }
}

impl Operator<'_> {
    fn end(&mut self) {
        let Some(program) = self.program.take() else { return };
        self.is_over.store(true, Ordering::Relaxed);
        let arguments = ["fleet", "start"];
        let id = program.id().to_string();
        std::process::Command::new("kill").args(["-INT", &id]).status().unwrap();
        let ran = Ran::ended(&arguments, program);
        let stopped = self.place.run(&["fleet", "stop", "fleet.toml"]);
        if !thread::panicking() {
            ran.exits(75);
            stopped.exits(0);
        }
    }
}

impl Drop for Operator<'_> {
    fn drop(&mut self) {
        self.end();
    }
}

/// Two robots; with `ONEIRO_LONG` ten, with the study's intervals. At least half of the cycles are late by less than a cycle, and each
/// generation on board ends within its interval.
#[test]
fn daemons_keep_their_cycles_while_they_evolve() {
    let is_long = std::env::var_os("ONEIRO_LONG").is_some();
    let (robots, interval_s, intervals) = if is_long { (10, 60, 4) } else { (2, 10, 1) };
    let place = Place::new("fleet-in-time");
    let fleet = deployed(&place, robots, interval_s, &[]);
    let is_over = AtomicBool::new(false);
    thread::scope(|scope| {
        scope.spawn(|| track(&fleet, &is_over));
        let mut operator = Operator::start(&place, &is_over);
        let limit = Duration::from_secs(u64::from(3 * interval_s * (intervals + 2)));
        let mut began = None;
        wait("the intervals", limit, || {
            thread::sleep(Duration::from_millis(200));
            let lives = |robot: &Robot| events(robot, "late").len() >= intervals as usize;
            if began.is_none() && fleet.iter().all(|robot| !robot.body.stands()) {
                began = Some((Instant::now(), fleet.iter().map(|robot| used(robot).0).sum::<f64>()));
            }
            fleet.iter().all(lives)
        });
        let (since, before) = began.expect("all robots have driven");
        let (busy, memory): (Vec<f64>, Vec<Vec<u64>>) = fleet.iter().map(used).unzip();
        let share = (busy.iter().sum::<f64>() - before) / since.elapsed().as_secs_f64() / f64::from(robots);
        let memory = memory.iter().flatten().max().copied();
        operator.end();
        assert!(fleet.iter().all(|robot| robot.body.stands()));
        eprintln!(
            "{robots} robots, {interval_s} s an interval: {:.2} % of a processor each, {memory:?} kB of memory at most",
            100.0 * share
        );
        // Not of a program that is ten times as large.
        let is_small = std::env::var_os("ONEIRO_ON_BOARD").is_some();
        let is_little = memory.is_some_and(|memory| (1000..30_000).contains(&memory));
        assert!(!is_small || is_little, "{memory:?} kB");
        let mut worst = [0.0_f64; 3];
        for robot in &fleet {
            for own in events(robot, "late") {
                let figures = ["median_ms", "high_ms", "greatest_ms"].map(|key| number(&own, key));
                worst = std::array::from_fn(|index| worst[index].max(figures[index]));
                assert!(figures[0] < 100.0, "{own}");
                // It drives in most cycles.
                assert!(number(&own, "cycles") > f64::from(5 * interval_s), "{own}");
            }
        }
        eprintln!(
            "late, ms, of the worst interval: median {}, 99 % {}, greatest {}",
            worst[0], worst[1], worst[2]
        );
        let generations: Vec<Value> = fleet.iter().flat_map(|robot| events(robot, "simulated")).collect();
        let greatest = |key: &str| generations.iter().map(|own| number(own, key)).fold(0.0, f64::max);
        eprintln!(
            "{} generations: {} s of a processor at most, done after {} s at most",
            generations.len(),
            greatest("worked_s"),
            greatest("taken_s")
        );
        assert!(generations.len() >= (robots * intervals) as usize);
        assert!(greatest("taken_s") < f64::from(interval_s));
    });
}

/// How late a thread is that only waits for its next cycle, ms: the machine's own delay.
fn machine_is_late(is_over: &AtomicBool) -> f64 {
    let (mut next, mut late) = (Instant::now(), 0.0_f64);
    while !is_over.load(Ordering::Relaxed) {
        next += Duration::from_millis(100);
        thread::sleep(next.saturating_duration_since(Instant::now()));
        late = late.max(1000.0 * next.elapsed().as_secs_f64());
    }
    late
}

/// Sends what somebody without the key can: `count` datagrams, some recorded ones among them, within a time.
fn flood(robot: &Robot, recorded: &[Vec<u8>], count: u32, time: Duration) {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let begun = Instant::now();
    for number in 0..count {
        let old = &recorded[number as usize % recorded.len()];
        let datagram = match number % 7 {
            // Sent again; damaged; cut; of another version, kind, sender and experiment.
            0 => old.clone(),
            1 => changed(old, old.len() - 1, number),
            2 => old[..old.len() / 2].to_vec(),
            3 => changed(old, 4, number),
            4 => changed(old, 6 + number as usize % 3, number),
            5 => changed(old, 9, number),
            // A number that was never used: it is authenticated, and forged.
            _ => changed(&changed(old, 20, number), 17, number >> 8),
        };
        let _ = socket.send_to(&datagram, ("127.0.0.1", robot.radio));
        if number % 64 == 0 {
            pace(begun, time, f64::from(number) / f64::from(count));
        }
    }
}

fn changed(datagram: &[u8], at: usize, by: u32) -> Vec<u8> {
    let mut datagram = datagram.to_vec();
    datagram[at] ^= 1 | by as u8;
    datagram
}

/// Waits until a part of a time is over.
fn pace(begun: Instant, time: Duration, part: f64) {
    thread::sleep(time.mul_f64(part).saturating_sub(begun.elapsed()));
}

/// Sends `count` lines in the tracker's place that can't be true, within a time.
fn lie(robot: &Robot, count: u32, time: Duration) {
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let begun = Instant::now();
    let heard: Vec<u32> = (0..500).collect();
    for number in 0..count {
        let t = 1e6 + f64::from(number);
        let line = |x: f64, brought: u64| json!({ "id": 0, "t": t, "x": x, "y": 500, "heading": 0.25, "carries": true, "brought": brought, "heard": [] });
        let text = match number % 6 {
            0 => line(200.0, u32::MAX.into()).to_string(),
            1 => line(200.0, 1_000_000).to_string(),
            2 => line(99_000.0, 0).to_string(),
            3 => line(1e308, u64::MAX).to_string(),
            4 => json!({ "id": 0, "t": t, "x": 200, "y": 500, "heading": 0.25, "heard": heard }).to_string() + "]",
            _ => "[".repeat(2000),
        };
        let _ = socket.send_to(text.as_bytes(), ("127.0.0.1", robot.tracker));
        if number % 16 == 0 {
            pace(begun, time, f64::from(number) / f64::from(count));
        }
    }
}

/// A hundred thousand hostile datagrams and ten thousand lines of a lying tracker, with `ONEIRO_LONG` ten times as many: no cycle begins
/// late by more than 50 ms and the machine's own delay, nothing is earned, and all is counted.
#[test]
fn a_flood_does_not_hold_a_daemon_up() {
    let is_long = std::env::var_os("ONEIRO_LONG").is_some();
    let (datagrams, lines, seconds) = if is_long {
        (1_000_000, 100_000, 100)
    } else {
        (100_000, 10_000, 20)
    };
    let (place, interval_s) = (Place::new("fleet-flood"), 10);
    let recorder = UdpSocket::bind("127.0.0.1:0").unwrap();
    recorder.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    let fleet = deployed(&place, 2, interval_s, &[recorder.local_addr().unwrap().port()]);
    let is_over = AtomicBool::new(false);
    thread::scope(|scope| {
        scope.spawn(|| track(&fleet, &is_over));
        let machine = scope.spawn(|| machine_is_late(&is_over));
        let mut operator = Operator::start(&place, &is_over);
        wait("driving", Duration::from_mins(1), || {
            thread::sleep(Duration::from_millis(50));
            fleet.iter().all(|robot| !robot.body.stands())
        });
        let recorded: Vec<Vec<u8>> = (0..16)
            .map(|_| {
                let mut room = [0; 2048];
                let length = recorder.recv(&mut room).unwrap();
                room[..length].to_vec()
            })
            .collect();
        let robot = &fleet[0];
        let before = events(robot, "late").len();
        let time = Duration::from_secs(seconds);
        thread::scope(|scope| {
            scope.spawn(|| flood(robot, &recorded, datagrams, time));
            scope.spawn(|| lie(robot, lines, time));
        });
        wait("the end of an interval", Duration::from_mins(1), || {
            thread::sleep(Duration::from_millis(100));
            events(robot, "late").len() > before + seconds as usize / interval_s as usize
        });
        // It lives on.
        wait("driving again", Duration::from_secs(20), || !robot.body.stands());
        operator.end();
        let machine = machine.join().unwrap();
        let begins = events(robot, "late")
            .iter()
            .map(|late| number(late, "begins_ms"))
            .fold(0.0, f64::max);
        let losses = events(robot, "losses").pop().unwrap();
        eprintln!(
            "{datagrams} datagrams and {lines} lines in {seconds} s: cycles began late by {begins:.1} ms at most, a thread that waits by {machine:.1} ms; {losses}"
        );
        assert!(begins <= 50.0 + machine, "{begins} ms, {machine} ms");
        for reason in ["forged", "replayed", "other_version", "other_experiment", "not_ours"] {
            assert!(number(&losses, reason) > f64::from(datagrams / 1000), "{losses}");
        }
        for reason in ["tracker_impossible", "tracker_unreadable"] {
            assert!(number(&losses, reason) > f64::from(lines / 100), "{losses}");
        }
        for interval in events(robot, "interval") {
            assert_eq!(
                (number(&interval, "real"), number(&interval, "brought")),
                (0.0, 0.0),
                "{interval}"
            );
        }
    });
}

/// Somebody has recorded all datagrams of one start, and sends them at the next one, when no robot is there: none lives, no beacon goes
/// out, and the experiment's clock stands.
#[test]
fn what_was_recorded_at_one_start_does_nothing_at_the_next() {
    let place = Place::new("fleet-replayed");
    let recorder = UdpSocket::bind("127.0.0.1:0").unwrap();
    recorder.set_read_timeout(Some(Duration::from_millis(200))).unwrap();
    let fleet = deployed(&place, 2, 10, &[recorder.local_addr().unwrap().port()]);
    let is_over = AtomicBool::new(false);
    let mut recorded = Vec::new();
    thread::scope(|scope| {
        scope.spawn(|| track(&fleet, &is_over));
        let mut operator = Operator::start(&place, &is_over);
        let begun = Instant::now();
        let mut drives = None;
        while drives.is_none_or(|at: Instant| at.elapsed() < Duration::from_secs(5)) {
            assert!(begun.elapsed() < Duration::from_mins(1), "robots did not drive");
            let mut room = [0; 2048];
            if let Ok(length) = recorder.recv(&mut room) {
                recorded.push(room[..length].to_vec());
            }
            if drives.is_none() && fleet.iter().all(|robot| !robot.body.stands()) {
                drives = Some(Instant::now());
            }
        }
        operator.end();
    });
    // All that robots say, statuses among it, and none of it is cut.
    assert!(recorded.len() > 20, "{}", recorded.len());
    let time = || serde_json::from_str::<Value>(&place.text("fleet/operator.json")).unwrap()["milliseconds"].as_i64();
    let before = time();

    // Their computers start nothing that speaks, and what listens in their places hears the operator.
    for robot in &fleet {
        robot.runs("while :; do sleep 0.2; done\n");
    }
    let ears: Vec<UdpSocket> = fleet
        .iter()
        .map(|robot| UdpSocket::bind(("127.0.0.1", robot.radio)).unwrap())
        .collect();
    let mut start = place.command(&["fleet", "start", "fleet.toml", "--wait", "6s", "--json"]);
    let program = start.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let (is_over, operator) = (AtomicBool::new(false), operator_of(&place));
    let ran = thread::scope(|scope| {
        scope.spawn(|| {
            let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
            while !is_over.load(Ordering::Relaxed) {
                for datagram in &recorded {
                    let _ = socket.send_to(datagram, ("127.0.0.1", operator));
                }
                thread::sleep(Duration::from_millis(50));
            }
        });
        let ran = Ran::ended(&["fleet", "start"], program);
        is_over.store(true, Ordering::Relaxed);
        ran
    });
    let ran = ran.exits(4).says(&["0 robots are ready, and 2 are needed"]);
    let mut counted = 0;
    for line in ran.stdout.lines() {
        let line: Value = serde_json::from_str(line).unwrap();
        assert_eq!(line["milliseconds"], Value::Null, "{line}");
        for robot in line["robots"].as_array().unwrap() {
            assert_eq!(
                (&robot["state"], &robot["status"]),
                (&json!("silent"), &Value::Null),
                "{line}"
            );
        }
        counted = line["refused"]
            .as_object()
            .unwrap()
            .values()
            .filter_map(Value::as_u64)
            .sum();
    }
    assert!(counted > 100, "{counted}");
    assert_eq!(time(), before);
    for socket in &ears {
        socket.set_read_timeout(Some(Duration::from_millis(100))).unwrap();
        let (mut room, mut heard) = ([0; 2048], 0);
        while let Ok(length) = socket.recv(&mut room) {
            heard += 1;
            // A call: its header, a number, and its tag. A beacon has nine bytes more.
            assert_eq!((room[6], length), (5, 25 + 8 + 16));
        }
        assert!(heard > 10, "{heard}");
    }
    place.run(&["fleet", "stop", "fleet.toml"]);
}

/// What the operator's machine can check, `fleet start` checks before it starts a daemon, which would connect to its robot.
#[test]
fn what_can_not_be_started_starts_no_daemon() {
    let place = Place::new("fleet-unstarted");
    let fleet = deployed(&place, 2, 10, &[]);
    let wheels = fleet.iter().map(|robot| robot.body.wheels().0).collect::<Vec<_>>();
    let is_untouched = |what: &str| {
        for (robot, before) in fleet.iter().zip(&wheels) {
            assert!(
                !robot.home.join("pid").exists() && robot.body.wheels().0 == *before,
                "{what}"
            );
        }
    };
    let start = ["fleet", "start", "fleet.toml"];
    let mode = |mode| fs::set_permissions(place.at("experiment.key"), fs::Permissions::from_mode(mode)).unwrap();
    for public in [0o644, 0o640, 0o606] {
        mode(public);
        let chmod = ["others than its owner can use this key", "chmod 600"];
        for arguments in [
            &start[..],
            &["fleet", "deploy", "fleet.toml"],
            &["fleet", "plan", "fleet.toml"],
            &["fleet", "status", "fleet.toml", "--listen", "1s"],
            &["fleet", "twin", "fleet.toml", "--out", "twin"],
        ] {
            place.run(arguments).exits(3).says(&chmod);
            is_untouched(&format!("{arguments:?}"));
        }
    }
    mode(0o600);
    let other = UdpSocket::bind(("127.0.0.1", operator_of(&place))).unwrap();
    place.run(&start).exits(4).says(&["can't listen at port"]);
    is_untouched("a port that is taken");
    drop(other);
    assert!(!place.at("fleet").exists());
    fs::create_dir(place.at("fleet")).unwrap();
    place.write("fleet/operator.json", "{");
    place.run(&start).exits(5).says(&["operator.json"]);
    is_untouched("a damaged record");
    fs::remove_file(place.at("fleet/operator.json")).unwrap();
    place.write("fleet/statuses.csv", "no table\nat all\n");
    place.run(&start).exits(5).says(&["statuses.csv"]);
    is_untouched("a damaged table");
}
