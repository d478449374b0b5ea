//! Lives on a robot on a wire, which keeps its last speed for ever: `oneiro evaluate --robot`, and runs and studies that end on it.
#![cfg(unix)]

use std::fs::File;
use std::io::Write;
use std::net::UdpSocket;
use std::process::Stdio;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use oneiro::cpu::Cpu;
use oneiro::random::Key;
use oneiro::reported::Reported;
use oneiro::tables::SENSOR_NAMES;
use oneiro::world::WorldSpec;
use serialport::SerialPort;

mod on_board;
mod run;
mod several;
mod study;
mod untouched;
use crate::peers::{Body, wait};
use crate::place;
use crate::place::Place;
use crate::place::table::Table;
use crate::robots;

/// For what has no limit but must happen.
const LONG: Duration = Duration::from_secs(20);

/// Two genomes: both bend to the right, one of them faster.
fn genomes() -> Vec<Vec<f32>> {
    [1.0, 3.0]
        .map(|bias| {
            let mut genes = vec![0.25; 18];
            (genes[8], genes[17]) = (bias, 0.5 * bias);
            genes
        })
        .into()
}

/// A place with an experiment of short lives, and genomes.
fn placed(name: &str, cycles: u32) -> Place {
    let place = Place::new(name);
    place.write("short.toml", format!("cycles = {cycles}\n"));
    let line = |genes: &Vec<f32>| genes.iter().map(f32::to_string).collect::<Vec<_>>().join(",");
    let text = genomes().iter().map(line).collect::<Vec<_>>().join("\n");
    place.write("genomes.csv", text + "\n");
    place
}

/// The command that evaluates both genomes on a robot.
fn arguments<'a>(address: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let own = [
        "evaluate",
        "short.toml",
        "--genomes",
        "genomes.csv",
        "--trials",
        "2",
        "--walk",
        "0.5",
        // On a busy machine the robot answers late.
        "--guard",
        "link_ms=400",
    ];
    [&own[..], &["--robot", address, "--log", "lives"], more].concat()
}

/// The fitness of a life, from its table alone.
fn told_again(place: &Place, life: &str, genes: &[f32], key: &str, start: [f32; 3], cycles: u32) -> f32 {
    let table = Table::read(place, &format!("lives/life-{life}.csv"));
    let activations = SENSOR_NAMES.map(|name| table.numbers(name));
    let ends = ["x_mm", "y_mm", "heading_turns"].map(|name| table.numbers(name));
    let world = Reported::new(&WorldSpec {
        cycles,
        ..WorldSpec::miglino1995()
    })
    .unwrap();
    let key = Key::of_words([0, 8].map(|digit| u32::from_str_radix(&key[digit..digit + 8], 16).unwrap()));
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let mut told = world.begin(genes, key, start).unwrap();
    for cycle in 0..table.rows.len() {
        let shares = told
            .speeds(&mut cpu, &activations.each_ref().map(|column| column[cycle]))
            .unwrap()
            .unwrap();
        let speeds = ["left_mm_s", "right_mm_s"].map(|name| table.numbers(name)[cycle]);
        assert_eq!(speeds, shares.map(|share| 80.0 * share));
        told.moved(&mut cpu, ends.each_ref().map(|column| column[cycle]))
            .unwrap();
    }
    assert_eq!(told.cycles(), cycles);
    told.fitness()
}

/// Lives are recorded so that their fitness can be computed again, the pose is that of the wheels, and nothing is lived twice.
#[test]
fn lives_are_recorded_and_not_lived_again() {
    const CYCLES: u32 = 10;
    let place = placed("lives", CYCLES);
    let body = Body::default();
    let address = robots::khepera(&body);
    let ran = place.run(&arguments(&address, &[])).exits(0);
    let ran = ran.says(&[
        "4 episodes of 1 s, each after 0.5 s of driving about: 0.1 robot-minutes",
        "on Khepera (5.02,5.01) at serial:",
        "episode 4 of 4: genome 1, trial 1, fitness",
    ]);
    assert!(body.stands());
    let lives = || Table::read(&place, "lives/lives.csv");
    let (all, index) = (lives().rows, lives().complete());
    assert_eq!(index.column("cycles"), ["10"; 4]);
    let printed: Vec<&str> = ran
        .stdout
        .lines()
        .skip(1)
        .map(|line| line.rsplit(',').next().unwrap())
        .collect();
    assert_eq!(index.column("bits"), printed);
    let starts = ["start_x_mm", "start_y_mm", "start_heading_turns"].map(|name| index.numbers(name));
    for (life, genes) in [(0, 0), (1, 0), (2, 1), (3, 1)] {
        let start = starts.each_ref().map(|column| column[life]);
        let number = index.column("life")[life];
        let fitness = told_again(
            &place,
            number,
            &genomes()[genes],
            index.column("key")[life],
            start,
            CYCLES,
        );
        assert_eq!(format!("{:08x}", fitness.to_bits()), printed[life], "life {number}");
        let table = Table::read(&place, &format!("lives/life-{number}.csv"));
        // The robot reads 11 to 18 all the time.
        assert_eq!(table.column("raw_proximity_right_10"), ["14"; 10]);
        // It bends to the right.
        let [left, right] = ["left_mm", "right_mm"].map(|name| *table.numbers(name).last().unwrap());
        assert!(left > 10.0 && right > 0.0 && left > right, "{left} and {right} mm");
        let turns = start[2] - table.numbers("heading_turns").last().unwrap();
        let expected = (left - right) / (53.0 * std::f32::consts::TAU);
        assert!((turns.rem_euclid(1.0) - expected).abs() < 1e-4, "{turns} turns");
    }
    // The driving about has moved it between any two lives.
    assert_ne!(starts[0][0], starts[0][1]);
    // Again: all are on record, and the wheels don't move.
    let since = body.wheels().1;
    let again = place.run(&arguments(&address, &[])).exits(0);
    assert_eq!(again.stdout, ran.stdout);
    assert_eq!(lives().rows, all);
    assert_eq!(body.wheels().1, since);
    // Other genes are another life; other values of the robot too.
    let more = place.run(&arguments(&address, &["--seed", "2", "--json"])).exits(0);
    let json: serde_json::Value = serde_json::from_str(&more.stdout).unwrap();
    assert_eq!(json.as_array().unwrap().len(), 4);
    assert_eq!(lives().complete().rows.len(), 8);
    // A table that was changed is noticed.
    let life = index.column("life")[1];
    let path = format!("lives/life-{life}.csv");
    let text = place.text(&path);
    let (head, last) = text.trim_end().rsplit_once('\n').unwrap();
    let changed: String = last
        .split(',')
        .map(|cell| if cell.starts_with("0.01") { "0.9" } else { cell })
        .collect::<Vec<_>>()
        .join(",");
    assert_ne!(changed, last);
    place.write(&path, format!("{head}\n{changed}\n"));
    let refused = place.run(&arguments(&address, &[])).exits(5);
    refused.says(&[&format!("episode {life}: its table gives the fitness")]);
}

/// A Khepera at 9600 baud, where sensors, odometers and a command take 92 ms together.
#[test]
fn a_slow_link_is_fast_enough_for_cycles_of_100_ms() {
    let place = placed("slow", 50);
    let body = Body::default();
    let address = robots::khepera_at(9600, true, &body);
    place.run(&arguments(&address, &[])).exits(0);
    let index = Table::read(&place, "lives/lives.csv");
    for life in index.column("life") {
        let table = Table::read(&place, &format!("lives/life-{life}.csv"));
        let mut ages = table.numbers("age_ms");
        ages.sort_by(f32::total_cmp);
        let late = ["late_min_ms", "late_median_ms", "late_99_ms", "late_max_ms"]
            .map(|name| index.numbers(name)[life.parse::<usize>().unwrap() - 1]);
        eprintln!("late by {late:?} ms; age {} ms, at most {} ms", ages[25], ages[49]);
        assert!(late[1] < 20.0, "{late:?}");
        // The exchange itself takes 52 ms, and the next one begins up to 92 ms later.
        assert!(ages[49] < 300.0, "{ages:?}");
    }
}

/// Killed in the middle of a life: the wheels stand, and the next call lives that life again, and none that was complete.
#[test]
fn only_the_life_that_was_cut_short_is_lived_again() {
    let place = placed("killed", 15);
    let body = Body::default();
    let address = robots::khepera(&body);
    let arguments = arguments(&address, &[]);
    let mut program = place.start(&arguments);
    wait("the second life", LONG, || {
        let path = place.at("lives/life-2.csv");
        std::fs::read_to_string(path).is_ok_and(|text| text.lines().count() > 8)
    });
    let event = Instant::now();
    program.kill().unwrap();
    wait("the stop", LONG, || body.stands());
    let took = body.wheels().1 - event;
    assert!(took < Duration::from_millis(500), "{took:?}");
    program.wait().unwrap();
    let index = Table::read(&place, "lives/lives.csv");
    assert_eq!(index.column("status"), ["complete", "under way"]);
    let first = place.text("lives/life-1.csv");
    // The guard has freed the port when the wheels are known to stand.
    wait("the end of the guard", LONG, || {
        place.run(&["robot", "stop", &address]).code == Some(0)
    });
    place.run(&arguments).exits(0);
    assert!(body.stands());
    let index = Table::read(&place, "lives/lives.csv");
    let expected = ["complete", "the program ended", "complete", "complete", "complete"];
    assert_eq!(index.column("status"), expected);
    let keys = index.column("key");
    assert_eq!(keys[1], keys[2]);
    assert!(keys[0] != keys[1] && keys[2] != keys[3]);
    assert!(index.numbers("cycles")[1] >= 7.0);
    assert_eq!(place.text("lives/life-1.csv"), first);
}

/// Ctrl-C ends it with exit code 75 and wheels that stand; the radio that is lost for a moment costs one life.
#[test]
fn what_ends_a_life_early_is_recorded() {
    let place = placed("early", 20);
    let body = Body::default();
    let address = robots::khepera(&body);
    // It is lost for longer than the guard waits, and not for so long that the wheels can't be stopped.
    let arguments = arguments(&address, &["--guard", "link_ms=250"]);
    let program = place.start(&arguments);
    let lines = |life: u32| {
        let text = std::fs::read_to_string(place.at(format!("lives/life-{life}.csv")));
        text.map_or(0, |text| text.lines().count())
    };
    wait("the first life", LONG, || lines(1) > 6);
    body.is_deaf.store(true, Ordering::SeqCst);
    thread::sleep(Duration::from_millis(700));
    body.is_deaf.store(false, Ordering::SeqCst);
    wait("the life after it", LONG, || lines(2) > 6);
    let event = Instant::now();
    std::process::Command::new("kill")
        .args(["-INT", &program.id().to_string()])
        .status()
        .unwrap();
    wait("the stop", LONG, || body.stands());
    let took = body.wheels().1 - event;
    assert!(took < Duration::from_millis(500), "{took:?}");
    let ran = place::Ran::new(&["evaluate"], &program.wait_with_output().unwrap()).exits(75);
    ran.says(&[
        "cut short; the episode is repeated: the sensors can't be read",
        "run the same command again to continue",
    ]);
    let index = Table::read(&place, "lives/lives.csv");
    let status = index.column("status");
    assert!(status[0].starts_with("the sensors can't be read"), "{}", status[0]);
    assert_eq!(status[1..], ["stopped"]);
    assert_eq!(index.column("bits"), ["", ""]);
}

/// Poses are those of a tracker without its outliers. When it falls silent, the wheels stand, and the life is lived again once it sees
/// the robot.
#[test]
fn a_tracker_says_where_the_robot_is() {
    let place = placed("tracked", 20);
    let body = Body::default();
    let address = robots::khepera(&body);
    let port = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let sees = Arc::new(AtomicBool::new(true));
    let is_seen = Arc::clone(&sees);
    thread::spawn(move || {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        for sighting in 0_u32.. {
            thread::sleep(Duration::from_millis(30));
            // Every tenth is of something else.
            let x = if sighting % 10 == 9 {
                3000.0
            } else {
                300.0 + 0.5 * f64::from(sighting)
            };
            let t = 0.03 * f64::from(sighting);
            let line = format!("{{\"id\":3,\"t\":{t},\"x\":{x},\"y\":250.5,\"heading\":0.125}}\n");
            // Nobody may listen.
            if is_seen.load(Ordering::SeqCst) {
                let _ = socket.send_to(line.as_bytes(), port);
            }
        }
    });
    let tracker = format!("udp:{port}#3");
    let arguments = arguments(&address, &["--tracker", &tracker]);
    let program = place.start(&arguments);
    let lines = |life: u32| {
        let text = std::fs::read_to_string(place.at(format!("lives/life-{life}.csv")));
        text.map_or(0, |text| text.lines().count())
    };
    wait("the second life", LONG, || lines(2) > 6);
    sees.store(false, Ordering::SeqCst);
    let event = Instant::now();
    wait("the stop", LONG, || body.stands());
    let took = body.wheels().1 - event;
    assert!(took < Duration::from_millis(800), "{took:?}");
    thread::sleep(Duration::from_millis(500));
    assert!(body.stands());
    sees.store(true, Ordering::SeqCst);
    let ran = place::Ran::new(&["evaluate"], &program.wait_with_output().unwrap()).exits(0);
    ran.says(&["the robot has to be put back: the tracker does not see the robot"]);
    let index = Table::read(&place, "lives/lives.csv");
    let status = index.column("status");
    // On a busy machine sightings may be late once more.
    let (complete, cut): (Vec<_>, Vec<_>) = status
        .iter()
        .zip(index.column("life"))
        .partition(|(status, _)| **status == "complete");
    assert_eq!(complete.len(), 4);
    assert!(!cut.is_empty());
    for (status, _) in cut {
        assert!(status.contains("the tracker does not see the robot"), "{status}");
    }
    // In a life that is cut short the odometers tell where it is from the last sighting on.
    for (_, life) in complete {
        let table = Table::read(&place, &format!("lives/life-{life}.csv"));
        let x = table.numbers("x_mm");
        assert!(x.iter().all(|x| (300.0..1000.0).contains(x)) && x.is_sorted(), "{x:?}");
        assert!(table.numbers("y_mm").iter().all(|y| *y == 250.5));
        assert!(table.numbers("heading_turns").iter().all(|heading| *heading == 0.125));
    }
}

/// Somebody at a terminal puts the robot where the simulator starts the same life.
#[test]
fn lives_can_begin_where_somebody_puts_the_robot() {
    let place = placed("hand", 5);
    let body = Body::default();
    let address = robots::khepera(&body);
    let (mut terminal, slave) = serialport::TTYPort::pair().unwrap();
    let input = File::options().read(true).write(true).open(slave.name().unwrap());
    let arguments = arguments(&address, &["--between", "hand", "--common-starts"]);
    let mut command = place.command(&arguments);
    let program = command
        .stdin(input.unwrap())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let program = program.unwrap();
    let rows = || {
        place
            .at("lives/lives.csv")
            .exists()
            .then(|| Table::read(&place, "lives/lives.csv").rows.len())
    };
    wait("the index", LONG, || rows() == Some(0));
    // It waits, however long that takes.
    thread::sleep(Duration::from_secs(3));
    assert!(body.stands() && rows() == Some(0));
    wait("all lives", LONG, || {
        terminal.write_all(b"\n").unwrap();
        thread::sleep(Duration::from_millis(200));
        Table::read(&place, "lives/lives.csv").complete().rows.len() == 4
    });
    let ran = place::Ran::new(&["evaluate"], &program.wait_with_output().unwrap()).exits(0);
    let ran = ran.says(&[
        "and the time to put it at each start",
        "put the robot at x = ",
        "; then press Enter",
    ]);
    let lives = Table::read(&place, "lives/lives.csv");
    assert_eq!(ran.stderr.matches("then press Enter").count(), lives.rows.len());
    let traces = [
        "evaluate",
        "short.toml",
        "--genomes",
        "genomes.csv",
        "--trials",
        "2",
        "--common-starts",
    ];
    place.good(&[&traces[..], &["--traces", "traces"]].concat());
    let index = lives.complete();
    for (life, trace) in ["trace-0-0", "trace-0-1", "trace-1-0", "trace-1-1"].iter().enumerate() {
        let simulated = Table::read(&place, &format!("traces/{trace}.csv"));
        for (own, name) in [
            ("start_x_mm", "x_mm"),
            ("start_y_mm", "y_mm"),
            ("start_heading_turns", "heading_turns"),
        ] {
            assert_eq!(index.numbers(own)[life], simulated.numbers(name)[0], "{trace}, {name}");
        }
    }
}

#[test]
fn what_can_not_be_lived_is_refused() {
    let place = placed("refused", 10);
    std::fs::create_dir(place.at("mine")).unwrap();
    place.write("mine/letter.txt", "mine");
    let body = Body::default();
    let robot = robots::khepera(&body);
    for (arguments, code, words) in [
        (&["--robot", "tcp:127.0.0.1:9"][..], 2, &["lacks --log DIR"][..]),
        (
            &["--robot", "surrogate:1", "--log", "new"],
            2,
            &["surrogate:1 is simulated"],
        ),
        (
            &["--robot", "khepera:1", "--log", "new"],
            3,
            &["`khepera` is no way to reach a robot"],
        ),
        (&["--log", "new"], 2, &["--robot"]),
        (
            &["--robot", &robot, "--log", "new", "--severity", "1"],
            2,
            &["--severity"],
        ),
        (
            &["--robot", &robot, "--log", "new", "--walk", "601"],
            2,
            &["from 0 to 600"],
        ),
        (&["--robot", &robot, "--log", "new", "--traces", "t"], 2, &["--traces"]),
        (&["--robot", "tcp:127.0.0.1:9", "--log", "new"], 4, &["can't be opened"]),
        (
            &["--robot", &robot, "--log", "mine"],
            3,
            &["mine: exists and holds other files", "--log"],
        ),
        (
            &["--robot", &robot, "--log", "new", "--speed", "300"],
            3,
            &["the maximum speed is 300 mm/s, and the guard allows 200.0 mm/s"],
        ),
        (
            &["--robot", &robot, "--log", "new", "--sensor", "left_90=prox_5"],
            3,
            &["the Khepera has no sensor prox_5 of the kind proximity; allowed: left_90=proximity_left_90"],
        ),
        (
            &["--robot", &robot, "--log", "new", "--tracker", "udp:5005"],
            3,
            &["udp:HOST:PORT#ID"],
        ),
        (
            &["--robot", &robot, "--log", "new", "--tracker", "udp:127.0.0.1:0"],
            4,
            &["no sighting of robot 0 within 5 s"],
        ),
        (
            &["--robot", &robot, "--log", "new", "--guard", "expiry_ms=1"],
            3,
            &["guard expiry_ms: `1` is out of range"],
        ),
        (
            &["--robot", &robot, "--log", "new", "--between", "hand"],
            4,
            &["standard input is no terminal", "put the robot at x ="],
        ),
    ] {
        let own = ["evaluate", "short.toml", "--genomes", "genomes.csv"];
        place.run(&[&own, arguments].concat()).exits(code).says(words);
    }
    assert!(body.stands());
    // A surrogate takes the same command.
    let own = [
        "evaluate",
        "short.toml",
        "--genomes",
        "genomes.csv",
        "--robot",
        "surrogate:1",
    ];
    assert_eq!(place.good(&own).lines().count(), 3);
}
