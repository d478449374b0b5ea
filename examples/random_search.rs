//! An optimiser of one's own: evolves a Khepera that avoids obstacles with a few lines of random search.
//!
//!     cargo run --release --example random_search

use oneiro::backend::{self, Options};
use oneiro::batch::{Batch, Rollout};
use oneiro::evaluator::Control;
use oneiro::random::{Key, pcg4d};
use oneiro::world::{World, WorldSpec};

const CHILDREN: u32 = 200;
const TRIALS: u64 = 5;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let world = World::new(WorldSpec::miglino1995())?;
    let mut evaluator = backend::open("auto", Options::default())?;

    let mut best = vec![0.0; world.genes()];
    for generation in 0..50 {
        // The best so far, and children that differ from it by up to 1 in each gene.
        let mut genomes = vec![best.clone(); CHILDREN as usize];
        for (child, genome) in genomes.iter_mut().enumerate().skip(1) {
            for (at, gene) in genome.iter_mut().enumerate() {
                let word = pcg4d([generation, child as u32, at as u32, 0])[3];
                *gene += word as f32 / 2.0_f32.powi(31) - 1.0;
            }
        }

        // Each lives five times. All share the same starts.
        let mut rollouts = Vec::new();
        for genes in &genomes {
            for trial in 0..TRIALS {
                rollouts.push(Rollout {
                    world: 0,
                    genes,
                    key: Key::rollout(1, generation.into(), 0, trial),
                });
            }
        }
        let batch = Batch::new(std::slice::from_ref(&world), &rollouts, None)?;
        let outcome = evaluator.evaluate(&batch, &Control::new())?;

        // Higher fitness is better.
        let mean = |trials: &[f32]| trials.iter().sum::<f32>() / trials.len() as f32;
        let scores: Vec<f32> = outcome.fitness.chunks(TRIALS as usize).map(mean).collect();
        let winner = (0..scores.len())
            .max_by(|&a, &b| scores[a].total_cmp(&scores[b]))
            .unwrap_or(0);
        best.clone_from(&genomes[winner]);
        println!(
            "generation {generation:2}: fitness {:6.1} of {}",
            scores[winner],
            world.cycles()
        );
    }
    println!("genes: {best:.2?}");
    Ok(())
}
