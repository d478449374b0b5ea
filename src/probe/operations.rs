//! The operations that kernels may use.

use oneiro_shaders::PROBE_OPERATIONS;

use super::{Case, Form, Scalar, Subject};
use crate::random::pcg4d;

/// Binary operations by their number in the kernel: first those for both numbers and integers.
const PAIR: &[&str] = &[
    "x + y",
    "x - y",
    "x * y",
    "min(x, y)",
    "max(x, y)",
    "x < y",
    "x <= y",
    "x > y",
    "x >= y",
    "x == y",
    "x != y",
    "select(x, y, x > y)",
];
const F32_PAIR: &[&str] = &[
    "x * y + x",
    "y - x * y",
    "x * x - y * y",
    "(x + y) - y",
    "(x - y) + y",
    "clamp(x, -abs(y), abs(y))",
];
const INTEGER_PAIR: &[&str] = &["x & y", "x | y", "x ^ y", "x << (y & 31)", "x >> (y & 31)"];
const U32_PAIR: &[&str] = &[
    "(x & 0x7fffffff) / ((y & 0x7fffffff) | 1)",
    "(x & 0x7fffffff) % ((y & 0x7fffffff) | 1)",
];
const BOOL_PAIR: &[&str] = &["x && y", "x || y", "x & y", "x | y", "!x", "select(x, y, !x)"];
/// Unary operations by their number less [`ALONE`].
const F32_ALONE: &[&str] = &[
    "-x",
    "abs(x)",
    "floor(x)",
    "trunc(x)",
    "i32(clamp(x, -16777215, 16777215))",
    "u32(clamp(x, 0, 16777215))",
    "x",
];
const I32_ALONE: &[&str] = &["-x", "~x", "f32(x >> 8)", "u32(x)", "clamp(x, -1000, 1000)"];
const U32_ALONE: &[&str] = &["~x", "f32(x >> 8)", "i32(x)", "clamp(x, 1000, 2000000000)"];
const ALONE: u32 = 32;
/// Which operand is a constant, by the kernel's numbering.
const FORMS: [Form; 9] = [
    Form::Open,
    Form::Right(0),
    Form::Right(1),
    Form::Right(-1),
    Form::Right(2),
    Form::Left(0),
    Form::Left(1),
    Form::Left(-1),
    Form::Left(2),
];

/// Every operation that kernels may use, with both operands known only at run time, and with each of the constants 0,
/// 1, -1 and 2 in place of either. As in kernels, no operand, intermediate or result is NaN, infinite or subnormal.
pub fn operations() -> Vec<Case> {
    let scalars = [
        (Scalar::F32, [PAIR, F32_PAIR].concat(), F32_ALONE),
        (Scalar::I32, [PAIR, INTEGER_PAIR].concat(), I32_ALONE),
        (Scalar::U32, [PAIR, INTEGER_PAIR, U32_PAIR].concat(), U32_ALONE),
        (Scalar::Bool, BOOL_PAIR.to_vec(), &[]),
    ];
    let mut cases = Vec::new();
    for (index, (scalar, pair, alone)) in scalars.into_iter().enumerate() {
        let forms = if scalar == Scalar::Bool { &FORMS[..1] } else { &FORMS };
        let kind = index as u32 * 256;
        for (form_number, &form) in forms.iter().enumerate() {
            let operands = operands(scalar, form);
            for (text, number) in pair.iter().zip(kind..) {
                let subject = Subject::Operation { scalar, text, form };
                cases.push(operation(subject, [number, form_number as u32], &operands));
            }
            if form == Form::Open {
                for (text, number) in alone.iter().zip(kind + ALONE..) {
                    let subject = Subject::Operation { scalar, text, form };
                    cases.push(operation(subject, [number, 0], &operands));
                }
            }
        }
    }
    cases
}

fn operation(subject: Subject, [number, form]: [u32; 2], operands: &[[u32; 2]]) -> Case {
    let ordinary = |&&[x, y]: &&[u32; 2]| match subject {
        Subject::Operation {
            scalar: Scalar::F32,
            text,
            ..
        } => steps(text, f32::from_bits(x), f32::from_bits(y))
            .into_iter()
            .all(is_ordinary),
        _ => true,
    };
    let (left, right): (Vec<u32>, Vec<u32>) = operands.iter().filter(ordinary).map(|&[x, y]| (x, y)).unzip();
    let parameters = [number, form, left.len() as u32, 0];
    Case {
        kernel: &PROBE_OPERATIONS,
        subject,
        parameters,
        left,
        right,
    }
}

/// Intermediate values of operations that can leave the range of normal numbers.
fn steps(text: &str, x: f32, y: f32) -> [f32; 3] {
    let product = x * y;
    match text {
        "x + y" => [x + y; 3],
        "x - y" => [x - y; 3],
        "x * y" => [product; 3],
        "x * y + x" => [product, product + x, 0.0],
        "y - x * y" => [product, y - product, 0.0],
        "x * x - y * y" => [x * x, y * y, x * x - y * y],
        "(x + y) - y" => [x + y, (x + y) - y, 0.0],
        "(x - y) + y" => [x - y, (x - y) + y, 0.0],
        _ => [0.0; 3],
    }
}

fn is_ordinary(x: f32) -> bool {
    x == 0.0 || x.is_normal()
}

/// Pairs of operands: special with special ones, and random ones.
fn operands(scalar: Scalar, form: Form) -> Vec<[u32; 2]> {
    const RANDOM: u32 = 640;
    let special: Vec<u32> = match scalar {
        Scalar::F32 => special_numbers(),
        Scalar::I32 | Scalar::U32 => SPECIAL_INTEGERS.to_vec(),
        Scalar::Bool => vec![0, 1],
    };
    let mut pairs: Vec<[u32; 2]> = Vec::new();
    for &x in &special {
        pairs.extend(special.iter().map(|&y| [x, y]));
    }
    pairs.extend((0..RANDOM).map(|index| random_pair(scalar, index)));
    let constant = |value: i8| match scalar {
        Scalar::F32 => f32::from(value).to_bits(),
        _ => i32::from(value) as u32,
    };
    for [x, y] in &mut pairs {
        match form {
            Form::Open => {}
            Form::Right(value) => *y = constant(value),
            Form::Left(value) => *x = constant(value),
        }
    }
    if form != Form::Open {
        pairs.sort_unstable();
        pairs.dedup();
    }
    pairs
}

/// Operands at which rounding, exponents or drivers change their behaviour.
fn special_numbers() -> Vec<u32> {
    const SIZES: [f32; 27] = [
        0.0,
        f32::MIN_POSITIVE,
        2.0 * f32::MIN_POSITIVE,
        1e-30,
        1e-19,
        f32::EPSILON,
        0.25,
        0.333_333_34,
        0.499_999_97,
        0.5,
        0.75,
        0.999_999_94,
        1.0,
        1.000_000_1,
        1.5,
        2.0,
        2.5,
        3.0,
        1023.0,
        4_194_304.5,
        8_388_607.5,
        8_388_608.0,
        8_388_609.0,
        16_777_216.0,
        4_294_967_296.0,
        1.844_674_3e19,
        f32::MAX,
    ];
    SIZES
        .iter()
        .flat_map(|size| [size.to_bits(), (-size).to_bits()])
        .collect()
}

const SPECIAL_INTEGERS: [u32; 24] = [
    0,
    1,
    2,
    3,
    7,
    8,
    31,
    32,
    33,
    255,
    256,
    0xffff,
    0x1_0000,
    0x7f_ffff,
    0x55aa_55aa,
    0x7fff_fffe,
    0x7fff_ffff,
    0x8000_0000,
    0x8000_0001,
    0xaa55_aa55,
    0xffff_0000,
    0xffff_fffd,
    0xffff_fffe,
    0xffff_ffff,
];

/// A random pair. Every other pair of numbers has similar magnitudes, so that digits cancel.
fn random_pair(scalar: Scalar, index: u32) -> [u32; 2] {
    let [a, b, c, d] = pcg4d([index, 0, 0, 0]);
    if scalar != Scalar::F32 {
        return [a, b];
    }
    let number = |digits: u32, exponent: u32| digits & 0x807f_ffff | (127 - 30 + exponent) << 23;
    let exponent = c % 60;
    let other = if index.is_multiple_of(2) {
        d % 60
    } else {
        exponent + d % 2
    };
    [number(a, exponent), number(b, other)]
}
