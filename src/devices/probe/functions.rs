//! The functions of `lib/numerics.wgsl` and `lib/random.wgsl`, one by one.

use oneiro_shaders::{PROBE_NUMERICS, probe_numerics as kernel};

use super::{Case, Subject};
use crate::exact::{LEAST, RECIPROCAL_GREATEST, ROOT_LEAST, TURNS_GREATEST};
use crate::random::pcg4d;

/// Arguments to test a function with: the range for which its comment states an error.
#[derive(Clone, Copy)]
enum Arguments {
    /// Positive numbers in a range.
    Positive(f32, f32),
    /// Numbers of either sign with magnitudes in a range, and 0 if the flag is set.
    Signed(f32, f32, bool),
    /// Vectors of every direction and length.
    Vectors,
    /// Words.
    Words,
}

/// Functions: number in the kernel, name and arguments.
const FUNCTIONS: &[(u32, &str, Arguments)] = &[
    (
        kernel::RECIPROCAL,
        "reciprocal",
        Arguments::Signed(LEAST, RECIPROCAL_GREATEST, false),
    ),
    (
        kernel::RECIPROCAL_ROOT,
        "reciprocal_root",
        Arguments::Positive(LEAST, f32::MAX),
    ),
    (kernel::ROOT, "root", Arguments::Positive(ROOT_LEAST, f32::MAX)),
    (kernel::COSINE, "cosine", Arguments::Signed(LEAST, TURNS_GREATEST, true)),
    (kernel::SINE, "sine", Arguments::Signed(LEAST, TURNS_GREATEST, true)),
    (kernel::DIRECTION, "direction", Arguments::Vectors),
    (kernel::EXPONENTIAL, "exponential", Arguments::Signed(LEAST, 87.0, true)),
    (kernel::LOGISTIC, "logistic", Arguments::Signed(LEAST, f32::MAX, true)),
    (kernel::LOGARITHM, "logarithm", Arguments::Positive(LEAST, f32::MAX)),
    (kernel::UNIT, "unit", Arguments::Words),
    (kernel::WORD_0, "random word 0", Arguments::Words),
    (kernel::WORD_1, "random word 1", Arguments::Words),
    (kernel::WORD_2, "random word 2", Arguments::Words),
    (kernel::WORD_3, "random word 3", Arguments::Words),
];

/// Every function of the kernels' library, each with `arguments` arguments (at least 64) from its whole range. Random
/// words are those of stream 1, step 4999 and block 3, with the arguments as keys.
pub fn functions(arguments: usize) -> Vec<Case> {
    let count = arguments.max(64);
    FUNCTIONS
        .iter()
        .map(|&(function, name, range)| {
            let (left, right) = range.operands(count);
            let probe = kernel::Probe {
                function,
                count: left.len() as u32,
                step: 4_999,
                block: 3,
            };
            Case {
                kernel: &PROBE_NUMERICS,
                subject: Subject::Function(name),
                parameters: bytemuck::cast(probe),
                left,
                right,
            }
        })
        .collect()
}

impl Arguments {
    fn operands(self, count: usize) -> (Vec<u32>, Vec<u32>) {
        let left = match self {
            Self::Positive(least, greatest) => spread(least, greatest, count),
            Self::Signed(least, greatest, zero) => {
                let sizes = spread(least, greatest, count / 2 - 1);
                let signs = sizes.iter().flat_map(|size| [*size, size | 1 << 31]);
                signs.chain([0, 1 << 31].into_iter().filter(|_| zero)).collect()
            }
            Self::Vectors => return vectors(count).into_iter().unzip(),
            Self::Words => {
                let words = (0..count as u32).map(|index| pcg4d([index; 4]));
                return words
                    .zip(0..)
                    // Keys that differ least, and keys that differ most.
                    .map(|([a, b, ..], index)| if index % 2 == 0 { (index, 0) } else { (a, b) })
                    .unzip();
            }
        };
        let right = vec![0; left.len()];
        (left, right)
    }
}

/// Bits of numbers in a range, ends included, evenly spread over all floats in between.
fn spread(least: f32, greatest: f32, count: usize) -> Vec<u32> {
    let (first, last) = (least.to_bits(), greatest.to_bits());
    let span = u64::from(last - first);
    (0..count as u64)
        .map(|index| first + (span * index / (count as u64 - 1)) as u32)
        .collect()
}

/// Vectors along the axes and diagonals, with similar components, with any components in [2^-60, 2^60], and (0, 0).
fn vectors(count: usize) -> Vec<(u32, u32)> {
    let exact = [0.0, 1.0, -1.0, 1e-18, -1e-18, 1e18, -1e18].map(f32::to_bits);
    let mut vectors: Vec<(u32, u32)> = exact.iter().flat_map(|&x| exact.map(|y| (x, y))).collect();
    vectors.extend((0..(count - vectors.len()) as u32).map(|index| {
        let [a, b, c, d] = pcg4d([index, 1, 0, 0]);
        let number = |digits: u32, exponent: u32| digits & 0x807f_ffff | (127 - 60 + exponent) << 23;
        let exponent = c % 120;
        let other = match index % 3 {
            0 => exponent,
            1 => (exponent + d % 8).min(119),
            _ => d % 120,
        };
        if d >> 31 == 0 {
            (number(a, exponent), number(b, other))
        } else {
            (number(a, other), number(b, exponent))
        }
    }));
    vectors
}
