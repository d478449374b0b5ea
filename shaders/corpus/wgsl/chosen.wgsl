// Arrays and vectors whose index differs between invocations, also beyond their ends.

struct Kept { pair: array<vec2<f32>, 3>, count: u32 }

const WEIGHTS = array<f32, 4>(0.5, 1.5, 2.5, 3.5);

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let slot = workgroup.x * 64u + lane;
    let base = slot * 16u;
    let x = floats[slot % 97u];
    let y = floats[(slot + 31u) % 97u];
    let at = slot * 7u % 11u;
    var earned = array<f32, 5>(x, y, 1.0, -2.0, 0.25);
    results[base] = bits(earned[at]);
    earned[at % 6u] = 3.0 * x;
    earned[lane % 2u] += y;
    results[base + 1u] = bits(earned[0] + earned[1]);
    results[base + 2u] = bits(earned[2] + earned[3] + earned[4]);
    let copy = earned;
    earned[2] = 100.0;
    results[base + 3u] = bits(copy[at]) + bits(copy[2]);
    let v = vec4(x, y, 2.0, 3.0);
    results[base + 4u] = bits(v[at % 5u] + WEIGHTS[at]);
    var w = vec3(x, y, -1.0);
    w[at] = 5.0;
    w[lane % 3u] += 0.5;
    results[base + 5u] = bits(w.x + w[at]);
    results[base + 6u] = bits(w.y + w.z);
    var kept: Kept;
    kept.pair[at % 4u] = vec2(y, x);
    kept.pair[lane % 3u].y += 1.0;
    kept.count = at;
    results[base + 7u] = bits(kept.pair[at].x + kept.pair[1].y);
    results[base + 8u] = bits(kept.pair[slot % 3u].y) + kept.count;
    var counts: array<u32, 3>;
    for (var i = 0u; i < 9u; i++) {
        let place = (i * lane) % 4u;
        if ((i + lane) % 3u > 0u) {
            counts[place] += i;
        }
    }
    results[base + 9u] = counts[0] + 100u * counts[1] + 10000u * counts[2];
    results[base + 10u] = u32(i32(at) - 5) % 3u;
    results[base + 11u] = bits(earned[i32(at) - 3]);
}
