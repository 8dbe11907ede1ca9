"""Hard cases: what one is, how a module declares it, and the outcome of one case under one contact law."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial, update_wrapper
from typing import Any, NamedTuple

from pounding_risk.lab.stability.trial import Trial, TrialScene
from pounding_risk.models.contact.impulsive import INSTANT_LAWS
from pounding_risk.models.contact.law import is_path_dependent
from pounding_risk.models.contact.laws import LAWS, SHIPPED
from pounding_risk.solver.counters import COMPLETE, STATUS_SENTENCES
from pounding_risk.solver.row.model import RowModel

# Contact laws that a case can be put to: those with a force, and also those whose velocities jump.
FORCES = SHIPPED
ALL = (*FORCES, *INSTANT_LAWS)
CAPPED = tuple(name for name in FORCES if LAWS[name].capped)
DAMPED = tuple(name for name in FORCES if LAWS[name].needs_restitution)
LINEAR = tuple(name for name in FORCES if Trial(name, 1e-6).is_linear)
HERTZ = tuple(name for name in FORCES if name not in LINEAR)
# A law that remembers its path rests where the path leaves it, and its corners are stepped over, not landed on.
PATH = tuple(name for name in FORCES if is_path_dependent(LAWS[name]))
POTENTIAL = tuple(name for name in FORCES if name not in PATH)
ONE = ("jankowski",)  # for cases without contact

ENERGY = "energy closes, nothing pulls, all is finite"


class Bound(NamedTuple):
    """The largest figure that a case may have: ``fixed`` + ``times`` × rtol, and why."""

    fixed: float
    times: float
    why: str

    def at(self, rtol: float) -> float:
        """The bound at a tolerance."""
        return self.fixed + self.times * rtol


BITS = Bound(0.0, 0.0, "exact: to the last bit")
LEDGER = Bound(1e-11, 10.0, "two hundred steps of 0.05 rtol each, should all err alike; rounding")


class Case(NamedTuple):
    """One hard case. ``figure`` runs it and returns by how much, without a unit, the invariant is missed."""

    number: str
    group: str
    scene: str
    invariant: str
    figure: Callable[[Trial], float]
    bound: Bound
    laws: tuple[str, ...]


Figure = Callable[..., float]


class Group:
    """Hard cases of one kind, as the module that holds this object declares them."""

    def __init__(self, name: str):
        self.name = name
        self.cases: list[Case] = []

    def case(
        self, number: str, scene: str, invariant: str, bound: Bound, laws: tuple[str, ...] = ALL, /, **arguments: Any
    ) -> Callable[[Figure], Figure]:
        """Declare the decorated function, with these further arguments, to measure a case."""

        def declare(function: Figure) -> Figure:
            figure = update_wrapper(partial(function, **arguments), function)
            self.cases.append(Case(number, self.name, scene, invariant, figure, bound, laws))
            return function

        return declare

    def energy(self, number: str, words: str, scene: TrialScene, laws: tuple[str, ...] = ALL) -> None:
        """Declare a case of one run, of which `Trial.unsound` measures the energy."""
        self.case(number, words, ENERGY, LEDGER, laws, scene=scene)(unsound)

    def energy_of_row(self, number: str, words: str, row: RowModel, gap: float) -> None:
        """As `energy`, of a row whose interfaces have one gap [m]."""
        self.case(number, words, ENERGY, LEDGER, FORCES, row=row, gap=gap)(Trial.unsound_row)


def unsound(trial: Trial, scene: TrialScene) -> float:
    """Energy that one run leaves unaccounted for, over its largest energy; infinite where the run is not sound."""
    return trial.unsound(trial.solve(scene))


class Row(NamedTuple):
    """Outcome of one case under one law. ``seconds`` counts the compiling of a law that was not used before.

    ``in_row`` is that of the same runs by the solver of rows, None where rows were not run or have none of them.
    """

    case: Case
    law: str
    figure: float
    bound: float
    status: str
    steps: int
    seconds: float
    in_row: Row | None = None

    @property
    def holds(self) -> bool:
        """True where the runs ended as they should and the figure, a number, keeps its bound."""
        return self.status == STATUS_SENTENCES[COMPLETE] and self.figure <= self.bound
