// `continue` into `continuing` blocks that use what the body computed.

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let base = (workgroup.x * 64u + lane) * 16u;
    var i = 0u;
    var even = 0u;
    var trail = 1u;
    loop {
        let step = 1u + ((lane + i) & 3u);
        if ((i ^ lane) % 3u == 0u) {
            continue;
        }
        even += step;
        if (even > 30u) {
            break;
        }
        continuing {
            i += step;
            trail = trail * 5u + step;
            break if i > 20u + lane % 8u;
        }
    }
    results[base] = i;
    results[base + 1u] = even;
    results[base + 2u] = trail;
}
