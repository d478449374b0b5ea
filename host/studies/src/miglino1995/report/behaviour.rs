//! Figures 9 to 12: the behaviour of the best individuals in both environments, and the distance between their paths.

use oneiro_base::console::counted;
use oneiro_report::figures::{self, Band, Journey, Panel, Spread, evenly};
use oneiro_report::numbers::{Digits, NONE, percent, shown, spread_words, spreads};
use oneiro_report::page::{Cell, Head, Row, figure, paragraph, table};
use oneiro_statistics::mean;

use super::evolution::name;
use super::{Report, colours, episode_seconds, paper, run_name, runs_of};
use crate::miglino1995::results::{Condition, Discrepancy, MeasuredEpisode, Results, Run};

/// Runs shown individually: the paper's five.
const SHOWN: usize = 5;
/// Cycles between two compared positions (equation 2), and the number of them in the paper's figure.
const EVERY: f64 = 5.0;
const POSITIONS: usize = 100;
const DIGITS: Digits = Digits::Four;
/// Dash patterns of lines.
const REPEATED: &str = "1.5 4";
const UNRELATED: &str = "9 5";

/// Figures 9 to 12, and a table of the best individuals' episodes.
pub(super) fn html(study: &Report<'_>) -> String {
    let by_mean = study.results.runs.iter().any(|run| run.champion.mean.is_some());
    let chosen_by = if by_mean {
        "mean of many simulated episodes"
    } else {
        "single simulated episode"
    };
    let mut body = paragraph(&format!(
        "The best individual of each run is the one with the best {} of generation {}. It runs from the start that \
         all share, {} s in simulation and {} s in reality.",
        chosen_by,
        study.results.simulated_generations,
        shown(episode_seconds(study.results), DIGITS),
        shown(episode_seconds(study.results), DIGITS),
    ));
    if study.results.is_wired {
        body.push_str(&paragraph(
            "A person put the robot at that start. Its real path is from its odometers, or from the tracker if there \
             was one. Collisions are not recorded.",
        ));
    }
    for condition in Condition::ALL {
        body.push_str(&trajectories(study, condition));
    }
    body + &discrepancies(study.results) + &champions(study.results)
}

/// Figure 9, 10 or 11.
fn trajectories(study: &Report<'_>, condition: Condition) -> String {
    let pairs: Vec<Journey<'_>> = runs_of(study.results, condition)
        .take(SHOWN)
        .map(|run| Journey {
            label: run_name(run.number),
            simulated: &run.champion.simulated.path,
            real: &run.champion.real.path,
        })
        .collect();
    let runs = runs_of(study.results, condition).count();
    let which = if runs > pairs.len() {
        format!("the first {} of {runs} runs", pairs.len())
    } else {
        counted(runs, "run", "runs")
    };
    let (number, says) = paper::printed_figures(condition).trajectories;
    let words = format!(
        "Paths of the best individuals evolved with {}, simulated (dashed) and real (full); {which}. In the paper, \
         {says}.",
        condition.title()
    );
    let title = format!("Simulated and real paths: {}", condition.title());
    let svg = figures::journeys(study.arena, study.body_radius, &title, colours(condition).0, &pairs);
    figure(&format!("Figure {number}"), &words, &svg)
}

/// Spread of a condition's sums of distances.
fn sums(results: &Results, condition: Condition, of: fn(&Discrepancy) -> &[f64]) -> Vec<Spread> {
    let rows = runs_of(results, condition).map(|run| of(&run.champion.discrepancy));
    let mut sums = spreads(rows);
    sums.truncate(POSITIONS);
    sums
}

/// Figure 12, and its final values as numbers.
fn discrepancies(results: &Results) -> String {
    let lines = |dash: &'static str, of: fn(&Discrepancy) -> &[f64]| {
        Condition::ALL.map(|condition| {
            let sums = sums(results, condition, of);
            let (label, values) = if dash.is_empty() {
                (short_title(condition), sums)
            } else {
                ("", sums.into_iter().map(without_spread).collect())
            };
            Band {
                label,
                colour: colours(condition).0,
                dash,
                values: evenly(EVERY, EVERY, values),
            }
        })
    };
    let single = Vec::from(lines("", |sums| &sums.paper));
    let starts: Vec<Band<'_>> = [
        lines("", |sums| &sums.starts),
        lines(REPEATED, |sums| &sums.repeated),
        lines(UNRELATED, |sums| &sums.unrelated),
    ]
    .into_iter()
    .flatten()
    .collect();
    let highs = single
        .iter()
        .chain(&starts)
        .flat_map(|band| &band.values)
        .map(|(_, spread)| spread.high);
    let high = highs.filter(|high| high.is_finite()).fold(0.0, f64::max);
    let panel = |title, bands, key| Panel {
        title,
        across: "cycle of 100 ms",
        up: "D, mm",
        from: 0.0,
        to: EVERY * POSITIONS as f64,
        low: 0.0,
        high,
        share: 0.5,
        change: None,
        key,
        grounds: &[],
        bands,
    };
    let mut panels = vec![panel("From one start, as in the paper", single, &[])];
    if !results.is_wired {
        let key = &[
            (REPEATED, "two real episodes"),
            (UNRELATED, "episodes of two different individuals"),
        ];
        panels.push(panel("From 100 starts", starts, key));
    }
    let svg = figures::bands("Discrepancy of simulated and real behaviour", &panels);
    let runs = Condition::ALL
        .map(|condition| runs_of(results, condition).count())
        .into_iter()
        .max()
        .unwrap_or(0);
    let beside = if results.is_wired {
        ""
    } else {
        " Next to it, which the paper lacks: the mean of 100 starts, and D of two real episodes from one start and of \
         two unrelated individuals."
    };
    let words = format!(
        "Discrepancy D of simulated and real paths, the sum of their distances every {EVERY} cycles (equation 2), mean \
         of the best individuals of {} a condition; {}.{beside} In the paper, conservative noise reduces D very much.",
        counted(runs, "run", "runs"),
        spread_words(runs)
    );
    let head = [
        Head::Text("Condition"),
        Head::Number("single start"),
        Head::Number("lowest and highest run"),
        Head::Number("100 starts"),
        Head::Number("two real episodes"),
        Head::Number("two individuals"),
        Head::Number("100 starts, per mm of path"),
    ];
    let rows: Vec<Row> = Condition::ALL
        .into_iter()
        .map(|condition| ends(results, condition))
        .collect();
    let caption = "The end of Figure 12, D in mm. D per mm of path is a ratio of sums over all episodes.";
    figure("Figure 12", &words, &svg) + &table("", caption, &head, &rows)
}

fn ends(results: &Results, condition: Condition) -> Row {
    let end = |of: fn(&Discrepancy) -> &[f64]| -> Vec<f64> {
        let last = |run: &Run| {
            let sums = of(&run.champion.discrepancy);
            sums[..sums.len().min(POSITIONS)].last().copied()
        };
        runs_of(results, condition).filter_map(last).collect()
    };
    let number = |x| Cell::number(shown(x, DIGITS));
    let single = end(|sums| &sums.paper);
    let low = single.iter().copied().fold(f64::NAN, f64::min);
    let high = single.iter().copied().fold(f64::NAN, f64::max);
    vec![
        Cell::html(name(condition)),
        number(mean(single)),
        Cell::number(format!("{} to {}", shown(low, DIGITS), shown(high, DIGITS))),
        number(mean(end(|sums| &sums.starts))),
        number(mean(end(|sums| &sums.repeated))),
        number(mean(end(|sums| &sums.unrelated))),
        number(Discrepancy::per_length(
            runs_of(results, condition).map(|run| &run.champion.discrepancy),
        )),
    ]
    .into()
}

/// The mean without its spread, for reference lines.
fn without_spread(Spread { mean, .. }: Spread) -> Spread {
    Spread {
        low: mean,
        mean,
        high: mean,
    }
}

/// Title that is short enough for the end of a line.
fn short_title(condition: Condition) -> &'static str {
    match condition {
        Condition::None => "no noise",
        Condition::Sensor => "sensor",
        Condition::Conservative => "conservative",
    }
}

/// Table of the best individuals' episodes.
fn champions(results: &Results) -> String {
    let head = [
        Head::Text("Run"),
        Head::Pair("fitness"),
        Head::Pair("both wheels forwards, %"),
        Head::Pair("cells visited, %"),
        Head::Pair("cycles collided, %"),
        Head::Pair("speed, 0 to 1"),
        Head::Pair("path, mm"),
        Head::Pair("stuck in a corner, %"),
    ];
    let mut rows = Vec::new();
    for condition in Condition::ALL {
        let runs: Vec<&Run> = runs_of(results, condition).collect();
        if runs.is_empty() {
            continue;
        }
        rows.push(Row {
            cells: cells(format!("{}, mean of {}", name(condition), runs.len()), &runs),
            sum: true,
        });
        for run in runs.iter().take(SHOWN) {
            rows.push(cells(run_name(run.number), std::slice::from_ref(run)).into());
        }
    }
    let words = "The best individuals' episodes from the start that all share. Cells are the arena's free squares of \
                 50 mm; a cycle that ends in a collision scores nothing; stuck in a corner: the last 100 cycles spent \
                 there, with less than 50 mm gone.";
    format!(
        "<h3>Behaviour of the best individuals</h3>\n{}",
        table("", words, &head, &rows)
    )
}

/// Means over some runs of the measures of simulated and real episodes, after a name as HTML.
fn cells(name: String, runs: &[&Run]) -> Vec<Cell> {
    type Measure = (fn(&MeasuredEpisode) -> f64, fn(f64) -> String);
    const MEASURES: [Measure; 7] = [
        (|episode| f64::from(episode.fitness), |x| shown(x, DIGITS)),
        (|episode| episode.forwards, percent),
        (|episode| episode.visited, percent),
        (|episode| episode.collided, percent),
        (|episode| episode.speed, |x| shown(x, Digits::Three)),
        (|episode| episode.length, |x| shown(x, DIGITS)),
        (|episode| f64::from(u8::from(episode.stuck_in_corner)), percent),
    ];
    const ENVIRONMENTS: [fn(&Run) -> &MeasuredEpisode; 2] = [|run| &run.champion.simulated, |run| &run.champion.real];
    let mut cells = vec![Cell::html(name)];
    for (measure, words) in MEASURES {
        for episode in ENVIRONMENTS {
            let value = mean(runs.iter().map(|run| measure(episode(run))));
            cells.push(Cell::number(if value.is_nan() {
                NONE.to_owned()
            } else {
                words(value)
            }));
        }
    }
    cells
}
