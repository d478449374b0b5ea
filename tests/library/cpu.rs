//! The CPU's results depend only on the batch, not on lanes, threads, chunks, or its division.

use oneiro::batch::{Batch, PartResult, Trace};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Error, Evaluator};
use oneiro::world::{Controller, World, WorldSpec};

use crate::lives::{self, CONTROLLERS, batch};

fn world(change: impl Fn(&mut WorldSpec)) -> World {
    lives::world(120, change)
}

fn worlds(controller: &Controller) -> Vec<World> {
    lives::worlds(controller, 120, 37)
}

/// Bits of all results of an evaluation.
fn bits(mut cpu: Cpu, batch: &Batch) -> (Vec<u32>, Vec<u32>) {
    let outcome = cpu.evaluate(batch, &Control::new()).unwrap();
    let fitness = outcome.fitness.iter().map(|fitness| fitness.to_bits()).collect();
    let trace = outcome.traces.iter().flat_map(Trace::words).collect();
    (fitness, trace)
}

fn cpu(threads: usize) -> Cpu {
    Cpu::new(Some(threads)).unwrap()
}

#[test]
fn every_lane_code_gives_the_same_bits() {
    let names = Cpu::variants();
    assert!(
        names.len() > 1 && names.iter().any(|name| name.ends_with("x1")),
        "{names:?}"
    );
    for controller in CONTROLLERS {
        let batch = batch(&worlds(&controller), 150, Some(7));
        let expected = bits(cpu(1), &batch);
        assert!(
            expected.0.iter().filter(|&&bits| f32::from_bits(bits) > 1.0).count() > 50,
            "lives that earn something"
        );
        for name in &names {
            assert!(
                bits(cpu(1).with_variant(name).unwrap(), &batch) == expected,
                "{name}, {controller:?}"
            );
        }
    }
}

#[test]
fn threads_and_chunks_do_not_matter() {
    let batch = batch(&worlds(&Controller::Perceptron), 300, Some(10));
    let expected = bits(cpu(1), &batch);
    for threads in [1, 2, 3, 8] {
        for chunk in [1, 7, 37, 119, 120, 121, u32::MAX] {
            assert!(
                bits(cpu(threads).with_chunk(chunk), &batch) == expected,
                "{threads} threads, {chunk} cycles"
            );
        }
    }
}

#[test]
fn batch_size_and_other_swarms_do_not_matter() {
    let worlds = worlds(&Controller::Recurrent);
    let all = bits(cpu(2), &batch(&worlds, 260, None)).0;
    for rollouts in [1, 2, 3, 15, 16, 17, 63, 64, 65, 129] {
        assert_eq!(
            bits(cpu(2), &batch(&worlds, rollouts, None)).0,
            all[..rollouts],
            "{rollouts} rollouts"
        );
    }
}

#[test]
fn parts_make_the_whole() {
    let batch = batch(&worlds(&Controller::Perceptron), 500, Some(40));
    let mut cpu = cpu(2);
    let whole = cpu.evaluate_part(&batch.all(), &Control::new()).unwrap();
    let mut parts = PartResult::default();
    for first in (0..batch.groups()).step_by(3) {
        let part = cpu
            .evaluate_part(&batch.part(first..first + 3), &Control::new())
            .unwrap();
        parts.fitness.extend(part.fitness);
        parts.trace.extend(part.trace);
    }
    assert_eq!(
        batch.outcome(parts.clone()).fitness,
        batch.outcome(whole.clone()).fitness
    );
    assert!(batch.outcome(parts).traces == batch.outcome(whole).traces);
}

/// The other tests rely on this: the smallest change of a constant is detected.
#[test]
fn one_changed_constant_shows() {
    let bits_of = |scale: f32| {
        let world = world(|spec| {
            let mut motors = (*spec.robot.motors).clone();
            motors.cells.iter_mut().for_each(|cell| cell.displacement *= scale);
            spec.robot.motors = std::sync::Arc::new(motors);
        });
        bits(cpu(1), &batch(&[world], 64, Some(1)))
    };
    assert!(bits_of(1.0) != bits_of(1.0 + f32::EPSILON));
}

#[test]
fn traces_tell_the_life() {
    let worlds = worlds(&Controller::Perceptron);
    let batch = batch(&worlds, 8, Some(1));
    let outcome = cpu(2).evaluate(&batch, &Control::new()).unwrap();
    for (rollout, trace) in outcome.traces.iter().enumerate() {
        let world = &worlds[rollout % worlds.len()];
        assert_eq!(trace.len(), world.cycles() as usize);
        assert_eq!(trace.last().unwrap().fitness, outcome.fitness[rollout]);
        let mut sum = 0.0;
        for record in trace {
            sum += record.reward;
            assert_eq!(record.fitness, sum);
            assert!(
                (0.0..600.0).contains(&record.x) && (0.0..350.0).contains(&record.y),
                "{record:?}"
            );
        }
        for pair in trace.windows(2) {
            let moved = (pair[1].x - pair[0].x).hypot(pair[1].y - pair[0].y);
            // 8.2 mm per cycle, and a tenth more with the third world's motor noise.
            assert!(moved < 8.2 * 1.1 + 0.01, "{moved} mm");
            assert!(pair[0].collided == 0.0 || (moved == 0.0 && pair[0].reward == 0.0));
        }
    }
    let start = outcome.traces[3][0];
    assert_eq!((start.x, start.y, start.heading), (100.0, 80.0, 0.25));
}

#[test]
fn progress_counts_the_robots_steps() {
    let batch = batch(&worlds(&Controller::Perceptron), 333, None);
    for name in Cpu::variants() {
        let control = Control::new();
        cpu(2)
            .with_chunk(50)
            .with_variant(name)
            .unwrap()
            .evaluate(&batch, &control)
            .unwrap();
        assert_eq!(control.steps(), batch.steps(), "{name}");
    }
}

#[test]
fn a_cancelled_evaluation_stops() {
    let batch = batch(&[world(|spec| spec.cycles = 1_000_000)], 1000, None);
    let control = Control::new();
    std::thread::scope(|scope| {
        let evaluation = scope.spawn(|| cpu(2).evaluate(&batch, &control));
        while control.steps() == 0 {
            std::thread::yield_now();
        }
        control.cancel();
        assert!(matches!(evaluation.join().unwrap(), Err(Error::Cancelled)));
    });
    assert!(control.steps() < batch.steps());
}

#[test]
fn what_is_not_there_is_refused_by_name() {
    let error = cpu(1).with_variant("abacus").unwrap_err().to_string();
    assert!(error.contains("`abacus`; allowed: ") && error.contains("x1"), "{error}");
    for threads in [0, 100_000] {
        let error = Cpu::new(Some(threads)).unwrap_err().to_string();
        assert_eq!(error, format!("{threads} threads; allowed: 1 to 1024"));
    }
}
