// Branches: uniform, varying, short ones that become selections, and an early return.
@group(0) @binding(0) var<storage, read> numbers: array<f32>;
@group(0) @binding(1) var<storage, read_write> results: array<f32>;

fn bounded(x: f32) -> f32 {
    if (x > 1.0f) {
        return 1.0f;
    }
    return x;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    var x = numbers[lane];
    if (x < 0.0f || lane == 3u) {
        x = -x;
    }
    if (workgroup.x == 0u) {
        results[lane] = x;
        return;
    }
    if (x > 9.0f) {
        return;
    }
    results[lane] = bounded(x);
}
