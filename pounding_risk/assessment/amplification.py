"""Amplification of two buildings by pounding over the ratio of their periods and the gap."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.progress import Progress
from pounding_risk._common.words import nearest
from pounding_risk.assessment.options import USUAL_PERCENTILE
from pounding_risk.assessment.spectra import charted, read_percentiles, rule_words, spread, usual_percentile, with_rules
from pounding_risk.errors import PoundingError
from pounding_risk.results.kinds import kind_of
from pounding_risk.units import GAP, say, shown

if TYPE_CHECKING:
    import xarray as xr

    from pounding_risk.motions.request import RecordRequest
    from pounding_risk.scene.records import Records
    from pounding_risk.scene.scene import Scene

Array = NDArray[np.float64]

PERCENTILES = (16.0, 50.0, 84.0)
REQUIRED = "required"  # the gap that the motions need, as what gap shares are of
RATIOS, GAP_SHARES = (0.2, 5.0), (0.1, 1.3)
RAISED = 0.005  # of a percentile above 1, from which a finding speaks of amplification
OUTPUTS = ("displacement", "acceleration")


def amplification(
    source: Scene | Mapping[str, Any] | str | Path | Records | RecordRequest,
    out: str | Path | None = None,
    *,
    ratios: Sequence[float | str] = RATIOS,
    num: int = 31,
    spacing: str = "log",
    fixed: str = "right",
    periods: float | str | Sequence[float | str] | None = None,
    gaps: Sequence[float | str] | None = None,
    gap_shares: Sequence[float | str] | None = None,
    num_gaps: int = 13,
    share_of: str = "srss",
    share_percentile: float | str = USUAL_PERCENTILE,
    damping: float | str | Sequence[float | str] | None = None,
    mass_ratio: float | None = None,
    percentiles: Sequence[float | str] = PERCENTILES,
    motions: bool = False,
    workers: int | None = None,
    new: bool = False,
    progress: Progress | None = None,
) -> xr.Dataset:
    """What pounding adds, over the period ratio and the gap.

    Amplification is the peak of a building with contact over its peak without, under the same motion: 1 where nothing
    touches. One building stays as it is, the other's period is the ratio times its period, with the mass that it has.
    Each pair of periods is run at every gap under every motion as `scan` would run it.

    Parameters
    ----------
    source : Scene, dict, path or Records
        A scene of two single masses, with its contact model, yield force, records, their amplitude and polarities; of
        several of a grid the scene's own, or the largest amplitude. Or records, under which two masses of 1000 t stand
        whose velocities jump at a touch (stereomechanical, restitution 0.65), so that their ratio alone counts.
    out : str or path, optional
        File for the dataset, ``.nc``.
    ratios : sequence of float
        The smallest and the largest ratio of the varied period to the one that stays, or three and more in rising
        order.
    num : int
        Ratios of a range, from 2 to 1000.
    spacing : {"log", "linear"}
        How they are spaced.
    fixed : str
        The building that stays: "left", "right" or its name.
    periods : float or str, or a sequence of them, optional
        Periods of that building [s]; the scene's by default, of records 0.5 s.
    gaps : sequence of float or str, optional
        The narrowest and the widest gap [m], or three and more in rising order.
    gap_shares : sequence of float, optional
        In place of gaps: their shares of the gap ``share_of`` at the same periods; from 0.1 to 1.3 by default.
    num_gaps : int
        Gaps of a range.
    share_of : str
        What shares are of: a separation rule that needs no height ("srss", "cqc", "abs" and others), from the spectral
        displacements, or "required", the gap that the motions need.
    share_percentile : float or str
        Share of the motions whose displacements, or gap, that is: 84, 0.84 or "84 %".
    damping : float or str, or two of them, optional
        Damping ratio of both buildings, or left and right; those of the scene, or 5 %, by default.
    mass_ratio : float, optional
        Mass of the left building over that of the right one, of records alone; 1 by default.
    percentiles : sequence of float or str
        Shares of the motions that the amplification is given for.
    motions : bool
        Keep the amplification in each motion, too.
    workers : int, optional
        Threads; one a processor by default. Results do not depend on it.
    new : bool
        Replace other results under the name ``out``.
    progress : callable, optional
        Called with the number of runs done and of all runs.

    Returns
    -------
    xarray.Dataset
        ``displacement_amplification`` along percentile, fixed_period, period_ratio, gap or gap_share, and building;
        its largest value over the motions, ``displacement_amplified``, the share of the motions above 1, and the same
        of the floor acceleration where the contact has a finite force; ``contact_share``, the share that touches; with
        ``motions`` also ``..._of_motion``. The attribute ``finding`` is a sentence.

    Raises
    ------
    PoundingError
        For a value out of bounds, gaps and shares given together, a rule that needs heights, more runs than memory
        holds, and an ``out`` that cannot be written or holds other results.
    SceneError
        For a scene with faults or with axes of other numbers, and one whose buildings are not two single masses that
        start from rest on one ground.
    RecordError
        For a record that cannot be used.
    """
    from pounding_risk.studies import amplification as study  # compiled
    from pounding_risk.studies import spectra as closings
    from pounding_risk.studies.study import check_out, saved

    target = check_out(out, "amplification", new)
    requested = read_percentiles(percentiles)
    at = read_percentiles([share_percentile], "share_percentile")[0]
    known = (*charted(), REQUIRED)
    if share_of not in known:
        raise PoundingError(
            f"share_of: {shown(share_of)} is none{nearest(str(share_of), known)}; it may be {', '.join(known)}"
        )
    if gaps is not None and gap_shares is not None:
        raise PoundingError("gaps and gap_shares are both given; shares are gaps too: leave one out")
    ratio_values = closings.rising_axis(ratios, num, spacing, "ratios", study.RATIO)
    shares = GAP_SHARES if gap_shares is None else gap_shares
    gap_axis = (
        ("gap_share", closings.rising_axis(shares, num_gaps, "linear", "gap_shares", study.SHARE))
        if gaps is None
        else ("gap", closings.rising_axis(gaps, num_gaps, "linear", "gaps", GAP))
    )
    scene = study.pair_scene(closings.opened(source), mass_ratio)
    stated = closings.stated_damping(scene)
    dampings = closings.damping_pair(damping, stated)
    scene = scene.updated(
        buildings=tuple(one._replace(damping=ratio) for one, ratio in zip(scene.pair, dampings, strict=True))
    )
    stays = study.staying(fixed, scene)
    fixed_periods = study.staying_periods(periods, scene.pair[stays].period)
    shaking = closings.shaking_of(scene, np.concatenate([fixed_periods, *(fixed_periods[:, None] * ratio_values)]))
    reference = np.stack(
        [_reference(shaking, float(period), ratio_values, stays, dampings, (share_of, at)) for period in fixed_periods]
    )
    shape = (*reference.shape, gap_axis[1].size)
    absolute = np.broadcast_to(gap_axis[1], shape) if gap_axis[0] == "gap" else reference[..., None] * gap_axis[1]
    words = (
        f"gap that {at:g} % of the motions need"
        if share_of == REQUIRED
        else f"{rule_words(share_of)} of the spectral displacements at {at:g} % of the motions"
    )
    chart = study.Chart(fixed_periods, ratio_values, stays, gap_axis, absolute, reference, words)
    peaks = study.responses(scene, shaking, chart.pairs(), workers, progress)
    dataset = study.amplification_dataset(scene, shaking, chart, peaks, requested, motions)
    dataset.attrs |= {"fixed": ("left", "right")[stays], "share_of": share_of, "share_percentile": at}
    return saved(dataset, "amplification", target, finding=finding(dataset))


def _reference(
    shaking: Any, period: float, ratios: Array, stays: int, dampings: tuple[float, float], of: tuple[str, float]
) -> Array:
    """The gap [m] that shares are of, by ratio, beside a building of this period."""
    from pounding_risk.studies import spectra as closings

    periods = [ratios * period, np.array([period])]
    left, right = periods if stays == 1 else periods[::-1]
    sides = closings.Oscillators(left, dampings[0]), closings.Oscillators(right, dampings[1])
    name, percentile = of
    peaks = closings.closings(shaking.motions, sides)
    alone = closings.gap_dataset(shaking, sides, peaks, (percentile,), False)
    chosen = alone["required_gap"] if name == REQUIRED else with_rules(alone)["separation"].sel(rule=name)
    return np.asarray(chosen.isel(percentile=0).values).reshape(-1)


# ------------------------------------------------------------------------------------------------ reading the dataset


def check_amplification(results: xr.Dataset) -> xr.Dataset:
    """The dataset; raises PoundingError for another one than `amplification` makes."""
    if kind_of(results) != "amplification" or "displacement_amplification" not in results.data_vars:
        raise PoundingError("this is no dataset of `pounding-risk amplification`; run it with -o amplification.nc")
    return results


def gap_dim(results: xr.Dataset) -> str:
    """The dimension of the gaps: "gap" or "gap_share"."""
    return "gap_share" if "gap_share" in results.dims else "gap"


def gap_words(results: xr.Dataset, value: float) -> str:
    """A gap in words: "a gap of 20 mm", "a gap of 0.5 SRSS"."""
    if gap_dim(results) == "gap":
        return f"a gap of {say(value, GAP, 3)}"
    return f"a gap of {value:.2g} {reference_name(results)}"


def reference_name(results: xr.Dataset) -> str:
    """What gap shares are of, in a word or two."""
    name = str(results.attrs["share_of"])
    return "times the gap required" if name == REQUIRED else rule_words(name)


def ratio_words(results: xr.Dataset) -> str:
    """The ratio of the periods as a formula: "T(frame) / T(masonry)"."""
    names = [str(name) for name in results["building"].values]
    stays = ("left", "right").index(str(results.attrs["fixed"]))
    return f"T({names[1 - stays]}) / T({names[stays]})"


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
    at = usual_percentile(results) if percentile is None else percentile
    values = results[f"{output}_amplification"].sel(percentile=at)
    periods = results["building_period"]
    own, other = periods, periods.isel(building=[1, 0]).assign_coords(building=periods["building"])
    of_kind = (own <= other) if stiffer else (own >= other)
    chosen = values.where(of_kind).transpose("fixed_period", "period_ratio", gap_dim(results), "building")
    if not np.isfinite(chosen.values).any():
        return Worst(1.0, "", float("nan"), float("nan"), float("nan"))
    place = np.unravel_index(int(np.nanargmax(chosen.values)), chosen.shape)
    cell = chosen[place]
    return Worst(
        float(cell),
        str(cell["building"].item()),
        float(cell["period_ratio"]),
        float(results[gap_dim(results)][place[2]]),
        float(cell["fixed_period"]),
    )


def finding(results: xr.Dataset, output: str = "displacement", percentile: float | None = None) -> str:
    """Sentence on how much contact raises the peak of the stiffer and of the softer building, and where."""
    at = usual_percentile(results) if percentile is None else percentile
    clauses = [f"{rise} ({where})" if where else rise for rise, where in rises(results, output, at)]
    return f"{raised_words(output, at)}: {'; '.join(clauses)}"


def raised_words(output: str, percentile: float) -> str:
    """What `rises` are of."""
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


def amplification_table(results: xr.Dataset) -> Any:
    """Every period, ratio, gap and building in a row, in SI; percentiles in columns.

    A pandas.DataFrame with the columns fixed_period, period_ratio, gap_share (where gaps are shares), gap, building,
    building_period, contact_share, and of each output its percentiles, the largest, and the share above 1.
    """
    import xarray as xr

    check_amplification(results)
    dims = ["fixed_period", "period_ratio", gap_dim(results), "building"]
    columns: dict[str, Any] = {"contact_share": results["contact_share"]}
    for output in OUTPUTS:
        name = f"{output}_amplification"
        if name in results:
            for value in results["percentile"].values:
                columns[f"{name}_{value:g}"] = results[name].sel(percentile=value)
            columns |= {one: results[one] for one in (f"{name}_largest", f"{output}_amplified")}
    whole = columns["displacement_amplified"].reset_coords(drop=True)
    of_pair = [name for name in ("gap", "building_period") if name not in results.dims]
    keys = {name: results[name].reset_coords(drop=True).broadcast_like(whole) for name in of_pair}
    part = xr.Dataset({name: column.reset_coords(drop=True) for name, column in (keys | columns).items()})
    return part.to_dataframe(dim_order=dims).reset_index()


SPREAD = (5, 3)  # ratios and gaps of a short table


def table_rows(results: xr.Dataset) -> Iterator[xr.Dataset]:
    """The dataset at a few ratios and gaps, spread over their ranges, beside each period."""
    dim = gap_dim(results)
    ratios, gaps = (
        spread(results.sizes[name], count) for name, count in zip(("period_ratio", dim), SPREAD, strict=True)
    )
    for period, ratio, gap in product(range(results.sizes["fixed_period"]), ratios, gaps):
        yield results.isel({"fixed_period": period, "period_ratio": ratio, dim: gap})
