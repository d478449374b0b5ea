// Switches with breaks, in loops, with `continue` and `return` inside, and the default in the middle.

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let base = (workgroup.x * 64u + lane) * 16u;
    var sum = 0u;
    for (var i = 0u; i < 8u; i++) {
        switch ((lane + i) % 6u) {
            case 0u: {
                sum += 1u;
            }
            case 1u, 4u: {
                if (i > lane % 5u) {
                    break;
                }
                sum += 20u;
            }
            default: {
                if (lane % 11u == 3u) {
                    continue;
                }
                sum += 300u;
            }
            case 2u: {
                if (i == 7u && lane % 2u == 1u) {
                    results[base + 1u] = sum;
                    return;
                }
                sum *= 2u;
                break;
            }
        }
        sum += 4000u;
    }
    switch (i32(lane) - 20i) {
        case -3i: {
            sum = 1u;
        }
        case 5i, default: {
            sum += 50000u;
        }
        case 0i: {
        }
    }
    results[base] = sum;
}
