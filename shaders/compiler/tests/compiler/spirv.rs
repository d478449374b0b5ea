//! In SPIR-V, all float results have `NoContraction`, and the validator accepts the modules.

use std::io::Write;
use std::process::{Command, Stdio};

use oneiro_shader_compiler::spirv::{decorated, float_arithmetic, without_contraction};
use oneiro_shader_compiler::{Indices, Part, compile, generate};

use crate::skips::skipped;

/// All kinds of float operations, on scalars and vectors, in functions and in branches.
const OPERATIONS: &str = "
@group(0) @binding(0) var<storage, read> numbers: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> results: array<vec4<f32>>;

fn scaled(v: vec4<f32>, by: f32) -> vec4<f32> {
    return v * by + by * v;
}

fn unused(x: f32) -> f32 {
    return x * 3.0f - 1.0f;
}

@compute @workgroup_size(64)
fn main(@builtin(local_invocation_index) lane: u32) {
    let v = numbers[lane];
    var sum = v + numbers[lane + 1u];
    if (v.x < 0.5f) {
        sum = -sum * scaled(v - sum, v.y);
    }
    sum.x += -v.z;
    sum.y *= 0.1f;
    results[lane] = sum;
}
";

fn part(path: &str, text: &str) -> Part {
    Part {
        path: path.into(),
        text: text.into(),
    }
}

fn spirv(parts: &[Part]) -> Vec<u32> {
    compile("kernel", parts, Indices::Clamped)
        .unwrap_or_else(|refusals| panic!("{}", refusals[0]))
        .spirv
}

/// The kernels that ship are checked where they are compiled, in `oneiro-shaders`.
fn modules() -> Vec<(String, Vec<u32>)> {
    let mut all = vec![("operations".to_owned(), spirv(&[part("operations", OPERATIONS)]))];
    for seed in [1, 2, 3] {
        let text = generate::kernel(seed, 60);
        let parts = [part("prelude", generate::PRELUDE), part("kernel", &text)];
        all.push((format!("random {seed}"), spirv(&parts)));
    }
    all
}

/// Number of float results that are not decorated.
fn bare(words: &[u32]) -> usize {
    let decorated = decorated(words);
    float_arithmetic(words)
        .iter()
        .filter(|id| !decorated.contains(id))
        .count()
}

#[test]
fn every_float_result_is_decorated() {
    for (name, words) in modules() {
        assert!(!float_arithmetic(&words).is_empty(), "{name} has no float operations");
        assert_eq!(bare(&words), 0, "{name}");
    }
    // v*by, by*v, +; x*3, -1; +; v-sum, -sum, *; -v.z, +=, *=
    assert_eq!(float_arithmetic(&modules()[0].1).len(), 12);
}

#[test]
fn one_result_less_is_seen() {
    let words = &modules()[0].1;
    for k in 0..float_arithmetic(words).len() {
        let less = without_contraction(words, &[k]);
        assert_eq!(less.len(), words.len() - 3);
        assert_eq!(bare(&less), 1, "result {k}");
        assert_eq!(without_contraction(&less, &[]), *words);
    }
}

/// Validates a module with `spirv-val`. Returns `None` if it is not installed.
fn validate(words: &[u32]) -> Option<Result<(), String>> {
    let mut child = Command::new("spirv-val")
        .args(["--target-env", "vulkan1.1", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .ok()?;
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    child.stdin.take()?.write_all(&bytes).ok()?;
    let output = child.wait_with_output().ok()?;
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    Some(if output.status.success() { Ok(()) } else { Err(message) })
}

#[test]
fn modules_are_valid() {
    for (name, words) in modules() {
        let Some(valid) = validate(&words) else {
            skipped("spirv-val", "whether modules are valid (Debian has it in spirv-tools)");
            return;
        };
        assert_eq!(valid, Ok(()), "{name}");
        let mut broken = words;
        broken.truncate(broken.len() - 1);
        assert!(
            validate(&broken).is_some_and(|valid| valid.is_err()),
            "{name}: a broken module passed"
        );
    }
}
