//! WGSL that is generated for worlds of several robots: what they sense of each other, and what their parts remember as words of
//! the world's state.

use std::fmt::Write;

use oneiro_shader_compiler as compiler;
use oneiro_shader_compiler::declarations::members;

use super::fields::{self, Remembered};
use super::interface::{self, MISSION_STATE};
use crate::parts::compose::{Kind, Lives, OwnPart, OwnParts, Scalar};
use crate::world::Build;
use crate::world::WorldSpec;
use crate::world::arena::Arena;
use crate::world::differential::{Differential, GREATEST_MEMBERS, Genomes};
use crate::world::reference::{Model, Reference};

/// Parts of worlds of several robots, and those that they take the place of.
pub(super) const PARTS: [&str; 11] = [
    "lib/members.wgsl",
    "members.wgsl",
    "physics/contacts.wgsl",
    FIRST,
    "physics/members.wgsl",
    OBSERVED,
    "sensor/others.wgsl",
    REFERENCE,
    RM11,
    RM12,
    VECTORS,
];
const FIRST: &str = "physics/first.wgsl";
const OBSERVED: &str = "physics/observed.wgsl";
const REFERENCE: &str = "sensor/reference.wgsl";
const RM11: &str = "sensor/rm11.wgsl";
const RM12: &str = "sensor/rm12.wgsl";
const VECTORS: &str = "sensor/vectors.wgsl";

/// Whether such a world is made of one of these parts.
pub(super) fn is_needed(path: &str, robot: &Build, lives: Lives) -> bool {
    let model = match robot {
        Build::Differential(own) => own.model,
        Build::Sampled | Build::Forager(_) => None,
    };
    match path {
        FIRST => lives != Lives::Observed,
        OBSERVED => lives == Lives::Observed,
        REFERENCE => model.is_some(),
        RM11 => model == Some(Model::Rm11),
        RM12 => model == Some(Model::Rm12),
        VECTORS => model == Some(Model::Vectors),
        _ => PARTS.contains(&path),
    }
}

pub(super) const REPLACED: [&str; 2] = ["life.wgsl", "physics/sampled.wgsl"];

/// Names of the numbers of words of a world and of a robot.
pub(super) const WORDS: [&str; 2] = ["WORLD_WORDS", "MEMBER_WORDS"];

/// What a robot's sensors notice of the others, given what is done for each other robot, for those that press bumpers, and the
/// widest range of a bumper. None of a single robot's.
pub(super) fn among(robot: &Differential, others: &str, pressing: &str, widest: &str) -> String {
    if robot.count.is_none() || others.is_empty() && pressing.is_empty() {
        return String::new();
    }
    let pressed = if pressing.is_empty() {
        String::new()
    } else {
        format!(
            "            let near = 2.0f * members.body + {widest};
            if (squared < near * near) {{
                let bearing = direction(to);
{pressing}            }}
"
        )
    };
    format!(
        "    let members = members_of(world);
    let body_squared = members.body * members.body;
    let count = member_count(world);
    for (var other = 0u; other < count; other++) {{
        let there = place_in(member_at(life, other), MEMBER_X);
        let to = vec2<f32>(there.x - at.x, there.y - at.y);
        let squared = squared_length(to);
        if ((other != life.member) & (squared < members.reach_squared)) {{
{others}{pressed}        }}
    }}
"
    )
}

/// A kind of memory: the word that its functions' names end with, its struct, and whose words it is among.
struct Memory {
    word: &'static str,
    structure: &'static str,
    is_of_world: bool,
}

const MEMORIES: [Memory; 5] = [
    Memory {
        word: "controller",
        structure: "ControllerState",
        is_of_world: false,
    },
    Memory {
        word: "sensor",
        structure: "SensorState",
        is_of_world: false,
    },
    Memory {
        word: "task",
        structure: "TaskState",
        is_of_world: false,
    },
    Memory {
        word: "robot",
        structure: "RobotState",
        is_of_world: false,
    },
    Memory {
        word: "mission",
        structure: MISSION_STATE,
        is_of_world: true,
    },
];

/// Words in the order that they get.
struct Words {
    begin: &'static str,
    count: usize,
    /// What saves those that have not been taken.
    save: String,
}

impl Words {
    fn new(begin: &'static str) -> Self {
        Self {
            begin,
            count: 0,
            save: String::new(),
        }
    }

    /// The next word holds a scalar; returns the expression that reads it, and adds to what saves it.
    fn next(&mut self, expression: &str, scalar: Scalar) -> String {
        let place = format!("{} + {}u", self.begin, self.count);
        self.count += 1;
        let (load, save) = match scalar {
            Scalar::Float => (
                format!("number(own, {place})"),
                format!("put(own, {place}, {expression})"),
            ),
            Scalar::Unsigned => (
                format!("word(own, {place})"),
                format!("put_word(own, {place}, {expression})"),
            ),
            Scalar::Signed => (
                format!("bitcast<i32>(word(own, {place}))"),
                format!("put_word(own, {place}, bitcast<u32>({expression}))"),
            ),
        };
        let _ = writeln!(self.save, "    {save};");
        load
    }

    /// A field of `memory`.
    fn field(&mut self, Remembered { ty, scalar, scalars }: &Remembered) -> String {
        let words: Vec<_> = scalars
            .iter()
            .map(|own| self.next(&format!("memory.{own}"), *scalar))
            .collect();
        format!("{ty}({})", words.join(", "))
    }
}

/// What robots that live together need beside the parts of a kernel: their numbers of words, functions that load and save what
/// parts remember, and what each robot earns. `readings` are the fields of `Readings`.
pub(super) fn declarations(
    parts: &[compiler::Part],
    own: &OwnParts,
    spec: &WorldSpec,
    lives: Lives,
    readings: &[String],
) -> String {
    let mut text = String::new();
    let task = own.get(Kind::Task).map(OwnPart::part);
    let functions = |name: &str| task.is_some_and(|part| part.functions().contains(&name));
    let earns_alone = own.scores_each();
    let declares = |structure: &str| parts.iter().find(|part| members(part, structure).is_some());
    if declares(MISSION_STATE).is_none() {
        // No struct is empty.
        let _ = writeln!(text, "struct {MISSION_STATE} {{ unused: u32 }}");
    }
    for function in interface::of(Kind::Task).mission {
        if let Some(body) = function.default.filter(|_| !functions(function.name())) {
            let _ = writeln!(text, "{} {{ {body} }}", function.text);
        }
    }
    let mut of_member = Words::new("MEMBER_MEMORY");
    let mut of_world = Words::new("WORLD_MEMORY");
    for Memory {
        word,
        structure,
        is_of_world,
    } in MEMORIES
    {
        let words = if is_of_world { &mut of_world } else { &mut of_member };
        let found = declares(structure);
        let fields = found.map_or_else(Vec::new, |part| fields::memory(part, structure, &mut Vec::new()));
        let fields = fields.into_iter().filter(|field| field.scalars != ["unused"]);
        let loaded: Vec<_> = fields.map(|field| words.field(&field)).collect();
        let save = std::mem::take(&mut words.save);
        let _ = write!(
            text,
            "fn {word}_loaded(own: u32) -> {structure} {{
    return {structure}({});
}}
fn save_{word}(own: u32, memory: {structure}) {{
{save}}}
",
            loaded.join(", ")
        );
    }
    let is_observed = lives == Lives::Observed;
    text += &if earns_alone || is_observed {
        kept(&mut of_member, readings)
    } else {
        "fn keep_act(own: u32, did: Act) {\n}\n".to_owned()
    };
    text += if earns_alone { EARNED } else { NOTHING_EARNED };
    if is_observed {
        text += &observed(spec.robot.members().unwrap_or(1), &mut of_member);
    }
    if let Build::Differential(robot) = &spec.robot.build {
        text += &heard(robot, &mut of_world, &mut of_member);
    }
    let [world, member] = WORDS;
    let _ = writeln!(
        text,
        "const {world}: u32 = WORLD_MEMORY + {}u;\nconst {member}: u32 = MEMBER_MEMORY + {}u;",
        of_world.count, of_member.count
    );
    text
}

/// Where what robots hear and see of the floor is kept: of each robot a word for the floor, one for the number that it heard in this
/// cycle, and two for what it heard in each of the last cycles; of the world a word for each message of a cycle.
fn heard(robot: &Differential, of_world: &mut Words, of_member: &mut Words) -> String {
    let (Some(_), Some(count)) = (robot.model, robot.count) else {
        return "fn hear(life: Life, step: u32) {\n}\n".to_owned();
    };
    let cycles = robot.reference.cycles() as usize;
    let (member, world) = (of_member.count, of_world.count);
    of_member.count += 2 + 2 * cycles;
    of_world.count += (count * count) as usize;
    format!(
        "const MEMBER_FLOOR: u32 = MEMBER_MEMORY + {member}u;
const MEMBER_HEARD: u32 = MEMBER_FLOOR + 1u;
const MEMBER_MESSAGES: u32 = MEMBER_FLOOR + 2u;
const HEARD_CYCLES: u32 = {cycles}u;
const WORLD_MESSAGES: u32 = WORLD_MEMORY + {world}u;
"
    )
}

/// Where an observed robot keeps what it has earned, and whose messages it has heard.
fn observed(count: u32, words: &mut Words) -> String {
    let (first, senders) = (words.count, count.div_ceil(u32::BITS));
    words.count += 1 + senders as usize;
    format!(
        "const MEMBER_EARNED: u32 = MEMBER_MEMORY + {first}u;
const MEMBER_SENDERS: u32 = MEMBER_EARNED + 1u;
const SENDER_WORDS: u32 = {senders}u;
"
    )
}

/// What a robot read and did, kept until all have moved.
fn kept(words: &mut Words, readings: &[String]) -> String {
    let mut load = String::new();
    for of in ["real", "perceived"] {
        for field in readings {
            let word = words.next(&format!("did.{of}.{field}"), Scalar::Float);
            let _ = writeln!(load, "    did.{of}.{field} = {word};");
        }
    }
    for field in [
        "outputs.x",
        "outputs.y",
        "moved.displacement",
        "moved.turn",
        "moved.left",
        "moved.right",
    ] {
        let word = words.next(&format!("did.{field}"), Scalar::Float);
        let _ = writeln!(load, "    did.{field} = {word};");
    }
    let save = std::mem::take(&mut words.save);
    format!(
        "fn keep_act(own: u32, did: Act) {{
{save}}}
fn act_kept(own: u32) -> Act {{
    var did = Act();
{load}    return did;
}}
"
    )
}

/// What robots earn where none earns alone, and where each does.
const NOTHING_EARNED: &str = "fn members_earned(life: Life, step: u32) -> f32 {
    return 0.0f;
}
";
const EARNED: &str = "fn members_earned(life: Life, step: u32) -> f32 {
    let count = member_count(life.world);
    var earned = 0.0f;
    for (var member = 0u; member < count; member++) {
        let me = member_life(life, member);
        let own = me.member_words;
        let reward = task_cycle(me, experience(own, step, act_kept(own)), task_loaded(own));
        save_task(own, reward.state);
        keep_earned(own, reward.earned);
        earned += reward.earned;
    }
    return earned;
}
";

/// Where a robot starts: at its own place, or at a drawn one.
fn start_place(robot: &Differential, arena: &Arena) -> String {
    if robot.starts.is_some() {
        let first = robot.differing_cell(arena);
        return format!("    let cell = numbers(world, {first}u + member);\n    return vec2<f32>(cell.x, cell.y);\n");
    }
    let place = if arena.is_field_round {
        "vec2<f32>(0.5f, 0.5f) + (0.5f * root(u.x)) * cosine_sine(u.y)"
    } else {
        "vec2<f32>(u.x, u.y)"
    };
    format!(
        "    let place = {place};
    return vec2<f32>(
        worlds[world].field_x + place.x * worlds[world].field_width,
        worlds[world].field_y + place.y * worlds[world].field_height,
    );
"
    )
}

/// The index of a robot's first gene.
fn first_gene(robot: &Differential, arena: &Arena) -> String {
    match robot.genomes {
        Genomes::Homogeneous => "life.genes".to_owned(),
        Genomes::Heterogeneous | Genomes::Teams(_) => {
            let first = robot.differing_cell(arena);
            format!("life.genes + u32(numbers(life.world, {first}u + member).z) * LANES")
        }
    }
}

/// Constants of a robot's world.
pub(super) fn constants(robot: &Differential, arena: &Arena, body_radius: f32) -> String {
    let mut text = format!(
        "const GREATEST_MEMBERS: u32 = {GREATEST_MEMBERS}u;
const MEMBERS_CELL: u32 = {}u;
fn start_place(world: u32, member: u32, u: vec4<f32>) -> vec2<f32> {{
{}}}
fn first_gene(life: Life, member: u32) -> u32 {{
    return {};
}}
",
        robot.members_cell(arena),
        start_place(robot, arena),
        first_gene(robot, arena)
    );
    if robot.model.is_some() {
        let (cell, sides) = (robot.reference_cell(arena), arena.sides);
        let inner = arena.walls.len() - sides + arena.obstacles.len() + arena.blocks.len();
        let hiding = inner + if arena.sides_hide_lamps(body_radius) { sides } else { 0 };
        let _ = write!(
            text,
            "const REFERENCE_CELL: u32 = {cell}u;
const LAMP_CELL: u32 = {}u;
const INNER_COUNT: u32 = {inner}u;
const SIDE_COUNT: u32 = {sides}u;
const HIDING_COUNT: u32 = {hiding}u;
",
            cell + Reference::CELLS,
        );
    }
    text
}
