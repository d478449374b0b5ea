//! Tidying takes branches on constants, and changes no results.

use oneiro_shader_compiler::interpret::{Memory, run_invocation};
use oneiro_shader_compiler::tree::{Op, Program, Statement, visit};
use oneiro_shader_compiler::{Part, trees};

/// Branches on constants in every kind of block, some in branches that are never taken.
const KERNEL: &str = "
const CHOICE: u32 = 2u;
const IS_ON: bool = true;
@group(0) @binding(0) var<storage, read_write> words: array<u32>;

fn chosen(x: u32) -> u32 {
    if (CHOICE == 1u) {
        return x + 100u;
    } else if (CHOICE == 2u) {
        return x + 200u;
    }
    return x + 300u;
}

@compute @workgroup_size(64)
fn main(@builtin(local_invocation_index) lane: u32) {
    var x = words[lane];
    if (false) {
        x = 1000u;
        if (true) { x = 2000u; }
    }
    if (x > 5u) {
        if (IS_ON) { x += 1u; } else { x += 2u; }
    } else {
        if (!IS_ON) { x += 4u; } else { if (true) { x += 8u; } }
    }
    for (var i = 0u; i < 3u; i++) {
        if (false) { break; }
        x += 16u;
    }
    loop {
        x += 32u;
        if (IS_ON) { break; }
    }
    words[lane] = chosen(x);
}
";

/// Numbers of branches on constants, and on other values.
fn branches(program: &Program) -> [usize; 2] {
    let mut branches = [0; 2];
    visit(&program.body, &mut |statement| {
        if let Statement::If { condition, .. } = statement {
            let is_constant = matches!(program.op(*condition), Op::Constant(_));
            branches[usize::from(!is_constant)] += 1;
        }
    });
    branches
}

#[test]
fn branches_on_constants_are_taken() {
    let part = Part {
        path: "kernel".into(),
        text: KERNEL.into(),
    };
    let trees = trees(&[part]).expect("it is exact");
    // Those on other values are that on `x` and the loop's condition.
    assert_eq!(branches(&trees.raw), [9, 2]);
    let [constant, _] = branches(&trees.tidied);
    assert_eq!(constant, 0);
    for program in [&trees.raw, &trees.tidied] {
        let mut buffers = [(0..64).collect::<Vec<u32>>()];
        let mut memory = Memory {
            buffers: &mut buffers,
            strides: &trees.strides,
        };
        for lane in 0..64 {
            run_invocation(program, &mut memory, 0, lane, true).expect("it ends");
        }
        let expected: Vec<u32> = (0..64)
            .map(|x| x + if x > 5 { 1 } else { 8 } + 3 * 16 + 32 + 200)
            .collect();
        assert_eq!(buffers[0], expected);
    }
}
