use oneiro_shader_compiler::{Part, compile};
fn try_(wrap: bool, text: &str) -> String {
    let body = if wrap { format!("{HEAD}\n@compute @workgroup_size(64)\nfn main(@builtin(local_invocation_index) lane: u32, @builtin(workgroup_id) group: vec3<u32>) {{\nlet x = numbers[lane]; let u = words[lane]; let i = bitcast<i32>(u); let v = vec3<f32>(x, x, x);\n{text}\n}}") } else { format!("{HEAD}\n{text}") };
    match compile("k", &[Part{path:"k.wgsl".into(), text: body}]) { Ok(_) => "ACCEPTED".into(), Err(e) => e.iter().map(|e| e.to_string()).collect::<Vec<_>>().join(" || ") }
}
const HEAD: &str = "@group(0) @binding(0) var<storage, read> numbers: array<f32>;
@group(0) @binding(1) var<storage, read> words: array<u32>;
@group(0) @binding(2) var<storage, read_write> out: array<f32>;
@group(0) @binding(3) var<storage, read_write> outw: array<u32>;";
#[test]
fn explore() {
    for t in [
        "out[lane] = x / 2.0f;", "out[lane] = x % 2.0f;", "out[lane] = sqrt(x);", "out[lane] = inverseSqrt(x);", "out[lane]=1.0f/3.0f;", "const c = 1.0f / 3.0f; out[lane]=c;",
        "out[lane] = exp(1.0f);", "out[lane]=fma(x,x,x);","out[lane]=dot(v,v);","out[lane] = x * 2.0;", "out[lane] = x * .5;", "out[lane] = x * 5e-1;", "out[lane] = x * 0x1.8p0;", "out[lane] = x * 1.f;",
        "out[lane] = f32(1) / f32(3);", "out[lane]=f32(7u/2u);", "out[lane] = 5.0f % 3.0f;",
        "outw[lane] = u << u;", "outw[lane] = u << (u & 31u);", "outw[lane] = u << (u & 32u);", "outw[lane] = u << 5u;", "outw[lane] = u << (u & 63u);","outw[lane] = u >> (u & 31u & u);",
        "const S = 5u; outw[lane] = u << S;", "let s = 5u; outw[lane] = u << s;",
        "var a: array<f32, 4>; a[u & 3u] = 1.0f; out[lane]=a[0];",
        "var a: array<f32, 4>; out[lane]=a[u & 3u];",
        "var a: array<f32, 4>; let p = &a[u & 3u]; *p = 1.0f; out[lane]=a[1];",
        "out[0] = x;", "out[group.x] = x;", "outw[group.x] = group.x;",
        "outw[lane] = u32(i / 3);", "outw[lane] = u32(i % 3);", "outw[lane] = u32(7 / 3);","outw[lane] = u32(7i / 3i);",
        "let m = mat2x2<f32>(1.0f,0.0f,0.0f,1.0f); out[lane]=(m*vec2<f32>(x,x)).x;", "var m: mat2x2<f32>; out[lane]=m[0].x;",
        "let h = 1.0h;", "var h: f16;", "out[lane] = f32(x == x && isNan(x));", "out[lane] = f32(all(vec2<bool>(true,false)));",
        "out[lane] = bitcast<f32>(0x7fc00000u);", "out[lane] = bitcast<f32>(1u);","out[lane] = 1e-40f;", "out[lane] = 1e-30f * 1e-15f;", "out[lane]=3e38f * 10.0f;",
        "workgroupBarrier();", "storageBarrier();", "outw[lane] = arrayLength(&words);", "discard;",
        "out[lane] = round(x);", "out[lane]=sign(x);","out[lane]=step(x,x);","out[lane]=fract(x);","out[lane]=ceil(x);","outw[lane]=countOneBits(u);","outw[lane]=firstLeadingBit(u);","outw[lane]=pack2x16float(vec2<f32>(x,x));","out[lane]=length(v);",
        "outw[lane]=extractBits(u,1u,2u);", "outw[lane] = dot4U8Packed(u,u);","outw[lane]=subgroupAdd(u);","out[lane]=mix(x,x,x);","out[lane]=normalize(v).x;","out[lane]=cross(v,v).x;","out[lane]=saturate(x);","out[lane]=degrees(x);",
        "out[lane] = v[u % 3u];", "var w = v; w[u % 3u] = x; out[lane]=w.x;", "let k = v[group.x % 3u]; out[lane]=k;",
        "out[lane] = f32(u);", "outw[lane] = u / 0u;", "outw[lane]= u / u;",
        "let e = x / 2.0f;", "_ = x / 2.0f;", "if (false) { out[lane] = sqrt(x); }",
        "var a = array<f32,2>(1.0f,2.0f); let b = a; out[lane]=b[0];",
        "outw[lane] = u32(vec3f(1.0f,2.0f,3.0f).x);",
        "out[lane] = select(x, 1.0f, vec2<bool>(true, true).x);",
        "outw[lane] = u32(i32(5) << 2u);", "let abs = 3u; outw[lane]=abs;",
        "outw[lane] = u + 1;", "out[lane] = x + 1;", "let q = quantizeToF16(x);", "let f = frexp(x); out[lane]=f.fract;",
        "var y = x; y /= 2.0f; out[lane] = y;", "var y = x; y %= 2.0f; out[lane] = y;", "var w = u; w <<= u; outw[lane]=w;", "var w = i; w /= 3; outw[lane]=u32(w);",
        "out[lane] = -0.0f;", "out[lane] = 16777217;", "const k = 2147483647; out[lane] = k;", "outw[lane] = u32(1e9f);","outw[lane] = u32(-1.0f);","outw[lane]=u32(x);",
        "let p = &out[lane]; *p = x;", "for (var k = 0u; k < 3u; k++) { out[k] = x; }",
        "if (lane == 0u) { outw[0] = 5u; }", "if (x > 0.0f) { outw[0] = group.x; } ", "var t = 0u; if (x > 0.0f) { t = 1u; } outw[0] = t;",
        "out[lane] = f32(bool(x));", "let r = reverseBits(u);",
    ] { println!("{t}\n      -> {}", try_(true, t)); }
    println!("-------- module");
    let m = "@compute @workgroup_size(64)\nfn main() { }";
    for t in [
        "var<workgroup> w: array<u32, 64>;", "override o: f32 = 1.0f;", "var<private> p: f32 = 1.0f / 3.0f;", "const k = 1.0f / 3.0f;", "const k = 5.0f % 3.0f;", "const k = exp(1.0f);", "const k = 2.0;", "enable f16;",
        "@group(0) @binding(4) var t: texture_2d<f32>;", "@group(0) @binding(4) var s: sampler;", "@group(0) @binding(4) var<storage, read_write> a: atomic<u32>;", "@group(0) @binding(4) var<storage, read_write> a: array<atomic<u32>>;",
        "@compute @workgroup_size(64)\nfn other() { }", "fn unused(x: f32) -> f32 { return x / 2.0f; }", "fn unused(x: f32) -> f32 { let y = sqrt(x); return x; }",
        "@vertex fn vs() -> @builtin(position) vec4<f32> { return vec4<f32>(0.0f,0.0f,0.0f,0.0f); }", "@fragment fn fs() {}",
        "struct S { m: mat2x2<f32> }", "alias M = mat2x2<f32>;", "struct H { a: u32, b: array<u32> } @group(0) @binding(4) var<storage, read> h: H;", "@group(0) @binding(4) var<storage, read> h: array<u32, 8>;","@group(0) @binding(4) var<uniform> h: array<vec4<u32>, 8>;", "@group(0) @binding(4) var<storage, read> h: array<array<u32, 4>>;",
        "@group(0) @binding(5) var<storage, read> h: array<u32>;", "@group(1) @binding(0) var<storage, read> h: array<u32>;", "@group(0) @binding(0) var<storage, read> h: array<u32>;",
        "fn exp(x: f32) -> f32 { return x; } fn g(x: f32) -> f32 { return exp(x); }", "fn abs(x: f32) -> f32 { return x; } fn g(x: f32) -> f32 { return abs(x); }",
        "var<push_constant> p: f32;", "@group(0) @binding(4) var<storage, read> b: array<bool>;", "struct P { a: f32, v: vec3<f32> } @group(0) @binding(4) var<storage, read> b: array<P>;", "struct P { v: vec3<f32> } @group(0) @binding(4) var<storage, read> b: array<P>;",
        "@group(0) @binding(4) var<storage, read> b: array<vec3<f32>>;", "const_assert 1 < 2;", "@must_use fn f() -> f32 { return 1.0f; }", "diagnostic(off, derivative_uniformity);",
        "fn r(x: u32) -> u32 { return r(x); }", "struct N { a: u32 } struct O { n: N, b: f32 } @group(0) @binding(4) var<storage, read> b: array<O>;", "@group(0) @binding(4) var<storage, write> b: array<u32>;",
    ] { println!("{t}\n      -> {}", try_(false, &format!("{t}\n{m}"))); }
    for t in ["@compute @workgroup_size(64)\nfn main(@builtin(num_workgroups) n: vec3<u32>) { }", "@compute @workgroup_size(64)\nfn main(@builtin(global_invocation_id) n: vec3<u32>) { outw[n.x] = n.x; }", "@compute @workgroup_size(8, 8)\nfn main() { }", "@compute @workgroup_size(64)\nfn start() { }", "", "@compute @workgroup_size(65)\nfn main() { }", "@compute @workgroup_size(64)\nfn main(@builtin(workgroup_id) w: vec3<u32>) { outw[w.y] = w.y; }","@compute @workgroup_size(64)\nfn main(@builtin(subgroup_size) n: u32) { }", "@compute @workgroup_size(64)\nfn main() { return 5; }", "@compute @workgroup_size(64)\nfn main() { let a = ; }","struct A { @builtin(local_invocation_index) l: u32 }\n@compute @workgroup_size(64)\nfn main(a: A) { outw[a.l] = a.l; }"] { println!("{t}\n      -> {}", try_(false, t)); }
}
