//! Random kernels through the interpreter: one invocation at a time, before and after tidying, and many lanes
//! at once under masks must leave the same bits. Mistakes that are made on purpose must be seen.

use std::time::{Duration, Instant};

use oneiro_shader_compiler::interpret::{Fault, Memory, Trap, run_invocation, run_lanes};
use oneiro_shader_compiler::{Part, Trees, generate, trees};

/// Invocations of the workgroup that are run.
const LANES: u32 = 16;
const WORKGROUP: u32 = 1;

fn text(seed: u64) -> String {
    generate::kernel(seed, 100)
}

/// A generated kernel's program; none if it was refused for the one reason that the generator can't foresee.
fn program(seed: u64) -> Option<Trees> {
    let part = |path: &str, text: String| Part {
        path: path.into(),
        text,
    };
    let text = text(seed);
    match trees(&[part("prelude", generate::PRELUDE.into()), part("kernel", text.clone())]) {
        Ok(trees) => Some(trees),
        Err(refusals) => {
            for refusal in refusals {
                assert!(
                    refusal.message.contains("can't be indexed by what differs"),
                    "seed {seed}: {refusal}\n{text}"
                );
            }
            None
        }
    }
}

fn buffers(seed: u64) -> Vec<Vec<u32>> {
    generate::buffers(seed, WORKGROUP + 1)
}

/// What the program means: each invocation by itself.
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

/// What tidying left of it.
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

/// What lane code does.
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

#[test]
fn lanes_do_what_the_program_means() {
    let start = Instant::now();
    let (mut run, mut refused, mut endless) = (0, 0, 0);
    let mut seed = 0;
    while seed < 4000 && (start.elapsed() < Duration::from_secs(15) || run < 100) {
        seed += 1;
        let Some(trees) = program(seed) else {
            refused += 1;
            continue;
        };
        let expected = match meaning(&trees, seed) {
            Ok(expected) => expected,
            Err(Trap::Endless) => {
                endless += 1;
                continue;
            }
            Err(trap) => panic!("seed {seed}: {trap}\n{}", text(seed)),
        };
        let same = |found: Result<Vec<Vec<u32>>, Trap>, how: &str| {
            assert_eq!(found.as_ref(), Ok(&expected), "seed {seed}, {how}\n{}", text(seed));
        };
        same(tidied(&trees, seed), "tidied");
        same(lanes::<1>(&trees, seed, None), "1 lane");
        same(lanes::<4>(&trees, seed, None), "4 lanes");
        same(lanes::<16>(&trees, seed, None), "16 lanes");
        run += 1;
    }
    eprintln!(
        "{run} kernels run, {refused} refused, {endless} endless, in {:.1?}",
        start.elapsed()
    );
    assert!(
        run > 3 * (refused + endless),
        "{run} kernels run, {refused} refused, {endless} endless"
    );
}

/// How many of some kernels a mistake changes.
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
