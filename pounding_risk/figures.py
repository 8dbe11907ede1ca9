"""Figures from results alone: no solver, no scene. Titles state the finding with numbers taken from the data.

Colours are those of Okabe and Ito (2008), told apart by the colour-blind; lines differ in dash too, for print.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STANDARD_GRAVITY = 9.80665
STYLES = (("#0072B2", "-"), ("#D55E00", "--"), ("#009E73", "-."), ("#CC79A7", ":"), ("#56B4E9", "-"), ("#E69F00", "--"))
QUIET = "#555555"
LAW_WORDS = {"jankowski": "nonlinear viscoelastic", "viscous_elastoplastic": "viscous elastoplastic"}


def blank(
    rows: int = 1, columns: int = 1, size: tuple[float, float] = (8.0, 4.5), **options: Any
) -> tuple[Figure, Any]:
    """A figure without pyplot's global state, and its axes as an array."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    for each in axes.flat:
        each.grid(True, color="#dddddd", linewidth=0.6)
        each.set_axisbelow(True)
    return figure, axes


def title(figure: Figure, finding: str, condition: str) -> None:
    """The finding, and below it what it holds for."""
    figure.suptitle(f"{finding}\n{condition}", fontsize=11)


def law_words(name: str) -> str:
    """A contact law as a reader knows it."""
    return LAW_WORDS.get(name, name.replace("_", " "))


def force_words(force: float) -> str:
    """A force in kN."""
    return "without yielding" if np.isinf(force) else f"$F_E$ = {force / 1e3:.0f} kN"


def impact_figure(impacts: Sequence[Any]) -> Figure:
    """Force against time and against penetration of isolated impacts (`collision.Impact`)."""
    figure, axes = blank(1, 2, (10.0, 4.6), sharey=True)
    labels = [_impact_label(each, impacts) for each in impacts]
    for (colour, dash), each, label in zip(_styles(len(impacts)), impacts, labels, strict=True):
        axes[0, 0].plot(each.time * 1e3, each.force / 1e3, color=colour, linestyle=dash, label=label)
        axes[0, 1].plot(each.penetration * 1e3, each.force / 1e3, color=colour, linestyle=dash)
    axes[0, 0].set(xlabel="time since the touch [ms]", ylabel="contact force [kN]")
    axes[0, 1].set(xlabel="penetration [mm]")
    axes[0, 1].legend(*axes[0, 0].get_legend_handles_labels(), fontsize=8, loc="lower right")
    achieved = ", ".join(f"{each.restitution:.3f}" for each in impacts)
    title(figure, _impact_finding(impacts), f"isolated impacts, in the legend's order; restitution achieved {achieved}")
    return figure


def _impact_finding(impacts: Sequence[Any]) -> str:
    flat = [each for each in impacts if _plateau(each) > 0.0]
    rest = ", ".join(f"{each.peak_force / 1e3:.0f}" for each in impacts if _plateau(each) == 0.0)
    if len(flat) < 2 or len({round(each.peak_force) for each in flat}) > 1:
        return "Peak force " + ", ".join(f"{each.peak_force / 1e3:.0f}" for each in impacts) + " kN"
    lengths = " and ".join(f"{_plateau(each) * 1e3:.1f} ms ({each.mass:.0f} kg)" for each in flat)
    more = f"; no plateau at {rest} kN" if rest else ""
    return f"Equal plateaus of {flat[0].peak_force / 1e3:.0f} kN for {lengths}{more}"


def _plateau(each: Any) -> float:
    """Time spent at the largest force, to a millionth of it."""
    at_top = each.force >= each.peak_force * (1.0 - 1e-6)
    times = each.time[at_top]
    return float(times[-1] - times[0]) if at_top.sum() > 1 else 0.0


def _impact_label(each: Any, impacts: Sequence[Any]) -> str:
    parts = []
    if len({other.law for other in impacts}) > 1:
        parts.append(law_words(each.law))
    if len({other.mass for other in impacts}) > 1 or not parts:
        parts.append(f"{each.mass:.0f} kg")
    if len({other.approach_speed for other in impacts}) > 1 or len(parts) < 2:
        parts.append(f"{each.approach_speed:g} m/s")
    return ", ".join(parts)


def simulation_figure(run: xr.Dataset) -> Figure:
    """One run: ground motion, relative displacement with the gap, contact force, energies."""
    figure, axes = blank(4, 1, (9.0, 9.5), sharex=True)
    time = run["time"].values
    ground, moved, force, energy = axes[:, 0]
    ground.plot(time, run["ground_acceleration"] / STANDARD_GRAVITY, color=QUIET, linewidth=0.8)
    ground.set_ylabel("ground\nacceleration [g]")
    moved.plot(time, run["relative_displacement"] * 1e3, color=STYLES[0][0], linewidth=1.0)
    moved.axhline(
        float(run["gap"]) * 1e3, color=STYLES[1][0], linestyle="--", label=f"gap {float(run['gap']) * 1e3:g} mm"
    )
    moved.set_ylabel("relative\ndisplacement [mm]")
    moved.legend(loc="upper right", fontsize=8)
    force.plot(time, run["contact_force"] / 1e3, color=STYLES[1][0], linewidth=0.8)
    force.set_ylabel("contact\nforce [kN]")
    kinds = ("ground", "damping", "contact", "held")
    words = ("from the ground", "to structural damping", "to contact", "kinetic and strain")
    for (colour, dash), kind, word in zip(_styles(4), kinds, words, strict=True):
        energy.plot(time, run[f"energy_{kind}"] / 1e3, color=colour, linestyle=dash, linewidth=1.0, label=word)
    energy.set(ylabel="energy [kJ]", xlabel="time [s]")
    energy.legend(fontsize=8, loc="upper left")
    outputs = json.loads(run.attrs["outputs"])
    finding = (
        f"{outputs['impact_count']:.0f} contacts, peak force {outputs['peak_contact_force'] / 1e3:,.0f} kN, "
        f"peak relative displacement {outputs['peak_relative_displacement'] * 1e3:.2f} mm"
    )
    title(figure, finding, _conditions(run))
    return figure


def _conditions(run: xr.Dataset) -> str:
    facts = run.attrs
    return (
        f"{law_words(facts['contact_model'])}, {force_words(facts['yield_force'])}, gap {facts['gap'] * 1e3:g} mm, "
        f"{facts['record']} {facts['polarity']} at {facts['pga'] / STANDARD_GRAVITY:.2f} g"
    )


def comparison_figure(runs: Sequence[xr.Dataset]) -> Figure:
    """Relative displacement and contact force of two runs of one pair, as in the paper's Figure 8."""
    first, second = runs
    figure, axes = blank(2, 1, (9.0, 6.4), sharex=True, height_ratios=(2.0, 1.0))
    for (colour, dash), run in zip(_styles(2), runs, strict=True):
        label = f"{law_words(run.attrs['contact_model'])}, {force_words(run.attrs['yield_force'])}"
        axes[0, 0].plot(run["time"], run["relative_displacement"] * 1e3, color=colour, linestyle=dash, label=label)
        axes[1, 0].plot(run["time"], run["contact_force"] / 1e3, color=colour, linestyle=dash, linewidth=0.9)
    peaks = [_signed_peak(run) for run in runs]
    for (colour, _), (time, value) in zip(_styles(2), peaks, strict=True):
        axes[0, 0].plot(time, value * 1e3, marker="o", markersize=6, color=colour, markerfacecolor="white")
    parted = json.loads(second.attrs["outputs"])["first_yield_time"]
    for each in axes[:, 0]:
        each.axvline(parted, color=QUIET, linewidth=0.9, linestyle=":")
    axes[0, 0].annotate(
        f"first yield {parted:.2f} s", (parted, 0.97), xycoords=("data", "axes fraction"), xytext=(-4, 0),
        textcoords="offset points", ha="right", va="top", fontsize=9, color=QUIET,
    )  # fmt: skip
    axes[0, 0].set_ylabel("relative displacement [mm]\n(positive: towards contact)")
    axes[0, 0].legend(fontsize=8, loc="lower left")
    axes[1, 0].set(xlabel="time [s]", ylabel="contact force [kN]", xlim=(0.0, float(first["time"].max())))
    amounts = [abs(value) * 1e3 for _, value in peaks]
    word = "lowers" if amounts[1] < amounts[0] else "raises"
    title(
        figure,
        f"Identical until {parted:.2f} s; yielding {word} the peak from {amounts[0]:.2f} to {amounts[1]:.2f} mm",
        f"{first.attrs['title']}; gap {first.attrs['gap'] * 1e3:g} mm; {first.attrs['record']} "
        f"{first.attrs['polarity']} at {first.attrs['pga'] / STANDARD_GRAVITY:.2f} g; circles: peaks",
    )
    return figure


def _signed_peak(run: xr.Dataset) -> tuple[float, float]:
    values = run["relative_displacement"].values
    place = int(np.abs(values).argmax())
    return float(run["time"].values[place]), float(values[place])


def window_figure(searched: xr.Dataset, window: tuple[float, float]) -> Figure:
    """Peak relative displacement and time of first yield against F_E, in every polarity of the scan."""
    figure, axes = blank(2, 1, (9.0, 7.0), sharex=True)
    lines = searched.squeeze()
    forces = lines["yield_force"].values
    finite = np.isfinite(forces)
    for (colour, dash), name in zip(_styles(lines.sizes["polarity"]), lines["polarity"].values, strict=True):
        line = lines.sel(polarity=name)
        peak = line["peak_relative_displacement"].values * 1e3
        axes[0, 0].plot(forces[finite] / 1e3, peak[finite], color=colour, linestyle=dash, label=str(name))
        axes[0, 0].axhline(peak[~finite][0], color=colour, linestyle=dash, linewidth=0.7)
        first = line["first_yield_time"].values
        axes[1, 0].plot(forces[finite] / 1e3, first[finite], color=colour, linestyle=dash)
    for each in axes[:, 0]:
        each.axvspan(window[0] / 1e3, window[1] / 1e3, color="#F0E442", alpha=0.35, linewidth=0.0)
    axes[0, 0].set_ylabel("peak relative displacement [mm]\n(thin: without yielding)")
    axes[0, 0].legend(title="record's polarity", fontsize=8, title_fontsize=8, loc="upper right")
    axes[1, 0].axhline(2.4, color=QUIET, linestyle=":", linewidth=0.9)
    axes[1, 0].annotate(
        "2.4 s, as published", (forces[0] / 1e3, 2.4), xytext=(2, 3), textcoords="offset points", fontsize=8
    )
    axes[1, 0].set(xlabel="yield force $F_E$ [kN]", ylabel="first yield [s]")
    smaller = [str(name) for name in lines["polarity"].values if _smaller_within(lines.sel(polarity=name), window)]
    title(
        figure,
        f"First yield near 2.4 s, then a smaller peak: $F_E$ from {window[0] / 1e3:.0f} to {window[1] / 1e3:.0f} kN",
        f"{searched.attrs['title']}; all through this window yielding lowers the peak with the record "
        f"{' and '.join(smaller) or 'in no polarity'}",
    )
    return figure


def _smaller_within(line: xr.Dataset, window: tuple[float, float]) -> bool:
    """True where every peak inside the window of F_E is smaller than the one without yielding."""
    peak, forces = line["peak_relative_displacement"].values, line["yield_force"].values
    inside = (forces >= window[0]) & (forces <= window[1])
    return bool((peak[inside] < peak[np.isinf(forces)][0]).all())


def scan_figure(results: xr.Dataset) -> Figure:
    """Peak relative displacement over gap and yield force, one panel for each record and polarity.

    Without a grid of both, lines against whichever there is. The last contact law and amplitude of a dataset that
    has several is shown.
    """
    peak = results["peak_relative_displacement"] * 1e3
    for axis in ("pga", "contact_model"):
        if axis in peak.dims:
            peak = peak.isel({axis: -1})
    if min(peak.sizes["gap"], peak.sizes["yield_force"]) < 2:
        return _scan_lines(results, peak)
    rows, columns = peak.sizes["polarity"], peak.sizes["record"]
    figure, axes = blank(rows, columns, (max(7.6, 1.6 + 2.3 * columns), 1.8 + 2.5 * rows), sharex=True, sharey=True)
    low, high = float(peak.min()), float(peak.max())
    picture: Any = None
    for place in np.ndindex(rows, columns):
        one = peak.isel(polarity=place[0], record=place[1]).transpose("yield_force", "gap")
        picture = _map(axes[place], results, one, (low, high))
        if place[0] == 0:
            axes[place].set_title(str(one["record"].values), fontsize=9)
        if place[1] == 0:
            axes[place].set_ylabel(f"{one['polarity'].values}\n$F_E$ [kN]", fontsize=9)
    figure.supxlabel("gap [mm]", fontsize=10)
    figure.colorbar(picture, ax=axes, label="peak relative displacement [mm]")
    finding = f"{_gap_needed(results)}; peak relative displacement up to {high:.1f} mm"
    title(figure, finding, f"{results.attrs['title']}; right of the dashed line there is no contact")
    return figure


def _gap_needed(results: xr.Dataset) -> str:
    """From which gap on there is no contact, over the records and polarities of a scan."""
    others = [name for name in results["impact_count"].dims if name not in ("record", "polarity", "gap")]
    touching = (results["impact_count"] > 0).any(others)
    if bool(touching.isel(gap=-1).any()):
        return f"Contact in {float(touching.isel(gap=-1).mean()):.0%} of the motions at the widest gap"
    first = results["gap"].where(~touching).min("gap") * 1e3
    low, high = float(first.min()), float(first.max())
    return (
        f"No contact from a gap of {low:.3g} mm on"
        if low == high
        else f"No contact from gaps of {low:.3g} to {high:.3g} mm on"
    )


def _map(axes: Axes, results: xr.Dataset, values: xr.DataArray, limits: tuple[float, float]) -> Any:
    """One heat map with yield forces as evenly spaced classes; a line where contact ends, whatever F_E is."""
    gaps = values["gap"].values * 1e3
    edges = np.concatenate(
        [[gaps[0] - (gaps[1] - gaps[0]) / 2], (gaps[1:] + gaps[:-1]) / 2, [gaps[-1] + (gaps[-1] - gaps[-2]) / 2]]
    )
    classes = np.arange(values.sizes["yield_force"] + 1) - 0.5
    axes.grid(False)
    picture = axes.pcolormesh(edges, classes, values.values, cmap="viridis", vmin=limits[0], vmax=limits[1])
    here = {name: values[name].values for name in ("record", "polarity")}
    counts = results["impact_count"].sel(here).transpose(..., "yield_force", "gap").values
    counts = counts.reshape(-1, *counts.shape[-2:])[-1]
    touching = (counts > 0).any(axis=0)
    if not touching.all():
        axes.axvline(edges[np.argmin(touching)], color="white", linestyle="--", linewidth=1.5)
    forces = values["yield_force"].values
    axes.set_yticks(
        np.arange(len(forces)), ["∞" if np.isinf(force) else f"{force / 1e3:.0f}" for force in forces], fontsize=8
    )
    axes.tick_params(axis="x", labelsize=8)
    return picture


def _scan_lines(results: xr.Dataset, peak: xr.DataArray) -> Figure:
    axis = "yield_force" if peak.sizes["yield_force"] > 1 else "gap"
    other = "gap" if axis == "yield_force" else "yield_force"
    scale, words = (1e-3, "yield force $F_E$ [kN]") if axis == "yield_force" else (1e3, "gap [mm]")
    figure, axes = blank(1, 1, (8.5, 5.0))
    lines = peak.isel({other: 0}).stack(line=("record", "polarity"))
    for (colour, dash), place in zip(_styles(lines.sizes["line"]), range(lines.sizes["line"]), strict=True):
        line = lines.isel(line=place)
        label = f"{line['record'].values}, {line['polarity'].values}"
        axes[0, 0].plot(line[axis] * scale, line, color=colour, linestyle=dash, marker=".", label=label)
    axes[0, 0].set(xlabel=words, ylabel="peak relative displacement [mm]")
    axes[0, 0].legend(fontsize=8)
    title(
        figure,
        f"Peak relative displacement {float(peak.min()):.1f} to {float(peak.max()):.1f} mm",
        results.attrs["title"],
    )
    return figure


def _styles(count: int) -> list[tuple[str, str]]:
    return [STYLES[place % len(STYLES)] for place in range(count)]
