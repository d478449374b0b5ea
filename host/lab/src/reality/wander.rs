//! Driving about at random between two episodes, so that the next one starts elsewhere.

use oneiro::random::{Key, pcg4d};

/// Cycles of 100 ms for which a robot drives about between two episodes.
pub const WALK: u32 = 100;

/// Genes of a perceptron with this many inputs, which depend on its key only: weights U(-5, 5), which turn in either direction
/// before an object, and biases U(0, 5), which drive ahead in the open.
pub fn wanderer(key: Key, inputs: usize, genes: usize) -> Vec<f32> {
    let gene = |gene: usize| {
        let [word, ..] = pcg4d([key.words[0], key.words[1], gene as u32, 1995]);
        let share = (word >> 8) as f32 / (1 << 24) as f32;
        // An output has its weights, then its bias.
        if gene % (inputs + 1) == inputs {
            5.0 * share
        } else {
            10.0 * share - 5.0
        }
    };
    (0..genes).map(gene).collect()
}
