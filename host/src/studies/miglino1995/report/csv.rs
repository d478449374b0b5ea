//! The numbers behind the figures, for readers who want to do their own statistics.

use crate::report::csv::{Csv, number};
use crate::studies::miglino1995::results::{Family, Level, Life, Results, Run};

/// Names and contents of the files: values of generations, of the individuals of the transferred generation and of the
/// last one, distances between paths in mm, and lives of the best individuals; and, if they were run, mean fitness of
/// each run with other last generations and in other simulators.
pub(crate) fn csv_files(results: &Results) -> Vec<(&'static str, String)> {
    let mut files = vec![
        ("generations.csv", generations(results)),
        ("transferred.csv", transferred(results)),
        ("last.csv", last(results)),
        ("discrepancy.csv", discrepancy(results)),
        ("champions.csv", champions(results)),
    ];
    if results.runs.iter().any(|run| run.controls.is_some()) {
        files.push(("controls.csv", controls(results)));
    }
    if !results.variants.is_empty() {
        files.push(("variants.csv", variants(results)));
    }
    files
}

/// Adds a row of a run.
fn row(table: &mut Csv, run: &Run, fields: impl IntoIterator<Item = String>) {
    let whose = [run.condition.name().to_owned(), run.number.to_string()];
    table.row(whose.into_iter().chain(fields));
}

/// An entry of a list that may be too short for the row; empty beyond its end.
fn entry<T: Copy + Into<f64>>(values: &[T], i: usize) -> String {
    values.get(i).map_or(String::new(), |&value| number(value.into()))
}

fn generations(results: &Results) -> String {
    let mut table = Csv::new("condition,run,generation,environment,peak,average".split(','));
    for run in &results.runs {
        let simulated = run
            .simulated
            .iter()
            .enumerate()
            .map(|(i, level)| (i, "simulation", level));
        let first = results.simulated_generations as usize;
        let real = run
            .real
            .iter()
            .enumerate()
            .map(|(i, level)| (first + i, "reality", level));
        for (generation, environment, level) in simulated.chain(real) {
            let values = [number(level.peak), number(level.average)];
            row(
                &mut table,
                run,
                [generation.to_string(), environment.to_owned()]
                    .into_iter()
                    .chain(values),
            );
        }
    }
    table.text()
}

fn transferred(results: &Results) -> String {
    let mut table =
        Csv::new("condition,run,individual,simulated,simulated_again,quiet,real,real_again,other_robot".split(','));
    for run in &results.runs {
        let lives = &run.transferred;
        let columns = [
            &lives.simulated,
            &lives.simulated_again,
            &lives.quiet,
            &lives.real,
            &lives.real_again,
            &lives.other_robot,
        ];
        for i in 0..columns.iter().map(|column| column.len()).max().unwrap_or(0) {
            let values = columns.iter().map(|column| entry(column, i));
            row(&mut table, run, std::iter::once(i.to_string()).chain(values));
        }
    }
    table.text()
}

fn last(results: &Results) -> String {
    let mut table = Csv::new("condition,run,individual,real".split(','));
    for run in &results.runs {
        for i in 0..run.last.len() {
            row(&mut table, run, [i.to_string(), entry(&run.last, i)]);
        }
    }
    table.text()
}

fn discrepancy(results: &Results) -> String {
    let mut table = Csv::new("condition,run,k,cycle,paper,starts,repeated,unrelated".split(','));
    for run in &results.runs {
        let sums = &run.champion.discrepancy;
        let columns = [&sums.paper, &sums.starts, &sums.repeated, &sums.unrelated];
        for i in 0..columns.iter().map(|column| column.len()).max().unwrap_or(0) {
            let place = [(i + 1).to_string(), (5 * (i + 1)).to_string()];
            let values = columns.iter().map(|column| entry(column, i));
            row(&mut table, run, place.into_iter().chain(values));
        }
    }
    table.text()
}

fn champions(results: &Results) -> String {
    const MEASURES: [&str; 7] = [
        "fitness",
        "collided",
        "forwards",
        "visited",
        "speed",
        "length",
        "stuck_in_corner",
    ];
    let who = ["condition", "run", "seed", "individual", "discrepancy_per_length"];
    let lives = ["simulated", "real"].map(|environment| MEASURES.map(|measure| format!("{environment}_{measure}")));
    let mut table = Csv::new(who.map(str::to_owned).into_iter().chain(lives.concat()));
    let values = |life: &Life| {
        [
            f64::from(life.fitness),
            life.collided,
            life.forwards,
            life.visited,
            life.speed,
            life.length,
            f64::from(u8::from(life.stuck_in_corner)),
        ]
        .map(number)
    };
    for run in &results.runs {
        let champion = &run.champion;
        let who = [
            run.seed.to_string(),
            champion.individual.to_string(),
            number(champion.discrepancy.per_length),
        ];
        let lives = values(&champion.simulated).into_iter().chain(values(&champion.real));
        row(&mut table, run, who.into_iter().chain(lives));
    }
    table.text()
}

fn controls(results: &Results) -> String {
    let mut table = Csv::new("condition,run,first,last,simulated_on,neutral,from_random".split(','));
    for run in &results.runs {
        let Some(controls) = &run.controls else { continue };
        let level = |level: Option<&Level>| level.map_or(String::new(), |level| number(level.average));
        row(
            &mut table,
            run,
            [
                level(run.real.first()),
                level(run.real.last()),
                number(controls.simulated_on),
                number(controls.neutral),
                number(controls.from_random),
            ],
        );
    }
    table.text()
}

fn variants(results: &Results) -> String {
    // All names are quoted, including those without a comma.
    let mut table = Csv::quoted_already("family,name,value,run,simulated,real".split(','));
    for variant in &results.variants {
        let family = match variant.family {
            Family::SensorRange => "sensor_range",
            Family::WalkRange => "walk_range",
            Family::Displacement => "displacement",
            Family::Simulator => "simulator",
        };
        for run in 0..variant.simulated.len().max(variant.real.len()) {
            let fields = [
                family.to_owned(),
                format!("\"{}\"", variant.name.replace('"', "\"\"")),
                number(variant.value),
                run.to_string(),
                entry(&variant.simulated, run),
                entry(&variant.real, run),
            ];
            table.row(fields);
        }
    }
    table.text()
}
