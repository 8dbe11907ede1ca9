"""Figure of a comparison of contact models along an axis of numbers of the scene."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk.errors import PoundingError
from pounding_risk.figures.along import is_number, label_side, shown_values
from pounding_risk.figures.compare import JUDGED, PANELS, ratio_limits, ratio_ticks, terms_words
from pounding_risk.figures.style import QUIET, STYLES, blank, plain, styles, title
from pounding_risk.results.scene_axes import axes_of, open_axes
from pounding_risk.scene.scene_axis import SceneAxis
from pounding_risk.studies.compare_along import along_finding, check_drawn, is_along, widest_along
from pounding_risk.studies.compare_findings import (
    LOW,
    NOTABLE,
    furthest,
    index_of_interface,
    interface_names,
    of_interface,
    peers,
    reach,
    times_words,
    with_terms_of_its_own,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

MARKERS = "os^D"  # of laws that share a style, which repeat after six
MOST_SHADED = 4  # laws whose ranges are all drawn; of more that of the one which goes furthest
MOST_MARKED = 12  # places along an axis that are marked on a line


def agreement_along_figure(dataset: xr.Dataset, note: str = "", interface: str | None = None) -> Figure:
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
    names = interface_names(dataset)
    index = widest_along(dataset) if interface is None else index_of_interface(names, interface)
    others = {one.name: 0 for one in axes_of(dataset) if one.name != axis.name and one.name in dataset.dims}
    part = of_interface(dataset.isel(others), index)
    drawn = Drawn(part, axis, _looks(part, axis.name))
    figure, panels = blank(2, 3, (14.5, 7.4))
    limits = drawn.limits()
    for panel, words in zip(panels.flat, PANELS, strict=False):
        drawn.ratios(panel, words, limits)
    drawn.flips(panels[1, 1])
    drawn.contacts(panels[1, 2])
    for panel in panels.flat:
        drawn.label(panel)
    panels[0, 2].legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.01, 1.02), frameon=False, handlelength=3.4)
    runs = part["impact_count"].size // part.sizes["contact_model"] // part.sizes[axis.name]
    where = f"interface {names[index]} of {len(names)}" if len(names) > 1 else ""
    caption = (
        f"{dataset.attrs['title']}; {counted(runs, 'case')} a law at each place; same {terms_words(dataset)} at each; "
        f"ratios to {dataset.attrs['baseline']}: median, shaded {LOW:g}-{100 - LOW:g} % of the cases with contact"
        f"{'' if drawn.shades_all else ', of the law that goes furthest'}"
    )
    title(figure, plain(along_finding(dataset)), plain("; ".join(filter(None, (where, caption)))), note)
    return figure


class Look(NamedTuple):
    """How the line of a law looks; that of one which cannot be on equal terms is thin."""

    colour: str
    dash: Any
    marker: str = "o"
    is_equal: bool = True


def _looks(part: xr.Dataset, axis: str) -> dict[str, Look]:
    """The look of every law beside the baseline."""
    names = [str(name) for name in part["contact_model"].values if str(name) != part.attrs["baseline"]]
    equal = {name for place in range(part.sizes[axis]) for name in peers(part.isel({axis: place}))}
    return {
        name: Look(colour, dash, MARKERS[number // len(STYLES) % len(MARKERS)], name in equal)
        for number, (name, (colour, dash)) in enumerate(zip(names, styles(len(names)), strict=True))
    }


class Drawn(NamedTuple):
    """A comparison of one interface along one axis, and how each law is drawn."""

    part: xr.Dataset
    axis: SceneAxis
    looks: dict[str, Look]

    @property
    def labels(self) -> xr.Dataset:
        """The values along the axis, and of what moves with it."""
        own = self.part[list(self.axis.keys)]
        return own.drop_vars([name for name in own.coords if name not in self.axis.keys])

    def label(self, panel: Any) -> None:
        """Name the axis below a panel with its unit."""
        label_side(panel, "x", self.labels, self.axis.name)
        panel.tick_params(labelsize=8.5)

    def line(self, panel: Any, values: xr.DataArray, look: Look, label: str = "") -> None:
        """Draw values along the axis; of texts, which have no order, the points alone."""
        places, _ = shown_values(self.labels, self.axis.name)
        is_ordered = is_number(self.labels, self.axis.name)
        marker = look.marker if len(places) <= MOST_MARKED or not is_ordered else ""
        dash = look.dash if is_ordered else ""
        style = {"linestyle": dash, "marker": marker, "markersize": 4, "linewidth": 1.6 if look.is_equal else 0.8}
        panel.plot(places, values, color=look.colour, label=label, **style)

    def limits(self) -> tuple[float, float]:
        """Ends of the scale of all panels of ratios; a law with terms of its own may lie beyond."""
        shown = self.part.isel(contact_model=~with_terms_of_its_own(self.part))
        outputs = [self._output(words) for words in PANELS]
        medians = shown["ratio_median"].sel(output=outputs).values.ravel()
        ranges = [self.part.sel(output=output, contact_model=self._shaded(output)) for output in outputs]
        lows, highs = ([one[f"ratio_{end}"].values.ravel() for one in ranges] for end in ("low", "high"))
        return ratio_limits(np.concatenate([medians, *lows]), np.concatenate([medians, *highs]))

    @property
    def shades_all(self) -> bool:
        """Whether the ranges of all laws on equal terms are drawn."""
        return sum(look.is_equal for look in self.looks.values()) <= MOST_SHADED

    def _shaded(self, output: str) -> list[str]:
        """The laws whose range over the cases is drawn."""
        equal = [name for name, look in self.looks.items() if look.is_equal]
        return equal if self.shades_all else [self._most(output)[0]]

    def ratios(self, panel: Any, words: str, limits: tuple[float, float]) -> None:
        """Draw the median ratios of one output under every law, and the range of those that are told apart."""
        output = self._output(words)
        panel.axhspan(1.0 - NOTABLE, 1.0 + NOTABLE, color="#e4e4e4", linewidth=0.0, zorder=0)
        panel.axhline(1.0, color="black", linewidth=1.6, label=f"{self.part.attrs['baseline']}, the baseline")
        shaded = self._shaded(output)
        for name, look in self.looks.items():
            cell = self.part.sel(output=output, contact_model=name)
            if name in shaded:
                self._range(panel, cell, look)
            self.line(panel, cell["ratio_median"], look, name if look.is_equal else f"{name}, not on equal terms")
        panel.set_yscale("log")
        panel.set_ylim(limits)
        beyond = "\n".join(self._beyond(output, limits))
        panel.text(0.98, 0.97, beyond, transform=panel.transAxes, ha="right", va="top", fontsize=8, color=QUIET)
        ticks = ratio_ticks(limits)
        panel.set_yticks(ticks, labels=[f"{tick:g}" for tick in ticks])
        panel.minorticks_off()
        panel.set_title(output, fontsize=9.5)
        panel.set_ylabel("over the baseline's [1]", fontsize=9)

    def _beyond(self, output: str, limits: tuple[float, float]) -> Iterator[str]:
        """The laws whose medians leave the scale, and how far they go."""
        for name in self.looks:
            medians = self.part["ratio_median"].sel(output=output, contact_model=name)
            low, high = float(medians.min()), float(medians.max())
            if high > limits[1] or low < limits[0]:
                yield f"beyond: {name}, {times_words(low, high)}"

    def _range(self, panel: Any, cell: xr.Dataset, look: Look) -> None:
        places, _ = shown_values(self.labels, self.axis.name)
        ends = cell["ratio_low"], cell["ratio_high"]
        if is_number(self.labels, self.axis.name):
            panel.fill_between(places, *ends, color=look.colour, alpha=0.13, linewidth=0.0)
        else:
            panel.vlines(places, *ends, color=look.colour, linewidth=2.4, alpha=0.4)

    def _output(self, words: str) -> str:
        """The output of a panel; of one known by building that of the building where the laws go furthest."""
        known = [str(name) for name in self.part["output"].values if str(name).partition(",")[0] == words]
        return max(known, key=lambda output: reach(*self._most(output)[1:]))

    def _most(self, output: str) -> tuple[str, float, float]:
        """(law, its range) where an output is moved furthest at any place, of the laws that the finding is about."""
        at = [self.part.isel({self.axis.name: place}) for place in range(self.part.sizes[self.axis.name])]
        ranges = [furthest(one, output, peers(one) or list(self.looks)) for one in at]
        return max(ranges, key=lambda one: reach(*one[1:]))

    def flips(self, panel: Any) -> None:
        """Draw in which share of the cases the peak relative displacement is another."""
        conclusion, words = JUDGED[0]
        of_conclusion = self.part.sel(conclusion=conclusion)
        share = 100.0 * of_conclusion["flips"] / of_conclusion["judged"].where(of_conclusion["judged"] > 0)
        for name, look in self.looks.items():
            self.line(panel, share.sel(contact_model=name), look)
        panel.set_ylim(0.0, 1.12 * max(10.0, float(share.max()) if share.notnull().any() else 0.0))
        panel.set_title(words, fontsize=9.5)
        panel.set_ylabel("share of the cases with contact [%]", fontsize=9)

    def contacts(self, panel: Any) -> None:
        """Draw how many cases have contact under the baseline: over how many the ratios are."""
        baseline = str(self.part.attrs["baseline"])
        count = self.part["judged"].sel(conclusion="displacement", contact_model=baseline)
        self.line(panel, count, Look("black", "-"))
        panel.set_ylim(0.0, 1.12 * max(1.0, float(count.max())))
        panel.locator_params(axis="y", integer=True)
        panel.set_title(f"cases with contact under {baseline}", fontsize=9.5)
        panel.set_ylabel("number of cases [1]", fontsize=9)
