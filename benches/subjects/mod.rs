//! Shared by the benchmarks: random lives, and the lane codes that take turns.

use std::time::Instant;

use oneiro::batch::{Batch, Rollout, Worlds};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::{Key, pcg4d};

/// Converts a random number to a weight from -5 to 5.
pub(crate) fn weight(word: u32) -> f32 {
    (word >> 8) as f32 / 1_677_721.6 - 5.0
}

/// Random genomes; `gene` converts a random number to a gene.
pub(crate) fn genomes(count: usize, genes: u32, gene: impl Fn(u32) -> f32) -> Vec<Vec<f32>> {
    let drawn = |genome: usize, index| gene(pcg4d([genome as u32, index, 0, 0])[0]);
    (0..count)
        .map(|genome| (0..genes).map(|index| drawn(genome, index)).collect())
        .collect()
}

/// Key of a genome's life.
pub(crate) fn key(genome: usize) -> Key {
    Key::rollout(1, 0, genome as u64, 0)
}

/// A life of each genome in the first world.
pub(crate) fn batch(worlds: &Worlds, genomes: &[Vec<f32>]) -> Batch {
    let life = |(index, genes)| Rollout {
        world: 0,
        genes,
        key: key(index),
    };
    let rollouts: Vec<_> = genomes.iter().map(Vec::as_slice).enumerate().map(life).collect();
    worlds.batch(&rollouts, None).expect("a valid batch")
}

/// A lane code on a number of threads.
pub(crate) struct Subject {
    name: String,
    cpu: Cpu,
    /// Steps per second in each turn.
    rates: Vec<f64>,
}

impl Subject {
    /// Each lane code meant for speed, on each of these numbers of threads.
    pub(crate) fn all(threads: &[usize]) -> Vec<Self> {
        let mut subjects = Vec::new();
        for variant in Cpu::variants() {
            if variant.starts_with("checked") {
                continue;
            }
            subjects.extend(threads.iter().map(|&threads| {
                let cpu = Cpu::new(Some(threads)).and_then(|cpu| cpu.with_variant(variant));
                Self {
                    name: format!("{variant}, {threads} thread"),
                    cpu: cpu.expect("it is available"),
                    rates: Vec::new(),
                }
            }));
        }
        subjects
    }

    pub(crate) fn take_turn(&mut self, batch: &Batch) {
        let start = Instant::now();
        std::hint::black_box(self.cpu.evaluate(batch, &Control::new()).expect("an evaluation"));
        self.rates.push(batch.steps() as f64 / start.elapsed().as_secs_f64());
    }

    /// Name and median of its turns, in steps per second.
    pub(crate) fn result(mut self) -> (String, f64) {
        (self.name, median(&mut self.rates))
    }
}

pub(crate) fn median(rates: &mut [f64]) -> f64 {
    rates.sort_by(f64::total_cmp);
    rates[rates.len() / 2]
}
