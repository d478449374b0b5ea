//! Places where a robot really is: where it can be sampled, and where controllers live real lives.

pub(crate) mod sampling;
pub(crate) mod surrogate;

use oneiro::batch::Record;
use oneiro::random::Key;
use serde::{Deserialize, Serialize};

use crate::exit::{Failure, Result};

/// An object that a robot can be placed before.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Object {
    /// The class that its table gets.
    pub(crate) class: String,
    /// What it is.
    pub(crate) shape: Shape,
}

/// What an object is. Lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shape {
    /// A wall that is longer than a robot sees.
    Wall,
    /// A cylinder.
    Round {
        /// Its radius.
        radius: f32,
    },
    /// A box, of which each point of view is sampled.
    Block {
        /// One side.
        length: f32,
        /// The other.
        width: f32,
    },
}

impl Object {
    /// The classes that can be asked for by name.
    pub(crate) const NAMES: [&str; 3] = ["wall", "round", "block"];

    /// A wall, a cylinder of the paper's 55 mm diameter, or a box twice as long as that and as wide.
    pub(crate) fn named(name: &str) -> Option<Self> {
        let shape = match name {
            "wall" => Shape::Wall,
            "round" => Shape::Round { radius: 27.5 },
            "block" => Shape::Block {
                length: 110.0,
                width: 55.0,
            },
            _ => return None,
        };
        Some(Self {
            class: name.into(),
            shape,
        })
    }

    /// What the paper's arena has.
    pub(crate) fn of_the_paper() -> Vec<Self> {
        ["wall", "round"].into_iter().filter_map(Self::named).collect()
    }

    /// From how many points of view it is sampled: one, if it looks the same from everywhere. A box looks the same
    /// again from behind; half a turn of points of view is enough.
    pub(crate) fn views(&self) -> u32 {
        match self.shape {
            Shape::Wall | Shape::Round { .. } => 1,
            Shape::Block { .. } => 8,
        }
    }
}

/// What the sensors read at one moment of a turn on the spot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turned {
    /// Where the object is: turns clockwise from the heading, 0 to 1.
    pub(crate) bearing: f64,
    /// Integers from 0 to 1023.
    pub(crate) readings: [u16; 8],
}

/// What a pair of commands does in one cycle of 100 ms, once the wheels have reached their speeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Driven {
    /// Along the heading, mm.
    pub(crate) displacement: f64,
    /// Turns, counter-clockwise.
    pub(crate) turn: f64,
}

/// A life to be lived.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Life<'a> {
    /// The controller's genes.
    pub(crate) genes: &'a [f32],
    /// In a simulation all that is random in it.
    pub(crate) key: Key,
    /// Where the robot is put: x and y in mm, heading in turns. None: at any free pose.
    pub(crate) start: Option<[f32; 3]>,
}

/// A life that was lived.
#[derive(Clone, Debug)]
pub(crate) struct Lived {
    /// Its fitness.
    pub(crate) fitness: f32,
    /// If it was asked for, a record each cycle, and one more with where it ended.
    pub(crate) trace: Vec<Record>,
}

/// Why reality did not do what it was asked to.
#[derive(Clone, Debug, thiserror::Error)]
#[cfg_attr(
    not(test),
    expect(
        dead_code,
        reason = "a surrogate is always readable and in its place; a real robot is not"
    )
)]
pub(crate) enum Trouble {
    /// The sensors could not be read, or not in time; it may work when tried again.
    #[error("the sensors can't be read: {0}")]
    Unreadable(String),
    /// The robot is not where it should be: lifted, stuck, or out of sight; it may work once it is put back.
    #[error("the robot has to be put back: {0}")]
    Displaced(String),
    /// The user wants to stop.
    #[error("stopped")]
    Stopped,
    /// It will not work.
    #[error("{0}")]
    Broken(String),
}

impl From<Trouble> for Failure {
    fn from(trouble: Trouble) -> Self {
        match trouble {
            Trouble::Stopped => Self::stopped("stopped; the same command goes on"),
            other => Self::device(other),
        }
    }
}

/// A robot in its surroundings. Time passes in every call, and every call can fail; what is asked again after a
/// [`Trouble`] is done anew. A simulation that stands in for a robot is one of these, and so is a robot on a wire.
pub(crate) trait Reality {
    /// One line on which robot this is.
    fn describe(&self) -> String;

    /// Puts the robot before an object that stands alone, so that its rim is so many mm away, and lets it turn
    /// on the spot once without stopping: its readings, in the order of time. Of an object that is not the same from
    /// everywhere, `view` is from where the robot looks at it: the direction from its centre to the robot's, in turns
    /// counter-clockwise from its length.
    ///
    /// # Errors
    /// See [`Trouble`].
    fn turn_before(&mut self, object: &Object, view: f64, gap: f32) -> std::result::Result<Vec<Turned>, Trouble>;

    /// Drives in the open with a pair of speeds, in the robot's own unit, left and right.
    ///
    /// # Errors
    /// See [`Trouble`].
    fn drive(&mut self, speeds: (i32, i32)) -> std::result::Result<Driven, Trouble>;

    /// Lives lives, one after the other, each from a start of its own.
    ///
    /// # Errors
    /// See [`Trouble`].
    fn live(&mut self, lives: &[Life<'_>], traced: bool) -> std::result::Result<Vec<Lived>, Trouble>;
}

/// Does something again when it fails in a way that may pass.
pub(crate) fn patiently<T>(mut attempt: impl FnMut() -> std::result::Result<T, Trouble>) -> Result<T> {
    const ATTEMPTS: u32 = 3;
    let mut tries = 1;
    loop {
        match attempt() {
            Ok(done) => return Ok(done),
            Err(Trouble::Unreadable(_) | Trouble::Displaced(_)) if tries < ATTEMPTS => tries += 1,
            Err(trouble) => return Err(trouble.into()),
        }
    }
}
