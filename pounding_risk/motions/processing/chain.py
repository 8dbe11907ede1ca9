"""The steps that turn a recorded acceleration into the input of a run: one function each, in one registry.

A step takes samples [m/s²] and the time step [s] and gives new samples and a sentence that says what it did.
A scene or a script asks for steps by name, ``[{"step": "mean"}, {"step": "bandpass", "low": "0.1 Hz"}]``;
`read_steps` turns that into steps with options in SI, or says what is wrong. The functions stand in modules by
kind: `steps_basic` (window, mean, trend, taper), `filtering`, `baseline`, `resampling`. To add a step is to write
one function under ``@step`` in one of them.

Nothing here scales: that comes last, in `pounding_risk.motions.motion`, on the samples that a run really sees.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Any

from pounding_risk.errors import RecordError
from pounding_risk.motions.processing import baseline
from pounding_risk.motions.processing import basic as steps_basic
from pounding_risk.motions.processing import filter as filtering
from pounding_risk.motions.processing import resample as resampling
from pounding_risk.motions.processing.basic import window
from pounding_risk.motions.processing.registry import STEPS, Done, Known, Step, step
from pounding_risk.units import Quantity, QuantityError, shown, si

__all__ = ["DEFAULT_CHAIN", "STEPS", "Done", "Known", "Step", "read_steps", "si", "step", "window"]

MODULES = (steps_basic, filtering, baseline, resampling)  # imported, their steps are known; told in this order
# What "auto" does to a raw record. Nothing in it needs a choice by the user; see field practice in each step.
DEFAULT_CHAIN: tuple[Step, ...] = (
    Step("mean", {}),
    Step("taper", {}),
    Step("bandpass", {}),
    Step("baseline", {}),
)


def read_steps(asked: Sequence[Mapping[str, Any]]) -> tuple[Step, ...]:
    """The steps of a list of tables: the key ``step``, and options as text with a unit or SI numbers.

    Raises RecordError for an unknown step or option, and for a value that an option cannot take.
    """
    return tuple(_read_step(number, table) for number, table in enumerate(asked, start=1))


def _read_step(number: int, table: Mapping[str, Any]) -> Step:
    place = f"processing, step {number}"
    if not isinstance(table, Mapping) or "step" not in table:
        raise RecordError(f'{place}: {shown(table)} names no step; write a table such as {{step = "mean"}}')
    name = table["step"]
    if not isinstance(name, str) or name not in STEPS:
        hint = _meant(name, STEPS)
        raise RecordError(f"{place}: {shown(name)} is not a step{hint}; it may be {', '.join(_names())}")
    known = STEPS[name].options
    options = {}
    for key, value in table.items():
        if key == "step":
            continue
        if key not in known:
            allowed = f"it takes {', '.join(known)}" if known else "it takes none"
            raise RecordError(f'{place}: "{name}" has no option {shown(key)}{_meant(key, known)}; {allowed}')
        options[key] = _option(f"{place}, {key}", value, known[key])
    return Step(name, options)


def _option(place: str, value: Any, kind: Quantity | tuple[str, ...]) -> Any:
    if not isinstance(kind, Quantity):
        if value not in kind:
            words = " or ".join(f'"{word}"' for word in kind)
            raise RecordError(f"{place}: {shown(value)} is not a choice; it may be {words}")
        return value
    try:
        return si(value, kind)
    except QuantityError as error:
        raise RecordError(f"{place}: {error}") from None


def _names() -> list[str]:
    """The steps by name, kind after kind."""
    kinds = [module.__name__ for module in MODULES]
    return sorted(STEPS, key=lambda name: kinds.index(STEPS[name].function.__module__))


def _meant(name: Any, known: Mapping[str, Any]) -> str:
    near = get_close_matches(name, known, 1, 0.6) if isinstance(name, str) else []
    return f' (did you mean "{near[0]}"?)' if near else ""
