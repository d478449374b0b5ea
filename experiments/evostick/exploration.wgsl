// GRID: a square of 2.5 m around the arena's middle, (0, 0), in ten by ten cells. In each cycle a hundredth of the cycles since a
// robot was last in it is subtracted for each cell (Results-Transferability, GridExplorationLoopFunc).
struct MissionState {
    // cycles since the last visit, four cells each
    ages_0: vec4<u32>,
    ages_1: vec4<u32>,
    ages_2: vec4<u32>,
    ages_3: vec4<u32>,
    ages_4: vec4<u32>,
    ages_5: vec4<u32>,
    ages_6: vec4<u32>,
    ages_7: vec4<u32>,
    ages_8: vec4<u32>,
    ages_9: vec4<u32>,
    ages_10: vec4<u32>,
    ages_11: vec4<u32>,
    ages_12: vec4<u32>,
    ages_13: vec4<u32>,
    ages_14: vec4<u32>,
    ages_15: vec4<u32>,
    ages_16: vec4<u32>,
    ages_17: vec4<u32>,
    ages_18: vec4<u32>,
    ages_19: vec4<u32>,
    ages_20: vec4<u32>,
    ages_21: vec4<u32>,
    ages_22: vec4<u32>,
    ages_23: vec4<u32>,
    ages_24: vec4<u32>,
}

// Ten cells in 2500.01 mm, the program's side.
const EACH_MM: f32 = 0.003999984f;

fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    // which cells robots are in, a bit for each
    var visits = array<u32, 4>();
    for (var robot = 0u; robot < robots(episode); robot++) {
        let pose = robot_pose(episode, robot);
        let x = pose.x * EACH_MM + 5.0f;
        let y = pose.y * EACH_MM + 5.0f;
        let is_inside = (x >= 0.0f) & (x < 10.0f) & (y >= 0.0f) & (y < 10.0f);
        let cell = 10u * u32(clamp(x, 0.0f, 9.5f)) + u32(clamp(y, 0.0f, 9.5f));
        for (var word = 0u; word < 4u; word++) {
            visits[word] |= select(0u, 1u << (cell & 31u), is_inside & ((cell >> 5u) == word));
        }
    }
    var ages = array<u32, 100>(
        before.ages_0.x, before.ages_0.y, before.ages_0.z, before.ages_0.w,
        before.ages_1.x, before.ages_1.y, before.ages_1.z, before.ages_1.w,
        before.ages_2.x, before.ages_2.y, before.ages_2.z, before.ages_2.w,
        before.ages_3.x, before.ages_3.y, before.ages_3.z, before.ages_3.w,
        before.ages_4.x, before.ages_4.y, before.ages_4.z, before.ages_4.w,
        before.ages_5.x, before.ages_5.y, before.ages_5.z, before.ages_5.w,
        before.ages_6.x, before.ages_6.y, before.ages_6.z, before.ages_6.w,
        before.ages_7.x, before.ages_7.y, before.ages_7.z, before.ages_7.w,
        before.ages_8.x, before.ages_8.y, before.ages_8.z, before.ages_8.w,
        before.ages_9.x, before.ages_9.y, before.ages_9.z, before.ages_9.w,
        before.ages_10.x, before.ages_10.y, before.ages_10.z, before.ages_10.w,
        before.ages_11.x, before.ages_11.y, before.ages_11.z, before.ages_11.w,
        before.ages_12.x, before.ages_12.y, before.ages_12.z, before.ages_12.w,
        before.ages_13.x, before.ages_13.y, before.ages_13.z, before.ages_13.w,
        before.ages_14.x, before.ages_14.y, before.ages_14.z, before.ages_14.w,
        before.ages_15.x, before.ages_15.y, before.ages_15.z, before.ages_15.w,
        before.ages_16.x, before.ages_16.y, before.ages_16.z, before.ages_16.w,
        before.ages_17.x, before.ages_17.y, before.ages_17.z, before.ages_17.w,
        before.ages_18.x, before.ages_18.y, before.ages_18.z, before.ages_18.w,
        before.ages_19.x, before.ages_19.y, before.ages_19.z, before.ages_19.w,
        before.ages_20.x, before.ages_20.y, before.ages_20.z, before.ages_20.w,
        before.ages_21.x, before.ages_21.y, before.ages_21.z, before.ages_21.w,
        before.ages_22.x, before.ages_22.y, before.ages_22.z, before.ages_22.w,
        before.ages_23.x, before.ages_23.y, before.ages_23.z, before.ages_23.w,
        before.ages_24.x, before.ages_24.y, before.ages_24.z, before.ages_24.w,
    );
    var total = 0u;
    for (var cell = 0u; cell < 100u; cell++) {
        let is_visited = (visits[cell >> 5u] & (1u << (cell & 31u))) != 0u;
        let age = select(ages[cell], 0u, is_visited);
        total += age;
        ages[cell] = age + 1u;
    }
    let now = MissionState(
        vec4<u32>(ages[0], ages[1], ages[2], ages[3]),
        vec4<u32>(ages[4], ages[5], ages[6], ages[7]),
        vec4<u32>(ages[8], ages[9], ages[10], ages[11]),
        vec4<u32>(ages[12], ages[13], ages[14], ages[15]),
        vec4<u32>(ages[16], ages[17], ages[18], ages[19]),
        vec4<u32>(ages[20], ages[21], ages[22], ages[23]),
        vec4<u32>(ages[24], ages[25], ages[26], ages[27]),
        vec4<u32>(ages[28], ages[29], ages[30], ages[31]),
        vec4<u32>(ages[32], ages[33], ages[34], ages[35]),
        vec4<u32>(ages[36], ages[37], ages[38], ages[39]),
        vec4<u32>(ages[40], ages[41], ages[42], ages[43]),
        vec4<u32>(ages[44], ages[45], ages[46], ages[47]),
        vec4<u32>(ages[48], ages[49], ages[50], ages[51]),
        vec4<u32>(ages[52], ages[53], ages[54], ages[55]),
        vec4<u32>(ages[56], ages[57], ages[58], ages[59]),
        vec4<u32>(ages[60], ages[61], ages[62], ages[63]),
        vec4<u32>(ages[64], ages[65], ages[66], ages[67]),
        vec4<u32>(ages[68], ages[69], ages[70], ages[71]),
        vec4<u32>(ages[72], ages[73], ages[74], ages[75]),
        vec4<u32>(ages[76], ages[77], ages[78], ages[79]),
        vec4<u32>(ages[80], ages[81], ages[82], ages[83]),
        vec4<u32>(ages[84], ages[85], ages[86], ages[87]),
        vec4<u32>(ages[88], ages[89], ages[90], ages[91]),
        vec4<u32>(ages[92], ages[93], ages[94], ages[95]),
        vec4<u32>(ages[96], ages[97], ages[98], ages[99]),
    );
    return Tally(-0.01f * f32(total), now);
}
