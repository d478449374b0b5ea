//! `oneiro run` and `oneiro evaluate` on three robots, whose readings never change, so that fitness depends on neither time nor robot.

use std::collections::BTreeSet;
use std::fs;
use std::process::{Child, Command};
use std::time::SystemTime;

use super::run::{RUN, status};
use super::*;
use crate::place::Ran;
use crate::robots;

/// Three Kheperas and their addresses.
fn three() -> ([Body; 3], [String; 3]) {
    let bodies = [(); 3].map(|()| Body::default());
    let addresses = bodies.each_ref().map(robots::khepera);
    (bodies, addresses)
}

/// Two generations of twelve, the last one on robots.
fn placed(name: &str, robots: &[String], cycles: u32) -> Place {
    let place = Place::new(name);
    // On a busy machine the robots answer late.
    let text = format!(
        "cycles = {cycles}\n[evolution]\npopulation = 12\nparents = 4\ngenerations = 2\n[reality]\nrobot = {robots:?}\n\
         generations = 1\nwalk_s = 0\nguard = {{ link_ms = 400, give_up_s = 5 }}\n"
    );
    place.write("wire.toml", text);
    place
}

/// Waits until one of the lives from a number on has had some cycles, and otherwise shows what the program has said.
fn lives_until(program: Child, place: &Place, life: usize, cycles: usize) -> Child {
    let has_lived = |life| {
        let text = fs::read_to_string(place.at(format!("out/lives/life-{life}.csv")));
        text.is_ok_and(|text| text.lines().count() > cycles)
    };
    let start = Instant::now();
    // On a busy machine one of them may be cut short.
    while !(life..life + 6).any(has_lived) {
        if start.elapsed() > LONG {
            let id = program.id().to_string();
            Command::new("kill").args(["-INT", &id]).status().unwrap();
            let ran = Ran::ended(&["run"], program);
            panic!("life {life} did not begin within {LONG:?}:\n{}", ran.stderr);
        }
        thread::sleep(Duration::from_millis(1));
    }
    program
}

/// Keys and genomes of the lives in a directory that are complete.
fn complete(place: &Place, directory: &str) -> Vec<(String, String)> {
    let index = Table::read(place, &format!("{directory}/lives.csv")).complete();
    let rows = index.column("key").into_iter().zip(index.column("genome"));
    rows.map(|(key, genome)| (key.to_owned(), genome.to_owned())).collect()
}

fn robots_of(place: &Place, directory: &str) -> BTreeSet<String> {
    let index = Table::read(place, &format!("{directory}/lives.csv"));
    index.column("robot").into_iter().map(str::to_owned).collect()
}

/// Seconds from the first cycle that was lived to the last.
fn took(place: &Place, directory: &str) -> f64 {
    let index = Table::read(place, &format!("{directory}/lives.csv"));
    let times = index.column("life").into_iter().map(|life| {
        let of = fs::metadata(place.at(format!("{directory}/life-{life}.csv"))).unwrap();
        [of.created().unwrap(), of.modified().unwrap()]
    });
    let all: Vec<[SystemTime; 2]> = times.collect();
    let begin = all.iter().map(|[begin, _]| *begin).min().unwrap();
    let end = all.iter().map(|[_, end]| *end).max().unwrap();
    end.duration_since(begin).unwrap().as_secs_f64()
}

/// Three robots live a generation in a third of the time that one takes, and evolution is the same.
#[test]
fn three_robots_take_a_third_of_the_time() {
    let (bodies, addresses) = three();
    let mut took_s = [0.0; 2];
    let mut outcomes = Vec::new();
    for (at, robots) in [&addresses[..1], &addresses[..]].into_iter().enumerate() {
        let place = placed(&format!("third-{at}"), robots, 15);
        let checked = place.good(&["check", "wire.toml"]);
        let time = ["0.3 robot-minutes\n", "0.3 robot-minutes, 0.1 minutes with 3 robots\n"][at];
        assert!(checked.contains(time), "{checked}");
        let ran = place.run(&RUN).exits(0);
        assert!(bodies[..robots.len()].iter().all(Body::stands));
        let all = complete(&place, "out/lives");
        assert_eq!(
            (all.len(), all.iter().collect::<BTreeSet<_>>().len()),
            (12, 12),
            "{}",
            ran.stderr
        );
        assert_eq!(robots_of(&place, "out/lives").len(), robots.len());
        let files = ["fitness.npy", "individuals.npy", "generations.csv", "champion.npy"];
        outcomes.push(files.map(|file| place.read(format!("out/{file}"))));
        took_s[at] = took(&place, "out/lives");
        place.run(&["verify", "out"]).exits(0);
    }
    eprintln!(
        "one robot {:.2} s, three robots {:.2} s: {:.3} of it",
        took_s[0],
        took_s[1],
        took_s[1] / took_s[0]
    );
    // On a machine with nothing else to do it is a third.
    assert!(took_s[1] < 0.6 * took_s[0], "{took_s:?}");
    assert!(took_s[0] > 12.0 * 1.5, "{took_s:?}");
    assert!(outcomes[0] == outcomes[1]);
}

/// Killed while all three live: their wheels stand, and no life that was complete is lived again.
#[test]
fn no_life_of_three_robots_is_lived_again() {
    let (bodies, addresses) = three();
    let place = placed("again", &addresses, 15);
    // The fifth is a second one of some robot's.
    let mut program = lives_until(place.start(&RUN), &place, 5, 8);
    wait("a complete life", LONG, || !complete(&place, "out/lives").is_empty());
    let event = Instant::now();
    program.kill().unwrap();
    wait("the stop", LONG, || bodies.iter().all(Body::stands));
    for body in &bodies {
        let took = body.wheels().1.saturating_duration_since(event);
        assert!(took < Duration::from_millis(500), "{took:?}");
    }
    program.wait().unwrap();
    let before = complete(&place, "out/lives");
    assert!((1..6).contains(&before.len()), "{before:?}");
    let tables = |count: usize| (1..=count).map(|life| place.text(format!("out/lives/life-{life}.csv")));
    let lived = Table::read(&place, "out/lives/lives.csv").rows.len();
    let kept: Vec<String> = tables(lived).collect();
    for address in &addresses {
        wait("the end of the guard", LONG, || {
            place.run(&["robot", "stop", address]).code == Some(0)
        });
    }

    let program = lives_until(place.start(&["resume", "out"]), &place, lived + 2, 8);
    let event = Instant::now();
    let signal = ["-INT", &program.id().to_string()];
    Command::new("kill").args(signal).status().unwrap();
    wait("the stop", LONG, || bodies.iter().all(Body::stands));
    for body in &bodies {
        let took = body.wheels().1.saturating_duration_since(event);
        assert!(took < Duration::from_millis(500), "{took:?}");
    }
    Ran::ended(&["resume"], program).exits(75).says(&["oneiro resume"]);

    place.run(&["resume", "out"]).exits(0);
    let after = complete(&place, "out/lives");
    assert_eq!(
        (after.len(), after.iter().collect::<BTreeSet<_>>().len()),
        (12, 12),
        "{after:?}"
    );
    assert!(before.iter().all(|life| after.contains(life)));
    assert!(tables(lived).eq(kept));
    let status = status(&place, "out");
    let cut = |reason: &str| status.iter().filter(|status| *status == reason).count();
    assert!((1..=3).contains(&cut("the program ended")), "{status:?}");
    assert!((1..=3).contains(&cut("stopped")), "{status:?}");
    place.run(&["verify", "out"]).exits(0);
}

/// A robot that falls silent in the middle of its life is set aside, and the others live that life and all that are left.
#[test]
fn the_life_of_a_robot_that_falls_silent_goes_to_another() {
    let (bodies, addresses) = three();
    let place = placed("silent-one", &addresses, 15);
    let program = lives_until(place.start(&RUN), &place, 3, 5);
    bodies[1].is_deaf.store(true, Ordering::SeqCst);
    let ran = Ran::ended(&RUN, program).exits(0);
    let set_aside = format!("{}: ", addresses[1]);
    let said: Vec<&str> = ran.stderr.lines().filter(|line| line.starts_with(&set_aside)).collect();
    assert!(
        said.iter()
            .any(|line| line.contains("set aside; the next free robot takes its episode")),
        "{}",
        ran.stderr
    );
    // It could not be stopped, and that is the last that is said of it.
    assert!(said.iter().any(|line| line.contains("cannot stop")), "{}", ran.stderr);
    let all = complete(&place, "out/lives");
    assert_eq!(
        (all.len(), all.iter().collect::<BTreeSet<_>>().len()),
        (12, 12),
        "{}",
        ran.stderr
    );
    let index = Table::read(&place, "out/lives/lives.csv");
    let rows = index
        .column("robot")
        .into_iter()
        .zip(index.column("key"))
        .zip(index.column("status"));
    let rows: Vec<_> = rows.collect();
    let ((_, key), _) = rows
        .iter()
        .find(|((robot, _), status)| *robot == addresses[1] && *status != "complete")
        .unwrap();
    let ((heir, _), _) = rows
        .iter()
        .find(|((_, own), status)| own == key && *status == "complete")
        .unwrap();
    assert_ne!(*heir, addresses[1]);

    // None but that one: nothing to live on.
    let alone = placed("silent-all", &addresses[1..2], 15);
    alone.run(&RUN).exits(4);
    // One that is not there from the beginning is left out.
    let some = placed("silent-some", &addresses[..2], 5);
    let ran = some.run(&RUN).exits(0);
    ran.says(&[&format!("{}: takes no episodes: ", addresses[1])]);
    assert_eq!(robots_of(&some, "out/lives"), [addresses[0].clone()].into());
    let mad = [
        "--set",
        "reality.robot=[\"tcp:127.0.0.1:9\", \"tcp:127.0.0.1:10\"]",
        "--out",
        "nobody",
    ];
    some.run(&[&RUN[..4], &mad].concat())
        .exits(4)
        .says(&["can't be opened"]);
}

/// `oneiro evaluate` on three robots prints what one gives.
#[test]
fn genomes_are_evaluated_on_three_robots() {
    let (bodies, addresses) = three();
    let place = super::placed("evaluated", 10);
    let more = [
        "--robot",
        &addresses[1],
        "--robot",
        &addresses[2],
        "--guard",
        "link_ms=400",
    ];
    let arguments = arguments(&addresses[0], &more);
    let ran = place.run(&arguments).exits(0);
    let ran = ran.says(&[
        "4 episodes of 1 s, each after 0.5 s of driving about: 0.1 robot-minutes, 0.1 minutes with 3 robots",
        "episode 4 of 4: ",
    ]);
    assert!(bodies.iter().all(Body::stands));
    assert_eq!(robots_of(&place, "lives").len(), 3);
    let one = super::arguments(&addresses[0], &["--log", "others"]);
    let one: Vec<&str> = one.into_iter().filter(|word| *word != "lives").collect();
    let at = one.iter().position(|word| *word == "--log").unwrap();
    let alone = place.run(&[&one[..at], &one[at + 1..]].concat()).exits(0);
    assert_eq!(alone.stdout, ran.stdout);
    for (more, words) in [
        (&["--robot", &*addresses[0]][..], "twice; allowed: each robot once"),
        (&["--robot", "surrogate:1"], "names surrogate:1 with other robots"),
        (
            &["--robot", &*addresses[1], "--tracker", "udp:127.0.0.1:5005#1"],
            "there are 2 robots and 1 trackers; allowed: a tracker for each robot",
        ),
    ] {
        place
            .run(&super::arguments(&addresses[0], more))
            .exits(3)
            .says(&[words]);
    }
}

/// Where somebody puts the robots, each waits for its own number.
#[test]
fn a_person_confirms_each_robot_by_its_number() {
    let (bodies, addresses) = three();
    let place = super::placed("numbers", 5);
    let (mut terminal, slave) = serialport::TTYPort::pair().unwrap();
    let input = File::options().read(true).write(true).open(slave.name().unwrap());
    let more = ["--between", "hand", "--robot", &addresses[1], "--guard", "link_ms=400"];
    let mut command = place.command(&arguments(&addresses[0], &more));
    let command = command
        .stdin(input.unwrap())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let program = command.spawn().unwrap();
    let count = || {
        let has_begun = place.at("lives/lives.csv").exists();
        if has_begun { complete(&place, "lives").len() } else { 0 }
    };
    let mut types = |line: &str| {
        terminal.write_all(line.as_bytes()).unwrap();
        thread::sleep(Duration::from_millis(200));
    };
    // The second robot has a life, and waits for its number; the first one has all others.
    wait("three lives", LONG, || {
        types("1\n");
        count() == 3
    });
    for line in ["\n", "1\n", "3\n", "12\n"] {
        types(line);
    }
    assert_eq!(count(), 3);
    assert_eq!(robots_of(&place, "lives"), [addresses[0].clone()].into());
    assert!(bodies[1].stands());
    wait("the last life", LONG, || {
        types("2\n");
        count() == 4
    });
    let ran = Ran::new(&["evaluate"], &program.wait_with_output().unwrap()).exits(0);
    ran.says(&[
        &format!("{}: put the robot at x = ", addresses[0]),
        "; then type 1 and press Enter",
        &format!("{}: put the robot at x = ", addresses[1]),
        "; then type 2 and press Enter",
    ]);
    assert_eq!(robots_of(&place, "lives").len(), 2);
}
