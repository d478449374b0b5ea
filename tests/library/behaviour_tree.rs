//! Behaviour trees: each cycle beside a second program, written from `docs/controllers.md`; genomes and texts; the same bits everywhere;
//! refusals.

use oneiro::automode::{Branch, Condition, Form, Modules, Tree};
use oneiro::cpu::Cpu;
use oneiro::world::{Controller, World};

use crate::composed::Subject;
use crate::modules::{
    act, batch, check_refusal, drawn, evaluated, genome, holds, is_off, key_of, places, spec, subject,
};

const TREES: Controller = Controller::BehaviourTree(Modules::DEFAULT);

/// A robot as the second program has it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Memory {
    branch: usize,
    turning: [i32; 4],
}

/// The first branch whose condition doesn't hold, from one on.
fn open(tree: &Tree, from: usize, readings: &[f64], chances: [f64; 4]) -> Option<usize> {
    let holds = |branch: usize| chances[branch] < holds(tree.branches[branch].condition, readings[4], readings[5]);
    (from..tree.branches.len()).find(|branch| !holds(*branch))
}

/// What a robot does in a cycle, and its memory afterwards.
fn cycle(tree: &Tree, before: Memory, readings: &[f64], key: [u32; 2], step: u32) -> ([f64; 2], Memory) {
    let first = open(tree, before.branch, readings, drawn(key, step, 0));
    let Some(branch) = first.or_else(|| open(tree, 0, readings, drawn(key, step, 1))) else {
        return ([0.0; 2], Memory { branch: 0, ..before });
    };
    let mut after = Memory { branch, ..before };
    let behaviour = tree.branches[branch].behaviour;
    let (wheels, turning) = act(behaviour, readings, before.turning[branch], key, step);
    after.turning[branch] = turning;
    (wheels, after)
}

/// What the cycles of random trees came to.
#[derive(Debug, Default)]
struct Seen {
    /// Cycles whose outputs or memory are not those of the second program, of all.
    wrong: usize,
    all: usize,
    /// In which each branch acted.
    acted: [usize; 4],
    /// In which none did.
    rested: usize,
    /// In which a branch acted that is before the last one.
    again: usize,
}

fn seen(change: impl Fn(&mut Tree)) -> Seen {
    let world = World::new(spec(TREES, 20)).unwrap();
    let genomes: Vec<_> = (0..90).map(|life| genome(&world, life)).collect();
    let outcome = evaluated(&mut Cpu::new(Some(2)).unwrap(), &batch(&world, &genomes, 1));
    let [perceived, memory] = places(&world);
    let mut seen = Seen::default();
    for ((genome, trace), life) in genomes.iter().zip(&outcome.traces).zip(0..) {
        let mut tree = Tree::of(genome);
        change(&mut tree);
        let key = key_of(life);
        let mut own = Memory {
            branch: 0,
            turning: [0; 4],
        };
        for (step, (record, details)) in (0..).zip(trace.lines()) {
            let readings: Vec<_> = perceived
                .iter()
                .map(|&place| f64::from(f32::from_bits(details[place])))
                .collect();
            let (wheels, after) = cycle(&tree, own, &readings, key, step);
            let found = Memory {
                branch: details[memory[0]] as usize,
                turning: [1, 2, 3, 4].map(|at| details[memory[at]].cast_signed()),
            };
            seen.all += 1;
            seen.wrong += usize::from(found != after || is_off(wheels, [record.left, record.right]));
            if wheels == [0.0; 2] && after.branch == 0 {
                seen.rested += 1;
            } else {
                seen.acted[after.branch] += 1;
            }
            seen.again += usize::from(after.branch < own.branch);
            own = found;
        }
    }
    seen
}

#[test]
fn cycles_are_those_of_the_second_program() {
    let same = seen(|_| ());
    assert_eq!((same.wrong, same.all), (0, 90 * 100), "{same:?}");
    // All of a tree's ways are taken.
    assert!(
        same.acted.iter().all(|cycles| *cycles > 100) && same.rested > 100 && same.again > 100,
        "{same:?}"
    );
    // A tree that is another in one value is seen at once.
    let other = seen(|tree| {
        for Branch { condition, .. } in &mut tree.branches {
            if let Condition::FixedProbability(p) = condition {
                *p *= 0.9;
            }
        }
    });
    assert!(other.wrong > 10, "{other:?}");
}

/// Genome to tree to text and back, for trees of all kinds.
#[test]
fn genomes_and_texts_are_the_same_trees() {
    let world = World::new(spec(TREES, 1)).unwrap();
    let layout = world.gene_layout();
    assert_eq!(layout.genes(), 29);
    assert_eq!(Form::of(layout), Some(Form::BehaviourTree));
    let mut branches = [0; 5];
    for life in 0..2000 {
        let tree = Tree::of(&genome(&world, life));
        branches[tree.branches.len()] += 1;
        let text = tree.to_string();
        assert_eq!(Tree::parse(&text).unwrap(), tree, "{text}");
        assert_eq!(Tree::of(&tree.genome()), tree, "{text}");
        // Genes without an effect are those that the layout says.
        let genome = tree.genome();
        for (gene, own) in layout.all().iter().enumerate() {
            let is_active = |(of, values): (usize, &[u32])| values.contains(&(genome[of] as u32));
            // What is of a branch that isn't there has a number of branches at the end of its chain.
            let is_there = gene == 0 || (gene - 1) / 7 < tree.branches.len();
            let mut other = genome.clone();
            let [least, greatest] = own.range.unwrap();
            other[gene] = if genome[gene] < f32::midpoint(least, greatest) {
                greatest
            } else {
                least
            };
            let changes = Tree::of(&other) != tree;
            assert_eq!(
                changes,
                is_there && own.only.is_none_or(is_active),
                "{}: {text}",
                own.name
            );
        }
    }
    assert!(branches[1..].iter().all(|trees| *trees > 300), "{branches:?}");
}

#[test]
fn a_text_of_the_program() {
    let text = "--bt-config --nroot 3 --nchildroot 2 --n0 0 --nchild0 2 --n00 6 --c00 3 --p00 8 --w00 2.5 --n01 5 --a01 0 --rwm01 50 \
                --n1 0 --nchild1 2 --n10 6 --c10 5 --p10 0.1 --n11 5 --a11 5 --rep11 1.5";
    let tree = Tree::parse(text).unwrap();
    assert_eq!(format!("--bt-config {tree}"), text);
    // As published trees are written.
    let published = text.replace("--rwm01 50", "--rwm01 50 --p01 0");
    assert_eq!(Tree::parse(&published).unwrap(), tree);
    let refusal = |text: &str| Tree::parse(text).unwrap_err().to_string();
    for (from, to, expected) in [
        ("--nroot 3", "--nroot 2", "word 3: `--nroot` is `2`; allowed: 3"),
        (
            "--nchildroot 2",
            "--nchildroot 5",
            "word 5: `--nchildroot` is `5`; allowed: 1 to 4, whole",
        ),
        ("--n0 0", "--n0 1", "word 7: `--n0` is `1`; allowed: 0"),
        ("--nchild0 2", "--nchild0 3", "word 9: `--nchild0` is `3`; allowed: 2"),
        ("--n00 6", "--n00 5", "word 11: `--n00` is `5`; allowed: 6"),
        ("--c00 3", "--c00 6", "word 13: `--c00` is `6`; allowed: 0 to 5, whole"),
        ("--n01 5", "--n01 7", "word 19: `--n01` is `7`; allowed: 5"),
        (
            "--rwm01 50",
            "--rwm01 0",
            "word 23: `--rwm01` is `0`; allowed: 1 to 100, whole",
        ),
        (
            " --rep11 1.5",
            "",
            "word 38: `--rep11` is missing; allowed: given with its value",
        ),
        (
            "--rep11 1.5",
            "--rep11 1.5 --n2 0",
            "word 40: `--n2` is not of this tree; allowed: options of its branches, their conditions and behaviours",
        ),
        (
            "--rwm01 50",
            "--rwm01 50 --p01 0.5",
            "word 25: `--p01` is `0.5`; allowed: 0",
        ),
        (
            "--nroot 3",
            "nroot 3",
            "word 2: `nroot` is no option; allowed: --nroot, --nchildroot, --n0, .., each with its value",
        ),
    ] {
        assert!(text.contains(from), "{from}");
        assert_eq!(refusal(&text.replace(from, to)), expected);
    }
}

#[test]
fn robots_without_the_readings_are_refused() {
    check_refusal(&TREES);
}

/// Episodes that are pinned ([`crate::composed`]).
pub(crate) fn subjects() -> Vec<Subject> {
    let world = World::new(spec(TREES, 10)).unwrap();
    vec![subject("behaviour trees", &world)]
}
