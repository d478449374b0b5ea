//! Worlds that are printed with a controller, in C: an episode there has the simulator's bits, sensors read at a pose what a trace has, and
//! commands of a trace move the robot as it did. The readings and the rewards are those of traces, not of the printed functions.

use std::fmt::Write as _;
use std::process::Command;
use std::{fs, thread};

use oneiro::automode::Modules;
use oneiro::batch::{Rollout, TraceRequest, Worlds};
use oneiro::cpu::Cpu;
use oneiro::differential::{Build, Differential};
use oneiro::evaluator::{Control, Evaluator};
use oneiro::export::{Also, Controller, c};
use oneiro::foraging::Forager;
use oneiro::random::Key;
use oneiro::reference::{Model, Reference};
use oneiro::world::{self, Collision, Noise, Robot, World, WorldSpec};

use crate::exported::{Folder, QUIET, compile, is_there};
use crate::{described, epucks, lives, modules, network};

const ALL: Also = Also {
    sensors: true,
    task: true,
};
const CYCLES: u32 = 200;
/// The episode that files know.
const KNOWN: Key = Key {
    words: [77, 99],
    trial: 3,
    generation: 0,
};

/// Worlds of sampled and of parametric robots, with and without noise, and with a task of a user's.
fn worlds() -> Vec<(&'static str, World)> {
    let parametric = |noise: Noise| {
        World::new(WorldSpec {
            robot: Robot {
                build: Build::Differential(Differential {
                    acceleration: Some(500.0),
                    wheel_noise: Some(0.1),
                    ..described::robot()
                }),
                ..Robot::khepera()
            },
            arena: described::arena(),
            controller: world::Controller::Recurrent,
            cycles: CYCLES,
            noise,
            ..WorldSpec::miglino1995()
        })
        .unwrap()
    };
    let sampled = |noise: Noise, collision: Collision| {
        lives::world(CYCLES, |spec| {
            spec.noise = noise;
            spec.robot.collision = collision;
        })
    };
    vec![
        ("plain", sampled(Noise::NONE, Collision::Undo)),
        ("noisy", sampled(Noise::SENSOR, Collision::Slide)),
        ("walking", sampled(Noise::CONSERVATIVE, Collision::KeepTurn)),
        ("parametric", parametric(Noise::NONE)),
        ("uncertain", parametric(Noise::SENSOR)),
    ]
}

fn with_world(world: &World, also: Also) -> Controller {
    let genome = modules::genome(world, 7);
    Controller::new(world, &genome, 0)
        .unwrap()
        .with_world(also, KNOWN)
        .unwrap()
}

/// The lines that a program of a file and this main function prints.
fn printed(name: &str, text: &str, main: &str) -> Option<Vec<String>> {
    if !is_there("gcc") {
        return None;
    }
    // Tests run at the same time.
    let folder = Folder::new(&format!("world-{name}-{:?}", thread::current().id()));
    fs::write(folder.0.join("own.c"), text).unwrap();
    fs::write(
        folder.0.join("main.c"),
        format!("#include <stdio.h>\n#include \"own.c\"\nint main(void)\n{{\n{main}    return 0;\n}}\n"),
    )
    .unwrap();
    let options: Vec<_> = QUIET.into_iter().chain(["-O2", "-std=c99", "-o", "world"]).collect();
    let compiled = compile(&folder.0, "gcc", &options, &["main.c".to_owned()]);
    let messages = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success(), "{name}: {messages}");
    let output = Command::new(folder.0.join("world")).output().unwrap();
    assert!(output.status.success(), "{name}: {}", output.status);
    let text = String::from_utf8(output.stdout).unwrap();
    Some(text.lines().map(str::to_owned).collect())
}

fn floats(numbers: &[f32]) -> String {
    let numbers: Vec<_> = numbers
        .iter()
        .map(|number| format!("own_number_of({}u)", number.to_bits()))
        .collect();
    numbers.join(", ")
}

fn words(numbers: &[f32]) -> String {
    let numbers: Vec<_> = numbers.iter().map(|number| number.to_bits().to_string()).collect();
    numbers.join(" ")
}

/// Statements that print an episode of `own_episode`, and the lines that the simulator gives for it.
fn episode(world: &World, genome: &[f32], key: Key) -> (String, String) {
    let main = format!(
        "    uint32_t cycles;
    float fitness = own_episode({}u, {}u, {}u, &cycles);
    printf(\"%d %d\\n%u %u\\n\", own_check(), own_check_world(), cycles, own_bits_of(fitness));
",
        key.words[0], key.words[1], key.trial
    );
    let rollout = Rollout {
        world: 0,
        genes: genome,
        key,
    };
    let batch = Worlds::new(&[world]).unwrap();
    let batch = batch.batch(&[rollout], Some(TraceRequest { every: 1 })).unwrap();
    let outcome = Cpu::new(Some(1)).unwrap().evaluate(&batch, &Control::new()).unwrap();
    (
        main,
        format!("{} {}", outcome.traces[0].len(), outcome.fitness[0].to_bits()),
    )
}

#[test]
fn an_episode_in_c_is_the_simulators() {
    let mut cpu = Cpu::new(Some(1)).unwrap();
    for (name, world) in worlds() {
        let controller = with_world(&world, ALL);
        let key = Key::rollout(3, 0, 1, 2);
        let cycles = controller.record(&mut cpu, key).unwrap();
        let text = c(&controller, "own", &[], &cycles[..16]);
        let (main, expected) = episode(&world, &modules::genome(&world, 7), Key::rollout(3, 0, 2, 5));
        if let Some(lines) = printed(name, &text, &main) {
            assert_eq!(lines, ["0 0", expected.as_str()], "{name}");
        }
        // With another arena, the file finds that its episode differs.
        let narrower = text.replace("600.0f", "590.0f");
        if let Some(lines) = printed(name, &narrower, &main) {
            assert_eq!(lines[0], "0 1", "{name} in another arena");
        }
    }
}

/// Each by itself: the sensors at the poses of a trace, and the motors and the task by its outputs.
#[test]
fn sensors_and_task_by_themselves_are_those_of_a_trace() {
    let mut cpu = Cpu::new(Some(1)).unwrap();
    for (name, world) in worlds() {
        let key = Key::rollout(3, 0, 1, 2);
        let genome = modules::genome(&world, 7);
        let rollout = Rollout {
            world: 0,
            genes: &genome,
            key,
        };
        let batch = Worlds::new(&[&world]).unwrap();
        let batch = batch.batch(&[rollout], Some(TraceRequest { every: 1 })).unwrap();
        let trace = cpu.evaluate(&batch, &Control::new()).unwrap().traces.remove(0);
        let records: Vec<_> = trace.lines().map(|(record, _)| *record).collect();
        let begin = format!(
            "own_world_begin(&world, {}u, {}u, {}u);",
            key.words[0], key.words[1], key.trial
        );

        let controller = with_world(
            &world,
            Also {
                task: true,
                ..Also::default()
            },
        );
        let cycles = controller.record(&mut cpu, key).unwrap();
        let text = c(&controller, "own", &[], &cycles[..4]);
        assert!(
            !text.contains("own_world_sense") && !text.contains("own_episode"),
            "{name}"
        );
        let mut main = format!("    own_world world;\n    own_world_cycle after;\n    {begin}\n");
        let mut expected = Vec::new();
        for (at, record) in records.iter().enumerate() {
            let _ = writeln!(
                main,
                "    {{ const float outputs[2] = {{{}}}; own_world_drive(&world, outputs, &after); }}
    printf(\"%u %u %u %u %d %d\\n\", own_bits_of(after.pose[0]), own_bits_of(after.pose[2]), own_bits_of(after.speeds[0]),
        own_bits_of(after.reward), after.collided, after.is_over);",
                floats(&[record.left, record.right])
            );
            let next = records
                .get(at + 1)
                .map_or_else(String::new, |next| words(&[next.x, next.heading]));
            let rest = words(&[record.speed_left, record.reward]);
            let is_last = u32::from(at + 1 == records.len());
            expected.push((next, format!("{rest} {} {is_last}", record.collided)));
        }
        let Some(lines) = printed(name, &text, &main) else {
            return;
        };
        assert_eq!(lines.len(), expected.len());
        for (line, (next, rest)) in lines.iter().zip(&expected) {
            assert!(
                line.starts_with(next.as_str()) && line.ends_with(rest.as_str()),
                "{name}: {line}: {next} {rest}"
            );
        }
        assert!(
            records.iter().any(|record| record.collided > 0.0) || name == "parametric",
            "{name}"
        );

        let controller = with_world(
            &world,
            Also {
                sensors: true,
                ..Also::default()
            },
        );
        let text = c(&controller, "own", &[], &cycles[..4]);
        assert!(
            !text.contains("own_world_drive") && !text.contains("own_episode"),
            "{name}"
        );
        if name == "walking" {
            // The displacement by its noise is remembered, and walks with each cycle that is driven.
            continue;
        }
        let inputs = cycles[0].readings.len();
        let format: Vec<_> = (0..inputs).map(|_| "%u").collect();
        let values: Vec<_> = (0..inputs)
            .map(|input| format!("own_bits_of(inputs[{input}])"))
            .collect();
        let mut main = format!("    own_world world;\n    float inputs[own_INPUTS];\n    {begin}\n");
        for (at, record) in records.iter().enumerate() {
            let _ = writeln!(
                main,
                "    {{ const float pose[3] = {{{}}}; own_world_place(&world, pose); }}
    world.cycle = {at};
    own_world_sense(&world, inputs);
    printf(\"{}\\n\", {});",
                floats(&[record.x, record.y, record.heading]),
                format.join(" "),
                values.join(", ")
            );
        }
        let lines = printed(name, &text, &main).unwrap();
        let expected: Vec<_> = cycles.iter().map(|cycle| words(&cycle.readings)).collect();
        assert_eq!(lines, expected, "{name}");
    }
}

/// E-pucks with a reference model.
fn epucks(model: Model, count: u32) -> WorldSpec {
    let spec = modules::spec(world::Controller::Recurrent, count);
    WorldSpec {
        robot: epucks::epucks(model, Reference::DEFAULT, count),
        ..spec
    }
}

/// Swarms whose robots see each other, push each other and hear each other.
fn swarms() -> Vec<(&'static str, World)> {
    let of = |mut spec: WorldSpec| {
        spec.cycles = 60;
        World::new(spec).unwrap()
    };
    vec![
        ("swarm", of(modules::spec(world::Controller::Recurrent, 4))),
        (
            "network",
            of(modules::spec(
                world::Controller::Network(network::networks()[0].clone()),
                7,
            )),
        ),
        ("epucks", of(epucks(Model::Rm11, 5))),
        ("epucks_1_2", of(epucks(Model::Rm12, 3))),
    ]
}

#[test]
fn a_swarms_episode_in_c_is_the_simulators() {
    let mut cpu = Cpu::new(Some(1)).unwrap();
    for (name, world) in swarms() {
        let genome = modules::genome(&world, 7);
        let controller = Controller::new(&world, &genome, 2)
            .unwrap()
            .with_world(ALL, KNOWN)
            .unwrap();
        let cycles = controller.record(&mut cpu, Key::rollout(3, 0, 1, 2)).unwrap();
        let text = c(&controller, "own", &[], &cycles[..16]);
        let (main, expected) = episode(&world, &genome, Key::rollout(3, 0, 2, 5));
        if let Some(lines) = printed(name, &text, &main) {
            assert_eq!(lines, ["0 0", expected.as_str()], "{name}");
        }
    }
}

/// With a state machine, whose random numbers differ from robot to robot, the robots are driven as in a trace.
#[test]
fn a_swarm_is_driven_in_c_as_in_its_traces() {
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let machine = world::Controller::StateMachine(Modules::DEFAULT);
    let world = World::new(WorldSpec {
        cycles: 60,
        ..modules::spec(machine, 3)
    })
    .unwrap();
    let genome = modules::genome(&world, 7);
    let key = Key::rollout(3, 0, 1, 2);
    let controller = Controller::new(&world, &genome, 0)
        .unwrap()
        .with_world(ALL, KNOWN)
        .unwrap();
    let cycles = controller.record(&mut cpu, key).unwrap();
    let text = c(&controller, "own", &[], &cycles[..4]);
    assert!(!text.contains("own_episode"));
    let observed = world.observed().unwrap();
    let rollout = Rollout {
        world: 0,
        genes: &genome,
        key,
    };
    let batch = Worlds::new(&[&observed]).unwrap();
    let batch = batch.batch(&[rollout], Some(TraceRequest { every: 1 })).unwrap();
    let outcome = cpu.evaluate(&batch, &Control::new()).unwrap();
    let traces = outcome.traces[0].by_robot(3);
    let begin = format!(
        "own_world_begin(&world, {}u, {}u, {}u);",
        key.words[0], key.words[1], key.trial
    );
    let mut main =
        format!("    own_world world;\n    own_world_cycle after[3];\n    float inputs[own_INPUTS];\n    {begin}\n");
    let mut expected = Vec::new();
    for (at, cycle) in cycles.iter().enumerate() {
        let outputs: Vec<f32> = traces
            .iter()
            .flat_map(|trace| [trace[at].left, trace[at].right])
            .collect();
        let _ = writeln!(
            main,
            "    own_world_sense(&world, 0, inputs);
    {{ const float outputs[6] = {{{}}}; own_world_drive(&world, outputs, after); }}
    printf(\"%u %u %d\\n\", own_bits_of(inputs[0]), own_bits_of(inputs[1]), after[1].is_over);",
            floats(&outputs)
        );
        let is_last = u32::from(at + 1 == cycles.len());
        expected.push(format!("{} {is_last}", words(&cycle.readings[..2])));
    }
    main += "    printf(\"%u\\n\", own_bits_of(after[0].fitness));\n";
    expected.push(outcome.fitness[0].to_bits().to_string());
    if let Some(lines) = printed("machine", &text, &main) {
        assert_eq!(lines, expected);
    }
}

#[test]
fn worlds_that_are_not_printed_are_refused() {
    let swarm = World::new(modules::spec(world::Controller::Recurrent, 4)).unwrap();
    let forager = World::new(WorldSpec {
        controller: world::Controller::Recurrent,
        ..WorldSpec::foraging(Forager::ODOWD2014)
    })
    .unwrap();
    let refused = |world: &World, also| {
        let controller = Controller::new(world, &modules::genome(world, 7), 0).unwrap();
        controller.with_world(also, KNOWN).unwrap_err().to_string()
    };
    assert!(refused(&forager, ALL).starts_with("world: is of foragers"));
    let sensors = Also {
        sensors: true,
        ..Also::default()
    };
    assert!(
        refused(&swarm, sensors).starts_with("world: is a swarm's, of which sensors and task are printed together")
    );
}
