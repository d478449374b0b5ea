//! Angles in degrees: a key in turns, such as `start.heading_turns`, can be given in degrees, as `start.heading_deg`.

use oneiro_base::exit::Result;
use toml::{Table, Value};

use super::source::{Parsed, Setting, Source};
use super::values::{self, Described};

/// The name of a key in degrees; none if its unit isn't turns.
pub(super) fn name(key: &str, unit: &str) -> Option<String> {
    unit.starts_with("turns").then(|| key.replace("_turns", "_deg"))
}

/// The path in turns of a path in degrees, such as `robot.sensors[2].heading_deg` or `robot.sensors.2.heading_deg`.
pub(crate) fn in_turns<T: Described>(path: &str) -> Option<String> {
    let (table, last) = path.rsplit_once('.').unwrap_or(("", path));
    let turns = last.contains("_deg").then(|| last.replace("_deg", "_turns"))?;
    let turns = if table.is_empty() { turns } else { format!("{table}.{turns}") };
    let key = key_of(&turns);
    let is_angle = T::rows().iter().any(|row| row.key == key && row.unit.starts_with("turns"));
    is_angle.then_some(turns)
}

/// The row's key of a path: every element of a list is `[]`.
fn key_of(path: &str) -> String {
    let mut key = String::new();
    for part in path.split('.') {
        let name = part.split('[').next().unwrap_or_default();
        let is_index = name.parse::<usize>().is_ok();
        match (is_index, key.is_empty()) {
            (true, _) => (),
            (false, true) => key += name,
            (false, false) => key.extend([".", name]),
        }
        if is_index || name.len() < part.len() {
            key += "[]";
        }
    }
    key
}

/// Reads the values of an experiment from a file and from settings that override it, with all angles in turns.
///
/// # Errors
/// As [`Source::read`]; and an angle that is given in turns and in degrees.
pub(super) fn read<'a, T: Described>(file: &'a Parsed<'_>, set: &[Setting]) -> Result<(Table, Source<'a>)> {
    let (mut given, mut source): (Table, _) = Source::read(file, set)?;
    for (degrees, turns) in source.renamed(in_turns::<T>)? {
        let Some(mut value) = values::at(&given, &degrees).cloned() else {
            continue;
        };
        values::remove(&mut given, &degrees);
        if let Some(turns) = turns {
            divide(&mut value);
            values::put(&mut given, &turns, value);
        }
    }
    Ok((given, source))
}

/// Makes turns of degrees, and leaves what is no number.
fn divide(value: &mut Value) {
    let number = match value {
        Value::Integer(degrees) => *degrees as f64,
        Value::Float(degrees) => *degrees,
        Value::Array(list) => return list.iter_mut().for_each(divide),
        _ => return,
    };
    *value = Value::Float(number / 360.0);
}
