"""Fragilities for pelicun: a CSV of limit states with the head of its Damage and Loss Model Library, and their words.

Limit states are against the intensity of the ground (``PGA``, ``SA_0.5``, ``PGV``), as the demand at location 0 in
direction 1: components stand there. Directional, since pelicun multiplies what is not by 1.2 for two directions.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator
from io import StringIO
from typing import TYPE_CHECKING, Any, NamedTuple

from pounding_risk.assessment.demands import resolved_intensity
from pounding_risk.errors import PoundingError
from pounding_risk.reports.exports._curves import KINDS, Fragilities, Function, Known, distinct, known_measure
from pounding_risk.reports.exports._damage import fragilities_of
from pounding_risk.reports.exports._written import Asked
from pounding_risk.results.attributes import tables_of
from pounding_risk.results.check import kind_of

if TYPE_CHECKING:
    import xarray as xr

PREFIX = "PND"  # of pounding; the libraries of pelicun have no such components
HEAD = ("ID", "Incomplete", "Demand-Type", "Demand-Unit", "Demand-Offset", "Demand-Directional")
OF_STATE = ("Family", "Theta_0", "Theta_1", "DamageStateWeights")
UNITS = {"g": "g", "cm/s": "cmps"}  # of intensities, in pelicun
SIDES = ("with", "without")


class Component(NamedTuple):
    """A component of pelicun: its limit states, and the words of each."""

    identifier: str
    function: Function


class Components(NamedTuple):
    """Components against one intensity, and what is left out."""

    measure: Known | None
    components: tuple[Component, ...]
    told: tuple[str, ...]


def components_of(results: xr.Dataset, asked: Asked) -> Components:
    """The components of contact, yielding and damage states, or of the one kind that is asked for.

    Raises PoundingError for an intensity that pelicun does not know, and where what is asked for has none.
    """
    kinds = (asked.of,) if asked.of else _kinds(results)
    if asked.intensity is not None and kind_of(results) != "damage":
        known_measure(resolved_intensity(results, asked.intensity))
    measure, named, told = None, [], []
    faults: list[PoundingError] = []
    for kind in kinds:
        for side in SIDES if kind == "damage" else SIDES[:1]:
            try:
                found = fragilities_of(results, _asked(asked, kind, side))
            except PoundingError as error:
                faults.append(error)
                told.append(f"{kind}{' without pounding' if side == 'without' else ''}: {error}")
                continue
            measure = found.measure
            told += found.told
            named += list(_named(found, kind, side))
    if faults and not named and len(kinds) == 1:
        raise faults[0]
    names = distinct(name for name, _ in named)
    components = (Component(name, function) for name, (_, function) in zip(names, named, strict=True))
    return Components(measure, tuple(components), tuple(dict.fromkeys(told)))


def _kinds(results: xr.Dataset) -> tuple[str, ...]:
    """The kinds of failure that a dataset may have fragilities of."""
    if kind_of(results) == "damage":
        return ("damage",)
    has_states = bool(tables_of(results.attrs["scene_resolved"]).get("damage"))
    return KINDS if has_states else KINDS[:2]


def _asked(asked: Asked, kind: str, side: str) -> Asked:
    """The options of a kind: those of the demands' amplitude do not matter to curves of damage."""
    if kind != "damage":
        return asked._replace(of=kind, method=None)  # which is of damage states
    return asked._replace(of=kind, without=side == "without", pga=None, intensity_level=None)


def _named(found: Fragilities, kind: str, side: str) -> Iterator[tuple[str, Function]]:
    """Functions by an identifier without "-", which pelicun parts the location and direction with."""
    for model in found.models:
        for function in model.functions:
            place = model.identifier if kind == "damage" else function.identifier
            parts = (PREFIX, kind, place, side) if kind == "damage" else (PREFIX, kind, place)
            yield ".".join(parts).replace("-", "_"), function


def demand_type(measure: Known) -> str:
    """The demand as pelicun calls it in words, "Spectral Acceleration|0.5"."""
    if measure.imt.startswith("SA("):
        return f"Spectral Acceleration|{measure.imt[3:-1]}"
    return {"PGA": "Peak Ground Acceleration", "PGV": "Peak Ground Velocity"}[measure.imt]


def demand_name(measure: Known) -> str:
    """The column of a file of demands that the components want, "1-SA_0.5-0-1"."""
    return f"1-{measure.imt.replace('(', '_').rstrip(')')}-0-1"


def fragility_table(measure: Known, components: tuple[Component, ...]) -> str:
    """The text of the file of fragilities."""
    most = max(len(component.function.curves) for component in components)
    out = StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([*HEAD, *(f"LS{number}-{name}" for number in range(1, most + 1) for name in OF_STATE)])
    for name, function in components:
        cells = [name, 0, demand_type(measure), UNITS[measure.unit], 0, 1]
        for curve in function.curves:
            cells += ["lognormal", repr(curve.median), repr(curve.dispersion), ""]
        writer.writerow(cells + [""] * (len(HEAD) + most * len(OF_STATE) - len(cells)))
    return out.getvalue()


def fragility_words(components: tuple[Component, ...], title: str) -> str:
    """The text of the file beside it, which says what each component and its states are, as pelicun's libraries do."""
    words: dict[str, dict[str, Any]] = {
        "_GeneralInformation": {
            "ShortName": "pounding-risk",
            "Description": f"Pounding of adjacent buildings: {title}. Each component has the quantity 1 EA.",
            "Version": "1.0",
        }
    }
    for name, function in components:
        words[name] = {
            "Description": function.curves[0].words,
            "SuggestedComponentBlockSize": "1 EA",
            "RoundUpToIntegerQuantity": "True",
            "LimitStates": {
                f"LS{number}": {f"DS{number}": {"Description": f"{curve.state}: {curve.words}; {curve.runs} runs"}}
                for number, curve in enumerate(function.curves, start=1)
            },
        }
    return f"{json.dumps(words, indent=2, ensure_ascii=False)}\n"
