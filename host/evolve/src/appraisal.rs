//! Means of genomes' fitness over many episodes, with their confidence intervals. They are results, so they use only
//! operations that are equal on all machines: sums in a fixed order, and square roots.

use std::cmp::Ordering;

/// A genome's mean fitness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Appraisal {
    /// Number of episodes.
    pub lives: u32,
    /// The mean; NaN if an episode's fitness is.
    pub mean: f64,
    /// Half the width of its 95 % confidence interval: Student's t times the standard error.
    pub reach: f64,
    /// The standard deviation over episodes.
    pub deviation: f64,
}

impl Appraisal {
    /// The mean fitness of two or more episodes, and its interval.
    pub fn of(fitness: &[f32]) -> Self {
        let count = fitness.len() as f64;
        let mean = fitness.iter().map(|&life| f64::from(life)).sum::<f64>() / count;
        let distances = fitness.iter().map(|&life| f64::from(life) - mean);
        let squares: f64 = distances.map(|distance| distance * distance).sum();
        let standard_error = (squares / (count - 1.0) / count).sqrt();
        Self {
            lives: fitness.len() as u32,
            mean,
            reach: students_t(fitness.len() as u32 - 1) * standard_error,
            deviation: (squares / (count - 1.0)).sqrt(),
        }
    }

    /// Bounds of the interval.
    pub fn interval(&self) -> [f64; 2] {
        [self.mean - self.reach, self.mean + self.reach]
    }
}

/// Indices of means from best to worst: ties keep their order, NaN is last.
pub fn by_mean(appraisals: &[Appraisal]) -> Vec<usize> {
    let mut ranking: Vec<usize> = (0..appraisals.len()).collect();
    let order = |a: f64, b: f64| b.partial_cmp(&a).unwrap_or_else(|| a.is_nan().cmp(&b.is_nan()));
    ranking.sort_by(|&a, &b| match order(appraisals[a].mean, appraisals[b].mean) {
        Ordering::Equal => a.cmp(&b),
        other => other,
    });
    ranking
}

/// The t with 95 % of Student's distribution between -t and t. Above three degrees of freedom the expansion in their
/// reciprocals (Abramowitz and Stegun, "Handbook of Mathematical Functions", 26.7.5) is within 0.001 of it, above ten
/// within 0.00001.
fn students_t(degrees: u32) -> f64 {
    const NORMAL: f64 = 1.959_963_984_540_054;
    const FEW: [f64; 3] = [12.706_204_736_432_1, 4.302_652_729_749_46, 3.182_446_305_284_26];
    if let 1..=3 = degrees {
        return FEW[degrees as usize - 1];
    }
    let z = NORMAL;
    let [z3, z5, z7, z9] = [
        z * z * z,
        z * z * z * z * z,
        z * z * z * z * z * z * z,
        z * z * z * z * z * z * z * z * z,
    ];
    let terms = [
        (z3 + z) / 4.0,
        (5.0 * z5 + 16.0 * z3 + 3.0 * z) / 96.0,
        (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / 384.0,
        (79.0 * z9 + 776.0 * z7 + 1482.0 * z5 - 1920.0 * z3 - 945.0 * z) / 92_160.0,
    ];
    let share = 1.0 / f64::from(degrees);
    terms.iter().rev().fold(0.0, |sum, term| (sum + term) * share) + z
}

#[cfg(test)]
mod tests {
    use super::*;
    use oneiro_statistics::t_within;

    #[test]
    fn t_is_students() {
        for degrees in 1..2000 {
            let allowed = if degrees > 10 { 1e-5 } else { 1e-3 };
            let exact = t_within(0.95, f64::from(degrees));
            assert!((students_t(degrees) - exact).abs() < allowed, "{degrees}: {exact}");
        }
    }

    #[test]
    fn means_have_intervals() {
        let appraisal = Appraisal::of(&[1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!((appraisal.lives, appraisal.mean), (5, 3.0));
        // 2.776 standard errors of sqrt(2.5 / 5).
        assert!((appraisal.reach - 2.776_445 * 0.5_f64.sqrt()).abs() < 1e-3);
        assert_eq!(appraisal.deviation, 2.5_f64.sqrt());
        let [low, high] = appraisal.interval();
        assert_eq!((low, high), (3.0 - appraisal.reach, 3.0 + appraisal.reach));
        assert_eq!(Appraisal::of(&[7.0, 7.0]).interval(), [7.0, 7.0]);
        assert!(Appraisal::of(&[7.0, f32::NAN]).mean.is_nan());
    }

    #[test]
    fn the_best_mean_is_first_and_nan_last() {
        let of = |lives: [f32; 2]| Appraisal::of(&lives);
        let all = [of([1.0, 1.0]), of([f32::NAN, 9.0]), of([0.0, 4.0]), of([2.0, 2.0])];
        assert_eq!(by_mean(&all), [2, 3, 0, 1]);
    }
}
