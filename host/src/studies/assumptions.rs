//! What a study takes for granted, and where each choice is from.

use serde::{Deserialize, Serialize};

use crate::report::page::{Cell, Head, Row, table};

/// A choice that the paper leaves open.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Assumption {
    /// Its name in the settings, such as `noise.walk_step`.
    pub(crate) name: String,
    /// Its value, with its unit.
    pub(crate) value: String,
    /// Where the value is from: the paper, a source, or ours.
    pub(crate) source: String,
}

/// All of them as a table under its own heading.
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
