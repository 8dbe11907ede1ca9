"""A comparison of contact models along axes of numbers of the scene: what it finds at each place, and how that changes.

It works on the dataset of `compare` alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from pounding_risk.errors import PoundingError
from pounding_risk.results.scene_axes import axes_of, idle_axes, open_axes, value_at
from pounding_risk.scene.scene_axis import SceneAxis
from pounding_risk.studies import compare_findings as findings
from pounding_risk.studies.compare_findings import Moved, Verdict

# What a comparison of each place says: the axes have no effect on it where none of these changes.
COMPARED = ("ratio_low", "ratio_median", "ratio_high", "rank_agreement", "flips", "judged")


class Place(NamedTuple):
    """A place along the axes of a comparison."""

    words: str  # "building.left.period = 0.5 s", of the axes that have an effect
    cells: tuple[str, ...]  # the value of every key of the axes with several values
    part: xr.Dataset  # what the comparison says there


def is_along(dataset: xr.Dataset) -> bool:
    """Whether a comparison has several places along axes of numbers of its scene."""
    return bool(open_axes(dataset))


def keys_along(dataset: xr.Dataset) -> list[str]:
    """What varies along the axes with several places."""
    return [key for axis in open_axes(dataset) for key in axis.keys]


def places_along(dataset: xr.Dataset) -> Iterator[Place]:
    """Every place along the axes, the last axis fastest."""
    axes = open_axes(dataset)
    idle = idle_axes(dataset, axes, COMPARED)
    tables = dataset.drop_vars([name for name, variable in dataset.data_vars.items() if "record" in variable.dims])
    single = {axis.name: 0 for axis in axes_of(dataset) if dataset.sizes.get(axis.name) == 1}
    for places in np.ndindex(*(dataset.sizes[axis.name] for axis in axes)):
        indices = dict(zip((axis.name for axis in axes), map(int, places), strict=True))
        cells = {(axis.name, key): value_at(dataset, key, indices[axis.name]) for axis in axes for key in axis.keys}
        words = ", ".join(f"{key} = {cell}" for (name, key), cell in cells.items() if name not in idle)
        yield Place(words, tuple(cells.values()), tables.isel(indices | single))


def widest_along(dataset: xr.Dataset) -> int:
    """The interface whose peak relative displacement the laws move furthest at any place; as `widest_interface`."""
    return int(np.max([findings.displacement_reaches(place.part) for place in places_along(dataset)], axis=0).argmax())


def check_drawn(axes: Sequence[SceneAxis], what: str) -> None:
    """Raise PoundingError for more than one axis with several places, with how to choose a place along the others."""
    several = [axis for axis in axes if axis.size > 1]
    if len(several) > 1:
        choices = " ".join(f"--select '{axis.name}={axis.values[0][0]}'" for axis in several[1:])
        raise PoundingError(
            f"{what}: the comparison lies along {' and '.join(axis.name for axis in several)}, and the figure has one "
            f"axis; choose a value along the others, such as {choices}"
        )


def along_finding(dataset: xr.Dataset) -> str:
    """One sentence: where the model matters along the axes, which law moves which output most where, and what flips."""
    verdicts = [(place, findings.verdict(place.part)) for place in places_along(dataset)]
    baseline, count = str(dataset.attrs["baseline"]), len(verdicts)
    kinds = {
        findings.MODEL: "the model matters",
        findings.YIELDING: "yielding matters, which is F_E and not the model,",
        findings.HARDLY: "the model hardly matters",
        findings.UNTOUCHED: f"{baseline} has contact in no case",
        findings.ALONE: f"no other law dissipates as {baseline} does",
    }
    by_kind = []
    for kind, words in kinds.items():
        places = [place.words for place, outcome in verdicts if outcome.kind == kind]
        if len(places) == count:
            by_kind.append(f"{words} at {'both' if count == 2 else f'all {count}'} places")
        elif places:
            by_kind.append(f"{words} at {len(places)} of {count} places{_where(places[0]) if len(places) == 1 else ''}")
    clauses = [", ".join(by_kind)]
    judged = [(place, outcome) for place, outcome in verdicts if outcome.shares]
    if judged:
        clauses += [*_moving(judged, baseline), *_flipping(judged)]
        asides = (findings.aside(place.part, outcome.names) for place, outcome in judged)
        clauses += dict.fromkeys(sentence for sentences in asides for sentence in sentences)
    idle = idle_axes(dataset, open_axes(dataset), COMPARED)
    clauses += [f"nothing that is compared depends on {' or '.join(idle)}"] if idle else []
    sentence = "; ".join(clauses)
    return f"{sentence[0].upper()}{sentence[1:]}."


def _where(words: str) -> str:
    """That something holds at a place; "" where no axis has an effect."""
    return f" where {words}" if words else ""


def _moving(judged: list[tuple[Place, Verdict]], baseline: str) -> Iterator[str]:
    """Which outputs move most, under which law and where, and where the first of them moves least."""
    against = f"against {baseline}, "
    widest = _widest([(place, moved) for place, outcome in judged for moved in outcome.moved])
    if not widest:
        widest = _widest([(place, moved) for place, outcome in judged for moved in outcome.moved_by_yielding])
        against += f"{findings.yields_otherwise(judged[0][0].part)}, "
    if not widest:
        yield findings.within_words(baseline)
        return
    for place, (output, law, low, high) in widest[: findings.NUMBERED]:
        yield f"{against}{output} is {findings.times_words(low, high)} times as large ({law}){_where(place.words)}"
        if against:
            yield from _least(output, judged)
        against = ""
    if (more_count := len(widest) - findings.NUMBERED) > 0:
        yield f"{more_count} more output{'s' * (more_count > 1)} off by over {100 * findings.NOTABLE:.0f} %"


def _widest(moved: list[tuple[Place, Moved]]) -> list[tuple[Place, Moved]]:
    """Of every output the place where it moves furthest, the output that moves furthest first."""
    widest: dict[str, tuple[Place, Moved]] = {}
    for place, output in sorted(moved, key=lambda pair: -findings.reach(*pair[1][2:])):
        widest.setdefault(output[0], (place, output))
    return list(widest.values())


def _least(output: str, judged: list[tuple[Place, Verdict]]) -> Iterator[str]:
    """Where an output moves least, and how far; nothing where it moves alike at all places."""
    ranges = [(place, findings.furthest(place.part, output, outcome.names)) for place, outcome in judged]
    ranked = sorted(
        (moved for moved in ranges if findings.reach(*moved[1][1:])), key=lambda moved: findings.reach(*moved[1][1:])
    )
    place, (law, low, high) = ranked[0]
    if findings.reach(low, high) < findings.reach(*ranked[-1][1][1:]):
        yield f"it moves least{_where(place.words)}, {findings.times_words(low, high)} times ({law})"


def _flipping(judged: list[tuple[Place, Verdict]]) -> Iterator[str]:
    """For each conclusion that is judged, how often at most it flips at any place, under which law and where."""
    interfaces = findings.interface_names(judged[0][0].part)
    for conclusion, words in findings.FLIPS.items():
        shares = [
            (*findings.most_frequent_flip(outcome.shares[conclusion], outcome.names, interfaces), place)
            for place, outcome in judged
        ]
        judged_shares = [share for share in shares if not np.isnan(share[0])]
        if judged_shares:
            most, law, place = max(judged_shares, key=lambda share: share[0])
            often = f"up to {findings.percent(most)} of the cases ({law}){_where(place.words)}"
            yield f"{words} in {often if most > 0.0 else 'none'}"
