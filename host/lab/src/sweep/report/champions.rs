//! The best runs, and all of them by cell.

use oneiro_report::numbers::shown;
use oneiro_report::page::{Cell, Head, Row, Section, paragraph, table};

use super::cells::Cells;
use super::runs::{Run, Runs};
use super::{DIGITS, Tables};

/// Number of runs shown.
const BEST: usize = 20;

/// The best runs by outcome, the best first, equal ones by number. Runs without an outcome are left out.
pub(super) fn champions(runs: &Runs) -> Vec<&Run> {
    let mut best: Vec<&Run> = runs.all.iter().filter(|run| run.outcome.is_finite()).collect();
    best.sort_by(|a, b| runs.merit(b).total_cmp(&runs.merit(a)));
    best.truncate(BEST);
    best
}

/// Table of the best runs.
pub(super) fn section(tables: &Tables<'_>, runs: &Runs) -> Section {
    let best = champions(runs);
    let example = best.first().map_or_else(String::new, |run| {
        let number = run.number;
        format!(", such as <code>oneiro sweep extract DIR {number}</code> of the best")
    });
    let words = format!(
        "<p>The best runs. A sweep keeps of each run what these tables have; \
         <code>oneiro sweep extract DIR RUN</code>, with this sweep\u{2019}s directory and a run\u{2019}s number{example}, \
         makes the run\u{2019}s own directory, to replay, verify and audit it.</p>\n"
    );
    let number = |run: &Run| run.number.to_string();
    let rows: Vec<Row> = best.iter().map(|run| row(runs, run, number(run))).collect();
    Section::new(
        "champions",
        "Champions",
        format!("{words}{}", table("", "", &head(tables, runs), &rows)),
    )
}

/// Table of the runs of the best cells, to which the cells link.
pub(super) fn by_cell(tables: &Tables<'_>, runs: &Runs, cells: &Cells<'_>) -> Section {
    let of_cells = cells.ranked.iter().take(cells.listed());
    let listed = of_cells
        .flat_map(|ranked| &ranked.cell.runs)
        .map(|&place| &runs.all[place]);
    let target = |run: &Run| format!("<span id=\"{}\">{}</span>", target(run), run.number);
    let rows: Vec<Row> = listed.map(|run| row(runs, run, target(run))).collect();
    let words = if rows.len() < runs.all.len() {
        "The runs of the best cells, cell by cell; results.csv has all runs."
    } else {
        "All runs, cell by cell, those of the best cell first."
    };
    let body = paragraph(words) + &table("", "", &head(tables, runs), &rows);
    Section::new("runs", "Runs", body)
}

/// Target of links to a run.
pub(super) fn target(run: &Run) -> String {
    format!("run-{}", run.number)
}

fn head<'a>(tables: &Tables<'a>, runs: &'a Runs) -> Vec<Head<'a>> {
    let mut head = vec![Head::Number("Run"), Head::Text("id")];
    head.extend(runs.factors.iter().map(|factor| Head::Text(&factor.name)));
    head.extend([Head::Number("seed"), Head::Number(tables.outcome.1)]);
    head.extend(tables.others.iter().map(|other| Head::Number(other)));
    head.push(Head::Text("result"));
    head
}

/// A run, with its number as HTML.
fn row(runs: &Runs, run: &Run, number: String) -> Row {
    let mut cells = vec![Cell::number(number), Cell::code(&run.id)];
    cells.extend(runs.texts(&run.levels).map(Cell::name));
    cells.push(Cell::number(run.seed.to_string()));
    cells.push(Cell::number(shown(run.outcome, DIGITS)));
    cells.extend(run.others.iter().map(|other| match other.parse() {
        // Of a whole number, such as that of a generation, each digit counts.
        Ok(_) if other.bytes().all(|byte| byte.is_ascii_digit()) => Cell::number(other.to_string()),
        Ok(number) => Cell::number(shown(number, DIGITS)),
        Err(_) => Cell::text(other),
    }));
    cells.push(Cell::code(&run.result));
    cells.into()
}
