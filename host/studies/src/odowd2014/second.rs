//! The second edition of the study: contrasts of cells, and of what the light law, credit and installation change, from the tables of its
//! sweeps, judged as `studies/preregistration-2014-second.md` says. `studies/recompute.py` does the same with other software.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use Case::{NoLight, Opposite, OppositeThenOver, Over, OverThenOpposite, Random};
use Kind::{Evolved, FitnessShuffled as Null, SimulatorRandom as Drawn, SimulatorRight as Right};
use oneiro_base::answer::Answer;
use oneiro_base::console::wrapped;
use oneiro_base::contents::{Column, Entry};
use oneiro_base::exit::{Failure, Result};
use oneiro_report::csv::{Csv, number};
use oneiro_statistics::{Undefined, mean, variance};

use super::report::name;
use super::results::{Case, Kind};
use crate::Findings;
use crate::contrasts::{self, Estimate, Judged, Row, above, equivalent, figures};
use crate::sweep_results;
use crate::verdict::brief;

const CONTRASTS: &str = "contrasts.csv";
const CLAIMS: &str = "claims.csv";
const CELLS: &str = "cells.csv";
/// Robots of a swarm: tables have food by robot-minute, and the study that of the swarm.
const ROBOTS: f64 = 10.0;
/// Food that is equivalent to none, items a minute.
const FOOD_MARGIN: f64 = 0.465;
/// Margin for fractions of simulators.
const SHARE_MARGIN: f64 = 0.15;
/// Margin for differences of mean S0.
const S0_MARGIN: f64 = 0.05;
/// The middle of the No Light bin, and how far its bounds are.
const MIDDLE: f64 = 0.495;
const BIN_MARGIN: f64 = 0.165;
/// Standard deviation from which on genes are widely spread.
const WIDE: f64 = 0.214;
const LOW: f64 = 0.33;
const HIGH: f64 = 0.66;

figures! {
    /// The used columns of a run's row.
    Run {
        rate: "rate",
        before_rate: "before_rate",
        after_rate: "after_rate",
        second_rate: "second_rate",
        late_right: "late_right",
        before_right: "before_right",
        before_later: "before_later",
        second_later: "second_later",
        settled_later: "settled_later",
        first_s0: "first_s0",
        before_s0: "before_s0",
        late_s0: "late_s0",
        second_s0_deviation: "second_s0_deviation",
        late_s0_deviation: "late_s0_deviation",
        late_g0: "late_g0",
        late_g0_deviation: "late_g0_deviation",
        late_g1: "late_g1",
        late_g1_deviation: "late_g1_deviation",
        chosen_area: "chosen_area",
    }
}

/// The factors' keys, as columns of a sweep's table.
const FACTOR_COLUMNS: [&str; 4] = [
    "swarm.robot.phototaxis_threshold",
    "swarm.simulators.mutation_scale",
    "swarm.simulators.credit",
    "swarm.clock.installed_s",
];

/// A combination of levels of the factors, as the tables have them: threshold, scale, credit and installation.
type Combination = [String; 4];
/// Place of the credit.
const CREDIT: usize = 2;
/// The factor's place in a combination, and the two levels whose difference its family is.
const LEVELS: [(usize, &str, &str); 3] = [(0, "0.0", "0.16"), (CREDIT, "lagged", "matched"), (3, "60", "34")];

/// The runs of a cell, by seed.
type Cell = BTreeMap<u64, Run>;
/// The cells of a combination, Random Movement among them.
type Cells = BTreeMap<(Case, Kind), Cell>;

/// Groups of runs, whose means add up to the estimate.
type Contrast = contrasts::Contrast<fn(&JudgedCells<'_>) -> Groups>;
type Groups = Vec<Vec<f64>>;

/// A combination's cells, or half of their runs.
struct JudgedCells<'a> {
    cells: &'a Cells,
    /// The first or the second half of each case's seeds, or all.
    half: Option<usize>,
}

impl JudgedCells<'_> {
    /// A figure of each run of a cell, in the order of seeds.
    fn each(&self, case: Case, kind: Kind, of: impl Fn(&Run) -> f64) -> Vec<f64> {
        let all: Vec<f64> = self.cells[&(case, kind)].values().map(of).collect();
        let middle = all.len() / 2;
        match self.half {
            None => all,
            Some(0) => all[..middle].to_vec(),
            Some(_) => all[middle..].to_vec(),
        }
    }

    fn evolved(&self, case: Case, of: impl Fn(&Run) -> f64) -> Vec<f64> {
        self.each(case, Evolved, of)
    }

    /// A figure minus that under another control, by seed.
    fn within(&self, case: Case, [one, other]: [Kind; 2], of: impl Fn(&Run) -> f64) -> Vec<f64> {
        let other = self.each(case, other, &of);
        let one = self.each(case, one, of);
        one.iter().zip(other).map(|(one, other)| one - other).collect()
    }

    fn above_null(&self, case: Case, of: impl Fn(&Run) -> f64) -> Vec<f64> {
        self.within(case, [Evolved, Null], of)
    }

    /// Food of Random Movement, multiplied by `times`.
    fn random(&self, times: f64) -> Vec<f64> {
        self.evolved(Random, |run| times * food(run))
    }
}

/// Food of the swarm per minute.
fn food(run: &Run) -> f64 {
    ROBOTS * run.rate
}

/// The family of a combination.
static OF_CELLS: [Contrast; 43] = [
    above("food over - random", &["D1"], |cells| {
        vec![cells.evolved(Over, food), cells.random(-1.0)]
    }),
    above("food opposite - random", &["D1", "D3"], |cells| {
        vec![cells.evolved(Opposite, food), cells.random(-1.0)]
    }),
    above("food over-then-opposite - random", &["D1"], |cells| {
        vec![cells.evolved(OverThenOpposite, food), cells.random(-1.0)]
    }),
    above("food opposite-then-over - random", &["D1"], |cells| {
        vec![cells.evolved(OppositeThenOver, food), cells.random(-1.0)]
    }),
    equivalent("food no-light = random", &["D1"], FOOD_MARGIN, |cells| {
        vec![cells.evolved(NoLight, food), cells.random(-1.0)]
    }),
    above("food over - null", &["D1", "D2"], |cells| {
        vec![cells.above_null(Over, food)]
    }),
    above("food opposite - null", &["D1", "D3"], |cells| {
        vec![cells.above_null(Opposite, food)]
    }),
    above("food over-then-opposite - null", &["D1"], |cells| {
        vec![cells.above_null(OverThenOpposite, food)]
    }),
    above("food opposite-then-over - null", &["D1"], |cells| {
        vec![cells.above_null(OppositeThenOver, food)]
    }),
    above("food over - 1.5 random", &["D2"], |cells| {
        vec![cells.evolved(Over, food), cells.random(-1.5)]
    }),
    above("food 2.5 random - over", &["D2"], |cells| {
        vec![cells.random(2.5), cells.evolved(Over, |run| -food(run))]
    }),
    above("food over - opposite", &["D3"], |cells| {
        vec![cells.evolved(Over, food), cells.evolved(Opposite, |run| -food(run))]
    }),
    above("right no-light - null", &["D4"], |cells| {
        vec![cells.above_null(NoLight, |run| run.settled_later)]
    }),
    equivalent("late S0 no-light = 0.495", &["D4"], BIN_MARGIN, |cells| {
        vec![cells.evolved(NoLight, |run| run.late_s0 - MIDDLE)]
    }),
    above("spread of G0 no-light - 0.214", &["D4"], |cells| {
        vec![cells.evolved(NoLight, |run| run.late_g0_deviation - WIDE)]
    }),
    above("spread of G1 no-light - 0.214", &["D4"], |cells| {
        vec![cells.evolved(NoLight, |run| run.late_g1_deviation - WIDE)]
    }),
    above("right over - null", &["D5"], |cells| {
        vec![cells.above_null(Over, |run| run.late_right)]
    }),
    above("late G0 over - 0.66", &["D5"], |cells| {
        vec![cells.evolved(Over, |run| run.late_g0 - HIGH)]
    }),
    above("0.33 - late G1 over", &["D5"], |cells| {
        vec![cells.evolved(Over, |run| LOW - run.late_g1)]
    }),
    above("spread of G0 no-light - over", &["D5"], |cells| {
        vec![
            cells.evolved(NoLight, |run| run.late_g0_deviation),
            cells.evolved(Over, |run| -run.late_g0_deviation),
        ]
    }),
    above("spread of G1 no-light - over", &["D5"], |cells| {
        vec![
            cells.evolved(NoLight, |run| run.late_g1_deviation),
            cells.evolved(Over, |run| -run.late_g1_deviation),
        ]
    }),
    equivalent("right opposite = null", &["D6"], SHARE_MARGIN, |cells| {
        vec![cells.above_null(Opposite, |run| run.late_right)]
    }),
    equivalent("late S0 opposite = 0.495", &["D6"], BIN_MARGIN, |cells| {
        vec![cells.evolved(Opposite, |run| run.late_s0 - MIDDLE)]
    }),
    above("spread of G0 opposite - 0.214", &["D6"], |cells| {
        vec![cells.evolved(Opposite, |run| run.late_g0_deviation - WIDE)]
    }),
    above("spread of G1 opposite - 0.214", &["D6"], |cells| {
        vec![cells.evolved(Opposite, |run| run.late_g1_deviation - WIDE)]
    }),
    above("right before the move - null", &["D7"], |cells| {
        vec![cells.above_null(OverThenOpposite, |run| run.before_right)]
    }),
    above("food 0.75 before - after the move", &["D7"], |cells| {
        vec![cells.evolved(OverThenOpposite, |run| {
            ROBOTS * (0.75 * run.before_rate - run.after_rate)
        })]
    }),
    above("S0 before - late", &["D7"], |cells| {
        vec![cells.evolved(OverThenOpposite, |run| run.before_s0 - run.late_s0)]
    }),
    above("0.5 - right late", &["D7"], |cells| {
        vec![cells.evolved(OverThenOpposite, |run| 0.5 - run.late_right)]
    }),
    above("food second half over - moved over", &["D8"], |cells| {
        vec![
            cells.evolved(Over, |run| ROBOTS * run.second_rate),
            cells.evolved(OppositeThenOver, |run| -ROBOTS * run.second_rate),
        ]
    }),
    above("right late - before", &["D8"], |cells| {
        vec![cells.evolved(OppositeThenOver, |run| run.late_right - run.before_later)]
    }),
    equivalent("first S0 opposite = opposite-then-over", &["D9"], S0_MARGIN, |cells| {
        vec![
            cells.evolved(Opposite, |run| run.first_s0),
            cells.evolved(OppositeThenOver, |run| -run.first_s0),
        ]
    }),
    above("food right opposite - random", &["D12"], |cells| {
        vec![cells.each(Opposite, Right, food), cells.random(-1.0)]
    }),
    above("food right gain over / 2 - opposite", &["D12"], |cells| {
        vec![
            cells.each(Over, Right, |run| 0.5 * food(run)),
            cells.each(Opposite, Right, |run| -food(run)),
            cells.random(0.5),
        ]
    }),
    above("area over - 0.5", &["D13"], |cells| {
        vec![cells.each(Over, Drawn, |run| run.chosen_area - 0.5)]
    }),
    above("area opposite - 0.5", &["D13"], |cells| {
        vec![cells.each(Opposite, Drawn, |run| run.chosen_area - 0.5)]
    }),
    above("food null opposite - random", &["D14"], |cells| {
        vec![cells.each(Opposite, Null, food), cells.random(-1.0)]
    }),
    equivalent("food opposite = null", &["D14"], FOOD_MARGIN, |cells| {
        vec![cells.above_null(Opposite, food)]
    }),
    above("right second half over - moved", &["D15"], |cells| {
        vec![
            cells.evolved(Over, |run| run.second_later),
            cells.evolved(OverThenOpposite, |run| -run.second_later),
        ]
    }),
    above("spread of S0 second half moved - over", &["D15"], |cells| {
        vec![
            cells.evolved(OverThenOpposite, |run| run.second_s0_deviation),
            cells.evolved(Over, |run| -run.second_s0_deviation),
        ]
    }),
    above("spread of late S0 null - evolved", &["D16"], |cells| {
        vec![cells.within(NoLight, [Null, Evolved], |run| run.late_s0_deviation)]
    }),
    above("food right - drawn over", &["D17"], |cells| {
        vec![cells.within(Over, [Right, Drawn], food)]
    }),
    above("food right - drawn opposite", &["D17"], |cells| {
        vec![cells.within(Opposite, [Right, Drawn], food)]
    }),
];

/// The figures that the family of a factor compares, each of one group.
static OF_FACTORS: [Contrast; 6] = [
    above("food over", &[], |cells| vec![cells.evolved(Over, food)]),
    above("food opposite", &[], |cells| vec![cells.evolved(Opposite, food)]),
    above("food no-light", &[], |cells| vec![cells.evolved(NoLight, food)]),
    above("food null opposite", &[], |cells| {
        vec![cells.each(Opposite, Null, food)]
    }),
    above("right over - null", &[], |cells| {
        vec![cells.above_null(Over, |run| run.late_right)]
    }),
    above("right opposite - null", &[], |cells| {
        vec![cells.above_null(Opposite, |run| run.late_right)]
    }),
];

/// The cells that all contrasts need.
fn needed_cells() -> impl Iterator<Item = (Case, Kind)> {
    let evolving = [NoLight, Over, Opposite, OverThenOpposite, OppositeThenOver];
    let paper = evolving.into_iter().flat_map(|case| [(case, Evolved), (case, Null)]);
    let interventions = [Over, Opposite]
        .into_iter()
        .flat_map(|case| [(case, Right), (case, Drawn)]);
    paper.chain(interventions).chain([(Random, Evolved)])
}

/// The claims that are judged.
const JUDGED: [&str; 15] = [
    "D1", "D2", "D3", "D4", "D5", "D6", "D7", "D8", "D9", "D12", "D13", "D14", "D15", "D16", "D17",
];

/// Welch's test of a sum of means.
fn estimate(groups: &[Vec<f64>], margin: Option<f64>) -> Estimate {
    let value = groups.iter().map(mean).sum();
    let parts = groups
        .iter()
        .map(|group| (variance(group) / group.len() as f64, group.len() as f64 - 1.0));
    let (sum, squares) = parts.fold((0.0, 0.0), |(sum, squares), (part, df)| {
        (sum + part, squares + part * part / df)
    });
    let df = if squares > 0.0 { sum * sum / squares } else { 1.0 };
    Estimate::new(value, sum.sqrt(), df, margin)
}

static FACTORS: LazyLock<Vec<Column>> = LazyLock::new(|| {
    let of = |name, text| Column::text(name, text);
    vec![
        of(
            "threshold",
            "the light from which on phototaxis acts (0.0: always), or `0.16 - 0.0` for what it changes",
        ),
        of("scale", "the standard deviation of mutations"),
        of("credit", "the rule of credit, or `matched - lagged`"),
        of(
            "installed_s",
            "when in an interval new controllers take over, or `34 - 60`",
        ),
    ]
});

static COLUMNS: LazyLock<Vec<Column>> = LazyLock::new(|| {
    let words = [
        Column::text(
            "contrast",
            "what is compared, see studies/preregistration-2014-second.md",
        ),
        Column::text("claims", "the claims that it belongs to"),
    ];
    let halves = [
        Column::text("first_half", "the outcome with the first half of each case's seeds"),
        Column::text("second_half", "the outcome with the second half"),
    ];
    let survives = "`yes` if the outcome is the same in both halves and by the other three criteria, else `no`";
    let factors = FACTORS.iter().cloned();
    let all = factors.chain(words).chain(contrasts::estimate_columns(
        "its estimate: items of food that the swarm brings in a minute, a fraction of simulators, or a gene's mean or standard deviation",
    ));
    let all = all.chain(halves).chain(contrasts::other_criteria_columns());
    all.chain([Column::text("survives", survives)]).collect()
});

static CLAIM_COLUMNS: LazyLock<Vec<Column>> = LazyLock::new(|| [&FACTORS[..], &contrasts::CLAIM].concat());

static CELL_COLUMNS: LazyLock<Vec<Column>> = LazyLock::new(|| {
    let of_cells = [
        Column::text("case", "the experiment case"),
        Column::text("control", "what the experimenter does to simulators"),
        Column::whole("runs", "", "the number of runs"),
        Column::number("food", "items/min", "food that the swarm brings"),
        Column::number("food_deviation", "items/min", "its standard deviation over runs"),
        Column::number(
            "late_right",
            "0 to 1",
            "the late fraction of simulators that have the light where it is",
        ),
        Column::number("late_s0", "0 to 0.99", "the late mean gene of simulators"),
        Column::number("late_g0", "0 to 0.99", "the late mean gene of controllers with food"),
        Column::number("late_g1", "0 to 0.99", "the late mean gene of controllers without food"),
    ];
    FACTORS.iter().cloned().chain(of_cells).collect()
});

/// The files that judging writes.
pub(crate) fn contents() -> Vec<Entry> {
    vec![
        Entry::table(
            CONTRASTS,
            "one row per contrast and combination of factors",
            COLUMNS.iter(),
        ),
        Entry::table(
            CLAIMS,
            "one row per claim and combination of factors",
            CLAIM_COLUMNS.iter(),
        ),
        Entry::table(CELLS, "one row per combination, case and control", CELL_COLUMNS.iter()),
    ]
}

/// Judges the runs of finished sweeps, and writes all tables to a directory if one is given. Returns the claims.
pub fn judge_sweeps(sweeps: &[PathBuf], out: Option<&Path>) -> Result<Answer<Findings>> {
    let mut found = Found::default();
    sweep_results::each_table(sweeps, |path, text| parse(path, text, &mut found))?;
    let tables = Tables::of(&found.complete()?).map_err(Failure::input)?;
    let head: Vec<&str> = CLAIM_COLUMNS.iter().map(|column| column.name.as_ref()).collect();
    let text = wrapped(&head, &tables.shown);
    let files = [
        (CONTRASTS, tables.contrasts),
        (CLAIMS, tables.claims),
        (CELLS, tables.cells),
    ];
    if let Some(out) = out {
        let what = "The second edition of the 2014 study, judged.";
        sweep_results::write(out, what, &files, &contents())?;
    }
    Ok(Answer::new(text, sweep_results::findings(&files)))
}

/// The runs of sweeps.
#[derive(Default)]
struct Found {
    all: BTreeMap<Combination, Cells>,
    /// Random Movement, which is of all combinations.
    random: Cell,
}

impl Found {
    /// Gives all combinations their common runs, and checks that none lacks a run.
    fn complete(self) -> Result<BTreeMap<Combination, Cells>> {
        let Self { mut all, random } = self;
        // Fixed and drawn controls are run once for both credits.
        let shared: Vec<(Combination, (Case, Kind), Cell)> = all
            .iter()
            .flat_map(|(key, cells)| cells.iter().map(move |(cell, runs)| (key, cell, runs)))
            .filter(|(_, (_, kind), _)| [Right, Drawn].contains(kind))
            .map(|(key, cell, runs)| (key.clone(), *cell, runs.clone()))
            .collect();
        for (key, cells) in &mut all {
            for (other, cell, runs) in &shared {
                let mut alike = other.clone();
                key[CREDIT].clone_into(&mut alike[CREDIT]);
                if alike == *key {
                    cells.entry(*cell).or_insert_with(|| runs.clone());
                }
            }
            cells.insert((Random, Evolved), random.clone());
            let seeds = |case: Case| cells.get(&(case, Evolved)).map(|runs| runs.keys().collect::<Vec<_>>());
            for (case, kind) in needed_cells() {
                let found = cells.get(&(case, kind)).map(|runs| runs.keys().collect::<Vec<_>>());
                let is_whole = found.as_ref().is_some_and(|found| found.len() > 3) && found == seeds(case);
                if !is_whole {
                    let [threshold, scale, credit, installed] = key;
                    return Err(Failure::input(format_args!(
                        "--sweeps: lack runs of swarm.case = {:?} with swarm.control = {:?} at a threshold of {threshold}, a scale of \
                         {scale}, credit {credit} and installation after {installed} s; allowed: finished sweeps of \
                         studies/odowd2014/second, random among them, with at least four seeds of each cell, the same for all \
                         of a case",
                        name(&case),
                        name(&kind),
                    )));
                }
            }
        }
        if all.is_empty() {
            let problem = "--sweeps: have no run of an evolving swarm; allowed: sweeps of studies/odowd2014/second";
            return Err(Failure::input(problem));
        }
        Ok(all)
    }
}

/// All tables of the judging.
struct Tables {
    contrasts: String,
    claims: String,
    cells: String,
    /// The claims' rows.
    shown: Vec<Vec<String>>,
}

impl Tables {
    fn of(all: &BTreeMap<Combination, Cells>) -> std::result::Result<Self, Undefined> {
        let (mut contrasts, mut claims) = (Vec::new(), Csv::new(CLAIM_COLUMNS.iter()));
        let mut table = Csv::new(CELL_COLUMNS.iter());
        let mut shown = Vec::new();
        for (key, cells) in all {
            let groups = |half| {
                let judged = JudgedCells { cells, half };
                OF_CELLS.iter().map(|contrast| (contrast.of)(&judged)).collect()
            };
            let judged = rows(key, &OF_CELLS, groups, &mut contrasts)?;
            for claim in JUDGED {
                let (outcome, reasons) = contrasts::of_claim(claim, &judged, &OF_CELLS);
                let row = |reason: &str| -> Vec<String> {
                    let ends = [claim, outcome.word(), reason].map(str::to_owned);
                    key.clone().into_iter().chain(ends).collect()
                };
                claims.row(row(&reasons.join("; ")));
                shown.push(row(&brief(&reasons)));
            }
            for (case, kind) in needed_cells() {
                table.row(key.clone().into_iter().chain(cell(cells, case, kind)));
            }
        }
        for (key, cells) in all {
            for (other, words) in others(key) {
                let Some(second) = all.get(&other) else { continue };
                let groups = |half| {
                    let [first, second] = [cells, second].map(|cells| JudgedCells { cells, half });
                    let difference = |contrast: &Contrast| {
                        let [first, second] = [&first, &second].map(|half| (contrast.of)(half));
                        let pairs = second.into_iter().flatten().zip(first.into_iter().flatten());
                        vec![pairs.map(|(second, first)| second - first).collect()]
                    };
                    OF_FACTORS.iter().map(difference).collect()
                };
                rows(&words, &OF_FACTORS, groups, &mut contrasts)?;
            }
        }
        Ok(Self {
            contrasts: contrasts::table(&COLUMNS, &contrasts)?,
            claims: claims.text(),
            cells: table.text(),
            shown,
        })
    }
}

/// The combinations at the second level of a factor of which this one is at the first, and what the differences are called.
fn others(combination: &Combination) -> impl Iterator<Item = (Combination, Combination)> {
    let at_first = LEVELS
        .into_iter()
        .filter(|(place, first, _)| combination[*place] == *first);
    at_first.map(|(place, first, second)| {
        let with = |word: &str| {
            let mut words = combination.clone();
            word.clone_into(&mut words[place]);
            words
        };
        (with(second), with(&format!("{second} - {first}")))
    })
}

/// Judges a family, also by halves, and keeps its rows.
fn rows(
    factors: &Combination,
    contrasts: &[Contrast],
    groups: impl Fn(Option<usize>) -> Vec<Groups>,
    table: &mut Vec<Row>,
) -> std::result::Result<Vec<Judged>, Undefined> {
    let by = |half| {
        let estimates = groups(half).into_iter().zip(contrasts);
        contrasts::family(
            estimates
                .map(|(groups, contrast)| estimate(&groups, contrast.margin))
                .collect(),
        )
    };
    let judged = by(None)?;
    let halves = [by(Some(0))?, by(Some(1))?];
    for (index, (row, contrast)) in judged.iter().zip(contrasts).enumerate() {
        let halves = halves.each_ref().map(|half| half[index].outcome);
        let words = [contrast.name.to_owned(), contrast.claims.join(" ")];
        table.push(Row {
            words: factors.iter().cloned().chain(words).collect(),
            judged: *row,
            firmness: halves.map(|half| half.word().to_owned()).into(),
            survives: halves.iter().all(|half| *half == row.outcome),
            is_by_criteria: true,
        });
    }
    Ok(judged)
}

/// The figures of a cell.
fn cell(cells: &Cells, case: Case, kind: Kind) -> Vec<String> {
    let judged = JudgedCells { cells, half: None };
    let all = judged.each(case, kind, food);
    let average = |of: fn(&Run) -> f64| mean(judged.each(case, kind, of));
    let numbers = [
        mean(&all),
        variance(&all).sqrt(),
        average(|run| run.late_right),
        average(|run| run.late_s0),
        average(|run| run.late_g0),
        average(|run| run.late_g1),
    ];
    let words = [name(&case), name(&kind), all.len().to_string()];
    words.into_iter().chain(numbers.map(number)).collect()
}

/// Parses the runs of a sweep's table.
fn parse(path: &Path, text: &str, into: &mut Found) -> Result {
    sweep_results::each_row(
        (path, text),
        "studies/odowd2014/second",
        &["swarm.case", "seed"],
        |row| {
            let run = Run::read(|column| row.number(column, |_| true, "a number, or NaN"))?;
            let case = row.cell("swarm.case")?;
            let found = Case::ALL.into_iter().find(|case_of| name(case_of) == case);
            let case =
                found.ok_or_else(|| row.bad("swarm.case is none of the paper's; allowed: an experiment case"))?;
            let seed = row.seed()?;
            let cell = if case == Random {
                &mut into.random
            } else {
                let [threshold, scale, credit, installed] =
                    FACTOR_COLUMNS.map(|column| row.cell(column).map(str::to_owned));
                let key = [threshold?, scale?, credit?, installed?];
                let control = row.cell("swarm.control")?;
                let kind = Kind::OF_STUDY.into_iter().find(|kind| name(kind) == control);
                let kind = kind.ok_or_else(|| row.bad("swarm.control is unknown; allowed: evolved, or a control"))?;
                into.all.entry(key).or_default().entry((case, kind)).or_default()
            };
            if cell.insert(seed, run).is_some() {
                let problem = format_args!("is the second run of seed {seed} of its cell; allowed: each sweep once");
                return Err(row.bad(problem));
            }
            Ok(())
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIGURES: [&str; 19] = [
        "rate",
        "before_rate",
        "after_rate",
        "second_rate",
        "late_right",
        "before_right",
        "before_later",
        "second_later",
        "settled_later",
        "first_s0",
        "before_s0",
        "late_s0",
        "second_s0_deviation",
        "late_s0_deviation",
        "late_g0",
        "late_g0_deviation",
        "late_g1",
        "late_g1_deviation",
        "chosen_area",
    ];

    /// Tables of eight seeds: Random Movement, and the cells of both light laws with matched credit; `of` gives a cell's figure.
    fn tables(of: impl Fn(Case, Kind, &str) -> f64) -> [String; 2] {
        let head = format!("run,swarm.case,seed,{}", FIGURES.join(","));
        let figures = |case, kind, seed: u64| {
            let spread = ((seed * 5) % 7) as f64 / 7.0 - 0.4;
            let figures = FIGURES.map(|name| (of(case, kind, name) + 0.01 * spread).to_string());
            figures.join(",")
        };
        let mut random = vec![head.clone()];
        for seed in 501..509 {
            random.push(format!("0,random,{seed},{}", figures(Random, Evolved, seed)));
        }
        let factors: Vec<&str> = FACTOR_COLUMNS.into();
        let mut all = vec![format!("{head},swarm.control,{}", factors.join(","))];
        for threshold in ["0.0", "0.16"] {
            for (case, kind) in needed_cells().filter(|(case, _)| *case != Random) {
                for seed in 0..8 {
                    let seed = 100 * case as u64 + seed;
                    let columns = [figures(case, kind, seed), name(&kind), threshold.to_owned()].join(",");
                    all.push(format!("0,{},{seed},{columns},0.2,matched,60", name(&case)));
                }
            }
        }
        [random, all].map(|lines| lines.join("\n"))
    }

    /// The paper's figures, and unmeasured ones as its explanations imply.
    #[expect(clippy::match_same_arms, reason = "figures that are equal by chance stay apart")]
    fn as_in_the_paper(case: Case, kind: Kind, figure: &str) -> f64 {
        match (figure, case, kind) {
            ("rate", Random | NoLight, _) => 0.46,
            ("rate", Over, Evolved) | ("before_rate" | "second_rate", ..) => 0.9,
            ("rate", Opposite, Null) => 0.58,
            ("rate", Opposite, Evolved | Right) => 0.6,
            ("rate", _, Evolved) => 0.7,
            ("rate", Over, Right) => 1.2,
            ("rate", _, _) => 0.5,
            ("after_rate", ..) => 0.3,
            ("late_right", Opposite | OverThenOpposite, _) | ("before_later", ..) => 0.3,
            ("second_later", OverThenOpposite, _) => 0.2,
            ("late_right" | "settled_later" | "before_right" | "second_later", _, Evolved) => 0.9,
            ("late_right" | "settled_later" | "before_right" | "second_later", ..) => 0.3,
            ("before_s0", ..) => 0.8,
            ("late_s0" | "first_s0", ..) => 0.5,
            ("second_s0_deviation", Over, _) => 0.05,
            ("late_s0_deviation", _, Evolved) => 0.1,
            ("second_s0_deviation" | "late_s0_deviation", ..) => 0.3,
            ("late_g0", ..) => 0.8,
            ("late_g1", ..) => 0.1,
            ("late_g0_deviation" | "late_g1_deviation", Over, _) => 0.05,
            ("late_g0_deviation" | "late_g1_deviation", ..) => 0.28,
            ("chosen_area", ..) => 0.6,
            _ => unreachable!("{figure}"),
        }
    }

    /// The same, except that a light moved over the nest brings less than one that was always there.
    fn judged(of: impl Fn(Case, Kind, &str) -> f64) -> Tables {
        let of = |case, kind, figure: &str| match (case, figure) {
            (OppositeThenOver, "second_rate") => of(case, kind, figure) - 0.2,
            _ => of(case, kind, figure),
        };
        let mut found = Found::default();
        for text in tables(of) {
            parse(Path::new("results.csv"), &text, &mut found).unwrap();
        }
        Tables::of(&found.complete().unwrap()).unwrap()
    }

    fn cell<'a>(table: &'a str, begin: &str, column: usize) -> &'a str {
        let row = table.lines().find(|row| row.starts_with(begin));
        let row = row.unwrap_or_else(|| panic!("{begin} in\n{table}"));
        row.split(',').nth(column).unwrap()
    }

    const HERE: &str = "0.16,0.2,matched,60";

    #[test]
    fn what_the_paper_says_holds_and_its_contrary_is_opposed() {
        let tables = judged(as_in_the_paper);
        for claim in JUDGED {
            assert_eq!(
                cell(&tables.claims, &format!("{HERE},{claim},"), 5),
                "holds",
                "{claim}\n{}",
                tables.contrasts
            );
        }
        // Selection that does the contrary, a light that fools everybody, and an anomaly.
        let tables = judged(|case, kind, figure| {
            let kind = match kind {
                Evolved => Null,
                Null => Evolved,
                Right => Drawn,
                other => other,
            };
            match (figure, case) {
                ("rate", Opposite) => 0.1,
                ("first_s0", Opposite) => 0.7,
                ("before_rate", _) => 0.3,
                ("before_later", _) => 0.95,
                ("chosen_area", _) => 0.4,
                ("late_right", OverThenOpposite) => 0.9,
                ("second_later", OverThenOpposite) | ("late_s0", Opposite) => 0.8,
                _ => as_in_the_paper(case, kind, figure),
            }
        });
        for (claim, expected) in [
            ("D1", "opposed"),
            ("D2", "opposed"),
            ("D3", "opposed"),
            ("D4", "opposed"),
            ("D5", "opposed"),
            ("D6", "opposed"),
            ("D7", "opposed"),
            ("D8", "opposed"),
            ("D9", "opposed"),
            ("D12", "opposed"),
            ("D13", "opposed"),
            ("D14", "opposed"),
            ("D15", "opposed"),
            ("D16", "opposed"),
        ] {
            let found = cell(&tables.claims, &format!("{HERE},{claim},"), 5);
            assert_eq!(found, expected, "{claim}\n{}", tables.contrasts);
        }
    }

    /// Welch's test as `SciPy` has it: `ttest_ind([1, 2, 4, 7], [2, 2.5, 3], equal_var=False)`.
    #[test]
    fn sums_of_means_are_tested_as_others_do() {
        let table = judged(as_in_the_paper);
        assert_eq!(cell(&table.cells, &format!("{HERE},over,evolved,"), 6), "8");
        let sums = estimate(&[vec![1.0, 2.0, 4.0, 7.0], vec![-2.0, -2.5, -3.0]], None);
        let judged = contrasts::family(vec![sums]).unwrap();
        let row = Row {
            words: Vec::new(),
            judged: judged[0],
            firmness: Vec::new(),
            survives: true,
            is_by_criteria: true,
        };
        let columns = COLUMNS.iter().skip(6).filter(|column| !column.name.ends_with("half"));
        let text = contrasts::table(&columns.cloned().collect::<Vec<_>>(), &[row]).unwrap();
        let [value, low, high, p]: [f64; 4] = std::array::from_fn(|column| {
            text.lines()
                .nth(1)
                .unwrap()
                .split(',')
                .nth(column)
                .unwrap()
                .parse()
                .unwrap()
        });
        for (found, expected) in [(value, 1.0), (low, -3.10739), (high, 5.10739), (p, 0.509_476)] {
            assert!((found - expected).abs() < 1e-5, "{found}, not {expected}");
        }
    }

    /// The law's family depends only on differences between the laws, and each outcome names what it does not survive.
    #[test]
    fn what_a_factor_changes_is_a_family_of_its_own() {
        let tables = judged(as_in_the_paper);
        let begin = "0.16 - 0.0,0.2,matched,60,food over,";
        assert_eq!(cell(&tables.contrasts, begin, 6), "0");
        assert_eq!(cell(&tables.contrasts, begin, 11), "undecided");
        let mut found = Found::default();
        let [random, all] = self::tables(as_in_the_paper);
        // More food over the nest under the second law, only in the second half of the seeds.
        let more = |row: &str| {
            let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
            let is_late = cells[2].parse::<u64>().is_ok_and(|seed| seed % 100 >= 4);
            if cells[1] == "over" && row.contains(",evolved,0.16,") && is_late {
                cells[3] = (cells[3].parse::<f64>().unwrap() + 0.2).to_string();
            }
            cells.join(",")
        };
        let all: Vec<String> = all.lines().map(more).collect();
        for text in [random, all.join("\n")] {
            parse(Path::new("results.csv"), &text, &mut found).unwrap();
        }
        let tables = Tables::of(&found.complete().unwrap()).unwrap();
        assert_eq!(cell(&tables.contrasts, begin, 6), "1", "{}", tables.contrasts);
        assert_eq!(
            [12, 13, 17].map(|column| cell(&tables.contrasts, begin, column)),
            ["undecided", "holds", "no"]
        );
    }

    #[test]
    fn tables_that_lack_something_are_refused() {
        let [random, all] = tables(as_in_the_paper);
        let refused = |texts: &[&str]| {
            let mut found = Found::default();
            let read = texts
                .iter()
                .try_for_each(|text| parse(Path::new("results.csv"), text, &mut found));
            read.and_then(|()| found.complete().map(|_| ()))
                .unwrap_err()
                .to_string()
        };
        for (texts, expected) in [
            (
                &[&*all][..],
                "lack runs of swarm.case = \"random\" with swarm.control = \"evolved\" at a threshold of 0.0",
            ),
            (&[&*random], "have no run of an evolving swarm; allowed: "),
            (
                &[&*random, &all, &random],
                "results.csv:2: is the second run of seed 501 of its cell; allowed: ",
            ),
            (
                &[&all.replace("late_g1,", "other,")],
                "results.csv:1: has no column late_g1; allowed: ",
            ),
            (
                &[&all.replacen(",evolved,", ",shuffled,", 1)],
                "results.csv:2: swarm.control is unknown; allowed: ",
            ),
            (
                &[&all.replacen("no-light", "dark", 1)],
                "results.csv:2: swarm.case is none of the paper's; allowed: ",
            ),
            (
                &[&all.replacen("no-light,", "no-light,x", 1)],
                "results.csv:2: has no seed; allowed: ",
            ),
            (
                &[&all.replacen(",simulator-right,0.0,", ",simulator-random,0.16,", 1)],
                "is the second run of seed",
            ),
        ] {
            let problem = refused(texts);
            assert!(problem.contains(expected), "{problem}, not {expected}");
        }
        // One cell has a seed less than the others of its case.
        let (short, _) = all.rsplit_once('\n').unwrap();
        let problem = refused(&[&random, short]);
        assert!(
            problem.contains("with swarm.control = \"simulator-random\" at a threshold of 0.16"),
            "{problem}"
        );
    }
}
