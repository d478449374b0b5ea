//! The GPU's results equal the CPU's, however it cuts batches, and whatever fails. These tests need an adapter: without
//! one they fail.
#![cfg(feature = "gpu")]

use std::sync::Arc;
use std::time::{Duration, Instant};

use oneiro::backend::Specialise;
use oneiro::batch::{Batch, Rollout, TraceRequest, Worlds};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Error, Evaluator};
use oneiro::foraging::Light;
use oneiro::gpu::{Bounds, Choice, FloatControls, Gpu, Path, Recovering, Run, adapters, find};
use oneiro::probe;
use oneiro::random::Key;
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::swarm::{Lamp, Order, Swarm};
use oneiro::world::{Controller, Noise, World, WorldSpec};
use oneiro_shaders::episode::Dispatch;
use oneiro_shaders::{Kernel, PROBE_OPERATIONS};

use crate::lives::{self, CONTROLLERS, batch, batch_with};

fn gpu() -> Gpu {
    Gpu::open(&Choice::Best).expect("these tests need an adapter")
}

fn cpu() -> Cpu {
    Cpu::new(Some(2)).unwrap()
}

fn world(change: impl Fn(&mut WorldSpec)) -> World {
    lives::world(60, change)
}

fn worlds(controller: &Controller) -> Vec<World> {
    lives::worlds(controller, 60, 23)
}

/// Bits of a rollout's results: its fitness, and its slot's whole trace.
type Bits = (u32, Vec<u32>);

fn bits(evaluator: &mut dyn Evaluator, batch: &Batch) -> Vec<Bits> {
    let control = Control::new();
    let result = evaluator.evaluate_part(&batch.all(), &control).unwrap();
    assert_eq!(control.steps(), batch.steps(), "progress ends at the batch's steps");
    let words = batch.trace_words();
    let of_slot = |slot: usize| {
        let trace = &result.trace[slot * words..][..words];
        (result.fitness[slot].to_bits(), trace.to_vec())
    };
    (0..batch.rollouts())
        .map(|rollout| of_slot(batch.slot(rollout).unwrap()))
        .collect()
}

/// Rollouts whose results differ.
fn differing(a: &[Bits], b: &[Bits]) -> Vec<usize> {
    assert_eq!(a.len(), b.len());
    (0..a.len()).filter(|&rollout| a[rollout] != b[rollout]).collect()
}

const NONE: [usize; 0] = [];

#[test]
fn adapters_are_found_by_index_and_name() {
    let all = adapters();
    assert!(!all.is_empty(), "these tests need an adapter");
    for adapter in &all {
        assert!(!adapter.name().is_empty());
        assert!(adapter.limits().binding_bytes >= 1 << 27 && adapter.limits().workgroups >= 65_535);
        let found = find(&Choice::Named(adapter.index().to_string())).unwrap();
        assert_eq!((found.name(), found.backend()), (adapter.name(), adapter.backend()));
        let part = adapter.name()[..4].to_uppercase();
        assert!(
            find(&Choice::Named(part.clone()))
                .unwrap()
                .name()
                .to_uppercase()
                .contains(&part)
        );
    }
    for wrong in ["no such card", "4294967295"] {
        match find(&Choice::Named(wrong.into())) {
            Err(Error::NoDevice(message)) => {
                assert!(message.contains(wrong) && message.contains(all[0].name()), "{message}");
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn all_kernels_give_the_cpus_bits() {
    let mut gpu = gpu();
    assert!(gpu.device().exact, "{:?}", gpu.device());
    for controller in CONTROLLERS {
        let worlds = worlds(&controller);
        let batch = batch(&worlds, 300, Some(7));
        let expected = bits(&mut cpu(), &batch);
        assert!(
            expected
                .iter()
                .filter(|(fitness, _)| f32::from_bits(*fitness) > 1.0)
                .count()
                > 100,
            "lives that earn"
        );
        assert_eq!(differing(&bits(&mut gpu, &batch), &expected), NONE, "{controller:?}");

        // The comparison detects one different genome.
        let changed = batch_with(&worlds, 300, Some(7), |index, genes| {
            if index == 121 {
                genes.reverse();
            }
        });
        assert_eq!(differing(&bits(&mut gpu, &changed), &expected), [121], "{controller:?}");
    }
}

/// Steps of a batch in a second, at the best of three.
fn speed(gpu: &mut Gpu, batch: &Batch) -> f64 {
    let lasted = (0..3).map(|_| {
        let start = Instant::now();
        gpu.evaluate_part(&batch.all(), &Control::new()).unwrap();
        start.elapsed().as_secs_f64()
    });
    batch.steps() as f64 / lasted.fold(f64::INFINITY, f64::min)
}

/// Kernels that are specialised to their worlds give the generic ones' bits.
#[cfg(feature = "compose")]
#[test]
fn specialised_kernels_give_the_same_bits() {
    let mut gpu = gpu();
    gpu.set_specialise(Specialise::Always);
    let surrogate = |controller: &Controller| {
        let mut worlds = worlds(controller);
        for severity in [0.0, 0.5, 1.0] {
            worlds.push(world(|spec| {
                spec.controller = controller.clone();
                spec.surrogate = Some(Arc::new(Surrogate::drawn(1, Differences::all(severity))));
            }));
        }
        worlds
    };
    for controller in CONTROLLERS {
        let all = surrogate(&controller);
        for worlds in [&all[..4], &all[4..]] {
            for trace in [None, Some(7)] {
                let batch = batch(worlds, 300, trace);
                let expected = bits(&mut cpu(), &batch);
                let before = gpu.specialised_steps();
                assert_eq!(
                    differing(&bits(&mut gpu, &batch), &expected),
                    NONE,
                    "{controller:?} {trace:?}"
                );
                assert_eq!(gpu.specialised_steps() - before, batch.steps(), "{:?}", gpu.warnings());
            }
        }
    }
}

/// The same, many more of them.
#[cfg(feature = "compose")]
#[test]
#[ignore = "takes minutes: tests/long.sh"]
fn a_hundred_thousand_lives_are_the_same() {
    let mut gpu = gpu();
    gpu.set_specialise(Specialise::Always);
    let noise = Noise {
        motor: 0.1,
        ..Noise::CONSERVATIVE
    };
    for controller in CONTROLLERS {
        for severity in [None, Some(0.5)] {
            let world = world(|spec| {
                // A surrogate has the noise of its own sensors.
                spec.noise = if severity.is_some() { Noise::NONE } else { noise };
                spec.controller = controller.clone();
                spec.cycles = 100;
                spec.surrogate = severity.map(|all| Arc::new(Surrogate::drawn(1, Differences::all(all))));
            });
            let batch = batch(&[world], 100_000, None);
            let differ = differing(&bits(&mut gpu, &batch), &bits(&mut cpu(), &batch)).len();
            println!("{controller:?}, severity {severity:?}: {differ} of 100,000 differ");
            assert_eq!(differ, 0);
        }
    }
}

/// How much faster a specialised kernel is.
#[cfg(feature = "compose")]
#[test]
#[ignore = "measures: with --nocapture"]
fn specialised_kernels_are_faster() {
    let kinds: [(&str, World); 4] = [
        ("no noise", lives::world(500, |_| ())),
        (
            "all noise",
            lives::world(500, |spec| {
                spec.noise = Noise {
                    motor: 0.1,
                    ..Noise::CONSERVATIVE
                }
            }),
        ),
        (
            "hidden",
            lives::world(500, |spec| spec.controller = Controller::Hidden { units: 4 }),
        ),
        (
            "surrogate",
            lives::world(500, |spec| {
                spec.surrogate = Some(Arc::new(Surrogate::drawn(1, Differences::all(0.5))));
            }),
        ),
    ];
    for (name, world) in kinds {
        let batch = batch(&[world], 10_000, None);
        let mut gpu = gpu();
        let start = Instant::now();
        let words = oneiro::gpu::specialised(&batch.all(), 0).unwrap().len();
        let own = start.elapsed();
        let [generic, special] = [Specialise::Never, Specialise::Always].map(|when| {
            gpu.set_specialise(when);
            let start = Instant::now();
            gpu.evaluate_part(&batch.all(), &Control::new()).unwrap();
            let first = start.elapsed();
            (speed(&mut gpu, &batch) / 1e6, first)
        });
        println!("{name}: {generic:.2?} {special:.2?} M steps/s, first batch; {words} words of SPIR-V in {own:.1?}");
    }
}

/// Only operations that a driver may round in its own way differ.
fn assert_numbers_alone_differ(differences: &[String]) {
    let any_of = |scalar: &str| differences.iter().any(|difference| difference.contains(scalar));
    assert!(any_of("f32: ") && !any_of("u32: "), "{differences:?}");
}

#[test]
fn the_suite_tells_exact_kernels_from_others() {
    let mut cases = probe::operations();
    cases.extend(probe::functions(500));
    let mut exact = gpu();
    assert_eq!(exact.why_inexact(), None);
    assert_eq!(exact.differences(&cases).unwrap(), Vec::<String>::new());

    // With WGSL the driver may contract and reassociate, and does.
    let mut inexact = Gpu::open_with(exact.adapter(), Path::Wgsl).unwrap();
    assert!(inexact.why_inexact().is_some());
    let differences = inexact.differences(&cases).unwrap();
    assert_numbers_alone_differ(&differences);
}

/// A kernel without its `NoContraction` decorations.
fn contractible(kernel: &'static Kernel) -> &'static Kernel {
    // OpDecorate of three words, the last of them NoContraction
    let (decorate, no_contraction) = (0x0003_0047, 42);
    let mut words = kernel.spirv[..5].to_vec();
    let mut rest = &kernel.spirv[5..];
    while let Some(&first) = rest.first() {
        let (instruction, next) = rest.split_at((first >> 16) as usize);
        if (first, instruction.last()) != (decorate, Some(&no_contraction)) {
            words.extend_from_slice(instruction);
        }
        rest = next;
    }
    assert!(words.len() < kernel.spirv.len());
    Box::leak(Box::new(Kernel {
        spirv: Vec::leak(words),
        ..*kernel
    }))
}

#[test]
fn no_contraction_is_what_makes_it_exact() {
    let mut gpu = gpu();
    gpu.ask_for(FloatControls::default());
    let mut cases = probe::operations();
    assert_eq!(gpu.differences(&cases).unwrap(), Vec::<String>::new());

    let kernel = contractible(&PROBE_OPERATIONS);
    for case in &mut cases {
        case.kernel = kernel;
    }
    let differences = gpu.differences(&cases).unwrap();
    assert_numbers_alone_differ(&differences);
}

#[test]
fn cuts_and_chunks_do_not_matter() {
    let mut gpu = gpu();
    let batch = batch(&worlds(&Controller::Recurrent), 500, Some(9));
    let expected = bits(&mut cpu(), &batch);
    for (groups, cycles) in [(1, u32::MAX), (2, 7), (3, 1), (u32::MAX, 59), (5, 60), (u32::MAX, 1)] {
        gpu.set_bounds(Bounds { groups, cycles });
        assert_eq!(
            differing(&bits(&mut gpu, &batch), &expected),
            NONE,
            "{groups} groups, {cycles} cycles"
        );
    }
}

/// Mesa's software driver leaves the loops of an invocation after a total number of iterations, so a dispatch has to
/// end before. Fast devices get long dispatches, so the pace is measured first.
#[test]
fn no_driver_ends_a_long_life_early() {
    let plain = world(|spec| spec.cycles = 12_000);
    let surrogate = world(|spec| {
        spec.surrogate = Some(Arc::new(Surrogate::drawn(1, Differences::all(0.5))));
        spec.cycles = 1500;
    });
    let mut gpu = gpu();
    let mut cpu = cpu();
    for world in [plain, surrogate] {
        let batch = batch(&[world], 64, Some(100));
        for _ in 0..2 {
            assert_eq!(differing(&bits(&mut gpu, &batch), &bits(&mut cpu, &batch)), NONE);
        }
    }
}

#[test]
fn parts_are_as_good_as_the_whole() {
    let mut gpu = gpu();
    let batch = batch(&worlds(&Controller::Perceptron), 700, Some(30));
    let whole = cpu().evaluate_part(&batch.all(), &Control::new()).unwrap();
    let words = batch.trace_words();
    let mut slot = 0;
    for groups in [0..3, 3..4, 4..4, 4..batch.groups()] {
        let part = batch.part(groups);
        let result = gpu.evaluate_part(&part, &Control::new()).unwrap();
        assert_eq!(result.fitness.len(), part.slots());
        for group in part.group_table() {
            for lane in 0..group.rollouts as usize {
                let (here, there) = (slot + lane, slot + lane - part.groups().start as usize * 64);
                assert_eq!(result.fitness[there].to_bits(), whole.fitness[here].to_bits());
                let traces = (
                    &result.trace[there * words..][..words],
                    &whole.trace[here * words..][..words],
                );
                assert_eq!(traces.0, traces.1);
            }
            slot += 64;
        }
    }
    assert_eq!(slot, whole.fitness.len());
}

#[test]
fn earlier_batches_do_not_matter() {
    let mut gpu = gpu();
    let long = batch(&[world(|spec| spec.cycles = 90)], 200, Some(1));
    let mixed = batch(&worlds(&Controller::Perceptron), 260, Some(1));
    let plain = batch(&worlds(&Controller::Hidden { units: 32 }), 260, None);
    for batch in [&long, &mixed, &plain, &mixed, &long, &mixed] {
        assert_eq!(differing(&bits(&mut gpu, batch), &bits(&mut cpu(), batch)), NONE);
    }
}

/// Worlds of unequal size and length share batches whose last groups aren't full. Every word of the results is the CPU's, whatever
/// the device's buffers held before: also words that no episode writes.
#[test]
fn every_word_is_defined() {
    let swarms = [40, 2, 7].map(Swarm::odowd2014);
    let orders = |world: usize| {
        let robots = swarms[world].robots as usize;
        swarms[world].inputs(&Lamp::fixed(Light::OverNest), &vec![Order::always([0.99, 0.0]); robots])
    };
    let inputs = [0, 1, 2].map(orders);
    let swarm = |index: usize, worlds: &[usize]| {
        let world = worlds[index % worlds.len()];
        (world, inputs[world].clone())
    };
    let singles = worlds(&Controller::Perceptron);
    let single = |index: usize, worlds: &[usize]| {
        let world = worlds[index % worlds.len()];
        (world, lives::genes(index, singles[world].genes()))
    };
    let mut gpu = gpu();
    // First all slots have the largest world, whose words then remain in the buffers.
    all_words(
        &mut gpu,
        &Worlds::new(&swarms).unwrap(),
        [(128, &[0]), (70, &[0, 1, 2]), (2, &[1, 2])],
        swarm,
    );
    all_words(
        &mut gpu,
        &Worlds::new(&singles).unwrap(),
        [(256, &[0]), (70, &[0, 3, 1]), (5, &[3, 2])],
        single,
    );
}

/// Compares all words of the results of some episodes, which take turns in some worlds, for two stretches of cycles.
fn all_words(
    gpu: &mut Gpu,
    worlds: &Worlds,
    batches: [(usize, &[usize]); 3],
    rollout: impl Fn(usize, &[usize]) -> (usize, Vec<f32>),
) {
    for (count, taken) in batches {
        let genes: Vec<(usize, Vec<f32>)> = (0..count).map(|index| rollout(index, taken)).collect();
        let rollouts: Vec<Rollout<'_>> = genes
            .iter()
            .zip(0..)
            .map(|((world, genes), index)| Rollout {
                world: *world,
                genes,
                key: Key::rollout(5, 0, index, 0),
            })
            .collect();
        let mut states = Vec::new();
        for cycles in [0..20, 20..22] {
            let batch = worlds
                .stretch(&rollouts, cycles, &states, Some(TraceRequest { every: 2 }))
                .unwrap();
            let [here, there] = [&mut cpu() as &mut dyn Evaluator, gpu].map(|device| {
                let result = device.evaluate_part(&batch.all(), &Control::new()).unwrap();
                let fitness: Vec<u32> = result.fitness.iter().map(|fitness| fitness.to_bits()).collect();
                [fitness, result.trace, result.states]
            });
            for (what, (here, there)) in ["fitness", "trace", "states"].into_iter().zip(here.iter().zip(&there)) {
                let differing = here.iter().zip(there).position(|(here, there)| here != there);
                assert_eq!(differing, None, "{what} of {count} episodes in the worlds {taken:?}");
            }
            states = cpu().evaluate(&batch, &Control::new()).unwrap().states;
        }
    }
}

#[test]
fn wgsl_serves_those_that_take_no_spirv() {
    let adapter = find(&Choice::Best).unwrap();
    let mut gpu = Gpu::open_with(&adapter, Path::Wgsl).unwrap();
    assert!(!gpu.device().exact);
    for controller in CONTROLLERS {
        let batch = batch(&worlds(&controller), 400, None);
        let expected = bits(&mut cpu(), &batch);
        let differ = differing(&bits(&mut gpu, &batch), &expected).len();
        // The driver may round in its own way, which changes few lives this short.
        assert!(differ <= 40, "{differ} of 400 differ, {controller:?}");
    }
}

#[test]
fn a_lost_device_is_an_error() {
    let mut gpu = gpu();
    gpu.set_bounds(Bounds { groups: 2, cycles: 10 });
    let batch = batch(&worlds(&Controller::Perceptron), 500, None);
    gpu.lose_after(5, 1);
    for _ in 0..2 {
        let control = Control::new();
        match gpu.evaluate(&batch, &control) {
            Err(Error::Lost { device, reason }) => assert!(device == gpu.adapter().name() && !reason.is_empty()),
            other => panic!("{:?}", other.map(|outcome| outcome.fitness.len())),
        }
        assert_eq!(control.steps(), 0, "what was lost is not done");
    }
}

#[test]
fn a_lost_device_is_opened_again_and_then_replaced() {
    let batch = batch(&worlds(&Controller::Perceptron), 500, Some(20));
    let expected = bits(&mut cpu(), &batch);
    // Number of dispatches until a loss, number of devices lost in a row, and number of warnings.
    for (dispatches, devices, warnings) in [(1, 1, 1), (7, 1, 1), (20, 1, 1), (1, 2, 2), (9, 2, 2)] {
        let mut gpu = gpu();
        gpu.set_bounds(Bounds { groups: 3, cycles: 10 });
        gpu.lose_after(dispatches, devices);
        let name = gpu.adapter().name().to_owned();
        let mut recovering = Recovering::new(gpu, Box::new(cpu()));
        for _ in 0..2 {
            assert_eq!(
                differing(&bits(&mut recovering, &batch), &expected),
                NONE,
                "{dispatches}, {devices}"
            );
        }
        assert_eq!(recovering.warnings().len(), warnings, "{:?}", recovering.warnings());
        assert!(recovering.warnings()[0].contains(&name), "{:?}", recovering.warnings());
        let now = recovering.device().name;
        assert_eq!(now, if devices == 1 { name.as_str() } else { "cpu" });
    }
}

#[test]
fn a_cancel_is_prompt_and_leaves_the_device_in_order() {
    let mut gpu = gpu();
    let worlds = [world(|spec| spec.cycles = 1_000_000)];
    let endless = batch(&worlds, 2_000, None);
    let control = Arc::new(Control::new());
    let far = Arc::clone(&control);
    let canceller = std::thread::spawn(move || {
        while far.steps() == 0 {
            std::thread::sleep(Duration::from_millis(5));
        }
        far.cancel();
        Instant::now()
    });
    assert!(matches!(gpu.evaluate(&endless, &control), Err(Error::Cancelled)));
    let took = canceller.join().unwrap().elapsed();
    assert!(took < Duration::from_secs(1), "{took:?}");

    let batch = batch(&self::worlds(&Controller::Perceptron), 200, Some(5));
    assert_eq!(differing(&bits(&mut gpu, &batch), &bits(&mut cpu(), &batch)), NONE);
}

#[test]
fn any_kernel_runs_on_bare_buffers() {
    let batch = batch(&[world(|spec| spec.noise = Noise::SENSOR)], 128, None);
    let part = batch.all();
    let dispatch = Dispatch {
        step_end: 60,
        ..Dispatch::default()
    };
    let words = |bytes: &[u8]| bytemuck::pod_collect_to_vec::<u8, u32>(bytes);
    let buffers = vec![
        words(bytemuck::bytes_of(&dispatch)),
        words(bytemuck::cast_slice(part.worlds())),
        words(bytemuck::cast_slice(part.shapes())),
        words(bytemuck::cast_slice(part.tables())),
        words(bytemuck::cast_slice(part.group_table())),
        part.inputs().to_vec(),
        vec![0; part.slots() * batch.kernel().stride("state") / 4],
        vec![0; part.slots()],
        vec![0; batch.kernel().stride("trace") / 4],
    ];
    let run = Run {
        kernel: batch.kernel(),
        buffers,
        workgroups: batch.groups(),
    };
    let mut runs = [run.clone(), run];
    gpu().run(&mut runs).unwrap();
    let expected: Vec<u32> = bits(&mut cpu(), &batch)
        .into_iter()
        .map(|(fitness, _)| fitness)
        .collect();
    assert!(runs.iter().all(|run| run.buffers[7] == expected));
}

/// Large swarms take many loops, more than a software driver turns in a cycle: they have the CPU's results nevertheless.
#[test]
fn crowds_are_exact() {
    use oneiro::foraging::Light;
    use oneiro::random::Key;
    use oneiro::swarm::{self, Arena, Lamp, Order, Simulated, Swarm};

    let lived = |evaluator: &mut dyn Evaluator, robots: u32, radius: f32| {
        let mut swarm = Swarm::odowd2014(robots);
        swarm.forager.arena_radius = radius;
        let world = swarm::World {
            swarm: 0,
            lamp: Lamp::fixed(Light::OverNest),
            key: Key::rollout(9, 0, 0, 0),
        };
        let control = Control::new();
        let mut arena = Simulated::new(evaluator, &control, &[swarm], &[world]).unwrap();
        let orders = [vec![Order::always([0.99, 0.5]); robots as usize]];
        arena.live(30, &orders, 10).map_err(|trouble| trouble.to_string())
    };
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let mut gpu = gpu();
    for (robots, radius) in [(10, 600.0), (40, 300.0), (50, 600.0), (128, 600.0)] {
        let (here, there) = (lived(&mut cpu, robots, radius), lived(&mut gpu, robots, radius));
        assert!(
            here.is_ok() && here == there,
            "{robots} robots in {radius} mm: {:?}",
            there.err()
        );
    }
}
