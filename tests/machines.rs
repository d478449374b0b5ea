//! What `tests/aarch64.sh` compares between processors: one line of digests of lives and of the compiler's corpus.
//! Here, that it is the same for every lane code of this one.

use std::sync::Arc;

use oneiro::batch::{Batch, Rollout, TraceRequest, Worlds};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::foraging::{Foraging, Light};
use oneiro::random::{Key, pcg4d};
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::swarm::{Lamp, Order, Swarm};
use oneiro::world::{Controller, Noise, World, WorldSpec};
use oneiro_shader_corpus::CASES;

/// FNV-1a over words.
fn digest(words: impl IntoIterator<Item = u32>) -> u64 {
    let mix = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    words
        .into_iter()
        .flat_map(u32::to_le_bytes)
        .fold(0xcbf2_9ce4_8422_2325, mix)
}

/// 40 lives of 100 cycles in each of three noises.
fn sampled(controller: Controller) -> Batch {
    let motor = Noise {
        motor: 0.1,
        ..Noise::CONSERVATIVE
    };
    let worlds = [Noise::NONE, Noise::SENSOR, motor].map(|noise| {
        let spec = WorldSpec {
            cycles: 100,
            noise,
            controller,
            ..WorldSpec::miglino1995()
        };
        World::new(spec).expect("a valid world")
    });
    batch(&Worlds::new(&worlds).expect("valid worlds"), |word| {
        f32::from(word) / 6553.6 - 5.0
    })
}

/// The same of surrogates of three severities.
fn surrogates() -> Batch {
    let worlds = [0.0, 1.0, 1.75].map(|severity| {
        let spec = WorldSpec {
            cycles: 100,
            surrogate: Some(Arc::new(Surrogate::drawn(1, Differences::all(severity)))),
            ..WorldSpec::miglino1995()
        };
        World::new(spec).expect("a valid world")
    });
    batch(&Worlds::new(&worlds).expect("valid worlds"), |word| {
        f32::from(word) / 6553.6 - 5.0
    })
}

/// The same of foragers in three scenarios.
fn foragers() -> Batch {
    let foragers = [Light::OverNest, Light::Nowhere, Light::OppositeNest].map(|light| Foraging {
        cycles: 300,
        ..Foraging::odowd2014(light)
    });
    batch(&Worlds::new(&foragers).expect("valid worlds"), |word| {
        f32::from(word) / 65_536.0
    })
}

/// Twenty worlds of ten robots that meet.
fn swarms() -> Batch {
    let ten = Swarm::odowd2014(10);
    let swarm = Swarm {
        forager: Foraging {
            cycles: 200,
            ..ten.forager
        },
        ..ten
    };
    let inputs: Vec<Vec<f32>> = (0..20)
        .map(|world| {
            let order = |robot| {
                Order::always(
                    pcg4d([world, robot, 0, 0]).map(|word| (word % 100) as f32 / 100.0)[..2]
                        .try_into()
                        .expect("two genes"),
                )
            };
            swarm.inputs(&Lamp::fixed(Light::OverNest), &(0..10).map(order).collect::<Vec<_>>())
        })
        .collect();
    let rollouts: Vec<_> = inputs
        .iter()
        .enumerate()
        .map(|(index, genes)| Rollout {
            world: 0,
            genes,
            key: Key::rollout(3, 0, index as u64, 0),
        })
        .collect();
    Worlds::new(&[swarm])
        .and_then(|worlds| worlds.batch(&rollouts, Some(TraceRequest { every: 1 })))
        .expect("a valid batch")
}

/// 120 lives shared out over the worlds; `gene` makes a gene of 16 random bits.
fn batch(worlds: &Worlds, gene: impl Fn(u16) -> f32) -> Batch {
    let drawn = |rollout, index| gene(pcg4d([rollout, index, 0, 0])[3] as u16);
    let genomes: Vec<Vec<f32>> = (0..120)
        .map(|rollout| {
            (0..worlds.genes()[0] as u32)
                .map(|index| drawn(rollout, index))
                .collect()
        })
        .collect();
    let rollouts: Vec<_> = genomes
        .iter()
        .enumerate()
        .map(|(index, genes)| Rollout {
            world: index % worlds.genes().len(),
            genes,
            key: Key::rollout(3, 0, index as u64, 0),
        })
        .collect();
    worlds
        .batch(&rollouts, Some(TraceRequest { every: 1 }))
        .expect("a valid batch")
}

fn lives(variant: &str, batch: &Batch) -> u64 {
    let cpu = Cpu::new(Some(1)).and_then(|cpu| cpu.with_variant(variant));
    let outcome = cpu
        .expect("it is available")
        .evaluate(batch, &Control::new())
        .expect("an evaluation");
    let trace = outcome.traces.concat();
    let fitness = outcome.fitness.iter().map(|fitness| fitness.to_bits());
    let logs = outcome.logs.concat();
    digest(fitness.chain(bytemuck::cast_slice(&trace).iter().copied()).chain(logs))
}

#[test]
fn every_lane_code_has_the_same_digest() {
    let mut digests = Vec::new();
    let batches = [
        sampled(Controller::Perceptron),
        sampled(Controller::Hidden { units: 3 }),
        sampled(Controller::Recurrent),
        surrogates(),
        foragers(),
        swarms(),
    ];
    for batch in &batches {
        let all: Vec<_> = Cpu::variants().into_iter().map(|name| lives(name, batch)).collect();
        assert!(
            all.len() > 1 && all.iter().all(|digest| *digest == all[0]),
            "{}: {all:x?}",
            batch.kernel().name
        );
        assert!(!digests.contains(&all[0]), "{}: as another's", batch.kernel().name);
        digests.push(all[0]);
    }
    let expected = CASES.iter().flat_map(|case| case.after.concat());
    digests.push(digest(expected));
    println!("digests {digests:016x?}");
}
