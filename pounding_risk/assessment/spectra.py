"""Required gaps over the periods of two linear buildings, beside what rules require from spectral displacements."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk._common.words import nearest
from pounding_risk.assessment.options import LEAST, USUAL_PERCENTILE
from pounding_risk.assessment.separations.rules import RULES, Case, Site
from pounding_risk.errors import PoundingError
from pounding_risk.results.variables import described
from pounding_risk.units import share, shown

Array = NDArray[np.float64]

JUDGED = ("srss", "cqc")  # in the finding and in the figure, unless others are named
SHORT_WORDS = {"abs": "ABS", "srss": "SRSS", "cqc": "DDC"}
SAME = 1e-9  # a rule short of the gap by no more than this share is not exceeded: they are rounded apart


def charted() -> tuple[str, ...]:
    """Rules that displacements, periods and dampings suffice for: heights do not follow from a period."""
    return tuple(name for name, rule in RULES.items() if not rule.needs)


def read_percentiles(percentiles: Sequence[float | str], name: str = "percentiles") -> tuple[float, ...]:
    """Percentiles in %, rising and each once; raises QuantityError, or PoundingError where there is none."""
    if isinstance(percentiles, str | float | int):
        percentiles = (percentiles,)
    shares = {round(100.0 * share(percentile, name, high=1.0 - LEAST), 6) for percentile in percentiles}
    if not shares:
        raise PoundingError(f"{name}: none is given; write shares of the motions such as 50 and 84")
    return tuple(sorted(shares))


def with_rules(results: xr.Dataset) -> xr.Dataset:
    """The dataset with what each rule of `charted` requires from the spectral displacements at each percentile."""
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
            f"rule_{fact}": ("rule", [getattr(RULES[name], fact) for name in rules], {"long_name": label})
            for fact, label in facts.items()
        },
    }
    return results.assign(separation=xr.Variable(dims, separation, described("m", words))).assign_coords(coords)


def usual_percentile(results: xr.Dataset) -> float:
    """The percentile [%] that findings, tables and figures show: 84, or the largest where that is not among them."""
    percentiles = results["percentile"].values
    return USUAL_PERCENTILE if USUAL_PERCENTILE in percentiles else float(percentiles.max())


class Shortfall(NamedTuple):
    """How a rule compares with the gap required at one percentile, over all pairs of periods that need one."""

    rule: str
    pairs: float  # share of the pairs at which it requires less
    ratio: float  # gap required over the rule's, where that is largest
    periods: tuple[float, float]  # s, left and right, there
    median: float  # gap required over the rule's


def shortfall(results: xr.Dataset, rule: str, percentile: float | None = None) -> Shortfall:
    """Compare a rule of the dataset with the gap required; all 0 where no pair needs a gap."""
    used_percentile = usual_percentile(results) if percentile is None else percentile
    gap = results["required_gap"].sel(percentile=used_percentile).values
    ratio = ratio_to_rule(results, rule, used_percentile)
    is_known = np.isfinite(ratio)
    if not is_known.any():
        return Shortfall(rule, 0.0, 0.0, (0.0, 0.0), 0.0)
    row, column = np.unravel_index(np.nanargmax(np.where(is_known, ratio, -1.0)), gap.shape)
    return Shortfall(
        rule,
        float((ratio[is_known] > 1.0 + SAME).mean()),
        float(ratio[row, column]),
        (float(results["left_period"][row]), float(results["right_period"][column])),
        float(np.median(ratio[is_known])),
    )


def shortfalls(results: xr.Dataset) -> list[Shortfall]:
    """Every rule of the dataset beside the gap required at the usual percentile."""
    return [shortfall(results, str(rule)) for rule in results["rule"].values]


def ratio_to_rule(results: xr.Dataset, rule: str, percentile: float) -> Array:
    """Gap required over what a rule requires, (left, right); NaN where either is 0: two alike move alike."""
    gap = results["required_gap"].sel(percentile=percentile).values
    separation = results["separation"].sel(percentile=percentile, rule=rule).values
    is_known = (separation > 0.0) & (gap > 0.0) & np.isfinite(separation)
    return np.divide(gap, separation, out=np.full(gap.shape, np.nan), where=is_known)


def motions_words(results: xr.Dataset) -> str:
    """How many motions there are, and how strong: "88 motions at PGA 0.5 g (44 records in both polarities)"."""
    records, polarities = results.sizes["record"], [str(polarity) for polarity in results["polarity"].values]
    sense = "in both polarities" if len(polarities) == 2 else f"{polarities[0]}"
    count = counted(records * len(polarities), "motion")
    return f"{count} {results.attrs.get('amplitude', '')} ({counted(records, 'record')} {sense})"


def rule_words(rule: str) -> str:
    """A rule's short name, with how its text is known where it was not read: SRSS, "Canada (quoted)"."""
    entry = RULES[rule]
    return SHORT_WORDS.get(rule) or (entry.title if entry.is_checked else f"{entry.title} ({entry.verification})")


def check_rules(results: xr.Dataset, rules: Sequence[str]) -> tuple[str, ...]:
    """The rules, each once; raises PoundingError for one that the dataset has not."""
    names = [str(rule) for rule in results["rule"].values]
    for rule in rules:
        if rule not in names:
            raise PoundingError(
                f"rule: {shown(rule)} is not in the dataset{nearest(rule, names)}; it has {', '.join(names)}"
            )
    return tuple(dict.fromkeys(rules))


def finding(results: xr.Dataset, rules: Sequence[str] = JUDGED) -> str:
    """Sentence on where rules require less than the motions need, at the usual percentile, and by how much at most."""
    used_percentile = usual_percentile(results)
    count = results.sizes["record"] * results.sizes["polarity"]
    clauses = []
    for rule in rules:
        comparison, words = shortfall(results, rule, used_percentile), rule_words(rule)
        if comparison.pairs == 0.0:
            clauses.append(f"{words} at no pair of periods")
            continue
        left, right = comparison.periods
        extent = f"by up to {100.0 * (comparison.ratio - 1.0):.0f} % ({left:.2g} s beside {right:.2g} s)"
        clauses.append(f"{words} at {100.0 * comparison.pairs:.0f} % of the pairs of periods, {extent}")
    return f"The gap that {used_percentile:g} % of {counted(count, 'motion')} need exceeds " + "; ".join(clauses)


def is_symmetric(results: xr.Dataset) -> bool:
    """Whether exchanging the buildings changes nothing but the polarity, and both polarities are in the ensemble."""
    alike = np.array_equal(results["left_period"].values, results["right_period"].values)
    return (
        alike and float(results["left_damping"]) == float(results["right_damping"]) and results.sizes["polarity"] == 2
    )
