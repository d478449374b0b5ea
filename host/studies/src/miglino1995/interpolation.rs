//! Refinement of sampled tables. A simulator looks its tables up by truncation; with enough interpolated points in
//! between, that approximates interpolation at every lookup.

use oneiro::tables::{SensorTable, SensorTables};

/// Points of the finer table per sample, in distance and in bearing: 0.5 mm and 0.5 degrees if samples are 2 mm and 2
/// degrees apart.
const FINER: u32 = 4;

/// Refines tables to [`FINER`] times the rows and bearings by bilinear interpolation. Sampled points keep their
/// readings, and points of view aren't mixed. Beyond the last row, where there is no next sample to interpolate to, its
/// readings hold as far as before.
pub(crate) fn interpolate(tables: &SensorTables) -> SensorTables {
    SensorTables {
        classes: tables.classes.iter().map(finer).collect(),
        ..tables.clone()
    }
}

fn finer(table: &SensorTable) -> SensorTable {
    let (rows, bearings) = (table.rows * FINER, table.bearings * FINER);
    let rows_of_views = (0..table.views).flat_map(|view| (0..rows).map(move |row| (view, row)));
    let cells = rows_of_views.flat_map(|(view, row)| (0..bearings).map(move |bearing| (view, row, bearing)));
    SensorTable {
        rows,
        bearings,
        spacing: table.spacing / FINER as f32,
        readings: cells
            .flat_map(|(view, row, bearing)| between(table, view, row, bearing))
            .collect(),
        ..table.clone()
    }
}

/// Readings from one point of view at a point of the finer table: the mean of the four surrounding samples, weighted by
/// proximity. Computed in integers and rounded once, halves up: the same on all machines.
fn between(table: &SensorTable, view: u32, row: u32, bearing: u32) -> impl Iterator<Item = u16> {
    let here = [row / FINER, bearing / FINER];
    let next = [(here[0] + 1).min(table.rows - 1), (here[1] + 1) % table.bearings];
    let past = [row % FINER, bearing % FINER];
    let sample = |row: u32, bearing: u32| {
        let row = view * table.rows + row;
        table.cell((row * table.bearings + bearing) as usize)
    };
    let around = [
        (sample(here[0], here[1]), (FINER - past[0]) * (FINER - past[1])),
        (sample(here[0], next[1]), (FINER - past[0]) * past[1]),
        (sample(next[0], here[1]), past[0] * (FINER - past[1])),
        (sample(next[0], next[1]), past[0] * past[1]),
    ];
    (0..table.sensors as usize).map(move |sensor| {
        let sum: u32 = around
            .iter()
            .map(|(readings, weight)| u32::from(readings[sensor]) * weight)
            .sum();
        ((sum + FINER * FINER / 2) / (FINER * FINER)) as u16
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three rows of four bearings with distinct readings.
    fn table() -> SensorTable {
        let reading = |cell: u16, sensor: u16| (cell * 83 + sensor * 11) % 1024;
        SensorTable {
            class: "wall".into(),
            sensors: 8,
            rows: 3,
            bearings: 4,
            nearest: 5.0,
            spacing: 2.0,
            views: 1,
            readings: (0..96).map(|at| reading(at / 8, at % 8)).collect(),
        }
    }

    #[test]
    fn points_that_were_sampled_keep_their_readings() {
        let sampled = SensorTables::khepera();
        for (table, finer) in sampled.classes.iter().zip(interpolate(&sampled).classes) {
            assert_eq!((finer.rows, finer.bearings), (80, 720));
            assert_eq!((finer.nearest, finer.spacing), (5.0, 0.5));
            assert_eq!(finer.reach().to_bits(), table.reach().to_bits());
            for row in 0..20 {
                for bearing in 0..180 {
                    assert_eq!(
                        finer.cell(4 * row * 720 + 4 * bearing),
                        table.cell(row * 180 + bearing),
                        "row {row}, bearing {bearing}"
                    );
                }
            }
        }
    }

    #[test]
    fn between_them_readings_change_in_proportion() {
        let table = table();
        let finer = finer(&table);
        let at = |row: usize, bearing: usize| finer.cell(row * 16 + bearing)[0];
        // The corners of the first square are 0 and 83, and in the next row 332 and 415.
        assert_eq!([at(0, 0), at(0, 1), at(0, 2), at(0, 3), at(0, 4)], [0, 21, 42, 62, 83]);
        assert_eq!([at(1, 0), at(2, 0), at(3, 0), at(4, 0)], [83, 166, 249, 332]);
        assert_eq!(at(2, 2), 208, "the mean of all four, 207.5, rounded");
    }

    #[test]
    fn points_of_view_stay_apart() {
        let one = table();
        let other = SensorTable {
            readings: one.readings.iter().map(|reading| reading / 2).collect(),
            ..one.clone()
        };
        let both = SensorTable {
            views: 2,
            readings: [&one, &other].map(|table| table.readings.clone()).concat(),
            ..one.clone()
        };
        let readings = [&one, &other].map(|table| finer(table).readings).concat();
        assert_eq!(finer(&both).readings, readings);
    }

    #[test]
    fn bearings_close_the_turn_and_the_last_row_holds() {
        let table = table();
        let finer = finer(&table);
        let at = |row: usize, bearing: usize| finer.cell(row * 16 + bearing)[0];
        // Wraps from the last bearing, 249, to the first, 0.
        assert_eq!([at(0, 12), at(0, 14), at(0, 15)], [249, 125, 62]);
        for row in 9..12 {
            assert_eq!(at(row, 0), at(8, 0), "row {row}");
        }
    }
}
