"""Outputs of a row: per interface, contact point, building and storey, from what the kernels count.

An interface's are those of a pair (`outputs.RUN`), gathered from its contact points: peaks are the largest of them,
counts, times in contact, impulses and energies their sums, first times the earliest.
"""

from __future__ import annotations

from math import inf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.solver import counters
from pounding_risk.solver.pair.outputs import COLUMNS, HIGH, LOW, RUN, run_outputs
from pounding_risk.solver.row.api import COLLAPSE_TIME, HIGHEST, LOWEST, RowRun
from pounding_risk.solver.row.model import RowModel

Array = NDArray[np.float64]
Outputs = dict[str, Array]

DISPLACEMENT, DRIFT, SHEAR, ACCELERATION = range(4)  # columns of `RowRun.floors`
AT_END, PLASTIC, DISSIPATED, STRENGTH_LEFT = range(4)  # columns of `RowRun.rest`

# How an interface's columns follow from those of its points.
LARGEST = (
    counters.PENETRATION,
    counters.APPROACH,
    counters.PEAK_FORCE,
    counters.DEMAND,
    counters.SET,
    counters.DAMAGE,
    counters.ENERGY,
    counters.STEPS,
    counters.RESIDUAL,
    HIGH,
)
SUMS = (
    counters.COUNT,
    counters.CONTACT_TIME,
    counters.IMPULSE,
    counters.YIELDS,
    counters.VISCOUS,
    counters.PLASTIC,
    counters.HELD,
)
SMALLEST = (counters.LOWEST_FORCE, LOW)
EARLIEST = (counters.FIRST_TOUCH, counters.FIRST_YIELD)
GATHERED = ((LARGEST, np.maximum), (SUMS, np.add), (SMALLEST, np.minimum), (EARLIEST, np.fmin))


class Variable(NamedTuple):
    """A variable of the dataset: unit, words, its dimensions beside those of the cases, and whether it counts."""

    unit: str
    words: str
    dims: tuple[str, ...]
    whole: bool = False


# Of `RUN`, those that each contact point has as well, as contact_point_...
OF_POINTS = (
    "impact_count",
    "peak_contact_force",
    "peak_penetration",
    "impulse",
    "yield_exceedance",
    "yield_demand",
    "first_impact_time",
    "peak_closing",
    "energy_viscous",
    "energy_plastic",
)
POINT = "contact_point_"
# What an interface's value is made of, for those of several contact points.
OVER_POINTS = {
    "peak_penetration": "largest of the contact points",
    "impact_count": "sum over the contact points",
    "first_impact_time": "earliest of the contact points",
    "contact_time": "sum over the contact points, so more than the time in which any point touches",
    "peak_approach_speed": "largest of the contact points",
    "peak_contact_force": "largest of the contact points, not of the sum of forces",
    "lowest_contact_force": "smallest of the contact points",
    "impulse": "sum over the contact points",
    "yield_exceedance": "of any contact point",
    "yield_demand": "largest of the contact points",
    "yield_count": "sum over the contact points",
    "first_yield_time": "earliest of the contact points",
    "energy_viscous": "sum over the contact points",
    "energy_plastic": "sum over the contact points",
    "permanent_set": "largest of the contact points",
    "restitution_held": "sum over the contact points",
}
OF_SPRINGS = "largest shear in the spring, without the P d / h of p_delta,"
AT_STOREYS = ("building", "storey")
OF_STOREYS = {  # in the order of the columns of `RowRun.floors`
    "storey_displacement": Variable("m", "largest displacement of the floor above relative to the ground", AT_STOREYS),
    "storey_drift": Variable("m", "largest drift of the storey", AT_STOREYS),
    "storey_shear": Variable("N", f"{OF_SPRINGS} of the storey; NaN without storey springs", AT_STOREYS),
    "storey_acceleration": Variable("m/s2", "largest absolute acceleration of the floor above", AT_STOREYS),
}
OF_BUILDINGS = {  # in the same order: the largest of the storeys
    "peak_displacement": Variable("m", "largest displacement of any floor relative to the ground", ("building",)),
    "peak_drift": Variable("m", "largest drift of any storey; NaN for a rigid building", ("building",)),
    "peak_storey_shear": Variable(
        "N", f"{OF_SPRINGS} of any storey; NaN for a rigid building and where a storey has no spring", ("building",)
    ),
    "peak_floor_acceleration": Variable(
        "m/s2",
        "largest absolute acceleration of any floor, in contact too; of a rigid building, the ground's",
        ("building",),
    ),
}
OF_LINKS = {
    "peak_link_stretch": Variable("m", "largest stretch of any link, u_right - u_left; NaN without", ("interface",)),
    "peak_link_shortening": Variable("m", "largest shortening of any link; NaN without", ("interface",)),
    "peak_link_spring_force": Variable(
        "N",
        "largest force of the spring of any link, without the dashpot beside it; NaN without spring",
        ("interface",),
    ),
    "link_energy": Variable(
        "J",
        "energy that all links have lost by slipping, breaking and dampers with link_exponent or a brace; NaN without",
        ("interface",),
    ),
    "peak_link_damper_force": Variable(
        "N",
        "largest force of any damper with link_exponent or a brace, without the spring beside it; NaN without",
        ("interface",),
    ),
    "broken_links": Variable("1", "links with a link_breaking_force that have broken; NaN without", ("interface",)),
}
OF_YIELDING = {
    "storey_ductility": Variable("1", "largest drift of the storey over the drift at yield", AT_STOREYS),
    "storey_residual_drift": Variable(
        "m",
        "size of the plastic drift of the storey at the end; with hysteresis of its drift without shear",
        AT_STOREYS,
    ),
}
OF_LAWS = {  # of storeys with hysteresis
    "storey_energy": Variable("J", "energy that the hysteresis of the storey has dissipated", AT_STOREYS),
    "storey_strength_left": Variable(
        "1",
        "strength that energy_capacity, or delta_a and delta_nu, left in the weaker direction over that at first; what "
        "a falling backbone takes is not counted",
        AT_STOREYS,
    ),
    "storey_collapse_time": Variable("s", "time at which the storey collapsed; NaN where it has not", AT_STOREYS),
}
OF_RUNS = {
    "row_impulse": Variable("N s", "impulse of all contacts of the row", ()),
    "row_energy_lost": Variable("J", "energy that all contacts of the row take, by damping and by yielding", ()),
}


class Frame(NamedTuple):
    """What of a row its outputs need beside a run."""

    model: RowModel
    storeys: NDArray[np.int64]  # (buildings, most storeys): the mass above each, −1 where there is none
    yield_drifts: Array  # m, by mass; NaN where a storey stays elastic
    contacts: NDArray[np.int64]  # the points of the model that are contact points
    starts: NDArray[np.int64]  # of these, the first of each interface

    @property
    def sizes(self) -> dict[str, int]:
        """Lengths of the dimensions of the variables."""
        buildings, storeys = self.storeys.shape
        points = len(self.contacts)
        return {"building": buildings, "storey": storeys, "interface": buildings - 1, "contact_point": points}

    @property
    def yields(self) -> bool:
        """True where a storey of the row has a yield strength."""
        return bool(np.isfinite(self.yield_drifts).any())

    def of_links(self) -> list[str]:
        """Those of `OF_LINKS` that the links of the row have: what they lose, and what breaks, where any may."""
        links = self.model.links
        has_dampers = any(link.exponent for link in links)  # of a power law
        known = {
            "link_energy": has_dampers or any(link.law and link.largest < inf for link in links),
            "peak_link_damper_force": has_dampers,
            "broken_links": any(link.breaking < inf for link in links),
        }
        return [name for name in OF_LINKS if known.get(name, bool(links))]

    @property
    def has_laws(self) -> bool:
        """True where a storey of the row has a law of its own."""
        return any(chain.laws.size for chain in self.model.chains)


def frame_of(model: RowModel) -> Frame:
    """The masses of each building's storeys, above the foundation where it has one."""
    counts = [chain.floors for chain in model.chains]
    storeys = np.full((len(counts), max(1, *counts)), -1)
    for building, (chain, count) in enumerate(zip(model.chains, counts, strict=True)):
        storeys[building, :count] = model.firsts[building] + chain.foundations + np.arange(count)
    drifts = np.concatenate([chain.drift_limits() for chain in model.chains])
    contacts = np.flatnonzero(~model.is_link)
    starts = np.searchsorted(model.interfaces[contacts], np.arange(len(model.chains) - 1))
    return Frame(model, storeys, np.where(np.isfinite(drifts), drifts, np.nan), contacts, starts)


def variables(frame: Frame) -> dict[str, Variable]:
    """Names of all variables of a case."""
    gathered = {name: f"; {words}" for name, words in OVER_POINTS.items()}  # how the values of points are put together
    interfaces = {
        name: Variable(output.unit, output.words + gathered.get(name, ""), ("interface",), output.whole)
        for name, output in RUN.items()
    }
    points = {
        f"{POINT}{name}": interfaces[name]._replace(dims=("contact_point",), words=f"{RUN[name].words}; of one point")
        for name in OF_POINTS
    }
    return interfaces | points | OF_RUNS | moving_variables(frame)


def moving_variables(frame: Frame) -> dict[str, Variable]:
    """Those that a row has without contact too."""
    of_links = {name: OF_LINKS[name] for name in frame.of_links()}
    of_laws = OF_LAWS if frame.has_laws else {}
    return OF_BUILDINGS | OF_STOREYS | (OF_YIELDING if frame.yields else {}) | of_laws | of_links


def outputs(run: RowRun, yield_forces: Array, pga: Any, frame: Frame) -> Outputs:
    """Every variable of a case by name, for one run or an array of them; NaN where one failed, −1 in counts and flags.

    ``yield_forces`` [N] is by contact point, ``pga`` [m/s²] what a rigid building feels, of all buildings or of each.
    """
    contact_forces = np.asarray(yield_forces)[..., frame.contacts]
    points = run_outputs(_columns(run, frame), contact_forces)
    lost = points["energy_viscous"] + points["energy_plastic"]
    return {
        **_of_interfaces(run, contact_forces, frame),
        **{f"{POINT}{name}": points[name] for name in OF_POINTS},
        "row_impulse": points["impulse"].sum(axis=-1),
        "row_energy_lost": lost.sum(axis=-1),
        **moving_outputs(run, pga, frame),
    }


def moving_outputs(run: RowRun, pga: Any, frame: Frame) -> Outputs:
    """Values of `moving_variables`, as `outputs` gives those of the others."""
    storeys = {name: _at_storeys(run.floors[..., column], frame, run) for column, name in enumerate(OF_STOREYS)}
    buildings = {
        name: np.fmax.reduce(values, axis=-1) for name, values in zip(OF_BUILDINGS, storeys.values(), strict=True)
    }
    is_rigid = np.asarray(run.status == counters.COMPLETE)[..., None] & (frame.storeys < 0).all(axis=-1)
    buildings["peak_displacement"] = np.where(is_rigid, 0.0, buildings["peak_displacement"])
    # Above isolators storeys may have no springs: the force of these alone is not the largest shear of the building.
    unknown = (np.isnan(storeys["storey_shear"]) & (frame.storeys >= 0)).any(axis=-1)
    buildings["peak_storey_shear"] = np.where(unknown, np.nan, buildings["peak_storey_shear"])
    ground_peak = np.atleast_1d(pga)
    buildings["peak_floor_acceleration"] = np.where(is_rigid, ground_peak, buildings["peak_floor_acceleration"])
    outputs_of_run = buildings | storeys
    if frame.yields:
        outputs_of_run["storey_ductility"] = _at_storeys(run.floors[..., DRIFT] / frame.yield_drifts, frame, run)
        outputs_of_run["storey_residual_drift"] = _at_storeys(np.abs(run.rest[..., PLASTIC]), frame, run)
    if frame.has_laws:
        outputs_of_run["storey_energy"] = _at_storeys(run.rest[..., DISSIPATED], frame, run)
        outputs_of_run["storey_strength_left"] = _at_storeys(run.rest[..., STRENGTH_LEFT], frame, run)
        outputs_of_run["storey_collapse_time"] = _of_storeys(run.rest[..., COLLAPSE_TIME], frame)
    return outputs_of_run | (_of_links(run, frame) if frame.model.links else {})


def _of_links(run: RowRun, frame: Frame) -> Outputs:
    """Values of those of `OF_LINKS` that the row has, (..., interfaces)."""
    model, points = frame.model, np.asarray(run.points)
    names = frame.of_links()
    values = {name: np.full((*points.shape[:-2], len(model.chains) - 1), np.nan) for name in names}
    for link, point in zip(model.links, np.flatnonzero(model.is_link), strict=True):
        stretched, shortened = -points[..., point, LOWEST], points[..., point, HIGHEST]
        lost = points[..., point, counters.PLASTIC]
        peaks = {"peak_link_stretch": stretched, "peak_link_shortening": shortened}
        sums = {}
        if link.stiffness:
            peaks["peak_link_spring_force"] = link.peak_force(stretched, shortened)
        if link.exponent:
            peaks["peak_link_damper_force"] = link.damper_force(points[..., point, counters.APPROACH])
        if link.largest < inf or link.exponent:
            sums["link_energy"] = lost
        if link.breaking < inf:
            # By then it has stored F² / 2k, which is lost; an unbroken one has lost nothing but by rounding.
            sums["broken_links"] = lost * link.stiffness > 0.25 * link.breaking**2
        place = ..., model.interfaces[point]
        for name, peak in peaks.items():
            values[name][place] = np.fmax(values[name][place], peak)
        for name in sums.keys() & values.keys():  # a strength without a spring has no law
            values[name][place] = np.nan_to_num(values[name][place]) + sums[name]
    failed = np.asarray(run.status) != counters.COMPLETE
    return {name: np.where(failed[..., None], np.nan, values[name]) for name in names}


def closing(run: RowRun, frame: Frame) -> tuple[Array, Array]:
    """Largest u_left − u_right by contact point and by interface [m]; the gap that the motion needs."""
    points = run.points[..., frame.contacts, HIGHEST]
    return points, np.maximum.reduceat(points, frame.starts, axis=-1)


def with_bumpers(values: Outputs, frame: Frame) -> Outputs:
    """Outputs whose closings [m] are what is taken up of the gap between the faces: by the motion and by bumpers."""
    bumpers = frame.model.bumpers
    if not bumpers.any():
        return values
    of_points = bumpers[frame.model.interfaces[frame.contacts]]
    taken = {"peak_closing": bumpers, f"{POINT}peak_closing": of_points}
    return values | {name: values[name] + length for name, length in taken.items()}


def _of_interfaces(run: RowRun, yield_forces: Array, frame: Frame) -> Outputs:
    """Every output of `RUN` at every interface; ``yield_forces`` [N] of the contact points."""
    columns, starts = _columns(run, frame), frame.starts
    columns[..., counters.DEMAND] /= yield_forces
    gathered = np.zeros((*columns.shape[:-2], starts.size, COLUMNS))
    for counter_group, gather in GATHERED:
        for counter in counter_group:
            gathered[..., counter] = gather.reduceat(columns[..., counter], starts, axis=-1)
    gathered[..., counters.STATUS] = np.asarray(run.status)[..., None]
    return run_outputs(gathered, np.ones(starts.size))


def _columns(run: RowRun, frame: Frame) -> Array:
    """The contact points' columns as a pair's run has them: counters, then the extremes of the first of its signals."""
    points = np.asarray(run.points)[..., frame.contacts, :]
    columns = np.zeros((*points.shape[:-1], COLUMNS))
    columns[..., : counters.TALLIED] = points[..., : counters.TALLIED]
    columns[..., HIGH], columns[..., LOW] = points[..., HIGHEST], points[..., LOWEST]
    columns[..., counters.STATUS] = np.asarray(run.status)[..., None]
    return columns


def _at_storeys(values: Array, frame: Frame, run: RowRun) -> Array:
    """`_of_storeys`, NaN where the run failed too."""
    failed = np.asarray(run.status)[..., None, None] != counters.COMPLETE
    return np.where(failed, np.nan, _of_storeys(values, frame))


def _of_storeys(values: Array, frame: Frame) -> Array:
    """Values by mass as (..., buildings, storeys), NaN where there is no storey."""
    # A row of rigid buildings has no mass at all; the one added is that of no storey.
    padded = np.concatenate([values, np.full((*values.shape[:-1], 1), np.nan)], axis=-1)
    return padded[..., frame.storeys]
