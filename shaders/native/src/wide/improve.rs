//! Makes a function faster without changing its results: what is computed twice, what a loop computes anew in each turn, and what only
//! rare code needs.

use std::collections::{HashMap, HashSet};

use super::graph::{Args, BlockId, Graph, Inst, Value};
use super::operations::Op;

/// Which blocks all ways to a block lead through.
struct Dominators {
    /// For each block its number in the tree, and the number after the last block that it dominates.
    ranges: Vec<(u32, u32)>,
}

impl Dominators {
    /// All ways but those back to the head of a loop lead to blocks that come later in the order.
    fn new(graph: &Graph) -> Self {
        let mut nearest = vec![0; graph.blocks.len()];
        let mut depths = vec![0; graph.blocks.len()];
        let places = graph.places();
        for &block in &graph.order[1..] {
            let earlier = graph.blocks[block].before.iter().copied();
            let common = earlier
                .filter(|before| places[*before] < places[block])
                .reduce(|mut a, mut b| {
                    while a != b {
                        if depths[a] < depths[b] {
                            (a, b) = (b, a);
                        }
                        a = nearest[a];
                    }
                    a
                });
            nearest[block] = common.expect("a block is reached first from an earlier one");
            depths[block] = depths[nearest[block]] + 1;
        }
        // The numbers of blocks that each dominates, itself included.
        let mut sizes = vec![1; graph.blocks.len()];
        for &block in graph.order[1..].iter().rev() {
            sizes[nearest[block]] += sizes[block];
        }
        let mut ranges = vec![(0, 0); graph.blocks.len()];
        let mut next = vec![1; graph.blocks.len()];
        ranges[0] = (0, sizes[0]);
        for &block in &graph.order[1..] {
            let start = next[nearest[block]];
            next[nearest[block]] += sizes[block];
            next[block] = start + 1;
            ranges[block] = (start, start + sizes[block]);
        }
        Self { ranges }
    }

    fn dominates(&self, a: BlockId, b: BlockId) -> bool {
        let (start, end) = self.ranges[a];
        (start..end).contains(&self.ranges[b].0)
    }
}

impl Graph {
    /// The place of each block in the order.
    fn places(&self) -> Vec<usize> {
        let mut places = vec![0; self.blocks.len()];
        for (place, block) in self.order.iter().enumerate() {
            places[*block] = place;
        }
        places
    }

    /// Lets what is computed twice be computed once. Constants are not: most are a part of the instructions that use them.
    pub(super) fn share(&mut self) {
        let dominators = Dominators::new(self);
        let mut constants: HashMap<Op, Value> = HashMap::new();
        let mut known: HashMap<(Op, Args), Vec<(BlockId, Value)>> = HashMap::new();
        for number in 0..self.order.len() {
            let block = self.order[number];
            let mut insts = std::mem::take(&mut self.blocks[block].insts);
            insts.retain_mut(|inst| {
                inst.args.each(|value| self.resolved(value));
                let (Some(out), true) = (inst.out, inst.op.is_pure()) else {
                    return true;
                };
                if inst.op.is_constant() {
                    constants.entry(inst.op).or_insert(out);
                    return true;
                }
                let mut args = inst.args;
                args.each(|value| match self.op(value) {
                    Some(op) if op.is_constant() => constants[&op],
                    _ => value,
                });
                let places = known.entry((inst.op, args)).or_default();
                let same = places.iter().find(|(other, _)| dominators.dominates(*other, block));
                if let Some((_, same)) = same {
                    self.set_same(out, *same);
                    return false;
                }
                places.push((block, out));
                true
            });
            self.blocks[block].insts = insts;
        }
        self.resolve_passed();
    }

    /// Computes what is the same in each turn of a loop before it.
    pub(super) fn lift(&mut self) {
        let places = self.places();
        // Inner loops first.
        for number in (0..self.order.len()).rev() {
            let head = self.order[number];
            let (entries, latches): (Vec<_>, Vec<_>) = self.blocks[head]
                .before
                .iter()
                .partition(|before| places[**before] < number);
            let ([entry], false) = (&entries[..], latches.is_empty()) else {
                continue;
            };
            let inside = self.inside(head, latches);
            let mut varies: HashSet<Value> = HashSet::new();
            let mut lifted = Vec::new();
            for block in self.order.clone().into_iter().filter(|block| inside.contains(block)) {
                varies.extend(&self.blocks[block].params);
                let is_rare = self.blocks[block].is_rare;
                let insts = std::mem::take(&mut self.blocks[block].insts);
                let mut kept = Vec::with_capacity(insts.len());
                for mut inst in insts {
                    let is_worthwhile = !is_rare && inst.op.is_lifted(inst.out.map(|out| self.class(out)));
                    if is_worthwhile && inst.args.iter().all(|arg| !varies.contains(&arg)) {
                        self.copy_constants(&mut inst, &mut lifted);
                        lifted.push(inst);
                    } else {
                        varies.extend(inst.out.filter(|_| !inst.op.is_constant()));
                        kept.push(inst);
                    }
                }
                self.blocks[block].insts = kept;
            }
            let insts = &mut self.blocks[*entry].insts;
            let end = insts.len() - 1;
            insts.splice(end..end, lifted);
        }
    }

    /// The blocks of a loop, from those that jump back to its head.
    fn inside(&self, head: BlockId, mut pending: Vec<BlockId>) -> HashSet<BlockId> {
        let mut inside = HashSet::from([head]);
        while let Some(block) = pending.pop() {
            if inside.insert(block) {
                pending.extend(&self.blocks[block].before);
            }
        }
        inside
    }

    /// Copies an instruction's constants to where it goes itself.
    fn copy_constants(&mut self, inst: &mut Inst, to: &mut Vec<Inst>) {
        for arg in inst.args.iter().collect::<Vec<_>>() {
            if let Some(op) = self.op(arg).filter(|op| op.is_constant()) {
                let copy = self.copy(op, arg, Args::default(), to);
                inst.args.each(|value| if value == arg { copy } else { value });
            }
        }
    }

    /// Adds the instruction that makes a value once more, and returns the other value.
    fn copy(&mut self, op: Op, of: Value, args: Args, to: &mut Vec<Inst>) -> Value {
        let out = self.value(self.class(of), Some(op), args);
        to.push(Inst {
            op,
            out: Some(out),
            args,
        });
        out
    }

    /// Computes what only rare code needs there.
    pub(super) fn sink(&mut self) {
        // Where each value is needed: in usual code, and in which rare blocks.
        let mut is_usual = vec![false; self.producers.len()];
        let mut rare: HashMap<Value, Vec<BlockId>> = HashMap::new();
        let mut need = |value: Value, block: BlockId, graph: &Self, is_usual: &mut Vec<bool>| {
            if graph.blocks[block].is_rare {
                let blocks = rare.entry(value).or_default();
                if !blocks.contains(&block) {
                    blocks.push(block);
                }
            } else {
                is_usual[value.at()] = true;
            }
        };
        for &block in &self.order {
            for value in &self.blocks[block].passed {
                need(*value, block, self, &mut is_usual);
            }
            if self.blocks[block].is_rare {
                for value in self.blocks[block].insts.iter().flat_map(|inst| inst.args.iter()) {
                    need(value, block, self, &mut is_usual);
                }
            }
        }
        for block in self.order.clone().into_iter().rev() {
            if self.blocks[block].is_rare {
                continue;
            }
            let mut insts = std::mem::take(&mut self.blocks[block].insts);
            let mut number = insts.len();
            while number > 0 {
                number -= 1;
                let inst = &insts[number];
                let blocks = inst.out.and_then(|out| rare.get(&out).filter(|_| !is_usual[out.at()]));
                match (inst.out, blocks.cloned()) {
                    (Some(out), Some(blocks)) if inst.op.is_pure() => {
                        let inst = insts.remove(number);
                        for to in blocks {
                            let mut copied = Vec::new();
                            let copy = self.copy(inst.op, out, inst.args, &mut copied);
                            let there = &mut self.blocks[to];
                            let replaced = |value| if value == out { copy } else { value };
                            there.insts.iter_mut().for_each(|inst| inst.args.each(replaced));
                            there.passed.iter_mut().for_each(|value| *value = replaced(*value));
                            there.insts.splice(0..0, copied);
                            for arg in inst.args.iter() {
                                let blocks = rare.entry(arg).or_default();
                                if !blocks.contains(&to) {
                                    blocks.push(to);
                                }
                            }
                        }
                    }
                    _ => inst.args.iter().for_each(|arg| is_usual[arg.at()] = true),
                }
            }
            self.blocks[block].insts = insts;
        }
    }
}
