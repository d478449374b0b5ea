//! The operations that kernels may use.

use oneiro_shaders::{PROBE_OPERATIONS, probe_operations as kernel};

use super::{Case, Form, Scalar, Subject};
use crate::random::pcg4d;

/// The number of an operation in the kernel, and how WGSL writes it.
type Operation = (u32, &'static str);

/// Binary operations for both numbers and integers.
const PAIR: &[Operation] = &[
    (kernel::ADD, "x + y"),
    (kernel::SUBTRACT, "x - y"),
    (kernel::MULTIPLY, "x * y"),
    (kernel::MINIMUM, "min(x, y)"),
    (kernel::MAXIMUM, "max(x, y)"),
    (kernel::IS_LESS, "x < y"),
    (kernel::IS_LESS_OR_EQUAL, "x <= y"),
    (kernel::IS_GREATER, "x > y"),
    (kernel::IS_GREATER_OR_EQUAL, "x >= y"),
    (kernel::IS_EQUAL, "x == y"),
    (kernel::IS_UNEQUAL, "x != y"),
    (kernel::SELECT, "select(x, y, x > y)"),
];
const F32_PAIR: &[Operation] = &[
    (kernel::MULTIPLY_ADD, "x * y + x"),
    (kernel::SUBTRACT_PRODUCT, "y - x * y"),
    (kernel::SUBTRACT_SQUARES, "x * x - y * y"),
    (kernel::ADD_SUBTRACT, "(x + y) - y"),
    (kernel::SUBTRACT_ADD, "(x - y) + y"),
    (kernel::CLAMP, "clamp(x, -abs(y), abs(y))"),
];
const INTEGER_PAIR: &[Operation] = &[
    (kernel::AND, "x & y"),
    (kernel::OR, "x | y"),
    (kernel::XOR, "x ^ y"),
    (kernel::SHIFT_LEFT, "x << (y & 31)"),
    (kernel::SHIFT_RIGHT, "x >> (y & 31)"),
];
const U32_PAIR: &[Operation] = &[
    (kernel::DIVIDE, "(x & 0x7fffffff) / ((y & 0x7fffffff) | 1)"),
    (kernel::REMAINDER, "(x & 0x7fffffff) % ((y & 0x7fffffff) | 1)"),
];
const BOOL_PAIR: &[Operation] = &[
    (kernel::BOTH, "x && y"),
    (kernel::EITHER, "x || y"),
    (kernel::AND, "x & y"),
    (kernel::OR, "x | y"),
    (kernel::SELECT, "select(x, y, !x)"),
];
/// Unary operations.
const F32_ALONE: &[Operation] = &[
    (kernel::NEGATE, "-x"),
    (kernel::ABSOLUTE, "abs(x)"),
    (kernel::FLOOR, "floor(x)"),
    (kernel::TRUNCATE, "trunc(x)"),
    (kernel::TO_I32, "i32(clamp(x, -16777215, 16777215))"),
    (kernel::TO_U32, "u32(clamp(x, 0, 16777215))"),
    (kernel::SAME, "x"),
];
const I32_ALONE: &[Operation] = &[
    (kernel::NEGATE, "-x"),
    (kernel::COMPLEMENT, "~x"),
    (kernel::TO_F32, "f32(x >> 8)"),
    (kernel::TO_U32, "u32(x)"),
    (kernel::CLAMP_ALONE, "clamp(x, -1000, 1000)"),
];
const U32_ALONE: &[Operation] = &[
    (kernel::COMPLEMENT, "~x"),
    (kernel::TO_F32, "f32(x >> 8)"),
    (kernel::TO_I32, "i32(x)"),
    (kernel::CLAMP_ALONE, "clamp(x, 1000, 2000000000)"),
];
const BOOL_ALONE: &[Operation] = &[(kernel::NOT, "!x")];
/// Which operand is a constant, by the kernel's numbering.
const FORMS: [(u32, Form); 9] = [
    (kernel::OPEN, Form::Open),
    (kernel::RIGHT_0, Form::Right(0)),
    (kernel::RIGHT_1, Form::Right(1)),
    (kernel::RIGHT_MINUS_1, Form::Right(-1)),
    (kernel::RIGHT_2, Form::Right(2)),
    (kernel::LEFT_0, Form::Left(0)),
    (kernel::LEFT_1, Form::Left(1)),
    (kernel::LEFT_MINUS_1, Form::Left(-1)),
    (kernel::LEFT_2, Form::Left(2)),
];

/// Every operation that kernels may use, with both operands known only at run time, and with each of the constants 0,
/// 1, -1 and 2 instead of either. As in kernels, no operand, intermediate or result is NaN, infinite or subnormal.
pub fn operations() -> Vec<Case> {
    let types = [
        (kernel::F32, Scalar::F32, [PAIR, F32_PAIR].concat(), F32_ALONE),
        (kernel::I32, Scalar::I32, [PAIR, INTEGER_PAIR].concat(), I32_ALONE),
        (
            kernel::U32,
            Scalar::U32,
            [PAIR, INTEGER_PAIR, U32_PAIR].concat(),
            U32_ALONE,
        ),
        (kernel::BOOL, Scalar::Bool, BOOL_PAIR.to_vec(), BOOL_ALONE),
    ];
    let mut cases = Vec::new();
    for (of, scalar, pair, alone) in types {
        let forms = if scalar == Scalar::Bool { &FORMS[..1] } else { &FORMS };
        for &(form_number, form) in forms {
            let operands = operands(scalar, form);
            let alone = if form == Form::Open { alone } else { &[] };
            for &(number, text) in pair.iter().chain(alone) {
                let subject = Subject::Operation { scalar, text, form };
                cases.push(operation(subject, [of, number, form_number], &operands));
            }
        }
    }
    cases
}

fn operation(subject: Subject, [scalar, operation, form]: [u32; 3], operands: &[[u32; 2]]) -> Case {
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
    let probe = kernel::Probe {
        scalar,
        operation,
        form,
        count: left.len() as u32,
    };
    Case {
        kernel: &PROBE_OPERATIONS,
        subject,
        parameters: bytemuck::cast(probe),
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
