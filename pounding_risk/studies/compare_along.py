"""A comparison of contact models along axes of numbers of the scene: what it finds at each place, and how that changes.

It works on the dataset of `compare` alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import nan
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pounding_risk.errors import PoundingError
from pounding_risk.results.scene_axes import axes_of, open_axes, value_at
from pounding_risk.scene.scene_axis import SceneAxis
from pounding_risk.studies.compare_findings import (
    ALONE,
    FIRST_TWO,
    FLIPS,
    HARDLY,
    MODEL,
    NOTABLE,
    TOLD,
    UNTOUCHED,
    YIELDING,
    Moved,
    Verdict,
    aside,
    displacement_reaches,
    flip_share,
    furthest,
    interface_names,
    most_often,
    of_interface,
    peers,
    percent,
    reach,
    times_words,
    verdict,
    within_words,
    yields_otherwise,
)

if TYPE_CHECKING:
    import xarray as xr

# What a comparison of each place says: the axes have no effect on it where none of these changes.
COMPARED = ("ratio_low", "ratio_median", "ratio_high", "rank_agreement", "flips", "judged")

FLIPPED = ("displacement over 10 % off", "yielding or not", "required gap")  # `FLIPS` as heads of a table


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


def idle_axes(dataset: xr.Dataset) -> list[str]:
    """The axes along which nothing changes that is compared."""
    return [axis.name for axis in open_axes(dataset) if all(_is_same(dataset[name], axis.name) for name in COMPARED)]


def _is_same(values: xr.DataArray, axis: str) -> bool:
    first = values.isel({axis: [0]}).values
    return bool(np.all((values.values == first) | (np.isnan(values.values) & np.isnan(first))))


def places_along(dataset: xr.Dataset) -> Iterator[Place]:
    """Every place along the axes, the last axis fastest."""
    axes, idle = open_axes(dataset), idle_axes(dataset)
    tables = dataset.drop_vars([name for name, values in dataset.data_vars.items() if "record" in values.dims])
    single = {axis.name: 0 for axis in axes_of(dataset) if dataset.sizes.get(axis.name) == 1}
    for places in np.ndindex(*(dataset.sizes[axis.name] for axis in axes)):
        at = dict(zip((axis.name for axis in axes), map(int, places), strict=True))
        cells = {(axis.name, key): value_at(dataset, key, at[axis.name]) for axis in axes for key in axis.keys}
        words = ", ".join(f"{key} = {cell}" for (name, key), cell in cells.items() if name not in idle)
        yield Place(words, tuple(cells.values()), tables.isel(at | single))


def widest_along(dataset: xr.Dataset) -> int:
    """The interface whose peak relative displacement the laws move furthest at any place; as `widest_interface`."""
    return int(np.max([displacement_reaches(place.part) for place in places_along(dataset)], axis=0).argmax())


class Row(NamedTuple):
    """What a comparison says of an interface at a place along the axes."""

    cells: tuple[str, ...]  # the value of every key
    touched: int  # cases with contact under the baseline
    cases: int
    furthest: list[tuple[str, float, float]]  # law and range of the ratio, of displacement and force
    flips: list[str]  # how often at most each of `FLIPS` does, and under which law


def rows_along(dataset: xr.Dataset, index: int) -> Iterator[Row]:
    """What a table has of each place, at interface ``index``."""
    places = list(places_along(dataset))
    runs = dataset["impact_count"].size // dataset.sizes["contact_model"] // dataset.sizes.get("interface", 1)
    for place in places:
        part = of_interface(place.part, index)
        names, baseline = peers(part), str(part.attrs["baseline"])
        touched = int(part["judged"].sel(conclusion="displacement", contact_model=baseline))
        ranges = [furthest(part, output, names) if names else ("", nan, nan) for output in FIRST_TWO]
        flips = [_at_most(flip_share(part, conclusion, names), names) for conclusion in FLIPS]
        yield Row(place.cells, touched, runs // len(places), ranges, flips)


def _at_most(share: Any, names: list[str]) -> str:
    """How often at most, and under which law; – where nothing is judged."""
    most, law = most_often(share, names, [""])
    return "–" if np.isnan(most) else f"{percent(most)} ({law})" if most else "0 %"


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
    found = [(place, verdict(place.part)) for place in places_along(dataset)]
    baseline = str(dataset.attrs["baseline"])
    words = {
        MODEL: "the model matters",
        YIELDING: "yielding matters, which is F_E and not the model,",
        HARDLY: "the model hardly matters",
        UNTOUCHED: f"{baseline} has contact in no case",
        ALONE: f"no other law dissipates as {baseline} does",
    }
    at = {kind: [place.words for place, said in found if said.kind == kind] for kind in words}
    parts = [", ".join(f"{words[kind]} {_places(places, len(found))}" for kind, places in at.items() if places)]
    judged = [(place, said) for place, said in found if said.shares]
    if judged:
        parts += [*_moving(judged, baseline), *_flipping(judged)]
        parts += dict.fromkeys(sentence for place, said in judged for sentence in aside(place.part, said.names))
    idle = idle_axes(dataset)
    parts += [f"nothing that is compared depends on {' or '.join(idle)}"] if idle else []
    sentence = "; ".join(parts)
    return f"{sentence[0].upper()}{sentence[1:]}."


def _places(places: list[str], count: int) -> str:
    if len(places) == count:
        return f"at {'both' if count == 2 else f'all {count}'} places"
    return f"at {len(places)} of {count} places{_where(places[0]) if len(places) == 1 else ''}"


def _where(words: str) -> str:
    """That something holds at a place; "" where no axis has an effect."""
    return f" where {words}" if words else ""


def _moving(judged: list[tuple[Place, Verdict]], baseline: str) -> Iterator[str]:
    """Which outputs move most, under which law and where, and where the first of them moves least."""
    against = f"against {baseline}, "
    widest = _widest([(place, one) for place, said in judged for one in said.moved])
    if not widest:
        widest = _widest([(place, one) for place, said in judged for one in said.apart])
        against += f"{yields_otherwise(judged[0][0].part)}, "
    if not widest:
        yield within_words(baseline)
        return
    for place, (output, law, low, high) in widest[:TOLD]:
        yield f"{against}{output} is {times_words(low, high)} times as large ({law}){_where(place.words)}"
        if against:
            yield from _least(output, judged)
        against = ""
    if len(widest) > TOLD:
        yield f"{len(widest) - TOLD} more output{'s' * (len(widest) > TOLD + 1)} off by over {100 * NOTABLE:.0f} %"


def _widest(moved: list[tuple[Place, Moved]]) -> list[tuple[Place, Moved]]:
    """Of every output the place where it moves furthest, the output that moves furthest first."""
    widest: dict[str, tuple[Place, Moved]] = {}
    for place, one in sorted(moved, key=lambda entry: -reach(*entry[1][2:])):
        widest.setdefault(one[0], (place, one))
    return list(widest.values())


def _least(output: str, judged: list[tuple[Place, Verdict]]) -> Iterator[str]:
    """Where an output moves least, and how far; nothing where it moves alike at all places."""
    ranges = [(place, furthest(place.part, output, said.names)) for place, said in judged]
    known = sorted((entry for entry in ranges if reach(*entry[1][1:])), key=lambda entry: reach(*entry[1][1:]))
    place, (law, low, high) = known[0]
    if reach(low, high) < reach(*known[-1][1][1:]):
        yield f"it moves least{_where(place.words)}, {times_words(low, high)} times ({law})"


def _flipping(judged: list[tuple[Place, Verdict]]) -> Iterator[str]:
    """For each conclusion that is judged, how often at most it flips at any place, under which law and where."""
    interfaces = interface_names(judged[0][0].part)
    for conclusion, words in FLIPS.items():
        shares = [(*most_often(said.shares[conclusion], said.names, interfaces), place) for place, said in judged]
        known = [share for share in shares if not np.isnan(share[0])]
        if known:
            most, law, place = max(known, key=lambda share: share[0])
            often = f"up to {percent(most)} of the cases ({law}){_where(place.words)}"
            yield f"{words} in {often if most > 0.0 else 'none'}"
