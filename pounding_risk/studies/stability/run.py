"""Running the table of hard cases."""

from __future__ import annotations

from collections.abc import Iterable
from math import nan
from time import perf_counter

from pounding_risk._common.progress import Progress
from pounding_risk.errors import PoundingError
from pounding_risk.models.contact.impulsive import INSTANT_LAWS
from pounding_risk.models.contact.laws import SHIPPED
from pounding_risk.scene.scene import known_law
from pounding_risk.solver.counters import STATUS_SENTENCES
from pounding_risk.studies.stability.case import Case, Row
from pounding_risk.studies.stability.table import CASES
from pounding_risk.studies.stability.trial import Trial
from pounding_risk.units import RTOL


def stability(
    rtol: float = 1e-6,
    law: Iterable[str] | None = None,
    case: Iterable[str] | None = None,
    progress: Progress | None = None,
) -> list[Row]:
    """Run the hard cases at a tolerance and say what holds: one row for each case and contact law.

    ``law`` and ``case`` pick laws by name and cases by number; all by default. ``progress`` is called with (rows
    done, rows in all). Raises PoundingError for a tolerance outside 1e-12 to 1e-2, an unknown law or case.
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
    work = [(each, name) for each in picked(case) for name in each.laws if name in laws]
    rows = []
    for each, name in work:
        rows.append(measured(each, name, rtol))
        if progress is not None:
            progress(len(rows), len(work))
    return rows


def picked(numbers: Iterable[str] | None) -> tuple[Case, ...]:
    """The cases of these numbers; raises PoundingError for one that there is not."""
    known = {case.number: case for case in CASES}
    wanted = tuple(known if numbers is None else dict.fromkeys(numbers))
    missing = [number for number in wanted if number not in known]
    if missing:
        raise PoundingError(f"{missing[0]!r} is not the number of a hard case; it may be {', '.join(known)}")
    return tuple(known[number] for number in wanted)


def measured(case: Case, law: str, rtol: float) -> Row:
    """One case under one law."""
    trial, start = Trial(law, rtol), perf_counter()
    try:
        figure, status = float(case.figure(trial)), STATUS_SENTENCES[trial.status]
    except PoundingError as error:  # an isolated impact that fails has no status, it raises its sentence
        figure, status = nan, str(error)
    return Row(case, law, figure, case.bound.at(rtol), status, trial.steps, perf_counter() - start)
