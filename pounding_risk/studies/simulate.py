"""Time histories, contacts, energies and outputs of one run."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from pounding_risk._common.dates import created
from pounding_risk._common.words import nearest
from pounding_risk.ensemble.job_choice import job_kind
from pounding_risk.ensemble.limits import check_memory
from pounding_risk.ensemble.plausibility import of_input
from pounding_risk.errors import PoundingError
from pounding_risk.models.structures.contact_points import COLUMN
from pounding_risk.motions.levels import PEAK, Level, at_pga, driven
from pounding_risk.motions.motion import Motion
from pounding_risk.results.attributes import as_text
from pounding_risk.results.contact_notes import of_run
from pounding_risk.results.labels import CONVENTIONS
from pounding_risk.results.run_labels import Case, run_dataset
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.notes import unused_keys
from pounding_risk.scene.reader import as_scene
from pounding_risk.scene.scene import Scene
from pounding_risk.scene.uncertain import stated
from pounding_risk.studies.pair_trace import pair_trace
from pounding_risk.studies.row_trace import row_trace
from pounding_risk.units import GAP, PGA, YIELD_FORCE, si

TRACES = {"pair": pair_trace, "row": row_trace}  # by solver


def simulate(
    study: Scene | str | Path,
    *,
    record: str | None = None,
    polarity: str | None = None,
    law: str | None = None,
    gap: float | str | None = None,
    yield_force: float | str | None = None,
    pga: float | str | None = None,
    intensity_level: float | str | None = None,
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
        Clear distance at rest, a number in m or a text with a unit ("20 mm"), of all interfaces or of the only one that
        the grid varies.
    yield_force : float or str, optional
        Yield force of the contact, a number in N or a text with a unit.
    pga : float or str, optional
        Peak ground acceleration to which the record is scaled, a number in m/s² or a text with a unit.
    intensity_level : float or str, optional
        Level of the measure of the scene's ``intensity`` to which the record is scaled, any number of its unit [SI] or
        a text with a unit; the first of its levels by default.

    Returns
    -------
    xarray.Dataset
        Along ``time`` [s] (nodes of the record and every step in contact): the motion of every floor along ``building``
        and ``storey``, NaN where there is none; the relative displacement, force and impulse at every
        ``contact_point``; and of a pair of single masses the energies [J] of both buildings together, W_ground =
        kinetic and strain + damping + contact. Along ``contact`` the contacts in the order of their touches. Beside
        them every output that `scan` has of the case. What a solver does not make is absent.

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
    asked = _asked(study, pga, intensity_level)
    level = asked or study.grid.amplitudes[0]
    motions = {motion.name: motion for motion in motions_of(study)}
    name = _chosen("record", record, tuple(motions))
    sense = _chosen("polarity", polarity, study.records.polarities)
    check_memory(study, (motions[name],), histories=True)
    if yield_force is not None and all(point.kind == COLUMN for point in study.points):
        raise PoundingError(
            "simulate: yield_force is that of floors, and in this row floors meet columns only; these yield at "
            "column_yield_force of their interface: change it in the scene (--set on the command line)"
        )
    motion = driven(motions[name], sense, level)
    run = run_of(study, case_of(study, motion, law or study.contact_model, gap, yield_force))
    keys = unused_keys(study)
    unused = {"unused_keys": as_text(keys)} if keys else {}
    notes = _notes(run, _narrowed(study, gap, asked), motions[name])
    if level is not None and level.measure != PEAK:
        run = run.assign_attrs(intensity=level.measure.intensity, intensity_level=level.value)
    return run.assign_attrs(record=name, polarity=sense, notes=notes, **unused, **about_run())


def case_of(study: Scene, motion: Motion, law: str, gap: float | None, yield_force: float | None) -> Case:
    """The case of the scene's own gaps and yield forces, or of those given [m, N].

    A gap is that of all interfaces, but of the only one that the grid varies where it names one.
    """
    varied = study.gridded_interface if len(study.grid.gaps) > 1 else None
    own_gaps = {name: interface.gap for name, interface in zip(study.interface_names, study.interfaces, strict=True)}
    gaps = [here if gap is None or varied not in (None, name) else gap for name, here in own_gaps.items()]
    return Case(
        motion,
        law,
        own_gaps[study.gridded_interface or study.interface_names[0]] if gap is None else gap,
        study.yield_force if yield_force is None else yield_force,
        gaps,
        study.point_yield_forces(yield_force),
    )


def run_of(study: Scene, case: Case) -> xr.Dataset:
    """The run of a case with its histories; to the bit the one that a scan makes of it."""
    return run_dataset(study, case, TRACES[job_kind(study).solver](study, case))


def about_run() -> dict[str, str]:
    """What every run with its histories says of itself beside what was run."""
    source = "pounding_risk: event-driven solver, one run with its histories"
    return {"Conventions": CONVENTIONS, "source": source, **created("pounding_risk.simulate")}


def _asked(study: Scene, pga: float | None, intensity_level: float | str | None) -> Level | None:
    """The amplitude that is asked for; None where none is."""
    measure = study.grid.measure
    if intensity_level is None:
        return at_pga(pga)
    if pga is not None:
        raise PoundingError("simulate: pga and intensity_level both set the amplitude; give one of them")
    return Level(measure, si(intensity_level, measure.quantity, "simulate: intensity_level"))


def _narrowed(study: Scene, gap: float | None, level: Level | None) -> Scene:
    """The study with the gap [m] and the amplitude of one run for its grid, where they are asked for."""
    grid = study.grid
    gaps = (study.gap if gap is None else gap,)
    return study.updated(grid=grid._replace(gaps=gaps, amplitudes=grid.amplitudes if level is None else (level,)))


def _notes(run: xr.Dataset, study: Scene, motion: Motion) -> str:
    """On unusual numbers of the scene, of this motion and of the run's contacts."""
    return as_text([*stated(study.uncertain), *of_input(study, (motion,)), *of_run(run, study)])


def _chosen(noun: str, name: str | None, names: tuple[str, ...]) -> str:
    if name is None:
        return names[0]
    if name not in names:
        sentence = f"{noun} {name!r} is not in the scene{nearest(name, names)}, which has {', '.join(names)}"
        raise PoundingError(f"{sentence}; name one of these")
    return name
