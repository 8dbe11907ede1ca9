"""Buildings and interfaces of rows as layers of a map: what is known of each, and where it is.

Names of columns end in their unit, ``_m`` or ``_N``; shares and ratios have none. `BUILDING` and `INTERFACE` say what
each column is. Contact is that of `assess`, at the assessed gap. What needs runs is empty where none is at it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import inf, isfinite, nan
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk.assessment.assess import Assessment, InterfaceAssessment, assess
from pounding_risk.assessment.demands import SAME_GAP, motions_of, share_with_lost, touching
from pounding_risk.assessment.fragility import not_run
from pounding_risk.assessment.row import RowCase, any_of_building, row_case
from pounding_risk.assessment.verdict import ADEQUATE, DEPENDS, INADEQUATE
from pounding_risk.errors import PoundingError
from pounding_risk.reports.exports import Options
from pounding_risk.reports.exports._outlines import Places, nominal_places, street_places
from pounding_risk.results.opened import Results
from pounding_risk.results.variables import NOT_RUN
from pounding_risk.statistics.proportions import exact_bounds
from pounding_risk.statistics.required_gap import required_gaps
from pounding_risk.units import GAP, say

Array = NDArray[np.float64]

WORST_FIRST = (INADEQUATE, DEPENDS, ADEQUATE)
PERCENTILES = (50, 84, 95)
DRIFTS, ACCELERATIONS = ("peak_drift", "peak_displacement"), ("peak_floor_acceleration",)  # of a single mass the second


class Column(NamedTuple):
    """What a column holds: its unit as of UDUNITS ("1" of a share, a ratio or a count, "" of text), and its words."""

    unit: str
    words: str


def _with_bounds(name: str, words: str) -> dict[str, Column]:
    ends = {"": words, "_low": f"lower bound of {name}", "_high": f"upper bound of {name}"}
    return {f"{name}{ending}": Column("1", text) for ending, text in ends.items()}


def _required() -> dict[str, Column]:
    columns = {}
    for percentile in PERCENTILES:
        name = f"required_gap_p{percentile}"
        words = (
            f"gap that {percentile} % of the motions do not close, at least this where a row was run at none so wide"
        )
        words += ", empty where none is wide enough"
        columns[f"{name}_m"] = Column("m", words)
        columns |= {f"{name}_{end}_m": Column("m", f"bound of {name}_m by recording") for end in ("low", "high")}
    return columns


BUILDING: dict[str, Column] = {
    "row": Column("", "row of buildings, the title of its scene"),
    "building": Column("", "name of the building"),
    "position": Column("", "end or interior of the row, or alone"),
    "storeys": Column("1", "number of storeys, 0 of a rigid building"),
    "height_m": Column("m", "level of the roof above the ground"),
    "verdict": Column("", "the worst verdict on its gaps: inadequate, depends or adequate"),
    **_with_bounds("p_contact", "share of the motions that close a gap beside it"),
    **_with_bounds(
        "p_yield", "share of the motions in which a contact of it reaches its F_E; empty where all are infinite"
    ),
    "drift_amplification": Column(
        "1", "largest storey drift, above isolators, with contact over without, median of motions that touch"
    ),
    "acceleration_amplification": Column("1", "largest acceleration with contact over without, likewise"),
    "motions": Column("1", "motions that p_contact is from"),
    "motions_scaled": Column("", "amplitude of the motions"),
}
INTERFACE: dict[str, Column] = {
    "row": BUILDING["row"],
    "interface": Column("", "names of both buildings"),
    "left": Column("", "name of the left building"),
    "right": Column("", "name of the right building"),
    "gap_m": Column("m", "assessed gap"),
    "verdict": Column("", "verdict on the gap: inadequate, depends or adequate"),
    "verdict_words": Column("", "verdict as a sentence"),
    **_with_bounds("p_contact", "share of the motions that close the gap"),
    **_with_bounds("p_yield", "share of the motions in which a contact reaches its F_E; empty where all are infinite"),
    **_required(),
    "contact_model": Column("", "contact model of the runs"),
    "yield_force_N": Column("N", "F_E of floors that meet, else of columns, empty where infinite"),
    "impacts": Column("1", "number of impacts, median of the motions that touch"),
    "peak_force_N": Column("N", "peak contact force, median of the motions that touch; empty where a jump has none"),
    "motions": Column("1", "motions that the verdict is from"),
    "recordings": Column("1", "recordings that these are of"),
    "motions_scaled": BUILDING["motions_scaled"],
}


class Layer(NamedTuple):
    """A layer: its name, what its columns are, its rows, and a shape of shapely for each."""

    name: str
    columns: dict[str, Column]
    rows: list[dict[str, Any]]
    shapes: list[Any]


class Layers(NamedTuple):
    """Buildings and interfaces, the reference system of their coordinates, and sentences on what they are."""

    buildings: Layer
    interfaces: Layer
    crs: str | None
    notes: tuple[str, ...]


class Row(NamedTuple):
    """What a row of buildings is assessed as."""

    title: str
    case: RowCase
    assessment: Assessment
    closes: Any  # as `closing_motions`

    @property
    def buildings(self) -> list[str]:
        """Names of the buildings, from left to right."""
        return [building.name for building in self.case.buildings]

    def beside(self, index: int) -> list[int]:
        """The interfaces of a building."""
        return [k for k in (index - 1, index) if 0 <= k < len(self.assessment.interfaces)]

    def is_run(self, index: int) -> bool:
        """Whether the runs are at the assessed gap of an interface."""
        return abs(self.assessment.interfaces[index].gap - self.case.gaps[index]) <= SAME_GAP


def layers_of(datasets: Sequence[xr.Dataset], options: Options) -> Layers:
    """Layers of the rows of a street, one dataset each; raises PoundingError as `assess` and `row_case`."""
    members = [
        (str(results.attrs.get("title", "")), list(map(str, results["building"].values))) for results in datasets
    ]
    names = [(title, building) for title, buildings in members for building in buildings]
    if len(set(names)) < len(names):
        title, building = next(name for name in names if names.count(name) > 1)
        raise PoundingError(
            f"{building} of {title} is in two of the results; name those of each row once, and give each scene a name"
        )
    places: Places = nominal_places(members) if options.street is None else street_places(options.street, members)
    case_options: dict[str, Any] = {"gap": options.gap, "pga": options.pga, "intensity_level": options.intensity_level}
    rows = []
    for results in datasets:
        assessment = assess(results, **case_options)
        closing = closing_motions(results, assessment)
        rows.append(Row(assessment.title, row_case(results, **case_options), assessment, closing))
    buildings = [_building(row, index) for row in rows for index in range(len(row.buildings))]
    interfaces = [_interface(row, index) for row in rows for index in range(len(row.buildings) - 1)]
    return Layers(
        Layer("buildings", BUILDING, buildings, places.buildings),
        Layer("interfaces", INTERFACE, interfaces, places.interfaces),
        places.crs,
        (*places.notes, *dict.fromkeys(sentence for row in rows for sentence in _notes(row))),
    )


def closing_motions(results: xr.Dataset, assessment: Assessment) -> Array:
    """1 where a motion closes the assessed gap, 0 where not, NaN where it is lost, and the same of whether it may.

    (2, interfaces, motions), as `touching` has both.
    """
    closes = []
    for (_, interface), assessed in zip(Results(results).interfaces, assessment.interfaces, strict=True):
        motions = motions_of(interface)
        level = motions.amplitudes.index(assessed.amplitude)
        touches = touching(interface, motions, assessed.gap)[:, :, level]
        closes.append(np.where(motions.finite[:, level] & ~np.isnan(touches[0]), touches, nan))
    return np.stack(closes, axis=1)


def not_run_words(assessment: Assessment) -> Iterator[str]:
    """A sentence on each gap at which motions may bring contact that no run shows."""
    for one in assessment.interfaces:
        closing = np.array(one.closing)
        if (closing > one.run.below(one.gap)).sum() > (closing > one.gap).sum():
            yield f"{one.name}: contact at a gap of {say(one.gap, GAP)} is not known: {not_run(one.run, one.gap)}"


def lost_words(lost: int, motions: int) -> str:
    """Sentence on motions without a finite response in the shares of `share_of_building`."""
    return (
        f"{counted(lost, 'motion')} of {motions} without a finite response, such as where a storey collapses, count as "
        "contact at every gap, and as none in lower bounds"
    )


def share_of_building(closes: Array, weight: float, confidence: float) -> tuple[float, float, float]:
    """The share of the motions that close any gap of a building, with bounds; ``closes`` of its interfaces."""
    share = share_with_lost(closes, nan, weight, confidence)
    return share.probability, share.low_recordings, share.high_recordings


def _building(row: Row, index: int) -> dict[str, Any]:
    """The values of a building, in the order of `BUILDING`."""
    shape = row.case.buildings[index]
    verdicts = [row.assessment.interfaces[k].verdict for k in row.beside(index)]
    weight = min(verdict.independent / verdict.motions for verdict in verdicts)
    closes = row.closes[:, row.beside(index)]
    is_run = all(map(row.is_run, row.beside(index)))
    yields = any_of_building(row.case, "yield_exceedance", index)
    has_height = np.isfinite(row.case.results["building_height"].values[index])
    cells = [
        *(row.title, shape.name, shape.position, 0 if shape.is_rigid else len(shape.levels)),
        shape.height if has_height else nan,
        min((verdict.word for verdict in verdicts), key=WORST_FIRST.index),
        *share_of_building(closes, weight, row.assessment.confidence),
        *_share(yields if is_run else np.empty(0), weight, row.assessment.confidence),
        *(_raised(row, index, names) if is_run else nan for names in (DRIFTS, ACCELERATIONS)),
        closes.shape[-1],
        Results(row.case.results).amplitude_words(),
    ]
    return dict(zip(BUILDING, cells, strict=True))


def _raised(row: Row, index: int, names: Sequence[str]) -> float:
    """With contact over without, of the first of these outputs that a dataset has; NaN of one that has none."""
    from pounding_risk.figures.row import amplification

    known_names = [name for name in names if {name, f"{name}_free"} <= set(row.case.results.data_vars)]
    return amplification(row.case, index, known_names[0]) if known_names else nan


def _share(answers: Any, weight: float, confidence: float) -> tuple[float, float, float]:
    """The share of answers that are 1, with exact bounds of as many independent motions as they stand for."""
    known_answers = answers[np.isfinite(answers)]
    if not known_answers.size:
        return nan, nan, nan
    low, high = exact_bounds(known_answers.sum() * weight, known_answers.size * weight, confidence)
    return float(known_answers.mean()), float(low), float(high)


def _interface(row: Row, index: int) -> dict[str, Any]:
    """The values of an interface, in the order of `INTERFACE`."""
    assessed = row.assessment.interfaces[index]
    touch, force, is_run = row.case.touches[index], assessed.own_force, row.is_run(index)
    weight, confidence = assessed.verdict.independent / assessed.verdict.motions, row.assessment.confidence
    closing = np.pad(np.array(assessed.closing), (0, int(np.isnan(row.closes[0, index]).sum())), constant_values=inf)
    required = required_gaps(closing, weight, tuple(map(float, PERCENTILES)), confidence)
    cells = [
        *(row.title, assessed.name, row.buildings[index], row.buildings[index + 1], assessed.gap),
        *(assessed.verdict.word, assessed.verdict.sentence),
        *share_of_building(row.closes[:, [index]], weight, confidence),
        *(_yielding(assessed, force) if is_run else [nan] * 3),
        *(
            width if isfinite(width) else nan
            for gap in (need.in_row(assessed.run) for need in required)
            for width in (gap.shown, gap.low, gap.high if gap.bounded else nan)
        ),
        *(assessed.own_model, force if isfinite(force) else nan),
        *((touch.impacts, touch.force) if is_run else (nan, nan)),
        *(closing.size, assessed.verdict.recordings, assessed.at),
    ]
    return dict(zip(INTERFACE, cells, strict=True))


def _yielding(assessed: InterfaceAssessment, force: float) -> tuple[float, float, float]:
    """The share of the motions that reach F_E, with bounds by recording; NaN where F_E is infinite."""
    for share in assessed.yielding:
        if (share.gap, share.yield_force, share.contact_model) == (assessed.yield_gap, force, assessed.own_model):
            return share.probability, share.low_recordings, share.high_recordings
    return nan, nan, nan


def _notes(row: Row) -> list[str]:
    """Sentences on the case of a row."""
    of = row.assessment
    notes = [
        f"motions {Results(row.case.results).amplitude_words()}; {of.asked[0].lower()}{of.asked[1:]}".rstrip("."),
        "probabilities are shares of the motions of the scan, of no hazard and no period of time",
    ]
    if count := int(np.isnan(row.closes[0]).any(axis=0).sum()):
        notes.append(f"{row.title}: {lost_words(count, row.closes.shape[-1])}")
    notes += not_run_words(of)
    notes += [
        f"{one.name}: required gaps wider than {say(one.run.widest, GAP, 3)} are lower bounds: the row was run at none"
        for one in of.interfaces
        if any(need.at_least for need in one.required)
    ]
    failed = row.case.motions - min(touch.runs for touch in row.case.touches)
    if failed:
        cause = NOT_RUN if Results(row.case.results).unpushed else "failed"
        notes.append(f"{row.title}: {counted(failed, 'run')} {cause}, and count in no share that only runs can tell")
    notes += [
        f"{interface.name}: no run is at {say(interface.gap, GAP)}, the nearest are at {say(row.case.gaps[k], GAP)}: "
        "yielding, impacts, forces and amplifications are left empty"
        for k, interface in enumerate(of.interfaces)
        if not row.is_run(k)
    ]
    return notes
