// A world of several robots by itself, commanded from outside: the entry of kernels that are printed in other languages. Its `main` replaces
// that of `physics/commanded`, for one world. Its inputs are the key, the trial, and of each robot the commands of both wheels and the number
// of cycles that the episode has had when this one is over.

@compute @workgroup_size(64)
fn main() {
    let episode = Episode(0u, vec2<u32>(inputs[0], inputs[1]), KEY_WORDS, inputs[2], 0u, WORLD_WORDS, 0u);
    fitness[0] = commanded_cycle(episode, inputs[KEY_WORDS + COMMANDS], 0u);
}
