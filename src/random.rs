//! Random numbers by counter, the host's side: a rollout's key is a function of who it is, never of what was drawn
//! before.

/// The key of a rollout's random numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Key(pub [u32; 2]);

impl Key {
    /// The key of one trial of one individual: all 256 bits enter. The same on every host.
    ///
    /// ```
    /// use oneiro::random::Key;
    /// assert_ne!(Key::rollout(1, 0, 0, 0), Key::rollout(1, 0, 0, 1));
    /// ```
    pub fn rollout(run_seed: u64, generation: u64, individual: u64, trial: u64) -> Self {
        let [a, b] = words(run_seed);
        let [c, d] = words(generation);
        let run = pcg4d([a, b, c, d]);
        let [a, b] = words(individual);
        let [c, d] = words(trial);
        // Twice, since once leaves the words' high bits little mixed.
        let [x, y, ..] = pcg4d(pcg4d([run[0] ^ a, run[1] ^ b, run[2] ^ c, run[3] ^ d]));
        Self([x, y])
    }
}

/// Low word first.
fn words(number: u64) -> [u32; 2] {
    [number as u32, (number >> 32) as u32]
}

/// The hash that the kernels draw from: 128 bits to 128 bits, a bijection (Jarzynski and Olano, "Hash Functions for
/// GPU Rendering", Journal of Computer Graphics Techniques 9(3), 2020).
pub fn pcg4d(words: [u32; 4]) -> [u32; 4] {
    let round = |[x, y, z, w]: [u32; 4]| {
        let x = x.wrapping_add(y.wrapping_mul(w));
        let y = y.wrapping_add(z.wrapping_mul(x));
        let z = z.wrapping_add(x.wrapping_mul(y));
        let w = w.wrapping_add(y.wrapping_mul(z));
        [x, y, z, w]
    };
    let seeded = words.map(|word| word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    round(round(seeded).map(|word| word ^ (word >> 16)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Worked out from the definition with integers of any size.
    #[test]
    fn known_answers() {
        assert_eq!(pcg4d([0, 0, 0, 0]), [0x0f02_f829, 0x2d56_8769, 0x32b0_c43b, 0xd325_48ea]);
        assert_eq!(pcg4d([1, 2, 3, 4]), [0x3622_cd16, 0xf114_71d8, 0xe110_9b3f, 0x02b9_4c2f]);
        assert_eq!(pcg4d([u32::MAX; 4]), [0x974e_d892, 0xc015_dc67, 0x9f95_5760, 0xa1bb_a208]);
        assert_eq!(Key::rollout(0, 0, 0, 0), Key([0x683e_e330, 0x8f0f_75b9]));
        assert_eq!(Key::rollout(0x0123_4567_89ab_cdef, 199, 99, 3), Key([0xbe6a_10f3, 0xc7ca_ca06]));
    }

    #[test]
    fn a_million_keys_are_a_million() {
        let mut keys: Vec<Key> = Vec::with_capacity(1_000_000);
        for run in 0..10 {
            for generation in 0..100 {
                for individual in 0..250 {
                    for trial in 0..4 {
                        keys.push(Key::rollout(run, generation, individual, trial));
                    }
                }
            }
        }
        keys.sort_unstable_by_key(|key| key.0);
        keys.dedup();
        assert_eq!(keys.len(), 1_000_000);
    }

    #[test]
    fn every_bit_of_every_number_turns_half_the_key() {
        for argument in 0..4 {
            for bit in 0..64 {
                let turned: u32 = (0..256_u64)
                    .map(|sample| {
                        let base = [sample, sample / 3, sample * 7, sample % 5];
                        let mut other = base;
                        other[argument] ^= 1 << bit;
                        let [a, b] = [base, other].map(|[r, g, i, t]| Key::rollout(r, g, i, t).0);
                        (a[0] ^ b[0]).count_ones() + (a[1] ^ b[1]).count_ones()
                    })
                    .sum();
                let mean = f64::from(turned) / 256.0;
                assert!((30.0..34.0).contains(&mean), "argument {argument}, bit {bit}: {mean} of 64 bits turn");
            }
        }
    }
}
