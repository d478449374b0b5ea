//! All combinations of mutation scale and credit side by side.

use oneiro_report::numbers::{percent, shown};
use oneiro_report::page::{Cell, Head, Row, table};
use oneiro_statistics::mean;

use super::measures::{LAST, S0, at_the_end, per_minute, runs_of, shares, third_of};
use super::{DIGITS, evolving_cases, short_title, title};
use crate::odowd2014::results::{Case, Combination, Kind, Results};

/// Food per minute by case; empty unless there are several combinations to compare.
pub(super) fn rates(results: &Results) -> String {
    if results.combinations.len() < 2 {
        return String::new();
    }
    let mut head = vec![Head::Text("Mutations and credit")];
    head.extend(Case::ALL.map(|case| Head::Number(short_title(case))));
    let row = |combination: &Combination| {
        let rates = Case::ALL.map(|case| {
            let runs = runs_of(combination, case, Kind::Evolved);
            Cell::number(shown(mean(runs.iter().map(|run| per_minute(&run.brought))), DIGITS))
        });
        Row::from(
            std::iter::once(Cell::text(&title(combination)))
                .chain(rates)
                .collect::<Vec<_>>(),
        )
    };
    let rows: Vec<Row> = results.combinations.iter().map(row).collect();
    table(
        "",
        "Items of food per minute of the whole swarm by case, mean of runs.",
        &head,
        &rows,
    )
}

/// Right simulators by case; empty unless there are several combinations.
pub(super) fn right(results: &Results) -> String {
    if results.combinations.len() < 2 {
        return String::new();
    }
    let mut head = vec![Head::Text("Mutations and credit")];
    head.extend(evolving_cases().map(|case| Head::Number(short_title(case))));
    let row = |combination: &Combination| {
        let shares = evolving_cases().map(|case| {
            let [_, light] = case.lights();
            let of = |kind| {
                let runs = runs_of(combination, case, kind);
                percent(mean(
                    runs.iter().map(|run| shares(at_the_end(run), S0)[third_of(light)]),
                ))
            };
            Cell::number(format!("{} / {}", of(Kind::Evolved), of(Kind::FitnessShuffled)))
        });
        Row::from(
            std::iter::once(Cell::text(&title(combination)))
                .chain(shares)
                .collect::<Vec<_>>(),
        )
    };
    let rows: Vec<Row> = results.combinations.iter().map(row).collect();
    let words = format!(
        "Percentage of robots whose simulator has the light where it is, in the last {LAST} minutes, mean of runs: \
         evolved / with fitness shuffled among the robots."
    );
    table("", &words, &head, &rows)
}
