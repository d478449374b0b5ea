//! A picture for each factor: the curves of its levels, and their outcomes.

use oneiro_report::figures::{Band, Column, Outcomes, Panel, Scale, factor, level_styles};
use oneiro_report::numbers::count;
use oneiro_report::page::figure;
use oneiro_statistics::quantile_of_sorted;

use super::curves::{Curves, Line};
use super::levels::{Factor, Group, Kind};
use super::runs::Runs;
use super::sample::Sample;
use super::{Compared, Tables};

/// Maximum number of runs drawn as points; the outcomes of more are drawn as boxes.
const MOST_POINTS: usize = 600;
/// Maximum number of lines and columns in a picture of levels without an order, which can't be grouped in bins.
const MOST_LINES: usize = 10;
pub(super) const MOST_COLUMNS: usize = 40;
/// Ratio of the maximum to the minimum level from which a logarithmic axis is considered.
const RATIO: f64 = 10.0;
/// Maximum number of letters of a level's name in a picture.
const LETTERS: usize = 24;

/// Draws the lines over time and the outcomes for the levels of one factor.
pub(super) fn picture(tables: &Tables<'_>, runs: &Runs, curves: &[Curves], samples: &[Sample], place: usize) -> String {
    let own = &runs.factors[place];
    let styles = level_styles(own.groups.len(), own.is_ordered());
    let labels: Vec<String> = own.groups.iter().map(|group| clipped(&group.label)).collect();
    let of_lines = best(samples, MOST_LINES);
    let by = format!("By {}", own.name);
    let panels = curves.iter().map(|curves| {
        let line = |&group: &usize| Drawn {
            label: &labels[group],
            style: &styles[group],
            line: &curves.groups[place][group],
        };
        panel(&by, curves, &of_lines.iter().map(line).collect::<Vec<_>>())
    });
    let panels: Vec<Panel<'_>> = panels.collect();
    let scale = scale(own);
    let drawn = Marks::of(tables, samples.iter().map(|sample| sample.values.len()).sum());
    let of_columns = best(samples, MOST_COLUMNS);
    let mut columns: Vec<Column<'_>> = Vec::new();
    for (group, x) in of_columns.iter().copied().zip(0_u32..) {
        let Group { first, last, .. } = own.groups[group];
        let ends = if scale == Scale::Names {
            [x.into(); 2]
        } else {
            [first, last].map(|level| own.levels[level].value)
        };
        columns.push(column(&labels[group], &styles[group].0, ends, &samples[group], drawn));
    }
    if own.is_binned() && drawn.points {
        // Within a bin, runs are drawn at their levels.
        for column in &mut columns {
            column.points.clear();
        }
        for run in runs.all.iter().filter(|run| run.outcome.is_finite()) {
            let at = own.levels[run.levels[place] as usize].value;
            columns[runs.group(run, place)].points.push((at, run.outcome));
        }
    }
    let across = if own.kind == Kind::Ranges && own.is_binned() {
        format!("{}, width", own.name)
    } else {
        own.name.clone()
    };
    let svg = factor(
        &format!("{}: how runs went, and what came out", own.name),
        &panels,
        &outcomes(tables, &across, scale, &columns),
    );
    let [unit, units] = own.unit();
    let some = |drawn: usize| {
        if drawn < own.groups.len() {
            format!(" Of {} {units}, the {drawn} with the highest means.", own.groups.len())
        } else {
            String::new()
        }
    };
    let words = format!(
        "{}. Left: {}, mean of the runs of each {unit}; {}.{} Right: {}, {}.{}",
        own.name,
        values(curves),
        band_words(&curves[0]),
        some(of_lines.len()),
        tables.outcome.1,
        drawn.words(),
        some(of_columns.len()),
    );
    figure(&format!("Figure {}", place + 1), &words, &svg)
}

/// Draws all runs together.
pub(super) fn all_runs(tables: &Tables<'_>, runs: &Runs, curves: &[Curves]) -> String {
    let all = runs.outcomes();
    let drawn = Marks::of(tables, all.values.len());
    let style = (level_styles(1, false)[0].0.clone(), "");
    let panels = curves.iter().map(|curves| {
        let line = Drawn {
            label: "",
            style: &style,
            line: &curves.all,
        };
        panel("All runs", curves, &[line])
    });
    let panels: Vec<Panel<'_>> = panels.collect();
    let svg = factor(
        "How runs went, and what came out",
        &panels,
        &outcomes(
            tables,
            "",
            Scale::Names,
            &[column("all runs", &style.0, [0.0; 2], &all, drawn)],
        ),
    );
    let words = format!(
        "Left: {}, mean of all runs; {}. Right: {}, {}.",
        values(curves),
        band_words(&curves[0]),
        tables.outcome.1,
        drawn.words(),
    );
    figure("Figure 1", &words, &svg)
}

/// Outcomes of runs whose levels are at one position, or in a range of positions.
fn column<'a>(label: &'a str, colour: &'a str, [from, to]: [f64; 2], sample: &Sample, drawn: Marks) -> Column<'a> {
    let values = sample.values.iter().filter(|_| drawn.points);
    Column {
        label,
        colour,
        from,
        to,
        mean: sample.spread(),
        quartiles: (drawn.boxes && !sample.values.is_empty()).then(|| sample.quartiles()),
        points: values.map(|&value| (from, value)).collect(),
    }
}

fn outcomes<'a>(tables: &Tables<'a>, across: &'a str, scale: Scale, columns: &'a [Column<'a>]) -> Outcomes<'a> {
    Outcomes {
        title: "What came out",
        across,
        up: tables.outcome.1,
        scale,
        columns,
    }
}

/// A line of the left panel.
struct Drawn<'a> {
    label: &'a str,
    /// Colour and dash pattern.
    style: &'a (String, &'static str),
    line: &'a Line,
}

fn panel<'a>(title: &'a str, curves: &'a Curves, lines: &[Drawn<'a>]) -> Panel<'a> {
    let spreads = || lines.iter().flat_map(|drawn| drawn.line).map(|(_, spread)| spread);
    let finite = |value: &f64| value.is_finite();
    let low = spreads()
        .map(|spread| spread.low)
        .filter(finite)
        .fold(f64::INFINITY, f64::min);
    let high = spreads()
        .map(|spread| spread.high)
        .filter(finite)
        .fold(f64::NEG_INFINITY, f64::max);
    let (from, to) = curves.ends();
    let band = |drawn: &Drawn<'a>| Band {
        label: drawn.label,
        colour: &drawn.style.0,
        dash: drawn.style.1,
        values: drawn.line.clone(),
    };
    Panel {
        title,
        across: &curves.across,
        up: &curves.up,
        from,
        to,
        low,
        high,
        bands: lines.iter().map(band).collect(),
        ..Panel::default()
    }
}

/// Indices of the groups with the best means, at most `most`, in ascending order.
pub(super) fn best(samples: &[Sample], most: usize) -> Vec<usize> {
    let mut groups: Vec<usize> = (0..samples.len()).collect();
    if groups.len() > most {
        let means: Vec<f64> = samples.iter().map(Sample::merit).collect();
        groups.sort_by(|&a, &b| means[b].total_cmp(&means[a]));
        groups.truncate(most);
        groups.sort_unstable();
    }
    groups
}

/// Axis for the outcomes of a factor's levels.
fn scale(factor: &Factor) -> Scale {
    match factor.kind {
        Kind::Words => Scale::Names,
        Kind::Ranges if !factor.is_binned() => Scale::Names,
        _ => match (&factor.levels[..], middle(factor)) {
            ([first, .., last], middle) if first.value > 0.0 && last.value >= RATIO * first.value => {
                // Chooses the scale that puts the middle level nearer to the middle.
                let aside = |place: fn(f64) -> f64| {
                    let [low, middle, high] = [first.value, middle, last.value].map(place);
                    ((middle - low) / (high - low) - 0.5).abs()
                };
                if aside(f64::ln) < aside(|x| x) {
                    Scale::Logarithmic
                } else {
                    Scale::Linear
                }
            }
            _ => Scale::Linear,
        },
    }
}

/// The middle level, or the mean of the two in the middle.
fn middle(factor: &Factor) -> f64 {
    let values: Vec<f64> = factor.levels.iter().map(|level| level.value).collect();
    quantile_of_sorted(&values, 0.5)
}

/// Caption for what lines show, by each axis that a reader may choose.
fn values(curves: &[Curves]) -> String {
    let [first, others @ ..] = curves else {
        return String::new();
    };
    let others = others.iter().map(|own| format!(" (or by {}: {})", own.across, own.up));
    first.up.clone() + &others.collect::<String>()
}

/// Caption for lines and their bands.
fn band_words(curves: &Curves) -> String {
    let mut words = vec!["shaded: its 95 % confidence interval by Student\u{2019}s t, from run to run".to_owned()];
    let (most, fewest) = curves.runs;
    if fewest < most {
        let (fewest, most) = (count(fewest.into()), count(most.into()));
        words.push(format!(
            "not every run has every time, so that means are of {fewest} to {most} runs in all"
        ));
    }
    if curves.stride > 1 {
        words.push(format!("one time of {} is drawn", curves.stride));
    }
    words.join("; ")
}

/// How the outcomes of runs are drawn.
#[derive(Clone, Copy)]
struct Marks {
    points: bool,
    boxes: bool,
}

impl Marks {
    /// Those of so many runs.
    fn of(tables: &Tables<'_>, runs: usize) -> Self {
        Self {
            points: runs <= MOST_POINTS,
            boxes: runs > MOST_POINTS || tables.compared == Compared::Conditions,
        }
    }

    /// Caption for the marks of runs and their mean.
    fn words(self) -> String {
        let points = if self.points { "a point a run; " } else { "" };
        let boxes = if self.boxes {
            "boxes: the middle half of the runs with the median, lines to the minimum and the maximum; "
        } else {
            ""
        };
        format!("{points}{boxes}diamonds: means with their 95 % confidence intervals")
    }
}

/// Shortens a name for a picture, keeping the end: that is where paths differ.
fn clipped(label: &str) -> String {
    let letters = label.chars().count();
    if letters <= LETTERS {
        return label.to_owned();
    }
    let end: String = label.chars().skip(letters - LETTERS + 1).collect();
    format!("\u{2026}{end}")
}
