// Speeds of both wheels where no robot is in sight and where one is, as shares of full speed: the controller without computation
// of Gauci, Chen, Li, Dodd and Gross (2014).
struct ControllerGenes {
    unseen_left: f32, // -1 to 1: of the left wheel while the sensor sees nothing
    unseen_right: f32, // -1 to 1: of the right wheel then
    seen_left: f32, // -1 to 1: of the left wheel while it sees another robot
    seen_right: f32, // -1 to 1: of the right wheel then
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let unseen = vec2<f32>(gene(episode, UNSEEN_LEFT), gene(episode, UNSEEN_RIGHT));
    let seen = vec2<f32>(gene(episode, SEEN_LEFT), gene(episode, SEEN_RIGHT));
    let speeds = select(unseen, seen, vec2<bool>(readings.sees > 0.5f));
    return Command(vec2<f32>(0.5f + 0.5f * speeds.x, 0.5f + 0.5f * speeds.y), before);
}
