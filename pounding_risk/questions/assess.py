"""Sheet of `assess`: the verdict on each gap with its evidence, and the tables that it rests on."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import xarray as xr

from pounding_risk.assessment.along import IDLE as IDLE_AXES
from pounding_risk.assessment.along import OWN, assess_along
from pounding_risk.assessment.assess import Assessment, InterfaceAssessment, assess, plain
from pounding_risk.errors import PoundingError
from pounding_risk.questions import adequacy, rates
from pounding_risk.questions._declaration import text_file
from pounding_risk.questions.along import sheet as along_sheet
from pounding_risk.questions.notes import of_records
from pounding_risk.questions.setback import ASSUMED, setbacks
from pounding_risk.questions.setback import sheet as setback_sheet
from pounding_risk.render.sheet import KEPT, MISSING, Block, count, head, heading, listing, number, paragraph, table
from pounding_risk.results.attributes import name_of
from pounding_risk.results.check import kind_of
from pounding_risk.results.scene_axes import check_one_place, open_axes
from pounding_risk.scene.scene_axis import SAMPLE

ORDER = 130
FUNCTION = "assessment.assess"
IDLE = ("gap", "intensity", "hazard", "gmfs", "site", "target_rate", "figure")  # of a setback


def answer(results: Any, *, setback: bool = False, **options: Any) -> Any:
    """The assessment that fits a dataset: of its gaps, along its axes, over its samples, or of setbacks.

    Parameters
    ----------
    setback : bool
        Instead: distance of each building from a property line.

    Returns
    -------
    Assessment, xarray.Dataset or tuple of Setback
        As `assess`, `assess_along`, `uncertainty` or `setbacks` gives it.
    """
    axes = [] if isinstance(results, Path) else [axis.name for axis in open_axes(results)]
    if setback:
        return setbacks(results, **options)
    if not axes:
        return assess(results, **options)
    site_options = [name for name in ("hazard", "gmfs") if name in options]
    if axes == [SAMPLE]:
        from pounding_risk.questions.uncertainty import uncertainty

        for name in site_options:
            raise PoundingError(
                f"{name}: is not joined with samples of uncertain numbers; choose one with --select sample=0"
            )
        return uncertainty(results, **options)
    if site_options or "intensity" in options:
        check_one_place(results, name_of(results))
    return assess_along(results, **options)


def check(options: Mapping[str, Any]) -> None:
    """Raise PoundingError for options that a setback does not take."""
    for name in IDLE if options.get("setback") else ():
        if name in options:
            raise PoundingError(f"{name}: is not taken with --setback, which no neighbour enters; leave it out")


def drawing(assessed: Any) -> str:
    """The figure of an answer."""
    if not isinstance(assessed, xr.Dataset):
        return "assess.assessment_figure"
    return "uncertainty.uncertainty_figure" if kind_of(assessed) == "uncertainty" else "along.along_figure"


def as_json(assessed: Any) -> str:
    """All of an answer as JSON."""
    return json.dumps(_facts(assessed), ensure_ascii=False, indent=1) + "\n"


def _facts(assessed: Any) -> Any:
    if isinstance(assessed, tuple):
        return plain({"assumed": ASSUMED, "setbacks": [asdict(setback) for setback in assessed]})
    if not isinstance(assessed, xr.Dataset):
        return assessed.as_dict()
    if kind_of(assessed) == "uncertainty":
        raise PoundingError(
            "out: samples of uncertain numbers are written by `pounding-risk uncertainty RESULTS -o uncertainty.nc`"
        )
    rows = assessed.to_dataframe().reset_index().astype(object)
    attributes = dict(assessed.attrs) | {name: json.loads(assessed.attrs[name]) for name in (OWN, IDLE_AXES)}
    return attributes | {"places": rows.where(rows.notna(), None).to_dict("records")}


FIGURES = {"": drawing}
FILES = {"out": text_file("", ".json", as_json)}


def sheet(assessment: Any) -> list[Block]:
    """The sheet of an answer, by its kind."""
    if isinstance(assessment, tuple):
        return setback_sheet(assessment)
    if not isinstance(assessment, xr.Dataset):
        return gaps(assessment)
    if kind_of(assessment) == "uncertainty":
        from pounding_risk.questions.uncertainty import sheet as uncertainty_sheet  # with pydantic

        note = (
            "`pounding-risk uncertainty` has more of this; `--select sample=0` gives the whole assessment of a sample"
        )
        return [*uncertainty_sheet(assessment), paragraph(note)]
    return along_sheet(assessment)


def gaps(assessment: Assessment) -> list[Block]:
    """The verdicts, then the tables of each interface, left to right.

    Without what its dataset or options do not give, such as rates without a hazard curve.
    """
    blocks = [paragraph("\n".join([assessment.title, *columns(assessment), assessment.asked]))]
    blocks += [listing(assessment.notes)] if assessment.notes else []
    blocks += row(assessment) if len(assessment.interfaces) > 1 else []
    for place, pair in enumerate(assessment.interfaces, start=1):
        blocks += [
            heading(pair.name, f"interface-{place}"),
            *verdict(pair),
            *adequacy.required_gaps(pair),
            *adequacy.contact(assessment, pair),
            *adequacy.yielding(assessment, pair),
            *adequacy.response(pair),
            *adequacy.influences(pair),
            *adequacy.fragilities(assessment, pair),
            *([paragraph(assessment.hazard_reading)] if assessment.hazard_reading and pair.rates else []),
            *rates.annual_rates(assessment, pair),
            *rates.scenario(assessment, pair),
            *rates.gaps_for_rates(assessment, pair),
            *adequacy.rules(assessment.percentile, pair),
        ]
    excluded = (f"excluded: {sentence}" for sentence in assessment.left_out)
    notes = [*assessment.unused_keys, *excluded, *of_records(assessment.flags)]
    return [*blocks, *([listing(notes)] if notes else [])]


def columns(assessment: Assessment) -> list[str]:
    """Sentences on columns that floors strike, each with its interface where there are several."""
    is_row = len(assessment.interfaces) > 1
    places: dict[str, list[str]] = {}
    for pair in assessment.interfaces:
        for words in pair.columns:
            places.setdefault(words, []).append(pair.name)
    entries = sorted(places.items(), key=lambda entry: len(entry[1]) > 1)  # what holds of several stands last, once
    return [f"{'; '.join(names)}: {words}" if is_row else words for words, names in entries]


def verdict(pair: InterfaceAssessment) -> tuple[Block, Block]:
    """The verdict on a gap with what to provide, and its evidence."""
    result = pair.verdict
    box = {
        "kind": "verdict",
        "name": pair.name,
        "word": result.word,
        "conclusion": list(result.conclusion[len(pair.columns) :]),  # columns stand at the top
        "sentence": result.sentence,
    }
    return box, listing([*result.evidence, f"In short: {pair.what_matters}."], mark="  ")


def row(assessment: Assessment) -> list[Block]:
    """Table of the verdicts of a row, one line an interface, and why equal counts have other verdicts."""
    heads = ["neighbours", head("gap", "m"), "verdict", "contact in", "of", "P(contact) [%]"]
    heads += [head(f"required by {assessment.percentile:g} %", "m")]
    if assessment.target_rate is not None:
        heads += [f"for {assessment.target_rate_words}", head("gap for it", "m")]
    rows: list[adequacy.Row] = []
    for pair in assessment.interfaces:
        cells: adequacy.Row = [pair.name, number(pair.gap, "m", adequacy.GIVEN), pair.verdict.word]
        share, required = pair.contact_at_gap(), pair.required_at(assessment.percentile)
        cells += [count(share.count), count(share.runs), number(share.probability, "%", 3), adequacy.need(required)]
        if assessment.target_rate is not None:
            by_rate = pair.rate_verdict
            cells += [MISSING, MISSING] if by_rate is None else [by_rate.word, rates.gap_for_rate(by_rate.required)]
        rows.append(cells)
    worst = sorted(range(len(rows)), key=lambda k: -assessment.interfaces[k].contact_at_gap().probability)
    note = "those with most contact"
    verdicts = table("The gaps of the row, left to right.", heads, rows, keep=sorted(worst[:KEPT]), note=note)
    return [verdicts, *map(paragraph, assessment.unlike_verdicts)]
