"""Typologies: period, mode shape and yield acceleration of a building of which only height and storeys are known.

    >>> round(TYPOLOGIES["concrete_frame"].period(30.0), 3)
    0.995

Each kind has the approximate period of a code, T = C_t h^x with h in m; a first mode shape (z / h)^p; and the spectral
acceleration at which its storeys yield. A period is verified where the numbers of its clause were read; ``source`` says
where. The powers p are this package's own: 1 for frames and masonry, whose storeys shear; 1.5 for walls, which bend.
Yield accelerations are those of the capacity curves of FEMA's Hazus Earthquake Model for moderate-code buildings of its
kinds C1, S1, S2, C2 and, of any code, URM, as the data of the SimCenter's capacity spectrum module repeat them.
"""

from __future__ import annotations

from math import inf
from typing import Any, NamedTuple

from pounding_risk.errors import PoundingError
from pounding_risk.units import HEIGHT, unknown

ASCE7, EC8 = "ASCE/SEI 7, 12.8.2.1, Table 12.8-2", "EN 1998-1:2004, 4.3.3.2.2 (3), expression (4.6)"
ASCE7_SOURCE = "Table 12.8-2 as Taly (2010), Design of Reinforced Masonry Structures, repeats it in Table 7.4"
EC8_SOURCE = "repeated from memory of the profession; read the clause before you rely on it"
EUROPEAN = "_ec8"  # how the names end


class CodePeriod(NamedTuple):
    """A code's approximate period, T = C_t h^x."""

    coefficient: float  # C_t, s / m^x
    exponent: float  # x
    highest: float  # m, of the buildings that the clause is for
    reference: str
    verified: bool
    source: str


class Typology(NamedTuple):
    """A kind of building and what its code and mode shape say of it."""

    name: str
    words: str
    code: CodePeriod
    power: float  # p of the first mode shape (z / h)^p
    rises: tuple[int, ...]  # storeys up to which each yield acceleration but the last holds
    yield_accelerations: tuple[float, ...]  # g, spectral, where the storeys yield in the first mode

    def period(self, height: float) -> float:
        """The code's approximate period [s] of a building of this height [m].

        Raises PoundingError for a height that the clause is not for.
        """
        if not 0.0 < height < inf:
            raise PoundingError(
                f'{height:g} m is out of range: a {HEIGHT.words} must be greater than 0 m; write height = "12 m"'
            )
        if height > self.code.highest:
            raise PoundingError(
                f"{height:g} m is higher than the {self.code.highest:g} m that {self.code.reference} is for; give the "
                f"period, or take {self.name.removesuffix(EUROPEAN)}"
            )
        return self.code.coefficient * height**self.code.exponent

    @property
    def period_words(self) -> str:
        """The code's formula of the period, in s for a height in m."""
        limit = "" if self.code.highest == inf else f" up to {self.code.highest:g} m"
        return f"{self.code.coefficient:g} h^{self.code.exponent:g}{limit}"

    @property
    def shape_words(self) -> str:
        """The formula of the first mode's shape."""
        return "z / h" if self.power == 1.0 else f"(z / h)^{self.power:g}"

    @property
    def yield_words(self) -> str:
        """Yield acceleration [g] by the number of storeys."""
        ranges = [
            f"{value:g} to {rise} storeys" for value, rise in zip(self.yield_accelerations, self.rises, strict=False)
        ]
        return ", ".join([*ranges, f"{self.yield_accelerations[-1]:g} above"])

    def yield_acceleration(self, storeys: int) -> float:
        """The spectral acceleration [g] at which a building of so many storeys yields."""
        return self.yield_accelerations[sum(storeys > rise for rise in self.rises)]


# Name, words, C_t and x of ASCE 7, C_t of Eurocode 8, p, storeys up to which each yield acceleration holds, these [g].
_KINDS: tuple[tuple[Any, ...], ...] = (
    ("concrete_frame", "concrete moment frame", (0.0466, 0.9), 0.075, 1.0, (3, 7), (0.125, 0.104, 0.049)),
    ("steel_frame", "steel moment frame", (0.0724, 0.8), 0.085, 1.0, (3, 7), (0.125, 0.078, 0.049)),
    ("braced_frame", "eccentrically braced frame", (0.0731, 0.75), 0.075, 1.0, (3, 7), (0.2, 0.167, 0.127)),
    ("concrete_walls", "concrete walls", (0.0488, 0.75), 0.050, 1.5, (3, 7), (0.2, 0.167, 0.127)),
    ("masonry", "unreinforced masonry walls", (0.0488, 0.75), 0.050, 1.0, (2,), (0.2, 0.111)),
)


def _both_codes() -> dict[str, Typology]:
    """Each kind with the period of ASCE 7, and under a name of its own with that of Eurocode 8."""
    kinds = []
    for name, words, (coefficient, exponent), ec8, *more in _KINDS:
        kinds.append(Typology(name, words, CodePeriod(coefficient, exponent, inf, ASCE7, True, ASCE7_SOURCE), *more))
        other = CodePeriod(ec8, 0.75, 40.0, EC8, False, EC8_SOURCE)
        kinds.append(Typology(name + EUROPEAN, words, other, *more))
    return {kind.name: kind for kind in (*kinds[::2], *kinds[1::2])}


TYPOLOGIES = _both_codes()
# Names of the field, and what they are here.
ELSEWHERE = {
    "rc rc_frame rc_moment_frame rcc concrete reinforced_concrete reinforced_concrete_frame": (
        'a frame of reinforced concrete is "concrete_frame"'
    ),
    "rc_wall rc_walls rc_shear_wall rc_shear_walls shear_wall shear_walls": 'walls of concrete are "concrete_walls"',
    "brick urm": 'walls of brick are "masonry"',
}


def known_typology(name: str) -> Typology:
    """The typology of this name; raises PoundingError, with the nearest name, where there is none."""
    if name not in TYPOLOGIES:
        raise PoundingError(unknown(name, "not a typology", TYPOLOGIES, ELSEWHERE))
    return TYPOLOGIES[name]
