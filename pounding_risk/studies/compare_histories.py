"""Relative displacement of one case of a comparison under every contact model, at one interface."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.ensemble.job import ScanInput
from pounding_risk.ensemble.laws import law_of
from pounding_risk.ensemble.row_job import RowJob
from pounding_risk.models.effects import wave_of
from pounding_risk.motions.motion import Motion, driven
from pounding_risk.results.labels import described
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.scene import Scene
from pounding_risk.solver.pair.api import Interface, free_response, oscillators
from pounding_risk.studies.pair_trace import histories, logged, relative_displacement
from pounding_risk.studies.row_trace import closing_at, grounds_at

Array = NDArray[np.float64]


class Shown(NamedTuple):
    """Which case of the grid is shown, by the place on each of its axes, and at which interface, from 0."""

    case: dict[str, int]
    place: int


class Moved(NamedTuple):
    """Relative displacement of every law at every contact point of an interface, and what stands there."""

    values: Array  # m, (laws, contact points, samples)
    points: list[str]
    gap: float  # m
    yield_forces: Array  # N, by contact point


def histories_of_laws(study: Scene, shown: Shown, baseline: str) -> dict[str, Any]:
    """Relative displacement of one case under every law at the record's samples, and which case it is.

    At the contact point of the interface whose displacement is largest under the baseline.
    """
    case, records = shown.case, study.records
    pga = study.grid.pgas[case.get("pga", 0)]
    motion = driven(motions_of(study)[case["record"]], records.polarities[case["polarity"]], pga)
    moved = (_of_row if study.is_row else _of_pair)(study, motion, shown)
    law = study.grid.contact_models.index(baseline)
    point = int(np.nanmax(np.abs(moved.values[law]), axis=-1).argmax())
    about: dict[str, Any] = described("m", "relative displacement of a case of median spread") | {"record": motion.name}
    about |= {"polarity": records.polarities[case["polarity"]], "pga": motion.pga, "gap": moved.gap}
    about |= {"yield_force": float(moved.yield_forces[point]), "interface": study.interface_names[shown.place]}
    about |= {"contact_point": moved.points[point]}
    return {
        "time": ("time", _samples(motion), described("s", "time since the start of the record")),
        "history": (("contact_model", "time"), moved.values[:, point], about),
    }


def _samples(motion: Motion) -> Array:
    """The times of the record's samples [s]."""
    return np.arange(len(motion.acceleration), dtype=np.float64) * motion.dt


def _of_pair(study: Scene, motion: Motion, shown: Shown) -> Moved:
    """By the solver of two single masses; their one contact point has the name of its interface."""
    pair, grid = oscillators(*study.pair), study.grid
    free = free_response(pair, motion.acceleration, motion.dt, wave_of(study.effects))
    gap, strength = grid.gaps[shown.case["gap"]], grid.yield_forces[shown.case["yield_force"]]
    rows = []
    for name in grid.contact_models:
        interface = Interface(gap, law_of(study, name), study.restitution, strength)
        _, log = logged(pair, free, interface, study.rtol)
        time, states, *_ = histories(pair, free, log)
        rows.append(np.interp(_samples(motion), time, relative_displacement(free, time, states)))
    return Moved(np.array(rows)[:, None], list(study.interface_names), gap, np.array([strength]))


def _of_row(study: Scene, motion: Motion, shown: Shown) -> Moved:
    """By the solver of rows; a motion that fails is NaN from there on."""
    case, job = shown.case, RowJob(ScanInput(study, motions_of(study)))
    limits = job.grid.limits(case["gap"], case["yield_force"])
    points = np.flatnonzero(job.grid.model.interfaces == shown.place)
    layout = job.grid.model.row(motion.dt)
    place = case["record"], case["polarity"], case.get("pga", 0)
    grounds = grounds_at(layout, motion, _samples(motion))
    rows = []
    for law in range(len(study.grid.contact_models)):
        run = job.cases(place, law, study.rtol).in_full(limits)
        # At every sample of the record, of which a node interval may be a part only.
        rows.append(closing_at(layout, run.states[:: layout.parts, 0], grounds)[:, points].T)
    names = [f"{point.left_floor:.3g} | {point.right_floor:.3g}" for point in study.points]
    return Moved(
        np.array(rows), [names[point] for point in points], float(limits.gaps[points[0]]), limits.yield_forces[points]
    )
