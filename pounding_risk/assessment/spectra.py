"""Required gaps over the periods of two linear buildings, beside what rules require from spectral displacements."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk._common.progress import Progress
from pounding_risk._common.words import nearest
from pounding_risk.assessment.options import LEAST, USUAL_PERCENTILE
from pounding_risk.assessment.separations.rules import RULES, Case, Site
from pounding_risk.errors import PoundingError
from pounding_risk.results.kinds import kind_of
from pounding_risk.results.variables import described
from pounding_risk.units import PERIOD, share, shown

if TYPE_CHECKING:
    import xarray as xr

    from pounding_risk.motions.motion import Motion
    from pounding_risk.motions.request import RecordRequest
    from pounding_risk.scene.records import Records
    from pounding_risk.scene.scene import Scene

Array = NDArray[np.float64]

PERCENTILES = (50.0, 84.0, 95.0)
JUDGED = ("srss", "cqc")  # in the finding and in the figure, unless others are named
SHORT_WORDS = {"abs": "ABS", "srss": "SRSS", "cqc": "DDC"}
SAME = 1e-9  # a rule short of the gap by no more than this share is not exceeded: they are rounded apart
TABLED = 4  # periods of each side in a short table


def charted() -> tuple[str, ...]:
    """Rules that displacements, periods and dampings suffice for: heights do not follow from a period."""
    return tuple(name for name, rule in RULES.items() if not rule.needs)


def spectra(
    source: Scene | Mapping[str, Any] | str | Path | Records | RecordRequest | Sequence[Motion],
    out: str | Path | None = None,
    *,
    periods: Sequence[float | str] = ("0.1 s", "2 s"),
    right_periods: Sequence[float | str] | None = None,
    num: int = 100,
    spacing: str = "log",
    damping: float | str | Sequence[float | str] | None = None,
    percentiles: Sequence[float | str] = PERCENTILES,
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


def read_percentiles(values: Sequence[float | str], name: str = "percentiles") -> tuple[float, ...]:
    """Percentiles in %, rising and each once; raises QuantityError, or PoundingError where there is none."""
    if isinstance(values, str | float | int):
        values = (values,)
    shares = {round(100.0 * share(value, name, high=1.0 - LEAST), 6) for value in values}
    if not shares:
        raise PoundingError(f"{name}: none is given; write shares of the motions such as 50 and 84")
    return tuple(sorted(shares))


def with_rules(results: xr.Dataset) -> xr.Dataset:
    """The dataset with what each rule of `charted` requires from the spectral displacements at each percentile."""
    import xarray as xr

    left, right = (results[f"{side}_displacement"].values for side in ("left", "right"))
    case = Case(
        (left[:, :, None], right[:, None, :]),
        (results["left_period"].values[None, :, None], results["right_period"].values[None, None, :]),
        (float(results["left_damping"]), float(results["right_damping"])),
        Site(),
    )
    dims = ("rule", *results["required_gap"].dims)
    rules = charted()
    separation = np.stack(
        [np.broadcast_to(RULES[name].function(case), results["required_gap"].shape) for name in rules]
    )
    words = "separation that a rule requires from the spectral displacements of both buildings at the percentile"
    facts = {"title": "what the rule is", "clause": "clause of the rule", "verification": "how its text is known"}
    coords = {
        "rule": ("rule", list(rules), {"long_name": "separation rule"}),
        **{
            f"rule_{fact}": ("rule", [getattr(RULES[name], fact) for name in rules], {"long_name": said})
            for fact, said in facts.items()
        },
    }
    return results.assign(separation=xr.Variable(dims, separation, described("m", words))).assign_coords(coords)


def check_spectra(results: xr.Dataset) -> xr.Dataset:
    """The dataset; raises PoundingError for another one than `spectra` makes."""
    if kind_of(results) != "spectra" or not {"required_gap", "separation"} <= set(results.data_vars):
        raise PoundingError("this is no dataset of `pounding-risk spectra`; run it with -o spectra.nc")
    lost = [name for name in ("percentile", "rule", "left_period", "right_period") if name not in results.coords]
    if lost:
        raise PoundingError(f"the dataset of spectra has lost its {' and '.join(lost)}; run spectra again")
    return results


def usual_percentile(results: xr.Dataset) -> float:
    """The percentile [%] that findings, tables and figures show: 84, or the largest where that is not among them."""
    known = results["percentile"].values
    return USUAL_PERCENTILE if USUAL_PERCENTILE in known else float(known.max())


class Shortfall(NamedTuple):
    """How a rule compares with the gap required at one percentile, over all pairs of periods that need one."""

    rule: str
    pairs: float  # share of the pairs at which it requires less
    ratio: float  # gap required over the rule's, where that is largest
    periods: tuple[float, float]  # s, left and right, there
    median: float  # gap required over the rule's


def shortfall(results: xr.Dataset, rule: str, percentile: float | None = None) -> Shortfall:
    """Compare a rule of the dataset with the gap required; all 0 where no pair needs a gap."""
    at = usual_percentile(results) if percentile is None else percentile
    gap = results["required_gap"].sel(percentile=at).values
    ratio = ratio_to_rule(results, rule, at)
    known = np.isfinite(ratio)
    if not known.any():
        return Shortfall(rule, 0.0, 0.0, (0.0, 0.0), 0.0)
    row, column = np.unravel_index(np.nanargmax(np.where(known, ratio, -1.0)), gap.shape)
    return Shortfall(
        rule,
        float((ratio[known] > 1.0 + SAME).mean()),
        float(ratio[row, column]),
        (float(results["left_period"][row]), float(results["right_period"][column])),
        float(np.median(ratio[known])),
    )


def shortfalls(results: xr.Dataset) -> list[Shortfall]:
    """Every rule of the dataset beside the gap required at the usual percentile."""
    return [shortfall(results, str(rule)) for rule in results["rule"].values]


def ratio_to_rule(results: xr.Dataset, rule: str, percentile: float) -> Array:
    """Gap required over what a rule requires, (left, right); NaN where either is 0: two alike move alike."""
    gap = results["required_gap"].sel(percentile=percentile).values
    separation = results["separation"].sel(percentile=percentile, rule=rule).values
    known = (separation > 0.0) & (gap > 0.0) & np.isfinite(separation)
    return np.divide(gap, separation, out=np.full(gap.shape, np.nan), where=known)


def motions_words(results: xr.Dataset) -> str:
    """How many motions there are, and how strong: "88 motions at PGA 0.5 g (44 records in both polarities)"."""
    records, polarities = results.sizes["record"], [str(polarity) for polarity in results["polarity"].values]
    sense = "in both polarities" if len(polarities) == 2 else f"{polarities[0]}"
    count = counted(records * len(polarities), "motion")
    return f"{count} {results.attrs.get('amplitude', '')} ({counted(records, 'record')} {sense})"


def rule_words(rule: str) -> str:
    """A rule's short name, with how its text is known where it was not read: SRSS, "Canada (quoted)"."""
    one = RULES[rule]
    return SHORT_WORDS.get(rule) or (one.title if one.is_checked else f"{one.title} ({one.verification})")


def check_rules(results: xr.Dataset, rules: Sequence[str]) -> tuple[str, ...]:
    """The rules, each once; raises PoundingError for one that the dataset has not."""
    known = [str(rule) for rule in results["rule"].values]
    for rule in rules:
        if rule not in known:
            raise PoundingError(
                f"rule: {shown(rule)} is not in the dataset{nearest(rule, known)}; it has {', '.join(known)}"
            )
    return tuple(dict.fromkeys(rules))


def finding(results: xr.Dataset, rules: Sequence[str] = JUDGED) -> str:
    """Sentence on where rules require less than the motions need, at the usual percentile, and by how much at most."""
    at = usual_percentile(results)
    count = results.sizes["record"] * results.sizes["polarity"]
    clauses = []
    for rule in rules:
        short, words = shortfall(results, rule, at), rule_words(rule)
        if short.pairs == 0.0:
            clauses.append(f"{words} at no pair of periods")
            continue
        left, right = short.periods
        most = f"by up to {100.0 * (short.ratio - 1.0):.0f} % ({left:.2g} s beside {right:.2g} s)"
        clauses.append(f"{words} at {100.0 * short.pairs:.0f} % of the pairs of periods, {most}")
    return f"The gap that {at:g} % of {counted(count, 'motion')} need exceeds " + "; ".join(clauses)


class Row(NamedTuple):
    """One pair of periods in a short table [s, m]."""

    periods: tuple[float, float]
    gaps: tuple[float, ...]  # at each percentile
    rules: tuple[float, ...]  # abs, srss and cqc at the usual percentile


def table_rows(results: xr.Dataset) -> list[Row]:
    """Rows for a few pairs of periods, spread over the ranges; where both sides are alike each pair once."""
    places = [spread(results.sizes[f"{side}_period"], TABLED) for side in ("left", "right")]
    alike, rows = is_symmetric(results), []
    at = results.sel(percentile=usual_percentile(results))
    for left, right in product(*places):
        if alike and right <= left:
            continue
        pair = {"left_period": left, "right_period": right}
        periods = (float(results["left_period"][left]), float(results["right_period"][right]))
        rules = at["separation"].sel(rule=["abs", "srss", "cqc"]).isel(pair).values.tolist()
        rows.append(Row(periods, tuple(results["required_gap"].isel(pair).values.tolist()), tuple(rules)))
    return rows


def is_symmetric(results: xr.Dataset) -> bool:
    """Whether exchanging the buildings changes nothing but the polarity, and both polarities are in the ensemble."""
    alike = np.array_equal(results["left_period"].values, results["right_period"].values)
    return (
        alike and float(results["left_damping"]) == float(results["right_damping"]) and results.sizes["polarity"] == 2
    )


def spread(size: int, count: int) -> list[int]:
    """Places of so many values, evenly over an axis of this size, both ends among them."""
    return sorted({round(place) for place in np.linspace(0, size - 1, min(count, size)).tolist()})
