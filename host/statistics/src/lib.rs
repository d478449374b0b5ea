//! Statistics: tests, effect sizes, a mixed model and resampling, as pure functions of samples.
//!
//! Tests have two sides: the alternative is that there is a difference, of either sign. They are those of `SciPy`, and
//! `tests/statistics` holds its figures for samples of many kinds; what is agreed upon to which precision stands in
//! `tests.rs`. Logarithms and exponentials are the platform's: figures of two hosts differ in the last places, so that
//! none of them may enter a run's results.

// Only this workspace uses it.
#![allow(
    missing_docs,
    clippy::missing_errors_doc,
    clippy::missing_panics_doc,
    clippy::return_self_not_must_use,
    rustdoc::private_intra_doc_links,
    reason = "items whose names do not say everything are documented"
)]
// `clippy.toml` says what has one place only.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

mod effects;
mod holm;
mod mixed;
mod parametric;
mod ranks;
mod resample;
mod special;
mod summary;
#[cfg(test)]
mod tests;

use std::fmt;

pub use effects::{cliffs_delta, cohens_d, roc_area, vargha_delaney};
pub use holm::holm;
pub use mixed::{nested_mean, random_intercept};
pub use parametric::{
    StudentT, anova, contrast_interval, mean_interval, one_sample_t, paired_t, ratio_interval, student_t, t_within,
};
pub use ranks::{Method, kendall, kruskal_wallis, mann_whitney, median_interval};
pub use resample::{Interval, bootstrap_interval, pseudo_values, subset};
pub use special::chi_squared_tail;
pub use special::{Probability, t_tails};
pub use summary::{mean, median, quantile, quantile_of_sorted, variance};

/// A figure that these samples do not have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Undefined {
    /// The figure, such as "Student's t test".
    pub figure: &'static str,
    /// The problem with the samples, and what is allowed.
    pub problem: String,
}

impl fmt::Display for Undefined {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.figure, self.problem)
    }
}

impl std::error::Error for Undefined {}

/// Result of these functions.
pub type Result<T> = std::result::Result<T, Undefined>;

fn undefined<T>(figure: &'static str, problem: impl Into<String>) -> Result<T> {
    Err(Undefined {
        figure,
        problem: problem.into(),
    })
}

/// Checks that each sample has `least` values or more, all of them finite.
fn check(figure: &'static str, samples: &[&[f64]], least: usize) -> Result<()> {
    for (sample, number) in samples.iter().zip(1..) {
        if sample.len() < least {
            let count = sample.len();
            let problem = format!("sample {number} has {count} values; allowed: {least} or more");
            return undefined(figure, problem);
        }
        if let Some(value) = sample.iter().find(|value| !value.is_finite()) {
            let problem = format!("sample {number} has a value that is {value}; allowed: finite numbers");
            return undefined(figure, problem);
        }
    }
    Ok(())
}

/// Checks two or more groups, none of them empty.
fn check_groups(figure: &'static str, groups: &[&[f64]]) -> Result<()> {
    check(figure, groups, 1)?;
    if groups.len() < 2 {
        return undefined(figure, format!("has {} groups; allowed: 2 or more", groups.len()));
    }
    Ok(())
}

/// Checks two samples whose values belong together.
fn check_pairs(figure: &'static str, a: &[f64], b: &[f64], least: usize) -> Result<()> {
    check(figure, &[a, b], least)?;
    if a.len() == b.len() {
        return Ok(());
    }
    undefined(
        figure,
        format!("samples of {} and {} values; allowed: pairs", a.len(), b.len()),
    )
}
