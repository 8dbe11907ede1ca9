"""What an assessment's numbers depend on: the yield force F_E, the contact model, the polarity.

An influence is how far a number moves from one level of a key to another, over all the others. Whether there is
contact does not depend on F_E or the contact model at all: the motion up to the first touch is the free one. In a row
that is so of the first touch of all; what pounding elsewhere then closes is not told apart by them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.quantities import GAP, YIELD_FORCE, say

Array = NDArray[np.float64]

CONTACT, REQUIRED, YIELD = "P(contact)", "required gap", "P(yield)"
WORDS = {"yield_force": "F_E", "contact_model": "the contact model", "polarity": "the polarity"}


@dataclass(frozen=True)
class Influence:
    """How far ``what`` moves with ``key``: ``spread``, the largest less the smallest over the ``levels``.

    ``turns`` is True where the levels lie on both sides of the target. ``spread`` is NaN where the grid has one level.
    """

    key: str
    what: str
    spread: float
    unit: str
    levels: tuple[tuple[str, float], ...]
    turns: bool
    words: str


class Yielding(NamedTuple):
    """Who yields: 1, 0 or NaN by (motions, models, forces), and what the axes are."""

    failed: Array
    polarities: tuple[str, ...]  # by motion
    models: tuple[str, ...]
    forces: tuple[float, ...]  # N


def of_contact(
    closing: Array, polarities: tuple[str, ...], gap: float, asked: tuple[float, float], in_row: bool = False
) -> tuple[Influence, ...]:
    """Influences on the probability of contact and on the required gap; ``asked`` = (percentile, target)."""
    percentile, target = asked
    names, kinds = list(dict.fromkeys(polarities)), np.array(polarities)
    shares = [(name, float((closing[kinds == name] > gap).mean())) for name in names]
    gaps = [(name, float(np.percentile(closing[kinds == name], percentile))) for name in names]
    free = "none: the motion is free up to the first touch, so that it alone decides whether there is contact"
    if in_row:
        free = "none on the first touch of the row; a motion counts where it touches here under any of them"
    spread = nan if in_row else 0.0
    none = tuple(Influence(key, CONTACT, spread, "1", (), False, free) for key in ("yield_force", "contact_model"))
    return (
        _influence("polarity", CONTACT, shares, target),
        _influence("polarity", f"{REQUIRED} at {percentile:g} %", gaps, gap),
        *none,
    )


def of_yielding(found: Yielding, target: float) -> tuple[Influence, ...]:
    """Influences on the probability that the force reaches F_E, over the grid's finite F_E at one gap."""
    kinds = np.array(found.polarities)
    names = [say(force, YIELD_FORCE) if isfinite(force) else "columns' own" for force in found.forces]
    by_force = [(name, _mean(found.failed[:, :, place])) for place, name in enumerate(names)]
    by_model = [(name, _mean(found.failed[:, place])) for place, name in enumerate(found.models)]
    by_polarity = [(name, _mean(found.failed[kinds == name])) for name in dict.fromkeys(found.polarities)]
    keys = (("yield_force", by_force), ("contact_model", by_model), ("polarity", by_polarity))
    listed = [_influence(key, YIELD, levels, target) for key, levels in keys]
    return tuple(sorted(listed, key=lambda each: -np.nan_to_num(each.spread, nan=-1.0)))


def ranked(influences: Sequence[Influence]) -> str:
    """In words, what matters most to yielding, and to contact."""
    told = []
    yielding = [each for each in influences if each.what == YIELD and each.spread > 0.0]
    if yielding:
        first, *rest = yielding
        told.append(f"whether F_E is reached depends most on {_spread(first)}" + _then(rest))
    contact = {each.key: each.spread for each in influences if each.what == CONTACT}
    moved = f"by {contact['polarity']:.2f}" if contact["polarity"] > 0.0 else "by nothing here"
    never = contact["yield_force"] == contact["contact_model"] == 0.0
    if not np.isnan(contact["polarity"]):
        also = ", F_E and the contact model never do" if never else ""
        told.append(f"the polarity moves P(contact) {moved}{also}")
    elif never:
        told.append("F_E and the contact model never change whether there is contact")
    return "; ".join(told) or "one level of each key was scanned, which tells nothing of what matters"


def _then(rest: Sequence[Influence]) -> str:
    return f", then on {' and '.join(map(_spread, rest))}" if rest else ""


def _spread(one: Influence) -> str:
    return f"{WORDS[one.key]} (by {one.spread:.2f})"


def _mean(values: Array) -> float:
    known = values[~np.isnan(values)]
    return float(known.mean()) if known.size else nan


def _influence(key: str, what: str, levels: list[tuple[str, float]], limit: float) -> Influence:
    """``limit`` is what the values are held against: the target, or the gap."""
    unit = "m" if what.startswith(REQUIRED) else "1"
    known = [(name, value) for name, value in levels if not np.isnan(value)]
    if len(known) < 2:
        only = f"{known[0][0]} alone: scan several to see" if known else "not defined: no run has such a force"
        return Influence(key, what, nan, unit, tuple(known), False, only)
    least, most = min(known, key=lambda each: each[1]), max(known, key=lambda each: each[1])
    turns = least[1] <= limit < most[1]
    words = f"{_said(least[1], unit)} ({least[0]}) to {_said(most[1], unit)} ({most[0]})"
    if least[1] == most[1]:
        words = f"none: {_said(most[1], unit)} at every level"
    elif turns:
        words += "; on both sides of " + (f"the gap, {say(limit, GAP, 3)}" if unit == "m" else f"the target, {limit:g}")
    return Influence(key, what, most[1] - least[1], unit, tuple(known), turns, words)


def _said(value: float, unit: str) -> str:
    return say(value, GAP, 3) if unit == "m" else f"{value:.2f}"
