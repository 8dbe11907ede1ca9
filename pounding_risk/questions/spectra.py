"""The gap required over the periods of two buildings, beside what rules require."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from pounding_risk._common.order import evenly
from pounding_risk._common.progress import Progress
from pounding_risk._common.words import nearest
from pounding_risk.assessment.spectra import (
    charted,
    finding,
    is_symmetric,
    motions_words,
    read_percentiles,
    shortfalls,
    usual_percentile,
    with_rules,
)
from pounding_risk.errors import PoundingError
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.request import RecordRequest
from pounding_risk.questions._declaration import FROM_TO, Option
from pounding_risk.questions.notes import notes_of
from pounding_risk.render.sheet import Block, Row, amount, facts, head, number, paragraph, percent, table
from pounding_risk.statistics.required_gap import USUAL_PERCENTILES
from pounding_risk.units import PERIOD

if TYPE_CHECKING:
    from pounding_risk.scene.records import Records
    from pounding_risk.scene.scene import Scene

ORDER = 125
SUBJECT = "records"
UNIT = "records"
FIGURES = {"": "spectra.gap_spectra_figure"}
OPTIONS = {
    "periods": FROM_TO,
    "right_periods": FROM_TO,
    "damping": Option(kind=list[str]),
    "percentiles": Option("--percentile"),
    "rules": Option("--rule", list[str], help="Of the figure, a rule of the table; twice. By default srss and cqc."),
}
TABLED = 4  # periods of each side in the short table
SIDES = ("left", "right")


def spectra(
    source: Scene | Mapping[str, Any] | str | Path | Records | RecordRequest | Sequence[Motion],
    out: str | Path | None = None,
    *,
    periods: Sequence[float | str] = ("0.1 s", "2 s"),
    right_periods: Sequence[float | str] | None = None,
    num: int = 100,
    spacing: str = "log",
    damping: float | str | Sequence[float | str] | None = None,
    percentiles: Sequence[float | str] = USUAL_PERCENTILES,
    motions: bool = False,
    workers: int | None = None,
    new: bool = False,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Gap required over the periods of two linear buildings.

    The gap that a motion needs is the largest closing u_left - u_right of two single masses on one ground, from rest
    and without contact, exact between the samples. Beside it stands what rules ask for from the spectral displacements
    at the same percentile.

    Parameters
    ----------
    source : Scene, dict, path, Records or sequence of Motion
        A scene of two single masses, of which the records, their amplitude and polarities and the damping ratios are
        taken; records; or motions, which act in both polarities. Of several amplitudes of a grid the scene's own is
        taken, or the largest.
    out : path, optional
        File for the dataset, ``.nc``.
    periods : sequence of float or str
        The shortest and the longest period of the left building [s], or three and more periods in rising order.
    right_periods : sequence of float or str, optional
        Those of the right building; the same by default.
    num : int
        Periods of a range, from 2 to 1000.
    spacing : {"log", "linear"}
        How they are spaced.
    damping : float or str, or two of them, optional
        Damping ratio of both buildings, or left and right; those of the scene, or 5 %, by default.
    percentiles : sequence of float or str
        Shares of the motions that the gap is for: 84, 0.84 or "84 %".
    motions : bool
        Keep the gap that each motion needs, too.
    workers : int, optional
        Threads; one a processor by default. Results do not depend on it.
    new : bool
        Replace other results under the name ``out``.
    progress : callable, optional
        Called with the number of records done and of all records.

    Returns
    -------
    xarray.Dataset
        ``required_gap`` and ``separation`` of each rule [m] along percentile, left_period and right_period;
        ``left_displacement`` and ``right_displacement`` [m] by percentile, and ``..._of_record`` by record; with
        ``motions`` also ``required_gap_of_motion`` [m]. The attribute ``finding`` is a sentence.

    Raises
    ------
    PoundingError
        For a range, a damping ratio or a percentile out of bounds, periods too short for a record, more results than
        4 GB, and an ``out`` that cannot be written or holds other results.
    SceneError
        For a scene with faults, and one whose buildings are not two single masses that start from rest on one ground.
    RecordError
        For a record that cannot be used.
    """
    from pounding_risk.studies import spectra as study  # compiled
    from pounding_risk.studies.study import check_out, saved

    target = check_out(out, "spectra", new)
    requested = read_percentiles(percentiles)
    left = study.rising_axis(periods, num, spacing, "periods", PERIOD)
    right = left if right_periods is None else study.rising_axis(right_periods, num, spacing, "right_periods", PERIOD)
    subject = study.opened(source)
    ratios = study.damping_pair(damping, study.stated_damping(subject))
    sides = study.Oscillators(left, ratios[0]), study.Oscillators(right, ratios[1])
    shaking = study.shaking_of(subject, np.concatenate([left, right]))
    closings = study.closings(shaking.motions, sides, workers, progress)
    dataset = with_rules(study.gap_dataset(shaking, sides, closings, requested, motions))
    return saved(dataset, "spectra", target, finding=finding(dataset))


def sheet(dataset: xr.Dataset) -> list[Block]:
    """The finding, required gaps at a few pairs of periods, every rule beside them, and what was run."""
    return [paragraph(dataset.attrs["finding"]), _gaps(dataset), _rules(dataset), _facts(dataset), *notes_of(dataset)]


def check(options: Mapping[str, Any]) -> None:
    """Raise PoundingError for rules of the figure that are not two of those of the table."""
    rules, known = options.get("rules", ()), charted()
    for rule in rules:
        if rule not in known:
            words = f'"{rule}" is none of the table{nearest(rule, known)}, which has {", ".join(known)}'
            raise PoundingError(f"rules: {words}")
    if rules and len(set(rules)) != 2:
        raise PoundingError("rules: the figure shows two rules; name two, such as --rule srss --rule eurocode8")


def few_pairs(dataset: xr.Dataset) -> Iterator[tuple[float, ...]]:
    """A few pairs of periods, with the gaps required and what ABS, SRSS and DDC require at the usual percentile.

    They are spread over the ranges; where both sides are alike each pair stands once.
    """
    places = [evenly(dataset.sizes[f"{side}_period"], TABLED) for side in SIDES]
    is_alike, rules = is_symmetric(dataset), dataset["separation"].sel(percentile=usual_percentile(dataset))
    for left, right in product(*places):
        if not is_alike or right > left:
            pair = {"left_period": left, "right_period": right}
            gaps = (dataset["required_gap"].isel(pair), rules.sel(rule=["abs", "srss", "cqc"]).isel(pair))
            periods = (
                float(dataset[f"{side}_period"][place]) for side, place in zip(SIDES, (left, right), strict=True)
            )
            yield (*periods, *(gap for array in gaps for gap in array.values.tolist()))


def _gaps(dataset: xr.Dataset) -> Block:
    shares = [percent(percentile) for percentile in dataset["percentile"].values]
    heads = [*(head(side, "s") for side in SIDES), *(head(words, "m") for words in (*shares, "ABS", "SRSS", "DDC"))]
    rows: list[Row] = [
        [*(number(period, "s", 3) for period in row[:2]), *(number(gap, "m", 3) for gap in row[2:])]
        for row in few_pairs(dataset)
    ]
    at = percent(usual_percentile(dataset))
    caption = f"Gap required by a share of the motions; ABS, SRSS and DDC of spectral displacements at {at}."
    return table(caption, heads, rows)


def _rules(dataset: xr.Dataset) -> Block:
    heads = ["rule", "text", head("insufficient at", "%"), "median", "largest"]
    heads += [*(head(f"at {side}", "s") for side in SIDES), "definition"]
    rows: list[Row] = []
    for entry in shortfalls(dataset):
        rule = dataset.sel(rule=entry.rule)
        row: Row = [entry.rule, str(rule["rule_verification"].item()), number(entry.pairs, "%", 3)]
        row += [*(number(ratio, digits=3) for ratio in (entry.median, entry.ratio))]
        rows.append([*row, *(number(period, "s", 2) for period in entry.periods), str(rule["rule_title"].item())])
    share = percent(usual_percentile(dataset))
    caption = (
        f"Gap that {share} of the motions require over that of each rule, at all pairs of periods: the share of the "
        "pairs at which the rule is insufficient, and the median and the largest ratio, with its periods."
    )
    return table(caption, heads, rows)


def _facts(dataset: xr.Dataset) -> Block:
    ranges = (dataset[f"{side}_period"].values for side in SIDES)
    periods = [f"{one.size} from {amount(one[0], 's')['text']} to {amount(one[-1], 's')['text']}" for one in ranges]
    dampings = [amount(dataset[f"{side}_damping"], "%")["text"] for side in SIDES]
    rows = [
        ("motions", motions_words(dataset)),
        ("periods", " × ".join(periods)),
        ("damping", " beside ".join(dampings)),
        ("models", "single masses on one ground, linear, without contact"),
        ("percentiles", "of the sample, without bounds"),
        ("rules", "with linear displacements (factors 1) and floors at different levels; none that needs heights"),
    ]
    return facts("Motions, buildings and rules.", rows)
