"""Variables, coordinates and attributes of the dataset of a row."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import accumulate
from typing import Any

import numpy as np
import xarray as xr

from pounding_risk.models.effects import bare
from pounding_risk.models.structures.contact_points import Point
from pounding_risk.motions.motion import Motion
from pounding_risk.results.files import as_text
from pounding_risk.results.layout import CaseVariable
from pounding_risk.results.pair_labels import (
    MOTIONS,
    OUTCOME,
    attributes,
    building_coordinates,
    case_coordinates,
    described,
    kept_as,
    motion_spectra,
    one_amplitude,
)
from pounding_risk.scene.level_notes import level_notes
from pounding_risk.scene.scene import Scene
from pounding_risk.solver.row.grid import RowGrid
from pounding_risk.solver.row.outputs import (
    AT_STOREYS,
    POINT,
    Frame,
    Variable,
    closing,
    moving_outputs,
    moving_variables,
    variables,
)


def row_skeleton(study: Scene, motions: tuple[Motion, ...], driven: np.ndarray, grid: RowGrid) -> xr.Dataset:
    """The dataset of a row without its cases; ``driven`` holds `cases.Driven` by record, polarity and amplitude."""
    free = _free(driven, grid) | motion_spectra(motions)
    laws = tuple(mechanics.laws[0] for mechanics in grid.mechanics)
    attrs = attributes(study, motions, laws) | {
        "source": "pounding_risk: event-driven row solver",
        "stiffness": as_text(_stiffnesses(study, grid)),
        "restitution": _listed([neighbour.restitution_words for neighbour in study.neighbours]),
    }
    if notes := level_notes(study):
        attrs["level_notes"] = as_text(notes)
    coords = case_coordinates(study, motions) | row_coordinates(study, grid)
    return one_amplitude(xr.Dataset(free, coords=coords, attrs=attrs), study)


def row_variables(frame: Frame) -> dict[str, CaseVariable]:
    """Every case variable of a row, except those of the tolerance check."""
    return case_variables(variables(frame)) | OUTCOME


def case_variables(outputs: Mapping[str, Variable]) -> dict[str, CaseVariable]:
    """Outputs of a row as variables of a dataset."""
    return {
        name: CaseVariable(one.dims, kept_as(one.whole), described(one.unit, one.words))
        for name, one in outputs.items()
    }


def _free(driven: np.ndarray, grid: RowGrid) -> dict[str, Any]:
    """Peaks of buildings and storeys, and closing of the gaps, without contact."""
    frame = grid.frame
    moving = [moving_outputs(one.free, one.pga, frame) for one in driven.flat]
    gaps = [closing(one.free, frame.model) for one in driven.flat]
    responses = {}
    for name, variable in moving_variables(frame).items():
        values = np.array([outputs[name] for outputs in moving])
        responses[f"{name}_free"] = _by_motion(
            values, driven.shape, variable.dims, variable.unit, f"{variable.words}; without contact"
        )
    words = "gap that the motion needs: largest u_left - u_right of the continuous motion without contact"
    for place, (name, dim) in enumerate(
        (("contact_point_peak_closing", "contact_point"), ("peak_closing", "interface"))
    ):
        values = np.array([closings[place] for closings in gaps])
        responses[f"{name}_free"] = _by_motion(values, driven.shape, (dim,), "m", words)
    return responses


def _by_motion(values: np.ndarray, shape: tuple[int, ...], dims: tuple[str, ...], unit: str, words: str) -> Any:
    return (*MOTIONS, *dims), values.reshape(*shape, *values.shape[1:]), described(unit, words)


def row_coordinates(study: Scene, grid: RowGrid) -> dict[str, Any]:
    """Interfaces, contact points, buildings and storeys, with facts on each."""
    points = grid.model.points
    names = [building.name for building in study.buildings]
    return {
        "interface": ("interface", list(study.interface_names), {"long_name": "neighbours, left | right"}),
        "contact_point": (
            "contact_point",
            [_label(point, names) for point in points],
            {"long_name": "contact point: the floors at which two neighbours meet, left | right"},
        ),
        **_point_coordinates(points, grid),
        **_building_coordinates(study, grid),
        **_gap_coordinates(study, grid),
    }


def _label(point: Point, names: list[str]) -> str:
    """Such as "A 2 | B 2", or "A 2 | B 1.4" where a floor of A meets a column of B."""
    left, right = names[point.interface], names[point.interface + 1]
    return f"{left} {point.left_floor:.3g} | {right} {point.right_floor:.3g}"


def _point_coordinates(points: tuple[Point, ...], grid: RowGrid) -> dict[str, Any]:
    facts = {
        "interface": (
            [point.interface for point in points],
            {"long_name": "index of the contact point's interface, from 0"},
        ),
        "level": ([point.level for point in points], described("m", "level above the ground; NaN where not known")),
        "kind": (
            [point.kind for point in points],
            {"long_name": "kind of contact point: two floors, or a floor and a column"},
        ),
        "left_floor": ([point.left_floor for point in points], described("1", "floor of the left building")),
        "right_floor": ([point.right_floor for point in points], described("1", "floor of the right building")),
    }
    coords: dict[str, Any] = {f"{POINT}{name}": ("contact_point", *fact) for name, fact in facts.items()}
    forces = described("N", "yield force F_E at the contact point; inf never yields")
    coords["contact_point_yield_force"] = (("yield_force", "contact_point"), grid.yield_forces, forces)
    return coords


def _building_coordinates(study: Scene, grid: RowGrid) -> dict[str, Any]:
    """Facts on each building; NaN where a rigid one, or one without storeys, has no such value."""
    buildings = study.buildings
    levels = np.full(grid.frame.storeys.shape, np.nan)
    for place, building in enumerate(buildings):
        given = list(accumulate(building.heights))
        levels[place, : len(given)] = given
    heights = [building.height if building.height > 0.0 else np.nan for building in buildings]
    storeys = (grid.frame.storeys >= 0).sum(axis=1)
    return building_coordinates(study, "first period of vibration") | {
        "building_height": ("building", heights, described("m", "level of the roof; NaN where not given")),
        "building_storeys": ("building", storeys, described("1", "storeys; a rigid building has none")),
        "building_position": (
            "building",
            positions(len(buildings)),
            {"long_name": "position of the building in the row: end or interior"},
        ),
        "storey": ("storey", np.arange(grid.frame.storeys.shape[1]) + 1, described("1", "storey, from the ground up")),
        "floor_level": (AT_STOREYS, levels, described("m", "level of the floor above the storey; NaN where not given")),
    }


def positions(count: int) -> list[str]:
    """Position of each of so many buildings: end or interior, or alone."""
    return ["alone"] if count == 1 else ["end", *["interior"] * (count - 2), "end"]


def _gap_coordinates(study: Scene, grid: RowGrid) -> dict[str, Any]:
    """The gap of each interface, where it is not the gap of the grid at all of them."""
    if (grid.gaps == np.array(study.grid.gaps)[:, None]).all():
        return {}
    words = "clear distance at rest of each interface; the axis gap is that of "
    of_axis = study.gridded_interface or "the scene's first one"
    return {"interface_gap": (("gap", "interface"), grid.gaps, described("m", words + of_axis))}


def _stiffnesses(study: Scene, grid: RowGrid) -> dict[str, list[float]]:
    """Stiffness by contact model, interface by interface."""
    return {
        name: [float(bare(mechanics.laws[place]).stiffness) for place in grid.model.bounds[:-1]]
        for name, mechanics in zip(study.grid.contact_models, grid.mechanics, strict=True)
    }


def _listed(words: list[str]) -> str:
    """The words once where all are equal, otherwise one after the other."""
    return words[0] if len(set(words)) == 1 else "; ".join(words)
