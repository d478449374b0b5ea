// Traces of worlds of robots: the first robot's lines.

fn traced(episode: Episode, result: Cycle, record: u32) {
    trace[record] = line(member_episode(episode, 0u), result.first, result.earned, number(episode.world_words, WORLD_EARNED));
}

fn keep_sender(member_words: u32, sender: u32) {
}

fn keep_earned(member_words: u32, earned: f32) {
}
