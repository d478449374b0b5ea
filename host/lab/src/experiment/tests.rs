use std::fs;
use std::path::PathBuf;

use oneiro::differential::{Build, Differential};
use oneiro::parameter::{Allowed, Datum, Parameter};
use oneiro::world;
use png::{BitDepth, ColorType};

use super::start::{Robots, Start};
use super::values::Described;
use super::*;
use crate::pixels;
use crate::runs;
use crate::scratch::{Scratch, holds};

fn read(scratch: &Scratch, text: &str, set: &[&str]) -> Result<Experiment> {
    let path = scratch.write("test.toml", text);
    Experiment::read(&path, &set.iter().map(|&set| set.to_owned()).collect::<Vec<_>>())
}

/// Place and problem: the message without the directory of the file.
fn refusal(scratch: &Scratch, text: &str, set: &[&str]) -> String {
    let Err(failure) = read(scratch, text, set) else {
        return format!("{text} {set:?} is accepted");
    };
    assert_eq!(failure.code(), 3, "{failure}");
    failure
        .to_string()
        .replace(&format!("{}/", scratch.path().display()), "")
}

#[test]
fn an_empty_experiment_is_the_paper_without_noise() {
    let scratch = Scratch::new("empty");
    let experiment = read(&scratch, "", &[]).unwrap();
    assert_eq!(experiment.name(), "test");
    assert_eq!(*experiment.world().spec(), world::WorldSpec::miglino1995());
    let evolution = &experiment.settings().evolution;
    assert_eq!(
        (evolution.population, evolution.parents, evolution.generations),
        (100, 20, 200)
    );
}

/// The first experiment is that of an empty file, and with all keys its comments have the defaults.
#[test]
fn the_example_holds_the_defaults() {
    let scratch = Scratch::new("example");
    let examples = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../experiments");
    let example = Experiment::read(&examples.join("khepera-avoidance.toml"), &[]).unwrap();
    let empty = read(&scratch, "name = \"khepera-avoidance\"", &[]).unwrap();
    assert_eq!(example.settings(), empty.settings());
    let text = khepera().whole();
    let set: Vec<&str> = text
        .lines()
        .map(|line| line.strip_prefix("# ").unwrap_or(line))
        .collect();
    for line in empty
        .resolved_toml(1)
        .lines()
        .filter(|line| line.contains('=') && !line.starts_with("seed"))
    {
        assert!(set.contains(&line), "{line} is not shown");
    }
    for line in empty.resolved_toml(1).lines().filter(|line| line.contains('=')) {
        let key = line.split('=').next().unwrap().trim();
        assert!(
            text.contains(&format!("\n{key} =")) || text.contains(&format!("\n# {key} =")),
            "{key} is not shown"
        );
    }
}

#[test]
fn all_experiments_are_valid() {
    let examples = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../experiments");
    let mut names = Vec::new();
    for entry in fs::read_dir(examples).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") && !path.ends_with("Cargo.toml") {
            let name = runs::read(&path, &[]).unwrap().name().to_owned();
            assert_eq!(Some(&*name), path.file_stem().and_then(|stem| stem.to_str()));
            names.push(name);
        }
    }
    assert!(names.len() >= 12, "{names:?}");
}

#[test]
fn a_resolved_experiment_is_itself_again() {
    let scratch = Scratch::new("resolved");
    let texts = [
        "",
        "trials = 3\ntrial_score = \"least\"\n[controller]\nkind = \"hidden\"\n[start]\nkind = \"at\"\nx_mm = 50\ny_mm = 50",
        "[arena]\nwidth_mm = 400\nheight_mm = 300.5\nobstacles = [{ x_mm = 200, y_mm = 150, radius_mm = 20 }]",
        "[arena]\nwidth_mm = 400\nheight_mm = 300\nwalls = [{ from_mm = [0, 0], to_mm = [400, 300], class = \"round\" }]",
        "[evolution]\nlimits = [-5, 5]\ninitial = [-0.1, 0.1]\n[noise]\nsensor = [0.0, 0.4]",
    ];
    for text in texts {
        let experiment = read(&scratch, text, &[]).unwrap();
        let resolved = experiment.resolved_toml(7);
        let again = read(&scratch, &resolved, &[]).unwrap();
        assert_eq!(again.settings().seed, Some(7));
        assert_eq!(again.resolved_toml(7), resolved);
        assert_eq!(again.identities().of(7), experiment.identities().of(7));
        assert_eq!(again.world().spec(), experiment.world().spec());
        assert_ne!(again.identities().of(8), experiment.identities().of(7));
    }
}

/// An arena that is large enough for a Thymio II.
const ROOM: &str = "\narena.width_mm = 1000\narena.height_mm = 1000\n";

/// A robot by name equals its values: an experiment with all of them is the same, even if the robot that ships changes.
#[test]
fn a_robot_by_name_is_its_values() {
    let scratch = Scratch::new("preset");
    for name in ["khepera", "epuck", "thymio2", "kheperax"] {
        let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("src/experiment/robots/{name}.toml"));
        let text = fs::read_to_string(file).unwrap();
        let written = read(&scratch, &format!("{ROOM}{text}"), &[]).unwrap();
        let named = read(&scratch, &format!("{ROOM}robot.preset = \"{name}\""), &[]).unwrap();
        assert_eq!(named.world().spec(), written.world().spec());
        assert_eq!(named.identities().of(1), written.identities().of(1));
        let resolved = named.resolved_toml(7);
        assert!(!resolved.contains(name), "{resolved}");
        assert_eq!(read(&scratch, &resolved, &[]).unwrap().resolved_toml(7), resolved);
    }
}

#[test]
fn a_robot_by_name_is_changed_key_by_key_and_its_sensors_as_a_whole() {
    let scratch = Scratch::new("changed-preset");
    let plain = read(&scratch, "robot.preset = \"epuck\"", &[]).unwrap();
    let robot = |experiment: &Experiment| match experiment.world().spec().robot.build.clone() {
        Build::Differential(robot) => robot,
        Build::Sampled | Build::Forager(_) => panic!("is not described"),
    };
    assert_eq!(robot(&plain).sensors.len(), 19);
    let text = "robot.preset = \"epuck\"\nrobot.greatest_speed_mm_s = 80";
    let slow = read(&scratch, text, &["robot.latency_cycles=2"]).unwrap();
    assert_eq!(
        robot(&slow),
        Differential {
            greatest_speed: Some(80.0),
            latency: Some(2),
            ..robot(&plain)
        }
    );
    let text = format!("{ROOM}[robot]\npreset = \"epuck\"\nsensors = [{{ name = \"nose\", range_mm = 20 }}]");
    let own = read(&scratch, &text, &[]).unwrap();
    assert_eq!(robot(&own).sensors.len(), 1);
    assert_eq!(robot(&own).sensors[0].name, "nose");
    assert_eq!(own.world().spec().robot.body_radius, 35.0);
    let other = read(&scratch, &text, &["robot.preset=thymio2"]).unwrap();
    assert_eq!(other.world().spec().robot.body_radius, 80.0);
}

/// The key `collision` exists only for single robots, so a robot by name leaves it out.
#[test]
fn a_robot_by_name_lives_with_others() {
    let scratch = Scratch::new("preset-swarm");
    let text = format!("{ROOM}robot.preset = \"epuck\"\nrobot.count = 4");
    let together = read(&scratch, &text, &[]).unwrap();
    assert_eq!(together.world().robots(), 4);
    let own = format!("{text}\nrobot.collision = \"slide\"");
    let message = refusal(&scratch, &own, &[]);
    assert!(
        message.contains("robot.collision: is given; allowed: only without robot.count"),
        "{message}"
    );
}

/// Sampled motors replace a robot's wheels, and tables replace its sensors if it lists sampled ones.
#[test]
fn a_robot_by_name_takes_samples() {
    let scratch = Scratch::new("sampled-preset");
    let text = format!(
        "{ROOM}[robot]\npreset = \"epuck\"\nmotors = \"khepera\"\nstates = \"evorobot\"\ntables = \"khepera\"\n\
         sensors = [{{ name = \"nose\", kind = \"sampled\", column = 2 }}]"
    );
    let own = read(&scratch, &text, &[]).unwrap();
    let robot = &own.world().spec().robot;
    let Build::Differential(described) = &robot.build else {
        panic!("is sampled");
    };
    assert!(described.sampled_motors && described.columns() == [Some(2)]);
    assert_eq!((described.wheel_base, described.greatest_speed), (None, None));
    assert_eq!((robot.body_radius, robot.motors.states), (35.0, 21));
    // A run's file has everything that makes the robot, and is the same experiment.
    let resolved = own.resolved_toml(1);
    assert!(
        resolved.contains("tables = \"khepera\"") && !resolved.contains("wheel_base_mm"),
        "{resolved}"
    );
    let again = read(&scratch, &resolved, &[]).unwrap();
    assert_eq!(again.resolved_toml(1), resolved);
}

/// Listed walls replace the four sides.
#[test]
fn arenas_that_a_robot_can_leave_are_warned_of() {
    let scratch = Scratch::new("open");
    let arena = |walls: &str, more: &str| {
        let wall = |ends: &str| {
            format!(
                "{{ {} }}",
                ends.replacen("from", "from_mm", 1).replacen("to", "to_mm", 1)
            )
        };
        let walls: Vec<_> = walls.split(';').map(wall).collect();
        format!(
            "robot.preset = \"epuck\"\narena = {{ width_mm = 500, height_mm = 400, walls = [{}], lights = [{{ x_mm = 50, y_mm = 50 }}]{more} }}",
            walls.join(", ")
        )
    };
    let inner = "from = [200, 0], to = [200, 300]";
    let sides = "from = [0, 0], to = [500, 0]; from = [500, 0], to = [500, 400]; from = [500, 400], to = [0, 400]";
    let last = |from: u32| format!("from = [0, {from}], to = [0, 0]");
    let warnings = |text: &str| read(&scratch, text, &[]).unwrap().warnings().to_vec();
    let open = warnings(&arena(inner, ""));
    let place = scratch.path().join("test.toml");
    let message = "lists walls, so the arena has no sides, and the robot can leave it; add the four sides to the list, or say arena.open = true";
    assert_eq!(open, [format!("{}:2:52: arena.walls: {message}", place.display())]);
    assert!(warnings(&arena(inner, ", open = true")).is_empty());
    assert!(warnings(&arena(&format!("{inner}; {sides}; {}", last(400)), "")).is_empty());
    // A gap is a way out if the body, 70 mm wide, fits through.
    assert_eq!(
        warnings(&arena(&format!("{inner}; {sides}; {}", last(300)), "")).len(),
        1
    );
    assert!(warnings(&arena(&format!("{inner}; {sides}; {}", last(340)), "")).is_empty());
}

/// A warning names each object that no robot gets near, each start outside of the arena, and the arena's origin.
#[test]
fn things_that_no_robot_reaches_are_warned_of() {
    let scratch = Scratch::new("unreached");
    let warnings = |more: &str, robot: &str| {
        let text = format!(
            "cycles = 50\nrobot.preset = \"thymio2\"\n{robot}\n[arena]\nwidth_mm = 1000\nheight_mm = 1000\n{more}"
        );
        let own = read(&scratch, &text, &[]).unwrap_or_else(|failure| panic!("{more}: {failure}"));
        own.warnings().to_vec()
    };
    let of_things = [
        ("patches", "radius_mm = 50"),
        ("patches", "sides_mm = [80, 60]"),
        ("obstacles", "radius_mm = 20"),
        ("blocks", "length_mm = 40, width_mm = 20"),
        ("lights", "brightness = 1.0"),
    ];
    for (list, size) in of_things {
        let thing = |x: i32, y: i32| format!("{{ x_mm = {x}, y_mm = {y}, {size} }}");
        let light = if list == "lights" {
            ""
        } else {
            "lights = [{ x_mm = 500, y_mm = 500 }]\n"
        };
        let of = |x, y| warnings(&format!("{light}{list} = [{}, {}]", thing(500, 300), thing(x, y)), "");
        for (x, y) in [(5000, 500), (-300, 500), (500, -300), (500, 1300), (-5000, -5000)] {
            let own = of(x, y);
            assert_eq!(own.len(), 1, "{list} at ({x}, {y}): {own:?}");
            let named = format!("arena.{list}[1]: ");
            let origin =
                "the arena has x from 0 to 1000 and y from 0 to 1000 mm; its origin (0, 0) is its lower left corner";
            assert!(own[0].contains(&named) && own[0].contains(origin), "{list}: {}", own[0]);
        }
        // Inside, and where it can be noticed from inside.
        for (x, y) in [(100, 100), (900, 500)] {
            assert!(of(x, y).is_empty(), "{list} at ({x}, {y}): {:?}", of(x, y));
        }
    }
    let lit = "lights = [{ x_mm = 500, y_mm = 500 }]";
    let half_outside = "patches = [{ x_mm = -20, y_mm = 500, radius_mm = 150 }]";
    assert!(warnings(&format!("{lit}\n{half_outside}"), "").is_empty());
    let octagon =
        "corners_mm = [[300, 0], [700, 0], [1000, 300], [1000, 700], [700, 1000], [300, 1000], [0, 700], [0, 300]]";
    let text = format!(
        "cycles = 50\nrobot.preset = \"thymio2\"\nstart = {{ kind = \"at\", x_mm = 40, y_mm = 40 }}\n[arena]\n{octagon}\n{lit}"
    );
    let told = match read(&scratch, &text, &[]) {
        Ok(own) => own.warnings().join("\n"),
        Err(failure) => failure.to_string(),
    };
    assert!(told.contains("start") && told.contains("outside"), "{told}");
    let inside = read(
        &scratch,
        &text.replace("x_mm = 40, y_mm = 40", "x_mm = 300, y_mm = 300"),
        &[],
    );
    assert!(inside.unwrap().warnings().is_empty());
}

/// Pairs of values that contradict each other are refused, whichever of them is changed.
#[test]
fn values_that_contradict_each_other_are_refused() {
    let scratch = Scratch::new("contradictions");
    let genome = |gene: &str| vec![gene; 18].join(",");
    scratch.write("far.csv", format!("{}\n{}\n", genome("0.5"), genome("3")));
    let few = "population = 2\nparents = 1\nelite = 0";
    let coevolution = "robot.preset = \"khepera\"\nrobot.count = 2\nrobot.starts_mm = [[70, 100], [200, 100]]\n[arena]\nwidth_mm = 270\nheight_mm = 200";
    for (text, expected) in [
        (
            format!("[evolution]\n{few}\ninit = \"far.csv\"\nlimits = [-1, 1]"),
            "evolution.init: ",
        ),
        (
            "[evolution]\ninitial = [1, 5]\nlimits = [-1, 1]".to_owned(),
            "evolution.limits: is [-1, 1], and evolution.initial is [1, 5]; allowed: limits that share a part of that range",
        ),
        (
            "[evolution]\nlimits = [2, 3]".to_owned(),
            "evolution.limits: is [2, 3], and evolution.initial is ",
        ),
        (
            format!("[evolution]\ninitial = [-1, 1]\nlimits = [-1, 1]\ninitial_shares = [{}]", genome("1.5")),
            "evolution.initial_shares: is 1.5 for ",
        ),
        ("[evolution]\ninitial = [1, -1]".to_owned(), "evolution.initial: "),
        ("[evolution]\nlimits = [1, -1]".to_owned(), "evolution.limits: "),
        ("noise.sensor = [0.2, -0.1]".to_owned(), "noise.sensor: "),
        ("[evolution]\npopulation = 4\nparents = 5".to_owned(), "evolution.parents: "),
        ("[evolution]\npopulation = 4\nparents = 2\nelite = 5".to_owned(), "evolution.elite: "),
        ("arena = { width_mm = 500, height_mm = 500, walls = [] }".to_owned(), "arena.walls: is empty; allowed: "),
        (
            "robot.preset = \"thymio2\"\narena = { width_mm = 500, height_mm = 500, start_radius_mm = 100 }".to_owned(),
            "arena.start_radius_mm: ",
        ),
        (
            "robot.preset = \"thymio2\"\nrobot.count = 20\narena = { width_mm = 500, height_mm = 500, start_radius_mm = 60 }"
                .to_owned(),
            "arena.start_radius_mm",
        ),
        (
            format!("{coevolution}\n[evolution]\nkind = \"coevolution\"\nopponents.first_gene = \"none such\""),
            "evolution.opponents.first_gene: ",
        ),
        (
            "[noise]\nwalk_step_mm = 3".to_owned(),
            "noise.walk_step_mm: is 3, which has no effect; allowed: only with noise.walk_range_mm above 0",
        ),
    ] {
        let message = refusal(&scratch, &text, &[]);
        assert!(message.contains(expected), "{text}\n gave {message}\n not {expected}");
    }
}

#[test]
fn light_sensors_in_the_dark_are_warned_of() {
    let scratch = Scratch::new("dark");
    let dark = read(&scratch, "robot.preset = \"epuck\"", &[]).unwrap();
    let place = scratch.path().join("test.toml");
    assert_eq!(
        dark.warnings(),
        [format!(
            "{}: arena.lights: is empty: the robot's 8 light sensors read 0",
            place.display()
        )]
    );
    let lit = "arena = { width_mm = 500, height_mm = 500, lights = [{ x_mm = 250, y_mm = 250 }] }";
    let lit = read(&scratch, &format!("robot.preset = \"epuck\"\n{lit}"), &[]).unwrap();
    let blind = read(&scratch, &format!("{ROOM}robot.preset = \"thymio2\""), &[]).unwrap();
    assert!(lit.warnings().is_empty() && blind.warnings().is_empty());
}

#[test]
fn recording_does_not_change_the_identity() {
    let scratch = Scratch::new("identity");
    let experiment = read(&scratch, "", &[]).unwrap();
    let other = read(&scratch, "", &["record.checkpoint_every=3", "record.individuals=false"]).unwrap();
    assert_eq!(experiment.identities().of(1), other.identities().of(1));
    assert_ne!(experiment.resolved_toml(1), other.resolved_toml(1));
    assert_ne!(
        experiment.identities().of(1),
        read(&scratch, "cycles = 501", &[]).unwrap().identities().of(1)
    );
}

#[test]
fn settings_go_before_the_file() {
    let scratch = Scratch::new("set");
    let text = "cycles = 10\n[noise]\nsensor = [0.0, 0.1]\nmotor = 0.5\n";
    let set = [
        "cycles=20",
        "noise.sensor=[0.0, 0.4]",
        "controller.kind=hidden",
        "evolution.mutation.rate=0.5",
        "cycles=30",
    ];
    let experiment = read(&scratch, text, &set).unwrap();
    let settings = experiment.settings();
    assert_eq!(settings.world.cycles, 30);
    assert_eq!(settings.world.noise.sensor, (0.0, 0.4));
    assert_eq!(settings.world.noise.motor, 0.5);
    assert_eq!(settings.world.controller, world::Controller::Hidden { units: 4 });
    assert_eq!(settings.evolution.mutation.rate, 0.5);
}

#[test]
fn a_step_of_the_walk_is_nothing_without_its_range() {
    let scratch = Scratch::new("walk");
    assert_eq!(
        read(&scratch, "", &[]).unwrap().world().spec().noise,
        world::Noise::default()
    );
    let noise = read(&scratch, "noise.walk_range_mm = 30", &[])
        .unwrap()
        .world()
        .spec()
        .noise;
    assert_eq!((noise.walk_range, noise.walk_step), (30.0, 1.5));
}

/// Texts with the expected place, problem and allowed values.
const REFUSED: &[(&str, &str)] = &[
    ("cycles = 0", "test.toml:1:10: cycles: is 0; allowed: 1 to 1000000"),
    (
        "\n[noise]\n  motor = 1.5\n",
        "test.toml:3:11: noise.motor: is 1.5; allowed: 0 to 1",
    ),
    (
        "[noise]\nsensor = [0.4, 0.0]",
        "test.toml:2:10: noise.sensor: is [0.4, 0.0]; allowed: [0, 0] or [minimum, maximum]",
    ),
    (
        "[noise]\nsensro = 1",
        "test.toml:2:1: noise.sensro: unknown key `sensro`; did you mean noise.sensor? (allowed: sensor, walk_range_mm, walk_step_mm, motor, gain, veer_turns_per_m, delay_cycles, drawn)",
    ),
    (
        "cycles = -5",
        "test.toml:1:10: cycles: is -5; allowed: a whole number from 1 to 1000000",
    ),
    (
        "cycles = \"many\"",
        "test.toml:1:10: cycles: is \"many\"; allowed: a whole number from 1 to 1000000",
    ),
    (
        "[noise]\nmotor = \"big\"",
        "test.toml:2:9: noise.motor: is \"big\"; allowed: a number from 0 to 1",
    ),
    (
        "[task]\nspeed = \"fast\"",
        "test.toml:2:9: task.speed: is \"fast\"; allowed: unsigned or signed",
    ),
    ("noise = 3", "test.toml:1:9: noise: is 3; allowed: a table of keys"),
    (
        "cycles = 5\ncycles = 6",
        "test.toml:2:1: duplicate key `cycles`, first in line 1; allowed: each key once",
    ),
    (
        "cycles = 5\n[noise]\nmotor = 0\nsensor = [0, 0]\nmotor = 0.1",
        "test.toml:5:1: duplicate key `motor`, first in line 3; allowed: each key once",
    ),
    (
        "[noise]\nmotor = 0\n[evolution]\nelite = 1\n[noise]\nmotor = 0",
        "test.toml:5:2: duplicate key `noise`, first in line 1; allowed: each key once",
    ),
    (
        "[robot]\nkind = \"differential\"\nsensors = [{ name = \"a\", range_mm = 9, heading_turns = 90 }]",
        "heading_turns: is 90; allowed: -1 to 1 turns, each of 360 degrees",
    ),
    ("cycles = ", "test.toml:1:10: has no value"),
    (
        "cycles = 900;",
        "test.toml:1:10: a line of TOML ends without `;`; write `900`",
    ),
    (
        "[robot]\nbody_radius_mm = 16,5",
        "test.toml:2:20: a number has a decimal point; write `16.5`",
    ),
    (
        "[noise]\nsensor = [-0,05, 0.05]",
        ": a number has a decimal point; write `0.05`",
    ),
    ("start = { x_mm = 5,5 }", ": a number has a decimal point; write `5.5`"),
    (
        "name = \u{201c}graze\u{201d}",
        ": `\u{201c}` is no quote of TOML; write `\"`",
    ),
    (
        "[robot]\npreset = \"epuck-rm1.1\"\ncount = 5\n[noise]\nsensor = [-0.4, 0.4]",
        "noise.sensor: is [-0.4, 0.4], which has no effect; allowed: only with robot.sensors",
    ),
    (
        "name = graze # mine",
        "test.toml:1:8: words are quoted; write `\"graze\"`",
    ),
    (
        "[task]\ncycles = 70",
        "test.toml:2:1: task.cycles: unknown key `cycles`; did you mean cycles, which is in no table? (allowed: kind",
    ),
    (
        "[sensors.values]\nwidth = 3.0",
        "test.toml:1:2: sensors: unknown key `sensors`; did you mean sensor? (allowed: name, seed, cycles, trials, trial_score, robot, pucks, arena, noise, sensor, controller, task, start, worlds, evolution, reality, record, test, files)",
    ),
    (
        "[robot]\ntables = \"epuck\"",
        "test.toml:2:10: robot.tables: is \"epuck\"; allowed: \"khepera\", \"reality\", \"surrogate:SEED\" or a list of files",
    ),
    (
        "[robot]\ntables = [\"wall.sam\", 3]",
        "test.toml:2:10: robot.tables: is [\"wall.sam\", 3]; allowed: \"khepera\", \"reality\", \"surrogate:SEED\" or a list of files",
    ),
    (
        "[robot]\ntables = \"reality\"",
        "test.toml:2:10: robot.tables: is \"reality\"; allowed: only with a surrogate as reality.robot",
    ),
    (
        "[robot]\nmotors = \"reality\"\n[reality]\nrobot = \"serial:/dev/ttyUSB0\"",
        "test.toml:2:10: robot.motors: is \"reality\"; allowed: only with a surrogate as reality.robot",
    ),
    (
        "[robot]\nkind = \"differential\"\nwheel_base_mm = 50\ngreatest_speed_mm_s = 80\ntables = \"reality\"\n[reality]\nrobot = \"surrogate:1\"",
        "robot.tables: is \"reality\", and the robot is parametric; allowed: only with a sampled robot",
    ),
    (
        "[reality]\nmotion_severity = 1.0",
        "test.toml:2:19: reality.motion_severity: is given; allowed: only with a surrogate as reality.robot",
    ),
    (
        "[reality.differences]\nlatency = 1.0",
        "reality.differences.latency: is given; allowed: only with a surrogate as reality.robot",
    ),
    (
        "[robot]\ntables = []",
        "test.toml:2:10: robot.tables: is empty; allowed: a file for each class of object",
    ),
    (
        "[robot]\ntables = [\"none.sam\"]",
        "test.toml:2:11: robot.tables[0]: none.sam: No such file",
    ),
    (
        "[robot]\nmotors = \"none.sam\"",
        "test.toml:2:10: robot.motors: none.sam: No such file",
    ),
    (
        "[robot]\nbody_radius_mm = nan",
        "test.toml:2:18: robot.body_radius_mm: is NaN; allowed: 1 to 100000",
    ),
    (
        "[robot]\nbody_radius_mm = 1",
        "robot.motors: the maximum displacement of a cycle is",
    ),
    (
        "[robot]\npreset = \"epcuk\"",
        "test.toml:2:10: robot.preset: is \"epcuk\"; did you mean epuck? (allowed: khepera, epuck, thymio2, kheperax, epuck-rm1.1, epuck-rm1.2)",
    ),
    (
        "[robot]\npreset = \"roomba\"",
        "test.toml:2:10: robot.preset: is \"roomba\"; allowed: khepera, epuck, thymio2, kheperax, epuck-rm1.1, epuck-rm1.2",
    ),
    (
        "[robot]\npreset = 3",
        "test.toml:2:10: robot.preset: is 3; allowed: khepera, epuck, thymio2, kheperax, epuck-rm1.1, epuck-rm1.2",
    ),
    (
        "[robot]\npreset = \"epuck\"\nkind = \"sampled\"",
        "test.toml:3:8: robot.kind: is \"sampled\", and robot.preset is \"epuck\"; allowed: \"differential\"",
    ),
    (
        "[robot]\npreset = \"epuck\"\ntables = \"khepera\"",
        "test.toml:3:10: robot.tables: is given, and no sensor reads it; allowed: only with sensors of the kind sampled",
    ),
    (
        "[robot]\npreset = \"epuck\"\ngreatest_speed_mm_s = 900",
        "test.toml:3:23: robot.greatest_speed_mm_s: the maximum displacement of a cycle is 90 mm",
    ),
    (
        "[robot]\npreset = \"epuck\"\nacceleration_mm_s2 = 0.5",
        "test.toml:3:22: robot.acceleration_mm_s2: is 0.5; allowed: 0, or at least 1",
    ),
    (
        "[robot]\npreset = \"epuck\"\nsensors = [{ name = \"one\", range_mm = 50, response = [[0, 1], [50, 2]] }]",
        "test.toml:3:68: robot.sensors[0].response[1][1]: is 2; allowed: 0 to 1",
    ),
    (
        "[robot]\npreset = \"epuck\"\nsensors = [{ name = \"one\", range_mm = 50, response = [0, 50] }]",
        "test.toml:3:54: robot.sensors[0].response: is [0, 50]; allowed: 2 to 32 pairs of a distance in mm and a reading from 0 to 1",
    ),
    (
        "[robot]\npreset = \"epuck\"\nsensors = [{ name = \"energy\", kind = \"battery\" }]",
        "test.toml:3:38: robot.sensors[0].kind: is battery; allowed: only with robot.battery_s",
    ),
    (
        "[arena]\npreset = \"maze\"",
        "test.toml:2:10: arena.preset: is \"maze\"; allowed: miglino1995, miglino1995-triangle, miglino1995-block, open, octagon",
    ),
    (
        "[arena]\npreset = \"open\"\nwidth_mm = 3",
        "test.toml:1:1: arena: has a preset and other keys",
    ),
    (
        "[[arena.walls]]\nfrom_mm = [0, 0]\nto_mm = [9, 9]",
        "arena: lacks its size; allowed: width_mm and height_mm",
    ),
    (
        "[arena]\nwidth_mm = 500\nheight_mm = 500\nwalls = [{ from_mm = [0, 0] }]",
        "test.toml:4:10: arena.walls[0]: lacks `to_mm`; allowed: two numbers from -100000 to 100000 (mm)",
    ),
    (
        "[arena]\nwidth_mm = 500\nheight_mm = 500\nobstacles = [{ x_mm = 1, y_mm = 1, radius_mm = -3 }]",
        "arena.obstacles[0].radius_mm: is -3; allowed: 0 to 100000",
    ),
    (
        "[arena]\nwidth_mm = 500\nheight_mm = 500\nobstacles = [{ x_mm = 1, y_mm = 1, radius_mm = 3, class = \"tree\" }]",
        "arena.obstacles[0].class: no sensor table for `tree`; allowed: wall, round",
    ),
    (
        "[arena]\nwidth_mm = 40\nheight_mm = 40",
        "arena: a robot's body is free in 0 % of its start field",
    ),
    (
        "[controller]\nunits = 3",
        "test.toml:2:9: controller.units: is given; allowed: only with kind = \"hidden\"",
    ),
    (
        "[controller]\nkind = \"hidden\"\nunits = 33",
        "test.toml:3:9: controller.units: is 33; allowed: 1 to 32",
    ),
    (
        "[reality]\ngenerations = 3",
        "test.toml:2:15: reality.generations: is given; allowed: only with reality.robot",
    ),
    ("[reality]\nrobot = \"surrogate\"", "test.toml:2:9: reality.robot: "),
    (
        "[reality]\nrobot = \"surrogate:1\"\ngenerations = 201",
        "test.toml:3:15: reality.generations: is 201; allowed: 1 to 200",
    ),
    (
        "[reality]\nrobot = \"surrogate:1\"\n[task]\nnew_cell = 1.0\n[robot]\npreset = \"kheperax\"",
        "test.toml:2:9: reality.robot: can't run this experiment: ",
    ),
    (
        "[start]\nx_mm = 3",
        "test.toml:2:8: start.x_mm: is given; allowed: only with kind = \"at\"",
    ),
    (
        "[start]\nkind = \"at\"\nx_mm = 3",
        "test.toml:1:1: start: lacks `y_mm`; allowed: a number from -100000 to 100000 (mm)",
    ),
    (
        "[start]\nkind = \"at\"\nx_mm = 3\ny_mm = 3",
        "test.toml:1:1: start: (3, 3) mm touches an object",
    ),
    (
        "[start]\nkind = \"at\"\nx_mm = 50\ny_mm = 50\nheading_turns = 1.5",
        "test.toml:5:17: start.heading_turns: is 1.5; allowed: -1 to 1 turns",
    ),
    (
        "[evolution]\npopulation = 0",
        "test.toml:2:14: evolution.population: is 0; allowed: 1 to 1000000",
    ),
    (
        "[evolution]\nparents = 30",
        "test.toml:2:11: evolution.parents: is 30; allowed: a divisor of the population, 100",
    ),
    (
        "[evolution]\nparents = 200",
        "test.toml:2:11: evolution.parents: is 200; allowed: 1 to 100",
    ),
    (
        "[evolution]\nelite = 21",
        "test.toml:2:9: evolution.elite: is 21; allowed: 0 to 20",
    ),
    (
        "[evolution]\nkind = \"cmaes\"",
        "test.toml:2:8: evolution.kind: is \"cmaes\"; allowed: genetic, cma-es, sep-cma-es, open-es, map-elites, \
         novelty, random",
    ),
    (
        "[evolution]\nkind = \"cma-es\"\nelite = 1",
        "test.toml:3:9: evolution.elite: is given; allowed: only with kind = \"genetic\" or \"novelty\"",
    ),
    (
        "[evolution]\nkind = \"random\"\n[evolution.mutation]\nrate = 0.1",
        "test.toml:4:8: evolution.mutation.rate: is given; allowed: only with evolution.kind = \"genetic\" or \"novelty\"",
    ),
    (
        "[evolution.strategy]\nsigma = 0.1",
        "test.toml:2:9: evolution.strategy.sigma: is given; allowed: only with evolution.kind = \"cma-es\" or \"sep-cma-es\" or \
         \"open-es\"",
    ),
    (
        "[evolution]\nkind = \"open-es\"\npopulation = 41",
        "test.toml:3:14: evolution.population: is 41; allowed: an even number, since samples are mirrored",
    ),
    (
        "[evolution]\nkind = \"grid\"",
        "evolution.grid.levels: is 11 for 18 genes; allowed: up to 1000000000 combinations",
    ),
    (
        "[evolution]\nkind = \"grid\"\npopulation = 100\ngrid.levels = 2",
        "test.toml:3:14: evolution.population: is 100; allowed: a divisor of the grid's 262144 combinations",
    ),
    (
        "[evolution]\ngrid.levels = 3",
        "evolution.grid.levels: is given; allowed: only with evolution.kind = \"grid\"",
    ),
    (
        "[evolution]\nkind = \"sep-cma-es\"\npopulation = 3",
        "test.toml:3:14: evolution.population: is 3; allowed: 4 or more",
    ),
    (
        "[controller]\nkind = \"hidden\"\nunits = 10\n[evolution]\nkind = \"cma-es\"",
        "test.toml:5:8: evolution.kind: is \"cma-es\" with 112 genes; allowed: up to 100, or sep-cma-es",
    ),
    (
        "[evolution]\nparents = 5\n[evolution.selection]\nkind = \"rank\"",
        "test.toml:2:11: evolution.parents: is given; allowed: only with evolution.selection.kind = \"truncation\" or \
         \"uniform\"",
    ),
    (
        "[evolution.selection]\nkind = \"rank\"\npressure = 2.5",
        "test.toml:3:12: evolution.selection.pressure: is 2.5; allowed: 1 to 2",
    ),
    (
        "[evolution.crossover]\nkind = \"one_point\"\nshare = 0.5",
        "test.toml:3:9: evolution.crossover.share: is given; allowed: only with kind = \"uniform\"",
    ),
    (
        "[evolution.mutation]\nkind = \"evostick\"\nper = \"gene\"",
        "test.toml:3:7: evolution.mutation.per: is given; allowed: only with kind = \"add_uniform\" or \"add_normal\" or \
         \"replace\"",
    ),
    (
        "[evolution]\nkind = \"novelty\"",
        "test.toml:1:2: evolution.descriptors: has 0; allowed: 1 to 6 measures of behaviour",
    ),
    (
        "[evolution]\nkind = \"map-elites\"\ndescriptors = [{ measure = \"end_x\", least = 0, greatest = 1 }]",
        "test.toml:3:28: evolution.descriptors[0].measure: is \"end_x\"; allowed: collisions, cells, distance_mm, mean_speed_mm_s, \
         stuck_s, mean_turning_turns_s, end_x_mm, end_y_mm, wall_distance_mm",
    ),
    (
        "[evolution]\nkind = \"map-elites\"\ndescriptors = [{ measure = \"end_x_mm\", least = 0 }]",
        "evolution.descriptors[0]: lacks `greatest`; allowed: a number",
    ),
    (
        "[evolution]\nkind = \"map-elites\"\ndescriptors = [{ measure = \"end_x_mm\", least = 1, greatest = 1 }]",
        "evolution.descriptors[0].greatest: is 1; allowed: above `least`, 1",
    ),
    (
        "[evolution]\nkind = \"map-elites\"\n[[evolution.descriptors]]\nmeasure = \"cells\"\nleast = 0\ngreatest = 9\n\
         [[evolution.descriptors]]\nmeasure = \"cells\"\nleast = 0\ngreatest = 9",
        "evolution.descriptors[1].measure: is \"cells\", again; allowed: each once",
    ),
    (
        "[evolution]\nkind = \"map-elites\"\n[[evolution.descriptors]]\nmeasure = \"cells\"\nleast = 0\ngreatest = 9\n\
         cells = 1001\n[[evolution.descriptors]]\nmeasure = \"end_x_mm\"\nleast = 0\ngreatest = 9\ncells = 1000",
        "evolution.descriptors: have more than 1000000 cells in all; allowed: at most that, or a centroidal archive",
    ),
    (
        "[evolution.archive]\niso = 0.1",
        "test.toml:2:7: evolution.archive.iso: is given; allowed: only with evolution.kind = \"map-elites\"",
    ),
    (
        "[evolution]\ndescriptors = [{ measure = \"cells\", least = 0, greatest = 9 }]",
        "evolution.descriptors: is given; allowed: only with kind = \"map-elites\" or \"novelty\"",
    ),
    (
        "[evolution]\ninitial = [1, 1]",
        "test.toml:2:11: evolution.initial: is [1, 1]; allowed: [minimum, maximum]",
    ),
    (
        "[evolution]\ninitial = [1, 2, 3]",
        "test.toml:2:11: evolution.initial: is [1, 2, 3]; allowed: two numbers from -1000000 to 1000000",
    ),
    (
        "[evolution]\nlimits = [-inf, 5]",
        "test.toml:2:10: evolution.limits: is -inf; allowed: -1000000 to 1000000",
    ),
    (
        "[evolution]\ninit = \"none.npy\"",
        "test.toml:2:8: evolution.init: none.npy: No such file",
    ),
    (
        "[evolution.mutation]\nrate = 1.01",
        "test.toml:2:8: evolution.mutation.rate: is 1.01; allowed: 0 to 1",
    ),
    (
        "[evolution.mutation]\nper = \"bit\"",
        "test.toml:2:7: evolution.mutation.per: is \"bit\"; allowed: gene or individual",
    ),
    (
        "[record]\ncheckpoint_every = 0",
        "test.toml:2:20: record.checkpoint_every: is 0; allowed: 1 to 4294967295",
    ),
    (
        "name = \"../there\"",
        "test.toml:1:8: name: is \"../there\"; allowed: letters, digits, - and _",
    ),
    (
        "seed = -1",
        "test.toml:1:8: seed: is -1; allowed: a whole number from 0 to 9223372036854775807",
    ),
    (
        "[files]\n\"a.sam\" = \"00\"",
        "a.sam: is a file that no other key names",
    ),
    (
        "sensor.part = \"/dev/zero\"",
        "test.toml:1:15: sensor.part: /dev/zero: is a device; allowed: a file",
    ),
    (
        "[evolution]\ninitial_shares = [0.5, 0, 0.5]",
        "test.toml:2:18: evolution.initial_shares: has 3 numbers; allowed: one for each gene, 18, or none",
    ),
    (
        "[evolution]\ninitial_shares = 0.5",
        "test.toml:2:18: evolution.initial_shares: is 0.5; allowed: a list of numbers from 0 to 1000000",
    ),
    (
        "[evolution]\ninitial_shares = [-0.5]",
        "test.toml:2:18: evolution.initial_shares: is -0.5; allowed: 0 to 1000000",
    ),
    (
        "[evolution]\nkind = \"cma-es\"\ninitial_shares = [0.5]",
        "test.toml:3:18: evolution.initial_shares: is given; allowed: only with kind = ",
    ),
    (
        "trials = 10000\n[evolution]\npopulation = 1000000",
        "test.toml:3:14: evolution.population: is 1000000, of 18 genes with 10000 episodes: 1266.7 GB of memory; allowed: up to 4 GB",
    ),
    ("trials = 0", "test.toml:1:10: trials: is 0; allowed: 1 to 10000"),
    ("Ω = 1", "test.toml:1:1"),
];

#[test]
fn refusals_say_where_and_what_is_allowed() {
    let scratch = Scratch::new("refusals");
    let mut wrong = Vec::new();
    for (text, expected) in REFUSED {
        let message = refusal(&scratch, text, &[]);
        if !message.contains(expected) {
            wrong.push(format!("{text}\n gave {message}\n  not {expected}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A value of any length is shown in part, between its place and the allowed values.
#[test]
fn long_values_are_shown_in_part() {
    let scratch = Scratch::new("long");
    let message = refusal(&scratch, &format!("name = \"{}\"", "é".repeat(100_000)), &[]);
    assert!(message.starts_with("test.toml:1:8: name: is \"éé"), "{message}");
    assert!(message.ends_with("since directories are named so"), "{message}");
    assert!(
        message.contains("é .. (") && message.contains(" characters) .. é"),
        "{message}"
    );
    let message = refusal(&scratch, &"#".repeat(oneiro_base::files::GREATEST_TEXT + 1), &[]);
    assert_eq!(message, "test.toml: has 1048577 bytes; allowed: up to 1048576");
    assert!(read(&scratch, &"#".repeat(oneiro_base::files::GREATEST_TEXT), &[]).is_ok());
}

/// Values that only the file's optimiser has are left out if a setting chooses another one.
#[test]
fn a_setting_of_the_optimiser_replaces_its_values() {
    let scratch = Scratch::new("replaced-optimiser");
    let text = "[evolution]\nparents = 10\nelite = 2\n[evolution.mutation]\nkind = \"add_normal\"\nrate = 0.5";
    let population = |set: &[&str]| read(&scratch, text, set).unwrap().settings().evolution.population;
    assert_eq!(population(&["evolution.kind=cma-es"]), 12);
    assert_eq!(population(&["evolution.kind=open-es"]), 40);
    let ranked = read(&scratch, text, &["evolution.selection.kind=rank"]).unwrap();
    let evolution = &ranked.settings().evolution;
    assert_eq!(
        (evolution.population, evolution.elite, evolution.mutation.rate),
        (100, 2, 0.5)
    );
    let text = ranked.resolved_toml(1);
    assert!(text.contains("elite = 2") && !text.contains("parents"), "{text}");
    // Given as a setting with it, such a value is refused.
    let message = refusal(&scratch, "", &["evolution.kind=cma-es", "evolution.elite=1"]);
    assert!(
        message.contains("evolution.elite: is given; allowed: only with"),
        "{message}"
    );
}

#[test]
fn refusals_of_settings_name_the_setting() {
    let scratch = Scratch::new("refused-sets");
    let text = "cycles = 10\n[noise]\nmotor = 0.5\n";
    for (set, expected) in [
        ("cycles=0", "--set cycles=0: cycles: is 0; allowed: 1 to 1000000"),
        (
            "noise.motor=2",
            "--set noise.motor=2: noise.motor: is 2; allowed: 0 to 1",
        ),
        (
            "noise.moter=2",
            "--set noise.moter=2: noise.moter: unknown key `moter`; did you mean noise.motor? (allowed: sensor",
        ),
        (
            "cycles.x=2",
            "--set cycles.x=2: cycles: is a table; allowed: a whole number",
        ),
        (
            "task.speed=fast",
            "--set task.speed=fast: task.speed: is \"fast\"; allowed: unsigned or signed",
        ),
        ("cycles=[1", "--set cycles=[1: "),
        ("cycles=", "--set cycles=: "),
        ("=3", "--set =3: "),
    ] {
        let message = refusal(&scratch, text, &[set]);
        assert!(message.starts_with(expected), "{set} gave {message}");
    }
    assert_eq!(read(&scratch, text, &["cycles"]).map(|_| ()).unwrap_err().code(), 2);
    // A problem in the file is still reported with its line.
    let message = refusal(&scratch, "cycles = 10\n[noise]\nmotor = 5", &["cycles=3"]);
    assert!(message.starts_with("test.toml:3:9: noise.motor"), "{message}");
    // One in a table of the file may come from what a setting adds.
    let text = "[robot]\npreset = \"epuck\"\n[start]\nkind = \"at\"\nx_mm = 100\ny_mm = 90\n\
                [worlds]\ncount = 3\n[worlds.vary]\n\"start.x_mm\" = [90, 95]";
    let set = "worlds.vary={\"start.y_mm\" = [9e4, 9e4]}";
    let message = refusal(&scratch, text, &[set]);
    let expected = format!("test.toml:7:1, --set {set}: worlds: makes world 0 of 3 invalid: ");
    assert!(message.starts_with(&expected), "{message}");
}

/// Files are found relative to the experiment, and a run's copies are checked by their hashes.
#[test]
fn files_are_inputs_with_hashes() {
    let scratch = Scratch::new("inputs");
    let sensors = oneiro::tables::SensorTables::khepera();
    for table in &sensors.classes {
        let path = scratch.path().join(format!("{}.sam", table.class));
        table.write(&path).unwrap();
    }
    oneiro::tables::MotorSamples::khepera()
        .write(scratch.path().join("motor.sam"))
        .unwrap();
    let genes: Vec<u8> = (0..18 * 4_u8).flat_map(|gene| f32::from(gene).to_le_bytes()).collect();
    let header = b"\x93NUMPY\x01\x00\x3b\x00{'descr': '<f4', 'fortran_order': False, 'shape': (4, 18)}\n";
    scratch.write("genes.npy", [&header[..], &genes].concat());
    let text = "[robot]\ntables = [\"wall.sam\", \"./round.sam\"]\nmotors = \"motor.sam\"\n\
                [evolution]\npopulation = 4\nparents = 2\ninit = \"genes.npy\"\n";
    let experiment = read(&scratch, text, &[]).unwrap();
    assert_eq!(experiment.world().spec().robot.sensors, sensors);
    assert_eq!(experiment.evolution(1).ask().genome(1)[0], 18.0);
    assert_eq!(experiment.inputs().len(), 4);

    // As runs do.
    for input in experiment.inputs() {
        scratch.write(&format!("run/{}", input.name), &input.content.bytes);
    }
    let config = scratch.write("run/config.toml", experiment.resolved_toml(3));
    let again = Experiment::read(&config, &[]).unwrap();
    assert_eq!(again.identities().of(3), experiment.identities().of(3));
    assert_eq!(again.evolution(1).ask(), experiment.evolution(1).ask());

    let mut changed = genes;
    changed[0] ^= 1;
    scratch.write("run/inputs/genes.npy", [&header[..], &changed].concat());
    let failure = Experiment::read(&config, &[]).map(|_| ()).unwrap_err();
    assert!(
        failure.code() == 3 && failure.to_string().contains("genes.npy has changed"),
        "{failure}"
    );

    let message = refusal(&scratch, &text.replace("population = 4", "population = 2"), &[]);
    assert!(
        message.contains(
            "test.toml:7:8: evolution.init: genes.npy holds 4 genomes; allowed: 1 to 2, evolution.population"
        ),
        "{message}"
    );
    let message = refusal(&scratch, &text.replace("./round.sam", "wall.sam"), &[]);
    assert!(message.contains("have one name"), "{message}");
    let hidden = refusal(&scratch, text, &["controller.kind=recurrent"]);
    assert!(hidden.contains("evolution.init") && hidden.contains("22"), "{hidden}");
}

/// A robot that senses the floor, in an arena of 300 x 200 mm.
const ON_FLOOR: &str = "[robot]\nkind = \"differential\"\nbody_radius_mm = 20\nwheel_base_mm = 30\ngreatest_speed_mm_s = 100\n\
    sensors = [{ name = \"floor\", kind = \"ground\", offset_mm = 0 }]\n[arena]\nwidth_mm = 300\nheight_mm = 200\n";

/// A picture of a white half to the left and a black one to the right, and of black to the left of white.
fn halves() -> [Vec<u8>; 2] {
    let png = |greys: &[u8]| pixels::written(2, 1, ColorType::Grayscale, BitDepth::Eight, greys);
    [png(&[255, 0]), png(&[0, 255])]
}

#[test]
fn a_picture_lies_where_it_is_said() {
    let scratch = Scratch::new("picture");
    scratch.write("floor.png", &halves()[0]);
    let of = |keys: &str| {
        let experiment = read(
            &scratch,
            &format!("{ON_FLOOR}[arena.picture]\nfile = \"floor.png\"\n{keys}"),
            &[],
        );
        let picture = experiment
            .unwrap()
            .world()
            .spec()
            .arena
            .picture
            .clone()
            .expect("a picture");
        let ([x, y], [width, height]) = (picture.low(), picture.sides());
        (
            [x, y, width, height],
            [picture.columns(), picture.rows()],
            picture.greys().to_vec(),
        )
    };
    let (field, cells, greys) = of("");
    assert_eq!((field, cells), ([0.0, 0.0, 300.0, 200.0], [60, 40]));
    assert!(
        greys
            .chunks(60)
            .all(|row| row[..30] == [255; 30] && row[30..] == [0; 30])
    );
    let (field, cells, greys) = of("x_mm = 100\ny_mm = 90\nsides_mm = [90, 60]\ncell_mm = 30");
    assert_eq!((field, cells), ([55.0, 60.0, 90.0, 60.0], [3, 2]));
    assert_eq!(greys, [255, 128, 0, 255, 128, 0]);
    assert_eq!(of("cell_mm = 10000").2, [128]);
}

/// Runs keep the picture's file and its hash, and are others with another picture.
#[test]
fn a_picture_travels_with_its_runs() {
    let scratch = Scratch::new("pictures");
    let [one, other] = halves();
    scratch.write("floors/floor.png", &one);
    let text = format!("{ON_FLOOR}picture.file = \"floors/floor.png\"\n");
    let experiment = read(&scratch, &text, &[]).unwrap();
    assert_eq!(experiment.inputs().len(), 1);
    for input in experiment.inputs() {
        scratch.write(&format!("run/{}", input.name), &input.content.bytes);
    }
    let config = scratch.write("run/config.toml", experiment.resolved_toml(3));
    // As if it were moved away or drawn anew.
    scratch.write("floors/floor.png", &other);
    let again = Experiment::read(&config, &[]).unwrap();
    assert_eq!(again.identities().of(3), experiment.identities().of(3));
    assert_eq!(again.world().spec(), experiment.world().spec());
    let redrawn = read(&scratch, &text, &[]).unwrap();
    assert_ne!(redrawn.identities().of(3), experiment.identities().of(3));
    let differences = redrawn.task_differences(&experiment);
    assert_eq!(
        differences.iter().map(|found| &*found.key).collect::<Vec<_>>(),
        ["arena.picture.file"]
    );
    scratch.write("run/inputs/floor.png", &other);
    let failure = Experiment::read(&config, &[]).map(|_| ()).unwrap_err();
    assert!(
        failure.code() == 3
            && failure.to_string().contains("arena.picture.file: ")
            && failure.to_string().contains("floor.png has changed"),
        "{failure}"
    );
}

#[test]
fn pictures_that_can_not_lie_on_the_floor_are_refused() {
    let scratch = Scratch::new("wrong-pictures");
    scratch.write("floor.png", &halves()[0]);
    scratch.write("cut.png", &halves()[0][..40]);
    scratch.write("text.png", "no picture");
    let of = |keys: &str| refusal(&scratch, &format!("{ON_FLOOR}{keys}"), &[]);
    for (keys, words) in [
        (
            "picture.file = \"none.png\"",
            "test.toml:10:16: arena.picture.file: none.png: ",
        ),
        (
            "picture.file = \"text.png\"",
            "text.png is no picture that can be read; allowed: PNG, and PGM",
        ),
        ("picture.file = \"cut.png\"", "cut.png is no whole PNG: "),
        (
            "picture.file = \"floor.png\"\npicture.cell_mm = 0.2",
            "is 0.2, which gives 1500 x 1000 cells; allowed: up to 1048576 in all, as with 0.4",
        ),
        (
            "picture.file = \"floor.png\"\npicture.cell_mm = 0.05",
            "arena.picture.cell_mm: is 0.05; allowed: 0.1 to 10000",
        ),
        (
            "picture.file = \"floor.png\"\npicture.x_mm = 99_900\npicture.sides_mm = [300, 9]",
            "arena.picture.x_mm: is 100050; allowed: -100000 to 100000",
        ),
        (
            "picture.x_mm = 20",
            "arena.picture.x_mm: is given; allowed: only with arena.picture.file",
        ),
        (
            "picture.file = \"floor.png\"\n[worlds.vary]\n\"arena.picture.x_mm\" = [0, 90]",
            "worlds.vary: has \"arena.picture.x_mm\", which is no number of a world",
        ),
    ] {
        let message = of(keys);
        assert!(message.contains(words), "{keys}: {message}");
    }
    let sampled = refusal(
        &scratch,
        "[arena]\nwidth_mm = 400\nheight_mm = 300\npicture.file = \"floor.png\"",
        &[],
    );
    assert!(
        sampled.contains("arena.picture: is given, but sampled robots do not sense it"),
        "{sampled}"
    );
    let preset = refusal(
        &scratch,
        "[arena]\npreset = \"open\"\npicture.file = \"floor.png\"",
        &[],
    );
    assert!(preset.contains("arena: has a preset and other keys"), "{preset}");
}

/// Genomes that can't begin an evolution are refused with the reason.
#[test]
fn given_genomes_that_can_not_be_used_are_refused() {
    let scratch = Scratch::new("given");
    let names = world::Controller::Perceptron.layout().names();
    let genome = |gene: &str| vec![gene; 18].join(",");
    scratch.write("one.csv", format!("{}\n{}\n", names.join(","), genome("0.5")));
    scratch.write("far.csv", format!("{}\n{}\n", names.join(","), genome("3")));
    scratch.write("three.csv", format!("{0}\n{0}\n{0}\n", genome("0.5")));
    for (file, values, expected) in [
        (
            "one",
            "kind = \"random\"",
            "is given, but with random all genomes are random; allowed: only with kind = \"genetic\" or ",
        ),
        (
            "one",
            "kind = \"grid\"",
            "is given, but with grid all genomes are those of the grid; allowed: only with kind = ",
        ),
        (
            "three",
            "population = 2\nparents = 1",
            "three.csv holds 3 genomes; allowed: 1 to 2, evolution.population",
        ),
        (
            "far",
            "limits = [-1, 1]",
            "of genome 0 is 3; allowed: -1 to 1, evolution.limits",
        ),
        (
            "far",
            "kind = \"race\"",
            "of genome 0 is 3; allowed: -1 to 1, evolution.initial",
        ),
    ] {
        let text = format!("[evolution]\ninit = \"{file}.csv\"\n{values}\n");
        let record = if values.contains("race") {
            "[record]\nindividuals = false\n"
        } else {
            ""
        };
        let message = refusal(&scratch, &(text + record), &[]);
        assert!(
            message.contains("test.toml:2:8: evolution.init: ") && message.contains(expected),
            "{message}"
        );
    }
    // A strategy takes any number.
    let text = "[evolution]\nkind = \"cma-es\"\npopulation = 4\ninit = \"three.csv\"";
    let text = text.replace("population = 4", "population = 4\nstrategy.sigma = 1e-6");
    let own = read(&scratch, &text, &[]).unwrap();
    let evolution = own.evolution(1);
    assert!(evolution.ask().values().iter().all(|gene| (gene - 0.5).abs() < 1e-4));
    assert_eq!(own.init().map(|(genomes, _)| genomes.len()), Some(3));
}

/// The world's name for any value leads back to its key in the file.
#[test]
fn values_of_worlds_are_refused_by_their_keys() {
    let scratch = Scratch::new("keys");
    let tables: [(&str, &[&str]); 4] = [
        (
            "arena",
            &[
                "radius_mm",
                "nest_radius_mm",
                "food_radius_mm",
                "lamp_behind_wall_mm",
                "light_decay",
                "ambient",
                "light_noise",
            ],
        ),
        (
            "robot",
            &[
                "body_radius_mm",
                "wheel_base_mm",
                "greatest_speed_mm_s",
                "wheel_noise",
                "cruise_mm_s",
                "turn_rad_s",
                "phototaxis_gain",
                "phototaxis_turn_rad_s",
                "phototaxis_threshold",
                "near_mm",
                "escape_s",
                "search_interval_s",
            ],
        ),
        ("messages", &["range_mm", "heard"]),
        (
            "differences",
            &[
                "wheels",
                "proximity",
                "light",
                "slip",
                "beam",
                "reflection",
                "shadows",
                "tracking_loss",
            ],
        ),
    ];
    for (table, keys) in tables {
        for key in keys {
            let file = scratch.write("own.toml", format!("[swarm.{table}]\n{key} = -1e9\n"));
            let refused = runs::read(&file, &[]).unwrap_err().to_string();
            let place = format!(
                "own.toml:2:{}: swarm.{table}.{key}: is -1000000000; allowed: ",
                key.len() + 4
            );
            assert!(refused.contains(&place), "{refused}");
        }
    }
}

/// Names of run directories and hashes of results depend on these bytes: changing them changes the identity of every run. The new files
/// are written next to the old.
#[test]
fn resolved_experiments_keep_their_bytes() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let resolved = root.join("tests/resolved");
    let mut identities = String::new();
    let mut wrong = Vec::new();
    let mut files: Vec<PathBuf> = [root.join("experiments"), resolved.clone()]
        .iter()
        .flat_map(|directory| fs::read_dir(directory).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.parent().unwrap() != resolved || path.to_string_lossy().ends_with(".in.toml"))
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml") && !path.ends_with("Cargo.toml"))
        .collect();
    files.sort_by_key(|path| path.file_name().unwrap().to_owned());
    for path in files {
        let experiment = runs::read(&path, &[]).unwrap();
        let (text, identity) = (experiment.resolved_toml(7), experiment.identities().of(7));
        let stem = path.file_stem().unwrap().to_string_lossy();
        let name = stem.strip_suffix(".in").unwrap_or(&stem);
        wrong.extend(holds(&resolved.join(format!("{name}.toml")), &text).err());
        identities.extend([name, " ", &identity.to_hex(), "\n"]);
        // Anybody may run what a run has recorded.
        let scratch = Scratch::new("recorded");
        for input in experiment.inputs() {
            scratch.write(&input.name, &input.content.bytes);
        }
        let again = runs::read(&scratch.write("config.toml", &text), &[]).and_then(|again| {
            let same = again.identities().of(7) == identity;
            same.then_some(())
                .ok_or_else(|| Failure::failed("is another experiment"))
        });
        wrong.extend(again.err().map(|problem| format!("{name}, as recorded: {problem}")));
    }
    assert!(identities.lines().count() >= 18, "{identities}");
    wrong.extend(holds(&resolved.join("identities.txt"), &identities).err());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Rows of both kinds of experiments, one after the other.
macro_rules! each_kind {
    ($check:ident) => {
        $check::<settings::Settings>();
        $check::<swarm::File>();
    };
}

#[test]
fn keys_are_plain_and_unique() {
    fn check<T: Described>() {
        let mut known = std::collections::BTreeSet::new();
        for row in T::rows() {
            let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "._[]".contains(c);
            assert!(row.key.chars().all(is_plain), "{}", row.key);
            assert!(known.insert(row.key), "{} twice", row.key);
            assert!(row.about.ends_with('.'), "{}: {}", row.key, row.about);
            let unit = match row.unit {
                "mm" => "_mm",
                "s" => "_s",
                "mm/s" => "_mm_s",
                "rad/s" => "_rad_s",
                "turns" => "_turns",
                _ => "",
            };
            assert!(row.key.ends_with(unit), "{} in {}", row.key, row.unit);
        }
    }
    each_kind!(check);
}

/// Settings with a value of each row, even if that requires a list or a choice.
fn with<T: Described>(row: &Parameter<T>) -> T {
    let mut own = values::under(row, None).map_or_else(T::default, |(_, own)| own);
    values::grow(row, &mut own);
    for row in T::rows() {
        if let Some(field) = (row.field)(&mut own, 0)
            && field.get().is_some_and(|datum| values::is_open(&datum))
        {
            let two = Datum::Double(2.0);
            assert!(field.set(&two) || field.set(&Datum::List(vec![two.clone(), two])));
        }
    }
    own
}

/// The problem reported for a value, if any.
fn problem<T: Described>(row: &Parameter<T>, datum: &Datum) -> Option<String> {
    let mut own = with(row);
    let field = (row.field)(&mut own, 0).unwrap();
    if !field.set(datum) && !field.set(&Datum::List(vec![datum.clone(); 2])) {
        return Some(format!("is {datum}; allowed: {}", values::allowed(row, field)));
    }
    match oneiro::parameter::check(T::rows(), &mut own) {
        Err(invalid) if invalid.field == row.name(0) => Some(invalid.problem),
        // This value may limit another one.
        _ => None,
    }
}

#[test]
fn ranges_hold_their_ends_and_nothing_beyond() {
    fn check<T: Described>() {
        let mut ranges = 0;
        for row in T::rows() {
            let of = |key| match oneiro::parameter::value(T::rows(), key, &mut with(row)) {
                Some(Datum::Single(number)) => f64::from(number),
                Some(Datum::Whole(number)) => number as f64,
                other => panic!("{key}: {other:?}"),
            };
            let whole = |least: u64, greatest: u64| {
                let [least, greatest] = [least, greatest].map(i128::from);
                (
                    [least, greatest].map(Datum::Whole),
                    [least - 1, greatest + 1].map(Datum::Whole),
                )
            };
            let number = |least: f64, greatest: f64| {
                if is_single(row) {
                    let [least, greatest] = [least as f32, greatest as f32];
                    let beyond = [least.next_down(), greatest.next_up()];
                    ([least, greatest].map(Datum::Single), beyond.map(Datum::Single))
                } else {
                    let beyond = [least.next_down(), greatest.next_up()];
                    ([least, greatest].map(Datum::Double), beyond.map(Datum::Double))
                }
            };
            let (ends, beyond) = match row.allowed {
                Allowed::Whole(least, greatest) => whole(least, greatest),
                Allowed::WholeUpTo(least, key) => whole(least, of(key) as u64),
                Allowed::Number(least, greatest) => number(least, greatest),
                Allowed::NumberUpTo(least, factor, key) => number(least, factor * of(key)),
                Allowed::Any | Allowed::Text(_) => continue,
            };
            for end in ends {
                assert_eq!(problem(row, &end), None, "{}", row.key);
            }
            for beyond in beyond {
                let problem = problem(row, &beyond).unwrap_or_else(|| panic!("{} may be {beyond}", row.key));
                let is_told = problem.starts_with(&format!("is {beyond}; allowed: "));
                // Kernels can't compute with numbers next to zero.
                assert!(is_told || problem.contains("allowed: 0, or"), "{}: {problem}", row.key);
            }
            ranges += 1;
        }
        assert!(ranges > 20, "{ranges}");
    }
    each_kind!(check);
}

/// Whether a number, or each of a pair, has single precision.
fn is_single<T: Described>(row: &Parameter<T>) -> bool {
    let mut own = with(row);
    let field = (row.field)(&mut own, 0).unwrap();
    let half = Datum::Double(0.5);
    assert!(field.set(&half) || field.set(&Datum::List(vec![half.clone(), half])));
    match field.get() {
        Some(Datum::List(list)) => matches!(list[0], Datum::Single(_)),
        datum => matches!(datum, Some(Datum::Single(_))),
    }
}

#[test]
fn defaults_are_allowed_and_read_back_from_their_text() {
    fn check<T: Described>() {
        let all = values::table(&mut T::default(), &Table::new());
        let text = text(&all);
        let file = Parsed::new("defaults.toml".into(), &text).unwrap();
        let (given, source): (Table, _) = Source::read(&file, &[]).unwrap();
        let mut again = T::default();
        values::read(&given, &mut again, &source).unwrap();
        assert_eq!(values::table(&mut again, &Table::new()), all);
    }
    each_kind!(check);
}

#[test]
fn each_word_of_a_choice_is_taken_and_given_back() {
    fn check<T: Described>() {
        for row in T::rows() {
            let words = (row.field)(&mut with(row), 0).unwrap().choices();
            let mut unwritten = 0;
            for (word, about) in words {
                let mut own = with(row);
                let datum = Datum::Word(word.into());
                assert!((row.field)(&mut own, 0).unwrap().set(&datum), "{} = {word}", row.key);
                let given = (row.field)(&mut own, 0).unwrap().get();
                unwritten += u32::from(given.is_none());
                let is_given = given.is_none() || given == Some(datum);
                assert!(is_given, "{} = {word}: {given:?}", row.key);
                assert!(!about.is_empty(), "{} = {word}", row.key);
            }
            // Only the default may be unwritten.
            assert!(unwritten <= 1, "{}", row.key);
        }
    }
    each_kind!(check);
}

#[test]
fn the_controllers_of_the_documents_are_taken() {
    let scratch = Scratch::new("controllers");
    let page = include_str!("../../../../docs/controllers.md");
    let examples = page
        .split("```toml\n")
        .skip(1)
        .map(|rest| rest.split("```").next().unwrap());
    let genes = examples.map(|example| read(&scratch, example, &[]).unwrap().world().genes());
    let ctrnn = 5 * (8 + 5 + 2) + 2 * 6;
    let elman = 4 * (8 + 4 + 1) + 2 * 5;
    let plastic = 2 * (3 * (8 + 2) + 1);
    assert_eq!(genes.collect::<Vec<_>>(), [ctrnn, 18, elman, plastic]);
}

#[test]
fn values_of_a_network_need_the_kind() {
    let scratch = Scratch::new("networks");
    assert_eq!(
        refusal(&scratch, "[controller]\nactivation = \"tanh\"", &[]),
        "test.toml:2:14: controller.activation: is given; allowed: only with kind = \"network\""
    );
    assert_eq!(
        refusal(
            &scratch,
            "[controller]\nkind = \"network\"\n[[controller.layers]]\nkind = \"gru\"",
            &[]
        ),
        "test.toml:4:8: controller.layers[0].kind: is \"gru\"; allowed: dense, elman, ctrnn, lstm, plastic"
    );
    assert_eq!(
        refusal(
            &scratch,
            "[controller]\nkind = \"network\"\n[[controller.layers]]\nunits = 1025",
            &[]
        ),
        "test.toml:4:9: controller.layers[0].units: is 1025; allowed: 1 to 1024"
    );
    assert_eq!(
        refusal(
            &scratch,
            "[controller]\nkind = \"network\"\n[[controller.layers]]\nslope = 2.0\nkind = \"lstm\"",
            &[]
        ),
        "test.toml:4:9: controller.layers[0].slope: is given; allowed: not with kind = \"lstm\""
    );
}

/// Keys named in the documents, in backticks and with an experiment's table, exist.
#[test]
fn documents_name_keys_that_there_are() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let all: Vec<&str> = Settings::rows().iter().map(|row| row.key).collect();
    let swarm: Vec<&str> = swarm::File::rows().iter().map(|row| row.key).collect();
    let known: Vec<&str> = all.iter().chain(&swarm).copied().collect();
    let is_key = |key: &str| {
        known.iter().any(|row| {
            let row = row.replace("[]", "");
            [row.as_str(), row.strip_prefix("swarm.").unwrap_or_default()]
                .iter()
                .any(|row| *row == key || row.strip_prefix(key).is_some_and(|rest| rest.starts_with('.')))
        })
    };
    let tables: Vec<&str> = known
        .iter()
        .filter_map(|key| key.split_once('.').map(|(table, _)| table))
        .collect();
    let mut wrong = Vec::new();
    let mut named = 0;
    let documents = fs::read_dir(root.join("docs"))
        .unwrap()
        .map(|entry| entry.unwrap().path());
    for path in documents.chain([root.join("README.md")]) {
        // Files of fleets and daemons have other keys; tests beside their readers check these pages.
        let is_other = ["fleet.md", "on-board.md"].iter().any(|page| path.ends_with(page));
        if is_other || path.extension().is_none_or(|extension| extension != "md") {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        for quoted in text.split('`').skip(1).step_by(2) {
            let key = quoted.split([' ', '=']).next().unwrap_or_default();
            // Numbers are indices of lists' elements.
            let parts: Vec<&str> = key.split('.').filter(|part| part.parse::<u32>().is_err()).collect();
            let is_plain = key
                .chars()
                .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || "._".contains(c));
            let last = parts.last().copied().unwrap_or_default();
            let is_file = ["toml", "rs", "svg", "sam", "csv", "npy", "json", "html", "md"].contains(&last);
            if parts.len() > 1 && is_plain && !is_file && tables.contains(&parts[0]) {
                named += 1;
                if !is_key(&parts.join(".")) {
                    wrong.push(format!("{}: {key}", path.display()));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(named > 20, "{named}");
}

#[test]
fn the_reference_page_is_that_of_the_rows() {
    const MARK: &str = "move it here. -->\n";
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs/configuration.md");
    let text = fs::read_to_string(&path).unwrap();
    let (head, _) = text.split_once(MARK).unwrap();
    holds(&path, &format!("{head}{MARK}{}", reference::tables())).unwrap();
}

/// The first experiment of README as `oneiro new` writes it.
fn khepera() -> Start<'static> {
    Start {
        name: "khepera-avoidance",
        robots: Robots::Khepera,
        parts: Vec::new(),
    }
}

/// What `oneiro new` writes is the experiment that ships.
#[test]
fn the_first_experiment_is_that_of_the_rows() {
    let shipped = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../experiments/khepera-avoidance.toml");
    holds(&shipped, &khepera().short()).unwrap();
}

/// Files of an experiment are relative to it; those on the command line are relative to the working directory.
#[test]
fn typed_files_are_looked_for_from_the_working_directory() {
    let scratch = Scratch::new("typed");
    let path = scratch.write("sub/test.toml", "robot.motors = \"motor.sam\"");
    let motors = oneiro::tables::MotorSamples::khepera();
    // A file among the sources would have them compiled again.
    let to_root: PathBuf = std::env::current_dir().unwrap().iter().skip(1).map(|_| "..").collect();
    let here = to_root.join(scratch.path().join("typed.sam").strip_prefix("/").unwrap());
    motors.write(&here).unwrap();
    let set = format!("robot.motors=\"{}\"", here.display());
    let typed = Experiment::read(&path, std::slice::from_ref(&set));
    let beside = Experiment::read(&path, &[]).unwrap_err().to_string();
    fs::remove_file(&here).unwrap();
    assert_eq!(typed.unwrap().inputs().len(), 1);
    assert!(beside.contains("sub/motor.sam: No such file"), "{beside}");
    let gone = Experiment::read(&path, &[set]).unwrap_err().to_string();
    assert!(
        gone.contains(&format!("robot.motors: {}: No such file", here.display())),
        "{gone}"
    );
}

/// Tables made from a surrogate are the files that `oneiro robot sample` would have written: a run's copies of them make the same run.
#[test]
fn a_surrogates_tables_are_inputs_of_its_runs() {
    let scratch = Scratch::new("surrogate");
    let text = "[robot]\ntables = \"surrogate:3\"\nmotors = \"surrogate:3\"\n";
    let made = read(&scratch, text, &[]).unwrap();
    let names: Vec<&str> = made.inputs().iter().map(|input| &*input.name).collect();
    assert_eq!(names, ["inputs/wall.sam", "inputs/round.sam", "inputs/motor.sam"]);
    for input in made.inputs() {
        scratch.write(&format!("run/{}", input.name), &input.content.bytes);
    }
    let config = scratch.write("run/config.toml", made.resolved_toml(3));
    let again = Experiment::read(&config, &[]).unwrap();
    assert_eq!(again.identities().of(3), made.identities().of(3));
    let reality = text.replace("surrogate:3", "reality") + "[reality]\nrobot = \"surrogate:3\"\n";
    let real = read(&scratch, &reality, &[]).unwrap();
    let robot = |of: &Experiment| of.world().spec().robot.clone();
    assert_eq!(robot(&again), robot(&made));
    assert_eq!(robot(&real), robot(&made));
    // A built-in table is no input.
    let built_in = read(&scratch, text, &["robot.motors=khepera"]).unwrap();
    assert_eq!(built_in.inputs().len(), 2);
    let block = read(&scratch, text, &["arena.preset=miglino1995-block"]).unwrap();
    assert_eq!(block.inputs().len(), 4);
    let refused = refusal(&scratch, &text.replace("surrogate:3", "surrogate:x"), &[]);
    assert!(
        refused.contains("is \"surrogate:x\"; allowed: \"khepera\", \"reality\""),
        "{refused}"
    );
}

/// The simulator made from reality is the same as from the files of `oneiro robot sample`, and both severities affect it.
#[test]
fn simulators_are_sampled_from_reality() {
    use crate::reality::Object;
    use crate::reality::sampling;
    use crate::reality::site::Site;

    let of = |more: &str| {
        let text =
            format!("[robot]\ntables = \"reality\"\nmotors = \"reality\"\n[reality]\nrobot = \"surrogate:3\"\n{more}");
        let parsed = Parsed::new("test.toml".into(), &text).unwrap();
        Experiment::of(Path::new("test.toml"), &parsed, &[], &Files::default()).unwrap()
    };
    let own = of("severity = 1.5");
    let engine = crate::engine::handle::Engine::new(
        Box::new(oneiro::cpu::Cpu::new(None).unwrap()),
        std::sync::Arc::default(),
    );
    let mut robot = Site::drawn(3, 1.5)
        .sampled(&engine, &world::WorldSpec::miglino1995())
        .unwrap();
    let samples = sampling::sample_unkept(&mut *robot, &Object::of_the_paper()).unwrap();
    let made = &own.world().spec().robot;
    assert_eq!(made.sensors, samples.sensors);
    let motors = oneiro::tables::MotorTable::new(&samples.motors, oneiro::tables::MotorStates::Symmetric20).unwrap();
    assert_eq!(made.motors.cells, motors.cells);
    // It is part of the world's identity.
    assert_ne!(own.world_identity(), of("severity = 1.0").world_identity());
    // One severity changes sensors, the other one motors. The severity of motion is the same unless it is given.
    let [apart, alike] = [
        "severity = 1.5\nmotion_severity = 0.5",
        "severity = 1.5\nmotion_severity = 1.5",
    ]
    .map(of);
    assert_ne!(apart.world().spec().robot.motors.cells, motors.cells);
    // One difference also changes the motors.
    let wheels = of("severity = 1.5\ndifferences.wheels = 0.5");
    assert_ne!(wheels.world().spec().robot.motors.cells, motors.cells);
    assert_eq!(alike.world().spec().robot.motors.cells, motors.cells);
}
