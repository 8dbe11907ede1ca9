"""The coefficient of restitution e from a law's damping ratio ξ, which papers give in its place.

Each law's inverse of the relation ξ(e) under which it was published stands beside the law.
"""

from __future__ import annotations

import re

from pounding_risk.models.contact.laws import RESTITUTION_OF_RATIO
from pounding_risk.units import Quantity, QuantityError, parse, shown

WRITTEN = re.compile(r"(?:xi|ξ)\s*=?\s*(?P<ratio>\S+)(?:\s+of\s+(?P<law>\S+))?")
EXAMPLE = '"xi 0.35 of jankowski"'


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
    if law not in RESTITUTION_OF_RATIO:
        known = ", ".join(RESTITUTION_OF_RATIO)
        raise QuantityError(f"{law} has no damping ratio ξ; it may be of {known}, or write e itself")
    function, largest = RESTITUTION_OF_RATIO[law]
    words = f"damping ratio ξ of {law}"
    limits = Quantity("1", 0.0, largest, words, open_high=largest == 1.0, example=EXAMPLE)
    restitution = function(parse(ratio, limits))
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
