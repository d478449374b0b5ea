//! A fleet in real time: the operator's program and daemons, each with its guard and a scripted e-puck2, all on this machine. How late
//! their cycles are, how long generations on board take, and how much of a processor and of memory that takes. `ONEIRO_ON_BOARD` names
//! another program for the daemons, such as the small one of the profile `robot`.

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

#[path = "peers/mod.rs"]
#[allow(dead_code, reason = "tests of drivers use the rest")]
mod peers;
#[allow(dead_code, reason = "other tests use the rest")]
mod place;
use peers::{Body, EPuck2, wait};
use place::{Place, Ran};

/// A robot, its port for the tracker, and its folder on its computer.
struct Robot {
    body: Body,
    tracker: u16,
    home: PathBuf,
}

fn free_port() -> u16 {
    UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// Deploys a fleet whose computers are folders on this machine.
fn deployed(place: &Place, robots: u32, interval_s: u32) -> Vec<Robot> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap();
    let clock = format!("[swarm]\nclock.interval_s = {interval_s}\nclock.installed_s = {interval_s}\n");
    let text = fs::read_to_string(root.join("experiments/odowd2014-over.toml")).unwrap();
    let text = text.replace("robots = 10", &format!("robots = {robots}"));
    place.write("experiment.toml", text.replace("[swarm]\n", &clock));
    place.good(&["fleet", "key", "experiment.key"]);
    // A shell, which takes `on-board` for a script.
    fs::copy("/bin/sh", place.at("shell")).unwrap();
    let mut file = format!(
        "experiment = \"experiment.toml\"\nseed = 1\nkey = \"experiment.key\"\noperator = \"127.0.0.1:{}\"\nbinary = \"shell\"\n\
         service = \"process\"\n[ssh]\nprogram = \"{}/tests/fleet/ssh\"\noptions = [\"-F\", \"{}\"]\n[tracker]\nlisten = \"127.0.0.1:1\"\n",
        free_port(),
        root.display(),
        place.at("").display(),
    );
    let fleet: Vec<Robot> = (0..robots)
        .map(|number| {
            let (epuck, tracker, radio) = (EPuck2::default(), free_port(), free_port());
            fs::create_dir(place.at(format!("host-{number}"))).unwrap();
            writeln!(
                file,
                "[[robots]]\nnumber = {number}\nhost = \"host-{number}\"\nradio = \"127.0.0.1:{radio}\"\naddress = \"{}\"\n\
                 set.radio.listen = \"127.0.0.1:{radio}\"\nset.tracker.listen = \"127.0.0.1:{tracker}\"",
                epuck.start()
            )
            .unwrap();
            Robot {
                body: epuck.0,
                tracker,
                home: place.at(format!("host-{number}/oneiro/robot-{number}")),
            }
        })
        .collect();
    place.write("fleet.toml", &file);
    place.good(&["fleet", "deploy", "fleet.toml"]);
    for robot in &fleet {
        let program = std::env::var("ONEIRO_ON_BOARD").unwrap_or_else(|_| env!("CARGO_BIN_EXE_oneiro").to_owned());
        let script = format!("exec {program} on-board \"$@\"\n");
        fs::write(robot.home.join("on-board"), script).unwrap();
        fs::set_permissions(robot.home.join("on-board"), fs::Permissions::from_mode(0o755)).unwrap();
    }
    fleet
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
    let fleet = deployed(&place, robots, interval_s);
    let is_over = AtomicBool::new(false);
    thread::scope(|scope| {
        scope.spawn(|| track(&fleet, &is_over));
        // Nobody reads what it says: in a pipe that would hold it up, and robots would stand.
        let mut start = place.command(&["fleet", "start", "fleet.toml"]);
        let program = start.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let mut operator = Operator {
            program: Some(program),
            place: &place,
            is_over: &is_over,
        };
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
