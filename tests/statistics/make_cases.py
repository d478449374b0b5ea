"""Makes cases.json: samples of many kinds, and what SciPy, statsmodels and mpmath say of them.

    pip install numpy scipy statsmodels pandas mpmath
    python make_cases.py > cases.json

Statistics are SciPy's. p values are too where SciPy has them; each is checked here against mpmath with 50 digits, which
also gives the logarithms, so that tails in which SciPy says 0 are covered. Mixed models are fitted by statsmodels, and
small ones also with dense matrices of 30 digits. The bootstrap is NumPy's, with its own PCG64.
"""

import json
import math
import sys
import warnings
from fractions import Fraction

import mpmath as mp
import numpy as np
import statsmodels.api
from scipy import stats
from statsmodels.stats.multitest import multipletests

mp.mp.dps = 50
random = np.random.default_rng(20240607)
samples, cases = {}, []


def sample(name, values):
    samples[name] = [float(f"{value:.6f}") for value in values]


def case(figure, names, expected, **parameters):
    assert all(name in samples for name in names), names
    cases.append({"figure": figure, "samples": names, "parameters": parameters, "expected": expected})


def of(*names):
    return [np.array(samples[name]) for name in names]


def probability(exact, scipy=None):
    """The p value and its logarithm, of a number of 50 digits; SciPy must agree where it doesn't underflow."""
    value = float(exact)
    if scipy is not None and value > 1e-300:
        assert abs(scipy - value) <= 1e-9 * value, (scipy, value)
        value = float(scipy)
    return {"p": value, "ln_p": float(mp.log(exact))}


def f_tail(f, between, within):
    f, between, within = mp.mpf(f), mp.mpf(between), mp.mpf(within)
    return mp.betainc(within / 2, between / 2, 0, within / (within + between * f), regularized=True)


def t_tails(t, df):
    return f_tail(mp.mpf(t) ** 2, 1, df)


def normal_tails(z):
    return mp.erfc(abs(mp.mpf(z)) / mp.sqrt(2))


def chi_squared_tail(x, df):
    return mp.gammainc(mp.mpf(df) / 2, mp.mpf(x) / 2, regularized=True)


# Samples.

for name, mean, deviation, count in [
    ("a500", 0.51, 0.08, 500), ("b500", 0.45, 0.08, 500), ("c500", 0.4502, 0.081, 500), ("far500", 3.7, 0.1, 500),
    ("very_far500", 900.0, 0.1, 500), ("wide120", 0.5, 0.4, 120), ("n31", 12.0, 3.0, 31), ("n30", 14.0, 6.0, 30),
    ("n17", 11.0, 3.0, 17), ("n9", 13.0, 3.0, 9), ("n7", 16.0, 3.0, 7), ("n3", 20.0, 3.0, 3), ("wide30", 12.0, 4.0, 30),
    ("seven", 14.0, 3.0, 7), ("all50", 9.0, 1.0, 50), ("below50", 0.0, 1.0, 50), ("n1", 0.0, 1.0, 1),
]:
    sample(name, random.normal(mean, deviation, count))
for name, high, count in [("ties40", 4, 40), ("ties25", 6, 25), ("ties300", 10, 300), ("ties25b", 5, 25)]:
    sample(name, random.integers(0, high, count))
sample("pair_low", [0.25, 1.0])
sample("pair_high", [3.5, 4.0])
sample("single", [13.25])
sample("equal_mean_a", [1, 2, 3, 4, 5, 6])
sample("equal_mean_b", [2, 3, 4, 5])
sample("constant3", [0.2, 0.2, 0.2])
sample("skewed200", random.exponential(2.0, 200))
sample("line200", np.array(samples["skewed200"]) * 0.4 + random.normal(0, 1, 200))
sample("near_line200", np.array(samples["skewed200"]) * -2.0 + random.normal(0, 0.3, 200))
sample("zeros30", np.where(np.arange(30) % 5, random.normal(12, 4, 30), samples["n30"]))
sample("shifted500", np.array(samples["a500"]) + random.normal(0.09, 0.05, 500))
sample("negative_zero", [-0.0, 0.0, 1.0, -1.0, 2.0])
sample("other5", [0.0, 1.0, 0.0, 1.0, 2.5])
sample("other3", [1.0, 2.0, 4.0])

# Tests of means.

pairs = [
    ("a500", "b500"), ("b500", "c500"), ("b500", "far500"), ("a500", "very_far500"), ("wide120", "a500"),
    ("n31", "n30"), ("n17", "n9"), ("n7", "n3"), ("pair_low", "pair_high"), ("n3", "pair_low"),
    ("equal_mean_a", "equal_mean_b"), ("ties40", "ties25"), ("constant3", "n7"),
]
for names in pairs:
    a, b = of(*names)
    result = stats.ttest_ind(a, b)
    tail = probability(t_tails(result.statistic, result.df), result.pvalue)
    case("student_t", names, {"t": result.statistic, "df": float(result.df), **tail})

for names in [
    ("a500", "shifted500"), ("b500", "c500"), ("n30", "zeros30"), ("ties25", "ties25b"), ("pair_low", "pair_high"),
    ("a500", "far500"), ("skewed200", "line200"),
]:
    result = stats.ttest_rel(*of(*names))
    tail = probability(t_tails(result.statistic, result.df), result.pvalue)
    case("paired_t", names, {"t": result.statistic, "df": float(result.df), **tail})

for name, mean in [
    ("a500", 0.5), ("a500", 0.0), ("n3", 18.0), ("pair_low", 0.0), ("equal_mean_a", 3.5), ("very_far500", 0.0),
]:
    result = stats.ttest_1samp(*of(name), mean)
    tail = probability(t_tails(result.statistic, result.df), result.pvalue)
    case("one_sample_t", [name], {"t": result.statistic, "df": float(result.df), **tail}, mean=mean)

group_sets = [
    ("a500", "b500"), ("b500", "c500"), ("a500", "b500", "far500"), ("a500", "very_far500"),
    ("n31", "n30", "n17", "n9", "n7", "n3"), ("n9", "single", "n7"), ("ties40", "ties25", "ties300"),
    ("equal_mean_a", "equal_mean_b"), ("pair_low", "pair_high"), ("wide120", "a500", "c500"), ("constant3", "n7"),
]
for names in group_sets:
    groups = of(*names)
    result = stats.f_oneway(*groups)
    df_between, df_within = len(groups) - 1, sum(map(len, groups)) - len(groups)
    exact = [[Fraction(value) for value in group] for group in groups]
    means = [sum(group) / len(group) for group in exact]
    grand = sum(map(sum, exact)) / sum(map(len, exact))
    between = sum(len(group) * (mean - grand) ** 2 for group, mean in zip(exact, means))
    within = sum((value - mean) ** 2 for group, mean in zip(exact, means) for value in group)
    f = between / df_between / (within / df_within)
    # SciPy subtracts sums of squares, which costs it digits where groups are very far apart.
    assert math.isclose(result.statistic, f, rel_tol=1e-7, abs_tol=1e-12)
    f = mp.mpf(f.numerator) / f.denominator
    tail = probability(f_tail(f, df_between, df_within), result.pvalue)
    case("anova", names, {"f": float(f), "df_between": df_between, "df_within": df_within, **tail})

# Tests of ranks.

for names in pairs + [("n9", "single"), ("ties300", "ties40"), ("skewed200", "line200"), ("negative_zero", "pair_low")]:
    a, b = of(*names)
    result = stats.mannwhitneyu(a, b, method="asymptotic")
    m, n = len(a), len(b)
    ties = sum(int(count) ** 3 - int(count) for count in np.unique(np.concatenate([a, b]), return_counts=True)[1])
    variance = Fraction(m * n, 12) * (m + n + 1 - Fraction(ties, (m + n) * (m + n - 1)))
    greater = max(Fraction(result.statistic), m * n - Fraction(result.statistic))
    excess = max(greater - Fraction(m * n + 1, 2), Fraction(0))
    z = mp.mpf(excess.numerator) / excess.denominator / mp.sqrt(mp.mpf(variance.numerator) / variance.denominator)
    case("mann_whitney", names, {"u": result.statistic, **probability(normal_tails(z), result.pvalue)}, exact=False)
    if ties == 0 and m * n <= 1000:
        result = stats.mannwhitneyu(a, b, method="exact")
        case("mann_whitney", names, {"u": result.statistic, **probability(result.pvalue)}, exact=True)

for names in group_sets:
    result = stats.kruskal(*of(*names))
    df = len(names) - 1
    case("kruskal_wallis", names, {
        "h": result.statistic, "df": df, **probability(chi_squared_tail(result.statistic, df), result.pvalue),
    })

# Sizes of effects.

for names in pairs + [("ties300", "ties40"), ("far500", "b500")]:
    a, b = of(*names)
    m, n = len(a), len(b)
    difference = a.mean() - b.mean()
    pooled = ((m - 1) * a.var(ddof=1) + (n - 1) * b.var(ddof=1)) / (m + n - 2)
    expected = {"cohens_d": difference / math.sqrt(pooled)}
    above, below = int(np.sum(a[:, None] > b)), int(np.sum(a[:, None] < b))
    expected["vargha_delaney"] = (above + (m * n - above - below) / 2) / (m * n)
    expected["cliffs_delta"] = (above - below) / (m * n)
    # The area by trapezia, under the curve itself.
    thresholds = np.unique(np.concatenate([a, b]))[::-1]
    hits = [0.0] + [np.mean(a >= threshold) for threshold in thresholds]
    alarms = [0.0] + [np.mean(b >= threshold) for threshold in thresholds]
    expected["roc_area"] = float(np.trapezoid(hits, alarms))
    case("effects", names, expected)

# Figures of one sample.

for name in ["a500", "n31", "n30", "ties40", "pair_low", "n3", "skewed200"]:
    values, = of(name)
    shares = [0.0, 0.025, 0.1, 0.25, 0.5, 0.75, 0.9, 0.975, 1.0]
    case("summary", [name], {
        "mean": values.mean(), "variance": values.var(ddof=1), "median": np.median(values),
        "quantiles": list(np.quantile(values, shares)),
    }, shares=shares)

# Holm's correction.

for p in [[0.01, 0.04, 0.03, 0.005], [0.5, 0.5, 0.5], [1e-120, 1.0, 0.2, 0.0, 0.049, 0.0004, 0.2], [0.03]]:
    case("holm", [], {"adjusted": list(multipletests(p, method="holm")[1])}, p=p)

# Tails.

for f, between, within in [
    (164.14, 1, 998), (549.79, 1, 998), (0.74, 1, 998), (6.66, 1, 998), (1e-20, 1, 998), (0.0, 1, 998), (1.0, 1, 1),
    (1.0, 7, 7), (2.5, 9, 4990), (1e5, 1, 998), (1e12, 3, 2000), (1e3, 4, 99_995), (1.001, 1, 99_998), (0.99, 40, 9),
    (3e4, 1, 1), (1.1, 5000, 5000), (5000, 20, 41.7),
]:
    scipy = stats.f.sf(f, between, within)
    tail = probability(f_tail(f, between, within), scipy)
    case("f_tail", [], tail, f=f, between=between, within=within)
for t, df in [(0.0, 5), (1e-9, 5), (-2.5, 1), (2.5, 4.31), (40, 9.5), (-38.7, 998), (1000, 998), (1e8, 3), (6, 99_998)]:
    case("t_tails", [], probability(t_tails(t, df), 2 * stats.t.sf(abs(t), df)), t=t, df=df)
for z in [0.0, 1e-8, -0.3, 1.0, 1.7, 1.8, -5, 12, 21.3, 37, 38.5, 100, -1e4]:
    case("normal_tails", [], probability(normal_tails(z), 2 * stats.norm.sf(abs(z))), z=z)
for x, df in [
    (0.0, 3), (1e-12, 1), (0.7, 1), (3.5, 2), (2.99, 1), (3.01, 1), (50, 5), (998, 4), (1400, 1), (1e4, 30), (95, 100),
    (900, 500),
]:
    case("chi_squared_tail", [], probability(chi_squared_tail(x, df), stats.chi2.sf(x, df)), x=x, df=df)

# The bootstrap: rand_pcg's Pcg64 is NumPy's PCG64.


def generator(state, stream):
    """The generator that rand_pcg makes of a state and a stream."""
    modulus, multiplier = 1 << 128, 0x2360ED051FC65DA44385DF649FCCF645
    increment = (stream << 1 | 1) % modulus
    bits = np.random.PCG64()
    bits.state = {
        "bit_generator": "PCG64", "has_uint32": 0, "uinteger": 0,
        "state": {"state": ((state + increment) * multiplier + increment) % modulus, "inc": increment},
    }
    return bits


for names, level in [(("skewed200",), 0.95), (("n31", "n30"), 0.9), (("n3",), 0.99)]:
    bits, statistics = generator(42, 54), []
    for _ in range(400):
        resampled = [[s[int(bits.random_raw()) * len(s) >> 64] for _ in s] for s in of(*names)]
        statistics.append(np.mean(resampled[0]) - (np.median(resampled[1]) if len(names) == 2 else 0))
    low, high = np.quantile(statistics, [(1 - level) / 2, 1 - (1 - level) / 2])
    case("bootstrap", names, {"low": low, "high": high}, level=level, resamples=400, state=42, stream=54)

# Mixed models.


def dense(x, y, group, start):
    """The fit by the textbook's matrices, 30 digits, from a first guess of the ratio of variances."""
    with mp.workdps(30):
        count = len(x)
        design = mp.matrix([[1, mp.mpf(float(value))] for value in x])
        values = mp.matrix([mp.mpf(float(value)) for value in y])

        def solve(ratio):
            covariance = mp.matrix(count, count)
            for i in range(count):
                for j in range(count):
                    covariance[i, j] = (i == j) + (ratio if group[i] == group[j] else 0)
            inverse = covariance ** -1
            information = design.T * inverse * design
            estimate = information ** -1 * (design.T * inverse * values)
            residuals = values - design * estimate
            square = (residuals.T * inverse * residuals)[0]
            deviance = (count - 2) * mp.log(square) + mp.log(mp.det(covariance)) + mp.log(mp.det(information))
            return deviance, estimate, information, square / (count - 2)

        def slope(logarithm, step=mp.mpf("1e-8")):
            up, down = solve(mp.exp(logarithm + step))[0], solve(mp.exp(logarithm - step))[0]
            return (up - down) / (2 * step)

        at = mp.log(mp.mpf(start))
        ratio = mp.exp(mp.findroot(slope, (at - mp.mpf("0.01"), at + mp.mpf("0.01")), solver="secant", tol=1e-24))
        assert 1e-3 < ratio < 1e9, ratio
        _, estimate, information, within = solve(ratio)
        error = mp.sqrt((information ** -1)[1, 1] * within)
        z = estimate[1] / error
        return {
            "intercept": float(estimate[0]), "slope": float(estimate[1]), "standard_error": float(error), "z": float(z),
            **probability(normal_tails(z)), "between_variance": float(ratio * within), "within_variance": float(within),
        }


def statsmodels_fit(x, y, group):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = statsmodels.api.MixedLM(y, statsmodels.api.add_constant(x), groups=group)
        fit = model.fit(reml=True, method=["bfgs"], gtol=1e-10)
    # Its own standard errors take in what isn't known of the variances, by the Hessian of all parameters; the block of
    # the two coefficients gives those of the textbook.
    information = -model.hessian(fit.params_object)[0][:2, :2]
    error = math.sqrt(np.linalg.inv(information)[1, 1])
    assert fit.converged
    return {
        "intercept": fit.fe_params[0], "slope": fit.fe_params[1], "standard_error": error,
        "z": fit.fe_params[1] / error, "between_variance": float(np.asarray(fit.cov_re)[0, 0]),
        "within_variance": float(fit.scale),
    }


def mixed(name, sizes, slope, between, within, make_x, exact):
    group = np.repeat(np.arange(len(sizes)), sizes)
    x = make_x(group)
    y = 1.5 + slope * x + random.normal(0, between, len(sizes))[group] + random.normal(0, within, len(group))
    names = [f"{name}_{part}" for part in ["x", "y", "group"]]
    for part, values in zip(names, [x, y, group]):
        sample(part, values)
    x, y, _ = of(*names)
    fit = statsmodels_fit(x, y, group)
    case("random_intercept", names, fit, reference="statsmodels")
    if exact:
        expected = dense(x, y, group, fit["between_variance"] / fit["within_variance"])
        case("random_intercept", names, expected, reference="dense")


def uniform(group):
    return random.uniform(-1, 3, len(group))


def by_group(group):
    return (group % 2).astype(float)


mixed("unbalanced", [2, 5, 3, 1, 8, 4], 0.7, 1.0, 0.5, uniform, True)
mixed("treated", [3, 4, 2, 5, 1, 4, 3], 1.2, 0.8, 0.6, by_group, True)
mixed("strong_groups", [3, 3, 4, 6], -2.0, 30.0, 0.2, uniform, True)
mixed("weak_groups", [7, 4, 5, 6, 6, 5], 0.1, 1.0, 1.0, uniform, True)
mixed("runs", [100] * 5, 0.02, 0.2, 0.08, lambda group: np.tile(np.arange(100) % 2, 5).astype(float), False)
mixed("many_groups", list(random.integers(1, 12, 60)), 0.3, 0.6, 1.0, uniform, False)

# Groups more alike than by chance: the groups' variance is 0, and what is left is a regression line.
sample("alike_x", [0, 1, 2, 3, 0.5, 1.5, 2.5, 3.5, 0.2, 1.2, 2.2])
sample("alike_y", [1, -1, 1.4, -0.6, -1, 1.2, -1, 1.3, 1.1, -1, 0.3])
sample("alike_group", [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2])
x, y = of("alike_x", "alike_y")
line = stats.linregress(x, y)
case("random_intercept", ["alike_x", "alike_y", "alike_group"], {
    "intercept": line.intercept, "slope": line.slope, "standard_error": line.stderr, "z": line.slope / line.stderr,
    "between_variance": 0.0, "within_variance": line.stderr**2 * np.sum((x - x.mean()) ** 2),
}, reference="line")

json.dump({"samples": samples, "cases": cases}, sys.stdout, allow_nan=False, separators=(",", ":"))
print()
