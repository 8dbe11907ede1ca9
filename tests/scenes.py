"""Scenes for tests as TOML text: a call gives what is special about a scene, the rest has defaults."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

BOTH = ["as recorded", "reversed"]
STIFFNESS = {"linear": "1e5 kN/m", "hertz": "4.2e7 kN/m^1.5"}  # of these laws; they take no restitution


def single(name: str, mass: str, period: str, **keys: Any) -> dict[str, Any]:
    """A building with one degree of freedom."""
    return {"name": name, "mass": mass, "period": period, **keys}


def storeyed(name: str, masses: Any, stiffnesses: Any, heights: Any = "3 m", **keys: Any) -> dict[str, Any]:
    """A building with storeys; one value for all needs the key ``storeys``."""
    return {"name": name, "floor_masses": masses, "storey_stiffnesses": stiffnesses, "storey_heights": heights, **keys}


def rigid(name: str = "wall", **keys: Any) -> dict[str, Any]:
    """A rigid neighbour."""
    return {"name": name, "rigid": True, **keys}


PAIR = (single("left", "500 t", "0.5 s"), single("right", "800 t", "1.0 s"))
FRAME = single("frame", "44.36 t", "0.208 s")


def scene_text(
    *buildings: Mapping[str, Any],
    name: str = "",
    records: Mapping[str, Any] | None = None,
    effects: Mapping[str, Any] | None = None,
    grid: Mapping[str, Any] | None = None,
    solver: Mapping[str, Any] | None = None,
    interfaces: Sequence[Mapping[str, Any]] | None = None,
    law: str = "jankowski",
    **interface: Any,
) -> str:
    """Text of a scene: `PAIR` with a law of concrete at 10 mm under El Centro 1940, except for what is given.

    ``law`` and further keywords are the keys of the only interface table; a key that is None is left out.
    """
    given = {"gap": "10 mm", "contact_model": law, "stiffness": STIFFNESS.get(law, "2.75e9 N/m^1.5")}
    given |= {} if law in STIFFNESS else {"restitution": 0.65}
    source = {} if {"files", "set", "manifest", "generated"} & set(records or ()) else {"names": ["RSN6-180"]}
    tables: list[tuple[str, Mapping[str, Any] | None]] = [
        ("[scene]", {"name": name} if name else None),
        *(("[[building]]", building) for building in buildings or PAIR),
        *(("[[interface]]", table) for table in (interfaces or [given | interface])),
        ("[records]", source | dict(records or {})),
        ("[effects]", effects),
        ("[grid]", grid),
        ("[solver]", solver),
    ]
    return "".join(_table(head, table) for head, table in tables if table is not None)


def damage_text(states: Mapping[str, Mapping[str, Any]]) -> str:
    """Text of the damage states of a scene, by their names."""
    return "".join(_table("[[damage]]", {"name": name, **keys}) for name, keys in states.items())


def two_records(**interface: Any) -> str:
    """A pair of 10 t and 20 t under two records: linear contact at 20 mm, a grid of 4 gaps and 2 amplitudes."""
    return scene_text(
        single("left", "10 t", "0.5 s"),
        single("right", "20 t", "0.3 s", damping=0.02),
        records={"names": ["RSN6-180", "RSN1690-090"], "window": ["0 s", "8 s"], "polarity": BOTH},
        grid={"gap": ["5 mm", "10 mm", "20 mm", "40 mm"], "pga": ["0.1 g", "0.3 g"]},
        **{"law": "linear", "gap": "20 mm"} | interface,
    )


def yielding_row(length: str) -> str:
    """A row whose storeys yield and whose floors meet columns, so long under two records, with a state of damage."""
    buildings = (
        storeyed("A", "200 t", "200 MN/m", "3.6 m", storeys=2, storey_strengths="900 kN"),
        storeyed("B", "180 t", "400 MN/m", storeys=2, storey_strengths="900 kN"),
        single("C", "150 t", "0.25 s", height="6 m"),
    )
    records = {"names": ["RSN6-180", "NAPA-HNE"], "window": ["0 s", length], "pga": "0.5 g"}
    text = scene_text(*buildings, law="linear", records=records, effects={"inelastic_storeys": {}}, gap="10 mm")
    return text + damage_text({"slight": {"drift": "0.5 %"}})


def _table(head: str, table: Mapping[str, Any]) -> str:
    """A table as TOML writes it, without keys that are None."""
    return "\n".join([head, *(f"{key} = {_value(value)}" for key, value in table.items() if value is not None), ""])


def _value(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {_value(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else str(value)


FOUR_IN_A_ROW = scene_text(
    storeyed("A", "200 t", "9e7 N/m", storeys=3),
    storeyed("B", "150 t", "3e8 N/m", "3.9 m", storeys=2),
    single("C", "500 t", "0.9 s", height="6 m"),
    rigid(),
    name="Four in a row",
    law="viscous_elastoplastic",
    gap="20 mm",
    column_yield_force="600 kN",
    records={"names": ["RSN6-180", "RSN1690-090"], "window": ["0.5 s", "5.5 s"], "pga": "0.5 g", "polarity": BOTH},
    grid={"gap": ["5 mm", "40 mm", "150 mm"], "yield_force": ["500 kN", "50 MN", "inf"]},
)
TWO_AND_A_WALL = scene_text(
    storeyed("tall", "200 t", "180 MN/m", storeys=3),
    single("shop", "150 t", "0.25 s", height="6 m"),
    rigid(),
    interfaces=[
        {
            "gap": "6 mm",
            "contact_model": "jankowski",
            "stiffness": "2.75e9 N/m^1.5",
            "restitution": 0.65,
            "yield_force": "900 kN",
        },
        {"gap": "3 mm", "stiffness": "2.75e9 N/m^1.5", "restitution": 0.65},
    ],
    records={"window": ["1 s", "4 s"]},
    grid={"gap": ["3 mm", "9 mm"], "interface": "tall | shop", "pga": ["0.1 g", "0.3 g"]},
)
