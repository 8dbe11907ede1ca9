"""Rows of a street as scene files, and the list of filled values as CSV."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from math import isnan
from typing import TYPE_CHECKING, Any, NamedTuple

from pounding_risk._common.letters import csv_text
from pounding_risk.errors import PoundingError
from pounding_risk.motions.request import SOURCES
from pounding_risk.scene.toml import write_toml
from pounding_risk.statistics.sobol import LEAST_SAMPLES
from pounding_risk.streets.hazus import STATES
from pounding_risk.streets.neighbours import floors
from pounding_risk.units import GAP, MASS, PERIOD, STIFFNESS, STOREY_STRENGTH, Quantity, exact, parse, say, shown

if TYPE_CHECKING:
    from pounding_risk.streets.defaults import Filled, House
    from pounding_risk.streets.neighbours import BlockRow, ClosePair, Neighbours

FILLED = "filled.csv"
SECTIONS = ("effects", "records", "grid", "uncertain", "solver")
SAMPLES = LEAST_SAMPLES  # of uncertain gaps; as a power of two balanced
POLARITIES = ["as recorded", "reversed"]  # a row is not symmetric
DEGREE_DIGITS = 6  # of the middle of a row, 0.1 m
LISTED = 3  # values of a column that are listed one by one


class Contact(NamedTuple):
    """The contact of every interface of a row, as a scene file writes it.

    Parameters
    ----------
    contact_model : str
        Law of contact.
    stiffness : str, optional
        Its stiffness; None leaves the key out, as for the others.
    restitution : str or float, optional
        Coefficient of restitution, or its relation to the velocity.
    yield_force : str, optional
        Force at which the contact yields.
    column_yield_force : str, optional
        Force at which a column that a floor hits yields.
    tolerance : str, optional
        Of the levels of floors that meet, in place of the depth of the floors.
    """

    contact_model: str = "jankowski"
    stiffness: str | None = "8e10 N/m^1.5"  # a contact of floors of hundreds of tons within a tenth of 0.2 s
    restitution: str | float | None = 0.65
    yield_force: str | None = None
    column_yield_force: str | None = None
    tolerance: str | None = None  # of the levels of floors that meet, in place of the floors' depth


CONCRETE = Contact()  # e of concrete as of Jankowski (2005), whose β, of blocks of half a ton, is too soft for floors


class Share(NamedTuple):
    """The values of one column that one rule filled: their number, and the values in words."""

    column: str
    number: int
    values: str
    rule: str


def shares(filled: Iterable[Filled]) -> list[Share]:
    """Sum up filled values by column and rule.

    Parameters
    ----------
    filled : iterable of Filled
        Values that were filled in.

    Returns
    -------
    list of Share
        One for each column and rule, in the order met.
    """
    groups: dict[tuple[str, str], list[str]] = {}
    for default in filled:
        groups.setdefault((default.column, default.rule), []).append(default.value)
    summary = []
    for (column, rule), cells in groups.items():
        distinct = list(dict.fromkeys(cells))
        more_text = f", ... ({len(distinct)} values)" if len(distinct) > LISTED else ""
        summary.append(Share(column, len(cells), f"{', '.join(distinct[:LISTED])}{more_text}", rule))
    return summary


def filled_csv(filled: Iterable[Filled]) -> str:
    """Every filled value as CSV: street, building, column, value, rule."""
    return csv_text([("street", "building", "column", "value", "rule"), *filled])


def slug(name: str) -> str:
    """A name as that of a file: letters and digits of any alphabet in lower case, the rest hyphens."""
    return re.sub(r"\W+", "-", name.lower()).strip("-_") or "row"


def scene_text(
    row: BlockRow,
    filled: Sequence[Filled],
    close: Sequence[ClosePair],
    source: str,
    *,
    records: Sequence[str] | None,
    contact: Contact,
    tables: Mapping[str, Any] | None,
    gaps: str = "",
) -> str:
    """The scene of a row as TOML, with comments on the origin of its numbers; ``gaps`` says how well gaps are known.

    Raises PoundingError for a section of ``tables`` that belongs to the buildings.
    """
    own_tables = dict(tables or {})
    for name in own_tables:
        if name not in SECTIONS:
            raise PoundingError(f"tables: {shown(name)} cannot be given; it may be {', '.join(SECTIONS)}")
    own_records = own_tables.get("records", {})
    middle = _middle_of_row(row) if "sites" in own_records else {}
    # Names, where no other source is given, and both polarities.
    has_source = records is None and any(key in own_records for key in SOURCES)
    names = {} if has_source else {"names": horizontal_records() if records is None else list(records)}
    keys_of_records = {**names, "polarity": POLARITIES, **own_records, **({"place": middle} if middle else {})}
    all_tables: dict[str, Any] = {**own_tables, "records": keys_of_records, "uncertain": _uncertain(row, own_tables)}
    if not all_tables["uncertain"]:
        del all_tables["uncertain"]
    document: dict[str, Any] = {
        "scene": {"name": f"{row.name}, {row.buildings[0].name} to {row.buildings[-1].name}"},
        "building": [_building(house) for house in row.buildings],
        "interface": [_interface(pair, contact) for pair in row.pairs],
        **{name: all_tables[name] for name in SECTIONS if name in all_tables},
    }
    damage = [
        {"name": f"{house.name}, {state}", "building": house.name, "drift": drift}
        for house in row.buildings
        if house.chain is not None
        for state, drift in zip(STATES, house.chain.drifts, strict=True)
    ]
    if damage:
        document["effects"] = {"inelastic_storeys": {}, **document.get("effects", {})}
        document["damage"] = damage
    return "".join(f"# {line}\n" for line in _origins(row, filled, close, source, gaps)) + "\n" + write_toml(document)


def _interface(pair: Neighbours, contact: Contact) -> dict[str, Any]:
    """The table of an interface: its gap, and the keys of the contact with an effect where these floors meet."""
    keys = {key: value for key, value in contact._asdict().items() if value is not None}
    meet, miss, _ = floors(pair.left, pair.right, None if contact.tolerance is None else parse(contact.tolerance, GAP))
    for key, number in (("yield_force", meet), ("column_yield_force", miss)):
        if number == 0:
            keys.pop(key, None)
    return {"gap": written(pair.gap, GAP), **keys}


def _origins(row: BlockRow, filled: Sequence[Filled], close: Sequence[ClosePair], source: str, gaps: str) -> list[str]:
    """Comments on the origin of a scene's numbers, and on the close buildings that it does not hold."""
    lines = [f"{len(row.buildings)} buildings of {source}, side by side; written by pounding-risk block."]
    if not isnan(row.direction):
        lines.append(f"From left to right is {row.direction:.1f} degrees clockwise from north.")
    if gaps:
        lines.append(f"{gaps[0].upper()}{gaps[1:]}.")
    if filled:
        lines.append("Filled in, as the table does not say:")
        lines += [f"  {each.column} of {each.number}: {each.values}; {each.rule}" for each in shares(filled)]
    partial = [neighbours for neighbours in row.pairs if neighbours.is_partial]
    if partial:
        lines.append("Neighbours that face each other over a part of the shorter front, taken as full neighbours:")
        lines += [f"  {each.left.name} | {each.right.name}: {each.faced_words}" for each in partial]
    if close:
        lines.append("Close to a building of this row, and not in it as its neighbour:")
        lines += [f"  {each.words}" for each in close]
    return lines


def _uncertain(row: BlockRow, own_tables: Mapping[str, Any]) -> dict[str, Any]:
    """The table [uncertain] of a row: its measured gaps within the resolution, beside the given table.

    Gaps that the given tables vary, by [grid] or by a distribution, are not added.
    """
    given = dict(own_tables.get("uncertain", {}))
    numbers = given.get("numbers", {})
    varied_keys = [*own_tables.get("grid", {}), *given, *(numbers if isinstance(numbers, Mapping) else ())]
    if any(key == "gap" or (key.startswith("interface") and key.endswith("gap")) for key in varied_keys):
        return given
    gap_tables = {}
    for number, pair in enumerate(row.pairs, start=1):
        if pair.resolution > 0.0 and pair.gaps[1] > 0.0:
            low, high = (written(end, GAP) for end in pair.gaps)
            gap_tables[f"interface.{number}.gap"] = {"distribution": "uniform", "low": low, "high": high}
    if gap_tables:
        return {"samples": SAMPLES, **given, **gap_tables}
    return given if set(given) - {"samples", "method", "seed"} else {}  # no number of this row is uncertain


def _middle_of_row(row: BlockRow) -> dict[str, float]:
    """The middle of a row in degrees, the mean of its buildings' middles; empty where it is not known."""
    mapped = [house.mapped for house in row.buildings if house.mapped is not None and not isnan(house.mapped.longitude)]
    if not mapped:
        return {}
    first = mapped[0].longitude  # across the meridian of 180 degrees longitudes go on
    east = sum((item.longitude - first + 180.0) % 360.0 - 180.0 for item in mapped) / len(mapped)
    longitude = (first + east + 180.0) % 360.0 - 180.0
    latitude = sum(item.latitude for item in mapped) / len(mapped)
    return {"longitude": round(longitude, DEGREE_DIGITS), "latitude": round(latitude, DEGREE_DIGITS)}


def horizontal_records() -> list[str]:
    """List the horizontal records of the catalogue.

    Returns
    -------
    list of str
        Their ids.
    """
    from pounding_risk.motions.catalogue import entries

    return [entry.id for entry in entries() if entry.horizontal]


def _building(house: House) -> dict[str, Any]:
    """The table of a building: of a typology, or with its storeys by Hazus."""
    more_keys = {"damping": house.damping, "floor_depth": written(house.floor_depth, GAP)}
    if (chain := house.chain) is not None:
        return {
            "name": house.name,
            "floor_masses": written(house.floor_mass, MASS),
            "storey_stiffnesses": written(chain.stiffness, STIFFNESS),
            "storey_heights": written(house.height / house.storeys, GAP),
            "storey_strengths": [written(strength, STOREY_STRENGTH) for strength in chain.strengths],
            "storeys": house.storeys,
            **more_keys,
        }
    return {
        "name": house.name,
        "height": written(house.height, GAP),
        "storeys": house.storeys,
        "typology": house.typology,
        "floor_mass": written(house.floor_mass, MASS),
        **({} if house.period is None else {"period": written(house.period, PERIOD)}),
        **more_keys,
    }


def written(value: float, quantity: Quantity) -> str:
    """A value in a usual unit, from which the very same number is read back."""
    for digits in (4, 6, 9):
        text = say(value, quantity, digits)
        if parse(text, quantity) == value:
            return text
    return str(exact(value, quantity))
