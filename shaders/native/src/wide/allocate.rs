//! Gives values registers, by regalloc2.

use regalloc2::{
    self as allocator, Block, Inst as Number, InstRange, MachineEnv, Operand, OperandConstraint, OperandKind,
    OperandPos, Output, PReg, PRegSet, RegClass, RegallocOptions, VReg,
};

use super::encode::{RAX, RBP, RCX, RDI, RDX, RSI, RSP, Register, Vectors};
use super::graph::{Graph, Inst, Value};
use super::operations::{Class, Op};
use crate::Error;

/// A function in the order of its code, as the allocator sees it.
pub(super) struct Function {
    pub(super) vectors: Vectors,
    pub(super) insts: Vec<Inst>,
    /// The block and what it holds.
    pub(super) blocks: Vec<Blocks>,
    operands: Vec<Operand>,
    /// Where each instruction's operands end.
    ends: Vec<u32>,
    values: usize,
    /// For each instruction, the constant operand in its bytes.
    pub(super) folded: Vec<Option<usize>>,
}

/// A block: its instructions, neighbours, parameters, and what it passes to the next block.
#[derive(Debug)]
pub(super) struct Blocks {
    range: InstRange,
    pub(super) before: Vec<Block>,
    pub(super) next: Vec<Block>,
    params: Vec<VReg>,
    passed: Vec<VReg>,
}

fn class(vectors: Vectors, class: Class) -> RegClass {
    match class {
        Class::Int => RegClass::Int,
        // The allocator's third kind.
        Class::Mask if vectors == Vectors::Avx512 => RegClass::Float,
        Class::Mask | Class::Vector => RegClass::Vector,
    }
}

fn general(register: Register) -> PReg {
    PReg::new(register.into(), RegClass::Int)
}

impl Function {
    /// `folded` says which operand of an instruction, if any, is written into it.
    pub(super) fn new(graph: &Graph, vectors: Vectors, folds: impl Fn(&Graph, &Inst) -> Option<usize>) -> Self {
        let mut numbers = vec![None; graph.blocks.len()];
        for (number, block) in graph.order.iter().enumerate() {
            numbers[*block] = Some(Block::new(number));
        }
        let numbered = |blocks: &[usize]| blocks.iter().filter_map(|block| numbers[*block]).collect();
        let register = |value: &Value| VReg::new(value.at(), class(vectors, graph.class(*value)));
        let mut function = Self {
            vectors,
            insts: Vec::new(),
            blocks: Vec::new(),
            operands: Vec::new(),
            ends: Vec::new(),
            values: graph.producers.len(),
            folded: Vec::new(),
        };
        for block in &graph.order {
            let block = &graph.blocks[*block];
            let first = function.insts.len();
            for inst in &block.insts {
                let folded = folds(graph, inst);
                function.add_operands(graph, inst, folded);
                function.insts.push(inst.clone());
                function.folded.push(folded);
            }
            function.blocks.push(Blocks {
                range: InstRange::new(Number::new(first), Number::new(function.insts.len())),
                before: numbered(&block.before),
                next: numbered(&block.next),
                params: block.params.iter().map(register).collect(),
                passed: block.passed.iter().map(register).collect(),
            });
        }
        function
    }

    /// Says where an instruction's result and operands may be: the result first.
    fn add_operands(&mut self, graph: &Graph, inst: &Inst, folded: Option<usize>) {
        let vectors = self.vectors;
        let register = |value: Value| VReg::new(value.at(), class(vectors, graph.class(value)));
        let arg = |at| register(inst.args.get(at));
        let count = inst.args.iter().count();
        let operands = &mut self.operands;
        let mut scratch = |class| {
            self.values += 1;
            VReg::new(self.values - 1, class)
        };
        let uses = |operands: &mut Vec<Operand>| {
            for at in (0..count).filter(|at| Some(*at) != folded) {
                operands.push(if inst.op.takes_memory() == Some(at) {
                    Operand::any_use(arg(at))
                } else {
                    Operand::reg_use(arg(at))
                });
            }
        };
        // What is read lane by lane.
        let on_stack = |at| Operand::new(arg(at), OperandConstraint::Stack, OperandKind::Use, OperandPos::Early);
        let out = inst.out.map(register);
        match inst.op {
            Op::Parameters => {
                for (at, place) in [RDI, RSI, RDX, RCX].into_iter().enumerate() {
                    operands.push(Operand::reg_fixed_def(arg(at), general(place)));
                }
            }
            // They overwrite their first operand.
            Op::Arithmetic(_) | Op::Negate | Op::Invert | Op::Extreme(_) | Op::TwoUnder(_) => {
                operands.extend(out.map(|out| Operand::reg_reuse_def(out, 1)));
                uses(operands);
            }
            Op::Multiply if folded.is_none() => {
                operands.extend(out.map(|out| Operand::reg_reuse_def(out, 1)));
                uses(operands);
            }
            Op::Shift(_) if folded.is_some() => {
                operands.extend(out.map(|out| Operand::reg_reuse_def(out, 1)));
                operands.push(Operand::reg_use(arg(0)));
            }
            Op::Choose => {
                operands.extend(out.map(|out| Operand::reg_reuse_def(out, 2)));
                operands.extend((0..count).map(|at| Operand::reg_use(arg(at))));
            }
            // With a VEX prefix it takes no memory.
            Op::ByNumber(..) if vectors == Vectors::Avx2 => {
                operands.extend(out.map(Operand::reg_def));
                operands.push(Operand::reg_use(arg(0)));
            }
            // The result is written before the operand is read for the last time.
            Op::Size | Op::Any => {
                operands.extend(out.map(Operand::reg_def_at_start));
                operands.push(Operand::reg_use(arg(0)));
            }
            Op::Divide | Op::Remainder => {
                let [kept, lost] = if inst.op == Op::Divide { [RAX, RDX] } else { [RDX, RAX] };
                operands.extend(out.map(|out| Operand::reg_fixed_def(out, general(kept))));
                operands.push(Operand::reg_fixed_use(arg(0), general(RAX)));
                operands.push(Operand::reg_use_at_end(arg(1)));
                // The other register is lost. The upper half is zeroed.
                if lost == RDX {
                    let upper = scratch(RegClass::Int);
                    operands.push(fixed_scratch(upper, RDX));
                } else {
                    let lower = scratch(RegClass::Int);
                    operands.push(Operand::new(
                        lower,
                        OperandConstraint::FixedReg(general(RAX)),
                        OperandKind::Def,
                        OperandPos::Late,
                    ));
                }
            }
            Op::Gather(_) => {
                // All three registers must differ, and the mask is used up.
                operands.extend(out.map(Operand::reg_def_at_start));
                operands.extend([0, 1].map(|at| Operand::reg_use(arg(at))));
                operands.push(Operand::reg_temp(scratch(class(vectors, Class::Mask))));
            }
            Op::Rows(..) => {
                operands.extend(out.map(Operand::reg_def_at_start));
                operands.extend([Operand::reg_use(arg(0)), on_stack(1)]);
                operands.push(Operand::reg_temp(scratch(RegClass::Int)));
            }
            Op::Scatter(_) if vectors == Vectors::Avx2 => {
                // The allocator has no two such places for one value; words are never the indices, which the buffer's end has clamped.
                operands.extend([
                    Operand::reg_use(arg(0)),
                    on_stack(1),
                    on_stack(2),
                    Operand::reg_use(arg(3)),
                ]);
                operands.extend([(); 3].map(|()| Operand::reg_temp(scratch(RegClass::Int))));
            }
            Op::Scatter(_) => {
                operands.extend((0..count).map(|at| Operand::reg_use(arg(at))));
                operands.push(Operand::reg_temp(scratch(RegClass::Float)));
            }
            _ => {
                operands.extend(out.map(Operand::reg_def));
                uses(operands);
            }
        }
        self.ends.push(self.operands.len() as u32);
    }

    /// Registers and places for all operands, and the moves between them.
    ///
    /// # Errors
    /// [`Error::Backend`] if the function isn't well formed.
    pub(super) fn allocate(&self, checked: bool) -> Result<Output, Error> {
        let mut set = [PRegSet::empty(); 3];
        for register in (0..16).filter(|register| ![RSP, RBP].contains(register)) {
            set[0].add(general(register));
        }
        let number = match self.vectors {
            Vectors::Avx2 => 16,
            Vectors::Avx512 => 32,
        };
        (0..number).for_each(|register| set[2].add(PReg::new(register, RegClass::Vector)));
        if self.vectors == Vectors::Avx512 {
            // The first mask register stands for none.
            (1..8).for_each(|register| set[1].add(PReg::new(register, RegClass::Float)));
        }
        let environment = MachineEnv {
            preferred_regs_by_class: set,
            non_preferred_regs_by_class: [PRegSet::empty(); 3],
            scratch_by_class: [None; 3],
            fixed_stack_slots: Vec::new(),
        };
        let options = RegallocOptions {
            validate_ssa: checked,
            ..RegallocOptions::default()
        };
        let failed = |error: &dyn std::fmt::Debug| Error::Backend(format!("{error:?}"));
        let output = allocator::run(self, &environment, &options).map_err(|error| failed(&error))?;
        if checked {
            let mut checker = allocator::checker::Checker::new(self, &environment);
            checker.prepare(&output);
            checker.run().map_err(|errors| failed(&errors))?;
        }
        Ok(output)
    }
}

/// A register that is overwritten before the operands are read.
fn fixed_scratch(value: VReg, register: Register) -> Operand {
    let place = OperandConstraint::FixedReg(general(register));
    Operand::new(value, place, OperandKind::Def, OperandPos::Early)
}

impl allocator::Function for Function {
    fn num_insts(&self) -> usize {
        self.insts.len()
    }
    fn num_blocks(&self) -> usize {
        self.blocks.len()
    }
    fn entry_block(&self) -> Block {
        Block::new(0)
    }
    fn block_insns(&self, block: Block) -> InstRange {
        self.blocks[block.index()].range
    }
    fn block_succs(&self, block: Block) -> &[Block] {
        &self.blocks[block.index()].next
    }
    fn block_preds(&self, block: Block) -> &[Block] {
        &self.blocks[block.index()].before
    }
    fn block_params(&self, block: Block) -> &[VReg] {
        &self.blocks[block.index()].params
    }
    fn is_ret(&self, inst: Number) -> bool {
        self.insts[inst.index()].op == Op::Return
    }
    fn is_branch(&self, inst: Number) -> bool {
        let op = self.insts[inst.index()].op;
        op.ends() && op != Op::Return
    }
    fn branch_blockparams(&self, block: Block, _: Number, _: usize) -> &[VReg] {
        &self.blocks[block.index()].passed
    }
    fn inst_operands(&self, inst: Number) -> &[Operand] {
        let first = inst.index().checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.operands[first as usize..self.ends[inst.index()] as usize]
    }
    fn inst_clobbers(&self, _: Number) -> PRegSet {
        PRegSet::empty()
    }
    fn num_vregs(&self) -> usize {
        self.values
    }
    fn spillslot_size(&self, class: RegClass) -> usize {
        // In units of eight bytes.
        if class == RegClass::Vector {
            self.vectors.lanes() as usize / 2
        } else {
            1
        }
    }
}
