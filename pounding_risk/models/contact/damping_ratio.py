"""The coefficient of restitution e from a law's damping ratio ξ, which papers give in its place.

Each is the closed inverse of the relation ξ(e) under which the law was published.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from math import exp, pi, sqrt

from pounding_risk.units import Quantity, QuantityError, parse, shown

WRITTEN = re.compile(r"(?:xi|ξ)\s*=?\s*(?P<ratio>\S+)(?:\s+of\s+(?P<law>\S+))?")
EXAMPLE = '"xi 0.35 of jankowski"'


def _kelvin_voigt(ratio: float) -> float:
    """e = exp(−π ξ / sqrt(1 − ξ²)), from ξ = −ln e / sqrt(π² + ln² e); Anagnostopoulos (1988)."""
    return exp(-pi * ratio / sqrt(1.0 - ratio * ratio))


def _modified_kelvin_voigt(ratio: float) -> float:
    """The root in (0, 1] of (ξ (π − 2) + 1) e² + 2 ξ e − 1 = 0; Mahmoud and Jankowski (2011)."""
    return _positive_root(ratio * (pi - 2.0) + 1.0, ratio, 1.0)


def _jankowski(ratio: float) -> float:
    """The root in (0, 1] of (ξ (9π − 16) + 9√5/2) e² + 16 ξ e − 9√5/2 = 0; Jankowski (2006)."""
    full = 4.5 * sqrt(5.0)
    return _positive_root(ratio * (9.0 * pi - 16.0) + full, 8.0 * ratio, full)


def _positive_root(square: float, half: float, constant: float) -> float:
    """The positive root of square e² + 2 half e − constant = 0, without a difference of like numbers."""
    return constant / (half + sqrt(half * half + square * constant))


INVERSES: dict[str, Callable[[float], float]] = {
    "kelvin_voigt": _kelvin_voigt,
    "kelvin_voigt_tension_cut": _kelvin_voigt,
    "modified_kelvin_voigt": _modified_kelvin_voigt,
    "jankowski": _jankowski,
    "viscous_elastoplastic": _jankowski,
}


def restitution_of_ratio(ratio: float, law: str) -> float:
    """The coefficient of restitution at which a law has a damping ratio.

    Parameters
    ----------
    ratio : float
        Damping ratio ξ of the contact: at least 0, and below 1 for the Kelvin-Voigt laws.
    law : str
        Name of a contact model whose damping is published as ξ(e).

    Returns
    -------
    float
        e in (0, 1].

    Raises
    ------
    QuantityError
        For a law without a ratio, and a ratio out of range.
    """
    if law not in INVERSES:
        known = ", ".join(INVERSES)
        raise QuantityError(f"{law} has no damping ratio ξ; it may be of {known}, or write e itself")
    below_one = INVERSES[law] is _kelvin_voigt
    words = f"damping ratio ξ of {law}"
    limits = Quantity("1", 0.0, 1.0 if below_one else 1e6, words, open_high=below_one, example=EXAMPLE)
    restitution = INVERSES[law](parse(ratio, limits))
    if not restitution > 0.0:
        raise QuantityError(f"ξ = {ratio:g} of {law} leaves no rebound at all; write a smaller ratio")
    return restitution


def is_ratio(text: object) -> bool:
    """Whether a text is meant as a damping ratio: it begins with xi or ξ."""
    return isinstance(text, str) and re.match(r"\s*(xi|ξ)\b", text) is not None


def written_ratio(text: str) -> tuple[float, str]:
    """The e of a text such as "xi 0.35 of jankowski", and words that say where e is from.

    Raises
    ------
    QuantityError
        For text of another form, and as `restitution_of_ratio`.
    """
    match = WRITTEN.fullmatch(text.strip())
    if match is None or match["law"] is None:
        raise QuantityError(f"{shown(text)} does not say the damping ratio of which law; write such as {EXAMPLE}")
    ratio = parse(match["ratio"], Quantity("1", 0.0, float("inf"), "damping ratio ξ", example=EXAMPLE))
    restitution = restitution_of_ratio(ratio, match["law"])
    return restitution, f"{restitution:.6g}, from ξ = {ratio:g} of {match['law']}"
