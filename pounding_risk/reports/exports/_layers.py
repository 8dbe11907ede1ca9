"""Buildings and interfaces of rows as layers of a map: what is known of each, and where it is.

Names of columns end in their unit, ``_m`` or ``_N``; shares and ratios have none. `BUILDING` and `INTERFACE` say what
each column is. Probabilities of interfaces are those of `assess`, of buildings shares of the runs of one case.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, nan
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk.assessment.assess import Assessment, InterfaceAssessment, assess
from pounding_risk.assessment.proportions import exact_bounds
from pounding_risk.assessment.row import RowCase, any_of_building, row_case
from pounding_risk.assessment.verdict import ADEQUATE, DEPENDS, INADEQUATE
from pounding_risk.errors import PoundingError
from pounding_risk.reports.exports._outlines import Places, nominal_places, street_places
from pounding_risk.reports.exports._written import Asked
from pounding_risk.results.amplitudes import amplitude_words
from pounding_risk.units import GAP, say

if TYPE_CHECKING:
    import xarray as xr

WORST_FIRST = (INADEQUATE, DEPENDS, ADEQUATE)
PERCENTILES = (50, 84, 95)
SAME_GAP = 1e-9  # m
DRIFTS, ACCELERATIONS = ("peak_drift", "peak_displacement"), ("peak_floor_acceleration",)  # of a single mass the second


class Column(NamedTuple):
    """What a column holds: its unit as of UDUNITS ("1" of a share, a ratio or a count, "" of text), and its words."""

    unit: str
    words: str


def _with_bounds(name: str, words: str) -> dict[str, Column]:
    ends = {"": words, "_low": f"lower bound of {name}", "_high": f"upper bound of {name}"}
    return {f"{name}{ending}": Column("1", said) for ending, said in ends.items()}


def _required() -> dict[str, Column]:
    columns = {}
    for percentile in PERCENTILES:
        name = f"required_gap_p{percentile}"
        columns[f"{name}_m"] = Column("m", f"gap that {percentile} % of the motions do not close")
        columns |= {f"{name}_{end}_m": Column("m", f"bound of {name}_m by recording") for end in ("low", "high")}
    return columns


BUILDING: dict[str, Column] = {
    "row": Column("", "row of buildings, the title of its scene"),
    "building": Column("", "name of the building"),
    "position": Column("", "end or interior of the row, or alone"),
    "storeys": Column("1", "number of storeys, 0 of a rigid building"),
    "height_m": Column("m", "level of the roof above the ground"),
    "verdict": Column("", "the worst verdict on its gaps: inadequate, depends or adequate"),
    **_with_bounds("p_contact", "share of the motions in which it touches a neighbour"),
    **_with_bounds("p_yield", "share of the motions in which a contact of it reaches F_E; empty where F_E is infinite"),
    "drift_amplification": Column("1", "largest storey drift with contact over without, median of motions that touch"),
    "acceleration_amplification": Column("1", "largest acceleration with contact over without, likewise"),
    "runs": Column("1", "motions whose run is complete"),
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
    **_with_bounds("p_yield", "share of the motions whose contact force reaches F_E; empty where F_E is infinite"),
    **_required(),
    "runs_gap_m": Column("m", "gap of the grid that the runs of p_yield and peak_force_N are at"),
    "contact_model": Column("", "contact model of these runs"),
    "yield_force_N": Column("N", "yield force F_E of these runs, empty where infinite"),
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
    told: tuple[str, ...]


class Row(NamedTuple):
    """What a row of buildings is assessed as."""

    title: str
    case: RowCase
    assessment: Assessment

    @property
    def buildings(self) -> list[str]:
        """Names, left to right."""
        return [building.name for building in self.case.buildings]


def layers_of(datasets: Sequence[xr.Dataset], asked: Asked) -> Layers:
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
    places: Places = nominal_places(members) if asked.street is None else street_places(asked.street, members)
    rows = [_row(results, asked) for results in datasets]
    buildings = [_building(row, at) for row in rows for at in range(len(row.buildings))]
    interfaces = [_interface(row, at) for row in rows for at in range(len(row.buildings) - 1)]
    return Layers(
        Layer("buildings", BUILDING, buildings, places.buildings),
        Layer("interfaces", INTERFACE, interfaces, places.interfaces),
        places.crs,
        (*places.told, *dict.fromkeys(sentence for row in rows for sentence in _told(row))),
    )


def _row(results: xr.Dataset, asked: Asked) -> Row:
    chosen: dict[str, Any] = {"gap": asked.gap, "pga": asked.pga, "intensity_level": asked.intensity_level}
    assessment = assess(results, **chosen)
    case = row_case(results, **chosen)
    return Row(assessment.title, case, assessment)


def _building(row: Row, at: int) -> dict[str, Any]:
    """The values of a building, in the order of `BUILDING`."""
    shape = row.case.buildings[at]
    beside = [row.assessment.interfaces[k] for k in (at - 1, at) if 0 <= k < len(row.assessment.interfaces)]
    weight = min(one.verdict.independent / one.verdict.motions for one in beside)
    touches, yields = (any_of_building(row.case, name, at) for name in ("impact_count", "yield_exceedance"))
    known = np.isfinite(row.case.results["building_height"].values[at])
    values = [
        *(row.title, shape.name, shape.position, 0 if shape.is_rigid else len(shape.levels)),
        shape.height if known else nan,
        min((one.verdict.word for one in beside), key=WORST_FIRST.index),
        *_share(touches, weight, row.assessment.confidence),
        *_share(yields if np.isfinite(_force(row)) else np.full(1, nan), weight, row.assessment.confidence),
        *(_raised(row, at, names) for names in (DRIFTS, ACCELERATIONS)),
        int(np.isfinite(touches).sum()),
        amplitude_words(row.case.results),
    ]
    return dict(zip(BUILDING, values, strict=True))


def _raised(row: Row, at: int, names: Sequence[str]) -> float:
    """With contact over without, of the first of these outputs that a dataset has; NaN of one that has none."""
    from pounding_risk.figures.storey_profiles import amplification

    known = [name for name in names if {name, f"{name}_free"} <= set(row.case.results.data_vars)]
    return amplification(row.case, at, known[0]) if known else nan


def _share(answers: Any, weight: float, confidence: float) -> tuple[float, float, float]:
    """The share of answers that are 1, with exact bounds of as many independent motions as they stand for."""
    known = answers[np.isfinite(answers)]
    if not known.size:
        return nan, nan, nan
    low, high = exact_bounds(known.sum() * weight, known.size * weight, confidence)
    return float(known.mean()), float(low), float(high)


def _force(row: Row) -> float:
    """F_E of the runs [N]."""
    return float(row.case.results["yield_force"])


def _interface(row: Row, at: int) -> dict[str, Any]:
    """The values of an interface, in the order of `INTERFACE`."""
    one = row.assessment.interfaces[at]
    contact, touch = one.contact_at_gap(), row.case.touches[at]
    required = [one.required_at(percentile) for percentile in PERCENTILES]
    force = _force(row)
    values = [
        *(row.title, one.name, row.buildings[at], row.buildings[at + 1], one.gap),
        *(one.verdict.word, one.verdict.sentence),
        *(contact.probability, contact.low_recordings, contact.high_recordings),
        *_yielding(one, force),
        *(value for gap in required for value in (gap.gap, gap.low, gap.high if gap.bounded else nan)),
        *(row.case.gaps[at], one.own_model, force if isfinite(force) else nan, touch.impacts, touch.force),
        *(one.verdict.motions, one.verdict.recordings, one.at),
    ]
    return dict(zip(INTERFACE, values, strict=True))


def _yielding(one: InterfaceAssessment, force: float) -> tuple[float, float, float]:
    """The share of the motions that reach F_E, with bounds by recording; NaN where F_E is infinite."""
    for share in one.yielding:
        if (share.gap, share.yield_force, share.contact_model) == (one.yield_gap, force, one.own_model):
            return share.probability, share.low_recordings, share.high_recordings
    return nan, nan, nan


def _told(row: Row) -> list[str]:
    """Sentences on the case of a row."""
    of = row.assessment
    told = [
        f"motions {amplitude_words(row.case.results)}; {of.asked[0].lower()}{of.asked[1:]}".rstrip("."),
        "probabilities are shares of the motions of the scan, of no hazard and no period of time",
    ]
    failed = row.case.motions - min(touch.runs for touch in row.case.touches)
    if failed:
        told.append(f"{row.title}: {counted(failed, 'run')} failed, and count in no share of a building")
    for at, interface in enumerate(of.interfaces):
        if abs(interface.gap - row.case.gaps[at]) > SAME_GAP:
            told.append(
                f"{interface.name}: runs are those at {say(row.case.gaps[at], GAP)}, the grid's nearest to "
                f"{say(interface.gap, GAP)}"
            )
    return told
