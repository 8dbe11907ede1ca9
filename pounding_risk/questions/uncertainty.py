"""What uncertain numbers mean: contact and required gaps over samples of them, and which numbers matter."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from pounding_risk._common.order import evenly
from pounding_risk._common.progress import Progress
from pounding_risk.assessment.options import USUAL_CONFIDENCE, read_criterion
from pounding_risk.assessment.uncertain import assessed
from pounding_risk.assessment.uncertain_samples import ALL_MOTIONS, Request, Samples, opened_samples, sampled_scene
from pounding_risk.assessment.uncertain_words import (
    COMPONENTS,
    OUTPUT_WORDS,
    closing_words,
    gap_scatter,
    indices_words,
    parts_words,
    samples_words,
)
from pounding_risk.errors import PoundingError
from pounding_risk.figures.uncertainty import uncertainty_figure
from pounding_risk.questions._declaration import Option
from pounding_risk.questions.adequacy import enough
from pounding_risk.questions.notes import of_keys, of_records
from pounding_risk.render.sheet import (
    Block,
    Cell,
    Row,
    facts,
    figure,
    head,
    heading,
    joined,
    listing,
    number,
    paragraph,
    probability,
    table,
    with_bounds,
)
from pounding_risk.results.amplitudes import intensity_words
from pounding_risk.results.files import save
from pounding_risk.results.opened import Results
from pounding_risk.scene.scene import Scene
from pounding_risk.units import GAP, si

ORDER = 135
SUBJECT = "scene or results"
UNIT = "batches"
FIGURES = {"": "uncertainty.uncertainty_figure"}
OPTIONS = {"sobol": Option(kind=int)}
ALONE = "motions alone"  # the curve of the dispersion within a sample
GAP_ROWS = 9  # gaps of the table of P(contact)
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
    """What uncertain numbers of a scene mean for the gap.

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
    from pounding_risk.studies.study import check_out

    file = check_out(out, "uncertainty", new)
    request = Request(
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
    Results(subject.dataset).read_gap(gap)
    dataset = assessed(subject, request._replace(level=subject.first_sample.level(pga, intensity_level)))
    if file is not None:
        save(dataset, file)
    return dataset


def sheet(dataset: xr.Dataset, *, tornado: bool = False) -> list[Block]:
    """The verdict on each interface with its tables and its figure, and what is assumed.

    Without percentiles over samples where motions are drawn with them.

    Parameters
    ----------
    tornado : bool
        With the table of each number moved alone, where the answer has one.
    """
    rows = [("scene", dataset.attrs["title"]), *((name, dataset.attrs[name]) for name in ("samples", "motions"))]
    blocks = [facts("", rows), paragraph(dataset.attrs["asked"])]
    for place, name in enumerate(dataset["interface"].values.tolist()):
        pair = dataset.isel(interface=place)
        blocks += [heading(str(name), f"uncertain-{place + 1}"), *_of_interface(pair)]
        if tornado and f"{pair['chosen_output'].item()}_moved" in pair:
            blocks.append(_tornado(pair))
        words = f"{name}: P(contact) over samples and motions with its bounds, and what the numbers contribute."
        drawing = partial(uncertainty_figure, dataset.isel(interface=[place]), titled=False)
        blocks.append(figure(f"uncertainty-{place + 1}", drawing, words, words))
    notes = [*of_keys(dataset.attrs), *json.loads(dataset.attrs["assumptions"])]
    notes += [f"excluded: {words}" for words in json.loads(dataset.attrs.get("left_out", "[]"))]
    notes += of_records(json.loads(dataset.attrs.get("flags", "{}")))
    return [*blocks, listing(notes)]


def _of_interface(pair: xr.Dataset) -> Iterator[Block]:
    sentences = (pair["sentence"].item(), samples_words(pair), parts_words(pair), pair["narrowing"].item())
    yield from (paragraph(words) for words in sentences if words)
    yield _required(pair)
    yield _contact(pair)
    yield _parts(pair)
    fault = str(pair["fragility_fault"].item())
    yield paragraph(f"No fragilities: {fault}") if fault else _fragilities(pair)
    yield _indices(pair)
    if words := indices_words(pair):
        yield paragraph(words)


def _over_samples(pair: xr.Dataset, name: str, unit: str) -> tuple[list[str], list[list[Cell]]]:
    """Heads and cells of the percentiles over the samples; none where motions are drawn with samples."""
    if name not in pair:
        return [], [[] for _ in pair[name.removesuffix("_of_samples")].values]
    heads = [head(words, unit) for words in ("5 % of samples", "median", "95 %")]
    shares = pair[name].sel(sample_percentile=[5.0, 50.0, 95.0]).transpose(..., "sample_percentile").values
    return heads, [[probability(share) if unit == "%" else number(share, unit) for share in row] for row in shares]


def _required(pair: xr.Dataset) -> Block:
    heads = [head("share", "%"), head("gap required", "m"), head("bounds", "m"), ""]
    more_heads, cells = _over_samples(pair, "required_gap_of_samples", "m")
    rows: list[Row] = []
    for percentile, sample_cells in zip(pair["percentile"].values, cells, strict=True):
        required = pair.sel(percentile=percentile)
        bound_note = "" if int(required["required_gap_bounded"]) else "the upper one is the largest seen"
        bounds = joined(number(required["required_gap_low"], "m"), enough(float(required["required_gap_high"])))
        rows.append([number(percentile), enough(float(required["required_gap"])), bounds, bound_note, *sample_cells])
    nominal = "Nominal gap, to which its scatter adds," if gap_scatter(pair) > 0.0 else "Gap"
    return table(f"{nominal} required by a share of samples and motions together.", heads + more_heads, rows)


def _contact(pair: xr.Dataset) -> Block:
    """P(contact) at a few gaps, the judged one and the scene's own among them."""
    gaps = pair["gap"].values
    own_places = [int(np.abs(gaps - float(pair[name])).argmin()) for name in ("judged_gap", "scene_gap")]
    places = sorted({*evenly(pair.sizes["gap"], GAP_ROWS), *own_places})
    has_scatter = gap_scatter(pair) > 0.0
    heads = [head("nominal gap" if has_scatter else "gap", "m"), head("P(contact)", "%")]
    more_heads, cells = _over_samples(pair, "contact_probability_of_samples", "%")
    rows: list[Row] = []
    for place in places:
        at_gap = pair.isel(gap=place)
        share, low, high = (probability(at_gap[f"contact_probability{end}"]) for end in ("", "_low", "_high"))
        rows.append([number(at_gap["gap"], "m"), share, joined(low, high), *cells[place]])
    caption = f"P(contact) against the gap, over samples and motions. Gaps: {pair['gap'].attrs['description']}."
    if has_scatter:
        caption += " The gap of each sample departs from a nominal one by the scatter that [uncertain] states."
    return table(caption, [*heads, head("bounds", "%"), *more_heads], rows)


def _parts(pair: xr.Dataset) -> Block:
    unit, output = str(pair["dispersion"].attrs["units"]), str(pair["chosen_output"].item())
    is_of_closing = output in OUTPUT_WORDS
    output_text = f"the logarithm of {closing_words(pair)}" if is_of_closing else output.replace("_", " ")
    rows: list[Row] = []
    for name in pair["component"].values:
        part = pair.sel(component=name)
        words = COMPONENTS.get(str(name), str(name)).removeprefix("the ")
        rows.append([words, number(part["variance_share"], "%", 2), *with_bounds(part, "dispersion", unit, 4, 4)])
    heads = ["part", head("share", "%"), head("deviation", unit), head("bounds", unit)]
    return table(f"Parts of the variance of {output_text}.", heads, rows)


def _fragilities(pair: xr.Dataset) -> Block:
    heads = ["dispersion of", head("median", "m/s2"), head("bounds", "m/s2")]
    rows: list[Row] = []
    for name in pair["curve"].values:
        if name == ALONE and "first_order_of_motions" in pair:  # which drawn motions do not show
            continue
        curve = pair.sel(curve=name)
        row: Row = [str(name)]
        for variable, unit in (("fragility_median", "m/s2"), ("fragility_dispersion", "1")):
            row += with_bounds(curve, variable, unit, 3, 3)
        rows.append(row)
    caption = f"Fragility of contact against {intensity_words(str(pair['fragility_intensity'].item()))}."
    return table(caption, [*heads, "dispersion", "bounds"], rows)


def _indices(pair: xr.Dataset) -> Block:
    """Indices of the output that the sentences are of, the largest first."""
    output = str(pair["chosen_output"].item())
    indices = pair.sel(output=output)
    kinds = {"first_order": "first-order share", "total_order": "total share"}
    kinds = {kind: words for kind, words in kinds.items() if kind in pair}
    heads = ["number", *(head(label, "%") for words in kinds.values() for label in (words, "bounds"))]
    rows: list[Row] = []
    for place in np.argsort(-np.nan_to_num(indices["first_order"].values, nan=-1.0)).tolist():
        entry = indices.isel(uncertain_number=place)
        cells = [cell for kind in kinds for cell in with_bounds(entry, kind, "%", 2)]
        rows.append([str(entry["uncertain_number"].item()), *cells])
    if "first_order_of_motions" in indices:
        rows.append(["the motion", *with_bounds(indices, "first_order_of_motions", "%", 2)])
    output_words = OUTPUT_WORDS.get(output, output.replace("_", " "))
    return table(f"Shares of the numbers in the variance of {output_words} over the samples.", heads, rows)


def check(options: Mapping[str, Any]) -> None:
    """Raise PoundingError for a tornado of what has none."""
    source = options["source"]
    if not options.get("tornado"):
        return
    if isinstance(source, Path) and source.suffix.lower() == ".toml":
        return  # not opened yet
    if not isinstance(source, Scene):
        raise PoundingError(
            "tornado: each number is moved alone in a run of the scene, which a dataset has not; name the scene"
        )
    if source.uncertain is not None and source.uncertain.is_drawn:
        raise PoundingError(f"tornado: is over all motions, and one is drawn with each sample; {ALL_MOTIONS}")


def _tornado(pair: xr.Dataset) -> Block:
    """The output with each number alone at its 10 % and 90 % quantiles, the widest first."""
    output = str(pair["chosen_output"].item())
    outputs = pair[f"{output}_moved"]
    unit = "%" if output == "contact_probability" else str(outputs.attrs["units"])
    rows: list[Row] = []
    for place in np.argsort(-np.ptp(outputs.values, axis=1), kind="stable").tolist():
        ends = outputs.values[place].tolist()
        rows.append([str(pair["uncertain_number"].values[place]), *(number(end, unit) for end in ends)])
    heads = ["number", *(head(words, unit) for words in ("at 10 %", "all at medians", "at 90 %"))]
    caption = f"{OUTPUT_WORDS[output]} with each number alone at its 10 % and its 90 %."
    return table(caption[0].upper() + caption[1:], heads, rows)
