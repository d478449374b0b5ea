//! WGSL that is generated for worlds of several robots: what they sense of each other, and what their parts remember as words of
//! the world's state.

use std::fmt::Write;

use oneiro_shader_compiler as compiler;
use oneiro_shader_compiler::declarations::members;

use super::fields::{self, Remembered};
use super::interface::{self, MISSION_STATE};
use crate::parts::compose::{EpisodeKind, Hearing, Kind, OwnPart, OwnParts, Owner, Scalar, Together};

/// Parts of worlds of several robots, and those that they take the place of.
pub(super) const PARTS: [&str; 12] = [
    "lib/members.wgsl",
    "members.wgsl",
    COMMANDED,
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
/// Replaces the other declarations where robots are commanded from outside.
pub(super) const COMMANDED: &str = "physics/commanded.wgsl";
const FIRST: &str = "physics/first.wgsl";
const OBSERVED: &str = "physics/observed.wgsl";
const REFERENCE: &str = "sensor/reference.wgsl";
const RM11: &str = "sensor/rm11.wgsl";
const RM12: &str = "sensor/rm12.wgsl";
const VECTORS: &str = "sensor/vectors.wgsl";

/// Whether such a world is made of one of these parts.
pub(super) fn is_needed(path: &str, hearing: Option<Hearing>, episodes: EpisodeKind) -> bool {
    match path {
        COMMANDED => false,
        FIRST => episodes != EpisodeKind::Observed,
        OBSERVED => episodes == EpisodeKind::Observed,
        REFERENCE => hearing.is_some(),
        RM11 | RM12 | VECTORS => hearing.is_some_and(|hearing| hearing.part == path),
        _ => PARTS.contains(&path),
    }
}

pub(super) const REPLACED: [&str; 2] = ["episode.wgsl", "physics/sampled.wgsl"];

/// Names of the numbers of words of a world and of a robot.
pub(super) const WORDS: [&str; 2] = ["WORLD_WORDS", "MEMBER_WORDS"];

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
    /// The code that saves those that have not been taken.
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
                format!("number(words, {place})"),
                format!("put(words, {place}, {expression})"),
            ),
            Scalar::Unsigned => (
                format!("word(words, {place})"),
                format!("put_word(words, {place}, {expression})"),
            ),
            Scalar::Signed => (
                format!("bitcast<i32>(word(words, {place}))"),
                format!("put_word(words, {place}, bitcast<u32>({expression}))"),
            ),
        };
        let _ = writeln!(self.save, "    {save};");
        load
    }

    /// A field of `memory`.
    fn field(&mut self, Remembered { ty, scalar, scalars }: &Remembered) -> String {
        let words: Vec<_> = scalars
            .iter()
            .map(|name| self.next(&format!("memory.{name}"), *scalar))
            .collect();
        format!("{ty}({})", words.join(", "))
    }
}

/// What swarms need besides the parts of a kernel: their numbers of words, functions that load and save what
/// parts remember, and what each robot earns. `readings` are the fields of `Readings`.
pub(super) fn declarations(
    parts: &[compiler::Part],
    custom: &OwnParts,
    owner: &Owner,
    together: Together,
    readings: &[String],
) -> String {
    let mut text = String::new();
    let task = custom.get(Kind::Task).map(OwnPart::part);
    let functions = |name: &str| task.is_some_and(|part| part.functions().contains(&name));
    let earns_alone = custom.scores_each();
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
            "fn {word}_loaded(words: u32) -> {structure} {{
    return {structure}({});
}}
fn save_{word}(words: u32, memory: {structure}) {{
{save}}}
",
            loaded.join(", ")
        );
    }
    let is_observed = owner.episodes == EpisodeKind::Observed;
    let is_commanded = custom.are_commanded();
    text += &if earns_alone || is_observed || is_commanded {
        kept(&mut of_member, readings)
    } else {
        "fn keep_act(words: u32, did: Act) {\n}\n".to_owned()
    };
    text += if earns_alone { EARNED } else { NOTHING_EARNED };
    if is_observed {
        text += &observed(together.count, &mut of_member);
    }
    if is_commanded {
        let _ = writeln!(text, "const MEMBER_EARNED: u32 = MEMBER_MEMORY + {}u;", of_member.count);
        of_member.count += 1;
    }
    text += &heard(together, &mut of_world, &mut of_member);
    if together.squares > 0 {
        text += &squares(together, &mut of_world, &mut of_member);
    }
    if together.pucks > 0 {
        let _ = writeln!(text, "const MEMBER_HELD: u32 = MEMBER_MEMORY + {}u;", of_member.count);
        of_member.count += 1;
    }
    let [world, member] = WORDS;
    let _ = writeln!(
        text,
        "const {world}: u32 = WORLD_MEMORY + {}u;\nconst {member}: u32 = MEMBER_MEMORY + {}u;",
        of_world.count, of_member.count
    );
    text
}

/// Words for the lists of a world's squares: see `lib/neighbours.wgsl`.
fn squares(together: Together, of_world: &mut Words, of_member: &mut Words) -> String {
    let Together {
        count,
        pucks,
        squares,
        rows,
        ..
    } = together;
    let (first, member) = (of_world.count, of_member.count);
    of_member.count += 2;
    of_world.count += (squares + 1 + count + pucks) as usize;
    format!(
        "const MOST_SQUARES: u32 = {squares}u;
const MOST_ROWS: u32 = {rows}u;
const MEMBER_LISTED: u32 = MEMBER_MEMORY + {member}u;
const WORLD_SQUARES: u32 = WORLD_MEMORY + {first}u;
const WORLD_LISTED: u32 = WORLD_SQUARES + MOST_SQUARES + 1u;
"
    )
}

/// Words for messages and the floor. Each robot has a word for the floor, one for the number of messages received in this
/// cycle, and two for the messages of each of the last cycles. The world has a word for each message of a cycle.
fn heard(Together { count, hearing, .. }: Together, of_world: &mut Words, of_member: &mut Words) -> String {
    let Some(Hearing { cycles, .. }) = hearing else {
        return "fn hear(episode: Episode, step: u32) {\n}\n".to_owned();
    };
    let (member, world) = (of_member.count, of_world.count);
    of_member.count += 2 + 2 * cycles as usize;
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

/// A robot's readings and actions, kept until all have moved.
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
        "fn keep_act(words: u32, did: Act) {{
{save}}}
fn act_kept(words: u32) -> Act {{
    var did = Act();
{load}    return did;
}}
"
    )
}

/// What robots earn where none earns alone, and where each does.
const NOTHING_EARNED: &str = "fn members_earned(episode: Episode, step: u32) -> f32 {
    return 0.0f;
}
";
const EARNED: &str = "fn members_earned(episode: Episode, step: u32) -> f32 {
    let count = member_count(episode.world);
    var earned = 0.0f;
    for (var member = 0u; member < count; member++) {
        let me = member_episode(episode, member);
        let words = me.member_words;
        let reward = task_cycle(me, experience(words, step, act_kept(words)), task_loaded(words));
        save_task(words, reward.state);
        keep_earned(words, reward.earned);
        earned += reward.earned;
    }
    return earned;
}
";
