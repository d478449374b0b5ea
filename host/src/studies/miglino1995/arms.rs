//! The study under other assumptions: each arm changes one choice that the paper leaves open.

use std::sync::{Arc, LazyLock};

use clap::ValueEnum;
use clap::builder::{PossibleValue, Str, StyledStr};
use oneiro::arena::Arena;
use oneiro::surrogate::{Difference, Differences};
use oneiro::tables::{MotorStates, SensorTables};
use oneiro::world::{Activation, Noise, Speed, Task, WorldSpec};
use serde::{Deserialize, Serialize};

use super::interpolation::interpolated;
use super::real_lives::RealStarts;
use super::results::Condition;
use crate::evolve::genetic::{self, MutationKind, MutationUnit};

/// One assumption that is made otherwise. On the command line and in files it goes by its [name](Self::name).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub(crate) enum Arm {
    Main,
    Square,
    Perceived,
    Signed,
    TwoTerms,
    StatesAsymmetric,
    StatesEvorobot,
    Triangle,
    SymmetricNoiseNarrow,
    SymmetricNoiseWide,
    WalkStepSmall,
    WalkStepLarge,
    TenReadings,
    Interpolated,
    MutationReplaces,
    MutationPerIndividual,
    WideGenes,
    ChampionByMean,
    CellsVisited,
    LatencyCycle,
    HalfSeverity,
    AnotherRobot,
    RealStartsContinuing,
    RealStartsWalk,
    Only(Difference),
    Without(Difference),
}

impl ValueEnum for Arm {
    fn value_variants<'a>() -> &'a [Self] {
        static ALL: LazyLock<Vec<Arm>> = LazyLock::new(|| {
            let others = Arm::groups().into_iter().flat_map(|(_, arms)| arms);
            std::iter::once(Arm::Main).chain(others).collect()
        });
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        fn named(name: impl Into<Str>, sentence: impl Into<StyledStr>) -> PossibleValue {
            PossibleValue::new(name).help(sentence)
        }
        Some(match self {
            Self::Main => named("main", "As preregistered"),
            Self::Square => named("square", "The square of DV, as the paper prints it"),
            Self::Perceived => named(
                "perceived",
                "(1 - I) with the activation as perceived, added noise included",
            ),
            Self::Signed => named("signed", "V is the mean of signed speeds"),
            Self::TwoTerms => named("two-terms", "No (1 - I), as Jakobi et al. 1995"),
            Self::StatesAsymmetric => named("states-asymmetric", "Motor states -10 to 9"),
            Self::StatesEvorobot => named("states-evorobot", "Motor states -10 to 10, rounded as Evorobot does"),
            Self::Triangle => named("triangle", "The obstacles in a triangle"),
            Self::SymmetricNoiseNarrow => named("symmetric-noise-narrow", "Sensor noise from -0.2 to 0.2"),
            Self::SymmetricNoiseWide => named("symmetric-noise-wide", "Sensor noise from -0.4 to 0.4"),
            Self::WalkStepSmall => named("walk-step-small", "Conservative noise with steps of 0.3 mm"),
            Self::WalkStepLarge => named("walk-step-large", "Conservative noise with steps of 5 mm"),
            Self::TenReadings => named("ten-readings", "Each sampled point is the rounded mean of ten turns"),
            Self::Interpolated => named(
                "interpolated",
                "Samples interpolated to half a degree and half a millimetre",
            ),
            Self::MutationReplaces => named("mutation-replaces", "Mutations replace genes by fresh ones"),
            Self::MutationPerIndividual => named(
                "mutation-per-individual",
                "A quarter of the individuals is mutated, in all genes",
            ),
            Self::WideGenes => named("wide-genes", "First genes from -5 to 5, and all kept there"),
            Self::ChampionByMean => named(
                "champion-by-mean",
                "Champions have the best mean of 100 simulated lives, not the best single one",
            ),
            Self::CellsVisited => named(
                "cells-visited",
                "Simulated lives are selected by 5 more for each new cell of 50 mm, as the paper's conclusion proposes",
            ),
            Self::LatencyCycle => named("latency-cycle", "Readings 100 ms old"),
            Self::HalfSeverity => named("half-severity", "Half the severity"),
            Self::AnotherRobot => named("another-robot", "Another robot in other surroundings"),
            Self::RealStartsContinuing => named(
                "real-starts-continuing",
                "Each real life starts where the last one of its run stopped",
            ),
            Self::RealStartsWalk => named(
                "real-starts-walk",
                "Between two real lives of a run the robot drives about for 10 s",
            ),
            Self::Only(difference) => named(
                format!("only-{}", difference.name().replace('_', "-")),
                format!("Reality differs in {} alone", difference.name().replace('_', " ")),
            ),
            Self::Without(difference) => named(
                format!("without-{}", difference.name().replace('_', "-")),
                format!("Reality differs in all but {}", difference.name().replace('_', " ")),
            ),
        })
    }
}

impl From<Arm> for String {
    fn from(arm: Arm) -> Self {
        arm.name()
    }
}

impl TryFrom<String> for Arm {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        <Self as ValueEnum>::from_str(&name, false)
    }
}

impl Arm {
    /// Every arm but the main one, by what it is about, in the order of `--help` and reports.
    pub(crate) fn groups() -> [(&'static str, Vec<Self>); 6] {
        [
            (
                "Simulator and reality: fitness, motors, arena",
                vec![
                    Self::Square,
                    Self::Perceived,
                    Self::Signed,
                    Self::TwoTerms,
                    Self::StatesAsymmetric,
                    Self::StatesEvorobot,
                    Self::Triangle,
                ],
            ),
            (
                "The simulator: its noise and its samples",
                vec![
                    Self::SymmetricNoiseNarrow,
                    Self::SymmetricNoiseWide,
                    Self::WalkStepSmall,
                    Self::WalkStepLarge,
                    Self::TenReadings,
                    Self::Interpolated,
                ],
            ),
            (
                "The genetic algorithm and its champions",
                vec![
                    Self::MutationReplaces,
                    Self::MutationPerIndividual,
                    Self::WideGenes,
                    Self::ChampionByMean,
                    Self::CellsVisited,
                ],
            ),
            (
                "Reality",
                vec![
                    Self::LatencyCycle,
                    Self::HalfSeverity,
                    Self::AnotherRobot,
                    Self::RealStartsContinuing,
                    Self::RealStartsWalk,
                ],
            ),
            (
                "Reality with one difference from the simulator",
                Difference::ALL.map(Self::Only).to_vec(),
            ),
            (
                "Reality with all differences but one",
                Difference::ALL.map(Self::Without).to_vec(),
            ),
        ]
    }

    /// What it is called on the command line and in files.
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
    pub(crate) fn evolution(self) -> genetic::Settings {
        let mut evolution = genetic::Settings::default();
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

    /// Simulated lives of each individual of generation 200 by whose mean the champion is chosen. None: it is chosen by
    /// the one that simulation and reality are compared by.
    pub(crate) fn champion_lives(self) -> Option<u32> {
        (self == Self::ChampionByMean).then_some(100)
    }

    /// What simulated lives are selected by besides their fitness: what each cell of 50 mm is worth that is new. Only
    /// selection knows of it; fitness is as everywhere, since a real robot does not know where it is.
    pub(crate) fn new_cell(self) -> Option<f32> {
        (self == Self::CellsVisited).then_some(5.0)
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
            Self::HalfSeverity => Differences::all(0.5 * severity),
            Self::Only(difference) => Differences::only(severity, difference),
            Self::Without(difference) => Differences::without(severity, difference),
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

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use clap::CommandFactory;

    use super::*;
    use crate::cli::Cli;

    /// Studies that were kept go by these names.
    #[test]
    fn names_stay_as_they_are() {
        let names: BTreeSet<String> = Arm::value_variants().iter().map(|arm| arm.name()).collect();
        assert_eq!(names.len(), Arm::value_variants().len(), "no two have the same");
        for name in [
            "main",
            "square",
            "perceived",
            "signed",
            "two-terms",
            "states-asymmetric",
            "states-evorobot",
            "triangle",
            "symmetric-noise-narrow",
            "symmetric-noise-wide",
            "walk-step-small",
            "walk-step-large",
            "mutation-replaces",
            "mutation-per-individual",
            "wide-genes",
            "latency-cycle",
            "half-severity",
            "another-robot",
            "real-starts-continuing",
            "real-starts-walk",
            "ten-readings",
            "interpolated",
            "champion-by-mean",
            "only-geometry",
            "only-read-noise",
            "without-illumination",
            "without-motor-lag",
        ] {
            assert!(names.contains(name), "{name}");
        }
    }

    /// `--help` has every arm in a line, with what it assumes.
    #[test]
    fn help_lists_every_arm() {
        let mut command = Cli::command();
        command.build();
        let reproduce = command.find_subcommand_mut("reproduce").unwrap();
        let study = reproduce.find_subcommand_mut("miglino1995").unwrap();
        let help = study.render_long_help().to_string();
        let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        let help = words(&help);
        for arm in Arm::value_variants() {
            let line = words(&format!("- {}: {}", arm.name(), arm.describe()));
            assert!(help.contains(&line), "{line}");
        }
    }

    #[test]
    fn files_have_an_arm_by_its_name() {
        for &arm in Arm::value_variants() {
            let text = serde_json::to_string(&arm).unwrap();
            assert_eq!(text, format!("\"{}\"", arm.name()));
            assert_eq!(serde_json::from_str::<Arm>(&text).unwrap(), arm);
            assert!(!arm.describe().is_empty(), "{text}");
        }
        assert!(serde_json::from_str::<Arm>("\"only-magic\"").is_err());
    }

    #[test]
    fn a_difference_is_alone_or_the_only_one_that_is_missing() {
        for difference in Difference::ALL {
            for other in Difference::ALL {
                let strength = |arm: Arm| arm.differences(1.75).strength(other);
                let expected = if other == difference { [1.75, 0.0] } else { [0.0, 1.75] };
                let name = (difference.name(), other.name());
                assert_eq!(
                    [strength(Arm::Only(difference)), strength(Arm::Without(difference))],
                    expected,
                    "{name:?}"
                );
            }
            assert!(Arm::value_variants().contains(&Arm::Only(difference)));
            assert!(Arm::value_variants().contains(&Arm::Without(difference)));
        }
    }
}
