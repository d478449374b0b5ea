//! `oneiro robot` and the guard against robots that others wrote: a Thymio II and an e-puck of Aseba's simulator. Whether and
//! how far a robot moves is told by another robot of the simulator, which it drives towards.
#![cfg(target_os = "linux")]

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::net::{TcpStream, UdpSocket};
use std::os::unix::process::CommandExt;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicI16, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

#[cfg(feature = "compose")]
mod on_board;
use crate::aseba::client::Client;
use crate::aseba::{FIRST_PORT, Pair, SWITCH, Switch, driven, in_a_network, live, pairs, pause, witness, world};
use crate::place::Place;

/// From an event to wheels that stand.
const LIMIT: Duration = Duration::from_millis(500);
/// For what has no limit but must happen.
const LONG: Duration = Duration::from_secs(20);
/// Readings of a robot that stands differ by less, and those of one that comes nearer at 80 mm/s by more, from one step of
/// the simulator to the next.
const NOISE: i16 = 25;

/// A file that drives straight on at 80 mm/s.
const STRAIGHT: &str = "straight.txt";
/// A reading of the witness that a robot has nearly touched it.
const CONTACT: i16 = 4000;

/// Variables of a kind of robot: its targets, and its sensors of proximity.
fn variables(kind: &str) -> ([&'static str; 2], &'static str) {
    match kind {
        "thymio2" => (["motor.left.target", "motor.right.target"], "prox.horizontal"),
        _ => (["speed.left", "speed.right"], "prox"),
    }
}

fn address(port: u16) -> String {
    format!("aseba:127.0.0.1:{port}")
}

fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// How near the driven robot is, as its witness sees it straight ahead: 0 for far, 4500 for contact.
fn nearness(client: &mut Client) -> i16 {
    client.get("prox.horizontal")[2]
}

/// A witness that looks as often as the simulator answers.
struct Witness {
    is_over: Arc<AtomicBool>,
    seen: JoinHandle<Vec<(Instant, i16)>>,
    newest: Arc<AtomicI16>,
}

impl Witness {
    fn start(port: u16) -> Self {
        let (is_over, newest) = (Arc::<AtomicBool>::default(), Arc::<AtomicI16>::default());
        let (end, shown) = (Arc::clone(&is_over), Arc::clone(&newest));
        let seen = thread::spawn(move || {
            let (mut client, mut seen) = (Client::connect(port), Vec::new());
            while !end.load(Ordering::SeqCst) {
                let value = nearness(&mut client);
                shown.store(value, Ordering::SeqCst);
                seen.push((Instant::now(), value));
            }
            seen
        });
        Self { is_over, seen, newest }
    }

    /// Waits until the driven robot is this near.
    #[track_caller]
    fn wait_for(&self, nearness: i16) {
        let start = Instant::now();
        while self.newest.load(Ordering::SeqCst) < nearness {
            assert!(start.elapsed() < LONG, "the robot does not come near");
            thread::sleep(Duration::from_millis(1));
        }
    }

    /// All that was seen.
    fn end(self) -> Vec<(Instant, i16)> {
        self.is_over.store(true, Ordering::SeqCst);
        self.seen.join().unwrap()
    }
}

/// When the robot stood, of what was seen: at the first reading after the last one that differs from where it stands at the
/// end.
fn stood(seen: &[(Instant, i16)]) -> Instant {
    let last = seen.last().unwrap().1;
    let moving = seen
        .iter()
        .rposition(|(_, value)| (value - last).abs() > NOISE)
        .unwrap();
    seen[moving + 1].0
}

fn signal(name: &str, id: &str) {
    let status = Command::new("kill").args([name, "--", id]).status().unwrap();
    assert!(status.success(), "kill {name} {id}");
}

/// A program that drives a robot straight on: `oneiro robot drive` with a file.
fn drive(place: &Place, port: u16, more: &[&str]) -> Child {
    let address = address(port);
    let own = ["robot", "drive", &address, "--commands", STRAIGHT];
    let mut command = place.command(&[&own, more].concat());
    let command = command.stdout(Stdio::null()).stderr(Stdio::piped()).process_group(0);
    command.spawn().unwrap()
}

/// What drives a robot straight on.
enum Driver {
    Drive(Child),
    /// The guard itself, with commands from here.
    Guard(Child, Arc<Mutex<ChildStdin>>),
}

impl Driver {
    fn guard(place: &Place, port: u16) -> Self {
        let mut command = place.command(&["guard", &address(port)]);
        let mut guard = command.stdin(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
        let requests = Arc::new(Mutex::new(guard.stdin.take().unwrap()));
        let commands = Arc::downgrade(&requests);
        thread::spawn(move || {
            let say = |line: &str| {
                // Until the driver ends, or the guard.
                let requests = commands.upgrade();
                requests.is_some_and(|requests| writeln!(requests.lock().unwrap(), "{line}").is_ok())
            };
            say(r#"{"hello":{"version":1}}"#);
            let commands = (1..).map(|sequence| json!({"sequence": sequence, "left_mm_s": 80.0, "right_mm_s": 80.0}));
            for command in commands {
                if !say(&json!({ "command": command }).to_string()) {
                    return;
                }
                thread::sleep(Duration::from_millis(20));
            }
        });
        Self::Guard(guard, requests)
    }

    fn process(&self) -> &Child {
        match self {
            Self::Drive(process) | Self::Guard(process, _) => process,
        }
    }

    /// Says something to the guard, between commands.
    fn say(&self, line: &str) {
        if let Self::Guard(_, requests) = self {
            writeln!(requests.lock().unwrap(), "{line}").unwrap();
        }
    }

    /// Ends it, or waits for its end.
    fn end(self) {
        let mut process = match self {
            Self::Drive(process) => process,
            Self::Guard(process, requests) => {
                drop(requests);
                process
            }
        };
        process.wait().unwrap();
    }
}

/// The process of a program's guard.
fn guard(program: &Child) -> String {
    let list = Command::new("ps")
        .args(["-o", "pid=", "--ppid", &program.id().to_string()])
        .output()
        .unwrap();
    String::from_utf8(list.stdout).unwrap().trim().to_owned()
}

/// What is there, what it senses, where it drives to, and that it stops: each compared with what a client of our own hears
/// from the simulator.
#[test]
fn robots_are_found_watched_driven_and_stopped() {
    if !in_a_network(
        "robots_are_found_watched_driven_and_stopped",
        "robots of Aseba's simulator",
    ) {
        return;
    }
    let kinds = [("thymio2", "Thymio II", 80.0), ("e-puck", "e-puck (Aseba)", 37.0)];
    // The first pair of a kind drives 52 mm nearer, 10 mm more or less: between the distances that the others show.
    let distances = |(kind, _, half)| {
        let start = 80.0 + half + 110.0;
        [start, start - 42.0, start - 62.0].map(|distance| Pair { kind, distance })
    };
    live(&pairs(&kinds.map(distances).concat()), 12, 1, |playground| {
        thread::scope(|scope| {
            for (index, (kind, robot, _)) in kinds.into_iter().enumerate() {
                scope.spawn(move || obeys(&playground.place, kind, robot, 3 * index));
            }
        });
    });
}

/// Goes through all commands with a robot: the driven one of the first of three pairs.
fn obeys(place: &Place, kind: &str, robot: &str, first: usize) {
    let address = address(driven(first));
    let told: Value = serde_json::from_str(&place.good(&["robot", "ping", &address, "--json"])).unwrap();
    assert_eq!(told["robot"], robot);
    let median = told["round_trip"]["median_ms"].as_f64().unwrap();
    assert!(median < 40.0, "{told}");
    pause();

    let watch = [
        "robot",
        "watch",
        &address,
        "--json",
        "--cycles",
        "5",
        "--kinds",
        "proximity",
    ];
    let readings = lines(&place.good(&watch));
    assert_eq!(readings.len(), 5);
    pause();
    let own = Client::connect(driven(first)).get(variables(kind).1);
    let mut felt = 0;
    for reading in readings {
        let values = reading["values"].as_object().unwrap();
        assert_eq!(values.len(), own.len());
        for (sensor, own) in own.iter().enumerate() {
            let value = values[&format!("prox_{sensor}")].as_i64().unwrap() as i16;
            assert!((value - own).abs() <= 3 * NOISE, "{kind} prox_{sensor}: {value} {own}");
            felt += u32::from(value > 500);
        }
    }
    // An e-puck sees less far.
    assert!(kind != "thymio2" || felt >= 5, "nothing is near");
    pause();

    let before = nearness(&mut Client::connect(witness(first)));
    let nearer = format!("{kind}.txt");
    // Slowly: the simulator does not catch up on time that a busy machine has lost.
    place.write(&nearer, "2.8 18.75 18.75\n");
    place.good(&["robot", "drive", &address, "--commands", &nearer]);
    pause();
    let [near, least, greatest] = [0, 1, 2].map(|pair| nearness(&mut Client::connect(witness(first + pair))));
    eprintln!("{kind}: {before}, then {near}, of {least} to {greatest}; median round trip {median} ms");
    assert!(
        before < least && (least..=greatest).contains(&near),
        "{kind}: {before} {near} {least} {greatest}"
    );
    pause();

    // It goes on without any client.
    let (targets, _) = variables(kind);
    let mut client = Client::connect(driven(first));
    for (target, speed) in targets.into_iter().zip([-60, -60]) {
        client.set(target, &[speed]);
    }
    // It has heard it all before the end.
    client.get(targets[0]);
    drop(client);
    pause();
    let before = nearness(&mut Client::connect(witness(first)));
    assert!(before < near - 2 * NOISE, "{kind}: {near} {before}");
    place.run(&["robot", "stop", &address]).exits(0);
    pause();
    let mut client = Client::connect(driven(first));
    assert_eq!(targets.map(|target| client.get(target)[0]), [0, 0]);
    let mut witness = Client::connect(witness(first));
    let stands = nearness(&mut witness);
    thread::sleep(LIMIT);
    assert!((nearness(&mut witness) - stands).abs() <= NOISE, "{kind}");
}

/// What happens to the program that drives, to its guard, or to the link.
const EVENTS: [&str; 7] = [
    "kill -9 of the program",
    "SIGSTOP of the program",
    "Ctrl-C",
    "SIGTERM of the guard",
    "another client",
    "operator",
    "messages",
];

/// Whatever happens to the program that drives, the robot stands in time.
#[test]
fn the_wheels_stand_in_time_in_the_simulator() {
    if !in_a_network(
        "the_wheels_stand_in_time_in_the_simulator",
        "the guard of robots of Aseba's simulator",
    ) {
        return;
    }
    let kinds = ["thymio2", "e-puck"];
    let cases: Vec<_> = kinds
        .into_iter()
        .flat_map(|kind| EVENTS.map(|event| (kind, event)))
        .collect();
    let world: Vec<Pair> = cases.iter().map(|(kind, _)| Pair { kind, distance: 380.0 }).collect();
    live(&pairs(&world), 2 * cases.len() as u16, 1, |playground| {
        playground.place.write(STRAIGHT, "60 80 80\n");
        // All at once, each with a pair of robots.
        thread::scope(|scope| {
            for (pair, (kind, event)) in cases.iter().enumerate() {
                scope.spawn(move || stops(&playground.place, pair, kind, event));
            }
        });
    });
}

fn stops(place: &Place, pair: usize, kind: &str, what: &str) {
    let port = driven(pair);
    let witness = Witness::start(witness(pair));
    let driver = match what {
        "operator" | "messages" => Driver::guard(place, port),
        _ => Driver::Drive(drive(place, port, &[])),
    };
    witness.wait_for(1300);
    let id = driver.process().id().to_string();
    let mut intruder = None;
    let event = Instant::now();
    match what {
        "kill -9 of the program" => signal("-KILL", &id),
        "SIGSTOP of the program" => signal("-STOP", &id),
        "Ctrl-C" => signal("-INT", &format!("-{id}")),
        "SIGTERM of the guard" => signal("-TERM", &guard(driver.process())),
        // The simulator hangs up on the guard, which comes back.
        "another client" => intruder = Some(TcpStream::connect(("127.0.0.1", port)).unwrap()),
        "operator" => driver.say("\"stop\""),
        _ => (0..3).for_each(|_| driver.say("{\"command\":{")),
    }
    if intruder.is_some() {
        // A program that goes on would drive again once the link is back.
        signal("-KILL", &id);
    }
    thread::sleep(Duration::from_millis(1200));
    let seen = witness.end();
    let took = stood(&seen).saturating_duration_since(event);
    eprintln!(
        "{kind}, {what}: {} ms, from 1300 to {}",
        took.as_millis(),
        seen.last().unwrap().1
    );
    assert!(took <= LIMIT, "{kind}, {what}: {took:?}");
    assert!(seen.last().unwrap().1 < CONTACT, "{kind}, {what}");
    if what == "SIGSTOP of the program" {
        signal("-KILL", &id);
    }
    driver.end();
}

/// Drives a robot, and kills its guard while the program that drives hangs. Returns the time until it stood, if it did within
/// 1.2 s, and lets it go on until it touches the witness if it did not.
fn without_guard(place: &Place, pair: usize, more: &[&str]) -> Option<Duration> {
    let witness = Witness::start(witness(pair));
    let mut program = drive(place, driven(pair), more);
    witness.wait_for(1300);
    signal("-STOP", &program.id().to_string());
    signal("-KILL", &guard(&program));
    let event = Instant::now();
    thread::sleep(Duration::from_millis(1200));
    let stands = witness.newest.load(Ordering::SeqCst) < CONTACT;
    if !stands {
        witness.wait_for(CONTACT);
    }
    program.kill().unwrap();
    program.wait().unwrap();
    let seen = witness.end();
    stands.then(|| stood(&seen).duration_since(event))
}

/// What remains: without its guard a robot drives on, until it touches the witness. This shows that the test above can fail. A
/// Thymio II has a program of its own that stops it, unless it was not given one.
#[test]
fn without_the_guard_only_a_thymio_stops_in_the_simulator() {
    if !in_a_network(
        "without_the_guard_only_a_thymio_stops_in_the_simulator",
        "robots of Aseba's simulator without a guard",
    ) {
        return;
    }
    let thymio = |distance| Pair {
        kind: "thymio2",
        distance,
    };
    live(&pairs(&[thymio(380.0), thymio(340.0)]), 4, 1, |playground| {
        playground.place.write(STRAIGHT, "60 80 80\n");
        let stood = without_guard(&playground.place, 0, &[]).expect("it stops by itself");
        eprintln!("thymio2, the guard and the program gone: {} ms", stood.as_millis());
        // Ten events of its own, and a step of the simulator before and after them.
        assert!(stood < Duration::from_millis(650), "{stood:?}");
        assert_eq!(without_guard(&playground.place, 1, &["--guard", "fuse=0"]), None);
    });
}

/// Simulators that are faster than real time: readings keep coming, and so do the robots.
#[test]
fn a_faster_simulator_is_driven_too() {
    if !in_a_network(
        "a_faster_simulator_is_driven_too",
        "Aseba's simulator, faster than real time",
    ) {
        return;
    }
    for (speed, fastest) in [(1, 40.0), (10, 10.0), (100, 10.0)] {
        // 0.5 s at 60 mm/s, on the simulator's clock.
        let pair = Pair {
            kind: "thymio2",
            distance: 290.0,
        };
        live(&pairs(&[pair]), 2, speed, |playground| {
            let (place, address) = (&playground.place, address(driven(0)));
            let told: Value = serde_json::from_str(&place.good(&["robot", "ping", &address, "--json"])).unwrap();
            let median = told["round_trip"]["median_ms"].as_f64().unwrap();
            assert!(median < fastest, "x{speed}: {median} ms");
            pause();
            let mut witness = Client::connect(witness(0));
            let before = nearness(&mut witness);
            place.write("nearer.txt", format!("0.5 {0} {0}\n", 60.0 / f64::from(speed)));
            // The robot's own program would stop it after 0.5 s of the simulator's clock.
            place.good(&[
                "robot",
                "drive",
                &address,
                "--commands",
                "nearer.txt",
                "--guard",
                "fuse=0",
            ]);
            let after = nearness(&mut witness);
            eprintln!("x{speed}: median round trip {median} ms, from {before} to {after}");
            assert!(
                after > before + 8 * NOISE && after < CONTACT,
                "x{speed}: {before} {after}"
            );
        });
    }
}

/// Two robots behind a switch, which passes on what each says to all.
#[test]
fn robots_behind_a_switch_are_told_apart() {
    if !in_a_network("robots_behind_a_switch_are_told_apart", "robots behind asebaswitch") {
        return;
    }
    let world = ["thymio2", "e-puck"].map(|kind| Pair { kind, distance: 290.0 });
    live(&pairs(&world), 4, 1, |playground| {
        let targets = [0, 1].map(|pair| format!("tcp:localhost;{}", driven(pair)));
        let (place, _switch) = (&playground.place, Switch::start(&targets));
        let address = format!("aseba:127.0.0.1:{SWITCH}");
        let ran = place.run(&["robot", "ping", &address]).exits(4);
        ran.says(&["has several robots", "#1 (thymio-II), #3 (e-puck2)"]);
        for (node, robot) in [(1, "Thymio II"), (3, "e-puck (Aseba)")] {
            let told = place.good(&["robot", "ping", &format!("{address}#{node}"), "--json"]);
            assert_eq!(serde_json::from_str::<Value>(&told).unwrap()["robot"], robot);
        }
        let mut witnesses = [0, 1].map(|pair| Client::connect(witness(pair)));
        let before = witnesses.each_mut().map(nearness);
        place.write("nearer.txt", "0.5 60 60\n");
        place.good(&["robot", "drive", &format!("{address}#1"), "--commands", "nearer.txt"]);
        let after = witnesses.each_mut().map(nearness);
        assert!(after[0] > before[0] + 8 * NOISE, "{before:?} {after:?}");
        assert!((after[1] - before[1]).abs() <= NOISE, "{before:?} {after:?}");
        place.good(&["robot", "stop", &format!("{address}#3")]);
    });
}

/// The experiment of `tests/transfer`, whose last generation lives on a Thymio II of the simulator. Nothing there tells where a robot is,
/// and the task does not ask: a tracker that always sees it at its start will do.
#[test]
fn a_runs_last_generation_lives_in_the_simulator() {
    const TRACKER: &str = "127.0.0.1:5005";
    const LIVES: usize = 4;
    if !in_a_network(
        "a_runs_last_generation_lives_in_the_simulator",
        "a run whose reality is Aseba's simulator",
    ) {
        return;
    }
    // In front of a cylinder that it sees.
    let things = r#"<robot type="thymio2" x="35" y="50" angle="0" port="33333" name="r1" nodeId="1"/>
<cylinder x="53" y="50" r="4" h="10" color="white"/>
"#;
    live(&world(100.0, 100.0, things), 1, 1, |playground| {
        let place = &playground.place;
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/transfer");
        for file in ["thymio.toml", "wall.sam", "round.sam"] {
            place.write(file, fs::read(folder.join(file)).unwrap());
        }
        let robot = address(FIRST_PORT);
        let set = [
            format!("reality.robot=\"{robot}\""),
            format!("reality.tracker=\"udp:{TRACKER}\""),
            "reality.generations=1".to_owned(),
            "reality.walk_s=0".to_owned(),
            "evolution.generations=3".to_owned(),
            format!("evolution.population={LIVES}"),
            "evolution.parents=2".to_owned(),
            "cycles=20".to_owned(),
        ];
        let mut arguments = vec!["run", "thymio.toml", "--out", "run", "--seed", "1", "--backend", "cpu"];
        arguments.extend(set.iter().flat_map(|value| ["--set", value]));
        let is_over = AtomicBool::new(false);
        thread::scope(|scope| {
            scope.spawn(|| {
                let (socket, begun) = (UdpSocket::bind("127.0.0.1:0").unwrap(), Instant::now());
                while !is_over.load(Ordering::SeqCst) {
                    let pose =
                        json!({"id": 0, "t": begun.elapsed().as_secs_f64(), "x": 350.0, "y": 500.0, "heading": 0.0});
                    // Nobody listens before and after the lives.
                    let _ = socket.send_to(format!("{pose}\n").as_bytes(), TRACKER);
                    thread::sleep(Duration::from_millis(50));
                }
            });
            let ran = catch_unwind(AssertUnwindSafe(|| place.good(&arguments)));
            is_over.store(true, Ordering::SeqCst);
            ran.unwrap_or_else(|failure| resume_unwind(failure));
        });
        let table = |name: &str| -> Vec<BTreeMap<String, String>> {
            let mut reader = csv::Reader::from_path(place.at("run").join(name)).unwrap();
            reader.deserialize().map(Result::unwrap).collect()
        };
        // A busy machine cuts lives short, which live again.
        let lives = table("lives/lives.csv");
        let lived: Vec<_> = lives.iter().filter(|life| life["status"] == "complete").collect();
        assert_eq!(lived.len(), LIVES);
        assert!(
            lived
                .iter()
                .all(|life| life["robot"] == robot && life["cycles"] == "20")
        );
        // The last generation's fitness is theirs, and not that of the simulator that was made from samples.
        let fitness = lived.iter().map(|life| life["fitness"].parse::<f32>().unwrap());
        let generations = table("generations.csv");
        assert_eq!(generations.len(), 3);
        let best: f32 = generations[2]["best"].parse().unwrap();
        assert_eq!(best, fitness.fold(f32::NEG_INFINITY, f32::max));
        // It saw the cylinder before the first life moved it.
        let first = table(&format!("lives/life-{}.csv", lived[0]["life"]));
        let seen: f64 = first[0]["raw_prox_2"].parse().unwrap();
        assert!(seen > 500.0, "{seen}");
    });
}
