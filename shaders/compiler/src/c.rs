//! C99 with the same bits: floats are single, integers wrap, and nothing is called but the functions of [`helpers`].

use crate::language::{Exits, Language, Opening, Operand, bare};
use crate::tree::{Binary, Label, Op, Program, Ty, Unary};

/// What a file begins with: it refuses to be compiled with arithmetic that gives other bits, and keeps products from being fused with sums,
/// which GCC does by default on processors that can, whatever the pragma of the C standard says. Constants are marked `ONEIRO_FLASH`.
pub const PREAMBLE: &str = "#include <float.h>
#include <stdbool.h>
#include <stdint.h>

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || defined(_M_FP_FAST)
#error \"fast-math changes the bits: compile without -ffast-math, -Ofast and /fp:fast\"
#endif
#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__ > 0
#error \"fast-math changes the bits: compile without -ffinite-math-only\"
#endif
#if defined(FLT_EVAL_METHOD)
#define ONEIRO_EVAL_METHOD FLT_EVAL_METHOD
#elif defined(__FLT_EVAL_METHOD__)
#define ONEIRO_EVAL_METHOD __FLT_EVAL_METHOD__
#endif
/* 16 is for floats of 16 bits alone. */
#if !defined(ONEIRO_EVAL_METHOD) || (ONEIRO_EVAL_METHOD != 0 && ONEIRO_EVAL_METHOD != 16)
#error \"floats must be computed as floats, FLT_EVAL_METHOD 0: on 32-bit x86 compile with -msse2 -mfpmath=sse\"
#endif
#if FLT_RADIX != 2 || FLT_MANT_DIG != 24 || FLT_MAX_EXP != 128
#error \"floats must have 32 bits as in IEEE 754\"
#endif
#ifdef __AVR__
#include <avr/pgmspace.h>
#define ONEIRO_FLASH PROGMEM
#else
#define ONEIRO_FLASH
#endif
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize (\"fp-contract=off\")
#elif defined(_MSC_VER) && !defined(__clang__)
#pragma fp_contract (off)
#else
#pragma STDC FP_CONTRACT OFF
#endif
";

/// Functions that printed code calls, each after those that it calls.
const HELPERS: [(&str, &str); 9] = [
    (
        "constant_of",
        "static uint32_t constant_of(const uint32_t *word)
{
#ifdef __AVR__
    return pgm_read_dword(word);
#else
    return *word;
#endif
}
",
    ),
    (
        "divisor_of",
        "static uint32_t divisor_of(uint32_t x)
{
    return x == 0 ? 1u : x;
}
",
    ),
    (
        "signed_of",
        "/* The number with the same bits. */
static int32_t signed_of(uint32_t x)
{
    return (int32_t)x;
}
",
    ),
    (
        "shifted_down",
        "/* With copies of the sign. */
static int32_t shifted_down(int32_t x, uint32_t places)
{
    return x < 0 ? signed_of(~(~(uint32_t)x >> places)) : signed_of((uint32_t)x >> places);
}
",
    ),
    (
        "bits_of",
        "static uint32_t bits_of(float x)
{
    union { float number; uint32_t bits; } word;
    word.number = x;
    return word.bits;
}
",
    ),
    (
        "number_of",
        "static float number_of(uint32_t bits)
{
    union { float number; uint32_t bits; } word;
    word.bits = bits;
    return word.number;
}
",
    ),
    (
        "whole_of",
        "/* Rounded towards zero; beyond all integers the nearest one, and 0 for what is no number. */
static int32_t whole_of(float x)
{
    if (x >= 2147483648.0f) {
        return 2147483647;
    }
    if (x > -2147483648.0f) {
        return (int32_t)x;
    }
    return x <= -2147483648.0f ? -2147483647 - 1 : 0;
}
",
    ),
    (
        "truncated",
        "/* From 2^23 on all numbers are whole. */
static float truncated(float x)
{
    return x < 8388608.0f && x > -8388608.0f ? (float)whole_of(x) : x;
}
",
    ),
    (
        "rounded_down",
        "static float rounded_down(float x)
{
    const float whole = truncated(x);
    return whole > x ? whole - 1.0f : whole;
}
",
    ),
];

/// The functions that printed code calls, for its file.
pub fn helpers(code: &str) -> String {
    let mut all = String::new();
    for (name, text) in HELPERS.iter().rev() {
        let call = format!("{name}(");
        if code.contains(&call) || all.contains(&call) {
            all = format!("{text}\n{all}");
        }
    }
    all
}

/// Code with its helpers, whose names begin with `name` then: several files can be included in one.
pub fn with_own_helpers(code: &str, name: &str) -> String {
    let mut text = code.to_owned();
    for (helper, _) in HELPERS {
        let call = format!("{helper}(");
        let mut pieces = text.split(&call);
        let mut named = pieces.next().unwrap_or_default().to_owned();
        for piece in pieces {
            // Another name may end with the helper's.
            if !named.ends_with(|last: char| last.is_alphanumeric() || last == '_') {
                named = named + name + "_";
            }
            named = named + &call + piece;
        }
        text = named;
    }
    text
}

/// The name of a type.
pub fn type_name(ty: Ty) -> &'static str {
    match ty {
        Ty::F32 => "float",
        Ty::I32 => "int32_t",
        Ty::U32 => "uint32_t",
        Ty::Bool => "bool",
    }
}

/// A constant, such as `1.5f`.
pub fn constant(bits: u32, ty: Ty) -> String {
    let x = f32::from_bits(bits);
    match ty {
        Ty::F32 if !x.is_finite() => format!("number_of({bits}u)"),
        Ty::F32 if x.is_sign_negative() => format!("({x:?}f)"),
        Ty::F32 => format!("{x:?}f"),
        Ty::I32 if bits == 1 << 31 => "(-2147483647 - 1)".to_owned(),
        Ty::I32 if bits > 1 << 31 => format!("({})", bits as i32),
        Ty::I32 => bits.to_string(),
        Ty::U32 if bits >= 1 << 24 => format!("0x{bits:x}u"),
        Ty::U32 => format!("{bits}u"),
        Ty::Bool => (bits != 0).to_string(),
    }
}

/// Computes what compares an unsigned number with the minimum or the maximum: compilers warn of comparisons that always come out alike.
pub(crate) fn compare_limits(program: &mut Program) {
    for at in 0..program.values.len() {
        if let Op::Convert(a) = program.values[at].op
            && let (Op::Constant(bits), Ty::Bool, Ty::U32) = (program.op(a), program.ty(a), program.values[at].ty)
        {
            program.values[at].op = Op::Constant(bits);
        }
        let Op::Binary(op, a, b) = program.values[at].op else {
            continue;
        };
        let bits = |value| match program.op(value) {
            Op::Constant(bits) if program.ty(value) == Ty::U32 => Some(bits),
            _ => None,
        };
        let [least, greatest] = [0, u32::MAX].map(|limit| [a, b].map(|value| bits(value) == Some(limit)));
        let op = match (op, least, greatest) {
            (Binary::GreaterEqual, [_, true], _)
            | (Binary::LessEqual, [true, _], _)
            | (Binary::LessEqual, _, [_, true])
            | (Binary::GreaterEqual, _, [true, _]) => Op::Constant(1),
            (Binary::Less, [_, true], _)
            | (Binary::Greater, [true, _], _)
            | (Binary::Greater, _, [_, true])
            | (Binary::Less, _, [true, _]) => Op::Constant(0),
            (Binary::Min, [true, _], _)
            | (Binary::Max, [_, true], _)
            | (Binary::Max, _, [true, _])
            | (Binary::Min, _, [_, true]) => Op::Bitcast(a),
            (Binary::Min, [_, true], _)
            | (Binary::Max, [true, _], _)
            | (Binary::Max, _, [_, true])
            | (Binary::Min, _, [true, _]) => Op::Bitcast(b),
            _ => continue,
        };
        program.values[at].op = op;
    }
}

/// C99, which is also C++.
#[derive(Clone, Copy, Debug)]
pub struct C;

impl Language for C {
    fn exits(&self) -> Exits {
        Exits::Jumps
    }

    fn constant(&self, bits: u32, ty: Ty) -> String {
        constant(bits, ty)
    }

    fn unary(&self, op: Unary, ty: Ty, x: &str) -> String {
        match (op, ty) {
            (Unary::Negate, Ty::F32) => format!("(-{x})"),
            (Unary::Negate, Ty::I32) => format!("signed_of(0u - (uint32_t){x})"),
            (Unary::Negate, _) => format!("(0u - {x})"),
            (Unary::Not, Ty::Bool) => format!("(!{x})"),
            (Unary::Not, Ty::I32) => format!("signed_of(~(uint32_t){x})"),
            (Unary::Not, _) => format!("(~{x})"),
            (Unary::Abs, Ty::F32) => format!("number_of(bits_of({}) & 0x7fffffffu)", bare(x)),
            (Unary::Abs, Ty::I32) => format!("({x} < 0 ? signed_of(0u - (uint32_t){x}) : {x})"),
            (Unary::Abs, _) => x.to_owned(),
            (Unary::Floor, _) => format!("rounded_down({})", bare(x)),
            (Unary::Trunc, _) => format!("truncated({})", bare(x)),
        }
    }

    fn binary(&self, op: Binary, ty: Ty, left: &Operand, right: &Operand) -> String {
        let (mut x, y) = (left.text.clone(), &right.text);
        if ty == Ty::U32 && left.bits.is_some() && right.bits.is_some() {
            x = format!("(uint32_t){x}");
        }
        let shifted_by = || match right.bits {
            Some(bits) => (bits & 31).to_string(),
            None => format!("({y} & 31u)"),
        };
        // Unsigned integers wrap, and have bits.
        let wrapping = |symbol: &str| match ty {
            Ty::I32 => format!("signed_of((uint32_t){x} {symbol} (uint32_t){y})"),
            _ => format!("({x} {symbol} {y})"),
        };
        let divisor = || match right.bits {
            Some(bits) => format!("{}u", bits.max(1)),
            None if ty == Ty::I32 => format!("divisor_of((uint32_t){y})"),
            None => format!("divisor_of({})", bare(y)),
        };
        let divided = |symbol: &str| match ty {
            Ty::I32 => format!("signed_of((uint32_t){x} {symbol} {})", divisor()),
            _ => format!("({x} {symbol} {})", divisor()),
        };
        match op {
            Binary::Add => wrapping("+"),
            Binary::Subtract => wrapping("-"),
            Binary::Multiply => wrapping("*"),
            Binary::Divide => divided("/"),
            Binary::Remainder => divided("%"),
            Binary::Min => format!("({x} < {y} ? {x} : {y})"),
            Binary::Max => format!("({x} > {y} ? {x} : {y})"),
            Binary::And if ty == Ty::Bool => format!("({x} && {y})"),
            Binary::Or if ty == Ty::Bool => format!("({x} || {y})"),
            Binary::Xor if ty == Ty::Bool => format!("({x} != {y})"),
            Binary::And => wrapping("&"),
            Binary::Or => wrapping("|"),
            Binary::Xor => wrapping("^"),
            Binary::ShiftLeft if ty == Ty::I32 => format!("signed_of((uint32_t){x} << {})", shifted_by()),
            Binary::ShiftLeft => format!("({x} << {})", shifted_by()),
            Binary::ShiftRight if ty == Ty::I32 => format!("shifted_down({x}, {})", shifted_by()),
            Binary::ShiftRight => format!("({x} >> {})", shifted_by()),
            Binary::Equal => format!("({x} == {y})"),
            Binary::NotEqual => format!("({x} != {y})"),
            Binary::Less => format!("({x} < {y})"),
            Binary::LessEqual => format!("({x} <= {y})"),
            Binary::Greater => format!("({x} > {y})"),
            Binary::GreaterEqual => format!("({x} >= {y})"),
        }
    }

    fn select(&self, ty: Ty, test: &str, accept: &Operand, reject: &Operand) -> String {
        // An `unsigned` has 16 bits on small processors.
        let is_short = ty == Ty::U32 && accept.bits.is_some() && reject.bits.is_some();
        let cast = if is_short { "(uint32_t)" } else { "" };
        format!("({test} ? {cast}{} : {cast}{})", accept.text, reject.text)
    }

    fn convert(&self, from: Ty, to: Ty, x: &str) -> String {
        match (from, to) {
            (Ty::Bool, Ty::F32) => format!("({x} ? 1.0f : 0.0f)"),
            (Ty::Bool, Ty::I32) => format!("({x} ? 1 : 0)"),
            (Ty::Bool, _) => format!("({x} ? (uint32_t)1u : (uint32_t)0u)"),
            (Ty::F32, Ty::Bool) => format!("({x} != 0.0f)"),
            (_, Ty::Bool) => format!("({x} != 0)"),
            (Ty::F32, Ty::I32) => format!("whole_of({})", bare(x)),
            (Ty::F32, Ty::U32) => format!("((uint32_t)whole_of({}))", bare(x)),
            (Ty::U32, Ty::F32) => format!("((float)signed_of({}))", bare(x)),
            (_, Ty::I32) => format!("signed_of({})", bare(x)),
            (_, to) => format!("(({}){x})", type_name(to)),
        }
    }

    fn bitcast(&self, from: Ty, to: Ty, x: &str) -> String {
        match (from, to) {
            (Ty::F32, Ty::I32) => format!("((int32_t)bits_of({}))", bare(x)),
            (Ty::F32, _) => format!("bits_of({})", bare(x)),
            (Ty::I32, Ty::F32) => format!("number_of((uint32_t){x})"),
            (_, Ty::F32) => format!("number_of({})", bare(x)),
            (_, Ty::I32) => format!("signed_of({})", bare(x)),
            (_, to) => format!("(({}){x})", type_name(to)),
        }
    }

    fn element(&self, array: &str, index: &str) -> String {
        format!("{array}[{index}]")
    }

    fn word(&self, table: &str, index: &str) -> String {
        format!("constant_of(&{table}[{index}])")
    }

    fn declaration(&self, name: &str, ty: Ty, value: &str, changed: bool) -> String {
        let constant = if changed { "" } else { "const " };
        format!("{constant}{} {name} = {value};", type_name(ty))
    }

    fn array(&self, name: &str, ty: Ty, elements: &[String]) -> String {
        let (ty, count, elements) = (type_name(ty), elements.len(), elements.join(", "));
        format!("{ty} {name}[{count}] = {{{elements}}};")
    }

    fn assignment(&self, place: &str, value: &str) -> String {
        format!("{place} = {value};")
    }

    fn open(&self, opening: Opening) -> String {
        match opening {
            Opening::If(test) => format!("if ({test}) {{"),
            Opening::Else => "} else {".to_owned(),
            Opening::Loop(_) => "for (;;) {".to_owned(),
            Opening::Once(_) => "{".to_owned(),
        }
    }

    fn close(&self, _: Opening) -> [Option<&'static str>; 2] {
        [None, Some("}")]
    }

    fn leave(&self, _: Label) -> String {
        "break;".to_owned()
    }
}
