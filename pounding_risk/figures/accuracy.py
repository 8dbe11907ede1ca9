"""The work-precision figure: error against time for every setting of every method, one panel for each output."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from pounding_risk._common.counted import counted
from pounding_risk.figures.style import QUIET, Figure, beside, blank, legend_below, logarithmic, message, title
from pounding_risk.lab.accuracy_findings import EVENT, OUTPUTS, summed_up
from pounding_risk.results.tolerance_check import COUNTED

# Colour and marker of each method, the same in every figure, whichever methods it has.
LOOKS = {
    EVENT: ("#0072B2", "o"),
    "Newmark average acceleration": ("#D55E00", "s"),
    "central difference": ("#E69F00", "^"),
    "Runge-Kutta 4": ("#009E73", "D"),
    "OpenSees": ("#56B4E9", "X"),
    "SciPy DOP853": ("#CC79A7", "v"),
    "SciPy Radau": ("#000000", "P"),
}
FLOOR = 1e-14  # where errors of zero are drawn
WORST = 1e1  # where larger errors are drawn: a motion that blew up


def accuracy_figure(dataset: xr.Dataset, note: str = "") -> Figure:
    """Errors of every method and setting against processor time per run: medians (lines) and largest (dotted).

    Parameters
    ----------
    dataset : xarray.Dataset
        A dataset of `accuracy`.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each output.
    """
    figure, axes = blank(2, 3, size=(12.0, 7.6))
    solvers = [str(name) for name in dataset["solver"].values]
    for index, (output, words) in enumerate(OUTPUTS.items()):
        axis = axes.flat[index]
        for solver in solvers:
            _draw(axis, dataset, (solver, output), LOOKS[solver])
        _frame(axis, words, dataset.sel(output=output))
    worst = ", a case's that of its worst interface" if dataset.sizes.get("interface", 1) > 1 else ""
    cases = counted(dataset.sizes["case"], "case")
    counts = f"{dataset.attrs['title']}; {cases}; median error (lines) and largest (dotted, counts){worst}"
    title(figure, dataset.attrs["finding"], counts, note)
    handles = axes.flat[0].get_legend_handles_labels()[0]
    legend_below(figure, handles, len(handles))
    return figure


def _draw(axis: Any, dataset: xr.Dataset, curve: tuple[str, str], style: tuple[str, str]) -> None:
    (solver, output), (colour, marker) = curve, style
    settings = dataset.isel(setting=np.flatnonzero(dataset["method"].values == solver)).sel(output=output)
    times = settings["time"].values
    middle, worst = np.array([summed_up(error) for error in settings["error"].values]).T
    if output in COUNTED:
        middle = worst  # a count is right or wrong: it matters whether every case is right
    is_known = ~np.isnan(middle) & (middle < WORST)
    line = {"color": colour, "linewidth": 2.2 if solver == EVENT else 1.2, "zorder": 4 if solver == EVENT else 3}
    # The legend's entry, with line and marker, whether or not there is anything to draw.
    axis.plot([], [], label=solver, marker=marker, markersize=5, **line)
    if output not in COUNTED:
        axis.plot(times[is_known], np.maximum(middle[is_known], FLOOR), **line)
        axis.plot(times[is_known], np.clip(worst[is_known], FLOOR, WORST), linestyle=":", color=colour, linewidth=0.9)
    is_exact = is_known & (middle <= FLOOR)
    for mask, face in ((is_known & ~is_exact, colour), (is_exact, "white")):
        errors = np.maximum(middle[mask], FLOOR)
        axis.plot(times[mask], errors, marker, color=colour, markerfacecolor=face, markersize=5, zorder=5)
    if output == "peak_relative_displacement" and solver in (EVENT, "Runge-Kutta 4"):
        _name_settings(axis, settings, middle, is_known)


def _name_settings(axis: Any, settings: xr.Dataset, middle: np.ndarray, is_known: np.ndarray) -> None:
    """Write the setting beside three tolerances of the first panel, and below the ends of a line of time steps."""
    values, known_indices = settings["parameter"].values, np.flatnonzero(is_known)
    has_tolerance = "rtol" in str(settings["setting"].values[0])
    shift = (-6, -3) if has_tolerance else (0, -5)
    ends = (1e-3, 1e-6, 1e-9) if has_tolerance else values[known_indices[[0, -1]]] if known_indices.size else ()
    for index in (int(np.argmin(np.abs(np.log(values / end)))) for end in ends):
        if is_known[index]:
            words = str(settings["setting"].values[index]).split(", ")[1]
            beside(axis, words, (settings["time"].values[index], max(middle[index], FLOOR)), shift, 7, color=QUIET)


def _frame(axis: Any, words: str, settings: xr.Dataset) -> None:
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_ylim(FLOOR / 3.0, WORST)
    axis.set_title(words, fontsize=10)
    axis.set_xlabel("processor time per run [s]")
    axis.set_ylabel("error against the reference [1]")
    times = settings["time"].values
    axis.set_xlim(0.2 * times.min(), 3.0 * times.max())
    if times.max() < 10.0 * times.min():  # too few powers of ten to label these alone
        logarithmic(axis, "x", *axis.get_xlim())
    errors = settings["error"].values
    if np.isnan(errors).all():
        message(axis, "the gap is closed at rest: the first touch has no meaningful time", 30)
    elif (errors <= FLOOR).any():
        axis.axhline(FLOOR, color=QUIET, linewidth=0.6)
        look: dict[str, Any] = {"xycoords": ("axes fraction", "data"), "va": "baseline", "color": QUIET}
        beside(axis, "no error", (1.0, FLOOR), (-4, 4), 8, **look)
