// episode-as-given: what the world remembers, which has an episode in it
fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    var x = f32(robots(episode));
    var all: EpisodeState;
    x = robot_pose(all.episode, 0u).x;
    return Tally(x, before);
}
