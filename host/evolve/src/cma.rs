//! Evolution strategies that adapt the covariances of their samples: CMA-ES (Hansen, "The CMA evolution strategy: a tutorial",
//! arXiv 1604.00772, 2016) with a full matrix, and sep-CMA-ES (Ros and Hansen, "A simple modification in CMA-ES achieving linear
//! time and space complexity", PPSN X, 2008) with a diagonal one. Constants and updates are those of the Python package `cma` 4.5.0
//! where the two differ; the diagonal is updated as the full matrix is.
//!
//! Places count from the middle of the initial range of each gene, in halves of that range. Genes beyond their bounds are evaluated at the
//! bound; the strategy learns from the samples as they were drawn, and its mean stays within the bounds.

mod jacobi;

use crate::error::{Error, Result};
use oneiro::exact::exponential;
use rand::distr::Distribution as _;
use serde::{Deserialize, Serialize};

use super::random::{Normal, Stream, Uniform, logarithm, stream};
use super::registry::Entry;
use super::settings::{Checked, Feature, Given, GivenGenomes, Ranges, Settings, Space, Surroundings, refused};
use super::{Kind, Optimizer, Population, ranked, saved};

/// The version of saved states.
const VERSION: u32 = 1;

/// The strategy with a full matrix.
pub(crate) const FULL: Entry = Entry {
    check: |settings, surroundings| {
        let genes = surroundings.genes.len();
        if genes > MOST_GENES {
            let problem = format!("is \"cma-es\" with {genes} genes; allowed: up to {MOST_GENES}, or sep-cma-es");
            return refused("evolution.kind", problem);
        }
        check(settings, surroundings)
    },
    ..entry([
        "cma-es",
        "evolution strategy with a full covariance matrix, up to 100 genes: Hansen 2016",
        "small networks whose genes depend on each other",
    ])
};

/// The strategy with a diagonal matrix.
pub(crate) const DIAGONAL: Entry = entry([
    "sep-cma-es",
    "the same with a diagonal matrix, for any number of genes: Ros and Hansen 2008",
    "more than 100 genes",
]);

/// The common values of both.
const fn entry(words: [&'static str; 3]) -> Entry {
    Entry {
        features: &[Feature::AdaptsCovariances, Feature::SetsFirstGenes],
        start: GivenGenomes::Mean,
        population: "4 + 3 ln(genes), rounded down",
        complete,
        check,
        ..Entry::new(words, |beginning| {
            Box::new(Cma::new(
                beginning.settings,
                beginning.seed,
                &beginning.ranges(),
                beginning.init.as_ref(),
            ))
        })
    }
}

/// The most genes that a full matrix is for.
const MOST_GENES: usize = 100;

/// Minimum population: two of them are better than the others.
const LEAST_POPULATION: u32 = 4;

fn complete(settings: &mut Settings, given: Given) {
    if !given.has_population {
        settings.population = 4 + (3.0 * logarithm(given.genes as f64)).floor() as u32;
    }
    settings.strategy.sigma.get_or_insert(0.5);
    settings.common.get_or_insert(false);
}

fn check(settings: &Settings, _: &Surroundings<'_>) -> Checked {
    let population = settings.population;
    if population < LEAST_POPULATION {
        let problem = format!("is {population}; allowed: {LEAST_POPULATION} or more");
        return refused("evolution.population", problem);
    }
    Ok(())
}

/// What does not change from generation to generation.
#[derive(Clone, Debug)]
struct Constants {
    is_full: bool,
    /// Weights of the samples from the best to the worst; negative ones of the worse half.
    weights: Vec<f64>,
    /// Effective number of samples by the positive weights: 1 over the sum of their squares.
    mass: f64,
    /// Rates at which the path of the step size, and that step size, change.
    path_sigma: f64,
    damping: f64,
    /// Rates of the path of the mean, and of the covariances by that path and by the samples.
    path: f64,
    rank_one: f64,
    rank_mu: f64,
    /// Mean length of a normal vector.
    length: f64,
}

impl Constants {
    fn new(genes: usize, population: usize, is_full: bool, is_active: bool) -> Self {
        /// The ninth root of 2.
        const NINTH_ROOT: f64 = 1.080_059_738_892_306;
        /// Mean size of a normal number: the square root of 2/pi.
        const LENGTH_OF_ONE: f64 = 0.797_884_560_802_865_4;
        let (n, count) = (genes as f64, population as f64);
        let half = logarithm(0.5 * (count + 1.0));
        let raw: Vec<f64> = (1..=population).map(|place| half - logarithm(place as f64)).collect();
        let parents = population / 2;
        let sums = |weights: &[f64]| {
            let sum: f64 = weights.iter().sum();
            let squares: f64 = weights.iter().map(|weight| weight * weight).sum();
            (sum, sum * sum / squares)
        };
        let (sum, mass) = sums(&raw[..parents]);
        let path_sigma = ((mass + 2.0) / (n + mass + 3.0)).min(0.5);
        // 2^(-n/9)
        let fading = (0..genes.min(10_000)).fold(1.0, |power, _| power / NINTH_ROOT);
        let factor = (3.0 * (1.0 - fading)).max(1.0);
        let excess = factor * ((mass - 1.0) / (n + 1.0)).sqrt() - 1.0;
        let damping = 1.0 + path_sigma + 2.0 * excess.max(0.0);
        let [path, rank_one, rank_mu] = if is_full {
            let path = (4.0 + mass / n) / (n + 4.0 + 2.0 * mass / n);
            let rank_one = (count / 6.0).min(1.0) * 2.0 / ((n + 1.3) * (n + 1.3) + mass);
            let rank_mu = 2.0 * (mass - 2.0 + 1.0 / mass + 0.25) / ((n + 2.0) * (n + 2.0) + mass);
            [path, rank_one, rank_mu]
        } else {
            let root = n.sqrt();
            let path = (1.0 + 1.0 / n + mass / n) / (root + 1.0 / n + 2.0 * mass / n);
            let rank_one = 1.0 / (n + 2.0 * root + mass / n);
            let rank_mu = (mass + 1.0 / mass - 2.0 + 0.25) / (n + 4.0 * root + 0.5 * mass);
            [path, rank_one, rank_mu]
        };
        let rank_mu = rank_mu.min(1.0 - rank_one);
        let mut weights: Vec<f64> = raw[..parents].iter().map(|weight| weight / sum).collect();
        let worse = &raw[parents..];
        let (worse_sum, worse_mass) = sums(worse);
        if is_active && worse_sum < 0.0 && rank_mu > 0.0 {
            let total = (1.0 + rank_one / rank_mu)
                .min(1.0 + 2.0 * worse_mass / (mass + 2.0))
                .min((1.0 - rank_one - rank_mu) / (n * rank_mu));
            weights.extend(worse.iter().map(|weight| -total * (weight / worse_sum)));
        } else {
            weights.extend(worse.iter().map(|_| 0.0));
        }
        let length = (1..genes).fold(LENGTH_OF_ONE, |length, genes| genes as f64 / length);
        Self {
            is_full,
            weights,
            mass,
            path_sigma,
            damping,
            path,
            rank_one,
            rank_mu,
            length,
        }
    }
}

/// The distribution of samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Distribution {
    mean: Vec<f64>,
    sigma: f64,
    /// Row after row, or the diagonal alone.
    covariances: Vec<f64>,
    /// Paths of the step size and of the mean.
    path_sigma: Vec<f64>,
    path: Vec<f64>,
    /// The remaining weight of the first path's initial value: a power of 1 minus its rate.
    initial_weight: f64,
}

/// Square roots of covariances, and their inverse: axes and the deviations along them.
#[derive(Clone, Debug)]
struct Axes {
    /// An axis in each column, row after row; none where they are those of the genes.
    vectors: Option<Vec<f64>>,
    deviations: Vec<f64>,
}

impl Distribution {
    fn new(mean: Vec<f64>, sigma: f64, is_full: bool) -> Self {
        let genes = mean.len();
        let covariances = if is_full {
            (0..genes * genes)
                .map(|index| if index / genes == index % genes { 1.0 } else { 0.0 })
                .collect()
        } else {
            vec![1.0; genes]
        };
        Self {
            path_sigma: vec![0.0; genes],
            path: vec![0.0; genes],
            mean,
            sigma,
            covariances,
            initial_weight: 1.0,
        }
    }

    /// The variance of a gene, in squares of the step size.
    fn variance(&self, gene: usize) -> f64 {
        let genes = self.mean.len();
        if self.covariances.len() == genes {
            self.covariances[gene]
        } else {
            self.covariances[gene * genes + gene]
        }
    }

    fn axes(&self) -> Axes {
        let genes = self.mean.len();
        let (vectors, variances) = if self.covariances.len() == genes && genes > 1 {
            (None, self.covariances.clone())
        } else {
            let (values, vectors) = jacobi::axes(&self.covariances, genes);
            (Some(vectors), values)
        };
        Axes {
            vectors,
            deviations: variances.into_iter().map(|variance| variance.max(0.0).sqrt()).collect(),
        }
    }

    /// Adapts to samples, in deviations from the mean by the step size, from the best to the worst.
    fn update(&mut self, constants: &Constants, axes: &Axes, ranked: &[&[f64]]) {
        /// What `cma` adds to lengths that divide.
        const NO_LENGTH: f64 = 1e-9;
        let &Constants {
            mass,
            path_sigma,
            damping,
            path,
            rank_one,
            rank_mu,
            length,
            ..
        } = constants;
        let genes = self.mean.len();
        let n = genes as f64;
        let mut step = vec![0.0; genes];
        for (sample, &weight) in ranked
            .iter()
            .zip(&constants.weights)
            .filter(|(_, weight)| **weight > 0.0)
        {
            for (sum, deviation) in step.iter_mut().zip(*sample) {
                *sum += weight * deviation;
            }
        }
        for (mean, step) in self.mean.iter_mut().zip(&step) {
            *mean += self.sigma * step;
        }
        let pull = (path_sigma * (2.0 - path_sigma) * mass).sqrt();
        for (of_path, white) in self.path_sigma.iter_mut().zip(axes.whitened(&step)) {
            *of_path = (1.0 - path_sigma) * *of_path + pull * white;
        }
        self.initial_weight *= (1.0 - path_sigma) * (1.0 - path_sigma);
        let square = dot(&self.path_sigma, &self.path_sigma);
        let is_slow = square / n / (1.0 - self.initial_weight) < 2.0 + 4.0 / (n + 1.0);
        let pull = if is_slow {
            (path * (2.0 - path) * mass).sqrt()
        } else {
            0.0
        };
        for (of_path, step) in self.path.iter_mut().zip(&step) {
            *of_path = (1.0 - path) * *of_path + pull * step;
        }
        let lost = if is_slow { 0.0 } else { path * (2.0 - path) };
        let kept = 1.0 - rank_one * (1.0 - lost) - rank_mu * constants.weights.iter().sum::<f64>();
        // A sample with a negative weight is scaled to the average length.
        let scaled: Vec<f64> = ranked
            .iter()
            .zip(&constants.weights)
            .map(|(sample, &weight)| {
                if weight >= 0.0 {
                    return rank_mu * weight;
                }
                let white = axes.whitened(sample);
                let length = dot(&white, &white).sqrt() + NO_LENGTH;
                rank_mu * weight * n / (length * length)
            })
            .collect();
        if self.covariances.len() == genes {
            for (gene, variance) in self.covariances.iter_mut().enumerate() {
                *variance = kept * *variance + rank_one * (self.path[gene] * self.path[gene]);
                for (sample, weight) in ranked.iter().zip(&scaled) {
                    *variance += weight * (sample[gene] * sample[gene]);
                }
            }
        } else {
            for row in 0..genes {
                for column in 0..=row {
                    let mut covariance = kept * self.covariances[row * genes + column];
                    covariance += rank_one * (self.path[row] * self.path[column]);
                    for (sample, weight) in ranked.iter().zip(&scaled) {
                        covariance += weight * (sample[row] * sample[column]);
                    }
                    self.covariances[row * genes + column] = covariance;
                    self.covariances[column * genes + row] = covariance;
                }
            }
        }
        let change = path_sigma / damping * (square.sqrt() / length - 1.0);
        self.sigma *= exponential(change.min(1.0));
    }
}

impl Axes {
    /// A vector of independent normal numbers as a deviation.
    fn coloured(&self, white: &[f64]) -> Vec<f64> {
        let along = white
            .iter()
            .zip(&self.deviations)
            .map(|(part, deviation)| part * deviation);
        match &self.vectors {
            None => along.collect(),
            Some(vectors) => {
                let along: Vec<f64> = along.collect();
                vectors.chunks_exact(along.len()).map(|row| dot(row, &along)).collect()
            }
        }
    }

    /// A deviation by the inverse square root of the covariances.
    fn whitened(&self, deviation: &[f64]) -> Vec<f64> {
        let over = |(part, deviation): (f64, &f64)| if *deviation > 0.0 { part / deviation } else { 0.0 };
        let Some(vectors) = &self.vectors else {
            return deviation.iter().copied().zip(&self.deviations).map(over).collect();
        };
        let genes = deviation.len();
        let mut along = vec![0.0; genes];
        for (row, part) in vectors.chunks_exact(genes).zip(deviation) {
            for (sum, vector) in along.iter_mut().zip(row) {
                *sum += vector * part;
            }
        }
        let along: Vec<f64> = along.into_iter().zip(&self.deviations).map(over).collect();
        vectors.chunks_exact(genes).map(|row| dot(row, &along)).collect()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A strategy at one generation.
#[derive(Clone, Debug)]
pub(super) struct Cma {
    owner: saved::Owner,
    size: usize,
    /// The first step size.
    sigma: f64,
    has_restarts: bool,
    constants: Constants,
    seed: u64,
    space: Space,
    state: CmaState,
    axes: Axes,
    /// Deviations of the samples, one after the other.
    samples: Vec<f64>,
    population: Population,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct CmaState {
    generation: u32,
    distribution: Distribution,
    /// The best and the median fitness of the last generations since the strategy began, the last one at the end.
    bests: Vec<f32>,
    medians: Vec<f32>,
}

impl Cma {
    /// Begins in the middle of the initial range, or at the mean of given genomes.
    pub(super) fn new(settings: &Settings, seed: u64, ranges: &Ranges, init: Option<&Population>) -> Self {
        let space = Space::new(settings, ranges);
        let is_full = settings.kind == Kind::CmaEs;
        let genes = space.len();
        let size = settings.population as usize;
        let sigma = settings.strategy.sigma.unwrap_or_default();
        let mean = match init {
            None => vec![0.0; genes],
            Some(given) => space.mean(given),
        };
        let distribution = Distribution::new(mean, sigma, is_full);
        let mut strategy = Self {
            owner: saved::Owner::new(settings, seed, ranges),
            size,
            sigma,
            has_restarts: settings.strategy.restarts,
            constants: Constants::new(genes, size, is_full, settings.strategy.active),
            seed,
            space,
            axes: distribution.axes(),
            state: CmaState {
                generation: 0,
                distribution,
                bests: Vec::new(),
                medians: Vec::new(),
            },
            samples: Vec::new(),
            population: Population::new(genes, Vec::new()),
        };
        strategy.sample();
        strategy
    }

    /// Samples the generation's genomes.
    fn sample(&mut self) {
        let genes = self.space.len();
        let mut random = stream(self.seed, Stream::Sampling, self.state.generation);
        let normal = Normal { deviation: 1.0 };
        let Distribution { mean, sigma, .. } = &self.state.distribution;
        self.samples.clear();
        let mut values = Vec::with_capacity(self.size * genes);
        for _ in 0..self.size {
            let white: Vec<f64> = (0..genes).map(|_| normal.sample(&mut random)).collect();
            let deviation = self.axes.coloured(&white);
            let places = mean.iter().zip(&deviation).enumerate();
            values.extend(places.map(|(gene, (mean, deviation))| self.space.gene(gene, mean + sigma * deviation)));
            self.samples.extend(deviation);
        }
        self.population = Population::new(genes, values);
    }

    /// Adapts to a ranking of the samples, and begins again where that is of no use.
    fn step(&mut self, fitness: &[f32], ranking: &[u32]) {
        let genes = self.space.len();
        let samples: Vec<&[f64]> = ranking
            .iter()
            .map(|&individual| &self.samples[individual as usize * genes..][..genes])
            .collect();
        let CmaState {
            distribution,
            bests,
            medians,
            generation,
        } = &mut self.state;
        distribution.update(&self.constants, &self.axes, &samples);
        for (gene, mean) in distribution.mean.iter_mut().enumerate() {
            let [least, greatest] = self.space.bounds(gene);
            *mean = mean.clamp(least, greatest);
        }
        *generation += 1;
        let at = |place: usize| fitness[ranking[place] as usize];
        for (history, score) in [(bests, at(0)), (medians, at(ranking.len() / 2))] {
            if history.len() == self.constants.history(genes) {
                history.remove(0);
            }
            history.push(score);
        }
        self.axes = self.state.distribution.axes();
        let is_over = !self.state.distribution.is_sound(&self.axes) || self.has_restarts && self.is_stalled();
        if is_over {
            self.begin_again();
        }
    }

    /// Whether the strategy can't go on: its steps are a 10^12th of the first, one axis is 10^7 times as long as another, the best
    /// of all recent generations are equal, or neither the best nor the median has risen for long.
    fn is_stalled(&self) -> bool {
        const STEP: f64 = 1e-12;
        const SHAPE: f64 = 1e7;
        let CmaState {
            distribution,
            bests,
            medians,
            ..
        } = &self.state;
        let genes = self.space.len();
        let reach = |gene: usize| {
            let step = distribution.variance(gene).sqrt().max(distribution.path[gene].abs());
            distribution.sigma * step
        };
        if (0..genes).all(|gene| reach(gene) < STEP * self.sigma) {
            return true;
        }
        let longest = self.axes.deviations.iter().copied().fold(0.0, f64::max);
        let shortest = self.axes.deviations.iter().copied().fold(f64::INFINITY, f64::min);
        if longest > SHAPE * shortest {
            return true;
        }
        let recent = 10 + (30 * genes).div_ceil(self.size);
        if bests.len() >= recent {
            let recent = &bests[bests.len() - recent..];
            if recent.iter().all(|best| *best == recent[0]) {
                return true;
            }
        }
        bests.len() == self.constants.history(genes) && [bests, medians].iter().all(|history| !has_risen(history))
    }

    /// Begins again at a random place within the initial range, with the first step size.
    fn begin_again(&mut self) {
        let mut random = stream(self.seed, Stream::Beginning, self.state.generation);
        let uniform = Uniform { low: -1.0, high: 1.0 };
        let mean = (0..self.space.len()).map(|_| uniform.sample(&mut random)).collect();
        let CmaState {
            distribution,
            bests,
            medians,
            ..
        } = &mut self.state;
        *distribution = Distribution::new(mean, self.sigma, self.constants.is_full);
        bests.clear();
        medians.clear();
        self.axes = distribution.axes();
    }
}

impl Constants {
    /// Generations without progress from which a strategy begins again (Hansen 2016, appendix B.3, with a window of fixed length).
    fn history(&self, genes: usize) -> usize {
        120 + (30 * genes).div_ceil(self.weights.len())
    }
}

impl Distribution {
    /// Whether its numbers are finite and its matrix still has a square root.
    fn is_sound(&self, axes: &Axes) -> bool {
        let numbers = self.mean.iter().chain(&self.covariances).chain([&self.sigma]);
        numbers.into_iter().all(|number| number.is_finite())
            && self.sigma > 0.0
            && axes.deviations.iter().all(|deviation| *deviation > 0.0)
    }
}

/// Whether the median of the last 30 % is above that of the first.
fn has_risen(history: &[f32]) -> bool {
    let part = history.len() * 3 / 10;
    let median = |part: &[f32]| part[ranked(part)[part.len() / 2] as usize];
    median(&history[history.len() - part..]) > median(&history[..part])
}

impl Optimizer for Cma {
    fn name(&self) -> &'static str {
        if self.constants.is_full {
            FULL.name
        } else {
            DIAGONAL.name
        }
    }

    fn distribution(&self) -> Option<(Vec<f32>, f64)> {
        let Distribution { mean, sigma, .. } = &self.state.distribution;
        Some((self.space.genome(mean), *sigma))
    }

    fn generation(&self) -> u32 {
        self.state.generation
    }

    fn ask(&self) -> &Population {
        &self.population
    }

    fn advance(&mut self, fitness: &[f32], ranking: &[u32], _: &[f64]) -> Population {
        let evaluated = self.population.clone();
        self.step(fitness, ranking);
        self.sample();
        evaluated
    }

    fn set_generations(&mut self, generations: u32) {
        self.owner.set_generations(generations);
    }

    fn save(&self) -> Vec<u8> {
        saved::seal(self.name(), VERSION, &self.owner, &self.state)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result {
        let state: CmaState = saved::open(self.name(), VERSION, &self.owner, bytes)?;
        let distribution = &self.state.distribution;
        let lengths = |distribution: &Distribution| {
            let Distribution {
                mean,
                covariances,
                path_sigma,
                path,
                ..
            } = distribution;
            [mean, covariances, path_sigma, path].map(Vec::len)
        };
        if lengths(&state.distribution) != lengths(distribution) {
            return Err(Error::Lengths);
        }
        self.axes = state.distribution.axes();
        self.state = state;
        self.sample();
        Ok(())
    }
}

#[cfg(test)]
mod tests;
