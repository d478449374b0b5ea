//! AMD's machine code, as RADV prints it: `v_fma_f32 v46, 2.0, v46, 1.0 ; d613002e 03ca5cf4`.

use super::code::{Instruction, Kind};
use oneiro::gpu::Compiled;

fn kind(name: &str) -> Kind {
    let is_of = |types: &[&str]| types.iter().any(|of| name.contains(of));
    if !is_of(&["_f16", "_bf16", "_f32", "_f64"]) {
        return Kind::Exact;
    }
    // Vector, scalar, or one of two at once; then how it is encoded.
    let mut operation = name;
    for prefix in ["v_dual_", "v_s_", "v_", "s_"] {
        if let Some(rest) = name.strip_prefix(prefix) {
            operation = rest;
            break;
        }
    }
    for suffix in ["_e32", "_e64", "_sdwa", "_dpp"] {
        operation = operation.strip_suffix(suffix).unwrap_or(operation);
    }
    if operation.starts_with("cmp_") || operation.starts_with("cmpx_") {
        return Kind::Exact;
    }
    match operation {
        "cvt_f32_u32" | "cvt_f32_i32" => return Kind::OfInteger,
        "cvt_u32_f32" | "cvt_i32_f32" => return Kind::ToInteger,
        _ => {}
    }
    let Some(operation) = operation.strip_suffix("_f32") else {
        return Kind::Inexact;
    };
    let operation = operation.strip_suffix("_num").unwrap_or(operation);
    let exact = [
        "add", "sub", "subrev", "floor", "trunc", "max", "min", "max3", "min3", "med3", "maxmin", "minmax",
        // These round the product before they add.
        "mad", "mac", "madak", "madmk",
    ];
    match operation {
        "mul" => Kind::Product,
        "fma" | "fmac" | "fmaak" | "fmamk" => Kind::Fused,
        "rcp" | "rcp_iflag" => Kind::Reciprocal,
        _ if exact.contains(&operation) => Kind::Exact,
        _ => Kind::Inexact,
    }
}

/// The instructions of a line: two, where a card begins two at once.
pub(crate) fn read(line: &str) -> Vec<Instruction<'_>> {
    let line = line.split(';').next().unwrap_or_default();
    line.split("::")
        .map(|text| {
            let text = text.trim();
            let (name, operands) = text.split_once(' ').unwrap_or((text, ""));
            // What follows an operand are modifiers.
            let mut operands = operands.split(',').map(|one| {
                let own = one.split_whitespace().next().unwrap_or_default();
                own.trim_matches(['-', '|'])
            });
            Instruction {
                kind: kind(name),
                text,
                result: operands.next().unwrap_or_default(),
                operands: operands.collect(),
            }
        })
        .collect()
}

pub(crate) fn figures(compiled: &Compiled) -> String {
    let of = |name: &str| compiled.statistic(name).unwrap();
    format!(
        "{} instructions, {} bytes, {} VGPRs, {} SGPRs, {} spilled, {} waves, throughput {}",
        of("Instructions"),
        of("Code size"),
        of("VGPRs"),
        of("SGPRs"),
        of("Spilled VGPRs") + of("Spilled SGPRs"),
        of("Subgroups per SIMD"),
        of("Inverse Throughput"),
    )
}
