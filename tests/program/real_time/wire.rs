//! `oneiro robot` against robots that are scripted here, over TCP: an e-puck2 and a Khepera, by their protocols, and ends
//! of a link that are none.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpListener;
use std::process::{Child, Stdio};
use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::peers::{EPuck2, Noise, listen, wait};
use crate::place::{Place, Ran};

/// A Khepera behind a server of serial ports, which answers a line of commands with a line.
fn khepera() -> String {
    listen(|mut stream| {
        let (mut heard, mut byte) = (Vec::new(), [0]);
        while let Ok(1) = stream.read(&mut byte) {
            if !matches!(byte[0], b'\r' | b'\n') {
                heard.push(byte[0]);
                continue;
            }
            let answer: &[u8] = match &heard[..] {
                b"" => b"",
                b"B" => b"b,5.02,5.01\r\n",
                b"D,0,0" => b"d\r\n",
                b"L,1,1" | b"L,1,0" => b"l\r\n",
                b"N" => b"n,11,12,13,14,15,16,17,18\r\n",
                b"O" => b"o,501,502,503,504,505,506,507,508\r\n",
                b"E" => b"e,0,0\r\n",
                _ => b"z,Protocol error\r\n",
            };
            heard.clear();
            if stream.write_all(answer).is_err() {
                return;
            }
        }
    })
}

fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn list_has_the_forms_of_addresses() {
    let place = Place::new("list");
    let text = place.good(&["robot", "list"]);
    for form in ["serial:PATH", "tcp:HOST:PORT", "aseba:serial:PATH", "aseba:HOST:PORT"] {
        assert!(text.contains(form), "{text}");
    }
    let list: Value = serde_json::from_str(&place.good(&["robot", "list", "--json"])).unwrap();
    assert_eq!(list["addresses"].as_array().unwrap().len(), 5);
    assert!(list["ports"].is_array());
}

#[test]
fn ping_tells_what_an_e_puck2_is_and_stops_it() {
    let place = Place::new("ping");
    let robot = EPuck2::default();
    let address = robot.start();
    let text = place.good(&["robot", "ping", &address]);
    for words in [
        &format!("e-puck2 at {address}\n"),
        "wheels: stopped; up to 1000 steps / s, which is 129 mm/s; 53 mm apart",
        "battery: 3.90 V\n",
        "round trip: 20 readings of acceleration: min ",
        "prox_0, prox_1,",
    ] {
        assert!(text.contains(words), "no `{words}` in\n{text}");
    }
    assert_eq!(robot.0.wheels().0, [0, 0]);

    let address = robot.start();
    let told: Value = serde_json::from_str(&place.good(&["robot", "ping", &address, "--json"])).unwrap();
    assert_eq!(told["robot"], "e-puck2");
    assert_eq!(told["address"], address);
    assert_eq!(told["wheels"]["greatest"], 1000);
    assert_eq!(told["wheels"]["base_mm"], 53.0);
    assert_eq!(told["battery"]["low"], false);
    let sensors = told["sensors"].as_array().unwrap();
    let distance = sensors.iter().find(|group| group["kind"] == "distance").unwrap();
    assert_eq!(distance["unit"], "mm");
    assert_eq!(distance["names"], serde_json::json!(["distance_front"]));
    let [min, median, max] = ["min_ms", "median_ms", "max_ms"].map(|key| told["round_trip"][key].as_f64().unwrap());
    assert!(0.0 <= min && min <= median && median <= max && max > 0.0, "{told}");
}

#[test]
fn ping_tells_what_a_khepera_is() {
    let place = Place::new("khepera");
    let told: Value = serde_json::from_str(&place.good(&["robot", "ping", &khepera(), "--json"])).unwrap();
    assert_eq!(told["robot"], "Khepera");
    assert_eq!(told["firmware"], "5.02,5.01");
    assert_eq!(told["battery"], Value::Null);
    assert_eq!(told["lights"], serde_json::json!(["led_0", "led_1"]));
}

#[test]
fn watch_prints_a_line_for_each_reading() {
    let place = Place::new("watch");
    let robot = EPuck2::default();
    let address = robot.start();
    let text = place.good(&["robot", "watch", &address, "--json", "--cycles", "5", "--hz", "50"]);
    let readings = lines(&text);
    assert_eq!(readings.len(), 5, "{text}");
    for reading in &readings {
        let values = &reading["values"];
        assert_eq!(values["prox_0"], 100);
        assert_eq!(values["prox_7"], 107);
        assert_eq!(values["light_3"], 3003);
        assert_eq!(values["distance_front"], 250);
        assert_eq!(values["temperature"], -5);
        assert!(reading["age_ms"].as_f64().unwrap() > 0.0);
    }
    let times: Vec<f64> = readings
        .iter()
        .map(|reading| reading["time_s"].as_f64().unwrap())
        .collect();
    assert!(times[0] == 0.0 && times.is_sorted() && times[4] > 0.02, "{times:?}");
    assert_eq!(robot.0.wheels().0, [0, 0]);

    // Standard output is no terminal here: without --json the lines are the same.
    let kinds = [
        "robot",
        "watch",
        &robot.start(),
        "--kinds",
        "distance,light",
        "--cycles",
        "1",
    ];
    let reading = &lines(&place.good(&kinds))[0];
    assert_eq!(reading["values"].as_object().unwrap().len(), 9, "{reading}");
}

/// After the restart a program of its own drives it: the watch stops it, and goes on.
#[test]
fn a_watch_stops_a_robot_that_has_restarted() {
    let place = Place::new("restart");
    let robot = EPuck2::default();
    let address = robot.start();
    let arguments = ["robot", "watch", &address, "--cycles", "40"];
    let mut program = place.start(&arguments);
    let mut lines = BufReader::new(program.stdout.take().unwrap()).lines();
    lines.next().unwrap().unwrap();
    // So that its counters are not at 0.
    robot.0.set([300, 300]);
    thread::sleep(Duration::from_millis(100));
    robot.0.set([0, 0]);
    robot.0.restarts.store(true, Ordering::SeqCst);
    wait("the restart", Duration::from_secs(10), || !robot.0.stands());
    let event = robot.0.wheels().1;
    wait("the stop", Duration::from_secs(10), || robot.0.stands());
    let took = robot.0.wheels().1 - event;
    assert!(took < Duration::from_millis(500), "{took:?}");
    assert_eq!(lines.count(), 39);
    let ran = Ran::ended(&arguments, program).exits(0);
    ran.says(&["the robot has restarted, and its wheels have been stopped"]);
}

#[test]
fn lights_are_switched_by_name() {
    let place = Place::new("light");
    let robot = EPuck2::default();
    let address = robot.start();
    let text = place.good(&["robot", "light", &address, "led_1,led_2,body", "on"]);
    assert_eq!(
        text,
        format!("switched on: led_1, led_2, body of the e-puck2 at {address}\n")
    );
    let lit = [&[0x11, 100, 100, 100][..], &[0; 9]].concat();
    assert_eq!(*robot.0.lights.lock().unwrap(), lit);
    assert!(robot.0.stands());
    let told: Value =
        serde_json::from_str(&place.good(&["robot", "light", &robot.start(), "led_2", "off", "--json"])).unwrap();
    assert_eq!(
        (&told["lights"], &told["state"]),
        (&serde_json::json!(["led_2"]), &"off".into())
    );
    assert_eq!(*robot.0.lights.lock().unwrap(), [0; 13]);

    let address = khepera();
    place.good(&["robot", "light", &address, "led_1", "on"]);
    let ran = place.run(&["robot", "light", &address, "led_1,led_2", "on"]).exits(3);
    ran.says(&["Khepera has no light led_2; allowed: led_0, led_1"]);
    place.run(&["robot", "light", &address, "led_1", "green"]).exits(2);
}

/// Its wheels are made to turn while it is watched, as if by somebody else.
#[test]
#[cfg(unix)]
fn ctrl_c_ends_a_watch_and_stops_the_wheels() {
    use std::process::Command;

    for (cycles, code, words) in [
        (&[][..], 0, "stopped by Ctrl-C"),
        (&["--cycles", "100000"], 75, "of 100000 readings"),
    ] {
        let place = Place::new("ctrl-c");
        let robot = EPuck2::default();
        let address = robot.start();
        let arguments = [&["robot", "watch", &address][..], cycles].concat();
        let mut program = place.start(&arguments);
        // The first line, of which the first byte is enough.
        program.stdout.as_mut().unwrap().read_exact(&mut [0]).unwrap();
        robot.0.set([50, 50]);
        let id = program.id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
        let ran = Ran::ended(&arguments, program);
        ran.exits(code).says(&[words]);
        assert_eq!(robot.0.wheels().0, [0, 0]);
    }
}

/// The reading fails and so does the stop, for the same reason, which is said once.
#[test]
fn a_watch_that_fails_says_why_and_that_the_wheels_may_turn() {
    let place = Place::new("lost");
    let robot = EPuck2::default();
    let address = robot.start();
    let arguments = ["robot", "watch", &address];
    let mut program = place.start(&arguments);
    program.stdout.as_mut().unwrap().read_exact(&mut [0]).unwrap();
    robot.0.is_gone.store(true, Ordering::Relaxed);
    let ran = Ran::ended(&arguments, program).exits(4);
    assert_eq!(
        ran.stderr.matches("the connection is lost").count(),
        1,
        "{}",
        ran.stderr
    );
    ran.says(&[
        "cannot stop: ",
        "the connection is lost",
        "The wheels may be turning: lift the robot",
    ]);
}

#[test]
fn stop_says_whether_the_robot_confirmed_it() {
    let place = Place::new("stop");
    let robot = EPuck2::default();
    let address = robot.start();
    let text = place.good(&["robot", "stop", &address]);
    assert_eq!(text, format!("stopped: the e-puck2 at {address} has confirmed it\n"));
    assert_eq!(robot.0.wheels().0, [0, 0]);
    let told: Value = serde_json::from_str(&place.good(&["robot", "stop", &robot.start(), "--json"])).unwrap();
    assert_eq!(told["stopped"], true);

    robot.0.is_runaway.store(true, Ordering::Relaxed);
    let ran = place.run(&["robot", "stop", &robot.start()]).exits(4);
    assert_eq!(ran.stdout, "");
    ran.says(&[
        "oneiro: cannot stop: ",
        "step counters have not stood still",
        "The wheels may be turning: lift the robot",
    ]);
    assert_eq!(robot.0.wheels().0, [300, -200]);
}

#[test]
fn a_recording_has_what_was_sent_and_received() {
    let place = Place::new("record");
    let address = EPuck2::default().start();
    place.good(&["robot", "watch", &address, "--cycles", "2", "--record", "link.txt"]);
    let text = place.text("link.txt");
    assert!(text.starts_with("oneiro link recording 1\n"), "{text}");
    // A stop at the beginning and at the end, and the sensors between.
    let stop = format!(" > 8002{}", "00".repeat(19));
    assert_eq!(text.lines().filter(|line| line.ends_with(&stop)).count(), 2, "{text}");
    assert!(text.contains("640065006600670068"), "{text}");

    // Nothing is overwritten, and the robot is left alone.
    let robot = EPuck2::default();
    let address = robot.start();
    place.write("mine.txt", "mine");
    place
        .run(&["robot", "ping", &address, "--record", "mine.txt"])
        .exits(3)
        .says(&["mine.txt: exists already", "name another file"]);
    assert_eq!(robot.0.wheels().0, [300, -200]);
    assert_eq!(place.text("mine.txt"), "mine");
}

#[test]
fn addresses_and_kinds_that_can_not_be_exit_with_3() {
    let place = Place::new("addresses");
    for (address, words) in [
        (
            "surrogate:1",
            &["surrogate:1: a surrogate has no link", "allowed: serial:PATH"][..],
        ),
        (
            "/dev/ttyUSB0",
            &["does not say how to reach it", "allowed: serial:PATH"],
        ),
        ("tcp:localhost", &["has no port", "HOST:PORT"]),
        ("usb:1", &["`usb` is no way to reach a robot", "aseba:HOST:PORT"]),
    ] {
        for command in ["ping", "watch", "stop"] {
            place.run(&["robot", command, address]).exits(3).says(words);
        }
    }
    let ran = place.run(&["robot", "watch", &khepera(), "--kinds", "ground"]).exits(3);
    ran.says(&["Khepera has no sensors of ground; allowed: proximity, light, wheel_speed"]);
    for arguments in [
        &["--hz", "0"][..],
        &["--hz", "1000"],
        &["--cycles", "0"],
        &["--kinds", "smell"],
    ] {
        let arguments = [&["robot", "watch", "tcp:127.0.0.1:9"], arguments].concat();
        place.run(&arguments).exits(2);
    }
}

/// Nobody listens, the other end is silent, hangs up, or sends what makes no sense.
#[test]
fn what_is_no_robot_exits_with_4_and_says_so_soon() {
    let place = Place::new("nobody");
    let closed = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let silent = listen(|mut stream| while let Ok(1..) = stream.read(&mut [0; 64]) {});
    let garbage = listen(|mut stream| {
        let mut noise = Noise::new();
        loop {
            if stream.write_all(&noise.bytes(100)).is_err() {
                return;
            }
            thread::sleep(Duration::from_millis(5));
        }
    });
    for (address, words) in [
        (format!("tcp:{closed}"), "can't be opened"),
        (listen(drop), "lost"),
        (
            silent.clone(),
            "no e-puck2 over Wi-Fi, e-puck, e-puck2 or Khepera answers; check that it is on",
        ),
        (
            garbage.clone(),
            "no e-puck2 over Wi-Fi, e-puck, e-puck2 or Khepera answers; check that it is on",
        ),
        (
            format!("aseba:{}", silent.trim_start_matches("tcp:")),
            "check that the robot is on",
        ),
        (format!("aseba:{}", garbage.trim_start_matches("tcp:")), "check"),
        (
            "serial:/dev/there is no such port".to_owned(),
            "check the path and the cable",
        ),
    ] {
        let start = Instant::now();
        place
            .run(&["robot", "ping", &address])
            .exits(4)
            .says(&[words, &address]);
        assert!(
            start.elapsed() < Duration::from_secs(10),
            "{address}: {:?}",
            start.elapsed()
        );
        let ran = place.run(&["robot", "stop", &address]).exits(4);
        ran.says(&["cannot stop: ", "The wheels may be turning"]);
    }
}

/// Memory that a process has for itself, kB: without its code's pages, which depend on the build. 0 if it has ended.
#[cfg(target_os = "linux")]
fn memory(program: &Child) -> u32 {
    let status = std::fs::read_to_string(format!("/proc/{}/status", program.id())).unwrap_or_default();
    let own = status.lines().find_map(|line| line.strip_prefix("RssAnon:"));
    own.map_or(0, |own| own.trim().trim_end_matches(" kB").parse().unwrap())
}

/// The most memory that a program has until it ends, kB.
#[cfg(target_os = "linux")]
fn most_memory(program: &mut Child) -> u32 {
    let mut most = 0;
    while program.try_wait().unwrap().is_none() {
        most = most.max(memory(program));
        thread::sleep(Duration::from_millis(5));
    }
    most
}

/// A robot's computer is small.
#[test]
#[cfg(target_os = "linux")]
fn a_watch_and_a_guard_need_little_memory() {
    let place = Place::new("memory");
    let address = EPuck2::default().start();
    let limits = 500..10_000;
    let mut watch = place.start(&["robot", "watch", &address, "--cycles", "20"]);
    let most = most_memory(&mut watch);
    println!("watch: {most} kB");
    assert!(watch.wait().unwrap().success() && limits.contains(&most), "{most} kB");

    let address = EPuck2::default().start();
    let mut command = place.command(&["guard", &address]);
    let mut guard = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut input = guard.stdin.take().unwrap();
    writeln!(input, "{}", serde_json::json!({ "hello": { "version": 1 } })).unwrap();
    let reports = BufReader::new(guard.stdout.take().unwrap()).lines();
    // Until it has read its sensors for a second.
    assert_eq!(reports.take(50).flatten().count(), 50);
    let most = memory(&guard);
    println!("guard: {most} kB");
    assert!(limits.contains(&most), "{most} kB");
    drop(input);
    assert!(guard.wait().unwrap().success());
}

/// What sends without an end is given up as well, and is not kept.
#[test]
#[cfg(target_os = "linux")]
fn a_flood_ends_and_is_not_kept() {
    let place = Place::new("flood");
    // A line without an end, lines, headers, and ever more nodes of a network.
    let floods: [fn(u32) -> Vec<u8>; 4] = [
        |_| vec![b'n'; 8192],
        |_| b"n,1,2,3,4,5,6,7,8\r\n".repeat(400),
        |_| [2; 8192].into(),
        |turn| {
            let node = |node: u32| [2, 0, node as u8, (node >> 8) as u8, 0x0c, 0x90, 5, 0];
            (1000 * turn..1000 * (turn + 1)).flat_map(node).collect()
        },
    ];
    for (index, flood) in floods.into_iter().enumerate() {
        let address = listen(move |mut stream| {
            for turn in 0.. {
                if stream.write_all(&flood(turn)).is_err() {
                    return;
                }
            }
        });
        for address in [address.clone(), format!("aseba:{}", address.trim_start_matches("tcp:"))] {
            let arguments = ["robot", "ping", &address];
            let start = Instant::now();
            let mut program = place.start(&arguments);
            let most = most_memory(&mut program);
            println!("flood {index} at {address}: {:.1?}, {most} kB", start.elapsed());
            Ran::ended(&arguments, program).exits(4).says(&[&address]);
            assert!((500..100_000).contains(&most), "flood {index} at {address}: {most} kB");
            assert!(start.elapsed() < Duration::from_mins(1), "flood {index} at {address}");
        }
    }
}
