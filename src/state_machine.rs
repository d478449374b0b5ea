//! Probabilistic finite state machines of `AutoMoDe`'s modules as genomes, and in `AutoMoDe`'s text form.
//! `shaders/wgsl/controller/state_machine.wgsl` runs them, over the readings of [`Model::Vectors`].
//!
//! Sources: the modules, their parameters and the machines are those of github.com/demiurge-project/AutoMoDe-private (the modules
//! commit 7e0b0c10, exploration 17d758bf; the ranges `optimization/grammar.txt`, commit 8c346f31), which is the program of
//! Francesca et al. 2014 and 2015; exploration's range of turns is that of the first paper.

mod text;

use std::sync::LazyLock;

use crate::parameter::Invalid;
use crate::reference::Model;
use crate::world::{Gene, GeneKind, GeneLayout};

pub use text::{BadText, parse};

/// Most states.
pub const GREATEST_STATES: usize = 4;
/// Most transitions from a state.
pub const GREATEST_TRANSITIONS: usize = 4;

const TRANSITION_GENES: usize = 5;
const STATE_GENES: usize = 4 + GREATEST_TRANSITIONS * TRANSITION_GENES;

/// Ranges of values, in genomes and in texts: the numbers of behaviours and of conditions, and their values.
const MODULES: [u32; 2] = [0, 5];
const TURNS: [u32; 2] = [1, 100];
const STRENGTHS: [f32; 2] = [1.0, 5.0];
const PROBABILITIES: [f32; 2] = [0.0, 1.0];
/// A genome has at least 1; a text may have 0.
const NEIGHBOURS: [u32; 2] = [0, 10];
const STEEPNESSES: [f32; 2] = [0.0, 20.0];
/// Range of the gene for where a transition leads, a share of the other states.
const SHARES: [f32; 2] = [0.0, 1.0];

/// Values of the modules that no gene has; what is `None` has its default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StateMachine {
    /// Length of the vector of proximity from which on exploration turns away. Default: 0.1.
    pub obstacle: Option<f32>,
    /// Weight of that vector in phototaxis, anti-phototaxis and repulsion. Default: 5.
    pub avoidance: Option<f32>,
    /// The same in attraction. Default: 6.
    pub attraction_avoidance: Option<f32>,
    /// Robots drive straight ahead instead of along shorter vectors. Default: 0.1.
    pub least_vector: Option<f32>,
    /// The inner wheel's least speed in a curve, as a share of the outer one's. Default: -0.5.
    pub slowest_wheel: Option<f32>,
}

impl StateMachine {
    /// All defaults.
    pub const DEFAULT: Self = Self {
        obstacle: None,
        avoidance: None,
        attraction_avoidance: None,
        least_vector: None,
        slowest_wheel: None,
    };

    /// Those of the kernel's `ControllerValues` that are given, by name. The kernel has the defaults of the others.
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

    /// Refuses robots without the readings that the modules use.
    pub(crate) fn check(model: Option<Model>) -> Result<(), Invalid> {
        if model == Some(Model::Vectors) {
            return Ok(());
        }
        let problem = "is `state-machine`; allowed: only with robot.model = \"rm1.1-vectors\"";
        Err(Invalid::new("controller.kind", problem))
    }
}

/// A machine. The first of its states is the one that it begins in.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// 1 to [`GREATEST_STATES`].
    pub states: Vec<State>,
}

/// A state.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// What a robot does in it.
    pub behaviour: Behaviour,
    /// Up to [`GREATEST_TRANSITIONS`]; none of a machine's only state.
    pub transitions: Vec<Transition>,
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
}

/// A transition to another state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    /// That state's number among the others, from 0: `AutoMoDe` counts them without the state that the transition is from.
    pub to: usize,
    /// When it happens.
    pub condition: Condition,
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
}

static LAYOUT: LazyLock<GeneLayout> = LazyLock::new(|| GeneLayout::of(genes()));

/// Whether a controller's genes are those of a state machine.
pub fn is_layout_of(layout: &GeneLayout) -> bool {
    *layout == *LAYOUT
}

/// The genes of a machine, in order.
pub(crate) fn genes() -> Vec<Gene> {
    use GeneKind::{Choice, Number, Whole};

    const AT_LEAST: [&[u32]; 4] = [&[1, 2, 3, 4], &[2, 3, 4], &[3, 4], &[4]];
    let gene = |name: String, kind, range, only| Gene {
        name,
        range: Some(range),
        kind,
        only,
    };
    let mut all = vec![gene("states".into(), Whole, wholes([1, GREATEST_STATES as u32]), None)];
    for state in 0..GREATEST_STATES {
        let first = all.len();
        let name = |of: &str| format!("state_{state}_{of}");
        let is_there = (state > 0).then_some((0, AT_LEAST[state]));
        all.extend([
            gene(name("behaviour"), Choice, wholes(MODULES), is_there),
            gene(name("turning_cycles"), Whole, wholes(TURNS), Some((first, &[0]))),
            gene(name("strength"), Number, STRENGTHS, Some((first, &[4, 5]))),
            gene(
                name("transitions"),
                Whole,
                wholes([1, GREATEST_TRANSITIONS as u32]),
                Some((0, AT_LEAST[state.max(1)])),
            ),
        ]);
        for (transition, &count) in AT_LEAST.iter().enumerate() {
            let name = |of: &str| format!("state_{state}_transition_{transition}_{of}");
            let (is_there, condition) = (Some((first + 3, count)), all.len() + 1);
            all.extend([
                gene(name("to"), Number, SHARES, is_there),
                gene(name("condition"), Choice, wholes(MODULES), is_there),
                gene(
                    name("probability"),
                    Number,
                    PROBABILITIES,
                    Some((condition, &[0, 1, 2, 5])),
                ),
                gene(
                    name("neighbours"),
                    Whole,
                    wholes([1, NEIGHBOURS[1]]),
                    Some((condition, &[3, 4])),
                ),
                gene(name("steepness"), Number, STEEPNESSES, Some((condition, &[3, 4]))),
            ]);
        }
    }
    all
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

impl Machine {
    /// The machine that a genome is, as the kernel reads it: any numbers are one.
    ///
    /// # Panics
    /// If there are not as many genes as a machine has.
    pub fn of(genes: &[f32]) -> Self {
        assert_eq!(genes.len(), 1 + GREATEST_STATES * STATE_GENES, "genes of a machine");
        let count = whole(genes[0], [1, GREATEST_STATES as u32]) as usize;
        let states = genes[1..].chunks_exact(STATE_GENES).take(count);
        Self {
            states: states.map(|genes| State::of(genes, count - 1)).collect(),
        }
    }

    /// The genome of a machine. Genes that have no effect are in the middle of their ranges.
    pub fn genome(&self) -> Vec<f32> {
        let middle = |gene: &Gene| {
            let [least, greatest] = gene.range.unwrap_or_default();
            f32::midpoint(least, greatest)
        };
        let mut genome: Vec<f32> = genes().iter().map(middle).collect();
        let others = self.states.len() - 1;
        genome[0] = within(self.states.len() as u32);
        for (genes, state) in genome[1..].chunks_exact_mut(STATE_GENES).zip(&self.states) {
            state.put(genes, others);
        }
        genome
    }
}

impl State {
    /// Decodes a state from its genes, in a machine with this number of other states.
    fn of(genes: &[f32], others: usize) -> Self {
        let strength = genes[2].clamp(STRENGTHS[0], STRENGTHS[1]);
        let behaviour = match whole(genes[0], MODULES) {
            0 => Behaviour::Exploration {
                turning: whole(genes[1], TURNS),
            },
            1 => Behaviour::Stop,
            2 => Behaviour::Phototaxis,
            3 => Behaviour::AntiPhototaxis,
            4 => Behaviour::Attraction { strength },
            _ => Behaviour::Repulsion { strength },
        };
        let count = if others == 0 {
            0
        } else {
            whole(genes[3], [0, GREATEST_TRANSITIONS as u32]) as usize
        };
        let transitions = genes[4..].chunks_exact(TRANSITION_GENES).take(count);
        Self {
            behaviour,
            transitions: transitions.map(|genes| Transition::of(genes, others)).collect(),
        }
    }

    fn put(&self, genes: &mut [f32], others: usize) {
        genes[0] = within(self.behaviour.number());
        match self.behaviour {
            Behaviour::Exploration { turning } => genes[1] = within(turning),
            Behaviour::Attraction { strength } | Behaviour::Repulsion { strength } => genes[2] = strength,
            Behaviour::Stop | Behaviour::Phototaxis | Behaviour::AntiPhototaxis => {}
        }
        genes[3] = within(self.transitions.len() as u32);
        for (genes, transition) in genes[4..].chunks_exact_mut(TRANSITION_GENES).zip(&self.transitions) {
            transition.put(genes, others);
        }
    }
}

impl Transition {
    fn of(genes: &[f32], others: usize) -> Self {
        let share = genes[0].clamp(SHARES[0], SHARES[1]);
        let probability = genes[2].clamp(PROBABILITIES[0], PROBABILITIES[1]);
        let crowd = Crowd {
            neighbours: whole(genes[3], NEIGHBOURS),
            steepness: genes[4].clamp(STEEPNESSES[0], STEEPNESSES[1]),
        };
        Self {
            to: ((share * others as f32) as usize).min(others - 1),
            condition: match whole(genes[1], MODULES) {
                0 => Condition::BlackFloor(probability),
                1 => Condition::GreyFloor(probability),
                2 => Condition::WhiteFloor(probability),
                3 => Condition::NeighbourCount(crowd),
                4 => Condition::InvertedNeighbourCount(crowd),
                _ => Condition::FixedProbability(probability),
            },
        }
    }

    fn put(&self, genes: &mut [f32], others: usize) {
        genes[0] = within(self.to as u32) / others as f32;
        genes[1] = within(self.condition.number());
        match self.condition {
            Condition::BlackFloor(probability)
            | Condition::GreyFloor(probability)
            | Condition::WhiteFloor(probability)
            | Condition::FixedProbability(probability) => genes[2] = probability,
            Condition::NeighbourCount(crowd) | Condition::InvertedNeighbourCount(crowd) => {
                genes[3] = within(crowd.neighbours);
                genes[4] = crowd.steepness;
            }
        }
    }
}
