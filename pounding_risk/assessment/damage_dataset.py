"""The dataset of `damage`: curves of each state with pounding and without, their ratios, and demands of the motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.assessment.damage_curves import POUNDING, Curves, Motions, Options
from pounding_risk.assessment.fragility import Fragility
from pounding_risk.assessment.gmfs import scenario_of
from pounding_risk.assessment.hazard import Rate, rate_of
from pounding_risk.results.amplitudes import intensity_unit, intensity_words
from pounding_risk.results.variables import described
from pounding_risk.statistics.fragility import fragility_curve
from pounding_risk.statistics.hazard import annual_rate

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

POINTS = 61  # intensities of the curves
PERCENTILES = (16.0, 50.0, 84.0)


def dataset_of(found: Sequence[Curves], motions: Motions, options: Options, case: xr.Dataset) -> xr.Dataset:
    """The dataset of all states."""
    import xarray as xr

    unit, words = intensity_unit(options.intensity), intensity_words(options.intensity)
    tested = motions.ims[np.isfinite(motions.ims)]
    im = np.geomspace(tested.min(), tested.max(), POINTS) if np.ptp(tested) > 0.0 else tested[:1]
    common = motions.levels
    level = np.arange(1.0, motions.ims.shape[1] + 1.0) if common is None else common
    about_levels = ("1", "number of the level, from 1") if common is None else (unit, f"{words} of all motions")
    fits = [[one.fits[side] for one in found] for side in (0, 1)]
    labels = {
        "state": ("state", [one.state.name for one in found], {"long_name": "state of damage"}),
        "state_words": ("state", [one.state.words for one in found], {"long_name": "demand that reaches the state"}),
        "state_threshold": ("state", [one.state.threshold for one in found], {"long_name": "threshold, in state_unit"}),
        "state_unit": ("state", [one.state.demand.unit for one in found], {"long_name": "unit of the demand"}),
        "pounding": ("pounding", list(POUNDING), {"long_name": "with contact between buildings, or without any"}),
        "level": ("level", level, described(*about_levels)),
        "im": ("im", im, described(unit, words)),
        "record": case["record"].variable,
        "polarity": case["polarity"].variable,
        "fault": (
            ("state", "pounding"),
            np.array([[fit.fault for fit in one.fits] for one in found], dtype=str),
            {"long_name": "why there is no curve"},
        ),
        "motion_intensity": (
            ("record", "polarity", "level"),
            _by_record(motions.ims, motions),
            described(unit, f"{words} of the motion"),
        ),
        **{name: case[name].reset_coords(drop=True).variable for name in ("gap", "contact_model", "yield_force")},
    }
    both = ("state", "pounding")
    of_fits = {
        "median": (unit, f"{words} at which the fitted curve is 0.5"),
        "dispersion": ("1", "dispersion of the curve, the deviation of the logarithm of the intensity"),
    }
    variables: dict[str, Any] = {
        name: (both, np.array([[getattr(fit, name) for fit in side] for side in fits]).T, described(*about))
        for name, about in of_fits.items()
    }
    errors = [[fit.errors for fit in side] for side in fits]
    for place, name in enumerate(("median_error", "dispersion_error")):
        said = "the logarithm of the median" if place == 0 else "the dispersion"
        values = np.array([[pair[place] for pair in side] for side in errors]).T
        variables[name] = (both, values, described("1", f"standard error of {said}, by recording or by motion"))
    variables |= _of_motions(found, motions, unit, common is not None)
    variables |= _compared(found, im, options, (unit, words))
    variables |= _rates(found, options) | _in_an_event(found, options)
    return xr.Dataset(variables, coords=labels, attrs={"intensity": options.intensity, "method": options.method})


def _by_record(values: NDArray[Any], motions: Motions) -> NDArray[Any]:
    """Values by motion as (record, polarity, ...)."""
    return values.reshape(len(motions.records), len(motions.polarities), *values.shape[1:])


def _of_motions(found: Sequence[Curves], motions: Motions, unit: str, has_common_levels: bool) -> dict[str, Any]:
    """Demands, capacities and counts of the motions."""
    by_level = ("state", "pounding", "level")
    ratios = np.array([one.ratios for one in found])  # state, pounding, motion, level
    known = np.isfinite(ratios)
    of_motions = ("record", "polarity")
    spread = {
        "demand_ratio": np.array([[_by_record(side, motions) for side in one] for one in ratios]),
        "capacity": np.array([[_by_record(side.values, motions) for side in one.found] for one in found]),
        "capacity_status": np.array([[_by_record(side.status, motions) for side in one.found] for one in found]),
    }
    where = {
        "long_name": "where the capacity lies",
        "flag_values": np.array([-1, 0, 1, 2, 3], dtype=np.int8),
        "flag_meanings": (
            "at_most_the_lowest_level known above_the_highest_level no_run_is_known between_the_level_and_the_one_below"
        ),
    }
    capacity = "intensity at which the motion first reaches the state, or the level next to it where it is not known"
    variables: dict[str, Any] = {
        "demand_ratio": (
            ("state", "pounding", *of_motions, "level"),
            spread["demand_ratio"],
            described("1", "demand over the threshold of the state"),
        ),
        "capacity": (("state", "pounding", *of_motions), spread["capacity"], described(unit, capacity)),
        "capacity_status": (("state", "pounding", *of_motions), spread["capacity_status"], where),
        "runs": (by_level, known.sum(axis=2).astype(np.int32), described("1", "runs that did not fail")),
        "reached": (
            by_level,
            (np.where(known, ratios, 0.0) >= 1.0).sum(axis=2).astype(np.int32),
            described("1", "runs that reach the state"),
        ),
        "falls_back": (
            ("state", "pounding"),
            np.array([[side.falls_back.sum() for side in one.found] for one in found], dtype=np.int32),
            described("1", "motions that reach the state at a level and not at a higher one"),
        ),
    }
    if has_common_levels:
        with np.errstate(all="ignore"):
            shares = np.array([_percentiles(ratios, percentile) for percentile in PERCENTILES])
        variables["demand_percentile"] = (
            ("percentile", *by_level),
            shares,
            described("1", "percentile of the demands over the threshold, of the motions at the level"),
        )
        variables["percentile"] = ("percentile", np.array(PERCENTILES), described("percent", "share of the motions"))
    return variables


def _percentiles(ratios: Array, percentile: float) -> Array:
    """A percentile of the demands over the motions; NaN where no run is known."""
    known = np.asarray(np.isfinite(ratios).any(axis=2))
    filled = np.where(known[:, :, None], ratios, 0.0)
    return np.where(known, np.nanpercentile(filled, percentile, axis=2), np.nan)


def _compared(found: Sequence[Curves], im: Array, options: Options, about: tuple[str, str]) -> dict[str, Any]:
    """Probabilities along the intensity, and ratios with over without, with their bounds."""
    unit, words = about
    both = ("state", "pounding")
    at = np.array([one.fits[1].median if options.at is None else options.at for one in found])
    variables: dict[str, Any] = {
        "probability": (
            (*both, "im"),
            np.array([one.probability(im) for one in found]),
            described("1", "probability that the state is reached"),
        ),
        "at_intensity": ("state", at, described(unit, f"{words} at which both probabilities are compared")),
        "probability_at": (
            both,
            np.array([one.probability(np.array([place])) for one, place in zip(found, at, strict=True)])[..., 0],
            described("1", "probability that the state is reached at at_intensity"),
        ),
    }
    ratios: dict[str, tuple[tuple[str, ...], str, list[Ratio]]] = {
        "median_ratio": (("state",), "median with pounding over that without", []),
        "probability_ratio": (("state", "im"), "probability with pounding over that without", []),
        "probability_ratio_at": (("state",), "probability with pounding over that without, at at_intensity", []),
    }
    for one, place in zip(found, at, strict=True):
        ratios["median_ratio"][2].append(_median_ratio(one, options))
        ratios["probability_ratio"][2].append(_probability_ratio(one, im, options))
        single = _probability_ratio(one, np.array([place]), options)
        ratios["probability_ratio_at"][2].append(Ratio(*(values[..., 0] for values in single)))
    return variables | _with_bounds(ratios)


class Ratio(NamedTuple):
    """With over without pounding, and its bounds."""

    value: Any
    low: Any
    high: Any


def _with_bounds(ratios: dict[str, tuple[tuple[str, ...], str, list[Ratio]]]) -> dict[str, Any]:
    """Variables of ratios and of both their bounds."""
    variables = {}
    for name, (dims, words, values) in ratios.items():
        columns = [np.array(column) for column in zip(*values, strict=True)]
        for ending, said, column in zip(
            ("", "_low", "_high"), ("", "lower bound: ", "upper bound: "), columns, strict=True
        ):
            variables[f"{name}{ending}"] = (dims, column, described("1", f"{said}{words}"))
    return variables


def _median_ratio(one: Curves, options: Options) -> Ratio:
    with_contact, without = one.drawn_alike
    value = one.fits[0].median / one.fits[1].median
    return Ratio(value, *one.bounds(np.exp(with_contact[:, 0] - without[:, 0]), options.tails))


def _probability_ratio(one: Curves, im: Array, options: Options) -> Ratio:
    """At these intensities; NaN where both probabilities are 0 to the last digit."""
    value = _over(*one.probability(im))
    sides = [fragility_curve(im, np.exp(side[:, :1]), side[:, 1:]) for side in one.drawn_alike]
    return Ratio(value, *one.bounds(_over(*sides), options.tails))


def _over(with_contact: Any, without: Any) -> Array:
    """With over without; infinite where only the latter is 0, NaN where both are or one is not known."""
    one, other = np.broadcast_arrays(np.asarray(with_contact, dtype=float), np.asarray(without, dtype=float))
    with np.errstate(all="ignore"):  # of what is told as infinite or not known
        return np.asarray(one / other)


def _rates(found: Sequence[Curves], options: Options) -> dict[str, Any]:
    """Annual rates of reaching each state; none without a hazard curve."""
    hazard = options.hazard
    if hazard is None:
        return {}
    rates = [[rate_of(hazard, _fragility(one, side, options), options.confidence) for side in (0, 1)] for one in found]
    variables: dict[str, Any] = {}
    for name, field, words in (
        ("annual_rate", "annual", "annual rate at which the state is reached"),
        ("annual_rate_low", "low", "lower bound: annual rate at which the state is reached"),
        ("annual_rate_high", "high", "upper bound: annual rate at which the state is reached"),
    ):
        values = np.array([[getattr(rate, field) for rate in pair] for pair in rates])
        variables[name] = (("state", "pounding"), values, described("year-1", words))
    missing = np.array([[rate.missing for rate in pair] for pair in rates])
    variables["annual_rate_missing"] = (
        ("state", "pounding"),
        missing,
        described("1", "share of the rate beyond the ends of the hazard curve, were it continued"),
    )
    ratios = [_rate_ratio(one, pair, options) for one, pair in zip(found, rates, strict=True)]
    return variables | _with_bounds(
        {"annual_rate_ratio": (("state",), "annual rate with over without pounding", ratios)}
    )


def _in_an_event(found: Sequence[Curves], options: Options) -> dict[str, Any]:
    """Probabilities of reaching each state in an event; none without ground-motion fields."""
    if options.fields is None:
        return {}
    known = [
        [scenario_of(options.fields, _fragility(one, side, options), options.confidence) for side in (0, 1)]
        for one in found
    ]
    words = "probability that the state is reached in an event"
    return {
        name: (
            ("state", "pounding"),
            np.array([[getattr(scenario, field) for scenario in pair] for pair in known]),
            described("1", f"{bound}{words}"),
        )
        for name, field, bound in (
            ("event_probability", "probability", ""),
            ("event_probability_low", "low", "lower bound: "),
            ("event_probability_high", "high", "upper bound: "),
        )
    }


def _rate_ratio(one: Curves, rates: Sequence[Rate], options: Options) -> Ratio:
    assert options.hazard is not None
    hazard, value = options.hazard, _over(rates[0].annual, rates[1].annual)
    sides = [annual_rate(hazard, np.exp(side[:, 0]), side[:, 1]) for side in one.drawn_alike]
    return Ratio(value, *one.bounds(_over(*sides), options.tails))


def _fragility(one: Curves, side: int, options: Options) -> Fragility:
    about: dict[str, Any] = {"what": one.state.name, "gap": 0.0, "yield_force": None, "contact_model": None}
    about |= {"intensity": options.intensity, "method": options.method, "note": "", "stripes": ()}
    return Fragility(**about, **asdict(one.fits[side]))
