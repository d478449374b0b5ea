// Two networks in one genome: robot 0, the predator, has the first 32 genes, and robot 1, the prey, the last 22. Each has one layer,
// whose two outputs are also its inputs in the next cycle. The predator has 13 readings, 8 of infra-red and 5 of its camera, and the
// prey the first 8 of them (Floreano and Nolfi 1997).

const PREY_INPUTS: u32 = 8u;

struct ControllerValues {
    predator_speed: f32, // 0.5, 0 to 1: its greatest speed, as a share of robot.greatest_speed_mm_s
    prey_speed: f32, // 1, 0 to 1: that of the prey
}

// Of each wheel a weight per reading, then the weights of the last left and right outputs, and a bias.
struct ControllerGenes {
    predator_to_left: array<f32, INPUTS>,
    predator_left: array<f32, 3>,
    predator_to_right: array<f32, INPUTS>,
    predator_right: array<f32, 3>,
    prey_to_left: array<f32, PREY_INPUTS>,
    prey_left: array<f32, 3>,
    prey_to_right: array<f32, PREY_INPUTS>,
    prey_right: array<f32, 3>,
}

struct ControllerState {
    outputs: vec2<f32>,
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let own = controller_values(episode);
    var share = own.prey_speed;
    var left = 0.0f;
    var right = 0.0f;
    if (robot_number(episode) == 0u) {
        share = own.predator_speed;
        left = fed(episode, PREDATOR_TO_LEFT, INPUTS, readings, before);
        right = fed(episode, PREDATOR_TO_RIGHT, INPUTS, readings, before);
    } else {
        left = fed(episode, PREY_TO_LEFT, PREY_INPUTS, readings, before);
        right = fed(episode, PREY_TO_RIGHT, PREY_INPUTS, readings, before);
    }
    let outputs = vec2<f32>(logistic(left), logistic(right));
    // An output of 1/2 is a standstill.
    let driven = vec2<f32>(0.5f + share * (outputs.x - 0.5f), 0.5f + share * (outputs.y - 0.5f));
    return Command(driven, ControllerState(outputs));
}

// The input of an output unit, whose first gene is `first`.
fn fed(episode: Episode, first: u32, count: u32, readings: Readings, before: ControllerState) -> f32 {
    var sum = 0.0f;
    for (var i = 0u; i < min(count, INPUTS); i++) {
        sum += gene(episode, first + i) * reading(readings, i);
    }
    let last = first + count;
    return sum + gene(episode, last) * before.outputs.x + gene(episode, last + 1u) * before.outputs.y + gene(episode, last + 2u);
}
