"""The grid of a row: the row itself, and laws, gaps and yield forces by contact point."""

from __future__ import annotations

from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pounding_risk.ensemble.laws import law_of
from pounding_risk.errors import SceneError
from pounding_risk.models.contact.impulsive import is_instant, only_in_pairs
from pounding_risk.models.contact.law import snake_case
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.scene.interfaces import known_law
from pounding_risk.scene.scene import Scene, between_walls
from pounding_risk.solver.row.cases import Mechanics, RowGrid
from pounding_risk.solver.row.model import RowModel
from pounding_risk.solver.row.outputs import frame_of

Array = NDArray[np.float64]


def row_grid(study: Scene) -> RowGrid:
    """The grid of a study; raises as `chain_of` and as `laws.law_of`."""
    model = model_of(study)
    gaps = np.array([study.interface_gaps(gap) for gap in study.grid.gaps])
    # With one yield force in the grid, every interface has its own.
    levels = study.grid.yield_forces if len(study.grid.yield_forces) > 1 else (None,)
    forces = model.at_points(np.array([study.point_yield_forces(level) for level in levels]))
    finite = np.unique(forces[np.isfinite(forces)])
    mechanics = tuple(mechanics_of(study, model, name, finite) for name in study.grid.contact_models)
    return RowGrid(frame_of(model), mechanics, gaps, forces, study.rtol)


def model_of(study: Scene) -> RowModel:
    """The buildings of a scene, their contact points and what they stand on; raises as `chain_of`."""
    chains = [chain_of(building, study.effects) for building in study.buildings]
    return RowModel(chains, study.points, study.supports, study.links, study.bumpers)


def mechanics_of(study: Scene, model: RowModel, name: str, levels: Array) -> Mechanics:
    """One contact model at every contact point, with the values of its interface; ``levels`` as in `Mechanics` [N]."""
    laws = [law_of(study.at(place), name) for place in range(len(study.interfaces))]
    for place, interface in enumerate(study.interfaces):
        if any(point.across < inf for point in interface.points):
            laws[place] = halved(laws[place], study)
    rules = [interface.restitution.rule for interface in study.interfaces]
    return Mechanics(
        tuple(laws[place] for place in model.interfaces), tuple(rules[place] for place in model.interfaces), levels
    )


def halved(law: Any, study: Scene) -> Any:
    """The law of one end of a face: half as stiff, so that both ends together are the floor's.

    Raises SceneError for a law without a stiffness of its own.
    """
    if hasattr(law, "law"):
        return law._replace(law=halved(law.law, study))
    if getattr(law, "table", None) is not None or not hasattr(law, "stiffness"):
        words = "has no stiffness to be shared by both ends of a face, as floors that rotate need it"
        raise SceneError(study.source, [f"interface.contact_model: {snake_case(type(law).__name__)} {words}"])
    return law._replace(stiffness=0.5 * law.stiffness)


def without_jumps(study: Scene, law_name: str) -> str:
    """Why the velocities of a row cannot jump as a contact model has it; "" where they can, or do not jump."""
    law = known_law(law_name)
    if not is_instant(law):
        return ""
    if reason := only_in_pairs(law):
        return f"only for a pair of single masses: {reason}"
    if study.links:
        return "velocities jump, which is computed for buildings that no link joins"
    places = [(point.interface, point.left_floor, point.right_floor) for point in study.points]
    masses = all(chain_of(building, study.effects).mass.size <= 1 for building in study.buildings)
    if not masses or places != [(place, 1.0, 1.0) for place in range(len(study.interfaces))]:
        return "velocities jump, which is computed for single masses that meet mass to mass"
    stuck = between_walls(study)
    return stuck.sentence if stuck else ""
