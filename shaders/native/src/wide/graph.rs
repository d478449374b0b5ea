//! A function in static single assignment form: blocks of instructions. What the emitter holds in variables becomes parameters of blocks.

use std::collections::HashMap;

use super::operations::{Class, Op};

/// A value, computed by one instruction or given to a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Value(pub(super) u32);

impl Value {
    pub(super) fn at(self) -> usize {
        self.0 as usize
    }
}

/// Index into [`Graph::blocks`].
pub(super) type BlockId = usize;

/// A local variable: values of one class.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Variable {
    number: u32,
    class: Class,
}

/// An instruction.
#[derive(Clone, Debug)]
pub(super) struct Inst {
    pub(super) op: Op,
    pub(super) out: Option<Value>,
    pub(super) args: Args,
}

/// At most four operands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Args {
    values: [Option<Value>; 4],
}

impl Args {
    pub(super) fn new(values: &[Value]) -> Self {
        let mut args = Self::default();
        for (arg, value) in args.values.iter_mut().zip(values) {
            *arg = Some(*value);
        }
        args
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = Value> {
        self.values.into_iter().flatten()
    }

    pub(super) fn get(&self, at: usize) -> Value {
        self.values[at].expect("the operation has this operand")
    }

    pub(super) fn each(&mut self, change: impl Fn(Value) -> Value) {
        for value in self.values.iter_mut().flatten() {
            *value = change(*value);
        }
    }
}

/// Instructions, of which the last one is a jump, a branch or a return.
#[derive(Clone, Debug, Default)]
pub(super) struct Block {
    pub(super) insts: Vec<Inst>,
    pub(super) params: Vec<Value>,
    /// What its jump passes to the next block.
    pub(super) passed: Vec<Value>,
    pub(super) before: Vec<BlockId>,
    pub(super) next: Vec<BlockId>,
    /// It hardly ever runs.
    pub(super) is_rare: bool,
    /// No later code jumps to it.
    is_sealed: bool,
    /// Parameters that other blocks don't pass yet.
    incomplete: Vec<(Variable, usize)>,
}

/// How a value is made.
#[derive(Clone, Copy, Debug)]
pub(super) struct Producer {
    pub(super) class: Class,
    /// `None` for a block's parameter.
    pub(super) op: Option<Op>,
    pub(super) args: Args,
}

/// A function while it is built.
#[derive(Debug, Default)]
pub(super) struct Graph {
    pub(super) blocks: Vec<Block>,
    pub(super) producers: Vec<Producer>,
    /// Blocks in the order of their code.
    pub(super) order: Vec<BlockId>,
    /// The value that a block's parameter equals, or itself.
    same: Vec<Value>,
    variables: u32,
    held: HashMap<(BlockId, Variable), Value>,
    current: BlockId,
}

impl Graph {
    /// A function whose first block has begun.
    pub(super) fn new() -> Self {
        let mut graph = Self::default();
        let entry = graph.block(false);
        graph.seal(entry);
        graph.start(entry);
        graph
    }

    // Values.

    pub(super) fn value(&mut self, class: Class, op: Option<Op>, args: Args) -> Value {
        let value = Value(self.producers.len() as u32);
        self.producers.push(Producer { class, op, args });
        self.same.push(value);
        value
    }

    /// Adds an instruction with a result.
    pub(super) fn add(&mut self, op: Op, class: Class, args: &[Value]) -> Value {
        let args = Args::new(args);
        let out = self.value(class, Some(op), args);
        self.push(Inst {
            op,
            out: Some(out),
            args,
        });
        out
    }

    /// Adds an instruction that has an effect.
    pub(super) fn act(&mut self, op: Op, args: &[Value]) {
        self.push(Inst {
            op,
            out: None,
            args: Args::new(args),
        });
    }

    /// Adds the function's parameters.
    pub(super) fn parameters(&mut self) -> [Value; 4] {
        let values = [(); 4].map(|()| self.value(Class::Int, None, Args::default()));
        self.act(Op::Parameters, &values);
        values
    }

    fn push(&mut self, inst: Inst) {
        self.blocks[self.current].insts.push(inst);
    }

    pub(super) fn class(&self, value: Value) -> Class {
        self.producers[value.at()].class
    }

    /// The operation that makes a value.
    pub(super) fn op(&self, value: Value) -> Option<Op> {
        self.producers[value.at()].op
    }

    pub(super) fn arg(&self, value: Value, at: usize) -> Value {
        self.producers[value.at()].args.get(at)
    }

    // Blocks.

    pub(super) fn block(&mut self, is_rare: bool) -> BlockId {
        self.blocks.push(Block {
            is_rare,
            ..Block::default()
        });
        self.blocks.len() - 1
    }

    pub(super) fn mark_rare(&mut self) {
        self.blocks[self.current].is_rare = true;
    }

    pub(super) fn start(&mut self, block: BlockId) {
        self.current = block;
        self.order.push(block);
    }

    /// Whether a block is reached: the first one is, and those that others go to.
    fn is_reached(&self, block: BlockId) -> bool {
        block == 0 || !self.blocks[block].before.is_empty()
    }

    fn link(&mut self, to: BlockId) {
        if self.is_reached(self.current) {
            self.blocks[to].before.push(self.current);
            self.blocks[self.current].next.push(to);
        }
    }

    pub(super) fn jump(&mut self, to: BlockId) {
        self.act(Op::Jump, &[]);
        self.link(to);
    }

    pub(super) fn branch(&mut self, op: Op, args: &[Value], accept: BlockId, reject: BlockId) {
        self.act(op, args);
        self.link(accept);
        self.link(reject);
    }

    /// Says that no other code will jump to a block.
    pub(super) fn seal(&mut self, block: BlockId) {
        self.blocks[block].is_sealed = true;
        for (variable, param) in std::mem::take(&mut self.blocks[block].incomplete) {
            self.complete(block, variable, param);
        }
    }

    // Variables.

    pub(super) fn variable(&mut self, class: Class) -> Variable {
        self.variables += 1;
        Variable {
            number: self.variables,
            class,
        }
    }

    pub(super) fn set(&mut self, variable: Variable, value: Value) {
        self.held.insert((self.current, variable), value);
    }

    pub(super) fn get(&mut self, variable: Variable) -> Value {
        let mut pending = Vec::new();
        let value = self.held_at_end(self.current, variable, &mut pending);
        self.complete_all(pending);
        value
    }

    /// What a variable holds at the end of a block so far. Parameters that it needs are pending.
    fn held_at_end(
        &mut self,
        mut block: BlockId,
        variable: Variable,
        pending: &mut Vec<(BlockId, Variable, usize)>,
    ) -> Value {
        let mut passed = Vec::new();
        let value = loop {
            if let Some(value) = self.held.get(&(block, variable)) {
                break *value;
            }
            passed.push(block);
            match (self.blocks[block].is_sealed, &self.blocks[block].before[..]) {
                (true, [only]) => block = *only,
                // Never reached.
                (true, []) => break self.value(variable.class, None, Args::default()),
                (is_sealed, _) => {
                    let param = self.value(variable.class, None, Args::default());
                    self.blocks[block].params.push(param);
                    let at = self.blocks[block].params.len() - 1;
                    if is_sealed {
                        pending.push((block, variable, at));
                    } else {
                        self.blocks[block].incomplete.push((variable, at));
                    }
                    break param;
                }
            }
        };
        for block in passed {
            self.held.insert((block, variable), value);
        }
        value
    }

    fn complete(&mut self, block: BlockId, variable: Variable, param: usize) {
        self.complete_all(vec![(block, variable, param)]);
    }

    /// Lets the blocks before pass what the parameters need.
    fn complete_all(&mut self, mut pending: Vec<(BlockId, Variable, usize)>) {
        while let Some((block, variable, at)) = pending.pop() {
            for before in self.blocks[block].before.clone() {
                let value = self.held_at_end(before, variable, &mut pending);
                let passed = &mut self.blocks[before].passed;
                // Others are filled in when it is their turn.
                passed.resize(passed.len().max(at + 1), value);
                passed[at] = value;
            }
        }
    }

    // The whole function.

    /// The value that another one equals in the end.
    pub(super) fn resolved(&self, mut value: Value) -> Value {
        while self.same[value.at()] != value {
            value = self.same[value.at()];
        }
        value
    }

    /// Drops blocks that are never reached, parameters that are always the same, and what nothing needs. `folds` says which operand of an
    /// instruction, if any, is written into it.
    pub(super) fn finish(&mut self, folds: impl Fn(&Self, &Inst) -> Option<usize>) {
        self.order
            .retain(|block| *block == 0 || !self.blocks[*block].before.is_empty());
        self.drop_same();
        self.share();
        self.lift();
        self.drop_unneeded(&folds);
        self.sink();
        // Constants of what is computed elsewhere.
        self.drop_unneeded(&folds);
        // What hardly ever runs stands behind everything else.
        let (rare, usual): (Vec<_>, _) = self.order.iter().partition(|block| self.blocks[**block].is_rare);
        self.order = usual;
        self.order.extend(rare);
    }

    /// Drops parameters to which all blocks pass the same.
    fn drop_same(&mut self) {
        loop {
            let mut changed = false;
            for number in 0..self.order.len() {
                let block = self.order[number];
                let mut at = 0;
                while let Some(&param) = self.blocks[block].params.get(at) {
                    let mut only = None;
                    let mut varies = false;
                    for before in &self.blocks[block].before {
                        let value = self.resolved(self.blocks[*before].passed[at]);
                        if value != param && only.replace(value).is_some_and(|other| other != value) {
                            varies = true;
                        }
                    }
                    match only {
                        Some(value) if !varies => {
                            self.same[param.at()] = value;
                            self.drop_parameter(block, at);
                            changed = true;
                        }
                        _ => at += 1,
                    }
                }
            }
            if !changed {
                break;
            }
        }
        self.resolve_passed();
    }

    pub(super) fn resolve_passed(&mut self) {
        for block in 0..self.blocks.len() {
            let mut passed = std::mem::take(&mut self.blocks[block].passed);
            for value in &mut passed {
                *value = self.resolved(*value);
            }
            self.blocks[block].passed = passed;
        }
    }

    /// Says that a value equals another one, whose code always ran before.
    pub(super) fn set_same(&mut self, value: Value, other: Value) {
        self.same[value.at()] = other;
    }

    fn drop_parameter(&mut self, block: BlockId, at: usize) {
        self.blocks[block].params.remove(at);
        for before in self.blocks[block].before.clone() {
            self.blocks[before].passed.remove(at);
        }
    }

    /// Drops instructions and parameters that nothing with an effect needs.
    fn drop_unneeded(&mut self, folds: &impl Fn(&Self, &Inst) -> Option<usize>) {
        let mut needed = vec![false; self.producers.len()];
        let mut places = vec![None; self.producers.len()];
        for block in &self.order {
            for (number, inst) in self.blocks[*block].insts.iter().enumerate() {
                if let Some(out) = inst.out {
                    places[out.at()] = Some((*block, number, true));
                }
            }
            for (number, param) in self.blocks[*block].params.iter().enumerate() {
                places[param.at()] = Some((*block, number, false));
            }
        }
        let mut pending = Vec::new();
        let need = |graph: &Self, inst: &Inst, pending: &mut Vec<Value>| {
            let folded = folds(graph, inst);
            let read = inst.args.iter().enumerate().filter(|(at, _)| Some(*at) != folded);
            pending.extend(read.map(|(_, value)| value));
        };
        for block in &self.order {
            for inst in self.blocks[*block].insts.iter().filter(|inst| inst.op.acts()) {
                needed_out(inst, &mut needed);
                need(self, inst, &mut pending);
            }
        }
        while let Some(value) = pending.pop() {
            if std::mem::replace(&mut needed[value.at()], true) {
                continue;
            }
            match places[value.at()] {
                Some((block, number, true)) => need(self, &self.blocks[block].insts[number], &mut pending),
                Some((block, number, false)) => {
                    pending.extend(
                        self.blocks[block]
                            .before
                            .iter()
                            .map(|before| self.blocks[*before].passed[number]),
                    );
                }
                None => {}
            }
        }
        for number in 0..self.order.len() {
            let block = self.order[number];
            self.blocks[block]
                .insts
                .retain(|inst| inst.op.acts() || inst.out.is_none_or(|out| needed[out.at()]));
            for at in (0..self.blocks[block].params.len()).rev() {
                if !needed[self.blocks[block].params[at].at()] {
                    self.drop_parameter(block, at);
                }
            }
        }
    }
}

/// An instruction that acts is there whether or not its result is read.
fn needed_out(inst: &Inst, needed: &mut [bool]) {
    if let Some(out) = inst.out {
        needed[out.at()] = true;
    }
}
