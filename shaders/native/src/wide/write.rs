//! Writes the bytes of a function whose values have registers.

use regalloc2::{Allocation, AllocationKind, Block, Edit, InstOrEdit, Output, PReg, RegClass};

use super::LONGEST;
use super::allocate::Function;
use super::encode::{
    Bytes, Condition, Constant, Label, Memory, Place, RAX, RBP, RBX, RDX, RSP, Register, Under, Vectors,
};
use super::graph::{Graph, Inst};
use super::operations::{Arithmetic, Logic, Op, instructions as x86};
use crate::{Error, FRAME};

/// Registers whose values belong to the caller, besides that of the frame.
const SAVED: [Register; 5] = [RBX, 12, 13, 14, 15];
/// Bytes of the smallest page.
const PAGE: u64 = 4096;
/// Everything, in a vector's bitwise function of three operands.
const ONES: u8 = 0xff;

struct Writer<'a> {
    graph: &'a Graph,
    function: &'a Function,
    output: &'a Output,
    bytes: Bytes,
    /// Where each array begins on the stack.
    arrays: &'a [u32],
    /// Bytes of what no register holds, before the arrays.
    spilled: u32,
    /// Where each block begins, or the block that it only jumps to.
    labels: Vec<Label>,
}

/// The code of a function. `arrays` has the bytes before each local array, and after the last one.
///
/// # Errors
/// [`Error::TooLarge`] if its data takes too much of the stack.
pub(super) fn write(graph: &Graph, function: &Function, output: &Output, arrays: &[u32]) -> Result<Vec<u8>, Error> {
    let spilled = (output.num_spillslots as u64 * 8).next_multiple_of(u64::from(LONGEST));
    let frame = spilled + u64::from(*arrays.last().expect("it has an end")).next_multiple_of(u64::from(LONGEST));
    if frame > FRAME {
        return Err(Error::TooLarge);
    }
    let blocks = function.blocks.len();
    let mut writer = Writer {
        graph,
        function,
        output,
        bytes: Bytes::new(function.vectors, blocks + 2),
        arrays,
        spilled: spilled as u32,
        labels: (0..blocks).collect(),
    };
    writer.skip_jumps();
    writer.begin(frame);
    let written: Vec<_> = (0..blocks).filter(|block| writer.labels[*block] == *block).collect();
    for (number, block) in written.iter().enumerate() {
        writer.bytes.label(*block);
        writer.block(*block, written.get(number + 1).copied());
    }
    writer.end();
    Ok(writer.bytes.finish())
}

/// Where each block's jumps end, if those that have one here only jump. Of a loop without any code, one block stays, and its jumps end there.
pub(super) fn destinations(jumps: &[Option<usize>]) -> Vec<Label> {
    fn end(labels: &[Label], mut block: usize) -> usize {
        while labels[block] != block {
            block = labels[block];
        }
        block
    }
    let mut labels: Vec<Label> = (0..jumps.len()).collect();
    for (block, next) in jumps.iter().enumerate() {
        if let Some(next) = *next {
            labels[block] = end(&labels, next);
        }
    }
    // Again: a block may only have been left out after others that jump to it, as the head of a loop is after its end.
    (0..jumps.len()).map(|block| end(&labels, block)).collect()
}

impl Writer<'_> {
    /// Blocks that only jump are left out.
    fn skip_jumps(&mut self) {
        let jump = |block: usize| {
            let mut code = self.output.block_insts_and_edits(self.function, Block::new(block));
            match (code.next(), &self.function.blocks[block].next[..]) {
                (Some(InstOrEdit::Inst(inst)), [next]) => {
                    (self.function.insts[inst.index()].op == Op::Jump).then(|| next.index())
                }
                _ => None,
            }
        };
        // The first one begins the function.
        let jumps: Vec<_> = (0..self.labels.len())
            .map(|block| jump(block).filter(|_| block != 0))
            .collect();
        self.labels = destinations(&jumps);
    }

    /// Where an array begins.
    fn array(&self, array: u32) -> Memory {
        Memory::At(RSP, (self.spilled + self.arrays[array as usize]) as i32)
    }

    fn has_masks(&self) -> bool {
        self.function.vectors == Vectors::Avx512
    }

    fn used_up(&self) -> Label {
        self.labels.len()
    }

    fn leave(&self) -> Label {
        self.labels.len() + 1
    }

    /// Saves the caller's registers, and takes a part of the stack.
    fn begin(&mut self, frame: u64) {
        self.bytes.push(RBP);
        self.bytes.copy(true, RBP, Place::In(RSP));
        for register in SAVED {
            self.bytes.push(register);
        }
        for page in 1..=frame / PAGE {
            self.bytes.touch(Memory::At(RSP, -((page * PAGE) as i32)));
        }
        self.bytes
            .arithmetic_with_number(true, Arithmetic::Subtract, RSP, frame as u32);
        self.bytes
            .arithmetic_with_number(true, Arithmetic::And, RSP, LONGEST.wrapping_neg());
    }

    fn end(&mut self) {
        self.bytes.label(self.used_up());
        self.bytes.set_number(RAX, 1);
        self.bytes.label(self.leave());
        self.bytes.address(RSP, Memory::At(RBP, -8 * SAVED.len() as i32));
        for register in SAVED.into_iter().rev() {
            self.bytes.pop(register);
        }
        self.bytes.pop(RBP);
        self.bytes.return_();
    }

    fn block(&mut self, block: usize, following: Option<Label>) {
        let code: Vec<_> = self
            .output
            .block_insts_and_edits(self.function, Block::new(block))
            .map(|step| match step {
                InstOrEdit::Inst(inst) => Ok(inst),
                InstOrEdit::Edit(Edit::Move { from, to }) => Err((*from, *to)),
            })
            .collect();
        let function = self.function;
        for step in code {
            match step {
                Err((from, to)) => self.copy(from, to),
                Ok(inst) => {
                    let allocated: Vec<_> = self.output.inst_allocs(inst).to_vec();
                    let inst = inst.index();
                    let next = &function.blocks[block].next;
                    let next: Vec<_> = next.iter().map(|next| self.labels[next.index()]).collect();
                    self.inst(
                        &function.insts[inst],
                        function.folded[inst],
                        &allocated,
                        &next,
                        following,
                    );
                }
            }
        }
    }

    fn copy(&mut self, from: Allocation, to: Allocation) {
        let class = [from, to].iter().find_map(|at| at.as_reg()).map(PReg::class);
        let place = place(from);
        match (class, to.kind()) {
            (Some(RegClass::Int), AllocationKind::Reg) => self.bytes.copy(true, register(to), place),
            (Some(RegClass::Float), AllocationKind::Reg) => self.bytes.copy_mask(register(to), place),
            (Some(RegClass::Vector), AllocationKind::Reg) => {
                self.bytes.vector(x86::VMOVAPS, register(to), 0, place);
            }
            (Some(RegClass::Int), _) => self.bytes.save(true, stack(to), register(from)),
            (Some(RegClass::Float), _) => self.bytes.save_mask(stack(to), register(from)),
            (Some(RegClass::Vector), _) => {
                let to = Place::At(stack(to));
                self.bytes.vector(x86::VMOVAPS_STORE, register(from), 0, to);
            }
            (None, _) => unreachable!("without a register for it, values are moved through one"),
        }
    }

    /// The operand that may be in memory, whose value may be folded into the instruction.
    fn place(&self, inst: &Inst, folded: Option<usize>, allocated: Option<&Allocation>) -> Place {
        if let Some(at) = folded {
            return Place::At(Memory::Constant(match self.graph.op(inst.args.get(at)) {
                Some(Op::Constant(word)) => Constant::Word(word),
                Some(Op::Ramp(first)) => Constant::Ramp(first),
                other => unreachable!("{other:?} is not a vector's constant"),
            }));
        }
        place(*allocated.expect("an operand that isn't folded has a place"))
    }

    fn number(&self, inst: &Inst, at: usize) -> u32 {
        match self.graph.op(inst.args.get(at)) {
            Some(Op::Int(number)) => number,
            other => unreachable!("{other:?} is not a number"),
        }
    }

    fn jump(&mut self, to: Label, following: Option<Label>) {
        if Some(to) != following {
            self.bytes.jump(to);
        }
    }

    fn branch(&mut self, condition: Condition, to: &[Label], following: Option<Label>) {
        if Some(to[0]) == following {
            self.bytes.jump_if(opposite(condition), to[1]);
        } else {
            self.bytes.jump_if(condition, to[0]);
            self.jump(to[1], following);
        }
    }

    fn inst(
        &mut self,
        inst: &Inst,
        folded: Option<usize>,
        at: &[Allocation],
        next: &[Label],
        following: Option<Label>,
    ) {
        let reg = |number: usize| register(at[number]);
        match inst.op {
            Op::Parameters => {}
            Op::Int(number) => self.bytes.set_number(reg(0), number),
            Op::Low => self.bytes.copy(false, reg(0), Place::In(reg(1))),
            Op::Arithmetic(op) if folded.is_some() => {
                let number = self.number(inst, 1);
                self.bytes.arithmetic_with_number(false, op, reg(0), number);
            }
            Op::Arithmetic(op) => {
                let with = self.place(inst, None, at.get(2));
                self.bytes.arithmetic(false, op, reg(0), with);
            }
            Op::Multiply if folded.is_some() => {
                let number = self.number(inst, 1);
                self.bytes.multiply_by(reg(0), reg(1), number);
            }
            Op::Multiply => self.bytes.multiply(reg(0), reg(2)),
            Op::Shift(op) if folded.is_some() => {
                let number = self.number(inst, 1);
                self.bytes.shift_by(op, reg(0), number as u8);
            }
            Op::Shift(op) => self.bytes.shift(op, reg(0), reg(1), reg(2)),
            Op::Negate => self.bytes.negate(reg(0)),
            Op::Invert => self.bytes.invert(reg(0)),
            Op::Size => {
                self.bytes.copy(false, reg(0), Place::In(reg(1)));
                self.bytes.negate(reg(0));
                self.bytes.copy_if(Condition::Negative, reg(0), reg(1));
            }
            Op::Extreme(condition) => {
                self.bytes.compare(reg(0), Place::In(reg(2)));
                self.bytes.copy_if(opposite(condition), reg(0), reg(2));
            }
            Op::Compare(condition) => {
                self.compare(inst, folded, &at[1..]);
                self.bytes.set_if(condition, reg(0));
            }
            Op::Choose => {
                self.bytes.test(reg(1));
                self.bytes.copy_if(Condition::Equal, reg(0), reg(3));
            }
            Op::Divide | Op::Remainder => {
                self.bytes.arithmetic(false, Arithmetic::Xor, RDX, Place::In(RDX));
                self.bytes.divide(reg(2));
            }
            Op::LoadPointer(offset) => self.bytes.copy(true, reg(0), Place::At(Memory::At(reg(1), offset))),
            Op::Load(offset) => self.bytes.copy(false, reg(0), Place::At(Memory::At(reg(1), offset))),
            Op::LoadFloat(offset) => {
                let from = Place::At(Memory::At(reg(1), offset));
                self.bytes.vector(x86::VMOVSS, reg(0), 0, from);
            }
            Op::LoadVector(offset) => {
                let from = Place::At(Memory::At(reg(1), offset));
                self.bytes.vector(x86::VMOVUPS, reg(0), 0, from);
            }
            Op::LoadSpread(offset) => {
                let from = Place::At(Memory::At(reg(1), offset));
                self.bytes.vector(x86::VBROADCASTSS, reg(0), 0, from);
            }
            Op::Store(offset) => self.bytes.save(false, Memory::At(reg(0), offset), reg(1)),
            Op::StoreFloat(offset) => {
                let to = Place::At(Memory::At(reg(0), offset));
                self.bytes.vector(x86::VMOVSS_STORE, reg(1), 0, to);
            }
            Op::StoreVector(offset) => {
                let to = Place::At(Memory::At(reg(0), offset));
                self.bytes.vector(x86::VMOVUPS_STORE, reg(1), 0, to);
            }
            Op::StoreMasked(offset) => {
                let (words, mask) = (reg(1), reg(2));
                let to = Place::At(Memory::At(reg(0), offset));
                if self.has_masks() {
                    self.bytes
                        .vector_under(x86::VMOVUPS_STORE, words, 0, to, Under::lanes_of(mask));
                } else {
                    self.bytes.vector(x86::VMASKMOVPS_STORE, words, mask, to);
                }
            }
            Op::Address => self.bytes.address(reg(0), Memory::Indexed(reg(1), reg(2), 0)),
            Op::Place(array) => {
                let place = self.array(array).word(reg(1));
                self.bytes.address(reg(0), place);
            }
            Op::Gather(offset) => {
                let (to, mask) = (reg(0), reg(3));
                self.all_lanes(mask);
                // What it held before doesn't matter.
                self.bytes.vector(x86::VPXORD, to, to, Place::In(to));
                let from = Place::At(Memory::Indexed(reg(1), reg(2), offset));
                if self.has_masks() {
                    self.bytes
                        .vector_under(x86::VPGATHERDD, to, 0, from, Under::lanes_of(mask));
                } else {
                    self.bytes.vector(x86::VPGATHERDD, to, mask, from);
                }
            }
            Op::Rows(first, offset) => {
                let (to, start, indices, index) = (reg(0), reg(1), stack(at[2]), reg(3));
                for (row, lane) in (first..self.function.vectors.lanes()).step_by(4).enumerate() {
                    self.bytes.copy(false, index, Place::At(indices.after(lane as i32 * 4)));
                    let from = Place::At(Memory::Indexed(start, index, offset));
                    if row == 0 {
                        self.bytes.vector(x86::VMOVUPS_ROW, to, 0, from);
                    } else {
                        self.bytes.vector(x86::VINSERTF32X4.with(row as u8), to, to, from);
                    }
                }
            }
            Op::Scatter(offset) if self.has_masks() => {
                let mask = reg(4);
                self.bytes.copy_mask(mask, Place::In(reg(3)));
                let to = Place::At(Memory::Indexed(reg(0), reg(1), offset));
                self.bytes
                    .vector_under(x86::VPSCATTERDD, reg(2), 0, to, Under::lanes_of(mask));
            }
            Op::Scatter(offset) => self.scatter(at, offset),
            Op::BitsOfFloat => self.bytes.vector(x86::VMOVD_STORE, reg(1), 0, Place::In(reg(0))),
            Op::FloatOfBits => self.bytes.vector(x86::VMOVD, reg(0), 0, Place::In(reg(1))),
            Op::FloatOfInt(op) => {
                // Without this, the result would wait for what the register held before.
                self.bytes.vector(x86::VPXORD, reg(0), reg(0), Place::In(reg(0)));
                self.bytes.vector(op, reg(0), reg(0), Place::In(reg(1)));
            }
            Op::IntOfFloat(op) => self.bytes.vector(op, reg(0), 0, Place::In(reg(1))),
            Op::MaskOfBits => self.bytes.mask_of_bits(reg(0), reg(1)),
            Op::BitsOfMask => self.bytes.bits_of_mask(reg(0), reg(1)),
            Op::Spread if self.has_masks() => self.bytes.vector(x86::VPBROADCASTD, reg(0), 0, Place::In(reg(1))),
            Op::Spread => {
                self.bytes.vector(x86::VMOVD, reg(0), 0, Place::In(reg(1)));
                self.bytes.vector(x86::VPBROADCASTD_WORD, reg(0), 0, Place::In(reg(0)));
            }
            Op::Any => {
                self.test_mask(reg(1));
                self.bytes.set_if(Condition::NotEqual, reg(0));
            }
            Op::Logic(op) => self.logic(op, reg(0), reg(1), reg(2)),
            Op::InvertMask if self.has_masks() => self.bytes.invert_mask(reg(0), reg(1)),
            Op::InvertMask => {
                let all = Place::At(Memory::Constant(Constant::Word(!0)));
                self.bytes.vector(x86::VPXORD, reg(0), reg(1), all);
            }
            Op::Lanes(true) => self.all_lanes(reg(0)),
            Op::Lanes(false) => self.logic(Logic::Xor, reg(0), reg(0), reg(0)),
            Op::Constant(0) => self.bytes.vector(x86::VPXORD, reg(0), reg(0), Place::In(reg(0))),
            Op::Constant(u32::MAX) => {
                let op = if self.has_masks() {
                    x86::VPTERNLOGD.with(ONES)
                } else {
                    x86::VPCMPEQD
                };
                self.bytes.vector(op, reg(0), reg(0), Place::In(reg(0)));
            }
            Op::Constant(word) => {
                let from = Place::At(Memory::Constant(Constant::Word(word)));
                self.bytes.vector(x86::VBROADCASTSS, reg(0), 0, from);
            }
            Op::Double(bits) => {
                let from = Place::At(Memory::Constant(Constant::Double(bits)));
                self.bytes.vector(x86::VMOVAPS, reg(0), 0, from);
            }
            Op::Ramp(first) => {
                let from = Place::At(Memory::Constant(Constant::Ramp(first)));
                self.bytes.vector(x86::VMOVUPS, reg(0), 0, from);
            }
            Op::One(op) => {
                let from = self.place(inst, folded, at.get(1));
                self.bytes.vector(op, reg(0), 0, from);
            }
            Op::ByNumber(op, number) => {
                let from = self.place(inst, folded, at.get(1));
                self.bytes.vector(op, number, reg(0), from);
            }
            Op::Two(op) | Op::Test(op) => {
                let from = self.place(inst, folded, at.get(2));
                self.bytes.vector(op, reg(0), reg(1), from);
            }
            Op::TwoUnder(op) => {
                let from = self.place(inst, folded, at.get(3));
                let mask = register(at[at.len() - 1]);
                self.bytes.vector_under(op, reg(0), reg(2), from, Under::lanes_of(mask));
            }
            Op::TestUnder(op) => {
                let from = self.place(inst, folded, at.get(2));
                let mask = register(at[at.len() - 1]);
                self.bytes.vector_under(op, reg(0), reg(1), from, Under::lanes_of(mask));
            }
            Op::Blend => {
                let (mask, rejected) = (reg(1), register(at[at.len() - 1]));
                let from = self.place(inst, folded, at.get(2));
                if self.has_masks() {
                    self.bytes
                        .vector_under(x86::VBLENDMPS, reg(0), rejected, from, Under::lanes_of(mask));
                } else {
                    self.bytes
                        .vector(x86::VBLENDVPS.with(mask << 4), reg(0), rejected, from);
                }
            }
            Op::Masked => {
                let under = Under {
                    mask: reg(1),
                    zeroes: true,
                };
                match self.place(inst, folded, at.get(2)) {
                    from @ Place::At(Memory::Constant(Constant::Word(_))) => {
                        self.bytes.vector_under(x86::VBROADCASTSS, reg(0), 0, from, under);
                    }
                    from => self.bytes.vector_under(x86::VMOVUPS, reg(0), 0, from, under),
                }
            }
            Op::Words => self.bytes.vector(x86::VPMOVM2D, reg(0), 0, Place::In(reg(1))),
            Op::Upper => {
                let op = if self.has_masks() {
                    x86::VEXTRACTI64X4
                } else {
                    x86::VEXTRACTI128
                };
                let op = op.with(1);
                self.bytes.vector(op, reg(1), 0, Place::In(reg(0)));
            }
            Op::SetTurns(array) => {
                let place = self.array(array);
                self.bytes.save(true, place, reg(0));
            }
            Op::Turn(array) => {
                let place = self.array(array);
                self.bytes.take_one_off(place);
                self.bytes.jump_if(Condition::Below, self.used_up());
            }
            Op::Jump => self.jump(next[0], following),
            Op::IfTrue => {
                self.bytes.test(reg(0));
                self.branch(Condition::NotEqual, next, following);
            }
            Op::IfCompare(condition) => {
                self.compare(inst, folded, at);
                self.branch(condition, next, following);
            }
            Op::IfAny => {
                self.test_mask(reg(0));
                self.branch(Condition::NotEqual, next, following);
            }
            Op::Return => {
                self.bytes.arithmetic(false, Arithmetic::Xor, RAX, Place::In(RAX));
                self.bytes.jump(self.leave());
            }
        }
    }

    // Masks.

    /// Sets the flag of zero if no lane is set.
    fn test_mask(&mut self, mask: Register) {
        if self.has_masks() {
            self.bytes.test_mask(mask);
        } else {
            self.bytes.vector(x86::VTESTPS, mask, 0, Place::In(mask));
        }
    }

    fn all_lanes(&mut self, mask: Register) {
        if self.has_masks() {
            self.bytes.logic(Logic::Same, mask, mask, mask);
        } else {
            self.bytes.vector(x86::VPCMPEQD, mask, mask, Place::In(mask));
        }
    }

    fn logic(&mut self, op: Logic, to: Register, a: Register, b: Register) {
        if self.has_masks() {
            return self.bytes.logic(op, to, a, b);
        }
        let op = match op {
            Logic::And => x86::VPANDD,
            Logic::AndNot => x86::VPANDN,
            Logic::Or => x86::VPORD,
            Logic::Xor => x86::VPXORD,
            Logic::Same => unreachable!("only registers of masks are set by it"),
        };
        self.bytes.vector(op, to, a, Place::In(b));
    }

    /// Stores the words of the set lanes one after another: those whose bits are left in a register.
    fn scatter(&mut self, at: &[Allocation], offset: i32) {
        let (start, indices, words) = (register(at[0]), stack(at[1]), stack(at[2]));
        let (mask, [bits, lane, index]) = (register(at[3]), [4, 5, 6].map(|number| register(at[number])));
        let [next, end] = [(); 2].map(|()| self.bytes.new_label());
        self.bytes.vector(x86::VMOVMSKPS, bits, 0, Place::In(mask));
        self.bytes.test(bits);
        self.bytes.jump_if(Condition::Equal, end);
        self.bytes.label(next);
        self.bytes.first_bit(lane, bits);
        self.bytes.copy(false, index, Place::At(indices.word(lane)));
        self.bytes.copy(false, lane, Place::At(words.word(lane)));
        self.bytes.save(false, Memory::Indexed(start, index, offset), lane);
        self.bytes.drop_first_bit(bits);
        self.bytes.jump_if(Condition::NotEqual, next);
        self.bytes.label(end);
    }

    fn compare(&mut self, inst: &Inst, folded: Option<usize>, at: &[Allocation]) {
        if folded.is_some() {
            let number = self.number(inst, 1);
            self.bytes.compare_with_number(register(at[0]), number);
        } else {
            let with = self.place(inst, None, at.get(1));
            self.bytes.compare(register(at[0]), with);
        }
    }
}

fn place(at: Allocation) -> Place {
    match at.kind() {
        AllocationKind::Reg => Place::In(register(at)),
        _ => Place::At(stack(at)),
    }
}

fn stack(at: Allocation) -> Memory {
    let slot = at.as_stack().expect("it is on the stack");
    Memory::At(RSP, slot.index() as i32 * 8)
}

fn register(at: Allocation) -> Register {
    at.as_reg().expect("it must be in a register").hw_enc() as Register
}

/// The condition that holds if this one doesn't.
fn opposite(condition: Condition) -> Condition {
    match condition {
        Condition::Below => Condition::AboveEqual,
        Condition::AboveEqual => Condition::Below,
        Condition::Equal => Condition::NotEqual,
        Condition::NotEqual => Condition::Equal,
        Condition::BelowEqual => Condition::Above,
        Condition::Above => Condition::BelowEqual,
        Condition::Less => Condition::GreaterEqual,
        Condition::GreaterEqual => Condition::Less,
        Condition::LessEqual => Condition::Greater,
        Condition::Greater => Condition::LessEqual,
        Condition::Negative => unreachable!("nothing branches on it"),
    }
}
