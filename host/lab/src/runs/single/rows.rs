//! The table of generations.

use std::fmt::Write as _;

use oneiro_base::contents::{Column, head};
use oneiro_evolve::Generation;
use oneiro_report::numbers::fixed;
use serde::{Deserialize, Serialize};

/// The table's columns.
pub(super) static COLUMNS: [Column; 9] = [
    Column::whole("generation", "", "its number, from 0"),
    Column::number("best", "", "the highest fitness"),
    Column::number(
        "peak",
        "",
        "the mean fitness of those that become parents (`evolution.parents`)",
    ),
    Column::number("mean", "", "the mean fitness of all"),
    Column::number("least", "", "the lowest fitness"),
    Column::number("deviation", "", "the standard deviation of the fitness of all"),
    Column::whole("individual", "", "the index of the best"),
    Column::whole(
        "nan",
        "",
        "the number of NaN fitness values; they rank last and are left out of the other columns",
    ),
    Column::text("best_bits", "`best` as its 32 bits, in hex"),
];

/// One row of `generations.csv`: statistics of a generation. NaN scores are counted and left out of the rest;
/// statistics without any score are NaN.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Row {
    /// Number, from 0.
    pub generation: u32,
    /// The best score.
    pub best: f32,
    /// Mean score of the individuals that become parents, the best 20 in the paper.
    pub peak: f64,
    /// Mean score of all individuals.
    pub mean: f64,
    /// Minimum score.
    pub least: f32,
    /// Standard deviation of all scores, with divisor n - 1.
    pub deviation: f64,
    /// Index of the best individual.
    pub individual: u32,
    /// Number of NaN scores.
    pub nan: u32,
}

impl Row {
    /// Statistics of a generation with `parents` parents.
    pub(crate) fn new(generation: &Generation, parents: u32) -> Self {
        Self::of(generation.number, &generation.fitness, &generation.ranking, parents)
    }

    /// Statistics of the scores of a generation, with its individuals by their rank.
    pub(super) fn of(number: u32, fitness: &[f32], all: &[u32], parents: u32) -> Self {
        let score = |&individual: &u32| fitness[individual as usize];
        // NaN ranks last.
        let nan = fitness.iter().filter(|score| score.is_nan()).count();
        let numbers = all.len() - nan;
        let ranking = &all[..numbers];
        let mean = |ranking: &[u32]| {
            ranking
                .iter()
                .map(|individual| f64::from(score(individual)))
                .sum::<f64>()
                / ranking.len() as f64
        };
        let average = mean(ranking);
        let squares: f64 = ranking
            .iter()
            .map(|individual| f64::from(score(individual)) - average)
            .map(|difference| difference * difference)
            .sum();
        Self {
            generation: number,
            best: ranking.first().map_or(f32::NAN, score),
            peak: mean(&ranking[..numbers.min(parents as usize)]),
            mean: average,
            least: ranking.last().map_or(f32::NAN, score),
            deviation: if numbers == 1 {
                0.0
            } else {
                (squares / (numbers as f64 - 1.0)).sqrt()
            },
            individual: all.first().copied().unwrap_or_default(),
            nan: nan as u32,
        }
    }

    /// Formats a line of the table.
    pub(crate) fn line(&self) -> String {
        let Self {
            generation,
            best,
            peak,
            mean,
            least,
            deviation,
            individual,
            nan,
        } = self;
        let bits = best.to_bits();
        let mut line = String::with_capacity(128);
        // Writing to a string can't fail.
        let _ = writeln!(
            line,
            "{generation},{best},{},{},{least},{},{individual},{nan},{bits:08x}",
            fixed(*peak, 6),
            fixed(*mean, 6),
            fixed(*deviation, 6)
        );
        line
    }

    /// Parses a table, or returns a problem with its line.
    pub(super) fn parse(text: &str) -> Result<Vec<Self>, String> {
        let head = head(&COLUMNS);
        if !text.starts_with(&head) {
            return Err(format!("line 1: is not {}", head.trim_end()));
        }
        let rows = csv::Reader::from_reader(text.as_bytes()).into_deserialize();
        let rows = rows
            .zip(2..)
            .map(|(row, number)| row.map_err(|_| format!("line {number}: is not a generation's")));
        rows.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use oneiro_evolve::Population;

    fn generation(fitness: &[f32], ranking: &[u32]) -> Generation {
        Generation {
            number: 7,
            population: Population::new(1, vec![0.0; fitness.len()]),
            fitness: fitness.to_vec(),
            ranking: ranking.to_vec(),
        }
    }

    #[test]
    fn a_row_sums_up_its_generation() {
        let row = Row::new(&generation(&[1.0, 4.0, 2.0, 5.0], &[3, 1, 2, 0]), 2);
        assert_eq!(
            (row.generation, row.best, row.least, row.individual, row.nan),
            (7, 5.0, 1.0, 3, 0)
        );
        assert_eq!((row.peak, row.mean), (4.5, 3.0));
        assert!((row.deviation - (10.0_f64 / 3.0).sqrt()).abs() < 1e-12);
        assert_eq!(row.line(), "7,5,4.500000,3.000000,1,1.825742,3,0,40a00000\n");
    }

    #[test]
    fn nan_is_counted_and_left_out() {
        let row = Row::new(&generation(&[f32::NAN, 4.0, 2.0], &[1, 2, 0]), 3);
        assert_eq!(
            (row.best, row.least, row.peak, row.mean, row.nan),
            (4.0, 2.0, 3.0, 3.0, 1)
        );
        let none = Row::new(&generation(&[f32::NAN; 2], &[0, 1]), 1);
        assert!(none.best.is_nan() && none.mean.is_nan() && none.peak.is_nan() && none.least.is_nan());
        assert_eq!(none.nan, 2);
    }

    #[test]
    fn a_table_reads_as_it_was_written() {
        let rows: Vec<Row> = [[0.1, -3.5], [1e-9, 0.0]]
            .map(|fitness| Row::new(&generation(&fitness, &[0, 1]), 1))
            .to_vec();
        let table = head(&COLUMNS) + &rows[0].line() + &rows[1].line();
        let again = Row::parse(&table).unwrap();
        assert_eq!(again[0].best, 0.1);
        assert_eq!(again[1].best, 1e-9);
        assert_eq!(again.len(), 2);
        assert!(Row::parse("").unwrap_err().contains("line 1"));
        assert!(Row::parse(&(head(&COLUMNS) + "1,2\n")).unwrap_err().contains("line 2"));
    }
}
