//! Assumptions of a study and the source of each.

use oneiro_report::page::{Cell, Head, Row, table};
use serde::{Deserialize, Serialize};

/// A value that a study assumes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Assumption {
    /// Key in the settings, such as `noise.walk_step`.
    pub name: String,
    /// Value with its unit.
    pub value: String,
    /// Source of the value: the paper, another publication, or our own choice.
    pub source: String,
}

/// Formats the assumptions as a table under its own heading.
pub(super) fn html(assumptions: &[Assumption]) -> String {
    let head = [Head::Text("Setting"), Head::Text("Value"), Head::Text("Source")];
    let rows: Vec<Row> = assumptions
        .iter()
        .map(|assumption| {
            Row::from(vec![
                Cell::code(&assumption.name),
                Cell::text(&assumption.value),
                Cell::text(&assumption.source),
            ])
        })
        .collect();
    let words = "Every choice in force, and where it is from.";
    format!("<h3>Assumptions</h3>\n{}", table("", words, &head, &rows))
}
