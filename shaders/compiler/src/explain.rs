//! Plain words for the mistakes that naga finds most often.

use naga::common::DiagnosticDisplay;
use naga::front::Typifier;
use naga::proc::{ResolveContext, TypeResolution};
use naga::valid::{CallError, ComposeError, ExpressionError, FunctionError, TypeError, ValidationError};
use naga::{BinaryOperator, Expression, Function, Handle, Module, Type, TypeInner};

/// What is wrong and what to write instead; `None` for mistakes that naga's own message must do for.
pub(crate) fn explained(module: &Module, error: &ValidationError) -> Option<String> {
    match error {
        ValidationError::Type {
            name,
            source: TypeError::EmptyStruct,
            ..
        } => Some(format!("`{name}` has no field; write one, or leave the struct out")),
        ValidationError::Function { handle, name, source } => {
            let problem = Types::of(module, &module.functions[*handle])?.explained(source)?;
            Some(format!("in `{name}`: {problem}"))
        }
        _ => None,
    }
}

/// The types of a function's expressions.
struct Types<'a> {
    module: &'a Module,
    function: &'a Function,
    typifier: Typifier,
}

impl<'a> Types<'a> {
    fn of(module: &'a Module, function: &'a Function) -> Option<Self> {
        let context = ResolveContext::with_locals(module, &function.local_variables, &function.arguments);
        let mut typifier = Typifier::new();
        for (handle, _) in function.expressions.iter() {
            typifier.grow(handle, &function.expressions, &context).ok()?;
        }
        Some(Self {
            module,
            function,
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
                let called = self.module.functions[*function]
                    .name
                    .as_deref()
                    .unwrap_or("the function");
                match error {
                    CallError::ArgumentCount { required, seen } => {
                        format!("`{called}` takes {required} arguments, and is given {seen}")
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
                let operator = sign(*op);
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
            ExpressionError::Compose(error) => return self.composed(handle, error),
            _ => return None,
        })
    }

    /// A struct or vector that is made of the wrong values.
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
        .find_map(|(own, constant)| (own == ty).then_some(constant))
}

/// What to write for a value of one type where another is needed, if that is all; else nothing.
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
fn alike(one: &str, other: &str) -> String {
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
/// An operator as it is written.
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
