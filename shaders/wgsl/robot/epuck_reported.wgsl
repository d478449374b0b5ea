// An e-puck outside the kernel: its readings are reported after its genes, four of proximity and eight of
// light, and then whether it carries food.

const REPORTED_NEAR: u32 = FORAGER_GENES;
const REPORTED_LIGHT: u32 = REPORTED_NEAR + 4u;
const REPORTED_CARRIES: u32 = REPORTED_LIGHT + 8u;
// Inputs of an episode after its key.
const REPORTED_INPUTS: u32 = REPORTED_CARRIES + 1u;

fn reported(episode: Episode, first: u32) -> vec4<f32> {
    return vec4<f32>(gene(episode, first), gene(episode, first + 1u), gene(episode, first + 2u), gene(episode, first + 3u));
}

// What the four sensors at the front read, in [0, 1].
fn near(episode: Episode, step: u32, pose: vec3<f32>) -> vec4<f32> {
    return reported(episode, REPORTED_NEAR);
}

// What four sensors read of the light, in [0, 1].
fn light(episode: Episode, step: u32, half: u32, pose: vec3<f32>) -> vec4<f32> {
    return reported(episode, REPORTED_LIGHT + 4u * half);
}

fn carries(episode: Episode) -> bool {
    return gene(episode, REPORTED_CARRIES) > 0.0f;
}

// The robot's wheels decide what a command does.
fn wheels(episode: Episode) -> vec2<f32> {
    return vec2<f32>(1.0f, 1.0f);
}
