//! Robots that an experiment describes: those of docs/robots.md, and that of `kheperax.toml` beside Kheperax's rules, written
//! again in double precision from their description alone.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};
use std::fmt::Write;
use std::path::Path;

use oneiro::random::pcg4d;

use crate::place::Place;

const GENES: usize = 66;
const POLICIES: usize = 200;

/// Walls, in sides of the maze.
const WALLS: [[[f64; 2]; 2]; 13] = [
    [[0.0, 0.0], [1.0, 0.0]],
    [[0.0, 0.0], [0.0, 1.0]],
    [[0.0, 1.0], [1.0, 1.0]],
    [[1.0, 1.0], [1.0, 0.0]],
    [[0.25, 0.25], [0.25, 0.75]],
    [[0.14, 0.45], [0.0, 0.65]],
    [[0.25, 0.75], [0.0, 0.8]],
    [[0.25, 0.75], [0.66, 0.875]],
    [[0.355, 0.0], [0.525, 0.185]],
    [[0.25, 0.5], [0.75, 0.215]],
    [[1.0, 0.25], [0.435, 0.55]],
    [[0.0, 0.8], [0.0, 1.0]],
    [[0.355, 0.0], [1.0, 0.0]],
];

/// A policy's genes: first weights from -sqrt(3 / inputs) to that, biases 0.
fn policy(number: usize) -> Vec<f32> {
    let uniform = |gene: usize, inputs: f64| {
        let [word, ..] = pcg4d([number as u32, gene as u32, 4, 2]);
        ((f64::from(word) / f64::from(u32::MAX) * 2.0 - 1.0) * (3.0 / inputs).sqrt()) as f32
    };
    let gene = |gene: usize| match (gene, gene % 8) {
        (64.., _) | (_, 5) => 0.0,
        (_, 0..5) => uniform(gene, 5.0),
        _ => uniform(gene, 8.0),
    };
    (0..GENES).map(gene).collect()
}

/// Distance and direction from a point to the nearest point of a wall.
fn nearest([x, y]: [f64; 2], [from, to]: [[f64; 2]; 2]) -> (f64, f64) {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let share = (((x - from[0]) * dx + (y - from[1]) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
    let (px, py) = (from[0] + share * dx - x, from[1] + share * dy - y);
    (px.hypot(py), py.atan2(px))
}

/// A laser's reading; -1 if no wall is within 0.2. Touching the end of a wall is a hit.
fn laser([x, y]: [f64; 2], angle: f64) -> f64 {
    const END: f64 = 1e-6;
    let (cosine, sine) = (angle.cos(), angle.sin());
    let hit = |[from, to]: &[[f64; 2]; 2]| {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let across = cosine * dy - sine * dx;
        let distance = ((from[0] - x) * dy - (from[1] - y) * dx) / across;
        let share = ((from[0] - x) * sine - (from[1] - y) * cosine) / across;
        let is_hit = (0.0..=0.2).contains(&distance) && (-END..=1.0 + END).contains(&share);
        is_hit.then_some(distance)
    };
    WALLS.iter().filter_map(hit).min_by(f64::total_cmp).unwrap_or(-1.0)
}

/// Right and left bumper: 1 while a wall touches the body on that side in front, else -1.
fn bumpers(at: [f64; 2], angle: f64) -> [f64; 2] {
    let mut pressed = [-1.0; 2];
    for wall in WALLS {
        let (distance, direction) = nearest(at, wall);
        let off = (direction - angle + PI).rem_euclid(TAU) - PI;
        if distance < 0.015 {
            if off <= 0.0 && off > -FRAC_PI_2 {
                pressed[0] = 1.0;
            }
            if (0.0..FRAC_PI_2).contains(&off) {
                pressed[1] = 1.0;
            }
        }
    }
    pressed
}

/// A life of 250 steps: where it ends, its fitness without a target, and whether it ended at a wall.
fn lived(genes: &[f32]) -> ([f64; 2], f64, bool) {
    let gene = |index: usize| f64::from(genes[index]);
    let ([mut x, mut y], mut angle, mut fitness) = ([0.15, 0.15], FRAC_PI_2, 0.0);
    let mut touched = bumpers([x, y], angle);
    let mut hit = false;
    for _ in 0..250 {
        let lasers = [-FRAC_PI_4, 0.0, FRAC_PI_4].map(|side| laser([x, y], angle + side));
        let inputs = [lasers[0], lasers[1], lasers[2], touched[0], touched[1]];
        let mut outputs = [gene(64), gene(65)];
        for unit in 0..8 {
            let sum: f64 = (0..5).map(|input| gene(8 * unit + input) * inputs[input]).sum();
            let value = (sum + gene(8 * unit + 5)).max(0.0);
            outputs[0] += gene(8 * unit + 6) * value;
            outputs[1] += gene(8 * unit + 7) * value;
        }
        let [left, right] = outputs.map(|output| 0.025 * output.tanh());
        fitness -= left * left + right * right;
        touched = bumpers([x, y], angle);
        hit = WALLS.iter().any(|wall| nearest([x, y], *wall).0 <= 0.015);
        if !hit {
            let turn = (right - left) / 0.03;
            let chord = 0.5
                * (left + right)
                * if turn == 0.0 {
                    1.0
                } else {
                    (0.5 * turn).sin() / (0.5 * turn)
                };
            x += chord * (angle + 0.5 * turn).cos();
            y += chord * (angle + 0.5 * turn).sin();
            angle += turn;
        }
    }
    ([x, y], fitness, hit)
}

/// An example of the page, by its number, with little evolution.
fn example(number: usize) -> String {
    let page = include_str!("../../docs/robots.md");
    let block = page.split("```toml\n").nth(1 + number);
    let text = block.and_then(|rest| rest.split("```").next()).unwrap();
    format!("evolution.generations = 3\nevolution.population = 20\nevolution.parents = 4\n{text}")
}

/// Runs an experiment with the seed 1, and returns its champion's trace.
fn traced(place: &Place, experiment: &str, out: &str) -> String {
    place.evolved(experiment, "1", out, &[]);
    place.good(&["verify", out]);
    place.text(format!("{out}/trace.csv"))
}

/// A column of a trace.
fn column(trace: &str, name: &str) -> Vec<f64> {
    let mut lines = trace.lines();
    let at = lines.next().unwrap().split(',').position(|column| column == name);
    let at = at.unwrap_or_else(|| panic!("no column {name}"));
    lines
        .map(|line| line.split(',').nth(at).unwrap().parse().unwrap())
        .collect()
}

/// The page's robots by name: `oneiro check` lists the sensors that the page lists, and each of them runs.
#[test]
fn robots_by_name_run() {
    let place = Place::new("named-robots");
    let room = "arena.width_mm = 1000\narena.height_mm = 1000\nevolution.generations = 2\nevolution.population = 10\nevolution.parents = 2";
    for (name, robot, count, sensors) in [
        (
            "khepera",
            "khepera, radius 28.5 mm, wheels 52 mm apart, up to 82 mm/s",
            8,
            "8 proximity (left_90, left_45, left_10, right_10, right_45, right_90, back_right, back_left)",
        ),
        (
            "epuck",
            "epuck, radius 35 mm, wheels 53 mm apart, up to 128.8 mm/s",
            19,
            "8 proximity (prox_0, prox_1, prox_2, prox_3, prox_4, prox_5, prox_6, prox_7), \
             8 light (light_0, light_1, light_2, light_3, light_4, light_5, light_6, light_7), \
             3 ground (ground_left, ground_centre, ground_right)",
        ),
        (
            "thymio2",
            "thymio2, radius 80 mm, wheels 94 mm apart, up to 166 mm/s",
            9,
            "7 proximity (prox_0, prox_1, prox_2, prox_3, prox_4, prox_5, prox_6), 2 ground (ground_left, ground_right)",
        ),
        (
            "kheperax",
            "kheperax, radius 15 mm, wheels 30 mm apart, up to 250 mm/s",
            5,
            "3 distance (right, ahead, left), 2 bumper (bump_right, bump_left)",
        ),
    ] {
        let page = include_str!("../../docs/robots.md");
        assert!(page.contains(&format!("| `{name}` |")), "{name}");
        let file = format!("{name}.toml");
        place.write(&file, format!("{room}\nrobot.preset = \"{name}\"\n"));
        let checked = place.good(&["check", &file]);
        assert!(checked.contains(&format!("  robot       {robot}\n")), "{checked}");
        assert!(checked.contains(&format!("  sensors     {sensors}\n")), "{checked}");
        let trace = traced(&place, &file, name);
        let head = trace.lines().next().unwrap();
        let found = head.split(',').filter(|column| column.starts_with("sensor_")).count();
        assert_eq!(found, count, "{head}");
        let config = place.text(format!("{name}/config.toml"));
        assert!(
            !config.contains("preset") && config.contains("wheel_base_mm"),
            "{config}"
        );
    }
}

/// The page's e-puck obeys late and slowly, and sees its lamp.
#[test]
fn the_pages_epuck_runs() {
    let place = Place::new("page-epuck");
    place.write("slow.toml", example(1));
    let checked = place.good(&["check", "slow.toml"]);
    let robot =
        "epuck, radius 35 mm, wheels 53 mm apart, up to 80 mm/s, accelerates by up to 400 mm/s^2, obeys 1 cycle late";
    assert!(
        checked.contains(robot) && checked.contains("light_7_to_right"),
        "{checked}"
    );
    let trace = traced(&place, "slow.toml", "run");
    let [left, before] = ["speed_left", "output_left"].map(|name| column(&trace, name));
    // Half of what 400 mm/s^2 add in a cycle, of 80 mm/s.
    assert_eq!(left[0], 0.0);
    assert!(
        left[1].abs() <= 0.25 + 1e-6 && (before[0] != 0.5) == (left[1] != 0.0),
        "{}",
        left[1]
    );
    let change = left.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    assert!(change.fold(0.0, f64::max) <= 0.5 + 1e-6);
    let light = column(&trace, "real_light_0");
    assert!(light.iter().any(|reading| *reading > 0.0));
    place.good(&["replay", "run", "--backend", "cpu", "--quiet"]);
}

/// The page's robot with a battery lives until it is empty, or as long as it charges.
#[test]
fn the_pages_battery_empties() {
    let place = Place::new("page-battery");
    place.write(
        "battery.toml",
        example(2).replace("battery_s = 60.0", "battery_s = 3.0"),
    );
    let checked = place.good(&["check", "battery.toml"]);
    assert!(
        checked.contains("up to 166 mm/s, a battery of 3 s, which ends the episode when empty"),
        "{checked}"
    );
    let trace = traced(&place, "battery.toml", "run");
    let energy = column(&trace, "real_energy");
    assert!(energy.len() >= 30, "{}", energy.len());
    for pair in energy.windows(2) {
        let fallen = pair[0] - pair[1];
        assert!((fallen - 1.0 / 30.0).abs() < 1e-5 || pair[1] == 1.0, "{pair:?}");
    }
    assert!(energy.iter().all(|charge| *charge > 0.0));
    // A task of the user's own is rewarded by the reading's name.
    place.write(
        "energy.wgsl",
        "fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
            return Reward(now.real.energy, before);
        }",
    );
    let own = ["--set", "task.kind=own", "--set", "task.part=energy.wgsl"];
    let run = [
        "run",
        "battery.toml",
        "--seed",
        "1",
        "--out",
        "own",
        "--backend",
        "cpu",
        "--quiet",
    ];
    place.good(&[&run[..], &own].concat());
    let trace = place.text("own/trace.csv");
    let (reward, energy) = (column(&trace, "reward"), column(&trace, "real_energy"));
    assert!(
        reward
            .iter()
            .zip(&energy)
            .all(|(reward, energy)| (reward - energy).abs() < 1e-6)
    );
}

/// The page's tables are made of the page's robot, and the page's robot made from them runs.
#[test]
fn the_pages_tables_are_sampled_and_read() {
    let place = Place::new("page-tables");
    place.write("formulas.toml", example(4));
    let sample = [
        "robot",
        "sample",
        "--robot",
        "formulas.toml",
        "--out",
        "tables",
        "--backend",
        "cpu",
    ];
    let names: Vec<_> = (0..7).map(|index| format!("prox_{index}")).collect();
    place.run(&sample).exits(0).says(&[&names.join(", ")]);
    place.write("own.toml", example(5));
    let trace = traced(&place, "own.toml", "run");
    for sensor in ["left", "ahead", "right"] {
        let readings = column(&trace, &format!("real_{sensor}"));
        assert!(readings.iter().any(|reading| *reading > 0.0), "{sensor}");
    }
    place.good(&["replay", "run", "--backend", "cpu", "--quiet"]);
}

/// The page's example runs as it stands, and its files have its sensors' names.
#[test]
fn the_pages_robot_runs() {
    let place = Place::new("own-robot");
    place.write("own.toml", example(0));
    let checked = place.good(&["check", "own.toml"]);
    for gene in ["left_to_left", "behind_to_right", "bias_right"] {
        assert!(checked.contains(gene), "{checked}");
    }
    place.good(&[
        "run",
        "own.toml",
        "--seed",
        "1",
        "--out",
        "run",
        "--backend",
        "cpu",
        "--quiet",
    ]);
    let trace = place.text("run/trace.csv");
    let head = trace.lines().next().unwrap();
    for column in ["sensor_left", "sensor_right", "sensor_behind", "real_behind"] {
        assert!(head.split(',').any(|name| name == column), "{head}");
    }
    let readme = place.text("run/README.md");
    for row in [
        "| `sensor_behind` | 0 to 1  | the perceived reading of the distance sensor `behind`, noise included |",
        "| `real_left`     | 0 to 1  | the reading of the proximity sensor `left` before sensor noise |",
    ] {
        assert!(readme.contains(row), "{readme}");
    }
    place.good(&["verify", "run"]);
    place.good(&["replay", "run", "--backend", "cpu", "--quiet"]);
    let bad = place.text("own.toml").replace("\"behind\"", "\"left\"");
    place.write("bad.toml", bad);
    place
        .run(&["check", "bad.toml"])
        .exits(3)
        .says(&["robot.sensors[2].name: is `left`; allowed: a name that no other"]);
    place
        .run(&[
            "check",
            "own.toml",
            "--set",
            "arena.preset=open",
            "--set",
            "arena.floor=0.5",
        ])
        .exits(3)
        .says(&["arena: has a preset and other keys"]);
    let both = ["run", "own.toml", "--seed", "1", "--set", "robot.tables=khepera"];
    place.run(&both).exits(3).says(&["robot.tables"]);
    let other = ["check", "own.toml", "--set", "robot.kind=sampled"];
    // Another kind of robot has none of what is described.
    assert!(place.good(&other).contains("sensors sampled for wall, round"));
}

/// Most of 200 random policies end where the rules say, to a millimetre: chaos carries the rest away, as it does between
/// single and double precision elsewhere.
#[test]
fn random_policies_end_where_the_rules_say() {
    let place = Place::new("kheperax");
    let mut genomes = String::new();
    let policies: Vec<_> = (0..POLICIES).map(policy).collect();
    for policy in &policies {
        let numbers: Vec<_> = policy.iter().map(ToString::to_string).collect();
        let _ = writeln!(genomes, "{}", numbers.join(","));
    }
    place.write("policies.csv", genomes);
    let experiment = Path::new(env!("CARGO_MANIFEST_DIR")).join("../experiments/kheperax.toml");
    let printed = place.good(&[
        "evaluate",
        &experiment.display().to_string(),
        "--genomes",
        "policies.csv",
        "--seed",
        "1",
        "--measures",
        "--set",
        "task.values.goal=0",
        "--backend",
        "cpu",
        "--json",
        "--quiet",
    ]);
    let lives: Vec<serde_json::Value> = serde_json::from_str(&printed).unwrap();
    assert_eq!(lives.len(), POLICIES);
    let (mut same, mut at_a_wall, mut far) = (0, 0, 0);
    for (life, policy) in lives.iter().zip(&policies) {
        let number = |name: &str| life[name].as_f64().unwrap();
        let ([x, y], fitness, hit) = lived(policy);
        let (dx, dy) = (number("end_x_mm") - 1000.0 * x, number("end_y_mm") - 1000.0 * y);
        if dx.hypot(dy) < 1.0 {
            same += 1;
            at_a_wall += u32::from(hit);
            far += u32::from((x - 0.15).hypot(y - 0.15) > 0.1);
            let off = (number("fitness") - fitness).abs();
            assert!(off < 2e-3 * fitness.abs() + 1e-5, "{life} {fitness}");
        }
    }
    println!("{same} of {POLICIES} end within 1 mm; {at_a_wall} of them at a wall, {far} over 100 mm from the start");
    assert!(same >= 180, "{same}");
    assert!(at_a_wall > 20 && far > 50, "{at_a_wall} {far}");
}

/// A robot with sensors of several kinds in an arena with a light and a patch.
const SEVERAL: &str = "cycles = 20
start = { kind = \"at\", x_mm = 500.0, y_mm = 300.0, heading_turns = 0.0 }
evolution = { population = 4, parents = 2, generations = 2, finalists = 0 }
[robot]
kind = \"differential\"
body_radius_mm = 35.0
wheel_base_mm = 53.0
greatest_speed_mm_s = 128.8
sensors = [
    { name = \"left\", heading_turns = 0.05, range_mm = 50.0 },
    { name = \"floor\", kind = \"ground\", offset_mm = 30.0 },
    { name = \"right\", heading_turns = -0.05, range_mm = 50.0 },
    { name = \"lamp\", kind = \"light\", range_mm = 500.0 },
]
[arena]
width_mm = 1000.0
height_mm = 600.0
lights = [{ x_mm = 900.0, y_mm = 300.0 }]
";

#[test]
fn a_described_robot_is_summed_up_and_drawn() {
    let place = Place::new("summed-up");
    place.write("several.toml", SEVERAL);
    let check = ["check", "several.toml"];
    let checked = place.good(&[&check[..], &["--out", "arena.svg"]].concat());
    for line in [
        "robot       radius 35 mm, wheels 53 mm apart, up to 128.8 mm/s\n",
        "sensors     2 proximity (left, right), 1 ground (floor), 1 light (lamp)\n",
        "0 round obstacles, 0 blocks, 1 light; ",
        "; the best 2 make 2 copies each\n",
    ] {
        assert!(checked.contains(line), "{checked}");
    }
    let patches = "arena.patches=[{x_mm=100,y_mm=100,radius_mm=50},{x_mm=900,y_mm=100,radius_mm=50}]";
    let more = place.good(&[&check[..], &["--set", patches, "--set", "evolution.elite=1"]].concat());
    for words in [
        "0 blocks, 1 light, 2 floor patches; ",
        "; the best one survives unchanged\n",
    ] {
        assert!(more.contains(words), "{more}");
    }
    let picture = place.text("arena.svg");
    // A pixel is 1000/880 mm: the robot is drawn at its start.
    assert!(picture.contains("translate(468 320)"), "{picture}");
    for hint in ["left: proximity", "floor: ground", "right: proximity", "lamp: light"] {
        assert!(picture.contains(hint), "{picture}");
    }
    let json: serde_json::Value = serde_json::from_str(&place.good(&[&check[..], &["--json"]].concat())).unwrap();
    let robot = serde_json::json!({
        "kind": "differential", "preset": null, "body_radius_mm": 35.0, "wheel_base_mm": 53.0, "greatest_speed_mm_s": 128.8,
        "speeds": null, "acceleration_mm_s2": null, "latency_cycles": null, "battery_s": null, "battery_ends_life": null,
        "classes": null, "motor_states": null, "collision": "undo",
    });
    assert_eq!(json["robot"], robot);
    place.write("sampled.toml", "");
    let whole: serde_json::Value = serde_json::from_str(&place.good(&["check", "sampled.toml", "--json"])).unwrap();
    let sampled = whole["robot"]
        .as_object()
        .unwrap()
        .iter()
        .filter(|(_, value)| !value.is_null());
    let sampled: serde_json::Value = sampled.map(|(key, value)| (key.clone(), value.clone())).collect();
    let robot = serde_json::json!({
        "kind": "sampled", "body_radius_mm": 27.5, "classes": ["wall", "round"], "motor_states": 20, "collision": "undo",
    });
    assert_eq!(sampled, robot);
    assert_eq!(
        json["sensors"],
        serde_json::json!({"proximity": 2, "ground": 1, "light": 1})
    );
}

#[test]
fn starts_lights_and_sensors_that_are_out_of_place_are_named() {
    let place = Place::new("out-of-place");
    place.write("several.toml", SEVERAL);
    for (change, words) in [
        (
            "start.x_mm=2000",
            "--set start.x_mm=2000: start.x_mm: is 2000; allowed: 0 to 1000",
        ),
        (
            "start.y_mm=-1",
            "--set start.y_mm=-1: start.y_mm: is -1; allowed: 0 to 600",
        ),
    ] {
        place
            .run(&["check", "several.toml", "--set", change])
            .exits(3)
            .says(&[words]);
    }
    let run = ["run", "several.toml", "--seed", "1", "--out", "run", "--backend", "cpu"];
    place.good(&run);
    place
        .run(&["replay", "run", "--start", "2000,300,0", "--backend", "cpu"])
        .exits(3)
        .says(&["--start 2000,300,0: start.x_mm: is 2000; allowed: 0 to 1000"]);
    // What may be meant is done, with a warning.
    let none = place.run(&["check", "several.toml"]).exits(0);
    assert!(!none.stderr.contains("warning"), "{}", none.stderr);
    let odd = SEVERAL
        .replace("offset_mm = 30.0", "offset_mm = 2500.0")
        .replace("x_mm = 900.0", "x_mm = 1200.0");
    place.write("odd.toml", odd);
    place.run(&["check", "odd.toml"]).exits(0).says(&[
        "warning: odd.toml:11:52: robot.sensors[1].offset_mm: is 2500, outside of the body of 35 mm radius",
        "warning: odd.toml:18:11: arena.lights[0]: is outside of the arena, and walls between hide it: the arena has x from 0 to 1000 and y from 0",
    ]);
    place.write("word.toml", SEVERAL.replace("\"floor\"", "\"target\""));
    place
        .run(&["check", "word.toml"])
        .exits(3)
        .says(&["word.toml:11:14: robot.sensors[1].name: is `target`; allowed: a name that is neither `own` nor"]);
}
