//! `oneiro check --episodes`: interprets episodes and checks each operation.

use std::collections::BTreeMap;

use oneiro::batch::{Batch, Rollout};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Error, Evaluator};
use oneiro::random::{Key, pcg4d};
use oneiro_base::console::counted;
use oneiro_base::exit::{Failure, Result};

use crate::experiment::Experiment;

/// Interprets episodes of random genomes, each up to the first operation whose result may differ between devices. Every other
/// genome is drawn from the range of initial genes, the rest from their limits.
///
/// # Errors
/// Exit 3: each of these operations, with its place, and the number of episodes in which it was the first.
pub(super) fn check(experiment: &Experiment, lives: u32) -> Result<String> {
    let world = experiment.world();
    let evolution = &experiment.settings().evolution;
    let mut cpu = Cpu::new(Some(1))?.checking();
    // For each place, the operation there, and the number of episodes in which it was the first.
    let mut found: BTreeMap<String, (String, u32)> = BTreeMap::new();
    for life in 0..lives {
        let [initial, limits] = [Some(evolution.initial), evolution.limits];
        let shared = if life % 2 == 1 { limits.or(initial) } else { initial }.unwrap_or_default();
        let ranges = world.gene_layout().ranges().into_iter().zip(0..);
        let gene = |(own, gene): (Option<[f32; 2]>, u32)| {
            let [low, high] = own.map_or(shared, |range| range.map(f64::from));
            let share = f64::from(pcg4d([life, gene, 0, 0x6c69_7665])[0]) / f64::from(u32::MAX);
            let gene = (low + (high - low) * share) as f32;
            if gene.is_normal() { gene } else { 0.0 }
        };
        let genes: Vec<f32> = ranges.map(gene).collect();
        let rollout = Rollout {
            world: 0,
            genes: &genes,
            key: Key::rollout(0, 0, life.into(), 0),
        };
        let batch = Batch::new(std::slice::from_ref(world), &[rollout], None)?;
        match cpu.evaluate(&batch, &Control::new()) {
            Err(Error::Inexact { place, what }) => found.entry(place).or_insert((what, 0)).1 += 1,
            other => drop(other?),
        }
    }
    if found.is_empty() {
        return Ok(format!(
            "{}: all numbers are exact",
            counted(lives, "episode", "episodes")
        ));
    }
    let lines = found.into_iter().map(|(place, (what, count))| {
        let lives = counted(lives, "episode", "episodes");
        format!("{place}: {what}, in {count} of {lives}; allowed: results that are 0, or normal and finite, of arguments in their range")
    });
    Err(Failure::input(lines.collect::<Vec<_>>().join("\n")))
}
