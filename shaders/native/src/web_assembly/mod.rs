//! Code for browsers: a module of WebAssembly with vectors of 128 bits. Its function takes as a fifth parameter the memory for local arrays.
//!
//! What is emitted is kept until the function ends, so that unused values can be left out, and local variables serve several values.

use std::mem::offset_of;

use oneiro_shader_compiler::Trees;
use oneiro_shader_compiler::tree::{Binary, Ty, Unary};
use wasm_encoder::{
    BlockType, CodeSection, EntityType, ExportKind, ExportSection, Function, FunctionSection, ImportSection,
    Instruction, MemArg, MemArgTarget, MemoryType, Module, TypeSection, ValType,
};

use crate::assembler::{Assembler, Form};
use crate::control::Structured;
use crate::emit::emit;
use crate::{Error, FRAME, Words, longest_element};

mod function;
#[cfg(test)]
mod tests;

use function::{Code, Steps, Value};

/// Numbers of lanes that code can be compiled for.
pub(crate) const NUMBERS: [u32; 3] = [4, 8, 16];
/// By what cached code would be named; there is no cache.
pub(crate) const VERSION: &str = "";
/// Bytes per word.
const WORD: u32 = 4;
/// Layout of [`Words`] in bytes.
const BUFFER: u32 = size_of::<Words>() as u32;
const START: u32 = offset_of!(Words, start) as u32;
const LENGTH: u32 = offset_of!(Words, len) as u32;
/// Local variables that engines allow.
const LOCALS: usize = 50_000;

/// Parameters of the function, see [`crate::run`], and its memory.
const PARAMETERS: [ValType; 5] = [ValType::I32, ValType::I32, ValType::I32, ValType::I64, ValType::I32];
const BUFFERS: u32 = 0;
const WORKGROUP: u32 = 1;
const FIRST_LANE: u32 = 2;
const TURNS: u32 = 3;
const MEMORY: u32 = 4;

/// The engine that runs this program.
pub(crate) struct Machine;

/// # Errors
/// None; an engine without vectors refuses the code.
#[expect(clippy::unnecessary_wraps, reason = "as the machines that it stands in for")]
pub(crate) fn host(_: bool) -> Result<Machine, Error> {
    Ok(Machine)
}

#[expect(clippy::unused_self, reason = "as the machines that it stands in for")]
impl Machine {
    pub(crate) fn description(&self) -> String {
        "wasm32 simd128".to_owned()
    }

    /// Compiles a program to a module.
    ///
    /// # Errors
    /// [`Error::TooLarge`]
    pub(crate) fn compile(&self, trees: &Trees, lanes: u32) -> Result<Vec<u8>, Error> {
        let mut asm = Wasm::new(trees);
        emit(&mut asm, trees, lanes);
        if u64::from(asm.memory) > FRAME {
            return Err(Error::TooLarge);
        }
        let (locals, instructions) = asm.steps.written(&PARAMETERS);
        if locals.len() > LOCALS {
            return Err(Error::TooLarge);
        }
        let mut function = Function::new_with_locals_types(locals);
        for instruction in &instructions {
            function.instruction(instruction);
        }
        // The code ends with a return.
        function
            .instruction(&Instruction::Unreachable)
            .instruction(&Instruction::End);
        Ok(module(&function))
    }
}

/// A module of one function, `run`, in the memory of the program.
fn module(function: &Function) -> Vec<u8> {
    let mut types = TypeSection::new();
    types.ty().function(PARAMETERS, [ValType::I32]);
    let mut imports = ImportSection::new();
    let memory = MemoryType {
        minimum: 0,
        maximum: None,
        memory64: false,
        shared: false,
        page_size_log2: None,
    };
    imports.import("oneiro", "memory", EntityType::Memory(memory));
    let mut functions = FunctionSection::new();
    functions.function(0);
    let mut exports = ExportSection::new();
    exports.export("run", ExportKind::Func, 0);
    let mut code = CodeSection::new();
    code.function(function);
    let mut module = Module::new();
    module
        .section(&types)
        .section(&imports)
        .section(&functions)
        .section(&exports)
        .section(&code);
    module.finish()
}

/// Writes WebAssembly.
struct Wasm {
    steps: Steps,
    /// Address and number of words of each buffer.
    buffers: Vec<[Value; 2]>,
    /// Bytes of memory so far, of which idle lanes store to the first.
    memory: u32,
}

fn scalar(ty: Ty) -> ValType {
    match ty {
        Ty::F32 => ValType::F32,
        Ty::I32 | Ty::U32 | Ty::Bool => ValType::I32,
    }
}

fn type_of(form: Form) -> ValType {
    match form {
        Form::One(ty) => scalar(ty),
        Form::Vector(_) => ValType::V128,
    }
}

/// A place in memory, words after an address. All may be read as vectors, from any word on.
fn at(words: u32) -> MemArg {
    MemArg {
        offset: u64::from(words * WORD),
        align: 2,
        target: MemArgTarget::Memory(0),
        ordering: None,
    }
}

impl Wasm {
    fn new(trees: &Trees) -> Self {
        let mut asm = Self {
            steps: Steps::default(),
            buffers: Vec::new(),
            memory: longest_element(trees) * WORD,
        };
        let table = asm.parameter(BUFFERS);
        for buffer in 0..trees.strides.len() as u32 {
            let loaded = [START, LENGTH].map(|offset| {
                let place = at((buffer * BUFFER + offset) / WORD);
                asm.int(Instruction::I32Load(place), &[table])
            });
            asm.buffers.push(loaded);
        }
        asm
    }

    fn parameter(&mut self, number: u32) -> Value {
        self.int(Instruction::LocalGet(number), &[])
    }

    fn int(&mut self, instruction: Instruction<'static>, operands: &[Value]) -> Value {
        self.steps.value(instruction, ValType::I32, operands)
    }

    fn float(&mut self, instruction: Instruction<'static>, operands: &[Value]) -> Value {
        self.steps.value(instruction, ValType::F32, operands)
    }

    fn vector(&mut self, instruction: Instruction<'static>, operands: &[Value]) -> Value {
        self.steps.value(instruction, ValType::V128, operands)
    }

    /// An operation that vectors have no instruction for.
    fn lane_by_lane(&mut self, op: Binary, ty: Ty, a: Value, b: Value) -> Value {
        let mut out = a;
        for lane in 0..Self::LANES as u8 {
            let [a, b] = [a, b].map(|vector| self.int(Instruction::I32x4ExtractLane(lane), &[vector]));
            let word = self.binary(op, Form::One(ty), a, b);
            out = self.vector(Instruction::I32x4ReplaceLane(lane), &[out, word]);
        }
        out
    }

    /// Pointer to a word.
    fn pointer(&mut self, start: Value, index: Value) -> Value {
        let bytes = self.int(Instruction::I32Shl, &[index, Value::Int(2)]);
        self.int(Instruction::I32Add, &[start, bytes])
    }

    /// `a < b ? a : b`, or `a > b ? a : b`.
    fn extreme(&mut self, form: Form, a: Value, b: Value, least: bool) -> Value {
        match form {
            // They are defined in the other order: the second operand unless the first is less, or greater.
            Form::Vector(_) if least => self.vector(Instruction::F32x4PMin, &[b, a]),
            Form::Vector(_) => self.vector(Instruction::F32x4PMax, &[b, a]),
            Form::One(_) => {
                let op = if least { Instruction::F32Lt } else { Instruction::F32Gt };
                let is_first = self.int(op, &[a, b]);
                self.select(is_first, a, b)
            }
        }
    }

    /// Converts floats to integers.
    fn convert_to_integer(&mut self, form: Form, to: Ty, a: Value) -> Value {
        let (low, high): (f32, f32) = if to == Ty::I32 {
            (-2_147_483_648.0, 2_147_483_520.0)
        } else {
            (0.0, 4_294_967_040.0)
        };
        let [low, high] = [low, high].map(|bound| self.constant(form, bound.to_bits()));
        let above = self.extreme(form, a, low, false);
        let within = self.extreme(form, above, high, true);
        match (form, to) {
            (Form::One(_), Ty::I32) => self.int(Instruction::I32TruncF32S, &[within]),
            (Form::One(_), _) => self.int(Instruction::I32TruncF32U, &[within]),
            (Form::Vector(_), Ty::I32) => self.vector(Instruction::I32x4TruncSatF32x4S, &[within]),
            (Form::Vector(_), _) => self.vector(Instruction::I32x4TruncSatF32x4U, &[within]),
        }
    }
}

/// The instruction of an operation on scalars.
fn scalar_operation(op: Binary, ty: Ty) -> Instruction<'static> {
    use Instruction as I;
    let signed = ty == Ty::I32;
    match (op, ty) {
        (Binary::Add, Ty::F32) => I::F32Add,
        (Binary::Subtract, Ty::F32) => I::F32Sub,
        (Binary::Multiply, Ty::F32) => I::F32Mul,
        (Binary::Equal, Ty::F32) => I::F32Eq,
        (Binary::NotEqual, Ty::F32) => I::F32Ne,
        (Binary::Less, Ty::F32) => I::F32Lt,
        (Binary::LessEqual, Ty::F32) => I::F32Le,
        (Binary::Greater, Ty::F32) => I::F32Gt,
        (Binary::GreaterEqual, Ty::F32) => I::F32Ge,
        (Binary::Add, _) => I::I32Add,
        (Binary::Subtract, _) => I::I32Sub,
        (Binary::Multiply, _) => I::I32Mul,
        (Binary::Divide, _) => I::I32DivU,
        (Binary::Remainder, _) => I::I32RemU,
        (Binary::And, _) => I::I32And,
        (Binary::Or, _) => I::I32Or,
        (Binary::Xor, _) => I::I32Xor,
        (Binary::ShiftLeft, _) => I::I32Shl,
        (Binary::ShiftRight, _) if signed => I::I32ShrS,
        (Binary::ShiftRight, _) => I::I32ShrU,
        (Binary::Equal, _) => I::I32Eq,
        (Binary::NotEqual, _) => I::I32Ne,
        (Binary::Less, _) if signed => I::I32LtS,
        (Binary::LessEqual, _) if signed => I::I32LeS,
        (Binary::Greater, _) if signed => I::I32GtS,
        (Binary::GreaterEqual, _) if signed => I::I32GeS,
        (Binary::Less, _) => I::I32LtU,
        (Binary::LessEqual, _) => I::I32LeU,
        (Binary::Greater, _) => I::I32GtU,
        (Binary::GreaterEqual, _) => I::I32GeU,
        (Binary::Min | Binary::Max, _) => unreachable!("it is made of others"),
    }
}

/// The instruction of an operation on vectors.
fn vector_operation(op: Binary, ty: Ty) -> Instruction<'static> {
    use Instruction as I;
    let signed = ty == Ty::I32;
    match (op, ty) {
        (Binary::Add, Ty::F32) => I::F32x4Add,
        (Binary::Subtract, Ty::F32) => I::F32x4Sub,
        (Binary::Multiply, Ty::F32) => I::F32x4Mul,
        (Binary::Equal, Ty::F32) => I::F32x4Eq,
        (Binary::NotEqual, Ty::F32) => I::F32x4Ne,
        (Binary::Less, Ty::F32) => I::F32x4Lt,
        (Binary::LessEqual, Ty::F32) => I::F32x4Le,
        (Binary::Greater, Ty::F32) => I::F32x4Gt,
        (Binary::GreaterEqual, Ty::F32) => I::F32x4Ge,
        (Binary::Add, _) => I::I32x4Add,
        (Binary::Subtract, _) => I::I32x4Sub,
        (Binary::Multiply, _) => I::I32x4Mul,
        (Binary::Min, _) if signed => I::I32x4MinS,
        (Binary::Max, _) if signed => I::I32x4MaxS,
        (Binary::Min, _) => I::I32x4MinU,
        (Binary::Max, _) => I::I32x4MaxU,
        (Binary::And, _) => I::V128And,
        (Binary::Or, _) => I::V128Or,
        (Binary::Xor, _) => I::V128Xor,
        (Binary::ShiftLeft, _) => I::I32x4Shl,
        (Binary::ShiftRight, _) if signed => I::I32x4ShrS,
        (Binary::ShiftRight, _) => I::I32x4ShrU,
        (Binary::Equal, _) => I::I32x4Eq,
        (Binary::NotEqual, _) => I::I32x4Ne,
        (Binary::Less, _) if signed => I::I32x4LtS,
        (Binary::LessEqual, _) if signed => I::I32x4LeS,
        (Binary::Greater, _) if signed => I::I32x4GtS,
        (Binary::GreaterEqual, _) if signed => I::I32x4GeS,
        (Binary::Less, _) => I::I32x4LtU,
        (Binary::LessEqual, _) => I::I32x4LeU,
        (Binary::Greater, _) => I::I32x4GtU,
        (Binary::GreaterEqual, _) => I::I32x4GeU,
        (Binary::Divide | Binary::Remainder, _) => unreachable!("it is done lane by lane"),
    }
}

impl Structured for Wasm {
    type Value = Value;
    type Label = u32;

    fn begin_if(&mut self, condition: Value) {
        self.steps.open(Instruction::If(BlockType::Empty), &[condition]);
    }

    fn begin_rare_if(&mut self, condition: Value) {
        self.begin_if(condition);
    }

    fn begin_else(&mut self) {
        self.steps.act(Code::Control(Instruction::Else), &[]);
    }

    fn end_if(&mut self) {
        self.steps.close();
    }

    fn begin_block(&mut self) -> u32 {
        self.steps.open(Instruction::Block(BlockType::Empty), &[])
    }

    fn end_block(&mut self) {
        self.steps.close();
    }

    fn begin_loop(&mut self) -> u32 {
        let label = self.begin_block();
        self.steps.open(Instruction::Loop(BlockType::Empty), &[]);
        label
    }

    fn end_loop(&mut self) {
        self.steps.act(Code::Control(Instruction::Br(0)), &[]);
        self.steps.close();
        self.steps.close();
    }

    fn leave(&mut self, label: u32) {
        let blocks = self.steps.depth() - 1 - label;
        self.steps.act(Code::Control(Instruction::Br(blocks)), &[]);
    }
}

impl Assembler for Wasm {
    const LANES: u32 = 4;
    const STORES_MASKED: bool = false;
    type Variable = function::Variable;
    type Pointers = [Value; 4];
    /// The byte at which it begins.
    type Array = u32;

    fn workgroup(&mut self) -> Value {
        self.parameter(WORKGROUP)
    }

    fn first_lane(&mut self) -> Value {
        self.parameter(FIRST_LANE)
    }

    fn elements(&mut self, buffer: u32, stride: u32) -> Value {
        let words = self.buffers[buffer as usize][1];
        if stride == 1 {
            return words;
        }
        self.int(Instruction::I32DivU, &[words, Value::Int(stride)])
    }

    fn constant(&mut self, form: Form, bits: u32) -> Value {
        match form {
            Form::One(Ty::F32) => Value::Float(bits),
            Form::One(_) => Value::Int(bits),
            Form::Vector(Ty::Bool) => Value::Vector([0_u32.wrapping_sub(bits); 4]),
            Form::Vector(_) => Value::Vector([bits; 4]),
        }
    }

    fn ramp(&mut self, first: u32) -> Value {
        Value::Vector([first, first + 1, first + 2, first + 3])
    }

    fn splat(&mut self, ty: Ty, value: Value) -> Value {
        match ty {
            Ty::F32 => self.vector(Instruction::F32x4Splat, &[value]),
            Ty::Bool => {
                let word = self.int(Instruction::I32Sub, &[Value::Int(0), value]);
                self.vector(Instruction::I32x4Splat, &[word])
            }
            Ty::I32 | Ty::U32 => self.vector(Instruction::I32x4Splat, &[value]),
        }
    }

    fn unary(&mut self, op: Unary, form: Form, a: Value) -> Value {
        use Instruction as I;
        match (op, form) {
            (Unary::Negate, Form::One(Ty::F32)) => self.float(I::F32Neg, &[a]),
            (Unary::Negate, Form::Vector(Ty::F32)) => self.vector(I::F32x4Neg, &[a]),
            (Unary::Negate, Form::One(_)) => self.int(I::I32Sub, &[Value::Int(0), a]),
            (Unary::Negate, Form::Vector(_)) => self.vector(I::I32x4Neg, &[a]),
            (Unary::Not, Form::One(Ty::Bool)) => self.int(I::I32Eqz, &[a]),
            (Unary::Not, Form::One(_)) => self.int(I::I32Xor, &[a, Value::Int(!0)]),
            (Unary::Not, Form::Vector(_)) => self.vector(I::V128Not, &[a]),
            (Unary::Abs, Form::One(Ty::F32)) => self.float(I::F32Abs, &[a]),
            (Unary::Abs, Form::Vector(Ty::F32)) => self.vector(I::F32x4Abs, &[a]),
            (Unary::Abs, Form::One(Ty::I32)) => {
                let negative = self.int(I::I32Sub, &[Value::Int(0), a]);
                let is_negative = self.int(I::I32LtS, &[a, Value::Int(0)]);
                self.select(is_negative, negative, a)
            }
            (Unary::Abs, Form::Vector(Ty::I32)) => self.vector(I::I32x4Abs, &[a]),
            (Unary::Abs, _) => a,
            (Unary::Floor, Form::One(_)) => self.float(I::F32Floor, &[a]),
            (Unary::Floor, Form::Vector(_)) => self.vector(I::F32x4Floor, &[a]),
            (Unary::Trunc, Form::One(_)) => self.float(I::F32Trunc, &[a]),
            (Unary::Trunc, Form::Vector(_)) => self.vector(I::F32x4Trunc, &[a]),
        }
    }

    fn binary(&mut self, op: Binary, form: Form, a: Value, b: Value) -> Value {
        let (Form::One(ty) | Form::Vector(ty)) = form;
        match (op, form) {
            (Binary::Min | Binary::Max, Form::One(Ty::F32) | Form::Vector(Ty::F32)) => {
                self.extreme(form, a, b, op == Binary::Min)
            }
            (Binary::Min | Binary::Max, Form::One(_)) => {
                let is = if op == Binary::Min {
                    Binary::Less
                } else {
                    Binary::Greater
                };
                let is_first = self.int(scalar_operation(is, ty), &[a, b]);
                self.select(is_first, a, b)
            }
            (Binary::Divide | Binary::Remainder, Form::Vector(_)) => self.lane_by_lane(op, ty, a, b),
            (_, Form::Vector(_)) => self.vector(vector_operation(op, ty), &[a, b]),
            (_, Form::One(Ty::F32)) if !op.compares() => self.float(scalar_operation(op, ty), &[a, b]),
            (_, Form::One(_)) => self.int(scalar_operation(op, ty), &[a, b]),
        }
    }

    fn shift_each(&mut self, op: Binary, ty: Ty, a: Value, counts: Value) -> Value {
        self.lane_by_lane(op, ty, a, counts)
    }

    fn select(&mut self, condition: Value, accept: Value, reject: Value) -> Value {
        let ty = self.steps.type_of(accept);
        self.steps.value(Instruction::Select, ty, &[accept, reject, condition])
    }

    fn blend(&mut self, _: Ty, mask: Value, accept: Value, reject: Value) -> Value {
        self.vector(Instruction::V128Bitselect, &[accept, reject, mask])
    }

    // A mask has words of all ones and all zeros.

    fn masked(&mut self, mask: Value, words: Value) -> Value {
        self.vector(Instruction::V128And, &[mask, words])
    }

    fn mask_of(&mut self, words: Value) -> Value {
        words
    }

    fn convert(&mut self, from: Form, to: Ty, a: Value) -> Value {
        use Instruction as I;
        match (from, to) {
            (Form::One(Ty::F32) | Form::Vector(Ty::F32), Ty::I32 | Ty::U32) => self.convert_to_integer(from, to, a),
            (Form::One(Ty::I32), Ty::F32) => self.float(I::F32ConvertI32S, &[a]),
            (Form::One(Ty::U32), Ty::F32) => self.float(I::F32ConvertI32U, &[a]),
            (Form::Vector(Ty::I32), Ty::F32) => self.vector(I::F32x4ConvertI32x4S, &[a]),
            (Form::Vector(Ty::U32), Ty::F32) => self.vector(I::F32x4ConvertI32x4U, &[a]),
            // Truth values are words.
            _ => a,
        }
    }

    fn bitcast(&mut self, from: Form, to: Ty, a: Value) -> Value {
        match (from, to) {
            (Form::One(Ty::F32), Ty::I32 | Ty::U32) => self.int(Instruction::I32ReinterpretF32, &[a]),
            (Form::One(Ty::I32 | Ty::U32), Ty::F32) => self.float(Instruction::F32ReinterpretI32, &[a]),
            _ => a,
        }
    }

    fn any(&mut self, mask: Value) -> Value {
        self.int(Instruction::V128AnyTrue, &[mask])
    }

    fn buffer_pointer(&mut self, buffer: u32, index: Value) -> Value {
        self.pointer(self.buffers[buffer as usize][0], index)
    }

    fn buffer_pointers(&mut self, buffer: u32, indices: Value, mask: Option<Value>) -> [Value; 4] {
        let start = self.splat(Ty::U32, self.buffers[buffer as usize][0]);
        let bytes = self.vector(Instruction::I32x4Shl, &[indices, Value::Int(2)]);
        let mut pointers = self.vector(Instruction::I32x4Add, &[start, bytes]);
        if let Some(mask) = mask {
            let sink = self.parameter(MEMORY);
            let sink = self.splat(Ty::U32, sink);
            pointers = self.blend(Ty::U32, mask, pointers, sink);
        }
        [0, 1, 2, 3].map(|lane| self.int(Instruction::I32x4ExtractLane(lane), &[pointers]))
    }

    fn array(&mut self, words: u32) -> u32 {
        let begin = self.memory;
        self.memory = begin.saturating_add(words.saturating_mul(WORD));
        begin
    }

    fn array_pointer(&mut self, array: u32, index: Value) -> Value {
        let memory = self.parameter(MEMORY);
        let start = self.int(Instruction::I32Add, &[memory, Value::Int(array)]);
        self.pointer(start, index)
    }

    fn load(&mut self, form: Form, pointer: Value, offset: u32) -> Value {
        match type_of(form) {
            ValType::F32 => self.float(Instruction::F32Load(at(offset)), &[pointer]),
            ValType::V128 => self.vector(Instruction::V128Load(at(offset)), &[pointer]),
            _ => self.int(Instruction::I32Load(at(offset)), &[pointer]),
        }
    }

    fn store(&mut self, form: Form, pointer: Value, offset: u32, value: Value) {
        let instruction = match type_of(form) {
            ValType::F32 => Instruction::F32Store(at(offset)),
            ValType::V128 => Instruction::V128Store(at(offset)),
            _ => Instruction::I32Store(at(offset)),
        };
        self.steps.act(Code::Effect(instruction), &[pointer, value]);
    }

    fn store_masked(&mut self, _: Value, _: u32, _: Value, _: Value) {
        unreachable!("vectors of 128 bits have no such instruction")
    }

    fn gather(&mut self, pointers: &[Value; 4], offset: u32) -> Value {
        let mut words = self.vector(Instruction::V128Load32Zero(at(offset)), &[pointers[0]]);
        for (lane, pointer) in (1..).zip(&pointers[1..]) {
            let memarg = at(offset);
            words = self.vector(Instruction::V128Load32Lane { memarg, lane }, &[*pointer, words]);
        }
        words
    }

    fn gather_four(&mut self, pointers: &[Value; 4], offset: u32) -> [Value; 4] {
        let rows = pointers.map(|pointer| self.load(Form::Vector(Ty::U32), pointer, offset));
        let mut shuffle = |a, b, order: [u8; 4]| {
            let mut bytes = [0; 16];
            for (at, byte) in bytes.iter_mut().enumerate() {
                *byte = order[at / 4] * 4 + at as u8 % 4;
            }
            self.vector(Instruction::I8x16Shuffle(bytes), &[a, b])
        };
        let [interleave_low, interleave_high, lows, highs] = [[0, 4, 1, 5], [2, 6, 3, 7], [0, 1, 4, 5], [2, 3, 6, 7]];
        let low_01 = shuffle(rows[0], rows[1], interleave_low);
        let high_01 = shuffle(rows[0], rows[1], interleave_high);
        let low_23 = shuffle(rows[2], rows[3], interleave_low);
        let high_23 = shuffle(rows[2], rows[3], interleave_high);
        [
            shuffle(low_01, low_23, lows),
            shuffle(low_01, low_23, highs),
            shuffle(high_01, high_23, lows),
            shuffle(high_01, high_23, highs),
        ]
    }

    fn scatter(&mut self, pointers: &[Value; 4], offset: u32, words: Value) {
        for (lane, pointer) in (0..).zip(pointers) {
            let memarg = at(offset);
            let store = Code::Effect(Instruction::V128Store32Lane { memarg, lane });
            self.steps.act(store, &[*pointer, words]);
        }
    }

    fn variable(&mut self, form: Form) -> function::Variable {
        self.steps.variable(type_of(form))
    }

    fn pointer_variable(&mut self) -> function::Variable {
        self.steps.variable(ValType::I32)
    }

    fn get(&mut self, variable: function::Variable) -> Value {
        self.steps.get(variable)
    }

    fn set(&mut self, variable: function::Variable, value: Value) {
        self.steps.act(Code::Set(variable), &[value]);
    }

    fn count_turn(&mut self) {
        let control = [
            Instruction::LocalGet(TURNS),
            Instruction::I64Eqz,
            Instruction::If(BlockType::Empty),
            Instruction::I32Const(1),
            Instruction::Return,
            Instruction::End,
            Instruction::LocalGet(TURNS),
            Instruction::I64Const(1),
            Instruction::I64Sub,
            Instruction::LocalSet(TURNS),
        ];
        for instruction in control {
            self.steps.act(Code::Control(instruction), &[]);
        }
    }

    fn finish(&mut self) {
        self.steps.act(Code::Control(Instruction::I32Const(0)), &[]);
        self.steps.act(Code::Control(Instruction::Return), &[]);
    }
}
