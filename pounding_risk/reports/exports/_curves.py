"""Fragility curves of an assessment as other tools take them: named, in g, with the range that the motions cover."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pounding_risk.assessment.assess import Assessment, assess
from pounding_risk.assessment.fragility import Fragility
from pounding_risk.errors import PoundingError
from pounding_risk.reports.exports._written import Asked
from pounding_risk.results.amplitudes import USUAL_DAMPING, spectral
from pounding_risk.units import GAP, STANDARD_GRAVITY, YIELD_FORCE, say

if TYPE_CHECKING:
    import xarray as xr

KINDS = ("contact", "yield")
LONGEST = 100  # characters of an identifier in NRML


class Measure(NamedTuple):
    """An intensity: "pga", or the spectral acceleration at a period [s] of 5 % damping."""

    period: float | None

    @property
    def imt(self) -> str:
        """The name in OpenQuake."""
        return "PGA" if self.period is None else f"SA({self.period:.6g})"


class Curve(NamedTuple):
    """A lognormal fragility: identifier, words, median [g] and dispersion with standard errors, motions [g].

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
    measure: Measure
    curves: tuple[Curve, ...]
    title: str
    told: tuple[str, ...]


def curves_of(results: xr.Dataset, asked: Asked) -> Curves:
    """The fragilities of an assessment; raises PoundingError where there are none, with why."""
    kind = asked.of or KINDS[0]
    if kind not in KINDS:
        raise PoundingError(f"--of: {kind!r} is none; it may be {' or '.join(KINDS)}")
    assessment = assess(results, gap=asked.gap, pga=asked.pga, intensity=asked.intensity)
    measure = _measure(assessment.intensity)
    every = list(_every(assessment, kind))
    without = tuple(f"{identifier}: no curve, {one.fault}" for identifier, one in every if one.fault)
    curves = tuple(_curve(identifier, one) for identifier, one in every if not one.fault)
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


def _curve(identifier: str, one: Fragility) -> Curve:
    where = "" if one.yield_force is None else f" under {one.contact_model} at F_E {say(one.yield_force, YIELD_FORCE)}"
    seen = tuple((stripe.im / STANDARD_GRAVITY, stripe.count / stripe.runs, stripe.runs) for stripe in one.stripes)
    words = f"{one.what} at a gap of {say(one.gap, GAP)}{where}, {one.method}"
    return Curve(identifier, words, one.median / STANDARD_GRAVITY, one.dispersion, one.errors, seen)


def _measure(intensity: str) -> Measure:
    """The intensity as other tools know it; raises PoundingError for one that they do not."""
    if intensity == "pga":
        return Measure(None)
    known = spectral(intensity[3:-1]) if intensity.startswith("sa(") else None
    if known is None or abs(known.damping - USUAL_DAMPING) > 1e-9:
        raise PoundingError(
            f"intensity {intensity!r} has no name in other tools; write --intensity pga, or a period such as "
            '"sa(0.5 s)", of 5 % damping'
        )
    return Measure(known.period)


def probabilities(curve: Curve, levels: np.ndarray) -> np.ndarray:
    """Probability of failure at intensities [g]."""
    from pounding_risk.assessment.fragility import fragility_curve

    return fragility_curve(levels, curve.median, curve.dispersion)
