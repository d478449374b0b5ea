// Traces of worlds of robots: the first robot's lines.

fn traced(episode: Episode, lived: Cycle, record: u32) {
    trace[record] = line(member_episode(episode, 0u), lived.first, lived.earned, number(episode.world_words, WORLD_EARNED));
}

fn keep_sender(own: u32, sender: u32) {
}

fn keep_earned(own: u32, earned: f32) {
}
