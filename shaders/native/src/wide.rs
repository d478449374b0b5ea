//! Machine code for 64-bit x86 with AVX2 or AVX-512, without Cranelift: 8 or 16 lanes in a register. From the assembler's calls to a
//! [`graph`], whose values get registers ([`allocate`]) and then bytes ([`write`], [`encode`]).

mod allocate;
mod encode;
mod graph;
mod improve;
mod operations;
#[cfg(test)]
mod tests;
mod write;

use std::collections::HashMap;
use std::mem::offset_of;

use oneiro_shader_compiler::Trees;
use oneiro_shader_compiler::tree::{Binary, Ty, Unary};

use self::allocate::Function;
pub(crate) use self::encode::Vectors;
use self::encode::{Condition, Instruction};
use self::graph::{BlockId, Graph, Inst, Value, Variable};
use self::operations::instructions as x86;
use self::operations::{Arithmetic, Class, Logic, Op, Shift};
use crate::assembler::{Assembler, Form};
use crate::control::{Blocks, Control};
use crate::emit::emit;
use crate::{Error, Words};

/// Bytes per word.
const WORD: u32 = 4;
/// Bytes of the longest vector, to which the stack's data is aligned.
const LONGEST: u32 = 64;
/// The array that holds how many turns are left for loops.
const TURNS: u32 = 0;
/// Layout of [`Words`] in bytes.
const BUFFER: i32 = size_of::<Words>() as i32;
const START: i32 = offset_of!(Words, start) as i32;
const LENGTH: i32 = offset_of!(Words, len) as i32;
/// Half of the range of unsigned integers.
const HALF: f32 = 2_147_483_648.0;
/// The number of a shift to the right, with zeros, in the instruction that shifts by a number.
const RIGHT: u8 = 2;
/// The bit of a float's sign.
const SIGN: u32 = 1 << 31;
/// The first float of 64 bits whose last bit counts ones.
const BIG: f64 = 4_503_599_627_370_496.0;
/// How a float is rounded to an integer, in the instruction that does so: down, or towards zero, without a report of what is lost.
const DOWN: u8 = 9;
const TO_ZERO: u8 = 11;

impl Vectors {
    /// Whether this processor runs code with them.
    pub(crate) fn are_available(self) -> bool {
        match self {
            Self::Avx2 => {
                is_x86_feature_detected!("avx2") && is_x86_feature_detected!("bmi1") && is_x86_feature_detected!("bmi2")
            }
            Self::Avx512 => {
                is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512bw")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vl")
                    && is_x86_feature_detected!("bmi2")
            }
        }
    }

    /// The machine, and the features of its processor that the code needs.
    pub(crate) fn description(self) -> String {
        match self {
            Self::Avx2 => "x86_64 avx2 bmi1 bmi2".into(),
            Self::Avx512 => "x86_64 avx512f avx512bw avx512dq avx512vl bmi2".into(),
        }
    }

    /// Numbers of lanes that code can be compiled for.
    pub(crate) fn numbers(self) -> &'static [u32] {
        match self {
            Self::Avx2 => &[8, 16, 32],
            Self::Avx512 => &[16, 32, 64],
        }
    }

    /// Compiles a program to machine code. `checked`: the allocation of registers is checked.
    pub(crate) fn compile(self, trees: &Trees, lanes: u32, checked: bool) -> Result<Vec<u8>, Error> {
        match self {
            Self::Avx2 => Wide::<8>::compile(trees, lanes, checked),
            Self::Avx512 => Wide::<16>::compile(trees, lanes, checked),
        }
    }
}

/// The operand of an instruction, if any, that is a constant and is written into its bytes.
fn folded(graph: &Graph, inst: &Inst) -> Option<usize> {
    let is = |at: usize| {
        let op = graph.op(inst.args.get(at));
        let is_vector = matches!(op, Some(Op::Constant(_) | Op::Ramp(_)));
        let is_number = matches!(op, Some(Op::Int(_)));
        match inst.op {
            Op::Arithmetic(_) | Op::Multiply | Op::Shift(_) | Op::Compare(_) | Op::IfCompare(_) => is_number,
            Op::One(op) | Op::Two(op) | Op::TwoUnder(op) | Op::Test(op) | Op::TestUnder(op) => {
                is_vector && op.takes_constants()
            }
            Op::Blend | Op::Masked => is_vector,
            _ => false,
        }
    };
    let at = match inst.op {
        Op::One(_) => 0,
        Op::Arithmetic(_) | Op::Multiply | Op::Shift(_) | Op::Compare(_) | Op::IfCompare(_) => 1,
        op => op.takes_memory()?,
    };
    is(at).then_some(at)
}

/// Pointers to a word for each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pointers {
    start: Value,
    indices: Value,
    /// The lanes that are stored to; `None` for all.
    mask: Option<Value>,
}

/// Vectors of so many lanes.
struct Wide<const LANES: u32> {
    graph: Graph,
    buffers: Value,
    /// First word of each buffer.
    starts: Vec<Value>,
    workgroup: Value,
    first_lane: Value,
    /// Where local arrays begin, in bytes, and the end of the last one.
    arrays: Vec<u32>,
    end: u32,
    control: Control<BlockId>,
    /// Vectors of words that are loaded for all lanes.
    spread: HashMap<Value, Value>,
}

fn class(form: Form) -> Class {
    match form {
        Form::One(Ty::F32) => Class::Vector,
        Form::One(_) => Class::Int,
        Form::Vector(Ty::Bool) => Class::Mask,
        Form::Vector(_) => Class::Vector,
    }
}

/// Byte offset of a word. No element is large enough for it to overflow, since the stack's limit also holds for elements.
fn displacement(words: u32) -> i32 {
    (words * WORD) as i32
}

/// The number of a comparison in instructions on floats, none of which reports NaN.
fn float_test(op: Binary) -> Option<u8> {
    Some(match op {
        Binary::Equal => 0,
        Binary::NotEqual => 4,
        Binary::Less => 17,
        Binary::LessEqual => 18,
        Binary::Greater => 30,
        Binary::GreaterEqual => 29,
        _ => return None,
    })
}

/// The same for vectors of integers.
fn integer_test(op: Binary) -> Option<u8> {
    Some(match op {
        Binary::Equal => 0,
        Binary::Less => 1,
        Binary::LessEqual => 2,
        Binary::NotEqual => 4,
        Binary::GreaterEqual => 5,
        Binary::Greater => 6,
        _ => return None,
    })
}

fn condition(op: Binary, signed: bool) -> Option<Condition> {
    Some(match op {
        Binary::Equal => Condition::Equal,
        Binary::NotEqual => Condition::NotEqual,
        Binary::Less if signed => Condition::Less,
        Binary::LessEqual if signed => Condition::LessEqual,
        Binary::Greater if signed => Condition::Greater,
        Binary::GreaterEqual if signed => Condition::GreaterEqual,
        Binary::Less => Condition::Below,
        Binary::LessEqual => Condition::BelowEqual,
        Binary::Greater => Condition::Above,
        Binary::GreaterEqual => Condition::AboveEqual,
        _ => return None,
    })
}

/// Whether its operands can change places.
fn commutes(op: Binary, ty: Ty) -> bool {
    match op {
        // Of two zeros, or of a number and NaN, minimum and maximum of floats take the second one.
        Binary::Min | Binary::Max => ty != Ty::F32,
        Binary::Add | Binary::Multiply | Binary::And | Binary::Or | Binary::Xor | Binary::Equal | Binary::NotEqual => {
            true
        }
        _ => false,
    }
}

impl<const LANES: u32> Wide<LANES> {
    /// Whether there are registers for masks, with a bit for each lane.
    const HAS_MASKS: bool = LANES == 16;
    const VECTORS: Vectors = if Self::HAS_MASKS {
        Vectors::Avx512
    } else {
        Vectors::Avx2
    };

    fn compile(trees: &Trees, lanes: u32, checked: bool) -> Result<Vec<u8>, Error> {
        let mut asm = Self::new(trees);
        emit(&mut asm, trees, lanes);
        let Self {
            mut graph,
            mut arrays,
            end,
            ..
        } = asm;
        arrays.push(end);
        graph.finish(folded);
        let function = Function::new(&graph, Self::VECTORS, folded);
        let output = function.allocate(checked)?;
        write::write(&graph, &function, &output, &arrays)
    }

    fn new(trees: &Trees) -> Self {
        let mut graph = Graph::new();
        let [buffers, workgroup, first_lane, turns] = graph.parameters();
        let [workgroup, first_lane] = [workgroup, first_lane].map(|word| graph.add(Op::Low, Class::Int, &[word]));
        let starts = (0..trees.strides.len() as i32)
            .map(|at| graph.add(Op::LoadPointer(at * BUFFER + START), Class::Int, &[buffers]))
            .collect();
        graph.act(Op::SetTurns(TURNS), &[turns]);
        Self {
            graph,
            buffers,
            starts,
            workgroup,
            first_lane,
            arrays: vec![0],
            end: LONGEST,
            control: Control::default(),
            spread: HashMap::new(),
        }
    }

    fn int(&mut self, op: Op, args: &[Value]) -> Value {
        self.graph.add(op, Class::Int, args)
    }

    fn mask(&mut self, op: Op, args: &[Value]) -> Value {
        self.graph.add(op, Class::Mask, args)
    }

    fn vector(&mut self, op: Op, args: &[Value]) -> Value {
        self.graph.add(op, Class::Vector, args)
    }

    fn is_constant(&self, value: Value) -> bool {
        matches!(self.graph.op(value), Some(Op::Int(_) | Op::Constant(_) | Op::Ramp(_)))
    }

    fn number_of(&self, value: Value) -> Option<u32> {
        match self.graph.op(value)? {
            Op::Int(number) => Some(number),
            _ => None,
        }
    }

    /// Whether a mask is known to have all lanes, or none.
    fn lanes_of(&self, value: Value) -> Option<bool> {
        match self.graph.op(value)? {
            Op::Lanes(all) => Some(all),
            _ => None,
        }
    }

    /// All lanes if a scalar is true, else none.
    fn lanes_if(&mut self, condition: Value) -> Value {
        let bits = self.int(Op::Negate, &[condition]);
        self.mask(if Self::HAS_MASKS { Op::MaskOfBits } else { Op::Spread }, &[bits])
    }

    fn integers(&mut self, op: Binary, signed: bool, a: Value, b: Value) -> Value {
        match (op, self.number_of(a), self.number_of(b)) {
            (Binary::Add, Some(a), Some(b)) => return self.int(Op::Int(a.wrapping_add(b)), &[]),
            (Binary::Subtract, Some(a), Some(b)) => return self.int(Op::Int(a.wrapping_sub(b)), &[]),
            (Binary::Multiply, Some(a), Some(b)) => return self.int(Op::Int(a.wrapping_mul(b)), &[]),
            (Binary::Add | Binary::Subtract, _, Some(0)) | (Binary::Multiply, _, Some(1)) => return a,
            (Binary::Multiply, _, Some(number)) if number.is_power_of_two() => {
                let count = self.int(Op::Int(number.trailing_zeros()), &[]);
                return self.int(Op::Shift(Shift::Left), &[a, count]);
            }
            _ => {}
        }
        let op = match op {
            Binary::Add => Op::Arithmetic(Arithmetic::Add),
            Binary::Subtract => Op::Arithmetic(Arithmetic::Subtract),
            Binary::And => Op::Arithmetic(Arithmetic::And),
            Binary::Or => Op::Arithmetic(Arithmetic::Or),
            Binary::Xor => Op::Arithmetic(Arithmetic::Xor),
            Binary::Multiply => Op::Multiply,
            Binary::Divide => Op::Divide,
            Binary::Remainder => Op::Remainder,
            Binary::Min => Op::Extreme(if signed { Condition::Less } else { Condition::Below }),
            Binary::Max => Op::Extreme(if signed { Condition::Greater } else { Condition::Above }),
            Binary::ShiftLeft => Op::Shift(Shift::Left),
            Binary::ShiftRight if signed => Op::Shift(Shift::SignedRight),
            Binary::ShiftRight => Op::Shift(Shift::Right),
            compares => Op::Compare(condition(compares, signed).expect("others are not comparisons")),
        };
        self.int(op, &[a, b])
    }

    fn floats(&mut self, op: Binary, is_vector: bool, a: Value, b: Value) -> Value {
        let (all, one) = match op {
            Binary::Add => (x86::VADDPS, x86::VADDSS),
            Binary::Subtract => (x86::VSUBPS, x86::VSUBSS),
            Binary::Multiply => (x86::VMULPS, x86::VMULSS),
            Binary::Min => (x86::VMINPS, x86::VMINSS),
            Binary::Max => (x86::VMAXPS, x86::VMAXSS),
            op => {
                let test = float_test(op).expect("floats have no other operations");
                if is_vector {
                    return self.mask(Op::Test(x86::VCMPPS.with(test)), &[a, b]);
                }
                let mask = self.mask(Op::Test(x86::VCMPSS.with(test)), &[a, b]);
                if Self::HAS_MASKS {
                    return self.int(Op::BitsOfMask, &[mask]);
                }
                let bits = self.int(Op::BitsOfFloat, &[mask]);
                return self.int(Op::Negate, &[bits]);
            }
        };
        self.vector(Op::Two(if is_vector { all } else { one }), &[a, b])
    }

    fn masks(&mut self, op: Binary, a: Value, b: Value) -> Value {
        if let [Some(all), _] | [_, Some(all)] = [a, b].map(|value| self.lanes_of(value)) {
            let other = if self.lanes_of(a).is_some() { b } else { a };
            match (op, all) {
                (Binary::And | Binary::Equal, true) | (Binary::Or | Binary::Xor | Binary::NotEqual, false) => {
                    return other;
                }
                (Binary::And, false) | (Binary::Or, true) => return self.mask(Op::Lanes(all), &[]),
                _ => return self.other_lanes(other),
            }
        }
        match op {
            Binary::And => {
                if let Some(under) = self.test_under(a, b).or_else(|| self.test_under(b, a)) {
                    return under;
                }
                let inverted = |value| {
                    let is_inverted = self.graph.op(value) == Some(Op::InvertMask);
                    is_inverted.then(|| self.graph.arg(value, 0))
                };
                if let Some(b) = inverted(b) {
                    return self.mask(Op::Logic(Logic::AndNot), &[b, a]);
                }
                if let Some(a) = inverted(a) {
                    return self.mask(Op::Logic(Logic::AndNot), &[a, b]);
                }
                self.mask(Op::Logic(Logic::And), &[a, b])
            }
            Binary::Or => self.mask(Op::Logic(Logic::Or), &[a, b]),
            Binary::Equal => {
                let differ = self.mask(Op::Logic(Logic::Xor), &[a, b]);
                self.mask(Op::InvertMask, &[differ])
            }
            Binary::Xor | Binary::NotEqual => self.mask(Op::Logic(Logic::Xor), &[a, b]),
            other => unreachable!("truth values have no {other:?}"),
        }
    }

    /// The lanes of a mask for which a comparison holds, or two of them. None waits for another: only one of two is made under the mask.
    fn test_under(&mut self, mask: Value, test: Value) -> Option<Value> {
        if !Self::HAS_MASKS || matches!(self.graph.op(mask), Some(Op::Test(_))) {
            return None;
        }
        match self.graph.op(test)? {
            Op::Test(op) => {
                let [a, b] = [0, 1].map(|at| self.graph.arg(test, at));
                Some(self.mask(Op::TestUnder(op), &[a, b, mask]))
            }
            Op::Logic(Logic::And) => {
                let [first, second] = [0, 1].map(|at| self.graph.arg(test, at));
                let Some(Op::Test(_)) = self.graph.op(first) else {
                    return None;
                };
                let under = self.test_under(mask, first)?;
                Some(self.mask(Op::Logic(Logic::And), &[under, second]))
            }
            _ => None,
        }
    }

    fn other_lanes(&mut self, mask: Value) -> Value {
        if let Some(Op::Test(test)) = self.graph.op(mask)
            && let Some(inverted) = test.inverted()
        {
            let args = [0, 1].map(|at| self.graph.arg(mask, at));
            return self.mask(Op::Test(inverted), &args);
        }
        self.mask(Op::InvertMask, &[mask])
    }

    fn vectors(&mut self, op: Binary, ty: Ty, a: Value, b: Value) -> Value {
        let signed = ty == Ty::I32;
        let op = match op {
            Binary::Add => x86::VPADDD,
            Binary::Subtract => x86::VPSUBD,
            Binary::Multiply => x86::VPMULLD,
            Binary::And => x86::VPANDD,
            Binary::Or => x86::VPORD,
            Binary::Xor => x86::VPXORD,
            Binary::Min if signed => x86::VPMINSD,
            Binary::Max if signed => x86::VPMAXSD,
            Binary::Min => x86::VPMINUD,
            Binary::Max => x86::VPMAXUD,
            Binary::Divide | Binary::Remainder => return self.divided(op, a, b),
            Binary::ShiftLeft | Binary::ShiftRight => return self.shifted(op, signed, a, b),
            op => return self.compared(op, signed, a, b),
        };
        self.vector(Op::Two(op), &[a, b])
    }

    fn compared(&mut self, op: Binary, signed: bool, a: Value, b: Value) -> Value {
        if Self::HAS_MASKS {
            let test = integer_test(op).expect("integers have no other operations");
            let compare = if signed { x86::VPCMPD } else { x86::VPCMPUD };
            return self.mask(Op::Test(compare.with(test)), &[a, b]);
        }
        // There are two instructions: equal, and greater with signs. Without them, one is not less than another if it is the greater one.
        let (test, a, b, inverted) = match op {
            Binary::Equal | Binary::NotEqual => (x86::VPCMPEQD, a, b, op == Binary::NotEqual),
            Binary::Greater | Binary::LessEqual if signed => (x86::VPCMPGTD, a, b, op == Binary::LessEqual),
            Binary::Less | Binary::GreaterEqual if signed => (x86::VPCMPGTD, b, a, op == Binary::GreaterEqual),
            Binary::GreaterEqual | Binary::Less => {
                let greater = self.vector(Op::Two(x86::VPMAXUD), &[a, b]);
                (x86::VPCMPEQD, greater, a, op == Binary::Less)
            }
            _ => {
                let less = self.vector(Op::Two(x86::VPMINUD), &[a, b]);
                (x86::VPCMPEQD, less, a, op == Binary::Greater)
            }
        };
        let mask = self.mask(Op::Test(test), &[a, b]);
        if inverted {
            self.mask(Op::InvertMask, &[mask])
        } else {
            mask
        }
    }

    /// Shifts all lanes by a scalar.
    fn shifted(&mut self, op: Binary, signed: bool, a: Value, count: Value) -> Value {
        // The number of the operation in the instruction by a number, and the one by a register.
        let (number, by_register) = match op {
            Binary::ShiftLeft => (6, x86::VPSLLD),
            _ if signed => (4, x86::VPSRAD),
            _ => (RIGHT, x86::VPSRLD),
        };
        if let Some(Op::Int(count)) = self.graph.op(count) {
            let op = x86::VPSHIFTD.with((count % 32) as u8);
            return self.vector(Op::ByNumber(op, number), &[a]);
        }
        let most = self.int(Op::Int(31), &[]);
        let count = self.int(Op::Arithmetic(Arithmetic::And), &[count, most]);
        let count = self.vector(Op::FloatOfBits, &[count]);
        self.vector(Op::Two(by_register), &[a, count])
    }

    /// Quotients or remainders of unsigned integers, in floats of 64 bits. Truncated, their quotient is exact: what an integer's quotient
    /// lacks to the next integer is at least a 2^32nd of it.
    fn divided(&mut self, op: Binary, a: Value, b: Value) -> Value {
        let mut halves = Vec::new();
        for upper in [false, true] {
            let [a, b] = [a, b].map(|all| {
                let half = if upper { self.vector(Op::Upper, &[all]) } else { all };
                self.doubles(half)
            });
            halves.push(self.vector(Op::Two(x86::VDIVPD), &[a, b]));
        }
        let quotients = self.truncated(&halves);
        if op == Binary::Divide {
            return quotients;
        }
        let products = self.vector(Op::Two(x86::VPMULLD), &[quotients, b]);
        self.vector(Op::Two(x86::VPSUBD), &[a, products])
    }

    /// Floats of 64 bits from half a vector of unsigned integers.
    fn doubles(&mut self, half: Value) -> Value {
        if Self::HAS_MASKS {
            return self.vector(Op::One(x86::VCVTUDQ2PD), &[half]);
        }
        // After the bits of 2^52, they are its last ones.
        let long = self.vector(Op::One(x86::VPMOVZXDQ), &[half]);
        let bits = self.vector(Op::Double(BIG.to_bits()), &[]);
        let sum = self.vector(Op::Two(x86::VPOR_DOUBLE), &[long, bits]);
        self.vector(Op::Two(x86::VSUBPD), &[sum, bits])
    }

    /// A vector of unsigned integers from floats of 64 bits for each half, truncated.
    fn truncated(&mut self, halves: &[Value]) -> Value {
        if Self::HAS_MASKS {
            let [lower, upper] = [0, 1].map(|at| self.vector(Op::One(x86::VCVTTPD2UDQ), &[halves[at]]));
            return self.vector(Op::Two(x86::VINSERTI64X4.with(1)), &[lower, upper]);
        }
        let big = self.vector(Op::Double(BIG.to_bits()), &[]);
        let [lower, upper] = [0, 1].map(|at| {
            let whole = self.vector(Op::One(x86::VROUNDPD.with(TO_ZERO)), &[halves[at]]);
            self.vector(Op::Two(x86::VADDPD), &[whole, big])
        });
        // The lower words of each, which are then in the order of quarters 0, 2, 1, 3.
        let mixed = self.vector(Op::Two(x86::VSHUFPS.with(0b10_00_10_00)), &[lower, upper]);
        self.vector(Op::One(x86::VPERMQ.with(0b11_01_10_00)), &[mixed])
    }

    fn convert_to_integer(&mut self, form: Form, to: Ty, a: Value) -> Value {
        let (low, high): (f32, f32) = if to == Ty::I32 {
            (-2_147_483_648.0, 2_147_483_520.0)
        } else {
            (0.0, 4_294_967_040.0)
        };
        let is_vector = matches!(form, Form::Vector(_));
        let [low, high] = [low, high].map(|bound| self.constant(form, bound.to_bits()));
        let above = self.floats(Binary::Max, is_vector, a, low);
        let within = self.floats(Binary::Min, is_vector, above, high);
        let (all, one) = match (to, Self::HAS_MASKS) {
            (Ty::I32, _) => (x86::VCVTTPS2DQ, x86::VCVTTSS2SI),
            (_, true) => (x86::VCVTTPS2UDQ, x86::VCVTTSS2USI),
            (_, false) if is_vector => return self.unsigned(within),
            (_, false) => (x86::VCVTTPS2DQ, x86::VCVTTSS2SI_LONG),
        };
        if is_vector {
            self.vector(Op::One(all), &[within])
        } else {
            self.int(Op::IntOfFloat(one), &[within])
        }
    }

    /// Unsigned integers from floats that have one each, through signed integers.
    fn unsigned(&mut self, floats: Value) -> Value {
        let half = self.vector(Op::Constant(HALF.to_bits()), &[]);
        let is_large = self.floats(Binary::GreaterEqual, true, floats, half);
        let less = self.vector(Op::Two(x86::VPANDD), &[is_large, half]);
        let rest = self.vector(Op::Two(x86::VSUBPS), &[floats, less]);
        let rest = self.vector(Op::One(x86::VCVTTPS2DQ), &[rest]);
        let bits = self.vector(Op::Constant(SIGN), &[]);
        let bits = self.vector(Op::Two(x86::VPANDD), &[is_large, bits]);
        self.vector(Op::Two(x86::VPXORD), &[rest, bits])
    }

    /// Floats from unsigned integers: the sum of their halves, of which each is exact, so that it is rounded once.
    fn floats_of_unsigned(&mut self, words: Value) -> Value {
        let upper = self.vector(Op::ByNumber(x86::VPSHIFTD.with(16), RIGHT), &[words]);
        let lower = self.with_bits(x86::VPANDD, words, 0xffff);
        let [upper, lower] = [upper, lower].map(|half| self.vector(Op::One(x86::VCVTDQ2PS), &[half]));
        let unit = self.vector(Op::Constant(65_536.0_f32.to_bits()), &[]);
        let upper = self.vector(Op::Two(x86::VMULPS), &[upper, unit]);
        self.vector(Op::Two(x86::VADDPS), &[upper, lower])
    }

    /// A bitwise operation with the sign of floats.
    fn with_bits(&mut self, op: Instruction, a: Value, bits: u32) -> Value {
        let bits = self.vector(Op::Constant(bits), &[]);
        self.vector(Op::Two(op), &[a, bits])
    }
}

impl<const LANES: u32> Blocks for Wide<LANES> {
    type Value = Value;
    type Block = BlockId;

    fn control(&mut self) -> &mut Control<BlockId> {
        &mut self.control
    }

    fn create(&mut self, is_rare: bool) -> BlockId {
        self.graph.block(is_rare)
    }

    fn mark_rare(&mut self) {
        self.graph.mark_rare();
    }

    fn start(&mut self, block: BlockId) {
        self.graph.start(block);
    }

    fn seal(&mut self, block: BlockId) {
        self.graph.seal(block);
    }

    fn jump(&mut self, to: BlockId) {
        self.graph.jump(to);
    }

    /// Goes to one of two blocks by a condition, in one instruction with its comparison where there is one.
    fn branch(&mut self, condition: Value, accept: BlockId, reject: BlockId) {
        let args = |at: usize| self.graph.arg(condition, at);
        match self.graph.op(condition) {
            // Truth values are inverted by a bitwise operation with 1.
            Some(Op::Arithmetic(Arithmetic::Xor)) if self.graph.op(args(1)) == Some(Op::Int(1)) => {
                self.branch(args(0), reject, accept);
            }
            Some(Op::Any) => self.graph.branch(Op::IfAny, &[args(0)], accept, reject),
            Some(Op::Compare(is)) => self
                .graph
                .branch(Op::IfCompare(is), &[args(0), args(1)], accept, reject),
            _ => self.graph.branch(Op::IfTrue, &[condition], accept, reject),
        }
    }
}

impl<const LANES: u32> Assembler for Wide<LANES> {
    const LANES: u32 = LANES;
    const STORES_MASKED: bool = true;
    type Variable = Variable;
    type Pointers = Pointers;
    type Array = u32;

    fn workgroup(&mut self) -> Value {
        self.workgroup
    }

    fn first_lane(&mut self) -> Value {
        self.first_lane
    }

    fn elements(&mut self, buffer: u32, stride: u32) -> Value {
        let words = self.int(Op::Load(buffer as i32 * BUFFER + LENGTH), &[self.buffers]);
        if stride == 1 {
            return words;
        }
        let stride = self.int(Op::Int(stride), &[]);
        self.int(Op::Divide, &[words, stride])
    }

    fn constant(&mut self, form: Form, bits: u32) -> Value {
        match class(form) {
            Class::Int => self.int(Op::Int(bits), &[]),
            Class::Mask => self.mask(Op::Lanes(bits != 0), &[]),
            Class::Vector => self.vector(Op::Constant(bits), &[]),
        }
    }

    fn ramp(&mut self, first: u32) -> Value {
        self.vector(Op::Ramp(first), &[])
    }

    fn splat(&mut self, ty: Ty, scalar: Value) -> Value {
        if let Some(loaded) = self.spread.get(&scalar).filter(|_| ty != Ty::Bool) {
            return *loaded;
        }
        match (ty, self.graph.op(scalar)) {
            (Ty::Bool, _) => self.lanes_if(scalar),
            (Ty::F32, Some(Op::Constant(_))) => scalar,
            (_, Some(Op::Int(bits))) => self.vector(Op::Constant(bits), &[]),
            (Ty::F32, _) => self.vector(Op::One(x86::VBROADCASTSS), &[scalar]),
            _ => self.vector(Op::Spread, &[scalar]),
        }
    }

    fn unary(&mut self, op: Unary, form: Form, a: Value) -> Value {
        let (Form::One(ty) | Form::Vector(ty)) = form;
        match (op, class(form), ty) {
            (Unary::Negate, Class::Vector, Ty::F32) => self.with_bits(x86::VPXORD, a, SIGN),
            (Unary::Abs, Class::Vector, Ty::F32) => self.with_bits(x86::VPANDD, a, !SIGN),
            (Unary::Not, Class::Int, Ty::Bool) => {
                let one = self.int(Op::Int(1), &[]);
                self.int(Op::Arithmetic(Arithmetic::Xor), &[a, one])
            }
            (Unary::Not, Class::Mask, _) => self.other_lanes(a),
            (Unary::Abs, _, Ty::U32) => a,
            (Unary::Negate, Class::Int, _) => self.int(Op::Negate, &[a]),
            (Unary::Not, Class::Int, _) => self.int(Op::Invert, &[a]),
            (Unary::Abs, Class::Int, _) => self.int(Op::Size, &[a]),
            (Unary::Negate, Class::Vector, _) => {
                let zeros = self.vector(Op::Constant(0), &[]);
                self.vector(Op::Two(x86::VPSUBD), &[zeros, a])
            }
            (Unary::Not, Class::Vector, _) => self.with_bits(x86::VPXORD, a, !0),
            (Unary::Abs, Class::Vector, _) => self.vector(Op::One(x86::VPABSD), &[a]),
            (Unary::Floor | Unary::Trunc, ..) => {
                let how = if op == Unary::Floor { DOWN } else { TO_ZERO };
                if let Form::Vector(_) = form {
                    self.vector(Op::One(x86::VRNDSCALEPS.with(how)), &[a])
                } else {
                    self.vector(Op::Two(x86::VRNDSCALESS.with(how)), &[a, a])
                }
            }
            (Unary::Negate | Unary::Abs, Class::Mask, _) => unreachable!("truth values have no sign"),
        }
    }

    fn binary(&mut self, op: Binary, form: Form, a: Value, b: Value) -> Value {
        let (Form::One(ty) | Form::Vector(ty)) = form;
        let (a, b) = if commutes(op, ty) && self.is_constant(a) {
            (b, a)
        } else {
            (a, b)
        };
        match (class(form), ty) {
            (Class::Int, _) => self.integers(op, ty == Ty::I32, a, b),
            (Class::Mask, _) => self.masks(op, a, b),
            (Class::Vector, Ty::F32) => self.floats(op, matches!(form, Form::Vector(_)), a, b),
            (Class::Vector, _) => self.vectors(op, ty, a, b),
        }
    }

    fn shift_each(&mut self, op: Binary, ty: Ty, a: Value, counts: Value) -> Value {
        let counts = self.with_bits(x86::VPANDD, counts, 31);
        let op = match op {
            Binary::ShiftLeft => x86::VPSLLVD,
            _ if ty == Ty::I32 => x86::VPSRAVD,
            _ => x86::VPSRLVD,
        };
        self.vector(Op::Two(op), &[a, counts])
    }

    fn select(&mut self, condition: Value, accept: Value, reject: Value) -> Value {
        if self.graph.class(accept) == Class::Int {
            return self.int(Op::Choose, &[condition, accept, reject]);
        }
        let lanes = self.lanes_if(condition);
        self.blend(Ty::U32, lanes, accept, reject)
    }

    fn blend(&mut self, _: Ty, mask: Value, accept: Value, reject: Value) -> Value {
        if self.graph.class(accept) == Class::Mask {
            let others = self.other_lanes(mask);
            return match (self.lanes_of(accept), self.lanes_of(reject)) {
                (Some(true), _) => self.masks(Binary::Or, mask, reject),
                (_, Some(true)) => self.masks(Binary::Or, others, accept),
                _ => {
                    let accepted = self.masks(Binary::And, mask, accept);
                    let rejected = self.masks(Binary::And, others, reject);
                    self.masks(Binary::Or, accepted, rejected)
                }
            };
        }
        if self.graph.op(reject) == Some(Op::Constant(0)) {
            return self.masked(mask, accept);
        }
        if self.graph.op(accept) == Some(Op::Constant(0)) {
            let others = self.other_lanes(mask);
            return self.masked(others, reject);
        }
        if let Some(Op::Two(op)) = self.graph.op(accept)
            && Self::HAS_MASKS
            && op.is_of_words()
        {
            let [a, b] = [0, 1].map(|at| self.graph.arg(accept, at));
            return self.vector(Op::TwoUnder(op), &[reject, a, b, mask]);
        }
        self.vector(Op::Blend, &[mask, accept, reject])
    }

    fn masked(&mut self, mask: Value, words: Value) -> Value {
        let is_all = self.graph.op(words) == Some(Op::Constant(u32::MAX));
        match (Self::HAS_MASKS, is_all) {
            (true, true) => self.vector(Op::Words, &[mask]),
            (true, false) => self.vector(Op::Masked, &[mask, words]),
            (false, true) => self.vector(Op::One(x86::VMOVAPS), &[mask]),
            (false, false) => self.vector(Op::Two(x86::VPANDD), &[mask, words]),
        }
    }

    fn mask_of(&mut self, words: Value) -> Value {
        if Self::HAS_MASKS {
            self.mask(Op::Test(x86::VPTESTMD), &[words, words])
        } else {
            self.mask(Op::One(x86::VMOVAPS), &[words])
        }
    }

    fn convert(&mut self, from: Form, to: Ty, a: Value) -> Value {
        match (from, to) {
            (Form::One(Ty::F32) | Form::Vector(Ty::F32), Ty::I32 | Ty::U32) => self.convert_to_integer(from, to, a),
            (Form::One(Ty::I32), Ty::F32) => self.vector(Op::FloatOfInt(x86::VCVTSI2SS), &[a]),
            (Form::One(Ty::U32), Ty::F32) if Self::HAS_MASKS => self.vector(Op::FloatOfInt(x86::VCVTUSI2SS), &[a]),
            // The upper half of a register is zero.
            (Form::One(Ty::U32), Ty::F32) => self.vector(Op::FloatOfInt(x86::VCVTSI2SS_LONG), &[a]),
            (Form::Vector(Ty::I32), Ty::F32) => self.vector(Op::One(x86::VCVTDQ2PS), &[a]),
            (Form::Vector(Ty::U32), Ty::F32) if Self::HAS_MASKS => self.vector(Op::One(x86::VCVTUDQ2PS), &[a]),
            (Form::Vector(Ty::U32), Ty::F32) => self.floats_of_unsigned(a),
            _ => a,
        }
    }

    fn bitcast(&mut self, from: Form, to: Ty, a: Value) -> Value {
        match (from, to) {
            (Form::One(Ty::F32), Ty::I32 | Ty::U32) => self.int(Op::BitsOfFloat, &[a]),
            (Form::One(Ty::I32 | Ty::U32), Ty::F32) => self.vector(Op::FloatOfBits, &[a]),
            _ => a,
        }
    }

    fn any(&mut self, mask: Value) -> Value {
        self.int(Op::Any, &[mask])
    }

    fn buffer_pointer(&mut self, buffer: u32, index: Value) -> Value {
        self.int(Op::Address, &[self.starts[buffer as usize], index])
    }

    fn buffer_pointers(&mut self, buffer: u32, indices: Value, mask: Option<Value>) -> Pointers {
        Pointers {
            start: self.starts[buffer as usize],
            indices,
            mask,
        }
    }

    fn array(&mut self, words: u32) -> u32 {
        self.arrays.push(self.end);
        self.end += (words * WORD).next_multiple_of(LONGEST);
        self.arrays.len() as u32 - 1
    }

    fn array_pointer(&mut self, array: u32, index: Value) -> Value {
        self.int(Op::Place(array), &[index])
    }

    fn load(&mut self, form: Form, pointer: Value, offset: u32) -> Value {
        let offset = displacement(offset);
        let word = match form {
            Form::One(Ty::F32) => self.vector(Op::LoadFloat(offset), &[pointer]),
            Form::One(_) => self.int(Op::Load(offset), &[pointer]),
            Form::Vector(_) => return self.vector(Op::LoadVector(offset), &[pointer]),
        };
        // Dropped unless it is needed. Later, something else may have been stored there.
        let spread = self.vector(Op::LoadSpread(offset), &[pointer]);
        self.spread.insert(word, spread);
        word
    }

    fn store(&mut self, form: Form, pointer: Value, offset: u32, value: Value) {
        let offset = displacement(offset);
        let op = match form {
            Form::One(Ty::F32) => Op::StoreFloat(offset),
            Form::One(_) => Op::Store(offset),
            Form::Vector(_) => Op::StoreVector(offset),
        };
        self.graph.act(op, &[pointer, value]);
    }

    fn store_masked(&mut self, pointer: Value, offset: u32, words: Value, mask: Value) {
        let op = Op::StoreMasked(displacement(offset));
        self.graph.act(op, &[pointer, words, mask]);
    }

    fn gather(&mut self, pointers: &Pointers, offset: u32) -> Value {
        let op = Op::Gather(displacement(offset));
        self.vector(op, &[pointers.start, pointers.indices])
    }

    fn gather_four(&mut self, pointers: &Pointers, offset: u32) -> [Value; 4] {
        let rows = [0, 1, 2, 3].map(|first| {
            let op = Op::Rows(first, displacement(offset));
            self.vector(op, &[pointers.start, pointers.indices])
        });
        // The first and second words of two lanes next to each other, and the third and fourth; then those of four lanes.
        let mut mix = |op, a, b| self.vector(Op::Two(op), &[a, b]);
        let [low_01, low_23] = [0, 2].map(|at| mix(x86::VUNPCKLPS, rows[at], rows[at + 1]));
        let [high_01, high_23] = [0, 2].map(|at| mix(x86::VUNPCKHPS, rows[at], rows[at + 1]));
        [
            mix(x86::VUNPCKLPD, low_01, low_23),
            mix(x86::VUNPCKHPD, low_01, low_23),
            mix(x86::VUNPCKLPD, high_01, high_23),
            mix(x86::VUNPCKHPD, high_01, high_23),
        ]
    }

    fn scatter(&mut self, pointers: &Pointers, offset: u32, words: Value) {
        let mask = pointers.mask.unwrap_or_else(|| self.mask(Op::Lanes(true), &[]));
        let op = Op::Scatter(displacement(offset));
        self.graph.act(op, &[pointers.start, pointers.indices, words, mask]);
    }

    fn variable(&mut self, form: Form) -> Variable {
        self.graph.variable(class(form))
    }

    fn pointer_variable(&mut self) -> Variable {
        self.graph.variable(Class::Int)
    }

    fn get(&mut self, variable: Variable) -> Value {
        self.graph.get(variable)
    }

    fn set(&mut self, variable: Variable, value: Value) {
        self.graph.set(variable, value);
    }

    fn count_turn(&mut self) {
        self.graph.act(Op::Turn(TURNS), &[]);
    }

    fn finish(&mut self) {
        self.graph.act(Op::Return, &[]);
        self.start_unreachable();
    }
}
