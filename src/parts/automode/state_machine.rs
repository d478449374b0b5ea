//! Probabilistic finite state machines of [modules](super). `shaders/wgsl/controller/state_machine.wgsl` runs them.

use std::fmt::{self, Display};

use super::text::{BadText, Options, Words, write_behaviour, write_condition};
use super::{
    AT_LEAST, BEHAVIOUR_GENES, Behaviour, CONDITION_GENES, Condition, behaviour_genes, condition_genes, gene, middle,
    whole, wholes, within,
};
use crate::genes::{Gene, GeneKind};

/// Most states.
pub const GREATEST_STATES: usize = 4;
/// Most transitions from a state.
pub const GREATEST_TRANSITIONS: usize = 4;

const TRANSITION_GENES: usize = 1 + CONDITION_GENES;
const STATE_GENES: usize = BEHAVIOUR_GENES + 1 + GREATEST_TRANSITIONS * TRANSITION_GENES;

/// What its texts consist of.
const WORDS: Words = Words {
    may_begin: "--fsm-config",
    such_as: "--nstates, --s0, ..",
    whole: &["nstates"],
    numbered: &["s", "n", "rwm", "att", "rep", "c", "p", "w"],
    between: Some('x'),
    kind: "machine; allowed: options of its states, their behaviours, transitions and conditions",
};

/// Range of the gene for where a transition leads, a fraction of the other states.
const SHARES: [f32; 2] = [0.0, 1.0];

/// A machine. The first of its states is the one that it begins in.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// 1 to [`GREATEST_STATES`].
    pub states: Vec<MachineState>,
}

/// A state.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineState {
    /// What a robot does in it.
    pub behaviour: Behaviour,
    /// Up to [`GREATEST_TRANSITIONS`]; none of a machine's only state.
    pub transitions: Vec<Transition>,
}

/// A transition to another state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transition {
    /// That state's number among the others, from 0: `AutoMoDe` counts them without the state that the transition is from.
    pub to: usize,
    /// When it happens.
    pub condition: Condition,
}

/// The genes of a machine, in order.
pub(crate) fn genes() -> Vec<Gene> {
    let mut all = vec![gene(
        "states".into(),
        GeneKind::Whole,
        wholes([1, GREATEST_STATES as u32]),
        None,
    )];
    for state in 0..GREATEST_STATES {
        let first = all.len();
        let is_there = (state > 0).then_some((0, AT_LEAST[state]));
        all.extend(behaviour_genes(&format!("state_{state}"), first, is_there));
        all.push(gene(
            format!("state_{state}_transitions"),
            GeneKind::Whole,
            wholes([1, GREATEST_TRANSITIONS as u32]),
            Some((0, AT_LEAST[state.max(1)])),
        ));
        for (transition, &count) in AT_LEAST.iter().enumerate() {
            let name = format!("state_{state}_transition_{transition}");
            let is_there = Some((first + BEHAVIOUR_GENES, count));
            all.push(gene(format!("{name}_to"), GeneKind::Number, SHARES, is_there));
            all.extend(condition_genes(&name, all.len(), is_there));
        }
    }
    all
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
            states: states.map(|genes| MachineState::of(genes, count - 1)).collect(),
        }
    }

    /// The genome of a machine. Genes that have no effect are in the middle of their ranges.
    pub fn genome(&self) -> Vec<f32> {
        let mut genome = middle(&genes());
        let others = self.states.len() - 1;
        genome[0] = within(self.states.len() as u32);
        for (genes, state) in genome[1..].chunks_exact_mut(STATE_GENES).zip(&self.states) {
            state.put(genes, others);
        }
        genome
    }

    /// Reads `AutoMoDe`'s text form: `--nstates 2 --s0 0 --rwm0 50 --n0 1 --n0x0 0 --c0x0 3 --p0x0 8 --w0x0 2.5 --s1 1 ..`. Options may
    /// be in any order, `--fsm-config` may stand before them, and the only state of a machine may have `--n0 0`.
    ///
    /// # Errors
    /// The first word that is no option with its value, is given twice, is not of this machine, or not allowed; or the option that is
    /// missing, at the word after the last.
    pub fn parse(text: &str) -> Result<Self, BadText> {
        let mut options = Options::read(text, WORDS)?;
        let count = options.whole("--nstates", [1, GREATEST_STATES as u32])?;
        let others = count as usize - 1;
        let states = (0..count)
            .map(|state| MachineState::read(&mut options, state, others))
            .collect::<Result<_, _>>()?;
        options.finished()?;
        Ok(Self { states })
    }
}

impl MachineState {
    /// Decodes a state from its genes, in a machine with this number of other states.
    fn of(genes: &[f32], others: usize) -> Self {
        let (behaviour, genes) = genes.split_at(BEHAVIOUR_GENES);
        let count = if others == 0 {
            0
        } else {
            whole(genes[0], [0, GREATEST_TRANSITIONS as u32]) as usize
        };
        let transitions = genes[1..].chunks_exact(TRANSITION_GENES).take(count);
        Self {
            behaviour: Behaviour::of(behaviour),
            transitions: transitions.map(|genes| Transition::of(genes, others)).collect(),
        }
    }

    fn put(&self, genes: &mut [f32], others: usize) {
        let (behaviour, genes) = genes.split_at_mut(BEHAVIOUR_GENES);
        self.behaviour.put(behaviour);
        genes[0] = within(self.transitions.len() as u32);
        for (genes, transition) in genes[1..].chunks_exact_mut(TRANSITION_GENES).zip(&self.transitions) {
            transition.put(genes, others);
        }
    }

    fn read(options: &mut Options, state: u32, others: usize) -> Result<Self, BadText> {
        let behaviour = options.behaviour(&format!("--s{state}"), &state.to_string())?;
        let count = format!("--n{state}");
        // A machine's only state may say that it has none.
        let most = if others > 0 { GREATEST_TRANSITIONS as u32 } else { 0 };
        let count = if options.has(&count) {
            options.whole(&count, [0, most])?
        } else {
            0
        };
        let mut transition = |transition| {
            let place = format!("{state}x{transition}");
            let to = options.whole(&format!("--n{place}"), [0, others as u32 - 1])? as usize;
            let condition = options.condition(&place)?;
            Ok(Transition { to, condition })
        };
        Ok(Self {
            behaviour,
            transitions: (0..count).map(&mut transition).collect::<Result<_, _>>()?,
        })
    }
}

impl Transition {
    fn of(genes: &[f32], others: usize) -> Self {
        let share = genes[0].clamp(SHARES[0], SHARES[1]);
        Self {
            to: ((share * others as f32) as usize).min(others - 1),
            condition: Condition::of(&genes[1..]),
        }
    }

    fn put(&self, genes: &mut [f32], others: usize) {
        genes[0] = within(self.to as u32) / others as f32;
        self.condition.put(&mut genes[1..]);
    }
}

/// The text that [`Machine::parse`] reads, with the fewest digits that give the same numbers.
impl Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "--nstates {}", self.states.len())?;
        for (state, from) in self.states.iter().enumerate() {
            write_behaviour(f, &format!("--s{state}"), &state.to_string(), from.behaviour)?;
            if self.states.len() > 1 {
                write!(f, " --n{state} {}", from.transitions.len())?;
            }
            for (transition, Transition { to, condition }) in from.transitions.iter().enumerate() {
                let place = format!("{state}x{transition}");
                write!(f, " --n{place} {to}")?;
                write_condition(f, &place, *condition)?;
            }
        }
        Ok(())
    }
}
