//! What one robot knows and decides: its simulator, its controllers, and what it does at the end of each interval. A
//! robot could run this by itself: it needs its own fitness, what it heard and what its simulations gave.

use oneiro::foraging::Light;

use super::clock::Clock;
use super::settings::Settings;
use crate::evolve::encapsulated::{Controllers, Genome, any_gene};
use crate::evolve::random::{Stream, stream};
use crate::exchange::Message;
use crate::exchange::pairs::Pairs;
use crate::swarm::lived::Credit;

/// One robot's evolution.
#[derive(Clone, Debug)]
pub(crate) struct Mind {
    seed: u64,
    pub(crate) clock: Clock,
    /// The controller that it starts with.
    pub(crate) first: Genome,
    controllers: Controllers,
    /// The best of each interval's simulations, and its fitness there.
    pub(crate) found: Vec<Genome>,
    pub(crate) dreamt: Vec<f32>,
    /// The gene of its simulator in each interval so far, the present one last.
    pub(crate) simulators: Vec<f32>,
    /// What it really earned in each interval that has ended.
    pub(crate) earned: Vec<f32>,
    /// The ranking of the population in the present simulator.
    ranking: Vec<usize>,
}

impl Mind {
    /// A robot that is about to be switched on.
    pub(crate) fn new(settings: &Settings, clock: Clock, seed: u64) -> Self {
        let controllers = Controllers::new(settings.controllers.population as usize, seed);
        Self {
            seed,
            clock,
            first: controllers.genomes()[0],
            controllers,
            found: Vec::new(),
            dreamt: Vec::new(),
            simulators: vec![any_gene(&mut stream(seed, Stream::Exchange, 0))],
            earned: Vec::new(),
            ranking: Vec::new(),
        }
    }

    /// The interval that it is in.
    pub(crate) fn interval(&self) -> u32 {
        self.simulators.len() as u32 - 1
    }

    /// The gene of its simulator.
    pub(crate) fn simulator(&self) -> f32 {
        self.simulators[self.simulators.len() - 1]
    }

    /// Puts another simulator in the place of its own.
    pub(crate) fn set_simulator(&mut self, gene: f32) {
        if let Some(own) = self.simulators.last_mut() {
            *own = gene;
        }
    }

    /// The scenario that it simulates.
    pub(crate) fn scenario(&self) -> Light {
        Light::of_gene(self.simulator())
    }

    /// The controllers that are simulated in this interval.
    pub(crate) fn population(&self) -> &[Genome] {
        self.controllers.genomes()
    }

    /// Takes what they earned in the simulator.
    pub(crate) fn dream(&mut self, fitness: &[f32]) {
        self.ranking = self.controllers.ranking(fitness, self.seed, self.interval());
        let best = self.ranking[0];
        self.found.push(self.controllers.genomes()[best]);
        self.dreamt.push(fitness[best]);
    }

    /// The simulator in which the controller was chosen that acts in an interval's last second; that of the interval
    /// itself if none was.
    pub(crate) fn chosen_under(&self, interval: u32) -> f32 {
        let last = self.clock.seconds_of(interval).end - 1;
        self.simulators[self.clock.found_in(last).unwrap_or(interval) as usize]
    }

    /// The simulator that a fitness of an interval is credited to.
    pub(crate) fn credited(&self, interval: u32, credit: Credit) -> f32 {
        match credit {
            Credit::Lagged => self.simulators[interval as usize],
            Credit::Matched => self.chosen_under(interval),
        }
    }

    /// The controller that acts in a second.
    pub(crate) fn acts(&self, second: u32) -> Genome {
        self.clock
            .found_in(second)
            .map_or(self.first, |interval| self.found[interval as usize])
    }

    /// The end of an interval: what it earned is `real`, what it heard came as messages. It breeds its controllers, and
    /// goes on with the best simulator that it knows of, changed. Whether that came from another robot.
    pub(crate) fn wake(&mut self, settings: &Settings, real: f32, heard: &[Message]) -> bool {
        let interval = self.interval();
        let mut pairs = Pairs::new(settings.pair_rules());
        for message in heard {
            pairs.hear(*message);
        }
        let guests: Vec<Genome> = pairs
            .ranked()
            .iter()
            .take(settings.controllers.guests as usize)
            .map(|pair| pair.controller)
            .collect();
        self.controllers = self
            .controllers
            .bred(&self.ranking, &settings.breeding(), &guests, self.seed, interval + 1);
        let own = self.credited(interval, settings.simulators.credit);
        let better = pairs.better_than(real);
        let kept = better.map_or(own, |pair| pair.simulator);
        let mut random = stream(self.seed, Stream::Exchange, interval + 1);
        self.earned.push(real);
        self.simulators
            .push(settings.simulator_mutation().of(kept, &mut random));
        better.is_some()
    }
}
