// The behaviours' e-puck in other programs, which give its readings; its outputs command its wheels as any controller's do. The
// functions here replace those of `robot/epuck_alone`.

// What the four sensors at the front read, in [0, 1].
fn near(episode: Episode, step: u32, pose: vec3<f32>) -> vec4<f32> {
    let given = exported_readings();
    return vec4<f32>(given.near_left_17, given.near_left_50, given.near_right_50, given.near_right_17);
}

// What four sensors read of the light, in [0, 1].
fn light(episode: Episode, step: u32, half: u32, pose: vec3<f32>) -> vec4<f32> {
    let given = exported_readings();
    if (half == 1u) {
        return vec4<f32>(given.light_left_90, given.light_left_150, given.light_right_150, given.light_right_90);
    }
    return vec4<f32>(given.light_left_17, given.light_left_50, given.light_right_50, given.light_right_17);
}

fn commands(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let acted = act(episode, step, vec3<f32>(0.0f, 0.0f, 0.0f), readings, before);
    return Command(acted.outputs, acted.state);
}
