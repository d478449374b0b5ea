//! Limits of a world's numbers. They are far beyond any use, and keep every number that a kernel computes finite and
//! normal, because machines differ in subnormals.

use std::collections::BTreeSet;

use glam::Vec2;
use oneiro_shaders::episode;

use crate::batch::WorldKind;
use crate::foragers::foraging;
pub(super) use crate::parameter::LEAST;
use crate::parameter::{self, Choice, Invalid, allowed_number, integer, length, number};
use crate::parts::compose::{GREATEST_GENES, Kind, OwnPart};
use crate::parts::network::Network;
use crate::world::arena::{Arena, Field, GREATEST_OBJECTS, GREATEST_PATCHES, GREATEST_SEEN, Wall};
use crate::world::body::Collision;
use crate::world::described::{Described, Drive, Together};
use crate::world::discs::Discs;
use crate::world::near::may_look_by_grid;
use crate::world::noise::Noise;
use crate::world::pack;
use crate::world::parameters::{COORDINATE, LENGTH, PARAMETERS};
use crate::world::physics::Physics;
use crate::world::reference::Model;
use crate::world::robot::{Build, Robot};
use crate::world::spec::{Controller, Task, WorldSpec};
use crate::world::start::{Area, GREATEST_POSES, Start};
use crate::world::tables::{self, GREATEST_READING, MotorTable, SENSORS, SensorTable, SensorTables};

/// The sensors' sums of readings are 16 bits wide.
const _: () = assert!(episode::GREATEST_SHAPES * GREATEST_READING as u32 <= u16::MAX as u32);

/// Most cells whose visits an episode records.
const GREATEST_CELLS: usize = episode::GREATEST_CELLS as usize;

/// Checks a world, and returns its robot's physics.
pub(super) fn check(spec: &mut WorldSpec) -> Result<Physics, Invalid> {
    parameter::check(&PARAMETERS, spec)?;
    turned(spec);
    forager(spec)?;
    robot(&spec.robot)?;
    let physics = physics(spec)?;
    arena(&spec.arena, spec.robot.tables())?;
    few_objects(spec, &physics)?;
    start(spec)?;
    spec.noise.check(&spec.robot.build)?;
    if let Some(individual) = &spec.surrogate {
        individual.check(|difference| spec.robot.differs_by(difference))?;
        surrogate(spec, &physics)?;
    }
    if let Controller::Network(layers) = &spec.controller {
        network(layers, spec)?;
    }
    if let Controller::StateMachine(_) | Controller::BehaviourTree(_) = &spec.controller {
        modules(spec, &physics)?;
    }
    own_parts(spec)?;
    if let Some(ready) = spec.task.ready() {
        let values = spec.own.get(Kind::Task).map(OwnPart::named_values);
        ready.check(&spec.arena, &spec.pucks, &values.unwrap_or_default())?;
        if ready.is_for_swarms() && physics.together().is_none() {
            let problem = format!("is `{}`; allowed: only in swarms, with robot.count", ready.word);
            return Err(Invalid::new("task.kind", problem));
        }
    }
    together(spec, &physics)?;
    new_cell(spec)?;
    greatest_speed(spec, &physics)?;
    Ok(physics)
}

/// Checks what is particular to a kind of robot, and returns its physics.
pub(super) fn physics(spec: &WorldSpec) -> Result<Physics, Invalid> {
    let individual = spec.surrogate.clone();
    if !matches!(spec.robot.build, Build::Differential(_)) {
        spec.pucks.check(None, spec.robot.body_radius)?;
    }
    Ok(match &spec.robot.build {
        Build::Sampled => {
            if spec.own.is_empty() {
                only_walls(&spec.arena)?;
            }
            eight_sensors(&spec.robot.sensors)?;
            individual.map_or(Physics::Sampled, Physics::Individual)
        }
        Build::Differential(robot) => {
            let mut robot = robot.check(&spec.own.readings(), &spec.robot.body(), &spec.arena)?;
            spec.pucks.add_to(&mut robot, spec.robot.body_radius)?;
            Physics::Described(robot, individual)
        }
        Build::Forager(forager) => Physics::Forager(*forager),
    })
}

/// Writes each direction as turns from 0 to less than 1.
fn turned(spec: &mut WorldSpec) {
    let Arena { blocks, patches, .. } = &mut spec.arena;
    let starts: Vec<&mut f32> = match &mut spec.start {
        Start::At { heading, .. } => vec![heading],
        Start::Poses(poses) => poses.0.iter_mut().map(|[.., heading]| heading).collect(),
        Start::Random | Start::Zone(_) => Vec::new(),
    };
    let blocks = blocks.iter_mut().map(|block| &mut block.heading);
    let patches = patches.iter_mut().map(|patch| &mut patch.heading);
    for heading in blocks.chain(patches).chain(starts) {
        *heading -= heading.floor();
    }
}

/// Checks what only foragers have, and gives them their arena and their body.
fn forager(spec: &mut WorldSpec) -> Result<(), Invalid> {
    let Build::Forager(mut forager) = spec.robot.build else {
        for (key, is_given, word) in [
            (
                "controller.kind",
                spec.controller == Controller::Behaviours,
                spec.controller.word(),
            ),
            ("task.kind", spec.task == Task::Foraging, spec.task.word()),
        ] {
            if is_given {
                let problem = format!("is `{word}`; allowed: only with robot.kind = \"forager\"");
                return Err(Invalid::new(key, problem));
            }
        }
        return Ok(());
    };
    forager.foraging.cycles = spec.cycles;
    forager.foraging.start = match spec.start {
        Start::At { x, y, heading } => Some([x, y, heading]),
        _ => None,
    };
    forager.foraging.check()?;
    let arena = forager.arena();
    let readings = spec.own.readings();
    let taken = readings.iter().find(|name| foraging::READINGS.contains(&name.as_str()));
    let refused = [
        (
            "arena",
            spec.arena != Arena::default() && spec.arena != arena,
            "is given; allowed: none, a forager's is round (arena.radius_mm)".to_owned(),
        ),
        (
            "noise",
            spec.noise != Noise::NONE,
            "is not zero for a forager; allowed: none, since arena.light_noise and robot.wheel_noise are a forager's \
             noise"
                .to_owned(),
        ),
        (
            "start.kind",
            matches!(spec.start, Start::Zone(_)),
            "is `zone` for a forager; allowed: random, at and poses".to_owned(),
        ),
        (
            "robot.collision",
            spec.robot.collision != Collision::Undo,
            "is given; allowed: none, the wall stops a forager, which still turns".to_owned(),
        ),
        (
            "sensor.part",
            taken.is_some(),
            format!(
                "has a reading called `{}` as a forager has; allowed: another name",
                taken.map_or("", String::as_str)
            ),
        ),
    ];
    if let Some((key, _, problem)) = refused.into_iter().find(|(_, is_refused, _)| *is_refused) {
        return Err(Invalid::new(key, problem));
    }
    spec.robot.body_radius = forager.foraging.body_radius;
    spec.robot.build = Build::Forager(forager);
    spec.arena = arena;
    Ok(())
}

/// Checks that an arena has nothing that only parametric robots see.
fn only_walls(arena: &Arena) -> Result<(), Invalid> {
    let lists = [
        ("lights", arena.lights.is_empty()),
        ("floor", arena.floor.is_none()),
        ("picture", arena.picture.is_none()),
        ("patches", arena.patches.is_empty()),
    ];
    match lists.into_iter().find(|(_, is_empty)| !is_empty) {
        None => Ok(()),
        Some((list, _)) => {
            let problem = "is given, but sampled robots do not sense it; allowed: none, custom parts that look at it, or \
                           robot.kind = \"differential\"";
            Err(Invalid::new(format!("arena.{list}"), problem))
        }
    }
}

/// Checks that tables are those of a sampled robot.
fn eight_sensors(tables: &SensorTables) -> Result<(), Invalid> {
    let is_other = |table: &SensorTable| table.sensors != SENSORS as u32;
    match tables.classes.iter().position(is_other) {
        None => Ok(()),
        Some(index) => {
            let count = tables.classes[index].sensors;
            let problem = format!(
                "is {count}; allowed: {SENSORS}, a Khepera's, or robot.kind = \"differential\" with {count} sensors of the kind sampled"
            );
            Err(Invalid::new(format!("robot.sensors.classes[{index}].sensors"), problem))
        }
    }
}

/// Checks that an arena has only so many objects as a robot's kernel looks at.
fn few_objects(spec: &WorldSpec, physics: &Physics) -> Result<(), Invalid> {
    if may_look_by_grid(physics) || spec.arena.objects() <= GREATEST_SEEN {
        return Ok(());
    }
    let problem = format!(
        "{} walls, obstacles and blocks; allowed: 0 to {} together, and {} with a parametric robot without sampled sensors, robot.model and \
         surrogate",
        spec.arena.objects(),
        GREATEST_SEEN,
        GREATEST_OBJECTS
    );
    Err(Invalid::new("arena", problem))
}

/// Checks the rest of a surrogate's world.
fn surrogate(spec: &WorldSpec, physics: &Physics) -> Result<(), Invalid> {
    if let Physics::Forager(_) = physics {
        let problem =
            "is `forager` in a surrogate's episode; allowed: another kind, since food exists only in the simulator";
        return Err(Invalid::new("robot.kind", problem));
    }
    if physics.described().and_then(Described::wheel_noise).is_some() {
        let problem = "is set in a surrogate's episode; allowed: none, since its wheels have noise";
        return Err(Invalid::new("robot.wheel_noise", problem));
    }
    if spec.noise != Noise::NONE {
        let problem = "is not zero in a surrogate's episode; allowed: none, since its sensors have noise";
        return Err(Invalid::new("noise", problem));
    }
    if matches!(physics, Physics::Individual(_)) && spec.robot.collision != Collision::Undo {
        let problem = "is not `Undo` in a surrogate's episode; allowed: `Undo`, since its slip says how it slides";
        return Err(Invalid::new("robot.collision", problem));
    }
    Ok(())
}

/// Refuses robots without the readings that modules use.
fn modules(spec: &WorldSpec, physics: &Physics) -> Result<(), Invalid> {
    let model = physics.described().and_then(Described::model);
    if model.is_some_and(|(model, _)| *model == Model::Vectors) {
        return Ok(());
    }
    let kind = spec.controller.word();
    let problem = format!("is `{kind}`; allowed: only with robot.model = \"rm1.1-vectors\"");
    Err(Invalid::new("controller.kind", problem))
}

/// Checks a network, and that its genes have different names.
fn network(network: &Network, spec: &WorldSpec) -> Result<(), Invalid> {
    let readings = spec.readings();
    network.check(&readings, GREATEST_GENES)?;
    let mut names = BTreeSet::new();
    let genes = network.genes(&readings);
    let Some(twice) = genes.iter().find(|gene| !names.insert(&gene.name)) else {
        return Ok(());
    };
    let is_named = |reading: &String| twice.name.starts_with(&format!("{reading}_to_"));
    let index = readings.iter().position(is_named).unwrap_or_default();
    let key = match spec.robot.described_sensors().get(index) {
        Some(_) => format!("robot.sensors[{index}].name"),
        None => "sensor.part".to_owned(),
    };
    let problem = format!(
        "the reading `{}` gives two genes of the network the name `{}`; allowed: another reading's name",
        readings[index], twice.name
    );
    Err(Invalid::new(key, problem))
}

/// Checks that a user's parts are there where a world asks for them.
fn own_parts(spec: &WorldSpec) -> Result<(), Invalid> {
    let parts = [
        (Kind::Controller, spec.controller == Controller::Own),
        (Kind::Task, spec.task.is_part()),
    ];
    for (kind, is_own) in parts {
        if is_own != spec.own.get(kind).is_some() {
            let problem = "and `own` disagree; allowed: `Own` with a part of this kind, or another without";
            return Err(Invalid::new(format!("{}.kind", kind.word()), problem));
        }
    }
    Ok(())
}

/// Checks the rest of a swarm's world, and that others have no mission.
fn together(spec: &WorldSpec, physics: &Physics) -> Result<(), Invalid> {
    const SINGLE: &str = "allowed: only without robot.count";
    let task = spec.own.get(Kind::Task).map(OwnPart::part);
    let Some(Together { count, .. }) = physics.together() else {
        return match task {
            Some(part) if part.has_mission() => {
                let problem = "has a mission (`mission_cycle`); allowed: only in swarms, with robot.count";
                Err(Invalid::new("task.part", problem))
            }
            _ => Ok(()),
        };
    };
    for own in spec.own.iter() {
        if let Some(end) = own.part().end_function() {
            let problem = format!(
                "has `{end}`, which ends only a single robot's episode; `mission_ends` ends a swarm's; {SINGLE}"
            );
            return Err(Invalid::new(format!("{}.part", own.part().kind().word()), problem));
        }
    }
    let refused = [
        ("start.kind", matches!(spec.start, Start::At { .. }), "is `at`"),
        ("noise.walk_range_mm", spec.noise.walk_range != 0.0, "is not 0"),
    ];
    if let Some((key, _, problem)) = refused.into_iter().find(|(_, is_refused, _)| *is_refused) {
        return Err(Invalid::new(key, format!("{problem}; {SINGLE}")));
    }
    let (bounds, pucks) = (spec.arena.start_bounds(), physics.pucks());
    let placed = |key: &str, places: &[[f32; 2]]| match places.iter().find(|[x, y]| !bounds.contains(*x, *y)) {
        Some([x, y]) => {
            let problem = format!("has ({x}, {y}) mm, outside of the arena; allowed: places in it");
            Err(Invalid::new(key, problem))
        }
        None => Ok(()),
    };
    placed("pucks.places_mm", pucks.map_or(&[], Discs::places))?;
    let places = physics.start_places();
    let drawn_pucks = pucks.filter(|pucks| pucks.places().is_empty());
    if !places.is_empty() {
        if spec.start != Start::Random {
            let problem = "is given together with robot.starts_mm; allowed: either";
            return Err(Invalid::new("start.kind", problem));
        }
        placed("robot.starts_mm", places)?;
    }
    // Bodies keep the others' centres out of discs; a draw finds a place with a chance of a half.
    let body = spec.robot.body_radius;
    let disc = |one: f32, other: f32| std::f32::consts::PI * (one + other) * (one + other);
    if let Some(pucks) = drawn_pucks {
        let largest = body.max(pucks.radius);
        let Field { width, height, .. } = spec.arena.field;
        let area = Area::of(&Start::Random, &spec.arena)?;
        let free = pack::free_share(spec, physics, area, largest - body);
        let room = 0.5 * free * width * height - *count as f32 * disc(body, largest);
        let most = (room / disc(pucks.radius, largest)).max(0.0).floor();
        if pucks.count as f32 > most {
            let problem = format!(
                "is {}, but half of the arena has room for {most} beside the robots, so that random places are found soon; allowed: \
                 fewer, pucks.places_mm, or a larger arena",
                pucks.count
            );
            return Err(Invalid::new("pucks.count", problem));
        }
    }
    if !spec.start.is_drawn() || !places.is_empty() {
        return Ok(());
    }
    let area = Area::of(&spec.start, &spec.arena)?;
    let Field { width, height, .. } = area.bounds();
    let placed = pucks.map_or(0.0, |pucks| pucks.places().len() as f32 * disc(body, pucks.radius));
    let room = 0.5 * pack::free_share(spec, physics, area, 0.0) * width * height - placed;
    let most = (room / disc(body, body)).max(0.0).floor();
    if *count as f32 <= most {
        return Ok(());
    }
    if matches!(spec.start, Start::Zone(_)) {
        let problem = format!(
            "is a zone half of which has room for the starts of {most} of {count} robots, so that random places are found soon; \
             allowed: a larger zone, a smaller robot.count, or start.kind = \"poses\""
        );
        return Err(Invalid::new("start", problem));
    }
    if let Some(radius) = start_radius(&spec.arena) {
        let problem = format!(
            "is {radius}, and half of that disc has room for the starts of {most} of {count} robots, so that random places are found \
             soon; allowed: a larger radius, or a smaller robot.count"
        );
        return Err(Invalid::new("arena.start_radius_mm", problem));
    }
    let problem = format!(
        "is {count}, but half of the arena has room for the starts of {most}, so that random places are found soon; allowed: fewer, \
         start.kind = \"poses\", or a larger arena"
    );
    Err(Invalid::new("robot.count", problem))
}

/// Radius of the disc that robots start in, if a larger one is possible.
fn start_radius(arena: &Arena) -> Option<f32> {
    let Field { x, y, width, .. } = arena.field;
    let radius = 0.5 * width;
    let middle = Vec2::new(x + radius, y + radius);
    let rooms = arena.polygon_sides().iter().map(|side| side.room(middle));
    // The largest possible disc is rounded.
    let is_larger_possible = radius + 0.01 < rooms.fold(f32::INFINITY, f32::min);
    (arena.is_field_round && is_larger_possible).then_some(radius)
}

/// Checks the value of a new cell.
fn new_cell(spec: &WorldSpec) -> Result<(), Invalid> {
    if !matches!(spec.task, Task::Avoidance { new_cell, .. } if new_cell > 0.0) {
        return Ok(());
    }
    let Field { width, height, .. } = spec.arena.field;
    let cells = pack::cells(width) * pack::cells(height);
    if spec.surrogate.is_some() {
        let problem = "is not zero in a surrogate's episode; allowed: 0, since a robot can't measure its place";
        return Err(Invalid::new("task.new_cell", problem));
    }
    if cells > GREATEST_CELLS {
        let problem = format!(
            "is not zero in a field of {cells} cells; allowed: 0, or a field of up to {GREATEST_CELLS} cells of {} mm",
            episode::CELL
        );
        return Err(Invalid::new("task.new_cell", problem));
    }
    Ok(())
}

/// Checks that no robot can jump over a wall, which it could if it moved farther than its diameter in a cycle.
fn greatest_speed(spec: &WorldSpec, physics: &Physics) -> Result<(), Invalid> {
    let diameter = 2.0 * spec.robot.body_radius;
    let key = match physics {
        Physics::Described(robot, _) if matches!(robot.drive, Drive::Wheels(_)) => "robot.greatest_speed_mm_s",
        Physics::Described(..) | Physics::Sampled | Physics::Individual(_) => "robot.motors",
        // Its wall is a circle, which it is always within.
        Physics::Forager(_) => return Ok(()),
    };
    let farthest = farthest(spec, physics);
    if farthest >= diameter {
        let problem = format!(
            "the maximum displacement of a cycle is {farthest} mm, noise included; allowed: less than the body's \
             diameter, {diameter} mm, so that no robot crosses a wall"
        );
        return Err(Invalid::new(key, problem));
    }
    Ok(())
}

/// Maximum displacement in a cycle, including noise, mm; not for foragers.
pub(super) fn farthest(spec: &WorldSpec, physics: &Physics) -> f32 {
    let described = physics.described().and_then(|robot| robot.drive.farthest());
    let sampled = || {
        let cells = spec.robot.motors.cells.iter();
        cells.map(|cell| cell.displacement.abs()).fold(0.0, f32::max)
    };
    described.unwrap_or_else(sampled) * (1.0 + spec.noise.motor)
}

fn robot(robot: &Robot) -> Result<(), Invalid> {
    number("robot.sensors.reading_scale", robot.sensors.reading_scale, LEAST..=1.0)?;
    for (index, table) in robot.sensors.classes.iter().enumerate() {
        sensor_table(&format!("robot.sensors.classes[{index}]"), table)?;
        let first = &robot.sensors.classes[0];
        let shape = |table: &SensorTable| (table.sensors, table.rows, table.bearings, table.nearest, table.spacing);
        if shape(table) != shape(first) {
            let problem = format!(
                "has another shape than the class {}; allowed: tables of one shape",
                first.class
            );
            return Err(Invalid::new(format!("robot.sensors.classes[{index}]"), problem));
        }
        if robot.sensors.class(&table.class) != Some(index) {
            let problem = format!("is a second table of the class {}; allowed: one a class", table.class);
            return Err(Invalid::new(format!("robot.sensors.classes[{index}]"), problem));
        }
    }
    motor_table(&robot.motors)
}

fn sensor_table(field: &str, table: &SensorTable) -> Result<(), Invalid> {
    integer(
        &format!("{field}.sensors"),
        table.sensors,
        1..=tables::GREATEST_SENSORS as u32,
    )?;
    integer(&format!("{field}.rows"), table.rows, 1..=1000)?;
    integer(&format!("{field}.bearings"), table.bearings, 4..=3600)?;
    number(format_args!("{field}.nearest"), table.nearest, 0.0..=10_000.0)?;
    number(format_args!("{field}.spacing"), table.spacing, 0.01..=1000.0)?;
    integer(&format!("{field}.views"), table.views, 1..=64)?;
    let count = table.cells() * table.sensors as usize;
    if table.readings.len() != count {
        let problem = format!(
            "has {} elements; allowed: views times rows times bearings times sensors, {count}",
            table.readings.len()
        );
        return Err(Invalid::new(format!("{field}.readings"), problem));
    }
    if let Some(at) = table.readings.iter().position(|&reading| reading > GREATEST_READING) {
        let problem = format!("is {}; allowed: 0 to {GREATEST_READING}", table.readings[at]);
        return Err(Invalid::new(format!("{field}.readings[{at}]"), problem));
    }
    Ok(())
}

fn motor_table(motors: &MotorTable) -> Result<(), Invalid> {
    integer("robot.motors.states", motors.states, 1..=256)?;
    let cells = motors.states as usize * motors.states as usize;
    if motors.cells.len() != cells {
        let problem = format!(
            "has {} cells; allowed: states times states, {cells}",
            motors.cells.len()
        );
        return Err(Invalid::new("robot.motors.cells", problem));
    }
    number("robot.motors.scale", motors.scale, 0.0..=1000.0)?;
    number("robot.motors.offset", motors.offset, 0.0..=1000.0)?;
    for (index, cell) in motors.cells.iter().enumerate() {
        number(
            format_args!("robot.motors.cells[{index}].displacement"),
            cell.displacement,
            -1000.0..=1000.0,
        )?;
        number(format_args!("robot.motors.cells[{index}].turn"), cell.turn, -0.5..=0.5)?;
        number(format_args!("robot.motors.cells[{index}].left"), cell.left, -1.0..=1.0)?;
        number(
            format_args!("robot.motors.cells[{index}].right"),
            cell.right,
            -1.0..=1.0,
        )?;
    }
    Ok(())
}

/// Checks an arena. Only where sensors are sampled do classes matter.
fn arena(arena: &Arena, sampled: Option<&SensorTables>) -> Result<(), Invalid> {
    let Field { x, y, width, height } = arena.field;
    allowed_number("arena", x, COORDINATE)?;
    allowed_number("arena", y, COORDINATE)?;
    allowed_number("arena.width_mm", width, LENGTH)?;
    allowed_number("arena.height_mm", height, LENGTH)?;
    if let Some(picture) = &arena.picture {
        let ([x, y], [width, height]) = (picture.low(), picture.sides());
        for (key, allowed, values) in [
            ("x_mm", COORDINATE, [x, x + width]),
            ("y_mm", COORDINATE, [y, y + height]),
            ("sides_mm", LENGTH, [width, height]),
        ] {
            for value in values {
                allowed_number(format_args!("arena.picture.{key}"), value, allowed)?;
            }
        }
    }
    let shapes = arena.objects();
    if shapes > GREATEST_OBJECTS {
        let problem = format!("{shapes} walls, obstacles and blocks; allowed: 0 to {GREATEST_OBJECTS} together");
        return Err(Invalid::new("arena", problem));
    }
    length("arena.patches", arena.patches.len(), GREATEST_PATCHES)?;
    for (index, wall) in arena.walls.iter().enumerate() {
        self::wall(&format!("arena.walls[{index}]"), wall)?;
    }
    polygon(arena)?;
    let Some(sensors) = sampled else {
        return Ok(());
    };
    for (index, wall) in arena.walls.iter().enumerate() {
        class(&format!("arena.walls[{index}].class"), &wall.class, sensors)?;
    }
    for (index, obstacle) in arena.obstacles.iter().enumerate() {
        class(&format!("arena.obstacles[{index}].class"), &obstacle.class, sensors)?;
    }
    for (index, block) in arena.blocks.iter().enumerate() {
        known_class(&format!("arena.blocks[{index}].class"), &block.class, sensors)?;
    }
    Ok(())
}

/// Checks that the sides of a polygon are those of a convex one, and that a round field lies within them, or within the field
/// of an arena without.
fn polygon(arena: &Arena) -> Result<(), Invalid> {
    const KEY: &str = "arena.corners_mm";
    let sides = arena.polygon_sides();
    if sides.len() != arena.sides || arena.sides == 1 || arena.sides == 2 {
        let problem = format!("has {} corners; allowed: at least 3", sides.len());
        return Err(Invalid::new(KEY, problem));
    }
    let next = sides.iter().cycle().skip(1);
    for (index, (side, next)) in sides.iter().zip(next).enumerate() {
        let rooms = sides.iter().map(|other| side.room(other.from.into()));
        // Corners of this side are on it except for roundings.
        if side.to != next.from || rooms.fold(f32::INFINITY, f32::min) < -0.01 {
            let problem = format!(
                "has a corner on the other side of its side {index}; allowed: a convex polygon, its corners counter-clockwise"
            );
            return Err(Invalid::new(KEY, problem));
        }
    }
    if arena.is_field_round {
        let Field { x, y, width, .. } = arena.field;
        let radius = 0.5 * width;
        let middle = Vec2::new(x + radius, y + radius);
        let room = sides.iter().map(|side| side.room(middle)).fold(f32::INFINITY, f32::min);
        // The disc is known by its rounded sides.
        if radius - room > 2.0 * f32::EPSILON * (x.abs() + y.abs() + width) {
            let problem = format!("is {radius}; allowed: up to {room} in this arena");
            return Err(Invalid::new("arena.start_radius_mm", problem));
        }
    }
    Ok(())
}

/// Checks that a start lies in the arena. Where a body is free is only known when its objects are packed.
fn start(spec: &WorldSpec) -> Result<(), Invalid> {
    let bounds = spec.arena.start_bounds();
    if let Start::Poses(poses) = &spec.start
        && !(1..=GREATEST_POSES).contains(&poses.0.len())
    {
        let problem = format!("has {} poses; allowed: 1 to {GREATEST_POSES}", poses.0.len());
        return Err(Invalid::new("start.poses", problem));
    }
    let Start::At { x, y, .. } = spec.start else {
        return Area::of(&spec.start, &spec.arena).map(|_| ());
    };
    number("start.x_mm", x, bounds.x..=bounds.x + bounds.width)?;
    number("start.y_mm", y, bounds.y..=bounds.y + bounds.height)
}

fn wall(field: &str, wall: &Wall) -> Result<(), Invalid> {
    for axis in 0..2 {
        let name = ["x", "y"][axis];
        let length = wall.to[axis] - wall.from[axis];
        if length != 0.0 && length.abs() < LEAST {
            let problem =
                format!("its ends differ by {length:e} mm in {name}; allowed: 0, or at least {LEAST:e} in size");
            return Err(Invalid::new(field, problem));
        }
    }
    let [x, y] = [wall.to[0] - wall.from[0], wall.to[1] - wall.from[1]];
    let squared = x * x + y * y;
    if squared < 1.0 {
        let problem = format!("is {} mm long; allowed: at least 1 mm", squared.sqrt());
        return Err(Invalid::new(field, problem));
    }
    Ok(())
}

/// Checks the class of an object that looks the same from everywhere.
fn class(field: &str, class: &str, sensors: &SensorTables) -> Result<(), Invalid> {
    let views = known_class(field, class, sensors)?.views;
    if views == 1 {
        return Ok(());
    }
    let problem = format!("`{class}` was sampled from {views} points of view; allowed: such a class for blocks");
    Err(Invalid::new(field, problem))
}

fn known_class<'a>(field: &str, class: &str, sensors: &'a SensorTables) -> Result<&'a SensorTable, Invalid> {
    if let Some(index) = sensors.class(class) {
        return Ok(&sensors.classes[index]);
    }
    let known: Vec<&str> = sensors.classes.iter().map(|table| table.class.as_str()).collect();
    let problem = format!("no sensor table for `{class}`; allowed: {}", known.join(", "));
    Err(Invalid::new(field, problem))
}
