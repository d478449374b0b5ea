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
                op, lhs_type, rhs_type, ..
            } => {
                let (left, right) = (self.inner(lhs_type), self.inner(rhs_type));
                let hint = conversion(&left, &right);
                let operator = sign(*op);
                format!("`{operator}` takes operands of one type; here they are {left} and {right}{hint}")
            }
            ExpressionError::SelectValuesTypeMismatch { accept, reject } => {
                let (reject, accept) = (self.inner(reject), self.inner(accept));
                let hint = conversion(&reject, &accept);
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

/// How to make one of two types the other, if that is all.
fn conversion(one: &str, other: &str) -> String {
    let is_integer = |ty: &str| ["i32", "u32"].contains(&ty);
    match (one, other) {
        ("f32", integer) | (integer, "f32") if is_integer(integer) => {
            format!("; write `f32(x)` for the {integer}, or `1.0f` for a constant")
        }
        ("i32", "u32") | ("u32", "i32") => "; write `u32(x)`, or `1u` for a constant".to_owned(),
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
