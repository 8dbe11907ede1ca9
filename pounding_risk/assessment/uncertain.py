"""What uncertain numbers of a scene mean: contact, required gaps and fragilities over samples of them and motions.

From the motion without contact of every sample, which a scene is run for, or from a dataset of `scan` with samples.
"""

from __future__ import annotations

from collections.abc import Mapping
from operator import attrgetter
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.dates import created
from pounding_risk._common.order import enough_for
from pounding_risk.assessment import uncertain_words as words
from pounding_risk.assessment.demands import is_linear
from pounding_risk.assessment.fragility import out_of_scale, shown_as
from pounding_risk.assessment.intensities import intensities
from pounding_risk.assessment.options import USUAL_PERCENTILE, Criterion
from pounding_risk.assessment.uncertain_samples import Output, Request, Samples, named_output
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import read_measure, read_sa
from pounding_risk.results.attributes import SCENE_AXES, VARIANTS, as_text
from pounding_risk.results.variables import bounded, described
from pounding_risk.scene.scene_axis import SAMPLE
from pounding_risk.statistics.closings import CrossedClosings, DrawnClosings, analysed_clusters, motion_share
from pounding_risk.statistics.crossed import Analysis
from pounding_risk.statistics.fragility import ALONE, Fit
from pounding_risk.statistics.proportions import exact_bounds
from pounding_risk.statistics.required_gap import USUAL_PERCENTILES
from pounding_risk.statistics.sobol import QUANTILES, Indices, given_indices, sobol_indices

Array = NDArray[np.float64]

CURVES = ("motions alone", "total")
PARTS = ("parameters", "motions", "interaction", "total")
PARTS_DRAWN = ("parameters and interaction", "motions", "total")  # where motions are drawn with the samples
OVER_SAMPLES = (5.0, 16.0, 50.0, 84.0, 95.0)  # percentiles over the samples
GAPS = 81  # at which P(contact) is given
USUAL_TARGET = (
    " The default target is what the 84th percentile, the median plus one standard deviation, leaves of 100 %."
)
GAPS_WORDS = (
    "even steps from 0 to what 99.5 % of all outcomes need or 1.2 times the judged gap, the scene's own gaps and the "
    "judged one"
)


@np.errstate(invalid="ignore")  # differences of infinities, where a motion has no finite closing
def assessed(subject: Samples, request: Request) -> xr.Dataset:
    """The dataset of `uncertainty` from samples."""
    places = range(len(subject.interfaces))
    closings = [subject.closings(index, request.level) for index in places]
    own_gaps = [subject.gap(index) for index in places]
    judged_gaps = own_gaps if request.gap is None else [request.gap for _ in places]
    largest = max(float(np.percentile(closing.rising, 99.5)) for closing in closings)
    most = max(largest, 1.2 * max(judged_gaps), 1e-6)
    largest_gap = most if np.isfinite(most) else max(float(np.exp(closing.logs.max())) for closing in closings)
    largest_gap = max(largest_gap, 1.2 * max(judged_gaps), 1e-6)
    gaps = np.unique([*np.linspace(0.0, largest_gap, GAPS), *judged_gaps, *own_gaps])
    datasets = [_interface(subject, index, closings[index], judged_gaps[index], gaps, request) for index in places]
    names = xr.Variable("interface", list(subject.interfaces), {"long_name": "buildings on both sides of a gap"})
    labels = {}
    for key, key_values in zip(subject.keys, subject.values, strict=True):
        about = subject.dataset[key].attrs if key in subject.dataset.variables else {}
        labels[f"value_of_{key}"] = "sample", key_values, {"long_name": f"value of {key}"} | about
    dataset = xr.concat(datasets, dim=names, combine_attrs="override").assign_coords(labels)
    few = words.of_few(closings[0], request.criterion)
    failures = (words.lost_words(name, crossed) for name, crossed in zip(subject.interfaces, closings, strict=True))
    notes = filter(None, (*(words.offset_words(subject, index) for index in places), *failures))
    assumptions = [*subject.assumptions, *notes]
    is_usual = request.criterion.agrees and request.criterion.percentile == USUAL_PERCENTILE
    about = {
        "title": subject.title,
        "asked": f"{request.criterion.words}{USUAL_TARGET if is_usual else ''}",
        "samples": subject.words,
        "motions": subject.motions_words(request.level),
        "assumptions": as_text([*assumptions, *few, *subject.first_sample.record_doubts]),
        **request.criterion._asdict(),
        **created("pounding_risk.uncertainty"),
    }
    run_attributes = {
        name: attribute for name, attribute in subject.dataset.attrs.items() if name not in (SCENE_AXES, VARIANTS)
    }
    return dataset.assign_attrs(run_attributes | about)


def _interface(
    subject: Samples, index: int, closings: CrossedClosings, gap: float, gaps: Array, request: Request
) -> xr.Dataset:
    """The part of the dataset of one interface."""
    criterion = request.criterion
    confidence = criterion.confidence
    outputs = subject.outputs(index, closings, gap, request)
    chosen_output = named_output(outputs, request.output)
    percentiles = tuple(sorted({*USUAL_PERCENTILES, criterion.percentile, criterion.target_percentile}))
    components = PARTS_DRAWN if closings.is_drawn else PARTS
    analysis = outputs[chosen_output].analysis or closings.analysis
    about_deviation = described("m", "standard deviation of the gap over the samples; 0 where it is known")
    about_zero = described("1", "outcomes whose closing, less what the gap has more than the scene's own, is 0")
    variables: dict[str, Any] = {
        **_contact_shares(closings, gap, gaps, criterion),
        **_required_gaps(closings, percentiles, confidence),
        **_variances(analysis, outputs[chosen_output].analysis_unit, confidence, components),
        **_fragilities(subject, index, closings, gap, request),
        **_indices(subject, outputs, closings, confidence),
        **subject.moved(index, gap, request),
        "scene_gap": ((), subject.gap(index), described("m", "gap of the scene")),
        "gap_deviation": ((), subject.gap_deviation(index), about_deviation),
        "outcomes_without_closing": ((), int((closings.closing <= 0.0).sum()), about_zero),
    }
    coords = {
        "gap": ("gap", gaps, described("m", "gap") | {"description": GAPS_WORDS}),
        "component": ("component", list(components), {"long_name": "part of the variance"}),
        "percentile": ("percentile", list(percentiles), described("1", "percentile [%]")),
        "sample_percentile": ("sample_percentile", list(OVER_SAMPLES), described("1", "percentile of samples [%]")),
        "uncertain_number": ("uncertain_number", list(subject.keys), {"long_name": "address in the scene"}),
        "output": ("output", list(outputs), {"long_name": "output of a sample"}),
        "output_unit": ("output", [output.unit for output in outputs.values()], {"long_name": "unit of the output"}),
        "output_words": ("output", [output.words for output in outputs.values()], {"long_name": "what the output is"}),
        "curve": ("curve", list(CURVES), {"long_name": "dispersion of the fragility"}),
    }
    if subject.moved_dataset is not None:
        coords["quantile"] = ("quantile", list(QUANTILES), described("1", "quantile of the number"))
    dataset = xr.Dataset(variables, coords)
    verdict, sentence = words.verdict_of(closings, subject, index, gap, request.level, criterion)
    dataset["verdict"] = ((), verdict, {"long_name": "verdict on the gap"})
    dataset["sentence"] = ((), sentence, {"long_name": "verdict in words"})
    dataset["chosen_output"] = ((), chosen_output, {"long_name": "output that the sentences are of"})
    narrowing = words.narrowing(dataset, closings, gap, criterion)
    dataset["narrowing"] = ((), " ".join(narrowing), {"long_name": "what would narrow the answer"})
    return dataset


def _contact_shares(closings: CrossedClosings, gap: float, gaps: Array, criterion: Criterion) -> dict[str, Any]:
    """P(contact) over the gaps and at the judged one, in all and in each sample; what drawn motions close."""
    over_gaps, at_gap = closings.contact(gaps, criterion.confidence), closings.contact(gap, criterion.confidence)
    contact = "P(contact) over samples and motions"
    judged = (at_gap.value[0], at_gap.low[0], at_gap.high[0])
    variables = {
        **bounded("contact_probability", "gap", over_gaps[:3], "1", contact),
        "judged_gap": ((), gap, described("m", "gap that is judged")),
        **bounded("judged_probability", (), judged, "1", f"{contact} at the judged gap"),
        "independent": ((), at_gap.independent[0], described("1", "independent outcomes that these bounds are for")),
        "independent_motions": ((), closings.counted.motions, described("1", "independent motions")),
    }
    if closings.is_drawn:
        about = described("m", "what the sample's motion closes without contact, which its gap is to be wider than")
        return variables | {"closing_of_sample": ("sample", closings.closing[:, 0], about)}
    by_sample = np.stack([np.percentile(closings.of_samples(width), OVER_SAMPLES) for width in gaps.tolist()])
    share = closings.of_samples(gap)
    count = int((share > criterion.target).sum())
    bounds = map(float, exact_bounds(count, share.size, criterion.confidence))
    over_samples = "percentiles over the samples of P(contact) over the motions"
    exceeding = "share of the samples in which P(contact) under these motions exceeds the target"
    return {
        **variables,
        "contact_probability_of_samples": (("gap", "sample_percentile"), by_sample, described("1", over_samples)),
        "contact_probability_of_sample": ("sample", share, described("1", "P(contact) over the motions at the gap")),
        **bounded("samples_over_target", (), (count / share.size, *bounds), "1", exceeding),
    }


def _required_gaps(closings: CrossedClosings, percentiles: tuple[float, ...], confidence: float) -> dict[str, Any]:
    """Required gaps at the percentiles, over samples and motions, and over the samples."""
    required = closings.required(percentiles, confidence)
    columns = [[getattr(need, name) for need in required] for name in ("gap", "low", "high")]
    is_bound = described("1", "1 where the upper bound is one, 0 where it is the largest seen")
    variables = {
        **bounded("required_gap", "percentile", columns, "m", "gap that a percentile of samples and motions needs"),
        "required_gap_bounded": ("percentile", np.array([need.bounded for need in required], dtype=np.int8), is_bound),
    }
    if not closings.is_drawn:
        over_samples = np.percentile(enough_for(closings.closing, percentiles, axis=1), OVER_SAMPLES, axis=1).T
        about = described("m", "percentiles over the samples of the gap that a percentile of the motions needs")
        variables["required_gap_of_samples"] = (("percentile", "sample_percentile"), over_samples, about)
    return variables


def _variances(analysis: Analysis, unit: str, confidence: float, names: tuple[str, ...]) -> dict[str, Any]:
    """Standard deviations by what they come from, with bounds, and each as a share of the variance."""
    of = [attrgetter("samples" if name.startswith("parameters") else name) for name in names]  # a field of `Components`
    bounds = np.sqrt([analysis.variance_bounds(component, confidence) for component in of])
    variances = np.maximum([component(analysis.all) for component in of[:-1]], 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = np.append(variances / variances.sum(), 1.0)
    output_text = "of the logarithm of what is closed" if unit == "1" else "of the output"
    return {
        **bounded("dispersion", "component", bounds.T, unit, f"standard deviation {output_text} by what it comes from"),
        "variance_share": ("component", shares, described("1", "share of the variance, of what is above 0")),
    }


def _fragilities(
    subject: Samples, index: int, closings: CrossedClosings, gap: float, request: Request
) -> dict[str, Any]:
    """Median and dispersion of the fragilities of motions alone and in all, with bounds; NaN with a fault.

    Linear buildings close a gap under a motion that is scaled by gap over closing: so every motion has a capacity in
    every sample, and ln capacity has the components of variance of ln closing and ln intensity together. The curve of
    the motions alone has the mean of ln capacity and the dispersion of the motions within a sample; the one in all adds
    what the samples differ by (the composite curve of Kennedy and Ravindra, Nuclear Engineering and Design 79, 1984).
    """
    from scipy.special import stdtrit

    logs, intensity, fault = _log_capacities(subject, index, closings, gap, request)
    medians, dispersions = np.full((2, 3), np.nan), np.full((2, 3), np.nan)
    if logs is not None:
        confidence = request.criterion.confidence
        analysis, counted = closings.of_logs(logs)
        alone, total = (
            np.sqrt(analysis.variance_bounds(getter, confidence))
            for getter in (lambda parts: parts.motions + parts.interaction, lambda parts: parts.total)
        )
        if closings.is_drawn:  # what motions do in a sample is not separable from what they do in the mean over samples
            alone = np.full(3, np.nan)
        freedom = max(min(counted.motions, float(counted.samples)) - 1.0, 1.0)
        half_width = float(stdtrit(freedom, 0.5 * (1.0 + confidence))) * np.sqrt(counted.variance_of_mean(analysis.all))
        medians[:] = np.exp(logs.mean() + np.array([0.0, -half_width, half_width]))
        dispersions = np.stack([alone, total])
    measure = read_measure(intensity)
    unit = "m/s2" if measure is None else measure.unit
    return {
        **bounded("fragility_median", "curve", medians.T, unit, "median of contact"),
        **bounded("fragility_dispersion", "curve", dispersions.T, "1", "dispersion of contact"),
        "fragility_intensity": ((), intensity, {"long_name": "intensity of the fragilities"}),
        "fragility_fault": ((), fault, {"long_name": "why there are no fragilities"}),
    }


def _log_capacities(
    subject: Samples, index: int, closings: CrossedClosings, gap: float, request: Request
) -> tuple[Array | None, str, str]:
    """Logarithms of the intensities at which motions close a gap [m], (samples, motions), their measure, or a fault."""
    one_sample = subject.first_sample.interfaces[index][1]
    intensity = one_sample.usual_intensity if request.intensity is None else request.intensity
    if intensity.startswith("sa(") and read_sa(intensity) is None:
        if request.intensity is not None:
            raise PoundingError(
                f"intensity {intensity!r}: a building's period may differ between samples; write pga, or a period "
                "such as sa(0.5 s)"
            )
        intensity = "pga"
    reach = subject.reach_of(subject.dataset, index, request.level)[:, closings.order]
    sample_gaps = subject.gaps_of(subject.dataset, index, gap)
    gaps = np.full(len(reach), gap) if sample_gaps is None else sample_gaps
    fault = ""
    if not is_linear(one_sample):
        fault = "the motion without contact is not linear: closings do not grow with the motion"
    elif subject.is_inner(index) and "impact_count" in subject.dataset:
        fault = "contact elsewhere in the row may push buildings across the gap, which does not grow with the motion"
    elif gaps.min() <= 0.0:
        fault = "a closed gap is touched by the weakest motion"
    elif not (reach.min() > 0.0 and np.isfinite(reach).all()):
        fault = "a motion closes nothing, or has no finite response, in some sample"
    elif closings.recordings.max() == 0:
        fault = ALONE
    if fault:
        return None, intensity, fault
    ims = intensities(one_sample, intensity)
    ims = subject.by_outcome(ims[:, min(subject.level(request.level), ims.shape[1] - 1)], closings)
    factors = np.log(gaps)[:, None] - np.log(reach)
    logs = np.log(ims) + factors
    median = Fit(median=float(np.exp(logs.mean())))
    _, fault = out_of_scale(median, np.exp([factors.mean()]), shown_as(intensity))
    return None if fault else logs, intensity, fault


def _indices(
    subject: Samples, outputs: Mapping[str, Output], closings: CrossedClosings, confidence: float
) -> dict[str, Any]:
    """Indices of each output and number: of first order those of the samples or of a design, by the width of bounds."""
    dims, share_text = ("output", "uncertain_number"), "share of the variance over the samples that would go were the"
    output_values = np.stack([output.values for output in outputs.values()])
    first = given_indices(subject.values, output_values, confidence, subject.is_balanced)
    from_design, variables = np.zeros(len(outputs), dtype=bool), {}
    if subject.design_dataset is not None:
        designed = np.stack([output.design for output in outputs.values() if output.design is not None])
        of_design, total = sobol_indices(designed, len(subject.keys), confidence)
        from_design = ~(first.width <= of_design.width)  # where those of the samples are NaN too
        first = Indices(*(np.where(from_design[:, None], *pair) for pair in zip(of_design, first, strict=True)))
        total_text = "share of the variance that would remain were all other numbers known exactly"
        variables = bounded("total_order", dims, total, "1", total_text)
        points = subject.design_dataset.sizes[SAMPLE] // (len(subject.keys) + 2)
        variables["sobol_points"] = ((), points, described("1", "points N of the Sobol design"))
    if isinstance(closings, DrawnClosings):
        labels = closings.of_motions, closings.recordings
        shares = np.array([motion_share(analysed_clusters(output, *labels), confidence) for output in output_values])
        variables |= bounded("first_order_of_motions", "output", shares.T, "1", f"{share_text} motion known exactly")
    deviation = described("1", "standard deviation over the samples, in the unit of the output")
    source = described("1", "1 where first-order shares are those of the Sobol design, 0 where those of the samples")
    return {
        **variables,
        **bounded("first_order", dims, first, "1", f"{share_text} number known exactly"),
        "first_order_of_design": ("output", from_design.astype(np.int8), source),
        "output_deviation": ("output", np.std(output_values, axis=1), deviation),
    }
