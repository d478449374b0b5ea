//! A controller by itself, without sensors, arena and task, and a world by itself, without a controller: the kernels that are printed in
//! other languages.

use std::fmt::Write;

use oneiro_shader_compiler as compiler;
use oneiro_shader_compiler::Generic;
use oneiro_shader_compiler::declarations::{declarations, members, renamed};
use oneiro_shaders::Kernel;

use super::fields::{self, Remembered};
use super::kernel::{GENERATED, OF_ONEIRO, parts_of, shipped, with};
use crate::parameter::Invalid;
use crate::parts::compose::{OwnParts, Refused, Scalar};

const ENTRY: &str = "exported.wgsl";
const ENTRY_OF_WORLD: &str = "simulated.wgsl";
const ENTRY_OF_SWARM: &str = "simulated_members.wgsl";
const MEMORY: &str = "ControllerState";

/// The part of a forager's behaviours, which read their sensors themselves, and that of given readings.
const BEHAVIOURS: &str = "controller/foraging.wgsl";
const GIVEN_SENSORS: &str = "robot/epuck_given.wgsl";

/// The words of `exported` before what the controller remembers, after which come the readings, the outputs and the wheels' speeds.
pub(crate) const HEAD: [&str; 4] = ["key_0", "key_1", "trial", "cycle"];
/// Its words after the readings.
pub(crate) const TAIL: [&str; 4] = ["left", "right", "speed_left", "speed_right"];

/// The speeds of a robot's wheels; those of sampled motors of which each state has one, the first word of its cell; and those of a forager,
/// which controller/outputs.wgsl has.
const OF_MOTION: &str = "fn exported_speeds(episode: Episode, outputs: vec2<f32>) -> vec2<f32> {
    let moved = motion(episode, 0u, outputs, RobotState()).motion;
    return vec2<f32>(moved.left, moved.right);
}
";
const OF_STATES: &str = "fn exported_speeds(episode: Episode, outputs: vec2<f32>) -> vec2<f32> {
    let left = tables[motor_state(episode.world, outputs.x)].x;
    let right = tables[motor_state(episode.world, outputs.y)].x;
    return vec2<f32>(bitcast<f32>(left), bitcast<f32>(right));
}
";
const OF_OUTPUTS: &str = "fn exported_speeds(episode: Episode, outputs: vec2<f32>) -> vec2<f32> {
    return 2.0f * outputs - vec2<f32>(1.0f, 1.0f);
}
";

/// Such a kernel.
pub(crate) struct Exported {
    pub(crate) kernel: Generic,
    /// The scalars that the controller remembers.
    pub(crate) memory: Vec<(String, Scalar)>,
}

/// The controller of a kernel, which has a robot's readings in these fields; of a swarm, the one with this number. `has_states` is whether `tables` has the speed of each state
/// of its motors.
///
/// # Errors
/// A controller that can't stand by itself.
pub(in crate::parts::compose) fn exported(
    kernel: &Kernel,
    own: &OwnParts,
    fields: &[String],
    robot: u32,
    has_states: bool,
) -> Result<Exported, Invalid> {
    let parts = parts_of_one(kernel);
    let memory: Vec<Remembered> = parts
        .iter()
        .find(|part| members(part, MEMORY).is_some())
        .map_or_else(Vec::new, |part| fields::memory(part, MEMORY, &mut Vec::new()))
        .into_iter()
        .filter(|field| field.scalars != ["unused"])
        .collect();
    let is_of_swarm = parts.iter().any(|part| part.path == "lib/members.wgsl");
    let items: Vec<_> = parts.iter().flat_map(declarations).collect();
    let speeds = if has_states {
        OF_STATES
    } else if items.iter().any(|item| item.name == "motion") {
        OF_MOTION
    } else {
        OF_OUTPUTS
    };
    let generated = compiler::Part {
        path: GENERATED.to_owned(),
        text: declared(&memory, &own.readings_in(fields), is_of_swarm.then_some(robot)) + speeds,
    };
    let behaves = parts.iter().any(|part| part.path == BEHAVIOURS);
    let sensors = behaves.then(|| shipped(GIVEN_SENSORS));
    let entry = sensors.into_iter().chain([shipped(ENTRY), generated]).collect();
    let kernel = entered("controller", parts, entry)?;
    let scalars = |field: Remembered| field.scalars.into_iter().map(move |name| (name, field.scalar));
    Ok(Exported {
        kernel,
        memory: memory.into_iter().flat_map(scalars).collect(),
    })
}

/// The world of a kernel of robots that are commanded from outside.
///
/// # Errors
/// A world that can't stand by itself.
pub(in crate::parts::compose) fn simulated(kernel: &Kernel) -> Result<Generic, Invalid> {
    let parts = parts_of_one(kernel);
    let is_of_swarm = parts.iter().any(|part| part.path == "lib/members.wgsl");
    let entry = if is_of_swarm { ENTRY_OF_SWARM } else { ENTRY_OF_WORLD };
    entered("world", parts, vec![shipped(entry)])
}

/// A kernel's parts, for one lane, so that genes lie next to each other.
fn parts_of_one(kernel: &Kernel) -> Vec<compiler::Part> {
    let mut parts = parts_of(kernel);
    for part in &mut parts {
        part.text = part.text.replace("const LANES: u32 = 64u;", "const LANES: u32 = 1u;");
    }
    parts
}

/// A kernel of these parts with another entry; `what` it is, for messages.
fn entered(what: &str, parts: Vec<compiler::Part>, entry: Vec<compiler::Part>) -> Result<Generic, Invalid> {
    // Oneiro's names that gave way to a user's have another end.
    let names = parts.iter().flat_map(declarations).map(|item| item.name);
    let gave_way: Vec<String> = names
        .filter_map(|name| name.strip_suffix(OF_ONEIRO).map(str::to_owned))
        .collect();
    let renamed_entry = entry.into_iter().map(|mut part| {
        for name in &gave_way {
            part.text = renamed(&part, name, &format!("{name}{OF_ONEIRO}"));
        }
        part
    });
    let parts = renamed_entry.fold(parts, with);
    Generic::new(&parts)
        .map_err(|refusals| Invalid::new(what, format!("can't stand by itself: {}", Refused::all(&refusals))))
}

/// The struct of what the caller has, and the functions that read and write it.
fn declared(memory: &[Remembered], readings: &[String], member: Option<u32>) -> String {
    let [key_0, key_1, trial, _] = HEAD;
    let mut fields = HEAD.map(|name| format!("    {name}: u32,\n")).concat();
    let (mut loaded, mut kept) = (Vec::new(), String::new());
    let mut count = 0;
    for field in memory {
        let mut words = Vec::new();
        for name in &field.scalars {
            let _ = writeln!(fields, "    m{count}: {},", field.scalar.wgsl());
            let _ = writeln!(kept, "    exported.m{count} = memory.{name};");
            words.push(format!("exported.m{count}"));
            count += 1;
        }
        loaded.push(format!("{}({})", field.ty, words.join(", ")));
    }
    let mut given = String::new();
    for (index, field) in readings.iter().enumerate() {
        let _ = writeln!(fields, "    r{index}: f32,");
        let _ = writeln!(given, "    readings.{field} = exported.r{index};");
    }
    fields += &TAIL.map(|name| format!("    {name}: f32,\n")).concat();
    let of_swarm = member.map_or_else(String::new, |member| format!(", 0u, 0u, {member}u"));
    format!(
        "struct Exported {{
{fields}}}
@group(0) @binding(9) var<storage, read_write> exported: Exported;
fn exported_episode() -> Episode {{
    return Episode(0u, vec2<u32>(exported.{key_0}, exported.{key_1}), KEY_WORDS, exported.{trial}{of_swarm});
}}
fn exported_memory() -> {MEMORY} {{
    return {MEMORY}({});
}}
fn keep_exported(memory: {MEMORY}) {{
{kept}}}
fn exported_readings() -> Readings {{
    var readings = Readings();
{given}    return readings;
}}
",
        loaded.join(", ")
    )
}
