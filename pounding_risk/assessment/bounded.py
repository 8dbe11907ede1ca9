"""Variables of a dataset with both their bounds: ``NAME``, ``NAME_low`` and ``NAME_high``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pounding_risk.results.variables import described

ENDS = {"": "", "_low": "lower bound: ", "_high": "upper bound: "}


def bounded(name: str, dims: Any, values: Iterable[Any], unit: str, words: str) -> dict[str, Any]:
    """Three variables, of a value, its lower and its upper bound."""
    pairs = zip(ENDS.items(), values, strict=True)
    return {f"{name}{end}": (dims, column, described(unit, f"{bound}{words}")) for (end, bound), column in pairs}
