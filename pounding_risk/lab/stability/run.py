"""Hard cases found in the modules of `cases`, and run under the contact laws."""

from __future__ import annotations

import re
from collections.abc import Iterable
from importlib import import_module
from math import nan
from pkgutil import iter_modules
from time import perf_counter

from pounding_risk._common.progress import Progress
from pounding_risk.errors import PoundingError
from pounding_risk.lab.stability import cases
from pounding_risk.lab.stability.case import Case, Group, Row
from pounding_risk.lab.stability.trial import RowTrial, Trial
from pounding_risk.models.contact.impulsive import INSTANT_LAWS, is_instant, only_in_pairs
from pounding_risk.models.contact.laws import SHIPPED
from pounding_risk.scene.interfaces import known_law
from pounding_risk.solver.counters import STATUS_SENTENCES
from pounding_risk.units import RTOL


def _declared() -> tuple[Case, ...]:
    """Cases of all modules: groups in the order of their first numbers, each in that of its numbers ("8", "8b")."""

    def place(case: Case) -> tuple[int, str]:
        integer, letter = re.fullmatch(r"(\d+)([a-z]?)", case.number).groups()  # type: ignore[union-attr]
        return int(integer), letter

    modules = (import_module(f"{cases.__name__}.{module.name}") for module in iter_modules(cases.__path__))
    groups = [each for module in modules for each in vars(module).values() if isinstance(each, Group)]
    in_order = [sorted(group.cases, key=place) for group in groups]
    return tuple(case for group in sorted(in_order, key=lambda group: place(group[0])) for case in group)


CASES = _declared()


def stability(
    rtol: float = 1e-6,
    law: Iterable[str] | None = None,
    case: Iterable[str] | None = None,
    progress: Progress | None = None,
    *,
    rows: bool = False,
) -> list[Row]:
    """Run the hard cases, and by how much their bounds hold.

    Parameters
    ----------
    rtol : float
        Relative tolerance of the solver, 1e-12 to 1e-2.
    law : iterable of str, optional
        Names of contact laws of the package; all by default.
    case : iterable of str, optional
        Numbers of cases, such as "8b"; all by default.
    progress : callable, optional
        Called after each case with the number of rows done and of all rows.
    rows : bool
        Run each case also by the solver of rows, as a row of two single masses, where that has what the case needs.

    Returns
    -------
    list of Row
        One row for each case and each of its contact laws: the measured figure (dimensionless), its bound, the
        status of the runs, the steps and the time [s] they took.

    Raises
    ------
    PoundingError
        If the tolerance is out of its range, or a law or a case is not known.
    """
    if not RTOL.allows(rtol):
        raise PoundingError(f"rtol is {rtol:g}; it must lie between {RTOL.low:g} and {RTOL.high:g}, usually 1e-6")
    shipped = (*SHIPPED, *INSTANT_LAWS)
    laws = shipped if law is None else tuple(dict.fromkeys(law))
    for name in laws:
        known_law(name)
        if name not in shipped:
            raise PoundingError(
                f"{name} is a law of your own, and what the hard cases must keep is known for those of the package; "
                f"choose among {', '.join(shipped)}"
            )
    by_number = {case.number: case for case in CASES}
    numbers = tuple(by_number if case is None else dict.fromkeys(case))
    if missing := [number for number in numbers if number not in by_number]:
        raise PoundingError(f"{missing[0]!r} is not the number of a hard case; it may be {', '.join(by_number)}")
    work = [(by_number[number], name) for number in numbers for name in by_number[number].laws if name in laws]
    outcomes: list[Row] = []
    for one, name in work:
        outcome = measured(one, Trial(name, rtol))
        outcomes.append(outcome._replace(in_row=measured_in_row(one, name, rtol)) if rows else outcome)
        if progress is not None:
            progress(len(outcomes), len(work))
    return outcomes


def measured_in_row(case: Case, law: str, rtol: float) -> Row | None:
    """Run one case by the solver of rows; None where that does not have the law, or nothing of what the case needs."""
    if is_instant(known_law(law)) and only_in_pairs(known_law(law)):
        return None
    trial = RowTrial(law, rtol)
    outcome = measured(case, trial)
    return outcome if trial.runs else None


def measured(case: Case, trial: Trial) -> Row:
    """Run one case by a trial, and read the clock."""
    start = perf_counter()
    try:
        figure, status = float(case.figure(trial)), STATUS_SENTENCES[trial.status]
    except PoundingError as error:  # an isolated impact that fails has no status, it raises its sentence
        figure, status = nan, str(error)
    return Row(case, trial.name, figure, case.bound.at(trial.rtol), status, trial.steps, perf_counter() - start)
