//! The study under other assumptions: each arm changes one choice that the paper leaves open.

use std::sync::Arc;

use clap::ValueEnum;
use oneiro::arena::Arena;
use oneiro::surrogate::{Difference, Differences};
use oneiro::tables::{MotorStates, SensorTables};
use oneiro::world::{Activation, Noise, Speed, Task, WorldSpec};
use serde::{Deserialize, Serialize};

use super::interpolation::interpolated;
use super::real_lives::RealStarts;
use super::results::Condition;
use crate::experiment::settings::{Evolution, MutationKind, MutationUnit};

/// One assumption that is made otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Arm {
    /// As preregistered
    Main,
    /// The square of DV, as the paper prints it
    Square,
    /// (1 - I) with the activation as perceived, added noise included
    Perceived,
    /// V is the mean of signed speeds
    Signed,
    /// No (1 - I), as Jakobi et al. 1995
    TwoTerms,
    /// Motor states -10 to 9
    StatesAsymmetric,
    /// Motor states -10 to 10, rounded as Evorobot does
    StatesEvorobot,
    /// The obstacles in a triangle
    Triangle,
    /// Sensor noise from -0.2 to 0.2
    SymmetricNoiseNarrow,
    /// Sensor noise from -0.4 to 0.4
    SymmetricNoiseWide,
    /// Conservative noise with steps of 0.3 mm
    WalkStepSmall,
    /// Conservative noise with steps of 5 mm
    WalkStepLarge,
    /// Mutations replace genes by fresh ones
    MutationReplaces,
    /// A quarter of the individuals is mutated, in all genes
    MutationPerIndividual,
    /// First genes from -5 to 5, and all kept there
    WideGenes,
    /// Readings 100 ms old
    LatencyCycle,
    /// Reality without its field of light
    NoIllumination,
    /// Half the severity
    HalfSeverity,
    /// Another robot in other surroundings
    AnotherRobot,
    /// Each real life starts where the last one of its run stopped
    RealStartsContinuing,
    /// Between two real lives of a run the robot drives about for 10 s
    RealStartsWalk,
    /// Each sampled point is the rounded mean of ten turns
    TenReadings,
    /// Samples interpolated to half a degree and half a millimetre
    Interpolated,
}

impl Arm {
    /// What it is called on the command line.
    pub(crate) fn name(self) -> String {
        self.to_possible_value()
            .map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// What it assumes, in a line.
    pub(crate) fn describe(self) -> String {
        self.to_possible_value()
            .and_then(|value| value.get_help().map(ToString::to_string))
            .unwrap_or_default()
    }

    /// The paper's noise of a condition.
    pub(crate) fn noise(self, condition: Condition) -> Noise {
        let noise = match condition {
            Condition::None => Noise::NONE,
            Condition::Sensor => Noise::SENSOR,
            Condition::Conservative => Noise::CONSERVATIVE,
        };
        match (self, condition) {
            (Self::SymmetricNoiseNarrow, Condition::Sensor) => Noise {
                sensor: (-0.2, 0.2),
                ..noise
            },
            (Self::SymmetricNoiseWide, Condition::Sensor) => Noise {
                sensor: (-0.4, 0.4),
                ..noise
            },
            (Self::WalkStepSmall, Condition::Conservative) => Noise {
                walk_step: 0.3,
                ..noise
            },
            (Self::WalkStepLarge, Condition::Conservative) => Noise {
                walk_step: 5.0,
                ..noise
            },
            _ => noise,
        }
    }

    /// The genetic algorithm, but for the number of generations.
    pub(crate) fn evolution(self) -> Evolution {
        let mut evolution = Evolution::default();
        match self {
            Self::MutationReplaces => evolution.mutation.kind = MutationKind::Replace,
            Self::MutationPerIndividual => evolution.mutation.per = MutationUnit::Individual,
            Self::WideGenes => {
                evolution.initial = [-5.0, 5.0];
                evolution.limits = Some([-5.0, 5.0]);
            }
            _ => (),
        }
        evolution
    }

    /// Arena and task, whatever robot and noise.
    pub(crate) fn world(self) -> WorldSpec {
        let main = WorldSpec::miglino1995();
        let Task::Avoidance {
            speed,
            difference,
            activation,
            new_cell,
        } = main.task;
        let task = match self {
            Self::Square => Task::Avoidance {
                speed,
                difference: oneiro::world::Difference::Square,
                activation,
                new_cell,
            },
            Self::Perceived => Task::Avoidance {
                speed,
                difference,
                activation: Activation::Perceived,
                new_cell,
            },
            Self::Signed => Task::Avoidance {
                speed: Speed::Signed,
                difference,
                activation,
                new_cell,
            },
            Self::TwoTerms => Task::Avoidance {
                speed,
                difference,
                activation: Activation::None,
                new_cell,
            },
            _ => main.task,
        };
        let arena = match self {
            Self::Triangle => Arena::miglino1995_triangle(),
            _ => main.arena,
        };
        WorldSpec { task, arena, ..main }
    }

    /// Which states the motors have.
    pub(crate) fn states(self) -> MotorStates {
        match self {
            Self::StatesAsymmetric => MotorStates::Asymmetric20,
            Self::StatesEvorobot => MotorStates::Evorobot21,
            _ => MotorStates::Symmetric20,
        }
    }

    /// How reality differs from its simulator.
    pub(crate) fn differences(self, severity: f32) -> Differences {
        match self {
            Self::LatencyCycle => Differences::all(severity).with_latency(100.0),
            Self::NoIllumination => Differences::without(severity, Difference::Illumination),
            Self::HalfSeverity => Differences::all(0.5 * severity),
            _ => Differences::all(severity),
        }
    }

    /// The robot's seed.
    pub(crate) fn robot(self, seed: u64) -> u64 {
        match self {
            Self::AnotherRobot => seed.wrapping_add(1),
            _ => seed,
        }
    }

    /// How the robot gets to the start of a real life.
    pub(crate) fn real_starts(self) -> RealStarts {
        match self {
            Self::RealStartsContinuing => RealStarts::Continuing,
            Self::RealStartsWalk => RealStarts::Walk,
            _ => RealStarts::Fresh,
        }
    }

    /// Turns before an object whose mean makes a row of its table.
    pub(crate) fn turns(self) -> u32 {
        match self {
            Self::TenReadings => 10,
            _ => 1,
        }
    }

    /// What a simulator looks up in place of a robot's samples.
    pub(crate) fn looked_up(self, sensors: &Arc<SensorTables>) -> Arc<SensorTables> {
        match self {
            Self::Interpolated => Arc::new(interpolated(sensors)),
            _ => Arc::clone(sensors),
        }
    }
}
