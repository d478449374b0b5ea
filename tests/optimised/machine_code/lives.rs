//! Lives of a group in worlds to which kernels are specialised, by the processor and by machine code.

use std::sync::Arc;

use oneiro::batch::{Batch, Rollout, Worlds};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::foraging::{Foraging, Light};
use oneiro::random::{Key, pcg4d};
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::swarm::{Lamp, Order, Swarm};
use oneiro::world::{Noise, World, WorldSpec};

use super::rdna::{Code, Issued};

/// Rollouts of a group.
const GROUP: u64 = 64;
/// Cycles of which costs are counted, after those at the beginning of a life that are left out.
const COUNTED: u32 = 32;
const LEFT_OUT: u32 = 8;

/// Lives of a group in worlds to which kernels are specialised, by name.
pub(crate) fn batches() -> Vec<(&'static str, Batch)> {
    let world = |change: fn(&mut WorldSpec)| {
        let mut spec = WorldSpec::miglino1995();
        spec.cycles = LEFT_OUT + COUNTED;
        change(&mut spec);
        let world = World::new(spec).unwrap();
        let genes = world.genes();
        batch(&Worlds::new(&[world]).unwrap(), |index| genome(genes, index))
    };
    let forager = Foraging {
        cycles: LEFT_OUT + COUNTED,
        ..Foraging::odowd2014(Light::OverNest)
    };
    let foragers = Worlds::new(&[forager]).unwrap();
    let swarm = Swarm {
        forager,
        ..Swarm::odowd2014(10)
    };
    let lamp = Lamp::fixed(Light::OverNest);
    let swarms = Worlds::new(&[swarm]).unwrap();
    vec![
        ("no noise", world(|_| ())),
        ("sensor noise", world(|spec| spec.noise = Noise::SENSOR)),
        (
            "all noise",
            world(|spec| {
                spec.noise = Noise {
                    motor: 0.1,
                    ..Noise::CONSERVATIVE
                };
            }),
        ),
        (
            "surrogate",
            world(|spec| spec.surrogate = Some(Arc::new(Surrogate::drawn(1, Differences::all(0.5))))),
        ),
        (
            "over nest",
            batch(&foragers, |index| {
                genome(2, index).iter().map(|gene| gene.abs()).collect()
            }),
        ),
        (
            "ten robots",
            batch(&swarms, |index| {
                let order = |robot| {
                    let genes = genome(2, 10 * index + robot);
                    Order::always([genes[0].abs(), genes[1].abs()])
                };
                swarm.inputs(&lamp, &(0..10).map(order).collect::<Vec<_>>())
            }),
        ),
    ]
}

/// Genes from -1 to 1.
fn genome(genes: usize, index: u64) -> Vec<f32> {
    let words = (0..genes as u32)
        .step_by(4)
        .flat_map(|block| pcg4d([index as u32, block, 0, 0]));
    words
        .map(|word| (word >> 8) as f32 / 8_388_608.0 - 1.0)
        .take(genes)
        .collect()
}

fn batch(worlds: &Worlds, genes: impl Fn(u64) -> Vec<f32>) -> Batch {
    let genes: Vec<Vec<f32>> = (0..GROUP).map(genes).collect();
    let rollouts: Vec<_> = (0..)
        .zip(&genes)
        .map(|(index, genes)| Rollout {
            world: 0,
            genes,
            key: Key::rollout(0, 0, index, 0),
        })
        .collect();
    worlds.stretch(&rollouts, 0..LEFT_OUT + COUNTED, &[], None).unwrap()
}

/// Lets a group live by machine code up to some cycle. Returns its buffers and what was issued.
fn lived(batch: &Batch, code: &Code, end: u32) -> ([Vec<u32>; 9], Issued) {
    let mut buffers = oneiro::gpu::buffers(&batch.all(), end);
    let issued = code.run(&mut buffers, 0);
    (buffers, issued)
}

/// Whether machine code gives a group the processor's bits: its fitness, and all that it keeps.
pub(crate) fn is_exact(batch: &Batch, code: &Code) -> bool {
    let (buffers, _) = lived(batch, code, LEFT_OUT + COUNTED);
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let expected = cpu.evaluate_part(&batch.all(), &Control::new()).unwrap();
    let bits: Vec<u32> = expected.fitness.iter().map(|fitness| fitness.to_bits()).collect();
    buffers[7] == bits && buffers[6] == expected.states
}

/// What a cycle of a group issues.
pub(crate) fn cost(batch: &Batch, code: &Code) -> String {
    let [all, first] = [LEFT_OUT + COUNTED, LEFT_OUT].map(|end| lived(batch, code, end).1);
    let a_cycle = |figure: fn(Issued) -> u64| (figure(all) - figure(first)) as f64 / f64::from(COUNTED);
    format!(
        "{:.0} issued a cycle, of them {:.0} vector, {:.0} memory, {:.0} products",
        a_cycle(Issued::all),
        a_cycle(|issued| issued.vector),
        a_cycle(|issued| issued.memory),
        a_cycle(|issued| issued.products),
    )
}
