"""From the tables of a scene, each without a fault of its own, to the study, and what only the whole can tell."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from pounding_risk.errors import PoundingError
from pounding_risk.models.contact.impulsive import CONTACT_MODELS
from pounding_risk.models.contact.laws import stiffness_quantity
from pounding_risk.models.contact.relation import AS_PUBLISHED
from pounding_risk.models.effects import EFFECTS
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.motions.request import RecordRequest
from pounding_risk.scene.buildings import building_of
from pounding_risk.scene.interfaces import Beside, contact_points, neighbour
from pounding_risk.scene.scene import Effect, EqualTerms, Grid, Neighbour, Scene, interface_name, stiff_model
from pounding_risk.scene.toml import Fault, KeyPath
from pounding_risk.units import parse

NO_STRENGTHS = (
    "no storey of the scene has a yield shear, so that none would yield; write storey_strengths in a [[building]], or "
    "generate one from a typology, or remove inelastic_storeys"
)
RENAMED = {"polarity": "polarities"}  # keys of [records] that are called otherwise in a study


class Origin(NamedTuple):
    """Where the tables of a scene come from."""

    source: str
    text: str
    lines: Mapping[KeyPath, int]
    overrides: tuple[str, ...]


def assembled(tables: Any, origin: Origin, row: bool) -> tuple[Scene, list[Fault]]:
    """The study, of a ``row`` or of a pair, and its faults: without any, the study holds."""
    grid, records = tables.grid, tables.records
    effects = tuple(found for name in EFFECTS if (found := getattr(tables.effects, name)) is not None)
    buildings, faults = _buildings(tables.building, effects)
    law_name = _shared(tables.interface, "contact_model") or grid.contact_model[0]
    neighbours: tuple[Neighbour, ...] = ()
    if not faults:
        neighbours, faults = _neighbours(tables, buildings, law_name, row)
    first = tables.interface[0]
    gap = _gap(first, grid)
    shared = {key: _shared(tables.interface, key) for key in ("plastic_exponent", "design_penetration")}
    terms = _shared(tables.interface, "equal_terms")
    study = Scene(
        name=tables.scene.name or Path(origin.source).stem,
        buildings=buildings,
        neighbours=neighbours,
        law_name=law_name,
        **shared,
        equal_terms=EqualTerms(**dict(terms)) if terms else None,
        records=RecordRequest(**{RENAMED.get(key, key): value for key, value in records}),
        grid=Grid(
            grid.gap or (gap,),
            grid.yield_force or (first.yield_force,),
            grid.contact_model or (law_name,),
            grid.pga or (records.pga,),
        ),
        rtol=tables.solver.rtol,
        effects=effects,
        relation=_relation(tables.interface),
        is_row=row,
        gridded_interface=_gridded(grid, buildings, neighbours) if row else None,
        text=origin.text,
        source=origin.source,
        overrides=origin.overrides,
    )
    return study, faults


def _buildings(tables: list[Any], effects: tuple[Effect, ...]) -> tuple[tuple[Building | Storeys, ...], list[Fault]]:
    """The buildings, and a fault for each that is none, or that an effect on buildings does not fit."""
    found, faults = [], []
    for index, table in enumerate(tables):
        try:
            found.append(building_of(table))
            chain_of(found[-1], effects)
        except PoundingError as error:
            faults.append(Fault(("building", index), str(error)))
    if not faults and "inelastic_storeys" in dict(effects) and not any(each.strengths for each in found):
        faults.append(Fault(("effects", "inelastic_storeys"), NO_STRENGTHS))
    return tuple(found), faults


def _neighbours(
    tables: Any, buildings: tuple[Building | Storeys, ...], law_name: str, row: bool
) -> tuple[tuple[Neighbour, ...], list[Fault]]:
    """What stands between each two buildings; one table stands for all where there is one."""
    found, faults = [], []
    for place in range(len(buildings) - 1):
        index = min(place, len(tables.interface) - 1)
        table, base = tables.interface[index], ("interface", index)
        sides, given = buildings[place : place + 2], tables.building[place : place + 2]
        here = Beside(place, (sides[0], sides[1]), (given[0], given[1]), table, base)
        points, wrong = contact_points(here)
        faults += wrong
        stiffness = _stiffness(table, law_name, tables.grid.contact_model)
        made = neighbour(here, points, _gap(table, tables.grid), stiffness)
        found.append(made._replace(yield_force=_yield_force(table, tables.grid, row)))
    return tuple(found), faults


def _shared(tables: list[Any], key: str) -> Any:
    """The value of a key that is one for all interfaces: that of the first which has it, or its default."""
    return next((getattr(table, key) for table in tables if key in table.model_fields_set), getattr(tables[0], key))


def _relation(tables: list[Any]) -> str:
    given = [table.restitution[2] for table in tables if "restitution" in table.model_fields_set]
    return given[0] if given else AS_PUBLISHED


def _gap(table: Any, grid: Any) -> float:
    """The interface's own gap, or the first of the grid."""
    gap: float = grid.gap[0] if table.gap is None else table.gap
    return gap


def _yield_force(table: Any, grid: Any, row: bool) -> float:
    """The interface's own; in a row, a grid of one yield force is that of all interfaces."""
    force: float = grid.yield_force[0] if row and len(grid.yield_force) == 1 else table.yield_force
    return force


def _gridded(grid: Any, buildings: tuple[Building | Storeys, ...], neighbours: tuple[Neighbour, ...]) -> str | None:
    """The only interface whose gap varies; the first where the scene has several gaps and no grid of them."""
    if grid.interface:
        return str(grid.interface)
    if not grid.gap and len({each.gap for each in neighbours}) > 1:
        return interface_name(buildings[0].name, buildings[1].name)
    return None


def _stiffness(table: Any, law_name: str, gridded: tuple[str, ...]) -> float | None:
    """The stiffness in the unit of the first contact model that takes one; none where no model does."""
    owner = stiff_model(law_name, gridded)
    return None if owner is None else parse(table.stiffness, stiffness_quantity(CONTACT_MODELS[owner]))
