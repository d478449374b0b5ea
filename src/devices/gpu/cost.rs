//! What a cycle costs a GPU: the operations of a kernel, counted by its compiler.

use std::collections::BTreeMap;

use oneiro_shader_compiler::Generic;
use oneiro_shader_compiler::count::{self, Counted};
use oneiro_shader_compiler::interpret::Memory;
use oneiro_shader_compiler::tree::Program;
use oneiro_shaders::Kernel;
use oneiro_shaders::episode::Dispatch;

use crate::batch::Part;
use crate::devices::variants::{Setting, parsed, program};
use crate::parts::compose;

/// What a group of episodes does in a number of cycles, all of its episodes together. What some of them do, the others wait for.
#[derive(Clone, Debug)]
pub struct Cost {
    /// Cycles counted.
    pub cycles: u32,
    /// By the kernel that takes any world.
    pub any: Counted,
    /// By the kernel that is specialised to the world.
    pub specialised: Counted,
    /// Its operations by lines of the kernel's files, the dearest first. A line of a user's part has those of all that it calls.
    pub lines: Vec<Line>,
}

/// A line of a kernel.
#[derive(Clone, Debug)]
pub struct Line {
    /// Path of its file: a user's part, or one that ships.
    pub path: String,
    /// Number, counted from 1.
    pub line: usize,
    /// Its text.
    pub text: String,
    /// Operations.
    pub operations: u64,
}

/// Counts what the first group of a part does in its cycles after the first `begin`.
///
/// # Errors
/// A mistake of the compiler.
pub fn cost(part: &Part<'_>, begin: u32) -> Result<Cost, String> {
    let cycles = part.cycles();
    let setting = Setting::of(part, part.group_table()[0].world);
    let generic = parsed(setting.kernel)?;
    let (_, specialised_program) = program(&generic, &setting);
    let of = |program| {
        let until = |end| counted(part, program, end);
        let (all, first) = (until(cycles.end)?, until(cycles.start + begin)?);
        Ok::<_, String>(all.since(&first))
    };
    let specialised = of(&specialised_program)?;
    Ok(Cost {
        cycles: cycles.end - cycles.start - begin,
        any: of(generic.any())?,
        lines: lines(setting.kernel, &generic, &specialised_program, &specialised),
        specialised,
    })
}

/// Operations by lines.
fn lines(kernel: &'static Kernel, generic: &Generic, program: &Program, counted: &Counted) -> Vec<Line> {
    let mut all: BTreeMap<(String, usize), u64> = BTreeMap::new();
    for (value, count) in &counted.values {
        let mut places = generic.places(program, *value);
        let of_user = places.iter().position(|place| compose::is_of_user(kernel, &place.path));
        let place = places.swap_remove(of_user.unwrap_or_default());
        *all.entry((place.path, place.line)).or_default() += count;
    }
    let texts: BTreeMap<String, String> = compose::parts_of(kernel)
        .into_iter()
        .map(|part| (part.path, part.text))
        .collect();
    let line = |((path, line), operations): ((String, usize), u64)| {
        let text = texts.get(&path).and_then(|text| text.lines().nth(line - 1));
        Line {
            text: text.unwrap_or_default().trim().to_owned(),
            path,
            line,
            operations,
        }
    };
    let mut all: Vec<Line> = all.into_iter().map(line).collect();
    all.sort_by_key(|line| std::cmp::Reverse(line.operations));
    all
}

/// What the first group does from the part's first cycle to `end`.
fn counted(part: &Part<'_>, program: &Program, end: u32) -> Result<Counted, String> {
    let bindings = part.kernel().bindings;
    let strides: Vec<u32> = bindings.iter().map(|binding| binding.stride / 4).collect();
    let mut memory = Memory {
        buffers: &mut buffers(part, end),
        strides: &strides,
    };
    count::count(program, &mut memory, 0, part.group_table()[0].rollouts).map_err(|trap| trap.to_string())
}

/// A part's buffers, by binding number, for whoever runs its kernel by other means. The part is the beginning of its batch, episodes from its
/// first cycle to `end`, and has no trace.
pub fn buffers(part: &Part<'_>, end: u32) -> [Vec<u32>; 9] {
    let batch = part.batch();
    let dispatch = Dispatch {
        step_begin: part.cycles().start,
        step_end: end,
        trace_every: 0,
        trace_records: 0,
        trace_begin: 0,
        first_input: part.first_input(),
        state_words: batch.state_words() as u32,
        record_words: batch.record_words() as u32,
    };
    let words = |words: &[u32]| words.to_vec();
    let mut states = words(part.states());
    states.resize(part.slots() * batch.state_words(), 0);
    [
        words(bytemuck::cast_slice(std::slice::from_ref(&dispatch))),
        words(bytemuck::cast_slice(part.worlds())),
        words(bytemuck::cast_slice(part.shapes())),
        words(bytemuck::cast_slice(part.tables())),
        words(bytemuck::cast_slice(part.group_table())),
        words(part.inputs()),
        states,
        vec![0; part.slots()],
        vec![0; batch.record_words()],
    ]
}
