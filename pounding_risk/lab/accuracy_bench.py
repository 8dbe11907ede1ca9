"""What the accuracy study asks of the solver of its scene: the cases, and runs of them by every method."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any, NamedTuple, Protocol

import numpy as np

from pounding_risk.lab.accuracy_findings import OUTPUTS
from pounding_risk.models.ground import SHARED
from pounding_risk.models.structures.contact_points import Point
from pounding_risk.models.structures.mdof import Chain
from pounding_risk.motions.levels import PEAK, driven
from pounding_risk.motions.motion import Motion
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.scene import Scene

FIXED = {
    "Newmark average acceleration": "newmark",
    "central difference": "central_difference",
    "Runge-Kutta 4": "rk4",
}
REFERENCE = 1e-12  # rtol of the event-driven reference
OWN_GROUNDS = "ground of a building's own"
INITIAL_STATES = "initial displacement or velocity"  # what the other methods do not begin with


def own_grounds(study: Scene) -> list[str]:
    """What else the other methods do not know: grounds that differ by keys of the buildings."""
    return [OWN_GROUNDS] if any(building.support != SHARED for building in study.buildings) else []


class Outcome(NamedTuple):
    """Answers, steps and times of one setting over all cases."""

    values: np.ndarray  # (cases, interfaces, OUTPUTS); NaN where a run failed, or was not made
    steps: float  # in contact, per contact
    residual: float  # largest share of energy that is unaccounted for; NaN where the method keeps no account
    seconds: float  # per case
    free_seconds: float  # per motion: a run without contact, for the gap required
    told: tuple[int, ...] = tuple(range(len(OUTPUTS)))  # the outputs that the method has


class PointCase(NamedTuple):
    """One case by contact point."""

    motion: int  # its index in `Bench.motions`
    laws: Sequence[Any]
    rules: Sequence[Any]  # of restitution
    gaps: np.ndarray  # m
    yield_forces: np.ndarray  # N


class Bench(Protocol):
    """The cases that every setting runs, and how each method runs them."""

    @property
    def motions(self) -> Sequence[Motion]:
        """In each polarity and amplitude."""

    @property
    def chains(self) -> Sequence[Chain]:
        """The buildings, left to right."""

    @property
    def points(self) -> Sequence[Point]:
        """The contact points, interface by interface."""

    @property
    def event_only(self) -> str:
        """What of the scene only the event-driven solver models; "" where every method does."""

    @property
    def labels(self) -> Sequence[str]:
        """What tables call each case: motion, contact model, gap and yield force."""

    @property
    def size(self) -> int:
        """Number of cases that every setting runs."""

    def point_cases(self) -> Iterator[PointCase]:
        """The cases in their order."""

    @property
    def closed_at_rest(self) -> np.ndarray:
        """True where a gap is closed at rest, (cases, interfaces)."""

    def warm_up(self) -> None:
        """Compile every kernel that is needed."""

    def event(self, rtol: float) -> Outcome:
        """The event-driven solver over all cases, every case run."""

    def fixed(self, method: str, dt: float) -> Outcome:
        """A fixed-step method over all cases in steps of about ``dt`` [s], a whole number of them a sample."""

    def general(self, solver: str, rtol: float) -> Outcome:
        """SciPy over one case of each of the first motions, the first gap with the largest yield force."""


class Driven(NamedTuple):
    """One motion of the grid in one polarity and amplitude, with its place on these axes and its name."""

    place: tuple[int, int, int]
    motion: Motion
    name: str


def driven_motions(study: Scene) -> list[Driven]:
    """The motions of a study in each polarity and amplitude."""
    listed = []
    axes = (motions_of(study), study.records.polarities, study.grid.amplitudes)
    for indices in np.ndindex(tuple(len(axis) for axis in axes)):
        motion, sense, level = (axis[index] for axis, index in zip(axes, indices, strict=True))
        at = "" if level is None else f" {level.value:.4g} m/s2" if level.measure == PEAK else f" {level.words}"
        listed.append(
            Driven((indices[0], indices[1], indices[2]), driven(motion, sense, level), f"{motion.name} {sense}{at}")
        )
    return listed


def thinned_grid(study: Scene, cases: int, motions: int) -> tuple[list[int], list[int]]:
    """Indices of as many gaps and yield forces as fit into so many cases, evenly spaced."""
    grid = study.grid
    most = max(1, cases // (motions * len(grid.contact_models)))
    forces = _thinned(grid.yield_forces, max(1, int(most**0.5)) if len(grid.gaps) > 1 else most)
    return _thinned(grid.gaps, max(1, most // len(forces))), forces


def _thinned(values: Sequence[float], most: int) -> list[int]:
    """Indices of at most so many of the values, first and last among them where there is room."""
    if len(values) <= most:
        return list(range(len(values)))
    indices = np.unique(np.linspace(0, len(values) - 1, max(most, 2)).round().astype(int))
    return [int(index) for index in (indices if most > 1 else indices[-1:])]


def case_labels(name: str, law: str, gaps: Sequence[float], forces: Sequence[float]) -> list[str]:
    """Labels of every gap with every yield force of one law under one motion; no forces for each interface's own."""
    if not forces:
        return [f"{name}, {law}, gap {gap:.4g} m" for gap in gaps]
    return [f"{name}, {law}, gap {gap:.4g} m, F_E {force:.4g} N" for gap, force in product(gaps, forces)]
