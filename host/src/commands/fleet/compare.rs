//! `oneiro fleet compare`: what a fleet or its twins did, beside the batched study.

use std::slice;

use oneiro_base::answer::Answer;
use oneiro_base::console::counted;
use oneiro_base::console::{Console, columns};
use oneiro_base::exit::Result;
use oneiro_fleet::fleet::compare::{Compared, Figures, LEVEL, batched, compare, of_directory};
use oneiro_fleet::fleet::file::Fleet;
use oneiro_lab::device;
use oneiro_report::numbers::fixed;
use serde_json::json;

use crate::cli::FleetCompare;
use crate::commands::places::found;

/// Compares records with batched runs of the fleet's experiment.
///
/// # Errors
/// Exit 3: the fleet's file, or a directory without a record; exit 4, 5 and 6.
pub(crate) fn run(arguments: &FleetCompare, console: Console) -> Result {
    let fleet = Fleet::read(&arguments.fleet)?;
    let plan = fleet.experiment.plan(fleet.seed);
    let directories = if arguments.records.is_empty() {
        slice::from_ref(&fleet.directory)
    } else {
        &arguments.records
    };
    let records: Vec<Figures> = directories
        .iter()
        .map(|directory| of_directory(&plan, &found(directory, &[], console)?))
        .collect::<Result<_>>()?;
    let plans: Vec<_> = arguments
        .seeds
        .clone()
        .map(|seed| fleet.experiment.plan(seed))
        .collect();
    let engine = arguments.backend.engine()?;
    let runs = batched(&plans, &engine)?;
    device::close(engine, console);
    let compared = compare(&records, &runs);
    let missed: u32 = records.iter().map(|run| run.missed).sum();
    let (name, seeds) = (fleet.experiment.name(), &arguments.seeds);
    let text = format!(
        "{name}: {} of the fleet ({} missed), {} (seeds {} to {})\n\n{}",
        counted(records.len(), "record", "records"),
        counted(missed, "interval of a robot", "intervals of robots"),
        counted(runs.len(), "batched run", "batched runs"),
        seeds.start(),
        seeds.end(),
        table(&compared)
    );
    let value = json!({
        "experiment": name,
        "level": LEVEL,
        "figures": compared,
        "fleet": records,
        "batched": runs,
    });
    console.print_answer(&Answer::new(text, value))
}

fn table(compared: &[Compared]) -> String {
    let head = ["mean ± sd", "fleet", "batched", "difference", "90 % interval"];
    let row = |own: &Compared| {
        let side = |[mean, spread]: [f64; 2]| {
            if spread.is_nan() {
                rounded(mean)
            } else {
                format!("{} ± {}", rounded(mean), rounded(spread))
            }
        };
        let more = |value: f64| {
            let (value, places, unit) = if own.is_share {
                (100.0 * value, 1, " %")
            } else {
                (value, 3, "")
            };
            let text = fixed(value, places);
            let sign = if text.starts_with('-') { "" } else { "+" };
            format!("{sign}{text}{unit}")
        };
        let interval = own.interval.map(|ends| ends.map(more).join(" to "));
        let unknown = || "none".to_owned();
        vec![
            own.figure.to_owned(),
            side(own.fleet),
            side(own.batched),
            own.difference.map_or_else(unknown, more),
            interval.unwrap_or_else(unknown),
        ]
    };
    columns(&head, &compared.iter().map(row).collect::<Vec<_>>())
}

/// Four digits or so.
fn rounded(value: f64) -> String {
    fixed(value, if value.abs() < 10.0 { 3 } else { 1 })
}
