//! Each factor: the variance it explains, the curves of its levels, and their outcomes.

use oneiro_report::figures::escaped;
use oneiro_report::numbers::{Digits, NONE, count, probability, shown};
use oneiro_report::page::{Cell, Head, Row, Section, breakable, paragraph, table};

use super::curves::Curves;
use super::effects::{Comparison, Effects, FactorEffect, LEAST, LEVEL};
use super::levels::{Factor, Group, Kind};
use super::runs::Runs;
use super::sample::Sample;
use super::{DIGITS, Tables, cells, marked, pictures};

/// Maximum number of levels listed individually.
const LISTED: usize = 12;
/// Number of levels in a table.
const SHOWN: usize = 200;

/// Position of the best among ordered groups.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// Between others.
    Inside,
    /// At the first.
    LowEnd,
    /// At the last.
    HighEnd,
}

/// The group with the best mean outcome.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Best {
    pub(super) group: usize,
    /// Its position, for three or more ordered groups.
    pub(super) place: Option<Place>,
    /// Group to compare with: for an inner group the better of the ends, for an end its neighbour, otherwise the second
    /// best.
    rival: Option<usize>,
}

impl Best {
    /// Finds the best of a factor's groups, the first of equal ones; `None` if no run has an outcome.
    pub(super) fn of(factor: &Factor, samples: &[Sample]) -> Option<Self> {
        let known = samples.iter().map(Sample::merit).enumerate();
        let known: Vec<(usize, f64)> = known.filter(|(_, merit)| merit.is_finite()).collect();
        let best_of = |some: &[(usize, f64)]| {
            let better = |best: (usize, f64), one: &(usize, f64)| if one.1 > best.1 { *one } else { best };
            some.split_first()
                .map(|(first, rest)| rest.iter().fold(*first, better).0)
        };
        let group = best_of(&known)?;
        let at = known.iter().position(|(one, _)| *one == group)?;
        let last = known.len() - 1;
        if !factor.is_ordered() || last < 2 {
            let others: Vec<(usize, f64)> = known.into_iter().filter(|(one, _)| *one != group).collect();
            return Some(Self {
                group,
                place: None,
                rival: best_of(&others),
            });
        }
        let (place, rival) = if at == 0 {
            (Place::LowEnd, Some(known[1].0))
        } else if at == last {
            (Place::HighEnd, Some(known[last - 1].0))
        } else {
            (Place::Inside, best_of(&[known[0], known[last]]))
        };
        Some(Self {
            group,
            place: Some(place),
            rival,
        })
    }
}

/// Table of the variance that each factor explains.
pub(super) fn overview(tables: &Tables<'_>, runs: &Runs, samples: &[Vec<Sample>], effects: &Effects) -> Section {
    let words = format!(
        "What each swept key explains of {}, over all levels of the others. The best level has the {} mean. \
         \u{3b5}\u{b2} = H / (n \u{2212} 1) is the fraction of rank variance between levels, 0 to 1. H: Kruskal-Wallis \
         statistic, for factors of more than two levels. p values are Holm-corrected across factors. Levels with \
         fewer than {LEAST} runs are left out of both. Marked with * and \
         bold: corrected p below 0.05.{}",
        tables.outcome.1,
        if tables.is_less_better { "lowest" } else { "highest" },
        unbalanced(runs)
    );
    let head = [
        Head::Text("Factor"),
        Head::Text("Best level"),
        Head::Text("Where it is"),
        Head::Number("\u{3b5}\u{b2}"),
        Head::Number("H"),
        Head::Number("df"),
        Head::Number("p"),
        Head::Number("p, Holm"),
    ];
    let row = |(place, factor): (usize, &Factor)| -> Row {
        let best = Best::of(factor, &samples[place]);
        let effect = effects.factors.iter().find(|effect| effect.factor == place);
        let mut cells = vec![
            Cell::html(format!(
                "<a href=\"#{}\">{}</a>",
                anchor(place),
                breakable(&factor.name)
            )),
            Cell::name(best.map_or(NONE, |best| &factor.groups[best.group].label)),
            match (runs.tested_as(place), best.and_then(|best| best.place)) {
                (Some(first), _) => Cell::text(&format!("changes with {}", runs.factors[first].name)),
                (None, Some(Place::Inside)) => Cell::text("inside"),
                (None, Some(Place::LowEnd)) => Cell::text("lower end"),
                (None, Some(Place::HighEnd)) => Cell::text("upper end"),
                (None, None) => Cell::text(NONE),
            },
        ];
        cells.extend(explained(effect).map(Cell::number));
        cells.into()
    };
    let rows: Vec<Row> = runs.factors.iter().enumerate().map(row).collect();
    let body = if rows.is_empty() {
        paragraph("Only the seed was swept: there is one cell, and nothing to compare.")
    } else {
        paragraph(&words) + &table("", "", &head, &rows)
    };
    Section::new("factors", "Factors", body)
}

/// A note if levels of one factor were not run with the same levels of the others. Randomly drawn numbers are spread
/// over them by chance.
fn unbalanced(runs: &Runs) -> String {
    let levels = runs.factors.iter().map(|factor| factor.levels.len());
    let combinations = levels.fold(1, usize::saturating_mul);
    let mut counts = runs.cells.iter().map(|cell| cell.runs.len());
    let first = counts.next();
    let is_even = counts.all(|count| Some(count) == first);
    if runs.factors.iter().any(Factor::is_binned) || (runs.cells.len() == combinations && is_even) {
        return String::new();
    }
    format!(
        " Not every combination of levels was run as often as any other ({} of {} were run at all), so that what one \
         factor seems to do may be another\u{2019}s doing.",
        count(runs.cells.len() as u64),
        count(combinations as u64)
    )
}

/// Numbers of the overview.
fn explained(effect: Option<&FactorEffect>) -> [String; 5] {
    let share = effect.map_or(NONE.to_owned(), |effect| shown(effect.explained, Digits::Three));
    match effect.and_then(|effect| effect.test.as_ref()) {
        Some(test) => [
            share,
            shown(test.h, DIGITS),
            shown(test.df, DIGITS),
            probability(test.p),
            marked(test.p_holm),
        ],
        None => [share, NONE.into(), NONE.into(), NONE.into(), NONE.into()],
    }
}

/// Description of a factor's levels.
pub(super) fn levels(factor: &Factor) -> String {
    let texts: Vec<&str> = factor.levels.iter().map(|level| level.text.as_str()).collect();
    match texts[..] {
        [first, .., last] if factor.is_binned() => {
            let what = if factor.kind == Kind::Ranges {
                "ranges, by width from"
            } else {
                "numbers from"
            };
            let bins = factor.groups.len();
            format!("{} {what} {first} to {last}, in {bins} bins", count(texts.len() as u64))
        }
        _ if texts.len() > LISTED => format!(
            "{} and {} more",
            texts[..LISTED].join(", "),
            count((texts.len() - LISTED) as u64)
        ),
        _ => texts.join(", "),
    }
}

/// Target of links to a factor.
fn anchor(place: usize) -> String {
    format!("factor-{}", place + 1)
}

/// One picture per factor of the curves and outcomes of its runs; a single one of all runs if there is no factor.
pub(super) fn one_by_one(
    tables: &Tables<'_>,
    runs: &Runs,
    curves: &[Curves],
    samples: &[Vec<Sample>],
    effects: &Effects,
) -> Section {
    let body = if runs.factors.is_empty() {
        pictures::all_runs(tables, runs, curves)
    } else {
        let factors = runs.factors.iter().enumerate();
        let articles = factors.map(|(place, factor)| {
            let samples = &samples[place];
            format!(
                "<div class=\"together\">\n<h3 id=\"{}\">{}</h3>\n{}{}</div>\n{}",
                anchor(place),
                escaped(&factor.name),
                runs.tested_as(place).map_or_else(
                    || verdict(factor, samples, place, effects),
                    |first| {
                        let first = &runs.factors[first].name;
                        paragraph(&format!("It changes only together with {first}, which has the tests."))
                    }
                ),
                pictures::picture(tables, runs, curves, samples, place),
                numbers(tables, factor, samples, place),
            )
        });
        articles.collect()
    };
    Section::new("curves", "How runs went, and what came out", body)
}

/// Names the best level, whether it lies inside the swept range, and how certain that is.
pub(super) fn verdict(factor: &Factor, samples: &[Sample], place: usize, effects: &Effects) -> String {
    let [unit, units] = factor.unit();
    let Some(best) = Best::of(factor, samples) else {
        return paragraph("No run has an outcome that is a number.");
    };
    let label = |group: usize| escaped(&factor.groups[group].label);
    let all = samples.iter().filter(|sample| sample.mean().is_finite()).count();
    if all < 2 {
        return format!("<p>One {unit} only, {}: nothing to compare.</p>\n", label(best.group));
    }
    let swept = || {
        let [first, last] = [factor.levels.first(), factor.levels.last()]
            .map(|level| level.map_or_else(String::new, |level| escaped(&level.text)));
        let by = if factor.kind == Kind::Ranges { ", by width" } else { "" };
        format!("{first} to {last}{by}")
    };
    let at = match best.place {
        Some(Place::Inside) => format!(", <b>inside</b> what was swept, {}", swept()),
        Some(Place::LowEnd) => format!(
            ", the <b>lower end</b> of what was swept, {}: what lies below was not tried, and may be better",
            swept()
        ),
        Some(Place::HighEnd) => format!(
            ", the <b>upper end</b> of what was swept, {}: what lies above was not tried, and may be better",
            swept()
        ),
        None => String::new(),
    };
    let against = best.rival.map_or_else(String::new, |rival| {
        let who = match best.place {
            Some(Place::Inside) => "the better of the two ends",
            Some(_) => "its neighbour",
            None if all == 2 => "the other",
            None => "the second best",
        };
        let comparison = effects.of_groups(place, [best.group, rival]);
        format!(
            " Against {}, {who}: {}.",
            label(rival),
            distinction(comparison, best.group, samples[best.group].is_less_better())
        )
    });
    format!(
        "<p>The best of {all} {units} is <b>{}</b>, with a mean of {}{at}.{against}</p>\n",
        label(best.group),
        shown(samples[best.group].mean(), DIGITS)
    )
}

/// Says whether a group differs significantly from another. Its mean is less if that is better.
fn distinction(comparison: Option<&Comparison>, group: usize, is_less: bool) -> String {
    let Some(comparison) = comparison else {
        return "undecided: too few runs to tell them apart".to_owned();
    };
    let is_first = comparison.pair[0] == group;
    let a = if is_first { comparison.a } else { 1.0 - comparison.a };
    let verdict = match (comparison.p_holm < LEVEL, if is_less { a < 0.5 } else { a > 0.5 }) {
        (true, true) => "a significant difference",
        (true, false) => "a significant difference, the other way round by ranks",
        (false, _) => "undecided: no significant difference",
    };
    let interval = comparison.interval.map_or_else(String::new, |delta| {
        // That of Cliff's delta, on the scale of A, and for the group.
        let ends = [delta.low, delta.high].map(|end| f64::midpoint(if is_first { end } else { -end }, 1.0));
        let [low, high] = [ends[0].min(ends[1]), ends[0].max(ends[1])].map(|end| shown(end, Digits::Three));
        format!(" (95\u{a0}%: {low} to {high})")
    });
    format!(
        "A\u{a0}=\u{a0}{}{interval}, corrected p\u{a0}=\u{a0}{}, {verdict}",
        shown(a, Digits::Three),
        probability(comparison.p_holm)
    )
}

/// Table of the numbers behind the picture.
fn numbers(tables: &Tables<'_>, factor: &Factor, samples: &[Sample], place: usize) -> String {
    let head = [
        Head::Text(&factor.name),
        Head::Number("n"),
        Head::Number("mean"),
        Head::Number("95 % interval"),
        Head::Number("s.d."),
        Head::Number("median"),
        Head::Number("minimum"),
        Head::Number("maximum"),
    ];
    let row = |(group, sample): (&Group, &Sample)| -> Row {
        let [least, _, median, _, greatest] = sample.quartiles();
        let spread = sample.spread();
        let number = |x| Cell::number(shown(x, DIGITS));
        let interval = if sample.values.len() > 1 {
            format!("{} to {}", shown(spread.low, DIGITS), shown(spread.high, DIGITS))
        } else {
            NONE.to_owned()
        };
        vec![
            Cell::name(&group.label),
            Cell::number(cells::counted(sample)),
            number(spread.mean),
            Cell::number(interval),
            number(sample.deviation()),
            number(median),
            number(least),
            number(greatest),
        ]
        .into()
    };
    let shown_ones = pictures::best(samples, SHOWN);
    let some = if shown_ones.len() < samples.len() {
        format!(" Of {} levels, the {SHOWN} best.", count(samples.len() as u64))
    } else {
        String::new()
    };
    let rows: Vec<Row> = shown_ones
        .into_iter()
        .map(|group| row((&factor.groups[group], &samples[group])))
        .collect();
    let words = format!(
        "{} by {}, over all levels of the other factors.{some}",
        tables.outcome.1, factor.name
    );
    table(&format!("Table {}", place + 1), &words, &head, &rows)
}
