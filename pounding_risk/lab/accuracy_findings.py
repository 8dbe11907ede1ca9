"""Results of an accuracy study: errors, the time to reach an error level, and the findings as sentences."""

from __future__ import annotations

from math import inf, isfinite, nan

import numpy as np
import xarray as xr

from pounding_risk._common.counted import counted
from pounding_risk._common.words import words_of
from pounding_risk.render.sheet import computing_time
from pounding_risk.results.tolerance_check import WORDS

EVENT = "event-driven"  # this package's solver among the methods
LEVELS = tuple(10.0**-power for power in range(2, 10))
DIGITS = 4  # that the commands print
RESTING = 1e-6  # s from which on a first impact is one, and not a gap that is closed at rest

OUTPUTS = WORDS | words_of("first_impact_time", "gap_required")
REACH, FORCE, COUNT, YIELDS, FIRST, GAP = range(6)


def errors_of(outputs: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Errors (..., outputs): relative for amounts and times, of counts the difference over the count.

    A motion that is not finite where the reference is has an infinite error; so has a first impact that only one has.
    """
    scale = np.abs(reference)
    scale[..., YIELDS] = 1.0
    scale[scale == 0.0] = 1.0
    errors = np.abs(outputs - reference) / scale
    no_touch = np.isnan(outputs[..., FIRST]) & np.isnan(reference[..., FIRST]) & np.isfinite(outputs[..., REACH])
    errors[no_touch, FIRST] = 0.0
    return np.where(np.isnan(errors), inf, errors)


def summed_up(errors: np.ndarray) -> tuple[float, float]:
    """(median, worst) over the cases that were run."""
    finite = errors[~np.isnan(errors)]
    return (float(np.median(finite)), float(finite.max())) if finite.size else (nan, nan)


def curve(dataset: xr.Dataset, solver: str, output: str) -> list[tuple[float, float]]:
    """(error, time) of a method's settings, errors the worst over the cases: the envelope from loose and quick on."""
    of_solver = dataset.isel(setting=np.flatnonzero(dataset["method"].values == solver)).sel(output=output)
    points = sorted(zip(of_solver["time"].values, (summed_up(e)[1] for e in of_solver["error"].values), strict=True))
    envelope: list[tuple[float, float]] = []
    for time, error in points:
        if isfinite(error) and (not envelope or error < envelope[-1][0]):
            envelope.append((error, time))
    return envelope


def times_to_reach(dataset: xr.Dataset, solver: str, output: str) -> list[float]:
    """Time per run at which all cases are within each of `LEVELS`; NaN where no setting of a method gets there.

    Between settings, straight lines in the logarithms of error and time.
    """
    points = curve(dataset, solver, output)
    times = []
    for level in LEVELS:
        index = next((i for i, (error, _) in enumerate(points) if error <= level), None)
        if index is None:
            times.append(nan)
        elif index == 0 or points[index][0] <= 0.0:
            times.append(points[index][1])
        else:
            (e0, t0), (e1, t1) = points[index - 1], points[index]
            times.append(float(t0 * (t1 / t0) ** (np.log(e0 / level) / np.log(e0 / e1))))
    return times


def holds_digits(outputs: np.ndarray, reference: np.ndarray) -> bool:
    """True where no value is further from the reference than half a unit of its last printed digit."""
    with np.errstate(divide="ignore", invalid="ignore"):
        unit = 10.0 ** (np.floor(np.log10(np.abs(reference))) - (DIGITS - 1))
    unit[..., [COUNT, YIELDS]] = 1.0
    is_same = np.abs(outputs - reference) <= 0.5 * np.where(np.isfinite(unit), unit, 0.0)
    is_same |= np.isnan(outputs) & np.isnan(reference)
    # No digit of a first touch from rest means anything; see `_dataset`.
    is_same[reference[..., FIRST] < RESTING, FIRST] = True
    return bool(is_same.all())


def finding(dataset: xr.Dataset) -> str:
    """One sentence: the cheapest setting whose printed digits no longer change, and the runner-up."""
    reference, times = dataset["reference"].values, dataset["time"].isel(output=REACH).values
    names, methods = dataset["setting"].values, dataset["method"].values
    is_lost = np.isnan(reference[..., REACH]).reshape(len(reference), -1).any(axis=1)
    was_run = is_lost | ~np.isnan(dataset["error"].values[..., REACH])  # SciPy runs some cases only
    holding = [
        index
        for index, cases in enumerate(was_run)
        if cases.any() and holds_digits(dataset["value"].values[index][cases], reference[cases])
    ]
    exact_settings = [index for index in holding if was_run[index].all()]
    touched = int((reference[..., COUNT] > 0.0).reshape(len(reference), -1).any(axis=1).sum())
    count = f"{counted(len(reference), 'case')}, {touched or 'none'} of them with contact"
    if not exact_settings:
        return f"No setting keeps all {DIGITS} printed digits of every output in all of {count}."
    best = min(exact_settings, key=times.__getitem__)
    sentence = f"{names[best]} is the cheapest setting whose {DIGITS} printed digits no longer change in {count}: "
    sentence += f"{computing_time(times[best])['text']} a run"
    other_settings = [index for index in exact_settings if methods[index] != methods[best]]
    if other_settings:
        second = min(other_settings, key=times.__getitem__)
        sentence += f"; the next method, {names[second]}, takes {times[second] / times[best]:.3g} times as long"
    elif partly := [index for index in holding if methods[index] != methods[best] and index not in exact_settings]:
        other = min(partly, key=times.__getitem__)
        part = f"{was_run[other].sum()} of {len(reference)} cases"
        sentence += f"; {names[other]}, has them too in the {part} in which it was run"
    elif methods[best] == EVENT:
        is_alone = set(methods) == {EVENT}
        sentence += "; no other method was run" if is_alone else "; no setting of another method gets there"
    return sentence + "."


def beaten_at(dataset: xr.Dataset) -> list[str]:
    """Where other methods reach an error level in less time than the event-driven solver, a line for each output.

    Counts and flags are right or wrong and have no levels.
    """
    lines = []
    reach = dataset["time_to_reach"]
    for output in (REACH, FORCE, FIRST, GAP):
        own_times = reach.sel(solver=EVENT).values[output]
        faster = []
        for solver in (name for name in reach["solver"].values if name != EVENT):
            ratios = own_times / reach.sel(solver=solver).values[output]
            levels_ahead = [(level, ratio) for level, ratio in zip(LEVELS, ratios.tolist(), strict=True) if ratio > 1.0]
            if levels_ahead:
                largest = max(ratio for _, ratio in levels_ahead)
                faster.append(f"{solver} for errors down to {levels_ahead[-1][0]:.0e} ({largest:.2g} times at most)")
        if faster:
            lines.append(f"{list(OUTPUTS.values())[output]}: {'; '.join(faster)}")
    return lines
