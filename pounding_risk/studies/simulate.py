"""Time histories, contacts, energies and outputs of one run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import xarray as xr

from pounding_risk._common.dates import created
from pounding_risk._common.words import nearest
from pounding_risk.ensemble.job_choice import job_kind
from pounding_risk.ensemble.limits import check_memory
from pounding_risk.ensemble.plausibility import of_input
from pounding_risk.errors import PoundingError
from pounding_risk.models.structures.contact_points import COLUMN
from pounding_risk.motions.levels import PEAK, Level, Measure, at_pga, driven
from pounding_risk.motions.record import AFTERSHOCK
from pounding_risk.results.attributes import as_text
from pounding_risk.results.contact_notes import of_run
from pounding_risk.results.labels import CONVENTIONS, flags_of
from pounding_risk.results.run_labels import Case, run_dataset
from pounding_risk.scene.known_motions import check_computed
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.notes import unused_keys
from pounding_risk.scene.reader import as_scene
from pounding_risk.scene.scene import Scene, own_amplitude
from pounding_risk.scene.uncertain import stated
from pounding_risk.studies.pair_trace import pair_trace
from pounding_risk.studies.row_trace import row_trace
from pounding_risk.units import GAP, PGA, YIELD_FORCE, say, si

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
    """Run one case in full: outputs, contacts, histories.

    Arguments that are left out take the scene's own values.

    Parameters
    ----------
    study : Scene or path
        A scene, or the path of its TOML file.
    record : str, optional
        Name of a record of the scene; its first by default.
    polarity : str, optional
        "as recorded" or "reversed"; the scene's first by default.
    law : str, optional
        Contact model; the scene's own by default.
    gap : float or str, optional
        Clear distance at rest, a number in m or a text with a unit ("20 mm"), of all interfaces or of the only one that
        the grid varies.
    yield_force : float or str, optional
        Yield force of the contact, a number in N or a text with a unit.
    pga : float or str, optional
        Peak ground acceleration to which the record is scaled, a number in m/s² or a text with a unit; of several in
        the grid that of [records] or the largest by default, as in `assess`.
    intensity_level : float or str, optional
        Level of the measure of the scene's ``intensity`` to which the record is scaled, any number of its unit [SI] or
        a text with a unit; the largest of its levels by default.

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
    check_computed(study, "simulate")
    gap, yield_force, pga = (
        None if value is None else si(value, quantity, f"simulate: {name}")
        for name, value, quantity in (("gap", gap, GAP), ("yield_force", yield_force, YIELD_FORCE), ("pga", pga, PGA))
    )
    grid, requested = study.grid, _chosen_level(study.grid.measure, pga, intensity_level)
    level = requested or own_amplitude(study)
    motions = {motion.name: motion for motion in motions_of(study)}
    name = _chosen("record", record, tuple(motions))
    sense = _chosen("polarity", polarity, study.records.polarities)
    check_memory(study, (motions[name],), histories=True)
    if yield_force is not None:
        _check_floors(study)
    gap_of_grid, gaps = _gaps(study, gap)
    case = Case(
        driven(motions[name], sense, level),
        law or study.contact_model,
        gap_of_grid,
        study.yield_force if yield_force is None else yield_force,
        gaps,
        study.point_yield_forces(yield_force),
    )
    run = run_of(study, case)
    narrowed = study.updated(grid=grid._replace(gaps=(study.gap if gap is None else gap,), amplitudes=(level,)))
    notes = [*stated(study.uncertain, study.axes), *of_input(narrowed, (motions[name],)), *of_run(run, narrowed)]
    if requested is None and len(grid.amplitudes) > 1:
        *levels, own = (say(each.value, each.measure.quantity) for each in (*grid.amplitudes, level) if each)
        notes.append(f"Of the amplitudes {', '.join(levels)}, {own} is run: the scene's own, or else the largest.")
    if shock := motions[name].record.get(AFTERSHOCK):
        run = run.assign_attrs({AFTERSHOCK: shock["name"]})
    if level is not None and level.measure != PEAK:
        run = run.assign_attrs(intensity=level.measure.intensity, intensity_level=level.value)
    return run.assign_attrs(
        record=name,
        polarity=sense,
        notes=as_text(notes),
        **flags_of(narrowed, (motions[name],)),
        **({"unused_keys": as_text(keys)} if (keys := unused_keys(study)) else {}),
        Conventions=CONVENTIONS,
        source="pounding_risk: event-driven solver, one run with its histories",
        **created("pounding_risk.simulate"),
    )


def run_of(study: Scene, case: Case) -> xr.Dataset:
    """The run of a case with its histories; to the bit the one that a scan makes of it.

    Raises SceneError for a scene with a known motion.
    """
    check_computed(study, "a run")
    return run_dataset(study, case, TRACES[job_kind(study).solver](study, case))


def _chosen_level(measure: Measure, pga: float | None, intensity_level: float | str | None) -> Level | None:
    """The requested amplitude; None where the scene's own is taken."""
    if intensity_level is None:
        return at_pga(pga)
    if pga is not None:
        raise PoundingError("simulate: pga and intensity_level both set the amplitude; give one of them")
    return Level(measure, si(intensity_level, measure.quantity, "simulate: intensity_level"))


def _check_floors(study: Scene) -> None:
    """Raise PoundingError where no floors meet, whose yield force could be set."""
    if all(point.kind == COLUMN for point in study.points):
        raise PoundingError(
            "simulate: yield_force is that of floors, and in this row floors meet columns only; these yield at "
            "column_strength of their building, or column_yield_force of their interface: change it in the scene "
            "(--set on the command line)"
        )


def _gaps(study: Scene, gap: float | None) -> tuple[float, Sequence[float]]:
    """The gap of a case as the grid counts it, and by interface: of all, or of the only one that the grid varies."""
    own_gaps, varied = [interface.gap for interface in study.interfaces], study.gridded_interface
    if gap is None:
        return own_gaps[study.interface_names.index(varied) if varied else 0], own_gaps
    return gap, study.interface_gaps(gap) if len(study.grid.gaps) > 1 else [gap] * len(own_gaps)


def _chosen(noun: str, name: str | None, names: tuple[str, ...]) -> str:
    if name is None:
        return names[0]
    if name not in names:
        sentence = f"{noun} {name!r} is not in the scene{nearest(name, names)}, which has {', '.join(names)}"
        raise PoundingError(f"{sentence}; name one of these")
    return name
