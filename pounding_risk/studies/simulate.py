"""Time histories, contacts and energies of one run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.dates import created
from pounding_risk._common.words import nearest
from pounding_risk.ensemble.laws import law_of
from pounding_risk.ensemble.limits import check_memory
from pounding_risk.ensemble.plausibility import of_input
from pounding_risk.errors import PoundingError
from pounding_risk.models.effects import wave_of
from pounding_risk.models.ground import DelayedGround
from pounding_risk.models.structures.contact_points import COLUMN
from pounding_risk.motions.motion import Motion, driven
from pounding_risk.results.contact_notes import of_run
from pounding_risk.results.files import as_text, versions
from pounding_risk.results.pair_labels import CONVENTIONS, sources_of
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.reader import as_scene
from pounding_risk.scene.scene import Scene
from pounding_risk.scene.unused_keys import unused_keys
from pounding_risk.solver.counters import (
    COMPLETE,
    CONTACT_COLUMNS,
    STATUS,
    STATUS_SENTENCES,
    Log,
)
from pounding_risk.solver.pair.api import Interface, free_response, oscillators
from pounding_risk.solver.pair.flight import Free
from pounding_risk.solver.pair.outputs import building_outputs, run_outputs
from pounding_risk.studies.pair_trace import (
    _node_times,
    energies,
    histories,
    logged,
    relative_displacement,
    widening,
)
from pounding_risk.studies.row_trace import cell_of, row_histories
from pounding_risk.units import GAP, PGA, YIELD_FORCE, si

Array = NDArray[np.float64]

RELATIVE = "what closes the gap: u_left - u_right, and what the ground adds"
CONTACT_UNITS = {
    "start": ("s", "touch"),
    "end": ("s", "parting, or the end of the record"),
    "approach_speed": ("m/s", "relative speed at the touch"),
    "restitution_asked": ("1", "restitution that the relation gives for this speed"),
    "peak_force": ("N", "largest force transmitted"),
    "uncapped_force": ("N", "largest force without the cap"),
    "peak_penetration": ("m", "largest penetration"),
    "yields": ("1", "times the uncapped force rose through the yield force"),
    "rebound_speed": ("m/s", "relative speed at the parting"),
    "impulse": ("N s", "impulse of the contact force"),
    "work": ("J", "work of the contact force: what the contact took"),
}


def simulate(
    study: Scene | str | Path,
    *,
    record: str | None = None,
    polarity: str | None = None,
    law: str | None = None,
    gap: float | str | None = None,
    yield_force: float | str | None = None,
    pga: float | str | None = None,
) -> xr.Dataset:
    """Run one case of a scene and return its time histories.

    Arguments that are left out take the scene's own values.

    Parameters
    ----------
    study : Scene or path
        A scene, or the path of its TOML file.
    record, polarity, law : str, optional
        Names of a record, a polarity and a contact model; the first record and polarity of the scene and its own
        contact model by default.
    gap : float or str, optional
        Clear distance at rest, a number in m or a text with a unit ("20 mm"). In a row it is that of all interfaces, or
        of the interface that the grid varies.
    yield_force : float or str, optional
        Yield force of the contact, a number in N or a text with a unit.
    pga : float or str, optional
        Peak ground acceleration to which the record is scaled, a number in m/s² or a text with a unit.

    Returns
    -------
    xarray.Dataset
        Of a pair: displacements, velocities, contact force and energies along ``time`` [s] (samples of the record and
        every step in contact) and ``building``, the contacts along ``contact``. Energies [J] are those of both
        buildings together: W_ground = kinetic + strain + damping + contact. Of a row: the motion of every floor along
        ``building`` and ``storey``, the force at every ``contact_point``, and the outputs that `scan` has of the case.

    Raises
    ------
    PoundingError
        As `scan`; and if the scene does not have the record or polarity, or a number is out of its range.
    """
    study = as_scene(study)
    gap, yield_force, pga = (
        None if value is None else si(value, quantity, f"simulate: {name}")
        for name, value, quantity in (("gap", gap, GAP), ("yield_force", yield_force, YIELD_FORCE), ("pga", pga, PGA))
    )
    motions = {motion.name: motion for motion in motions_of(study)}
    name = _chosen("record", record, tuple(motions))
    sense = _chosen("polarity", polarity, study.records.polarities)
    check_memory(study, (motions[name],))
    motion = driven(motions[name], sense, pga if pga is not None else study.grid.pgas[0])
    keys = unused_keys(study)
    unused = {"unused_keys": as_text(keys)} if keys else {}
    if study.is_row:
        if yield_force is not None and all(point.kind == COLUMN for point in study.points):
            raise PoundingError(
                "simulate: yield_force is that of floors, and in this row floors meet columns only; these yield at "
                "column_yield_force of their interface: change it in the scene (--set on the command line)"
            )
        run_of_row = row_histories(study, cell_of(study, motion, law or study.law_name, gap, yield_force))
        unusual = _notes(run_of_row, _narrowed(study, gap, pga), motions[name])
        return run_of_row.assign_attrs(record=name, polarity=sense, notes=unusual, **unused, **about_run())
    name_of_law = law or study.law_name
    interface = Interface(
        study.gap if gap is None else gap,
        law_of(study, name_of_law),
        study.restitution,
        study.yield_force if yield_force is None else yield_force,
    )
    run_of_pair = pair_histories(study, motion, interface)
    labels = {"record": name, "polarity": sense, "contact_model": name_of_law, **unused, **about_run()}
    return run_of_pair.assign_attrs(labels, notes=_notes(run_of_pair, _narrowed(study, gap, pga), motions[name]))


def about_run() -> dict[str, str]:
    """What every run with its histories says of itself beside what was run."""
    source = "pounding_risk: event-driven solver, one run with its histories"
    return {"Conventions": CONVENTIONS, "source": source, **created("pounding_risk.simulate")}


def _narrowed(study: Scene, gap: float | None, pga: float | None) -> Scene:
    """The study with the gap [m] and the amplitude [m/s²] of one run for its grid, where they are asked for."""
    grid = study.grid
    gaps = (study.gap if gap is None else gap,)
    return replace(study, grid=grid._replace(gaps=gaps, pgas=grid.pgas if pga is None else (pga,)))


def _notes(run: xr.Dataset, study: Scene, motion: Motion) -> str:
    """On unusual numbers of the scene, of this motion and of the run's contacts."""
    return as_text([*of_input(study, (motion,)), *of_run(run, study)])


def pair_histories(study: Scene, motion: Motion, interface: Interface) -> xr.Dataset:
    """A run of a pair with its histories, under a motion of one polarity and amplitude."""
    pair = oscillators(*study.pair)
    free = free_response(pair, motion.acceleration, motion.dt, wave_of(study.effects))
    raw, log = logged(pair, free, interface, study.rtol)
    outputs = {key: float(value) for key, value in run_outputs(raw, interface.yield_force).items()}
    sides = building_outputs(raw, study.pair, motion.pga)
    dataset = _dataset(study, (pair, free, log, interface.gap))
    if int(raw[STATUS]) != COMPLETE:
        dataset = _until(dataset, _last(log))
    return dataset.assign_attrs(
        title=study.name,
        gap=interface.gap,
        yield_force=interface.yield_force,
        pga=motion.pga,
        effects=", ".join(effect.name for effect in study.effects),
        references="; ".join(sources_of(study, [interface.law])),
        status=STATUS_SENTENCES[int(raw[STATUS])],
        outputs=as_text(outputs),
        building_outputs=as_text({key: list(map(float, values)) for key, values in sides.items()}),
        processing=as_text(list(motion.processing)),
        scene_resolved=study.to_toml(),
        versions=as_text(versions()),
    )


def _chosen(what: str, asked: str | None, known: tuple[str, ...]) -> str:
    if asked is None:
        return known[0]
    if asked not in known:
        sentence = f"{what} {asked!r} is not in the scene{nearest(asked, known)}, which has {', '.join(known)}"
        raise PoundingError(f"{sentence}; name one of these")
    return asked


def _last(log: Log) -> float:
    """The end of the last step that a run made in contact."""
    return float(log.steps[: log.used[1], 0].max(initial=0.0))


def _until(run: xr.Dataset, last: float) -> xr.Dataset:
    """A run that failed has no motion past its failure: NaN, where the buildings would swing on as if parted."""
    before_failure = run["time"] <= last
    names = [
        name
        for name, variable in run.data_vars.items()
        if "time" in variable.dims and not str(name).startswith("ground")
    ]
    return run.assign({name: run[name].where(before_failure).assign_attrs(run[name].attrs) for name in names})


def _dataset(study: Scene, parts: tuple[Any, Free, Log, float]) -> xr.Dataset:
    pair, free, log, gap = parts
    # A motion beyond all numbers is told by the run's status, not by a warning of each sum.
    with np.errstate(over="ignore", invalid="ignore"):
        motion = histories(pair, free, log)
        energy = energies(pair, free, motion)
    time, states, force = motion[:3]
    contacts = log.contacts[: log.used[0]]
    described = {
        "displacement": (("time", "building"), states[:, :2], "m", "displacement relative to the ground"),
        "velocity": (("time", "building"), states[:, 2:], "m/s", "velocity relative to the ground"),
        "relative_displacement": ("time", relative_displacement(free, time, states), "m", RELATIVE),
        "contact_force": ("time", force, "N", "contact force, compression positive"),
        "ground_acceleration": ("time", np.interp(time, _node_times(free), free.ground), "m/s2", "ground acceleration"),
        **_of_the_wave(free, time),
        **{f"energy_{key}": ("time", values, "J", words) for key, (values, words) in energy.items()},
        **{
            f"contact_{column}": ("contact", contacts[:, index], *CONTACT_UNITS[column])
            for index, column in enumerate(CONTACT_COLUMNS)
        },
    }
    return xr.Dataset(
        {
            key: (dims, values, {"units": unit, "long_name": words})
            for key, (dims, values, unit, words) in described.items()
        },
        coords={
            "time": ("time", time, {"units": "s", "long_name": "time since the start of the record"}),
            "building": ("building", [building.name for building in study.buildings]),
            "gap": ((), gap, {"units": "m", "long_name": "clear distance at rest"}),
        },
    )


def _of_the_wave(free: Free, time: Array) -> dict[str, tuple[str, Array, str, str]]:
    """What a passing wave adds to a history; nothing where the ground is one."""
    if not isinstance(free.passage, DelayedGround):
        return {}
    right = np.interp(time, _node_times(free), free.passage.right)
    return {
        "ground_acceleration_right": ("time", right, "m/s2", "ground acceleration under the right building"),
        "ground_widening": (
            "time",
            widening(free, time)[0],
            "m",
            "widening of the ground between the buildings, x_right - x_left",
        ),
    }
