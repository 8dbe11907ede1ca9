"""The runs of a hard case by the solver of rows: two single masses as a row with one contact point."""

from __future__ import annotations

from math import nan

import numpy as np

from pounding_risk.lab.stability.trial import History, Trial, TrialScene
from pounding_risk.models.structures.contact_points import FLOOR, Point
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.solver.counters import COMPLETE
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.api import RowRun
from pounding_risk.solver.row.cases import Cases, Driven, Limits, Mechanics
from pounding_risk.solver.row.layout import nodes_of
from pounding_risk.solver.row.model import RowModel
from pounding_risk.solver.row.outputs import OF_BUILDINGS, frame_of, outputs
from pounding_risk.solver.row.trace_reader import contacts_of, instants_of, motion_at

SIDES = ("left", "right")


class RowTrial(Trial):
    """As `Trial`, by the solver of rows; ``runs`` counts them, 0 for a case that asks for nothing that rows have."""

    def __init__(self, name: str, rtol: float):
        super().__init__(name, rtol)
        self.runs = 0

    def _made(self, scene: TrialScene, *, histories: bool = False) -> tuple[RowRun, RowModel, Limits]:
        """One run, with the row and its limits."""
        self.runs += 1
        model = RowModel([chain_of(scene.left), chain_of(scene.right)], [Point(0, 1.0, 1.0, FLOOR, nan)])
        limits = Limits(*(np.array([value]) for value in (scene.gap, scene.yield_force, scene.yield_force)))
        law = self.law(scene)
        finite = limits.yield_forces[np.isfinite(limits.yield_forces)]
        mechanics = Mechanics((law,), (scene.restitution,), finite)
        free = rows.free_response(model.row(scene.dt), scene.ground)
        pga = float(np.abs(scene.ground).max(initial=0.0))
        driven = Driven(scene.ground, scene.dt, pga, free.run)
        cases = Cases(model, mechanics, driven, self.rtol, lambda: free.motion)
        run = cases.in_full(limits) if histories else cases.whole(limits)
        self.steps += run.steps
        return run, model, limits

    def solve(self, scene: TrialScene, expected: int = COMPLETE) -> dict[str, float]:
        """Every output of one run, under the names of a pair; a status other than the one ``expected`` is kept."""
        run, model, limits = self._made(scene)
        pga = float(np.abs(scene.ground).max(initial=0.0))
        values = outputs(run, limits.yield_forces, pga, frame_of(model))
        answers = {name: float(value[0]) for name, value in values.items() if value.shape == (1,)}
        answers = {name: value for name, value in answers.items() if not name.startswith("contact_point_")}
        for name in OF_BUILDINGS:
            if name != "peak_drift":  # of a single mass its displacement
                answers |= {f"{name}_{side}": float(values[name][at]) for at, side in enumerate(SIDES)}
        if run.status != expected and self.status == COMPLETE:
            self.status = run.status
        return answers | {"status": float(run.status), "steps": float(run.steps)}

    def follow(self, scene: TrialScene) -> History:
        """The contacts and steps of one run; of a contact what the cases read: touch, parting, approach speed."""
        run, model, _ = self._made(scene, histories=True)
        layout = model.row(scene.dt)
        instants = instants_of(run.log, len(nodes_of(layout, scene.ground)), layout.step)
        touched = contacts_of(run.log, 1, instants)
        contacts = np.array([contact.facts for contact in touched]).reshape(len(touched), -1)
        moved = motion_at(run.log, run.states, instants)
        steps = []
        for contact in touched:
            at = np.searchsorted(instants.every, contact.instants)
            states = [_of_sides(scene, moved[at, part]) for part in range(2)]
            steps.append(np.column_stack([contact.instants, *states[0], *states[1], contact.forces]))
        return History(contacts, np.concatenate(steps) if steps else np.zeros((0, 6)))


def _of_sides(scene: TrialScene, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values of the masses (instants, masses) of the left and the right building; 0 for a rigid one."""
    still = np.zeros(len(values))
    left = still if scene.left.is_rigid else values[:, 0]
    return left, still if scene.right.is_rigid else values[:, -1]
