//! What a part may declare and use.

use std::collections::BTreeSet;

use oneiro_shader_compiler as compiler;
use oneiro_shader_compiler::declarations::{Declaration, access_of, calls, declarations, signature, use_of};
use oneiro_shaders::{KERNELS, LIFE_PERCEPTRON, PARTS};

use super::interface::{Function, Interface};
use super::{generate, kernel};

/// Functions of shipped parts that every part may call; `lib/numerics`, `lib/random` and `lib/user` have them.
const CALLS: [&str; 15] = [
    "reciprocal",
    "root",
    "reciprocal_root",
    "exponential",
    "logarithm",
    "logistic",
    "hyperbolic_tangent",
    "flushed",
    "cosine_sine",
    "direction",
    "squared_length",
    "highest",
    "random",
    "blocked",
    "distance_along",
];
/// Fields that identify a rollout in its batch. What depends on them would depend on what else is in the batch.
const PLACES_IN_THE_BATCH: [&str; 2] = ["world", "genes"];

/// Everything that is wrong with what a part declares and uses, given what is generated for it.
pub(super) fn problems(
    part: &compiler::Part,
    interface: &Interface,
    declared: &[Declaration],
    generated: &str,
) -> Vec<String> {
    let mut taken = shipped_names();
    let calls = used_problems(part, interface, &taken);
    taken.extend(names(kernel::GENERATED, generated));
    taken.extend(generate::COUNTS.map(str::to_owned));
    let mut problems = declared_problems(part, interface, declared, &taken);
    problems.extend(calls);
    problems
}

/// Names that the shipped parts declare which users' parts are composed with.
fn shipped_names() -> BTreeSet<String> {
    let is_composed = |path: &&str| {
        let life = |name: &str| name.starts_with("life_") || name.starts_with("surrogate_");
        let mut kernels = KERNELS.iter().filter(|kernel| life(kernel.name));
        let ships = KERNELS.iter().any(|kernel| kernel.parts.contains(path));
        !ships || kernels.any(|kernel| kernel.parts.contains(path))
    };
    let shipped = PARTS.iter().filter(|(path, _)| is_composed(path));
    shipped.flat_map(|(path, text)| names(path, text)).collect()
}

/// Names that a part declares.
fn names(path: &str, text: &str) -> impl Iterator<Item = String> {
    let part = compiler::Part {
        path: path.to_owned(),
        text: text.to_owned(),
    };
    declarations(&part).into_iter().map(|declaration| declaration.name)
}

/// Problems with what a part declares or doesn't declare. `taken` are the names of the rest of the kernel.
fn declared_problems(
    part: &compiler::Part,
    interface: &Interface,
    declared: &[Declaration],
    taken: &BTreeSet<String>,
) -> Vec<String> {
    let path = &part.path;
    let mut problems = Vec::new();
    for required in interface.functions.iter().filter(|function| function.default.is_none()) {
        if declared.iter().all(|own| own.name != required.name()) {
            let (name, text) = (required.name(), required.text);
            problems.push(format!("{path}: has no function `{name}`; write `{text} {{ .. }}`"));
        }
    }
    for (name, form) in interface.others {
        if declared.iter().all(|own| own.name != *name) {
            problems.push(format!("{path}: has no `{name}`; write `{form}`"));
        }
    }
    for own in declared {
        let Declaration {
            keyword,
            name,
            place,
            signature: has,
        } = own;
        let expected = interface.functions.iter().find(|function| function.name() == name);
        let form = interface.others.iter().find(|(other, _)| other == name);
        if let Some((_, form)) = form
            && (!form.starts_with(keyword.as_str()) || keyword == "const" && has != "u32")
        {
            problems.push(format!("{place}: `{name}` is declared otherwise; write `{form}`"));
        } else if keyword == "var" {
            problems.push(format!(
                "{place}: declares a buffer or a global variable; allowed: structs, constants and functions, and memory in \
                 `{}State`",
                interface.title
            ));
        } else if let Some(Function { text, .. }) = expected {
            let wanted = text
                .split_once('(')
                .map(|(_, rest)| signature(&format!("({rest}")))
                .unwrap_or_default();
            if keyword != "fn" || *has != wanted {
                problems.push(format!(
                    "{place}: `{name}` has other parameters or another result; write `{text}`"
                ));
            }
        } else if form.is_none() && !interface.structs.contains(&name.as_str()) && taken.contains(name) {
            problems.push(format!("{place}: `{name}` is a name of Oneiro's; choose another"));
        }
    }
    problems
}

/// Problems with what a part uses of the rest of the kernel.
fn used_problems(part: &compiler::Part, interface: &Interface, taken: &BTreeSet<String>) -> Vec<String> {
    let mut problems = Vec::new();
    let buffers: Vec<_> = LIFE_PERCEPTRON.bindings.iter().map(|binding| binding.name).collect();
    if let Some((place, name)) = use_of(part, &buffers) {
        problems.push(format!(
            "{place}: `{name}` is a buffer of the kernel's; choose another name for your own"
        ));
    }
    if let Some((place, name)) = access_of(part, &PLACES_IN_THE_BATCH) {
        problems.push(format!(
            "{place}: `.{name}` of a life is only for the kernel: pass `life` itself on, and choose other names for fields of \
             your own"
        ));
    }
    for (name, place) in calls(part) {
        let is_allowed = [&CALLS, interface.calls, interface.structs]
            .iter()
            .any(|list| list.contains(&name.as_str()));
        if !is_allowed && taken.contains(&name) {
            let allowed = CALLS
                .iter()
                .chain(interface.calls)
                .copied()
                .collect::<Vec<_>>()
                .join(", ");
            problems.push(format!(
                "{place}: `{name}` can't be called from here; allowed: {allowed}, and your own functions"
            ));
        }
    }
    problems
}
