//! `oneiro robot sample` of described robots against the formulas of their sensors and wheels in double precision, and runs of robots made
//! from such tables.

use std::f64::consts::TAU;
use std::fs;

use oneiro::tables::{MotorSamples, SensorTable};

use crate::place::Place;

const RADIUS: f64 = 40.0;

/// Sensors: name, where they look, are and how far off, in turns and mm, and their range, mm. `nose` has the response below.
const SENSORS: [(&str, f64, Option<f64>, f64, f64); 4] = [
    ("nose", 0.0, None, 40.0, 60.0),
    ("left", 0.15, None, 38.0, 47.0),
    ("aside", -0.2, Some(-0.1), 30.0, 55.0),
    ("tail", 0.5, None, 10.0, 80.0),
];
const RESPONSE: [[f64; 2]; 3] = [[5.0, 1.0], [20.0, 0.3], [60.0, 0.1]];

/// An experiment with a robot that has these sensors, and others that no table holds.
fn robot(place: &Place) {
    let mut text = "[robot]
kind = \"differential\"
body_radius_mm = 40.0
wheel_base_mm = 60.0
greatest_speed_mm_s = 200.0
speeds = 21
acceleration_mm_s2 = 5000.0
latency_cycles = 1
battery_s = 60.0
sensors = [
    { name = \"floor\", kind = \"ground\" },
    { name = \"energy\", kind = \"battery\" },
"
    .to_owned();
    for (name, heading, bearing, offset, range) in SENSORS {
        let bearing = bearing.map_or_else(String::new, |bearing| format!("bearing_turns = {bearing:?}, "));
        let response = if name == "nose" {
            format!(", response = {RESPONSE:?}")
        } else {
            String::new()
        };
        let looks = format!("heading_turns = {heading:?}, {bearing}offset_mm = {offset:?}, range_mm = {range:?}");
        text += &["    { name = \"", name, "\", ", &looks, &response, " },\n"].concat();
    }
    place.write("own.toml", text + "]\n");
}

/// Distance along a ray to a wall or to a cylinder of 27.5 mm radius whose nearest point is this far ahead of the origin.
fn ray(class: &str, ahead: f64, [x, y]: [f64; 2], angle: f64) -> f64 {
    let (sine, cosine) = angle.sin_cos();
    if class == "wall" {
        let distance = (ahead - x) / cosine;
        return if cosine > 0.0 { distance } else { f64::INFINITY };
    }
    let (to_x, to_y) = (ahead + 27.5 - x, -y);
    let (along, across) = (to_x * cosine + to_y * sine, to_y * cosine - to_x * sine);
    if along > 0.0 && across.abs() < 27.5 {
        along - (27.5 * 27.5 - across * across).sqrt()
    } else {
        f64::INFINITY
    }
}

/// What a sensor reads at this distance.
fn read(name: &str, range: f64, distance: f64) -> f64 {
    if distance >= range {
        return 0.0;
    }
    if name != "nose" {
        return 1.0 - distance.max(0.0) / range;
    }
    match RESPONSE.iter().position(|[at, _]| *at > distance) {
        Some(0) => RESPONSE[0][1],
        Some(after) => {
            let [near, far] = [RESPONSE[after - 1], RESPONSE[after]];
            near[1] + (far[1] - near[1]) * (distance - near[0]) / (far[0] - near[0])
        }
        None => RESPONSE[2][1],
    }
}

/// In the middle of each cell a table has the reading of the formulas as an integer.
#[test]
fn tables_have_the_readings_of_the_formulas() {
    let place = Place::new("readings");
    robot(&place);
    let sample = ["robot", "sample", "--robot", "own.toml", "--backend", "cpu", "--out"];
    let said = place.run(&[&sample[..], &["tables", "--objects", "wall,round,block"]].concat());
    said.exits(0).says(&[
        "not sampled: floor, energy, since tables have readings by the distance and bearing of an object",
        "wrote 3 tables of 4 sensors and one of motors to tables; their columns: nose, left, aside, tail",
    ]);
    for class in ["wall", "round"] {
        let table = SensorTable::read(place.at(format!("tables/{class}.sam")))
            .unwrap()
            .table;
        // `nose` and `tail` reach 100 and 90 mm from the centre, so 60 mm from the rim.
        assert_eq!((table.sensors, table.rows, table.bearings), (4, 30, 180));
        assert_eq!((table.nearest, table.spacing, table.views), (0.0, 2.0, 1));
        let (mut hits, mut off) = ([0; 4], 0);
        for cell in 0..table.cells() {
            let ahead = RADIUS + 2.0 * ((cell / 180) as f64 + 0.5);
            // The object is at the heading 0.
            let heading = ((cell % 180) as f64 + 0.5) / 180.0;
            for (sensor, (name, looks, bearing, offset, range)) in SENSORS.into_iter().enumerate() {
                let place = TAU * (heading + bearing.unwrap_or(looks));
                let from = if bearing.is_some() { offset } else { 0.0 };
                let start = [from * place.cos(), from * place.sin()];
                // A ray begins at the centre unless the sensor is elsewhere than it looks.
                let free = ray(class, ahead, start, TAU * (heading + looks)) - (offset - from);
                let expected = 1023.0 * read(name, range, free);
                let found = f64::from(table.cell(cell)[sensor]);
                // At an edge a ray hits or misses.
                off += u32::from((found - expected).abs() > 0.52);
                hits[sensor] += u32::from(expected > 1.0);
            }
        }
        assert!(hits.iter().all(|hits| *hits > 100), "{class} {hits:?}");
        assert!(off <= 3, "{class}: {off}");
    }
    // From before the middle of its long side a block is a wall, and from all sides together it is less.
    let [wall, block] = ["wall", "block"].map(|class| {
        SensorTable::read(place.at(format!("tables/{class}.sam")))
            .unwrap()
            .table
    });
    assert_eq!((block.views, block.sensors), (8, 4));
    for (row, view) in (0..30).flat_map(|row| [3, 4].map(|view| (row, view))) {
        let [wall, block] = [wall.cell(row * 180)[0], block.cell((view * 30 + row) * 180)[0]];
        assert!(wall.abs_diff(block) <= 1, "{row} {view}: {wall} {block}");
    }
    let felt = |table: &SensorTable| {
        let cells = (0..table.cells()).filter(|cell| table.cell(*cell)[1] > 0);
        cells.count() as f64 / table.cells() as f64
    };
    assert!(felt(&block) < 0.95 * felt(&wall), "{} {}", felt(&block), felt(&wall));
    // On a GPU it is the same robot.
    if cfg!(feature = "gpu") {
        place.good(&[
            "robot",
            "sample",
            "--robot",
            "own.toml",
            "--backend",
            "gpu:0",
            "--out",
            "gpu",
        ]);
        for file in ["wall.sam", "round.sam", "motor.sam"] {
            assert!(
                place.read(format!("gpu/{file}")) == place.read(format!("tables/{file}")),
                "{file}"
            );
        }
    }
    // The program shows them.
    let shown = place.good(&["robot", "tables", "show", "tables/round.sam", "--out", "round.svg"]);
    assert!(shown.starts_with("round: 4 sensors, 30 distances from 0 mm"), "{shown}");
    assert!(place.text("round.svg").contains("Readings of 4 sensors"));
    place.good(&["robot", "tables", "convert", "tables/round.sam", "round.sample"]);
    let converted = SensorTable::read(place.at("round.sample")).unwrap();
    assert_eq!(
        converted.table,
        SensorTable::read(place.at("tables/round.sam")).unwrap().table
    );
}

/// Motors go along the arcs of their wheels once these are as fast as commanded.
#[test]
fn motors_are_those_of_the_wheels() {
    let place = Place::new("motors");
    robot(&place);
    place.good(&[
        "robot",
        "sample",
        "--robot",
        "own.toml",
        "--backend",
        "cpu",
        "--objects",
        "wall",
        "--out",
        "tables",
    ]);
    let motors = MotorSamples::read(place.at("tables/motor.sam")).unwrap();
    assert_eq!(motors.speeds, (-10..=10).collect::<Vec<_>>());
    for (pair, (degrees, centimetres)) in motors.degrees.iter().zip(&motors.centimetres).enumerate() {
        let [left, right] = [pair / 21, pair % 21].map(|index| 20.0 * (index as f64 - 10.0) / 10.0);
        let turn = (right - left) / 60.0;
        let way = 0.5 * (left + right);
        let chord = if turn == 0.0 {
            way
        } else {
            way * (turn / 2.0).sin() / (turn / 2.0)
        };
        assert!(
            (f64::from(*degrees) + turn * 360.0 / TAU).abs() < 1e-3,
            "{pair}: {degrees}"
        );
        assert!(
            (10.0 * f64::from(*centimetres) - chord).abs() < 1e-4,
            "{pair}: {centimetres}"
        );
    }
}

/// A robot made from the tables of another, and from its motors.
fn from_tables(place: &Place) {
    place.write(
        "twin.toml",
        "cycles = 120
evolution = { population = 10, parents = 2, generations = 3, finalists = 2, finalist_lives = 3 }
start = { kind = \"at\", x_mm = 300.0, y_mm = 120.0, heading_turns = 0.1 }
[noise]
sensor = [-0.05, 0.05]
motor = 0.1
[robot]
kind = \"differential\"
body_radius_mm = 40.0
tables = [\"tables/wall.sam\", \"tables/round.sam\", \"tables/block.sam\"]
motors = \"tables/motor.sam\"
states = \"evorobot\"
turn_before_move = 0.5
collision = \"slide\"
sensors = [
    { name = \"nose\", kind = \"sampled\" },
    { name = \"floor\", kind = \"ground\" },
    { name = \"tail\", kind = \"sampled\", column = 3 },
    { name = \"laser\", kind = \"distance\", range_mm = 300.0 },
    { name = \"aside\", kind = \"sampled\" },
]
[arena]
width_mm = 600.0
height_mm = 500.0
obstacles = [{ x_mm = 200.0, y_mm = 300.0, radius_mm = 27.5, class = \"round\" }]
blocks = [{ x_mm = 420.0, y_mm = 320.0, length_mm = 110.0, width_mm = 55.0, heading_turns = 0.1, class = \"block\" }]
",
    );
}

/// A run of such a robot is resumed, verified, replayed and repeated from the copies in its directory, and its files name its sensors.
#[test]
fn a_robot_made_from_tables_runs() {
    let place = Place::new("runs");
    robot(&place);
    let sample = [
        "robot",
        "sample",
        "--robot",
        "own.toml",
        "--backend",
        "cpu",
        "--objects",
        "wall,round,block",
    ];
    place.good(&[&sample[..], &["--out", "tables"]].concat());
    let refused = place.run(&[&sample[..], &["--severity", "1", "--out", "other"]].concat());
    refused.exits(2).says(&[
        "--severity 1: is given with --robot",
        "allowed: with --robot surrogate:SEED",
    ]);
    from_tables(&place);
    let checked = place.good(&["check", "twin.toml", "--out", "twin.svg"]);
    for line in [
        "robot       radius 40 mm, 21 x 21 motor states\n",
        "sensors     3 sampled (nose, tail, aside), 1 ground (floor), 1 distance (laser), \
         tables of 4 sensors for wall, round, block, 0 to 60 mm from the rim\n",
        "  nose_to_left\n",
    ] {
        assert!(checked.contains(line), "{checked}");
    }
    let run = ["--seed", "1", "--backend", "cpu", "--quiet", "--out"];
    place.good(&[&["run", "twin.toml"], &run[..], &["run"]].concat());
    #[cfg(unix)]
    {
        // Before its last file is written.
        place.good(&[&["run", "twin.toml"], &run[..], &["stopped"]].concat());
        fs::remove_file(place.at("stopped/DONE")).unwrap();
    }
    fs::remove_dir_all(place.at("tables")).unwrap();
    #[cfg(unix)]
    {
        place.good(&["resume", "stopped", "--backend", "cpu"]);
        assert!(place.read("stopped/champion.json") == place.read("run/champion.json"));
    }
    place.good(&["verify", "run"]);
    place.good(&["replay", "run", "--backend", "cpu", "--quiet"]);
    let config = place.text("run/config.toml");
    for line in [
        "tables = [\"inputs/wall.sam\", \"inputs/round.sam\", \"inputs/block.sam\"]\n",
        "motors = \"inputs/motor.sam\"\n",
        "column = 3\n",
        "\"inputs/motor.sam\" = \"",
    ] {
        assert!(config.contains(line), "{config}");
    }
    assert!(!config.contains("wheel_base_mm"), "{config}");
    place.good(&[&["run", "run/config.toml"], &run[..], &["again"]].concat());
    for file in ["generations.csv", "champion.json", "trace.csv"] {
        assert!(
            place.read(format!("run/{file}")) == place.read(format!("again/{file}")),
            "{file}"
        );
    }
    let trace = place.text("run/trace.csv");
    let head = trace.lines().next().unwrap();
    for column in ["sensor_nose", "real_tail", "sensor_laser"] {
        assert!(head.split(',').any(|name| name == column), "{head}");
    }
    assert!(
        place
            .text("run/README.md")
            .contains("the perceived reading of the sampled sensor `nose`, noise included"),
        "a line of its README"
    );
    // A table that has changed is another experiment.
    let changed = place.text("run/inputs/wall.sam").replacen("TURN 0\n", "TURN 1\n", 1);
    place.write("run/inputs/wall.sam", changed);
    place
        .run(&[&["run", "run/config.toml"], &run[..], &["changed"]].concat())
        .exits(3)
        .says(&["robot.tables[0]", "wall.sam has changed: its BLAKE3 hash is"]);
}

#[test]
fn what_cannot_be_is_refused() {
    let place = Place::new("refused");
    robot(&place);
    let sample = [
        "robot",
        "sample",
        "--backend",
        "cpu",
        "--objects",
        "wall,round",
        "--robot",
    ];
    place.good(&[&sample[..], &["own.toml", "--out", "tables"]].concat());
    place.good(&["robot", "tables", "export", "--builtin", "wall", "lamp.sam"]);
    place.write("tables/block.sam", place.text("tables/wall.sam"));
    from_tables(&place);
    for (change, words) in [
        (
            "robot.tables=[\"tables/wall.sam\",\"lamp.sam\"]",
            "robot.tables: lamp.sam: 8 sensors, 20 rows of 180 bearings, from 5 mm in steps of 2 mm, but tables/wall.sam has 4 sensors",
        ),
        (
            "robot.tables=[\"tables/wall.sam\",\"tables/round.sam\"]",
            "arena.blocks[0].class: no sensor table for `block`; allowed: wall, round",
        ),
        (
            "robot.tables=[]",
            "robot.tables: is empty; allowed: a file for each class",
        ),
        (
            "robot.wheel_base_mm=60",
            "robot.wheel_base_mm: is given; allowed: not with robot.motors",
        ),
        (
            "robot.speeds=5",
            "robot.speeds: is given; allowed: not with robot.motors",
        ),
        (
            "robot.acceleration_mm_s2=0.1",
            "robot.acceleration_mm_s2: is 0.1; allowed: 0, or at least 1",
        ),
        (
            "robot.body_radius_mm=9",
            "robot.motors: the maximum displacement of a cycle is",
        ),
        (
            "robot.kind=sampled",
            "robot.tables: is 4; allowed: 8, a Khepera's, or robot.kind = \"differential\"",
        ),
    ] {
        place
            .run(&["check", "twin.toml", "--set", change])
            .exits(3)
            .says(&[words]);
    }
    let twin = place.text("twin.toml");
    for (from, to, words) in [
        (
            "column = 3",
            "column = 4",
            "robot.sensors[2].column: is 4; allowed: 0 to 3, since the tables have 4",
        ),
        (
            "column = 3",
            "column = 0",
            "robot.sensors[2].column: is 0, the column of `nose`",
        ),
        (
            "column = 3",
            "range_mm = 3",
            "robot.sensors[2].range_mm: is given; allowed: not with kind = \"sampled\"",
        ),
        (
            "\"ground\"",
            "\"ground\", column = 1",
            "robot.sensors[1].column: is given; allowed: not with kind = \"ground\"",
        ),
        (
            "motors = \"tables/motor.sam\"\n",
            "",
            "robot.states: is given; allowed: only with robot.motors",
        ),
        (
            "motors = \"tables/motor.sam\"\nstates = \"evorobot\"\nturn_before_move = 0.5\n",
            "",
            "robot: lacks `wheel_base_mm`; allowed: `wheel_base_mm` and `greatest_speed_mm_s`, or sampled `motors`",
        ),
        (
            "tables = [\"tables/wall.sam\", \"tables/round.sam\", \"tables/block.sam\"]\n",
            "",
            "robot: lacks `tables`",
        ),
        ("\"tables/wall.sam\"", "\"tables/none.sam\"", "tables/none.sam"),
    ] {
        assert!(twin.contains(from), "{from}");
        place.write("bad.toml", twin.replacen(from, to, 1));
        place.run(&["check", "bad.toml"]).exits(3).says(&[words]);
    }
    // Tables of other numbers of sensors are no Khepera's.
    place.write(
        "khepera.toml",
        "[robot]\ntables = [\"tables/wall.sam\", \"tables/round.sam\"]\n",
    );
    place
        .run(&["check", "khepera.toml"])
        .exits(3)
        .says(&["robot.tables: is 4; allowed: 8, a Khepera's, or robot.kind = \"differential\" with 4 sensors"]);
    let bad = |text: &str, words: &str| {
        place.write("bad.toml", text);
        let ran = place.run(&[&sample[..], &["bad.toml", "--out", "bad"]].concat());
        ran.exits(3).says(&["--robot bad.toml", words]);
    };
    bad(
        "cycles = 5\n",
        "its robot.kind is `sampled`; allowed: an experiment with a parametric robot",
    );
    bad(&twin, "has no sensor of the kind proximity; allowed: one or more");
    let other = place.text("own.toml").replace("200.0", "100.0");
    place.write("other.toml", other);
    place
        .run(&[&sample[..], &["other.toml", "--out", "tables"]].concat())
        .exits(3)
        .says(&["holds samples of another robot"]);
}
