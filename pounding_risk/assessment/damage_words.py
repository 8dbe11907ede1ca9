"""What a dataset of `damage` says in words and in a table."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isfinite, isnan, nan

import numpy as np
import xarray as xr

from pounding_risk._common.counted import counted
from pounding_risk.assessment.damage_curves import (
    DRAWS,
    LOST,
    NO_CONTACT,
    POUNDING,
    SEED,
    Curves,
    Motions,
    Options,
)
from pounding_risk.assessment.hazard import COVERED
from pounding_risk.results.amplitudes import intensity_words
from pounding_risk.results.attributes import (
    collapsible_buildings,
    isolated_buildings,
    moat_walls,
    rotating_buildings,
    rotating_words,
)
from pounding_risk.results.opened import Results
from pounding_risk.statistics.damage_fits import BETWEEN, METHODS, NONE
from pounding_risk.units import GAP, YIELD_FORCE, rounded, say

NAMED = 3  # gaps of a row that are named one by one
FEW = 6  # recordings, below which bounds may be too narrow
METHOD_WORDS = {"stripes": "stripes", "ida": "incremental dynamic analysis", "cloud": "cloud"}


def measure_words(dataset: xr.Dataset) -> tuple[str, str]:
    """The intensity of the curves in words, and its unit."""
    return intensity_words(str(dataset.attrs["intensity"])), str(dataset["im"].attrs["units"])


def gap_words(dataset: xr.Dataset) -> str:
    """The gap of the curves, "20 mm"; of a row whose gaps differ that of each interface, of many the range of them."""
    if "interface_gap" not in dataset.variables:
        return say(float(dataset["gap"]), GAP)
    gaps = np.ravel(dataset["interface_gap"].values)
    if len(gaps) > NAMED:
        return f"{say(gaps.min(), GAP)} to {say(gaps.max(), GAP)}, by interface"
    pairs = zip(gaps, dataset["interface"].values, strict=True)
    return " and ".join(f"{say(gap, GAP)} ({name})" for gap, name in pairs)


def case_words(dataset: xr.Dataset) -> str:
    """The gap, contact model and yield force of the curves, and how many motions they are of."""
    force = float(dataset["yield_force"])
    phrases = [f"gap {gap_words(dataset)}", str(dataset["contact_model"].item()).replace("_", " ")]
    phrases += [f"F_E {say(force, YIELD_FORCE)}"] if isfinite(force) else []
    motions = dataset.sizes["record"] * dataset.sizes["polarity"]
    return f"{', '.join(phrases)}; {counted(motions, 'motion')} {dataset.attrs.get('amplitude', '')}".rstrip()


def finding(dataset: xr.Dataset) -> str:
    """Sentence on what pounding does to each state: to its annual rate where a hazard is known, and to its median.

    A median is earlier with pounding where its ratio is below 1, a rate more frequent where its ratio is above 1. With
    other dispersions both may go one way; the rate, which counts every intensity, is the one that counts.
    """
    words, _ = measure_words(dataset)
    is_known = (dataset["runs"] > 0).any(["pounding", "level"]).values
    order = np.lexsort((np.isnan(dataset["median_ratio"].values), ~is_known))  # ratios first, what is left out last
    clauses = "; ".join(_clause(dataset.isel(state=place)) for place in order)
    gap = gap_words(dataset)
    if "annual_rate_ratio" not in dataset:
        return f"Median {words} with pounding at {gap} over that without: {clauses}"
    return f"Annual rate and median {words}, with pounding at {gap} over without: {clauses}"


def _clause(state: xr.Dataset) -> str:
    """One state in the finding."""
    name, ratio = str(state["state"].item()), float(state["median_ratio"])
    if not state["runs"].any():
        return f"{name} is left out ({state['fault'].values[0]})"
    if isnan(ratio):
        counts = [
            f"{int(state['reached'].sel(pounding=side).sum())} of "
            f"{int(state['runs'].sel(pounding=side).sum())} runs {side}"
            for side in POUNDING
        ]
        if str(state["fault"].sel(pounding="without").item()) == NO_CONTACT:
            lost = int(state["demand_ratio"].sel(pounding="with").isnull().sum())  # failed, or without a finite force
            others = f", not known of {counted(lost, 'other')}" if lost else ""
            return f"{name} is reached in {counts[0]} pounding{others}, and in none without contact"
        return f"{name} has no ratio, it is reached in {' and '.join(counts)}"
    median = _ratio_words(state, "median_ratio")
    rate = float(state["annual_rate_ratio"]) if "annual_rate_ratio" in state else nan
    if isnan(rate):
        missing = float(state["annual_rate_missing"].max()) if "annual_rate_missing" in state else nan
        if missing > COVERED:
            beyond = f"{rounded(100.0 * missing, 2)} % of one lie beyond the hazard curve"
            return f"{name} median {median} (no ratio of rates: {beyond})"
        return f"{name} {median}"
    is_opposed = (round(rate, 2) - 1.0) * (round(ratio, 2) - 1.0) > 0.0  # a lower median alone raises the rate
    return f"{name} rate {_ratio_words(state, 'annual_rate_ratio')}, median {median}" + (
        " (they point opposite ways, as the dispersions differ: the rate counts)" if is_opposed else ""
    )


def _ratio_words(state: xr.Dataset, name: str) -> str:
    """A ratio with its bounds, "0.94 (0.80 to 1.10)", or that it has none."""
    low, high = float(state[f"{name}_low"]), float(state[f"{name}_high"])
    return f"{float(state[name]):.2f}" + (" without bounds" if isnan(low) else f" ({low:.2f} to {high:.2f})")


def notes_of(curves: Sequence[Curves], motions: Motions, options: Options, results: Results) -> Iterator[str]:
    """Sentences on what is assumed, left out and not known."""
    yield from (f"{pair.state.name} is left out: {pair.fits[0].fault}." for pair in curves if not pair.is_known)
    curves, count = [pair for pair in curves if pair.is_known], options.recordings
    is_linked = any(map(results.has_link, range(results.dataset.sizes["interface"])))
    model = "the buildings with their links but without contact" if is_linked else "each building alone"
    yield (
        f"Curves ({options.method}): {METHODS[options.method].words}. Without pounding: {model} under the same motion."
    )
    yield (
        f"Bounds of ratios: {100.0 * options.confidence:g} % by {DRAWS} samples of the {counted(count, 'recording')}, "
        f"drawn with replacement (seed {SEED}), widened for so few (Hesterberg 2015); each sample gives both curves."
    )
    if count < FEW:
        yield f"With {counted(count, 'recording')} the bounds may be too narrow all the same."
    if "inelastic_storeys" not in results.scene.get("effects", {}):
        isolator_text = ", but isolators do" if isolated_buildings(results.scene) else ""
        yield f"No storey yields in the runs{isolator_text}: demands beyond yield are those of elastic buildings."
    isolated = isolated_buildings(results.scene)
    if isolated and any(pair.state.demand.of_structure and not pair.state.storey for pair in curves):
        names = " and ".join(isolated)
        yield f"Drifts and ductility of {names} are those above the isolators, which are storey 1: name it to count it."
    pairs = [pair for pair in curves if "building" in pair.state.demand.places]
    rotating = [
        name for name in rotating_buildings(results.scene) if any(pair.state.building in ("", name) for pair in pairs)
    ]
    yield from (f"{rotating_words(name)}." for name in rotating)
    if (walls := moat_walls(results.scene)) and any(not pair.state.building for pair in pairs):
        yield f"States of any building leave out {' and '.join(walls)}, a wall beside isolators: name it to count it."
    fragile = collapsible_buildings(results.scene)
    for pair in pairs:
        if pair.state.demand.of_structure and pair.state.building not in ("", *fragile) and results.fallen:
            yield (
                f"{pair.state.name}: runs in which {' or '.join(fragile)} collapses are left out, for they end there: "
                f"of {pair.state.building} nothing is known."
            )
    for pair in curves:
        yield from _state_notes(pair, motions, options)


def _state_notes(pair: Curves, motions: Motions, options: Options) -> Iterator[str]:
    """Sentences on one state."""
    name = pair.state.name
    failed = int(np.isnan(pair.ratios[0]).sum())
    if failed:
        count_text = f"{counted(failed, 'run')} of {motions.ims.size}"
        yield f"{name}: {count_text} failed, or have no such demand, and are left out."
    for side, ratios in zip(POUNDING, pair.ratios, strict=True):
        collapsed = int(np.isinf(ratios).sum())
        if collapsed:
            runs = f"{counted(collapsed, 'run')} of {motions.ims.size} {side} pounding"
            yield f"{name}: {runs} ended in the collapse of a storey, and count as reached, of infinite demand."
    for side, fit, capacities in zip(POUNDING, pair.fits, pair.capacities, strict=True):
        curve_text = f"{name}, {side} pounding"
        if fit.fault:
            yield f"{curve_text}: no curve: {fit.fault}."
        if fit.fault == NO_CONTACT or options.method != "ida":
            continue
        if fallen := int(capacities.falls_back.sum()):
            count_text = counted(fallen, "motion")
            yield f"{curve_text}: reached by {count_text} at a level and not at a higher one; the first counts."
        if outside_count := int((np.abs(capacities.status) == 1).sum()):
            count_text = f"of {int((capacities.status != NONE).sum())} capacities {outside_count}"
            yield f"{curve_text}: {count_text} outside the tested levels, which count as such."
        if between_count := int((capacities.status == BETWEEN).sum()):
            count_text = counted(between_count, "capacity", "capacities")
            yield (
                f"{curve_text}: {count_text} known as between two levels only, for the demand jumps: a contact "
                "force is 0 without touch, and a force is capped where what carries it yields."
            )
    if pair.state.demand.interfaces and options.method == "cloud":
        yield (
            f"{name}: a contact force is capped where the contact yields, which a cloud's straight line does not "
            "follow; several levels and stripes do."
        )
    if pair.is_compared and pair.lost:
        consequence = "no bounds are given" if pair.lost > LOST * DRAWS else "left out of the bounds"
        yield f"{name}: no curve from {counted(pair.lost, 'sample')} of recordings; {consequence}."
