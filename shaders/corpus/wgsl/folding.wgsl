// What drivers would like to contract, to reassociate or to fold, if they could.

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let slot = workgroup.x * 64u + lane;
    let base = slot * 16u;
    let x = floats[slot % 97u];
    let y = floats[(slot + 31u) % 97u];
    results[base] = bits((x * 0.1f) * 0.3f);
    results[base + 1u] = bits(x * y + 0.7f);
    results[base + 2u] = bits((x + 0.1f) + 0.2f);
    results[base + 3u] = bits(x * y - y * 0.3f);
    results[base + 4u] = bits((x - y) + y);
    results[base + 5u] = bits(x * 3.0f + x * 5.0f);
    results[base + 6u] = bits(-(x - y) * 0.1f);
    results[base + 7u] = u32((x + y * 1e-9f) == x);
    results[base + 8u] = bits(x - floor(x));
    results[base + 9u] = bits((x - floor(x)) + floor(x));
    results[base + 10u] = bits(x * 1e-9f * y);
    // Bounds in either order.
    results[base + 11u] = bits(clamp(x, y, 3.0f));
    results[base + 12u] = clamp(slot, settings.a & 127u, 20u);
    results[base + 13u] = u32(clamp(i32(lane) - 30i, i32(slot % 7u), -3i));
}
