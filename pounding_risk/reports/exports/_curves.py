"""Fragility curves of an assessment as other tools take them: named, and in their units."""

from __future__ import annotations

import re
from collections.abc import Iterator
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

KINDS = ("contact", "yield")
LONGEST = 100  # characters of an identifier in NRML


class Known(NamedTuple):
    """An intensity as other tools know it: its name in OpenQuake, its unit there, and the size of that in SI."""

    imt: str
    unit: str
    size: float


class Curve(NamedTuple):
    """A lognormal fragility: identifier, words, median and dispersion with standard errors, motions.

    Intensities are in the unit of `Known`.

    ``seen`` are intensity, share of failures and count of motions of each stripe.
    """

    identifier: str
    words: str
    median: float
    dispersion: float
    errors: tuple[float, float]  # of ln median, and of the dispersion
    seen: tuple[tuple[float, float, int], ...]


class Curves(NamedTuple):
    """Curves of one kind of failure against one intensity, and what is left out."""

    kind: str
    measure: Known
    curves: tuple[Curve, ...]
    title: str
    told: tuple[str, ...]


def curves_of(results: xr.Dataset, asked: Asked) -> Curves:
    """The fragilities of an assessment; raises PoundingError where there are none, with why."""
    kind = asked.of or KINDS[0]
    if kind not in KINDS:
        raise PoundingError(f"--of: {kind!r} is none; it may be {' or '.join(KINDS)}")
    assessment = assess(
        results, gap=asked.gap, pga=asked.pga, intensity_level=asked.intensity_level, intensity=asked.intensity
    )
    measure = _measure(assessment.intensity)
    every = list(_every(assessment, kind))
    without = tuple(f"{identifier}: no curve, {one.fault}" for identifier, one in every if one.fault)
    curves = tuple(_curve(identifier, one, measure.size) for identifier, one in every if not one.fault)
    if not curves:
        why = "; ".join(dict.fromkeys(one.fault for _, one in every)) or _none(kind)
        raise PoundingError(f"the results hold no fragility of {kind}: {why}")
    return Curves(kind, measure, curves, assessment.title, without)


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


def _curve(identifier: str, one: Fragility, size: float) -> Curve:
    where = "" if one.yield_force is None else f" under {one.contact_model} at F_E {say(one.yield_force, YIELD_FORCE)}"
    seen = tuple((stripe.im / size, stripe.count / stripe.runs, stripe.runs) for stripe in one.stripes)
    words = f"{one.what} at a gap of {say(one.gap, GAP)}{where}, {one.method}"
    return Curve(identifier, words, one.median / size, one.dispersion, one.errors, seen)


def _measure(intensity: str) -> Known:
    """The intensity as other tools know it; raises PoundingError for one that they do not."""
    measure = read_measure(intensity)
    if measure == Measure("pga"):
        return Known("PGA", "g", STANDARD_GRAVITY)
    if measure == Measure("pgv"):
        return Known("PGV", "cm/s", 0.01)
    if measure is not None and measure.is_same(Measure("sa", measure.periods)):
        return Known(f"SA({measure.periods[0]:.6g})", "g", STANDARD_GRAVITY)
    raise PoundingError(
        f"intensity {intensity!r} has no name in other tools; write --intensity pga, pgv, or a period such as "
        '"sa(0.5 s)", of 5 % damping'
    )


def probabilities(curve: Curve, levels: np.ndarray) -> np.ndarray:
    """Probability of failure at intensities in the unit of the curve."""
    from pounding_risk.assessment.fragility import fragility_curve

    return fragility_curve(levels, curve.median, curve.dispersion)
