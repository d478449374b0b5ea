use std::io::{Read, Write};
use std::net::TcpListener;
use std::thread;

use super::script::{Random, Scripted, Step, hear, say};
use super::*;

/// The first two questions to an e-puck.
fn asked_as_an_e_puck(answer: Option<&str>) -> Vec<Step> {
    let asked = [hear([&[0; 21][..], b"\rD,0,0\r"].concat()), hear("V\r")];
    let once: Vec<Step> = asked.into_iter().chain(answer.map(say)).collect();
    [once.clone(), once].concat()
}

fn recognised(steps: Vec<Step>) -> Result<Option<Box<dyn Robot>>> {
    recognise(Box::new(Scripted::new(steps)))
}

#[test]
fn a_khepera_is_told_from_an_e_puck() {
    for answer in [None, Some("z,Protocol error\r\n"), Some("Command not found\r\n")] {
        let khepera = vec![
            hear("\rD,0,0\r"),
            hear("B\r"),
            say("b,5.02,5.01\r\n"),
            hear("D,0,0\r"),
            say("d\r\n"),
            hear("E\r"),
            say("e,0,0\r\n"),
        ];
        let robot = recognised([asked_as_an_e_puck(answer), khepera].concat())
            .unwrap()
            .unwrap();
        assert_eq!(robot.description().robot, "Khepera");
    }
}

#[test]
fn what_says_nothing_known_is_not_recognised() {
    let asked = [hear("\rD,0,0\r"), hear("B\r")];
    let silent = [asked_as_an_e_puck(None), asked.to_vec(), asked.to_vec()].concat();
    assert!(recognised(silent).unwrap().is_none());
    let modem = [hear("\rD,0,0\r"), hear("B\r"), say("ERROR\r\n")];
    let modem = [asked_as_an_e_puck(Some("ERROR\r\n")), modem.to_vec(), modem.to_vec()].concat();
    assert!(recognised(modem).unwrap().is_none());
    let lost = vec![hear([&[0; 21][..], b"\rD,0,0\r"].concat()), Step::HangUp];
    assert!(matches!(recognised(lost), Err(Error::Disconnected { .. })));
}

/// A robot that has named itself, and does not stop, is not asked whether it is something else.
#[test]
fn a_robot_that_does_not_stop_is_an_error() {
    let epuck = epuck::tests::opening_that_keeps("e,5,5\r\n");
    assert!(matches!(recognised(epuck), Err(Error::StillTurning { .. })));
    let khepera = vec![hear("\rD,0,0\r"), hear("B\r"), say("b,5.02,5.01\r\n")];
    let unanswered = [vec![hear("D,0,0\r")], khepera.clone()].concat();
    let unanswered = vec![unanswered; 3].concat();
    let steps = [asked_as_an_e_puck(None), khepera, unanswered];
    assert!(matches!(recognised(steps.concat()), Err(Error::TimedOut { command, .. }) if command == "D,0,0"));
}

/// Listens, and for each connection answers what `answer` makes of the bytes so far, of which it takes what it has
/// understood; as long as it does, it is asked again.
fn listen(connections: usize, answer: impl Fn(&mut Vec<u8>) -> Vec<u8> + Send + 'static) -> Wire {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    thread::spawn(move || {
        for stream in listener.incoming().take(connections) {
            let (mut stream, mut heard, mut buffer) = (stream.unwrap(), Vec::new(), [0; 64]);
            while let Ok(count @ 1..) = stream.read(&mut buffer) {
                heard.extend_from_slice(&buffer[..count]);
                let mut left = heard.len() + 1;
                while heard.len() < left {
                    left = heard.len();
                    let _ = stream.write_all(&answer(&mut heard));
                }
            }
        }
    });
    Wire::Plain(Transport::Tcp {
        host: "127.0.0.1".into(),
        port,
    })
}

/// A Khepera behind a server of serial ports: the first connection is spent on the question for an e-puck2.
#[test]
fn a_khepera_is_found_over_tcp() {
    let wire = listen(2, |heard| {
        let Some(end) = heard.iter().position(|byte| *byte == b'\r') else {
            return Vec::new();
        };
        let line: Vec<u8> = heard.drain(..=end).collect();
        match &line[..] {
            b"\r" => b"".to_vec(),
            b"B\r" => b"b,5.02,5.01\r\n".to_vec(),
            b"D,0,0\r" => b"d\r\n".to_vec(),
            b"E\r" => b"e,0,0\r\n".to_vec(),
            _ => b"z,Protocol error\r\n".to_vec(),
        }
    });
    let robot = connect(&wire, None).unwrap();
    assert_eq!(robot.description().firmware, "5.02,5.01");
    robot.close().unwrap();
}

#[test]
fn what_answers_nothing_over_tcp_is_reported() {
    let wire = listen(2, |_| Vec::new());
    let words = connect(&wire, None).err().unwrap().to_string();
    assert!(
        words.contains("no e-puck2 (Wi-Fi), e-puck or Khepera answers; check"),
        "{words}"
    );
}

#[test]
fn a_robot_that_is_tilted_or_falls_is_lifted() {
    let at = |degrees: f64| {
        [
            0.0,
            800.0 * degrees.to_radians().sin(),
            800.0 * degrees.to_radians().cos(),
        ]
    };
    for degrees in [0.0, 29.0, -29.0] {
        assert!(!is_tilted(&at(degrees)), "{degrees}");
    }
    for degrees in [31.0, -31.0, 90.0, 180.0] {
        assert!(is_tilted(&at(degrees)), "{degrees}");
    }
    assert!(is_tilted(&[0.0; 3]));
}

/// Uses a robot whose other end has gone mad. Every call ends, and what is accepted could be. The first call is a reading:
/// later ones are rarely in step.
fn use_mad(robot: &mut dyn Robot, random: &mut Random, now: impl Fn() -> Duration) -> usize {
    let groups = robot.description().sensors.clone();
    let mut accepted = 0;
    for call in 0..20 {
        let start = now();
        match if call == 0 { 5 } else { random.below(6) } {
            0 => drop(robot.drive(random.below(2000) as i32 - 1000, 5)),
            1 => drop(robot.stop()),
            2 => drop(robot.light(0, true)),
            3 => drop(robot.battery()),
            4 => drop(robot.odometry()),
            _ => {
                let group = groups[if call == 0 { 0 } else { random.below(groups.len()) }];
                if let Ok(reading) = robot.sense(&[group.kind]) {
                    assert_eq!(reading.values.len(), group.names.len());
                    assert!(reading.values.iter().all(|value| value.is_finite()));
                    accepted += 1;
                }
            }
        }
        assert!(now() < start + Duration::from_secs(3));
    }
    accepted
}

/// For each driver, and many seeds. Some readings are accepted, since some answers are whole.
#[test]
fn no_call_panics_or_hangs_when_the_robot_goes_mad() {
    type Open = fn(Scripted) -> Box<dyn Robot>;
    let khepera: Open = |link| {
        let mut robot = khepera::Khepera::new(Box::new(link));
        robot.begin().unwrap();
        Box::new(robot)
    };
    let epuck: Open = |link| {
        let mut robot = epuck::EPuck::new(Box::new(link));
        robot.begin().unwrap();
        Box::new(robot)
    };
    let epuck2: Open = |link| Box::new(epuck2::EPuck2::connect(Box::new(link)).unwrap().unwrap());
    let thymio: Open = |link| Box::new(thymio::Thymio::connect(Box::new(link), None).unwrap());
    let text = |lines: &[&str]| -> Vec<Vec<u8>> { lines.iter().map(|line| line.as_bytes().to_vec()).collect() };
    let as_1 = |is_binary| epuck::tests::opening(epuck::tests::VERSION_1, epuck::tests::EIGHT, is_binary);
    let lines = text(&[
        "n,1,2,3,4,5,6,7,8\r\n",
        "d\r\n",
        "b,5.02,5.01\r\n",
        "h,5,6\r\n",
        "e,1,2\r\n",
        "z,Protocol error\r\n",
    ]);
    let lines_1 = text(&[
        "n,1,2,3,4,5,6,7,8\r\n",
        "d\r\n",
        "q,5,6\r\n",
        epuck::tests::VERSION_1,
        "a,1,2,3\r\n",
    ]);
    let binary_1 = [
        text(&[epuck::tests::VERSION_1]),
        vec![vec![0; 4], vec![0; 8], vec![0; 20], vec![0; 10]],
    ]
    .concat();
    let blocks = vec![epuck2::tests::answer([1, 2]), epuck2::tests::answer([1, 2]), vec![3]];
    let values = vec![
        aseba::tests::from(1, 0x9005, &[3, 0, 0, 0, 0, 0]),
        aseba::tests::from(1, 0x9005, &[5, 0, 1, 0, 2, 0, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 7, 0]),
        aseba::tests::from(1, 5, &[1, 2]),
    ];
    for (open, opening, answers) in [
        (khepera, khepera::tests::opening(), lines),
        (epuck, as_1(false), lines_1),
        (epuck, as_1(true), binary_1),
        (epuck2, epuck2::tests::opening(), blocks),
        (thymio, thymio::tests::opening(1), values),
    ] {
        let accepted: usize = (0..100)
            .map(|seed| {
                let link = Scripted::new(opening.clone()).then_noise(seed, answers.clone());
                let hand = link.hand();
                let mut robot = open(link);
                use_mad(&mut *robot, &mut Random(1000 + seed), || hand.now())
            })
            .sum();
        assert!(accepted > 0);
    }
}

/// A controller that evolved on a preset finds its sensors on the robot by their names.
#[test]
fn sensors_have_the_names_of_presets() {
    let thymio = thymio::THYMIO.sensors.iter().map(|(group, _)| *group);
    let thymio: Vec<Group> = thymio
        .filter(|group| matches!(group.kind, Kind::Proximity | Kind::Ground))
        .collect();
    for (preset, groups) in [
        (
            include_str!("../../lab/src/experiment/robots/epuck.toml"),
            vec![epuck::PROXIMITY, epuck::LIGHT, epuck::GROUND],
        ),
        (include_str!("../../lab/src/experiment/robots/thymio2.toml"), thymio),
    ] {
        let preset: toml::Table = preset.parse().unwrap();
        let sensors = preset["robot"]["sensors"].as_array().unwrap();
        let names: Vec<&str> = sensors.iter().map(|sensor| sensor["name"].as_str().unwrap()).collect();
        assert_eq!(
            names,
            groups.iter().flat_map(|group| group.names).copied().collect::<Vec<_>>()
        );
    }
}

#[test]
fn kinds_and_lights_that_a_robot_lacks_are_named() {
    let description = Description {
        robot: "thing".into(),
        firmware: String::new(),
        sensors: vec![epuck::PROXIMITY, epuck::GROUND],
        wheels: epuck::WHEELS,
        lights: &["left", "right"],
    };
    let groups = description.groups(&[Kind::Ground, Kind::Proximity]).unwrap();
    assert_eq!(groups, [epuck::GROUND, epuck::PROXIMITY]);
    let words = description
        .groups(&[Kind::Ground, Kind::Light])
        .unwrap_err()
        .to_string();
    assert_eq!(words, "thing has no sensors of light; allowed: proximity, ground");
    let words = description.light(2).unwrap_err().to_string();
    assert_eq!(words, "thing has no light 2; allowed: 0 to 1");
}

/// A recording of a real link plays back to the same readings, including the stop at the end. The robot sends less
/// often than a real one: its answers are then far from the limits in time by which the driver decides.
#[test]
fn a_recording_over_tcp_plays_back() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        stream.read_exact(&mut [0; 21]).unwrap();
        while stream.write_all(&epuck2::tests::answer([7, 9])).is_ok() {
            thread::sleep(Duration::from_millis(70));
        }
    });
    let host = "127.0.0.1".into();
    let path = std::env::temp_dir().join(format!("oneiro-recorded-{}", std::process::id()));
    let recording = Recording::create(&path).unwrap();
    let wire = Wire::Plain(Transport::Tcp { host, port });
    let used = |robot: &mut dyn Robot| -> Vec<Reading> {
        let kinds: Vec<Kind> = robot.description().sensors.iter().map(|group| group.kind).collect();
        let readings = (0..3).map(|_| Reading {
            at: Duration::ZERO,
            age: Duration::ZERO,
            ..robot.sense(&kinds).unwrap()
        });
        let readings = readings.collect();
        robot.stop().unwrap();
        readings
    };
    let mut robot = connect(&wire, Some(&recording)).unwrap();
    let readings = used(&mut *robot);
    drop(robot);
    assert_eq!(recording.finish(), None);

    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    let mut replays = recording::replay::Replay::parse(&text).unwrap();
    let mut again = epuck2::EPuck2::connect(Box::new(replays.remove(0))).unwrap().unwrap();
    assert_eq!(used(&mut again), readings);
}
