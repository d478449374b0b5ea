//! What the study of Miglino, Lund and Nolfi (1995) gave, before anything is judged: plain numbers, saved as they
//! come and the only thing that claims and figures are made of.

use serde::{Deserialize, Serialize};

use crate::studies::assumptions::Assumption;

/// What noise a simulator adds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Condition {
    /// No noise.
    None,
    /// A random number is added to each sensor.
    Sensor,
    /// What is perceived is displaced by a slow walk.
    Conservative,
}

impl Condition {
    /// Each of them, in the paper's order.
    pub(crate) const ALL: [Self; 3] = [Self::None, Self::Sensor, Self::Conservative];

    /// Its name in files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Sensor => "sensor",
            Self::Conservative => "conservative",
        }
    }

    /// What reports call it.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::None => "no noise",
            Self::Sensor => "sensor noise",
            Self::Conservative => "conservative noise",
        }
    }
}

/// All that the study found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Results {
    /// Generations that were selected by simulated fitness: 200.
    pub(crate) simulated_generations: u32,
    /// Generations that lived in reality: 20, the first of them being number `simulated_generations`.
    pub(crate) real_generations: u32,
    /// Individuals of a generation.
    pub(crate) population: u32,
    /// How many make the peak, and reproduce: 20.
    pub(crate) parents: u32,
    /// Cycles of a life, of 100 ms.
    pub(crate) cycles: u32,
    /// What was in force, for the report.
    pub(crate) assumptions: Vec<Assumption>,
    /// How much the reality's differences from its simulator change readings and motion, one by one.
    pub(crate) differences: Vec<DifferenceEffect>,
    /// Fitness of a controller made by hand that goes to and fro without turning, in 100 lives in the simulator
    /// without noise.
    pub(crate) to_and_fro: Vec<f32>,
    /// Whether a simulated life took less than 2 s here, a 25th of a real one.
    pub(crate) life_within_two_seconds: bool,
    /// With `--full`: the first half of the study in other simulators.
    pub(crate) variants: Vec<Variant>,
    /// Run by run, and in each the conditions in their order.
    pub(crate) runs: Vec<Run>,
}

/// What a variant is one of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Family {
    /// Ranges of sensor noise.
    SensorRange,
    /// Ranges of conservative noise.
    WalkRange,
    /// Conservative noise of one range, by how it changes.
    Displacement,
    /// What the simulator is made from.
    Simulator,
}

/// Evolution for 200 generations in another simulator, and then generation 200 in the study's reality.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Variant {
    /// What it is one of.
    pub(crate) family: Family,
    /// What is different.
    pub(crate) name: String,
    /// Of a family of numbers its own: the upper end of a sensor noise, the range of a walk in mm, or its greatest step
    /// in mm. Otherwise 0.
    pub(crate) value: f64,
    /// Mean simulated fitness of generation 200, run by run.
    pub(crate) simulated: Vec<f64>,
    /// Mean real fitness of generation 200, run by run.
    pub(crate) real: Vec<f64>,
}

/// With `--full`: mean real fitness where twenty generations in reality are replaced.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Controls {
    /// By as many in simulation.
    pub(crate) simulated_on: f64,
    /// By as many in reality with parents drawn by lot.
    pub(crate) neutral: f64,
    /// By as many in reality from random genes.
    pub(crate) from_random: f64,
}

/// What one difference between reality and simulator does by itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct DifferenceEffect {
    /// Its name.
    pub(crate) name: String,
    /// Root mean square change of an activation, 0 to 1, along lives of random controllers.
    pub(crate) activation: f64,
    /// Root mean square distance after one cycle, mm.
    pub(crate) displacement: f64,
    /// Root mean square difference of the heading after one cycle, degrees.
    pub(crate) turn: f64,
}

/// One evolution: in simulation, then in reality.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Run {
    /// What noise its simulator adds.
    pub(crate) condition: Condition,
    /// Its number within its condition, from 0.
    pub(crate) number: u32,
    /// Its seed.
    pub(crate) seed: u64,
    /// Generations 0 to 200 in simulation.
    pub(crate) simulated: Vec<Level>,
    /// Generations 200 to 219 in reality.
    pub(crate) real: Vec<Level>,
    /// The individuals of generation 200, in their order.
    pub(crate) transferred: Transferred,
    /// The real fitness of the individuals of generation 219.
    pub(crate) last: Vec<f32>,
    /// The best of generation 200 in simulation.
    pub(crate) champion: Champion,
    /// What else could have raised real fitness, with `--full`.
    pub(crate) controls: Option<Controls>,
}

/// How well a generation does, ranked in the environment where it lived.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Level {
    /// Mean fitness of the best 20.
    pub(crate) peak: f64,
    /// Mean fitness of all.
    pub(crate) average: f64,
}

/// The fitness of each individual of generation 200, life by life.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Transferred {
    /// In simulation with the noise it evolved with: what the paper compares.
    pub(crate) simulated: Vec<f32>,
    /// The same again from another start.
    pub(crate) simulated_again: Vec<f32>,
    /// In simulation without noise.
    pub(crate) quiet: Vec<f32>,
    /// In reality.
    pub(crate) real: Vec<f32>,
    /// In reality again, from another start.
    pub(crate) real_again: Vec<f32>,
    /// In another robot of the same kind, in the same surroundings.
    pub(crate) other_robot: Vec<f32>,
}

/// The best individual of a run's generation 200.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Champion {
    /// Its index in the generation.
    pub(crate) individual: u32,
    /// Its mean fitness in the lives that it was chosen by. None: it was chosen by a single one, the best of
    /// [`Transferred::simulated`].
    pub(crate) mean: Option<f64>,
    /// 16 weights and 2 biases: for each output eight weights and a bias.
    pub(crate) genome: Vec<f32>,
    /// Its life in simulation, from the start that all share.
    pub(crate) simulated: Life,
    /// Its life in reality, from there.
    pub(crate) real: Life,
    /// How far simulated and real paths are apart.
    pub(crate) discrepancy: Discrepancy,
}

/// A life and how it was lived.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Life {
    /// Its fitness.
    pub(crate) fitness: f32,
    /// The robot's centre at the start of each cycle, mm.
    pub(crate) path: Vec<[f32; 2]>,
    /// Share of cycles that end in a collision.
    pub(crate) collided: f64,
    /// Share of cycles in which both wheels turn forwards.
    pub(crate) forwards: f64,
    /// Share of the arena's free cells of 50 mm that the robot's centre visits.
    pub(crate) visited: f64,
    /// Mean of the wheels' absolute speed, 0 to 1.
    pub(crate) speed: f64,
    /// Length of the path, mm.
    pub(crate) length: f64,
    /// Whether it spends its last 100 cycles within 100 mm of a corner and goes less than 50 mm in them.
    pub(crate) stuck_in_corner: bool,
}

/// Sums of the distances between two paths at cycles 5, 10, .. 5 k (equation 2), mm; entry i is of k = i + 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Discrepancy {
    /// Between the simulated and the real life from the shared start: the paper's Figure 12.
    pub(crate) paper: Vec<f64>,
    /// The same, the mean of 100 other starts.
    pub(crate) starts: Vec<f64>,
    /// `starts` at its end over the simulated path's length, the mean of the 100 starts.
    pub(crate) per_length: f64,
    /// Between two real lives from one start, the mean of the 100 starts.
    pub(crate) repeated: Vec<f64>,
    /// Between the simulated life and the real life of another run's champion, the mean of the 100 starts.
    pub(crate) unrelated: Vec<f64>,
}
