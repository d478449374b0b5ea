//! Starts of episodes, from a file.

use std::path::Path;

use oneiro::world::{Start, World, WorldSpec};
use oneiro_base::columns::{self, Columns};
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;

/// Columns of a file of starts.
const COLUMNS: [&str; 3] = ["x_mm", "y_mm", "heading_turns"];

/// Reads starts from a `.csv` file, one per line: x and y in mm, heading in turns. With a header, columns are in any order, and
/// others are ignored, so that a trace can be read; without one they are in this order. `say` is told both. Returns the world of
/// each start.
///
/// # Errors
/// Exit 3: there is no such file, no start in it, a value that isn't a number, or a start that the world doesn't allow,
/// such as one in a wall; with the line.
pub fn read(path: &Path, spec: &WorldSpec, say: impl FnOnce(String)) -> Result<Vec<World>> {
    let refused = |problem: &dyn std::fmt::Display| Failure::input(format_args!("{}: {problem}", path.display()));
    if spec.robot.count() > 1 {
        return Err(refused(
            &"has starts of single robots; allowed for a swarm: start.poses of its experiment",
        ));
    }
    let bytes = files::bytes(path)?;
    let Columns { values, lines, word } =
        columns::read(&bytes, &COLUMNS, |value, _| Ok(value)).map_err(|problem| refused(&problem))?;
    if let Some(word) = word {
        say(format!("{}: {word}", path.display()));
    }
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
