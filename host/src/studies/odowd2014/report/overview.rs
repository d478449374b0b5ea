//! All combinations of mutation scale and credit side by side.

use super::measures::{LAST, S0, at_the_end, rate, runs_of, shares, third_of};
use super::{DIGITS, evolving, short_title, title};
use crate::report::figures::escaped;
use crate::report::numbers::{percent, shown};
use crate::report::page::{Cell, Head, Row, Section, paragraph, table};
use crate::statistics::mean;
use crate::studies::odowd2014::results::{Case, Combination, Kind, Results};

/// The overview; `None` unless there are several combinations to compare.
pub(super) fn section(results: &Results) -> Option<Section> {
    if results.combinations.len() < 2 {
        return None;
    }
    let body = [
        paragraph(
            "The paper gives a standard deviation of mutations that does not fit its genes, and credits fitness to a \
             simulator that the controller was not chosen in. So there is no one setting that is the paper's: \
             several were run, and none stands before the others.",
        ),
        rates(results),
        right(results),
    ];
    Some(Section {
        id: "combinations".into(),
        title: "Mutation and credit".into(),
        body: body.concat(),
    })
}

/// A combination with a link to its section.
fn whose(place: usize, combination: &Combination) -> Cell {
    Cell::html(format!(
        "<a href=\"#combination-{}\">{}</a>",
        place + 1,
        escaped(&title(combination))
    ))
}

fn rates(results: &Results) -> String {
    let mut head = vec![Head::Text("Runs")];
    head.extend(Case::ALL.map(|case| Head::Number(short_title(case))));
    let row = |(place, combination): (usize, &Combination)| {
        let rates = Case::ALL.map(|case| {
            let runs = runs_of(combination, case, Kind::Evolved);
            Cell::number(shown(mean(runs.iter().map(|run| rate(run, 0..usize::MAX))), DIGITS))
        });
        Row::from(
            std::iter::once(whose(place, combination))
                .chain(rates)
                .collect::<Vec<_>>(),
        )
    };
    let rows: Vec<Row> = results.combinations.iter().enumerate().map(row).collect();
    table("", "Food per minute of the whole swarm, by case.", &head, &rows)
}

fn right(results: &Results) -> String {
    let mut head = vec![Head::Text("Runs")];
    head.extend(evolving().map(|case| Head::Number(short_title(case))));
    let row = |(place, combination): (usize, &Combination)| {
        let shares = evolving().map(|case| {
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
            std::iter::once(whose(place, combination))
                .chain(shares)
                .collect::<Vec<_>>(),
        )
    };
    let rows: Vec<Row> = results.combinations.iter().enumerate().map(row).collect();
    let words = format!(
        "Share of robots whose simulator has the light where it is, in the last {LAST} minutes, in per cent: as the paper / \
         with fitness shuffled."
    );
    table("", &words, &head, &rows)
}
