// batch-place: the number of a robot
fn mission_cycle(life: Life, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(life));
    x = f32(life.member);
    return Tally(x, before);
}
