//! What `tests/aarch64.sh` compares between processors: one line of digests of lives and of the compiler's corpus.
//! Here, that it is the same for every lane code of this one.

use oneiro::batch::{Batch, Rollout, TraceRequest};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::{Key, pcg4d};
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
fn batch(controller: Controller) -> Batch {
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
    let gene = |rollout, gene| f32::from(pcg4d([rollout, gene, 0, 0])[3] as u16) / 6553.6 - 5.0;
    let genomes: Vec<Vec<f32>> = (0..120)
        .map(|rollout| {
            (0..worlds[0].genes() as u32)
                .map(|index| gene(rollout, index))
                .collect()
        })
        .collect();
    let rollouts: Vec<_> = genomes
        .iter()
        .enumerate()
        .map(|(index, genes)| Rollout {
            world: index % worlds.len(),
            genes,
            key: Key::rollout(3, 0, index as u64, 0),
        })
        .collect();
    Batch::new(&worlds, &rollouts, Some(TraceRequest { every: 1 })).expect("a valid batch")
}

fn lives(variant: &str, controller: Controller) -> u64 {
    let cpu = Cpu::new(Some(1)).and_then(|cpu| cpu.with_variant(variant));
    let outcome = cpu
        .expect("it is available")
        .evaluate(&batch(controller), &Control::new())
        .expect("an evaluation");
    let trace = outcome.traces.concat();
    let fitness = outcome.fitness.iter().map(|fitness| fitness.to_bits());
    digest(fitness.chain(bytemuck::cast_slice(&trace).iter().copied()))
}

#[test]
fn every_lane_code_has_the_same_digest() {
    let mut digests = Vec::new();
    for controller in [
        Controller::Perceptron,
        Controller::Hidden { units: 3 },
        Controller::Recurrent,
    ] {
        let all: Vec<_> = Cpu::variants()
            .into_iter()
            .map(|name| lives(name, controller))
            .collect();
        assert!(
            all.len() > 1 && all.iter().all(|digest| *digest == all[0]),
            "{controller:?}: {all:x?}"
        );
        digests.push(all[0]);
    }
    assert!(digests[0] != digests[1] && digests[1] != digests[2], "{digests:x?}");
    let expected = CASES.iter().flat_map(|case| case.after.concat());
    digests.push(digest(expected));
    println!("digests {digests:016x?}");
}
