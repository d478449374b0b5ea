//! A program of the shader compiler's tree as instructions, in SPMD style like the lane code that is printed ahead:
//! what is uniform stays a scalar, what varies is one vector for every four lanes, and a branch on a varying condition
//! runs, under a mask, if any lane is in it.
//!
//! Nothing that an idle lane does reaches memory outside of the buffers: elements are clamped for all lanes alike.

use std::collections::BTreeSet;

use oneiro_shader_compiler::Trees;
use oneiro_shader_compiler::tree::{
    Address, Array, Binary, Block, Label, Op, Program, Statement, Ty, Unary, Value, Variable, visit,
};
use oneiro_shader_compiler::uniform::{Region, Shape, Shapes, depth_of};

use crate::assembler::{Assembler, Form, LANES};

/// Writes a program for so many lanes, a multiple of [`LANES`].
pub(crate) fn emit<A: Assembler>(asm: &mut A, trees: &Trees, lanes: u32) {
    let program = &trees.tidied;
    let mut emitter = Emitter {
        program,
        shapes: &trees.shapes,
        asm,
        vectors: (lanes / LANES) as usize,
        pool: Vec::new(),
        values: vec![None; program.values.len()],
        variables: vec![None; program.variables.len()],
        arrays: vec![None; program.arrays.len()],
        indexed: indexed_arrays(program),
        regions: Vec::new(),
        masks: Vec::new(),
        labels: vec![None; program.labels as usize],
        counts: Vec::new(),
        places: Vec::new(),
        stored_to: None,
        scratch: None,
    };
    for (buffer, stride) in trees.strides.iter().enumerate() {
        let elements = emitter.asm.elements(buffer as u32, *stride);
        let one = emitter.word(1);
        let last = emitter.arithmetic(Binary::Subtract, elements, one);
        let lasts = emitter.splat(Ty::U32, last);
        emitter.counts.push(Count { elements, last, lasts });
    }
    emitter.block(&program.body);
    emitter.asm.finish();
}

/// The arrays that are indexed by what is not constant; the others are variables, one an element.
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

/// Vectors of all lanes: where they begin in [`Emitter::pool`].
#[derive(Clone, Copy, Debug)]
struct Lanes(u32);

/// What is known of a computed value.
#[derive(Clone, Copy, Debug)]
struct Held<V> {
    /// If it is uniform, or linear: then that of lane 0.
    scalar: Option<V>,
    /// For all lanes.
    lanes: Lanes,
}

/// A variable, and how many regions enclose its declaration.
#[derive(Clone, Debug)]
struct Local<T> {
    home: usize,
    /// One if it is uniform, else one a vector; for an array's elements, one after the other.
    parts: Vec<T>,
}

/// A local array.
#[derive(Clone, Debug)]
enum Storage<T, M> {
    /// A variable for each element.
    Variables(Local<T>),
    /// Memory, and how many regions enclose its declaration.
    Memory(M, usize),
}

/// A mask of the lanes that are active in a region.
#[derive(Clone, Debug)]
struct Mask<T> {
    parts: Vec<T>,
    /// How many regions enclose the one that it is of.
    depth: usize,
}

/// A buffer's elements.
#[derive(Clone, Copy, Debug)]
struct Count<V> {
    elements: V,
    last: V,
    lasts: Lanes,
}

struct Emitter<'a, A: Assembler> {
    program: &'a Program,
    shapes: &'a Shapes,
    asm: &'a mut A,
    /// Vectors that hold all lanes.
    vectors: usize,
    pool: Vec<A::Value>,
    values: Vec<Option<Held<A::Value>>>,
    variables: Vec<Option<Local<A::Variable>>>,
    arrays: Vec<Option<Storage<A::Variable, A::Array>>>,
    indexed: BTreeSet<Array>,
    regions: Vec<Region>,
    masks: Vec<Mask<A::Variable>>,
    labels: Vec<Option<A::Label>>,
    counts: Vec<Count<A::Value>>,
    /// Elements whose places are known here.
    places: Vec<(Element, Places<A::Place>)>,
    /// The element that was last stored to under the mask of here, and the places of its active lanes.
    stored_to: Option<(Element, Places<A::Place>)>,
    /// A word for each lane.
    scratch: Option<A::Array>,
}

/// An element of a buffer: its binding number, the index, and its words.
type Element = (u32, Value, u32);

/// Places of all lanes, for each vector.
type Places<P> = Vec<[P; LANES as usize]>;

impl<A: Assembler> Emitter<'_, A> {
    // Vectors of all lanes.

    fn each(&mut self, mut make: impl FnMut(&mut Self, usize) -> A::Value) -> Lanes {
        let vectors: Vec<_> = (0..self.vectors).map(|k| make(self, k)).collect();
        let lanes = Lanes(self.pool.len() as u32);
        self.pool.extend(vectors);
        lanes
    }

    fn part(&self, lanes: Lanes, k: usize) -> A::Value {
        self.pool[lanes.0 as usize + k]
    }

    fn same(&mut self, vector: A::Value) -> Lanes {
        self.each(|_, _| vector)
    }

    fn splat(&mut self, ty: Ty, scalar: A::Value) -> Lanes {
        let vector = self.asm.splat(ty, scalar);
        self.same(vector)
    }

    fn constants(&mut self, ty: Ty, bits: u32) -> Lanes {
        let vector = self.asm.constant(Form::Four(ty), bits);
        self.same(vector)
    }

    /// `base`, `base + 1`, ..
    fn linear(&mut self, base: A::Value) -> Lanes {
        let base = self.asm.splat(Ty::U32, base);
        self.each(|emitter, k| {
            let ramp = emitter.asm.ramp(k as u32 * LANES);
            emitter.asm.binary(Binary::Add, Form::Four(Ty::U32), base, ramp)
        })
    }

    fn unaries(&mut self, op: Unary, ty: Ty, a: Lanes) -> Lanes {
        self.each(|emitter, k| {
            let a = emitter.part(a, k);
            emitter.asm.unary(op, Form::Four(ty), a)
        })
    }

    fn binaries(&mut self, op: Binary, ty: Ty, a: Lanes, b: Lanes) -> Lanes {
        self.each(|emitter, k| {
            let (a, b) = (emitter.part(a, k), emitter.part(b, k));
            emitter.asm.binary(op, Form::Four(ty), a, b)
        })
    }

    fn bitcasts(&mut self, from: Ty, to: Ty, a: Lanes) -> Lanes {
        if from == to {
            return a;
        }
        self.each(|emitter, k| {
            let a = emitter.part(a, k);
            emitter.asm.bitcast(Form::Four(from), to, a)
        })
    }

    fn blends(&mut self, ty: Ty, mask: Lanes, accept: Lanes, reject: Lanes) -> Lanes {
        self.each(|emitter, k| {
            let (mask, accept, reject) = (emitter.part(mask, k), emitter.part(accept, k), emitter.part(reject, k));
            emitter.asm.blend(ty, mask, accept, reject)
        })
    }

    /// What has no form for vectors: of each lane's words.
    fn lane_by_lane(&mut self, op: Binary, ty: Ty, a: Lanes, b: Lanes) -> Lanes {
        self.each(|emitter, k| {
            let (vector, with) = (emitter.part(a, k), emitter.part(b, k));
            let mut out = vector;
            for lane in 0..LANES {
                let x = emitter.asm.lane(vector, lane);
                let y = emitter.asm.lane(with, lane);
                let result = emitter.integers(op, ty, x, y);
                out = emitter.asm.with_lane(out, lane, result);
            }
            out
        })
    }

    // Scalars.

    fn word(&mut self, bits: u32) -> A::Value {
        self.asm.constant(Form::One(Ty::U32), bits)
    }

    fn arithmetic(&mut self, op: Binary, a: A::Value, b: A::Value) -> A::Value {
        self.asm.binary(op, Form::One(Ty::U32), a, b)
    }

    /// An operation on integers, of which division by zero leaves the dividend: it divides by one.
    fn integers(&mut self, op: Binary, ty: Ty, a: A::Value, b: A::Value) -> A::Value {
        let b = if matches!(op, Binary::Divide | Binary::Remainder) {
            let one = self.word(1);
            self.arithmetic(Binary::Max, b, one)
        } else {
            b
        };
        self.asm.binary(op, Form::One(ty), a, b)
    }

    // Values of the program.

    fn held(&self, value: Value) -> Held<A::Value> {
        self.values[value.0 as usize].expect("a value is set before it is used")
    }

    /// A uniform value, or a linear value's number in lane 0.
    fn scalar(&mut self, value: Value) -> A::Value {
        match self.program.op(value) {
            Op::Constant(bits) => self.asm.constant(Form::One(self.program.ty(value)), bits),
            _ => self.held(value).scalar.expect("it is uniform or linear"),
        }
    }

    /// A value for all lanes.
    fn lanes(&mut self, value: Value) -> Lanes {
        match self.program.op(value) {
            Op::Constant(bits) => self.constants(self.program.ty(value), bits),
            _ => self.held(value).lanes,
        }
    }

    fn hold_lanes(&mut self, value: Value, lanes: Lanes) {
        self.values[value.0 as usize] = Some(Held { scalar: None, lanes });
    }

    /// Keeps a value that is a scalar, and what it is for all lanes: what of that nothing uses is never written.
    fn hold_scalar(&mut self, value: Value, scalar: A::Value) {
        let lanes = match self.shapes.shape(value) {
            Shape::Linear => self.linear(scalar),
            _ => self.splat(self.program.ty(value), scalar),
        };
        self.values[value.0 as usize] = Some(Held {
            scalar: Some(scalar),
            lanes,
        });
    }

    fn computed(&mut self, value: Value) {
        if let Op::Constant(_) = self.program.op(value) {
            return;
        }
        if self.shapes.shape(value) == Shape::Varying {
            let lanes = self.varying(value);
            self.hold_lanes(value, lanes);
        } else {
            let scalar = self.uniform(value);
            self.hold_scalar(value, scalar);
        }
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
            Op::ReadElement(array, index) => self.element(array, index, None),
            Op::Unary(op, a) => {
                let a = self.scalar(a);
                self.asm.unary(op, Form::One(ty), a)
            }
            Op::Binary(op, a, b) => {
                let from = self.program.ty(a);
                let (a, b) = (self.scalar(a), self.scalar(b));
                self.integers(op, from, a, b)
            }
            Op::Select {
                condition,
                accept,
                reject,
            } => {
                let (condition, accept, reject) = (self.scalar(condition), self.scalar(accept), self.scalar(reject));
                self.asm.select(condition, accept, reject)
            }
            Op::Convert(a) => {
                let from = self.program.ty(a);
                let a = self.scalar(a);
                match (from, ty) {
                    (Ty::Bool, Ty::F32) => {
                        let word = self.asm.convert(Form::One(from), Ty::U32, a);
                        self.asm.convert(Form::One(Ty::U32), Ty::F32, word)
                    }
                    (_, Ty::Bool) if from != Ty::Bool => {
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

    fn varying(&mut self, value: Value) -> Lanes {
        let ty = self.program.ty(value);
        match self.program.op(value) {
            Op::Constant(_) | Op::Lane | Op::Workgroup | Op::Loaded => unreachable!("it does not vary by itself"),
            Op::Read(variable) => {
                let parts = self.variable(variable).parts.clone();
                self.each(|emitter, k| emitter.asm.get(parts[k]))
            }
            Op::ReadElement(array, index) => self.each(|emitter, k| emitter.element(array, index, Some(k))),
            Op::Unary(op, a) => {
                let a = self.lanes(a);
                self.unaries(op, ty, a)
            }
            Op::Binary(op, a, b) => self.varying_binary(op, a, b),
            Op::Select {
                condition,
                accept,
                reject,
            } => {
                let (accept, reject) = (self.lanes(accept), self.lanes(reject));
                if self.shapes.is_uniform(condition) {
                    let condition = self.scalar(condition);
                    return self.each(|emitter, k| {
                        let (accept, reject) = (emitter.part(accept, k), emitter.part(reject, k));
                        emitter.asm.select(condition, accept, reject)
                    });
                }
                let condition = self.lanes(condition);
                self.blends(ty, condition, accept, reject)
            }
            Op::Convert(a) => {
                let from = self.program.ty(a);
                let a = self.lanes(a);
                match (from, ty) {
                    (Ty::Bool, _) if ty != Ty::Bool => {
                        let one = if ty == Ty::F32 { 1.0_f32.to_bits() } else { 1 };
                        let ones = self.constants(Ty::U32, one);
                        let bits = self.binaries(Binary::And, Ty::U32, a, ones);
                        self.bitcasts(Ty::U32, ty, bits)
                    }
                    (_, Ty::Bool) if from != Ty::Bool => {
                        let zeros = self.constants(from, 0);
                        self.binaries(Binary::NotEqual, from, a, zeros)
                    }
                    _ => self.each(|emitter, k| {
                        let a = emitter.part(a, k);
                        emitter.asm.convert(Form::Four(from), ty, a)
                    }),
                }
            }
            Op::Bitcast(a) => {
                let from = self.program.ty(a);
                let a = self.lanes(a);
                self.bitcasts(from, ty, a)
            }
        }
    }

    fn varying_binary(&mut self, op: Binary, a: Value, b: Value) -> Lanes {
        let ty = self.program.ty(a);
        let lanes = self.lanes(a);
        let shifts = matches!(op, Binary::ShiftLeft | Binary::ShiftRight);
        if shifts && self.shapes.is_uniform(b) {
            let count = self.scalar(b);
            return self.each(|emitter, k| {
                let a = emitter.part(lanes, k);
                emitter.asm.binary(op, Form::Four(ty), a, count)
            });
        }
        let with = self.lanes(b);
        if shifts || matches!(op, Binary::Divide | Binary::Remainder) {
            return self.lane_by_lane(op, ty, lanes, with);
        }
        self.binaries(op, ty, lanes, with)
    }

    // Locals.

    fn variable(&self, variable: Variable) -> &Local<A::Variable> {
        self.variables[variable.0 as usize]
            .as_ref()
            .expect("a variable is declared before it is used")
    }

    /// A new variable, uniform or for all lanes, with a constant in it.
    fn declared(&mut self, ty: Ty, varies: bool, init: u32) -> Vec<A::Variable> {
        let form = if varies { Form::Four(ty) } else { Form::One(ty) };
        let value = self.asm.constant(form, init);
        let parts = if varies { self.vectors } else { 1 };
        let declare = |_| {
            let part = self.asm.variable(form);
            self.asm.set(part, value);
            part
        };
        (0..parts).map(declare).collect()
    }

    /// Memory's form of a local array's elements: truth values are words there.
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
            let parts = info.init.iter().flat_map(|bits| self.declared(info.ty, varies, *bits));
            let parts = parts.collect();
            self.arrays[slot] = Some(Storage::Variables(Local { home, parts }));
            return;
        }
        // A declaration that is passed again starts anew, in the same memory.
        let memory = match &self.arrays[slot] {
            Some(Storage::Memory(memory, _)) => *memory,
            _ => self.asm.array(info.init.len() as u32 * self.element_words(array)),
        };
        self.arrays[slot] = Some(Storage::Memory(memory, home));
        let zero = self.word(0);
        for (at, bits) in info.init.iter().enumerate() {
            let bits = match (info.ty, varies) {
                (Ty::Bool, true) => 0_u32.wrapping_sub(*bits),
                _ => *bits,
            };
            let ty = Self::stored(info.ty);
            let form = if varies { Form::Four(ty) } else { Form::One(ty) };
            let value = self.asm.constant(form, bits);
            let first = at as u32 * self.element_words(array);
            let parts = if varies { self.vectors as u32 } else { 1 };
            for k in 0..parts {
                self.asm.write(memory, zero, first + k * LANES, value);
            }
        }
    }

    /// Words of an element in memory.
    fn element_words(&self, array: Array) -> u32 {
        if self.shapes.array_varies(array) {
            self.vectors as u32 * LANES
        } else {
            1
        }
    }

    /// The clamped number of an element, if it is a constant.
    fn fixed_element(&self, array: Array, index: Value) -> Option<usize> {
        let last = self.program.arrays[array.0 as usize].init.len() - 1;
        match self.program.op(index) {
            Op::Constant(bits) => Some((bits as usize).min(last)),
            _ => None,
        }
    }

    /// Where in its array's memory an element begins.
    fn element_index(&mut self, array: Array, index: Value) -> A::Value {
        let words = self.element_words(array);
        if let Some(at) = self.fixed_element(array, index) {
            return self.word(at as u32 * words);
        }
        let last = self.program.arrays[array.0 as usize].init.len() as u32 - 1;
        let (index, last) = (self.scalar(index), self.word(last));
        let clamped = self.arithmetic(Binary::Min, index, last);
        let words = self.word(words);
        self.arithmetic(Binary::Multiply, clamped, words)
    }

    fn storage(&self, array: Array) -> &Storage<A::Variable, A::Array> {
        self.arrays[array.0 as usize]
            .as_ref()
            .expect("an array is declared before it is used")
    }

    /// An element of a local array, or one of its vectors.
    fn element(&mut self, array: Array, index: Value, vector: Option<usize>) -> A::Value {
        let ty = self.program.arrays[array.0 as usize].ty;
        match self.storage(array) {
            Storage::Variables(local) => {
                let at = self.fixed_element(array, index).expect("its indices are constants");
                let part = match vector {
                    Some(k) => local.parts[at * self.vectors + k],
                    None => local.parts[at],
                };
                self.asm.get(part)
            }
            Storage::Memory(memory, _) => {
                let memory = *memory;
                let first = self.element_index(array, index);
                let stored = Self::stored(ty);
                if let Some(k) = vector {
                    return self.asm.read(memory, Form::Four(stored), first, k as u32 * LANES);
                }
                let value = self.asm.read(memory, Form::One(stored), first, 0);
                self.truth(ty, value)
            }
        }
    }

    /// A scalar that has been a word in memory.
    fn truth(&mut self, ty: Ty, value: A::Value) -> A::Value {
        if ty != Ty::Bool {
            return value;
        }
        let zero = self.word(0);
        self.arithmetic(Binary::NotEqual, value, zero)
    }

    fn write(&mut self, variable: Variable, value: Value) {
        let Local { home, parts } = self.variable(variable).clone();
        let ty = self.program.variables[variable.0 as usize].ty;
        if !self.shapes.variable_varies(variable) {
            let scalar = self.scalar(value);
            self.asm.set(parts[0], scalar);
            return;
        }
        let active = self.written_under(home);
        self.write_parts(&parts, ty, value, active);
    }

    /// The mask under which is written what was declared in so many regions; none if all lanes that are active there
    /// are active here.
    fn written_under(&mut self, home: usize) -> Option<Lanes> {
        if self.shapes.diverges(&self.regions[home..]) {
            self.active()
        } else {
            None
        }
    }

    fn write_parts(&mut self, parts: &[A::Variable], ty: Ty, value: Value, active: Option<Lanes>) {
        let mut new = self.lanes(value);
        if let Some(active) = active {
            let old = self.each(|emitter, k| emitter.asm.get(parts[k]));
            new = self.blends(ty, active, new, old);
        }
        for (k, part) in parts.iter().enumerate() {
            let vector = self.part(new, k);
            self.asm.set(*part, vector);
        }
    }

    fn write_element(&mut self, array: Array, index: Value, value: Value) {
        let ty = self.program.arrays[array.0 as usize].ty;
        let varies = self.shapes.array_varies(array);
        match self.storage(array).clone() {
            Storage::Variables(Local { home, parts }) => {
                let at = self.fixed_element(array, index).expect("its indices are constants");
                if varies {
                    let active = self.written_under(home);
                    let parts = &parts[at * self.vectors..(at + 1) * self.vectors];
                    self.write_parts(parts, ty, value, active);
                } else {
                    let scalar = self.scalar(value);
                    self.asm.set(parts[at], scalar);
                }
            }
            Storage::Memory(memory, home) => {
                let first = self.element_index(array, index);
                if !varies {
                    let mut scalar = self.scalar(value);
                    if ty == Ty::Bool {
                        scalar = self.asm.convert(Form::One(Ty::Bool), Ty::U32, scalar);
                    }
                    self.asm.write(memory, first, 0, scalar);
                    return;
                }
                let active = self.written_under(home);
                let mut new = self.lanes(value);
                if let Some(active) = active {
                    let form = Form::Four(Self::stored(ty));
                    let old = self.each(|emitter, k| emitter.asm.read(memory, form, first, k as u32 * LANES));
                    new = self.blends(ty, active, new, old);
                }
                for k in 0..self.vectors {
                    let vector = self.part(new, k);
                    self.asm.write(memory, first, k as u32 * LANES, vector);
                }
            }
        }
    }

    // Masks.

    /// The lanes that are active here; none if all are.
    fn active(&mut self) -> Option<Lanes> {
        let parts = self.masks.last()?.parts.clone();
        Some(self.each(|emitter, k| emitter.asm.get(parts[k])))
    }

    /// Begins a region's mask, with the lanes that are active in it.
    fn push_mask(&mut self, lanes: Lanes) {
        let parts: Vec<_> = (0..self.vectors)
            .map(|_| self.asm.variable(Form::Four(Ty::Bool)))
            .collect();
        for (k, part) in parts.iter().enumerate() {
            let mask = self.part(lanes, k);
            self.asm.set(*part, mask);
        }
        let depth = self.regions.len() - 1;
        self.masks.push(Mask { parts, depth });
    }

    /// Begins a mask that lanes leave, with all that are active.
    fn push_live(&mut self) {
        let lanes = match self.active() {
            Some(active) => active,
            None => self.constants(Ty::Bool, 1),
        };
        self.push_mask(lanes);
    }

    fn any(&mut self, lanes: Lanes) -> A::Value {
        let mut all = self.part(lanes, 0);
        for k in 1..self.vectors {
            let part = self.part(lanes, k);
            all = self.asm.binary(Binary::Or, Form::Four(Ty::Bool), all, part);
        }
        self.asm.any(all)
    }

    fn none(&mut self, lanes: Lanes) -> A::Value {
        let any = self.any(lanes);
        self.asm.unary(Unary::Not, Form::One(Ty::Bool), any)
    }

    /// `a & !b`
    fn and_not(&mut self, a: Lanes, b: Lanes) -> Lanes {
        let inverted = self.unaries(Unary::Not, Ty::Bool, b);
        self.binaries(Binary::And, Ty::Bool, a, inverted)
    }

    // Statements.

    fn block(&mut self, block: &Block) {
        for (at, statement) in block.iter().enumerate() {
            self.statement(statement, at == 0 && self.regions.is_empty());
        }
    }

    /// A block that may be passed by: what is known in it is not known after it.
    fn scope(&mut self, block: &Block) {
        let known = self.places.len();
        self.block(block);
        self.places.truncate(known);
    }

    fn statement(&mut self, statement: &Statement, outermost: bool) {
        if matches!(
            statement,
            Statement::If { .. } | Statement::Loop { .. } | Statement::Labeled { .. } | Statement::Exit(_)
        ) {
            self.stored_to = None;
        }
        match statement {
            Statement::Let(value) => self.computed(*value),
            Statement::Load { targets, address } => self.load(targets, address),
            Statement::Declare(variable) => {
                let info = &self.program.variables[variable.0 as usize];
                let parts = self.declared(info.ty, self.shapes.variable_varies(*variable), info.init);
                let home = self.regions.len();
                self.variables[variable.0 as usize] = Some(Local { home, parts });
            }
            Statement::DeclareArray(array) => self.declare_array(*array),
            Statement::Write(variable, value) => self.write(*variable, *value),
            Statement::WriteElement {
                array, index, value, ..
            } => self.write_element(*array, *index, *value),
            Statement::Store { address, value, .. } => self.store(address, *value),
            Statement::If {
                condition,
                accept,
                reject,
            } => self.branch(*condition, accept, reject, outermost),
            Statement::Loop { label, body, .. } => self.repeat(*label, body),
            Statement::Labeled { label, body, .. } => self.labeled(*label, body),
            Statement::Exit(label) => self.exit(*label),
        }
    }

    fn repeat(&mut self, label: Label, body: &Block) {
        self.regions.push(Region::Label(label));
        let masked = self.shapes.loop_is_left_by_some(label);
        if masked {
            self.push_live();
        }
        let own = self.asm.begin_loop();
        self.labels[label.0 as usize] = Some(own);
        if let (true, Some(active)) = (masked, self.active()) {
            let none = self.none(active);
            self.asm.begin_if(none);
            self.asm.leave(own);
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
            let first_in_kernel = self.regions.len() == 1;
            for statement in body {
                self.statement(statement, first_in_kernel);
            }
        }
        if masked {
            self.masks.pop();
        }
        self.regions.pop();
    }

    fn branch(&mut self, condition: Value, accept: &Block, reject: &Block, outermost: bool) {
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
        let test = self.lanes(condition);
        self.regions.push(Region::Branch(true));
        for (block, inverted) in [(accept, false), (reject, true)] {
            if block.is_empty() {
                continue;
            }
            let lanes = match (self.active(), inverted) {
                (None, false) => test,
                (None, true) => self.unaries(Unary::Not, Ty::Bool, test),
                (Some(outer), false) => self.binaries(Binary::And, Ty::Bool, outer, test),
                (Some(outer), true) => self.and_not(outer, test),
            };
            self.push_mask(lanes);
            let any = self.any(lanes);
            self.asm.begin_if(any);
            self.scope(block);
            self.asm.end_if();
            self.masks.pop();
        }
        self.regions.pop();
        let mut leaves = false;
        for block in [accept, reject] {
            visit(block, &mut |statement| {
                leaves |= matches!(statement, Statement::Exit(_));
            });
        }
        if outermost
            && leaves
            && let Some(active) = self.active()
        {
            let none = self.none(active);
            self.asm.begin_if(none);
            self.asm.finish();
            self.asm.end_if();
        }
    }

    fn exit(&mut self, label: Label) {
        if !self.shapes.exit_diverges(&self.regions, label) {
            let own = self.labels[label.0 as usize].expect("an exit stands in its label's block");
            self.asm.leave(own);
            return;
        }
        let depth = depth_of(&self.regions, label);
        let gone = self.active().expect("a varying exit stands under a mask");
        for mask in self.masks.clone() {
            if mask.depth < depth {
                continue;
            }
            let old = self.each(|emitter, k| emitter.asm.get(mask.parts[k]));
            let left = self.and_not(old, gone);
            for (k, part) in mask.parts.iter().enumerate() {
                let lanes = self.part(left, k);
                self.asm.set(*part, lanes);
            }
        }
    }

    // Buffers.

    /// An address' element, if it is not the same for all lanes.
    fn varying_element(&self, address: &Address) -> Option<Value> {
        address.element.filter(|element| !self.shapes.is_uniform(*element))
    }

    /// The word at which a uniform element begins, clamped.
    fn index(&mut self, address: &Address) -> A::Value {
        let Some(element) = address.element else {
            return self.word(0);
        };
        let element = self.scalar(element);
        let last = self.counts[address.buffer as usize].last;
        let clamped = self.arithmetic(Binary::Min, element, last);
        if address.stride == 1 {
            return clamped;
        }
        let stride = self.word(address.stride);
        self.arithmetic(Binary::Multiply, clamped, stride)
    }

    /// Where the lanes' elements begin, clamped.
    fn places(&mut self, address: &Address, element: Value, mask: Option<Lanes>) -> Places<A::Place> {
        let elements = self.lanes(element);
        let lasts = self.counts[address.buffer as usize].lasts;
        let mut indices = self.binaries(Binary::Min, Ty::U32, elements, lasts);
        let stride = address.stride;
        if stride.is_power_of_two() && stride > 1 {
            let count = self.word(stride.trailing_zeros());
            indices = self.each(|emitter, k| {
                let at = emitter.part(indices, k);
                emitter.asm.binary(Binary::ShiftLeft, Form::Four(Ty::U32), at, count)
            });
        } else if stride > 1 {
            let strides = self.constants(Ty::U32, stride);
            indices = self.binaries(Binary::Multiply, Ty::U32, indices, strides);
        }
        let vectors = 0..self.vectors;
        let place = |k| {
            let indices = self.part(indices, k);
            let mask = mask.map(|mask| self.part(mask, k));
            self.asm.places(address.buffer, indices, mask)
        };
        vectors.map(place).collect()
    }

    /// The same, of all lanes, if it is not known yet.
    fn known_places(&mut self, address: &Address, element: Value) -> Places<A::Place> {
        let key = (address.buffer, element, address.stride);
        if let Some((_, known)) = self.places.iter().find(|(other, _)| *other == key) {
            return known.clone();
        }
        let places = self.places(address, element, None);
        self.places.push((key, places.clone()));
        places
    }

    /// Whether the lanes' elements are words one after the other, none beyond the end.
    fn begin_if_within(&mut self, address: &Address, first: A::Value) {
        let count = self.counts[address.buffer as usize].elements;
        let all = self.word(self.vectors as u32 * LANES);
        let room = self.arithmetic(Binary::Subtract, count, all);
        let enough = self.arithmetic(Binary::LessEqual, all, count);
        let within = self.arithmetic(Binary::LessEqual, first, room);
        let both = self.asm.binary(Binary::And, Form::One(Ty::Bool), enough, within);
        self.asm.begin_if(both);
    }

    fn is_consecutive(&self, address: &Address, element: Value) -> bool {
        self.shapes.shape(element) == Shape::Linear && address.stride == 1
    }

    fn load(&mut self, targets: &[Value], address: &Address) {
        let Some(element) = self.varying_element(address) else {
            let index = self.index(address);
            for (k, target) in targets.iter().enumerate() {
                let word = self.asm.load(address.buffer, index, address.offset + k as u32);
                let scalar = match self.program.ty(*target) {
                    Ty::F32 => self.asm.bitcast(Form::One(Ty::U32), Ty::F32, word),
                    _ => word,
                };
                self.hold_scalar(*target, scalar);
            }
            return;
        };
        if let [target] = targets
            && self.is_consecutive(address, element)
        {
            let words = self.load_consecutive(address, element);
            self.loaded(*target, words);
            return;
        }
        let places = self.known_places(address, element);
        if let [target] = targets {
            let words = self.each(|emitter, k| emitter.asm.gather(&places[k], address.offset));
            self.loaded(*target, words);
            return;
        }
        let quads: Vec<_> = places
            .iter()
            .map(|places| self.asm.gather_four(places, address.offset))
            .collect();
        for (word, target) in targets.iter().enumerate() {
            let words = self.each(|_, k| quads[k][word]);
            self.loaded(*target, words);
        }
    }

    fn loaded(&mut self, target: Value, words: Lanes) {
        let lanes = match self.program.ty(target) {
            Ty::F32 => self.bitcasts(Ty::U32, Ty::F32, words),
            _ => words,
        };
        self.hold_lanes(target, lanes);
    }

    fn load_consecutive(&mut self, address: &Address, element: Value) -> Lanes {
        let first = self.scalar(element);
        let parts: Vec<_> = (0..self.vectors)
            .map(|_| self.asm.variable(Form::Four(Ty::U32)))
            .collect();
        self.begin_if_within(address, first);
        for (k, part) in parts.iter().enumerate() {
            let at = address.offset + k as u32 * LANES;
            let words = self.asm.load_four(address.buffer, first, at);
            self.asm.set(*part, words);
        }
        self.asm.begin_else();
        // Rare, so it shall be short.
        let scratch = self.scratch();
        self.each_word(address, first, |emitter, lane, index| {
            let word = emitter.asm.load(address.buffer, index, address.offset);
            emitter.asm.write(scratch, lane, 0, word);
        });
        let zero = self.word(0);
        for (k, part) in parts.iter().enumerate() {
            let words = self.asm.read(scratch, Form::Four(Ty::U32), zero, k as u32 * LANES);
            self.asm.set(*part, words);
        }
        self.asm.end_if();
        self.each(|emitter, k| emitter.asm.get(parts[k]))
    }

    fn store_consecutive(&mut self, address: &Address, element: Value, words: Lanes) {
        let first = self.scalar(element);
        self.begin_if_within(address, first);
        for k in 0..self.vectors {
            let words = self.part(words, k);
            let at = address.offset + k as u32 * LANES;
            self.asm.store_four(address.buffer, first, at, words);
        }
        self.asm.begin_else();
        let scratch = self.scratch();
        let zero = self.word(0);
        for k in 0..self.vectors {
            let words = self.part(words, k);
            self.asm.write(scratch, zero, k as u32 * LANES, words);
        }
        self.each_word(address, first, |emitter, lane, index| {
            let word = emitter.asm.read(scratch, Form::One(Ty::U32), lane, 0);
            emitter.asm.store(address.buffer, index, address.offset, word);
        });
        self.asm.end_if();
    }

    fn scratch(&mut self) -> A::Array {
        let words = self.vectors as u32 * LANES;
        *self.scratch.get_or_insert_with(|| self.asm.array(words))
    }

    /// Repeats something for each lane's number and for the clamped index of its element, which is a word.
    fn each_word(&mut self, address: &Address, first: A::Value, mut act: impl FnMut(&mut Self, A::Value, A::Value)) {
        let lane = self.asm.variable(Form::One(Ty::U32));
        let (zero, one) = (self.word(0), self.word(1));
        let lanes = self.word(self.vectors as u32 * LANES);
        self.asm.set(lane, zero);
        let label = self.asm.begin_loop();
        let at = self.asm.get(lane);
        let element = self.arithmetic(Binary::Add, first, at);
        let last = self.counts[address.buffer as usize].last;
        let index = self.arithmetic(Binary::Min, element, last);
        act(self, at, index);
        let next = self.arithmetic(Binary::Add, at, one);
        self.asm.set(lane, next);
        let all = self.arithmetic(Binary::Equal, next, lanes);
        self.asm.begin_if(all);
        self.asm.leave(label);
        self.asm.end_if();
        self.asm.end_loop();
    }

    fn store(&mut self, address: &Address, value: Value) {
        let ty = self.program.ty(value);
        let Some(element) = self.varying_element(address) else {
            let scalar = self.scalar(value);
            let word = match ty {
                Ty::F32 => self.asm.bitcast(Form::One(ty), Ty::U32, scalar),
                Ty::Bool => self.asm.convert(Form::One(ty), Ty::U32, scalar),
                _ => scalar,
            };
            let index = self.index(address);
            let active = self.active();
            if let Some(active) = active {
                let any = self.any(active);
                self.asm.begin_if(any);
            }
            self.asm.store(address.buffer, index, address.offset, word);
            if active.is_some() {
                self.asm.end_if();
            }
            return;
        };
        let lanes = self.lanes(value);
        let words = if ty == Ty::Bool {
            let ones = self.constants(Ty::U32, 1);
            self.binaries(Binary::And, Ty::U32, lanes, ones)
        } else {
            self.bitcasts(ty, Ty::U32, lanes)
        };
        let active = self.active();
        if active.is_none() && self.is_consecutive(address, element) {
            return self.store_consecutive(address, element, words);
        }
        let places = match active {
            None => self.known_places(address, element),
            Some(_) => self.active_places(address, element, active),
        };
        for (k, places) in places.iter().enumerate() {
            let words = self.part(words, k);
            self.asm.scatter(places, address.offset, words);
        }
    }

    /// Where the active lanes' elements begin. A struct is stored word by word.
    fn active_places(&mut self, address: &Address, element: Value, active: Option<Lanes>) -> Places<A::Place> {
        let key = (address.buffer, element, address.stride);
        if let Some((_, known)) = self.stored_to.as_ref().filter(|(other, _)| *other == key) {
            return known.clone();
        }
        let places = self.places(address, element, active);
        self.stored_to = Some((key, places.clone()));
        places
    }
}
