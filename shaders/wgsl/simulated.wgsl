// A single robot's world by itself, commanded from outside: the entry of kernels that are printed in other languages. Its `main` replaces
// an episode's. `dispatch.step_begin` says what it does, and is known when it is printed. An episode's inputs are its key, its trial, the
// commands of both wheels, its cycle and a pose.

const SIMULATED_BEGIN: u32 = 0u;
const SIMULATED_PLACE: u32 = 1u;
const SIMULATED_SENSE: u32 = 2u;

// Inputs after the commands.
const SIMULATED_CYCLE: u32 = 2u;
const SIMULATED_POSE: u32 = 3u;

fn simulated_input(index: u32) -> f32 {
    return bitcast<f32>(inputs[KEY_WORDS + index]);
}

@compute @workgroup_size(64)
fn main() {
    let episode = Episode(0u, vec2<u32>(inputs[0], inputs[1]), KEY_WORDS, inputs[2]);
    let step = inputs[KEY_WORDS + SIMULATED_CYCLE];
    if (dispatch.step_begin == SIMULATED_BEGIN) {
        let first = first_state(episode);
        state[0] = first;
        trace[0].record = Record(
            stored(first.x), stored(first.y), stored(first.heading), 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f,
            stored(score(episode, first)),
        );
        fitness[0] = select(0.0f, 1.0f, is_over(episode, first));
    } else if (dispatch.step_begin == SIMULATED_PLACE) {
        var placed = state[0];
        placed.x = simulated_input(SIMULATED_POSE);
        placed.y = simulated_input(SIMULATED_POSE + 1u);
        placed.heading = simulated_input(SIMULATED_POSE + 2u);
        state[0] = placed;
    } else if (dispatch.step_begin == SIMULATED_SENSE) {
        // Of this cycle only what the sensors read is taken.
        trace[0].details = details_kept(cycle(episode, step, state[0]).line.details);
    } else {
        let result = cycle(episode, step, state[0]);
        let after = kept(result.next);
        let r = result.line.record;
        state[0] = after;
        trace[0].record = Record(
            stored(after.x), stored(after.y), stored(after.heading), 0.0f, 0.0f, 0.0f, 0.0f, stored(r.speed_left), stored(r.speed_right),
            r.collided, stored(r.reward), stored(score(episode, after)),
        );
        fitness[0] = select(0.0f, 1.0f, is_over(episode, after));
    }
}
