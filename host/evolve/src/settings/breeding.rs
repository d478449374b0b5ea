//! Values of the genetic algorithm, which also breeds the populations of novelty search and of coevolution.

use oneiro::batch::GREATEST_GENE;
use oneiro::parameter::Allowed::{Any, Number, Whole};
use oneiro::parameter::{Choice, Choices, Parameter, row};
use serde::Serialize;

use super::{Checked, Feature, Need, Settings, refused};

const OURS: &str = "ours";

/// How parents are chosen.
#[derive(Clone, Debug, PartialEq, Serialize)]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
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
            "the best of some randomly drawn individuals",
        ),
    ];

    /// Experiments from before there was a choice keep their identity.
    fn is_written(&self) -> bool {
        *self != Self::Truncation
    }
}

/// How a child's genes come from two parents.
#[derive(Clone, Debug, PartialEq, Serialize)]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize)]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
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
    /// Whether the experiment chooses if the chance is per gene or per individual; else it is per individual.
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
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

/// Values that are the experiment's only with some optimisers.
impl Settings {
    /// With the genetic algorithm, also if it selects by novelty.
    pub(crate) fn genetic(&mut self) -> Option<&mut Self> {
        self.is(Feature::Breeds).then_some(self)
    }

    /// With the genetic algorithm, if only the best become parents.
    pub(crate) fn if_has_parents(&mut self) -> Option<&mut Self> {
        self.has_parents().then_some(self)
    }

    /// With the genetic algorithm, if there is crossover.
    pub(crate) fn if_has_crossover(&mut self) -> Option<&mut Crossover> {
        let crossover = &mut self.genetic()?.crossover;
        (crossover.kind != CrossoverKind::None).then_some(crossover)
    }

    /// With the genetic algorithm, if the chance of a mutation has a unit to choose.
    pub(crate) fn if_mutates_by_unit(&mut self) -> Option<&mut Mutation> {
        let mutation = &mut self.genetic()?.mutation;
        mutation.kind.has_unit().then_some(mutation)
    }

    /// With the genetic algorithm, if genes change by an amount.
    pub(crate) fn if_mutates_by_amount(&mut self) -> Option<&mut Mutation> {
        let mutation = &mut self.genetic()?.mutation;
        (mutation.kind != MutationKind::FlipBits).then_some(mutation)
    }

    /// With the genetic algorithm, if genes are words of bits.
    pub(crate) fn if_mutates_by_bits(&mut self) -> Option<&mut Mutation> {
        let mutation = &mut self.genetic()?.mutation;
        (mutation.kind == MutationKind::FlipBits).then_some(mutation)
    }

    /// Whether only the best become parents.
    pub(crate) fn has_parents(&self) -> bool {
        self.is(Feature::Breeds) && self.selection.kind.is_of_the_best()
    }
}

/// Rows of these values.
#[rustfmt::skip]
pub(crate) fn rows<T: AsMut<Settings>>() -> Vec<Parameter<T>> {
    vec![
        row("evolution.selection.kind", "", Any, OURS,
            "How parents are selected; default: truncation.", |values, _| Some(&mut values.as_mut().genetic()?.selection.kind)),
        row("evolution.selection.pressure", "", Number(1.0, 2.0), "Baker 1985",
            "Children of the best for each child of an average individual; the last has 2 minus this.", |values, _| {
                let selection = &mut values.as_mut().genetic()?.selection;
                (selection.kind == SelectionKind::Rank).then_some(&mut selection.pressure)
            }),
        row("evolution.selection.scaling", "", Number(1.0, 10.0), "Goldberg 1989, linear scaling",
            "Children of the best for each child of an average individual; fewer where the worst would have fewer than 0.", |values, _| {
                let selection = &mut values.as_mut().genetic()?.selection;
                (selection.kind == SelectionKind::Roulette).then_some(&mut selection.scaling)
            }),
        row("evolution.selection.size", "", Whole(1, 1_000_000), OURS,
            "Individuals in a tournament.", |values, _| {
                let selection = &mut values.as_mut().genetic()?.selection;
                (selection.kind == SelectionKind::Tournament).then_some(&mut selection.size)
            }),
        row("evolution.crossover.kind", "", Any, "ours: none mentioned in Miglino et al. 1995, section 3.4",
            "How a child's genes come from two parents, before they are mutated; default: none.", |values, _| Some(&mut values.as_mut().genetic()?.crossover.kind)),
        row("evolution.crossover.rate", "", Number(0.0, 1.0), OURS,
            "Probability that a child has two parents.", |values, _| Some(&mut values.as_mut().if_has_crossover()?.rate)),
        row("evolution.crossover.share", "", Number(0.0, 1.0), OURS,
            "Probability that a gene of such a child is the second parent's.", |values, _| {
                let crossover = values.as_mut().if_has_crossover()?;
                (crossover.kind == CrossoverKind::Uniform).then_some(&mut crossover.share)
            }),
        row("evolution.mutation.kind", "", Any, OURS,
            "How mutation changes a gene.", |values, _| Some(&mut values.as_mut().genetic()?.mutation.kind)),
        row("evolution.mutation.rate", "", Number(0.0, 1.0), "Miglino et al. 1995, section 3.4",
            "Probability of a change.", |values, _| Some(&mut values.as_mut().genetic()?.mutation.rate)),
        row("evolution.mutation.per", "", Any, "ours: \"25%\", and not of what, in Miglino et al. 1995, section 3.4",
            "Whether that probability is per gene or per individual.", |values, _| Some(&mut values.as_mut().if_mutates_by_unit()?.per)),
        row("evolution.mutation.amount", "", Number(0.0, GREATEST_GENE.into()), "ours: no size in Miglino et al. 1995, section 3.4",
            "Size of the change: the maximum that is added, or its standard deviation; not with replace.", |values, _| Some(&mut values.as_mut().if_mutates_by_amount()?.amount)),
        row("evolution.mutation.bits", "bits", Whole(1, 16), "Floreano and Nolfi 1997",
            "Bits of a gene, where mutation flips them.", |values, _| Some(&mut values.as_mut().if_mutates_by_bits()?.bits)),
    ]
}

/// Checks what truncation needs.
pub(crate) fn check(settings: &Settings) -> Checked {
    let Settings {
        elite,
        parents,
        population,
        ..
    } = *settings;
    if settings.selection.kind != SelectionKind::Truncation {
        return Ok(());
    }
    if elite > parents {
        return refused(
            "evolution.elite",
            format_args!("is {elite}; allowed: 0 to {parents}, evolution.parents"),
        );
    }
    if !population.is_multiple_of(parents) {
        return refused(
            "evolution.parents",
            format_args!(
                "is {parents}; allowed: a divisor of the population, {population}, since each parent makes equally \
                 many copies"
            ),
        );
    }
    Ok(())
}

/// What has an effect only with another value.
pub(crate) fn needs(settings: &Settings) -> Vec<Need> {
    vec![Need::new(
        &["evolution.mutation.amount"],
        settings.mutation.kind != MutationKind::Replace,
        "with another evolution.mutation.kind than \"replace\"",
        &["evolution.mutation.kind"],
    )]
}
