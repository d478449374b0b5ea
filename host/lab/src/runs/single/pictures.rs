//! Pictures of a finished run: its champion's life and its learning curve.

use oneiro::batch::{Record, Trace};
use oneiro_evolve::Champion;
use oneiro_report::figures::{self, Series};

use super::rows::Row;
use super::trace::{TraceTable, trace_every};
use super::{LEARNING_CURVE, PATH, TRACE};
use crate::experiment::Experiment;

/// Files with the trace of the champion's life and its path, if it was traced, and the learning curve.
pub(super) fn all(
    experiment: &Experiment,
    seed: u64,
    champion: &Champion,
    trace: Option<&Trace>,
    rows: &[Row],
) -> Vec<(&'static str, Vec<u8>)> {
    let every = trace_every(experiment);
    let mut files = Vec::new();
    if let Some(trace) = trace {
        let table = TraceTable::new(experiment.world()).csv(trace, every);
        files.push((TRACE, table.into_bytes()));
        files.push((PATH, path_svg(experiment, seed, champion, trace, every).into_bytes()));
    }
    files.push((LEARNING_CURVE, learning_curve_svg(experiment, seed, rows).into_bytes()));
    files
}

fn path_svg(experiment: &Experiment, seed: u64, champion: &Champion, trace: &[Record], every: u32) -> String {
    let world = experiment.world().spec();
    let Champion {
        generation, individual, ..
    } = champion;
    let name = experiment.name();
    let title = format!("{name}, seed {seed}: individual {individual} of generation {generation}");
    figures::life(&world.arena, world.robot.body_radius, &title, trace, every)
}

fn learning_curve_svg(experiment: &Experiment, seed: u64, rows: &[Row]) -> String {
    let series = |label, value: fn(&Row) -> f64| Series {
        label,
        values: rows.iter().map(value).collect(),
    };
    let title = format!("{}, seed {seed}", experiment.name());
    let peak = format!("mean of the best {}", experiment.settings().evolution.best());
    figures::learning_curve(
        &title,
        "fitness",
        &[
            series("best", |row| f64::from(row.best)),
            series(&peak, |row| row.peak),
            series("mean", |row| row.mean),
        ],
    )
}
