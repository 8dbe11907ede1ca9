"""Units of acceleration: the size of a file's unit in m/s², as the file or the user states it."""

from __future__ import annotations

from pounding_risk.errors import RecordError
from pounding_risk.units import PGA, STANDARD_GRAVITY, QuantityError, parse

LONGEST_UNIT = 40  # characters; parsing a unit takes the square of them
# How a user says the unit of a file that does not; for messages.
TO_GIVE = 'records.unit = "cm/s^2" in a scene, unit="cm/s^2" in Python, --unit "cm/s^2" on the command line'
# The usual ones, for speed and for the capitals that older programs write.
_USUAL = {"g": STANDARD_GRAVITY, "m/s2": 1.0, "cm/s2": 0.01, "mm/s2": 0.001, "gal": 0.01, "Gal": 0.01, "mps2": 1.0}
_SAME = (("sec", "s"), ("²", "2"), ("**", ""), ("^", ""), ("(", ""), (")", ""), (" ", ""), ("/s/s", "/s2"))


def known(unit: str) -> float | None:
    """How many m/s² one of a usual unit of acceleration is, in any usual spelling; None for any other text."""
    spelling = unit.strip()
    spelling = spelling.lower() if spelling.isupper() else spelling
    for written, plain in _SAME:
        spelling = spelling.replace(written, plain)
    return _USUAL.get(spelling)


def size_of(unit: object, where: str) -> float:
    """How many m/s² one ``unit`` is; ``where`` begins the message.

    Raises RecordError for what is no unit of acceleration, "" and counts too.
    """
    size = known(unit) if isinstance(unit, str) else None
    if size is not None:
        return size
    try:
        if len(str(unit)) > LONGEST_UNIT:
            raise QuantityError("no unit is so long")
        return parse(f"1 {unit}", PGA)
    except QuantityError:
        shown = "".join(letter if letter.isprintable() else "?" for letter in str(unit)[:40])
        raise RecordError(
            f'{where}: "{shown}" is not a unit of acceleration; write one such as "g", "cm/s^2" or "m/s^2"'
        ) from None


def sentence(unit: str, size: float) -> str:
    """The sentence on units in the history of a motion: "units: cm/s^2, times 0.01"."""
    return f"units: {unit.strip()}, times {size:.10g}"
