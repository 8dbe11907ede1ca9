"""Traps for who adds a key or an output: each declaration reaches what is made of it, or its file is named."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from pounding_risk.results.variables import VARIABLES
from pounding_risk.scene.buildings import KINDS, RigidWall, ShearBuilding, SingleMass, TypologyBuilding, table_of
from pounding_risk.solver.pair.outputs import BUILDING, RUN

# A value of each key that differs from its default; a kind that has a key without one here fails below.
VALUES: dict[str, Any] = {
    "name": "hall",
    "mass": 44e3,
    "period": 0.5,
    "stiffness": 40e6,
    "damping": 0.07,
    "damping_rule": "rayleigh",
    "floor_length": 17.0,
    "wave_speed": 3000.0,
    "height": 9.0,
    "floor_depth": 0.31,
    "initial_displacement": 0.01,
    "initial_velocity": 0.2,
    "ground_factor": -0.5,
    "ground_delay": 0.1,
    "ground_velocity": 0.3,
    "ground_record": ("a.AT2",),
    "floor_masses": (50e3, 40e3),
    "storey_stiffnesses": (60e6, 50e6),
    "storey_heights": (4.0, 3.0),
    "storey_strengths": (2e6, 1e6),
    "storeys": 2,
    "typology": "masonry",
    "floor_mass": 60e3,
    "rigid": True,
}
# A moving building is not rigid, k follows from mass and period, a typology becomes the storeys that it generates, and
# the depth of floors becomes the contact points, which a scene writes with its interfaces.
NOT_KEPT = {
    SingleMass: {"rigid", "stiffness", "floor_depth"},
    RigidWall: {"floor_depth"},
    ShearBuilding: {"rigid", "storeys", "floor_depth"},
    TypologyBuilding: {"rigid", "typology", "floor_mass", "height", "period", "storeys", "floor_depth"},
}


def kept() -> Iterator[Any]:
    for kind in KINDS:
        yield from (
            pytest.param(kind, key, id=f"{kind.__name__}-{key}")
            for key in sorted(set(kind.model_fields) - NOT_KEPT[kind])
        )


@pytest.mark.parametrize(("kind", "key"), [*kept()])
def test_every_key_of_a_building_comes_back_from_its_structure(kind, key):
    """A key that a structure drops is lost by `to_toml`: it belongs into structure() and table_of()."""
    wanted = set(kind.model_fields) - ({"rigid", "stiffness"} if kind is not RigidWall else set())
    values = {name: VALUES[name] for name in wanted}
    back = table_of(kind.made(values).structure())
    assert key in type(back).model_fields, f"{key}: scene/buildings.py, table_of: no table of the structure has it"
    value, asked = getattr(back, key), VALUES[key]
    if isinstance(value, tuple) and not isinstance(asked, tuple):
        asked = (asked,) * len(value)
    assert value == asked, f"{key}: lost; scene/buildings.py, {kind.__name__}.structure() and table_of()"


def test_every_output_of_a_run_has_its_place_in_a_dataset():
    """One without a row would end in a KeyError where datasets are laid out."""
    for name in {*RUN, *BUILDING}:
        assert name in VARIABLES, f"{name}: declare its dimensions and unit in pounding_risk/results/variables.py"
