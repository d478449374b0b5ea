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
    let turns = if table.is_empty() {
        turns
    } else {
        format!("{table}.{turns}")
    };
    let key = key_of(&turns);
    let is_angle = T::rows()
        .iter()
        .any(|row| row.key == key && row.unit.starts_with("turns"));
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::settings::Settings;
    use super::super::{Experiment, Files, swarm};
    use super::*;

    /// An experiment that has every key in turns of a parametric robot.
    const ALL: &str = "
[robot]
kind = 'differential'
body_radius_mm = 30
wheel_base_mm = 50
greatest_speed_mm_s = 100
sensors = [
    { name = 'a', kind = 'distance', heading_turns = 0.125, bearing_turns = 0.25, range_mm = 50 },
    { name = 'b', kind = 'bumper', heading_turns = 0.0625, range_mm = 5, width_turns = 0.5 },
]
[arena]
width_mm = 500
height_mm = 500
blocks = [{ x_mm = 50, y_mm = 60, length_mm = 30, width_mm = 20, heading_turns = 0.1 }]
patches = [{ x_mm = 250, y_mm = 250, sides_mm = [40, 30], grey = 0.5, heading_turns = -0.3 }]
[start]
kind = 'at'
x_mm = 200
y_mm = 200
heading_turns = 0.375
";

    /// Only the built-in robot veers.
    const VEER: &str = "noise.veer_turns_per_m = 0.05";

    fn read(text: &str, set: &[Setting]) -> std::result::Result<Experiment, String> {
        let parsed = Parsed::new("e.toml".into(), text).unwrap();
        Experiment::of(Path::new("e.toml"), &parsed, set, &Files::default()).map_err(|failure| failure.to_string())
    }

    /// Every row in turns takes degrees: in the file, and from settings as those of the command line, of sweeps and of Python.
    #[test]
    fn every_key_in_turns_is_taken_in_degrees() {
        let expected = read(ALL, &[]).unwrap();
        let mut degrees = String::new();
        let mut keys = 0;
        for part in ALL.split_inclusive([',', '}', '\n']) {
            match part.split_once("_turns") {
                Some((before, rest)) => {
                    let (key, value) = rest.split_once('=').unwrap();
                    let number = value.trim_matches([' ', ',', '}', '\n']);
                    let turned = format!("{}", 360.0 * number.parse::<f64>().unwrap());
                    let value = value.replace(number, &turned);
                    degrees.extend([before, "_deg", key, "=", &value]);
                    keys += 1;
                }
                None => degrees += part,
            }
        }
        let own = read(&degrees, &[]).unwrap();
        assert_eq!(own.world().spec(), expected.world().spec());
        assert_eq!(own.identities().of(1), expected.identities().of(1));
        assert!(!own.resolved_toml(1).contains("_deg"));
        let rows = Settings::rows().iter().map(|row| (row.key, row.unit));
        let rows = rows.chain(swarm::File::rows().iter().map(|row| (row.key, row.unit)));
        let mut known = 0;
        for (key, unit) in rows.filter(|(key, _)| key.contains("_turns")) {
            assert!(name(key, unit).is_some(), "{key} has the unit {unit:?}");
            let (list, last) = key.rsplit_once('.').unwrap();
            let path = format!("{}.{last}", list.replace("[]", "[0]"));
            let last = last.replace("_turns", "_deg");
            // The bumper is the second sensor.
            let path = if last == "width_deg" {
                path.replace("[0]", "[1]")
            } else {
                path
            };
            let base = if key.starts_with("noise.") { VEER } else { ALL };
            let setting = |key: &str, value: f64| Setting::at(format!("--set {key}"), key, &value.into());
            let [turns, degrees] = [(path.clone(), 0.02), (path.replace("_turns", "_deg"), 7.2)]
                .map(|(key, value)| read(base, &[setting(&key, value)]).unwrap());
            assert_eq!(degrees.world().spec(), turns.world().spec(), "{path}");
            assert_ne!(
                degrees.world().spec(),
                read(base, &[]).unwrap().world().spec(),
                "{path}"
            );
            let both = read(
                base,
                &[setting(&path, 0.02), setting(&path.replace("_turns", "_deg"), 7.2)],
            )
            .unwrap_err();
            assert!(both.contains(&format!("{last}: is already given, as {path}")), "{both}");
            known += 1;
        }
        // Two sensors have a heading, and one key is in the other text.
        assert_eq!(keys, known);
    }

    #[test]
    fn degrees_and_turns_are_not_given_together() {
        let both = ALL.replace("heading_turns = 0.375", "heading_turns = 0.375\nheading_deg = 90");
        let refused = read(&both, &[]).unwrap_err();
        assert!(
            refused
                .contains("e.toml:21:15: start.heading_deg: is already given, as start.heading_turns (e.toml:20:17)"),
            "{refused}"
        );
        let typed = |setting: &str| Setting::typed(setting).unwrap();
        // What has the higher rank replaces the other.
        for (text, set) in [
            (ALL.to_owned(), "start.heading_deg=90"),
            (
                ALL.replace("start]", "start]\nheading_deg = 80")
                    .replace("heading_turns = 0.375", ""),
                "start.heading_turns=0.25",
            ),
        ] {
            let made = read(&text, &[typed(set)]).unwrap().resolved_toml(1);
            assert!(made.contains("heading_turns = 0.25\n"), "{made}");
        }
        for (set, expected) in [
            (
                "start.heading_deg=720",
                "start.heading_turns: is 2; allowed: -1 to 1 turns, each of 360 degrees",
            ),
            (
                "start.heading_deg=north",
                "start.heading_turns: is \"north\"; allowed: a number",
            ),
            ("task.heading_deg=1", "unknown key `heading_deg`"),
        ] {
            let refused = read(ALL, &[typed(set)]).unwrap_err();
            assert!(
                refused.starts_with(&format!("--set {set}")) && refused.contains(expected),
                "{refused}"
            );
        }
        // Conversion is one division in double precision.
        let third = read(ALL, &[typed("start.heading_deg=120")]).unwrap().resolved_toml(1);
        assert!(third.contains("heading_turns = 0.3333333333333333\n"), "{third}");
    }
}
