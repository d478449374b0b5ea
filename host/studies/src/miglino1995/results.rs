//! Results of the study of Miglino, Lund and Nolfi (1995), before anything is judged: plain numbers, saved when they
//! are produced. Claims and figures are made from nothing else.

use serde::{Deserialize, Serialize};

use crate::assumptions::Assumption;

/// Noise of a simulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Condition {
    /// No noise.
    None,
    /// Random numbers added to the sensors.
    Sensor,
    /// Perceived positions displaced by a slow random walk.
    Conservative,
}

impl Condition {
    /// All conditions, in the paper's order.
    pub const ALL: [Self; 3] = [Self::None, Self::Sensor, Self::Conservative];

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Sensor => "sensor",
            Self::Conservative => "conservative",
        }
    }

    /// Name in reports.
    pub fn title(self) -> &'static str {
        match self {
            Self::None => "no noise",
            Self::Sensor => "sensor noise",
            Self::Conservative => "conservative noise",
        }
    }
}

/// All results of the study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Results {
    /// Generations selected by simulated fitness: 200.
    pub(crate) simulated_generations: u32,
    /// Generations in reality: 20, the first of them numbered `simulated_generations`.
    pub(crate) real_generations: u32,
    /// Individuals per generation.
    pub population: u32,
    /// Number of best individuals that reproduce, and whose mean is the peak: 20.
    pub parents: u32,
    /// Cycles of an episode, 100 ms each.
    pub cycles: u32,
    /// Assumptions in force, for the report.
    pub(crate) assumptions: Vec<Assumption>,
    /// Each difference's effect on readings and motion by itself.
    pub differences: Vec<DifferenceEffect>,
    /// Fitness of a handmade controller that goes to and fro without turning, in 100 episodes in the simulator without
    /// noise.
    pub(crate) to_and_fro: Vec<f32>,
    /// Whether a simulated episode took less than 2 s on this machine, a 25th of a real one.
    pub(crate) life_within_two_seconds: bool,
    /// Whether reality is a connected robot, which is measured less than a surrogate.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_wired: bool,
    /// With `--full`: the study's simulated half in other simulators.
    pub variants: Vec<Variant>,
    /// Runs in the order of their numbers; within a number, in the order of the conditions.
    pub runs: Vec<Run>,
}

/// Subject of a variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// Ranges of sensor noise.
    SensorRange,
    /// Ranges of conservative noise.
    WalkRange,
    /// Conservative noise of one range that changes in other ways.
    Displacement,
    /// Source of the simulator's tables.
    Simulator,
}

/// Evolution for 200 generations in another simulator, then generation 200's transfer to the study's reality.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Variant {
    pub family: Family,
    /// The difference from the study's simulator.
    pub name: String,
    /// For families of numbers: the upper end of the sensor noise, or the walk's range or maximum step in mm. Otherwise
    /// 0.
    pub value: f64,
    /// Mean simulated fitness of generation 200 for each run.
    pub simulated: Vec<f64>,
    /// Mean real fitness of generation 200 for each run.
    pub real: Vec<f64>,
}

/// With `--full`: mean real fitness if the twenty generations in reality are replaced.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Controls {
    /// Replaced by as many in simulation.
    pub(crate) simulated_on: f64,
    /// Replaced by as many in reality with randomly drawn parents.
    pub(crate) neutral: f64,
    /// Replaced by as many in reality, starting from random genes.
    pub(crate) from_random: f64,
}

/// Effect of a single difference between reality and simulator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct DifferenceEffect {
    /// Name of the difference.
    pub name: String,
    /// Root mean square change of an activation, 0 to 1, over episodes of random controllers.
    pub activation: f64,
    /// Root mean square distance after one cycle, mm.
    pub displacement: f64,
    /// Root mean square difference of the heading after one cycle, degrees.
    pub turn: f64,
}

/// One evolution, in simulation and then in reality.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Run {
    /// Noise of its simulator.
    pub condition: Condition,
    /// Number within its condition, from 0.
    pub number: u32,
    pub seed: u64,
    /// Generations 0 to 200 in simulation.
    pub simulated: Vec<Level>,
    /// Generations 200 to 219 in reality.
    pub real: Vec<Level>,
    /// Fitness of the individuals of generation 200, in their order.
    pub transferred: Transferred,
    /// Real fitness of the individuals of generation 219.
    pub last: Vec<f32>,
    /// Best of generation 200 in simulation.
    pub champion: Champion,
    /// With `--full`: other possible causes of a rise in real fitness.
    pub controls: Option<Controls>,
}

/// Fitness of a generation, ranked in the environment where it lived.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Level {
    /// Mean fitness of the best 20.
    pub peak: f64,
    /// Mean fitness of all individuals.
    pub average: f64,
}

/// Fitness of each individual of generation 200 in several episodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Transferred {
    /// In simulation with the noise it evolved with, as compared in the paper.
    pub simulated: Vec<f32>,
    /// In the same simulation from another start.
    pub(crate) simulated_again: Vec<f32>,
    /// In simulation without noise.
    pub quiet: Vec<f32>,
    /// In reality.
    pub real: Vec<f32>,
    /// In reality again, from another start.
    pub(crate) real_again: Vec<f32>,
    /// In another robot of the same kind, in the same surroundings. Empty for a connected robot.
    pub(crate) other_robot: Vec<f32>,
}

/// Best individual of a run's generation 200.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Champion {
    /// Index in the generation.
    pub individual: u32,
    /// Mean fitness in the episodes that it was chosen by. `None` if it was chosen by a single episode, as the best of
    /// [`Transferred::simulated`].
    pub mean: Option<f64>,
    /// 16 weights and 2 biases: eight weights and a bias for each output.
    pub genome: Vec<f32>,
    /// Episode in simulation, from the start that all champions share.
    pub simulated: MeasuredEpisode,
    /// Episode in reality, from the same start.
    pub real: MeasuredEpisode,
    /// Distances between simulated and real paths.
    pub(crate) discrepancy: Discrepancy,
}

/// An episode with measures of its behaviour.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct MeasuredEpisode {
    pub fitness: f32,
    /// The robot's centre at the start of each cycle, mm.
    pub path: Vec<[f32; 2]>,
    /// Share of cycles that end in a collision. NaN on a wire, where nothing reports collisions.
    pub collided: f64,
    /// Share of cycles in which both wheels turn forwards.
    pub forwards: f64,
    /// Share of the arena's free 50 mm cells visited by the robot's centre.
    pub visited: f64,
    /// Mean absolute wheel speed, 0 to 1.
    pub speed: f64,
    /// Length of the path, mm.
    pub length: f64,
    /// Whether the robot spends its last 100 cycles within 100 mm of a corner and moves less than 50 mm in them.
    pub(crate) stuck_in_corner: bool,
}

/// Cumulative distances between two paths at cycles 5, 10, .. 5 k (equation 2), mm; entry i is of k = i + 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Discrepancy {
    /// Between the simulated and the real episode from the shared start: the paper's Figure 12.
    pub paper: Vec<f64>,
    /// The same, as the mean over 100 other starts. This field and all that follow are empty or NaN for a connected
    /// robot.
    pub starts: Vec<f64>,
    /// Length of the simulated path, mm, as the mean over the 100 starts.
    pub length: f64,
    /// Between two real episodes from the same start, as the mean over the 100 starts.
    pub repeated: Vec<f64>,
    /// Between the simulated episode and the real episode of another run's champion, as the mean over the 100 starts.
    pub(crate) unrelated: Vec<f64>,
}

impl Discrepancy {
    /// D at the end of an episode, as the mean over the 100 starts. In ratios it serves as their sum.
    pub(crate) fn whole(&self) -> f64 {
        self.starts.last().copied().unwrap_or(f64::NAN)
    }

    /// D per mm of the simulated path: the ratio of the sums over several champions and all of their starts. A mean of
    /// ratios would depend on the episodes in which a robot hardly moves.
    pub(crate) fn per_length<'a>(all: impl IntoIterator<Item = &'a Self>) -> f64 {
        let sum = |(whole, length): (f64, f64), discrepancy: &Self| {
            (whole + discrepancy.whole(), length + discrepancy.length)
        };
        let (whole, length) = all.into_iter().fold((0.0, 0.0), sum);
        whole / length
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A champion that hardly moves counts as much as it moves.
    #[test]
    fn distances_per_length_are_ratios_of_sums() {
        let champion = |whole: f64, length: f64| Discrepancy {
            paper: Vec::new(),
            starts: vec![0.0, whole],
            length,
            repeated: Vec::new(),
            unrelated: Vec::new(),
        };
        let all = [champion(6000.0, 2000.0), champion(1200.0, 0.01), champion(5000.0, 0.0)];
        assert_eq!(Discrepancy::per_length(&all[..1]), 3.0);
        let ratio = Discrepancy::per_length(&all);
        assert!((ratio - 12_200.0 / 2000.01).abs() < 1e-12, "{ratio}");
        assert!(Discrepancy::per_length(&[]).is_nan());
        let wired = Discrepancy {
            starts: Vec::new(),
            ..champion(0.0, f64::NAN)
        };
        assert!(Discrepancy::per_length([&wired]).is_nan());
    }
}
