//! What a cycle costs a GPU: the operations of a kernel, counted by its compiler.

use oneiro_shader_compiler::count::{self, Counted};
use oneiro_shader_compiler::interpret::Memory;
use oneiro_shader_compiler::tree::Program;
use oneiro_shaders::life::Dispatch;

use super::specialised::{Setting, parsed, program};
use crate::batch::Part;

/// What a group of rollouts does in a number of cycles, all of its rollouts together. What some of them do, the others wait for.
#[derive(Clone, Debug)]
pub struct Cost {
    /// Cycles counted.
    pub cycles: u32,
    /// By the kernel that takes any world.
    pub any: Counted,
    /// By the kernel that is specialised to the world.
    pub specialised: Counted,
}

/// Counts what the first group of a part does in its cycles after the first `begin`.
///
/// # Errors
/// A mistake of the compiler.
pub fn cost(part: &Part<'_>, begin: u32) -> Result<Cost, String> {
    let cycles = part.cycles();
    let setting = Setting::of(part, part.group_table()[0].world);
    let generic = parsed(setting.kernel)?;
    let (_, own) = program(&generic, &setting);
    let of = |program| {
        let until = |end| counted(part, program, end);
        let (all, first) = (until(cycles.end)?, until(cycles.start + begin)?);
        Ok::<_, String>(all.since(&first))
    };
    Ok(Cost {
        cycles: cycles.end - cycles.start - begin,
        any: of(generic.any())?,
        specialised: of(&own)?,
    })
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

/// A part's buffers, by binding number, for whoever runs its kernel by other means. The part is the beginning of its batch, lives from its
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
