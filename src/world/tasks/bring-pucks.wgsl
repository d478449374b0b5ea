// Bring pucks to the nest: one patch of the floor is the nest. A robot that carries none takes what is in reach of its gripper while it is
// outside of the nest, and puts it down in the nest. Fitness: the share of the pucks that lie in the nest, its mean over the episode, and what
// carrying earned.

struct TaskValues {
    nest: f32, // 0, 0 to 4095: number of the patch that is the nest, from 0
    carry: f32, // 0.1, 0 to 1000: what carrying earns, for all robots over a whole episode
}

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    let own = task_values(episode);
    let is_home = on_patch(episode, u32(own.nest), now.end.xy);
    var carries = carries_puck(episode);
    if carries && is_home {
        carries = !put_puck(episode);
    } else if !carries && !is_home {
        carries = take_puck(episode);
    }
    let share = own.carry / f32(cycles(episode)) / f32(robots(episode));
    return Reward(select(0.0, share, carries), before);
}

fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    let nest = u32(task_values(episode).nest);
    var home = 0u;
    for (var i = 0u; i < pucks(episode); i++) {
        if !is_carried(episode, i) && on_patch(episode, nest, puck_place(episode, i)) {
            home += 1u;
        }
    }
    return Tally(f32(home) / f32(pucks(episode)) / f32(cycles(episode)), before);
}
