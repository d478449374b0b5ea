//! Random kernels as machine code have the same bits at every number of lanes as in the interpreter, which knows neither
//! masks nor vectors.

use std::time::Duration;

use oneiro_shader_compiler::generate;
use oneiro_shader_compiler::interpret::Trap;

use crate::common::{Extent, TURNS, meaning, natives, program, run};
use crate::seeds::{Outcome, Plan, unless_refused};

const PLAN: Plan = Plan {
    kernels: 600,
    // An emulated processor takes a second for each.
    least: if cfg!(target_arch = "x86_64") { 60 } else { 24 },
    patience: Duration::from_secs(8),
    // A hundred thousand kernels.
    long: 167,
};

/// A call at the maximum number of lanes, in the second workgroup.
const EXTENT: Extent = Extent {
    workgroups: 1..2,
    lanes: 64,
};

fn compare(seed: u64) -> Outcome {
    let text = generate::kernel(seed, 20 + (seed % 80) as u32);
    let Some(trees) = unless_refused(seed, &text, program(&text)) else {
        return Outcome::Refused;
    };
    let buffers = generate::buffers(seed, EXTENT.workgroups.end);
    let expected = match meaning(&trees, buffers.clone(), &EXTENT) {
        Ok(expected) => expected,
        Err(Trap::Endless) => return Outcome::Endless,
        Err(trap) => panic!("seed {seed}: {trap}\n{text}"),
    };
    for native in natives(&trees) {
        let found = run(&native, buffers.clone(), &EXTENT, TURNS);
        assert!(found == Ok(expected.clone()), "seed {seed}: {native:?} differs\n{text}");
    }
    Outcome::Same
}

#[test]
fn machine_code_does_what_the_program_means() {
    PLAN.run(compare);
}
