//! The same bits everywhere: the life kernel on every instruction set and through the Vulkan driver, compared with one
//! another and with a witness written by hand.

use std::sync::Arc;

use oneiro::batch::{Batch, Outcome, Rollout, TraceRequest};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::{Key, pcg4d};
use oneiro::tables::SensorTables;
use oneiro::world::{Drawn, Noise, World, WorldSpec};

use crate::lives::choices::{collisions, specs, varied, with_blocks};
use crate::skips::skipped;
use crate::witness;

/// Genes uniform in -5..5, multiples of 2^-20.
fn genes(rollout: usize, count: usize) -> Vec<f32> {
    (0..count as u32)
        .map(|gene| {
            let [word, ..] = pcg4d([rollout as u32, gene, 7, 7]);
            (f32::from(word as u16) / 65_536.0 - 0.5) * 10.0
        })
        .collect()
}

/// Batches are traced so that poses and readings are compared too: a fitness alone hides differences that its steps
/// round away.
fn batch(spec: &WorldSpec, rollouts: usize, traced: bool) -> Batch {
    let world = World::new(spec.clone()).expect("a valid world");
    let genomes: Vec<_> = (0..rollouts).map(|rollout| genes(rollout, world.genes())).collect();
    let rollouts: Vec<_> = genomes
        .iter()
        .enumerate()
        .map(|(index, genes)| Rollout {
            world: 0,
            genes,
            key: Key::rollout(7, 0, index as u64, 0),
        })
        .collect();
    Batch::new(&[world], &rollouts, traced.then_some(TraceRequest { every: 1 })).expect("a valid batch")
}

fn evaluate(evaluator: &mut dyn Evaluator, spec: &WorldSpec, rollouts: usize, traced: bool) -> Outcome {
    evaluator
        .evaluate(&batch(spec, rollouts, traced), &Control::new())
        .expect("an evaluation")
}

/// Rollouts whose bits differ.
#[cfg(feature = "gpu")]
fn differing(a: &[f32], b: &[f32]) -> Vec<usize> {
    assert_eq!(a.len(), b.len());
    (0..a.len())
        .filter(|&index| a[index].to_bits() != b[index].to_bits())
        .collect()
}

/// A life as the witness has it: what a trace holds of each cycle, and the fitness.
struct Witnessed {
    cycles: Vec<Vec<f32>>,
    fitness: f32,
}

/// The witness's lives of the first rollouts.
fn witnessed(spec: &WorldSpec, rollouts: usize) -> Vec<Witnessed> {
    let setting = witness::Setting::new(spec);
    let lived = |rollout: usize| {
        let genes = genes(rollout, spec.controller.layout().genes());
        let mut life = witness::Life::new(&setting, &genes, Key::rollout(7, 0, rollout as u64, 0));
        let cycle = |cycle| {
            let pose = life.pose();
            let (seen, readings) = life.cycle(cycle);
            [&pose[..], &seen, readings.as_flattened(), &[life.fitness]].concat()
        };
        let cycles = (0..spec.cycles).map(cycle).collect();
        let fitness = life.fitness;
        Witnessed { cycles, fitness }
    };
    (0..rollouts).map(lived).collect()
}

/// First rollout and cycle in which a traced life differs from the witness's.
fn first_difference(outcome: &Outcome, lives: &[Witnessed]) -> Option<(usize, usize)> {
    assert_eq!(outcome.traces.len(), lives.len());
    for (rollout, (trace, life)) in outcome.traces.iter().zip(lives).enumerate() {
        assert_eq!(trace.len(), life.cycles.len());
        for (cycle, ((record, details), expected)) in trace.lines().zip(&life.cycles).enumerate() {
            let place = [record.x, record.y, record.heading, record.seen_x, record.seen_y];
            let readings: Vec<f32> = details.iter().map(|word| f32::from_bits(*word)).collect();
            let found = [&place[..], &readings, &[record.fitness]].concat();
            // Records hold zero with its one sign.
            let same = |(expected, found): (&f32, &f32)| (expected + 0.0).to_bits() == found.to_bits();
            if !expected.iter().zip(&found).all(same) {
                return Some((rollout, cycle));
            }
        }
        assert_eq!(life.fitness.to_bits(), outcome.fitness[rollout].to_bits());
    }
    None
}

#[test]
fn every_instruction_set_agrees_with_the_witness() {
    for (name, spec) in specs().into_iter().chain(collisions()).chain(varied()) {
        let lives = witnessed(&spec, 100);
        for variant in Cpu::variants() {
            let mut cpu = Cpu::new(None)
                .and_then(|cpu| cpu.with_variant(variant))
                .expect("it is available");
            let found = first_difference(&evaluate(&mut cpu, &spec, 100, true), &lives);
            assert_eq!(
                found, None,
                "{name}: {variant} differs from the witness in this rollout and cycle"
            );
        }
    }
}

/// The test above can fail: a motion longer by one unit in the last place is detected.
#[test]
fn one_constant_changed_by_one_ulp_is_seen() {
    let spec = WorldSpec::miglino1995();
    let mut other = spec.clone();
    let mut motors = (*other.robot.motors).clone();
    for cell in &mut motors.cells {
        cell.displacement = cell.displacement.next_up();
    }
    other.robot.motors = motors.into();
    let outcome = evaluate(&mut Cpu::new(None).expect("a CPU"), &spec, 100, true);
    assert_ne!(first_difference(&outcome, &witnessed(&other, 100)), None);
}

/// Nor is other noise than the witness's unseen.
#[test]
fn noise_changed_by_one_ulp_is_seen() {
    let (_, spec) = varied()
        .into_iter()
        .find(|(name, _)| name == "all")
        .expect("it is one of them");
    let outcome = evaluate(&mut Cpu::new(None).expect("a CPU"), &spec, 100, true);
    assert_eq!(first_difference(&outcome, &witnessed(&spec, 100)), None);
    let changes: [fn(&mut Noise); 4] = [
        |noise| noise.gain = noise.gain.map(f32::next_up),
        |noise| noise.veer = noise.veer.map(f32::next_up),
        |noise| noise.delay = noise.delay.map(f32::next_up),
        |noise| noise.drawn = Some(Drawn::Life),
    ];
    for change in changes {
        let mut other = spec.clone();
        change(&mut other.noise);
        assert_ne!(
            first_difference(&outcome, &witnessed(&other, 100)),
            None,
            "{:?}",
            other.noise
        );
    }
}

/// Recordings of a real robot, if the machine has some.
fn recorded(spec: &WorldSpec) -> Option<WorldSpec> {
    let folder = std::env::var_os("ONEIRO_RECORDINGS").map_or_else(
        || std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/khepera"),
        std::path::PathBuf::from,
    );
    if !folder.is_dir() {
        skipped("recordings", "lives by the tables of a real robot");
        return None;
    }
    let tables = SensorTables::read(&[folder.join("wall.sam"), folder.join("round.sam")]).expect("recordings");
    let mut spec = spec.clone();
    spec.robot.sensors = if spec.arena.blocks.is_empty() {
        Arc::new(tables.table)
    } else {
        with_blocks(&tables.table)
    };
    Some(spec)
}

#[test]
fn recordings_agree_with_the_witness() {
    for (name, spec) in specs().into_iter().take(4) {
        let Some(spec) = recorded(&spec) else { return };
        let outcome = evaluate(&mut Cpu::new(None).expect("a CPU"), &spec, 200, true);
        let found = first_difference(&outcome, &witnessed(&spec, 200));
        assert_eq!(
            found, None,
            "{name}: differs from the witness in this rollout and cycle"
        );
    }
}

/// Lives long enough to meet everything, on the Vulkan driver and on every instruction set.
#[cfg(feature = "gpu")]
#[test]
fn the_gpu_agrees_with_the_cpu() {
    let mut gpu = oneiro::backend::open("gpu:llvmpipe", oneiro::backend::Options::default()).expect("a Vulkan driver");
    assert!(gpu.device().exact, "{:?} is not exact", gpu.device());
    let mut cpu = Cpu::new(None).expect("a CPU");
    let lives = if std::env::var_os("ONEIRO_LONG").is_some() {
        4_000
    } else {
        1_000
    };
    for (name, spec) in specs().into_iter().chain(collisions()).chain(varied()) {
        for spec in [Some(spec.clone()), recorded(&spec)].into_iter().flatten() {
            let traced = first_difference(&evaluate(&mut *gpu, &spec, 20, true), &witnessed(&spec, 20));
            assert_eq!(
                traced, None,
                "{name}: differs from the witness in this rollout and cycle"
            );
            let there = evaluate(&mut *gpu, &spec, lives, false).fitness;
            let found = differing(&there, &evaluate(&mut cpu, &spec, lives, false).fitness);
            assert!(
                found.is_empty(),
                "{name}: {} of {lives} rollouts differ, the first is {}",
                found.len(),
                found[0]
            );
        }
    }
}
