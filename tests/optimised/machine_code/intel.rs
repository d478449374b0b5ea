//! Intel's machine code, as ANV's compiler prints it: `(+f0.0) mul(8) g6<1>F g5<0,1,0>F 0x4f7ffffeF /* 4.29497e+09F */ { align1 };`.

use super::code::{Instruction, Kind};
use oneiro::gpu::Compiled;

/// An operand's type: what is in capitals at its end.
fn kind_of_number(operand: &str) -> &str {
    operand.trim_start_matches(|letter: char| !letter.is_ascii_uppercase())
}

/// An operand's register or constant, without its sign, its type, and which lanes it has.
fn plain(operand: &str) -> &str {
    let own = operand.trim_start_matches(['-', '~']).trim_start_matches("(abs)");
    let own = own.split('<').next().unwrap_or_default();
    own.trim_end_matches(|letter: char| letter.is_ascii_uppercase())
}

fn kind(name: &str, operands: &[&str]) -> Kind {
    let types = || operands.iter().map(|operand| kind_of_number(operand));
    // F, halves, doubles, and vectors of small ones.
    if !types().any(|of| of.ends_with('F')) {
        return Kind::Exact;
    }
    let all_floats = types().all(|of| of == "F");
    match name.split('.').next().unwrap_or_default() {
        "mul" if all_floats => Kind::Product,
        "add" | "sel" | "cmp" | "rndd" | "rndz" if all_floats => Kind::Exact,
        "mad" if all_floats => Kind::Fused,
        "math inv" if all_floats => Kind::Reciprocal,
        "mov" => match (kind_of_number(operands[0]), kind_of_number(operands[1])) {
            ("F", "F" | "VF") => Kind::Exact,
            ("F", "D" | "UD" | "W" | "UW" | "B" | "UB") => Kind::OfInteger,
            ("D" | "UD" | "W" | "UW", "F") => Kind::ToInteger,
            _ => Kind::Inexact,
        },
        _ => Kind::Inexact,
    }
}

pub(crate) fn read(line: &str) -> Vec<Instruction<'_>> {
    // What belongs to a message is in further lines, indented.
    if line.starts_with(char::is_whitespace) {
        return Vec::new();
    }
    let text = line.split(['{', '/']).next().unwrap_or_default().trim();
    let instruction = match text.split_once(") ") {
        Some((predicate, rest)) if predicate.starts_with('(') => rest,
        _ => text,
    };
    // The number of lanes is in brackets.
    let Some((name, rest)) = instruction.split_once('(') else {
        return Vec::new();
    };
    let mut operands: Vec<&str> = rest.split_whitespace().skip(1).collect();
    let kind = kind(name, &operands);
    for operand in &mut operands {
        *operand = plain(operand);
    }
    let result = if operands.is_empty() { "" } else { operands.remove(0) };
    if kind == Kind::Fused {
        // What is added comes first.
        operands.rotate_left(1);
    }
    vec![Instruction {
        kind,
        text,
        result,
        operands,
    }]
}

pub(crate) fn figures(compiled: &Compiled) -> String {
    format!(
        "{} instructions, {} lanes, {} live registers, {} spilled, {} filled, {} messages, {} cycles",
        compiled.statistic("Instruction Count").unwrap(),
        compiled.lanes,
        compiled.statistic("Max live registers").unwrap(),
        compiled.statistic("Spill Count").unwrap(),
        compiled.statistic("Fill Count").unwrap(),
        compiled.statistic("SEND Count").unwrap(),
        compiled.statistic("Cycle Count").unwrap(),
    )
}
