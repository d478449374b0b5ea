//! What the study does: every choice that the paper leaves open, by name, with its value and its source.

use oneiro::surrogate::{Differences, Individual, Surrogate};
use oneiro::world::{Noise, WorldSpec};
use serde::{Deserialize, Serialize};

use super::arms::Arm;
use super::results::Condition;
use crate::evolve::genetic;
use crate::reality::site::Site;
use crate::studies::assumptions::Assumption;

/// Generations that are selected by simulated fitness.
pub(crate) const SIMULATED: u32 = 200;
/// Generations that live in reality.
pub(crate) const REAL: u32 = 20;
/// How different reality is from its simulator: chosen by the calibration of `docs/preregistration-1995.md`, on the
/// condition without noise and on other robots.
pub(crate) const SEVERITY: f32 = 1.75;

/// A whole study. Two studies with equal settings give equal reports.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Settings {
    /// Everything random but the robot comes from it.
    pub(crate) seed: u64,
    /// Runs of each condition.
    pub(crate) runs: u32,
    /// The seed of the surrogate robot and its surroundings.
    pub(crate) robot: u64,
    /// How different reality is from its simulator, 0 to 2.
    pub(crate) severity: f32,
    /// What is assumed otherwise than preregistered.
    pub(crate) arm: Arm,
    /// With controls and with other simulators.
    pub(crate) full: bool,
    /// Hashes of the files with the simulator's tables, where it is not made from samples of the surrogate.
    pub(crate) tables: Vec<String>,
}

impl Settings {
    /// The noise of a condition's simulator.
    pub(crate) fn noise(&self, condition: Condition) -> Noise {
        self.arm.noise(condition)
    }

    /// The genetic algorithm, through all generations.
    pub(crate) fn evolution(&self) -> genetic::Settings {
        genetic::Settings {
            generations: SIMULATED + REAL,
            ..self.arm.evolution()
        }
    }

    /// How reality differs from its simulator.
    pub(crate) fn differences(&self) -> Differences {
        self.arm.differences(self.severity)
    }

    /// The robot's seed.
    pub(crate) fn robot(&self) -> u64 {
        self.arm.robot(self.robot)
    }

    /// The robot that is sampled and lives.
    pub(crate) fn surrogate(&self) -> Surrogate {
        Surrogate::drawn(self.robot(), self.differences())
    }

    /// That robot as the site of reality.
    pub(crate) fn reality(&self) -> Site {
        Site::surrogate(self.robot(), self.surrogate())
    }

    /// Another robot of the same kind in the same surroundings.
    pub(crate) fn other_reality(&self) -> Site {
        let surrogate = Surrogate {
            individual: Individual::drawn(self.robot().wrapping_add(1)),
            ..self.surrogate()
        };
        Site::surrogate(self.robot(), surrogate)
    }

    /// The hash of the sampled robot's parameters, of its surroundings and of how reality differs.
    pub(crate) fn parameters_hash(&self) -> String {
        let text = format!("{:?}", self.surrogate());
        blake3::hash(text.as_bytes()).to_hex()[..16].to_owned()
    }

    /// Which robot it is, and what its simulator is made from.
    pub(crate) fn describe(&self) -> String {
        let reality = format!(
            "surrogate:{}, severity {}, parameters {}",
            self.robot(),
            self.surrogate().differences.severity,
            self.parameters_hash()
        );
        if self.tables.is_empty() {
            format!("{reality}; its simulator is made from its samples")
        } else {
            let tables = self.tables.join(", ");
            format!(
                "{reality}; the simulator is made from recordings of another robot ({tables}), to which the surrogate is fitted in nothing"
            )
        }
    }

    /// The seed of a run.
    pub(crate) fn run_seed(&self, condition: Condition, number: u32) -> u64 {
        let index = self.seed.wrapping_mul(1 << 20).wrapping_add(u64::from(number));
        index.wrapping_mul(4).wrapping_add(condition as u64)
    }

    /// Arena and task, whatever robot and noise.
    pub(crate) fn world(&self) -> WorldSpec {
        self.arm.world()
    }

    /// All that is assumed, for the report.
    pub(crate) fn assumptions(&self) -> Vec<Assumption> {
        let evolution = self.evolution();
        let row = |name: &str, value: String, source: &str| Assumption {
            name: name.into(),
            value,
            source: source.into(),
        };
        let arm = (self.arm != Arm::Main).then(|| {
            row(
                "arm",
                self.arm.name(),
                "ours: in place of the preregistered choice below that it names",
            )
        });
        let main =
            vec![
            row("runs", format!("{} a condition", self.runs), "paper: 5"),
            row(
                "generations",
                format!("{SIMULATED} selected in simulation, then {REAL} in reality, from number {SIMULATED}"),
                "paper; generation 200 lives in both, unmutated in between: ours",
            ),
            row("population", evolution.population.to_string(), "paper"),
            row(
                "parents",
                format!("{}, equally many copies each", evolution.parents),
                "paper",
            ),
            row(
                "mutation",
                format!(
                    "each gene with probability {}, + U(-{1}, {1})",
                    evolution.mutation.rate, evolution.mutation.amount
                ),
                "paper: \"25 %\", not of what, nor how large: ours",
            ),
            row(
                "champion",
                "the best single simulated life of generation 200".into(),
                "ours",
            ),
            row("first genes", "U(-1, 1)".into(), "ours"),
            row(
                "fitness.V",
                "mean of the wheels' absolute speeds".into(),
                "from the paper's remark on Figure 11 d",
            ),
            row(
                "fitness.DV",
                "root of the difference of signed speeds".into(),
                "Floreano and Mondada; the paper prints the square",
            ),
            row(
                "fitness.I",
                "the greatest activation without added noise".into(),
                "ours",
            ),
            row(
                "collision",
                "undoes the cycle's motion and earns nothing".into(),
                "Evorobot",
            ),
            row(
                "motor states",
                "-10 to -1 and 1 to 10, symmetric".into(),
                "ours; the paper has 20 x 20 states",
            ),
            row(
                "arena",
                "600 x 350 mm, obstacles of radius 27.5 mm at (180, 175), (300, 175), (420, 175) mm".into(),
                "paper; the obstacles' places are ours",
            ),
            row(
                "start",
                "uniform free pose, a fresh one for each life".into(),
                "paper: random position; heading and reality: ours",
            ),
            row(
                "noise.sensor",
                "U(0, 0.4) added to each activation, clipped".into(),
                "paper, read literally",
            ),
            row("noise.walk_range", "30 mm".into(), "paper"),
            row(
                "noise.walk_step",
                "U(-1.5, 1.5) mm each cycle, reflected".into(),
                "ours",
            ),
            row(
                "network",
                "8 inputs, 2 logistic outputs, 16 weights and 2 biases".into(),
                "paper; logistic: Evorobot",
            ),
            row(
                "samples",
                "180 bearings x 20 distances from 5 mm in steps of 2 mm, one reading a point, look-up by truncation"
                    .into(),
                "paper; distances and truncation: Evorobot",
            ),
            row(
                "reality",
                format!("surrogate robot {}, parameters {}", self.robot(), self.parameters_hash()),
                "docs/preregistration-1995.md",
            ),
            row(
                "reality.severity",
                self.severity.to_string(),
                "calibrated as docs/preregistration-1995.md says",
            ),
        ];
        arm.into_iter().chain(main).collect()
    }
}
