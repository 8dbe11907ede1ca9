"""Selection of records by what is known of them, and by how close their spectra come to a target.

    >>> import numpy as np
    >>> from pounding_risk.motions.motion import Motion
    >>> from pounding_risk.motions.selection import select
    >>> from pounding_risk.motions.target_spectra import read_target
    >>> random = np.random.default_rng(0)
    >>> motions = [Motion(f"r{k}", random.standard_normal(1000), 0.01, {"magnitude": 6.0 + k}) for k in range(3)]
    >>> target = read_target("asce7:sds=1.0,sd1=0.6,tl=8")
    >>> chosen = select(motions, target, periods=(0.2, 1.0), count=1, magnitude=(6.5, 8.0))
    >>> len(chosen.motions()), chosen.left_out
    (1, {'magnitude outside 6.5 to 8': 1})

Each record, or pair of horizontal components, is scaled by the one factor that brings it closest to the target; the
closest are taken. Sa is the pseudo-spectral acceleration, at the damping of the target.

Of a target with a standard deviation of ln Sa those are taken that have its mean and deviation together, after Baker
and Lee (2018) and Jayaram, Lin and Baker (2011), in short: as many spectra as records are wanted are drawn from the
target's distribution of ln Sa, with the correlations between periods of Baker and Jayaram (2008), and have its mean and
deviation at each period exactly; each takes the unused candidate that is closest to it. Then each choice in turn is
replaced by the candidate that most reduces Σ (m − μ)² + (s − σ)² over the periods, m and s being the mean and the
standard deviation of ln Sa of the choices, until none does. Where the target is conditioned on Sa at a period, every
candidate is scaled to it there; elsewhere to its simulated spectrum, by the factor of least squares in ln Sa.

References
----------
Baker and Jayaram (2008), Earthquake Spectra 24(1), 299-317. Jayaram, Lin and Baker (2011), Earthquake Spectra 27(3),
797-815. Baker and Lee (2018), Journal of Earthquake Engineering 22(6), 1031-1047.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from math import exp, inf, isclose, isfinite
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk._common.short_repr import ShortRepr
from pounding_risk.errors import RecordError
from pounding_risk.motions.motion import USUAL_FACTORS, Motion, in_si
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.motions.record import copies, is_vertical, lowest_usable, recording
from pounding_risk.motions.rotation import rotated
from pounding_risk.motions.scaling import by_factor, period_range, spectral_accelerations
from pounding_risk.motions.target_spectra import Target
from pounding_risk.units import PGA, shown

SEED = 20080301
PASSES = 20


class Aim(NamedTuple):
    """What the choices shall have at each period [s]: mean and deviation of ln Sa, and the period of conditioning."""

    periods: Samples
    mean: Samples
    deviation: Samples
    pivot: float | None


class Limits(NamedTuple):
    """Least and largest factor, and at most so many choices of one earthquake."""

    factors: tuple[float, float]
    per_event: int | None = None


class Choice(NamedTuple):
    """A candidate, by its position, and its factor."""

    position: int
    factor: float


def correlation(periods: Samples) -> Samples:
    """Correlation of ln Sa between periods [s] from 0.01 to 10 s (Baker and Jayaram 2008), shape (n, n)."""
    at = np.clip(np.asarray(periods, dtype=np.float64), 0.01, 10.0)
    low, high = np.minimum.outer(at, at), np.maximum.outer(at, at)
    first = 1.0 - np.cos(np.pi / 2.0 - 0.366 * np.log(high / np.maximum(low, 0.109)))
    fading = 1.0 - 1.0 / (1.0 + np.exp(np.minimum(100.0 * high - 5.0, 700.0)))
    second = np.where(high < 0.2, 1.0 - 0.105 * fading * (high - low) / (high - 0.0099), 0.0)
    third = np.where(high < 0.109, second, first)
    fourth = first + 0.5 * (np.sqrt(third) - third) * (1.0 + np.cos(np.pi * low / 0.109))
    among = np.where(high < 0.2, np.minimum(second, fourth), fourth)
    return np.asarray(np.where(high <= 0.109, second, np.where(low > 0.109, first, among)))


def simulated(aim: Aim, count: int) -> Samples:
    """Spectra of ln Sa with the mean and the deviation of an aim, exactly, shape (count, periods)."""
    periods = aim.periods if aim.pivot is None else np.append(aim.periods, aim.pivot)
    r = correlation(periods)
    if aim.pivot is not None:
        at_pivot = r[-1, :-1]
        left = np.sqrt(np.maximum(1.0 - at_pivot**2, 0.0))
        scale = np.outer(left, left)
        r = np.divide(r[:-1, :-1] - np.outer(at_pivot, at_pivot), scale, out=np.zeros_like(scale), where=scale > 1e-9)
    eigenvalues, vectors = np.linalg.eigh(r)
    drawn = np.random.default_rng(SEED).standard_normal((count, len(eigenvalues)))
    drawn = drawn @ (vectors * np.sqrt(np.maximum(eigenvalues, 0.0))).T
    drawn -= drawn.mean(axis=0)
    spread = drawn.std(axis=0, ddof=1)
    return aim.mean + aim.deviation * np.divide(drawn, spread, out=np.zeros_like(drawn), where=spread > 1e-12)


def match(
    logs: Samples, fixed: Samples | None, aim: Aim, count: int, limits: Limits, events: Sequence[Hashable]
) -> list[Choice]:
    """Choose candidates whose spectra together have the mean and the deviation of an aim.

    ``logs`` is ln Sa of the candidates before scaling, (candidates, periods), ``events`` the earthquake of each. Where
    the aim is conditioned at a period ``fixed`` has the logarithm of the factor of each, else None, and ``limits``
    bound it. ``count`` is two at least and no more than there are candidates; fewer are chosen where the limit on
    earthquakes leaves no more.
    """
    spectra = simulated(aim, count)
    chosen: list[int] = []
    factors: list[Samples] = []
    with np.errstate(divide="ignore"):
        low, high = np.log(limits.factors)
    for spectrum in spectra:
        # Logarithms of the factors of all candidates for this spectrum.
        factor = np.asarray(np.clip((spectrum - logs).mean(axis=1), low, high)) if fixed is None else fixed
        cost = ((logs + factor[:, None] - spectrum) ** 2).sum(axis=1)
        cost[~_allowed(chosen, events, limits)] = np.inf
        best = int(np.argmin(cost))
        if not np.isfinite(cost[best]):
            break
        chosen.append(best)
        factors.append(factor)
    _replace(logs, chosen, factors, aim, limits, events)
    return [Choice(one, float(np.exp(factor[one]))) for one, factor in zip(chosen, factors, strict=True)]


def _allowed(chosen: Sequence[int], events: Sequence[Hashable], limits: Limits) -> NDArray[np.bool_]:
    """Candidates that may still be chosen beside those that are."""
    counts = Counter(events[one] for one in chosen)
    full = {event for event, number in counts.items() if limits.per_event is not None and number >= limits.per_event}
    allowed = np.array([event not in full for event in events])
    allowed[list(chosen)] = False
    return allowed


def _replace(
    logs: Samples, chosen: list[int], factors: Sequence[Samples], aim: Aim, limits: Limits, events: Sequence[Hashable]
) -> None:
    """Replace choices, in place, by candidates that bring mean and deviation closer, until none does."""
    n = len(chosen)
    if n < 2:
        return
    for _ in range(PASSES):
        before = list(chosen)
        for place in range(n):
            others = [at for at in range(n) if at != place]
            rows = np.array([logs[chosen[at]] + factors[at][chosen[at]] for at in others])
            mine = logs + factors[place][:, None]
            mean = (rows.sum(axis=0) + mine) / n
            square = ((rows - rows.mean(axis=0)) ** 2).sum(axis=0) + (1.0 - 1.0 / n) * (mine - rows.mean(axis=0)) ** 2
            error = ((mean - aim.mean) ** 2 + (np.sqrt(square / (n - 1)) - aim.deviation) ** 2).sum(axis=1)
            error[~_allowed([chosen[at] for at in others], events, limits)] = np.inf
            best = int(np.argmin(error))
            if error[best] < error[chosen[place]] * (1.0 - 1e-12):
                chosen[place] = best
        if chosen == before:
            return


# ------------------------------------------------------------------------------------------------------------ selection
NODES = 30  # periods in the range, evenly in the logarithm, ends included
LEAST_OF_TARGET = 0.9  # ASCE 7-16, 16.2.3.2
FILTERS = ("magnitude", "distance_km", "vs30", "pga")


@dataclass(frozen=True)
class Criteria:
    """The criteria of a selection.

    Parameters
    ----------
    periods : (float or str, float or str)
        Range of periods in which spectra are compared [s].
    count : int
        Number of candidates chosen, at most.
    spectrum : str
        "component" takes every component by itself; "geomean", "rotd50" and "rotd100" take pairs, of which that is the
        spectrum, with one factor for both components.
    limits : (float, float)
        Smallest and largest factor.
    per_event : int, optional
        Number of candidates of one earthquake, at most.
    magnitude : (float, float), optional
        Smallest and largest magnitude.
    distance_km : (float, float), optional
        Smallest and largest distance [km].
    vs30 : (float, float), optional
        Smallest and largest shear-wave velocity of the upper 30 m [m/s].
    pga : (float or str, float or str), optional
        Smallest and largest peak ground acceleration [m/s²] before scaling, of the larger component of a pair.

    Raises
    ------
    RecordError
        For values that none of these can have.
    """

    periods: tuple[float, float] = (0.2, 2.0)
    count: int = 11
    spectrum: str = "component"
    limits: tuple[float, float] = USUAL_FACTORS
    per_event: int | None = None
    magnitude: tuple[float, float] | None = None
    distance_km: tuple[float, float] | None = None
    vs30: tuple[float, float] | None = None
    pga: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "periods", period_range(self.periods))
        if self.spectrum not in SPECTRA:
            raise RecordError(f"spectrum: {shown(self.spectrum)} is not one; it may be {', '.join(SPECTRA)}")
        for key in ("count", "per_event"):
            value = getattr(self, key)
            if not (value is None and key == "per_event") and not (isinstance(value, int | np.integer) and value >= 1):
                raise RecordError(f"{key}: {shown(value)} is no number of records; write a whole number from 1 up")
        if self.pga is not None:
            object.__setattr__(self, "pga", tuple(in_si("pga", bound, PGA) for bound in self.pga))
        for key in ("limits", *FILTERS):
            bounds = getattr(self, key)
            if bounds is None:
                continue
            numbers = isinstance(bounds, Sequence) and all(isinstance(bound, int | float) for bound in bounds)
            if not numbers or len(bounds) != 2 or not bounds[0] <= bounds[1]:
                raise RecordError(
                    f"{key}: {shown(bounds)} is no range; give the smallest and the largest, such as (0.25, 4.0)"
                )
        if self.limits[0] <= 0.0:
            raise RecordError(
                f"limits: a factor of {self.limits[0]:g} scales nothing; write two above 0, such as 0.25, 4"
            )


@dataclass(frozen=True, eq=False)
class Row:
    """A chosen candidate: one component, or a pair with one factor."""

    motions: tuple[Motion, ...]  # as given, not scaled
    factor: float
    misfit: float  # root mean square of ln(scaled Sa / target)
    limited: bool  # the factor is at one of its limits
    acceleration: Samples  # Sa of the unscaled candidate at Selection.periods [m/s²]
    doubts: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Names of the components, joined."""
        return " + ".join(motion.name for motion in self.motions)

    def known(self, key: str) -> Any:
        """The value of the fact ``key``, such as "event", in the records; None where none of them has it."""
        return _known(self.motions, key)


@dataclass(frozen=True, eq=False, repr=False)
class Selection(ShortRepr):
    """The result of a selection, closest candidate first, and how the ensemble compares with the target."""

    target: Target
    wanted: Criteria
    periods: Samples  # s, where spectra were compared
    rows: tuple[Row, ...]
    considered: int  # candidates, chosen or not
    left_out: dict[str, int] = field(default_factory=dict)  # why, and how many

    def facts(self) -> Iterable[tuple[str, str]]:
        """Target, periods, the chosen candidates with factor and misfit, and why others were left out."""
        low, high = self.wanted.periods
        yield "target", f"{self.target.name}, from {low:g} to {high:g} s"
        for row in self.rows:
            doubts = "".join(f"; {doubt}" for doubt in row.doubts)
            yield row.name, f"times {row.factor:.3g}, misfit {row.misfit:.3f}{doubts}"
        yield "chosen", f"{len(self.rows)} of {counted(self.considered, 'candidate')}"
        yield from ((f"excluded, {why}", counted(number, "candidate")) for why, number in self.left_out.items())

    def motions(self) -> tuple[Motion, ...]:
        """The components that were chosen, each scaled by its factor."""
        low, high = self.wanted.periods
        aim = f"the target {self.target.name} from {low:g} to {high:g} s"
        return tuple(
            by_factor(motion.doubted(row.doubts), row.factor, aim) for row in self.rows for motion in row.motions
        )

    @property
    def spectra(self) -> Samples:
        """Sa of the scaled candidates [m/s²], shape (rows, periods)."""
        return np.array([row.factor * row.acceleration for row in self.rows])

    def spectra_at(self, periods: Samples) -> Samples:
        """Spectra of the chosen candidates, scaled, at other periods [s]: Sa [m/s²], shape (rows, periods).

        They are the spectra that were compared: of components, or of pairs as `Criteria.spectrum` says.
        """
        spectra = SPECTRA[self.wanted.spectrum]([row.motions for row in self.rows], periods, self.target.damping)
        return spectra * np.array([row.factor for row in self.rows])[:, None]

    @property
    def median_ratio(self) -> Samples:
        """Geometric mean of the scaled spectra over the target, shape (periods,)."""
        return np.exp(np.log(self.spectra).mean(axis=0)) / self.target.at(self.periods)

    @property
    def least_mean_ratio(self) -> float:
        """The least of (arithmetic mean of the scaled spectra / target) over the range.

        ASCE 7-16, 16.2.3.2 requires 0.9, with "rotd100" and the range from 0.2 of the shortest to 2 of the longest
        first-mode period.
        """
        return float((self.spectra.mean(axis=0) / self.target.at(self.periods)).min())

    @property
    def deviation(self) -> Samples:
        """Standard deviation of ln Sa of the scaled spectra, shape (periods,)."""
        return np.asarray(np.log(self.spectra).std(axis=0, ddof=1))

    def _spread_words(self) -> tuple[str, ...]:
        """Sentences on mean and deviation of ln Sa against those of the target, where it has a deviation."""
        if self.target.deviation is None:
            return ()
        shift, goal = np.log(self.median_ratio), self.target.deviation_at(self.periods)
        off = self.deviation - goal
        pivot = self.target.pivot
        scaled = "each scaled to a simulated spectrum" if pivot is None else f"all scaled to the target at {pivot:g} s"
        return (
            f"target: {self.target.origin or self.target.name}; {scaled}",
            f"mean of ln Sa: {shift.min():+.3f} to {shift.max():+.3f} off the target's",
            f"deviation of ln Sa: {self.deviation.min():.3f} to {self.deviation.max():.3f}, {off.min():+.3f} to "
            f"{off.max():+.3f} off the target's, which is {goal.min():.3f} to {goal.max():.3f}",
        )

    def words(self) -> tuple[str, ...]:
        """Sentences that summarise the selection."""
        low, high = self.wanted.periods
        left_out = ", ".join(f"{count} for {why}" for why, count in self.left_out.items()) or "none"
        factors, misfits = [[getattr(row, key) for row in self.rows] for key in ("factor", "misfit")]
        limited = sum(row.limited for row in self.rows)
        median, mean = self.median_ratio, self.least_mean_ratio
        rule = ""
        if self.wanted.spectrum == "rotd100":
            rule = (
                f", {'not ' if mean < LEAST_OF_TARGET else ''}the {LEAST_OF_TARGET:g} that ASCE 7-16, 16.2.3.2 requires"
            )
        return (
            f"chosen: {len(self.rows)} of {counted(self.considered, 'candidate')}, {self.wanted.count} requested",
            f"excluded: {left_out}",
            f"factors: {min(factors):.3g} to {max(factors):.3g}, {limited} of them at a limit",
            f"misfits: {min(misfits):.3g} to {max(misfits):.3g}, root mean square of ln(Sa / target)",
            f"median: {median.min():.3g} to {median.max():.3g} of {self.target.name} from {low:g} to {high:g} s",
            f"mean: {mean:.3g} of it at least{rule}",
            *self._spread_words(),
        )


class Fit(NamedTuple):
    """The best factor of a spectrum, and how close it comes to the target with it."""

    factor: float
    misfit: float
    limited: bool


def fit(acceleration: Samples, target: Samples, limits: tuple[float, float] = (0.0, inf)) -> Fit:
    """The factor f within ``limits`` for which Σ ln²(f Sa / target) is least, and the root of the mean of it.

    Closed form: the geometric mean of target / Sa; the sum is a parabola in ln f, so that beyond a limit the limit is
    the best.
    """
    ratios = np.log(np.asarray(target) / np.asarray(acceleration))
    best = exp(float(ratios.mean()))
    factor = min(max(best, limits[0]), limits[1])
    return Fit(factor, float(np.sqrt(np.mean((np.log(factor) - ratios) ** 2))), factor != best)


def select(motions: Iterable[Motion], target: Target, **choices: Any) -> Selection:
    """Select the records whose spectra come closest to a target, each with its factor.

    Parameters
    ----------
    motions : iterable of Motion
        The candidates, in any order: equal misfits are ordered by name.
    target : Target
        The target spectrum.
    **choices : dict
        The criteria, parameters of `pounding_risk.motions.selection.Criteria`: periods, count, spectrum, limits,
        per_event, magnitude, distance_km, vs30, pga.

    Returns
    -------
    Selection
        The chosen candidates, closest first, and the number of those left out for each reason.

    Raises
    ------
    RecordError
        For criteria out of range, a range of periods outside the target, components of a pair that cannot be brought
        together, and where no candidate is left.

    Notes
    -----
    Of a target with a standard deviation the candidates whose factor to its conditioning period is beyond ``limits``
    are left out.

    Vertical components are left out by their names (UP, DWN, HNZ ...). Pairs are two components of one recording: of
    the same ``rsn``, or else of the same event, date and station; a recording with one, or with more than two, is
    left out. So are records without a fact that a criterion needs, copies, and records whose spectrum is zero.
    """
    unknown = [key for key in choices if key not in Criteria.__dataclass_fields__]
    if unknown:
        raise RecordError(
            f"{', '.join(unknown)}: no choice of a selection; it takes {', '.join(Criteria.__dataclass_fields__)}"
        )
    criteria = Criteria(**choices)
    periods = np.geomspace(*criteria.periods, NODES)
    goal = target.at(periods)
    left_out: Counter[str] = Counter()
    candidates = _candidates(list(motions), criteria, left_out)
    considered = len(candidates) + sum(left_out.values())
    candidates = [candidate for candidate in candidates if _passes(candidate, criteria, left_out)]
    compared = periods if target.pivot is None else np.append(periods, target.pivot)
    spectra_of = SPECTRA[criteria.spectrum]
    spectra = spectra_of(candidates, compared, target.damping) if candidates else np.empty((0, compared.size))
    rows = []
    for components, spectrum in zip(candidates, spectra, strict=True):
        if not (np.isfinite(spectrum).all() and (spectrum > 0.0).all()):
            left_out["a spectrum of zero"] += 1
            continue
        at_pivot, spectrum = spectrum[NODES:], spectrum[:NODES]
        limits = criteria.limits
        if at_pivot.size:
            limits = (float(target.at(compared[-1]) / at_pivot[0]),) * 2
            if not criteria.limits[0] <= limits[0] <= criteria.limits[1]:
                left_out[f"a factor to the target at {compared[-1]:g} s outside the limits"] += 1
                continue
        best = fit(spectrum, goal, limits)
        is_limited = best.limited and not at_pivot.size
        rows.append(Row(components, best.factor, best.misfit, is_limited, spectrum, _doubts(components, criteria)))
    rows.sort(key=lambda row: (row.misfit, row.name))
    chosen = _first(rows, criteria, left_out) if target.deviation is None else _matched(rows, target, criteria)
    if not chosen:
        why = ", ".join(f"{count} for {reason}" for reason, count in left_out.items()) or "none was given"
        raise RecordError(f"no record is left of {considered}: {why}; widen the choice")
    return Selection(target, criteria, periods, tuple(chosen), considered, dict(left_out))


def _candidates(motions: list[Motion], criteria: Criteria, left_out: Counter[str]) -> list[tuple[Motion, ...]]:
    """Components, or pairs of them, in an order that does not depend on the one given."""
    level = [motion for motion in motions if not is_vertical(motion.record)]
    if len(level) < len(motions):
        left_out["being vertical"] += len(motions) - len(level)
    level.sort(key=lambda motion: motion.name)
    again = {copy.place for copy in copies([(motion.acceleration, motion.dt) for motion in level])}
    if again:
        left_out["being a copy of another candidate"] += len(again)
    level = [motion for number, motion in enumerate(level) if number not in again]
    if criteria.spectrum == "component":
        return [(motion,) for motion in level]
    groups: dict[Any, list[Motion]] = {}
    for motion in level:
        groups.setdefault(recording(motion.record, motion.name), []).append(motion)
    for group in groups.values():
        if len(group) != 2:
            left_out[f"being {len(group)} horizontal component{'s' if len(group) > 1 else ''} of one recording"] += 1
    return [(group[0], group[1]) for group in groups.values() if len(group) == 2]


def _known(candidate: tuple[Motion, ...], key: str) -> Any:
    if key == "pga":
        return max(motion.pga for motion in candidate)
    return next((motion.record[key] for motion in candidate if motion.record.get(key) not in (None, "")), None)


def _passes(candidate: tuple[Motion, ...], criteria: Criteria, left_out: Counter[str]) -> bool:
    """True for a candidate that passes every filter; the first filter that it fails is counted."""
    for key in FILTERS:
        bounds = getattr(criteria, key)
        if bounds is None:
            continue
        value = _known(candidate, key)
        if value is None or not isfinite(float(value)):
            left_out[f"{key} unknown"] += 1
            return False
        if not bounds[0] <= float(value) <= bounds[1]:
            left_out[f"{key} outside {bounds[0]:g} to {bounds[1]:g}"] += 1
            return False
    if criteria.per_event is not None and _known(candidate, "event") is None:
        left_out["event unknown"] += 1
        return False
    return True


def _first(rows: list[Row], criteria: Criteria, left_out: Counter[str]) -> list[Row]:
    """The closest candidates, no more of one earthquake than allowed."""
    chosen: list[Row] = []
    events: Counter[tuple[Any, Any]] = Counter()
    for row in rows:
        event = row.known("event"), row.known("date")
        if len(chosen) == criteria.count:
            break
        if criteria.per_event is not None and events[event] >= criteria.per_event:
            left_out[f"more than {criteria.per_event} of one event"] += 1
        else:
            chosen.append(row)
            events[event] += 1
    return chosen


def _matched(rows: list[Row], target: Target, criteria: Criteria) -> list[Row]:
    """Candidates that have the mean and the deviation of the target together, the closest to its mean first."""
    if not rows:
        return []
    if criteria.count < 2 or len(rows) < 2:
        raise RecordError(
            f"{target.name}: a standard deviation needs two records at least; {len(rows)} can be chosen and "
            f"{criteria.count} requested: request more, or widen the choice"
        )
    periods = np.geomspace(*criteria.periods, NODES)
    aim = Aim(periods, np.log(target.at(periods)), target.deviation_at(periods), target.pivot)
    logs = np.log([row.acceleration for row in rows])
    fixed = None if target.pivot is None else np.log([row.factor for row in rows])
    events = [(row.known("event"), row.known("date")) for row in rows]
    count, limits = min(criteria.count, len(rows)), Limits(criteria.limits, criteria.per_event)
    chosen = []
    for choice in match(logs, fixed, aim, count, limits, events):
        row, ends = rows[choice.position], [bound for bound in criteria.limits if isclose(choice.factor, bound)]
        misfit = float(np.sqrt(np.mean((logs[choice.position] + np.log(choice.factor) - aim.mean) ** 2)))
        chosen.append(replace(row, factor=choice.factor, misfit=misfit, limited=bool(ends) and fixed is None))
    return sorted(chosen, key=lambda row: (row.misfit, row.name))


def _doubts(candidate: tuple[Motion, ...], criteria: Criteria) -> tuple[str, ...]:
    """A flag for a record that is compared at periods beyond its usable ones."""
    lowest = max(lowest_usable(motion.record) or 0.0 for motion in candidate)
    if criteria.periods[1] * lowest <= 1.0:
        return ()
    longest = f"{1.0 / lowest:.3g} s"
    return (f"compared up to {criteria.periods[1]:g} s, and usable up to {longest} ({lowest:.4g} Hz) only",)


def _geometric(candidates: list[tuple[Motion, ...]], periods: Samples, damping: float) -> Samples:
    """sqrt(Sa1 Sa2) of pairs; the peaks of the two components may come at different times."""
    both = spectral_accelerations([motion for parts in candidates for motion in parts], periods, damping)
    return np.sqrt(both[0::2] * both[1::2])


def _of_direction(percentile: float) -> Callable[[list[tuple[Motion, ...]], Samples, float], Samples]:
    """The function that gives RotDnn of pairs, over the time that both components cover."""

    def spectra(candidates: list[tuple[Motion, ...]], periods: Samples, damping: float) -> Samples:
        from pounding_risk.motions.intensity import rotated_spectra

        ordinates = []
        for first, second in candidates:
            # Turned to the first component and across it: aligned, of one length, and perpendicular.
            along = float(first.record.get("azimuth") or 0.0)
            both = [rotated(first, second, along + turn) for turn in (0.0, 90.0)]
            turned = rotated_spectra((both[0].acceleration, both[1].acceleration), first.dt, periods, damping)
            ordinates.append(turned.rotd(percentile))
        return np.array(ordinates)

    return spectra


SPECTRA: dict[str, Callable[[list[tuple[Motion, ...]], Samples, float], Samples]] = {
    "component": lambda candidates, periods, damping: spectral_accelerations(
        [parts[0] for parts in candidates], periods, damping
    ),
    "geomean": _geometric,
    "rotd50": _of_direction(50.0),
    "rotd100": _of_direction(100.0),
}
