//! `oneiro sweep`: many evolutions as one job.

use std::path::{Path, PathBuf};
use std::time::Instant;

use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, columns, counted};
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_base::plain;
use oneiro_base::progress::meanwhile;
use oneiro_lab::device;
use oneiro_lab::engine::handle::Engine;
use oneiro_lab::engine::watcher::{Watch, Watcher};
use oneiro_lab::record::{RunPlace, Session, Standing, is_locked, standing};
use oneiro_lab::runs::Shown;
use oneiro_lab::sweep::contents;
use oneiro_lab::sweep::estimate::{Devices, Estimate, Timed, estimates, fastest};
use oneiro_lab::sweep::file::Axis;
use oneiro_lab::sweep::journal::{self, Journal, Line};
use oneiro_lab::sweep::store::{AllFinished, Shard, Store};
use oneiro_lab::sweep::tables::{self, Readable, Written};
use oneiro_lab::sweep::work::Work;
use oneiro_lab::sweep::{Plan, RunIndex, Sweep, report};
use oneiro_report::page::write as write_page;
use serde::{Serialize, Serializer};
use serde_json::json;

use super::cost::{self, Ceiling};
use super::places::{RUNS, SWEEPS, already_done, done_of, found, sweep_or_newest, typed};
use super::report::Report;
use super::run::run_all;
use super::slurm;
use super::watch::Page;
use crate::COMMIT;
use crate::cli::{self, SweepCommand, SweepPlan, SweepRun};

/// Most runs of a sweep that needs no `--yes`.
const UNASKED: usize = 10_000;
/// Runs that a plan shows without `--all`.
const SHOWN: usize = 20;

/// Runs the subcommand.
pub(super) fn run(arguments: &cli::Sweep, console: Console) -> Result {
    match &arguments.command {
        SweepCommand::Plan(arguments) => plan(arguments, console),
        SweepCommand::Run(arguments) => sweep(arguments, console),
        SweepCommand::Status { dir } => status(&sweep_or_newest(dir.as_deref(), console)?, console),
        SweepCommand::Merge { dirs, out } => {
            let dirs = dirs.iter().map(|dir| found(dir, &[SWEEPS], console));
            let dirs = dirs.collect::<Result<Vec<_>>>()?;
            let tables = merge(&dirs, out.as_deref(), console)?;
            print_tables(&tables, out.as_ref().unwrap_or(&dirs[0]), None, console)
        }
        SweepCommand::Report { dir, outcome, out } => {
            let dir = sweep_or_newest(dir.as_deref(), console)?;
            let (answer, best) = reported(&dir, outcome.as_deref(), out.as_deref())?;
            console.print_answer(&answer)?;
            console.next(format_args!("oneiro sweep extract {} {best}", typed(&dir)));
            Ok(())
        }
        SweepCommand::Extract { dir, run, out, backend } => {
            let dir = found(dir, &[SWEEPS], console)?;
            extract(&dir, run, out.as_deref(), backend, console)
        }
    }
}

fn plan(arguments: &SweepPlan, console: Console) -> Result {
    let sweep = Sweep::read(&arguments.sweep)?;
    let all = sweep.runs();
    let plan = meanwhile(&format!("checking {all} runs"), console.bars(), || {
        sweep.plan_on_robots()
    })?;
    let steps = plan.steps(&sweep, 0..all as RunIndex);
    let devices = if arguments.no_estimate {
        Vec::new()
    } else {
        // `auto` is whichever of them is faster.
        let devices: &[Devices<'_>] = match arguments.backend.as_deref() {
            None | Some("auto") => &[Devices::Cpu, Devices::Gpus],
            Some(name) => &[Devices::Named(name)],
        };
        let cells = Timed::of_sweep(&sweep, &plan)?;
        estimates(&cells, devices, arguments.threads, console.bars())?
    };
    if let Some(cells) = plan.unequal_budgets() {
        let [least, most] = cells.map(|(cell, episodes)| match sweep.described(cell) {
            words if words.is_empty() => format!("{episodes}"),
            words => format!("{episodes} ({words})"),
        });
        console.warn([format!(
            "the cells have unequal budgets: {least} to {most} episodes a run; evolution.episodes gives all the same"
        )]);
    }
    let cards = if arguments.cards {
        let worlds = sweep.cell(0)?.sample()?;
        meanwhile("counting a cycle's operations", console.bars(), || {
            cost::at_most(&worlds)
        })?
    } else {
        Vec::new()
    };
    let planned = Planned {
        bytes_a_run: plan.bytes,
        cards_at_most: cards,
        cells: sweep.file().cells(),
        devices,
        keys: sweep.file().keys().collect(),
        minutes_on_robots: plan.robot_time.map(|time| time.minutes),
        name: sweep.name(),
        robot_minutes: plan.robot_time.map(|time| time.robot_minutes),
        runs: PlannedRuns {
            sweep: &sweep,
            plan: &plan,
        },
        seeds: sweep.file().seeds.len(),
        steps,
    };
    let most = if arguments.all { usize::MAX } else { SHOWN };
    let text = planned.text(most);
    console.print_answer(&Answer::new(text, &planned))?;
    if plan.robot_time.is_none() {
        let yes = if all > UNASKED { " --yes" } else { "" };
        let file = files::for_shell(&arguments.sweep.display().to_string());
        console.next(format_args!("oneiro sweep run {file}{yes}"));
    }
    Ok(())
}

/// What a sweep will do; fields are in the order of the alphabet, as in all JSON of the program.
#[derive(Serialize)]
struct Planned<'a> {
    bytes_a_run: u64,
    cards_at_most: Vec<Ceiling>,
    cells: usize,
    devices: Vec<Estimate>,
    keys: Vec<&'a str>,
    minutes_on_robots: Option<f64>,
    name: &'a str,
    robot_minutes: Option<f64>,
    runs: PlannedRuns<'a>,
    seeds: usize,
    steps: u64,
}

/// The runs, of which there may be millions.
struct PlannedRuns<'a> {
    sweep: &'a Sweep,
    plan: &'a Plan,
}

impl Serialize for PlannedRuns<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let Self { sweep, plan } = self;
        serializer.collect_seq((0..sweep.runs() as RunIndex).map(|run| {
            let cell = sweep.cell_of(run);
            json!({
                "run": run,
                "id": plan.ids[run as usize].to_hex().as_str(),
                "values": sweep.levels(cell),
                "seed": sweep.seed_of(run),
                "steps": plan.steps[cell],
                "episodes": plan.episodes[cell],
            })
        }))
    }
}

impl Planned<'_> {
    /// The plan for people, with the first runs and cells, at most so many.
    fn text(&self, most: usize) -> String {
        let PlannedRuns { sweep, plan } = self.runs;
        let shown = most.min(sweep.runs());
        let row = |run: RunIndex| {
            let cell = sweep.cell_of(run);
            let mut row = vec![run.to_string(), plan.ids[run as usize].to_hex()[..12].to_owned()];
            row.extend(sweep.levels(cell));
            row.push(sweep.seed_of(run).to_string());
            row.push(format!("{:.3}", plan.steps[cell] as f64 / 1e6));
            row
        };
        let head: Vec<&str> = ["run", "id"]
            .into_iter()
            .chain(self.keys.iter().copied())
            .chain(["seed", "M steps"])
            .collect();
        let runs: Vec<Vec<String>> = (0..shown as RunIndex).map(row).collect();
        let all = sweep.runs();
        let more = if shown < all {
            format!("... and {} more; --all lists them\n", all - shown)
        } else {
            String::new()
        };
        let device = |device: &Estimate| {
            let rate = format!("{:.1}", device.steps_per_second / 1e6);
            vec![device.name.clone(), rate, time(device.seconds)]
        };
        let here = if self.devices.is_empty() {
            String::new()
        } else {
            let rows: Vec<Vec<String>> = self.devices.iter().map(device).collect();
            columns(&["here", "M steps/s", "all runs"], &rows)
        };
        let cells = match fastest(&self.devices) {
            Some(fastest) if self.cells > 1 => format!("{}\n", self.of_cells(fastest, most)),
            _ => String::new(),
        };
        let elsewhere = if self.cards_at_most.is_empty() {
            String::new()
        } else {
            let card = |own: &Ceiling| {
                let rate = format!("{:.0}", own.steps_per_second / 1e6);
                vec![
                    own.card.to_owned(),
                    rate,
                    time(self.steps as f64 / own.steps_per_second),
                ]
            };
            let rows: Vec<Vec<String>> = self.cards_at_most.iter().map(card).collect();
            format!("\n{}", columns(&["maximum of a card", "M steps/s", "all runs"], &rows))
        };
        let robots = plan.robot_time.map_or_else(String::new, |time| {
            format!("on robots: {time}; robots run no sweeps: start each run with `oneiro run`\n\n")
        });
        format!(
            "{}: {}, {} from {} each; {:.4} billion robot-steps; {} of memory for each run in progress\n\n\
         {}{more}\n{cells}{robots}{here}{elsewhere}",
            self.name,
            counted(all, "run", "runs"),
            counted(self.cells, "cell", "cells"),
            counted(self.seeds, "seed", "seeds"),
            self.steps as f64 / 1e9,
            size(self.bytes_a_run),
            columns(&head, &runs),
        )
    }
}

impl Planned<'_> {
    /// The first cells, with the time that their runs take.
    fn of_cells(&self, estimate: &Estimate, most: usize) -> String {
        let PlannedRuns { sweep, plan } = self.runs;
        let row = |cell: usize| {
            let mut row = vec![cell.to_string()];
            row.extend(sweep.levels(cell));
            row.push(plan.episodes[cell].map_or_else(|| "-".to_owned(), |own| own.to_string()));
            row.push(time(estimate.cells[cell]));
            row
        };
        let rows: Vec<Vec<String>> = (0..self.cells.min(most)).map(row).collect();
        let head = [&["cell"], &self.keys[..], &["episodes a run", "all its runs"]].concat();
        let more = match self.cells.saturating_sub(most) {
            0 => String::new(),
            more => format!("... and {more} more; --all lists them\n"),
        };
        columns(&head, &rows) + &more
    }
}

/// The directory that a sweep is done in.
pub(super) fn directory(arguments: &SweepRun, sweep: &Sweep) -> PathBuf {
    let default = || Path::new(SWEEPS).join(sweep.name());
    arguments.out.clone().unwrap_or_else(default)
}

/// Formats a duration.
pub(super) fn time(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{s:.1} s"),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

fn size(bytes: u64) -> String {
    if bytes < 10_000_000 {
        format!("{:.0} kB", bytes as f64 / 1e3)
    } else {
        format!("{:.0} MB", bytes as f64 / 1e6)
    }
}

fn sweep(arguments: &SweepRun, console: Console) -> Result {
    let began = Instant::now();
    if arguments.shards.is_some() && !arguments.print_slurm {
        return Err(Failure::usage(
            "--shards: counts the tasks of --print-slurm; allowed: with it. Without Slurm, `--shard 1/4` does the first quarter \
             of the runs, `--shard 2/4` the second, each in a separate process",
        ));
    }
    // Before the sweep's directory is made.
    device::refuse_null(&arguments.backend.name)?;
    let sweep = Sweep::read(&arguments.sweep)?;
    let all = sweep.runs();
    if all > UNASKED && !arguments.yes {
        return Err(Failure::input(format_args!(
            "{}: has {all} runs; allowed: up to {UNASKED} without --yes (`oneiro sweep plan` lists them)",
            sweep.file().seeds_place
        )));
    }
    if arguments.print_slurm {
        return console.print_plain(slurm::script(&sweep, arguments, console)?);
    }
    let plan = sweep.plan()?;
    let shard = match arguments.shard {
        Some(shard) => shard,
        None => slurm::shard(console)?.unwrap_or(Shard::ALL),
    };
    let mut means = Means {
        engine: &|| arguments.backend.engine(),
        watch: &mut |name, steps, until| Box::new(Watcher::new(steps, name, until, console.bars())),
    };
    let _page = Page::beside(
        &arguments.beside,
        std::iter::once(&*directory(arguments, &sweep)),
        console,
    )?;
    let done = done((arguments, began), (&sweep, &plan), shard, &mut means, console)?;
    if shard != Shard::ALL {
        let Finished { store, of_shard, .. } = &done;
        let text = format!(
            "shard {shard}: {} done; `oneiro sweep merge {}` joins all shards; name the directories of shards that are \
             elsewhere after it",
            counted(*of_shard, "run is", "runs are"),
            store.directory().display()
        );
        let value = json!({"shard": shard.to_string(), "runs": of_shard, "specialised": done.specialised});
        console.print_answer(&Answer::new(text, value))?;
        let word = if done.runs.runs.len() == all { "merge" } else { "status" };
        console.next(format_args!("oneiro sweep {word} {}", typed(store.directory())));
        return Ok(());
    }
    let tables = done.tables(&sweep, &plan)?;
    print_tables(&tables, done.store.directory(), done.specialised, console)
}

/// Does a sweep or a shard of it, by means other than the command line's. `arguments` name its directory. A whole sweep has tables.
///
/// # Errors
/// As the command says.
pub(crate) fn by(arguments: &SweepRun, means: &mut Means<'_>, console: Console) -> Result<Option<Written>> {
    device::refuse_null(&arguments.backend.name)?;
    let sweep = Sweep::read(&arguments.sweep)?;
    let plan = sweep.plan()?;
    let shard = arguments.shard.unwrap_or(Shard::ALL);
    let finished = done((arguments, Instant::now()), (&sweep, &plan), shard, means, console)?;
    (shard == Shard::ALL)
        .then(|| finished.tables(&sweep, &plan))
        .transpose()
}

/// What a sweep is done with: the engine, and what watches it and says when to stop.
pub(crate) struct Means<'a> {
    pub(crate) engine: &'a (dyn Fn() -> Result<Engine> + Sync),
    pub(crate) watch: &'a mut MakeWatch<'a>,
}

/// Makes a watcher of a sweep by its name, its number of robot-steps and the time at which it has to stop.
type MakeWatch<'a> = dyn FnMut(&str, u64, Option<Instant>) -> Box<dyn Watch + 'a> + Send + 'a;

/// The runs of a shard that are done.
struct Finished {
    store: Store,
    runs: AllFinished,
    of_shard: usize,
    /// Share of the robot-steps that kernels specialised to their worlds have simulated now; none if nothing was left to do.
    specialised: Option<f64>,
}

impl Finished {
    fn tables(&self, sweep: &Sweep, plan: &Plan) -> Result<Written> {
        tables::write(self.store.directory(), sweep, plan, &self.runs)
    }
}

/// Does the runs of a shard that aren't done yet.
fn done(
    (arguments, began): (&SweepRun, Instant),
    (sweep, plan): (&Sweep, &Plan),
    shard: Shard,
    means: &mut Means<'_>,
    console: Console,
) -> Result<Finished> {
    let all = sweep.runs();
    console.warn(sweep.cell(0)?.warnings());
    let store = Store::prepare(&directory(arguments, sweep), sweep, plan)?;
    let mut finished = all_finished(std::slice::from_ref(&store), plan, console)?;
    let of_shard = shard.runs(all).count();
    let todo: Vec<RunIndex> = shard.runs(all).filter(|run| !finished.runs.contains_key(run)).collect();
    if todo.len() < of_shard {
        already_done(of_shard - todo.len(), of_shard, console);
    }
    let mut specialised = None;
    if !todo.is_empty() {
        let (lines, share) = work((arguments, began), (sweep, plan), &store, shard, todo, means, console)?;
        store.add(store.journal(shard), lines, Some(&plan.ids), &mut finished)?;
        specialised = Some(share);
    }
    Ok(Finished {
        store,
        runs: finished,
        of_shard,
        specialised,
    })
}

/// Does a shard's runs. Returns all that it has done, now and before, and the share of the robot-steps that kernels specialised to
/// their worlds have simulated now.
fn work(
    (arguments, began): (&SweepRun, Instant),
    (sweep, plan): (&Sweep, &Plan),
    store: &Store,
    shard: Shard,
    mut todo: Vec<RunIndex>,
    means: &mut Means<'_>,
    console: Console,
) -> Result<(Vec<Line>, f64)> {
    let engine = (means.engine)()?;
    let session = Session::new(COMMIT, &arguments.backend.name, engine.description());
    let (journal, begun) = Journal::begin(&store.make_journal(shard)?, store.identity()?, session)?;
    console.warn(&begun.problems);
    todo.retain(|run| !begun.finished.contains(run));
    let mut saved = begun.saved;
    saved.retain(|saved| todo.binary_search(&saved.run).is_ok());
    let runs = counted(todo.len(), "run", "runs");
    console.say(format!("{}: {runs} on {}", sweep.name(), engine.name()));
    let until = arguments.time_budget.map(|budget| began + budget);
    let steps = plan.steps(sweep, todo.iter().copied());
    let mut watcher = (means.watch)(sweep.name(), steps, until);
    let mut work = Work::new((sweep, plan), saved, arguments.checkpoint_every, &journal);
    let waiting = work.waiting(todo);
    let most = arguments.jobs.map_or(usize::MAX, |jobs| jobs as usize).min(work.most());
    let ended = engine.run(waiting, most, &mut work, &mut *watcher);
    drop(watcher);
    let specialised = device::close(engine, console);
    // The work ended because something could not be written; closing says what.
    let lines = journal.close()?;
    ended.map(|()| (lines, specialised))
}

/// Combines finished runs from directories of one sweep, and warns of damage.
fn all_finished(stores: &[Store], plan: &Plan, console: Console) -> Result<AllFinished> {
    let mut finished = AllFinished::default();
    for store in stores {
        store.finished(Some(&plan.ids), &mut finished)?;
    }
    console.warn(&finished.problems);
    Ok(finished)
}

/// Prints which tables of a sweep were written.
fn print_tables(
    Written { runs, hash, files }: &Written,
    directory: &Path,
    specialised: Option<f64>,
    console: Console,
) -> Result {
    let names: Vec<String> = files.iter().map(|file| format!("  {}", file.display())).collect();
    let (all, short) = (counted(*runs, "run", "runs"), console.hash(hash));
    console.print_answer(&Answer::new(
        format!("{all}, hash {short}\n{}", names.join("\n")),
        json!({"runs": runs, "hash": hash, "files": files, "specialised": specialised}),
    ))?;
    console.next(format_args!("oneiro sweep report {}", typed(directory)));
    Ok(())
}

fn status(dir: &Path, console: Console) -> Result {
    let store = Store::open(dir)?;
    let made = store.what();
    let mut shards = Vec::new();
    let mut finished = AllFinished::default();
    store.finished(None, &mut finished)?;
    // Tables may also have the runs of shards in other directories.
    let mut all = tables::runs_in(dir, made.runs)?;
    // Written after them.
    let is_merged = dir.join(contents::SUMS).exists();
    let mut warnings = Vec::new();
    if is_merged && let Err(problem) = tables::verify(dir) {
        warnings.push(problem.to_string());
    }
    all.extend(finished.runs.keys());
    for (shard, journal) in store.journals()? {
        // Whichever shard did a run, it need not be done again.
        let done = shard.runs(made.runs).filter(|run| all.contains(run)).count();
        let runs = shard.runs(made.runs).count();
        let state = match done {
            _ if is_locked(&journal) => "running",
            done if done == runs => "done",
            _ => "stopped",
        };
        let (under_way, generations) = journal::under_way(&journal, &store.identity()?)?;
        shards.push(ShardStatus {
            shard: shard.to_string(),
            done,
            runs,
            under_way,
            generations,
            state,
        });
    }
    let done = all.len();
    warnings.extend(finished.problems);
    let row = |shard: &ShardStatus| {
        let numbers = [
            shard.done as u64,
            shard.runs as u64,
            shard.under_way as u64,
            shard.generations,
        ];
        let numbers = numbers.iter().map(u64::to_string);
        let words = std::iter::once(shard.shard.clone()).chain(numbers);
        words.chain([shard.state.to_owned()]).collect()
    };
    let rows: Vec<Vec<String>> = shards.iter().map(row).collect();
    let rest = match (done == made.runs, is_merged) {
        (true, false) => "; `oneiro sweep merge` makes their tables",
        (true, true) => ", and their tables are there",
        _ => "",
    };
    let text = format!(
        "{}: {}{rest}\n\n{}",
        made.name,
        done_of(done, made.runs, "done"),
        columns(
            &["shard", "done", "runs", "in progress", "generations of these", "state"],
            &rows
        )
    );
    let value = json!({
        "name": made.name,
        "runs": made.runs,
        "done": done,
        "tables": is_merged,
        "shards": shards,
    });
    console.print_answer(&Answer {
        warnings,
        ..Answer::new(text, value)
    })?;
    if done == made.runs {
        let word = if is_merged { "report" } else { "merge" };
        console.next(format_args!("oneiro sweep {word} {}", typed(dir)));
    }
    Ok(())
}

/// Progress of a shard.
#[derive(Debug, Serialize)]
struct ShardStatus {
    shard: String,
    done: usize,
    runs: usize,
    /// Runs in progress at the last checkpoint, and the total of their finished generations.
    under_way: usize,
    generations: u64,
    state: &'static str,
}

/// Writes the tables of shards that are done, into the first directory or another.
///
/// # Errors
/// As the command says.
pub(crate) fn merge(dirs: &[PathBuf], out: Option<&Path>, console: Console) -> Result<Written> {
    let stores = dirs.iter().map(|dir| Store::open(dir)).collect::<Result<Vec<_>>>()?;
    let Some((first, others)) = stores.split_first() else {
        return Err(Failure::usage("merge needs at least one directory"));
    };
    for other in others {
        first.fits(other)?;
    }
    let (sweep, plan) = first.sweep()?;
    let finished = all_finished(&stores, &plan, console)?;
    match out {
        None => tables::write(first.directory(), &sweep, &plan, &finished),
        Some(out) => {
            finished.is_all_of(&sweep)?;
            // Makes it a sweep's directory like any other, for reports and extraction.
            let store = Store::prepare(out, &sweep, &plan)?;
            tables::write(store.directory(), &sweep, &plan, &finished)
        }
    }
}

/// The key of the optimiser's kind.
const OPTIMISER: &str = "evolution.kind";

/// Writes a report. Also returns the run with the best outcome.
fn reported(dir: &Path, outcome: Option<&str>, out: Option<&Path>) -> Result<(Answer, u64)> {
    let store = Store::open(dir)?;
    let (sweep, plan) = store.sweep()?;
    let out = out.unwrap_or(dir);
    plain::make_directory(out).map_err(|error| Failure::unreadable(out, &error))?;
    let readable = Readable::of(&store, &sweep, &plan, out)?;
    let unfinished = unfinished(&sweep, &readable);
    let mut warnings = readable.problems.clone();
    warnings.extend(
        unfinished
            .as_ref()
            .map(|unfinished| format!("{}: is unfinished: {}", dir.display(), unfinished.words())),
    );
    let Shown { by, time, value } = plan.shown;
    let columns = &plan.outcomes;
    let known = |name: &str| columns.iter().find(|known| known.name == name);
    let by = match outcome {
        None => by,
        Some(name) => {
            let Some(known) = known(name) else {
                let allowed: Vec<&str> = columns.iter().map(|column| &*column.name).collect();
                let allowed = allowed.join(", ");
                let instead = if name.starts_with("end_") {
                    format!(
                        ". A sweep's tables have no measures of an episode's end; `oneiro evaluate --genomes {} --measures \
                         --summary` computes them for the champions",
                        dir.display()
                    )
                } else {
                    String::new()
                };
                return Err(Failure::input(format_args!(
                    "--outcome {name}: is no outcome in {}; allowed: {allowed}{instead}",
                    contents::RESULTS
                )));
            };
            (&*known.name, &*known.name)
        }
    };
    let others: Vec<String> = columns
        .iter()
        .filter(|column| column.name != by.0)
        .map(|column| column.name.to_string())
        .collect();
    let factors: Vec<String> = sweep.file().axes.iter().flat_map(Axis::factors).cloned().collect();
    let runs = 0..sweep.runs() as RunIndex;
    let spent: Option<Vec<u64>> = runs.map(|run| plan.spent[sweep.cell_of(run)]).collect();
    let spent = spent.as_deref().map(|ends| report::Spent {
        ends,
        // Generations of several optimisers are different things.
        is_first: factors.iter().any(|key| key == OPTIMISER),
    });
    let page = report::report(&report::Tables {
        title: &store.what().name,
        results: &readable.table(contents::RESULTS),
        generations: &readable.table(contents::GENERATIONS),
        factors: &factors,
        compared: report::Compared::Levels,
        outcome: by,
        is_less_better: known(by.0).is_some_and(|column| column.is_less_better),
        others: &others,
        unfinished,
        time,
        value,
        spent,
    })?;
    let mut files = write_page(out, report::PAGE, &page.html)?;
    for (name, text) in [(report::CELLS, &page.cells_csv), (report::EFFECTS, &page.effects_csv)] {
        let path = out.join(name);
        disk::write(&path, text.as_bytes())?;
        files.push(path);
    }
    let files: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
    let answer = Answer {
        warnings,
        ..Answer::new(files.join("\n"), page.json)
    };
    Ok((answer, page.best))
}

/// What the tables of a sweep lack, if anything.
fn unfinished(sweep: &Sweep, readable: &Readable) -> Option<report::Unfinished> {
    let missing = readable.missing.clone();
    let seeds = sweep.file().seeds.len();
    let mut missing_of = vec![0; sweep.file().cells()];
    for run in &missing {
        missing_of[sweep.cell_of(*run)] += 1;
    }
    (!missing.is_empty()).then(|| report::Unfinished {
        runs: sweep.runs(),
        runs_a_cell: seeds,
        without_runs: (0..sweep.file().cells())
            .filter(|cell| missing_of[*cell] == seeds)
            .map(|cell| sweep.described(cell))
            .collect(),
        missing,
    })
}

fn extract(dir: &Path, run: &str, out: Option<&Path>, backend: &cli::Backend, console: Console) -> Result {
    let store = Store::open(dir)?;
    let (sweep, plan) = store.sweep()?;
    let run = chosen(run, &plan, dir)?;
    let seed = sweep.seed_of(run);
    let mut finished = AllFinished::default();
    store.finished(Some(&plan.ids), &mut finished)?;
    let known = finished.runs.get(&run).map(|finished| finished.line.result.clone());
    let id = plan.ids[run as usize].to_hex();
    let directory = out.map_or_else(|| dir.join(RUNS).join(format!("run-{run}")), Path::to_owned);
    let experiment = sweep.experiment_of(sweep.cell_of(run))?;
    if out.is_none() {
        disk::make_folder(dir, RUNS)?;
    }
    let repeat = |place| {
        let done = run_all(vec![place], sweep.name(), backend, console)?;
        let result = done.into_iter().next().map(|Report { result, .. }| result);
        result.ok_or_else(|| Failure::failed("the run has no result"))
    };
    let result = match standing(&directory, experiment.identities().of(seed))? {
        Standing::New => repeat(RunPlace::New {
            experiment,
            seed,
            directory: directory.clone(),
            name: None,
        })?,
        Standing::Unfinished(run) => repeat(RunPlace::Saved(run))?,
        Standing::Done(done) => {
            already_done(1, 1, console);
            done.result
        }
    };
    if let Some(known) = known
        && known != result
    {
        return Err(Failure::failed(format_args!(
            "run {run} gave {} here and {} in the sweep; one of the machines can't be trusted: \
             `oneiro device test` shows which",
            console.hash(&result),
            console.hash(&known)
        )));
    }
    console.print_answer(&Answer::new(
        format!("run {run}\nresult {}\n{}", console.hash(&result), directory.display()),
        json!({"run": run, "id": id.as_str(), "result": result, "directory": directory}),
    ))?;
    console.next(format_args!("oneiro replay {}", typed(&directory)));
    Ok(())
}

/// The run that the user selected.
fn chosen(text: &str, plan: &Plan, dir: &Path) -> Result<RunIndex> {
    let all = plan.ids.len();
    if let Ok(run) = text.parse::<RunIndex>()
        && (run as usize) < all
    {
        return Ok(run);
    }
    let is_meant = |id: &blake3::Hash| text.len() >= 6 && id.to_hex().starts_with(text);
    let meant: Vec<RunIndex> = (0..all as RunIndex)
        .filter(|&run| is_meant(&plan.ids[run as usize]))
        .collect();
    match meant[..] {
        [run] => Ok(run),
        [] => Err(Failure::input(format_args!(
            "{}: has no run {text}; allowed: 0 to {}, or six and more digits of an id",
            dir.display(),
            all - 1
        ))),
        _ => Err(Failure::input(format_args!(
            "{}: {text} is the beginning of several ids",
            dir.display()
        ))),
    }
}
