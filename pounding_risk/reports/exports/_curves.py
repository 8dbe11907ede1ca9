"""Fragility curves of an assessment as other tools take them: named, and in their units."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from math import exp
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pounding_risk.assessment.assess import Assessment, assess
from pounding_risk.assessment.fragility import Fragility
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import Measure, read_measure
from pounding_risk.reports.exports._written import Asked
from pounding_risk.units import GAP, STANDARD_GRAVITY, YIELD_FORCE, say

if TYPE_CHECKING:
    import xarray as xr

KINDS = ("contact", "yield", "damage")
STATES = {"contact": "contact", "yield": "yielding"}  # limit states of curves that stand alone
LONGEST = 100  # characters of an identifier in NRML
TAIL = 4.0  # dispersions on either side of the median that a curve is written for: 0.003 % and 99.997 %


class Known(NamedTuple):
    """An intensity as other tools know it: its name in OpenQuake, its unit there, and the size of that in SI."""

    imt: str
    unit: str
    size: float
    word: str  # as `assess` takes it


class Curve(NamedTuple):
    """A lognormal fragility: limit state, words, median and dispersion with standard errors, runs.

    Intensities are in the unit of `Known`.
    """

    state: str
    words: str
    median: float
    dispersion: float
    errors: tuple[float, float]  # of ln median, and of the dispersion
    runs: int


class Function(NamedTuple):
    """The curves of the limit states of one place, the one of the lowest threshold first."""

    identifier: str
    curves: tuple[Curve, ...]

    @property
    def ends(self) -> tuple[float, float]:
        """The intensities between which it is written: `TAIL` dispersions beyond its outermost medians."""
        low, high = ([c.median * exp(side * TAIL * c.dispersion) for c in self.curves] for side in (-1.0, 1.0))
        return min(low), max(high)


class Model(NamedTuple):
    """Functions that have the same limit states, for which other tools take each to hold where a later one does."""

    identifier: str
    states: tuple[str, ...]
    functions: tuple[Function, ...]


class Fragilities(NamedTuple):
    """Models against one intensity, and what is left out."""

    measure: Known
    models: tuple[Model, ...]
    title: str
    told: tuple[str, ...]


def of_assessment(results: xr.Dataset, asked: Asked, kind: str) -> Fragilities:
    """The fragilities of contact or yielding; raises PoundingError where there are none, with why."""
    assessment = assess(
        results, gap=asked.gap, pga=asked.pga, intensity_level=asked.intensity_level, intensity=asked.intensity
    )
    measure = known_measure(assessment.intensity)
    every = list(_every(assessment, kind))
    left_out = tuple(f"{identifier}: no curve, {one.fault}" for identifier, one in every if one.fault)
    curved = [(identifier, one) for identifier, one in every if not one.fault]
    if not curved:
        why = "; ".join(dict.fromkeys(one.fault for _, one in every)) or _none(kind)
        raise PoundingError(f"the results hold no fragility of {kind}: {why}")
    names = distinct(identifier for identifier, _ in curved)
    functions = (Function(name, (_curve(one, measure),)) for name, (_, one) in zip(names, curved, strict=True))
    return Fragilities(measure, (Model(STATES[kind], (STATES[kind],), tuple(functions)),), assessment.title, left_out)


def _none(kind: str) -> str:
    return "no contact of them yields" if kind == "yield" else "no gap was assessed"


def _every(assessment: Assessment, kind: str) -> Iterator[tuple[str, Fragility]]:
    """The fragilities of a kind at the assessed gap of each interface, with identifiers."""
    for interface in assessment.interfaces:
        for one in interface.fragility:
            gap = interface.gap if kind == "contact" else interface.yield_gap
            if one.what != kind or one.gap != gap:
                continue
            force = "" if one.yield_force is None else f"FE {say(one.yield_force, YIELD_FORCE)}"
            parts = (interface.name, f"gap {say(one.gap, GAP)}", one.contact_model or "", force)
            yield identifier_of(*parts), one


def identifier_of(*parts: str) -> str:
    """An identifier of letters, digits, "-" and "_" from words: "frame-wall_gap-60mm"."""
    words = (re.sub(r"[^A-Za-z0-9_.]+", "-", part).strip("-") for part in parts)
    return re.sub(r"\.", "p", "_".join(filter(None, words)))[:LONGEST]


def distinct(names: Iterable[str], otherwise: str = "") -> list[str]:
    """The names, each another: a number follows one that stood before, and ``otherwise`` where nothing is left."""
    taken: list[str] = []
    for name in names:
        name, number = name or otherwise, 1
        numbered = name
        while numbered in taken or not numbered:
            number += 1
            numbered = f"{name[: LONGEST - 4]}-{number}"
        taken.append(numbered)
    return taken


def _curve(one: Fragility, measure: Known) -> Curve:
    where = "" if one.yield_force is None else f" under {one.contact_model} at F_E {say(one.yield_force, YIELD_FORCE)}"
    words = f"{one.what} at a gap of {say(one.gap, GAP)}{where}, {one.method}"
    runs = sum(stripe.runs for stripe in one.stripes)
    return Curve(STATES[one.what], words, one.median / measure.size, one.dispersion, one.errors, runs)


def known_measure(intensity: str) -> Known:
    """The intensity as other tools know it; raises PoundingError for one that they do not."""
    measure = read_measure(intensity)
    if measure == Measure("pga"):
        return Known("PGA", "g", STANDARD_GRAVITY, intensity)
    if measure == Measure("pgv"):
        return Known("PGV", "cm/s", 0.01, intensity)
    if measure is not None and measure.is_same(Measure("sa", measure.periods)):
        return Known(f"SA({measure.periods[0]:.6g})", "g", STANDARD_GRAVITY, intensity)
    raise PoundingError(
        f"intensity {intensity!r} has no name in other tools; write --intensity pga, pgv, or a period such as "
        '"sa(0.5 s)", of 5 % damping'
    )


def probabilities(curve: Curve, levels: np.ndarray) -> np.ndarray:
    """Probability of failure at intensities in the unit of the curve."""
    from pounding_risk.statistics.fragility import fragility_curve

    return fragility_curve(levels, curve.median, curve.dispersion)
