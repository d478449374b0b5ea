// Loops that count in all the forms that have a bound.

fn found(at: u32, lane: u32) -> bool {
    return (at * 7u + lane) % 13u == 5u;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let base = (workgroup.x * 64u + lane) * 16u;
    var sum = 0u;
    var i = 3u;
    while (i < 10u) {
        i++;
        if ((i + lane) % 3u == 0u) {
            continue;
        }
        sum += i;
    }
    results[base] = sum;
    for (var k = 9; k > 0 && !found(u32(k), lane); k -= 2) {
        sum += u32(k);
    }
    results[base + 1u] = sum;
    var n = 0u;
    loop {
        if (n >= 8u || found(n, lane)) {
            sum += 100u;
            break;
        }
        for (var k = 0u; k < n; k++) {
            sum ^= k + lane;
        }
        n += 2u;
    }
    results[base + 2u] = sum + n;
    if (lane % 2u == 0u) {
        var down = 5;
        loop {
            down--;
            sum += lane;
            if (down == 0) {
                break;
            }
        }
        for (var k = 0; k < 3; k++) {
            sum = sum * 3u + 1u;
        }
    }
    results[base + 3u] = sum;
    var at = 0u;
    loop {
        sum += at;
        if (found(at, lane)) {
            continue;
        }
        sum ^= 5u;
        continuing {
            at++;
            break if (at > lane % 4u && at >= 3u) || at >= 7u;
        }
    }
    results[base + 4u] = sum + at;
    results[base + 5u] = first(lane);
}

// Leaves by a return.
fn first(lane: u32) -> u32 {
    var i = 0u;
    while (true) {
        if (!(i < 20u)) {
            return 99u;
        }
        if (found(i, lane)) {
            return i;
        }
        i++;
    }
    return 0u;
}
