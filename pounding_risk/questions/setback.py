"""Setbacks from a property line: how far one building moves under the motions of a scan, without a neighbour.

Codes set a building back from a line by its own design displacement (ASCE 7 by δ_M, UBC 97 by Δ_M, Eurocode 8 by d_s);
here it is the peak of the linear model, or of what the scene's effects make of it, that motions reach.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf
from pathlib import Path

import numpy as np
import xarray as xr

from pounding_risk._common.counted import counted
from pounding_risk._common.short_repr import ShortRepr
from pounding_risk.assessment.demands import by_motion
from pounding_risk.assessment.options import NO_LOWER, NO_UPPER, USUAL_CONFIDENCE, read_criterion
from pounding_risk.errors import PoundingError
from pounding_risk.questions.adequacy import bounds_cell, enough, marks
from pounding_risk.render.sheet import Block, head, listing, number, table
from pounding_risk.results.attributes import no_response, rotating_buildings, rotating_words
from pounding_risk.results.files import open_scan
from pounding_risk.results.opened import Results
from pounding_risk.results.scene_axes import check_one_place
from pounding_risk.statistics.proportions import independent_motions, logs_of, numbered
from pounding_risk.statistics.required_gap import USUAL_PERCENTILES, RequiredGap, required_gaps
from pounding_risk.units import GAP, say

# What a setback takes for granted; stated wherever one is read.
ASSUMED = (
    "A setback is the largest displacement of any floor, relative to the building's own ground, to whichever side it "
    "is larger: it holds for a line on either side",
    "No neighbour strikes it: one that does from the other side may push it further",
    "The line moves with the ground below the building; displacements are those of these motions, not δM of a code",
)
AT_A_WALL = (
    "So no setback is given: scan it beside a [[building]] with rigid = true, to which `assess` gives the gap that the "
    "ends of its face require"
)
NO_BOUND = {
    NO_LOWER: "no lower bound above 0",
    NO_UPPER: "the upper one is the largest seen: so few recordings do not bound this percentile",
}


@dataclass(frozen=True, repr=False)
class Setback(ShortRepr):
    """Distance from a property line that one building requires, by percentile, as `RequiredGap` counts it.

    ``at`` says how strong the motions are; ``independent`` is the number of motions that they stand for, and
    ``percentile`` [%] the requested one. In ``lost`` of the motions the building has no finite displacement, as where a
    storey collapses: no setback is wide enough for them. ``note`` says of a linked building whose motion it is, and of
    one whose floors rotate why ``required`` is empty.
    """

    building: str
    at: str
    motions: int
    independent: float
    percentile: float
    required: tuple[RequiredGap, ...]
    lost: int = 0
    note: str = ""

    @property
    def distance(self) -> float:
        """The setback [m] at the requested percentile; raises PoundingError where the dataset has none."""
        if not self.required:
            raise PoundingError(self.note)
        return next(required.gap for required in self.required if required.percentile == self.percentile)

    def facts(self) -> Iterable[tuple[str, str]]:
        """Building, motions, and the setback at each percentile, as pairs of a name and words."""
        yield "building", self.building
        yield "motions", f"{counted(self.motions, 'motion')} {self.at}"
        for required in self.required:
            yield f"setback for {required.percentile:g} % of the motions", say(required.gap, GAP)
        if self.note:
            yield "note", self.note


def setbacks(
    results: xr.Dataset | str | Path,
    *,
    percentile: float | str | None = None,
    target: float | str | None = None,
    confidence: float | str = USUAL_CONFIDENCE,
    pga: float | str | None = None,
    intensity_level: float | str | None = None,
) -> tuple[Setback, ...]:
    """Setback from a property line that each building of a dataset of `scan` requires, counted as a required gap.

    The motions' displacements without contact are those of every floor; a rigid building requires none.

    Parameters
    ----------
    results : xarray.Dataset, str or Path
        A dataset of `scan`, or the file it is in.
    percentile : float or str, optional
        Share of the motions, beside 50, 84 and 95 %, as `assess` takes it.
    target : float or str, optional
        Accepted probability of crossing the line, as `assess` takes it.
    confidence : float or str
        Confidence of the bounds, above 50 %.
    pga : float or str, optional
        Amplitude of the grid [m/s2, or text with a unit]; the scene's own or the largest by default.
    intensity_level : float or str, optional
        The same for a grid of any measure.

    Returns
    -------
    tuple of Setback
        One for each building, from left to right.

    Raises
    ------
    PoundingError
        For a dataset that is none of `scan` or has more than one place along an axis, for an option out of its
        range, and where the floors of every building rotate.
    """
    opened = open_scan(results)
    check_one_place(opened.dataset, opened.name)
    criterion = read_criterion(target, percentile, confidence)
    part = opened.at_level(opened.level(pga, intensity_level))
    dataset = part.dataset
    recordings = np.repeat(part.recordings, dataset.sizes["polarity"])
    shaking = np.repeat(part.is_shaking, dataset.sizes["polarity"])
    peaks = by_motion(dataset["peak_displacement_free"], ("building",)).astype(float)
    distances, rotating, links = [], rotating_buildings(opened.scene), _links(opened)
    for name, peak in zip(map(str, dataset["building"].values), peaks.T, strict=True):
        finite = shaking & np.isfinite(peak)
        if not finite.any():
            raise PoundingError(no_response(dataset, name))
        independent = independent_motions(logs_of(peak[finite]), numbered(recordings[finite]))
        weight = independent / finite.sum()
        # No setback is wide enough for a motion in which the building collapses.
        values = np.where(finite, peak, inf)[shaking]
        required = required_gaps(values, weight, (*USUAL_PERCENTILES, criterion.percentile), criterion.confidence)
        words, size, lost = part.amplitude_words(), values.size, int((shaking & ~finite).sum())
        note = links.get(name, "")
        if name in rotating:
            required, note = (), f"{rotating_words(name)}. {AT_A_WALL}"
        distances.append(Setback(name, words, size, weight * size, criterion.percentile, required, lost, note))
    if not any(one.required for one in distances):
        raise PoundingError(" ".join(one.note for one in distances))
    return tuple(distances)


def _links(results: Results) -> dict[str, str]:
    """A sentence for each building that links join to another, by its name."""
    names = list(map(str, results.dataset["building"].values))
    linked: dict[str, list[str]] = {}
    for place, pair in enumerate(pairwise(names)):
        for name, other in (pair, pair[::-1]) if results.has_link(place) else ():
            linked.setdefault(name, []).append(other)
    return {
        name: f"{name}: it moves with the links to {' and '.join(others)}, without which it may need another setback: "
        "run the scene without them too"
        for name, others in linked.items()
    }


def sheet(answer: Sequence[Setback]) -> list[Block]:
    """Table of the setbacks by percentile, and what they take for granted."""
    heads = ["building", "sufficient for [%]", head("setback", "m")]
    heads += [head("bounds by recording", "m")]
    entries = [(one.building, required) for one in answer for required in one.required]
    rows = [[name, number(gap.percentile), enough(gap.gap), bounds_cell(gap)] for name, gap in entries]
    lost_lines = [
        f"{one.building} has no finite displacement in {counted(one.lost, 'motion')}: for these no setback is enough"
        for one in answer
        if one.lost
    ] + [one.note for one in answer if one.note]
    return [
        table(f"Setback from a property line, {answer[0].motions} motions {answer[0].at}.", heads, rows),
        *marks((gap for _, gap in entries), NO_BOUND),
        listing([f"{sentence}." for sentence in (*lost_lines, *ASSUMED)], mark=""),
    ]
