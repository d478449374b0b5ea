//! Turns the shader compiler's tree into instructions, in SPMD style like the lane code that is compiled ahead of time.
//! Uniform values are scalars. Varying values take as many vectors as hold all lanes. A branch on a varying condition runs
//! under a mask if any lane takes it.
//!
//! Idle lanes can't reach memory outside the buffers either: indices are clamped in all lanes.

use std::collections::{BTreeMap, BTreeSet};

use oneiro_shader_compiler::Trees;
use oneiro_shader_compiler::tree::{
    Array, Binary, Block, Label, Op, Program, Statement, Ty, Unary, Value, Variable, visit,
};
use oneiro_shader_compiler::uniform::{Region, Shape, Shapes, depth_of};

use crate::assembler::{Assembler, Form};
use crate::share::shared;

mod buffers;

const WORD: Form = Form::One(Ty::U32);
const WORDS: Form = Form::Vector(Ty::U32);
/// The bit of a float's sign.
const SIGN: u32 = 1 << 31;

/// Emits a program for a number of lanes that is a multiple of [`Assembler::LANES`].
pub(crate) fn emit<A: Assembler>(asm: &mut A, trees: &Trees, lanes: u32) {
    let program = &shared(trees);
    let vectors = (lanes / A::LANES) as usize;
    let mut emitter = Emitter {
        program,
        shapes: &trees.shapes,
        asm,
        vectors,
        scalars: vec![None; program.values.len()],
        parts: vec![None; program.values.len() * vectors],
        variables: vec![None; program.variables.len()],
        arrays: vec![None; program.arrays.len()],
        indexed: indexed_arrays(program),
        shared: Vec::new(),
        constants: Vec::new(),
        regions: Vec::new(),
        masks: Vec::new(),
        labels: vec![None; program.labels as usize],
        ends: Vec::new(),
        pointers: BTreeMap::new(),
        uniform_pointers: BTreeMap::new(),
        known: Vec::new(),
        stored_to: None,
        scratch: None,
    };
    for (buffer, stride) in (0..).zip(&trees.strides) {
        let end = emitter.end(buffer, *stride, lanes);
        emitter.ends.push(end);
    }
    emitter.scope(&program.body);
    emitter.asm.finish();
}

/// Arrays with an index that isn't constant. The others become variables, one per element.
fn indexed_arrays(program: &Program) -> BTreeSet<Array> {
    let mut indexed = BTreeSet::new();
    let is_constant = |index: Value| matches!(program.op(index), Op::Constant(_));
    visit(&program.body, &mut |statement| match statement {
        Statement::Let(value) => {
            if let Op::ReadElement(array, index) = program.op(*value)
                && !is_constant(index)
            {
                indexed.insert(array);
            }
        }
        Statement::WriteElement { array, index, .. } if !is_constant(*index) => _ = indexed.insert(*array),
        _ => {}
    });
    indexed
}

/// A variable, and the number of regions around its declaration.
#[derive(Clone, Debug)]
struct Local<T> {
    home: usize,
    /// One part if it is uniform, else one per vector. For an array, the parts of all elements in order.
    parts: Vec<T>,
}

/// A local array.
#[derive(Clone, Debug)]
enum Storage<T, M> {
    /// A variable for each element.
    Variables(Local<T>),
    /// Memory, and the number of regions around its declaration.
    Memory(M, usize),
}

/// Mask of the lanes that are active in a region.
#[derive(Clone, Debug)]
struct Mask<T> {
    parts: Vec<T>,
    /// Number of regions around that one.
    depth: usize,
}

/// The end of a buffer.
#[derive(Clone, Copy, Debug)]
struct End<V> {
    /// Index of the last element, as a scalar and as a vector.
    last: V,
    lasts: V,
    /// Number of elements at which consecutive words of all lanes may start.
    starts: V,
}

/// An element of a buffer in one vector: binding number, index, words per element, and number of the vector.
type Element = (u32, Value, u32, usize);

struct Emitter<'a, A: Assembler> {
    program: &'a Program,
    shapes: &'a Shapes,
    asm: &'a mut A,
    /// Number of vectors that hold all lanes.
    vectors: usize,
    /// Uniform values, and linear values in lane 0.
    scalars: Vec<Option<A::Value>>,
    /// Values in all lanes: the vectors of each value in order.
    parts: Vec<Option<A::Value>>,
    variables: Vec<Option<Local<A::Variable>>>,
    arrays: Vec<Option<Storage<A::Variable, A::Array>>>,
    indexed: BTreeSet<Array>,
    /// Splats and constants shared by the vectors of a statement.
    shared: Vec<(Value, A::Value)>,
    constants: Vec<((Ty, u32), A::Value)>,
    regions: Vec<Region>,
    masks: Vec<Mask<A::Variable>>,
    labels: Vec<Option<A::Label>>,
    /// Ends of the buffers.
    ends: Vec<End<A::Value>>,
    /// Pointers that are already computed at this point, and their elements in the order in which they were.
    pointers: BTreeMap<Element, A::Pointers>,
    uniform_pointers: BTreeMap<Element, A::Value>,
    known: Vec<Element>,
    /// The element last stored to under the current mask, with the pointers of its active lanes.
    stored_to: Option<(Element, Vec<A::Pointers>)>,
    /// Memory of one word per lane.
    scratch: Option<A::Array>,
}

impl<A: Assembler> Emitter<'_, A> {
    fn end(&mut self, buffer: u32, stride: u32, lanes: u32) -> End<A::Value> {
        let elements = self.asm.elements(buffer, stride);
        let [zero, one, others] = [0, 1, lanes - 1].map(|word| self.word(word));
        let last = self.arithmetic(Binary::Subtract, elements, one);
        let starts = self.arithmetic(Binary::Subtract, elements, others);
        let holds_all = self.arithmetic(Binary::Greater, elements, others);
        End {
            last,
            lasts: self.asm.splat(Ty::U32, last),
            starts: self.asm.select(holds_all, starts, zero),
        }
    }

    // Scalars.

    fn word(&mut self, bits: u32) -> A::Value {
        self.asm.constant(WORD, bits)
    }

    fn arithmetic(&mut self, op: Binary, a: A::Value, b: A::Value) -> A::Value {
        self.asm.binary(op, WORD, a, b)
    }

    /// An operation on scalars. Division by zero divides by one instead.
    fn operation(&mut self, op: Binary, ty: Ty, a: A::Value, b: A::Value) -> A::Value {
        let b = if matches!(op, Binary::Divide | Binary::Remainder) {
            let one = self.word(1);
            self.arithmetic(Binary::Max, b, one)
        } else {
            b
        };
        self.asm.binary(op, Form::One(ty), a, b)
    }

    /// A uniform value, or a linear value in lane 0.
    fn scalar(&mut self, value: Value) -> A::Value {
        match self.program.op(value) {
            Op::Constant(bits) => self.asm.constant(Form::One(self.program.ty(value)), bits),
            _ => self.scalars[value.0 as usize].expect("it is set before it is used, and not varying"),
        }
    }

    fn hold_scalar(&mut self, value: Value, scalar: A::Value) {
        self.scalars[value.0 as usize] = Some(scalar);
    }

    /// Spreads a uniform or linear value over a vector. Cranelift drops it if nothing uses it.
    fn spread(&mut self, value: Value, k: usize) {
        let scalar = self.scalar(value);
        let mut part = match self.shared.iter().find(|(other, _)| *other == value) {
            Some((_, known)) => *known,
            None => self.asm.splat(self.program.ty(value), scalar),
        };
        self.shared.push((value, part));
        if self.shapes.shape(value) == Shape::Linear {
            let ramp = self.asm.ramp(k as u32 * A::LANES);
            part = self.asm.binary(Binary::Add, WORDS, part, ramp);
        }
        self.hold_part(value, k, part);
    }

    fn uniform(&mut self, value: Value) -> A::Value {
        let ty = self.program.ty(value);
        match self.program.op(value) {
            Op::Constant(_) | Op::Loaded => unreachable!("it is not computed"),
            Op::Lane => self.asm.first_lane(),
            Op::Workgroup => self.asm.workgroup(),
            Op::Read(variable) => {
                let part = self.variable(variable).parts[0];
                self.asm.get(part)
            }
            Op::ReadElement(array, index) => self.uniform_element(array, index),
            Op::Unary(op, a) => {
                let a = self.scalar(a);
                self.asm.unary(op, Form::One(ty), a)
            }
            Op::Binary(op, a, b) => {
                let from = self.program.ty(a);
                let (a, b) = (self.scalar(a), self.scalar(b));
                self.operation(op, from, a, b)
            }
            Op::Select {
                condition,
                accept,
                reject,
            } => {
                let [condition, accept, reject] = [condition, accept, reject].map(|value| self.scalar(value));
                self.asm.select(condition, accept, reject)
            }
            Op::Convert(a) => {
                let from = self.program.ty(a);
                let a = self.scalar(a);
                match (from, ty) {
                    (Ty::Bool, Ty::F32) => {
                        let word = self.asm.convert(Form::One(from), Ty::U32, a);
                        self.asm.convert(WORD, Ty::F32, word)
                    }
                    (Ty::F32 | Ty::I32 | Ty::U32, Ty::Bool) => {
                        let zero = self.asm.constant(Form::One(from), 0);
                        self.asm.binary(Binary::NotEqual, Form::One(from), a, zero)
                    }
                    _ => self.asm.convert(Form::One(from), ty, a),
                }
            }
            Op::Bitcast(a) => {
                let from = self.program.ty(a);
                let a = self.scalar(a);
                self.asm.bitcast(Form::One(from), ty, a)
            }
        }
    }

    // Vectors.

    /// A vector with the same constant in every lane.
    fn constant(&mut self, ty: Ty, bits: u32) -> A::Value {
        if let Some((_, known)) = self.constants.iter().find(|(other, _)| *other == (ty, bits)) {
            return *known;
        }
        let constant = self.asm.constant(Form::Vector(ty), bits);
        self.constants.push(((ty, bits), constant));
        constant
    }

    /// One vector of a value for all lanes.
    fn part(&mut self, value: Value, k: usize) -> A::Value {
        match self.program.op(value) {
            Op::Constant(bits) => self.constant(self.program.ty(value), bits),
            _ => self.parts[value.0 as usize * self.vectors + k].expect("it is set before it is used"),
        }
    }

    fn hold_part(&mut self, value: Value, k: usize, part: A::Value) {
        self.parts[value.0 as usize * self.vectors + k] = Some(part);
    }

    fn varying(&mut self, value: Value, k: usize, pointer: Option<A::Value>) -> A::Value {
        let ty = self.program.ty(value);
        match self.program.op(value) {
            Op::Constant(_) | Op::Lane | Op::Workgroup | Op::Loaded => unreachable!("it does not vary by itself"),
            Op::Read(variable) => {
                let part = self.variable(variable).parts[k];
                self.asm.get(part)
            }
            Op::ReadElement(array, index) => {
                if let Some(pointer) = pointer {
                    let words = self
                        .asm
                        .load(Form::Vector(Self::stored(ty)), pointer, k as u32 * A::LANES);
                    return if ty == Ty::Bool { self.asm.mask_of(words) } else { words };
                }
                let part = self.element_variable(array, index, k);
                self.asm.get(part)
            }
            Op::Unary(op, a) => self.varying_unary(op, a, k),
            Op::Binary(op, a, b) => self.varying_binary(op, a, b, k),
            Op::Select {
                condition,
                accept,
                reject,
            } => {
                let (accept, reject) = (self.part(accept, k), self.part(reject, k));
                if self.shapes.is_uniform(condition) {
                    let condition = self.scalar(condition);
                    self.asm.select(condition, accept, reject)
                } else {
                    let mask = self.part(condition, k);
                    self.asm.blend(ty, mask, accept, reject)
                }
            }
            Op::Convert(a) => {
                let from = self.type_to_convert(a);
                let a = self.part(a, k);
                match (from, ty) {
                    (Ty::Bool, Ty::F32 | Ty::I32 | Ty::U32) => {
                        let one = if ty == Ty::F32 { 1.0_f32.to_bits() } else { 1 };
                        let bits = self.masked_bits(a, one);
                        self.asm.bitcast(WORDS, ty, bits)
                    }
                    (Ty::F32 | Ty::I32 | Ty::U32, Ty::Bool) => {
                        let zeros = self.asm.constant(Form::Vector(from), 0);
                        self.asm.binary(Binary::NotEqual, Form::Vector(from), a, zeros)
                    }
                    _ => self.asm.convert(Form::Vector(from), ty, a),
                }
            }
            Op::Bitcast(a) => {
                let from = self.program.ty(a);
                let a = self.part(a, k);
                self.asm.bitcast(Form::Vector(from), ty, a)
            }
        }
    }

    /// Type from which a value is converted: its own, or that of signed integers if it is sure to be less than 2^31. These
    /// have the same bits, and are converted in one instruction on all processors.
    fn type_to_convert(&self, value: Value) -> Ty {
        let is = |value, fits: fn(u32) -> bool| matches!(self.program.op(value), Op::Constant(bits) if fits(bits));
        let is_small = match (self.program.ty(value), self.program.op(value)) {
            (Ty::U32, Op::Binary(Binary::And, a, b)) => [a, b].into_iter().any(|mask| is(mask, |bits| bits < 1 << 31)),
            (Ty::U32, Op::Binary(Binary::ShiftRight, _, count)) => is(count, |count| count % 32 > 0),
            _ => false,
        };
        if is_small { Ty::I32 } else { self.program.ty(value) }
    }

    /// The given bits in lanes where the mask is set, else 0.
    fn masked_bits(&mut self, mask: A::Value, bits: u32) -> A::Value {
        let bits = self.constant(Ty::U32, bits);
        self.asm.masked(mask, bits)
    }

    /// The size and the negative of floats only change their sign's bit.
    fn varying_unary(&mut self, op: Unary, a: Value, k: usize) -> A::Value {
        let ty = self.program.ty(a);
        let vector = self.part(a, k);
        let (op, bits) = match (op, ty) {
            (Unary::Abs, Ty::F32) => (Binary::And, !SIGN),
            (Unary::Negate, Ty::F32) => (Binary::Xor, SIGN),
            _ => return self.asm.unary(op, Form::Vector(ty), vector),
        };
        let words = self.asm.bitcast(Form::Vector(ty), Ty::U32, vector);
        let bits = self.constant(Ty::U32, bits);
        let words = self.asm.binary(op, WORDS, words, bits);
        self.asm.bitcast(WORDS, ty, words)
    }

    fn varying_binary(&mut self, op: Binary, a: Value, b: Value, k: usize) -> A::Value {
        let ty = self.program.ty(a);
        let vector = self.part(a, k);
        let shifts = matches!(op, Binary::ShiftLeft | Binary::ShiftRight);
        if shifts && self.shapes.is_uniform(b) {
            let count = self.scalar(b);
            return self.asm.binary(op, Form::Vector(ty), vector, count);
        }
        let mut with = self.part(b, k);
        if shifts {
            return self.asm.shift_each(op, ty, vector, with);
        }
        if matches!(op, Binary::Divide | Binary::Remainder) {
            let ones = self.constant(Ty::U32, 1);
            with = self.asm.binary(Binary::Max, WORDS, with, ones);
        }
        self.asm.binary(op, Form::Vector(ty), vector, with)
    }

    // Locals.

    fn variable(&self, variable: Variable) -> &Local<A::Variable> {
        self.variables[variable.0 as usize]
            .as_ref()
            .expect("a variable is declared before it is used")
    }

    /// Declares a variable, uniform or one per lane, initialised with a constant.
    fn declared(&mut self, ty: Ty, varies: bool, init: u32) -> Vec<A::Variable> {
        let (form, parts) = if varies {
            (Form::Vector(ty), self.vectors)
        } else {
            (Form::One(ty), 1)
        };
        let value = self.asm.constant(form, init);
        let declare = |_| {
            let part = self.asm.variable(form);
            self.asm.set(part, value);
            part
        };
        (0..parts).map(declare).collect()
    }

    fn element_type(&self, array: Array) -> Ty {
        self.program.arrays[array.0 as usize].ty
    }

    /// Type of an array's elements in memory, where truth values are words.
    fn stored(ty: Ty) -> Ty {
        if ty == Ty::Bool { Ty::U32 } else { ty }
    }

    fn declare_array(&mut self, array: Array) {
        let program = self.program;
        let info = &program.arrays[array.0 as usize];
        let varies = self.shapes.array_varies(array);
        let home = self.regions.len();
        let slot = array.0 as usize;
        if !self.indexed.contains(&array) {
            let mut parts = Vec::new();
            for bits in &info.init {
                parts.extend(self.declared(info.ty, varies, *bits));
            }
            self.arrays[slot] = Some(Storage::Variables(Local { home, parts }));
            return;
        }
        let words = self.element_words(array);
        let memory = self.asm.array(info.init.len() as u32 * words);
        self.arrays[slot] = Some(Storage::Memory(memory, home));
        let zero = self.word(0);
        let start = self.asm.array_pointer(memory, zero);
        let ty = Self::stored(info.ty);
        for (at, &bits) in (0..).zip(&info.init) {
            if varies {
                let bits = if info.ty == Ty::Bool {
                    0_u32.wrapping_sub(bits)
                } else {
                    bits
                };
                let value = self.asm.constant(Form::Vector(ty), bits);
                for k in 0..self.vectors as u32 {
                    self.asm
                        .store(Form::Vector(ty), start, at * words + k * A::LANES, value);
                }
            } else {
                let value = self.asm.constant(Form::One(ty), bits);
                self.asm.store(Form::One(ty), start, at, value);
            }
        }
    }

    /// Words per element in memory.
    fn element_words(&self, array: Array) -> u32 {
        if self.shapes.array_varies(array) {
            self.vectors as u32 * A::LANES
        } else {
            1
        }
    }

    fn storage(&self, array: Array) -> &Storage<A::Variable, A::Array> {
        self.arrays[array.0 as usize]
            .as_ref()
            .expect("an array is declared before it is used")
    }

    /// The variable of an array's element, or of one of its vectors.
    fn element_variable(&self, array: Array, index: Value, k: usize) -> A::Variable {
        let (Storage::Variables(local), Op::Constant(index)) = (self.storage(array), self.program.op(index)) else {
            unreachable!("an array that has other indices than constants is in memory")
        };
        let elements = self.program.arrays[array.0 as usize].init.len();
        let each = local.parts.len() / elements;
        local.parts[(index as usize).min(elements - 1) * each + k]
    }

    /// Pointer to an element, if its array is in memory.
    fn element_pointer(&mut self, array: Array, index: Value) -> Option<A::Value> {
        let Storage::Memory(memory, _) = *self.storage(array) else {
            return None;
        };
        let last = self.program.arrays[array.0 as usize].init.len() as u32 - 1;
        let words = self.element_words(array);
        let (index, last, words) = (self.scalar(index), self.word(last), self.word(words));
        let clamped = self.arithmetic(Binary::Min, index, last);
        let at = self.arithmetic(Binary::Multiply, clamped, words);
        Some(self.asm.array_pointer(memory, at))
    }

    fn uniform_element(&mut self, array: Array, index: Value) -> A::Value {
        let ty = self.element_type(array);
        let Some(pointer) = self.element_pointer(array, index) else {
            let variable = self.element_variable(array, index, 0);
            return self.asm.get(variable);
        };
        let value = self.asm.load(Form::One(Self::stored(ty)), pointer, 0);
        if ty == Ty::Bool {
            let zero = self.word(0);
            self.arithmetic(Binary::NotEqual, value, zero)
        } else {
            value
        }
    }

    fn write_uniform_element(&mut self, array: Array, index: Value, value: Value) {
        let ty = self.element_type(array);
        let mut scalar = self.scalar(value);
        let Some(pointer) = self.element_pointer(array, index) else {
            let variable = self.element_variable(array, index, 0);
            return self.asm.set(variable, scalar);
        };
        if ty == Ty::Bool {
            scalar = self.asm.convert(Form::One(ty), Ty::U32, scalar);
        }
        self.asm.store(Form::One(Self::stored(ty)), pointer, 0, scalar);
    }

    /// Mask for writing a local that was declared inside `home` regions. `None` if every lane that was active there is
    /// active here.
    fn written_under(&mut self, home: usize, k: usize) -> Option<A::Value> {
        let mask = self.masks.last()?.parts[k];
        let diverges = self.shapes.diverges(&self.regions[home..]);
        diverges.then(|| self.asm.get(mask))
    }

    fn write_variable(&mut self, part: A::Variable, home: usize, ty: Ty, new: A::Value, k: usize) {
        let new = match self.written_under(home, k) {
            Some(active) => {
                let old = self.asm.get(part);
                self.asm.blend(ty, active, new, old)
            }
            None => new,
        };
        self.asm.set(part, new);
    }

    fn write_varying_element(&mut self, array: Array, index: Value, value: Value, k: usize, pointer: Option<A::Value>) {
        let ty = self.element_type(array);
        let new = self.part(value, k);
        let home = match self.storage(array) {
            Storage::Variables(local) => local.home,
            Storage::Memory(_, home) => *home,
        };
        let Some(pointer) = pointer else {
            let variable = self.element_variable(array, index, k);
            return self.write_variable(variable, home, ty, new, k);
        };
        let new = if ty == Ty::Bool { self.masked_bits(new, !0) } else { new };
        let (form, offset) = (Form::Vector(Self::stored(ty)), k as u32 * A::LANES);
        let new = match self.written_under(home, k) {
            Some(active) => {
                let old = self.asm.load(form, pointer, offset);
                self.asm.blend(Self::stored(ty), active, new, old)
            }
            None => new,
        };
        self.asm.store(form, pointer, offset, new);
    }

    // Masks: one vector of truth values for each vector of lanes.

    /// The lanes that are active here; `None` if all are.
    fn active(&mut self) -> Option<Vec<A::Value>> {
        let parts = self.masks.last()?.parts.clone();
        Some(parts.into_iter().map(|part| self.asm.get(part)).collect())
    }

    /// Starts the mask of a region with its active lanes.
    fn push_mask(&mut self, lanes: &[A::Value]) {
        let start = |mask: &A::Value| {
            let part = self.asm.variable(Form::Vector(Ty::Bool));
            self.asm.set(part, *mask);
            part
        };
        let parts = lanes.iter().map(start).collect();
        let depth = self.regions.len() - 1;
        self.masks.push(Mask { parts, depth });
    }

    /// Starts a mask that lanes can leave, with all lanes that are active now.
    fn push_live(&mut self) {
        let all = self.asm.constant(Form::Vector(Ty::Bool), 1);
        let lanes = self.active().unwrap_or_else(|| vec![all; self.vectors]);
        self.push_mask(&lanes);
    }

    fn any(&mut self, lanes: &[A::Value]) -> A::Value {
        let or = |a, b: &A::Value| self.asm.binary(Binary::Or, Form::Vector(Ty::Bool), a, *b);
        let all = lanes[1..].iter().fold(lanes[0], or);
        self.asm.any(all)
    }

    fn begin_if_none(&mut self, lanes: &[A::Value]) {
        let any = self.any(lanes);
        let none = self.asm.unary(Unary::Not, Form::One(Ty::Bool), any);
        self.asm.begin_if(none);
    }

    fn not(&mut self, mask: A::Value) -> A::Value {
        self.asm.unary(Unary::Not, Form::Vector(Ty::Bool), mask)
    }

    fn and(&mut self, a: A::Value, b: A::Value) -> A::Value {
        self.asm.binary(Binary::And, Form::Vector(Ty::Bool), a, b)
    }

    // Statements.

    /// Emits a block that may be skipped: what was computed in it isn't available after it.
    fn scope(&mut self, block: &Block) {
        let known = self.known.len();
        self.block(block);
        for element in self.known.drain(known..) {
            self.pointers.remove(&element);
            self.uniform_pointers.remove(&element);
        }
    }

    fn block(&mut self, block: &Block) {
        for statement in block {
            self.statement(statement);
            self.shared.clear();
            self.constants.clear();
        }
    }

    fn statement(&mut self, statement: &Statement) {
        match statement {
            // Constants are emitted where they are used.
            Statement::Let(value) if matches!(self.program.op(*value), Op::Constant(_)) => {}
            Statement::Store { address, value, .. } => self.store(address, *value),
            Statement::If { .. } | Statement::Loop { .. } | Statement::Labeled { .. } | Statement::Exit(_) => {
                self.stored_to = None;
                self.emit_control(statement);
                self.stored_to = None;
            }
            _ => {
                let pointer = self.emit_once(statement);
                for k in 0..self.vectors {
                    self.emit_vector(statement, k, pointer);
                }
            }
        }
    }

    fn emit_control(&mut self, statement: &Statement) {
        match statement {
            Statement::If {
                condition,
                accept,
                reject,
            } => self.branch(*condition, accept, reject),
            Statement::Loop { label, body, .. } => self.repeat(*label, body),
            Statement::Labeled { label, body, .. } => self.labeled(*label, body),
            Statement::Exit(label) => self.exit(*label),
            _ => unreachable!("other statements don't jump"),
        }
    }

    /// Emits what a statement does once. Returns a pointer to its vectors if they are consecutive in memory.
    fn emit_once(&mut self, statement: &Statement) -> Option<A::Value> {
        match statement {
            Statement::Let(value) if self.shapes.shape(*value) != Shape::Varying => {
                let scalar = self.uniform(*value);
                self.hold_scalar(*value, scalar);
            }
            Statement::Let(value) => {
                if let Op::ReadElement(array, index) = self.program.op(*value) {
                    return self.element_pointer(array, index);
                }
            }
            Statement::Load { targets, address } => match self.varying_element(address) {
                None => self.load_uniform(targets, address),
                Some(element) if self.is_consecutive(address, element) => {
                    return Some(self.consecutive(address, element));
                }
                Some(_) => {}
            },
            Statement::Declare(variable) => {
                let info = &self.program.variables[variable.0 as usize];
                let parts = self.declared(info.ty, self.shapes.variable_varies(*variable), info.init);
                let home = self.regions.len();
                self.variables[variable.0 as usize] = Some(Local { home, parts });
            }
            Statement::DeclareArray(array) => self.declare_array(*array),
            Statement::Write(variable, value) if !self.shapes.variable_varies(*variable) => {
                let part = self.variable(*variable).parts[0];
                let scalar = self.scalar(*value);
                self.asm.set(part, scalar);
            }
            Statement::WriteElement {
                array, index, value, ..
            } => {
                if self.shapes.array_varies(*array) {
                    return self.element_pointer(*array, *index);
                }
                self.write_uniform_element(*array, *index, *value);
            }
            _ => {}
        }
        None
    }

    /// Emits what a statement does with one vector.
    fn emit_vector(&mut self, statement: &Statement, k: usize, pointer: Option<A::Value>) {
        match statement {
            Statement::Let(value) if self.shapes.shape(*value) == Shape::Varying => {
                let part = self.varying(*value, k, pointer);
                self.hold_part(*value, k, part);
            }
            Statement::Let(value) => self.spread(*value, k),
            Statement::Load { targets, address } => match self.varying_element(address) {
                Some(element) => self.load(targets, address, element, k, pointer),
                None => targets.iter().for_each(|target| self.spread(*target, k)),
            },
            Statement::Write(variable, value) if self.shapes.variable_varies(*variable) => {
                let local = self.variable(*variable);
                let (part, home) = (local.parts[k], local.home);
                let ty = self.program.variables[variable.0 as usize].ty;
                let new = self.part(*value, k);
                self.write_variable(part, home, ty, new, k);
            }
            Statement::WriteElement {
                array, index, value, ..
            } if self.shapes.array_varies(*array) => self.write_varying_element(*array, *index, *value, k, pointer),
            _ => {}
        }
    }

    fn repeat(&mut self, label: Label, body: &Block) {
        self.regions.push(Region::Label(label));
        let masked = self.shapes.loop_is_left_by_some(label);
        if masked {
            self.push_live();
        }
        let end = self.asm.begin_loop();
        self.labels[label.0 as usize] = Some(end);
        if let (true, Some(active)) = (masked, self.active()) {
            self.begin_if_none(&active);
            self.asm.leave(end);
            self.asm.end_if();
        }
        self.asm.count_turn();
        self.scope(body);
        self.asm.end_loop();
        if masked {
            self.masks.pop();
        }
        self.regions.pop();
    }

    fn labeled(&mut self, label: Label, body: &Block) {
        self.regions.push(Region::Label(label));
        let masked = self.shapes.is_left_by_some(label);
        if masked {
            self.push_live();
        }
        if self.shapes.is_left_by_all(label, body, &mut self.regions) {
            self.labels[label.0 as usize] = Some(self.asm.begin_block());
            self.scope(body);
            self.asm.end_block();
        } else {
            self.block(body);
        }
        if masked {
            self.masks.pop();
        }
        self.regions.pop();
    }

    fn branch(&mut self, condition: Value, accept: &Block, reject: &Block) {
        if self.shapes.is_uniform(condition) {
            let condition = self.scalar(condition);
            self.regions.push(Region::Branch(false));
            self.asm.begin_if(condition);
            self.scope(accept);
            if !reject.is_empty() {
                self.asm.begin_else();
                self.scope(reject);
            }
            self.asm.end_if();
            self.regions.pop();
            return;
        }
        self.regions.push(Region::Branch(true));
        for (block, inverted) in [(accept, false), (reject, true)] {
            if block.is_empty() {
                continue;
            }
            let outer = self.active();
            let mut lanes = Vec::new();
            for k in 0..self.vectors {
                let test = self.part(condition, k);
                let test = if inverted { self.not(test) } else { test };
                lanes.push(match &outer {
                    Some(outer) => self.and(outer[k], test),
                    None => test,
                });
            }
            self.push_mask(&lanes);
            let any = self.any(&lanes);
            self.asm.begin_if(any);
            self.scope(block);
            self.asm.end_if();
            self.masks.pop();
        }
        self.regions.pop();
        if self.shapes.ends_early(&self.regions, [accept, reject])
            && let Some(active) = self.active()
        {
            self.begin_if_none(&active);
            self.asm.finish();
            self.asm.end_if();
        }
    }

    fn exit(&mut self, label: Label) {
        if !self.shapes.exit_diverges(&self.regions, label) {
            let end = self.labels[label.0 as usize].expect("an exit stands in its label's block");
            self.asm.leave(end);
            return;
        }
        let depth = depth_of(&self.regions, label);
        let leaving = self.active().expect("a varying exit stands under a mask");
        for mask in self.masks.clone() {
            if mask.depth < depth {
                continue;
            }
            for (part, leaving) in mask.parts.iter().zip(&leaving) {
                let before = self.asm.get(*part);
                let others = self.not(*leaving);
                let after = self.and(before, others);
                self.asm.set(*part, after);
            }
        }
    }
}
