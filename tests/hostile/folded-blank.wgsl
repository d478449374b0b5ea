// ascii-source (in the text alone): a folded constant by a blank that naga takes
const C: f32 = sin‎(1.0f);

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = C;
    return Reward(x, before);
}
