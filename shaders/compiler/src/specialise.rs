//! Evaluates a program in part: known words of buffers become constants, what follows from them is computed, branches that
//! are never taken vanish, short loops whose turns are known are written out, and what does not change in a loop is computed before it.
//!
//! Results are the same to the last bit. A float is folded only where its result is zero or normal, by the arithmetic that every
//! backend has, and no law of real numbers is used that floats don't obey. That zero times a number is zero, whatever the signs, is used
//! where zeros' signs don't matter: walls along an axis have many zeros.

use std::collections::BTreeMap;

use crate::hoist::hoist;
use crate::interpret::{apply, check, is_ordinary};
use crate::tidy::remove_unused;
use crate::tree::{Address, Binary, Block, Label, Op, Program, Statement, Ty, Unary, Value, visit};

/// What is known of a kernel's buffers before it runs.
pub struct Known<'a> {
    /// The word of a buffer, by binding number, element and word within the element; the element is `None` if there is just one, or if
    /// it is not known. Elements beyond the last are the last. `None` for words that are not known, or that the kernel writes.
    pub word: &'a dyn Fn(u32, Option<u32>, u32) -> Option<u32>,
    /// Whether a zero's sign may matter. It does to nothing in a kernel that keeps all that it stores from having one, and looks at the bits of
    /// no float that may be zero.
    pub signed_zeros: bool,
}

/// Most turns of an unrolled loop.
const TURNS: u32 = 32;
/// Most values of all turns of an unrolled loop.
const VALUES: usize = 2_000;

/// Evaluates a program in part.
pub fn specialise(program: &Program, known: &Known<'_>) -> Program {
    let mut partial = Partial {
        old: program,
        known,
        new: Program {
            variables: program.variables.clone(),
            arrays: program.arrays.clone(),
            buffers: program.buffers,
            calls: program.calls.clone(),
            ..Program::default()
        },
        values: vec![None; program.values.len()],
        constants: BTreeMap::new(),
        state: KnownValues {
            variables: vec![None; program.variables.len()],
            arrays: vec![Vec::new(); program.arrays.len()],
        },
        labels: BTreeMap::new(),
        branches: 0,
        attempts: Vec::new(),
        has_failed: false,
        scopes: Scopes::default(),
    };
    let mut body = Vec::new();
    partial.scopes.open();
    partial.block(&program.body, &mut body);
    let mut new = partial.new;
    new.body = body;
    remove_unused(&mut new);
    hoist(&mut new);
    new
}

/// Known new values of variables and elements of arrays.
#[derive(Clone)]
struct KnownValues {
    variables: Vec<Option<Value>>,
    /// Empty until the array is declared.
    arrays: Vec<Vec<Option<Value>>>,
}

impl KnownValues {
    /// Forgets what differs from another state.
    fn join(&mut self, other: &Self) {
        let differ = |(value, other): (&mut Option<Value>, &Option<Value>)| {
            if value != other {
                *value = None;
            }
        };
        self.variables.iter_mut().zip(&other.variables).for_each(differ);
        for (array, other) in self.arrays.iter_mut().zip(&other.arrays) {
            if array.len() == other.len() {
                array.iter_mut().zip(other).for_each(differ);
            } else {
                array.clear();
            }
        }
    }
}

/// Which values can be used at the statement at hand: those that were computed in a block around it.
#[derive(Default)]
struct Scopes {
    /// Blocks around the statement, the outermost first.
    open: Vec<usize>,
    /// For each block the one that its statements went into, if it is no more than its statements; else itself.
    within: Vec<usize>,
    /// The block of each new value.
    of_values: Vec<usize>,
}

impl Scopes {
    fn open(&mut self) {
        self.open.push(self.within.len());
        self.within.push(self.within.len());
    }

    /// Closes the innermost block. `dissolves` is whether its statements are now those of the block around it.
    fn close(&mut self, dissolves: bool) {
        let closed = self.open.pop().expect("it was opened");
        if dissolves {
            self.within[closed] = self.open.last().copied().unwrap_or(closed);
        }
    }

    /// Notes the block of all values up to a number that have none yet.
    fn note(&mut self, values: usize) {
        let block = self.open.last().copied().unwrap_or_default();
        self.of_values.resize(values.max(self.of_values.len()), block);
    }

    fn is_visible(&self, value: Value) -> bool {
        let mut scope = self.of_values[value.0 as usize];
        while self.within[scope] != scope {
            scope = self.within[scope];
        }
        self.open.contains(&scope)
    }
}

/// A block that can be left.
#[derive(Clone)]
struct Target {
    label: Label,
    /// What all its exits know; none if it has no exit.
    left: Option<KnownValues>,
    /// Number of unknown branches around it.
    branches: u32,
}

/// A loop that may be written out.
struct Attempt {
    label: Label,
    values: usize,
}

struct Partial<'a> {
    old: &'a Program,
    known: &'a Known<'a>,
    new: Program,
    /// The new value of each old one.
    values: Vec<Option<Value>>,
    constants: BTreeMap<(u8, u32), Value>,
    state: KnownValues,
    /// By the old labels.
    labels: BTreeMap<Label, Target>,
    /// Number of unknown branches around the statement at hand.
    branches: u32,
    /// Loops around it that may be written out, the outermost first.
    attempts: Vec<Attempt>,
    /// Whether the innermost of them can't be.
    has_failed: bool,
    scopes: Scopes,
}

impl Partial<'_> {
    fn constant(&mut self, bits: u32, ty: Ty) -> Value {
        let new = &mut self.new;
        *self
            .constants
            .entry((ty as u8, bits))
            .or_insert_with(|| new.add(Op::Constant(bits), ty))
    }

    /// The new value of an old one.
    fn value(&mut self, old: Value) -> Value {
        if let Op::Constant(bits) = self.old.op(old) {
            return self.constant(bits, self.old.ty(old));
        }
        self.values[old.0 as usize].expect("a value is computed before it is used")
    }

    /// Bits of a new value, if they are known.
    fn bits(&self, new: Value) -> Option<u32> {
        match self.new.op(new) {
            Op::Constant(bits) => Some(bits),
            _ => None,
        }
    }

    /// A value that a variable or an element is known to have, if it can be used here.
    fn kept(&self, value: Option<Value>) -> Option<Value> {
        value.filter(|value| self.bits(*value).is_some() || self.scopes.is_visible(*value))
    }

    /// Adds a value that is computed here.
    fn new_value(&mut self, op: Op, ty: Ty) -> Value {
        self.scopes.note(self.new.values.len());
        let new = self.new.add(op, ty);
        self.scopes.note(self.new.values.len());
        new
    }

    /// Adds a value that stands for an old one, with its name and place.
    fn add(&mut self, old: Value, op: Op, out: &mut Block) {
        let node = &self.old.values[old.0 as usize];
        let new = self.new_value(op, node.ty);
        let node_of_new = &mut self.new.values[new.0 as usize];
        (node_of_new.name, node_of_new.span, node_of_new.call) = (node.name.clone(), node.span, node.call);
        out.push(Statement::Let(new));
        self.values[old.0 as usize] = Some(new);
    }

    /// Runs a block. Returns whether its end can be reached.
    fn block(&mut self, block: &Block, out: &mut Block) -> bool {
        block
            .iter()
            .all(|statement| self.statement(statement, out) && !self.has_failed)
    }

    fn statement(&mut self, statement: &Statement, out: &mut Block) -> bool {
        match statement {
            Statement::Let(value) => self.compute(*value, out),
            Statement::Load { targets, address } => self.load(targets, address, out),
            Statement::Declare(variable) => {
                let info = &self.old.variables[variable.0 as usize];
                self.state.variables[variable.0 as usize] = Some(self.constant(info.init, info.ty));
                out.push(statement.clone());
            }
            Statement::DeclareArray(array) => {
                let info = &self.old.arrays[array.0 as usize];
                let init = info.init.iter().map(|bits| Some(self.constant(*bits, info.ty)));
                self.state.arrays[array.0 as usize] = init.collect();
                out.push(statement.clone());
            }
            Statement::Write(variable, value) => {
                let value = self.value(*value);
                self.state.variables[variable.0 as usize] = Some(value);
                out.push(Statement::Write(*variable, value));
            }
            Statement::WriteElement {
                array,
                index,
                value,
                span,
            } => {
                let (index, value) = (self.value(*index), self.value(*value));
                let at = self.bits(index);
                let elements = &mut self.state.arrays[array.0 as usize];
                match (at, elements.len()) {
                    (_, 0) => {}
                    (Some(at), length) => elements[(at as usize).min(length - 1)] = Some(value),
                    (None, _) => elements.fill(None),
                }
                let (array, span) = (*array, *span);
                out.push(Statement::WriteElement {
                    array,
                    index,
                    value,
                    span,
                });
            }
            Statement::Store { address, value, span } => {
                let (address, value, span) = (self.address(address), self.value(*value), *span);
                out.push(Statement::Store { address, value, span });
            }
            Statement::If {
                condition,
                accept,
                reject,
            } => return self.branch(*condition, [accept, reject], out),
            Statement::Labeled { label, body, function } => {
                let mut inner = Vec::new();
                let new = self.enter(*label);
                self.scopes.open();
                let ends = self.block(body, &mut inner);
                let is_left = self.leave(*label, ends);
                let dissolves = Self::place(new, inner, function.clone(), out);
                self.scopes.close(dissolves);
                return ends || is_left;
            }
            Statement::Loop { label, body, span } => return self.turns(*label, body, *span, out),
            Statement::Exit(label) => {
                self.exit(*label);
                let new = self.labels[label].label;
                out.push(Statement::Exit(new));
                return false;
            }
        }
        true
    }

    /// Puts a block that can be left into its place: without its last exit, and without a label if that was the only one. Returns whether
    /// it then is no more than its statements.
    fn place(label: Label, mut body: Block, function: Option<String>, out: &mut Block) -> bool {
        if matches!(body.last(), Some(Statement::Exit(last)) if *last == label) {
            body.pop();
        }
        let mut is_left = false;
        visit(&body, &mut |statement| {
            is_left |= matches!(statement, Statement::Exit(left) if *left == label);
        });
        if is_left {
            out.push(Statement::Labeled { label, body, function });
        } else {
            out.append(&mut body);
        }
        !is_left
    }

    /// Begins a block that can be left. Returns its new label.
    fn enter(&mut self, old: Label) -> Label {
        let label = Label(self.new.labels);
        self.new.labels += 1;
        let target = Target {
            label,
            left: None,
            branches: self.branches,
        };
        self.labels.insert(old, target);
        label
    }

    /// Ends a block that can be left. `ends` is whether its end is reached. Returns whether it was left before.
    fn leave(&mut self, old: Label, ends: bool) -> bool {
        let left = self.labels.get_mut(&old).and_then(|target| target.left.take());
        let is_left = left.is_some();
        match left {
            Some(left) if ends => self.state.join(&left),
            Some(left) => self.state = left,
            None => {}
        }
        is_left
    }

    /// Leaves a block.
    fn exit(&mut self, old: Label) {
        let target = self.labels.get_mut(&old).expect("exits lie in their blocks");
        // A turn that may be the last or not: the loop stays one.
        self.has_failed |= self.attempts.iter().any(|attempt| attempt.label == old) && self.branches > target.branches;
        match &mut target.left {
            Some(left) => left.join(&self.state),
            left => *left = Some(self.state.clone()),
        }
    }

    fn branch(&mut self, condition: Value, [accept, reject]: [&Block; 2], out: &mut Block) -> bool {
        let condition = self.value(condition);
        if let Some(bits) = self.bits(condition) {
            return self.block(if bits == 0 { reject } else { accept }, out);
        }
        self.branches += 1;
        let before = self.state.clone();
        let (mut accepted, mut rejected) = (Vec::new(), Vec::new());
        self.scopes.open();
        let first = self.block(accept, &mut accepted);
        self.scopes.close(false);
        let after = std::mem::replace(&mut self.state, before);
        self.scopes.open();
        let second = !self.has_failed && self.block(reject, &mut rejected);
        self.scopes.close(false);
        self.branches -= 1;
        match (first, second) {
            (true, true) => self.state.join(&after),
            (true, false) => self.state = after,
            _ => {}
        }
        out.push(Statement::If {
            condition,
            accept: accepted,
            reject: rejected,
        });
        first || second
    }

    /// Writes the turns of a loop out if they are few, and keeps the loop otherwise.
    fn turns(&mut self, label: Label, body: &Block, span: naga::Span, out: &mut Block) -> bool {
        let before = (self.state.clone(), self.labels.clone());
        let start = self.new.values.len();
        let mut all = Vec::new();
        let new = self.enter(label);
        self.attempts.push(Attempt { label, values: start });
        let mut turns = 0;
        self.scopes.open();
        while self.block(body, &mut all) && !self.has_failed {
            turns += 1;
            self.has_failed |= turns > TURNS;
        }
        self.attempts.pop();
        if !self.has_failed {
            let is_left = self.leave(label, false);
            let dissolves = Self::place(new, all, None, out);
            self.scopes.close(dissolves);
            return is_left;
        }
        self.scopes.close(false);
        if self
            .attempts
            .first()
            .is_some_and(|outermost| self.new.values.len() - outermost.values > VALUES)
        {
            // Nor can the one around it be written out.
            return false;
        }
        self.has_failed = false;
        self.new.values.truncate(start);
        self.scopes.of_values.truncate(start);
        self.constants.retain(|_, value| (value.0 as usize) < start);
        (self.state, self.labels) = before;
        self.forget(body);
        let new = self.enter(label);
        let mut inner = Vec::new();
        self.scopes.open();
        self.block(body, &mut inner);
        self.scopes.close(false);
        let is_left = self.leave(label, false);
        out.push(Statement::Loop {
            label: new,
            body: inner,
            span,
        });
        is_left
    }

    /// Forgets all that a block may write.
    fn forget(&mut self, block: &Block) {
        let state = &mut self.state;
        visit(block, &mut |statement| match statement {
            Statement::Write(variable, _) | Statement::Declare(variable) => state.variables[variable.0 as usize] = None,
            Statement::WriteElement { array, .. } | Statement::DeclareArray(array) => {
                state.arrays[array.0 as usize].fill(None);
            }
            _ => {}
        });
    }

    fn address(&mut self, address: &Address) -> Address {
        Address {
            element: address.element.map(|element| self.value(element)),
            ..*address
        }
    }

    fn load(&mut self, targets: &[Value], address: &Address, out: &mut Block) {
        let address = self.address(address);
        let element = address.element.and_then(|element| self.bits(element));
        let mut is_known = true;
        let mut loaded = Vec::new();
        for (word, target) in (0..).zip(targets) {
            let ty = self.old.ty(*target);
            let bits = (self.known.word)(address.buffer, element, address.offset + word);
            let new = if let Some(bits) = bits.filter(|bits| is_ordinary(ty, *bits)) {
                self.constant(bits, ty)
            } else {
                is_known = false;
                self.new_value(Op::Loaded, ty)
            };
            self.values[target.0 as usize] = Some(new);
            loaded.push(new);
        }
        if is_known {
            return;
        }
        for (new, target) in loaded.iter_mut().zip(targets) {
            if self.bits(*new).is_some() {
                // Nothing uses it.
                *new = self.new_value(Op::Loaded, self.old.ty(*target));
            }
        }
        let targets = loaded;
        out.push(Statement::Load { targets, address });
    }

    fn compute(&mut self, old: Value, out: &mut Block) {
        if let Some(outermost) = self.attempts.first() {
            self.has_failed |= self.new.values.len() - outermost.values > VALUES;
        }
        let ty = self.old.ty(old);
        let op = self.old.op(old);
        let known = match op {
            Op::Read(variable) => self.kept(self.state.variables[variable.0 as usize]),
            Op::ReadElement(array, index) => {
                let index = self.value(index);
                let elements = &self.state.arrays[array.0 as usize];
                let at = self.bits(index).zip(elements.len().checked_sub(1));
                let element = at.and_then(|(at, last)| elements[(at as usize).min(last)]);
                self.kept(element)
            }
            _ => self.folded(old).map(|bits| self.constant(bits, ty)),
        };
        if known.is_some() {
            self.values[old.0 as usize] = known;
            return;
        }
        let new = match op {
            Op::Unary(op, a) => Op::Unary(op, self.value(a)),
            Op::Binary(op, a, b) => {
                let (a, b) = (self.value(a), self.value(b));
                let same = self.same(op, a, b).or_else(|| self.same_but_for_zeros(op, a, b));
                let same = same.or_else(|| self.compared_with_itself(op, a, b));
                if same.is_some() {
                    self.values[old.0 as usize] = same;
                    return;
                }
                match op {
                    Binary::Subtract if self.is_any_zero(a) => Op::Unary(Unary::Negate, b),
                    _ => Op::Binary(op, a, b),
                }
            }
            Op::Select {
                condition,
                accept,
                reject,
            } => {
                let (condition, accept, reject) = (self.value(condition), self.value(accept), self.value(reject));
                let taken = match self.bits(condition) {
                    Some(0) => Some(reject),
                    Some(_) => Some(accept),
                    None if self.is_any_zero(accept) && self.is_any_zero(reject) => Some(accept),
                    None => (accept == reject).then_some(accept),
                };
                if taken.is_some() {
                    self.values[old.0 as usize] = taken;
                    return;
                }
                Op::Select {
                    condition,
                    accept,
                    reject,
                }
            }
            Op::Convert(a) => Op::Convert(self.value(a)),
            Op::Bitcast(a) => Op::Bitcast(self.value(a)),
            Op::ReadElement(array, index) => Op::ReadElement(array, self.value(index)),
            other => other,
        };
        self.add(old, new, out);
    }

    /// Bits of an operation on known operands.
    fn folded(&mut self, old: Value) -> Option<u32> {
        let op = self.old.op(old);
        let mut operands = [0; 3];
        let mut count = 0;
        for operand in op.operands() {
            let new = self.value(operand);
            operands[count] = self.bits(new)?;
            count += 1;
        }
        // Calls that break the rules are left to the device: nobody relies on them.
        let is_computed = count > 0 && check(self.old, old, operands).is_ok();
        is_computed.then(|| apply(self.old, old, operands))
    }

    /// Whether a value is a zero of either sign, and that doesn't matter.
    fn is_any_zero(&self, value: Value) -> bool {
        let is_zero = |bits: u32| f32::from_bits(bits) == 0.0;
        !self.known.signed_zeros && self.new.ty(value) == Ty::F32 && self.bits(value).is_some_and(is_zero)
    }

    /// Result of an operation of floats of which one is zero, except for the sign of a zero.
    fn same_but_for_zeros(&mut self, op: Binary, a: Value, b: Value) -> Option<Value> {
        match (op, self.is_any_zero(a), self.is_any_zero(b)) {
            (Binary::Multiply, true, _) | (Binary::Multiply, _, true) => Some(self.constant(0, Ty::F32)),
            (Binary::Add, true, _) => Some(b),
            (Binary::Add | Binary::Subtract, _, true) => Some(a),
            _ => None,
        }
    }

    /// Result of a comparison of a value with itself. A float may be NaN.
    fn compared_with_itself(&mut self, op: Binary, a: Value, b: Value) -> Option<Value> {
        if a != b || self.new.ty(a) == Ty::F32 {
            return None;
        }
        match op {
            Binary::Equal | Binary::LessEqual | Binary::GreaterEqual => Some(self.constant(1, Ty::Bool)),
            Binary::NotEqual | Binary::Less | Binary::Greater => Some(self.constant(0, Ty::Bool)),
            _ => None,
        }
    }

    /// The operand that an operation always results in.
    fn same(&self, op: Binary, a: Value, b: Value) -> Option<Value> {
        const ONE: u32 = 1.0_f32.to_bits();
        const MINUS_ZERO: u32 = (-0.0_f32).to_bits();
        let right = |op: Binary, ty: Ty, bits: u32| {
            matches!(
                (op, ty, bits),
                (Binary::Multiply, Ty::F32, ONE)
                    | (Binary::Multiply | Binary::Divide, Ty::I32 | Ty::U32, 1)
                    | (Binary::Add, Ty::F32, MINUS_ZERO)
                    | (Binary::Subtract, Ty::F32, 0)
                    | (
                        Binary::Add
                            | Binary::Subtract
                            | Binary::Or
                            | Binary::Xor
                            | Binary::ShiftLeft
                            | Binary::ShiftRight,
                        Ty::I32 | Ty::U32,
                        0
                    )
                    | (Binary::And, Ty::I32 | Ty::U32, u32::MAX)
                    | (Binary::And, Ty::Bool, 1)
                    | (Binary::Or | Binary::Xor, Ty::Bool, 0)
            )
        };
        let commutes = matches!(
            op,
            Binary::Add | Binary::Multiply | Binary::And | Binary::Or | Binary::Xor
        );
        let ty = self.new.ty(a);
        if self.bits(b).is_some_and(|bits| right(op, ty, bits)) {
            return Some(a);
        }
        if commutes && self.bits(a).is_some_and(|bits| right(op, ty, bits)) {
            return Some(b);
        }
        // Absorbed by it.
        let absorbs = |bits: u32| match (op, ty) {
            (Binary::And, Ty::Bool) | (Binary::And | Binary::Multiply, Ty::I32 | Ty::U32) => bits == 0,
            (Binary::Or, Ty::Bool) => bits == 1,
            _ => false,
        };
        [a, b]
            .into_iter()
            .find(|operand| self.bits(*operand).is_some_and(absorbs))
    }
}
