"""Time histories of chosen cases of a study, at the samples of their records, as one dataset with the labels of a scan.

Each case is run as `simulate` runs it and told at the samples of its record; it is written before the next ones are
kept, so that memory does not grow with their number.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from os import cpu_count
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.dates import created
from pounding_risk._common.files import AGAIN
from pounding_risk._common.progress import Progress
from pounding_risk.ensemble.laws import law_of
from pounding_risk.ensemble.replacing import OTHER_NAME, check_replaceable
from pounding_risk.ensemble.row_grid import row_grid
from pounding_risk.errors import PoundingError
from pounding_risk.motions.motion import Motion, driven
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.results.check import check_scan
from pounding_risk.results.files import RESULTS, check_target, open_results
from pounding_risk.results.layout import AXES, CaseVariable, Template, blocks
from pounding_risk.results.pair_labels import (
    CONVENTIONS,
    OUTCOME,
    case_coordinates,
    described,
    made_from,
    one_amplitude,
)
from pounding_risk.results.provenance import check_records, recorded
from pounding_risk.results.row_labels import row_coordinates
from pounding_risk.results.store import store_of
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.reader import read_scene
from pounding_risk.scene.scene import Study
from pounding_risk.solver.counters import STATUS_SENTENCES
from pounding_risk.solver.pair.api import Interface
from pounding_risk.studies.case_choice import LAW, Asked, Choice, chosen, largest, values_of
from pounding_risk.studies.simulate import pair_histories
from pounding_risk.studies.simulate_row import Cell, row_histories

MOST = 1000  # cases, unless more are asked for: some tens of seconds, and a gigabyte
OF_A_PAIR = {
    "displacement": ("building",),
    "relative_displacement": (),
    "contact_force": (),
    "energy_ground": (),
    "energy_held": (),
    "energy_contact": (),
    "energy_damping": (),
}
OF_A_ROW = {"displacement": ("building", "storey"), "contact_force": ("contact_point",)}
CODES = {sentence: code for code, sentence in STATUS_SENTENCES.items()}
COMMENT = (
    "Values at the samples of the records. Between two samples a peak can be larger: the peaks in the results of "
    "scan are those of the continuous motion."
)


class Cases(NamedTuple):
    """The chosen cases of a study, ready to be run."""

    study: Study
    motions: tuple[Motion, ...]
    choice: Choice
    laws: dict[int, Any]  # of a pair, by place

    @property
    def samples(self) -> int:
        """Of the longest record."""
        return max(len(self.motions[place].acceleration) for place in self.choice.records)

    def motion(self, place: Sequence[int]) -> Motion:
        """The motion of a case, in its polarity and amplitude."""
        study = self.study
        return driven(self.motions[place[0]], study.records.polarities[place[1]], study.grid.pgas[place[2]])

    def run(self, place: Sequence[int]) -> xr.Dataset:
        """A case as `simulate` tells it."""
        study, grid = self.study, self.study.grid
        motion, (law, gap, force) = self.motion(place), place[LAW:]
        if study.is_row:
            # A grid of one yield force leaves every interface its own.
            level = grid.yield_forces[force] if len(grid.yield_forces) > 1 else None
            gaps, forces = study.interface_gaps(grid.gaps[gap]), study.point_yield_forces(level)
            return row_histories(study, Cell(motion, grid.contact_models[law], np.array(gaps), np.array(forces)))
        interface = Interface(grid.gaps[gap], self.laws[law], study.restitution, grid.yield_forces[force])
        return pair_histories(study, motion, interface)

    def at_samples(self, place: Sequence[int]) -> dict[str, Any]:
        """The variables of a case, time last and NaN past the end of its record, and its status."""
        run, motion = self.run(place), self.motion(place)
        at = _nearest(run["time"].values, motion.times)
        found: dict[str, Any] = {"status": CODES[run.attrs["status"]]}
        for name in OF_A_ROW if self.study.is_row else OF_A_PAIR:
            told = np.moveaxis(run[name].values[at], 0, -1)
            found[name] = np.full((*told.shape[:-1], self.samples), np.nan)
            found[name][..., : len(at)] = told
        return found


def histories(
    source: Study | str | Path,
    out: str | Path,
    *,
    records: Sequence[str] | None = None,
    polarities: Sequence[str] | None = None,
    pgas: Sequence[float] | None = None,
    laws: Sequence[str] | None = None,
    gaps: Sequence[float] | None = None,
    yield_forces: Sequence[float] | None = None,
    largest_of: str | None = None,
    most: int = MOST,
    folder: str | Path | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
    say: Callable[[str], None] | None = None,
) -> Path:
    """Write the time histories of chosen cases of a grid to ``out``, with the labels of its results; returns the path.

    ``source`` is a scene, or the results of a scan, whose scene and records are then those of the results (see
    `rerun`, also for ``folder``). Of each axis of the grid the values named are taken, or all: names, and numbers in
    SI [m/s², m, N]. ``largest_of`` names an output of the results: of each contact model only the case in which it is
    largest. ``say`` is told how much it will be before anything is written, ``progress`` is called with (cases done,
    cases in all).

    Dimensions are those of the results, and sample; ``time`` [s] is by record and sample, NaN past the end of a record.
    Values are those of `simulate` at the samples of the record. With ``largest_of`` the other axes of the grid are
    labels along contact_model.

    Raises PoundingError for values that the grid does not have, more than ``most`` cases, and an ``out`` that cannot be
    written; as `scan` and as `rerun` for the source.
    """
    target = check_target(out, RESULTS)
    if not isinstance(source, Study) and target.resolve() == Path(source).resolve():
        raise PoundingError(f"{out}: is what the histories are of, which stays as it is; write to another name")
    asked: Asked = {"record": records, "polarity": polarities, "pga": pgas}
    asked |= {"contact_model": laws, "gap": gaps, "yield_force": yield_forces}
    check_replaceable(target, "histories", choice=OTHER_NAME)
    cases = _chosen_cases(source, asked, largest_of, folder)
    count = len(cases.choice.places)
    if count > most:
        raise PoundingError(
            f"{count} cases are chosen, and at most {most} are written; choose some of the records, polarities, "
            "amplitudes, contact models, gaps or yield forces, or allow more (--most)"
        )
    template = template_of(cases)
    if say is not None:
        size = f"{max(template.bytes_per_case * count / 1e6, 0.1):.1f} MB"
        say(f"{count:,} case{'s' * (count != 1)}, {cases.samples:,} samples: about {size} before compression")
    _write(cases, template, target, workers or cpu_count() or 1, progress)
    return target


def _chosen_cases(source: Study | str | Path, asked: Asked, output: str | None, folder: str | Path | None) -> Cases:
    """The cases that are asked for; the source is read, its records too."""
    if isinstance(source, Study) or Path(source).suffix.lower() not in RESULTS:
        if output is not None:
            raise PoundingError(f"the case with the largest {output} is known from results; name those of a scan")
        study = source if isinstance(source, Study) else read_scene(source)
        motions = motions_of(study)
        choice = chosen(values_of(study, [motion.name for motion in motions]), asked)
    else:
        with open_results(source, lazy=True) as results:
            study = recorded(results, Path(source), folder).study
            motions = motions_of(study)
            check_records(results, motions)
            choice = chosen(values_of(study, [motion.name for motion in motions]), asked)
            if output is not None:
                check_scan(results, str(source))
                choice = largest(results, output, choice)
    places = dict.fromkeys(choice.places[:, LAW].tolist())
    laws = {} if study.is_row else {place: law_of(study, study.grid.contact_models[place]) for place in places}
    return Cases(study, motions, choice, laws)


def template_of(cases: Cases) -> Template:
    """The template of the dataset. One case of each contact model is run for it, on one thread: it compiles."""
    choice = cases.choice
    first = [choice.places[choice.places[:, LAW] == law][0] for law in dict.fromkeys(choice.places[:, LAW].tolist())]
    run, *_ = [cases.run(place) for place in first]
    variables = {
        name: CaseVariable(
            (*dims, "sample"), np.dtype(np.float64), {**run[name].attrs, "cell_methods": "sample: point"}
        )
        for name, dims in (OF_A_ROW if cases.study.is_row else OF_A_PAIR).items()
    }
    return Template(_skeleton(cases), {**variables, "status": OUTCOME["status"]}, choice.shape)


def _skeleton(cases: Cases) -> xr.Dataset:
    """Labels, the time of every sample, and the ground motions."""
    study, choice, samples = cases.study, cases.choice, cases.samples
    labels = {name: found for name, found in case_coordinates(study, cases.motions).items() if name != "period"}
    if study.is_row:
        labels |= row_coordinates(study, row_grid(study))
    every = one_amplitude(xr.Dataset(coords=labels), study)
    along = "contact_model" if choice.by_law else "record"
    taken: dict[str, Any] = {axis: sorted(set(choice.places[:, place].tolist())) for place, axis in enumerate(AXES)}
    if choice.by_law:
        taken = {axis: (along, choice.places[:, place]) for place, axis in enumerate(AXES)}
    every = every.isel({axis: places for axis, places in taken.items() if axis in every.dims})
    records = choice.places[:, 0] if choice.by_law else choice.records
    times = _rows([cases.motions[place].times for place in records], samples)
    shaken = tuple(dim for dim in AXES[:3] if dim in every.dims)
    driving = choice.places if choice.by_law else _motions_of(choice)
    ground = _rows([cases.motion(place).acceleration for place in driving], samples)
    dims = (along,) if choice.by_law else shaken
    told = described("m/s2", "acceleration of the ground motion, where it comes first")
    return (
        every.assign_coords(
            time=((along, "sample"), times, described("s", "time since the start of the record")),
            sample=("sample", np.arange(samples), described("1", "sample of the record, from 0")),
        )
        .assign(
            ground_acceleration=((*dims, "sample"), ground.reshape(*(every.sizes[dim] for dim in dims), samples), told)
        )
        .assign_attrs(_attributes(cases))
    )


def _motions_of(choice: Choice) -> NDArray[np.int64]:
    """Places of the first case of each motion, in the order of the axes."""
    return choice.places.reshape(int(np.prod(choice.shape[:3])), -1, len(AXES))[:, 0]


def _attributes(cases: Cases) -> dict[str, Any]:
    study = cases.study
    return {
        "Conventions": CONVENTIONS,
        "title": f"{study.name}: time histories",
        "source": f"pounding_risk: event-driven {'row' if study.is_row else 'pair'} solver",
        "comment": COMMENT,
        **made_from(study, [cases.motions[place] for place in cases.choice.records]),
    }


def _rows(values: Sequence[Samples], length: int) -> Samples:
    """Arrays as rows of one length, NaN past the end of the shorter ones."""
    rows = np.full((len(values), length), np.nan)
    for row, each in zip(rows, values, strict=True):
        row[: len(each)] = each
    return rows


def _nearest(times: Samples, asked: Samples) -> NDArray[np.int64]:
    """Where a run is told at these times, which are among its own but for rounding."""
    after = np.clip(np.searchsorted(times, asked), 1, len(times) - 1)
    return np.where(asked - times[after - 1] < times[after] - asked, after - 1, after).astype(np.int64)


def _write(cases: Cases, template: Template, target: Path, workers: int, progress: Progress | None) -> None:
    """Run every case and write it; only this thread touches the file."""
    width, total, done = template.width, len(cases.choice.places), 0
    with store_of(template, target, AGAIN) as store, ThreadPoolExecutor(workers) as pool:
        for block in blocks(template):
            places = cases.choice.places[block.start * width : block.stop * width]
            values = {
                name: np.empty((len(places), *template.extra(name)), each.dtype)
                for name, each in template.cases.items()
            }
            for at, found in enumerate(pool.map(cases.at_samples, places)):
                for name, told in found.items():
                    values[name][at] = told
                done += 1
                if progress is not None:
                    progress(done, total)
            shaped = {name: each.reshape(len(block), width, *template.extra(name)) for name, each in values.items()}
            store.write(block, shaped)
        store.finish(created("pounding_risk.histories"))
