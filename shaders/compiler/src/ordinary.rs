//! Ordinary WGSL: what devices compute in different ways becomes calls of functions that are the same everywhere, those of
//! `lib/ordinary.wgsl`. A kernel without any of it stays unchanged.

use std::collections::{BTreeMap, BTreeSet};

use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{
    BinaryOperator, Block, Expression, Function, Handle, Literal, MathFunction, Module, RelationalFunction, ScalarKind,
    Span, Statement, TypeInner,
};
use oneiro_shader_parts::PARTS;

use crate::front;
use crate::rules::Rule;
use crate::source::{Part, Refusal, Refusals, Source};
use crate::words::{blank_comments, is_call, words};

/// The part that has the functions, and the one whose functions they call.
const LIBRARY: &str = "lib/ordinary.wgsl";
const NUMERICS: &str = "lib/numerics.wgsl";

/// WGSL's functions that are computed by the library.
pub(crate) const CALLS: [&str; 40] = [
    "sqrt",
    "inverseSqrt",
    "length",
    "distance",
    "normalize",
    "dot",
    "cross",
    "reflect",
    "sin",
    "cos",
    "tan",
    "asin",
    "acos",
    "atan",
    "atan2",
    "tanh",
    "exp",
    "exp2",
    "log",
    "log2",
    "pow",
    "mix",
    "smoothstep",
    "step",
    "sign",
    "saturate",
    "fma",
    "fract",
    "ceil",
    "round",
    "degrees",
    "radians",
    "any",
    "all",
    "countOneBits",
    "countLeadingZeros",
    "countTrailingZeros",
    "firstLeadingBit",
    "firstTrailingBit",
    "reverseBits",
];
/// Those of which a mathematical library computes constants, each in its own way.
pub(crate) const NOT_OF_CONSTANTS: [&str; 13] = [
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "tanh", "exp", "exp2", "log", "log2", "pow",
];

/// A call that stands for an expression.
struct Call {
    function: String,
    arguments: Vec<Handle<Expression>>,
    /// The place of the expression.
    span: Span,
}

/// Replaces what the library computes by calls, and puts the library's functions before the kernel; `None` if it computes nothing here.
///
/// # Errors
/// A kernel that naga doesn't take together with these functions.
pub(crate) fn lowered(
    source: &Source,
    module: &Module,
    info: &ModuleInfo,
) -> Result<Option<(Source, Module, ModuleInfo)>, Refusal> {
    let names: BTreeSet<_> = bodies(module, info)
        .flat_map(|(function, info)| calls(module, function, info).into_values())
        .map(|call| call.function)
        .collect();
    if names.is_empty() {
        return Ok(None);
    }
    let source = source.after(&Part {
        path: LIBRARY.into(),
        text: library(names, &source.text),
    });
    let (mut module, info) = front::parse(&source)?;
    let all: Vec<_> = bodies(&module, &info)
        .map(|(function, info)| calls(&module, function, info))
        .collect();
    let named: BTreeMap<_, _> = module
        .functions
        .iter()
        .filter_map(|(handle, function)| Some((function.name.clone()?, handle)))
        .collect();
    let functions = module.functions.iter_mut().map(|(_, function)| function);
    let entries = module.entry_points.iter_mut().map(|entry| &mut entry.function);
    for (function, calls) in functions.chain(entries).zip(&all) {
        let mut results = BTreeMap::new();
        for (handle, call) in calls {
            results.insert(*handle, named[&call.function]);
        }
        rewrite(&mut function.body, calls, &results);
        for (handle, called) in results {
            *function.expressions.get_mut(handle) = Expression::CallResult(called);
        }
    }
    let info = front::validate(&module).map_err(|error| Refusal {
        place: source.place(0),
        function: None,
        rule: Rule::Internal,
        message: format!("{:?}", error.into_inner()),
    })?;
    Ok(Some((source, module, info)))
}

/// Constants that a mathematical library would compute: calls of these functions that naga has replaced by their results.
pub(crate) fn folded(source: &Source, module: &Module) -> Refusals {
    let entries = module.entry_points.iter().map(|entry| &entry.function);
    let functions = module.functions.iter().map(|(_, function)| function);
    let mut computed = BTreeSet::new();
    for function in functions.chain(entries) {
        for (handle, expression) in function.expressions.iter() {
            if matches!(expression, Expression::Math { .. }) {
                computed.extend(
                    function
                        .expressions
                        .get_span(handle)
                        .to_range()
                        .map(|range| range.start),
                );
            }
        }
    }
    let text = blank_comments(&source.text);
    let declared: BTreeSet<_> = module
        .functions
        .iter()
        .filter_map(|(_, function)| function.name.clone())
        .collect();
    let is_folded = |(at, word): &(usize, &str)| {
        NOT_OF_CONSTANTS.contains(word)
            && !declared.contains(*word)
            && is_call(&text[at + word.len()..])
            && !computed.contains(at)
    };
    let refusal = |(at, word)| Refusal {
        place: source.place(at),
        function: None,
        rule: Rule::ExactFunctions,
        message: format!(
            "`{word}` of a constant would be computed by the machine that compiles; write its value, or `let x = ..;` and `{word}(x)`"
        ),
    };
    words(&text).filter(is_folded).map(refusal).collect()
}

/// The functions of a module, in the order in which [`lowered`] goes through them.
fn bodies<'a>(module: &'a Module, info: &'a ModuleInfo) -> impl Iterator<Item = (&'a Function, &'a FunctionInfo)> {
    let functions = module
        .functions
        .iter()
        .map(|(handle, function)| (function, &info[handle]));
    let entries = module.entry_points.iter().enumerate();
    functions.chain(entries.map(|(at, entry)| (&entry.function, info.get_entry_point(at))))
}

/// The calls that stand for a function's expressions.
fn calls(module: &Module, function: &Function, info: &FunctionInfo) -> BTreeMap<Handle<Expression>, Call> {
    let call = |(handle, expression)| {
        let (name, arguments) = Types { module, function, info }.call(expression)?;
        let span = function.expressions.get_span(handle);
        let function = name;
        Some((
            handle,
            Call {
                function,
                arguments,
                span,
            },
        ))
    };
    function.expressions.iter().filter_map(call).collect()
}

struct Types<'a> {
    module: &'a Module,
    function: &'a Function,
    info: &'a FunctionInfo,
}

impl Types<'_> {
    fn inner(&self, expression: Handle<Expression>) -> &TypeInner {
        self.info[expression].ty.inner_with(&self.module.types)
    }

    /// A function for arguments like this one.
    fn named(&self, base: &str, argument: Handle<Expression>) -> Option<String> {
        let inner = self.inner(argument);
        let scalar = match inner.scalar_kind()? {
            ScalarKind::Float | ScalarKind::Bool => "",
            ScalarKind::Sint => "_i32",
            ScalarKind::Uint => "_u32",
            _ => return None,
        };
        Some(match inner {
            TypeInner::Scalar(_) => format!("wgsl_{base}{scalar}"),
            TypeInner::Vector { size, .. } => format!("wgsl_{base}{scalar}_vec{}", *size as u32),
            _ => return None,
        })
    }

    /// The function that stands for an expression, and its arguments.
    fn call(&self, expression: &Expression) -> Option<(String, Vec<Handle<Expression>>)> {
        match *expression {
            Expression::Binary { op, left, right } => {
                let base = self.operator(op, left, right)?;
                Some((self.named(base, left)?, vec![left, right]))
            }
            Expression::Relational { fun, argument } => {
                let base = match fun {
                    RelationalFunction::Any => "any",
                    RelationalFunction::All => "all",
                    _ => return None,
                };
                Some((self.named(base, argument)?, vec![argument]))
            }
            Expression::Math {
                fun, arg, arg1, arg2, ..
            } => {
                let mut arguments: Vec<_> = [Some(arg), arg1, arg2].into_iter().flatten().collect();
                let mut base = self.function(fun, arg)?;
                if fun == MathFunction::Pow
                    && let Some(constant) = arg1.and_then(|power| self.power(power))
                {
                    base = constant;
                    arguments.truncate(1);
                }
                let mut function = self.named(base, arg)?;
                let last = *arguments.last()?;
                if fun == MathFunction::Mix && function != self.named(base, last)? {
                    function.push_str("_by_one");
                }
                Some((function, arguments))
            }
            _ => None,
        }
    }

    /// The name of an operator that the library computes.
    fn operator(
        &self,
        op: BinaryOperator,
        left: Handle<Expression>,
        right: Handle<Expression>,
    ) -> Option<&'static str> {
        let kind = self.inner(left).scalar_kind()?;
        let is_signed = matches!(kind, ScalarKind::Float | ScalarKind::Sint);
        match op {
            BinaryOperator::Divide if is_signed => Some("divide"),
            BinaryOperator::Modulo if is_signed => Some("modulo"),
            // Constant counts stay. naga refuses those above 31.
            BinaryOperator::ShiftLeft | BinaryOperator::ShiftRight
                if !is_masked(self.module, self.function, right)
                    && constants(self.module, self.function, right).is_empty() =>
            {
                Some(if op == BinaryOperator::ShiftLeft {
                    "shift_left"
                } else {
                    "shift_right"
                })
            }
            _ => None,
        }
    }

    /// The name of a function that the library computes.
    fn function(&self, fun: MathFunction, arg: Handle<Expression>) -> Option<&'static str> {
        use MathFunction as F;
        let kind = self.inner(arg).scalar_kind()?;
        if kind != ScalarKind::Float {
            return match fun {
                F::Sign if kind == ScalarKind::Sint => Some("sign"),
                F::Dot => Some("dot"),
                F::CountOneBits => Some("countOneBits"),
                F::CountLeadingZeros => Some("countLeadingZeros"),
                F::CountTrailingZeros => Some("countTrailingZeros"),
                F::FirstTrailingBit => Some("firstTrailingBit"),
                F::ReverseBits => Some("reverseBits"),
                F::FirstLeadingBit => Some("firstLeadingBit"),
                _ => None,
            };
        }
        Some(match fun {
            F::Saturate => "saturate",
            F::Cos => "cos",
            F::Sin => "sin",
            F::Tan => "tan",
            F::Tanh => "tanh",
            F::Acos => "acos",
            F::Asin => "asin",
            F::Atan => "atan",
            F::Atan2 => "atan2",
            F::Radians => "radians",
            F::Degrees => "degrees",
            F::Ceil => "ceil",
            F::Round => "round",
            F::Fract => "fract",
            F::Exp => "exp",
            F::Exp2 => "exp2",
            F::Log => "log",
            F::Log2 => "log2",
            F::Pow => "pow",
            F::Dot => "dot",
            F::Cross => "cross",
            F::Distance => "distance",
            F::Length => "length",
            F::Normalize => "normalize",
            F::Reflect => "reflect",
            F::Sign => "sign",
            F::Fma => "fma",
            F::Mix => "mix",
            F::Step => "step",
            F::SmoothStep => "smoothstep",
            F::Sqrt => "sqrt",
            F::InverseSqrt => "inverseSqrt",
            _ => return None,
        })
    }

    /// The function for a constant power, the same for all components.
    fn power(&self, power: Handle<Expression>) -> Option<&'static str> {
        let bits = constants(self.module, self.function, power);
        let (first, rest) = bits.split_first()?;
        let power = f32::from_bits(*first);
        let known = [
            (-2.0, "pow_minus_two"),
            (-1.0, "pow_minus_one"),
            (-0.5, "pow_minus_half"),
            (0.5, "pow_half"),
            (1.0, "pow_one"),
            (2.0, "pow_two"),
            (3.0, "pow_three"),
            (4.0, "pow_four"),
        ];
        let (_, name) = known.into_iter().find(|(known, _)| *known == power)?;
        rest.iter().all(|other| other == first).then_some(name)
    }
}

/// The bits of what is known at build time.
pub(crate) fn constants(module: &Module, function: &Function, expression: Handle<Expression>) -> Vec<u32> {
    let bits = |literal: &Literal| match literal {
        Literal::F32(x) => Some(x.to_bits()),
        Literal::U32(bits) => Some(*bits),
        Literal::I32(bits) => Some(*bits as u32),
        _ => None,
    };
    match &function.expressions[expression] {
        Expression::Literal(literal) => bits(literal).into_iter().collect(),
        Expression::Constant(constant) => match &module.global_expressions[module.constants[*constant].init] {
            Expression::Literal(literal) => bits(literal).into_iter().collect(),
            _ => Vec::new(),
        },
        Expression::Compose { components, .. } => {
            let each = components
                .iter()
                .map(|component| constants(module, function, *component));
            let all: Vec<_> = each.collect();
            if all.iter().any(Vec::is_empty) {
                Vec::new()
            } else {
                all.concat()
            }
        }
        Expression::Splat { value, .. } => constants(module, function, *value),
        _ => Vec::new(),
    }
}

/// Whether the bits of a shift's count beyond the fifth are 0.
pub(crate) fn is_masked(module: &Module, function: &Function, count: Handle<Expression>) -> bool {
    let below_32 = |handle| matches!(constants(module, function, handle)[..], [count] if count < 32);
    match function.expressions[count] {
        Expression::Binary {
            op: BinaryOperator::And,
            left,
            right,
        } => below_32(left) || below_32(right),
        Expression::Splat { value, .. } => below_32(value),
        Expression::Compose { ref components, .. } => components.iter().all(|component| below_32(*component)),
        _ => below_32(count),
    }
}

/// Takes the expressions that become results of calls out of the ranges that are computed, and calls there.
fn rewrite(
    block: &mut Block,
    calls: &BTreeMap<Handle<Expression>, Call>,
    results: &BTreeMap<Handle<Expression>, Handle<Function>>,
) {
    let mut rewritten = Block::with_capacity(block.len());
    for (mut statement, span) in std::mem::take(block).span_into_iter() {
        let Statement::Emit(range) = statement else {
            match &mut statement {
                Statement::Block(inner) => rewrite(inner, calls, results),
                Statement::If { accept, reject, .. } => {
                    rewrite(accept, calls, results);
                    rewrite(reject, calls, results);
                }
                Statement::Switch { cases, .. } => {
                    for case in cases {
                        rewrite(&mut case.body, calls, results);
                    }
                }
                Statement::Loop { body, continuing, .. } => {
                    rewrite(body, calls, results);
                    rewrite(continuing, calls, results);
                }
                _ => {}
            }
            rewritten.push(statement, span);
            continue;
        };
        let mut computed: Option<[Handle<Expression>; 2]> = None;
        for handle in range {
            let Some(call) = calls.get(&handle) else {
                computed = Some([computed.map_or(handle, |[first, _]| first), handle]);
                continue;
            };
            if let Some([first, last]) = computed.take() {
                rewritten.push(Statement::Emit(naga::Range::new_from_bounds(first, last)), span);
            }
            let statement = Statement::Call {
                function: results[&handle],
                arguments: call.arguments.clone(),
                result: Some(handle),
            };
            rewritten.push(statement, call.span);
        }
        if let Some([first, last]) = computed {
            rewritten.push(Statement::Emit(naga::Range::new_from_bounds(first, last)), span);
        }
    }
    *block = rewritten;
}

/// The text of these functions and of those that they call, other than those that a kernel has.
fn library(names: BTreeSet<String>, kernel: &str) -> String {
    let kernel = blank_comments(kernel);
    let mut previous = "";
    let declared = words(&kernel).filter(|(_, word)| std::mem::replace(&mut previous, word) == "fn");
    let mut done: BTreeSet<_> = declared.map(|(_, word)| word.to_owned()).collect();
    let shipped = shipped();
    let mut text = String::new();
    let mut wanted: Vec<_> = names.into_iter().collect();
    while let Some(name) = wanted.pop() {
        if !done.insert(name.clone()) {
            continue;
        }
        let function = shipped.get(name.as_str()).cloned();
        let function = function.unwrap_or_else(|| of_vectors(&name, &shipped));
        let used = words(&function).map(|(_, word)| word);
        wanted.extend(
            used.filter(|word| shipped.contains_key(word) || word.starts_with("wgsl_"))
                .map(str::to_owned),
        );
        text.push_str(&function);
        text.push('\n');
    }
    text
}

/// The functions of the library and of what it calls, by name.
fn shipped() -> BTreeMap<&'static str, String> {
    let parts = PARTS.iter().filter(|(path, _)| [LIBRARY, NUMERICS].contains(path));
    let functions = parts.flat_map(|(_, text)| text.split("\nfn ").skip(1));
    let named = functions.filter_map(|text| {
        let (name, _) = text.split_once('(')?;
        let (function, _) = text.split_once("\n}")?;
        Some((name, format!("fn {function}\n}}")))
    });
    named.collect()
}

/// A function of vectors, by that of their components.
fn of_vectors(name: &str, shipped: &BTreeMap<&str, String>) -> String {
    let (name_of_one, by_one) = name.strip_suffix("_by_one").map_or((name, false), |rest| (rest, true));
    let (base, size) = name_of_one.rsplit_once("_vec").expect("it is of vectors");
    let size: usize = size.parse().expect("vectors have a number of components");
    let components = &["x", "y", "z", "w"][..size];
    let joined = |each: &dyn Fn(&str) -> String, with: &str| {
        components
            .iter()
            .map(|component| each(component))
            .collect::<Vec<_>>()
            .join(with)
    };
    let scalar = base
        .rsplit_once('_')
        .map(|(_, ty)| ty)
        .filter(|ty| ["i32", "u32"].contains(ty));
    let ty = format!("vec{size}<{}>", scalar.unwrap_or("f32"));
    let dot = format!("wgsl_dot_vec{size}");
    let (parameters, result, value) = match base {
        _ if by_one => (
            format!("a: {ty}, b: {ty}, t: f32"),
            ty.clone(),
            format!("{name_of_one}(a, b, {ty}(t))"),
        ),
        "wgsl_dot" | "wgsl_dot_i32" | "wgsl_dot_u32" => (
            format!("a: {ty}, b: {ty}"),
            scalar.unwrap_or("f32").to_owned(),
            joined(&|c| format!("a.{c} * b.{c}"), " + "),
        ),
        "wgsl_length" => (format!("v: {ty}"), "f32".to_owned(), format!("wgsl_sqrt({dot}(v, v))")),
        "wgsl_distance" => (
            format!("a: {ty}, b: {ty}"),
            "f32".to_owned(),
            format!("wgsl_length_vec{size}(a - b)"),
        ),
        "wgsl_normalize" => (
            format!("v: {ty}"),
            ty.clone(),
            format!("v * wgsl_inverseSqrt({dot}(v, v))"),
        ),
        "wgsl_reflect" => (
            format!("a: {ty}, b: {ty}"),
            ty.clone(),
            format!("a - b * (2.0f * {dot}(b, a))"),
        ),
        "wgsl_any" | "wgsl_all" => {
            let with = if base == "wgsl_any" { " | " } else { " & " };
            (
                format!("v: vec{size}<bool>"),
                "bool".to_owned(),
                joined(&|c| format!("v.{c}"), with),
            )
        }
        _ => {
            let head = shipped.get(base).and_then(|text| text.split_once('('));
            let (head, _) = head
                .and_then(|(_, rest)| rest.split_once(')'))
                .expect("the library has it");
            let parameters: Vec<_> = head
                .split(", ")
                .filter_map(|parameter| parameter.split_once(": "))
                .collect();
            let list: Vec<_> = parameters
                .iter()
                .map(|(name, ty)| format!("{name}: vec{size}<{ty}>"))
                .collect();
            let each = |c: &str| {
                let arguments: Vec<_> = parameters.iter().map(|(name, _)| format!("{name}.{c}")).collect();
                format!("{base}({})", arguments.join(", "))
            };
            (list.join(", "), ty.clone(), format!("{ty}({})", joined(&each, ", ")))
        }
    };
    format!("fn {name}({parameters}) -> {result} {{\n    return {value};\n}}")
}
