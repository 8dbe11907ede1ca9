"""Outputs of a run: name, unit, description, and how each follows from the counters of the kernels.

Raw columns are `COLUMNS` numbers for each run: the counters, then the largest and the smallest of every watched signal.

A model whose velocities jump (`models.contact.impulsive`) has no finite force at a touch: its largest force is that of
the joined motion, NaN where there was a touch and none, and yielding is not defined, NaN or −1, once there was a touch.
Its ``energy_viscous`` is what the jumps take, its ``contact_time`` that of the joined motion. `DistributedMass` gives
each jump a force and a duration, and its outputs are those of a law without a cap; what waves in the floors keep counts
as ``energy_viscous``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.models.structures.sdof import Building
from pounding_risk.solver import counters
from pounding_risk.solver.pair.flight import SIGNALS

Raw = NDArray[np.float64]
COLUMNS = counters.TALLIED + 2 * SIGNALS
HIGH, LOW = counters.TALLIED, counters.TALLIED + SIGNALS


class Output(NamedTuple):
    """One variable of a dataset; ``compute`` takes raw columns (..., COLUMNS) and the yield force [N]."""

    unit: str
    words: str
    compute: Callable[[Raw, Raw], Raw]
    whole: bool = False  # a count or a flag: stored as integer, −1 where the run failed or it is not defined


def _column(number: int) -> Callable[[Raw, Raw], Raw]:
    return lambda raw, strength: raw[..., number]


def _share(raw: Raw, strength: Raw) -> Raw:
    # Without yielding (infinite F_E) the demand is zero, also where there was no contact.
    return raw[..., counters.DEMAND] / strength


def _defined(raw: Raw, count: NDArray[Any]) -> Raw:
    # A jump has no force that could reach the yield force: what depends on it is not defined.
    return np.where(np.isnan(raw[..., counters.DEMAND]), -1.0, count)


def _residual(raw: Raw, strength: Raw) -> Raw:
    peak = raw[..., counters.ENERGY]
    return np.abs(raw[..., counters.RESIDUAL]) / np.where(peak > 0.0, peak, 1.0)


def _reach(signal: int) -> Callable[[Raw], Raw]:
    return lambda raw: np.maximum(raw[..., HIGH + signal], -raw[..., LOW + signal])


RUN: dict[str, Output] = {
    "peak_relative_displacement": Output(
        "m",
        "largest |u_left - u_right| of the continuous motion, with the ground's own widening on unlike grounds",
        lambda raw, _: _reach(0)(raw),
    ),
    "peak_closing": Output("m", "largest u_left - u_right towards contact", _column(HIGH)),
    "peak_opening": Output("m", "largest u_right - u_left, away from contact", lambda raw, _: -raw[..., LOW]),
    "peak_penetration": Output(
        "m",
        "largest penetration of any contact, from the gap that permanent indentations widen",
        _column(counters.PENETRATION),
    ),
    "impact_count": Output("1", "contacts, each from touch to parting", _column(counters.COUNT), whole=True),
    "first_impact_time": Output("s", "time of the first touch; NaN without contact", _column(counters.FIRST_TOUCH)),
    "contact_time": Output("s", "duration of all contacts together", _column(counters.CONTACT_TIME)),
    "peak_approach_speed": Output("m/s", "largest relative speed at a touch", _column(counters.APPROACH)),
    "peak_contact_force": Output(
        "N",
        "largest contact force; of a jump in velocity, which has no finite force, the force in joined motion, or NaN",
        _column(counters.PEAK_FORCE),
    ),
    "lowest_contact_force": Output(
        "N", "smallest contact force; negative where the law pulls", _column(counters.LOWEST_FORCE)
    ),
    "impulse": Output("N s", "total impulse of the contact force", _column(counters.IMPULSE)),
    "yield_exceedance": Output(
        "1",
        "1 where the uncapped force reaches the yield force",
        lambda raw, _: _defined(raw, raw[..., counters.YIELDS] > 0.0),
        whole=True,
    ),
    "yield_demand": Output("1", "largest uncapped force over the yield force", _share),
    "yield_count": Output(
        "1",
        "contacts in which the uncapped force reaches the yield force",
        lambda raw, _: _defined(raw, raw[..., counters.YIELDS]),
        whole=True,
    ),
    "first_yield_time": Output(
        "s",
        "time at which the uncapped force first reaches the yield force; NaN without yielding",
        _column(counters.FIRST_YIELD),
    ),
    "energy_viscous": Output("J", "energy that the contact's damper takes", _column(counters.VISCOUS)),
    "energy_plastic": Output(
        "J", "energy that yielding takes; none in laws whose plateau is retraced", _column(counters.PLASTIC)
    ),
    "permanent_set": Output("m", "widening of the gap by indentations at the end of the run", _column(counters.SET)),
    "energy_residual": Output(
        "1",
        "energy that all contacts together leave unaccounted for, over the largest mechanical energy at a touch",
        _residual,
    ),
    "restitution_held": Output(
        "1",
        "contacts faster than the range of the restitution relation, computed with the restitution at the range's end",
        _column(counters.HELD),
        whole=True,
    ),
}

# Per building, from the raw columns and the building; each is stored with its twin without contact.
BUILDING: dict[str, tuple[str, str, Callable[[Raw, Building, int, Raw | float], Raw]]] = {
    "peak_displacement": (
        "m",
        "largest displacement relative to the ground under the building",
        lambda raw, building, side, pga: _reach(1 + side)(raw),
    ),
    "peak_storey_shear": (
        "N",
        "largest force in the building's spring, k u; NaN for a rigid building",
        lambda raw, building, side, pga: (
            np.full_like(raw[..., 0], np.nan) if building.is_rigid else building.stiffness * _reach(1 + side)(raw)
        ),
    ),
    "peak_floor_acceleration": (
        "m/s2",
        "largest absolute acceleration of the mass, in contact too, without jumps in velocity, which have no finite "
        "acceleration; of a rigid building, the ground's",
        lambda raw, building, side, pga: np.full_like(raw[..., 0], pga) if building.is_rigid else _reach(3 + side)(raw),
    ),
}


def run_outputs(raw: Raw, yield_force: Raw | float) -> dict[str, Raw]:
    """Every output of `RUN` by name, with raw's leading shape; failed runs are NaN, or −1 in counts and flags."""
    strength = np.asarray(yield_force, dtype=float)
    failed = raw[..., counters.STATUS] != counters.COMPLETE
    return {
        name: np.where(failed, -1.0 if output.whole else np.nan, output.compute(raw, strength))
        for name, output in RUN.items()
    }


def building_outputs(raw: Raw, buildings: tuple[Building, Building], pgas: Raw) -> dict[str, Raw]:
    """Every output of `BUILDING` by name, with a last axis for left and right.

    ``pgas`` are the peaks of a_g under both [m/s²], (..., 2) with the runs' shape before.
    """
    failed = raw[..., counters.STATUS] != counters.COMPLETE
    return {
        name: np.stack(
            [
                np.where(failed, np.nan, compute(raw, building, side, pgas[..., side]))
                for side, building in enumerate(buildings)
            ],
            axis=-1,
        )
        for name, (_, _, compute) in BUILDING.items()
    }
