//! MAP-Elites (Mouret and Clune, "Illuminating search spaces by mapping elites", arXiv 1504.04909, 2015): an archive of cells keeps the
//! best genome of each kind of behaviour. Cells are a grid, or the regions nearest to centroids (Vassiliades, Chatzilygeroudis and
//! Mouret, "Using centroidal Voronoi tessellations to scale up the multidimensional archive of phenotypic elites algorithm", IEEE
//! Transactions on Evolutionary Computation 22(4), 2018). Children are varied along the line between two elites (Vassiliades and
//! Mouret, "Discovering the elite hypervolume by leveraging interspecies correlation", GECCO 2018).

mod values;

use std::collections::BTreeMap;

use crate::error::{Error, Result};
use rand::Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::random::{Normal, Stream, below, shuffled, stream, unit};
use super::registry::Entry;
use super::settings::{Descriptor, Feature, GivenGenomes, Ranges, Settings, Space};
use super::{Champion, Finalists, Optimizer, Population, saved};
use values::Cells as Kind;
pub use values::{Acceptance, Values};

const NAME: &str = "map-elites";
const VERSION: u32 = 1;

pub(crate) const ENTRY: Entry = Entry {
    features: &[Feature::Behaviour, Feature::Archive],
    start: GivenGenomes::First("variations of them"),
    check: values::check,
    needs: values::needs,
    ..Entry::new(
        [
            NAME,
            "an archive of the best of each kind of behaviour: Mouret and Clune 2015",
            "to see which behaviours are possible, and when the best is reached by detours",
        ],
        |beginning| {
            Box::new(MapElites::new(
                beginning.settings,
                beginning.seed,
                &beginning.ranges(),
                beginning.init,
            ))
        },
    )
};

/// The best genome of a cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Elite {
    /// By which it is compared: its score, or the mean of all its scores.
    pub fitness: f64,
    /// Its behaviour, or the mean of all.
    pub behaviour: Vec<f64>,
    /// How often it was evaluated.
    pub evaluations: u32,
    /// Where it was evaluated with this score.
    pub generation: u32,
    pub individual: u32,
    pub score: f32,
    pub genome: Vec<f32>,
}

/// Elites by the numbers of their cells.
#[derive(Clone, Debug)]
pub struct Archive {
    cells: Cells,
    elites: BTreeMap<u32, Elite>,
}

/// Which cell a behaviour belongs to.
#[derive(Clone, Debug)]
enum Cells {
    Grid(Vec<Descriptor>),
    /// Centroids, one after the other, as fractions of the descriptors' ranges.
    Centroids(Vec<Descriptor>, Vec<f64>),
}

impl Cells {
    fn new(settings: &Settings) -> Self {
        let descriptors = settings.descriptors.clone();
        match settings.tables.archive.cells {
            Kind::Grid => Self::Grid(descriptors),
            Kind::Centroidal => {
                let centroids = centroids(descriptors.len(), settings.tables.archive.centroids as usize);
                Self::Centroids(descriptors, centroids)
            }
        }
    }

    fn count(&self) -> usize {
        match self {
            Self::Grid(descriptors) => descriptors.iter().map(|descriptor| descriptor.cells as usize).product(),
            Self::Centroids(descriptors, centroids) => centroids.len() / descriptors.len(),
        }
    }

    /// The number of a behaviour's cell: of a grid, the last descriptor counts fastest. None of a NaN. Behaviour outside of the
    /// ranges belongs to the cells at their ends.
    fn of(&self, behaviour: &[f64]) -> Option<u32> {
        if behaviour.iter().any(|value| value.is_nan()) {
            return None;
        }
        Some(match self {
            Self::Grid(descriptors) => descriptors.iter().zip(behaviour).fold(0, |cell, (descriptor, &value)| {
                let place = (f64::from(descriptor.cells) * descriptor.share(value)).floor();
                cell * descriptor.cells + place.clamp(0.0, f64::from(descriptor.cells - 1)) as u32
            }),
            Self::Centroids(descriptors, centroids) => {
                let shares = descriptors
                    .iter()
                    .zip(behaviour)
                    .map(|(descriptor, &value)| descriptor.share(value).clamp(0.0, 1.0));
                nearest(&shares.collect::<Vec<_>>(), centroids) as u32
            }
        })
    }
}

/// The nearest of some points to a place; of equals the first.
fn nearest(place: &[f64], points: &[f64]) -> usize {
    let mut best = (f64::INFINITY, 0);
    for (index, point) in points.chunks_exact(place.len()).enumerate() {
        let square: f64 = place.iter().zip(point).map(|(a, b)| (a - b) * (a - b)).sum();
        if square < best.0 {
            best = (square, index);
        }
    }
    best.1
}

/// Centroids that divide a cube evenly: means of the samples nearest to each, found again and again (Lloyd's algorithm). They are
/// the same for all seeds, so that archives of several runs have the same cells.
fn centroids(dimensions: usize, count: usize) -> Vec<f64> {
    const SAMPLES: usize = 20;
    const ROUNDS: usize = 30;
    let mut random = stream(0, Stream::Centroids, count as u32);
    let samples: Vec<f64> = (0..SAMPLES * count * dimensions).map(|_| unit(&mut random)).collect();
    let mut centroids = samples[..count * dimensions].to_vec();
    for _ in 0..ROUNDS {
        let mut sums = vec![0.0; count * dimensions];
        let mut counts = vec![0.0_f64; count];
        for sample in samples.chunks_exact(dimensions) {
            let nearest_one = nearest(sample, &centroids);
            counts[nearest_one] += 1.0;
            for (sum, value) in sums[nearest_one * dimensions..].iter_mut().zip(sample) {
                *sum += value;
            }
        }
        for (cell, count) in counts.iter().enumerate().filter(|(_, count)| **count > 0.0) {
            for place in cell * dimensions..(cell + 1) * dimensions {
                centroids[place] = sums[place] / count;
            }
        }
    }
    centroids
}

/// Centroids of an archive's cells, one after the other, as fractions of the descriptors' ranges; `None`: cells are a grid.
pub fn centroids_of(settings: &Settings) -> Option<Vec<f64>> {
    match Cells::new(settings) {
        Cells::Grid(_) => None,
        Cells::Centroids(_, centroids) => Some(centroids),
    }
}

impl Archive {
    /// Elites with the numbers of their cells, in their order.
    pub fn elites(&self) -> impl Iterator<Item = (u32, &Elite)> {
        self.elites.iter().map(|(cell, elite)| (*cell, elite))
    }

    /// Cells.
    pub fn cells(&self) -> usize {
        self.cells.count()
    }

    /// The fraction of all cells that have an elite.
    pub fn coverage(&self) -> f64 {
        self.elites.len() as f64 / self.cells() as f64
    }

    /// The sum of what the elites' fitness is above `offset`.
    pub fn quality(&self, offset: f64) -> f64 {
        // The sum of nothing would be minus zero.
        self.elites
            .values()
            .fold(0.0, |sum, elite| sum + (elite.fitness - offset))
    }

    /// Puts a genome into its cell if that is empty or its elite is worse; of equals, the older one stays.
    fn add(&mut self, elite: Elite) {
        let Some(cell) = self.cells.of(&elite.behaviour).filter(|_| !elite.fitness.is_nan()) else {
            return;
        };
        let is_better = |there: &Elite| elite.fitness > there.fitness;
        if self.elites.get(&cell).is_none_or(is_better) {
            self.elites.insert(cell, elite);
        }
    }
}

/// The algorithm at one generation.
#[derive(Clone, Debug)]
struct MapElites {
    owner: saved::Owner,
    size: u32,
    values: Values,
    seed: u64,
    space: Space,
    generation: u32,
    archive: Archive,
    /// Cells of the elites that are evaluated again, the first individuals of the generation.
    again: Vec<u32>,
    population: Population,
}

impl MapElites {
    fn new(settings: &Settings, seed: u64, ranges: &Ranges, init: Option<Population>) -> Self {
        let space = Space::new(settings, ranges);
        let mut map_elites = Self {
            owner: saved::Owner::new(settings, seed, ranges),
            size: settings.population,
            values: settings.tables.archive.clone(),
            seed,
            population: Population::new(space.len(), Vec::new()),
            space,
            generation: 0,
            archive: Archive {
                cells: Cells::new(settings),
                elites: BTreeMap::new(),
            },
            again: Vec::new(),
        };
        map_elites.breed();
        if let Some(init) = init {
            map_elites.population = map_elites.filled(&init);
        }
        map_elites
    }

    /// Given genomes, and variations of them up to a whole population.
    fn filled(&self, given: &Population) -> Population {
        let parents: Vec<&[f32]> = given.genomes().collect();
        let mut values = given.values().to_vec();
        let mut random = stream(self.seed, Stream::Selection, self.generation);
        values.extend(self.varied(&parents, self.size as usize - given.len(), &mut random));
        Population::new(given.genes(), values)
    }

    /// Makes the generation's genomes: elites that are evaluated again, then children.
    fn breed(&mut self) {
        let filled: Vec<u32> = self.archive.elites.keys().copied().collect();
        if filled.is_empty() {
            let mut random = stream(self.seed, Stream::InitialGenes, self.generation);
            self.again.clear();
            self.population = Population::new(self.space.len(), self.space.drawn(self.size, &mut random));
            return;
        }
        let mut random = stream(self.seed, Stream::Selection, self.generation);
        let order = shuffled(filled.len(), &mut random);
        let again = (self.values.reevaluated as usize).min(filled.len());
        self.again = order[..again].iter().map(|&place| filled[place]).collect();
        let genome = |cell: &u32| &self.archive.elites[cell].genome[..];
        let mut values: Vec<f32> = self.again.iter().flat_map(genome).copied().collect();
        let parents: Vec<&[f32]> = filled.iter().map(genome).collect();
        values.extend(self.varied(&parents, self.size as usize - again, &mut random));
        self.population = Population::new(self.space.len(), values);
    }

    /// Children of genomes, one after the other.
    fn varied(&self, genomes: &[&[f32]], children: usize, mut random: &mut impl Rng) -> Vec<f32> {
        let genes = self.space.len();
        let mut values = vec![0.0; children * genes];
        // Children's random numbers, in order: their parents, then their normal numbers, starting with that along the
        // line.
        let mut drawn = Vec::with_capacity(children * (1 + genes));
        let parent = |random: &mut _| genomes[below(genomes.len(), random)];
        let parents: Vec<_> = (0..children)
            .map(|_| {
                let parents = [(); 2].map(|()| parent(&mut random));
                drawn.extend((0..=genes).map(|_| Normal::drawn(&mut random)));
                parents
            })
            .collect();
        let normal = Normal { deviation: 1.0 };
        let (space, spread) = (&self.space, &self.values);
        values
            .par_chunks_exact_mut(genes)
            .zip(parents.par_iter().zip(drawn.par_chunks_exact(1 + genes)))
            .for_each(|(child, ([first, second], drawn))| {
                let along = spread.line * normal.of(drawn[0]);
                for (gene, value) in child.iter_mut().enumerate() {
                    let (first, second) = (f64::from(first[gene]), f64::from(second[gene]));
                    let apart = spread.iso * space.half(gene) * normal.of(drawn[1 + gene]);
                    *value = space.kept(gene, first + apart + along * (second - first));
                }
            });
        values
    }

    /// Takes what elites did that were evaluated again, and then the others.
    fn place(&mut self, fitness: &[f32], behaviour: &[f64]) {
        let dimensions = behaviour.len() / fitness.len();
        let (archive, population, generation) = (&mut self.archive, &self.population, self.generation);
        let lived = |individual: usize| Elite {
            fitness: fitness[individual].into(),
            behaviour: behaviour[individual * dimensions..][..dimensions].to_vec(),
            evaluations: 1,
            generation,
            individual: individual as u32,
            score: fitness[individual],
            genome: population.genome(individual).to_vec(),
        };
        let mut moved = Vec::new();
        for (individual, cell) in self.again.iter().enumerate() {
            let (Some(before), now) = (archive.elites.remove(cell), lived(individual)) else {
                continue;
            };
            moved.push(self.values.acceptance.joined(before, now));
        }
        let others = (self.again.len()..fitness.len()).map(lived);
        for elite in moved.into_iter().chain(others) {
            archive.add(elite);
        }
    }
}

impl Acceptance {
    /// An elite after another evaluation.
    fn joined(self, before: Elite, now: Elite) -> Elite {
        let evaluations = before.evaluations.saturating_add(1);
        match self {
            Self::Optimistic => Elite {
                evaluations,
                ..if now.fitness > before.fitness { now } else { before }
            },
            Self::Mean => {
                let count = f64::from(evaluations);
                let mean = |before: f64, now: f64| before + (now - before) / count;
                let behaviours = before.behaviour.iter().zip(&now.behaviour);
                Elite {
                    fitness: mean(before.fitness, now.fitness),
                    behaviour: behaviours.map(|(before, now)| mean(*before, *now)).collect(),
                    evaluations,
                    ..before
                }
            }
        }
    }
}

impl Optimizer for MapElites {
    fn name(&self) -> &'static str {
        NAME
    }

    fn generation(&self) -> u32 {
        self.generation
    }

    fn ask(&self) -> &Population {
        &self.population
    }

    fn descriptors(&self) -> usize {
        match &self.archive.cells {
            Cells::Grid(all) | Cells::Centroids(all, _) => all.len(),
        }
    }

    fn archive(&self) -> Option<&Archive> {
        Some(&self.archive)
    }

    /// The best elites.
    fn finalists<'a>(&'a self, luckiest: &'a Champion, _: &'a [f32], _: &'a [f32]) -> Finalists<'a> {
        let mut elites: Vec<&Elite> = self.archive.elites.values().collect();
        // Of equals, the first cell first.
        elites.sort_by(|a, b| b.fitness.total_cmp(&a.fitness));
        let others = elites.into_iter().map(|elite| Champion {
            generation: elite.generation,
            individual: elite.individual,
            fitness: elite.score,
            genome: elite.genome.clone(),
        });
        Box::new(others.filter(|champion| !champion.is_individual(luckiest)))
    }

    fn advance(&mut self, fitness: &[f32], _: &[u32], behaviour: &[f64]) -> Population {
        self.place(fitness, behaviour);
        let evaluated = self.population.clone();
        self.generation += 1;
        self.breed();
        evaluated
    }

    fn set_generations(&mut self, generations: u32) {
        self.owner.set_generations(generations);
    }

    fn save(&self) -> Vec<u8> {
        // A population that a file gave is not bred again.
        let first = (self.generation == 0).then(|| self.population.values());
        saved::seal(
            NAME,
            VERSION,
            &self.owner,
            &(self.generation, &self.archive.elites, first),
        )
    }

    fn restore(&mut self, bytes: &[u8]) -> Result {
        type State = (u32, BTreeMap<u32, Elite>, Option<Vec<f32>>);
        let (generation, elites, first): State = saved::open(NAME, VERSION, &self.owner, bytes)?;
        let (genes, dimensions) = (self.space.len(), self.descriptors());
        let is_own = |elite: &Elite| elite.genome.len() == genes && elite.behaviour.len() == dimensions;
        let length = first.as_ref().map_or(genes * self.size as usize, Vec::len);
        if !elites.values().all(is_own) || length != genes * self.size as usize {
            return Err(Error::Lengths);
        }
        self.generation = generation;
        self.archive.elites = elites;
        self.breed();
        if let Some(values) = first {
            self.population = Population::new(genes, values);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
