//! Lives that are reported cycle by cycle: a simulated life, told again, has the same commands, rewards and memory, bit for bit.

use std::sync::Arc;

use crate::described;
use oneiro::arena::Arena;
use oneiro::batch::{Batch, Rollout, Trace, TraceRequest};
use oneiro::compose::{DetailKind, Kind, OwnPart, OwnParts, Part};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::Key;
use oneiro::reported::{Error, Reported};
use oneiro::world::{Controller, Start, Task, World, WorldSpec};

/// A memory in each part, sensors that know the pose, a controller that draws random numbers, and a task that ends the life.
const OWN: [(Kind, &str); 3] = [
    (
        Kind::Sensor,
        "struct SensorReadings { x: f32, before: f32 }
struct SensorState { last: f32 }
fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    return Sensed(SensorReadings(pose.x * 0.001f, before.last), SensorState(pose.y * 0.001f));
}",
    ),
    (
        Kind::Controller,
        "const CONTROLLER_GENES: u32 = 2u * INPUTS;
struct ControllerState { outputs: vec2<f32> }
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let chance = random(episode, 1u, step, 0u).x;
    let left = logistic(weighed(episode, 0u, readings) + before.outputs.y + chance);
    let right = logistic(weighed(episode, INPUTS, readings) - before.outputs.x);
    return Command(vec2<f32>(left, right), ControllerState(vec2<f32>(left, right)));
}",
    ),
    (
        Kind::Task,
        "struct TaskState { path: f32 }
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let apart = vec2<f32>(now.end.x - now.start.x, now.end.y - now.start.y);
    let way = abs(apart.x) + abs(apart.y);
    return Reward(way * (1.0f - highest(now.real)) + now.outputs.x, TaskState(before.path + way));
}
fn task_ends(episode: Episode, own: TaskState) -> bool { return own.path > 300.0f; }
fn task_score(episode: Episode, own: TaskState, sum: f32) -> f32 { return sum + own.path; }",
    ),
];

fn parts() -> OwnParts {
    OwnParts::from(OWN.map(|(kind, text)| {
        let part = Part::new(kind, &format!("{}.wgsl", kind.word()), text).unwrap();
        OwnPart::new(Arc::new(part), &[]).unwrap()
    }))
}

/// A wide field, so that most lives touch nothing.
fn spec(controller: Controller) -> WorldSpec {
    WorldSpec {
        arena: Arena::rectangle(1500.0, 1500.0),
        controller,
        cycles: 150,
        ..WorldSpec::miglino1995()
    }
}

/// Genes of either sign, from the number of a life.
fn genes(life: u32, count: usize) -> Vec<f32> {
    let gene = |gene: u32| ((life * 31 + gene * 17) % 41) as f32 * 0.25 - 5.0;
    (0..count as u32).map(gene).collect()
}

/// Readings of the robot itself in a record, and those before noise.
fn readings(world: &World, trace: &Trace, record: usize) -> Vec<f32> {
    let details = trace.details(record);
    let real = world.details().iter().zip(details);
    real.filter(|(detail, _)| detail.kind == DetailKind::Real)
        .map(|(_, word)| f32::from_bits(*word))
        .collect()
}

/// Tells simulated lives again. Returns the number of cycles compared.
fn told_again(spec: &WorldSpec) -> usize {
    let world = World::new(spec.clone()).unwrap();
    let reported = Reported::new(spec).unwrap();
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let mut compared = 0;
    for life in 0..12 {
        let genes = genes(life, world.genes());
        let key = Key::rollout(7, 0, life.into(), 0);
        let rollout = Rollout {
            world: 0,
            genes: &genes,
            key,
        };
        let batch = Batch::new(&[&world], &[rollout], Some(TraceRequest { every: 1 })).unwrap();
        let outcome = cpu.evaluate(&batch, &Control::new()).unwrap();
        let trace = &outcome.traces[0];
        let poses: Vec<[f32; 3]> = trace
            .iter()
            .map(|record| [record.x, record.y, record.heading])
            .collect();
        let mut again = reported.begin(&genes, key, poses[0]).unwrap();
        // Reality knows nothing of a simulated collision, and where a simulated life has ended is not in its trace.
        let touched = trace.iter().position(|record| record.collided > 0.0);
        for record in 0..touched.unwrap_or(trace.len()).min(trace.len() - 1) {
            let speeds = again.speeds(&mut cpu, &readings(&world, trace, record)).unwrap();
            let expected = trace[record];
            assert_eq!(speeds, Some([expected.speed_left, expected.speed_right]));
            let told = again.moved(&mut cpu, poses[record + 1]).unwrap();
            assert_eq!(told.details(0), trace.details(record));
            assert_eq!(told[0], expected);
            if spec.task != Task::Own {
                assert_eq!(again.fitness().to_bits(), expected.fitness.to_bits());
            }
            compared += 1;
        }
    }
    compared
}

#[test]
fn a_simulated_life_told_again_is_the_same() {
    for (spec, least) in [
        (spec(Controller::Perceptron), 900),
        (spec(Controller::Hidden { units: 3 }), 900),
        (spec(Controller::Recurrent), 900),
        (described::spec(|_, _| ()), 300),
    ] {
        let compared = told_again(&spec);
        assert!(compared > least, "{compared} cycles of {:?}", spec.controller);
    }
    let own = WorldSpec {
        own: parts(),
        task: Task::Own,
        ..spec(Controller::Own)
    };
    assert!(told_again(&own) > 300);
}

/// A task that ends the life ends a reported one too, and nothing comes after it.
#[test]
fn a_life_ends_by_its_task_or_its_length() {
    let own = WorldSpec {
        own: parts(),
        task: Task::Own,
        ..spec(Controller::Own)
    };
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let world = Reported::new(&own).unwrap();
    for (way, cycles) in [(100.0, 4), (1.0, 150)] {
        let mut life = world
            .begin(&genes(1, 20), Key::rollout(1, 2, 3, 4), [700.0, 700.0, 0.0])
            .unwrap();
        while life.speeds(&mut cpu, &[0.0; 8]).unwrap().is_some() {
            let [x, y, heading] = life.pose();
            assert_eq!(life.moved(&mut cpu, [x + way, y, heading]).unwrap().len(), 1);
        }
        assert_eq!(life.cycles(), cycles);
        let (fitness, pose) = (life.fitness(), life.pose());
        assert!(life.moved(&mut cpu, [0.0; 3]).unwrap().is_empty());
        assert_eq!((life.fitness(), life.pose(), life.cycles()), (fitness, pose, cycles));
    }
}

#[test]
fn what_is_no_report_is_refused() {
    let spec = WorldSpec {
        start: Start::Random,
        ..spec(Controller::Perceptron)
    };
    let world = Reported::new(&spec).unwrap();
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let key = Key::rollout(1, 0, 0, 0);
    let refused = |genes: &[f32], start| world.begin(genes, key, start).unwrap_err().to_string();
    assert!(refused(&[0.0; 17], [0.0; 3]).contains("genes: are 17; allowed: 18"));
    assert!(refused(&[f32::NAN; 18], [0.0; 3]).contains("NaN"));
    assert!(refused(&[0.0; 18], [0.0, f32::INFINITY, 0.0]).contains("start[1]: is inf"));
    let mut life = world.begin(&[1.0; 18], key, [0.0; 3]).unwrap();
    let mut refused = |readings: &[f32]| match life.speeds(&mut cpu, readings) {
        Err(Error::Invalid(invalid)) => invalid.to_string(),
        other => panic!("{other:?}"),
    };
    assert!(refused(&[0.0; 7]).contains("readings: are 7; allowed: 8"));
    assert!(refused(&[0.0, 0.0, 0.0, f32::NAN, 0.0, 0.0, 0.0, 0.0]).contains("readings[3]: is NaN"));
    let end = life.moved(&mut cpu, [f32::NAN, 0.0, 0.0]).unwrap_err().to_string();
    assert!(end.contains("end[0]: is NaN"), "{end}");
}
