//! A sweep of swarms. Their runs are whole lives, many in lockstep; two threads take turns with the device, so that it
//! works while robots exchange their simulators. What is under way when a process ends is done again: a group lasts some
//! seconds.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use oneiro::batch::Batch;
use oneiro::evaluator::{Control, Error, Evaluator};

use super::journal::Journal;
use super::lockstep::Pace;
use super::outcome::Outcome;
use super::{Cell, Plan, RunIndex, Sweep};
use crate::exit::{Failure, Result};
use crate::swarm::settings::Settings;
use crate::swarm::{self, live};
use crate::worker::Watch;

/// What a group should take, since it is done again when it is interrupted.
const LONG: Duration = Duration::from_secs(4);
/// Runs of the first group, and the fewest and the most of others: enough for the lanes of a vector, or of several.
const FIRST: usize = 4;
const GROUP: [usize; 2] = [16, 64];
/// Threads that take turns.
const CREWS: usize = 2;

/// Runs that last equally long and whose clocks are alike.
struct Group {
    runs: Vec<RunIndex>,
    plans: Vec<swarm::Plan>,
}

/// Runs that wait, in the order of the sweep.
struct Waiting<'a> {
    sweep: &'a Sweep,
    runs: VecDeque<RunIndex>,
    /// Runs of the next group, and of any.
    size: usize,
    largest: usize,
    /// The cell that was looked at last.
    cell: Option<(usize, Cell)>,
}

impl Waiting<'_> {
    fn plan(&mut self, run: RunIndex) -> Result<swarm::Plan> {
        let index = self.sweep.cell_of(run);
        if self.cell.as_ref().is_none_or(|(known, _)| *known != index) {
            self.cell = Some((index, self.sweep.cell(index)?));
        }
        match &self.cell {
            Some((_, Cell::Swarm(experiment))) => Ok(experiment.plan(self.sweep.seed_of(run))),
            _ => Err(Failure::failed("a sweep of single robots has no swarms")),
        }
    }

    fn next(&mut self) -> Result<Option<Group>> {
        let pace = |settings: &Settings| (settings.minutes, settings.clock.clone());
        let mut group = Group {
            runs: Vec::new(),
            plans: Vec::new(),
        };
        while group.runs.len() < self.size.min(self.largest)
            && let Some(&run) = self.runs.front()
        {
            let plan = self.plan(run)?;
            if group
                .plans
                .first()
                .is_some_and(|first| pace(&first.settings) != pace(&plan.settings))
            {
                break;
            }
            self.runs.pop_front();
            group.runs.push(run);
            group.plans.push(plan);
        }
        Ok(Some(group).filter(|group| !group.runs.is_empty()))
    }

    /// A group of so many runs took so long.
    fn learn(&mut self, runs: usize, took: Duration) {
        let fit = runs as f64 * LONG.as_secs_f64() / took.as_secs_f64().max(1e-3);
        self.size = (fit as usize).clamp(GROUP[0], GROUP[1]);
    }
}

/// Does runs of a sweep.
///
/// # Errors
/// Exit 75 when it was stopped, and as the evaluator's errors; exit 6 when recording fails.
pub(crate) fn run(
    (sweep, plan): (&Sweep, &Plan),
    runs: Vec<RunIndex>,
    pace: Pace,
    evaluator: &mut dyn Evaluator,
    journal: &Journal,
    watch: &mut dyn Watch,
) -> Result {
    const BLINK: Duration = Duration::from_millis(50);
    let share = runs.len().min(pace.jobs.unwrap_or(usize::MAX)).div_ceil(CREWS);
    let crews = if pace.jobs == Some(1) { 1 } else { CREWS };
    let waiting = Mutex::new(Waiting {
        sweep,
        runs: runs.into(),
        size: FIRST,
        largest: share.clamp(1, GROUP[1]),
        cell: None,
    });
    let evaluator = Mutex::new(evaluator);
    let control = Control::new();
    let work = || -> Result {
        let evaluate = |batch: &Batch| {
            let mut evaluator = evaluator.lock().unwrap_or_else(PoisonError::into_inner);
            if control.is_cancelled() {
                return Err(Error::Cancelled);
            }
            evaluator.evaluate(batch, &control)
        };
        loop {
            let next = waiting.lock().unwrap_or_else(PoisonError::into_inner).next()?;
            let Some(Group { runs, plans }) = next else {
                return Ok(());
            };
            let began = Instant::now();
            let lived = live(&plans, &evaluate)?;
            let took = began.elapsed();
            waiting
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .learn(runs.len(), took);
            for ((run, own), lived) in runs.into_iter().zip(&plans).zip(&lived) {
                let id = plan.ids[run as usize];
                journal.done(Outcome::of_swarm(run, id, &own.settings, lived), id)?;
            }
            // What is on the disk now is safe from power cuts, too.
            journal.checkpoint(Vec::new())?;
        }
    };
    thread::scope(|scope| {
        let crew = || {
            let result = work();
            if result.is_err() {
                control.cancel();
            }
            result
        };
        let crews: Vec<_> = (0..crews).map(|_| scope.spawn(crew)).collect();
        while !crews.iter().all(thread::ScopedJoinHandle::is_finished) {
            if watch.stops() {
                control.cancel();
            }
            watch.steps(control.steps());
            thread::sleep(BLINK);
        }
        let broken = || Err(Failure::failed("a thread of the sweep broke down"));
        let results: Vec<Result> = crews
            .into_iter()
            .map(|crew| crew.join().unwrap_or_else(|_| broken()))
            .collect();
        // The others were only stopped by the first failure.
        let (stopped, failed): (Vec<_>, Vec<_>) = results
            .into_iter()
            .filter_map(Result::err)
            .partition(|failure| failure.code() == Failure::stopped("").code());
        match failed.into_iter().chain(stopped).next() {
            Some(failure) => Err(failure),
            None => Ok(()),
        }
    })
}
