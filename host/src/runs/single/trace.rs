//! A life as a table.

use std::fmt::Write;

use oneiro::batch::Record;

use crate::contents::{Column, head};
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
    head(columns())
}

/// The columns of a trace.
pub(super) fn columns() -> impl Iterator<Item = &'static Column> {
    std::iter::once(&CYCLE).chain(COLUMNS.iter().map(|(column, _)| column))
}

/// Lines of a trace, from that of the cycle `first` on.
pub(crate) fn trace_lines(trace: &[Record], first: u32, every: u32) -> String {
    let mut text = String::with_capacity(trace.len() * 240);
    for (record, index) in trace.iter().zip(0_u64..) {
        // Writing to a string can't fail.
        let _ = write!(text, "{}", u64::from(first) + index * u64::from(every));
        for (_, value) in &COLUMNS {
            let _ = write!(text, ",{}", value(record));
        }
        text.push('\n');
    }
    text
}

type Traced = (Column, fn(&Record) -> f32);

static CYCLE: Column = Column::whole("cycle", "100 ms", "its number, from 0");
/// Columns after `cycle`: the pose at the start of the cycle, the perceived activations, the outputs and their results, then
/// the activations before sensor noise and where they were sensed. New columns go at the end, since scripts may select
/// columns by position.
#[rustfmt::skip]
static COLUMNS: [Traced; 28] = [
    (Column::number("x_mm", "mm", "x at the start of the cycle"), |record| record.x),
    (Column::number("y_mm", "mm", "y at the start of the cycle"), |record| record.y),
    (Column::number("heading_turns", "turns", "the heading at the start of the cycle, counter-clockwise from the x axis"), |record| record.heading),
    (Column::number("sensor_0", "0 to 1", "the perceived activation of `left_90`, noise included"), |record| record.sensor_0),
    (Column::number("sensor_1", "0 to 1", "the perceived activation of `left_45`, noise included"), |record| record.sensor_1),
    (Column::number("sensor_2", "0 to 1", "the perceived activation of `left_10`, noise included"), |record| record.sensor_2),
    (Column::number("sensor_3", "0 to 1", "the perceived activation of `right_10`, noise included"), |record| record.sensor_3),
    (Column::number("sensor_4", "0 to 1", "the perceived activation of `right_45`, noise included"), |record| record.sensor_4),
    (Column::number("sensor_5", "0 to 1", "the perceived activation of `right_90`, noise included"), |record| record.sensor_5),
    (Column::number("sensor_6", "0 to 1", "the perceived activation of `back_right`, noise included"), |record| record.sensor_6),
    (Column::number("sensor_7", "0 to 1", "the perceived activation of `back_left`, noise included"), |record| record.sensor_7),
    (Column::number("output_left", "0 to 1", "the controller's output for the left wheel"), |record| record.left),
    (Column::number("output_right", "0 to 1", "the controller's output for the right wheel"), |record| record.right),
    (Column::number("speed_left", "-1 to 1", "the selected speed of the left wheel as a share of the greatest"), |record| record.speed_left),
    (Column::number("speed_right", "-1 to 1", "the selected speed of the right wheel as a share of the greatest"), |record| record.speed_right),
    (Column::number("collided", "", "1 if the cycle ended in a collision, else 0"), |record| record.collided),
    (Column::number("reward", "", "the reward of the cycle"), |record| record.reward),
    (Column::number("fitness", "", "the sum of the rewards up to and including this cycle"), |record| record.fitness),
    (Column::number("real_0", "0 to 1", "the activation of `left_90` before sensor noise"), |record| record.real_0),
    (Column::number("real_1", "0 to 1", "the activation of `left_45` before sensor noise"), |record| record.real_1),
    (Column::number("real_2", "0 to 1", "the activation of `left_10` before sensor noise"), |record| record.real_2),
    (Column::number("real_3", "0 to 1", "the activation of `right_10` before sensor noise"), |record| record.real_3),
    (Column::number("real_4", "0 to 1", "the activation of `right_45` before sensor noise"), |record| record.real_4),
    (Column::number("real_5", "0 to 1", "the activation of `right_90` before sensor noise"), |record| record.real_5),
    (Column::number("real_6", "0 to 1", "the activation of `back_right` before sensor noise"), |record| record.real_6),
    (Column::number("real_7", "0 to 1", "the activation of `back_left` before sensor noise"), |record| record.real_7),
    (Column::number("seen_x_mm", "mm", "x of the place where the activations were sensed, displaced by conservative noise"), |record| record.seen_x),
    (Column::number("seen_y_mm", "mm", "y of that place"), |record| record.seen_y),
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
