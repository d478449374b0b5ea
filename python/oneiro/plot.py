"""Pictures on Matplotlib's axes. Each function draws on `ax`, or on the current axes, and returns them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Circle, Rectangle

from ._errors import InputError
from ._experiment import whole
from ._runs import Run, Sweep

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike

    from ._arena import Arena
    from ._native import Experiment

__all__ = ["arena", "curve", "path"]

_DARK = "#444444"


def _rectangle(x: float, y: float, length: float, width: float, heading: float, **style: Any) -> Rectangle:
    """A rectangle by its centre."""
    corner = (x - length / 2, y - width / 2)
    return Rectangle(corner, length, width, angle=360 * heading, rotation_point="center", **style)


def arena(exp: Experiment, ax: Axes | None = None) -> Axes:
    """Draws an experiment's arena, in mm."""
    ax = plt.gca() if ax is None else ax
    own: Arena = exp.arena
    for x, y, radius, length, width, heading, grey in own.patches.tolist():
        style = {"facecolor": str(min(max(grey, 0.0), 1.0)), "edgecolor": "#888888", "linewidth": 0.5, "zorder": 0}
        ax.add_patch(
            Circle((x, y), radius, **style) if radius > 0 else _rectangle(x, y, length, width, heading, **style)
        )
    for x, y, radius in own.circles.tolist():
        ax.add_patch(Circle((x, y), radius, color=_DARK, zorder=1))
    for x, y, length, width, heading in own.blocks.tolist():
        ax.add_patch(_rectangle(x, y, length, width, heading, color=_DARK, zorder=1))
    for x, y, to_x, to_y in own.segments.tolist():
        ax.plot([x, to_x], [y, to_y], color=_DARK, linewidth=1.5, zorder=1)
    for x, y, _ in own.lights.tolist():
        ax.plot([x], [y], marker="*", markersize=10, color="#e0a000", zorder=2)
    left, lower, width, height = own.field
    margin = 0.03 * max(width, height)
    ax.set_xlim(left - margin, left + width + margin)
    ax.set_ylim(lower - margin, lower + height + margin)
    ax.set_aspect("equal")
    ax.set_xlabel("x, mm")
    ax.set_ylabel("y, mm")
    return ax


def path(exp: Experiment, trace: ArrayLike, ax: Axes | None = None, *, length: int | None = None, **style: Any) -> Axes:
    """Draws the arena, and the way of a robot in it.

    `trace` is that of an episode, such as `outcome.traces[0, 0]`, or `[cycles, 2]` or `[cycles, 3]` positions or poses in mm. `length` is
    the number of cycles to draw: by default all, of an episode's trace those before its end. `style` is of Matplotlib's `plot`.
    """
    places = np.asarray(trace)
    if places.dtype.names is not None:
        if places.ndim != 1 or not {"x_mm", "y_mm"} <= set(places.dtype.names):
            raise InputError(f"trace: has the shape {list(places.shape)}; allowed: one episode's, [cycles]")
        if length is None:
            # After an early end there are zeros.
            lived = np.flatnonzero(places != np.zeros((), places.dtype))
            length = int(lived[-1]) + 1 if len(lived) else None
        places = np.stack([places["x_mm"], places["y_mm"]], axis=1)
    if places.ndim != 2 or places.shape[1] not in (2, 3) or len(places) == 0:
        raise InputError(f"trace: has the shape {list(places.shape)}; allowed: a trace, [cycles, 2] or [cycles, 3]")
    if length is not None:
        if not 1 <= whole("length", length) <= len(places):
            raise InputError(f"length: is {length}; allowed: 1 to {len(places)} cycles")
        places = places[:length]
    ax = arena(exp, ax)
    (line,) = ax.plot(places[:, 0], places[:, 1], **{"linewidth": 1.0, "zorder": 3, **style})
    ax.plot([places[0, 0]], [places[0, 1]], marker="o", markersize=4, color=line.get_color(), zorder=3)
    return ax


def curve(
    source: Run | Sweep, ax: Axes | None = None, *, columns: tuple[str, ...] = ("best", "mean"), **style: Any
) -> Axes:
    """Draws a run's learning curve, or that of each run of a sweep: columns of `generations` over the generation."""
    ax = plt.gca() if ax is None else ax
    table = source.generations
    names = list(table.keys()) if isinstance(table, dict) else list(table.columns)
    if missing := [name for name in columns if name not in names]:
        raise InputError(f"columns: has {missing[0]!r}; allowed: {', '.join(names)}")
    over = next(name for name in ("generation", *names) if name in names)
    which = np.asarray(table["run"]) if isinstance(source, Sweep) else np.zeros(len(table[over]), int)
    x = np.asarray(table[over])
    for index, column in enumerate(columns):
        y = np.asarray(table[column], float)
        for number, run in enumerate(dict.fromkeys(which.tolist())):
            own = which == run
            label = column if number == 0 else None
            ax.plot(x[own], y[own], **{"color": f"C{index}", "label": label, "linewidth": 1.0, **style})
    ax.set_xlabel(over)
    ax.set_ylabel("fitness")
    ax.legend()
    return ax
