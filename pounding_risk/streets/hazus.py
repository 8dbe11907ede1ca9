"""Building types of FEMA's Hazus Earthquake Model: the typology that each comes nearest to, and chains of storeys.

The chain is that of Lu et al. (2014), as SimCenter's MDOF-LU makes it: n equal masses m on equal springs k, whose first
period is T = n T_1, and storeys that yield at the capacity curve's yield point under forces that grow with the height:

    k = π² m / (T² sin²(a / 2)),  a = π / (2 n + 1)          α_1 = cot²(a / 2) / (n (2 n + 1))
    V_i = A_y α_1 n m g (1 − i (i − 1) / (n (n + 1)))         i from 1 at the ground

k and α_1, the share of the mass in the first mode, are those of the uniform chain in closed form; MDOF-LU has
polynomials that come within 0.3 % of them. T_1 is the typical period of a type over its typical number of storeys.

Lu, Han, Hori, Xiong, Xu (2014), A coarse-grained parallel approach for seismic damage simulations of urban areas based
on refined models and GPU/CPU cooperative computing, Advances in Engineering Software 70, 90-103.
"""

from __future__ import annotations

from functools import cache
from math import pi, sin, tan
from typing import NamedTuple

from pounding_risk.units import STANDARD_GRAVITY

FOOT = 0.3048  # m


class Family(NamedTuple):
    """A structural type of Hazus, of any height: its name in words, and the nearest typology here, or ""."""

    words: str
    typology: str


# Types of the Hazus Earthquake Model technical manual, table 5.1. Moment frames that infills stiffen, and reinforced
# masonry, have the period of ASCE 7's "all other structural systems", which is that of the typology masonry.
FAMILIES = {
    "W1": Family("light wood frame", ""),
    "W2": Family("commercial or industrial wood frame", ""),
    "S1": Family("steel moment frame", "steel_frame"),
    "S2": Family("steel braced frame", "braced_frame"),
    "S3": Family("light metal frame", ""),
    "S4": Family("steel frame with concrete walls", "concrete_walls"),
    "S5": Family("steel frame with masonry infill", "masonry"),
    "C1": Family("concrete moment frame", "concrete_frame"),
    "C2": Family("concrete walls", "concrete_walls"),
    "C3": Family("concrete frame with masonry infill", "masonry"),
    "PC1": Family("precast tilt-up walls", "concrete_walls"),
    "PC2": Family("precast frame with concrete walls", "concrete_walls"),
    "RM1": Family("reinforced masonry with flexible floors", "masonry"),
    "RM2": Family("reinforced masonry with stiff floors", "masonry"),
    "URM": Family("unreinforced masonry walls", "masonry"),
    "MH": Family("mobile home", ""),
}
HEIGHTS = ("L", "M", "H")  # behind the family: low-rise, mid-rise, high-rise


def family_of(name: str) -> str:
    """The family of a type, "C1" of "C1M" and of "c1"; "" where it is none."""
    upper = name.strip().upper()
    stem = upper[:-1] if upper.endswith(HEIGHTS) else upper
    return upper if upper in FAMILIES else stem if stem in FAMILIES else ""


LEVELS = ("high", "moderate", "low", "pre")  # of the code that a building was designed by
STATES = ("slight", "moderate", "extensive", "complete")
OF_TYPOLOGY = {
    "concrete_frame": "C1",
    "steel_frame": "S1",
    "braced_frame": "S2",
    "concrete_walls": "C2",
    "masonry": "URM",
}
NO_CODE = ("S5", "C3", "URM")  # without moderate and high code in the manual: such buildings are older
# Type, typical period [s], storeys and height [ft], elastic damping [%]; then for each level of the code the yield
# acceleration A_y [g], and the storey drift ratios [1e-4] at which the states of damage begin. Technical manual, tables
# 5.1, 5.5, 5.7 to 5.10 and those of drift limits, as HazusData.txt of MDOF-LU repeats them; periods and heights of a
# storey there are these over the storeys. The accelerations were compared with the tables of SimCenter's capacity
# spectrum module (of Hazus 5.1), the drifts with pelicun's library of damage models (Hazus 5.1): all are equal. Mobile
# homes (MH) are left out, as the two differ in their acceleration.
TABLE = """
W1 0.35 1 14 10 0.400 40 120 400 1000 0.300 40 99 306 750 0.200 40 99 306 750 0.200 32 79 245 600
W2 0.40 2 24 10 0.400 40 120 400 1000 0.200 40 99 306 750 0.100 40 99 306 750 0.100 32 79 245 600
S1L 0.50 2 24 5 0.250 60 120 300 800 0.125 60 104 235 600 0.062 60 96 203 500 0.062 48 76 162 400
S1M 1.08 5 60 5 0.156 40 80 200 533 0.078 40 69 157 400 0.039 40 64 135 333 0.039 32 51 108 267
S1H 2.21 13 156 5 0.098 30 60 150 400 0.049 30 52 118 300 0.024 30 48 101 250 0.024 24 38 81 200
S2L 0.40 2 24 5 0.400 50 100 300 800 0.200 50 87 233 600 0.100 50 80 200 500 0.100 40 64 160 400
S2M 0.86 5 60 5 0.333 33 67 200 533 0.167 33 58 156 400 0.083 33 53 133 333 0.083 27 43 107 267
S2H 1.77 13 156 5 0.254 25 50 150 400 0.127 25 43 117 300 0.063 25 40 100 250 0.063 20 32 80 200
S3 0.40 1 15 5 0.400 40 80 240 700 0.200 40 70 187 525 0.100 40 64 161 438 0.100 32 51 128 350
S4L 0.35 2 24 5 0.320 40 80 240 700 0.160 40 69 187 525 0.080 40 64 161 438 0.080 32 51 128 350
S4M 0.65 5 60 5 0.267 27 53 160 467 0.133 27 46 125 350 0.067 27 43 107 292 0.067 21 34 86 233
S4H 1.32 13 156 5 0.203 20 40 120 350 0.102 20 35 93 262 0.051 20 32 80 219 0.051 16 26 64 175
S5L 0.35 2 24 5 0.100 30 60 150 350 0.100 30 60 150 350 0.100 30 60 150 350 0.100 24 48 120 280
S5M 0.65 5 60 5 0.083 20 40 100 233 0.083 20 40 100 233 0.083 20 40 100 233 0.083 16 32 80 187
S5H 1.32 13 156 5 0.063 15 30 75 175 0.063 15 30 75 175 0.063 15 30 75 175 0.063 12 24 60 140
C1L 0.40 2 20 7 0.250 50 100 300 800 0.125 50 87 233 600 0.062 50 80 200 500 0.062 40 64 160 400
C1M 0.75 5 50 7 0.208 33 67 200 533 0.104 33 58 156 400 0.052 33 53 133 333 0.052 27 43 107 267
C1H 1.45 12 120 7 0.098 25 50 150 400 0.049 25 43 117 300 0.024 25 40 100 250 0.024 20 32 80 200
C2L 0.35 2 20 7 0.400 40 100 300 800 0.200 40 84 232 600 0.100 40 76 197 500 0.100 32 61 158 400
C2M 0.56 5 50 7 0.333 27 67 200 533 0.167 27 56 154 400 0.083 27 51 132 333 0.083 21 41 105 267
C2H 1.09 12 120 7 0.254 20 50 150 400 0.127 20 42 116 300 0.063 20 38 99 250 0.063 16 31 79 200
C3L 0.35 2 20 7 0.100 30 60 150 350 0.100 30 60 150 350 0.100 30 60 150 350 0.100 24 48 120 280
C3M 0.56 5 50 7 0.083 20 40 100 233 0.083 20 40 100 233 0.083 20 40 100 233 0.083 16 32 80 187
C3H 1.09 12 120 7 0.063 15 30 75 175 0.063 15 30 75 175 0.063 15 30 75 175 0.063 12 24 60 140
PC1 0.35 1 15 7 0.600 40 80 240 700 0.300 40 70 187 525 0.150 40 64 161 438 0.150 32 51 128 350
PC2L 0.35 2 20 7 0.400 40 80 240 700 0.200 40 69 187 525 0.100 40 64 161 438 0.100 32 51 128 350
PC2M 0.56 5 50 7 0.333 27 53 160 467 0.167 27 46 125 350 0.083 27 43 107 292 0.083 21 34 86 233
PC2H 1.09 12 120 7 0.254 20 40 120 350 0.127 20 35 94 263 0.063 20 32 80 219 0.063 16 26 64 175
RM1L 0.35 2 20 10 0.533 40 80 240 700 0.267 40 69 187 525 0.133 40 64 161 438 0.133 32 51 128 350
RM1M 0.56 5 50 10 0.444 27 53 160 467 0.222 27 46 125 350 0.111 27 43 107 292 0.111 21 34 86 233
RM2L 0.35 2 20 10 0.533 40 80 240 700 0.267 40 69 187 525 0.133 40 64 161 438 0.133 32 51 128 350
RM2M 0.56 5 50 10 0.444 27 53 160 467 0.222 27 46 125 350 0.111 27 43 107 292 0.111 21 34 86 233
RM2H 1.09 12 120 10 0.338 20 40 120 350 0.169 20 35 94 263 0.085 20 32 80 219 0.085 16 26 64 175
URML 0.35 1 15 10 0.200 30 60 150 350 0.200 30 60 150 350 0.200 30 60 150 350 0.200 24 48 120 280
URMM 0.50 3 35 10 0.111 20 40 100 233 0.111 20 40 100 233 0.111 20 40 100 233 0.111 16 32 80 187
"""


class Level(NamedTuple):
    """Strength and limits of damage of a type under one level of the code."""

    yield_acceleration: float  # g
    drifts: tuple[float, ...]  # storey drift ratios, by state


class Type(NamedTuple):
    """A building type of Hazus with its range of height."""

    name: str  # "C1M"
    period: float  # s, of one storey
    storey_height: float  # m
    damping: float
    levels: dict[str, Level]


class Chain(NamedTuple):
    """Storeys of a building by the rule: all masses, springs and heights are equal."""

    kind: str
    level: str
    period: float  # s
    stiffness: float  # N/m, of each storey
    strengths: tuple[float, ...]  # N, from the ground up
    drifts: tuple[float, ...]  # storey drift ratios at which the states of damage begin


@cache
def types() -> dict[str, Type]:
    """The types of the table by their names."""
    by_name = {}
    for line in TABLE.strip().splitlines():
        name, period, storeys, height, damping, *cells = line.split()
        n = int(storeys)
        groups = [[float(cell) for cell in cells[k : k + 5]] for k in range(0, len(cells), 5)]
        levels = {
            level: Level(strength, tuple(drift / 1e4 for drift in drifts))
            for level, (strength, *drifts) in zip(LEVELS, groups, strict=True)
        }
        by_name[name] = Type(name, float(period) / n, float(height) * FOOT / n, float(damping) / 100.0, levels)
    return by_name


def type_of(family: str, storeys: int) -> Type | None:
    """The type of a family for a number of storeys: low-rise to 3 (of plain masonry 2), mid-rise to 7, high-rise above.

    None where the table has no such family.
    """
    low = 2 if family == "URM" else 3
    rise = "L" if storeys <= low else "M" if storeys <= 7 or family in ("RM1", "URM") else "H"
    by_name = types()
    return by_name.get(family) or by_name.get(family + rise)


def chain(kind: Type, level: str, storeys: int, floor_mass: float, period: float | None = None) -> Chain:
    """The storeys of a building of floors of this mass [kg]; ``period`` [s] stands for that of its type."""
    n, limits = storeys, kind.levels[level]
    first_period = n * kind.period if period is None else period
    half_angle = pi / (2.0 * (2.0 * n + 1.0))
    stiffness = pi**2 * floor_mass / (first_period * sin(half_angle)) ** 2
    base = limits.yield_acceleration * STANDARD_GRAVITY * floor_mass / (tan(half_angle) ** 2 * (2.0 * n + 1.0))
    strengths = tuple(base * (1.0 - i * (i - 1) / (n * (n + 1))) for i in range(1, n + 1))
    return Chain(kind.name, level, first_period, stiffness, strengths, limits.drifts)
