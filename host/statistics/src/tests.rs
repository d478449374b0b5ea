//! The figures of `tests/statistics/cases.json`, which `make_cases.py` in the same folder made with `SciPy`, mpmath and
//! statsmodels. All agree to a relative 1e-9, except the mixed models that statsmodels fits: these agree to 1e-8, the
//! precision of its optimiser where the likelihood is flat.

use std::collections::BTreeMap;

use rand::Rng;
use rand_pcg::Pcg64;
use serde_json::Value;

use super::effects::{cliffs_delta, roc_area, vargha_delaney};
use super::mixed::RandomIntercept;
use super::parametric::{Anova, StudentT, one_sample_t};
use super::ranks::{KruskalWallis, MannWhitney, Method, kendall, kruskal_wallis, mann_whitney};
use super::special::{Probability, chi_squared_tail, f_tail, normal_tails, t_tails};
use super::*;

const CASES: &str = include_str!("../../../tests/statistics/cases.json");

/// Whether a figure is the expected one, to a relative tolerance. Logarithms of probabilities near 1, and statistics of
/// samples alike, are near 0: there the tolerance is that of 0.001.
fn agrees(name: &str, found: f64, expected: f64, tolerance: f64) -> bool {
    let is_near_zero = matches!(name, "ln_p" | "t" | "f" | "h" | "cohens_d");
    let scale = if is_near_zero {
        expected.abs().max(1e-3)
    } else {
        expected.abs()
    };
    found == expected || (found - expected).abs() <= tolerance * scale
}

type Figures = BTreeMap<&'static str, Vec<f64>>;

fn figures<const N: usize>(figures: [(&'static str, f64); N]) -> Figures {
    figures.map(|(name, value)| (name, vec![value])).into()
}

fn tail(p: Probability) -> [(&'static str, Vec<f64>); 2] {
    [("p", vec![p.value]), ("ln_p", vec![p.ln])]
}

fn with_tail<const N: usize>(others: [(&'static str, f64); N], p: Probability) -> Figures {
    let mut all = figures(others);
    all.extend(tail(p));
    all
}

/// The module's figures for a case.
fn computed(figure: &str, samples: &[&[f64]], parameters: &Value) -> Result<Figures> {
    let number = |name: &str| parameters[name].as_f64().expect("a number");
    let numbers = |name: &str| numbers(&parameters[name]);
    let method = || {
        if parameters["exact"] == true {
            Method::Exact
        } else {
            Method::Asymptotic
        }
    };
    let of_t = |test: StudentT| with_tail([("t", test.t), ("df", test.df)], test.p);
    Ok(match (figure, samples) {
        ("student_t", [a, b]) => of_t(student_t(a, b)?),
        ("paired_t", [a, b]) => of_t(paired_t(a, b)?),
        ("one_sample_t", [sample]) => of_t(one_sample_t(sample, number("mean"))?),
        ("anova", groups) => {
            let Anova {
                f,
                df_between,
                df_within,
                p,
            } = anova(groups)?;
            with_tail([("f", f), ("df_between", df_between), ("df_within", df_within)], p)
        }
        ("mann_whitney", [a, b]) => {
            let MannWhitney { u, p } = mann_whitney(a, b, method())?;
            with_tail([("u", u)], p)
        }
        ("kruskal_wallis", groups) => {
            let KruskalWallis { h, df, p } = kruskal_wallis(groups)?;
            with_tail([("h", h), ("df", df)], p)
        }
        ("effects", [a, b]) => effects(a, b)?,
        ("summary", [sample]) => {
            let mut all = figures([
                ("mean", mean(*sample)),
                ("variance", variance(sample)),
                ("median", median(sample)),
            ]);
            all.insert(
                "quantiles",
                numbers("shares").iter().map(|&share| quantile(sample, share)).collect(),
            );
            all
        }
        ("holm", []) => [("adjusted", holm(&numbers("p"))?)].into(),
        ("f_tail", []) => tail(f_tail(number("f"), number("between"), number("within"))).into(),
        ("t_tails", []) => tail(t_tails(number("t"), number("df"))).into(),
        ("normal_tails", []) => tail(normal_tails(number("z"))).into(),
        ("chi_squared_tail", []) => tail(chi_squared_tail(number("x"), number("df"))).into(),
        ("bootstrap", samples) => {
            let statistic = |s: &[Vec<f64>]| mean(&s[0]) - s.get(1).map_or(0.0, |second| median(second));
            let mut random = Pcg64::new(number("state") as u128, number("stream") as u128);
            let Interval { low, high } = bootstrap_interval(
                samples,
                statistic,
                number("level"),
                number("resamples") as usize,
                &mut random,
            )?;
            figures([("low", low), ("high", high)])
        }
        ("random_intercept", [x, y, group]) => model(&random_intercept(x, y, &labels(group))?),
        (figure, samples) => panic!("{figure} of {} samples", samples.len()),
    })
}

fn effects(a: &[f64], b: &[f64]) -> Result<Figures> {
    let mut all = figures([
        ("cohens_d", cohens_d(a, b)?),
        ("vargha_delaney", vargha_delaney(a, b)?),
        ("cliffs_delta", cliffs_delta(a, b)?),
    ]);
    let positive: Vec<bool> = (0..a.len() + b.len()).map(|index| index < a.len()).collect();
    all.insert("roc_area", vec![roc_area(&[a, b].concat(), &positive)?]);
    Ok(all)
}

fn model(fit: &RandomIntercept) -> Figures {
    let figures = [
        ("intercept", fit.intercept),
        ("slope", fit.slope),
        ("standard_error", fit.standard_error),
        ("z", fit.z),
        ("between_variance", fit.between_variance),
        ("within_variance", fit.within_variance),
    ];
    with_tail(figures, fit.p)
}

fn labels(group: &[f64]) -> Vec<usize> {
    group.iter().map(|&label| label as usize).collect()
}

/// A number, or a list of them.
fn numbers(value: &Value) -> Vec<f64> {
    let number = |value: &Value| value.as_f64().expect("a number");
    value
        .as_array()
        .map_or_else(|| vec![number(value)], |list| list.iter().map(number).collect())
}

#[test]
fn figures_are_those_of_scipy() {
    let file: Value = serde_json::from_str(CASES).expect("JSON");
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    let mut wrong = Vec::new();
    for case in file["cases"].as_array().expect("cases") {
        let figure = case["figure"].as_str().expect("a name");
        let names: Vec<&str> = case["samples"]
            .as_array()
            .expect("names")
            .iter()
            .filter_map(Value::as_str)
            .collect();
        let samples: Vec<Vec<f64>> = names.iter().map(|&name| numbers(&file["samples"][name])).collect();
        let samples: Vec<&[f64]> = samples.iter().map(Vec::as_slice).collect();
        let is_iterated = case["parameters"]["reference"] == "statsmodels";
        let tolerance = if is_iterated { 1e-8 } else { 1e-9 };
        let found = computed(figure, &samples, &case["parameters"]).expect("figures");
        for (name, expected) in case["expected"].as_object().expect("figures") {
            let (expected, found) = (numbers(expected), &found[name.as_str()]);
            assert_eq!(expected.len(), found.len(), "{figure} of {names:?}: {name}");
            for (&expected, &found) in expected.iter().zip(found) {
                *counts.entry(figure).or_default() += 1;
                if !agrees(name, found, expected, tolerance) {
                    wrong.push(format!(
                        "{figure} of {names:?}, {}: {name} {found:e}, not {expected:e}",
                        case["parameters"]
                    ));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert_eq!(counts.len(), 15, "kinds of figures: {counts:?}");
    assert!(counts.values().all(|&count| count >= 6), "{counts:?}");
}

#[test]
fn comparison_tells_figures_apart() {
    assert!(agrees("p", 1e-200, 1.000_000_000_5e-200, 1e-9));
    assert!(!agrees("p", 1e-200, 1.000_000_002e-200, 1e-9));
    assert!(!agrees("p", 0.0, 1e-300, 1e-9));
    assert!(!agrees("ln_p", -2_000.0, -2_000.000_003, 1e-9));
    assert!(!agrees("ln_p", f64::NEG_INFINITY, -2000.0, 1e-9));
    assert!(!agrees("t", f64::NAN, 0.0, 1e-9));
}

/// A design with `per` values in each group, of which `of(group, index)` gives x and y.
fn design(groups: usize, per: usize, of: impl Fn(usize, usize) -> (f64, f64)) -> (Vec<f64>, Vec<f64>, Vec<usize>) {
    let places: Vec<(usize, usize)> = (0..groups * per).map(|place| (place / per, place % per)).collect();
    let (x, y) = places.iter().map(|&(group, index)| of(group, index)).unzip();
    (x, y, places.iter().map(|&(group, _)| group).collect())
}

/// Numbers of no pattern, -0.5 to 0.5.
fn scatter(n: usize) -> f64 {
    (n * n * 37 + n * 11) as f64 % 101.0 / 101.0 - 0.5
}

fn assert_agree<const N: usize>(pairs: [(f64, f64); N]) {
    for (place, (found, expected)) in pairs.into_iter().enumerate() {
        assert!(
            (found - expected).abs() <= 1e-12 * expected.abs(),
            "figure {place}: {found:e}, not {expected:e}"
        );
    }
}

/// Where x is the same within each group and groups are of one size, the slope's z is Student's t of the groups' means,
/// and the variances are those of the nested analysis of variance.
#[test]
fn balanced_treatment_of_groups_has_its_closed_form() {
    const PER: usize = 7;
    let effect = |group: usize| 3.0 * scatter(group + 5);
    let (x, y, group) = design(10, PER, |g, i| {
        ((g % 2) as f64, effect(g) + 1.3 * (g % 2) as f64 + scatter(g * PER + i))
    });
    let fit = random_intercept(&x, &y, &group).expect("a fit");
    let groups: Vec<&[f64]> = y.chunks(PER).collect();
    let means = |kind: usize| {
        groups
            .iter()
            .skip(kind)
            .step_by(2)
            .map(|group| mean(*group))
            .collect::<Vec<_>>()
    };
    let (control, treated) = (means(0), means(1));
    let test = student_t(&treated, &control).expect("a t");
    let within = groups.iter().map(|group| variance(group)).sum::<f64>() / groups.len() as f64;
    let of_means = f64::midpoint(variance(&control), variance(&treated));
    assert!(of_means > within / PER as f64, "groups differ");
    assert_agree([
        (fit.slope, mean(&treated) - mean(&control)),
        (fit.intercept, mean(&control)),
        (fit.z, test.t),
        (fit.within_variance, within),
        (fit.between_variance, of_means - within / PER as f64),
    ]);
}

/// Where every group has the same x, the slope is that of the deviations from the groups' means, and the variances are
/// those of the analysis of variance in two ways.
#[test]
fn balanced_treatment_within_groups_has_its_closed_form() {
    const PER: usize = 6;
    const GROUPS: usize = 5;
    let effect = |group: usize| 2.0 * scatter(group + 3);
    let (x, y, group) = design(GROUPS, PER, |g, i| {
        (i as f64, effect(g) - 0.2 * i as f64 + scatter(g * PER + i))
    });
    let fit = random_intercept(&x, &y, &group).expect("a fit");
    let means: Vec<f64> = y.chunks(PER).map(mean).collect();
    let dx = |place: usize| x[place] - (PER - 1) as f64 / 2.0;
    let dy = |place: usize| y[place] - means[place / PER];
    let places = || 0..x.len();
    let xx: f64 = places().map(|place| dx(place) * dx(place)).sum();
    let slope = places().map(|place| dx(place) * dy(place)).sum::<f64>() / xx;
    let squares: f64 = places()
        .map(|place| (dy(place) - slope * dx(place)) * (dy(place) - slope * dx(place)))
        .sum();
    let within = squares / (x.len() - GROUPS - 1) as f64;
    assert!(variance(&means) > within / PER as f64, "groups differ");
    assert_agree([
        (fit.slope, slope),
        (fit.standard_error, (within / xx).sqrt()),
        (fit.within_variance, within),
        (fit.between_variance, variance(&means) - within / PER as f64),
    ]);
    assert_eq!(fit.groups, GROUPS);
}

/// Groups' numbers and order are only names.
#[test]
fn groups_may_be_named_anything() {
    let (x, y, group) = design(6, 4, |g, i| (scatter(g + 7 * i), scatter(g) + scatter(g * 4 + i)));
    let other: Vec<usize> = group.iter().map(|&g| g * 31 + 2).collect();
    assert_eq!(random_intercept(&x, &y, &group), random_intercept(&x, &y, &other));
}

/// The maximum sample that the exact method takes: all of one above all of the other is one order of C(200, 100).
#[test]
fn exact_tail_of_the_greatest_samples() {
    let low: Vec<f64> = (0..100).map(f64::from).collect();
    let high: Vec<f64> = (100..200).map(f64::from).collect();
    let test = mann_whitney(&low, &high, Method::Exact).expect("a U");
    let orders: f64 = (1..=100).map(|k| f64::from(100 + k) / f64::from(k)).product();
    assert_agree([(test.p.value, 2.0 / orders)]);
    assert_eq!(test.u, 0.0);
}

#[test]
fn samples_without_a_figure_are_refused() {
    let [none, one, two, same]: [&[f64]; 4] = [&[], &[1.0], &[1.0, 2.0], &[3.0, 3.0]];
    let (nan, ties) = ([1.0, f64::NAN], [1.0, 2.0, 2.0]);
    let mut random = Pcg64::new(1, 1);
    let mut interval =
        |level, resamples| bootstrap_interval(&[two], |s| mean(&s[0]), level, resamples, &mut random).err();
    let refusals = [
        (
            student_t(one, two).err(),
            "Student's t test: sample 1 has 1 values; allowed: 2 or more",
        ),
        (
            student_t(two, &nan).err(),
            "Student's t test: sample 2 has a value that is NaN; allowed: finite numbers",
        ),
        (
            student_t(same, same).err(),
            "Student's t test: the values of each sample are equal",
        ),
        (paired_t(two, &[2.0, 3.0]).err(), "paired t test: all values are equal"),
        (
            paired_t(two, &ties).err(),
            "paired t test: samples of 2 and 3 values; allowed: pairs",
        ),
        (
            one_sample_t(two, f64::INFINITY).err(),
            "one-sample t test: sample 2 has a value that is inf",
        ),
        (
            anova(&[two]).err(),
            "analysis of variance: has 1 groups; allowed: 2 or more",
        ),
        (
            anova(&[one, one]).err(),
            "analysis of variance: every group has 1 value",
        ),
        (
            anova(&[same, one]).err(),
            "analysis of variance: the values of each group are equal",
        ),
        (
            anova(&[none, two]).err(),
            "analysis of variance: sample 1 has 0 values; allowed: 1 or more",
        ),
        (
            mann_whitney(same, same, Method::Asymptotic).err(),
            "Mann-Whitney U test: all values are equal",
        ),
        (
            mann_whitney(&ties, two, Method::Exact).err(),
            "Mann-Whitney U test: has ties",
        ),
        (
            mann_whitney(&scattered(101), &scattered(202)[101..], Method::Exact).err(),
            "Mann-Whitney U test: has 10201 pairs; allowed: 10000",
        ),
        (kruskal_wallis(&[two]).err(), "Kruskal-Wallis test: has 1 groups"),
        (
            kruskal_wallis(&[same, same]).err(),
            "Kruskal-Wallis test: all values are equal",
        ),
        (
            cohens_d(same, same).err(),
            "Cohen's d: the deviation that it is divided by is 0",
        ),
        (
            vargha_delaney(none, two).err(),
            "Vargha and Delaney's A: sample 1 has 0 values",
        ),
        (
            roc_area(two, &[true]).err(),
            "area under the ROC curve: has 1 labels of 2 scores",
        ),
        (
            roc_area(two, &[true; 2]).err(),
            "area under the ROC curve: sample 2 has 0 values",
        ),
        (
            holm(&[0.5, 1.5]).err(),
            "Holm's correction: a p value is 1.5; allowed: 0 to 1",
        ),
        (interval(1.0, 10), "bootstrap interval: its level is 1"),
        (interval(0.95, 0), "bootstrap interval: has 0 resamples"),
    ];
    for (refusal, expected) in refusals {
        let text = refusal.map_or_else(|| "no refusal".into(), |refusal| refusal.to_string());
        assert!(text.starts_with(expected), "{text}, not {expected}");
    }
}

#[test]
fn models_without_a_fit_are_refused() {
    let refused = |x: &[f64], y: &[f64], group: &[usize], expected: &str| {
        let text = random_intercept(x, y, group).expect_err("a refusal").to_string();
        assert!(
            text.starts_with(&format!("random-intercept model: {expected}")),
            "{text}, not {expected}"
        );
    };
    let (x, y) = ([0.0, 1.0, 0.0, 1.0], [0.3, 1.1, 2.0, 3.1]);
    assert!(random_intercept(&x, &y, &[0, 0, 1, 1]).is_ok());
    refused(&x, &y, &[0, 0, 1], "has 3 groups of 4 values");
    refused(&[2.0; 4], &y, &[0, 0, 1, 1], "all x are equal");
    refused(&x, &y, &[5; 4], "has 1 groups");
    refused(
        &[0.0, 0.0, 1.0, 1.0],
        &y,
        &[0, 0, 1, 1],
        "has 2 groups; allowed: 2 or more, 3 where x is the same within each",
    );
    refused(&x, &y, &[0, 1, 2, 3], "has 4 values in 4 groups");
    refused(
        &x,
        &[0.3, 1.3, 2.0, 3.0],
        &[0, 0, 1, 1],
        "each group's values lie on a line of one slope",
    );
}

/// Values all different, in no order, and none of them 0.
fn scattered(count: usize) -> Vec<f64> {
    (0..count).map(|n| (n * 577 % 1009) as f64 + 1.0).collect()
}

#[test]
fn figures_of_no_sample_are_not_numbers() {
    assert!(mean([0.0_f64; 0]).is_nan() && median(&[]).is_nan() && variance(&[1.0]).is_nan());
    assert!(quantile(&[1.0], 1.1).is_nan() && quantile(&[1.0], f64::NAN).is_nan());
}

/// Of 300 normal samples of 25, the 90 % intervals of about 90 % hold the true mean; the percentile's are known to be a
/// little narrow. Those of a mean that is five standard errors off do not.
#[test]
fn bootstrap_interval_holds_the_true_mean_as_often_as_it_says() {
    let mut random = Pcg64::new(7, 11);
    let mut normal = || {
        (0..12)
            .map(|_| (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64)
            .sum::<f64>()
            - 6.0
    };
    let samples: Vec<Vec<f64>> = (0..300).map(|_| (0..25).map(|_| normal()).collect()).collect();
    let held = |statistic: fn(&[Vec<f64>]) -> f64| {
        let mut random = Pcg64::new(13, 17);
        let holds = |sample: &&Vec<f64>| {
            let interval = bootstrap_interval(&[sample], statistic, 0.9, 200, &mut random).expect("an interval");
            (interval.low..=interval.high).contains(&0.0)
        };
        samples.iter().filter(holds).count()
    };
    let of_mean = held(|s| mean(&s[0]));
    assert!((250..=285).contains(&of_mean), "{of_mean} of 300");
    assert!(held(|s| mean(&s[0]) + 1.0) < 3);
}

/// Each of the ten pairs out of five comes about as often. Drawn numbers differ, and all are drawn if fewer are there
/// than asked for.
#[test]
fn each_subset_is_as_likely() {
    const DRAWS: usize = 10_000;
    let mut random = Pcg64::new(19, 23);
    let mut pairs = BTreeMap::new();
    for _ in 0..DRAWS {
        let mut drawn = subset(5, 2, &mut random);
        drawn.sort_unstable();
        assert!(drawn.len() == 2 && drawn[0] < drawn[1] && drawn[1] < 5, "{drawn:?}");
        *pairs.entry(drawn).or_insert(0_usize) += 1;
    }
    assert_eq!(pairs.len(), 10);
    for (pair, count) in pairs {
        // Five standard deviations of a count.
        assert!(count.abs_diff(DRAWS / 10) < 150, "{pair:?} {count} times");
    }
    let mut all = subset(4, 9, &mut random);
    all.sort_unstable();
    assert_eq!(all, [0, 1, 2, 3]);
    assert!(subset(0, 5, &mut random).is_empty());
}

/// Two fits by statsmodels' `MixedLM` and, where groups differ no more than their values, by its `OLS`.
#[test]
fn means_of_nested_values_are_those_of_the_mixed_model() {
    let groups = |size: usize, values: &[f64]| -> Vec<Vec<f64>> { values.chunks(size).map(<[f64]>::to_vec).collect() };
    let differing = [1.5, 2.0, 0.5, 4.0, 5.5, 3.0, 2.0, 1.0, 2.5, 7.0, 5.0, 6.5];
    let nested = nested_mean(&groups(3, &differing)).unwrap();
    assert!(
        (nested.mean - 3.375).abs() < 1e-12 && (nested.standard_error - 1.116_739_2).abs() < 1e-6,
        "{nested:?}"
    );
    assert_eq!(nested.df, 3.0);
    let alike = nested_mean(&groups(2, &[1.0, 5.0, 3.0, 2.0, 4.0, 3.5])).unwrap();
    assert!(
        (alike.mean - 37.0 / 12.0).abs() < 1e-12 && (alike.standard_error - 7.0 / 12.0).abs() < 1e-12,
        "{alike:?}"
    );
    assert_eq!(nested_mean(&groups(2, &[1.0; 4])).unwrap().standard_error, 0.0);
    for (refused, problem) in [
        (groups(3, &[1.0; 4]), "different sizes; allowed: groups of one size"),
        (groups(4, &[1.0; 4]), "has 1 groups; allowed: 2 or more"),
        (groups(2, &[1.0, f64::NAN, 1.0, 2.0]), "allowed: finite numbers"),
    ] {
        let found = nested_mean(&refused).unwrap_err().to_string();
        assert!(found.contains(problem), "{found}");
    }
}

/// The example with ties of `SciPy`'s documentation of `kendalltau`, and both ends.
#[test]
fn kendall_of_known_samples() {
    let tau = kendall(&[12.0, 2.0, 1.0, 12.0, 2.0], &[1.0, 4.0, 7.0, 1.0, 0.0]).expect("a tau");
    assert!((tau + 0.471_404_520_791_031_7).abs() < 1e-15, "{tau}");
    let rising = [1.0, 2.0, 3.0];
    assert_eq!(kendall(&rising, &[5.0, 6.0, 9.0]), Ok(1.0));
    assert_eq!(kendall(&rising, &[9.0, 6.0, 5.0]), Ok(-1.0));
    assert!(kendall(&rising, &[1.0; 3]).is_err() && kendall(&rising, &rising[..2]).is_err());
}

/// `SciPy` 1.17's `ttest_ind(equal_var=False).confidence_interval()`, and the same formula with its quantiles for three samples.
#[test]
fn contrasts_of_means_have_welchs_intervals() {
    let (a, b, c) = ([3.1, 4.2, 5.0, 4.4, 3.9], [2.0, 6.5, 4.1, 8.8], [1.0, 1.5, 0.2]);
    let close = |samples: &[(f64, &[f64])], low: f64, high: f64| {
        let found = contrast_interval(samples, 0.95).unwrap();
        assert!(
            (found.low - low).abs() < 1e-9 && (found.high - high).abs() < 1e-9,
            "{found:?}"
        );
    };
    close(&[(1.0, &a), (-1.0, &b)], -5.802_806_407_502_463, 3.342_806_407_502_464);
    close(
        &[(1.0, &a), (-0.5, &b), (-0.5, &c)],
        -1.186_805_658_093_243_3,
        3.176_805_658_093_244,
    );
    assert_eq!(contrast_interval(&[(1.0, &a)], 0.95), mean_interval(&a, 0.95));
    let equal = contrast_interval(&[(2.0, &[1.5, 1.5]), (1.0, &[1.0, 1.0])], 0.95).unwrap();
    assert_eq!((equal.low, equal.high), (4.0, 4.0));
    assert!(contrast_interval(&[(1.0, &a), (1.0, &[1.0])], 0.95).is_err());
    assert!(contrast_interval(&[], 0.95).is_err());
}

/// Values outside the interval on either side: `SciPy` 1.17's `binom.cdf` with a chance of one half.
#[test]
fn medians_have_intervals_between_values() {
    for (count, outside) in [(6, 1), (8, 1), (9, 2), (11, 2), (12, 3), (17, 5), (20, 6), (25, 8)] {
        let sample: Vec<f64> = (1..=count).rev().map(f64::from).collect();
        let Interval { low, high } = median_interval(&sample, 0.95).unwrap();
        assert_eq!(
            (low, high),
            (f64::from(outside), f64::from(count + 1 - outside)),
            "{count}"
        );
    }
    let few = median_interval(&[1.0, 2.0, 3.0, 4.0, 5.0], 0.95).unwrap_err();
    assert!(few.problem.contains("has 5 values; allowed: 6 or more"), "{few}");
    let many: Vec<f64> = (0..3000).map(f64::from).collect();
    let Interval { low, high } = median_interval(&many, 0.95).unwrap();
    assert!(
        (1440.0..1450.0).contains(&low) && (1549.0..1559.0).contains(&high),
        "{low} {high}"
    );
}

/// Of a mean they are the values themselves.
#[test]
fn pseudo_values_are_the_shares_of_the_units() {
    let sample = [1.0, 4.0, 2.0];
    let values = pseudo_values(3, |kept| mean(kept.iter().map(|&unit| sample[unit])));
    for (value, unit) in values.iter().zip(sample) {
        assert!((value - unit).abs() < 1e-12);
    }
    assert_eq!(pseudo_values(1, |kept| kept.len() as f64), [1.0]);
    assert!(pseudo_values(0, |_| f64::NAN).is_empty());
}
