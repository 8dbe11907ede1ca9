"""Contact and required gaps along axes of other numbers of the scene: at each place as `assess` has them there."""

from __future__ import annotations

import json
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from pounding_risk._common.counted import counted
from pounding_risk.assessment.demands import contact_of
from pounding_risk.assessment.options import USUAL_CONFIDENCE, percent_words, read_criterion
from pounding_risk.errors import PoundingError
from pounding_risk.results.files import open_scan, opened_or_given
from pounding_risk.results.opened import Results
from pounding_risk.results.scene_axes import has_drawn_motions, idle_axes, open_axes, own_places, value_at
from pounding_risk.results.variables import described
from pounding_risk.scene.scene_axis import SAMPLE, SceneAxis
from pounding_risk.statistics.required_gap import rounded_up
from pounding_risk.units import GAP, say

OWN, IDLE = "own_places", "idle_axes"  # attributes: where the scene's own values stand, and axes without influence
JUDGED = ("contact_probability", "required_gap", "assessed_gap")
# What is known at each place and interface, with its unit and words.
OUTPUTS = {
    "assessed_gap": ("m", "gap that is assessed"),
    "contact_probability": ("1", "share of the motions that close it"),
    "contact_probability_low": ("1", "lower bound of the probability of contact, by recording"),
    "contact_probability_high": ("1", "upper bound of the probability of contact, by recording"),
    "required_gap": ("m", "gap that is enough for the percentile of the motions"),
    "required_gap_low": ("m", "lower bound of the required gap, by recording"),
    "required_gap_high": ("m", "upper bound of the required gap; the largest seen where so few do not bound it"),
    "required_gap_bounded": (
        "1",
        "1 with an upper bound of the required gap, 0 with too few recordings, -1 without a run of the row",
    ),
    "motions_without_response": ("1", "motions without a finite response, for which no gap is wide enough"),
}


def assess_along(
    results: xr.Dataset | str | Path,
    *,
    gap: float | str | None = None,
    confidence: float | str = USUAL_CONFIDENCE,
    percentile: float | str | None = None,
    target: float | str | None = None,
    pga: float | str | None = None,
    intensity_level: float | str | None = None,
) -> xr.Dataset:
    """Assess contact at every place along the axes of other numbers of the scene, by the rules of `assess`.

    Parameters
    ----------
    results : xarray.Dataset, str or Path
        A dataset of `scan` with such axes, or the file it is in; a part of it that ``sel`` left is as good.
    gap : float or str, optional
        The gap to assess [m, or text with a unit], at every interface; that of the scene by default.
    confidence : float or str
        Confidence of all bounds, above 50 %.
    percentile : float or str, optional
        Share of the motions whose required gap is given; as of `assess`.
    target : float or str, optional
        Accepted probability of contact; what the percentile leaves by default.
    pga : float or str, optional
        Amplitude of the grid to assess [m/s2, or text with a unit]; as of `assess`.
    intensity_level : float or str, optional
        The same for a grid of any measure; as of `assess`.

    Returns
    -------
    xarray.Dataset
        Along the axes and ``interface``: ``assessed_gap`` [m], ``contact_probability`` and ``required_gap`` [m], the
        last two with bounds by recording (``..._low``, ``..._high``; without one from above where
        ``required_gap_bounded`` is not 1), and ``motions_without_response``, in which such
        as a storey collapses: no gap is wide enough for them. The attribute ``asked`` says what was asked,
        ``own_places`` at which place of each axis the scene's own value stands, ``idle_axes`` which axes change nothing
        here (both as JSON).

    Raises
    ------
    PoundingError
        As `assess`, for a dataset that has one place along each axis, which `assess` takes, and for samples each of
        which has a motion of its own.
    """
    scan, source = opened_or_given(results, "the dataset")
    axes = open_axes(scan)
    if not axes:
        raise PoundingError(f"{source}: has no axis of another number of the scene with several values; use assess")
    _check_samples(scan, source, axes)
    criterion = read_criterion(target, percentile, confidence)
    gap_value, level = Results(scan).read_gap(gap), Results(scan).level(pga, intensity_level)
    sizes = tuple(scan.sizes[axis.name] for axis in axes)
    columns: dict[str, Any] = {}
    at, names = "", []
    for places in product(*map(range, sizes)):
        cell = {axis.name: [place] for axis, place in zip(axes, places, strict=True)}
        opened = open_scan(scan.isel(cell), source)
        names = [name for name, _ in opened.interfaces]
        for index, (_, interface) in enumerate(opened.interfaces):
            contact = contact_of(interface, index, gap_value, level, criterion)
            (share, required), at = contact.with_lost(criterion), contact.at
            shares = contact.gap, share.probability, share.low_recordings, share.high_recordings
            bound_kind = -1.0 if required.is_pushed else required.bounded
            numbers = *shares, required.shown, required.low, required.high, bound_kind, contact.lost
            for name, number in zip(OUTPUTS, numbers, strict=True):
                columns.setdefault(name, np.full((*sizes, len(names)), np.nan))[(*places, index)] = number
    dims = (*(axis.name for axis in axes), "interface")
    keys = [key for axis in axes for key in axis.keys]
    coords = {key: scan[key] for key in keys} | {"interface": scan["interface"]}
    assessed = xr.Dataset(
        {name: (dims, columns[name], described(*facts)) for name, facts in OUTPUTS.items()},
        {name: coordinate.variable for name, coordinate in coords.items()},
    )
    facts = criterion._asdict() | {"title": str(scan.attrs.get("title", "")), "asked": criterion.words, "motions": at}
    facts |= {OWN: json.dumps(own_places(scan)), IDLE: json.dumps(idle_axes(assessed, axes, JUDGED))}
    return assessed.assign_attrs(facts)


def _check_samples(dataset: xr.Dataset, source: str, axes: Sequence[SceneAxis]) -> None:
    """Raise PoundingError where samples differ by their motions too."""
    if has_drawn_motions(dataset) and SAMPLE in [axis.name for axis in axes]:
        options_text = " ".join(f"--select '{axis.name}=...'" for axis in axes if axis.name != SAMPLE)
        raise PoundingError(
            f"{source}: one motion is drawn with each sample, so that samples differ by their motions too: assess one "
            f"sample, with --select 'sample=0', or all of them together"
            + (f", at one value of what varies beside them: {options_text}" if options_text else ", with uncertainty")
        )


def is_along(assessed: Any) -> bool:
    """Whether a dataset is one of `assess_along`."""
    return set(OUTPUTS) <= set(getattr(assessed, "data_vars", ())) and OWN in assessed.attrs


class Place(NamedTuple):
    """A place along the axes of a dataset at which the whole assessment stands."""

    places: dict[str, int]  # by axis
    words: str  # "building.left.period = 0.5 s"
    why: str  # "the scene's own values", "those that need the widest gap"


def usual_place(assessed: xr.Dataset) -> Place:
    """The place of the scene's own values; along axes without them, that which needs the widest gap."""
    axes = [str(dim) for dim in assessed.dims if dim != "interface"]
    own_at = {name: int(place) for name, place in json.loads(assessed.attrs[OWN]).items() if name in axes}
    other_axes = [axis for axis in axes if axis not in own_at]
    places = dict(own_at)
    if other_axes:
        gaps = assessed["required_gap"].isel(own_at).transpose(*other_axes, "interface").max("interface").values
        widest_at = np.unravel_index(int(gaps.argmax()), gaps.shape)
        places |= {axis: int(place) for axis, place in zip(other_axes, widest_at, strict=True)}
    widest = "those that need the widest gap"
    axes_text = " and ".join(filter(None, [", ".join(other_axes[:-1]), *other_axes[-1:]]))
    reason = f"the scene's own values{f', and of {axes_text} {widest}' if other_axes else ''}" if own_at else widest
    return Place(places, ", ".join(value_words(assessed, axis, places[axis]) for axis in axes), reason)


def value_words(assessed: xr.Dataset, axis: str, place: int) -> str:
    """The value along an axis at a place, and those that move with it: "building.frame.mass = 500 t"."""
    keys = [str(key) for key, coordinate in assessed.coords.items() if coordinate.dims == (axis,)]
    return ", ".join(f"{key} = {value_at(assessed, key, place)}" for key in keys)


def along_finding(assessed: xr.Dataset) -> str:
    """Sentence on how far the probability of contact and the required gap change along the axes, and where most."""
    share, required = assessed["contact_probability"], assessed["required_gap"]
    axes = [str(dim) for dim in assessed.dims if dim != "interface"]
    order = required.transpose(*axes, "interface")
    widest = np.unravel_index(int(order.values.argmax()), order.shape)
    idle = json.loads(assessed.attrs[IDLE])
    place_text = ", ".join(
        value_words(assessed, axis, int(place)) for axis, place in zip(axes, widest, strict=False) if axis not in idle
    )
    interface_text = f" at {assessed['interface'].values[widest[-1]]}" if assessed.sizes["interface"] > 1 else ""
    gap = assessed["assessed_gap"].values
    gap_text = f" of {say(float(gap.flat[0]), GAP, 6)}" if np.ptp(gap) == 0.0 else ""

    def between(low: str, high: str) -> str:
        return f"is {low}" if low == high else f"lies from {low} to {high}"

    shares_text = between(*(f"{100 * float(end):.3g} %" for end in (share.min(), share.max())))
    gaps_text = between(*(_gap_words(float(end)) for end in (required.min(), required.max())))
    most_text = f" (the most where {place_text}{interface_text})" if place_text else interface_text
    return f"The gap required {gaps_text}{most_text}; P(contact){gap_text} {shares_text}"


def _gap_words(gap: float) -> str:
    return say(rounded_up(gap), GAP, 3) if np.isfinite(gap) else "∞ (no gap is wide enough)"


def lost_words(assessed: xr.Dataset) -> str:
    """Sentence on motions without a finite response; "" where there are none."""
    counts = assessed["motions_without_response"]
    if not counts.any():
        return ""
    places = int((counts.transpose(..., "interface").values > 0).any(axis=-1).sum())
    return (
        f"at {counted(places, 'place')} motions have no finite response, up to {int(counts.max())} of them: they count "
        "as contact at every gap, and as none in the lower bounds"
    )


def kept_words(assessed: xr.Dataset) -> str:
    """Sentence on where P(contact) and its upper bound are within the target, at every interface of a row."""
    share, high = (assessed[f"contact_probability{end}"].max("interface") for end in ("", "_high"))
    scope = " at every interface" if assessed.sizes["interface"] > 1 else ""
    target = float(assessed.attrs["target"])
    return (
        f"P(contact){scope} is within the target of {percent_words(target)} {_places(assessed, share <= target)}, "
        f"its upper bound {_places(assessed, high <= target)}"
    )


def _places(assessed: xr.Dataset, holds: xr.DataArray) -> str:
    """The places that are true, in words: from one value of the only axis on, or their number."""
    if holds.all() or not holds.any():
        return "everywhere" if holds.all() else "nowhere"
    count_text = f"at {int(holds.sum())} of {holds.size} places"
    if holds.ndim > 1:
        return count_text
    axis = str(holds.dims[0])
    is_number = holds[axis].dtype.kind in "if"
    order = holds[axis].values.argsort() if is_number else np.arange(holds.size)
    flags = holds.values[order]
    words = [value_words(assessed, axis, int(place)) for place in order[flags]]
    if is_number and (flags == np.sort(flags)).all():
        return f"where {words[0]} or more"
    if is_number and (flags == np.sort(flags)[::-1]).all():
        return f"where {words[-1]} or less"
    return f"{count_text} ({'; '.join(words)})"


def idle_words(assessed: xr.Dataset) -> str:
    """Sentence on the axes that make no difference; "" where all do."""
    idle = json.loads(assessed.attrs[IDLE])
    if not idle:
        return ""
    return f"neither P(contact) nor the gap required depends on {', '.join(idle)}"
