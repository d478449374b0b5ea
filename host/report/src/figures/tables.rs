//! A sampled sensor table as heat maps, one panel for each sensor and point of view.

use std::fmt::Write;

use oneiro::tables::{SENSORS, SensorTable};

use super::svg::{Anchor, BOLD, PLAIN, SOFT, Svg, number, ramp};

/// Size of a panel's plot, distance to the next one, and room for text.
const PANEL: (f64, f64) = (200.0, 130.0);
const GAP: (f64, f64) = (34.0, 54.0);
const LEFT: f64 = 60.0;
const TOP: f64 = 80.0;
const COLUMNS: usize = 4;
/// Colours from zero to the maximum reading.
pub const HEAT: [[u8; 3]; 5] = [
    [0xf5, 0xf3, 0xee],
    [0xb9, 0xd6, 0xd2],
    [0x4f, 0x9a, 0xa5],
    [0x2b, 0x4f, 0x8f],
    [0x1c, 0x1f, 0x4f],
];
/// Number of distinguishable shades.
const SHADES: u16 = 32;
/// The maximum reading.
const GREATEST: u16 = 1023;
/// Names of a Khepera's sensors, in the order of its answer.
pub(super) const NAMES: [&str; SENSORS] = [
    "left 90",
    "left 45",
    "left 10",
    "right 10",
    "right 45",
    "right 90",
    "back right",
    "back left",
];

/// Room for a heading above each point of view, if there are several.
const HEADING: f64 = 30.0;

/// Draws each sensor's reading for an object at a bearing (clockwise, straight ahead in the middle) and a distance, by
/// point of view.
pub fn sensor_table(table: &SensorTable) -> String {
    let (views, sensors) = (table.views as usize, table.sensors as usize);
    let heading = if views > 1 { HEADING } else { 0.0 };
    let view_height = sensors.div_ceil(COLUMNS) as f64 * (PANEL.1 + GAP.1) + heading;
    let width = LEFT + COLUMNS as f64 * (PANEL.0 + GAP.0);
    let height = TOP + views as f64 * view_height - 14.0;
    let count = match sensors {
        1 => "one sensor".to_owned(),
        SENSORS => "eight sensors".to_owned(),
        count => format!("{count} sensors"),
    };
    let title = format!(
        "Readings of {count} for an object of class \u{201c}{}\u{201d}",
        table.class
    );
    let mut svg = Svg::new(width, height, &title);
    svg.words((LEFT, 34.0), 17.0, Anchor::Start, BOLD, &title);
    key(&mut svg, width - GAP.0);
    for view in 0..views {
        let top = TOP + view as f64 * view_height;
        if views > 1 {
            let degrees = |view: usize| number(180.0 * view as f64 / views as f64);
            let words = format!(
                "from {}\u{b0} to {}\u{b0} off its length",
                degrees(view),
                degrees(view + 1)
            );
            svg.words((LEFT, top), 14.0, Anchor::Start, BOLD, &words);
        }
        for sensor in 0..sensors {
            let corner = (
                LEFT + (sensor % COLUMNS) as f64 * (PANEL.0 + GAP.0),
                top + heading + (sensor / COLUMNS) as f64 * (PANEL.1 + GAP.1),
            );
            panel(&mut svg, table, view, sensor, corner);
        }
    }
    svg.finish()
}

/// Draws the key to the shades.
fn key(svg: &mut Svg, right: f64) {
    let width = 140.0 / f64::from(SHADES);
    for shade in 0..SHADES {
        let x = right - 140.0 + f64::from(shade) * width;
        svg.rectangle((x, 24.0), (width + 0.3, 10.0), &format!("fill=\"{}\"", colour(shade)));
    }
    svg.words((right - 148.0, 33.0), 12.0, Anchor::End, SOFT, "reading");
    svg.words((right - 140.0, 48.0), 12.0, Anchor::Start, SOFT, "0");
    svg.words((right, 48.0), 12.0, Anchor::End, SOFT, &GREATEST.to_string());
}

fn panel(svg: &mut Svg, table: &SensorTable, view: usize, sensor: usize, (left, top): (f64, f64)) {
    svg.rectangle((left, top), PANEL, &format!("fill=\"{}\"", colour(0)));
    for shade in 1..SHADES {
        let cells = cells_of(table, view, sensor, shade);
        if !cells.is_empty() {
            let (x, y) = (number(left), number(top));
            let fill = colour(shade);
            svg.raw(&format!(
                "<path transform=\"translate({x} {y})\" d=\"{cells}\" fill=\"{fill}\" shape-rendering=\"crispEdges\"/>"
            ));
        }
    }
    svg.rectangle((left, top), PANEL, "fill=\"none\" stroke=\"#a9acb3\"");
    // Other robots name their sensors in their experiments.
    let name = if table.sensors as usize == SENSORS {
        format!("{sensor}: {}", NAMES[sensor])
    } else {
        sensor.to_string()
    };
    svg.words((left, top - 7.0), 13.0, Anchor::Start, PLAIN, &name);
    // The outer labels stay within the panel, clear of the next one's.
    let bearings = [
        (-180, Anchor::Start),
        (-90, Anchor::Middle),
        (0, Anchor::Middle),
        (90, Anchor::Middle),
        (180, Anchor::End),
    ];
    for (degrees, anchor) in bearings {
        let x = left + (0.5 + f64::from(degrees) / 360.0) * PANEL.0;
        svg.line((x, top + PANEL.1), (x, top + PANEL.1 + 4.0), "stroke=\"#a9acb3\"");
        svg.words(
            (x, top + PANEL.1 + 17.0),
            11.0,
            anchor,
            SOFT,
            &format!("{degrees}\u{b0}"),
        );
    }
    // Only the leftmost panels label their distances; all share them.
    if sensor.is_multiple_of(COLUMNS) {
        let farthest = table.nearest + table.spacing * table.rows.saturating_sub(1) as f32;
        let near = format!("{} mm", number(f64::from(table.nearest)));
        let far = format!("{} mm", number(f64::from(farthest)));
        svg.words((left - 6.0, top + PANEL.1 - 2.0), 11.0, Anchor::End, SOFT, &near);
        svg.words((left - 6.0, top + 11.0), 11.0, Anchor::End, SOFT, &far);
    }
}

/// Path data of the cells of one shade, with neighbours in a row joined; the nearest distance is at the bottom.
fn cells_of(table: &SensorTable, view: usize, sensor: usize, shade: u16) -> String {
    let (rows, bearings) = (table.rows as usize, table.bearings as usize);
    let (width, height) = (PANEL.0 / bearings.max(1) as f64, PANEL.1 / rows.max(1) as f64);
    let has_shade = |row: usize, column: usize| {
        // The bearing straight ahead, 0, is drawn in the middle.
        let bearing = (column + bearings.div_ceil(2)) % bearings;
        let cell = (view * rows + row) * bearings + bearing;
        let reading = table.readings.get(cell * table.sensors as usize + sensor);
        reading.is_some_and(|reading| shade_of(*reading) == shade)
    };
    let mut path = String::new();
    for row in 0..rows {
        let y = PANEL.1 - (row + 1) as f64 * height;
        let mut column = 0;
        while column < bearings {
            let first = column;
            while column < bearings && has_shade(row, column) {
                column += 1;
            }
            if column > first {
                let (x, run) = (first as f64 * width, (column - first) as f64 * width);
                // Writing to a string can't fail.
                let _ = write!(
                    path,
                    "M{} {}h{}v{}h-{}z",
                    number(x),
                    number(y),
                    number(run),
                    number(height),
                    number(run)
                );
            } else {
                column += 1;
            }
        }
    }
    path
}

fn shade_of(reading: u16) -> u16 {
    // Even the smallest reading looks different from none.
    let shade = u32::from(reading.min(GREATEST)) * u32::from(SHADES - 1);
    shade.div_ceil(u32::from(GREATEST)) as u16
}

fn colour(shade: u16) -> String {
    ramp(&HEAT, f64::from(shade) / f64::from(SHADES - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shades_span_the_readings() {
        assert_eq!(shade_of(0), 0);
        assert_eq!(shade_of(1), 1);
        assert_eq!(shade_of(1023), SHADES - 1);
        assert_eq!(shade_of(u16::MAX), SHADES - 1);
    }

    #[test]
    fn a_reading_is_drawn_where_it_stands() {
        let mut table = SensorTable {
            class: "wall".into(),
            sensors: 5,
            rows: 2,
            bearings: 4,
            nearest: 5.0,
            spacing: 2.0,
            views: 2,
            readings: vec![0; 5 * 16],
        };
        // Nearest row, a quarter turn to the right.
        table.readings[5 + 3] = 1023;
        assert_eq!(cells_of(&table, 0, 3, SHADES - 1), "M150 65h50v65h-50z");
        assert_eq!(cells_of(&table, 0, 2, SHADES - 1), "");
        assert_eq!(cells_of(&table, 1, 3, SHADES - 1), "");
        // The same from the other point of view.
        table.readings[5 * (8 + 1) + 2] = 1023;
        assert_eq!(cells_of(&table, 1, 2, SHADES - 1), "M150 65h50v65h-50z");
    }
}
