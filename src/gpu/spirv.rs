//! The float-control modes that a driver has, added to a kernel's SPIR-V.

use super::adapter::FloatControls;

const HEADER: usize = 5;
const VERSION_1_4: u32 = 0x0001_0400;
const OP_EXTENSION: u32 = 10;
const OP_ENTRY_POINT: u32 = 15;
const OP_EXECUTION_MODE: u32 = 16;
const OP_CAPABILITY: u32 = 17;
const FLOAT_BITS: u32 = 32;

/// A mode: the capability that a module declares for it, and the execution mode itself.
struct Mode {
    capability: u32,
    execution_mode: u32,
}
const DENORM_PRESERVE: Mode = Mode { capability: 4464, execution_mode: 4459 };
const SIGNED_ZERO_INF_NAN_PRESERVE: Mode = Mode { capability: 4466, execution_mode: 4461 };
const ROUNDING_MODE_RTE: Mode = Mode { capability: 4467, execution_mode: 4462 };

/// A module that asks for the given modes for 32-bit floats in each of its entry points; else unchanged.
pub fn with_modes(module: &[u32], controls: FloatControls) -> Vec<u32> {
    let modes: Vec<Mode> = [
        (controls.round_to_nearest, ROUNDING_MODE_RTE),
        (controls.keep_special, SIGNED_ZERO_INF_NAN_PRESERVE),
        (controls.keep_subnormal, DENORM_PRESERVE),
    ]
    .into_iter()
    .filter_map(|(wanted, mode)| wanted.then_some(mode))
    .collect();
    if modes.is_empty() {
        return module.to_vec();
    }

    let mut entry_points = Vec::new();
    // The layout of a module is fixed: capabilities, extensions, imports, memory model, entry points, their
    // modes. New instructions go to the end of their own section.
    let mut capabilities_end = HEADER;
    let mut extensions_end = HEADER;
    let mut entry_points_end = HEADER;
    let mut at = HEADER;
    while let Some(&word) = module.get(at) {
        let (opcode, length) = (word & 0xffff, (word >> 16).max(1) as usize);
        match opcode {
            OP_CAPABILITY => capabilities_end = at + length,
            OP_EXTENSION => extensions_end = at + length,
            OP_ENTRY_POINT => {
                entry_points.push(module[at + 2]);
                entry_points_end = at + length;
            }
            _ => {}
        }
        at += length;
    }

    let mut out = module[..capabilities_end].to_vec();
    for mode in &modes {
        out.extend([instruction(OP_CAPABILITY, 2), mode.capability]);
    }
    let extensions_end = extensions_end.max(capabilities_end);
    out.extend_from_slice(&module[capabilities_end..extensions_end]);
    if module[1] < VERSION_1_4 {
        let name = literal("SPV_KHR_float_controls");
        out.push(instruction(OP_EXTENSION, 1 + name.len()));
        out.extend(name);
    }
    out.extend_from_slice(&module[extensions_end..entry_points_end]);
    for entry_point in entry_points {
        for mode in &modes {
            out.extend([instruction(OP_EXECUTION_MODE, 4), entry_point, mode.execution_mode, FLOAT_BITS]);
        }
    }
    out.extend_from_slice(&module[entry_points_end..]);
    out
}

/// The first word of an instruction.
fn instruction(opcode: u32, words: usize) -> u32 {
    (words as u32) << 16 | opcode
}

/// A string as SPIR-V has it: little-endian words, ended by a zero byte.
fn literal(text: &str) -> Vec<u32> {
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize(text.len() / 4 * 4 + 4, 0);
    bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}
