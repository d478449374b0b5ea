//! The figures' numbers, for readers' statistics.

use oneiro_base::contents::{Column, Entry};
use oneiro_lab::swarm::tables::INTERVALS_COLUMNS;
use oneiro_report::csv::{Csv, known, number};

use super::measures::{BIN, G0, G1, MINUTE, S0, at_the_end, intervals, level, robots_at, runs_of, shares, total};
use super::{name, questions};
use crate::odowd2014::results::{Case, Combination, Kind, Results, Run};

static WHOSE: [Column; 4] = [
    Column::number("scale", "", "the standard deviation of mutations"),
    Column::text(
        "credit",
        "the simulator that a robot's fitness is credited to: `lagged` or `matched`",
    ),
    Column::text("case", "where the light is, as `swarm.case` has it"),
    Column::text("kind", "the evolution, `evolved`, or one of the controls"),
];
static RUN: Column = Column::whole("run", "", "the run's number within its case and kind, from 0");
static RUNS: [Column; 9] = [
    Column::whole("brought", "items", "food that all robots brought"),
    Column::whole("first_half", "items", "food brought before the light moves"),
    Column::whole("second_half", "items", "food brought after that"),
    Column::number(
        "s0_opposite",
        "0 to 1",
        "in the last ten minutes: the fraction of simulators with the light opposite the nest",
    ),
    Column::number(
        "s0_no_light",
        "0 to 1",
        "in the last ten minutes: the fraction of simulators without a light",
    ),
    Column::number(
        "s0_over",
        "0 to 1",
        "in the last ten minutes: the fraction of simulators with the light over the nest",
    ),
    Column::number(
        "s0",
        "0 to 0.99",
        "in the last ten minutes: the mean gene of simulators",
    ),
    Column::number(
        "g0",
        "0 to 0.99",
        "in the last ten minutes: the mean gene of the behaviour with food",
    ),
    Column::number(
        "g1",
        "0 to 0.99",
        "in the last ten minutes: the mean gene of the behaviour without food",
    ),
];
static RATES: [Column; 4] = [
    Column::whole("from", "s", "the beginning of the bin"),
    Column::whole("to", "s", "its end"),
    Column::whole("brought", "items", "food that all robots brought in it"),
    Column::number("per_minute", "items a minute", "food brought per minute of the bin"),
];
static INTERVAL: Column = Column::whole("interval", "", "its number, from 0");
static GENES: [Column; 7] = [
    Column::whole(
        "robots",
        "",
        "the number of robots of all runs in this interval; the columns below are computed from these",
    ),
    Column::number("s0_mean", "0 to 0.99", "the mean gene of simulators"),
    Column::number("s0_sd", "", "its standard deviation"),
    Column::number("g0_mean", "0 to 0.99", "the mean gene of the behaviour with food"),
    Column::number("g0_sd", "", "its standard deviation"),
    Column::number("g1_mean", "0 to 0.99", "the mean gene of the behaviour without food"),
    Column::number("g1_sd", "", "its standard deviation"),
];
static BINS: [Column; 9] = [
    Column::number(
        "s0_opposite",
        "0 to 1",
        "the fraction of simulators with the light opposite the nest",
    ),
    Column::number("s0_no_light", "0 to 1", "the fraction of simulators without a light"),
    Column::number(
        "s0_over",
        "0 to 1",
        "the fraction of simulators with the light over the nest",
    ),
    Column::number(
        "g0_flees",
        "0 to 1",
        "the fraction of controllers that flee the light with food",
    ),
    Column::number(
        "g0_random",
        "0 to 1",
        "the fraction of controllers that search at random with food",
    ),
    Column::number(
        "g0_seeks",
        "0 to 1",
        "the fraction of controllers that seek the light with food",
    ),
    Column::number(
        "g1_flees",
        "0 to 1",
        "the fraction of controllers that flee the light without food",
    ),
    Column::number(
        "g1_random",
        "0 to 1",
        "the fraction of controllers that search at random without food",
    ),
    Column::number(
        "g1_seeks",
        "0 to 1",
        "the fraction of controllers that seek the light without food",
    ),
];

/// The columns that identify a row's combination, case and kind, the number of its run or interval, and others.
fn of(number: &Column, others: &[Column]) -> Vec<Column> {
    [&WHOSE[..], std::slice::from_ref(number), others].concat()
}

/// The files of numbers; one of them only with open questions.
pub(crate) fn contents(has_questions: bool) -> Vec<Entry> {
    let mut all = vec![
        Entry::table("runs.csv", "one row per run", &of(&RUN, &RUNS)),
        Entry::table(
            "intervals.csv",
            "one row per robot and interval, for runs as in the paper",
            &of(&RUN, &INTERVALS_COLUMNS),
        ),
        Entry::table("rates.csv", "one row per 250 s of each run", &of(&RUN, &RATES)),
        Entry::table(
            "genes.csv",
            "one row per interval of each case and kind, over all runs",
            &of(&INTERVAL, &GENES),
        ),
        Entry::table(
            "bins.csv",
            "one row per interval of each case and kind, over all runs: what the genes select",
            &of(&INTERVAL, &BINS),
        ),
    ];
    if has_questions {
        let about = "with `--questions`: one row per open question";
        all.push(Entry::table("questions.csv", about, &questions::COLUMNS));
    }
    all
}

/// Names and contents of the files that [`contents()`] describes, if they were run.
pub(crate) fn csv_files(results: &Results) -> Vec<(&'static str, String)> {
    vec![
        ("runs.csv", runs(results)),
        ("intervals.csv", robots(results)),
        ("rates.csv", rates(results)),
        ("genes.csv", genes(results)),
        ("bins.csv", bins(results)),
    ]
    .into_iter()
    .chain((!results.questions.is_empty()).then(|| ("questions.csv", questions::csv(results))))
    .collect()
}

/// Fields that identify a row's combination, case and kind.
fn whose(combination: &Combination, case: Case, kind: Kind) -> [String; 4] {
    [
        number(combination.scale),
        name(&combination.credit),
        name(&case),
        name(&kind),
    ]
}

/// Runs with their identifying fields and their number.
fn all_runs(results: &Results) -> impl Iterator<Item = (Vec<String>, &Run)> {
    results.combinations.iter().flat_map(|combination| {
        combination.runs.iter().map(move |run| {
            let mut whose = Vec::from(whose(combination, run.case, run.kind));
            whose.push(run.number.to_string());
            (whose, run)
        })
    })
}

/// Cases and kinds that have runs, with their identifying fields.
fn groups(results: &Results) -> impl Iterator<Item = ([String; 4], Vec<&Run>)> {
    results.combinations.iter().flat_map(|combination| {
        let kinds = Case::ALL
            .into_iter()
            .flat_map(|case| Kind::OF_STUDY.map(|kind| (case, kind)));
        kinds.filter_map(move |(case, kind)| {
            let runs = runs_of(combination, case, kind);
            (!runs.is_empty()).then(|| (whose(combination, case, kind), runs))
        })
    })
}

fn runs(results: &Results) -> String {
    let mut table = Csv::new(&of(&RUN, &RUNS));
    let half = results.light_moves_minute as usize * MINUTE;
    for (whose, run) in all_runs(results) {
        let (first, second) = run.brought.split_at(half.min(run.brought.len()));
        let brought = [total(&run.brought), total(first), total(second)].map(|food| food.to_string());
        let shares = shares(at_the_end(run), S0).map(known);
        let means = [S0, G0, G1].map(|gene| known(level(at_the_end(run), gene).0));
        table.row(whose.into_iter().chain(brought).chain(shares).chain(means));
    }
    table.text()
}

fn robots(results: &Results) -> String {
    let mut table = Csv::new(&of(&RUN, &INTERVALS_COLUMNS));
    // The rows of all kinds would take a hundred megabytes.
    for (whose, run) in all_runs(results).filter(|(_, run)| run.kind == Kind::Evolved) {
        for (interval, robots) in run.intervals.iter().enumerate() {
            for (place, robot) in robots.iter().enumerate() {
                let gene = |x: f32| number(f64::from(x));
                let fields = [
                    interval.to_string(),
                    place.to_string(),
                    gene(robot.s0),
                    gene(robot.chosen_under),
                    gene(robot.g0),
                    gene(robot.g1),
                    gene(robot.real),
                    robot.simulated.map_or_else(String::new, gene),
                    robot.heard.to_string(),
                    robot.reached.to_string(),
                    u8::from(robot.taken).to_string(),
                ];
                table.row(whose.iter().cloned().chain(fields));
            }
        }
    }
    table.text()
}

fn rates(results: &Results) -> String {
    let mut table = Csv::new(&of(&RUN, &RATES));
    for (whose, run) in all_runs(results) {
        let per_minute = run.rates(BIN);
        for (bin, (food, rate)) in run.brought.chunks(BIN).zip(per_minute).enumerate() {
            let from = bin * BIN;
            let fields = [
                from.to_string(),
                (from + food.len()).to_string(),
                total(food).to_string(),
                number(rate),
            ];
            table.row(whose.iter().cloned().chain(fields));
        }
    }
    table.text()
}

fn genes(results: &Results) -> String {
    let mut table = Csv::new(&of(&INTERVAL, &GENES));
    for (whose, runs) in groups(results) {
        for interval in 0..intervals(&runs) {
            let at = || robots_at(&runs, interval);
            let levels = [S0, G0, G1].map(|gene| level(at(), gene));
            let levels = levels
                .into_iter()
                .flat_map(|(mean, deviation)| [known(mean), known(deviation)]);
            let place = [interval.to_string(), at().count().to_string()];
            table.row(whose.iter().cloned().chain(place).chain(levels));
        }
    }
    table.text()
}

fn bins(results: &Results) -> String {
    let mut table = Csv::new(&of(&INTERVAL, &BINS));
    for (whose, runs) in groups(results) {
        for interval in 0..intervals(&runs) {
            let shares = [S0, G0, G1].map(|gene| shares(robots_at(&runs, interval), gene));
            let shares = shares.into_iter().flatten().map(known);
            table.row(whose.iter().cloned().chain([interval.to_string()]).chain(shares));
        }
    }
    table.text()
}
