//! What a user's parts may do with the rest of a kernel and with the bits of floats, checked on the compiled form: whatever naga takes
//! for a blank, an alias or a name, an expression has a type, and a call has a function.

use std::collections::BTreeSet;

use naga::proc::TypeResolution;
use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{Binding, Expression, Function, Handle, Module, ScalarKind, Span, Statement, Type, TypeInner};

use crate::rules::Rule;
use crate::source::{Refusal, Refusals, Source};

/// How the parts of users are separated from the other parts of a kernel. By default there are none.
#[derive(Clone, Copy, Debug, Default)]
pub struct Isolation<'a> {
    /// The struct that says which episode a function works for. Users' functions pass it on unchanged.
    pub episode: &'a str,
    /// For each part of the kernel, in order, what is allowed if it is a user's; `None` for others. If this is empty, none is.
    pub users: &'a [Option<Allowed<'a>>],
}

/// What a user's part may share with the parts that aren't users'.
#[derive(Clone, Debug, Default)]
pub struct Allowed<'a> {
    /// Their functions that it may call.
    pub calls: BTreeSet<&'a str>,
    /// Its functions that they call.
    pub called: BTreeSet<&'a str>,
}

/// Everything in a kernel by which a user's part could reach another episode.
pub(crate) fn check(isolation: &Isolation<'_>, source: &Source, module: &Module, info: &ModuleInfo) -> Refusals {
    if isolation.users.is_empty() {
        return Refusals::new();
    }
    let mut checker = Checker {
        isolation,
        source,
        module,
        carriers: carriers(isolation.episode, module),
        refusals: Refusals::new(),
    };
    checker.check_declarations();
    for (handle, function) in module.functions.iter() {
        let owner = checker.owner(module.functions.get_span(handle));
        match owner {
            Some(allowed) => checker.check_function(function, &info[handle], allowed),
            None => checker.check_block(&function.body, function.name.as_ref(), None),
        }
    }
    for entry in &module.entry_points {
        checker.check_block(&entry.function.body, entry.function.name.as_ref(), None);
    }
    checker.refusals
}

/// The types that an episode can be in: its own struct, and whatever has or points to one of these.
struct Carriers {
    episode: Option<Handle<Type>>,
    all: BTreeSet<Handle<Type>>,
}

fn carriers(episode: &str, module: &Module) -> Carriers {
    let mut carriers = Carriers {
        episode: None,
        all: BTreeSet::new(),
    };
    // A type only refers to those before it.
    for (handle, ty) in module.types.iter() {
        let is_struct = matches!(ty.inner, TypeInner::Struct { .. });
        if is_struct && ty.name.as_deref() == Some(episode) {
            carriers.episode = Some(handle);
            carriers.all.insert(handle);
        } else if carriers.is_in(&ty.inner) {
            carriers.all.insert(handle);
        }
    }
    carriers
}

impl Carriers {
    /// Whether an episode is in a type, or behind it, other than by itself.
    fn is_in(&self, inner: &TypeInner) -> bool {
        match inner {
            TypeInner::Struct { members, .. } => members.iter().any(|member| self.all.contains(&member.ty)),
            TypeInner::Array { base, .. } | TypeInner::Pointer { base, .. } | TypeInner::BindingArray { base, .. } => {
                self.all.contains(base)
            }
            _ => false,
        }
    }

    fn has(&self, ty: &TypeResolution) -> bool {
        match ty {
            TypeResolution::Handle(handle) => self.all.contains(handle),
            TypeResolution::Value(inner) => self.is_in(inner),
        }
    }

    fn is_episode(&self, ty: &TypeResolution) -> bool {
        matches!(ty, TypeResolution::Handle(handle) if Some(*handle) == self.episode)
    }
}

struct Checker<'a> {
    isolation: &'a Isolation<'a>,
    source: &'a Source,
    module: &'a Module,
    carriers: Carriers,
    refusals: Refusals,
}

impl<'a> Checker<'a> {
    /// The rights of the user's part that a declaration is in; `None` if it is in one of Oneiro's parts. A declaration across the ends of
    /// parts has no rights.
    fn owner(&self, span: Span) -> Option<&'a Allowed<'a>> {
        static NOTHING: Allowed<'static> = Allowed {
            calls: BTreeSet::new(),
            called: BTreeSet::new(),
        };
        let part = self.source.part_of(span);
        match part.and_then(|part| self.isolation.users.get(part)) {
            Some(allowed) => allowed.as_ref(),
            None => Some(&NOTHING),
        }
    }

    fn refuse(&mut self, span: Span, function: Option<&String>, rule: Rule, message: String) {
        self.refusals.push(Refusal {
            place: self.source.place_of(span),
            function: function.cloned(),
            rule,
            message,
        });
    }

    /// Refuses types, constants and variables outside of functions.
    fn check_declarations(&mut self) {
        let module = self.module;
        let episode = self.isolation.episode;
        for (handle, ty) in module.types.iter() {
            let span = module.types.get_span(handle);
            // Types without a name have no place: their values are refused.
            if !span.is_defined() || self.owner(span).is_none() {
                continue;
            }
            if self.carriers.is_in(&ty.inner) {
                let message = format!("a struct can't hold an `{episode}`; give it to each function as a parameter");
                self.refuse(span, None, Rule::EpisodeAsGiven, message);
            }
            if let TypeInner::Struct { members, .. } = &ty.inner
                && members.iter().any(|member| member.binding.is_some())
            {
                self.refuse_binding(span, None);
            }
        }
        for (handle, constant) in module.constants.iter() {
            let span = module.constants.get_span(handle);
            if self.owner(span).is_some() && self.carriers.all.contains(&constant.ty) {
                self.refuse_made(span, None);
            }
        }
        for (handle, _) in module.global_variables.iter() {
            let span = module.global_variables.get_span(handle);
            if self.owner(span).is_some() {
                let message = "a part can't declare a buffer or a variable outside of functions; keep its memory in \
                               its state";
                self.refuse(span, None, Rule::OwnBuffers, message.to_owned());
            }
        }
    }

    fn refuse_made(&mut self, span: Span, function: Option<&String>) {
        let episode = self.isolation.episode;
        let message = format!("an `{episode}` is made here; pass on the one that the function receives");
        self.refuse(span, function, Rule::EpisodeAsGiven, message);
    }

    fn refuse_binding(&mut self, span: Span, function: Option<&String>) {
        let message =
            "`@builtin`, `@location` and the like belong to an entry point, which only Oneiro has; leave them out";
        self.refuse(span, function, Rule::EntryPoint, message.to_owned());
    }

    /// Refuses whatever a user's function does with an episode but pass it on, and what it uses of the kernel.
    fn check_function(&mut self, function: &Function, info: &FunctionInfo, allowed: &Allowed<'_>) {
        let module = self.module;
        let name = function.name.as_ref();
        let bound: Vec<Option<&Binding>> = function
            .arguments
            .iter()
            .map(|argument| argument.binding.as_ref())
            .chain(function.result.iter().map(|result| result.binding.as_ref()))
            .collect();
        if bound.iter().any(Option::is_some) {
            self.refuse_binding(self.span_of(function), name);
        }
        // One such mistake leads to others.
        let before = self.refusals.len();
        for (handle, local) in function.local_variables.iter() {
            if self.carriers.all.contains(&local.ty) {
                let episode = self.isolation.episode;
                let span = function.local_variables.get_span(handle);
                let message = format!("a variable can't hold an `{episode}`; write `let`, or use the parameter");
                self.refuse(span, name, Rule::EpisodeAsGiven, message);
            }
        }
        for (handle, expression) in function.expressions.iter() {
            if self.refusals.len() > before {
                break;
            }
            self.check_expression(handle, expression, function, info);
        }
        let kind = |handle: Handle<Expression>| info[handle].ty.inner_with(&module.types).scalar_kind();
        for (handle, expression) in function.expressions.iter() {
            let place = function.expressions.get_span(handle);
            match expression {
                Expression::GlobalVariable(variable) => {
                    let buffer = module.global_variables[*variable].name.as_deref().unwrap_or_default();
                    let message = format!("`{buffer}` is one of the kernel's buffers; parts can't read or write it");
                    self.refuse(place, name, Rule::KernelBuffers, message);
                }
                Expression::As {
                    expr, convert: None, ..
                } if kind(*expr) == Some(ScalarKind::Float) && kind(handle) != Some(ScalarKind::Float) => {
                    let message = "the bits of a float differ between devices, if it is 0 or not a number; write \
                                   `u32(x)` or `i32(x)` for its value";
                    self.refuse(place, name, Rule::FloatBits, message.to_owned());
                }
                _ => {}
            }
        }
        self.check_block(&function.body, name, Some(allowed));
    }

    /// Refuses an expression that makes an episode, keeps it, or takes it apart.
    fn check_expression(
        &mut self,
        handle: Handle<Expression>,
        expression: &Expression,
        function: &Function,
        info: &FunctionInfo,
    ) {
        let (span, name) = (function.expressions.get_span(handle), function.name.as_ref());
        let episode = self.isolation.episode;
        if let Expression::Access { base, .. } | Expression::AccessIndex { base, .. } = expression
            && self.carriers.has(&info[*base].ty)
        {
            let message = format!("the fields of an `{episode}` are only for Oneiro: pass it on as a whole");
            return self.refuse(span, name, Rule::BatchPlace, message);
        }
        let ty = &info[handle].ty;
        if !self.carriers.has(ty) {
            return;
        }
        let is_passed_on = match expression {
            Expression::FunctionArgument(_) => self.carriers.is_episode(ty),
            Expression::CallResult(called) => {
                let span = self.module.functions.get_span(*called);
                self.carriers.is_episode(ty) && self.owner(span).is_some()
            }
            _ => false,
        };
        if is_passed_on {
            return;
        }
        if matches!(expression, Expression::FunctionArgument(_)) {
            let message =
                format!("this parameter holds an `{episode}`, or points to one; allowed: an `{episode}` itself");
            self.refuse(span, name, Rule::EpisodeAsGiven, message);
        } else {
            self.refuse_made(span, name);
        }
    }

    /// The place of a function of the module.
    fn span_of(&self, function: &Function) -> Span {
        let mut functions = self.module.functions.iter();
        let found = functions.find(|(_, other)| other.name == function.name);
        found.map_or(Span::UNDEFINED, |(handle, _)| self.module.functions.get_span(handle))
    }

    /// Refuses calls between a user's part and the others that aren't on the lists: of those that `allowed` belongs to, or of others.
    fn check_block(&mut self, block: &naga::Block, caller: Option<&String>, allowed: Option<&Allowed<'_>>) {
        for (statement, span) in block.span_iter() {
            match statement {
                Statement::Call { function, .. } => self.check_call(*span, caller, *function, allowed),
                Statement::Block(inner) => self.check_block(inner, caller, allowed),
                Statement::If { accept, reject, .. } => {
                    self.check_block(accept, caller, allowed);
                    self.check_block(reject, caller, allowed);
                }
                Statement::Switch { cases, .. } => {
                    for case in cases {
                        self.check_block(&case.body, caller, allowed);
                    }
                }
                Statement::Loop { body, continuing, .. } => {
                    self.check_block(body, caller, allowed);
                    self.check_block(continuing, caller, allowed);
                }
                // No kernel has other statements.
                _ => {}
            }
        }
    }

    fn check_call(
        &mut self,
        span: Span,
        caller: Option<&String>,
        function: Handle<Function>,
        allowed: Option<&Allowed<'_>>,
    ) {
        let name = self.module.functions[function].name.clone().unwrap_or_default();
        let place = self.module.functions.get_span(function);
        match (allowed, self.owner(place)) {
            (Some(allowed), None) if !allowed.calls.contains(name.as_str()) => {
                let list: Vec<_> = allowed.calls.iter().copied().collect();
                let message = format!("`{name}` can't be called from here; allowed: {}", list.join(", "));
                self.refuse(span, caller, Rule::AllowedCalls, message);
            }
            (None, Some(user)) if !user.called.contains(name.as_str()) => {
                let message = format!("Oneiro's files would call this `{name}` instead of theirs; choose another name");
                self.refuse(place, None, Rule::BuiltInName, message);
            }
            _ => {}
        }
    }
}
