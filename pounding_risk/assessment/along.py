"""Contact and required gaps along axes of other numbers of the scene: at each place as `assess` has them there."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.assessment.assess import Options, contact_of
from pounding_risk.assessment.demands import check_dataset, interfaces
from pounding_risk.assessment.options import USUAL_CONFIDENCE, read_criterion
from pounding_risk.errors import PoundingError
from pounding_risk.results.amplitudes import level_asked
from pounding_risk.results.files import open_results
from pounding_risk.results.scene_axes import open_axes
from pounding_risk.results.selected_axes import with_axes
from pounding_risk.results.variables import described
from pounding_risk.units import GAP, si

if TYPE_CHECKING:
    import xarray as xr

# What is known at each place and interface, with its unit and words.
OUTPUTS = {
    "assessed_gap": ("m", "gap that is assessed"),
    "contact_probability": ("1", "share of the motions that close it"),
    "contact_probability_low": ("1", "lower bound of the probability of contact, by recording"),
    "contact_probability_high": ("1", "upper bound of the probability of contact, by recording"),
    "required_gap": ("m", "gap that the percentile of the motions needs"),
    "required_gap_low": ("m", "lower bound of the required gap, by recording"),
    "required_gap_high": ("m", "upper bound of the required gap; the largest seen where so few do not bound it"),
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
        last two with bounds by recording (``..._low``, ``..._high``). The attribute ``asked`` says what was asked.

    Raises
    ------
    PoundingError
        As `assess`, and for a dataset that has one place along each axis, which `assess` takes.
    """
    import xarray as xr

    whole = open_results(results) if isinstance(results, str | Path) else results
    whose = str(results) if isinstance(results, str | Path) else "the dataset"
    axes = open_axes(whole)
    if not axes:
        raise PoundingError(f"{whose}: has no axis of another number of the scene with several values; use assess")
    criterion = read_criterion(target, percentile, confidence)
    options = Options(
        None if gap is None else si(gap, GAP._replace(open_high=True), "gap"),
        None,
        criterion,
        "pga",
        level_asked(whole, pga, intensity_level),
        None,
    )
    sizes = tuple(whole.sizes[axis.name] for axis in axes)
    values: dict[str, Any] = {}
    at, names = "", []
    for places in product(*map(range, sizes)):
        chosen = {axis.name: [place] for axis, place in zip(axes, places, strict=True)}
        part = with_axes(whole.isel(chosen), whose)
        check_dataset(part, whose)
        names = [str(name) for name in part["interface"].values]
        for index, (_, one) in enumerate(interfaces(part)):
            contact = contact_of(one, index, options)
            share, need, at = contact.at_gap, contact.required[criterion.percentile], contact.at
            told = (contact.gap, share.probability, share.low_recordings, share.high_recordings)
            for name, value in zip(OUTPUTS, (*told, need.gap, need.low, need.high), strict=True):
                values.setdefault(name, np.full((*sizes, len(names)), np.nan))[(*places, index)] = value
    dims = (*(axis.name for axis in axes), "interface")
    keys = [key for axis in axes for key in axis.keys]
    coords = {key: whole[key] for key in keys} | {"interface": whole["interface"]}
    assessed = xr.Dataset(
        {name: (dims, values[name], described(*about)) for name, about in OUTPUTS.items()},
        {name: coordinate.variable for name, coordinate in coords.items()},
    )
    about = criterion._asdict() | {"title": str(whole.attrs.get("title", "")), "asked": criterion.words, "motions": at}
    return assessed.assign_attrs(about)
