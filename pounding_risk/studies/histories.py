"""Time histories of chosen cases of a study, at the samples of their records, as one dataset with the labels of a scan.

Each case is run as `simulate` runs it and interpolated at the samples of its record. A block of cases is written before
the next one is run, so that memory does not grow with their number.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from math import isinf
from os import cpu_count
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk._common.dates import created
from pounding_risk._common.files import AGAIN
from pounding_risk._common.progress import Progress
from pounding_risk._common.words import nearest
from pounding_risk.ensemble.job_choice import job_kind
from pounding_risk.ensemble.replacing import OTHER_NAME, check_replaceable
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import LEVEL_AXIS, PEAK, PGA_AXIS, driven
from pounding_risk.motions.motion import Motion
from pounding_risk.results import labels
from pounding_risk.results.amplitudes import axis_words, place_of
from pounding_risk.results.check import check_scan
from pounding_risk.results.files import RESULTS, check_target, open_results, reading
from pounding_risk.results.layout import AMPLITUDE, AXES, CaseVariable, Template, axes_by, axes_of_cases, blocks
from pounding_risk.results.provenance import check_records, recorded
from pounding_risk.results.run_labels import Case
from pounding_risk.results.scene_axes import at_one_place, selected, with_axes
from pounding_risk.results.store import store_of
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.reader import as_scene
from pounding_risk.scene.scene import Scene
from pounding_risk.scene.variants import check_one_scene
from pounding_risk.solver.counters import STATUS_SENTENCES
from pounding_risk.studies.simulate import run_of

LAW = AXES.index("contact_model")
Values = dict[str, Sequence[Any] | None]  # by axis; None for all values of it
MOST = 1000  # cases, unless more are allowed: some tens of seconds, and a gigabyte
# Of the histories of a run, those that are written where its solver makes them.
WRITTEN = (
    "displacement",
    "absolute_displacement",
    "ground_displacement",
    "relative_displacement",
    "contact_force",
    "energy_ground",
    "energy_held",
    "energy_contact",
    "energy_damping",
)
CODES = {sentence: code for code, sentence in STATUS_SENTENCES.items()}
COMMENT = (
    "Values at the samples of the records. Between two samples a peak can be larger: the peaks in the results of "
    "scan are those of the continuous motion."
)


class Choice(NamedTuple):
    """Chosen cases of a grid."""

    places: NDArray[np.int64]  # (cases, axes): index of each case along each of `AXES`
    shape: tuple[int, ...]  # along `AXES`
    by_law: bool  # one case of each contact model: the other axes are labels along it

    @property
    def records(self) -> list[int]:
        """Places of the records that the cases have, ascending."""
        return sorted(set(self.places[:, 0].tolist()))


class Cases(NamedTuple):
    """The chosen cases of a study, ready to be run."""

    study: Scene
    motions: tuple[Motion, ...]
    choice: Choice

    @property
    def samples(self) -> int:
        """Number of samples of the longest record."""
        return max(len(self.motions[place].acceleration) for place in self.choice.records)

    def motion(self, case: Sequence[int]) -> Motion:
        """The motion of a case, in its polarity and amplitude."""
        study = self.study
        return driven(self.motions[case[0]], study.records.polarities[case[1]], study.grid.amplitudes[case[2]])

    def run(self, case: Sequence[int]) -> xr.Dataset:
        """Dataset of a case, as `simulate` returns it."""
        study, grid = self.study, self.study.grid
        law, gap, force = case[LAW:]
        level = grid.gaps[gap], grid.yield_forces[force]
        limits = study.interface_gaps(level[0]), level_forces(study, level[1])
        return run_of(study, Case(self.motion(case), grid.contact_models[law], *level, *limits))

    def at_samples(self, case: Sequence[int]) -> dict[str, Any]:
        """The variables of a case, time last and NaN past the end of its record, and its status."""
        run, times = self.run(case), self.motion(case).times
        # The samples are among the run's instants, except for rounding.
        instants = run["time"].values
        after = np.clip(np.searchsorted(instants, times), 1, len(instants) - 1)
        nodes = np.where(times - instants[after - 1] < instants[after] - times, after - 1, after)
        variables: dict[str, Any] = {"status": CODES[run.attrs["status"]]}
        for name in WRITTEN:
            if name in run:
                array = np.moveaxis(run[name].values[nodes], 0, -1)
                variables[name] = np.full((*array.shape[:-1], self.samples), np.nan)
                variables[name][..., : len(nodes)] = array
        return variables


def level_forces(study: Scene, force: float) -> tuple[float, ...]:
    """Yield forces of the contact points [N] at a yield force of the grid.

    Of a grid of one yield force several interfaces have their own.
    """
    is_own = len(study.grid.yield_forces) == 1 and len(study.interfaces) > 1
    return study.point_yield_forces(None if is_own else force)


def histories(
    source: Scene | str | Path,
    out: str | Path,
    *,
    records: Sequence[str] | None = None,
    polarities: Sequence[str] | None = None,
    pgas: Sequence[float | str] | None = None,
    intensity_levels: Sequence[float | str] | None = None,
    laws: Sequence[str] | None = None,
    gaps: Sequence[float | str] | None = None,
    yield_forces: Sequence[float | str] | None = None,
    largest_of: str | None = None,
    select: Sequence[str] = (),
    most: int = MOST,
    folder: str | Path | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
    say: Callable[[str], None] | None = None,
) -> Path:
    """Write time histories of chosen cases as one dataset.

    Values are those of `simulate` at the samples of the records, with the labels of the results. Of each axis of the
    grid the named values are taken, or all of them.

    Parameters
    ----------
    source : Scene or path
        A scene, or the results of a scan, whose scene and records are then those of the results.
    out : path
        File for the dataset, ``.nc`` or ``.zarr``.
    records : sequence of str, optional
        Only these records.
    polarities : sequence of str, optional
        Only these polarities.
    pgas : sequence of float or str, optional
        Only these peak ground accelerations [m/s², or text with a unit].
    intensity_levels : sequence of float or str, optional
        Only these levels of the measure that the scene scales its records to [SI, or text with a unit], in place of the
        peak ground accelerations.
    laws : sequence of str, optional
        Only these contact models.
    gaps : sequence of float or str, optional
        Only these gaps [m, or text with a unit].
    yield_forces : sequence of float or str, optional
        Only these yield forces F_E [N, or text with a unit].
    largest_of : str, optional
        An output of the results: of each contact model only the case in which it is largest is written, and the other
        axes of the grid are labels along ``contact_model``.
    select : sequence of str
        One value along each axis of another number of the scene that the results have, "building.frame.period=0.5 s".
    most : int
        Most cases that may be written, a safeguard.
    folder : path, optional
        Where record files are that the scene of the results names relative to itself, see `rerun`.
    workers : int, optional
        Number of threads; as many as there are processors by default.
    progress : callable, optional
        Called with the number of cases done and of all cases.
    say : callable, optional
        Called with a sentence on the size, before anything is written.

    Returns
    -------
    pathlib.Path
        The path of the dataset. Its dimensions are those of the results, and sample; ``time`` [s] is by record and
        sample, NaN past the end of a record.

    Raises
    ------
    PoundingError
        As `scan` and `rerun`; and if the grid does not have a value, more than ``most`` cases are chosen, or ``out``
        cannot be written.
    """
    target = check_target(out, RESULTS)
    if not isinstance(source, Scene) and target.resolve() == Path(source).resolve():
        raise PoundingError(f"{out}: is what the histories are of, which stays as it is; write to another name")
    requested: Values = {"record": records, "polarity": polarities, PGA_AXIS: pgas, LEVEL_AXIS: intensity_levels}
    requested |= {"contact_model": laws, "gap": gaps, "yield_force": yield_forces}
    check_replaceable(target, "histories", choice=OTHER_NAME)
    cases = _chosen_cases(source, requested, largest_of, folder, select)
    count = len(cases.choice.places)
    if count > most:
        raise PoundingError(
            f"{counted(count, 'case')} chosen, and at most {most} are written; choose some of the records, polarities, "
            "amplitudes, contact models, gaps or yield forces, or allow more (--most)"
        )
    template = template_of(cases)
    if say is not None:
        size = f"{max(template.bytes_per_case * count / 1e6, 0.1):.1f} MB"
        say(f"{count:,} case{'s' * (count != 1)}, {cases.samples:,} samples: about {size} before compression")
    width, done = template.width, 0
    # Only this thread touches the file.
    with store_of(template, target, AGAIN) as store, ThreadPoolExecutor(workers or cpu_count() or 1) as pool:
        for block in blocks(template):
            indices = cases.choice.places[block.start * width : block.stop * width]
            arrays = {
                name: np.empty((len(indices), *template.extra(name)), variable.dtype)
                for name, variable in template.cases.items()
            }
            for row, variables in enumerate(pool.map(cases.at_samples, indices)):
                for name, array in variables.items():
                    arrays[name][row] = array
                done += 1
                if progress is not None:
                    progress(done, count)
            values = {name: array.reshape(len(block), width, *template.extra(name)) for name, array in arrays.items()}
            store.write(block, values)
        store.finish(created("pounding_risk.histories"))
    return target


def _chosen_cases(
    source: Scene | str | Path, requested: Values, output: str | None, folder: str | Path | None, select: Sequence[str]
) -> Cases:
    """The chosen cases; the source is read, its records too."""
    if isinstance(source, Scene) or Path(source).suffix.lower() not in RESULTS:
        if output is not None:
            raise PoundingError(f"the case with the largest {output} is known from results; name those of a scan")
        study = as_scene(source)
        check_one_scene(study, "histories")
        motions = motions_of(study)
        return Cases(study, motions, _chosen(study, motions, requested))
    with open_results(source, lazy=True) as dataset, reading(source, (RuntimeError,)):
        results = at_one_place(selected(dataset, select, str(source)), str(source))
        study = recorded(results, Path(source), folder).study
        motions = motions_of(study)
        check_records(results, motions)
        if results["record"].ndim == 0:  # of a sample that one motion was drawn with
            motions = tuple(motion for motion in motions if motion.name == results["record"].item())
            results = with_axes(results, str(source))
        choice = _chosen(study, motions, requested)
        if output is not None:
            check_scan(results, str(source))
            choice = largest(results, output, choice)
        return Cases(study, motions, choice)


def _chosen(study: Scene, motions: Sequence[Motion], requested: Values) -> Choice:
    """The chosen cases of a grid, amplitudes by the word of their measure; raises PoundingError as `histories`."""
    measure, labels = study.grid.measure, dict(requested)
    pgas, levels = labels.pop(PGA_AXIS), labels.pop(LEVEL_AXIS)
    if pgas is not None and levels is not None:
        raise PoundingError("pgas and intensity_levels both choose the amplitudes; give one of them")
    if pgas is not None and measure != PEAK:
        raise PoundingError(
            f"PGA: the scene scales its records to levels of {measure.words}; choose by intensity_levels "
            "(--intensity-level)"
        )
    values = values_of(study, [motion.name for motion in motions])
    return chosen(values, labels | {measure.intensity: levels if pgas is None else pgas})


def template_of(cases: Cases) -> Template:
    """The template of the dataset. One case of each contact model is run for it, on one thread: it compiles."""
    choice = cases.choice
    first = [choice.places[choice.places[:, LAW] == law][0] for law in dict.fromkeys(choice.places[:, LAW].tolist())]
    run, *_ = [cases.run(case) for case in first]
    variables = {}
    for name in (name for name in WRITTEN if name in run):
        dims, attrs = (*map(str, run[name].dims[1:]), "sample"), run[name].attrs | {"cell_methods": "sample: point"}
        variables[name] = CaseVariable(dims, np.dtype(np.float64), attrs)
    return Template(_skeleton(cases), {**variables, "status": labels.OUTCOME["status"]}, choice.shape)


def _skeleton(cases: Cases) -> xr.Dataset:
    """Labels, the time of every sample, and the ground motions."""
    study, choice, samples = cases.study, cases.choice, cases.samples
    coords = labels.case_coordinates(study, cases.motions)
    for name in ("period", "record_pgv"):  # facts of records for assessments
        coords.pop(name, None)
    gaps = np.array([study.interface_gaps(gap) for gap in study.grid.gaps])
    coords |= labels.places_of(study, gaps, np.array([level_forces(study, force) for force in study.grid.yield_forces]))
    skeleton = labels.one_amplitude(xr.Dataset(coords=coords), study)
    axes = axes_by(study.grid.measure.axis)
    if choice.by_law:
        indexers: dict[str, Any] = {axis: ("contact_model", choice.places[:, k]) for k, axis in enumerate(axes)}
        dims: tuple[str, ...] = ("contact_model",)
        records, motion_cases = choice.places[:, 0], choice.places
    else:
        indexers = {axis: np.unique(choice.places[:, k]) for k, axis in enumerate(axes)}
        dims, records = tuple(dim for dim in axes[: AMPLITUDE + 1] if dim in skeleton.dims), np.array(choice.records)
        # The first case of each motion, in the order of the axes.
        motion_cases = choice.places.reshape(int(np.prod(choice.shape[:3])), -1, len(AXES))[:, 0]
    skeleton = skeleton.isel({axis: places for axis, places in indexers.items() if axis in skeleton.dims})
    times, ground = np.full((len(records), samples), np.nan), np.full((len(motion_cases), samples), np.nan)
    for row, record in zip(times, records, strict=True):
        row[: len(cases.motions[record].times)] = cases.motions[record].times
    for row, case in zip(ground, motion_cases, strict=True):
        acceleration = cases.motion(case).acceleration
        row[: len(acceleration)] = acceleration
    ground = ground.reshape(*(skeleton.sizes[dim] for dim in dims), samples)
    attributes = labels.described("m/s2", "acceleration of the ground motion, where it comes first")
    return (
        skeleton.assign_coords(
            time=((dims[0], "sample"), times, labels.described("s", "time since the start of the record")),
            sample=("sample", np.arange(samples), labels.described("1", "sample of the record, from 0")),
        )
        .assign(ground_acceleration=((*dims, "sample"), ground, attributes))
        .assign_attrs(
            Conventions=labels.CONVENTIONS,
            title=f"{study.name}: time histories",
            source=f"pounding_risk: event-driven {job_kind(study).solver} solver",
            comment=COMMENT,
            **labels.made_from(study, [cases.motions[place] for place in choice.records]),
        )
    )


def values_of(study: Scene, records: Sequence[str]) -> dict[str, tuple[Any, ...]]:
    """The values of a study's grid by axis, in order; ``records`` are the names of its motions.

    The axis of levels goes by the word of their measure, as `amplitudes` takes it.
    """
    grid = study.grid
    along = (tuple(records), study.records.polarities, grid.levels, grid.contact_models, grid.gaps, grid.yield_forces)
    return dict(zip(axes_by(grid.measure.intensity), along, strict=True))


def chosen(values: dict[str, tuple[Any, ...]], wanted: Values) -> Choice:
    """The cases of these values along each axis.

    A number stands for the value of the grid that is as large, within 1e-9 of it. Raises PoundingError for what the
    grid does not have.
    """
    picked = []
    for axis, values_of_axis in values.items():
        names = wanted.get(axis)
        if names is None:
            picked.append(list(range(len(values_of_axis))))
        elif not names:
            raise PoundingError(
                f"{axis_words(axis)}: the list is empty; name one value at least, or leave it out for all"
            )
        else:
            picked.append(sorted({place_of(axis, values_of_axis, label) for label in names}))
    return Choice(np.array(list(product(*picked)), dtype=np.int64), tuple(map(len, picked)), False)


def largest(results: xr.Dataset, output: str, choice: Choice) -> Choice:
    """Of each contact model the case ``among`` these in which an output of the results is largest.

    An output of interfaces, storeys or buildings counts with its largest value. Raises PoundingError for what is no
    output of a case, and where no case of a contact model has one.
    """
    axes = axes_of_cases(results)
    dims = [axis for axis in axes if axis in results.dims]
    names = [str(name) for name, variable in results.data_vars.items() if set(dims) <= set(variable.dims)]
    if output not in names:
        raise PoundingError(
            f"{output} is no output of a case{nearest(output, names)}; the results have {', '.join(names)}"
        )
    array = results[output].transpose(*dims, ...)
    sizes = tuple(results.sizes.get(axis, 1) for axis in axes)
    outputs = array.values.astype(np.float64).reshape(*sizes, -1)
    peaks = np.where(np.isnan(outputs), -np.inf, outputs).max(axis=-1)[tuple(choice.places.T)]
    best_places = []
    for law in dict.fromkeys(choice.places[:, LAW].tolist()):
        law_cases = np.flatnonzero(choice.places[:, LAW] == law)
        first = law_cases[peaks[law_cases].argmax()]
        if isinf(peaks[first]):
            name = results["contact_model"].values[law]
            raise PoundingError(f"no chosen case of {name} has a finite {output}; choose other cases or another output")
        best_places.append(choice.places[first])
    shape = [1] * len(AXES)
    shape[LAW] = len(best_places)
    return Choice(np.array(best_places), tuple(shape), True)
