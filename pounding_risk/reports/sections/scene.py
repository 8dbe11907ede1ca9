"""Section on the scene: the buildings, what stands between them, the grid of cases, and what is assumed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from pounding_risk.assessment.row import struck_columns
from pounding_risk.render import sheet
from pounding_risk.reports.data import Pair, ReportData
from pounding_risk.results.attributes import has_own_grounds, moves_across, rotating_buildings
from pounding_risk.results.opened import Results
from pounding_risk.units import SHOWN, legible, rounded

TITLE = "Scene and assumptions"
ORDER = 20
ASSUMED = (
    "Each building is linear, with viscous damping, and moves as one mass; it stands on rigid ground.",
    "The buildings touch at one point, at the height of their masses.",
    "The ground acceleration is linear between the samples of a record.",
)
OF_A_ROW = (
    "Neighbours touch at the contact points that are listed with the row; a column moves with the floors at its ends, "
    "on the straight line between them.",
    ASSUMED[-1],
)


def write(data: ReportData) -> list[sheet.Block]:
    """Buildings, interfaces, the grid of cases and the assumptions."""
    results = data.results
    heads = ["building", sheet.head("mass", "kg"), "period [s]", sheet.head("damping", "%")]
    heads += ["storeys", "height [m]", "in the row"] if data.has_points else []
    rows: list[sheet.Row] = []
    rigid = []
    for name in map(str, results["building"].values):
        building = results.sel(building=name)
        columns = [("building_mass", "kg"), ("building_period", "s"), ("building_damping", "%")]
        row: sheet.Row = [name, *(sheet.number(building[variable], unit) for variable, unit in columns)]
        if data.has_points:
            row += [sheet.count(building["building_storeys"]), sheet.number(building["building_height"])]
            row.append(str(building["building_position"].values))
        rows.append(row)
        rigid += [name] if np.isnan(building["building_period"]) else []
    interfaces = data.scene["interface"]
    pair_tables = [interfaces[min(index, len(interfaces) - 1)] for index in range(len(data.pairs))]
    return [
        sheet.table("Buildings, left to right.", heads, rows),
        *([sheet.paragraph(f"{' and '.join(rigid)}: rigid, moves with the ground.")] if rigid else []),
        *([sheet.paragraph(" ".join(isolated))] if (isolated := [*_of_isolated(data)]) else []),
        *(
            sheet.facts(f"Between {pair.name.replace(' | ', ' and ')}.", _interface_rows(pair, keys))
            for pair, keys in zip(data.pairs, pair_tables, strict=True)
        ),
        sheet.facts("The grid of cases.", _grid(data)),
        sheet.heading("Assumptions", "assumptions"),
        sheet.listing([*([*_of_storeys(data.scene), *OF_A_ROW] if data.has_points else ASSUMED), *_assumed(data)]),
    ]


def _of_isolated(data: ReportData) -> Iterator[str]:
    """The period of each isolated building while its isolators yield, and whether its storeys may."""
    can_yield = "inelastic_storeys" in data.scene.get("effects", {})
    strong = {one["name"]: "storey_strengths" in one for one in data.scene["building"]}
    for name, period in data.isolated_periods.items():
        storeys = "may yield too" if can_yield and strong[name] else "stay elastic"
        yield (
            f"{name}: the period is that before its isolators yield; while they yield it is "
            f"{sheet.amount(period, 's')['text']}. Storeys above them {storeys}."
        )


def _interface_rows(pair: Pair, keys: Mapping[str, Any]) -> Iterator[tuple[str, sheet.Cell | str]]:
    """The keys of an interface as the scene's file has them, and the strengths of the columns that floors meet.

    The gap and the yield force are in the units of readers, a yield force that no contact has is left out.
    """
    struck = struck_columns(Results(pair.results), 0, pair.assessed.gap)
    only_columns = len(struck) == pair.results.sizes.get("contact_point", 1)
    for key, value in keys.items():
        if key == "gap":
            yield "gap", sheet.amount(float(value.split()[0]), "m")
        elif key == "yield_force" and not only_columns:
            yield "yield force F_E", _force(float(str(value).split()[0]), "none: never yields")
        elif key not in ("yield_force", "column_yield_force"):
            yield key.replace("_", " "), _value_words(value)
    by_value: dict[tuple[str, float], list[str]] = {}
    for column in struck:
        storey, _, building = column.column.removeprefix("storey ").partition(" of ")
        by_value.setdefault((building, column.strength), []).append(storey)
    for (building, strength), storeys in by_value.items():
        yield f"strength of columns of {building}, storey {', '.join(storeys)}", _force(strength, "none given")


def _force(force: float, without: str) -> sheet.Cell:
    return {"text": without, "raw": None} if np.isinf(force) else sheet.amount(force, "N")


def _value_words(value: Any) -> str:
    """A value of a resolved scene, where quantities are in SI, in words and in the units of tables."""
    if isinstance(value, dict):
        return ", ".join(f"{key.replace('_', ' ')} {_value_words(item)}" for key, item in value.items()) or "no options"
    if isinstance(value, list):
        return ", ".join(map(_value_words, value))
    first, _, unit = str(value).partition(" ")
    try:
        name, factor = SHOWN.get(unit or "1", (unit, 1.0))
        number = rounded(factor * float(first))
        return legible(value) if "e" in number and unit and "^" not in unit else f"{number} {name}".strip()
    except ValueError:
        return str(value).replace("_", " ")


def _grid(data: ReportData) -> list[tuple[str, sheet.Cell | str]]:
    results = data.results
    rows: list[tuple[str, sheet.Cell | str]] = [("cases", sheet.count(results["status"].size))]
    rows.append(("records", sheet.count(results.sizes["record"])))
    rows.append(("polarity", ", ".join(map(str, results["polarity"].values))))
    amplitudes = Results(results).amplitudes
    if amplitudes.axis not in results.coords:
        rows.append(("amplitude", Results(results).amplitude_words()))
    gap_words = "gap of the interface that varies, or of the first" if "interface_gap" in results.variables else "gap"
    amplitude = amplitudes.axis, f"amplitude ({amplitudes.measure.words})", amplitudes.measure.unit
    for name, words, unit in (amplitude, ("gap", gap_words, "m"), ("yield_force", "F_E", "N")):
        if name not in results.coords:
            continue
        labels = np.atleast_1d(results[name].values)
        is_own = name == "yield_force" and np.isinf(labels).all() and "contact_point_yield_force" in results.variables
        rows.append((words, "that of the columns" if is_own else _span(labels, unit)))
    rows.append(("contact models", ", ".join(map(sheet.name_of, data.laws))))
    return rows


def _span(labels: Any, unit: str) -> sheet.Cell:
    finite = labels[np.isfinite(labels)]
    cells = [sheet.amount(end, unit) for end in dict.fromkeys((finite.min(), finite.max()))] if finite.size else []
    text = " to ".join(end["text"] for end in cells)
    if len(finite) > 1:
        text += f", {len(finite)} values"
    if len(finite) < len(labels):
        text = f"{text}, and never yielding" if text else "never yields"
    return {"text": text, "parts": [end["raw"] for end in cells]}


def _of_storeys(scene: Mapping[str, Any]) -> Iterator[str]:
    """How the buildings of a row move, and what joins their floors, by the tables of the scene."""

    def named(key: str) -> str:
        return " and ".join(str(building["name"]) for building in scene["building"] if key in building)

    moves = "Buildings move along the row only"
    if rotating := rotating_buildings(scene):
        moves = f"Buildings move along the row, and floors of {' and '.join(rotating)} rotate in plan too"
    if across := [name for name in rotating if moves_across(scene, name)]:
        moves += f"; those of {' and '.join(across)} move across the row as well, under the second component"
    yield f"{moves}; floors are rigid, and each storey is a spring with viscous damping."
    if by_matrix := named("stiffness_matrix"):
        yield f"The floors of {by_matrix} are joined by a stiffness matrix in place of storey springs."
    if split := [
        str(one["name"]) for one in scene["building"] if {"stiffness_matrix", "storey_strengths"} <= one.keys()
    ]:
        yield f"Storeys of {' and '.join(split)} that may yield are a part of it: storey shears are those of this part."
    if by_masses := named("mass_matrix"):
        yield f"Masses of {by_masses} are a matrix: floors have inertia against each other's accelerations too."
    if by_modes := named("interior_masses"):
        yield (
            f"Between the floors of {by_modes} the model moves statically and in interior modes (Craig and Bampton "
            "1968); tables and figures show its floors alone."
        )
    if isolated := named("isolation"):
        yield f"{isolated}: on isolators, a bilinear spring with viscous damping below the slab."
    if "inelastic_storeys" in scene.get("effects", {}):
        rules = {str(one["name"]): one["hysteresis"]["rule"] for one in scene["building"] if "hysteresis" in one}
        rule_text = "".join(f", those of {name} by the rule {rule}" for name, rule in rules.items())
        yield f"Storeys with a strength yield{rule_text}, and others stay elastic."
    if names := named("displacement_history"):
        yield f"{names}: moves as its files say, and contacts are not run."


def _assumed(data: ReportData) -> list[str]:
    """Further assumptions that follow from the scene's own keys."""
    sentences = []
    effects = data.scene.get("effects", {})
    if not has_own_grounds(data.scene):
        sentences.append(f"{'All' if data.several else 'Both'} buildings stand on the same motion at the same time.")
    elif "wave_passage" not in effects:
        sentences.append("Buildings stand on unlike grounds, as their keys ground_ say; peaks are relative to these.")
    results = Results(data.results)
    if linked := [pair.name.replace(" | ", " and ") for k, pair in enumerate(data.pairs) if results.has_link(k)]:
        sentences.append(
            f"Springs or dampers without mass join {', '.join(linked)}; what is called without contact has them too."
        )
    if "permanent_set" not in effects and np.isfinite(data.results["yield_force"].values).any():
        sentences.append(
            "Yielding leaves no permanent indentation: laws with a yield force retrace their plateau, as published, "
            "unless the effect permanent_set is named."
        )
    held_cases = int((data.results["restitution_held"] > 0).sum()) if "restitution_held" in data.results else 0
    if held_cases:
        sentences.append(
            f"In {held_cases} cases contacts are faster than the range of the restitution relation, which is held at "
            "its end."
        )
    return sentences
