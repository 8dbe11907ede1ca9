"""What the commands are given: options with units, files to write, contact laws by name; checked before any work."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pounding_risk.errors import PoundingError

if TYPE_CHECKING:
    from pounding_risk.quantities import Quantity

PER_STIFFNESS = {"N/m": "k", "N/m^1.5": "β"}


def read(option: str, text: str, quantity: Quantity) -> float:
    """The SI value of an option's text."""
    from pounding_risk.quantities import QuantityError, parse

    try:
        return parse(text, quantity)
    except QuantityError as error:
        raise PoundingError(f"{option}: {error}") from None


def target(option: str, path: Path | None, suffixes: tuple[str, ...]) -> Path | None:
    """A file that can be written, checked before any work is done."""
    if path is None:
        return None
    from pounding_risk.results import check_target

    if not path.name:
        raise PoundingError(f"{option}: {str(path)!r} is not the name of a file; write one that ends in {suffixes[0]}")
    try:
        return check_target(path, suffixes)
    except PoundingError as error:
        raise PoundingError(f"{option}: {error}") from None


def check_folder(folder: Path) -> None:
    """A folder that is there or can be made."""
    existing = next(each for each in (folder, *folder.absolute().parents) if each.exists())
    if not existing.is_dir():
        raise PoundingError(f"--out: {existing} is a file, not a folder; choose another name")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise PoundingError(f"--out: the folder {existing} cannot be written to; choose another one")


def laws(
    names: Sequence[str], stiffnesses: Sequence[str], blow: tuple[float, float, Any]
) -> tuple[list[Any], list[str]]:
    """The laws of these names; a stiffness of the kind that is not given follows from an equal peak force."""
    from pounding_risk.collision import equal_stiffness
    from pounding_risk.models.contact import stiffness_quantity
    from pounding_risk.quantities import say
    from pounding_risk.study import known_law

    classes = {name: known_law(name) for name in dict.fromkeys(names)}
    given = _stiffnesses(stiffnesses)
    laws, notes = [], []
    for name, law in classes.items():
        quantity = stiffness_quantity(law)
        if quantity.unit in given:
            laws.append(law(given[quantity.unit]))
            continue
        ((unit, value),) = given.items()
        usual = {"N/m": "linear", "N/m^1.5": "jankowski"}[unit]
        like = next((other for other in classes if stiffness_quantity(classes[other]).unit == unit), usual)
        laws.append(law(equal_stiffness(law, known_law(like)(value), *blow, "peak force")))
        words = say(laws[-1].stiffness, quantity)
        notes.append(f"{name}: {PER_STIFFNESS[quantity.unit]} = {words}, which gives the peak force of {like} uncapped")
    return laws, notes


def _stiffnesses(texts: Sequence[str]) -> dict[str, float]:
    """The value of each unit of stiffness that is given."""
    from pounding_risk.models.contact import HERTZ_STIFFNESS, LINEAR_STIFFNESS
    from pounding_risk.quantities import QuantityError, parse

    given: dict[str, float] = {}
    for text in texts:
        try:
            unit, value = LINEAR_STIFFNESS.unit, parse(text, LINEAR_STIFFNESS)
        except QuantityError:
            unit, value = HERTZ_STIFFNESS.unit, read("--stiffness", text, HERTZ_STIFFNESS)
        if unit in given:
            raise PoundingError(f"--stiffness: two values in {unit}; give one of each unit at most")
        given[unit] = value
    return given
