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

use oneiro::swarm::{Lamp, SECOND};
use serde::Serialize;

use crate::engine::handle::Engine;
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
/// As [`Engine::finished`].
pub(crate) fn live(plans: &[Plan], engine: &Engine) -> Result<Vec<Run>> {
    let jobs = plans.iter().cloned().map(SwarmJob::new).collect();
    Ok(engine.finished(jobs, &mut ())?.iter().map(SwarmJob::run).collect())
}

#[cfg(test)]
mod tests;
