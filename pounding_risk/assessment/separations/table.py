"""Code separations of a pair from its own spectral displacements, side by side with what its motions ask for.

    >>> from pounding_risk.assessment.separations.table import separations
    >>> rows = separations(("A", "B"), (0.03, 0.04), (0.9, 1.0), (0.05, 0.05))
    >>> [(row.rule, round(1e3 * row.separation, 1)) for row in rows[:3]]
    [('abs', 70.0), ('srss', 50.0), ('cqc', 36.9)]

Works from a dataset alone: ``peak_displacement_free`` is the spectral displacement of each building under each motion,
``peak_closing_free`` the gap that this motion needs.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from math import inf, isfinite, nan
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk._common.order import enough_for
from pounding_risk._common.short_repr import ShortRepr
from pounding_risk._common.words import nearest
from pounding_risk.assessment.demands import by_motion
from pounding_risk.assessment.options import USUAL_PERCENTILE, percentile_of
from pounding_risk.assessment.separations import rules
from pounding_risk.assessment.separations.rules import RULES, Case, Rule, Site
from pounding_risk.errors import PoundingError
from pounding_risk.results.attributes import (
    has_histories,
    has_own_grounds,
    isolated_buildings,
    no_response,
    rotating_buildings,
    yielding_buildings,
)
from pounding_risk.results.files import open_with_axes
from pounding_risk.results.opened import Results
from pounding_risk.statistics.required_gap import rounded_up
from pounding_risk.statistics.separations import Pair, white_noise_correlation
from pounding_risk.units import GAP, Quantity, say, si

Array = NDArray[np.float64]

LOW, MIDDLE, HIGH = 16.0, 50.0, 84.0  # percentiles: one standard deviation to either side, were it normal
PLAIN = Site()
DISPLACEMENT = Quantity("m", -inf, inf, "peak displacement", example="45 mm")  # `_check` bounds it
NEEDED = ("peak_displacement_free", "peak_closing_free", "building_period", "building_damping")
SAME = 1e-9  # a rule short of the demand by no more than this share is not exceeded: they are rounded apart


@dataclass(frozen=True)
class SeparationRow:
    """Separation of one rule [m]; None where it needs what was not given, as ``note`` says.

    ``verification`` says how the text of the clause is known: "derived", "clause read", "quoted" or "from memory", by
    ``source``; ``superseded`` names later editions of it, "" where none is known here.
    """

    rule: str
    title: str
    clause: str
    year: int | None
    verification: str
    source: str
    superseded: str
    separation: float | None
    note: str


@dataclass(frozen=True)
class Comparison:
    """One rule beside the gaps that the motions need.

    ``middle`` and ``upper`` [m] are the median and the percentile of what the rule requires, motion by motion, from
    that motion's own peaks, not from a code's design displacements;
    ``ratio_*`` the 16 %, 50 % and 84 % values of that over the gap the same motion needs; ``exceeded`` the share of
    the motions that need more than the rule requires. All None where the rule gives no number. None of them counts the
    length of ``bumper`` [m] in the gap.
    """

    row: SeparationRow  # of the median displacements
    middle: float | None = None
    upper: float | None = None
    ratio_low: float | None = None
    ratio_median: float | None = None
    ratio_high: float | None = None
    exceeded: float | None = None
    bumper: float = 0.0

    @property
    def safe(self) -> bool | None:
        """Whether every motion gets the gap it needs."""
        return None if self.exceeded is None else self.exceeded == 0.0


@dataclass(frozen=True, repr=False)
class CodeTable(ShortRepr):
    """Rules beside the gaps that the motions of a dataset need, at one amplitude."""

    buildings: tuple[str, str]
    amplitude: float | None  # SI, of the grid: PGA, or the level of its measure; None where the grid has none
    at: str  # how strong the motions are, in words
    percentile: float  # %
    motions: int  # record and polarity, those with a demand
    without: int  # motions that close no gap at all, in no ratio
    demand_median: float  # m
    demand: float  # m, at the percentile
    displacements: tuple[float, float]  # m, medians of the two buildings
    correlation: float | None  # ρ of the two buildings under white noise; None where one is rigid
    names: tuple[str, ...]  # of the motions with a demand
    closing: tuple[float, ...]  # m, the gap that each needs
    asked: dict[str, tuple[float, ...]]  # m, what each combination requires, motion by motion
    rules: tuple[Comparison, ...]

    def facts(self) -> Iterable[tuple[str, str]]:
        """Buildings, motions, required gap and finding, as pairs of a name and words."""
        yield "between", " | ".join(self.buildings)
        yield "motions", f"{self.motions} {self.at}"
        yield f"gap of {self.percentile:g} % of the motions", say(rounded_up(self.demand), GAP, 3)
        yield "separations", rules.OWN_PEAKS
        yield "finding", self.finding

    @property
    def finding(self) -> str:
        """Sentence on how often the three combinations fall short in these motions."""
        return short_in(self.rules, self.motions)

    def as_dict(self) -> dict[str, Any]:
        """The table as numbers, words and lists that JSON holds."""
        return asdict(self)


def separations(
    buildings: Sequence[str],
    displacements: Sequence[Any],
    periods: Pair | None = None,
    dampings: Pair | None = None,
    site: Site = PLAIN,
) -> tuple[SeparationRow, ...]:
    """Separations that every rule of `RULES` asks for between two buildings, left and right.

    A rule that needs what is not given has no number, and its note says what it needs. Design displacements come from
    elastic ones under a code's reduced forces and its factor: ``Site(factors=(3.0, 3.0))`` for q, Cd / Ie or μ of 3, as
    ``factor`` of the rule names it; one call for each code whose factor differs.

    Parameters
    ----------
    buildings : sequence of str
        Names of the two buildings.
    displacements : pair of float or str
        Peak displacements [m, or text with a unit] of the linear model without contact under the design motion, at the
        height where the two can touch.
    periods : pair of float, optional
        Periods [s]; NaN for a rigid building. The double difference needs them.
    dampings : pair of float, optional
        Damping ratios, with the periods.
    site : Site
        What codes ask about the two neighbours besides how they move.

    Returns
    -------
    tuple of SeparationRow
        One row a rule, in the order of `RULES`.

    Raises
    ------
    PoundingError
        For a number out of its range.
    """
    if len(buildings) != 2:
        raise PoundingError(
            f"{counted(len(buildings), 'building')}; a separation is between two: choose a pair of neighbours"
        )
    if len(displacements) != 2:
        raise PoundingError(f"{len(displacements)} displacements; give two, left and right, such as 0.045, 0.03")
    left, right = (si(displacement, DISPLACEMENT, "displacements") for displacement in displacements)
    for displacement in (left, right):
        if not (isfinite(displacement) and displacement >= 0.0):
            raise PoundingError(
                f"a peak displacement is {displacement:g} m; it must be at least 0 and finite: give the peak"
            )
    _check_site(site)
    given_pairs = None if periods is None or dampings is None else (periods, dampings)
    of_periods, of_dampings = given_pairs or ((nan, nan), (nan, nan))
    case = Case((left, right), of_periods, of_dampings, site)
    rows = []
    for rule in RULES.values():
        missing_needs = ["periods and dampings"] if rule.has_periods and given_pairs is None else []
        missing_needs += [key for key in rule.needs if getattr(site, key) is None]
        notes = [
            f"needs {' and '.join(missing_needs)}" if missing_needs else "",
            {rules.MEMORY: rules.FROM_MEMORY, rules.QUOTED: rules.QUOTED_ONLY}.get(rule.verification, ""),
            f"superseded by {rule.superseded}" if rule.superseded else "",
        ]
        if not missing_needs:  # what the rule assumes of what the user did not give
            notes += [rules.TAKEN[key] for key in rule.assumes if getattr(site, key) == getattr(PLAIN, key)]
        facts = (rule.name, rule.title, rule.clause, rule.year, rule.verification, rule.source, rule.superseded)
        separation = None if missing_needs else float(rule.function(case))
        rows.append(SeparationRow(*facts, separation, "; ".join(filter(None, notes))))
    return tuple(rows)


def _check_site(site: Site) -> None:
    ground = None if site.ground is None else (site.ground,)
    positive: tuple[tuple[str, Any, str], ...] = (
        ("height", site.heights, " m"), ("factor", site.factors, ""), ("design acceleration", ground, " m/s²")
    )  # fmt: skip
    for name, stated_values, unit in positive:
        for value in stated_values or ():
            if not (isfinite(value) and value > 0.0):
                raise PoundingError(f"a {name} is {value:g}{unit}; it must be greater than 0 and finite: correct it")
    choices: tuple[tuple[str, tuple[Any, ...]], ...] = (
        ("zone", rules.ZONES), ("intensity", rules.INTENSITIES), ("structure", rules.STRUCTURES)
    )  # fmt: skip
    for name, allowed in choices:
        value = getattr(site, name)
        if value is not None and value not in allowed:
            raise PoundingError(f"{name} is {value!r}; it must be {', '.join(map(str, allowed))}: choose one")


def code_table(
    results: xr.Dataset, percentile: float | str = USUAL_PERCENTILE, site: Site = PLAIN, *, interface: str | None = None
) -> CodeTable:
    """Separations that rules ask for, from the spectral displacements of each motion, beside the gap that it needs.

    A motion is a record in a polarity. Of several amplitudes the scene's own is taken, or the largest; select one to
    see another. Where a wave passes along the row the ground itself moves apart: that is in the gap needed and in no
    rule, whose note says so. Of buildings with storeys displacements are those at the highest contact point, and the
    dataset's heights and levels are the site's where ``site`` gives none.

    Parameters
    ----------
    results : xarray.Dataset
        A dataset of `scan`, of one pair of buildings, or of a row of which ``interface`` names two neighbours.
    percentile : float or str
        Share of the motions whose gap is given beside the median: 84, 0.84 or "84 %", between 50 % and 100 %.
    site : Site
        What codes ask about the two neighbours besides how they move.
    interface : str, optional
        Name of an interface, "left | right".

    Returns
    -------
    CodeTable
        Every rule beside the gaps that the motions need.

    Raises
    ------
    PoundingError
        Where the dataset lacks what `scan` writes, has more than two buildings and no interface is named, or no finite
        motion; and for an interface that it has not and a percentile out of its range.
    """
    percentile = percentile_of(percentile)
    opened = open_with_axes(results)
    if interface is not None:
        pairs = dict(opened.interfaces)
        if interface not in pairs:
            hint = nearest(str(interface), pairs)
            raise PoundingError(f"interface: {interface!r} is not in the dataset{hint}, which has {', '.join(pairs)}")
        opened = pairs[interface]
    return separations_of(opened.at_level(), percentile, site)


def separations_of(results: Results, percentile: float, site: Site = PLAIN) -> CodeTable:
    """`code_table` of two neighbours at one amplitude; the percentile in %."""
    dataset = results.dataset
    if missing := [name for name in NEEDED if name not in dataset]:
        raise PoundingError(f"the dataset has no {' and no '.join(missing)}; scan the scene again with this version")
    if dataset.sizes.get("building", 1) != 2:
        example = " | ".join(map(str, dataset["building"].values[:2]))
        raise PoundingError(
            f"the dataset has {dataset.sizes.get('building', 1)} buildings; select two neighbours, such as "
            f'interface="{example}", or with isel(building=[0, 1])'
        )
    pair = dataset.isel(interface=0, missing_dims="ignore")
    left, right = (by_motion(at_contact(pair, side)).astype(float) for side in (0, 1))
    bumper = float(pair.coords.get("interface_bumper", 0.0))
    closing = by_motion(pair["peak_closing_free"]).astype(float) - bumper
    is_known = np.isfinite(left) & np.isfinite(right) & np.isfinite(closing)
    if not is_known.any():
        raise PoundingError(no_response(dataset))
    site = _completed_site(pair, site)
    periods: Pair = tuple(pair["building_period"].values.tolist())
    dampings: Pair = tuple(pair["building_damping"].values.tolist())
    has_closing = is_known & (closing > 0.0)
    names = [f"{record} {polarity}" for record in pair["record"].values for polarity in pair["polarity"].values]
    first, second = map(str, pair["building"].values)
    medians = (float(np.median(left[is_known])), float(np.median(right[is_known])))
    case = Case((left[has_closing], right[has_closing]), periods, dampings, site)
    rows = separations((first, second), medians, periods, dampings, site)
    rows = _with_notes(rows, {first, second}, results.scene, is_known, bumper)
    amplitude = results.amplitudes.values[0]
    has_both_periods = bool(np.isfinite(pair["building_period"].values).all())
    demand_median, demand = enough_for(closing[is_known], (MIDDLE, percentile)).tolist()
    return CodeTable(
        buildings=(first, second),
        amplitude=amplitude if amplitude is not None and isfinite(amplitude) else None,
        at=results.amplitude_words(),
        percentile=percentile,
        motions=int(has_closing.sum()),
        without=int((is_known & ~has_closing).sum()),
        demand_median=demand_median,
        demand=demand,
        displacements=medians,
        correlation=float(white_noise_correlation(periods, dampings)) if has_both_periods else None,
        names=tuple(np.array(names)[has_closing].tolist()),
        closing=tuple(closing[has_closing].tolist()),
        asked={name: tuple(_separation_by_motion(RULES[name], case).tolist()) for name in rules.COMBINATIONS},
        rules=tuple(replace(_comparison(row, case, closing[has_closing], percentile), bumper=bumper) for row in rows),
    )


def _with_notes(
    rows: Sequence[SeparationRow], names: set[str], scene: Mapping[str, Any], is_known: NDArray[np.bool_], bumper: float
) -> tuple[SeparationRow, ...]:
    """The rows with what the displacements of these two buildings are, and what they do not say."""
    lost_count = int((~is_known).sum())
    rigid = {one["name"] for one in scene.get("building", ()) if one.get("rigid")}
    conditions = {
        rules.MOAT: names & set(isolated_buildings(scene)) and names & rigid,
        rules.ONE_GROUND: has_own_grounds(scene),
        rules.ROTATING: names & set(rotating_buildings(scene)),
        rules.ISOLATED: names & set(isolated_buildings(scene)),  # of the rule that takes periods
        f"without the {lost_count} of {counted(is_known.size, 'motion')} that have no finite response": lost_count,
        rules.CLEAR: bumper,
    }
    displacement_note = rules.OF_YIELDING if names & set(yielding_buildings(scene)) else rules.NOT_REDUCED
    displacement_note = rules.OF_HISTORIES if has_histories(scene) else displacement_note

    def note_of(row: SeparationRow) -> str:
        notes = [note for note, holds in conditions.items() if holds and (note != rules.ISOLATED or row.rule == "cqc")]
        notes += [rules.OF_UBC97] if row.rule.startswith("ubc97") and displacement_note != rules.NOT_REDUCED else []
        return "; ".join(filter(None, (row.note.replace(rules.NOT_REDUCED, displacement_note), *notes)))

    return tuple(replace(row, note=note_of(row)) for row in rows)


def at_contact(results: xr.Dataset, side: int) -> xr.DataArray:
    """A building's largest displacement without contact at the highest point of contact with its neighbour [m].

    Of a pair of single masses that of the mass. Part-way up a storey between those of the floors below and above,
    which the peak there does not exceed.
    """
    peak = results["peak_displacement_free"].isel(building=side)
    if "storey_displacement_free" not in results or int(results["building_storeys"].values[side]) == 0:
        return peak
    floors = results[f"contact_point_{('left', 'right')[side]}_floor"].values
    below, share = divmod(float(floors[results["contact_point_left_floor"].values.argmax()]), 1.0)
    storeys = results["storey_displacement_free"].isel(building=side)
    foot = storeys.isel(storey=int(below) - 1) if below else 0.0 * peak
    return foot if share == 0.0 else (1.0 - share) * foot + share * storeys.isel(storey=int(below))


def _completed_site(results: xr.Dataset, site: Site) -> Site:
    """The site with heights and alignment of floors from the dataset, where ``site`` gives none."""
    left, right = (float(height) for height in results["building_height"].values)
    has_heights = all(isfinite(height) and height > 0.0 for height in (left, right))
    heights = (left, right) if site.heights is None and has_heights else site.heights
    # Floors of a rigid building, of a single mass that stands for several, and those whose levels are not known, cannot
    # be said to be aligned: every floor of both, from the ground up, must meet one.
    level = (results["contact_point_kind"] == "floor") & np.isfinite(results["contact_point_level"])
    floors = [np.unique(results[f"contact_point_{side}_floor"].values) for side in ("left", "right")]
    is_meeting = all(np.array_equal(floor_numbers, np.arange(floor_numbers.size) + 1.0) for floor_numbers in floors)
    has_floors = "storey_displacement_free" in results and bool((results["building_storeys"] > 0).all())
    return site._replace(heights=heights, aligned=site.aligned or (has_floors and is_meeting and bool(level.all())))


def _separation_by_motion(rule: Rule, case: Case) -> Array:
    """Separations of a rule [m], one for each motion."""
    return np.broadcast_to(np.asarray(rule.function(case), dtype=float), np.shape(case.displacements[0]))


def _comparison(row: SeparationRow, case: Case, closing: Array, percentile: float) -> Comparison:
    if row.separation is None or not closing.size:
        return Comparison(row)
    separation = _separation_by_motion(RULES[row.rule], case)
    low, middle, high = np.percentile(separation / closing, (LOW, MIDDLE, HIGH)).tolist()
    median, upper = float(np.median(separation)), float(enough_for(separation, percentile))
    return Comparison(row, median, upper, low, middle, high, float(np.mean(closing > separation * (1.0 + SAME))))


def short_in(comparisons: Sequence[Comparison], motions: int) -> str:
    """Sentence on how often the three combinations fall short in so many motions that close a gap."""
    if not motions:
        return "No motion closes any gap between these buildings"
    clauses = []
    for comparison in comparisons:
        if comparison.row.rule in rules.COMBINATIONS:
            count = round((comparison.exceeded or 0.0) * motions) or "none"
            clauses.append((comparison.row.rule.upper(), count, f"{comparison.ratio_median:.2f}"))
    (name, count, ratio), *others = clauses
    start = (
        f"Of {counted(motions, 'motion')} {name} falls short in {count} ({ratio} times the gap needed in the median)"
    )
    return ", ".join([start, *(f"{name} in {count} ({ratio})" for name, count, ratio in others)])
