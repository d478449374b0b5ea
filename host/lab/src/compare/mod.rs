//! Different experiments with one score, side by side: their champions in common new episodes, or their recorded scores.
//!
//! | file | contents |
//! |---|---|
//! | [`sources`] | finished runs, from their directories and from sweeps |
//! | [`links`] | from the report to the pages of runs |

mod links;
pub mod sources;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use oneiro::evaluator::{Control, Evaluator};
use oneiro_base::contents::{Column, Entry};
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_evolve::Population;
use oneiro_evolve::appraisal::Appraisal;
use oneiro_evolve::settings::Kind;
use oneiro_report::csv::{Csv, known};
use oneiro_report::page;
use serde_json::Value;

use crate::experiment::{Difference, SCORE_NAME};
use crate::lives::{Keys, Lives};
use crate::sweep::report::conditions::{self, CONDITION};
use crate::sweep::report::curves::{best_at, in_equal_parts, shared_times};
use crate::sweep::report::{Compared, Tables};
use sources::Condition;

/// Files of a comparison.
pub const PAGE: &str = "compare.html";
const RUNS: &str = "compare.csv";
const CURVES: &str = "curves.csv";
const CONDITIONS: &str = "conditions.csv";
const EFFECTS: &str = "effects.csv";

static RUNS_COLUMNS: [Column; 12] = [
    Column::whole(
        "run",
        "",
        "its number, from 0: condition by condition, and seed by seed within one",
    ),
    Column::text("id", "the hash of the run's experiment and seed"),
    Column::text(CONDITION, "its condition"),
    Column::whole("seed", "", "the run's seed"),
    Column::text(
        "source",
        "the run's directory, or its sweep's with the run's number there",
    ),
    Column::whole(
        "episodes",
        "",
        "episodes that its evolution may spend, without those of finalists",
    ),
    Column::number(
        "score",
        "",
        "what runs are compared by: the mean of the champion's new episodes, or its recorded score; empty if that is not a number",
    ),
    Column::number(
        "score_low",
        "",
        "the lower bound of the 95 % confidence interval of the mean of new episodes, by Student's t; empty for a recorded score",
    ),
    Column::number("score_high", "", "its upper bound"),
    Column::number(
        "recorded_mean",
        "",
        "the recorded mean of the champion's new episodes (`evolution.finalist_lives`); empty without finalists",
    ),
    Column::number("fitness", "", "the highest score of any individual in its generation"),
    Column::text("result", "the hash of the run's results"),
];

static CURVES_COLUMNS: [Column; 3] = [
    Column::whole("run", "", "the run's number in `compare.csv`"),
    Column::whole("episodes", "", "episodes that its evolution has spent"),
    Column::number("best", "", "the highest score in any generation so far"),
];

/// The files of a comparison's directory.
pub fn contents() -> Vec<Entry> {
    vec![
        Entry::file(PAGE, "the report: conditions, figures and tests"),
        Entry::file(format!("{}/", page::FIGURES), page::FIGURES_ABOUT),
        Entry::table(CONDITIONS, "one row per condition", &conditions::COLUMNS),
        Entry::table(RUNS, "one row per run", &RUNS_COLUMNS),
        Entry::table(
            CURVES,
            "the best score by episodes spent, at common times: a run that ends before others of its condition keeps its best",
            &CURVES_COLUMNS,
        ),
        Entry::table(
            EFFECTS,
            "one row per pair of conditions compared, with the columns of a sweep's `effects.csv`",
            conditions::effects_columns(),
        ),
    ]
}

/// What champions are compared by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Score {
    /// The mean of this many new episodes, on random numbers common to all.
    New { episodes: u32, seed: u64 },
    /// The recorded mean of its finalist's episodes.
    RecordedMean,
    /// The highest recorded score of any individual in its generation.
    Fitness,
}

impl Score {
    /// `worlds` says which worlds new episodes are in.
    fn words(self, worlds: &str) -> String {
        match self {
            Self::New { episodes, seed } => {
                format!(
                    "mean fitness of the champion in {episodes} new episodes with the same random numbers for all (seed {seed}), {worlds}; \
                     more is better"
                )
            }
            Self::RecordedMean => {
                "recorded mean fitness of the champion\u{2019}s new episodes, each run\u{2019}s own; more is better"
                    .to_owned()
            }
            Self::Fitness => {
                "recorded fitness of the best individual in its generation, by which it was selected; more is better"
                    .to_owned()
            }
        }
    }

    /// Name of an axis.
    fn axis(self) -> &'static str {
        match self {
            Self::New { .. } => "mean fitness of the champion in new episodes",
            Self::RecordedMean => "recorded mean fitness of the champion",
            Self::Fitness => "recorded fitness of the best individual",
        }
    }
}

/// How conditions can be compared, and what is doubtful about it.
#[derive(Debug)]
pub struct Plan {
    pub score: Score,
    pub warnings: Vec<String>,
    /// Keys of worlds in which conditions differ, with the values of the first and of the other.
    pub differences: Vec<String>,
    /// Values that all conditions were given for new episodes, as typed.
    pub set: Vec<String>,
}

impl Plan {
    /// Decides by what conditions are compared: by `new`, episodes and a seed, if they share their task, else by what was recorded.
    ///
    /// # Errors
    /// Exit 3 if their scores count different things.
    pub fn of(conditions: &[Condition], new: Option<(u32, u64)>, set: &[String]) -> Result<Self> {
        let Some((first, others)) = conditions.split_first() else {
            return Err(Failure::input("there are no conditions"));
        };
        let mut warnings = Vec::new();
        let mut of_tasks: BTreeMap<String, String> = BTreeMap::new();
        for other in others {
            let differences = first.experiment.task_differences(&other.experiment);
            if let Some(named) = differences.iter().find(|own| SCORE_NAME.contains(&own.key.as_str())) {
                return Err(not_comparable(named, first, other));
            }
            for difference in differences {
                let words = values(&difference, first, other);
                of_tasks.entry(difference.key).or_insert(words);
            }
        }
        let shares_task = of_tasks.is_empty();
        if !shares_task {
            let all: Vec<_> = of_tasks.iter().map(|(key, words)| format!("{key}: {words}")).collect();
            warnings.push(format!(
                "tasks differ in {}: so recorded scores are compared, each of the condition's task",
                all.join("; ")
            ));
        }
        let score = match new {
            Some((episodes, seed)) if shares_task => Score::New { episodes, seed },
            _ if conditions
                .iter()
                .flat_map(|own| &own.runs)
                .all(|run| run.mean.is_some()) =>
            {
                Score::RecordedMean
            }
            _ => Score::Fitness,
        };
        if score == Score::Fitness {
            warnings.push(
                "some runs have no finalists (evolution.finalists), so runs are compared by the scores that selected their best, which \
                 are too high by luck"
                    .to_owned(),
            );
            warnings.extend(combinations(first, others)?);
        }
        warnings.extend(budgets(conditions));
        Ok(Self {
            score,
            warnings,
            differences: differences(first, others),
            set: set.to_vec(),
        })
    }

    /// The worlds of new episodes, for readers.
    fn worlds(&self) -> String {
        match (&self.set[..], &self.differences[..]) {
            ([], []) => "in the world that all share".to_owned(),
            ([], _) => "each in the world of its condition".to_owned(),
            (set, []) => format!("all with {}", set.join(" and ")),
            (set, _) => format!(
                "all with {}, else each in the world of its condition",
                set.join(" and ")
            ),
        }
    }
}

/// Checks how the fitness of several episodes was combined; a warning if not of as many.
fn combinations(first: &Condition, others: &[Condition]) -> Result<Option<String>> {
    let trials = |own: &Condition| own.experiment.settings().trials;
    for other in others {
        let all = first.experiment.score_differences(&other.experiment);
        if let Some(difference) = all.iter().find(|own| own.key == "trial_score")
            && (trials(first) > 1 || trials(other) > 1)
        {
            return Err(not_comparable(difference, first, other));
        }
    }
    let other = others.iter().find(|other| trials(other) != trials(first));
    Ok(other.map(|other| {
        format!(
            "scores are of different numbers of episodes: trials = {} ({}), {} ({})",
            trials(first),
            first.name,
            trials(other),
            other.name
        )
    }))
}

/// A warning if runs of different conditions may spend different numbers of episodes.
fn budgets(conditions: &[Condition]) -> Option<String> {
    // Equal budgets of `evolution.episodes` stay equal, whatever is left of them for whole generations.
    let budget = |own: &Condition| {
        let given = own.experiment.settings().evolution.budget;
        given.unwrap_or_else(|| own.experiment.episodes().total())
    };
    let words = |own: &Condition| format!("{} ({})", budget(own), own.name);
    let least = conditions.iter().min_by_key(|own| budget(own))?;
    let most = conditions.iter().max_by_key(|own| budget(own))?;
    (budget(least) < budget(most)).then(|| {
        format!(
            "budgets are unequal: from {} to {} episodes a run",
            words(least),
            words(most)
        )
    })
}

fn not_comparable(difference: &Difference, first: &Condition, other: &Condition) -> Failure {
    Failure::input(format_args!(
        "scores are not comparable: {}: {}; allowed: experiments whose scores count the same",
        difference.key,
        values(difference, first, other)
    ))
}

fn values(Difference { values: [one, two], .. }: &Difference, first: &Condition, other: &Condition) -> String {
    format!("{} ({}), {} ({})", short(one), first.name, short(two), other.name)
}

/// The beginning of a long value.
fn short(value: &str) -> String {
    const LETTERS: usize = 60;
    if value.chars().count() <= LETTERS {
        return value.to_owned();
    }
    value.chars().take(LETTERS).chain(['\u{2026}']).collect()
}

/// The keys in which worlds differ, each once, except what controllers are made of, which is what conditions are for.
fn differences(first: &Condition, others: &[Condition]) -> Vec<String> {
    let mut known: BTreeMap<String, String> = BTreeMap::new();
    for other in others {
        for difference in first.experiment.differences(&other.experiment) {
            let words = || format!("{}: {}", difference.key, values(&difference, first, other));
            if !difference.key.starts_with("files.") {
                known.entry(difference.key.clone()).or_insert_with(words);
            }
        }
    }
    known.into_values().collect()
}

/// Re-evaluates the champions of all runs in new episodes, in the worlds of their conditions. Random numbers are common to all.
///
/// # Errors
/// As the evaluator's.
pub fn appraised(
    conditions: &[Condition],
    (episodes, seed): (u32, u64),
    evaluator: &mut dyn Evaluator,
    control: &Control,
) -> Result<Vec<Vec<Appraisal>>> {
    let of_condition = |own: &Condition| {
        let genomes = champions(own);
        let lives = lives(own, &genomes, (episodes, seed));
        let fitness = lives.fitness(&mut *evaluator, control)?;
        Ok(fitness.chunks_exact(episodes as usize).map(Appraisal::of).collect())
    };
    conditions.iter().map(of_condition).collect()
}

/// Robot-steps of [`appraised`].
pub fn steps(conditions: &[Condition], episodes: u32) -> u64 {
    let of_condition = |own: &Condition| lives(own, &champions(own), (episodes, 0)).steps();
    conditions.iter().map(of_condition).fold(0, u64::saturating_add)
}

fn champions(condition: &Condition) -> Population {
    let genes: Vec<f32> = condition
        .runs
        .iter()
        .flat_map(|run| run.champion.iter().copied())
        .collect();
    Population::new(condition.experiment.world().gene_layout().genes(), genes)
}

fn lives<'a>(condition: &'a Condition, genomes: &'a Population, (episodes, seed): (u32, u64)) -> Lives<'a> {
    Lives {
        worlds: std::slice::from_ref(condition.experiment.world()),
        genomes,
        count: episodes as usize,
        keys: Keys::of_champions(seed),
    }
}

/// What was written.
#[derive(Debug)]
pub struct Written {
    pub files: Vec<PathBuf>,
    pub json: Value,
    /// A table for people.
    pub heads: [&'static str; 7],
    pub rows: Vec<Vec<String>>,
    /// The same of the pairs that are tested.
    pub heads_of_pairs: [&'static str; 6],
    pub pairs: Vec<Vec<String>>,
}

/// Writes the report and its tables into a directory, in place of earlier ones. `appraisals` are those of new episodes.
///
/// # Errors
/// Exit 6 if writing fails.
pub fn write(
    out: &Path,
    conditions: &[Condition],
    plan: &Plan,
    appraisals: Option<&[Vec<Appraisal>]>,
) -> Result<Written> {
    let [runs, curves] = [RUNS, CURVES].map(|name| out.join(name));
    disk::write(&runs, table_of_runs(conditions, plan, appraisals).as_bytes())?;
    disk::write(&curves, table_of_curves(conditions).as_bytes())?;
    let names: Vec<&str> = conditions.iter().map(|own| own.name.as_str()).collect();
    let is_unknown = |own: &Condition| {
        let is_race = own.experiment.settings().evolution.kind == Kind::Race;
        is_race && own.runs.iter().any(|run| run.spent.is_none())
    };
    let caption = if conditions.iter().any(is_unknown) {
        "The left panel shows scores that selection saw: the best of each generation is too high by luck, more so with fewer episodes an \
         individual. A race\u{2019}s generations have different numbers of episodes, which sweeps do not record: they are drawn as if these \
         were equal."
    } else {
        "The left panel shows scores that selection saw: the best of each generation is too high by luck, more so with fewer episodes an \
         individual."
    };
    let request = conditions::Request {
        tables: Tables {
            title: &format!("{} conditions compared", names.len()),
            results: &runs,
            generations: &curves,
            factors: &[CONDITION.to_owned()],
            compared: Compared::Conditions,
            outcome: ("score", plan.score.axis()),
            is_less_better: false,
            others: &[],
            unfinished: None,
            time: ("episodes", "episodes spent"),
            value: ("best", "best score so far"),
            spent: None,
        },
        episodes: conditions
            .iter()
            .map(|own| (own.name.clone(), own.experiment.episodes().generations))
            .collect(),
        about: plan.score.words(&plan.worlds()),
        warnings: &plan.warnings,
        differences: &plan.differences,
        caption: caption.to_owned(),
        sources: conditions
            .iter()
            .flat_map(|own| &own.runs)
            .map(|run| links::html(out, run))
            .collect(),
    };
    let report = conditions::report(&request)?;
    let mut files = page::write(out, PAGE, &report.html)?;
    for (name, text) in [(CONDITIONS, &report.conditions_csv), (EFFECTS, &report.effects_csv)] {
        let path = out.join(name);
        disk::write(&path, text.as_bytes())?;
        files.push(path);
    }
    files.extend([runs, curves]);
    Ok(Written {
        files,
        json: report.json,
        heads: conditions::HEADS,
        rows: report.rows,
        heads_of_pairs: conditions::HEADS_OF_PAIRS,
        pairs: report.pairs,
    })
}

fn table_of_runs(conditions: &[Condition], plan: &Plan, appraisals: Option<&[Vec<Appraisal>]>) -> String {
    let mut table = Csv::new(&RUNS_COLUMNS);
    let mut number = 0_u64;
    for (place, condition) in conditions.iter().enumerate() {
        for (index, run) in condition.runs.iter().enumerate() {
            let appraisal = appraisals.map(|all| all[place][index]);
            let [low, high] = appraisal.map_or([f64::NAN; 2], |own| own.interval());
            let score = match plan.score {
                Score::New { .. } => appraisal.map_or(f64::NAN, |own| own.mean),
                Score::RecordedMean => run.mean.unwrap_or(f64::NAN),
                Score::Fitness => run.fitness,
            };
            let words = [
                number.to_string(),
                run.id.clone(),
                condition.name.clone(),
                run.seed.to_string(),
                run.source.clone(),
                condition.experiment.episodes().generations.to_string(),
            ];
            let figures = [score, low, high, run.mean.unwrap_or(f64::NAN), run.fitness].map(known);
            table.row(words.into_iter().chain(figures).chain([run.result.clone()]));
            number += 1;
        }
    }
    table.text()
}

/// The best score by episodes spent. All runs have the same times, so that means can be taken over them.
fn table_of_curves(conditions: &[Condition]) -> String {
    let times = shared_times(conditions.iter().map(|own| own.experiment.episodes().generations));
    let mut table = Csv::new(&CURVES_COLUMNS);
    let mut number = 0_u64;
    for condition in conditions {
        let end = condition.experiment.episodes().generations;
        for run in &condition.runs {
            let equal = || in_equal_parts(end, run.best.len());
            let spent = run.spent.clone().unwrap_or_else(equal);
            for (time, best) in best_at(&run.best, &spent, end, &times) {
                table.row([number.to_string(), time.to_string(), known(best)]);
            }
            number += 1;
        }
    }
    table.text()
}
