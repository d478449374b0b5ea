// A controller by itself: the entry of kernels that are printed in other languages. Its `main` replaces an episode's.
// `dispatch.step_begin` says what it does, and is known when it is printed. The caller's words, `exported`, are generated, and so are
// the functions that read and write them.

const EXPORT_BEGIN: u32 = 0u;
const EXPORT_CYCLE: u32 = 1u;

@compute @workgroup_size(64)
fn main() {
    let episode = exported_episode();
    if (dispatch.step_begin == EXPORT_BEGIN) {
        exported.cycle = 0u;
        keep_exported(controller_kept(controller_begin(episode)));
    } else if (dispatch.step_begin == EXPORT_CYCLE) {
        let command = commands(episode, exported.cycle, exported_readings(), exported_memory());
        exported.cycle += 1u;
        keep_exported(controller_kept(command.state));
        exported.left = stored(command.outputs.x);
        exported.right = stored(command.outputs.y);
    } else {
        let speeds = exported_speeds(episode, vec2<f32>(exported.left, exported.right));
        exported.speed_left = stored(speeds.x);
        exported.speed_right = stored(speeds.y);
    }
}
