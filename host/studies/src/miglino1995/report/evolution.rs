//! Figures 6 to 8 and Tables 1 and 2: fitness over the generations, at the transfer and after it.

use oneiro_base::console::counted;
use oneiro_report::figures::{self, Band, Panel, Spread, evenly};
use oneiro_report::numbers::{Digits, NONE, probability, shown, spread_words, spreads};
use oneiro_report::page::{Cell, Head, Row, dotted, figure, paragraph, table};
use oneiro_statistics::mean;

use super::verdicts::degrees_of_freedom;
use super::{Report, colours, last_generation, paper, runs_of};
use crate::claims::Test;
use crate::miglino1995::results::{Condition, Level, Results, Run};

/// Generations before the transfer that are shown again, enlarged.
const NEAR: f64 = 10.0;
/// Significant digits of mean fitness and of F.
const DIGITS: Digits = Digits::Four;

/// Figures 6 to 8 and Table 1.
pub(super) fn html(study: &Report<'_>) -> String {
    let results = study.results;
    let mut body = paragraph(&format!(
        "The peak is the mean of the best {} individuals of a generation, the average that of all {}, ranked in the \
         environment where they ran. Generation {} runs in both environments.",
        results.parents, results.population, results.simulated_generations
    ));
    let curves = Condition::ALL.map(|condition| Curves::of(results, condition));
    let high = curves.iter().flat_map(Curves::highs).fold(0.0, f64::max);
    for (condition, curves) in Condition::ALL.into_iter().zip(curves) {
        body.push_str(&generations(results, condition, curves, high));
    }
    body + &first_table(study)
}

/// Means and spreads of a condition's runs, generation by generation.
struct Curves {
    /// Simulated and real.
    peak: [Vec<Spread>; 2],
    average: [Vec<Spread>; 2],
}

impl Curves {
    fn of(results: &Results, condition: Condition) -> Self {
        let spreads_of = |levels: fn(&Run) -> &[Level], value: fn(&Level) -> f64| {
            let rows: Vec<Vec<f64>> = runs_of(results, condition)
                .map(|run| levels(run).iter().map(value).collect())
                .collect();
            spreads(rows.iter().map(Vec::as_slice))
        };
        let both = |value| {
            [
                spreads_of(|run| &run.simulated, value),
                spreads_of(|run| &run.real, value),
            ]
        };
        Self {
            peak: both(|level| level.peak),
            average: both(|level| level.average),
        }
    }

    fn highs(&self) -> impl Iterator<Item = f64> {
        let all = self.peak.iter().chain(&self.average).flatten();
        all.map(|spread| spread.high).filter(|high| high.is_finite())
    }
}

/// Figure 6, 7 or 8.
fn generations(results: &Results, condition: Condition, curves: Curves, high: f64) -> String {
    let (full, light) = colours(condition);
    let (transfer, end) = (
        f64::from(results.simulated_generations),
        f64::from(last_generation(results)),
    );
    let Curves { peak, average } = curves;
    let bands = |named: bool| {
        let mut bands = Vec::new();
        for (label, colour, [simulated, real]) in [("average", light, &average), ("peak", full, &peak)] {
            let band = |first, values: &Vec<Spread>, label| Band {
                label,
                colour,
                dash: "",
                values: evenly(first, 1.0, values.iter().copied()),
            };
            // The name appears once, where the line ends.
            let (middle, last) = match (named, real.is_empty()) {
                (false, _) => ("", ""),
                (true, true) => (label, ""),
                (true, false) => ("", label),
            };
            bands.push(band(0.0, simulated, middle));
            bands.push(band(transfer, real, last));
        }
        bands
    };
    let titles = ["all generations", "around the transfer"].map(|which| format!("{}: {which}", condition.title()));
    let panel = |title, from, share, named| Panel {
        title,
        across: "generation",
        up: "fitness, 0 to 500",
        from,
        to: end,
        low: 0.0,
        high,
        share,
        change: Some((transfer, "simulation", "reality")),
        key: &[],
        grounds: &[],
        bands: bands(named),
    };
    let svg = figures::bands(
        &format!("Fitness through generations: {}", condition.title()),
        &[
            panel(&titles[0], 0.0, 0.6, false),
            panel(&titles[1], (transfer - NEAR).max(0.0), 0.4, true),
        ],
    );
    let (number, says) = paper::printed_figures(condition).generations;
    let runs = runs_of(results, condition).count();
    let words = format!(
        "Peak and average fitness with {}, mean of {}; {}. The first {} generations are selected by simulated \
         fitness, the last {} by real fitness. In the paper, {says}.",
        condition.title(),
        counted(runs, "run", "runs"),
        spread_words(runs),
        results.simulated_generations,
        results.real_generations,
    );
    figure(&format!("Figure {number}"), &words, &svg)
}

/// The test of a claim that corresponds to the paper's tables: see [`Report::claims`].
fn papers_test<'a>(study: &Report<'a>, claim: &str, condition: Condition) -> Option<&'a Test> {
    let claim = study.claims.iter().find(|one| one.id == claim)?;
    claim
        .tests
        .iter()
        .find(|test| test.statistic == "F" && test.name.starts_with(condition.title()))
}

/// Table 1: simulation against reality in the transferred generation.
fn first_table(study: &Report<'_>) -> String {
    let individuals = |condition, episodes: fn(&Run) -> &[f32]| mean_of(study.results, condition, episodes);
    let rows: Vec<Row> = Condition::ALL
        .into_iter()
        .map(|condition| {
            let means = [
                individuals(condition, |run| &run.transferred.simulated),
                individuals(condition, |run| &run.transferred.real),
            ];
            row(
                condition,
                means,
                papers_test(study, "C3", condition),
                paper::printed_figures(condition).gap,
            )
        })
        .collect();
    let words = format!(
        "Analysis of variance between simulated (with the noise of the condition) and real fitness of all individuals of generation \
         {}, as the paper has it: it counts relatives as independent. Claim C3 has the tests that do not, and those \
         with noise off in both environments. Individuals in each environment: {}.",
        study.results.simulated_generations,
        sizes(study.results),
    );
    table("Table 1", &words, &head("mean, simulated", "mean, real"), &rows)
}

/// Table 2: the transferred generation against the last one, both in reality.
pub(super) fn second_table(study: &Report<'_>) -> String {
    let results = study.results;
    let rows: Vec<Row> = Condition::ALL
        .into_iter()
        .map(|condition| {
            let means = [
                mean_of(results, condition, |run| &run.transferred.real),
                mean_of(results, condition, |run| &run.last),
            ];
            let test = papers_test(study, "C6", condition);
            row(condition, means, test, paper::printed_figures(condition).recovery)
        })
        .collect();
    let words = format!(
        "Analysis of variance between the real fitness of all individuals of generation {} and of generation {}, as \
         the paper has it; tests that do not count relatives as independent stand at claim C6. Individuals of each \
         generation: {}.",
        results.simulated_generations,
        last_generation(results),
        sizes(results),
    );
    table(
        "Table 2",
        &words,
        &head("mean, at the transfer", "mean, at the end"),
        &rows,
    )
}

fn head<'a>(before: &'a str, after: &'a str) -> [Head<'a>; 9] {
    [
        Head::Text("Condition"),
        Head::Number(before),
        Head::Number(after),
        Head::Number("d.f."),
        Head::Number("F"),
        Head::Number("p"),
        Head::Text("Remark, at .01"),
        Head::Number("F, paper"),
        Head::Text("Remark, paper"),
    ]
}

fn row(condition: Condition, means: [f64; 2], test: Option<&Test>, (papers, papers_significant): (f64, bool)) -> Row {
    let or_none = |cell: fn(&Test) -> String| test.map_or(NONE.to_owned(), cell);
    vec![
        Cell::html(name(condition)),
        Cell::number(shown(means[0], DIGITS)),
        Cell::number(shown(means[1], DIGITS)),
        Cell::number(or_none(degrees_of_freedom)),
        Cell::number(or_none(|test| shown(test.value, DIGITS))),
        Cell::number(or_none(|test| probability(test.p))),
        Cell::text(test.map_or("not tested", |test| remark(test.p < paper::LEVEL))),
        Cell::number(format!(
            "<span class=\"paper\">{}</span><br/><span class=\"small\">{}</span>",
            // As printed.
            papers,
            paper::DEGREES_OF_FREEDOM
        )),
        Cell::html(format!("<span class=\"paper\">{}</span>", remark(papers_significant))),
    ]
    .into()
}

fn remark(significant: bool) -> &'static str {
    if significant {
        "significant effect"
    } else {
        "no significant effect"
    }
}

/// A condition's name in its colour.
pub(super) fn name(condition: Condition) -> String {
    dotted(colours(condition).0, condition.title())
}

/// Numbers of individuals by condition.
fn sizes(results: &Results) -> String {
    let size = |condition: Condition| {
        let individuals: usize = runs_of(results, condition).map(|run| run.transferred.real.len()).sum();
        format!("{individuals} with {}", condition.title())
    };
    Condition::ALL.map(size).join(", ")
}

/// Mean over all individuals of a condition.
fn mean_of(results: &Results, condition: Condition, episodes: fn(&Run) -> &[f32]) -> f64 {
    mean(
        runs_of(results, condition)
            .flat_map(episodes)
            .map(|&fitness| f64::from(fitness)),
    )
}
