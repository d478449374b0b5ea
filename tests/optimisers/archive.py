"""An archive of elites as the Python package `ribs` fills it, as a file for the tests of host/evolve/src/map_elites/tests.rs.

    archive.py FILE
"""

import sys
from pathlib import Path

import numpy as np
import ribs
from ribs.archives import GridArchive

assert ribs.__version__ == "0.12.0", ribs.__version__

CELLS, RANGES, BATCH, BATCHES, OFFSET = [7, 5], [(-1.0, 1.0), (0.0, 10.0)], 16, 40, -2.5


def words(numbers):
    return " ".join(repr(float(number)) for number in np.ravel(numbers))


archive = GridArchive(solution_dim=1, dims=CELLS, ranges=RANGES, qd_score_offset=OFFSET)
random = np.random.default_rng(5)
lines = [f"{BATCH} {BATCHES} {OFFSET!r}"]
for batch in range(BATCHES):
    # Scores are rounded, so that many are equal, and some behaviours lie outside of the ranges.
    scores = np.round(random.normal(0.0, 2.0, BATCH), 1).astype(np.float32).astype(float)
    behaviour = np.stack([random.uniform(-1.2, 1.2, BATCH), random.uniform(-1.0, 11.0, BATCH)], axis=1)
    solutions = (batch * BATCH + np.arange(BATCH)).astype(float)[:, None]
    added = archive.add(solutions, scores, behaviour)
    lines.append(words(scores))
    lines.append(words(behaviour))
    lines.append(" ".join(str(int(status)) for status in added["status"]))
    lines.append(f"{len(archive)} {float(archive.stats.coverage)!r} {float(archive.stats.qd_score)!r}")
data = archive.data(["index", "objective", "solution"])
order = np.argsort(data["index"])
for place in order:
    lines.append(f"{data['index'][place]} {float(data['objective'][place])!r} {int(data['solution'][place][0])}")
Path(sys.argv[1]).write_text("\n".join(lines) + "\n")
print(lines[4 * BATCHES])
