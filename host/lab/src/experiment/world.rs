//! The world of an experiment's robots.

use oneiro::arena::{Arena, Corners};
use oneiro::compose::{Kind, OwnParts};
use oneiro::differential::Build;
use oneiro::parameter::Invalid;
use oneiro::picture::{GREATEST_CELLS, Picture};
use oneiro::world::{Controller, Noise, Robot, World, WorldSpec};
use oneiro_base::exit::{Failure, Result};

use super::inputs::Inputs;
use super::settings::{FROM_REALITY, PictureFile, Samples, SensorFiles, Settings};
use super::source::Source;

/// Makes the world; its errors are reported with the place in the experiment.
pub(super) fn world(settings: &Settings, source: &Source<'_>, inputs: &mut Inputs<'_>) -> Result<World> {
    let own = settings.world.clone();
    let (mut parts, mut refused) = (OwnParts::default(), Vec::new());
    for (kind, file, is_own) in [
        (Kind::Sensor, &settings.sensor, settings.sensor.part.is_some()),
        (
            Kind::Controller,
            &settings.controller,
            own.controller == Controller::Own,
        ),
        (Kind::Task, &settings.task, own.task.is_part()),
    ] {
        if is_own {
            let ready = own.task.ready().filter(|_| kind == Kind::Task);
            match inputs.part(kind, file, ready) {
                Ok(part) => parts.insert(part),
                Err(failure) => refused.push(failure),
            }
        }
    }
    if let Some(failure) = refused.into_iter().reduce(Failure::and) {
        return Err(failure);
    }
    let paths: Vec<String> = parts.iter().map(|own| format!("{}:", own.part().path())).collect();
    let mut arena = arena(settings, own.arena);
    arena.picture = picture(settings, &arena, source, inputs)?;
    World::new(WorldSpec {
        robot: robot(settings, own.robot, source, inputs)?,
        arena,
        own: parts,
        noise: Noise {
            // A step is meaningless without a range to walk in.
            walk_step: if own.noise.walk_range == 0.0 {
                0.0
            } else {
                own.noise.walk_step
            },
            ..own.noise
        },
        ..own
    })
    .map_err(|Invalid { field, problem }| {
        // A mistake in a part has a place in that part.
        if paths.iter().any(|path| problem.starts_with(path)) {
            return Failure::input(problem);
        }
        source.invalid(key(&field), &problem)
    })
}

/// The robot with the samples that it is made from. A parametric one may have sampled motors and some sampled sensors.
fn robot(settings: &Settings, mut own: Robot, source: &Source<'_>, inputs: &mut Inputs<'_>) -> Result<Robot> {
    let files = &settings.robot;
    let Build::Differential(described) = &mut own.build else {
        return Ok(Robot {
            sensors: inputs.sensors(&files.tables)?,
            motors: inputs.motors(&files.motors, files.states)?,
            ..own
        });
    };
    let Samples { tables, motors, states } = &files.described;
    let from_reality = [
        ("robot.tables", *tables == Some(SensorFiles::FromReality)),
        ("robot.motors", motors.as_deref() == Some(FROM_REALITY)),
    ];
    if let Some((key, _)) = from_reality.iter().find(|(_, is_so)| *is_so) {
        let problem = "is \"reality\", and the robot is parametric; allowed: only with a sampled robot; see `oneiro robot sample --robot FILE.toml`";
        return Err(source.invalid(key, problem));
    }
    match tables {
        Some(tables) if described.has_sampled_sensors() => own.sensors = inputs.sensors(tables)?,
        Some(_) => {
            let problem = "is given, and no sensor reads it; allowed: only with sensors of the kind sampled";
            return Err(source.invalid("robot.tables", problem));
        }
        None if described.has_sampled_sensors() => {
            let problem =
                "lacks `tables`, and has sensors of the kind sampled; allowed: \"khepera\" or a list of files";
            return Err(source.invalid("robot", problem));
        }
        None => (),
    }
    match (motors, states) {
        (Some(motors), states) => {
            own.motors = inputs.motors(motors, states.unwrap_or_default())?;
            described.sampled_motors = true;
        }
        (None, Some(_)) => {
            return Err(source.invalid("robot.states", "is given; allowed: only with robot.motors"));
        }
        (None, None) => (),
    }
    Ok(own)
}

/// The picture on the arena's floor.
fn picture(
    settings: &Settings,
    arena: &Arena,
    source: &Source<'_>,
    inputs: &mut Inputs<'_>,
) -> Result<Option<Picture>> {
    const CELL_MM: f32 = 5.0;
    let PictureFile {
        file,
        x,
        y,
        sides,
        cell,
    } = &settings.arena.picture;
    let Some(file) = file else { return Ok(None) };
    let around = arena.within_walls();
    let [width, height] = sides.unwrap_or([around.width, around.height]);
    let low = [
        x.unwrap_or(around.x + 0.5 * around.width) - 0.5 * width,
        y.unwrap_or(around.y + 0.5 * around.height) - 0.5 * height,
    ];
    let cell = cell.unwrap_or(CELL_MM);
    let cells = [width, height].map(|side| (side / cell).round().max(1.0));
    if cells[0] * cells[1] > GREATEST_CELLS as f32 {
        // Somewhat more, in tenths of a mm, for whatever is rounded.
        let enough = (10.0 * (width * height / GREATEST_CELLS as f32).sqrt()).ceil() / 10.0 + 0.1;
        let problem = format!(
            "is {cell}, which gives {} x {} cells; allowed: up to {GREATEST_CELLS} in all, as with {enough:.1}",
            cells[0], cells[1]
        );
        return Err(source.invalid("arena.picture.cell_mm", problem));
    }
    inputs
        .picture(file, [low, [width, height]], cells.map(|count| count as u32))
        .map(Some)
}

/// The experiment's key for a field of the world: the same, except for the parts that come from files.
fn key(field: &str) -> &str {
    let files = [("robot.sensors.", "robot.tables"), ("robot.motors", "robot.motors")];
    let found = files.iter().find(|(part, _)| field.starts_with(part));
    found.map_or(field, |(_, key)| key)
}

/// The arena from the catalogue, or one with the experiment's own size and objects.
fn arena(settings: &Settings, own: Arena) -> Arena {
    if let Build::Forager(_) = settings.world.robot.build {
        return own;
    }
    if let Some(preset) = settings.arena.preset.as_deref().and_then(Arena::named) {
        return preset;
    }
    let size = &settings.arena;
    let [width, height] = [size.width_mm, size.height_mm].map(Option::unwrap_or_default);
    let (outline, walls) = if let Some(Corners(corners)) = &size.corners {
        let polygon = Arena::polygon(corners, size.start_radius);
        let walls = [own.walls, polygon.walls.clone()].concat();
        (polygon, walls)
    } else {
        let rectangle = Arena::rectangle(width, height);
        let walls = if own.walls.is_empty() && size.open != Some(true) {
            rectangle.walls.clone()
        } else {
            own.walls
        };
        let outline = match size.start_radius {
            Some(radius) => rectangle.starting_within([0.5 * width, 0.5 * height], radius),
            None => rectangle,
        };
        (outline, walls)
    };
    Arena {
        walls,
        obstacles: own.obstacles,
        blocks: own.blocks,
        lights: own.lights,
        floor: own.floor,
        patches: own.patches,
        wall_height: own.wall_height,
        ..outline
    }
}
