//! Ordinary WGSL: what devices compute in different ways becomes calls of functions that are the same everywhere, those of
//! `lib/ordinary.wgsl`. A kernel without any of it stays unchanged.

use std::collections::{BTreeMap, BTreeSet};

use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{
    BinaryOperator, Block, Expression, Function, Handle, Literal, MathFunction, Module, PredeclaredType,
    RelationalFunction, ScalarKind, Span, Statement, TypeInner,
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
pub(crate) const CALLS: [&str; 52] = [
    "sqrt",
    "inverseSqrt",
    "length",
    "distance",
    "normalize",
    "dot",
    "cross",
    "reflect",
    "refract",
    "faceForward",
    "transpose",
    "determinant",
    "sin",
    "cos",
    "tan",
    "asin",
    "acos",
    "atan",
    "atan2",
    "sinh",
    "cosh",
    "tanh",
    "asinh",
    "acosh",
    "atanh",
    "exp",
    "exp2",
    "log",
    "log2",
    "pow",
    "ldexp",
    "frexp",
    "modf",
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
const NOT_OF_CONSTANTS: [&str; 18] = [
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "exp",
    "exp2", "log", "log2", "pow",
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
    return_predeclared(&mut module);
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

/// Lets the library's functions of two results return the types that WGSL has for these, which have no name there.
fn return_predeclared(module: &mut Module) {
    let predeclared = module.special_types.predeclared_types.iter();
    let predeclared: BTreeMap<_, _> = predeclared
        .filter_map(|(predeclared, ty)| {
            let (base, size) = match predeclared {
                PredeclaredType::ModfResult { size, .. } => ("modf", size),
                PredeclaredType::FrexpResult { size, .. } => ("frexp", size),
                PredeclaredType::AtomicCompareExchangeWeakResult(_) => return None,
            };
            let size = size.map_or_else(String::new, |size| format!("_vec{}", size as u32));
            Some((format!("wgsl_{base}{size}"), *ty))
        })
        .collect();
    for (_, function) in module.functions.iter_mut() {
        let ty = function.name.as_ref().and_then(|name| predeclared.get(name));
        let (Some(ty), Some(result)) = (ty, &mut function.result) else {
            continue;
        };
        for (_, expression) in function.expressions.iter_mut() {
            if let Expression::Compose { ty: composed, .. } = expression
                && *composed == result.ty
            {
                *composed = *ty;
            }
        }
        result.ty = *ty;
    }
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
        let call = Call {
            function: name,
            arguments,
            span: function.expressions.get_span(handle),
        };
        Some((handle, call))
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

    /// A function of matrices, or of one and a vector or number.
    fn of_matrices(&self, base: &str, arguments: &[Handle<Expression>]) -> Option<String> {
        let inners: Vec<_> = arguments.iter().map(|argument| self.inner(*argument)).collect();
        let has_matrix = inners.iter().any(|inner| matches!(inner, TypeInner::Matrix { .. }));
        let name = |inner: &&TypeInner| match inner {
            TypeInner::Scalar(_) => Some("f32".to_owned()),
            TypeInner::Vector { size, .. } => Some(format!("vec{}", *size as u32)),
            TypeInner::Matrix { columns, rows, .. } => Some(format!("mat{}x{}", *columns as u32, *rows as u32)),
            _ => None,
        };
        let types: Vec<_> = inners.iter().map(name).collect::<Option<_>>()?;
        has_matrix.then(|| format!("wgsl_{base}_{}", types.join("_")))
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
                let arguments = vec![left, right];
                let of_matrices = match op {
                    BinaryOperator::Multiply => self.of_matrices("multiply", &arguments),
                    BinaryOperator::Add => self.of_matrices("add", &arguments),
                    BinaryOperator::Subtract => self.of_matrices("subtract", &arguments),
                    _ => None,
                };
                let function = match of_matrices {
                    Some(function) => function,
                    None => self.named(self.operator(op, left, right)?, left)?,
                };
                Some((function, arguments))
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
                let of_matrices = match fun {
                    MathFunction::Transpose => Some("transpose"),
                    MathFunction::Determinant => Some("determinant"),
                    _ => None,
                };
                if let Some(base) = of_matrices {
                    return Some((self.of_matrices(base, &arguments)?, arguments));
                }
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
            F::Sinh => "sinh",
            F::Cosh => "cosh",
            F::Tanh => "tanh",
            F::Asinh => "asinh",
            F::Acosh => "acosh",
            F::Atanh => "atanh",
            F::Ldexp => "ldexp",
            F::Frexp => "frexp",
            F::Modf => "modf",
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
            F::Refract => "refract",
            F::FaceForward => "faceForward",
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
        let function = function.unwrap_or_else(|| {
            result_of_two(&name)
                .or_else(|| of_matrices(&name))
                .unwrap_or_else(|| of_vectors(&name, &shipped))
        });
        let used = words(&function).map(|(_, word)| word);
        wanted.extend(
            used.filter(|word| shipped.contains_key(word) || word.starts_with("wgsl_"))
                .filter(|word| !word.ends_with(RESULT))
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

/// The functions that return two numbers, with the fields of their results.
const OF_TWO: [(&str, [[&str; 2]; 2]); 2] = [
    ("wgsl_modf", [["fract", "f32"], ["whole", "f32"]]),
    ("wgsl_frexp", [["fract", "f32"], ["exp", "i32"]]),
];

/// A function that returns two numbers or vectors, with the struct that it returns.
fn result_of_two(name: &str) -> Option<String> {
    let (base, fields) = OF_TWO.iter().find(|(base, _)| {
        let rest = name.strip_prefix(base);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with("_vec"))
    })?;
    let size = &name[base.len()..];
    let ty = |scalar: &str| match size.strip_prefix('_') {
        Some(vector) => format!("{vector}<{scalar}>"),
        None => scalar.to_owned(),
    };
    let [first, second] =
        fields.map(|[field, scalar]| (format!("{field}: {}", ty(scalar)), format!("{base}_{field}{size}(x)")));
    let parameter = ty("f32");
    Some(format!(
        "struct {name}{RESULT} {{ {}, {} }}\nfn {name}(x: {parameter}) -> {name}{RESULT} {{\n    return {name}{RESULT}({}, {});\n}}",
        first.0, second.0, first.1, second.1
    ))
}

/// How the name of such a struct ends. WGSL has no name for the one that users' code takes it for.
const RESULT: &str = "_result";

/// A function of matrices: sums and products in a fixed order, of their columns.
fn of_matrices(name: &str) -> Option<String> {
    let mut words = name.strip_prefix("wgsl_")?.split('_');
    let (base, types) = (words.next()?, words.collect::<Vec<_>>());
    let sizes = |ty: &str| {
        let (columns, rows) = ty.strip_prefix("mat")?.split_once('x')?;
        Some([columns.parse::<usize>().ok()?, rows.parse::<usize>().ok()?])
    };
    let full = |ty: &str| {
        if ty == "f32" {
            ty.to_owned()
        } else {
            format!("{ty}<f32>")
        }
    };
    let listed = |ty: String, count: usize, each: &dyn Fn(usize) -> String| {
        let all: Vec<_> = (0..count).map(each).collect();
        (ty.clone(), format!("{ty}({})", all.join(", ")))
    };
    let components = ["x", "y", "z", "w"];
    let (result, value) = match (base, types.as_slice()) {
        ("transpose", [a]) => {
            let [columns, rows] = sizes(a)?;
            listed(format!("mat{rows}x{columns}<f32>"), rows, &|row| {
                let column = |column: usize| format!("a[{column}].{}", components[row]);
                listed(format!("vec{columns}<f32>"), columns, &column).1
            })
        }
        ("add" | "subtract", [a, _]) => {
            let with = if base == "add" { '+' } else { '-' };
            listed(full(a), sizes(a)?[0], &|column| {
                format!("a[{column}] {with} b[{column}]")
            })
        }
        ("multiply", [a, "f32"]) => listed(full(a), sizes(a)?[0], &|column| format!("a[{column}] * b")),
        ("multiply", ["f32", b]) => listed(full(b), sizes(b)?[0], &|column| format!("a * b[{column}]")),
        ("multiply", [a, b]) => match (sizes(a), sizes(b)) {
            (Some([_, rows]), Some([columns, inner])) => {
                listed(format!("mat{columns}x{rows}<f32>"), columns, &|column| {
                    format!("wgsl_multiply_{a}_vec{inner}(a, b[{column}])")
                })
            }
            (Some([columns, rows]), None) => {
                let products: Vec<_> = (0..columns)
                    .map(|at| format!("a[{at}] * b.{}", components[at]))
                    .collect();
                (format!("vec{rows}<f32>"), products.join(" + "))
            }
            (None, Some([columns, rows])) => listed(format!("vec{columns}<f32>"), columns, &|column| {
                format!("wgsl_dot_vec{rows}(a, b[{column}])")
            }),
            _ => return None,
        },
        _ => return None,
    };
    let parameters: Vec<_> = ["a", "b"]
        .iter()
        .zip(&types)
        .map(|(name, ty)| format!("{name}: {}", full(ty)))
        .collect();
    let parameters = parameters.join(", ");
    Some(format!(
        "fn {name}({parameters}) -> {result} {{\n    return {value};\n}}"
    ))
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
        "wgsl_refract" => {
            let parameters = format!("a: {ty}, b: {ty}, ratio: f32");
            let value = format!("select({ty}(), ratio * a - (ratio * d + wgsl_sqrt(max(k, 0.0f))) * b, k >= 0.0f)");
            let k = "let k = 1.0f - ratio * ratio * (1.0f - d * d)";
            return format!(
                "fn {name}({parameters}) -> {ty} {{\n    let d = {dot}(b, a);\n    {k};\n    return {value};\n}}"
            );
        }
        "wgsl_faceForward" => (
            format!("a: {ty}, b: {ty}, c: {ty}"),
            ty.clone(),
            format!("select(-a, a, {dot}(b, c) < 0.0f)"),
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
            let (head, result) = head
                .and_then(|(_, rest)| rest.split_once(") -> "))
                .expect("the library has it");
            let result = result.split_once(' ').map_or(result, |(result, _)| result);
            let ty = format!("vec{size}<{result}>");
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
