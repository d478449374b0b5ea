//! The evolution strategy of Salimans, Ho, Chen, Sidor and Sutskever, "Evolution strategies as a scalable alternative to
//! reinforcement learning" (arXiv 1703.03864, 2017): mirrored samples around a centre, of which only the ranks count, give a
//! gradient, which Adam (Kingma and Ba, arXiv 1412.6980, 2014) follows. Places count from the middle of the initial range of each
//! gene, in halves of that range.

use crate::error::{Error, Result};
use rand::distr::Distribution;
use serde::{Deserialize, Serialize};

use super::random::{Normal, Stream, Uniform, stream};
use super::registry::Entry;
use super::settings::{Checked, Feature, Given, GivenGenomes, Ranges, Settings, Space, Surroundings, refused};
use super::{Optimizer, Population, saved};

const NAME: &str = "open-es";
const VERSION: u32 = 1;

pub(crate) const ENTRY: Entry = Entry {
    features: &[Feature::FollowsGradient],
    start: GivenGenomes::Mean,
    population: "40",
    complete,
    check,
    ..Entry::new(
        [
            NAME,
            "evolution strategy with mirrored samples, ranks and Adam: Salimans et al. 2017",
            "networks of hundreds of genes or more, with several episodes each",
        ],
        |beginning| {
            Box::new(OpenEs::new(
                beginning.settings,
                beginning.seed,
                &beginning.ranges(),
                beginning.init.as_ref(),
            ))
        },
    )
};

fn complete(settings: &mut Settings, given: Given) {
    if !given.has_population {
        settings.population = 40;
    }
    // The best of those that docs/optimisers.md compares.
    settings.strategy.sigma.get_or_insert(0.8);
    settings.strategy.learning_rate.get_or_insert(0.3);
    settings.common.get_or_insert(true);
}

fn check(settings: &Settings, _: &Surroundings<'_>) -> Checked {
    let population = settings.population;
    if population % 2 == 1 {
        let problem = format!("is {population}; allowed: an even number, since samples are mirrored");
        return refused("evolution.population", problem);
    }
    Ok(())
}

/// How much of Adam's means of gradients, and of their squares, stays from step to step.
const KEPT: [f64; 2] = [0.9, 0.999];
/// What Adam adds to a divisor.
const ADDED: f64 = 1e-8;

/// The strategy at one generation.
#[derive(Clone, Debug)]
struct OpenEs {
    owner: saved::Owner,
    pairs: usize,
    sigma: f64,
    learning_rate: f64,
    weight_decay: f64,
    seed: u64,
    space: Space,
    state: OpenEsState,
    /// The direction of each pair's first sample, one after the other.
    directions: Vec<f64>,
    population: Population,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct OpenEsState {
    generation: u32,
    centre: Vec<f64>,
    /// Adam's means of gradients, and of their squares.
    gradients: Vec<f64>,
    squares: Vec<f64>,
    /// The fractions of these means that are still the initial values.
    initial_weights: [f64; 2],
}

impl OpenEs {
    /// Begins at random genes, or at the mean of given genomes.
    fn new(settings: &Settings, seed: u64, ranges: &Ranges, init: Option<&Population>) -> Self {
        let space = Space::new(settings, ranges);
        let mut random = stream(seed, Stream::Beginning, 0);
        let uniform = Uniform { low: -1.0, high: 1.0 };
        let genes = space.len();
        let drawn = || {
            let genes = 0..genes;
            genes
                .map(|gene| space.share(gene) * uniform.sample(&mut random))
                .collect()
        };
        let state = OpenEsState {
            generation: 0,
            centre: init.map_or_else(drawn, |given| space.mean(given)),
            gradients: vec![0.0; genes],
            squares: vec![0.0; genes],
            initial_weights: [1.0; 2],
        };
        let mut strategy = Self {
            owner: saved::Owner::new(settings, seed, ranges),
            pairs: settings.population as usize / 2,
            sigma: settings.strategy.sigma.unwrap_or_default(),
            learning_rate: settings.strategy.learning_rate.unwrap_or_default(),
            weight_decay: settings.strategy.weight_decay,
            seed,
            space,
            state,
            directions: Vec::new(),
            population: Population::new(genes, Vec::new()),
        };
        strategy.sample();
        strategy
    }

    /// Samples the generation's genomes, in pairs at opposite sides of the centre.
    fn sample(&mut self) {
        let genes = self.space.len();
        let mut random = stream(self.seed, Stream::Sampling, self.state.generation);
        let normal = Normal { deviation: 1.0 };
        self.directions = (0..self.pairs * genes).map(|_| normal.sample(&mut random)).collect();
        let mut values = Vec::with_capacity(2 * self.directions.len());
        for direction in self.directions.chunks_exact(genes) {
            for sigma in [self.sigma, -self.sigma] {
                let places = self.state.centre.iter().zip(direction).enumerate();
                values.extend(places.map(|(gene, (centre, along))| self.space.gene(gene, centre + sigma * along)));
            }
        }
        self.population = Population::new(genes, values);
    }

    /// Moves the centre.
    fn step(&mut self, ranking: &[u32]) {
        let OpenEsState {
            centre,
            gradients,
            squares,
            initial_weights,
            ..
        } = &mut self.state;
        let count = ranking.len() as f64;
        let mut shaped = vec![0.0; ranking.len()];
        for (place, &individual) in ranking.iter().enumerate() {
            shaped[individual as usize] = 0.5 - place as f64 / (count - 1.0);
        }
        let mut gradient = vec![0.0; centre.len()];
        for (pair, direction) in shaped.chunks_exact(2).zip(self.directions.chunks_exact(centre.len())) {
            let weight = pair[0] - pair[1];
            for (sum, along) in gradient.iter_mut().zip(direction) {
                *sum += weight * along;
            }
        }
        for (share, kept) in initial_weights.iter_mut().zip(KEPT) {
            *share *= kept;
        }
        let rate = self.learning_rate * (1.0 - initial_weights[1]).sqrt() / (1.0 - initial_weights[0]);
        let adam = gradients.iter_mut().zip(squares);
        for (gene, ((centre, sum), (mean, square))) in centre.iter_mut().zip(gradient).zip(adam).enumerate() {
            let slope = sum / count - self.weight_decay * *centre;
            *mean = KEPT[0] * *mean + (1.0 - KEPT[0]) * slope;
            *square = KEPT[1] * *square + (1.0 - KEPT[1]) * (slope * slope);
            let [least, greatest] = self.space.bounds(gene);
            *centre = (*centre + rate * *mean / (square.sqrt() + ADDED)).clamp(least, greatest);
        }
        self.state.generation += 1;
    }
}

impl Optimizer for OpenEs {
    fn name(&self) -> &'static str {
        NAME
    }

    fn distribution(&self) -> Option<(Vec<f32>, f64)> {
        Some((self.space.genome(&self.state.centre), self.sigma))
    }

    fn generation(&self) -> u32 {
        self.state.generation
    }

    fn ask(&self) -> &Population {
        &self.population
    }

    fn advance(&mut self, _: &[f32], ranking: &[u32], _: &[f64]) -> Population {
        let evaluated = self.population.clone();
        self.step(ranking);
        self.sample();
        evaluated
    }

    fn set_generations(&mut self, generations: u32) {
        self.owner.set_generations(generations);
    }

    fn save(&self) -> Vec<u8> {
        saved::seal(NAME, VERSION, &self.owner, &self.state)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result {
        let state: OpenEsState = saved::open(NAME, VERSION, &self.owner, bytes)?;
        if [&state.centre, &state.gradients, &state.squares].map(Vec::len) != [self.space.len(); 3] {
            return Err(Error::Lengths);
        }
        self.state = state;
        self.sample();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::settings::Kind;
    use super::*;

    const GENES: usize = 3;

    fn strategy() -> OpenEs {
        let mut settings = Settings {
            kind: Kind::OpenEs,
            population: 4,
            ..Settings::default()
        };
        settings.strategy.sigma = Some(0.02);
        settings.strategy.learning_rate = Some(0.01);
        settings.complete(GENES, 1, true);
        OpenEs::new(&settings, 1, &vec![None; GENES], None)
    }

    #[test]
    fn samples_are_mirrored() {
        let strategy = strategy();
        for pair in 0..2 {
            let [one, other] = [0, 1].map(|side| strategy.ask().genome(2 * pair + side));
            for gene in 0..GENES {
                let middle = 0.5 * (f64::from(one[gene]) + f64::from(other[gene]));
                assert!((middle - strategy.state.centre[gene]).abs() < 1e-7);
                assert!(one[gene] != other[gene]);
            }
        }
    }

    /// Three steps, held against the formulas written out for one gene after the other.
    #[test]
    fn steps_are_those_of_the_formulas() {
        let mut strategy = strategy();
        let mut centre = strategy.state.centre.clone();
        let mut adam = [[0.0_f64; 2]; GENES];
        let (fitness, shaped) = ([3.0, 1.0, 2.0, 7.0], [1.0 / 6.0, -0.5, -1.0 / 6.0, 0.5]);
        for step in 1..4 {
            for gene in 0..GENES {
                let along = |pair: usize| strategy.directions[pair * GENES + gene];
                let gradient = ((shaped[0] - shaped[1]) * along(0) + (shaped[2] - shaped[3]) * along(1)) / 4.0;
                let slope = gradient - 0.005 * centre[gene];
                let [mean, square] = &mut adam[gene];
                *mean = 0.9 * *mean + 0.1 * slope;
                *square = 0.999 * *square + 0.001 * slope * slope;
                let rate = 0.01 * (1.0 - 0.999_f64.powi(step)).sqrt() / (1.0 - 0.9_f64.powi(step));
                centre[gene] += rate * *mean / (square.sqrt() + 1e-8);
            }
            strategy.tell(fitness.to_vec(), &[]).unwrap();
            for (gene, expected) in strategy.state.centre.iter().zip(&centre) {
                assert!((gene - expected).abs() < 1e-14, "step {step}: {gene} {expected}");
            }
        }
    }
}
