//! The description of a world: arena, noise, controller, task and start as plain data.

use std::sync::Arc;

use crate::foragers::foraging;
use crate::genes::{Gene, GeneLayout, PREVIOUS};
use crate::parts::automode::{self, Modules};
use crate::parts::compose::OwnParts;
use crate::parts::network::Network;
use crate::world::arena::Arena;
use crate::world::forager::Forager;
use crate::world::noise::Noise;
use crate::world::pucks::Pucks;
use crate::world::robot::{Build, Robot};
use crate::world::start::Start;
use crate::world::surrogate::Surrogate;
use crate::world::tables::SENSOR_NAMES;
use crate::world::varied::Varied;

/// Mapping from sensors to wheel commands, with weights and biases as genes.
#[derive(Clone, Debug, PartialEq)]
pub enum Controller {
    /// All readings to 2 logistic outputs: 18 genes for 8 readings.
    Perceptron,
    /// All readings to `units` hidden logistic units to 2 logistic outputs: `11 units + 2` genes for 8 readings.
    Hidden {
        /// Number of hidden units, 1 to 32.
        units: u32,
    },
    /// All readings and the 2 previous outputs to 2 logistic outputs: 22 genes for 8 readings.
    Recurrent,
    /// A network given by its layers. Needs the feature `compose`.
    Network(Network),
    /// A probabilistic finite state machine of `AutoMoDe`'s modules: 97 genes. Only for [`Model::Vectors`]. Needs the feature
    /// `compose`.
    ///
    /// [`Model::Vectors`]: crate::reference::Model::Vectors
    StateMachine(Modules),
    /// A behaviour tree of the same modules: 29 genes. Likewise.
    BehaviourTree(Modules),
    /// A forager's behaviours: 2 genes choose between seeking the light, fleeing it and searching at random, with food and
    /// without. Only for [`Build::Forager`].
    Behaviours,
    /// A user's controller, in [`WorldSpec::own`].
    Own,
}

impl Controller {
    /// Genes of a controller with these readings, unless it is a user's.
    pub(crate) fn genes(&self, readings: &[String]) -> Vec<Gene> {
        const OUTPUTS: [&str; 2] = ["left", "right"];
        let weights = |inputs: &[String], to: &str| -> Vec<Gene> {
            let weights = inputs.iter().map(|input| format!("{input}_to_{to}"));
            weights.chain([format!("bias_{to}")]).map(Gene::new).collect()
        };
        match self {
            Self::Perceptron => OUTPUTS.iter().flat_map(|to| weights(readings, to)).collect(),
            Self::Hidden { units } => {
                let unit = |unit: u32| {
                    let to_outputs = OUTPUTS.map(|to| Gene::new(format!("unit_{unit}_to_{to}")));
                    weights(readings, &format!("unit_{unit}")).into_iter().chain(to_outputs)
                };
                let biases = OUTPUTS.map(|to| Gene::new(format!("bias_{to}")));
                (0..*units).flat_map(unit).chain(biases).collect()
            }
            Self::Recurrent => {
                let inputs = [readings, &PREVIOUS.map(str::to_owned)].concat();
                OUTPUTS.iter().flat_map(|to| weights(&inputs, to)).collect()
            }
            Self::Network(network) => network.genes(readings),
            Self::StateMachine(_) => automode::machine_genes(),
            Self::BehaviourTree(_) => automode::tree_genes(),
            Self::Behaviours => foraging::genes(),
            Self::Own => Vec::new(),
        }
    }

    /// Genes of a shipped controller that reads the eight sampled sensors of proximity.
    pub fn layout(&self) -> GeneLayout {
        GeneLayout::new(self.genes(&SENSOR_NAMES.map(str::to_owned)))
    }
}

/// The role of speed in equation 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Speed {
    /// `(|left| + |right|) / 2`: driving backwards earns as much as driving forwards.
    Unsigned,
    /// `(left + right) / 2`.
    Signed,
}

/// Power of the wheels' difference in equation 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Difference {
    /// `1 - sqrt(DV)`, as in Floreano and Mondada and in Evorobot.
    Root,
    /// `1 - DV^2`, as printed in the 1995 paper.
    Square,
}

/// Activation that counts in equation 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activation {
    /// Without the added sensor noise.
    Real,
    /// With the added sensor noise.
    Perceived,
    /// No sensor term (the two-term formula of Jakobi et al. 1995).
    None,
}

/// Task that fitness measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Task {
    /// A user's task, in [`WorldSpec::own`].
    Own,
    /// Get to a patch of the floor. This task and the following ones are parts: [`crate::tasks::READY`].
    Reach,
    /// Visit all patches in their order.
    Visit,
    /// Bring food from patches to one that is the nest.
    Collect,
    /// Get everywhere.
    Cover,
    /// Drive on dark patches.
    FollowLine,
    /// Drive along walls and objects.
    FollowWall,
    /// Be in one cluster, in swarms.
    StayTogether,
    /// Get to a light.
    Phototaxis,
    /// Push pucks together, in swarms.
    GatherPucks,
    /// Bring pucks to a patch of the floor, in swarms.
    BringPucks,
    /// The seconds left when food is brought to the nest: equation 1 of O'Dowd et al. 2014. Only for
    /// [`Build::Forager`].
    Foraging,
    /// Equation 1 of Miglino et al. 1995 with the choices below, summed over the cycles of an episode. A cycle that ends in a collision
    /// earns nothing.
    Avoidance {
        /// Signed or unsigned V.
        speed: Speed,
        /// Root or square of DV.
        difference: Difference,
        /// Activation in (1 - I).
        activation: Activation,
        /// Additional value of each 50 mm cell that the robot's centre enters for the first time, 0 to 1000. The
        /// paper's conclusion proposes such a term, only for simulations, where the robot's position is known. Must be
        /// 0 for fields of more than 128 cells.
        new_cell: f32,
    },
}

impl Task {
    /// Equation 1 with unsigned V, the root of DV, where the paper prints the square, and the activation without added noise.
    pub const AVOIDANCE: Self = Self::Avoidance {
        speed: Speed::Unsigned,
        difference: Difference::Root,
        activation: Activation::Real,
        new_cell: 0.0,
    };

    /// Sets the value of a new cell, if the task has one.
    #[must_use]
    pub fn with_new_cell(mut self, value: f32) -> Self {
        if let Self::Avoidance { new_cell, .. } = &mut self {
            *new_cell = value;
        }
        self
    }
}

/// Everything about an episode except genes and seed.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldSpec {
    /// The body, its sensors and motors.
    pub robot: Robot,
    /// The individual, with its physics. `None`: the simulator made from the robot's tables or description.
    pub surrogate: Option<Arc<Surrogate>>,
    /// Walls and obstacles.
    pub arena: Arena,
    /// Discs that the robots of a swarm push and carry.
    pub pucks: Pucks,
    /// Noise of the simulation.
    pub noise: Noise,
    /// Mapping from sensors to wheel commands.
    pub controller: Controller,
    /// Task that fitness measures.
    pub task: Task,
    /// Sensors that a user wrote, the controller if `controller` is [`Controller::Own`], and the task if `task` is
    /// [`Task::Own`], or one of [`crate::tasks::READY`] with other values than its defaults.
    pub own: OwnParts,
    /// Start of episodes.
    pub start: Start,
    /// Numbers that differ between episodes.
    pub varied: Varied,
    /// Length of an episode in cycles of 100 ms, 1 to 1,000,000.
    pub cycles: u32,
    /// The last of these cycles that are not the episode's: its parts are told of the others alone. See [`WorldSpec::seen_to_its_end`].
    pub cycles_after: u32,
}

impl WorldSpec {
    /// The main conditions of Miglino et al. 1995, without noise: a Khepera, its arena with three obstacles, a
    /// perceptron, 500 cycles from a random free pose.
    pub fn miglino1995() -> Self {
        Self {
            robot: Robot::khepera(),
            surrogate: None,
            arena: Arena::miglino1995(),
            pucks: Pucks::default(),
            noise: Noise::NONE,
            controller: Controller::Perceptron,
            task: Task::AVOIDANCE,
            own: OwnParts::default(),
            start: Start::Random,
            varied: Varied::default(),
            cycles: 500,
            cycles_after: 0,
        }
    }

    /// The same world with a cycle after the episode, whose beginning is how the episode ended. Fitness is that of the cycles before.
    #[must_use]
    pub fn seen_to_its_end(self) -> Self {
        Self {
            cycles: self.cycles + 1,
            cycles_after: 1,
            ..self
        }
    }

    /// A forager in its arena, with its behaviours, its task and the start and the length of its episodes.
    pub fn foraging(forager: Forager) -> Self {
        let settings = forager.foraging;
        Self {
            robot: Robot {
                body_radius: settings.body_radius,
                build: Build::Forager(forager),
                ..Robot::khepera()
            },
            arena: Arena::default(),
            controller: Controller::Behaviours,
            task: Task::Foraging,
            start: settings
                .start
                .map_or(Start::Random, |[x, y, heading]| Start::At { x, y, heading }),
            cycles: settings.cycles,
            ..Self::miglino1995()
        }
    }

    /// Names of all readings: the robot's, then those of a user's sensors.
    pub(crate) fn readings(&self) -> Vec<String> {
        self.own.readings_of(&self.robot.build.readings())
    }
}
