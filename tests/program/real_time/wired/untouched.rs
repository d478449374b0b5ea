//! Refusals that need no robot come before one is touched: its wheels keep turning.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use super::*;
use crate::robots;

/// A daemon's file of a member of a swarm.
fn member(address: &str, key: &str, directory: &str, more: &str) -> String {
    format!(
        "experiment = \"swarm.toml\"\nrobot = 0\naddress = \"{address}\"\nkey = \"{key}\"\ndirectory = \"{directory}\"\n\
         [radio]\nlisten = \"127.0.0.1:0\"\npeers = [\"127.0.0.1:9\"]\n{more}"
    )
}

/// A command, what follows its file, the exit code, and what is said.
type Case<'a> = (&'a [&'a str], &'a [&'a str], i32, &'a [&'a str]);

/// All commands that connect to a robot, each with another mistake.
#[test]
fn what_is_wrong_beside_a_robot_does_not_touch_it() {
    let place = placed("untouched", 10);
    let body = Body::default();
    let address = robots::khepera(&body);
    let before = body.wheels().0;
    let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
    let taken = taken.local_addr().unwrap().to_string();
    place.write("swarm.toml", "[swarm]\nrobots = 2\nminutes = 1\n");
    for (key, mode) in [("private.key", 0o600), ("public.key", 0o644), ("group.key", 0o640)] {
        place.good(&["fleet", "key", key]);
        fs::set_permissions(place.at(key), fs::Permissions::from_mode(mode)).unwrap();
    }
    place.write("short.key", "00ff\n");
    fs::set_permissions(place.at("short.key"), fs::Permissions::from_mode(0o600)).unwrap();
    place.write("letter.txt", "mine");
    fs::create_dir(place.at("mine")).unwrap();
    place.write("mine/letter.txt", "mine");
    fs::create_dir_all(place.at("sampled/rows")).unwrap();
    place.write(
        "sampled/rows/wall-object.json",
        "\"Wall, 3 rows from 9 mm in steps of 9 mm\"",
    );
    fs::create_dir_all(place.at("damaged")).unwrap();
    place.write("damaged/checkpoint", "no checkpoint");
    let tracker = format!("[tracker]\nlisten = \"{taken}\"\n");
    for (name, text) in [
        ("public.toml", member(&address, "public.key", "state", "")),
        ("group.toml", member(&address, "group.key", "state", "")),
        ("short-key.toml", member(&address, "short.key", "state", "")),
        ("no-key.toml", member(&address, "no.key", "state", "")),
        ("file.toml", member(&address, "private.key", "letter.txt", "")),
        ("damaged.toml", member(&address, "private.key", "damaged", "")),
        ("tracked.toml", member(&address, "private.key", "state", &tracker)),
        (
            "guarded.toml",
            member(&address, "private.key", "state", "[guard]\nspeed_mm_s = 0\n"),
        ),
        (
            "alone.toml",
            format!("experiment = \"short.toml\"\naddress = \"{address}\"\ndirectory = \"letter.txt\"\n"),
        ),
        (
            "fast.toml",
            format!("cycles = 6\n[reality]\nrobot = \"{address}\"\ngenerations = 1\nspeed_mm_s = 300\n"),
        ),
    ] {
        place.write(name, text);
    }
    let evaluate = [
        "evaluate",
        "short.toml",
        "--genomes",
        "genomes.csv",
        "--robot",
        &address,
        "--log",
    ];
    let sample = ["robot", "sample", "--yes", "--robot", &address, "--out"];
    let udp = format!("udp:{taken}");
    let chmod = ["others than its owner can use this key", "chmod 600"];
    let cases: [Case<'_>; 25] = [
        (&["on-board"], &["public.toml"], 3, &chmod),
        (&["on-board"], &["group.toml"], 3, &chmod),
        (&["on-board"], &["short-key.toml"], 3, &["line 1: has 4 digits"]),
        (&["on-board"], &["no-key.toml"], 3, &["no.key"]),
        (&["on-board"], &["file.toml"], 6, &["letter.txt"]),
        (&["on-board"], &["damaged.toml"], 5, &["checkpoint"]),
        (&["on-board"], &["tracked.toml"], 3, &["tracker.listen"]),
        (&["on-board"], &["guarded.toml"], 3, &["speed_mm_s"]),
        (&["on-board"], &["alone.toml"], 6, &["letter.txt"]),
        (
            &evaluate,
            &["mine"],
            3,
            &[
                "mine: exists and holds other files",
                "name another directory with --log",
            ],
        ),
        (&evaluate, &["letter.txt"], 3, &["letter.txt"]),
        (&evaluate, &["new", "--tracker", &udp], 3, &["--tracker udp:", "in use"]),
        (
            &evaluate,
            &["new", "--speed", "300"],
            3,
            &["the guard allows 200.0 mm/s"],
        ),
        (&evaluate, &["new", "--guard", "expiry_ms=1"], 3, &["guard expiry_ms"]),
        (&evaluate, &["new", "--tracker", "udp:x"], 3, &["udp:HOST:PORT"]),
        (&sample, &["letter.txt"], 3, &["letter.txt: is a file"]),
        (&sample, &["sampled"], 3, &["has rows of `wall`"]),
        (
            &sample,
            &["new", "--full-speed", "250"],
            3,
            &["is more than the guard allows"],
        ),
        (&sample, &["new", "--guard", "speed=1"], 3, &["guard speed"]),
        (&sample, &["new", "--record", "letter.txt"], 3, &["exists already"]),
        (
            &["run", "fast.toml", "--out", "out"],
            &[],
            3,
            &["the guard allows 200.0 mm/s"],
        ),
        (
            &["reproduce", "miglino1995", "--robot", &address, "--out"],
            &["mine"],
            3,
            &["lacks --tables"],
        ),
        (
            &["robot", "watch", &address],
            &["--record", "letter.txt"],
            3,
            &["exists already"],
        ),
        (
            &["robot", "drive", &address],
            &["--commands", "letter.txt"],
            3,
            &["letter.txt: line 1"],
        ),
        (&["guard", &address], &["--guard", "speed_mm_s=0"], 3, &[]),
    ];
    for (command, more, code, words) in cases {
        let arguments = [command, more].concat();
        place.run(&arguments).exits(code).says(words);
        assert_eq!(body.wheels().0, before, "{arguments:?} has touched the robot");
    }
    // What is right does.
    place.good(&["robot", "stop", &address]);
    assert!(body.stands());
    assert!(Path::new(&place.at("letter.txt")).is_file());
}
