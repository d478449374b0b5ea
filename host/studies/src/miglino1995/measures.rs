//! Measures of champions' episodes, and of the differences between reality and simulator.

use oneiro::batch::{Record, Trace};
use oneiro::tables::SENSORS;
use oneiro::world::{Start, World, WorldSpec};
use oneiro_lab::lives::measures::{Grid, PLACES, distance, is_stuck, moves};

use super::results::{DifferenceEffect, Discrepancy, MeasuredEpisode};

/// Cycles between terms of D (equation 2).
const TERM: usize = 5;
/// A simulated and a real episode from the same start.
pub(super) struct Pair {
    pub(super) simulated: Trace,
    pub(super) real: Trace,
}

/// Cumulative distances between two episodes at cycles 5, 10, .. in mm (equation 2).
fn discrepancy<'a>(one: &'a [Record], other: &'a [Record]) -> impl Iterator<Item = f64> + 'a {
    let pairs = one.iter().zip(other).skip(TERM).step_by(TERM);
    pairs.scan(0.0, |sum, (a, b)| {
        *sum += distance(a, b);
        Some(*sum)
    })
}

fn path_length(episode: &[Record]) -> f64 {
    moves(episode).sum()
}

/// Sums over starts.
#[derive(Default)]
pub(super) struct Sums {
    starts: Vec<f64>,
    repeated: Vec<f64>,
    unrelated: Vec<f64>,
    length: f64,
    count: usize,
}

impl Sums {
    /// Adds a simulated and a real episode from a start, the real one repeated, and another champion's two.
    pub(super) fn add(&mut self, pair: &Pair, again: &Trace, other: &Pair) {
        let add = |sums: &mut Vec<f64>, values: &mut dyn Iterator<Item = f64>| {
            for (index, value) in values.enumerate() {
                if index == sums.len() {
                    sums.push(0.0);
                }
                sums[index] += value;
            }
        };
        add(&mut self.starts, &mut discrepancy(&pair.simulated, &pair.real));
        add(&mut self.repeated, &mut discrepancy(&pair.real, again));
        add(&mut self.unrelated, &mut discrepancy(&pair.simulated, &other.real));
        self.length += path_length(&pair.simulated);
        self.count += 1;
    }

    /// The sums from the shared start, and the means over the others. Without others these are not there.
    pub(super) fn mean(self, shared: &Pair) -> Discrepancy {
        let count = self.count as f64;
        let mean = |sums: Vec<f64>| sums.into_iter().map(|sum| sum / count).collect();
        Discrepancy {
            paper: discrepancy(&shared.simulated, &shared.real).collect(),
            starts: mean(self.starts),
            length: self.length / count,
            repeated: mean(self.repeated),
            unrelated: mean(self.unrelated),
        }
    }
}

/// A moment of an episode.
pub(super) struct Moment {
    pub(super) record: Record,
    pub(super) activations: [f32; SENSORS],
}

/// Root mean square changes of activations, position and heading.
pub(super) fn effect(name: &str, with: &[Moment], without: &[Moment]) -> DifferenceEffect {
    let mean = |change: &dyn Fn(&Moment, &Moment) -> f64| {
        let sum: f64 = with.iter().zip(without).map(|(a, b)| change(a, b)).sum();
        (sum / with.len() as f64).sqrt()
    };
    let square = |a: f32, b: f32| (f64::from(a) - f64::from(b)) * (f64::from(a) - f64::from(b));
    DifferenceEffect {
        name: name.into(),
        activation: mean(&|a, b| {
            let pairs = a.activations.into_iter().zip(b.activations);
            pairs.map(|(a, b)| square(a, b)).sum::<f64>() / 8.0
        }),
        displacement: mean(&|a, b| square(a.record.x, b.record.x) + square(a.record.y, b.record.y)),
        turn: mean(&|a, b| {
            let turn = f64::from(a.record.heading) - f64::from(b.record.heading);
            let degrees = 360.0 * (turn - (turn + 0.5).floor());
            degrees * degrees
        }),
    }
}

/// The arena's cells of 50 mm, and its corners.
pub(super) struct Cells {
    grid: Grid,
    free: Vec<bool>,
    corners: Vec<[f32; 2]>,
}

impl Cells {
    pub(super) fn new(spec: &WorldSpec) -> Self {
        let grid = Grid::new(spec.arena.field);
        let free = (0..grid.columns * grid.rows)
            .map(|cell| {
                let [x, y] = grid.middle(cell);
                let start = Start::At { x, y, heading: 0.0 };
                World::new(WorldSpec { start, ..spec.clone() }).is_ok()
            })
            .collect();
        Self {
            grid,
            free,
            corners: spec.arena.walls.iter().map(|wall| wall.from).collect(),
        }
    }

    /// Measures an episode from a trace with one cycle more than the episode counts.
    pub(super) fn measure_episode(&self, trace: &[Record]) -> MeasuredEpisode {
        let lived = &trace[..trace.len() - 1];
        let share = |which: &dyn Fn(&Record) -> bool| {
            lived.iter().filter(|record| which(record)).count() as f64 / lived.len() as f64
        };
        let mut visited = vec![false; self.free.len()];
        for record in lived {
            visited[self.grid.cell(record)] = true;
        }
        let free = self.free.iter().filter(|free| **free).count();
        let seen = visited
            .iter()
            .zip(&self.free)
            .filter(|(seen, free)| **seen && **free)
            .count();
        let speeds: f64 = lived
            .iter()
            .map(|record| 0.5 * (f64::from(record.speed_left).abs() + f64::from(record.speed_right).abs()))
            .sum();
        MeasuredEpisode {
            fitness: lived.last().map_or(0.0, |record| record.fitness),
            path: trace.iter().map(|record| [record.x, record.y]).collect(),
            collided: share(&|record| record.collided > 0.0),
            forwards: share(&|record| record.speed_left > 0.0 && record.speed_right > 0.0),
            visited: seen as f64 / free.max(1) as f64,
            speed: speeds / lived.len() as f64,
            length: path_length(trace),
            stuck_in_corner: self.stuck(trace),
        }
    }

    /// Whether the robot spends the last 100 cycles within 100 mm of one corner and moves less than 50 mm in them.
    fn stuck(&self, trace: &[Record]) -> bool {
        const NEAR: f32 = 100.0;
        let end = &trace[trace.len().saturating_sub(PLACES)..];
        let near = |&[x, y]: &[f32; 2]| {
            end.iter().all(|record| {
                let (x, y) = (record.x - x, record.y - y);
                x * x + y * y < NEAR * NEAR
            })
        };
        is_stuck(moves(end)) && self.corners.iter().any(near)
    }
}
