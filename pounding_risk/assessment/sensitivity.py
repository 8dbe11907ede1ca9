"""Sensitivity of an assessment to the yield force F_E, the contact model and the polarity.

An influence is how far a number moves from one level of a key to another. Whether there is contact does not depend on
F_E or the contact model: the motion up to the first touch is the free one. In a row that holds for the first touch of
all; what pounding elsewhere then closes is not attributed to them. That a force reaches F_E depends on F_E by
definition: F_E is held against the response instead, and P(yield) is given at the scene's own F_E. Contact models are
compared without yielding where the grid has that: what differs by the cap alone is an influence of F_E and not of the
model. The response is the largest value of an output over the motions with contact.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from math import inf, isfinite, nan
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.order import enough_for
from pounding_risk._common.words import words_of
from pounding_risk.assessment.demands import Motions, by_motion
from pounding_risk.assessment.options import Criterion
from pounding_risk.results.amplitudes import own
from pounding_risk.results.attributes import finite
from pounding_risk.results.variables import unit_of
from pounding_risk.units import GAP, YIELD_FORCE, Quantity, say

Array = NDArray[np.float64]

CONTACT, REQUIRED, YIELD = "P(contact)", "required gap", "P(yield)"
WORDS = {"yield_force": "F_E", "contact_model": "the contact model", "polarity": "the polarity"}
NEVER = "no yielding"  # an infinite F_E in words
COLUMNS_ALONE = "F_E of columns alone"  # where these have one of their own
CAPPED = "peak_contact_force"  # F_E is its upper end: that it follows F_E is no finding
OF_BUILDINGS = ("peak_relative_displacement", "peak_floor_acceleration", "storey_ductility")
NOTABLE = 0.01  # a median that moves by less than this share of itself is called unchanged
# Outputs of a dataset as far as it has them. Of two buildings or several storeys the largest counts.
OUTPUTS = words_of("peak_relative_displacement", "peak_floor_acceleration", "peak_contact_force", "peak_penetration")
OUTPUTS |= words_of("storey_ductility")
LOW, MIDDLE, HIGH = 16.0, 50.0, 84.0
CASES = ("contact_model", "yield_force")


@dataclass(frozen=True)
class Response:
    """One output at one gap [m], contact model and F_E [N], over the motions with contact: 16, 50 and 84 %.

    ``output`` is the dataset's variable, the larger of both buildings' where each has its own; values are NaN where no
    motion brings contact or the contact model has no such output.
    """

    output: str
    words: str
    unit: str
    gap: float
    contact_model: str
    yield_force: float
    low: float
    median: float
    high: float
    motions: int


def responses_at(
    results: xr.Dataset, gap: float, isolated: Collection[str] = (), walls: Collection[str] = ()
) -> tuple[Response, ...]:
    """Every output of `OUTPUTS` that a dataset of one interface and amplitude has, by contact model and F_E.

    ``gap`` [m] is one of the grid's. Of the ``isolated`` buildings the ductility is that of the storeys above the slab.
    The ``walls`` of a moat around them are left out.
    """
    at_gap = results.isel(gap=int(np.abs(results["gap"].values - gap).argmin()))
    touching = by_motion(at_gap["impact_count"], CASES) > 0
    responses = []
    for output, words in OUTPUTS.items():
        if output not in at_gap:
            continue
        inner_axes = [axis for axis in at_gap[output].dims if axis not in ("record", "polarity", *CASES)]
        outputs = finite(at_gap, output)
        if walls and "building" in outputs.dims:
            words = f"{words} without {' and '.join(walls)}"
            outputs = outputs.where(~outputs["building"].isin(list(walls)))
        if output == "storey_ductility" and isolated:
            words = f"{words} above isolators"
            outputs = outputs.where(~outputs["building"].isin(list(isolated)) | (outputs["storey"] > 1))
            if outputs.isnull().all():  # the isolators alone yield, and walls
                continue
        peaks = np.where(touching, by_motion(outputs.max(inner_axes), CASES), np.nan)
        for model, force in np.ndindex(peaks.shape[1:]):
            known_peaks = peaks[np.isfinite(peaks[:, model, force]), model, force]
            percentiles = np.percentile(known_peaks, (LOW, MIDDLE, HIGH)) if known_peaks.size else np.full(3, np.nan)
            case = (str(at_gap["contact_model"].values[model]), float(at_gap["yield_force"].values[force]))
            low, median, high = map(float, percentiles)
            responses.append(Response(output, words, unit_of(output), gap, *case, low, median, high, known_peaks.size))
    return tuple(responses)


@dataclass(frozen=True)
class Influence:
    """How far ``what`` moves with ``key``: ``spread``, the largest less the smallest over the ``levels``.

    ``what`` is a probability, the required gap, or the median of ``output`` over the motions with contact. ``turns`` is
    True where the levels lie on both sides of the target. ``spread`` is NaN where there is one level, and where the
    levels differ by more than the key.
    """

    key: str
    what: str
    spread: float
    unit: str
    levels: tuple[tuple[str, float], ...]
    turns: bool
    words: str
    output: str = ""

    @property
    def is_single(self) -> bool:
        """Whether the grid has one level of the key, so that nothing is said of it."""
        return len(self.levels) == 1

    @property
    def share(self) -> float:
        """The spread over the largest level; 0 where it is not known."""
        most = max((abs(output) for _, output in self.levels), default=0.0)
        return self.spread / most if most > 0.0 and isfinite(self.spread) else 0.0


class Yielding(NamedTuple):
    """Yielding of the runs, 1, 0 or NaN by (motions, models, forces), and the labels of these axes."""

    failed: Array
    polarities: tuple[str, ...]  # by motion
    models: tuple[str, ...]
    forces: tuple[float, ...]  # N


def contact_influences(
    motions: Motions, touched: NDArray[np.bool_], gap: float, criterion: Criterion
) -> tuple[Influence, ...]:
    """Influences on the probability of contact and on the required gap; ``touched`` is contact by motion."""
    percentile, target, in_row = criterion.percentile, criterion.target, motions.alone is not None
    closing, polarities = motions.closing[:, 0], np.array(motions.polarities)
    names = list(dict.fromkeys(motions.polarities))
    shares = [(name, float(touched[polarities == name].mean())) for name in names]
    gaps = [(name, float(enough_for(closing[polarities == name], percentile))) for name in names]
    text = "none: the motion is free up to the first touch, so that it alone decides whether there is contact"
    if in_row:
        text = "none on the first touch of the row; P(contact) is that of the scene's own contact model and F_E"
    spread = nan if in_row else 0.0
    by_law = tuple(Influence(key, CONTACT, spread, "1", (), False, text) for key in ("yield_force", "contact_model"))
    return (
        _influence("polarity", CONTACT, shares, target),
        _influence("polarity", f"{REQUIRED} at {percentile:g} %", gaps, gap, "m"),
        *by_law,
    )


def yield_influences(yielding: Yielding, force: float, target: float) -> tuple[Influence, ...]:
    """Influences on the probability that the force reaches F_E, at one gap and one F_E of the grid [N]."""

    def mean(outcomes: Array) -> float:
        known_outcomes = outcomes[~np.isnan(outcomes)]
        return float(known_outcomes.mean()) if known_outcomes.size else nan

    polarities = np.array(yielding.polarities)
    failed = yielding.failed[:, :, yielding.forces.index(force)]
    by_model = [(name, mean(failed[:, index])) for index, name in enumerate(yielding.models)]
    by_polarity = [(name, mean(failed[polarities == name])) for name in dict.fromkeys(yielding.polarities)]
    yield_text = f"{YIELD} at {force_words(force) if isfinite(force) else 'the F_E of columns'}"
    keys = (("contact_model", by_model), ("polarity", by_polarity))
    influences = [_influence(key, yield_text, levels, target) for key, levels in keys]
    return tuple(sorted(influences, key=lambda influence: -np.nan_to_num(influence.spread, nan=-1.0)))


def response_influences(
    responses: Sequence[Response], model: str, force: float, columns_yield: bool = False
) -> tuple[Influence, ...]:
    """Influences of F_E and of the contact model on the median of each output.

    Responses are of one gap, those of one output together. F_E is varied under the scene's own contact ``model``;
    contact models are compared at the scene's own F_E, ``force`` [N], where the grid has no case without yielding.
    ``columns_yield`` says that columns have an F_E of their own, so that an infinite one of floors is not without.
    """
    at = inf if any(response.yield_force == inf for response in responses) else force
    by_force, by_model = [], []
    for output, grouped in groupby(responses, key=lambda response: response.output):
        levels = list(grouped)
        what, unit = f"median {levels[0].words}", levels[0].unit
        forces = [
            (force_words(case.yield_force, columns_yield), case.median)
            for case in levels
            if case.contact_model == model
        ]
        influence = replace(_influence("yield_force", what, forces, nan, unit), output=output)
        if output == CAPPED and influence.spread > 0.0:
            influence = replace(influence, words=f"{influence.words}; F_E is its upper end under a law that yields")
        by_force.append(influence)
        models = [(case.contact_model, case.median) for case in levels if case.yield_force == at]
        influence = replace(_influence("contact_model", what, models, nan, unit), output=output)
        if influence.spread > 0.0 and at == inf:
            influence = replace(influence, words=f"{influence.words}, without yielding")
        elif influence.spread > 0.0:
            condition = (
                f'at {force_words(at)}, where yielding may be part of it: "inf" in grid.yield_force separates them'
            )
            influence = replace(influence, words=f"{influence.words}; {condition}", spread=nan)
        by_model.append(influence)
    return (*by_force, *by_model)


def what_matters(influences: Sequence[Influence]) -> str:
    """Sentences on what F_E and the contact model change most, and on what yielding and contact depend."""
    sentences = []
    for key in ("yield_force", "contact_model"):
        of_key = [influence for influence in influences if influence.key == key]
        levels = [influence for influence in of_key if influence.output in OF_BUILDINGS and isfinite(influence.spread)]
        largest = max(levels, key=lambda influence: influence.share, default=None)
        if largest is not None and largest.share < NOTABLE:
            sentences.append(f"{WORDS[key]} changes no median response of the buildings by {100 * NOTABLE:g} % or more")
        elif largest is not None:
            sentences.append(f"{WORDS[key]} changes the {largest.what} most, {largest.words}")
    yielding = [influence for influence in influences if influence.what.startswith(YIELD) and influence.spread > 0.0]
    if yielding:
        yield_text = yielding[0].what.partition(" at ")[2]
        causes = " and ".join(f"{WORDS[influence.key]} (by {influence.spread:.2f})" for influence in yielding)
        sentences.append(f"whether {yield_text} is reached depends on {causes}")
    contact = {influence.key: influence.spread for influence in influences if influence.what == CONTACT}
    is_never = contact["yield_force"] == contact["contact_model"] == 0.0
    polarity = contact["polarity"]
    if not np.isnan(polarity):
        changes = f"changes P(contact) by {polarity:.2f}" if polarity > 0.0 else "does not change P(contact)"
        others_text = "; F_E and the contact model never do" if polarity > 0.0 else ", nor do F_E and the contact model"
        sentences.append(f"the polarity {changes}{others_text if is_never else ''}")
    elif is_never:
        sentences.append("F_E and the contact model never change whether there is contact")
    single = [words for key, words in WORDS.items() if any(one.is_single for one in influences if one.key == key)]
    if not sentences and single:
        names = " and ".join(filter(None, [", ".join(single[:0:-1]), single[0]]))
        verb = "each, so that their" if len(single) > 1 else "alone, so that its"
        return f"{names} had one value {verb} influence is not shown"
    return "; ".join(sentences) or "the runs show no influence"


def force_words(force: float, columns_yield: bool = False) -> str:
    """A yield force F_E in words; where it is infinite "no yielding", or that columns alone yield."""
    return f"F_E {own(force, YIELD_FORCE)}" if isfinite(force) else COLUMNS_ALONE if columns_yield else NEVER


def _influence(key: str, what: str, levels: list[tuple[str, float]], limit: float, unit: str = "1") -> Influence:
    """Influence of a key; ``limit`` is the target or the gap, NaN where the values are compared with neither."""
    points = [(name, output) for name, output in levels if not np.isnan(output)]
    if len(points) < 2:
        text = f"{points[0][0]} alone: scan several to see" if points else "not defined: no run has such a value"
        return Influence(key, what, nan, unit, tuple(points), False, text)
    lowest, highest = min(points, key=lambda level: level[1]), max(points, key=lambda level: level[1])
    turns = lowest[1] <= limit < highest[1]
    quantity = Quantity({"m/s2": "m/s^2"}.get(unit, unit), -inf, inf, "")
    is_share = unit == "1" and isfinite(limit)
    low, high = (f"{end[1]:.2f}" if is_share else say(end[1], quantity, 3) for end in (lowest, highest))
    words = f"{low} ({lowest[0]}) to {high} ({highest[0]})"
    if lowest[1] == highest[1]:
        words = f"none: {high} at every level"
    elif turns:
        words += "; on both sides of " + (f"the gap, {own(limit, GAP)}" if unit == "m" else f"the target, {limit:g}")
    if undefined_names := [name for name, output in levels if np.isnan(output)]:
        words += f"; not defined for {', '.join(undefined_names)}"
    return Influence(key, what, highest[1] - lowest[1], unit, tuple(points), turns, words)
