"""Scenes and ground motions of the hard cases, and the runs of one law at one tolerance, as a pair and as a row."""

from __future__ import annotations

from math import inf, isfinite, isnan, nan
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.models.contact.impulsive import CONTACT_MODELS, is_instant, needs_floors
from pounding_risk.models.contact.laws import stiffness_quantity
from pounding_risk.models.restitution import Restitution
from pounding_risk.models.structures.contact_points import FLOOR, Point
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.solver.counters import COMPLETE, COUNT, LOWEST_FORCE, PEAK_FORCE, make_log
from pounding_risk.solver.pair.api import Interface, free_response, oscillators, run, solve
from pounding_risk.solver.pair.isolated import Impact
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.api import RowRun
from pounding_risk.solver.row.cases import Cases, Driven, Limits, Mechanics
from pounding_risk.solver.row.layout import nodes_of
from pounding_risk.solver.row.model import RowModel
from pounding_risk.solver.row.outputs import OF_BUILDINGS, frame_of
from pounding_risk.solver.row.outputs import outputs as row_outputs
from pounding_risk.solver.row.trace_reader import contacts_of, instants_of, motion_at
from pounding_risk.studies.impact import impact
from pounding_risk.units import USUAL_FLOOR_LENGTH

Ground = NDArray[np.float64]

# Laws whose published form may pull: Kelvin-Voigt before every parting, the Hertz-damp family where two driven
# buildings part faster than they met.
PULLING = ("kelvin_voigt", "hertz_damp", "hertz_damp_exact")
# A law that cannot pull is evaluated up to 1e-8 of a step past its turn from approach to restitution, where a dashpot
# gives so much of the peak force; what is larger is a pull.
NO_PULL = 1e-8
STEPS_KEPT = 200_000

# With floors, of which the harder is the shorter: a force in steps, for models that collide them.
SOFT = Building("left", 500e3, 0.5, 0.05, 27.0)
STIFF = Building("right", 800e3, 0.31, 0.05, 12.0)
WALL = Building.rigid("wall")
SIDES = ("left", "right")


def shaking(peak: float, dt: float = 0.01, duration: float = 5.0) -> Ground:
    """Five sines under a half sine: a_g [m/s²] that starts and ends at zero, with this largest value."""
    t = np.arange(round(duration / dt) + 1) * dt
    rates, phases = (0.7, 1.3, 2.9, 4.7, 7.9), (0.3, 2.1, 4.4, 1.2, 5.6)  # Hz, rad: no common period
    waves = sum(np.sin(2.0 * np.pi * rate * t + phase) for rate, phase in zip(rates, phases, strict=True))
    a = waves * np.sin(np.pi * t / t[-1])
    a[0] = a[-1] = 0.0
    return np.asarray(a * (peak / np.abs(a).max()))


def push(level: float, rise: float, hold: float, dt: float = 0.01, release: float = 0.0) -> Ground:
    """a_g that rises smoothly from 0 to ``level``, stays, and may fall to −``level`` over ``release`` [s]."""
    up = 0.5 * level * (1.0 - np.cos(np.linspace(0.0, np.pi, round(rise / dt) + 1)))
    stages = [up, np.full(round(hold / dt), level)]
    if release > 0.0:
        stages.append(level * np.cos(np.linspace(0.0, np.pi, round(release / dt) + 1)[1:]))
    return np.concatenate(stages)


class TrialScene(NamedTuple):
    """A pair, its interface and its ground motion; a law takes the stiffness of its kind."""

    left: Building = SOFT
    right: Building = STIFF
    gap: float = 0.0  # m
    hertz: float = 2.75e9  # β, N/m^1.5
    linear: float = 5e8  # k, N/m
    restitution: Restitution = Restitution(0.65)
    yield_force: float = inf  # N
    ground: Ground = shaking(4.0)
    dt: float = 0.01

    @property
    def pga(self) -> float:
        """The largest ground acceleration of its motion [m/s²]."""
        return float(np.abs(self.ground).max(initial=0.0))


class History(NamedTuple):
    """Contacts and steps of one run, as `counters.CONTACT_COLUMNS` and `counters.STEP_COLUMNS`."""

    contacts: Ground
    steps: Ground


class Trial:
    """One law at one tolerance: makes the runs of a case and keeps count of what they took.

    ``status`` is that of the first run that did not complete; ``steps`` those of all runs. A case compares what
    the runs return, which for a failed run is NaN, so that it cannot hold.
    """

    def __init__(self, name: str, rtol: float):
        self.name, self.rtol, self.kind = name, rtol, CONTACT_MODELS[name]
        self.status, self.steps = COMPLETE, 0

    @property
    def is_linear(self) -> bool:
        """True for the laws whose stiffness is in N/m."""
        return not is_instant(self.kind) and stiffness_quantity(self.kind).unit == "N/m"

    def law(self, scene: TrialScene) -> Any:
        """The law with the scene's stiffness or floors, where it takes them."""
        if needs_floors(self.kind):
            kind: Any = self.kind
            pair = (scene.left, scene.right)
            return kind.between(*(one._replace(floor_length=one.floor_length or USUAL_FLOOR_LENGTH) for one in pair))
        if is_instant(self.kind):
            return self.kind()
        return self.kind(scene.linear if self.is_linear else scene.hertz)

    def interface(self, scene: TrialScene) -> Interface:
        """The scene's interface under this law."""
        return Interface(scene.gap, self.law(scene), scene.restitution, scene.yield_force)

    def solve(self, scene: TrialScene, expected: int = COMPLETE) -> dict[str, float]:
        """Every output of one run; a status other than the one ``expected`` is kept."""
        outputs = solve(scene.left, scene.right, self.interface(scene), scene.ground, scene.dt, rtol=self.rtol)
        self._count(int(outputs["steps"]), int(outputs["status"]), expected)
        return outputs

    def _count(self, steps: int, status: int, expected: int = COMPLETE) -> None:
        """Add the steps of a run, and keep a status that is not the expected one."""
        self.steps += steps
        if status != expected and self.status == COMPLETE:
            self.status = status

    def follow(self, scene: TrialScene) -> History:
        """The contacts and steps of one run."""
        pair = oscillators(scene.left, scene.right)
        log = make_log(STEPS_KEPT // 20, STEPS_KEPT, np.zeros(0))
        run(pair, free_response(pair, scene.ground, scene.dt), self.interface(scene), self.rtol, log)
        self.steps += int(log.used[1])
        return History(log.contacts[: log.used[0]], log.steps[: log.used[1]])

    def collide(self, scene: TrialScene, speed: float, mass: float, other: float = inf) -> Impact:
        """One isolated impact of two free masses, at the trial's tolerance."""
        contact: dict[str, Any] = {"restitution": scene.restitution, "yield_force": scene.yield_force}
        collision = impact(self.law(scene), speed, mass, other, rtol=self.rtol, **contact)
        self.steps += len(collision.time)
        return collision

    def unsound(self, outputs: dict[str, float]) -> float:
        """The energy that a run with contact leaves unaccounted for, over its largest energy.

        Infinite where the run broke what must hold to rounding: there was contact, no force pulls in a law that
        does not, the capped force is at most F_E, no output is NaN or infinite.
        """
        # The force of a jump is not finite, unless floors collide: NaN has a meaning there.
        forceless = is_instant(self.kind) and not needs_floors(self.kind)
        peak = 0.0 if forceless else outputs["peak_contact_force"]
        pulls = self.name not in PULLING and not outputs["lowest_contact_force"] >= -NO_PULL * peak
        never = {"first_yield_time", "peak_storey_shear_left", "peak_storey_shear_right"}  # NaN has a meaning there
        if forceless:
            never |= {"peak_contact_force", "yield_demand"}
        broken = any(not isfinite(value) for name, value in outputs.items() if name not in never)
        return inf if pulls or broken or not outputs["impact_count"] > 0.0 else outputs["energy_residual"]

    def solve_row(self, row: RowModel, scene: TrialScene, expected: int = COMPLETE) -> RowRun:
        """One run of a row whose interfaces have the gap, law and motion of a scene, with the states at all nodes."""
        count = len(row.points)
        laws, restitutions = [self.law(scene)] * count, [scene.restitution] * count
        gaps = row.gaps(np.full(len(row.chains) - 1, scene.gap))
        contacts = rows.Contacts(gaps, np.full(count, scene.yield_force), laws, restitutions)
        run = rows.run_row(row.row(scene.dt), contacts, scene.ground, rtol=self.rtol, histories=True)
        self._count(run.steps, run.status, expected)
        return run

    def unsound_row(self, row: RowModel, gap: float) -> float:
        """As `unsound`, of the usual scene's motion on a row of equal gaps; infinite where a point has no contact."""
        run = self.solve_row(row, TrialScene(gap=gap))
        counts, lowest, peaks = (run.points[~row.is_link, column] for column in (COUNT, LOWEST_FORCE, PEAK_FORCE))
        pulls = self.name not in PULLING and bool((lowest < -NO_PULL * peaks).any())
        return inf if pulls or not counts.all() else abs(run.residual) / run.energy


class RowTrial(Trial):
    """As `Trial`, by the solver of rows; ``runs`` counts them, 0 for a case that needs nothing that rows have."""

    def __init__(self, name: str, rtol: float):
        super().__init__(name, rtol)
        self.runs = 0

    def _run(self, scene: TrialScene, *, histories: bool = False) -> tuple[RowRun, RowModel, Limits]:
        """One run, with the row and its limits."""
        self.runs += 1
        model = RowModel([chain_of(scene.left), chain_of(scene.right)], [Point(0, 1.0, 1.0, FLOOR, nan)])
        limits = Limits(*(np.array([value]) for value in (scene.gap, scene.yield_force, scene.yield_force)))
        finite = limits.yield_forces[np.isfinite(limits.yield_forces)]
        mechanics = Mechanics((self.law(scene),), (scene.restitution,), finite)
        free = rows.free_response(model.row(scene.dt), scene.ground)
        driven = Driven(scene.ground, scene.dt, scene.pga, free.run)
        cases = Cases(model, mechanics, driven, self.rtol, lambda: free.motion)
        return cases.in_full(limits) if histories else cases.whole(limits), model, limits

    def solve(self, scene: TrialScene, expected: int = COMPLETE) -> dict[str, float]:
        """Every output of one run, under the names of a pair; a status other than the one ``expected`` is kept."""
        run, model, limits = self._run(scene)
        self._count(run.steps, run.status, expected)
        values = row_outputs(run, limits.yield_forces, scene.pga, frame_of(model))
        of_pair = (name for name in values if values[name].shape == (1,) and not name.startswith("contact_point_"))
        answers = {name: float(values[name][0]) for name in of_pair}
        for name in OF_BUILDINGS:
            if name != "peak_drift":  # of a single mass its displacement
                answers |= {f"{name}_{side}": float(values[name][at]) for at, side in enumerate(SIDES)}
        return answers | {"status": float(run.status), "steps": float(run.steps)}

    def follow(self, scene: TrialScene) -> History:
        """The contacts and steps of one run; of a contact what the cases read: touch, parting, approach speed."""
        run, model, _ = self._run(scene, histories=True)
        self.steps += run.steps
        layout = model.row(scene.dt)
        instants = instants_of(run.log, len(nodes_of(layout, scene.ground)), layout.step)
        touched = contacts_of(run.log, 1, instants)
        contacts = np.array([contact.facts for contact in touched]).reshape(len(touched), -1)
        moved = motion_at(run.log, run.states, instants)
        steps = []
        for contact in touched:
            states = moved[np.searchsorted(instants.every, contact.instants)]  # (instants, u and v, masses)
            still = np.zeros((len(states), 2))  # of a rigid building
            left = still if scene.left.is_rigid else states[:, :, 0]
            right = still if scene.right.is_rigid else states[:, :, -1]
            columns = (left[:, 0], right[:, 0], left[:, 1], right[:, 1])
            steps.append(np.column_stack([contact.instants, *columns, contact.forces]))
        return History(contacts, np.concatenate(steps) if steps else np.zeros((0, 6)))


def largest_difference(
    first: dict[str, float], second: dict[str, float], only: tuple[str, ...] = (), but: tuple[str, ...] = ()
) -> float:
    """The largest difference of two runs' outputs over the larger of the two; 0 where all bits agree, NaN with NaN.

    ``only`` names the outputs that count, all by default; ``but`` those that do not.
    """
    worst = 0.0
    for name in set(only or first) - set(but):
        a, b = first[name], second[name]
        if a == b or (isnan(a) and isnan(b)):
            continue
        difference = abs(a - b) / max(abs(a), abs(b))
        worst = max(worst, inf if isnan(difference) else difference)
    return worst
