//! A life as a table.

use std::fmt::Write;

use oneiro::batch::Record;

use crate::experiment::Experiment;

/// Cycles from one record of a champion's trace to the next: a long life is traced less often.
pub(super) fn trace_every(experiment: &Experiment) -> u32 {
    const LONGEST: u32 = 10_000;
    experiment.world().cycles().div_ceil(LONGEST)
}

/// A trace with a record each `every` cycles as CSV: a line a record.
pub(crate) fn trace_csv(trace: &[Record], every: u32) -> String {
    trace_head() + &trace_lines(trace, 0, every)
}

/// The names of the columns.
pub(crate) fn trace_head() -> String {
    let names: Vec<&str> = std::iter::once("cycle")
        .chain(COLUMNS.iter().map(|(name, _)| *name))
        .collect();
    names.join(",") + "\n"
}

/// Lines of a trace, from that of the cycle `first` on.
pub(crate) fn trace_lines(trace: &[Record], first: u32, every: u32) -> String {
    let mut text = String::with_capacity(trace.len() * 240);
    for (record, index) in trace.iter().zip(0_u64..) {
        // Writing to a string can't fail.
        let _ = write!(text, "{}", u64::from(first) + index * u64::from(every));
        for (_, value) in COLUMNS {
            let _ = write!(text, ",{}", value(record));
        }
        text.push('\n');
    }
    text
}

type Column = (&'static str, fn(&Record) -> f32);

/// The pose at the start of a cycle, what was perceived there, and what came of it; then the readings without sensor noise
/// and the place that they are from. Programs may count columns, so new ones come last.
const COLUMNS: [Column; 28] = [
    ("x_mm", |record| record.x),
    ("y_mm", |record| record.y),
    ("heading_turns", |record| record.heading),
    ("sensor_0", |record| record.sensor_0),
    ("sensor_1", |record| record.sensor_1),
    ("sensor_2", |record| record.sensor_2),
    ("sensor_3", |record| record.sensor_3),
    ("sensor_4", |record| record.sensor_4),
    ("sensor_5", |record| record.sensor_5),
    ("sensor_6", |record| record.sensor_6),
    ("sensor_7", |record| record.sensor_7),
    ("output_left", |record| record.left),
    ("output_right", |record| record.right),
    ("speed_left", |record| record.speed_left),
    ("speed_right", |record| record.speed_right),
    ("collided", |record| record.collided),
    ("reward", |record| record.reward),
    ("fitness", |record| record.fitness),
    ("real_0", |record| record.real_0),
    ("real_1", |record| record.real_1),
    ("real_2", |record| record.real_2),
    ("real_3", |record| record.real_3),
    ("real_4", |record| record.real_4),
    ("real_5", |record| record.real_5),
    ("real_6", |record| record.real_6),
    ("real_7", |record| record.real_7),
    ("seen_x_mm", |record| record.seen_x),
    ("seen_y_mm", |record| record.seen_y),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_a_record() {
        let record = Record {
            x: 1.5,
            fitness: 0.1,
            seen_y: 7.25,
            ..Record::default()
        };
        let text = trace_csv(&[Record::default(), record], 5);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].starts_with("cycle,x_mm,") && lines[0].ends_with(",seen_x_mm,seen_y_mm"));
        assert_eq!(
            lines[2],
            "5,1.5,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0.1,0,0,0,0,0,0,0,0,0,7.25"
        );
        assert!(lines.iter().all(|line| line.split(',').count() == 29));
    }
}
