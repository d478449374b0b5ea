//! Evolution: the genetic algorithm as data-driven operators, asked for a population and told its fitness. It knows
//! nothing of robots, devices or files.

pub(crate) mod encapsulated;
pub(crate) mod random;

use std::cmp::Ordering;

use oneiro::batch::GREATEST_GENE;
use rand::distr::Distribution;
use rand_pcg::Pcg64;

use crate::experiment::settings::{self, MutationKind, MutationUnit};
use random::{Chance, Normal, Stream, Uniform, stream};

/// Genomes of equal length, one after the other.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Population {
    genes: usize,
    values: Vec<f32>,
}

impl Population {
    /// Genomes of `genes` genes each, one after the other; the number of values is a multiple of `genes`.
    pub(crate) fn new(genes: usize, values: Vec<f32>) -> Self {
        debug_assert!(genes > 0 && values.len().is_multiple_of(genes), "whole genomes");
        Self { genes, values }
    }

    /// Genes of a genome.
    pub(crate) fn genes(&self) -> usize {
        self.genes
    }

    /// Individuals.
    pub(crate) fn len(&self) -> usize {
        self.values.len() / self.genes
    }

    /// The genomes in order.
    pub(crate) fn genomes(&self) -> impl Iterator<Item = &[f32]> {
        self.values.chunks_exact(self.genes)
    }

    /// An individual's genome.
    pub(crate) fn genome(&self, individual: usize) -> &[f32] {
        &self.values[individual * self.genes..][..self.genes]
    }

    /// All genes, genome by genome.
    pub(crate) fn values(&self) -> &[f32] {
        &self.values
    }
}

/// The best single score of a run so far, and whose it was.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Champion {
    /// Generation.
    pub(crate) generation: u32,
    /// Index in its generation.
    pub(crate) individual: u32,
    /// Its score.
    pub(crate) fitness: f32,
    /// Its genes.
    pub(crate) genome: Vec<f32>,
}

/// A generation that has lived.
#[derive(Clone, Debug)]
pub(crate) struct Generation {
    /// Its number, from 0.
    pub(crate) number: u32,
    /// Who lived.
    pub(crate) population: Population,
    /// Their scores.
    pub(crate) fitness: Vec<f32>,
    /// Indices from the best to the worst.
    pub(crate) ranking: Vec<u32>,
}

/// One evolution: a function of its settings, its seed and the fitness that it is told.
#[derive(Clone, Debug)]
pub(crate) struct Evolution {
    settings: settings::Evolution,
    seed: u64,
    generation: u32,
    population: Population,
    champion: Option<Champion>,
}

impl Evolution {
    /// Starts from random genes, or from those given: as many individuals as the settings say.
    pub(crate) fn new(settings: &settings::Evolution, seed: u64, genes: usize, init: Option<Population>) -> Self {
        let population = init.unwrap_or_else(|| initial(settings, seed, genes));
        Self::at(settings, seed, 0, population, None)
    }

    /// Goes on where another stopped.
    pub(crate) fn at(
        settings: &settings::Evolution,
        seed: u64,
        generation: u32,
        population: Population,
        champion: Option<Champion>,
    ) -> Self {
        debug_assert_eq!(population.len(), settings.population as usize, "a whole population");
        Self {
            settings: settings.clone(),
            seed,
            generation,
            population,
            champion,
        }
    }

    /// The generation that lives next, or the number of generations when all have lived.
    pub(crate) fn generation(&self) -> u32 {
        self.generation
    }

    /// Whether all generations have lived.
    pub(crate) fn is_finished(&self) -> bool {
        self.generation >= self.settings.generations
    }

    /// Who lives next.
    pub(crate) fn ask(&self) -> &Population {
        &self.population
    }

    /// The best so far; none before the first generation has lived.
    pub(crate) fn champion(&self) -> Option<&Champion> {
        self.champion.as_ref()
    }

    /// Takes the fitness of [`Evolution::ask`]'s individuals, to be maximised, and breeds the next generation from
    /// the best of them.
    pub(crate) fn tell(&mut self, fitness: Vec<f32>) -> Generation {
        let ranking = ranked(&fitness);
        let best = ranking[0] as usize;
        if self
            .champion
            .as_ref()
            .is_none_or(|champion| by_fitness(fitness[best], champion.fitness).is_lt())
        {
            self.champion = Some(Champion {
                generation: self.generation,
                individual: ranking[0],
                fitness: fitness[best],
                genome: self.population.genome(best).to_vec(),
            });
        }
        let next = bred(
            &self.settings,
            self.seed,
            self.generation + 1,
            &self.population,
            &ranking,
        );
        let number = self.generation;
        self.generation += 1;
        Generation {
            number,
            population: std::mem::replace(&mut self.population, next),
            fitness,
            ranking,
        }
    }
}

/// The better first; NaN is worse than every number.
pub(crate) fn by_fitness(a: f32, b: f32) -> Ordering {
    b.partial_cmp(&a).unwrap_or_else(|| a.is_nan().cmp(&b.is_nan()))
}

/// Indices from the best to the worst; of equals, the lower index first.
fn ranked(fitness: &[f32]) -> Vec<u32> {
    let mut ranking: Vec<u32> = (0..fitness.len() as u32).collect();
    ranking.sort_by(|&a, &b| by_fitness(fitness[a as usize], fitness[b as usize]).then(a.cmp(&b)));
    ranking
}

/// Generation 0.
fn initial(settings: &settings::Evolution, seed: u64, genes: usize) -> Population {
    let mut random = stream(seed, Stream::InitialGenes, 0);
    let [low, high] = settings.initial;
    let values = (0..settings.population as usize * genes)
        .map(|_| kept(Uniform { low, high }.sample(&mut random), settings))
        .collect();
    Population::new(genes, values)
}

/// The generation that comes from one: equally many copies of each parent, the best parent's first; all of them
/// mutated but the first copy of each of the elite.
fn bred(settings: &settings::Evolution, seed: u64, generation: u32, from: &Population, ranking: &[u32]) -> Population {
    let mut random = stream(seed, Stream::Mutation, generation);
    let copies = settings.population / settings.parents;
    let mut values = Vec::with_capacity(from.values.len());
    for (rank, &parent) in (0..settings.parents).zip(ranking) {
        for copy in 0..copies {
            let start = values.len();
            values.extend_from_slice(from.genome(parent as usize));
            if copy > 0 || rank >= settings.elite {
                mutate(&mut values[start..], settings, &mut random);
            }
        }
    }
    Population::new(from.genes, values)
}

/// Changes a genome as the settings say.
fn mutate(genome: &mut [f32], settings: &settings::Evolution, random: &mut Pcg64) {
    let mutation = &settings.mutation;
    let chance = Chance(mutation.rate);
    if mutation.per == MutationUnit::Individual && !chance.sample(random) {
        return;
    }
    for gene in genome {
        if mutation.per == MutationUnit::Gene && !chance.sample(random) {
            continue;
        }
        let [low, high] = settings.initial;
        let amount = mutation.amount;
        let changed = match mutation.kind {
            MutationKind::AddUniform => {
                f64::from(*gene)
                    + Uniform {
                        low: -amount,
                        high: amount,
                    }
                    .sample(random)
            }
            MutationKind::AddNormal => f64::from(*gene) + Normal { deviation: amount }.sample(random),
            MutationKind::Replace => Uniform { low, high }.sample(random),
        };
        *gene = kept(changed, settings);
    }
}

/// A gene within the limits, and a number that batches take: not subnormal, and zero with its one sign.
fn kept(gene: f64, settings: &settings::Evolution) -> f32 {
    let [least, greatest] = settings
        .limits
        .unwrap_or([-f64::from(GREATEST_GENE), f64::from(GREATEST_GENE)]);
    let gene = gene.clamp(least, greatest) as f32;
    if gene.is_normal() { gene } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GENES: usize = 18;

    /// A mock evaluator: prefers genes near one half.
    fn fitness(population: &Population) -> Vec<f32> {
        population
            .genomes()
            .map(|genome| -genome.iter().map(|gene| (gene - 0.5) * (gene - 0.5)).sum::<f32>())
            .collect()
    }

    fn settings() -> settings::Evolution {
        settings::Evolution {
            population: 20,
            parents: 4,
            ..Default::default()
        }
    }

    fn hash(population: &Population) -> String {
        let bytes: Vec<u8> = population.values().iter().flat_map(|gene| gene.to_le_bytes()).collect();
        blake3::hash(&bytes).to_hex()[..16].to_owned()
    }

    /// The genes were worked out apart, with integers of any size. Whoever changes one of these changes every run.
    #[test]
    fn generations_0_and_1_have_known_hashes() {
        let mut evolution = Evolution::new(&settings::Evolution::default(), 1, GENES, None);
        assert_eq!(evolution.ask().len(), 100);
        assert_eq!(hash(evolution.ask()), "1dc38cf455d16ca3");
        let generation = evolution.tell(fitness(evolution.ask()));
        assert_eq!(generation.number, 0);
        assert_eq!(hash(evolution.ask()), "3fd97b105ab87124");
    }

    #[test]
    fn fitness_is_maximised_and_rises() {
        let mut evolution = Evolution::new(&settings(), 2, GENES, None);
        let mut bests = Vec::new();
        for _ in 0..100 {
            let generation = evolution.tell(fitness(evolution.ask()));
            bests.push(generation.fitness[generation.ranking[0] as usize]);
        }
        assert!(bests[99] > bests[0] + 3.0, "{} to {}", bests[0], bests[99]);
        let champion = evolution.champion().expect("a champion");
        assert_eq!(champion.fitness, bests.iter().copied().fold(f32::MIN, f32::max));
        assert_eq!(
            fitness(&Population::new(GENES, champion.genome.clone())),
            [champion.fitness]
        );
    }

    #[test]
    fn the_better_rank_first_and_of_equals_the_first() {
        assert_eq!(ranked(&[1.0, 3.0, -0.0, 3.0, 0.0]), [1, 3, 0, 2, 4]);
    }

    /// A NaN has one fate: it ranks last, whatever its sign, and never becomes the champion.
    #[test]
    fn nan_ranks_last() {
        assert_eq!(
            ranked(&[f32::NAN, -1.0, -f32::NAN, f32::NEG_INFINITY, 2.0]),
            [4, 1, 3, 0, 2]
        );
        let mut evolution = Evolution::new(&settings(), 3, GENES, None);
        let mut scores = vec![f32::NAN; 20];
        evolution.tell(scores.clone());
        assert!(evolution.champion().is_some_and(|champion| champion.fitness.is_nan()));
        scores[7] = -5.0;
        evolution.tell(scores);
        assert!(
            evolution
                .champion()
                .is_some_and(|champion| champion.fitness == -5.0 && champion.individual == 7)
        );
        evolution.tell(vec![f32::NAN; 20]);
        assert!(evolution.champion().is_some_and(|champion| champion.generation == 1));
    }

    #[test]
    fn each_parent_makes_its_copies() {
        let unmutated = settings::Mutation {
            rate: 0.0,
            ..Default::default()
        };
        let mut evolution = Evolution::new(
            &settings::Evolution {
                mutation: unmutated,
                ..settings()
            },
            4,
            GENES,
            None,
        );
        let generation = evolution.tell((0..20_u8).map(f32::from).collect());
        for (index, genome) in evolution.ask().genomes().enumerate() {
            assert_eq!(genome, generation.population.genome(19 - index / 5));
        }
    }

    #[test]
    fn the_elite_stays_as_it_is() {
        let settings = settings::Evolution {
            elite: 2,
            mutation: settings::Mutation {
                rate: 1.0,
                ..Default::default()
            },
            ..settings()
        };
        let mut evolution = Evolution::new(&settings, 5, GENES, None);
        let generation = evolution.tell((0..20_u8).map(f32::from).collect());
        let is_copy = |index: usize, parent| evolution.ask().genome(index) == generation.population.genome(parent);
        assert!(is_copy(0, 19) && is_copy(5, 18));
        assert!(!is_copy(1, 19) && !is_copy(10, 17));
    }

    /// The share of genes that change, by how much, and how changes fall on individuals.
    #[test]
    fn mutations_are_those_asked_for() {
        for (kind, per) in [
            (MutationKind::AddUniform, MutationUnit::Gene),
            (MutationKind::AddNormal, MutationUnit::Gene),
            (MutationKind::Replace, MutationUnit::Gene),
            (MutationKind::AddUniform, MutationUnit::Individual),
        ] {
            let settings = settings::Evolution {
                population: 2000,
                parents: 1,
                initial: [2.0, 3.0],
                mutation: settings::Mutation {
                    kind,
                    rate: 0.25,
                    per,
                    amount: 0.5,
                },
                ..Default::default()
            };
            let mut evolution = Evolution::new(&settings, 6, GENES, None);
            let generation = evolution.tell((0..2000_u16).map(|index| -f32::from(index)).collect());
            let parent = generation.population.genome(0);
            let mut changes = Vec::new();
            let mut touched = 0;
            for genome in evolution.ask().genomes() {
                let before = changes.len();
                changes.extend(
                    genome
                        .iter()
                        .zip(parent)
                        .filter(|(a, b)| a != b)
                        .map(|(a, b)| f64::from(a - b)),
                );
                touched += usize::from(changes.len() > before);
                assert!(per == MutationUnit::Gene || [before, before + GENES].contains(&changes.len()));
                assert!(kind != MutationKind::Replace || genome.iter().all(|gene| (2.0..=3.0).contains(gene)));
            }
            let share = changes.len() as f64 / (2000 * GENES) as f64;
            assert!((share - 0.25).abs() < 0.03, "{kind:?}: {share}");
            let individuals = f64::from(touched as u32) / 2000.0;
            let expected = if per == MutationUnit::Gene {
                1.0 - 0.75_f64.powi(18)
            } else {
                0.25
            };
            assert!((individuals - expected).abs() < 0.03, "{individuals}");
            let deviation = (changes.iter().map(|x| x * x).sum::<f64>() / changes.len() as f64).sqrt();
            match kind {
                MutationKind::AddUniform => assert!((deviation - 0.5 / 3.0_f64.sqrt()).abs() < 0.01, "{deviation}"),
                MutationKind::AddNormal => assert!((deviation - 0.5).abs() < 0.02, "{deviation}"),
                MutationKind::Replace => assert!(deviation > 0.28, "{deviation}"),
            }
        }
    }

    #[test]
    fn genes_stay_within_limits_and_normal() {
        let limited = settings::Evolution {
            limits: Some([-0.5, 0.25]),
            ..settings()
        };
        let mut evolution = Evolution::new(&limited, 7, GENES, None);
        for _ in 0..5 {
            assert!(evolution.ask().values().iter().all(|gene| (-0.5..=0.25).contains(gene)));
            evolution.tell(fitness(evolution.ask()));
        }
        assert_eq!(kept(1e9, &settings()), GREATEST_GENE);
        assert_eq!(kept(1e-40, &settings()).to_bits(), 0);
        assert_eq!(kept(-1e-60, &settings()).to_bits(), 0);
    }

    #[test]
    fn an_evolution_goes_on_from_where_it_stopped() {
        let mut whole = Evolution::new(&settings(), 8, GENES, None);
        for _ in 0..3 {
            whole.tell(fitness(whole.ask()));
        }
        let mut resumed = Evolution::at(
            &settings(),
            8,
            whole.generation(),
            whole.ask().clone(),
            whole.champion().cloned(),
        );
        whole.tell(fitness(whole.ask()));
        resumed.tell(fitness(resumed.ask()));
        assert_eq!(whole.ask(), resumed.ask());
        assert_eq!(whole.champion(), resumed.champion());
        assert_eq!(whole.generation(), 4);
    }
}
