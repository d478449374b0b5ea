"""How many runs of each cell the second edition of the 1995 study needs: python power.py

The unit of analysis is the robot; runs are nested in robots. A figure of a robot is the mean of its runs, so that of R runs it
has the variance robots + runs / R. The smallest effect of interest is 25 points of fitness, half of the first edition's gap without
noise, or about a quarter of its standard deviation over individuals (a gap of 50 at d = 0.46). Standard deviations are those of the first edition's
figures, rounded up: over robots 15 for a gap and for a difference of two gaps, over runs 60 for a gap and, as if the
conditions of one run were independent, 85 for a difference of two.
"""

from statistics import NormalDist

ROBOTS = 30
INTEREST = 25.0
POWER = 0.8
# Holm's first step over the contrasts of one collision rule and severity.
FAMILY = 16
ALPHA = 0.05


def needed(robots, runs, two_sided, least=2, most=1000):
    """The least number of runs at which a t test over robots finds the effect (or, one-sided, excludes it) with the power."""
    normal = NormalDist()
    level = ALPHA / FAMILY / (2 if two_sided else 1)
    # For equivalence both one-sided tests must reject at an effect of 0.
    beta = 1 - POWER if two_sided else (1 - POWER) / 2
    distance = normal.inv_cdf(1 - level) + normal.inv_cdf(1 - beta)
    for count in range(least, most):
        # 29 degrees of freedom for the normal: the usual correction of the sample size.
        error = ((robots**2 + runs**2 / count) / ROBOTS) ** 0.5 * (1 + 1 / (4 * (ROBOTS - 1)))
        if distance * error <= INTEREST:
            return count
    return None


print(f"difference of two conditions, two-sided: {needed(15.0, 85.0, True)} runs")
print(f"one gap against 0, two-sided: {needed(15.0, 60.0, True)} runs")
print(f"one gap equivalent to 0, within as much: {needed(15.0, 60.0, False)} runs")
