// Loops: one that all invocations leave together, and one in it that they leave one by one, by `break`, by
// `continue` and by `return`.
@group(0) @binding(0) var<storage, read> numbers: array<u32>;
@group(0) @binding(1) var<storage, read_write> results: array<u32>;

fn search(start: u32, goal: u32) -> u32 {
    var steps = 0u;
    for (var i = start; i < start + 9u; i++) {
        if (numbers[i] == goal) {
            return i;
        }
        if (numbers[i] > 50u) {
            continue;
        }
        steps++;
        if (steps > goal) {
            break;
        }
    }
    return 100u + steps;
}

@compute @workgroup_size(64)
fn main(@builtin(local_invocation_index) lane: u32) {
    var sum = 0u;
    for (var k = 0u; k < 3u; k++) {
        sum += search(lane + k, k);
    }
    results[lane] = sum;
}
