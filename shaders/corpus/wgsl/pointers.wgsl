// Pointers to locals, structs and arrays, written under divergence and in loops.

fn bump(at: ptr<function, u32>, by: u32) -> u32 {
    if (by > 40u) {
        *at += 1000u;
        return by;
    }
    *at += by;
    return *at;
}

fn shift(values: ptr<function, array<u32, 4>>, into: ptr<function, u32>) {
    for (var i = 0u; i < 4u; i++) {
        if ((*values)[i] > 50u) {
            *into += i;
        } else {
            (*values)[i] += *into + i;
        }
    }
}

fn turn(item: ptr<function, Local>, lane: u32) {
    while ((*item).u < lane) {
        (*item).u += 3u;
        (*item).v = (*item).v.yx + vec2<f32>(1.0f, 0.0f);
        if ((*item).u == 15u) {
            return;
        }
    }
    (*item).f = (*item).v.x;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let base = (workgroup.x * 64u + lane) * 16u;
    var a = lane;
    var b = 3u;
    if (lane % 2u == 0u) {
        b = bump(&a, lane) + bump(&b, 2u);
    }
    var values = array<u32, 4>(lane, 2u, lane * 3u, 60u);
    for (var i = 0u; i < lane % 4u; i++) {
        shift(&values, &b);
    }
    var item = Local(0.0f, lane % 6u, vec2<f32>(0.0f, 10.0f));
    turn(&item, lane % 32u);
    results[base] = a;
    results[base + 1u] = b;
    results[base + 2u] = values[0];
    results[base + 3u] = values[2] * 100u + values[3];
    results[base + 4u] = item.u;
    results[base + 5u] = u32(item.f);
    results[base + 6u] = u32(item.v.x) * 100u + u32(item.v.y);
}
