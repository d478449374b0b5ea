//! The program on one robot: its simulator, its controllers, and its decisions at the end of each interval. It needs only the
//! robot's fitness, the results of its simulations and the received messages.

use oneiro::batch::Rollout;
use oneiro::foraging::Light;
use oneiro::random::Key;
use oneiro_evolve::encapsulated::{Controllers, Genome, any_gene};
use oneiro_evolve::random::{Stream, shuffled, stream};
use serde::{Deserialize, Serialize};

use super::clock::Clock;
use super::settings::{Says, Settings};
use crate::exchange::Message;
use crate::exchange::pairs::{Pairs, Rules};
use crate::swarm::record::Credit;

/// What a robot had at the end of an interval.
#[derive(Clone, Debug, PartialEq)]
pub struct Ended {
    /// The robot that the simulator of its next interval came from, and the interval there that its fitness was of; none if it is its own.
    pub from: Option<(usize, u32)>,
    /// Its pairs, the best first.
    pub pairs: Vec<Message>,
}

/// One robot's evolution of controllers and of its simulator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OnBoard {
    seed: u64,
    pub clock: Clock,
    /// The controller that it starts with.
    pub first: Genome,
    controllers: Controllers,
    /// The controller that did best in each interval's simulations, and its fitness there.
    pub chosen: Vec<Genome>,
    pub simulated: Vec<f32>,
    /// The gene of its simulator in each interval so far, the present one last.
    pub simulators: Vec<f32>,
    /// Its real fitness in each interval that has ended.
    pub real: Vec<f32>,
    /// The ranking of the controllers in the present simulator, from the best to the worst.
    pub(super) ranking: Vec<usize>,
}

impl OnBoard {
    /// State of a robot that is about to be switched on.
    pub fn new(settings: &Settings, clock: Clock, seed: u64) -> Self {
        let controllers = Controllers::new(settings.controllers.population as usize, seed);
        Self {
            seed,
            clock,
            first: controllers.genomes()[0],
            controllers,
            chosen: Vec::new(),
            simulated: Vec::new(),
            simulators: vec![any_gene(&mut stream(seed, Stream::Exchange, 0))],
            real: Vec::new(),
            ranking: Vec::new(),
        }
    }

    /// The interval that it is in.
    pub fn interval(&self) -> u32 {
        self.simulators.len() as u32 - 1
    }

    /// The gene of its simulator.
    pub fn simulator(&self) -> f32 {
        self.simulators[self.simulators.len() - 1]
    }

    /// Replaces its simulator.
    pub(crate) fn set_simulator(&mut self, gene: f32) {
        if let Some(own) = self.simulators.last_mut() {
            *own = gene;
        }
    }

    /// The scenario that it simulates.
    pub fn scenario(&self) -> Light {
        Light::of_gene(self.simulator())
    }

    /// The controllers to simulate in this interval.
    pub fn controllers(&self) -> &[Genome] {
        self.controllers.genomes()
    }

    /// Their episodes in its simulator, which is world number `world` of a batch. `robot` is its number in the run with this
    /// seed.
    pub fn rollouts(&self, world: usize, seed: u64, robot: u64) -> impl Iterator<Item = Rollout<'_>> {
        let generation = u64::from(self.interval()) + 1;
        self.controllers().iter().zip(0..).map(move |(genes, index)| Rollout {
            world,
            genes,
            key: Key::rollout(seed, generation, robot, index),
        })
    }

    /// Whether this interval's controllers are still to be simulated.
    pub fn is_to_simulate(&self) -> bool {
        self.simulated.len() < self.simulators.len()
    }

    /// Takes the fitness of its controllers in its simulator.
    pub fn take_simulated(&mut self, fitness: &[f32]) {
        self.ranking = self.controllers.ranking(fitness, self.seed, self.interval());
        let best = self.ranking[0];
        self.chosen.push(self.controllers.genomes()[best]);
        self.simulated.push(fitness[best]);
    }

    /// The simulator in which the controller was chosen that acts in an interval's last second; that of the interval
    /// itself if none was.
    pub fn chosen_under(&self, interval: u32) -> f32 {
        self.simulators[self.credited_in(interval, Credit::Matched) as usize]
    }

    /// The interval of the simulator that a fitness of an interval is credited to.
    pub fn credited_in(&self, interval: u32, credit: Credit) -> u32 {
        let last = self.clock.seconds_of(interval).end - 1;
        match credit {
            Credit::Lagged => interval,
            Credit::Matched => self.clock.chosen_in(last).unwrap_or(interval),
        }
    }

    /// That simulator.
    pub fn credited(&self, interval: u32, credit: Credit) -> f32 {
        self.simulators[self.credited_in(interval, credit) as usize]
    }

    /// The controller that acts in a second: the one before, while the simulations that choose it are late.
    pub fn acts(&self, second: u32) -> Genome {
        let count = self.clock.chosen_in(second).map_or(0, |interval| interval as usize + 1);
        let chosen = &self.chosen[..count.min(self.chosen.len())];
        chosen.last().copied().unwrap_or(self.first)
    }

    /// The message that it broadcasts in a second; none before it is switched on. `so_far` is its fitness in this interval until
    /// then, and `whole` gives that of an interval that has ended.
    pub fn message(
        &self,
        sender: usize,
        at: u32,
        (says, credit): (Says, Credit),
        so_far: f32,
        whole: impl FnOnce(usize) -> Option<f32>,
    ) -> Option<Message> {
        let now = self.clock.interval_at(at)?;
        let (interval, fitness) = match says {
            Says::SoFar => (now, so_far),
            Says::LastWhole => {
                let last = now.checked_sub(1)?;
                (last, whole(last as usize)?)
            }
        };
        Some(Message {
            sender,
            interval,
            simulator: self.credited(interval, credit),
            fitness,
            controller: self.acts(at),
        })
    }

    /// Ends an interval that it has missed in part, or whose controllers were not simulated in time: its controllers and its
    /// simulator remain unchanged.
    pub fn miss_interval(&mut self, real: f32) {
        if self.is_to_simulate() {
            let acting = self.chosen.last().copied().unwrap_or(self.first);
            self.chosen.push(acting);
            self.simulated.push(self.simulated.last().copied().unwrap_or(f32::NAN));
        }
        self.real.push(real);
        self.simulators.push(self.simulator());
    }

    /// How well the simulator that chose the controller of an interval predicted its real fitness there: minus the difference. None if
    /// no simulator chose it.
    pub(super) fn agreement(&self, interval: u32, real: f32) -> Option<f32> {
        let last = self.clock.seconds_of(interval).end - 1;
        let predicted = self.simulated[self.clock.chosen_in(last)? as usize];
        Some(-(predicted - real).abs())
    }

    /// Ends an interval in which its real fitness was `real`: breeds its controllers, and takes over the best simulator among its
    /// own and the received ones, mutated.
    pub fn end_interval(&mut self, settings: &Settings, real: f32, heard: &[Message]) -> Ended {
        self.end_interval_by(settings, real, (settings.simulators.credit, real), heard)
    }

    /// The same where simulators are compared by something else than real fitness: `by` has the rule of credit and what its own
    /// simulator has reached.
    pub(super) fn end_interval_by(
        &mut self,
        settings: &Settings,
        real: f32,
        (credit, reached): (Credit, f32),
        heard: &[Message],
    ) -> Ended {
        let interval = self.interval();
        let pairs = stored(settings.pair_rules(), heard);
        let ranked = pairs.ranked();
        let guests: Vec<Genome> = ranked
            .iter()
            .take(settings.controllers.guests as usize)
            .map(|pair| pair.controller)
            .collect();
        self.controllers = self
            .controllers
            .bred(&self.ranking, &settings.breeding(), &guests, self.seed, interval + 1);
        let own = self.credited(interval, credit);
        let better = pairs.better_than(reached);
        let kept = better.map_or(own, |pair| pair.simulator);
        let mut random = stream(self.seed, Stream::Exchange, interval + 1);
        self.real.push(real);
        self.simulators
            .push(settings.simulator_mutation().of(kept, &mut random));
        Ended {
            from: better.map(|pair| (pair.sender, pair.interval)),
            pairs: ranked,
        }
    }

    /// Begins an interval without simulations: the controller that acts in it is known.
    pub(super) fn begin_without_simulator(&mut self) {
        self.simulated.push(f32::NAN);
    }

    /// Ends an interval without simulators, in which its real fitness was `real`: takes over a controller, mutated. It is the best of
    /// its own and of those received, or any of those received.
    pub(super) fn end_interval_without_simulator(
        &mut self,
        settings: &Settings,
        real: f32,
        heard: &[Message],
        is_random: bool,
    ) -> Ended {
        let interval = self.interval();
        let rules = settings.pair_rules();
        // A full store would prefer the fittest.
        let room = if is_random { usize::MAX } else { rules.room };
        let pairs = stored(Rules { room, ..rules }, heard);
        let ranked = pairs.ranked();
        let mut random = stream(self.seed, Stream::Exchange, interval + 1);
        let other = match (is_random, ranked.len()) {
            (true, 0) => None,
            (true, count) => Some(ranked[shuffled(count, &mut random)[0]]),
            (false, _) => pairs.better_than(real).copied(),
        };
        let acting = self.acts(self.clock.seconds_of(interval).end - 1);
        let taken = other.map_or(acting, |pair| pair.controller);
        self.chosen.push(settings.breeding().mutated(taken, &mut random));
        self.real.push(real);
        self.simulators.push(self.simulator());
        self.begin_without_simulator();
        Ended {
            from: other.map(|pair| (pair.sender, pair.interval)),
            pairs: ranked,
        }
    }
}

/// The pairs that a robot has stored of what it heard.
fn stored(rules: Rules, heard: &[Message]) -> Pairs {
    let mut pairs = Pairs::new(rules);
    for message in heard {
        pairs.hear(*message);
    }
    pairs
}
