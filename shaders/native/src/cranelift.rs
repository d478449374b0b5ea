//! Machine code by Cranelift: vectors of 128 bits. Its optimiser is off, since values that it hoists out of loops are then
//! spilled, which costs more than it saves.

use std::mem::offset_of;

use cranelift_codegen::control::ControlPlane;
use cranelift_codegen::ir::condcodes::{FloatCC, IntCC};
use cranelift_codegen::ir::immediates::V128Imm;
use cranelift_codegen::ir::types::{F32, F32X4, I8, I8X16, I32, I32X4, I64, I64X2};
use cranelift_codegen::ir::{
    self, AbiParam, BlockArg, InstBuilder, MemFlagsData, Signature, StackSlot, StackSlotData, StackSlotKind, TrapCode,
    UserFuncName,
};
use cranelift_codegen::isa::{CallConv, OwnedTargetIsa, TargetIsa};
use cranelift_codegen::settings::{self, Configurable};
use cranelift_codegen::{CodegenError, Context};
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext, Variable};
use oneiro_shader_compiler::Trees;
use oneiro_shader_compiler::tree::{Binary, Ty, Unary};
use target_lexicon::Architecture;

use crate::assembler::{Assembler, Form};
use crate::control::{Blocks, Control};
use crate::emit::emit;
use crate::{Error, FRAME, Words, longest_element};

/// Cranelift for this machine.
pub(crate) struct Machine(OwnedTargetIsa);

/// By what cached code is named.
pub(crate) const VERSION: &str = cranelift_codegen::VERSION;
/// Numbers of lanes that code can be compiled for.
pub(crate) const NUMBERS: [u32; 3] = [4, 8, 16];
/// Bytes per word.
const WORD: u32 = 4;
/// Layout of [`Words`] in bytes.
const BUFFER: i32 = size_of::<Words>() as i32;
const START: i32 = offset_of!(Words, start) as i32;
const LENGTH: i32 = offset_of!(Words, len) as i32;
const _: () = assert!(BUFFER == 16 && START == 0 && LENGTH == 8, "two words of 64 bits");
/// Form of a word.
const WORD_FORM: Form = Form::One(Ty::U32);
/// Flags of conversions between types of one size.
const BITCAST: MemFlagsData = MemFlagsData::new().with_endianness(ir::Endianness::Little);

/// Settings of Cranelift for this machine, with all of its internal checks if `checked`.
pub(crate) fn host(checked: bool) -> Result<Machine, Error> {
    let builder = cranelift_native::builder().map_err(|why| Error::Machine(why.into()))?;
    let mut flags = settings::builder();
    let mut set = |name: &str, value: &str| {
        flags
            .set(name, value)
            .expect("this version of Cranelift has the setting");
    };
    set("opt_level", "none");
    set("enable_verifier", if checked { "true" } else { "false" });
    set("regalloc_checker", if checked { "true" } else { "false" });
    set("unwind_info", "false");
    // So that a large frame can't skip over the guard page below the stack.
    set("enable_probestack", "true");
    set("probestack_strategy", "inline");
    let isa = builder
        .finish(settings::Flags::new(flags))
        .map_err(|error| Error::Machine(error.to_string()))?;
    match isa.triple().architecture {
        Architecture::X86_64 if !has(&*isa, "has_sse41") => Err(Error::Machine(
            "this processor has no SSE4.1, which code compiled at run time needs".into(),
        )),
        Architecture::X86_64 | Architecture::Aarch64(_) => Ok(Machine(isa)),
        other => Err(Error::Machine(format!(
            "there is no code for {other}; allowed: 64-bit x86, 64-bit ARM"
        ))),
    }
}

fn has(isa: &dyn TargetIsa, flag: &str) -> bool {
    isa.isa_flags()
        .iter()
        .any(|value| value.name == flag && value.as_bool() == Some(true))
}

impl Machine {
    /// The machine and its processor's features.
    pub(crate) fn description(&self) -> String {
        let flags = self.0.isa_flags().into_iter().map(|flag| format!(" {flag}"));
        format!("{}{}", self.0.triple(), flags.collect::<String>())
    }

    /// Compiles a program to machine code.
    pub(crate) fn compile(&self, trees: &Trees, lanes: u32) -> Result<Vec<u8>, Error> {
        let isa = &*self.0;
        let call = if cfg!(target_arch = "x86_64") {
            CallConv::SystemV
        } else {
            CallConv::triple_default(isa.triple())
        };
        let mut signature = Signature::new(call);
        signature.params = [isa.pointer_type(), I32, I32, I64].map(AbiParam::new).into();
        signature.returns.push(AbiParam::new(I32));
        let mut context = Context::new();
        context.func = ir::Function::with_name_signature(UserFuncName::user(0, 0), signature);
        let mut builder_context = FunctionBuilderContext::new();
        let mut asm = Clif::new(
            isa,
            FunctionBuilder::new(&mut context.func, &mut builder_context),
            trees,
        );
        emit(&mut asm, trees, lanes);
        asm.end(isa);
        let compiled = context
            .compile(isa, &mut ControlPlane::default())
            .map_err(|error| match error.inner {
                CodegenError::CodeTooLarge | CodegenError::ImplLimitExceeded => Error::TooLarge,
                other => Error::Backend(format!("{other:?}")),
            })?;
        let frame = compiled
            .buffer
            .frame_layout()
            .ok_or_else(|| Error::Backend("the size of its frame is unknown".into()))?;
        if u64::from(frame.frame_to_fp_offset) > FRAME {
            return Err(Error::TooLarge);
        }
        match compiled.buffer.relocs() {
            [] => Ok(compiled.code_buffer().to_vec()),
            [first, ..] => Err(Error::Backend(format!("the code refers to {:?}", first.target))),
        }
    }
}

/// Address and length of a buffer.
#[derive(Clone, Copy, Debug)]
struct Buffer {
    start: ir::Value,
    words: ir::Value,
}

/// Writes Cranelift's intermediate language.
struct Clif<'a> {
    builder: FunctionBuilder<'a>,
    is_x86: bool,
    buffers: Vec<Buffer>,
    workgroup: ir::Value,
    first_lane: ir::Value,
    /// Turns left for loops, and the block to go to when there are none.
    turns_left: Variable,
    used_up: ir::Block,
    /// Memory that idle lanes store to, as long as the longest element.
    sink: StackSlot,
    control: Control<ir::Block>,
}

fn scalar(ty: Ty) -> ir::Type {
    match ty {
        Ty::F32 => F32,
        Ty::I32 | Ty::U32 => I32,
        Ty::Bool => I8,
    }
}

fn clif_type(form: Form) -> ir::Type {
    match form {
        Form::One(ty) => scalar(ty),
        Form::Vector(Ty::F32) => F32X4,
        Form::Vector(_) => I32X4,
    }
}

/// A scalar or a vector, as `form` is, of another type.
fn like(form: Form, ty: Ty) -> ir::Type {
    clif_type(match form {
        Form::One(_) => Form::One(ty),
        Form::Vector(_) => Form::Vector(ty),
    })
}

/// Byte offset of a word. No element is large enough for it to overflow, since [`FRAME`] also limits elements.
fn displacement(words: u32) -> i32 {
    (words * WORD) as i32
}

/// Properties of loads and stores: they never trap. Words are aligned; vectors may start at any word.
fn memory_flags(form: Form) -> MemFlagsData {
    match form {
        Form::One(_) => MemFlagsData::trusted(),
        Form::Vector(_) => MemFlagsData::new().with_notrap(),
    }
}

/// Four consecutive words.
fn words(words: [u32; 4]) -> V128Imm {
    let mut bytes = [0; 16];
    for (bytes, word) in bytes.chunks_exact_mut(4).zip(words) {
        bytes.copy_from_slice(&word.to_le_bytes());
    }
    V128Imm(bytes)
}

fn stack_slot(builder: &mut FunctionBuilder<'_>, words: u32) -> StackSlot {
    let data = StackSlotData::new(StackSlotKind::ExplicitSlot, words * WORD, 4);
    builder.create_sized_stack_slot(data)
}

impl<'a> Clif<'a> {
    /// Begins the function: loads the buffers' pointers and lengths.
    fn new(isa: &dyn TargetIsa, mut builder: FunctionBuilder<'a>, trees: &Trees) -> Self {
        let entry = builder.create_block();
        builder.append_block_params_for_function_params(entry);
        builder.switch_to_block(entry);
        builder.seal_block(entry);
        let &[buffers, workgroup, first_lane, turns] = builder.block_params(entry) else {
            unreachable!("the signature has four parameters")
        };
        let mut load = |offset| {
            let flags = MemFlagsData::trusted();
            builder.ins().load(isa.pointer_type(), flags, buffers, offset)
        };
        let buffers = (0..trees.strides.len() as i32)
            .map(|at| Buffer {
                start: load(at * BUFFER + START),
                words: load(at * BUFFER + LENGTH),
            })
            .collect();
        let longest = longest_element(trees);
        let turns_left = builder.declare_var(I64);
        builder.def_var(turns_left, turns);
        Self {
            is_x86: isa.triple().architecture == Architecture::X86_64,
            buffers,
            workgroup,
            first_lane,
            turns_left,
            used_up: builder.create_block(),
            sink: stack_slot(&mut builder, longest),
            control: Control::default(),
            builder,
        }
    }

    /// Ends the function, whose emitted code ends with a return.
    fn end(mut self, isa: &dyn TargetIsa) {
        // The block after that return is never reached, but must also end.
        self.builder.ins().trap(TrapCode::unwrap_user(1));
        self.start_sealed(self.used_up);
        let result = self.builder.ins().iconst(I32, 1);
        self.builder.ins().return_(&[result]);
        self.builder.finalize(isa.frontend_config());
    }

    fn vector(&mut self, bits: [u32; 4]) -> ir::Value {
        let constant = self.builder.func.dfg.constants.insert(words(bits).0.as_slice().into());
        self.builder.ins().vconst(I32X4, constant)
    }

    fn cast(&mut self, to: ir::Type, a: ir::Value) -> ir::Value {
        if self.builder.func.dfg.value_type(a) == to {
            a
        } else {
            self.builder.ins().bitcast(to, BITCAST, a)
        }
    }

    /// An operation that vectors have no instruction for.
    fn lane_by_lane(&mut self, op: Binary, ty: Ty, a: ir::Value, b: ir::Value) -> ir::Value {
        let mut out = a;
        for lane in 0..Self::LANES as u8 {
            let operands = [a, b].map(|vector| self.builder.ins().extractlane(vector, lane));
            let word = self.binary(op, Form::One(ty), operands[0], operands[1]);
            out = self.builder.ins().insertlane(out, word, lane);
        }
        out
    }

    /// Pointer to a word, given its index in 64 bits.
    fn pointer(&mut self, start: ir::Value, index: ir::Value) -> ir::Value {
        let bytes = self.builder.ins().ishl_imm_u(index, 2);
        self.builder.ins().iadd(start, bytes)
    }

    fn compare(&mut self, op: Binary, ty: Ty, a: ir::Value, b: ir::Value) -> Option<ir::Value> {
        let float = match op {
            Binary::Equal => FloatCC::Equal,
            Binary::NotEqual => FloatCC::NotEqual,
            Binary::Less => FloatCC::LessThan,
            Binary::LessEqual => FloatCC::LessThanOrEqual,
            Binary::Greater => FloatCC::GreaterThan,
            Binary::GreaterEqual => FloatCC::GreaterThanOrEqual,
            _ => return None,
        };
        if ty == Ty::F32 {
            return Some(self.builder.ins().fcmp(float, a, b));
        }
        let signed = ty == Ty::I32;
        let int = match op {
            Binary::Equal => IntCC::Equal,
            Binary::NotEqual => IntCC::NotEqual,
            Binary::Less if signed => IntCC::SignedLessThan,
            Binary::LessEqual if signed => IntCC::SignedLessThanOrEqual,
            Binary::Greater if signed => IntCC::SignedGreaterThan,
            Binary::GreaterEqual if signed => IntCC::SignedGreaterThanOrEqual,
            Binary::Less => IntCC::UnsignedLessThan,
            Binary::LessEqual => IntCC::UnsignedLessThanOrEqual,
            Binary::Greater => IntCC::UnsignedGreaterThan,
            _ => IntCC::UnsignedGreaterThanOrEqual,
        };
        Some(self.builder.ins().icmp(int, a, b))
    }

    /// `a < b ? a : b`, or `a > b ? a : b`, in the form that Cranelift matches to a single x86 instruction.
    fn extreme(&mut self, form: Form, a: ir::Value, b: ir::Value, least: bool) -> ir::Value {
        let (x, y) = if least { (a, b) } else { (b, a) };
        let less = self.builder.ins().fcmp(FloatCC::LessThan, x, y);
        if let Form::One(_) = form {
            return self.builder.ins().select(less, a, b);
        }
        let mask = self.cast(F32X4, less);
        self.builder.ins().bitselect(mask, a, b)
    }

    /// Converts floats to integers.
    fn convert_to_integer(&mut self, form: Form, to: Ty, a: ir::Value) -> ir::Value {
        let (low, high): (f32, f32) = if to == Ty::I32 {
            (-2_147_483_648.0, 2_147_483_520.0)
        } else {
            (0.0, 4_294_967_040.0)
        };
        let [low, high] = [low, high].map(|bound| self.constant(form, bound.to_bits()));
        if self.is_x86 && form == Form::Vector(Ty::F32) {
            return self.convert_to_integer_on_x86(to, a, low, high);
        }
        let above = self.extreme(form, a, low, false);
        let within = self.extreme(form, above, high, true);
        if to == Ty::I32 {
            self.builder.ins().fcvt_to_sint_sat(like(form, to), within)
        } else {
            self.builder.ins().fcvt_to_uint_sat(like(form, to), within)
        }
    }

    /// The same for vectors, with the instruction of x86, which makes `1 << 31` of all numbers that aren't signed integers.
    fn convert_to_integer_on_x86(&mut self, to: Ty, a: ir::Value, low: ir::Value, high: ir::Value) -> ir::Value {
        let form = Form::Vector(Ty::F32);
        if to == Ty::I32 {
            // That is already the right result for NaN, which is kept here, and for numbers below the smallest integer.
            let within = self.extreme(form, high, a, true);
            return self.builder.ins().x86_cvtt2dq(I32X4, within);
        }
        let above = self.extreme(form, a, low, false);
        let within = self.extreme(form, above, high, true);
        // Of a number and the number less 2^32, one is a signed integer, and has the bits of the result.
        let wrap = self.constant(form, 4_294_967_296.0_f32.to_bits());
        let wrapped = self.builder.ins().fsub(within, wrap);
        let [direct, wrapped] = [within, wrapped].map(|a| self.builder.ins().x86_cvtt2dq(I32X4, a));
        let both = self.builder.ins().bxor(direct, wrapped);
        let none = self.vector([1 << 31; 4]);
        self.builder.ins().bxor(both, none)
    }
}

impl Blocks for Clif<'_> {
    type Value = ir::Value;
    type Block = ir::Block;

    fn control(&mut self) -> &mut Control<ir::Block> {
        &mut self.control
    }

    fn create(&mut self, is_rare: bool) -> ir::Block {
        let block = self.builder.create_block();
        if is_rare {
            self.builder.set_cold_block(block);
        }
        block
    }

    fn mark_rare(&mut self) {
        if let Some(block) = self.builder.current_block() {
            self.builder.set_cold_block(block);
        }
    }

    fn start(&mut self, block: ir::Block) {
        self.builder.switch_to_block(block);
    }

    fn seal(&mut self, block: ir::Block) {
        self.builder.seal_block(block);
    }

    fn jump(&mut self, to: ir::Block) {
        self.builder.ins().jump(to, &[] as &[BlockArg]);
    }

    fn branch(&mut self, condition: ir::Value, accept: ir::Block, reject: ir::Block) {
        let none: &[BlockArg] = &[];
        self.builder.ins().brif(condition, accept, none, reject, none);
    }
}

impl Assembler for Clif<'_> {
    const LANES: u32 = 4;
    const STORES_MASKED: bool = false;
    type Variable = Variable;
    type Pointers = [ir::Value; 4];
    type Array = StackSlot;

    fn workgroup(&mut self) -> ir::Value {
        self.workgroup
    }

    fn first_lane(&mut self) -> ir::Value {
        self.first_lane
    }

    fn elements(&mut self, buffer: u32, stride: u32) -> ir::Value {
        let words = self.buffers[buffer as usize].words;
        let words = self.builder.ins().ireduce(I32, words);
        if stride == 1 {
            return words;
        }
        let stride = self.builder.ins().iconst(I32, i64::from(stride));
        self.builder.ins().udiv(words, stride)
    }

    fn constant(&mut self, form: Form, bits: u32) -> ir::Value {
        match form {
            Form::One(Ty::F32) => self.builder.ins().f32const(f32::from_bits(bits)),
            Form::One(ty) => self.builder.ins().iconst(scalar(ty), i64::from(bits)),
            Form::Vector(Ty::F32) => {
                let constant = self.vector([bits; 4]);
                self.cast(F32X4, constant)
            }
            Form::Vector(Ty::Bool) => self.vector([0_u32.wrapping_sub(bits); 4]),
            Form::Vector(_) => self.vector([bits; 4]),
        }
    }

    fn ramp(&mut self, first: u32) -> ir::Value {
        self.vector([first, first + 1, first + 2, first + 3])
    }

    fn splat(&mut self, ty: Ty, value: ir::Value) -> ir::Value {
        let value = if ty == Ty::Bool {
            let word = self.builder.ins().uextend(I32, value);
            self.builder.ins().ineg(word)
        } else {
            value
        };
        self.builder.ins().splat(clif_type(Form::Vector(ty)), value)
    }

    fn unary(&mut self, op: Unary, form: Form, a: ir::Value) -> ir::Value {
        let (Form::One(ty) | Form::Vector(ty)) = form;
        match (op, ty) {
            (Unary::Negate, Ty::F32) => self.builder.ins().fneg(a),
            (Unary::Negate, _) => self.builder.ins().ineg(a),
            (Unary::Not, Ty::Bool) if form == Form::One(ty) => self.builder.ins().bxor_imm_u(a, 1),
            (Unary::Not, _) => self.builder.ins().bnot(a),
            (Unary::Abs, Ty::F32) => self.builder.ins().fabs(a),
            (Unary::Abs, Ty::I32) => self.builder.ins().iabs(a),
            (Unary::Abs, _) => a,
            (Unary::Floor, _) => self.builder.ins().floor(a),
            (Unary::Trunc, _) => self.builder.ins().trunc(a),
        }
    }

    fn binary(&mut self, op: Binary, form: Form, a: ir::Value, b: ir::Value) -> ir::Value {
        let (Form::One(ty) | Form::Vector(ty)) = form;
        let (float, signed) = (ty == Ty::F32, ty == Ty::I32);
        if let Some(result) = self.compare(op, ty, a, b) {
            return result;
        }
        match op {
            Binary::Min if float => return self.extreme(form, a, b, true),
            Binary::Max if float => return self.extreme(form, a, b, false),
            Binary::Divide | Binary::Remainder if form == Form::Vector(ty) => return self.lane_by_lane(op, ty, a, b),
            _ => {}
        }
        let ins = self.builder.ins();
        match op {
            Binary::Add if float => ins.fadd(a, b),
            Binary::Subtract if float => ins.fsub(a, b),
            Binary::Multiply if float => ins.fmul(a, b),
            Binary::Add => ins.iadd(a, b),
            Binary::Subtract => ins.isub(a, b),
            Binary::Multiply => ins.imul(a, b),
            Binary::Divide => ins.udiv(a, b),
            Binary::Remainder => ins.urem(a, b),
            Binary::Min if signed => ins.smin(a, b),
            Binary::Max if signed => ins.smax(a, b),
            Binary::Min => ins.umin(a, b),
            Binary::Max => ins.umax(a, b),
            Binary::And => ins.band(a, b),
            Binary::Or => ins.bor(a, b),
            Binary::Xor => ins.bxor(a, b),
            Binary::ShiftLeft => ins.ishl(a, b),
            Binary::ShiftRight if signed => ins.sshr(a, b),
            Binary::ShiftRight => ins.ushr(a, b),
            _ => unreachable!("a comparison has returned"),
        }
    }

    fn shift_each(&mut self, op: Binary, ty: Ty, a: ir::Value, counts: ir::Value) -> ir::Value {
        self.lane_by_lane(op, ty, a, counts)
    }

    fn select(&mut self, condition: ir::Value, accept: ir::Value, reject: ir::Value) -> ir::Value {
        self.builder.ins().select(condition, accept, reject)
    }

    fn blend(&mut self, ty: Ty, mask: ir::Value, accept: ir::Value, reject: ir::Value) -> ir::Value {
        let (accept, reject) = (self.cast(I32X4, accept), self.cast(I32X4, reject));
        // Each is one instruction on its architecture.
        let words = if self.is_x86 {
            self.builder.ins().blendv(mask, accept, reject)
        } else {
            self.builder.ins().bitselect(mask, accept, reject)
        };
        self.cast(clif_type(Form::Vector(ty)), words)
    }

    // A mask has words of all ones and all zeros.

    fn masked(&mut self, mask: ir::Value, words: ir::Value) -> ir::Value {
        self.builder.ins().band(mask, words)
    }

    fn mask_of(&mut self, words: ir::Value) -> ir::Value {
        words
    }

    fn convert(&mut self, from: Form, to: Ty, a: ir::Value) -> ir::Value {
        match (from, to) {
            (Form::One(Ty::F32) | Form::Vector(Ty::F32), Ty::I32 | Ty::U32) => self.convert_to_integer(from, to, a),
            (Form::One(Ty::Bool), Ty::I32 | Ty::U32) => self.builder.ins().uextend(I32, a),
            (Form::One(Ty::I32) | Form::Vector(Ty::I32), Ty::F32) => {
                self.builder.ins().fcvt_from_sint(like(from, Ty::F32), a)
            }
            (Form::One(Ty::U32) | Form::Vector(Ty::U32), Ty::F32) => {
                self.builder.ins().fcvt_from_uint(like(from, Ty::F32), a)
            }
            _ => a,
        }
    }

    fn bitcast(&mut self, from: Form, to: Ty, a: ir::Value) -> ir::Value {
        self.cast(like(from, to), a)
    }

    fn any(&mut self, mask: ir::Value) -> ir::Value {
        self.builder.ins().vany_true(mask)
    }

    fn buffer_pointer(&mut self, buffer: u32, index: ir::Value) -> ir::Value {
        let index = self.builder.ins().uextend(I64, index);
        self.pointer(self.buffers[buffer as usize].start, index)
    }

    fn buffer_pointers(&mut self, buffer: u32, indices: ir::Value, mask: Option<ir::Value>) -> [ir::Value; 4] {
        let start = self.buffers[buffer as usize].start;
        // Two indices at a time, since extracting from a vector is slower than shifting in a register.
        let pairs = self.cast(I64X2, indices);
        let [low, high] = [0, 1].map(|pair| self.builder.ins().extractlane(pairs, pair));
        [(0, low), (1, low), (2, high), (3, high)].map(|(lane, pair)| {
            let index = if lane % 2 == 1 {
                self.builder.ins().ushr_imm_u(pair, 32)
            } else {
                let word = self.builder.ins().ireduce(I32, pair);
                self.builder.ins().uextend(I64, word)
            };
            let pointer = self.pointer(start, index);
            let Some(mask) = mask else {
                return pointer;
            };
            let active = self.builder.ins().extractlane(mask, lane);
            let sink = self.builder.ins().stack_addr(I64, self.sink, 0);
            self.select(active, pointer, sink)
        })
    }

    fn array(&mut self, words: u32) -> StackSlot {
        stack_slot(&mut self.builder, words)
    }

    fn array_pointer(&mut self, array: StackSlot, index: ir::Value) -> ir::Value {
        let start = self.builder.ins().stack_addr(I64, array, 0);
        let index = self.builder.ins().uextend(I64, index);
        self.pointer(start, index)
    }

    fn load(&mut self, form: Form, pointer: ir::Value, offset: u32) -> ir::Value {
        let offset = displacement(offset);
        self.builder
            .ins()
            .load(clif_type(form), memory_flags(form), pointer, offset)
    }

    fn store(&mut self, form: Form, pointer: ir::Value, offset: u32, value: ir::Value) {
        let offset = displacement(offset);
        self.builder.ins().store(memory_flags(form), value, pointer, offset);
    }

    fn store_masked(&mut self, _: ir::Value, _: u32, _: ir::Value, _: ir::Value) {
        unreachable!("vectors of 128 bits have no such instruction")
    }

    fn gather(&mut self, pointers: &[ir::Value; 4], offset: u32) -> ir::Value {
        let word = self.load(WORD_FORM, pointers[0], offset);
        let mut words = self.builder.ins().scalar_to_vector(I32X4, word);
        for (lane, pointer) in (1..).zip(&pointers[1..]) {
            let word = self.load(WORD_FORM, *pointer, offset);
            words = self.builder.ins().insertlane(words, word, lane);
        }
        words
    }

    fn gather_four(&mut self, pointers: &[ir::Value; 4], offset: u32) -> [ir::Value; 4] {
        let rows = pointers.map(|pointer| self.load(Form::Vector(Ty::U32), pointer, offset));
        // Interleaved words and joined halves of two vectors: x86 and ARM have instructions for both.
        let mut shuffle = |a, b, order: [u8; 4]| {
            let mut bytes = [0; 16];
            for (at, byte) in bytes.iter_mut().enumerate() {
                *byte = order[at / 4] * 4 + at as u8 % 4;
            }
            let mask = self.builder.func.dfg.immediates.push(bytes.as_slice().into());
            let [a, b] = [a, b].map(|row| self.cast(I8X16, row));
            let bytes = self.builder.ins().shuffle(a, b, mask);
            self.cast(I32X4, bytes)
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

    fn scatter(&mut self, pointers: &[ir::Value; 4], offset: u32, words: ir::Value) {
        for (lane, pointer) in (0..).zip(pointers) {
            let word = self.builder.ins().extractlane(words, lane);
            self.store(WORD_FORM, *pointer, offset, word);
        }
    }

    fn variable(&mut self, form: Form) -> Variable {
        self.builder.declare_var(clif_type(form))
    }

    fn pointer_variable(&mut self) -> Variable {
        self.builder.declare_var(I64)
    }

    fn get(&mut self, variable: Variable) -> ir::Value {
        self.builder.use_var(variable)
    }

    fn set(&mut self, variable: Variable, value: ir::Value) {
        self.builder.def_var(variable, value);
    }

    fn count_turn(&mut self) {
        let turns = self.get(self.turns_left);
        let any = self.block();
        self.branch(turns, any, self.used_up);
        self.start_sealed(any);
        let turns = self.builder.ins().iadd_imm_s(turns, -1);
        self.set(self.turns_left, turns);
    }

    fn finish(&mut self) {
        let done = self.builder.ins().iconst(I32, 0);
        self.builder.ins().return_(&[done]);
        self.start_unreachable();
    }
}
