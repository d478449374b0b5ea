// Inputs of AutoMoDe's modules from the reference model RM1.1: sums of the readings as vectors, ahead and to the left.

struct Given {
    prox: vec2<f32>,
    light: vec2<f32>,
    ground: f32,
    neighbours: f32,
    attraction: vec2<f32>,
}

fn given_to(episode: Episode, step: u32, pose: vec3<f32>) -> Given {
    let at = vec2<f32>(pose.x, pose.y);
    let heading = cosine_sine(pose.z);
    let all = heard(episode, step, heading);
    return Given(
        flushed2(ring_sum(proximity(episode, step, at, heading))),
        flushed2(ring_sum(brightness(episode, step, at, pose.z))),
        floor_by_vote(episode, step, at, heading),
        f32(all.number),
        flushed2(all.attraction),
    );
}

fn flushed2(v: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(flushed(v.x), flushed(v.y));
}
