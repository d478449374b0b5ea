// Traces of worlds of robots that are observed: instead of the first robot's line one for each robot, robot after
// robot. They also say whose messages the robot has heard and what it has earned since the line before. `MEMBER_SENDERS`, a bit for
// each robot in SENDER_WORDS words, and `MEMBER_EARNED` are generated. The fitness of a line is what it would be if the episode ended
// there.

fn traced(episode: Episode, result: Cycle, record: u32) {
    let count = member_count(episode.world);
    let now = score(episode);
    for (var member = 0u; member < count; member++) {
        let me = member_episode(episode, member);
        let member_words = me.member_words;
        trace[record * count + member] = line(me, act_kept(member_words), result.earned, now);
        put(member_words, MEMBER_EARNED, 0.0f);
        for (var word = 0u; word < SENDER_WORDS; word++) {
            put_word(member_words, MEMBER_SENDERS + word, 0u);
        }
    }
}

fn keep_sender(member_words: u32, sender: u32) {
    let field = MEMBER_SENDERS + (sender >> 5u);
    put_word(member_words, field, word(member_words, field) | (1u << (sender & 31u)));
}

fn keep_earned(member_words: u32, earned: f32) {
    put(member_words, MEMBER_EARNED, number(member_words, MEMBER_EARNED) + earned);
}
