"""How many runs of each cell the second edition of the 2014 study needs: python power.py

The unit of analysis is the run. Standard deviations are those of the first edition at the scale 0.2 with matched credit and the light
over the nest, from its effect sizes: 5.64 against 4.61 items a minute at d = 0.68 give 1.5, shares of 0.53 against 0.36 at d = 0.76 give
0.22. 5.64 against 4.65 at d = 0.98 leave next to nothing for Random Movement; 0.3 is taken, that of 230 items counted. The smallest effect of interest is 0.93 items a minute, a fifth of what
Random Movement brings, and 0.15 of the simulators. Runs of a case and of its null are taken as independent, as if sharing seeds gained nothing.
"""

from statistics import NormalDist

POWER = 0.8
# Holm's first step over the contrasts of one combination.
FAMILY = 43
ALPHA = 0.05


def needed(one, other, effect, equivalence=False):
    """The least number of runs in each of two groups at which the effect is found, or at no effect one of this size is excluded."""
    normal = NormalDist()
    level = ALPHA / FAMILY / (1 if equivalence else 2)
    # For equivalence both one-sided tests must reject.
    beta = (1 - POWER) / 2 if equivalence else 1 - POWER
    distance = normal.inv_cdf(1 - level) + normal.inv_cdf(1 - beta)
    for count in range(2, 10_000):
        # The degrees of freedom of count - 1 for the normal: the usual correction.
        error = ((one**2 + other**2) / count) ** 0.5 * (1 + 1 / (4 * (count - 1)))
        if distance * error <= effect:
            return count
    return None


print(f"food, two evolving cells: {needed(1.5, 1.5, 0.93)} runs")
print(f"food, an evolving cell and Random Movement: {needed(1.5, 0.3, 0.93)} runs")
print(f"shares of simulators: {needed(0.22, 0.22, 0.15)} runs")
print(f"food equivalent to Random Movement's within 0.465, where both spread by 0.3: {needed(0.3, 0.3, 0.465, True)} runs")
print(f"the same where one spreads by 1.5: {needed(1.5, 0.3, 0.465, True)} runs")
