//! Measures of champions' episodes, and of the differences between reality and simulator.

use oneiro::arena::Arena;
use oneiro::batch::{Record, Trace};
use oneiro::tables::SENSORS;
use oneiro::world::{Start, World, WorldSpec};
use oneiro_lab::lives::measures::{Grid, PLACES, distance, is_stuck, moves};

use super::results::{DifferenceEffect, Discrepancy, MeasuredEpisode};

/// Cycles between terms of D (equation 2), and over which a path has its direction.
const TERM: usize = 5;
/// A robot this near to a corner, mm, is in it.
const IN_CORNER: f32 = 100.0;

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
            corners: corners(&spec.arena),
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
        let end = &trace[trace.len().saturating_sub(PLACES)..];
        let near = |corner: &[f32; 2]| end.iter().all(|record| is_in(*corner, [record.x, record.y]));
        is_stuck(moves(end)) && self.corners.iter().any(near)
    }
}

/// The corners of an arena.
pub(super) fn corners(arena: &Arena) -> Vec<[f32; 2]> {
    arena.walls.iter().map(|wall| wall.from).collect()
}

fn is_in(corner: [f32; 2], at: [f32; 2]) -> bool {
    let (x, y) = (at[0] - corner[0], at[1] - corner[1]);
    x * x + y * y < IN_CORNER * IN_CORNER
}

/// How often a path enters a corner and leaves it again, and how often by a turn of more than 90 degrees: its direction after it is
/// against that before it.
pub(super) fn corner_turns(path: &[[f32; 2]], corners: &[[f32; 2]]) -> [f64; 2] {
    let corner = |at: &[f32; 2]| corners.iter().position(|corner| is_in(*corner, *at));
    let along = |from: [f32; 2], to: [f32; 2]| [to[0] - from[0], to[1] - from[1]];
    let (mut visits, mut turns, mut begin) = (0.0, 0.0, 0);
    for visit in path.chunk_by(|one, other| corner(one) == corner(other)) {
        let end = begin + visit.len() - 1;
        if corner(&visit[0]).is_some() && begin >= TERM && end + TERM < path.len() {
            let before = along(path[begin - TERM], path[begin]);
            let after = along(path[end], path[end + TERM]);
            visits += 1.0;
            turns += f64::from(u8::from(before[0] * after[0] + before[1] * after[1] < 0.0));
        }
        begin = end + 1;
    }
    [visits, turns]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A path of straight lines, 8 mm a cycle.
    fn path(places: &[[f32; 2]]) -> Vec<[f32; 2]> {
        let lines = places.windows(2).flat_map(|ends| {
            let [from, to] = [ends[0], ends[1]];
            let length = (to[0] - from[0]).hypot(to[1] - from[1]);
            let steps = (length / 8.0).round();
            (0..steps as u32).map(move |step| {
                let share = step as f32 / steps;
                [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]
            })
        });
        lines.collect()
    }

    #[test]
    fn turns_of_more_than_a_right_angle_in_corners_are_counted() {
        let corners = [[0.0, 0.0], [600.0, 0.0]];
        let counted = |places: &[[f32; 2]]| corner_turns(&path(places), &corners);
        // Along one wall and away from it by less than 90 degrees; by more; and both, one after the other.
        let less = [[300.0, 40.0], [40.0, 40.0], [20.0, 300.0]];
        let more = [[300.0, 40.0], [40.0, 40.0], [160.0, 200.0]];
        assert_eq!(counted(&less), [1.0, 0.0]);
        assert_eq!(counted(&more), [1.0, 1.0]);
        assert_eq!(
            counted(&[&more[..], &[[300.0, 40.0], [560.0, 40.0], [600.0, 300.0]]].concat()),
            [2.0, 1.0]
        );
        // A wall far from corners is none, and who stays in a corner has not left it.
        assert_eq!(counted(&[[300.0, 300.0], [300.0, 40.0], [300.0, 300.0]]), [0.0, 0.0]);
        assert_eq!(counted(&more[..2]), [0.0, 0.0]);
    }
}
