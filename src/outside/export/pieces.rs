//! What all printed controllers have: the fields of their state, their tables, and what the comment at the top says.

use std::collections::BTreeSet;

use oneiro_shader_compiler::language::{Language, Memory};
use oneiro_shader_compiler::tree::Ty;

use super::{Controller, Table};
use crate::parts::compose::{HEAD, Scalar};

/// A field of the state: its place in the words of a [`State`], its name and its type.
pub(super) struct Field {
    pub(super) word: usize,
    pub(super) name: String,
    pub(super) ty: Ty,
}

pub(super) fn full_speed(controller: &Controller) -> String {
    match controller.full_speed {
        Some(speed) => format!("{speed} mm/s, the robot's full speed"),
        None => "the robot's full speed".to_owned(),
    }
}

/// What a file's comment at the top says, without what makes it one.
pub(super) fn head(controller: &Controller, name: &str, origin: &[String]) -> Vec<String> {
    let mut lines = vec![format!(
        "{name}: a controller ({}), made by Oneiro {}.",
        controller.kind,
        env!("CARGO_PKG_VERSION")
    )];
    lines.extend(origin.iter().cloned());
    lines.extend([String::new(), "Inputs, in order:".to_owned()]);
    let inputs = controller.inputs.iter().enumerate();
    lines.extend(inputs.map(|(index, input)| format!("  {index}: {}, {}", input.name, input.about)));
    lines.push(
        "Outputs: commands of the left and the right wheel, from 0, full speed backwards, to 1, full speed forwards."
            .to_owned(),
    );
    lines.push("Genes:".to_owned());
    lines.extend(
        controller
            .genes
            .iter()
            .map(|(name, gene)| format!("  {name} = {gene:?}")),
    );
    lines.iter().map(|line| line.replace(['\r', '\n'], " ")).collect()
}

/// The fields of the state: the number of the cycle, and the others that the controller asks for.
pub(super) fn fields(controller: &Controller) -> Vec<Field> {
    let is_kept = [
        controller.draws(),
        controller.draws(),
        controller.asks_for_trial(),
        true,
    ];
    let head = HEAD.iter().zip(is_kept).enumerate();
    let mut taken: BTreeSet<String> = HEAD.iter().map(|name| (*name).to_owned()).collect();
    let mut fields: Vec<Field> = head
        .filter(|(_, (_, is_kept))| *is_kept)
        .map(|(word, (name, _))| Field {
            word,
            name: (*name).to_owned(),
            ty: Ty::U32,
        })
        .collect();
    for (at, (name, scalar)) in controller.memory.iter().enumerate() {
        // Names of WGSL may be words of another language, or of a printed file.
        let mut name = name.replace('.', "_");
        if KEYWORDS.split_whitespace().any(|word| word == name) || !name.is_ascii() {
            name = format!("memory_{at}");
        }
        while !taken.insert(name.clone()) {
            name += "_";
        }
        fields.push(Field {
            word: HEAD.len() + at,
            name,
            ty: match scalar {
                Scalar::Float => Ty::F32,
                Scalar::Unsigned => Ty::U32,
                Scalar::Signed => Ty::I32,
            },
        });
    }
    fields
}

/// Words of languages and printed files that a field of a controller's memory may have as its name.
pub(super) const KEYWORDS: &str = "abstract alignas alignof and and_eq as asm assert async auto await become bitand bitor bool box break case catch \
                        char check class compl const constexpr continue crate debugger decltype def default del delete do double \
                        dynamic_cast elif else elseif end enum except explicit export extends extern final finally float fn for friend \
                        from function global goto if impl implements import in inline instanceof int int32_t interface is lambda let \
                        local long loop macro match mod move mut mutable namespace new nil nonlocal noexcept not not_eq null nullptr \
                        operator or or_eq override package pass priv private protected pub public raise ref register repeat reset \
                        restore restrict return self short signed sizeof static static_assert step struct super switch template then \
                        this thread_local throw trait true try type typedef typeid typename typeof uint32_t union unsafe unsigned \
                        unsized until use using var virtual void volatile wchar_t wheels where while with words xor xor_eq yield";

/// Names of the caller's words in the functions, and their types; `state` begins those of the state.
pub(super) fn places(
    controller: &Controller,
    fields: &[Field],
    language: &dyn Language,
    state: &str,
) -> Vec<(String, Ty)> {
    let mut places: Vec<(String, Ty)> = vec![(String::new(), Ty::U32); HEAD.len() + controller.memory.len()];
    for field in fields {
        places[field.word] = (format!("{state}{}", field.name), field.ty);
    }
    let element = |array: &str, index: usize| (language.element(array, &index.to_string()), Ty::F32);
    places.extend((0..controller.inputs.len()).map(|input| element("inputs", input)));
    places.extend(
        [("outputs", 0), ("outputs", 1), ("speeds", 0), ("speeds", 1)].map(|(array, index)| element(array, index)),
    );
    places
}

/// Whether a field is a number that an episode begins with.
pub(super) fn is_seed(field: &Field) -> bool {
    HEAD[..3].contains(&field.name.as_str())
}

/// The last buffer is the caller's.
pub(super) fn buffers(tables: &[Table], name: &str, places: &[(String, Ty)]) -> Vec<Memory> {
    let table = |table: &Table| {
        let elements = (table.words.len() as u32).checked_div(table.stride).unwrap_or(0);
        Memory::Constants(format!("{name}_{}", name_of(table)), elements)
    };
    let (_, others) = tables.split_last().expect("a kernel has buffers");
    others
        .iter()
        .map(table)
        .chain([Memory::Places(places.to_vec())])
        .collect()
}

pub(super) fn name_of(table: &Table) -> &str {
    if table.name == "inputs" { "genes" } else { &table.name }
}
