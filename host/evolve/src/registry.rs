//! Entries of the registry of optimisers. The registry is in `lib.rs`: one line an optimiser, from which its name, rows, checks and
//! documentation follow.

use std::fmt::Display;

use oneiro::parameter::{Invalid, Parameter};
use oneiro::world::Gene;

use super::settings::{Ranges, Settings};
use super::{Optimizer, Population};

/// An optimiser's entry in the registry.
pub struct Entry {
    /// Its name in an experiment.
    pub name: &'static str,
    /// What it is, and its source.
    pub about: &'static str,
    /// When to use it.
    pub suits: &'static str,
    /// Where it differs from most others.
    pub(crate) features: &'static [Feature],
    /// Its default population in words that follow "has"; empty if that is everyone's.
    pub(crate) population: &'static str,
    /// Makes it, before its first generation.
    pub(crate) begin: fn(Beginning<'_>) -> Box<dyn Optimizer>,
    /// Gives values that are not given their defaults.
    pub(crate) complete: fn(&mut Settings, Given),
    /// Checks its values.
    pub(crate) check: fn(&Settings, &Surroundings<'_>) -> Checked,
    /// What has an effect only with another of its values.
    pub(crate) needs: fn(&Settings) -> Vec<Need>,
    /// Individuals that are evaluated in all generations, at most.
    pub(crate) evaluations: fn(&Settings) -> u64,
}

impl Entry {
    /// An optimiser that begins at random genes, runs for the experiment's number of generations, and has nothing to
    /// check.
    pub(crate) const fn new(
        [name, about, suits]: [&'static str; 3],
        begin: fn(Beginning<'_>) -> Box<dyn Optimizer>,
    ) -> Self {
        Self {
            name,
            about,
            suits,
            features: &[],
            population: "",
            begin,
            complete: |_, _| (),
            check: |_, _| Ok(()),
            needs: |_| Vec::new(),
            evaluations: |settings| u64::from(settings.genomes_per_generation()) * u64::from(settings.generations),
        }
    }
}

/// Where an optimiser differs from most others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Feature {
    /// It breeds as the genetic algorithm does, by its values.
    Breeds,
    /// Its first individuals may be given.
    TakesGenomes,
    /// It does not begin at random genes.
    SetsFirstGenes,
    /// The number of its generations follows from its other values.
    SetsGenerations,
    /// It adapts covariances, and moves to the better half of its samples.
    AdaptsCovariances,
    /// It follows a gradient.
    FollowsGradient,
    /// It needs measures of behaviour.
    Behaviour,
    /// Its individuals are recorded only if an experiment asks for it.
    Unrecorded,
    /// Common random numbers are the same in all its generations.
    OneDraw,
}

/// What an optimiser begins with.
pub(crate) struct Beginning<'a> {
    pub(crate) settings: &'a Settings,
    pub(crate) seed: u64,
    /// The controller's genes.
    pub(crate) genes: &'a [Gene],
    /// The first individuals, if they are given.
    pub(crate) init: Option<Population>,
}

impl Beginning<'_> {
    /// The genes' ranges.
    pub(crate) fn ranges(&self) -> Ranges {
        self.genes.iter().map(|gene| gene.range).collect()
    }
}

/// What defaults may depend on.
#[derive(Clone, Copy)]
pub(crate) struct Given {
    pub(crate) genes: usize,
    /// Episodes of each individual.
    pub(crate) trials: u32,
    /// Whether the experiment gives the number of individuals.
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

/// Values of one optimiser, in a table of `[evolution]`.
pub(crate) trait Table: Default + PartialEq {
    /// Rows of the values.
    fn rows<T: AsMut<Settings>>() -> Vec<Parameter<T>>;

    /// Whether it is no part of the settings' hash: the hashes of experiments from before there was the optimiser stay.
    fn is_left_out(&self) -> bool {
        *self == Self::default()
    }
}

/// Makes the registry: a line has an optimiser's name in Rust and the path of its entry, and if it has values, the name of their table
/// and their type.
macro_rules! optimisers {
    ($($kind:ident: $entry:path $(, $table:ident: $values:ty)?;)*) => {
        /// An optimiser.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
        pub enum Kind {
            $(#[allow(missing_docs, reason = "its entry says what it is")] $kind,)*
        }

        impl Choice for Kind {
            const CHOICES: Choices<Self> = &[$(($entry.name, Self::$kind, $entry.about),)*];

            /// Experiments from before there was a choice keep their identity.
            fn is_written(&self) -> bool {
                *self != Self::default()
            }
        }

        impl Kind {
            /// Its entry.
            pub fn entry(self) -> &'static Entry {
                match self {
                    $(Self::$kind => &$entry,)*
                }
            }

            /// All entries.
            pub fn entries() -> impl Iterator<Item = &'static Entry> {
                [$(Self::$kind,)*].into_iter().map(Self::entry)
            }
        }

        /// Tables of values, each of one optimiser.
        #[derive(Clone, Debug, Default, PartialEq, Serialize)]
        pub struct Tables {
            $($(
                #[serde(skip_serializing_if = "Table::is_left_out")]
                #[allow(missing_docs, reason = "the type says what it is")]
                pub $table: $values,
            )?)*
        }

        impl Tables {
            /// Rows of all values.
            fn rows<T: AsMut<Settings>>() -> Vec<Parameter<T>> {
                let mut rows = Vec::new();
                $($(rows.extend(<$values as Table>::rows());)?)*
                rows
            }
        }

        impl Settings {
            $($(
                /// The table, with its optimiser.
                pub(crate) fn $table(&mut self) -> Option<&mut $values> {
                    (self.kind == Kind::$kind).then_some(&mut self.tables.$table)
                }
            )?)*
        }
    };
}
pub(crate) use optimisers;
