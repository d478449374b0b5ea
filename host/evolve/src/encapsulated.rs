//! The evolution on board of each robot (section 4.2 of O'Dowd, Studley and Winfield, 2014): a small population of
//! controllers, all re-evaluated in each interval, since the simulator has changed. Mutated copies of the best replace
//! the others.

use oneiro::parameter::{Choice, Choices};
use rand::distr::Distribution;
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

use super::by_fitness;
use super::random::{Chance, Normal, Stream, Uniform, shuffled, stream};

/// The maximum gene; the minimum is 0.
pub const GREATEST: f64 = 0.99;
/// A controller: what it does with food, and without.
pub type Genome = [f32; 2];

/// The rule for a gene that a mutation takes out of 0 to 0.99.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Boundary {
    /// It stays at the bound.
    Clamp,
    /// It is reflected at the bound.
    Reflect,
    /// It wraps around to the other bound.
    Wrap,
    /// The mutation is drawn again until the gene is within.
    Resample,
}

impl Choice for Boundary {
    const CHOICES: Choices<Self> = &[
        ("clamp", Self::Clamp, "a gene stays at the bound"),
        ("reflect", Self::Reflect, "it is reflected from the bound"),
        ("wrap", Self::Wrap, "it enters again at the other bound"),
        ("resample", Self::Resample, "it is drawn again until it is within"),
    ];
}

/// Mutation of a gene by a normal number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mutation {
    /// Its standard deviation.
    pub deviation: f64,
    /// The rule that keeps the gene within the bounds.
    pub boundary: Boundary,
}

impl Mutation {
    /// Mutates a gene.
    pub fn of(self, gene: f32, random: &mut Pcg64) -> f32 {
        let normal = Normal {
            deviation: self.deviation,
        };
        let gene = f64::from(gene);
        let moved = gene + normal.sample(random);
        let period = 2.0 * GREATEST;
        let within = match self.boundary {
            Boundary::Clamp => moved,
            Boundary::Wrap => moved - GREATEST * (moved / GREATEST).floor(),
            Boundary::Reflect => {
                let phase = moved - period * (moved / period).floor();
                if phase > GREATEST { period - phase } else { phase }
            }
            Boundary::Resample => {
                // Half of all draws go towards the farther bound: 10,000 misses do not happen.
                let mut drawn = moved;
                for _ in 0..10_000 {
                    if (0.0..=GREATEST).contains(&drawn) {
                        break;
                    }
                    drawn = gene + normal.sample(random);
                }
                drawn
            }
        };
        kept(within)
    }
}

/// Clamps a gene, and replaces a subnormal one by 0, as kernels require.
fn kept(gene: f64) -> f32 {
    let gene = gene.clamp(0.0, GREATEST) as f32;
    if gene.is_normal() { gene } else { 0.0 }
}

/// Draws a gene, uniform over its whole range.
pub fn any_gene(random: &mut Pcg64) -> f32 {
    let all = Uniform {
        low: 0.0,
        high: GREATEST,
    };
    kept(all.sample(random))
}

/// The population of one robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Controllers {
    genomes: Vec<Genome>,
}

/// Selection and mutation of controllers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Breeding {
    /// The number of best controllers that are kept and copied: 4 of 10 in the paper.
    pub parents: usize,
    /// The chance that a gene of a copy changes: 0.2 in the paper.
    pub rate: f64,
    /// The mutation of such a gene.
    pub mutation: Mutation,
}

impl Breeding {
    /// A copy of a controller, of which each gene may change.
    pub fn mutated(&self, parent: Genome, random: &mut Pcg64) -> Genome {
        let chance = Chance(self.rate);
        parent.map(|gene| {
            if chance.sample(random) {
                self.mutation.of(gene, random)
            } else {
                gene
            }
        })
    }
}

impl Controllers {
    /// Random controllers.
    pub fn new(count: usize, seed: u64) -> Self {
        let mut random = stream(seed, Stream::InitialGenes, 0);
        let genome = |_| [any_gene(&mut random), any_gene(&mut random)];
        Self {
            genomes: (0..count).map(genome).collect(),
        }
    }

    /// All genomes.
    pub fn genomes(&self) -> &[Genome] {
        &self.genomes
    }

    /// Indices from the best to the worst. The order of equals is drawn.
    pub fn ranking(&self, fitness: &[f32], seed: u64, interval: u32) -> Vec<usize> {
        let lots = shuffled(self.genomes.len(), &mut stream(seed, Stream::Ties, interval));
        let mut ranking = lots;
        ranking.sort_by(|&a, &b| by_fitness(fitness[a], fitness[b]));
        ranking
    }

    /// The population of the next interval: the parents stay, and mutated copies of them, of the best first, replace the
    /// others. `guests` replace the last of the copies.
    pub fn bred(&self, ranking: &[usize], breeding: &Breeding, guests: &[Genome], seed: u64, next: u32) -> Self {
        let mut random = stream(seed, Stream::Mutation, next);
        let count = self.genomes.len();
        let parents: Vec<Genome> = ranking[..breeding.parents.min(count)]
            .iter()
            .map(|&index| self.genomes[index])
            .collect();
        let mut genomes = parents.clone();
        for &parent in parents.iter().cycle().take(count - parents.len()) {
            genomes.push(breeding.mutated(parent, &mut random));
        }
        let free = guests.len().min(count - parents.len());
        genomes[count - free..].copy_from_slice(&guests[..free]);
        Self { genomes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLAMPED: Mutation = Mutation {
        deviation: 0.2,
        boundary: Boundary::Clamp,
    };

    fn mutants(gene: f32, mutation: Mutation) -> Vec<f32> {
        let mut random = stream(7, Stream::Mutation, 0);
        (0..20_000).map(|_| mutation.of(gene, &mut random)).collect()
    }

    fn share(genes: &[f32], low: f32, high: f32) -> f64 {
        genes.iter().filter(|gene| (low..high).contains(gene)).count() as f64 / genes.len() as f64
    }

    /// With a deviation of 2 the parent is forgotten where genes wrap, reflect or are drawn again; where they are clamped
    /// most end at the bounds. The shares were computed independently.
    #[test]
    fn a_deviation_of_two_forgets_the_parent() {
        let literal = |boundary| Mutation {
            deviation: 2.0,
            boundary,
        };
        for boundary in [Boundary::Wrap, Boundary::Reflect, Boundary::Resample] {
            for gene in [0.1, 0.9] {
                let mutated = mutants(gene, literal(boundary));
                assert!(mutated.iter().all(|gene| (0.0..=0.99).contains(gene)));
                for (low, high) in [(0.0, 0.33), (0.33, 0.66), (0.66, 1.0)] {
                    let third = share(&mutated, low, high);
                    assert!((third - 1.0 / 3.0).abs() < 0.02, "{boundary:?} of {gene}: {third}");
                }
            }
        }
        let low = mutants(0.165, literal(Boundary::Clamp));
        let high = mutants(0.825, literal(Boundary::Clamp));
        for (genes, bins) in [(&low, [0.53, 0.06, 0.41]), (&high, [0.41, 0.06, 0.53])] {
            for (bin, (from, to)) in bins.iter().zip([(0.0, 0.33), (0.33, 0.66), (0.66, 1.0)]) {
                let found = share(genes, from, to);
                assert!((found - bin).abs() < 0.02, "{found} for {bin}");
            }
        }
    }

    #[test]
    fn small_mutations_stay_near() {
        for boundary in [Boundary::Clamp, Boundary::Reflect, Boundary::Wrap, Boundary::Resample] {
            let mutation = Mutation {
                deviation: 0.02,
                boundary,
            };
            let near = mutants(0.5, mutation);
            assert!(near.iter().all(|gene| (gene - 0.5).abs() < 0.1));
            let deviation = (near.iter().map(|g| f64::from(g - 0.5).powi(2)).sum::<f64>() / 20_000.0).sqrt();
            assert!((deviation - 0.02).abs() < 0.001, "{boundary:?}: {deviation}");
            let bound = mutants(0.99, mutation);
            let at_bound = share(&bound, 0.9899, 1.0);
            let other_end = share(&bound, 0.0, 0.2);
            match boundary {
                Boundary::Clamp => assert!((at_bound - 0.5).abs() < 0.02),
                Boundary::Wrap => assert!((other_end - 0.5).abs() < 0.02),
                Boundary::Reflect | Boundary::Resample => assert!(at_bound < 0.05 && other_end == 0.0),
            }
        }
    }

    #[test]
    fn the_best_overwrite_the_others() {
        let population = Controllers::new(10, 3);
        let fitness: Vec<f32> = (0..10_u8).map(f32::from).collect();
        let ranking = population.ranking(&fitness, 3, 0);
        assert_eq!(ranking, [9, 8, 7, 6, 5, 4, 3, 2, 1, 0]);
        let breeding = |rate| Breeding {
            parents: 4,
            rate,
            mutation: CLAMPED,
        };
        let copies = population.bred(&ranking, &breeding(0.0), &[], 3, 1);
        let from: Vec<Genome> = [9, 8, 7, 6, 9, 8, 7, 6, 9, 8]
            .map(|index| population.genomes[index])
            .into();
        assert_eq!(
            copies.genomes, from,
            "ranks 1 to 4 stay; their copies are those of 1, 2, 3, 4, 1, 2"
        );
        let all = population.bred(&ranking, &breeding(1.0), &[], 3, 1);
        assert_eq!(all.genomes[..4], from[..4]);
        assert!(all.genomes[4..].iter().zip(&from[4..]).all(|(a, b)| a != b));
        let guests = population.bred(&ranking, &breeding(0.2), &[[0.5, 0.25]; 2], 3, 1);
        assert_eq!(guests.genomes[8..], [[0.5, 0.25]; 2]);
        assert_eq!(guests.genomes[..4], from[..4]);
    }

    /// A fifth of the genes of copies change.
    #[test]
    fn the_rate_is_that_of_genes() {
        let breeding = Breeding {
            parents: 4,
            rate: 0.2,
            mutation: CLAMPED,
        };
        let mut population = Controllers {
            genomes: vec![[0.5, 0.5]; 10],
        };
        let mut changed = 0;
        for interval in 0..2000 {
            let ranking: Vec<usize> = (0..10).collect();
            let bred = population.bred(&ranking, &breeding, &[], 11, interval);
            changed += bred.genomes[4..]
                .as_flattened()
                .iter()
                .filter(|gene| **gene != 0.5)
                .count();
            population = Controllers {
                genomes: vec![[0.5, 0.5]; 10],
            };
        }
        let rate = changed as f64 / (2000.0 * 12.0);
        assert!((rate - 0.2).abs() < 0.01, "{rate}");
    }

    #[test]
    fn equals_are_ranked_by_lot() {
        let population = Controllers::new(10, 5);
        let firsts: Vec<usize> = (0..1000)
            .map(|interval| population.ranking(&[1.0; 10], 5, interval)[0])
            .collect();
        for index in 0..10 {
            let count = firsts.iter().filter(|first| **first == index).count();
            assert!((60..150).contains(&count), "{index} is first {count} times of 1000");
        }
        let ranking = population.ranking(&[0.0, f32::NAN, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 5, 0);
        assert_eq!((ranking[0], ranking[9]), (3, 1), "NaN is last");
    }
}
