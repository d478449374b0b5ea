//! Cases and controls of swarms' runs, and a run's record.

use oneiro::foraging::Light;
use oneiro::swarm::Lamp;
use serde::{Deserialize, Serialize};

/// Places of the light that simulators tell apart.
pub const LIGHTS: [Light; 3] = [Light::OppositeNest, Light::Nowhere, Light::OverNest];

/// The experiment cases of section 4.1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Case {
    /// 1. No light source.
    NoLight,
    /// 2. The light stays over the nest.
    Over,
    /// 3. The light stays opposite the nest.
    Opposite,
    /// 4. Over the nest, after half of the time opposite.
    OverThenOpposite,
    /// 5. Opposite the nest, after half of the time over it.
    OppositeThenOver,
    /// 6. No evolution: all search at random.
    Random,
}

impl Case {
    /// All of them, in the paper's order.
    pub const ALL: [Self; 6] = [
        Self::NoLight,
        Self::Over,
        Self::Opposite,
        Self::OverThenOpposite,
        Self::OppositeThenOver,
        Self::Random,
    ];

    /// The paper's name.
    pub fn title(self) -> &'static str {
        match self {
            Self::NoLight => "No Light Source",
            Self::Over => "Light Fixed Over Nest",
            Self::Opposite => "Light Fixed Opposite Nest",
            Self::OverThenOpposite => "Light Over Nest \u{2192} Light Opposite Nest",
            Self::OppositeThenOver => "Light Opposite Nest \u{2192} Light Over Nest",
            Self::Random => "Random Movement",
        }
    }

    /// The light's place in the first and in the second half.
    pub fn lights(self) -> [Light; 2] {
        match self {
            Self::NoLight | Self::Random => [Light::Nowhere; 2],
            Self::Over => [Light::OverNest; 2],
            Self::Opposite => [Light::OppositeNest; 2],
            Self::OverThenOpposite => [Light::OverNest, Light::OppositeNest],
            Self::OppositeThenOver => [Light::OppositeNest, Light::OverNest],
        }
    }

    /// Its lamp, which moves at this cycle.
    pub fn lamp(self, moves: u32) -> Lamp {
        let [first, then] = self.lights();
        Lamp { first, then, moves }
    }
}

/// The paper's distributed evolution, a control in which the experimenter intervenes, or another method in its place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// The paper's evolution.
    #[default]
    Evolved,
    /// The null: real fitness is shuffled among robots before it is compared.
    FitnessShuffled,
    /// Simulators are shuffled among robots after each exchange.
    SimulatorShuffled,
    /// All simulators always have the light where it is.
    SimulatorRight,
    /// All simulators always have the light where it is not.
    SimulatorWrong,
    /// Each simulator is drawn anew each interval.
    SimulatorRandom,
    /// A single robot.
    Alone,
    /// No simulators: a robot takes over the controller with the highest real fitness, its own or a received one, mutated.
    Embodied,
    /// No simulators: a robot takes over one of the received controllers at random, mutated (after mEDEA).
    EmbodiedRandom,
    /// Simulators are compared by how well they predicted real fitness.
    Disparity,
    /// Every robot hears all others, wherever they are.
    HeardByAll,
    /// All robots have one simulator: the one that best predicted what all of them reached in the last interval.
    Central,
}

impl Kind {
    /// The paper's own, and the controls of its study.
    pub const OF_STUDY: [Self; 7] = [
        Self::Evolved,
        Self::FitnessShuffled,
        Self::SimulatorShuffled,
        Self::SimulatorRight,
        Self::SimulatorWrong,
        Self::SimulatorRandom,
        Self::Alone,
    ];

    /// Other methods.
    pub const RIVALS: [Self; 5] = [
        Self::Embodied,
        Self::EmbodiedRandom,
        Self::Disparity,
        Self::HeardByAll,
        Self::Central,
    ];

    /// The number of simulators in which a robot evaluates each controller.
    pub fn simulators(self) -> usize {
        match self {
            Self::Embodied | Self::EmbodiedRandom => 0,
            // With the light at each of its places.
            Self::Central => LIGHTS.len(),
            _ => 1,
        }
    }

    /// Whether robots have simulators, and controllers are chosen in them.
    pub fn has_simulators(self) -> bool {
        self.simulators() > 0
    }

    /// Whether robots exchange what they have.
    pub fn exchanges(self) -> bool {
        self != Self::Central
    }

    /// Whether the experimenter sets all simulators, whatever robots have heard.
    pub fn sets_simulators(self) -> bool {
        matches!(
            self,
            Self::SimulatorRight | Self::SimulatorWrong | Self::SimulatorRandom
        )
    }

    /// Whether simulators only change by exchange, so that each descends from a robot's first one.
    pub fn has_lineages(self) -> bool {
        matches!(
            self,
            Self::Evolved | Self::FitnessShuffled | Self::Alone | Self::Disparity | Self::HeardByAll
        )
    }

    /// The name in reports.
    pub fn title(self) -> &'static str {
        match self {
            Self::Evolved => "as the paper",
            Self::FitnessShuffled => "fitness shuffled",
            Self::SimulatorShuffled => "simulators shuffled",
            Self::SimulatorRight => "simulators right",
            Self::SimulatorWrong => "simulators wrong",
            Self::SimulatorRandom => "simulators random",
            Self::Alone => "one robot alone",
            Self::Embodied => "no simulators, the best controllers spread",
            Self::EmbodiedRandom => "no simulators, controllers spread at random",
            Self::Disparity => "simulators that predict best spread",
            Self::HeardByAll => "all hear all",
            Self::Central => "one simulator, from all robots' data",
        }
    }
}

/// The simulator that a robot's fitness is credited to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Credit {
    /// The one that the robot has while it earns the fitness, as the paper says.
    Lagged,
    /// The one in which the controller was chosen that earns it.
    Matched,
}

/// The record of a swarm's run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Its experiment case.
    pub case: Case,
    /// The evolution or the control.
    pub kind: Kind,
    /// Its number among those of its case and kind, from 0.
    pub number: u32,
    /// The second in which each robot is switched on, and its first interval begins.
    pub switched_on: Vec<u16>,
    /// Food that all robots brought in each second.
    pub brought: Vec<u16>,
    /// Each robot in each interval; empty without evolution. If robots are switched on a whole interval apart, there is one
    /// interval less than there is time for.
    pub intervals: Vec<Vec<RobotInterval>>,
}

/// One robot in one interval of 60 s of that robot's clock.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotInterval {
    /// The gene of its simulator, 0 to 0.99.
    pub s0: f32,
    /// The gene of the simulator in which the acting controller was chosen: that of the interval before, unless controllers are
    /// installed within their interval.
    pub chosen_under: f32,
    /// Gene of the acting controller for behaviour with food, 0 to 0.99.
    pub g0: f32,
    /// Gene of the acting controller for behaviour without food, 0 to 0.99.
    pub g1: f32,
    /// Its real fitness, `F_R` (equation 1).
    pub real: f32,
    /// The fitness of the same controller in the simulator in which it was chosen; none in the first interval.
    pub simulated: Option<f32>,
    /// Number of robots whose messages it received.
    pub heard: u16,
    /// How many robots it can reach by the encounters of this interval, itself among them.
    pub reached: u16,
    /// Whether the simulator of its next interval came from another robot; false in the last interval.
    pub taken: bool,
    /// The robot whose first simulator its simulator descends from.
    pub founder: u16,
}
