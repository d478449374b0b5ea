//! Programs with unrolled loops leave the same bits, and their loops turn no oftener than is said.

use oneiro_shader_compiler::interpret::{Memory, Trap, run_invocation};
use oneiro_shader_compiler::{Generic, Indices, Part, generate};

const BUFFERS: &str = "\
struct World { count: u32, most: u32 }
struct Dispatch { begin: u32, end: u32 }
@group(0) @binding(0) var<uniform> dispatch: Dispatch;
@group(0) @binding(1) var<storage, read> worlds: array<World>;
@group(0) @binding(2) var<storage, read_write> out: array<u32>;
fn first(lane: u32, count: u32) -> u32 {
    for (var i = 0u; i < count; i++) { if (i * i > lane) { return i; } }
    return 99u;
}
";
const WORLD: [u32; 2] = [13, 20];
const LANES: u32 = 8;

fn part(path: &str, text: String) -> Part {
    Part {
        path: path.into(),
        text,
    }
}

fn generic(body: &str) -> Generic {
    let kernel = format!(
        "@compute @workgroup_size(64)\nfn main(@builtin(local_invocation_index) lane: u32) {{\n    var sum = 0u;\n    \
         let count = min(worlds[0].count, 20u);\n    {body}\n    out[lane] = sum;\n}}\n"
    );
    let parts = [part("buffers", BUFFERS.into()), part("kernel", kernel)];
    Generic::new(&parts).unwrap_or_else(|refusals| panic!("`{body}`: {}", refusals[0]))
}

/// Buffers after a kernel has run, and the most turns of an invocation.
fn run(generic: &Generic, mut buffers: Vec<Vec<u32>>) -> Result<(Vec<Vec<u32>>, u64), Trap> {
    let strides: Vec<u32> = generic.bindings.iter().map(|binding| binding.stride / 4).collect();
    let mut memory = Memory {
        buffers: &mut buffers,
        strides: &strides,
    };
    let mut most = 0;
    for lane in 0..LANES {
        most = most.max(run_invocation(generic.any(), &mut memory, 0, lane, true)?);
    }
    Ok((buffers, most))
}

/// The kernel with unrolled loops, for what the buffers hold, and the turns that it is said to take.
fn unrolled(generic: &Generic, buffers: &[Vec<u32>], most: u64) -> Option<(Generic, u64)> {
    let word = |name: &str, element: Option<u64>, word: u32| {
        let at = generic
            .bindings
            .iter()
            .position(|binding| binding.name == name)
            .expect("a buffer");
        let first = element.unwrap_or(0) as usize * (generic.bindings[at].stride / 4) as usize;
        buffers[at][first + word as usize]
    };
    let (variant, [said, _]) = generic.unrolled([&word, &word], most)?;
    variant
        .spirv(variant.any(), Indices::Clamped)
        .unwrap_or_else(|problem| panic!("{problem}"));
    Some((variant, said))
}

/// The smallest `most` for which there is a program, down to 2, at each of which the bits are the same.
fn same(generic: &Generic, buffers: &[Vec<u32>], what: &str) -> Option<u64> {
    let (expected, turns) = run(generic, buffers.to_vec()).ok()?;
    let mut least = None;
    let mut most = turns;
    while let Some((variant, said)) = unrolled(generic, buffers, most) {
        let (found, turns) = run(&variant, buffers.to_vec()).unwrap_or_else(|trap| panic!("{what}, {most}: {trap}"));
        assert!(found == expected, "{what}: other bits with {most} turns");
        assert!(
            turns <= said && said <= most,
            "{what}: {turns} turns of {said} of {most}"
        );
        least = Some(said);
        if said <= 4 {
            break;
        }
        most = said - 1;
    }
    least
}

#[test]
fn unrolled_loops_do_the_same() {
    for body in [
        "for (var i = 0u; i < 7u; i++) { sum += i * lane; }",
        "for (var i = 2u; i <= count; i += 3u) { sum = sum * 5u + i; }",
        "for (var i = 0u; i < count; i++) { if (i % 3u == lane % 3u) { continue; } sum = sum * 5u + i; }",
        "for (var i = 0u; i < count; i++) { if (i == lane + 5u) { break; } sum = sum * 5u + i; }",
        "for (var i = 0u; (i < count) & (sum < 50u); i++) { sum = sum * 5u + i; }",
        "for (var i = 0u; i < count; i++) { for (var j = i; j < count; j++) { sum = sum * 5u + i * j; } }",
        "for (var i = 0u; i < count; i++) { for (var j = 0u; j < 4u; j++) { if (i * j > lane) { break; } sum += j; } }",
        "var a = array<u32, 4>(); for (var i = 0u; i < 4u; i++) { a[i] = i * lane; } for (var i = 0u; i < 4u; i++) { sum += a[i]; }",
        "for (var i = 0u; i < count; i++) { var own = i; for (var j = 0u; j < 3u; j++) { own += own; } sum += own; }",
        "for (var i = 0u; i < count; i++) { sum += first(lane + i, count); }",
        "for (var i = 0u; i < count; i++) { out[lane] = out[lane] * 3u + i; } sum = out[lane];",
    ] {
        let buffers = [vec![0, 0], WORLD.to_vec(), vec![1; 64]];
        let least = same(&generic(body), &buffers, body);
        assert!(least.is_some_and(|least| least <= 13), "{least:?}: {body}");
    }
}

/// Loops that count up to a word of the dispatch turn more often in another one.
#[test]
fn loops_over_cycles_stay_loops() {
    let generic = generic(
        "for (var i = dispatch.begin; i < min(dispatch.end, 100u); i++) { for (var j = 0u; j < count; j++) { sum = sum * 5u + i; } }",
    );
    let buffers = |end: u32| vec![vec![4, end], WORLD.to_vec(), vec![0; 64]];
    let (variant, _) = unrolled(&generic, &buffers(5), 5).unwrap();
    for end in [4, 5, 60] {
        let (expected, found) = (run(&generic, buffers(end)), run(&variant, buffers(end)));
        assert_eq!(expected.unwrap().0, found.unwrap().0, "{end}");
    }
}

#[test]
fn random_kernels_do_the_same() {
    let mut shorter = 0;
    for seed in 0..100 {
        let text = generate::kernel(seed, 20 + (seed % 80) as u32);
        let parts = [part("prelude", generate::PRELUDE.into()), part("kernel", text.clone())];
        let Ok(generic) = Generic::new(&parts) else { continue };
        let buffers = generate::buffers(seed, 1);
        shorter += u32::from(same(&generic, &buffers, &format!("seed {seed}\n{text}")).is_some());
    }
    assert!(shorter > 10, "{shorter}");
}
