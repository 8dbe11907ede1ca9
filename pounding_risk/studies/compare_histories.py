"""Relative displacement of one case of a comparison under every contact model, at one interface."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.motions.levels import driven
from pounding_risk.results.labels import described
from pounding_risk.results.run_labels import Case
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.scene import Scene
from pounding_risk.studies.histories import level_forces
from pounding_risk.studies.simulate import run_of

Array = NDArray[np.float64]


class Shown(NamedTuple):
    """Which case of the grid is shown, by the place on each of its axes, and at which interface, from 0."""

    case: dict[str, int]
    place: int


def histories_of_laws(study: Scene, shown: Shown, baseline: str) -> dict[str, Any]:
    """Relative displacement of one case under every law at the record's samples, and which case it is.

    At the contact point of the interface whose displacement is largest under the baseline; NaN once a run has failed.
    """
    case, grid, polarities = shown.case, study.grid, study.records.polarities
    gap, force = grid.gaps[case["gap"]], grid.yield_forces[case["yield_force"]]
    level = grid.amplitudes[case.get(grid.measure.axis, 0)]
    motion = driven(motions_of(study)[case["record"]], polarities[case["polarity"]], level)
    gaps, forces = study.interface_gaps(gap), level_forces(study, force)
    samples = np.arange(len(motion.acceleration), dtype=np.float64) * motion.dt
    values = np.array(
        [_closing(study, Case(motion, law, gap, force, gaps, forces), samples) for law in grid.contact_models]
    )
    here = [index for index, point in enumerate(study.points) if point.interface == shown.place]
    baselines = np.abs(values[grid.contact_models.index(baseline)][here])
    point = here[int(np.nanmax(baselines, axis=-1).argmax())]
    about: dict[str, Any] = described("m", "relative displacement of a case of median spread") | {"record": motion.name}
    about |= {"polarity": polarities[case["polarity"]], "pga": motion.pga, "gap": float(gaps[shown.place])}
    about |= {"yield_force": float(forces[point]), "interface": study.interface_names[shown.place]}
    floors = "{1:.3g} | {2:.3g}".format(*study.points[point])
    about |= {"contact_point": floors if len(study.points) > 1 else study.interface_names[shown.place]}
    return {
        "time": ("time", samples, described("s", "time since the start of the record")),
        "history": (("contact_model", "time"), values[:, point], about),
    }


def _closing(study: Scene, case: Case, samples: Array) -> Array:
    """Relative displacement at every contact point of one run (points, samples) [m]."""
    run = run_of(study, case)
    times, closing = run["time"].values, run["relative_displacement"].transpose("contact_point", "time").values
    return np.array([np.interp(samples, times, values, right=np.nan) for values in closing])
