"""The accessor ``pounding`` of datasets: the public calls that take a dataset, as methods of it, and a short display.

Registered with xarray where a module is imported that makes or opens datasets, so for every dataset that the package
returns or opens. Importing xarray takes longer than checking a scene, which needs none of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import reduce, wraps
from inspect import signature
from typing import Any

import numpy as np
import xarray as xr

import pounding_risk
from pounding_risk._common.counted import counted
from pounding_risk._common.short_repr import ShortRepr
from pounding_risk._common.words import listed
from pounding_risk.errors import PoundingError
from pounding_risk.results.amplitudes import axis_words, listed_values
from pounding_risk.results.check import kind_of
from pounding_risk.results.layout import axes_of_cases
from pounding_risk.results.opened import Results, one_case
from pounding_risk.results.scene_axes import along_words

MOST_COUNTED = 5_000_000  # cases whose states are read for the display
# What may be called next on a dataset of each kind, as the display says it.
NEXT = {
    "scan": (".figure()", ".assess()", '.report("report.html")', ".case(gap=...)", ".separations()", ".summary()"),
    "simulate": (".figure()", '.save("run.nc")'),
    "histories": (".case(gap=...)",),
    "compare": (".figure()", ".case(gap=...)"),
    "accuracy": (".figure()",),
    "effects": (".figure()", ".case(gap=...)"),
    "spectra": (".figure()", '.save("spectra.nc")'),
    "uncertainty": (".figure()", '.save("uncertainty.nc")'),
    "amplification": (".figure()", '.save("amplification.nc")'),
    "damage": (".figure()", '.figure("ida")', '.save("damage.nc")'),
}
REPAIR = "take what a call such as scan, simulate or spectra returned, or open_results opened"
# Coordinates or attributes that have the value of a run: one for all, or one for each interface or contact point.
LEVELS = {"pga": ("pga",), "gap": ("gap", "interface_gap"), "yield_force": ("yield_force", "contact_point_yield_force")}
OF_RUN = ("record", "polarity", "contact_model", "status")  # attributes of a run that its display shows


class _Method:
    """A function whose first argument is a dataset, as a method: named as `pounding_risk` has it, or the function.

    A named one stands in a layer above, and is imported where it is first used.
    """

    def __init__(self, function: str | Callable[..., Any]) -> None:
        self.function = function

    def __get__(self, accessor: Pounding | None, owner: type | None = None) -> Callable[..., Any]:
        target: Any = self.function
        function: Any = reduce(getattr, target.split("."), pounding_risk) if isinstance(target, str) else target
        return function if accessor is None else _bound(function, accessor)


def _bound(function: Callable[..., Any], accessor: Pounding) -> Callable[..., Any]:
    """The function with the accessor's dataset as its first argument; its signature has the others."""

    @wraps(function)
    def method(*arguments: Any, **options: Any) -> Any:
        return function(accessor.checked(), *arguments, **options)

    full = signature(function)
    method.__signature__ = full.replace(parameters=list(full.parameters.values())[1:])  # type: ignore[attr-defined]
    return method


@xr.register_dataset_accessor("pounding")
class Pounding(ShortRepr):
    """What can be asked of a dataset of this package: ``dataset.pounding.assess(gap="40 mm")``.

    Each method is the public call that takes a dataset, with this one as its first argument; ``separations`` is
    `code_table`, ``figure`` is `figures.results_figure`, and ``case`` selects one case by its values.
    """

    assess = _Method("assess")
    setbacks = _Method("setbacks")
    uncertainty = _Method("uncertainty")
    damage = _Method("damage")
    report = _Method("report")
    figure = _Method("figures.results_figure")
    case = _Method(one_case)
    separations = _Method("code_table")
    summary = _Method("summary")
    view = _Method("view")
    draw = _Method("draw")
    animate = _Method("animate")
    save = _Method("save")

    def __init__(self, dataset: xr.Dataset) -> None:
        self._dataset = dataset

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """A question about results that has no method here: that of its function."""
        function = None if name.startswith("_") else getattr(pounding_risk, name, None)
        if function is None or next(iter(signature(function).parameters), "") != "results":
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        return _bound(function, self)

    @property
    def kind(self) -> str:
        """The call that made the dataset, such as scan, simulate or spectra; "" where none did."""
        return kind_of(self._dataset)

    def checked(self) -> xr.Dataset:
        """The dataset; raises PoundingError where this package did not make it."""
        if not self.kind:
            raise PoundingError(f"{_foreign(self._dataset)}; {REPAIR}")
        return self._dataset

    def heading(self) -> str:
        """Which call made the dataset."""
        return f"results of {self.kind}" if self.kind else "no results"

    def facts(self) -> Iterable[tuple[str, str]]:
        """Scene, buildings, axes with their values, cases, and what to call next, as pairs of a name and words."""
        dataset, kind = self._dataset, self.kind
        if not kind:
            yield "pounding", _foreign(dataset)
            return
        yield "scene", str(dataset.attrs.get("title", ""))
        if "building" in dataset.coords:
            yield "buildings", " | ".join(map(str, dataset["building"].values.ravel()))
        yield from _facts_of_run(dataset) if kind == "simulate" else _facts_of_grid(dataset)
        if kind == "uncertainty":
            yield from zip(dataset["interface"].values.tolist(), dataset["sentence"].values.tolist(), strict=True)
        if "finding" in dataset.attrs:
            yield "finding", str(dataset.attrs["finding"])
        yield "go on with", f".pounding{', '.join(NEXT[kind])}"


def _foreign(dataset: xr.Dataset) -> str:
    """Sentence on a dataset that the package did not make."""
    has = listed(list(map(str, dataset.data_vars)), 3) or "none"
    return f"pounding: this dataset was not made by pounding_risk, or lost what shows it (its variables: {has})"


def _facts_of_run(run: xr.Dataset) -> Iterator[tuple[str, str]]:
    facts: list[tuple[str, Any]] = [(axis_words(name), run.attrs.get(name, "")) for name in OF_RUN]
    facts += [(axis_words(axis), listed_values(axis, _levels(run, axis))) for axis in LEVELS]
    facts.append(("contacts", run.sizes.get("contact", 0)))
    if "time" in run.variables:
        facts.append(("lasts", f"{float(run['time'][-1]):.6g} s, {counted(run['time'].size, 'instant')}"))
    yield from ((name, str(words)) for name, words in facts if words != "")


def _levels(run: xr.Dataset, axis: str) -> list[float]:
    """The amplitude, gaps or yield forces of a run, each once."""
    stored = [run[name].values if name in run.coords else run.attrs.get(name) for name in LEVELS[axis]]
    levels = [level for value in stored if value is not None for level in np.atleast_1d(value)]
    return sorted({float(level) for level in levels if not isinstance(level, str)})  # which is no level: damaged


def _facts_of_grid(dataset: xr.Dataset) -> Iterator[tuple[str, str]]:
    for words in along_words(dataset):
        key, _, extent = words.partition(": ")
        yield key, extent
    for axis in ("setting", "effects", *axes_of_cases(dataset)):
        if axis in dataset.coords:
            name = Results(dataset).axis_name(axis)
            yield axis_words(name), listed_values(name, Results(dataset).values_along(axis))
    if "status" in dataset.variables:
        yield "cases", _cases(dataset)


def _cases(dataset: xr.Dataset) -> str:
    """Number of cases; how many of them were simulated and are complete, unless it takes long to read."""
    cases = f"{dataset['status'].size:,}"
    if dataset["status"].size > MOST_COUNTED:
        return f"{cases}; .summary() counts those that are complete"
    simulated = f"{int(dataset['simulated'].sum())} simulated, " if "simulated" in dataset.variables else ""
    return f"{cases}, {simulated}{int((dataset['status'] == 0).sum())} complete"
