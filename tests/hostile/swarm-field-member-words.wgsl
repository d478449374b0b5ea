// batch-place: the place of a robot's words
fn mission_cycle(life: Life, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(life));
    x = f32(life.member_words);
    return Tally(x, before);
}
