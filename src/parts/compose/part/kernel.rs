//! Composition of a kernel from shipped parts and users' parts.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::panic;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

use oneiro_shader_compiler as compiler;
use oneiro_shader_compiler::declarations::{declarations, renamed};
use oneiro_shader_compiler::{Allowed, Compiled, Indices, Isolation, Refusal, Refusals, Rule, compile_isolated};
use oneiro_shader_parts::PARTS;
use oneiro_shaders::kernel::Turns;
use oneiro_shaders::{Binding, Kernel, WordOf};

use super::interface::{GENE_COUNT, GENES};
use super::{Part, check, generate, interface, members, refusal};
use crate::genes::Gene;
use crate::parameter::Invalid;
use crate::parts::compose::{
    Composed, EpisodeKind, GREATEST_GENES, Hearing, Kind, Make, OwnParts, Owner, Refused, Together,
};

/// Stands for a path in messages about generated declarations.
pub(super) const GENERATED: &str = "what Oneiro adds";

/// The end that names of Oneiro's declarations get where a user's part declares the same names.
pub(super) const OF_ONEIRO: &str = "_of_oneiro";

/// What users' parts may ask of the world and of the experiment.
pub(super) const USER: &str = "lib/user.wgsl";
const GIVEN: &str = "lib/given.wgsl";

/// The entry of kernels of single robots, and how it takes over what a cycle leaves. Where an episode is cut into pieces, zeros lose their
/// sign. A user's part may see signs, so in its kernel they lose it after each cycle, wherever the cuts are.
const ENTRY: &str = "episode.wgsl";
const NEXT: &str = "after = result.next;";
const KEPT: &str = "after = kept(result.next);";

/// The entry of single robots that are commanded from outside.
const COMMANDED: &str = "commanded.wgsl";

/// Trace details of the shipped sensors; composed kernels generate their own.
const DETAILS: &str = "sensor/details.wgsl";

/// Parts of sampled sensors and of sampled motors, and that of such motors of a parametric robot.
const SENSORS: [&str; 2] = ["sensor/readings.wgsl", "sensor/sampled.wgsl"];
const MOTORS: [&str; 2] = ["robot/motors.wgsl", "robot/differential.wgsl"];
const BETWEEN: &str = "robot/between.wgsl";

/// Parts that a parametric robot has, those of its sampled sensors, and that of the wheels that it has unless its motors are
/// sampled.
const DESCRIBED: [&str; 2] = ["robot/drive.wgsl", "sensor/kinds.wgsl"];
const TABLES: &str = "sensor/tables.wgsl";
const WHEELS: &str = "robot/arcs.wgsl";

/// Physics by the kind of episodes, and what else an individual's need.
const fn physics(episodes: EpisodeKind) -> &'static str {
    match episodes {
        EpisodeKind::Simulated | EpisodeKind::Observed => "physics/sampled.wgsl",
        EpisodeKind::Reported => "physics/reported.wgsl",
        EpisodeKind::Individual => "physics/individual.wgsl",
    }
}
const DIFFERENCES: &str = "lib/differences.wgsl";

/// The part of noise that the kernels that ship don't have.
const VARIED: &str = "robot/varied.wgsl";

/// The parts of arenas of many objects and of many patches, and that of the grids of both.
const NEAR: &str = "lib/near.wgsl";
const PATCHES: &str = "lib/patches.wgsl";
const SQUARES: &str = "lib/squares.wgsl";

/// The part of pucks.
const PUCKS: &str = "lib/pucks.wgsl";

/// The part of swarms of many bodies.
const NEIGHBOURS: &str = "lib/neighbours.wgsl";

/// The parts of floors with a picture: what all have, the readings of a parametric robot, and the floor that custom parts of a single
/// robot ask for.
const PICTURE: &str = "lib/picture.wgsl";
const PICTURE_READ: &str = "sensor/picture.wgsl";
const PICTURE_GIVEN: &str = "lib/pictured.wgsl";

/// Whether an episode has that noise. Reality that is reported has none of the simulator's.
fn is_varied(owner: &Owner) -> bool {
    owner.episodes == EpisodeKind::Simulated && owner.is_varied
}

/// Parts of foragers: what all have, and their controllers and their task.
const FORAGER: [&str; 12] = [
    "lib/circle.wgsl",
    "lib/circle_given.wgsl",
    "lib/circle_rays.wgsl",
    "lib/food.wgsl",
    "lib/food_eight.wgsl",
    "lib/forager.wgsl",
    "physics/forager.wgsl",
    "robot/epuck.wgsl",
    "robot/epuck_alone.wgsl",
    "sensor/epuck.wgsl",
    "sensor/foraging.wgsl",
    "task/foraging.wgsl",
];
const FOOD: [&str; 2] = ["lib/food_few.wgsl", "lib/food_many.wgsl"];
const OUTPUTS: &str = "controller/outputs.wgsl";
const BEHAVIOURS: [&str; 2] = ["controller/behaviours.wgsl", "controller/foraging.wgsl"];
const BRINGING: &str = "task/bringing.wgsl";

/// The part of swarms whose robots are driven from outside.
const DRIVEN: &str = "driven.wgsl";

/// Parts that all other robots have and foragers don't.
const NOT_FORAGER: [&str; 3] = ["lib/walk.wgsl", "physics/sliding.wgsl", physics(EpisodeKind::Simulated)];

/// Whether only foragers, alone or in swarms, are made of a part.
pub(super) fn is_of_foragers(path: &str) -> bool {
    FORAGER.contains(&path)
        || FOOD.contains(&path)
        || BEHAVIOURS.contains(&path)
        || [OUTPUTS, BRINGING, DRIVEN].contains(&path)
}

/// Whether only swarms' kernels have a part.
pub(super) fn is_of_members(path: &str) -> bool {
    members::PARTS.contains(&path)
}

/// Whether a forager is made of a part, if the part is not of every robot.
fn is_of_forager(path: &str, behaves: bool, brings: bool, has_many_items: bool) -> Option<bool> {
    let others = [
        &SENSORS[..],
        &MOTORS,
        &DESCRIBED,
        &[TABLES, WHEELS, BETWEEN],
        &NOT_FORAGER,
    ];
    match path {
        _ if FORAGER.contains(&path) => Some(true),
        _ if FOOD.contains(&path) => Some(path == FOOD[usize::from(has_many_items)]),
        _ if BEHAVIOURS.contains(&path) => Some(behaves),
        OUTPUTS => Some(!behaves),
        BRINGING => Some(brings),
        _ if behaves && is_replaced(path, Kind::Controller) && path != GENES_PART => Some(false),
        _ if brings && is_replaced(path, Kind::Task) => Some(false),
        _ => others.iter().any(|list| list.contains(&path)).then_some(false),
    }
}

/// Whether a robot is made of a part, if the part is only of some robots.
fn is_of_robot(path: &str, make: &Make) -> Option<bool> {
    let robot = match make {
        Make::Sampled => {
            return (DESCRIBED.contains(&path) || [TABLES, WHEELS, BETWEEN].contains(&path)).then_some(false);
        }
        Make::Forager {
            behaves,
            brings,
            has_many_items,
        } => return is_of_forager(path, *behaves, *brings, *has_many_items),
        Make::Described(robot) => robot,
    };
    if SENSORS.contains(&path) || path == TABLES {
        return Some(robot.has_sampled_sensors);
    }
    if MOTORS.contains(&path) || path == BETWEEN {
        return Some(robot.has_sampled_motors);
    }
    if path == WHEELS {
        return Some(!robot.has_sampled_motors);
    }
    DESCRIBED.contains(&path).then_some(true)
}

/// The text of a part without what is declared in its place; the rest stays on its lines.
fn without(shipped: &compiler::Part, others: &BTreeSet<String>) -> String {
    let mut lines: Vec<&str> = shipped.text.lines().collect();
    for item in declarations(shipped).iter().filter(|item| others.contains(&item.name)) {
        let first = item.place.line - 1;
        // Shipped parts are formatted alike: attributes have their lines, and a body ends with a line of its brace.
        let attributes = lines[..first]
            .iter()
            .rev()
            .take_while(|line| line.starts_with('@'))
            .count();
        let last = match item.keyword.as_str() {
            "fn" | "struct" => lines[first..].iter().position(|line| *line == "}").unwrap_or(0),
            _ => 0,
        };
        lines[first - attributes..=first + last].fill("");
    }
    lines.join("\n") + "\n"
}

/// A part that ships.
pub(super) fn shipped(path: &str) -> compiler::Part {
    let shipped = PARTS.iter().find(|(shipped, _)| *shipped == path);
    compiler::Part {
        path: path.to_owned(),
        text: shipped.map_or_else(String::new, |(_, text)| (*text).to_owned()),
    }
}

/// Parts and another shipped one, whose declarations replace the same names in them.
pub(super) fn with(parts: Vec<compiler::Part>, other: compiler::Part) -> Vec<compiler::Part> {
    let instead = declarations(&other).into_iter().map(|item| item.name).collect();
    let kept = parts.into_iter().map(|shipped| {
        let text = without(&shipped, &instead);
        compiler::Part { text, ..shipped }
    });
    kept.chain([other]).collect()
}

/// The genes of shipped controllers.
const GENES_PART: &str = "lib/genes.wgsl";

/// The shipped part in whose place a user's stands.
fn is_replaced(path: &str, kind: Kind) -> bool {
    match kind {
        Kind::Sensor => path == "sensor/no_others.wgsl",
        Kind::Controller => path.starts_with("controller/") || path == GENES_PART,
        Kind::Task => path.starts_with("task/"),
    }
}

static COMPOSED: Mutex<BTreeMap<String, Composed>> = Mutex::new(BTreeMap::new());

/// Kernels composed so far. A poisoned lock is fine: entries are added complete or not at all.
fn known() -> MutexGuard<'static, BTreeMap<String, Composed>> {
    COMPOSED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The files that a kernel's text is made of.
pub(crate) fn parts_of(kernel: &Kernel) -> Vec<compiler::Part> {
    let composed = known().get(kernel.name).copied();
    let files = composed.map_or(&[][..], |composed| composed.files);
    let shipped;
    let files = if files.is_empty() {
        shipped = shipped_files(kernel);
        &shipped
    } else {
        files
    };
    let ends = files.iter().skip(1).map(|(_, begin)| *begin).chain([kernel.wgsl.len()]);
    let part = |((path, begin), end): (&(String, usize), usize)| compiler::Part {
        path: path.clone(),
        text: kernel.wgsl[*begin..end].to_owned(),
    };
    files.iter().zip(ends).map(part).collect()
}

/// The files of a kernel that ships, and where each begins in its text.
fn shipped_files(kernel: &Kernel) -> Vec<(String, usize)> {
    let place = |(path, text): &(&str, &str)| Some(((*path).to_owned(), kernel.wgsl.find(text)?));
    let mut files: Vec<_> = PARTS.iter().filter_map(place).collect();
    files.sort_by_key(|(_, begin)| *begin);
    files
}

/// Whether a user wrote the file with this path, of a kernel that was composed.
pub(crate) fn is_of_user(kernel: &Kernel, path: &str) -> bool {
    let is_known = path == GENERATED || PARTS.iter().any(|(shipped, _)| *shipped == path);
    kernel.variants.is_empty() && !is_known
}

/// The name of a kernel that is composed, and what is generated for its robot.
fn described(base: &Kernel, parts: &OwnParts, owner: &Owner) -> (String, String) {
    let readings = parts.readings_in(&owner.fields);
    let mut generated = generate::details(&parts.details(owner)) + &generate::reading(&readings);
    let mut name = base.name.to_owned();
    match &owner.make {
        Make::Sampled => {}
        Make::Described(robot) => {
            if let Some(Together {
                count, pucks, hearing, ..
            }) = robot.together
            {
                // Its traces have as many poses.
                let _ = write!(name, "+{count}-together");
                if pucks > 0 {
                    let _ = write!(name, "+{pucks}-pucks");
                }
                if let Some(Hearing { model, cycles, .. }) = hearing {
                    let _ = write!(name, "+{model}-{cycles}");
                }
            }
            let hash = blake3::hash(robot.text.as_bytes()).to_hex();
            let _ = write!(name, "+{}-sensors-{}", robot.sensors, &hash[..16]);
            generated += &robot.text;
        }
        Make::Forager {
            behaves,
            brings,
            has_many_items,
        } => {
            name += "+forager";
            name += if *has_many_items { "+many-items" } else { "" };
            name += if *behaves { "+behaviours" } else { "" };
            name += if *brings { "+foraging" } else { "" };
        }
    }
    match owner.episodes {
        EpisodeKind::Simulated => {}
        EpisodeKind::Reported => {
            name += "+reported";
            generated += &generate::reports(&owner.fields);
        }
        EpisodeKind::Individual => name += "+individual",
        EpisodeKind::Observed => name += "+observed",
    }
    if is_varied(owner) {
        name += "+varied";
    }
    if owner.grids.objects {
        name += "+near";
    }
    if owner.grids.patches {
        name += "+patches";
    }
    if owner.has_picture {
        name += "+picture";
    }
    for each in parts.iter() {
        let stem = Path::new(&each.part.path)
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy();
        let hash = blake3::hash(format!("{} {}", each.part.kind.word(), each.part.text).as_bytes()).to_hex();
        let _ = write!(name, "+{stem}-{}", &hash[..32]);
    }
    (name, generated)
}

/// Composes a kernel. Each is composed once and stays for the rest of the program.
pub(in crate::parts::compose) fn compose(
    base: &'static Kernel,
    parts: &OwnParts,
    owner: &Owner,
) -> Result<Composed, Invalid> {
    let ships = matches!(owner.make, Make::Sampled) && owner.episodes == EpisodeKind::Simulated && !owner.is_varied;
    if parts.is_empty() && ships {
        return Ok(Composed {
            kernel: base,
            genes: None,
            files: &[],
            words: None,
        });
    }
    let (name, generated) = described(base, parts, owner);
    if let Some(composed) = known().get(&name) {
        return Ok(*composed);
    }
    let (kernel, genes, files, words) =
        new(base, parts, owner, generated, &name).map_err(|refusals| invalid(parts, &owner.make, &refusals))?;
    let leaked = || Composed {
        kernel: Box::leak(Box::new(kernel)),
        genes: genes.map(|genes| &*genes.leak()),
        files: files.leak(),
        words,
    };
    Ok(*known().entry(name).or_insert_with(leaked))
}

/// Names the key of the part that is refused first.
fn invalid(parts: &OwnParts, robot: &Make, refusals: &[Refusal]) -> Invalid {
    if matches!(robot, Make::Described(_)) && refusals[0].place.path == GENERATED {
        let is_of_names = matches!(
            refusals[0].rule,
            Rule::ReservedName | Rule::BuiltInName | Rule::UnknownName | Rule::ValidWgsl
        );
        let names = if is_of_names {
            "have names that can't be used; choose others: "
        } else {
            ""
        };
        return Invalid::new("robot.sensors", format!("{names}{}", Refused::all(refusals)));
    }
    let is_refused = |path: &str| refusals.iter().any(|refusal| refusal.place.path == path);
    let refused = parts.iter().find(|part| is_refused(&part.part.path));
    let Some(part) = refused.or_else(|| parts.iter().next()) else {
        return Invalid::new("part", Refused::all(refusals).to_string());
    };
    // Some mistakes only show in a shipped part, such as a function of the user's that calls its caller.
    let through = if refused.is_none() {
        format!("{}: ", part.part.path)
    } else {
        String::new()
    };
    let problem = format!("{through}{}", Refused::all(refusals));
    Invalid::new(part.key(), problem)
}

/// Composes the kernel of swarms driven from outside: its part's declarations replace the same names.
pub(in crate::parts::compose) fn driven() -> Result<&'static Kernel, Invalid> {
    const NAME: &str = "swarm+driven";
    if let Some(composed) = known().get(NAME) {
        return Ok(composed.kernel);
    }
    let base = &oneiro_shaders::SWARM;
    let kept = base.parts.iter().map(|path| shipped(path)).collect();
    let parts = with(kept, shipped(DRIVEN));
    let made = compiled(&parts, &[]).and_then(|compiled| kernel(base, compiled, NAME));
    let made = made.map_err(|refusals| Invalid::new("kernel", Refused::all(&refusals).to_string()))?;
    let leaked = || Composed {
        kernel: Box::leak(Box::new(made)),
        genes: None,
        files: files(&parts).leak(),
        words: None,
    };
    Ok(known().entry(NAME.to_owned()).or_insert_with(leaked).kernel)
}

/// The paths of a kernel's parts, and where each begins in its text.
fn files(parts: &[compiler::Part]) -> Vec<(String, usize)> {
    let mut begin = 0;
    let file = |part: &compiler::Part| {
        let start = begin;
        begin += part.text.len() + usize::from(!part.text.ends_with('\n'));
        (part.path.clone(), start)
    };
    parts.iter().map(file).collect()
}

/// A compiled kernel instead of another one that has the same buffers.
fn kernel(base: &'static Kernel, compiled: Compiled, name: &str) -> Result<Kernel, Refusals> {
    let bindings = base.bindings.iter().zip(&compiled.bindings);
    let bindings: Vec<_> = bindings
        .map(|(binding, made)| Binding {
            stride: made.stride,
            ..*binding
        })
        .collect();
    let turns = compiled.turns?;
    Ok(Kernel {
        name: name.to_owned().leak(),
        parts: &[],
        wgsl: compiled.wgsl.leak(),
        spirv: compiled.spirv.leak(),
        entry_point: base.entry_point,
        workgroup_size: compiled.workgroup_size,
        bindings: bindings.leak(),
        turns: Turns(Box::leak(Box::new(move |word: &WordOf<'_>| turns.value(word)))),
        variants: &[],
    })
}

/// A new kernel, the genes of a user's controller, its files, and in swarms the words of a world and of
/// each of them.
type New = (Kernel, Option<Vec<Gene>>, Vec<(String, usize)>, Option<[u32; 2]>);

/// The parts of a kernel.
pub(super) struct Assembled {
    pub(super) parts: Vec<compiler::Part>,
    /// Rights of each user's part.
    pub(super) users: Vec<Option<Allowed<'static>>>,
    /// Names that only foragers' or only swarms' kernels have.
    few: BTreeSet<String>,
}

fn assembled(base: &Kernel, custom: &OwnParts, owner: &Owner, mut generated: String) -> Assembled {
    let part = |path: &str, text: &str| compiler::Part {
        path: path.to_owned(),
        text: text.to_owned(),
    };
    let is_kept = |path: &str| path != DETAILS && custom.iter().all(|each| !is_replaced(path, each.part.kind));
    let (episodes, together) = (owner.episodes, owner.together());
    let is_of_robot = |path: &str| is_of_robot(path, &owner.make);
    let is_needed = |path: &str| {
        let is_of_robot = is_of_robot(path);
        if is_of_members(path) || together.is_some() && members::REPLACED.contains(&path) {
            return together.is_some_and(|together| members::is_needed(path, together.hearing, episodes));
        }
        if [EpisodeKind::Simulated, EpisodeKind::Reported, EpisodeKind::Individual]
            .map(physics)
            .contains(&path)
        {
            // A Khepera's surrogate and foragers have their physics elsewhere.
            let is_own = episodes != EpisodeKind::Simulated || base.parts.contains(&path);
            return path == physics(episodes) && is_own && is_of_robot != Some(false);
        }
        if path == DIFFERENCES {
            return episodes == EpisodeKind::Individual;
        }
        [USER, GIVEN].contains(&path) || is_of_robot.unwrap_or_else(|| base.parts.contains(&path) && is_kept(path))
    };
    let names = |parts: &[compiler::Part]| -> BTreeSet<String> {
        let declared = parts.iter().flat_map(declarations);
        declared.map(|item| item.name).collect()
    };
    let needed: Vec<_> = PARTS.iter().filter(|(path, _)| is_needed(path)).collect();
    let (of_robot, others): (Vec<_>, Vec<_>) = needed
        .into_iter()
        .partition(|(path, _)| is_of_robot(path) == Some(true));
    let [of_robot, others] =
        [of_robot, others].map(|parts| -> Vec<_> { parts.into_iter().map(|(path, text)| part(path, text)).collect() });
    // The code generated for a parametric robot replaces declarations of its parts, and a forager's parts those of others.
    let (instead, replaced, kept) = match &owner.make {
        Make::Forager { .. } => (names(&of_robot), others, of_robot),
        _ => (names(&[part(GENERATED, &generated)]), of_robot, others),
    };
    let mut few = BTreeSet::new();
    if let Make::Forager { .. } = owner.make {
        few.clone_from(&instead);
    }
    let replaced = replaced
        .into_iter()
        .map(|found| part(&found.path, &without(&found, &instead)));
    let mut parts: Vec<_> = replaced.chain(kept).collect();
    if let Some(together) = together {
        let (of_members, others): (Vec<_>, Vec<_>) = parts.into_iter().partition(|found| is_of_members(&found.path));
        few = names(&of_members);
        let others = others
            .into_iter()
            .map(|found| part(&found.path, &without(&found, &few)));
        parts = others.chain(of_members).collect();
        let described = [part(GENERATED, &generated)];
        let users: Vec<_> = custom.iter().map(|each| each.part.source()).collect();
        let all = [&parts[..], &described, &users].concat();
        generated += &members::declarations(&all, custom, owner, together, &custom.readings_in(&owner.fields));
    }
    if is_varied(owner) {
        parts = with(parts, shipped(VARIED));
    }
    if owner.grids.objects {
        parts = with(parts, shipped(NEAR));
    }
    if owner.grids.patches {
        parts = with(parts, shipped(PATCHES));
    }
    if owner.grids.objects || owner.grids.patches {
        parts = with(parts, shipped(SQUARES));
    }
    if together.is_some_and(|together| together.pucks > 0) {
        parts = with(parts, shipped(PUCKS));
    }
    if together.is_some_and(|together| together.squares > 0) {
        parts = with(parts, shipped(NEIGHBOURS));
    }
    if owner.has_picture {
        parts = with(parts, shipped(PICTURE));
        if let Make::Described(_) = owner.make {
            parts = with(parts, shipped(PICTURE_READ));
        }
        // A swarm's parts ask for what its robots read.
        if together.is_none() {
            parts = with(parts, shipped(PICTURE_GIVEN));
        }
    }
    if custom.are_commanded() {
        let entry = if together.is_some() {
            members::COMMANDED
        } else {
            COMMANDED
        };
        parts = with(parts, shipped(entry));
    }
    // Other parts that may end an episode are asked after the task.
    for own in custom.iter().filter(|own| own.part.kind != Kind::Task) {
        let Some(end) = own.part.end_function() else { continue };
        let word = own.part.kind.word();
        for physics in parts.iter_mut().filter(|part| part.path.starts_with("physics/")) {
            for me in ["episode", "of_genes(episode)"] {
                let of_task = format!("task_ends({me}, before.task)");
                let of_both = format!("{of_task} | {end}({me}, before.{word})");
                physics.text = physics.text.replace(&of_task, &of_both);
            }
        }
    }
    if custom.iter().any(|each| !each.part.is_of_oneiro) {
        for entry in parts.iter_mut().filter(|part| part.path == ENTRY) {
            entry.text = entry.text.replace(NEXT, KEPT);
        }
    }
    let mut cells = 0;
    for each in custom.iter() {
        let first = interface::of(each.part.kind).first_value();
        let _ = writeln!(generated, "const {first}: u32 = {cells}u;\n{}", each.part.generated);
        cells += each.part.values.len().div_ceil(4);
    }
    let _ = writeln!(generated, "const {}: u32 = {cells}u;", generate::GIVEN_CELL);
    // The user's parts come last, so that a mistake in them changes no place in another.
    parts.push(part(GENERATED, &generated));
    let mut users = vec![None; parts.len()];
    let of_oneiro = parts.len();
    for each in custom.iter() {
        parts.push(each.part.source());
        users.push(Some(check::allowed(each.part.kind)));
    }
    let is_of_user = |at: usize| {
        let each = at.checked_sub(of_oneiro).and_then(|at| custom.iter().nth(at));
        each.is_some_and(|each| !each.part.is_of_oneiro)
    };
    let numbered = parts.iter().enumerate();
    let theirs = numbered
        .filter(|(at, _)| is_of_user(*at))
        .flat_map(|(_, part)| declarations(part));
    let names: BTreeSet<_> = theirs.filter(check::gives_way).map(|item| item.name).collect();
    for (_, part) in parts.iter_mut().enumerate().filter(|(at, _)| !is_of_user(*at)) {
        for name in &names {
            part.text = renamed(part, name, &format!("{name}{OF_ONEIRO}"));
        }
    }
    Assembled { parts, users, few }
}

/// A kernel's parts, of which no text is checked.
#[cfg(test)]
pub(super) fn unchecked(custom: &OwnParts, owner: &Owner) -> Assembled {
    let base = &oneiro_shaders::LIFE_PERCEPTRON;
    let (_, generated) = described(base, custom, owner);
    assembled(base, custom, owner, generated)
}

fn new(
    base: &'static Kernel,
    custom: &OwnParts,
    owner: &Owner,
    generated: String,
    name: &str,
) -> Result<New, Refusals> {
    let Assembled {
        mut parts,
        mut users,
        few,
    } = assembled(base, custom, owner, generated);
    check::of_few(custom, &few)?;
    let mut compiled = compiled(&parts, &users);
    let is_of_generated = |refusals: &Refusals| refusals.iter().any(|refusal| refusal.place.path == GENERATED);
    if compiled.as_ref().is_err_and(is_of_generated) {
        // What is generated repeats names of theirs: read those first, so that the mistake is found where it was made.
        let others = users.iter().take_while(|user| user.is_none()).count();
        parts.rotate_left(others);
        users.rotate_left(others);
        if let Err(refusals) = self::compiled(&parts, &users) {
            compiled = Err(refusals);
        }
    }
    let mut refusals = check::uncalled(&parts, custom);
    let compiled = match compiled {
        Ok(compiled) if refusals.is_empty() => compiled,
        others => {
            refusals.extend(others.err().unwrap_or_default());
            check::suggest(&mut refusals, &parts, custom);
            return Err(refusals);
        }
    };
    let genes = match custom.get(Kind::Controller) {
        Some(controller) => Some(genes(
            &controller.part,
            &compiled,
            &custom.readings_of(&owner.readings()),
        )?),
        None => None,
    };
    let words = members::WORDS.map(|name| number(&compiled, name));
    let words = match words {
        [Some(world), Some(member)] if owner.together().is_some() => Some([world, member]),
        _ => None,
    };
    Ok((kernel(base, compiled, name)?, genes, files(&parts), words))
}

/// The value of a kernel's constant.
fn number(compiled: &Compiled, name: &str) -> Option<u32> {
    let value = compiled.constants.iter().find(|constant| constant.name == name);
    value.and_then(|constant| constant.value.parse::<u32>().ok())
}

/// Compiles parts, of which those with a list are users'. Whatever a user writes must not end the program.
fn compiled(parts: &[compiler::Part], users: &[Option<Allowed<'_>>]) -> Result<Compiled, Refusals> {
    let isolation = Isolation {
        episode: interface::EPISODE,
        users,
    };
    let compiled = panic::catch_unwind(|| {
        compile_isolated("composed", parts, Indices::Clamped, &isolation)
            .and_then(Compiled::bounded)
            .and_then(Compiled::used)
    });
    compiled.unwrap_or_else(|_| Err(vec![failed(parts)]))
}

/// The refusal of what the compiler can't cope with.
fn failed(parts: &[compiler::Part]) -> Refusal {
    let place = compiler::Place {
        path: parts.last().map(|part| part.path.clone()).unwrap_or_default(),
        line: 1,
        column: 1,
    };
    let message = "the compiler failed on this part, which is a mistake in Oneiro: please report it with the part";
    refusal(&place, Rule::Internal, message)
}

/// The genes that a controller declares. `readings` are the names of all readings.
fn genes(controller: &Part, compiled: &Compiled, readings: &[String]) -> Result<Vec<Gene>, Refusals> {
    let number = |name: &str| number(compiled, name);
    let count = number(GENE_COUNT).filter(|number| (1..=GREATEST_GENES).contains(number));
    let Some(count) = count else {
        return Err(vec![gene_count(controller)]);
    };
    if controller.genes.is_empty() {
        return Ok((0..count).map(|index| Gene::new(format!("gene_{index}"))).collect());
    }
    let mut genes: Vec<Gene> = Vec::new();
    let mut taken = BTreeSet::new();
    for (index, field) in controller.genes.iter().enumerate() {
        let end = controller
            .genes
            .get(index + 1)
            .map_or(Some(count), |next| number(&next.constant()));
        let elements = end.unwrap_or(count).saturating_sub(genes.len() as u32) as usize;
        let name = &field.name;
        let names: Vec<String> = match field.count.as_deref() {
            None => vec![name.clone()],
            Some(INPUTS) => readings.iter().map(|reading| format!("{name}_{reading}")).collect(),
            Some(_) => (0..elements).map(|element| format!("{name}_{element}")).collect(),
        };
        if let Some(twice) = names.iter().find(|name| !taken.insert((*name).clone())) {
            let message = format!("in `{GENES}`: `{name}`: another gene is also called `{twice}`; choose another name");
            return Err(vec![refusal(&field.place, Rule::GeneForm, message)]);
        }
        let range = field.range;
        genes.extend(names.into_iter().map(|name| Gene::ranged(name, range)));
    }
    Ok(genes)
}

/// The number of readings.
const INPUTS: &str = "INPUTS";

/// The refusal of a controller's number of genes.
fn gene_count(controller: &Part) -> Refusal {
    let part = controller.source();
    let named = !controller.genes.is_empty();
    let name = if named { GENES } else { GENE_COUNT };
    let declared = declarations(&part).into_iter().find(|declared| declared.name == name);
    let place = declared.expect("a controller declares one of them").place;
    let message = if named {
        format!("`{GENES}` has more than {GREATEST_GENES} genes; allowed: 1 to {GREATEST_GENES}")
    } else {
        format!("`{name}` isn't a number of genes; write `const {name}: u32 = NUMBER;`, 1 to {GREATEST_GENES}")
    };
    refusal(&place, Rule::GeneCount, message)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::parts::compose::OwnPart;
    use crate::world::WorldSpec;

    /// The entry has the line that is replaced: once in a kernel without users' parts, and never in one with them.
    #[test]
    fn the_signs_of_zeros_are_lost_each_cycle() {
        let text = "fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward { return Reward(1.0f, before); }";
        let part = Part::new(Kind::Task, "own.wgsl", text).expect("it is valid");
        let users = OwnParts::from([OwnPart::new(Arc::new(part), &[]).expect("it has no values")]);
        let owner = WorldSpec::miglino1995().unchecked_owner();
        for (custom, lines) in [(OwnParts::default(), [1, 0]), (users, [0, 1])] {
            let assembled = unchecked(&custom, &owner);
            let entry = assembled.parts.iter().find(|part| part.path == ENTRY);
            let entry = entry.expect("single robots have it");
            assert_eq!([NEXT, KEPT].map(|line| entry.text.matches(line).count()), lines);
        }
    }
}
