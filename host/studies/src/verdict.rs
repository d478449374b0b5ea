//! Verdicts by intervals. A part of a criterion holds where the 95 % interval of its figure lies on the asked side of a bound, is opposed
//! where it lies on the other, and is undecided where it spans the bound. The worst part is the claim's verdict.

use std::cmp::Ordering;
use std::fmt;

use oneiro_report::numbers::significant;
use oneiro_statistics::{Interval, contrast_interval};
use serde::{Deserialize, Serialize};

/// Level of the intervals.
pub(crate) const LEVEL: f64 = 0.95;
/// Runs that an interval or a test must have to decide anything: those of a condition of the 1995 paper, the smaller of the studies that
/// were registered.
const FEWEST: usize = 5;
/// Significant digits in reasons.
const DIGITS: usize = 3;

/// Outcome of a claim or of a part of it, from the best to the worst.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    Holds,
    /// An interval spans a bound, there are too few runs for an interval, or something was not measured.
    Undecided,
    Opposed,
    /// No question for a study, such as one that hardware answers. No part has it.
    NotJudged,
}

impl Verdict {
    /// Its name.
    pub fn word(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Undecided => "undecided",
            Self::Opposed => "opposed",
            Self::NotJudged => "not judged",
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// A part of a criterion.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Part {
    pub verdict: Verdict,
    /// The figure and its interval, or what is missing.
    pub reason: String,
}

impl Part {
    /// Something that was counted or measured without an error.
    pub(crate) fn fact(what: &str, holds: bool) -> Self {
        let (verdict, no) = if holds {
            (Verdict::Holds, "")
        } else {
            (Verdict::Opposed, "not: ")
        };
        Self {
            verdict,
            reason: format!("{no}{what}"),
        }
    }

    /// Something that can't be asked.
    pub(crate) fn undecided(reason: impl Into<String>) -> Self {
        Self {
            verdict: Verdict::Undecided,
            reason: reason.into(),
        }
    }

    /// Whether a weighted sum of the means of independent samples of runs is above a bound.
    pub(crate) fn above(what: &str, samples: &[(f64, &[f64])], bound: f64) -> Self {
        Self::within(what, samples, [bound, f64::INFINITY])
    }

    /// Whether it is below a bound.
    pub(crate) fn below(what: &str, samples: &[(f64, &[f64])], bound: f64) -> Self {
        Self::within(what, samples, [f64::NEG_INFINITY, bound])
    }

    /// Whether it is within a range.
    pub(crate) fn within(what: &str, samples: &[(f64, &[f64])], range: [f64; 2]) -> Self {
        let runs = samples.iter().map(|(_, sample)| sample.len()).min().unwrap_or(0);
        if samples
            .iter()
            .any(|(_, sample)| sample.iter().any(|value| !value.is_finite()))
        {
            return Self::undecided(format!("{what}: is no number in some runs"));
        }
        match contrast_interval(samples, LEVEL) {
            Ok(interval) => Self::of_interval(what, interval, range, runs),
            Err(_) => Self::undecided(format!("{what}: has no interval")).of_runs(runs),
        }
    }

    /// Whether a figure with this interval, from so many runs, is within a range, which may be open.
    pub(crate) fn of_interval(what: &str, Interval { low, high }: Interval, [from, to]: [f64; 2], runs: usize) -> Self {
        let [start, end] = [low, high].map(|end| significant(end, DIGITS));
        let shown = |bound: f64| significant(bound, DIGITS);
        let (verdict, reason) = if low > from && high < to {
            (Verdict::Holds, format!("{what}: {start} to {end}"))
        } else if high < from {
            (
                Verdict::Opposed,
                format!("{what}: {start} to {end}, below {}", shown(from)),
            )
        } else if low > to {
            (
                Verdict::Opposed,
                format!("{what}: {start} to {end}, above {}", shown(to)),
            )
        } else {
            let bound = if low <= from { from } else { to };
            let reason = format!("{what}: the 95 % interval {start} to {end} spans {}", shown(bound));
            (Verdict::Undecided, reason)
        };
        Self { verdict, reason }.of_runs(runs)
    }

    /// The same, undecided if it is of too few runs.
    pub(crate) fn of_runs(self, runs: usize) -> Self {
        if runs >= FEWEST {
            return self;
        }
        Self::undecided(format!("too few runs ({runs} of at least {FEWEST}): {}", self.reason))
    }

    /// Whether either of two holds.
    pub(crate) fn or(self, other: Self) -> Self {
        match self.verdict.cmp(&other.verdict) {
            Ordering::Less => self,
            Ordering::Greater => other,
            Ordering::Equal => Self {
                reason: format!("{}; {}", self.reason, other.reason),
                ..self
            },
        }
    }
}

/// A verdict, and the parts of the criterion that make it, each with its interval.
pub(crate) type Judged = (Verdict, Vec<String>);

/// The verdict of a criterion: its parts' worst.
pub(crate) fn of_parts(parts: Vec<Part>) -> Judged {
    let verdict = parts
        .iter()
        .map(|part| part.verdict)
        .max()
        .unwrap_or(Verdict::Undecided);
    let decisive = parts.into_iter().filter(|part| part.verdict == verdict);
    (verdict, decisive.map(|part| part.reason).collect())
}

/// The first reason, and how many others there are, for a line on a terminal.
pub(crate) fn brief(reasons: &[String]) -> String {
    match reasons {
        [] => String::new(),
        [reason] => reason.clone(),
        [reason, others @ ..] => format!("{reason}; {} more", others.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn above(sample: &[f64]) -> (Verdict, String) {
        let Part { verdict, reason } = Part::above("x", &[(1.0, sample)], 0.0);
        (verdict, reason)
    }

    #[test]
    fn an_interval_decides_and_not_a_sign() {
        assert_eq!(above(&[4.0, 5.0, 6.0, 4.0, 6.0]).0, Verdict::Holds);
        let (verdict, reason) = above(&[-4.0, -5.0, -6.0, -4.0, -6.0]);
        assert_eq!((verdict, &*reason), (Verdict::Opposed, "x: -6.24 to -3.76, below 0"));
        let (verdict, reason) = above(&[4.0, 5.0, 6.0, -4.0, 6.0]);
        assert_eq!(
            (verdict, &*reason),
            (Verdict::Undecided, "x: the 95 % interval -1.84 to 8.64 spans 0")
        );
        let (verdict, reason) = above(&[198.0, 198.0 - 2.0 * 56.5]);
        assert_eq!(verdict, Verdict::Undecided);
        assert!(
            reason.starts_with("too few runs (2 of at least 5): x: the 95 % interval -576 to 859 spans 0"),
            "{reason}"
        );
        assert_eq!(
            above(&[1.0]),
            (
                Verdict::Undecided,
                "too few runs (1 of at least 5): x: has no interval".into()
            )
        );
        assert_eq!(
            above(&[]),
            (
                Verdict::Undecided,
                "too few runs (0 of at least 5): x: has no interval".into()
            )
        );
        // Four runs decide nothing, even clear ones.
        let (verdict, reason) = above(&[5.0, 5.1, 5.0, 5.1]);
        assert_eq!(
            (verdict, &*reason),
            (Verdict::Undecided, "too few runs (4 of at least 5): x: 4.96 to 5.14")
        );
        assert_eq!(
            above(&[1.0, f64::NAN]),
            (Verdict::Undecided, "x: is no number in some runs".into())
        );
    }

    #[test]
    fn ranges_have_two_sides() {
        let within = |low: f64, high: f64| Part::of_interval("x", Interval { low, high }, [0.9, 1.1], 20);
        assert_eq!(within(0.95, 1.05).verdict, Verdict::Holds);
        assert_eq!(within(0.8, 1.05).reason, "x: the 95 % interval 0.8 to 1.05 spans 0.9");
        assert_eq!(within(0.95, 1.2).reason, "x: the 95 % interval 0.95 to 1.2 spans 1.1");
        assert_eq!(within(0.5, 0.6).reason, "x: 0.5 to 0.6, below 0.9");
        assert_eq!(within(1.5, 1.6).reason, "x: 1.5 to 1.6, above 1.1");
    }

    #[test]
    fn the_worst_part_counts_and_the_better_of_two_ways() {
        let part = |verdict: Verdict| Part {
            verdict,
            reason: verdict.word().into(),
        };
        let [holds, undecided, opposed] = [Verdict::Holds, Verdict::Undecided, Verdict::Opposed].map(part);
        let of = |parts: &[&Part]| of_parts(parts.iter().map(|part| (*part).clone()).collect());
        let twice = vec!["holds".to_owned(); 2];
        assert_eq!(of(&[&holds, &holds]), (Verdict::Holds, twice));
        let twice = vec!["undecided".to_owned(); 2];
        assert_eq!(of(&[&undecided, &holds, &undecided]), (Verdict::Undecided, twice));
        assert_eq!(
            of(&[&undecided, &opposed]),
            (Verdict::Opposed, vec!["opposed".to_owned()])
        );
        assert_eq!(of(&[]).0, Verdict::Undecided);
        for (one, other, expected) in [
            (&holds, &opposed, Verdict::Holds),
            (&holds, &undecided, Verdict::Holds),
            (&undecided, &opposed, Verdict::Undecided),
            (&undecided, &undecided, Verdict::Undecided),
            (&opposed, &opposed, Verdict::Opposed),
        ] {
            assert_eq!(one.clone().or(other.clone()).verdict, expected);
            assert_eq!(other.clone().or(one.clone()).verdict, expected);
        }
        assert_eq!(opposed.clone().or(opposed).reason, "opposed; opposed");
    }
}
