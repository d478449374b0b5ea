//! Random search, a control: every generation has new random genomes, drawn like generation 0. Compared at equal
//! evaluations, it shows what an optimiser's selection adds.

use crate::error::Result;

use super::random::{Stream, stream};
use super::registry::Entry;
use super::settings::{GivenGenomes, Ranges, Settings, Space};
use super::{Optimizer, Population, saved};

const NAME: &str = "random";
const VERSION: u32 = 1;

pub(crate) const ENTRY: Entry = Entry {
    start: GivenGenomes::None("all genomes are random"),
    ..Entry::new(
        [
            NAME,
            "random genomes in every generation: a control",
            "to see what another optimiser adds",
        ],
        |beginning| {
            Box::new(RandomSearch::new(
                beginning.settings,
                beginning.seed,
                &beginning.ranges(),
            ))
        },
    )
};

/// The search at one generation.
#[derive(Clone, Debug)]
struct RandomSearch {
    owner: saved::Owner,
    size: u32,
    seed: u64,
    space: Space,
    generation: u32,
    population: Population,
}

impl RandomSearch {
    fn new(settings: &Settings, seed: u64, ranges: &Ranges) -> Self {
        let space = Space::new(settings, ranges);
        let mut search = Self {
            owner: saved::Owner::new(settings, seed, ranges),
            size: settings.population,
            seed,
            population: Population::new(space.len(), Vec::new()),
            space,
            generation: 0,
        };
        search.population = search.drawn();
        search
    }

    /// The genomes of a generation.
    fn drawn(&self) -> Population {
        let mut random = stream(self.seed, Stream::InitialGenes, self.generation);
        Population::new(self.space.len(), self.space.drawn(self.size, &mut random))
    }
}

impl Optimizer for RandomSearch {
    fn name(&self) -> &'static str {
        NAME
    }

    fn generation(&self) -> u32 {
        self.generation
    }

    fn ask(&self) -> &Population {
        &self.population
    }

    fn advance(&mut self, _: &[f32], _: &[u32], _: &[f64]) -> Population {
        self.generation += 1;
        let next = self.drawn();
        std::mem::replace(&mut self.population, next)
    }

    fn set_generations(&mut self, generations: u32) {
        self.owner.set_generations(generations);
    }

    fn save(&self) -> Vec<u8> {
        saved::seal(NAME, VERSION, &self.owner, &self.generation)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result {
        self.generation = saved::open(NAME, VERSION, &self.owner, bytes)?;
        self.population = self.drawn();
        Ok(())
    }
}
