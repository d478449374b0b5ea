//! Every operation that kernels may use gives the bits that IEEE 754 and integers modulo 2^32 require, in every lane
//! code.

use oneiro::probe::{Case, Form, Scalar, Subject, operations};

/// Bits of a number, with zero's one sign.
fn stored(x: f32) -> u32 {
    if x == 0.0 { 0 } else { x.to_bits() }
}

/// Result of an operation in Rust.
fn reference(scalar: Scalar, text: &str, left: u32, right: u32) -> u32 {
    match scalar {
        Scalar::F32 => of_numbers(text, f32::from_bits(left), f32::from_bits(right)),
        Scalar::I32 => of_integers(text, (left as i32).into(), (right as i32).into()),
        Scalar::U32 => of_integers(text, left.into(), right.into()),
        Scalar::Bool => of_truths(text, left & 1 == 1, right & 1 == 1),
    }
}

fn of_numbers(text: &str, x: f32, y: f32) -> u32 {
    let size = y.abs();
    stored(match text {
        "x + y" => x + y,
        "x - y" => x - y,
        "x * y" => x * y,
        "min(x, y)" | "select(x, y, x > y)" => x.min(y),
        "max(x, y)" => x.max(y),
        "x * y + x" => x * y + x,
        "y - x * y" => y - x * y,
        "x * x - y * y" => x * x - y * y,
        "(x + y) - y" => (x + y) - y,
        "(x - y) + y" => (x - y) + y,
        "clamp(x, -abs(y), abs(y))" => x.clamp(-size, size),
        "-x" => -x,
        "abs(x)" => x.abs(),
        "floor(x)" => x.floor(),
        "trunc(x)" => x.trunc(),
        "x" => x,
        "i32(clamp(x, -16777215, 16777215))" => return (f64::from(x) as i64).clamp(-16_777_215, 16_777_215) as u32,
        "u32(clamp(x, 0, 16777215))" => return (f64::from(x) as i64).clamp(0, 16_777_215) as u32,
        _ => return u32::from(comparison(text, x, y)),
    })
}

/// Signed or unsigned: exact, then modulo 2^32.
fn of_integers(text: &str, x: i128, y: i128) -> u32 {
    let whole = match text {
        "x + y" => x + y,
        "x - y" => x - y,
        "x * y" => x * y,
        "min(x, y)" | "select(x, y, x > y)" => x.min(y),
        "max(x, y)" => x.max(y),
        "x & y" => x & y,
        "x | y" => x | y,
        "x ^ y" => x ^ y,
        "x << (y & 31)" => x << (y & 31),
        "x >> (y & 31)" => x >> (y & 31),
        "(x & 0x7fffffff) / ((y & 0x7fffffff) | 1)" => (x % (1 << 31)) / ((y % (1 << 31)) | 1),
        "(x & 0x7fffffff) % ((y & 0x7fffffff) | 1)" => (x % (1 << 31)) % ((y % (1 << 31)) | 1),
        "-x" => -x,
        "~x" => -x - 1,
        "i32(x)" | "u32(x)" => x,
        "clamp(x, -1000, 1000)" => x.clamp(-1000, 1000),
        "clamp(x, 1000, 2000000000)" => x.clamp(1000, 2_000_000_000),
        "f32(x >> 8)" => return stored((x >> 8) as f32),
        _ => return u32::from(comparison(text, x, y)),
    };
    whole.rem_euclid(1 << 32) as u32
}

fn of_truths(text: &str, x: bool, y: bool) -> u32 {
    u32::from(match text {
        "x && y" | "x & y" => x && y,
        "x || y" | "x | y" | "select(x, y, !x)" => x || y,
        "!x" => !x,
        _ => panic!("no reference for bool {text}"),
    })
}

fn comparison<T: PartialOrd + Copy>(text: &str, x: T, y: T) -> bool {
    match text {
        "x < y" => x < y,
        "x <= y" => x <= y,
        "x > y" => x > y,
        "x >= y" => x >= y,
        "x == y" => x == y,
        "x != y" => x != y,
        _ => panic!("no reference for {text}"),
    }
}

fn scalar_and_text(case: &Case) -> (Scalar, &'static str, Form) {
    match case.subject {
        Subject::Operation { scalar, text, form } => (scalar, text, form),
        Subject::Function(name) => panic!("{name} is no operation"),
    }
}

#[test]
fn every_lane_code_computes_every_operation() {
    for case in operations() {
        let (scalar, text, _) = scalar_and_text(&case);
        let operands = || case.left.iter().zip(&case.right);
        let expected: Vec<u32> = operands().map(|(&x, &y)| reference(scalar, text, x, y)).collect();
        assert!(case.lane_codes().count() > 1, "{}", case.subject);
        for variant in case.lane_codes() {
            let results = case.run(variant).unwrap();
            assert_eq!(results.len(), expected.len(), "{} in {}", case.subject, variant);
            for ((x, y), (result, expected)) in operands().zip(results.iter().zip(&expected)) {
                assert_eq!(
                    result, expected,
                    "{} of {x:#010x}, {y:#010x} in {}: {result:#010x}, not {expected:#010x}",
                    case.subject, variant
                );
            }
        }
    }
}

/// Number of operands for which an operation on numbers gives other bits when it is computed in a wrong way.
fn shown(text: &str, wrong: impl Fn(f32, f32) -> f32) -> usize {
    let open = (Scalar::F32, text, Form::Open);
    let cases = operations();
    let case = cases.iter().find(|case| scalar_and_text(case) == open).unwrap();
    let operands = case.left.iter().zip(&case.right);
    let differ = operands
        .filter(|&(&x, &y)| stored(wrong(f32::from_bits(x), f32::from_bits(y))) != reference(Scalar::F32, text, x, y));
    differ.count()
}

/// A control: a lane code that contracted products and sums would be caught.
#[test]
fn contraction_shows() {
    assert!(shown("x * y + x", |x, y| x.mul_add(y, x)) > 20);
    assert!(shown("y - x * y", |x, y| (-x).mul_add(y, y)) > 20);
    assert!(shown("x * x - y * y", |x, y| x.mul_add(x, -(y * y))) > 20);
}

/// A control: algebraic folding of constants and reassociation of sums would be caught.
#[test]
fn reassociation_shows() {
    for text in ["(x + y) - y", "(x - y) + y"] {
        assert!(shown(text, |x, _| x) > 100, "{text}");
    }
}

#[test]
fn operands_and_results_are_ordinary_numbers() {
    let ordinary = |word: u32| f32::from_bits(word).is_normal() || f32::from_bits(word) == 0.0;
    let mut forms = 0;
    for case in operations() {
        let (scalar, text, form) = scalar_and_text(&case);
        assert!(
            case.left.len() >= 4 && case.left.len() == case.right.len(),
            "{}",
            case.subject
        );
        forms += usize::from(form != Form::Open);
        if scalar != Scalar::F32 {
            continue;
        }
        assert!(
            case.left.iter().chain(&case.right).all(|&word| ordinary(word)),
            "{}",
            case.subject
        );
        if ["x + y", "x - y", "x * y", "x * y + x", "y - x * y", "x * x - y * y"].contains(&text) {
            let results = case.left.iter().zip(&case.right);
            let mut results = results.map(|(&x, &y)| reference(scalar, text, x, y));
            assert!(results.all(ordinary), "{}", case.subject);
        }
    }
    assert_eq!(forms, 8 * (18 + 17 + 19));
}
