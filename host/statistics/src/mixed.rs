//! A linear mixed model with a random intercept, for values that share something by group: y = a + b x + u(group) + e.
//!
//! It is fitted by restricted maximum likelihood (Patterson and Thompson, "Recovery of inter-block information when
//! block sizes are unequal", Biometrika 58(3), 1971). With λ = var(u) / var(e), a group of n values enters by its
//! deviations from its mean, and by its mean with the weight w = n / (1 + n λ). All else follows from λ in closed form,
//! so that minus twice the log-likelihood is, up to a constant, a function of λ only:
//!
//! (N - 2) ln R + Σ ln(1 + n λ) + ln Σ w + ln S,
//!
//! where S is the sum of squares of x about its mean and R that of the residuals, both within groups plus between
//! groups by the weights w.

use std::collections::BTreeMap;

use super::special::{Probability, normal_tails};
use super::summary::{all_equal, mean, squares};
use super::{Result, check_groups, check_pairs, undefined};

/// A fitted model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RandomIntercept {
    /// a: the intercept of a group without an effect.
    pub intercept: f64,
    /// b: the slope, common to all groups.
    pub slope: f64,
    /// The slope's standard error.
    pub standard_error: f64,
    /// The slope over its standard error.
    pub z: f64,
    /// Probability of a z at least as far from 0, by the normal distribution: too small with few groups and with x that
    /// is the same within each.
    pub p: Probability,
    /// The variance of the groups' effects.
    pub(crate) between_variance: f64,
    /// The variance of the residuals.
    pub(crate) within_variance: f64,
    /// Groups.
    pub groups: usize,
}

const FIGURE: &str = "random-intercept model";
const NO_RESIDUALS: &str = "each group's values lie on a line of one slope; allowed: residual variation within groups";

/// Fits y = a + b x + u(group) + e. Groups may be of any sizes; x may vary within them, between them, or both.
///
/// # Errors
///
/// Samples of unequal lengths; all x equal; too few values or groups to tell the two variances; or no residual
/// variation within groups.
pub fn random_intercept(x: &[f64], y: &[f64], group: &[usize]) -> Result<RandomIntercept> {
    check_pairs(FIGURE, x, y, 1)?;
    if group.len() != x.len() {
        return undefined(
            FIGURE,
            format!("has {} groups of {} values; allowed: one each", group.len(), x.len()),
        );
    }
    if all_equal(&[x]) {
        return undefined(FIGURE, "all x are equal; allowed: some variation");
    }
    let data = Data::new(x, y, group);
    data.check()?;
    let ratio = data.likeliest_ratio()?;
    let fit = data.fit(ratio);
    let within_variance = fit.residual / (data.values - 2.0);
    let standard_error = (within_variance / fit.xx).sqrt();
    let z = fit.slope / standard_error;
    Ok(RandomIntercept {
        intercept: fit.mean_y - fit.slope * fit.mean_x,
        slope: fit.slope,
        standard_error,
        z,
        p: normal_tails(z),
        between_variance: ratio * within_variance,
        within_variance,
        groups: data.groups.len(),
    })
}

/// A group's size and means.
struct Group {
    n: f64,
    x: f64,
    y: f64,
}

/// Statistics of the values that suffice for the likelihood.
struct Data {
    groups: Vec<Group>,
    /// How many values there are.
    values: f64,
    /// Sums over all values of the products of deviations from the group's means.
    within_xx: f64,
    within_xy: f64,
    within_yy: f64,
}

/// The estimates for one ratio of variances.
struct Fit {
    slope: f64,
    /// Weighted means of the groups' means.
    mean_x: f64,
    mean_y: f64,
    /// Σ w.
    weight: f64,
    /// S: the weighted sum of squares of x.
    xx: f64,
    /// R: the weighted sum of squares of the residuals.
    residual: f64,
}

impl Data {
    fn new(x: &[f64], y: &[f64], group: &[usize]) -> Self {
        let mut members: BTreeMap<usize, Vec<(f64, f64)>> = BTreeMap::new();
        for ((&x, &y), &group) in x.iter().zip(y).zip(group) {
            members.entry(group).or_default().push((x, y));
        }
        let mut data = Self {
            groups: Vec::with_capacity(members.len()),
            values: x.len() as f64,
            within_xx: 0.0,
            within_xy: 0.0,
            within_yy: 0.0,
        };
        for members in members.values() {
            let n = members.len() as f64;
            // Where all x are one number, their mean is that number, so that nothing is left within.
            let first = members[0].0;
            let mean_x = first + members.iter().map(|(x, _)| x - first).sum::<f64>() / n;
            let mean_y = members.iter().map(|(_, y)| y).sum::<f64>() / n;
            for (x, y) in members {
                let (dx, dy) = (x - mean_x, y - mean_y);
                data.within_xx += dx * dx;
                data.within_xy += dx * dy;
                data.within_yy += dy * dy;
            }
            data.groups.push(Group {
                n,
                x: mean_x,
                y: mean_y,
            });
        }
        data
    }

    /// Checks that a degree of freedom is left between groups and another within, once the slope has its own.
    fn check(&self) -> Result<()> {
        let groups = self.groups.len() as f64;
        let slope_within = self.within_xx > 0.0;
        let least_groups = if slope_within { 2 } else { 3 };
        if self.groups.len() < least_groups {
            let problem = format!("has {groups} groups; allowed: 2 or more, 3 where x is the same within each");
            return undefined(FIGURE, problem);
        }
        if self.values - groups - f64::from(u8::from(slope_within)) < 1.0 {
            return undefined(
                FIGURE,
                format!(
                    "has {} values in {groups} groups; allowed: more of them within groups",
                    self.values
                ),
            );
        }
        let explained = if slope_within {
            self.within_xy * self.within_xy / self.within_xx
        } else {
            0.0
        };
        // Less is about what rounding leaves of a line through all points.
        if self.within_yy - explained <= 1e-12 * self.within_yy {
            return undefined(FIGURE, NO_RESIDUALS);
        }
        Ok(())
    }

    /// The estimates for a ratio λ: generalised least squares.
    fn fit(&self, ratio: f64) -> Fit {
        let weighted = |value: &dyn Fn(&Group) -> f64| -> f64 {
            self.groups
                .iter()
                .map(|group| weight(group, ratio) * value(group))
                .sum()
        };
        let weight = weighted(&|_| 1.0);
        let mean_x = weighted(&|group| group.x) / weight;
        let mean_y = weighted(&|group| group.y) / weight;
        let xx = self.within_xx + weighted(&|group| (group.x - mean_x) * (group.x - mean_x));
        let xy = self.within_xy + weighted(&|group| (group.x - mean_x) * (group.y - mean_y));
        let slope = xy / xx;
        let residual_within = self.within_yy - 2.0 * slope * self.within_xy + slope * slope * self.within_xx;
        let residual_between = weighted(&|group| {
            let residual = group.y - mean_y - slope * (group.x - mean_x);
            residual * residual
        });
        Fit {
            slope,
            mean_x,
            mean_y,
            weight,
            xx,
            residual: residual_within + residual_between,
        }
    }

    /// Minus twice the restricted log-likelihood of a ratio, up to a constant.
    fn deviance(&self, ratio: f64) -> f64 {
        let fit = self.fit(ratio);
        let sizes: f64 = self.groups.iter().map(|group| (group.n * ratio).ln_1p()).sum();
        (self.values - 2.0) * fit.residual.ln() + sizes + fit.weight.ln() + fit.xx.ln()
    }

    /// The derivative of the deviance. Means and slope minimise S and R, so only the weights' derivatives, -w^2, enter.
    fn deviance_slope(&self, ratio: f64) -> f64 {
        let fit = self.fit(ratio);
        let terms = self.groups.iter().map(|group| {
            let w = weight(group, ratio);
            let dx = group.x - fit.mean_x;
            let residual = group.y - fit.mean_y - fit.slope * dx;
            let information = 1.0 / fit.weight + dx * dx / fit.xx;
            w - w * w * ((self.values - 2.0) * residual * residual / fit.residual + information)
        });
        terms.sum()
    }

    /// The maximum-likelihood ratio, from the change of sign of the deviance's derivative: between the points of a
    /// grid, then by bisection. The deviance itself is flat at the bottom and gives only half of the digits.
    fn likeliest_ratio(&self) -> Result<f64> {
        // 0, then 1e-12 to 1e12 by halves of powers of ten.
        let powers = (-24..=24).map(|half| 10_f64.powf(f64::from(half) / 2.0));
        let grid: Vec<f64> = std::iter::once(0.0).chain(powers).collect();
        let is_falling: Vec<bool> = grid.iter().map(|&ratio| self.deviance_slope(ratio) < 0.0).collect();
        let mut minima = if is_falling[0] { vec![] } else { vec![0.0] };
        for (ends, falling) in grid.windows(2).zip(is_falling.windows(2)) {
            if falling[0] && !falling[1] {
                minima.push(self.bottom(ends[0], ends[1]));
            }
        }
        let least = minima
            .into_iter()
            .min_by(|&a, &b| self.deviance(a).total_cmp(&self.deviance(b)));
        least.map_or_else(|| undefined(FIGURE, NO_RESIDUALS), Ok)
    }

    /// A ratio between two where the deviance no longer falls, to the last place.
    fn bottom(&self, mut low: f64, mut high: f64) -> f64 {
        loop {
            let middle = f64::midpoint(low, high);
            if middle <= low || middle >= high {
                return middle;
            }
            if self.deviance_slope(middle) < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
    }
}

/// The weight of a group's means.
fn weight(group: &Group, ratio: f64) -> f64 {
    group.n / (1.0 + group.n * ratio)
}

/// The mean of values that are nested in groups: y = a + u(group) + e.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NestedMean {
    /// a.
    pub mean: f64,
    /// Its standard error; 0 where all values are equal.
    pub standard_error: f64,
    /// Degrees of freedom of Student's t: groups - 1.
    pub df: f64,
}

/// Fits y = a + u(group) + e by restricted maximum likelihood to groups of one size, for which it has a closed form: that of the
/// analysis of variance, unless groups' means vary less than values within would make them, and u is 0 (Searle, Casella and
/// `McCulloch`, "Variance Components", Wiley 1992, section 4.5).
///
/// # Errors
///
/// Fewer than two groups, groups of different sizes, or values that are not finite.
pub fn nested_mean(groups: &[Vec<f64>]) -> Result<NestedMean> {
    const FIGURE: &str = "mean of nested values";
    let samples: Vec<&[f64]> = groups.iter().map(Vec::as_slice).collect();
    check_groups(FIGURE, &samples)?;
    let size = groups[0].len();
    if groups.iter().any(|group| group.len() != size) {
        return undefined(FIGURE, "groups have different sizes; allowed: groups of one size");
    }
    let count = (groups.len() * size) as f64;
    let means: Vec<f64> = groups.iter().map(mean).collect();
    let all = mean(&means);
    let between = size as f64 * squares(&means) / (groups.len() - 1) as f64;
    let inner: f64 = samples.iter().map(|group| squares(group)).sum();
    let within = inner / (count - groups.len() as f64).max(1.0);
    let square = if between >= within {
        between
    } else {
        // One variance for all values.
        (inner + between * (groups.len() - 1) as f64) / (count - 1.0)
    };
    Ok(NestedMean {
        mean: all,
        standard_error: (square / count).sqrt(),
        df: (groups.len() - 1) as f64,
    })
}
