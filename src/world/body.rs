//! The body of a robot.

use crate::parameter::{Choice, Choices};
use crate::world::tables::{MotorTable, SensorTables};

/// Values that all robots have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Body<'a> {
    /// Radius, mm.
    pub(crate) radius: f32,
    /// Tables that sampled sensors read.
    pub(crate) sensors: &'a SensorTables,
    /// The table of sampled motors.
    pub(crate) motors: &'a MotorTable,
    /// Effect of a collision.
    pub(crate) collision: Collision,
}

/// Effect of a collision: a cycle after which the robot's body would touch something. Such a cycle earns nothing in any
/// case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Collision {
    /// Undoes both move and turn, as Evorobot does: without noise, a robot that touches something stays where it is.
    #[default]
    Undo,
    /// Keeps the turn and undoes the move.
    KeepTurn,
    /// Lets the body slide along what it would touch, and turn. In a corner it stops.
    Slide,
    /// Lets the body move into contact, and stick there for the rest of its episode, as Kheperax does.
    Stick,
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
        (
            "stick",
            Self::Stick,
            "the robot moves into contact, and stays there for the rest of its episode",
        ),
    ];

    /// Experiments from before there was a choice keep their identity.
    fn is_written(&self) -> bool {
        *self != Self::Undo
    }
}
