//! `oneiro compare`: different experiments with one score, in one report.

use std::path::{Path, PathBuf};

use oneiro::evaluator::Control;
use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, columns, counted};
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_base::plain;
use oneiro_base::progress;
use oneiro_lab::compare::sources::Sources;
use oneiro_lab::compare::{self, Plan, Score};
use oneiro_lab::device;
use oneiro_lab::experiment::kinds::is_sweep;
use serde_json::json;

use super::list;
use super::places::{RUNS, SWEEPS, found};
use crate::cli::Compare;

/// The directory of a comparison that has no other.
const USUAL: &str = "compare";
/// New episodes of each champion without `--trials`.
const EPISODES: u32 = 100;

/// Compares, and writes the report with its tables.
pub(crate) fn run(arguments: &Compare, console: Console) -> Result {
    let out = arguments.out.as_deref().unwrap_or(Path::new(USUAL));
    files::must_not_be_file(out)?;
    let episodes = arguments.trials.unwrap_or(EPISODES);
    if episodes < 2 {
        return Err(Failure::input(format_args!(
            "--trials {episodes}: champions are compared by means of several episodes; allowed: 2 to 1000000"
        )));
    }
    let named: Vec<PathBuf> = arguments
        .sources
        .iter()
        .map(|source| found(source, &[RUNS, SWEEPS], console))
        .collect::<Result<_>>()?;
    // Nothing is written unless all can be read.
    for path in &named {
        if !is_sweep(path) {
            list::runs(path)?;
        }
    }
    plain::make_directory(out).map_err(|error| files::uncreated(out, &error))?;
    let mut sources = Sources::default();
    for path in &named {
        if is_sweep(path) {
            sources.add_sweep(path, &arguments.set, out)?;
        } else {
            for directory in list::runs(path)? {
                sources.add_run(&directory, path, &arguments.set)?;
            }
        }
    }
    let (conditions, warnings) = sources.finish()?;
    let seed = arguments.seed.unwrap_or(1);
    let mut plan = Plan::of(
        &conditions,
        (!arguments.recorded).then_some((episodes, seed)),
        &arguments.set,
    )?;
    plan.warnings.splice(0..0, warnings);
    console.warn(&plan.warnings);
    let runs: usize = conditions.iter().map(|own| own.runs.len()).sum();
    let all = format!(
        "{}, {}",
        counted(conditions.len(), "condition", "conditions"),
        counted(runs, "run", "runs")
    );
    let appraisals = match plan.score {
        Score::New { episodes, seed } => {
            let mut evaluator = arguments.backend.open()?;
            console.say(format!(
                "{all}; {episodes} new episodes of each champion, {}, on {}",
                [&[format!("seed {seed}")][..], &arguments.set].concat().join(", "),
                device::name(evaluator.as_ref())
            ));
            let control = Control::new();
            let steps = compare::steps(&conditions, episodes);
            let appraisals = progress::watched(steps, "evaluating", console.bars(), &control, || {
                compare::appraised(&conditions, (episodes, seed), evaluator.as_mut(), &control)
            })?;
            device::tell_warnings(evaluator.as_ref(), console);
            Some(appraisals)
        }
        Score::RecordedMean | Score::Fitness => {
            console.say(format!("{all}; recorded scores"));
            None
        }
    };
    let written = compare::write(out, &conditions, &plan, appraisals.as_deref())?;
    let mut value = written.json;
    value["files"] = json!(written.files);
    let pairs = if written.pairs.is_empty() {
        "too few runs for tests".to_owned()
    } else {
        columns(&written.heads_of_pairs, &written.pairs)
    };
    let text = format!(
        "{}\n{pairs}\nreport  {}",
        columns(&written.heads, &written.rows),
        out.join(compare::PAGE).display()
    );
    console.print_answer(&Answer::new(text, value))
}
