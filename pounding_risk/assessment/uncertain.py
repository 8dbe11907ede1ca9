"""What uncertain numbers of a scene mean: contact, required gaps and fragilities over samples of them and motions.

From the motion without contact of every sample, which a scene is run for, or from a dataset of `scan` with samples.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.dates import created
from pounding_risk._common.order import enough_for
from pounding_risk._common.progress import Progress
from pounding_risk.assessment import uncertain_words as words
from pounding_risk.assessment.demands import record_doubts
from pounding_risk.assessment.options import USUAL_CONFIDENCE, USUAL_PERCENTILE, Criterion, read_criterion
from pounding_risk.assessment.uncertain_fragility import CURVES, Capacities
from pounding_risk.assessment.uncertain_samples import (
    Asked,
    Samples,
    named_output,
    opened_samples,
    sampled_scene,
)
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import read_measure
from pounding_risk.results.amplitudes import level_asked
from pounding_risk.results.layout import SCENE_AXES
from pounding_risk.results.scene_axes import VARIANTS
from pounding_risk.results.variables import described
from pounding_risk.statistics.crossed import Analysis, Components
from pounding_risk.statistics.crossed_contact import CrossedClosings
from pounding_risk.statistics.drawn_closings import DrawnClosings, analysed_clusters, motion_share
from pounding_risk.statistics.sobol import Indices, given_indices, sobol_indices
from pounding_risk.units import GAP, si

if TYPE_CHECKING:
    import xarray as xr

    from pounding_risk.scene.scene import Scene

Array = NDArray[np.float64]

PARTS = ("parameters", "motions", "interaction", "total")
PARTS_DRAWN = ("parameters and interaction", "motions", "total")  # where motions are drawn with the samples
OVER_SAMPLES = (5.0, 16.0, 50.0, 84.0, 95.0)  # percentiles over the samples
GAPS = 81  # at which P(contact) is given
GAPS_WORDS = (
    "even steps from 0 to what 99.5 % of all outcomes need or 1.2 times the judged gap, the scene's own gaps and the "
    "judged one"
)
USUAL_SOBOL = 256


def uncertainty(
    source: Scene | Mapping[str, Any] | xr.Dataset | str | Path,
    out: str | Path | None = None,
    *,
    gap: float | str | None = None,
    target: float | str | None = None,
    percentile: float | str | None = None,
    confidence: float | str = USUAL_CONFIDENCE,
    pga: float | str | None = None,
    intensity_level: float | str | None = None,
    intensity: str | None = None,
    output: str | None = None,
    samples: int | None = None,
    sobol: bool | int = False,
    workers: int | None = None,
    new: bool = False,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Assess what the uncertain numbers of a scene mean, beside what the motions do.

    Parameters
    ----------
    source : Scene, dict, Dataset or path
        A scene with a table ``[uncertain]``, or its file: the motion without contact is computed in every sample, and
        no run of contact. Or a dataset of `scan` with samples, or its file.
    out : path, optional
        File for the dataset, ``.nc``.
    gap : float or str, optional
        The gap to assess [m, or text with a unit], at every interface; the scene's own by default. Where gaps are
        themselves uncertain it is the nominal gap: each sample's departs from it as from the scene's own.
    target : float or str, optional
        Accepted probability of contact; what the percentile leaves by default. As of `assess`.
    percentile : float or str, optional
        Share of samples and motions whose required gap is given, beside 50, 84 and 95 %. As of `assess`.
    confidence : float or str
        Confidence of all bounds, above 50 %.
    pga : float or str, optional
        Amplitude of the grid to assess [m/s2, or text with a unit]; as of `assess`.
    intensity_level : float or str, optional
        Level of intensity to assess, of a scene or dataset with such levels; as of `assess`.
    intensity : str, optional
        Of the fragilities: "pga", or "sa(0.5 s)" at any period, 5 % damped; by default what the motions are scaled to,
        or PGA. A building's own period may differ between samples, so it is none of these.
    output : str, optional
        What the indices and the sentence on what narrows the answer are of: "contact_probability", "required_gap" or
        "log_median_closing"; of a dataset also any of its outputs, such as "peak_contact_force", the median over the
        motions at the scene's own case. P(contact) by default, or the required gap where P(contact) does not vary.
        Where motions are drawn with the samples: "contact", the default, "log_closing", or an output of a dataset, each
        under the sample's own motion.
    samples : int, optional
        How many samples of a scene, in place of its own number.
    sobol : bool or int
        Compute Sobol indices, first and total, of a scene on a design of their own: so many points, 256 by default,
        times the count of numbers and two. First-order indices are estimated from the samples too, from 128 on, and
        those with the narrower bounds are given; ``first_order_of_design`` says which.
    workers : int, optional
        Threads; one a processor by default. Results do not depend on it.
    new : bool
        Replace other results under the name ``out``.
    progress : callable, optional
        Called with how much is done and the whole.

    Returns
    -------
    xarray.Dataset
        Along ``interface``: P(contact) over ``gap`` with bounds, and its percentiles over the samples; required gaps;
        the deviations of ln closing that parameters, motions and their interaction have; fragilities; indices of each
        ``uncertain_number``, and for a scene each output at its 10 % and 90 % quantiles. ``verdict``, ``sentence`` and
        ``narrowing`` are words, the attribute ``assumptions`` says what is assumed and left out. Where motions are
        drawn with the samples there is no P(contact) of a sample, and the share of the motions stands beside the
        indices.

    Raises
    ------
    PoundingError
        For a scene or a dataset without samples, for Sobol indices of correlated numbers, of drawn motions or of a
        dataset, for options out of their range, and for an ``out`` that cannot be written or holds other results.
    SceneError
        For a scene with faults.
    RecordError
        For a record that cannot be used.
    """
    from pounding_risk.results.files import save
    from pounding_risk.studies.out_file import check_out

    file = check_out(out, "uncertainty", new)
    asked = Asked(
        None if gap is None else si(gap, GAP._replace(open_high=True), "gap"),
        read_criterion(target, percentile, confidence),
        None,
        intensity,
        output,
    )
    num = (USUAL_SOBOL if sobol is True else int(sobol)) if sobol else 0
    subject = opened_samples(source)
    if isinstance(subject, Samples):
        if num or samples is not None:
            what = "sobol" if num else "samples"
            raise PoundingError(
                f"{what}: of a scene alone, whose motion without contact is computed for it; a dataset has the samples "
                "that it has. Name the scene"
            )
    else:
        subject = sampled_scene(subject, samples, num, workers, progress)
    dataset = assessed(subject, asked._replace(level=level_asked(subject.first_sample, pga, intensity_level)))
    if file is not None:
        save(dataset, file)
    return dataset


@np.errstate(invalid="ignore")  # differences of infinities, where a motion has no finite closing
def assessed(subject: Samples, asked: Asked) -> xr.Dataset:
    """The dataset of `uncertainty` from samples."""
    import xarray as xr

    closings = [subject.closings(index, asked.level) for index in range(len(subject.interfaces))]
    judged = [subject.gap(index) if asked.gap is None else asked.gap for index in range(len(closings))]
    largest = max(float(np.percentile(one.rising, 99.5)) for one in closings)
    most = max(largest, 1.2 * max(judged), 1e-6)
    finite = most if np.isfinite(most) else max(float(one.logs.max()) for one in closings)
    # The scene's own gap stands among them, whatever gap is judged.
    own = [subject.gap(index) for index in range(len(closings))]
    gaps = np.unique([*np.linspace(0.0, finite, GAPS), *judged, *own])
    parts = [
        _interface(subject, index, one, gap, gaps, asked)
        for index, (one, gap) in enumerate(zip(closings, judged, strict=True))
    ]
    names = xr.Variable("interface", list(subject.interfaces), {"long_name": "buildings on both sides of a gap"})
    dataset = xr.concat(parts, dim=names, combine_attrs="override")
    dataset = dataset.assign_coords(
        {
            f"value_of_{key}": ("sample", values, subject.attrs_of(key))
            for key, values in zip(subject.keys, subject.values, strict=True)
        }
    )
    few = words.of_few(closings[0], asked.criterion)
    assumptions = [*subject.assumptions, *few, *record_doubts(subject.first_sample)]
    about = {
        "title": subject.title,
        "asked": f"{asked.criterion.words}{_usual_target(asked.criterion)}",
        "samples": subject.words,
        "motions": subject.motions_words(asked.level),
        "assumptions": json.dumps(assumptions, ensure_ascii=False),
        **asked.criterion._asdict(),
        **created("pounding_risk.uncertainty"),
    }
    of_run = {name: value for name, value in subject.dataset.attrs.items() if name not in (SCENE_AXES, VARIANTS)}
    return dataset.assign_attrs(of_run | about)


def _usual_target(criterion: Criterion) -> str:
    """Whence the usual target is, where it is that."""
    if not criterion.agrees or criterion.percentile != USUAL_PERCENTILE:
        return ""
    return " The default target is what the 84th percentile, the median plus one standard deviation, leaves of 100 %."


def _interface(
    subject: Samples, index: int, closings: CrossedClosings, gap: float, gaps: Array, asked: Asked
) -> xr.Dataset:
    """The part of the dataset of one interface."""
    import xarray as xr

    criterion = asked.criterion
    outputs = subject.outputs(index, closings, gap, asked)
    chosen = named_output(outputs, asked.output)
    parts: dict[str, Any] = {
        **_contact(closings, gap, gaps, criterion),
        **_required(closings, criterion),
        **_of_samples(closings, gap, criterion),
        **_variances(
            outputs[chosen].analysis or closings.analysis,
            outputs[chosen].analysis_unit,
            criterion.confidence,
            _parts_of(closings),
        ),
        **_fragilities(Capacities.of(subject, index, closings, gap, asked), criterion.confidence),
    }
    indices = _indices(subject, outputs, criterion.confidence)
    parts |= indices | subject.moved(index, gap, asked)
    about = described("m", "standard deviation of the gap over the samples; 0 where it is known")
    parts["scene_gap"] = ((), subject.gap(index), described("m", "gap of the scene"))
    parts["gap_deviation"] = ((), subject.gap_deviation(index), about)
    if closings.is_drawn:
        parts |= _share_of_motions(outputs, closings, criterion.confidence)
    dataset = xr.Dataset(
        parts,
        {
            "gap": ("gap", gaps, described("m", "gap") | {"description": GAPS_WORDS}),
            "component": ("component", list(_parts_of(closings)), {"long_name": "part of the variance"}),
            "percentile": ("percentile", list(_percentiles(criterion)), described("1", "percentile [%]")),
            "sample_percentile": ("sample_percentile", list(OVER_SAMPLES), described("1", "percentile of samples [%]")),
            "uncertain_number": ("uncertain_number", list(subject.keys), {"long_name": "address in the scene"}),
            "output": ("output", list(outputs), {"long_name": "output of a sample"}),
            "output_unit": ("output", [one.unit for one in outputs.values()], {"long_name": "unit of the output"}),
            "output_words": ("output", [one.words for one in outputs.values()], {"long_name": "what the output is"}),
            "curve": ("curve", list(CURVES), {"long_name": "dispersion of the fragility"}),
            **subject.nominal_coordinates(),
        },
    )
    verdict = words.verdict_of(closings, subject, index, gap, asked.level, criterion)
    dataset["verdict"] = ((), verdict.word, {"long_name": "verdict on the gap"})
    dataset["sentence"] = ((), verdict.sentence, {"long_name": "verdict in words"})
    dataset["chosen_output"] = ((), chosen, {"long_name": "output that the sentences are of"})
    narrowing = words.narrowing(dataset, closings, gap, criterion)
    dataset["narrowing"] = ((), " ".join(narrowing), {"long_name": "what would narrow the answer"})
    return dataset


def _contact(closings: CrossedClosings, gap: float, gaps: Array, criterion: Criterion) -> dict[str, Any]:
    """P(contact) over the gaps and at the judged one."""
    over, here = closings.contact(gaps, criterion.confidence), closings.contact(gap, criterion.confidence)
    contact = "P(contact) over samples and motions"
    return {
        **({} if closings.is_drawn else _contact_of_samples(closings, gaps)),
        "contact_probability": ("gap", over.value, described("1", contact)),
        "contact_probability_low": ("gap", over.low, described("1", f"lower bound of {contact}")),
        "contact_probability_high": ("gap", over.high, described("1", f"upper bound of {contact}")),
        "judged_gap": ((), gap, described("m", "gap that is judged")),
        "judged_probability": ((), here.value[0], described("1", f"{contact} at the judged gap")),
        "judged_probability_low": ((), here.low[0], described("1", "its lower bound")),
        "judged_probability_high": ((), here.high[0], described("1", "its upper bound")),
        "independent": ((), here.independent[0], described("1", "independent outcomes that these bounds are for")),
        "independent_motions": ((), closings.counted.motions, described("1", "independent motions")),
    }


def _contact_of_samples(closings: CrossedClosings, gaps: Array) -> dict[str, Any]:
    """Percentiles over the samples of P(contact) over the motions, over the gaps."""
    of_samples = np.stack([np.percentile(closings.of_samples(one), OVER_SAMPLES) for one in gaps.tolist()])
    about = described("1", "percentiles over the samples of P(contact) over the motions")
    return {"contact_probability_of_samples": (("gap", "sample_percentile"), of_samples, about)}


def _percentiles(criterion: Criterion) -> tuple[float, ...]:
    from pounding_risk.statistics.required_gap import USUAL_PERCENTILES

    return tuple(sorted({*USUAL_PERCENTILES, criterion.percentile, criterion.target_percentile}))


def _required(closings: CrossedClosings, criterion: Criterion) -> dict[str, Any]:
    """Required gaps at the percentiles, over samples and motions, and over the samples."""
    percentiles = _percentiles(criterion)
    required = closings.required(percentiles, criterion.confidence)
    gap = "gap that a percentile of samples and motions together needs"
    return {
        **({} if closings.is_drawn else _required_of_samples(closings, percentiles)),
        "required_gap": ("percentile", [one.gap for one in required], described("m", gap)),
        "required_gap_low": ("percentile", [one.low for one in required], described("m", f"lower bound of the {gap}")),
        "required_gap_high": (
            "percentile",
            [one.high for one in required],
            described("m", f"upper bound of the {gap}; the largest seen where it is not bounded"),
        ),
        "required_gap_bounded": (
            "percentile",
            np.array([one.bounded for one in required], dtype=np.int8),
            described("1", "1 where the upper bound is one"),
        ),
    }


def _required_of_samples(closings: CrossedClosings, percentiles: tuple[float, ...]) -> dict[str, Any]:
    """Percentiles over the samples of the gaps that percentiles of the motions need."""
    over_samples = np.percentile(enough_for(closings.closing, percentiles, axis=1), OVER_SAMPLES, axis=1).T
    about = described("m", "percentiles over the samples of the gap that a percentile of the motions needs")
    return {"required_gap_of_samples": (("percentile", "sample_percentile"), over_samples, about)}


def _of_samples(closings: CrossedClosings, gap: float, criterion: Criterion) -> dict[str, Any]:
    """P(contact) in each sample, and the share of samples in which it exceeds the target; what drawn motions close."""
    from pounding_risk.statistics.proportions import exact_bounds

    if closings.is_drawn:
        about = described("m", "what the sample's motion closes without contact, which its gap is to be wider than")
        return {"closing_of_sample": ("sample", closings.closing[:, 0], about)}
    share = closings.of_samples(gap)
    count, runs = int((share > criterion.target).sum()), share.size
    low, high = exact_bounds(count, runs, criterion.confidence)
    over = "share of the samples in which P(contact) under these motions exceeds the target"
    return {
        "contact_probability_of_sample": ("sample", share, described("1", "P(contact) over the motions at the gap")),
        "samples_over_target": ((), count / runs, described("1", over)),
        "samples_over_target_low": ((), float(low), described("1", "its lower bound, for these motions")),
        "samples_over_target_high": ((), float(high), described("1", "its upper bound, for these motions")),
    }


def _parts_of(closings: CrossedClosings) -> tuple[str, ...]:
    return PARTS_DRAWN if closings.is_drawn else PARTS


def _variances(analysis: Analysis, unit: str, confidence: float, parts: tuple[str, ...]) -> dict[str, Any]:
    """Standard deviations by what they come from, with bounds, and each as a share of the variance."""
    of: dict[str, Callable[[Components], Any]] = {
        "parameters": lambda components: components.samples,
        "parameters and interaction": lambda components: components.samples,
        "motions": lambda components: components.motions,
        "interaction": lambda components: components.interaction,
        "total": lambda components: components.total,
    }
    bounds = np.sqrt([analysis.variance_bounds(of[name], confidence) for name in parts])
    shares = _shares([of[name](analysis.all) for name in parts[:-1]])
    whose = "of the logarithm of what is closed" if unit == "1" else "of the output"
    deviation = f"standard deviation {whose} by what it comes from"
    return {
        "dispersion": ("component", bounds[:, 0], described(unit, deviation)),
        "dispersion_low": ("component", bounds[:, 1], described(unit, f"lower bound of the {deviation}")),
        "dispersion_high": ("component", bounds[:, 2], described(unit, f"upper bound of the {deviation}")),
        "variance_share": ("component", shares, described("1", "share of the variance, of what is above 0")),
    }


def _shares(components: Sequence[float]) -> Array:
    parts = np.maximum(components, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.append(parts / parts.sum(), 1.0)


def _fragilities(capacities: Capacities, confidence: float) -> dict[str, Any]:
    """Median and dispersion of the fragilities of motions alone and in all, with bounds; NaN with a fault."""
    fitted = capacities.fitted(confidence)
    measure = read_measure(capacities.intensity)
    unit = "m/s2" if measure is None else measure.unit
    words = {"fragility_median": (unit, "median"), "fragility_dispersion": ("1", "dispersion")}
    parts: dict[str, Any] = {}
    for name, (unit, what) in words.items():
        for column, ending in enumerate(("", "_low", "_high")):
            about = described(unit, f"{('', 'lower bound of the ', 'upper bound of the ')[column]}{what} of contact")
            parts[f"{name}{ending}"] = ("curve", fitted[name][:, column], about)
    parts["fragility_intensity"] = ((), capacities.intensity, {"long_name": "intensity of the fragilities"})
    parts["fragility_fault"] = ((), capacities.fault, {"long_name": "why there are no fragilities"})
    return parts


def _share_of_motions(outputs: Mapping[str, Any], closings: CrossedClosings, confidence: float) -> dict[str, Any]:
    """The share that the motions have in the variance of each output, as first-order indices of a number have one."""
    assert isinstance(closings, DrawnClosings), "asked of drawn motions alone"
    labels = closings.of_motions, closings.recordings
    values = [motion_share(analysed_clusters(one.values, *labels), confidence) for one in outputs.values()]
    known = "share of the variance over the samples that would go were the motion known exactly"
    ends = {"": "", "_low": "lower bound of the ", "_high": "upper bound of the "}
    return {
        f"first_order_of_motions{end}": ("output", [value[at] for value in values], described("1", f"{words_}{known}"))
        for at, (end, words_) in enumerate(ends.items())
    }


def _indices(subject: Samples, outputs: Mapping[str, Any], confidence: float) -> dict[str, Any]:
    """Indices of each output and number: of first order those of the samples or of a design, by the width of bounds."""
    dims = ("output", "uncertain_number")
    parts: dict[str, Any] = {
        "output_deviation": (
            "output",
            [float(np.std(one.values)) for one in outputs.values()],
            described("1", "standard deviation over the samples, in the unit of the output"),
        ),
    }

    def add(name: str, indices: Indices, what: str) -> None:
        for ending, values in zip(("", "_low", "_high"), indices, strict=True):
            bound = {"": "", "_low": "lower bound of the ", "_high": "upper bound of the "}[ending]
            parts[f"{name}{ending}"] = (dims, values, described("1", f"{bound}{what}"))

    stacked = np.stack([one.values for one in outputs.values()])
    first = given_indices(subject.values, stacked, confidence, subject.is_balanced)
    from_design = np.zeros(len(outputs), dtype=bool)
    if subject.has_design:
        designed = np.stack([one.design for one in outputs.values()])
        of_design, total = sobol_indices(designed, len(subject.keys), confidence)
        add("total_order", total, "share of the variance that would remain were all other numbers known exactly")
        from_design = ~(first.width <= of_design.width)  # where those of the samples are NaN too
        first = Indices(*(np.where(from_design[:, None], *both) for both in zip(of_design, first, strict=True)))
        parts["sobol_points"] = ((), subject.sobol_points, described("1", "points N of the Sobol design"))
    about = described("1", "1 where first-order shares are those of the Sobol design, 0 where those of the samples")
    parts["first_order_of_design"] = ("output", from_design.astype(np.int8), about)
    add("first_order", first, "share of the variance over samples that would go were the number known exactly")
    return parts
