//! `oneiro run` whose last generation lives on a robot on a wire, and disks that are full.

use std::fs;
use std::process::{Child, Command};

use serde_json::Value;

use super::*;
use crate::disk::Disk;
use crate::place::Ran;
use crate::robots;
use crate::skips;

/// Evolves for three generations, the last one on a robot.
fn placed(name: &str, robot: &str, cycles: u32) -> Place {
    let place = Place::new(name);
    // On a busy machine the robot answers late.
    let text = format!(
        "cycles = {cycles}\n[evolution]\npopulation = 4\nparents = 2\ngenerations = 3\n[record]\nindividuals = true\n\
         [reality]\nrobot = \"{robot}\"\ngenerations = 1\nwalk_s = 0\nguard = {{ link_ms = 400 }}\n"
    );
    place.write("wire.toml", text);
    place
}

pub(super) const RUN: [&str; 6] = ["run", "wire.toml", "--seed", "5", "--out", "out"];

/// Waits until a life has had some cycles.
pub(super) fn wait_for_cycles(place: &Place, life: &str, cycles: usize) {
    let path = place.at(life);
    wait(life, LONG, || {
        fs::read_to_string(&path).is_ok_and(|text| text.lines().count() > cycles)
    });
}

/// Asserts that the wheels come to stand within half a second of an event, and waits until the guard is gone.
pub(super) fn stops(place: &Place, body: &Body, address: &str, event: Instant) {
    wait("the stop", LONG, || body.stands());
    let took = body.wheels().1.saturating_duration_since(event);
    assert!(took < Duration::from_millis(500), "{took:?}");
    wait("the end of the guard", LONG, || {
        place.run(&["robot", "stop", address]).code == Some(0)
    });
}

pub(super) fn status(place: &Place, directory: &str) -> Vec<String> {
    let index = Table::read(place, &format!("{directory}/lives/lives.csv"));
    index.column("status").into_iter().map(str::to_owned).collect()
}

/// The fitness of the last generation, as bits in hex.
fn last_fitness(place: &Place, directory: &str) -> Vec<String> {
    let bytes = place.read(format!("{directory}/fitness.npy"));
    let numbers = bytes[bytes.len() - 16..].chunks_exact(4);
    numbers
        .map(|number| format!("{:08x}", u32::from_le_bytes(number.try_into().unwrap())))
        .collect()
}

/// What a run that ends on a robot leaves behind, and what the other commands make of it.
#[test]
fn a_run_ends_on_a_robot() {
    let body = Body::default();
    let address = robots::khepera(&body);
    let place = placed("run", &address, 10);
    let checked = place.good(&["check", "wire.toml"]);
    assert!(
        checked.contains("generation 2 is evaluated on serial:") && checked.contains(": 0.1 robot-minutes"),
        "{checked}"
    );
    let ran = place.run(&RUN).exits(0);
    ran.says(&["Khepera", "life-4.csv: fitness"]);
    assert!(body.stands());
    // Its fitness is that of its lives, in the order of the individuals.
    let lives = || Table::read(&place, "out/lives/lives.csv");
    let (all, index) = (lives().rows, lives().complete());
    assert_eq!(last_fitness(&place, "out"), index.column("bits"));
    assert_eq!(index.column("cycles"), ["10"; 4]);
    // With no time to drive about, each life begins where the last one has ended.
    let starts = lives().numbers("start_x_mm");
    for (life, start) in (1..).zip(&starts[1..]) {
        let ends = Table::read(&place, &format!("out/lives/life-{life}.csv")).numbers("x_mm");
        assert_eq!(ends.last(), Some(start));
    }
    let generations = Table::read(&place, "out/generations.csv");
    assert_eq!(generations.column("generation"), ["0", "1", "2"]);
    let best = index.numbers("fitness").into_iter().fold(f32::NAN, f32::max);
    assert_eq!(generations.numbers("best")[2].to_bits(), best.to_bits());
    let champion: Value = serde_json::from_str(&place.text("out/champion.json")).unwrap();
    assert_eq!(champion["generation"], 2);
    assert_eq!(champion["fitness_bits"], format!("{:08x}", best.to_bits()));
    assert!(!place.at("out/trace.csv").exists());
    let about = place.text("out/README.md");
    assert!(about.contains("| `lives` ") && !about.contains("replay"), "{about}");

    // Again: nothing is lived.
    let since = body.wheels().1;
    place.run(&RUN).exits(0);
    place.run(&["resume", "out"]).exits(0);
    assert_eq!((lives().rows, body.wheels().1), (all, since));
    place.run(&["verify", "out"]).exits(0).says(&["1 run is intact"]);
    assert!(place.good(&["list", "."]).contains("done"));
    // Two generations of four were simulated.
    let audited = place.good(&["verify", "--recompute", "out", "--fraction", "1"]);
    assert!(
        audited.contains("8 of 12 individuals audited, 0 with other bits"),
        "{audited}"
    );
    place.run(&["replay", "out"]).exits(3).says(&[
        "out: its champion was evaluated on a connected robot, and such an episode can't be repeated",
        "oneiro evaluate --genomes out",
    ]);
    assert!(place.good(&["evaluate", "--genomes", "out"]).lines().count() > 1);
    place.write("sweep.toml", "experiment = \"wire.toml\"\nseeds = [1, 2]\n");
    let refused = place.run(&["sweep", "run", "sweep.toml", "--out", "swept"]).exits(3);
    refused.says(&["reality.robot: is a connected robot; allowed: with `oneiro run`"]);
    assert!(!place.at("swept").exists());
    let plan = ["sweep", "plan", "sweep.toml", "--no-estimate"];
    let planned = place.good(&plan);
    // Two runs of four lives of a second.
    let words = "on robots: 0.1 robot-minutes; robots run no sweeps: start each run with `oneiro run`";
    assert!(planned.contains(words), "{planned}");
    let planned: Value = serde_json::from_str(&place.good(&[&plan[..], &["--json"]].concat())).unwrap();
    let minutes = |key: &str| planned[key].as_f64().unwrap();
    assert!((minutes("robot_minutes") - 8.0 / 60.0).abs() < 1e-9, "{planned}");
    assert_eq!(planned["robot_minutes"], planned["minutes_on_robots"]);
    assert_eq!(body.wheels().1, since);

    // Its lives calibrate the simulator.
    let calibrate = ["robot", "calibrate", "wire.toml", "--log", "out/lives", "--out"];
    let told = place.good(&[&calibrate[..], &["calibrated"]].concat());
    assert!(
        told.contains("4 episodes, 40 cycles") && told.contains("wheels turn at"),
        "{told}"
    );
    let told: Value = serde_json::from_str(&place.good(&[&calibrate[..], &["again", "--json"]].concat())).unwrap();
    assert_eq!((&told["episodes"], &told["cycles"]), (&4.into(), &40.into()));
    assert_eq!(told["sensors"].as_array().unwrap().len(), 8);
    for file in ["calibration.html", "errors.csv", "settings.toml"] {
        assert_eq!(
            place.read(format!("calibrated/{file}")),
            place.read(format!("again/{file}"))
        );
    }
    assert_eq!(Table::read(&place, "again/errors.csv").head[0], "sensor");
    place.run(&[&calibrate[..], &["again"]].concat()).exits(3);
    // They are no part of the results.
    fs::remove_dir_all(place.at("out/lives")).unwrap();
    place.run(&["verify", "out"]).exits(0);
}

/// Killed in the middle of a life, and stopped by Ctrl-C: the wheels stand, and no complete life is lived again.
#[test]
fn a_run_on_a_robot_goes_on() {
    let body = Body::default();
    let address = robots::khepera(&body);
    let place = placed("goes-on", &address, 15);
    let mut program = place.start(&RUN);
    wait_for_cycles(&place, "out/lives/life-2.csv", 8);
    let event = Instant::now();
    program.kill().unwrap();
    stops(&place, &body, &address, event);
    program.wait().unwrap();
    assert_eq!(status(&place, "out"), ["complete", "under way"]);
    let first = place.text("out/lives/life-1.csv");

    let program = place.start(&["resume", "out"]);
    // The third is the second one's other attempt.
    wait_for_cycles(&place, "out/lives/life-4.csv", 8);
    let event = Instant::now();
    let signal = ["-INT", &program.id().to_string()];
    Command::new("kill").args(signal).status().unwrap();
    wait("the stop", LONG, || body.stands());
    let took = body.wheels().1.saturating_duration_since(event);
    assert!(took < Duration::from_millis(500), "{took:?}");
    Ran::ended(&["resume"], program).exits(75).says(&["oneiro resume"]);
    let expected = ["complete", "the program ended", "complete", "stopped"];
    assert_eq!(status(&place, "out"), expected);
    assert!(place.good(&["list", "."]).contains("stopped"));

    place.run(&["resume", "out"]).exits(0);
    let expected = [&expected[..], &["complete"; 2]].concat();
    assert_eq!(status(&place, "out"), expected);
    assert!(body.stands());
    assert_eq!(place.text("out/lives/life-1.csv"), first);
    let index = Table::read(&place, "out/lives/lives.csv");
    let complete = [0, 2, 4, 5];
    let keys = index.column("key");
    assert_eq!((keys[1], keys[3]), (keys[2], keys[4]));
    assert_eq!(
        last_fitness(&place, "out"),
        complete.map(|life| index.column("bits")[life])
    );
    assert_eq!(Table::read(&place, "out/generations.csv").rows.len(), 3);
    place.run(&["verify", "out"]).exits(0);
}

/// The simulated generations are kept, and the run goes on once there is a robot.
#[test]
fn a_run_waits_for_its_robot() {
    let body = Body::default();
    let address = robots::khepera(&body);
    let place = placed("silent", &address, 5);
    body.is_deaf.store(true, Ordering::SeqCst);
    place
        .run(&RUN)
        .exits(4)
        .says(&["no e-puck, e-puck2 or Khepera answers at 38400 baud"]);
    assert_eq!(Table::read(&place, "out/generations.csv").rows.len(), 2);
    let list = place.good(&["list", "."]);
    assert!(list.contains("2/3"), "{list}");
    body.is_deaf.store(false, Ordering::SeqCst);
    let ran = place.run(&["resume", "out"]).exits(0);
    assert_eq!(ran.stderr.matches(": fitness").count(), 4);
    assert_eq!(Table::read(&place, "out/lives/lives.csv").complete().rows.len(), 4);
    let ran = place.run(&[&RUN[..5], &["hushed", "--quiet"]].concat()).exits(0);
    assert_eq!(ran.stderr, "");
    let other = ["--set", "reality.robot=\"tcp:127.0.0.1:9\"", "--out", "nobody"];
    place
        .run(&[&RUN[..4], &other].concat())
        .exits(4)
        .says(&["tcp:127.0.0.1:9: can't be opened"]);
    place
        .run(&["resume", "nobody"])
        .exits(4)
        .says(&["tcp:127.0.0.1:9: can't be opened"]);
}

/// A disk that is full in the middle of a life ends it: the wheels stand, and it is lived again once there is space.
#[test]
fn a_full_disk_stops_the_wheels() {
    let body = Body::default();
    let address = robots::khepera(&body);
    let place = placed("full", &address, 60);
    let Some(disk) = Disk::mounted(place.at("disk"), 2) else {
        skips::skipped("disk", "lives on a disk that is full: only root may mount a small one");
        return;
    };
    let line = |genes: &Vec<f32>| genes.iter().map(f32::to_string).collect::<Vec<_>>().join(",");
    place.write("one.csv", line(&genomes()[0]) + "\n");
    let evaluate = [
        "evaluate",
        "wire.toml",
        "--genomes",
        "one.csv",
        "--robot",
        &address,
        "--walk",
        "0",
        "--log",
        "disk/own/lives",
    ];
    fs::create_dir(place.at("disk/own")).unwrap();
    let run = [&RUN[..5], &["disk/out"]].concat();
    for (arguments, again, directory) in [
        (&evaluate[..], &evaluate[..], "disk/own"),
        (&run, &["resume", "disk/out"], "disk/out"),
    ] {
        let mut program = place.start(arguments);
        let table = format!("{directory}/lives/life-1.csv");
        wait_for_cycles(&place, &table, 5);
        disk.fill();
        // Cycles are recorded until the file's last page is full.
        let size = || fs::metadata(place.at(&table)).unwrap().len();
        let (mut last, mut grown) = (size(), Instant::now());
        wait("the end", LONG, || {
            if size() != last {
                (last, grown) = (size(), Instant::now());
            }
            program.try_wait().unwrap().is_some()
        });
        assert!(body.stands());
        // The next cycle could not be recorded, 100 ms later.
        let took = body.wheels().1.saturating_duration_since(grown);
        assert!(took < Duration::from_millis(100 + 500), "{took:?}");
        let ran = Ran::ended(arguments, program).exits(6);
        ran.says(&["life-1.csv", "No space left on device", "free some space"]);
        assert!(last < 60 * 100, "{last}");
        disk.free();
        place.run(again).exits(0);
        let status = status(&place, directory);
        assert_eq!(status[0], "the program ended");
        assert!(
            status.len() > 1 && status[1..].iter().all(|status| status == "complete"),
            "{status:?}"
        );
    }
}

/// Two busy loops for each processor.
struct Load(Vec<Child>);

impl Load {
    fn new() -> Self {
        let loops = 2 * thread::available_parallelism().unwrap().get();
        let busy = || Command::new("sh").args(["-c", "while :; do :; done"]).spawn().unwrap();
        Self((0..loops).map(|_| busy()).collect())
    }
}

impl Drop for Load {
    fn drop(&mut self) {
        for own in &mut self.0 {
            own.kill().unwrap();
            own.wait().unwrap();
        }
    }
}

/// How late commands are at 10 Hz: on this machine as it is; with `ONEIRO_LONG` in more lives, and with two busy loops for each
/// processor as well, without and with real-time priority. Half of them are sent within a cycle of their time.
#[test]
fn commands_come_in_time() {
    let is_long = std::env::var_os("ONEIRO_LONG").is_some();
    let (count, cases): (usize, &[_]) = if is_long {
        (10, &[(false, "0"), (false, "1"), (true, "0"), (true, "1")])
    } else {
        (1, &[(false, "1")])
    };
    for &(is_loaded, realtime) in cases {
        let body = Body::default();
        let address = robots::khepera_at(38_400, true, &body);
        let place = placed("late", &address, 50);
        let lines = (0..count).map(|_| genomes()[0].iter().map(f32::to_string).collect::<Vec<_>>().join(",") + "\n");
        place.write("some.csv", lines.collect::<String>());
        let load = is_loaded.then(Load::new);
        let own = [
            "evaluate",
            "wire.toml",
            "--genomes",
            "some.csv",
            "--trials",
            "2",
            "--robot",
            &address,
        ];
        let priority = format!("realtime={realtime}");
        let lives = ["--walk", "0", "--log", "out/lives", "--guard", &priority];
        fs::create_dir(place.at("out")).unwrap();
        place.run(&[&own[..], &lives].concat()).exits(0);
        drop(load);
        let status = status(&place, "out");
        let complete = Table::read(&place, "out/lives/lives.csv").complete();
        let table = |life| Table::read(&place, &format!("out/lives/life-{life}.csv"));
        let tables: Vec<_> = complete.column("life").into_iter().map(table).collect();
        let quantiles = |name: &str| {
            let mut all: Vec<f32> = tables.iter().flat_map(|table| table.numbers(name)).collect();
            all.sort_by(f32::total_cmp);
            let count = all.len();
            (count, all[count / 2], all[count * 99 / 100], all[count - 1])
        };
        eprintln!(
            "with load: {is_loaded}, {priority}; {} lives, {} complete",
            status.len(),
            tables.len()
        );
        assert!(tables.len() == 2 * count, "{status:?}");
        for name in ["late_ms", "age_ms"] {
            let (cycles, median, high, greatest) = quantiles(name);
            eprintln!("  {name}: {cycles} cycles, median {median}, 99 % {high}, greatest {greatest}");
            assert_eq!(cycles, 50 * tables.len());
            assert!(median < 100.0, "{name}: {median}");
        }
    }
}
