//! What machine code of any card must not have: operations on floats that round in another way than IEEE's do, one by one.

/// What an instruction does to floats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// None of them, or an operation that rounds as IEEE says.
    Exact,
    /// A product, rounded.
    Product,
    /// A float of an integer, rounded to nearest.
    OfInteger,
    /// The integer part of a float.
    ToInteger,
    /// A product and a sum, rounded once: its first two operands are the factors.
    Fused,
    /// An estimate of a reciprocal.
    Reciprocal,
    /// Anything else. What nobody has looked at is here.
    Inexact,
}

/// An instruction. Its registers are without signs and types.
#[derive(Clone, Debug)]
pub(crate) struct Instruction<'a> {
    pub(crate) kind: Kind,
    pub(crate) text: &'a str,
    pub(crate) result: &'a str,
    pub(crate) operands: Vec<&'a str>,
}

/// A little less than 2^32: the reciprocal of a whole number is scaled by it where integers are divided.
const SCALE: f32 = f32::from_bits(0x4f7f_fffe);

/// A constant: a decimal fraction, or the bits.
fn constant(operand: &str) -> Option<f32> {
    let digits = operand.trim_start_matches('-');
    match digits.strip_prefix("0x") {
        Some(bits) => u32::from_str_radix(bits, 16).ok().map(f32::from_bits),
        // One without a fraction is an integer's bits.
        None => digits.contains('.').then(|| digits.parse().ok())?,
    }
}

/// A product with a power of two is exact, so it does not matter when it is rounded.
fn is_power_of_two(operand: &str) -> bool {
    constant(operand).is_some_and(|value| value.is_normal() && value.to_bits().trailing_zeros() >= 23)
}

/// What reads the result of an instruction before something else is written there.
fn readers(code: &[Instruction<'_>], at: usize) -> Vec<usize> {
    let register = code[at].result;
    let mut found = Vec::new();
    for (later, other) in code.iter().enumerate().skip(at + 1) {
        if other.operands.contains(&register) {
            found.push(later);
        }
        if other.result == register {
            break;
        }
    }
    found
}

/// Whether a reciprocal is the estimate that an integer division begins with, which corrects it: of a whole number, and only used
/// scaled and as a whole number.
fn divides_integers(code: &[Instruction<'_>], at: usize) -> bool {
    let only_for = |of: usize, is_right: &dyn Fn(usize) -> bool| {
        let readers = readers(code, of);
        !readers.is_empty() && readers.into_iter().all(is_right)
    };
    let is_whole = |reader: usize| code[reader].kind == Kind::ToInteger;
    let is_scaled = |reader: usize| {
        let product = &code[reader];
        product.kind == Kind::Product
            && product.operands.iter().any(|one| constant(one) == Some(SCALE))
            && only_for(reader, &is_whole)
    };
    let set = code[..at].iter().rfind(|other| other.result == code[at].operands[0]);
    set.is_some_and(|set| set.kind == Kind::OfInteger) && only_for(at, &is_scaled)
}

/// Instructions that may give other bits than IEEE's operations one by one.
pub(crate) fn inexact<'a>(code: &[Instruction<'a>]) -> Vec<&'a str> {
    let is_inexact = |at: &usize| match code[*at].kind {
        Kind::Exact | Kind::Product | Kind::OfInteger | Kind::ToInteger => false,
        Kind::Fused => !code[*at].operands.iter().take(2).any(|factor| is_power_of_two(factor)),
        Kind::Reciprocal => !divides_integers(code, *at),
        Kind::Inexact => true,
    };
    let found = (0..code.len()).filter(is_inexact);
    found.map(|at| code[at].text).collect()
}
