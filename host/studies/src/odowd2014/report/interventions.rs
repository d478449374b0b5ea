//! Usefulness of simulators: foraging rates when they are shuffled, fixed or drawn at random, and of a lone robot.

use oneiro_report::numbers::{probability, shown};
use oneiro_report::page::{Cell, Head, Row, table};
use oneiro_statistics::{mean, variance};

use super::measures::{difference, per_minute, runs_of};
use super::{DIGITS, case_name, kind_name, named, other_kinds};
use crate::odowd2014::results::{Case, Combination, Kind, Run};

/// The table of interventions; empty if there were none.
pub(super) fn html(combination: &Combination) -> String {
    if other_kinds(combination).next().is_none() {
        return String::new();
    }
    let head = [
        Head::Text("Case"),
        Head::Text("Runs"),
        Head::Number("of them"),
        Head::Number("food per minute"),
        Head::Number("s.d. of runs"),
        Head::Number("over as the paper"),
        Head::Number("d"),
        Head::Number("p"),
    ];
    let rates = |runs: &[&Run]| -> Vec<f64> { runs.iter().map(|run| per_minute(&run.brought)).collect() };
    let mut rows = Vec::new();
    for case in Case::ALL {
        let paper = rates(&runs_of(combination, case, Kind::Evolved));
        let mut whose = case_name(case);
        for kind in std::iter::once(Kind::Evolved).chain(other_kinds(combination)) {
            let of_kind = rates(&runs_of(combination, case, kind));
            if of_kind.is_empty() {
                continue;
            }
            let number = |x| Cell::number(shown(x, DIGITS));
            let middle = mean(of_kind.iter().copied());
            let mut cells = vec![
                Cell::html(std::mem::take(&mut whose)),
                kind_name(kind),
                Cell::number(of_kind.len().to_string()),
                number(middle),
                number(variance(&of_kind).sqrt()),
            ];
            if kind == Kind::Evolved {
                cells.push(Cell::across(3, "the reference for the others"));
            } else {
                let against = difference(&of_kind, &paper);
                cells.push(number(middle / mean(paper.iter().copied())));
                cells.push(number(against.d));
                cells.push(Cell::number(probability(against.p)));
            }
            rows.push(Row::from(cells));
        }
    }
    let words = "Food per minute of the whole swarm over all of the time where a part of the evolution was taken away, and \
                 Student's test of runs against those as the paper has it. One robot alone brings what one can; with nobody to \
                 meet, nothing selects its simulators.";
    table(&named("Interventions", combination), words, &head, &rows)
}
