// Functions that return from within a varying `if` in a loop, called under divergence, and once more by those
// invocations that had already returned from an earlier call.

fn first_above(start: u32, bound: u32) -> u32 {
    for (var i = start; i < start + 12u; i++) {
        if (words[i] % 17u > bound) {
            return i;
        }
    }
    return 1000u;
}

fn steps_to(limit: u32, step: u32) -> u32 {
    var at = 0u;
    var steps = 0u;
    loop {
        loop {
            at += step + 1u;
            if (at > limit) {
                return steps;
            }
            if ((at & 3u) == 0u) {
                break;
            }
        }
        steps++;
        if (steps > 5u) {
            return 100u + at;
        }
    }
    return 0u;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let base = (workgroup.x * 64u + lane) * 16u;
    results[base] = first_above(lane, lane % 19u);
    if (lane % 3u != 1u) {
        results[base + 1u] = first_above(lane % 30u, 12u) * 2u + first_above(3u, lane);
    }
    var sum = 0u;
    for (var i = 0u; i < 5u; i++) {
        sum = sum * 7u + steps_to(lane + i, (lane + i) % 4u);
        if (sum > 100000u + lane * 1000u) {
            results[base + 2u] = i;
            return;
        }
    }
    results[base + 3u] = sum;
}
