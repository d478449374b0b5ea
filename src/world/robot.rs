//! A robot: its body and its kind.

use std::sync::Arc;

use crate::foragers::foraging;
use crate::parameter::{Choice, Choices};
use crate::parts::compose::sampled_fields;
use crate::world::body::{Body, Collision};
use crate::world::differential::Differential;
use crate::world::forager::Forager;
use crate::world::sensors::{Feature, Sensor};
use crate::world::surrogate::Difference;
use crate::world::tables::{MotorStates, MotorTable, SENSOR_NAMES, SensorTables};

/// A robot with two wheels.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// Radius of the round body, mm. Khepera: 27.5 (Miglino et al. 1995).
    pub body_radius: f32,
    /// Measured readings of its proximity sensors; of a parametric robot those of its sensors of the kind sampled.
    pub sensors: Arc<SensorTables>,
    /// Measured motions of its motors; of a parametric robot if its motors are sampled.
    pub motors: Arc<MotorTable>,
    /// Fraction of a cycle's turn made before its displacement, 0 to 1. With 0 it moves along the old heading. Parametric robots
    /// have their own.
    pub turn_before_move: f32,
    /// Effect of a collision.
    pub collision: Collision,
    /// Whether sensors and motors are those that were sampled, or described.
    pub build: Build,
}

impl Robot {
    /// The compiled-in Khepera with its symmetric motor states.
    pub fn khepera() -> Self {
        Self {
            body_radius: 27.5,
            sensors: SensorTables::khepera(),
            motors: MotorTable::khepera(MotorStates::Symmetric20),
            turn_before_move: 0.0,
            collision: Collision::Undo,
            build: Build::Sampled,
        }
    }

    /// Number of robots of a swarm; `None` for a single robot.
    pub(crate) fn members(&self) -> Option<u32> {
        self.build.described()?.count
    }

    /// Number of robots of its world.
    pub fn count(&self) -> u32 {
        self.members().unwrap_or(1)
    }

    /// Whether the robots of a swarm start at given places.
    pub fn has_starts(&self) -> bool {
        !self.start_places().is_empty()
    }

    /// Start of each robot of a swarm, if set: x and y, mm.
    pub(crate) fn start_places(&self) -> &[[f32; 2]] {
        self.build.described().map_or(&[], Differential::start_places)
    }

    /// The sensors of a parametric robot, in the order of their readings; none of a sampled one.
    pub fn described_sensors(&self) -> &[Sensor] {
        self.build.described().map_or(&[], |robot| &robot.sensors)
    }

    /// The tables that its sensors read, if any does.
    pub fn tables(&self) -> Option<&SensorTables> {
        match &self.build {
            Build::Differential(robot) if !robot.has_sampled_sensors() => None,
            Build::Forager(_) => None,
            _ => Some(&self.sensors),
        }
    }

    /// Its body.
    pub(crate) fn body(&self) -> Body<'_> {
        Body {
            radius: self.body_radius,
            sensors: &self.sensors,
            motors: &self.motors,
            collision: self.collision,
        }
    }

    /// Whether a surrogate's difference changes anything for it. Of parametric robots, rays meet all objects anyway, so
    /// [`Difference::Geometry`] is where their sensors look and how strong they are; described wheels drive arcs; and a robot that
    /// slides or sticks in the simulator does so in reality.
    pub fn differs_by(&self, difference: Difference) -> bool {
        let Some(robot) = self.build.described() else {
            return true;
        };
        let has = |feature| robot.sensors.iter().any(|sensor| sensor.kind.entry().has(feature));
        match difference {
            Difference::Geometry => robot
                .sensors
                .iter()
                .any(|sensor| sensor.kind.entry().mounting.is_some()),
            Difference::Reflectivity => has(Feature::SeesSurfaces),
            Difference::Illumination => has(Feature::SeesLight),
            Difference::ReadNoise => has(Feature::Analogue),
            Difference::Latency | Difference::MotorLag | Difference::Wheels => true,
            Difference::Arcs => robot.sampled_motors && robot.turn_before_move != Some(0.5),
            Difference::Slip => matches!(self.collision, Collision::Undo | Collision::KeepTurn),
        }
    }
}

/// Origin of a robot's sensors and motors.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Build {
    /// The tables of [`Robot::sensors`](crate::world::Robot::sensors) and [`Robot::motors`](crate::world::Robot::motors).
    #[default]
    Sampled,
    /// Numbers, which take the tables' place except for what is of the kind sampled. Needs the feature `compose`.
    Differential(Differential),
    /// An e-puck in the on-board simulator of O'Dowd et al. 2014: [`Forager`]. It brings its own body and its own arena. Needs the
    /// feature `compose`.
    Forager(Forager),
}

impl Build {
    /// A parametric robot's description.
    pub fn described(&self) -> Option<&Differential> {
        match self {
            Self::Differential(robot) => Some(robot),
            Self::Sampled | Self::Forager(_) => None,
        }
    }

    /// Names of its readings.
    pub fn readings(&self) -> Vec<String> {
        match self {
            Self::Sampled => SENSOR_NAMES.map(str::to_owned).into(),
            Self::Differential(robot) => robot.readings(),
            Self::Forager(_) => foraging::READINGS.map(str::to_owned).into(),
        }
    }

    /// The fields of a kernel's `Readings` that have them.
    pub(crate) fn fields(&self) -> Vec<String> {
        match self {
            Self::Sampled => sampled_fields(),
            Self::Differential(_) | Self::Forager(_) => self.readings(),
        }
    }
}

impl Choice for Build {
    const CHOICES: Choices<Self> = &[
        ("sampled", Self::Sampled, "from tables of samples, such as the Khepera"),
        (
            "differential",
            Self::Differential(Differential::open()),
            "two wheels, and the sensors listed: see docs/robots.md",
        ),
        (
            "forager",
            Self::Forager(Forager::ODOWD2014),
            "an e-puck in a round arena with food, a nest and a lamp: see docs/epuck.md",
        ),
    ];

    /// Experiments from before there was a choice keep their identity.
    fn is_written(&self) -> bool {
        *self != Self::Sampled
    }
}
