//! How languages write what controllers do whose numbers are double floats and integers of their own kinds: each operation is followed by
//! one that rounds or wraps its result. A sum, difference or product of two floats that is rounded to double and then to single has the
//! bits of one that is rounded once.

use oneiro_shader_compiler::language::{Exits, Language, Opening, Operand, bare};
use oneiro_shader_compiler::tree::{Binary, Label, Ty, Unary};

/// Such a language. Its file has the functions `f`, `i` and `u`, which make a number one of their type, and others by their names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dynamic {
    JavaScript,
    Python,
    Lua,
}

use Dynamic::{JavaScript, Lua, Python};

impl Dynamic {
    /// The function that makes a number one of this type.
    fn fitted(ty: Ty, text: &str) -> String {
        let function = match ty {
            Ty::F32 => "f",
            Ty::I32 => "i",
            Ty::U32 | Ty::Bool => "u",
        };
        format!("{function}({})", bare(text))
    }

    /// An integer as an unsigned one.
    fn unsigned(ty: Ty, text: &str) -> String {
        match ty {
            Ty::I32 => format!("u({})", bare(text)),
            _ => text.to_owned(),
        }
    }

    fn chosen(self, ty: Ty, test: &str, accept: &str, reject: &str) -> String {
        match self {
            JavaScript => format!("({test} ? {accept} : {reject})"),
            Python => format!("({accept} if {test} else {reject})"),
            // Else `accept` must be true.
            Lua if ty == Ty::Bool => format!("(({test} and {accept}) or (not {test} and {reject}))"),
            Lua => format!("({test} and {accept} or {reject})"),
        }
    }

    fn end(self) -> &'static str {
        if self == JavaScript { ";" } else { "" }
    }
}

impl Language for Dynamic {
    fn exits(&self) -> Exits {
        match self {
            JavaScript => Exits::Names,
            Python | Lua => Exits::Flags,
        }
    }

    fn constant(&self, bits: u32, ty: Ty) -> String {
        let x = f32::from_bits(bits);
        match ty {
            Ty::F32 if !x.is_finite() => format!("number_of({bits})"),
            // Small processors don't read decimals to the last bit: the file has these constants by their bits.
            Ty::F32 if *self == Python && (x.fract() != 0.0 || x.abs() > 1e6) => format!("k_{bits:08x}"),
            Ty::F32 if x.is_sign_negative() => format!("({:?})", f64::from(x)),
            Ty::F32 => format!("{:?}", f64::from(x)),
            Ty::I32 if bits >> 31 == 1 => format!("({})", bits as i32),
            Ty::I32 | Ty::U32 => bits.to_string(),
            Ty::Bool if *self == Python => if bits == 0 { "False" } else { "True" }.to_owned(),
            Ty::Bool => (bits != 0).to_string(),
        }
    }

    fn unary(&self, op: Unary, ty: Ty, x: &str) -> String {
        match (op, ty) {
            (Unary::Negate, Ty::F32) => format!("(-{x})"),
            (Unary::Negate, _) => Self::fitted(ty, &format!("-{x}")),
            (Unary::Not, Ty::Bool) if *self == JavaScript => format!("(!{x})"),
            (Unary::Not, Ty::Bool) => format!("(not {x})"),
            (Unary::Not, Ty::I32) => format!("(-1 - {x})"),
            (Unary::Not, _) => format!("({} - {x})", u32::MAX),
            (Unary::Abs, Ty::I32) => format!("i(absolute({}))", bare(x)),
            (Unary::Abs, _) => format!("absolute({})", bare(x)),
            (Unary::Floor, _) => format!("rounded_down({})", bare(x)),
            (Unary::Trunc, _) => format!("truncated({})", bare(x)),
        }
    }

    fn binary(&self, op: Binary, ty: Ty, left: &Operand, right: &Operand) -> String {
        let (x, y) = (&left.text, &right.text);
        let operation = |symbol: &str| format!("({x} {symbol} {y})");
        let [unsigned_x, unsigned_y] = [x, y].map(|text| Self::unsigned(ty, text));
        let called = |function: &str| {
            let call = format!("{function}({}, {})", bare(&unsigned_x), bare(&unsigned_y));
            if ty == Ty::I32 { Self::fitted(ty, &call) } else { call }
        };
        let shifted = |function: &str| {
            let places = match right.bits {
                Some(bits) => (bits & 31).to_string(),
                None => format!("{} % 32", Self::unsigned(ty, y)),
            };
            Self::fitted(ty, &format!("{function}({}, {places})", bare(x)))
        };
        let divisor = match right.bits {
            Some(bits) => bits.max(1).to_string(),
            None => format!("divisor_of({})", bare(&unsigned_y)),
        };
        let divided = |text: String| {
            if ty == Ty::I32 { Self::fitted(ty, &text) } else { text }
        };
        match op {
            Binary::Add => Self::fitted(ty, &operation("+")),
            Binary::Subtract => Self::fitted(ty, &operation("-")),
            Binary::Multiply if ty == Ty::F32 => Self::fitted(ty, &operation("*")),
            Binary::Multiply => {
                let product = format!("product({}, {})", bare(&unsigned_x), bare(&unsigned_y));
                Self::fitted(ty, &product)
            }
            Binary::Divide => divided(format!("quotient({}, {divisor})", bare(&unsigned_x))),
            Binary::Remainder => divided(format!("({unsigned_x} % {divisor})")),
            Binary::Min => self.chosen(ty, &operation("<"), x, y),
            Binary::Max => self.chosen(ty, &operation(">"), x, y),
            Binary::And if ty == Ty::Bool => operation(if *self == JavaScript { "&&" } else { "and" }),
            Binary::Or if ty == Ty::Bool => operation(if *self == JavaScript { "||" } else { "or" }),
            Binary::And => called("bit_and"),
            Binary::Or => called("bit_or"),
            Binary::Xor if ty != Ty::Bool => called("bit_xor"),
            Binary::Xor | Binary::NotEqual => operation(match self {
                JavaScript => "!==",
                Python => "!=",
                Lua => "~=",
            }),
            Binary::ShiftLeft => shifted("shifted_left"),
            Binary::ShiftRight => shifted("shifted_right"),
            Binary::Equal => operation(if *self == JavaScript { "===" } else { "==" }),
            Binary::Less => operation("<"),
            Binary::LessEqual => operation("<="),
            Binary::Greater => operation(">"),
            Binary::GreaterEqual => operation(">="),
        }
    }

    fn select(&self, ty: Ty, test: &str, accept: &Operand, reject: &Operand) -> String {
        self.chosen(ty, test, &accept.text, &reject.text)
    }

    fn convert(&self, from: Ty, to: Ty, x: &str) -> String {
        let unequal = if *self == Lua { "~=" } else { "!=" };
        match (from, to) {
            (Ty::Bool, Ty::F32) => self.chosen(to, x, "1.0", "0.0"),
            (Ty::Bool, _) => self.chosen(to, x, "1", "0"),
            (Ty::F32, Ty::Bool) => format!("({x} {unequal} 0.0)"),
            (_, Ty::Bool) => format!("({x} {unequal} 0)"),
            (Ty::F32, Ty::I32) => format!("whole_of({})", bare(x)),
            (Ty::F32, Ty::U32) => format!("u(whole_of({}))", bare(x)),
            _ => Self::fitted(to, x),
        }
    }

    fn bitcast(&self, from: Ty, to: Ty, x: &str) -> String {
        match (from, to) {
            (Ty::F32, Ty::I32) => format!("i(bits_of({}))", bare(x)),
            (Ty::F32, _) => format!("bits_of({})", bare(x)),
            (_, Ty::F32) => format!("number_of({})", bare(&Self::unsigned(from, x))),
            _ if from == to => x.to_owned(),
            _ => Self::fitted(to, x),
        }
    }

    fn element(&self, array: &str, index: &str) -> String {
        match (self, index.parse::<u32>()) {
            (Lua, Ok(index)) => format!("{array}[{}]", index + 1),
            (Lua, Err(_)) => format!("{array}[({index}) + 1]"),
            _ => format!("{array}[{index}]"),
        }
    }

    fn word(&self, table: &str, index: &str) -> String {
        self.element(table, index)
    }

    fn local(&self, name: String) -> String {
        // A function has at most 200 local variables.
        if *self == Lua { format!("v.{name}") } else { name }
    }

    fn declaration(&self, name: &str, _: Ty, value: &str, changed: bool) -> String {
        let word = match self {
            JavaScript if changed => "let ",
            JavaScript => "const ",
            Python | Lua => "",
        };
        format!("{word}{name} = {value}{}", self.end())
    }

    fn array(&self, name: &str, _: Ty, elements: &[String]) -> String {
        let elements = elements.join(", ");
        match self {
            JavaScript => format!("const {name} = [{elements}];"),
            Python => format!("{name} = [{elements}]"),
            Lua => format!("{name} = {{{elements}}}"),
        }
    }

    fn assignment(&self, place: &str, value: &str) -> String {
        format!("{place} = {value}{}", self.end())
    }

    fn open(&self, opening: Opening) -> String {
        match (self, opening) {
            (JavaScript, Opening::If(test)) => format!("if ({test}) {{"),
            (JavaScript, Opening::Else) => "} else {".to_owned(),
            (JavaScript, Opening::Loop(label)) => format!("block_{}: for (;;) {{", label.0),
            (JavaScript, Opening::Once(label)) => format!("block_{}: {{", label.0),
            (Python, Opening::If(test)) => format!("if {test}:"),
            (Python, Opening::Else) => "else:".to_owned(),
            (Python, Opening::Loop(_) | Opening::Once(_)) => "while True:".to_owned(),
            (Lua, Opening::If(test)) => format!("if {test} then"),
            (Lua, Opening::Else) => "else".to_owned(),
            (Lua, Opening::Loop(_)) => "while true do".to_owned(),
            (Lua, Opening::Once(_)) => "repeat".to_owned(),
        }
    }

    fn close(&self, opening: Opening) -> [Option<&'static str>; 2] {
        match (self, opening) {
            (JavaScript, _) => [None, Some("}")],
            (Python, Opening::Once(_)) => [Some("break"), None],
            (Python, _) => [None, None],
            (Lua, Opening::Once(_)) => [None, Some("until true")],
            (Lua, _) => [None, Some("end")],
        }
    }

    fn leave(&self, label: Label) -> String {
        match self {
            JavaScript => format!("break block_{};", label.0),
            Python => "break".to_owned(),
            // It must be the last statement of a block.
            Lua => "do break end".to_owned(),
        }
    }

    fn nothing(&self) -> Option<&'static str> {
        (*self == Python).then_some("pass")
    }
}
