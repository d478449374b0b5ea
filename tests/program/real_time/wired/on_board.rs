//! `oneiro on-board` of robots without a swarm, in real time.

use std::os::unix::net::UnixDatagram;
use std::process::Command;

use serde_json::Value;

use super::run::{self, stops};
use super::*;
use crate::peers::{EPuck2, Noise};
use crate::place::Ran;
use crate::robots;

const ON_BOARD: [&str; 2] = ["on-board", "robot.toml"];

/// A place with a daemon's file and its experiment of six generations.
fn placed(name: &str, address: &str, robot: &str, cycles: u32) -> Place {
    let place = Place::new(name);
    let experiment = format!("cycles = {cycles}\n[evolution]\npopulation = 20\nparents = 4\ngenerations = 6\n{robot}");
    place.write("experiment.toml", experiment);
    // On a busy machine the robot answers late.
    let file = format!(
        "experiment = \"experiment.toml\"\naddress = \"{address}\"\nseed = 3\ndirectory = \"state\"\n\
         [transfers]\ngenerations = 1\nagain_every = 4\nleast_lives = 2\nfinal_lives = 1\n\
         [lives]\nwalk_s = 0\n[guard]\nlink_ms = 400\n"
    );
    place.write("robot.toml", file);
    place
}

/// The simulator's part of the transfers: what is new there, by generation, individual and score.
fn proposed(place: &Place) -> Vec<[String; 3]> {
    let table = Table::read(place, "state/transfers.csv");
    let columns = ["why", "generation", "individual", "simulated"].map(|name| table.column(name));
    let [why, proposed @ ..] = columns;
    let rows = (0..why.len()).filter(|row| why[*row] == "new");
    rows.map(|row| proposed.each_ref().map(|column| column[row].to_owned()))
        .collect()
}

/// Each transfer has a life that is complete on record, in the same order and with the same fitness. Returns how many there are.
fn recorded(place: &Place) -> usize {
    let transfers = Table::read(place, "state/transfers.csv");
    let lives = Table::read(place, "state/lives/lives.csv").complete();
    let numbers: Vec<String> = (0..transfers.rows.len()).map(|number| number.to_string()).collect();
    assert_eq!(transfers.column("transfer"), numbers);
    assert_eq!(transfers.column("bits"), lives.column("bits"));
    lives.rows.len()
}

fn events(place: &Place, event: &str) -> Vec<Value> {
    let log = place.text("state/log.jsonl");
    let lines = log.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    lines.filter(|line| line["event"] == event).collect()
}

/// An e-puck2 on Wi-Fi, from start to end, under systemd.
#[test]
fn an_epuck2_evolves_on_board() {
    let robot = EPuck2::default();
    let address = robot.start();
    let walls = "[robot]\npreset = \"epuck\"\n[arena]\nwidth_mm = 900\nheight_mm = 900\n";
    let place = placed("epuck2", &address, walls, 30);
    let systemd = UnixDatagram::bind(place.at("notify")).unwrap();
    // A socket keeps only a few messages that nobody reads.
    let systemd = thread::spawn(move || {
        let (mut words, mut bytes) = (Vec::new(), [0; 256]);
        while !words.last().is_some_and(|own: &String| own.starts_with("STOPPING")) {
            let length = systemd.recv(&mut bytes).unwrap();
            words.push(String::from_utf8_lossy(&bytes[..length]).into_owned());
        }
        words
    });
    let mut command = place.command(&ON_BOARD);
    command.env("NOTIFY_SOCKET", place.at("notify"));
    let ran = Ran::new(&ON_BOARD, &command.output().unwrap()).exits(0);
    ran.says(&[
        "at least 7 episodes on the robot: 0.3 robot-minutes",
        "life-1.csv: fitness",
    ]);
    assert!(robot.0.stands());
    assert!(recorded(&place) >= 7);
    assert_eq!(proposed(&place).len(), 5, "one of six gave way to the best measured");
    let transfers = Table::read(&place, "state/transfers.csv");
    assert_eq!(transfers.column("why").last(), Some(&"final"));
    let words = systemd.join().unwrap();
    let count = |word: &str| words.iter().filter(|own| own.starts_with(word)).count();
    // Once a second of seven lives of 3 s.
    assert!(count("READY=1") == 1 && count("STOPPING=1") == 1, "{words:?}");
    assert!(
        count("WATCHDOG=1") >= 18 && count("STATUS=transfer 6: ") == 1,
        "{words:?}"
    );
    // The controller that the robot has gone back to lives in the simulator, too.
    let genomes = ["evaluate", "experiment.toml", "--genomes", "state/best.npy"];
    assert!(place.good(&genomes).lines().count() > 1);

    let lives = Table::read(&place, "state/lives/lives.csv");
    let greatest = |column: &str| lives.numbers(column).into_iter().fold(f32::NAN, f32::max);
    let sum = |key: &str| {
        let all = events(&place, "simulated");
        all.iter().map(|event| event[key].as_f64().unwrap()).sum::<f64>()
    };
    println!(
        "commands late by {} ms at most in the median of a life, and {} ms at 99 %; 6 generations of 20 in {:.3} s of work, {:.3} s",
        greatest("late_median_ms"),
        greatest("late_99_ms"),
        sum("worked_s"),
        sum("taken_s")
    );
}

/// How late commands are while the simulator works beside them, and while it does not, in lives of 20 s; and what it gets done.
#[test]
#[ignore = "a measurement in real time that takes two minutes: tests/long.sh runs it and prints its figures"]
fn evolution_beside_leaves_the_cycles_alone() {
    const GENERATIONS: f64 = 10_000.0;
    let body = Body::default();
    let address = robots::khepera(&body);
    let place = placed("beside", &address, "", 200);
    let edit = |file: &str, replaced: &[(&str, &str)]| {
        let text = replaced
            .iter()
            .fold(place.text(file), |text, (old, new)| text.replace(old, new));
        place.write(file, text);
    };
    let population = ("population = 20\nparents = 4", "population = 100\nparents = 20");
    edit(
        "experiment.toml",
        &[population, ("generations = 6", "generations = 30000")],
    );
    let lives = ("least_lives = 2", "least_lives = 1");
    edit("robot.toml", &[("generations = 1\n", "generations = 10000\n"), lives]);
    place.run(&ON_BOARD).exits(0);
    // The first two lives have the second and the third interval of the simulator beside them.
    assert_eq!(recorded(&place), 4);
    let evolved = events(&place, "simulated");
    for event in &evolved {
        let [worked, taken] = ["worked_s", "taken_s"].map(|key| event[key].as_f64().unwrap());
        // It rests for a quarter of the time that it works.
        assert!(worked <= 0.8 * taken + 0.02, "{event}");
        let [one, all] = [worked, taken].map(|seconds| GENERATIONS / seconds);
        println!("{GENERATIONS} generations in {taken:.1} s: {all:.0} a second, {one:.0} a second of work");
    }
    let table = Table::read(&place, "state/lives/lives.csv");
    let late = ["late_median_ms", "late_99_ms", "late_max_ms"].map(|name| table.numbers(name));
    for (life, beside) in ["beside it", "beside it", "alone", "alone"].into_iter().enumerate() {
        let [median, high, greatest] = late.each_ref().map(|column| column[life]);
        println!(
            "{beside}: commands late by {median:.2} ms (median), {high:.2} ms (99 %), {greatest:.2} ms (greatest)"
        );
    }
}

/// Killed at random moments, each time the wheels stand within half a second; it goes on, and nothing is missing or lived for another.
#[test]
fn a_daemon_that_is_killed_goes_on() {
    const KILLS: usize = 6;
    let body = Body::default();
    let address = robots::khepera(&body);
    let whole = placed("whole", &address, "", 10);
    whole.run(&ON_BOARD).exits(0);
    assert!(recorded(&whole) >= 7 && body.stands());

    let place = placed("killed", &address, "", 10);
    let mut noise = Noise::new();
    let mut kills = 0;
    while kills < KILLS {
        let mut daemon = place.start(&ON_BOARD);
        let before = events_of(&place, "connected");
        wait("the robot", LONG, || events_of(&place, "connected") > before);
        // Between a tenth of a second and two lives.
        let milliseconds = 100 + 7 * u64::from(noise.bytes(1)[0]);
        thread::sleep(Duration::from_millis(milliseconds));
        let event = Instant::now();
        daemon.kill().unwrap();
        if daemon.wait().unwrap().code().is_some() {
            break;
        }
        stops(&place, &body, &address, event);
        kills += 1;
    }
    assert!(kills >= 4, "it was over after {kills} kills");
    place.run(&ON_BOARD).exits(0);
    recorded(&place);
    assert!(body.stands());
    assert_eq!(proposed(&place), proposed(&whole));
    let lives = Table::read(&place, "state/lives/lives.csv");
    let cut = lives
        .column("status")
        .iter()
        .filter(|own| **own == "the program ended")
        .count();
    println!("{kills} kills, {cut} of them in a life");

    // Again: all is done. With a checkpoint that is damaged, nothing is begun anew.
    let since = body.wheels().1;
    place.run(&ON_BOARD).exits(0);
    assert_eq!(body.wheels().1, since);
    let mut checkpoint = place.read("state/checkpoint");
    checkpoint[40] ^= 1;
    place.write("state/checkpoint", checkpoint);
    place
        .run(&ON_BOARD)
        .exits(5)
        .says(&["state/checkpoint: is cut off or damaged"]);
    assert_eq!(body.wheels().1, since);
}

fn events_of(place: &Place, event: &str) -> usize {
    if place.at("state/log.jsonl").exists() {
        let log = place.text("state/log.jsonl");
        log.matches(&format!("\"event\":\"{event}\"")).count()
    } else {
        0
    }
}

/// `oneiro fleet` installs a robot that lives by itself on its computer, starts and stops it there, and collects its record. In place of
/// ssh a script runs all commands on this machine.
#[test]
fn a_fleet_has_robots_that_live_by_themselves() {
    let body = Body::default();
    let address = robots::khepera(&body);
    let place = placed("fleet", &address, "", 20);
    let there = place.at("host-1/oneiro/robot-1");
    std::fs::create_dir_all(place.at("host-1")).unwrap();
    // A small program of this machine.
    std::fs::copy("/bin/sh", place.at("program")).unwrap();
    let ssh = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fleet/ssh");
    let [ssh, own] = [ssh.canonicalize().unwrap(), place.at(".")].map(|path| path.display().to_string());
    let fleet = format!(
        "binary = \"program\"\nservice = \"process\"\ndirectory = \"record\"\n[ssh]\nprogram = \"{ssh}\"\n\
         options = [\"-F\", \"{own}\"]\n[[robots]]\nnumber = 1\nhost = \"host-1\"\nrobot = \"robot.toml\"\n"
    );
    place.write("fleet.toml", fleet);
    let told = |command: &str, words: &[&str]| {
        let ran = place.run(&["fleet", command, "fleet.toml"]).exits(0);
        for word in words {
            assert!(ran.stdout.contains(word), "{command}: no `{word}` in\n{}", ran.stdout);
        }
        ran
    };
    told("plan", &["at least 7 episodes on the robot", "directory = \"state\""]);
    told("deploy", &["sent oneiro, experiment.toml, robot.toml"]);
    std::fs::remove_file(there.join("oneiro")).unwrap();
    std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_oneiro"), there.join("oneiro")).unwrap();
    told("start", &[]).says(&["robots drive from now on, without a beacon", "robot 1: its daemon runs"]);
    run::wait_for_cycles(&place, "host-1/oneiro/robot-1/state/lives/life-1.csv", 8);
    told("status", &["running; last event `simulated`"]);
    told("stop", &["stopped, wheels confirmed"]);
    assert!(body.stands());
    told("status", &["stopped; last event `end`"]);
    told("collect", &[" files, "]).says(&["the records of 1 robot are in record"]);
    let lives = Table::read(&place, "record/robot-1/lives/lives.csv");
    assert_eq!(lives.column("status"), ["stopped"]);
    for command in ["compare", "replay"] {
        let refused = place.run(&["fleet", command, "fleet.toml"]).exits(3);
        refused.says(&["fleet.toml: its robots have no swarm's experiment"]);
    }
}

/// Ctrl-C and `systemctl stop`: the wheels stand, and the same command goes on. A second daemon is refused, and so is a robot that
/// is not there.
#[test]
fn a_daemon_is_stopped_by_a_signal() {
    let body = Body::default();
    let address = robots::khepera(&body);
    let place = placed("signal", &address, "", 40);
    let daemon = place.start(&ON_BOARD);
    run::wait_for_cycles(&place, "state/lives/life-1.csv", 8);
    place
        .run(&ON_BOARD)
        .exits(3)
        .says(&["state: another daemon is using this directory"]);
    let event = Instant::now();
    Command::new("kill")
        .args(["-TERM", &daemon.id().to_string()])
        .status()
        .unwrap();
    wait("the stop", LONG, || body.stands());
    let took = body.wheels().1.saturating_duration_since(event);
    assert!(took < Duration::from_millis(500), "{took:?}");
    Ran::ended(&ON_BOARD, daemon)
        .exits(75)
        .says(&["run the same command again to continue"]);
    body.is_deaf.store(true, Ordering::SeqCst);
    place
        .run(&ON_BOARD)
        .exits(4)
        .says(&["no e-puck, e-puck2 or Khepera answers"]);
    // What the robot lacks is refused at its place.
    body.is_deaf.store(false, Ordering::SeqCst);
    place.write(
        "experiment.toml",
        "[robot]\npreset = \"thymio2\"\n[arena]\nwidth_mm = 900\nheight_mm = 900\n",
    );
    place.write("robot.toml", place.text("robot.toml").replace("\"state\"", "\"other\""));
    place
        .run(&ON_BOARD)
        .exits(3)
        .says(&["robot.toml:2:11: address: Khepera has no sensors of ground"]);
    assert!(body.stands());
}
