//! Validation of worlds.

use std::sync::Arc;

use glam::Vec2;
use oneiro::arena::{Arena, Obstacle, Wall};
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::tables::{MotorTable, SensorTable, SensorTables};
use oneiro::world::{Controller, Noise, Start, Task, World, WorldSpec};

fn spec() -> WorldSpec {
    WorldSpec::miglino1995()
}

fn motors(change: impl Fn(&mut MotorTable)) -> Arc<MotorTable> {
    let mut motors = (*spec().robot.motors).clone();
    change(&mut motors);
    Arc::new(motors)
}

fn sensors(change: impl Fn(&mut SensorTables)) -> Arc<SensorTables> {
    let mut sensors = (*spec().robot.sensors).clone();
    change(&mut sensors);
    Arc::new(sensors)
}

/// A table of blocks, which look the same from both of its points of view.
fn block_table() -> SensorTable {
    let mut table = spec().robot.sensors.classes[0].clone();
    table.class = "block".into();
    table.views = 2;
    table.readings = [table.readings.clone(), table.readings].concat();
    table
}

/// Puts the robot into the arena with the block, with a table for it.
fn with_block(spec: &mut WorldSpec) {
    spec.arena = Arena::miglino1995_block();
    spec.robot.sensors = sensors(|sensors| sensors.classes.push(block_table()));
}

/// Gene names are right: without the weight of a named sensor, that sensor doesn't move the named output.
fn at(x: f32, y: f32, heading: f32) -> Start {
    Start::At { x, y, heading }
}

#[test]
fn genes_have_names() {
    let controllers = [
        Controller::Perceptron,
        Controller::Hidden { units: 3 },
        Controller::Recurrent,
    ];
    for controller in &controllers {
        let names = controller.layout().names();
        assert_eq!(names.len(), controller.layout().genes(), "{names:?}");
        let distinct: std::collections::BTreeSet<&String> = names.iter().collect();
        assert_eq!(distinct.len(), names.len(), "{names:?}");
    }
    let [perceptron, hidden, recurrent] = controllers.map(|controller| controller.layout().names());
    assert_eq!(
        [&perceptron[0], &perceptron[8], &perceptron[16]],
        ["left_90_to_left", "bias_left", "back_left_to_right"]
    );
    assert_eq!(
        [&hidden[11], &hidden[19], &hidden[21]],
        ["left_90_to_unit_1", "bias_unit_1", "unit_1_to_right"]
    );
    assert_eq!([&hidden[33], &hidden[34]], ["bias_left", "bias_right"]);
    assert_eq!(
        [&recurrent[8], &recurrent[20]],
        ["previous_left_to_left", "previous_right_to_right"]
    );
}

#[test]
fn a_block_is_solid_to_its_corners() {
    let mut spec = spec();
    with_block(&mut spec);
    // A centre is free in 545 x 295 mm, less two discs of 55 mm radius and the points within 27.5 mm of the block.
    let discs = std::f32::consts::PI * (2.0 * 55.0 * 55.0 + 27.5 * 27.5);
    let block = 110.0 * 55.0 + 2.0 * 27.5 * (110.0 + 55.0);
    let free = (545.0 * 295.0 - discs - block) / (600.0 * 350.0);
    let estimate = World::new(spec.clone()).unwrap().free_share();
    assert!((estimate - free).abs() < 0.01, "{estimate}, not {free}");
    // 27 mm from a corner, along the diagonal of the block; and 28 mm.
    let [corner, ..] = spec.arena.blocks[0].corners();
    let centre = Vec2::new(spec.arena.blocks[0].x, spec.arena.blocks[0].y);
    for (gap, free) in [(27.0, false), (28.0, true), (-20.0, false)] {
        let at = corner + gap * (corner - centre).normalize();
        spec.start = Start::At {
            x: at.x,
            y: at.y,
            heading: 0.0,
        };
        assert_eq!(World::new(spec.clone()).is_ok(), free, "{gap} mm from a corner");
    }
}

#[test]
fn the_catalogue_is_liveable() {
    for name in Arena::NAMES {
        let arena = Arena::named(name).unwrap();
        assert_eq!(arena.name, name);
        let mut spec = WorldSpec {
            arena: arena.clone(),
            ..spec()
        };
        spec.robot.sensors = sensors(|sensors| sensors.classes.push(block_table()));
        let world = World::new(spec).unwrap();
        assert!(world.free_share() > 0.5, "{name}: {}", world.free_share());
        let bounds = arena.bounds();
        assert!(
            bounds.width >= arena.field.width && bounds.height >= arena.field.height,
            "{name}"
        );
    }
    assert!(Arena::named("elsewhere").is_none());
}

#[test]
fn the_1995_arena_is_as_the_paper_has_it() {
    let arena = Arena::miglino1995();
    let field = arena.field;
    assert_eq!((field.x, field.y, field.width, field.height), (0.0, 0.0, 600.0, 350.0));
    assert_eq!((arena.walls.len(), arena.obstacles.len()), (4, 3));
    assert!(
        arena
            .obstacles
            .iter()
            .all(|obstacle| obstacle.radius == 27.5 && obstacle.class == "round")
    );
    // A centre is free in 545 x 295 mm, less three discs of 55 mm radius.
    let free = (545.0 * 295.0 - 3.0 * std::f32::consts::PI * 55.0 * 55.0) / (600.0 * 350.0);
    let estimate = World::new(spec()).unwrap().free_share();
    assert!((estimate - free).abs() < 0.01, "{estimate}, not {free}");
}

#[test]
fn the_number_of_genes_is_as_documented() {
    for (controller, genes) in [
        (Controller::Perceptron, 18),
        (Controller::Hidden { units: 5 }, 57),
        (Controller::Recurrent, 22),
    ] {
        assert_eq!(World::new(WorldSpec { controller, ..spec() }).unwrap().genes(), genes);
    }
}

#[test]
fn an_arena_without_objects_is_allowed() {
    let arena = Arena {
        walls: Vec::new(),
        obstacles: Vec::new(),
        ..Arena::miglino1995()
    };
    assert_eq!(World::new(WorldSpec { arena, ..spec() }).unwrap().free_share(), 1.0);
}

#[test]
fn headings_are_from_0_to_less_than_1() {
    for (given, expected) in [(-0.25, 0.75), (1.0, 0.0), (-1.0, 0.0), (-1e-6, 1.0 - 1e-6), (0.5, 0.5)] {
        let mut spec = WorldSpec::miglino1995();
        spec.start = at(90.0, 90.0, given);
        let Start::At { heading, .. } = World::new(spec).unwrap().spec().start else {
            panic!("it starts at a place");
        };
        assert_eq!(heading, expected, "{given}");
        assert!((0.0..1.0).contains(&heading), "{given}");
    }
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table of everything that is refused")]
fn invalid_values_are_refused_by_name() {
    type Change = fn(&mut WorldSpec);
    let cases: [(&str, &str, Change); 55] = [
        ("cycles", "1 to 1000000", |spec| spec.cycles = 0),
        ("cycles", "1 to 1000000", |spec| spec.cycles = 1_000_001),
        ("controller.units", "1 to 32", |spec| {
            spec.controller = Controller::Hidden { units: 0 };
        }),
        ("controller.units", "1 to 32", |spec| {
            spec.controller = Controller::Hidden { units: 33 };
        }),
        ("robot.body_radius_mm", "is 0;", |spec| spec.robot.body_radius = 0.0),
        ("robot.body_radius_mm", "is NaN;", |spec| {
            spec.robot.body_radius = f32::NAN;
        }),
        ("robot.body_radius_mm", "is inf;", |spec| {
            spec.robot.body_radius = f32::INFINITY;
        }),
        ("robot.turn_before_move", "0 to 1", |spec| {
            spec.robot.turn_before_move = 1.5;
        }),
        ("robot.turn_before_move", "is 1e-40;", |spec| {
            spec.robot.turn_before_move = 1e-40;
        }),
        ("noise.sensor", "-1 to 1", |spec| spec.noise.sensor = (0.0, 1.1)),
        ("noise.sensor", "[minimum, maximum]", |spec| {
            spec.noise.sensor = (0.4, 0.0);
        }),
        ("noise.sensor", "[minimum, maximum]", |spec| {
            spec.noise.sensor = (0.2, 0.2);
        }),
        ("noise.sensor", "is NaN", |spec| spec.noise.sensor = (f32::NAN, 0.2)),
        ("noise.walk_range_mm", "0 to 1000", |spec| spec.noise.walk_range = -1.0),
        ("noise.walk_step_mm", "twice", |spec| {
            spec.noise = Noise {
                walk_range: 1.0,
                walk_step: 2.5,
                ..Noise::NONE
            }
        }),
        ("noise.walk_step_mm", "twice", |spec| spec.noise.walk_step = 1.0),
        ("noise.motor", "0 to 1", |spec| spec.noise.motor = 1.01),
        ("start.x_mm", "-100000 to 100000", |spec| spec.start = at(1e6, 0.0, 0.0)),
        ("start.x_mm", "is 601; allowed: 0 to 600", |spec| {
            spec.start = at(601.0, 90.0, 0.0);
        }),
        ("start.y_mm", "is -1; allowed: 0 to 350", |spec| {
            spec.start = at(90.0, -1.0, 0.0);
        }),
        ("start.heading_turns", "-1 to 1", |spec| {
            spec.start = at(90.0, 90.0, 1.5);
        }),
        ("start.heading_turns", "-1 to 1", |spec| {
            spec.start = at(90.0, 90.0, -1.5);
        }),
        ("start", "touches", |spec| spec.start = at(20.0, 90.0, 0.0)),
        ("arena.width_mm", "1 to 100000", |spec| spec.arena.field.width = 0.5),
        ("arena", "is NaN", |spec| spec.arena.field.x = f32::NAN),
        ("arena", "free in 0 %", |spec| {
            spec.arena = Arena::rectangle(50.0, 350.0);
        }),
        ("arena", "25 %", |spec| {
            spec.arena = Arena::rectangle(100.0, 100.0);
        }),
        ("arena.walls[2].to_mm", "-100000 to 100000", |spec| {
            spec.arena.walls[2].to[1] = 1e9;
        }),
        ("arena.walls[1]", "at least 1 mm", |spec| {
            spec.arena.walls[1].to = spec.arena.walls[1].from;
        }),
        ("arena.walls[0]", "differ by", |spec| {
            spec.arena.walls[0] = Wall {
                from: [0.0, 0.000_01],
                to: [600.0, 0.000_010_5],
                class: "wall".into(),
            };
        }),
        ("arena.walls[3].class", "allowed: wall, round", |spec| {
            spec.arena.walls[3].class = "glass".into();
        }),
        ("arena.obstacles[0].radius_mm", "0 to 100000", |spec| {
            spec.arena.obstacles[0].radius = -1.0;
        }),
        ("arena.obstacles[2].class", "no sensor table for `box`", |spec| {
            spec.arena.obstacles[2].class = "box".into();
        }),
        ("arena", "0 to 64", |spec| {
            spec.arena = Arena::miglino1995().with_obstacles((0..58).map(|at| (at as f32, 0.0)), 1.0);
        }),
        ("arena.blocks[0].length_mm", "1 to 100000", |spec| {
            with_block(spec);
            spec.arena.blocks[0].length = 0.0;
        }),
        ("arena.blocks[0].width_mm", "is NaN", |spec| {
            with_block(spec);
            spec.arena.blocks[0].width = f32::NAN;
        }),
        ("arena.blocks[0].heading_turns", "-1 to 1", |spec| {
            with_block(spec);
            spec.arena.blocks[0].heading = 1.5;
        }),
        ("arena.blocks[0].class", "allowed: wall, round", |spec| {
            spec.arena = Arena::miglino1995_block();
        }),
        ("arena.obstacles[1].class", "2 points of view", |spec| {
            with_block(spec);
            spec.arena.obstacles[1].class = "block".into();
        }),
        ("robot.sensors.classes[2].views", "1 to 64", |spec| {
            with_block(spec);
            let mut sensors = (*spec.robot.sensors).clone();
            sensors.classes[2].views = 0;
            spec.robot.sensors = Arc::new(sensors);
        }),
        ("task.new_cell", "0 to 1000", |spec| {
            spec.task = Task::AVOIDANCE.with_new_cell(-1.0);
        }),
        ("task.new_cell", "up to 128 cells", |spec| {
            spec.task = Task::AVOIDANCE.with_new_cell(1.0);
            spec.arena = Arena::rectangle(1000.0, 1000.0);
        }),
        ("task.new_cell", "surrogate's episode", |spec| {
            spec.task = Task::AVOIDANCE.with_new_cell(1.0);
            spec.surrogate = Some(Arc::new(Surrogate::drawn(1, Differences::all(1.0))));
        }),
        ("robot.motors.states", "1 to 256", |spec| {
            spec.robot.motors = motors(|motors| motors.states = 0);
        }),
        ("robot.motors.cells", "states times states", |spec| {
            spec.robot.motors = motors(|motors| motors.states = 19);
        }),
        ("robot.motors.scale", "0 to 1000", |spec| {
            spec.robot.motors = motors(|motors| motors.scale = -20.0);
        }),
        ("robot.motors.offset", "0 to 1000", |spec| {
            spec.robot.motors = motors(|motors| motors.offset = f32::NAN);
        }),
        ("robot.motors.cells[7].turn", "-0.5 to 0.5", |spec| {
            spec.robot.motors = motors(|motors| motors.cells[7].turn = 0.6);
        }),
        ("robot.motors", "crosses a wall", |spec| {
            spec.robot.motors = motors(|motors| motors.cells[7].displacement = 55.0);
        }),
        ("robot.sensors.reading_scale", "is 0;", |spec| {
            spec.robot.sensors = sensors(|sensors| sensors.reading_scale = 0.0);
        }),
        ("robot.sensors.classes[1].readings[31]", "0 to 1023", |spec| {
            spec.robot.sensors = sensors(|sensors| sensors.classes[1].readings[8 * 3 + 7] = 1024);
        }),
        (
            "robot.sensors.classes[1].readings",
            "views times rows times bearings times sensors, 28800",
            |spec| {
                spec.robot.sensors = sensors(|sensors| sensors.classes[1].readings.truncate(100));
            },
        ),
        ("robot.sensors.classes[1]", "another shape", |spec| {
            spec.robot.sensors = sensors(|sensors| sensors.classes[1].nearest = 6.0);
        }),
        ("robot.sensors.classes[1]", "second table of the class wall", |spec| {
            spec.robot.sensors = sensors(|sensors| sensors.classes[1].class = "wall".into());
        }),
        ("robot.sensors.classes[0].spacing", "0.01 to 1000", |spec| {
            spec.robot.sensors = sensors(|sensors| sensors.classes[0].spacing = 0.0);
        }),
    ];
    for (field, problem, change) in cases {
        let mut spec = spec();
        change(&mut spec);
        let Err(invalid) = World::new(spec) else {
            panic!("{field} ({problem}) was accepted")
        };
        assert_eq!(invalid.field, field, "{invalid}");
        assert!(invalid.problem.contains(problem), "{invalid}, not {problem}");
        let names_what_is_allowed = invalid.problem.contains("; allowed");
        assert!(names_what_is_allowed, "{invalid}");
    }
}

#[test]
fn as_many_objects_as_sixteen_bits_can_sum_are_allowed() {
    let mut arena = Arena::rectangle(2000.0, 2000.0);
    arena.obstacles = (0..60)
        .map(|index| Obstacle {
            x: 100.0 + 25.0 * index as f32,
            y: 1000.0,
            radius: 10.0,
            class: "round".into(),
        })
        .collect();
    World::new(WorldSpec { arena, ..spec() }).unwrap();
}
