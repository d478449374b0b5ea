//! Conditions of an evolution's values, and their refusals.

use std::fmt::Display;

use oneiro::parameter::Invalid;
use oneiro::world::Gene;

/// Where an optimiser differs from most others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Feature {
    /// It breeds as the genetic algorithm does, by its values.
    Breeds,
    /// It does not begin at random genes.
    SetsFirstGenes,
    /// The number of its generations follows from its other values.
    SetsGenerations,
    /// It adapts covariances, and moves to the better half of its samples.
    AdaptsCovariances,
    /// It follows a gradient.
    FollowsGradient,
    /// It keeps an archive of elites.
    Archive,
    /// Two populations evolve against each other.
    TwoPopulations,
    /// It needs measures of behaviour.
    Behaviour,
    /// Its individuals are recorded only if an experiment asks for it.
    Unrecorded,
    /// Common random numbers are the same in all its generations.
    OneDraw,
}

/// The use that an optimiser has for given genomes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GivenGenomes {
    /// Nothing, for this reason, in words that follow its name.
    None(&'static str),
    /// Its first samples are drawn around their mean.
    Mean,
    /// They are the first individuals; the others are as described.
    First(&'static str),
}

/// What defaults may depend on.
#[derive(Clone, Copy)]
pub(crate) struct Given {
    pub(crate) genes: usize,
    /// Episodes of each individual.
    pub(crate) trials: u32,
    /// Whether the experiment says how many individuals there are.
    pub(crate) has_population: bool,
}

/// What checks may depend on besides the table `[evolution]`.
pub struct Surroundings<'a> {
    /// The controller's genes.
    pub genes: &'a [Gene],
    /// Whether all individuals are recorded.
    pub records_individuals: bool,
    /// Whether the last generations run on a robot.
    pub has_robot: bool,
}

pub(crate) type Checked = Result<(), Invalid>;

/// Refuses a key's value: `problem` is the value and what is allowed.
pub(crate) fn refused(key: &str, problem: impl Display) -> Checked {
    Err(Invalid {
        field: key.into(),
        problem: problem.to_string(),
    })
}

/// Keys that have an effect only under a condition.
pub struct Need {
    /// Keys, or tables of keys.
    pub keys: Vec<String>,
    pub is_met: bool,
    /// The condition, in words that follow "only".
    pub only: &'static str,
    /// Keys that decide whether it is met.
    pub by: &'static [&'static str],
}

impl Need {
    pub fn new(keys: &[&str], is_met: bool, only: &'static str, by: &'static [&'static str]) -> Self {
        let keys = keys.iter().map(|key| (*key).to_owned()).collect();
        Self { keys, is_met, only, by }
    }
}
