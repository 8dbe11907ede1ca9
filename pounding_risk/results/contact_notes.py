"""Notes on what contacts did and concrete floors do not do, from a dataset alone: no solver is needed."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pounding_risk.errors import PoundingError
from pounding_risk.results.files import told
from pounding_risk.results.layout import streamed
from pounding_risk.units import FLOOR_LENGTH, GAP, PERIOD, TIME, QuantityError, parse, say

if TYPE_CHECKING:
    import xarray as xr

    from pounding_risk.scene.scene import Study

Array = NDArray[np.float64]

WALL = 0.11  # s; 0.0488 h^0.75 of one storey of 3 m (ASCE 7-16, equation 12.8-7): what is stiffer stands for a wall
LONGEST_CONTACT = 0.5  # of a building's period: by then its own spring has turned it round
CRUSHED = 0.0035  # strain at which concrete crushes (EN 1992-1-1, table 3.1, to C50/60)
USUAL_FLOOR = 15.0  # m, of a floor whose length is not given
PUSHING = "floors push rather than collide; a stiffness too small?"


def of_results(results: xr.Dataset) -> tuple[str, ...]:
    """A sentence for each thing that contacts of a scan did and concrete floors do not, after those on its input.

    Raises PoundingError where the attributes with the latter, or with the scene, are damaged.
    """
    kept = told(results, "notes", [])
    if not isinstance(kept, list):
        raise _damaged("notes")
    return (*map(str, kept), *_of_contacts(results))


def _damaged(attribute: str) -> PoundingError:
    return PoundingError(
        f'the attribute "{attribute}" of the results cannot be read: the file was changed since; run the scan again'
    )


def of_run(run: xr.Dataset, study: Study) -> tuple[str, ...]:
    """A sentence for each thing that contacts of one run did and concrete floors do not."""
    lengths = (getattr(building, "floor_length", 0.0) for building in study.buildings)
    if "interface" in run.dims:
        depth, lasting = run["peak_penetration"].values, _durations(run)
    else:
        depth = run["contact_peak_penetration"].values
        lasting = [(run["contact_end"] - run["contact_start"]).values]
    found = [_depth_words(float(np.nanmax(depth, initial=0.0)), lengths)]
    for sides, each in zip(pairwise(study.buildings), lasting, strict=True):
        short = shortest({building.name: building.period for building in sides if not building.is_rigid})
        if short and each.size and (middle := float(np.median(each))) >= LONGEST_CONTACT * short[1]:
            found.append(f"contacts last {say(middle, TIME, 3)}, {share_of(middle, *short)}: {PUSHING}")
    return tuple(filter(None, found))


def _durations(run: xr.Dataset) -> list[Array]:
    """The mean duration of the contacts of a row's run [s], interface by interface; empty where there is none."""
    times, counts = run["contact_time"].values, run["impact_count"].values
    return [np.array([time / count]) if count > 0 else np.empty(0) for time, count in zip(times, counts, strict=True)]


def _of_contacts(results: xr.Dataset) -> Iterator[str]:
    """On the deepest contact of a scan, and on contacts that mostly last half of a period."""
    names = ("peak_penetration", "contact_time", "impact_count", "building_period")
    of_row = "interface" in results.dims
    if any(name not in results.variables for name in names) or not (of_row or results["building"].size == 2):
        return
    depth, lasting = 0.0, _Lasting(results)
    for piece in streamed(results, names[:3]):
        depth = max(depth, float(np.nanmax(piece["peak_penetration"], initial=0.0)))
        lasting.add(piece["contact_time"], piece["impact_count"])
    if words := _depth_words(depth, _floor_lengths(results)):
        yield words
    yield from lasting.words()


def _floor_lengths(results: xr.Dataset) -> list[float]:
    """The length of each building's floors as its scene gives it [m]; 0 where it gives none."""
    try:
        tables = tomllib.loads(results.attrs.get("scene_resolved", "")).get("building", [])
        return [parse(table.get("floor_length", "0 m"), FLOOR_LENGTH._replace(open_low=False)) for table in tables]
    except (tomllib.TOMLDecodeError, AttributeError, TypeError, QuantityError):
        raise _damaged("scene_resolved") from None


def _depth_words(depth: float, lengths: Iterable[float]) -> str:
    """On a penetration that crushes the two longest floors through their whole length; "" for a smaller one."""
    longest = sorted((length or USUAL_FLOOR for length in lengths), reverse=True)[:2] or [USUAL_FLOOR] * 2
    limit = CRUSHED * sum(longest)
    if not depth > limit:
        return ""
    floors = " and ".join(f"{length:g} m" for length in longest)
    return (
        f"the deepest contact has a penetration of {say(depth, GAP, 3)}, more than {say(limit, GAP, 3)}, which crushes "
        f"floors of {floors} through their whole length (strain {CRUSHED:g}, EN 1992-1-1, table 3.1); a stiffness too "
        "small, or F_E too low for these masses and speeds?"
    )


class _Lasting:
    """How many cases have contacts that last half of a period on average, interface by interface."""

    def __init__(self, results: xr.Dataset) -> None:
        names = [str(name) for name in results["building"].values]
        periods = dict(zip(names, map(float, results["building_period"].values), strict=True))
        sides = list(pairwise(names)) if "interface" in results.dims else [(names[0], names[-1])]
        self.shortest = [shortest({name: periods[name] for name in pair}) for pair in sides]
        limits = [LONGEST_CONTACT * short[1] if short else inf for short in self.shortest]
        self.limits = np.array(limits) if "interface" in results.dims else limits[0]
        self.long: Any = np.zeros(len(limits), dtype=int)
        self.touching: Any = np.zeros(len(limits), dtype=int)

    def add(self, time: Array, count: NDArray[np.int64]) -> None:
        """Count a piece; the last axis is that of interfaces, where there is one."""
        touching = (count > 0) & (time > 0.0)
        long = touching & (time >= self.limits * count)
        over = tuple(range(touching.ndim - (np.ndim(self.limits) > 0)))
        self.touching = self.touching + touching.sum(axis=over)
        self.long = self.long + long.sum(axis=over)

    def words(self) -> Iterator[str]:
        """Where more than half of the cases with contact are such."""
        for long, touching, short in zip(self.long, self.touching, self.shortest, strict=True):
            if short and 2 * long > touching:
                name, period = short
                yield (
                    f"in {long} of {touching} cases with contact one lasts {LONGEST_CONTACT:g} times the period of "
                    f"{name} ({say(period, PERIOD)}) or more on average: {PUSHING}"
                )


def shortest(periods: Mapping[str, float]) -> tuple[str, float] | None:
    """The building of the shortest period [s] that does not stand for a wall; None where all do."""
    swinging = {name: period for name, period in periods.items() if period >= WALL}
    return min(swinging.items(), key=lambda item: item[1]) if swinging else None


def share_of(lasts: float, name: str, period: float) -> str:
    """How much of the period of the building ``name`` [s] a contact lasts [s], in words."""
    return f"{lasts / period:.2g} times the period of {name} ({say(period, PERIOD)})"
