// batch-place: the place of a world's words
fn mission_cycle(life: Life, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(life));
    x = f32(life.world_words);
    return Tally(x, before);
}
