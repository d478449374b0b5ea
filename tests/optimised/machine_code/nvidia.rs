//! NVIDIA's machine code, as NVK's compiler prints it: `@!p0 r3 = ffma.ftz r3 r17 0x3ff2e190 // delay=6 wt=000001`.

use super::code::{Instruction, Kind};
use oneiro::gpu::Compiled;

fn kind(name: &str) -> Kind {
    let mut parts = name.split('.');
    let operation = parts.next().unwrap_or_default();
    // Subnormals as zeros, and clamped to [0, 1]; another one may be another way to round.
    let is_plain = parts.all(|modifier| ["ftz", "sat"].contains(&modifier));
    match operation {
        "fmul" if is_plain => Kind::Product,
        "fadd" if is_plain => Kind::Exact,
        "ffma" if is_plain => Kind::Fused,
        "fmnmx" | "fset" | "fsetp" | "fsel" => Kind::Exact,
        "frnd" if name.starts_with("frnd.f32.f32.") => Kind::Exact,
        "i2f" if ["i2f.f32.u32.re", "i2f.f32.i32.re"].contains(&name) => Kind::OfInteger,
        "f2i" if name.trim_end_matches(".ftz").ends_with("32.f32.rz") => Kind::ToInteger,
        "mufu" if name == "mufu.rcp" => Kind::Reciprocal,
        "mufu" | "i2f" => Kind::Inexact,
        // Floats, halves and doubles.
        _ if operation.starts_with(['f', 'h', 'd']) => Kind::Inexact,
        _ => Kind::Exact,
    }
}

pub(crate) fn read(line: &str) -> Vec<Instruction<'_>> {
    let text = line.split("//").next().unwrap_or_default().trim();
    let instruction = match text.split_once(' ') {
        Some((predicate, rest)) if predicate.starts_with('@') => rest,
        _ => text,
    };
    let (results, operation) = instruction.split_once(" = ").unwrap_or(("", instruction));
    let mut words = operation.split_whitespace();
    vec![Instruction {
        kind: kind(words.next().unwrap_or_default()),
        text,
        result: results.split_whitespace().next().unwrap_or_default(),
        operands: words.map(|word| word.trim_matches(['-', '|'])).collect(),
    }]
}

pub(crate) fn figures(compiled: &Compiled) -> String {
    format!(
        "{} instructions, {} bytes, {} registers, {} bytes of local memory",
        compiled.statistic("Instruction count").unwrap(),
        compiled.statistic("Code Size").unwrap(),
        compiled.statistic("Number of GPRs").unwrap(),
        compiled.statistic("SLM Size").unwrap(),
    )
}
