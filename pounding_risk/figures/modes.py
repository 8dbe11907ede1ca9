"""Figure of the modes: the shapes of each building's slowest modes over its height."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.figures.style import QUIET, Figure, message, plain, styles, title, wrapped

if TYPE_CHECKING:
    from pounding_risk.studies.modes import Modes

MOST_MODES = 3
COLUMNS = 5  # buildings side by side


def modes_figure(buildings: Sequence[Modes]) -> Figure:
    """Shapes of the slowest modes by level, the largest displacement of each 1.

    Parameters
    ----------
    buildings : sequence of Modes
        As `modes` gives them, left to right.

    Returns
    -------
    matplotlib.figure.Figure
        A panel for each building.
    """
    figure, axes = wrapped(len(buildings), COLUMNS, (1.5, 1.0), (3.2, 3.6))
    for axis, building in zip(axes.flat, buildings, strict=False):
        _draw_shapes(axis, building)
    for axis in axes[:, 0]:
        axis.set_ylabel("level [m]")
    most = max(min(MOST_MODES, building.periods.size) for building in buildings)
    modes_text = f"the {most} slowest modes" if most > 1 else "the only mode"
    title(figure, _finding(buildings), f"shapes of {modes_text}; each building on its own, storeys elastic")
    return figure


def _finding(buildings: Sequence[Modes]) -> str:
    """The shortest and the longest first period, with their buildings."""
    first = sorted((float(one.periods[0]), one.name) for one in buildings if one.periods.size)
    words = (
        [f"{period:.3g} s ({plain(name)})" for period, name in dict.fromkeys((first[0], first[-1]))] if first else []
    )
    return f"First periods: {' to '.join(words)}" if words else "All buildings are rigid"


def _draw_shapes(axis: Any, building: Modes) -> None:
    axis.set_title(plain(building.name), fontsize=10, loc="left")
    axis.axvline(0.0, color=QUIET, linewidth=0.8)
    axis.set_xlim(-1.1, 1.1)
    axis.set_xlabel("displacement, the largest 1 [1]", fontsize=9)
    if not building.periods.size:
        axis.set_yticks([])
        return message(axis, "rigid")
    has_levels = not np.isnan(building.levels).any()
    levels = building.levels if has_levels else np.ones(building.levels.size)
    if not has_levels:
        axis.set_yticks([0.0, 1.0], ["ground", "mass"])
    for mode, (colour, dash) in enumerate(styles(min(MOST_MODES, building.periods.size))):
        shape = building.shapes[:, mode]
        # A building on soil moves at its foundation; any other stands still at the ground.
        is_grounded = levels[0] > 0.0
        heights = np.concatenate([[0.0], levels]) if is_grounded else levels
        displacements = np.concatenate([[0.0], shape]) if is_grounded else shape
        label = f"{building.periods[mode]:.3g} s, {100 * building.shares[mode]:.0f} % of the mass"
        axis.plot(displacements, heights, dash, color=colour, marker="o", markersize=3.5, label=label)
    axis.legend(fontsize=7, loc="upper left")
    axis.margins(y=0.25)
    axis.set_ylim(bottom=0.0)
