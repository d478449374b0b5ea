//! How fast the lane code is, as ratios to the witness written by hand: `cargo bench --bench witness`.
//!
//! The machine may be shared and its speed may drift, so the subjects take turns and medians are compared. It
//! fails if the order of things has turned: one function that is no longer inlined loses its instruction set and
//! most of its speed, and nothing else would say so.

use std::process::ExitCode;
use std::time::Instant;

use oneiro::batch::{Batch, Rollout};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::{Key, pcg4d};
use oneiro::world::{World, WorldSpec};

#[path = "../tests/witness/mod.rs"]
mod witness;

/// Rollouts of a turn of the lane code, and of the witness.
const ROLLOUTS: usize = 10_000;
const WITNESSED: usize = 400;
/// Turns of each subject.
const TURNS: usize = 7;
/// What AVX-512 must reach on one thread, in turns of the witness; half of what was asked, since this is a guard
/// and not the measurement.
const CLIFF: f64 = 2.5;

fn genes(rollout: usize) -> Vec<f32> {
    (0..18)
        .map(|gene| (pcg4d([rollout as u32, gene, 0, 0])[0] >> 8) as f32 / 1_677_721.6 - 5.0)
        .collect()
}

fn main() -> ExitCode {
    let mut fast = true;
    println!("condition     subject             M steps/s   x witness");
    for (name, spec) in conditions() {
        let genomes: Vec<_> = (0..ROLLOUTS).map(genes).collect();
        let key = |index: usize| Key::rollout(1, 0, index as u64, 0);
        let rollouts: Vec<_> = genomes
            .iter()
            .enumerate()
            .map(|(index, genes)| Rollout {
                world: 0,
                genes,
                key: key(index),
            })
            .collect();
        let world = World::new(spec.clone()).expect("a valid world");
        let batch = Batch::new(&[world], &rollouts, None).expect("a valid batch");

        let mut subjects = Vec::new();
        for variant in Cpu::variants()
            .into_iter()
            .filter(|variant| !variant.starts_with("checked"))
        {
            for threads in [1, 2] {
                let cpu = Cpu::new(Some(threads))
                    .and_then(|cpu| cpu.with_variant(variant))
                    .expect("it is available");
                subjects.push((format!("{variant}, {threads} thread"), cpu, Vec::new()));
            }
        }
        let mut witness = Vec::new();
        for _ in 0..TURNS {
            let start = Instant::now();
            let setting = witness::Setting::new(&spec);
            for (index, genes) in genomes.iter().take(WITNESSED).enumerate() {
                let mut life = witness::Life::new(&setting, genes, key(index));
                (0..spec.cycles).for_each(|step| life.cycle(step));
                std::hint::black_box((life.pose(), life.fitness));
            }
            witness.push((WITNESSED * spec.cycles as usize) as f64 / start.elapsed().as_secs_f64());
            for (_, cpu, rates) in &mut subjects {
                let start = Instant::now();
                std::hint::black_box(cpu.evaluate(&batch, &Control::new()).expect("an evaluation"));
                rates.push(batch.steps() as f64 / start.elapsed().as_secs_f64());
            }
        }
        let base = median(&mut witness);
        println!("{name:12}  {:18} {:10.1}", "witness, by hand", base / 1e6);
        for (subject, _, mut rates) in subjects {
            let rate = median(&mut rates);
            println!("{name:12}  {subject:18} {:10.1} {:11.2}", rate / 1e6, rate / base);
            fast &= !subject.starts_with("avx512x64, 1") || rate > CLIFF * base;
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

fn median(rates: &mut [f64]) -> f64 {
    rates.sort_by(f64::total_cmp);
    rates[rates.len() / 2]
}
