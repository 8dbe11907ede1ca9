"""Notes on numbers that are possible but unusual, with the slip that makes them: of the input and of the contacts.

Never a refusal. `USUAL` has the ranges of the input; `of_input` holds a scene and its motions against them, and
`of_results` and `of_run` are on what contacts did.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import pairwise
from math import inf, isfinite, pi, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.layout import streamed
from pounding_risk.models.contact import LINEAR_STIFFNESS, stiffness_quantity
from pounding_risk.models.instant import is_instant
from pounding_risk.quantities import (
    FLOOR_LENGTH,
    FLOOR_MASS,
    GAP,
    PERIOD,
    PGA,
    STANDARD_GRAVITY,
    TIME,
    Quantity,
    parse,
    say,
)
from pounding_risk.results import told
from pounding_risk.study import Study, known_law

if TYPE_CHECKING:
    import xarray as xr

    from pounding_risk.motions import Motion

Array = NDArray[np.float64]


class Usual(NamedTuple):
    """A usual range in SI, where it is from, and the slip that most likely made a number below or above it."""

    quantity: Quantity
    low: float
    high: float
    source: str
    below: str
    above: str


USUAL = {
    "mass of a floor": Usual(
        FLOOR_MASS,
        5e3,
        5e7,
        "a floor of 20 m² at 250 kg/m², and a tower of 50 000 t as one mass",
        "kg written for t?",
        "t written for kg?",
    ),
    # Shorter periods stand for a wall, as 0.007 s of the masonry in Khatiwada et al. (2011), and are no slip.
    "period": Usual(
        PERIOD,
        0.0,
        12.1,
        "0.0724 h^0.8 for a steel frame of h = 600 m (ASCE 7-16, equation 12.8-7)",
        "",
        "a decimal point lost, or ms written as s?",
    ),
    "gap": Usual(
        GAP, 0.0, 2.0, "two buildings of 50 m that lean by 2 % towards each other", "", "m written for mm or cm?"
    ),
    "PGA as recorded": Usual(
        PGA,
        0.039 * STANDARD_GRAVITY,
        2.0 * STANDARD_GRAVITY,
        "0.039 g is the least of intensity V (Wald et al. 1999, table 1), and few records exceed 2 g",
        "cm/s² read as mm/s², or a weak record?",
        "m/s² read as g?",
    ),
    "PGA asked for": Usual(PGA, 0.0, 2.0 * STANDARD_GRAVITY, "few records exceed 2 g", "", "m/s² or % written as g?"),
}
WALL = 0.11  # s; 0.0488 h^0.75 of one storey of 3 m (ASCE 7-16, equation 12.8-7): what is stiffer stands for a wall
SPEED = 0.5  # m/s, of a usual approach; the time of a Hertz contact goes with its power −0.2
# Twice the way of sound through 1.75 m of concrete at 3500 m/s: no floor parts sooner.
SHORTEST_CONTACT = 1e-3  # s
LONGEST_CONTACT = 0.5  # of a building's period: by then its own spring has turned it round
CRUSHED = 0.0035  # strain at which concrete crushes (EN 1992-1-1, table 3.1, to C50/60)
USUAL_FLOOR = 15.0  # m, of a floor whose length is not given
HERTZ_TIME = 3.2181  # 2 ∫ ds / √(1 − s^(5/2)) (5/4)^(2/5) from 0 to 1: t = 3.2181 (m v²/β)^(2/5) / v
PUSHING = "floors push rather than collide; a stiffness too small?"
UNIT_CHECKED = "check the unit"  # ends the flag of a motion whose unit another check doubts


def of_input(study: Study, motions: Iterable[Motion]) -> tuple[str, ...]:
    """A sentence for each unusual number of a scene and of its motions.

    Parameters
    ----------
    study : Study
        The scene.
    motions : iterable of Motion
        Its motions, before polarity and the grid's amplitudes.

    Returns
    -------
    tuple of str
        Which number, the usual range with its source, and the likely slip.
    """
    return (*_of_buildings(study), *_of_gaps(study), *_of_stiffnesses(study), *_of_motions(study, tuple(motions)))


def of_results(results: xr.Dataset) -> tuple[str, ...]:
    """A sentence for each thing that contacts of a scan did and concrete floors do not, after those on its input.

    Raises PoundingError where the attribute with the latter is damaged.
    """
    return (*map(str, told(results, "notes", [])), *_of_contacts(results))


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
        short = _shortest({building.name: building.period for building in sides if not building.is_rigid})
        if short and each.size and (middle := float(np.median(each))) >= LONGEST_CONTACT * short[1]:
            found.append(f"contacts last {say(middle, TIME, 3)}, {_share_of(middle, *short)}: {PUSHING}")
    return tuple(filter(None, found))


def _durations(run: xr.Dataset) -> list[Array]:
    """The mean duration of the contacts of a row's run [s], interface by interface; empty where there is none."""
    times, counts = run["contact_time"].values, run["impact_count"].values
    return [np.array([time / count]) if count > 0 else np.empty(0) for time, count in zip(times, counts, strict=True)]


# --- the input --------------------------------------------------------------------------------------------


def _unusual(what: str, values: Mapping[str, float]) -> Iterator[str]:
    """A sentence for each value, by the words for it, outside the range of `USUAL`."""
    usual = USUAL[what]
    for whose, value in values.items():
        if not isfinite(value) or usual.low <= value <= usual.high:
            continue
        limit, side, slip = (usual.low, "more", usual.below) if value < usual.low else (usual.high, "less", usual.above)
        words = f"{say(value, usual.quantity)}, usually {say(limit, usual.quantity)} or {side}"
        yield f"{whose}: {what} {words} ({usual.source}); {slip}"


def _of_buildings(study: Study) -> Iterator[str]:
    moving = [building for building in study.buildings if not building.is_rigid]
    for building in moving:
        masses = getattr(building, "masses", None) or (building.mass,)
        for mass in dict.fromkeys((min(masses), max(masses))):
            yield from _unusual("mass of a floor", {building.name: mass})
    yield from _unusual("period", {building.name: building.period for building in moving})


def _of_gaps(study: Study) -> Iterator[str]:
    own = [neighbour.gap for neighbour in study.neighbours] or [study.gap]
    yield from _unusual("gap", dict(zip(study.interfaces, own, strict=True)))
    yield from _unusual("gap", {"grid.gap": max(study.grid.gaps)} if max(study.grid.gaps) > max(own) else {})


def _of_stiffnesses(study: Study) -> Iterator[str]:
    """Contact durations that the stiffness of each interface leads to."""
    if all(is_instant(known_law(name)) for name in study.grid.contact_models):
        return
    for place, name in enumerate(study.interfaces):
        here = study.at(place)
        if here.stiffness is None:
            continue
        quantity = stiffness_quantity(known_law(here.stiff_name))
        lasts = contact_duration(here.stiffness, quantity.unit, here.striking_mass)
        words = (
            f"{name}: a stiffness of {say(here.stiffness, quantity)} makes a contact at {SPEED:g} m/s last "
            f"{say(lasts, TIME, 3)}"
        )
        periods = {building.name: building.period for building in here.buildings if not building.is_rigid}
        short = _shortest(periods)
        if short and lasts >= LONGEST_CONTACT * short[1]:
            unit = quantity.unit
            yield f"{words}, {_share_of(lasts, *short)}: that is no blow; {unit} written for k{unit} or M{unit}?"
        elif lasts < SHORTEST_CONTACT:
            yield (
                f"{words}, less than {1e3 * SHORTEST_CONTACT:g} ms, in which sound crosses 1.75 m of concrete twice; "
                f"k{quantity.unit} written for {quantity.unit}?"
            )


def contact_duration(stiffness: float, unit: str, mass: float, speed: float = SPEED) -> float:
    """How long two masses touch that meet without damping and without yielding [s].

    Parameters
    ----------
    stiffness : float
        k [N/m] of F = k δ: t = π √(m/k), half of a period; or β [N/m^1.5] of F = β δ^1.5: t = 3.2181 (m v²/β)^(2/5) / v
        (Goldsmith 1960, Impact, section 4.2, after Hertz).
    unit : str
        "N/m" or "N/m^1.5".
    mass : float
        m1 m2 / (m1 + m2) [kg].
    speed : float
        Of the approach [m/s].

    Returns
    -------
    float
        The time from touch to parting [s]; damping changes it by 2 % at most.

    Examples
    --------
    >>> round(contact_duration(4.0, "N/m", 1.0), 4)
    1.5708
    """
    if unit == LINEAR_STIFFNESS.unit:
        return pi * sqrt(mass / stiffness)
    return float(HERTZ_TIME * (mass * speed**2 / stiffness) ** 0.4 / speed)


def _of_motions(study: Study, motions: tuple[Motion, ...]) -> Iterator[str]:
    """Peaks of motions that keep the amplitude of their files, and amplitudes that are asked for."""
    request = study.records
    amplitudes = [pga for pga in (*study.grid.pgas, request.pga) if pga is not None]
    if amplitudes:
        yield from _unusual("PGA asked for", {"the scene": max(amplitudes)})
        return
    if any(motion.record.get("factor", 1.0) != 1.0 for motion in motions):
        return
    usual = USUAL["PGA as recorded"]
    for outside, most in ((_below(usual.low), min), (_above(usual.high), max)):
        unusual = {motion.name: motion.pga for motion in motions if outside(motion.pga) and not _doubted(motion)}
        if unusual:
            name = most(unusual, key=unusual.__getitem__)
            others = f" and {len(unusual) - 1} more" if len(unusual) > 1 else ""
            yield from _unusual("PGA as recorded", {f"{name}{others}": unusual[name]})


def _below(limit: float) -> Callable[[float], bool]:
    return lambda value: value < limit


def _above(limit: float) -> Callable[[float], bool]:
    return lambda value: value > limit


def _doubted(motion: Motion) -> bool:
    """True where a flag of the motion doubts its unit already."""
    return any(flag.endswith(UNIT_CHECKED) for flag in motion.flags)


# --- contacts ---------------------------------------------------------------------------------------------


def _of_contacts(results: xr.Dataset) -> Iterator[str]:
    """On the deepest contact of a scan, and on contacts that mostly last half of a period."""
    names = ("peak_penetration", "contact_time", "impact_count", "building_period")
    if any(name not in results.variables for name in names):
        return
    depth, lasting = 0.0, _Lasting(results)
    for piece in streamed(results, names[:3]):
        depth = max(depth, float(np.nanmax(piece["peak_penetration"], initial=0.0)))
        lasting.add(piece["contact_time"], piece["impact_count"])
    tables = tomllib.loads(results.attrs.get("scene_resolved", "")).get("building", [])
    if words := _depth_words(depth, (_floor_length(table) for table in tables)):
        yield words
    yield from lasting.words()


def _floor_length(table: Mapping[str, Any]) -> float:
    return parse(table["floor_length"], FLOOR_LENGTH) if "floor_length" in table else 0.0


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
        self.shortest = [_shortest({name: periods[name] for name in pair}) for pair in sides]
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
                    f"in {long} of {touching} cases with contact one lasts {LONGEST_CONTACT:g} of the period of {name} "
                    f"({say(period, PERIOD)}) or more on average: {PUSHING}"
                )


def _shortest(periods: Mapping[str, float]) -> tuple[str, float] | None:
    """The building of the shortest period [s] that does not stand for a wall; None where all do."""
    swinging = {name: period for name, period in periods.items() if period >= WALL}
    return min(swinging.items(), key=lambda item: item[1]) if swinging else None


def _share_of(lasts: float, name: str, period: float) -> str:
    return f"{lasts / period:.2g} of the period of {name} ({say(period, PERIOD)})"
