//! Figures 6 to 10: the evolution of simulators and controllers by case, and their final genes.

use oneiro_base::console::counted;
use oneiro_report::figures::{self, Band, Ground, Panel, Spread, evenly};
use oneiro_report::numbers::{percent, probability, shown};
use oneiro_report::page::{Cell, Head, Row, figure, table};
use oneiro_statistics::mean;

use super::measures::{G0, G1, Gene, LAST, S0, alone, at_the_end, difference, level, levels, robots_at, runs_of};
use super::measures::{intervals, shares, third_of};
use super::{DIGITS, case_name, colour, evolving_cases, kind_name, moves, named, other_kinds, paper};
use crate::odowd2014::results::{Case, Combination, Kind, Results, Run};

/// Names of the thirds of `S0`, `G0` and `G1`, their line colours and their background colours.
const SCENARIOS: [&str; 3] = ["opposite nest", "no light", "over nest"];
const BEHAVIOURS: [&str; 3] = ["flees light", "random search", "seeks light"];
const COLOURS: [&str; 3] = ["#2b3a8f", "#6b6e76", "#b87700"];
const GROUNDS: [&str; 3] = ["#e8ebf6", "#f3f3f1", "#fbf1d8"];
/// Borders of the thirds.
const BORDERS: [f64; 4] = [0.0, 0.33, 0.66, 1.0];
/// Dash pattern of lines without selection.
const NULL: &str = "5 4";

/// Figures 6 to 8, of lights that stay, and the final genes of all cases.
pub(super) fn fixed_lights(results: &Results, combination: &Combination) -> String {
    figures_of(results, combination, false) + &simulators(combination) + &controllers(combination)
}

/// Figures 9 and 10, of lights that move.
pub(super) fn moving_lights(results: &Results, combination: &Combination) -> String {
    figures_of(results, combination, true)
}

fn figures_of(results: &Results, combination: &Combination, moving: bool) -> String {
    let cases = evolving_cases().filter(|&case| moves(case) == moving);
    cases.map(|case| evolution(results, combination, case)).collect()
}

fn thirds(labels: [&'static str; 3]) -> [Ground<'static>; 3] {
    [0, 1, 2].map(|third| Ground {
        low: BORDERS[third],
        high: BORDERS[third + 1],
        label: labels[third],
        colour: GROUNDS[third],
    })
}

/// Figure 6, 7, 8, 9 or 10; empty if the case was not run.
fn evolution(results: &Results, combination: &Combination, case: Case) -> String {
    let runs = runs_of(combination, case, Kind::Evolved);
    let null = runs_of(combination, case, Kind::FitnessShuffled);
    let Some((number, says)) = paper::genes(case) else {
        return String::new();
    };
    if runs.is_empty() {
        return String::new();
    }
    let (scenarios, behaviours) = (thirds(SCENARIOS), thirds(BEHAVIOURS));
    let band = |label, colour, dash, values| Band {
        label,
        colour,
        dash,
        // The value for a robot's first minute is drawn at the middle of that minute.
        values: evenly(0.5, 1.0, values),
    };
    let panel = |title, up, grounds, bands| Panel {
        title,
        across: "time, minutes",
        up,
        from: 0.0,
        to: f64::from(results.minutes),
        low: 0.0,
        high: 1.0,
        share: 0.5,
        change: moves(case).then_some((f64::from(results.light_moves_minute), "", "the light moves")),
        key: &[],
        grounds,
        bands,
    };
    let of_gene = |gene: Gene| {
        let mut bands = vec![band("", colour(case), "", levels(&runs, gene))];
        if !null.is_empty() {
            let means = levels(&null, gene).into_iter().map(|spread| alone(spread.mean));
            bands.push(band("", colour(case), NULL, means.collect()));
        }
        bands
    };
    let mut of_thirds = Vec::new();
    for third in 0..3 {
        of_thirds.push(band(SCENARIOS[third], COLOURS[third], "", share_of(&runs, third)));
        of_thirds.push(band("", COLOURS[third], NULL, share_of(&null, third)));
    }
    let svg = figures::grid(
        &format!("Genes through time: {}", case.title()),
        &[
            &[
                panel(
                    "S0: the light in the simulator",
                    "gene S0, 0 to 0.99",
                    &scenarios,
                    of_gene(S0),
                ),
                panel(
                    "Fraction of simulators with each light",
                    "fraction of robots, 0 to 1",
                    &[],
                    of_thirds,
                ),
            ],
            &[
                panel("G0: with food", "gene G0, 0 to 0.99", &behaviours, of_gene(G0)),
                panel("G1: without food", "gene G1, 0 to 0.99", &behaviours, of_gene(G1)),
            ],
        ],
    );
    let dashed = if null.is_empty() {
        String::new()
    } else {
        format!(
            " Dashed: the mean and the fractions of {} with real fitness shuffled among the robots, which prevents \
             adaptation.",
            counted(null.len(), "run", "runs")
        )
    };
    let words = format!(
        "{}: mean of all robots of {}; shaded: one standard deviation to both sides, as far as genes go. The \
         background shows what values select.{dashed} In the paper, {says}.",
        case.title(),
        counted(runs.len(), "run", "runs")
    );
    figure(&named(&format!("Figure {number}"), combination), &words, &svg)
}

/// Fraction of robots by interval whose simulator has its gene in a third.
fn share_of(runs: &[&Run], third: usize) -> Vec<Spread> {
    let at = |interval| alone(shares(robots_at(runs, interval), S0)[third]);
    (0..intervals(runs)).map(at).collect()
}

/// The same fraction at the end of each run.
fn ends(runs: &[&Run], third: usize) -> Vec<f64> {
    runs.iter().map(|run| shares(at_the_end(run), S0)[third]).collect()
}

/// Table of final simulators, in runs of each kind.
fn simulators(combination: &Combination) -> String {
    let head = [
        Head::Text("Case"),
        Head::Text("Runs"),
        Head::Number("of them"),
        Head::Number("opposite, %"),
        Head::Number("no light, %"),
        Head::Number("over, %"),
        Head::Number("right, %"),
        Head::Number("d against fitness shuffled"),
        Head::Number("p"),
    ];
    let mut rows = Vec::new();
    for case in evolving_cases() {
        let [_, light] = case.lights();
        let right = third_of(light);
        let null = ends(&runs_of(combination, case, Kind::FitnessShuffled), right);
        let mut whose = case_name(case);
        for kind in std::iter::once(Kind::Evolved).chain(other_kinds(combination)) {
            let runs = runs_of(combination, case, kind);
            if runs.is_empty() {
                continue;
            }
            let mut cells = vec![
                Cell::html(std::mem::take(&mut whose)),
                kind_name(kind),
                Cell::number(runs.len().to_string()),
            ];
            cells.extend([0, 1, 2].map(|third| Cell::number(percent(mean(ends(&runs, third))))));
            let fractions = ends(&runs, right);
            cells.push(Cell::number(percent(mean(fractions.iter().copied()))));
            let against = (kind != Kind::FitnessShuffled).then(|| difference(&fractions, &null));
            let number = |x: Option<f64>, words: fn(f64) -> String| Cell::number(words(x.unwrap_or(f64::NAN)));
            cells.push(number(against.as_ref().map(|against| against.d), |d| shown(d, DIGITS)));
            cells.push(number(against.as_ref().map(|against| against.p), probability));
            rows.push(Row::from(cells));
        }
    }
    let words = format!(
        "The light in the simulators in the last {LAST} minutes, percentage of robots, mean of runs. Right: where the \
         light is then. Student's test of runs, of the percentage that is right, against runs with shuffled fitness."
    );
    table(&named("Simulators", combination), &words, &head, &rows)
}

/// Table of final controllers.
fn controllers(combination: &Combination) -> String {
    let head = [
        Head::Text("Case"),
        Head::Text("Gene"),
        Head::Number("mean"),
        Head::Number("s.d."),
        Head::Number("flees light, %"),
        Head::Number("random search, %"),
        Head::Number("seeks light, %"),
        Head::Number("mean, fitness shuffled"),
        Head::Number("s.d., fitness shuffled"),
    ];
    let mut rows = Vec::new();
    for case in evolving_cases() {
        let runs = runs_of(combination, case, Kind::Evolved);
        let null = runs_of(combination, case, Kind::FitnessShuffled);
        if runs.is_empty() {
            continue;
        }
        let mut whose = case_name(case);
        for (gene, words) in [(G0, "G0"), (G1, "G1")] {
            let robots = |runs: &[&Run]| level(runs.iter().flat_map(|run| at_the_end(run)), gene);
            let ((middle, deviation), (null_middle, null_deviation)) = (robots(&runs), robots(&null));
            let number = |x| Cell::number(shown(x, DIGITS));
            let mut cells = vec![
                Cell::html(std::mem::take(&mut whose)),
                Cell::text(words),
                number(middle),
                number(deviation),
            ];
            let shares = shares(runs.iter().flat_map(|run| at_the_end(run)), gene);
            cells.extend(shares.map(|share| Cell::number(percent(share))));
            cells.extend([number(null_middle), number(null_deviation)]);
            rows.push(Row::from(cells));
        }
    }
    let words = format!(
        "The genes of the controllers that act in the last {LAST} minutes, G0 with food and G1 without it, over all \
         robots and runs. With a narrow spread, robots agree."
    );
    table(&named("Controllers", combination), &words, &head, &rows)
}
