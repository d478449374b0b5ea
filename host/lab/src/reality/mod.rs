//! Reality, where a robot is sampled and transferred controllers are evaluated: a surrogate, or a connected robot.

pub mod described;
mod place;
pub mod sampling;
pub mod site;
mod surrogate;
pub mod turning;
pub mod wander;
pub mod wired;

use oneiro::batch::Trace;
use oneiro::random::Key;
use oneiro_base::exit::Result;
use serde::{Deserialize, Serialize};

pub use oneiro_robots::vehicle::trouble::Trouble;

/// An object that a robot can be placed before.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// The class of its table.
    pub class: String,
    /// Its shape.
    pub shape: Shape,
}

/// The shape of an object. Lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A wall, longer than a robot's sensors reach.
    Wall,
    /// A cylinder.
    Round {
        /// Its radius.
        radius: f32,
    },
    /// A box, sampled from several directions.
    Block {
        /// One side.
        length: f32,
        /// The other.
        width: f32,
    },
}

impl Object {
    /// The classes that have a name.
    pub const NAMES: [&str; 3] = ["wall", "round", "block"];

    /// A wall, a cylinder of the paper's 55 mm diameter, or a box twice as long as that and as wide.
    pub fn named(name: &str) -> Option<Self> {
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

    /// The objects of the paper's arena.
    pub fn of_the_paper() -> Vec<Self> {
        ["wall", "round"].into_iter().filter_map(Self::named).collect()
    }

    /// The number of directions it is sampled from: one if it looks the same from all sides. A box is symmetric, so half a turn
    /// is enough.
    pub fn views(&self) -> u32 {
        match self.shape {
            Shape::Wall | Shape::Round { .. } => 1,
            Shape::Block { .. } => 8,
        }
    }
}

/// The sensors' readings at one moment of a turn on the spot.
#[derive(Clone, Debug, PartialEq)]
pub struct Turned {
    /// The bearing of the object: turns clockwise from the heading, 0 to 1.
    pub bearing: f64,
    /// Integers from 0 to 1023, as many at each moment.
    pub readings: Vec<u16>,
}

/// The motion of one cycle of 100 ms under a pair of commands, once the wheels have reached their speeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Driven {
    /// Along the heading, mm.
    pub displacement: f64,
    /// Turns, counter-clockwise.
    pub turn: f64,
}

/// An episode in reality.
#[derive(Clone, Copy, Debug)]
pub struct Life<'a> {
    /// The controller's genes.
    pub genes: &'a [f32],
    /// The key of its random numbers, where reality is a simulation.
    pub key: Key,
    /// The start: x and y in mm, heading in turns. None: any free pose.
    pub start: Option<[f32; 3]>,
}

/// The result of an episode in reality.
#[derive(Clone, Debug)]
pub struct Lived {
    /// Its fitness.
    pub fitness: f32,
    /// A record each cycle, and one more with the pose at the end; empty if no trace was requested.
    pub trace: Trace,
}

/// A robot in its surroundings, for the evaluation of controllers: a real one, or a simulation that represents it. Every call
/// takes time and can fail; a call repeated after a [`Trouble`] starts over.
pub trait Reality {
    /// One line that says which robot this is.
    fn describe(&self) -> String;

    /// Whether an episode is on record, so that it takes no time.
    fn has_lived(&self, _life: &Life<'_>) -> bool {
        false
    }

    /// Evaluates episodes, each from its start: one after the other on one robot, several at once on several. `on_lived` is
    /// called with the number of each when it ends.
    ///
    /// # Errors
    /// See [`Trouble`].
    fn live_each(
        &mut self,
        lives: &[Life<'_>],
        traced: bool,
        on_lived: &(dyn Fn(usize, &Lived) + Sync),
    ) -> std::result::Result<Vec<Lived>, Trouble>;

    /// The same, reported at the end.
    ///
    /// # Errors
    /// See [`Trouble`].
    fn live(&mut self, lives: &[Life<'_>], traced: bool) -> std::result::Result<Vec<Lived>, Trouble> {
        self.live_each(lives, traced, &|_, _| {})
    }
}

/// A robot that is sampled without a person. A connected robot is sampled row by row, see [`turning`], since a person has to
/// place it.
pub trait Sampled {
    /// One line that says which robot this is.
    fn describe(&self) -> String;

    /// Places the robot before a single object, `gap` mm from its rim, and lets it turn on the spot once without stopping.
    /// Returns its readings in order of time. `view` is the direction from the object's centre to the robot's, in turns
    /// counter-clockwise from the object's length; it only matters for a box.
    ///
    /// # Errors
    /// See [`Trouble`].
    fn turn_before(&mut self, object: &Object, view: f64, gap: f32) -> std::result::Result<Vec<Turned>, Trouble>;

    /// Drives in the open with a pair of wheel speeds, left and right, in the robot's unit.
    ///
    /// # Errors
    /// See [`Trouble`].
    fn drive(&mut self, speeds: (i32, i32)) -> std::result::Result<Driven, Trouble>;

    /// Skips turns before objects and drives that were measured earlier: later measurements are the same as if they had taken
    /// place.
    fn leave_out(&mut self, turns: u32, drives: u32) {
        // A real robot has no state of them.
        let _ = (turns, drives);
    }
}

/// Retries a call whose failure may pass.
pub fn patiently<T>(mut attempt: impl FnMut() -> std::result::Result<T, Trouble>) -> Result<T> {
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
