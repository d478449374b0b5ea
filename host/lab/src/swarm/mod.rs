//! Swarms whose on-board simulators evolve with their controllers: the algorithm of O'Dowd, Studley and Winfield (2014).
//!
//! | file | content |
//! |---|---|
//! | [`job`] | a run: asks for evaluations, takes their results |
//! | [`on_board`] | the evolution on one robot |
//! | [`clock`] | a robot's intervals |
//! | [`memory`] | the exchange of messages within one process |
//! | [`record`], [`tables`] | the record of a run, and its tables |

pub mod clock;
pub mod job;
pub mod measures;
mod memory;
pub mod on_board;
pub mod record;
pub mod settings;
pub mod tables;

use oneiro::random::Key;
use oneiro::swarm::{Lamp, SECOND};
use oneiro_base::exit::Result;
use oneiro_evolve::random::{Stream, below, stream};
use serde::Serialize;

use crate::engine::handle::Engine;
use crate::swarm::record::{Case, Kind, Run};
use clock::Clock;
use job::SwarmJob;
use settings::Settings;

/// A swarm's run: its experiment, its control and its seed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// The values of its experiment.
    pub settings: Settings,
    /// The paper's evolution, or a control.
    pub kind: Kind,
    /// Its number among those of its kind and case.
    pub number: u32,
    /// Seed of everything random except the differences between robots.
    pub seed: u64,
}

impl Plan {
    /// The arena's lamp.
    pub fn lamp(&self) -> Lamp {
        self.settings.case.lamp(SECOND * self.settings.light_moves())
    }

    /// When each robot is switched on, and the times of its intervals.
    pub fn clocks(&self) -> Vec<Clock> {
        let times = &self.settings.clock;
        let mut schedule = stream(self.seed, Stream::Schedule, 0);
        let clock = |_| Clock {
            offset: below(times.offset_s as usize + 1, &mut schedule) as u32,
            interval: times.interval_s,
            installed: times.installed_s,
        };
        (0..self.settings.world.robots).map(clock).collect()
    }

    /// The seed of a robot's random numbers.
    pub fn robot_seed(&self, robot: usize) -> u64 {
        let [low, high] = Key::rollout(self.seed, u64::MAX, robot as u64, 0).words;
        u64::from(low) | u64::from(high) << 32
    }

    /// A hash of everything that decides the run.
    fn hash(&self) -> blake3::Hash {
        blake3::hash(&serde_json::to_vec(self).expect("plans are numbers and words"))
    }
}

/// Robot-steps of a swarm, in the arena and on board.
pub fn steps(plan: &Plan) -> [u64; 2] {
    let own = &plan.settings;
    let real = u64::from(own.world.robots) * u64::from(SECOND * own.seconds());
    let cycles = u64::from(SECOND * own.clock.interval_s) * u64::from(own.seconds() / own.clock.interval_s);
    let simulators = if own.case == Case::Random {
        0
    } else {
        plan.kind.simulators()
    };
    [real, controllers(own) * cycles * simulators as u64]
}

/// Controllers of all robots.
pub fn controllers(settings: &Settings) -> u64 {
    u64::from(settings.world.robots) * u64::from(settings.controllers.population)
}

/// Runs swarms from beginning to end.
///
/// # Errors
/// As [`Engine::finished`].
pub fn live(plans: &[Plan], engine: &Engine) -> Result<Vec<Run>> {
    let jobs = plans.iter().cloned().map(SwarmJob::new).collect();
    Ok(engine.finished(jobs, &mut ())?.iter().map(SwarmJob::run).collect())
}

#[cfg(test)]
mod tests;
