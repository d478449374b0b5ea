//! What the second editions of the studies share: contrasts with intervals, tests corrected over families, outcomes, and whether
//! these survive other criteria.

use oneiro_base::contents::Column;
use oneiro_report::csv::{Csv, number};
use oneiro_report::numbers::significant;
use oneiro_statistics::{Undefined, holm, t_tails, t_within};

use crate::verdict::{Part, Verdict, of_parts};

/// Level of each family's tests, and of intervals.
const LEVEL: f64 = 0.05;
/// A level next to it.
const STRICT_LEVEL: f64 = 0.01;

/// A row's numbers of a sweep's table, each by the name of its column.
macro_rules! figures {
    ($(#[$words:meta])* $name:ident { $($field:ident: $column:literal,)+ }) => {
        $(#[$words])*
        #[derive(Clone, Copy, Debug)]
        pub(super) struct $name {
            $(pub(super) $field: f64,)+
        }

        impl $name {
            fn read(mut number: impl FnMut(&str) -> Result<f64>) -> Result<Self> {
                Ok(Self { $($field: number($column)?,)+ })
            }
        }
    };
}
pub(super) use figures;

/// A figure, computed from runs by `of`, whose mean should be above 0 or, if there is a margin, equivalent to 0 within it.
pub(super) struct Contrast<F: 'static> {
    pub(super) name: &'static str,
    pub(super) claims: &'static [&'static str],
    pub(super) margin: Option<f64>,
    pub(super) of: F,
}

pub(super) const fn above<F>(name: &'static str, claims: &'static [&'static str], of: F) -> Contrast<F> {
    Contrast {
        name,
        claims,
        margin: None,
        of,
    }
}

pub(super) const fn equivalent<F>(
    name: &'static str,
    claims: &'static [&'static str],
    margin: f64,
    of: F,
) -> Contrast<F> {
    Contrast {
        name,
        claims,
        margin: Some(margin),
        of,
    }
}

/// A contrast's estimate, with its interval, and its test: of a mean above 0 or, with a margin, of one equivalent to 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Estimate {
    value: f64,
    low: f64,
    high: f64,
    p: f64,
    margin: Option<f64>,
}

impl Estimate {
    /// The estimate of a mean with its standard error and degrees of freedom. One that is not a number shows nothing.
    pub(super) fn new(value: f64, error: f64, df: f64, margin: Option<f64>) -> Self {
        if !(value.is_finite() && error.is_finite()) {
            return Self {
                value: f64::NAN,
                low: f64::NAN,
                high: f64::NAN,
                p: 1.0,
                margin,
            };
        }
        let reach = t_within(1.0 - LEVEL, df) * error;
        // The probability of a mean as far above a bound.
        let above = |bound: f64| {
            let distance = value - bound;
            if error == 0.0 {
                return if distance > 0.0 { 0.0 } else { 1.0 };
            }
            let tails = t_tails(distance / error, df).value / 2.0;
            if distance > 0.0 { tails } else { 1.0 - tails }
        };
        let p = match margin {
            Some(margin) => above(-margin).max(1.0 - above(margin)),
            None if error == 0.0 => f64::from(u8::from(value == 0.0)),
            None => t_tails(value / error, df).value,
        };
        Self {
            value,
            low: value - reach,
            high: value + reach,
            p: p.min(1.0),
            margin,
        }
    }

    /// The outcome by a p, corrected or not.
    fn outcome(&self, p: f64, level: f64) -> Verdict {
        let is_opposed = match self.margin {
            Some(margin) => self.low > margin || self.high < -margin,
            None => p < level && self.value < 0.0,
        };
        match (is_opposed, p < level) {
            (true, _) => Verdict::Opposed,
            (false, true) => Verdict::Holds,
            (false, false) => Verdict::Undecided,
        }
    }
}

/// A judged contrast.
#[derive(Clone, Copy, Debug)]
pub(super) struct Judged {
    estimate: Estimate,
    p_holm: f64,
    pub(super) outcome: Verdict,
}

/// Judges a family.
pub(super) fn family(estimates: Vec<Estimate>) -> Result<Vec<Judged>, Undefined> {
    let p: Vec<f64> = estimates.iter().map(|estimate| estimate.p).collect();
    let judged = estimates.into_iter().zip(holm(&p)?);
    Ok(judged
        .map(|(estimate, p_holm)| Judged {
            estimate,
            p_holm,
            outcome: estimate.outcome(p_holm, LEVEL),
        })
        .collect())
}

impl Judged {
    /// The estimate, and both ends of its interval.
    #[cfg(test)]
    pub(super) fn figures(&self) -> [f64; 3] {
        [self.estimate.value, self.estimate.low, self.estimate.high]
    }

    /// The contrast as a part of a claim.
    fn part(&self, name: &str) -> Part {
        let Estimate { value, low, high, .. } = self.estimate;
        if value.is_nan() {
            return Part::undecided(format!("{name}: too few runs for an interval"));
        }
        let [low, high] = [low, high].map(|end| significant(end, 3));
        let p = significant(self.p_holm, 2);
        Part {
            verdict: self.outcome,
            reason: format!("{name}: {low} to {high}, p = {p} after Holm's correction"),
        }
    }
}

/// The worst outcome of a claim's contrasts, from those of a family, and the contrasts that have it.
pub(super) fn of_claim<F>(claim: &str, judged: &[Judged], contrasts: &[Contrast<F>]) -> (Verdict, Vec<String>) {
    let pairs = judged
        .iter()
        .zip(contrasts)
        .filter(|(_, contrast)| contrast.claims.contains(&claim));
    of_parts(pairs.map(|(judged, contrast)| judged.part(contrast.name)).collect())
}

/// The last columns of the table of claims.
pub(super) static CLAIM: [Column; 3] = [
    Column::text("claim", "the claim of the paper"),
    Column::text(
        "outcome",
        "`holds` if all of its contrasts hold, `opposed` if one is opposed, else `undecided`",
    ),
    Column::text(
        "reason",
        "the contrasts that decide it, each with its 95 % interval and its p",
    ),
];

/// A contrast's columns: its estimate, and its outcomes by the registered and by other criteria.
pub(super) fn estimate_columns(unit: &'static str) -> [Column; 6] {
    [
        Column::number("estimate", "", unit),
        Column::number("low", "", "the lower end of its 95 % interval"),
        Column::number("high", "", "the upper end"),
        Column::number("p", "", "the probability by its test"),
        Column::number("p_holm", "", "the same, after Holm's correction over the family"),
        Column::text("outcome", "`holds`, `opposed` or `undecided`"),
    ]
}

pub(super) fn other_criteria_columns() -> [Column; 3] {
    [
        Column::text("uncorrected", "the outcome without a correction over the family"),
        Column::text("level_0.01", "the outcome at the level 0.01 instead of 0.05"),
        Column::text(
            "one_family",
            "the outcome if all contrasts that are judged together are one family",
        ),
    ]
}

/// A row of the table of contrasts.
pub(super) struct Row {
    /// Columns before the estimate.
    pub(super) words: Vec<String>,
    pub(super) judged: Judged,
    /// Columns between the outcome and the outcomes by other criteria.
    pub(super) firmness: Vec<String>,
    /// Whether the outcome survives what the registration names, without other criteria.
    pub(super) survives: bool,
    /// Whether the registration also names other criteria.
    pub(super) is_by_criteria: bool,
}

/// The table of all contrasts, with the outcomes that need all of them.
pub(super) fn table(columns: &[Column], rows: &[Row]) -> Result<String, Undefined> {
    let p: Vec<f64> = rows.iter().map(|row| row.judged.estimate.p).collect();
    let mut table = Csv::new(columns);
    for (row, one_family) in rows.iter().zip(holm(&p)?) {
        let Judged {
            estimate,
            p_holm,
            outcome,
        } = row.judged;
        let Estimate {
            value, low, high, p, ..
        } = estimate;
        let others = [
            estimate.outcome(p, LEVEL),
            estimate.outcome(p_holm, STRICT_LEVEL),
            estimate.outcome(one_family, LEVEL),
        ];
        let survives = row.survives && (!row.is_by_criteria || others.iter().all(|other| *other == outcome));
        let cells = row.words.iter().cloned();
        let cells = cells
            .chain([value, low, high, p, p_holm].map(number))
            .chain([outcome.word().to_owned()])
            .chain(row.firmness.iter().cloned())
            .chain(others.map(|other| other.word().to_owned()))
            .chain([if survives { "yes" } else { "no" }.to_owned()]);
        table.row(cells);
    }
    Ok(table.text())
}
