"""Notes on contacts that are implausible for concrete floors, from a dataset alone. No solver is imported."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from math import inf
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk.models.contact.table import TABULATED, beyond_end
from pounding_risk.results.attributes import unreadable
from pounding_risk.results.layout import blocks, streamed, template_of
from pounding_risk.results.layout import place as place_of_block
from pounding_risk.units import FLOOR_LENGTH, GAP, PERIOD, TIME, USUAL_FLOOR_LENGTH, QuantityError, parse, say

if TYPE_CHECKING:
    import xarray as xr

    from pounding_risk.scene.scene import Scene

Array = NDArray[np.float64]

WALL = 0.11  # s; 0.0488 h^0.75 of one storey of 3 m (ASCE 7-16, equation 12.8-7): stiffer buildings represent walls
LONGEST_CONTACT = 0.5  # of the period of a building, by when its own stiffness reverses it
CRUSHED = 0.0035  # strain at which concrete crushes (EN 1992-1-1, table 3.1, to C50/60)
OF_POINTS = "contact_point_peak_closing"
ANY_LENGTH = FLOOR_LENGTH._replace(open_low=False)
PUSHING = "floors push rather than collide; a stiffness too small?"


def of_scan(dataset: xr.Dataset, scene: Mapping[str, Any]) -> tuple[str, ...]:
    """A sentence for each way in which the contacts of a scan are implausible; ``scene`` are the tables of its scene.

    Raises PoundingError where these tables are damaged.
    """
    try:
        tables = [scene.get(section, []) for section in ("building", "interface")]
        lengths = [parse(table.get("floor_length", "0 m"), ANY_LENGTH) for table in tables[0]]
        tabulated = {place: table for place, table in enumerate(tables[1]) if "table" in table}
        devices = ["table" in table or "bumper_length" in table for table in tables[1]]
    except (AttributeError, TypeError, QuantityError):
        raise unreadable("scene_resolved") from None
    return tuple(_of_contacts(dataset, lengths, tabulated, devices))


def of_run(run: xr.Dataset, study: Scene) -> tuple[str, ...]:
    """A sentence for each way in which the contacts of one run are implausible."""
    lengths = (getattr(building, "floor_length", 0.0) for building in study.buildings)
    devices = [interface.table is not None or bool(interface.bumper_length) for interface in study.interfaces]
    notes = [*_depth_words(*_deepest(run, devices), lengths)]
    interface_of = dict(zip(run["contact_point"].values, run["contact_point_interface"].values, strict=True))
    places = np.array([interface_of[name] for name in run["contact_place"].values])
    for place, sides in enumerate(pairwise(study.buildings)):
        short = shortest({side.name: side.period for side in sides if not side.is_rigid})
        durations = (run["contact_end"] - run["contact_start"]).values[places == place]
        if short and durations.size and (median := float(np.median(durations))) >= LONGEST_CONTACT * short[1]:
            notes.append(f"contacts last {say(median, TIME, 3)}, {share_of(median, *short)}: {PUSHING}")
    model = str(run.attrs.get("contact_model", ""))
    ends = [
        inf if interface.table is None or TABULATED not in (model, interface.contact_model) else interface.table.end
        for interface in study.interfaces
    ]
    depths = _depths(run, "peak_closing").values.tolist()
    notes += [
        _beyond_bumper(depth, length)
        for depth, length, interface in zip(depths, study.bumpers, study.interfaces, strict=False)
        if TABULATED not in (model, interface.contact_model)
    ]
    notes += [beyond_end(depth, end) for depth, end in zip(depths, ends, strict=True)]
    return tuple(filter(None, notes))


def _of_contacts(
    results: xr.Dataset, lengths: list[float], tabulated: dict[int, Any], devices: list[bool]
) -> Iterator[str]:
    """Notes on the deepest contact of a scan, and on contacts that mostly last half of a period.

    ``lengths`` are those of the floors of each building [m], 0 where the scene gives none; ``tabulated`` the tables of
    the interfaces with a table of forces, and ``devices`` says at which interfaces no floors are crushed.
    """
    names = ("peak_closing", "contact_time", "impact_count", "building_period")
    if any(name not in results.variables for name in names) or "interface" not in results.dims:
        return
    # Where the periods differ along an axis, there is no one limit of how long a contact lasts.
    lasting = _LongContacts(results) if results["building_period"].dims == ("building",) else None
    if lasting is not None:
        for piece in streamed(results, names[1:3]):
            lasting.add(piece["contact_time"], piece["impact_count"])
    yield from _depth_words(*_deepest(results, devices), lengths)
    yield from _beyond_tables(results, tabulated)
    yield from _beyond_bumpers(results)
    if lasting is not None:
        yield from lasting.words()


def _depths(results: xr.Dataset, name: str, where: Mapping[str, Any] = MappingProxyType({})) -> xr.DataArray:
    """How much further than the gap the faces close at places of a dataset [m], by one of its peak closings.

    That is all by which they are deformed: `peak_penetration` counts from a gap that permanent indentations widened.
    """
    gaps = results["interface_gap" if "interface_gap" in results.variables else "gap"]
    if name == OF_POINTS and "interface" in gaps.dims:
        gaps = gaps.isel(interface=results["contact_point_interface"].variable)
    closing, gaps = (
        array.isel({dim: index for dim, index in where.items() if dim in array.dims}) for array in (results[name], gaps)
    )
    return closing - gaps  # a drawn gap lies along the samples too


def _beyond_tables(results: xr.Dataset, tabulated: dict[int, Any]) -> Iterator[str]:
    """A note for each interface at which cases go deeper than the last point of its table of forces."""
    if not tabulated or "peak_closing" not in results.variables:
        return
    from pounding_risk.scene.values import OF_EACH_INTERFACE

    for place, interface in tabulated.items():
        labels = (TABULATED, OF_EACH_INTERFACE) if interface["contact_model"] == TABULATED else (TABULATED,)
        laws = [at for at, name in enumerate(results["contact_model"].values) if str(name) in labels]
        if not laws:
            continue
        end, count, deepest = parse(interface["table"]["penetration"][-1], GAP), 0, 0.0
        for at in range(results.sizes["gap"]):
            cell = {"interface": place, "contact_model": laws, "gap": at}
            depth = _depths(results, "peak_closing", cell).values
            count += int((depth > end).sum())
            deepest = max(deepest, float(np.nanmax(depth, initial=0.0)))
        if words := beyond_end(deepest, end):
            yield f"{results['interface'].values[place]}, in {counted(count, 'case')}: {words}"


def _beyond_bumpers(results: xr.Dataset) -> Iterator[str]:
    """A note for each interface at which cases go deeper than its bumpers are long, under laws without a table."""
    if "interface_bumper" not in results.variables or "peak_closing" not in results.variables:
        return
    laws = [k for k, name in enumerate(results["contact_model"].values) if str(name) != TABULATED]
    for place, name in enumerate(results["interface"].values):
        length, count, excess = results["interface_bumper"].isel(interface=place), 0, (0.0, 0.0)
        for gap in range(results.sizes["gap"]):
            depth = _depths(results, "peak_closing", {"interface": place, "contact_model": laws, "gap": gap})
            deep = depth.where((depth > length) & (length > 0.0))
            count += int(deep.notnull().sum())
            if deep.notnull().any():  # samples have each its own length
                lengths, k = length.broadcast_like(deep).transpose(*deep.dims).values, int(np.nanargmax(deep.values))
                excess = max(excess, (float(deep.values.flat[k]), float(lengths.flat[k])))
        if count:
            yield f"{name}, in {counted(count, 'case')}: {_beyond_bumper(*excess)}"


def _beyond_bumper(depth: float, length: float) -> str:
    """A sentence where a penetration is more than the bumpers are long [m]; "" elsewhere."""
    if not depth > length or not length:
        return ""
    return (
        f"the penetration of {say(depth, GAP, 3)} is more than the bumpers are long, {say(length, GAP, 3)}: where they "
        "are solid faces meet faces, which only a table of forces that goes on with the stiffness of the faces says"
    )


def _deepest(results: xr.Dataset, devices: Sequence[bool]) -> tuple[float, float]:
    """Largest deformation of floors, or masses, and of a column by a floor [m]; 0 where there is none.

    Interfaces with ``devices``, tables of forces or bumpers, count for columns alone; one value stands for all.
    """
    has_points = OF_POINTS in results.variables and "contact_point_kind" in results.variables
    name, axis = (OF_POINTS, "contact_point") if has_points else ("peak_closing", "interface")
    places = np.atleast_1d(results["contact_point_interface"].values if has_points else np.arange(results.sizes[axis]))
    is_column = np.atleast_1d(results["contact_point_kind"].values == "column") if has_points else places < 0
    is_floor = ~is_column & ~np.array(devices or [False])[np.minimum(places, max(len(devices) - 1, 0))]
    floors, columns = 0.0, 0.0
    template = template_of(results)
    for cell in [place_of_block(template, block) for block in blocks(template)] if name in template.cases else [{}]:
        depths = _depths(results, name, cell).transpose(..., axis).values
        floors = max(floors, float(np.nanmax(depths[..., is_floor], initial=0.0)))
        columns = max(columns, float(np.nanmax(depths[..., is_column], initial=0.0)))
    return floors, columns


def _depth_words(depth: float, in_column: float, lengths: Iterable[float]) -> Iterator[str]:
    """Notes on penetrations above that which crushes the two longest floors through their whole length."""
    longest = sorted((length or USUAL_FLOOR_LENGTH for length in lengths), reverse=True)[:2] or [USUAL_FLOOR_LENGTH] * 2
    limit = CRUSHED * sum(longest)
    floors = " and ".join(f"{length:g} m" for length in longest)
    if depth > limit:
        yield (
            f"the deepest contact has a penetration of {say(depth, GAP, 3)}; from {say(limit, GAP, 3)} on, floors of "
            f"{floors} are crushed through their whole length (strain {CRUSHED:g}, EN 1992-1-1, table 3.1); a "
            "stiffness too small, or F_E too low for these masses and speeds?"
        )
    if in_column > limit:
        yield (
            f"a floor deflects a column of its neighbour by up to {say(in_column, GAP, 3)}, and no deflection ends the "
            "resistance of a column in the model: count it as failed, with the floors that it carries"
        )


class _LongContacts:
    """Counts, by interface, the cases whose contacts last half of a period on average."""

    def __init__(self, results: xr.Dataset) -> None:
        names = [str(name) for name in results["building"].values]
        periods = dict(zip(names, map(float, results["building_period"].values), strict=True))
        self.shortest = [shortest({name: periods[name] for name in pair}) for pair in pairwise(names)]
        self.limits = np.array([LONGEST_CONTACT * short[1] if short else inf for short in self.shortest])
        self.long: Any = np.zeros(self.limits.size, dtype=int)
        self.touching: Any = np.zeros(self.limits.size, dtype=int)

    def add(self, time: Array, count: NDArray[np.int64]) -> None:
        """Count a block of cases; the last axis is that of interfaces."""
        is_touching = (count > 0) & (time > 0.0)
        is_long = is_touching & (time >= self.limits * np.maximum(count, 1))  # no limit times no contact is no number
        case_axes = tuple(range(is_touching.ndim - 1))
        self.touching = self.touching + is_touching.sum(axis=case_axes)
        self.long = self.long + is_long.sum(axis=case_axes)

    def words(self) -> Iterator[str]:
        """A note for each interface at which more than half of the cases with contact are such."""
        for long, touching, building in zip(self.long, self.touching, self.shortest, strict=True):
            if building and 2 * long > touching:
                name, period = building
                yield (
                    f"in {long} of {touching} cases with contact one lasts {LONGEST_CONTACT:g} times the period of "
                    f"{name} ({say(period, PERIOD)}) or more on average: {PUSHING}"
                )


def shortest(periods: Mapping[str, float]) -> tuple[str, float] | None:
    """Name and period [s] of the building of the shortest period that is not a wall; None where all are walls."""
    swinging = {name: period for name, period in periods.items() if period >= WALL}
    return min(swinging.items(), key=lambda building: building[1]) if swinging else None


def share_of(duration: float, name: str, period: float) -> str:
    """The duration of a contact [s] as a multiple of the period [s] of the building ``name``, in words."""
    return f"{duration / period:.3g} times the period of {name} ({say(period, PERIOD)})"
