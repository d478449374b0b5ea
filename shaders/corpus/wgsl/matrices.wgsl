// Matrices in variables, parameters, results, structs and arrays. The program that these kernels are compared with has sums
// of products in their place.

struct Pose {
    turn: mat2x2<f32>,
    place: vec2<f32>,
}

const FLIP = mat2x2<f32>(0.0, 1.0, 1.0, 0.0);

fn turned(angle: f32) -> mat2x2<f32> {
    let c = cos(angle);
    let s = sin(angle);
    return mat2x2(c, s, -s, c);
}

fn moved(pose: Pose, by: vec2<f32>, angle: f32) -> Pose {
    return Pose(pose.turn * turned(angle), pose.place + pose.turn * by);
}

fn scale(m: ptr<function, mat3x3<f32>>, by: f32) {
    (*m)[1] *= by;
    *m = *m * by;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let slot = workgroup.x * 64u + lane;
    let base = slot * 16u;
    let x = 0.01 * floats[slot % 97u];
    let y = 0.01 * floats[(slot + 31u) % 97u];
    let v = vec2(x, y);
    let w = vec3(y, x, 0.5);
    var pose = Pose(turned(x), v);
    for (var i = 0u; i < 3u; i++) {
        pose = moved(pose, v.yx, 0.1 * y);
    }
    results[base] = bits(pose.place.x);
    results[base + 1u] = bits(pose.turn[1].x);
    let a = mat2x3f(w, w.zxy);
    let b = mat3x2f(v, v.yx, v * 3.0);
    let c = a * b;
    let d = b * a;
    results[base + 2u] = bits((c * w).y);
    results[base + 3u] = bits((w * c).z);
    results[base + 4u] = bits(determinant(c + transpose(c)));
    results[base + 5u] = bits((d - FLIP * d)[slot % 2u].y);
    var m = mat3x3f(w, w.yzx, w.zxy);
    scale(&m, 0.3);
    m[slot % 3u].x = 2.0;
    m[2u][slot % 3u] = 0.1;
    results[base + 6u] = bits(determinant(m));
    var all: array<mat2x2<f32>, 3>;
    all[slot % 3u] = pose.turn;
    all[1][0] += v;
    all[2] = all[slot % 3u] * 0.1 + all[1];
    results[base + 7u] = bits((all[2] * v).x);
    results[base + 8u] = bits((v * all[(slot + 1u) % 3u]).y);
    let l = mat4x4f(vec4(w, x), vec4(y, w), vec4(v, v), vec4(0.2, w.zyx));
    results[base + 9u] = bits(determinant(l * l));
    results[base + 10u] = bits((0.1 * transpose(l) * vec4(v, w.xy)).w);
    var none: mat4x2f;
    none[slot & 3u] = v;
    none[slot % 5u][slot % 3u] += y;
    results[base + 12u] = bits(none[slot % 7u][1]);
    results[base + 11u] = bits((none * vec4(w, 1.0)).x);
}
