//! Plain words for the mistakes that naga finds most often.

use naga::common::DiagnosticDisplay;
use naga::front::Typifier;
use naga::proc::{ResolveContext, TypeResolution};
use naga::valid::{
    CallError, ComposeError, EntryPointError, ExpressionError, FunctionError, TypeError, ValidationError,
};
use naga::{
    BinaryOperator, Block, Expression, Function, Handle, Module, Span, Statement, Type, TypeInner, UnaryOperator,
};

/// How a module has the operators `&&` and `||`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Logic {
    /// As branches, as naga makes them.
    AsWritten,
    /// As `&` and `|`, which stand for `&&` and `||`.
    AsBits,
}

/// Whether the mistake is a value that is stored in a variable of another type, which naga also says of `a && b` if `b` is no bool.
pub(crate) fn stores_another_type(error: &ValidationError) -> bool {
    let (ValidationError::Function { source, .. }
    | ValidationError::EntryPoint {
        source: EntryPointError::Function(source),
        ..
    }) = error
    else {
        return false;
    };
    matches!(source, FunctionError::InvalidStoreTypes { .. })
}

/// Where a function returns a value of another type than its head says. Naga only says where that value was computed.
pub(crate) fn returns_another_type(module: &Module, error: &ValidationError) -> Option<Span> {
    let ValidationError::Function {
        handle,
        source: FunctionError::InvalidReturnType {
            expression: Some(value),
            ..
        },
        ..
    } = error
    else {
        return None;
    };
    returned(&module.functions[*handle].body, *value)
}

/// The `return` of a value in a block.
fn returned(block: &Block, value: Handle<Expression>) -> Option<Span> {
    block.span_iter().find_map(|(statement, span)| match statement {
        Statement::Return { value: Some(returned) } => (*returned == value).then_some(*span),
        Statement::Block(block) => returned(block, value),
        Statement::If { accept, reject, .. } => returned(accept, value).or_else(|| returned(reject, value)),
        Statement::Loop { body, continuing, .. } => returned(body, value).or_else(|| returned(continuing, value)),
        Statement::Switch { cases, .. } => cases.iter().find_map(|case| returned(&case.body, value)),
        _ => None,
    })
}

/// What is wrong and what to write instead; `None` for mistakes that naga's own message must do for.
pub(crate) fn explained(module: &Module, error: &ValidationError, logic: Logic) -> Option<String> {
    match error {
        ValidationError::Type {
            name,
            source: TypeError::EmptyStruct,
            ..
        } => Some(format!("`{name}` has no field; write one, or leave the struct out")),
        ValidationError::Function { handle, name, source } => {
            if is_abstract(source) {
                return Some(format!("in `{name}`: {ABSTRACT}"));
            }
            let problem = Types::of(module, &module.functions[*handle], logic)?.explained(source)?;
            Some(format!("in `{name}`: {problem}"))
        }
        _ => None,
    }
}

/// What to write where naga finds no type for numbers without one.
pub(crate) const ABSTRACT: &str =
    "none of the numbers that a function is given here has a type; write one as `0.5f`, or `1u`";

/// Whether the mistake is a constant without a type, such as `0.5`, where naga finds none for it.
fn is_abstract(error: &FunctionError) -> bool {
    let mut cause: Option<&dyn std::error::Error> = Some(error);
    std::iter::from_fn(|| {
        let this = cause?;
        cause = this.source();
        Some(this.to_string())
    })
    .any(|text| text.contains("Abstract types"))
}

/// The types of a function's expressions.
struct Types<'a> {
    module: &'a Module,
    function: &'a Function,
    logic: Logic,
    typifier: Typifier,
}

impl<'a> Types<'a> {
    fn of(module: &'a Module, function: &'a Function, logic: Logic) -> Option<Self> {
        let context = ResolveContext::with_locals(module, &function.local_variables, &function.arguments);
        let mut typifier = Typifier::new();
        for (handle, _) in function.expressions.iter() {
            typifier.grow(handle, &function.expressions, &context).ok()?;
        }
        Some(Self {
            module,
            function,
            logic,
            typifier,
        })
    }

    /// A type's name in WGSL.
    fn name(&self, ty: Handle<Type>) -> String {
        DiagnosticDisplay((ty, self.module.to_ctx())).to_string()
    }

    /// The name of an expression's type.
    fn found(&self, expression: Handle<Expression>) -> String {
        self.resolved(&self.typifier[expression])
    }

    fn resolved(&self, ty: &TypeResolution) -> String {
        DiagnosticDisplay((ty, self.module.to_ctx())).to_string()
    }

    fn inner(&self, inner: &TypeInner) -> String {
        self.resolved(&TypeResolution::Value(inner.clone()))
    }

    fn explained(&self, error: &FunctionError) -> Option<String> {
        Some(match error {
            FunctionError::InvalidReturnType {
                expression: None,
                expected_ty: Some(expected),
            } => format!(
                "it can end without a result; write `return VALUE;`, of type {}",
                self.name(*expected)
            ),
            FunctionError::InvalidReturnType {
                expression: Some(found),
                expected_ty: Some(expected),
            } => format!("returns {}; its head says {}", self.found(*found), self.name(*expected)),
            FunctionError::InvalidReturnType {
                expression: Some(found),
                expected_ty: None,
            } => {
                let found = self.found(*found);
                format!("returns {found}; its head says nothing: write `-> {found}`")
            }
            FunctionError::InvalidCall { function, error } => {
                let function = &self.module.functions[*function];
                let called = function.name.as_deref().unwrap_or("the function");
                match error {
                    CallError::ArgumentCount { required, seen } => {
                        let names = function
                            .arguments
                            .iter()
                            .filter_map(|argument| argument.name.as_deref());
                        let names = names.collect::<Vec<_>>().join(", ");
                        let noun = if *required == 1 { "argument" } else { "arguments" };
                        format!("`{called}` takes {required} {noun}, and is given {seen}; write `{called}({names})`")
                    }
                    CallError::ArgumentType {
                        index,
                        required,
                        seen_expression,
                    } => {
                        let (found, required) = (self.found(*seen_expression), self.name(*required));
                        let hint = conversion(&found, &required);
                        format!(
                            "argument {} of `{called}` is {found}; allowed: {required}{hint}",
                            index + 1
                        )
                    }
                    _ => return None,
                }
            }
            FunctionError::InvalidIfType(condition) => {
                format!("the condition of `if` is {}; allowed: bool", self.found(*condition))
            }
            FunctionError::InvalidStoreTypes { pointer, value } => {
                let found = self.found(*value);
                let TypeInner::Pointer { base, .. } = *self.typifier[*pointer].inner_with(&self.module.types) else {
                    return None;
                };
                let allowed = self.name(base);
                let hint = conversion(&found, &allowed);
                format!("the value is {found}; allowed: {allowed}{hint}")
            }
            FunctionError::MissingDefaultCase => {
                "a `switch` says what to do in all other cases; write `default: { .. }`".to_owned()
            }
            FunctionError::Expression { handle, source } => return self.expression(*handle, source),
            _ => return None,
        })
    }

    fn expression(&self, handle: Handle<Expression>, error: &ExpressionError) -> Option<String> {
        Some(match error {
            ExpressionError::InvalidBinaryOperandTypes {
                op,
                lhs_expr,
                lhs_type,
                rhs_expr,
                rhs_type,
            } => {
                let (left, right) = (self.inner(lhs_type), self.inner(rhs_type));
                let is_constant = |operand: &Handle<Expression>| {
                    matches!(self.function.expressions[*operand], Expression::Literal(_))
                };
                if let Some(logical) = logical(*op).filter(|_| self.logic == Logic::AsBits) {
                    let not_bool = if left == "bool" { &right } else { &left };
                    let hint = conversion(not_bool, "bool");
                    return Some(format!(
                        "`{logical}` takes two bools; here they are {left} and {right}{hint}"
                    ));
                }
                let operator = sign(*op);
                let is_of_bits = ["&", "|", "^", "<<", ">>"].contains(&operator);
                if is_of_bits && [&left, &right].iter().any(|ty| ty.contains("f32")) {
                    let hint = if operator == "^" {
                        "; write `x * x` for a square"
                    } else {
                        ""
                    };
                    return Some(format!(
                        "`{operator}` takes integers; here they are {left} and {right}{hint}"
                    ));
                }
                let hint = if left == "bool" && ["<", "<=", ">", ">="].contains(&operator) {
                    format!("; write `a {operator} b && b {operator} c`")
                } else {
                    let needed = match (is_constant(lhs_expr), is_constant(rhs_expr)) {
                        (false, true) if left != "i32" => &left,
                        (true, false) if right != "i32" => &right,
                        _ => "",
                    };
                    let of_type = |one| format!("; a constant of type {needed} is written `{one}`");
                    constant(needed).map_or_else(|| alike(&left, &right), of_type)
                };
                format!("`{operator}` takes operands of one type; here they are {left} and {right}{hint}")
            }
            ExpressionError::SelectValuesTypeMismatch { accept, reject } => {
                let (reject, accept) = (self.inner(reject), self.inner(accept));
                let hint = alike(&reject, &accept);
                format!("`select` chooses between {reject} and {accept}; allowed: one type{hint}")
            }
            ExpressionError::SelectConditionNotABool { actual } => format!(
                "`select` chooses by {}; allowed: bool, as the last of its three arguments",
                self.inner(actual)
            ),
            ExpressionError::InvalidUnaryOperandType(op, operand) => {
                let found = self.found(*operand);
                match op {
                    UnaryOperator::LogicalNot => {
                        let zero = constant(&found).map(|one| one.replacen('1', "0", 1));
                        let hint = zero.map_or_else(String::new, |zero| format!("; write `x == {zero}`"));
                        format!("`!` takes a bool; here it is {found}{hint}")
                    }
                    UnaryOperator::Negate => format!("`-` takes f32, i32 or a vector of them; here it is {found}"),
                    UnaryOperator::BitwiseNot => format!("`~` takes an integer; here it is {found}"),
                }
            }
            ExpressionError::InvalidIndexType(index) => {
                let found = self.found(*index);
                let hint = if found == "f32" { "; write `u32(x)`" } else { "" };
                format!("an index is {found}; allowed: u32 or i32{hint}")
            }
            ExpressionError::IndexOutOfBounds(_, index) => format!("the index {index} is beyond the last element"),
            ExpressionError::ShiftAmountTooLarge { .. } => {
                "a constant number of bits to shift by is at most 31".to_owned()
            }
            ExpressionError::Compose(error) => return self.composed(handle, error),
            _ => return None,
        })
    }

    /// A struct or vector with the wrong values.
    fn composed(&self, handle: Handle<Expression>, error: &ComposeError) -> Option<String> {
        let Expression::Compose { ty, components } = &self.function.expressions[handle] else {
            return None;
        };
        let name = self.name(*ty);
        let members = match &self.module.types[*ty].inner {
            TypeInner::Struct { members, .. } => &members[..],
            _ => &[],
        };
        let fields: Vec<_> = members
            .iter()
            .map(|member| {
                format!(
                    "{}: {}",
                    member.name.as_deref().unwrap_or_default(),
                    self.name(member.ty)
                )
            })
            .collect();
        Some(match error {
            ComposeError::ComponentCount { given, expected } => {
                let allowed = if fields.is_empty() {
                    String::new()
                } else {
                    format!("; allowed: {}", fields.join(", "))
                };
                format!("`{name}` is made of {expected} values, and is given {given}{allowed}")
            }
            ComposeError::ComponentType { index } => {
                let found = self.found(*components.get(*index as usize)?);
                let allowed = fields.get(*index as usize)?;
                let hint = conversion(&found, allowed.rsplit(' ').next().unwrap_or_default());
                format!("value {} of `{name}` is {found}; allowed: {allowed}{hint}", index + 1)
            }
            ComposeError::Type(_) => return None,
        })
    }
}

/// A constant of a type.
fn constant(ty: &str) -> Option<&'static str> {
    [("f32", "1.0f"), ("u32", "1u"), ("i32", "1")]
        .into_iter()
        .find_map(|(name, constant)| (name == ty).then_some(constant))
}

/// The conversion to write if a value only has the wrong type; else nothing.
pub(crate) fn conversion(found: &str, needed: &str) -> String {
    match (constant(found), constant(needed)) {
        (Some(_), Some(one)) => format!("; write `{needed}(x)`, or `{one}` for a constant"),
        (None, Some(one)) if found == "bool" => {
            format!("; write `select({}, {one}, x)`", one.replacen('1', "0", 1))
        }
        (Some(one), None) if needed == "bool" => format!("; write `x != {}`", one.replacen('1', "0", 1)),
        _ => String::new(),
    }
}

/// How to make operands of two types those of one.
pub(crate) fn alike(one: &str, other: &str) -> String {
    match (one, other) {
        ("f32", integer @ ("i32" | "u32")) | (integer @ ("i32" | "u32"), "f32") => {
            format!("; write `f32(x)` for the {integer}, or `1.0f` for a constant")
        }
        ("bool", number) | (number, "bool") if constant(number).is_some() => {
            conversion("bool", number) + " for the bool"
        }
        ("i32", "u32") | ("u32", "i32") => conversion("i32", "u32"),
        _ => String::new(),
    }
}

/// The logical operator that an operator on bits may stand for.
fn logical(op: BinaryOperator) -> Option<&'static str> {
    match op {
        BinaryOperator::And => Some("&&"),
        BinaryOperator::InclusiveOr => Some("||"),
        _ => None,
    }
}

/// An operator in WGSL.
fn sign(op: BinaryOperator) -> &'static str {
    match op {
        BinaryOperator::Add => "+",
        BinaryOperator::Subtract => "-",
        BinaryOperator::Multiply => "*",
        BinaryOperator::Divide => "/",
        BinaryOperator::Modulo => "%",
        BinaryOperator::Equal => "==",
        BinaryOperator::NotEqual => "!=",
        BinaryOperator::Less => "<",
        BinaryOperator::LessEqual => "<=",
        BinaryOperator::Greater => ">",
        BinaryOperator::GreaterEqual => ">=",
        BinaryOperator::And => "&",
        BinaryOperator::ExclusiveOr => "^",
        BinaryOperator::InclusiveOr => "|",
        BinaryOperator::LogicalAnd => "&&",
        BinaryOperator::LogicalOr => "||",
        BinaryOperator::ShiftLeft => "<<",
        BinaryOperator::ShiftRight => ">>",
    }
}
