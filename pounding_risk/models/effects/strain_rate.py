"""Dynamic increase of the yield force with the strain rate."""

from __future__ import annotations

from math import inf, isnan, nan
from typing import Any, NamedTuple

from pounding_risk.errors import PoundingError
from pounding_risk.models.effects import effect
from pounding_risk.units import Quantity

ORDER = 10  # the first to wrap a law: it is the yield force after hardening that leaves an indentation
LENGTH = Quantity("m", 0.0, inf, "length over which the impact deforms", open_low=True, open_high=True, example="0.6 m")
STRENGTH = Quantity("Pa", 8e6, 130e6, "mean concrete strength f_cm", example="30 MPa")
# Strain rates of the codes' formulas [1/s]: where hardening begins in compression, and where it steepens.
QUASI_STATIC, FAST = 30e-6, 30.0


@effect(
    reference="CEB-FIP Model Code 1990 and fib Model Code 2010: concrete under high strain rates, compression",
    options={"code": ("mc1990", "mc2010"), "length": LENGTH, "strength": STRENGTH},
    absent={"strength": "none (code mc1990 needs one)"},
)
class StrainRate(NamedTuple):
    """Dynamic increase of the yield force: F_E × DIF(ε̇), ε̇ = approach speed / length at the touch.

    DIF = (ε̇/ε̇0)^a up to 30/s, b (ε̇/ε̇0)^(1/3) above, ε̇0 = 30e-6/s; 1 below. CEB-FIP Model Code 1990: a = 1.026 α,
    b = 10^(6.156 α − 2), α = 1 / (5 + 0.9 f_cm), f_cm in MPa. fib Model Code 2010: a = 0.014, b = 0.012. Concrete in
    compression. At 0.5 m/s over 0.6 m the codes give factors of 1.39 (f_cm 30 MPa) and 1.15: the choice matters.

    >>> round(StrainRate.on(None, code="mc2010", length=0.6).hardening(0.5), 3)
    1.154
    """

    law: Any
    length: float  # m
    rise: float  # a
    far: float  # b

    @classmethod
    def on(cls, law: Any, code: str, length: float, strength: float = nan) -> StrainRate:
        """The law with this hardening; ``length`` [m], ``strength`` f_cm [Pa].

        Raises PoundingError where Model Code 1990 is given no strength.
        """
        if code == "mc1990":
            if isnan(strength):
                raise PoundingError('strain_rate: code mc1990 asks for the concrete; write strength = "30 MPa"')
            alpha = 1.0 / (5.0 + 0.9 * strength / 1e6)
            return cls(law, length, 1.026 * alpha, 10.0 ** (6.156 * alpha - 2.0))
        return cls(law, length, 0.014, 0.012)

    def hardening(self, speed):
        rate = speed / self.length / QUASI_STATIC
        if rate <= 1.0:
            return 1.0
        return rate**self.rise if rate * QUASI_STATIC <= FAST else self.far * rate ** (1.0 / 3.0)
