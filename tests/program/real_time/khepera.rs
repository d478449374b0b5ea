//! `oneiro robot` and an emulated Khepera on a pseudo-terminal, in real time: by a description of the protocol that shares
//! nothing with the program.
#![cfg(unix)]

use std::io::{ErrorKind, Read, Write};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread;
use std::time::{Duration, Instant};

use oneiro::arena::Arena;
use serde_json::Value;
use serialport::{SerialPort, TTYPort};

use crate::emulated::surrogate::Simulated;
use crate::emulated::{Body, Firmware, Khepera, Rolling, resampled};
use crate::place::Place;

/// A robot at a port. It hears and is heard only at its own baud rate.
struct Port<B> {
    robot: Arc<Mutex<Khepera<B>>>,
    path: String,
}

impl<B: Body + 'static> Port<B> {
    /// Starts it with turning wheels.
    fn new(body: B, baud: u32) -> Self {
        let (mut port, slave) = TTYPort::pair().unwrap();
        let path = slave.name().unwrap();
        drop(slave);
        port.set_timeout(Duration::from_millis(2)).unwrap();
        let mut robot = Khepera::new(body, Firmware::ALL[0], baud);
        robot.receive(b"D,3,-3\n", Duration::ZERO);
        let robot = Arc::new(Mutex::new(robot));
        let own = Arc::clone(&robot);
        thread::spawn(move || {
            let (start, mut buffer) = (Instant::now(), [0; 256]);
            loop {
                let came = port.read(&mut buffer);
                let rate = port.baud_rate().unwrap();
                let mut robot = own.lock().unwrap();
                let heard = &buffer[..*came.as_ref().unwrap_or(&0)];
                robot.receive(&resampled(heard, rate, baud), start.elapsed());
                let said = robot.send(start.elapsed());
                drop(robot);
                match came {
                    // Nothing is kept for whoever opens the port next.
                    Err(error) if error.kind() != ErrorKind::TimedOut => thread::sleep(Duration::from_millis(2)),
                    _ => port.write_all(&resampled(&said, baud, rate)).unwrap_or_default(),
                }
            }
        });
        Self { robot, path }
    }

    fn address(&self) -> String {
        format!("serial:{}", self.path)
    }

    fn robot(&self) -> MutexGuard<'_, Khepera<B>> {
        self.robot.lock().unwrap()
    }
}

fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Without a baud rate in the address, all are tried; with a wrong one nobody answers.
#[test]
fn ping_finds_it_at_each_baud_rate() {
    thread::scope(|scope| {
        for baud in [9600, 19_200, 38_400, 57_600, 115_200] {
            scope.spawn(move || {
                let place = Place::new(&format!("ping-{baud}"));
                let port = Port::new(Rolling::default(), baud);
                let address = port.address();
                let told: Value = serde_json::from_str(&place.good(&["robot", "ping", &address, "--json"])).unwrap();
                assert_eq!(
                    (&told["robot"], &told["firmware"]),
                    (&"Khepera".into(), &"5.01,5.00".into())
                );
                assert_eq!(port.robot().speeds(), [0, 0], "{baud}");
                // A reading takes its time on the line at least: 2 bytes there and 18 back, without the line feed.
                let least = told["round_trip"]["min_ms"].as_f64().unwrap();
                assert!(least >= 20.0 * 11_000.0 / f64::from(baud), "{told}");

                let wrong = if baud == 9600 { 38_400 } else { 9600 };
                let ran = place.run(&["robot", "ping", &format!("{address}@{wrong}")]).exits(4);
                ran.says(&[&format!("no e-puck, e-puck2 or Khepera answers at {wrong} baud")]);
                place.good(&["robot", "stop", &format!("{address}@{baud}")]);
            });
        }
    });
}

#[test]
fn watch_reads_what_it_senses() {
    let place = Place::new("watch");
    let body = Rolling {
        proximity: [1023, 1, 2, 3, 4, 5, 6, 7],
        light: [50, 51, 52, 53, 54, 55, 56, 500],
        ..Rolling::default()
    };
    let port = Port::new(body, 115_200);
    // As slow to answer as a cable's patience bears.
    port.robot().delay = Duration::from_millis(60);
    let address = format!("{}@115200", port.address());
    let text = place.good(&["robot", "watch", &address, "--json", "--cycles", "5", "--hz", "4"]);
    let readings = lines(&text);
    assert_eq!(readings.len(), 5, "{text}");
    for reading in readings {
        let values = reading["values"].as_object().unwrap();
        let read: Vec<i64> = values.values().map(|value| value.as_f64().unwrap() as i64).collect();
        let robot = port.robot();
        let mut sensed: Vec<i64> = robot
            .body
            .proximity
            .iter()
            .chain(&robot.body.light)
            .map(|value| i64::from(*value))
            .collect();
        sensed.extend([0, 0]);
        let sorted = |mut values: Vec<i64>| {
            values.sort_unstable();
            values
        };
        // JSON has them in the order of their names.
        assert_eq!(sorted(read), sorted(sensed));
        assert_eq!(values["proximity_left_90"], 1023);
        assert_eq!(values["proximity_back_left"], 7);
        assert!(reading["age_ms"].as_f64().unwrap() >= 60.0, "{reading}");
    }
}

/// A file of commands drives it as far as it says, and it stands in the end.
#[test]
fn it_is_driven_by_a_file() {
    let place = Place::new("drive");
    let port = Port::new(Rolling::default(), 38_400);
    port.robot().receive(b"D,0,0\n", Duration::ZERO);
    place.write("file.txt", "1.5 80 80\n0.5 0 0\n1.0 -40 40\n");
    let address = format!("{}@38400", port.address());
    let before = port.robot().body.pose;
    place.good(&["robot", "drive", &address, "--commands", "file.txt"]);
    assert_eq!(port.robot().speeds(), [0, 0]);
    let after = port.robot().body.pose;
    let way = (after[0] - before[0]).hypot(after[1] - before[1]);
    // 120 mm less what acceleration costs, 8 mm, and by the unit of 8 mm/s.
    assert!((95.0..130.0).contains(&way), "{way}");
    // 40 mm of each wheel on a circle of 26.5 mm.
    let turned = after[2] - before[2];
    assert!((1.2..1.7).contains(&turned), "{turned}");
    let rest = port.robot().counters();
    thread::sleep(Duration::from_millis(300));
    assert_eq!(port.robot().counters(), rest);
}

/// It restarts while it is driven: that needs an operator, whom a file of commands has not.
#[test]
fn a_restart_while_it_is_driven_ends_the_drive() {
    let place = Place::new("restart");
    let port = Port::new(Rolling::default(), 38_400);
    place.write("file.txt", "20 60 60\n");
    let address = format!("{}@38400", port.address());
    let arguments = [
        "robot",
        "drive",
        &address,
        "--commands",
        "file.txt",
        "--record",
        "link.txt",
    ];
    thread::scope(|scope| {
        let ran = scope.spawn(|| place.run(&arguments));
        let start = Instant::now();
        while port.robot().speeds() != [7, 7] {
            assert!(start.elapsed() < Duration::from_secs(20));
            thread::sleep(Duration::from_millis(2));
        }
        port.robot().restarts_after = Some(3);
        let ran = ran.join().unwrap().exits(1);
        assert!(ran.stdout.contains("restarted"), "{}", ran.stdout);
        assert!(start.elapsed() < Duration::from_secs(15));
    });
    assert_eq!(port.robot().speeds(), [0, 0]);
    // "ROM", which it begins with.
    let received: String = place
        .text("link.txt")
        .lines()
        .filter_map(|line| line.split_once(" < "))
        .map(|(_, hex)| hex)
        .collect();
    assert!(received.contains("524f4d"), "{received}");
}

/// A simulated robot before a wall: the wall is seen over the wire, and driving backwards leads away from it.
#[test]
fn a_simulated_robot_backs_off_a_wall() {
    let place = Place::new("wall");
    let body = Simulated::new(2, Arena::miglino1995(), [300.0, 45.0, 0.75]);
    let port = Port::new(body, 115_200);
    port.robot().receive(b"D,0,0\n", Duration::ZERO);
    port.robot().body.place([300.0, 45.0, 0.75]);
    let address = format!("{}@115200", port.address());
    let ahead = || {
        let text = place.good(&[
            "robot",
            "watch",
            &address,
            "--kinds",
            "proximity",
            "--json",
            "--cycles",
            "1",
        ]);
        lines(&text)[0]["values"]["proximity_left_10"].as_f64().unwrap()
    };
    let near = ahead();
    place.write("back.txt", "1.2 -50 -50\n");
    place.good(&["robot", "drive", &address, "--commands", "back.txt"]);
    let far = ahead();
    assert!(near > 500.0 && far < 150.0, "{near} {far}");
    let [x, y, _] = port.robot().body.pose;
    assert!((x - 300.0).abs() < 10.0 && (75.0..115.0).contains(&y), "{x} {y}");
}
