"""Fragility curves of contact, yielding and damage states as other tools take them: named, and in their units.

States of damage are ordered limit states: of one demand in one place, lowest first. Other tools take the probability of
being in a state as the difference of two curves. That holds where no curve crosses the next within the range that is
written; states whose curves do are models of their own.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from math import exp, isinf, log
from typing import Any, NamedTuple

import xarray as xr

from pounding_risk.assessment.assess import Assessment, assess
from pounding_risk.assessment.damage_curves import POUNDING
from pounding_risk.assessment.fragility import Fragility
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import Measure, read_measure
from pounding_risk.render.sheet import strength
from pounding_risk.reports.exports import Options
from pounding_risk.results.check import kind_of
from pounding_risk.results.opened import Results
from pounding_risk.statistics.damage_fits import METHODS
from pounding_risk.units import GAP, STANDARD_GRAVITY, YIELD_FORCE, say

KINDS = ("contact", "yield", "damage")
STATES = {"contact": "contact", "yield": "yielding"}  # limit states of curves that stand alone
LONGEST = 100  # characters of an identifier in NRML
LONGEST_STATE = 70  # characters of the name of a limit state; OpenQuake takes 75
TAIL = 4.0  # dispersions on either side of the median that a curve is written for: 0.003 % and 99.997 %


class Intensity(NamedTuple):
    """An intensity as other tools know it: its name in OpenQuake, its unit there, and the size of that in SI."""

    imt: str
    unit: str
    size: float
    word: str  # as `assess` takes it


class Curve(NamedTuple):
    """A lognormal fragility: limit state, words, median and dispersion with standard errors, runs.

    Intensities are in the unit of `Intensity`.
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

    measure: Intensity
    models: tuple[Model, ...]
    title: str
    notes: tuple[str, ...]


def fragilities_of(results: xr.Dataset, options: Options) -> Fragilities:
    """The fragilities of one kind of failure; raises PoundingError where there are none, with why."""
    kind = options.of or ("damage" if kind_of(results) == "damage" else KINDS[0])
    if kind not in KINDS:
        raise PoundingError(f"--of: {kind!r} is none; it may be {' or '.join(KINDS)}")
    if kind == "damage":
        return _of_damage(results, options)
    if options.method is not None:
        raise PoundingError(f"--method: is of damage states, and has no effect on {kind}; leave it out")
    if kind_of(results) == "damage":
        raise PoundingError(f"--of: {kind} is assessed from results of scan, and this dataset is of damage states")
    if options.without:
        raise PoundingError(f"--without: without pounding there is no {STATES[kind]}; write --of damage")
    assessment = assess(
        results, gap=options.gap, pga=options.pga, intensity_level=options.intensity_level, intensity=options.intensity
    )
    measure = intensity_of(assessment.intensity)
    curves = list(_at_assessed_gaps(assessment, kind))
    left_out = tuple(f"{identifier}: no curve, {curve.fault}" for identifier, curve in curves if curve.fault)
    fitted = [(identifier, curve) for identifier, curve in curves if not curve.fault]
    if not fitted:
        default = "no contact of them yields" if kind == "yield" else "no gap was assessed"
        cause = "; ".join(dict.fromkeys(curve.fault for _, curve in curves)) or default
        raise PoundingError(f"the results hold no fragility of {kind}: {cause}")
    names = distinct(identifier for identifier, _ in fitted)
    functions = (Function(name, (_curve(curve, measure),)) for name, (_, curve) in zip(names, fitted, strict=True))
    return Fragilities(measure, (Model(STATES[kind], (STATES[kind],), tuple(functions)),), assessment.title, left_out)


def _at_assessed_gaps(assessment: Assessment, kind: str) -> Iterator[tuple[str, Fragility]]:
    """The fragilities of a kind at the assessed gap of each interface, with identifiers."""
    for interface in assessment.interfaces:
        for one in interface.fragility:
            if one.what == kind and one.gap == (interface.gap if kind == "contact" else interface.yield_gap):
                force = "" if one.yield_force is None else f"FE {_force(one.yield_force)}"
                yield identifier_of(interface.name, f"gap {say(one.gap, GAP)}", one.contact_model or "", force), one


def _force(force: float) -> str:
    """A yield force in words, as tables of an assessment have it; infinite where columns yield at their own."""
    return str(strength(force)["text"]) if isinf(force) else say(force, YIELD_FORCE)


def _curve(fit: Fragility, measure: Intensity) -> Curve:
    model = "" if fit.yield_force is None else f" under {fit.contact_model} at F_E {_force(fit.yield_force)}"
    words = f"{fit.what} at a gap of {say(fit.gap, GAP)}{model}, {fit.method}"
    runs = sum(stripe.runs for stripe in fit.stripes)
    return Curve(STATES[fit.what], words, fit.median / measure.size, fit.dispersion, fit.errors, runs)


def identifier_of(*texts: str) -> str:
    """An identifier of letters, digits, "-" and "_" from words: "frame-wall_gap-60mm"."""
    words = (re.sub(r"[^A-Za-z0-9_.]+", "-", text).strip("-") for text in texts)
    return re.sub(r"\.", "p", "_".join(filter(None, words)))[:LONGEST]


def distinct(names: Iterable[str], otherwise: str = "") -> list[str]:
    """The names, each another: a number follows one that stood before, and ``otherwise`` where nothing is left."""
    used_names: list[str] = []
    for name in names:
        name, number = name or otherwise, 1
        numbered = name
        while numbered in used_names or not numbered:
            number += 1
            numbered = f"{name[: LONGEST - 4]}-{number}"
        used_names.append(numbered)
    return used_names


def intensity_of(word: str) -> Intensity:
    """The intensity as other tools know it; raises PoundingError for one that they do not."""
    measure = read_measure(word)
    if measure == Measure("pga"):
        return Intensity("PGA", "g", STANDARD_GRAVITY, word)
    if measure == Measure("pgv"):
        return Intensity("PGV", "cm/s", 0.01, word)
    if measure is not None and measure.is_same(Measure("sa", measure.periods)):
        return Intensity(f"SA({measure.periods[0]:.6g})", "g", STANDARD_GRAVITY, word)
    raise PoundingError(
        f"intensity {word!r} has no name in other tools; write --intensity pga, pgv, or a period such as "
        '"sa(0.5 s)", of 5 % damping'
    )


# ------------------------------------------------------------------------------------------------ damage states


def _of_damage(results: xr.Dataset, options: Options) -> Fragilities:
    """The fragilities of damage states with pounding, or without."""
    dataset = damage_dataset(results, options)
    measure, side = intensity_of(str(dataset.attrs["intensity"])), POUNDING[options.without]
    models: list[Model] = []
    notes: list[str] = []
    # Names of the states by their demand and place, "storey drift of frame", in the order of their thresholds.
    groups: dict[str, list[tuple[float, str]]] = {}
    columns = (dataset[name].values.tolist() for name in ("state", "state_words", "state_threshold"))
    for state, words, threshold in zip(*columns, strict=True):
        groups.setdefault(words.partition(" ≥ ")[0], []).append((threshold, state))
    runs = (
        dataset["runs"]
        .sel(pounding=side)
        .sum([dim for dim in dataset["runs"].dims if dim not in ("state", "pounding")])
    )
    for state, state_runs in zip(dataset["state"].values.tolist(), runs.values.tolist(), strict=True):
        if state_runs < runs.max():
            left_out = f"{int(runs.max() - state_runs)} of {int(runs.max())} runs"
            notes.append(f"{state}, {side} pounding: {left_out} failed, or have no such demand, and are left out")
    names = distinct((identifier_of(words) for words in groups), "damage")
    for name, states in zip(names, groups.values(), strict=True):
        fitted = []
        for _, state in sorted(states):
            part = dataset.sel(state=state, pounding=side)
            if fault := str(part["fault"].item()):
                notes.append(f"{state}, {side} pounding: no curve, {fault}")
            else:
                fitted.append(part)
        if not fitted:
            continue
        function = Function(name, _damage_curves(fitted, dataset, measure))
        if crossed := crossing(function, measure):
            notes.append(crossed)
            models += [
                Model(f"{name}_{curve.state}", (curve.state,), (Function(name, (curve,)),)) for curve in function.curves
            ]
        else:
            models.append(Model(name, tuple(curve.state for curve in function.curves), (function,)))
    if not models:
        raise PoundingError(f"the results hold no fragility of damage: {'; '.join(notes)}")
    method = str(dataset.attrs["method"])
    basis = f"curves of damage states: {method}, {METHODS[method].words}"
    return Fragilities(measure, tuple(models), str(dataset.attrs.get("title", "")), (basis, *notes))


def damage_dataset(results: xr.Dataset, options: Options) -> xr.Dataset:
    """The dataset of `damage`, computed from results of `scan` where it is not given itself."""
    from pounding_risk.questions.damage import damage

    is_fitted = kind_of(results) == "damage"
    for name in ("gap", "pga", "intensity_level", "intensity", "method") if is_fitted else ("pga", "intensity_level"):
        if getattr(options, name) is not None:
            option = f"--{name.replace('_', '-')}"
            if is_fitted:
                raise PoundingError(f"{option}: the curves of this dataset are fitted; give {option} to `damage`")
            raise PoundingError(f"{option}: curves of damage are of all levels; leave it out")
    if is_fitted:
        return results
    if not Results(results).scene.get("damage"):
        raise PoundingError(
            "--of damage: the scene has no [[damage]]; write `pounding-risk damage results.nc --states FILE -o "
            "damage.nc`, and export that file"
        )
    return damage(results, gap=options.gap, intensity=options.intensity, method=options.method)


def _damage_curves(states: Sequence[Any], dataset: xr.Dataset, measure: Intensity) -> tuple[Curve, ...]:
    """The curves of states, each at one side, in the unit of the intensity."""
    from pounding_risk.assessment.damage_words import case_words

    names = distinct((identifier_of(str(state["state"].item()))[:LONGEST_STATE] for state in states), "state")
    case_text = case_words(dataset)  # "gap 10 mm, jankowski; 44 motions ..."; gap and contact are of pounding alone
    curves = []
    for name, state in zip(names, states, strict=True):
        side = str(state["pounding"].item())
        side_text = case_text if side == POUNDING[0] else case_text.partition("; ")[2]
        words = f"{state['state_words'].item()}, {side} pounding, {side_text}, {dataset.attrs['method']}"
        errors = float(state["median_error"]), float(state["dispersion_error"])
        median, dispersion = float(state["median"]) / measure.size, float(state["dispersion"])
        curves.append(Curve(name, words, median, dispersion, errors, int(state["runs"].sum())))
    return tuple(curves)


def crossing(function: Function, measure: Intensity) -> str:
    """Sentence on the first two curves of a function that cross within its range; "" where each holds the next.

    Φ((ln x − ln θ)/β) of two curves differ in their arguments by a straight line in ln x: they are ordered throughout
    where they are at both ends.
    """
    for lower, higher in pairwise(function.curves):
        if all(
            log(im / lower.median) / lower.dispersion >= log(im / higher.median) / higher.dispersion
            for im in function.ends
        ):
            continue
        slope, where = lower.dispersion - higher.dispersion, ""
        if slope:
            meet = (log(higher.median) * lower.dispersion - log(lower.median) * higher.dispersion) / slope
            where = f" at {measure.imt} {exp(meet):.3g} {measure.unit}"
        return (
            f"{function.identifier}: the curves of {lower.state} and {higher.state} cross{where}, within the range "
            "that is written, and so they are no ordered limit states; each state is a model of its own"
        )
    return ""
