//! Behaviour trees of [modules](super), as `AutoMoDe-Maple` has them. `shaders/wgsl/controller/behaviour_tree.wgsl` runs them.

use std::fmt::{self, Display};

use super::text::{BadText, Options, Words, write_behaviour, write_condition};
use super::{
    AT_LEAST, BEHAVIOUR_GENES, Behaviour, CONDITION_GENES, Condition, behaviour_genes, condition_genes, gene, middle,
    whole, wholes, within,
};
use crate::genes::{Gene, GeneKind};

/// Most branches of a tree.
pub const GREATEST_BRANCHES: usize = 4;

const BRANCH_GENES: usize = CONDITION_GENES + BEHAVIOUR_GENES;

/// Numbers of `AutoMoDe`'s nodes.
const SELECTOR: u32 = 0;
const SEQUENCE_WITH_MEMORY: u32 = 3;
const ACTION: u32 = 5;
const CONDITION: u32 = 6;

/// What its texts consist of.
const WORDS: Words = Words {
    may_begin: "--bt-config",
    such_as: "--nroot, --nchildroot, --n0, ..",
    whole: &["nroot", "nchildroot"],
    numbered: &["n", "nchild", "c", "p", "w", "a", "rwm", "att", "rep"],
    between: None,
    kind: "tree; allowed: options of its branches, their conditions and behaviours",
};

/// A tree: a sequence with memory. In each cycle it asks the condition of the branch that acted last. While that doesn't hold, the
/// branch's behaviour acts; if it does, the next branch is asked. If all from there on hold, the tree is asked once more from its first
/// branch; if all hold again, the robot stands for this cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree {
    /// 1 to [`GREATEST_BRANCHES`].
    pub branches: Vec<Branch>,
}

/// A branch: a selector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Branch {
    /// When the tree goes on to the next branch.
    pub condition: Condition,
    /// What a robot does else.
    pub behaviour: Behaviour,
}

/// The genes of a tree, in order.
pub(crate) fn genes() -> Vec<Gene> {
    let mut all = vec![gene(
        "branches".into(),
        GeneKind::Whole,
        wholes([1, GREATEST_BRANCHES as u32]),
        None,
    )];
    for (branch, &counts) in AT_LEAST.iter().enumerate() {
        let is_there = (branch > 0).then_some((0, counts));
        let name = format!("branch_{branch}");
        all.extend(condition_genes(&name, all.len(), is_there));
        all.extend(behaviour_genes(&name, all.len(), is_there));
    }
    all
}

impl Tree {
    /// The tree that a genome is, as the kernel reads it: any numbers are one.
    ///
    /// # Panics
    /// If there are not as many genes as a tree has.
    pub fn of(genes: &[f32]) -> Self {
        assert_eq!(genes.len(), 1 + GREATEST_BRANCHES * BRANCH_GENES, "genes of a tree");
        let count = whole(genes[0], [1, GREATEST_BRANCHES as u32]) as usize;
        let branch = |genes: &[f32]| Branch {
            condition: Condition::of(&genes[..CONDITION_GENES]),
            behaviour: Behaviour::of(&genes[CONDITION_GENES..]),
        };
        Self {
            branches: genes[1..].chunks_exact(BRANCH_GENES).take(count).map(branch).collect(),
        }
    }

    /// The genome of a tree. Genes that have no effect are in the middle of their ranges.
    pub fn genome(&self) -> Vec<f32> {
        let mut genome = middle(&genes());
        genome[0] = within(self.branches.len() as u32);
        for (genes, branch) in genome[1..].chunks_exact_mut(BRANCH_GENES).zip(&self.branches) {
            branch.condition.put(&mut genes[..CONDITION_GENES]);
            branch.behaviour.put(&mut genes[CONDITION_GENES..]);
        }
        genome
    }

    /// Reads `AutoMoDe`'s text form: `--nroot 3 --nchildroot 1 --n0 0 --nchild0 2 --n00 6 --c00 5 --p00 0.1 --n01 5 --a01 0 --rwm01 50`.
    /// Options may be in any order, `--bt-config` may stand before them, and a behaviour may have the probability 0: `--p01 0`.
    ///
    /// # Errors
    /// As [`Machine::parse`](super::Machine::parse). Other trees than these are refused.
    pub fn parse(text: &str) -> Result<Self, BadText> {
        let mut options = Options::read(text, WORDS)?;
        options.whole("--nroot", [SEQUENCE_WITH_MEMORY; 2])?;
        let count = options.whole("--nchildroot", [1, GREATEST_BRANCHES as u32])?;
        let branch = |branch| {
            options.whole(&format!("--n{branch}"), [SELECTOR; 2])?;
            options.whole(&format!("--nchild{branch}"), [2; 2])?;
            options.whole(&format!("--n{branch}0"), [CONDITION; 2])?;
            let condition = options.condition(&format!("{branch}0"))?;
            options.whole(&format!("--n{branch}1"), [ACTION; 2])?;
            let behaviour = options.behaviour(&format!("--a{branch}1"), &format!("{branch}1"))?;
            // The chance that a behaviour succeeds by itself, which Maple's don't.
            let chance = format!("--p{branch}1");
            if options.has(&chance) {
                options.whole(&chance, [0; 2])?;
            }
            Ok(Branch { condition, behaviour })
        };
        let branches = (0..count).map(branch).collect::<Result<_, _>>()?;
        options.finished()?;
        Ok(Self { branches })
    }
}

/// The text that [`Tree::parse`] reads, with the fewest digits that give the same numbers.
impl Display for Tree {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "--nroot {SEQUENCE_WITH_MEMORY} --nchildroot {}", self.branches.len())?;
        for (branch, of_branch) in self.branches.iter().enumerate() {
            write!(f, " --n{branch} {SELECTOR} --nchild{branch} 2 --n{branch}0 {CONDITION}")?;
            write_condition(f, &format!("{branch}0"), of_branch.condition)?;
            write!(f, " --n{branch}1 {ACTION}")?;
            write_behaviour(f, &format!("--a{branch}1"), &format!("{branch}1"), of_branch.behaviour)?;
        }
        Ok(())
    }
}
