//! The exactness rules: a closed list of what comes out the same bits everywhere. Calls are checked in the source, where
//! messages can say what to write instead; everything is checked on the IR after [`ordinary`], over every expression, used or
//! not.

use std::collections::BTreeSet;

use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{
    BinaryOperator, BuiltIn, Expression, Function, Handle, Literal, MathFunction, Module, ScalarKind, Statement,
    TypeInner, UnaryOperator,
};

use crate::front::has_function;
use crate::ordinary::{self, constants, is_masked};
use crate::rules::Rule;
use crate::source::{Part, Place, Refusal, Refusals, Source};
use crate::words::{blank_comments, is_call, is_number, words};

/// Built-in functions that may be called.
pub(crate) const CALLS: [&str; 8] = ["abs", "floor", "trunc", "select", "bitcast", "min", "max", "clamp"];
/// Types that may be constructed.
pub(crate) const CONSTRUCTORS: [&str; 35] = [
    "f32", "u32", "i32", "bool", "array", "vec2", "vec3", "vec4", "vec2f", "vec3f", "vec4f", "vec2u", "vec3u", "vec4u",
    "vec2i", "vec3i", "vec4i", "mat2x2", "mat2x3", "mat2x4", "mat3x2", "mat3x3", "mat3x4", "mat4x2", "mat4x3",
    "mat4x4", "mat2x2f", "mat2x3f", "mat2x4f", "mat3x2f", "mat3x3f", "mat3x4f", "mat4x2f", "mat4x3f", "mat4x4f",
];
/// Words before a parenthesis that aren't calls.
const KEYWORDS: [&str; 7] = ["if", "for", "while", "switch", "return", "case", "var"];

/// Most bytes of a local variable, and of all local arrays of a kernel: each of many lanes has its own.
pub const GREATEST_LOCAL: u32 = 1 << 16;

const TYPES: &str = "types are f32, i32, u32, bool, their vectors, arrays and structs, and matrices of f32";

/// Refuses what the text of a part alone shows. Functions that it doesn't declare may be those of other parts, unless WGSL has
/// one of that name.
pub fn check_part(part: &Part) -> Refusals {
    let mut refusals = check_source(&Source::new(std::slice::from_ref(part)));
    refusals.retain(|refusal| refusal.rule != Rule::UnknownName);
    refusals
}

/// Checks a kernel's text: only functions on the lists are called.
pub(crate) fn check_source(source: &Source) -> Refusals {
    let text = blank_comments(&source.text);
    let bytes = text.as_bytes();
    let mut declared = BTreeSet::new();
    let mut previous = "";
    let mut refusals = Vec::new();
    let mut refuse = |at: usize, rule: Rule, message: String| {
        refusals.push(Refusal {
            place: source.place(at),
            function: None,
            rule,
            message,
        });
    };
    for (at, word) in words(&text) {
        if matches!(previous, "fn" | "struct" | "alias") {
            declared.insert(word);
            if is_built_in(word) || is_unsupported(word) {
                let message = format!("`{word}` shadows a WGSL built-in; choose another name");
                refuse(at, Rule::BuiltInName, message);
            }
        }
        previous = word;
    }
    for (at, word) in words(&text) {
        let attribute = at > 0 && bytes[at - 1] == b'@';
        if is_number(word) {
            if word.ends_with('h') {
                let message = format!("the constant `{word}` has 16 bits; floats are f32");
                refuse(at, Rule::SupportedTypes, message);
            }
        } else if !attribute && is_call(&text[at + word.len()..]) {
            if is_built_in(word) || ordinary::CALLS.contains(&word) || declared.contains(word) {
                continue;
            }
            if !is_unsupported(word) && !has_function(word) {
                let hint = meant(word).map_or_else(String::new, |meant| format!("; write {meant}"));
                refuse(at, Rule::UnknownName, format!("there is no function `{word}`{hint}"));
                continue;
            }
            let message = format!(
                "`{word}` is not on the list of functions that are exact on every device{}",
                instead(word).map_or_else(String::new, |other| format!("; write {other}")),
            );
            let rule = if is_unsupported(word) {
                Rule::SupportedTypes
            } else {
                Rule::ExactFunctions
            };
            refuse(at, rule, message);
        } else if !attribute && !declared.contains(word) && is_unsupported(word) {
            let message = format!("`{word}` is not supported in kernels; {TYPES}");
            refuse(at, Rule::SupportedTypes, message);
        }
    }
    refusals
}

/// Whether a word before a parenthesis is WGSL's own, and allowed.
pub(crate) fn is_built_in(word: &str) -> bool {
    CALLS.contains(&word) || CONSTRUCTORS.contains(&word) || KEYWORDS.contains(&word)
}

/// The replacement of a function that is not on the list. Functions that WGSL doesn't have are those of
/// `lib/numerics.wgsl`.
fn instead(function: &str) -> Option<&'static str> {
    Some(match function {
        "quantizeToF16" => "its argument, since floats have 32 bits",
        "extractBits" => "`(x >> first) & ((1u << count) - 1u)`",
        _ => return None,
    })
}

/// WGSL for a function that only other languages have.
fn meant(function: &str) -> Option<&'static str> {
    Some(match function {
        "float" | "double" => "`f32(x)`",
        "int" => "`i32(x)`",
        "uint" | "unsigned" => "`u32(x)`",
        "float2" | "double2" => "`vec2<f32>(x, y)`",
        "float3" | "double3" => "`vec3<f32>(x, y, z)`",
        "float4" | "double4" => "`vec4<f32>(x, y, z, w)`",
        "fabs" => "`abs(x)`",
        "fmin" => "`min(x, y)`",
        "fmax" => "`max(x, y)`",
        "hypot" => "`length(vec2<f32>(x, y))`",
        "rand" => "`random(episode, STREAM, step, n)`",
        _ => return None,
    })
}

/// Whether a word is refused wherever it stands: types, and a statement of other stages.
fn is_unsupported(word: &str) -> bool {
    let is_matrix = |rest: &str| matches!(rest.as_bytes(), [b'2'..=b'4', b'x', b'2'..=b'4', b'h']);
    let known = [
        "f16",
        "vec2h",
        "vec3h",
        "vec4h",
        "sampler",
        "sampler_comparison",
        "atomic",
        "discard",
    ];
    known.contains(&word) || word.starts_with("texture_") || word.strip_prefix("mat").is_some_and(is_matrix)
}

/// Checks a kernel's IR against the closed list.
pub(crate) fn check_module(source: &Source, module: &Module, info: &ModuleInfo) -> Refusals {
    let mut refusals = Vec::new();
    let mut refuse = |span, rule, message: &str| {
        refusals.push(Refusal {
            place: source.place_of(span),
            function: None,
            rule,
            message: message.into(),
        });
    };
    for (handle, ty) in module.types.iter() {
        let refused = match &ty.inner {
            TypeInner::Scalar(scalar) | TypeInner::Vector { scalar, .. } | TypeInner::Matrix { scalar, .. } => {
                !is_allowed(*scalar)
            }
            TypeInner::Pointer { .. }
            | TypeInner::ValuePointer { .. }
            | TypeInner::Array { .. }
            | TypeInner::Struct { .. } => false,
            _ => true,
        };
        if refused {
            refuse(
                module.types.get_span(handle),
                Rule::SupportedTypes,
                &format!("this type is not supported; {TYPES}"),
            );
        }
    }
    for (handle, _) in module.overrides.iter() {
        refuse(
            module.overrides.get_span(handle),
            Rule::NoOverride,
            "override constants are not supported",
        );
    }
    let text = blank_comments(&source.text);
    for (handle, expression) in module.global_expressions.iter() {
        let span = module.global_expressions.get_span(handle);
        if let Expression::Literal(literal) = expression
            && let Some((rule, message)) = refused_literal(*literal)
        {
            refuse(span, rule, message);
        }
    }
    for (handle, variable) in module.global_variables.iter() {
        use naga::AddressSpace::{Private, Storage, Uniform};
        if variable.space == Private && module.types[variable.ty].inner.size(module.to_ctx()) > GREATEST_LOCAL {
            let span = module.global_variables.get_span(handle);
            let message = format!("this variable is too large; allowed: {GREATEST_LOCAL} bytes");
            refuse(span, Rule::LargeVariable, &message);
        }
        if !matches!(variable.space, Private | Storage { .. } | Uniform) {
            refuse(
                module.global_variables.get_span(handle),
                Rule::Internal,
                "this address space is not supported; allowed are private, uniform and storage",
            );
        }
    }
    for (handle, function) in module.functions.iter() {
        Checker {
            source,
            text: &text,
            module,
            function,
            info: &info[handle],
            refusals: &mut refusals,
        }
        .check();
    }
    for (index, entry) in module.entry_points.iter().enumerate() {
        let mut checker = Checker {
            source,
            text: &text,
            module,
            function: &entry.function,
            info: info.get_entry_point(index),
            refusals: &mut refusals,
        };
        checker.check();
        for argument in &entry.function.arguments {
            use BuiltIn::{GlobalInvocationId, LocalInvocationId, LocalInvocationIndex, WorkGroupId};
            let allowed = matches!(
                argument.binding,
                Some(naga::Binding::BuiltIn(
                    WorkGroupId | LocalInvocationIndex | LocalInvocationId | GlobalInvocationId
                ))
            );
            if !allowed {
                checker.refuse(
                    naga::Span::UNDEFINED,
                    Rule::EntryPoint,
                    "an entry point may only take workgroup_id, local_invocation_index, local_invocation_id and \
                     global_invocation_id: other built-in values depend on how the work was cut",
                );
            }
        }
    }
    refusals
}

fn is_allowed(scalar: naga::Scalar) -> bool {
    scalar.kind == ScalarKind::Bool || scalar.width == 4
}

/// The rule that something breaks, and the message.
type Refused = (Rule, &'static str);

/// The reason why a constant is refused.
fn refused_literal(literal: Literal) -> Option<Refused> {
    match literal {
        Literal::F32(x) => refused_float(x),
        Literal::I32(_) | Literal::U32(_) | Literal::Bool(_) => None,
        _ => Some((Rule::SupportedTypes, "a constant is neither f32, i32, u32 nor bool")),
    }
}

fn refused_float(x: f32) -> Option<Refused> {
    let message = if !x.is_finite() {
        "a constant is not finite"
    } else if x.is_subnormal() {
        "a constant is subnormal, between 0 and 1.1754944e-38: write `0.0f`, or a constant that is not"
    } else {
        return None;
    };
    Some((Rule::FiniteConstants, message))
}

struct Checker<'a> {
    source: &'a Source,
    /// Its text without comments.
    text: &'a str,
    module: &'a Module,
    function: &'a Function,
    info: &'a FunctionInfo,
    refusals: &'a mut Refusals,
}

impl Checker<'_> {
    fn refuse(&mut self, span: naga::Span, rule: Rule, message: &str) {
        let place = if span.is_defined() {
            self.source.place_of(span)
        } else {
            self.function_place()
        };
        self.refusals.push(Refusal {
            place,
            function: self.function.name.clone(),
            rule,
            message: message.into(),
        });
    }

    fn function_place(&self) -> Place {
        let name = self.function.name.as_deref().unwrap_or_default();
        let mut previous = "";
        for (at, word) in words(self.text) {
            if previous == "fn" && word == name {
                return self.source.place(at);
            }
            previous = word;
        }
        self.source.place(0)
    }

    fn check(&mut self) {
        let size = |ty: &TypeInner| ty.size(self.module.to_ctx());
        let is_large =
            |handle: &Handle<Expression>| size(self.info[*handle].ty.inner_with(&self.module.types)) > GREATEST_LOCAL;
        let large = self
            .function
            .expressions
            .iter()
            .map(|(handle, _)| handle)
            .find(is_large);
        if let Some(handle) = large {
            let span = self.function.expressions.get_span(handle);
            let message = format!("this value is too large; allowed: {GREATEST_LOCAL} bytes");
            self.refuse(span, Rule::LargeVariable, &message);
        }
        for (handle, local) in self.function.local_variables.iter() {
            if self.module.types[local.ty].inner.size(self.module.to_ctx()) > GREATEST_LOCAL {
                let span = self.function.local_variables.get_span(handle);
                let message = format!("this variable is too large; allowed: {GREATEST_LOCAL} bytes");
                self.refuse(span, Rule::LargeVariable, &message);
            }
        }
        for (handle, expression) in self.function.expressions.iter() {
            let span = self.function.expressions.get_span(handle);
            if let Some((rule, message)) = self.refused(expression) {
                self.refuse(span, rule, message);
            }
        }
        let function = self.function;
        self.check_block(&function.body);
    }

    fn kind(&self, expression: Handle<Expression>) -> Option<ScalarKind> {
        self.info[expression].ty.inner_with(&self.module.types).scalar_kind()
    }

    fn refused(&self, expression: &Expression) -> Option<Refused> {
        let internal = |message| Some((Rule::Internal, message));
        match expression {
            Expression::Literal(literal) => refused_literal(*literal),
            Expression::As {
                expr,
                kind: ScalarKind::Float,
                convert: None,
            } => constants(self.module, self.function, *expr)
                .into_iter()
                .find_map(|bits| refused_float(f32::from_bits(bits))),
            Expression::Unary { op, expr } => match (op, self.kind(*expr)?) {
                (UnaryOperator::Negate, ScalarKind::Float | ScalarKind::Sint)
                | (UnaryOperator::LogicalNot, ScalarKind::Bool)
                | (UnaryOperator::BitwiseNot, ScalarKind::Sint | ScalarKind::Uint) => None,
                _ => internal("this unary operation is not on the list"),
            },
            Expression::Binary { op, left, right } => self.refused_binary(*op, *left, *right),
            Expression::Math { fun, arg, .. } => {
                let kind = self.kind(*arg)?;
                match fun {
                    MathFunction::Abs | MathFunction::Min | MathFunction::Max | MathFunction::Clamp => None,
                    MathFunction::Floor | MathFunction::Trunc if kind == ScalarKind::Float => None,
                    _ => Some((
                        Rule::ExactFunctions,
                        "this function is not exact on every device; allowed are abs, floor, trunc, min, max, clamp",
                    )),
                }
            }
            Expression::As { convert, .. } if convert.is_none_or(|width| width == 4 || width == 1) => None,
            Expression::As { .. } => Some((
                Rule::SupportedTypes,
                "only conversions between f32, i32, u32 and bool are on the list",
            )),
            Expression::Constant(_)
            | Expression::ZeroValue(_)
            | Expression::Compose { .. }
            | Expression::Access { .. }
            | Expression::AccessIndex { .. }
            | Expression::Splat { .. }
            | Expression::Swizzle { .. }
            | Expression::FunctionArgument(_)
            | Expression::GlobalVariable(_)
            | Expression::LocalVariable(_)
            | Expression::Load { .. }
            | Expression::Select { .. }
            | Expression::CallResult(_) => None,
            Expression::ArrayLength(_) => {
                internal("`arrayLength` depends on how a buffer was made, not on what is in it")
            }
            Expression::Relational { .. } => Some((Rule::ExactFunctions, "tests for NaN are not on the list")),
            Expression::AtomicResult { .. } => internal("atomic operations have no fixed order"),
            _ => internal("this expression is not on the list"),
        }
    }

    fn refused_binary(
        &self,
        op: BinaryOperator,
        left: Handle<Expression>,
        right: Handle<Expression>,
    ) -> Option<Refused> {
        use BinaryOperator as Op;
        let kind = self.kind(left)?;
        match op {
            Op::Divide | Op::Modulo if kind != ScalarKind::Uint => {
                Some((Rule::Internal, "only unsigned integers are divided"))
            }
            Op::ShiftLeft | Op::ShiftRight if !is_masked(self.module, self.function, right) => {
                Some((Rule::Internal, "a shift's count is below 32"))
            }
            _ => None,
        }
    }

    /// Whether an expression is a pointer to a part of a variable, which SPIR-V can't pass.
    fn is_pointer_into(&self, expression: Handle<Expression>) -> bool {
        let inner = self.info[expression].ty.inner_with(&self.module.types);
        let is_part = matches!(
            self.function.expressions[expression],
            Expression::Access { .. } | Expression::AccessIndex { .. }
        );
        is_part && matches!(inner, TypeInner::Pointer { .. } | TypeInner::ValuePointer { .. })
    }

    fn check_block(&mut self, block: &naga::Block) {
        for (statement, span) in block.span_iter() {
            match statement {
                Statement::Emit(_)
                | Statement::Break
                | Statement::Continue
                | Statement::Return { .. }
                | Statement::Store { .. } => {}
                Statement::Call { arguments, .. } => {
                    if arguments.iter().any(|argument| self.is_pointer_into(*argument)) {
                        self.refuse(
                            *span,
                            Rule::WholePointers,
                            "a pointer to a part of a variable can't be passed; pass one to the whole, or return the value",
                        );
                    }
                }
                Statement::Block(inner) => self.check_block(inner),
                Statement::If { accept, reject, .. } => {
                    self.check_block(accept);
                    self.check_block(reject);
                }
                Statement::Switch { cases, .. } => {
                    for case in cases {
                        if case.fall_through && !case.body.is_empty() {
                            self.refuse(*span, Rule::Internal, "a case that falls through is not supported");
                        }
                        self.check_block(&case.body);
                    }
                }
                Statement::Loop { body, continuing, .. } => {
                    self.check_block(body);
                    self.check_block(continuing);
                }
                Statement::ControlBarrier(_) | Statement::MemoryBarrier(_) | Statement::WorkGroupUniformLoad { .. } => {
                    self.refuse(
                        *span,
                        Rule::Internal,
                        "barriers are not supported: lanes of one workgroup run in separate calls",
                    );
                }
                Statement::Atomic { .. } => {
                    self.refuse(*span, Rule::Internal, "atomic operations have no fixed order");
                }
                _ => self.refuse(*span, Rule::Internal, "this statement is not on the list"),
            }
        }
    }
}
