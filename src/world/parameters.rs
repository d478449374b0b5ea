//! The values of a world, by their keys in an experiment's file.

use std::sync::LazyLock;

use oneiro_shaders::life;

use super::{Activation, Collision, Controller, Difference, Speed, Start, Task, WorldSpec};
use crate::parameter::Allowed::{Any, Number, Text, Turns, Whole};
use crate::parameter::{Allowed, Choice, Choices, Parameter, row};

/// Range of coordinates, mm: beyond 100 m single precision is too coarse for a robot's steps.
pub const COORDINATE: Allowed = Number(-1e5, 1e5);
/// Range of lengths of bodies, arenas and blocks, mm.
pub const LENGTH: Allowed = Number(1.0, 1e5);

const OURS: &str = "ours";
const CLASS: Allowed = Text("a class of the sensor tables");

/// Rows of all values except tables and the size of the arena, which an experiment specifies in its own way.
#[rustfmt::skip]
pub fn parameters<T: AsMut<WorldSpec>>() -> Vec<Parameter<T>> {
    vec![
        row("cycles", "cycles of 100 ms", Whole(1, 1_000_000), "Miglino et al. 1995, section 3.1",
            "Length of a life: 500 cycles are 50 s.", |own, _| Some(&mut own.as_mut().cycles)),
        row("robot.body_radius_mm", "mm", LENGTH, "Miglino et al. 1995, section 3.1",
            "Radius of the round body.", |own, _| Some(&mut own.as_mut().robot.body_radius)),
        row("robot.collision", "", Any, "Evorobot",
            "What a collision does: undo, unless it is given.", |own, _| Some(&mut own.as_mut().robot.collision)),
        row("robot.turn_before_move", "", Number(0.0, 1.0), "Evorobot",
            "Share of a cycle's turn that is made before its displacement.", |own, _| Some(&mut own.as_mut().robot.turn_before_move)),
        row("arena.walls", "", Any, OURS,
            "Walls of an arena of your own; its four sides, of the class wall, where there are none.", |own, _| Some(&mut own.as_mut().arena.walls)),
        row("arena.walls[].from_mm", "mm", COORDINATE, "",
            "x and y of one end of a wall.", |own, index| Some(&mut own.as_mut().arena.walls.get_mut(index)?.from)),
        row("arena.walls[].to_mm", "mm", COORDINATE, "",
            "x and y of its other end.", |own, index| Some(&mut own.as_mut().arena.walls.get_mut(index)?.to)),
        row("arena.walls[].class", "", CLASS, "",
            "Its class, which selects the sensor table.", |own, index| Some(&mut own.as_mut().arena.walls.get_mut(index)?.class)),
        row("arena.obstacles", "", Any, OURS,
            "Round obstacles of an arena of your own.", |own, _| Some(&mut own.as_mut().arena.obstacles)),
        row("arena.obstacles[].x_mm", "mm", COORDINATE, "",
            "x of an obstacle's centre.", |own, index| Some(&mut own.as_mut().arena.obstacles.get_mut(index)?.x)),
        row("arena.obstacles[].y_mm", "mm", COORDINATE, "",
            "y of its centre.", |own, index| Some(&mut own.as_mut().arena.obstacles.get_mut(index)?.y)),
        row("arena.obstacles[].radius_mm", "mm", Number(0.0, 1e5), "",
            "Its radius; the paper's obstacles have 27.5.", |own, index| Some(&mut own.as_mut().arena.obstacles.get_mut(index)?.radius)),
        row("arena.obstacles[].class", "", CLASS, "",
            "Its class, which selects the sensor table.", |own, index| Some(&mut own.as_mut().arena.obstacles.get_mut(index)?.class)),
        row("arena.blocks", "", Any, OURS,
            "Rectangular obstacles of an arena of your own.", |own, _| Some(&mut own.as_mut().arena.blocks)),
        row("arena.blocks[].x_mm", "mm", COORDINATE, "",
            "x of a block's centre.", |own, index| Some(&mut own.as_mut().arena.blocks.get_mut(index)?.x)),
        row("arena.blocks[].y_mm", "mm", COORDINATE, "",
            "y of its centre.", |own, index| Some(&mut own.as_mut().arena.blocks.get_mut(index)?.y)),
        row("arena.blocks[].length_mm", "mm", LENGTH, "",
            "One of its sides.", |own, index| Some(&mut own.as_mut().arena.blocks.get_mut(index)?.length)),
        row("arena.blocks[].width_mm", "mm", LENGTH, "",
            "The other side.", |own, index| Some(&mut own.as_mut().arena.blocks.get_mut(index)?.width)),
        row("arena.blocks[].heading_turns", "turns", Turns, "",
            "Direction of its length, counter-clockwise from the x axis.", |own, index| Some(&mut own.as_mut().arena.blocks.get_mut(index)?.heading)),
        row("arena.blocks[].class", "", CLASS, "",
            "Its class; none is built in, `oneiro sample` makes one.", |own, index| Some(&mut own.as_mut().arena.blocks.get_mut(index)?.class)),
        row("noise.sensor", "", Number(-1.0, 1.0), "Miglino et al. 1995, section 4",
            "A uniform number from this range is added to each activation; the paper's sensor noise is [0.0, 0.4].", |own, _| Some(&mut own.as_mut().noise.sensor)),
        row("noise.walk_range_mm", "mm", Number(0.0, 1000.0), "Miglino et al. 1995, section 4",
            "Conservative noise: what is perceived is displaced by a random walk within plus and minus this; 30 in the paper.", |own, _| Some(&mut own.as_mut().noise.walk_range)),
        row("noise.walk_step_mm", "mm", Number(0.0, 2000.0), "ours: \"a small random value\" in Miglino et al. 1995, section 3.2.1",
            "Greatest step of that walk in a cycle, in x and y each; at most twice the range.", |own, _| Some(&mut own.as_mut().noise.walk_step)),
        row("noise.motor", "", Number(0.0, 1.0), "ours: no amount in Miglino et al. 1995, section 3.2.2",
            "Relative uniform noise of each cycle's displacement and turn.", |own, _| Some(&mut own.as_mut().noise.motor)),
        row("controller.kind", "", Any, "Miglino et al. 1995, section 3.3, figure 5",
            "How genes become wheel commands.", |own, _| Some(&mut own.as_mut().controller)),
        row("controller.units", "", Whole(1, life::GREATEST_HIDDEN.into()), "ours: no hidden layer in Miglino et al. 1995, section 3.3",
            "Hidden units.", |own, _| match &mut own.as_mut().controller {
                Controller::Hidden { units } => Some(units),
                _ => None,
            }),
        row("task.kind", "", Any, "Miglino et al. 1995, section 3.1, equation 1",
            "What fitness is given for.", |own, _| Some(&mut own.as_mut().task)),
        row("task.speed", "", Any, "Miglino et al. 1995, section 5: driving to and fro \"will score relatively high\"",
            "V of equation 1.", |own, _| match &mut own.as_mut().task { Task::Avoidance { speed, .. } => Some(speed), Task::Own => None }),
        row("task.difference", "", Any, "Floreano and Mondada, whose formula Miglino et al. 1995 take; their section 3.1, equation 1, prints the square",
            "DV of equation 1.", |own, _| match &mut own.as_mut().task { Task::Avoidance { difference, .. } => Some(difference), Task::Own => None }),
        row("task.activation", "", Any, OURS,
            "I of equation 1.", |own, _| match &mut own.as_mut().task { Task::Avoidance { activation, .. } => Some(activation), Task::Own => None }),
        row("task.new_cell", "", Number(0.0, 1000.0), "none in Miglino et al. 1995, whose section 5 proposes such a term",
            "Fitness for each cell of 50 mm that a robot enters for the first time; for fields of up to 128 such cells.", |own, _| match &mut own.as_mut().task { Task::Avoidance { new_cell, .. } => Some(new_cell), Task::Own => None }),
        row("start.kind", "", Any, "Miglino et al. 1995, section 3.1",
            "Where lives start.", |own, _| Some(&mut own.as_mut().start)),
        row("start.x_mm", "mm", COORDINATE, "",
            "x of the start.", |own, _| match &mut own.as_mut().start { Start::At { x, .. } => Some(x), Start::Random => None }),
        row("start.y_mm", "mm", COORDINATE, "",
            "y of the start.", |own, _| match &mut own.as_mut().start { Start::At { y, .. } => Some(y), Start::Random => None }),
        row("start.heading_turns", "turns", Turns, OURS,
            "Heading at the start, counter-clockwise from the x axis.", |own, _| match &mut own.as_mut().start { Start::At { heading, .. } => Some(heading), Start::Random => None }),
    ]
}

/// Rows for worlds by themselves.
pub(super) static PARAMETERS: LazyLock<Vec<Parameter<WorldSpec>>> = LazyLock::new(parameters);

impl AsMut<Self> for WorldSpec {
    fn as_mut(&mut self) -> &mut Self {
        self
    }
}

impl Choice for Controller {
    const CHOICES: Choices<Self> = &[
        ("perceptron", Self::Perceptron, "8 inputs, 2 logistic outputs: 18 genes"),
        (
            "hidden",
            Self::Hidden { units: 4 },
            "a layer of logistic units between: 11 genes a unit, and 2",
        ),
        (
            "recurrent",
            Self::Recurrent,
            "both outputs are fed back as inputs: 22 genes",
        ),
        (
            "own",
            Self::Own,
            "a controller of your own, in WGSL: see docs/extend.md",
        ),
    ];
}

impl Choice for Collision {
    const CHOICES: Choices<Self> = &[
        ("undo", Self::Undo, "neither the move nor the turn is made"),
        ("keep_turn", Self::KeepTurn, "the turn is made, the move is not"),
        (
            "slide",
            Self::Slide,
            "the robot slides along what it would touch, and turns",
        ),
    ];

    /// Experiments from before there was a choice keep their identity.
    fn is_written(&self) -> bool {
        *self != Self::Undo
    }
}

impl Choice for Task {
    const CHOICES: Choices<Self> = &[
        (
            "avoidance",
            Self::AVOIDANCE,
            "equation 1 of the paper: the sum over a life's cycles of V (1 - sqrt(DV)) (1 - I)",
        ),
        ("own", Self::Own, "a task of your own, in WGSL: see docs/extend.md"),
    ];
}

impl Choice for Speed {
    const CHOICES: Choices<Self> = &[
        (
            "unsigned",
            Self::Unsigned,
            "(|left| + |right|) / 2: driving backwards counts as driving forwards does",
        ),
        ("signed", Self::Signed, "(left + right) / 2"),
    ];
}

impl Choice for Difference {
    const CHOICES: Choices<Self> = &[
        ("root", Self::Root, "1 - sqrt(DV)"),
        ("square", Self::Square, "1 - DV^2"),
    ];
}

impl Choice for Activation {
    const CHOICES: Choices<Self> = &[
        ("real", Self::Real, "the greatest activation without the added noise"),
        ("perceived", Self::Perceived, "the greatest activation with its noise"),
        ("none", Self::None, "no term for it"),
    ];
}

impl Choice for Start {
    const CHOICES: Choices<Self> = &[
        ("random", Self::Random, "a free pose for each life"),
        (
            "at",
            Self::At {
                x: f32::NAN,
                y: f32::NAN,
                heading: 0.0,
            },
            "one pose for all lives",
        ),
    ];
}
