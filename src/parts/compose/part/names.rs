//! A part may declare every name that gives way, and the results are those of a part without.

use std::fmt::Write as _;
use std::sync::Arc;

use super::{Part, check};
use crate::batch::{Batch, Rollout};
use crate::cpu::Cpu;
use crate::differential::{Build, Differential};
use crate::evaluator::{Control, Evaluator};
use crate::foraging::Forager;
use crate::parts::compose::{Kind, OwnPart, OwnParts};
use crate::random::Key;
use crate::world::{Robot, Task, World, WorldSpec};

fn task(declarations: &str) -> OwnPart {
    let text = format!(
        "{declarations}
        fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {{
            return Reward(length(now.end.xy - now.start.xy) + 0.25 * f32(now.collided), before);
        }}"
    );
    let part = Part::new(Kind::Task, "own.wgsl", &text).unwrap_or_else(|refused| panic!("{refused}"));
    OwnPart::new(Arc::new(part), &[]).expect("it has no values")
}

fn fitness(spec: WorldSpec, part: OwnPart) -> Vec<u32> {
    let spec = WorldSpec {
        task: Task::Own,
        cycles: 60,
        own: OwnParts::from([part]),
        ..spec
    };
    let world = World::new(spec).unwrap_or_else(|invalid| panic!("{invalid}"));
    let genes: Vec<f32> = (0..world.genes()).map(|gene| gene as f32 / 7.0 - 1.0).collect();
    let rollout = |episode| Rollout {
        world: 0,
        genes: &genes,
        key: Key::rollout(1, 0, episode, 0),
    };
    let rollouts: Vec<_> = (0..16).map(rollout).collect();
    let batch = Batch::new(&[world], &rollouts, None).expect("it fits");
    let mut cpu = Cpu::new(Some(1)).expect("there is a thread");
    let outcome = cpu.evaluate(&batch, &Control::new()).expect("it runs");
    outcome.fitness.iter().map(|fitness| fitness.to_bits()).collect()
}

#[test]
fn every_name_that_gives_way_may_be_declared() {
    let names = check::names_that_give_way();
    assert!(names.len() > 100 && names.contains("logistic"), "{names:?}");
    let names: Vec<_> = names.iter().collect();
    // A part has at most 500 declarations.
    let declarations: Vec<String> = names
        .chunks(400)
        .flat_map(|names| {
            let (mut functions, mut constants) = (String::new(), String::new());
            for name in names {
                let _ = writeln!(functions, "fn {name}(x: f32) -> f32 {{ return 0.5 * x; }}");
                let _ = writeln!(constants, "const {name} = 123.0;");
            }
            [functions, constants]
        })
        .collect();
    let robot = |count| WorldSpec {
        robot: Robot {
            build: Build::Differential(Differential {
                count,
                ..Differential::new(51.0, 128.0)
            }),
            ..Robot::khepera()
        },
        ..WorldSpec::miglino1995()
    };
    for spec in [
        WorldSpec::miglino1995(),
        WorldSpec::foraging(Forager::ODOWD2014),
        robot(None),
        robot(Some(3)),
    ] {
        let expected = fitness(spec.clone(), task(""));
        for declarations in &declarations {
            assert_eq!(fitness(spec.clone(), task(declarations)), expected);
        }
    }
}
