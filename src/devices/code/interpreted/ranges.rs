//! Ranges of the arguments of kernels' functions (`docs/extend.md`). Outside them results have no meaning but may be exact, so
//! checks of each operation don't find them.

use oneiro_shader_compiler::{Part, Place};
use oneiro_shader_parts::PARTS;

use crate::exact::{LEAST, RECIPROCAL_GREATEST, ROOT_LEAST, TURNS_GREATEST};

/// The parts that have the functions.
const NUMERICS: &str = "lib/numerics.wgsl";
const ORDINARY: &str = "lib/ordinary.wgsl";

/// The range of a function's argument.
struct Range {
    function: &'static str,
    /// How a call begins in messages.
    call: &'static str,
    parameter: &'static str,
    least: f32,
    greatest: f32,
    /// Whether that is the range of its magnitude.
    is_signed: bool,
    has_zero: bool,
    words: &'static str,
}

/// A function of numbers that are not smaller than the smallest normal one.
const POSITIVE: Range = Range {
    function: "",
    call: "",
    parameter: "x",
    least: LEAST,
    greatest: f32::MAX,
    is_signed: false,
    has_zero: false,
    words: "from 1.2e-38",
};

/// A function of an angle in radians.
const ANGLE: Range = Range {
    greatest: 8000.0,
    is_signed: true,
    has_zero: true,
    words: "up to 8,000 radians, of both signs",
    ..POSITIVE
};

/// A function of a sine or a cosine.
const COSINE: Range = Range {
    greatest: 1.0,
    is_signed: true,
    has_zero: true,
    words: "-1 to 1",
    ..POSITIVE
};

const RANGES: [Range; 17] = [
    Range {
        function: "reciprocal",
        call: "reciprocal(",
        greatest: RECIPROCAL_GREATEST,
        is_signed: true,
        words: "from 1.2e-38 to 8e37, of both signs",
        ..POSITIVE
    },
    Range {
        function: "reciprocal_root",
        call: "reciprocal_root(",
        ..POSITIVE
    },
    Range {
        function: "root",
        call: "root(",
        least: ROOT_LEAST,
        has_zero: true,
        words: "0, and from 8e-31",
        ..POSITIVE
    },
    Range {
        function: "cosine_sine",
        call: "cosine_sine(",
        parameter: "turns",
        greatest: TURNS_GREATEST,
        is_signed: true,
        has_zero: true,
        words: "up to 8 million turns, of both signs",
        ..POSITIVE
    },
    Range {
        function: "logarithm",
        call: "logarithm(",
        ..POSITIVE
    },
    Range {
        function: "wgsl_divide",
        call: "x / (",
        parameter: "b",
        is_signed: true,
        words: "from 1.2e-38, of both signs",
        ..POSITIVE
    },
    Range {
        function: "wgsl_sqrt",
        call: "sqrt(",
        has_zero: true,
        words: "0, and from 1.2e-38",
        ..POSITIVE
    },
    Range {
        function: "wgsl_inverseSqrt",
        call: "inverseSqrt(",
        ..POSITIVE
    },
    Range {
        function: "wgsl_log",
        call: "log(",
        ..POSITIVE
    },
    Range {
        function: "wgsl_log2",
        call: "log2(",
        ..POSITIVE
    },
    Range {
        function: "wgsl_sin",
        call: "sin(",
        ..ANGLE
    },
    Range {
        function: "wgsl_cos",
        call: "cos(",
        ..ANGLE
    },
    Range {
        function: "wgsl_tan",
        call: "tan(",
        ..ANGLE
    },
    Range {
        function: "wgsl_asin",
        call: "asin(",
        ..COSINE
    },
    Range {
        function: "wgsl_acos",
        call: "acos(",
        ..COSINE
    },
    Range {
        function: "wgsl_acosh",
        call: "acosh(",
        least: 1.0,
        words: "from 1",
        ..POSITIVE
    },
    Range {
        function: "wgsl_atanh",
        call: "atanh(",
        greatest: 1.0f32.next_down(),
        words: "between -1 and 1",
        ..COSINE
    },
];

/// Divisions of signed integers, and how they are written. WGSL gives those by 0 a value, which hardly is meant.
const QUOTIENTS: [(&str, &str); 2] = [("wgsl_divide_i32", "x / (0)"), ("wgsl_modulo_i32", "x % (0)")];

/// How a function begins.
fn head(function: &str) -> String {
    format!("fn {function}(")
}

impl Range {
    /// Whether the argument is within, in WGSL.
    fn within(&self) -> String {
        let Self {
            parameter,
            least,
            greatest,
            ..
        } = self;
        let size = if self.is_signed {
            format!("abs({parameter})")
        } else {
            (*parameter).to_owned()
        };
        let zero = if self.has_zero {
            format!(" | ({parameter} == 0.0f)")
        } else {
            String::new()
        };
        format!("(({size} >= {least:?}f) & ({size} <= {greatest:?}f)){zero}")
    }
}

/// Makes these functions divide their argument's bits by 0 where it is out of its range, in the line of their head: a division that is
/// checked. What the compiler would add for ordinary WGSL stands before the other parts.
pub(super) fn checked(mut parts: Vec<Part>) -> Vec<Part> {
    let ordinary = PARTS.iter().filter(|(path, _)| *path == ORDINARY);
    let ordinary = ordinary.map(|(path, text)| Part {
        path: (*path).into(),
        text: (*text).into(),
    });
    parts.splice(0..0, ordinary);
    for part in parts
        .iter_mut()
        .filter(|part| [NUMERICS, ORDINARY].contains(&part.path.as_str()))
    {
        let ranges = RANGES
            .iter()
            .map(|range| (range.function, range.parameter, range.within()));
        let quotients = QUOTIENTS.map(|(function, _)| (function, "b", "b != 0".to_owned()));
        for (function, parameter, within) in ranges.chain(quotients) {
            let head = part.text.find(&head(function));
            let Some(body) = head.and_then(|head| Some(head + part.text[head..].find('{')? + 1)) else {
                continue;
            };
            let check = format!(" let within = bitcast<u32>({parameter}) / select(0u, 1u, {within});");
            part.text.insert_str(body, &check);
        }
    }
    parts
}

/// The message for a breach of these divisions: the function with its argument, and its range.
pub(super) fn breach(place: &Place, what: &str) -> Option<String> {
    let bits = what.split_once("u / 0u")?.0.parse().ok()?;
    let mut parts = PARTS.iter();
    let (_, text) = parts.find(|(path, _)| [NUMERICS, ORDINARY].contains(path) && *path == place.path)?;
    let line = text.lines().nth(place.line - 1)?;
    let is_of = |function: &str| line.starts_with(&head(function));
    if let Some((_, call)) = QUOTIENTS.iter().find(|(function, _)| is_of(function)) {
        return Some(format!("{call} is a division by 0"));
    }
    let Range { call, words, .. } = RANGES.iter().find(|range| is_of(range.function))?;
    let argument = f32::from_bits(bits);
    Some(format!("{call}{argument:?}f) is out of its range, which is {words}"))
}
