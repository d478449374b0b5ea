//! Swarms whose on-board simulators evolve with their controllers: the algorithm of O'Dowd, Studley and Winfield (2014).
//!
//! | file | content |
//! |---|---|
//! | [`job`] | a swarm's run: what is evaluated next, and what becomes of the results |
//! | [`on_board`] | what runs on board of one robot |
//! | [`clock`] | when a robot's intervals begin |
//! | [`memory`] | the exchange of messages within one process |
//! | [`lived`], [`tables`] | what a run gives |

pub(crate) mod clock;
pub(crate) mod job;
pub(crate) mod lived;
mod memory;
pub(crate) mod on_board;
pub(crate) mod settings;
pub(crate) mod tables;

use oneiro::batch::{Batch, Outcome, Rollout, TraceRequest, WorldKind, Worlds};
use oneiro::evaluator;
use oneiro::swarm::{Lamp, SECOND};
use serde::Serialize;

use crate::engine::job::{Job, Kind as PlaceKind, Place, Results};
use crate::exit::Result;
use crate::swarm::lived::{Case, Kind, Run};
use job::SwarmJob;
use settings::Settings;

/// A swarm that is to live.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Plan {
    /// The values of its experiment.
    pub(crate) settings: Settings,
    /// What of its evolution is left as it is.
    pub(crate) kind: Kind,
    /// Its number among those of its kind and case.
    pub(crate) number: u32,
    /// Everything random follows from it, but how robots differ.
    pub(crate) seed: u64,
}

impl Plan {
    /// The arena's lamp.
    pub(crate) fn lamp(&self) -> Lamp {
        self.settings.case.lamp(SECOND * self.settings.light_moves())
    }

    /// A hash of all that decides the run.
    fn hash(&self) -> blake3::Hash {
        blake3::hash(&serde_json::to_vec(self).expect("plans are numbers and words"))
    }
}

/// Robot-steps of a swarm, in the arena and on board.
pub(crate) fn steps(plan: &Plan) -> u64 {
    let own = &plan.settings;
    let real = u64::from(own.robots) * u64::from(SECOND * own.seconds());
    let lives = u64::from(own.robots) * u64::from(own.controllers.population);
    let simulated = lives * u64::from(SECOND * own.clock.interval_s) * u64::from(own.seconds() / own.clock.interval_s);
    real + if own.case == Case::Random { 0 } else { simulated }
}

/// Runs swarms from beginning to end.
///
/// # Errors
/// As [`drive`].
pub(crate) fn live(
    plans: &[Plan],
    evaluate: &dyn Fn(&Batch) -> std::result::Result<Outcome, evaluator::Error>,
) -> Result<Vec<Run>> {
    let mut jobs: Vec<SwarmJob> = plans.iter().cloned().map(SwarmJob::new).collect();
    drive(&mut jobs, evaluate)?;
    Ok(jobs.iter().map(SwarmJob::run).collect())
}

/// Runs swarms to their end, those that are equally far in one batch.
///
/// # Errors
/// Exit 3 for a value that a world does not allow, exit 75 when it was stopped, and as the evaluator's errors.
pub(crate) fn drive(
    jobs: &mut [SwarmJob],
    evaluate: &dyn Fn(&Batch) -> std::result::Result<Outcome, evaluator::Error>,
) -> Result {
    let mut packed = Vec::new();
    while step(jobs, &mut packed, evaluate)? {}
    Ok(())
}

/// Worlds that were packed before, by the keys of their places.
type Packed = Vec<(Vec<blake3::Hash>, Worlds)>;

/// Lets the swarms that are behind take their next step. Returns whether there was one.
fn step(
    jobs: &mut [SwarmJob],
    packed: &mut Packed,
    evaluate: &dyn Fn(&Batch) -> std::result::Result<Outcome, evaluator::Error>,
) -> Result<bool> {
    // On board before the arena, so that swarms stay together.
    let stages = jobs.iter().filter_map(Job::ask).map(|request| request.stage);
    let Some(stage) = stages.min_by_key(|stage| (stage.reached, stage.cycles)) else {
        return Ok(false);
    };
    let is_next = |job: &&mut SwarmJob| job.ask().is_some_and(|request| request.stage == stage);
    let mut group: Vec<&mut SwarmJob> = jobs.iter_mut().filter(is_next).collect();
    let (batch, counts) = batch(&group, packed)?;
    let outcome = evaluate(&batch)?;
    let mut first = 0;
    for (job, count) in group.iter_mut().zip(counts) {
        let own = first..first + count;
        first = own.end;
        job.tell(&Results {
            fitness: &outcome.fitness[own.clone()],
            traces: &[],
            logs: outcome.logs.get(own.clone()).unwrap_or_default(),
            log_words: batch.record_words(),
            states: outcome.states.get(own).unwrap_or_default(),
        })?;
    }
    Ok(true)
}

/// The next requests of some jobs, all of one stage, as a batch; and how many rollouts each job has in it.
fn batch(jobs: &[&mut SwarmJob], packed: &mut Packed) -> Result<(Batch, Vec<usize>)> {
    let mut places: Vec<&Place> = Vec::new();
    let mut rollouts = Vec::new();
    let mut states: Vec<Vec<u32>> = Vec::new();
    let mut counts = Vec::new();
    let mut stretch = None;
    for request in jobs.iter().filter_map(|job| job.ask()) {
        let mut indices = Vec::new();
        for place in request.worlds {
            let known = places.iter().position(|known| known.key == place.key);
            indices.push(known.unwrap_or(places.len()));
            if known.is_none() {
                places.push(place);
            }
        }
        let before = rollouts.len();
        rollouts.extend(request.rollouts.map(|rollout| Rollout {
            world: indices[rollout.world],
            ..rollout
        }));
        counts.push(rollouts.len() - before);
        states.extend_from_slice(request.states);
        stretch = request.stage.cycles.zip(request.stage.trace_every);
    }
    let keys: Vec<blake3::Hash> = places.iter().map(|place| place.key).collect();
    let known = packed.iter().position(|(known, _)| *known == keys);
    let index = known.unwrap_or(packed.len());
    if known.is_none() {
        packed.push((keys, pack(&places)?));
    }
    let worlds = &packed[index].1;
    let batch = match stretch {
        None => worlds.batch(&rollouts, None)?,
        Some(([start, end], every)) => {
            // States that share a batch are equally long.
            let words = states.iter().map(Vec::len).max().unwrap_or(0);
            for state in &mut states {
                state.resize(words, 0);
            }
            worlds.stretch(&rollouts, start..end, &states, Some(TraceRequest { every }))?
        }
    };
    Ok((batch, counts))
}

/// Places' worlds, packed.
fn pack(places: &[&Place]) -> Result<Worlds> {
    let worlds: Vec<&dyn WorldKind> = places
        .iter()
        .map(|place| -> &dyn WorldKind {
            match &place.world {
                PlaceKind::Life(world) => &**world,
                PlaceKind::Forager(world) => &**world,
                PlaceKind::Swarm(world) => &**world,
            }
        })
        .collect();
    Ok(Worlds::new(&worlds)?)
}

#[cfg(test)]
mod tests;
