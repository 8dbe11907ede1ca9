"""Figure of effects: what each combination changes in every output, and the time it costs."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from pounding_risk._common.counted import counted
from pounding_risk.figures.style import QUIET, STYLES, Figure, beside, blank, title
from pounding_risk.lab.effects_findings import COMPARED, acted_on, changes, yielding_cases

PANELS = (
    *("peak_relative_displacement", "peak_contact_force", "impact_count"),
    *("peak_floor_acceleration", "permanent_set"),
)


def effects_figure(dataset: xr.Dataset, note: str = "") -> Figure:
    """Changes of outputs by effects over the cases that they act on, and the time of a run.

    Parameters
    ----------
    dataset : xarray.Dataset
        A dataset of `effects`.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        A panel for each output that is above zero somewhere, with every case, the median and the middle two thirds; the
        last one for the time.
    """
    panels = [output for output in PANELS if (dataset[output] > 0.0).any()]
    rows_of_panels = len(panels) // 3 + 1
    figure, axes = blank(rows_of_panels, 3, size=(12.0, 2.8 + 0.9 * dataset.sizes["effects"]), sharey=True)
    for axis in axes.flat[len(panels) + 1 :]:
        axis.set_visible(False)
    names = [str(name) for name in dataset["effects"].values]
    yielded = yielding_cases(dataset)
    for axis, output in zip(axes.flat, panels, strict=False):
        in_mm = output == "permanent_set"
        rows = []
        for name in names[1:]:
            if in_mm:
                rows.append(1e3 * dataset[output].sel(effects=name).values[acted_on(dataset, name)].ravel())
            else:
                rows.append(100.0 * changes(dataset, name, output))
        axis.set_xlim(*_edges(rows))
        axis.locator_params(axis="x", nbins=7)
        for row, values in enumerate(rows, 1):
            _draw_spread(axis, row, values, STYLES[row % len(STYLES)][0])
            _write_beyond(axis, row, values, "mm" if in_mm else "%")
        axis.axvline(0.0, color=QUIET, linewidth=0.8)
        axis.set_title(COMPARED[output], fontsize=10)
        axis.set_xlabel("widening of the gap at the end [mm]" if in_mm else "change by the effects [%]")
    axis, ratios = axes.flat[len(panels)], dataset["time_ratio"].values
    for row in range(1, len(ratios)):
        axis.barh(row, ratios[row], height=0.5, color=STYLES[row % len(STYLES)][0])
        beside(axis, f"{ratios[row]:.2f}", (ratios[row], row), (4, 0), 10)
    axis.axvline(1.0, color=QUIET, linewidth=0.8)
    axis.set_xlim(0.0, 1.25 * max(1.0, ratios.max()))
    axis.set_title("time of a run", fontsize=10)
    axis.set_xlabel("over that without effects [1]")
    for axis in axes[:, 0]:
        axis.set_yticks(range(1, len(names)), [name.replace(" + ", "\n+ ") for name in names[1:]])
        axis.set_ylim(len(names) - 0.4, 0.4)
    all_text = ", and all where the ground or a building is changed" if dataset["acts_on_all"].any() else ""
    has_interfaces = dataset.sizes.get("interface", 1) > 1
    idle = [COMPARED[output] for output in PANELS if output not in panels]
    idle_words = f"; no panel, as above zero in no case: {', '.join(idle)}" if idle else ""
    dots = ", dots: a case at one interface, or of one building" if has_interfaces else ""
    has_infinite = any(np.isinf(changes(dataset, name, output)).any() for name in names[1:] for output in panels)
    idle_words += "; from zero: nothing without effects" * has_infinite
    condition = (
        f"{dataset.attrs['title']}; shown: {int(yielded.sum())} of {counted(yielded.size, 'case')} that yield without "
        f"effects{all_text}; bars: middle two thirds, line: median{dots}{idle_words}"
    )
    title(figure, dataset.attrs["finding"], condition, note)
    return figure


def _edges(rows: list[np.ndarray]) -> tuple[float, float]:
    """Ends of a panel: all values but the outermost hundredth of any row, so that a few far cases leave room.

    A row of less than a hundred values lies within.
    """
    finite_rows = [values[np.isfinite(values)] for values in rows if np.isfinite(values).any()] or [np.zeros(1)]
    low = min(0.0, *(float(np.quantile(values, 0.01, method="lower")) for values in finite_rows))
    high = max(0.0, *(float(np.quantile(values, 0.99, method="higher")) for values in finite_rows))
    margin = 0.05 * (high - low) or 1.0
    return low - margin, high + margin


def _draw_spread(axis: Any, row: int, values: np.ndarray, colour: str) -> None:
    """Every value of a row, their median and middle two thirds."""
    if not values.size:
        return
    # Points side by side at random, the same on any day.
    shifts = np.random.default_rng(row).uniform(-0.18, 0.18, values.size)
    axis.plot(values, row + shifts, ".", color=colour, markersize=4, alpha=0.5)
    edge = axis.get_xlim()[1]
    low, middle, high = np.quantile(np.minimum(values, edge), (0.16, 0.5, 0.84))
    if np.quantile(values, 0.84, method="higher") > edge:  # the bar goes on beyond the panel
        high = edge
        axis.plot(edge, row, ">", color="black", markersize=9, clip_on=False, zorder=4)
    axis.plot([low, high], [row, row], color="black", linewidth=3, solid_capstyle="butt", alpha=0.6)
    axis.plot([middle, middle], [row - 0.28, row + 0.28], color="black", linewidth=2)


def _write_beyond(axis: Any, row: int, values: np.ndarray, unit: str) -> None:
    """How many values of a row lie outside the panel, and the farthest; a change from zero is infinite."""
    left, right = axis.get_xlim()
    finite = values[np.isfinite(values)]
    for edge, beyond, shift in ((left, finite[finite < left], 3), (right, finite[finite > right], -3)):
        words = []
        if beyond.size:
            farthest = f"{beyond[np.abs(beyond).argmax()]:+.0f}".replace("-", "−")
            words.append(f"{beyond.size} beyond, to {farthest} {unit}")
        if edge == right and np.isinf(values).any():
            words.append(f"{np.isinf(values).sum()} from zero")
        beside(axis, ", ".join(words), (edge, row + 0.42), (shift, 0), 8)
