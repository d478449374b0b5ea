//! The table `[evolution]` of an experiment: the optimiser, its values, and for how many generations it runs.

use oneiro::batch::GREATEST_GENE;
use oneiro::parameter::{Choice, Choices, Datum, Field};
use oneiro::world::Gene;
use rand::Rng;
use rand::distr::Distribution;
use serde::{Deserialize, Serialize};

use super::random::Uniform;

/// An optimiser.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kind {
    #[default]
    Genetic,
    CmaEs,
    SepCmaEs,
    OpenEs,
    MapElites,
    Novelty,
    Random,
    Grid,
    Race,
    Coevolution,
}

impl Choice for Kind {
    const CHOICES: Choices<Self> = &[
        (
            "genetic",
            Self::Genetic,
            "a genetic algorithm; by default that of Miglino et al. 1995",
        ),
        (
            "cma-es",
            Self::CmaEs,
            "evolution strategy with a full covariance matrix, up to 100 genes: Hansen 2016",
        ),
        (
            "sep-cma-es",
            Self::SepCmaEs,
            "the same with a diagonal matrix, for any number of genes: Ros and Hansen 2008",
        ),
        (
            "open-es",
            Self::OpenEs,
            "evolution strategy with mirrored samples, ranks and Adam: Salimans et al. 2017",
        ),
        (
            "map-elites",
            Self::MapElites,
            "an archive of the best of each kind of behaviour: Mouret and Clune 2015",
        ),
        (
            "novelty",
            Self::Novelty,
            "the genetic algorithm, selecting by how new a behaviour is: Lehman and Stanley 2011",
        ),
        ("random", Self::Random, "random genomes in every generation: a control"),
        (
            "grid",
            Self::Grid,
            "every combination of evenly spaced genes once: an exhaustive search",
        ),
        (
            "race",
            Self::Race,
            "an iterated race, in which candidates drop out by a test on ranks: López-Ibáñez et al. 2016 (irace)",
        ),
        (
            "coevolution",
            Self::Coevolution,
            "two populations that the genetic algorithm breeds by contests with each other: Floreano and Nolfi 1997",
        ),
    ];

    /// Experiments from before there was a choice keep their identity.
    fn is_written(&self) -> bool {
        *self != Self::Genetic
    }
}

/// The optimiser, its values, and for how many generations it runs. Values of other optimisers are not used.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// The optimiser.
    pub kind: Kind,
    /// Individuals.
    pub population: u32,
    /// How many of the best may become parents.
    pub parents: u32,
    /// Generations that are evaluated.
    pub generations: u32,
    /// How many of the best also keep one copy as they are.
    pub elite: u32,
    /// Whether all individuals of a generation live with the same random numbers; each has its own where nothing is given.
    pub common: Option<bool>,
    /// Range of the uniform initial genes.
    pub initial: [f64; 2],
    /// The share of that range, around its middle, that random genes begin in, gene by gene; all of it where nothing is given.
    #[serde(skip_serializing_if = "Shares::is_empty")]
    pub initial_shares: Shares,
    /// A file of initial genes instead.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub init: Option<String>,
    /// Range that genes are kept within.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limits: Option<[f64; 2]>,
    pub selection: Selection,
    pub crossover: Crossover,
    pub mutation: Mutation,
    pub strategy: Strategy,
    /// Measures of behaviour, of optimisers that use it.
    pub descriptors: Vec<Descriptor>,
    pub archive: Archive,
    pub novelty: Novelty,
    #[serde(skip_serializing_if = "Grid::is_default")]
    pub grid: Grid,
    #[serde(skip_serializing_if = "Race::is_default")]
    pub race: Race,
    #[serde(skip_serializing_if = "Opponents::is_default")]
    pub opponents: Opponents,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            kind: Kind::Genetic,
            population: 100,
            parents: 20,
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
            archive: Archive::default(),
            novelty: Novelty::default(),
            grid: Grid::default(),
            race: Race::default(),
            opponents: Opponents::default(),
        }
    }
}

/// Values that are the experiment's only with some optimisers.
impl Settings {
    /// With the genetic algorithm, also if it selects by novelty.
    pub fn genetic(&mut self) -> Option<&mut Self> {
        self.is_genetic().then_some(self)
    }

    /// With an optimiser whose first individuals may be given.
    pub fn begun(&mut self) -> Option<&mut Self> {
        (self.is_genetic() || self.kind == Kind::MapElites).then_some(self)
    }

    /// With an optimiser that begins at random genes.
    pub fn drawing(&mut self) -> Option<&mut Self> {
        (!matches!(self.kind, Kind::CmaEs | Kind::SepCmaEs | Kind::Race | Kind::Grid)).then_some(self)
    }

    /// With an optimiser that uses behaviour.
    pub fn behaving(&mut self) -> Option<&mut Self> {
        self.uses_behaviour().then_some(self)
    }

    /// With an archive of elites.
    pub fn archived(&mut self) -> Option<&mut Archive> {
        (self.kind == Kind::MapElites).then_some(&mut self.archive)
    }

    /// With novelty search.
    pub fn novel(&mut self) -> Option<&mut Novelty> {
        (self.kind == Kind::Novelty).then_some(&mut self.novelty)
    }

    /// With an exhaustive search.
    pub fn gridded(&mut self) -> Option<&mut Grid> {
        (self.kind == Kind::Grid).then_some(&mut self.grid)
    }

    /// With a race.
    pub fn racing(&mut self) -> Option<&mut Race> {
        (self.kind == Kind::Race).then_some(&mut self.race)
    }

    /// With two populations.
    pub fn opposed(&mut self) -> Option<&mut Opponents> {
        self.is_coevolution().then_some(&mut self.opponents)
    }

    /// With an optimiser whose generations are counted.
    pub fn counted(&mut self) -> Option<&mut Self> {
        (!matches!(self.kind, Kind::Race | Kind::Grid)).then_some(self)
    }

    /// With the genetic algorithm, if only the best become parents.
    pub fn truncated(&mut self) -> Option<&mut Self> {
        self.has_parents().then_some(self)
    }

    /// With the genetic algorithm, if there is crossover.
    pub fn crossed(&mut self) -> Option<&mut Crossover> {
        let crossover = &mut self.genetic()?.crossover;
        (crossover.kind != CrossoverKind::None).then_some(crossover)
    }

    /// With the genetic algorithm, if the chance of a mutation has a unit to choose.
    pub fn mutated_by_unit(&mut self) -> Option<&mut Mutation> {
        let mutation = &mut self.genetic()?.mutation;
        mutation.kind.has_unit().then_some(mutation)
    }

    /// With the genetic algorithm, if genes change by an amount.
    pub fn mutated_by_amount(&mut self) -> Option<&mut Mutation> {
        let mutation = &mut self.genetic()?.mutation;
        (mutation.kind != MutationKind::FlipBits).then_some(mutation)
    }

    /// With the genetic algorithm, if genes are words of bits.
    pub fn mutated_by_bits(&mut self) -> Option<&mut Mutation> {
        let mutation = &mut self.genetic()?.mutation;
        (mutation.kind == MutationKind::FlipBits).then_some(mutation)
    }

    /// With an evolution strategy.
    pub fn strategy(&mut self) -> Option<&mut Strategy> {
        matches!(self.kind, Kind::CmaEs | Kind::SepCmaEs | Kind::OpenEs).then_some(&mut self.strategy)
    }

    /// With an evolution strategy that adapts covariances.
    pub fn adapting(&mut self) -> Option<&mut Strategy> {
        (self.kind != Kind::OpenEs).then_some(self.strategy()?)
    }

    /// With an evolution strategy that follows a gradient.
    pub fn climbing(&mut self) -> Option<&mut Strategy> {
        (self.kind == Kind::OpenEs).then_some(self.strategy()?)
    }

    /// Gives what a file does not give the optimiser's own default.
    pub fn complete(&mut self, genes: usize, trials: u32, has_population: bool) {
        if self.kind == Kind::Race {
            self.race.trials = trials;
            // No generation has fewer than two.
            self.generations = u32::try_from(self.race.evaluations() / 2 + 1).unwrap_or(u32::MAX);
            self.common.get_or_insert(true);
        }
        if !has_population {
            self.population = match self.kind {
                Kind::CmaEs | Kind::SepCmaEs => super::cma::default_population(genes),
                Kind::OpenEs => 40,
                Kind::Race => self.race.greatest_population(genes),
                Kind::Grid => self.grid.default_population(genes),
                _ => self.population,
            };
        }
        if self.kind == Kind::Grid {
            let generations = self.grid.combinations(genes) / u64::from(self.population);
            self.generations = u32::try_from(generations).unwrap_or(u32::MAX);
        }
        let sigma = match self.kind {
            Kind::CmaEs | Kind::SepCmaEs => 0.5,
            Kind::OpenEs => 0.02,
            _ => return,
        };
        self.strategy.sigma.get_or_insert(sigma);
        self.common.get_or_insert(self.kind == Kind::OpenEs);
    }

    /// Whether all individuals of a generation live with the same random numbers.
    pub fn has_common_numbers(&self) -> bool {
        self.common == Some(true)
    }

    /// Whether a genetic algorithm breeds.
    pub fn is_genetic(&self) -> bool {
        matches!(self.kind, Kind::Genetic | Kind::Novelty | Kind::Coevolution)
    }

    /// Whether two populations live against each other.
    pub fn is_coevolution(&self) -> bool {
        self.kind == Kind::Coevolution
    }

    /// Genomes that live in each generation: the individuals, or the contests of two populations' individuals.
    pub fn lived(&self) -> u32 {
        if self.is_coevolution() {
            return self
                .population
                .saturating_mul(2)
                .saturating_mul(self.opponents.contests);
        }
        self.population
    }

    /// Number of the random numbers of a genome in its generation: its own, or where they are common, that of its contest among those
    /// of an individual.
    pub fn lot(&self, index: u32) -> u32 {
        match (self.has_common_numbers(), self.is_coevolution()) {
            (false, _) => index,
            (true, true) => index % self.opponents.contests,
            (true, false) => 0,
        }
    }

    /// Number of the random numbers of a generation: its own, but one for a whole grid where they are common.
    pub fn draw(&self, generation: u32) -> u32 {
        if self.kind == Kind::Grid && self.has_common_numbers() {
            return 0;
        }
        generation
    }

    /// Whether the optimiser uses behaviour.
    pub fn uses_behaviour(&self) -> bool {
        matches!(self.kind, Kind::MapElites | Kind::Novelty)
    }

    /// Whether the optimiser keeps an archive of elites.
    pub fn has_archive(&self) -> bool {
        self.kind == Kind::MapElites
    }

    /// Cells of the archive.
    pub fn cells(&self) -> usize {
        match self.archive.cells {
            Cells::Grid => self.descriptors.iter().map(|own| own.cells as usize).product(),
            Cells::Centroidal => self.archive.centroids as usize,
        }
    }

    /// Whether only the best become parents.
    fn has_parents(&self) -> bool {
        self.is_genetic() && self.selection.kind.is_of_the_best()
    }

    /// How many of the best the statistics of a generation call its parents: those that become parents, or those that an evolution
    /// strategy moves to; else a fifth of the population, as in Miglino et al. 1995.
    pub fn best(&self) -> u32 {
        match self.kind {
            _ if self.has_parents() => self.parents,
            Kind::CmaEs | Kind::SepCmaEs => (self.population / 2).max(1),
            _ => (self.population / 5).max(1),
        }
    }
}

/// A number for each gene, or none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
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
        let own = match datum {
            Datum::List(list) => list.iter().map(number).collect::<Option<_>>(),
            _ => None,
        };
        let is_set = own.is_some();
        if let Some(own) = own {
            self.0 = own;
        }
        is_set
    }

    fn kind(&self) -> &'static str {
        "a list of numbers"
    }
}

/// How parents are chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Selection {
    pub kind: SelectionKind,
    /// Of ranks: how many children the best has, if an average individual has one.
    pub pressure: f64,
    /// Of a roulette wheel: the same.
    pub scaling: f64,
    /// Of tournaments: individuals in each.
    pub size: u32,
}

impl Default for Selection {
    fn default() -> Self {
        Self {
            kind: SelectionKind::Truncation,
            pressure: 2.0,
            scaling: 2.0,
            size: 2,
        }
    }
}

/// A kind of selection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SelectionKind {
    Truncation,
    Uniform,
    Rank,
    Roulette,
    Tournament,
}

impl SelectionKind {
    /// Whether only `parents` of the best have children.
    pub(crate) fn is_of_the_best(self) -> bool {
        matches!(self, Self::Truncation | Self::Uniform)
    }
}

impl Choice for SelectionKind {
    const CHOICES: Choices<Self> = &[
        (
            "truncation",
            Self::Truncation,
            "the best, with equally many children each",
        ),
        ("uniform", Self::Uniform, "each child's is drawn from the best"),
        (
            "rank",
            Self::Rank,
            "drawn from all, by a chance that falls linearly with the rank: Baker 1985",
        ),
        (
            "roulette",
            Self::Roulette,
            "drawn from all, by a chance that rises linearly with fitness: Goldberg 1989",
        ),
        (
            "tournament",
            Self::Tournament,
            "the best of some that are drawn from all",
        ),
    ];

    /// Experiments from before there was a choice keep their identity.
    fn is_written(&self) -> bool {
        *self != Self::Truncation
    }
}

/// How a child's genes come from two parents.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Crossover {
    pub kind: CrossoverKind,
    /// The chance of a child to have two parents.
    pub rate: f64,
    /// Of the uniform kind: the chance of each gene to be the second parent's.
    pub share: f64,
}

impl Default for Crossover {
    fn default() -> Self {
        Self {
            kind: CrossoverKind::None,
            rate: 0.5,
            share: 0.5,
        }
    }
}

/// A kind of crossover.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CrossoverKind {
    None,
    OnePoint,
    TwoPoint,
    Uniform,
}

impl Choice for CrossoverKind {
    const CHOICES: Choices<Self> = &[
        ("none", Self::None, "each child has one parent"),
        (
            "one_point",
            Self::OnePoint,
            "from one place on, the genes are the second parent's",
        ),
        (
            "two_point",
            Self::TwoPoint,
            "between two places, the genes are the second parent's",
        ),
        (
            "uniform",
            Self::Uniform,
            "each gene by itself may be the second parent's",
        ),
    ];

    /// Experiments from before there was a choice keep their identity.
    fn is_written(&self) -> bool {
        *self != Self::None
    }
}

/// Mutation of children.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mutation {
    /// The change of a gene.
    pub kind: MutationKind,
    /// The chance of a change.
    pub rate: f64,
    /// Whether the chance is drawn for each gene or each individual.
    pub per: MutationUnit,
    /// Size of the change.
    pub amount: f64,
    /// Bits of a gene.
    #[serde(skip_serializing_if = "Mutation::has_default_bits")]
    pub bits: u32,
}

impl Mutation {
    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
    fn has_default_bits(bits: &u32) -> bool {
        *bits == Self::default().bits
    }
}

impl Default for Mutation {
    fn default() -> Self {
        Self {
            kind: MutationKind::AddUniform,
            rate: 0.25,
            per: MutationUnit::Gene,
            amount: 1.0,
            bits: 5,
        }
    }
}

/// A kind of mutation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MutationKind {
    AddUniform,
    AddNormal,
    Replace,
    AddVector,
    EvoStick,
    FlipBits,
}

impl MutationKind {
    /// Whether the chance is of a gene or of an individual, as the experiment says; else it is of an individual.
    pub(crate) fn has_unit(self) -> bool {
        !matches!(self, Self::AddVector | Self::EvoStick | Self::FlipBits)
    }
}

impl Choice for MutationKind {
    const CHOICES: Choices<Self> = &[
        (
            "add_uniform",
            Self::AddUniform,
            "adds a number drawn uniformly between minus and plus the amount",
        ),
        (
            "add_normal",
            Self::AddNormal,
            "adds a normally distributed number, with the amount as its standard deviation",
        ),
        ("replace", Self::Replace, "draws the gene again from the initial range"),
        (
            "add_vector",
            Self::AddVector,
            "adds a vector of random direction to all genes; its length is normally distributed, with the amount as its standard \
             deviation; the rate is the probability that an individual changes",
        ),
        (
            "evostick",
            Self::EvoStick,
            "as in EvoStick: adds a uniformly distributed number, replaces the gene by one, or leaves it; the rate is the probability \
             that an individual's mutation is severe (docs/optimisers.md)",
        ),
        (
            "flip_bits",
            Self::FlipBits,
            "flips bits: each gene is an integer of `bits` bits, mapped evenly onto its initial range; the rate is the probability that a bit flips",
        ),
    ];
}

/// The unit that the chance of mutation is drawn for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MutationUnit {
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

/// Values of evolution strategies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Strategy {
    /// Standard deviation of the first samples, or of all, in halves of the initial range; given once complete.
    pub sigma: Option<f64>,
    /// Whether the worse half of the samples shrinks the covariances.
    pub active: bool,
    /// Whether a strategy that can't go on begins again.
    pub restarts: bool,
    /// Adam's step.
    pub learning_rate: f64,
    /// How strongly genes are drawn to the middle of their initial range.
    pub weight_decay: f64,
}

impl Default for Strategy {
    fn default() -> Self {
        Self {
            sigma: None,
            active: true,
            restarts: true,
            learning_rate: 0.01,
            weight_decay: 0.005,
        }
    }
}

/// A measure of behaviour that an optimiser uses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Descriptor {
    /// Its name.
    pub measure: String,
    /// Its range; NaN until it is given.
    pub least: f32,
    pub greatest: f32,
    /// Cells that a grid divides the range into.
    pub cells: u32,
}

impl Default for Descriptor {
    fn default() -> Self {
        Self {
            measure: String::new(),
            least: f32::NAN,
            greatest: f32::NAN,
            cells: 20,
        }
    }
}

impl Descriptor {
    /// A value as a share of the range.
    pub fn share(&self, value: f64) -> f64 {
        let [least, greatest] = [self.least, self.greatest].map(f64::from);
        (value - least) / (greatest - least)
    }

    #[cfg(test)]
    pub(super) fn named(measure: &str, [least, greatest]: [f32; 2], cells: u32) -> Self {
        Self {
            measure: measure.into(),
            least,
            greatest,
            cells,
        }
    }
}

/// Values of an archive of elites.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Archive {
    pub cells: Cells,
    /// Cells, if they are not a grid's.
    pub centroids: u32,
    /// Standard deviations of variation: of each gene, in halves of the initial range, and along the line to another elite.
    pub iso: f64,
    pub line: f64,
    /// Elites of each generation that are evaluated again.
    pub reevaluated: u32,
    pub acceptance: Acceptance,
    /// The fitness that counts as nothing in the QD score.
    pub offset: f64,
}

impl Default for Archive {
    fn default() -> Self {
        Self {
            cells: Cells::Grid,
            centroids: 1000,
            iso: 0.01,
            line: 0.2,
            reevaluated: 0,
            acceptance: Acceptance::Optimistic,
            offset: 0.0,
        }
    }
}

/// How an archive's cells divide behaviour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Cells {
    Grid,
    Centroidal,
}

impl Choice for Cells {
    const CHOICES: Choices<Self> = &[
        ("grid", Self::Grid, "each descriptor's range is divided evenly"),
        (
            "centroidal",
            Self::Centroidal,
            "regions of equal size around centroids: Vassiliades et al. 2018",
        ),
    ];
}

/// What elites are compared by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Acceptance {
    Optimistic,
    Mean,
}

impl Choice for Acceptance {
    const CHOICES: Choices<Self> = &[
        (
            "optimistic",
            Self::Optimistic,
            "the best score that they ever had, in the cell of that life",
        ),
        (
            "mean",
            Self::Mean,
            "the mean of all their scores, in the cell of their mean behaviour",
        ),
    ];
}

/// Values of novelty search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Novelty {
    /// Nearest behaviours whose mean distance is the novelty.
    pub neighbours: u32,
    /// Behaviours of each generation that are kept, drawn at random.
    pub added: u32,
}

impl Default for Novelty {
    fn default() -> Self {
        Self {
            neighbours: 15,
            added: 6,
        }
    }
}

/// Values of an exhaustive search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// Values of each gene.
    pub levels: u32,
}

impl Default for Grid {
    fn default() -> Self {
        Self { levels: 11 }
    }
}

impl Grid {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Combinations of the values of all genes.
    pub fn combinations(&self, genes: usize) -> u64 {
        u64::from(self.levels).saturating_pow(u32::try_from(genes).unwrap_or(u32::MAX))
    }

    /// A generation: all combinations of the last genes, as many as make up to 10,000 individuals.
    fn default_population(&self, genes: usize) -> u32 {
        let powers = (1..=genes).map(|genes| self.combinations(genes));
        let largest = powers.take_while(|&count| count <= 10_000).last();
        largest.map_or(self.levels, |count| count as u32)
    }
}

/// Values of a race.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Race {
    /// Lives of all candidates.
    pub lives: u64,
    /// Lives of a candidate in a generation: those of the experiment.
    pub trials: u32,
    /// Generations before the first test.
    pub first_test: u32,
    /// Of the test.
    pub confidence: f64,
}

impl Default for Race {
    fn default() -> Self {
        Self {
            lives: 200_000,
            trials: 1,
            first_test: 5,
            confidence: 0.95,
        }
    }
}

impl Race {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Candidates that may live for a generation.
    pub fn evaluations(&self) -> u64 {
        self.lives / u64::from(self.trials.max(1))
    }

    /// Candidates of the first race.
    fn greatest_population(&self, genes: usize) -> u32 {
        let iterations = super::race::few(genes) as u64;
        let count = self.evaluations() / iterations / (u64::from(self.first_test) + 1);
        u32::try_from(count)
            .unwrap_or(u32::MAX)
            .clamp(iterations as u32 + 1, 100_000)
    }
}

/// Who the individuals of two populations meet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Opponents {
    pub kind: OpponentKind,
    /// Of recent ones: of how many generations.
    pub generations: u32,
    /// Contests of each individual in a generation.
    pub contests: u32,
    /// Name of the first gene of the second population's genomes.
    pub first_gene: String,
    /// What the scores of both sides of a contest add up to.
    pub total: f64,
}

impl Default for Opponents {
    fn default() -> Self {
        Self {
            kind: OpponentKind::Recent,
            generations: 10,
            contests: 10,
            first_gene: String::new(),
            total: 1.0,
        }
    }
}

impl Opponents {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Genes of the first population's genomes; `None` if the second's have none or all.
    pub fn split(&self, genes: &[Gene]) -> Option<usize> {
        let first = genes.iter().position(|gene| gene.name == self.first_gene);
        first.filter(|first| *first > 0)
    }
}

/// Which of the other population's best an individual meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum OpponentKind {
    Recent,
    HallOfFame,
}

impl Choice for OpponentKind {
    const CHOICES: Choices<Self> = &[
        (
            "recent",
            Self::Recent,
            "the best of the last generations, the last first",
        ),
        (
            "hall-of-fame",
            Self::HallOfFame,
            "the best of generations that are drawn from all earlier ones, anew in each generation",
        ),
    ];
}

/// The range of each gene that has one of its own. It replaces the initial range and the limits, and the amount of a mutation
/// is as large in it as in the initial range.
pub type Ranges = Vec<Option<[f32; 2]>>;

/// Where genes may be.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Space(Vec<Place>);

/// Where a gene begins, and its least and greatest value.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    initial: [f64; 2],
    /// The share of that, around its middle, in which random genes begin.
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
    pub(super) fn new(settings: &Settings, ranges: &Ranges) -> Self {
        let place = |(gene, &own): (usize, &_)| Place {
            initial: initial_range(settings, own),
            share: settings.initial_shares.of(gene),
            bounds: bounds(settings, own),
        };
        Self(ranges.iter().enumerate().map(place).collect())
    }

    /// Genes.
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// This many random genomes, one after the other.
    pub(super) fn drawn(&self, count: u32, random: &mut impl Rng) -> Vec<f32> {
        let genomes = (0..count).flat_map(|_| &self.0);
        genomes
            .map(|place| kept(place.first().sample(random), place.bounds))
            .collect()
    }

    /// The share of a gene's initial range, around its middle, in which it begins if it is random.
    pub(super) fn share(&self, gene: usize) -> f64 {
        self.0[gene].share
    }

    /// A gene at a place that counts from the middle of its initial range, in halves of that.
    pub(super) fn gene(&self, gene: usize, at: f64) -> f32 {
        let Place {
            initial: [low, high],
            bounds,
            ..
        } = self.0[gene];
        kept(0.5 * (low + high) + 0.5 * (high - low) * at, bounds)
    }

    /// Half of a gene's initial range.
    pub(super) fn half(&self, gene: usize) -> f64 {
        let [low, high] = self.0[gene].initial;
        0.5 * (high - low)
    }

    /// A gene within its bounds.
    pub(super) fn kept(&self, gene: usize, value: f64) -> f32 {
        kept(value, self.0[gene].bounds)
    }

    /// The place of a gene's bounds, counted in the same way.
    pub(super) fn bounds(&self, gene: usize) -> [f64; 2] {
        let Place {
            initial: [low, high],
            bounds,
            ..
        } = self.0[gene];
        bounds.map(|bound| (bound - 0.5 * (low + high)) / (0.5 * (high - low)))
    }
}

/// The range of a gene's initial values.
pub(super) fn initial_range(settings: &Settings, own: Option<[f32; 2]>) -> [f64; 2] {
    own.map_or(settings.initial, |range| range.map(f64::from))
}

/// The least and the greatest value of a gene: those of its range or the limits.
pub(super) fn bounds(settings: &Settings, own: Option<[f32; 2]>) -> [f64; 2] {
    own.map(|range| range.map(f64::from))
        .or(settings.limits)
        .unwrap_or([-f64::from(GREATEST_GENE), f64::from(GREATEST_GENE)])
}

/// Clamps a gene to its bounds, and replaces a subnormal one by +0, as batches require.
pub(super) fn kept(gene: f64, [least, greatest]: [f64; 2]) -> f32 {
    let gene = gene.clamp(least, greatest) as f32;
    if gene.is_normal() { gene } else { 0.0 }
}
