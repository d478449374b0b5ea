//! `oneiro device bench --host`: what the host can do alone. A sweep is evolved and recorded as by `oneiro sweep run`, on a device
//! that answers at once.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::{Duration, Instant};

use oneiro_base::answer::Answer;
use oneiro_base::console::{Console, columns};
use oneiro_base::disk;
use oneiro_base::exit::{Failure, Result};
use oneiro_base::files;
use oneiro_base::plain;
use oneiro_lab::device::NULL;
use oneiro_lab::engine::handle::Engine;
use oneiro_lab::engine::job::Progress;
use oneiro_lab::engine::scheduler::Times;
use oneiro_lab::engine::signals::stop_signal;
use oneiro_lab::engine::watcher::Watch;
use oneiro_lab::record::Session;
use oneiro_lab::sweep::Sweep;
use oneiro_lab::sweep::journal::Journal;
use oneiro_lab::sweep::work::Work;
use serde::Serialize;
use serde_json::json;

use super::median;
use super::null::Null;
use crate::COMMIT;
use crate::cli::DeviceBench;

/// Individuals of a generation, and generations of a run: those of the default experiment.
const INDIVIDUALS: u64 = 100;
const GENERATIONS: u64 = 200;
/// Runs of the first sweep on each number of processors, which shows how many runs take the wanted time.
const FIRST_RUNS: u32 = 20;
/// Times that each number of processors is measured, in turns, so that a slowdown of the machine affects all alike.
const TURNS: u32 = 3;
/// Time between checkpoints, as in a sweep by default.
const CHECKPOINT_EVERY: Duration = Duration::from_secs(10);

/// What one number of processors can do: medians of the turns.
#[derive(Debug, Serialize)]
struct Row {
    processors: usize,
    runs: u32,
    seconds: f64,
    individuals_per_second: f64,
    /// Speed relative to that of the first row.
    ratio: f64,
    shares: Shares,
    /// Most memory that the program had, where the system says.
    peak_bytes: Option<u64>,
}

/// How the engine's thread spent the time; what it let other threads do counts as its own.
#[derive(Clone, Copy, Debug, Serialize)]
struct Shares {
    /// Selection and mutation.
    breed: f64,
    /// Packing of batches.
    pack: f64,
    /// Recording, without what the journal's thread does meanwhile.
    record: f64,
    /// Waiting for the device's thread.
    wait: f64,
    /// What the device's thread took to put results into the order of individuals.
    place: f64,
}

/// A sweep that was done.
struct Turn {
    seconds: f64,
    times: Times,
    placing: Duration,
    peak: Option<u64>,
}

/// Measures and prints a table.
pub(super) fn run(arguments: &DeviceBench, console: Console) -> Result {
    let all = thread::available_parallelism().map_or(1, usize::from);
    let processors: Vec<usize> = match &arguments.processors[..] {
        [] => (1..=all).collect(),
        chosen => chosen.iter().copied().map(usize::from).collect(),
    };
    if let Some(number) = processors.iter().find(|&&number| number > all) {
        return Err(Failure::input(format_args!(
            "--processors {number}: this program may run on {all}; allowed: 1 to {all}"
        )));
    }
    let stop = stop_signal()?;
    let seconds = f64::from(arguments.seconds.unwrap_or(10)) / f64::from(TURNS);
    let mut runs = Vec::new();
    for &number in &processors {
        let first = sweep(number, FIRST_RUNS, &stop)?;
        let wanted = f64::from(FIRST_RUNS) * seconds / first.seconds;
        // More runs would show nothing else.
        runs.push((wanted as u32).clamp(1, 100_000));
    }
    let mut turns: Vec<Vec<Turn>> = processors.iter().map(|_| Vec::new()).collect();
    for turn in 1..=TURNS {
        console.say(format!("turn {turn} of {TURNS}"));
        for ((&number, &runs), turns) in processors.iter().zip(&runs).zip(&mut turns) {
            turns.push(sweep(number, runs, &stop)?);
        }
    }
    let mut rows: Vec<Row> = Vec::new();
    for ((&number, &runs), turns) in processors.iter().zip(&runs).zip(&turns) {
        rows.push(row(number, runs, turns, rows.first()));
    }
    let value = json!({
        "individuals": INDIVIDUALS,
        "generations": GENERATIONS,
        "rows": rows,
    });
    console.print_answer(&Answer::new(table(&rows), value))
}

/// Medians of the turns on a number of processors.
fn row(processors: usize, runs: u32, turns: &[Turn], first: Option<&Row>) -> Row {
    let of = |figure: &dyn Fn(&Turn) -> f64| median(&mut turns.iter().map(figure).collect::<Vec<_>>());
    let share = |time: fn(&Turn) -> Duration| of(&|turn| time(turn).as_secs_f64() / turn.seconds);
    let seconds = of(&|turn| turn.seconds);
    let rate = f64::from(runs) * (INDIVIDUALS * GENERATIONS) as f64 / seconds;
    Row {
        processors,
        runs,
        seconds,
        individuals_per_second: rate,
        ratio: first.map_or(1.0, |first| rate / first.individuals_per_second),
        shares: Shares {
            breed: share(|turn| turn.times.advance),
            pack: share(|turn| turn.times.pack),
            record: share(|turn| turn.times.record),
            wait: share(|turn| turn.times.wait),
            place: share(|turn| turn.placing),
        },
        peak_bytes: turns.iter().filter_map(|turn| turn.peak).max(),
    }
}

fn table(rows: &[Row]) -> String {
    let head = [
        "processors",
        "M individuals/s",
        "ratio",
        "select, mutate",
        "pack",
        "record",
        "wait",
        "place",
        "peak",
        "runs",
    ];
    let cells: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let mut cells = vec![
                row.processors.to_string(),
                format!("{:.2}", row.individuals_per_second / 1e6),
                format!("{:.2}x", row.ratio),
            ];
            let Shares {
                breed,
                pack,
                record,
                wait,
                place,
            } = row.shares;
            cells.extend([breed, pack, record, wait, place].map(|share| format!("{:.1} %", 100.0 * share)));
            cells.push(
                row.peak_bytes
                    .map_or_else(|| "-".to_owned(), |bytes| format!("{} MB", bytes >> 20)),
            );
            cells.push(row.runs.to_string());
            cells
        })
        .collect();
    let mut text = format!(
        "Million individuals per second that the host evolves and records, with a device that takes no time (`{NULL}`).\n\
         Runs of {INDIVIDUALS} individuals and {GENERATIONS} generations of the default experiment, as in a sweep; medians of {TURNS} turns.\n\n"
    );
    // Writing to a string can't fail.
    let _ = write!(
        text,
        "{}\nPercentages are of the time of the engine's thread and its workers. Meanwhile the device's thread stores the results.\n",
        columns(&head, &cells)
    );
    text
}

/// Does a sweep on some processors.
fn sweep(processors: usize, runs: u32, stop: &Arc<AtomicBool>) -> Result<Turn> {
    let work = || {
        let all = thread::available_parallelism().map_or(1, usize::from);
        if processors < all {
            bind(processors);
        }
        let threads = rayon::ThreadPoolBuilder::new().num_threads(processors).build();
        threads.map_err(Failure::failed)?.install(|| evolved(runs, stop))
    };
    thread::scope(|scope| {
        let ended = scope.spawn(work).join();
        ended.unwrap_or_else(|_| Err(Failure::broken("the benchmark")))
    })
}

/// Evolves and records runs in a temporary directory.
fn evolved(runs: u32, stop: &Arc<AtomicBool>) -> Result<Turn> {
    let scratch = Scratch::new()?;
    let path = scratch.0.join("host.toml");
    let write = |path: &Path, text: &str| files::write_new(path, text.as_bytes());
    write(&scratch.0.join("default.toml"), "")?;
    write(
        &path,
        &format!("experiment = \"default.toml\"\nseeds = \"1..{runs}\"\n"),
    )?;
    let sweep = Sweep::read(&path)?;
    let plan = sweep.plan()?;
    let null = Null::default();
    let placing = null.placing();
    let engine = Engine::new(Box::new(null), Arc::clone(stop));
    let session = Session::new(COMMIT, NULL, engine.description());
    let mut clock = Clock(Times::default());
    memory::forget_peak();
    let began = Instant::now();
    let folder = disk::make_folder(&scratch.0, "journal")?;
    let (journal, _) = Journal::begin(&folder, blake3::hash(b"host"), session)?;
    let mut work = Work::new((&sweep, &plan), Vec::new(), CHECKPOINT_EVERY, &journal);
    let waiting = work.waiting((0..runs).collect());
    let most = work.most();
    let ended = engine.run(waiting, most, &mut work, &mut clock);
    journal.close()?;
    ended?;
    Ok(Turn {
        seconds: began.elapsed().as_secs_f64(),
        times: clock.0,
        placing: placing(),
        peak: memory::peak(),
    })
}

/// Learns how the time was spent.
struct Clock(Times);

impl Watch for Clock {
    fn stops(&self) -> bool {
        false
    }

    fn steps(&mut self, _: u64) {}

    fn advanced(&mut self, _: Progress) {}

    fn ended(&mut self, times: &Times) {
        self.0 = *times;
    }
}

/// A temporary directory, removed in the end.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Result<Self> {
        let path = std::env::temp_dir().join(format!("oneiro-bench-{}", std::process::id()));
        plain::make_new_directory(&path).map_err(|error| Failure::storage(&path, &error))?;
        Ok(Self(path))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What can't be removed is left to the system, as everything in this place.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Binds this thread, and those that it starts from now on, to the first of the processors that it may run on.
#[cfg(target_os = "linux")]
fn bind(processors: usize) {
    use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
    let Ok(allowed) = sched_getaffinity(None) else { return };
    let mut own = CpuSet::new();
    for processor in (0..CpuSet::MAX_CPU).filter(|&it| allowed.is_set(it)).take(processors) {
        own.set(processor);
    }
    // If the system refuses, the pool's size alone limits the threads that work at a time.
    let _ = sched_setaffinity(None, &own);
}

/// Does nothing: the pool's size alone limits the threads that work at a time.
#[cfg(not(target_os = "linux"))]
fn bind(_: usize) {}

/// The program's peak memory.
#[cfg(target_os = "linux")]
mod memory {
    use std::io::Write;
    use std::path::Path;

    use oneiro_base::plain;

    /// Lets the peak begin at what is in use now. If the system refuses, it is that of the whole program.
    pub(super) fn forget_peak() {
        let _ = plain::append(Path::new("/proc/self/clear_refs")).and_then(|mut file| file.write_all(b"5"));
    }

    /// Most bytes in use since then.
    pub(super) fn peak() -> Option<u64> {
        let status = String::from_utf8(plain::read(Path::new("/proc/self/status"), plain::MAXIMUM).ok()?).ok()?;
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
        let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
        Some(kilobytes << 10)
    }
}

/// The system isn't asked.
#[cfg(not(target_os = "linux"))]
mod memory {
    pub(super) fn forget_peak() {}

    pub(super) fn peak() -> Option<u64> {
        None
    }
}
