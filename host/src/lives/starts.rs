//! Places where lives start, from a file.

use std::path::Path;

use oneiro::world::{Start, World, WorldSpec};

use crate::columns;
use crate::exit::{Failure, Result};
use crate::files;

/// The columns of a file of starts.
const COLUMNS: [&str; 3] = ["x_mm", "y_mm", "heading_turns"];

/// Reads starts from a `.csv` file, one a line: x and y in mm, heading in turns. Where a line of names goes before them,
/// other columns don't matter, so that a trace can be read. For each start the world that lives from there have.
///
/// # Errors
/// Exit 3: there is no such file, no start in it, something that is no number, or a start that the world does not
/// allow, such as one in a wall; with the line.
pub(crate) fn read(path: &Path, spec: &WorldSpec) -> Result<Vec<World>> {
    let refused = |problem: &dyn std::fmt::Display| Failure::input(format_args!("{}: {problem}", path.display()));
    let bytes = files::bytes(path)?;
    let (values, lines) = columns::read(&bytes, &COLUMNS, |value, _| Ok(value)).map_err(|problem| refused(&problem))?;
    if lines.is_empty() {
        return Err(refused(&format_args!(
            "holds no start; allowed: one or more lines of {}",
            COLUMNS.join(", ")
        )));
    }
    let starts = values.as_chunks().0.iter().zip(lines);
    starts
        .map(|(&[x, y, heading], line)| {
            let start = Start::At { x, y, heading };
            World::new(WorldSpec { start, ..spec.clone() })
                .map_err(|invalid| refused(&format_args!("line {line}: {invalid}")))
        })
        .collect()
}
