//! Parts as nobody would write them: those of `oneiro new` and of the classics, with a few tokens deleted, doubled, swapped
//! or replaced. Each is refused with a place in it, or its lives end; nothing panics.

use std::sync::Arc;
use std::time::Duration;

use oneiro::batch::{Rollout, Worlds};
use oneiro::compose::{Kind, OwnPart, OwnParts, Part};
use oneiro::cpu::Cpu;
use oneiro::evaluator::{Control, Evaluator};
use oneiro::random::Key;
use oneiro::world::{Controller, Task, World, WorldSpec};

use crate::mutations::{Spent, alone, mutant, peak};

const PARTS: [(Kind, &str); 8] = [
    (
        Kind::Sensor,
        include_str!("../../host/lab/src/experiment/parts/sensor.wgsl"),
    ),
    (Kind::Sensor, include_str!("../../experiments/homing/sensors.wgsl")),
    (
        Kind::Controller,
        include_str!("../../host/lab/src/experiment/parts/controller.wgsl"),
    ),
    (Kind::Controller, include_str!("../../experiments/road-sign/ctrnn.wgsl")),
    (
        Kind::Task,
        include_str!("../../host/lab/src/experiment/parts/task.wgsl"),
    ),
    (Kind::Task, include_str!("../../experiments/road-sign/task.wgsl")),
    (Kind::Task, include_str!("../../experiments/discrimination/task.wgsl")),
    (Kind::Task, include_str!("../../experiments/wall-following/task.wgsl")),
];

/// Tokens that kernels don't expect.
const ODD: [&str; 24] = [
    "0u",
    "1u",
    "4294967295u",
    "-2147483647i",
    "65535u",
    "3.4e38f",
    "0x1p-126f",
    "0.0f",
    "i32",
    "u32",
    "f32",
    "bool",
    "vec2<f32>",
    "array<u32, 70000>",
    "array<f32, 3>",
    "&",
    "*",
    "loop",
    "while",
    "for",
    "continue",
    "return",
    "life",
    "before",
];

/// Maximum processor time for the episodes of one mutant.
const PATIENCE: Duration = Duration::from_secs(30);
/// Most memory of the process, KB.
const MEMORY: u64 = 768 << 10;

/// Mutants that are tried however long it takes.
const LEAST: u32 = 200;

/// Makes a world of a mutant and lets some live in it, where each must live as it does alone. The error is that of a refusal.
fn live(kind: Kind, text: &str) -> Result<(), String> {
    let part = Part::new(kind, "mutant.wgsl", text).map_err(|refused| refused.to_string())?;
    let own = OwnPart::new(Arc::new(part), &[]).map_err(|invalid| invalid.to_string())?;
    let mut spec = WorldSpec {
        cycles: 20,
        own: OwnParts::from([own]),
        ..WorldSpec::miglino1995()
    };
    match kind {
        Kind::Sensor => {}
        Kind::Controller => spec.controller = Controller::Own,
        Kind::Task => spec.task = Task::Own,
    }
    let world = World::new(spec).map_err(|invalid| invalid.to_string())?;
    let genes: Vec<f32> = (0..world.genes()).map(|gene| (gene % 7) as f32 - 3.0).collect();
    let rollouts: Vec<_> = (0..20)
        .map(|life| Rollout {
            world: 0,
            genes: &genes,
            key: Key::rollout(1, 0, life, 0),
        })
        .collect();
    let worlds = Worlds::new(&[world]).map_err(|invalid| invalid.to_string())?;
    let spent = Spent::by("self");
    let lived = |rollouts: &[Rollout<'_>]| {
        let batch = worlds.batch(rollouts, None).unwrap();
        let outcome = Cpu::new(Some(1)).unwrap().evaluate(&batch, &Control::new());
        outcome
            .map(|outcome| outcome.fitness)
            .map_err(|error| error.to_string())
    };
    let together = lived(&rollouts)?;
    let took = spent.time();
    for life in [0, 7, 19] {
        let alone = lived(&rollouts[life..=life])?;
        assert_eq!(
            alone[0].to_bits(),
            together[life].to_bits(),
            "life {life} depends on others:\n{text}"
        );
    }
    assert!(took < PATIENCE, "twenty lives took {took:?}:\n{text}");
    Ok(())
}

/// Whether a message names the part with a line and a column, or something that has none.
fn is_placed(message: &str) -> bool {
    let is_place = |after: &str| {
        let mut numbers = after.split(':').map(str::parse::<u32>);
        numbers.next().is_some_and(|line| line.is_ok()) && numbers.next().is_some_and(|column| column.is_ok())
    };
    let has_place = message.split(".wgsl:").skip(1).any(is_place);
    let has_none = ["mutant.wgsl: has no", "in a cycle; allowed"];
    message.contains("mutant.wgsl") && has_place || has_none.iter().any(|words| message.contains(words))
}

#[test]
fn mutants_are_refused_or_live() {
    if !alone(concat!(module_path!(), "::mutants_are_refused_or_live")) {
        return;
    }
    let times = if std::env::var_os("ONEIRO_LONG").is_some() {
        120
    } else {
        1
    };
    let (spent, patience) = (Spent::by("self"), Duration::from_secs(5) * times);
    let (mut taken, mut refused, mut problems) = (0, 0, Vec::new());
    for seed in 0..2_000 * times {
        if seed >= LEAST && spent.time() > patience {
            break;
        }
        let (kind, text) = PARTS[seed as usize % PARTS.len()];
        let text = mutant(text, &ODD, seed);
        match live(kind, &text) {
            Ok(()) => taken += 1,
            Err(message) => {
                refused += 1;
                // No mistake in a part breaks a rule of Oneiro's own files.
                if !is_placed(&message) || !message.ends_with(']') || message.contains("[internal]") {
                    problems.push(format!("seed {seed}: {message}\n{text}"));
                }
            }
        }
    }
    eprintln!(
        "{taken} mutants lived, {refused} were refused, in {:.1?}; at most {} MB",
        spent.time(),
        peak() >> 10
    );
    assert!(problems.is_empty(), "{}", problems.join("\n"));
    eprintln!("{} KB", peak());
    assert!(peak() < MEMORY, "{} KB", peak());
    assert!(taken > 20 && refused > 100, "{taken} lived, {refused} were refused");
}

/// Whole texts that compilers have trouble with: each is refused, or its lives end.
#[test]
fn deep_and_long_parts_are_refused_or_live() {
    if !alone(concat!(module_path!(), "::deep_and_long_parts_are_refused_or_live")) {
        return;
    }
    let task = |body: &str, rest: &str| {
        format!(
            "fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {{
    var x = now.outputs.x;
{body}
    return Reward(x, before);
}}
{rest}"
        )
    };
    let many = |text: &str, count: usize| text.repeat(count);
    let numbered = |count: usize, text: &dyn Fn(usize) -> String| (0..count).map(text).collect::<String>();
    let long = "a".repeat(100_000);
    let texts = [
        ("nothing", String::new()),
        ("a nul", "\0".to_owned()),
        (
            "parentheses",
            task(&format!("x = {}x{};", many("(", 90), many(")", 90)), ""),
        ),
        ("signs", task(&format!("x = {}x;", many("- ", 900)), "")),
        ("nots", task(&format!("let b = {}true;", many("!", 900)), "")),
        ("a long sum", task(&format!("x = {}x;", many("x + ", 490)), "")),
        (
            "a long product of sums",
            task(&format!("x = {}x{};", many("(x + ", 90), many(") * x", 90)), ""),
        ),
        ("blocks", task(&format!("{}{}", many("{", 90), many("}", 90)), "")),
        (
            "branches",
            task(&format!("{}x = 1.0f;{}", many("if x > 0.0f {", 90), many("}", 90)), ""),
        ),
        (
            "branches one after the other",
            task(&format!("if x > 0.0f {{}}{}", many(" else if x > 0.0f {}", 240)), ""),
        ),
        (
            "many branches",
            task(&format!("if x > 0.0f {{}}{}", many(" else if x > 0.0f {}", 20_000)), ""),
        ),
        (
            "loops in loops",
            task(
                &format!(
                    "{}{}",
                    numbered(40, &|i| format!("for (var i{i} = 0u; i{i} < 9u; i{i}++) {{")),
                    many("}", 40)
                ),
                "",
            ),
        ),
        ("a loop without a bound", task("loop { x += 1.0f; }", "")),
        (
            "a long loop",
            task("for (var i = 0u; i < 4294967295u; i++) { x += 1.0f; }", ""),
        ),
        ("statements", task(&many("x = x * 0.5f;", 15_000), "")),
        ("variables", task(&numbered(19_000, &|i| format!("var v{i} = x;")), "")),
        (
            "a large array",
            task("var a: array<f32, 1000000000>; x = a[now.step];", ""),
        ),
        (
            "arrays of arrays",
            task(
                "",
                &format!(
                    "struct S {{ a: {}f32{} }}",
                    many("array<", 20_000),
                    many(", 2>", 20_000)
                ),
            ),
        ),
        (
            "structs in structs",
            task(
                "",
                &format!(
                    "struct S0 {{ x: f32 }}{}",
                    numbered(490, &|i| format!("struct S{} {{ a: S{i}, b: S{i} }}", i + 1))
                ),
            ),
        ),
        ("a long name", task(&format!("let {long} = x; x = {long};"), "")),
        (
            "a name that isn't ASCII",
            task("let \u{e9}t\u{e9} = x; x = \u{e9}t\u{e9};", ""),
        ),
        ("recursion", task("x = f(x);", "fn f(x: f32) -> f32 { return f(x); }")),
        (
            "recursion of two",
            task(
                "x = f(x);",
                "fn f(x: f32) -> f32 { return g(x); } fn g(x: f32) -> f32 { return f(x); }",
            ),
        ),
        (
            "doubling",
            task(
                "x = g40(x);",
                &format!(
                    "fn g0(x: f32) -> f32 {{ return x; }}{}",
                    numbered(40, &|i| format!(
                        "fn g{}(x: f32) -> f32 {{ return g{i}(g{i}(x)); }}",
                        i + 1
                    ))
                ),
            ),
        ),
        (
            "a chain of calls",
            task(
                "x = g490(x);",
                &format!(
                    "fn g0(x: f32) -> f32 {{ return x; }}{}",
                    numbered(490, &|i| format!("fn g{}(x: f32) -> f32 {{ return g{i}(x); }}", i + 1))
                ),
            ),
        ),
        (
            "constants of constants",
            task(
                "x = C490;",
                &format!(
                    "const C0 = 0.5f;{}",
                    numbered(490, &|i| format!("const C{} = C{i} * 0.5f;", i + 1))
                ),
            ),
        ),
        ("a recursive constant", task("x = A;", "const A = B; const B = A;")),
        ("a recursive struct", task("", "struct A { b: B } struct B { a: A }")),
        ("digits", task(&format!("x = {}.0f;", many("9", 50_000)), "")),
        ("comments in comments", many("/*", 200_000)),
        ("attributes", many("@", 50_000)),
        ("templates", many("a<", 490)),
        (
            "indices",
            task(&format!("x = x{}{};", many("[0", 90), many("]", 90)), ""),
        ),
        ("members", task(&format!("x = now{};", many(".x", 450)), "")),
        ("references", task(&format!("x = {}x;", many("&*", 450)), "")),
        (
            "switches",
            task(
                &format!(
                    "switch now.step {{ {} default {{}} }}",
                    numbered(240, &|i| format!("case {i}u {{}}"))
                ),
                "",
            ),
        ),
        ("functions", task("", &numbered(490, &|i| format!("fn g{i}() {{}}\n")))),
    ];
    for (what, text) in texts {
        let spent = Spent::by("self");
        let lived = live(Kind::Task, &text).map_err(|message| message.chars().take(200).collect::<String>());
        let took = spent.time();
        eprintln!("{what}: {lived:?} {took:.1?}");
        assert!(took < PATIENCE, "{what} took {took:.1?}");
    }
}
