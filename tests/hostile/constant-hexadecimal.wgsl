// float-suffix (in the text alone): a constant whose last letter is a digit
const C: f32 = 0x1.8f * 3.0f;

fn task_cycle(episode: Episode, now: Experience, before: TaskState) -> Reward {
    var x = now.moved.left;
    x = C;
    return Reward(x, before);
}
