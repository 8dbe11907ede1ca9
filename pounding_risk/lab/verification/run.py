"""The runs of published cases, their comparison with ours, and the words of acceptance of engineers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from math import floor, inf, isfinite, log10, nan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk._common.progress import Progress
from pounding_risk._common.short_repr import ShortRepr
from pounding_risk._common.words import nearest
from pounding_risk.errors import PoundingError
from pounding_risk.lab.verification import contacts, noise, pulses
from pounding_risk.lab.verification.case import INPUT, KINDS, Case, Collision, Published, read_case, shipped
from pounding_risk.lab.verification.measures import MODAL, Solved, force_curve, history
from pounding_risk.lab.verification.property import Property
from pounding_risk.motions.read import read_motion
from pounding_risk.studies.impact import impact
from pounding_risk.studies.modes import modes
from pounding_risk.studies.simulate import simulate
from pounding_risk.units import GAP, MISSING, PERIOD, TIME, rounded, say

EXACT, ACCEPTABLE, UNACCEPTABLE = "exact", "acceptable", "unacceptable"
RUNGS = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)  # tolerances of the solver; ours is the value at the last
FINER = (1, 1, 1, 2, 4, 8)  # by rung: how many times as many samples a generated motion has as in its case
DEFAULT_RUNG = 1e-6  # from which on the values show how far ours has converged
DIGITS = 6  # of ours that tables show: what agrees in all of them is exact
FAR = 10.0  # a difference so many times what ours changes by is not ours
COMPLETE = "complete"  # status of a run that reached its end
# The published relations that `verify` checks beside the cases, by name.
PROPERTIES: Mapping[str, Callable[[], Property]] = {
    relation.__name__: relation
    for relation in (
        *(contacts.isolated_impacts, contacts.kelvin_voigt_laws, contacts.twins_and_wall, contacts.plateaus),
        *(contacts.yielding_contact, pulses.self_similarity, noise.double_difference, noise.first_passage),
    )
}


class Check(NamedTuple):
    """One published value beside ours; all numbers in SI."""

    case: str
    title: str
    source: str  # in a few words
    kind: str  # one of `KINDS`
    quantity: str  # and what selects it
    unit: str
    printed: str  # the value as it is printed
    published: float  # the same in SI
    printed_unit: str
    size: float  # of the unit in which it is printed
    within: float  # half a unit of its last digit, at least of the sixth digit
    uncertainty: float  # reading error or scatter, 0 where none is stated
    ours: float  # where the source's axis and origin are other than ours in the source's
    rungs: tuple[float, ...]  # ours at the tolerances `RUNGS`, of which ours is the last; empty without a tolerance
    word: str  # "exact", "acceptable" or "unacceptable"
    limit: float  # share of the published value up to which a difference is acceptable
    note: str  # why ours may differ, by the case

    @property
    def difference(self) -> float:
        """Ours less the published value, as a share of that; of zero the difference itself over zero, ±inf."""
        difference = self.ours - self.published
        if self.published:
            return difference / abs(self.published)
        return float(np.copysign(inf, difference)) if difference else 0.0

    @property
    def change(self) -> float:
        """How far ours moves between the default tolerance and the finest; NaN without a tolerance.

        A share of the largest of these values and the published one, so that a value of zero has a change too: 0 where
        all are zero. The samples of generated motions become finer with it, see `FINER`.
        """
        fine = [value for rtol, value in zip(RUNGS, self.rungs, strict=False) if rtol <= DEFAULT_RUNG]
        largest = max(map(abs, (self.published, *fine)))
        return (max(fine) - min(fine)) / (largest or 1.0) if fine else nan

    @property
    def is_converged(self) -> bool:
        """True where the difference is not of our solver or samples: ours moves by less than a tenth of it."""
        return bool(self.rungs) and FAR * self.change < abs(self.difference)


class Point(NamedTuple):
    """A published value on a curve; SI."""

    x: float
    y: float
    uncertainty: float  # 0 where none is stated
    kind: str
    ours: float


class Curve(NamedTuple):
    """A curve of ours, and the published points on it; SI."""

    case: str
    title: str
    source: str
    axes: tuple[str, str]  # what is along x and along y
    units: tuple[str, str]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    points: tuple[Point, ...]


@dataclass(frozen=True, repr=False)
class Verification(ShortRepr):
    """Published cases with the values that this program gives, and their differences."""

    checks: tuple[Check, ...]
    cases: tuple[Case, ...]
    curves: tuple[Curve, ...]
    properties: tuple[Property, ...] = ()

    @property
    def failing(self) -> tuple[Property, ...]:
        """The published relations that ours does not keep."""
        return tuple(one for one in self.properties if not one.holds)

    @property
    def unacceptable(self) -> tuple[Check, ...]:
        """The values that ours does not reach."""
        return tuple(check for check in self.checks if check.word == UNACCEPTABLE)

    @property
    def sources(self) -> tuple[str, ...]:
        """The sources, each once, in the order of the cases."""
        return tuple(dict.fromkeys(check.source for check in self.checks))

    def finding(self) -> str:
        """How many values there are, exact, acceptable or unacceptable, and of each kind; how many properties hold.

        Inputs that a source prints as if they were results, such as the specified e of a law, are not counted
        among the values.
        """
        clauses = []
        if self.checks:
            checks = [check for check in self.checks if check.kind != INPUT]
            counts = {word: sum(check.word == word for check in checks) for word in (EXACT, ACCEPTABLE, UNACCEPTABLE)}
            words = ", ".join(f"{count} {word}" for word, count in counts.items())
            sources = counted(len({check.source for check in checks}), "source")
            clauses.append(f"{counted(len(checks), 'published value')} of {sources}: {words}")
            of_kind = Counter(check.kind for check in checks)
            kinds = [counted(of_kind[name], kind.one, kind.several) for name, kind in KINDS.items() if of_kind[name]]
            if kinds:
                clauses.append(f"by kind: {', '.join(kinds)}")
            inputs = [check for check in self.checks if check.kind == INPUT]
            if inputs:
                far = sum(check.word == UNACCEPTABLE for check in inputs)
                agree = f"{far} of them more than {100.0 * KINDS[INPUT].limit:.0f} % apart" if far else "not counted"
                clauses.append(f"{counted(len(inputs), 'input')} of their cases, {agree}")
        if self.properties:
            holding = len(self.properties) - len(self.failing)
            clauses.append(f"{holding} of {len(self.properties)} published properties hold")
        return "; ".join(clauses)

    def facts(self) -> Iterable[tuple[str, str]]:
        """Counts, and each value that is unacceptable."""
        yield "values", self.finding()
        for check in self.unacceptable:
            yield check.case, f"{check.quantity}: published {check.printed}, ours {said(check)}"
        for item in self.failing:
            yield item.name, "; ".join(reading.quantity for reading in item.readings if not reading.holds)


def said(check: Check) -> str:
    """Our value in the unit in which the published one is printed, with `DIGITS` digits."""
    return f"{rounded(check.ours / check.size, DIGITS)} {check.printed_unit}".strip()


def share(value: float) -> str:
    """A share in per cent with two digits; a tiny one as a power of ten."""
    if not isfinite(value):
        return MISSING
    if value == 0.0:
        return "0"
    return f"{value:.0e}" if abs(value) < 1e-5 else f"{100.0 * value:.2g} %"


def verify(cases: str | Path | Iterable[str | Path] | None = None, *, progress: Progress | None = None) -> Verification:
    """Published cases and properties beside ours.

    The words are those of CSI's verification manuals: "exact" where ours agrees to the digits printed (six at most),
    "acceptable" up to 5 % of the published value, 25 % of an experiment's, or within the stated uncertainty, and
    "unacceptable" beyond. Each run is made at tolerances from 1e-4 to 1e-9, below 1e-6 with finer samples of generated
    motions as well, which shows how far ours has converged.
    A property is a published relation without a single number: it holds where each of its readings is within bounds
    that follow from the tolerance, the digits printed or the number of samples.

    Parameters
    ----------
    cases : str, Path or iterable of them, optional
        Names of cases and of properties that ship with the package, case files (.toml), or folders of them; all that
        ship by default.
    progress : callable, optional
        Called after each case and each property with the number done and of all.

    Returns
    -------
    Verification
        One `Check` for each published value, the cases, curves on which published points lie, and the properties.

    Raises
    ------
    PoundingError
        For a case that is not known, and for a case file that cannot be read or run, with every fault of it.
    """
    files, names = chosen(cases)
    read, errors = [], []
    for file in files:
        try:
            read.append(read_case(file))
        except PoundingError as error:
            errors.append(error)
    if len(errors) == 1:
        raise errors[0]
    if errors:
        raise PoundingError("\n".join(map(str, errors)))
    checks: list[Check] = []
    curves: list[Curve] = []
    properties: list[Property] = []
    report, total = progress or (lambda done, total: None), len(files) + len(names)
    for done, case in enumerate(read, start=1):
        try:
            case_checks, drawn = compared(case)
        except PoundingError as error:
            raise PoundingError(f"{case.file}: {error}") from None
        checks += case_checks
        curves += drawn
        report(done, total)
    for name in names:
        properties.append(PROPERTIES[name]())
        report(len(read) + len(properties), total)
    return Verification(tuple(checks), tuple(read), tuple(curves), tuple(properties))


def chosen(cases: str | Path | Iterable[str | Path] | None) -> tuple[list[Path], list[str]]:
    """The files of the cases that are named, and the names of the properties: all that ship where none is named."""
    if cases is None:
        return list(shipped().values()), list(PROPERTIES)
    names = [cases] if isinstance(cases, str | Path) else list(cases)
    properties = list(dict.fromkeys(str(name) for name in names if str(name) in PROPERTIES))
    return case_files([name for name in names if str(name) not in PROPERTIES]), properties


def case_files(names: Iterable[str | Path]) -> list[Path]:
    """The files of cases that are named; raises PoundingError for a name that is no case, file or folder."""
    known, files = shipped(), list[Path]()
    for name in names:
        path = Path(name)
        if str(name) in known:
            files.append(known[str(name)])
        elif path.is_dir():
            inside = sorted(path.glob("*.toml"))
            if not inside:
                raise PoundingError(f"{path}: no case file (.toml) in this folder; name one with such files")
            files += inside
        elif path.suffix == ".toml" or path.exists():
            files.append(path)
        else:
            raise PoundingError(
                f"{str(name)!r} is neither a case nor a file or folder{nearest(str(name), [*known, *PROPERTIES])}; "
                f"cases are {', '.join(known)}; properties {', '.join(PROPERTIES)}"
            )
    return list(dict.fromkeys(files))


# ------------------------------------------------------------------------------------------------ one case


def compared(case: Case) -> tuple[list[Check], list[Curve]]:
    """The checks of a case, and the curves on which its published points lie."""
    results = _results(case)
    checks = []
    for number, value in enumerate(case.published, start=1):
        try:
            ours = tuple(_ours(value, solved) for solved in results)
        except PoundingError as error:
            raise PoundingError(f"published.{number}: {error}") from None
        checks.append(_check(case, value, ours))
    return checks, list(_curves(case, results[-1]))


def _ours(value: Published, solved: Any) -> float:
    """Our value on the axis of the source."""
    return value.factor * value.measure.of(solved, value.at) + value.offset


def _results(case: Case) -> list[Any]:
    """What the case gives at each tolerance, or once where it has none."""
    subject = case.subject
    if isinstance(subject, Collision):
        e = 1.0 if subject.restitution is None else subject.restitution
        contact: Any = {"restitution": e, "relation": subject.relation, "yield_force": subject.yield_force}
        return [impact(subject.law, subject.speed, *subject.masses, rtol=rtol, **contact) for rtol in RUNGS]
    if isinstance(subject, tuple):
        return [tuple(read_motion(name) for name in subject)]
    modal = {one.name: one for one in modes(subject)}
    if all(value.quantity in MODAL for value in case.published):
        return [Solved(None, modal)]
    results = []
    for rtol, times in zip(RUNGS, FINER, strict=True):
        # So many times as many samples of generated motions.
        records = subject.records._replace(generated=tuple(one.finer(times) for one in subject.records.generated))
        run = simulate(subject.updated(rtol=rtol, records=records if times > 1 else subject.records))
        if run.attrs["status"] != COMPLETE:
            raise PoundingError(f"at rtol {rtol:g} the run is not complete: {run.attrs['status']}")
        results.append(Solved(run, modal))
    return results


def _check(case: Case, value: Published, moved: tuple[float, ...]) -> Check:
    ours, printed, limit = moved[-1], value.printed, KINDS[value.kind].limit
    published = printed.value
    # Half a unit of the last of `DIGITS` digits; 0 of zero.
    half = 0.5 * 10.0 ** (floor(log10(abs(published))) - DIGITS + 1) if published else 0.0
    within, margin = max(printed.half, half), max(limit * abs(published), value.uncertainty)
    difference = abs(ours - published)
    word = EXACT if difference <= within else ACCEPTABLE if difference <= margin else UNACCEPTABLE
    case_facts = case.name, case.about.title, case.about.source, value.kind, _words(value), value.measure.unit
    source_facts = printed.text, published, printed.unit, printed.size, within, value.uncertainty
    return Check(*case_facts, *source_facts, ours, moved if len(moved) > 1 else (), word, limit, value.note)


def _words(value: Published) -> str:
    """The quantity and what selects it, in words."""
    units = {"time": TIME, "since": TIME, "penetration": GAP, "period": PERIOD}
    at = ", ".join(f"{key} {say(item, units[key]) if key in units else item}" for key, item in value.at.items())
    return f"{value.quantity.replace('_', ' ')}{f' ({at})' if at else ''}"


# ------------------------------------------------------------------------------------------------ curves


def _curves(case: Case, solved: Any) -> Iterable[Curve]:
    """A curve for each history or force-penetration curve of which the case has published points."""
    groups: dict[Any, list[Published]] = {}
    for value in case.published:
        along = next((key for key in ("time", "penetration") if key in value.at), None)
        if along is not None and "since" not in value.at:
            places = tuple(selector for selector in value.at.items() if selector[0] != along)
            groups.setdefault((along, value.quantity, places, value.factor, value.offset), []).append(value)
    for (along, quantity, places, factor, offset), values in groups.items():
        x, y = _line(solved, quantity, dict(places))
        unit = values[0].measure.unit
        points = [
            Point(one.at[along], one.printed.value, one.uncertainty, one.kind, _ours(one, solved)) for one in values
        ]
        axes, units = (along, quantity.replace("_", " ")), ("s" if along == "time" else "m", unit)
        about = case.name, case.about.title, case.about.source
        yield Curve(*about, axes, units, x, factor * y + offset, tuple(points))


def _line(solved: Any, quantity: str, places: Mapping[str, Any]) -> tuple[Any, Any]:
    if isinstance(solved, Solved) and solved.run is not None:
        values = history(solved.run, quantity, places)
        return values.time.values, values.values
    return force_curve(solved)
