//! Lowers naga's IR to a [`Program`].

use std::collections::BTreeMap;

use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{
    AddressSpace, BinaryOperator, BuiltIn, Expression, Function, Handle, Literal, MathFunction, Module, ScalarKind,
    Span, SwitchValue, Type, TypeInner, UnaryOperator, VectorSize,
};

use crate::rules::Rule;
use crate::source::{Refusal, Refusals, Source};
use crate::tree::{
    Address, Array, ArrayInfo, Binary, Block, CallInfo, Label, Op, Program, Statement, Ty, Unary, Value, Variable,
    VariableInfo,
};

/// Most values and blocks of a program: functions that call the next one twice would make it grow without end.
const GREATEST_SIZE: usize = 100_000;

/// Lowers the entry point of a module.
///
/// # Errors
/// Constructs that have no form in lane code.
pub(crate) fn lower(source: &Source, module: &Module, info: &ModuleInfo) -> Result<Program, Refusals> {
    let mut lowering = Lowering {
        source,
        module,
        info,
        program: Program::default(),
        globals: BTreeMap::new(),
        blocks: vec![Vec::new()],
        here: Span::UNDEFINED,
        called: None,
    };
    match lowering.entry() {
        Ok(()) => {
            lowering.program.body = lowering.blocks.pop().unwrap_or_default();
            Ok(lowering.program)
        }
        Err(refusal) => Err(vec![refusal]),
    }
}

/// A lowered expression: scalars in order, or a place in memory.
#[derive(Clone, Debug)]
enum Lowered {
    Scalars(Vec<Value>),
    Place(Place),
}

/// Place of a scalar in memory.
#[derive(Clone, Copy, Debug)]
enum Spot {
    Variable(Variable),
    /// An element of a local array, by its number.
    Element(Array, Value),
}

/// Place of a value in memory.
#[derive(Clone, Debug)]
enum Place {
    /// A spot for each scalar.
    Spots(Vec<Spot>),
    /// One of the elements of an array or vector, each with a spot for each scalar, by its number.
    OneOf(Vec<Vec<Spot>>, Value),
    /// A whole local array, with an array for each scalar of its elements.
    Arrays(Vec<Array>),
    /// A whole runtime-sized array.
    Buffer { buffer: u32, stride: u32 },
    /// Part of a buffer.
    InBuffer(Address),
}

type Lower<T> = Result<T, Refusal>;

struct Lowering<'a> {
    source: &'a Source,
    module: &'a Module,
    info: &'a ModuleInfo,
    program: Program,
    globals: BTreeMap<Handle<naga::GlobalVariable>, Place>,
    /// Blocks being written, the innermost last.
    blocks: Vec<Block>,
    /// Place of the latest statement or expression in the WGSL.
    here: Span,
    /// The call that is being lowered.
    called: Option<u32>,
}

/// An inlined call of a function.
struct Call<'a> {
    function: &'a Function,
    info: &'a FunctionInfo,
    arguments: Vec<Lowered>,
    locals: BTreeMap<Handle<naga::LocalVariable>, Place>,
    known: BTreeMap<Handle<Expression>, Lowered>,
    /// Variables for returned scalars, and the label that ends the call, if it returns early.
    early: Option<(Vec<Variable>, Label)>,
    /// Values of a return at the end.
    result: Option<Vec<Value>>,
    /// Labels that `break` and `continue` exit to, the innermost last.
    breaks: Vec<Label>,
    continues: Vec<Label>,
}

impl<'a> Lowering<'a> {
    fn refuse<T>(&self, span: Span, call: &Call<'_>, rule: Rule, message: &str) -> Lower<T> {
        Err(Refusal {
            place: self.source.place_of(if span.is_defined() { span } else { self.here }),
            function: call.function.name.clone(),
            rule,
            message: message.into(),
        })
    }

    fn push(&mut self, statement: Statement) {
        self.blocks
            .last_mut()
            .expect("a block is being written")
            .push(statement);
    }

    fn value(&mut self, op: Op, ty: Ty) -> Value {
        let value = self.program.add(op, ty);
        self.program.values[value.0 as usize].call = self.called;
        if !matches!(op, Op::Constant(_)) {
            self.push(Statement::Let(value));
        }
        value
    }

    fn constant(&mut self, bits: u32, ty: Ty) -> Value {
        self.program.add(Op::Constant(bits), ty)
    }

    fn label(&mut self) -> Label {
        self.program.labels += 1;
        Label(self.program.labels - 1)
    }

    fn variable(&mut self, name: String, ty: Ty, init: u32) -> Variable {
        self.program.variables.push(VariableInfo { ty, init, name });
        let variable = Variable(self.program.variables.len() as u32 - 1);
        self.push(Statement::Declare(variable));
        variable
    }

    /// Lists the scalars of a type in order: the ends of their names, their types, and their words in a buffer.
    fn scalars(&self, ty: Handle<Type>) -> Vec<(String, Ty, u32)> {
        match &self.module.types[ty].inner {
            TypeInner::Scalar(scalar) => vec![(String::new(), scalar_type(*scalar), 0)],
            TypeInner::Vector { size, scalar } => (0..*size as u32)
                .map(|k| (COMPONENTS[k as usize].to_owned(), scalar_type(*scalar), k))
                .collect(),
            TypeInner::Matrix { columns, rows, scalar } => (0..*columns as u32)
                .flat_map(|column| {
                    let row = move |row: u32| {
                        (
                            format!("_{column}{}", COMPONENTS[row as usize]),
                            scalar_type(*scalar),
                            column * words_of_column(*rows) + row,
                        )
                    };
                    (0..*rows as u32).map(row)
                })
                .collect(),
            TypeInner::Struct { members, .. } => {
                let mut all = Vec::new();
                for member in members {
                    let name = member.name.as_deref().unwrap_or_default();
                    for (inner, scalar, word) in self.scalars(member.ty) {
                        all.push((format!("_{name}{inner}"), scalar, member.offset / 4 + word));
                    }
                }
                all
            }
            TypeInner::Array {
                base,
                size: naga::ArraySize::Constant(count),
                stride,
            } => {
                let mut all = Vec::new();
                for index in 0..count.get() {
                    for (inner, scalar, word) in self.scalars(*base) {
                        all.push((format!("_{index}{inner}"), scalar, index * stride / 4 + word));
                    }
                }
                all
            }
            _ => Vec::new(),
        }
    }

    fn entry(&mut self) -> Lower<()> {
        let entry = &self.module.entry_points[0];
        for (handle, global) in self.module.global_variables.iter() {
            let name = global.name.clone().unwrap_or_default();
            let place = match (global.binding, global.space) {
                (Some(binding), _) => {
                    self.program.buffers += 1;
                    match self.module.types[global.ty].inner {
                        TypeInner::Array { stride, .. } => Place::Buffer {
                            buffer: binding.binding,
                            stride: stride / 4,
                        },
                        _ => Place::InBuffer(Address {
                            buffer: binding.binding,
                            element: None,
                            stride: 0,
                            offset: 0,
                        }),
                    }
                }
                (None, AddressSpace::Private) => {
                    let init = global.init.map(|init| self.constant_bits(init));
                    self.local(
                        &name,
                        global.ty,
                        self.module.global_variables.get_span(handle),
                        init.as_deref(),
                    )
                }
                _ => continue,
            };
            self.globals.insert(handle, place);
        }
        let mut arguments = Vec::new();
        for argument in &entry.function.arguments {
            let Some(naga::Binding::BuiltIn(builtin)) = argument.binding else {
                continue;
            };
            let zero = self.constant(0, Ty::U32);
            let scalars = match builtin {
                BuiltIn::LocalInvocationIndex => vec![self.value(Op::Lane, Ty::U32)],
                BuiltIn::LocalInvocationId => vec![self.value(Op::Lane, Ty::U32), zero, zero],
                BuiltIn::WorkGroupId => vec![self.value(Op::Workgroup, Ty::U32), zero, zero],
                _ => {
                    let group = self.value(Op::Workgroup, Ty::U32);
                    let width = self.constant(entry.workgroup_size[0], Ty::U32);
                    let first = self.value(Op::Binary(Binary::Multiply, group, width), Ty::U32);
                    let lane = self.value(Op::Lane, Ty::U32);
                    vec![self.value(Op::Binary(Binary::Add, first, lane), Ty::U32), zero, zero]
                }
            };
            arguments.push(Lowered::Scalars(scalars));
        }
        self.call(&entry.function, self.info.get_entry_point(0), arguments, "main")?;
        Ok(())
    }

    /// Bits of a constant expression's scalars.
    fn constant_bits(&self, expression: Handle<Expression>) -> Vec<u32> {
        match &self.module.global_expressions[expression] {
            Expression::Literal(literal) => vec![literal_bits(*literal)],
            Expression::ZeroValue(ty) => vec![0; self.scalars(*ty).len()],
            Expression::Compose { components, .. } => components
                .iter()
                .flat_map(|component| self.constant_bits(*component))
                .collect(),
            Expression::Splat { size, value } => self.constant_bits(*value).repeat(*size as usize),
            Expression::Constant(constant) => self.constant_bits(self.module.constants[*constant].init),
            _ => Vec::new(),
        }
    }

    /// Declares a local or private variable.
    fn local(&mut self, name: &str, ty: Handle<Type>, span: Span, init: Option<&[u32]>) -> Place {
        let bits = |count: usize| {
            init.filter(|bits| bits.len() == count)
                .map_or_else(|| vec![0; count], <[u32]>::to_vec)
        };
        if let TypeInner::Array {
            base,
            size: naga::ArraySize::Constant(count),
            ..
        } = self.module.types[ty].inner
        {
            let scalars = self.scalars(base);
            let bits = bits(scalars.len() * count.get() as usize);
            let arrays = scalars.iter().enumerate().map(|(k, (inner, scalar, _))| {
                let init = bits.iter().skip(k).step_by(scalars.len()).copied().collect();
                self.program.arrays.push(ArrayInfo {
                    ty: *scalar,
                    init,
                    name: format!("{name}{inner}"),
                    span,
                });
                let array = Array(self.program.arrays.len() as u32 - 1);
                self.push(Statement::DeclareArray(array));
                array
            });
            return Place::Arrays(arrays.collect());
        }
        let scalars = self.scalars(ty);
        let bits = bits(scalars.len());
        let variables = scalars
            .into_iter()
            .zip(bits)
            .map(|((inner, scalar, _), init)| self.variable(format!("{name}{inner}"), scalar, init));
        Place::Spots(variables.map(Spot::Variable).collect())
    }

    /// Inlines a call. Returns the scalars that the function returns.
    fn call(
        &mut self,
        function: &'a Function,
        info: &'a FunctionInfo,
        arguments: Vec<Lowered>,
        name: &str,
    ) -> Lower<Vec<Value>> {
        let mut call = Call {
            function,
            info,
            arguments,
            locals: BTreeMap::new(),
            known: BTreeMap::new(),
            early: None,
            result: None,
            breaks: Vec::new(),
            continues: Vec::new(),
        };
        let label = self.label();
        if returns_early(&function.body, true) {
            let scalars = function
                .result
                .as_ref()
                .map(|result| self.scalars(result.ty))
                .unwrap_or_default();
            let variables = scalars
                .into_iter()
                .map(|(inner, ty, _)| self.variable(format!("{name}_result{inner}"), ty, 0))
                .collect();
            call.early = Some((variables, label));
        }
        self.blocks.push(Vec::new());
        for (handle, local) in function.local_variables.iter() {
            let init = local.init.map(|init| self.local_bits(&call, init)).transpose()?;
            let span = function.local_variables.get_span(handle);
            let place = self.local(
                local.name.as_deref().unwrap_or("temporary"),
                local.ty,
                span,
                init.as_deref(),
            );
            call.locals.insert(handle, place);
        }
        self.block(&mut call, &function.body)?;
        let body = self.blocks.pop().expect("pushed above");
        // A separate block, so that its variables are initialised at each call.
        self.push(Statement::Labeled {
            label,
            body,
            function: Some(name.to_owned()),
        });
        if let Some((variables, _)) = call.early.take() {
            let read = |v: Variable| (Op::Read(v), self.program.variables[v.0 as usize].ty);
            let reads: Vec<_> = variables.into_iter().map(read).collect();
            return Ok(reads.into_iter().map(|(op, ty)| self.value(op, ty)).collect());
        }
        Ok(call.result.unwrap_or_default())
    }

    /// Bits of a local variable's constant initial value.
    fn local_bits(&self, call: &Call<'_>, expression: Handle<Expression>) -> Lower<Vec<u32>> {
        Ok(match &call.function.expressions[expression] {
            Expression::Literal(literal) => vec![literal_bits(*literal)],
            Expression::ZeroValue(ty) => vec![0; self.scalars(*ty).len()],
            Expression::Constant(constant) => self.constant_bits(self.module.constants[*constant].init),
            Expression::Splat { size, value } => self.local_bits(call, *value)?.repeat(*size as usize),
            Expression::Compose { components, .. } => {
                let mut bits = Vec::new();
                for component in components {
                    bits.extend(self.local_bits(call, *component)?);
                }
                bits
            }
            _ => {
                let span = call.function.expressions.get_span(expression);
                return self.refuse(
                    span,
                    call,
                    Rule::Internal,
                    "this initial value is not supported; assign it after the declaration",
                );
            }
        })
    }

    fn block(&mut self, call: &mut Call<'a>, block: &'a naga::Block) -> Lower<()> {
        for (statement, span) in block.span_iter() {
            self.statement(call, statement, *span)?;
        }
        Ok(())
    }

    fn inner_block(&mut self, call: &mut Call<'a>, block: &'a naga::Block) -> Lower<Block> {
        self.blocks.push(Vec::new());
        self.block(call, block)?;
        Ok(self.blocks.pop().expect("pushed above"))
    }

    fn statement(&mut self, call: &mut Call<'a>, statement: &'a naga::Statement, span: Span) -> Lower<()> {
        use naga::Statement as S;
        if span.is_defined() && !matches!(statement, S::Emit(_)) {
            self.here = span;
        }
        if self.program.values.len() + self.program.labels as usize > GREATEST_SIZE {
            let problem = format!(
                "the kernel is too large with all its calls inlined; allowed: {GREATEST_SIZE} values and calls, about \
                 ten times the largest shipped kernel"
            );
            return self.refuse(span, call, Rule::LargeKernel, &problem);
        }
        match statement {
            S::Emit(range) => {
                for handle in range.clone() {
                    let lowered = self.expression(call, handle)?;
                    if let (Lowered::Scalars(scalars), Some(name)) =
                        (&lowered, call.function.named_expressions.get(&handle))
                    {
                        for scalar in scalars {
                            self.program.values[scalar.0 as usize]
                                .name
                                .get_or_insert_with(|| name.clone());
                        }
                    }
                    call.known.insert(handle, lowered);
                }
            }
            S::Block(inner) => self.block(call, inner)?,
            S::If {
                condition,
                accept,
                reject,
            } => {
                let condition = self.scalar(call, *condition)?;
                let accept = self.inner_block(call, accept)?;
                let reject = self.inner_block(call, reject)?;
                self.push(Statement::If {
                    condition,
                    accept,
                    reject,
                });
            }
            S::Switch { selector, cases } => self.switch(call, *selector, cases)?,
            S::Loop {
                body,
                continuing,
                break_if,
            } => {
                let (label, next) = (self.label(), self.label());
                call.breaks.push(label);
                call.continues.push(next);
                let body = self.inner_block(call, body)?;
                self.blocks.push(vec![Statement::Labeled {
                    label: next,
                    body,
                    function: None,
                }]);
                self.block(call, continuing)?;
                if let Some(condition) = break_if {
                    let condition = self.scalar(call, *condition)?;
                    let accept = vec![Statement::Exit(label)];
                    self.push(Statement::If {
                        condition,
                        accept,
                        reject: Vec::new(),
                    });
                }
                let body = self.blocks.pop().expect("pushed above");
                call.breaks.pop();
                call.continues.pop();
                self.push(Statement::Loop { label, body, span });
            }
            S::Break => {
                let label = *call
                    .breaks
                    .last()
                    .expect("naga lets `break` stand in loops and switches only");
                self.push(Statement::Exit(label));
            }
            S::Continue => {
                let label = *call.continues.last().expect("naga lets `continue` stand in loops only");
                self.push(Statement::Exit(label));
            }
            S::Return { value } => {
                let values = value
                    .map(|value| self.all_scalars(call, value))
                    .transpose()?
                    .unwrap_or_default();
                if let Some((variables, label)) = call.early.clone() {
                    for (variable, value) in variables.into_iter().zip(values) {
                        self.push(Statement::Write(variable, value));
                    }
                    self.push(Statement::Exit(label));
                } else {
                    call.result = Some(values);
                }
            }
            S::Store { pointer, value } => {
                let place = self.place(call, *pointer)?;
                if let Place::Arrays(arrays) = place {
                    let values = self.all_scalars(call, *value)?;
                    for (at, value) in values.iter().enumerate() {
                        let index = self.constant((at / arrays.len()) as u32, Ty::U32);
                        self.write(Spot::Element(arrays[at % arrays.len()], index), *value, span);
                    }
                    return Ok(());
                }
                let values = self.all_scalars(call, *value)?;
                if let Place::OneOf(elements, index) = &place {
                    for (number, spots) in elements.iter().enumerate() {
                        for (spot, value) in spots.iter().zip(&values) {
                            let old = self.read(*spot, span);
                            let new = self.chosen(*index, [number, elements.len()], *value, old);
                            self.write(*spot, new, span);
                        }
                    }
                    return Ok(());
                }
                let words = self.words_behind(call, *pointer);
                for (k, value) in values.into_iter().enumerate() {
                    match &place {
                        Place::Spots(spots) => self.write(spots[k], value, span),
                        Place::InBuffer(address) => {
                            let address = Address {
                                offset: address.offset + words[k],
                                ..*address
                            };
                            self.push(Statement::Store { address, value, span });
                        }
                        _ => return self.refuse(span, call, Rule::Internal, "a whole buffer can't be stored"),
                    }
                }
            }
            S::Call {
                function,
                arguments,
                result,
            } => {
                let callee = &self.module.functions[*function];
                let mut lowered = Vec::new();
                for argument in arguments {
                    lowered.push(self.lowered(call, *argument)?);
                }
                let name = callee.name.as_deref().unwrap_or("function");
                let within = self.called;
                self.program.calls.push(CallInfo { span, within });
                self.called = Some(self.program.calls.len() as u32 - 1);
                let values = self.call(callee, &self.info[*function], lowered, name)?;
                self.called = within;
                if let Some(result) = result {
                    call.known.insert(*result, Lowered::Scalars(values));
                }
            }
            _ => return self.refuse(span, call, Rule::Internal, "this statement has no lane code"),
        }
        Ok(())
    }

    /// Lowers a switch to a chain of comparisons in a block that `break` leaves.
    fn switch(
        &mut self,
        call: &mut Call<'a>,
        selector: Handle<Expression>,
        cases: &'a [naga::SwitchCase],
    ) -> Lower<()> {
        let selector = self.scalar(call, selector)?;
        let ty = self.program.ty(selector);
        let label = self.label();
        call.breaks.push(label);
        let mut chain = Vec::new();
        let mut default = Vec::new();
        let mut tests = Vec::new();
        let mut is_default = false;
        for case in cases {
            match case.value {
                SwitchValue::I32(value) => tests.push(value as u32),
                SwitchValue::U32(value) => tests.push(value),
                SwitchValue::Default => is_default = true,
            }
            if case.fall_through {
                continue;
            }
            let mut body = self.inner_block(call, &case.body)?;
            if matches!(body.last(), Some(Statement::Exit(last)) if *last == label) {
                body.pop();
            }
            if is_default {
                default = body;
            } else {
                chain.push((std::mem::take(&mut tests), body));
            }
            tests.clear();
            is_default = false;
        }
        call.breaks.pop();
        let mut rest = default;
        for (tests, body) in chain.into_iter().rev() {
            self.blocks.push(Vec::new());
            let mut condition = None;
            for test in tests {
                let test = self.constant(test, ty);
                let equal = self.value(Op::Binary(Binary::Equal, selector, test), Ty::Bool);
                condition = Some(match condition {
                    None => equal,
                    Some(other) => self.value(Op::Binary(Binary::Or, other, equal), Ty::Bool),
                });
            }
            if let Some(condition) = condition {
                self.push(Statement::If {
                    condition,
                    accept: body,
                    reject: rest,
                });
            }
            rest = self.blocks.pop().expect("pushed above");
        }
        self.push(Statement::Labeled {
            label,
            body: rest,
            function: None,
        });
        Ok(())
    }

    fn lowered(&mut self, call: &mut Call<'a>, handle: Handle<Expression>) -> Lower<Lowered> {
        if let Some(known) = call.known.get(&handle) {
            return Ok(known.clone());
        }
        // Constants, arguments and references to variables are in no Emit.
        let lowered = self.expression(call, handle)?;
        if !matches!(call.function.expressions[handle], Expression::Literal(_)) {
            call.known.insert(handle, lowered.clone());
        }
        Ok(lowered)
    }

    fn all_scalars(&mut self, call: &mut Call<'a>, handle: Handle<Expression>) -> Lower<Vec<Value>> {
        match self.lowered(call, handle)? {
            Lowered::Scalars(scalars) => Ok(scalars),
            Lowered::Place(_) => {
                let span = call.function.expressions.get_span(handle);
                self.refuse(span, call, Rule::Internal, "a pointer can't be used as a value")
            }
        }
    }

    fn scalar(&mut self, call: &mut Call<'a>, handle: Handle<Expression>) -> Lower<Value> {
        let scalars = self.all_scalars(call, handle)?;
        match scalars.as_slice() {
            [one] => Ok(*one),
            _ => self.refuse(
                call.function.expressions.get_span(handle),
                call,
                Rule::Internal,
                "a scalar is needed here",
            ),
        }
    }

    fn place(&mut self, call: &mut Call<'a>, handle: Handle<Expression>) -> Lower<Place> {
        match self.lowered(call, handle)? {
            Lowered::Place(place) => Ok(place),
            Lowered::Scalars(_) => self.refuse(
                call.function.expressions.get_span(handle),
                call,
                Rule::Internal,
                "a pointer is needed here",
            ),
        }
    }

    /// Type that a pointer points to.
    fn pointee(&self, call: &Call<'_>, pointer: Handle<Expression>) -> TypeInner {
        match call.info[pointer].ty.inner_with(&self.module.types) {
            TypeInner::Pointer { base, .. } => self.module.types[*base].inner.clone(),
            TypeInner::ValuePointer {
                size: Some(size),
                scalar,
                ..
            } => TypeInner::Vector {
                size: *size,
                scalar: *scalar,
            },
            TypeInner::ValuePointer { size: None, scalar, .. } => TypeInner::Scalar(*scalar),
            other => other.clone(),
        }
    }

    /// Words of the scalars that a pointer points to, relative to the pointer.
    fn words_behind(&self, call: &Call<'_>, pointer: Handle<Expression>) -> Vec<u32> {
        match call.info[pointer].ty.inner_with(&self.module.types) {
            TypeInner::Pointer { base, .. } => self.scalars(*base).iter().map(|(_, _, word)| *word).collect(),
            TypeInner::ValuePointer { size: Some(size), .. } => (0..*size as u32).collect(),
            _ => vec![0],
        }
    }

    fn expression(&mut self, call: &mut Call<'a>, handle: Handle<Expression>) -> Lower<Lowered> {
        let span = call.function.expressions.get_span(handle);
        if span.is_defined() {
            self.here = span;
        }
        let first = self.program.values.len();
        let scalars = match &call.function.expressions[handle] {
            Expression::Literal(literal) => {
                let (bits, ty) = (literal_bits(*literal), literal_type(*literal));
                vec![self.constant(bits, ty)]
            }
            Expression::Constant(constant) => {
                let constant = &self.module.constants[*constant];
                let bits = self.constant_bits(constant.init);
                let types = self.scalars(constant.ty);
                bits.into_iter()
                    .zip(types)
                    .map(|(bits, (_, ty, _))| self.constant(bits, ty))
                    .collect()
            }
            Expression::ZeroValue(ty) => self
                .scalars(*ty)
                .into_iter()
                .map(|(_, ty, _)| self.constant(0, ty))
                .collect(),
            Expression::Compose { components, .. } => {
                let mut all = Vec::new();
                for component in components {
                    all.extend(self.all_scalars(call, *component)?);
                }
                all
            }
            Expression::Splat { size, value } => vec![self.scalar(call, *value)?; *size as usize],
            Expression::Swizzle { size, vector, pattern } => {
                let vector = self.all_scalars(call, *vector)?;
                pattern[..*size as usize]
                    .iter()
                    .map(|component| vector[*component as usize])
                    .collect()
            }
            Expression::FunctionArgument(index) => return Ok(call.arguments[*index as usize].clone()),
            Expression::GlobalVariable(global) => return Ok(Lowered::Place(self.globals[global].clone())),
            Expression::LocalVariable(local) => return Ok(Lowered::Place(call.locals[local].clone())),
            Expression::Access { base, index } => {
                let mut index = self.scalar(call, *index)?;
                // SPIR-V's is clamped as if it were unsigned.
                if self.program.ty(index) == Ty::I32 {
                    index = self.value(Op::Bitcast(index), Ty::U32);
                }
                return self.access(call, *base, index, span);
            }
            Expression::AccessIndex { base, index } => return self.access_index(call, *base, *index, span),
            Expression::Load { pointer } => self.load(call, *pointer, span)?,
            Expression::Unary { op, expr } => {
                let op = match op {
                    UnaryOperator::Negate => Unary::Negate,
                    UnaryOperator::LogicalNot | UnaryOperator::BitwiseNot => Unary::Not,
                };
                let operands = self.all_scalars(call, *expr)?;
                operands
                    .into_iter()
                    .map(|x| self.value(Op::Unary(op, x), self.program.ty(x)))
                    .collect()
            }
            Expression::Binary { op, left, right } => {
                let left = self.all_scalars(call, *left)?;
                let right = self.all_scalars(call, *right)?;
                self.componentwise(binary(*op), &left, &right)
            }
            Expression::Select {
                condition,
                accept,
                reject,
            } => {
                let condition = self.all_scalars(call, *condition)?;
                let accept = self.all_scalars(call, *accept)?;
                let reject = self.all_scalars(call, *reject)?;
                (0..accept.len())
                    .map(|k| {
                        let op = Op::Select {
                            condition: condition[k % condition.len()],
                            accept: accept[k],
                            reject: reject[k],
                        };
                        self.value(op, self.program.ty(accept[k]))
                    })
                    .collect()
            }
            Expression::Math {
                fun, arg, arg1, arg2, ..
            } => {
                let first = self.all_scalars(call, *arg)?;
                let second = arg1
                    .map(|arg| self.all_scalars(call, arg))
                    .transpose()?
                    .unwrap_or_default();
                let third = arg2
                    .map(|arg| self.all_scalars(call, arg))
                    .transpose()?
                    .unwrap_or_default();
                let unary = |op: Unary, this: &mut Self| {
                    first
                        .iter()
                        .map(|x| this.value(Op::Unary(op, *x), this.program.ty(*x)))
                        .collect()
                };
                match fun {
                    MathFunction::Abs => unary(Unary::Abs, self),
                    MathFunction::Floor => unary(Unary::Floor, self),
                    MathFunction::Trunc => unary(Unary::Trunc, self),
                    MathFunction::Min => self.componentwise(Binary::Min, &first, &second),
                    MathFunction::Max => self.componentwise(Binary::Max, &first, &second),
                    MathFunction::Clamp => {
                        let above = self.componentwise(Binary::Max, &first, &second);
                        self.componentwise(Binary::Min, &above, &third)
                    }
                    _ => return self.refuse(span, call, Rule::Internal, "this function has no lane code"),
                }
            }
            Expression::As { expr, kind, convert } => {
                let operands = self.all_scalars(call, *expr)?;
                let ty = kind_type(*kind);
                let convert = convert.is_some();
                operands
                    .into_iter()
                    .map(|x| {
                        let from = self.program.ty(x);
                        if from == ty {
                            return x;
                        }
                        let integers = matches!((from, ty), (Ty::I32, Ty::U32) | (Ty::U32, Ty::I32));
                        self.value(
                            if convert && !integers {
                                Op::Convert(x)
                            } else {
                                Op::Bitcast(x)
                            },
                            ty,
                        )
                    })
                    .collect()
            }
            _ => return self.refuse(span, call, Rule::Internal, "this expression has no lane code"),
        };
        // Those of operands have theirs already.
        let values = self.program.values[first..].iter_mut();
        values
            .filter(|value| !value.span.is_defined())
            .for_each(|value| value.span = span);
        Ok(Lowered::Scalars(scalars))
    }

    fn componentwise(&mut self, op: Binary, left: &[Value], right: &[Value]) -> Vec<Value> {
        (0..left.len().max(right.len()))
            .map(|k| {
                let (a, b) = (left[k % left.len()], right[k % right.len()]);
                let ty = if op.compares() { Ty::Bool } else { self.program.ty(a) };
                self.value(Op::Binary(op, a, b), ty)
            })
            .collect()
    }

    /// Lowers `base[index]` with an index computed at run time.
    fn access(&mut self, call: &mut Call<'a>, base: Handle<Expression>, index: Value, span: Span) -> Lower<Lowered> {
        let place = match self.lowered(call, base)? {
            Lowered::Place(Place::Buffer { buffer, stride }) => Place::InBuffer(Address {
                buffer,
                element: Some(index),
                stride,
                offset: 0,
            }),
            Lowered::Place(Place::Arrays(arrays)) => Place::Spots(element(arrays, index)),
            Lowered::Place(Place::Spots(spots)) => {
                let Some(count) = count_of(&self.pointee(call, base)) else {
                    return self.refuse(span, call, Rule::Internal, "this has no index");
                };
                let elements = spots.chunks(spots.len() / count).map(<[Spot]>::to_vec);
                Place::OneOf(elements.collect(), index)
            }
            Lowered::Scalars(scalars) => {
                let Some(count) = count_of(call.info[base].ty.inner_with(&self.module.types)) else {
                    return self.refuse(span, call, Rule::Internal, "this has no index");
                };
                let elements: Vec<_> = scalars.chunks(scalars.len() / count).map(<[Value]>::to_vec).collect();
                return Ok(Lowered::Scalars(self.one_of(elements, index)));
            }
            Lowered::Place(Place::OneOf(elements, outer)) => {
                let Some(count) = count_of(&self.pointee(call, base)) else {
                    return self.refuse(span, call, Rule::Internal, "this has no index");
                };
                let [outer, inner] = [(outer, elements.len()), (index, count)].map(|(index, count)| {
                    let last = self.constant(count as u32 - 1, Ty::U32);
                    self.value(Op::Binary(Binary::Min, index, last), Ty::U32)
                });
                let count_value = self.constant(count as u32, Ty::U32);
                let first = self.value(Op::Binary(Binary::Multiply, outer, count_value), Ty::U32);
                let index = self.value(Op::Binary(Binary::Add, first, inner), Ty::U32);
                let each = elements
                    .iter()
                    .flat_map(|element| element.chunks(element.len() / count));
                Place::OneOf(each.map(<[Spot]>::to_vec).collect(), index)
            }
            Lowered::Place(Place::InBuffer(_)) => {
                return self.refuse(span, call, Rule::Internal, "a part of a buffer has no index");
            }
        };
        Ok(Lowered::Place(place))
    }

    /// The scalars of one of these elements, by its number. Beyond the last, it is the last one.
    fn one_of(&mut self, elements: Vec<Vec<Value>>, index: Value) -> Vec<Value> {
        let count = elements.len();
        let numbered = elements.into_iter().enumerate();
        let chosen = numbered.reduce(|(_, before), (number, element)| {
            let each = element.into_iter().zip(before);
            let each = each.map(|(accept, reject)| self.chosen(index, [number, count], accept, reject));
            (number, each.collect())
        });
        chosen.map_or_else(Vec::new, |(_, scalars)| scalars)
    }

    /// One value if an index is this number of so many, else another.
    fn chosen(&mut self, index: Value, [number, count]: [usize; 2], accept: Value, reject: Value) -> Value {
        let is_last = number + 1 == count;
        let op = if is_last { Binary::GreaterEqual } else { Binary::Equal };
        let number = self.constant(number as u32, Ty::U32);
        let condition = self.value(Op::Binary(op, index, number), Ty::Bool);
        let op = Op::Select {
            condition,
            accept,
            reject,
        };
        self.value(op, self.program.ty(accept))
    }

    /// Lowers `base.member` or `base[constant]`.
    fn access_index(
        &mut self,
        call: &mut Call<'a>,
        base: Handle<Expression>,
        index: u32,
        span: Span,
    ) -> Lower<Lowered> {
        let lowered = self.lowered(call, base)?;
        if let Lowered::Place(Place::Buffer { buffer, stride }) = lowered {
            let element = self.constant(index, Ty::U32);
            return Ok(Lowered::Place(Place::InBuffer(Address {
                buffer,
                element: Some(element),
                stride,
                offset: 0,
            })));
        }
        // Index and number of the component's scalars among those of the base, and its word.
        let inner = self.pointee(call, base);
        let (first, count, word) = match &inner {
            TypeInner::Vector { .. } => (index as usize, 1, index),
            TypeInner::Matrix { rows, .. } => {
                let count = *rows as usize;
                (index as usize * count, count, index * words_of_column(*rows))
            }
            TypeInner::Struct { members, .. } => {
                let counts: Vec<_> = members.iter().map(|member| self.scalars(member.ty).len()).collect();
                let first = counts[..index as usize].iter().sum();
                (first, counts[index as usize], members[index as usize].offset / 4)
            }
            TypeInner::Array { base, stride, .. } => {
                let count = self.scalars(*base).len();
                (index as usize * count, count, index * stride / 4)
            }
            _ => return self.refuse(span, call, Rule::Internal, "this has no components"),
        };
        Ok(match lowered {
            Lowered::Scalars(scalars) => Lowered::Scalars(scalars[first..first + count].to_vec()),
            Lowered::Place(Place::Spots(spots)) => Lowered::Place(Place::Spots(spots[first..first + count].to_vec())),
            Lowered::Place(Place::Arrays(arrays)) => {
                let index = self.constant(index, Ty::U32);
                Lowered::Place(Place::Spots(element(arrays, index)))
            }
            Lowered::Place(Place::InBuffer(address)) => Lowered::Place(Place::InBuffer(Address {
                offset: address.offset + word,
                ..address
            })),
            Lowered::Place(Place::OneOf(elements, at)) => {
                let each = elements
                    .into_iter()
                    .map(|element| element[first..first + count].to_vec());
                Lowered::Place(Place::OneOf(each.collect(), at))
            }
            Lowered::Place(Place::Buffer { .. }) => {
                return self.refuse(span, call, Rule::Internal, "this has no components");
            }
        })
    }

    fn load(&mut self, call: &mut Call<'a>, pointer: Handle<Expression>, span: Span) -> Lower<Vec<Value>> {
        match self.place(call, pointer)? {
            Place::Spots(spots) => Ok(self.all_read(spots, span)),
            Place::OneOf(elements, index) => {
                let values = elements.into_iter().map(|spots| self.all_read(spots, span)).collect();
                Ok(self.one_of(values, index))
            }
            Place::Arrays(arrays) => {
                let count = self.program.arrays[arrays[0].0 as usize].init.len();
                let mut all = Vec::new();
                for number in 0..count {
                    let index = self.constant(number as u32, Ty::U32);
                    all.extend(self.all_read(element(arrays.clone(), index), span));
                }
                Ok(all)
            }
            Place::InBuffer(address) => {
                let types: Vec<_> = match call.info[pointer].ty.inner_with(&self.module.types) {
                    TypeInner::Pointer { base, .. } => self
                        .scalars(*base)
                        .into_iter()
                        .map(|(_, ty, word)| (ty, word))
                        .collect(),
                    TypeInner::ValuePointer { size, scalar, .. } => (0..size.map_or(1, |size| size as u32))
                        .map(|k| (scalar_type(*scalar), k))
                        .collect(),
                    _ => Vec::new(),
                };
                let targets: Vec<_> = types.iter().map(|(ty, _)| self.program.add(Op::Loaded, *ty)).collect();
                let vector = types.len() == 4 && types.iter().enumerate().all(|(k, (_, word))| *word == k as u32);
                if vector {
                    self.push(Statement::Load {
                        targets: targets.clone(),
                        address,
                    });
                } else {
                    for (target, (_, word)) in targets.iter().zip(&types) {
                        let address = Address {
                            offset: address.offset + word,
                            ..address
                        };
                        self.push(Statement::Load {
                            targets: vec![*target],
                            address,
                        });
                    }
                }
                Ok(targets)
            }
            Place::Buffer { .. } => self.refuse(span, call, Rule::Internal, "a whole buffer can't be loaded"),
        }
    }

    fn all_read(&mut self, spots: Vec<Spot>, span: Span) -> Vec<Value> {
        spots.into_iter().map(|spot| self.read(spot, span)).collect()
    }

    fn read(&mut self, spot: Spot, span: Span) -> Value {
        match spot {
            Spot::Variable(variable) => self.value(Op::Read(variable), self.program.variables[variable.0 as usize].ty),
            Spot::Element(array, index) => {
                let value = self.value(Op::ReadElement(array, index), self.program.arrays[array.0 as usize].ty);
                self.program.values[value.0 as usize].span = if span.is_defined() { span } else { self.here };
                value
            }
        }
    }

    fn write(&mut self, spot: Spot, value: Value, span: Span) {
        self.push(match spot {
            Spot::Variable(variable) => Statement::Write(variable, value),
            Spot::Element(array, index) => Statement::WriteElement {
                array,
                index,
                value,
                span,
            },
        });
    }
}

/// The same element of several arrays.
fn element(arrays: Vec<Array>, index: Value) -> Vec<Spot> {
    arrays.into_iter().map(|array| Spot::Element(array, index)).collect()
}

/// Returns whether a function has a return other than its last statement.
fn returns_early(block: &naga::Block, last_counts: bool) -> bool {
    let count = block.len();
    block.iter().enumerate().any(|(at, statement)| match statement {
        naga::Statement::Return { .. } => !(last_counts && at + 1 == count),
        naga::Statement::Block(inner) => returns_early(inner, last_counts && at + 1 == count),
        naga::Statement::If { accept, reject, .. } => returns_early(accept, false) || returns_early(reject, false),
        naga::Statement::Switch { cases, .. } => cases.iter().any(|case| returns_early(&case.body, false)),
        naga::Statement::Loop { body, continuing, .. } => {
            returns_early(body, false) || returns_early(continuing, false)
        }
        _ => false,
    })
}

/// The ends of the names of a vector's components.
const COMPONENTS: [&str; 4] = ["_x", "_y", "_z", "_w"];

/// Words from a column of a matrix to the next one.
fn words_of_column(rows: VectorSize) -> u32 {
    (rows as u32).next_power_of_two()
}

/// The number of elements of an array or vector, or of columns of a matrix.
fn count_of(inner: &TypeInner) -> Option<usize> {
    match inner {
        TypeInner::Matrix { columns, .. } => Some(*columns as usize),
        TypeInner::Vector { size, .. } => Some(*size as usize),
        TypeInner::Array {
            size: naga::ArraySize::Constant(count),
            ..
        } => Some(count.get() as usize),
        _ => None,
    }
}

fn binary(op: BinaryOperator) -> Binary {
    match op {
        BinaryOperator::Add => Binary::Add,
        BinaryOperator::Subtract => Binary::Subtract,
        BinaryOperator::Multiply => Binary::Multiply,
        BinaryOperator::Divide => Binary::Divide,
        BinaryOperator::Modulo => Binary::Remainder,
        BinaryOperator::Equal => Binary::Equal,
        BinaryOperator::NotEqual => Binary::NotEqual,
        BinaryOperator::Less => Binary::Less,
        BinaryOperator::LessEqual => Binary::LessEqual,
        BinaryOperator::Greater => Binary::Greater,
        BinaryOperator::GreaterEqual => Binary::GreaterEqual,
        BinaryOperator::And | BinaryOperator::LogicalAnd => Binary::And,
        BinaryOperator::ExclusiveOr => Binary::Xor,
        BinaryOperator::InclusiveOr | BinaryOperator::LogicalOr => Binary::Or,
        BinaryOperator::ShiftLeft => Binary::ShiftLeft,
        BinaryOperator::ShiftRight => Binary::ShiftRight,
    }
}

fn scalar_type(scalar: naga::Scalar) -> Ty {
    kind_type(scalar.kind)
}

fn kind_type(kind: ScalarKind) -> Ty {
    match kind {
        ScalarKind::Float | ScalarKind::AbstractFloat => Ty::F32,
        ScalarKind::Sint | ScalarKind::AbstractInt => Ty::I32,
        ScalarKind::Uint => Ty::U32,
        ScalarKind::Bool => Ty::Bool,
    }
}

fn literal_type(literal: Literal) -> Ty {
    match literal {
        Literal::F32(_) => Ty::F32,
        Literal::U32(_) => Ty::U32,
        Literal::Bool(_) => Ty::Bool,
        _ => Ty::I32,
    }
}

fn literal_bits(literal: Literal) -> u32 {
    match literal {
        Literal::F32(x) => x.to_bits(),
        Literal::U32(x) => x,
        Literal::I32(x) => x as u32,
        Literal::Bool(x) => u32::from(x),
        _ => 0,
    }
}
