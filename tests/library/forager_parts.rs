//! Foragers with any controller and any task: the bits of the kernel that ships where both do the same, the same bits
//! everywhere, and refusals.

use std::sync::Arc;

use oneiro::batch::{Batch, Outcome, Record, Rollout, Trace, TraceRequest, Worlds};
use oneiro::compose::{DetailKind, Kind, OwnPart, OwnParts, Part};
use oneiro::cpu::Cpu;
use oneiro::differential::Build;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::foraging::{Details, Forager, Foraging, Light, READINGS};
use oneiro::random::{Key, pcg4d};
use oneiro::reported::Reported;
use oneiro::world::{Collision, Controller, Noise, Task, World, WorldSpec};

use crate::composed::Subject;

/// The shipped task as a user would write it.
const SAME: &str = "
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let left = max(60.0f - f32(now.step + 1u) * 0.1f, 0.0f);
    return Reward(select(0.0f, left, now.brought), before);
}
";

/// Towards the light with food, and away from it without; the readings say where it is.
const PHOTOTAXIS: &str = "
struct ControllerGenes {
    speed: f32, // 0 to 1: share of the greatest speed
    gain: f32, // 0 to 1: of a turn
}
struct ControllerState {
    turned: f32,
    carried: u32,
}
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let ahead = readings.light_left_17 + readings.light_right_17 - readings.light_left_150 - readings.light_right_150;
    let aside = readings.light_left_50 + readings.light_left_90 - readings.light_right_50 - readings.light_right_90;
    let sign = select(-1.0f, 1.0f, readings.carries > 0.0f);
    let off = direction(sign * vec2<f32>(ahead, aside));
    let turn = gene(episode, GAIN) * (off - floor(off + 0.5f)) + 0.2f * highest(readings);
    let forward = 0.5f + 0.5f * gene(episode, SPEED);
    return Command(vec2<f32>(forward - turn, forward + turn), ControllerState(turn, before.carried + u32(readings.carries)));
}
";

/// A task with values, a memory, an end and a score, which asks for everything that foragers have.
const WHOLE: &str = "
struct TaskValues {
    enough: f32, // 2, 1 to 100: items after which a life ends
    toward: f32, // 0.5, 0 to 1: what a millimetre towards food or nest earns
}
struct TaskState {
    taken: u32,
    brought: u32,
    way: f32,
}
fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    return TaskState(0u, 0u, distance_along(episode, vec2<f32>(pose.x, pose.y), pose.z, 500.0f));
}
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var own = before;
    own.taken += select(0u, 1u, now.took);
    own.brought += select(0u, 1u, now.brought);
    own.way = select(now.to_food, now.to_nest, own.taken > own.brought);
    let nearer = clamp(before.way - own.way, -13.0f, 13.0f);
    let hit = select(0.0f, 1.0f, now.collided | blocked(episode, vec2<f32>(now.end.x + 20.0f, now.end.y)));
    return Reward(task_values(episode).toward * nearer + now.worth - hit, own);
}
fn task_ends(episode: Episode, own: TaskState) -> bool {
    return f32(own.brought) >= task_values(episode).enough;
}
fn task_score(episode: Episode, own: TaskState, sum: f32) -> f32 {
    return sum + 10.0f * f32(own.taken);
}
";

/// A reading of distance that a user adds.
const SENSOR: &str = "
struct SensorReadings {
    wall: f32,
}
fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    return Sensed(SensorReadings(0.001f * distance_along(episode, pose.xy, pose.z, 2000.0f)), before);
}
";

fn own(kind: Kind, text: &str, values: &[(&str, f64)]) -> OwnPart {
    let part = Part::new(kind, "own.wgsl", text).unwrap_or_else(|refused| panic!("{refused}"));
    OwnPart::new(Arc::new(part), values).unwrap()
}

fn spec(foraging: Foraging) -> WorldSpec {
    WorldSpec::foraging(Forager {
        foraging,
        ..Forager::ODOWD2014
    })
}

/// A world with a user's controller and task.
fn everything(light: Light) -> World {
    World::new(WorldSpec {
        controller: Controller::Own,
        task: Task::Own,
        own: OwnParts::from([
            own(Kind::Controller, PHOTOTAXIS, &[]),
            own(Kind::Task, WHOLE, &[("enough", 3.0)]),
        ]),
        ..spec(Foraging::odowd2014(light))
    })
    .unwrap()
}

/// Foragers of all kinds of the study's values.
fn foragers() -> Vec<Foraging> {
    let mut foragers: Vec<Foraging> = [Light::OverNest, Light::Nowhere, Light::OppositeNest]
        .map(Foraging::odowd2014)
        .into();
    foragers.push(Foraging {
        light_noise: 0.0,
        wheel_noise: 0.0,
        food_items: 8,
        start: Some([100.0, -50.0, 0.25]),
        ..foragers[0]
    });
    // Nothing is near enough to be avoided: it runs into the wall.
    foragers.push(Foraging {
        near: 0.0,
        ..foragers[2]
    });
    foragers
}

/// Genes from 0 to 0.99 in hundredths.
fn genome(life: u64, genes: usize) -> Vec<f32> {
    let word = |gene: usize| pcg4d([life as u32, gene as u32, 0, 2014])[0];
    (0..genes).map(|gene| (word(gene) % 100) as f32 / 100.0).collect()
}

/// The rollouts of a world that is alone in its batch.
fn rollouts(genomes: &[Vec<f32>]) -> Vec<Rollout<'_>> {
    let rollout = |(life, genes)| Rollout {
        world: 0,
        genes,
        key: Key::rollout(1, 0, life, 0),
    };
    (0_u64..).zip(genomes.iter().map(Vec::as_slice)).map(rollout).collect()
}

fn batch(world: &World, lives: u64, every: u32) -> Batch {
    let genomes: Vec<_> = (0..lives).map(|life| genome(life, world.genes())).collect();
    let trace = (every > 0).then_some(TraceRequest { every });
    Batch::new(std::slice::from_ref(world), &rollouts(&genomes), trace).unwrap()
}

fn evaluated(evaluator: &mut dyn Evaluator, batch: &Batch) -> Outcome {
    evaluator.evaluate(batch, &Control::new()).unwrap()
}

fn lived(batch: &Batch) -> Outcome {
    evaluated(&mut Cpu::new(Some(2)).unwrap(), batch)
}

fn bits(numbers: &[f32]) -> Vec<u32> {
    numbers.iter().map(|number| number.to_bits()).collect()
}

/// The detail of a record by its kind and name.
fn detail(world: &World, kind: DetailKind, name: &str, details: &[u32]) -> f32 {
    let is_it = |own: &oneiro::compose::Detail| own.kind == kind && own.name == name;
    f32::from_bits(details[world.details().iter().position(is_it).unwrap()])
}

/// Behaviours and task that ship, put together as parts, have the bits of the kernel that ships: fitness, paths, wheels, rewards
/// and readings. So has the task written again as a user's.
#[test]
fn what_ships_has_its_bits_as_parts() {
    let mut collided = 0;
    for foraging in foragers() {
        let genomes: Vec<_> = (0..300).map(|life| genome(life, 2)).collect();
        let trace = Some(TraceRequest { every: 1 });
        let shipped = lived(
            &Worlds::new(&[foraging])
                .unwrap()
                .batch(&rollouts(&genomes), trace)
                .unwrap(),
        );
        assert!(shipped.fitness.iter().any(|&fitness| fitness > 0.0));
        let again = WorldSpec {
            task: Task::Own,
            own: OwnParts::from([own(Kind::Task, SAME, &[])]),
            ..spec(foraging)
        };
        for spec in [spec(foraging), again] {
            let world = World::new(spec).unwrap();
            assert_eq!(world.gene_layout().names(), ["with_food", "without_food"]);
            let found = lived(&batch(&world, 300, 1));
            assert_eq!(bits(&found.fitness), bits(&shipped.fitness));
            for (found, shipped) in found.traces.iter().zip(&shipped.traces) {
                for (cycle, (record, details)) in found.lines().enumerate() {
                    let without_outputs = |own: &Record| Record {
                        left: 0.0,
                        right: 0.0,
                        ..*own
                    };
                    assert_eq!(without_outputs(record), shipped[cycle]);
                    collided += u32::from(record.collided > 0.0);
                    let own: Details = shipped.details_as(cycle);
                    let read = |name| detail(&world, DetailKind::Perceived, name, details);
                    let near = ["near_left_17", "near_left_50", "near_right_50", "near_right_17"].map(read);
                    assert_eq!(near, [own.front_0, own.front_1, own.front_2, own.front_3]);
                    assert_eq!(read("carries"), own.carries);
                }
            }
        }
    }
    assert!(collided > 1000, "{collided} cycles ended at the wall");
}

/// Episodes that are pinned ([`crate::composed`]).
pub(crate) fn subjects() -> Vec<Subject> {
    let world = everything(Light::OverNest);
    vec![Subject::new("own parts", 150, 150, |episodes| {
        batch(&world, episodes as u64, 7)
    })]
}

/// What a task is told of food agrees with the readings, and what its memory says with the trace.
#[test]
fn a_task_is_told_what_became_of_the_food() {
    let world = everything(Light::OverNest);
    let memory = |name: &str, details: &[u32]| detail(&world, DetailKind::Memory(Kind::Task), name, details);
    let outcome = lived(&batch(&world, 300, 1));
    let (mut taken, mut ended) = (0, 0);
    for (trace, fitness) in outcome.traces.iter().zip(&outcome.fitness) {
        let lines: Vec<_> = trace.lines().collect();
        for pair in lines.windows(2) {
            let carries = pair
                .iter()
                .map(|(_, details)| detail(&world, DetailKind::Real, "carries", details));
            let carries: Vec<f32> = carries.collect();
            let items = |name: &str| memory(name, pair[0].1).to_bits();
            assert_eq!(items("taken") - items("brought"), carries[1] as u32);
            let (next, end) = (&pair[1].0, pair[0].1);
            if carries[1] > 0.0 {
                let from_nest = (next.x + 600.0).hypot(next.y);
                assert!((memory("way", end) - from_nest).abs() < 1e-2);
            }
        }
        let (last, details) = lines.last().unwrap();
        let items = |name: &str| memory(name, details).to_bits();
        assert_eq!(*fitness, last.fitness + 10.0 * items("taken") as f32);
        assert!(items("brought") == 3 || lines.len() == 600);
        taken += items("taken");
        ended += u32::from(items("brought") == 3);
    }
    assert!(taken > 100 && ended > 3, "{taken} items taken, {ended} lives ended");
}

/// Outputs command the wheels: 0 full speed backwards, 1 forwards; the path is an arc. In double precision.
#[test]
fn outputs_drive_arcs() {
    let foraging = Foraging {
        wheel_noise: 0.0,
        food_items: 0,
        start: Some([-100.0, 50.0, 0.125]),
        cycles: 30,
        ..Foraging::odowd2014(Light::Nowhere)
    };
    for [left, right] in [[1.0, 1.0], [0.0, 0.5], [0.75, 1.0], [0.25, 0.75], [1.0, 0.0]] {
        let text = format!(
            "const CONTROLLER_GENES: u32 = 1u;
            fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {{
                return Command(vec2<f32>({left:?}f, {right:?}f), before);
            }}"
        );
        let world = World::new(WorldSpec {
            controller: Controller::Own,
            own: OwnParts::from([own(Kind::Controller, &text, &[])]),
            ..spec(foraging)
        })
        .unwrap();
        let trace = &lived(&batch(&world, 1, 1)).traces[0];
        let [mut x, mut y, mut heading] = [-100.0_f64, 50.0, 0.125];
        let ways = [left, right].map(|output: f64| 12.88 * (2.0 * output - 1.0));
        let (forward, turn) = (
            0.5 * (ways[0] + ways[1]),
            (ways[1] - ways[0]) / 53.0 / std::f64::consts::TAU,
        );
        for record in trace {
            for (found, expected) in [(record.x, x), (record.y, y)] {
                assert!(
                    (f64::from(found) - expected).abs() < 1e-2,
                    "{left}, {right}: {found}, not {expected}"
                );
            }
            assert_eq!([record.left, record.right].map(f64::from), [left, right]);
            let mean = std::f64::consts::TAU * (heading + 0.5 * turn);
            x += forward * mean.cos();
            y += forward * mean.sin();
            heading += turn;
        }
    }
}

/// Each reading of light is that of its sensor, before noise by the law in docs/epuck.md in double precision.
#[test]
fn readings_of_light_follow_their_law() {
    const BEARINGS: [f64; 8] = [17.0, 50.0, -50.0, -17.0, 90.0, 150.0, 210.0, 270.0];
    for (light, lamp) in [(Light::OverNest, -700.0), (Light::OppositeNest, 700.0)] {
        let world = World::new(spec(Foraging::odowd2014(light))).unwrap();
        let outcome = lived(&batch(&world, 40, 25));
        for (record, details) in outcome.traces.iter().flat_map(Trace::lines) {
            let [x, y, heading] = [record.x, record.y, record.heading].map(f64::from);
            for (name, bearing) in READINGS[4..12].iter().zip(BEARINGS) {
                let axis = std::f64::consts::TAU * heading + bearing.to_radians();
                let [to_x, to_y] = [lamp - x - 35.0 * axis.cos(), -y - 35.0 * axis.sin()];
                let off = (to_y.atan2(to_x) - axis).sin().atan2((to_y.atan2(to_x) - axis).cos());
                let facing = (1.0 - 2.0 * off.abs() / std::f64::consts::PI).max(0.0);
                let expected = (0.1 + (-0.002 * to_x.hypot(to_y)).exp() * facing).min(1.0);
                let found = |kind| f64::from(detail(&world, kind, name, details));
                assert!((found(DetailKind::Real) - expected).abs() < 1e-4, "{name}: {expected}");
                assert!(
                    (found(DetailKind::Perceived) - expected).abs() < 0.0501,
                    "{name}: {expected}"
                );
            }
        }
    }
}

/// Every controller that ships reads a forager's thirteen readings, and a user's; sensors of a user's see the round wall.
#[test]
fn all_controllers_read_all_readings() {
    for (controller, genes) in [
        (Controller::Perceptron, 30),
        (Controller::Hidden { units: 2 }, 36),
        (Controller::Recurrent, 34),
    ] {
        let world = World::new(WorldSpec {
            controller,
            own: OwnParts::from([own(Kind::Sensor, SENSOR, &[])]),
            ..spec(Foraging::odowd2014(Light::OverNest))
        })
        .unwrap();
        assert_eq!(world.genes(), genes);
        let names = world.gene_layout().names();
        for reading in READINGS {
            assert!(names.iter().any(|name| name.starts_with(reading)), "{reading}");
        }
        let outcome = lived(&batch(&world, 40, 3));
        for (record, details) in outcome.traces.iter().flat_map(Trace::lines) {
            let found = f64::from(detail(&world, DetailKind::Perceived, "wall", details));
            let angle = std::f64::consts::TAU * f64::from(record.heading);
            let (x, y) = (f64::from(record.x), f64::from(record.y));
            let along = x * angle.cos() + y * angle.sin();
            let expected = (along * along + 360_000.0 - x * x - y * y).sqrt() - along;
            assert!((1000.0 * found - expected).abs() < 0.01, "{found}, not {expected} mm");
        }
    }
}

#[test]
fn what_foragers_lack_is_refused() {
    let good = spec(Foraging::odowd2014(Light::OverNest));
    assert!(World::new(good.clone()).is_ok());
    let refused = |spec: WorldSpec, field: &str, problem: &str| {
        let invalid = World::new(spec).unwrap_err();
        assert_eq!(invalid.field, field);
        assert!(invalid.problem.contains(problem), "{invalid}");
    };
    let mut sticky = good.clone();
    sticky.robot.collision = Collision::Slide;
    refused(sticky, "robot.collision", "the wall stops a forager");
    let noise = Noise::SENSOR;
    refused(WorldSpec { noise, ..good.clone() }, "noise", "arena.light_noise");
    let arena = WorldSpec::miglino1995().arena;
    refused(WorldSpec { arena, ..good.clone() }, "arena", "arena.radius_mm");
    for (field, controller, task) in [
        ("controller.kind", Controller::Behaviours, Task::AVOIDANCE),
        ("task.kind", Controller::Perceptron, Task::Foraging),
    ] {
        let spec = WorldSpec {
            controller,
            task,
            ..WorldSpec::miglino1995()
        };
        refused(spec, field, "only with robot.kind = \"forager\"");
    }
    let mut wide = good.clone();
    if let Build::Forager(own) = &mut wide.robot.build {
        own.foraging.nest_radius = 700.0;
    }
    refused(wide, "arena.nest_radius_mm", "is 700");
    let names = [own(Kind::Sensor, &SENSOR.replace("wall", "carries"), &[])];
    refused(
        WorldSpec {
            own: OwnParts::from(names),
            ..good.clone()
        },
        "sensor.part",
        "`carries`",
    );
    assert_eq!(Reported::new(&good).unwrap_err().field, "robot.kind");
}

/// What a forager is made of is closed to a user's parts, as what other robots are made of; it takes no names from those.
#[test]
fn a_foragers_own_functions_are_closed() {
    const TASK: &str = "fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    return Reward(BODY, before);
}
";
    let task = |text: &str| own(Kind::Task, text, &[]);
    let with = |text: &str, spec: WorldSpec| {
        World::new(WorldSpec {
            task: Task::Own,
            own: OwnParts::from([task(text)]),
            ..spec
        })
    };
    let forager = || spec(Foraging::odowd2014(Light::OverNest));
    let own_near = TASK.replace("BODY", "near(1.0f)") + "fn near(x: f32) -> f32 { return x; }\n";
    assert!(with(&own_near, WorldSpec::miglino1995()).is_ok());
    assert!(with(&own_near, forager()).is_ok());
    for (text, expected) in [
        (
            TASK.replace("BODY", "nest_of(0u).x"),
            "own.wgsl:2:19: `nest_of` can't be called from here",
        ),
        (
            TASK.replace("BODY", "first_food(episode).x_first.x"),
            "own.wgsl:2:19: `first_food` can't be called from here",
        ),
        (
            TASK.replace("BODY", "now.brougth"),
            "own.wgsl:2:23: `Experience` has no field `brougth`; allowed: step, start, end, real, perceived, outputs, moved, collided, took, \
             brought, worth, to_nest, to_food; did you mean `brought`? [unknown-name]",
        ),
    ] {
        let invalid = with(&text, forager()).unwrap_err();
        assert_eq!(invalid.field, "task.part");
        assert!(invalid.problem.contains(expected), "{invalid}");
    }
    let named = PHOTOTAXIS.replace("speed", "lamp").replace("SPEED", "LAMP");
    let invalid = World::new(WorldSpec {
        controller: Controller::Own,
        own: OwnParts::from([own(Kind::Controller, &named, &[])]),
        ..forager()
    })
    .unwrap_err();
    assert!(
        invalid
            .problem
            .contains("the constant `LAMP` of `lamp` is a name that Oneiro uses"),
        "{invalid}"
    );
}
