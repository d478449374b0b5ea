//! How fast the lane code of the other lives is than those that `oneiro bench` times: `cargo bench --bench lives`.
//! A surrogate's severities between 0 and 1 and above 1 mix both pictures of what the sensors see, and so take both
//! their times.

use std::sync::Arc;
use std::time::Instant;

use oneiro::batch::{Batch, Rollout, Worlds};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::foraging::{Foraging, Light};
use oneiro::random::{Key, pcg4d};
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::world::{World, WorldSpec};

/// Rollouts of a turn.
const ROLLOUTS: u64 = 2000;
/// Turns of each lane code.
const TURNS: usize = 5;

fn main() {
    println!("{:24}  lane code, 1 thread   M steps/s", "life");
    for severity in [0.0, 1.0, 1.75] {
        let world = World::new(WorldSpec {
            surrogate: Some(Arc::new(Surrogate::drawn(1, Differences::all(severity)))),
            ..WorldSpec::miglino1995()
        })
        .expect("a valid world");
        let genes = world.genes() as u32;
        let worlds = Worlds::new(&[world]).expect("valid worlds");
        let gene = |word: u32| (word >> 8) as f32 / 1_677_721.6 - 5.0;
        time(&format!("surrogate, severity {severity}"), &batch(&worlds, genes, gene));
    }
    let foragers = Worlds::of_foragers(&[Foraging::odowd2014(Light::OverNest)]).expect("valid worlds");
    let gene = |word: u32| (word % 100) as f32 / 100.0;
    time("forager", &batch(&foragers, 2, gene));
}

/// Random controllers in the first world.
fn batch(worlds: &Worlds, genes: u32, gene: impl Fn(u32) -> f32) -> Batch {
    let genome = |rollout: u64| -> Vec<f32> {
        let drawn = |index: u32| gene(pcg4d([rollout as u32, index, 0, 0])[0]);
        (0..genes).map(drawn).collect()
    };
    let genomes: Vec<Vec<f32>> = (0..ROLLOUTS).map(genome).collect();
    let rollouts: Vec<_> = genomes
        .iter()
        .zip(0..)
        .map(|(genes, index)| Rollout {
            world: 0,
            genes,
            key: Key::rollout(1, 0, index, 0),
        })
        .collect();
    worlds.batch(&rollouts, None).expect("a valid batch")
}

/// Runs a batch by each lane code in turn, some times, and prints the medians.
fn time(life: &str, batch: &Batch) {
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
            std::hint::black_box(cpu.evaluate(batch, &Control::new()).expect("an evaluation"));
            rates.push(batch.steps() as f64 / start.elapsed().as_secs_f64());
        }
    }
    for (variant, _, mut rates) in subjects {
        rates.sort_by(f64::total_cmp);
        println!("{life:24}  {variant:20} {:10.2}", rates[TURNS / 2] / 1e6);
    }
}
