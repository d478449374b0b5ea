//! The table `[evolution]` of an experiment: the optimiser, its values, and for how many generations it runs.

pub(crate) mod breeding;
pub(crate) mod budget;
mod conditions;
pub(crate) mod descriptors;
mod strategy;

use oneiro::batch::GREATEST_GENE;
use oneiro::parameter::Allowed::{Any, Number, Text, Whole, WholeUpTo};
use oneiro::parameter::{Datum, Field, Invalid, Parameter, row};
use rand::Rng;
use rand::distr::Distribution;
use serde::Serialize;

use super::Population;
use super::random::Uniform;
pub use super::{Kind, Tables};
pub use breeding::{Crossover, CrossoverKind, Mutation, MutationKind, MutationUnit, Selection, SelectionKind};
pub use budget::{Course, Episodes, MOST_GENERATIONS};
pub(crate) use conditions::{Checked, Feature, Given, refused};
pub use conditions::{GivenGenomes, Need, Surroundings};
pub use descriptors::Descriptor;
pub use strategy::Strategy;

/// The optimiser, its values, and for how many generations it runs. Values of other optimisers are not used.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Settings {
    /// The optimiser.
    pub kind: Kind,
    /// Individuals.
    pub population: u32,
    /// How many of the best may become parents.
    pub parents: u32,
    /// Episodes that a run may have, from which its generations follow.
    #[serde(skip)]
    pub budget: Option<u64>,
    /// Generations that are evaluated.
    pub generations: u32,
    /// How many of the best also keep one unchanged copy.
    pub elite: u32,
    /// Whether all individuals of a generation live with the same random numbers; each has its own where nothing is given.
    pub common: Option<bool>,
    /// Range of the uniform initial genes.
    pub initial: [f64; 2],
    /// The central fraction of that range for random genes, gene by gene; all of it where nothing is given.
    #[serde(skip_serializing_if = "Shares::is_empty")]
    pub initial_shares: Shares,
    /// A file of initial genes instead.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub init: Option<String>,
    /// Range that genes are kept within.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<[f64; 2]>,
    /// What several optimisers share.
    pub selection: Selection,
    pub crossover: Crossover,
    pub mutation: Mutation,
    pub strategy: Strategy,
    pub descriptors: Vec<Descriptor>,
    /// Tables of one optimiser each.
    #[serde(flatten)]
    pub tables: Tables,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            kind: Kind::Genetic,
            population: 100,
            parents: 20,
            budget: None,
            generations: 200,
            elite: 0,
            common: None,
            initial: [-1.0, 1.0],
            initial_shares: Shares::default(),
            init: None,
            limits: None,
            selection: Selection::default(),
            crossover: Crossover::default(),
            mutation: Mutation::default(),
            strategy: Strategy::default(),
            descriptors: Vec::new(),
            tables: Tables::default(),
        }
    }
}

impl Settings {
    /// Whether the optimiser has a feature.
    pub(crate) fn is(&self, feature: Feature) -> bool {
        self.kind.entry().features.contains(&feature)
    }

    /// With an optimiser that may begin with given genomes.
    fn if_takes_genomes(&mut self) -> Option<&mut Self> {
        (!matches!(self.kind.entry().start, GivenGenomes::None(_))).then_some(self)
    }

    /// With an optimiser that begins at random genes.
    fn if_draws_genes(&mut self) -> Option<&mut Self> {
        (!self.is(Feature::SetsFirstGenes)).then_some(self)
    }

    /// With an optimiser whose generations are counted.
    fn if_counts_generations(&mut self) -> Option<&mut Self> {
        (!self.is(Feature::SetsGenerations)).then_some(self)
    }

    /// The default number of parents: 20, or where 20 does not divide the population, its largest divisor up to a fifth of it.
    pub fn parents_of(population: u32) -> u32 {
        let default = Self::default().parents;
        if population.is_multiple_of(default) {
            return default;
        }
        let divides = |count: &u32| population.is_multiple_of(*count);
        (1..=population.min(1_000_000) / 5).rev().find(divides).unwrap_or(1)
    }

    /// Gives what a file does not give the optimiser's own default.
    pub fn complete(&mut self, genes: usize, trials: u32, has_population: bool) {
        let given = Given {
            genes,
            trials,
            has_population,
        };
        (self.kind.entry().complete)(self, given);
    }

    /// Checks the values that the optimiser uses, once they are complete.
    ///
    /// # Errors
    /// The key, the value and the allowed ones.
    pub fn check(&self, surroundings: &Surroundings<'_>) -> Result<(), Invalid> {
        let genes = surroundings.genes.len();
        for (key, range) in [
            ("evolution.initial", Some(self.initial)),
            ("evolution.limits", self.limits),
        ] {
            if let Some([low, high]) = range
                && low >= high
            {
                let problem = format!("is [{low}, {high}]; allowed: [minimum, maximum]");
                return refused(key, problem);
            }
        }
        let shares = self.initial_shares.0.len();
        if shares != 0 && shares != genes {
            let problem = format!("has {shares} numbers; allowed: one for each gene, {genes}, or none");
            return refused("evolution.initial_shares", problem);
        }
        (self.kind.entry().check)(self, surroundings)
    }

    /// What has an effect only with another value of this table.
    pub fn needs(&self) -> Vec<Need> {
        let mut needs = vec![Need::new(
            &["evolution.initial_shares"],
            self.init.is_none(),
            "without evolution.init",
            &["evolution.init"],
        )];
        needs.extend(breeding::needs(self));
        needs.extend(Kind::entries().flat_map(|entry| (entry.needs)(self)));
        needs
    }

    /// Whether the course of its generations does not depend on their number, so that it can go on for more.
    pub fn is_open_ended(&self) -> bool {
        !self.is(Feature::SetsGenerations)
    }

    /// Whether all individuals of a generation have the same random numbers.
    pub fn has_common_numbers(&self) -> bool {
        self.common == Some(true)
    }

    /// Whether two populations evolve against each other.
    pub fn is_coevolution(&self) -> bool {
        self.is(Feature::TwoPopulations)
    }

    /// Whether individuals are recorded where an experiment does not say so.
    pub fn records_individuals(&self) -> bool {
        !self.is(Feature::Unrecorded)
    }

    /// Individuals that are evaluated in all generations, at most.
    pub fn evaluations(&self) -> u64 {
        (self.kind.entry().evaluations)(self)
    }

    /// Genomes evaluated in each generation: the individuals, or the pairs of two populations' individuals.
    pub fn genomes_per_generation(&self) -> u32 {
        if self.is_coevolution() {
            return self
                .population
                .saturating_mul(2)
                .saturating_mul(self.tables.opponents.contests);
        }
        self.population
    }

    /// Maximum number of genomes of earlier generations that the optimiser keeps: elites of an archive, or the best of all generations.
    pub fn genomes_kept(&self) -> u64 {
        if self.is_coevolution() {
            u64::from(self.generations)
        } else if self.has_archive() {
            (self.cells() as u64).min(self.evaluations())
        } else {
            0
        }
    }

    /// Number of a genome's random numbers in its generation: its index, or where they are common, its episode's among
    /// those of an individual.
    pub fn lot(&self, index: u32) -> u32 {
        match (self.has_common_numbers(), self.is_coevolution()) {
            (false, _) => index,
            (true, true) => index % self.tables.opponents.contests,
            (true, false) => 0,
        }
    }

    /// Number of the random numbers of a generation: its own, but one for a whole grid where they are common.
    pub fn draw(&self, generation: u32) -> u32 {
        if self.is(Feature::OneDraw) && self.has_common_numbers() {
            return 0;
        }
        generation
    }

    /// Whether the optimiser uses behaviour.
    pub fn uses_behaviour(&self) -> bool {
        self.is(Feature::Behaviour)
    }

    /// Whether the optimiser keeps an archive of elites.
    pub fn has_archive(&self) -> bool {
        self.is(Feature::Archive)
    }

    /// How many of the best the statistics of a generation call its parents: those that become parents, or those that an evolution
    /// strategy moves to; else a fifth of the population, as in Miglino et al. 1995.
    pub fn best(&self) -> u32 {
        if self.has_parents() {
            self.parents
        } else {
            let part = if self.is(Feature::AdaptsCovariances) { 2 } else { 5 };
            (self.population / part).max(1)
        }
    }
}

/// Default populations that differ from everyone's, in words.
fn populations() -> String {
    let mut groups: Vec<(&str, Vec<&str>)> = Vec::new();
    for entry in Kind::entries().filter(|entry| !entry.population.is_empty()) {
        match groups.last_mut() {
            Some((words, names)) if *words == entry.population => names.push(entry.name),
            _ => groups.push((entry.population, vec![entry.name])),
        }
    }
    let words = groups.iter().map(|(words, names)| match &names[..] {
        [name] => format!("{name} has {words}"),
        names => format!("{} have {words}", names.join(" and ")),
    });
    words.collect::<Vec<_>>().join("; ")
}

/// Rows of all values, in the order of a file.
#[rustfmt::skip]
pub fn rows<T: AsMut<Settings>>() -> Vec<Parameter<T>> {
    const OURS: &str = "ours";
    let gene = Number(-f64::from(GREATEST_GENE), GREATEST_GENE.into());
    let mut rows: Vec<Parameter<T>> = vec![
        row("evolution.kind", "", Any, OURS,
            "The optimiser: see docs/optimisers.md; default: genetic.", |values, _| Some(&mut values.as_mut().kind)),
        row("evolution.population", "", Whole(1, 1_000_000), "Miglino et al. 1995, section 3.4",
            format!("Individuals; default: {}.", populations()).leak(), |values, _| Some(&mut values.as_mut().population)),
        row("evolution.parents", "", WholeUpTo(1, "evolution.population"), "Miglino et al. 1995, section 3.4",
            "Number of the best that have children, with truncation or uniform selection; default: 20, or the largest divisor of the population up to a fifth of it where 20 does not divide it.", |values, _| Some(&mut values.as_mut().if_has_parents()?.parents)),
        row("evolution.episodes", "", Whole(1, 1_000_000_000_000), OURS,
            "Instead of `evolution.generations`: maximum episodes of a run. Counted are individuals x trials of each generation (with coevolution x `evolution.opponents.contests`, and the last pair), including unchanged and re-evaluated individuals, and the finalists' episodes. An episode that is replayed for its trace counts once. The number of generations follows from it; with grid, the levels; with race, the candidates' episodes.", |values, _| Some(&mut values.as_mut().budget)),
        row("evolution.generations", "", Whole(1, MOST_GENERATIONS.into()), "Miglino et al. 1995, section 3.4",
            "Generations that are evaluated.", |values, _| Some(&mut values.as_mut().if_counts_generations()?.generations)),
        row("evolution.elite", "", WholeUpTo(0, "evolution.population"), "ours: none mentioned in Miglino et al. 1995, section 3.4",
            "Number of the best that survive unchanged; with truncation at most evolution.parents.", |values, _| Some(&mut values.as_mut().genetic()?.elite)),
        row("evolution.common_random_numbers", "", Any, OURS,
            "Whether all individuals of a generation have the same random numbers, including starts; default: false, but true with open-es, and always with race.", |values, _| Some(&mut values.as_mut().common)),
        row("evolution.initial", "", gene, "ours: no range in Miglino et al. 1995, section 3.4",
            "Range of the uniform initial genes.", |values, _| Some(&mut values.as_mut().initial)),
        row("evolution.initial_shares", "", Number(0.0, 1e6), OURS,
            "Central fraction of that range for random genes: a number for each gene; default: 1 for all.", |values, _| Some(&mut values.as_mut().if_draws_genes()?.initial_shares)),
        row("evolution.init", "", Text("a file of genomes, or a run's directory"), OURS,
            "Genomes to begin with, as `--genomes` takes them: a file, or a run's directory for its champion. Evolution strategies begin at their mean; of others they are the first individuals.", |values, _| Some(&mut values.as_mut().if_takes_genomes()?.init)),
        row("evolution.limits", "", gene, OURS,
            "Bounds of genes; default: none.", |values, _| Some(&mut values.as_mut().limits)),
    ];
    rows.extend(breeding::rows());
    rows.extend(strategy::rows());
    rows.extend(descriptors::rows());
    rows.extend(Tables::rows());
    rows
}

/// A number for each gene, or none.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Shares(pub Vec<f64>);

impl Shares {
    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn of(&self, gene: usize) -> f64 {
        self.0.as_slice().get(gene).copied().unwrap_or(1.0)
    }
}

impl Field for Shares {
    fn get(&self) -> Option<Datum> {
        (!self.is_empty()).then(|| Datum::List(self.0.iter().copied().map(Datum::Double).collect()))
    }

    fn set(&mut self, datum: &Datum) -> bool {
        let number = |datum: &Datum| {
            let mut number = 0.0_f64;
            number.set(datum).then_some(number)
        };
        let numbers = match datum {
            Datum::List(list) => list.iter().map(number).collect::<Option<_>>(),
            _ => None,
        };
        let is_set = numbers.is_some();
        if let Some(numbers) = numbers {
            self.0 = numbers;
        }
        is_set
    }

    fn kind(&self) -> &'static str {
        "a list of numbers"
    }
}

/// The range of each gene that has one. It replaces the initial range and the limits, and the amount of a mutation is
/// as large in it as in the initial range.
pub type Ranges = Vec<Option<[f32; 2]>>;

/// Where genes may be.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Space(Vec<Place>);

/// Where a gene begins, and its minimum and maximum.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    initial: [f64; 2],
    /// The central fraction of that for random genes.
    share: f64,
    bounds: [f64; 2],
}

impl Place {
    /// Where a random gene begins.
    fn first(&self) -> Uniform {
        let [low, high] = self.initial;
        let apart = 0.5 * (1.0 - self.share) * (high - low);
        // Without a share, exactly the range.
        Uniform {
            low: low + apart,
            high: high - apart,
        }
    }
}

impl Space {
    pub(crate) fn new(settings: &Settings, ranges: &Ranges) -> Self {
        let place = |(gene, &range): (usize, &_)| Place {
            initial: initial_range(settings, range),
            share: settings.initial_shares.of(gene),
            bounds: bounds(settings, range),
        };
        Self(ranges.iter().enumerate().map(place).collect())
    }

    /// Genes.
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// This many random genomes, one after the other.
    pub(crate) fn drawn(&self, count: u32, random: &mut impl Rng) -> Vec<f32> {
        let genomes = (0..count).flat_map(|_| &self.0);
        genomes
            .map(|place| kept(place.first().sample(random), place.bounds))
            .collect()
    }

    /// The central fraction of a gene's initial range, in which it begins if it is random.
    pub(crate) fn share(&self, gene: usize) -> f64 {
        self.0[gene].share
    }

    /// A gene at a place that counts from the middle of its initial range, in halves of that.
    pub(crate) fn gene(&self, gene: usize, at: f64) -> f32 {
        let Place {
            initial: [low, high],
            bounds,
            ..
        } = self.0[gene];
        kept(0.5 * (low + high) + 0.5 * (high - low) * at, bounds)
    }

    /// The genes at such places.
    pub(crate) fn genome(&self, at: &[f64]) -> Vec<f32> {
        at.iter().enumerate().map(|(gene, at)| self.gene(gene, *at)).collect()
    }

    /// Half of a gene's initial range.
    pub(crate) fn half(&self, gene: usize) -> f64 {
        let [low, high] = self.0[gene].initial;
        0.5 * (high - low)
    }

    /// The mean of genomes, in such places, within the bounds.
    pub(crate) fn mean(&self, genomes: &Population) -> Vec<f64> {
        let count = genomes.len() as f64;
        let mean = |gene: usize| {
            let [low, high] = self.0[gene].initial;
            let sum: f64 = genomes.genomes().map(|genome| f64::from(genome[gene])).sum();
            let [least, greatest] = self.bounds(gene);
            ((sum / count - 0.5 * (low + high)) / (0.5 * (high - low))).clamp(least, greatest)
        };
        (0..self.len()).map(mean).collect()
    }

    /// A gene within its bounds.
    pub(crate) fn kept(&self, gene: usize, value: f64) -> f32 {
        kept(value, self.0[gene].bounds)
    }

    /// The place of a gene's bounds, counted in the same way.
    pub(crate) fn bounds(&self, gene: usize) -> [f64; 2] {
        let Place {
            initial: [low, high],
            bounds,
            ..
        } = self.0[gene];
        bounds.map(|bound| (bound - 0.5 * (low + high)) / (0.5 * (high - low)))
    }
}

/// The range of a gene's initial values.
pub(crate) fn initial_range(settings: &Settings, range: Option<[f32; 2]>) -> [f64; 2] {
    range.map_or(settings.initial, |ends| ends.map(f64::from))
}

/// The minimum and the maximum of a gene: those of its range or the limits.
pub(crate) fn bounds(settings: &Settings, range: Option<[f32; 2]>) -> [f64; 2] {
    range
        .map(|ends| ends.map(f64::from))
        .or(settings.limits)
        .unwrap_or([-f64::from(GREATEST_GENE), f64::from(GREATEST_GENE)])
}

/// Clamps a gene to its bounds, and replaces a subnormal one by +0, as batches require.
pub(crate) fn kept(gene: f64, [least, greatest]: [f64; 2]) -> f32 {
    let gene = gene.clamp(least, greatest) as f32;
    if gene.is_normal() { gene } else { 0.0 }
}
