//! How Rust writes what controllers do.

use oneiro_shader_compiler::language::{Exits, Language, Opening, Operand, bare};
use oneiro_shader_compiler::tree::{Binary, Label, Ty, Unary};

/// Rust without its standard library and without `unsafe`.
pub(super) struct Rust;

pub(super) fn type_name(ty: Ty) -> &'static str {
    match ty {
        Ty::F32 => "f32",
        Ty::I32 => "i32",
        Ty::U32 => "u32",
        Ty::Bool => "bool",
    }
}

impl Language for Rust {
    fn exits(&self) -> Exits {
        Exits::Names
    }

    fn constant(&self, bits: u32, ty: Ty) -> String {
        let x = f32::from_bits(bits);
        match ty {
            Ty::F32 if !x.is_finite() => format!("f32::from_bits({bits}u32)"),
            Ty::F32 if x.is_sign_negative() => format!("({x:?}f32)"),
            Ty::F32 => format!("{x:?}f32"),
            Ty::I32 => format!("({}i32)", bits as i32),
            Ty::U32 => format!("{bits}u32"),
            Ty::Bool => (bits != 0).to_string(),
        }
    }

    fn unary(&self, op: Unary, ty: Ty, x: &str) -> String {
        match (op, ty) {
            (Unary::Negate, Ty::F32) => format!("(-{x})"),
            (Unary::Negate, _) => format!("{x}.wrapping_neg()"),
            (Unary::Not, _) => format!("(!{x})"),
            (Unary::Abs, Ty::F32) => format!("f32::from_bits({x}.to_bits() & 0x7fff_ffff)"),
            (Unary::Abs, Ty::I32) => format!("{x}.wrapping_abs()"),
            (Unary::Abs, _) => x.to_owned(),
            (Unary::Floor, _) => format!("rounded_down({})", bare(x)),
            (Unary::Trunc, _) => format!("truncated({})", bare(x)),
        }
    }

    fn binary(&self, op: Binary, ty: Ty, x: &Operand, y: &Operand) -> String {
        let shifted_by = match y.bits {
            Some(bits) => (bits & 31).to_string(),
            None => format!("{} as u32", y.text),
        };
        let (x, y) = (&x.text, &y.text);
        let operation = |symbol: &str| format!("({x} {symbol} {y})");
        let wrapping = |symbol: &str, name: &str| match ty {
            Ty::F32 => operation(symbol),
            _ => format!("{x}.wrapping_{name}({})", bare(y)),
        };
        // Integers are divided as unsigned ones.
        let divided = |symbol: &str| match ty {
            Ty::I32 => format!("(({x} as u32 {symbol} ({y} as u32).max(1)) as i32)"),
            _ => format!("({x} {symbol} {y}.max(1))"),
        };
        match op {
            Binary::Add => wrapping("+", "add"),
            Binary::Subtract => wrapping("-", "sub"),
            Binary::Multiply => wrapping("*", "mul"),
            Binary::Divide => divided("/"),
            Binary::Remainder => divided("%"),
            Binary::Min => format!("(if {x} < {y} {{ {x} }} else {{ {y} }})"),
            Binary::Max => format!("(if {x} > {y} {{ {x} }} else {{ {y} }})"),
            Binary::And if ty == Ty::Bool => operation("&&"),
            Binary::Or if ty == Ty::Bool => operation("||"),
            Binary::Xor if ty == Ty::Bool => operation("!="),
            Binary::And => operation("&"),
            Binary::Or => operation("|"),
            Binary::Xor => operation("^"),
            Binary::ShiftLeft => format!("{x}.wrapping_shl({shifted_by})"),
            Binary::ShiftRight => format!("{x}.wrapping_shr({shifted_by})"),
            Binary::Equal => operation("=="),
            Binary::NotEqual => operation("!="),
            Binary::Less => operation("<"),
            Binary::LessEqual => operation("<="),
            Binary::Greater => operation(">"),
            Binary::GreaterEqual => operation(">="),
        }
    }

    fn select(&self, _: Ty, test: &str, accept: &Operand, reject: &Operand) -> String {
        format!(
            "(if {} {{ {} }} else {{ {} }})",
            bare(test),
            bare(&accept.text),
            bare(&reject.text)
        )
    }

    fn convert(&self, from: Ty, to: Ty, x: &str) -> String {
        match (from, to) {
            (Ty::Bool, Ty::F32) => format!("(if {} {{ 1.0f32 }} else {{ 0.0f32 }})", bare(x)),
            (Ty::F32, Ty::Bool) => format!("({x} != 0.0f32)"),
            (_, Ty::Bool) => format!("({x} != 0)"),
            (_, to) => format!("({x} as {})", type_name(to)),
        }
    }

    fn bitcast(&self, from: Ty, to: Ty, x: &str) -> String {
        match (from, to) {
            (Ty::F32, Ty::I32) => format!("({x}.to_bits() as i32)"),
            (Ty::F32, _) => format!("{x}.to_bits()"),
            (Ty::I32, Ty::F32) => format!("f32::from_bits({x} as u32)"),
            (_, Ty::F32) => format!("f32::from_bits({})", bare(x)),
            (_, to) => format!("({x} as {})", type_name(to)),
        }
    }

    fn element(&self, array: &str, index: &str) -> String {
        if index.parse::<u32>().is_ok() {
            format!("{array}[{index}]")
        } else {
            format!("{array}[({index}) as usize]")
        }
    }

    fn word(&self, table: &str, index: &str) -> String {
        self.element(table, index)
    }

    fn declaration(&self, name: &str, ty: Ty, value: &str, changed: bool) -> String {
        let changed = if changed { "mut " } else { "" };
        format!("let {changed}{name}: {} = {value};", type_name(ty))
    }

    fn array(&self, name: &str, ty: Ty, elements: &[String]) -> String {
        let (ty, count, elements) = (type_name(ty), elements.len(), elements.join(", "));
        format!("let mut {name}: [{ty}; {count}] = [{elements}];")
    }

    fn assignment(&self, place: &str, value: &str) -> String {
        format!("{place} = {value};")
    }

    fn open(&self, opening: Opening) -> String {
        match opening {
            Opening::If(test) => format!("if {test} {{"),
            Opening::Else => "} else {".to_owned(),
            Opening::Loop(label) => format!("'block_{}: loop {{", label.0),
            Opening::Once(label) => format!("'block_{}: {{", label.0),
        }
    }

    fn close(&self, _: Opening) -> [Option<&'static str>; 2] {
        [None, Some("}")]
    }

    fn leave(&self, label: Label) -> String {
        format!("break 'block_{};", label.0)
    }
}
