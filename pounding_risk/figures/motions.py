"""Figures of motions: before and after processing, histories, response spectra of an ensemble, and a selection."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pounding_risk.errors import PoundingError, RecordError
from pounding_risk.figures.style import STYLES, Axes, Figure, beside, blank, joined, logarithmic, plain, styles, title
from pounding_risk.motions.record import RAW, lowest_usable
from pounding_risk.units import STANDARD_GRAVITY, rounded, say_in

if TYPE_CHECKING:
    from pounding_risk.motions.motion import Motion
    from pounding_risk.motions.processing.signals import Samples
    from pounding_risk.motions.selection import Selection
    from pounding_risk.motions.target_spectra import Target

BEFORE, AFTER, NOISE = "#8a8a8a", STYLES[0][0], STYLES[1][0]
TARGET = STYLES[1][0]
SHORTEST, LONGEST = 0.02, 10.0  # s of the periods drawn
PERIODS = 120
MOST_ROWS = 12  # motions in a figure of histories
BINS_PER_DECADE = 40
FAINTEST = 1e-4  # of the largest Fourier amplitude after processing: below it there is nothing to see


class History(NamedTuple):
    """One quantity of a motion over time: its name, the size of its unit in SI, the unit, and its samples in SI."""

    name: str
    size: float
    unit: str
    samples: Samples


def processing_figure(before: Motion, after: Motion, *, shift: float = 0.0, note: str = "") -> Figure:
    """A record before and after processing: acceleration, velocity, displacement, and Fourier amplitudes.

    On the left both on one scale, which shows how far the integrals drift; on the right the processed one on its own.

    Parameters
    ----------
    before, after : Motion
        The record as it was read, and processed.
    shift : float
        Time [s] of the first sample of ``after`` on the clock of ``before``.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        Three rows of histories, and the spectrum with the corners of the filter.
    """
    figure, axes = blank(4, 2, (12.0, 10.5), height_ratios=(1.0, 1.0, 1.0, 1.35))
    for axis in axes[1:3].flat:
        axis.sharex(axes[0, 0] if axis in axes[:, 0] else axes[0, 1])
    old, new = _histories(before), _histories(after)
    for row, (old_history, new_history) in enumerate(zip(old, new, strict=True)):
        _draw_beside(axes[row], (before.times, old_history), (after.times + shift, new_history))
    for left, right in axes[:3]:
        left.set_xlim(min(0.0, shift), max(before.times[-1], after.times[-1] + shift))
        right.set_xlim(shift, after.times[-1] + shift)
    axes[2, 0].set_xlabel("time [s]")
    axes[2, 1].set_xlabel("time [s]")
    axes[0, 0].set_title("before (grey) and after (blue), one scale", fontsize=10)
    axes[0, 1].set_title("after, its own scale, peaks marked", fontsize=10)
    _draw_amplitudes(joined(figure, axes[3]), before, after)
    title(figure, _processing_words(before, after, old, new), _origin_words(after), note)
    return figure


def histories_figure(motions: Sequence[Motion], *, note: str = "") -> Figure:
    """Acceleration, velocity and displacement of motions over time, a row each.

    Parameters
    ----------
    motions : sequence of Motion
        From 1 to 12.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        A row of three panels for each motion; the largest value of each stands above it.

    Raises
    ------
    PoundingError
        For no motion, and for more than 12.
    """
    if not 1 <= len(motions) <= MOST_ROWS:
        raise PoundingError(f"{len(motions)} motions: a figure of histories shows from 1 to {MOST_ROWS}; name fewer")
    figure, axes = blank(len(motions), 3, (11.0, 1.2 + 1.45 * len(motions)))
    for row, motion in zip(axes, motions, strict=True):
        for axis, letter, history in zip(row, "avd", _histories(motion), strict=True):
            axis.plot(motion.times, history.samples / history.size, color=AFTER, linewidth=0.8)
            axis.set_ylabel(f"{letter} [{history.unit}]", fontsize=9)
            axis.tick_params(labelsize=8)
            axis.set_xlim(0.0, motion.duration)
            peak = float(np.abs(history.samples).max()) / history.size
            axis.set_title(f"{rounded(peak, 3)} {history.unit}", fontsize=8, loc="right", pad=2.0)
        row[0].set_title(plain(motion.name), fontsize=9, loc="left", pad=2.0)
    for axis in axes[-1]:
        axis.set_xlabel("time [s]", fontsize=9)
    condition = "Acceleration a, velocity v and displacement d of the ground, from rest; above each its largest value"
    motions_text = f"{len(motions)} motions" if len(motions) > 1 else plain(motions[0].name)
    peaks = [say_in(motion.pga, "g", 3) for motion in sorted(motions, key=lambda motion: motion.pga)]
    title(figure, f"{motions_text}: PGA {' to '.join(dict.fromkeys((peaks[0], peaks[-1])))}", condition, note)
    return figure


def _processing_words(before: Motion, after: Motion, old: Sequence[History], new: Sequence[History]) -> str:
    """How processing changes the largest acceleration and displacement of a motion."""
    if before.dt == after.dt and np.array_equal(before.acceleration, after.acceleration):
        return f"Processing leaves {plain(after.name)} as it is"
    changes = []
    for name, old_history, new_history in (("PGA", old[0], new[0]), ("PGD", old[2], new[2])):
        ends = [rounded(np.abs(history.samples).max() / new_history.size, 3) for history in (old_history, new_history)]
        changes.append(f"{name} from {ends[0]} to {ends[1]} {new_history.unit}")
    return f"Processing of {plain(after.name)} changes {' and '.join(changes)}"


def _origin_words(motion: Motion) -> str:
    """Event, date, station and component of a motion as far as they are known."""
    facts = [str(motion.record[key]) for key in ("event", "date", "station") if motion.record.get(key)]
    return ", ".join([*facts, f"component {motion.record['component']}"] if motion.record.get("component") else facts)


def _histories(motion: Motion) -> tuple[History, History, History]:
    velocity, displacement = motion.velocity_displacement()
    return (
        History("acceleration", STANDARD_GRAVITY, "g", motion.acceleration),
        History("velocity", 0.01, "cm/s", velocity),
        History("displacement", 0.01, "cm", displacement),
    )


def _draw_beside(axes: Any, before: tuple[Samples, History], after: tuple[Samples, History]) -> None:
    """Draw one quantity: both motions on the left, the later one alone on the right with its peak marked."""
    (old_times, old), (times, new) = before, after
    both_panel, new_panel = axes
    size, unit = new.size, new.unit
    if max(np.abs(old.samples).max(), np.abs(new.samples).max()) > 100.0 * size and unit.startswith("cm"):
        size, unit = 100.0 * size, unit.removeprefix("c")
    both_panel.plot(old_times, old.samples / size, color=BEFORE, linewidth=1.6, label="before")
    both_panel.plot(times, new.samples / size, color=AFTER, linewidth=0.8, label="after")
    both_panel.set_ylabel(f"{new.name} [{unit}]")
    values = new.samples / new.size
    new_panel.plot(times, values, color=AFTER, linewidth=0.8)
    new_panel.set_ylabel(f"[{new.unit}]")
    peak = int(np.abs(values).argmax())
    new_panel.plot(times[peak], values[peak], "o", color="black", markerfacecolor="none", markersize=6)
    new_panel.margins(y=0.18)
    words = f"{rounded(abs(values[peak]), 3)} {new.unit} at {times[peak]:.4g} s"
    is_late = times[peak] > 0.5 * (times[0] + times[-1])
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 1.0}
    beside(new_panel, words, (times[peak], values[peak]), (-9 if is_late else 9, 0), 9, bbox=box)


def _draw_amplitudes(axis: Axes, before: Motion, after: Motion) -> None:
    """Draw Fourier amplitudes before and after, that of the noise, and the corners of the filter."""
    centred = before.acceleration - before.acceleration.mean()
    new = fourier_amplitude(after.acceleration, after.dt)
    axis.plot(*fourier_amplitude(centred, before.dt), color=BEFORE, linewidth=2.2, label="before, less its mean")
    axis.plot(*new, color=AFTER, linewidth=1.2, label="after")
    noise = _noise(before)
    if noise is not None:
        axis.plot(*noise, color=NOISE, linestyle=":", linewidth=1.6, label="noise before the earthquake, smoothed")
    limits = min(max(0.01, 1.0 / after.duration), 0.05 / after.dt), 0.5 / after.dt
    corners_shown = [corner for corner in corners(after) if limits[0] <= corner <= limits[1]]
    for index, corner in enumerate(corners_shown):
        words = "" if index else "corners of the filter"
        axis.axvline(corner, color="black", linestyle="--", linewidth=1.0, label=words)
        shift, look = 4 if corner < 1.0 else -4, {"xycoords": ("data", "axes fraction"), "va": "baseline"}
        beside(axis, f"{corner:.3g} Hz", (corner, 0.03), (shift, 0), 9, **look)
    axis.set(xlabel="frequency [Hz]", ylabel="Fourier amplitude\nof acceleration [m/s]")
    axis.set_xscale("log")
    highest = float(new[1].max(initial=0.0))
    if highest > 0.0:
        axis.set_yscale("log")
        lowest = FAINTEST * highest if noise is None else min(FAINTEST * highest, 0.5 * float(noise[1].min()))
        axis.set_ylim(max(lowest, FAINTEST**2 * highest), 4.0 * highest)
    axis.set_xlim(limits)
    axis.legend(fontsize=9, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, frameon=False)


def _noise(motion: Motion) -> tuple[Samples, Samples] | None:
    """Frequency [Hz] and Fourier amplitude [m/s] of the noise before the earthquake, for as long as the earthquake.

    None for a processed record, whose quiet is the filter's, and where there is too little quiet.
    """
    from pounding_risk.motions.processing.noise import signal_to_noise

    if motion.record.get("state") != RAW:
        return None
    try:
        spectra = signal_to_noise(motion.acceleration, motion.dt)
    except RecordError:
        return None
    return spectra.frequency, spectra.noise


def fourier_amplitude(samples: Samples, dt: float) -> tuple[Samples, Samples]:
    """Frequency [Hz] and Fourier amplitude [m/s] of an acceleration, root mean square in 40 bins a decade.

    |∫ a exp(−2πift) dt|; bins without a frequency of the transform are left out, and so is zero frequency.
    """
    amplitude = np.abs(np.fft.rfft(samples))[1:] * dt
    frequency = np.fft.rfftfreq(len(samples), dt)[1:]
    bins = np.floor(BINS_PER_DECADE * np.log10(frequency)).astype(int)
    bins -= bins.min()
    counts = np.bincount(bins)
    is_filled = counts > 0
    means = [np.bincount(bins, weights)[is_filled] / counts[is_filled] for weights in (frequency, amplitude**2)]
    return means[0], np.sqrt(means[1])


def corners(motion: Motion) -> tuple[float, ...]:
    """Corners [Hz] of the filter that a motion went through, here or before it was distributed."""
    frequencies = [motion.record.get(key) for key in ("low_corner", "high_corner")]
    return tuple(float(corner) for corner in frequencies if corner)


def longest_usable(motion: Motion) -> float | None:
    """Longest period [s] at which the spectrum of a motion is not that of its filter; None where it is not known."""
    lowest = lowest_usable(motion.record)
    return 1.0 / lowest if lowest else None


def ensemble_spectra(motions: Sequence[Motion], damping: float = 0.05) -> tuple[Samples, Samples]:
    """Some 120 periods from 0.02 to 10 s, and Sa = ω² max|u| of every motion there [m/s²], in one call.

    Raises PoundingError for no motion, and for one of zeros, which a logarithmic scale cannot show.
    """
    from pounding_risk.motions.intensity import response_spectra

    if not motions:
        raise PoundingError("there is no motion to draw spectra of; give one at least")
    still = [motion.name for motion in motions if not motion.acceleration.any()]
    if still:
        raise PoundingError(f"{', '.join(still)}: every sample is zero, which has no spectrum; leave it out")
    steps, periods = [motion.dt for motion in motions], ensemble_periods(motions)
    spectra = response_spectra([motion.acceleration for motion in motions], steps, periods, damping)
    return periods, spectra.pseudo_acceleration


def ensemble_periods(motions: Sequence[Motion]) -> Samples:
    """Periods [s] from 0.02 to 10 s, or from the shortest that every time step allows, evenly in the logarithm."""
    from pounding_risk.motions.intensity import LEAST_PERIOD

    shortest = max(SHORTEST, LEAST_PERIOD * max(motion.dt for motion in motions))
    return np.geomspace(shortest, LONGEST, PERIODS)


def spectra_figure(
    motions: Sequence[Motion],
    target: Target | None = None,
    damping: float = 0.05,
    percentiles: tuple[float, float] = (16.0, 84.0),
    *,
    note: str = "",
) -> Figure:
    """Response spectra of motions, their median and percentiles, and a target spectrum.

    Parameters
    ----------
    motions : sequence of Motion
        At least one.
    target : Target, optional
        A target spectrum.
    damping : float
        Damping ratio.
    percentiles : pair of float
        Percentiles of the motions [%] that are drawn at each period.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        One panel: Sa [g] against period [s].
    """
    periods, spectra = ensemble_spectra(motions, damping)
    figure, axes = blank(1, 1, (9.0, 6.0))
    draw_spectra(axes[0, 0], periods, spectra, percentiles)
    if target is not None:
        _draw_target(axes[0, 0], target, periods)
    _draw_usable(axes[0, 0], motions)
    axes[0, 0].legend(fontsize=9, loc="lower left")
    terms = f"Damping {100.0 * damping:g} %"
    if len(motions) > 2:
        terms = f"{terms}; median and {percentiles[0]:g} to {percentiles[1]:g} % of the records at each period"
    motions_text = f"Median Sa of {len(motions)} records" if len(motions) > 1 else f"Sa of {plain(motions[0].name)}"
    title(figure, _spectrum_words(motions_text, periods, np.median(spectra, axis=0), target), terms, note)
    return figure


def _spectrum_words(motions_text: str, periods: Samples, spectrum: Samples, target: Target | None) -> str:
    """The period at which a spectrum [m/s²] is largest, or the range of its ratios to a target where one is given."""
    if target is not None and np.isfinite(ratios := spectrum / at_periods(target, periods)).any():
        low, high = np.nanmin(ratios), np.nanmax(ratios)
        ends = max(periods[0], target.periods[0]), min(periods[-1], target.periods[-1])
        range_text = f"from {ends[0]:.3g} to {ends[1]:.3g} s"
        return f"{motions_text} is {low:.2f} to {high:.2f} times {plain(target.name)} {range_text}"
    index = int(spectrum.argmax())
    return f"{motions_text} is largest at {periods[index]:.2g} s: {say_in(spectrum[index], 'g', 3)}"


def draw_spectra(
    axis: Axes,
    periods: Samples,
    values: Samples,
    percentiles: tuple[float, float] = (16.0, 84.0),
    buildings: Sequence[tuple[str, float]] = (),
    of_selection: str = "",
) -> None:
    """Each record's Sa [m/s²], (records, periods), their median and percentiles, and the periods of buildings [s].

    A selection, ``of_selection`` such as "pairs", has no median: its geometric mean in the compared range is drawn.
    """
    values, is_ensemble = values / STANDARD_GRAVITY, len(values) > 1 or bool(of_selection)
    words = f"{len(values)} {of_selection}, scaled" if of_selection else f"{len(values)} records"
    look: dict[str, Any] = {"color": "#b0b0b0", "linewidth": 0.6, "label": words}
    if not is_ensemble:
        look = {"color": AFTER, "linewidth": 1.8, "label": "the record"}
    for spectrum in values:
        axis.plot(periods, spectrum, **look)
        look["label"] = ""
    if is_ensemble and not of_selection:
        axis.plot(periods, np.median(values, axis=0), color=AFTER, linewidth=2.4, label="median")
    if len(values) > 2:
        words = f"{percentiles[0]:g} and {percentiles[1]:g} %{f' of the {of_selection}' if of_selection else ''}"
        for share, label in zip(np.percentile(values, percentiles, axis=0), (words, ""), strict=True):
            axis.plot(periods, share, color=AFTER, linestyle="--", linewidth=1.4, label=label)
    for (name, period), (colour, dash) in zip(buildings, styles(len(buildings) + 1)[1:], strict=True):
        if periods[0] <= period <= periods[-1]:
            axis.axvline(period, color=colour, linestyle=dash, linewidth=1.6, label=f"{plain(name)}, {period:.3g} s")
    axis.set(xscale="log", yscale="log", xlabel="period [s]", ylabel="spectral acceleration Sa [g]")
    axis.set_xlim(periods[0], periods[-1])
    for scale in (axis.xaxis, axis.yaxis):
        scale.set_major_formatter("{x:g}")


def _draw_target(axis: Axes, target: Target, periods: Samples) -> None:
    """Draw the target at the periods that it is given for."""
    shown = at_periods(target, periods) / STANDARD_GRAVITY
    axis.plot(periods, shown, color=TARGET, linewidth=2.2, linestyle=(0, (6, 1.5)), label=f"target: {target.name}")
    is_inside = np.isfinite(shown)
    if target.deviation is not None and is_inside.any():
        shown_periods, spread = periods[is_inside], np.exp(target.deviation_at(periods[is_inside]))
        words = "target, one standard deviation of ln Sa to each side"
        for values, label in ((shown[is_inside] * spread, words), (shown[is_inside] / spread, "")):
            axis.plot(shown_periods, values, color=TARGET, linewidth=1.2, linestyle=(0, (2, 1.5)), label=label)


def _draw_usable(axis: Axes, motions: Sequence[Motion]) -> None:
    """Draw a line at the period up to which every record is usable, as far as that is known."""
    limits = [limit for limit in map(longest_usable, motions) if limit is not None]
    if limits and min(limits) < axis.get_xlim()[1]:
        records_text = "every record" if len(limits) == len(motions) else f"{len(limits)} of {len(motions)} records"
        words = f"usable up to {min(limits):.2g} s: {records_text if len(motions) > 1 else 'the record'}"
        axis.axvline(min(limits), color="black", linestyle=":", linewidth=1.2, label=words)


def selection_figure(
    selection: Selection, percentiles: tuple[float, float] = (16.0, 84.0), *, note: str = ""
) -> Figure:
    """Selected records, scaled, against the target; and the factor and the misfit of each.

    Parameters
    ----------
    selection : Selection
        As `select` gives it. The blue line is the geometric mean of what was compared with the target, in the range
        where it was.
    percentiles : pair of float
        Percentiles of the records [%] that are drawn at each period.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        Spectra on the left, misfits on the right; between them the standard deviation of ln Sa, where the target has
        one.
    """
    rows, target = selection.rows, selection.wanted
    has_spread = selection.target.deviation is not None
    widths = (1.5, 1.0, 1.0) if has_spread else (1.5, 1.0)
    size = (7.0 * sum(widths) / 1.25, max(6.0, 1.6 + 0.28 * len(rows)))
    figure, axes = blank(1, len(widths), size, width_ratios=widths)
    left, right = axes[0][0], axes[0][-1]
    if has_spread:
        _draw_deviation(axes[0][1], selection)
    periods = ensemble_periods(selection.motions())
    noun = "components" if target.spectrum == "component" else f"pairs ({target.spectrum})"
    left.axvspan(*target.periods, color="#eeeeee", linewidth=0.0, zorder=0, label="range that is compared")
    draw_spectra(left, periods, selection.spectra_at(periods), percentiles, of_selection=noun)
    mean = selection.median_ratio * selection.target.at(selection.periods) / STANDARD_GRAVITY
    left.plot(selection.periods, mean, color=AFTER, linewidth=2.6, label=f"geometric mean of {len(rows)} {noun}")
    _draw_target(left, selection.target, periods)
    _draw_usable(left, selection.motions())
    left.legend(fontsize=9, loc="lower left")
    for position, row in enumerate(rows):
        look: dict[str, Any] = {"color": "white", "hatch": "////"} if row.limited else {"color": AFTER}
        right.barh(position, row.misfit, height=0.7, edgecolor=AFTER, **look)
        beside(right, f"× {row.factor:.2f}", (row.misfit, position), (4, 0), 8.5)
    right.set_yticks(range(len(rows)), [row.name for row in rows], fontsize=8.5)
    right.set_ylim(len(rows) - 0.4, -0.6)
    right.set_xlim(0.0, 1.2 * max(row.misfit for row in rows) or 1.0)
    right.grid(False, axis="y")
    limited_text = ", hatched: at a limit" if any(row.limited for row in rows) else ""
    right.set_title(f"factor (×{limited_text}) and misfit of each", fontsize=10)
    right.set_xlabel("misfit, root mean square of ln(Sa / target) [1]")
    factors = [row.factor for row in rows]
    terms = f"Compared from {target.periods[0]:g} to {target.periods[1]:g} s; "
    terms += f"damping {100.0 * selection.target.damping:g} %; factors {min(factors):.2f} to {max(factors):.2f}"
    low, high = selection.median_ratio.min(), selection.median_ratio.max()
    finding = f"their geometric mean is {low:.2f} to {high:.2f} times {plain(selection.target.name)}"
    title(figure, f"{len(rows)} of {selection.considered} candidates: {finding}", terms, note)
    return figure


def _draw_deviation(axis: Axes, selection: Selection) -> None:
    """Draw the standard deviation of ln Sa of the chosen records over the periods, and that of the target."""
    periods = selection.periods
    axis.plot(periods, selection.deviation, color=AFTER, linewidth=2.2, label=f"{len(selection.rows)} chosen")
    goal = selection.target.deviation_at(periods)
    axis.plot(periods, goal, color=TARGET, linewidth=2.2, linestyle=(0, (6, 1.5)), label="target")
    logarithmic(axis, "x", periods[0], periods[-1])
    axis.set(xlabel="period [s]", ylabel="standard deviation of ln Sa [1]")
    axis.set_ylim(bottom=0.0)
    axis.legend(fontsize=9)
    axis.set_title("spread in the range that is compared", fontsize=10)


def at_periods(target: Target, periods: Samples) -> Samples:
    """Sa [m/s²] of a target at these periods; NaN outside its range."""
    is_inside = (periods >= target.periods[0]) & (periods <= target.periods[-1])
    values = np.full(len(periods), np.nan)
    if is_inside.any():
        values[is_inside] = target.at(periods[is_inside])
    return values
