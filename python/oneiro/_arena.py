"""An experiment's arena, as arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class Arena(NamedTuple):
    """Where an experiment's robots are: float32 arrays with a row for each object, in mm, and headings in turns."""

    field: tuple[float, float, float, float]
    """x and y of the lower left corner, width and height."""
    segments: NDArray[np.float32]
    """`[n, 4]`: walls by x and y of both ends."""
    circles: NDArray[np.float32]
    """`[n, 3]`: round obstacles by x and y of the centre, and the radius."""
    blocks: NDArray[np.float32]
    """`[n, 5]`: rectangular obstacles by x and y of the centre, length, width and heading."""
    patches: NDArray[np.float32]
    """`[n, 7]`: parts of the floor by x and y of the centre; the radius, or 0 and length, width and heading; and the grey, 0 for black."""
    lights: NDArray[np.float32]
    """`[n, 3]`: x, y and height."""


def made(
    field: list[float],
    segments: NDArray[np.float32],
    circles: NDArray[np.float32],
    blocks: NDArray[np.float32],
    patches: NDArray[np.float32],
    lights: NDArray[np.float32],
) -> Arena:
    """An arena. Called by `Experiment.arena`."""
    x, y, width, height = field
    return Arena((x, y, width, height), segments, circles, blocks, patches, lights)
