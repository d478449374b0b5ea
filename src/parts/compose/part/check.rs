//! What a part may declare and use.

use std::collections::BTreeSet;
use std::sync::LazyLock;

use oneiro_shader_compiler as compiler;
use oneiro_shader_compiler::declarations::{
    Declaration, accesses, built_in, calls, declarations, indexed, members, names, ordinary, parameters_at, signature,
    uses, word_at,
};
use oneiro_shader_compiler::{Allowed, Place, Refusal, Refusals, Rule};
use oneiro_shader_parts::PARTS;
use oneiro_shaders::{KERNELS, LIFE_PERCEPTRON};

use super::fields::GeneField;
use super::interface::{self, Function, GENE_COUNT, GENES, Interface};
use super::{generate, kernel, refusal};
use crate::parameter::nearest;
use crate::parts::compose::{Kind, OF_EACH, OwnParts};

/// Functions of shipped parts that every part may call; `lib/numerics`, `lib/random`, `lib/user` and `lib/given` have them.
const CALLS: [&str; 36] = [
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
    generate::READING,
    "random",
    "blocked",
    "distance_along",
    "cycles",
    "body_radius",
    "arena_lights",
    "arena_light",
    "arena_patches",
    "arena_patch",
    "arena_walls",
    "arena_wall",
    "arena_obstacles",
    "arena_obstacle",
    "arena_blocks",
    "arena_block",
    "arena_field",
    "on_patch",
    "on_other_patch",
    "floor_at",
    "clearance",
    "trial",
    "robots",
    "robot_number",
];
/// Those that a part may declare itself, for all parts of its experiment. No function that stands for ordinary WGSL calls them.
const REPLACEABLE: [&str; 12] = [
    "floor_at",
    "on_patch",
    "on_other_patch",
    "clearance",
    "trial",
    "logistic",
    "hyperbolic_tangent",
    "flushed",
    "cosine_sine",
    "direction",
    "squared_length",
    "highest",
];
/// Functions that are generated for parts with values.
const VALUES: [&str; 3] = ["sensor_values", "controller_values", "task_values"];
/// Fields that identify an episode in its batch. Results that depend on them would depend on the rest of the batch.
const PLACES_IN_THE_BATCH: [&str; 2] = ["world", "genes"];
/// What to write where a part asks for another's memory.
const NO_MEMORY: &str = "no part can read another's memory; make what is shared a reading of the sensors, and read it as \
    `now.real.own.NAME` in a task or as `readings.own.NAME` in a controller";
/// Structs and constants of the kernel that parts use.
const STRUCTS: [&str; 12] = [
    "Experience",
    "Readings",
    "Motion",
    "Sensed",
    "Command",
    "Reward",
    "ArenaLight",
    "ArenaPatch",
    "ArenaWall",
    "ArenaObstacle",
    "ArenaBlock",
    "ArenaField",
];
const CONSTANTS: [&str; 4] = ["INPUTS", "STREAM_TASK", "STREAM_CONTROLLER", "STREAM_OWN_SENSOR"];

/// What a user's part of a kind may share with the rest of the kernel.
pub(super) fn allowed(kind: Kind) -> Allowed<'static> {
    let interface = interface::of(kind);
    Allowed {
        calls: [&CALLS[..], &TOGETHER, &VALUES, interface.calls]
            .concat()
            .into_iter()
            .collect(),
        called: interface.known().map(Function::name).collect(),
    }
}

/// Whether a part may declare something although Oneiro's files have the same name for a function or a constant: they rename theirs.
pub(super) fn gives_way(item: &Declaration) -> bool {
    ["fn", "const"].contains(&item.keyword.as_str()) && names_that_give_way().contains(&item.name)
}

/// All names of these functions and constants.
pub(super) fn names_that_give_way() -> &'static BTreeSet<String> {
    static NAMES: LazyLock<BTreeSet<String>> = LazyLock::new(|| {
        let is_of_kernels = |(path, _): &&(&str, &str)| *path != "lib/ordinary.wgsl";
        let of_part = |(path, text): &(&str, &str)| {
            let part = compiler::Part {
                path: (*path).to_owned(),
                text: (*text).to_owned(),
            };
            let items = declarations(&part).into_iter();
            items.filter(|item| ["fn", "const"].contains(&item.keyword.as_str()))
        };
        let interfaces = [Kind::Sensor, Kind::Controller, Kind::Task].map(interface::of);
        let is_kept = |name: &String| {
            let name = name.as_str();
            let is_of_interface = |interface: &Interface| {
                name.starts_with(&format!("{}_", interface.kind.word()))
                    || interface.known().any(|function| function.name() == name)
                    || interface.others.iter().any(|(other, _)| *other == name)
                    || interface.calls.contains(&name)
            };
            let lists = [
                &CALLS[..],
                &TOGETHER,
                &CONSTANTS,
                &generate::COUNTS,
                &super::members::WORDS,
            ];
            let is_listed = lists.iter().any(|list| list.contains(&name)) && !REPLACEABLE.contains(&name);
            name != "main" && !is_listed && !interfaces.iter().any(is_of_interface)
        };
        let all = PARTS.iter().filter(is_of_kernels).flat_map(of_part);
        all.map(|item| item.name).filter(is_kept).collect()
    });
    &NAMES
}

/// The refusal of a part that has [`interface::EPISODE`] by its former name.
pub(super) fn renamed(part: &compiler::Part) -> Option<Refusal> {
    const FORMER: &str = interface::FORMER_EPISODE;
    let declared = declarations(part);
    let is_of_word = |c: char| c.is_alphanumeric() || c == '_';
    let has_parameter = |function: &Declaration| function.signature.split(|c| !is_of_word(c)).any(|ty| ty == FORMER);
    let is_meant = declared.iter().all(|other| other.name != FORMER) && declared.iter().any(has_parameter);
    let (place, _) = uses(part, &[FORMER]).into_iter().next().filter(|_| is_meant)?;
    let message = format!(
        "`{FORMER}` is now `{}`; rename it in the whole file",
        interface::EPISODE
    );
    Some(refusal(&place, Rule::UnknownName, message))
}

/// Everything that is wrong with what a part declares and uses, given what is generated for it.
pub(super) fn problems(
    part: &compiler::Part,
    interface: &Interface,
    declared: &[Declaration],
    generated: &str,
) -> Refusals {
    let mut taken = shipped_names();
    let mut used = buffer_problems(part);
    used.extend(call_problems(part, interface, &taken));
    let added: BTreeSet<_> = declared_names(kernel::GENERATED, generated).collect();
    taken.extend(added.iter().cloned());
    let mut problems = declared_problems(part, interface, declared, &taken, &added);
    problems.extend(used);
    problems
}

/// Functions that parts may call in swarms; `lib/members` has them, and `lib/pucks` those of pucks.
const TOGETHER: [&str; 10] = [
    "robot_pose",
    "clusters_within",
    "pucks",
    "puck_radius",
    "puck_place",
    "is_carried",
    "carries_puck",
    "puck_clusters_within",
    "take_puck",
    "put_puck",
];

/// Refuses parts that declare or call what only foragers' or only swarms' kernels have.
pub(super) fn of_few(custom: &OwnParts, taken: &BTreeSet<String>) -> Result<(), Refusals> {
    let mut problems = Refusals::new();
    for each in custom.iter() {
        let part = each.part().source();
        let interface = interface::of(each.part().kind());
        let declared = declarations(&part).into_iter();
        let is_taken = |item: &Declaration| {
            !interface.structs.contains(&item.name.as_str()) && taken.contains(&item.name) && !gives_way(item)
        };
        problems.extend(declared.filter(is_taken).map(|item| taken_name(&item)));
        problems.extend(call_problems(&part, &interface, taken));
        problems.extend(constant_problems(&each.part().genes, taken));
    }
    if problems.is_empty() { Ok(()) } else { Err(problems) }
}

/// Problems with the constants of named genes.
pub(super) fn gene_problems(genes: &[GeneField]) -> Refusals {
    constant_problems(genes, &shipped_names())
}

fn constant_problems(genes: &[GeneField], taken: &BTreeSet<String>) -> Refusals {
    let refused = genes.iter().filter(|gene| taken.contains(&gene.constant()));
    let refusal = |gene: &GeneField| {
        let (name, constant) = (&gene.name, gene.constant());
        let problem =
            format!("in `{GENES}`: the constant `{constant}` of `{name}` is a name that Oneiro uses; choose another");
        refusal(&gene.place, Rule::ReservedName, problem)
    };
    refused.map(refusal).collect()
}

/// Names declared by the shipped parts that users' parts are composed with, and by the code generated with them.
fn shipped_names() -> BTreeSet<String> {
    let is_composed = |path: &&str| {
        let episode = |name: &str| name.starts_with("life_") || name.starts_with("surrogate_");
        let mut kernels = KERNELS.iter().filter(|kernel| episode(kernel.name));
        let is_of_few = kernel::is_of_foragers(path) || kernel::is_of_members(path);
        let ships = KERNELS.iter().any(|kernel| kernel.parts.contains(path)) || is_of_few;
        !ships || kernels.any(|kernel| kernel.parts.contains(path))
    };
    let shipped = PARTS.iter().filter(|(path, _)| is_composed(path));
    let declared = shipped.flat_map(|(path, text)| declared_names(path, text));
    let generated = generate::COUNTS
        .into_iter()
        .chain([generate::READING, generate::GIVEN_CELL]);
    declared.chain(generated.map(str::to_owned)).collect()
}

/// Names that a part declares outside of functions.
fn declared_names(path: &str, text: &str) -> impl Iterator<Item = String> {
    let part = compiler::Part {
        path: path.to_owned(),
        text: text.to_owned(),
    };
    declarations(&part).into_iter().map(|item| item.name)
}

/// The kind of part that declarations are of, by the function that each kind must have.
fn kind_of(declared: &[Declaration]) -> Option<Kind> {
    [Kind::Sensor, Kind::Controller, Kind::Task].into_iter().find(|kind| {
        declared
            .iter()
            .any(|item| item.name == format!("{}_cycle", kind.word()))
    })
}

/// The place of a part as a whole.
fn whole(part: &compiler::Part) -> Place {
    Place {
        path: part.path.clone(),
        line: 0,
        column: 0,
    }
}

/// Problems with what a part declares or doesn't declare. `taken` are the names of the rest of the kernel, among them those that
/// are `added` for this part.
fn declared_problems(
    part: &compiler::Part,
    interface: &Interface,
    declared: &[Declaration],
    taken: &BTreeSet<String>,
    added: &BTreeSet<String>,
) -> Refusals {
    let whole = whole(part);
    let mut problems = Refusals::new();
    let mut refuse = |place, rule, message| problems.push(refusal(place, rule, message));
    let has_mission = declared.iter().any(|item| item.name == interface::MISSION);
    let is_required = |function: &&Function| function.default.is_none() && !(has_mission && function.name() == OF_EACH);
    for required in interface.functions.iter().filter(is_required) {
        if declared.iter().all(|item| item.name != required.name()) {
            let (name, text) = (required.name(), required.text);
            let is_known = |item: &&Declaration| interface.known().any(|known| known.name() == item.name);
            let others = declared.iter().filter(|item| item.keyword == "fn" && !is_known(item));
            let meant =
                others.filter_map(|item| Some((item, nearest(interface.known().map(Function::name), &item.name)?)));
            let meant = meant
                .into_iter()
                .find(|(_, meant)| [name, interface::MISSION].contains(meant));
            let message = match (meant, kind_of(declared)) {
                (Some((item, meant)), _) => {
                    refuse(
                        &item.place,
                        Rule::MissingDeclaration,
                        format!(
                            "there is no function `{name}`; did you mean `{meant}` by `{}`?",
                            item.name
                        ),
                    );
                    continue;
                }
                (None, Some(other)) if other != interface.kind => {
                    let (expected, other) = (interface.kind.word(), other.word());
                    format!("is a {other}, not a {expected}: it has `{other}_cycle`; name it in `{other}.part`")
                }
                _ => format!("has no function `{name}`; write `{text} {{ .. }}`"),
            };
            refuse(&whole, Rule::MissingDeclaration, message);
        }
    }
    for (name, form) in interface.others {
        if !added.contains(*name) && declared.iter().all(|item| item.name != *name) {
            let instead = match *name {
                GENE_COUNT => format!(", or name the genes: `struct {GENES} {{ NAME: f32, .. }}`"),
                _ => String::new(),
            };
            let message = format!("has no `{name}`; write `{form}`{instead}");
            refuse(&whole, Rule::MissingDeclaration, message);
        }
    }
    for item in declared {
        let Declaration {
            keyword,
            name,
            place,
            signature: has,
        } = item;
        let expected = interface.known().find(|function| function.name() == name);
        let form = interface.others.iter().find(|(other, _)| other == name);
        if let Some((_, form)) = form
            && (!form.starts_with(keyword.as_str()) || keyword == "const" && has != "u32")
        {
            let message = format!("`{name}` is declared otherwise; write `{form}`");
            refuse(place, Rule::DeclaredForm, message);
        } else if form.is_some() && added.contains(name) {
            let message = format!("`{name}` is the number of genes that `{GENES}` names; leave it out");
            refuse(place, Rule::DeclaredForm, message);
        } else if keyword == "var" {
            let message = format!(
                "declares a buffer or a global variable; allowed: structs, constants and functions, and memory in `{}State`",
                interface.title
            );
            refuse(place, Rule::OwnBuffers, message);
        } else if let Some(Function { text, .. }) = expected {
            let wanted = text
                .split_once('(')
                .map(|(_, rest)| signature(&format!("({rest}")))
                .unwrap_or_default();
            if keyword != "fn" || *has != wanted {
                let message = format!("`{name}` has other parameters or another result; write `{text}`");
                refuse(place, Rule::DeclaredForm, message);
            }
        } else if ["const", "override"].contains(&keyword.as_str()) && built_in().any(|known| known == name) {
            let message = format!("`{name}` shadows a WGSL built-in; choose another name");
            refuse(place, Rule::BuiltInName, message);
        } else if form.is_none()
            && !interface.structs.contains(&name.as_str())
            && taken.contains(name)
            && !gives_way(item)
        {
            let Refusal { rule, message, .. } = taken_name(item);
            refuse(place, rule, message);
        }
    }
    problems
}

/// The refusal of a declaration with one of Oneiro's names.
fn taken_name(item: &Declaration) -> Refusal {
    let message = format!("`{}` is a name that Oneiro uses; choose another", item.name);
    refusal(&item.place, Rule::ReservedName, message)
}

/// Problems with what a part uses of the kernel's buffers and of what it is given. It may give their names to what it declares
/// itself; its compiled form shows what is meant.
fn buffer_problems(part: &compiler::Part) -> Refusals {
    let mut problems = Refusals::new();
    let mut refuse = |place: &Place, rule, message| problems.push(refusal(place, rule, message));
    let names = names(part);
    let is_foreign = |(_, name): &(Place, &str)| !names.contains(*name);
    let buffers: Vec<_> = LIFE_PERCEPTRON.bindings.iter().map(|binding| binding.name).collect();
    for (place, name) in uses(part, &buffers).into_iter().filter(is_foreign) {
        let message = format!("`{name}` is one of the kernel's buffers; parts can't read or write it");
        refuse(&place, Rule::KernelBuffers, message);
    }
    for (place, name) in accesses(part, &PLACES_IN_THE_BATCH).into_iter().filter(is_foreign) {
        let message = format!("`.{name}` of an episode is only for the kernel: pass `episode` itself on");
        refuse(&place, Rule::BatchPlace, message);
    }
    for (name, place) in indexed(part) {
        if let Some(readings) = readings_at(part, &name, &place) {
            let message = format!(
                "readings have names, and no index; write `{}({readings}, i)`",
                generate::READING
            );
            refuse(&place, Rule::IndexedArrays, message);
        }
    }
    problems
}

/// Problems with what a part calls.
fn call_problems(part: &compiler::Part, interface: &Interface, taken: &BTreeSet<String>) -> Refusals {
    let mut problems = Refusals::new();
    for (name, place) in calls(part) {
        let is_allowed = [&CALLS[..], &TOGETHER, interface.calls, interface.structs]
            .iter()
            .any(|list| list.contains(&name.as_str()));
        if !is_allowed && taken.contains(&name) {
            let allowed = CALLS
                .iter()
                .chain(interface.calls)
                .copied()
                .collect::<Vec<_>>()
                .join(", ");
            let message = if interface.is_of_another(&name) {
                format!("`{name}` can't be called from here; {NO_MEMORY}")
            } else {
                format!("`{name}` can't be called from here; allowed: {allowed}, and your own functions")
            };
            problems.push(refusal(&place, Rule::AllowedCalls, message));
        }
    }
    problems
}

/// Functions of users' parts that look like those that the kernel calls, and that nothing calls.
pub(super) fn uncalled(parts: &[compiler::Part], custom: &OwnParts) -> Refusals {
    let users: Vec<_> = parts
        .iter()
        .filter(|part| custom.iter().any(|each| each.part().path() == part.path))
        .collect();
    let mut refusals = Refusals::new();
    for part in &users {
        for Declaration {
            keyword, name, place, ..
        } in declarations(part)
        {
            let kinds = [Kind::Sensor, Kind::Controller, Kind::Task];
            let prefix = kinds.map(|kind| (kind, format!("{}_", kind.word())));
            let Some((kind, prefix)) = prefix.iter().find(|(_, prefix)| name.starts_with(prefix)) else {
                continue;
            };
            let known: Vec<_> = interface::of(*kind).functions.iter().map(Function::name).collect();
            let count: usize = users.iter().map(|part| uses(part, &[&name]).len()).sum();
            let mut kinds_of_file = custom.iter().filter(|each| each.part().path() == part.path);
            let is_of_kind = kinds_of_file.any(|each| each.part().kind() == *kind);
            let is_known = known.contains(&name.as_str());
            if keyword != "fn" || is_known && is_of_kind || count > 1 {
                continue;
            }
            if is_known {
                let message = format!(
                    "nothing calls `{name}` here; allowed: in the file of `{}.part`",
                    kind.word()
                );
                refusals.push(refusal(&place, Rule::UncalledFunction, message));
                continue;
            }
            let meant = nearest(known.iter().copied(), &name);
            let meant = meant.map_or_else(String::new, |meant| format!("; did you mean `{meant}`?"));
            let message = format!(
                "nothing calls `{name}`; allowed: {}, which Oneiro calls, and functions that a part calls or whose names don't \
                 begin with `{prefix}`{meant}",
                known.join(", ")
            );
            refusals.push(refusal(&place, Rule::UncalledFunction, message));
        }
    }
    refusals
}

/// The expression that a name at a place ends, if it is a struct of readings: a parameter, a field of what a task is given, or
/// what a `let` of the same function made of one.
fn readings_at(part: &compiler::Part, name: &str, place: &Place) -> Option<String> {
    let before: Vec<_> = part.text.split('\n').take(place.line).collect();
    let (line, above) = before.split_last()?;
    let line: String = line.chars().take(place.column - 1).collect();
    let is_inside = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
    let owner = &line[line.trim_end_matches(is_inside).len()..];
    let whole = format!("{owner}{name}");
    let parameters = parameters_at(part, place);
    let is_given = |name: &str, ty: &str| parameters.iter().any(|(parameter, of)| parameter == name && of == ty);
    let is_readings = |expression: &str| match expression.split_once('.') {
        Some((owner, field)) => is_given(owner, "Experience") && ["real", "perceived"].contains(&field),
        None => is_given(expression, "Readings"),
    };
    let text = above.join("\n") + "\n" + &line;
    let function = &text[text.rfind("fn ").unwrap_or(0)..];
    let made = function.rsplit_once(&format!("let {whole} ="));
    let made = made.and_then(|(_, after)| after.split(';').next());
    (is_readings(&whole) || made.is_some_and(|made| is_readings(made.trim()))).then_some(whole)
}

/// Naga's message, without a place, for an index of a struct or a number.
const INDEXED: &str = "Invalid access into expression";

/// Adds to the refusal of each unknown name of a user's part the name that was probably meant, and says which part has an index
/// where none may be.
pub(super) fn suggest(refusals: &mut [Refusal], parts: &[compiler::Part], custom: &OwnParts) {
    let own_part = |path: &str| {
        let each = custom.iter().find(|each| each.part().path() == path)?;
        let part = parts.iter().find(|part| part.path == path)?;
        Some((part, interface::of(each.part().kind())))
    };
    for refusal in refusals {
        if refusal.message.starts_with(INDEXED)
            && let Some(part) = parts
                .iter()
                .find(|part| own_part(&part.path).is_some() && !indexed(part).is_empty())
        {
            refusal.place = whole(part);
            let message = "an index follows what is neither an array nor a vector; fields have names, and readings";
            refusal.message = format!("{message} `{}(readings, i)`", generate::READING);
        }
        if refusal.rule == Rule::UnknownName
            && let Some((part, interface)) = own_part(&refusal.place.path)
            && let Some(written) = word_at(part, &refusal.place)
        {
            let field = Field {
                parts,
                part,
                written: &written,
                place: &refusal.place,
            };
            if refusal.message.starts_with(ACCESSED) {
                let any = || format!("{}{}", refusal.message, field.alike(custom));
                refusal.message = field.explained().unwrap_or_else(any);
                continue;
            }
            if interface.is_of_another(&written) {
                refusal.message = format!("{}; {NO_MEMORY}", refusal.message);
                continue;
            }
            let mut usable = usable(parts, &interface, custom);
            // It is declared, but not here.
            usable.remove(&written);
            let alike = || nearest(usable.iter().map(String::as_str), &written).map(str::to_owned);
            if let Some(name) = field_of_parameter(parts, part, &refusal.place, &written).or_else(alike) {
                refusal.message = format!("{}; did you mean `{name}`?", refusal.message);
            }
        }
    }
}

/// Naga's message for a field that a struct doesn't have.
const ACCESSED: &str = "invalid field accessor";

/// Most declarations, each of which names the one before, by which the type of an expression is looked up.
const LONGEST_CHAIN: u32 = 20;

/// An access to a field that there isn't.
struct Field<'a> {
    parts: &'a [compiler::Part],
    part: &'a compiler::Part,
    written: &'a str,
    place: &'a Place,
}

impl Field<'_> {
    /// The fields that there are, and the one that was probably meant; `None` if the type of what has them isn't found.
    fn explained(&self) -> Option<String> {
        let Self { written, place, .. } = self;
        let line = self.part.text.split('\n').nth(place.line - 1)?;
        let line: String = line.chars().take(place.column - 1).collect();
        let is_inside = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
        let owner = line[line.trim_end_matches(is_inside).len()..].trim_end_matches('.');
        let above: Vec<_> = self.part.text.split('\n').take(place.line - 1).collect();
        let above = above.join("\n") + "\n" + &line;
        let ty = self.type_of(owner, &above[above.rfind("fn ").unwrap_or(0)..], LONGEST_CHAIN)?;
        let Some(fields) = self.fields(&ty) else {
            let count = ty.strip_prefix("vec")?.chars().next()?.to_digit(10)? as usize;
            let components = ["x", "y", "z", "w"].get(..count)?.join(", ");
            return Some(format!(
                "`{owner}` is a {ty} and has no `{written}`; allowed: {components}"
            ));
        };
        let deeper = || {
            let has = |ty: &str| {
                self.fields(ty)
                    .is_some_and(|fields| fields.iter().any(|(name, _)| name == written))
            };
            let outer = fields.iter().find(|(_, ty)| has(ty));
            outer.map(|(outer, _)| format!("{owner}.{outer}.{written}"))
        };
        let alike = || nearest(fields.iter().map(|(name, _)| name.as_str()), written).map(str::to_owned);
        let of_khepera = ty == "Readings" && ["first", "last"].contains(written);
        let meant = if of_khepera {
            "; a parametric robot has no `first` and `last`".to_owned()
        } else {
            alike()
                .or_else(deeper)
                .map_or_else(String::new, |meant| format!("; did you mean `{meant}`?"))
        };
        let names: Vec<_> = fields.iter().map(|(name, _)| name.as_str()).collect();
        if names == [generate::UNUSED] {
            return Some(format!(
                "`{ty}` has no fields, since the part doesn't declare it; write `struct {ty} {{ {written}: f32, }}`"
            ));
        }
        Some(format!(
            "`{ty}` has no field `{written}`; allowed: {}{meant}",
            names.join(", ")
        ))
    }

    /// Of the fields of all structs that parts use, the one that was probably meant, where the type isn't found.
    fn alike(&self, custom: &OwnParts) -> String {
        let declared = self
            .parts
            .iter()
            .filter(|part| custom.iter().any(|each| each.part().path() == part.path));
        let declared = declared.flat_map(declarations).filter(|item| item.keyword == "struct");
        let structs = declared.map(|item| item.name).chain(STRUCTS.map(str::to_owned));
        let fields: Vec<_> = structs.filter_map(|name| self.fields(&name)).flatten().collect();
        let meant = nearest(fields.iter().map(|(name, _)| name.as_str()), self.written);
        meant.map_or_else(String::new, |meant| format!("; did you mean `{meant}`?"))
    }

    /// The fields of a struct with their types.
    fn fields(&self, ty: &str) -> Option<Vec<(String, String)>> {
        let fields = self.parts.iter().find_map(|part| members(part, ty))?;
        Some(fields.into_iter().map(|field| (field.name, field.ty)).collect())
    }

    /// The type of a name and of fields of it, such as `now.real`, as far as the text `above` in the same function shows it
    /// by a chain of at most `most` declarations.
    fn type_of(&self, expression: &str, above: &str, most: u32) -> Option<String> {
        let most = most.checked_sub(1)?;
        let mut names = expression.split('.');
        let root = names.next().filter(|root| !root.is_empty())?;
        let parameters = parameters_at(self.part, self.place);
        let parameter = parameters
            .into_iter()
            .find_map(|(name, ty)| (name == root).then_some(ty));
        let ty = parameter.or_else(|| self.declared(root, above, most))?;
        names.try_fold(ty, |ty, name| {
            let fields = self.fields(&ty)?;
            fields.into_iter().find_map(|(field, ty)| (field == name).then_some(ty))
        })
    }

    /// The type of what `let` or `var` declares in a text: that which it says, or that of its value.
    fn declared(&self, name: &str, above: &str, most: u32) -> Option<String> {
        let is_declared = |at: &usize| {
            let before = above[..*at].trim_end();
            let after = above[at + name.len()..].trim_start();
            (before.ends_with("let") || before.ends_with("var")) && after.starts_with([':', '='])
        };
        let at = above.rmatch_indices(name).map(|(at, _)| at).find(is_declared)?;
        let (head, value) = above[at..].split(';').next()?.split_once('=')?;
        if let Some((_, ty)) = head.split_once(':') {
            return Some(ty.split_whitespace().collect());
        }
        let value = value.trim();
        let Some((called, _)) = value.split_once('(') else {
            return self.type_of(value, &above[..at], most);
        };
        if self.fields(called).is_some() {
            return Some(called.to_owned());
        }
        let functions = self.parts.iter().flat_map(declarations);
        let function = functions
            .into_iter()
            .find(|item| item.keyword == "fn" && item.name == called)?;
        // Only what ends with the call has the type of its result.
        let (_, result) = function.signature.rsplit_once("->")?;
        value.ends_with(')').then(|| result.to_owned())
    }
}

/// The expression, such as `now.moved`, for a name that stands alone at a place and is a field of what the function around it
/// is given.
fn field_of_parameter(parts: &[compiler::Part], part: &compiler::Part, place: &Place, written: &str) -> Option<String> {
    let is_alone = accesses(part, &[written]).iter().all(|(other, _)| other != place);
    let has_field = |ty: &str| {
        let fields = parts.iter().find_map(|part| members(part, ty));
        fields.is_some_and(|fields| fields.iter().any(|field| field.name == written))
    };
    let parameters = parameters_at(part, place).into_iter().filter(|_| is_alone);
    let (parameter, _) = parameters.into_iter().find(|(_, ty)| has_field(ty))?;
    Some(format!("{parameter}.{written}"))
}

/// Names that a part may use: WGSL's, those of the interface, and what users' parts declare.
fn usable(parts: &[compiler::Part], interface: &Interface, custom: &OwnParts) -> BTreeSet<String> {
    let lists = [&CALLS[..], &TOGETHER, &CONSTANTS, interface.calls, interface.structs].concat();
    let fields = parts
        .iter()
        .flat_map(|part| STRUCTS.iter().filter_map(|name| members(part, name)).flatten());
    let declared = custom.iter().flat_map(|each| {
        let path = each.part().path();
        let values = format!("{}_values", each.part().kind().word());
        let part = parts.iter().find(|part| part.path == path);
        part.map(names).unwrap_or_default().into_iter().chain([values])
    });
    let listed = built_in().chain(ordinary()).chain(lists).map(str::to_owned);
    listed.chain(fields.map(|field| field.name)).chain(declared).collect()
}
