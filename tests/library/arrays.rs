//! Whatever arrays are accepted, the CPU runs: of the largest that are, and one element more, alone and in swarms.

use std::fmt::Write;
use std::sync::Arc;

use oneiro::batch::{Batch, Rollout};
use oneiro::compose::{Kind, OwnPart, OwnParts, Part};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::Key;
use oneiro::world::{Controller, Task, World, WorldSpec};

use crate::hostile::described;

/// Words of all arrays of a kernel.
const MOST: u32 = 16_384;

/// Statements that use arrays of so many words, and what they need outside of functions.
type Arrays = fn(u32) -> (String, String);

/// Elements of an array's end are changed and added to `x`.
fn indexed(ty: &str, count: u32, write: &str, read: &str) -> String {
    format!(
        "var a: array<{ty}, {count}>;
        for (var i = {}u; i < {count}u; i++) {{ a[i]{write}; }}
        for (var i = 0u; i < {count}u; i += {}u) {{ x += {read}; }}",
        count.saturating_sub(5),
        (count / 7).max(1)
    )
}

const ARRAYS: [(&str, Arrays); 8] = [
    ("floats", |words| {
        (indexed("f32", words, " = x + f32(i)", "a[i]"), String::new())
    }),
    ("truths", |words| {
        (
            indexed("bool", words, " = x > 0.5f", "select(1.0f, 2.0f, a[i])"),
            String::new(),
        )
    }),
    ("vectors", |words| {
        (
            indexed("vec4<f32>", words / 4, ".y = x", "a[i].y + a[i].z"),
            String::new(),
        )
    }),
    ("structs", |words| {
        let pair = "struct Pair { a: f32, b: u32 }\n".to_owned();
        (indexed("Pair", words / 2, ".b = i", "f32(a[i].b & 7u)"), pair)
    }),
    ("arrays of arrays", |words| {
        (indexed("array<f32, 2>", words / 2, "[1] = x", "a[i][1]"), String::new())
    }),
    ("two", |words| {
        let one = indexed("f32", words / 2, " = x", "a[i]");
        let other = one.replace("a[", "b[").replace("var a", "var b");
        (
            format!(
                "{one}\n{}",
                other.replace(
                    &format!("array<f32, {}>", words / 2),
                    &format!("array<f32, {}>", words - words / 2)
                )
            ),
            String::new(),
        )
    }),
    ("four calls", |words| {
        let body = indexed("f32", words / 4, " = x", "a[i]");
        let function = format!("fn passed(y: f32) -> f32 {{\nvar x = y;\n{body}\nreturn x;\n}}\n");
        ("x = passed(passed(passed(passed(x))));".to_owned(), function)
    }),
    // Few elements, which are not in memory.
    ("constant indices", |words| {
        (
            format!(
                "var a: array<f32, {words}>;\na[1] = x;\na[{}] = x + 1.0f;\nx += a[0] + a[1] + a[{}];",
                words - 1,
                words - 1
            ),
            String::new(),
        )
    }),
];

/// A part of a kind with these statements.
fn part(kind: Kind, is_mission: bool, (body, outside): &(String, String)) -> String {
    let (head, tail) = match kind {
        Kind::Task if is_mission => (
            "fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {\nvar x = robot_pose(episode, 1u).z;",
            "return Tally(0.001f * x, before);",
        ),
        Kind::Task => (
            "fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {\nvar x = now.moved.left;",
            "return Reward(0.001f * x, before);",
        ),
        Kind::Controller => (
            "const CONTROLLER_GENES: u32 = 2u;
            fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {\nvar x = gene(episode, 1u);",
            "return Command(vec2<f32>(logistic(x), 0.7f), before);",
        ),
        Kind::Sensor => (
            "struct SensorReadings { odd_one: f32 }
            fn sensor_cycle(episode: Episode, step: u32, pose: vec3<f32>, before: SensorState) -> Sensed {\nvar x = pose.z;",
            "return Sensed(SensorReadings(logistic(x)), before);",
        ),
    };
    format!("{outside}{head}\n{body}\n{tail}\n}}\n")
}

fn world(kind: Kind, is_swarm: bool, text: &str) -> Result<World, String> {
    let mut spec = if is_swarm {
        described(Some(3))
    } else {
        WorldSpec::miglino1995()
    };
    spec.cycles = 4;
    match kind {
        Kind::Sensor => {}
        Kind::Controller => spec.controller = Controller::Own,
        Kind::Task => spec.task = Task::Own,
    }
    let part = Part::new(kind, "own.wgsl", text).map_err(|refused| refused.to_string())?;
    spec.own = OwnParts::from([OwnPart::new(Arc::new(part), &[]).map_err(|invalid| invalid.to_string())?]);
    World::new(spec).map_err(|invalid| invalid.to_string())
}

/// The fitness of lives, as bits, and what is warned of.
fn live(cpu: Cpu, world: &World) -> (Vec<u32>, Vec<String>) {
    let mut cpu = cpu;
    let genes: Vec<f32> = (0..world.genes()).map(|gene| gene as f32 / 7.0 - 1.0).collect();
    let rollouts: Vec<_> = (0..19)
        .map(|life| Rollout {
            world: 0,
            genes: &genes,
            key: Key::rollout(5, 0, life, 0),
        })
        .collect();
    let batch = Batch::new(std::slice::from_ref(world), &rollouts, None).unwrap();
    let outcome = cpu
        .evaluate(&batch, &Control::new())
        .unwrap_or_else(|error| panic!("{error}"));
    let bits = outcome.fitness.iter().map(|fitness| fitness.to_bits()).collect();
    (bits, cpu.warnings().to_vec())
}

#[test]
fn the_largest_arrays_that_are_accepted_run() {
    let places = [
        (Kind::Task, false),
        (Kind::Controller, false),
        (Kind::Sensor, false),
        (Kind::Task, true),
        (Kind::Controller, true),
    ];
    for (kind, is_swarm) in places {
        // Arrays of Oneiro's own files.
        let text = |words: u32, arrays: Arrays| part(kind, is_swarm, &arrays(words));
        for (what, arrays) in ARRAYS {
            let what = format!("{what}, {kind:?}, in a swarm: {is_swarm}");
            let accepted =
                world(kind, is_swarm, &text(MOST, arrays)).unwrap_or_else(|refused| panic!("{what}: {refused}"));
            let refused = world(kind, is_swarm, &text(MOST + 4, arrays)).expect_err(&what);
            assert!(
                refused.contains("allowed: 65536") && refused.ends_with("[large-variable]"),
                "{what}: {refused}"
            );
            let (found, warnings) = live(Cpu::new(Some(2)).unwrap(), &accepted);
            assert!(warnings.is_empty(), "{what}: {warnings:?}");
            let interpreter = Cpu::new(Some(2)).unwrap().with_variant("interpretedx1").unwrap();
            assert_eq!(found, live(interpreter, &accepted).0, "{what}");
        }
    }
}

/// An array of arrays, of which an element has a name, with indices that differ between robots and within loops, also beyond the ends.
/// The placeholders are that element, read and written, and the declaration.
const GRID: &str = "
    DECLARED
    let seed = u32(abs(x) * 1000.0);
    for (var i = 0u; i < 3u; i++) {
        for (var j = 0u; j < 5u; j++) { AT(i, j) = x + f32(i * 7u + j); }
    }
    for (var turn = 0u; turn < 9u; turn++) {
        let i = (seed + turn) % 4u;
        let j = (seed / 4u + turn) % 7u;
        AT(i, j) += 0.5 * AT(j, i);
        x += AT(turn, i);
    }";

/// Elements of arrays within arrays, of vectors and structs within them, and of flat arrays are the same.
#[test]
fn arrays_in_arrays_are_as_flat_ones() {
    let at = |form: &str| {
        let mut text = String::new();
        for (number, piece) in GRID.split("AT(").enumerate() {
            let rest = if number == 0 {
                piece.to_owned()
            } else {
                let (indices, rest) = piece.split_once(')').unwrap();
                let (i, j) = indices.split_once(", ").unwrap();
                form.replace('I', i).replace('J', j) + rest
            };
            text += &rest;
        }
        text
    };
    let forms = [
        ("a: array<f32, 15>", "a[5u * min(I, 2u) + min(J, 4u)]", ""),
        ("a: array<array<f32, 5>, 3>", "a[I][J]", ""),
        (
            "a: array<Row, 3>",
            "a[I].cells[J]",
            "struct Row { first: u32, cells: array<f32, 5> }\n",
        ),
        ("a: array<array<array<vec2<f32>, 1>, 5>, 3>", "a[I][J][0].y", ""),
        ("a: array<array<array<vec2<f32>, 1>, 5>, 3>", "a[I][J][I][1u + J]", ""),
    ];
    for (kind, is_swarm) in [(Kind::Task, false), (Kind::Controller, true)] {
        let lives = forms.map(|(declared, form, outside)| {
            let body = at(form).replace("DECLARED", &format!("var {declared};"));
            let world = world(kind, is_swarm, &part(kind, is_swarm, &(body, outside.to_owned())))
                .unwrap_or_else(|refused| panic!("{form}: {refused}"));
            let (found, _) = live(Cpu::new(Some(2)).unwrap(), &world);
            let interpreter = Cpu::new(Some(2)).unwrap().with_variant("interpretedx1").unwrap();
            assert_eq!(found, live(interpreter, &world).0, "{form}");
            found
        });
        assert!(lives[0].iter().any(|bits| *bits != lives[0][0]));
        assert_eq!(lives, std::array::from_fn(|_| lives[0].clone()));
    }
}

/// Arrays of different functions count together, and the message says how many bytes they have.
#[test]
fn what_all_arrays_take_is_said() {
    let (body, outside) = ARRAYS[6].1(20_000);
    let refused = world(Kind::Task, false, &part(Kind::Task, false, &(body, outside))).unwrap_err();
    assert_eq!(
        refused,
        "task.part: own.wgsl:3:1: the arrays of all functions, counted again at each call, take 80000 bytes; allowed: 65536. `a` is the \
         largest [large-variable]"
    );
}

/// A task that has so many vectors until it needs all of them.
fn many_values(vectors: u32) -> String {
    let mut body = "let y = vec4<f32>(x, x + 1.0f, x + 2.0f, x + 3.0f);\n".to_owned();
    body += "let v0 = y + y;\n";
    for number in 1..vectors {
        let _ = writeln!(body, "let v{number} = v{} + y;", number - 1);
    }
    body += "var sum = y;\n";
    let names: Vec<_> = (0..vectors).map(|number| format!("v{number}")).collect();
    for some in names.chunks(100).rev() {
        let _ = writeln!(body, "sum += {};", some.join(" + "));
    }
    body += "x = clamp(sum.x + sum.y + sum.z + sum.w, -9.0f, 9.0f);";
    part(Kind::Task, false, &(body, String::new()))
}

/// Numbers that are all needed later take room on a thread's stack: the code has fewer lanes. Where there is no room for those of 4
/// lanes, the kernel is interpreted, with a warning.
#[test]
fn what_cannot_be_compiled_is_interpreted() {
    // There is room for 8,224 numbers of 16 lanes, and for 32,800 of 4.
    for (vectors, is_compiled) in [(2_100, true), (8_260, false)] {
        let world =
            world(Kind::Task, false, &many_values(vectors)).unwrap_or_else(|refused| panic!("{vectors}: {refused}"));
        let (found, warnings) = live(Cpu::new(Some(2)).unwrap(), &world);
        let interpreter = Cpu::new(Some(2)).unwrap().with_variant("interpretedx1").unwrap();
        assert_eq!(found, live(interpreter, &world).0, "{vectors}");
        match &warnings[..] {
            [] => assert!(is_compiled, "{vectors}"),
            [warning] => assert!(
                !is_compiled && warning.contains("the kernel is interpreted instead"),
                "{vectors}: {warning}"
            ),
            _ => panic!("{vectors}: {warnings:?}"),
        }
    }
}
