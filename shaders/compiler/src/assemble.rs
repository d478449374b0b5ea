//! Turns a program back into a module of naga, from which SPIR-V is written. The module has the buffers and types of the one that the
//! program was lowered from.

use std::collections::{BTreeMap, BTreeSet};

use naga::{
    AddressSpace, ArraySize, BinaryOperator, Binding, BuiltIn, EntryPoint, Expression, Function, FunctionArgument,
    Handle, Literal, LocalVariable, MathFunction, Module, Scalar, ScalarKind, ShaderStage, Span, Type, TypeInner,
    UnaryOperator, VectorSize,
};

use crate::tidy::carry_values_out;
use crate::tree::{Address, Array, Binary, Block, Label, Op, Program, Statement, Ty, Unary, Value, Variable, visit};

/// Makes the module of a program that was lowered from `original`.
///
/// # Errors
/// A word of a buffer that has no type there.
pub(crate) fn module(program: &Program, original: &Module) -> Result<Module, String> {
    let mut program = program.clone();
    carry_values_out(&mut program);
    let mut body = std::mem::take(&mut program.body);
    dissolve_all(&mut body);
    let entry = &original.entry_points[0];
    let mut module = Module {
        types: original.types.clone(),
        constants: original.constants.clone(),
        global_variables: original.global_variables.clone(),
        global_expressions: original.global_expressions.clone(),
        ..Module::default()
    };
    let name = entry.name.clone();
    let mut assembling = Assembling::new(&program, &mut module);
    let mut out = assembling.prologue();
    assembling.block(&body, &mut out)?;
    let mut function = assembling.function;
    function.body = out;
    module.entry_points.push(EntryPoint {
        name,
        stage: ShaderStage::Compute,
        early_depth_test: None,
        workgroup_size: entry.workgroup_size,
        workgroup_size_overrides: None,
        function,
        mesh_info: None,
        task_payload: None,
        incoming_ray_payload: None,
    });
    Ok(module)
}

/// Turns blocks with exits into branches, where that needs no copies. The others become loops of one turn.
pub(crate) fn dissolve_all(block: &mut Block) {
    for mut statement in std::mem::take(block) {
        statement.blocks_mut().for_each(dissolve_all);
        match statement {
            Statement::Labeled { label, body, function } => match dissolved(body.clone(), label) {
                Some(mut plain) => block.append(&mut plain),
                None => block.push(Statement::Labeled { label, body, function }),
            },
            other => block.push(other),
        }
    }
}

/// A block without its exits to a label: what a branch with an exit skips becomes the other side of that branch. None if an exit lies
/// in a loop, or what it skips would be needed twice.
fn dissolved(block: Block, label: Label) -> Option<Block> {
    let mut out = Vec::new();
    let mut statements = block.into_iter();
    while let Some(statement) = statements.next() {
        match statement {
            Statement::Exit(left) if left == label => return Some(out),
            Statement::If {
                condition,
                mut accept,
                mut reject,
            } if leaves(&accept, label) || leaves(&reject, label) => {
                let rest: Block = statements.collect();
                match (always_leaves(&accept), always_leaves(&reject)) {
                    (true, true) => {}
                    (true, false) => reject.extend(rest),
                    (false, true) => accept.extend(rest),
                    (false, false) if rest.is_empty() => {}
                    (false, false) => return None,
                }
                out.push(Statement::If {
                    condition,
                    accept: dissolved(accept, label)?,
                    reject: dissolved(reject, label)?,
                });
                return Some(out);
            }
            other if leaves(std::slice::from_ref(&other), label) => return None,
            other => out.push(other),
        }
    }
    Some(out)
}

/// Whether a block has an exit to a label.
pub(crate) fn leaves(block: &[Statement], label: Label) -> bool {
    let mut found = false;
    visit(block, &mut |statement| {
        found |= matches!(statement, Statement::Exit(left) if *left == label);
    });
    found
}

/// Whether the end of a block is never reached.
fn always_leaves(block: &[Statement]) -> bool {
    block.last().is_some_and(|last| match last {
        Statement::Exit(_) => true,
        Statement::If { accept, reject, .. } => always_leaves(accept) && always_leaves(reject),
        _ => false,
    })
}

/// A loop of the module.
struct Scope {
    label: Label,
    /// Set by an exit that also leaves loops within it.
    flag: Option<Handle<Expression>>,
}

struct Assembling<'a> {
    program: &'a Program,
    module: &'a mut Module,
    function: Function,
    values: Vec<Option<Handle<Expression>>>,
    literals: BTreeMap<(u8, u32), Handle<Expression>>,
    variables: BTreeMap<Variable, Handle<Expression>>,
    arrays: BTreeMap<Array, Handle<Expression>>,
    buffers: BTreeMap<u32, (Handle<Expression>, Handle<Type>)>,
    lane: Handle<Expression>,
    workgroup: Handle<Expression>,
    /// Loops around the statement at hand, the outermost first.
    scopes: Vec<Scope>,
}

impl<'a> Assembling<'a> {
    fn new(program: &'a Program, module: &'a mut Module) -> Self {
        let mut function = Function::default();
        let word = module.types.insert(scalar(Ty::U32), Span::UNDEFINED);
        let three = TypeInner::Vector {
            size: VectorSize::Tri,
            scalar: Scalar::U32,
        };
        let three = module.types.insert(
            Type {
                name: None,
                inner: three,
            },
            Span::UNDEFINED,
        );
        let inputs = [(three, BuiltIn::WorkGroupId), (word, BuiltIn::LocalInvocationIndex)];
        let [workgroup, lane] = inputs.map(|(ty, builtin)| {
            function.arguments.push(FunctionArgument {
                name: None,
                ty,
                binding: Some(Binding::BuiltIn(builtin)),
            });
            let index = function.arguments.len() as u32 - 1;
            let argument = Expression::FunctionArgument(index);
            function.expressions.append(argument, Span::UNDEFINED)
        });
        let mut writer = Self {
            program,
            module,
            function,
            values: vec![None; program.values.len()],
            literals: BTreeMap::new(),
            variables: BTreeMap::new(),
            arrays: BTreeMap::new(),
            buffers: BTreeMap::new(),
            lane,
            workgroup,
            scopes: Vec::new(),
        };
        let globals: Vec<_> = writer
            .module
            .global_variables
            .iter()
            .filter(|(_, global)| global.space != AddressSpace::Private)
            .filter_map(|(handle, global)| Some((handle, global.ty, global.binding?.binding)))
            .collect();
        for (handle, ty, binding) in globals {
            let pointer = writer.append(Expression::GlobalVariable(handle));
            writer.buffers.insert(binding, (pointer, ty));
        }
        writer
    }

    fn append(&mut self, expression: Expression) -> Handle<Expression> {
        self.function.expressions.append(expression, Span::UNDEFINED)
    }

    /// Adds an expression that is computed here.
    fn emit(&mut self, expression: Expression, out: &mut naga::Block) -> Handle<Expression> {
        let handle = self.append(expression);
        out.push(
            naga::Statement::Emit(naga::Range::new_from_bounds(handle, handle)),
            Span::UNDEFINED,
        );
        handle
    }

    /// The first statements: what is computed once.
    fn prologue(&mut self) -> naga::Block {
        let mut out = naga::Block::new();
        let (base, index) = (self.workgroup, 0);
        self.workgroup = self.emit(Expression::AccessIndex { base, index }, &mut out);
        out
    }

    fn literal(&mut self, ty: Ty, bits: u32) -> Handle<Expression> {
        if let Some(handle) = self.literals.get(&(ty as u8, bits)) {
            return *handle;
        }
        let literal = match ty {
            Ty::F32 => Literal::F32(f32::from_bits(bits)),
            Ty::I32 => Literal::I32(bits as i32),
            Ty::U32 => Literal::U32(bits),
            Ty::Bool => Literal::Bool(bits != 0),
        };
        let handle = self.append(Expression::Literal(literal));
        self.literals.insert((ty as u8, bits), handle);
        handle
    }

    fn value(&mut self, value: Value) -> Handle<Expression> {
        match self.program.op(value) {
            Op::Constant(bits) => self.literal(self.program.ty(value), bits),
            Op::Lane => self.lane,
            Op::Workgroup => self.workgroup,
            _ => self.values[value.0 as usize].expect("a value is computed before it is used"),
        }
    }

    fn local(&mut self, name: &str, inner: TypeInner) -> Handle<Expression> {
        let ty = self.module.types.insert(Type { name: None, inner }, Span::UNDEFINED);
        let local = LocalVariable {
            name: Some(name.to_owned()),
            ty,
            init: None,
        };
        let local = self.function.local_variables.append(local, Span::UNDEFINED);
        self.append(Expression::LocalVariable(local))
    }

    fn variable(&mut self, variable: Variable) -> Handle<Expression> {
        if let Some(pointer) = self.variables.get(&variable) {
            return *pointer;
        }
        let info = &self.program.variables[variable.0 as usize];
        let pointer = self.local(&info.name, scalar(info.ty).inner);
        self.variables.insert(variable, pointer);
        pointer
    }

    fn array(&mut self, array: Array) -> Handle<Expression> {
        if let Some(pointer) = self.arrays.get(&array) {
            return *pointer;
        }
        let info = &self.program.arrays[array.0 as usize];
        let base = self.module.types.insert(scalar(info.ty), Span::UNDEFINED);
        let count = std::num::NonZeroU32::new(info.init.len() as u32).unwrap_or(std::num::NonZeroU32::MIN);
        let inner = TypeInner::Array {
            base,
            size: ArraySize::Constant(count),
            stride: 4,
        };
        let pointer = self.local(&info.name, inner);
        self.arrays.insert(array, pointer);
        pointer
    }

    /// The place of an element of an array; beyond the last, the last one.
    fn element(&mut self, array: Array, index: Value, out: &mut naga::Block) -> Handle<Expression> {
        let base = self.array(array);
        let last = self.program.arrays[array.0 as usize].init.len() as u32 - 1;
        self.at(base, index, last, out)
    }

    fn at(&mut self, base: Handle<Expression>, index: Value, last: u32, out: &mut naga::Block) -> Handle<Expression> {
        let access = match self.program.op(index) {
            Op::Constant(index) => Expression::AccessIndex {
                base,
                index: index.min(last),
            },
            _ => Expression::Access {
                base,
                index: self.value(index),
            },
        };
        self.emit(access, out)
    }

    /// The place of a word, or with `four` of a vector, in a buffer.
    fn place(&mut self, address: &Address, four: bool, out: &mut naga::Block) -> Result<Handle<Expression>, String> {
        let (mut place, mut ty) = self.buffers[&address.buffer];
        let mut word = address.offset;
        if let (TypeInner::Array { base, .. }, Some(element)) = (&self.module.types[ty].inner, address.element) {
            ty = *base;
            place = self.at(place, element, u32::MAX, out);
        }
        loop {
            let (index, inner) = match &self.module.types[ty].inner {
                TypeInner::Scalar(_) => return Ok(place),
                TypeInner::Vector { .. } if four && word == 0 => return Ok(place),
                TypeInner::Vector { .. } => {
                    return Ok(self.emit(
                        Expression::AccessIndex {
                            base: place,
                            index: word,
                        },
                        out,
                    ));
                }
                TypeInner::Struct { members, .. } => {
                    let at = members.iter().rposition(|member| member.offset / 4 <= word);
                    let at = at.ok_or("a struct has no member there")?;
                    word -= members[at].offset / 4;
                    (at as u32, members[at].ty)
                }
                TypeInner::Array { base, stride, .. } => {
                    let (index, base) = (word / (stride / 4), *base);
                    word %= stride / 4;
                    (index, base)
                }
                other => return Err(format!("a buffer has a {other:?}")),
            };
            place = self.emit(Expression::AccessIndex { base: place, index }, out);
            ty = inner;
        }
    }

    fn block(&mut self, block: &Block, out: &mut naga::Block) -> Result<(), String> {
        block.iter().try_for_each(|statement| self.statement(statement, out))
    }

    fn store(out: &mut naga::Block, pointer: Handle<Expression>, value: Handle<Expression>) {
        out.push(naga::Statement::Store { pointer, value }, Span::UNDEFINED);
    }

    fn statement(&mut self, statement: &Statement, out: &mut naga::Block) -> Result<(), String> {
        match statement {
            Statement::Let(value) => self.compute(*value, out),
            Statement::Load { targets, address } => {
                let pointer = self.place(address, targets.len() == 4, out)?;
                let base = self.emit(Expression::Load { pointer }, out);
                match targets.as_slice() {
                    [one] => self.values[one.0 as usize] = Some(base),
                    _ => {
                        for (index, target) in (0..).zip(targets) {
                            let one = self.emit(Expression::AccessIndex { base, index }, out);
                            self.values[target.0 as usize] = Some(one);
                        }
                    }
                }
            }
            Statement::Declare(variable) => {
                let info = &self.program.variables[variable.0 as usize];
                let (init, pointer) = (self.literal(info.ty, info.init), self.variable(*variable));
                Self::store(out, pointer, init);
            }
            Statement::DeclareArray(array) => {
                let info = &self.program.arrays[array.0 as usize];
                let base = self.array(*array);
                for (index, bits) in (0..).zip(&info.init) {
                    let init = self.literal(info.ty, *bits);
                    let pointer = self.emit(Expression::AccessIndex { base, index }, out);
                    Self::store(out, pointer, init);
                }
            }
            Statement::Write(variable, value) => {
                let (value, pointer) = (self.value(*value), self.variable(*variable));
                Self::store(out, pointer, value);
            }
            Statement::WriteElement {
                array, index, value, ..
            } => {
                let value = self.value(*value);
                let pointer = self.element(*array, *index, out);
                Self::store(out, pointer, value);
            }
            Statement::Store { address, value, .. } => {
                let value = self.value(*value);
                let pointer = self.place(address, false, out)?;
                Self::store(out, pointer, value);
            }
            Statement::If {
                condition,
                accept,
                reject,
            } => {
                let condition = self.value(*condition);
                let (mut accepted, mut rejected) = (naga::Block::new(), naga::Block::new());
                self.block(accept, &mut accepted)?;
                self.block(reject, &mut rejected)?;
                let branch = naga::Statement::If {
                    condition,
                    accept: accepted,
                    reject: rejected,
                };
                out.push(branch, Span::UNDEFINED);
            }
            Statement::Loop { label, body, .. } => self.repeat(*label, body, false, out)?,
            Statement::Labeled { label, body, .. } if leaves(body, *label) => self.repeat(*label, body, true, out)?,
            Statement::Labeled { body, .. } => self.block(body, out)?,
            Statement::Exit(label) => {
                let scope = self.scopes.iter().rposition(|scope| scope.label == *label);
                let at = scope.ok_or("an exit lies outside of its block")?;
                if at + 1 < self.scopes.len()
                    && let Some(flag) = self.scopes[at].flag
                {
                    let set = self.literal(Ty::Bool, 1);
                    Self::store(out, flag, set);
                }
                out.push(naga::Statement::Break, Span::UNDEFINED);
            }
        }
        Ok(())
    }

    /// A loop; with `once`, a block that can be left.
    fn repeat(&mut self, label: Label, block: &Block, once: bool, out: &mut naga::Block) -> Result<(), String> {
        let flag = is_left_from_within(block, label).then(|| self.local("left", TypeInner::Scalar(Scalar::BOOL)));
        if let Some(flag) = flag {
            let not = self.literal(Ty::Bool, 0);
            Self::store(out, flag, not);
        }
        self.scopes.push(Scope { label, flag });
        let mut body = naga::Block::new();
        self.block(block, &mut body)?;
        if once && !always_leaves(block) {
            body.push(naga::Statement::Break, Span::UNDEFINED);
        }
        self.scopes.pop();
        let turns = naga::Statement::Loop {
            body,
            continuing: naga::Block::new(),
            break_if: None,
        };
        out.push(turns, Span::UNDEFINED);
        // Exits that leave more than this loop go on from here.
        let mut outer = BTreeSet::new();
        visit(block, &mut |statement| {
            if let Statement::Exit(left) = statement {
                outer.insert(*left);
            }
        });
        let flags: Vec<_> = self
            .scopes
            .iter()
            .filter(|scope| outer.contains(&scope.label))
            .filter_map(|scope| scope.flag)
            .collect();
        for pointer in flags {
            let condition = self.emit(Expression::Load { pointer }, out);
            let mut accept = naga::Block::new();
            accept.push(naga::Statement::Break, Span::UNDEFINED);
            let branch = naga::Statement::If {
                condition,
                accept,
                reject: naga::Block::new(),
            };
            out.push(branch, Span::UNDEFINED);
        }
        Ok(())
    }

    fn compute(&mut self, value: Value, out: &mut naga::Block) {
        let ty = self.program.ty(value);
        let math = |fun, arg, arg1| Expression::Math {
            fun,
            arg,
            arg1,
            arg2: None,
            arg3: None,
        };
        let expression = match self.program.op(value) {
            Op::Constant(_) | Op::Lane | Op::Workgroup | Op::Loaded => return,
            Op::Unary(op, a) => {
                let expr = self.value(a);
                match op {
                    Unary::Negate => Expression::Unary {
                        op: UnaryOperator::Negate,
                        expr,
                    },
                    Unary::Not if ty == Ty::Bool => Expression::Unary {
                        op: UnaryOperator::LogicalNot,
                        expr,
                    },
                    Unary::Not => Expression::Unary {
                        op: UnaryOperator::BitwiseNot,
                        expr,
                    },
                    Unary::Abs => math(MathFunction::Abs, expr, None),
                    Unary::Floor => math(MathFunction::Floor, expr, None),
                    Unary::Trunc => math(MathFunction::Trunc, expr, None),
                }
            }
            Op::Binary(op, a, b) => {
                let (left, right) = (self.value(a), self.value(b));
                match op {
                    Binary::Min => math(MathFunction::Min, left, Some(right)),
                    Binary::Max => math(MathFunction::Max, left, Some(right)),
                    _ => Expression::Binary {
                        op: operator(op, ty),
                        left,
                        right,
                    },
                }
            }
            Op::Select {
                condition,
                accept,
                reject,
            } => Expression::Select {
                condition: self.value(condition),
                accept: self.value(accept),
                reject: self.value(reject),
            },
            Op::Convert(a) => Expression::As {
                expr: self.value(a),
                kind: kind(ty),
                convert: Some(if ty == Ty::Bool { 1 } else { 4 }),
            },
            Op::Bitcast(a) => Expression::As {
                expr: self.value(a),
                kind: kind(ty),
                convert: None,
            },
            Op::Read(variable) => Expression::Load {
                pointer: self.variable(variable),
            },
            Op::ReadElement(array, index) => Expression::Load {
                pointer: self.element(array, index, out),
            },
        };
        self.values[value.0 as usize] = Some(self.emit(expression, out));
    }
}

/// Whether an exit to a label lies in a loop within the block.
fn is_left_from_within(block: &[Statement], label: Label) -> bool {
    block.iter().any(|statement| match statement {
        Statement::Loop { body, .. } => leaves(body, label),
        Statement::Labeled { label: other, body, .. } if leaves(body, *other) => leaves(body, label),
        other => other.blocks().any(|inner| is_left_from_within(inner, label)),
    })
}

fn scalar(ty: Ty) -> Type {
    let scalar = match ty {
        Ty::F32 => Scalar::F32,
        Ty::I32 => Scalar::I32,
        Ty::U32 => Scalar::U32,
        Ty::Bool => Scalar::BOOL,
    };
    Type {
        name: None,
        inner: TypeInner::Scalar(scalar),
    }
}

fn kind(ty: Ty) -> ScalarKind {
    match ty {
        Ty::F32 => ScalarKind::Float,
        Ty::I32 => ScalarKind::Sint,
        Ty::U32 => ScalarKind::Uint,
        Ty::Bool => ScalarKind::Bool,
    }
}

fn operator(op: Binary, ty: Ty) -> BinaryOperator {
    match op {
        Binary::Add => BinaryOperator::Add,
        Binary::Subtract => BinaryOperator::Subtract,
        Binary::Multiply => BinaryOperator::Multiply,
        Binary::Divide => BinaryOperator::Divide,
        Binary::Remainder => BinaryOperator::Modulo,
        Binary::And if ty == Ty::Bool => BinaryOperator::LogicalAnd,
        Binary::Or if ty == Ty::Bool => BinaryOperator::LogicalOr,
        Binary::And => BinaryOperator::And,
        Binary::Or => BinaryOperator::InclusiveOr,
        Binary::Xor if ty == Ty::Bool => BinaryOperator::NotEqual,
        Binary::Xor => BinaryOperator::ExclusiveOr,
        Binary::ShiftLeft => BinaryOperator::ShiftLeft,
        Binary::ShiftRight => BinaryOperator::ShiftRight,
        Binary::Equal => BinaryOperator::Equal,
        Binary::NotEqual => BinaryOperator::NotEqual,
        Binary::Less => BinaryOperator::Less,
        Binary::LessEqual => BinaryOperator::LessEqual,
        Binary::Greater => BinaryOperator::Greater,
        Binary::GreaterEqual => BinaryOperator::GreaterEqual,
        Binary::Min | Binary::Max => unreachable!("these are functions"),
    }
}
