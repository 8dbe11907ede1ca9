"""Results of a study of effects: what each changes, in which cases, and the finding as a sentence."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

import numpy as np
import xarray as xr

from pounding_risk._common.counted import counted
from pounding_risk._common.words import words_of
from pounding_risk.units import signed_percent

NONE, ALL = "none", "all together"
# What an effect may change, with the words for it; the first is the one that the finding speaks of.
COMPARED = words_of("peak_relative_displacement", "peak_contact_force", "impact_count", "impulse")
COMPARED |= words_of("peak_storey_shear", "peak_floor_acceleration", "permanent_set")
DIGITS = 4  # that a table shows
ROUNDING = 1e-12  # a relative change that is none


def changes(dataset: xr.Dataset, name: str, output: str) -> np.ndarray:
    """Relative change of one output by these effects, over the cases that they act on and that complete with them.

    An effect of yielding acts on the cases that yield without effects, one of the ground or of buildings on all. Where
    there was nothing before, a change to something is infinite. Of a row every interface, or building, counts.
    """
    acted = acted_on(dataset, name)
    before = dataset[output].sel(effects=NONE).values.astype(float)[acted]
    after = dataset[output].sel(effects=name).values.astype(float)[acted]
    is_finite = np.isfinite(before) & np.isfinite(after)
    if dataset[output].dtype.kind == "i":
        is_finite &= (before >= 0) & (after >= 0)  # −1 is the count of a run that failed
    before, after = before[is_finite], after[is_finite]
    with np.errstate(divide="ignore", invalid="ignore"):
        change = (after - before) / np.abs(before)
    is_same = np.isclose(after, before, rtol=ROUNDING, atol=0.0)
    return np.where(is_same, 0.0, np.where(before == 0.0, inf, change))


def acted_on(dataset: xr.Dataset, name: str) -> np.ndarray:
    """True for the cases that these effects act on; in the shape of a case's outputs."""
    return yielding_cases(dataset) | bool(dataset["acts_on_all"].sel(effects=name))


def changed_cases(dataset: xr.Dataset, name: str) -> int:
    """In how many cases these effects change a reported digit of any output."""
    is_altered = np.zeros(dataset["status"].sel(effects=NONE).shape, dtype=bool)
    for output in COMPARED:
        before, after = (dataset[output].sel(effects=label).values for label in (NONE, name))
        pairs = zip(before.ravel(), after.ravel(), strict=True)
        printed = [f"{one:.{DIGITS}g}" != f"{other:.{DIGITS}g}" for one, other in pairs]
        is_different = np.reshape(printed, before.shape)
        is_altered |= is_different.any(axis=-1) if is_different.ndim > is_altered.ndim else is_different
    return int(is_altered.sum())


def finding(dataset: xr.Dataset) -> str:
    """One sentence: which effect changes most, what the effects cost, and which change no reported digit."""
    names = [str(name) for name in dataset["effects"].values[1:]]
    idle_names = [name for name in names if changed_cases(dataset, name) == 0]
    cases = counted(int(dataset["status"].sel(effects=NONE).size), "case")
    largest_ratio = float(dataset["time_ratio"].max())
    cost = f"a run takes {largest_ratio:.2f} times as long at most" if largest_ratio > 1.0 else "none takes time"
    if len(idle_names) == len(names):
        return f"No effect changes a reported digit of any of the {cases}; {cost}."
    output, words = next(iter(COMPARED.items()))
    # All together is no effect of its own: it is named where no single one stands beside it.
    single_names = [name for name in names if name not in idle_names and name != ALL] or [ALL]
    spreads = {name: np.abs(changes(dataset, name, output)) for name in single_names}
    spreads = {name: spread for name, spread in spreads.items() if spread.size}
    if not spreads:
        return f"No change of the {words} is known in any of the {cases}: runs fail, or none yields; {cost}."
    strongest = max(spreads, key=lambda name: float(np.mean(spreads[name])))
    change = changes(dataset, strongest, output)
    idle_words = f"; {' and '.join(idle_names)} change no reported digit" if idle_names else ""
    return (
        f"{strongest} changes the {words} most: by {signed_percent(change.min())} to {signed_percent(change.max())} %, "
        f"in {changed_cases(dataset, strongest)} of {cases} ({yielding(dataset)} yield); {cost}{idle_words}."
    )


def yielding(dataset: xr.Dataset) -> int:
    """In how many cases F_E is reached without effects."""
    return int(yielding_cases(dataset).sum())


def yielding_cases(dataset: xr.Dataset) -> np.ndarray:
    """True for the cases in which F_E is reached without effects, of a row anywhere."""
    yields = dataset["yield_exceedance"].sel(effects=NONE) == 1
    return np.asarray((yields.any("interface") if "interface" in yields.dims else yields).values)


def rows(dataset: xr.Dataset) -> Iterator[tuple[str, int, float, float, dict[str, tuple[float, float, float]]]]:
    """For every line but the first: effects, cases changed, time, ratio, and smallest, median, largest change."""
    for name in map(str, dataset["effects"].values):
        results = dataset.sel(effects=name)
        spread = {}
        for output in COMPARED:
            change = changes(dataset, name, output)
            low, middle, high = (change.min(), float(np.median(change)), change.max()) if change.size else (0.0,) * 3
            spread[output] = (low, middle, high)
        yield name, changed_cases(dataset, name), float(results["time"]), float(results["time_ratio"]), spread
