//! Users' sensors, controllers and tasks: composed when the program runs, the same bits on the CPU and a GPU, and refused with
//! file, line and column if anything is wrong.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use oneiro::arena::{Arena, Block, Obstacle};
use oneiro::backend::Specialise;
use oneiro::batch::{self, Batch, Outcome, PartResult, Rollout, Trace, TraceRequest};
use oneiro::compose::{DetailKind, Kind, OwnPart, OwnParts, Part, Rule};
use oneiro::cpu::Cpu;
use oneiro::differential::{Build, Differential};
use oneiro::evaluator::{Control, Device, Error, Evaluator};
use oneiro::foraging::Forager;
use oneiro::random::Key;
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::world::{Controller, Noise, Robot, Task, World, WorldSpec};

/// Equation 1 as the user would write it: what ships, under another name.
const SAME: &str = "
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let moved = now.moved;
    let speed = 0.5f * (abs(moved.left) + abs(moved.right));
    let turning = root(0.5f * abs(moved.left - moved.right));
    let earned = speed * (1.0f - turning) * (1.0f - highest(now.real));
    return Reward(select(earned, 0.0f, now.collided), before);
}
";

/// The shipped perceptron as the user would write it.
const PERCEPTRON: &str = "
const CONTROLLER_GENES: u32 = 2u * (INPUTS + 1u);
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let left = logistic(weighed(episode, 0u, readings) + gene(episode, INPUTS));
    let right = logistic(weighed(episode, INPUTS + 1u, readings) + gene(episode, 2u * INPUTS + 1u));
    return Command(vec2f(left, right), before);
}
";

/// The shipped recurrent controller, with its memory.
const RECURRENT: &str = "
const CONTROLLER_GENES: u32 = 2u * INPUTS + 6u;
struct ControllerState { outputs: vec2<f32> }
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let n = INPUTS;
    let old = before.outputs;
    let left = weighed(episode, 0u, readings) + gene(episode, n) * old.x + gene(episode, n + 1u) * old.y + gene(episode, n + 2u);
    let right = weighed(episode, n + 3u, readings) + gene(episode, 2u * n + 3u) * old.x + gene(episode, 2u * n + 4u) * old.y + gene(episode, 2u * n + 5u);
    let outputs = vec2<f32>(logistic(left), logistic(right));
    return Command(outputs, ControllerState(outputs));
}
";

/// The shipped controller with three hidden units.
const HIDDEN: &str = "
const CONTROLLER_GENES: u32 = 3u * (INPUTS + 3u) + 2u;
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let biases = CONTROLLER_GENES - 2u;
    var sums = vec2<f32>(gene(episode, biases), gene(episode, biases + 1u));
    for (var unit = 0u; unit < 3u; unit++) {
        let first = unit * (INPUTS + 3u);
        let output = logistic(weighed(episode, first, readings) + gene(episode, first + INPUTS));
        sums.x += gene(episode, first + INPUTS + 1u) * output;
        sums.y += gene(episode, first + INPUTS + 2u) * output;
    }
    return Command(vec2<f32>(logistic(sums.x), logistic(sums.y)), before);
}
";
const WRITTEN_AGAIN: [(&str, Controller); 3] = [
    (PERCEPTRON, Controller::Perceptron),
    (HIDDEN, Controller::Hidden { units: 3 }),
    (RECURRENT, Controller::Recurrent),
];

/// Two more sensors: a range finder that looks ahead, and a compass with noise that remembers its last reading.
const SENSORS: &str = "
struct SensorValues {
    range: f32, // 300, 1 to 2000 mm: of the range finder
    noise: f32, // 0.1, 0 to 1: of the compass
}
struct SensorReadings {
    ahead: f32,
    north: f32,
}
struct SensorState { north: f32 }
fn sensor_begin(episode: Episode, pose: vec3f) -> SensorState {
    return SensorState(cosine_sine(pose.z).y);
}
fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    let own = sensor_values(episode);
    let ahead = distance_along(episode, vec2<f32>(pose.x, pose.y), pose.z, own.range) * reciprocal(own.range);
    let noise = own.noise * (random(episode, STREAM_OWN_SENSOR, step, 0u).x - 0.5f);
    let north = 0.5f * (before.north + cosine_sine(pose.z).y) + noise;
    return Sensed(SensorReadings(ahead, north), SensorState(north));
}
";

/// A task that rewards what the sensors read.
const ROOM: &str = "
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    return Reward(now.real.own.ahead + 0.25f * now.perceived.own.north, before);
}
";

/// A task with everything: values, a state of several kinds, a beginning, an end, a score.
const WHOLE: &str = "
struct TaskValues {
    far: f32, // 150, 10 to 1000 mm: distance from the start that ends a life
    bonus: f32, // 5, 0 to 100: what the end earns
    weight_a: f32, // 1, -1 to 1: weight of x
    weight_b: f32, // 0.5, -1 to 1: weight of y
    last: f32, // 0.25, 0 to 1: in a second cell
}
struct TaskState {
    start: vec2<f32>, // where it began
    cycles: u32,
    farthest: f32,
    done: u32,
}
fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
    return TaskState(vec2<f32>(pose.x, pose.y), 0u, 0.0f, 0u);
}
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let own = task_values(episode);
    var next = before;
    let x = now.end.x - before.start.x;
    let y = now.end.y - before.start.y;
    next.cycles += 1u;
    next.farthest = max(before.farthest, root(x * x + y * y));
    next.done = select(0u, 1u, next.farthest > own.far);
    return Reward(own.weight_a * now.moved.left + own.weight_b * now.moved.right + own.last * now.outputs.x, next);
}
fn task_ends(episode: Episode, own: TaskState) -> bool {
    return own.done != 0u;
}
fn task_score(episode: Episode, own: TaskState, sum: f32) -> f32 {
    return sum + own.farthest + f32(own.cycles);
}
";

fn part(kind: Kind, text: &str) -> Arc<Part> {
    Arc::new(Part::new(kind, "own.wgsl", text).unwrap_or_else(|refused| panic!("{refused}")))
}

fn own(kind: Kind, text: &str, values: &[(&str, f64)]) -> OwnPart {
    OwnPart::new(part(kind, text), values).unwrap_or_else(|invalid| panic!("{invalid}"))
}

fn world(text: &str, values: &[(&str, f64)], change: &dyn Fn(&mut WorldSpec)) -> World {
    let mut spec = WorldSpec {
        task: Task::Own,
        own: OwnParts::from([own(Kind::Task, text, values)]),
        noise: Noise::SENSOR,
        cycles: 200,
        ..WorldSpec::miglino1995()
    };
    change(&mut spec);
    World::new(spec).unwrap()
}

/// Genes and keys of many lives, of one batch for each world.
fn batch(world: &World, lives: u32, trace: Option<TraceRequest>) -> Batch {
    let genes: Vec<Vec<f32>> = (0..lives)
        .map(|life| {
            (0..world.genes())
                .map(|gene| ((life * 31 + gene as u32 * 7) % 41) as f32 / 10.0 - 2.0)
                .collect()
        })
        .collect();
    let rollouts: Vec<_> = (0_u64..)
        .zip(&genes)
        .map(|(life, genes)| Rollout {
            world: 0,
            genes,
            key: Key::rollout(7, 0, life, 0),
        })
        .collect();
    Batch::new(std::slice::from_ref(world), &rollouts, trace).unwrap()
}

fn fitness(world: &World) -> Vec<u32> {
    let outcome = Cpu::new(Some(2))
        .unwrap()
        .evaluate(&batch(world, 300, None), &Control::new())
        .unwrap();
    outcome.fitness.iter().map(|fitness| fitness.to_bits()).collect()
}

/// The crate of parts names each file of its folder.
#[test]
fn every_part_is_listed() {
    fn visit(folder: &Path, files: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                visit(&path, files);
            } else if path.extension().is_some_and(|extension| extension == "wgsl") {
                files.push(path);
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders/wgsl");
    let mut files = Vec::new();
    visit(&root, &mut files);
    files.sort();
    let mut listed: Vec<_> = oneiro_shader_parts::PARTS
        .iter()
        .chain(&oneiro_shader_parts::STATE_MACHINE)
        .chain(&oneiro_shader_parts::BEHAVIOUR_TREE[1..])
        .map(|(path, _)| root.join(path))
        .collect();
    listed.sort();
    assert_eq!(listed, files);
}

#[test]
fn the_shipped_task_written_again_has_its_bits() {
    for controller in [
        Controller::Perceptron,
        Controller::Hidden { units: 3 },
        Controller::Recurrent,
    ] {
        let own = world(SAME, &[], &|spec| spec.controller = controller.clone());
        let shipped = World::new(WorldSpec {
            task: Task::AVOIDANCE,
            own: OwnParts::default(),
            ..own.spec().clone()
        })
        .unwrap();
        assert!(own.kernel().variants.is_empty() && !shipped.kernel().variants.is_empty());
        assert_eq!(fitness(&own), fitness(&shipped), "{controller:?}");
    }
    let other = SAME.replace("0.5f * (abs", "0.50001f * (abs");
    let [own, other] = [SAME, &other].map(|text| fitness(&world(text, &[], &|_| {})));
    assert_ne!(own, other, "a changed constant shows");
}

#[test]
fn a_task_has_values_a_state_an_end_and_a_score() {
    let of = |values: &[(&str, f64)]| {
        let world = world(WHOLE, values, &|_| {});
        let outcome = Cpu::new(Some(1)).unwrap();
        let mut cpu = outcome;
        let outcome = cpu
            .evaluate(&batch(&world, 100, Some(TraceRequest { every: 1 })), &Control::new())
            .unwrap();
        (outcome.fitness.clone(), outcome.traces)
    };
    let (fitness, traces) = of(&[]);
    let mut ended = 0;
    for (fitness, trace) in fitness.iter().zip(&traces) {
        let lived = trace.len();
        let start = (trace[0].x, trace[0].y);
        let away = |x: f32, y: f32| ((x - start.0).powi(2) + (y - start.1).powi(2)).sqrt();
        let farthest = trace
            .iter()
            .fold(0.0_f32, |most, record| most.max(away(record.x, record.y)));
        ended += u32::from(lived < 200);
        let earned = trace[lived - 1].fitness;
        let least = earned + farthest + lived as f32;
        // The last cycle's end is not in the trace.
        assert!((least - 0.1..least + 20.0).contains(fitness), "{fitness} {least}");
    }
    assert!((10..90).contains(&ended), "{ended} of 100 lives ended early");
    let (never, _) = of(&[("far", 1000.0)]);
    assert!(never.iter().zip(&fitness).filter(|(a, b)| a != b).count() >= ended as usize);
    let (heavier, _) = of(&[("last", 1.0)]);
    assert_ne!(heavier, fitness);
}

/// Any part may end an episode of a single robot, in each kind of simulator and on each device. Here each counts cycles.
#[test]
fn sensors_controllers_and_tasks_end_episodes_alike() {
    const TASK: &str = "struct TaskState { n: u32 }
        fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
            return Reward(now.outputs.x, TaskState(before.n + 1u));
        }";
    const SENSOR: &str = "struct SensorReadings { constant: f32 }
        struct SensorState { n: u32 }
        fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
            return Sensed(SensorReadings(0.5), SensorState(before.n + 1u));
        }";
    const CONTROLLER: &str = "const CONTROLLER_GENES: u32 = 2u * INPUTS;
        struct ControllerState { n: u32 }
        fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
            let left = logistic(weighed(episode, 0u, readings));
            let right = logistic(weighed(episode, INPUTS, readings));
            return Command(vec2<f32>(left, right), ControllerState(before.n + 1u));
        }";
    let kinds = [
        (Kind::Task, TASK),
        (Kind::Sensor, SENSOR),
        (Kind::Controller, CONTROLLER),
    ];
    let parts_with_end = |ending: Option<Kind>| {
        OwnParts::from(kinds.map(|(kind, text)| {
            let (word, title) = (kind.word(), format!("{kind:?}"));
            let end =
                format!("fn {word}_ends(episode: Episode, memory: {title}State) -> bool {{ return memory.n >= 15u; }}");
            let text = if ending == Some(kind) {
                format!("{text}\n{end}")
            } else {
                text.to_owned()
            };
            own(kind, &text, &[])
        }))
    };
    let described: fn(&mut WorldSpec) = |spec| spec.robot.build = Build::Differential(Differential::new(60.0, 100.0));
    let forager: fn(&mut WorldSpec) = |spec| {
        *spec = WorldSpec {
            own: spec.own.clone(),
            controller: Controller::Own,
            task: Task::Own,
            ..WorldSpec::foraging(Forager::ODOWD2014)
        }
    };
    let mut evaluators = evaluators();
    for change in [|_: &mut WorldSpec| {}, described, surrogate, forager] {
        let world = |ending| {
            let mut spec = WorldSpec {
                controller: Controller::Own,
                task: Task::Own,
                own: parts_with_end(ending),
                ..WorldSpec::miglino1995()
            };
            change(&mut spec);
            spec.cycles = 40;
            World::new(spec).unwrap()
        };
        let mut found = |ending| {
            let batch = batch(&world(ending), 100, Some(TraceRequest { every: 1 }));
            let outcomes = evaluators.iter_mut().flatten().map(|evaluator| {
                let found = evaluator.evaluate(&batch, &Control::new()).unwrap();
                let lived = found.traces.iter().map(|trace| trace.len()).max().unwrap();
                let bits: Vec<u32> = found.fitness.iter().map(|fitness| fitness.to_bits()).collect();
                (lived, bits)
            });
            let outcomes: Vec<_> = outcomes.collect();
            assert!(outcomes.iter().all(|own| *own == outcomes[0]), "{ending:?}");
            outcomes[0].clone()
        };
        let by_task = found(Some(Kind::Task));
        assert_eq!(by_task.0, 15);
        assert!(found(Some(Kind::Sensor)) == by_task);
        assert!(found(Some(Kind::Controller)) == by_task);
        let whole = found(None);
        assert!(whole.0 == 40 && whole.1 != by_task.1);
    }
    for kind in [Kind::Sensor, Kind::Controller] {
        let mut robot = Differential::new(60.0, 100.0);
        robot.count = Some(3);
        let spec = WorldSpec {
            controller: Controller::Own,
            task: Task::Own,
            own: parts_with_end(Some(kind)),
            robot: Robot {
                build: Build::Differential(robot),
                ..WorldSpec::miglino1995().robot
            },
            ..WorldSpec::miglino1995()
        };
        let refused = World::new(spec).unwrap_err();
        let word = kind.word();
        assert_eq!(refused.field, format!("{word}.part"));
        assert!(
            refused
                .problem
                .starts_with(&format!("has `{word}_ends`, which ends only a single robot's episode"))
        );
    }
}

/// A device that shows traces once all have been simulated, as a GPU does.
struct Afterwards(Cpu);

impl Evaluator for Afterwards {
    fn device(&self) -> Device {
        self.0.device()
    }

    fn evaluate_part(&mut self, part: &batch::Part<'_>, control: &Control) -> Result<PartResult, Error> {
        self.0.evaluate_part(part, control)
    }
}

/// An observer is shown the words of traces, also of episodes that end early, however many cycles are simulated at a time.
#[test]
fn an_observer_is_shown_the_traces() {
    let world = world(WHOLE, &[], &|_| {});
    for every in [1, 7, 150] {
        let episodes = batch(&world, 100, Some(TraceRequest { every }));
        let cpu = || Cpu::new(Some(2)).unwrap();
        let whole = cpu().evaluate(&episodes, &Control::new()).unwrap();
        let longest = whole.traces.iter().map(|trace| trace.len()).max().unwrap();
        assert!(whole.traces.iter().any(|trace| trace.len() < longest));
        let devices: [Box<dyn Evaluator>; 3] = [
            Box::new(cpu()),
            Box::new(cpu().with_chunk(10)),
            Box::new(Afterwards(cpu())),
        ];
        for (mut device, number) in devices.into_iter().zip(0..) {
            let shown: Vec<_> = whole.traces.iter().map(|_| Mutex::new(Vec::new())).collect();
            let observe = |episode: usize, words: &[u32]| shown[episode].lock().unwrap().extend_from_slice(words);
            let outcome = device.observe(&episodes, &Control::new(), &observe).unwrap();
            assert!(outcome.traces.is_empty());
            let bits = |fitness: &[f32]| fitness.iter().map(|own| own.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&outcome.fitness), bits(&whole.fitness));
            for (trace, words) in whole.traces.iter().zip(shown) {
                let words = words.into_inner().unwrap();
                assert!(trace.words().eq(words), "device {number}, every {every}");
            }
        }
    }
}

fn surrogate(spec: &mut WorldSpec) {
    spec.noise = Noise::NONE;
    spec.surrogate = Some(Arc::new(Surrogate::drawn(1, Differences::all(1.0))));
}

#[test]
fn surrogates_have_users_parts_too() {
    let [same, shipped] = [
        world(SAME, &[], &surrogate),
        World::new(WorldSpec {
            task: Task::AVOIDANCE,
            own: OwnParts::default(),
            ..world(SAME, &[], &surrogate).spec().clone()
        })
        .unwrap(),
    ];
    assert!(
        same.kernel().name.starts_with("surrogate_perceptron+own-"),
        "{}",
        same.kernel().name
    );
    assert_eq!(fitness(&same), fitness(&shipped));
}

#[test]
fn the_shipped_controllers_written_again_have_their_bits() {
    for (text, controller) in WRITTEN_AGAIN {
        for change in [&|_: &mut WorldSpec| {}, &surrogate as &dyn Fn(&mut WorldSpec)] {
            let mut spec = WorldSpec {
                controller: controller.clone(),
                noise: Noise::SENSOR,
                cycles: 200,
                ..WorldSpec::miglino1995()
            };
            change(&mut spec);
            let shipped = World::new(spec.clone()).unwrap();
            spec.controller = Controller::Own;
            spec.own = OwnParts::from([own(Kind::Controller, text, &[])]);
            let written = World::new(spec).unwrap();
            assert_eq!(written.genes(), shipped.genes());
            assert_eq!(written.gene_layout().names()[3], "gene_3");
            assert_eq!(fitness(&written), fitness(&shipped), "{controller:?}");
        }
    }
}

/// The shipped perceptron with named genes, which it reads by loops.
const NAMED: &str = "
struct ControllerGenes {
    to_left: array<f32, INPUTS>, // weights of the left output
    bias_left: f32, // -0.5 to 2: of the left output
    to_right: array<f32, INPUTS>, // -3 to 3 per unit: weights of the right output
    bias_right: f32,
}
fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    var sums = vec2<f32>(0.0f, 0.0f);
    for (var i = 0u; i < INPUTS; i++) {
        sums.x += gene(episode, TO_LEFT + i) * reading(readings, i);
        sums.y += gene(episode, TO_RIGHT + i) * reading(readings, i);
    }
    let left = logistic(sums.x + gene(episode, BIAS_LEFT));
    return Command(vec2<f32>(left, logistic(sums.y + gene(episode, BIAS_RIGHT))), before);
}
";

/// Names and ranges say nothing of what a controller computes; readings by their index are those by their names.
#[test]
fn genes_are_named_and_have_ranges() {
    let [named, plain] = [NAMED, PERCEPTRON].map(everything);
    assert_eq!(fitness(&named), fitness(&plain));
    let (names, ranges) = (named.gene_layout().names(), named.gene_layout().ranges());
    assert_eq!((names.len(), ranges.len()), (22, 22));
    assert_eq!(
        names[7..13],
        [
            "to_left_back_left",
            "to_left_ahead",
            "to_left_north",
            "bias_left",
            "to_right_left_90",
            "to_right_left_45"
        ]
    );
    assert_eq!((names[21].as_str(), ranges[21]), ("bias_right", None));
    assert!(ranges[..10].iter().all(Option::is_none));
    assert_eq!(ranges[10], Some([-0.5, 2.0]));
    assert!(ranges[11..21].iter().all(|range| *range == Some([-3.0, 3.0])));
    // The length of an array is any constant.
    let counted = |length: &str, genes: usize| {
        let text = format!(
            "const UNITS = 3;
            struct ControllerGenes {{ first: f32, many: array<f32, {length}>, last: f32 }}
            fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {{
                return Command(vec2<f32>(gene(episode, MANY + 1u), gene(episode, LAST)), before);
            }}"
        );
        let names = everything(&text).gene_layout().names();
        assert_eq!(names.len(), genes);
        assert_eq!((names[1].as_str(), names[genes - 1].as_str()), ("many_0", "last"));
        assert_eq!(names[genes - 2], format!("many_{}", genes - 3));
    };
    counted("4", 6);
    counted("UNITS", 5);
    counted("2u * (INPUTS + 1u)", 24);
    counted("u32(UNITS) * INPUTS", 32);
}

#[test]
fn readings_have_an_index() {
    let rewarded = |earned: &str| {
        let task = format!(
            "fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {{
                return Reward({earned}, before);
            }}"
        );
        let mut spec = everything(PERCEPTRON).spec().clone();
        spec.own.insert(Arc::new(own(Kind::Task, &task, &[])));
        fitness(&World::new(spec).unwrap())
    };
    for (index, name) in [
        ("0u", "first.x"),
        ("6u", "last.z"),
        ("8u", "own.ahead"),
        ("9u", "own.north"),
        ("10u + now.step", "own.north"),
    ] {
        for readings in ["now.perceived", "now.real"] {
            let by_name = rewarded(&format!("{readings}.{name}"));
            assert_eq!(
                rewarded(&format!("reading({readings}, {index})")),
                by_name,
                "{readings}.{name}"
            );
        }
    }
}

/// A world with every kind of part.
fn everything(text: &str) -> World {
    World::new(WorldSpec {
        controller: Controller::Own,
        task: Task::Own,
        own: OwnParts::from([
            own(Kind::Sensor, SENSORS, &[("range", 500.0)]),
            own(Kind::Controller, text, &[]),
            own(Kind::Task, ROOM, &[]),
        ]),
        noise: Noise::SENSOR,
        cycles: 200,
        ..WorldSpec::miglino1995()
    })
    .unwrap()
}

#[test]
fn sensors_reach_shipped_and_own_controllers_alike() {
    let sensors = |range: f64| own(Kind::Sensor, SENSORS, &[("range", range)]);
    let shipped = |controller, range| {
        World::new(WorldSpec {
            controller,
            own: OwnParts::from([sensors(range), own(Kind::Task, ROOM, &[])]),
            ..everything(PERCEPTRON).spec().clone()
        })
        .unwrap()
    };
    for ((text, controller), genes) in WRITTEN_AGAIN.into_iter().zip([22, 41, 26]) {
        let (written, shipped) = (everything(text), shipped(controller.clone(), 500.0));
        assert_eq!((written.genes(), shipped.genes()), (genes, genes));
        assert_eq!(shipped.gene_layout().names().len(), genes);
        let bits = fitness(&written);
        assert_eq!(bits, fitness(&shipped), "{controller:?}");
        assert_ne!(bits[0], bits[1]);
    }
    let names = shipped(Controller::Perceptron, 500.0).gene_layout().names();
    assert_eq!(
        names[8..12],
        ["ahead_to_left", "north_to_left", "bias_left", "left_90_to_right"]
    );
    let [far, near] = [500.0, 300.0].map(|range| fitness(&shipped(Controller::Perceptron, range)));
    assert_ne!(far, near, "the range shows");
}

/// Traces have the readings of a user's sensors, and what each part remembers, of every type.
#[test]
fn traces_have_own_readings_and_memory() {
    const TASK: &str = "
    struct TaskState {
        place: vec2<f32>,
        cycles: u32,
        down: vec3<i32>,
    }
    fn task_begin(episode: Episode, pose: vec3<f32>) -> TaskState {
        return TaskState(vec2<f32>(0.0f, 0.0f), 5u, vec3<i32>(0, 0, 0));
    }
    fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
        let down = vec3<i32>(-3, 7, -1 - i32(now.step));
        let place = vec2<f32>(now.perceived.own.ahead, now.end.y);
        return Reward(0.0f, TaskState(place, before.cycles + 1u, down));
    }";
    let world = World::new(WorldSpec {
        task: Task::Own,
        own: OwnParts::from([
            own(Kind::Sensor, SENSORS, &[]),
            own(Kind::Controller, RECURRENT, &[]),
            own(Kind::Task, TASK, &[]),
        ]),
        ..everything(RECURRENT).spec().clone()
    })
    .unwrap();
    let names: Vec<_> = world.details().iter().map(|detail| detail.name.as_str()).collect();
    assert_eq!(names[..2], ["0", "1"]);
    #[rustfmt::skip]
    assert_eq!(
        names[16..],
        ["ahead", "north", "north", "outputs.x", "outputs.y", "place.x", "place.y", "cycles", "down.x", "down.y", "down.z"]
    );
    let kinds = |kind| world.details().iter().filter(|detail| detail.kind == kind).count();
    assert_eq!((kinds(DetailKind::Perceived), kinds(DetailKind::Real)), (10, 8));
    assert_eq!(kinds(DetailKind::Memory(Kind::Task)), 6);
    let batch = batch(&world, 70, Some(TraceRequest { every: 3 }));
    let outcome = Cpu::new(Some(2)).unwrap().evaluate(&batch, &Control::new()).unwrap();
    for trace in &outcome.traces {
        assert_eq!(trace.len(), 67);
        for (index, (record, details)) in trace.lines().enumerate() {
            let float = |word: usize| f32::from_bits(details[16 + word]);
            let memory: Vec<f32> = (2..7).map(float).collect();
            assert_eq!(memory[0], float(1), "the compass remembers its reading");
            assert_eq!(memory[1..3], [record.left, record.right]);
            assert_eq!(memory[3], float(0));
            assert!((memory[4] - record.y).abs() < 10.0);
            let step = 3 * index as u32;
            let whole = &details[23..];
            assert_eq!(whole[..3], [6 + step, (-3_i32).cast_unsigned(), 7]);
            assert_eq!(whole[3].cast_signed(), -1 - step.cast_signed());
        }
    }
}

/// A world with a controller whose commands are these expressions, of which `wild` is not a number.
fn commanded_world(left: &str, right: &str) -> World {
    let text = format!(
        "const CONTROLLER_GENES: u32 = 3u;
        fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {{
            let large = 3e38f * (10.0f + readings.first.x);
            let wild = large - large;
            return Command(vec2<f32>({left}, {right}), before);
        }}"
    );
    let spec = WorldSpec {
        controller: Controller::Own,
        own: OwnParts::from([own(Kind::Controller, &text, &[])]),
        noise: Noise::SENSOR,
        cycles: 100,
        ..WorldSpec::miglino1995()
    };
    World::new(spec).unwrap()
}

fn commanded(left: &str, right: &str) -> Vec<u32> {
    fitness(&commanded_world(left, right))
}

#[test]
fn commands_and_genes_stay_in_their_range() {
    let plain = commanded("1.0f", "0.0f");
    assert_ne!(plain, commanded("0.9f", "0.0f"));
    assert_eq!(plain, commanded("5.0f", "-3.0f"));
    assert_eq!(plain, commanded("3e38f", "wild"));
    // Beyond a controller's genes are those of others.
    let last = commanded("0.5f + 0.2f * gene(episode, 2u)", "0.6f");
    assert_eq!(last, commanded("0.5f + 0.2f * gene(episode, 3u)", "0.6f"));
    assert_eq!(last, commanded("0.5f + 0.2f * gene(episode, 5000u + step)", "0.6f"));
    assert_ne!(last, commanded("0.5f + 0.2f * gene(episode, 1u)", "0.6f"));
}

#[test]
fn readings_stay_in_their_range() {
    let read = |reading: &str| {
        let text = format!(
            "struct SensorReadings {{ only: f32 }}
            fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {{
                let large = 3e38f * (10.0f + pose.z);
                let wild = large - large;
                return Sensed(SensorReadings({reading}), before);
            }}"
        );
        let spec = WorldSpec {
            own: OwnParts::from([own(Kind::Sensor, &text, &[])]),
            cycles: 100,
            ..WorldSpec::miglino1995()
        };
        fitness(&World::new(spec).unwrap())
    };
    assert_eq!(read("1000.0f"), read("3e37f"));
    assert_eq!(read("0.0f"), read("wild"));
    assert_ne!(read("0.0f"), read("0.25f"));
}

/// Distances along rays, against the same in double precision, for walls, round obstacles and blocks.
#[test]
fn rays_end_at_the_nearest_object() {
    let arena = Arena {
        obstacles: vec![Obstacle {
            x: 300.0,
            y: 250.0,
            radius: 40.0,
            class: "round".into(),
        }],
        blocks: vec![Block {
            x: 150.0,
            y: 120.0,
            length: 80.0,
            width: 40.0,
            heading: 0.1,
            class: "wall".into(),
        }],
        ..Arena::rectangle(500.0, 400.0)
    };
    let sensor = "
struct SensorReadings { ahead: f32 }
fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {
    let heading = 0.02f + f32(step) * 0.013f;
    return Sensed(SensorReadings(distance_along(episode, vec2<f32>(210.0f, 190.0f), heading, 250.0f)), before);
}";
    let task = "
struct TaskState { all: f32 }
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    return Reward(now.real.own.ahead, TaskState(now.real.own.ahead));
}
fn task_score(episode: Episode, own: TaskState, sum: f32) -> f32 { return own.all; }";
    let mut met = [0_u32; 4];
    for step in 0..77_u32 {
        let world = World::new(WorldSpec {
            arena: arena.clone(),
            task: Task::Own,
            own: OwnParts::from([own(Kind::Sensor, sensor, &[]), own(Kind::Task, task, &[])]),
            cycles: step + 1,
            ..WorldSpec::miglino1995()
        })
        .unwrap();
        let measured = f32::from_bits(fitness(&world)[0]);
        let angle = (0.02 + f64::from(step) * 0.013) * std::f64::consts::TAU;
        let (expected, object) = nearest((210.0, 190.0), angle);
        met[object] += 1;
        assert!(
            (f64::from(measured) - expected).abs() < 2e-3,
            "step {step}: {measured} {expected}"
        );
    }
    assert!(met.iter().all(|count| *count > 0), "{met:?}");
}

/// The distance from a point to the nearest object of the test above, by small steps; and which it is: nothing, a wall, the
/// obstacle or the block.
fn nearest((x, y): (f64, f64), angle: f64) -> (f64, usize) {
    let object = |distance: f64| {
        let (x, y) = (x + distance * angle.cos(), y + distance * angle.sin());
        let turn = 0.1 * std::f64::consts::TAU;
        let (from_x, from_y) = (x - 150.0, y - 120.0);
        let along = from_x * turn.cos() + from_y * turn.sin();
        let across = from_y * turn.cos() - from_x * turn.sin();
        if !(0.0..=500.0).contains(&x) || !(0.0..=400.0).contains(&y) {
            1
        } else if (x - 300.0).hypot(y - 250.0) < 40.0 {
            2
        } else if along.abs() < 40.0 && across.abs() < 20.0 {
            3
        } else {
            0
        }
    };
    let steps = (0..250_000_u32).map(|step| f64::from(step) * 1e-3);
    let hit = steps
        .map(|distance| (distance, object(distance)))
        .find(|(_, object)| *object != 0);
    hit.unwrap_or((250.0, 0))
}

/// Long lives in many dispatches keep the task's state.
#[test]
fn dispatches_cut_a_life_without_a_trace() {
    let world = world(WHOLE, &[("far", 400.0)], &|_| {});
    let whole = fitness(&world);
    let mut cut = Cpu::new(Some(1)).unwrap().with_chunk(7);
    let outcome = cut.evaluate(&batch(&world, 300, None), &Control::new()).unwrap();
    let cut: Vec<u32> = outcome.fitness.iter().map(|fitness| fitness.to_bits()).collect();
    assert_eq!(whole, cut);
}

/// So a processor that kernels can't be compiled for has the same results.
#[test]
fn the_interpreter_has_the_same_bits() {
    for world in [everything(RECURRENT), world(WHOLE, &[], &|_| {})] {
        let batch = batch(&world, 40, Some(TraceRequest { every: 3 }));
        let lived = |mut cpu: Cpu| {
            let outcome = cpu.evaluate(&batch, &Control::new()).unwrap();
            let words: Vec<_> = outcome.traces.iter().flat_map(Trace::words).collect();
            (
                outcome
                    .fitness
                    .iter()
                    .map(|fitness| fitness.to_bits())
                    .collect::<Vec<_>>(),
                words,
            )
        };
        let interpreted = lived(Cpu::new(Some(2)).unwrap().with_variant("interpretedx1").unwrap());
        assert!(interpreted == lived(Cpu::new(Some(2)).unwrap()));
    }
}

/// Evaluators with kernels for any world, and with kernels for the world at hand.
fn evaluators() -> Vec<[Box<dyn Evaluator>; 2]> {
    let cpu = |when| Box::new(Cpu::new(Some(2)).unwrap().with_specialise(when)) as Box<dyn Evaluator>;
    #[cfg_attr(not(feature = "gpu"), expect(unused_mut, reason = "no GPU is added"))]
    let mut evaluators = vec![[Specialise::Never, Specialise::Always].map(cpu)];
    #[cfg(feature = "gpu")]
    evaluators.push([Specialise::Never, Specialise::Always].map(|when| {
        let mut gpu = oneiro::gpu::Gpu::open(&oneiro::gpu::Choice::Best).unwrap();
        gpu.set_specialise(when);
        Box::new(gpu) as Box<dyn Evaluator>
    }));
    evaluators
}

#[test]
fn gpus_and_kernels_for_one_world_have_the_same_bits() {
    let mut evaluators = evaluators();
    for world in [
        world(SAME, &[], &|_| {}),
        world(WHOLE, &[], &|_| {}),
        everything(PERCEPTRON),
        everything(RECURRENT),
        everything(NAMED),
        commanded_world("5.0f", "wild"),
    ] {
        let batch = batch(&world, 2_000, Some(TraceRequest { every: 20 }));
        let bits = |fitness: &[f32]| fitness.iter().copied().map(f32::to_bits).collect::<Vec<_>>();
        let words = |traces: &[Trace]| traces.iter().flat_map(Trace::words).collect::<Vec<_>>();
        let mut expected: Option<Outcome> = None;
        for (evaluator, steps) in evaluators
            .iter_mut()
            .flat_map(|pair| pair.iter_mut().zip([0, batch.steps()]))
        {
            let before = evaluator.specialised_steps();
            let found = evaluator.evaluate(&batch, &Control::new()).unwrap();
            let own = evaluator.specialised_steps() - before;
            assert_eq!(own, steps, "{:?}", evaluator.warnings());
            let expected = expected.get_or_insert_with(|| found.clone());
            assert_eq!(bits(&expected.fitness), bits(&found.fitness));
            assert!(
                words(&expected.traces) == words(&found.traces),
                "{}",
                world.kernel().name
            );
        }
    }
}

/// What `refusal` says of a part that isn't refused.
const TAKEN: &str = "it is taken";

/// The reasons why a part is refused, when it is read or when a world is made of it.
fn refusal(kind: Kind, text: &str) -> String {
    let part = match Part::new(kind, "own.wgsl", text) {
        Ok(part) => OwnPart::new(Arc::new(part), &[]).unwrap(),
        Err(refused) => return refused.to_string(),
    };
    let mut spec = WorldSpec {
        own: OwnParts::from([part]),
        ..WorldSpec::miglino1995()
    };
    match kind {
        Kind::Sensor => {}
        Kind::Controller => spec.controller = Controller::Own,
        Kind::Task => spec.task = Task::Own,
    }
    World::new(spec).map_or_else(|invalid| invalid.problem, |_| TAKEN.to_owned())
}

#[test]
fn mistakes_are_refused_with_their_place() {
    let cycle = "fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward { return Reward(0.0f, before); }";
    let first = |statement: &str| SAME.replace("let moved =", &format!("{statement} let moved ="));
    let cases = [
        (
            "fn reward() {}".to_owned(),
            "own.wgsl: has no function `task_cycle`; write `fn task_cycle(episode: Episode",
        ),
        (
            SAME.replace("episode", "life").replace("Episode", "Life"),
            "own.wgsl:2:21: `Life` is now `Episode`; rename it in the whole file [unknown-name]",
        ),
        (
            format!("struct Life {{ x: f32 }}\nfn older(life: Life) -> f32 {{ return life.x; }}\n{cycle}"),
            TAKEN,
        ),
        (
            SAME.replace("now: Experience", "now: u32"),
            "own.wgsl:2:4: `task_cycle` has other parameters or another result; write `fn task_cycle(episode: Episode, now: Exp",
        ),
        (
            SAME.replace("1.0f - turning", "quantizeToF16(turning)"),
            "own.wgsl:6:27: `quantizeToF16` is not on the list of functions that are exact on every device; write its arg",
        ),
        (
            SAME.replace("root(0.5f *", "sqrt(0.5 *"),
            TAKEN,
        ),
        (
            SAME.replace("root(0.5f *", "root(cos(0.5) *"),
            "own.wgsl:5:24: `cos` of a constant would be computed by the machine that compiles; write its value, or `let x = ..;` and `cos(x)`",
        ),
        (
            SAME.replace("let moved = now.moved;", "let moved = now.mood;"),
            "own.wgsl:3:21: `Experience` has no field `mood`; allowed: step, start, end",
        ),
        (
            first("fitness[0] = 1.0f;"),
            "own.wgsl:3:5: `fitness` is one of the kernel's buffers",
        ),
        (
            first("//\rfitness[0] = 1.0f;\n"),
            "`fitness` is one of the kernel's buffers",
        ),
        (
            first("//\u{2028}fitness[0] = 1.0f;\n"),
            "own.wgsl:3:7: the character U+2028, a line separator; allowed outside of comments: ASCII",
        ),
        (first("if 0X2E+2 > 1 {}"), TAKEN),
        (
            first("if 0X2E+inputs[0] > 1u {}"),
            "`inputs` is one of the kernel's buffers",
        ),
        (
            first("let steps = dispatch.step_end;"),
            "`dispatch` is one of the kernel's buffers",
        ),
        (
            first("if blocked(Episode(1u, episode.key, 0u), vec2f(0.0f, 0.0f)) { }"),
            "own.wgsl:3:16: `Episode` can't be called from here; allowed: reciprocal, root",
        ),
        (
            first("let other = episode.world + 1u;"),
            "own.wgsl:3:25: `.world` of an episode is only for the kernel",
        ),
        (
            first("let cell = cell_at(0u, vec2f(0.0f, 0.0f));"),
            "own.wgsl:3:16: `cell_at` can't be called from here; allowed: reciprocal, root",
        ),
        (
            format!("@group(0) @binding(9) var<storage, read_write> mine: array<u32>;\n{cycle}"),
            "own.wgsl:1:48: declares a buffer or a global variable; allowed: structs, constants and functions",
        ),
        (
            format!("var<private> mine: u32;\n{cycle}"),
            "own.wgsl:1:14: declares a buffer or a global variable",
        ),
        (
            format!("fn task_kept(own: TaskState) -> TaskState {{ return own; }}\n{cycle}"),
            "own.wgsl:1:4: `task_kept` is a name that Oneiro uses; choose another",
        ),
        (
            format!("fn within(x: f32) -> f32 {{ return x; }}\n{cycle}"),
            TAKEN,
        ),
        (
            format!("fn random(x: f32) -> f32 {{ return x; }}\n{cycle}"),
            "own.wgsl:1:4: `random` is a name that Oneiro uses; choose another",
        ),
        (
            format!("struct vec2f {{ x: f32 }}\n{cycle}"),
            "own.wgsl:1:8: `vec2f` shadows a WGSL built-in",
        ),
        (
            format!("struct TaskState {{ on: bool }}\n{cycle}"),
            "own.wgsl:1:20: in `TaskState`: `on`: bool can't be kept",
        ),
        (
            format!("struct TaskValues {{\n  a: f32,\n}}\n{cycle}"),
            "own.wgsl:2:3: in `TaskValues`: `a`: has no comment that says which values are allowed; write `a: f32, // DEFAULT",
        ),
        (
            format!("struct TaskValues {{\n  a: f32, // 3, 0 to 10 mm\n}}\n{cycle}"),
            "`a`: its comment lacks its end, a colon and the value's meaning; write `a: f32, // DEFAULT",
        ),
        (
            format!("struct TaskValues {{\n  a: f32, // 3, 10 to 0 mm: far\n}}\n{cycle}"),
            "`a`: its range begins with 10, which is above 0",
        ),
        (
            format!("struct TaskValues {{\n  a: f32, // 3, 0-10 mm: far\n}}\n{cycle}"),
            "`a`: its range `0-10 mm` is not `LEAST to GREATEST`",
        ),
        (
            format!("struct TaskState {{\n  float found;\n}}\n{cycle}"),
            "own.wgsl:2:9: `float found` declares nothing in WGSL; write `found: f32,`",
        ),
        (
            format!("struct TaskState {{\n  found: f32;\n}}\n{cycle}"),
            "own.wgsl:2:3: in `TaskState`: `found`: a field ends with a comma; write `found: f32,`",
        ),
        (
            cycle.replace("task_cycle", "task_cylce"),
            "own.wgsl:1:4: there is no function `task_cycle`; did you mean `task_cycle` by `task_cylce`?",
        ),
        (
            "fn mission_cylce(episode: Episode, step: u32, before: MissionState) -> Tally { return Tally(0.0f, before); }"
                .to_owned(),
            "own.wgsl:1:4: there is no function `task_cycle`; did you mean `mission_cycle` by `mission_cylce`?",
        ),
        (
            "fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed { }".to_owned(),
            "own.wgsl: is a sensor, not a task: it has `sensor_cycle`; name it in `sensor.part`",
        ),
        (
            first("let found = before.found;"),
            "`TaskState` has no fields, since the part doesn't declare it; write `struct TaskState { found: f32, }`",
        ),
        (
            format!("struct TaskValues {{\n  a: f32, // 3, 0 to 2: more\n}}\n{cycle}"),
            "the default is 3; allowed: 0 to 2",
        ),
        (
            first("for (var i = 0u; i < u32(now.step * now.step); i += 0u) {}"),
            "own.wgsl:3:5: in `task_cycle`: this loop has no bound known before it runs",
        ),
        (
            first("var i = 0u; let stale = i; for (; stale < 10u; i++) {}"),
            "own.wgsl:3:32: in `task_cycle`: this loop has no bound known before it runs",
        ),
        (
            format!("{cycle}\n@compute @workgroup_size(64) fn main() {{}}"),
            "own.wgsl:2:33: `main` is a name that Oneiro uses",
        ),
        (format!("{cycle} fn ,"), "own.wgsl:1:"),
        (
            first("let x = now.real[now.step];"),
            "own.wgsl:3:17: readings have names, and no index; write `reading(now.real, i)` [indexed-arrays]",
        ),
        (
            first("let seen = now.perceived; let x = seen[0];"),
            "own.wgsl:3:39: readings have names, and no index; write `reading(seen, i)` [indexed-arrays]",
        ),
        (
            first("let seen: Readings = now.real; let x = seen[now.step];"),
            "own.wgsl: an index follows what is neither an array nor a vector; fields have names, and readings `reading(",
        ),
        (first("var real = array<f32, 2>(1.0f, 2.0f); real[0] = real[1];"), TAKEN),
        (
            first("let x = mix(0, 1, 0.5);"),
            "none of the numbers that a function is given here has a type; write one as `0.5f`",
        ),
    ];
    let cases = cases.into_iter().map(|(text, message)| (Kind::Task, text, message));
    let controller = [
        (
            RECURRENT.replace("2u * INPUTS + 6u", "0u"),
            "own.wgsl:2:7: `CONTROLLER_GENES` isn't a number of genes; write `const",
        ),
        (
            RECURRENT.replace("2u * INPUTS + 6u", "65537u"),
            "`const CONTROLLER_GENES: u32 = NUMBER;`, 1 to 65536",
        ),
        (
            RECURRENT.replace("CONTROLLER_GENES", "GENES"),
            "own.wgsl: has no `CONTROLLER_GENES`; write `const CONTROLLER_GENES",
        ),
        (
            RECURRENT.replace("old = before.outputs", "old = before.outputs.z"),
            "own.wgsl:6:",
        ),
    ];
    let named = |fields: &str| {
        let genes = NAMED.find("fn ").unwrap();
        format!("struct ControllerGenes {{\n{fields}\n}}\n{}", &NAMED[genes..])
    };
    let all = "to_left: array<f32, INPUTS>,\nto_right: array<f32, INPUTS>,\nbias_left: f32,\nbias_right: f32";
    let with = |field: &str| named(&format!("{field},\n{all}"));
    let of_genes = [
        (named(all), TAKEN),
        (with("a: f32, // of it"), TAKEN),
        (with("a: f32, // -1e6 to 1e6 mm: of it"), TAKEN),
        (
            with("a: u32"),
            "own.wgsl:2:1: in `ControllerGenes`: `a`: isn't an f32 or an array of them, such as `array<f32, INPUTS>`; write `a: f32, // LEAST",
        ),
        (
            with("a: array<f32>"),
            "own.wgsl:2:1: in `ControllerGenes`: `a`: isn't an f32 or an array",
        ),
        (with("A: f32"), "`A`: its name is not letters from a to z"),
        (
            with("lanes: f32"),
            "own.wgsl:2:1: in `ControllerGenes`: the constant `LANES` of `lanes` is a name that Oneiro uses",
        ),
        (
            with("a: f32, // 1 to 0: of it"),
            "`a`: its range begins with 1, which is above 0",
        ),
        (with("a: f32, // 0 to 1"), "`a`: its comment begins with a number"),
        (
            with("a: f32, // -1: of it"),
            "`a`: its range `-1` is not `LEAST to GREATEST`",
        ),
        (
            with("a: f32, // 0 to 2e6: of it"),
            "`a`: an end of its range is 2000000; allowed: -1000000 to 1000000",
        ),
        (
            with("a: f32, // 0 to 1e-9: of it"),
            "`a`: an end of its range is 1e-9; allowed: 0, or",
        ),
        (
            with("a: f32, // 1 to 1: of it"),
            "`a`: its range has one value, 1; make it a constant",
        ),
        (
            with("a: array<f32, 65536>"),
            "own.wgsl:1:8: `ControllerGenes` has more than 65536 genes; allowed: 1 to 65536",
        ),
        (with("a: array<f32, MANY>"), "own.wgsl:2:"),
        (
            with("to_left_left_90: f32"),
            "own.wgsl:3:1: in `ControllerGenes`: `to_left`: another gene is also called `to_left_left_90`",
        ),
        (with("a: f32") + "const A: u32 = 1u;", "`A` is a name that Oneiro uses"),
        (
            named(all) + "const CONTROLLER_GENES: u32 = 3u;",
            "`CONTROLLER_GENES` is the number of genes that `ControllerGenes` names; leave it out",
        ),
        (
            named(""),
            "own.wgsl: has no `CONTROLLER_GENES`; write `const CONTROLLER_GENES: u32 = NUMBER;`, or name the genes: `struct ControllerGenes",
        ),
        (
            NAMED.replace("reading(readings, i);\n        sums.y", "readings[i];\n        sums.y"),
            "own.wgsl:11:48: readings have names, and no index; write `reading(readings, i)` [indexed-arrays]",
        ),
    ];
    let controller = controller.into_iter().chain(of_genes).chain([
        (
            RECURRENT.replace("const CONTROLLER_GENES: u32", "const CONTROLLER_GENES"),
            "own.wgsl:2:7: `CONTROLLER_GENES` is declared otherwise; write `const CONTROLLER_GENES: u32 = NUMBER;`",
        ),
        (
            RECURRENT.replace("let outputs", "var next = before; increase(&next.outputs); let outputs")
                + "fn increase(p: ptr<function, vec2<f32>>) { *p += 1.0f; }",
            "own.wgsl:9:24: in `controller_cycle`: a pointer to a part of a variable can't be passed",
        ),
        (
            RECURRENT.replace("ControllerState(outputs)", "ControllerState(outputs, 1.0f)"),
            "own.wgsl:10:",
        ),
        (format!("\u{feff}{RECURRENT}"), TAKEN),
    ]);
    let sensor = [
        (
            SENSORS.replace("ahead: f32", "ahead: u32"),
            "own.wgsl:7:5: in `SensorReadings`: `ahead` isn't an f32",
        ),
        (
            SENSORS.replace("    ahead: f32", "    left_90: f32"),
            "own.wgsl:7:5: in `SensorReadings`: `left_90` is a name of a shipped reading",
        ),
        (
            SENSORS.replace("SensorReadings", "Seen"),
            "own.wgsl: has no `SensorReadings`; write `struct SensorReadings",
        ),
        (
            SENSORS.replace("let own =", "let x = gene(episode, 0u); let own ="),
            "`gene` can't be called from here",
        ),
    ];
    let others = controller.map(|(text, message)| (Kind::Controller, text, message));
    let others = others
        .into_iter()
        .chain(sensor.map(|(text, message)| (Kind::Sensor, text, message)));
    let mut problems = Vec::new();
    for (kind, text, message) in cases.chain(others) {
        let refused = refusal(kind, &text);
        if !refused.contains(message) {
            problems.push(format!("{text}\n{refused}\nexpected: {message}"));
        }
        if message != TAKEN {
            broken(&refused);
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n\n"));
}

/// The rules that the lines of a refusal end with.
fn broken(refused: &str) -> Vec<Rule> {
    let rule = |line: &str| {
        let name = line.strip_suffix(']').and_then(|line| line.rsplit_once('['));
        let known = name.and_then(|(_, name)| Rule::ALL.iter().find(|rule| rule.name() == name));
        *known.unwrap_or_else(|| panic!("no rule ends `{line}`"))
    };
    refused.lines().map(rule).collect()
}

/// The smallest task.
const NOTHING: &str =
    "fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward { return Reward(0.0f, before); }\n";

/// An example of a rule as a whole part.
fn whole(example: &str) -> (Kind, String) {
    let kinds = [Kind::Sensor, Kind::Controller, Kind::Task];
    let has_cycle = |kind: &Kind| example.contains(&format!("fn {}_cycle", kind.word()));
    match kinds.into_iter().find(has_cycle) {
        Some(kind) => (kind, example.to_owned()),
        None => (Kind::Task, format!("{example}{NOTHING}")),
    }
}

#[test]
fn each_rule_refuses_its_wrong_example_and_takes_its_right_one() {
    let refused = |example: &str| {
        let (kind, text) = whole(example);
        refusal(kind, &text)
    };
    let (mut without, mut problems) = (Vec::new(), Vec::new());
    for rule in Rule::ALL {
        let Some([wrong, right]) = rule.examples() else {
            without.push(*rule);
            continue;
        };
        let [wrong, right] = [refused(wrong), refused(right)];
        if wrong == TAKEN || broken(&wrong).iter().any(|own| own != rule) || right != TAKEN {
            problems.push(format!("{rule}:\nwrong: {wrong}\nright: {right}"));
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n\n"));
    assert_eq!(without, [Rule::Internal]);
}

#[test]
fn rules_have_short_names_of_their_own() {
    let is_short = |name: &str| name.len() <= 20 && name.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'-');
    let mut names: Vec<_> = Rule::ALL.iter().map(|rule| rule.name()).collect();
    assert!(names.iter().all(|name| is_short(name)), "{names:?}");
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), Rule::ALL.len());
    assert!(
        Rule::ALL
            .iter()
            .all(|rule| rule.about().ends_with('.') && rule.why().ends_with('.'))
    );
}

/// The places of a refusal's lines: line and column.
fn places(refused: &str) -> Vec<String> {
    let place = |line: &str| {
        line.trim_start_matches("own.wgsl:")
            .split(": ")
            .next()
            .unwrap_or_default()
            .to_owned()
    };
    refused.lines().map(place).collect()
}

#[test]
fn all_that_is_wrong_is_refused_at_once() {
    // What declarations show, and what the text shows besides.
    let declared = "struct TaskValues {
    a: f32, // none
    b: u32, // 1, 0 to 2: of it
}
struct TaskState { on: bool, many: array<f32, 3> }
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let other = fitness[episode.world] + fitness[episode.genes] + 0.5;
    return Reward(sqrt(other) + touches(0u, now.end.xy), before);
}
fn within() {}
";
    let refused = refusal(Kind::Task, declared);
    assert_eq!(
        places(&refused),
        ["2:5", "3:5", "5:20", "5:30", "7:17", "7:33", "7:42", "7:58", "8:33"],
        "{refused}"
    );
    // What shows when parts are compiled.
    let compiled = "fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var sum = now.end.x / 3e-40;
    while (sum > 1.0f) { sum *= 0.5; }
    var a = array<f32, 2>(1.0f, 2.0f);
    let i = u32(now.end.x);
    return Reward(sum + a[i & 1u], before);
}
";
    let refused = refusal(Kind::Task, compiled);
    let expected = [("2:27", Rule::FiniteConstants), ("3:5", Rule::LoopWithoutBound)];
    assert_eq!(places(&refused), expected.map(|(place, _)| place), "{refused}");
    assert_eq!(broken(&refused), expected.map(|(_, rule)| rule));
}

#[test]
fn misspelt_names_are_answered_with_the_nearest() {
    let task = |statement: &str| {
        format!(
            "const GREATEST: f32 = 2.0f;
            fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {{
                let distance = now.end.x; {statement}
                return Reward(twice_of(distance), before);
            }}
            fn twice_of(x: f32) -> f32 {{ let inner = x; return GREATEST * inner; }}"
        )
    };
    for (statement, words) in [
        (
            "_ = recirpocal(distance);",
            "there is no function `recirpocal`; did you mean `reciprocal`? [unknown-name]",
        ),
        (
            "_ = twice_off(distance);",
            "there is no function `twice_off`; did you mean `twice_of`?",
        ),
        (
            "_ = flor(distance);",
            "there is no function `flor`; did you mean `floor`?",
        ),
        ("_ = twice_of(distanse);", "`distanse`; did you mean `distance`?"),
        ("_ = GREATES;", "did you mean `GREATEST`?"),
        ("_ = STREAM_TASKS;", "did you mean `STREAM_TASK`?"),
        (
            "_ = now.colided;",
            "`Experience` has no field `colided`; allowed: step, start, end, real, perceived, outputs, moved, collided; did \
             you mean `collided`? [unknown-name]",
        ),
        (
            "_ = something_else(distance);",
            "there is no function `something_else` [unknown-name]",
        ),
        // What is declared elsewhere is not what was meant, unless the function is given it.
        ("_ = moved;", "`moved`; did you mean `now.moved`?"),
        (
            "_ = now.outputs.left;",
            "own.wgsl:3:59: `now.outputs` is a vec2<f32> and has no `left`; allowed: x, y [unknown-name]",
        ),
        ("_ = inner;", "`inner` [unknown-name]"),
    ] {
        let refused = refusal(Kind::Task, &task(statement));
        assert!(refused.contains(words), "{refused}\nexpected: {words}");
        assert_eq!(broken(&refused), [Rule::UnknownName]);
    }
}

/// What is said of a task beside the sensors `SENSORS`, with a statement in its cycle.
fn beside_sensors(build: Build, statement: &str) -> String {
    let task = format!(
        "struct TaskState {{ energy: f32, meals: u32 }}
        fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {{
            var next = before; let nose: vec2<f32> = now.outputs; let seen = now.perceived;
            {statement}
            return Reward(0.0f, next);
        }}"
    );
    let sensors = Part::new(Kind::Sensor, "sensors.wgsl", SENSORS).unwrap();
    let sensors = OwnPart::new(Arc::new(sensors), &[]).unwrap();
    let mut spec = WorldSpec {
        task: Task::Own,
        own: OwnParts::from([sensors, own(Kind::Task, &task, &[])]),
        ..WorldSpec::miglino1995()
    };
    spec.robot.build = build;
    let refused = World::new(spec);
    refused.map_or_else(|invalid| invalid.problem, |_| TAKEN.to_owned())
}

#[test]
fn fields_that_there_are_not_are_answered_with_those_that_there_are() {
    const EXPERIENCE: &str =
        "`Experience` has no field `{}`; allowed: step, start, end, real, perceived, outputs, moved, collided";
    let experience = |field: &str| EXPERIENCE.replace("{}", field);
    for (expression, message) in [
        // A variable that has a similar name is none of the fields.
        ("now.pose.xy", experience("pose")),
        ("now.own.ahead", experience("own") + "; did you mean `now.real.own`?"),
        (
            "now.real.ahead",
            "`Readings` has no field `ahead`; allowed: first, last, own; did you mean `now.real.own.ahead`?".into(),
        ),
        (
            "seen.own.ahed",
            "`SensorReadings` has no field `ahed`; allowed: ahead, north; did you mean `ahead`?".into(),
        ),
        (
            "next.enery",
            "`TaskState` has no field `enery`; allowed: energy, meals; did you mean `energy`?".into(),
        ),
        ("nose.z", "`nose` is a vec2<f32> and has no `z`; allowed: x, y".into()),
        (
            "sensor_values(episode).nois",
            "invalid field accessor `nois`; did you mean `noise`?".into(),
        ),
    ] {
        let refused = beside_sensors(Build::Sampled, &format!("_ = {expression};"));
        let (_, found) = refused.split_once(": ").unwrap();
        assert_eq!(found, format!("{message} [unknown-name]"), "{expression}");
    }
    // No type is what it is made of, however names are repeated.
    let circular = "let a = b.x; let b = a.y; _ = a.z;";
    assert!(beside_sensors(Build::Sampled, circular).contains("nothing declares `b`"));
    // Nor is one looked up by a long chain.
    let chain: Vec<String> = (1..5_000).map(|at| format!("let n{at} = n{};", at - 1)).collect();
    let chain = format!("let n0 = now; {} _ = n4999.pose;", chain.concat());
    assert!(beside_sensors(Build::Sampled, &chain).contains("invalid field accessor `pose`"));
    let described = Build::Differential(Differential::new(60.0, 100.0));
    assert_eq!(
        beside_sensors(described, "_ = now.real.first;"),
        "own.wgsl:4:26: `Readings` has no field `first`; allowed: own; a parametric robot has no `first` and `last` \
         [unknown-name]"
    );
}

#[test]
fn misspelt_functions_are_refused() {
    let cycle = "fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward { return Reward(0.0f, before); }";
    let misspelt = |head: &str| format!("{cycle}\n{head}");
    let refused = refusal(
        Kind::Task,
        &misspelt("fn task_end(episode: Episode, own: TaskState) -> bool { return true; }"),
    );
    assert_eq!(
        refused,
        "own.wgsl:2:4: nothing calls `task_end`; allowed: task_cycle, task_begin, task_ends, task_score, which Oneiro calls, \
         and functions that a part calls or whose names don't begin with `task_`; did you mean `task_ends`? \
         [uncalled-function]"
    );
    for (head, end) in [
        ("fn task_beginn() {}", "did you mean `task_begin`? [uncalled-function]"),
        (
            "fn sensor_ends() {}",
            "nothing calls `sensor_ends` here; allowed: in the file of `sensor.part` [uncalled-function]",
        ),
        (
            "fn sensor_start() {}",
            "names don't begin with `sensor_` [uncalled-function]",
        ),
        (
            "fn controller_begins() {}",
            "did you mean `controller_begin`? [uncalled-function]",
        ),
    ] {
        assert!(refusal(Kind::Task, &misspelt(head)).ends_with(end), "{head}");
    }
    // What another part calls is no mistake.
    let called =
        cycle.replace("0.0f", "task_speed(now)") + "fn task_speed(now: Experience) -> f32 { return now.moved.left; }";
    assert_eq!(refusal(Kind::Task, &called), TAKEN);
    let shared = misspelt("fn task_place() -> f32 { return 1.0f; }");
    let sensors = SENSORS.replace("let own =", "let place = task_place(); let own =");
    let together = [own(Kind::Sensor, &sensors, &[]), own(Kind::Task, &shared, &[])];
    let spec = WorldSpec {
        task: Task::Own,
        own: OwnParts::from(together),
        ..WorldSpec::miglino1995()
    };
    assert!(World::new(spec).is_ok());
}

#[test]
fn commas_and_braces_that_are_missing_are_named() {
    let task = |fields: &str, end: &str| {
        format!(
            "struct TaskState {{ {fields} }}
fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {{
    if now.collided {{ return Reward(-1.0f, before);{end}
    return Reward(0.0f, before);
}}
fn task_ends(episode: Episode, own: TaskState) -> bool {{ return false; }}"
        )
    };
    for (text, message) in [
        (
            task("energy: f32\n    meals: u32", "}"),
            "own.wgsl:1:20: in `TaskState`: `energy`: a comma is missing after its type; write `energy: f32,` [valid-wgsl]",
        ),
        (
            task("energy: f32", ""),
            "own.wgsl:6:1: a `}` is missing before this: a `{` of line 2 or below is still open [valid-wgsl]",
        ),
        (
            task("energy: f32", "}}"),
            "own.wgsl:5:1: this `}` closes nothing; leave it out [valid-wgsl]",
        ),
        (
            task("energy: f32", "}").trim_end_matches('}').to_owned(),
            "own.wgsl:6:71: a `}` is missing before this: a `{` of line 6 or below is still open [valid-wgsl]",
        ),
    ] {
        assert_eq!(refusal(Kind::Task, &text), message);
    }
    let values = "struct TaskValues {
    a: f32 // 1, 0 to 2: of it
    b: f32, // 1, 0 to 2: of it
}";
    assert!(
        refusal(Kind::Task, &format!("{values}{}", task("energy: f32", "}"))).starts_with(
            "own.wgsl:2:5: in `TaskValues`: `a`: a comma is missing after its type; write `a: f32,` [valid-wgsl]"
        )
    );
    let readings = SENSORS.replace("ahead: f32,", "ahead: f32");
    assert_eq!(
        refusal(Kind::Sensor, &readings),
        "own.wgsl:7:5: in `SensorReadings`: `ahead`: a comma is missing after its type; write `ahead: f32,` [valid-wgsl]"
    );
}

#[test]
fn no_part_reads_the_memory_of_another() {
    const NO_MEMORY: &str = "no part can read another's memory; make what is shared a reading of the sensors, and read it as \
        `now.real.own.NAME` in a task or as `readings.own.NAME` in a controller";
    let asked = |call: &str| beside_sensors(Build::Sampled, &format!("_ = {call};"));
    assert_eq!(
        asked("sensor_state(episode)"),
        format!("own.wgsl:4:17: there is no function `sensor_state`; {NO_MEMORY} [unknown-name]")
    );
    let part = "fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let other = sensor_begin(episode, now.start);
    return Reward(0.0f, before);
}";
    assert_eq!(
        refusal(Kind::Task, part),
        format!("own.wgsl:2:17: `sensor_begin` can't be called from here; {NO_MEMORY} [allowed-calls]")
    );
}

/// A task whose cycles loop up to an end.
fn looping(end: &str, cycles: u32) -> Result<World, String> {
    let text = SAME.replace(
        "let moved = now.moved;",
        &format!(
            "var sum = 0.0f; for (var i = 0u; i < {end}; i++) {{ sum = 0.5f * sum + 1.0f; }} let moved = now.moved;"
        ),
    );
    let text = text.replace("Reward(select(earned", "Reward(sum + f32(now.step) + select(earned");
    let world = World::new(WorldSpec {
        task: Task::Own,
        own: OwnParts::from([own(Kind::Task, &text, &[])]),
        cycles,
        ..WorldSpec::miglino1995()
    });
    world.map_err(|invalid| invalid.to_string())
}

/// Nothing could stop it in time. Of loops that turn more often from cycle to cycle, the last cycle counts.
#[test]
fn a_cycle_of_too_many_loops_is_refused() {
    for (end, cycles, turns) in [
        ("4000000000u", 500, "4"),
        ("now.step * 250u", 500, "12"),
        ("min(now.step, 200000u)", 150_000, "15"),
    ] {
        let refused = looping(end, cycles).unwrap_err();
        assert!(
            refused.starts_with(&format!("task.part: loops up to {turns}"))
                && refused.ends_with("allowed: at most 100000, so that a run can be stopped [too-many-turns]"),
            "{end}: {refused}"
        );
    }
    assert!(looping("now.step * 150u", 500).is_ok());
}

/// Software drivers leave loops after a limited number of turns. If a dispatch exceeded it, results would differ. Loops that turn more often
/// in a cycle are unrolled, unless they turn more often from cycle to cycle.
#[cfg(feature = "gpu")]
#[test]
fn loops_end_in_time_on_a_gpu() {
    let mut gpu = oneiro::gpu::Gpu::open(&oneiro::gpu::Choice::Best).unwrap();
    for (end, cycles) in [("min(now.step, 1500u)", 1500), ("now.step * 100u", 500), ("90000u", 10)] {
        let world = looping(end, cycles).unwrap();
        let batch = batch(&world, 70, None);
        let [cpu, gpu] = [&mut Cpu::new(Some(2)).unwrap() as &mut dyn Evaluator, &mut gpu]
            .map(|evaluator| evaluator.evaluate(&batch, &Control::new()).unwrap().fitness);
        assert_eq!(cpu, gpu, "{end}");
    }
    let grows = batch(&looping("now.step * 150u", 500).unwrap(), 70, None);
    let refused = gpu
        .evaluate(&grows, &Control::new())
        .map(|_| ())
        .unwrap_err()
        .to_string();
    assert!(refused.contains("unrolled they make the kernel too long"), "{refused}");
}

#[test]
fn values_are_checked() {
    let problem = |values: &[(&str, f64)]| OwnPart::new(part(Kind::Task, WHOLE), values).unwrap_err().to_string();
    assert_eq!(
        problem(&[("fat", 1.0)]),
        "task.values.fat: isn't a value of own.wgsl; allowed: far, bonus, weight_a, weight_b, last"
    );
    assert_eq!(problem(&[("far", 1.0)]), "task.values.far: is 1; allowed: 10 to 1000");
    assert!(problem(&[("last", f64::NAN)]).contains("is NaN"));
    let values = part(Kind::Task, WHOLE).values().to_vec();
    assert_eq!(
        (values[0].unit.as_str(), values[0].about.as_str()),
        ("mm", "distance from the start that ends a life")
    );
}

/// The blocks of a page in one language.
fn blocks<'a>(page: &'a str, language: &str) -> Vec<&'a str> {
    let fence = format!("```{language}\n");
    page.split(&fence)
        .skip(1)
        .filter_map(|block| block.split("```").next())
        .collect()
}

#[test]
fn the_parts_of_the_documentation_are_taken() {
    let page = include_str!("../../docs/extend.md");
    let parts = blocks(page, "wgsl");
    let kind = |text: &str| {
        let kinds = [Kind::Sensor, Kind::Controller, Kind::Task];
        kinds
            .into_iter()
            .find(|kind| text.contains(&format!("fn {}_cycle", kind.word())))
            .unwrap()
    };
    let kinds: Vec<Kind> = parts.iter().map(|text| kind(text)).collect();
    assert_eq!(
        kinds,
        [
            Kind::Task,
            Kind::Controller,
            Kind::Controller,
            Kind::Sensor,
            Kind::Task,
            Kind::Task,
            Kind::Task
        ]
    );
    for (controller, task) in [(1, 0), (1, 5), (2, 5), (1, 6)] {
        let world = World::new(WorldSpec {
            controller: Controller::Own,
            own: OwnParts::from([controller, 3, task].map(|index| own(kinds[index], parts[index], &[]))),
            ..world(SAME, &[], &|_| {}).spec().clone()
        });
        let fitness = fitness(&world.unwrap());
        assert!(fitness.iter().any(|bits| f32::from_bits(*bits) > 0.0));
    }
    let forager = World::new(WorldSpec {
        task: Task::Own,
        own: OwnParts::from([own(kinds[4], parts[4], &[])]),
        ..WorldSpec::foraging(Forager::ODOWD2014)
    });
    let fitness = fitness(&forager.unwrap());
    assert!(fitness.iter().any(|bits| f32::from_bits(*bits) > 100.0));
}
