//! The test of a race: Friedman's, and of the candidates that differ Conover's comparisons with the best (Conover, "Practical
//! Nonparametric Statistics", 3rd edition, 1999, section 5.8), as irace has them.

use super::tails;

/// The ranks of candidates, from 1 for the best, equal ones sharing the mean of theirs; lower places are better.
fn ranks(places: &[u32]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by_key(|&index| places[index]);
    let mut ranks = vec![0.0; places.len()];
    let mut better = 0;
    for equals in order.chunk_by(|&a, &b| places[a] == places[b]) {
        for &index in equals {
            ranks[index] = better as f64 + f64::midpoint(equals.len() as f64, 1.0);
        }
        better += equals.len();
    }
    ranks
}

/// The sum of each candidate's ranks over all instances.
pub(super) fn sums(instances: &[Vec<u32>]) -> Vec<f64> {
    let mut sums = vec![0.0; instances.first().map_or(0, Vec::len)];
    for places in instances {
        for (sum, rank) in sums.iter_mut().zip(ranks(places)) {
            *sum += rank;
        }
    }
    sums
}

/// Which candidates stay: all if there is no difference, else those that are not worse than the best. `instances` has the place of
/// each candidate on each of two or more.
pub(super) fn kept(instances: &[Vec<u32>], confidence: f64) -> Vec<bool> {
    let sums = sums(instances);
    let (count, lives) = (sums.len(), instances.len());
    let (k, n) = (count as f64, lives as f64);
    // Of all squared ranks: k (k + 1) (2 k + 1) / 6 an instance without ties.
    let squares: f64 = instances
        .iter()
        .flat_map(|places| ranks(places))
        .map(|rank| rank * rank)
        .sum();
    let mean = n * (k + 1.0) / 2.0;
    let between: f64 = sums.iter().map(|sum| (sum - mean) * (sum - mean)).sum();
    // Friedman's statistic, corrected for ties.
    let within = squares - n * k * (k + 1.0) * (k + 1.0) / 4.0;
    if count < 2 || within <= 0.0 {
        return vec![true; count];
    }
    let statistic = (k - 1.0) * between / within;
    let alpha = 1.0 - confidence;
    if tails::chi_squared(statistic, count - 1) >= alpha {
        return vec![true; count];
    }
    let df = (lives - 1) * (count - 1);
    let all: f64 = sums.iter().map(|sum| sum * sum).sum();
    let error = (2.0 * (n * squares - all).max(0.0) / df as f64).sqrt();
    let best = sums.iter().copied().fold(f64::INFINITY, f64::min);
    let is_kept = |sum: &f64| *sum == best || tails::student((sum - best) / error, df) >= alpha;
    sums.iter().map(is_kept).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hollander and Wolfe's rounding times (1973, p. 140): `friedman.test` of R has a statistic of 11.143 with 2 degrees of freedom
    /// and p = 0.003805.
    const TIMES: [[f64; 3]; 22] = [
        [5.40, 5.50, 5.55],
        [5.85, 5.70, 5.75],
        [5.20, 5.60, 5.50],
        [5.55, 5.50, 5.40],
        [5.90, 5.85, 5.70],
        [5.45, 5.55, 5.60],
        [5.40, 5.40, 5.35],
        [5.45, 5.50, 5.35],
        [5.25, 5.15, 5.00],
        [5.85, 5.80, 5.70],
        [5.25, 5.20, 5.10],
        [5.65, 5.55, 5.45],
        [5.60, 5.35, 5.45],
        [5.05, 5.00, 4.95],
        [5.50, 5.50, 5.40],
        [5.45, 5.55, 5.50],
        [5.55, 5.55, 5.35],
        [5.45, 5.50, 5.55],
        [5.50, 5.45, 5.25],
        [5.65, 5.60, 5.40],
        [5.70, 5.65, 5.55],
        [6.30, 6.30, 6.25],
    ];

    fn places() -> Vec<Vec<u32>> {
        let each = TIMES.iter().map(|times| {
            let place = |time: &f64| times.iter().filter(|other| *other < time).count() as u32;
            times.iter().map(place).collect()
        });
        each.collect()
    }

    #[test]
    fn the_statistic_is_that_of_a_textbook() {
        let places = places();
        assert_eq!(sums(&places), [53.0, 47.0, 32.0]);
        // p = 0.003805: a difference at 0.99, none at 0.997. The third runner is best; the error of a difference of sums by
        // Conover's formula is 5.7321 with 42 degrees of freedom, so the others are 3.66 and 2.62 errors behind: p = 0.0007 and 0.012.
        assert_eq!(kept(&places, 0.997), [true, true, true]);
        assert_eq!(kept(&places, 0.99), [false, true, true]);
        assert_eq!(kept(&places, 0.95), [false, false, true]);
    }

    #[test]
    fn equals_stay_and_the_always_worse_go() {
        assert_eq!(kept(&vec![vec![0, 0, 0]; 9], 0.95), [true; 3]);
        assert_eq!(kept(&vec![vec![2, 0, 1, 3]; 9], 0.95), [false, true, false, false]);
        assert_eq!(kept(&vec![vec![0, 0, 2]; 9], 0.95), [true, true, false]);
    }
}
