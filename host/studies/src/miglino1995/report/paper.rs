//! The paper's printed figures, as far as they can be compared with numbers: Miglino, Lund and Nolfi, "Evolving Mobile
//! Robots in Simulated and Real Environments", Artificial Life 2(4), 1995.

use crate::miglino1995::results::Condition;

/// Diameter of the robot, mm.
pub(super) const DIAMETER: f64 = 55.0;
/// Degrees of freedom of all tests of Tables 1 and 2.
pub(super) const DEGREES_OF_FREEDOM: &str = "1, 998";
/// Significance level of Tables 1 and 2.
pub(super) const LEVEL: f64 = 0.01;
/// Total runs, generations in simulation and in reality, and individuals in each.
pub(super) const RUNS: u64 = 15;
pub(super) const SIMULATED_GENERATIONS: u64 = 200;
pub(super) const REAL_GENERATIONS: u64 = 20;
pub(super) const POPULATION: u64 = 100;
/// Cycles of an episode, and their duration in seconds on an IBM RISC/6000 and in reality.
pub(super) const CYCLES: f64 = 500.0;
pub(super) const SIMULATED_EPISODE: f64 = 2.0;
pub(super) const REAL_EPISODE: f64 = 50.0;

/// Figures printed for one condition.
pub(super) struct Printed {
    /// F of Table 1 (simulation against reality in generation 200), and whether the effect is significant.
    pub(super) gap: (f64, bool),
    /// F of Table 2 (generation 200 against generation 219, in reality), and whether the effect is significant.
    pub(super) recovery: (f64, bool),
    /// Number of the figure of the generations, and the text's comment on it.
    pub(super) generations: (u32, &'static str),
    /// Number of the figure of the trajectories, and the text's comment on it.
    pub(super) trajectories: (u32, &'static str),
}

/// Figures printed for a condition.
pub(super) fn printed_figures(condition: Condition) -> Printed {
    match condition {
        Condition::None => Printed {
            gap: (164.14, true),
            recovery: (74.09, true),
            generations: (6, "individuals lose performance at the transfer and recover it rapidly"),
            trajectories: (
                9,
                "transferred robots often turn more than 90\u{b0} in corners and get stuck there",
            ),
        },
        Condition::Sensor => Printed {
            gap: (549.79, true),
            recovery: (30.74, true),
            generations: (
                7,
                "the peak loses less than without noise and the average more, and only the peak recovers",
            ),
            trajectories: (
                10,
                "robots are slower in reality than in simulation and sometimes hit obstacles",
            ),
        },
        Condition::Conservative => Printed {
            gap: (0.74, false),
            recovery: (26.01, true),
            generations: (
                8,
                "individuals score a bit lower in simulation and higher than both others in reality, where they still improve",
            ),
            trajectories: (
                11,
                "both paths match almost perfectly; the robot of run d is a bit slower in reality",
            ),
        },
    }
}
