// Loads and stores: uniform, of neighbours, gathered, of whole vectors and structs.
struct Point {
    x: f32,
    y: f32,
}

@group(0) @binding(0) var<uniform> scale: f32;
@group(0) @binding(1) var<storage, read> order: array<u32>;
@group(0) @binding(2) var<storage, read> quads: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> points: array<Point>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let slot = workgroup.x * 64u + lane;
    let first = quads[workgroup.x].x;
    let quad = quads[order[slot]];
    points[slot] = Point(quad.x * scale + first, points[slot].y - quad.w);
}
