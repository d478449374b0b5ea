//! Adds the float-control modes that a driver has to a kernel's SPIR-V.

use super::adapter::FloatControls;

const HEADER: usize = 5;
const VERSION_1_4: u32 = 0x0001_0400;
const OP_EXTENSION: u32 = 10;
const OP_ENTRY_POINT: u32 = 15;
const OP_EXECUTION_MODE: u32 = 16;
const OP_CAPABILITY: u32 = 17;
const FLOAT_BITS: u32 = 32;

/// A mode: the capability that a module must declare, and the execution mode itself.
struct Mode {
    capability: u32,
    execution_mode: u32,
}
const DENORM_PRESERVE: Mode = Mode {
    capability: 4464,
    execution_mode: 4459,
};
const SIGNED_ZERO_INF_NAN_PRESERVE: Mode = Mode {
    capability: 4466,
    execution_mode: 4461,
};
const ROUNDING_MODE_RTE: Mode = Mode {
    capability: 4467,
    execution_mode: 4462,
};

/// Requests the given modes for 32-bit floats in each of a module's entry points.
pub(super) fn with_modes(module: &[u32], controls: FloatControls) -> Vec<u32> {
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
    // A module has a fixed layout: capabilities, extensions, imports, memory model, entry points, their modes. New
    // instructions go to the end of their section.
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
            out.extend([
                instruction(OP_EXECUTION_MODE, 4),
                entry_point,
                mode.execution_mode,
                FLOAT_BITS,
            ]);
        }
    }
    out.extend_from_slice(&module[entry_points_end..]);
    out
}

/// The first word of an instruction.
fn instruction(opcode: u32, words: usize) -> u32 {
    (words as u32) << 16 | opcode
}

/// A string in SPIR-V: little-endian words, ended by a zero byte.
fn literal(text: &str) -> Vec<u32> {
    let mut bytes = text.as_bytes().to_vec();
    bytes.resize(text.len() / 4 * 4 + 4, 0);
    bytes
        .chunks_exact(4)
        .map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect()
}

#[cfg(test)]
mod tests {
    use std::process::{Command, Stdio};

    use oneiro_shaders::KERNELS;

    use super::*;

    const ALL: FloatControls = FloatControls {
        round_to_nearest: true,
        keep_special: true,
        keep_subnormal: true,
    };

    /// Words of each instruction.
    fn instructions(module: &[u32]) -> Vec<&[u32]> {
        let mut rest = &module[HEADER..];
        let mut found = Vec::new();
        while let Some(word) = rest.first() {
            let (one, next) = rest.split_at((word >> 16) as usize);
            found.push(one);
            rest = next;
        }
        found
    }

    #[test]
    fn modes_are_added_and_nothing_else_changes() {
        for kernel in KERNELS {
            let before = instructions(kernel.spirv);
            let module = with_modes(kernel.spirv, ALL);
            let after = instructions(&module);
            assert_eq!(module[..HEADER], kernel.spirv[..HEADER]);
            let entry_point = before
                .iter()
                .find(|i| i[0] & 0xffff == OP_ENTRY_POINT)
                .expect("an entry point")[2];
            let added: Vec<&[u32]> = after.iter().filter(|i| !before.contains(i)).copied().collect();
            let capability = |c: u32| vec![instruction(OP_CAPABILITY, 2), c];
            let mode = |m: u32| vec![instruction(OP_EXECUTION_MODE, 4), entry_point, m, 32];
            assert_eq!(
                [added[0], added[1], added[2]],
                [capability(4467), capability(4466), capability(4464)]
                    .each_ref()
                    .map(|i| &i[..])
            );
            assert_eq!(added[3][0], instruction(OP_EXTENSION, 7));
            assert_eq!(
                bytemuck::cast_slice::<u32, u8>(&added[3][1..]),
                b"SPV_KHR_float_controls\0\0"
            );
            assert_eq!(
                [added[4], added[5], added[6]],
                [mode(4462), mode(4461), mode(4459)].each_ref().map(|i| &i[..])
            );
            assert_eq!(after.len(), before.len() + 7);
            assert!(
                after.iter().filter(|i| before.contains(i)).eq(before.iter()),
                "the rest keeps its order"
            );
        }
    }

    #[test]
    fn missing_driver_modes_are_not_requested() {
        let module = KERNELS[0].spirv;
        assert_eq!(with_modes(module, FloatControls::default()), module);
        let some = with_modes(
            module,
            FloatControls {
                keep_subnormal: false,
                ..ALL
            },
        );
        assert_eq!(some.len(), module.len() + 2 * (2 + 4) + 7);
        assert!(
            !instructions(&some)
                .iter()
                .any(|i| i[..] == [instruction(OP_CAPABILITY, 2), 4464])
        );
        // From version 1.4 on, the modes need no extension.
        let mut newer = module.to_vec();
        newer[1] = VERSION_1_4;
        assert_eq!(with_modes(&newer, ALL).len(), module.len() + 3 * (2 + 4));
    }

    /// The Khronos validator accepts the result, if it is installed.
    #[test]
    fn the_validator_accepts_it() {
        for (index, kernel) in KERNELS.iter().enumerate() {
            for controls in [FloatControls::default(), ALL] {
                let path = std::env::temp_dir().join(format!("oneiro-{}-{index}.spv", std::process::id()));
                std::fs::write(&path, bytemuck::cast_slice(&with_modes(kernel.spirv, controls)))
                    .expect("a temporary file");
                let run = Command::new("spirv-val")
                    .args(["--target-env", "vulkan1.2"])
                    .arg(&path)
                    .stdin(Stdio::null())
                    .output();
                let _ = std::fs::remove_file(&path);
                match run {
                    Ok(said) => assert!(
                        said.status.success(),
                        "{}: {}",
                        kernel.name,
                        String::from_utf8_lossy(&said.stderr)
                    ),
                    Err(_) => return println!("not validated: there is no spirv-val here (Debian: spirv-tools)"),
                }
            }
        }
    }
}
