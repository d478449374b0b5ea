//! Mistakes that naga finds are described in WGSL's words, with the types and names of the kernel.

use oneiro_shader_compiler::{Compiled, Indices, Part, compile};

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
    let refusals = compile("test", &[part], Indices::Clamped)
        .and_then(Compiled::bounded)
        .and_then(Compiled::used)
        .unwrap_err();
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
            "value 1 of `Pair` is u32; allowed: first: f32; write `f32(x)`, or `1.0f` for a constant",
        ),
        (
            "",
            "return Pair(twice(x, x), vec2<f32>(x, x));",
            "argument 2 of `twice` is f32; allowed: u32; write `u32(x)`, or `1u` for a constant",
        ),
        (
            "",
            "return Pair(twice(x), vec2<f32>(x, x));",
            "`twice` takes 2 arguments, and is given 1; write `twice(x, times)`",
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

/// A refusal's message, without its place and its rule.
fn said(declarations: &str, body: &str) -> String {
    let refused = refusal(declarations, body);
    let (_, message) = refused.split_once(": ").unwrap();
    let (message, _) = message.rsplit_once(" [").unwrap();
    message.to_owned()
}

#[test]
fn habits_from_other_languages_are_answered() {
    const LOOP: &str = "in `made`: this loop has no bound known before it runs; ";
    const SAME_INDEX: &str = "the index of a local array of more than 256 elements has to be the same in all episodes, a constant or the counter of a loop; \
        go through the array: `for (var i = 0u; i < COUNT; i++)` with `x = select(x, a[i], i == index);` to read an element, \
        and `a[i] = select(a[i], x, i == index);` to write one";
    let whole = "return Pair(x, vec2<f32>(x, x));";
    let cases = [
        ("let y = x let z = x;", "expected `;`, found \"let\""),
        (
            "float foo = 0.0f;",
            "`float foo` declares nothing in WGSL; write `var foo = 0.0f;`",
        ),
        (
            "for (int i = 0; i < 3; i++) {}",
            "`int i` declares nothing in WGSL; write `var i = 0u;`",
        ),
        (
            "let y = x > 0.0f ? 1.0f : 0.0f;",
            "WGSL has no `?`; write `select(b, a, condition)` for `condition ? a : b`",
        ),
        (
            "# hello\n",
            "WGSL has no `#`; write `//` before a comment, and `const NAME = VALUE;` for a `#define`",
        ),
        ("if x > 0.0f and x < 1.0f {}", "WGSL has no `and`; write `&&`"),
        ("if x > 0.0f or x < 1.0f {}", "WGSL has no `or`; write `||`"),
        (
            "let y = 1.0f; y = 2.0f;",
            "`y` is declared by `let`, and nothing can be assigned to it; declare it by `var`",
        ),
        (
            "let y = 1.0f; y += 2.0f;",
            "`y` is declared by `let`, and nothing can be assigned to it; declare it by `var`",
        ),
        (
            "x = 2.0f;",
            "`x` is a parameter, and nothing can be assigned to it; copy it: `var next = x;`",
        ),
        (
            "var v = vec2<f32>(x, x); v.xy = vec2<f32>(x, 1.0f);",
            "several components can't be assigned to at once; write `v.x = ..;` and so on, one by one",
        ),
        (
            "var count = n; count = x > 0.0f;",
            "the value is bool; allowed: u32; write `select(0u, 1u, x)`",
        ),
        (
            "var count = n; count = 1.0f;",
            "the value is f32; allowed: u32; write `u32(x)`, or `1u` for a constant",
        ),
        (
            "var count = n; count = i32(x);",
            "the value is i32; allowed: u32; write `u32(x)`, or `1u` for a constant",
        ),
        (
            "var ends = false; ends = x;",
            "the value is f32; allowed: bool; write `x != 0.0f`",
        ),
        (
            "let y = n + 1.0f;",
            "in `made`: `+` takes operands of one type; here they are u32 and f32; a constant of type u32 is written `1u`",
        ),
        (
            "let y = 2u * x;",
            "in `made`: `*` takes operands of one type; here they are u32 and f32; a constant of type f32 is written `1.0f`",
        ),
        (
            "let y = n + (x > 0.0f);",
            "in `made`: `+` takes operands of one type; here they are u32 and bool; write `select(0u, 1u, x)` for the bool",
        ),
        (
            "let y = 0.0f < x < 1.0f;",
            "in `made`: `<` takes operands of one type; here they are bool and f32; write `a < b && b < c`",
        ),
        (
            "let y = n << 40u;",
            "in `made`: a constant number of bits to shift by is at most 31",
        ),
        (
            "let y = sqrt(-1.0);",
            "this is computed of constants, before the kernel runs: sqrt has no value there",
        ),
        (
            "let y = 1.0 / 0.0;",
            "this is computed of constants, before the kernel runs: a division by 0 has no value",
        ),
        (
            "let y = 1u << 40u;",
            "this is computed of constants, before the kernel runs: a shift by 32 bits or more has no value",
        ),
        (
            "var i = 0u; while (i < n) { i++; }",
            "give it a maximum, such as 40: `for (var i = 0u; i < 40u && (i < n); i++) { .. }`",
        ),
        (
            "for (var i = 0; i < i32(n); i++) {}",
            "write `for (var i = start; i < end; i += step)`, where `start` is a constant, and `end` is one or has a \
             visible maximum, such as `min(x, 8u)`",
        ),
        (
            "for (var i: i32 = 0; i < 3; i--) {}",
            "write `for (var i = start; i > end; i -= step)`, where `end` is a constant, and `start` is one or has a visible \
             maximum, such as `min(x, 8u)`; or count upwards",
        ),
        (
            "for (var i = n; i > 0u; i--) {}",
            "write `for (var i = start; i > end; i -= step)`, where `end` is a constant, and `start` is one or has a visible \
             maximum, such as `min(x, 8u)`; or count upwards",
        ),
        (
            "for (var i = 0u; i < n; i++) {}",
            "write `for (var i = start; i < end; i += step)`, where `start` is a constant, and `end` is one or has a \
             visible maximum, such as `min(x, 8u)`",
        ),
        // Whether anything uses the element or not.
        ("var a: array<f32, 999>; let y = a[n & 1u];", SAME_INDEX),
        ("var a: array<f32, 999>; a[n & 1u] = 0.0f;", SAME_INDEX),
    ];
    let mut problems = Vec::new();
    for (body, expected) in cases {
        let is_loop = ["for (var", "var i = 0u; while"]
            .iter()
            .any(|start| body.starts_with(start));
        let expected = format!("{}{expected}", if is_loop { LOOP } else { "" });
        let found = said("", &format!("{body} {whole}"));
        if found != expected {
            problems.push(format!("{body}\n{found}\nexpected: {expected}"));
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n\n"));
    let twice = "fn twice() {}";
    assert_eq!(
        refusal(twice, whole),
        "own.wgsl:4:4: `twice` is declared at own.wgsl:3:4 already; choose another name [valid-wgsl]"
    );
    assert_eq!(
        said("# hello", whole),
        "WGSL has no `#`; write `//` before a comment, and `const NAME = VALUE;` for a `#define`"
    );
    assert_eq!(
        said("let y = 1.0f;", whole),
        "expected a declaration, `fn`, `struct`, `const` or `alias`, found `let`"
    );
}

#[test]
fn types_that_do_not_fit_are_answered_with_their_place() {
    for (statement, column, message) in [
        // Naga makes branches of these two operators.
        (
            "if own.found && x < 1.0f {}",
            4,
            "in `within`: `&&` takes two bools; here they are u32 and bool; write `x != 0u`",
        ),
        (
            "if x < 1.0f || own.found {}",
            4,
            "in `within`: `||` takes two bools; here they are bool and u32; write `x != 0u`",
        ),
        (
            "let t = b && x;",
            9,
            "in `within`: `&&` takes two bools; here they are bool and f32; write `x != 0.0f`",
        ),
        (
            "if u && u {}",
            4,
            "in `within`: the condition of `if` is u32; allowed: bool",
        ),
        (
            "if !own.found {}",
            4,
            "in `within`: `!` takes a bool; here it is u32; write `x == 0u`",
        ),
        (
            "let q = -u;",
            9,
            "in `within`: `-` takes f32, i32 or a vector of them; here it is u32",
        ),
        (
            "let q = x ^ 2.0f;",
            9,
            "in `within`: `^` takes integers; here they are f32 and f32; write `x * x` for a square",
        ),
        ("let q = x ** 2.0f;", 12, "WGSL has no `**`; write `x * x` for a square"),
        (
            "let q = 0.5F * x;",
            12,
            "the suffix of a float is a small `f`; write `0.5f`",
        ),
        (
            "switch u { case 1u: {} }",
            1,
            "in `within`: a `switch` says what to do in all other cases",
        ),
        (
            "let q = min(x, u);",
            9,
            "argument 2 of `min` is u32, another is f32; allowed: one type; write `f32(x)`",
        ),
        ("let q = abs(b);", 9, "argument 1 of `abs` is bool; allowed: a number"),
        (
            "let q = select(x, u, b);",
            16,
            "`select` chooses between f32 and u32; allowed: one type; write `f32(x)`",
        ),
        ("let k: u32 = -1;", 14, "-1 is no u32; allowed: 0 to 4294967295"),
        (
            "var f = x; f++;",
            12,
            "`++` and `--` count u32 or i32; write `f += 1.0f`",
        ),
        (
            "var t: vec2 = vec2<f32>(x, x);",
            8,
            "`vec2` lacks the type of its components; write `vec2<f32>`",
        ),
        (
            "let k: f32 = u;",
            5,
            "`k` is declared as f32, and its value is u32; write `f32(x)`",
        ),
        (
            "var earned = 0; earned += x;",
            17,
            "the value is f32; allowed: i32; `earned` is an i32 because of `var earned = 0;`: write `0.0f` there",
        ),
        ("let q = Own;", 9, "`Own` is a type; write `Own(..)`"),
        ("let q = True;", 9, "nothing declares `True`; write `true`"),
        (
            "let q = PI * x;",
            9,
            "nothing declares `PI`; write `3.1415927f`; angles are in turns",
        ),
        (
            "let q = float3(x, x, x);",
            9,
            "there is no function `float3`; write `vec3<f32>(x, y, z)`",
        ),
        (
            "let target = x;",
            5,
            "`target` is a reserved word of WGSL; choose another name",
        ),
        (
            "if x > 1.0f { return x; } elif b {}",
            32,
            "WGSL has no `elif`; write `else if`",
        ),
        (
            "if (x > 1.0f) return x;",
            15,
            "a block stands in braces; write `{` before `return`",
        ),
        ("if b { return u; }", 8, "in `within`: returns u32; its head says f32"),
    ] {
        let head = "struct Own { found: u32, way: f32 }\nfn within(x: f32, u: u32, b: bool, own: Own) -> f32 {";
        let declarations = format!("{head}\n{statement}\nreturn x;\n}}\n");
        // Six lines stand before the statement.
        let expected = format!("own.wgsl:6:{column}: {message}");
        let refused = refusal(&declarations, "return Pair(x, vec2<f32>(x, x));");
        assert!(
            refused.starts_with(&expected),
            "{statement}\n{refused}\nexpected: {expected}"
        );
    }
}
