"""What a processing step is, and the registry that every step enters.

`pounding_risk.motions.processing.chain` reads and lists them.

A step takes samples [m/s²] and the time step [s] and gives new samples and a sentence that says what it did. To add one
is to write one function under ``@step``, in the module that holds its kind.
"""

from __future__ import annotations

from collections.abc import Callable
from math import inf
from typing import Any, NamedTuple

from pounding_risk.errors import RecordError
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.units import Quantity

ORDER = Quantity("1", 1.0, 20.0, "order", example="5")
DRIFT_OF_PEAK = 0.05  # |d_end|/PGD and |v_end|/PGV above this are flagged


class Done(NamedTuple):
    """What a step gives: samples, its sentence, doubts, how many samples it cut from the start, and its time step.

    ``cut`` is below zero where samples were added before the start; ``dt`` [s] is None where it stays as it was;
    ``factor`` is what a scaling multiplied them by; ``band`` [Hz] are the corners of a filter, 0 and inf for none.
    """

    samples: Samples
    sentence: str
    flags: tuple[str, ...] = ()
    cut: int = 0
    dt: float | None = None
    factor: float = 1.0
    band: tuple[float, float] = (0.0, inf)


class Step(NamedTuple):
    """A step asked for: its name and its options in SI."""

    name: str
    options: dict[str, Any]

    def apply(self, samples: Samples, dt: float) -> Done:
        """The step done to ``samples`` [m/s²] at every ``dt`` [s]."""
        return STEPS[self.name].function(samples, dt, **self.options)


class Known(NamedTuple):
    """A step of the registry: its function and, for each option, a Quantity or the words it may be."""

    function: Callable[..., Done]
    options: dict[str, Quantity | tuple[str, ...]]


STEPS: dict[str, Known] = {}


def step(name: str, **options: Quantity | tuple[str, ...]) -> Callable[[Callable[..., Done]], Callable[..., Done]]:
    """Enter a function in the registry under ``name``, with the options it takes."""

    def enter(function: Callable[..., Done]) -> Callable[..., Done]:
        STEPS[name] = Known(function, options)
        return function

    return enter


def whole(order: float, words: str, least: int) -> int:
    """An order as a whole number; raises RecordError where it is none, or too low."""
    if int(order) != order or order < least:
        raise RecordError(f"the order of {words} is {order:g}; it must be a whole number from {least} to 20")
    return int(order)
