//! Controllers of `AutoMoDe`'s modules: probabilistic finite [state machines](Machine) and [behaviour trees](Tree), as genomes and in
//! `AutoMoDe`'s text form. `shaders/wgsl/controller/modules.wgsl` has the modules, which use the readings of [`Model::Vectors`](crate::reference::Model::Vectors).
//!
//! Sources: the modules, their parameters and the machines are those of github.com/demiurge-project/AutoMoDe-private (the modules
//! commit 7e0b0c10, exploration 17d758bf; the ranges `optimization/grammar.txt`, commit 8c346f31), which is the program of
//! Francesca et al. 2014 and 2015; exploration's range of turns is that of the first paper. Trees are those of `AutoMoDe-Maple`
//! (Kuckling, Ligot, Bozhinoski and Birattari 2018), by the same program (nodes commit 4a671660, the tree ad2d3658, texts 00262d2d).

mod behaviour_tree;
mod state_machine;
mod text;

use std::sync::LazyLock;

use crate::genes::{Gene, GeneKind, GeneLayout};

pub(crate) use behaviour_tree::genes as tree_genes;
pub(crate) use state_machine::genes as machine_genes;

pub use behaviour_tree::{Branch, GREATEST_BRANCHES, Tree};
pub use state_machine::{GREATEST_STATES, GREATEST_TRANSITIONS, Machine, MachineState, Transition};
pub use text::BadText;

/// Ranges of values, in genomes and in texts: the numbers of behaviours and of conditions, and their values.
const MODULES: [u32; 2] = [0, 5];
const TURNS: [u32; 2] = [1, 100];
const STRENGTHS: [f32; 2] = [1.0, 5.0];
const PROBABILITIES: [f32; 2] = [0.0, 1.0];
/// A genome has at least 1; a text may have 0.
const NEIGHBOURS: [u32; 2] = [0, 10];
const STEEPNESSES: [f32; 2] = [0.0, 20.0];

/// Values of the modules that no gene has; what is `None` has its default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Modules {
    /// Length of the vector of proximity from which on exploration turns away. Default: 0.1.
    pub obstacle: Option<f32>,
    /// Weight of that vector in phototaxis, anti-phototaxis and repulsion. Default: 5.
    pub avoidance: Option<f32>,
    /// The same in attraction. Default: 6.
    pub attraction_avoidance: Option<f32>,
    /// Robots drive straight ahead instead of along shorter vectors. Default: 0.1.
    pub least_vector: Option<f32>,
    /// The inner wheel's minimum speed in a curve, as a fraction of the outer one's. Default: -0.5.
    pub slowest_wheel: Option<f32>,
}

impl Modules {
    /// All defaults.
    pub const DEFAULT: Self = Self {
        obstacle: None,
        avoidance: None,
        attraction_avoidance: None,
        least_vector: None,
        slowest_wheel: None,
    };

    /// The values set in the kernel's `ControllerValues`, by name. The kernel has the defaults of the others.
    pub(crate) fn given(&self) -> Vec<(&'static str, f64)> {
        let all = [
            ("obstacle", self.obstacle),
            ("avoidance", self.avoidance),
            ("attraction_avoidance", self.attraction_avoidance),
            ("least_vector", self.least_vector),
            ("slowest_wheel", self.slowest_wheel),
        ];
        all.into_iter()
            .filter_map(|(name, value)| Some((name, value?.into())))
            .collect()
    }
}

/// A behaviour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Behaviour {
    /// Straight ahead; from obstacles ahead it turns away for a random number of cycles.
    Exploration {
        /// Most of them, 1 to 100.
        turning: u32,
    },
    /// It stands.
    Stop,
    /// Toward the light.
    Phototaxis,
    /// Away from it.
    AntiPhototaxis,
    /// Toward other robots.
    Attraction {
        /// Weight of the others, 1 to 5.
        strength: f32,
    },
    /// Away from them.
    Repulsion {
        /// Weight of the others, 1 to 5.
        strength: f32,
    },
}

/// A condition, which holds with a probability in each cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Condition {
    /// With this probability on a black floor.
    BlackFloor(f32),
    /// On one that is neither black nor white.
    GreyFloor(f32),
    /// On a white one.
    WhiteFloor(f32),
    /// With `1 / (1 + e^(steepness (neighbours - n)))` for `n` robots that are heard.
    NeighbourCount(Crowd),
    /// With 1 less that.
    InvertedNeighbourCount(Crowd),
    /// With this probability everywhere.
    FixedProbability(f32),
}

/// Values of the conditions that count neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crowd {
    /// Neighbours with which the probability is one half, 0 to 10.
    pub neighbours: u32,
    /// How fast it changes with their number, 0 to 20.
    pub steepness: f32,
}

impl Behaviour {
    /// What it is called.
    pub fn word(self) -> &'static str {
        match self {
            Self::Exploration { .. } => "exploration",
            Self::Stop => "stop",
            Self::Phototaxis => "phototaxis",
            Self::AntiPhototaxis => "anti-phototaxis",
            Self::Attraction { .. } => "attraction",
            Self::Repulsion { .. } => "repulsion",
        }
    }

    /// Its number in `AutoMoDe`, and in a genome.
    fn number(self) -> u32 {
        match self {
            Self::Exploration { .. } => 0,
            Self::Stop => 1,
            Self::Phototaxis => 2,
            Self::AntiPhototaxis => 3,
            Self::Attraction { .. } => 4,
            Self::Repulsion { .. } => 5,
        }
    }

    /// Decodes it from its genes.
    fn of(genes: &[f32]) -> Self {
        let strength = genes[2].clamp(STRENGTHS[0], STRENGTHS[1]);
        match whole(genes[0], MODULES) {
            0 => Self::Exploration {
                turning: whole(genes[1], TURNS),
            },
            1 => Self::Stop,
            2 => Self::Phototaxis,
            3 => Self::AntiPhototaxis,
            4 => Self::Attraction { strength },
            _ => Self::Repulsion { strength },
        }
    }

    fn put(self, genes: &mut [f32]) {
        genes[0] = within(self.number());
        match self {
            Self::Exploration { turning } => genes[1] = within(turning),
            Self::Attraction { strength } | Self::Repulsion { strength } => genes[2] = strength,
            Self::Stop | Self::Phototaxis | Self::AntiPhototaxis => {}
        }
    }
}

impl Condition {
    fn number(self) -> u32 {
        match self {
            Self::BlackFloor(_) => 0,
            Self::GreyFloor(_) => 1,
            Self::WhiteFloor(_) => 2,
            Self::NeighbourCount(_) => 3,
            Self::InvertedNeighbourCount(_) => 4,
            Self::FixedProbability(_) => 5,
        }
    }

    /// Decodes it from its genes.
    fn of(genes: &[f32]) -> Self {
        let probability = genes[1].clamp(PROBABILITIES[0], PROBABILITIES[1]);
        let crowd = Crowd {
            neighbours: whole(genes[2], NEIGHBOURS),
            steepness: genes[3].clamp(STEEPNESSES[0], STEEPNESSES[1]),
        };
        match whole(genes[0], MODULES) {
            0 => Self::BlackFloor(probability),
            1 => Self::GreyFloor(probability),
            2 => Self::WhiteFloor(probability),
            3 => Self::NeighbourCount(crowd),
            4 => Self::InvertedNeighbourCount(crowd),
            _ => Self::FixedProbability(probability),
        }
    }

    fn put(self, genes: &mut [f32]) {
        genes[0] = within(self.number());
        match self {
            Self::BlackFloor(probability)
            | Self::GreyFloor(probability)
            | Self::WhiteFloor(probability)
            | Self::FixedProbability(probability) => genes[1] = probability,
            Self::NeighbourCount(crowd) | Self::InvertedNeighbourCount(crowd) => {
                genes[2] = within(crowd.neighbours);
                genes[3] = crowd.steepness;
            }
        }
    }
}

/// Of one to four parts: the counts with which the first, second, third or fourth is there.
const AT_LEAST: [&[u32]; 4] = [&[1, 2, 3, 4], &[2, 3, 4], &[3, 4], &[4]];

/// Genes of a behaviour: which one, and its values.
const BEHAVIOUR_GENES: usize = 3;
/// Genes of a condition: which one, and its values.
const CONDITION_GENES: usize = 4;

/// When a gene matters: a gene's index, and the whole numbers of it with which.
type Only = Option<(usize, &'static [u32])>;

fn gene(name: String, kind: GeneKind, range: [f32; 2], only: Only) -> Gene {
    Gene {
        name,
        range: Some(range),
        kind,
        only,
    }
}

/// The genes of a behaviour, of which the first has this index.
fn behaviour_genes(of: &str, first: usize, only: Only) -> [Gene; BEHAVIOUR_GENES] {
    let name = |name: &str| format!("{of}_{name}");
    [
        gene(name("behaviour"), GeneKind::Choice, wholes(MODULES), only),
        gene(
            name("turning_cycles"),
            GeneKind::Whole,
            wholes(TURNS),
            Some((first, &[0])),
        ),
        gene(name("strength"), GeneKind::Number, STRENGTHS, Some((first, &[4, 5]))),
    ]
}

/// The same of a condition.
fn condition_genes(of: &str, first: usize, only: Only) -> [Gene; CONDITION_GENES] {
    let name = |name: &str| format!("{of}_{name}");
    let fixed: Only = Some((first, &[0, 1, 2, 5]));
    let counted: Only = Some((first, &[3, 4]));
    [
        gene(name("condition"), GeneKind::Choice, wholes(MODULES), only),
        gene(name("probability"), GeneKind::Number, PROBABILITIES, fixed),
        gene(name("neighbours"), GeneKind::Whole, wholes([1, NEIGHBOURS[1]]), counted),
        gene(name("steepness"), GeneKind::Number, STEEPNESSES, counted),
    ]
}

/// The range of a gene that stands for whole numbers: it ends before the next one.
fn wholes([least, greatest]: [u32; 2]) -> [f32; 2] {
    [least as f32, (greatest + 1) as f32]
}

/// The whole number that a gene stands for.
fn whole(gene: f32, [least, greatest]: [u32; 2]) -> u32 {
    gene.floor().clamp(least as f32, greatest as f32) as u32
}

/// A gene that stands for a whole number.
fn within(whole: u32) -> f32 {
    whole as f32 + 0.5
}

/// A genome in the middle of all ranges, for genes without effect.
fn middle(genes: &[Gene]) -> Vec<f32> {
    let middle = |gene: &Gene| {
        let [least, greatest] = gene.range.unwrap_or_default();
        f32::midpoint(least, greatest)
    };
    genes.iter().map(middle).collect()
}

/// Genomes that also have a text form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// [`Machine`]
    StateMachine,
    /// [`Tree`]
    BehaviourTree,
}

impl Form {
    /// That of controllers with these genes.
    pub fn of(layout: &GeneLayout) -> Option<Self> {
        // Each run of a sweep asks: their names are written once.
        static MACHINE: LazyLock<Vec<Gene>> = LazyLock::new(machine_genes);
        static TREE: LazyLock<Vec<Gene>> = LazyLock::new(tree_genes);
        if layout.controller() == *MACHINE {
            Some(Self::StateMachine)
        } else if layout.controller() == *TREE {
            Some(Self::BehaviourTree)
        } else {
            None
        }
    }

    /// The genes of the controller that a text stands for.
    ///
    /// # Errors
    /// Those of [`Machine::parse`] and [`Tree::parse`].
    pub fn genome(self, text: &str) -> Result<Vec<f32>, BadText> {
        match self {
            Self::StateMachine => Ok(Machine::parse(text)?.genome()),
            Self::BehaviourTree => Ok(Tree::parse(text)?.genome()),
        }
    }

    /// What its memory calls the number of what acts: a state or a branch.
    pub fn acting(self) -> &'static str {
        match self {
            Self::StateMachine => "state",
            Self::BehaviourTree => "branch",
        }
    }

    /// The behaviours of a genome's states or branches.
    ///
    /// # Panics
    /// If there are not as many genes as such a controller has.
    pub fn behaviours(self, genome: &[f32]) -> Vec<Behaviour> {
        match self {
            Self::StateMachine => Machine::of(genome).states.iter().map(|state| state.behaviour).collect(),
            Self::BehaviourTree => Tree::of(genome)
                .branches
                .iter()
                .map(|branch| branch.behaviour)
                .collect(),
        }
    }

    /// The text of a genome, with a line for each of its controllers.
    ///
    /// # Panics
    /// If there are not as many genes as such controllers have.
    pub fn text(self, genome: &[f32]) -> String {
        let (genes, text): (_, fn(&[f32]) -> String) = match self {
            Self::StateMachine => (machine_genes().len(), |genome| Machine::of(genome).to_string()),
            Self::BehaviourTree => (tree_genes().len(), |genome| Tree::of(genome).to_string()),
        };
        let lines: Vec<String> = genome.chunks(genes).map(text).collect();
        lines.join("\n")
    }
}
