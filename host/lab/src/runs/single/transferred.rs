//! The robot's first generation, compared in the simulator and in reality: the fitness of its individuals, and the path of the
//! best of them.

use oneiro::batch::Trace;
use oneiro_base::contents::{Column, OutcomeColumn};
use oneiro_evolve::ranked;
use oneiro_report::numbers::fixed;
use serde::{Deserialize, Serialize};

use super::rows::Row;

/// Cycles between the moments at which paths are compared (Miglino et al. 1995, equation 2).
pub(super) const TERM: u32 = 5;
/// The start of the compared paths: x and y in mm, heading in turns. The 1995 paper does not give one; this is the 1995 study's.
pub(super) const START: [f32; 3] = [100.0, 90.0, 0.125];

/// The complete results of the robot's first generation elsewhere.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Transferred {
    /// Fitness in the simulator, and there without its noise.
    pub(super) simulated: Vec<f32>,
    pub(super) quiet: Vec<f32>,
    /// Positions of the best in the simulator without noise, and in two episodes in reality: x and y in mm, one after the other.
    pub(super) path: Vec<f32>,
    pub(super) real_paths: Vec<Vec<f32>>,
}

/// The comparison's numbers for a sweep's table.
#[derive(Debug)]
pub(super) struct Compared {
    /// The first generation in reality: in the simulator, there without its noise, and in reality.
    simulated: Row,
    quiet: Row,
    real: Row,
    /// The last generation, in reality.
    last: Row,
    /// Distances between paths in the simulator and in reality, and between two in reality.
    paths: [f64; 2],
}

/// The text of a value.
type Text = fn(&Compared) -> String;

/// The columns of a sweep's table of results, and their values.
pub(super) static OUTCOMES: [OutcomeColumn<Text>; 14] = [
    OutcomeColumn::new(
        Column::number(
            "simulated",
            "",
            "with `robots = \"own\"`: the simulated mean fitness of the first generation that is evaluated in reality",
        ),
        |own| fixed(own.simulated.mean, 6),
    ),
    OutcomeColumn::new(
        Column::number(
            "simulated_peak",
            "",
            "there the mean of the best, as many as become parents",
        ),
        |own| fixed(own.simulated.peak, 6),
    ),
    OutcomeColumn::new(
        Column::number(
            "simulated_deviation",
            "",
            "there the standard deviation over individuals",
        ),
        |own| fixed(own.simulated.deviation, 6),
    ),
    OutcomeColumn::new(
        Column::number(
            "quiet",
            "",
            "the mean fitness of the same generation in the simulator without noise",
        ),
        |own| fixed(own.quiet.mean, 6),
    ),
    OutcomeColumn::new(Column::number("quiet_peak", "", "there the mean of the best"), |own| {
        fixed(own.quiet.peak, 6)
    }),
    OutcomeColumn::new(
        Column::number("quiet_deviation", "", "there the standard deviation"),
        |own| fixed(own.quiet.deviation, 6),
    ),
    OutcomeColumn::new(
        Column::number("real", "", "the mean fitness of the same generation in reality"),
        |own| fixed(own.real.mean, 6),
    ),
    OutcomeColumn::new(Column::number("real_peak", "", "there the mean of the best"), |own| {
        fixed(own.real.peak, 6)
    }),
    OutcomeColumn::new(
        Column::number("real_deviation", "", "there the standard deviation"),
        |own| fixed(own.real.deviation, 6),
    ),
    OutcomeColumn::new(
        Column::number("last", "", "the mean fitness of the last generation, in reality"),
        |own| fixed(own.last.mean, 6),
    ),
    OutcomeColumn::new(Column::number("last_peak", "", "there the mean of the best"), |own| {
        fixed(own.last.peak, 6)
    }),
    OutcomeColumn::new(
        Column::number("last_deviation", "", "there the standard deviation"),
        |own| fixed(own.last.deviation, 6),
    ),
    OutcomeColumn::new(
        Column::number(
            "path_gap_mm",
            "mm",
            "the distance between an episode in the simulator without noise and one in reality, from one start, of the individual that is \
         best in the simulator: the sum over every fifth cycle",
        ),
        |own| fixed(own.paths[0], 6),
    ),
    OutcomeColumn::new(
        Column::number("path_repeat_mm", "mm", "that distance between two episodes in reality"),
        |own| fixed(own.paths[1], 6),
    ),
];

impl Transferred {
    /// The individual whose paths are compared: the best in the simulator.
    pub(super) fn best(&self) -> u32 {
        ranked(&self.simulated)[0]
    }

    /// The comparison, with the rows of the first and the last generation in reality.
    pub(super) fn compared(&self, parents: u32, first: &Row, last: &Row) -> Compared {
        let of = |fitness: &[f32]| Row::of(0, fitness, &ranked(fitness), parents);
        Compared {
            simulated: of(&self.simulated),
            quiet: of(&self.quiet),
            real: first.clone(),
            last: last.clone(),
            paths: match &self.real_paths[..] {
                [real, again] => [between(&self.path, real), between(real, again)],
                _ => [f64::NAN; 2],
            },
        }
    }
}

/// The positions of an episode.
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
    fn values_are_those_of_the_columns() {
        let transferred = Transferred {
            simulated: vec![1.0, 3.0],
            quiet: vec![5.0, 5.0],
            path: vec![0.0, 0.0, 0.0, 0.0],
            real_paths: vec![vec![0.0, 0.0, 3.0, 4.0], vec![0.0, 0.0, 3.0, 5.0]],
        };
        assert_eq!(transferred.best(), 1);
        let row = Row::of(0, &[2.0, 4.0], &[1, 0], 1);
        let compared = transferred.compared(1, &row, &row);
        let cells: Vec<String> = OUTCOMES.iter().map(|outcome| (outcome.value)(&compared)).collect();
        assert_eq!(
            cells.join(" "),
            "2.000000 3.000000 1.414214 5.000000 5.000000 0.000000 3.000000 4.000000 1.414214 3.000000 4.000000 1.414214 5.000000 \
             1.000000"
        );
    }
}
