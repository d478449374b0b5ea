// Loops within loops whose bounds, breaks and continues differ between invocations.

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let base = (workgroup.x * 64u + lane) * 16u;
    var sum = 0u;
    var turns = 0u;
    for (var i = 0u; i < lane % 7u; i++) {
        if (i == lane % 3u) {
            continue;
        }
        for (var k = i; k < 9u; k++) {
            turns++;
            if (k == lane % 5u) {
                continue;
            }
            if (k * i > lane) {
                break;
            }
            var j = 0u;
            loop {
                j += 1u + (lane & 1u);
                if (j > k) {
                    break;
                }
                sum = sum * 3u + j;
            }
        }
        if (turns > 20u + lane % 4u) {
            break;
        }
    }
    results[base] = sum;
    results[base + 1u] = turns;
}
