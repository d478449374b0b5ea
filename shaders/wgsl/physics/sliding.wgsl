// A body that slides along what it would touch.

// What a collision does: a cycle that would end where the body touches something. It undoes the move and the turn, or
// the move alone; or the body slides along, and turns; or it gets there, and sticks for the rest of its episode.
const UNDO: u32 = 0u;
const KEEP_TURN: u32 = 1u;
const SLIDE: u32 = 2u;
const STICK: u32 = 3u;

// How near a body comes to what it slides along, mm: more than roundings make up for in arenas of a few metres.
const GAP: f32 = 0x1p-8f;

// Where a body that wants to go from one point to another comes to: there, or along what it would touch there, or
// nowhere. One that `closes` first comes as near to that as it can; one that doesn't keeps its distance.
fn slid(world: u32, start: vec2<f32>, goal: vec2<f32>, closes: bool) -> vec2<f32> {
    if (!touches(world, goal)) {
        return goal;
    }
    let first = near_first(world, goal);
    let count = near_count(world, goal);
    var moved = vec2<f32>(goal.x - start.x, goal.y - start.y);
    for (var index = 0u; index < count; index++) {
        let shape = near_shape(world, first + index);
        if (squared_length(toward(shape, goal)) < shapes[shape].contact_squared) {
            // Without what leads into the object.
            let to = toward(shape, start);
            let squared = squared_length(to);
            let inverse = reciprocal_root(max(squared, 0x1p-60f));
            let room = select(0.0f, squared * inverse - (shapes[shape].contact + GAP), closes);
            let into = max((moved.x * to.x + moved.y * to.y) * inverse - room, 0.0f);
            moved = vec2<f32>(moved.x - into * (to.x * inverse), moved.y - into * (to.y * inverse));
        }
    }
    let aside = vec2<f32>(start.x + moved.x, start.y + moved.y);
    if (touches(world, aside)) {
        return start;
    }
    return aside;
}
