//! The first generation that lives on a robot, compared in the simulator and in reality: the fitness of its individuals, and the path
//! of the best of them.

use oneiro::batch::Trace;
use serde::{Deserialize, Serialize};

use super::rows::Row;
use crate::contents::Column;
use crate::evolve::ranked;

/// Cycles between the moments at which paths are compared (Miglino et al. 1995, equation 2).
pub(super) const TERM: u32 = 5;
/// The start of the compared paths: x and y in mm, heading in turns. The one of the 1995 study, which leaves it open.
pub(super) const START: [f32; 3] = [100.0, 90.0, 0.125];

/// What the first generation on the robot does elsewhere, as far as it is known.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Transferred {
    /// Fitness in the simulator, and there without its noise.
    pub(super) simulated: Vec<f32>,
    pub(super) quiet: Vec<f32>,
    /// Positions of the best in the simulator without noise, and in two lives in reality: x and y in mm, one after the other.
    pub(super) path: Vec<f32>,
    pub(super) real_paths: Vec<Vec<f32>>,
}

/// The columns of a sweep's table of results.
pub(super) static COLUMNS: [Column; 14] = [
    Column::number(
        "simulated",
        "",
        "with `robots = \"own\"`: the mean fitness of the first generation that lives in reality, in the simulator",
    ),
    Column::number(
        "simulated_peak",
        "",
        "there the mean of the best, as many as become parents",
    ),
    Column::number(
        "simulated_deviation",
        "",
        "there the standard deviation over individuals",
    ),
    Column::number(
        "quiet",
        "",
        "the mean fitness of the same generation in the simulator without noise",
    ),
    Column::number("quiet_peak", "", "there the mean of the best"),
    Column::number("quiet_deviation", "", "there the standard deviation"),
    Column::number("real", "", "the mean fitness of the same generation in reality"),
    Column::number("real_peak", "", "there the mean of the best"),
    Column::number("real_deviation", "", "there the standard deviation"),
    Column::number("last", "", "the mean fitness of the last generation, in reality"),
    Column::number("last_peak", "", "there the mean of the best"),
    Column::number("last_deviation", "", "there the standard deviation"),
    Column::number(
        "path_gap_mm",
        "mm",
        "the distance between a life in the simulator without noise and one in reality, from one start, of the individual that is \
         best in the simulator: the sum over every fifth cycle",
    ),
    Column::number("path_repeat_mm", "mm", "that distance between two lives in reality"),
];

impl Transferred {
    /// The individual whose paths are compared: the best in the simulator.
    pub(super) fn best(&self) -> u32 {
        ranked(&self.simulated)[0]
    }

    /// The cells of [`COLUMNS`]; `first` and `last` are the rows of the generations in reality.
    pub(super) fn cells(&self, parents: u32, first: &Row, last: &Row) -> Vec<String> {
        let of_row = |row: &Row| [row.mean, row.peak, row.deviation];
        let of = |fitness: &[f32]| of_row(&Row::of(0, fitness, &ranked(fitness), parents));
        let paths = match &self.real_paths[..] {
            [real, again] => [between(&self.path, real), between(real, again)],
            _ => [f64::NAN; 2],
        };
        let numbers = [of(&self.simulated), of(&self.quiet), of_row(first), of_row(last)];
        let numbers = numbers.iter().flatten().chain(&paths);
        numbers.map(|number| format!("{number:.6}")).collect()
    }
}

/// The positions of a life.
pub(super) fn positions(trace: &Trace) -> Vec<f32> {
    trace.iter().flat_map(|record| [record.x, record.y]).collect()
}

/// The sum of the distances between two paths after their common start.
fn between(one: &[f32], other: &[f32]) -> f64 {
    let pairs = one.chunks_exact(2).zip(other.chunks_exact(2));
    let distance = |(a, b): (&[f32], &[f32])| {
        let (x, y) = (f64::from(a[0] - b[0]), f64::from(a[1] - b[1]));
        (x * x + y * y).sqrt()
    };
    pairs.skip(1).map(distance).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_part_by_the_sum_of_their_distances() {
        assert_eq!(
            between(&[0.0, 9.0, 0.0, 0.0, 1.0, 1.0], &[7.0, 0.0, 3.0, 4.0, 1.0, 3.0]),
            7.0
        );
    }

    #[test]
    fn cells_are_those_of_the_columns() {
        let transferred = Transferred {
            simulated: vec![1.0, 3.0],
            quiet: vec![5.0, 5.0],
            path: vec![0.0, 0.0, 0.0, 0.0],
            real_paths: vec![vec![0.0, 0.0, 3.0, 4.0], vec![0.0, 0.0, 3.0, 5.0]],
        };
        assert_eq!(transferred.best(), 1);
        let row = Row::of(0, &[2.0, 4.0], &[1, 0], 1);
        let cells = transferred.cells(1, &row, &row);
        assert_eq!(cells.len(), COLUMNS.len());
        assert_eq!(
            cells.join(" "),
            "2.000000 3.000000 1.414214 5.000000 5.000000 0.000000 3.000000 4.000000 1.414214 3.000000 4.000000 1.414214 5.000000 \
             1.000000"
        );
    }
}
