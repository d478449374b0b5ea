//! Varied lives, for tests that compare devices.

pub(crate) mod choices;
pub(crate) mod subjects;

use oneiro::batch::{Batch, Rollout, TraceRequest};
use oneiro::random::{Key, pcg4d};
use oneiro::world::{Controller, Noise, Start, World, WorldSpec};

pub(crate) const CONTROLLERS: [Controller; 3] = [
    Controller::Perceptron,
    Controller::Hidden { units: 3 },
    Controller::Recurrent,
];

pub(crate) fn world(cycles: u32, change: impl Fn(&mut WorldSpec)) -> World {
    let mut spec = WorldSpec {
        cycles,
        ..WorldSpec::miglino1995()
    };
    change(&mut spec);
    World::new(spec).unwrap()
}

/// All kinds of noise; and a chosen start, for a life of another length.
pub(crate) fn worlds(controller: &Controller, cycles: u32, short: u32) -> Vec<World> {
    let noise = |noise| {
        world(cycles, |spec| {
            spec.noise = noise;
            spec.controller = controller.clone();
        })
    };
    vec![
        noise(Noise::NONE),
        noise(Noise::SENSOR),
        noise(Noise {
            motor: 0.1,
            ..Noise::CONSERVATIVE
        }),
        world(short, |spec| {
            spec.controller = controller.clone();
            spec.start = Start::At {
                x: 100.0,
                y: 80.0,
                heading: 0.25,
            };
        }),
    ]
}

/// Distinct genes from -5 to 5.
pub(crate) fn genes(individual: usize, count: usize) -> Vec<f32> {
    let gene = |gene| pcg4d([individual as u32, gene, 0, 0])[3] as f32 / 2.0_f32.powi(32) * 10.0 - 5.0;
    (0..count as u32).map(gene).collect()
}

/// Rollouts that take turns in all worlds, with a record every `every` cycles.
pub(crate) fn batch(worlds: &[World], rollouts: usize, every: Option<u32>) -> Batch {
    batch_with(worlds, rollouts, every, |_, _| {})
}

/// The same; `change` may modify each rollout's genes.
pub(crate) fn batch_with(
    worlds: &[World],
    rollouts: usize,
    every: Option<u32>,
    change: impl Fn(usize, &mut [f32]),
) -> Batch {
    let genes: Vec<Vec<f32>> = (0..rollouts)
        .map(|index| {
            let mut genes = genes(index, worlds[index % worlds.len()].genes());
            change(index, &mut genes);
            genes
        })
        .collect();
    let rollout = |(index, genes)| Rollout {
        world: index % worlds.len(),
        genes,
        key: Key::rollout(1, 0, index as u64, 0),
    };
    let rollouts: Vec<Rollout<'_>> = genes.iter().map(Vec::as_slice).enumerate().map(rollout).collect();
    Batch::new(worlds, &rollouts, every.map(|every| TraceRequest { every })).unwrap()
}
