// Stay together: in each cycle a swarm earns the share of its robots that are in the largest cluster. Robots whose middles are less
// than a distance apart are linked, also through others. Fitness: the mean over the episode, 0 to 1.

struct TaskValues {
    reach: f32, // 250, 1 to 100000 mm: distance of linked robots
}

fn mission_cycle(episode: Episode, step: u32, before: MissionState) -> Tally {
    let largest = clusters_within(episode, task_values(episode).reach).largest;
    return Tally(f32(largest) / f32(robots(episode)) / f32(cycles(episode)), before);
}
