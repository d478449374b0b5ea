//! Formatting of numbers, and means and spreads of several.

use oneiro_statistics as statistics;
use oneiro_statistics::quantile_of_sorted;

/// Mean of several values, and the range of their spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    pub low: f64,
    pub mean: f64,
    pub high: f64,
}

/// Number of runs from which a spread leaves the outer ones out.
const MANY: usize = 10;
/// Mark of a missing value.
pub const NONE: &str = "\u{2013}";

/// Formats a number with at most `digits` significant digits, without an exponent if that is short.
pub fn significant(x: f64, digits: usize) -> String {
    if !x.is_finite() {
        return x.to_string();
    }
    let rounded = format!("{x:.*e}", digits.max(1) - 1);
    let value: f64 = rounded.parse().unwrap_or(x);
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-4..1e9).contains(&value.abs()) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// Formats a number with fixed decimal places. Zero has no sign, even if a negative number rounds to it.
pub fn fixed(x: f64, places: usize) -> String {
    let text = format!("{x:.places$}");
    match text.strip_prefix('-') {
        Some(zero) if !zero.contains(|digit: char| digit != '0' && digit != '.') => zero.to_owned(),
        _ => text,
    }
}

/// The same number, with no sign if it is zero.
pub fn unsigned_zero(x: f64) -> f64 {
    x + 0.0
}

/// Rounds a number to six decimal places, as in tables.
pub fn to_six_places(number: f64) -> f64 {
    fixed(number, 6).parse().unwrap_or(number)
}

/// Significant digits of a number in a report's tables and figures: no report shows more than four. Tables as CSV have [six](super::csv).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Digits {
    /// Of effects, shares and deviations.
    Three = 3,
    /// Of what was measured.
    Four = 4,
}

/// Formats a number for readers, as HTML.
pub fn shown(x: f64, digits: Digits) -> String {
    let text = in_figure(x, digits);
    match text.split_once('e') {
        Some((mantissa, exponent)) => format!("{mantissa}\u{2009}\u{b7}\u{2009}10<sup>{exponent}</sup>"),
        None => text,
    }
}

/// Formats a number for readers, as the text of a figure.
pub fn in_figure(x: f64, digits: Digits) -> String {
    if x.is_nan() {
        return NONE.to_owned();
    }
    if x.is_infinite() {
        return if x > 0.0 { "\u{221e}" } else { "\u{2212}\u{221e}" }.to_owned();
    }
    significant(x, digits as usize).replace('-', "\u{2212}")
}

/// Formats a probability, as HTML.
pub fn probability(p: f64) -> String {
    if p == 0.0 {
        "&lt;\u{2009}10<sup>\u{2212}300</sup>".to_owned()
    } else {
        shown(p, Digits::Three)
    }
}

/// Formats a share in per cent, to a tenth.
pub fn percent(share: f64) -> String {
    if share.is_finite() {
        fixed(100.0 * share, 1)
    } else {
        NONE.to_owned()
    }
}

/// Formats a whole number with thousands separated.
pub fn count(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// Mean of several runs with their range, or with their middle half for ten runs or more.
pub fn spread(mut values: Vec<f64>) -> Spread {
    values.sort_by(f64::total_cmp);
    let mean = statistics::mean(&values);
    let outer = if values.len() < MANY { 0.0 } else { 0.25 };
    Spread {
        low: quantile_of_sorted(&values, outer),
        mean,
        high: quantile_of_sorted(&values, 1.0 - outer),
    }
}

/// Description of the [`spread`] of `runs` runs.
pub fn spread_words(runs: usize) -> &'static str {
    if runs < MANY {
        "shaded: from the lowest to the highest run"
    } else {
        "shaded: from the lower to the upper quartile of the runs"
    }
}

/// Spread of several rows entry by entry, as far as the longest reaches.
pub fn spreads<'a>(rows: impl Iterator<Item = &'a [f64]>) -> Vec<Spread> {
    let rows: Vec<&[f64]> = rows.collect();
    let length = rows.iter().map(|row| row.len()).max().unwrap_or(0);
    let at = |i: usize| rows.iter().filter_map(|row| row.get(i).copied()).collect();
    (0..length).map(|i| spread(at(i))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_no_more_digits_than_they_may() {
        assert_eq!(significant(123.456_789, 6), "123.457");
        assert_eq!(significant(1_234_567.0, 6), "1234570");
        assert_eq!(significant(-0.000_123_456_78, 6), "-0.000123457");
        assert_eq!(significant(1.5e-143, 6), "1.5e-143");
        assert_eq!(significant(0.1_f32.into(), 6), "0.1");
        assert_eq!(significant(9.999_999, 3), "10");
        assert_eq!(significant(0.0, 6), "0");
        assert_eq!(significant(f64::NAN, 6), "NaN");
    }

    #[test]
    fn zero_has_no_sign() {
        for (number, places, text) in [
            (-0.0, 1, "0.0"),
            (-0.04, 1, "0.0"),
            (-0.06, 1, "-0.1"),
            (-4e-7, 6, "0.000000"),
            (-0.4, 0, "0"),
            (2.5, 6, "2.500000"),
            (f64::NAN, 6, "NaN"),
            (f64::NEG_INFINITY, 6, "-inf"),
        ] {
            assert_eq!(fixed(number, places), text);
        }
        assert!(to_six_places(-1e-9).is_sign_positive() && unsigned_zero(-0.0).is_sign_positive());
        assert_eq!(significant(-0.0, 6), "0");
    }

    #[test]
    fn readers_see_powers_and_minus_signs() {
        use Digits::{Four, Three};
        assert_eq!(shown(-1.5, Three), "\u{2212}1.5");
        assert_eq!(
            shown(2.5e-12, Three),
            "2.5\u{2009}\u{b7}\u{2009}10<sup>\u{2212}12</sup>"
        );
        assert_eq!(in_figure(-2.5e-12, Three), "\u{2212}2.5e\u{2212}12");
        for text in [shown, in_figure] {
            assert_eq!(text(f64::NAN, Three), NONE);
            assert_eq!(text(f64::NEG_INFINITY, Three), "\u{2212}\u{221e}");
            // Not the title of 0.892 that says 0.9, nor a zero with a sign.
            assert_eq!(text(0.892, Three), "0.892");
            assert_eq!(text(19_142.37, Four), "19140");
            assert_eq!(text(-0.0, Four), "0");
        }
    }

    #[test]
    fn probabilities_beyond_all_bounds_are_shown() {
        assert_eq!(probability(0.012_345), "0.0123");
        assert!(probability(1.23e-143).ends_with("10<sup>\u{2212}143</sup>"));
        assert!(probability(0.0).starts_with("&lt;"));
    }

    #[test]
    fn whole_numbers_are_grouped() {
        assert_eq!(count(7), "7");
        assert_eq!(count(300_000), "300\u{202f}000");
        assert_eq!(count(1_234_567), "1\u{202f}234\u{202f}567");
    }

    #[test]
    fn a_spread_leaves_out_the_outer_runs_of_many() {
        let few = spread(vec![3.0, 1.0, 2.0]);
        assert_eq!((few.low, few.mean, few.high), (1.0, 2.0, 3.0));
        let many = spread((0..=12).rev().map(f64::from).collect());
        assert_eq!((many.low, many.mean, many.high), (3.0, 6.0, 9.0));
        assert!(spread(vec![]).mean.is_nan());
    }

    #[test]
    fn rows_may_differ_in_length() {
        let spreads = spreads([&[1.0, 2.0][..], &[3.0]].into_iter());
        assert_eq!(spreads.iter().map(|spread| spread.mean).collect::<Vec<_>>(), [2.0, 2.0]);
    }
}
