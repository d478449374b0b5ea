//! Random kernels as machine code: at every number of lanes, the bits of the interpreter, which knows neither masks nor
//! vectors. How many of them ran is counted.

use std::time::{Duration, Instant};

use oneiro_shader_compiler::generate;
use oneiro_shader_compiler::interpret::Trap;
use oneiro_shader_native::LANES;

mod common;
use common::{Extent, TURNS, meaning, native, program, run};

/// Kernels that are tried, if there is time; how many are tried in any case; and how much more `tests/long.sh` does.
const KERNELS: u64 = 600;
const LEAST: u64 = 100;
const PATIENCE: Duration = Duration::from_secs(20);
const LONG: u32 = 30;

/// Two calls of the most lanes, in a workgroup that is not the first.
const EXTENT: Extent = Extent {
    workgroups: 1..2,
    lanes: 32,
};

/// What became of a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    Same,
    Refused,
    Endless,
}

fn compare(seed: u64) -> Outcome {
    let text = generate::kernel(seed, 20 + (seed % 80) as u32);
    let Ok(trees) = program(&text) else {
        return Outcome::Refused;
    };
    let buffers = generate::buffers(seed, EXTENT.workgroups.end);
    let expected = match meaning(&trees, buffers.clone(), &EXTENT) {
        Ok(expected) => expected,
        Err(Trap::Endless) => return Outcome::Endless,
        Err(trap) => panic!("seed {seed}: {trap}\n{text}"),
    };
    for lanes in LANES {
        let found = run(&native(&trees, lanes), buffers.clone(), &EXTENT, TURNS);
        assert!(
            found == Ok(expected.clone()),
            "seed {seed}: {lanes} lanes differ\n{text}"
        );
    }
    Outcome::Same
}

#[test]
fn machine_code_does_what_the_program_means() {
    let start = Instant::now();
    let times = if std::env::var_os("ONEIRO_LONG").is_some() {
        LONG
    } else {
        1
    };
    let kernels = KERNELS * u64::from(times);
    let threads = std::thread::available_parallelism().map_or(1, |threads| threads.get() as u64);
    let work = |first: u64| {
        let seeds = (first..kernels).step_by(threads as usize);
        let outcomes = seeds.take_while(|seed| *seed < LEAST || start.elapsed() < PATIENCE * times);
        outcomes.map(compare).collect::<Vec<_>>()
    };
    let outcomes: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..threads).map(|first| scope.spawn(move || work(first))).collect();
        threads
            .into_iter()
            .flat_map(|thread| thread.join().expect("the message is above"))
            .collect()
    });
    let same = outcomes.iter().filter(|outcome| **outcome == Outcome::Same).count();
    eprintln!(
        "{same} of {} kernels do what they mean, in {:.1?}",
        outcomes.len(),
        start.elapsed()
    );
    assert!(
        same > outcomes.len() * 3 / 4,
        "too many kernels are refused or run too long"
    );
}
