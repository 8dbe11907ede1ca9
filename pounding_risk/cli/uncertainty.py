"""The command `uncertainty`: contact and required gaps over samples of uncertain numbers, and which numbers matter."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.files import announce, draw
from pounding_risk.cli._common.notes import print_flags, print_left_out, print_notes
from pounding_risk.cli._common.options import (
    NONE,
    Amplitude,
    Confidence,
    Dataset,
    Figure,
    IntensityLevel,
    New,
    Overrides,
    Percentile,
    Target,
    Workers,
    argument,
    option,
    read_optional,
)
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.render.terminal import engineering, print_pairs, print_table

ORDER = 135
SCENE = ".toml"
ALONE = "motions alone"  # the curve of the dispersion within a sample
GAP_ROWS = 9  # gaps of the table of P(contact)


def uncertainty(
    source: Annotated[Path, argument("SOURCE", "A scene with [uncertain] (.toml), or a dataset of its scan (.nc).")],
    gap: Annotated[
        str | None,
        option("The gap to judge; of uncertain gaps the nominal one, to which the scatter adds.", "the scene's"),
    ] = None,
    percentile: Percentile = None,
    confidence: Confidence = "95 %",
    target: Target = None,
    pga: Amplitude = None,
    intensity_level: IntensityLevel = None,
    intensity: Annotated[
        str | None, option('Of the fragilities: pga or "sa(0.5 s)".', "what the motions are scaled to, or pga")
    ] = None,
    output: Annotated[
        str | None,
        option(
            "What indices are of: contact_probability, required_gap, log_median_closing (of drawn motions contact, "
            "log_closing), or of a dataset any output.",
            "contact_probability, or contact",
        ),
    ] = None,
    samples: Annotated[int | None, option("Samples of a scene.", "its own", min=2)] = None,
    sobol: Annotated[
        int | None,
        option("Sobol indices, first and total, from N points times numbers + 2; such as 1024.", "none", min=8),
    ] = None,
    tornado: Annotated[bool, typer.Option("--tornado", help="Print each number from its 10 % to its 90 %.")] = False,
    overrides: Overrides = NONE,
    workers: Workers = None,
    out: Dataset = None,
    new: New = False,
    figure: Figure = None,
) -> None:
    """What uncertain numbers mean for the gap."""
    from pounding_risk.assessment.options import read_criterion
    from pounding_risk.assessment.uncertain import uncertainty as run
    from pounding_risk.assessment.uncertain_samples import ALL_MOTIONS
    from pounding_risk.errors import PoundingError
    from pounding_risk.scene.reader import read_scene
    from pounding_risk.units import GAP, PGA

    criterion = read_criterion(target, percentile, confidence, prefix="--")
    judged = read_optional("--gap", gap, GAP._replace(open_high=True)), read_optional("--pga", pga, PGA)
    is_scene = source.suffix.lower() == SCENE
    if overrides and not is_scene:
        raise PoundingError("--set: changes a value of a scene, and a dataset is of one already; leave it out")
    if tornado and not is_scene:
        raise PoundingError(
            "--tornado: each number is moved alone in a run of the scene, which a dataset has not; name the scene"
        )
    subject: Any = read_scene(source, overrides) if is_scene else source
    if tornado and subject.uncertain is not None and subject.uncertain.is_drawn:
        raise PoundingError(f"--tornado: is over all motions, and one is drawn with each sample; {ALL_MOTIONS}")
    with ProgressDisplay("uncertainty", "batches") as progress:
        dataset = run(
            subject, out, gap=judged[0], pga=judged[1], **criterion._asdict(), intensity=intensity, output=output,
            intensity_level=intensity_level,
            samples=samples, sobol=sobol or False, workers=workers, new=new, progress=progress,
        )  # fmt: skip
    announce(out)
    draw(figure, "uncertainty.uncertainty_figure", dataset)
    print_uncertainty(dataset, tornado)


def print_uncertainty(dataset: Any, tornado: bool = False) -> None:
    """Print the verdict on each interface, the tables that it rests on, and what is assumed."""
    print(dataset.attrs["title"])
    print(dataset.attrs["asked"])
    print_pairs([("samples", dataset.attrs["samples"]), ("motions", dataset.attrs["motions"])])
    for name in dataset["interface"].values:
        part = dataset.sel(interface=name)
        print(f"\n{name}\n\n{part['sentence'].item()}\n")
        words = [_samples_words(part)] if "samples_over_target" in part else []
        print("".join(f"  {line}\n" for line in (*words, _parts_words(part), part["narrowing"].item())))
        _print_required(part)
        _print_contact(part)
        _print_parts(part)
        _print_fragilities(part)
        _print_indices(part)
        if tornado:
            _print_tornado(part)
    print_notes(json.loads(dataset.attrs["assumptions"]))
    print_left_out(json.loads(dataset.attrs.get("left_out", "[]")))
    print_flags(json.loads(dataset.attrs.get("flags", "{}")))


def _samples_words(part: Any) -> str:
    from pounding_risk.assessment.options import percent_words

    share, low, high = (float(part[f"samples_over_target{ending}"]) for ending in ("", "_low", "_high"))
    return (
        f"In {_percent(share)} of the samples (bounds {_percent(low)} to {_percent(high)}) P(contact) under these "
        f"motions exceeds {percent_words(float(part.attrs['target']))}."
    )


def _parts_words(part: Any) -> str:
    from pounding_risk.assessment.uncertain_words import parts_words

    return parts_words(part)


def _percent(value: float) -> str:
    from pounding_risk.assessment.verdict import share_words

    return share_words(value)


def _print_required(part: Any) -> None:
    of_samples = ("5 % of samples", "median", "95 %") if "required_gap_of_samples" in part else ()
    head = "nominal gap required by" if _has_scatter(part) else "gap required by"
    heads = (head, "over samples and motions", "bounds", *of_samples)
    rows = []
    for percentile in part["percentile"].values:
        one = part.sel(percentile=percentile)
        high = _length(one["required_gap_high"])
        bound = high if int(one["required_gap_bounded"]) else f"{high} (largest seen)"
        places = (5.0, 50.0, 95.0) if of_samples else ()
        over = [_length(one["required_gap_of_samples"].sel(sample_percentile=at)) for at in places]
        bounds = f"{_length(one['required_gap_low'])} to {bound}"
        rows.append((f"{percentile:g} %", _length(one["required_gap"]), bounds, *over))
    print_table(heads, rows, "lrlrrr"[: len(heads)])
    print()


def _has_scatter(part: Any) -> bool:
    from pounding_risk.assessment.uncertain_words import gap_scatter

    return gap_scatter(part) > 0.0


def _length(value: Any) -> str:
    return engineering(float(value), "m", 3)


def _print_contact(part: Any) -> None:
    """Print P(contact) at a few gaps, the judged one and the scene's own among them."""
    import numpy as np

    size, gaps = part.sizes["gap"], part["gap"].values
    own = [int(np.abs(gaps - float(part[name])).argmin()) for name in ("judged_gap", "scene_gap")]
    places = sorted({*(round(at * (size - 1) / (GAP_ROWS - 1)) for at in range(GAP_ROWS)), *own})
    of_samples = ("5 % of samples", "median", "95 %") if "contact_probability_of_samples" in part else ()
    heads = ("nominal gap" if _has_scatter(part) else "gap", "P(contact)", "bounds", *of_samples)
    rows = []
    for one in (part.isel(gap=place) for place in places):
        ends = (5, 50, 95) if of_samples else ()
        over = [_percent(float(one["contact_probability_of_samples"].sel(sample_percentile=at))) for at in ends]
        low, high = (_percent(float(one[f"contact_probability{ending}"])) for ending in ("_low", "_high"))
        rows.append((_length(one["gap"]), _percent(float(one["contact_probability"])), f"{low} to {high}", *over))
    print_table(heads, rows, "rrlrrr"[: len(heads)])
    print(f"Gaps: {part['gap'].attrs['description']}.")
    if _has_scatter(part):
        print("The gap of each sample departs from a nominal one by the scatter that [uncertain] states.")
    print()


def _print_parts(part: Any) -> None:
    heads = ("part of the variance", "share", "deviation", "bounds")
    unit = str(part["dispersion"].attrs["units"])
    rows = []
    for name in part["component"].values:
        one = part.sel(component=name)
        deviation, low, high = (_value(one[f"dispersion{ending}"], unit) for ending in ("", "_low", "_high"))
        rows.append((str(name), _share(one["variance_share"]), deviation, f"{low} to {high}"))
    print_table(heads, rows, "lrrl")
    print()


def _value(value: Any, unit: str) -> str:
    number = float(value)
    return f"{number:.3g}" if unit == "1" else engineering(number, unit, 3)


def _share(value: Any) -> str:
    number = 100.0 * float(value)
    return "–" if number != number else f"{number:.0f} %"


def _print_fragilities(part: Any) -> None:
    fault = str(part["fragility_fault"].item())
    if fault:
        print(f"no fragilities: {fault}\n")
        return
    heads = (f"fragility against {part['fragility_intensity'].item()}", "median", "bounds", "dispersion", "bounds")
    rows = []
    for name in part["curve"].values:
        one = part.sel(curve=name)
        if name == ALONE and "first_order_of_motions" in part:  # which drawn motions do not show
            continue
        median, *ends = (engineering(float(one[f"fragility_median{end}"]), "m/s2", 3) for end in ("", "_low", "_high"))
        spread, *bounds = (f"{float(one[f'fragility_dispersion{end}']):.3g}" for end in ("", "_low", "_high"))
        rows.append((str(name), median, " to ".join(ends), spread, " to ".join(bounds)))
    print_table(heads, rows, "lrlrl")
    print()


def _print_indices(part: Any) -> None:
    """Print the indices of the output that the sentences are of, the largest first."""
    import numpy as np

    from pounding_risk.assessment.uncertain_words import indices_words

    output = str(part["chosen_output"].item())
    one = part.sel(output=output)
    kinds = ["first_order", *(["total_order"] if "total_order" in part else [])]
    words = {"first_order": "first-order share", "total_order": "total share"}
    heads = [f"number, on {output}", *(head for kind in kinds for head in (words[kind], "bounds"))]
    rows = []
    for place in np.argsort(-np.nan_to_num(one["first_order"].values, nan=-1.0)):
        number = one.isel(uncertain_number=int(place))
        cells = [str(number["uncertain_number"].item())]
        for kind in kinds:
            low, high = (_share(number[f"{kind}{ending}"]) for ending in ("_low", "_high"))
            cells += [_share(number[kind]), f"{low} to {high}"]
        rows.append(cells)
    if "first_order_of_motions" in one:
        value, low, high = (_share(one[f"first_order_of_motions{end}"]) for end in ("", "_low", "_high"))
        rows.append(["the motion", value, f"{low} to {high}"])
    print_table(heads, rows, "l" + "rl" * len(kinds))
    if sentence := indices_words(part):
        print(sentence)
    print()


def _print_tornado(part: Any) -> None:
    """Print the output with each number alone at its 10 % and 90 % quantiles, the widest first."""
    import numpy as np

    output = str(part["chosen_output"].item())
    name = f"{output}_moved"
    if name not in part:
        return
    values, unit = part[name].values, str(part[name].attrs["units"])
    heads = (f"number, on {output}", "at 10 %", "all at medians", "at 90 %")
    say_one = _percent if output == "contact_probability" else lambda one: _value(one, unit)
    rows = [
        (str(part["uncertain_number"].values[place]), *(say_one(one) for one in values[place]))
        for place in np.argsort(-np.ptp(values, axis=1), kind="stable")
    ]
    print_table(heads, rows, "lrrr")
    print()
