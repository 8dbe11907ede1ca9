"""What can be compared with a published value: the quantities of an impact, of a recording and of a scene's run.

A quantity of a scene is any output of `simulate`, or a period or damping ratio of a building alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from pounding_risk.errors import PoundingError
from pounding_risk.results.run_labels import CONTACTS, HISTORIES
from pounding_risk.results.variables import VARIABLES, own_dims
from pounding_risk.solver.pair.isolated import Impact
from pounding_risk.units import GAP, say

# What says at which place, time or mode a quantity is meant.
PLACES = ("building", "storey", "interface", "contact_point", "contact", "mode")
SELECTORS = (*PLACES, "time", "since", "penetration", "period")
COUNTED = ("storey", "contact_point", "contact")  # by number, from 1
SPLINED = {"displacement": "velocity"}  # histories whose slope is known, and so is the curve between the nodes


class Measure(NamedTuple):
    """A quantity that can be compared."""

    unit: str
    takes: tuple[str, ...]  # selectors that it may have
    needs: tuple[str, ...]  # and those that it must have
    of: Callable[[Any, Mapping[str, Any]], float]  # from what was solved, and the selectors, to the value in SI


# ------------------------------------------------------------------------------------------------ one impact


def _deepest(impact: Impact, at: Mapping[str, Any]) -> float:
    """Time of the deepest penetration, where the rate passes zero between two steps."""
    first = int(np.argmax(impact.rate <= 0.0))
    span = slice(max(first - 1, 0), first + 1)
    return float(_spline(impact.time[span], impact.penetration[span], impact.rate[span]).derivative().roots()[0])


def force_curve(impact: Impact) -> tuple[np.ndarray, np.ndarray]:
    """Penetration [m] and force [N] of an impact on the way in."""
    going = slice(int(np.argmax(impact.penetration)) + 1)
    return impact.penetration[going], impact.force[going]


def _force(impact: Impact, at: Mapping[str, Any]) -> float:
    """Force at a penetration on the way in, between the steps by a spline in δ^1.5, in which Hertz's is a line."""
    from scipy.interpolate import CubicSpline

    depth = at["penetration"]
    depths, forces = force_curve(impact)
    if depth > depths[-1]:
        deepest = say(impact.peak_penetration, GAP)
        raise PoundingError(
            f"force at a penetration of {say(depth, GAP)}: the deepest is {deepest}; write a smaller one"
        )
    return float(CubicSpline(depths**1.5, forces)(depth**1.5))


def _fact(name: str, unit: str) -> Measure:
    """A number that an impact has by this name."""
    return Measure(unit, (), (), lambda impact, at: float(getattr(impact, name)))


FACTS = {"restitution": "1", "rebound_speed": "m/s", "peak_force": "N", "peak_penetration": "m", "duration": "s"}
FACTS |= {"impulse": "N s", "energy_lost": "J"}
IMPACT: Mapping[str, Measure] = {
    **{name: _fact(name, unit) for name, unit in FACTS.items()},
    "time_of_peak_penetration": Measure("s", (), (), _deepest),
    "force": Measure("N", ("penetration",), ("penetration",), _force),
}


# ------------------------------------------------------------------------------------------------ a recording


def _rotated(pair: tuple[Any, Any], period: float) -> Any:
    from pounding_risk.motions.intensity import rotated_spectra

    count = min(motion.acceleration.size for motion in pair)
    return rotated_spectra(tuple(motion.acceleration[:count] for motion in pair), pair[0].dt, [period])


MOTION: Mapping[str, Measure] = {
    "rotd50_pga": Measure("m/s^2", (), (), lambda pair, at: float(_rotated(pair, 1.0).rotd_pga(50))),
    "rotd50_sa": Measure(
        "m/s^2", ("period",), ("period",), lambda pair, at: float(_rotated(pair, at["period"]).rotd(50)[0])
    ),
}


# ------------------------------------------------------------------------------------------------ a scene


class Solved(NamedTuple):
    """What a scene gives: its run, None where only modes are compared, and the modes of its buildings."""

    run: xr.Dataset | None
    modes: Mapping[str, Any]  # by building


def _modal(field: str, unit: str) -> Measure:
    def of(solved: Solved, at: Mapping[str, Any]) -> float:
        building = at["building"]
        if building not in solved.modes:
            raise PoundingError(f"building {building!r} is not in the scene, which has {', '.join(solved.modes)}")
        values = getattr(solved.modes[building], field)
        if at["mode"] > len(values):
            raise PoundingError(f"mode {at['mode']} of {building}: it has {len(values)}; write a lower number")
        return float(values[at["mode"] - 1])

    return Measure(unit, ("building", "mode"), ("building", "mode"), of)


def history(run: xr.Dataset, name: str, at: Mapping[str, Any]) -> xr.DataArray:
    """A variable of a run at the places that are selected; raises PoundingError where more than one is left."""
    if name not in run:
        raise PoundingError(f"{name}: the run of this scene does not have it; write another output of `simulate`")
    values = run[name]
    for dim in values.dims:
        if dim == "time":
            continue
        if dim not in at and values.sizes[dim] != 1:
            raise PoundingError(f"{name} has {values.sizes[dim]} values along {dim}; write which: {dim} = ...")
        values = values.isel({dim: _index(run, name, str(dim), at)})
    return values


def _index(run: xr.Dataset, name: str, dim: str, at: Mapping[str, Any]) -> int:
    if dim not in at:
        return 0
    size, wanted = run.sizes[dim], at[dim]
    if dim in COUNTED:
        if wanted > size:
            raise PoundingError(f"{name}: {dim} {wanted} of {size}; write a number from 1 to {size}")
        return int(wanted) - 1
    names = [str(label) for label in run[dim].values]
    if wanted not in names:
        raise PoundingError(f"{name}: {dim} {wanted!r} is not in the scene, which has {', '.join(names)}")
    return names.index(wanted)


def _output(name: str) -> Callable[[Solved, Mapping[str, Any]], float]:
    def of(solved: Solved, at: Mapping[str, Any]) -> float:
        if solved.run is None:
            raise PoundingError(f"{name}: the scene was not run")
        values = history(solved.run, name, at)
        if "time" not in values.dims:
            return float(values)
        times = values.time.values
        if not times[0] <= at["time"] <= times[-1]:
            lasts = f"the run lasts from {times[0]:g} to {times[-1]:g} s"
            raise PoundingError(f"{name} at {at['time']:g} s: {lasts}; write a time in it")
        if name not in SPLINED:
            return float(np.interp(at["time"], times, values.values))
        slope = history(solved.run, SPLINED[name], at).values
        after = min(max(int(np.searchsorted(times, at["time"])), 1), times.size - 1)
        span = slice(after - 1, after + 1)
        return float(_spline(times[span], values.values[span], slope[span])(at["time"]))

    return of


def _mean_speed(solved: Solved, at: Mapping[str, Any]) -> float:
    """Mean size of a floor's velocity over a span of time [m/s]."""
    if solved.run is None:
        raise PoundingError("mean_speed: the scene was not run")
    within = abs(history(solved.run, "velocity", at)).sel(time=slice(at["since"], at["time"]))
    return float(within.integrate("time") / (within.time[-1] - within.time[0]))


def _spline(x: Any, y: Any, slope: Any) -> Any:
    from scipy.interpolate import CubicHermiteSpline

    return CubicHermiteSpline(x, y, slope)


def _outputs() -> dict[str, Measure]:
    """Every output of `simulate` with its unit and what selects one value."""
    listed = {name: (dims, unit) for name, (dims, unit, _) in HISTORIES.items()}
    listed |= {f"contact_{name}": (("contact",), unit) for name, (unit, _) in CONTACTS.items()}
    for name, declared in VARIABLES.items():
        if declared.unit is not None and "period" not in declared.dims and "free" not in name:
            listed.setdefault(name, (own_dims(name), declared.unit))
    measures = {}
    for name, (dims, unit) in listed.items():
        needs = tuple(dim for dim in dims if dim == "time")
        measures[name] = Measure({"m/s2": "m/s^2"}.get(unit, unit), dims, needs, _output(name))
    return measures


MODAL = {"period": _modal("periods", "s"), "damping_ratio": _modal("dampings", "1")}
MODAL["angular_frequency"] = MODAL["period"]._replace(
    unit="rad/s", of=lambda solved, at: 2.0 * np.pi / MODAL["period"].of(solved, at)
)
SPANNED = {
    "mean_speed": Measure("m/s", ("building", "storey", "since", "time"), ("building", "since", "time"), _mean_speed)
}
SCENE: Mapping[str, Measure] = {**_outputs(), **MODAL, **SPANNED}
