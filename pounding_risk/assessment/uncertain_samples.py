"""Samples of the uncertain numbers of a scene with what the motions close in each, from a run or from a dataset."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk._common.files import STORE
from pounding_risk._common.order import enough_for
from pounding_risk._common.progress import Progress
from pounding_risk.assessment.demands import SAME_GAP, UNDEFINED, Motions, motions_of, pushed_closing
from pounding_risk.assessment.options import Criterion
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import LEVEL_AXIS, PGA_AXIS
from pounding_risk.motions.processing.signals import LEAST_SHAKING
from pounding_risk.results.check import check_scan
from pounding_risk.results.files import open_results, open_scan
from pounding_risk.results.layout import amplitude_axis
from pounding_risk.results.opened import Results
from pounding_risk.results.scene_axes import axes_of, check_one_place, has_drawn_motions, with_axes
from pounding_risk.results.variables import UNPUSHED, described
from pounding_risk.scene.scene_axis import SAMPLE
from pounding_risk.scene.uncertain import SOBOL, points_of
from pounding_risk.statistics.closings import CrossedClosings, DrawnClosings, analysed_clusters
from pounding_risk.statistics.crossed import Analysis, analysed
from pounding_risk.statistics.proportions import labels, logs_of, numbered
from pounding_risk.statistics.sobol import power_of_two, saltelli_points, tornado_points
from pounding_risk.units import shown, unknown

if TYPE_CHECKING:
    from pounding_risk.scene.scene import Scene

Array = NDArray[np.float64]

LEAST_SAMPLES, MOST_SAMPLES = 2, 1_000_000  # of a scene, and of a design
MOST_SOBOL = 65536
OF_RECORDS = ("records", "processing", "motions_sha256", "flags", "copies")  # attributes on all records
ONE_MOTION = (
    "Each sample has one motion, drawn with it: bounds count recordings, of which the samples are clusters. What the "
    "uncertain numbers do alone is not separable from what they do together with the motions, and no sample has its "
    "own P(contact) over the motions."
)
AS_RUN = (
    "What neighbours push across a gap of the row is known at the gaps that were run: wider required gaps, and "
    "P(contact) there, are lower bounds."
)
CORRELATED = (
    "are correlated: their indices share what they have in common, and a tornado moves each by itself, which they "
    "hardly do."
)
ALL_MOTIONS = 'run all motions in each: motions = "all" in [uncertain], or --set uncertain.motions=all'


class Request(NamedTuple):
    """The options of `uncertainty`, as they were read."""

    gap: float | None
    criterion: Criterion
    level: int | None  # index of the requested amplitude
    intensity: str | None
    output: str | None


class OutputKind(NamedTuple):
    """An output of a sample that follows from what its motions close."""

    of: Callable[[Array, float, float], Any]  # closings (samples, motions), the gap [m] and the percentile [%]
    unit: str
    words: str


# By whether each sample has one motion, which is drawn with it.
KINDS_OF_OUTPUT = {
    False: {
        "contact_probability": OutputKind(
            lambda closing, gap, _: (closing > gap).mean(axis=1), "1", "P(contact) over the motions at the gap"
        ),
        "required_gap": OutputKind(
            lambda closing, _, percentile: enough_for(closing, percentile, axis=1),
            "m",
            "gap that the percentile of the motions needs",
        ),
        "log_median_closing": OutputKind(
            lambda closing, *_: logs_of(closing).mean(axis=1), "1", "mean over the motions of ln(closing in m)"
        ),
    },
    True: {
        "contact": OutputKind(
            lambda closing, gap, _: (closing[:, 0] > gap).astype(float),
            "1",
            "whether the sample's motion closes the gap, 1 or 0",
        ),
        "log_closing": OutputKind(
            lambda closing, *_: logs_of(closing)[:, 0], "1", "ln(closing in m) under the sample's motion"
        ),
    },
}


class Output(NamedTuple):
    """An output of each sample and at the points of a design; ``analysis`` is of its values, where not of closings."""

    values: Array
    unit: str
    words: str
    design: Array | None = None
    analysis: Analysis | None = None
    analysis_unit: str = "1"


@dataclass(frozen=True)
class Samples:
    """A dataset along ``sample``, and of each uncertain number (``keys``) its value in each sample.

    Of a scene alone also the datasets at the points of a tornado and of Sobol indices. ``assumptions`` are sentences on
    what is assumed and left out.
    """

    dataset: xr.Dataset
    keys: tuple[str, ...]
    values: tuple[NDArray[Any], ...]
    title: str
    words: str
    assumptions: tuple[str, ...]
    moved_dataset: xr.Dataset | None = None
    design_dataset: xr.Dataset | None = None

    @cached_property
    def first_sample(self) -> Results:
        """The results of the first sample, for what is the same in all."""
        one_sample = with_axes(self.dataset.isel({SAMPLE: [0]}))
        one_sample = one_sample.isel({SAMPLE: 0}, drop=True) if SAMPLE in one_sample.dims else one_sample
        return Results(self._with_drawn_records(one_sample) if self.is_drawn else one_sample)

    def _with_drawn_records(self, one_sample: xr.Dataset) -> xr.Dataset:
        """The dataset of one sample without its motion, and with the facts on every record that is drawn."""
        _, first_samples = np.unique(self.dataset["record"].values, return_index=True)
        fact_names = [str(name) for name in self.dataset.variables if str(name).startswith("record")]
        variables = {name: self.dataset[name].variable.isel({SAMPLE: first_samples}) for name in fact_names}
        for name, variable in variables.items():
            dims = tuple("record" if dim == SAMPLE else dim for dim in variable.dims)
            variables[name] = type(variable)(dims, variable.values, variable.attrs)
        outputs = [name for name, variable in one_sample.variables.items() if "record" in variable.dims]
        of_records = {name: self.dataset.attrs[name] for name in OF_RECORDS if name in self.dataset.attrs}
        bare = one_sample.drop_vars([*outputs, *({"polarity"} & set(one_sample.variables))]).assign_attrs(of_records)
        variables["polarity"] = type(variables["record"])("polarity", self.dataset["polarity"].values[:1])
        spectra = {name: variables.pop(name) for name in fact_names if name not in self.dataset.coords}
        return bare.assign_coords(variables).assign(spectra)

    @property
    def is_drawn(self) -> bool:
        """True where each sample has one motion, which is drawn with it."""
        return has_drawn_motions(self.dataset)

    @property
    def interfaces(self) -> tuple[str, ...]:
        return tuple(map(str, np.atleast_1d(self.dataset["interface"].values)))

    @property
    def is_balanced(self) -> bool:
        """True where the samples are Sobol points of independent numbers."""
        written = Results(self.dataset).scene.get("uncertain", {})
        is_own = not written.get("points") and not written.get("correlations")
        return is_own and written.get("method", SOBOL) == SOBOL

    def motions(self, index: int) -> Motions:
        """The motions of an interface in the first sample: their names, recordings and amplitudes.

        Where motions are drawn with the samples, that of each sample.
        """
        if not self.is_drawn:
            return motions_of(self.first_sample.interfaces[index][1])
        records, polarities = (tuple(map(str, self.dataset[name].values)) for name in ("record", "polarity"))
        closing = _by_sample(self.dataset["peak_closing_free"].isel(interface=index, missing_dims="ignore"), 0)
        amplitudes = self.first_sample.amplitudes.values
        finite = np.isfinite(closing) & self._shaking[:, None]
        return Motions(records, polarities, Results(self.dataset).recordings, amplitudes, closing, finite)

    @property
    def _shaking(self) -> NDArray[np.bool_]:
        """Whether the record holds a motion: of each motion of a sample, or of each sample where they are drawn."""
        if self.is_drawn:
            return np.asarray(self.dataset["record_pga"].values >= LEAST_SHAKING)
        return np.repeat(self.first_sample.is_shaking, self.first_sample.dataset.sizes["polarity"])

    def by_outcome(self, table: Array, closings: CrossedClosings) -> Array:
        """Values of the motions of `first_sample` in the order of the closings: (1, motions), or (samples, 1)."""
        if not self.is_drawn:
            return table[None, closings.order]
        first_dataset = self.first_sample.dataset
        places = {name: place for place, name in enumerate(first_dataset["record"].values.tolist())}
        polarity_count = first_dataset.sizes["polarity"]
        return np.array([[table[polarity_count * places[name]]] for name in self.dataset["record"].values.tolist()])

    def level(self, requested: int | None) -> int:
        """Index of the assessed amplitude."""
        return self.first_sample.scene_level if requested is None else requested

    def motions_words(self, level: int | None) -> str:
        """How many motions of how many recordings at which amplitude, in words."""
        motions = self.motions(0)
        count = len(set(zip(motions.records, motions.polarities, strict=True)))
        motions_text = f"{counted(count, 'motion')} of {counted(int(motions.recordings.max()) + 1, 'recording')}"
        motions_text = f"one of {motions_text} drawn with each," if self.is_drawn else motions_text
        return f"{motions_text} {self.first_sample.amplitude_words(motions.amplitudes[self.level(level)])}"

    def gap(self, index: int) -> float:
        """The scene's own gap at an interface [m]."""
        return Results(self.dataset).scene_gap(index)

    def closings(self, index: int, level: int | None) -> CrossedClosings:
        """What every motion closes in every sample."""
        closing, motions = self.closing_of(self.dataset, index, level), self.motions(index)
        if not self.is_drawn:
            return CrossedClosings(closing, motions.recordings)
        return DrawnClosings(closing[:, 0], _motion_numbers(motions), motions.recordings)

    def closing_of(self, dataset: xr.Dataset, index: int, level: int | None) -> Array:
        """Closings (samples, motions) [m], less the excess of a sample's gap over the scene's.

        The dataset may be of other points; inf where no closing is finite.
        """
        reach, gaps = self.reach_of(dataset, index, level), self.gaps_of(dataset, index, self.gap(index))
        return reach if gaps is None else np.maximum(reach - (gaps - self.gap(index))[:, None], 0.0)

    def gaps_of(self, dataset: xr.Dataset, index: int, gap: float) -> Array | None:
        """The gap of each sample [m], were the scene's own ``gap``; None where gaps are not uncertain."""
        interface = dataset.isel(interface=index, missing_dims="ignore")
        for name in ("sample_gap", "interface_gap"):
            if name in interface.variables and SAMPLE in interface[name].dims:
                gaps = interface[name].transpose(SAMPLE, ...).values
                return np.asarray(gaps.reshape(len(gaps), -1)[:, 0], dtype=float) - self.gap(index) + gap
        return None

    def gap_deviation(self, index: int) -> float:
        """Standard deviation over the samples of the gap [m]; 0 where it is known."""
        gaps = self.gaps_of(self.dataset, index, self.gap(index))
        return 0.0 if gaps is None else float(np.std(gaps))

    def gap_offset(self, index: int) -> float:
        """Mean of the gaps of the samples less the scene's own [m], where chance does not explain it; else 0."""
        gaps = self.gaps_of(self.dataset, index, 0.0)
        if gaps is None:
            return 0.0
        mean, by_chance = float(np.mean(gaps)), 3.0 * float(np.std(gaps)) / np.sqrt(gaps.size)
        return mean if abs(mean) > max(by_chance, 1e-6) else 0.0

    def reach_of(self, dataset: xr.Dataset, index: int, level: int | None) -> Array:
        """What motions close (samples, motions) [m], whatever the gap; inf where there is no finite closing."""
        interface = dataset.isel(interface=index, missing_dims="ignore")
        free_closing = interface["peak_closing_free"]
        if SAMPLE not in free_closing.dims:  # without contact it is one for all where gaps alone are uncertain
            free_closing = free_closing.expand_dims({SAMPLE: interface.sizes[SAMPLE]})
        closing = _by_sample(free_closing, self.level(level))
        finite = np.isfinite(closing) & (self._shaking[:, None] if self.is_drawn else self._shaking)
        if "peak_displacement_free" in dataset:
            # As `demands.motions_of`: the closing of a motion in which a storey collapses is that up to there.
            peaks = dataset["peak_displacement_free"].isel(building=[index, index + 1])
            finite &= np.isfinite(_by_sample(peaks.max("building", skipna=False), self.level(level)))
        free_reach = np.where(finite, closing, np.inf)
        if "impact_count" not in dataset or not self.is_inner(index):
            return free_reach
        gaps = interface["interface_gap"] if "interface_gap" in interface.variables else interface["gap"]
        pushed = pushed_closing(interface, gaps, (SAMPLE, "record", "polarity", amplitude_axis(interface)))
        case = interface.isel(Results(dataset).scene_contact)
        # As `demands.run_failed`: what neighbours push is not known.
        failed = (
            (case["impact_count"] == UNDEFINED) & (case["status"] != UNPUSHED) & (case["peak_closing_free"] <= gaps)
        )
        reach = np.fmax(free_reach, _by_sample(pushed, self.level(level)))
        return np.where(_by_sample(failed.astype(float), self.level(level)) > 0.0, np.inf, reach)

    def may_be_pushed(self, index: int, gap: float) -> bool:
        """True in a row that was not run at so wide a gap [m], across which neighbours may push the two together."""
        is_run = "impact_count" in self.dataset and gap <= self.gap(index) + SAME_GAP
        return self.dataset.sizes.get("interface", 1) > 1 and not is_run

    def is_inner(self, index: int) -> bool:
        """True where what stands further along the row may push a building of the interface."""
        return "interior" in self.first_sample.dataset["building_position"].values[index : index + 2]

    def outputs(self, index: int, closings: CrossedClosings, gap: float, request: Request) -> dict[str, Output]:
        """The outputs of each sample by name: those of the closing, and another of the dataset that is requested."""
        design = None if self.design_dataset is None else self.closing_of(self.design_dataset, index, request.level)
        args = gap, request.criterion.percentile
        outputs = {}
        for name, kind in KINDS_OF_OUTPUT[self.is_drawn].items():
            by_sample, designed = (None if one is None else kind.of(one, *args) for one in (closings.closing, design))
            outputs[name] = Output(np.asarray(by_sample), kind.unit, kind.words, designed)
        if request.output is not None and request.output not in outputs:
            outputs[request.output] = self._other_output(index, request.output, request.level)
        return outputs

    def _other_output(self, index: int, name: str, level: int | None) -> Output:
        """An output of the dataset at the scene's own case in each sample: the median over the motions."""
        axes = {SAMPLE} if self.is_drawn else {SAMPLE, "record", "polarity"}
        names = [
            str(key)
            for key, variable in self.dataset.data_vars.items()
            if key != "record_spectral_acceleration" and axes <= set(variable.dims) and variable.dtype.kind in "fiu"
        ]
        if name not in names:
            known_names = [*KINDS_OF_OUTPUT[self.is_drawn], *names]
            reason = "" if "impact_count" in self.dataset else "; others need runs of contact: name a dataset of a scan"
            if self.is_drawn and name in KINDS_OF_OUTPUT[False]:
                reason = f"; it is over all motions in each sample, and these have one each: {ALL_MOTIONS}"
            raise PoundingError(f"output: {unknown(name, 'none', known_names)}{reason}")
        case = self.first_sample.scene_case | {"interface": index, "building": slice(index, index + 2)}
        case[amplitude_axis(self.dataset)] = self.level(level)
        variable = self.dataset[name]
        outcomes = _by_sample(variable.isel({axis: at for axis, at in case.items() if axis in variable.dims}), 0)
        is_known = np.isfinite(outcomes)
        with np.errstate(invalid="ignore"):
            medians = np.nanmedian(np.where(is_known, outcomes, np.nan), axis=1)
        if not np.isfinite(medians).all():
            raise PoundingError(f"output: {name} has no number in some sample at the scene's own case; choose another")
        filled = np.where(is_known, outcomes, medians[:, None])
        lost_count = int(outcomes.size - is_known.sum())
        is_positive = bool((filled > 0.0).all())
        analysed_values = np.log(filled) if is_positive else filled
        unit, words = str(variable.attrs.get("units", "1")), str(variable.attrs.get("long_name", name))
        motions = self.motions(index)
        recordings = numbered(motions.recordings)
        if self.is_drawn:
            words = f"{words}, under the sample's motion"
            analysis = analysed_clusters(analysed_values[:, 0], _motion_numbers(motions), recordings)
        else:
            words = f"median over the motions of {words}"
            words += f", without the {lost_count} of {outcomes.size} outcomes that have no number" if lost_count else ""
            order = np.argsort(recordings, kind="stable")
            analysis = analysed(analysed_values[:, order], recordings[order])
        return Output(medians, unit, words, None, analysis, "1" if is_positive else unit)

    def moved(self, index: int, gap: float, request: Request) -> dict[str, Any]:
        """Each output with all numbers at their medians, and with each alone at its 10 % and 90 % quantiles."""
        if self.moved_dataset is None:
            return {}
        closing = self.closing_of(self.moved_dataset, index, request.level)
        variables: dict[str, Any] = {}
        for name, kind in KINDS_OF_OUTPUT[False].items():
            moved_outputs = kind.of(closing, gap, request.criterion.percentile)
            ends = moved_outputs[1:].reshape(-1, 2)
            columns = np.column_stack([ends[:, 0], np.full(len(ends), moved_outputs[0]), ends[:, 1]])
            words = f"{kind.words}, the number at a quantile and all others at their medians"
            variables[f"{name}_moved"] = (("uncertain_number", "quantile"), columns, described(kind.unit, words))
        attributes = described("m", "what each motion closes with all numbers at their medians, rising")
        return variables | {"closing_at_medians": ("motion", np.sort(closing[0]), attributes)}


def _by_sample(output: xr.DataArray, level: int) -> Array:
    """Values at one amplitude as (samples, motions), (samples, 1), or one row for all; the largest over other axes."""
    output = output if SAMPLE in output.dims else output.expand_dims(SAMPLE)
    output = output.isel({axis: level for axis in (PGA_AXIS, LEVEL_AXIS) if axis in output.dims})
    axes = [axis for axis in (SAMPLE, "record", "polarity") if axis in output.dims]
    other_axes = [axis for axis in output.dims if axis not in axes]
    table = (output.max(other_axes) if other_axes else output).transpose(*axes).values
    return np.asarray(table.reshape(len(table), -1), dtype=float)


def _motion_numbers(motions: Motions) -> NDArray[np.int64]:
    """Numbers from 0, equal for samples of one record and polarity."""
    return labels(list(zip(motions.records, motions.polarities, strict=True)))


def named_output(outputs: Mapping[str, Output], requested: str | None) -> str:
    """The output that sentences are of: that requested, P(contact), or the required gap where P(contact) is constant.

    Where motions are drawn with the samples: contact, or the logarithm of the closing.
    """
    if requested is not None:
        return requested
    first, second, *_ = outputs
    return first if np.ptp(outputs[first].values) > 0.0 else second


# ------------------------------------------------------------------------------------------------------------ sources


def opened_samples(source: Any) -> Samples | Scene:
    """The samples of a dataset or its file, or the scene of anything else; raises PoundingError without samples."""
    is_file = isinstance(source, str | Path) and str(source).lower().endswith((".nc", STORE))
    if is_file or hasattr(source, "data_vars"):
        return _from_dataset(open_results(source) if is_file else source, str(source) if is_file else "the dataset")
    from pounding_risk.scene.reader import as_scene

    scene = as_scene(source)
    if scene.uncertain is None:
        raise PoundingError(
            f"{scene.source}: nothing in it is uncertain: it has no table [uncertain], or one whose numbers all have "
            'stated values, as by samples = 0; write one, such as "building.frame.period" = {distribution = '
            '"lognormal", dispersion = 0.2}, or use assess'
        )
    return scene


def _from_dataset(dataset: xr.Dataset, source: str) -> Samples:
    axis = next((axis for axis in axes_of(dataset) if axis.name == SAMPLE), None)
    if axis is None or dataset.sizes.get(SAMPLE, 1) < LEAST_SAMPLES:
        raise PoundingError(
            f"{source}: has no samples of uncertain numbers; scan a scene with a table [uncertain], or use assess"
        )
    check_one_place(dataset.isel({SAMPLE: [0]}), source)
    check_scan(dataset, source)
    open_scan(dataset.isel({SAMPLE: [0]}), source)
    written = Results(dataset).scene.get("uncertain", {})
    correlated = [" and ".join(pair["between"]) for pair in written.get("correlations", [])]
    assumptions = [
        "The samples are counted as if they were drawn independently; those of a Latin hypercube or Sobol points are "
        "spread more evenly, so that bounds are wider than need be.",
        f"Every number but {', '.join(axis.keys)} is taken as known exactly.",
        *([ONE_MOTION] if has_drawn_motions(dataset) else []),
        *([AS_RUN] if "impact_count" in dataset and "interior" in dataset["building_position"].values else []),
        *json.loads(dataset.attrs.get("notes", "[]")),
        *([f"{'; '.join(correlated)} {CORRELATED}"] if correlated else []),
    ]
    key_values = tuple(np.asarray(dataset[key].values) for key in axis.keys)
    words = f"{dataset.sizes[SAMPLE]} samples of {counted(len(axis.keys), 'number')}"
    return Samples(dataset, axis.keys, key_values, str(dataset.attrs.get("title", "")), words, tuple(assumptions))


def sampled_scene(
    scene: Scene, samples: int | None, num: int, workers: int | None, progress: Progress | None
) -> Samples:
    """The samples of a scene with their motion without contact, and the points of a tornado and of Sobol indices."""
    from pounding_risk.studies.uncertainty import free_motion

    uncertain = scene.uncertain
    assert uncertain is not None, "checked when the scene was opened"
    count = uncertain.samples if samples is None else samples
    if isinstance(count, bool) or not isinstance(count, int) or not LEAST_SAMPLES <= count <= MOST_SAMPLES:
        raise PoundingError(
            f"samples: {shown(count)} is no whole number from {LEAST_SAMPLES} to {MOST_SAMPLES}; one sample does not "
            "show what the numbers mean"
        )
    if samples is not None:
        if uncertain.given:
            raise PoundingError("samples: the scene gives its points, one a sample; leave samples out, or the points")
        uncertain = replace(uncertain, samples=samples)
    numbers, is_drawn = len(uncertain.keys), uncertain.is_drawn
    points = [np.asarray(uncertain.points())]
    if not is_drawn:  # a tornado and a design of their own are over all motions in each point
        points.append(independent_points(tornado_points(numbers), uncertain))
    if num:
        _check_sobol(num, uncertain)
        points.append(saltelli_points(points_of(SOBOL, power_of_two(max(num, 8)), 2 * numbers, uncertain.seed)))
    dataset = free_motion(scene, np.concatenate(points), workers=workers, progress=progress)
    ends = np.cumsum([0, *map(len, points)]).tolist()
    datasets = [dataset.isel({SAMPLE: slice(low, high)}) for low, high in pairwise(ends)]
    key_values = tuple(np.asarray(datasets[0][key].values) for key in uncertain.keys)
    words = "; ".join(f"{name}: {words}" for name, words in uncertain.described()).removeprefix("samples: ")
    title, assumptions = str(dataset.attrs.get("title", "")), tuple(_assumptions_of_scene(uncertain, dataset))
    extra_datasets = None if is_drawn else datasets[1], datasets[2] if num else None
    return Samples(datasets[0], tuple(uncertain.keys), key_values, title, words, assumptions, *extra_datasets)


def _check_sobol(num: int, uncertain: Any) -> None:
    """Raise PoundingError where Sobol indices on a design of their own cannot be had."""
    if uncertain.is_drawn:
        raise PoundingError(
            f"sobol: motions are drawn with the samples, and Sobol indices are over all of them; {ALL_MOTIONS}. "
            "First-order indices follow from the samples without it"
        )
    if uncertain.correlations:
        between = " and ".join(uncertain.correlations[0].between)
        raise PoundingError(
            f"sobol: {between} are correlated, and Sobol indices are of independent numbers; leave sobol out for "
            "first-order indices from the samples, which share what the numbers have in common"
        )
    if num > MOST_SOBOL:
        raise PoundingError(f"sobol: {num} is more than {MOST_SOBOL}; write a power of two such as 1024")


def independent_points(points: Array, uncertain: Any) -> Array:
    """Points whose correlated numbers stand at the quantiles that the given points have in each column."""
    if not uncertain.correlations:
        return points
    from scipy.special import ndtr, ndtri

    factor = np.linalg.cholesky(np.array(uncertain.matrix))
    return np.asarray(ndtr(np.linalg.solve(factor, ndtri(points).T).T))


def _assumptions_of_scene(uncertain: Any, free: xr.Dataset) -> Iterator[str]:
    """What is assumed and left out where a scene is run without contact."""
    yield (
        "No run of contact: whether a motion closes a gap follows from the motion without contact, whatever the "
        "contact model or F_E."
    )
    yield "Every number that [uncertain] does not name is taken as known exactly."
    if uncertain.method != "random":
        yield (
            f"The samples are points of a design ({uncertain.method}), counted as if they were drawn independently: "
            "they are spread more evenly, so that bounds are wider than need be."
        )
    if uncertain.is_drawn:
        yield ONE_MOTION
    yield from uncertain.notes()
    if uncertain.correlations:
        pairs = "; ".join(" and ".join(correlation.between) for correlation in uncertain.correlations)
        yield f"{pairs} {CORRELATED}"
    yield from json.loads(free.attrs.get("notes", "[]"))
