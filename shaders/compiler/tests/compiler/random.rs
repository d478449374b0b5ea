//! Random kernels in the interpreter leave the same bits one invocation at a time, before and after tidying, and with many
//! lanes at once under masks. Deliberate mistakes are noticed.

use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use oneiro_shader_compiler::interpret::{Fault, Memory, Trap, run_invocation, run_lanes};
use oneiro_shader_compiler::specialise::Known;
use oneiro_shader_compiler::tree::{Statement, visit};
use oneiro_shader_compiler::{Generic, Indices, Part, Trees, generate, trees};

use crate::seeds::{Outcome, Plan, unless_refused};

/// Number of invocations to run.
const LANES: u32 = 16;
const WORKGROUP: u32 = 1;
const PLAN: Plan = Plan {
    kernels: 4000,
    least: 202,
    patience: Duration::from_secs(6),
    long: 150,
};

fn text(seed: u64) -> String {
    generate::kernel(seed, 20 + (seed % 80) as u32)
}

fn parts(seed: u64) -> [Part; 2] {
    let part = |path: &str, text: &str| Part {
        path: path.into(),
        text: text.into(),
    };
    [part("prelude", generate::PRELUDE), part("kernel", &text(seed))]
}

/// Returns a generated kernel's program, or `None` if it is refused as expected.
fn program(seed: u64) -> Option<Trees> {
    unless_refused(seed, &text(seed), trees(&parts(seed)))
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

/// Buffers after the specialised program has run, of whose constant words a share is known; and by how many statements it is shorter.
fn specialised(trees: &Trees, seed: u64, share: u32) -> (Result<Vec<Vec<u32>>, Trap>, i64) {
    let mut buffers = buffers(seed);
    let contents = buffers.clone();
    let generic = Generic::new(&parts(seed)).unwrap_or_else(|refusals| panic!("{refusals:?}"));
    let word = |buffer: u32, element: Option<u32>, offset: u32| {
        let binding = &generic.bindings[buffer as usize];
        let stride = trees.strides[buffer as usize];
        let words = &contents[buffer as usize];
        let is_array = words.len() as u32 > stride;
        if binding.kind == "ReadWrite" || (is_array && element.is_none()) {
            return None;
        }
        let element = element.unwrap_or(0).min(words.len() as u32 / stride - 1);
        let index = element * stride + offset;
        let is_known = (u64::from(index) ^ seed).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
        (is_known % 4 < u64::from(share)).then(|| words[index as usize])
    };
    let program = generic.program(&Known {
        word: &word,
        signed_zeros: true,
    });
    generic
        .spirv(&program, Indices::Clamped)
        .unwrap_or_else(|problem| panic!("seed {seed}: {problem}\n{}", text(seed)));
    let statements = |body: &[Statement]| {
        let mut count = 0;
        visit(body, &mut |_| count += 1);
        count
    };
    let shorter = statements(&trees.raw.body) - statements(&program.body);
    let mut memory = Memory {
        buffers: &mut buffers,
        strides: &trees.strides,
    };
    for lane in 0..LANES {
        if let Err(trap) = run_invocation(&program, &mut memory, WORKGROUP, lane, true) {
            return (Err(trap), shorter);
        }
    }
    (Ok(buffers), shorter)
}

#[test]
fn specialised_programs_mean_the_same() {
    let shorter = AtomicU32::new(0);
    PLAN.run(|seed| {
        let Some(trees) = program(seed) else {
            return Outcome::Refused;
        };
        let Ok(expected) = meaning(&trees, seed) else {
            return Outcome::Endless;
        };
        for share in [0, 2, 4] {
            let (found, statements) = specialised(&trees, seed, share);
            assert!(
                found.as_ref() == Ok(&expected),
                "seed {seed}: with {share} of 4 words known, {:?}\n{}",
                found.err(),
                text(seed)
            );
            shorter.fetch_add(u32::from(statements > 0), Ordering::Relaxed);
        }
        Outcome::Same
    });
    assert!(shorter.into_inner() > 100);
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
