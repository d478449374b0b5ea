// batch-place: the place of a robot's words
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(episode));
    x = f32(episode.member_words);
    return Tally(x, before);
}
