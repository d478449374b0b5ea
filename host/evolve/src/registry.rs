//! Entries of the registry of optimisers. The registry is in `lib.rs`: one line an optimiser, from which its name, rows, checks and
//! documentation follow.

use oneiro::parameter::Parameter;
use oneiro::world::Gene;

use super::settings::budget::count_generations;
use super::settings::{Checked, Feature, Given, GivenGenomes, Need, Ranges, Settings, Surroundings};
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
    /// What it makes of given genomes.
    pub(crate) start: GivenGenomes,
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
    /// The most individuals that it offers as finalists, by the number of genes.
    pub(crate) survivors: fn(usize) -> u32,
    /// Sets what follows from a budget of episodes.
    pub(crate) spend: Spend,
}

/// Sets what follows from a budget of episodes. Besides the settings it takes whether an experiment gives a key, and how many
/// individuals all generations may have with some settings.
pub(crate) type Spend = fn(&mut Settings, Given, &dyn Fn(&str) -> bool, &dyn Fn(&Settings) -> u64);

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
            start: GivenGenomes::Mean,
            population: "",
            begin,
            complete: |_, _| (),
            check: |_, _| Ok(()),
            needs: |_| Vec::new(),
            evaluations: |settings| u64::from(settings.genomes_per_generation()) * u64::from(settings.generations),
            survivors: |_| u32::MAX,
            spend: |settings, _, _, left| count_generations(settings, left(settings)),
        }
    }
}

/// What an optimiser begins with.
pub(crate) struct Beginning<'a> {
    pub(crate) settings: &'a Settings,
    pub(crate) seed: u64,
    /// The controller's genes.
    pub(crate) genes: &'a [Gene],
    /// The genomes to begin with, if they are given: as many as [`most_given`](super::most_given) at most.
    pub(crate) init: Option<Population>,
}

impl Beginning<'_> {
    /// The genes' ranges.
    pub(crate) fn ranges(&self) -> Ranges {
        self.genes.iter().map(|gene| gene.range).collect()
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
