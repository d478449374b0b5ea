// Elements at and beyond the ends of buffers, arrays, and arrays in arrays: indices are clamped, signed ones as if unsigned.

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let slot = workgroup.x * 64u + lane;
    let base = slot * 16u;
    results[base] = words[slot];
    results[base + 1u] = words[slot + 60u];
    results[base + 2u] = words[lane - 8u];
    results[base + 3u] = words[4000000000u];
    results[base + 4u] = words[i32(lane) - 30i];
    results[base + 5u] = bits(items[lane].at.y) + items[slot * 3u].kind;
    results[base + 6u] = bits(quads[lane * 2u].w);
    results[base + 7u] = words[i32(workgroup.x) - 1i];
    results[base + 8u] = bits(floats[settings.a * 77777u]);
    var local = array<u32, 3>(lane, 20u, 30u);
    local[settings.b] = 7u;
    local[i32(workgroup.x) - 1i] += 100u;
    results[base + 9u] = local[0] + local[1] * 1000u + local[2] * 1000000u;
    results[base + 10u] = local[workgroup.x + 5u];
    var grid = array<array<vec2<u32>, 3>, 2>();
    for (var row = 0u; row < 2u; row++) {
        for (var column = 0u; column < 3u; column++) {
            grid[row][column] = vec2<u32>(10u * row + column, lane);
        }
    }
    grid[lane % 3u][workgroup.x + settings.b].x += 1000u;
    grid[lane % 2u][lane % 5u][lane % 3u] += 7u;
    results[base + 11u] = grid[lane & 1u][lane % 3u].x + grid[1][settings.b][workgroup.x] * 10000u;
    results[base + 12u] = grid[workgroup.x][2].x + grid[lane / 32u][lane % 4u].y * 10000u;
    notes[slot].third = i32(lane) - 5i;
    notes[slot].second = f32(lane) * 0.5f;
}
