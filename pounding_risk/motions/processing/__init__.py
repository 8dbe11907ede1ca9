"""The processing of a record: what a step is, the registry that finds every step, and the chain for raw records.

A step takes samples [m/s²] and the time step [s] and returns new samples with a sentence that says what was done.
A scene or a script names steps, ``[{"step": "mean"}, {"step": "bandpass", "low": "0.1 Hz"}]``, and
`read_steps` turns that into steps with options in SI. To add a step is to write one function under ``@step`` in a
module of this folder, a new one or the one of its family; nothing else lists it.

No step scales. Scaling comes last, in `pounding_risk.motions.read`, on the samples that a run takes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import inf
from typing import Any, NamedTuple

from pounding_risk._common.plugins import Registry
from pounding_risk._common.words import nearest
from pounding_risk.errors import RecordError
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.units import Quantity, QuantityError, exact, shown, si, unknown

ORDER = Quantity("1", 1.0, 20.0, "order", example="5")
DRIFT_OF_PEAK = 0.05  # |d_end|/PGD and |v_end|/PGV above this are flagged


class Done(NamedTuple):
    """The result of a step: samples, a sentence, doubts, and what it changed beside the samples.

    ``cut`` is the number of samples cut from the start, below zero where samples were added before it. ``dt`` [s] is
    the new time step, None where it stays. ``factor`` is what a scaling multiplied the samples by. ``band`` [Hz] holds
    the corners of a filter, 0 and inf for none.
    """

    samples: Samples
    sentence: str
    flags: tuple[str, ...] = ()
    cut: int = 0
    dt: float | None = None
    factor: float = 1.0
    band: tuple[float, float] = (0.0, inf)


class Step(NamedTuple):
    """A step as it is requested: its name and its options in SI, which never change."""

    name: str
    options: Mapping[str, Any]

    def __hash__(self) -> int:
        return hash((self.name, frozenset(self.options.items())))

    def apply(self, samples: Samples, dt: float) -> Done:
        """Apply the step to ``samples`` [m/s²] with the time step ``dt`` [s]."""
        return known_steps()[self.name].function(samples, dt, **self.options)

    def written(self) -> dict[str, Any]:
        """The table as a scene file has it: quantities as text, exact."""
        kinds = known_steps()[self.name].options
        written = {
            key: exact(option, kind) if isinstance(kind := kinds[key], Quantity) else option
            for key, option in self.options.items()
        }
        return {"step": self.name, **written}


class Known(NamedTuple):
    """A step of the registry: its function and, for each option, a Quantity or the words it may be."""

    function: Callable[..., Done]
    options: dict[str, Quantity | tuple[str, ...]]


_REGISTRY = Registry("steps", arrange=sorted, folder=__name__)
# What "auto" does to a raw record. No step of it needs a choice by the user; each says what field practice it follows.
DEFAULT_CHAIN: tuple[Step, ...] = tuple(Step(name, {}) for name in ("mean", "taper", "bandpass", "baseline"))


def step(name: str, **options: Quantity | tuple[str, ...]) -> Callable[[Callable[..., Done]], Callable[..., Done]]:
    """Enter a function in the registry under ``name``, with the options it takes."""

    def enter(function: Callable[..., Done]) -> Callable[..., Done]:
        _REGISTRY.enter(name, Known(function, options), function.__module__)
        return function

    return enter


def known_steps() -> Mapping[str, Known]:
    """List the processing steps of all modules of this folder, of plug-ins, and those of a user's script.

    Returns
    -------
    mapping of str to Known
        Function and options of each step by its name, in alphabetical order.
    """
    return _REGISTRY


def read_steps(tables: Sequence[Mapping[str, Any] | Step]) -> tuple[Step, ...]:
    """Read the steps of a list of tables.

    Parameters
    ----------
    tables : sequence of mapping or Step
        Tables with the key ``step``, and options as text with a unit or SI numbers; a step is taken as it is.

    Returns
    -------
    tuple of Step
        The steps with their options in SI.

    Raises
    ------
    RecordError
        For an unknown step or option, and for a value that an option cannot take.
    """
    return tuple(_read_step(f"processing, step {number}", table) for number, table in enumerate(tables, start=1))


def _read_step(where: str, table: Mapping[str, Any] | Step) -> Step:
    if isinstance(table, Step):
        return table
    if not isinstance(table, Mapping) or "step" not in table:
        raise RecordError(f'{where}: {shown(table)} names no step; write a table such as {{step = "mean"}}')
    name, steps = table["step"], known_steps()
    if not isinstance(name, str) or name not in steps:
        raise RecordError(f"{where}: {unknown(name, 'not a step', steps)}")
    allowed_options = steps[name].options
    options = {}
    for key, option in table.items():
        if key == "step":
            continue
        if key not in allowed_options:
            allowed = f"it takes {', '.join(allowed_options)}" if allowed_options else "it takes none"
            raise RecordError(
                f'{where}: "{name}" has no option {shown(key)}{nearest(str(key), allowed_options)}; {allowed}'
            )
        options[key] = _option(f"{where}, {key}", option, allowed_options[key])
    return Step(name, options)


def _option(where: str, option: Any, kind: Quantity | tuple[str, ...]) -> Any:
    if not isinstance(kind, Quantity):
        if option not in kind:
            words = " or ".join(f'"{word}"' for word in kind)
            raise RecordError(f"{where}: {shown(option)} is not a choice; it may be {words}")
        return option
    try:
        return si(option, kind)
    except QuantityError as error:
        raise RecordError(f"{where}: {error}") from None


def whole(order: float, words: str, least: int) -> int:
    """An order as a whole number; raises RecordError where it is none, or too low."""
    if int(order) != order or order < least:
        raise RecordError(f"the order of {words} is {order:g}; it must be a whole number from {least} to 20")
    return int(order)
