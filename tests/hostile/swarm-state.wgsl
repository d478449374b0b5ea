// episode-as-given: what the world remembers, which has an episode in it
fn mission_cycle(life: Life, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(life));
    var all: State;
    x = robot_pose(all.life, 0u).x;
    return Tally(x, before);
}
