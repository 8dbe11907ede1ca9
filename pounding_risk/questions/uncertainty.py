"""Sheet of `uncertainty`: contact and required gaps over samples of uncertain numbers, and which numbers matter."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.assessment.uncertain_samples import ALL_MOTIONS
from pounding_risk.assessment.uncertain_words import (
    OUTPUT_WORDS,
    gap_scatter,
    indices_words,
    parts_words,
    samples_words,
)
from pounding_risk.errors import PoundingError
from pounding_risk.questions._declaration import Option
from pounding_risk.questions.notes import of_records
from pounding_risk.render.sheet import (
    Block,
    Cell,
    between,
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
)
from pounding_risk.scene.scene import Scene

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

ORDER = 135
FUNCTION = "assessment.uncertain"
SUBJECT = "scene or results"
UNIT = "batches"
FIGURES = {"": "uncertainty.uncertainty_figure"}
OPTIONS = {"sobol": Option(kind=int)}
Row = list[Cell | str]
ALONE = "motions alone"  # the curve of the dispersion within a sample
GAP_ROWS = 9  # gaps of the table of P(contact)


def sheet(dataset: xr.Dataset, *, tornado: bool = False) -> list[Block]:
    """The verdict on each interface with its tables, the figure, and what is assumed.

    Parameters
    ----------
    dataset : xarray.Dataset
        An answer of `uncertainty`.
    tornado : bool
        With the table of each number moved alone, where the answer has one.

    Returns
    -------
    list of Block
        Without percentiles over samples where motions are drawn with them.
    """
    about = [("scene", dataset.attrs["title"]), *((name, dataset.attrs[name]) for name in ("samples", "motions"))]
    blocks = [facts("", about), paragraph(dataset.attrs["asked"])]
    for place, name in enumerate(dataset["interface"].values.tolist()):
        part = dataset.isel(interface=place)
        blocks += [heading(str(name), f"uncertain-{place + 1}"), *_of_interface(part)]
        if tornado and f"{part['chosen_output'].item()}_moved" in part:
            blocks.append(_tornado(part))
    words = "P(contact) over samples and motions with its bounds, and what the uncertain numbers contribute."
    notes = [*json.loads(dataset.attrs["assumptions"])]
    notes += [f"excluded: {words}" for words in json.loads(dataset.attrs.get("left_out", "[]"))]
    notes += of_records(json.loads(dataset.attrs.get("flags", "{}")))
    return [*blocks, figure("uncertainty", lambda: _figure(dataset), words, words), listing(notes)]


def _figure(dataset: xr.Dataset) -> Figure:
    from pounding_risk.figures.uncertainty import uncertainty_figure

    return uncertainty_figure(dataset)


def _of_interface(part: xr.Dataset) -> Iterator[Block]:
    sentences = (part["sentence"].item(), samples_words(part), parts_words(part), part["narrowing"].item())
    yield from (paragraph(words) for words in sentences if words)
    yield _required(part)
    yield _contact(part)
    yield _parts(part)
    fault = str(part["fragility_fault"].item())
    yield paragraph(f"No fragilities: {fault}") if fault else _fragilities(part)
    yield _indices(part)
    if words := indices_words(part):
        yield paragraph(words)


def _over_samples(part: xr.Dataset, name: str, unit: str) -> tuple[list[str], list[list[Cell]]]:
    """Heads and cells of the percentiles over the samples; none where motions are drawn with samples."""
    if name not in part:
        return [], [[] for _ in part[name.removesuffix("_of_samples")].values]
    heads = [head(words, unit) for words in ("5 % of samples", "median", "95 %")]
    values = part[name].sel(sample_percentile=[5.0, 50.0, 95.0]).transpose(..., "sample_percentile").values
    return heads, [[probability(value) if unit == "%" else number(value, unit) for value in row] for row in values]


def _required(part: xr.Dataset) -> Block:
    heads = [head("share", "%"), head("gap required", "m"), head("bounds", "m"), ""]
    more, cells = _over_samples(part, "required_gap_of_samples", "m")
    rows: list[Row] = []
    for percentile, over in zip(part["percentile"].values, cells, strict=True):
        one = part.sel(percentile=percentile)
        bounded = "" if int(one["required_gap_bounded"]) else "the upper one is the largest seen"
        row: Row = [number(percentile), number(one["required_gap"], "m")]
        rows.append([*row, between(one["required_gap_low"], one["required_gap_high"], "m"), bounded, *over])
    nominal = "Nominal gap, to which its scatter adds," if gap_scatter(part) > 0.0 else "Gap"
    return table(f"{nominal} required by a share of samples and motions together.", heads + more, rows)


def _contact(part: xr.Dataset) -> Block:
    """P(contact) at a few gaps, the judged one and the scene's own among them."""
    size, gaps = part.sizes["gap"], part["gap"].values
    own = [int(np.abs(gaps - float(part[name])).argmin()) for name in ("judged_gap", "scene_gap")]
    places = sorted({*(round(at * (size - 1) / (GAP_ROWS - 1)) for at in range(GAP_ROWS)), *own})
    nominal = gap_scatter(part) > 0.0
    heads = [head("nominal gap" if nominal else "gap", "m"), head("P(contact)", "%")]
    more, cells = _over_samples(part, "contact_probability_of_samples", "%")
    rows: list[Row] = []
    for place in places:
        one = part.isel(gap=place)
        share, low, high = (probability(one[f"contact_probability{end}"]) for end in ("", "_low", "_high"))
        rows.append([number(one["gap"], "m"), share, joined(low, high), *cells[place]])
    caption = f"P(contact) against the gap, over samples and motions. Gaps: {part['gap'].attrs['description']}."
    if nominal:
        caption += " The gap of each sample departs from a nominal one by the scatter that [uncertain] states."
    return table(caption, [*heads, head("bounds", "%"), *more], rows)


def _parts(part: xr.Dataset) -> Block:
    unit, output = str(part["dispersion"].attrs["units"]), str(part["chosen_output"].item())
    whose = "the logarithm of the closing without contact" if output in OUTPUT_WORDS else output.replace("_", " ")
    rows: list[Row] = []
    for name in part["component"].values:
        one = part.sel(component=name)
        deviation = number(one["dispersion"], unit), between(one["dispersion_low"], one["dispersion_high"], unit)
        rows.append([str(name), number(one["variance_share"], "%", 2), *deviation])
    heads = ["part", head("share", "%"), head("deviation", unit), head("bounds", unit)]
    return table(f"Parts of the variance of {whose}.", heads, rows)


def _fragilities(part: xr.Dataset) -> Block:
    heads = ["dispersion of", head("median", "m/s2"), head("bounds", "m/s2")]
    rows: list[Row] = []
    for name in part["curve"].values:
        if name == ALONE and "first_order_of_motions" in part:  # which drawn motions do not show
            continue
        one = part.sel(curve=name)
        row: Row = [str(name)]
        for of, unit in (("fragility_median", "m/s2"), ("fragility_dispersion", "1")):
            row += [number(one[of], unit, 3), between(one[f"{of}_low"], one[f"{of}_high"], unit, 3)]
        rows.append(row)
    caption = f"Fragility of contact against {part['fragility_intensity'].item()}."
    return table(caption, [*heads, "dispersion", "bounds"], rows)


def _indices(part: xr.Dataset) -> Block:
    """Indices of the output that the sentences are of, the largest first."""
    output = str(part["chosen_output"].item())
    one = part.sel(output=output)
    kinds = {"first_order": "first-order share", "total_order": "total share"}
    kinds = {kind: words for kind, words in kinds.items() if kind in part}
    heads = ["number", *(head(each, "%") for words in kinds.values() for each in (words, "bounds"))]
    rows: list[Row] = []
    for place in np.argsort(-np.nan_to_num(one["first_order"].values, nan=-1.0)).tolist():
        here = one.isel(uncertain_number=place)
        rows.append([str(here["uncertain_number"].item()), *(cell for kind in kinds for cell in _share(here, kind))])
    if "first_order_of_motions" in one:
        rows.append(["the motion", *_share(one, "first_order_of_motions")])
    said = OUTPUT_WORDS.get(output, output.replace("_", " "))
    return table(f"Shares of the numbers in the variance of {said} over the samples.", heads, rows)


def _share(one: xr.Dataset, name: str) -> list[Cell]:
    return [number(one[name], "%", 2), between(one[f"{name}_low"], one[f"{name}_high"], "%", 2)]


def check(given: Mapping[str, Any]) -> None:
    """Raise PoundingError for a tornado of what has none."""
    source = given["source"]
    if not given.get("tornado"):
        return
    if isinstance(source, Path) and source.suffix.lower() == ".toml":
        return  # not opened yet
    if not isinstance(source, Scene):
        raise PoundingError(
            "tornado: each number is moved alone in a run of the scene, which a dataset has not; name the scene"
        )
    if source.uncertain is not None and source.uncertain.is_drawn:
        raise PoundingError(f"tornado: is over all motions, and one is drawn with each sample; {ALL_MOTIONS}")


def _tornado(part: xr.Dataset) -> Block:
    """The output with each number alone at its 10 % and 90 % quantiles, the widest first."""
    output = str(part["chosen_output"].item())
    moved = part[f"{output}_moved"]
    unit = "%" if output == "contact_probability" else str(moved.attrs["units"])
    rows: list[Row] = []
    for place in np.argsort(-np.ptp(moved.values, axis=1), kind="stable").tolist():
        values = moved.values[place].tolist()
        rows.append([str(part["uncertain_number"].values[place]), *(number(value, unit) for value in values)])
    heads = ["number", *(head(words, unit) for words in ("at 10 %", "all at medians", "at 90 %"))]
    caption = f"{OUTPUT_WORDS[output]} with each number alone at its 10 % and its 90 %."
    return table(caption[0].upper() + caption[1:], heads, rows)
