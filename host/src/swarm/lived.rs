//! What is asked of a swarm's run, and what it gave: plain numbers.

use clap::ValueEnum;
use oneiro::foraging::Light;
use oneiro::swarm::Lamp;
use serde::{Deserialize, Serialize};

/// The experiment cases of section 4.1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Case {
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
    pub(crate) const ALL: [Self; 6] = [
        Self::NoLight,
        Self::Over,
        Self::Opposite,
        Self::OverThenOpposite,
        Self::OppositeThenOver,
        Self::Random,
    ];

    /// The paper's name.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::NoLight => "No Light Source",
            Self::Over => "Light Fixed Over Nest",
            Self::Opposite => "Light Fixed Opposite Nest",
            Self::OverThenOpposite => "Light Over Nest \u{2192} Light Opposite Nest",
            Self::OppositeThenOver => "Light Opposite Nest \u{2192} Light Over Nest",
            Self::Random => "Random Movement",
        }
    }

    /// Where the light is in the first and in the second half.
    pub(crate) fn lights(self) -> [Light; 2] {
        match self {
            Self::NoLight | Self::Random => [Light::Nowhere; 2],
            Self::Over => [Light::OverNest; 2],
            Self::Opposite => [Light::OppositeNest; 2],
            Self::OverThenOpposite => [Light::OverNest, Light::OppositeNest],
            Self::OppositeThenOver => [Light::OppositeNest, Light::OverNest],
        }
    }

    /// Its lamp, which moves at a cycle.
    pub(crate) fn lamp(self, moves: u32) -> Lamp {
        let [first, then] = self.lights();
        Lamp { first, then, moves }
    }
}

/// What of the distributed evolution is left as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Kind {
    /// All of it.
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
    /// One robot alone.
    Alone,
}

impl Kind {
    /// All of them.
    pub(crate) const ALL: [Self; 7] = [
        Self::Evolved,
        Self::FitnessShuffled,
        Self::SimulatorShuffled,
        Self::SimulatorRight,
        Self::SimulatorWrong,
        Self::SimulatorRandom,
        Self::Alone,
    ];

    /// What readers see.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Evolved => "as the paper",
            Self::FitnessShuffled => "fitness shuffled (null)",
            Self::SimulatorShuffled => "simulators shuffled",
            Self::SimulatorRight => "simulators right",
            Self::SimulatorWrong => "simulators wrong",
            Self::SimulatorRandom => "simulators random",
            Self::Alone => "one robot alone",
        }
    }
}

/// Which pair a robot's fitness is credited to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Credit {
    /// The simulator that the robot has while it earns it, as the paper says.
    Lagged,
    /// The simulator in which the controller was chosen that earns it.
    Matched,
}

impl Credit {
    /// What readers see.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Lagged => "lagged",
            Self::Matched => "matched",
        }
    }
}

/// One run: fifty minutes of a swarm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Run {
    /// Its experiment case.
    pub(crate) case: Case,
    /// What was left as it is.
    pub(crate) kind: Kind,
    /// Its number among those of its case and kind, from 0.
    pub(crate) number: u32,
    /// The second in which each robot is switched on, and its first interval begins.
    pub(crate) switched_on: Vec<u16>,
    /// Food that all robots brought in each second, 3000 of them.
    pub(crate) brought: Vec<u16>,
    /// Interval by interval what each robot was and did, one less than there is time for if robots are switched on a
    /// whole interval apart; empty without evolution.
    pub(crate) intervals: Vec<Vec<RobotInterval>>,
}

/// One robot in one interval of 60 s of its own clock.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct RobotInterval {
    /// The gene of its simulator, 0 to 0.99.
    pub(crate) s0: f32,
    /// The gene of the simulator in which the controller was chosen that acts: that of the interval before, unless
    /// controllers are installed within their interval.
    pub(crate) chosen_under: f32,
    /// The controller that acts: the behaviour with food, 0 to 0.99.
    pub(crate) g0: f32,
    /// That without food.
    pub(crate) g1: f32,
    /// Fitness that counted as its own, `F_R` (equation 1): under the null another robot's.
    pub(crate) real: f32,
    /// Fitness that the same controller had in the simulator in which it was chosen; none in the first interval.
    pub(crate) simulated: Option<f32>,
    /// How many robots it heard.
    pub(crate) heard: u16,
    /// How many robots it can reach by the encounters of this interval, itself among them.
    pub(crate) reached: u16,
    /// Whether the simulator that it goes on with came from another robot; not in the last interval, after which none
    /// goes on.
    pub(crate) taken: bool,
}
