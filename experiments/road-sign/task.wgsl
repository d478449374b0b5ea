// Turn, at the end of the stem, to the side on which a lamp was passed: sensors.wgsl has the lamp and the walls.

struct TaskState {
    // greatest y, mm
    farthest: f32,
    // 0 on the way, 1 at the end of the signalled arm, 2 at the end of the other
    end: u32,
}

// y of the start and of the stem's end, and x of the ends of both arms, mm.
const START: f32 = 40.0f;
const STEM: f32 = 600.0f;
const LEFT_END: f32 = 60.0f;
const RIGHT_END: f32 = 670.0f;

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let is_left = lamp(episode).x == LEFT_WALL;
    let at_left = now.end.x < LEFT_END;
    let at_end = at_left | (now.end.x > RIGHT_END);
    let end = select(0u, select(2u, 1u, at_left == is_left), at_end);
    return Reward(0.0f, TaskState(max(before.farthest, now.end.y), end));
}

fn task_ends(episode: Episode, own: TaskState) -> bool {
    return own.end != 0u;
}

// 1 at the end of the signalled arm, 0 at that of the other; on the way 0.4 of the progress along the stem.
fn task_score(episode: Episode, own: TaskState, sum: f32) -> f32 {
    let progress = clamp((own.farthest - START) * reciprocal(STEM - START), 0.0f, 1.0f);
    return select(0.4f * progress, select(0.0f, 1.0f, own.end == 1u), own.end != 0u);
}
