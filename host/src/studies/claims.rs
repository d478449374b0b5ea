//! The claims of the paper, and what the study says of each.

use std::fmt;

use serde::Serialize;

/// What the first effect of a claim is called that is judged in several combinations of settings alike.
pub(crate) const HOLDS_IN: &str = "combinations in which it holds";

/// How a claim came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Verdict {
    /// Its criterion holds.
    Reproduced,
    /// Its criterion fails.
    NotReproduced,
    /// Too few runs for its test, or its parts disagree.
    Undecided,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Reproduced => "reproduced",
            Self::NotReproduced => "not_reproduced",
            Self::Undecided => "undecided",
        })
    }
}

/// A figure that a verdict rests on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Effect {
    /// What it is, such as `d, no noise, noise as evolved`.
    pub(crate) name: String,
    /// Its value.
    pub(crate) value: f64,
    /// The paper's own value, where it prints one.
    pub(crate) paper: Option<f64>,
}

/// A test of significance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Test {
    /// What is compared, and how.
    pub(crate) name: String,
    /// `F`, `t`, `U` or `z`.
    pub(crate) statistic: String,
    /// Its value.
    pub(crate) value: f64,
    /// Degrees of freedom, where it has any.
    pub(crate) degrees_of_freedom: Vec<f64>,
    /// Probability of as much or more by chance.
    pub(crate) p: f64,
    /// p after Holm's correction, over the tests that the study's preregistration names together.
    pub(crate) p_holm: Option<f64>,
}

/// One claim and its verdict.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Claim {
    /// Such as `C1`.
    pub(crate) id: String,
    /// What the paper says.
    pub(crate) statement: String,
    /// When it counts as reproduced; fixed before anything was evolved.
    pub(crate) criterion: String,
    /// How it came out.
    pub(crate) verdict: Verdict,
    /// What the verdict rests on.
    pub(crate) effects: Vec<Effect>,
    /// Tests: the paper's, of individuals, and those of runs.
    pub(crate) tests: Vec<Test>,
    /// What a reader should know besides.
    pub(crate) remark: String,
}
