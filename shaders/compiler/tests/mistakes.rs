//! Mistakes that naga finds are described in WGSL's words, with the types and names of the kernel.

use oneiro_shader_compiler::{Part, compile};

/// A kernel with these declarations, and this body of a function that returns a `Pair`.
fn refusal(declarations: &str, body: &str) -> String {
    let text = format!(
        "@group(0) @binding(0) var<storage, read_write> out: array<f32>;
struct Pair {{ first: f32, second: vec2<f32> }}
fn twice(x: f32, times: u32) -> f32 {{ return 2.0f * x; }}
{declarations}
fn made(x: f32, n: u32) -> Pair {{ {body} }}
@compute @workgroup_size(64)
fn main(@builtin(local_invocation_index) lane: u32) {{ out[lane] = made(f32(lane), lane).first; }}
"
    );
    let part = Part {
        path: "own.wgsl".into(),
        text,
    };
    let refusals = compile("test", &[part]).unwrap_err();
    refusals[0].to_string()
}

#[test]
fn mistakes_have_plain_words() {
    let whole = "return Pair(x, vec2<f32>(x, x));";
    let cases = [
        ("", "return x;", "in `made`: returns f32; its head says Pair"),
        (
            "",
            "let y = x;",
            "in `made`: it can end without a result; write `return VALUE;`, of type Pair",
        ),
        (
            "",
            "return Pair(x);",
            "in `made`: `Pair` is made of 2 values, and is given 1; allowed: first: f32, second: vec2<f32>",
        ),
        (
            "",
            "return Pair(n, vec2<f32>(x, x));",
            "value 1 of `Pair` is u32; allowed: first: f32; write `f32(x)` for the u32, or `1.0f` for a constant",
        ),
        (
            "",
            "return Pair(twice(x, x), vec2<f32>(x, x));",
            "argument 2 of `twice` is f32; allowed: u32; write `f32(x)` for the u32, or `1.0f` for a constant",
        ),
        (
            "",
            "return Pair(twice(x), vec2<f32>(x, x));",
            "`twice` takes 2 arguments, and is given 1",
        ),
        (
            "",
            "return Pair(x + n, vec2<f32>(x, x));",
            "`+` takes operands of one type; here they are f32 and u32; write `f32(x)` for the u32, or `1.0f` for a constant",
        ),
        (
            "",
            "return Pair(x, vec2<f32>(x, x) - vec3<f32>(x, x, x));",
            "`-` takes operands of one type; here they are vec2<f32> and vec3<f32>",
        ),
        (
            "",
            "if (x) { } return Pair(x, vec2<f32>(x, x));",
            "the condition of `if` is f32; allowed: bool",
        ),
        (
            "struct Nothing { }",
            whole,
            "`Nothing` has no field; write one, or leave the struct out",
        ),
    ];
    let mut problems = Vec::new();
    for (declarations, body, message) in cases {
        let refused = refusal(declarations, body);
        if !refused.contains(message) {
            problems.push(format!("{body}\n{refused}\nexpected: {message}"));
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n\n"));
}
