//! Upper bounds of loops' turns are never less than the turns that loops take, are exact where that is possible, and are
//! refused where there is none.

use oneiro_shader_compiler::interpret::{Memory, Trap, run_invocation};
use oneiro_shader_compiler::{Indices, Part, Trees, compile, generate, trees};

const BUFFERS: &str = "\
struct World { count: u32, cells: u32, share: f32 }
struct Dispatch { begin: u32, end: u32 }
@group(0) @binding(0) var<uniform> dispatch: Dispatch;
@group(0) @binding(1) var<storage, read> worlds: array<World>;
@group(0) @binding(2) var<storage, read> tables: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> out: array<u32>;
const MOST: u32 = 9u;
";
const WORLD: [u32; 3] = [5, 2, 0];
const DISPATCH: [u32; 2] = [3, 10];
const LANE: u32 = 4;

fn part(path: &str, text: String) -> Part {
    Part {
        path: path.into(),
        text,
    }
}

fn parts(body: &str) -> [Part; 2] {
    let kernel = format!(
        "@compute @workgroup_size(64)\nfn main(@builtin(local_invocation_index) lane: u32) {{\n    var sum = 0u;\n    \
         {body}\n    out[lane] = sum;\n}}\n"
    );
    [part("buffers", BUFFERS.into()), part("kernel", kernel)]
}

fn memory() -> Vec<Vec<u32>> {
    let cells = [[0; 4], [0; 4], [0, 0, 0, 7.5_f32.to_bits()], [6, 0, 0, 0]];
    vec![DISPATCH.into(), WORLD.into(), cells.concat(), vec![0; 64]]
}

fn bound(trees: &Trees, buffers: &[Vec<u32>]) -> Option<u64> {
    let word = |name: &str, element: Option<u64>, word: u32| {
        let at = trees
            .buffers
            .iter()
            .position(|buffer| buffer == name)
            .expect("a buffer");
        let first = element.unwrap_or(0) as usize * trees.strides[at] as usize;
        buffers[at][first + word as usize]
    };
    Some(trees.turns.as_ref().ok()?.value(&word))
}

/// Returns the bound of a body, and the number of turns that its loops take.
fn turns(body: &str) -> (u64, u64) {
    let trees = trees(&parts(body)).unwrap_or_else(|refusals| panic!("`{body}`: {}", refusals[0]));
    let mut buffers = memory();
    let bound = bound(&trees, &buffers).unwrap_or_else(|| panic!("`{body}`: {:?}", trees.turns));
    let mut memory = Memory {
        buffers: &mut buffers,
        strides: &trees.strides,
    };
    (bound, run_invocation(&trees.raw, &mut memory, 0, LANE, true).unwrap())
}

#[test]
fn loops_that_run_to_their_end_turn_as_often_as_is_said() {
    for (body, expected) in [
        ("sum += 1u;", 0),
        ("for (var i = 0u; i < 7u; i++) { sum += i; }", 8),
        ("for (var i = 2u; i < 7u; i++) { sum += i; }", 6),
        ("for (var i = 0u; i <= 7u; i++) { sum += i; }", 9),
        ("for (var i = 0u; 7u > i; i += 3u) { sum += i; }", 4),
        ("for (var i = 0u; (sum < 100u) & (i < 7u); i++) { sum += i; }", 8),
        (
            "let end = min(worlds[0].count, MOST); for (var i = 0u; i < end; i++) { sum += i; }",
            6,
        ),
        (
            "let end = 3u * min(worlds[0].count, MOST); for (var i = 0u; i < end; i += 3u) { sum += i; }",
            6,
        ),
        (
            "let end = (min(worlds[0].count, MOST) + 31u) / 32u; for (var i = 0u; i < end; i++) { sum += i; }",
            2,
        ),
        (
            "let first = worlds[0].cells; let end = first + min(worlds[0].count, MOST);
             for (var i = first; i < end; i++) { sum += i; }",
            6,
        ),
        (
            "let end = min(u32(bitcast<f32>(tables[worlds[0].cells].w)), MOST); for (var i = 0u; i < end; i++) { sum += i; }",
            8,
        ),
        (
            "let end = min(tables[worlds[0].cells + 1u].x, MOST); for (var i = 0u; i < end; i++) { sum += i; }",
            7,
        ),
        (
            "for (var i = dispatch.begin; i < min(dispatch.end, worlds[0].count); i++) { sum += i; }",
            3,
        ),
        (
            "for (var i = 0u; i < 7u; i++) { for (var k = 0u; k < 3u; k++) { sum += k; } }
             for (var i = 0u; i < 2u; i++) { sum += i; }",
            8 + 7 * 4 + 3,
        ),
        // Other forms, where the step is before the test or after it.
        ("var i = 2u; while (i < 7u) { sum += i; i++; }", 6),
        ("var i = 7; while i > 0 { i -= 2; sum += 1u; }", 5),
        ("for (var i = 0u; i < 7u;) { i += 2u; sum += i; }", 5),
        ("var i = 0u; loop { if (i >= 7u) { break; } sum += i; i++; }", 8),
        ("var i = 0u; loop { if (i == 8u) { break; } sum += i; i += 2u; }", 5),
        ("var i = 0u; loop { i++; if (i >= 7u) { break; } sum += i; }", 7),
        (
            "var i = 0u; loop { sum += i; i++; if (i > 6u) { sum += 1u; break; } }",
            7,
        ),
        ("var i = 0; loop { sum += 1u; continuing { i++; break if i == 3; } }", 3),
        (
            "var i = 0u; loop { let c = i; i++; if (c >= 3u) { break; } sum += c; }",
            4,
        ),
        ("var i = 0u; while (true) { if !(i < 3u) { break; } i++; }", 4),
        (
            "var i = 0u; while (i < min(worlds[0].count, MOST)) { var k = 3; while (k != 0) { k--; } i++; }",
            6 + 5 * 4,
        ),
        (
            "var i = 0u; loop { for (var k = 0u; k < 3u; k++) { sum += k; } i++; if (i == 4u) { break; } }",
            4 + 4 * 4,
        ),
        (
            "if (lane > 3u) { var i = 5u; while (i < 7u) { i++; } for (var k = 3; k > 0; k--) { sum += 1u; } }",
            3 + 4,
        ),
        ("for (var x = 0.0; x < 1.0; x += 0.1) { sum += 1u; }", 11),
        (
            "var x = 1.0; loop { x -= 0.25; if (x <= 0.0) { break; } sum += 1u; }",
            4,
        ),
        // `&&` and `||` are branches.
        ("for (var i = 0u; i < 7u && sum < 100u; i++) { sum += i; }", 8),
        ("for (var i = 0; sum < 100u && i < 7; i++) { sum += 1u; }", 8),
        (
            "var i = 0u; while (sum < 100u && !(i >= 7u) && (sum < 90u && sum < 80u)) { sum += i; i++; }",
            8,
        ),
        ("var i = 0u; loop { if (sum > 100u || i >= 7u) { break; } i++; }", 8),
        ("var i = 0u; loop { if (i >= 7u || sum > 100u) { break; } i++; }", 8),
    ] {
        assert_eq!(turns(body), (expected, expected), "{body}");
    }
}

#[test]
fn loops_that_end_early_turn_no_oftener_than_is_said() {
    for (body, expected) in [
        ("for (var i = 0u; i < 64u; i++) { if (i == lane) { break; } }", 65),
        ("for (var i = lane; i < 7u; i++) { sum += i; }", 8),
        (
            "for (var i = 0u; i < 7u; i++) { if (i == lane) { continue; } sum += i; }",
            8,
        ),
        (
            "for (var i = 0u; i < 7u; i++) { for (var k = 0u; k < i; k++) { sum += k; } }",
            8 + 7 * 8,
        ),
        ("for (var i = 0u; i < min(lane, 7u); i++) { sum += i; }", 8),
        (
            "var near = 1u; for (var i = 0u; i < min(near, 7u); i++) { near = 2u; }",
            8,
        ),
        (
            "if (lane > 3u) { for (var i = 0u; i < 7u; i++) { sum += i; } } else { for (var i = 0u; i < 2u; i++) { sum += i; } }",
            8 + 3,
        ),
        ("for (var i = 0u; i < select(3u, 7u, lane > 9u); i++) { sum += i; }", 8),
        ("for (var i = 0u; i < lane % 7u; i++) { sum += i; }", 7),
        ("for (var i = 0u; i < (lane & 7u); i++) { sum += i; }", 8),
        // The sum of the start wraps around.
        (
            "let most = 4294967295u; for (var i = most + 5u; i < 10u; i++) { sum += i; }",
            7,
        ),
        // From a constant to a constant, also with signs, and down.
        ("for (var i = 0; i < 7; i++) { sum += u32(i); }", 8),
        ("for (var i = -3; i <= 3; i += 2) { sum += u32(i + 3); }", 5),
        ("for (var i = 7; i > -2; i -= 4) { sum += 1u; }", 4),
        ("for (var i = 7u; i > 0u; i--) { sum += i; }", 8),
        ("for (var i = 9u; i >= 3u; i -= 3u) { sum += i; }", 4),
        ("for (var i = 0u; i != 8u; i += 2u) { sum += i; }", 5),
        ("for (var i = 5; (2 <= i) & (sum < 90u); i--) { sum += 1u; }", 5),
        ("for (var i = 9; i < 3; i++) { sum += 1u; }", 1),
        (
            "for (var i = 3; i > 0; i--) { for (var k = 0; k < 5; k++) { sum += 1u; } }",
            4 + 3 * 6,
        ),
        (
            "for (var i = 3u; i > 0u; i--) { for (var k = 0u; k < i; k++) { sum += 1u; } }",
            4 + 3 * 4,
        ),
        // At the first test, the counter may be beyond its end.
        (
            "var i = 50u; loop { for (var k = 0u; k < i; k++) { sum += k; } if (i < 3u) { } else { break; } continuing { i++; } }",
            1 + 51,
        ),
        // Once it has counted, the counter is a step beyond.
        (
            "var i = 0u; loop { if (i < 3u) { } else { break; } continuing { i++; for (var k = 0u; k < i; k++) { sum += k; } } }",
            4 + 3 * 5,
        ),
        (
            "var i = 0u; while (i < 7u) { for (var k = 0u; k < i; k++) { sum += k; } i++; for (var k = 0u; k < i; k++) { } }",
            8 + 7 * (8 + 9),
        ),
        // Where the step comes first, the counter is at the end when it is tested last.
        (
            "var i = 0u; loop { for (var k = 0u; k < i; k++) { } i++; for (var k = 0u; k < i; k++) { } if (i >= 3u) { break; } }",
            3 + 3 * (4 + 5),
        ),
        // The first step wraps around.
        (
            "var i = 4294967295u; loop { i++; if (i >= 7u) { break; } sum += i; }",
            8,
        ),
        ("var i = lane; loop { i += 3u; if (i >= 7u) { break; } sum += i; }", 4),
        (
            "var found = false; for (var i = 0u; i < 9u && !found; i++) { found = i == lane; }",
            10,
        ),
        (
            "var i = 0u; while (i < 9u) { i++; if (i == lane) { continue; } sum += i; }",
            10,
        ),
        ("var i = 0u; while (i < 9u) { if (i == lane) { break; } i++; }", 10),
        // Ends and starts with a maximum.
        ("for (var i = 0; i < min(i32(lane), 7); i++) { sum += 1u; }", 8),
        (
            "for (var i = -1; i <= clamp(i32(lane), 0, 7); i += 2) { sum += 1u; }",
            6,
        ),
        ("for (var i = 0; i < i32(lane % 7u); i++) { sum += 1u; }", 7),
        ("var i = min(lane, 7u); while (i > 0u) { i--; sum += 1u; }", 8),
        ("for (var i = min(i32(lane), 7); i >= 0; i -= 3) { sum += 1u; }", 4),
        // A loop after another one, which leaves the counter anywhere.
        ("var i = 0u; while (i < 9u) { i++; } while (i < 20u) { i++; }", 10 + 21),
    ] {
        let (bound, counted) = turns(body);
        assert!(counted <= bound, "{counted} turns of {bound}: {body}");
        assert_eq!(bound, expected, "{body}");
    }
}

#[test]
fn loops_without_a_bound_are_refused_with_their_line() {
    for body in [
        "for (var i = 0u; i < lane; i++) { sum += i; }",
        "for (var i = 0u; i < worlds[0].count; i++) { sum += i; }",
        "for (var i = 0u; i < tables[lane].x; i++) { sum += i; }",
        "for (var i = 0u; i < u32(worlds[0].share); i++) { sum += i; }",
        "for (var i = 0u; i < out[0]; i++) { sum += i; }",
        "for (var i = 0u; i < worlds[0].count + 1u; i++) { sum += i; }",
        "for (var i = 0u; i < 7u * worlds[0].count; i++) { sum += i; }",
        "for (var i = 0u; i != 7u; i += 2u) { sum += i; }",
        "for (var i = 8u; i != 7u; i++) { sum += i; }",
        "for (var i = 0u; i < 7u; i++) { i -= sum; }",
        "for (var i = 0u; i < 7u; i += lane) { sum += i; }",
        "for (var i = 7u; i >= 0u; i--) { sum += i; }",
        "for (var i = 7u; i > 1u; i -= 3u) { sum += i; if (i < 2u) { i = 9u; } }",
        "for (var i = 2u; i > 0u; i -= 3u) { sum += i; }",
        "for (var i = 0u; i < 4294967295u; i += 2u) { sum += i; }",
        "for (var i = 0; i < 7; i--) { sum += 1u; }",
        "for (var i = 0; i != 7; i += 2) { sum += 1u; }",
        "for (var i = 2147483000; i <= 2147483647; i++) { sum += 1u; }",
        "for (var i = -2147483000; i >= -2147483647; i -= 4000) { sum += 1u; }",
        "for (var i = 0; i < i32(lane); i++) { sum += 1u; }",
        "for (var i = i32(lane); i < 7; i++) { sum += 1u; }",
        "while (sum < 7u) { if (lane > 3u) { continue; } sum++; }",
        "while (sum < 7u) { if (lane > 3u) { sum++; } }",
        "while (sum < 7u) { sum++; sum--; }",
        "while (sum < 7u || lane > 3u) { sum++; }",
        "while (!(sum < 7u && lane > 3u)) { sum++; }",
        "while (sum != 7u) { sum += 2u; }",
        "while (sum < 7u) { sum += lane; }",
        "var i = 3; while (i < i32(lane)) { i++; }",
        "var i = 3; i = i32(lane); while (i < 9) { i++; }",
        "var i = 0; if (lane > 3u) { i = 7; } while (i < 9) { i++; }",
        "for (var x = 0.0; x < 1e9; x += 0.1) { sum += 1u; }",
        "for (var x = 0.0; x != 1.0; x += 0.1) { sum += 1u; }",
        "for (var x = f32(lane); x < 9.0; x += 1.0) { sum += 1u; }",
        "for (var i = 0; i < max(i32(lane), 7); i++) { sum += 1u; }",
        "for (var i = min(i32(lane), 7); i < 9; i++) { sum += 1u; }",
        "for (var i = min(lane, 7u); i > 0u; i -= 2u) { sum += 1u; }",
        "for (var i = 0; i < min(i32(lane), 2147483647); i += 2) { sum += 1u; }",
        "for (var i = 0; i != min(i32(lane), 7); i++) { sum += 1u; }",
        "var i = min(lane, 7u); loop { i--; if (i <= 0u) { break; } }",
        "for (var i = 0; i < i32(min(lane, 4294967295u)); i++) { sum += 1u; }",
        "var go = true; while (go) { sum++; go = sum < 7u; }",
        "var i = 7u; loop { i--; if (i < 0u) { break; } }",
        "var i = 0; loop { i += 3; if (i == 7) { break; } }",
        "var i = 2147483647; loop { i++; if (i >= 7) { break; } }",
        "var i = 0u; loop { if (i >= 7u) { for (var k = 0u; k < lane; k++) { } break; } i++; }",
        "var i = 0u; loop { if (i >= 7u) { if (lane > 3u) { continue; } break; } i++; }",
        "var i = 0u; let c = i; while (c < 7u) { i++; }",
        "var i = 0u; loop { if (lane > 3u) { continue; } if (i >= 7u) { break; } continuing { i++; } }",
        "while (sum < 7u) { sum *= 2u; }",
        "loop { sum++; if (sum > lane) { break; } }",
        "for (var i = 0u; i < 7u; i++) { for (var k = 0u; k < lane; k++) { sum += k; } }",
        "if (lane > 3u) { loop { break; } }",
        // A read from before a loop, or from another turn of it, is not the counter's.
        "var i = 0u; let c = i; for (; c < 10u; i++) { sum += 1u; }",
        "var i = 0u; let c = i; for (; i < 10u; i = c + 1u) { sum += 1u; }",
        "for (var i = 0u; i <= min(worlds[0].count, 4294967295u) * min(worlds[0].cells, 4294967295u) * min(lane, 4294967295u); i++) { sum += 1u; }",
        "var i = lane; loop { for (var k = 0u; k < i; k++) { sum += 1u; } if (i < 3u) { } else { break; } continuing { i++; } }",
        "var i = lane; let c = i; for (i = 0u; i < 10u; i++) { for (var k = 0u; k < c; k++) { sum += 1u; } }",
    ] {
        let compiled = compile("kernel", &parts(body), Indices::Clamped)
            .unwrap_or_else(|refusals| panic!("`{body}`: {}", refusals[0]));
        let Err(refusals) = compiled.bounded() else {
            panic!("`{body}` is taken")
        };
        let message = refusals[0].to_string();
        assert!(
            message.starts_with("kernel:4:")
                && message.contains(": in `main`: this loop has no bound known before it runs; ")
                && message.contains("`for (var i = "),
            "`{body}`: {message}"
        );
    }
}

#[test]
fn the_message_has_a_loop_with_the_same_test() {
    for (body, expected) in [
        (
            "while (sum < lane) { sum++; sum++; }",
            "`for (var i = 0u; i < 40u && (sum < lane); i++) { .. }`",
        ),
        (
            "while sum < lane  || lane > 3u { sum++; sum++; }",
            "`for (var i = 0u; i < 40u && (sum < lane || lane > 3u); i++) { .. }`",
        ),
        (
            "while (sum < lane) || (lane > 3u) { sum++; sum++; }",
            "`for (var i = 0u; i < 40u && ((sum < lane) || (lane > 3u)); i++) { .. }`",
        ),
        (
            "loop { if (lane > 3u) { break; } }",
            "`for (var i = 0u; i < 40u; i++) { .. }`, with `break` in it",
        ),
    ] {
        let compiled = compile("kernel", &parts(body), Indices::Clamped).unwrap();
        let message = compiled.bounded().unwrap_err()[0].to_string();
        assert!(message.contains(expected), "{message}");
    }
}

/// Values that are shared again and again take no time.
#[test]
fn ends_of_shared_values_are_refused_soon() {
    let doubled: Vec<String> = (0..60)
        .map(|step| format!("let x{} = x{step} + x{step}; ", step + 1))
        .collect();
    let doubled = doubled.concat();
    let body = format!("let x0 = min(worlds[0].count, MOST); {doubled} for (var i = 0u; i < x60; i++) {{ sum += i; }}");
    let compiled = compile("kernel", &parts(&body), Indices::Clamped).unwrap();
    assert!(compiled.bounded().is_err());
    let long: Vec<String> = (0..5_000)
        .map(|step| format!("let x{} = x{step} + 1u; ", step + 1))
        .collect();
    let long = long.concat();
    let body = format!("let x0 = min(worlds[0].count, MOST); {long} for (var i = 0u; i < x5000; i++) {{ sum += i; }}");
    let compiled = compile("kernel", &parts(&body), Indices::Clamped).unwrap();
    assert!(compiled.bounded().is_err());
    let nested: Vec<String> = (0..40)
        .map(|level| {
            format!(
                "for (var i{} = 0u; i{} < i{level} + i{level}; i{}++) {{ ",
                level + 1,
                level + 1,
                level + 1
            )
        })
        .collect();
    let body = format!(
        "for (var i0 = 0u; i0 < min(worlds[0].count, MOST); i0++) {{ {} sum += 1u; {} }}",
        nested.concat(),
        "}".repeat(40)
    );
    let compiled = compile("kernel", &parts(&body), Indices::Clamped).unwrap();
    assert!(compiled.bounded().is_err());
}

/// The loops of random kernels.
#[test]
fn random_loops_turn_no_oftener_than_is_said() {
    let (mut known, mut unknown) = (0, 0);
    for seed in 0..100 {
        let text = generate::kernel(seed, 20 + (seed % 80) as u32);
        let Ok(trees) = trees(&[part("prelude", generate::PRELUDE.into()), part("kernel", text.clone())]) else {
            continue;
        };
        let mut buffers = generate::buffers(seed, 1);
        let Some(bound) = bound(&trees, &buffers) else {
            unknown += 1;
            continue;
        };
        known += 1;
        for lane in 0..8 {
            let mut memory = Memory {
                buffers: &mut buffers,
                strides: &trees.strides,
            };
            match run_invocation(&trees.raw, &mut memory, 0, lane, true) {
                Ok(turns) => assert!(turns <= bound, "seed {seed}: {turns} turns of {bound}\n{text}"),
                Err(Trap::Endless) => break,
                Err(trap) => panic!("seed {seed}: {trap}"),
            }
        }
    }
    assert!(known > 10, "{known} kernels have a bound, {unknown} have none");
}
