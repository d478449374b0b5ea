//! Tasks of a user's own: composed when the program runs, the same bits on the CPU and a GPU, and refused with file, line and
//! column if anything is wrong.

use std::sync::Arc;

use oneiro::batch::{Batch, Rollout, TraceRequest};
use oneiro::compose::{OwnTask, TaskPart};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::Key;
use oneiro::surrogate::{Differences, Surrogate};
use oneiro::world::{Controller, Noise, Task, World, WorldSpec};

/// Equation 1 as the user would write it: what ships, under another name.
const SAME: &str = "
fn task_cycle(life: Life, now: Experience, before: TaskState) -> Reward {
    let moved = now.moved;
    let speed = 0.5f * (abs(moved.left) + abs(moved.right));
    let turning = root(0.5f * abs(moved.left - moved.right));
    let earned = speed * (1.0f - turning) * (1.0f - highest(now.real));
    return Reward(select(earned, 0.0f, now.collided), before);
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
fn task_begin(life: Life, pose: vec3<f32>) -> TaskState {
    return TaskState(vec2<f32>(pose.x, pose.y), 0u, 0.0f, 0u);
}
fn task_cycle(life: Life, now: Experience, before: TaskState) -> Reward {
    let own = task_values(life.world);
    var next = before;
    let x = now.end.x - before.start.x;
    let y = now.end.y - before.start.y;
    next.cycles += 1u;
    next.farthest = max(before.farthest, root(x * x + y * y));
    next.done = select(0u, 1u, next.farthest > own.far);
    return Reward(own.weight_a * now.moved.left + own.weight_b * now.moved.right + own.last * now.outputs.x, next);
}
fn task_ends(own: TaskState) -> bool {
    return own.done != 0u;
}
fn task_score(own: TaskState, sum: f32) -> f32 {
    return sum + own.farthest + f32(own.cycles);
}
";

fn part(text: &str) -> Arc<TaskPart> {
    Arc::new(TaskPart::new("own.wgsl", text).unwrap_or_else(|refused| panic!("{refused}")))
}

fn world(text: &str, values: &[(&str, f64)], change: &dyn Fn(&mut WorldSpec)) -> World {
    let mut spec = WorldSpec {
        task: Task::Own,
        own_task: Some(Arc::new(OwnTask::new(part(text), values).unwrap())),
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

#[test]
fn the_shipped_task_written_again_has_its_bits() {
    for controller in [
        Controller::Perceptron,
        Controller::Hidden { units: 3 },
        Controller::Recurrent,
    ] {
        let own = world(SAME, &[], &|spec| spec.controller = controller);
        let shipped = World::new(WorldSpec {
            task: Task::AVOIDANCE,
            own_task: None,
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

#[test]
fn surrogates_have_the_task_too() {
    let own = world(WHOLE, &[], &|spec| {
        spec.noise = Noise::NONE;
        spec.surrogate = Some(Arc::new(Surrogate::drawn(1, Differences::all(1.0))));
    });
    assert_eq!(fitness(&own), fitness(&own));
    assert!(
        own.kernel().name.starts_with("surrogate_perceptron+own-"),
        "{}",
        own.kernel().name
    );
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

#[cfg(feature = "gpu")]
#[test]
fn a_gpu_has_the_same_bits() {
    use oneiro::gpu::{Choice, Gpu};
    let mut gpu = Gpu::open(&Choice::Best).unwrap();
    for text in [SAME, WHOLE] {
        let world = world(text, &[], &|_| {});
        let batch = batch(&world, 2_000, None);
        let [cpu, gpu] = [&mut Cpu::new(Some(2)).unwrap() as &mut dyn Evaluator, &mut gpu]
            .map(|evaluator| evaluator.evaluate(&batch, &Control::new()).unwrap().fitness);
        let differing = cpu.iter().zip(&gpu).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        assert_eq!(differing, 0);
    }
}

#[test]
fn mistakes_are_refused_with_their_place() {
    let mut problems = Vec::new();
    let cycle =
        "fn task_cycle(life: Life, now: Experience, before: TaskState) -> Reward { return Reward(0.0f, before); }";
    for (text, message) in [
        (
            "fn reward() {}".to_owned(),
            "own.wgsl: has no function `task_cycle`; allowed: `fn task_cycle(life: Life",
        ),
        (
            SAME.replace("1.0f - turning", "sqrt(turning)"),
            "own.wgsl:6:27: `sqrt` is not on the list of functions that are exact on every device: abs, floor, trunc, select, bitcast, min, max, clamp; write `root(x)`",
        ),
        (
            SAME.replace("root(0.5f *", "root(0.5 *"),
            "own.wgsl:5:24: the float constant `0.5` has no suffix",
        ),
        (
            SAME.replace("let moved = now.moved;", "let moved = now.mood;"),
            "own.wgsl:3:21: invalid field accessor `mood`",
        ),
        (
            SAME.replace("let moved", "fitness[0] = 1.0f; let moved"),
            "own.wgsl:3:5: `fitness` is a buffer that only the kernel may use",
        ),
        (
            format!("@group(0) @binding(9) var<storage, read_write> mine: array<u32>;\n{cycle}"),
            "own.wgsl: declares a buffer",
        ),
        (
            format!("struct TaskState {{ on: bool }}\n{cycle}"),
            "own.wgsl:1:20: in `TaskState`: `on`: bool can't be kept",
        ),
        (
            format!("struct TaskValues {{\n  a: f32,\n}}\n{cycle}"),
            "own.wgsl:2:3: in `TaskValues`: `a`: its comment",
        ),
        (
            format!("struct TaskValues {{\n  a: f32, // 3, 0 to 2: more\n}}\n{cycle}"),
            "the default is 3; allowed: 0 to 2",
        ),
        (
            SAME.replace(
                "let moved =",
                "for (var i = 0u; i < u32(now.step * now.step); i += 0u) {} let moved =",
            ),
            "own.wgsl:3:5: in `task_cycle`: nothing known beforehand bounds this loop",
        ),
        (
            format!("{cycle}\n@compute @workgroup_size(64) fn main() {{}}"),
            "own.wgsl:2:",
        ),
        (format!("{cycle} fn ,"), "own.wgsl:1:"),
    ] {
        let refused = match TaskPart::new("own.wgsl", &text) {
            Ok(_) => "it is taken".to_owned(),
            Err(refused) => refused.to_string(),
        };
        if !refused.contains(message) {
            problems.push(format!("{text}\n{refused}\nexpected: {message}"));
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n\n"));
}

/// Nothing could stop it in time.
#[test]
fn a_cycle_of_too_many_loops_is_refused() {
    let text = SAME.replace(
        "let moved = now.moved;",
        "var sum = 0.0f; for (var i = 0u; i < 4000000000u; i++) { sum = 0.5f * sum + 1.0f; } let moved = now.moved;",
    );
    let text = text.replace("Reward(select(earned", "Reward(sum + select(earned");
    let task = OwnTask::new(part(&text), &[]).unwrap();
    let refused = World::new(WorldSpec {
        task: Task::Own,
        own_task: Some(Arc::new(task)),
        ..WorldSpec::miglino1995()
    });
    let refused = refused.unwrap_err().to_string();
    assert!(
        refused.starts_with("task.part: loops up to 4")
            && refused.ends_with("allowed: up to 100000, so that a run can be stopped"),
        "{refused}"
    );
}

#[test]
fn values_are_checked() {
    let problem = |values: &[(&str, f64)]| OwnTask::new(part(WHOLE), values).unwrap_err().to_string();
    assert_eq!(
        problem(&[("fat", 1.0)]),
        "task.values.fat: is no value of own.wgsl; allowed: far, bonus, weight_a, weight_b, last"
    );
    assert_eq!(problem(&[("far", 1.0)]), "task.values.far: is 1; allowed: 10 to 1000");
    assert!(problem(&[("last", f64::NAN)]).contains("is NaN"));
    let values = part(WHOLE).values().to_vec();
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
    let page = include_str!("../docs/extend.md");
    let parts = blocks(page, "wgsl");
    assert_eq!(parts.len(), 2);
    for text in parts {
        assert!(
            fitness(&world(text, &[], &|_| {}))
                .iter()
                .any(|bits| f32::from_bits(*bits) > 0.0)
        );
    }
}
