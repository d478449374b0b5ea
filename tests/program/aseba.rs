//! Aseba's simulator `asebaplayground`, in a network namespace of its own since it listens on all addresses.

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::fs::{self, DirBuilder};
use std::os::unix::fs::DirBuilderExt;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use std::{env, thread};

use crate::place::Place;
use crate::skips::skipped;

pub(crate) mod client;
pub(crate) mod crowd;

/// Set for a test that runs in its namespace.
const INSIDE: &str = "ONEIRO_TEST_NETWORK";
/// It may crash when a client connects within a second of the last one's end.
const PAUSE: Duration = Duration::from_millis(1200);
const START: Duration = Duration::from_secs(20);
pub(crate) const FIRST_PORT: u16 = 33333;

/// Runs the calling test, of the calling file, again in a network namespace that has nothing but the loopback device. Returns whether
/// this is that run.
#[track_caller]
pub(crate) fn in_a_network(test: &str, untested: &str) -> bool {
    if env::var_os(INSIDE).is_some() {
        return true;
    }
    let tools = ["asebaplayground", "asebaswitch", "faketime", "unshare", "ip"];
    let is_there = |tool: &&str| env::split_paths(&env::var_os("PATH").unwrap()).any(|path| path.join(tool).exists());
    let shell = |flags: &str, command: &str| {
        let script = format!("ip link set lo up && exec {command}");
        let mut shell = Command::new("unshare");
        shell.args([flags, "sh", "-c", &script]);
        shell
    };
    // Root needs no namespace of users, which it may not have in a container.
    let flags = ["-n", "-rn"].into_iter().find(|flags| {
        let tried = shell(flags, "true").stderr(Stdio::null()).status();
        tried.is_ok_and(|status| status.success())
    });
    let Some(flags) = flags.filter(|_| tools.iter().all(is_there)) else {
        skipped("playground", untested);
        return false;
    };
    let file = Path::new(std::panic::Location::caller().file()).with_extension("");
    let folders = file.iter().map(|name| name.to_str().unwrap()).rev();
    let mut path: Vec<&str> = folders.take_while(|name| *name != "program").collect();
    path.reverse();
    let test = [&path[..], &[test]].concat().join("::");
    // Also if the program was built again since.
    let program = format!("/proc/{}/exe", std::process::id());
    let command = format!("'{program}' --exact --nocapture --include-ignored {test}");
    let run = shell(flags, &command)
        .env(INSIDE, "1")
        .stderr(Stdio::inherit())
        .output()
        .unwrap();
    let output = String::from_utf8_lossy(&run.stdout);
    print!("{output}");
    // A name that no test has is no failure there.
    assert!(output.contains("test result: ok. 1 passed"), "{test}: {}", run.status);
    false
}

/// A robot that drives, and a Thymio II that sees how near it is.
#[derive(Clone, Copy)]
pub(crate) struct Pair {
    /// `thymio2` or `e-puck`.
    pub(crate) kind: &'static str,
    /// Distance between the middles of their axles, mm.
    pub(crate) distance: f64,
}

/// Pairs in rows that don't see each other. The driven robot of pair `i` has port 33333 + 2 `i`; its witness, which it
/// faces, has the next one. Nodes are numbered from 1.
pub(crate) fn pairs(pairs: &[Pair]) -> String {
    let mut robots = String::new();
    for (row, pair) in pairs.iter().enumerate() {
        let y = 30.0 + 60.0 * row as f64;
        let places = [(pair.kind, 30.0, 0.0), ("thymio2", 30.0 + pair.distance / 10.0, PI)];
        for (column, (kind, x, angle)) in places.into_iter().enumerate() {
            let index = 2 * row + column;
            let (port, node) = (FIRST_PORT + index as u16, index + 1);
            writeln!(
                robots,
                r#"<robot type="{kind}" x="{x}" y="{y}" angle="{angle}" port="{port}" name="r{node}" nodeId="{node}"/>"#
            )
            .unwrap();
        }
    }
    world(120.0, 60.0 * pairs.len() as f64, &robots)
}

/// A world of this size in cm, inside a wall.
pub(crate) fn world(width: f64, height: f64, things: &str) -> String {
    format!(
        r#"<!DOCTYPE aseba-playground>
<aseba-playground>
<color name="white" r="1" g="1" b="1"/>
<world w="{width}" h="{height}" color="white"/>
{things}</aseba-playground>
"#
    )
}

/// The port of a pair's driven robot.
pub(crate) fn driven(pair: usize) -> u16 {
    FIRST_PORT + 2 * pair as u16
}

/// That of its witness.
pub(crate) fn witness(pair: usize) -> u16 {
    driven(pair) + 1
}

/// Waits until a robot accepts a client again.
pub(crate) fn pause() {
    thread::sleep(PAUSE);
}

/// A running simulator.
pub(crate) struct Playground {
    process: Child,
    pub(crate) place: Place,
}

impl Playground {
    /// Starts it in a world, this many times as fast as real time, and waits until it listens at its first `robots` ports.
    pub(crate) fn start(world: &str, robots: u16, speed: u32) -> Self {
        let place = Place::new(&format!("playground-{}", world.len()));
        place.write("world.playground", world);
        let (home, runtime) = (place.at("home"), place.at("runtime"));
        for folder in [&home, &runtime] {
            let _ = fs::remove_dir_all(folder);
            DirBuilder::new().mode(0o700).create(folder).unwrap();
        }
        let mut command = Command::new("asebaplayground");
        if speed != 1 {
            // The loader puts the system's folder for libraries in the place of $LIB. Unlike the program faketime, this starts no
            // process in between.
            command.env("LD_PRELOAD", "/usr/$LIB/faketime/libfaketimeMT.so.1");
            command.env("FAKETIME", format!("+0 x{speed}"));
        }
        let process = command
            .arg(place.at("world.playground"))
            .env("QT_QPA_PLATFORM", "offscreen")
            .env("HOME", home)
            .env("XDG_RUNTIME_DIR", runtime)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut playground = Self { process, place };
        let start = Instant::now();
        while !(0..robots).all(|robot| listens(FIRST_PORT + robot)) {
            assert!(
                start.elapsed() < START && !playground.has_crashed(),
                "the playground does not start"
            );
            thread::sleep(Duration::from_millis(5));
        }
        playground
    }

    fn has_crashed(&mut self) -> bool {
        let ended = self.process.try_wait().unwrap();
        ended.is_some_and(|status| !status.success())
    }
}

impl Drop for Playground {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Port of a switch.
pub(crate) const SWITCH: u16 = 33300;

/// A running `asebaswitch`, which joins networks.
pub(crate) struct Switch(Child);

impl Switch {
    pub(crate) fn start(targets: &[String]) -> Self {
        // The switch doesn't send a message until the previous one has been acknowledged, and Linux may hold an acknowledgement back
        // for 40 ms. `quickack` turns that delay off.
        let route = "route replace local 127.0.0.0/8 dev lo table local scope host src 127.0.0.1 quickack 1";
        let routes = [route, &route.replace("127.0.0.0/8", "127.0.0.1")]
            .map(|route| Command::new("ip").args(route.split(' ')).status().unwrap().success());
        assert_eq!(routes, [true; 2]);
        let mut command = Command::new("asebaswitch");
        command.args(["-p", &SWITCH.to_string()]).args(targets);
        let process = command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        let switch = Self(process.unwrap());
        let start = Instant::now();
        while !listens(SWITCH) {
            assert!(start.elapsed() < START, "the switch does not start");
            thread::sleep(Duration::from_millis(5));
        }
        // It connects to its targets after it listens.
        pause();
        switch
    }
}

impl Drop for Switch {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Whether somebody listens at a port of this namespace. A connection would be a client.
fn listens(port: u16) -> bool {
    const LISTEN: &str = "0A";
    let is_port = |line: &str| {
        let fields: Vec<&str> = line.split_whitespace().collect();
        fields[1].ends_with(&format!(":{port:04X}")) && fields[3] == LISTEN
    };
    let table = |name: &str| fs::read_to_string(format!("/proc/net/{name}")).unwrap_or_default();
    (table("tcp") + &table("tcp6"))
        .lines()
        .filter(|line| !line.contains("address"))
        .any(is_port)
}

/// Starts the simulator for a scenario, and returns what that does. If the simulator crashes, which is no failure of ours, the scenario begins anew, three
/// times at most.
pub(crate) fn live<T>(world: &str, robots: u16, speed: u32, scenario: impl Fn(&Playground) -> T) -> T {
    for _ in 0..3 {
        let mut playground = Playground::start(world, robots, speed);
        match catch_unwind(AssertUnwindSafe(|| scenario(&playground))) {
            Ok(outcome) => return outcome,
            Err(_) if playground.has_crashed() => eprintln!("the playground has crashed"),
            Err(failure) => resume_unwind(failure),
        }
    }
    panic!("the playground has crashed three times");
}
