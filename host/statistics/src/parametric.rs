//! Tests of means, for values about normal.

use super::resample::Interval;
use super::special::{Probability, f_tail, t_tails};
use super::summary::{all_equal, mean, squares, variance};
use super::{Result, check, check_groups, check_pairs, undefined};

/// A one-way analysis of variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anova {
    /// The mean square between groups over that within.
    pub f: f64,
    /// Degrees of freedom between groups: k - 1.
    pub df_between: f64,
    /// Degrees of freedom within groups: N - k.
    pub df_within: f64,
    /// Probability of an F at least as large.
    pub p: Probability,
}

/// One-way analysis of variance of two or more independent groups (Fisher, "Statistical Methods for Research Workers",
/// 1925). With two it is Student's t test, squared.
///
/// # Errors
///
/// Fewer than two groups, an empty one, no more values than groups, or no variation within any.
pub fn anova(groups: &[&[f64]]) -> Result<Anova> {
    const FIGURE: &str = "analysis of variance";
    check_groups(FIGURE, groups)?;
    let values = groups.concat();
    if values.len() <= groups.len() {
        return undefined(FIGURE, "every group has 1 value; allowed: a group of 2 or more");
    }
    if groups.iter().all(|group| all_equal(&[group])) {
        return undefined(
            FIGURE,
            "the values of each group are equal; allowed: variation within a group",
        );
    }
    let grand = mean(&values);
    let distance = |group: &&[f64]| group.len() as f64 * (mean(*group) - grand) * (mean(*group) - grand);
    let between: f64 = groups.iter().map(distance).sum();
    let within: f64 = groups.iter().map(|group| squares(group)).sum();
    let df_between = (groups.len() - 1) as f64;
    let df_within = (values.len() - groups.len()) as f64;
    let f = between / df_between / (within / df_within);
    Ok(Anova {
        f,
        df_between,
        df_within,
        p: f_tail(f, df_between, df_within),
    })
}

/// A t test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StudentT {
    /// The difference over its standard error; positive where the first sample's mean is the greater.
    pub t: f64,
    /// Degrees of freedom.
    pub df: f64,
    /// Probability of a t at least as far from 0.
    pub p: Probability,
}

impl StudentT {
    fn new(difference: f64, standard_error: f64, df: f64) -> Self {
        let t = difference / standard_error;
        let p = t_tails(t, df);
        Self { t, df, p }
    }
}

/// Student's t test of two independent samples of equal variance (Student, "The probable error of a mean", Biometrika
/// 6(1), 1908).
///
/// # Errors
///
/// A sample of fewer than 2 values, or no variation within either.
pub fn student_t(a: &[f64], b: &[f64]) -> Result<StudentT> {
    check_variation("Student's t test", a, b)?;
    let (m, n) = (a.len() as f64, b.len() as f64);
    let df = m + n - 2.0;
    let pooled = (squares(a) + squares(b)) / df;
    Ok(StudentT::new(
        mean(a) - mean(b),
        (pooled * (1.0 / m + 1.0 / n)).sqrt(),
        df,
    ))
}

fn check_variation(figure: &'static str, a: &[f64], b: &[f64]) -> Result<()> {
    check(figure, &[a, b], 2)?;
    if all_equal(&[a]) && all_equal(&[b]) {
        return undefined(
            figure,
            "the values of each sample are equal; allowed: variation within one",
        );
    }
    Ok(())
}

/// The t test of pairs: that of their differences, first minus second, against 0.
///
/// # Errors
///
/// Samples of two lengths, fewer than 2 pairs, or differences that are all equal.
pub fn paired_t(a: &[f64], b: &[f64]) -> Result<StudentT> {
    const FIGURE: &str = "paired t test";
    check_pairs(FIGURE, a, b, 2)?;
    let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    one_sample(FIGURE, &differences, 0.0)
}

/// The confidence interval of the ratio of two means, first over second, by the logarithms' standard errors (the delta
/// method); `confidence` such as 0.9.
///
/// # Errors
///
/// A sample of fewer than 2 values, or a mean that is not above 0.
pub fn ratio_interval(a: &[f64], b: &[f64], confidence: f64) -> Result<Interval> {
    const FIGURE: &str = "ratio of means";
    check(FIGURE, &[a, b], 2)?;
    let (above, below) = (mean(a), mean(b));
    if !(above > 0.0 && below > 0.0) {
        return undefined(FIGURE, format!("means of {above} and {below}; allowed: above 0"));
    }
    let error = |sample: &[f64], mean: f64| variance(sample) / (sample.len() as f64 * mean * mean);
    let spread = (error(a, above) + error(b, below)).sqrt();
    let reach = t_within(confidence, (a.len() + b.len() - 2) as f64) * spread;
    let ratio = above / below;
    Ok(Interval {
        low: ratio * (-reach).exp(),
        high: ratio * reach.exp(),
    })
}

/// The confidence interval of a mean, by Student's t; `confidence` such as 0.95.
///
/// # Errors
///
/// A sample of fewer than 2 values.
pub fn mean_interval(sample: &[f64], confidence: f64) -> Result<Interval> {
    check("interval of a mean", &[sample], 2)?;
    let n = sample.len() as f64;
    let reach = t_within(confidence, n - 1.0) * (variance(sample) / n).sqrt();
    let mean = mean(sample);
    Ok(Interval {
        low: mean - reach,
        high: mean + reach,
    })
}

/// The confidence interval of a weighted sum of the means of independent samples, each with its weight, by Welch's t: variances may
/// differ (Welch, "The generalization of 'Student's' problem when several different population variances are involved", Biometrika
/// 34(1), 1947). Of one sample with the weight 1 it is [`mean_interval`].
///
/// # Errors
///
/// No sample, or one of fewer than 2 values.
pub fn contrast_interval(samples: &[(f64, &[f64])], confidence: f64) -> Result<Interval> {
    const FIGURE: &str = "interval of a contrast";
    let all: Vec<&[f64]> = samples.iter().map(|(_, sample)| *sample).collect();
    check(FIGURE, &all, 2)?;
    if all.is_empty() {
        return undefined(FIGURE, "has no sample; allowed: 1 or more");
    }
    let value: f64 = samples.iter().map(|(weight, sample)| weight * mean(*sample)).sum();
    let square = |(weight, sample): &(f64, &[f64])| weight * weight * variance(sample) / sample.len() as f64;
    let whole: f64 = samples.iter().map(square).sum();
    if whole == 0.0 {
        return Ok(Interval {
            low: value,
            high: value,
        });
    }
    let parts = samples
        .iter()
        .map(|sample| square(sample).powi(2) / (sample.1.len() - 1) as f64);
    let reach = t_within(confidence, whole * whole / parts.sum::<f64>()) * whole.sqrt();
    Ok(Interval {
        low: value - reach,
        high: value + reach,
    })
}

/// The t with this fraction of Student's distribution between -t and t, below 1000: such as 1.96 for 0.95 and many
/// degrees of freedom.
pub fn t_within(share: f64, df: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1e3);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if t_tails(middle, df).value > 1.0 - share {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// The t test of a sample against a known mean.
///
/// # Errors
///
/// Fewer than 2 values, or all of them equal.
pub fn one_sample_t(sample: &[f64], expected: f64) -> Result<StudentT> {
    one_sample("one-sample t test", sample, expected)
}

fn one_sample(figure: &'static str, sample: &[f64], expected: f64) -> Result<StudentT> {
    check(figure, &[sample, &[expected, expected]], 2)?;
    if all_equal(&[sample]) {
        return undefined(figure, "all values are equal; allowed: some variation");
    }
    let n = sample.len() as f64;
    Ok(StudentT::new(
        mean(sample) - expected,
        (variance(sample) / n).sqrt(),
        n - 1.0,
    ))
}
