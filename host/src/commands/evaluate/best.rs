//! `oneiro evaluate --best`: re-evaluates recorded genomes on many new episodes and reports the one with the best mean.

use std::path::Path;

use oneiro::evaluator::Control;
use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, columns, counted, decimal};
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_base::progress;
use oneiro_evolve::appraisal::{Appraisal, by_mean};
use oneiro_lab::device;
use oneiro_lab::lives::{Keys, Lives};
use oneiro_report::numbers::{significant, to_six_places};
use serde::Serialize;
use serde_json::{Value, json};

use super::{experiment_and_seed, retyped, shell};
use crate::cli::Evaluate;
use crate::commands::places::{settings_typed, typed};
use crate::commands::subjects::{Named, Subjects, Which};

/// Episodes of each genome without `--trials`.
const EPISODES: u32 = 100;
/// A file to write the best genome to.
const BEST: &str = "best.json";
/// Genomes that are shown without `--all`.
const SHOWN: usize = 20;

/// Lets all genomes live the same fresh lives, prints them from the best mean to the worst, and writes the best.
pub(crate) fn run(arguments: &Evaluate, console: Console) -> Result {
    let lives = arguments.trials.unwrap_or(EPISODES);
    if lives < 2 {
        return Err(Failure::input(format_args!(
            "--trials {lives}: --best compares means of several episodes; allowed: 2 to 1000000"
        )));
    }
    arguments.file().map(writable).transpose()?;
    let named = finished(Named::all(&arguments.genomes, console)?, console)?;
    let (experiment, seed) = experiment_and_seed(arguments, &named, false)?;
    let layout = experiment.world().gene_layout();
    let which = Which::All {
        individuals: arguments.ranked.individuals,
    };
    let subjects = Subjects::read(&named, layout, which, console)?.distinct();
    let all = Lives {
        worlds: std::slice::from_ref(experiment.world()),
        genomes: &subjects.genomes,
        count: lives as usize,
        keys: Keys::of_champions(seed),
    };
    let mut evaluator = arguments.backend.open()?;
    console.say(format!(
        "{}, {lives} episodes each, seed {seed}, on {}",
        counted(subjects.genomes.len(), "genome", "genomes"),
        device::name(evaluator.as_ref())
    ));
    let control = Control::new();
    let fitness = progress::watched(all.steps(), "evaluating", console.bars(), &control, || {
        all.fitness(evaluator.as_mut(), &control)
    })?;
    device::tell_warnings(evaluator.as_ref(), console);

    let each = fitness.chunks_exact(lives as usize);
    let appraisals: Vec<Appraisal> = each.clone().map(Appraisal::of).collect();
    let fitness: Vec<&[f32]> = each.collect();
    let ranking = by_mean(&appraisals);
    let row = |&index: &usize| Row::new(&subjects.sources[index], &appraisals[index], fitness[index]);
    let rows: Vec<Row<'_>> = ranking.iter().map(row).collect();
    let best = ranking[0];
    let json = |row: &Row<'_>, genome: &[f32]| {
        let mut own = json!(row);
        own["lives"] = lives.into();
        own["seed"] = seed.into();
        own["gene_names"] = json!(layout.names());
        own["genome"] = genome.iter().copied().map(decimal).collect();
        own
    };
    let champion = json(&rows[0], subjects.genomes.genome(best));
    if let Some(out) = arguments.file() {
        files::write_new(out, &disk::json(&champion))?;
        console.say(format!("wrote {}", out.display()));
    }
    console.print_answer(&Answer::new(
        table(&rows, arguments.ranked.all),
        json!({ "best": champion, "genomes": rows }),
    ))?;
    let run = named.iter().find_map(|own| match own {
        Named::Run(run) => Some(typed(run.directory())),
        Named::File(_) | Named::Sweep(_) => None,
    });
    match (arguments.file().map(shell), run, &arguments.experiment) {
        (None, ..) if !Path::new(BEST).exists() => {
            console.next(format_args!("oneiro evaluate {} --out {BEST}", retyped(arguments)));
        }
        (Some(file), Some(run), _) => console.next(format_args!("oneiro replay {run} --genome {file}")),
        (Some(file), None, Some(experiment)) => {
            let (experiment, set) = (shell(experiment), settings_typed(&arguments.set));
            console.next(format_args!(
                "oneiro evaluate {experiment}{set} --genomes {file} --trials {lives} --summary"
            ));
        }
        _ => {}
    }
    Ok(())
}

/// Refuses a file that can't be written, before anything is computed.
fn writable(out: &Path) -> Result {
    files::must_end_in(
        "--out",
        out,
        "json",
        "the best is written in the format of champion.json",
    )?;
    files::must_be_new(out)
}

/// Leaves out unfinished runs, which have no champion yet.
fn finished(named: Vec<Named>, console: Console) -> Result<Vec<Named>> {
    let mut finished = Vec::with_capacity(named.len());
    for named in named {
        match &named {
            Named::Run(run) if !run.is_done()? => console.say(format!(
                "warning: {}: is not finished, so it is left out; `oneiro resume` continues it",
                run.directory().display()
            )),
            _ => finished.push(named),
        }
    }
    if finished.is_empty() {
        return Err(Failure::input(
            "there are no genomes yet; allowed: finished runs and sweeps, and files of genomes",
        ));
    }
    Ok(finished)
}

/// Appraisal of one genome.
#[derive(Serialize)]
struct Row<'a> {
    /// File of the genome, with its row.
    source: &'a str,
    mean: f64,
    /// 95 % confidence interval of the mean, by Student's t.
    interval: [f64; 2],
    deviation: f64,
    lowest: Value,
    highest: Value,
}

impl<'a> Row<'a> {
    fn new(source: &'a str, appraisal: &Appraisal, lives: &[f32]) -> Self {
        let extreme = |of: fn(f32, f32) -> f32| decimal(lives.iter().copied().fold(f32::NAN, of));
        Self {
            source,
            mean: to_six_places(appraisal.mean),
            interval: appraisal.interval().map(to_six_places),
            deviation: to_six_places(appraisal.deviation),
            lowest: extreme(f32::min),
            highest: extreme(f32::max),
        }
    }
}

/// Formats the best genomes, or all, with the best marked.
fn table(rows: &[Row<'_>], all: bool) -> String {
    let shown = if all { rows.len() } else { SHOWN.min(rows.len()) };
    let line = |(row, mark): (&Row<'_>, &str)| {
        let [from, to] = row.interval;
        let numbers = [row.mean, from, to, row.deviation].map(|number| significant(number, 6));
        let extremes = [&row.lowest, &row.highest].map(|number| significant(number.as_f64().unwrap_or(f64::NAN), 6));
        let mut line = vec![row.source.to_owned()];
        line.extend(numbers.into_iter().chain(extremes));
        line.push(mark.to_owned());
        line
    };
    let marks = std::iter::once("best").chain(std::iter::repeat(""));
    let lines: Vec<Vec<String>> = rows[..shown].iter().zip(marks).map(line).collect();
    let head = [
        "genome",
        "mean",
        "95 %: from",
        "to",
        "deviation",
        "lowest",
        "highest",
        "",
    ];
    let more = match rows.len() - shown {
        0 => String::new(),
        more => format!("... and {more} more; --all lists them\n"),
    };
    columns(&head, &lines) + &more
}
