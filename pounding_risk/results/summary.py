"""Summary of a dataset in a few numbers, read block by block, so that it need not fit into memory.

No solver is imported: results can be summed up where none can be compiled.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from math import fsum, inf, nan
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

from pounding_risk._common.short_repr import ShortRepr
from pounding_risk.errors import PoundingError
from pounding_risk.results.attributes import isolated_notes, status_sentences
from pounding_risk.results.check import AXES_OF_CASES, check_scan
from pounding_risk.results.files import open_with_axes, reading, stream_results
from pounding_risk.results.layout import Template, blocks, streamed, template_of, values_at
from pounding_risk.results.opened import Results
from pounding_risk.results.scene_axes import open_axes, without_effect, words_of_values
from pounding_risk.results.tolerance_check import findings
from pounding_risk.results.variables import NOT_RUN, UNPUSHED

COMPLETE = 0  # of the variable ``status``
IN_RECHECKS = ("recomputed", "of these sensitive")  # counts that the sentences on rechecks contain
SHOWN = 3  # outputs that a short display names
OUTCOMES = ("status", "simulated", "sensitive")  # counted, not averaged


class Spread(NamedTuple):
    """Spread of a variable under one contact model, over the complete cases in which it has a value."""

    values: int  # how many
    least: float  # NaN, as the others, where there is no value
    mean: float
    largest: float


@dataclass(frozen=True, repr=False)
class Summary(ShortRepr):
    """Summary of the dataset of a scan."""

    title: str
    counts: dict[str, int]  # see `counted`
    rechecks: dict[str, str]  # see `tolerance_check.findings`
    units: dict[str, str]  # by variable
    spreads: dict[str, dict[str, Spread]]  # by variable and contact model
    notes: tuple[str, ...] = ()  # on unusual numbers of the input and of the contacts
    along: tuple[tuple[str, str], ...] = ()  # each axis of numbers of the scene, and what is along it

    def facts(self) -> Iterable[tuple[str, str]]:
        """Scene, counts of cases, rechecks, the variables with a spread, and notes, as pairs of a name and words."""
        yield "scene", self.title
        yield from self.along
        yield from ((name, f"{count:,}") for name, count in self.counts.items() if name not in IN_RECHECKS)
        yield from self.rechecks.items()
        yield "spreads", f"of {len(self.spreads)} outputs, {', '.join([*self.spreads][:SHOWN])} and so on"
        yield from (("note", note) for note in self.notes)


def summary(results: xr.Dataset | str | Path) -> Summary:
    """How a dataset's cases ended, and the range of outputs.

    Parameters
    ----------
    results : xarray.Dataset, str or Path
        A dataset of `scan`, or its file (``.nc``, ``.zarr``).

    Returns
    -------
    Summary
        Counts of cases, findings of the tolerance check, spreads in SI units, and notes on unusual numbers.

    Raises
    ------
    PoundingError
        For a file that cannot be read, and for anything that is not the dataset of a scan.
    """
    if isinstance(results, str | Path):
        with stream_results(results) as dataset, reading(results, (OSError, RuntimeError)):
            return _summary(dataset, str(results))
    return _summary(results if open_axes(results) else open_with_axes(results, "the dataset").dataset, "the dataset")


def _summary(dataset: xr.Dataset, source: str) -> Summary:
    template = template_of(dataset)
    if "status" not in template.cases or "contact_model" not in template.dims:
        raise PoundingError(
            f"{source}: is no dataset of a scan; name what `pounding-risk scan SCENE -o results.nc` wrote"
        )
    if "rtol" not in dataset.attrs:
        raise PoundingError(f"{source}: its attributes are lost; name the file that the scan wrote, before any change")
    check_scan(dataset, source, names=(*AXES_OF_CASES, "simulated", "impact_count"))
    spreads = _spreads(dataset, template)
    units = {name: str(template.cases[name].attrs.get("units", "1")) for name in spreads}
    title = str(dataset.attrs.get("title", ""))
    notes, along = (*Results(dataset).notes, *isolated_notes(dataset)), tuple(_along(dataset))
    return Summary(title, counted(dataset), dict(findings(dataset)), units, spreads, notes, along)


def _along(dataset: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Each axis with several places: its values, in how many cases there is contact, and whether any output changes."""
    idle = without_effect(dataset)
    for axis in open_axes(dataset):
        words = words_of_values(dataset, axis.name)
        shares = [
            float((dataset["impact_count"].isel({axis.name: place}) > 0).any("interface").mean())
            for place in range(dataset.sizes[axis.name])
        ]
        shares_text = " to ".join(dict.fromkeys(f"{100.0 * end:.3g} %" for end in (min(shares), max(shares))))
        effect = "no output depends on it" if axis.name in idle else f"contact in {shares_text} of cases"
        yield axis.name, f"{words}; {effect}"


def counted(dataset: xr.Dataset) -> dict[str, int]:
    """Number of cases: all, simulated, known without a run, sensitive, and failed, these by sentence."""
    names = [name for name in OUTCOMES if name in dataset]
    cases, simulated, rechecked, sensitive = 0, 0, 0, 0
    for piece in streamed(dataset, names):
        cases += piece["status"].size
        simulated += int(piece["simulated"].sum())
        if "sensitive" in piece:
            rechecked += int((piece["sensitive"] >= 0).sum())
            sensitive += int((piece["sensitive"] == 1).sum())
    statuses = _statuses(dataset)
    unpushed = statuses[UNPUSHED]
    counts = {"cases": cases, "simulated": simulated, "known without a run of their own": cases - simulated - unpushed}
    if unpushed:
        counts[NOT_RUN] = unpushed
    if "sensitive" in names:
        counts |= {"recomputed": rechecked, "of these sensitive": sensitive}
    return counts | failures(dataset, statuses)


def failures(dataset: xr.Dataset, statuses: Mapping[int, int] | None = None) -> dict[str, int]:
    """Number of failed cases by the sentence that says why; ``statuses`` are those of `_statuses`, if known."""
    cases, sentences = _statuses(dataset) if statuses is None else statuses, status_sentences(dataset["status"])
    failed_codes = [code for code in sorted(cases) if code not in (COMPLETE, UNPUSHED)]
    return {sentences.get(code, f"status {code}"): cases[code] for code in failed_codes}


def _statuses(dataset: xr.Dataset) -> Counter[int]:
    """Number of cases by status."""
    cases: Counter[int] = Counter()
    for piece in streamed(dataset, ("status",)):
        codes, counts = np.unique(piece["status"], return_counts=True)
        cases.update(dict(zip(map(int, codes), map(int, counts), strict=True)))
    return cases


class _Accumulator:
    """Count, extremes and sums of a variable over the blocks read so far."""

    def __init__(self) -> None:
        self.values, self.least, self.largest = 0, inf, -inf
        self.sums: list[float] = []

    def add(self, numbers: np.ndarray) -> None:
        finite = numbers[np.isfinite(numbers)]
        if finite.size:
            self.values += finite.size
            self.least, self.largest = min(self.least, float(finite.min())), max(self.largest, float(finite.max()))
            with np.errstate(over="ignore"):  # of damaged numbers
                self.sums.append(float(finite.sum(dtype=float)))

    def spread(self) -> Spread:
        if not self.values:
            return Spread(0, nan, nan, nan)
        total = fsum(self.sums) if max(map(abs, self.sums)) < 1e300 else sum(self.sums)  # which may overflow
        return Spread(self.values, self.least, total / self.values, self.largest)


def _spreads(dataset: xr.Dataset, template: Template) -> dict[str, dict[str, Spread]]:
    laws = [str(name) for name in dataset["contact_model"].values]
    names = [name for name in template.cases if name not in OUTCOMES]
    accumulators = {name: [_Accumulator() for _ in laws] for name in names}
    for block in blocks(template):
        piece = values_at(dataset, template, block, ("status", *names))
        complete = piece["status"] == COMPLETE
        law_of = np.unravel_index(np.array(block), template.shape[:-1])[template.axes.index("contact_model")]
        for place in range(len(laws)):
            is_chosen = complete & (law_of == place)[:, None]
            for name in names:
                accumulators[name][place].add(piece[name][is_chosen])
    return {
        name: {law: accumulator.spread() for law, accumulator in zip(laws, by_law, strict=True)}
        for name, by_law in accumulators.items()
    }
