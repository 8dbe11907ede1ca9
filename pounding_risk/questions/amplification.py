"""How pounding raises both buildings' peaks over the ratio of periods and the gap."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.letters import cell
from pounding_risk._common.order import evenly
from pounding_risk._common.progress import Progress
from pounding_risk.assessment.amplification import (
    OUTPUTS,
    REQUIRED,
    finding,
    gap_dim,
    ratio_words,
    reference_name,
    told_words,
)
from pounding_risk.assessment.options import USUAL_PERCENTILE
from pounding_risk.assessment.spectra import charted, motions_words, read_percentiles, rule_words, with_rules
from pounding_risk.errors import PoundingError
from pounding_risk.motions.request import RecordRequest
from pounding_risk.questions._declaration import FROM_TO, RANGE, Option, text_file
from pounding_risk.questions.notes import notes_of
from pounding_risk.render.sheet import Block, Row, facts, head, number, paragraph, percent, table
from pounding_risk.results.check import check_kind
from pounding_risk.units import GAP, unknown

if TYPE_CHECKING:
    from pounding_risk.scene.records import Records
    from pounding_risk.scene.scene import Scene

ORDER = 126
SUBJECT = "records"
UNIT = "runs"
FIGURES = {"": "amplification_chart.amplification_figure"}
OPTIONS = {
    "ratios": RANGE,
    "periods": Option("--period", list[str]),
    "gaps": FROM_TO,
    "gap_shares": RANGE,
    "damping": Option(kind=list[str]),
    "percentiles": Option("--percentile"),
}
PERCENTILES = (16.0, 50.0, 84.0)
RATIOS, GAP_SHARES = (0.2, 5.0), (0.1, 1.3)
Array = NDArray[np.float64]
SPREAD = (5, 3)  # ratios and gaps of the short table


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
    used = read_percentiles([share_percentile], "share_percentile")[0]
    choices = (*charted(), REQUIRED)
    if share_of not in choices:
        raise PoundingError(f"share_of: {unknown(share_of, 'none', choices)}")
    if gaps is not None and gap_shares is not None:
        raise PoundingError("gaps and gap_shares are both given; shares are gaps too: leave one out")
    ratio_values = closings.rising_axis(ratios, num, spacing, "ratios", study.RATIO)
    shares = GAP_SHARES if gap_shares is None else gap_shares
    dim, steps, bounds = ("gap_share", shares, study.SHARE) if gaps is None else ("gap", gaps, GAP)
    gap_axis = dim, closings.rising_axis(steps, num_gaps, "linear", f"{dim}s", bounds)
    scene = study.pair_scene(closings.opened(source), mass_ratio)
    dampings = closings.damping_pair(damping, closings.stated_damping(scene))
    pair = zip(scene.pair, dampings, strict=True)
    scene = scene.updated(buildings=tuple(building._replace(damping=ratio) for building, ratio in pair))
    side = study.staying(fixed, scene)
    fixed_periods = study.staying_periods(periods, scene.pair[side].period)
    shaking = closings.shaking_of(scene, np.concatenate([fixed_periods, *(fixed_periods[:, None] * ratio_values)]))
    reference = np.stack(
        [_reference(shaking, float(period), ratio_values, side, dampings, (share_of, used)) for period in fixed_periods]
    )
    shape = (*reference.shape, gap_axis[1].size)
    absolute = np.broadcast_to(gap_axis[1], shape) if dim == "gap" else reference[..., None] * gap_axis[1]
    words = f"gap that {used:g} % of the motions need"
    if share_of != REQUIRED:
        words = f"{rule_words(share_of)} of the spectral displacements at {used:g} % of the motions"
    chart = study.Chart(fixed_periods, ratio_values, side, gap_axis, absolute, reference, words)
    peaks = study.responses(scene, shaking, chart.pairs(), workers, progress)
    dataset = study.amplification_dataset(scene, shaking, chart, peaks, requested, motions)
    dataset.attrs |= {"fixed": ("left", "right")[side], "share_of": share_of, "share_percentile": used}
    return saved(dataset, "amplification", target, finding=finding(dataset))


def _reference(
    shaking: Any, period: float, ratios: Array, side: int, dampings: tuple[float, float], basis: tuple[str, float]
) -> Array:
    """The reference gap [m] of the shares, by ratio, beside a building of this period."""
    from pounding_risk.studies import spectra as closings

    periods = [ratios * period, np.array([period])]
    left, right = periods if side == 1 else periods[::-1]
    sides = closings.Oscillators(left, dampings[0]), closings.Oscillators(right, dampings[1])
    name, percentile = basis
    spectra = closings.gap_dataset(shaking, sides, closings.closings(shaking.motions, sides), (percentile,), False)
    gaps = spectra["required_gap"] if name == REQUIRED else with_rules(spectra)["separation"].sel(rule=name)
    return np.asarray(gaps.isel(percentile=0).values).reshape(-1)


def amplification_table(results: xr.Dataset) -> Any:
    """Every period, ratio, gap and building in a row, in SI; percentiles in columns.

    A pandas.DataFrame with the columns fixed_period, period_ratio, gap_share (where gaps are shares), gap, building,
    building_period, contact_share, and of each output its percentiles, the largest, and the share above 1.
    """
    check_kind(results, "amplification")
    dims = ["fixed_period", "period_ratio", gap_dim(results), "building"]
    columns: dict[str, Any] = {"contact_share": results["contact_share"]}
    for output in OUTPUTS:
        name = f"{output}_amplification"
        if name in results:
            for percentile in results["percentile"].values:
                columns[f"{name}_{percentile:g}"] = results[name].sel(percentile=percentile)
            columns |= {name_of: results[name_of] for name_of in (f"{name}_largest", f"{output}_amplified")}
    shape = columns["displacement_amplified"].reset_coords(drop=True)
    pair_names = [name for name in ("gap", "building_period") if name not in results.dims]
    keys = {name: results[name].reset_coords(drop=True).broadcast_like(shape) for name in pair_names}
    table_columns = xr.Dataset({name: column.reset_coords(drop=True) for name, column in (keys | columns).items()})
    return table_columns.to_dataframe(dim_order=dims).reset_index()


def _table_text(dataset: xr.Dataset) -> str:
    table_of_all = amplification_table(dataset)
    return str(table_of_all.assign(building=table_of_all["building"].map(cell)).to_csv(index=False))


FILES = {"table": text_file("Write the whole table", ".csv", _table_text)}


def sheet(dataset: xr.Dataset) -> list[Block]:
    """The finding, amplifications of the displacements at a few ratios and gaps, and what was run."""
    return [paragraph(dataset.attrs["finding"]), _amplifications(dataset), _facts(dataset), *notes_of(dataset)]


def _amplifications(dataset: xr.Dataset) -> Block:
    has_periods, has_shares = dataset.sizes["fixed_period"] > 1, "gap_share" in dataset.dims
    heads = [head("beside", "s")] if has_periods else []
    heads += [ratio_words(dataset), *([f"gap / {reference_name(dataset)}"] if has_shares else [])]
    heads += [head("gap", "m"), head("contact in", "%")]
    heads += [f"{name} {percent(p)}" for name in dataset["building"].values for p in dataset["percentile"].values]
    rows: list[Row] = []
    for part in _few_cells(dataset):
        row: Row = [number(part["fixed_period"], "s", 3)] if has_periods else []
        row += [number(part["period_ratio"], digits=3), *([number(part["gap_share"], digits=3)] if has_shares else [])]
        row += [number(part["gap"], "m", 3), number(part["contact_share"], "%", 3)]
        ratios = part["displacement_amplification"].transpose("building", "percentile").values.ravel()
        rows.append([*row, *(number(ratio, digits=3) for ratio in ratios)])
    places = prod(dataset.sizes[dim] for dim in ("fixed_period", "period_ratio", gap_dim(dataset)))
    part_words = f", at {len(rows)} of {places} places; --table writes all" if len(rows) < places else ""
    caption = f"Peak displacement with contact over that without, not exceeded by a share of the motions{part_words}."
    return table(caption, heads, rows)


def _few_cells(dataset: xr.Dataset) -> Iterator[xr.Dataset]:
    """The dataset at a few ratios and gaps, spread over their ranges, beside each period."""
    dims = ("period_ratio", gap_dim(dataset))
    places = (evenly(dataset.sizes[dim], count) for dim, count in zip(dims, SPREAD, strict=True))
    for index in product(range(dataset.sizes["fixed_period"]), *places):
        yield dataset.isel(dict(zip(("fixed_period", *dims), index, strict=True)))


def _facts(dataset: xr.Dataset) -> Block:
    ratios, failed = dataset["period_ratio"].values, int(dataset.attrs["failed_runs"])
    rows = [
        ("motions", motions_words(dataset)),
        ("ratios", f"{ratios.size} from {number(ratios[0])['text']} to {number(ratios[-1])['text']}"),
        ("models", told_words(dataset)),
        *([("failed", f"{failed} runs, excluded from the percentiles")] if failed else []),
    ]
    return facts("Motions and buildings.", rows)
