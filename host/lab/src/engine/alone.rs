//! The requests of one job on the caller's thread, for programs that have one thread only. Several of them may share a request: each
//! holds the same job, evaluates a part of its episodes, and tells the job the results of all.

use std::ops::Range;

use oneiro::batch::{Outcome, Rollout};
use oneiro_base::exit::{Failure, Result};

use super::handle::Engine;
use super::job::{Job, Request, Results, Stage};
use super::scheduler::Packed;

/// Evaluates requests, and keeps the worlds that it has packed.
#[derive(Default)]
pub(crate) struct Alone(Option<Packed>);

/// The number of episodes of a job's next request whose results are their fitness alone: those that can be shared. `None` once the job
/// is finished.
pub(crate) fn shared(job: &dyn Job) -> Option<usize> {
    let request = job.ask()?;
    let is_fitness = request.stage == Stage::lives(request.stage.kernel);
    Some(if is_fitness { request.lives } else { 0 })
}

impl Alone {
    /// Evaluates some episodes of a job's next request. Also returns the words of a log's line.
    ///
    /// # Errors
    /// Errors of the evaluator; exit 3 if the episodes run outside of it.
    pub(crate) fn evaluate(
        &mut self,
        job: &dyn Job,
        episodes: Range<usize>,
        engine: &Engine,
    ) -> Result<(Outcome, usize)> {
        let Some(request) = job.ask() else {
            return Err(Failure::failed("the run is finished"));
        };
        if request.stage == Stage::OUTSIDE {
            let problem = "reality.robot: is a connected robot; allowed here: a surrogate, or none";
            return Err(Failure::input(problem));
        }
        let mut rollouts: Vec<Rollout<'_>> = Vec::with_capacity(request.lives);
        job.rollouts(&mut rollouts);
        let packed = self.packed(&request)?;
        let places = request.worlds.iter().filter_map(|place| packed.index(place));
        let places: Vec<usize> = places.collect();
        let mut rollouts = rollouts[episodes.clone()].to_vec();
        for rollout in &mut rollouts {
            rollout.world = places[rollout.world];
        }
        let batch = match request.stage.stretch() {
            None => packed.worlds.batch(&rollouts, request.stage.trace())?,
            Some(cycles) => {
                let words = packed.worlds.state_words();
                let mut states = request.states.get(episodes).unwrap_or_default().to_vec();
                for state in &mut states {
                    state.resize(words, 0);
                }
                packed
                    .worlds
                    .stretch(&rollouts, cycles, &states, request.stage.trace())?
            }
        };
        Ok((engine.evaluate(&batch)?, batch.record_words()))
    }

    /// Evaluates all episodes of a job's next request, and lets it take its step.
    ///
    /// # Errors
    /// As [`Alone::evaluate`], and those of the job.
    pub(crate) fn step(&mut self, job: &mut dyn Job, engine: &Engine) -> Result<super::job::Step> {
        let lives = job.ask().map_or(0, |request| request.lives);
        let (outcome, log_words) = self.evaluate(job, 0..lives, engine)?;
        job.tell(&Results {
            fitness: &outcome.fitness,
            traces: &outcome.traces,
            logs: &outcome.logs,
            log_words,
            states: &outcome.states,
        })
    }

    /// The packed worlds of a request.
    fn packed(&mut self, request: &Request<'_>) -> Result<&Packed> {
        let is_known = self.0.as_ref().is_some_and(|packed| {
            packed.kernel == request.stage.kernel && request.worlds.iter().all(|place| packed.index(place).is_some())
        });
        if !is_known {
            let request = std::slice::from_ref(request);
            self.0 = Some(Packed::new(request, request[0].stage.kernel)?);
        }
        self.0.as_ref().ok_or_else(|| Failure::failed("a batch has no worlds"))
    }
}
