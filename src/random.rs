//! The host's side of counter-based random numbers: an episode's key depends only on run, generation, individual and
//! trial, never on earlier draws.

/// Key of an episode's random numbers, and what chooses its world if worlds vary.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Key {
    /// The key of its random numbers.
    pub words: [u32; 2],
    /// Number of the trial, from 0.
    pub trial: u32,
    /// The same number for all episodes of a generation of a run.
    pub generation: u32,
}

impl Key {
    /// A key of trial 0.
    pub const fn of_words(words: [u32; 2]) -> Self {
        Self {
            words,
            trial: 0,
            generation: 0,
        }
    }

    /// Derives the key of one trial of one individual from all 256 bits of the arguments. It is the same on every host.
    ///
    /// ```
    /// use oneiro::random::Key;
    /// assert_ne!(Key::rollout(1, 0, 0, 0), Key::rollout(1, 0, 0, 1));
    /// ```
    pub fn rollout(run_seed: u64, generation: u64, individual: u64, trial: u64) -> Self {
        Keys::new(run_seed, generation).of(individual, trial)
    }
}

/// Keys of the episodes of a generation, in half of the time: their common part is computed once.
///
/// ```
/// use oneiro::random::{Key, Keys};
/// assert_eq!(Keys::new(1, 2).of(3, 4), Key::rollout(1, 2, 3, 4));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Keys([u32; 4]);

impl Keys {
    /// The keys of a generation of a run.
    pub fn new(run_seed: u64, generation: u64) -> Self {
        Self(mixed([0; 4], run_seed, generation))
    }

    /// As [`Key::rollout`].
    #[cfg_attr(not(debug_assertions), inline)]
    pub fn of(&self, individual: u64, trial: u64) -> Key {
        let [x, y, ..] = mixed(self.0, individual, trial);
        Key {
            words: [x, y],
            trial: trial as u32,
            generation: self.0[0],
        }
    }
}

/// Mixes two more numbers into a hash.
#[cfg_attr(not(debug_assertions), inline)]
fn mixed(hash: [u32; 4], first: u64, second: u64) -> [u32; 4] {
    let more = [first, first >> 32, second, second >> 32];
    pcg4d(std::array::from_fn(|word| hash[word] ^ more[word] as u32))
}

/// Hash that the kernels draw from: 128 bits to 128 bits, a bijection (Jarzynski and Olano, "Hash Functions for GPU
/// Rendering", Journal of Computer Graphics Techniques 9(3), 2020), with the third round of `lib/random.wgsl`.
//
// In the development profile this library is optimised and what calls it is not: inlined there it would take several times as long.
#[cfg_attr(not(debug_assertions), inline)]
pub fn pcg4d(words: [u32; 4]) -> [u32; 4] {
    let round = |[x, y, z, w]: [u32; 4]| {
        let x = x.wrapping_add(y.wrapping_mul(w));
        let y = y.wrapping_add(z.wrapping_mul(x));
        let z = z.wrapping_add(x.wrapping_mul(y));
        let w = w.wrapping_add(y.wrapping_mul(z));
        [x, y, z, w]
    };
    let seeded = words.map(|word| word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let folded = |words: [u32; 4]| words.map(|word| word ^ (word >> 16));
    round(folded(round(folded(round(seeded)))))
}

/// Words and their [hashes](pcg4d), computed from the definition with arbitrary-precision integers: for tests.
pub const KNOWN_ANSWERS: [([u32; 4], [u32; 4]); 3] = [
    ([0; 4], [0xb945_c51c, 0xcce1_9873, 0x67ad_221f, 0xe36d_57bc]),
    ([1, 2, 3, 4], [0x62d0_9abc, 0x66de_8150, 0xf741_90ef, 0x3a81_0846]),
    ([u32::MAX; 4], [0x9eac_8992, 0x26a8_d52c, 0x6783_e80d, 0x6301_b6ef]),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Computed from the definition with arbitrary-precision integers.
    #[test]
    fn known_answers() {
        for (words, hash) in KNOWN_ANSWERS {
            assert_eq!(pcg4d(words), hash);
        }
        assert_eq!(Key::rollout(0, 0, 0, 0).words, [0x258b_6576, 0x3b28_d866]);
        assert_eq!(
            Key::rollout(0x0123_4567_89ab_cdef, 199, 99, 3).words,
            [0xe38a_e345, 0xabb9_7375]
        );
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
        keys.sort_unstable_by_key(|key| key.words);
        keys.dedup_by_key(|key| key.words);
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
                        let [a, b] = [base, other].map(|[r, g, i, t]| Key::rollout(r, g, i, t).words);
                        (a[0] ^ b[0]).count_ones() + (a[1] ^ b[1]).count_ones()
                    })
                    .sum();
                let mean = f64::from(turned) / 256.0;
                assert!(
                    (30.0..34.0).contains(&mean),
                    "argument {argument}, bit {bit}: {mean} of 64 bits turn"
                );
            }
        }
    }
}
