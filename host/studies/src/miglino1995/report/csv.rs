//! The figures' numbers, for readers' statistics.

use oneiro_base::contents::{Column, Entry};
use oneiro_report::csv::{Csv, known, number};

use crate::miglino1995::results::{Discrepancy, Family, Level, MeasuredEpisode, Results, Run};

static CONDITION: Column = Column::text("condition", "the simulator's noise: `none`, `sensor` or `conservative`");
static RUN: Column = Column::whole("run", "", "the run's number within its condition, from 0");

static GENERATIONS: [Column; 4] = [
    Column::whole("generation", "", "its number, from 0"),
    Column::text("environment", "where it ran: `simulation` or `reality`"),
    Column::number("peak", "", "the mean fitness of the best, those that become parents"),
    Column::number("average", "", "the mean fitness of all"),
];
static TRANSFERRED: [Column; 7] = [
    Column::whole("individual", "", "its index in the generation"),
    Column::number(
        "simulated",
        "",
        "its fitness in simulation, with the noise it evolved with",
    ),
    Column::number(
        "simulated_again",
        "",
        "its fitness in another simulated episode, from another start",
    ),
    Column::number("quiet", "", "its fitness in simulation without noise"),
    Column::number("real", "", "its fitness in reality"),
    Column::number(
        "real_again",
        "",
        "its fitness in another real episode, from another start",
    ),
    Column::number(
        "other_robot",
        "",
        "its fitness in another robot of the same kind; empty for a connected robot, of which there is one",
    ),
];
static LAST: [Column; 2] = [
    Column::whole("individual", "", "its index in the generation"),
    Column::number("real", "", "its fitness in reality"),
];
static DISCREPANCY: [Column; 6] = [
    Column::whole("k", "", "the number of distances summed"),
    Column::whole("cycle", "100 ms", "the cycle of the last distance, 5 k"),
    Column::number(
        "paper",
        "mm",
        "the sum of distances between the simulated and the real path, from the start that all share",
    ),
    Column::number(
        "starts",
        "mm",
        "the same sum, mean over 100 other starts; like the next two empty for a connected robot, which a person would have to put there",
    ),
    Column::number(
        "repeated",
        "mm",
        "the sum between two real paths from one start, mean over the 100 starts",
    ),
    Column::number(
        "unrelated",
        "mm",
        "the sum between the simulated path and the real path of another run's champion, mean over the 100 starts",
    ),
];
static CHAMPIONS: [Column; 3] = [
    Column::whole("seed", "", "the run's seed"),
    Column::whole("individual", "", "the champion's index in the generation"),
    Column::number(
        "discrepancy_per_length",
        "",
        "the last `starts` in `discrepancy.csv` divided by the length of the simulated path, each summed over the 100 starts; empty as \
         `starts` is",
    ),
];
/// Of the champion's episode in each environment.
static MEASURES: [Column; 7] = [
    Column::number("fitness", "", "its fitness"),
    Column::number(
        "collided",
        "0 to 1",
        "the fraction of cycles that end in a collision; empty for a connected robot, which reports none",
    ),
    Column::number(
        "forwards",
        "0 to 1",
        "the fraction of cycles in which both wheels turn forwards",
    ),
    Column::number(
        "visited",
        "0 to 1",
        "the fraction of the arena's free cells of 50 mm that it visits",
    ),
    Column::number(
        "speed",
        "0 to 1",
        "the wheels' mean absolute speed as a fraction of the maximum",
    ),
    Column::number("length", "mm", "the length of the path"),
    Column::whole(
        "stuck_in_corner",
        "",
        "1 if it spends its last 100 cycles within 100 mm of a corner and goes less than 50 mm in them, else 0",
    ),
];
static CONTROLS: [Column; 5] = [
    Column::number("first", "", "the mean real fitness of the first generation in reality"),
    Column::number("last", "", "the mean real fitness of the last generation in reality"),
    Column::number(
        "simulated_on",
        "",
        "the same if the generations in reality are replaced by as many in simulation",
    ),
    Column::number("neutral", "", "the same if parents in reality are drawn at random"),
    Column::number(
        "from_random",
        "",
        "the same if evolution in reality starts from random genes",
    ),
];
static VARIANTS: [Column; 6] = [
    Column::text(
        "family",
        "the family of the simulator: `sensor_range`, `walk_range`, `displacement` or `simulator`",
    ),
    Column::text("name", "how the simulator differs"),
    Column::number(
        "value",
        "",
        "the upper end of a sensor noise, or the range or the maximum step of a walk in mm; else 0",
    ),
    Column::whole("run", "", "the run's number, from 0"),
    Column::number(
        "simulated",
        "",
        "the mean simulated fitness of the transferred generation",
    ),
    Column::number("real", "", "its mean real fitness"),
];

/// The columns that identify a row's run, and others.
fn of_run(others: &[Column]) -> Vec<Column> {
    [&[CONDITION.clone(), RUN.clone()], others].concat()
}

fn columns_of_champions() -> Vec<Column> {
    let episodes = ["simulated", "real"].map(|environment| {
        MEASURES.clone().map(|measure| {
            let about = format!("of its {environment} episode: {}", measure.words());
            let name = format!("{environment}_{}", measure.name);
            measure.named(name).about(about)
        })
    });
    of_run(&[&CHAMPIONS[..], &episodes.concat()].concat())
}

/// The files of numbers; two of them only for a full study.
pub(crate) fn contents(is_full: bool) -> Vec<Entry> {
    let table = |name, about, columns: &[Column]| Entry::table(name, about, &of_run(columns));
    let mut all = vec![
        table("generations.csv", "one row per generation of each run", &GENERATIONS),
        table(
            "transferred.csv",
            "one row per individual of the generation transferred to reality",
            &TRANSFERRED,
        ),
        table(
            "last.csv",
            "one row per individual of the last generation in reality",
            &LAST,
        ),
        table(
            "discrepancy.csv",
            "the distance between the champions' simulated and real paths",
            &DISCREPANCY,
        ),
        Entry::table(
            "champions.csv",
            "one row per run: the episodes of its champion, the best of the transferred generation",
            &columns_of_champions(),
        ),
    ];
    if is_full {
        let controls = "with `--full`: one row per run, with controls for what else could have raised real fitness";
        all.push(table("controls.csv", controls, &CONTROLS));
        let variants = "with `--full`: one row per run in other simulators";
        all.push(Entry::table("variants.csv", variants, &VARIANTS));
    }
    all
}

/// Names and contents of the files that [`contents()`] describes, if they were run.
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
    let mut table = Csv::new(&of_run(&GENERATIONS));
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
    let mut table = Csv::new(&of_run(&TRANSFERRED));
    for run in &results.runs {
        let episodes = &run.transferred;
        let columns = [
            &episodes.simulated,
            &episodes.simulated_again,
            &episodes.quiet,
            &episodes.real,
            &episodes.real_again,
            &episodes.other_robot,
        ];
        for i in 0..columns.iter().map(|column| column.len()).max().unwrap_or(0) {
            let values = columns.iter().map(|column| entry(column, i));
            row(&mut table, run, std::iter::once(i.to_string()).chain(values));
        }
    }
    table.text()
}

fn last(results: &Results) -> String {
    let mut table = Csv::new(&of_run(&LAST));
    for run in &results.runs {
        for i in 0..run.last.len() {
            row(&mut table, run, [i.to_string(), entry(&run.last, i)]);
        }
    }
    table.text()
}

fn discrepancy(results: &Results) -> String {
    let mut table = Csv::new(&of_run(&DISCREPANCY));
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
    let mut table = Csv::new(&columns_of_champions());
    let values = |episode: &MeasuredEpisode| {
        [
            f64::from(episode.fitness),
            episode.collided,
            episode.forwards,
            episode.visited,
            episode.speed,
            episode.length,
            f64::from(u8::from(episode.stuck_in_corner)),
        ]
        .map(known)
    };
    for run in &results.runs {
        let champion = &run.champion;
        let who = [
            run.seed.to_string(),
            champion.individual.to_string(),
            known(Discrepancy::per_length([&champion.discrepancy])),
        ];
        let episodes = values(&champion.simulated).into_iter().chain(values(&champion.real));
        row(&mut table, run, who.into_iter().chain(episodes));
    }
    table.text()
}

fn controls(results: &Results) -> String {
    let mut table = Csv::new(&of_run(&CONTROLS));
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
    let mut table = Csv::quoted_already(&VARIANTS);
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
