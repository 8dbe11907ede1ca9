"""Fragilities of a kind; those of damage states as ordered limit states: of one demand in one place, lowest first.

Other tools take the probability of being in a state as the difference of two curves. That holds where no curve crosses
the next within the range that is written; states whose curves do are models of their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import exp, log
from typing import TYPE_CHECKING, Any

from pounding_risk.assessment.damage_curves import POUNDING
from pounding_risk.errors import PoundingError
from pounding_risk.reports.exports._curves import (
    KINDS,
    STATES,
    Curve,
    Fragilities,
    Function,
    Known,
    Model,
    distinct,
    identifier_of,
    known_measure,
    of_assessment,
)
from pounding_risk.reports.exports._written import Asked
from pounding_risk.results.attributes import tables_of
from pounding_risk.results.kinds import kind_of
from pounding_risk.statistics.damage_fits import METHODS

if TYPE_CHECKING:
    import xarray as xr

LONGEST_STATE = 70  # characters of the name of a limit state; OpenQuake takes 75


def fragilities_of(results: xr.Dataset, asked: Asked) -> Fragilities:
    """The fragilities of one kind of failure; raises PoundingError where there are none, with why."""
    kind = asked.of or ("damage" if kind_of(results) == "damage" else KINDS[0])
    if kind not in KINDS:
        raise PoundingError(f"--of: {kind!r} is none; it may be {' or '.join(KINDS)}")
    if kind == "damage":
        return of_damage(results, asked)
    if asked.method is not None:
        raise PoundingError(f"--method: is of damage states, and has no effect on {kind}; leave it out")
    if kind_of(results) == "damage":
        raise PoundingError(f"--of: {kind} is assessed from results of scan, and this dataset is of damage states")
    if asked.without:
        raise PoundingError(f"--without: without pounding there is no {STATES[kind]}; write --of damage")
    return of_assessment(results, asked, kind)


def of_damage(results: xr.Dataset, asked: Asked) -> Fragilities:
    """The fragilities of damage states with pounding, or without; raises PoundingError where there are none."""
    dataset = damage_dataset(results, asked)
    measure = known_measure(str(dataset.attrs["intensity"]))
    side = POUNDING[asked.without]
    models: list[Model] = []
    told: list[str] = []
    method = str(dataset.attrs["method"])
    groups = _groups(dataset)
    names = distinct((identifier_of(words) for words in groups), "damage")
    for name, states in zip(names, groups.values(), strict=True):
        curved = []
        for state in states:
            one = dataset.sel(state=state, pounding=side)
            if fault := str(one["fault"].item()):
                told.append(f"{state}, {side} pounding: no curve, {fault}")
            else:
                curved.append(one)
        if curved:
            function = Function(name, _curves(curved, dataset, measure))
            crossed = crossing(function, measure)
            told += [crossed] if crossed else []
            models += _models(function, bool(crossed))
    if not models:
        raise PoundingError(f"the results hold no fragility of damage: {'; '.join(told)}")
    about = f"curves of damage states: {method}, {METHODS[method].words}"
    return Fragilities(measure, tuple(models), str(dataset.attrs.get("title", "")), (about, *told))


def damage_dataset(results: xr.Dataset, asked: Asked) -> xr.Dataset:
    """The dataset of `damage`, made of results of `scan` where it is not given itself."""
    from pounding_risk.assessment.damage import damage

    if kind_of(results) != "damage":
        for name in ("pga", "intensity_level"):
            if getattr(asked, name) is not None:
                raise PoundingError(f"--{name.replace('_', '-')}: curves of damage are of all levels; leave it out")
        if not tables_of(results.attrs["scene_resolved"]).get("damage"):
            raise PoundingError(
                "--of damage: the scene has no [[damage]]; write `pounding-risk damage results.nc --states FILE -o "
                "damage.nc`, and export that file"
            )
        return damage(results, gap=asked.gap, intensity=asked.intensity, method=asked.method)
    for name in ("gap", "pga", "intensity_level", "intensity", "method"):
        if getattr(asked, name) is not None:
            option = name.replace("_", "-")
            raise PoundingError(f"--{option}: the curves of this dataset are fitted; give --{option} to `damage`")
    return results


def _groups(dataset: xr.Dataset) -> dict[str, list[str]]:
    """Names of the states by their demand and place, "storey drift of frame", in the order of their thresholds."""
    groups: dict[str, list[tuple[float, str]]] = {}
    for name, words, threshold in zip(
        *(dataset[name].values.tolist() for name in ("state", "state_words", "state_threshold")), strict=True
    ):
        groups.setdefault(words.partition(" ≥ ")[0], []).append((threshold, name))
    return {words: [name for _, name in sorted(states)] for words, states in groups.items()}


def _curves(states: Sequence[Any], dataset: xr.Dataset, measure: Known) -> tuple[Curve, ...]:
    """The curves of states, each at one side, in the unit of the intensity."""
    from pounding_risk.assessment.damage_words import case_words

    names = distinct((identifier_of(str(one["state"].item()))[:LONGEST_STATE] for one in states), "state")
    curves = []
    for name, one in zip(names, states, strict=True):
        side = str(one["pounding"].item())
        about = case_words(dataset)  # "gap 10 mm, jankowski; 44 motions ..."; gap and contact are of pounding alone
        about = about if side == POUNDING[0] else about.partition("; ")[2]
        words = f"{one['state_words'].item()}, {side} pounding, {about}, {dataset.attrs['method']}"
        errors = float(one["median_error"]), float(one["dispersion_error"])
        median, dispersion = float(one["median"]) / measure.size, float(one["dispersion"])
        curves.append(Curve(name, words, median, dispersion, errors, int(one["runs"].sum())))
    return tuple(curves)


def crossing(function: Function, measure: Known) -> str:
    """Sentence on the first two curves of a function that cross within its range; "" where each holds the next.

    Φ((ln x − ln θ)/β) of two curves differ in their arguments by a straight line in ln x: they are ordered throughout
    where they are at both ends.
    """
    for lower, higher in pairwise(function.curves):
        apart = [(log(x / lower.median) / lower.dispersion, log(x / higher.median) / higher.dispersion)
                 for x in function.ends]  # fmt: skip
        if all(one >= other for one, other in apart):
            continue
        slope = lower.dispersion - higher.dispersion
        where = ""
        if slope:
            meet = (log(higher.median) * lower.dispersion - log(lower.median) * higher.dispersion) / slope
            where = f" at {measure.imt} {exp(meet):.3g} {measure.unit}"
        return (
            f"{function.identifier}: the curves of {lower.state} and {higher.state} cross{where}, within the range "
            "that is written, and so they are no ordered limit states; each state is a model of its own"
        )
    return ""


def _models(function: Function, is_crossed: bool) -> list[Model]:
    """The model of a function, or one for each of its states."""
    if not is_crossed:
        return [Model(function.identifier, tuple(curve.state for curve in function.curves), (function,))]
    return [
        Model(f"{function.identifier}_{curve.state}", (curve.state,), (Function(function.identifier, (curve,)),))
        for curve in function.curves
    ]
