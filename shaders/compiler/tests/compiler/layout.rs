//! Host structs have the layout of those in the WGSL, or the kernel is refused.

use oneiro_shader_compiler::{Binding, Compiled, Indices, Part, Refusals, compile};

fn compiled(declarations: &str) -> Result<Compiled, Refusals> {
    let text = format!("{declarations}\n@compute @workgroup_size(64)\nfn main() {{}}\n");
    let part = Part {
        path: "kernel".into(),
        text,
    };
    let kernel = compile("kernel", &[part], Indices::Clamped)?;
    kernel.structs.clone()?;
    Ok(kernel)
}

fn refused(declarations: &str, words: &str) {
    let refusals = compiled(declarations).expect_err(declarations);
    let message = refusals[0].to_string();
    assert!(message.contains(words), "`{declarations}`: {message}");
}

/// Puts generated text on one line, without its comments.
fn squeezed(text: &str) -> String {
    let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
    code.flat_map(str::split_whitespace).collect::<Vec<_>>().join(" ")
}

#[test]
fn structs_and_strides() {
    let kernel = compiled(
        "struct Mixed { a: f32, b: i32, at: vec2<f32>, direction: vec3<f32>, count: u32, four: vec4<u32> }
        @group(0) @binding(2) var<storage, read_write> mixed: array<Mixed>;
        @group(0) @binding(0) var<uniform> one: Mixed;
        @group(0) @binding(1) var<storage, read> vectors: array<vec3<f32>>;
        @group(0) @binding(3) var<storage, read> word: u32;",
    )
    .unwrap();
    assert_eq!(
        squeezed(kernel.structs.as_ref().unwrap()),
        "#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)] #[repr(C)] \
         pub struct Mixed { pub a: f32, pub b: i32, pub at: [f32; 2], pub direction: [f32; 3], pub count: u32, \
         pub four: [u32; 4], } \
         impl Mixed { pub const FIELDS: [&'static str; 6] = [\"a\", \"b\", \"at\", \"direction\", \"count\", \"four\"]; }"
    );
    for offset in [
        "at byte 0.",
        "at byte 4.",
        "at byte 8.",
        "at byte 16.",
        "at byte 28.",
        "at byte 32.",
        "48 bytes.",
    ] {
        assert!(kernel.structs.as_ref().unwrap().contains(offset), "{offset}");
    }
    let bindings: String = kernel.bindings.iter().map(Binding::as_rust).collect();
    assert_eq!(
        squeezed(&bindings),
        "Binding { binding: 0, name: \"one\", kind: BindingKind::Uniform, stride: 48 }, \
         Binding { binding: 1, name: \"vectors\", kind: BindingKind::Read, stride: 16 }, \
         Binding { binding: 2, name: \"mixed\", kind: BindingKind::ReadWrite, stride: 48 }, \
         Binding { binding: 3, name: \"word\", kind: BindingKind::Read, stride: 4 },"
    );
}

#[test]
fn structs_in_structs() {
    let kernel = compiled(
        "struct Outer { a: f32, inner: Inner, b: f32 } struct Inner { c: u32, d: f32 }
        @group(0) @binding(0) var<storage, read> outer: array<Outer>;",
    )
    .unwrap();
    let text = squeezed(kernel.structs.as_ref().unwrap());
    let inner = text.find("pub struct Inner { pub c: u32, pub d: f32, }").expect(&text);
    let outer = text
        .find("pub struct Outer { pub a: f32, pub inner: Inner, pub b: f32, }")
        .expect(&text);
    assert!(inner < outer);
    assert_eq!(text.matches("pub struct").count(), 2);
}

#[test]
fn constants() {
    let kernel = compiled(
        "const COUNT: u32 = 8u;
        const LEAST: i32 = -3i;
        const SPEED: f32 = 8.25f;
        const ON: bool = true;
        const TWICE: u32 = 2u * COUNT;
        const AXES: vec4<f32> = vec4<f32>(0.5f, 1.0f, -0.25f, SPEED);
        const CELL: vec2<u32> = vec2<u32>(COUNT, 3u);",
    )
    .unwrap();
    let items: Vec<_> = kernel
        .constants
        .iter()
        .map(|constant| squeezed(&constant.item))
        .collect();
    assert_eq!(
        items,
        [
            "pub const COUNT: u32 = 8;",
            "pub const LEAST: i32 = -3;",
            "pub const SPEED: f32 = 8.25;",
            "pub const ON: bool = true;",
            "pub const TWICE: u32 = 16;",
            "pub const AXES: [f32; 4] = [0.5, 1.0, -0.25, 8.25];",
            "pub const CELL: [u32; 2] = [8, 3];",
        ]
    );
}

#[test]
fn offsets_are_those_that_lane_code_uses() {
    let text = "struct Item { a: f32, b: u32, at: vec2<f32>, last: vec3<f32>, end: u32 }
        @group(0) @binding(0) var<storage, read> items: array<Item>;
        @group(0) @binding(1) var<storage, read_write> out: array<f32>;
        @compute @workgroup_size(64)
        fn main(@builtin(local_invocation_index) lane: u32) {
            out[lane] = items[lane].at.y + items[lane].last.z + f32(items[lane].end);
        }";
    let part = Part {
        path: "kernel".into(),
        text: text.into(),
    };
    let lanes = compile("kernel", &[part], Indices::Clamped).unwrap().lanes;
    // Words 3, 6 and 7 of 8.
    for access in ["n0, 8, 3)", "n0, 8, 6)", "n0, 8, 7)"] {
        assert!(lanes.contains(access), "{access} in\n{lanes}");
    }
}

#[test]
fn paddings_are_refused() {
    let bound = |members: &str| {
        format!("struct Item {{ {members} }} @group(0) @binding(0) var<storage, read> items: array<Item>;")
    };
    refused(&bound("a: f32, at: vec2<f32>"), "`Item.at` is preceded by padding");
    refused(
        &bound("a: f32, b: f32, at: vec3<f32>, c: f32"),
        "`Item.at` is preceded by padding",
    );
    refused(&bound("at: vec2<f32>, a: f32"), "`Item` ends in padding");
    refused(&bound("at: vec3<f32>"), "`Item` ends in padding");
    refused(&bound("a: f32, @align(16) b: f32"), "`Item.b` is preceded by padding");
    refused(&bound("@size(8) a: f32, b: f32"), "`Item.b` is preceded by padding");
    refused(
        &bound("many: array<f32, 4>"),
        "`Item.many`: host structs hold only scalars, vectors and structs",
    );
    // A struct that is in no buffer may have any layout.
    compiled("struct Free { a: f32, at: vec3<f32>, many: array<f32, 3> } fn f(free: Free) {}").unwrap();
}
