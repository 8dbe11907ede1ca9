"""Storeys that yield by a law of their own: a backbone, and a rule of what follows a turn.

A rule is a module here, found by its file: `advance` gives the branch that follows an event, all branches being
straight, so that a run lands on each change; `own_numbers`, `refusal`, `WORDS`, `REFERENCE` and the ``OPTIONS`` of
`Hysteresis` that it takes, and what it is for: storeys, or links between neighbours. `_numbers` has what `advance`
reads and writes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from pounding_risk._jit.calls import ENTERING
from pounding_risk.errors import PoundingError
from pounding_risk.models._discovery import modules_in_order
from pounding_risk.models.structures.hysteresis._numbers import (
    BEGIN,
    COLLAPSE,
    CONSTANT,
    COUNT,
    DRIFT,
    LAST_SLOPE,
    LOWER,
    OWN,
    SHEAR,
    SIZE,
    SLOPE,
    STIFFNESS,
    STRENGTH,
    TURN,
    UNLOADING,
    UPPER,
    VERB,
    WORK,
)

RULES: dict[str, ModuleType] = {module.__name__.rpartition(".")[2]: module for module in modules_in_order(__name__)}
_ENTRIES: dict[str, float] = {}


@dataclass(frozen=True)
class Hysteresis:
    """How the storeys of a building yield, in multiples of each storey's yield drift d_y and yield shear V_y.

    ``backbone`` has the points past yield, each (drift, shear); past the last one the shear stays. Without any it is
    the straight line of ``hardening``. The parameters are those of the rule that has them among its ``OPTIONS``.

    Raises PoundingError for a backbone that no storey has, and for one that the rule is not for.

    >>> Hysteresis("kinematic", ((4.0, 1.15),)).slopes(1.0, (1.0, 4.0), (1.0, 1.15))[-1]
    0.0
    """

    rule: str
    backbone: tuple[tuple[float, float], ...] = ()
    hardening: float = 0.0  # slope over the elastic one, of a storey without a backbone
    pinching_drift: float = 1.0
    pinching_force: float = 1.0
    unloading: float = 0.0
    energy_capacity: float = inf
    energy_exponent: float = 1.0
    exponent: float = 1.0
    beta: float = 0.5
    delta_a: float = 0.0
    delta_nu: float = 0.0
    delta_eta: float = 0.0
    collapse_drift: float = 0.2  # of the storey's height

    def __post_init__(self) -> None:
        points = ((1.0, 1.0), *self.backbone)
        for (drift, shear), (next_drift, next_shear) in pairwise(points):
            if not next_drift > drift or not next_shear > 0.0:
                raise PoundingError(
                    f"backbone: [{next_drift:g}, {next_shear:g}] after [{drift:g}, {shear:g}]; each point has a larger "
                    "drift than the one before it, yield being [1, 1], and a shear above 0"
                )
        drifts, shears = zip(*points, strict=True)
        lacking = RULES[self.rule].refusal(self.slopes(1.0, drifts, shears))
        if lacking:
            raise PoundingError(f"backbone: the rule {self.rule} takes {lacking}")

    def slopes(self, stiffness: float, drifts: Sequence[float], shears: Sequence[float]) -> list[float]:
        """Slope of each piece of a backbone past yield [N/m], that past its last point at the end."""
        pieces = pairwise(zip(drifts, shears, strict=True))
        between = [(after - before) / (stop - start) for (start, before), (stop, after) in pieces]
        return [*between, 0.0 if self.backbone else self.hardening * stiffness]

    def numbers(self, stiffness: float, strength: float, height: float) -> NDArray[np.float64]:
        """The row of numbers of a storey's law, as the solver takes it.

        Parameters
        ----------
        stiffness : float
            Of the storey while it is elastic, without the part of P-Δ [N/m].
        strength : float
            Its yield shear [N].
        height : float
            Of the storey [m].
        """
        points = ((1.0, 1.0), *self.backbone)
        drifts = [drift * strength / stiffness for drift, _ in points]
        shears = [shear * strength for _, shear in points]
        row = np.zeros(OWN)
        row[VERB] = list(RULES).index(self.rule)
        row[COLLAPSE], row[STRENGTH], row[STIFFNESS] = self.collapse_drift * height, 1.0, stiffness
        row[SIZE] = drifts[0]
        row[COUNT], row[LAST_SLOPE] = len(points), self.slopes(stiffness, drifts, shears)[-1]
        return np.append(row, RULES[self.rule].own_numbers(self, stiffness, drifts, shears))


def forces_along(row: NDArray[np.float64], drifts: NDArray[np.float64]) -> NDArray[np.float64]:
    """Forces [N] of a law at drifts [m] that are followed in turn from rest, each straight from the one before.

    Parameters
    ----------
    row : array
        Numbers of the law, as `Hysteresis.numbers` gives them.
    drifts : array, shape (n,)
        Drifts, or displacements between the ends of a link.
    """
    numbers, slots, drift = row.copy(), np.zeros(8), 0.0
    advance = RULES[list(RULES)[int(row[VERB])]].advance
    numbers[UNLOADING] = numbers[STIFFNESS]

    def meet(event: float, at: float) -> None:
        force = numbers[SLOPE] * at + numbers[CONSTANT]
        numbers[WORK] += 0.5 * (numbers[SHEAR] + force) * (at - numbers[DRIFT])
        slots[:3] = event, at, force
        advance(0.0, 0.0, numbers, slots)
        numbers[DRIFT], numbers[SHEAR] = at, slots[0] * at + slots[1]

    meet(BEGIN, 0.0)
    forces = np.zeros(len(drifts))
    for place, target in enumerate(drifts.tolist()):
        side = float(np.sign(target - drift))
        if side == -slots[2] != 0.0:
            meet(TURN, drift)
        while side and side * (target - (end := numbers[UPPER if side > 0.0 else LOWER])) > 0.0:
            meet(side, end)
        drift = target
        forces[place] = slots[0] * drift + slots[1]
    return forces


def called(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rows of `Hysteresis.numbers` with the address of the rule's `advance` in place of its number.

    A rule is compiled at its first use. Rows of storeys without a law are zero, and stay so.
    """
    rows = rows.copy()
    for storey in np.flatnonzero(rows[:, STIFFNESS] > 0.0) if rows.size else ():
        rows[storey, VERB] = _entry_of(list(RULES)[int(rows[storey, VERB])])
    return rows


def _entry_of(rule: str) -> float:
    with ENTERING:
        if rule not in _ENTRIES:
            out = np.zeros(1)
            RULES[rule].write_entry(out)
            _ENTRIES[rule] = float(out[0])
        return _ENTRIES[rule]
