//! Random kernels in the interpreter leave the same bits one invocation at a time, before and after tidying, and with many
//! lanes at once under masks. Deliberate mistakes are noticed.

use std::time::Duration;

use oneiro_shader_compiler::interpret::{Fault, Memory, Trap, run_invocation, run_lanes};
use oneiro_shader_compiler::{Part, Trees, generate, trees};

#[path = "../../../tests/seeds/mod.rs"]
mod seeds;
use seeds::{Outcome, Plan, unless_refused};

/// Number of invocations to run.
const LANES: u32 = 16;
const WORKGROUP: u32 = 1;
const PLAN: Plan = Plan {
    kernels: 4000,
    least: 202,
    patience: Duration::from_secs(15),
    long: 60,
};

fn text(seed: u64) -> String {
    generate::kernel(seed, 20 + (seed % 80) as u32)
}

/// Returns a generated kernel's program, or `None` if it is refused as expected.
fn program(seed: u64) -> Option<Trees> {
    let part = |path: &str, text: &str| Part {
        path: path.into(),
        text: text.into(),
    };
    let text = text(seed);
    let program = trees(&[part("prelude", generate::PRELUDE), part("kernel", &text)]);
    unless_refused(seed, &text, program)
}

fn buffers(seed: u64) -> Vec<Vec<u32>> {
    generate::buffers(seed, WORKGROUP + 1)
}

/// Buffers after the raw program has run, one invocation at a time: the right result.
fn meaning(trees: &Trees, seed: u64) -> Result<Vec<Vec<u32>>, Trap> {
    let mut buffers = buffers(seed);
    let mut memory = Memory {
        buffers: &mut buffers,
        strides: &trees.strides,
    };
    for lane in 0..LANES {
        run_invocation(&trees.raw, &mut memory, WORKGROUP, lane, true)?;
    }
    Ok(buffers)
}

/// Buffers after the tidied program has run, one invocation at a time.
fn tidied(trees: &Trees, seed: u64) -> Result<Vec<Vec<u32>>, Trap> {
    let mut buffers = buffers(seed);
    let mut memory = Memory {
        buffers: &mut buffers,
        strides: &trees.strides,
    };
    for lane in 0..LANES {
        run_invocation(&trees.tidied, &mut memory, WORKGROUP, lane, false)?;
    }
    Ok(buffers)
}

/// Buffers after the tidied program has run under masks.
fn lanes<const N: usize>(trees: &Trees, seed: u64, fault: Option<Fault>) -> Result<Vec<Vec<u32>>, Trap> {
    let mut buffers = buffers(seed);
    let mut memory = Memory {
        buffers: &mut buffers,
        strides: &trees.strides,
    };
    for first in (0..LANES).step_by(N) {
        run_lanes::<N>(&trees.tidied, &trees.shapes, &mut memory, WORKGROUP, first, fault)?;
    }
    Ok(buffers)
}

fn compare(seed: u64) -> Outcome {
    let Some(trees) = program(seed) else {
        return Outcome::Refused;
    };
    let expected = match meaning(&trees, seed) {
        Ok(expected) => expected,
        Err(Trap::Endless) => return Outcome::Endless,
        Err(trap) => panic!("seed {seed}: {trap}\n{}", text(seed)),
    };
    let same = |found: Result<Vec<Vec<u32>>, Trap>, how: &str| {
        assert!(
            found.as_ref() == Ok(&expected),
            "seed {seed}: {how} differ\n{}",
            text(seed)
        );
    };
    same(tidied(&trees, seed), "the tidied program's buffers");
    same(lanes::<1>(&trees, seed, None), "1 lane's buffers");
    same(lanes::<4>(&trees, seed, None), "4 lanes' buffers");
    same(lanes::<16>(&trees, seed, None), "16 lanes' buffers");
    Outcome::Same
}

#[test]
fn lanes_do_what_the_program_means() {
    PLAN.run(compare);
}

/// Number of kernels in which a mistake is noticed.
fn seen(fault: Fault, kernels: u64) -> u64 {
    let shows = |seed: &u64| {
        let Some(trees) = program(*seed) else { return false };
        let Ok(expected) = meaning(&trees, *seed) else {
            return false;
        };
        lanes::<16>(&trees, *seed, Some(fault)) != Ok(expected)
    };
    (1..=kernels).filter(shows).count() as u64
}

#[test]
fn mistakes_are_seen() {
    for fault in [
        Fault::NothingDiverges,
        Fault::WritesUnmasked,
        Fault::StoresUnmasked,
        Fault::ExitsStayInOuterMasks,
        Fault::ExitsStayInInnerMasks,
        Fault::LeftBlocksForgotten,
    ] {
        let seen = seen(fault, 40);
        eprintln!("{fault:?} is seen in {seen} of 40 kernels");
        assert!(seen > 0, "{fault:?} is not seen");
    }
}
