//! The functions that stand for ordinary WGSL are as accurate as their comments in `lib/ordinary.wgsl` say. With `ONEIRO_LONG=1` over every
//! float of their ranges.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::common::{Extent, TURNS, native, run, targets};
use oneiro_shader_compiler::{Part, trees};

/// A function of one or two numbers in WGSL, and what it is.
struct Case {
    wgsl: &'static str,
    truth: fn(f64, f64) -> f64,
    /// The range of `x`, and whether it has both signs.
    range: [f32; 2],
    is_signed: bool,
    others: &'static [f32],
    /// Maximum error in units in the last place.
    ulp: f64,
}

const LEAST: f32 = f32::MIN_POSITIVE;
const MOST: f32 = f32::MAX;
const ALONE: &[f32] = &[1.0];
const MANY: &[f32] = &[3.0, -0.7, 10.0, 1.999_999_9, 1e-20, -7e19];
const NEAR: &[f32] = &[3.0, -0.7, 1e-3, 1e3];

const fn case(wgsl: &'static str, truth: fn(f64, f64) -> f64, range: [f32; 2], is_signed: bool, ulp: f64) -> Case {
    Case {
        wgsl,
        truth,
        range,
        is_signed,
        others: ALONE,
        ulp,
    }
}

fn cases() -> Vec<Case> {
    vec![
        Case {
            others: MANY,
            ..case("x / y", |x, y| x / y, [LEAST, MOST], true, 0.500_001)
        },
        case("y / x", |x, y| y / x, [LEAST, 4.25e37], true, 0.500_001),
        case("sqrt(x)", |x, _| x.sqrt(), [LEAST, MOST], false, 0.500_001),
        case("inverseSqrt(x)", |x, _| 1.0 / x.sqrt(), [LEAST, MOST], false, 2.1),
        case("sin(x)", |x, _| x.sin(), [1e-30, 8000.0], true, 2.8),
        case("cos(x)", |x, _| x.cos(), [1e-30, 8000.0], true, 2.8),
        case("tan(x)", |x, _| x.tan(), [1e-30, 8000.0], true, 4.1),
        case("asin(x)", |x, _| x.asin(), [1e-30, 1.0], true, 3.4),
        case("acos(x)", |x, _| x.acos(), [1e-30, 1.0], true, 2.1),
        case("atan(x)", |x, _| x.atan(), [1e-30, 8e37], true, 3.2),
        Case {
            others: NEAR,
            ..case("atan2(y, x)", |x, y| y.atan2(x), [1e-30, 1e30], true, 3.2)
        },
        case("sinh(x)", |x, _| x.sinh(), [1e-30, 87.0], true, 3.6),
        case("cosh(x)", |x, _| x.cosh(), [1e-30, 87.0], true, 3.1),
        case("tanh(x)", |x, _| x.tanh(), [1e-30, 88.0], true, 2.0),
        case("asinh(x)", |x, _| arc_sinh(x), [1e-30, MOST], true, 2.7),
        case("acosh(x)", |x, _| x.acosh(), [1.0, MOST], false, 2.8),
        case("atanh(x)", |x, _| x.atanh(), [1e-30, 1.0_f32.next_down()], true, 2.4),
        case("exp(x)", |x, _| x.exp(), [1e-30, 87.0], true, 2.8),
        case("exp2(x)", |x, _| x.exp2(), [1e-30, 126.0], true, 1.3),
        case("log(x)", |x, _| x.ln(), [LEAST, MOST], false, 1.2),
        case("log2(x)", |x, _| x.log2(), [LEAST, MOST], false, 1.8),
        case("pow(x, 3.0)", |x, _| x.powi(3), [1e-12, 1e12], true, 1.4),
        case("pow(x, -2.0)", |x, _| x.powi(-2), [1e-18, 1e18], true, 1.6),
        case(
            "length(vec3(x, y, y))",
            |x, y| (x * x + 2.0 * y * y).sqrt(),
            [1e-18, 1e18],
            true,
            1.2,
        ),
    ]
}

/// asinh(x), also where x + sqrt(x^2 + 1) has lost x.
fn arc_sinh(x: f64) -> f64 {
    let size = x.abs();
    (size + size * size / (1.0 + size.hypot(1.0))).ln_1p().copysign(x)
}

/// One unit in the last place of a float near a number.
fn unit(x: f64) -> f64 {
    let exponent = (x.abs().to_bits() >> 52) as i64 - 1023;
    2.0_f64.powi(exponent.max(-126) as i32 - 23)
}

/// The results of a function for many numbers.
fn results(wgsl: &str, xs: &[f32], y: f32) -> Vec<f32> {
    let text = format!(
        "@group(0) @binding(0) var<storage, read> xs: array<f32>;
        @group(0) @binding(1) var<storage, read> ys: array<f32>;
        @group(0) @binding(2) var<storage, read_write> out: array<f32>;
        @compute @workgroup_size(64)
        fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {{
            let x = xs[64u * group.x + lane];
            let y = ys[0];
            out[64u * group.x + lane] = {wgsl};
        }}"
    );
    let part = Part {
        path: "ordinary".into(),
        text,
    };
    let trees = trees(&[part]).expect("it is ordinary");
    let target = &targets()[0];
    let lanes = *target.lanes().last().expect("there is a number of lanes");
    let native = native(target, &trees, lanes);
    let groups = xs.len().div_ceil(64);
    let mut words: Vec<_> = xs.iter().map(|x| x.to_bits()).collect();
    words.resize(64 * groups, 1.0_f32.to_bits());
    let extent = Extent {
        workgroups: 0..groups as u32,
        lanes: 64,
    };
    let count = words.len();
    let buffers = run(&native, vec![words, vec![y.to_bits()], vec![0; count]], &extent, TURNS).expect("it ends");
    buffers[2][..xs.len()]
        .iter()
        .map(|word| f32::from_bits(*word))
        .collect()
}

/// The maximum error of a function, and where it is.
fn error(case: &Case, stride: usize) -> (f64, [f32; 2]) {
    let mut most = (0.0, [0.0; 2]);
    let signs: &[u32] = if case.is_signed { &[0, 1 << 31] } else { &[0] };
    for y in case.others {
        for sign in signs {
            let all: Vec<u32> = (case.range[0].to_bits()..=case.range[1].to_bits())
                .step_by(stride)
                .collect();
            for some in all.chunks(1 << 20) {
                let xs: Vec<_> = some.iter().map(|bits| f32::from_bits(bits | sign)).collect();
                for (x, result) in xs.iter().zip(results(case.wgsl, &xs, *y)) {
                    let truth = (case.truth)(f64::from(*x), f64::from(*y));
                    let is_possible = (f64::from(LEAST)..=f64::from(MOST)).contains(&truth.abs());
                    assert!(
                        result.is_finite() && !result.is_subnormal(),
                        "{} at {x:e}: {result:e}",
                        case.wgsl
                    );
                    let error = (f64::from(result) - truth).abs() / unit(truth);
                    if is_possible && error > most.0 {
                        most = (error, [*x, *y]);
                    }
                }
            }
        }
    }
    most
}

#[test]
fn errors_are_as_stated() {
    let stride = if std::env::var_os("ONEIRO_LONG").is_some() {
        1
    } else {
        10_007
    };
    let mut problems = Vec::new();
    for case in cases() {
        let (error, [x, y]) = error(&case, stride);
        let result = format!("{:24} {error:.4} ulp at x {x:e}, y {y:e}", case.wgsl);
        eprintln!("{result}");
        if error > case.ulp || error < 0.5 * case.ulp {
            problems.push(format!("{result}; stated: {}", case.ulp));
        }
    }
    assert!(problems.is_empty(), "{problems:#?}");
}

/// The relative error of a power that isn't a constant grows with its exponent of two.
#[test]
fn the_error_of_powers_is_as_stated() {
    const STATED: f64 = 2e-7;
    let mut most = 0.0_f64;
    for y in [0.3_f32, -0.7, 1.5, -2.25, 7.125, 13.7, -18.1] {
        let xs: Vec<_> = (LEAST.to_bits()..MOST.to_bits())
            .step_by(10_007)
            .map(f32::from_bits)
            .collect();
        for (x, result) in xs.iter().zip(results("pow(x, y)", &xs, y)) {
            let exponent = f64::from(y) * f64::from(*x).log2();
            if exponent.abs() < 125.0 {
                let error = (f64::from(result) / exponent.exp2() - 1.0).abs();
                most = most.max(error / (1.0 + exponent.abs()));
            }
        }
    }
    assert!(most <= STATED && most > 0.4 * STATED, "{most:e}; stated: {STATED:e}");
}

/// What is exact, and what stands at the ends of ranges and beyond them.
#[test]
fn special_values() {
    for (wgsl, xs, y, expected) in [
        (
            "x / y",
            &[6.0_f32, 0.0, -7.5, 1e38, 1e-38][..],
            3.0_f32,
            &[2.0_f32, 0.0, -2.5, 1e38 / 3.0, 0.0][..],
        ),
        ("x / y", &[1e38, -1e38, 1.0], 1e-10, &[f32::MAX, -f32::MAX, 1e10]),
        ("x / 0.0", &[0.0, 1.0], 0.0, &[0.0, 1.701_411_8e38]),
        ("x % y", &[7.5, -7.5, 6.0], 2.0, &[1.5, -1.5, 0.0]),
        (
            "sqrt(x)",
            &[0.0, 9.0, 2.25, 1e10, -4.0],
            0.0,
            &[0.0, 3.0, 1.5, 1e5, 0.0],
        ),
        ("exp2(x)", &[0.0, 10.0, -3.0, -200.0], 0.0, &[1.0, 1024.0, 0.125, LEAST]),
        ("log2(x)", &[1.0, 1024.0, 0.125], 0.0, &[0.0, 10.0, -3.0]),
        ("exp(x) + log(x + 1.0)", &[0.0], 0.0, &[1.0]),
        (
            "acos(x)",
            &[1.0, -1.0, 2.0, 0.0],
            0.0,
            &[0.0, PI as f32, 0.0, FRAC_PI_2 as f32],
        ),
        (
            "atan2(x, y)",
            &[0.0, 1.0, -1.0],
            0.0,
            &[0.0, FRAC_PI_2 as f32, -FRAC_PI_2 as f32],
        ),
        ("atan2(x, y)", &[0.0, 1.0], -1.0, &[PI as f32, 2.356_194_5]),
        (
            "round(x)",
            &[0.5, 1.5, 2.5, -0.5, -1.5, -2.6, 1e9],
            0.0,
            &[0.0, 2.0, 2.0, 0.0, -2.0, -3.0, 1e9],
        ),
        ("ceil(x)", &[0.2, -0.2, 3.0], 0.0, &[1.0, 0.0, 3.0]),
        ("fract(x)", &[1.25, -1.25], 0.0, &[0.25, 0.75]),
        ("sign(x)", &[3.0, -3.0, 0.0], 0.0, &[1.0, -1.0, 0.0]),
        ("modf(x).fract", &[1.25, -1.25, 0.0], 0.0, &[0.25, -0.25, 0.0]),
        ("modf(x).whole", &[1.25, -1.25, 1e9], 0.0, &[1.0, -1.0, 1e9]),
        ("modf(vec3(x, y, -x)).fract.z", &[1.25], 0.0, &[-0.25]),
        (
            "frexp(x).fract",
            &[6.0, -0.5, 0.0, LEAST, MOST],
            0.0,
            &[0.75, -0.5, 0.0, 0.5, 0.999_999_94],
        ),
        (
            "f32(frexp(x).exp)",
            &[6.0, -0.5, 0.0, LEAST, MOST],
            0.0,
            &[3.0, 0.0, 0.0, -125.0, 128.0],
        ),
        ("f32(frexp(vec2(y, x)).exp.y)", &[6.0, 1024.0], 0.0, &[3.0, 11.0]),
        (
            "ldexp(x, i32(y))",
            &[3.0, -3.0, 0.0, LEAST],
            5.0,
            &[96.0, -96.0, 0.0, 32.0 * LEAST],
        ),
        (
            "ldexp(x, i32(y))",
            &[1e30, -1e30, 1e-30, 0.0],
            5000.0,
            &[MOST, -MOST, MOST, 0.0],
        ),
        (
            "ldexp(x, i32(y))",
            &[1e30, 1.0, 0.0],
            -127.0,
            &[1e30 / 1.701_411_8e38, 0.0, 0.0],
        ),
        ("ldexp(vec2(x, y), vec2(3, -1)).y", &[1.0], 3.0, &[1.5]),
        ("sinh(x) + cosh(x)", &[0.0], 0.0, &[1.0]),
        ("asinh(x) + atanh(x)", &[0.0], 0.0, &[0.0]),
        ("acosh(x)", &[1.0, 0.5], 0.0, &[0.0, 0.0]),
        ("refract(vec2(x, y), vec2(0.0, 1.0), 0.5).y", &[0.0], -1.0, &[-1.0]),
        ("refract(vec2(x, y), vec2(0.0, 1.0), 0.5).x", &[0.6], -0.8, &[0.3]),
        (
            "refract(vec3(x, y, 0.0), vec3(0.0, 1.0, 0.0), 2.0).x",
            &[0.6],
            -0.8,
            &[0.0],
        ),
        (
            "faceForward(vec2(x, y), vec2(x, y), vec2(0.0, 1.0)).x",
            &[3.0],
            1.0,
            &[-3.0],
        ),
        (
            "faceForward(vec2(x, y), vec2(x, y), vec2(0.0, 1.0)).x",
            &[3.0],
            -1.0,
            &[3.0],
        ),
        // Columns are (x, 2) and (3, y).
        ("(mat2x2(x, 2.0, 3.0, y) * vec2(10.0, 1.0)).x", &[5.0], 7.0, &[53.0]),
        ("(mat2x2(x, 2.0, 3.0, y) * vec2(10.0, 1.0)).y", &[5.0], 7.0, &[27.0]),
        ("(vec2(10.0, 1.0) * mat2x2(x, 2.0, 3.0, y)).y", &[5.0], 7.0, &[37.0]),
        ("transpose(mat2x2(x, 2.0, 3.0, y))[1].x", &[5.0], 7.0, &[2.0]),
        ("determinant(mat2x2(x, 2.0, 3.0, y))", &[5.0], 7.0, &[29.0]),
        (
            "(2.0 * mat2x2(x, 2.0, 3.0, y) * 3.0 + mat2x2(y, y, y, y))[1].y",
            &[5.0],
            7.0,
            &[49.0],
        ),
        (
            "(mat2x2(x, 2.0, 3.0, y) - mat2x2(y, x, y, x))[1].x",
            &[5.0],
            7.0,
            &[-4.0],
        ),
        (
            "(mat2x2(x, 2.0, 3.0, y) * mat2x2(1.0, 2.0, 3.0, 4.0))[1].y",
            &[5.0],
            7.0,
            &[34.0],
        ),
        (
            "(mat2x3(x, 1.0, 2.0, 3.0, y, 4.0) * mat3x2(1.0, 2.0, 3.0, 4.0, 5.0, 6.0))[2].y",
            &[5.0],
            7.0,
            &[47.0],
        ),
        ("transpose(mat2x3(x, 1.0, 2.0, 3.0, y, 4.0))[2].y", &[5.0], 7.0, &[4.0]),
        (
            "determinant(mat3x3(x, 2.0, 1.0, 0.0, 3.0, y, 1.0, 1.0, 1.0))",
            &[2.0],
            4.0,
            &[3.0],
        ),
        (
            "determinant(mat4x4(x, 2.0, 1.0, 3.0, 0.0, 3.0, y, 1.0, 1.0, 1.0, 1.0, 2.0, 5.0, 0.0, 1.0, 1.0))",
            &[2.0],
            4.0,
            &[-30.0],
        ),
        ("step(y, x)", &[0.9, 1.0, 1.1], 1.0, &[0.0, 1.0, 1.0]),
        ("smoothstep(0.0, y, x)", &[-1.0, 1.0, 5.0], 2.0, &[0.0, 0.5, 1.0]),
        ("mix(x, y, 0.5)", &[2.0], 4.0, &[3.0]),
        ("pow(x, 2.0) + pow(x, 0.5)", &[4.0, 9.0], 0.0, &[18.0, 84.0]),
        ("pow(x, 3.0)", &[-2.0], 0.0, &[-8.0]),
        ("length(vec2(x, y))", &[3.0], 4.0, &[5.0]),
        ("distance(vec2(x, y), vec2(0.0, 1.0))", &[3.0], 5.0, &[5.0]),
        ("dot(vec3(x, y, 1.0), vec3(1.0, 2.0, 3.0))", &[3.0], 4.0, &[14.0]),
        ("cross(vec3(x, 0.0, 0.0), vec3(0.0, y, 0.0)).z", &[3.0], 4.0, &[12.0]),
        ("reflect(vec2(x, y), vec2(0.0, 1.0)).y", &[3.0], 4.0, &[-4.0]),
        ("normalize(vec2(x, y)).x", &[0.0, 4.0], 0.0, &[0.0, 1.0]),
        ("degrees(radians(x))", &[0.0, 180.0], 0.0, &[0.0, 180.0]),
        ("f32(i32(x) / i32(y))", &[7.0, -7.0], 2.0, &[3.0, -3.0]),
        ("f32(i32(x) % i32(y))", &[7.0, -7.0], -2.0, &[1.0, -1.0]),
        ("f32(1u << u32(x))", &[3.0, 35.0], 0.0, &[8.0, 8.0]),
        ("f32(x > y)", &[1.0, -1.0], 0.0, &[1.0, 0.0]),
        (
            "f32(countOneBits(u32(x)))",
            &[0.0, 255.0, 1025.0],
            0.0,
            &[0.0, 8.0, 2.0],
        ),
        (
            "f32(countLeadingZeros(u32(x)))",
            &[0.0, 1.0, 1025.0],
            0.0,
            &[32.0, 31.0, 21.0],
        ),
        (
            "f32(countTrailingZeros(u32(x)))",
            &[0.0, 1.0, 1024.0],
            0.0,
            &[32.0, 0.0, 10.0],
        ),
        (
            "f32(firstLeadingBit(i32(x)))",
            &[0.0, 1.0, -5.0, 1024.0],
            0.0,
            &[-1.0, 0.0, 2.0, 10.0],
        ),
        ("f32(firstTrailingBit(i32(x)))", &[0.0, 12.0], 0.0, &[-1.0, 2.0]),
        ("f32(reverseBits(u32(x)) >> 24u)", &[1.0, 6.0], 0.0, &[128.0, 96.0]),
        (
            "f32(any(vec2(x, y) > vec2(0.0))) + 2.0 * f32(all(vec2(x, y) > vec2(0.0)))",
            &[1.0, -1.0],
            0.0,
            &[1.0, 0.0],
        ),
    ] {
        let found = results(wgsl, xs, y);
        let is_equal = found.iter().zip(expected).all(|(found, expected)| found == expected);
        assert!(is_equal, "{wgsl} of {xs:?} and {y}: {found:?}, not {expected:?}");
    }
}
