"""Figure of uncertain numbers: P(contact) over samples and motions, and the numbers on which it depends."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from pounding_risk._common.counted import counted
from pounding_risk.assessment.options import percent_words
from pounding_risk.assessment.uncertain_words import OUTPUT_WORDS, gap_scatter, indices_words
from pounding_risk.assessment.verdict import share_words
from pounding_risk.figures.assess import VERDICT_WORDS
from pounding_risk.figures.style import MEANING, QUIET, STYLES, Figure, blank, legend_under, message, plain, title
from pounding_risk.results.check import check_kind
from pounding_risk.statistics.sobol import LEAST_SAMPLES
from pounding_risk.units import say_in

BANDS = ((5.0, 95.0, 0.18), (16.0, 84.0, 0.32))  # percentiles over the samples, and how dark
LEAST_SHOWN, MOST_SHOWN = -0.25, 1.25  # of shares, whose bounds may lie further out
MOST_NUMBERS = 12  # that are drawn, those that matter most
FIRST, TOTAL = STYLES[0][0], STYLES[5][0]
LEAST_GAP = 1e-5  # m; no gap is built to less, so that shares of a smaller one mean nothing


def uncertainty_figure(results: xr.Dataset, note: str = "", *, titled: bool = True) -> Figure:
    """P(contact) against the gap over samples and motions, with indices of the uncertain numbers and a tornado.

    Parameters
    ----------
    results : xarray.Dataset
        A dataset of `uncertainty`.
    note : str
        Added to the caption.
    titled : bool
        Whether finding and conditions are written; without them, as in a report, panels stand below each other.

    Returns
    -------
    matplotlib.figure.Figure
        A line of panels for each interface; the tornado where the dataset is of a scene.

    Raises
    ------
    PoundingError
        For a dataset of another call.
    """
    check_kind(results, "uncertainty")
    names = [str(name) for name in np.atleast_1d(results["interface"].values)]
    has_tornado = "quantile" in results.dims
    columns = 3 if has_tornado else 2
    shape = (len(names), columns) if titled else (len(names) * columns, 1)
    size = (4.6 * columns, 0.8 + 4.8 * len(names)) if titled else (7.2, 3.8 * shape[0])
    figure, axes = blank(*shape, size)
    interfaces = [results.sel(interface=name) if "interface" in results.dims else results for name in names]
    for line, part, name in zip(axes.reshape(-1, columns), interfaces, names, strict=True):
        _draw_contact(line[0], part, name if len(names) > 1 else "")
        _draw_indices(line[1], part)
        if has_tornado:
            _draw_tornado(line[2], part)
    if not titled:
        return figure
    joiner = ", " if "first_order_of_motions" in results else " × "
    condition = (
        f"{counted(results.sizes['sample'], 'sample')}{joiner}{results.attrs['motions']}; bounds of "
        f"{percent_words(float(results.attrs['confidence']))} over recordings and samples"
    )
    shares = " ".join(dict.fromkeys(filter(None, map(indices_words, interfaces))))
    condition = f"{condition}. {shares}" if shares else condition
    title(figure, "; ".join(map(_finding, interfaces)), condition, note)
    return figure


def _finding(part: xr.Dataset) -> str:
    """The verdict on the gap of one interface, with P(contact)."""
    name, word = plain(str(part["interface"].item())), str(part["verdict"].item())
    gap, share = say_in(float(part["judged_gap"]), "mm", 3), share_words(float(part["judged_probability"]))
    return f"{name}: {gap} is {VERDICT_WORDS.get(word, word)}, P(contact) over samples and motions {share}"


def _draw_contact(axis: Any, part: xr.Dataset, name: str) -> None:
    """Draw P(contact) against the gap: samples as bands, all together with bounds, and all numbers at their medians."""
    gaps, colour = 1e3 * part["gap"].values, MEANING["motions"]
    bands = BANDS if "contact_probability_of_samples" in part else ()  # none where each sample has one motion
    for low, high, depth in bands:
        ends = [part["contact_probability_of_samples"].sel(sample_percentile=end).values for end in (low, high)]
        label = f"{low:g} to {high:g} % of samples"
        axis.fill_between(gaps, *ends, color=colour, alpha=depth, linewidth=0.0, label=label)
    axis.plot(gaps, part["contact_probability"], "-", color=colour, linewidth=2.0, label="samples and motions")
    for end, label in (("_low", "bounds of these"), ("_high", "")):
        axis.plot(gaps, part[f"contact_probability{end}"], ":", color=colour, linewidth=1.2, label=label)
    if "closing_at_medians" in part:
        closing = part["closing_at_medians"].values
        at_medians = [(closing > gap).mean() for gap in part["gap"].values]
        axis.plot(gaps, at_medians, "--", color=STYLES[1][0], linewidth=1.3, label="all numbers at their medians")
    axis.axvline(1e3 * float(part["judged_gap"]), color=MEANING["gap"], linewidth=1.0, label="gap judged")
    axis.axhline(float(part.attrs["target"]), color=MEANING["target"], linestyle="-.", linewidth=1.0, label="target")
    axis.set_xlim(0.0, gaps[-1])
    axis.set_ylim(0.0, 1.0)
    axis.yaxis.set_major_formatter(lambda share, _: f"{100 * share:.0f} %")
    axis.set_xlabel("nominal gap, without its scatter [mm]" if gap_scatter(part) > 0.0 else "gap [mm]")
    axis.set_ylabel("P(contact)")
    axis.set_title(f"contact{f', {plain(name)}' if name else ''}", fontsize=9.5)
    legend_under(axis, 2)


def _order_drawn(values: Any) -> list[int]:
    """Places of the numbers that are drawn, the least important first, so that the largest stands on top."""
    order = np.argsort(-np.nan_to_num(values, nan=-1.0), kind="stable")[:MOST_NUMBERS]
    return [int(place) for place in order[::-1]]


def _draw_indices(axis: Any, part: xr.Dataset) -> None:
    """Draw first-order shares as bars, and total ones where they are known, with bounds."""
    output = str(part["chosen_output"].item())
    one = part.sel(output=output)
    if "first_order_of_motions" in one:  # beside the numbers, as one of them
        with_motion = {
            name: ("uncertain_number", np.append(one[name], one[name.replace("first_order", "first_order_of_motions")]))
            for name in ("first_order", "first_order_low", "first_order_high")
        }
        labels = [*map(str, one["uncertain_number"].values), "the motion"]
        one = type(one)(with_motion, {"uncertain_number": labels})
    words = OUTPUT_WORDS.get(output, output.replace("_", " "))
    if not np.isfinite(one["first_order"].values).any():
        axis.set(xticks=[], yticks=[])
        few_text = f"no shares of the variance from so few samples: {LEAST_SAMPLES} or more"
        is_varying = float(part["output_deviation"].sel(output=output)) > 0.0
        return message(axis, few_text if is_varying else f"{words} does not vary over the samples")
    names = one["uncertain_number"].values
    order = _order_drawn(one["first_order"].values)
    kinds = [("first_order", FIRST, "", "first-order")]
    if "total_order" in part:
        kinds.append(("total_order", TOTAL, "///", "total"))
    width = 0.8 / len(kinds)
    for number, (kind, colour, hatch, label) in enumerate(kinds):
        value, low, high = (one[f"{kind}{end}"].values[order] for end in ("", "_low", "_high"))
        heights = np.arange(len(order)) + width * ((len(kinds) - 1) / 2.0 - number)
        axis.barh(heights, value, width * 0.9, color=colour, hatch=hatch, edgecolor="white", label=label)
        ends = np.clip([value - low, high - value], 0.0, None)
        axis.errorbar(value, heights, xerr=ends, fmt="none", color="black", linewidth=1.0, capsize=2.5)
    low, high = axis.get_xlim()
    shares = [share for kind, *_ in kinds for share in one[kind].values if np.isfinite(share)]
    axis.set_xlim(max(low, min([LEAST_SHOWN, *shares])), min(high, max([MOST_SHOWN, *shares])))
    axis.set_yticks(range(len(order)), [_label(names[place]) for place in order], fontsize=8)
    axis.axvline(0.0, color=QUIET, linewidth=0.8)
    axis.xaxis.set_major_formatter(lambda share, _: f"{100 * share:.0f} %")
    axis.set_xlabel("share of the variance over the samples")
    if len(kinds) > 1:
        legend_under(axis, 2)
    shares_text = "first-order and total shares" if len(kinds) > 1 else "first-order shares"
    axis.set_title(f"{shares_text} of {words}, with bounds", fontsize=9.5)


def _label(name: Any) -> str:
    """An address on two lines where it is long: the table and its name on the first, the key on the second."""
    keys = plain(str(name)).split(".")
    table_parts = min(len(keys) - 1, 2)
    if len(str(name)) <= 16 or not table_parts:
        return ".".join(keys)
    return ".".join(keys[:table_parts]) + "\n" + ".".join(keys[table_parts:])


def _draw_tornado(axis: Any, part: xr.Dataset) -> None:
    """Draw an output with each number alone from its 10 % to its 90 % quantile."""
    output = str(part["chosen_output"].item())
    name = output if f"{output}_moved" in part else "required_gap"
    moved_output = part[f"{name}_moved"]
    values, unit = moved_output.values, str(moved_output.attrs["units"])
    scale, middle, words = 1e3 if unit == "m" else 1.0, float(values[0, 1]), OUTPUT_WORDS.get(name, name)
    at = (say_in(middle, "mm", 3) if middle > LEAST_GAP else "less than 0.01 mm") if unit == "m" else f"{middle:.3g}"
    at = f"{100 * middle:.3g} %" if name == "contact_probability" else at
    if not np.ptp(values) > (LEAST_GAP if unit == "m" else 0.0):
        axis.set(xticks=[], yticks=[])
        return message(axis, f"each number alone leaves {words} at {at}")
    order = _order_drawn(np.ptp(values, axis=1))
    middle *= scale
    for place, number in enumerate(order):
        # One above the other: both ends may lie on one side of the median.
        for end, offset, colour, hatch in ((0, 0.18, STYLES[4][0], ""), (2, -0.18, STYLES[1][0], "///")):
            reach = scale * values[number, end] - middle
            axis.barh(place + offset, reach, 0.34, left=middle, color=colour, hatch=hatch, edgecolor="white")
    for colour, hatch, label in ((STYLES[4][0], "", "at its 10 % quantile"), (STYLES[1][0], "///", "at its 90 %")):
        axis.barh([np.nan], [0.0], color=colour, hatch=hatch, edgecolor="white", label=label)
    axis.axvline(middle, color="black", linewidth=1.0)
    axis.set_ylim(-0.6, len(order) - 0.4)
    axis.margins(x=0.08)
    axis.locator_params(axis="x", nbins=5)
    axis.set_yticks(range(len(order)), [_label(part["uncertain_number"].values[place]) for place in order], fontsize=8)
    axis.set_xlabel(f"{words} [mm]" if unit == "m" else words)
    if name == "contact_probability":
        axis.xaxis.set_major_formatter(lambda share, _: f"{100 * share:.3g} %")
    axis.set_title(f"each number alone; all at their medians: {at}", fontsize=9.5)
    legend_under(axis, 2)
