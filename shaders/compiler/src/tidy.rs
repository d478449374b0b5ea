//! Passes that make a program smaller without changing its results. They remove unused values and branches that are never
//! taken, declare variables where they are needed, put values that are used outside a block with exits into variables, and
//! turn short varying branches into selections.

use std::collections::{BTreeMap, BTreeSet};

use crate::tree::{Array, Binary, Block, Label, Op, Program, Statement, Ty, Value, Variable, visit};
use crate::uniform::Shapes;

/// Removes values that nothing uses, and writes that nothing reads.
pub fn remove_unused(program: &mut Program) {
    loop {
        let mut used = BTreeSet::new();
        let mut read = BTreeSet::new();
        let mut read_arrays = BTreeSet::new();
        visit(&program.body, &mut |statement| {
            used.extend(statement.operands(program));
            for result in statement.results() {
                match program.op(*result) {
                    Op::Read(variable) => _ = read.insert(variable),
                    Op::ReadElement(array, _) => _ = read_arrays.insert(array),
                    _ => {}
                }
            }
        });
        let mut removed = false;
        let mut body = std::mem::take(&mut program.body);
        sweep(&mut body, &mut |statement| {
            let keep = match statement {
                Statement::Let(value) => used.contains(value),
                Statement::Load { targets, .. } => targets.iter().any(|target| used.contains(target)),
                Statement::Write(variable, _) | Statement::Declare(variable) => read.contains(variable),
                Statement::WriteElement { array, .. } | Statement::DeclareArray(array) => read_arrays.contains(array),
                Statement::If { accept, reject, .. } => !accept.is_empty() || !reject.is_empty(),
                Statement::Labeled { body, .. } => !body.is_empty(),
                _ => true,
            };
            removed |= !keep;
            keep
        });
        program.body = body;
        if !removed {
            return;
        }
    }
}

/// Keeps the statements for which `keep` returns true, beginning with those of inner blocks.
fn sweep(block: &mut Block, keep: &mut impl FnMut(&Statement) -> bool) {
    for statement in block.iter_mut() {
        for inner in statement.blocks_mut() {
            sweep(inner, keep);
        }
    }
    block.retain(|statement| keep(statement));
}

/// Gives each declaration its variable or array. Those of a loop whose turns are written out, or of a function that was inlined
/// several times, are one variable before.
pub(crate) fn part_variables(program: &mut Program) {
    let mut body = std::mem::take(&mut program.body);
    Parted {
        program,
        declared: BTreeSet::new(),
        declared_arrays: BTreeSet::new(),
    }
    .block(&mut body, &mut Renamed::default());
    program.body = body;
}

/// Variables and arrays by what they were.
#[derive(Clone, Default)]
struct Renamed {
    variables: BTreeMap<Variable, Variable>,
    arrays: BTreeMap<Array, Array>,
}

struct Parted<'a> {
    program: &'a mut Program,
    declared: BTreeSet<Variable>,
    declared_arrays: BTreeSet<Array>,
}

impl Parted<'_> {
    fn block(&mut self, block: &mut Block, renamed: &mut Renamed) {
        for statement in block {
            match statement {
                Statement::Declare(variable) if !self.declared.insert(*variable) => {
                    let info = self.program.variables[variable.0 as usize].clone();
                    let new = Variable(self.program.variables.len() as u32);
                    self.program.variables.push(info);
                    renamed.variables.insert(*variable, new);
                    *variable = new;
                }
                Statement::DeclareArray(array) if !self.declared_arrays.insert(*array) => {
                    let info = self.program.arrays[array.0 as usize].clone();
                    let new = Array(self.program.arrays.len() as u32);
                    self.program.arrays.push(info);
                    renamed.arrays.insert(*array, new);
                    *array = new;
                }
                Statement::Let(value) => match &mut self.program.values[value.0 as usize].op {
                    Op::Read(variable) => *variable = *renamed.variables.get(variable).unwrap_or(variable),
                    Op::ReadElement(array, _) => *array = *renamed.arrays.get(array).unwrap_or(array),
                    _ => {}
                },
                Statement::Write(variable, _) => *variable = *renamed.variables.get(variable).unwrap_or(variable),
                Statement::WriteElement { array, .. } => *array = *renamed.arrays.get(array).unwrap_or(array),
                _ => {}
            }
            for inner in statement.blocks_mut() {
                self.block(inner, &mut renamed.clone());
            }
        }
    }
}

/// Reads and writes all elements of an array where an index differs between lanes, so that each index is the same in all of them.
/// Returns whether there is one.
pub(crate) fn go_through_arrays(program: &mut Program, shapes: &Shapes) -> bool {
    let before = program.values.len();
    let mut body = std::mem::take(&mut program.body);
    go_through(program, shapes, &mut body);
    program.body = body;
    program.values.len() > before
}

fn go_through(program: &mut Program, shapes: &Shapes, block: &mut Block) {
    let mut through = Through {
        program,
        out: Block::with_capacity(block.len()),
    };
    for mut statement in std::mem::take(block) {
        for inner in statement.blocks_mut() {
            go_through(through.program, shapes, inner);
        }
        match statement {
            Statement::Let(value) => match through.program.op(value) {
                Op::ReadElement(array, index) if !shapes.is_uniform(index) => through.read(value, array, index),
                _ => through.out.push(statement),
            },
            Statement::WriteElement {
                array,
                index,
                value,
                span,
            } if !shapes.is_uniform(index) => through.write(array, index, value, span),
            other => through.out.push(other),
        }
    }
    *block = through.out;
}

/// A block under construction.
struct Through<'a> {
    program: &'a mut Program,
    out: Block,
}

impl Through<'_> {
    fn value(&mut self, op: Op, ty: Ty) -> Value {
        let value = self.program.add(op, ty);
        self.out.push(Statement::Let(value));
        value
    }

    fn element(&mut self, array: Array, number: Value) -> Value {
        self.value(Op::ReadElement(array, number), self.program.arrays[array.0 as usize].ty)
    }

    /// The numbers of an array's elements, and for each whether an index means it: beyond the last, the last one.
    fn numbers(&mut self, array: Array, index: Value) -> Vec<(Value, Value)> {
        let count = self.program.arrays[array.0 as usize].init.len() as u32;
        let numbered = |number: u32| {
            let is_last = number + 1 == count;
            let compare = if is_last { Binary::GreaterEqual } else { Binary::Equal };
            let number = self.program.add(Op::Constant(number), Ty::U32);
            (number, self.value(Op::Binary(compare, index, number), Ty::Bool))
        };
        (0..count).map(numbered).collect()
    }

    /// The value keeps its number, which others use.
    fn read(&mut self, value: Value, array: Array, index: Value) {
        let numbers = self.numbers(array, index);
        let mut chosen = Op::ReadElement(array, numbers[0].0);
        for (number, condition) in &numbers[1..] {
            let reject = self.value(chosen, self.program.ty(value));
            let accept = self.element(array, *number);
            chosen = Op::Select {
                condition: *condition,
                accept,
                reject,
            };
        }
        self.program.values[value.0 as usize].op = chosen;
        self.out.push(Statement::Let(value));
    }

    fn write(&mut self, array: Array, index: Value, value: Value, span: naga::Span) {
        for (number, condition) in self.numbers(array, index) {
            let reject = self.element(array, number);
            let select = Op::Select {
                condition,
                accept: value,
                reject,
            };
            let value = self.value(select, self.program.ty(value));
            self.out.push(Statement::WriteElement {
                array,
                index: number,
                value,
                span,
            });
        }
    }
}

/// A variable or array that a statement declares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Local {
    Variable(Variable),
    Array(Array),
}

/// Moves each declaration to just before its first use, in the innermost block with all uses. It only moves into a loop if
/// the variable is written there before it is read, since each turn would initialise it again.
pub(crate) fn sink_declarations(program: &mut Program) {
    let mut declared = Vec::new();
    visit(&program.body, &mut |statement| match statement {
        Statement::Declare(variable) => declared.push(Local::Variable(*variable)),
        Statement::DeclareArray(array) => declared.push(Local::Array(*array)),
        _ => {}
    });
    let mut body = std::mem::take(&mut program.body);
    for local in declared {
        sink(program, &mut body, local);
    }
    program.body = body;
}

fn declaration(local: Local) -> Statement {
    match local {
        Local::Variable(variable) => Statement::Declare(variable),
        Local::Array(array) => Statement::DeclareArray(array),
    }
}

fn declares(statement: &Statement, local: Local) -> bool {
    match (statement, local) {
        (Statement::Declare(a), Local::Variable(b)) => *a == b,
        (Statement::DeclareArray(a), Local::Array(b)) => *a == b,
        _ => false,
    }
}

/// Finds the block that declares a variable and moves the declaration within it.
fn sink(program: &Program, block: &mut Block, local: Local) -> bool {
    if let Some(at) = block.iter().position(|statement| declares(statement, local)) {
        block.remove(at);
        place(program, block, local);
        return true;
    }
    block
        .iter_mut()
        .any(|statement| statement.blocks_mut().any(|inner| sink(program, inner, local)))
}

/// Puts a declaration into the innermost block possible, just before the first use.
fn place(program: &Program, block: &mut Block, local: Local) {
    if !try_place(program, block, local, false) {
        block.insert(0, declaration(local));
    }
}

fn try_place(program: &Program, block: &mut Block, local: Local, in_loop: bool) -> bool {
    let users: Vec<_> = (0..block.len())
        .filter(|at| mentions(program, &block[*at], local))
        .collect();
    let Some(&first) = users.first() else { return false };
    if users.len() == 1 {
        let enters_loop = matches!(block[first], Statement::Loop { .. });
        let mut inside = block[first]
            .blocks_mut()
            .filter(|inner| inner.iter().any(|s| mentions(program, s, local)));
        if let (Some(inner), None) = (inside.next(), inside.next())
            && try_place(program, inner, local, in_loop || enters_loop)
        {
            return true;
        }
    }
    let overwrites = matches!((&block[first], local), (Statement::Write(v, _), Local::Variable(other)) if *v == other);
    if in_loop && !overwrites {
        return false;
    }
    block.insert(first, declaration(local));
    true
}

/// Returns whether a statement, or one within it, uses a variable.
fn mentions(program: &Program, statement: &Statement, local: Local) -> bool {
    let mentions_it = match (statement, local) {
        (Statement::Write(v, _), Local::Variable(other)) => *v == other,
        (Statement::WriteElement { array, .. }, Local::Array(other)) => *array == other,
        (Statement::Let(value), Local::Variable(other)) => program.op(*value) == Op::Read(other),
        (Statement::Let(value), Local::Array(other)) => {
            matches!(program.op(*value), Op::ReadElement(array, _) if array == other)
        }
        _ => false,
    };
    mentions_it
        || statement
            .blocks()
            .flatten()
            .any(|inner| mentions(program, inner, local))
}

/// Puts each value that is set in a block with exits, and used after it, into a variable.
pub(crate) fn carry_values_out(program: &mut Program) {
    let mut exits = BTreeSet::new();
    visit(&program.body, &mut |statement| {
        if let Statement::Exit(label) = statement {
            exits.insert(*label);
        }
    });
    let mut body = std::mem::take(&mut program.body);
    carry(program, &mut body, &exits);
    program.body = body;
}

fn carry(program: &mut Program, block: &mut Block, exits: &BTreeSet<Label>) {
    let mut at = 0;
    while at < block.len() {
        for inner in block[at].blocks_mut() {
            carry(program, inner, exits);
        }
        let leaving = matches!(&block[at], Statement::Labeled { label, .. } if exits.contains(label));
        if leaving {
            let mut set = BTreeSet::new();
            visit(&block[at..=at], &mut |statement| {
                set.extend(statement.results().iter().copied());
            });
            let mut needed = BTreeSet::new();
            visit(&block[at + 1..], &mut |statement| {
                needed.extend(
                    statement
                        .operands(program)
                        .into_iter()
                        .filter(|value| set.contains(value)),
                );
            });
            for value in needed {
                let ty = program.ty(value);
                let name = program.values[value.0 as usize]
                    .name
                    .clone()
                    .unwrap_or_else(|| "carried".into());
                program.variables.push(crate::tree::VariableInfo { ty, init: 0, name });
                let variable = Variable(program.variables.len() as u32 - 1);
                let read = program.add(Op::Read(variable), ty);
                for inner in block[at].blocks_mut() {
                    write_after(inner, value, variable);
                }
                for later in &mut block[at + 1..] {
                    substitute(program, later, &BTreeMap::from([(value, read)]));
                }
                block.insert(at + 1, Statement::Let(read));
                block.insert(at, Statement::Declare(variable));
                at += 1;
            }
        }
        at += 1;
    }
}

fn write_after(block: &mut Block, value: Value, variable: Variable) {
    if let Some(at) = block.iter().position(|statement| statement.results().contains(&value)) {
        block.insert(at + 1, Statement::Write(variable, value));
        return;
    }
    for statement in block {
        for inner in statement.blocks_mut() {
            write_after(inner, value, variable);
        }
    }
}

/// Replaces values in a statement and in those of its blocks.
fn substitute(program: &mut Program, statement: &mut Statement, with: &BTreeMap<Value, Value>) {
    rename(program, statement, &|value| with.get(&value).copied().unwrap_or(value));
    for block in statement.blocks_mut() {
        for inner in block {
            substitute(program, inner, with);
        }
    }
}

/// Replaces the values that a statement uses, without those that only its blocks use.
pub fn rename(program: &mut Program, statement: &mut Statement, with: &impl Fn(Value) -> Value) {
    let new = |value: &mut Value| *value = with(*value);
    match statement {
        Statement::Let(value) => match &mut program.values[value.0 as usize].op {
            Op::Unary(_, a) | Op::Convert(a) | Op::Bitcast(a) | Op::ReadElement(_, a) => new(a),
            Op::Binary(_, a, b) => {
                new(a);
                new(b);
            }
            Op::Select {
                condition,
                accept,
                reject,
            } => {
                new(condition);
                new(accept);
                new(reject);
            }
            Op::Constant(_) | Op::Lane | Op::Workgroup | Op::Read(_) | Op::Loaded => {}
        },
        Statement::Load { address, .. } => {
            if let Some(element) = &mut address.element {
                new(element);
            }
        }
        Statement::Write(_, value) => new(value),
        Statement::WriteElement { index, value, .. } => {
            new(index);
            new(value);
        }
        Statement::Store { address, value, .. } => {
            if let Some(element) = &mut address.element {
                new(element);
            }
            new(value);
        }
        Statement::If { condition, .. } => new(condition),
        _ => {}
    }
}

/// Replaces each branch whose condition is a constant by its only possible side.
pub(crate) fn take_constant_branches(program: &mut Program) {
    fn take(program: &Program, block: &mut Block) {
        for statement in std::mem::take(block) {
            match statement {
                Statement::If {
                    condition,
                    accept,
                    reject,
                } if let Op::Constant(bits) = program.op(condition) => {
                    let mut taken = if bits == 0 { reject } else { accept };
                    take(program, &mut taken);
                    block.append(&mut taken);
                }
                mut other => {
                    for inner in other.blocks_mut() {
                        take(program, inner);
                    }
                    block.push(other);
                }
            }
        }
    }
    let mut body = std::mem::take(&mut program.body);
    take(program, &mut body);
    program.body = body;
}

/// Most statements in a branch that becomes a selection.
const SHORT: usize = 12;

/// Turns short varying branches that only compute and assign into selections. naga makes such branches of `&&` and `||`.
pub(crate) fn select_short_branches(program: &mut Program, shapes: &Shapes) {
    let mut body = std::mem::take(&mut program.body);
    convert(program, shapes, &mut body);
    program.body = body;
}

fn convert(program: &mut Program, shapes: &Shapes, block: &mut Block) {
    let mut out = Vec::with_capacity(block.len());
    for mut statement in std::mem::take(block) {
        for inner in statement.blocks_mut() {
            convert(program, shapes, inner);
        }
        match statement {
            Statement::If {
                condition,
                accept,
                reject,
            } if !shapes.is_uniform(condition) && is_short(program, &accept) && is_short(program, &reject) => {
                let mut assigned: BTreeMap<Variable, [Option<Value>; 2]> = BTreeMap::new();
                for (side, branch) in [accept, reject].into_iter().enumerate() {
                    for statement in branch {
                        match statement {
                            Statement::Write(variable, value) => {
                                assigned.entry(variable).or_default()[side] = Some(value);
                            }
                            other => out.push(other),
                        }
                    }
                }
                for (variable, sides) in assigned {
                    let ty = program.variables[variable.0 as usize].ty;
                    let old = program.add(Op::Read(variable), ty);
                    out.push(Statement::Let(old));
                    let [accept, reject] = sides.map(|side| side.unwrap_or(old));
                    let chosen = program.add(
                        Op::Select {
                            condition,
                            accept,
                            reject,
                        },
                        ty,
                    );
                    out.push(Statement::Let(chosen));
                    out.push(Statement::Write(variable, chosen));
                }
            }
            other => out.push(other),
        }
    }
    *block = out;
}

/// Returns whether a branch consists of few cheap operations and assignments, and reads no variable that it has assigned.
fn is_short(program: &Program, block: &Block) -> bool {
    let mut written = BTreeSet::new();
    block.len() <= SHORT
        && block.iter().all(|statement| match statement {
            Statement::Write(variable, _) => {
                written.insert(*variable);
                true
            }
            Statement::Let(value) => match program.op(*value) {
                Op::Read(variable) => !written.contains(&variable),
                Op::Binary(op, ..) => !matches!(op, Binary::Divide | Binary::Remainder),
                // The branch may be what keeps a number or index in range.
                Op::Convert(_) | Op::ReadElement(..) | Op::Loaded => false,
                _ => true,
            },
            _ => false,
        })
}
