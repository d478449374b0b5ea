//! Twins of fleets: daemons as processes, each behind the real driver and guard of an emulated e-puck, live through faults on one virtual
//! clock. What they record depends on the script and the seed alone, wheels stand in time, and no interval is missing without a reason.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::place::Place;

/// Greatest time for which wheels may turn after a fault that leaves the link working, ms.
const LIMIT_MS: f64 = 500.0;

/// Writes the files of a fleet of `robots` robots with intervals of 20 s.
fn fleet(place: &Place, robots: u32, minutes: u32) {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments/odowd2014-over.toml");
    let values = format!(
        "[swarm]\nminutes = {minutes}\nlight_moves_minute = 0\nclock.interval_s = 20\nclock.installed_s = 10\n"
    );
    let text = fs::read_to_string(shipped).unwrap();
    let text = text
        .replace("[swarm]\n", &values)
        .replace("robots = 10", &format!("robots = {robots}"));
    place.write("experiment.toml", &text);
    place.good(&["fleet", "key", "experiment.key"]);
    let mut file = String::from(
        "experiment = \"experiment.toml\"\nseed = 5\nkey = \"experiment.key\"\noperator = \"10.0.0.1:4711\"\nbinary = \"oneiro\"\n\
         [tracker]\nlisten = \"0.0.0.0:5005\"\n",
    );
    for robot in 0..robots {
        writeln!(
            file,
            "[[robots]]\nnumber = {robot}\nhost = \"pi@10.0.1.{robot}\"\naddress = \"serial:/dev/rfcomm0\""
        )
        .unwrap();
    }
    place.write("fleet.toml", &file);
}

/// Lets the fleet's twin live, and returns what it says.
fn twin(place: &Place, out: &str, more: &[&str]) -> Value {
    let said = place.good(&[&["fleet", "twin", "fleet.toml", "--out", out, "--json"][..], more].concat());
    serde_json::from_str(&said).unwrap()
}

/// Rows of a table, by the names of its columns.
fn rows(text: &str) -> Vec<BTreeMap<&str, &str>> {
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    lines
        .map(|line| head.iter().copied().zip(line.split(',')).collect())
        .collect()
}

/// Asserts that wheels stood in time after each fault but those that hold the link itself.
fn stood_in_time(place: &Place, out: &str) {
    let text = place.text(format!("{out}/stops.csv"));
    for stop in rows(&text) {
        let stood: f64 = stop["stood_ms"].parse().unwrap_or(f64::INFINITY);
        match stop["fault"] {
            "kill" | "pause" | "operator" => assert!(stood <= LIMIT_MS, "{stop:?}"),
            // Until the line carries bytes again.
            "serial" => assert!(stood <= 1000.0 + LIMIT_MS, "{stop:?}"),
            other => assert_eq!(other, "clock"),
        }
    }
}

/// Asserts that every robot's table has all intervals that have ended, in order. Returns those that were missed.
fn missed(place: &Place, out: &str, robots: u32, ended: usize) -> Vec<(u32, usize)> {
    let mut missed = Vec::new();
    for robot in 0..robots {
        let text = place.text(format!("{out}/robots/{robot}/intervals.csv"));
        let rows = rows(&text);
        assert!(
            rows.len() >= ended,
            "robot {robot} has {} intervals of {ended}",
            rows.len()
        );
        for (interval, row) in rows.iter().enumerate() {
            assert_eq!(
                (row["interval"], row["robot"]),
                (&*interval.to_string(), &*robot.to_string())
            );
            if row["missed"] == "1" {
                missed.push((robot, interval));
            }
        }
    }
    missed
}

const PACKETS: &str = "seed = 2\n[[packets]]\nlatency_ms = [1.0, 20.0]\nlost = 0.3\nreordered = 0.1\nduplicated = 0.1\n\
                       corrupted = 0.05\nforged = 20.0\n";

#[test]
fn daemons_live_through_faults_the_same_at_any_speed() {
    let place = Place::new("twin-faults");
    fleet(&place, 4, 1);
    let faults = format!(
        "{PACKETS}[[kill]]\nrobots = [0]\nat_s = 25.35\nfor_s = 4.0\n[[pause]]\nrobots = [1]\nat_s = 27.15\nfor_s = 2.0\n\
         [[serial]]\nrobots = [2]\nat_s = 30.45\nfor_s = 1.0\n[[clock]]\nrobots = [3]\nat_s = 5.0\nppm = 300.0\n\
         [[operator]]\nat_s = 36.05\nfor_s = 2.0\n"
    );
    place.write("faults.toml", &faults);
    let fast = twin(&place, "fast", &["--faults", "faults.toml"]);
    let slow = twin(&place, "slow", &["--faults", "faults.toml", "--speed", "20"]);
    assert_eq!((&fast, fast["problems"].as_array().unwrap().len()), (&slow, 0));
    for name in ["twin.csv", "stops.csv", "faults.jsonl"] {
        assert!(
            place.read(format!("fast/{name}")) == place.read(format!("slow/{name}")),
            "{name}"
        );
    }
    stood_in_time(&place, "fast");
    assert_eq!(place.text("fast/stops.csv").lines().count(), 1 + 4 + 4);
    // Robot 0 was killed in its second interval. The others lost time, and no interval.
    let missed = missed(&place, "fast", 4, 2);
    assert!(
        !missed.is_empty() && missed.iter().all(|(robot, _)| *robot == 0),
        "{missed:?}"
    );
    // Another seed of the faults is another life.
    place.write("others.toml", faults.replace("seed = 2", "seed = 3"));
    let other = twin(&place, "other", &["--faults", "others.toml"]);
    assert_ne!(fast["hash"], other["hash"]);

    let said = place.good(&[
        "fleet",
        "compare",
        "fleet.toml",
        "fast",
        "other",
        "--seeds",
        "1..3",
        "--backend",
        "cpu",
        "--json",
    ]);
    let compared: Value = serde_json::from_str(&said).unwrap();
    let brought = |out: &str| {
        let of = |robot| {
            rows(&place.text(format!("{out}/robots/{robot}/intervals.csv")))
                .iter()
                .map(|row| row["brought"].parse::<f64>().unwrap())
                .sum::<f64>()
        };
        (0..4).map(of).sum::<f64>()
    };
    for (index, out) in ["fast", "other"].into_iter().enumerate() {
        let record = &compared["fleet"][index];
        assert!(record["food"].as_f64().unwrap() <= brought(out), "{record}");
        assert!((0.0..=1.0).contains(&record["right"].as_f64().unwrap()), "{record}");
    }
    assert_eq!(compared["batched"].as_array().unwrap().len(), 3);
    place
        .run(&["fleet", "compare", "fleet.toml", "."])
        .exits(3)
        .says(&["intervals.csv", "allowed"]);
    place.run(&["fleet", "twin", "fleet.toml", "--out", "fast"]).exits(3);
}

/// A hundred daemons are killed at random moments of a whole experiment, of whose datagrams a third is lost, and others come late, twice,
/// damaged or forged.
#[test]
#[ignore = "takes minutes: tests/long.sh"]
fn a_study_survives_a_hundred_kills() {
    let place = Place::new("twin-kills");
    fleet(&place, 10, 50);
    let kills = "[[kill]]\ntimes = 100\nfrom_s = 30.0\nto_s = 2900.0\nfor_s = 3.0\n";
    place.write("faults.toml", format!("{PACKETS}{kills}"));
    let outcome = twin(&place, "out", &["--faults", "faults.toml"]);
    assert_eq!(outcome["seconds"], 3000);
    stood_in_time(&place, "out");
    let mut killed = Vec::new();
    let faults = place.text("out/faults.jsonl");
    for line in faults.lines() {
        let line: Value = serde_json::from_str(line).unwrap();
        if line["fault"] == "kill" && line["outcome"] == "done" {
            killed.push((line["robot"].as_u64().unwrap() as u32, line["at_s"].as_f64().unwrap()));
        }
    }
    // A robot that is down can't be killed.
    assert!(killed.len() > 80, "{}", killed.len());
    let missed = missed(&place, "out", 10, 148);
    let reasons: BTreeSet<_> = missed
        .iter()
        .map(|(robot, interval)| {
            // It is down for 3 s, and switched on up to 5 s after the others.
            let seconds = (20 * *interval as i64 - 4)..(20 * *interval as i64 + 26);
            let reason = killed
                .iter()
                .position(|(other, at)| other == robot && seconds.contains(&(*at as i64)));
            reason.unwrap_or_else(|| panic!("robot {robot} missed interval {interval} without being killed"))
        })
        .collect();
    println!(
        "{} kills, {} intervals missed by {} of them; food {}",
        killed.len(),
        missed.len(),
        reasons.len(),
        outcome["brought"]
    );
    // One interval each at most, and one more where a robot was down at its end.
    assert!(missed.len() <= 2 * killed.len());
}

/// Resident memory of a process and of those that it has started, kB.
fn memory(process: u32) -> u64 {
    let read = |path: String| fs::read_to_string(path).unwrap_or_default();
    let children = read(format!("/proc/{process}/task/{process}/children"));
    let all = children.split_whitespace().filter_map(|child| child.parse().ok());
    let own = |process: u32| {
        let status = read(format!("/proc/{process}/status"));
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        line.and_then(|own| own.trim_end_matches("kB").trim().parse::<u64>().ok())
    };
    all.chain([process]).filter_map(own).sum()
}

/// Three robots live for a day: their memory stays as it was in the second quarter, and only tables grow that have a row for each
/// interval, and the arena's, which has one for each second.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "takes a quarter of an hour: tests/long.sh"]
fn a_day_takes_no_more_memory() {
    let place = Place::new("twin-day");
    fleet(&place, 3, 24 * 60);
    let mut twin = place.start(&["fleet", "twin", "fleet.toml", "--out", "out", "--json"]);
    let mut taken = Vec::new();
    let status = loop {
        if let Some(status) = twin.try_wait().unwrap() {
            break status;
        }
        taken.push(memory(twin.id()));
        std::thread::sleep(std::time::Duration::from_millis(500));
    };
    assert!(status.success());
    let quarter = taken.len() / 4;
    let most = |range: std::ops::Range<usize>| taken[range].iter().copied().max().unwrap_or_default();
    let (early, late) = (most(quarter..2 * quarter), most(3 * quarter..taken.len()));
    println!("{early} kB in the second quarter of the day, {late} kB in the last");
    assert!(late < early + early / 20, "{early} kB, and then {late} kB");
    // A row has some 200 bytes at most.
    let seconds = 24 * 3600;
    let limits = [
        ("out/twin.csv", 3 * seconds * 100),
        ("out/faults.jsonl", 1),
        ("out/stops.csv", 100),
    ];
    let intervals = (0..3).map(|robot| (format!("out/robots/{robot}/intervals.csv"), seconds / 20 * 200));
    let all = limits.map(|(name, limit)| (name.to_owned(), limit));
    for (name, limit) in all.into_iter().chain(intervals) {
        let length = place.read(&name).len() as u64;
        println!("{name}: {length} bytes");
        assert!(length <= limit, "{name}: {length} bytes, of {limit}");
    }
}
