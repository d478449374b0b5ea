//! What a run of a sweep gave: its row of the table of results, and its rows of the table of generations.

use serde::{Deserialize, Serialize};

use super::table::{Column, Holds};
use super::{RunIndex, Sweep};
use crate::evolve::{Champion, Generation};
use crate::record::{self, Row};
use crate::run::keys;
use crate::statistics::mean;
use crate::swarm::lived::Run as SwarmRun;
use crate::swarm::settings::Settings as SwarmSettings;
use crate::swarm::tables::INTERVALS_HEAD;

/// A finished run. Numbers are text as the tables have it, so that every way to them has the same bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Outcome {
    pub(crate) run: RunIndex,
    /// A cell of each of [`Sweep::outcomes`].
    pub(crate) cells: Vec<String>,
    /// The lines of its generations, without the table's first line.
    pub(crate) generations: String,
    /// The hash of its results, the same that a directory of this run has.
    pub(crate) result: String,
}

/// Of single robots: the champion's fitness and whose it was; of the last generation the mean of the parents and of
/// all; scores of the whole run that are NaN.
const KHEPERA: [Column; 6] = [
    ("best", Holds::Number),
    ("best_generation", Holds::Whole),
    ("best_individual", Holds::Whole),
    ("peak", Holds::Number),
    ("mean", Holds::Number),
    ("nan", Holds::Whole),
];

/// Of the last offspring, which nobody selected: their mean fitness in the simulator, their mean and their best in
/// reality.
const REALITY: [Column; 3] = [
    ("simulated", Holds::Number),
    ("real", Holds::Number),
    ("real_best", Holds::Number),
];

/// Of swarms: food in all and per robot-minute; per robot-minute in the last fifth of the time, and there the share of
/// simulators that have the light where it is, and their mean gene.
const SWARM: [Column; 5] = [
    ("brought", Holds::Whole),
    ("rate", Holds::Number),
    ("late_rate", Holds::Number),
    ("late_right", Holds::Number),
    ("late_s0", Holds::Number),
];

/// The columns of tables of generations: a run's own, as its directory has them.
const GENERATIONS: [Column; 9] = [
    ("generation", Holds::Whole),
    ("best", Holds::Number),
    ("peak", Holds::Number),
    ("mean", Holds::Number),
    ("least", Holds::Number),
    ("deviation", Holds::Number),
    ("individual", Holds::Whole),
    ("nan", Holds::Whole),
    ("best_bits", Holds::Text),
];
const INTERVALS: [Column; 11] = [
    ("interval", Holds::Whole),
    ("robot", Holds::Whole),
    ("s0", Holds::Number),
    ("chosen_under", Holds::Number),
    ("g0", Holds::Number),
    ("g1", Holds::Number),
    ("real", Holds::Number),
    ("simulated", Holds::Number),
    ("heard", Holds::Whole),
    ("reached", Holds::Whole),
    ("taken", Holds::Whole),
];

/// What reports show of a sweep: columns, and what readers call them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shown {
    /// The outcome that cells are compared by; higher is better.
    pub(crate) by: (&'static str, &'static str),
    /// Of the table of generations, along the axes of learning curves.
    pub(crate) time: (&'static str, &'static str),
    pub(crate) value: (&'static str, &'static str),
}

impl Sweep {
    /// What reports show where nobody asks for something else.
    pub(crate) fn shown(&self) -> Shown {
        if self.is_swarm() {
            return Shown {
                by: ("rate", "food per robot-minute"),
                time: ("interval", "interval"),
                value: ("real", "real fitness of a robot's interval"),
            };
        }
        let by = if self.file().reality.is_some() {
            ("real", "mean fitness of the last offspring in reality")
        } else {
            ("peak", "mean fitness of the last generation's parents")
        };
        Shown {
            by,
            time: ("generation", "generation"),
            value: ("peak", "mean fitness of the parents"),
        }
    }

    /// The columns of what its runs give.
    pub(crate) fn outcomes(&self) -> Vec<Column> {
        if self.is_swarm() {
            return SWARM.to_vec();
        }
        let reality = self.file().reality.iter().flat_map(|_| REALITY);
        KHEPERA.into_iter().chain(reality).collect()
    }

    /// The columns of its runs' generations; of swarms a line is a robot's interval.
    pub(crate) fn generations(&self) -> &'static [Column] {
        if self.is_swarm() { &INTERVALS } else { &GENERATIONS }
    }

    /// The first line of a run's own table of generations.
    pub(crate) fn generations_head(&self) -> &'static str {
        if self.is_swarm() { INTERVALS_HEAD } else { Row::HEAD }
    }
}

/// The end of one evolution.
#[derive(Debug)]
pub(crate) struct Ended<'a> {
    pub(crate) run: RunIndex,
    pub(crate) seed: u64,
    pub(crate) trials: u32,
    pub(crate) identity: blake3::Hash,
    /// The last generation and its line of the table.
    pub(crate) last: &'a Generation,
    pub(crate) row: &'a Row,
    pub(crate) champion: &'a Champion,
    /// All lines.
    pub(crate) generations: String,
    /// Scores that were NaN.
    pub(crate) nan: u64,
}

impl Ended<'_> {
    /// What it gave, as far as its own simulator can tell.
    pub(crate) fn outcome(self) -> Outcome {
        let champion = self.champion;
        let keys: Vec<_> = keys(self.seed, champion.generation, champion.individual, self.trials).collect();
        let result = record::result(self.identity, &self.generations, self.last, champion, self.seed, &keys);
        Outcome {
            run: self.run,
            cells: vec![
                champion.fitness.to_string(),
                champion.generation.to_string(),
                champion.individual.to_string(),
                format!("{:.6}", self.row.peak),
                format!("{:.6}", self.row.mean),
                self.nan.to_string(),
            ],
            generations: self.generations,
            result,
        }
    }
}

impl Outcome {
    /// Adds what the last offspring did in the simulator and in reality: their fitness, one for each of their lives.
    pub(crate) fn met_reality(&mut self, simulated: &[f32], real: &[f32]) {
        let mean_of = |fitness: &[f32]| mean(&fitness.iter().copied().map(f64::from).collect::<Vec<_>>());
        let best = real.iter().copied().fold(f32::NAN, f32::max);
        self.cells.push(format!("{:.6}", mean_of(simulated)));
        self.cells.push(format!("{:.6}", mean_of(real)));
        self.cells.push(best.to_string());
    }

    /// What a swarm's run gave.
    pub(crate) fn of_swarm(run: RunIndex, identity: blake3::Hash, settings: &SwarmSettings, lived: &SwarmRun) -> Self {
        let (result, generations) = record::swarm_result(identity, lived);
        Self {
            run,
            cells: lived.cells(settings),
            generations,
            result,
        }
    }
}
