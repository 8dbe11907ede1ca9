"""The dataset of `damage`: curves of each state with pounding and without, their ratios, and demands of the motions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk.assessment.damage_curves import POUNDING, Curves, Motions, Options
from pounding_risk.assessment.fragility import Fragility
from pounding_risk.assessment.gmfs import scenario_of
from pounding_risk.assessment.hazard import rate_of
from pounding_risk.results.amplitudes import intensity_unit, intensity_words
from pounding_risk.results.variables import bounded, described
from pounding_risk.statistics.fragility import fragility_curve
from pounding_risk.statistics.hazard import annual_rate

Array = NDArray[np.float64]

POINTS = 61  # intensities of the curves
PERCENTILES = (16.0, 50.0, 84.0)
BOTH = ("state", "pounding")
OF_CASE = ("gap", "contact_model", "yield_force")
OF_GAPS = ("interface", "interface_gap")  # of a row whose gaps differ


def dataset_of(curves: Sequence[Curves], motions: Motions, options: Options, case: xr.Dataset) -> xr.Dataset:
    """The dataset of all states."""
    unit, words = intensity_unit(options.intensity), intensity_words(options.intensity)
    tests = motions.ims[np.isfinite(motions.ims)]
    im = np.geomspace(tests.min(), tests.max(), POINTS) if np.ptp(tests) > 0.0 else tests[:1]
    common_ims = motions.levels
    level = np.arange(1.0, motions.ims.shape[1] + 1.0) if common_ims is None else common_ims
    level_facts = ("1", "number of the level, from 1") if common_ims is None else (unit, f"{words} of all motions")
    motion_shape = (len(motions.records), len(motions.polarities))
    faults = np.array([[fit.fault for fit in pair.fits] for pair in curves], dtype=str)
    thresholds, ims = [pair.state.threshold for pair in curves], motions.ims.reshape(*motion_shape, -1)
    coords = {
        "state": ("state", [pair.state.name for pair in curves], {"long_name": "state of damage"}),
        "state_words": ("state", [pair.state.words for pair in curves], {"long_name": "demand that reaches the state"}),
        "state_threshold": ("state", thresholds, {"long_name": "threshold, in state_unit"}),
        "state_unit": ("state", [pair.state.demand.unit for pair in curves], {"long_name": "unit of the demand"}),
        "pounding": ("pounding", list(POUNDING), {"long_name": "with contact between buildings, or without any"}),
        "level": ("level", level, described(*level_facts)),
        "im": ("im", im, described(unit, words)),
        "record": case["record"].variable,
        "polarity": case["polarity"].variable,
        "fault": (BOTH, faults, {"long_name": "why there is no curve"}),
        "motion_intensity": (("record", "polarity", "level"), ims, described(unit, f"{words} of the motion")),
        **{name: case[name].reset_coords(drop=True).variable for name in OF_CASE},
        **({name: case[name].variable for name in OF_GAPS} if OF_GAPS[1] in case.variables else {}),
    }
    variables = {
        **_fit_variables(curves, unit, words),
        **_motion_variables(curves, motion_shape, unit, common_ims is not None),
        **_comparison(curves, im, options, unit, words),
        **_rate_variables(curves, options),
        **_event_variables(curves, options),
    }
    return xr.Dataset(variables, coords, {"intensity": options.intensity, "method": options.method})


def _fit_variables(curves: Sequence[Curves], unit: str, words: str) -> dict[str, Any]:
    """Medians and dispersions of the fits with the larger of their standard errors."""
    columns = np.array([[(fit.median, fit.dispersion, *fit.errors) for fit in pair.fits] for pair in curves])
    about = (
        ("median", unit, f"{words} at which the fitted curve is 0.5"),
        ("dispersion", "1", "dispersion of the curve, the deviation of the logarithm of the intensity"),
        ("median_error", "1", "standard error of the logarithm of the median, by recording or by motion"),
        ("dispersion_error", "1", "standard error of the dispersion, by recording or by motion"),
    )
    return {name: (BOTH, columns[..., k], described(*facts)) for k, (name, *facts) in enumerate(about)}


def _motion_variables(
    curves: Sequence[Curves], motion_shape: tuple[int, int], unit: str, has_common_levels: bool
) -> dict[str, Any]:
    """Demands, capacities and counts of the motions; ``motion_shape`` are the numbers of records and polarities."""
    by_level, by_motion = (*BOTH, "level"), (*BOTH, "record", "polarity")
    shape = (len(curves), len(POUNDING), *motion_shape)
    ratios = np.array([pair.ratios for pair in curves])  # state, pounding, motion, level
    is_known = ~np.isnan(ratios)

    def of_sides(getter: Callable[[Any], Any]) -> Any:
        return np.array([[getter(side) for side in pair.capacities] for pair in curves])

    status_attributes = {
        "long_name": "where the capacity lies",
        "flag_values": np.array([-1, 0, 1, 2, 3], dtype=np.int8),
        "flag_meanings": (
            "at_most_the_lowest_level known above_the_highest_level no_run_is_known between_the_level_and_the_one_below"
        ),
    }
    reached = (np.where(is_known, ratios, 0.0) >= 1.0).sum(axis=2)
    falls_back = of_sides(lambda side: side.falls_back.sum())
    fall_text = "motions that reach the state at a level and not at a higher one"
    ratio_attributes = described("1", "demand over the threshold of the state; infinite where the building collapses")
    capacity = "intensity at which the motion first reaches the state, or the level next to it where it is not known"
    variables: dict[str, Any] = {
        "demand_ratio": ((*by_motion, "level"), ratios.reshape(*shape, -1), ratio_attributes),
        "capacity": (by_motion, of_sides(lambda side: side.reached_at).reshape(shape), described(unit, capacity)),
        "capacity_status": (by_motion, of_sides(lambda side: side.status).reshape(shape), status_attributes),
        "runs": (by_level, is_known.sum(axis=2).astype(np.int32), described("1", "runs that did not fail")),
        "reached": (by_level, reached.astype(np.int32), described("1", "runs that reach the state")),
        "falls_back": (BOTH, falls_back.astype(np.int32), described("1", fall_text)),
    }
    if has_common_levels:
        is_run = is_known.any(axis=2)
        filled = np.where(is_run[:, :, None], ratios, 0.0)
        finite = np.where(np.isinf(filled), np.max(filled, where=np.isfinite(filled), initial=0.0), filled)
        next_run = np.nanpercentile(filled, PERCENTILES, axis=2, method="higher")  # infinite where it is a collapse
        percentiles = np.where(np.isinf(next_run), next_run, np.nanpercentile(finite, PERCENTILES, axis=2))
        percentiles = np.where(is_run, percentiles, np.nan)
        percentile_attributes = described(
            "1",
            "percentile of the demands over the threshold, of the motions at the level; of a collapse infinite",
        )
        variables["demand_percentile"] = (("percentile", *by_level), percentiles, percentile_attributes)
        variables["percentile"] = ("percentile", np.array(PERCENTILES), described("percent", "share of the motions"))
    return variables


def _comparison(curves: Sequence[Curves], im: Array, options: Options, unit: str, words: str) -> dict[str, Any]:
    """Probabilities along the intensity, and ratios with over without, with their bounds."""
    point_ims = np.array([pair.fits[1].median if options.at is None else options.at for pair in curves])
    probabilities = np.array([pair.probability(im) for pair in curves])
    at_points = np.array([pair.probability(place) for pair, place in zip(curves, point_ims, strict=True)])
    ratios = [
        (
            _ratio(pair, options, lambda median, _: median),
            _probability_ratio(pair, im, options),
            _probability_ratio(pair, np.array([place]), options)[:, 0],
        )
        for pair, place in zip(curves, point_ims, strict=True)
    ]
    medians, by_im, single = (np.array(columns) for columns in zip(*ratios, strict=True))  # (states, 3, ...)
    ratio_text = "probability with pounding over that without"
    return {
        "probability": ((*BOTH, "im"), probabilities, described("1", "probability that the state is reached")),
        "at_intensity": ("state", point_ims, described(unit, f"{words} at which both probabilities are compared")),
        "probability_at": (BOTH, at_points, described("1", "probability that the state is reached at at_intensity")),
        **bounded("median_ratio", "state", medians.T, "1", "median with pounding over that without"),
        **bounded("probability_ratio", ("state", "im"), by_im.swapaxes(0, 1), "1", ratio_text),
        **bounded("probability_ratio_at", "state", single.T, "1", f"{ratio_text}, at at_intensity"),
    }


def _probability_ratio(pair: Curves, im: Array, options: Options) -> Array:
    """At these intensities, (3, intensities); NaN where both probabilities are 0 to the last digit."""
    return _ratio(pair, options, lambda median, beta: fragility_curve(im, median[..., None], beta[..., None]))


def _ratio(pair: Curves, options: Options, function: Callable[[Array, Array], Array]) -> Any:
    """With over without pounding of a ``function`` of medians and dispersions, with bounds from the samples, (3, ...).

    Infinite where only the number without pounding is 0, NaN where both are or one is not known.
    """
    with np.errstate(all="ignore"):
        with_contact, without = (function(np.asarray(fit.median), np.asarray(fit.dispersion)) for fit in pair.fits)
        sampled = [function(np.exp(side[:, 0]), side[:, 1]) for side in pair.drawn_alike]
        return np.array([with_contact / without, *pair.bounds(sampled[0] / sampled[1], options.tails)])


def _rate_variables(curves: Sequence[Curves], options: Options) -> dict[str, Any]:
    """Annual rates of reaching each state; none without a hazard curve."""
    hazard = options.hazard
    if hazard is None:
        return {}
    rates = [[rate_of(hazard, fit, options.confidence) for fit in _fragilities(pair, options)] for pair in curves]
    columns = np.array([[(rate.annual, rate.low, rate.high, rate.missing) for rate in pair] for pair in rates])
    rate_text = "annual rate at which the state is reached"
    missing_text = "share of the rate beyond the ends of the hazard curve, were it continued"
    ratios = np.array([_ratio(pair, options, partial(annual_rate, hazard)) for pair in curves])
    # Two lower bounds have no ratio.
    ratios[[any(rate.at_least for rate in pair) for pair in rates]] = np.nan
    return {
        **bounded("annual_rate", BOTH, np.moveaxis(columns[..., :3], -1, 0), "year-1", rate_text),
        "annual_rate_missing": (BOTH, columns[..., 3], described("1", missing_text)),
        **bounded("annual_rate_ratio", "state", ratios.T, "1", "annual rate with over without pounding"),
    }


def _event_variables(curves: Sequence[Curves], options: Options) -> dict[str, Any]:
    """Probabilities of reaching each state in an event; none without ground-motion fields."""
    fields = options.fields
    if fields is None:
        return {}
    events = [[scenario_of(fields, fit, options.confidence) for fit in _fragilities(pair, options)] for pair in curves]
    columns = [
        np.array([[getattr(event, name) for event in pair] for pair in events])
        for name in ("probability", "low", "high")
    ]
    return bounded("event_probability", BOTH, columns, "1", "probability that the state is reached in an event")


def _fragilities(pair: Curves, options: Options) -> list[Fragility]:
    """Both curves of a state as `rate_of` takes them."""
    case = pair.state.name, 0.0, None, None, options.intensity, options.method
    return [Fragility(*case, **asdict(fit)) for fit in pair.fits]
