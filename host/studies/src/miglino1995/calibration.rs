//! The calibration of the second edition: of each collision rule the two severities at which the surrogate has the paper's gap without
//! noise, and repeats its paths, by the rule of `docs/preregistration-1995-second.md`.

use std::collections::BTreeMap;

use oneiro_base::contents::Column;
use oneiro_report::csv::{Csv, number};
use oneiro_statistics::{mean, variance};

use super::second::{Run, effect};

/// d without noise in the paper's Table 1.
const D: f64 = 0.81;
/// Maximum distance between two real episodes, as a fraction of that between a simulated and a real one.
const REPEATABILITY: f64 = 0.5;

pub(super) static COLUMNS: [Column; 9] = [
    Column::text("rule", "the simulator's collision rule"),
    Column::number("severity", "", "the severity of what sensors see"),
    Column::number(
        "motion_severity",
        "",
        "the severity of motion and of the age of readings",
    ),
    Column::number(
        "d",
        "",
        "Cohen's d of generation 200, simulated minus real; mean over robots",
    ),
    Column::number("d_error", "", "the standard error of that mean"),
    Column::number(
        "repeatability",
        "",
        "mean `path_repeat_mm` over mean `path_gap_mm` of a robot; mean over robots",
    ),
    Column::number("repeatability_error", "", "the standard error of that mean"),
    Column::text("chosen", "`yes` for the rule's chosen pair of severities, else `no`"),
    Column::text(
        "missed",
        "the targets that the pair misses by more than two standard errors: `d`, `repeatability`",
    ),
];

/// A rule and a pair of severities, and the runs of each robot.
pub(super) type Pairs = BTreeMap<Key, Robots>;
type Key = (String, [String; 2]);
type Robots = BTreeMap<String, Vec<Run>>;

/// A mean over robots, and its standard error.
#[derive(Clone, Copy)]
struct Figure {
    mean: f64,
    error: f64,
}

impl Figure {
    fn of(robots: &[f64]) -> Self {
        Self {
            mean: mean(robots),
            error: (variance(robots) / robots.len() as f64).sqrt(),
        }
    }
}

/// A pair of severities, and what it gives.
struct Pair<'a> {
    rule: &'a str,
    severities: &'a [String; 2],
    d: Figure,
    repeatability: Figure,
}

impl Pair<'_> {
    fn repeats(&self) -> bool {
        self.repeatability.mean + self.repeatability.error <= REPEATABILITY
    }

    fn sum(&self) -> f64 {
        let numbers = self
            .severities
            .iter()
            .map(|severity| severity.parse::<f64>().unwrap_or(f64::NAN));
        numbers.sum()
    }

    fn missed(&self) -> String {
        let Self { d, repeatability, .. } = self;
        let is_missed = [
            ("d", (d.mean - D).abs() > 2.0 * d.error),
            (
                "repeatability",
                repeatability.mean - REPEATABILITY > 2.0 * repeatability.error,
            ),
        ];
        let names = is_missed
            .iter()
            .filter(|(_, is_missed)| *is_missed)
            .map(|(name, _)| *name);
        names.collect::<Vec<_>>().join(" ")
    }
}

/// The table of all pairs.
pub(super) fn table(pairs: &Pairs) -> String {
    fn pair<'a>((key, robots): (&'a Key, &Robots)) -> Pair<'a> {
        let of = |figure: &dyn Fn(&[&Run]) -> f64| {
            let robots = robots.values().map(|runs| figure(&runs.iter().collect::<Vec<_>>()));
            Figure::of(&robots.collect::<Vec<_>>())
        };
        Pair {
            rule: &key.0,
            severities: &key.1,
            d: of(&effect),
            repeatability: of(&|runs| {
                let sum = |of: fn(&Run) -> f64| runs.iter().map(|run| of(run)).sum::<f64>();
                sum(|run| run.path_repeat) / sum(|run| run.path_gap)
            }),
        }
    }
    let all: Vec<Pair<'_>> = pairs.iter().map(pair).collect();
    let mut table = Csv::new(&COLUMNS);
    for pair in &all {
        let of_rule = all.iter().filter(|other| other.rule == pair.rule);
        let is_chosen = chosen(of_rule).is_some_and(|chosen| std::ptr::eq(chosen, pair));
        let [severity, motion] = pair.severities.clone();
        let figures = [
            pair.d.mean,
            pair.d.error,
            pair.repeatability.mean,
            pair.repeatability.error,
        ]
        .map(number);
        let ends = [if is_chosen { "yes" } else { "no" }.to_owned(), pair.missed()];
        table.row(
            [pair.rule.to_owned(), severity, motion]
                .into_iter()
                .chain(figures)
                .chain(ends),
        );
    }
    table.text()
}

/// A rule's chosen pair.
fn chosen<'a, 'b>(pairs: impl Iterator<Item = &'b Pair<'a>> + Clone) -> Option<&'b Pair<'a>>
where
    'a: 'b,
{
    let far = |pair: &Pair<'_>| (pair.d.mean - D).abs();
    let nearest = pairs.clone().filter(|pair| pair.repeats());
    let nearest = nearest.min_by(|a, b| far(a).total_cmp(&far(b)).then(a.sum().total_cmp(&b.sum())));
    nearest.or_else(|| pairs.min_by(|a, b| a.repeatability.mean.total_cmp(&b.repeatability.mean)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rows of pairs, each with its severities, d, and repeatability; robots are spread by a tenth of each.
    fn rows(pairs: &[(&str, &str, f64, f64)]) -> Vec<Vec<String>> {
        let run = |gap: f64, repeat: f64| Run {
            simulated: 100.0 + 10.0 * gap,
            simulated_peak: 300.0,
            simulated_deviation: 10.0,
            quiet: 100.0,
            real: 100.0,
            real_peak: 300.0,
            real_deviation: 10.0,
            last: 100.0,
            path_gap: 1000.0,
            path_repeat: 1000.0 * repeat,
        };
        let of = |&(severity, motion, d, repeat): &(&str, &str, f64, f64)| {
            let robots = [0.9, 1.0, 1.1].map(|part| (part.to_string(), vec![run(d * part, repeat * part); 2]));
            (
                ("undo".to_owned(), [severity, motion].map(str::to_owned)),
                robots.into(),
            )
        };
        let text = table(&pairs.iter().map(of).collect());
        text.lines()
            .skip(1)
            .map(|row| row.split(',').map(str::to_owned).collect())
            .collect()
    }

    #[test]
    fn the_nearest_gap_of_those_that_repeat_is_chosen() {
        let all = rows(&[
            ("0.5", "0.5", 0.2, 0.1),
            ("0.5", "1.0", 0.9, 0.4),
            ("1.0", "1.0", 0.8, 0.49),
            ("2.0", "2.0", 1.5, 0.9),
        ]);
        let chosen: Vec<&str> = all.iter().map(|row| &*row[7]).collect();
        assert_eq!(chosen, ["no", "yes", "no", "no"]);
        let missed: Vec<&str> = all.iter().map(|row| &*row[8]).collect();
        assert_eq!(missed, ["d", "", "", "d repeatability"]);
        // The d of individuals of two equal runs: a divisor of 398 instead of 400.
        let d: f64 = all[1][3].parse().unwrap();
        assert!((d - 0.9 * (398.0_f64 / 396.0).sqrt()).abs() < 1e-5, "{d}");
        let error: f64 = all[1][6].parse().unwrap();
        assert!((error - 0.04 / 3.0_f64.sqrt()).abs() < 1e-6, "{error}");
    }

    #[test]
    fn where_none_repeats_the_one_that_does_best_is_chosen() {
        let all = rows(&[("0.5", "0.5", 0.81, 0.9), ("1.0", "1.0", 0.2, 0.8)]);
        assert_eq!([&*all[0][7], &*all[1][7]], ["no", "yes"]);
        assert_eq!(all[1][8], "d repeatability");
    }
}
