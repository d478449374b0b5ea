//! Interprets programs: one invocation at a time with plain jumps, which defines the right results, and is how kernels run
//! where nothing compiles them; and for tests many lanes at once under masks, as lane code does. Both must leave the same bits
//! in the buffers.

use std::collections::{BTreeSet, HashSet};
use std::num::FpCategory;

use crate::tree::{Address, Array, Binary, Block, Label, Op, Program, Statement, Ty, Unary, Value, Variable, visit};
use crate::uniform::{Region, Shape, Shapes, depth_of};

/// The buffers of a dispatch, by binding number.
pub trait Buffers {
    /// Number of elements of a buffer, at least 1.
    fn elements(&self, buffer: u32) -> u32;
    /// Loads a word.
    fn load(&self, buffer: u32, index: usize) -> u32;
    /// Stores a word.
    fn store(&mut self, buffer: u32, index: usize, value: u32);
}

/// Buffers that the interpreter has to itself.
#[derive(Debug)]
pub struct Memory<'a> {
    /// Words of each buffer, by binding number. No buffer is empty.
    pub buffers: &'a mut [Vec<u32>],
    /// Words per element of each buffer.
    pub strides: &'a [u32],
}

/// Reasons why a program was not run to its end.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Trap {
    /// Its loops turned more often than is allowed, or it ran more statements than any test's program should.
    #[error("it runs too long")]
    Endless,
    /// It used a value or variable that nothing has set.
    #[error("{0} is used before it is set")]
    Unset(String),
    /// It did something that the exactness rules leave undefined.
    #[error("{0}: kernels hold no NaN, infinity, subnormal, or number out of range")]
    Inexact(String),
}

/// A deliberate mistake, which tests must notice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// All exits are jumps and no write is masked, as if nothing diverged.
    NothingDiverges,
    /// Varying variables are written in all lanes.
    WritesUnmasked,
    /// Idle lanes also write to buffers.
    StoresUnmasked,
    /// An exit leaves only the innermost mask.
    ExitsStayInOuterMasks,
    /// An exit leaves only the mask of its label's block.
    ExitsStayInInnerMasks,
    /// A variable outside a block that some lanes have left is written as if none had.
    LeftBlocksForgotten,
}

/// Most statements of a run.
const PATIENCE: u64 = 2_000_000;

impl Buffers for Memory<'_> {
    fn elements(&self, buffer: u32) -> u32 {
        self.buffers[buffer as usize].len() as u32 / self.strides[buffer as usize]
    }

    fn load(&self, buffer: u32, index: usize) -> u32 {
        self.buffers[buffer as usize][index]
    }

    fn store(&mut self, buffer: u32, index: usize, value: u32) {
        self.buffers[buffer as usize][index] = value;
    }
}

/// Index of a word, with its element clamped to those of the buffer.
fn at(memory: &impl Buffers, address: &Address, element: u32) -> usize {
    let last = memory.elements(address.buffer) - 1;
    let first = address.element.map_or(0, |_| element.min(last) * address.stride);
    (first + address.offset) as usize
}

/// Runs one invocation, whose loops may take `turns` turns in all.
///
/// # Errors
/// [`Trap::Endless`] if they take more. A program that uses a value that isn't set, which the compiler makes none of.
pub fn run(program: &Program, memory: &mut impl Buffers, workgroup: u32, lane: u32, turns: u64) -> Result<(), Trap> {
    let mut invocation = Invocation {
        turns_left: turns,
        ..Invocation::new(program, memory, workgroup, lane)
    };
    invocation.block(&program.body)?;
    Ok(())
}

/// Runs one invocation as a compiler's program would that adds products without rounding them: where both operands are products, the left
/// or the right one.
///
/// # Errors
/// As [`run`].
pub fn run_fused(program: &Program, memory: &mut impl Buffers, is_left: bool, turns: u64) -> Result<(), Trap> {
    let mut invocation = Invocation {
        fuses_left: Some(is_left),
        turns_left: turns,
        ..Invocation::new(program, memory, 0, 0)
    };
    invocation.block(&program.body)?;
    Ok(())
}

/// An operation that broke the exactness rules.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Breach {
    /// Its value.
    pub value: Value,
    /// The operation with its operands, and its result.
    pub what: String,
}

/// Runs one invocation up to the first operation that breaks the exactness rules, if any does. Its loops may take `turns` turns in
/// all.
///
/// # Errors
/// As [`run`].
pub fn run_checked(
    program: &Program,
    memory: &mut impl Buffers,
    workgroup: u32,
    lane: u32,
    turns: u64,
) -> Result<Option<Breach>, Trap> {
    let mut invocation = Invocation {
        strict: true,
        turns_left: turns,
        ..Invocation::new(program, memory, workgroup, lane)
    };
    match (invocation.block(&program.body), invocation.breach) {
        (Err(Trap::Inexact(what)), Some(value)) => Ok(Some(Breach { value, what })),
        (done, _) => done.map(|_| None),
    }
}

/// The statements that some invocation of a group has run, and in which turns of the loops around them.
#[derive(Debug, Default)]
pub(crate) struct Watch {
    seen: HashSet<(usize, u64)>,
    /// Stands for the turns at hand.
    turns: u64,
}

impl Watch {
    fn see(&mut self, statement: &Statement) {
        self.seen.insert((std::ptr::from_ref(statement).addr(), self.turns));
    }

    /// Begins a turn of a loop that was entered in the turns `around` it.
    fn turn(&mut self, label: Label, turn: u64, around: u64) {
        // Mixed well enough that two ways to a statement have two numbers.
        let mixed = (around ^ (u64::from(label.0) << 32 | turn)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.turns = mixed ^ (mixed >> 29);
    }

    fn turns(&self) -> u64 {
        self.turns
    }

    /// The addresses of the statements, once for each of their turns.
    pub(crate) fn statements(&self) -> impl Iterator<Item = usize> {
        self.seen.iter().map(|(statement, _)| *statement)
    }

    fn leave(&mut self, around: u64) {
        self.turns = around;
    }
}

/// Runs one invocation, and notes each statement that it runs.
///
/// # Errors
/// As [`run`].
pub(crate) fn run_watched(
    program: &Program,
    memory: &mut impl Buffers,
    workgroup: u32,
    lane: u32,
    watch: &mut Watch,
) -> Result<(), Trap> {
    let mut invocation = Invocation {
        watch: Some(watch),
        ..Invocation::new(program, memory, workgroup, lane)
    };
    invocation.block(&program.body)?;
    Ok(())
}

/// Runs one invocation of a test, and returns the number of turns that all its loops took.
///
/// # Errors
/// A program that runs too long or uses a value that isn't set, and if `strict`, one that breaks the exactness rules.
pub fn run_invocation(
    program: &Program,
    memory: &mut impl Buffers,
    workgroup: u32,
    lane: u32,
    strict: bool,
) -> Result<u64, Trap> {
    let mut invocation = Invocation {
        strict,
        patience: PATIENCE,
        ..Invocation::new(program, memory, workgroup, lane)
    };
    invocation.block(&program.body)?;
    Ok(invocation.turns)
}

struct Invocation<'a, M> {
    program: &'a Program,
    memory: &'a mut M,
    workgroup: u32,
    lane: u32,
    strict: bool,
    values: Vec<Option<u32>>,
    variables: Vec<Option<u32>>,
    arrays: Vec<Vec<u32>>,
    patience: u64,
    turns: u64,
    turns_left: u64,
    /// The value that broke the exactness rules.
    breach: Option<Value>,
    /// Sees every statement that is run.
    watch: Option<&'a mut Watch>,
    /// Whether sums take products unrounded, and the left ones first.
    fuses_left: Option<bool>,
}

impl<'a, M: Buffers> Invocation<'a, M> {
    fn new(program: &'a Program, memory: &'a mut M, workgroup: u32, lane: u32) -> Self {
        Self {
            program,
            memory,
            workgroup,
            lane,
            strict: false,
            values: vec![None; program.values.len()],
            variables: vec![None; program.variables.len()],
            arrays: vec![Vec::new(); program.arrays.len()],
            patience: u64::MAX,
            turns: 0,
            turns_left: u64::MAX,
            breach: None,
            watch: None,
            fuses_left: None,
        }
    }

    fn get(&self, value: Value) -> Result<u32, Trap> {
        match self.program.op(value) {
            Op::Constant(bits) => Ok(bits),
            _ => self.values[value.0 as usize].ok_or_else(|| unset_value(self.program, value)),
        }
    }

    fn element(&self, array: Array, index: Value) -> Result<usize, Trap> {
        let length = self.arrays[array.0 as usize].len();
        if length == 0 {
            return Err(Trap::Unset(self.program.arrays[array.0 as usize].name.clone()));
        }
        Ok((self.get(index)? as usize).min(length - 1))
    }

    fn computed(&self, value: Value) -> Result<u32, Trap> {
        let op = self.program.op(value);
        match op {
            Op::Lane => Ok(self.lane),
            Op::Workgroup => Ok(self.workgroup),
            Op::Read(variable) => {
                self.variables[variable.0 as usize].ok_or_else(|| unset_variable(self.program, variable))
            }
            Op::ReadElement(array, index) => Ok(self.arrays[array.0 as usize][self.element(array, index)?]),
            _ => {
                let mut operands = [0; 3];
                for (slot, operand) in operands.iter_mut().zip(op.operands()) {
                    *slot = self.get(operand)?;
                }
                if self.strict {
                    check(self.program, value, operands)?;
                }
                if let Some(is_left) = self.fuses_left
                    && let Some(fused) = self.fused(value, operands, is_left)
                {
                    return Ok(fused);
                }
                Ok(apply(self.program, value, operands))
            }
        }
    }

    /// A sum or a difference of floats that takes a product unrounded, if it has one.
    fn fused(&self, value: Value, [a, b, _]: [u32; 3], is_left: bool) -> Option<u32> {
        let Op::Binary(op @ (Binary::Add | Binary::Subtract), left, right) = self.program.op(value) else {
            return None;
        };
        if self.program.ty(value) != Ty::F32 {
            return None;
        }
        let factors = |operand: Value| match self.program.op(operand) {
            Op::Binary(Binary::Multiply, x, y) => {
                let [x, y] = [self.get(x).ok()?, self.get(y).ok()?];
                Some([f32::from_bits(x), f32::from_bits(y)])
            }
            _ => None,
        };
        let (of_left, of_right) = (factors(left), factors(right));
        let [a, b] = [a, b].map(f32::from_bits);
        let is_difference = op == Binary::Subtract;
        let sum = match (of_left, of_right) {
            (Some([x, y]), other) if is_left || other.is_none() => x.mul_add(y, if is_difference { -b } else { b }),
            (_, Some([x, y])) => (if is_difference { -x } else { x }).mul_add(y, a),
            _ => return None,
        };
        Some(sum.to_bits())
    }

    /// Runs a block. Returns the label that an exit leaves, if it ended with one.
    fn block(&mut self, block: &Block) -> Result<Option<Label>, Trap> {
        for statement in block {
            if let Some(label) = self.statement(statement)? {
                return Ok(Some(label));
            }
        }
        Ok(None)
    }

    fn statement(&mut self, statement: &Statement) -> Result<Option<Label>, Trap> {
        self.patience = self.patience.checked_sub(1).ok_or(Trap::Endless)?;
        if let Some(watch) = &mut self.watch {
            watch.see(statement);
        }
        match statement {
            Statement::Let(value) => {
                let computed = self.computed(*value);
                if let Err(Trap::Inexact(_)) = computed {
                    self.breach = Some(*value);
                }
                self.values[value.0 as usize] = Some(computed?);
            }
            Statement::Load { targets, address } => {
                let element = address.element.map_or(Ok(0), |element| self.get(element))?;
                let first = at(self.memory, address, element);
                for (word, target) in targets.iter().enumerate() {
                    self.values[target.0 as usize] = Some(self.memory.load(address.buffer, first + word));
                }
            }
            Statement::Declare(variable) => {
                self.variables[variable.0 as usize] = Some(self.program.variables[variable.0 as usize].init);
            }
            Statement::DeclareArray(array) => {
                self.arrays[array.0 as usize].clone_from(&self.program.arrays[array.0 as usize].init);
            }
            Statement::Write(variable, value) => {
                let value = self.get(*value)?;
                let slot = &mut self.variables[variable.0 as usize];
                if slot.replace(value).is_none() {
                    return Err(unset_variable(self.program, *variable));
                }
            }
            Statement::WriteElement {
                array, index, value, ..
            } => {
                let at = self.element(*array, *index)?;
                self.arrays[array.0 as usize][at] = self.get(*value)?;
            }
            Statement::Store { address, value, .. } => {
                let element = address.element.map_or(Ok(0), |element| self.get(element))?;
                let value = self.get(*value)?;
                self.memory
                    .store(address.buffer, at(self.memory, address, element), value);
            }
            Statement::If {
                condition,
                accept,
                reject,
            } => {
                let branch = if self.get(*condition)? != 0 { accept } else { reject };
                return self.block(branch);
            }
            Statement::Loop { label, body, .. } => {
                let around = self.watch.as_ref().map_or(0, |watch| watch.turns());
                let mut turn = 0;
                let left = loop {
                    self.patience = self.patience.checked_sub(1).ok_or(Trap::Endless)?;
                    self.turns_left = self.turns_left.checked_sub(1).ok_or(Trap::Endless)?;
                    self.turns += 1;
                    turn += 1;
                    if let Some(watch) = &mut self.watch {
                        watch.turn(*label, turn, around);
                    }
                    if let Some(left) = self.block(body)? {
                        break left;
                    }
                };
                if let Some(watch) = &mut self.watch {
                    watch.leave(around);
                }
                return Ok(Some(left).filter(|left| left != label));
            }
            Statement::Labeled { label, body, .. } => {
                return Ok(self.block(body)?.filter(|left| left != label));
            }
            Statement::Exit(label) => return Ok(Some(*label)),
        }
        Ok(None)
    }
}

/// Runs `N` lanes of a workgroup, from `first_lane` on, under masks. `fault` is a mistake to make.
///
/// # Errors
/// A program that runs too long or uses a value that isn't set.
pub fn run_lanes<const N: usize>(
    program: &Program,
    shapes: &Shapes,
    memory: &mut Memory<'_>,
    workgroup: u32,
    first_lane: u32,
    fault: Option<Fault>,
) -> Result<(), Trap> {
    let mut group = Group::<N> {
        program,
        shapes,
        memory,
        workgroup,
        first_lane,
        fault,
        values: vec![None; program.values.len()],
        variables: vec![None; program.variables.len()],
        arrays: vec![Vec::new(); program.arrays.len()],
        homes: vec![0; program.variables.len()],
        array_homes: vec![0; program.arrays.len()],
        regions: Vec::new(),
        masks: Vec::new(),
        exits: exits(program),
        patience: PATIENCE,
    };
    group.block(&program.body).map(|_| ())
}

/// Labels with an exit. Only their blocks are printed as blocks.
fn exits(program: &Program) -> BTreeSet<Label> {
    let mut exits = BTreeSet::new();
    visit(&program.body, &mut |statement| {
        if let Statement::Exit(label) = statement {
            exits.insert(*label);
        }
    });
    exits
}

/// Lanes that are active in a region, and the number of regions around that one.
struct Mask<const N: usize> {
    lanes: [bool; N],
    depth: usize,
}

struct Group<'a, 'm, const N: usize> {
    program: &'a Program,
    shapes: &'a Shapes,
    memory: &'a mut Memory<'m>,
    workgroup: u32,
    first_lane: u32,
    fault: Option<Fault>,
    /// Uniform values have the same bits in every lane.
    values: Vec<Option<[u32; N]>>,
    variables: Vec<Option<[u32; N]>>,
    arrays: Vec<Vec<[u32; N]>>,
    homes: Vec<usize>,
    array_homes: Vec<usize>,
    regions: Vec<Region>,
    masks: Vec<Mask<N>>,
    exits: BTreeSet<Label>,
    patience: u64,
}

impl<const N: usize> Group<'_, '_, N> {
    fn get(&self, value: Value) -> Result<[u32; N], Trap> {
        match self.program.op(value) {
            Op::Constant(bits) => Ok([bits; N]),
            _ => self.values[value.0 as usize].ok_or_else(|| unset_value(self.program, value)),
        }
    }

    /// Returns a uniform value.
    fn scalar(&self, value: Value) -> Result<u32, Trap> {
        Ok(self.get(value)?[0])
    }

    fn element(&self, array: Array, index: Value) -> Result<usize, Trap> {
        let length = self.arrays[array.0 as usize].len();
        if length == 0 {
            return Err(Trap::Unset(self.program.arrays[array.0 as usize].name.clone()));
        }
        Ok((self.scalar(index)? as usize).min(length - 1))
    }

    fn active(&self) -> [bool; N] {
        self.masks.last().map_or([true; N], |mask| mask.lanes)
    }

    /// Returns whether some lanes may be idle here that were active inside the first `home` regions.
    fn diverges(&self, home: usize) -> bool {
        match self.fault {
            Some(Fault::NothingDiverges | Fault::WritesUnmasked) => false,
            Some(Fault::LeftBlocksForgotten) => self.regions[home..]
                .iter()
                .any(|region| matches!(region, Region::Branch(true))),
            _ => self.shapes.diverges(&self.regions[home..]),
        }
    }

    fn computed(&self, value: Value) -> Result<[u32; N], Trap> {
        let op = self.program.op(value);
        let mut lanes = match op {
            Op::Lane => std::array::from_fn(|k| self.first_lane + k as u32),
            Op::Workgroup => [self.workgroup; N],
            Op::Read(variable) => {
                self.variables[variable.0 as usize].ok_or_else(|| unset_variable(self.program, variable))?
            }
            Op::ReadElement(array, index) => self.arrays[array.0 as usize][self.element(array, index)?],
            _ => {
                let mut operands = [[0; N]; 3];
                for (slot, operand) in operands.iter_mut().zip(op.operands()) {
                    *slot = self.get(operand)?;
                }
                std::array::from_fn(|k| apply(self.program, value, operands.map(|lanes| lanes[k])))
            }
        };
        let first = lanes[0];
        match self.shapes.shape(value) {
            Shape::Uniform => lanes.fill(first),
            Shape::Linear => lanes = std::array::from_fn(|k| first.wrapping_add(k as u32)),
            Shape::Varying => {}
        }
        Ok(lanes)
    }

    /// Returns a variable's content after a write.
    fn written(&self, varies: bool, home: usize, value: Value, old: [u32; N]) -> Result<[u32; N], Trap> {
        let new = self.get(value)?;
        if !varies {
            return Ok([new[0]; N]);
        }
        if !self.diverges(home) {
            return Ok(new);
        }
        let active = self.active();
        Ok(std::array::from_fn(|k| if active[k] { new[k] } else { old[k] }))
    }

    fn block(&mut self, block: &Block) -> Result<Option<Label>, Trap> {
        for statement in block {
            if let Some(label) = self.statement(statement)? {
                return Ok(Some(label));
            }
        }
        Ok(None)
    }

    /// Runs a block that is printed as one, so that values computed in it are unknown outside.
    fn scope(&mut self, block: &Block) -> Result<Option<Label>, Trap> {
        let left = self.block(block)?;
        visit(block, &mut |statement| {
            for result in statement.results() {
                self.values[result.0 as usize] = None;
            }
        });
        Ok(left)
    }

    fn statement(&mut self, statement: &Statement) -> Result<Option<Label>, Trap> {
        self.patience = self.patience.checked_sub(1).ok_or(Trap::Endless)?;
        match statement {
            Statement::Let(value) => self.values[value.0 as usize] = Some(self.computed(*value)?),
            Statement::Load { targets, address } => self.load(targets, address)?,
            Statement::Declare(variable) => {
                self.homes[variable.0 as usize] = self.regions.len();
                self.variables[variable.0 as usize] = Some([self.program.variables[variable.0 as usize].init; N]);
            }
            Statement::DeclareArray(array) => {
                self.array_homes[array.0 as usize] = self.regions.len();
                let init = &self.program.arrays[array.0 as usize].init;
                self.arrays[array.0 as usize] = init.iter().map(|bits| [*bits; N]).collect();
            }
            Statement::Write(variable, value) => {
                let at = variable.0 as usize;
                let old = self.variables[at].ok_or_else(|| unset_variable(self.program, *variable))?;
                let varies = self.shapes.variable_varies(*variable);
                self.variables[at] = Some(self.written(varies, self.homes[at], *value, old)?);
            }
            Statement::WriteElement {
                array, index, value, ..
            } => {
                let (at, element) = (array.0 as usize, self.element(*array, *index)?);
                let old = self.arrays[at][element];
                let varies = self.shapes.array_varies(*array);
                self.arrays[at][element] = self.written(varies, self.array_homes[at], *value, old)?;
            }
            Statement::Store { address, value, .. } => self.store(address, *value)?,
            Statement::If {
                condition,
                accept,
                reject,
            } => return self.branch(*condition, accept, reject),
            Statement::Loop { label, body, .. } => {
                let masked = self.shapes.loop_is_left_by_some(*label);
                return self.enter(*label, masked, |group| {
                    let mask = group.masks.len().wrapping_sub(1);
                    while !masked || group.masks[mask].lanes.contains(&true) {
                        group.patience = group.patience.checked_sub(1).ok_or(Trap::Endless)?;
                        if let Some(left) = group.scope(body)? {
                            return Ok(Some(left));
                        }
                    }
                    Ok(None)
                });
            }
            Statement::Labeled { label, body, .. } => {
                let masked = self.shapes.is_left_by_some(*label);
                let scoped = self.exits.contains(label);
                return self.enter(*label, masked, |group| {
                    if scoped { group.scope(body) } else { group.block(body) }
                });
            }
            Statement::Exit(label) => return Ok(self.exit(*label)),
        }
        Ok(None)
    }

    /// Runs the block of a label, with a new mask if `masked`.
    fn enter(
        &mut self,
        label: Label,
        masked: bool,
        run: impl FnOnce(&mut Self) -> Result<Option<Label>, Trap>,
    ) -> Result<Option<Label>, Trap> {
        let lanes = self.active();
        let depth = self.regions.len();
        self.regions.push(Region::Label(label));
        if masked {
            self.masks.push(Mask { lanes, depth });
        }
        let left = run(self)?;
        if masked {
            self.masks.pop();
        }
        self.regions.pop();
        Ok(left.filter(|left| *left != label))
    }

    fn branch(&mut self, condition: Value, accept: &Block, reject: &Block) -> Result<Option<Label>, Trap> {
        let test = self.get(condition)?;
        let depth = self.regions.len();
        if self.shapes.is_uniform(condition) {
            self.regions.push(Region::Branch(false));
            let left = self.scope(if test[0] != 0 { accept } else { reject })?;
            self.regions.truncate(depth);
            return Ok(left);
        }
        self.regions.push(Region::Branch(true));
        for (block, chosen) in [(accept, true), (reject, false)] {
            let active = self.active();
            let lanes: [bool; N] = std::array::from_fn(|k| active[k] && (test[k] != 0) == chosen);
            if !lanes.contains(&true) {
                continue;
            }
            self.masks.push(Mask { lanes, depth });
            let left = self.scope(block)?;
            self.masks.pop();
            if left.is_some() {
                self.regions.truncate(depth);
                return Ok(left);
            }
        }
        self.regions.truncate(depth);
        Ok(None)
    }

    fn exit(&mut self, label: Label) -> Option<Label> {
        if self.fault == Some(Fault::NothingDiverges) || !self.shapes.exit_diverges(&self.regions, label) {
            return Some(label);
        }
        let gone = self.active();
        let depth = depth_of(&self.regions, label);
        let innermost = self.masks.len() - 1;
        for (at, mask) in self.masks.iter_mut().enumerate() {
            let stays = match self.fault {
                Some(Fault::ExitsStayInOuterMasks) => at != innermost,
                Some(Fault::ExitsStayInInnerMasks) => mask.depth > depth,
                _ => false,
            };
            if mask.depth >= depth && !stays {
                for (lane, gone) in mask.lanes.iter_mut().zip(gone) {
                    *lane &= !gone;
                }
            }
        }
        None
    }

    fn load(&mut self, targets: &[Value], address: &Address) -> Result<(), Trap> {
        let elements = address.element.map_or(Ok([0; N]), |element| self.get(element))?;
        for (word, target) in targets.iter().enumerate() {
            let load = |element| {
                self.memory
                    .load(address.buffer, at(self.memory, address, element) + word)
            };
            let mut lanes = elements.map(load);
            if self.shapes.is_uniform(*target) {
                lanes = [lanes[0]; N];
            }
            self.values[target.0 as usize] = Some(lanes);
        }
        Ok(())
    }

    fn store_word(&mut self, address: &Address, element: u32, value: u32) {
        self.memory
            .store(address.buffer, at(self.memory, address, element), value);
    }

    fn store(&mut self, address: &Address, value: Value) -> Result<(), Trap> {
        let elements = address.element.map_or(Ok([0; N]), |element| self.get(element))?;
        let value = self.get(value)?;
        let mut active = self.active();
        if self.fault == Some(Fault::StoresUnmasked) {
            active = [true; N];
        }
        if address.element.is_none_or(|element| self.shapes.is_uniform(element)) {
            if active.contains(&true) {
                self.store_word(address, elements[0], value[0]);
            }
            return Ok(());
        }
        for k in 0..N {
            if active[k] {
                self.store_word(address, elements[k], value[k]);
            }
        }
        Ok(())
    }
}

fn unset_value(program: &Program, value: Value) -> Trap {
    let name = program.values[value.0 as usize].name.as_deref().unwrap_or("value");
    Trap::Unset(format!("{name} ({})", value.0))
}

fn unset_variable(program: &Program, variable: Variable) -> Trap {
    Trap::Unset(program.variables[variable.0 as usize].name.clone())
}

/// Applies an operation to its operands' bits.
pub(crate) fn apply(program: &Program, value: Value, [a, b, c]: [u32; 3]) -> u32 {
    let ty = program.ty(value);
    match program.op(value) {
        Op::Unary(op, _) => unary(op, ty, a),
        Op::Binary(op, left, _) => match program.ty(left) {
            Ty::F32 => float(op, f32::from_bits(a), f32::from_bits(b)),
            Ty::I32 => signed(op, a as i32, b as i32),
            Ty::U32 | Ty::Bool => unsigned(op, a, b),
        },
        Op::Select { .. } => {
            if a != 0 {
                b
            } else {
                c
            }
        }
        Op::Convert(from) => convert(program.ty(from), ty, a),
        Op::Bitcast(_) => a,
        Op::Constant(_) | Op::Lane | Op::Workgroup | Op::Read(_) | Op::ReadElement(..) | Op::Loaded => {
            unreachable!("it has no operands")
        }
    }
}

fn unary(op: Unary, ty: Ty, a: u32) -> u32 {
    let x = f32::from_bits(a);
    match (op, ty) {
        (Unary::Negate, Ty::F32) => (-x).to_bits(),
        (Unary::Negate, _) => a.wrapping_neg(),
        (Unary::Not, Ty::Bool) => u32::from(a == 0),
        (Unary::Not, _) => !a,
        (Unary::Abs, Ty::F32) => x.abs().to_bits(),
        (Unary::Abs, Ty::I32) => (a as i32).wrapping_abs() as u32,
        (Unary::Abs, _) => a,
        (Unary::Floor, _) => x.floor().to_bits(),
        (Unary::Trunc, _) => x.trunc().to_bits(),
    }
}

fn convert(from: Ty, to: Ty, a: u32) -> u32 {
    let x = f32::from_bits(a);
    match (from, to) {
        (Ty::Bool, Ty::F32) => f32::from(a as u8).to_bits(),
        (Ty::F32, Ty::Bool) => u32::from(x != 0.0),
        (_, Ty::Bool) => u32::from(a != 0),
        (Ty::I32, Ty::F32) => (a as i32 as f32).to_bits(),
        (Ty::U32, Ty::F32) => (a as f32).to_bits(),
        (Ty::F32, Ty::I32) => x as i32 as u32,
        (Ty::F32, Ty::U32) => x as u32,
        _ => a,
    }
}

fn float(op: Binary, x: f32, y: f32) -> u32 {
    match op {
        Binary::Add => (x + y).to_bits(),
        Binary::Subtract => (x - y).to_bits(),
        Binary::Multiply => (x * y).to_bits(),
        Binary::Min => (if x < y { x } else { y }).to_bits(),
        Binary::Max => (if x > y { x } else { y }).to_bits(),
        _ => compare(op, x, y),
    }
}

fn signed(op: Binary, x: i32, y: i32) -> u32 {
    match op {
        Binary::Min => x.min(y) as u32,
        Binary::Max => x.max(y) as u32,
        Binary::ShiftRight => x.wrapping_shr(y as u32) as u32,
        Binary::Less | Binary::LessEqual | Binary::Greater | Binary::GreaterEqual => compare(op, x, y),
        _ => unsigned(op, x as u32, y as u32),
    }
}

fn unsigned(op: Binary, x: u32, y: u32) -> u32 {
    match op {
        Binary::Add => x.wrapping_add(y),
        Binary::Subtract => x.wrapping_sub(y),
        Binary::Multiply => x.wrapping_mul(y),
        Binary::Divide => x / y.max(1),
        Binary::Remainder => x % y.max(1),
        Binary::Min => x.min(y),
        Binary::Max => x.max(y),
        Binary::And => x & y,
        Binary::Or => x | y,
        Binary::Xor => x ^ y,
        Binary::ShiftLeft => x.wrapping_shl(y),
        Binary::ShiftRight => x.wrapping_shr(y),
        _ => compare(op, x, y),
    }
}

fn compare<T: PartialOrd + Copy>(op: Binary, x: T, y: T) -> u32 {
    u32::from(match op {
        Binary::Equal => x == y,
        Binary::NotEqual => x != y,
        Binary::Less => x < y,
        Binary::LessEqual => x <= y,
        Binary::Greater => x > y,
        Binary::GreaterEqual => x >= y,
        _ => unreachable!("{op:?} does not compare"),
    })
}

/// Returns whether a number is one that kernels may hold.
pub(crate) fn is_ordinary(ty: Ty, bits: u32) -> bool {
    let x = f32::from_bits(bits);
    ty != Ty::F32 || x == 0.0 || x.is_normal()
}

/// Returns whether an operation stays within the exactness rules.
pub(crate) fn check(program: &Program, value: Value, operands: [u32; 3]) -> Result<(), Trap> {
    const WHOLE: i64 = 1 << 24;
    let ty = program.ty(value);
    let result = f32::from_bits(apply(program, value, operands));
    let ordinary = is_ordinary(ty, result.to_bits());
    let [a, b, _] = operands;
    let kept = match program.op(value) {
        Op::Convert(from) => match (program.ty(from), ty) {
            (Ty::F32, Ty::I32 | Ty::U32) => {
                let x = f32::from_bits(a);
                x < WHOLE as f32 && x > if ty == Ty::I32 { -WHOLE as f32 } else { -1.0 }
            }
            (Ty::I32, Ty::F32) => i64::from(a as i32).abs() <= WHOLE,
            (Ty::U32, Ty::F32) => i64::from(a) <= WHOLE,
            _ => true,
        },
        Op::Binary(Binary::Divide | Binary::Remainder, ..) => b != 0,
        Op::Binary(Binary::ShiftLeft | Binary::ShiftRight, ..) => b < 32,
        _ => true,
    };
    if ordinary && kept {
        return Ok(());
    }
    let class = match result.classify() {
        _ if !kept => "out of range",
        FpCategory::Nan => "not a number",
        FpCategory::Infinite => "infinite",
        _ => "subnormal",
    };
    let (operation, result) = (said(program, value, operands), shown(ty, result.to_bits()));
    Err(Trap::Inexact(format!("{operation} is {result}, which is {class}")))
}

/// A number as WGSL has it.
fn shown(ty: Ty, bits: u32) -> String {
    match ty {
        Ty::F32 => format!("{:?}f", f32::from_bits(bits)),
        Ty::I32 => format!("{}i", bits as i32),
        Ty::U32 => format!("{bits}u"),
        Ty::Bool => (bits != 0).to_string(),
    }
}

/// An operation on numbers, as WGSL has it.
fn said(program: &Program, value: Value, operands: [u32; 3]) -> String {
    let op = program.op(value);
    let numbers = op.operands().zip(operands);
    let numbers: Vec<_> = numbers
        .map(|(operand, bits)| shown(program.ty(operand), bits))
        .collect();
    let symbol = match op {
        Op::Binary(Binary::Add, ..) => " + ",
        Op::Binary(Binary::Subtract, ..) => " - ",
        Op::Binary(Binary::Multiply, ..) => " * ",
        Op::Binary(Binary::Divide, ..) => " / ",
        Op::Binary(Binary::Remainder, ..) => " % ",
        Op::Binary(Binary::ShiftLeft, ..) => " << ",
        Op::Binary(Binary::ShiftRight, ..) => " >> ",
        _ => {
            let function = match (op, program.ty(value)) {
                (Op::Bitcast(_), _) => "bitcast<f32>",
                (Op::Convert(_), Ty::F32) => "f32",
                (Op::Convert(_), Ty::I32) => "i32",
                (Op::Convert(_), _) => "u32",
                (Op::Select { .. }, _) => "select",
                (Op::Unary(Unary::Negate, _), _) => "-",
                (Op::Unary(Unary::Abs, _), _) => "abs",
                (Op::Unary(Unary::Floor, _), _) => "floor",
                (Op::Unary(Unary::Trunc, _), _) => "trunc",
                (Op::Binary(Binary::Min, ..), _) => "min",
                _ => "max",
            };
            return format!("{function}({})", numbers.join(", "));
        }
    };
    numbers.join(symbol)
}
