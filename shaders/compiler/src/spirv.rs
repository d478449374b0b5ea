//! Writes SPIR-V that a driver may not reassociate, contract or round otherwise.

use naga::back::spv;
use naga::proc::{BoundsCheckPolicies, BoundsCheckPolicy};
use naga::valid::ModuleInfo;

/// Words before the first instruction.
const HEADER: usize = 5;
/// Index of the word with the first unused id.
const ID_BOUND: usize = 3;
const OP_EXT_INST: u32 = 12;
/// Numbers of instructions in GLSL.std.450.
const F_MIN: u32 = 37;
const F_MAX: u32 = 40;
const F_CLAMP: u32 = 43;
const S_CLAMP: u32 = 45;
const OP_DECORATE: u32 = 71;
const OP_TYPE_VOID: u32 = 19;
const OP_TYPE_FORWARD_POINTER: u32 = 39;
const NO_CONTRACTION: u32 = 42;

/// Indices of elements of buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Indices {
    /// Any: beyond the last element is the last one.
    Clamped,
    /// Those of a kernel that was seen never to leave its buffers. Where one does nevertheless, the driver keeps it within the buffer's
    /// memory, but no result is defined.
    Within,
}

/// Writes a module with every option pinned and `NoContraction` on every float arithmetic result.
///
/// # Errors
/// Errors of naga's writer.
pub(crate) fn write(module: &naga::Module, info: &ModuleInfo, indices: Indices) -> Result<Vec<u32>, String> {
    let options = spv::Options {
        lang_version: (1, 3),
        flags: spv::WriterFlags::empty(),
        fake_missing_bindings: false,
        binding_map: module
            .global_variables
            .iter()
            .filter_map(|(_, v)| v.binding)
            .map(own_place)
            .collect(),
        capabilities: None,
        bounds_check_policies: BoundsCheckPolicies {
            index: BoundsCheckPolicy::Restrict,
            buffer: match indices {
                Indices::Clamped => BoundsCheckPolicy::Restrict,
                Indices::Within => BoundsCheckPolicy::Unchecked,
            },
            image_load: BoundsCheckPolicy::Restrict,
            binding_array: BoundsCheckPolicy::Restrict,
        },
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::None,
        force_loop_bounding: false,
        ray_query_initialization_tracking: false,
        trace_ray_argument_validation: false,
        use_storage_input_output_16: false,
        debug_info: None,
        task_dispatch_limits: None,
        mesh_shader_primitive_indices_clamp: false,
        emit_int_div_checks: true,
    };
    let words = spv::write_vec(module, info, &options, None).map_err(|error| error.to_string())?;
    Ok(without_contraction(&without_clamps(&words), &[]))
}

/// Gives each binding its number in the WGSL.
fn own_place(binding: naga::ResourceBinding) -> (naga::ResourceBinding, spv::BindingInfo) {
    let info = spv::BindingInfo {
        descriptor_set: binding.group,
        binding: binding.binding,
        binding_array_size: None,
    };
    (binding, info)
}

/// Turns each `clamp(x, low, high)` into `min(max(x, low), high)`, which is also defined for `low > high`.
fn without_clamps(words: &[u32]) -> Vec<u32> {
    let mut out = words[..HEADER].to_vec();
    for (at, opcode, length) in instructions(words) {
        let instruction = &words[at..at + length];
        match *instruction {
            [head, ty, result, set, clamp @ F_CLAMP..=S_CLAMP, x, low, high] if opcode == OP_EXT_INST => {
                let above = out[ID_BOUND];
                out[ID_BOUND] += 1;
                // Minimum, maximum and clamp each have three instructions, in the same order of types.
                let (min, max) = (clamp - F_CLAMP + F_MIN, clamp - F_CLAMP + F_MAX);
                out.extend([head - (1 << 16), ty, above, set, max, x, low]);
                out.extend([head - (1 << 16), ty, result, set, min, above, high]);
            }
            _ => out.extend_from_slice(instruction),
        }
    }
    out
}

/// Decorates all results of float arithmetic with `NoContraction`, apart from those whose indices are in `except`: tests
/// expect such an omission to be noticed.
pub fn without_contraction(words: &[u32], except: &[usize]) -> Vec<u32> {
    let results = float_arithmetic(words);
    let mut out = words[..HEADER].to_vec();
    let mut decorated = false;
    for (at, opcode, length) in instructions(words) {
        let decoration = opcode == OP_DECORATE;
        if !decorated && (decoration || (OP_TYPE_VOID..=OP_TYPE_FORWARD_POINTER).contains(&opcode)) {
            decorated = true;
            for (index, id) in results.iter().enumerate() {
                if !except.contains(&index) {
                    out.extend([3 << 16 | OP_DECORATE, *id, NO_CONTRACTION]);
                }
            }
        }
        if !(decoration && words[at + 2] == NO_CONTRACTION) {
            out.extend_from_slice(&words[at..at + length]);
        }
    }
    out
}

/// Ids of the results of float arithmetic in a module, in order.
pub fn float_arithmetic(words: &[u32]) -> Vec<u32> {
    // FNegate, FAdd, FSub, FMul, FDiv, FRem, FMod, VectorTimesScalar .. Dot
    let arithmetic = |opcode: u32| matches!(opcode, 127 | 129 | 131 | 133 | 136 | 140 | 141 | 142..=148);
    instructions(words)
        .filter(|(_, opcode, _)| arithmetic(*opcode))
        .map(|(at, _, _)| words[at + 2])
        .collect()
}

/// Ids of the results with `NoContraction`.
pub fn decorated(words: &[u32]) -> Vec<u32> {
    instructions(words)
        .filter(|(at, opcode, length)| *opcode == OP_DECORATE && *length == 3 && words[at + 2] == NO_CONTRACTION)
        .map(|(at, _, _)| words[at + 1])
        .collect()
}

/// Index, opcode and length in words of each instruction.
fn instructions(words: &[u32]) -> impl Iterator<Item = (usize, u32, usize)> {
    let mut at = HEADER;
    std::iter::from_fn(move || {
        let word = *words.get(at)?;
        let here = at;
        at += (word >> 16).max(1) as usize;
        Some((here, word & 0xffff, (word >> 16) as usize))
    })
}
