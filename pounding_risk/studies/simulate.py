"""Time histories, contacts and energies of one run."""

from __future__ import annotations

from dataclasses import replace
from math import isfinite
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
from pounding_risk.models.structures.sdof import Oscillator
from pounding_risk.motions.motion import Motion, driven
from pounding_risk.results.contact_notes import of_run
from pounding_risk.results.files import as_text, versions
from pounding_risk.results.labels import CONVENTIONS, sources_of
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.reader import as_scene
from pounding_risk.scene.scene import Scene
from pounding_risk.scene.unused_keys import unused_keys
from pounding_risk.solver.counters import (
    COMPLETE,
    CONTACT_COLUMNS,
    FIRST_YIELD,
    STATUS,
    STATUS_SENTENCES,
    YIELDS,
    Log,
    make_log,
)
from pounding_risk.solver.pair.api import Interface, free_response, oscillators, run
from pounding_risk.solver.pair.flight import Free, state_at, write_series
from pounding_risk.solver.pair.outputs import building_outputs, run_outputs
from pounding_risk.solver.workspace import make_workspace
from pounding_risk.studies.simulate_row import cell_of, row_histories
from pounding_risk.units import GAP, PGA, YIELD_FORCE, si

Array = NDArray[np.float64]
ROWS = 4096  # to begin with; a log that overflows is made again with the room it asked for

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


def logged(pair: Any, free: Free, interface: Interface, rtol: float) -> tuple[Array, Log]:
    """A run with its log, whole: (raw columns, log)."""
    contacts, steps = ROWS, 8 * ROWS
    while True:
        log = make_log(contacts, steps, np.array([float(interface.yield_force)]))
        raw = run(pair, free, interface, rtol, log)
        if log.used[0] <= contacts and log.used[1] <= steps:
            if not isfinite(interface.law.ceiling(1.0)):
                # A law without a cap yields where its force reaches the yield force, as in `pair.solve`.
                raw[YIELDS], raw[FIRST_YIELD] = log.reached[0], log.first[0]
            return raw, log
        contacts, steps = max(contacts, int(log.used[0])), max(steps, int(log.used[1]))


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


def _node_times(free: Free) -> Array:
    return np.array([free.passage.moment(free.step, node) for node in range(free.ground.size)], dtype=np.float64)


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


def relative_displacement(free: Free, time: Array, states: Array) -> Array:
    """What closes the gap at these times: u_left − u_right, and what the ground itself adds."""
    return states[:, 0] - states[:, 1] - widening(free, time)[0]


def widening(free: Free, time: Array) -> Array:
    """(w, ẇ, ẅ) of w = x_right − x_left at these times, shape (3, n)."""
    values = np.zeros((3, len(time)))
    if not isinstance(free.passage, DelayedGround):
        return values
    wave, node = free.passage, _nodes_before(free, time)
    after = time - _node_times(free)[node]
    bend, slope = (wave.right - wave.left)[node], (wave.right_slope - wave.left_slope)[node]
    values[2] = bend + slope * after
    values[1] = wave.rate[node] + after * (bend + 0.5 * after * slope)
    values[0] = wave.spread[node] + after * (wave.rate[node] + after * (0.5 * bend + after * slope / 6.0))
    return values


def _nodes_before(free: Free, time: Array) -> NDArray[np.int64]:
    """The node at or before each time, never the last one."""
    nodes = np.searchsorted(_node_times(free), time, side="right") - 1
    return np.asarray(np.clip(nodes, 0, free.ground.size - 2), dtype=np.int64)


def histories(pair: tuple[Oscillator, Oscillator], free: Free, log: Log) -> tuple[Array, Array, Array, Array, Array]:
    """(times, states (n, 4), contact force, its work so far, its impulse so far) over the whole record.

    In contact the solver's own steps; in flight the free response plus the free vibration that the last contact
    left, in closed form, at every node.
    """
    nodes = _node_times(free)
    pieces = []
    done, first, sums = -np.inf, 0, np.zeros(2)
    vibration = np.zeros(4)
    for contact in [*log.contacts[: log.used[0]], None]:
        touch = np.inf if contact is None else contact[0]
        inside = (nodes > done) & (nodes < touch)
        flight = np.zeros((inside.sum(), 8))
        flight[:, 0] = nodes[inside]
        flight[:, 1:5] = free.states[inside] + _vibrations(pair, vibration, nodes[inside] - done)
        flight[:, 6:] = sums
        pieces.append(flight)
        if contact is None:
            break
        last = int(contact[11])
        piece = log.steps[first:last].copy()
        piece[:, 6:] += sums
        pieces.append(piece)
        first, done, sums = last, float(piece[-1, 0]), piece[-1, 6:]
        vibration = piece[-1, 1:5] - _free_at(pair, free, done)
    rows = np.concatenate(pieces)
    return rows[:, 0], rows[:, 1:5], rows[:, 5], rows[:, 6], rows[:, 7]


def _vibrations(pair: tuple[Oscillator, Oscillator], start: Array, after: Array) -> Array:
    """Free vibration of both buildings from ``start`` (u, u, v, v), at times ``after`` it: shape (n, 4)."""
    states = np.zeros((len(after), 4))
    if not np.any(start):
        return states
    for side, oscillator in enumerate(pair):
        if oscillator.inverse_omega == 0.0:
            continue
        zeta_omega = 0.5 * oscillator.two_zeta_omega
        rate = np.sqrt(oscillator.omega2 - zeta_omega * zeta_omega)
        decay, c, s = np.exp(-zeta_omega * after), np.cos(rate * after), np.sin(rate * after) / rate
        u, v = start[side], start[side + 2]
        states[:, side] = decay * (u * c + (v + zeta_omega * u) * s)
        states[:, side + 2] = decay * (v * c - (oscillator.omega2 * u + zeta_omega * v) * s)
    return states


def _free_at(pair: tuple[Oscillator, Oscillator], free: Free, time: float) -> Array:
    """The free response between nodes, from its series."""
    node = int(_nodes_before(free, np.array([time]))[0])
    workspace = make_workspace()
    write_series(
        pair, tuple(free.states[node]), free.passage.stretch(free.ground, free.step, node, 0.0), free.terms, workspace
    )
    return np.array(state_at(pair, workspace, free.terms, time - free.passage.moment(free.step, node)))


def energies(
    pair: tuple[Oscillator, Oscillator], free: Free, motion: tuple[Array, ...]
) -> dict[str, tuple[Array, str]]:
    """Energy of both buildings together at every time, by kind [J].

    Over an interval with a_g linear, −m ∫ a_g u̇ dt = −m ([a_g u] − a_g' ∫ u dt), and ∫ u dt follows from the
    equation of motion integrated once; what the structures' dampers took is what is left of the balance. A passing
    wave carries the buildings against each other: the ground then takes ∫ F ẇ dt out.
    """
    time, states, force, work, impulse = motion
    length = np.diff(time)
    put_in = -_carried(free, time, force, impulse)
    held = np.zeros_like(time)
    for side, oscillator in enumerate(pair):
        if oscillator.inverse_omega == 0.0:
            continue
        begins, slope = _grounds(free, time, side)
        ends = begins + slope * length
        area = 0.5 * (ends + begins) * length
        u, v = states[:, side], states[:, side + 2]
        push = (1.0, -1.0)[side] * np.diff(impulse) * oscillator.inverse_mass
        placed = (-area - np.diff(v) - oscillator.two_zeta_omega * np.diff(u) - push) / oscillator.omega2
        put_in[1:] -= oscillator.mass * np.cumsum(ends * u[1:] - begins * u[:-1] - slope * placed)
        held += 0.5 * oscillator.mass * (v * v + oscillator.omega2 * u * u)
    return {
        "ground": (put_in, "work that the ground has done on both buildings"),
        "held": (held, "kinetic and strain energy of both buildings"),
        "contact": (work, "work of the contact force, dissipated and stored"),
        "damping": (put_in - held - work, "energy that the structures' dampers have taken"),
    }


def _grounds(free: Free, time: Array, side: int) -> tuple[Array, Array]:
    """a_g under a building at the beginning of every interval between these times, and its slope there."""
    # What lies between two nodes is told by its middle: an end may stand on either side of a node by rounding.
    node = _nodes_before(free, 0.5 * (time[1:] + time[:-1]))
    after = time[:-1] - _node_times(free)[node]
    if isinstance(free.passage, DelayedGround):
        wave = free.passage
        values, slopes = ((wave.left, wave.left_slope), (wave.right, wave.right_slope))[side]
        return values[node] + slopes[node] * after, slopes[node]
    slope = (free.ground[node + 1] - free.ground[node]) / free.step
    return free.ground[node] + slope * after, slope


def _carried(free: Free, time: Array, force: Array, impulse: Array) -> Array:
    """∫ F ẇ dt = [ẇ J] − ∫ ẅ J dt, J = ∫ F dt, up to every time; by Hermite's rule, which knows F at both ends.

    Its error is (ω h)⁴ / 720 over intervals h in which F moves with ω: some millionths.
    """
    rate, length = widening(free, time)[1], np.diff(time)
    (left, left_slope), (right, right_slope) = (_grounds(free, time, side) for side in (0, 1))
    begins, twist = right - left, right_slope - left_slope
    ends = begins + twist * length
    turns = (begins * force[:-1] - ends * force[1:]) + twist * (impulse[:-1] - impulse[1:])
    areas = 0.5 * length * (ends * impulse[1:] + begins * impulse[:-1]) + length**2 / 12.0 * turns
    return rate * impulse - np.append(0.0, np.cumsum(areas))
