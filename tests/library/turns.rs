//! Software drivers leave loops silently after a total number of iterations, and dispatches are cut accordingly: no
//! kernel's loops may iterate more often than its compiler says. An interpreter counts them in real worlds.

use oneiro::acting::Behaviours;
use oneiro::batch::{Batch, LANES, Rollout, WorldKind, Worlds};
use oneiro::foraging::{Foraging, Light};
use oneiro::random::{Key, pcg4d};
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::swarm::{Lamp, Order, Swarm};
use oneiro::world::{Collision, Controller, World, WorldSpec};
use oneiro_shader_compiler::interpret::{Memory, run_invocation};
use oneiro_shader_compiler::{Part, Trees, trees};
use oneiro_shaders::{Kernel, episode};

fn tree(kernel: &Kernel) -> Trees {
    let part = Part {
        path: kernel.name.into(),
        text: kernel.wgsl.into(),
    };
    trees(&[part]).expect("it was compiled before")
}

/// Greatest number of iterations among a batch's rollouts in each of its first cycles.
fn counted(batch: &Batch, cycles: u32) -> Vec<u64> {
    let trees = tree(batch.kernel());
    let part = batch.all();
    let words = |bytes: &[u8]| bytemuck::pod_collect_to_vec::<u8, u32>(bytes);
    let mut buffers: Vec<Vec<u32>> = trees
        .buffers
        .iter()
        .map(|name| match name.as_str() {
            "worlds" => words(bytemuck::cast_slice(part.worlds())),
            "shapes" => words(bytemuck::cast_slice(part.shapes())),
            "tables" => part.tables().as_flattened().to_vec(),
            "groups" => words(bytemuck::cast_slice(part.group_table())),
            "inputs" => part.inputs().to_vec(),
            "state" => vec![0; part.slots() * batch.state_words()],
            "fitness" => vec![0; part.slots()],
            "trace" => vec![0; part.slots() * batch.record_words()],
            _ => Vec::new(),
        })
        .collect();
    let cycle = |step| {
        let dispatch = episode::Dispatch {
            step_begin: step,
            step_end: step + 1,
            trace_every: 1,
            trace_records: 1,
            first_input: part.first_input(),
            trace_begin: step,
            state_words: batch.state_words() as u32,
            record_words: batch.record_words() as u32,
        };
        let uniform = trees.buffers.iter().position(|name| name == "dispatch").unwrap();
        buffers[uniform] = words(bytemuck::bytes_of(&dispatch));
        let mut memory = Memory {
            buffers: &mut buffers,
            strides: &trees.strides,
        };
        let mut most = 0;
        for (group, own) in (0..).zip(part.group_table()) {
            for lane in 0..own.rollouts {
                let turns = run_invocation(&trees.raw, &mut memory, group, lane, true);
                most = most.max(turns.unwrap_or_else(|trap| panic!("cycle {step}, lane {lane}: {trap}")));
            }
        }
        most
    };
    (0..cycles).map(cycle).collect()
}

/// Counts iterations in a few rollouts in each world.
fn hold<W: WorldKind>(name: &str, worlds: &[W], genes: impl Fn(usize, usize) -> Vec<f32>) {
    for (index, world) in worlds.iter().enumerate() {
        let genomes: Vec<Vec<f32>> = (0..2).map(|rollout| genes(rollout, world.genes())).collect();
        let rollout = |(rollout, genes)| Rollout {
            world: 0,
            genes,
            key: Key::rollout(7, 0, rollout, index as u64),
        };
        let rollouts: Vec<_> = (0..).zip(genomes.iter().map(Vec::as_slice)).map(rollout).collect();
        let batch = Worlds::new(std::slice::from_ref(&world))
            .unwrap()
            .batch(&rollouts, None)
            .unwrap();
        assert!(batch.all().slots() == LANES);
        let (begin, cycle) = (u64::from(batch.all().begin_loops()), u64::from(batch.all().loops()));
        let counted = counted(&batch, 12.min(batch.cycles().end));
        let most = *counted[1..].iter().max().unwrap();
        println!(
            "{name} {index}: begins {} of {}, then {most} of {cycle}",
            counted[0],
            begin + cycle
        );
        assert!(
            counted[0] <= begin + cycle,
            "{name} {index}: {} in the first cycle",
            counted[0]
        );
        // The last check of the loop over cycles counts as part of the beginning.
        assert!(most <= cycle + 1, "{name} {index}: {most} in a cycle");
        // Every loop that always runs is counted.
        assert!(most > 1, "{name} {index}");
    }
}

fn gene(rollout: usize, index: usize) -> f32 {
    pcg4d([rollout as u32, index as u32, 7, 7])[0] as f32 / 2.0_f32.powi(32)
}

#[test]
fn lives_of_single_robots() {
    for controller in [
        Controller::Perceptron,
        Controller::Hidden { units: 5 },
        Controller::Recurrent,
    ] {
        let world = |change: &dyn Fn(&mut WorldSpec)| {
            let mut spec = WorldSpec {
                controller: controller.clone(),
                ..WorldSpec::miglino1995()
            };
            change(&mut spec);
            World::new(spec).unwrap()
        };
        let drawn = |severity| {
            let surrogate = Surrogate::drawn(1, Differences::all(severity)).into();
            world(&|spec| spec.surrogate = Some(std::sync::Arc::clone(&surrogate)))
        };
        let genes = |rollout, count| (0..count).map(|index| 10.0 * gene(rollout, index) - 5.0).collect();
        let sampled = [
            world(&|_| ()),
            world(&|spec| (spec.noise.walk_range, spec.noise.walk_step) = (30.0, 1.5)),
            world(&|spec| spec.robot.collision = Collision::Slide),
        ];
        hold("sampled", &sampled, genes);
        hold("surrogate", &[drawn(0.0), drawn(0.5), drawn(1.0)], genes);
    }
}

#[test]
fn foragers() {
    let foragers = [Light::OverNest, Light::Nowhere].map(Foraging::odowd2014);
    hold("forager", &foragers, |rollout, count| {
        (0..count).map(|index| gene(rollout, index)).collect()
    });
}

#[test]
fn behaviours() {
    let foraging = Foraging::odowd2014(Light::Nowhere);
    hold("acting", &[Behaviours { foraging, cycles: 50 }], |rollout, count| {
        (0..count).map(|index| gene(rollout, index)).collect()
    });
}

#[test]
fn swarms() {
    for (robots, radius) in [(1, 600.0), (10, 600.0), (12, 200.0), (33, 1200.0)] {
        let mut swarm = Swarm::odowd2014(robots);
        swarm.forager.arena_radius = radius;
        hold("swarm", &[swarm], |rollout, _| {
            let orders: Vec<_> = (0..robots as usize)
                .map(|robot| Order::always([gene(rollout, robot), gene(rollout, robot + 1)]))
                .collect();
            swarm.inputs(&Lamp::fixed(Light::OverNest), &orders)
        });
    }
}
