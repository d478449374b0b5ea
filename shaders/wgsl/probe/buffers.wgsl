// What the probes share: the buffers of one dispatch of a `Probe`.

// Not a uniform: lavapipe would compile the kernel anew for each of its values.
@group(0) @binding(0) var<storage, read> probe: Probe;
// First and second operands or arguments; f32 and i32 as their bits.
@group(0) @binding(1) var<storage, read> left: array<u32>;
@group(0) @binding(2) var<storage, read> right: array<u32>;
@group(0) @binding(3) var<storage, read_write> results: array<u32>;

// A number's bits, with zero's one sign.
fn stored_bits(x: f32) -> u32 {
    return bitcast<u32>(select(x, 0.0f, x == 0.0f));
}
