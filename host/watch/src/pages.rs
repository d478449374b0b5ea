//! The parts of the page.

use oneiro_base::console::counted;
use oneiro_report::bundle::bundle;
use oneiro_report::figures::{Band, Panel, escaped, panel};
use oneiro_report::numbers::Spread;
use oneiro_report::page::dark_rules;
use oneiro_statistics::quantile;
use serde_json::json;

use crate::sources::{Run, Source, Sources};
use crate::sweeps::Cells;

pub(crate) const PAGE: &str = include_str!("watch.html");

/// The page's style.
pub(crate) fn style() -> String {
    let colours = COLOURS.iter().chain(&OTHERS).chain([&SOFT]).copied();
    include_str!("watch.css").to_owned() + &dark_rules("#curve ", colours)
}

/// The page's script.
pub(crate) fn script() -> String {
    format!("(() => {{\n'use strict';\n{}}})();\n", bundle("watch"))
}

/// Colours of the lines of one run, in the order of its values; the first is also that of the selected run among others.
const COLOURS: [&str; 3] = ["#d9485f", "#2b3a8f", "#2a9d8f"];
const SOFT: &str = "#74777f";
/// Colours of runs with other settings.
const OTHERS: [&str; 4] = ["#2b3a8f", "#2a9d8f", "#8a3fa0", "#b06f00"];

/// Pages of a directory that are served unchanged.
pub(crate) const FILES: [&str; 4] = ["report.html", "replay.html", "learning.html", "archive.html"];

/// Widths of a curve in pixels, and its height.
const WIDTHS: [u32; 2] = [320, 1600];
const HEIGHT: f64 = 340.0;

/// The learning curve of a run, among those of the same experiment, as wide as the page has room.
pub(crate) fn curve(sources: &Sources, run: &Run, width: u32) -> String {
    let all = sources.group(&run.group);
    let groups = sources.groups(run);
    // The run's own group comes first.
    let others = groups.get(1..).unwrap_or_default();
    let undrawn = others.len().saturating_sub(OTHERS.len());
    let others = &others[..others.len() - undrawn];
    let exactly = |value| Spread {
        low: value,
        mean: value,
        high: value,
    };
    let stride = others
        .iter()
        .flat_map(|(_, runs)| runs)
        .chain(&all)
        .map(|run| run.curve.stride())
        .max();
    let stride = stride.unwrap_or(1);
    let lines = |run: &Run, value: usize| -> Vec<(f64, Spread)> {
        let line = run.curve.line(value, stride);
        line.into_iter().map(|(time, value)| (time, exactly(value))).collect()
    };
    let median = |runs: &[&Run]| match runs {
        [one] => lines(one, 0),
        many => spread(many, stride),
    };
    let experiment = run.saved.experiment();
    let values = run.curve.values();
    let setting = groups.first().map_or("", |(label, _)| label);
    let of_setting = |what: &str| {
        if others.is_empty() {
            what.to_owned()
        } else {
            format!("{setting}, {what}")
        }
    };
    let seed = |run: &Run| of_setting(&format!("seed {}", run.saved.seed()));
    let this = match all.len() {
        1 => format!("this: {setting}"),
        _ => seed(run),
    };
    // A median of two says less than both.
    let rest = match &all[..] {
        [one, other] => {
            let other = if one.saved.seed() == run.saved.seed() {
                other
            } else {
                one
            };
            (seed(other), lines(other, 0))
        }
        many => (of_setting("median"), spread(many, stride)),
    };
    let band = |label, colour, values| Band {
        label,
        colour,
        dash: "",
        values,
    };
    let mut shown: Vec<Band<'_>> = Vec::new();
    if all.len() > 1 {
        shown.push(band(&rest.0, SOFT, rest.1));
        shown.push(band(&this, COLOURS[0], lines(run, 0)));
    } else {
        // With other settings in the chart, only the first value.
        let count = if others.is_empty() { values.len() } else { 1 };
        let label = |value: usize| {
            if others.is_empty() { values[value].label } else { &this }
        };
        shown.extend((0..count).map(|value| band(label(value), COLOURS[value], lines(run, value))));
    }
    for ((label, runs), colour) in others.iter().zip(OTHERS) {
        shown.push(band(label, colour, median(runs)));
    }
    let all_values = || shown.iter().flat_map(|band| &band.values);
    let numbers = |end: fn(&Spread) -> f64| {
        all_values()
            .map(move |(_, spread)| end(spread))
            .filter(|own| own.is_finite())
    };
    let time = experiment.shown().time.1;
    let title = match all.len() {
        1 if others.is_empty() => format!("each {time}"),
        1 => format!("{} of each {time}", values[0].label),
        seeds => format!("{} of each {time}, {seeds} seeds", values[0].label),
    };
    let title = match undrawn {
        0 => title,
        more => format!(
            "{title}; {} not drawn",
            counted(more, "older setting", "older settings")
        ),
    };
    let width = width.clamp(WIDTHS[0], WIDTHS[1]);
    let shown = Panel {
        title: &title,
        across: time,
        up: "fitness",
        to: all_values().map(|(time, _)| *time).fold(1.0, f64::max),
        low: numbers(|own| own.low).fold(f64::INFINITY, f64::min),
        high: numbers(|own| own.high).fold(f64::NEG_INFINITY, f64::max),
        bands: shown,
        ..Panel::default()
    };
    panel(&title, &shown, (width.into(), HEIGHT))
}

/// Median and quartiles of the first value over runs, wherever two or more have one.
fn spread(runs: &[&Run], stride: u32) -> Vec<(f64, Spread)> {
    let lines: Vec<Vec<(f64, f64)>> = runs.iter().map(|run| run.curve.line(0, stride)).collect();
    let longest = lines.iter().max_by_key(|line| line.len());
    let at = |(place, (time, _)): (usize, &(f64, f64))| {
        let own = lines.iter().filter_map(|line| Some(line.get(place)?.1));
        let own: Vec<f64> = own.filter(|own| own.is_finite()).collect();
        let spread = Spread {
            low: quantile(&own, 0.25),
            mean: quantile(&own, 0.5),
            high: quantile(&own, 0.75),
        };
        (own.len() > 1).then_some((*time, spread))
    };
    longest.into_iter().flatten().enumerate().filter_map(at).collect()
}

/// Links to the pages in a source's directory.
pub(crate) fn links(source: &Source) -> String {
    let there = FILES.iter().filter(|name| source.directory.join(name).is_file());
    let link = |name: &&str| {
        format!(
            "<a href=\"file/{}/{name}\" target=\"_blank\" rel=\"noopener\">{name}</a>",
            source.id
        )
    };
    there.map(link).collect::<Vec<_>>().join(" ")
}

/// What is known of all: the cells of sweeps, and a list.
pub(crate) fn tables(sources: &Sources) -> String {
    let summary = sources.summary();
    let row = |own: &serde_json::Value| {
        let text = |key: &str| match &own[key] {
            serde_json::Value::Null => String::new(),
            serde_json::Value::String(text) => escaped(text),
            other => escaped(&other.to_string()),
        };
        let cells = ["kind", "name", "seed", "state", "steps", "length", "best", "directory"]
            .map(|key| format!("<td>{}</td>", text(key)));
        format!("<tr>{}</tr>\n", cells.concat())
    };
    let rows: String = summary["sources"].as_array().into_iter().flatten().map(row).collect();
    if rows.is_empty() {
        return "<p>Nothing yet. Runs appear here when they begin.</p>\n".to_owned();
    }
    let cells: String = sources.sweeps().map(Cells::table).collect();
    let heads =
        ["kind", "name", "seed", "state", "done", "of", "best", "directory"].map(|name| format!("<th>{name}</th>"));
    format!(
        "{cells}<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"All that was found\">\
         <table>\n<thead><tr>{}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n",
        heads.concat()
    )
}

/// The page as a file.
pub(crate) fn snapshot(curve: &str, episode: Option<&(String, String)>, tables: &str) -> String {
    let style = format!("<style>\n{}</style>", style());
    let curve = match curve {
        "" => String::new(),
        svg => format!("<figure id=\"curve\">{svg}</figure>\n"),
    };
    let episode = episode.map_or_else(String::new, |(words, page)| {
        format!(
            "<figure><figcaption>{words}</figcaption>\n<iframe title=\"The newest best's episode\" srcdoc=\"{}\"></iframe></figure>\n",
            attribute(page)
        )
    });
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<meta name=\"viewport\" content=\"width=device-width, \
         initial-scale=1\"/>\n<title>Oneiro: a snapshot</title>\n{style}\n</head>\n<body>\n<header><h1>Oneiro: a snapshot</h1></header>\n\
         <main>\n{curve}{episode}{tables}</main>\n</body>\n</html>\n"
    )
}

/// HTML as an attribute's value: all of it is kept, also control characters.
fn attribute(html: &str) -> String {
    html.replace('&', "&amp;").replace('"', "&quot;")
}

/// A scene in brief.
pub(crate) fn scene(scene: Option<&oneiro_lab::runs::Scene>) -> String {
    let scene = scene.map(|own| {
        json!({
            "generation": own.generation,
            "individual": own.individual,
            "fitness": Some(own.fitness).filter(|fitness| fitness.is_finite()),
            "paths": own.paths,
            "archive": own.archive,
        })
    });
    json!(scene).to_string()
}
