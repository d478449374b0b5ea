//! Bumpers.

use std::fmt::Write;

use super::kind::{Entry, Mark};

/// Stands for the distance of the centres of two bodies that touch.
pub(crate) const APART: &str = "APART";

/// Width of a bumper that has none given, turns.
pub const WIDTH: f32 = 0.5;

pub(super) const ENTRY: Entry = Entry {
    keys: &["heading_turns", "range_mm", "width_turns"],
    numbers: |sensor, _| [sensor.range.unwrap_or(1.0), 0.5 * sensor.width.unwrap_or(WIDTH)],
    reach: |sensor, around| around.body_radius + sensor.range.unwrap_or(0.0),
    mark: Mark::Arc,
    ..Entry::new(
        ["bumper", "1 while an object is within its range and its width, else 0"],
        |text, each| {
            let (index, own) = (each.index, each.arguments());
            let _ = writeln!(
                text.pressing,
                "                pressed{index} = max(pressed{index}, bumper_on({APART}, squared, bearing, {own}));"
            );
            let _ = writeln!(text.numbers, "    var pressed{index} = 0.0f;");
            let pressed = format!("max(pressed{index}, bumper_at(shape, squared, bearing, {own}))");
            let _ = writeln!(text.bumpers, "                pressed{index} = {pressed};");
            text.widest = format!("max({}, s{index}.range)", text.widest);
            format!("pressed{index}")
        },
    )
};

/// The code that presses bumpers, from the code for each.
pub(crate) fn of_an_object(bumpers: &str, widest: &str) -> String {
    if bumpers.is_empty() {
        return String::new();
    }
    format!(
        "            let near = shapes[shape].contact + {widest};
            if (squared < near * near) {{
                let bearing = direction(to);
{bumpers}            }}
"
    )
}
