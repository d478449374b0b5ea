//! What a rollout lives in: robot, arena, noise, controller, task and start, as plain data, and the validated
//! [`World`] that is made from it.

use std::sync::Arc;

use crate::arena::Arena;
use crate::tables::{MotorTable, SensorTables};

/// A robot on two wheels with sampled sensors and motors.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// Radius of the round body, mm. Khepera: 27.5 (Miglino et al. 1995).
    pub body_radius: f32,
    /// What its proximity sensors were measured to read.
    pub sensors: Arc<SensorTables>,
    /// What its motors were measured to do.
    pub motors: Arc<MotorTable>,
    /// Share of a cycle's turn that is made before its displacement, 0 to 1. 0 moves along the old heading.
    pub turn_before_move: f32,
}

/// The noise of a simulated life. All zero is the paper's "no noise".
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// A uniform number from this range is added to each activation, which is then clipped to `0..=1`.
    /// The paper's sensor noise is `(0.0, 0.4)`; a symmetric one is `(-0.2, 0.2)`.
    pub sensor: (f32, f32),
    /// Conservative noise: what is perceived is displaced by a walk within plus and minus this, mm. Paper: 30.
    pub walk_range: f32,
    /// Greatest step of that walk in one cycle, mm, for x and y each.
    pub walk_step: f32,
    /// Relative uniform noise on each cycle's displacement and turn, 0 to 1.
    pub motor: f32,
}

/// How genes become wheel commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Controller {
    /// 8 inputs, 2 logistic outputs: 18 genes.
    Perceptron,
    /// 8 inputs, `units` hidden logistic units, 2 logistic outputs: `11 units + 2` genes.
    Hidden {
        /// 1 to 32.
        units: u32,
    },
    /// 8 inputs and the 2 previous outputs, 2 logistic outputs: 22 genes.
    Recurrent,
}

/// How speed counts in equation 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Speed {
    /// `(|left| + |right|) / 2`: driving backwards pays as forwards does.
    Unsigned,
    /// `(left + right) / 2`.
    Signed,
}

/// The power of the wheels' difference in equation 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Difference {
    /// `1 - sqrt(DV)`, as Floreano and Mondada and Evorobot have it.
    Root,
    /// `1 - DV^2`, as the 1995 paper prints it.
    Square,
}

/// Which activation counts in equation 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activation {
    /// Without the added sensor noise.
    Real,
    /// With it.
    Perceived,
    /// No sensor term (the two-term formula of Jakobi et al. 1995).
    None,
}

/// What fitness is given for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// Equation 1 of Miglino et al. 1995, summed over the cycles of a life.
    Avoidance {
        /// Signed or unsigned V.
        speed: Speed,
        /// Root or square of DV.
        difference: Difference,
        /// The activation in (1 - I).
        activation: Activation,
    },
}

/// Where a life starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// A free pose, uniform over the arena's field and all headings, drawn from the rollout's own key.
    Random,
    /// One pose for all: x and y in mm, heading in turns counter-clockwise from the x axis.
    At {
        /// mm
        x: f32,
        /// mm
        y: f32,
        /// turns, `0..1`
        heading: f32,
    },
}

/// Everything about a life but genes and seed.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldSpec {
    /// The body, its sensors and motors.
    pub robot: Robot,
    /// Walls and obstacles.
    pub arena: Arena,
    /// Noise of the simulation.
    pub noise: Noise,
    /// How genes become commands.
    pub controller: Controller,
    /// What fitness is given for.
    pub task: Task,
    /// Where lives start.
    pub start: Start,
    /// Length of a life in cycles of 100 ms, 1 to 1,000,000.
    pub cycles: u32,
}
