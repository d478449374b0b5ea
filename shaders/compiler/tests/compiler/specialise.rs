//! Operations of which one operand is a constant are left out only where that changes no bit, also of zeros of either sign.

use std::fmt::Write as _;

use oneiro_shader_compiler::interpret::{Memory, run_invocation};
use oneiro_shader_compiler::specialise::Known;
use oneiro_shader_compiler::tree::{Binary, Op, Program, Statement, visit};
use oneiro_shader_compiler::{Generic, Part, trees};

const KERNEL: &str = "
@group(0) @binding(0) var<storage, read> numbers: array<f32>;
@group(0) @binding(1) var<storage, read_write> results: array<u32>;
@compute @workgroup_size(64)
fn main(@builtin(local_invocation_index) lane: u32) {
    let x = numbers[lane];
    let n = bitcast<u32>(x);
    let i = bitcast<i32>(n);
    let b = x < 1.0f;
    let at = lane * 32u;
";

/// What is stored of each number, as WGSL.
const RESULTS: [&str; 24] = [
    "bitcast<u32>(x + 0.0f)",
    "bitcast<u32>(0.0f + x)",
    "bitcast<u32>(x + -0.0f)",
    "bitcast<u32>(x - 0.0f)",
    "bitcast<u32>(x - -0.0f)",
    "bitcast<u32>(0.0f - x)",
    "bitcast<u32>(x * 1.0f)",
    "bitcast<u32>(1.0f * x)",
    "bitcast<u32>(x * 0.0f)",
    "bitcast<u32>(max(x, 0.0f))",
    "n + 0u",
    "n - 0u",
    "0u - n",
    "n * 1u",
    "n * 0u",
    "n / 1u",
    "n % 1u",
    "(n & 0xffffffffu) | (n & 0u)",
    "n ^ 0u",
    "n << 0u",
    "bitcast<u32>(i >> 0u)",
    "bitcast<u32>(i * 1i)",
    "select(0u, 1u, b & true)",
    "select(0u, 1u, (b | true) & (b | false))",
];

/// Runs the kernel in part evaluated, and compares all results with those of the whole one.
fn compared(signed_zeros: bool, is_same: impl Fn(u32, u32) -> bool) -> [Program; 2] {
    let mut text = KERNEL.to_owned();
    for (index, result) in RESULTS.iter().enumerate() {
        writeln!(text, "    results[at + {index}u] = {result};").unwrap();
    }
    text += "}\n";
    let parts = [Part {
        path: "kernel".into(),
        text,
    }];
    let raw = trees(&parts).unwrap_or_else(|refusals| panic!("{refusals:?}")).raw;
    let generic = Generic::new(&parts).unwrap();
    let known = Known {
        word: &|_, _, _| None,
        signed_zeros,
    };
    let program = generic.program(&known);
    let mut numbers = vec![
        0.0_f32,
        -0.0,
        1.0,
        -1.0,
        0.5,
        f32::MIN_POSITIVE,
        -f32::MIN_POSITIVE,
        16_777_216.0,
    ];
    numbers.extend((8..64).map(|index| (index as f32 - 30.5) * 0.37));
    let run = |program: &Program| {
        let words = numbers.iter().map(|number| number.to_bits()).collect();
        let mut buffers = vec![words, vec![0; 64 * 32]];
        let strides = [1, 1];
        for lane in 0..64 {
            let mut memory = Memory {
                buffers: &mut buffers,
                strides: &strides,
            };
            run_invocation(program, &mut memory, 0, lane, true).unwrap();
        }
        buffers.pop().unwrap()
    };
    let (expected, found) = (run(&raw), run(&program));
    for (at, (found, expected)) in found.iter().zip(&expected).enumerate() {
        let what = RESULTS.get(at % 32).unwrap_or(&"");
        assert!(
            is_same(*found, *expected),
            "{what} of {}: {found:#x}, not {expected:#x}",
            numbers[at / 32]
        );
    }
    [raw, program]
}

/// Number of operations on two operands.
fn operations(program: &Program) -> u32 {
    let mut count = 0;
    visit(&program.body, &mut |statement| {
        count += u32::from(matches!(statement, Statement::Let(value) if matches!(program.op(*value), Op::Binary(..))));
    });
    count
}

#[test]
fn operands_stand_for_results_where_no_bit_differs() {
    let [raw, program] = compared(true, |found, expected| found == expected);
    assert!(
        operations(&program) + 10 <= operations(&raw),
        "most of them are left out"
    );
}

/// More of them do where zeros' signs don't matter, and then only those differ.
#[test]
fn zeros_may_lose_their_signs() {
    let [_, exact] = compared(true, |_, _| true);
    let is_zero = |bits: u32| f32::from_bits(bits) == 0.0;
    let [_, program] = compared(false, |found, expected| {
        found == expected || (is_zero(found) && is_zero(expected))
    });
    assert!(operations(&program) + 5 <= operations(&exact), "more are left out");
}

/// Values that don't change in a loop are loaded and multiplied before it; those that a turn writes are not.
#[test]
fn loops_do_once_what_does_not_change() {
    let text = "
@group(0) @binding(0) var<storage, read> numbers: array<f32>;
@group(0) @binding(1) var<storage, read_write> results: array<f32>;
@compute @workgroup_size(64)
fn main(@builtin(local_invocation_index) lane: u32) {
    var sum = 0.0f;
    for (var turn = 0u; turn < u32(numbers[0]); turn++) {
        sum += numbers[lane] * 3.0f + results[lane];
        results[lane] = sum;
    }
}
";
    let parts = [Part {
        path: "kernel".into(),
        text: text.into(),
    }];
    let known = Known {
        word: &|_, _, _| None,
        signed_zeros: true,
    };
    let program = Generic::new(&parts).unwrap().program(&known);
    let (mut loads, mut products) = ([0; 2], 0);
    visit(&program.body, &mut |statement| {
        let Statement::Loop { body, .. } = statement else {
            return;
        };
        visit(body, &mut |statement| match statement {
            Statement::Load { address, .. } => loads[address.buffer as usize] += 1,
            Statement::Let(value) => {
                products += u32::from(matches!(program.op(*value), Op::Binary(Binary::Multiply, ..)));
            }
            _ => {}
        });
    });
    assert_eq!(
        (loads, products),
        ([0, 1], 0),
        "only what turns write is loaded in them"
    );
}
