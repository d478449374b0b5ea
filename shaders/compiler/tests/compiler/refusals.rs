//! Everything that could differ between devices is refused, with its place; everything on the list is accepted.

use oneiro_shader_compiler::Rule::{
    ExactFunctions, FiniteConstants, LoopWithoutBound, SameIndex, UnknownName, ValidWgsl,
};
use oneiro_shader_compiler::{Indices, Part, Refusals, Rule, compile};

const BUFFERS: &str = "\
@group(0) @binding(0) var<storage, read> numbers: array<f32>;
@group(0) @binding(1) var<storage, read> words: array<u32>;
@group(0) @binding(2) var<storage, read_write> out: array<f32>;
@group(0) @binding(3) var<storage, read_write> out_words: array<u32>;
";
const START: &str = "\
@compute @workgroup_size(64)
fn main(@builtin(local_invocation_index) lane: u32, @builtin(workgroup_id) group: vec3<u32>) {
    let x = numbers[lane];
    let u = words[lane];
    let i = bitcast<i32>(u);
    let v = vec3<f32>(x, 1.0f, x);
";

fn check(kernel: &str) -> Result<(), Refusals> {
    let part = |path: &str, text: &str| Part {
        path: path.into(),
        text: text.into(),
    };
    compile(
        "kernel",
        &[part("buffers", BUFFERS), part("kernel", kernel)],
        Indices::Clamped,
    )
    .map(|_| ())
}

/// Checks that a statement is refused at its line, with a message that contains these words.
fn refused(statement: &str, words: &str) {
    let kernel = format!("{START}    {statement}\n}}\n");
    assert_refused(&kernel, 7, statement, words);
}

/// Checks that a declaration is refused at its line.
fn refused_outside(declaration: &str, words: &str) {
    let kernel = format!("// A comment: 1.0 / 2.0\n{declaration}\n{START}}}\n");
    assert_refused(&kernel, 2, declaration, words);
}

fn assert_refused(kernel: &str, line: usize, what: &str, words: &str) {
    let Err(refusals) = check(kernel) else {
        panic!("`{what}` is taken");
    };
    let place = format!("kernel:{line}:");
    let fits = |refusal: &String| refusal.starts_with(&place) && refusal.contains(words);
    let messages: Vec<_> = refusals.iter().map(ToString::to_string).collect();
    assert!(messages.iter().any(fits), "`{what}` at {place}: {messages:#?}");
    // Rules for parts explain what parts can write; parts name no buffers.
    let is_internal = refusals.iter().any(|refusal| refusal.rule == Rule::Internal);
    let names_buffers = ["out", "<workgroup>"].iter().any(|words| what.contains(words));
    assert!(!is_internal || names_buffers, "`{what}`: {messages:#?}");
}

fn taken(statement: &str) {
    if let Err(refusals) = check(&format!("{START}    {statement}\n}}\n")) {
        panic!("`{statement}`: {}", refusals[0]);
    }
}

/// What devices compute in different ways, and the library of the compiler computes instead.
#[test]
fn ordinary_wgsl_is_taken() {
    for statement in [
        "out[lane] = x / 2.0f;",
        "let unused = x / 2.0;",
        "_ = v / x;",
        "var y = x; y /= 2.0;",
        "out[lane] = x % 2.0;",
        "var y = v; y %= v;",
        "out[lane] = 1.0 / 3.0;",
        "const third = 1.0 / 3.0; out[lane] = third;",
        "out[lane] = x * (5.0 % 3.0);",
        "out[lane] = f32(1) / f32(3);",
        "out[lane] = (vec2(1.0, 2.0) / 3.0).x;",
        "out[lane] = f32(7u / 2u) + f32(7 % 2);",
        "let q = i / 3;",
        "var q = i; q %= 3;",
        "let q = vec2<i32>(i, i) / i;",
        "out_words[lane] = u << u;",
        "out_words[lane] = u32(i >> (u & 63u));",
        "var w = u; w <<= u - u;",
        "let pair = vec2<u32>(u, 1u) << vec2<u32>(1u, u);",
        "out[lane] = sqrt(2.0) + length(vec2(3.0, 4.0)) + radians(90.0) + x;",
        "out_words[lane] = dot(vec2<u32>(u, 1u), vec2<u32>(2u, 3u)) + u32(dot(vec2<i32>(i, 1), vec2<i32>(2, 3)));",
        "let angle = 0.5; out[lane] = sin(angle) + mix(v, v, v).x + mix(v, v, 0.5).y;",
        "for (var k = 0u; k < 3u; k++) { out[lane] = sqrt(f32(k)); }",
        "if (sqrt(x) > 1.0 && exp(x) < 2.0) { out[lane] = log(x); }",
        "let parts = modf(x); out[lane] = parts.fract + parts.whole;",
        "var parts = frexp(v); parts.exp += vec3(1); parts = frexp(2.0 * v); out[lane] = ldexp(parts.fract, parts.exp).x;",
        "var m = mat2x2<f32>(x, 1.0, 2.0, 3.0); m[1] = m * m[0]; m[0].x = 1.0; out[lane] = (m * m)[1].y;",
        "let m = mat2x2f(v.xy, v.yx); out[lane] = m[u].x + m[0][1] + (v * mat2x3f(v, v)).x;",
        "var m: mat4x3f; m[u][u % 3u] = x; m[1u][u] += m[u].y; out[lane] = m[u][i];",
        "var all: array<mat3x3f, 2>; all[1] = mat3x3f(v, v, v) * 2; out[lane] = all[1][2].z + all[u][1].x;",
        "switch (u / 2u) { case 1u: { out[lane] = cos(x); } default: { out[lane] = atan2(x, 1.0); } }",
    ] {
        taken(statement);
    }
    for (name, arguments) in ORDINARY {
        taken(&format!("let result = {name}({arguments});"));
        taken(&format!("if (false) {{ _ = {name} ({arguments}); }}"));
    }
    let helper = "fn f(x: f32) -> f32 { return sqrt(x) / x; }\nconst K = sqrt(2.0) / 3.0;\nfn length(x: f32) -> f32 { return x; }\n";
    let kernel = format!("{helper}{START}    out[lane] = f(x) + length(K);\n}}\n");
    assert_eq!(check(&kernel), Ok(()));
}

const ORDINARY: [(&str, &str); 52] = [
    ("sqrt", "x"),
    ("inverseSqrt", "v"),
    ("exp", "x"),
    ("exp2", "x"),
    ("log", "x"),
    ("log2", "v"),
    ("sin", "v.xy"),
    ("cos", "x"),
    ("tan", "x"),
    ("asin", "x"),
    ("acos", "x"),
    ("atan", "x"),
    ("atan2", "v, v"),
    ("sinh", "x"),
    ("cosh", "v"),
    ("tanh", "x"),
    ("asinh", "x"),
    ("acosh", "v.xy"),
    ("atanh", "x"),
    ("ldexp", "x, 2"),
    ("frexp", "v"),
    ("modf", "x"),
    ("refract", "v, v, x"),
    ("faceForward", "v, v, v"),
    ("transpose", "mat2x3(v, v)"),
    ("determinant", "mat3x3(v, v, v)"),
    ("pow", "v, v"),
    ("fma", "x, x, x"),
    ("mix", "x, x, 0.5"),
    ("smoothstep", "v, v, v"),
    ("step", "x, x"),
    ("fract", "x"),
    ("round", "x"),
    ("ceil", "x"),
    ("sign", "i"),
    ("saturate", "x"),
    ("radians", "x"),
    ("degrees", "x"),
    ("dot", "v, v"),
    ("length", "v"),
    ("distance", "x, x"),
    ("normalize", "v"),
    ("cross", "v, v"),
    ("reflect", "v, v"),
    ("all", "v < v"),
    ("any", "v < v"),
    ("countOneBits", "u"),
    ("countLeadingZeros", "i"),
    ("countTrailingZeros", "vec2(u)"),
    ("firstLeadingBit", "i"),
    ("firstTrailingBit", "u"),
    ("reverseBits", "i"),
];

/// A constant would have the bits of the library of the machine that compiles.
#[test]
fn functions_of_constants() {
    for (name, argument) in [
        ("sin", "1.0"),
        ("exp", "1.0f"),
        ("atan2", "1.0, 2"),
        ("pow", "2.0, 0.5"),
        ("log2", "vec2(3.0)"),
        ("sinh", "1.0"),
        ("acosh", "2.0"),
    ] {
        let words = format!("`{name}` of a constant");
        refused(&format!("let a = {name}({argument});"), &words);
        refused(&format!("let b = 2.0 * {name} ({argument});"), &words);
        refused_outside(&format!("const K = {name}({argument});"), &words);
        refused_outside(&format!("fn unused() {{ _ = {name}({argument}); }}"), &words);
    }
    refused(
        "switch (u) { case u32(exp(1.0)): { return; } default: {} }",
        "`exp` of a constant",
    );
    refused(
        "var a: array<f32, u32(exp(1.0))>; out[lane] = a[0];",
        "`exp` of a constant",
    );
    refused("const_assert sin(1.0) < 1.0;", "`sin` of a constant");
}

#[test]
fn functions() {
    for (name, arguments) in [
        ("quantizeToF16", "x"),
        ("pack2x16float", "v.xy"),
        ("unpack2x16float", "u"),
        ("pack4x8unorm", "v.xxxx"),
        ("unpack4x8snorm", "u"),
        ("dot4U8Packed", "u, u"),
        ("extractBits", "u, 1u, 2u"),
        ("insertBits", "u, u, 1u, 2u"),
        ("arrayLength", "&words"),
        ("subgroupAdd", "u"),
        ("subgroupBallot", "true"),
        ("quadSwapX", "u"),
        ("dpdx", "x"),
    ] {
        let message = format!("`{name}` is not on the list");
        refused(&format!("let result = {name}({arguments});"), &message);
        refused(&format!("if (false) {{ _ = {name} ({arguments}); }}"), &message);
        refused_outside(
            &format!("fn unused(x: f32, u: u32, v: vec3<f32>) {{ _ = {name}({arguments}); }}"),
            &message,
        );
    }
    refused(
        "let result = vec2<f32>(x, quantizeToF16(x));",
        "`quantizeToF16` is not on the list",
    );
    refused_outside("const e = quantizeToF16(1.0f);", "`quantizeToF16` is not on the list");
    refused_outside(
        "fn abs(x: f32) -> f32 { return x; }\nfn f() { _ = abs(1.0f); }",
        "`abs` shadows a WGSL built-in",
    );
}

#[test]
fn pointers_into_variables() {
    let text = format!(
        "{START}    var two = Two(u, u); increase(&two.a);\n}}\nfn increase(p: ptr<function, u32>) {{ *p += 1u; }}\nstruct Two {{ a: u32, b: u32 }}\n"
    );
    assert_refused(
        &text,
        7,
        "increase(&two.a)",
        "a pointer to a part of a variable can't be passed",
    );
}

#[test]
fn kernels_that_are_too_large() {
    refused(
        "var large = array<f32, 20000>(); _ = large[0];",
        "this variable is too large; allowed: 65536 bytes",
    );
    refused(
        "let large = array<f32, 20000>(); _ = large[0];",
        "this value is too large; allowed: 65536 bytes",
    );
    refused_outside(
        "var<private> large: array<f32, 20000>;",
        "this variable is too large; allowed: 65536 bytes",
    );
    let mut lines = vec![
        "@compute @workgroup_size(64) fn main() { _ = call40(1.0f); }".to_owned(),
        "fn call0(x: f32) -> f32 { return x; }".to_owned(),
    ];
    lines.extend((0..40).map(|depth| {
        let next = depth + 1;
        format!("fn call{next}(x: f32) -> f32 {{ return call{depth}(x) + call{depth}(x + 1.0f); }}")
    }));
    let kernel = lines.join("\n");
    let part = Part {
        path: "kernel".into(),
        text: kernel,
    };
    let refusals = compile("kernel", &[part], Indices::Clamped).unwrap_err();
    assert!(
        refusals[0].to_string().contains("too large with all its calls inlined"),
        "{}",
        refusals[0]
    );
}

#[test]
fn memory_that_others_see() {
    for name in ["workgroupBarrier", "storageBarrier"] {
        refused(&format!("{name}();"), &format!("`{name}` is not on the list"));
    }
    refused_outside("var<workgroup> shared_words: array<u32, 64>;", "address space");
    for ty in ["atomic<u32>", "array<atomic<u32>>"] {
        let declaration = format!("@group(0) @binding(4) var<storage, read_write> counter: {ty};");
        refused_outside(&declaration, "`atomic` is not supported");
    }
    refused("out[0] = x;", "different values at one address");
    refused("out[group.x] = x;", "different values at one address");
    refused(
        "for (var k = 0u; k < 3u; k++) { out[k] = x; }",
        "different values at one address",
    );
    refused(
        "var some = 0u; if (x > 0.0f) { some = 1u; } out_words[0] = some;",
        "different values",
    );
}

#[test]
fn constants() {
    for constant in ["2.0", "2.", ".5", "5e-1", "1E3", "0x1.8p0", "0X1P3"] {
        taken(&format!("const k = {constant}; out[lane] = x * {constant} + k;"));
    }
    refused("out[lane] = f32(1.0h);", "`1.0h` has 16 bits");
    refused("out[lane] = 1e-40f;", "a constant is subnormal");
    refused("out[lane] = 1e-30f * 1e-15f;", "a constant is subnormal");
    refused("out[lane] = bitcast<f32>(1u);", "a constant is subnormal");
    refused("out[lane] = bitcast<f32>(0x7fc00000u);", "a constant is not finite");
    refused(
        "out[lane] = bitcast<vec2<f32>>(vec2<u32>(1065353216u, 0x7f800000u)).y;",
        "a constant is not finite",
    );
    refused_outside(
        "const infinite = 0xff800000u; fn f() -> f32 { return bitcast<f32>(infinite); }",
        "not finite",
    );
    // naga refuses these two.
    refused("out[lane] = 3e38f * 10.0f;", "greater than an f32 can be");
    refused("out[lane] = 1e39f;", "numeric literal not representable");
}

#[test]
fn integers() {
    for count in ["32u", "40u", "u32(7 * 7)"] {
        let words = "a constant number of bits";
        refused_outside(&format!("fn f(u: u32) -> u32 {{ return u << {count}; }}"), words);
        refused_outside(&format!("fn f(i: i32) -> i32 {{ return i >> {count}; }}"), words);
    }
    refused("out_words[lane] = u / 0u;", "Division by zero");
}

#[test]
fn types() {
    for ty in ["mat2x2h", "f16", "vec2h", "array<mat4x3h, 2>"] {
        refused(&format!("var unused: {ty};"), "is not supported in kernels");
        refused_outside(&format!("alias Other = {ty};"), "is not supported in kernels");
        refused_outside(
            &format!("struct Other {{ member: {ty} }}"),
            "is not supported in kernels",
        );
    }
    refused("let m = mat2x2h(x, x, x, x);", "`mat2x2h` is not on the list");
    for ty in ["texture_2d<f32>", "texture_storage_2d<r32float, write>", "sampler"] {
        refused_outside(
            &format!("@group(0) @binding(4) var other: {ty};"),
            "is not supported in kernels",
        );
    }
    refused_outside("override factor: f32 = 1.0f;", "override constants");
    refused_outside(
        "@group(0) @binding(4) var<storage, read> other: array<bool>;",
        "HOST_SHAREABLE",
    );
}

#[test]
fn indices() {
    for statement in [
        "var a: array<f32, 4>; a[u & 3u] = 1.0f; out[lane] = a[0];",
        "var a: array<f32, 4>; out[lane] = a[lane];",
        "var a: array<f32, 4>; let element = &a[u & 3u]; *element = 1.0f; out[lane] = a[1];",
        "var a: array<vec2<f32>, 4>; out[lane] = a[u].y;",
        "out[lane] = v[u % 3u];",
        "var w = v; w[group.x % 3u] = x; out[lane] = w.x;",
        "let a = array<f32, 2>(x, 1.0f); out[lane] = a[group.x];",
        "var a = array<f32, 2>(x, 1.0f); let b = a; out[lane] = b[0];",
    ] {
        taken(statement);
    }
    let message = "more than 256 elements has to be the same in all episodes";
    refused("var a: array<f32, 257>; a[u & 3u] = 1.0f; out[lane] = a[0];", message);
    refused("var a: array<f32, 257>; out[lane] = a[lane];", message);
}

#[test]
fn whole_kernels() {
    let refused = |kernel: &str, words: &str| {
        let refusals = check(kernel).expect_err(kernel);
        assert!(refusals[0].to_string().contains(words), "`{kernel}`: {}", refusals[0]);
        refusals[0].place.to_string()
    };
    let main = "@compute @workgroup_size(64)\nfn main() {}\n";
    refused("", "one entry point, this has 0");
    refused(
        &format!("{main}@compute @workgroup_size(64) fn other() {{}}"),
        "one entry point, this has 2",
    );
    refused(
        &format!("{main}@fragment fn other() {{}}"),
        "one entry point, this has 2",
    );
    refused(&main.replace("main", "start"), "must be `main`");
    refused(&main.replace("64", "8, 8"), "one-dimensional workgroup");
    refused(&main.replace("64", "65"), "a multiple of 64 invocations");
    refused(&main.replace("{}", "{ discard; }"), "`discard` is not supported");
    refused(&main.replace("{}", "{ let a = ; }"), "expected expression");
    for builtin in [
        "num_workgroups",
        "local_invocation_index) lane: u32, @builtin(num_workgroups",
    ] {
        let place = refused(
            &main.replace("()", &format!("(@builtin({builtin}) n: vec3<u32>)")),
            "depend on how",
        );
        assert!(place.starts_with("kernel:2:"), "{place}");
    }
    refused(&main.replace("()", "(@builtin(subgroup_size) n: u32)"), "SUBGROUP");
    let bound = |declaration: &str| format!("{declaration}\n{main}");
    refused(
        &bound("@group(1) @binding(0) var<storage> other: array<u32>;"),
        "is in group 1",
    );
    refused(
        &bound("@group(0) @binding(5) var<storage> other: array<u32>;"),
        "is binding 5, but 4 comes next",
    );
    refused(
        &bound("@group(0) @binding(3) var<storage> other: array<u32>;"),
        "is binding 3, but 4 comes next",
    );
    refused(
        &bound("@group(0) @binding(4) var<storage> other: array<u32, 8>;"),
        "has the buffer's length",
    );
    refused(
        &bound("@group(0) @binding(4) var<uniform> other: array<vec4<u32>, 8>;"),
        "has the buffer's length",
    );
}

/// The line of each refusal of some statements, the first of which is on line 1, and its rule.
fn all_refused(statements: &[&str]) -> Vec<(usize, Rule)> {
    let kernel = format!("{START}{}\n}}\n", statements.join("\n"));
    let line = |place: usize| place - START.lines().count();
    check(&kernel)
        .unwrap_err()
        .iter()
        .map(|refusal| (line(refusal.place.line), refusal.rule))
        .collect()
}

#[test]
fn everything_is_refused_at_once() {
    let of_values = [
        "while (x < numbers[3]) { out[lane] = f32(extractBits(u, 1u, 2u)); }",
        "out[lane] = 1e-40;",
        "out[lane] = f32(extractBits(u, 1u, 2u)) / 2.0;",
        "out[lane] = f32(extractBits(u, 1u, 2u)) + 1e-40;",
    ];
    // A function that has no form in lane code hides the loop.
    let expected = [
        (1, ExactFunctions),
        (2, FiniteConstants),
        (3, ExactFunctions),
        (4, ExactFunctions),
        (4, FiniteConstants),
    ];
    assert_eq!(all_refused(&of_values), expected);
    let loops = [
        "for (var k = 0u; k < u; k++) { out[lane] = 1e-40; }",
        "out[lane] = 1e-41;",
        "var a: array<f32, 999>; a[u & 3u] = 1.0f; out[lane] = a[0];",
        "while (x < numbers[lane]) {}",
    ];
    let [first, constant, index, last] = [
        (1, LoopWithoutBound),
        (2, FiniteConstants),
        (3, SameIndex),
        (4, LoopWithoutBound),
    ];
    assert_eq!(
        all_refused(&loops),
        [first, (1, FiniteConstants), constant, index, last]
    );
    assert_eq!(all_refused(&["", "", loops[2], loops[3]]), [index, last]);
    // A syntax error only hides what the text alone doesn't show.
    let unparsed = ["out[lane] = sine(y);", "out[lane] = quantizeToF16(x);"];
    assert_eq!(all_refused(&unparsed), [(1, UnknownName), (2, ExactFunctions)]);
    let unparsed = ["out[lane] = ;", "out[lane] = quantizeToF16(x);"];
    assert_eq!(all_refused(&unparsed), [(1, ValidWgsl), (2, ExactFunctions)]);
    // A function is inlined at each of its calls, and refused once.
    let twice = format!("{START}}}\nfn f(u: u32) {{ for (var k = 0u; k < u; k++) {{ _ = 1e-40; }} }}\n");
    let twice = twice.replace("let x", "f(words[lane]); f(words[lane] + 1u); let x");
    let rules: Vec<_> = check(&twice).unwrap_err().iter().map(|refusal| refusal.rule).collect();
    assert_eq!(rules, [LoopWithoutBound, FiniteConstants]);
}

/// A name that neither WGSL nor the kernel has is not said to be inexact.
#[test]
fn unknown_names() {
    for (statement, words) in [
        (
            "out[lane] = recirpocal(x);",
            "there is no function `recirpocal` [unknown-name]",
        ),
        ("out[lane] = recirpocal;", "nothing declares `recirpocal`"),
        ("let w = v.length;", "invalid field accessor `length`"),
    ] {
        refused(statement, words);
        assert_eq!(all_refused(&[statement]), [(1, UnknownName)]);
    }
}

#[test]
fn the_list_is_taken() {
    for statement in [
        "out[lane] = x + x - x * x;",
        "out[lane] = -abs(floor(trunc(x)));",
        "out[lane] = select(min(x, 1.0f), max(x, -1.0f), x < 2.0f);",
        "out[lane] = clamp(x, 0.0f, 0x1.8p3f) + 1.f + .5f + 1e-3f;",
        "out[lane] = f32(u & 0xffffffu) + f32(i & 255i) + f32(x > 1.0f);",
        "out_words[lane] = u32(clamp(x, 0.0f, 9.0f)) + u32(i32(clamp(x, -9.0f, 9.0f))) + u32(x != 0.0f);",
        "out_words[lane] = bitcast<u32>(select(x, 0.0f, x == 0.0f)) ^ ~u | (u & 3u);",
        "out[lane] = bitcast<f32>((u & 0x7fffffu) | 0x3f800000u);",
        "out_words[lane] = u / 3u + u % (u | 1u) - u * 5u;",
        "out_words[lane] = (u << 31u) >> (u & 31u) >> (31u & u);",
        "out_words[lane] = u32(-abs(i) + min(i, 3) - clamp(i, -1, 1) >> 2u);",
        "let s = 5u; out_words[lane] = u << s;",
        "out_words[lane] = vec3<u32>(u, u, 1u).zyx[2];",
        "out[lane] = (v * v - v * x).y;",
        "if (x > 1.0f && !(u == 3u) || lane < 5u) { return; }",
        "switch (u) { case 1u, 2u: { return; } default: { } }",
        "var a = array<f32, 2>(x, 1.0f); a[group.x] = 2.0f; out[lane] = a[1];",
        "out_words[group.x] = group.x;",
        "if (x > 1.0f) { out_words[0] = 7u; }",
        "out_words[i] = words[i];",
        "/* x / 2.0 and sin(x) */ return; // 1.0 / 3.0",
    ] {
        taken(statement);
    }
}
