//! Pictures on the floor, and walls of maps.

use std::fs;
use std::path::{Path, PathBuf};

use crate::place::Place;

fn experiments() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments")
}

/// A short run's settings.
const SHORT: [&str; 10] = [
    "--set",
    "evolution.generations=2",
    "--set",
    "evolution.population=6",
    "--set",
    "cycles=60",
    "--set",
    "trials=2",
    "--set",
    "evolution.finalist_lives=2",
];

/// Runs and sweeps need the picture only when they begin.
#[test]
fn runs_keep_the_picture_of_their_floor() {
    let place = Place::new("pictures");
    fs::create_dir(place.at("line-follower")).unwrap();
    for file in ["line-follower.toml", "line-follower/track.png"] {
        place.write(file, fs::read(experiments().join(file)).unwrap());
    }
    let checked = place.good(&["check", "line-follower.toml", "--out", "line.svg"]);
    assert!(checked.contains("a floor picture of 300 x 200 cells"), "{checked}");
    let drawn = place.text("line.svg");
    assert!(
        drawn.contains("shape-rendering=\"crispEdges\">\n<path d=\"M"),
        "{drawn}"
    );

    place.good(
        &[
            &["run", "line-follower.toml", "--seed", "1", "--out", "run"][..],
            &SHORT,
        ]
        .concat(),
    );
    place.write(
        "sides.toml",
        "name = \"sides\"\nexperiment = \"line-follower.toml\"\nseeds = \"1..2\"\n[set]\nevolution.generations = 1\nevolution.population = 4\n\
         cycles = 40\ntrials = 1\nevolution.finalist_lives = 2\n[grid]\narena.picture.cell_mm = [4.0, 20.0]\n",
    );
    place.good(&["sweep", "run", "sides.toml", "--out", "sweep"]);
    fs::remove_file(place.at("line-follower/track.png")).unwrap();
    place
        .run(&["check", "line-follower.toml"])
        .exits(3)
        .says(&["arena.picture.file", "track.png"]);
    assert_eq!(
        place.read("run/inputs/track.png"),
        fs::read(experiments().join("line-follower/track.png")).unwrap()
    );
    place.good(&["verify", "run", "--recompute", "--fraction", "1"]);
    place.good(&["replay", "run"]);
    let page = place.text("run/replay-0.html");
    assert!(
        page.contains("\"picture\":{") && page.contains("\"columns\":200,"),
        "no picture is in the page"
    );
    place.good(&[
        "evaluate",
        "--genomes",
        "run",
        "--trials",
        "2",
        "--seed",
        "3",
        "--summary",
    ]);
    place.good(&["verify", "sweep"]);
    place.good(&["sweep", "extract", "sweep", "0"]);

    // A copy that was changed is another floor.
    let mut changed = place.read("run/inputs/track.png");
    let last = changed.len() - 20;
    changed[last] ^= 1;
    place.write("run/inputs/track.png", changed);
    place.run(&["replay", "run"]).exits(3).says(&["track.png has changed"]);
}

#[test]
fn pictures_that_are_none_end_with_a_sentence() {
    let place = Place::new("no-pictures");
    place.write(
        "line-follower.toml",
        fs::read(experiments().join("line-follower.toml")).unwrap(),
    );
    let whole = fs::read(experiments().join("line-follower/track.png")).unwrap();
    fs::create_dir(place.at("line-follower")).unwrap();
    for (content, words) in [
        (&whole[..600], "track.png is no whole PNG: "),
        (
            b"GIF89a",
            "track.png is no picture that can be read; allowed: PNG, and PGM of the kinds P2 and P5",
        ),
        (
            b"P5 90000 90000 255 ",
            "track.png has 90000 x 90000 pixels; allowed: 1 to 16777216 in all",
        ),
    ] {
        place.write("line-follower/track.png", content);
        let place_of_key = "line-follower.toml:37:8: arena.picture.file: ";
        place
            .run(&["check", "line-follower.toml"])
            .exits(3)
            .says(&[place_of_key, words]);
        place
            .run(&["import", "line-follower/track.png", "--mm-per-pixel", "4"])
            .exits(3)
            .says(&[words]);
    }
}

#[test]
fn a_map_is_imported_checked_and_drawn() {
    let place = Place::new("maps");
    let map = experiments().join("map-maze/map.yaml");
    let said = place.good(&["import", map.to_str().unwrap(), "--out", "rooms.toml"]);
    assert!(said.contains("map.yaml:2: the robot: not taken: "), "{said}");
    place.good(&["check", "rooms.toml", "--out", "rooms.svg"]);
    let drawn = place.text("rooms.svg");
    assert!(drawn.matches("<line").count() > 20, "{drawn}");
    let picture = experiments().join("map-maze/map.png");
    let picture = picture.to_str().unwrap();
    place
        .run(&["import", picture])
        .exits(3)
        .says(&["lacks the size of its pixels; allowed: with --mm-per-pixel MM"]);
    place.good(&[
        "import",
        picture,
        "--mm-per-pixel",
        "10",
        "--threshold",
        "0.9",
        "--tolerance",
        "20",
        "--out",
        "rougher.toml",
    ]);
    place.good(&["check", "rougher.toml"]);
    place
        .run(&["import", map.to_str().unwrap(), "--threshold", "0.5"])
        .exits(3)
        .says(&[
            "--threshold: ",
            "is a map of ROS; allowed: with maps as pictures (.png, .pgm)",
        ]);
}
