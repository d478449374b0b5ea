//! The host's random numbers: named streams by counter, and distributions made only of `+ - * /` and `sqrt`, so that
//! every host draws the same bits. They implement `rand`'s trait `Distribution`, which is also that of `rand_distr`.

use oneiro::random::pcg4d;
use rand::Rng;
use rand::distr::Distribution;
use rand_pcg::Pcg64;

/// The purpose of a stream of random numbers. A purpose's number never changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// The genes of generation 0.
    InitialGenes = 0,
    /// Mutations, a stream for each generation that they lead to.
    Mutation = 1,
    /// Mutations of simulators after an exchange, a stream for each interval that they lead to.
    Exchange = 2,
    /// The times at which robots are switched on.
    Schedule = 3,
    /// The order of equals, a stream for each interval.
    Ties = 4,
    /// Interventions of the experimenter, a stream for each interval.
    Intervention = 5,
    /// A sweep's values drawn from ranges.
    Samples = 6,
    /// Parents, a stream for each generation that they lead to.
    Selection = 7,
    /// Second parents and their genes, a stream for each generation that they lead to.
    Crossover = 8,
    /// Samples of an evolution strategy, a stream for each generation.
    Sampling = 9,
    /// Where an evolution strategy begins, again a stream for each generation.
    Beginning = 10,
    /// Samples of behaviour that centroids divide.
    Centroids = 11,
    /// Behaviours that an archive keeps, a stream for each generation.
    Archive = 12,
    /// The seed of the second of two populations.
    SecondPopulation = 13,
    /// Opponents from a hall of fame, a stream for each generation.
    Opponents = 14,
    /// Links between robots that are open, a stream for each interval.
    Migration = 15,
}

/// The stream of a run for a purpose and a generation. It depends only on these three, so no generator's state is
/// saved. Different arguments give different streams: pcg4d is a bijection.
pub fn stream(seed: u64, purpose: Stream, generation: u32) -> Pcg64 {
    let [a, b, c, d] = pcg4d([seed as u32, (seed >> 32) as u32, generation, purpose as u32]).map(u128::from);
    Pcg64::new(a | b << 32 | c << 64 | d << 96, DEFAULT_STREAM)
}

/// The increment that PCG's author gives as the default.
const DEFAULT_STREAM: u128 = 0x0a02_bdbf_7bb3_c0a7_ac28_fa16_a64a_bf96;

/// A random order of the numbers below `count` (Fisher and Yates).
pub fn shuffled(count: usize, random: &mut (impl Rng + ?Sized)) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    for last in (1..count).rev() {
        order.swap(last, below(last + 1, random));
    }
    order
}

/// A whole number below `count`, which is far below 2^53.
pub fn below(count: usize, random: &mut (impl Rng + ?Sized)) -> usize {
    (unit(random) * count as f64) as usize
}

/// A number in `[0, 1)`, a multiple of 2^-53.
pub fn unit(random: &mut (impl Rng + ?Sized)) -> f64 {
    unit_of(random.next_u64())
}

/// The number in `[0, 1)` that [`unit()`] makes of a random word.
pub(crate) fn unit_of(word: u64) -> f64 {
    const SPACING: f64 = 1.0 / UNITS as f64;
    (word >> 11) as f64 * SPACING
}

/// How many numbers [`unit()`] may give.
const UNITS: u64 = 1 << 53;

/// A yes or no, yes with this probability, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chance(pub f64);

impl Chance {
    /// The bound below which a random word's first 53 bits say yes: they are compared as whole numbers then, not as units.
    pub fn bound(self) -> u64 {
        // Exact: multiplying by a power of two only scales, and the smallest whole number that is not below has the
        // same numbers below it.
        (self.0 * UNITS as f64).ceil() as u64
    }
}

impl Distribution<bool> for Chance {
    fn sample<R: Rng + ?Sized>(&self, random: &mut R) -> bool {
        unit(random) < self.0
    }
}

/// Uniform numbers from `low` up to `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uniform {
    /// The minimum.
    pub low: f64,
    /// The maximum.
    pub high: f64,
}

impl Uniform {
    /// The number at a fraction of the range, from 0 up to 1.
    pub fn at(&self, share: f64) -> f64 {
        self.low + (self.high - self.low) * share
    }
}

impl Distribution<f64> for Uniform {
    fn sample<R: Rng + ?Sized>(&self, random: &mut R) -> f64 {
        self.at(unit(random))
    }
}

/// Normal numbers of mean 0, by the polar method (Marsaglia and Bray, "A convenient method for generating normal
/// variables", SIAM Review 6(3), 1964). The second number of each pair is dropped, so that a draw
/// leaves nothing to save.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normal {
    /// Standard deviation.
    pub deviation: f64,
}

impl Normal {
    /// A number's draws from the generator, the smaller part of the work: [`Normal::of`] makes the number from them, on
    /// any thread.
    pub fn drawn(random: &mut (impl Rng + ?Sized)) -> [f64; 2] {
        loop {
            let x = 2.0 * unit(random) - 1.0;
            let y = 2.0 * unit(random) - 1.0;
            let square = x * x + y * y;
            if square > 0.0 && square < 1.0 {
                return [x, square];
            }
        }
    }

    /// The number.
    pub fn of(self, [x, square]: [f64; 2]) -> f64 {
        self.deviation * (x * (-2.0 * logarithm(square) / square).sqrt())
    }
}

impl Distribution<f64> for Normal {
    fn sample<R: Rng + ?Sized>(&self, random: &mut R) -> f64 {
        self.of(Self::drawn(random))
    }
}

/// The natural logarithm of a positive normal number, within 2 units in the last place (4 near 1, where it is small):
/// from the exponent and, for the mantissa m between sqrt(1/2) and sqrt(2), the series of 2 artanh((m - 1)/(m + 1)).
pub fn logarithm(x: f64) -> f64 {
    const TERMS: u32 = 12;
    let mut exponent = (x.to_bits() >> 52) as i64 - 1023;
    let mut mantissa = f64::from_bits(x.to_bits() & ((1 << 52) - 1) | 1023 << 52);
    if mantissa > std::f64::consts::SQRT_2 {
        mantissa *= 0.5;
        exponent += 1;
    }
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let square = s * s;
    let mut series = 0.0;
    for term in (1..TERMS).rev() {
        series = (series + 1.0 / f64::from(2 * term + 1)) * square;
    }
    exponent as f64 * std::f64::consts::LN_2 + (2.0 * s + 2.0 * s * series)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Words of the generator and numbers made of them, computed independently with big integers and another logarithm. A
    /// change here changes every run.
    #[test]
    fn known_answers() {
        let mut random = stream(1, Stream::Mutation, 2);
        let words: Vec<u64> = (0..3).map(|_| random.next_u64()).collect();
        assert_eq!(
            words,
            [0xaec5_02da_e6f5_a186, 0x01fe_3416_ec28_d47e, 0xc80b_50c8_b018_aafe]
        );
        let normals: Vec<u64> = (0..3)
            .map(|_| Normal { deviation: 1.0 }.sample(&mut random).to_bits())
            .collect();
        assert_eq!(
            normals,
            [0xbfc8_7968_722b_8a4f, 0xbfd7_9010_ce6b_19b8, 0xbfc5_a6c1_53b6_0115]
        );
        let uniform = Uniform { low: -1.0, high: 1.0 }.sample(&mut random).to_bits();
        assert_eq!(uniform, 0x3fee_47cd_c8a2_3af4);
    }

    #[test]
    fn streams_differ_in_every_word_that_makes_them() {
        let first = |seed, purpose, generation| stream(seed, purpose, generation).next_u64();
        let mut words = vec![
            first(0, Stream::InitialGenes, 0),
            first(0, Stream::Mutation, 0),
            first(0, Stream::Mutation, 1),
            first(1, Stream::Mutation, 0),
            first(1 << 32, Stream::Mutation, 0),
        ];
        words.sort_unstable();
        words.dedup();
        assert_eq!(words.len(), 5);
    }

    #[test]
    fn logarithm_is_right_to_the_last_places() {
        let mut random = stream(3, Stream::Mutation, 0);
        let mut worst = 0.0_f64;
        for sample in 0..200_000 {
            let x = unit(&mut random) * if sample % 2 == 0 { 1.0 } else { 1e-6 };
            if x > 0.0 {
                worst = worst.max(((logarithm(x) - x.ln()) / x.ln()).abs() / f64::EPSILON);
            }
        }
        assert!(worst <= 4.0, "{worst} units in the last place");
        assert_eq!(logarithm(1.0), 0.0);
        assert_eq!(logarithm(0.25), -2.0 * std::f64::consts::LN_2);
    }

    /// The Kolmogorov-Smirnov distance to the normal of `rand_distr`, two samples of 100,000: one in a thousand exceeds
    /// 0.0087. The negative control, 2 % wider and shifted by a 20th of the deviation, does.
    #[test]
    fn normals_are_normal() {
        const SAMPLES: usize = 100_000;
        let sorted = |mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values
        };
        let mut random = stream(4, Stream::Mutation, 0);
        let samples = sorted(
            (0..SAMPLES)
                .map(|_| Normal { deviation: 2.0 }.sample(&mut random))
                .collect(),
        );
        let shifted = samples.iter().map(|x| x * 1.02 + 0.1).collect::<Vec<_>>();
        let reference = rand_distr::Normal::new(0.0, 2.0).expect("a normal");
        let mut random = stream(5, Stream::Mutation, 0);
        let reference = sorted((0..SAMPLES).map(|_| reference.sample(&mut random)).collect());
        let distance = |sample: &[f64]| {
            (0..SAMPLES)
                .map(|index| {
                    let below = reference.partition_point(|&x| x <= sample[index]);
                    ((index + 1) as f64 - below as f64).abs() / SAMPLES as f64
                })
                .fold(0.0, f64::max)
        };
        assert!(distance(&samples) < 0.0087, "{}", distance(&samples));
        assert!(distance(&shifted) > 0.0087, "{}", distance(&shifted));
        let mean = samples.iter().sum::<f64>() / SAMPLES as f64;
        let variance = samples.iter().map(|x| x * x).sum::<f64>() / SAMPLES as f64;
        assert!(
            mean.abs() < 0.02 && (variance - 4.0).abs() < 0.06,
            "mean {mean}, variance {variance}"
        );
    }

    #[test]
    fn uniforms_stay_in_range_and_fill_it() {
        let mut random = stream(6, Stream::InitialGenes, 0);
        let range = Uniform { low: -1.0, high: 3.0 };
        let values: Vec<f64> = (0..100_000).map(|_| range.sample(&mut random)).collect();
        assert!(values.iter().all(|x| (-1.0..=3.0).contains(x)));
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        assert!((mean - 1.0).abs() < 0.02, "{mean}");
        let happened = (0..100_000).filter(|_| Chance(0.25).sample(&mut random)).count();
        assert!((24_500..25_500).contains(&happened), "{happened}");
    }
}
