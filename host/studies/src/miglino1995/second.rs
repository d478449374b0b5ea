//! The second and the third edition of the study, and plastic controllers: contrasts of conditions, of collision rules, of readings of
//! equation 1 and of controllers, from the tables of their sweeps, judged as `studies/preregistration-1995-second.md`, `-third.md` and
//! `-plastic.md` say. `studies/recompute.py` does the same with other software.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use oneiro_base::answer::Answer;
use oneiro_base::console::columns;
use oneiro_base::contents::{Column, Entry};
use oneiro_base::exit::{Failure, Result};
use oneiro_report::csv::{Csv, number};
use oneiro_statistics::{Undefined, mean, nested_mean, one_sample_t, variance};

use super::calibration::{self, Pairs};
use super::results::{Condition, Run as StudyRun};
use crate::Findings;
use crate::contrasts::{self, Estimate, Judged, Row, above, equivalent, figures};
use crate::sweep_results;
use crate::verdict::{Part, brief};

const CONTRASTS: &str = "contrasts.csv";
const CLAIMS: &str = "claims.csv";
const CELLS: &str = "cells.csv";
const CALIBRATION: &str = "calibration.csv";
/// A run whose peak in the simulator is below this has failed to converge.
const FAILED_BELOW: f64 = 100.0;
/// A gap within this is equivalent to none.
const MARGIN: f64 = 25.0;
/// Individuals of a generation.
const INDIVIDUALS: f64 = 100.0;

figures! {
    /// What is taken of a run's row of the table.
    Run {
        simulated: "simulated",
        simulated_peak: "simulated_peak",
        simulated_deviation: "simulated_deviation",
        quiet: "quiet",
        real: "real",
        real_peak: "real_peak",
        real_deviation: "real_deviation",
        last: "last",
        path_gap: "path_gap_mm",
        path_repeat: "path_repeat_mm",
    }
}

impl Run {
    /// The same of a run of a study.
    fn of_study(run: &StudyRun) -> Self {
        let fitness = |lives: &[f32]| lives.iter().map(|&life| f64::from(life)).collect::<Vec<_>>();
        let transferred = &run.transferred;
        let [simulated, quiet, real, last] =
            [&transferred.simulated, &transferred.quiet, &transferred.real, &run.last].map(|lives| fitness(lives));
        let end = |sums: &[f64]| sums.last().copied().unwrap_or(f64::NAN);
        Self {
            simulated: mean(&simulated),
            simulated_peak: run.simulated.last().map_or(f64::NAN, |level| level.peak),
            simulated_deviation: variance(&simulated).sqrt(),
            quiet: mean(quiet),
            real: mean(&real),
            real_peak: run.real.first().map_or(f64::NAN, |level| level.peak),
            real_deviation: variance(&real).sqrt(),
            last: mean(last),
            path_gap: end(&run.champion.discrepancy.paper),
            path_repeat: end(&run.champion.discrepancy.repeated),
        }
    }

    fn gap(&self) -> f64 {
        self.simulated - self.real
    }

    fn true_gap(&self) -> f64 {
        self.quiet - self.real
    }

    fn on(&self) -> f64 {
        self.last - self.real
    }

    fn peak_fall(&self) -> f64 {
        self.simulated_peak - self.real_peak
    }

    fn failed(&self) -> f64 {
        f64::from(u8::from(self.simulated_peak < FAILED_BELOW))
    }
}

/// The runs of one seed of a robot: in the order of [`Condition::ALL`].
pub(super) type Trio = [Run; 3];
/// A robot and a seed of it.
type Key = (String, u64);
/// The runs of one collision rule, and one reading of equation 1 or one controller, at one severity.
pub(super) type Runs = BTreeMap<Key, Trio>;

/// The same while some conditions may be missing.
type Known = BTreeMap<Key, [Option<Run>; 3]>;

/// A figure of each run number of each robot.
type Contrast<T> = contrasts::Contrast<fn(&T) -> f64>;

/// The contrasts of conditions, a family for each rule, reading and severity.
static OF_CONDITIONS: [Contrast<Trio>; 16] = [
    above("gap sensor - none", &["C3", "C4"], |[none, sensor, _]| {
        sensor.gap() - none.gap()
    }),
    above("gap none - conservative", &["C3"], |[none, _, conservative]| {
        none.gap() - conservative.gap()
    }),
    equivalent("gap conservative = 0", &["C3"], MARGIN, |[_, _, conservative]| {
        conservative.gap()
    }),
    above("true gap none - conservative", &[], |[none, _, conservative]| {
        none.true_gap() - conservative.true_gap()
    }),
    above("peak fall none - sensor", &["C4"], |[none, sensor, _]| {
        none.peak_fall() - sensor.peak_fall()
    }),
    above("simulated none - conservative", &["C5"], |[none, _, conservative]| {
        none.simulated - conservative.simulated
    }),
    above(
        "simulated sensor - conservative",
        &["C5"],
        |[_, sensor, conservative]| sensor.simulated - conservative.simulated,
    ),
    above("real conservative - none", &["C5"], |[none, _, conservative]| {
        conservative.real - none.real
    }),
    above("real conservative - sensor", &["C5"], |[_, sensor, conservative]| {
        conservative.real - sensor.real
    }),
    above("on none", &["C6"], |[none, ..]| none.on()),
    above("on sensor", &["C6"], |[_, sensor, _]| sensor.on()),
    above("on conservative", &["C6"], |[.., conservative]| conservative.on()),
    above("on none - sensor", &["C7"], |[none, sensor, _]| none.on() - sensor.on()),
    above("path none / 2 - conservative", &["C8"], |[none, _, conservative]| {
        none.path_gap / 2.0 - conservative.path_gap
    }),
    above(
        "path sensor / 2 - conservative",
        &["C8"],
        |[_, sensor, conservative]| sensor.path_gap / 2.0 - conservative.path_gap,
    ),
    above("failed conservative - none", &[], |[none, _, conservative]| {
        conservative.failed() - none.failed()
    }),
];

/// The contrasts of C13, which is not registered: a family apart.
static OF_PEAKS: [Contrast<Trio>; 3] = [
    above("25 - peak fall none", &["C13"], |[none, ..]| MARGIN - none.peak_fall()),
    above("25 - peak fall sensor", &["C13"], |[_, sensor, _]| {
        MARGIN - sensor.peak_fall()
    }),
    above("25 - peak fall conservative", &["C13"], |[.., conservative]| {
        MARGIN - conservative.peak_fall()
    }),
];

/// A claim's contrast by a few runs of one robot.
pub(super) struct Shown {
    pub(super) name: &'static str,
    /// Its value in each run number.
    pub(super) values: Vec<f64>,
    /// Whether the 95 % interval of its mean shows it.
    pub(super) part: Part,
    /// Whether the mean alone does.
    pub(super) is_met: bool,
}

/// The contrasts of a claim by the runs of one robot; none if it has none. The conditions of a run number share their seed, as
/// registered; few runs allow no correction over the family.
pub(super) fn of_one_robot(claim: &str, runs: &[Trio]) -> Vec<Shown> {
    let contrasts = OF_CONDITIONS.iter().chain(&OF_PEAKS);
    contrasts
        .filter(|contrast| contrast.claims.contains(&claim))
        .map(|contrast| {
            let values: Vec<f64> = runs.iter().map(contrast.of).collect();
            let (low, high) = contrast.margin.map_or((0.0, f64::INFINITY), |margin| (-margin, margin));
            let mean = mean(&values);
            Shown {
                name: contrast.name,
                part: Part::within(contrast.name, &[(1.0, &values)], [low, high]),
                is_met: low < mean && mean < high,
                values,
            }
        })
        .collect()
}

/// The complete run numbers of a study.
pub(super) fn trios(runs: &[StudyRun]) -> Vec<Trio> {
    let mut known: BTreeMap<u32, [Option<Run>; 3]> = BTreeMap::new();
    for run in runs {
        known.entry(run.number).or_default()[run.condition as usize] = Some(Run::of_study(run));
    }
    let complete = known
        .into_values()
        .filter_map(|[none, sensor, conservative]| Some([none?, sensor?, conservative?]));
    complete.collect()
}

/// The contrasts of the rules undo and slide, a family for each reading and severity.
static OF_RULES: [Contrast<[Trio; 2]>; 6] = [
    above("failed none", &[], |[undo, slide]| undo[0].failed() - slide[0].failed()),
    above("failed sensor", &[], |[undo, slide]| {
        undo[1].failed() - slide[1].failed()
    }),
    above("failed conservative", &[], |[undo, slide]| {
        undo[2].failed() - slide[2].failed()
    }),
    above("true gap none - conservative", &[], |pair| {
        of_second(pair, OF_CONDITIONS[3].of)
    }),
    above("gap sensor - none", &[], |pair| of_second(pair, OF_CONDITIONS[0].of)),
    above("gap none - conservative", &[], |pair| {
        of_second(pair, OF_CONDITIONS[1].of)
    }),
];

/// What a sweep may vary in addition to the collision rule: the reading of equation 1, and the controller.
const VARIED: [&str; 3] = ["task.speed", "task.difference", "controller.layers.0.kind"];
/// The reading that both earlier editions have, and the controller that does not learn, with which others are compared.
const BASES: [&str; 2] = ["unsigned root", "elman"];

/// The contrasts of a reading or a controller and its base, a family for each rule and severity.
static OF_READINGS: [Contrast<[Trio; 2]>; 6] = [
    above("gap none", &[], |pair| of_second(pair, |[none, ..]| none.gap())),
    above("gap conservative", &[], |pair| of_second(pair, OF_CONDITIONS[2].of)),
    above("gap sensor - none", &[], |pair| of_second(pair, OF_CONDITIONS[0].of)),
    above("gap none - conservative", &[], |pair| {
        of_second(pair, OF_CONDITIONS[1].of)
    }),
    above("real conservative - none", &[], |pair| {
        of_second(pair, OF_CONDITIONS[7].of)
    }),
    above("path repeat none - conservative", &[], |pair| {
        of_second(pair, |[none, _, conservative]| {
            none.path_repeat - conservative.path_repeat
        })
    }),
];

/// How much larger a figure is in the second of two cells, such as where bodies slide.
fn of_second([first, second]: &[Trio; 2], of: fn(&Trio) -> f64) -> f64 {
    of(second) - of(first)
}

/// Which runs a family is judged by.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kept<'a> {
    All,
    Without(&'a str),
    /// The first or the second half of each robot's seeds.
    Half(usize),
    /// Those where no condition failed.
    Converged,
}

/// A contrast's values by robot.
fn by_robot<T>(
    data: &BTreeMap<Key, T>,
    kept: Kept<'_>,
    has_failed: fn(&T) -> bool,
    of: fn(&T) -> f64,
) -> Vec<Vec<f64>> {
    let mut robots: BTreeMap<&str, Vec<&T>> = BTreeMap::new();
    for ((robot, _), runs) in data {
        robots.entry(robot).or_default().push(runs);
    }
    let values_of = |(robot, all): (&str, Vec<&T>)| -> Vec<f64> {
        let half = all.len() / 2;
        let runs: Vec<&T> = match kept {
            Kept::Without(other) if other == robot => Vec::new(),
            Kept::All | Kept::Without(_) => all,
            Kept::Half(0) => all[..half].to_vec(),
            Kept::Half(_) => all[half..].to_vec(),
            Kept::Converged => all.into_iter().filter(|runs| !has_failed(runs)).collect(),
        };
        runs.into_iter().map(of).collect()
    };
    let groups = robots.into_iter().map(values_of);
    groups.filter(|values| !values.is_empty()).collect()
}

/// Estimates the mean of a contrast. Robots can have different numbers of converged runs, so they enter by their means.
fn estimate(groups: &[Vec<f64>], kept: Kept<'_>, margin: Option<f64>) -> std::result::Result<Estimate, Undefined> {
    let (value, error, df) = if kept == Kept::Converged {
        let means: Vec<f64> = groups.iter().map(mean).collect();
        let error = (variance(&means) / means.len() as f64).sqrt();
        (mean(&means), error, means.len() as f64 - 1.0)
    } else if groups.len() < 2 {
        (f64::NAN, f64::NAN, 0.0)
    } else {
        let fitted = nested_mean(groups)?;
        (fitted.mean, fitted.standard_error, fitted.df)
    };
    Ok(Estimate::new(value, error, df, margin))
}

/// Judges a family.
fn family<T>(
    data: &BTreeMap<Key, T>,
    contrasts: &[Contrast<T>],
    kept: Kept<'_>,
    has_failed: fn(&T) -> bool,
) -> std::result::Result<Vec<Judged>, Undefined> {
    let estimates = contrasts.iter().map(|contrast| {
        let groups = by_robot(data, kept, has_failed, contrast.of);
        estimate(&groups, kept, contrast.margin)
    });
    contrasts::family(estimates.collect::<std::result::Result<_, _>>()?)
}

static COLUMNS: LazyLock<Vec<Column>> = LazyLock::new(|| {
    let words = [
        Column::text(
            "severity",
            "the severity of reality; two, of what sensors see and of motion, where they differ",
        ),
        Column::text(
            "rule",
            "the simulator's collision rule, with the reading of equation 1 (its V and its DV) or the controller if the sweep varies it; of two, \
             what the second changes: `slide - undo`, `signed square - unsigned root`, or `plastic - elman`",
        ),
        Column::text(
            "contrast",
            "what is compared, see studies/preregistration-1995-second.md, -third.md and -plastic.md",
        ),
        Column::text("claims", "the claims that it belongs to"),
    ];
    let firmness = [
        Column::whole(
            "changed_by_robots",
            "",
            "the number of robots without which, one at a time, the outcome changes",
        ),
        Column::text("first_half", "the outcome with the first half of each robot's runs"),
        Column::text("second_half", "the outcome with the second half"),
        Column::text("converged", "the outcome with the runs in which no condition failed"),
    ];
    let unit = "its estimate: points of fitness, mm of the paths, or a fraction of the runs";
    let survives = Column::text(
        "survives",
        "`yes` if the outcome is the same without any one robot, in both halves, and with converged runs, else `no`",
    );
    let estimate = contrasts::estimate_columns(unit);
    let criteria = contrasts::other_criteria_columns();
    words
        .into_iter()
        .chain(estimate)
        .chain(firmness)
        .chain(criteria)
        .chain([survives])
        .collect()
});

const SEVERITY: Column = Column::text("severity", "the severity of reality");
const RULE: Column = Column::text(
    "rule",
    "the simulator's collision rule, with the reading of equation 1 (its V and its DV) or the controller if the sweep varies it",
);

static CLAIM_COLUMNS: LazyLock<Vec<Column>> = LazyLock::new(|| [&[SEVERITY, RULE][..], &contrasts::CLAIM].concat());

static CELL_COLUMNS: [Column; 13] = [
    SEVERITY,
    RULE,
    Column::text("noise", "the simulator's noise"),
    Column::whole("runs", "", "runs of all robots"),
    Column::number("failed", "", "the fraction of runs that failed to converge"),
    Column::number(
        "simulated",
        "",
        "mean fitness of generation 200 in the simulator as evolved",
    ),
    Column::number("quiet", "", "the same without the simulator's noise"),
    Column::number("real", "", "the same in reality"),
    Column::number("last", "", "mean fitness of generation 219 in reality"),
    Column::number(
        "d",
        "",
        "Cohen's d of generation 200, simulated minus real, over all individuals of a robot; mean over robots",
    ),
    Column::number("d_error", "", "the standard error of that mean"),
    Column::number("path_gap_mm", "mm", "mean distance of paths in simulator and reality"),
    Column::number("path_repeat_mm", "mm", "mean distance of two paths in reality"),
];

/// The files that judging writes.
pub(crate) fn contents() -> Vec<Entry> {
    vec![
        Entry::table(CONTRASTS, "one row per contrast, severity and rule", COLUMNS.iter()),
        Entry::table(CLAIMS, "one row per claim, severity and rule", CLAIM_COLUMNS.iter()),
        Entry::table(CELLS, "one row per severity, rule and noise", &CELL_COLUMNS),
        Entry::table(
            CALIBRATION,
            "of a sweep without noise over two severities: one row per rule and pair of severities",
            &calibration::COLUMNS,
        ),
    ]
}

/// Judges the runs of finished sweeps, and writes all tables to a directory if one is given. Returns the claims.
pub fn judge_sweeps(sweeps: &[PathBuf], out: Option<&Path>) -> Result<Answer<Findings>> {
    let mut found = Found::default();
    sweep_results::each_table(sweeps, |path, text| parse(path, text, &mut found))?;
    let mut files = Vec::new();
    let mut text = String::new();
    if !found.all.is_empty() {
        let tables = Tables::of(&found.all).map_err(Failure::input)?;
        let head: Vec<&str> = CLAIM_COLUMNS.iter().map(|column| column.name.as_ref()).collect();
        text += &columns(&head, &tables.shown);
        files.extend([
            (CONTRASTS, tables.contrasts),
            (CLAIMS, tables.claims),
            (CELLS, tables.cells),
        ]);
    }
    if !found.pairs.is_empty() {
        let table = calibration::table(&found.pairs);
        text += &table;
        files.push((CALIBRATION, table));
    }
    if let Some(out) = out {
        let what = "The second edition of the 1995 study, judged.";
        sweep_results::write(out, what, &files, &contents())?;
    }
    Ok(Answer::new(text, sweep_results::findings(&files)))
}

/// The runs of sweeps: those that are judged, by severity and rule, and those of a calibration.
#[derive(Default)]
struct Found {
    all: BTreeMap<(String, String), Runs>,
    pairs: Pairs,
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
    fn of(all: &BTreeMap<(String, String), Runs>) -> std::result::Result<Self, Undefined> {
        let (mut contrasts, mut claims) = (Vec::new(), Csv::new(CLAIM_COLUMNS.iter()));
        let mut cells = Csv::new(&CELL_COLUMNS);
        let mut shown = Vec::new();
        for ((severity, rule), runs) in all {
            let has_failed = |trio: &Trio| trio.iter().any(|run| run.failed() > 0.0);
            let judged = rows([severity, rule], runs, &OF_CONDITIONS, has_failed, &mut contrasts)?;
            for claim in ["C3", "C4", "C5", "C6", "C7", "C8"] {
                let (outcome, reasons) = contrasts::of_claim(claim, &judged, &OF_CONDITIONS);
                let row = |reason: &str| [severity, rule, claim, outcome.word(), reason].map(str::to_owned);
                claims.row(row(&reasons.join("; ")));
                shown.push(row(&brief(&reasons)).into());
            }
            for condition in Condition::ALL {
                cells.row(
                    [severity.clone(), rule.clone(), condition.name().to_owned()]
                        .into_iter()
                        .chain(cell(runs, condition)),
                );
            }
        }
        let severities: BTreeSet<&String> = all.keys().map(|(severity, _)| severity).collect();
        for severity in severities {
            let of_cell = |rule: &str| all.get(&(severity.clone(), rule.to_owned()));
            let mut compared = |what: &str, [first, second]: [&str; 2], contrasts_of: &[Contrast<[Trio; 2]>]| {
                let (Some(first), Some(second)) = (of_cell(first), of_cell(second)) else {
                    return Ok::<_, Undefined>(());
                };
                let pairs = first
                    .iter()
                    .filter_map(|(key, first)| Some((key.clone(), [*first, *second.get(key)?])));
                let has_failed = |pair: &[Trio; 2]| pair.iter().flatten().any(|run| run.failed() > 0.0);
                let what = [severity, what];
                rows(what, &pairs.collect(), contrasts_of, has_failed, &mut contrasts).map(drop)
            };
            let cells: Vec<&str> = all
                .keys()
                .filter(|(own, _)| own == severity)
                .map(|(_, cell)| cell.as_str())
                .collect();
            for slide in cells.iter().filter(|cell| cell.starts_with("slide")) {
                let undo = slide.replacen("slide", "undo", 1);
                let what = slide.replacen("slide", "slide - undo", 1);
                compared(&what, [&undo, slide], &OF_RULES)?;
            }
            for cell in cells {
                let Some((rule, own)) = cell.split_once(' ').filter(|(_, own)| !BASES.contains(own)) else {
                    continue;
                };
                for base in BASES {
                    let what = format!("{rule} {own} - {base}");
                    compared(&what, [&format!("{rule} {base}"), cell], &OF_READINGS)?;
                }
            }
        }
        Ok(Self {
            contrasts: contrasts::table(&COLUMNS, &contrasts)?,
            claims: claims.text(),
            cells: cells.text(),
            shown,
        })
    }
}

/// Judges a family, also by fewer runs, and writes its rows.
fn rows<T>(
    [severity, rule]: [&str; 2],
    data: &BTreeMap<Key, T>,
    contrasts: &[Contrast<T>],
    has_failed: fn(&T) -> bool,
    table: &mut Vec<Row>,
) -> std::result::Result<Vec<Judged>, Undefined> {
    let by = |kept| family(data, contrasts, kept, has_failed);
    let judged = by(Kept::All)?;
    let robots: BTreeSet<&String> = data.keys().map(|(robot, _)| robot).collect();
    let without = robots.into_iter().map(|robot| by(Kept::Without(robot)));
    let without: Vec<Vec<Judged>> = without.collect::<std::result::Result<_, _>>()?;
    let others = [by(Kept::Half(0))?, by(Kept::Half(1))?, by(Kept::Converged)?];
    for (index, (row, contrast)) in judged.iter().zip(contrasts).enumerate() {
        let changed = without
            .iter()
            .filter(|other| other[index].outcome != row.outcome)
            .count();
        let others = others.each_ref().map(|other| other[index].outcome);
        let survives = changed == 0 && others.iter().all(|other| *other == row.outcome);
        let firmness = others.map(|other| other.word().to_owned());
        table.push(Row {
            words: [severity, rule, contrast.name, &contrast.claims.join(" ")]
                .map(str::to_owned)
                .into(),
            judged: *row,
            firmness: std::iter::once(changed.to_string()).chain(firmness).collect(),
            survives,
            is_by_criteria: false,
        });
    }
    Ok(judged)
}

/// The numbers of a condition.
fn cell(runs: &Runs, condition: Condition) -> Vec<String> {
    let mut robots: BTreeMap<&str, Vec<&Run>> = BTreeMap::new();
    for ((robot, _), trio) in runs {
        robots.entry(robot).or_default().push(&trio[condition as usize]);
    }
    let all = || robots.values().flatten();
    let average = |of: fn(&Run) -> f64| mean(all().map(|run| of(run)).collect::<Vec<_>>());
    let d: Vec<f64> = robots.values().map(|runs| effect(runs)).collect();
    let error = one_sample_t(&d, 0.0).map_or(f64::NAN, |test| (mean(&d) / test.t).abs());
    let numbers = [
        average(Run::failed),
        average(|run| run.simulated),
        average(|run| run.quiet),
        average(|run| run.real),
        average(|run| run.last),
        mean(&d),
        error,
        average(|run| run.path_gap),
        average(|run| run.path_repeat),
    ];
    std::iter::once(all().count().to_string())
        .chain(numbers.map(number))
        .collect()
}

/// Cohen's d of all individuals of a robot's runs, simulated minus real, from the runs' means and standard deviations.
pub(super) fn effect(runs: &[&Run]) -> f64 {
    let squares = |of: fn(&Run) -> [f64; 2]| {
        let grand = mean(runs.iter().map(|run| of(run)[0]).collect::<Vec<_>>());
        let squares_of_runs = runs.iter().map(|run| of(run)).map(|[mean, deviation]| {
            (INDIVIDUALS - 1.0) * deviation * deviation + INDIVIDUALS * (mean - grand) * (mean - grand)
        });
        (grand, squares_of_runs.sum::<f64>())
    };
    let (simulated, one) = squares(|run| [run.simulated, run.simulated_deviation]);
    let (real, other) = squares(|run| [run.real, run.real_deviation]);
    let count = 2.0 * INDIVIDUALS * runs.len() as f64 - 2.0;
    (simulated - real) / ((one + other) / count).sqrt()
}

/// Parses the runs of a sweep's table. One without noise over two severities is a calibration.
fn parse(path: &Path, text: &str, into: &mut Found) -> Result {
    const MOTION: &str = "reality.motion_severity";
    let needed = ["reality.severity", "robot.collision", "reality.robot", "seed"];
    let mut found: BTreeMap<(String, String), Known> = BTreeMap::new();
    sweep_results::each_row((path, text), "studies/miglino1995/second", &needed, |row| {
        let run = Run::read(|column| row.number(column, |number| number.is_finite(), "a number"))?;
        let severity = row.cell("reality.severity")?;
        let motion = row.find(MOTION).unwrap_or(severity);
        let [mut rule, robot] = [row.cell("robot.collision")?, row.cell("reality.robot")?].map(str::to_owned);
        for value in VARIED.iter().filter_map(|key| row.find(key)) {
            rule = [&rule, " ", value].concat();
        }
        if row.find("noise.sensor").is_none() && row.find(MOTION).is_some() {
            let severities = [severity, motion].map(str::to_owned);
            let robots = into.pairs.entry((rule, severities)).or_default();
            robots.entry(robot).or_default().push(run);
            return Ok(());
        }
        let [sensor, walk] = [row.cell("noise.sensor")?, row.cell("noise.walk_range_mm")?];
        let condition = match (sensor == "[0.0, 0.0]", walk == "0.0") {
            (true, true) => Condition::None,
            (false, true) => Condition::Sensor,
            (true, false) => Condition::Conservative,
            (false, false) => return Err(row.bad("has both kinds of noise; allowed: one of them")),
        };
        let severity = if motion == severity {
            severity.to_owned()
        } else {
            format!("{severity}/{motion}")
        };
        let runs = found.entry((severity, rule)).or_default();
        let trio = runs.entry((robot, row.seed()?)).or_default();
        trio[condition as usize] = Some(run);
        Ok(())
    })?;
    for (cell, runs) in found {
        let trios = into.all.entry(cell).or_default();
        for ((robot, seed), trio) in runs {
            let [Some(none), Some(sensor), Some(conservative)] = trio else {
                let problem =
                    format_args!("lacks a condition of seed {seed} of {robot}; allowed: a run of each of the three");
                return Err(sweep_results::bad(path, 1, problem));
            };
            trios.insert((robot, seed), [none, sensor, conservative]);
        }
    }
    Ok(())
}

/// A claim's verdict over all robots, and its contrasts: the name, the estimate with its interval, and the outcome.
#[cfg(test)]
pub(super) type OfAllRobots = (
    &'static str,
    crate::verdict::Verdict,
    Vec<(&'static str, [f64; 3], crate::verdict::Verdict)>,
);

/// The claims over all robots of a rule and severity: C3 to C8 by the registered family, C13 by its own.
#[cfg(test)]
pub(super) fn of_all_robots(runs: &Runs) -> Vec<OfAllRobots> {
    let families = [
        (&OF_CONDITIONS[..], &["C3", "C4", "C5", "C6", "C7", "C8"][..]),
        (&OF_PEAKS[..], &["C13"]),
    ];
    let judged = families.map(|(contrasts, claims)| {
        let judged = family(runs, contrasts, Kept::All, |_| false).unwrap();
        claims
            .iter()
            .map(move |claim| {
                let (verdict, _) = contrasts::of_claim(claim, &judged, contrasts);
                let pairs = contrasts
                    .iter()
                    .zip(&judged)
                    .filter(|(contrast, _)| contrast.claims.contains(claim));
                let of_claim = pairs
                    .map(|(contrast, judged)| (contrast.name, judged.figures(), judged.outcome))
                    .collect();
                (*claim, verdict, of_claim)
            })
            .collect::<Vec<OfAllRobots>>()
    });
    judged.concat()
}

/// The runs of a table of one rule and severity.
#[cfg(test)]
pub(super) fn runs_of(path: &Path) -> Runs {
    let mut found = Found::default();
    parse(path, &std::fs::read_to_string(path).unwrap(), &mut found).unwrap();
    assert_eq!(found.all.len(), 1);
    found.all.into_values().next().unwrap()
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "run,noise.sensor,noise.walk_range_mm,reality.severity,robot.collision,reality.robot,seed,simulated,simulated_peak,\
                        simulated_deviation,quiet,real,real_peak,real_deviation,last,path_gap_mm,path_repeat_mm";

    /// A table of eight robots with four runs; `of` gives a run's figures by rule (0: undo) and condition, `spread` within 2 of 0.
    fn table(of: impl Fn(usize, Condition, f64) -> [f64; 10]) -> String {
        let mut text = HEAD.to_owned();
        for (rule, name) in ["undo", "slide"].into_iter().enumerate() {
            for robot in 0..8 {
                for seed in 0..4 {
                    let spread = f64::from((robot * 5 + seed * 3) % 7) / 2.0 - 1.5;
                    for condition in Condition::ALL {
                        let noise = match condition {
                            Condition::None => "\"[0.0, 0.0]\",0.0",
                            Condition::Sensor => "\"[0.0, 0.4]\",0.0",
                            Condition::Conservative => "\"[0.0, 0.0]\",30.0",
                        };
                        let figures = of(rule, condition, spread * (1.0 + f64::from(condition as u8)));
                        let figures = figures.map(|figure| figure.to_string()).join(",");
                        let seed = 10 * robot + seed;
                        let row = [
                            "0",
                            noise,
                            "1.0",
                            name,
                            &format!("surrogate:{robot}"),
                            &seed.to_string(),
                            &figures,
                        ];
                        text = [text, row.join(",")].join("\n");
                    }
                }
            }
        }
        text
    }

    /// Figures of the paper: with sensor noise the average falls most and the peak falls little; with conservative noise
    /// there is no gap.
    fn as_in_the_paper(rule: usize, condition: Condition, spread: f64) -> [f64; 10] {
        let (simulated, real, peak, path) = match condition {
            Condition::None => (300.0, 250.0, 250.0, 9000.0),
            Condition::Sensor => (300.0, 200.0, 290.0, 9000.0),
            Condition::Conservative => (280.0, 280.0, 300.0, 3000.0),
        };
        let failed = rule == 0 && condition == Condition::Conservative && spread > 1.0;
        let simulated_peak = if failed { 90.0 } else { 330.0 };
        let on = if condition == Condition::None { 40.0 } else { 20.0 };
        [
            simulated + spread,
            simulated_peak,
            30.0,
            simulated,
            real,
            peak,
            30.0,
            real + on + spread,
            path + spread,
            path / 2.0,
        ]
    }

    fn judged(text: &str) -> Result<Tables> {
        let mut found = Found::default();
        parse(Path::new("results.csv"), text, &mut found)?;
        Ok(Tables::of(&found.all).unwrap())
    }

    fn outcome(table: &str, begin: &str, column: usize) -> String {
        let row = table
            .lines()
            .find(|row| row.starts_with(begin))
            .unwrap_or_else(|| panic!("{begin} in\n{table}"));
        row.split(',').nth(column).unwrap().to_owned()
    }

    #[test]
    fn what_the_paper_says_holds_and_its_contrary_is_opposed() {
        let tables = judged(&table(as_in_the_paper)).unwrap();
        for claim in ["C3", "C4", "C5", "C6", "C7", "C8"] {
            assert_eq!(
                outcome(&tables.claims, &format!("1.0,slide,{claim},"), 3),
                "holds",
                "{}",
                tables.contrasts
            );
        }
        assert_eq!(
            outcome(&tables.contrasts, "1.0,slide - undo,failed conservative,", 9),
            "holds"
        );
        assert_eq!(
            outcome(&tables.contrasts, "1.0,slide - undo,failed none,", 9),
            "undecided"
        );
        assert_eq!(outcome(&tables.cells, "1.0,slide,conservative,", 4), "0");
        assert_ne!(outcome(&tables.cells, "1.0,undo,conservative,", 4), "0");
        // Sensor and conservative noise change places.
        let exchanged = |rule, condition, spread| {
            let other = match condition {
                Condition::None => Condition::None,
                Condition::Sensor => Condition::Conservative,
                Condition::Conservative => Condition::Sensor,
            };
            as_in_the_paper(rule, other, spread)
        };
        let tables = judged(&table(exchanged)).unwrap();
        for (claim, expected) in [("C3", "opposed"), ("C5", "opposed"), ("C6", "holds"), ("C8", "opposed")] {
            assert_eq!(
                outcome(&tables.claims, &format!("1.0,slide,{claim},"), 3),
                expected,
                "{}",
                tables.contrasts
            );
        }
        // A gap of 100 is not equivalent to none, whatever its sign.
        assert_eq!(
            outcome(&tables.contrasts, "1.0,slide,gap conservative = 0,", 9),
            "opposed"
        );
    }

    #[test]
    fn an_outcome_that_hangs_on_one_robot_says_so() {
        // One robot of eight has all of the difference, and halves agree.
        let text = table(|_, condition, spread| {
            let gap = if condition == Condition::Sensor { 10.0 } else { 0.0 };
            [
                300.0 + gap + spread,
                330.0,
                30.0,
                300.0,
                300.0,
                330.0,
                30.0,
                300.0,
                900.0,
                900.0,
            ]
        });
        let tables = judged(&text).unwrap();
        assert_eq!(outcome(&tables.contrasts, "1.0,undo,gap sensor - none,", 9), "holds");
        assert_eq!(outcome(&tables.contrasts, "1.0,undo,gap sensor - none,", 17), "yes");
        let one = |row: &str| -> String {
            if !row.contains("surrogate:3,") && row.contains("0.4]") {
                let mut cells: Vec<String> = row.rsplitn(11, ',').map(str::to_owned).collect();
                cells[9] = (cells[9].parse::<f64>().unwrap() - 12.0).to_string();
                cells.reverse();
                return cells.join(",");
            }
            row.to_owned()
        };
        let text: Vec<String> = text.lines().map(one).collect();
        let tables = judged(&text.join("\n")).unwrap();
        assert_eq!(
            outcome(&tables.contrasts, "1.0,undo,gap sensor - none,", 17),
            "no",
            "{}",
            tables.contrasts
        );
    }

    #[test]
    fn tables_of_something_else_are_refused() {
        let whole = table(as_in_the_paper);
        let refused = |text: &str| judged(text).map(|_| ()).unwrap_err().to_string();
        let problem = refused(&whole.replace("path_gap_mm", "path"));
        assert!(
            problem.contains("results.csv:1: has no column path_gap_mm; allowed: "),
            "{problem}"
        );
        let problem = refused(&whole.replacen("330,", "NaN,", 1));
        assert!(
            problem.contains("results.csv:2: simulated_peak is \"NaN\"; allowed: a number"),
            "{problem}"
        );
        let (short, _) = whole.rsplit_once('\n').unwrap();
        let problem = refused(short);
        assert!(
            problem.contains("lacks a condition of seed 73 of surrogate:7; allowed: "),
            "{problem}"
        );
        let problem = refused(&whole.replacen("\"[0.0, 0.4]\",0.0", "\"[0.0, 0.4]\",30.0", 1));
        assert!(
            problem.contains("results.csv:3: has both kinds of noise; allowed: one of them"),
            "{problem}"
        );
    }
}
