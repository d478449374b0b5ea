//! Tests of ranks, for values of any distribution.

use super::resample::Interval;
use super::special::{Probability, chi_squared_tail, normal_tails};
use super::summary::all_equal;
use super::{Result, check, check_groups, undefined};

/// How the probability of a rank statistic is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// By counting all the orders that there are: for small samples without ties.
    Exact,
    /// By the normal distribution that the statistic tends to, with the variance corrected for ties.
    Asymptotic,
}

/// The Mann-Whitney U test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MannWhitney {
    /// Pairs in which the first sample's value is the greater; ties count half.
    pub u: f64,
    /// Probability of a U at least as far from half the pairs.
    pub p: Probability,
}

/// The Mann-Whitney U test of two independent samples ("On a test of whether one of two random variables is
/// stochastically larger than the other", Annals of Mathematical Statistics 18(1), 1947). The asymptotic method has the
/// correction for continuity.
///
/// # Errors
///
/// An empty sample; all values equal; for the exact method, ties or more than 10,000 pairs.
pub fn mann_whitney(a: &[f64], b: &[f64], method: Method) -> Result<MannWhitney> {
    const FIGURE: &str = "Mann-Whitney U test";
    const MOST_PAIRS: usize = 10_000;
    check(FIGURE, &[a, b], 1)?;
    if all_equal(&[a, b]) {
        return undefined(FIGURE, "all values are equal; allowed: some variation");
    }
    let Ranks { ranks, ties } = rank(&[a, b].concat());
    let pairs = (a.len() * b.len()) as f64;
    let least_sum = (a.len() * (a.len() + 1) / 2) as f64;
    let u = ranks[..a.len()].iter().sum::<f64>() - least_sum;
    let greater = u.max(pairs - u);
    let p = match method {
        Method::Exact => {
            check_exact(FIGURE, ties, a.len() * b.len(), MOST_PAIRS, "pairs")?;
            upper_tail(&mann_whitney_counts(a.len(), b.len()), greater).twice()
        }
        Method::Asymptotic => {
            let total = ranks.len() as f64;
            let variance = pairs / 12.0 * (total + 1.0 - ties / (total * (total - 1.0)));
            normal_tails((greater - pairs / 2.0 - 0.5).max(0.0) / variance.sqrt())
        }
    };
    Ok(MannWhitney { u, p })
}

/// The confidence interval of a median, between two values of the sample, whatever its distribution: outside there are as few values on
/// either side as a fair coin would leave with at most that error (Thompson, "On confidence ranges for the median and other
/// expectation distributions for populations of unknown distribution form", Annals of Mathematical Statistics 7(3), 1936).
///
/// # Errors
///
/// Too few values: fewer than 6 for a confidence of 0.95.
pub fn median_interval(sample: &[f64], confidence: f64) -> Result<Interval> {
    const FIGURE: &str = "interval of a median";
    check(FIGURE, &[sample], 1)?;
    let mut sorted = sample.to_vec();
    sorted.sort_by(f64::total_cmp);
    let count = sorted.len();
    // The chance that so few of the values, or fewer, lie below the median.
    let (mut ln_chance, mut chance) = (-(count as f64) * std::f64::consts::LN_2, 0.0);
    let mut outside = 0;
    while outside < count / 2 {
        chance += f64::exp(ln_chance);
        if 1.0 - 2.0 * chance < confidence {
            break;
        }
        ln_chance += ((count - outside) as f64 / (outside + 1) as f64).ln();
        outside += 1;
    }
    if outside == 0 {
        let needed = (1.0 - f64::log2(1.0 - confidence)).ceil();
        return undefined(
            FIGURE,
            format!("sample 1 has {count} values; allowed: {needed} or more"),
        );
    }
    Ok(Interval {
        low: sorted[outside - 1],
        high: sorted[count - outside],
    })
}

/// Kendall's tau-b of two rankings of the same things: 1 if they agree, -1 if one is the other's reverse, corrected for ties ("The
/// treatment of ties in ranking problems", Biometrika 33(3), 1945).
///
/// # Errors
///
/// Samples of different lengths or of fewer than two values, or one whose values are all equal.
pub fn kendall(a: &[f64], b: &[f64]) -> Result<f64> {
    const FIGURE: &str = "Kendall's tau";
    check(FIGURE, &[a, b], 2)?;
    if a.len() != b.len() {
        return undefined(FIGURE, "the samples differ in length; allowed: pairs of values");
    }
    if all_equal(&[a]) || all_equal(&[b]) {
        return undefined(FIGURE, "all values are equal; allowed: some variation");
    }
    // Sums of whole numbers, exact below 2^53: the agreement of each pair, and the pairs without a tie in one sample.
    let (mut agreement, mut untied) = (0.0, [0.0, 0.0]);
    for second in 1..a.len() {
        for first in 0..second {
            let sign =
                |values: &[f64]| f64::from(values[second] > values[first]) - f64::from(values[second] < values[first]);
            let [a, b] = [sign(a), sign(b)];
            agreement += a * b;
            untied[0] += a * a;
            untied[1] += b * b;
        }
    }
    Ok(agreement / (untied[0] * untied[1]).sqrt())
}

/// The Kruskal-Wallis test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KruskalWallis {
    /// The statistic, corrected for ties.
    pub h: f64,
    /// Degrees of freedom: k - 1.
    pub df: f64,
    /// Probability of an H at least as large, by the chi-squared distribution that it tends to.
    pub p: Probability,
}

/// The Kruskal-Wallis test of two or more independent groups ("Use of ranks in one-criterion variance analysis",
/// Journal of the American Statistical Association 47, 1952).
///
/// # Errors
///
/// Fewer than two groups, an empty one, or all values equal.
pub fn kruskal_wallis(groups: &[&[f64]]) -> Result<KruskalWallis> {
    const FIGURE: &str = "Kruskal-Wallis test";
    check_groups(FIGURE, groups)?;
    if all_equal(groups) {
        return undefined(FIGURE, "all values are equal; allowed: some variation");
    }
    let Ranks { ranks, ties } = rank(&groups.concat());
    let total = ranks.len() as f64;
    let mut rest = ranks.as_slice();
    let mut between = 0.0;
    for group in groups {
        let (ranks_of_group, others) = rest.split_at(group.len());
        let n = ranks_of_group.len() as f64;
        let distance = ranks_of_group.iter().sum::<f64>() / n - f64::midpoint(total, 1.0);
        between += n * distance * distance;
        rest = others;
    }
    let h = 12.0 / (total * (total + 1.0)) * between / (1.0 - ties / (total * total * total - total));
    let df = (groups.len() - 1) as f64;
    Ok(KruskalWallis {
        h,
        df,
        p: chi_squared_tail(h, df),
    })
}

/// The ranks of values, in their order.
pub(super) struct Ranks {
    /// From 1; equal values share the mean of theirs.
    pub(super) ranks: Vec<f64>,
    /// The sum of t^3 - t over sets of t equal values: 0 without ties.
    pub(super) ties: f64,
}

/// Ranks values.
pub(super) fn rank(values: &[f64]) -> Ranks {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&i, &j| values[i].total_cmp(&values[j]));
    let mut ranks = vec![0.0; values.len()];
    let mut ties = 0.0;
    let mut before = 0;
    // By `==`, since the two zeros are equal.
    for equal in order.chunk_by(|&i, &j| values[i] == values[j]) {
        let t = equal.len() as f64;
        for &index in equal {
            ranks[index] = before as f64 + f64::midpoint(t, 1.0);
        }
        ties += t * t * t - t;
        before += equal.len();
    }
    Ranks { ranks, ties }
}

fn check_exact(figure: &'static str, ties: f64, count: usize, most: usize, unit: &str) -> Result<()> {
    if ties > 0.0 {
        return undefined(
            figure,
            "has ties, for which there is no exact method; allowed: the asymptotic one",
        );
    }
    if count > most {
        let problem =
            format!("has {count} {unit}; allowed: {most} for the exact method, any number for the asymptotic");
        return undefined(figure, problem);
    }
    Ok(())
}

/// Orders of m and n values for each U, 0 to m n, by Mann and Whitney's recurrence: the maximum is either one of the m,
/// and above n others, or one of the n. Sums of positive numbers, so that each is right to the last places.
fn mann_whitney_counts(m: usize, n: usize) -> Vec<f64> {
    let mut counts = vec![vec![0.0; m * n + 1]; m + 1];
    for counts_of in &mut counts {
        counts_of[0] = 1.0;
    }
    for others in 1..=n {
        for size in 1..=m {
            let (fewer, rest) = counts.split_at_mut(size);
            for (count, &before) in rest[0][others..].iter_mut().zip(&fewer[size - 1]) {
                *count += before;
            }
        }
    }
    counts.swap_remove(m)
}

/// The fraction of the counts at a value or above it.
fn upper_tail(counts: &[f64], value: f64) -> Probability {
    let tail: f64 = counts[value as usize..].iter().sum();
    Probability::new(tail / counts.iter().sum::<f64>())
}
