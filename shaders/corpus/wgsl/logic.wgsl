// `&&` and `||` whose right side must not always run.

fn counted(at: ptr<function, u32>, result: bool) -> bool {
    *at += 1u;
    return result;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let base = (workgroup.x * 64u + lane) * 16u;
    var calls = 0u;
    var hits = 0u;
    var i = 0u;
    while (i < 10u && counted(&calls, (i ^ lane) % 7u != 6u)) {
        i++;
        if ((lane & i) == 2u || counted(&calls, i > 4u) && counted(&calls, lane % 3u == 0u)) {
            hits += i;
        }
        if (!(lane > 5u && i > 3u) != (hits > 9u)) {
            hits += 100u;
        }
    }
    results[base] = calls;
    results[base + 1u] = hits;
    results[base + 2u] = i;
}
