//! From an experiment's values to the world that robots live in.

use oneiro::arena::{Arena, Block, Obstacle, Wall};
use oneiro::world::{self, World, WorldSpec};

use super::inputs::Inputs;
use super::settings::{self, Activation, ControllerKind, Difference, Settings, Speed, StartKind, TaskKind};
use super::source::Source;
use crate::exit::Result;

/// Makes the world; what it refuses is told with the place in the experiment.
pub(super) fn world(settings: &Settings, source: &Source<'_>, inputs: &mut Inputs<'_>) -> Result<World> {
    let robot = world::Robot {
        body_radius: settings.robot.body_radius_mm as f32,
        sensors: inputs.sensors(&settings.robot.tables)?,
        motors: inputs.motors(&settings.robot.motors, settings.robot.states)?,
        turn_before_move: settings.robot.turn_before_move as f32,
    };
    World::new(WorldSpec {
        surrogate: None,
        robot,
        arena: arena(&settings.arena),
        noise: noise(&settings.noise),
        controller: controller(&settings.controller),
        task: task(&settings.task),
        start: start(&settings.start),
        cycles: settings.cycles,
    })
    .map_err(|invalid| source.invalid(&key(&invalid.field), &invalid.problem))
}

/// The experiment's key of a world's field: the same with the unit, and without the parts that files bring.
fn key(field: &str) -> String {
    let name = |part: &str| match part {
        "body_radius" | "walk_range" | "walk_step" | "from" | "to" | "x" | "y" | "radius" | "length" | "width"
        | "height" => format!("{part}_mm"),
        "heading" => "heading_turns".into(),
        other => other.into(),
    };
    if field.starts_with("robot.sensors") {
        return "robot.tables".into();
    }
    if field.starts_with("robot.motors") {
        return "robot.motors".into();
    }
    let field = field.replace("arena.field.", "arena.");
    // The ends of a wall are lists.
    let field = field
        .split_once(".from.")
        .or(field.split_once(".to."))
        .map_or(field.as_str(), |(wall, _)| {
            &field[..wall.len()
                + if field[wall.len()..].starts_with(".from.") {
                    ".from".len()
                } else {
                    ".to".len()
                }]
        });
    field.split('.').map(name).collect::<Vec<_>>().join(".")
}

fn arena(arena: &settings::Arena) -> Arena {
    if let Some(preset) = arena.preset.as_deref().and_then(Arena::named) {
        return preset;
    }
    let size = |value: Option<f64>| value.unwrap_or_default() as f32;
    let point = |[x, y]: [f64; 2]| [x as f32, y as f32];
    let mut own = Arena::rectangle(size(arena.width_mm), size(arena.height_mm));
    if !arena.walls.is_empty() {
        own.walls = arena
            .walls
            .iter()
            .map(|wall| Wall {
                from: point(wall.from_mm),
                to: point(wall.to_mm),
                class: wall.class.clone(),
            })
            .collect();
    }
    own.obstacles = arena
        .obstacles
        .iter()
        .map(|obstacle| Obstacle {
            x: obstacle.x_mm as f32,
            y: obstacle.y_mm as f32,
            radius: obstacle.radius_mm as f32,
            class: obstacle.class.clone(),
        })
        .collect();
    own.blocks = arena
        .blocks
        .iter()
        .map(|block| Block {
            x: block.x_mm as f32,
            y: block.y_mm as f32,
            length: block.length_mm as f32,
            width: block.width_mm as f32,
            heading: block.heading_turns as f32,
            class: block.class.clone(),
        })
        .collect();
    own
}

fn noise(noise: &settings::Noise) -> world::Noise {
    let [low, high] = noise.sensor;
    let walk_range = noise.walk_range_mm as f32;
    world::Noise {
        sensor: (low as f32, high as f32),
        walk_range,
        // A step without a range to walk in is none.
        walk_step: if walk_range == 0.0 {
            0.0
        } else {
            noise.walk_step_mm as f32
        },
        motor: noise.motor as f32,
    }
}

fn controller(controller: &settings::Controller) -> world::Controller {
    match controller.kind {
        ControllerKind::Perceptron => world::Controller::Perceptron,
        ControllerKind::Hidden => world::Controller::Hidden {
            units: controller.units.unwrap_or(settings::DEFAULT_UNITS),
        },
        ControllerKind::Recurrent => world::Controller::Recurrent,
    }
}

fn task(task: &settings::Task) -> world::Task {
    let TaskKind::Avoidance = task.kind;
    world::Task::Avoidance {
        speed: match task.speed {
            Speed::Unsigned => world::Speed::Unsigned,
            Speed::Signed => world::Speed::Signed,
        },
        difference: match task.difference {
            Difference::Root => world::Difference::Root,
            Difference::Square => world::Difference::Square,
        },
        activation: match task.activation {
            Activation::Real => world::Activation::Real,
            Activation::Perceived => world::Activation::Perceived,
            Activation::None => world::Activation::None,
        },
        new_cell: task.new_cell as f32,
    }
}

fn start(start: &settings::Start) -> world::Start {
    let number = |value: Option<f64>| value.unwrap_or_default() as f32;
    match start.kind {
        StartKind::Random => world::Start::Random,
        StartKind::At => world::Start::At {
            x: number(start.x_mm),
            y: number(start.y_mm),
            heading: number(start.heading_turns),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::key;

    #[test]
    fn fields_of_worlds_have_keys_in_experiments() {
        for (field, expected) in [
            ("cycles", "cycles"),
            ("noise.walk_step", "noise.walk_step_mm"),
            ("noise.sensor", "noise.sensor"),
            ("robot.body_radius", "robot.body_radius_mm"),
            ("robot.sensors.classes[0].rows", "robot.tables"),
            ("robot.motors.cells[3].turn", "robot.motors"),
            ("arena.field.width", "arena.width_mm"),
            ("arena.walls[2].from.x", "arena.walls[2].from_mm"),
            ("arena.walls[2].to.y", "arena.walls[2].to_mm"),
            ("arena.walls[2].class", "arena.walls[2].class"),
            ("arena.obstacles[0].radius", "arena.obstacles[0].radius_mm"),
            ("arena.blocks[1].length", "arena.blocks[1].length_mm"),
            ("arena.blocks[1].heading", "arena.blocks[1].heading_turns"),
            ("start.heading", "start.heading_turns"),
            ("start", "start"),
        ] {
            assert_eq!(key(field), expected);
        }
    }
}
