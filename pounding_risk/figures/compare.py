"""Figures of a comparison of contact models: at one place, along an axis of the scene, and of the reference impacts."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from pounding_risk._common.counted import counted
from pounding_risk.errors import PoundingError
from pounding_risk.figures import style
from pounding_risk.figures.along import is_number, label_side, shown_values
from pounding_risk.render.sheet import amount
from pounding_risk.results.scene_axes import at_one_place, axes_of, open_axes
from pounding_risk.studies import compare_findings as findings
from pounding_risk.studies.compare_along import along_finding, check_drawn, is_along, widest_along
from pounding_risk.units import say_in

Laws = list[tuple[str, str]]  # (name, kind), from the top down
# Colour, marker and dash of a kind of law.
KINDS = {
    "dissipates": ("#0072B2", "o", "-"),
    "dissipates, yields": ("#009E73", "s", "-."),
    "elastic": ("#D55E00", "^", (0, (4, 2))),
    "e and force its own": ("#CC79A7", "D", (0, (1, 1))),
}
PANELS = ("peak relative displacement", "peak contact force", "impact count", "peak floor acceleration")
RANKED = (("peak relative displacement", "displacement"), ("peak contact force", "force"))
JUDGED = (
    ("displacement", f"displacement off by > {100 * findings.NOTABLE:.0f} %"),
    ("yield exceedance", "yielding or not"),
)
TICKS = (0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0, 5.0, 10.0)
WIDE_TICKS = (0.1, 0.3, 1.0, 3.0, 10.0)
FEWEST_TICKS, MOST_TICKS = 3, 6  # more labels than that run into each other in the panels
STEPS = (0.4, 0.2, 0.1)  # of ticks about 1; the axis has three of the second, as it reaches 0.2 to both sides
SHOWN = 10.0  # s of a history, about the moment at which the laws differ most
ROW_HEIGHT = 0.36  # inches of a law in the panels above
FEWEST_ROWS = 4  # that these panels have room for, so that their titles and ticks do not meet
FAMILIES = {"N/m": "k", "N/m^1.5": "β"}  # letters of stiffness by its unit
MARKERS = "os^D"  # along an axis, of laws that share a style, which repeat after six
MOST_SHADED = 4  # laws whose ranges are all drawn along an axis; of more laws only the widest range
MOST_MARKED = 12  # places along an axis that are marked on a line


def agreement_figure(dataset: xr.Dataset, note: str = "", interface: str | None = None) -> style.Figure:
    """Contact models against the baseline: ratios of outputs, changed conclusions, ranks, and one typical history.

    Parameters
    ----------
    dataset : xarray.Dataset
        A dataset of `compare`.
    note : str
        Added to the caption.
    interface : str, optional
        Which interface of a row is drawn, "left | right"; by default the one where the laws move the peak relative
        displacement most. The history is that one's in any case.

    Returns
    -------
    matplotlib.figure.Figure
        Four panels of ratios, one of conclusions, one of ranks; below the history, where the dataset has one: that of a
        place which was selected along axes of numbers of the scene has none.

    Raises
    ------
    PoundingError
        For a dataset with several places along axes of numbers of its scene, and an interface that it has not.
    """
    interface_text, dataset = _at_interface(dataset, interface)
    laws = _laws(dataset)
    height = ROW_HEIGHT * max(len(laws), FEWEST_ROWS)
    heights = (height, 2.4) if "history" in dataset else (height,)
    figure, axes = style.blank(len(heights), 6, (15.0, 1.2 + sum(heights)), height_ratios=heights)
    # A law with terms of its own may lie beyond the scale.
    part = dataset.isel(output=[str(name).partition(",")[0] in PANELS for name in dataset["output"].values])
    part = part.isel(contact_model=~findings.with_terms_of_its_own(dataset))
    limits = ratio_limits(part["ratio_low"].values, part["ratio_high"].values)
    for axis, panel in zip(axes[0, :4], PANELS, strict=True):
        _draw_ratios(axis, dataset, panel, (laws, limits))
        style.logarithmic(axis, "x", *limits, ratio_ticks(limits))  # one scale: what hardly moves looks so
    _draw_flips(axes[0, 4], dataset, laws)
    _draw_ranks(axes[0, 5], dataset, laws)
    for axis in axes[0, 1:]:
        axis.tick_params(labelleft=False)
    e_achieved = dict(zip(dataset["contact_model"].values, dataset["reference_restitution"].values, strict=True))
    labels = [name if np.isnan(e_achieved[name]) else f"{name}, e {e_achieved[name]:.2f}" for name, _ in laws]
    axes[0, 0].set_yticks(range(len(laws)), labels, fontsize=9)
    axes[0, 0].get_yticklabels()[0].set_fontweight("bold")
    if "history" in dataset:
        _draw_history(style.joined(figure, axes[1]), dataset, laws)
    cases = counted(dataset["impact_count"].size // len(laws), "case")
    terms = (
        f"{dataset.attrs['title']}; {cases} a law; same {terms_words(dataset)}; "
        f"ratios: median and {findings.LOW:g}-{100 - findings.LOW:g} % of the cases with contact"
    )
    style.title(figure, str(dataset.attrs["finding"]), "; ".join(filter(None, (interface_text, terms))), note)
    return figure


def _at_interface(dataset: xr.Dataset, interface: str | None) -> tuple[str, xr.Dataset]:
    """Words on the interface that is drawn, and its part of a comparison at one place."""
    dataset = at_one_place(dataset, "the comparison")
    index = findings.place_of_interface(dataset, interface)
    interface_text = findings.which_interface(dataset, index)
    return interface_text and f"At {interface_text}", findings.of_interface(dataset, index)


def _laws(dataset: xr.Dataset) -> Laws:
    """Laws in the order of the figure: the baseline, then by kind, in the dataset's order within a kind."""
    baseline = str(dataset.attrs["baseline"])
    laws = []
    names = map(str, dataset["contact_model"].values)
    facts = dataset["dissipates"].values, dataset["capped"].values, findings.with_terms_of_its_own(dataset)
    for name, is_damped, is_capped, is_own in zip(names, *facts, strict=True):
        kind = "elastic" if not is_damped else "dissipates, yields" if is_capped else "dissipates"
        laws.append((name, "e and force its own" if is_own else kind))
    return sorted(laws, key=lambda law: (law[0] != baseline, list(KINDS).index(law[1])))


def terms_words(dataset: xr.Dataset) -> str:
    """The terms on which laws are equal in the reference impact, and its speed, where it is one speed."""
    e_text = "e and " if dataset.attrs.get("restitution_relation") == "exact" else ""
    speed = f" at {dataset.attrs['speed']:g} m/s" if "speed" in dataset.attrs else ""
    return f"{e_text}{dataset.attrs['same']}{speed} as {dataset.attrs['reference_law']}"


def _set_up_rows(axis: Any, laws: Laws, words: str, x_label: str) -> None:
    """Set up a panel that has a row for each law."""
    axis.set_ylim(len(laws) - 0.5, -0.5)
    axis.set_yticks(range(len(laws)))
    axis.set_title(words, fontsize=9.5)
    axis.set_xlabel(x_label, fontsize=9)
    axis.tick_params(axis="x", labelsize=8.5)


def ratio_limits(lows: ArrayLike, highs: ArrayLike) -> tuple[float, float]:
    """Ends of a scale on which ratios are shown: within 0.1 to 10, and not closer to 1 than twice `NOTABLE`."""
    low = float(np.nanmin(lows, initial=1.0 - 2.0 * findings.NOTABLE))
    high = float(np.nanmax(highs, initial=1.0 + 2.0 * findings.NOTABLE))
    return max(low, TICKS[0]) / 1.06, min(high, TICKS[-1]) * 1.06


def ratio_ticks(limits: tuple[float, float]) -> list[float]:
    """Ticks between two ends: of `TICKS`, of `WIDE_TICKS` for wide scales, or in round steps close to 1."""
    ticks = [tick for tick in TICKS if limits[0] <= tick <= limits[1]]
    if len(ticks) > MOST_TICKS:
        return [tick for tick in ticks if tick in WIDE_TICKS]
    if len(ticks) >= FEWEST_TICKS:
        return ticks
    for step in STEPS:
        ticks = [round(1.0 + number * step, 1) for number in range(-9, 10)]
        ticks = [tick for tick in ticks if limits[0] <= tick <= limits[1]]
        if len(ticks) >= FEWEST_TICKS:
            break
    return ticks


def _draw_ratios(axis: Any, dataset: xr.Dataset, panel: str, laws_and_limits: tuple[Laws, tuple[float, float]]) -> None:
    """Draw median and range of the ratios of one output; of an output by building, the right building's below, open.

    ``shown`` = (laws, ends of the scale); a median beyond them stands at the edge as a number.
    """
    laws, limits = laws_and_limits
    outputs = [str(name) for name in dataset["output"].values if str(name).partition(",")[0] == panel]
    _set_up_rows(axis, laws, panel, "over the baseline's [1]")
    axis.axvspan(1.0 - findings.NOTABLE, 1.0 + findings.NOTABLE, color="#e4e4e4", linewidth=0.0, zorder=0)
    axis.axvline(1.0, color="black", linewidth=0.9)
    for row, (name, kind) in enumerate(laws):
        colour, marker, _ = KINDS[kind]
        for number, output in enumerate(outputs):
            cell = dataset.sel(output=output, contact_model=name)
            low, middle, high = (float(cell[f"ratio_{part}"]) for part in ("low", "median", "high"))
            if np.isnan(middle):
                continue
            height = row + (number - 0.5 * (len(outputs) - 1)) * 0.32
            if not limits[0] <= middle <= limits[1]:
                edge = (0.98, "right") if middle > limits[1] else (0.02, "left")
                look = {"transform": axis.get_yaxis_transform(), "ha": edge[1], "va": "center", "fontsize": 8.5}
                axis.text(edge[0], height, f"{middle:.2g}", color=colour, **look)
                continue
            axis.plot([low, high], [height, height], color=colour, linewidth=2.4 if number == 0 else 1.3)
            for end, is_cut, mark in ((limits[0], low < limits[0], "<"), (limits[1], high > limits[1], ">")):
                if is_cut:  # the range goes on beyond the scale
                    axis.plot(end, height, mark, color=colour, markersize=6.0, clip_on=False)
            face = colour if number == 0 else "white"
            axis.plot(middle, height, marker, color=colour, markerfacecolor=face, markersize=5.5, zorder=4)
    if len(outputs) > 1:
        for output, face in zip(outputs, ("black", "white"), strict=True):
            name = style.in_lines(
                output.partition(", ")[2], style.NAME_LINE
            )  # a longer one would take the panels' room
            axis.plot([], [], "o", color="black", markerfacecolor=face, label=name)
        style.legend_under(axis, 1)


def _draw_flips(axis: Any, dataset: xr.Dataset, laws: Laws) -> None:
    """Draw the share of the cases in which a law leads to another conclusion than the baseline."""
    _set_up_rows(axis, laws, "conclusions that flip", "share of the cases [%]")
    names = [name for name, _ in laws]
    largest = 10.0
    for number, (conclusion, words) in enumerate(JUDGED):
        shares = 100.0 * findings.flip_share(dataset, conclusion, names)
        hatch, shade = (("", "#777777"), ("////", "white"))[number]
        heights = np.arange(len(laws)) + (number - 0.5) * 0.36
        axis.barh(heights, np.nan_to_num(shares), 0.32, color=shade, edgecolor="#444444", hatch=hatch, label=words)
        largest = max(largest, float(np.nanmax(shares, initial=0.0)))
    axis.set_xlim(0.0, 1.12 * largest)
    style.legend_under(axis, 1)


def _draw_ranks(axis: Any, dataset: xr.Dataset, laws: Laws) -> None:
    """Draw Spearman's correlation of the motions' ranks with the baseline's."""
    _set_up_rows(axis, laws, "motions ranked alike", "Spearman's correlation [1]")
    for number, (output, words) in enumerate(RANKED):
        values = dataset["rank_agreement"].sel(output=output, contact_model=[name for name, _ in laws]).values
        heights = np.arange(len(laws)) + (number - 0.5) * 0.3
        face = ("black", "white")[number]
        axis.plot(values, heights, "od"[number], color="black", markerfacecolor=face, markersize=5.5, label=words)
    ranks = dataset["rank_agreement"].sel(output=[output for output, _ in RANKED]).values
    if np.isnan(ranks).all():
        style.message(axis, "not ranked: fewer than three motions with contact", 14)
    lowest = min(0.8, float(np.nanmin(ranks, initial=1.0)) - 0.05)
    axis.set_xlim(lowest, 1.0 + 0.05 * (1.0 - lowest))
    style.legend_under(axis, 1)


def _draw_history(axis: Any, dataset: xr.Dataset, laws: Laws) -> None:
    """Draw the relative displacement of one case under every law, where they differ most; the baseline in black."""
    history = dataset["history"]
    facts, baseline = history.attrs, findings.place_of(dataset, str(dataset.attrs["baseline"]))
    time, values = dataset["time"].values, history.values * 1e3
    difference = np.nanmax(np.abs(values - values[baseline]), axis=0)
    start = min(max(time[int(difference.argmax())] - 0.4 * SHOWN, 0.0), max(time[-1] - SHOWN, 0.0))
    is_shown = (time >= start) & (time <= start + SHOWN)
    labelled_kinds: set[str] = set()
    for name, kind in laws[1:]:
        row, (colour, _, dash) = findings.place_of(dataset, name), KINDS[kind]
        label = "" if kind in labelled_kinds else kind
        labelled_kinds.add(kind)
        axis.plot(time[is_shown], values[row, is_shown], color=colour, linestyle=dash, linewidth=1.0, label=label)
    axis.plot(time[is_shown], values[baseline, is_shown], color="black", linewidth=1.8, label=laws[0][0], zorder=2.5)
    low, high = axis.get_ylim()
    axis.set_ylim(low, high + 0.22 * (high - low))  # room for the legend
    axis.axhline(facts["gap"] * 1e3, color=style.QUIET, linestyle=":", linewidth=1.2, label="gap")
    axis.set(xlabel="time [s]", ylabel="relative\ndisplacement [mm]", xlim=(start, min(start + SHOWN, time[-1])))
    peaks = np.nanmax(np.abs(values), axis=1)
    case = (
        f"gap {say_in(facts['gap'], 'mm', 6)}, {style.force_words(facts['yield_force'])}, {style.motion_words(facts)}"
    )
    point = str(facts.get("contact_point", ""))
    place_text = "Peaks" if point == facts.get("interface", "") else f"{facts['interface']}, floors {point}: peaks"
    words = f"{place_text} of {peaks.min():.1f} to {peaks.max():.1f} mm in a case of median spread: {case}"
    axis.set_title(f"{words}; where laws differ most", fontsize=9.5)
    axis.legend(fontsize=8, loc="upper right", ncols=len(labelled_kinds) + 2, handlelength=2.6)


def reference_figure(dataset: xr.Dataset, note: str = "", interface: str | None = None) -> style.Figure:
    """Force against time and against penetration of the reference impact, one row for each unit of stiffness.

    Parameters
    ----------
    dataset : xarray.Dataset
        A dataset of `compare`.
    note : str
        Added to the caption.
    interface : str, optional
        The interface of a row whose impact is drawn, as in `agreement_figure`.

    Returns
    -------
    matplotlib.figure.Figure
        Two panels a row.

    Raises
    ------
    PoundingError
        As `agreement_figure`.
    """
    which, dataset = _at_interface(dataset, interface)
    names = [str(name) for name in dataset["contact_model"].values]
    units = [unit for unit in FAMILIES if unit in dataset["stiffness_unit"].values]
    figure, axes = style.blank(len(units), 2, (11.5, 1.4 + 3.3 * len(units)), sharex="col", sharey=True)
    for row, unit in enumerate(units):
        law_indices = [index for index in range(len(names)) if dataset["stiffness_unit"].values[index] == unit]
        widths = np.linspace(3.2, 1.4, len(law_indices))  # lines that lie on one another show: the first is the widest
        for index, width, (colour, dash) in zip(law_indices, widths, style.styles(len(law_indices)), strict=True):
            law = dataset.isel(contact_model=index)
            look = {"color": colour, "linestyle": dash, "linewidth": width}
            force = law["impact_force"].values / 1e6
            stiffness = amount(law["stiffness"], unit)["text"].replace("^1.5", "$^{1.5}$")
            label = f"{names[index]}{'' if int(law['dissipates']) else ', elastic'}\n"
            label += f"{FAMILIES[unit]} = {stiffness}, e {float(law['reference_restitution']):.3f}"
            axes[row, 0].plot(law["impact_time"].values * 1e3, force, label=label, **look)
            axes[row, 1].plot(law["impact_penetration"].values * 1e3, force, **look)
        axes[row, 0].set_ylabel("contact force [MN]")
        axes[row, 1].legend(*axes[row, 0].get_legend_handles_labels(), fontsize=8, loc="center left",
                            bbox_to_anchor=(1.01, 0.5), frameon=False, handlelength=3.0)  # fmt: skip
    axes[-1, 0].set_xlabel("time since the touch [ms]")
    axes[-1, 1].set_xlabel("penetration [mm]")
    forceless = [name for name, unit in zip(names, dataset["stiffness_unit"].values, strict=True) if unit not in units]
    without_force = f"{', '.join(forceless)}: no force against penetration" if forceless else ""
    blow = (
        f"{say_in(float(dataset['reduced_mass']), 't')} against a wall, same {terms_words(dataset)}, without yielding"
    )
    curves = dataset.isel(contact_model=np.isin(dataset["stiffness_unit"].values, units))
    style.title(figure, _reference_finding(curves), "; ".join(filter(None, (which, blow, without_force))), note)
    return figure


def _reference_finding(dataset: xr.Dataset) -> str:
    """Sentence on the equal terms of the laws, their differences, and the restitution achieved."""
    name, scale, words, unit = "reference_peak_penetration", 1e3, "penetration", "mm"
    if dataset.attrs["same"] == "penetration":
        name, scale, words, unit = "reference_peak_force", 1e-6, "peak force", "MN"
    damped = dataset.isel(contact_model=np.flatnonzero(dataset["dissipates"].values))
    low, high = (scale * float(dataset[name].reduce(edge)) for edge in (np.nanmin, np.nanmax))
    finding = f"Same {dataset.attrs['same']}, but {words} from {low:.3g} to {high:.3g} {unit}"
    if not damped.sizes["contact_model"]:
        return finding
    e, required = damped["reference_restitution"].values, float(damped["reference_restitution_asked"].max())
    if np.nanmax(np.abs(e - required)) < 5e-4:
        return f"{finding}; e {required:.3g}, as required, of all laws that take one"
    return f"{finding}; e achieved {np.nanmin(e):.3f} to {np.nanmax(e):.3f} where {required:.3g} is required"


def agreement_along_figure(dataset: xr.Dataset, note: str = "", interface: str | None = None) -> style.Figure:
    """Contact models against the baseline along one axis of numbers of the scene: a line for each model.

    Parameters
    ----------
    dataset : xarray.Dataset
        A dataset of `compare` with several places along one such axis; of others one value is selected.
    note : str
        Added to the caption.
    interface : str, optional
        Which interface of a row is drawn, "left | right"; by default the one where the laws move the peak relative
        displacement most at any place.

    Returns
    -------
    matplotlib.figure.Figure
        Four panels of ratios with their range over the cases, one of conclusions, one of the cases with contact.

    Raises
    ------
    PoundingError
        For a dataset with one place, or with several along more than one axis, and an interface that it has not.
    """
    if not is_along(dataset):
        raise PoundingError("the comparison has one place along axes of numbers; draw it with agreement_figure")
    check_drawn(open_axes(dataset), "figure")
    (axis,) = open_axes(dataset)
    names = findings.interface_names(dataset)
    index = widest_along(dataset) if interface is None else findings.index_of_interface(names, interface)
    other_places = {item.name: 0 for item in axes_of(dataset) if item.name != axis.name and item.name in dataset.dims}
    part = findings.of_interface(dataset.isel(other_places), index)
    labels = part[list(axis.keys)]
    labels = labels.drop_vars([name for name in labels.coords if name not in axis.keys])
    figure, panels = style.blank(2, 3, (14.5, 7.4))
    all_shaded = _draw_ratios_along(panels.flat[:4], part, labels, axis.name)
    baseline = str(dataset.attrs["baseline"])
    conclusion, words = JUDGED[0]
    judged = part["judged"].sel(conclusion=conclusion)
    share = 100.0 * part["flips"].sel(conclusion=conclusion) / judged.where(judged > 0)
    for name, look in _law_looks(part, axis.name).items():
        _draw_line(panels[1, 1], share.sel(contact_model=name), labels, look)
    panels[1, 1].set_ylim(0.0, 1.12 * max(10.0, float(share.max()) if share.notnull().any() else 0.0))
    panels[1, 1].set_title(words, fontsize=9.5)
    panels[1, 1].set_ylabel("share of the cases with contact [%]", fontsize=9)
    count = judged.sel(contact_model=baseline)
    _draw_line(panels[1, 2], count, labels, {"color": "black", "linestyle": "-", "marker": "o", "linewidth": 1.6})
    panels[1, 2].set_ylim(0.0, 1.12 * max(1.0, float(count.max())))
    panels[1, 2].locator_params(axis="y", integer=True)
    panels[1, 2].set_title(f"cases with contact under {baseline}", fontsize=9.5)
    panels[1, 2].set_ylabel("number of cases [1]", fontsize=9)
    for panel in panels.flat:
        label_side(panel, "x", labels, axis.name)
        panel.tick_params(labelsize=8.5)
    panels[0, 2].legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.01, 1.02), frameon=False, handlelength=3.4)
    runs = part["impact_count"].size // part.sizes["contact_model"] // part.sizes[axis.name]
    place_text = f"At interface {names[index]} of {len(names)}" if len(names) > 1 else ""
    caption = (
        f"{dataset.attrs['title']}; {counted(runs, 'case')} a law at each place; same {terms_words(dataset)} at each; "
        f"ratios to {baseline}: median, shaded {findings.LOW:g}-{100 - findings.LOW:g} % of the cases with contact"
        f"{'' if all_shaded else ', of the law that goes furthest'}"
    )
    style.title(
        figure, style.plain(along_finding(dataset)), style.plain("; ".join(filter(None, (place_text, caption)))), note
    )
    return figure


def _laws_on_equal_terms(part: xr.Dataset, axis: str) -> set[str]:
    """The laws that are on equal terms at some place."""
    return {name for place in range(part.sizes[axis]) for name in findings.comparable_laws(part.isel({axis: place}))}


def _law_looks(part: xr.Dataset, axis: str) -> dict[str, dict[str, Any]]:
    """Look of every law beside the baseline; laws that cannot be on equal terms have thin lines."""
    names = [str(name) for name in part["contact_model"].values if str(name) != part.attrs["baseline"]]
    equal, looks = _laws_on_equal_terms(part, axis), {}
    for number, (name, (colour, dash)) in enumerate(zip(names, style.styles(len(names)), strict=True)):
        marker = MARKERS[number // len(style.STYLES) % len(MARKERS)]
        width = 1.6 if name in equal else 0.8
        looks[name] = {"color": colour, "linestyle": dash, "marker": marker, "linewidth": width}
    return looks


def _draw_line(panel: Any, values: xr.DataArray, labels: xr.Dataset, look: dict[str, Any], label: str = "") -> None:
    """Draw values along the axis; along texts, which have no order, points without a line."""
    (axis,) = values.dims
    places, _ = shown_values(labels, str(axis))
    if not is_number(labels, str(axis)):
        look = look | {"linestyle": ""}
    elif len(places) > MOST_MARKED:
        look = look | {"marker": ""}
    panel.plot(places, values, label=label, markersize=4, **look)


def _draw_ratios_along(panels: Any, part: xr.Dataset, labels: xr.Dataset, axis: str) -> bool:
    """Draw median ratios of the four outputs, and ranges of laws on equal terms; returns whether all have a range.

    An output by building is drawn at the building where the laws go furthest.
    """
    looks, equal = _law_looks(part, axis), _laws_on_equal_terms(part, axis)
    all_shaded = sum(name in equal for name in looks) <= MOST_SHADED
    every_place = [part.isel({axis: place}) for place in range(part.sizes[axis])]

    def widest(output: str) -> tuple[str, float, float]:
        """(Law, its range) where an output moves furthest at any place, among the laws of the finding."""
        ranges = [findings.furthest(at, output, findings.comparable_laws(at) or list(looks)) for at in every_place]
        return max(ranges, key=lambda law_range: findings.reach(*law_range[1:]))

    shaded = {}  # laws by output
    for words in PANELS:
        outputs = [str(name) for name in part["output"].values if str(name).partition(",")[0] == words]
        output = max(outputs, key=lambda name: findings.reach(*widest(name)[1:]))
        shaded[output] = [name for name in looks if name in equal] if all_shaded else [widest(output)[0]]
    # A law with terms of its own may lie beyond the scale.
    medians = (
        part["ratio_median"]
        .isel(contact_model=~findings.with_terms_of_its_own(part))
        .sel(output=list(shaded))
        .values.ravel()
    )
    ranges = [part.sel(output=output, contact_model=laws) for output, laws in shaded.items()]
    lows, highs = ([laws[f"ratio_{end}"].values.ravel() for laws in ranges] for end in ("low", "high"))
    limits = ratio_limits(np.concatenate([medians, *lows]), np.concatenate([medians, *highs]))
    places, _ = shown_values(labels, axis)
    for panel, output in zip(panels, shaded, strict=True):
        panel.axhspan(1.0 - findings.NOTABLE, 1.0 + findings.NOTABLE, color="#e4e4e4", linewidth=0.0, zorder=0)
        panel.axhline(1.0, color="black", linewidth=1.6, label=f"{part.attrs['baseline']}, the baseline")
        beyond_texts = []
        for name, look in looks.items():
            cell = part.sel(output=output, contact_model=name)
            ends = cell["ratio_low"], cell["ratio_high"]
            if name in shaded[output] and is_number(labels, axis):
                panel.fill_between(places, *ends, color=look["color"], alpha=0.13, linewidth=0.0)
            elif name in shaded[output]:
                panel.vlines(places, *ends, color=look["color"], linewidth=2.4, alpha=0.4)
            _draw_line(panel, cell["ratio_median"], labels, look, name + ", not on equal terms" * (name not in equal))
            low, high = float(cell["ratio_median"].min()), float(cell["ratio_median"].max())
            if high > limits[1] or low < limits[0]:
                beyond_texts.append(f"beyond: {name}, {findings.times_words(low, high)}")
        words = "\n".join(beyond_texts)
        panel.text(0.98, 0.97, words, transform=panel.transAxes, ha="right", va="top", fontsize=8, color=style.QUIET)
        style.logarithmic(panel, "y", *limits, ratio_ticks(limits))
        panel.set_title(output, fontsize=9.5)
        panel.set_ylabel("over the baseline's [1]", fontsize=9)
    return all_shaded
