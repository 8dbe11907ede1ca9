"""Amplification of two buildings by pounding over the ratio of their periods and the gap."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk.assessment.spectra import rule_words, usual_percentile
from pounding_risk.units import GAP, say

Array = NDArray[np.float64]

REQUIRED = "required"  # the gap that the motions need, as what gap shares are of
RAISED = 0.005  # of a percentile above 1, from which a finding speaks of amplification
OUTPUTS = ("displacement", "acceleration")


def gap_dim(results: xr.Dataset) -> str:
    """The dimension of the gaps: "gap" or "gap_share"."""
    return "gap_share" if "gap_share" in results.dims else "gap"


def gap_words(results: xr.Dataset, gap: float) -> str:
    """A gap in words: "a gap of 20 mm", "a gap of 0.5 SRSS"."""
    if gap_dim(results) == "gap":
        return f"a gap of {say(gap, GAP, 3)}"
    return f"a gap of {gap:.2g} {reference_name(results)}"


def reference_name(results: xr.Dataset) -> str:
    """What gap shares are of, in a word or two."""
    name = str(results.attrs["share_of"])
    return "times the gap required" if name == REQUIRED else rule_words(name)


def ratio_words(results: xr.Dataset) -> str:
    """The ratio of the periods as a formula: "T(frame) / T(masonry)"."""
    names = [str(name) for name in results["building"].values]
    fixed_side = ("left", "right").index(str(results.attrs["fixed"]))
    return f"T({names[1 - fixed_side]}) / T({names[fixed_side]})"


class Worst(NamedTuple):
    """Where a percentile of the amplification is largest."""

    value: float
    building: str
    ratio: float  # of the periods
    gap: float  # [m] or share
    period: float  # s, of the building that stays


def worst(results: xr.Dataset, stiffer: bool, output: str = "displacement", percentile: float | None = None) -> Worst:
    """The largest amplification of the stiffer building of each pair, or of the softer one.

    Where both periods are equal, both buildings count.
    """
    used_percentile = usual_percentile(results) if percentile is None else percentile
    amplified = results[f"{output}_amplification"].sel(percentile=used_percentile)
    periods = results["building_period"]
    own_period, other_period = periods, periods.isel(building=[1, 0]).assign_coords(building=periods["building"])
    is_kind = (own_period <= other_period) if stiffer else (own_period >= other_period)
    values = amplified.where(is_kind).transpose("fixed_period", "period_ratio", gap_dim(results), "building")
    if not np.isfinite(values.values).any():
        return Worst(1.0, "", float("nan"), float("nan"), float("nan"))
    index = np.unravel_index(int(np.nanargmax(values.values)), values.shape)
    cell = values[index]
    return Worst(
        float(cell),
        str(cell["building"].item()),
        float(cell["period_ratio"]),
        float(results[gap_dim(results)][index[2]]),
        float(cell["fixed_period"]),
    )


def finding(results: xr.Dataset, output: str = "displacement", percentile: float | None = None) -> str:
    """Sentence on how much contact raises the peak of the stiffer and of the softer building, and where."""
    used_percentile = usual_percentile(results) if percentile is None else percentile
    clauses = [f"{rise} ({where})" if where else rise for rise, where in rises(results, output, used_percentile)]
    return f"{raised_words(output, used_percentile)}: {'; '.join(clauses)}"


def raised_words(output: str, percentile: float) -> str:
    """The sentence that the figures of `rises` complete: the output and the share of the motions."""
    return f"Pounding raises the peak {output} that {percentile:g} % of the motions do not exceed"


def rises(results: xr.Dataset, output: str, percentile: float) -> list[tuple[str, str]]:
    """How much contact raises the peak of the stiffer and of the softer building, and where; "" where it does not."""
    clauses = []
    for stiffer, words in ((True, "the stiffer building"), (False, "the softer one")):
        place = worst(results, stiffer, output, percentile)
        if place.value < 1.0 + RAISED:
            clauses.append((f"{words} nowhere", ""))
            continue
        where = f"{ratio_words(results)} = {place.ratio:.2g} and {gap_words(results, place.gap)}"
        if results.sizes["fixed_period"] > 1:
            where += f", beside {place.period:.3g} s"
        clauses.append((f"{words} up to {place.value:.2f} times", where))
    return clauses


def told_words(results: xr.Dataset) -> str:
    """What the amplification is of, and what is left out."""
    left, right = (str(name) for name in results["building"].values)
    masses = [float(mass) for mass in results["building_mass"].values]
    model = str(results.attrs["contact_model"]).replace("_", " ")
    words = f"single masses, linear, m({left}) / m({right}) = {masses[0] / masses[1]:.3g}, contact {model}"
    jumps = "" if "acceleration_amplification" in results else "; its jumps have no finite acceleration"
    return f"{words}{jumps}; percentiles of the sample, without bounds"
