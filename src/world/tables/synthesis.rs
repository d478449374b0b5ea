//! Synthesises the built-in Khepera from published statistics of a real one's recordings. It uses only exactly rounded
//! operations, so that every machine makes the same integers.
//!
//! A sensor's reading of an object at distance d and bearing b from its own axis is `clip(1.5 / (1 + 2 exp((d -
//! reach(b)) / fade))) * 1023`, a logistic that is clipped where the sensor saturates, with a reach that falls off like
//! a cosine. So the reading is one half at the reach. On the axis the reach is published; off the axis it follows from
//! the published angles over which the reading is at least one half at 9, 15 and 21 mm, and is linear in `cos b`
//! between these points. The fade follows from the distance on the axis at which the reading has fallen to 5 %.

use super::{GREATEST_READING, SENSORS, SensorTable};
use crate::exact::{cosine, exponential};
use crate::random::pcg4d;

/// Response of one sensor to one class of object.
pub(super) struct Response {
    /// Distance on the axis at which the reading is 50 % of the maximum, mm.
    pub(super) half: f64,
    /// Distance on the axis at which it is 5 %, mm.
    pub(super) twentieth: f64,
    /// Angles over which it is at least 50 % at [`WIDTHS_AT`], degrees.
    pub(super) widths: [f64; 3],
}

/// Distances of the widths, mm.
pub(super) const WIDTHS_AT: [f64; 3] = [9.0, 15.0, 21.0];

/// Directions of the sensors, degrees clockwise from the heading, left 90 first.
pub(super) const BEARINGS: [f64; SENSORS] = [-69.0, -42.0, -7.0, 15.0, 44.0, 75.0, 169.0, -166.0];

const fn response(half: f64, twentieth: f64, widths: [f64; 3]) -> Response {
    Response {
        half,
        twentieth,
        widths,
    }
}

/// Statistics of a wall.
pub(super) const WALL: [Response; SENSORS] = [
    response(24.5, 34.2, [96.0, 74.0, 46.0]),
    response(24.4, 36.1, [92.0, 72.0, 42.0]),
    response(23.5, 32.6, [88.0, 66.0, 24.0]),
    response(20.2, 29.1, [76.0, 52.0, 0.0]),
    response(25.9, 35.3, [96.0, 76.0, 48.0]),
    response(29.5, 43.0, [106.0, 90.0, 70.0]),
    response(23.8, 35.2, [92.0, 68.0, 32.0]),
    response(29.4, 43.0, [112.0, 92.0, 68.0]),
];

/// Statistics of a round obstacle of 27 mm radius.
pub(super) const ROUND: [Response; SENSORS] = [
    response(19.9, 26.2, [58.0, 32.0, 0.0]),
    response(19.9, 26.6, [54.0, 34.0, 0.0]),
    response(18.4, 24.7, [52.0, 30.0, 0.0]),
    response(15.5, 21.9, [48.0, 12.0, 0.0]),
    response(20.7, 26.9, [54.0, 38.0, 0.0]),
    response(23.1, 33.2, [64.0, 48.0, 24.0]),
    response(18.5, 24.9, [52.0, 32.0, 0.0]),
    response(23.1, 32.7, [64.0, 48.0, 22.0]),
];

/// Makes a table in the shape of the recordings: 20 rows from 5 mm in steps of 2 mm, 180 bearings.
pub(super) fn table(class: &str, responses: &[Response; SENSORS]) -> SensorTable {
    let (rows, bearings) = (20, 180);
    let readings = (0..rows * bearings)
        .flat_map(|cell| {
            let distance = 5.0 + 2.0 * f64::from(cell / bearings);
            let bearing = 2.0 * f64::from(cell % bearings);
            (0..SENSORS).map(move |sensor| {
                let share = share(&responses[sensor], distance, bearing - BEARINGS[sensor]);
                let word = pcg4d([cell, sensor as u32, class.len() as u32, 0])[3];
                let reading = (share * f64::from(GREATEST_READING) + 0.5).floor() as u16 + background(word);
                reading.min(GREATEST_READING)
            })
        })
        .collect();
    SensorTable {
        class: class.into(),
        sensors: SENSORS as u32,
        rows,
        bearings,
        nearest: 5.0,
        spacing: 2.0,
        views: 1,
        readings,
    }
}

/// Reading as a fraction of the maximum; `off_axis` in degrees.
fn share(response: &Response, distance: f64, off_axis: f64) -> f64 {
    // The logistic falls from 1/2 to 1/20 where 2 exp(x) grows from 2 to 29.
    const LOGARITHM_OF_29_HALVES: f64 = 2.674_148_649_426_529;
    let fade = (response.twentieth - response.half) / LOGARITHM_OF_29_HALVES;
    let reach = reach(response, 1.0 - cosine(off_axis));
    (1.5 / (1.0 + 2.0 * exponential((distance - reach) / fade))).min(1.0)
}

/// Distance in mm at which the reading is one half, at an angle off the axis whose cosine is 1 - `fall`.
fn reach(response: &Response, fall: f64) -> f64 {
    let mut near = (0.0, response.half);
    let mut slope = 0.0;
    for (width, at) in response
        .widths
        .into_iter()
        .zip(WIDTHS_AT)
        .rev()
        .filter(|(width, _)| *width > 0.0)
    {
        let far = (1.0 - cosine(width / 2.0), at);
        slope = (far.1 - near.1) / (far.0 - near.0);
        if fall < far.0 {
            break;
        }
        near = far;
    }
    near.1 + slope * (fall - near.0)
}

/// Reading without an object: half the time 0, else 1 to 10, so 2.75 on average with a standard deviation of 3.42.
fn background(word: u32) -> u16 {
    let of_twenty = (u64::from(word) * 20) >> 32;
    of_twenty.saturating_sub(9) as u16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::tables::{Format, SensorTables, sam};

    #[test]
    fn committed_tables_are_the_synthesised_ones() {
        let committed = SensorTables::khepera();
        for (class, responses) in [("wall", &WALL), ("round", &ROUND)] {
            let index = committed.class(class).unwrap();
            assert_eq!(
                committed.classes[index],
                table(class, responses),
                "{class}: `cargo test -p oneiro write_tables -- --ignored` writes the files anew"
            );
        }
    }

    #[test]
    #[ignore = "writes the committed tables"]
    fn write_tables() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/world/tables/khepera");
        for (class, responses) in [("wall", &WALL), ("round", &ROUND)] {
            let path = folder.join(format!("{class}.sam"));
            std::fs::write(path, sam::print_sensors(&table(class, responses), Format::Sam)).unwrap();
        }
    }

    /// Distance at which a sensor's readings, along its axis, fall below a level.
    fn falls_through(table: &SensorTable, sensor: usize, level: f64) -> f64 {
        let bearing = (BEARINGS[sensor] / 2.0 + 180.5).floor() as usize % 180;
        let reading = |row: usize| f64::from(table.cell(row * 180 + bearing)[sensor]);
        let row = (0..19)
            .rfind(|&row| reading(row) >= level && reading(row + 1) < level)
            .unwrap();
        5.0 + 2.0 * (row as f64 + (reading(row) - level) / (reading(row) - reading(row + 1)))
    }

    #[test]
    fn moments_are_the_published_ones() {
        for (class, responses) in [("wall", &WALL), ("round", &ROUND)] {
            let table = table(class, responses);
            let greatest = f64::from(GREATEST_READING);
            for (sensor, response) in responses.iter().enumerate() {
                // Rows are 2 mm apart, and readings include a background of up to 10.
                let half = falls_through(&table, sensor, 0.5 * greatest);
                assert!(
                    (half - response.half).abs() < 0.5,
                    "{class} {sensor}: 50 % at {half} mm"
                );
                // The last row is at 43 mm, where two sensors have just fallen to 5 %.
                if response.twentieth < 43.0 {
                    let twentieth = falls_through(&table, sensor, 0.05 * greatest);
                    assert!(
                        (twentieth - response.twentieth).abs() < 1.0,
                        "{class} {sensor}: 5 % at {twentieth} mm"
                    );
                }
                // Bearings are 2 degrees apart at both ends of the width.
                for (width, at) in response.widths.into_iter().zip(WIDTHS_AT) {
                    let row = ((at - 5.0) / 2.0) as usize;
                    let reads_half = |cell: &usize| f64::from(table.cell(*cell)[sensor]) >= 0.5 * greatest;
                    let measured = 2.0 * (row * 180..(row + 1) * 180).filter(reads_half).count() as f64;
                    assert!(
                        (measured - width).abs() <= 4.0,
                        "{class} {sensor}: {measured} degrees at {at} mm, not {width}"
                    );
                }
            }
        }
    }

    #[test]
    fn sensors_saturate_as_published() {
        let wall = table("wall", &WALL);
        for sensor in 0..SENSORS {
            let saturates = falls_through(&wall, sensor, f64::from(GREATEST_READING));
            assert!((15.0..=23.0).contains(&saturates), "{sensor}: to {saturates} mm");
        }
    }

    #[test]
    fn background_is_as_published() {
        // More than 90 degrees off its axis, a sensor sees nothing in the far rows.
        let wall = table("wall", &WALL);
        let mut readings = Vec::new();
        for cell in 10 * 180..20 * 180 {
            for (sensor, bearing) in BEARINGS.into_iter().enumerate() {
                if cosine(2.0 * (cell % 180) as f64 - bearing) < 0.0 {
                    readings.push(f64::from(wall.cell(cell)[sensor]));
                }
            }
        }
        let count = readings.len() as f64;
        let mean = readings.iter().sum::<f64>() / count;
        let variance = readings
            .iter()
            .map(|reading| (reading - mean) * (reading - mean))
            .sum::<f64>()
            / count;
        assert!((mean - 2.7).abs() < 0.1, "mean {mean}");
        assert!((variance.sqrt() - 3.4).abs() < 0.1, "s.d. {}", variance.sqrt());
        assert!(readings.iter().all(|&reading| reading <= 13.0));
    }
}
