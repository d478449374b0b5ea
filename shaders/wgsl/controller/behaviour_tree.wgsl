// A behaviour tree of AutoMoDe's modules (modules.wgsl), as AutoMoDe-Maple has it: a sequence with memory of up to four branches, each a
// selector of a condition and a behaviour. src/parts/automode/behaviour_tree.rs has the genes' names.

const BRANCHES: u32 = 4u;

// Genes: the number of branches; of each the condition and its three values, and the behaviour and its two values.
const CONDITION_GENES: u32 = 4u;
const BRANCH_GENES: u32 = CONDITION_GENES + 3u;
const CONTROLLER_GENES: u32 = 1u + BRANCHES * BRANCH_GENES;

// Blocks of random numbers: whether each condition holds, at first and when the tree is asked again.
const FIRST: u32 = 0u;
const AGAIN: u32 = 1u;

struct ControllerState {
    // the branch that the next cycle begins with
    branch: u32,
    // of each branch, cycles that its exploration still turns: counter-clockwise if positive
    turning: vec4<i32>,
}

// The first branch from one on whose condition doesn't hold, hence whose behaviour acts; `count` if there is none.
fn acting_branch(episode: Episode, count: u32, begin: u32, drawn: vec4<f32>, readings: Readings) -> u32 {
    var chances = array<f32, 4>(drawn.x, drawn.y, drawn.z, drawn.w);
    var found = count;
    for (var nth = 0u; nth < BRANCHES; nth++) {
        if ((nth >= begin) & (nth < found)) {
            if (chances[nth] >= probability(episode, 1u + nth * BRANCH_GENES, readings)) {
                found = nth;
            }
        }
    }
    return found;
}

fn controller_cycle(episode: Episode, step: u32, readings: Readings, before: ControllerState) -> Command {
    let count = whole_gene(episode, 0u, 1.0f, 4.0f);
    var branch = acting_branch(episode, count, before.branch, random(episode, STREAM_CONTROLLER, step, FIRST), readings);
    // If all conditions hold, the tree has succeeded and is asked once more, from its beginning.
    if (branch == count) {
        branch = acting_branch(episode, count, 0u, random(episode, STREAM_CONTROLLER, step, AGAIN), readings);
    }
    // Then it rests.
    if (branch == count) {
        return Command(vec2<f32>(0.5f, 0.5f), ControllerState(0u, before.turning));
    }
    let is_own = vec4<u32>(0u, 1u, 2u, 3u) == vec4<u32>(branch);
    let turning = select(vec4<i32>(0), before.turning, is_own);
    let first = 1u + branch * BRANCH_GENES + CONDITION_GENES;
    let acted = behave(episode, step, first, readings, turning.x + turning.y + turning.z + turning.w);
    return Command(
        0.5f + 0.5f * acted.wheels,
        ControllerState(branch, select(before.turning, vec4<i32>(acted.turning), is_own)),
    );
}
