//! The genetic algorithm of Miglino, Lund and Nolfi (1995): the best are copied, each equally often, and the copies
//! mutated.

use oneiro::batch::GREATEST_GENE;
use oneiro::parameter::{Choice, Choices};
use rand::Rng;
use rand::distr::Distribution;
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

use super::random::{Chance, Normal, Stream, Uniform, stream, unit, unit_of};
use super::{Generation, Optimizer, Population, ranked};
use crate::exit::{Failure, Result};
use crate::sealed;

/// The algorithm's name, and the version of its saved states.
const NAME: &str = "genetic";
const VERSION: u32 = 1;

/// The table `[evolution]` of an experiment: the algorithm, and for how many generations it runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Settings {
    /// Individuals.
    pub(crate) population: u32,
    /// How many of the best are copied, each equally often.
    pub(crate) parents: u32,
    /// Generations that are evaluated.
    pub(crate) generations: u32,
    /// How many of the best also keep one copy without mutation.
    pub(crate) elite: u32,
    /// Range of the uniform initial genes.
    pub(crate) initial: [f64; 2],
    /// A file of initial genes instead.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) init: Option<String>,
    /// Range that genes are kept within.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) limits: Option<[f64; 2]>,
    /// Mutation of copies.
    pub(crate) mutation: Mutation,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            population: 100,
            parents: 20,
            generations: 200,
            elite: 0,
            initial: [-1.0, 1.0],
            init: None,
            limits: None,
            mutation: Mutation::default(),
        }
    }
}

/// Mutation of copies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Mutation {
    /// The change of a gene.
    pub(crate) kind: MutationKind,
    /// The chance of a change.
    pub(crate) rate: f64,
    /// Whether the chance is drawn for each gene or each individual.
    pub(crate) per: MutationUnit,
    /// Size of the change.
    pub(crate) amount: f64,
}

impl Default for Mutation {
    fn default() -> Self {
        Self {
            kind: MutationKind::AddUniform,
            rate: 0.25,
            per: MutationUnit::Gene,
            amount: 1.0,
        }
    }
}

/// A kind of mutation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum MutationKind {
    AddUniform,
    AddNormal,
    Replace,
}

impl Choice for MutationKind {
    const CHOICES: Choices<Self> = &[
        (
            "add_uniform",
            Self::AddUniform,
            "adds a uniform number between minus and plus the amount",
        ),
        (
            "add_normal",
            Self::AddNormal,
            "adds a normal number with the amount as its standard deviation",
        ),
        ("replace", Self::Replace, "draws the gene again from the initial range"),
    ];
}

/// The unit that the chance of mutation is drawn for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum MutationUnit {
    Gene,
    Individual,
}

impl Choice for MutationUnit {
    const CHOICES: Choices<Self> = &[
        ("gene", Self::Gene, "each gene by itself"),
        (
            "individual",
            Self::Individual,
            "each individual: all its genes change, or none",
        ),
    ];
}

/// The range of each gene that has one of its own. It replaces the initial range and the limits, and the amount of a mutation
/// is as large in it as in the initial range.
type Ranges = Vec<Option<[f32; 2]>>;

/// The algorithm at one generation: a function of its settings, its seed and the fitness reported to it.
#[derive(Clone, Debug)]
pub(crate) struct Genetic {
    settings: Settings,
    seed: u64,
    generation: u32,
    ranges: Ranges,
    population: Population,
}

impl Genetic {
    /// Starts from random genes, one for each of `ranges`, or from those given: as many individuals as the settings say.
    pub(crate) fn new(settings: &Settings, seed: u64, ranges: Ranges, init: Option<Population>) -> Self {
        let population = init.unwrap_or_else(|| initial(settings, seed, &ranges));
        Self {
            ranges,
            ..Self::at(settings, seed, 0, population)
        }
    }

    /// Starts from a generation of this number, of genes without ranges of their own.
    pub(crate) fn at(settings: &Settings, seed: u64, generation: u32, population: Population) -> Self {
        debug_assert_eq!(population.len(), settings.population as usize, "a whole population");
        Self {
            settings: settings.clone(),
            seed,
            generation,
            ranges: vec![None; population.genes()],
            population,
        }
    }

    /// Hash of everything that decides its results besides fitness.
    fn owner(&self) -> blake3::Hash {
        let settings = (&self.settings, self.seed, self.population.genes());
        let mut decisive = serde_json::to_vec(&settings).expect("settings are numbers and words");
        if self.ranges.iter().any(Option::is_some) {
            decisive.extend(serde_json::to_vec(&self.ranges).expect("ranges are numbers"));
        }
        blake3::hash(&decisive)
    }

    /// Breeds the next generation: equally many copies of each parent, the best parent's first, all of them mutated but the
    /// first copy of each of the elite.
    fn bred(&self, ranking: &[u32]) -> Population {
        let mut random = stream(self.seed, Stream::Mutation, self.generation + 1);
        let Settings {
            population,
            parents,
            elite,
            ..
        } = self.settings;
        let copies = (population / parents) as usize;
        let genes = self.population.genes;
        let mut values = Vec::with_capacity(self.population.values.len());
        for &parent in &ranking[..parents as usize] {
            for _ in 0..copies {
                values.extend_from_slice(self.population.genome(parent as usize));
            }
        }
        let changes: Vec<Change> = self
            .ranges
            .iter()
            .map(|&range| Change::of(&self.settings, range))
            .collect();
        let (of_elite, others) = values.split_at_mut(elite as usize * copies * genes);
        for family in of_elite.chunks_exact_mut(copies * genes) {
            self.mutate(&mut family[genes..], &changes, &mut random);
        }
        self.mutate(others, &changes, &mut random);
        Population::new(genes, values)
    }

    /// Mutates genomes as the settings say; `changes` are those of a genome's genes.
    fn mutate(&self, genomes: &mut [f32], changes: &[Change], random: &mut Pcg64) {
        let Mutation { rate, per, kind, .. } = self.settings.mutation;
        let chance = Chance(rate);
        match (per, kind) {
            (MutationUnit::Gene, MutationKind::AddUniform | MutationKind::Replace) => {
                mutate_each(genomes, changes, chance, random);
            }
            (MutationUnit::Gene, MutationKind::AddNormal) => {
                for (gene, change) in genomes.iter_mut().zip(changes.iter().cycle()) {
                    if chance.sample(random) {
                        *gene = change.drawn(*gene, random);
                    }
                }
            }
            (MutationUnit::Individual, _) => {
                for genome in genomes.chunks_exact_mut(changes.len()) {
                    if chance.sample(random) {
                        for (gene, change) in genome.iter_mut().zip(changes) {
                            *gene = change.drawn(*gene, random);
                        }
                    }
                }
            }
        }
    }
}

/// Changes each gene of genomes by this chance, with one random word for the chance and one for the change.
///
/// No processor predicts which genes change, and each that it mispredicts costs as much as some twenty that it doesn't. So
/// words are drawn first without a branch on them, noting which ones say yes, and then only the genes are visited that change.
fn mutate_each(genomes: &mut [f32], changes: &[Change], chance: Chance, random: &mut Pcg64) {
    /// Genes at a time: their words stay in the processor's nearest memory.
    const PIECE: usize = 512;
    let bound = chance.bound();
    // What most experiments have: no division to find a gene's own.
    let is_one = changes.iter().all(|change| *change == changes[0]);
    let mut words = [0_u64; 2 * PIECE];
    // Places of the words that said yes.
    let mut said = [0_u16; 2 * PIECE];
    for (number, piece) in genomes.chunks_mut(PIECE).enumerate() {
        let (mut drawn, mut yes, mut is_yes) = (0, 0, 0);
        while drawn - yes < piece.len() {
            let word = random.next_u64();
            words[drawn] = word;
            said[yes] = drawn as u16;
            // 1 if the word is below the bound, by the sign of the difference: a comparison might be compiled to a branch. The word
            // after a yes is the change.
            is_yes = ((word >> 11).wrapping_sub(bound) >> 63) as usize & !is_yes;
            yes += is_yes;
            drawn += 1;
        }
        for (before, &place) in said[..yes].iter().enumerate() {
            // Each change before it took a word more.
            let index = usize::from(place) - before;
            let own = if is_one {
                0
            } else {
                (number * PIECE + index) % changes.len()
            };
            piece[index] = changes[own].at(piece[index], unit_of(words[usize::from(place) + 1]));
        }
    }
}

/// How a gene changes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Change {
    kind: MutationKind,
    /// Initial range.
    initial: [f64; 2],
    amount: f64,
    /// The least and the greatest that it may become.
    bounds: [f64; 2],
}

impl Change {
    /// The change of a gene, with the range of its own if it has one.
    fn of(settings: &Settings, own: Option<[f32; 2]>) -> Self {
        let mutation = &settings.mutation;
        let initial = initial_range(settings, own);
        let amount = match own {
            Some(_) => mutation.amount * (initial[1] - initial[0]) / (settings.initial[1] - settings.initial[0]),
            None => mutation.amount,
        };
        Self {
            kind: mutation.kind,
            initial,
            amount,
            bounds: bounds(settings, own),
        }
    }

    /// The changed gene.
    fn drawn(&self, gene: f32, random: &mut Pcg64) -> f32 {
        match self.kind {
            MutationKind::AddNormal => {
                let normal = Normal { deviation: self.amount };
                kept(f64::from(gene) + normal.sample(random), self.bounds)
            }
            MutationKind::AddUniform | MutationKind::Replace => self.at(gene, unit(random)),
        }
    }

    /// The changed gene, if a uniform number decides: that at a share of its range.
    fn at(&self, gene: f32, share: f64) -> f32 {
        let [low, high] = match self.kind {
            MutationKind::Replace => self.initial,
            _ => [-self.amount, self.amount],
        };
        let drawn = Uniform { low, high }.at(share);
        let changed = match self.kind {
            MutationKind::Replace => drawn,
            _ => f64::from(gene) + drawn,
        };
        kept(changed, self.bounds)
    }
}

impl Optimizer for Genetic {
    fn name(&self) -> &'static str {
        NAME
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn generation(&self) -> u32 {
        self.generation
    }

    fn ask(&self) -> &Population {
        &self.population
    }

    fn tell(&mut self, fitness: Vec<f32>) -> Result<Generation> {
        if fitness.len() != self.population.len() {
            return Err(Failure::failed(format_args!(
                "generation {}: {} scores for {} individuals; allowed: one for each",
                self.generation,
                fitness.len(),
                self.population.len()
            )));
        }
        let ranking = ranked(&fitness);
        let next = self.bred(&ranking);
        let number = self.generation;
        self.generation += 1;
        Ok(Generation {
            number,
            population: std::mem::replace(&mut self.population, next),
            fitness,
            ranking,
        })
    }

    fn save(&self) -> Vec<u8> {
        let state = (self.generation, &self.population.values);
        sealed::seal(NAME, VERSION, &self.owner(), &state)
    }

    fn restore(&mut self, saved: &[u8]) -> Result {
        let (generation, values): (u32, Vec<f32>) = sealed::open(NAME, VERSION, &self.owner(), saved)
            .map_err(|problem| Failure::corrupt(format_args!("the saved state of the optimiser {problem}")))?;
        if values.len() != self.population.values.len() {
            return Err(Failure::corrupt(
                "the saved state of the optimiser has another population",
            ));
        }
        self.generation = generation;
        self.population.values = values;
        Ok(())
    }
}

/// Generation 0.
fn initial(settings: &Settings, seed: u64, ranges: &[Option<[f32; 2]>]) -> Population {
    let mut random = stream(seed, Stream::InitialGenes, 0);
    let genomes = (0..settings.population).flat_map(|_| ranges);
    let values = genomes
        .map(|&range| {
            let [low, high] = initial_range(settings, range);
            kept(Uniform { low, high }.sample(&mut random), bounds(settings, range))
        })
        .collect();
    Population::new(ranges.len(), values)
}

/// The range of a gene's initial values.
fn initial_range(settings: &Settings, own: Option<[f32; 2]>) -> [f64; 2] {
    own.map_or(settings.initial, |range| range.map(f64::from))
}

/// The least and the greatest value of a gene: those of its range or the limits.
fn bounds(settings: &Settings, own: Option<[f32; 2]>) -> [f64; 2] {
    own.map(|range| range.map(f64::from))
        .or(settings.limits)
        .unwrap_or([-f64::from(GREATEST_GENE), f64::from(GREATEST_GENE)])
}

/// Clamps a gene to its bounds, and replaces a subnormal one by +0, as batches require.
fn kept(gene: f64, [least, greatest]: [f64; 2]) -> f32 {
    let gene = gene.clamp(least, greatest) as f32;
    if gene.is_normal() { gene } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::super::tests::fitness;
    use super::*;

    const GENES: usize = 18;

    fn settings() -> Settings {
        Settings {
            population: 20,
            parents: 4,
            ..Default::default()
        }
    }

    fn hash(population: &Population) -> String {
        let bytes: Vec<u8> = population.values().iter().flat_map(|gene| gene.to_le_bytes()).collect();
        blake3::hash(&bytes).to_hex()[..16].to_owned()
    }

    /// The genes were computed independently, with big integers. A change here changes every run.
    #[test]
    fn generations_0_and_1_have_known_hashes() {
        let mut evolution = Genetic::new(&Settings::default(), 1, vec![None; GENES], None);
        assert_eq!(evolution.ask().len(), 100);
        assert_eq!(hash(evolution.ask()), "1dc38cf455d16ca3");
        let generation = evolution.tell(fitness(evolution.ask())).unwrap();
        assert_eq!(generation.number, 0);
        assert_eq!(hash(evolution.ask()), "3fd97b105ab87124");
    }

    #[test]
    fn each_parent_makes_its_copies() {
        let unmutated = Mutation {
            rate: 0.0,
            ..Default::default()
        };
        let mut evolution = Genetic::new(
            &Settings {
                mutation: unmutated,
                ..settings()
            },
            4,
            vec![None; GENES],
            None,
        );
        let generation = evolution.tell((0..20_u8).map(f32::from).collect()).unwrap();
        for (index, genome) in evolution.ask().genomes().enumerate() {
            assert_eq!(genome, generation.population.genome(19 - index / 5));
        }
    }

    /// Genes that change one after the other, as the definition says.
    fn changed_one_by_one(genes: &mut [f32], changes: &[Change], chance: Chance, random: &mut Pcg64) {
        for (gene, change) in genes.iter_mut().zip(changes.iter().cycle()) {
            if chance.sample(random) {
                *gene = change.drawn(*gene, random);
            }
        }
    }

    /// The words that are drawn in advance change the same genes in the same way, and leave the generator where one by one does.
    #[test]
    fn genes_change_as_one_by_one() {
        let own: Ranges = vec![None, Some([10.0, 18.0]), None, Some([-1.0, 0.5]), None];
        for kind in [MutationKind::AddUniform, MutationKind::Replace] {
            for rate in [0.0, 1e-12, 0.01, 0.25, 0.5, 0.999, 1.0] {
                let mut settings = settings();
                (settings.mutation.kind, settings.mutation.rate) = (kind, rate);
                for ranges in [&vec![None; 5], &own] {
                    let changes: Vec<Change> = ranges.iter().map(|&range| Change::of(&settings, range)).collect();
                    for count in [0, 5, 510, 515, 2560] {
                        let (mut random, mut other) = (stream(9, Stream::Mutation, 1), stream(9, Stream::Mutation, 1));
                        let mut genes: Vec<f32> = (0..count).map(|gene| 0.01 * f32::from(gene as u16)).collect();
                        let mut expected = genes.clone();
                        mutate_each(&mut genes, &changes, Chance(rate), &mut random);
                        changed_one_by_one(&mut expected, &changes, Chance(rate), &mut other);
                        assert_eq!(genes, expected, "{kind:?}, {rate}, {count}");
                        assert_eq!(random, other, "{kind:?}, {rate}, {count}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_elite_stays_as_it_is() {
        let settings = Settings {
            elite: 2,
            mutation: Mutation {
                rate: 1.0,
                ..Default::default()
            },
            ..settings()
        };
        let mut evolution = Genetic::new(&settings, 5, vec![None; GENES], None);
        let generation = evolution.tell((0..20_u8).map(f32::from).collect()).unwrap();
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
            let settings = Settings {
                population: 2000,
                parents: 1,
                initial: [2.0, 3.0],
                mutation: Mutation {
                    kind,
                    rate: 0.25,
                    per,
                    amount: 0.5,
                },
                ..Default::default()
            };
            let mut evolution = Genetic::new(&settings, 6, vec![None; GENES], None);
            let generation = evolution
                .tell((0..2000_u16).map(|index| -f32::from(index)).collect())
                .unwrap();
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
        let limited = Settings {
            limits: Some([-0.5, 0.25]),
            ..settings()
        };
        let mut evolution = Genetic::new(&limited, 7, vec![None; GENES], None);
        for _ in 0..5 {
            assert!(evolution.ask().values().iter().all(|gene| (-0.5..=0.25).contains(gene)));
            evolution.tell(fitness(evolution.ask())).unwrap();
        }
        assert_eq!(kept(1e9, bounds(&limited, Some([0.0, 3.0]))), 3.0);
        let unlimited = bounds(&settings(), None);
        assert_eq!(kept(1e9, unlimited), GREATEST_GENE);
        assert_eq!(kept(1e-40, unlimited).to_bits(), 0);
        assert_eq!(kept(-1e-60, unlimited).to_bits(), 0);
    }

    /// A gene with a range of its own covers it, and mutations change it as much in proportion as others.
    #[test]
    fn genes_have_ranges_of_their_own() {
        let ranges: Ranges = (0..GENES).map(|gene| (gene % 2 == 1).then_some([10.0, 18.0])).collect();
        for kind in [MutationKind::AddUniform, MutationKind::AddNormal, MutationKind::Replace] {
            let settings = Settings {
                population: 1000,
                parents: 1000,
                elite: 0,
                limits: Some([-1.0, 1.0]),
                mutation: Mutation {
                    kind,
                    rate: 1.0,
                    amount: 0.125,
                    ..Mutation::default()
                },
                ..Settings::default()
            };
            let mut evolution = Genetic::new(&settings, 8, ranges.clone(), None);
            let first = evolution.ask().clone();
            let generation = evolution.tell(vec![1.0; 1000]).unwrap();
            let next = evolution.ask();
            // Means of the change of genes, in widths of their ranges.
            let (mut plain, mut ranged) = (0.0, 0.0);
            for (child, &parent) in generation.ranking.iter().enumerate() {
                let pairs = next.genome(child).iter().zip(first.genome(parent as usize));
                for (gene, (new, old)) in pairs.enumerate() {
                    let change = f64::from((new - old).abs()) / 9000.0;
                    if gene % 2 == 1 {
                        assert!((10.0..=18.0).contains(new) && (10.0..=18.0).contains(old));
                        ranged += change / 8.0;
                    } else {
                        assert!((-1.0..=1.0).contains(new));
                        plain += change / 2.0;
                    }
                }
            }
            assert!((plain / ranged - 1.0).abs() < 0.05, "{kind:?}: {plain} {ranged}");
            assert!(plain > 0.01, "{plain}");
        }
        let [plain, ranged] = [vec![None; GENES], ranges].map(|ranges| Genetic::new(&settings(), 8, ranges, None));
        assert!(
            plain.clone().restore(&ranged.save()).is_err(),
            "another optimiser's state"
        );
        assert!(ranged.clone().restore(&ranged.save()).is_ok());
    }
}
