// An episode's genes.

fn gene(episode: Episode, index: u32) -> f32 {
    return bitcast<f32>(inputs[episode.genes + index * LANES]);
}
