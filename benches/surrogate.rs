//! How fast the surrogate's lane code is: `cargo bench --bench surrogate`. Severities between 0 and 1 and above 1 mix
//! both pictures of what the sensors see, and so take both their times.

use std::sync::Arc;
use std::time::Instant;

use oneiro::batch::{Batch, Rollout};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::{Key, pcg4d};
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::world::{World, WorldSpec};

/// Rollouts of a turn.
const ROLLOUTS: u64 = 2000;
/// Turns of each lane code.
const TURNS: usize = 5;

fn main() {
    println!("severity  lane code, 1 thread   M steps/s");
    for severity in [0.0, 1.0, 1.75] {
        let world = World::new(WorldSpec {
            surrogate: Some(Arc::new(Surrogate::drawn(1, Differences::all(severity)))),
            ..WorldSpec::miglino1995()
        })
        .expect("a valid world");
        let genomes: Vec<Vec<f32>> = (0..ROLLOUTS)
            .map(|rollout| {
                (0..world.genes() as u32)
                    .map(|gene| (pcg4d([rollout as u32, gene, 0, 0])[0] >> 8) as f32 / 1_677_721.6 - 5.0)
                    .collect()
            })
            .collect();
        let rollouts: Vec<_> = genomes
            .iter()
            .zip(0..)
            .map(|(genes, index)| Rollout {
                world: 0,
                genes,
                key: Key::rollout(1, 0, index, 0),
            })
            .collect();
        let batch = Batch::new(&[world], &rollouts, None).expect("a valid batch");
        let mut subjects: Vec<(&str, Cpu, Vec<f64>)> = Cpu::variants()
            .into_iter()
            .filter(|variant| !variant.starts_with("checked"))
            .map(|variant| {
                let cpu = Cpu::new(Some(1)).and_then(|cpu| cpu.with_variant(variant));
                (variant, cpu.expect("it is available"), Vec::new())
            })
            .collect();
        for _ in 0..TURNS {
            for (_, cpu, rates) in &mut subjects {
                let start = Instant::now();
                std::hint::black_box(cpu.evaluate(&batch, &Control::new()).expect("an evaluation"));
                rates.push(batch.steps() as f64 / start.elapsed().as_secs_f64());
            }
        }
        for (variant, _, mut rates) in subjects {
            rates.sort_by(f64::total_cmp);
            println!("{severity:8}  {variant:20} {:10.2}", rates[TURNS / 2] / 1e6);
        }
    }
}
