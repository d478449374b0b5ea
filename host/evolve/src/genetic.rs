//! A genetic algorithm: parents are selected, have children, and these are mutated. Its default is that of Miglino, Lund and
//! Nolfi (1995): the best are copied, each equally often, and the copies mutated.

use crate::error::{Error, Result};
use rand::Rng;
use rand::distr::Distribution;
use rand_pcg::Pcg64;

use super::random::{Chance, Normal, Stream, Uniform, below, stream, unit, unit_of};
use super::registry::Entry;
use super::settings::{
    Crossover, CrossoverKind, Feature, GivenGenomes, Mutation, MutationKind, MutationUnit, Ranges, SelectionKind,
    Settings, Space, bounds, breeding, initial_range, kept,
};
use super::{Optimizer, Population, saved};

/// The algorithm's name, and the version of its saved states.
const NAME: &str = "genetic";
const VERSION: u32 = 1;

/// What it makes of given genomes: it copies and mutates them.
pub(crate) const FROM_MUTANTS: GivenGenomes = GivenGenomes::First("mutated copies of them");

pub(crate) const ENTRY: Entry = Entry {
    features: &[Feature::Breeds],
    start: FROM_MUTANTS,
    check: |settings, _| breeding::check(settings),
    ..Entry::new(
        [
            NAME,
            "a genetic algorithm; by default that of Miglino et al. 1995",
            "to reproduce published evolutions; when scores are rough or noisy",
        ],
        |beginning| {
            Box::new(Genetic::new(
                beginning.settings,
                beginning.seed,
                beginning.ranges(),
                beginning.init,
            ))
        },
    )
};

/// The algorithm at one generation: a function of its settings, its seed and the fitness reported to it.
#[derive(Clone, Debug)]
pub struct Genetic {
    settings: Settings,
    seed: u64,
    generation: u32,
    ranges: Ranges,
    population: Population,
}

impl Genetic {
    /// Starts from random genes, one for each of `ranges`, or from given genomes, at most as many as the settings' individuals: these are
    /// the first individuals, and the others are mutated copies of them.
    pub fn new(settings: &Settings, seed: u64, ranges: Ranges, init: Option<Population>) -> Self {
        let mut genetic = Self {
            settings: settings.clone(),
            seed,
            generation: 0,
            population: Population::new(ranges.len(), Vec::new()),
            ranges,
        };
        genetic.population = match init {
            None => initial(settings, seed, &genetic.ranges),
            Some(given) => genetic.filled(&given),
        };
        genetic
    }

    /// Given genomes, and mutated copies of them up to a whole population.
    fn filled(&self, given: &Population) -> Population {
        let individuals = 0..self.settings.population as usize;
        let genomes = individuals.flat_map(|individual| given.genome(individual % given.len()));
        let mut values: Vec<f32> = genomes.copied().collect();
        let mut random = stream(self.seed, Stream::Mutation, 0);
        self.mutate(&mut values[given.values().len()..], &self.changes(), &mut random);
        Population::new(given.genes(), values)
    }

    /// How each gene of a genome changes.
    fn changes(&self) -> Vec<Change> {
        let of = |&range: &_| Change::of(&self.settings, range);
        self.ranges.iter().map(of).collect()
    }

    /// Starts from a generation of this number, of genes without separate ranges.
    pub fn at(settings: &Settings, seed: u64, generation: u32, population: Population) -> Self {
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
    fn owner(&self) -> saved::Owner {
        saved::Owner::new(&self.settings, self.seed, &self.ranges)
    }

    /// Breeds the next generation. With truncation it has equally many copies of each parent, the best parent's first, and the
    /// first copy of each of the elite is unchanged. With other selections the elite comes first.
    fn bred(&self, ranking: &[u32], fitness: &[f32]) -> Population {
        let Settings { population, elite, .. } = self.settings;
        let mut random = stream(self.seed, Stream::Mutation, self.generation + 1);
        let genes = self.population.genes;
        let parents = self.parents(ranking, fitness);
        let mut values = Vec::with_capacity(self.population.values.len());
        for &parent in &parents.chosen {
            values.extend_from_slice(self.population.genome(parent as usize));
        }
        if self.settings.crossover.kind != CrossoverKind::None {
            self.cross(&mut values, &parents);
        }
        let changes = self.changes();
        // Families of the elite, whose first child is unchanged.
        let (families, family) = match self.settings.selection.kind {
            SelectionKind::Truncation => (elite, population / self.settings.parents),
            _ => (elite, 1),
        };
        let family = family as usize * genes;
        let (of_elite, others) = values.split_at_mut(families as usize * family);
        for family in of_elite.chunks_exact_mut(family) {
            self.mutate(&mut family[genes..], &changes, &mut random);
        }
        self.mutate(others, &changes, &mut random);
        Population::new(genes, values)
    }

    /// Selects the first parent of each child, and how a second one is selected.
    fn parents(&self, ranking: &[u32], fitness: &[f32]) -> Parents {
        let Settings {
            population,
            parents,
            elite,
            ref selection,
            ..
        } = self.settings;
        let mut random = stream(self.seed, Stream::Selection, self.generation + 1);
        let best = &ranking[..parents.min(population) as usize];
        let wheel = match selection.kind {
            SelectionKind::Truncation | SelectionKind::Uniform => Wheel::Even(best.to_vec()),
            SelectionKind::Rank => Wheel::of_ranks(ranking, selection.pressure),
            SelectionKind::Roulette => Wheel::of_fitness(ranking, fitness, selection.scaling),
            SelectionKind::Tournament => Wheel::Tournament(ranking.to_vec(), selection.size),
        };
        let (chosen, kept) = if selection.kind == SelectionKind::Truncation {
            let copies = population / parents;
            let chosen = best.iter().flat_map(|&parent| (0..copies).map(move |_| parent));
            let is_kept = |child| child % copies == 0 && child / copies < elite;
            (chosen.collect(), (0..population).map(is_kept).collect())
        } else {
            let others = (elite..population).map(|_| wheel.drawn(&mut random));
            let chosen = ranking[..elite as usize].iter().copied().chain(others);
            (chosen.collect(), (0..population).map(|child| child < elite).collect())
        };
        Parents { chosen, kept, wheel }
    }

    /// Gives changed children genes of a second parent, each with the settings' chance.
    fn cross(&self, children: &mut [f32], parents: &Parents) {
        let Crossover { kind, rate, share } = self.settings.crossover;
        let mut random = stream(self.seed, Stream::Crossover, self.generation + 1);
        let genes = self.population.genes;
        for (child, &is_kept) in children.chunks_exact_mut(genes).zip(&parents.kept) {
            if is_kept || !Chance(rate).sample(&mut random) {
                continue;
            }
            let second = self.population.genome(parents.wheel.drawn(&mut random) as usize);
            let [from, to] = match kind {
                // Each parent gives one gene or more, if there are two.
                CrossoverKind::OnePoint => [(1 + below((genes - 1).max(1), &mut random)).min(genes - 1), genes],
                CrossoverKind::TwoPoint => {
                    let places = [below(genes + 1, &mut random), below(genes + 1, &mut random)];
                    [places[0].min(places[1]), places[0].max(places[1])]
                }
                CrossoverKind::Uniform => {
                    for (gene, &other) in child.iter_mut().zip(second) {
                        if Chance(share).sample(&mut random) {
                            *gene = other;
                        }
                    }
                    continue;
                }
                CrossoverKind::None => continue,
            };
            child[from..to].copy_from_slice(&second[from..to]);
        }
    }

    /// Mutates genomes as the settings say; `changes` are those of a genome's genes.
    fn mutate(&self, genomes: &mut [f32], changes: &[Change], random: &mut Pcg64) {
        let Mutation { rate, per, kind, .. } = self.settings.mutation;
        let chance = Chance(rate);
        match (per, kind) {
            (_, MutationKind::AddVector) => {
                for genome in genomes.chunks_exact_mut(changes.len()) {
                    if chance.sample(random) {
                        add_vector(genome, changes, random);
                    }
                }
            }
            (_, MutationKind::EvoStick) => {
                for genome in genomes.chunks_exact_mut(changes.len()) {
                    mutate_as_evostick(genome, changes, chance.sample(random), random);
                }
            }
            (_, MutationKind::FlipBits) => {
                for (gene, change) in genomes.iter_mut().zip(changes.iter().cycle()) {
                    *gene = change.flipped(*gene, chance, random);
                }
            }
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
/// Processors can't predict which genes change, and a misprediction costs as much as about twenty unchanged genes. So
/// words are first drawn and noted without a branch, and then only the changing genes are visited.
fn mutate_each(genomes: &mut [f32], changes: &[Change], chance: Chance, random: &mut Pcg64) {
    /// Genes at a time: their words stay in the processor's nearest memory.
    const PIECE: usize = 512;
    let bound = chance.bound();
    // Most experiments: no division to find a gene's kind of change.
    let is_one = changes.iter().all(|change| *change == changes[0]);
    let mut words = [0_u64; 2 * PIECE];
    // Places of the words that decide for a change.
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
            let kind = if is_one {
                0
            } else {
                (number * PIECE + index) % changes.len()
            };
            piece[index] = changes[kind].at(piece[index], unit_of(words[usize::from(place) + 1]));
        }
    }
}

/// Adds a vector of random direction, whose length is normal, as Beer's genetic algorithm does.
fn add_vector(genome: &mut [f32], changes: &[Change], random: &mut Pcg64) {
    let normal = Normal { deviation: 1.0 };
    let length = normal.sample(random);
    let direction: Vec<f64> = genome.iter().map(|_| normal.sample(random)).collect();
    // Of 0 only if all are, which no generator draws.
    let size = direction.iter().map(|part| part * part).sum::<f64>().sqrt();
    for ((gene, change), part) in genome.iter_mut().zip(changes).zip(direction) {
        *gene = kept(f64::from(*gene) + change.amount * length * (part / size), change.bounds);
    }
}

/// Mutates a genome as `EvoStick`'s program does: of a severe mutation 0.7 of genes are changed and 0.2 replaced, of another one all
/// are changed but of those in the last fifth, if there are ten or more, 0.5, of which 0.2 are replaced.
fn mutate_as_evostick(genome: &mut [f32], changes: &[Change], is_severe: bool, random: &mut Pcg64) {
    let count = genome.len();
    for (index, (gene, change)) in genome.iter_mut().zip(changes).enumerate() {
        let (drawn, share) = (unit(random), unit(random));
        let is_tail = count >= 10 && 5 * index > 4 * count;
        let [added, replaced] = match (is_severe, is_tail) {
            (true, _) => [0.7, 0.9],
            (false, true) => [0.5, 0.7],
            (false, false) => [1.0, 1.0],
        };
        let number = Uniform {
            low: -change.amount,
            high: change.amount,
        }
        .at(share);
        if drawn < added {
            *gene = kept(f64::from(*gene) + number, change.bounds);
        } else if drawn < replaced {
            *gene = kept(change.middle() + number, change.bounds);
        }
    }
}

/// The first parent of each child, whether that child is an unchanged copy, and how second parents are drawn.
struct Parents {
    chosen: Vec<u32>,
    kept: Vec<bool>,
    wheel: Wheel,
}

/// Individuals that parents are drawn from.
enum Wheel {
    /// Each with the same chance.
    Even(Vec<u32>),
    /// By sums of weights: the last is that of all.
    Weighted(Vec<u32>, Vec<f64>),
    /// The best-ranked of a number of randomly drawn individuals.
    Tournament(Vec<u32>, u32),
}

impl Wheel {
    /// Weights that fall linearly with the rank, from `pressure` of the best to 2 - `pressure` of the last (Baker 1985).
    fn of_ranks(ranking: &[u32], pressure: f64) -> Self {
        let last = (ranking.len() - 1).max(1) as f64;
        let weight = |place: usize| pressure - (2.0 * pressure - 2.0) * (place as f64 / last);
        Self::weighted(ranking, (0..ranking.len()).map(weight))
    }

    /// Weights that rise linearly with fitness: the best has `scaling` times the mean, or less where the worst would
    /// fall below 0 (linear scaling, Goldberg 1989). NaN and minus infinity have none. Negative fitness is shifted
    /// first, so that the minimum is 0.
    fn of_fitness(ranking: &[u32], fitness: &[f32], scaling: f64) -> Self {
        let score = |&individual: &u32| f64::from(fitness[individual as usize].min(f32::MAX));
        let fit: Vec<u32> = ranking
            .iter()
            .copied()
            .filter(|individual| fitness[*individual as usize] > f32::NEG_INFINITY)
            .collect();
        let (Some(best), Some(least)) = (fit.first().map(score), fit.last().map(score)) else {
            return Self::Even(ranking.to_vec());
        };
        if best <= least {
            return Self::Even(fit);
        }
        let shift = least.min(0.0);
        let [best, least] = [best, least].map(|score| score - shift);
        let mean = fit.iter().map(|individual| score(individual) - shift).sum::<f64>() / fit.len() as f64;
        let slope = if least * (scaling - 1.0) > scaling * mean - best {
            (scaling - 1.0) * mean / (best - mean)
        } else {
            mean / (mean - least)
        };
        let weights: Vec<f64> = fit
            .iter()
            .map(|individual| (mean + slope * (score(individual) - shift - mean)).max(0.0))
            .collect();
        Self::weighted(&fit, weights.into_iter())
    }

    fn weighted(individuals: &[u32], weights: impl Iterator<Item = f64>) -> Self {
        let sums = weights.scan(0.0, |sum, weight| {
            *sum += weight;
            Some(*sum)
        });
        Self::Weighted(individuals.to_vec(), sums.collect())
    }

    /// Draws one.
    fn drawn(&self, random: &mut Pcg64) -> u32 {
        match self {
            Self::Even(all) => all[below(all.len(), random)],
            Self::Weighted(all, sums) => {
                let at = unit(random) * sums[sums.len() - 1];
                all[sums.partition_point(|&sum| sum <= at).min(all.len() - 1)]
            }
            Self::Tournament(all, size) => {
                let places = (0..*size).map(|_| below(all.len(), random));
                all[places.min().unwrap_or_default()]
            }
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
    /// Bits, of a gene that is a word.
    bits: u32,
    /// Minimum and maximum after the change.
    bounds: [f64; 2],
}

impl Change {
    /// The change of a gene, with the gene's range if it has one.
    fn of(settings: &Settings, range: Option<[f32; 2]>) -> Self {
        let mutation = &settings.mutation;
        let initial = initial_range(settings, range);
        let amount = match range {
            Some(_) => mutation.amount * (initial[1] - initial[0]) / (settings.initial[1] - settings.initial[0]),
            None => mutation.amount,
        };
        Self {
            kind: mutation.kind,
            initial,
            amount,
            bits: mutation.bits,
            bounds: bounds(settings, range),
        }
    }

    /// The middle of its initial range.
    fn middle(&self) -> f64 {
        0.5 * (self.initial[0] + self.initial[1])
    }

    /// The maximum word.
    fn greatest(&self) -> u32 {
        (1 << self.bits) - 1
    }

    /// A word's gene: words are spread evenly over the initial range, both ends included.
    fn of_word(&self, word: u32) -> f32 {
        let [low, high] = self.initial;
        kept(
            low + (high - low) * (f64::from(word) / f64::from(self.greatest())),
            self.bounds,
        )
    }

    /// The gene as a word, if its bits flip by a chance each; the same gene if none does.
    fn flipped(&self, gene: f32, chance: Chance, random: &mut Pcg64) -> f32 {
        let flips = (0..self.bits).fold(0, |flips, bit| flips | u32::from(chance.sample(random)) << bit);
        if flips == 0 {
            return gene;
        }
        let place = self.share(gene) * f64::from(self.greatest());
        self.of_word(place.round() as u32 ^ flips)
    }

    /// A gene's place in its initial range, 0 to 1.
    fn share(&self, gene: f32) -> f64 {
        let [low, high] = self.initial;
        ((f64::from(gene) - low) / (high - low)).clamp(0.0, 1.0)
    }

    /// The word that a gene drawn from the initial range makes: each with the same chance.
    fn word_of_draw(&self, gene: f32) -> u32 {
        ((self.share(gene) * f64::from(self.greatest() + 1)) as u32).min(self.greatest())
    }

    /// The changed gene.
    fn drawn(&self, gene: f32, random: &mut Pcg64) -> f32 {
        match self.kind {
            MutationKind::AddNormal => {
                let normal = Normal { deviation: self.amount };
                kept(f64::from(gene) + normal.sample(random), self.bounds)
            }
            _ => self.at(gene, unit(random)),
        }
    }

    /// The changed gene, if a uniform number decides: the one at a fraction of its range.
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

    fn generation(&self) -> u32 {
        self.generation
    }

    fn ask(&self) -> &Population {
        &self.population
    }

    fn advance(&mut self, fitness: &[f32], ranking: &[u32], _: &[f64]) -> Population {
        let next = self.bred(ranking, fitness);
        self.generation += 1;
        std::mem::replace(&mut self.population, next)
    }

    fn set_generations(&mut self, generations: u32) {
        self.settings.generations = generations;
    }

    fn save(&self) -> Vec<u8> {
        let state = (self.generation, &self.population.values);
        saved::seal(NAME, VERSION, &self.owner(), &state)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result {
        let (generation, values): (u32, Vec<f32>) = saved::open(NAME, VERSION, &self.owner(), bytes)?;
        if values.len() != self.population.values.len() {
            return Err(Error::Lengths);
        }
        self.generation = generation;
        self.population.values = values;
        Ok(())
    }
}

/// Generation 0.
fn initial(settings: &Settings, seed: u64, ranges: &Ranges) -> Population {
    let mut random = stream(seed, Stream::InitialGenes, 0);
    let mut values = Space::new(settings, ranges).drawn(settings.population, &mut random);
    if settings.mutation.kind == MutationKind::FlipBits {
        let changes = ranges.iter().map(|&range| Change::of(settings, range));
        for (gene, change) in values.iter_mut().zip(changes.collect::<Vec<_>>().iter().cycle()) {
            *gene = change.of_word(change.word_of_draw(*gene));
        }
    }
    Population::new(ranges.len(), values)
}

#[cfg(test)]
mod tests {
    use oneiro::batch::GREATEST_GENE;

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
        let generation = evolution.tell(fitness(evolution.ask()), &[]).unwrap();
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
        let generation = evolution.tell((0..20_u8).map(f32::from).collect(), &[]).unwrap();
        for (index, genome) in evolution.ask().genomes().enumerate() {
            assert_eq!(genome, generation.population.genome(19 - index / 5));
        }
    }

    /// Genes that change one after the other, as defined.
    fn changed_one_by_one(genes: &mut [f32], changes: &[Change], chance: Chance, random: &mut Pcg64) {
        for (gene, change) in genes.iter_mut().zip(changes.iter().cycle()) {
            if chance.sample(random) {
                *gene = change.drawn(*gene, random);
            }
        }
    }

    /// Words drawn in advance change the same genes in the same way as words drawn one by one, and leave the generator
    /// in the same state.
    #[test]
    fn genes_change_as_one_by_one() {
        let ranged: Ranges = vec![None, Some([10.0, 18.0]), None, Some([-1.0, 0.5]), None];
        for kind in [MutationKind::AddUniform, MutationKind::Replace] {
            for rate in [0.0, 1e-12, 0.01, 0.25, 0.5, 0.999, 1.0] {
                let mut settings = settings();
                (settings.mutation.kind, settings.mutation.rate) = (kind, rate);
                for ranges in [&vec![None; 5], &ranged] {
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
        let generation = evolution.tell((0..20_u8).map(f32::from).collect(), &[]).unwrap();
        let is_copy = |index: usize, parent| evolution.ask().genome(index) == generation.population.genome(parent);
        assert!(is_copy(0, 19) && is_copy(5, 18));
        assert!(!is_copy(1, 19) && !is_copy(10, 17));
    }

    /// Parents of the children of a population of 2000 whose fitness is given, by index.
    fn children(fitness: Vec<f32>, change: impl Fn(&mut Settings)) -> Vec<f64> {
        let mut settings = Settings {
            population: 2000,
            mutation: Mutation {
                rate: 0.0,
                ..Mutation::default()
            },
            ..Settings::default()
        };
        change(&mut settings);
        // Each genome is its index.
        let init = Population::new(1, (0..2000_u16).map(f32::from).collect());
        let mut evolution = Genetic::new(&settings, 3, vec![None], Some(init));
        evolution.tell(fitness, &[]).unwrap();
        let mut counts = vec![0.0; 2000];
        for genome in evolution.ask().genomes() {
            counts[genome[0] as usize] += 1.0;
        }
        counts
    }

    /// Children of the first and the last tenth of the individuals, as fractions of all.
    fn tenths(counts: &[f64]) -> [f64; 2] {
        [&counts[..200], &counts[1800..]].map(|part| part.iter().sum::<f64>() / 2000.0)
    }

    /// Chances are those of the formulas: within four deviations of the mean of 2000 draws.
    #[test]
    fn parents_are_drawn_as_the_selection_says() {
        let rising: Vec<f32> = (0..2000_u16).map(f32::from).collect();
        let by = |kind| move |settings: &mut Settings| settings.selection.kind = kind;
        let near = |[first, last]: [f64; 2], [least, greatest]: [f64; 2]| {
            assert!((first - least).abs() < 0.02, "{first} for {least}");
            assert!((last - greatest).abs() < 0.036, "{last} for {greatest}");
        };
        // Linear from 2 for the best to 0 for the last: the mean of the last tenth is 0.1, and a tenth are there.
        near(tenths(&children(rising.clone(), by(SelectionKind::Rank))), [0.01, 0.19]);
        let gentle = |settings: &mut Settings| {
            (settings.selection.kind, settings.selection.pressure) = (SelectionKind::Rank, 1.1);
        };
        near(tenths(&children(rising.clone(), gentle)), [0.091, 0.109]);
        // Fitness from 0 to twice the mean: scaling to twice the mean changes nothing, also after a shift below 0.
        near(
            tenths(&children(rising.clone(), by(SelectionKind::Roulette))),
            [0.01, 0.19],
        );
        let shifted = rising.iter().map(|fitness| fitness - 5000.0).collect();
        near(tenths(&children(shifted, by(SelectionKind::Roulette))), [0.01, 0.19]);
        // A positive constant changes nothing either: the worst still have 0.
        let raised = rising.iter().map(|fitness| fitness + 1000.0).collect();
        near(tenths(&children(raised, by(SelectionKind::Roulette))), [0.01, 0.19]);
        let halved = |settings: &mut Settings| {
            (settings.selection.kind, settings.selection.scaling) = (SelectionKind::Roulette, 1.5);
        };
        near(tenths(&children(rising.clone(), halved)), [0.055, 0.145]);
        // The best of two is of the last tenth unless neither is.
        near(
            tenths(&children(rising.clone(), by(SelectionKind::Tournament))),
            [0.01, 0.19],
        );
        let larger = |settings: &mut Settings| {
            (settings.selection.kind, settings.selection.size) = (SelectionKind::Tournament, 7);
        };
        near(tenths(&children(rising.clone(), larger)), [0.0, 1.0 - 0.9_f64.powi(7)]);
        let uniform = |settings: &mut Settings| {
            (settings.selection.kind, settings.parents, settings.elite) = (SelectionKind::Uniform, 400, 100);
        };
        let counts = children(rising, uniform);
        assert!(counts[..1600].iter().all(|count| *count == 0.0));
        assert!(counts[1900..].iter().all(|count| *count >= 1.0), "the elite");
        near(tenths(&counts), [0.0, 0.5 * 1900.0 / 2000.0 + 100.0 / 2000.0]);
    }

    /// Equal, infinite and missing scores exclude no possible parent, and include no other.
    #[test]
    fn a_roulette_wheel_takes_any_score() {
        let by = |settings: &mut Settings| settings.selection.kind = SelectionKind::Roulette;
        let counts = children(vec![-3.0; 2000], by);
        assert!(tenths(&counts).iter().all(|share| (share - 0.1).abs() < 0.03));
        let mut odd = vec![1.0; 2000];
        (odd[0], odd[1], odd[2], odd[3]) = (f32::NAN, f32::NEG_INFINITY, f32::INFINITY, 2.0);
        let counts = children(odd, by);
        assert_eq!((counts[0], counts[1]), (0.0, 0.0));
        // It has twice as many children as the others on average.
        assert!((1.0..12.0).contains(&counts[2]), "{}", counts[2]);
        assert!((tenths(&counts)[1] - 0.1).abs() < 0.03);
        assert!(
            tenths(&children(vec![f32::NAN; 2000], by))
                .iter()
                .all(|share| (share - 0.1).abs() < 0.03)
        );
    }

    /// Genes of two parents, of which one has zeros and the other ones.
    #[test]
    fn children_have_genes_of_both_parents() {
        for kind in [CrossoverKind::OnePoint, CrossoverKind::TwoPoint, CrossoverKind::Uniform] {
            for elite in [0, 10] {
                let mut settings = Settings {
                    population: 2000,
                    elite,
                    mutation: Mutation {
                        rate: 0.0,
                        ..Mutation::default()
                    },
                    ..Settings::default()
                };
                settings.selection.kind = SelectionKind::Uniform;
                settings.parents = 2000;
                settings.crossover = Crossover {
                    kind,
                    rate: 0.5,
                    share: 0.25,
                };
                let genes = (0..2000 * GENES).map(|gene| (gene / GENES % 2) as f32).collect();
                let mut evolution = Genetic::new(&settings, 2, vec![None; GENES], Some(Population::new(GENES, genes)));
                evolution.tell(vec![0.0; 2000], &[]).unwrap();
                let joints = |genome: &[f32]| genome.windows(2).filter(|pair| pair[0] != pair[1]).count();
                let mixed: Vec<&[f32]> = evolution.ask().genomes().filter(|genome| joints(genome) > 0).collect();
                let most = match kind {
                    CrossoverKind::OnePoint => 1,
                    CrossoverKind::TwoPoint => 2,
                    _ => GENES,
                };
                assert!(mixed.iter().all(|genome| joints(genome) <= most), "{kind:?}");
                // Half have two parents, and those of half of these differ.
                let share = mixed.len() as f64 / 2000.0;
                assert!((0.2..0.28).contains(&share), "{kind:?}: {share}");
                if kind == CrossoverKind::OnePoint {
                    let places: std::collections::BTreeSet<usize> = mixed
                        .iter()
                        .filter_map(|genome| genome.windows(2).position(|pair| pair[0] != pair[1]))
                        .collect();
                    assert_eq!(places.len(), GENES - 1, "each place between two genes");
                }
                let first = evolution.ask().genomes().take(elite as usize);
                assert!(first.into_iter().all(|genome| joints(genome) == 0), "the elite");
            }
        }
    }

    /// `EvoStick`'s mutation of 50 genes by its numbers, and the length of a vector that is added.
    #[test]
    fn whole_genomes_mutate_as_published() {
        const COUNT: usize = 4000;
        let changed = |kind, rate| {
            let mut settings = settings();
            settings.limits = Some([-5.0, 5.0]);
            settings.mutation = Mutation {
                kind,
                rate,
                amount: 1.0,
                ..Mutation::default()
            };
            let evolution = Genetic::new(&settings, 1, vec![None; 50], None);
            let changes: Vec<Change> = (0..50).map(|_| Change::of(&settings, None)).collect();
            let mut genomes = vec![3.0; 50 * COUNT];
            evolution.mutate(&mut genomes, &changes, &mut stream(5, Stream::Mutation, 1));
            genomes
        };
        // Fractions of genes that are changed, and that are replaced by a number from -1 to 1, of the first 41 and of
        // the last 9.
        let shares = |genomes: &[f32], from, to| {
            let genes = || genomes.chunks_exact(50).flat_map(|genome| &genome[from..to]);
            let count = (COUNT * (to - from)) as f64;
            let share = |is: fn(f32) -> bool| genes().filter(|gene| is(**gene)).count() as f64 / count;
            [share(|gene| gene >= 2.0 && gene != 3.0), share(|gene| gene < 1.0)]
        };
        for (rate, expected) in [(1.0, [[0.7, 0.2], [0.7, 0.2]]), (0.0, [[1.0, 0.0], [0.5, 0.2]])] {
            let genomes = changed(MutationKind::EvoStick, rate);
            for (measured, expected) in [shares(&genomes, 0, 41), shares(&genomes, 41, 50)].iter().zip(expected) {
                for (value, expected) in measured.iter().zip(expected) {
                    assert!((value - expected).abs() < 0.015, "{rate}: {value} for {expected}");
                }
            }
        }
        let genomes = changed(MutationKind::AddVector, 0.5);
        let lengths: Vec<f64> = genomes
            .chunks_exact(50)
            .map(|genome| genome.iter().map(|gene| f64::from(gene - 3.0).powi(2)).sum::<f64>())
            .filter(|square| *square > 0.0)
            .collect();
        let share = lengths.len() as f64 / COUNT as f64;
        assert!((share - 0.5).abs() < 0.03, "{share}");
        let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
        assert!((mean - 1.0).abs() < 0.1, "{mean}");
    }

    /// The fraction of genes that change, by how much, and how changes fall on individuals.
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
                    ..Mutation::default()
                },
                ..Default::default()
            };
            let mut evolution = Genetic::new(&settings, 6, vec![None; GENES], None);
            let generation = evolution
                .tell((0..2000_u16).map(|index| -f32::from(index)).collect(), &[])
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
                _ => assert!(deviation > 0.28, "{deviation}"),
            }
        }
    }

    /// Words of three bits from -1 to 6 are whole numbers: each begins equally often, and bits flip only by their
    /// chance.
    #[test]
    fn bits_flip_by_their_chance() {
        let mut settings = Settings {
            population: 4000,
            parents: 1,
            initial: [-1.0, 6.0],
            ..Settings::default()
        };
        (settings.mutation.kind, settings.mutation.rate, settings.mutation.bits) = (MutationKind::FlipBits, 0.1, 3);
        let mut evolution = Genetic::new(&settings, 6, vec![None; 2], None);
        let word = |gene: &f32| (gene + 1.0) as usize;
        let mut counts = [0.0; 8];
        for gene in evolution.ask().values() {
            assert_eq!(gene.fract(), 0.0);
            counts[word(gene)] += 1.0 / 8000.0;
        }
        assert!(
            counts.iter().all(|share: &f64| (share - 0.125).abs() < 0.015),
            "{counts:?}"
        );
        let generation = evolution.tell(vec![0.0; 4000], &[]).unwrap();
        let parent = generation.population.genome(0);
        let mut flips = [0.0; 3];
        for genome in evolution.ask().genomes() {
            for (gene, parent) in genome.iter().zip(parent) {
                let changed = word(gene) ^ word(parent);
                for (bit, share) in flips.iter_mut().enumerate() {
                    *share += (changed >> bit & 1) as f64 / 8000.0;
                }
            }
        }
        assert!(flips.iter().all(|share: &f64| (share - 0.1).abs() < 0.015), "{flips:?}");
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
            evolution.tell(fitness(evolution.ask()), &[]).unwrap();
        }
        assert_eq!(kept(1e9, bounds(&limited, Some([0.0, 3.0]))), 3.0);
        let unlimited = bounds(&settings(), None);
        assert_eq!(kept(1e9, unlimited), GREATEST_GENE);
        assert_eq!(kept(1e-40, unlimited).to_bits(), 0);
        assert_eq!(kept(-1e-60, unlimited).to_bits(), 0);
    }

    /// A gene with its range covers it, and mutations change it as much in proportion as others.
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
            let generation = evolution.tell(vec![1.0; 1000], &[]).unwrap();
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
