// A rollout's genes.

fn gene(life: Life, index: u32) -> f32 {
    return bitcast<f32>(inputs[life.genes + index * LANES]);
}
