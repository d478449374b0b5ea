// Locals that live across iterations, and those that start anew in each: in a loop, in a function called in
// one, in branches.

fn anew(lane: u32) -> u32 {
    var seen: u32;
    var start = 5u;
    if ((lane & 1u) == 0u) {
        seen += 7u;
        start = lane;
    }
    return seen * 10u + start;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let base = (workgroup.x * 64u + lane) * 16u;
    var kept = 1u;
    var sum = 0u;
    var last = 99u;
    for (var i = 0u; i < 6u; i++) {
        var fresh: u32;
        var half = 3u;
        if ((lane + i) % 3u == 0u) {
            fresh += kept;
            kept += lane;
        } else if (i > lane % 5u) {
            half = fresh + last;
            last = i;
            if (half > 40u + lane) {
                break;
            }
        }
        sum = sum * 2u + fresh + half + anew(lane + i);
        count += i;
    }
    results[base] = kept;
    results[base + 1u] = sum;
    results[base + 2u] = last;
    results[base + 3u] = count;
}
