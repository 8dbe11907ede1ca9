"""One run of a row in full: where every floor is, and what every contact point transmits, instant by instant.

Contact forces follow from the momentum of the floors. Between two instants, with ∫ by the trapezoidal rule,

    Bᵀ F Δt = −[m Δv + ∫ (C v + V − V_above + m a_g) dt],

F by least squares over the points that are closed; row k of B is what the displacements close at point k. So the
impulse between two instants is the run's own, and F its mean.
"""

from __future__ import annotations

from math import ceil
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk import rows
from pounding_risk.chains import Chain
from pounding_risk.core.tally import STATUS_SENTENCES
from pounding_risk.models.effects import with_effects
from pounding_risk.motions import Motion
from pounding_risk.results import as_text, versions
from pounding_risk.row_dataset import row_coordinates
from pounding_risk.row_grid import RowGrid, row_grid
from pounding_risk.row_model import RowModel
from pounding_risk.row_outputs import outputs, variables
from pounding_risk.scan_dataset import described, sources_of
from pounding_risk.study import Study

Array = NDArray[np.float64]
STEP = 1e-3  # s, between two instants at most: a contact of buildings lasts some ten of them


class Cell(NamedTuple):
    """What is run: a motion under one contact model, with the gaps [m] and yield forces [N] of the contact points."""

    motion: Motion
    law: str
    gaps: Array
    yield_forces: Array


def cell_of(study: Study, motion: Motion, law: str, gap: float | None, yield_force: float | None) -> Cell:
    """The scene's own gaps and yield forces, or those named: the gap of the gridded interface, or of all of them."""
    own = [neighbour.gap for neighbour in study.neighbours]
    gaps = np.array(own if gap is None else study.interface_gaps(gap))
    return Cell(motion, law, gaps, np.array(study.point_yield_forces(yield_force)))


def row_histories(study: Study, cell: Cell) -> xr.Dataset:
    """The run with its histories, and every output of a case; raises as `row_grid`.

    Dimensions: time [s], building, storey, interface, contact_point.
    """
    grid = row_grid(study)
    model, motion = grid.frame.model, cell.motion
    laid, ground = _finer(model, motion)
    run = rows.run_row(laid, _contacts(study, model, cell), ground, rtol=study.rtol, states=True)
    nodes = rows.nodes_of(laid, ground)
    closing = closing_of(model)
    force = contact_forces(model, run.states, (nodes, laid.step), closing, cell.gaps[model.interfaces])
    moved, fast = (_by_storey(grid, run.states[:, place]) for place in (0, 1))
    floors = ("time", "building", "storey")
    found: dict[str, Any] = {
        "displacement": (floors, moved, described("m", "displacement of the floor relative to the ground")),
        "velocity": (floors, fast, described("m/s", "velocity of the floor relative to the ground")),
        "contact_force": (("time", "contact_point"), force, described("N", "mean force since the instant before")),
        "ground_acceleration": ("time", nodes, described("m/s2", "ground acceleration")),
    }
    told = outputs(run, cell.yield_forces, motion.pga, grid.frame)
    for name, variable in variables(grid.frame).items():
        found[name] = (variable.dims, told[name], described(variable.unit, variable.words))
    coords = row_coordinates(study, grid)
    coords["contact_point_yield_force"] = ("contact_point", cell.yield_forces, described("N", "yield force F_E"))
    coords["interface_gap"] = ("interface", cell.gaps, described("m", "clear distance at rest"))
    names = [building.name for building in study.buildings]
    coords["building"] = ("building", names, {"long_name": "building, left to right"})
    coords["time"] = ("time", laid.step * np.arange(nodes.size), described("s", "time"))
    return xr.Dataset(found, coords=coords, attrs=_attributes(study, cell, run.status))


def _finer(model: RowModel, motion: Motion) -> tuple[rows.Laid, Array]:
    """The row laid out for instants `STEP` apart at most; a_g is linear between samples, and so it is between these."""
    parts = ceil(motion.dt / STEP)
    samples = np.arange(motion.acceleration.size)
    ground = np.interp(np.arange((samples.size - 1) * parts + 1) / parts, samples, motion.acceleration)
    return rows.lay_out(model.chains, model.points, motion.dt / parts), ground


def _contacts(study: Study, model: RowModel, cell: Cell) -> rows.Contacts:
    laws = [with_effects(study.law_at(place, cell.law), study.effects) for place in range(len(study.neighbours))]
    rules = [neighbour.restitution for neighbour in study.neighbours]
    places = model.interfaces
    return rows.Contacts(
        cell.gaps[places], cell.yield_forces, [laws[at] for at in places], [rules[at] for at in places]
    )


def closing_of(model: RowModel) -> Array:
    """B (contact points, masses): what displacements of the masses close at each point, u_left − u_right."""
    found = np.zeros((len(model.points), model.firsts[-1]))
    for row, point in zip(found, model.points, strict=True):
        for side, floor in enumerate((point.left_floor, point.right_floor)):
            chain = model.chains[point.interface + side]
            first = model.firsts[point.interface + side] + chain.foundations - 1
            below, part = divmod(float(floor), 1.0)
            for place, share in ((int(below), 1.0 - part), (int(below) + 1, part)):
                # What is below the lowest mass is the ground, or the foundation.
                if chain.mass.size and share and place + chain.foundations > 0:
                    row[first + place] += (1.0 - 2.0 * side) * share
    return found


def contact_forces(model: RowModel, states: Array, ground: tuple[Array, float], closing: Array, gaps: Array) -> Array:
    """Mean force [N] at each contact point since the instant before, (instants, contact points).

    ``states`` are u and v (instants, 2, masses), ``ground`` a_g at the instants and the time between them.
    """
    acceleration, step = ground
    u, v = states[:, 0], states[:, 1]
    mass = np.concatenate([chain.mass for chain in model.chains])
    held = mass * acceleration[:, None]
    for first, chain in zip(model.firsts, model.chains, strict=False):
        here = slice(first, first + chain.mass.size)
        shears = storey_shears(chain, u[:, here])
        held[:, here] += v[:, here] @ chain.damping.T + shears - np.pad(shears[:, 1:], ((0, 0), (0, 1)))
    pushed = -(mass * np.diff(v, axis=0) / step + 0.5 * (held[1:] + held[:-1]))
    is_closed = u @ closing.T > gaps
    touching = is_closed[1:] | is_closed[:-1]
    force = np.zeros((len(u), len(closing)))
    for pattern in np.unique(touching[touching.any(axis=1)], axis=0):
        when = np.flatnonzero((touching == pattern).all(axis=1))
        force[np.ix_(when + 1, np.flatnonzero(pattern))] = pushed[when] @ np.linalg.pinv(closing[pattern].T).T
    return force


def storey_shears(chain: Chain, u: Array) -> Array:
    """The shear of each storey [N] under its drifts, (instants, masses): bilinear where it has a strength."""
    drift = np.diff(u, axis=1, prepend=0.0)
    limits = chain.strength / chain.shear
    if not np.isfinite(limits).any():
        return np.asarray(chain.spring * drift)
    plastic, lasting = np.zeros(drift.shape[1]), np.zeros_like(drift)
    for at, now in enumerate(drift):
        plastic = np.clip(plastic, now - limits, now + limits)
        lasting[at] = plastic
    return np.asarray(chain.spring * drift - (1.0 - chain.hardening) * chain.shear * lasting)


def _by_storey(grid: RowGrid, values: Array) -> Array:
    """Values of the masses (instants, masses) as (instants, buildings, storeys); NaN where there is none."""
    places = grid.frame.storeys
    return np.where(places >= 0, values[:, np.maximum(places, 0)] if values.shape[1] else np.nan, np.nan)


def _attributes(study: Study, cell: Cell, status: int) -> dict[str, Any]:
    law = study.law_at(0, cell.law)
    return {
        "title": study.name,
        "contact_model": cell.law,
        "pga": cell.motion.pga,
        "effects": ", ".join(effect.name for effect in study.effects),
        "references": "; ".join(sources_of(study, [law])),
        "status": STATUS_SENTENCES[status],
        "processing": as_text(list(cell.motion.processing)),
        "scene_resolved": study.to_toml(),
        "versions": as_text(versions()),
    }
