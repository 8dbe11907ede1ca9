"""The range of stiffness that a contact between two buildings should have, and the published rules of choice beside it.

A contact that lasts longer than a tenth of a building's period is no blow: the building moves on its own spring while
it lasts. One that is shorter than the passage of a wave through a floor cannot be that of floors that move as rigid
bodies. Durations are those of the undamped isolated impact (`ensemble.plausibility.contact_duration`).
"""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, pi, sqrt
from typing import NamedTuple

import numpy as np

from pounding_risk.ensemble.plausibility import HERTZ_TIME, SHARE_OF_PERIOD, contact_duration
from pounding_risk.models.contact.laws import HERTZ_STIFFNESS, LINEAR_STIFFNESS, stiffness_quantity
from pounding_risk.models.contact.table import TABULATED
from pounding_risk.models.structures.contact_points import COLUMN, Point
from pounding_risk.models.structures.sdof import CONCRETE_WAVE_SPEED, Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.render.sheet import amount
from pounding_risk.scene.interfaces import known_law
from pounding_risk.scene.scene import Scene
from pounding_risk.units import rounded

KIP, INCH = 4448.2216152605, 0.0254  # N, m
BELOW, WITHIN, ABOVE = "too soft", "in the range", "too stiff"


class Floor(NamedTuple):
    """What collides on one side of an interface."""

    building: str
    mass: float  # kg, at the contact point; inf for a rigid wall
    lateral: float  # N/m, of the storey below, or of a single mass's spring; inf for a rigid wall
    period: float  # s, of the building; 0 for a rigid wall
    length: float  # m
    wave_speed: float  # m/s
    is_assumed: bool  # whether the length is not the scene's

    @property
    def passage(self) -> float:
        """Time in which a wave crosses the floor once [s]; 0 for a rigid wall."""
        return 0.0 if self.mass == inf else self.length / self.wave_speed

    @property
    def axial(self) -> float:
        """E A / L [N/m] of a floor that carries no more than its own mass: m (c / L)²."""
        return self.mass * (self.wave_speed / self.length) ** 2


class Rule(NamedTuple):
    """A published rule of choice, applied to one interface."""

    name: str
    published: float  # in `unit`
    unit: str
    source: str
    known: str  # how its value is known: "derived", "quoted", "from memory"
    equivalent: float  # stiffness of the scene's law whose isolated impact lasts as long, in its unit
    duration: float  # s
    verdict: str  # BELOW, WITHIN or ABOVE; "" where there is no range


class StiffnessRange(NamedTuple):
    """The range of stiffness at one interface. Durations are at ``speed``, of the undamped isolated impact."""

    interface: str
    buildings: tuple[str, str]
    contact_model: str
    unit: str  # of stiffness
    own: float  # the scene's
    speed: float  # m/s
    mass: float  # kg, reduced mass of the floors that collide
    duration: float  # s, of a contact with the scene's stiffness
    longest: float  # s, a tenth of the shorter period
    shortest: float  # s, passage of a wave through the longer floor
    low: float  # in `unit`; above `high` where the range is empty
    high: float
    is_column: bool  # a floor meets a column, which bends: E A / L of floors says nothing of it
    wall: str  # the building that is too stiff for any contact to be short beside its period, and counts as a wall
    assumed: tuple[str, ...]  # the buildings whose floor length is assumed
    assumed_length: float  # m
    rules: tuple[Rule, ...]

    @property
    def is_empty(self) -> bool:
        """True where no stiffness satisfies both limits."""
        return self.low > self.high

    @property
    def verdict(self) -> str:
        """Where the scene's stiffness lies: `BELOW`, `WITHIN` or `ABOVE`; "" where the range is empty."""
        return "" if self.is_empty else _verdict(self.own, self.low, self.high)

    @property
    def recommended(self) -> float | None:
        """The stiffness to write: the scene's own within the range, else that of E A / L, else the middle.

        None where the range is empty. Where floors meet columns E A / L is not considered. A table of forces stands for
        itself, whatever the range of floors that collide.
        """
        if self.contact_model == TABULATED or self.is_column:
            return self.own
        if self.is_empty:
            return None
        if self.verdict == WITHIN:
            return self.own
        stiffness = self.rules[0].equivalent if self._by_axial else sqrt(self.low * self.high)
        rounded = float(f"{stiffness:.2g}")
        return rounded if self.low <= rounded <= self.high else stiffness

    @property
    def _by_axial(self) -> bool:
        """Whether E A / L of the floors, the first of the rules, lies in the range and is that of the contact."""
        return self.rules[0].verdict == WITHIN

    @property
    def line(self) -> str:
        """The line of the [[interface]] table; "" where the range is empty."""
        proposed = None if self.contact_model == TABULATED or self.is_column else self.recommended
        return "" if proposed is None else 'stiffness = "{text}"'.format(**amount(proposed, self.unit))

    @property
    def why(self) -> str:
        """Why this line, in a sentence; where the range is empty, what to do."""
        limits = (
            f"a wave crosses the floor in {ms(self.shortest)} and a tenth of the shorter period is {ms(self.longest)}"
        )
        lasts = (
            f"with the scene's {amount(self.own, self.unit)['text']} a contact at {self.speed:.2g} m/s lasts "
            f"{ms(self.duration)}"
        )
        if self.contact_model == TABULATED:
            return (
                f"Keep the forces of the table, another stiffness would scale them: {lasts}, by the secant to its last "
                f"point; {limits}, which is of floors that collide without anything between them"
            )
        if self.is_column:
            return (
                "No stiffness is proposed: floors strike columns only, which bend, and neither E A / L nor the waves "
                f"of the floors say how stiff these are. Keep the scene's, or write that of the column in bending; "
                f"{lasts}; between floors, {limits}"
            )
        if self.is_empty:
            return (
                f"No stiffness fits: {limits}; {lasts}. Write the length of the floors, if they are shorter, or "
                'contact_model = "distributed_mass", which follows the waves in single masses, or keep the stiffness '
                "and do not use contact forces and accelerations"
            )
        if self.verdict == WITHIN:
            return f"Keep it: {lasts}; {limits}"
        origin = "as long as E A / L of the floors" if self._by_axial else "the middle of the range"
        new = contact_duration(self.recommended or inf, self.unit, self.mass, self.speed)
        return f"{self.verdict.capitalize()}: {lasts}; {limits}. The value proposed makes it {ms(new)}, {origin}"


def ms(seconds: float) -> str:
    """A duration in milliseconds: 17.3 ms, 1040 ms."""
    return f"{rounded(1e3 * seconds, 3)} ms"


def stiffness_for(duration: float, unit: str, mass: float, speed: float) -> float:
    """The stiffness with which an isolated contact lasts so long: the inverse of `contact_duration`.

    Parameters
    ----------
    duration : float
        [s].
    unit : str
        "N/m": k = m (π / t)²; or "N/m^1.5": β = m v² (3.2181 / (v t))^2.5.
    mass : float
        Reduced mass [kg].
    speed : float
        Approach speed [m/s].

    Returns
    -------
    float
        In ``unit``.

    Examples
    --------
    >>> round(stiffness_for(contact_duration(2e9, "N/m^1.5", 3e4, 0.3), "N/m^1.5", 3e4, 0.3))
    2000000000
    """
    if unit == LINEAR_STIFFNESS.unit:
        return mass * (pi / duration) ** 2
    return float(mass * speed**2 * (HERTZ_TIME / (speed * duration)) ** 2.5)


def stiffness_range(scene: Scene, index: int, point: Point, speed: float, floor_length: float) -> StiffnessRange:
    """The range at the interface ``index``, of the floors at a contact ``point`` that meet at ``speed`` [m/s].

    ``floor_length`` [m] is for buildings that give none. The interface has a stiffness.
    """
    part = scene.at(index)
    left, right = part.buildings
    floors = (floor_at(left, point.left_floor, floor_length), floor_at(right, point.right_floor, floor_length))
    shortest = max(floor.passage for floor in floors)
    # A building that vibrates faster than that moves with its ground, whatever strikes it.
    moving = [floor for floor in floors if floor.period > 0.0]
    slow = [floor for floor in moving if SHARE_OF_PERIOD * floor.period > shortest]
    wall = next((floor.building for floor in moving if floor not in slow), "") if len(slow) == 1 else ""
    colliding = slow if wall else moving
    mass = 1.0 / sum(1.0 / floor.mass for floor in colliding)
    longest = SHARE_OF_PERIOD * min(floor.period for floor in colliding)
    unit = stiffness_quantity(known_law(part.stiff_name)).unit
    own_stiffness = float(part.stiffness or 0.0)
    low, high = (stiffness_for(duration, unit, mass, speed) for duration in (longest, shortest))
    assumed = tuple(dict.fromkeys(floor.building for floor in moving if floor.is_assumed))
    rules = []
    for name, published, rule_unit, source, basis in _published(floors):
        duration = contact_duration(published, rule_unit, mass, speed)
        equivalent = published if rule_unit == unit else stiffness_for(duration, unit, mass, speed)
        verdict = "" if low > high else _verdict(equivalent, low, high)
        rules.append(Rule(name, published, rule_unit, source, basis, equivalent, duration, verdict))
    return StiffnessRange(
        interface=scene.interface_names[index],
        buildings=(left.name, right.name),
        contact_model=part.stiff_name,
        unit=unit,
        own=own_stiffness,
        speed=speed,
        mass=mass,
        duration=contact_duration(own_stiffness, unit, mass, speed),
        longest=longest,
        shortest=shortest,
        low=low,
        high=high,
        is_column=point.kind == COLUMN,
        wall=wall,
        assumed=assumed,
        assumed_length=floor_length,
        rules=tuple(rules),
    )


def floor_at(building: Building | Storeys, floor: float, floor_length: float) -> Floor:
    """What collides at a floor number of a building: a single mass, a floor, or a column between two floors.

    A column at the fraction s of its storey has the inverse mass (1 − s)² / m_below + s² / m_above; of a mass matrix
    it is B M⁻¹ Bᵀ with these shares.
    """
    if isinstance(building, Building):
        length = building.floor_length or floor_length
        mass = inf if building.is_rigid else building.mass
        is_assumed = not (building.is_rigid or building.floor_length > 0.0)
        lateral, period, wave_speed = building.stiffness, building.period, building.wave_speed
        return Floor(building.name, mass, lateral, period, length, wave_speed, is_assumed)
    below = int(floor)
    fraction = floor - below
    inverse = (1.0 - fraction) ** 2 / building.masses[below - 1] if below else 0.0
    inverse += fraction**2 / building.masses[below] if fraction else 0.0
    inertia = building.mass_coupling()
    if inertia.size:
        shares = np.zeros(len(inertia) + 1)  # of the ground and the floors
        shares[below : below + 2] = ((1.0 - fraction), fraction)[: len(shares) - below]
        inverse = float(shares[1:] @ np.linalg.solve(inertia, shares[1:]))
    storey = building.storey_springs[below if fraction else below - 1]
    return Floor(building.name, 1.0 / inverse, storey, building.period, floor_length, CONCRETE_WAVE_SPEED, True)


def _verdict(stiffness: float, low: float, high: float) -> str:
    return BELOW if stiffness < low else ABOVE if stiffness > high else WITHIN


def _published(floors: tuple[Floor, Floor]) -> Iterator[tuple[str, float, str, str, str]]:
    """Name, value, unit, source and how it is known, of each rule."""
    k, beta = LINEAR_STIFFNESS.unit, HERTZ_STIFFNESS.unit
    moving = [floor for floor in floors if floor.mass < inf]
    axial = 1.0 / sum(1.0 / floor.axial for floor in moving)
    sizes = dict.fromkeys(f"L = {floor.length:g} m, c = {floor.wave_speed:g} m/s" for floor in moving)
    yield (
        "E A / L of the colliding floors, one behind the other",
        axial,
        k,
        f"OpenSees, Impact Material; Kharazian and Lopez-Almansa (2017); here m (c / L)², {' and '.join(sizes)}",
        "derived",
    )
    lateral = max(floor.lateral for floor in moving)
    thread = "practitioners (simpliengineering.com, gap element in SAP2000)"
    yield "10 × the stiffer storey's lateral stiffness", 10.0 * lateral, k, thread, "quoted"
    yield "20 × the stiffer building's", 20.0 * lateral, k, "Anagnostopoulos (1988)", "from memory"
    yield "100 × the stiffer storey's lateral stiffness", 100.0 * lateral, k, thread, "quoted"
    yield "50 000 kip/in, floors of buildings", 5e4 * KIP / INCH, k, "Maison and Kasai (1990)", "from memory"
    yield "linear viscoelastic, concrete", 9.35e7, k, "Jankowski (2005), fit to van Mier's test", "from memory"
    yield "Hertz, concrete", 2.0e9, beta, "Jankowski (2005), fit to van Mier's test", "from memory"
    yield "nonlinear viscoelastic, concrete", 2.75e9, beta, "Jankowski (2005), fit to van Mier's test", "from memory"
    yield "25 000 kip/in^1.5", 25e3 * KIP / INCH**1.5, beta, "OpenSees, Impact Material", "quoted"
