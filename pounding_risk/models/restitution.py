"""Coefficient of restitution e as a function of the speed at which a contact starts."""

from __future__ import annotations

from math import inf
from typing import Annotated, NamedTuple, Protocol

from pounding_risk._jit.compile import speaks
from pounding_risk.models._discovery import documented
from pounding_risk.units import RESTITUTION, Quantity


@speaks
class RestitutionRule(Protocol):
    """The methods of a relation e(v)."""

    def at(self, speed):
        """e at an approach speed [m/s]."""

    def beyond(self, speed):
        """True for a speed past the range of validity."""


@documented
class Restitution(NamedTuple):
    """e(v) = c0 + c1 v + c2 v² + c3 v³ for approach speeds v up to ``fastest`` [m/s], held beyond it.

    A constant is the polynomial of degree zero, so that one compiled kernel serves both.

    >>> round(CONCRETE.at(0.5), 4)
    0.683
    """

    c0: Annotated[float, Quantity("1", 0.0, 1.0, "restitution of the gentlest touch")]
    c1: Annotated[float, Quantity("s/m", -inf, inf, "linear coefficient")] = 0.0
    c2: Annotated[float, Quantity("s^2/m^2", -inf, inf, "quadratic coefficient")] = 0.0
    c3: Annotated[float, Quantity("s^3/m^3", -inf, inf, "cubic coefficient")] = 0.0
    fastest: Annotated[float, Quantity("m/s", 0.0, inf, "largest approach speed of the fit")] = inf

    def at(self, speed):
        v = min(speed, self.fastest)
        return self.c0 + v * (self.c1 + v * (self.c2 + v * self.c3))

    def beyond(self, speed):
        return speed > self.fastest


# Concrete on concrete: the 2011 paper's equation (4), after Jankowski (2010). The cubic falls steeply past
# 5 m/s and reaches zero at 7.10 m/s, which is an artefact of the fit: e is held at e(5 m/s) = 0.393.
CONCRETE = Restitution(0.7929, -0.2529, 0.0696, -0.0070, 5.0)

NAMED = {"concrete": CONCRETE}


def constant(e: float) -> Restitution:
    """The relation with the same e at every approach speed.

    Parameters
    ----------
    e : float
        Coefficient of restitution.

    Returns
    -------
    Restitution
        A polynomial of degree zero.

    Raises
    ------
    ValueError
        For an e outside (0, 1].
    """
    if not RESTITUTION.allows(e):
        raise ValueError(f"coefficient of restitution {e:.15g}: it must lie in (0, 1]; concrete is usually 0.5 to 0.75")
    return Restitution(float(e))
