//! Tables of effect sizes and tests.

use oneiro_base::contents::Column;
use oneiro_report::csv::{Csv, known};
use oneiro_report::numbers::{Digits, NONE, count, probability, shown};
use oneiro_report::page::{Cell, Head, Row, Section, list, paragraph, table};

use super::cells::Cells;
use super::effects::{Comparison, EXACT, Effects, FEW, FEWER_RESAMPLES, Family, LEAST, LEVEL, RESAMPLES};
use super::levels::Factor;
use super::runs::Runs;
use super::{DIGITS, Tables, marked};

/// Number of comparisons of a family on the page.
const SHOWN: usize = 200;
/// Significant digits of effect sizes.
const EFFECT: Digits = Digits::Three;

/// Explanation of the tests, and both families of comparisons.
pub(super) fn section(tables: &Tables<'_>, runs: &Runs, cells: &Cells<'_>, effects: &Effects) -> Section {
    let tests = if effects.levels.comparisons.is_empty() && effects.cells.comparisons.is_empty() {
        String::new()
    } else {
        tests(tables)
    };
    Section::new(
        "effects",
        "Effect sizes and tests",
        format!("{tests}{}{}", of_levels(runs, effects), of_cells(runs, cells, effects)),
    )
}

/// Explanation that applies to all tables.
pub(super) fn tests(tables: &Tables<'_>) -> String {
    list(&[
        &format!(
            "Differences are of means of {}, first minus second: above 0 where the first is higher.",
            tables.outcome.1
        ),
        "A (Vargha and Delaney) is the chance that a run of the first has a higher outcome than one of the second, ties \
         counted half; \u{3b4} (Cliff) is 2 A \u{2212} 1. 0.5 and 0 mean no difference.",
        &format!(
            "The interval is the 95 % percentile bootstrap interval of \u{3b4}, each sample resampled separately \
             {RESAMPLES} times ({FEWER_RESAMPLES} times or more where runs are very many), from fixed seeds. An interval \
             of one number means that the samples do not overlap."
        ),
        &format!(
            "p: Mann-Whitney U test, two-sided: exact where neither sample has more than {EXACT} \
             runs or ties, else by the normal approximation with corrections for ties and continuity."
        ),
        "p values are Holm-corrected within each table: the chance of one or more false marks in a table is at most 0.05. \
         Marked with * and bold: corrected p below 0.05.",
        &format!("Samples of fewer than {LEAST} runs whose outcome is a number are not tested."),
    ])
}

fn of_levels(runs: &Runs, effects: &Effects) -> String {
    let family = &effects.levels;
    if effects.factors.is_empty() {
        return "<h3>Levels</h3>\n".to_owned() + &paragraph("No factor has two levels: there is nothing to compare.");
    }
    let binned = runs.factors.iter().any(Factor::is_binned);
    let are_many = |factor: &Factor| factor.groups.len() > FEW;
    let words = format!(
        "All pairs of {} of each factor{}, over all levels of the other factors, whose effect counts as noise here. The \
         family: {}, of all factors together.{}{}",
        if binned {
            "levels, or of bins of levels,"
        } else {
            "levels"
        },
        if runs.factors.iter().any(are_many) {
            format!(", or, of more than {FEW}, each against the best,")
        } else {
            String::new()
        },
        size_of(family),
        untested(family, "levels"),
        hopeless(family)
    );
    let label = |factor: usize, group: usize| Cell::name(&runs.factors[factor].groups[group].label);
    let names = |one: &Comparison| {
        let factor = one.factor.unwrap_or(0);
        let [first, second] = one.pair.map(|group| label(factor, group));
        vec![Cell::name(&runs.factors[factor].name), first, second]
    };
    let head = [Head::Text("Factor"), Head::Text("first"), Head::Text("second")];
    format!(
        "<h3>Levels</h3>\n{}{}",
        paragraph(&words),
        comparisons(family, &head, names)
    )
}

fn of_cells(runs: &Runs, cells: &Cells<'_>, effects: &Effects) -> String {
    let family = &effects.cells;
    let head = "<h3>Cells</h3>\n".to_owned();
    if cells.ranked.len() < 2 {
        return head + &paragraph("There are not two cells to compare.");
    }
    if family.comparisons.is_empty() {
        let words = format!("Fewer than two cells have {LEAST} runs whose outcome is a number: none is tested.");
        return head + &paragraph(&words);
    }
    let which = if cells.ranked.len() - family.untested <= FEW {
        "All pairs of cells, by their numbers in the table of cells, the better first."
    } else {
        "Each cell against the best, by their numbers in the table of cells. The best was picked by these same runs, so \
         its lead is more likely too large than too small."
    };
    let words = format!(
        "{which} The family: {}.{}{}",
        size_of(family),
        untested(family, "cells"),
        hopeless(family)
    );
    let names = |one: &Comparison| {
        let name = |rank: usize| {
            let levels: Vec<&str> = runs.texts(&cells.ranked[rank].cell.levels).collect();
            Cell::name(&format!("{}: {}", rank + 1, levels.join(", ")))
        };
        one.pair.map(name).into()
    };
    let columns = [Head::Text("first"), Head::Text("second")];
    format!(
        "{head}{}{}{}",
        paragraph(&words),
        paragraph(&seeds(family, effects.seed_correlation)),
        comparisons(family, &columns, names)
    )
}

/// How many tests a family has.
pub(super) fn size_of(family: &Family) -> String {
    match family.comparisons.len() {
        1 => "this test alone".to_owned(),
        several => format!("these {} tests", count(several as u64)),
    }
}

/// Names the samples that were too small.
pub(super) fn untested(family: &Family, what: &str) -> String {
    match family.untested {
        0 => String::new(),
        n => format!(
            " Not tested, for having fewer than {LEAST} runs whose outcome is a number: {} of the {what}.",
            count(n as u64)
        ),
    }
}

/// A note if no possible result could have been significant.
pub(super) fn hopeless(family: &Family) -> String {
    let least = family.least_p();
    if family.comparisons.is_empty() || least < LEVEL {
        return String::new();
    }
    format!(
        " With samples as small as these and as many tests, no corrected p can be below {}: nothing could be marked, \
         whatever the runs say. More seeds, or fewer cells, would make these tests worth something.",
        shown(least, EFFECT)
    )
}

/// A note on cells that share seeds.
fn seeds(family: &Family, correlation: Option<f64>) -> String {
    let all = family.comparisons.iter();
    if all.clone().all(|one| one.shared_seeds == 0) {
        return "No two of these cells share a seed.".to_owned();
    }
    let who = if all.clone().all(|one| one.same_seeds) {
        "The cells have the same seeds, so that their runs could be paired by seed."
    } else {
        "Some of these cells share seeds (effects.csv says how many), so that runs could be paired by seed."
    };
    let correlation = correlation.map_or_else(String::new, |r| {
        format!(
            " How far runs of one seed are above or below the means of their cells is correlated by r = {} from cell to \
             cell.",
            shown(r, EFFECT)
        )
    });
    format!(
        "{who} They are tested as independent samples all the same: a seed settles where a run begins and which random \
         numbers it draws, but what comes of these is another thing in each cell.{correlation} Where r is about 0, pairs \
         have nothing in common that a test of pairs could use; were it high, the tests here would err on the side of no \
         difference."
    )
}

/// A table of comparisons: all of them, or those with the smallest p.
pub(super) fn comparisons(family: &Family, names: &[Head<'_>], cells: impl Fn(&Comparison) -> Vec<Cell>) -> String {
    let mut head = names.to_vec();
    head.extend(
        [
            "n",
            "difference",
            "A",
            "\u{3b4}",
            "95 % of \u{3b4}",
            "U",
            "p",
            "p, Holm",
        ]
        .map(Head::Number),
    );
    let mut shown_ones: Vec<&Comparison> = family.comparisons.iter().collect();
    let mut words = String::new();
    if shown_ones.len() > SHOWN {
        shown_ones.sort_by(|a, b| a.p.total_cmp(&b.p));
        shown_ones.truncate(SHOWN);
        words = format!("The {SHOWN} with the lowest p; effects.csv has all of them.");
    }
    let row = |one: &&Comparison| -> Row {
        let mut row = cells(one);
        let [m, n] = one.runs.map(|n| count(n as u64));
        let interval = one.interval.map_or(NONE.to_owned(), |interval| {
            let [low, high] = [interval.low, interval.high].map(|end| shown(end, EFFECT));
            if low == high { low } else { format!("{low} to {high}") }
        });
        let figures = [
            if m == n { m } else { format!("{m}, {n}") },
            shown(one.means[0] - one.means[1], DIGITS),
            shown(one.a, EFFECT),
            shown(one.delta, EFFECT),
            interval,
            shown(one.u, DIGITS),
            probability(one.p),
            marked(one.p_holm),
        ];
        row.extend(figures.map(Cell::number));
        row.into()
    };
    let rows: Vec<Row> = shown_ones.iter().map(row).collect();
    table("", &words, &head, &rows)
}

/// The columns of the table of comparisons.
pub(super) static COLUMNS: [Column; 19] = [
    Column::text("family", "`levels` of one key, or whole `cells`"),
    Column::text("factor", "the key whose levels are compared"),
    Column::text("first", "the first level, or the first cell's number in `cells.csv`"),
    Column::text("second", "the second level or cell number"),
    Column::whole("n_first", "", "the number of runs with the first"),
    Column::whole("n_second", "", "the number of runs with the second"),
    Column::number("mean_first", "", "the outcome's mean with the first"),
    Column::number("mean_second", "", "its mean with the second"),
    Column::number("difference", "", "the first mean minus the second"),
    Column::number(
        "a",
        "0 to 1",
        "Vargha and Delaney's A: how often a run with the first is better",
    ),
    Column::number("a_low", "0 to 1", "the lower bound of A's 95 % confidence interval"),
    Column::number("a_high", "0 to 1", "the upper bound of A's interval"),
    Column::number("delta", "-1 to 1", "Cliff's delta, 2 A - 1"),
    Column::number(
        "delta_low",
        "-1 to 1",
        "the lower bound of delta's 95 % confidence interval",
    ),
    Column::number("delta_high", "-1 to 1", "the upper bound of delta's interval"),
    Column::number("u", "", "Mann and Whitney's U"),
    Column::number("p", "0 to 1", "the two-sided p-value of the test"),
    Column::number(
        "p_holm",
        "0 to 1",
        "the p-value corrected by Holm's procedure for all comparisons of its family",
    ),
    Column::whole("shared_seeds", "", "the number of seeds that occur in both"),
];

/// All comparisons of both families as CSV. Groups of a factor's levels are named; cells are numbered as in the table
/// of cells. A's interval is delta's, converted to the scale of A.
pub(super) fn csv(runs: &Runs, effects: &Effects) -> String {
    let mut table = Csv::new(&COLUMNS);
    for one in effects.levels.comparisons.iter().chain(&effects.cells.comparisons) {
        let names = if let Some(factor) = one.factor {
            let factor = &runs.factors[factor];
            let [first, second] = one.pair.map(|group| factor.groups[group].label.clone());
            ["levels".to_owned(), factor.name.clone(), first, second]
        } else {
            let [first, second] = one.pair.map(|rank| (rank + 1).to_string());
            ["cells".to_owned(), String::new(), first, second]
        };
        let [low, high] = one
            .interval
            .map_or([f64::NAN; 2], |interval| [interval.low, interval.high]);
        let figures = [
            one.means[0],
            one.means[1],
            one.means[0] - one.means[1],
            one.a,
            f64::midpoint(low, 1.0),
            f64::midpoint(high, 1.0),
            one.delta,
            low,
            high,
            one.u,
            one.p,
            one.p_holm,
        ];
        let row = names
            .into_iter()
            .chain(one.runs.map(|n| n.to_string()))
            .chain(figures.map(known));
        table.row(row.chain([one.shared_seeds.to_string()]));
    }
    table.text()
}
