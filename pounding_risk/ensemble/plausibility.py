"""Notes on numbers of a scene that are possible but unusual, with the mistake that most likely caused them.

Nothing is refused. `USUAL` has the ranges, `of_input` compares a scene and its motions with them. Notes on computed
contacts are in `results.contact_notes`.
"""

from __future__ import annotations

import re
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from math import ceil, exp, floor, inf, isfinite, isnan, log, log10, nan, pi, sqrt
from operator import add, itemgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.models.contact.impulsive import is_instant
from pounding_risk.models.contact.laws import LINEAR_STIFFNESS, stiffness_quantity
from pounding_risk.models.contact.table import TABULATED
from pounding_risk.models.ground import SHARED
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.motions.levels import PEAK, Level, driven
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.record import AFTERSHOCK, BESIDE, GENERATED, recordings_within, site_of
from pounding_risk.motions.request import AS_RECORDED
from pounding_risk.results.contact_notes import LONGEST_CONTACT, share_of, shortest
from pounding_risk.scene.ground_motion import parting
from pounding_risk.scene.interfaces import known_law
from pounding_risk.scene.known_motions import has_known_motion, known_motion_notes
from pounding_risk.scene.scene import Scene
from pounding_risk.scene.values import Axes
from pounding_risk.scene.variants import Variants
from pounding_risk.units import (
    DAMPING,
    FLOOR_MASS,
    GAP,
    PERIOD,
    PGA,
    RESTITUTION,
    STANDARD_GRAVITY,
    STOREY_HEIGHT,
    TIME,
    Quantity,
    say,
)

SHARE_OF_WEIGHT = Quantity("1", 0.0, float("inf"), "strength over weight")


class Usual(NamedTuple):
    """A usual range in SI, its source, and the most likely mistake for a number below it, and above."""

    quantity: Quantity
    range: tuple[float, float]
    source: str
    slips: tuple[str, str]


USUAL = {
    "mass of a floor": Usual(
        FLOOR_MASS,
        (5e3, 5e7),
        "a floor of 20 m² at 250 kg/m², and a tower of 50 000 t as one mass",
        ("kg written for t?", "t written for kg?"),
    ),
    # Shorter periods represent walls, such as 0.007 s of the masonry in Khatiwada et al. (2011), and are no mistake.
    "period": Usual(
        PERIOD,
        (0.0, 12.1),
        "0.0724 h^0.8 for a steel frame of h = 600 m (ASCE 7-16, equation 12.8-7)",
        ("", "a decimal point lost, or ms written as s?"),
    ),
    "storey height": Usual(
        STOREY_HEIGHT,
        (0.5, 15.0),
        "from below the slab of an isolated building to a hall",
        ("mm or cm written for m?", "a decimal point lost?"),
    ),
    "strength of a storey over the weight above": Usual(
        SHARE_OF_WEIGHT,
        (0.005, 10.0),
        "half a percent of the weight is less than any code's base shear, ten times it more than walls hold",
        ("kN written for MN, or N for kN?", "MN written for kN?"),
    ),
    "strength of the isolators over the weight on them": Usual(
        SHARE_OF_WEIGHT,
        (0.005, 0.3),
        "lead-rubber bearings have 0.03 to 0.15, sliders 0.2 at most",
        ("kN written for MN, or N for kN?", "MN written for kN, or kg for t?"),
    ),
    "period while the isolators yield": Usual(
        PERIOD,
        (0.7, 12.1),
        "isolated buildings have 1.5 s to 6 s, models on shaking tables half of it",
        ("stiffness or mass in another unit?", "kN/m written for MN/m, or a radius in mm?"),
    ),
    "yield displacement of the isolators": Usual(
        GAP, (0.0, 0.1), "lead-rubber bearings have 5 mm to 25 mm, sliders less", ("", "m written for mm?")
    ),
    "damping": Usual(
        DAMPING, (0.0, 0.2), "buildings have 0.5 % to 10 %, more with dampers", ("", "% written as a share?")
    ),
    "restitution": Usual(
        RESTITUTION,
        (0.1, 1.0),
        "0.4 to 0.8 of concrete, by its speed",
        ("a decimal point lost, or a damping ratio?", ""),
    ),
    "gap": Usual(
        GAP, (0.0, 2.0), "two buildings of 50 m that lean by 2 % towards each other", ("", "m written for mm or cm?")
    ),
    "PGA as recorded": Usual(
        PGA,
        (0.039 * STANDARD_GRAVITY, 2.0 * STANDARD_GRAVITY),
        "0.039 g is the least of intensity V (Wald et al. 1999, table 1), and few records exceed 2 g",
        ("cm/s² read as mm/s², or a weak record?", "m/s² read as g?"),
    ),
    "PGA after scaling": Usual(PGA, (0.0, 2.0 * STANDARD_GRAVITY), "few records exceed 2 g", ("", "levels too high?")),
    "PGA asked for": Usual(
        PGA, (0.0, 2.0 * STANDARD_GRAVITY), "few records exceed 2 g", ("", "m/s² or % written as g?")
    ),
}
# Of the periods of steel frames, 0.0724 h^0.8 with the height in m (ASCE 7-16, equation 12.8-7): a wall, and a building
# that is much softer than any frame.
PERIODS_OF_HEIGHT = 0.05, 5.0
OF_MASS = ("mass", "period")
SAME_HEIGHT = 1e-9  # of it: rounding of sums of storey heights
SAME_PERIOD = 1e-9  # of it: rounding of the stiffnesses that are made from it
SPEED = 0.5  # m/s, a usual approach speed; the duration of a Hertz contact varies with its power −0.2
SHARE_OF_PERIOD = 0.1  # of the shorter period that a contact may last: the rule of `advise`
# The time in which sound crosses 1.75 m of concrete twice at 3500 m/s: no floors separate sooner.
SHORTEST_CONTACT = 1e-3  # s
STIFFEST = 1e12  # N/m^1.5, 36 times the typical value of OpenSees' Impact Material
HERTZ_TIME = 3.2181  # 2 ∫ ds / √(1 − s^(5/2)) (5/4)^(2/5) from 0 to 1: t = 3.2181 (m v²/β)^(2/5) / v
LEFT_OF_PAUSE = 0.05  # of the amplitude before the aftershock: ten periods at 5 % leave 4 %
NUMBER = re.compile(r"(?<![\w.^,-])(\d+(?:,\d{3})*(?:\.\d+)?(?:e[-+]?\d+)?)(?!\w)")  # of a sentence, alone
HIDDEN_DIGITS = {ord(str(digit)): 0xE000 + digit for digit in range(10)}  # private letters
SHOWN_DIGITS = {hidden: digit for digit, hidden in HIDDEN_DIGITS.items()}
UNIT_CHECKED = "check the unit"  # ends the flag of a motion whose unit another check questions


def of_input(study: Scene, motions: Iterable[Motion]) -> tuple[str, ...]:
    """A sentence on the site of the motions of a scene, and one for each unusual number of both.

    It has the number, the usual range with its source, and the likely mistake. The motions are those before polarity
    and the grid's amplitudes.
    """
    all_motions = tuple(motions)
    sites = dict.fromkeys(filter(None, (site_of(motion.record) for motion in all_motions)))
    stiffness_notes = () if has_known_motion(study) else _stiffness_notes(study)  # no contact is run
    gap_notes = *_missing_height_notes(study), *_gap_notes(study), *_lower_building_notes(study)
    scene_notes = *_building_notes(study), *gap_notes, *stiffness_notes, *_restitution_notes(study), *_link_notes(study)
    motion_notes = (
        *_motion_notes(study, all_motions),
        *_own_record_notes(study, all_motions),
        *_ground_notes(study, all_motions),
    )
    return (
        *(f"the motions are those of {site}" for site in sites),
        *scene_notes,
        *motion_notes,
        *known_motion_notes(study, all_motions),
    )


def notes_along(study: Scene, motions: tuple[Motion, ...]) -> tuple[str, ...]:
    """A sentence for each unusual number of a scene, of its axes, and of its motions."""
    scenes = list(Variants(study).alone()) if study.axes else [study]
    drawn = () if study.uncertain is None else study.uncertain.notes()
    notes = with_ranges((note for scene in scenes for note in of_input(scene, motions)), study)
    masses, periods = (
        np.array([[getattr(building, name) for building in scene.buildings] for scene in scenes]) for name in OF_MASS
    )
    return (*drawn, *of_varied_masses(study.buildings, masses, periods), *notes)


def of_varied_masses(buildings: Sequence[Any], masses: NDArray[Any], periods: NDArray[Any]) -> Iterator[str]:
    """A sentence for each building whose mass varies and whose period stays.

    Masses [kg] and periods [s], 0 of a rigid building, are (scenes, buildings).
    """
    for building, mass, period in zip(buildings, masses.T, periods.T, strict=True):
        if (mass == mass[0]).all() or np.ptp(period) >= SAME_PERIOD * period.max():
            continue
        if getattr(building, "mass_matrix", ()):
            sentence = "floor_masses vary the load of the ground motion alone; its mass_matrix and periods stay"
        else:
            sentence = (
                "its mass varies and its period stays, so that its stiffness varies as its mass; write its stiffness "
                "in place of period where that is what stays"
            )
        yield f"{building.name}: {sentence}"


def with_ranges(notes: Iterable[str], study: Scene) -> list[str]:
    """Notes of the places along a scene's axes; those that differ in numbers alone become one note.

    It has a range, "0.03 to 0.05", in place of a number that differs. Names of buildings may have digits.
    """
    groups: dict[tuple[str, ...], list[list[str]]] = {}
    for note in dict.fromkeys(notes):
        subject, colon, words = note.partition(": ")
        for building in study.buildings:
            whole_name = rf"(?<![\w.,+-]){re.escape(building.name)}(?!\w|[.,]\d)"  # "1" is no digit of 0.31
            words = re.sub(whole_name, lambda name: name[0].translate(HIDDEN_DIGITS), words)
        first, *pairs = NUMBER.split(words)
        groups.setdefault((subject + colon + first, *pairs[1::2]), []).append(pairs[::2])
    merged = []
    for (first, *texts), rows in groups.items():
        columns = [sorted(set(column), key=_number_value) for column in zip(*rows, strict=True)]
        ranges = [" to ".join(dict.fromkeys((column[0], column[-1]))) for column in columns]
        merged.append(first + "".join(map(add, ranges, texts)))
    return [words.translate(SHOWN_DIGITS) for words in merged]


def _number_value(number: str) -> float:
    """The value of a number of `NUMBER`, which may have commas between thousands."""
    return float(number.replace(",", ""))


# --- the input --------------------------------------------------------------------------------------------


def _unusual_notes(name: str, numbers: Mapping[str, float]) -> Iterator[str]:
    """A sentence for each value, given with its name, outside the range of `USUAL`."""
    usual = USUAL[name]
    for subject, number in numbers.items():
        low, high = usual.range
        if not isfinite(number) or low <= number <= high:
            continue
        limit, side, slip = (low, "more", usual.slips[0]) if number < low else (high, "less", usual.slips[1])
        words = f"{say(number, usual.quantity)}, usually {say(limit, usual.quantity)} or {side}"
        yield f"{subject}: {name} {words} ({usual.source}); {slip}"


def _building_notes(study: Scene) -> Iterator[str]:
    moving = [building for building in study.buildings if not building.is_rigid]
    if "soil_flexibility" in dict(study.effects):
        yield "soil_flexibility: foundations sway and do not rock, which would move roofs further; gaps may need more"
    for building in moving:
        masses = getattr(building, "masses", None) or (building.mass,)
        for mass in dict.fromkeys((min(masses), max(masses))):
            yield from _unusual_notes("mass of a floor", {building.name: mass})
        yield from _storey_notes(building)
        yield from _isolator_notes(building)
        yield from _condensation_notes(building)
        if _is_upside_down(building):
            yield (
                f"{building.name}: in its first mode floor 1 moves most and the roof least, as where modes or matrices "
                "are given from the roof down; a scene has them from the lowest floor up"
            )
        if _is_part(building):
            yield (
                f"{building.name}: storey shears are those of storey_stiffnesses, a part of its matrix; the rest "
                "carries more"
            )
        plans = getattr(building, "plans", ())
        if plans and not plans[0].moves_across:
            yield (
                f"{building.name}: only ground motion along the row turns its floors; that across it does too where "
                "the centre of stiffness is off along the row, which eccentricity_along of its plan states"
            )
    yield from _unusual_notes("period", {building.name: building.period for building in moving})
    yield from _unusual_notes("damping", {building.name: building.damping for building in moving})


def _is_upside_down(building: Any) -> bool:
    """True where the floors of a matrix move less in the first mode the higher they stand, as of no building."""
    if getattr(building, "plans", ()) or not getattr(building, "stiffness_matrix", ()):
        return False
    above = building.superstructure()
    shape = np.abs(above.vibration().shapes[: len(above.masses), 0])
    return bool(shape.argmax() == 0 and shape.argmin() == shape.size - 1 > 0)


def _is_part(building: Any) -> bool:
    """True where storeys that may yield are a part of the matrix that joins the floors of a building."""
    return bool(getattr(building, "strengths", ()) and getattr(building, "stiffness_matrix", ()))


def _storey_notes(building: Any) -> Iterator[str]:
    """Notes on heights and strengths of storeys, and on the period beside the height; isolators are left out."""
    heights, strengths = (getattr(building, name, None) or () for name in ("heights", "strengths"))
    storeys = [f"{building.name}, storey {storey + 1}" for storey in range(len(heights))]
    isolators = 0 if getattr(building, "isolators", None) is None else 1
    weights = [STANDARD_GRAVITY * sum(building.masses[storey:]) for storey in range(len(strengths))]
    shares = {name: force / weight for name, force, weight in zip(storeys, strengths, weights, strict=False)}
    yield from _unusual_notes("storey height", _extremes(dict(zip(storeys, heights, strict=True))))
    if not _is_part(building):
        yield from _unusual_notes(
            "strength of a storey over the weight above", _extremes(dict(list(shares.items())[isolators:]))
        )
    if len(heights) < 2 or isolators or building.period > USUAL["period"].range[1]:
        return
    of_frame = 0.0724 * sum(heights) ** 0.8
    low, high = (share * of_frame for share in PERIODS_OF_HEIGHT)
    if not low <= building.period <= high:
        shares_of_frame = "{:g} to {:g} times".format(*PERIODS_OF_HEIGHT)
        yield (
            f"{building.name}: period {say(building.period, PERIOD)} at a height of "
            f"{say(sum(heights), STOREY_HEIGHT)}, usually {say(low, PERIOD, 2)} to {say(high, PERIOD, 2)} "
            f"({shares_of_frame} that of a steel frame, ASCE 7-16, equation 12.8-7); a decimal point lost, or a "
            "stiffness or mass in another unit?"
        )


def _isolator_notes(building: Any) -> Iterator[str]:
    """Notes on the strength and the stiffness of isolators, by the mass that they carry."""
    if getattr(building, "isolators", None) is None:
        return
    mass = sum(building.masses)
    law = building.isolators.law(mass)
    share = {building.name: law.strength / (STANDARD_GRAVITY * mass)} if law.strength else {}  # 0 is linear
    yield from _unusual_notes("strength of the isolators over the weight on them", share)
    yield from _unusual_notes(
        "yield displacement of the isolators", {building.name: building.isolators.yield_displacement}
    )
    if law.soft > 0.0:
        yield from _unusual_notes("period while the isolators yield", {building.name: 2.0 * pi * sqrt(mass / law.soft)})


def _condensation_notes(building: Any) -> Iterator[str]:
    """A note where a building condensed from a larger model lacks periods of that model."""
    condensation = getattr(building, "condensation", None)
    worst = condensation.worst() if condensation is not None else None
    if worst is None:
        return
    target, period = worst
    period_text = "no mode like it" if isnan(period) else f"{say(period, PERIOD)}, {abs(period / target - 1.0):.1%} off"
    yield (
        f"{building.name}: condensed to its floors it has {period_text}, where the whole model has a period of "
        f"{say(target, PERIOD)}; write interior_modes = {1 + len(building.interior_masses)} or more"
    )


def _extremes(numbers: Mapping[str, float]) -> dict[str, float]:
    """The smallest and the largest of the finite values, with their names: one note for each, not for each storey."""
    finite = sorted((number, subject) for subject, number in numbers.items() if isfinite(number))
    return {subject: number for number, subject in (*finite[:1], *finite[-1:])}


def _link_notes(study: Scene) -> Iterator[str]:
    """A sentence for each building with a link on its columns: their strength is not compared with its force."""
    for place, interface in enumerate(study.interfaces):
        pair = study.buildings[place : place + 2]
        for side, (building, other) in enumerate((pair, pair[::-1])):
            links = () if building.is_rigid else interface.links
            ends = {link.right_floor if side else link.left_floor for link in links}
            if storeys := ", ".join(f"{ceil(floor)}" for floor in sorted(ends) if floor % 1.0):
                yield (
                    f"{building.name}: the link to {other.name} ends on columns, of storey {storeys}; its force acts "
                    "on the floors below and above them, and the columns' strength is not compared with it"
                )


def _missing_height_notes(study: Scene) -> Iterator[str]:
    """A sentence for each single mass without a height beside storeys: it is taken to be as tall as these."""
    for place, interface in enumerate(study.interfaces):
        pair = study.buildings[place : place + 2]
        for mass, neighbour in (pair, pair[::-1]):
            tops = getattr(neighbour, "levels", ())[-1:]
            if tops and not (interface.contact or mass.is_rigid or getattr(mass, "height", 1.0) > 0.0):
                roof = say(tops[0], STOREY_HEIGHT)
                meeting = f"is taken to meet the roof of {neighbour.name}"
                yield f'{mass.name}: has no height, and {meeting}; write height = "{roof}", or its own'


def _gap_notes(study: Scene) -> Iterator[str]:
    gaps = [interface.gap for interface in study.interfaces]
    if any(study.bumpers):
        yield "gaps are those between the faces: closings and gaps required count the bumpers that stand in them"
    yield from _unusual_notes("gap", dict(zip(study.interface_names, gaps, strict=True)))
    yield from _unusual_notes("gap", {"grid.gap": max(study.grid.gaps)} if max(study.grid.gaps) > max(gaps) else {})


def _lower_building_notes(study: Scene) -> Iterator[str]:
    """A sentence on each building lower than both neighbours: they may meet above it, which no run computes."""
    roofs = [sum(building.heights) or nan for building in study.buildings]
    for place in range(1, len(roofs) - 1):
        if roofs[place] < min(roofs[place - 1], roofs[place + 1]) * (1.0 - SAME_HEIGHT):
            left, low, right = (building.name for building in study.buildings[place - 1 : place + 2])
            yield (
                f"{low}: {left} and {right} rise above it, and no contact of the two over it is computed; where they "
                "may close its width and both gaps, assess a scene of these two with that distance as the gap"
            )


def _stiffness_notes(study: Scene) -> Iterator[str]:
    """Notes on the contact durations that follow from the stiffness of each interface."""
    if all(is_instant(known_law(name)) for name in study.model_names):
        return
    for place, name in enumerate(study.interface_names):
        pair = study.at(place)
        if pair.stiffness is None:
            continue
        quantity = stiffness_quantity(known_law(pair.stiff_name))
        time = contact_duration(pair.stiffness, quantity.unit, pair.striking_mass)
        words = (
            f"{name}: a stiffness of {say(pair.stiffness, quantity)} makes a contact at {SPEED:g} m/s last "
            f"{say(time, TIME, 3)}"
        )
        periods = {building.name: building.period for building in pair.buildings if not building.is_rigid}
        short = shortest(periods)
        if short and time >= LONGEST_CONTACT * short[1]:
            unit = quantity.unit
            yield f"{words}, {share_of(time, *short)}: that is no blow; {unit} written for k{unit} or M{unit}?"
        elif short and time > (longest := SHARE_OF_PERIOD * short[1]) and pair.stiff_name != TABULATED:
            least = pair.stiffness * (time / longest) ** (2.0 if quantity.unit == LINEAR_STIFFNESS.unit else 2.5)
            last_digit = 10.0 ** (floor(log10(least)) - 1)
            least = last_digit * ceil(least / last_digit)  # two digits, upwards: what is written keeps the rule
            yield (
                f"{words}, {share_of(time, *short)}: too soft by the rule of `pounding-risk advise`, a tenth of it at "
                f"most, which {say(least, quantity, 2)} keeps; forces and accelerations of the contact follow from it"
            )
        elif time < SHORTEST_CONTACT:
            yield (
                f"{words}, less than {1e3 * SHORTEST_CONTACT:g} ms, in which sound crosses 1.75 m of concrete twice; "
                f"k{quantity.unit} written for {quantity.unit}?"
            )
        elif quantity.unit != LINEAR_STIFFNESS.unit and pair.stiffness > STIFFEST and short and time < 0.5 * longest:
            yield f"{words}; a typical one is 2.75e10 {quantity.unit}; k{quantity.unit} written for {quantity.unit}?"


def _restitution_notes(study: Scene) -> Iterator[str]:
    if any(known_law(name).needs_restitution for name in study.model_names):
        pairs = zip(study.interface_names, study.interfaces, strict=True)
        yield from _unusual_notes("restitution", {name: one.restitution.rule.at(SPEED) for name, one in pairs})


def contact_duration(stiffness: float, unit: str, mass: float, speed: float = SPEED) -> float:
    """Time from touch to parting [s] of two masses without damping and without yielding.

    Of the stiffness k [N/m] in F = k δ it is π √(m/k), half of a period; of β [N/m^1.5] in F = β δ^1.5 it is 3.2181 (m
    v²/β)^(2/5) / v (Goldsmith 1960, Impact, section 4.2, after Hertz), v the approach speed [m/s]. ``mass`` is m1 m2 /
    (m1 + m2) [kg]. Damping changes it by 13 % at most where e is 0.5 or more.

    >>> round(contact_duration(4.0, "N/m", 1.0), 4)
    1.5708
    """
    if unit == LINEAR_STIFFNESS.unit:
        return pi * sqrt(mass / stiffness)
    return float(HERTZ_TIME * (mass * speed**2 / stiffness) ** 0.4 / speed)


def _motion_notes(study: Scene, motions: tuple[Motion, ...]) -> Iterator[str]:
    """Notes on the peaks of motions as recorded, and on the amplitudes that the scene asks for."""
    request = study.records
    grid = study.grid
    if request.aftershock:
        yield from _sequence_notes(motions)
        yield from _pause_notes(study)
    if grid.measure != PEAK:
        yield from _level_notes(grid, motions)
        return
    amplitudes = [pga for pga in (*grid.levels, request.pga) if pga is not None]
    if amplitudes:
        yield from _unusual_notes("PGA asked for", {"the scene": max(amplitudes)})
        return
    if any(motion.record.get("factor", 1.0) != 1.0 for motion in motions):
        return
    # Motions with a flag that questions their unit already are left out.
    checked = [motion for motion in motions if not any(flag.endswith(UNIT_CHECKED) for flag in motion.flags)]
    generated = [motion for motion in checked if motion.record.get("state") == GENERATED]
    yield from _peak_notes("PGA as recorded", [motion for motion in checked if motion not in generated])
    yield from _peak_notes("PGA asked for", generated)


def _peak_notes(name: str, motions: Sequence[Motion]) -> Iterator[str]:
    """A note on the PGA of motions furthest below a usual range of that name, and on the one furthest above."""
    low, high = USUAL[name].range
    weak = [(motion.pga, motion.name) for motion in motions if motion.pga < low]
    strong = [(motion.pga, motion.name) for motion in motions if motion.pga > high]
    for unusual, pick in ((weak, min), (strong, max)):
        if unusual:
            pga, label = pick(unusual, key=itemgetter(0))
            more_text = f" and {len(unusual) - 1} more" if len(unusual) > 1 else ""
            yield from _unusual_notes(name, {f"{label}{more_text}": pga})


def _sequence_notes(motions: Sequence[Motion]) -> Iterator[str]:
    """A note for each aftershock behind several recordings, which then count as one."""
    mainshocks: dict[Hashable, set[Hashable]] = {}
    names: dict[Hashable, dict[str, None]] = {}
    keys = recordings_within([motion.record for motion in motions], [motion.name for motion in motions])
    for motion, (mainshock, shock) in zip(motions, keys, strict=True):
        mainshocks.setdefault(shock, set()).add(mainshock)
        names.setdefault(shock, {})[motion.record[AFTERSHOCK]["name"]] = None
    for shock, recordings in mainshocks.items():
        count = len(recordings | {mainshock for mainshock, _ in keys if mainshock == shock})
        if count > 1:
            yield (
                f"aftershock {', '.join(names[shock])}: stands in the motions of {count} recordings, which count as "
                "one, as it may decide in all of them; bounds are wider than with an aftershock of its own for each"
            )


def _pause_notes(study: Scene) -> Iterator[str]:
    """A note on the building that the aftershock meets furthest from rest: free vibration falls as exp(-2π ζ t / T)."""
    moving = [building for building in study.buildings if not building.is_rigid]
    dampings = [one.first_damping() if isinstance(one, Storeys) else one.damping for one in moving]
    rates = [2.0 * pi * damping / one.period for one, damping in zip(moving, dampings, strict=True)]
    rate, pause = min(rates, default=inf), study.records.pause
    left = exp(-rate * pause)
    if left <= LEFT_OF_PAUSE or has_known_motion(study):
        return
    building, damping = moving[rates.index(rate)], dampings[rates.index(rate)]
    repair = f'; write pause = "{ceil(-log(LEFT_OF_PAUSE) / rate)} s" or more' if rate > 0.0 else ""
    yield (
        f"{building.name}: {100.0 * left:.2g} % of the amplitude of its free vibration, exp(-2 pi damping pause / "
        f"period), are left after a pause of {say(pause, TIME)} at a period of {say(building.period, PERIOD)} and a "
        f"damping of {say(damping, DAMPING)}, usually {100.0 * LEFT_OF_PAUSE:g} % or less: the aftershock does not "
        f"meet it at rest{repair}"
    )


def _level_notes(grid: Axes, motions: tuple[Motion, ...]) -> Iterator[str]:
    """A note on the strongest PGA of motions that are scaled to levels of another measure."""
    values = grid.measure.of(motions)
    largest = max(level for level in grid.levels if level is not None)
    moving = [(motion, value) for motion, value in zip(motions, values, strict=True) if value > 0.0]
    peaks = {motion.name: motion.pga * largest / value for motion, value in moving}
    if peaks:
        name = max(peaks, key=peaks.__getitem__)
        yield from _unusual_notes("PGA after scaling", {f"{name} at {Level(grid.measure, largest).words}": peaks[name]})


def _own_record_notes(study: Scene, motions: Sequence[Motion]) -> Iterator[str]:
    """A note for each record that stands below a building in several recordings, which bounds count as independent."""
    names = [building.name for building in study.buildings if building.support.records]
    keys = recordings_within([motion.record for motion in motions], [motion.name for motion in motions])
    recordings_above: dict[tuple[str, str], set[Hashable]] = {}
    for motion, (first, *_) in zip(motions, keys, strict=True):
        for building, record in zip(names, motion.record.get(BESIDE, ()), strict=False):
            recordings_above.setdefault((building, record["name"]), set()).add(first)
    for (building, name), recordings in recordings_above.items():
        if len(recordings) > 1:
            yield (
                f"{building}: {name} stands below it in the motions of {len(recordings)} recordings, which bounds "
                "count as independent: they hold for this record below it, and leave out what another one would change"
            )


def _ground_notes(study: Scene, motions: tuple[Motion, ...]) -> Iterator[str]:
    """A note on the interface whose grounds part most: that displacement is part of what closes and opens the gap."""
    if not any(building.support != SHARED for building in study.buildings):
        return
    amplitude = study.grid.amplitudes[-1]
    driving = [driven(motion, AS_RECORDED, None if motion.pga == 0.0 else amplitude) for motion in motions]
    partings = [parting(study, motion) for motion in driving]
    sizes = np.array([item.largest for item in partings])
    if not sizes.any():
        return
    number, place = np.unravel_index(int(sizes.argmax()), sizes.shape)
    worst, name = partings[number], study.interface_names[place]
    largest, end = (say(float(values[place]), GAP, 3) for values in (worst.largest, np.abs(worst.end)))
    yield (
        f"{name}: their grounds move by up to {largest} against each other ({driving[number].name}, at "
        f"{worst.when[place]:.3g} s), which is part of what closes and opens the gap; {end} are left at the end: "
        "in a record without baseline correction that is drift, no motion of the ground"
    )
