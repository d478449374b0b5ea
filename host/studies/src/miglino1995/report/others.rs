//! Alternatives: other last generations and other simulators.

use std::fmt::Write;

use oneiro_report::numbers::{Digits, NONE, shown, significant};
use oneiro_report::page::{Cell, Head, Row, table};
use oneiro_statistics::{Interval, bootstrap_interval, mean, variance};
use rand_pcg::Pcg64;

use super::evolution::name;
use super::{colours, last_generation, runs_of};
use crate::miglino1995::results::{Condition, Controls, Family, Results, Run, Variant};

/// Significant digits of fitness.
const DIGITS: Digits = Digits::Four;
/// Width and height of a strip of runs, in pixels.
const STRIP: (f64, f64) = (300.0, 18.0);

/// Explanation of the intervals for the reader.
const INTERVAL: &str = "The interval is the bootstrap's of the mean over runs, 95 %; of five runs it is rough itself. \
                        Each dot is a run, the bar the interval, the tick the mean.";

/// Ends of the axis of a strip.
struct Scale(f64, f64);

impl Scale {
    /// An axis around some values, with round ends.
    fn around(values: impl Iterator<Item = f64>) -> Self {
        const ROUND: f64 = 50.0;
        let (low, high) = values
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            });
        if low > high {
            return Self(0.0, ROUND);
        }
        let low = (low / ROUND).floor() * ROUND;
        Self(low, ((high / ROUND).ceil() * ROUND).max(low + ROUND))
    }

    fn words(&self) -> String {
        format!("fitness of runs, from {} to {}", self.0, self.1)
    }

    /// Draws runs as dots on a line, with their mean and its interval.
    fn strip(&self, values: &[f64], colour: &str) -> String {
        let (width, height) = STRIP;
        let middle = height / 2.0;
        let at = |value: f64| significant(6.0 + (width - 12.0) * (value - self.0) / (self.1 - self.0), 4);
        let mut svg = format!(
            "<svg class=\"strip\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">\
             <line x1=\"6\" y1=\"{middle}\" x2=\"{}\" y2=\"{middle}\" stroke=\"#e1e2e6\"/>",
            width - 6.0
        );
        if let Some(Interval { low, high }) = interval(values) {
            let _ = write!(
                svg,
                "<line x1=\"{}\" y1=\"{middle}\" x2=\"{}\" y2=\"{middle}\" stroke=\"{colour}\" stroke-width=\"6\" \
                 stroke-opacity=\"0.3\"/>",
                at(low),
                at(high)
            );
        }
        for &value in values {
            let _ = write!(
                svg,
                "<circle cx=\"{}\" cy=\"{middle}\" r=\"2.6\" fill=\"{colour}\" fill-opacity=\"0.55\"/>",
                at(value)
            );
        }
        let mean = mean(values.iter().copied());
        if mean.is_finite() {
            let x = at(mean);
            let _ = write!(
                svg,
                "<line x1=\"{x}\" y1=\"2\" x2=\"{x}\" y2=\"{}\" stroke=\"{colour}\" stroke-width=\"2\"/>",
                height - 2.0
            );
        }
        svg + "</svg>"
    }
}

/// The 95 % interval of the mean over runs, by a bootstrap with fixed draws; needs two runs or more.
fn interval(values: &[f64]) -> Option<Interval> {
    const LEVEL: f64 = 0.95;
    const RESAMPLES: usize = 2000;
    if values.len() < 2 {
        return None;
    }
    let mean = |samples: &[Vec<f64>]| mean(samples[0].iter().copied());
    bootstrap_interval(&[values], mean, LEVEL, RESAMPLES, &mut Pcg64::new(1995, 0)).ok()
}

/// Cells with a mean, its interval and the runs themselves.
fn cells(values: &[f64], scale: &Scale, colour: &str) -> [Cell; 3] {
    let interval = interval(values).map_or(NONE.to_owned(), |Interval { low, high }| {
        format!("{} to {}", shown(low, Digits::Three), shown(high, Digits::Three))
    });
    [
        Cell::number(shown(mean(values.iter().copied()), DIGITS)),
        Cell::number(interval),
        Cell::html(scale.strip(values, colour)),
    ]
}

/// Real fitness of the last generation next to that of each alternative, by condition; empty if none was run.
pub(super) fn controls(results: &Results) -> String {
    type Figure = fn(&Run) -> Option<f64>;
    fn control(run: &Run, which: fn(&Controls) -> f64) -> Option<f64> {
        run.controls.as_ref().map(which)
    }
    const FIGURES: [Figure; 5] = [
        |run| run.real.first().map(|level| level.average),
        |run| run.real.last().map(|level| level.average),
        |run| control(run, |controls| controls.simulated_on),
        |run| control(run, |controls| controls.neutral),
        |run| control(run, |controls| controls.from_random),
    ];
    if results.runs.iter().all(|run| run.controls.is_none()) {
        return String::new();
    }
    let (first, last) = (results.simulated_generations, last_generation(results));
    let names = [
        format!("generation {first}"),
        format!("generation {last}"),
        format!("generation {last}, had all been simulated"),
        format!("generation {last}, had parents been drawn by lot"),
        format!("{} generations in reality from random genes", results.real_generations),
    ];
    let values = |condition, figure: Figure| -> Vec<f64> { runs_of(results, condition).filter_map(figure).collect() };
    let all = Condition::ALL.map(|condition| FIGURES.map(|figure| values(condition, figure)));
    let scale = Scale::around(all.iter().flatten().flatten().copied());
    let mut rows = Vec::new();
    for (condition, figures) in Condition::ALL.into_iter().zip(&all) {
        for (index, (what, values)) in names.iter().zip(figures).enumerate() {
            let whose = if index == 0 { name(condition) } else { String::new() };
            let mut row = vec![Cell::html(whose), Cell::text(what)];
            row.extend(cells(values, &scale, colours(condition).0));
            rows.push(row.into());
        }
    }
    let runs = scale.words();
    let head = [
        Head::Text("Condition"),
        Head::Text("Mean real fitness of"),
        Head::Number("mean"),
        Head::Number("interval"),
        Head::Text(&runs),
    ];
    let words = format!(
        "What raises real fitness: the last generation as it came about, and as it would have been had selection gone \
         on in simulation, had there been none, and had there been no evolution in simulation. {INTERVAL}"
    );
    format!(
        "<h3>Controls of the generations in reality</h3>\n{}",
        table("", &words, &head, &rows)
    )
}

/// Other simulators by family; empty if none was run.
pub(super) fn variants(results: &Results) -> String {
    const COLOUR: &str = "#4a4d57";
    const FAMILIES: [(Family, &str); 4] = [
        (Family::SensorRange, "Ranges of sensor noise"),
        (Family::WalkRange, "Ranges of conservative noise"),
        (
            Family::Displacement,
            "What is perceived displaced within 30 mm, by how the displacement changes",
        ),
        (
            Family::Simulator,
            "The simulator's source, without noise in its sensors",
        ),
    ];
    if results.variants.is_empty() {
        return String::new();
    }
    let scale = Scale::around(results.variants.iter().flat_map(|variant| &variant.real).copied());
    let runs = scale.words();
    let head = [
        Head::Text("Simulator"),
        Head::Number("mean, simulated"),
        Head::Number("mean, real"),
        Head::Number("interval"),
        Head::Number("s.d. of runs"),
        Head::Text(&runs),
    ];
    let mut rows = Vec::new();
    for (family, title) in FAMILIES {
        let of_family: Vec<&Variant> = results
            .variants
            .iter()
            .filter(|variant| variant.family == family)
            .collect();
        if of_family.is_empty() {
            continue;
        }
        rows.push(Row {
            cells: vec![Cell::across(head.len(), title)],
            sum: true,
        });
        for variant in of_family {
            let [mean_real, interval, strip] = cells(&variant.real, &scale, COLOUR);
            rows.push(
                vec![
                    Cell::text(&variant.name),
                    Cell::number(shown(mean(variant.simulated.iter().copied()), DIGITS)),
                    mean_real,
                    interval,
                    Cell::number(shown(variance(&variant.real).sqrt(), Digits::Three)),
                    strip,
                ]
                .into(),
            );
        }
    }
    let words = format!(
        "Evolution for {} generations in other simulators of the same robot, and fitness of the generation after them \
         there and in reality. Claim C11 is judged by the two families of ranges, no claim by the others. {INTERVAL}",
        results.simulated_generations
    );
    format!("<h3>Other simulators</h3>\n{}", table("", &words, &head, &rows))
}
