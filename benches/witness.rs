//! The speed of the lane code as ratios to a program written by hand (the witness): `cargo bench --bench witness`.
//!
//! The machine may be shared and its speed may drift, so the subjects take turns, and medians are compared. The
//! benchmark fails if AVX-512 is too slow: a single function that is no longer inlined loses its instruction set and
//! most of its speed, and no other test notices.

use std::process::ExitCode;
use std::time::Instant;

use oneiro::batch::Worlds;
use oneiro::world::{World, WorldSpec};

mod subjects;
use subjects::{Subject, batch, genomes, key, median, weight};

#[path = "../tests/witness/mod.rs"]
mod witness;

/// Rollouts per turn of the lane code, and of the witness.
const ROLLOUTS: usize = 10_000;
const WITNESSED: usize = 400;
/// Turns of each subject.
const TURNS: usize = 7;
/// Least accepted ratio of AVX-512 to the witness on one thread: half of the target in docs/measurements.md, since this
/// is a guard, not the measurement.
const CLIFF: f64 = 2.5;

fn main() -> ExitCode {
    let mut fast = true;
    println!("condition     subject             M steps/s   x witness");
    for (name, spec) in conditions() {
        let genomes = genomes(ROLLOUTS, 18, weight);
        let world = World::new(spec.clone()).expect("a valid world");
        let batch = batch(&Worlds::new(&[world]).expect("valid worlds"), &genomes);
        let mut subjects = Subject::all(&[1, 2]);
        let mut witness = Vec::new();
        for _ in 0..TURNS {
            let start = Instant::now();
            let setting = witness::Setting::new(&spec);
            for (index, genes) in genomes.iter().take(WITNESSED).enumerate() {
                let mut life = witness::Life::new(&setting, genes, key(index));
                for step in 0..spec.cycles {
                    life.cycle(step);
                }
                std::hint::black_box((life.pose(), life.fitness));
            }
            witness.push((WITNESSED * spec.cycles as usize) as f64 / start.elapsed().as_secs_f64());
            for subject in &mut subjects {
                subject.take_turn(&batch);
            }
        }
        let base = median(&mut witness);
        println!("{name:12}  {:18} {:10.1}", "witness, by hand", base / 1e6);
        for (subject, rate) in subjects.into_iter().map(Subject::result) {
            println!("{name:12}  {subject:18} {:10.1} {:11.2}", rate / 1e6, rate / base);
            fast &= !subject.starts_with("native512x64, 1") || rate > CLIFF * base;
        }
    }
    if fast { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The three noise conditions of Miglino et al. 1995.
fn conditions() -> [(&'static str, WorldSpec); 3] {
    let none = WorldSpec::miglino1995();
    let (mut sensor, mut conservative) = (none.clone(), none.clone());
    sensor.noise.sensor = (0.0, 0.4);
    (conservative.noise.walk_range, conservative.noise.walk_step) = (30.0, 1.5);
    [("none", none), ("sensor", sensor), ("conservative", conservative)]
}
