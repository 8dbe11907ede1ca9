"""A scene's whole grid: records × polarities × amplitudes × contact laws × gaps × yield forces → one dataset."""

from __future__ import annotations

from os import cpu_count
from pathlib import Path
from typing import NamedTuple

import xarray as xr

from pounding_risk.core.tally import COMPLETE, STATUS_SENTENCES
from pounding_risk.gather import gathered
from pounding_risk.jobs import Job, Order, Part, job_of, never
from pounding_risk.layout import blocks
from pounding_risk.parts import InMemory
from pounding_risk.recheck import check_share
from pounding_risk.results import as_text, check_target, save
from pounding_risk.study import Study, as_study
from pounding_risk.threads import Progress, counter, work_through


class _Chunk(NamedTuple):
    lines: range
    law: int


def scan(
    study: Study | str | Path,
    out: str | Path | None = None,
    *,
    screening: bool = True,
    check_fraction: float = 0.01,
    workers: int | None = None,
    progress: Progress | None = None,
    command: str = "",
) -> xr.Dataset:
    """Run every case of a scene's grid and return (and write to ``out``) one labelled dataset.

    Dimensions: record, polarity, pga (of several), contact_model [name], gap [m],
    yield_force [N]; see `outputs` for the variables. A row's are by interface, contact_point, building and storey as
    well; see `row_outputs`. ``screening`` leaves out runs whose answer is known exactly;
    the answers are the same without it. ``check_fraction`` of the runs, a random sample and at least one, are made
    again at a tighter tolerance: the variables ``sensitive`` and ``change_...`` say how far they move (see
    `recheck`). ``command`` is the command line, kept as an attribute. ``progress`` is called with (cases done, cases in
    all). Raises SceneError for a faulty scene, RecordError for a record that cannot be used, PoundingError for an
    ``out`` that cannot be written or a ``check_fraction`` outside 0 to 1; all of them before the first run.
    """
    target = None if out is None else check_target(out)
    check_share(check_fraction)
    study = as_study(study)
    motions, left_out = gathered(study)
    job = job_of(Order(study, motions, screening, check_fraction))
    parts = InMemory()
    count = counter(job.lines * job.width, progress)

    def work(chunk: _Chunk) -> tuple[range, Part]:
        part = job.solve(chunk.lines, never)
        assert part is not None
        return chunk.lines, part

    def keep(done: tuple[range, Part]) -> None:
        parts.keep(*done, 0.0)
        count(len(done[0]) * job.width)

    chunks = [_Chunk(range(line, line + 1), job.law_at(line)) for line in range(job.lines)]
    work_through(chunks, work, workers or cpu_count() or 1, keep)
    dataset = assembled(job, parts)
    if command:
        dataset.attrs["command"] = command
    if left_out:
        dataset.attrs["left_out"] = as_text(list(left_out))
    if target is not None:
        save(dataset, target)
    return dataset


def assembled(job: Job, parts: InMemory) -> xr.Dataset:
    """The dataset in memory."""
    form, labeller = job.form, job.labeller()
    import numpy as np

    values = {name: np.zeros((form.lines, form.width, *form.extra(name)), v.dtype) for name, v in form.cases.items()}
    spans = list(blocks(form))
    for lines, part in zip(spans, parts.parts(spans), strict=True):
        for name, found in labeller.values(lines, part).items():
            values[name][lines.start : lines.stop] = found
    finish = labeller.finish()
    for line, patch in finish.patches:
        for name, found in patch.items():
            values[name][line] = found[0]
    sizes = tuple(form.skeleton.sizes[dim] for dim in form.dims)
    made = {
        name: (
            (*form.dims, *form.cases[name].dims),
            array.reshape(*sizes, *form.extra(name)),
            dict(form.cases[name].attrs),
        )
        for name, array in values.items()
    }
    return form.skeleton.assign(made).assign_attrs(finish.attrs)


def failures(dataset: xr.Dataset) -> dict[str, int]:
    """How many cases failed, by the sentence that says why."""
    status = dataset["status"].values
    counts = {sentence: int((status == code).sum()) for code, sentence in STATUS_SENTENCES.items() if code != COMPLETE}
    return {sentence: count for sentence, count in counts.items() if count}


def summary(dataset: xr.Dataset) -> dict[str, int]:
    """Cases in all, those simulated, those known without a run, those found sensitive, those failed by sentence."""
    status = dataset["status"].values
    counts = {
        "cases": int(status.size),
        "simulated": int(dataset["simulated"].sum()),
        "known without a run of their own": int((dataset["simulated"] == 0).sum()),
    }
    if "sensitive" in dataset:
        counts["made again"] = int((dataset["sensitive"] >= 0).sum())
        counts["of these sensitive"] = int((dataset["sensitive"] == 1).sum())
    return counts | failures(dataset)
