//! Figure 5 and its tests: food collected, by case.

use oneiro_base::console::counted;
use oneiro_report::figures::{self, Band, Panel, evenly};
use oneiro_report::numbers::{Digits, probability, shown, spread_words, spreads};
use oneiro_report::page::{Cell, Head, Row, dotted, figure, table};
use oneiro_statistics::{mean, variance};

use super::measures::{BIN, MINUTE, difference, minutes, runs_of};
use super::{colour, moves, named, paper, short_title};
use crate::odowd2014::results::{Case, Combination, Kind, Results, Run};

pub(super) fn html(results: &Results, combination: &Combination) -> String {
    rate_figure(results, combination) + &tests(results, combination)
}

/// Cases that have runs as in the paper.
fn cases(combination: &Combination) -> impl Iterator<Item = (Case, Vec<&Run>)> {
    let runs = |case| (case, runs_of(combination, case, Kind::Evolved));
    Case::ALL.into_iter().map(runs).filter(|(_, runs)| !runs.is_empty())
}

/// Figure 5.
fn rate_figure(results: &Results, combination: &Combination) -> String {
    let cases: Vec<(Case, Vec<&Run>)> = cases(combination).collect();
    let bands: Vec<Band<'_>> = cases
        .iter()
        .map(|(case, runs)| {
            let rows: Vec<Vec<f64>> = runs.iter().map(|run| run.rates(BIN)).collect();
            Band {
                label: short_title(*case),
                colour: colour(*case),
                dash: if *case == Case::Random { "6 4" } else { "" },
                values: evenly(0.5 * BIN as f64, BIN as f64, spreads(rows.iter().map(Vec::as_slice))),
            }
        })
        .collect();
    let highs = bands
        .iter()
        .flat_map(|band| &band.values)
        .map(|(_, spread)| spread.high);
    let high = highs.filter(|high| high.is_finite()).fold(0.0, f64::max);
    let moved = f64::from(results.light_moves_minute) * MINUTE as f64;
    let svg = figures::bands(
        "Foraging rate",
        &[Panel {
            title: "Foraging rate of the whole swarm",
            across: "time, s",
            up: "items of food per minute",
            from: 0.0,
            to: f64::from(results.minutes) * MINUTE as f64,
            low: 0.0,
            high,
            share: 1.0,
            change: cases.iter().any(|(case, _)| moves(*case)).then_some((
                moved,
                "",
                "the light moves in the cases with an arrow",
            )),
            key: &[],
            grounds: &[],
            bands,
        }],
    );
    let runs = cases.iter().map(|(_, runs)| runs.len()).max().unwrap_or(0);
    let words = format!(
        "Food that the swarm brings to the nest, in bins of {BIN} s, mean of {}; {}. In the paper, all cases except \
         no light differ from random movement, and light over the nest appears to double the rate.",
        counted(runs, "run", "runs"),
        spread_words(runs)
    );
    figure(&named("Figure 5", combination), &words, &svg)
}

/// Table of each case's rate and its difference from that of random movement.
fn tests(results: &Results, combination: &Combination) -> String {
    let (all, half) = (results.minutes as usize, results.light_moves_minute as usize);
    let rates = |runs: &[&Run]| -> Vec<f64> { runs.iter().map(|run| run.rate(0..all)).collect() };
    let control = runs_of(combination, Case::Random, Kind::Evolved);
    let (control_minutes, control_rates) = (minutes(control.iter().copied()), rates(&control));
    let rows: Vec<Row> = cases(combination)
        .map(|(case, runs)| {
            let number = |x| Cell::number(shown(x, Digits::Three));
            let over = |minutes: std::ops::Range<usize>| mean(runs.iter().map(|run| run.rate(minutes.clone())));
            let case_rates = rates(&runs);
            let mut cells = vec![
                Cell::html(dotted(colour(case), short_title(case))),
                number(over(0..all)),
                number(over(0..half)),
                number(over(half..all)),
                number(variance(&case_rates).sqrt()),
            ];
            if case == Case::Random {
                cells.push(Cell::across(6, "the reference for the others"));
                return cells.into();
            }
            cells.push(number(
                mean(case_rates.iter().copied()) / mean(control_rates.iter().copied()),
            ));
            for (values, control) in [
                (&minutes(runs.iter().copied()), &control_minutes),
                (&case_rates, &control_rates),
            ] {
                let difference = difference(values, control);
                cells.push(number(difference.d));
                cells.push(Cell::number(probability(difference.p)));
            }
            cells.push(Cell::number(format!(
                "<span class=\"paper\">{}</span>",
                figures::escaped(paper::test(case))
            )));
            cells.into()
        })
        .collect();
    let first = format!("minutes 1 to {}", results.light_moves_minute);
    let second = format!("minutes {} to {}", results.light_moves_minute + 1, results.minutes);
    let by_minutes = format!("d, {} minutes", results.minutes);
    let head = [
        Head::Text("Case"),
        Head::Number("food per minute"),
        Head::Number(&first),
        Head::Number(&second),
        Head::Number("s.d. of runs"),
        Head::Number("over random"),
        Head::Number(&by_minutes),
        Head::Number("p"),
        Head::Number("d, runs"),
        Head::Number("p"),
        Head::Number("p, paper"),
    ];
    let words = format!(
        "Food per minute of the whole swarm, and Student's tests against Random Movement: the paper's, whose samples are the {} \
         minutes, each the mean of all runs, and the one whose samples are runs, which unlike minutes are independent.",
        results.minutes
    );
    table(&named("Rates", combination), &words, &head, &rows)
}
