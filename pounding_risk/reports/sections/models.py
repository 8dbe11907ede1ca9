"""What was found beside the adequacy of the gap: contact models compared, how exact numbers are, what effects do."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.assessment.sensitivity import force_words
from pounding_risk.figures.report import Spread, report_models, svg_text
from pounding_risk.reports.blocks import (
    SHOWN,
    Block,
    Cell,
    amount,
    count,
    facts,
    figure,
    head,
    heading,
    listing,
    middle,
    name_of,
    number,
    paragraph,
    percentiles,
    rounded,
    table,
)
from pounding_risk.reports.material import Material, Pair

if TYPE_CHECKING:
    import xarray as xr

FIRST_OUTPUTS = 4  # of a comparison, which has the most telling ones first
# Outputs by which models are set side by side: what they are called, and their unit.
BY_MODEL = {
    "peak_relative_displacement": ("peak relative displacement", "m"),
    "peak_contact_force": ("peak contact force", "N"),
    "impact_count": ("contacts", "1"),
}
MOVED = {
    "change_peak_relative_displacement": "peak relative displacement",
    "change_peak_contact_force": "peak contact force",
}
COUNTED = {"change_impact_count": "impact count", "change_yield_exceedance": "yield exceedance"}
EFFECTS_FREE = "none"  # the scene without effects, in a dataset of `effects`


def models(material: Material) -> list[Block]:
    """Every contact model at the scene's gap: shares of contact and yielding, and the spread of three outputs."""
    blocks: list[Block] = []
    for pair in material.pairs:
        blocks += _by_model(material, pair)
    if len(material.laws) == 1 and "compare" not in material.others:
        other = "more of them under contact_model of the grid" if material.is_row else "`pounding-risk compare`"
        blocks.append(paragraph(f"One contact model was run. Whether another says otherwise: {other}."))
    if "compare" in material.others:
        blocks += _compared(material.others["compare"])
    return blocks


def _by_model(material: Material, pair: Pair) -> list[Block]:
    here = pair.results.sel(gap=pair.grid_gap, yield_force=material.yield_force)
    # A count of −1 is none: the run failed.
    touching = here["impact_count"] > 0
    where = f"at a gap of {amount(pair.grid_gap, 'm')['text']}, {force_words(material.yield_force)}{pair.at}"
    heads = [("contact model", "l"), ("cases", "r"), ("with contact", "r"), ("reach F_E", "r")]
    heads += [(f"{head(words, unit)}: median (16 to 84 %)", "r") for words, unit in BY_MODEL.values()]
    rows: list[list[Cell | str]] = []
    panels: dict[str, list[Spread]] = {name: [] for name in BY_MODEL}
    for law in material.laws:
        one, mine = here.sel(contact_model=law), touching.sel(contact_model=law).values
        ended = one["impact_count"].values >= 0
        cells: list[Cell | str] = [name_of(law), count(ended.sum()), count(mine.sum())]
        # An instant jump has no force that could reach F_E or not.
        reached = one["yield_exceedance"].values
        cells.append(count((reached == 1).sum()) if (reached >= 0).any() else number(np.nan))
        for name, (_, unit) in BY_MODEL.items():
            spread = percentiles(one[name].values[mine])
            panels[name].append(Spread(name_of(law), *spread))
            cells.append(middle(spread, unit))
        rows.append(cells)
    note = f"All motions {where}; the spread is over those with contact."
    drawn = [(head(words, unit), _in_units(panels[name], unit)) for name, (words, unit) in BY_MODEL.items()]
    known = [(words, spreads) for words, spreads in drawn if any(np.isfinite(each.middle) for each in spreads)]
    blocks = [table(f"{pair.name}: outputs by contact model. {note}", heads, rows)]
    if known and len(rows) > 1:
        outputs = ", ".join(words for words, _ in known)
        said = f"{pair.name}: median and middle 68 % of {outputs} under {len(rows)} contact models"
        blocks.append(
            figure(
                f"{pair.anchor}-models",
                svg_text(report_models(known)),
                f"{said}, {where}.",
                f"{said}, {where}; the table above has the numbers.",
            )
        )
    return blocks


def _in_units(spreads: list[Spread], unit: str) -> list[Spread]:
    size = SHOWN[unit][1]
    return [Spread(each.name, each.low * size, each.middle * size, each.high * size) for each in spreads]


def _compared(dataset: xr.Dataset) -> list[Block]:
    """The finding of `compare`, and each law's ratios and changed conclusions."""
    baseline = str(dataset.attrs["baseline"])
    outputs = [str(name) for name in dataset["output"].values[:FIRST_OUTPUTS]]
    conclusions = [str(name) for name in dataset["conclusion"].values]
    ratios: list[list[Cell | str]] = []
    differing: list[list[Cell | str]] = []
    for law in map(str, dataset["contact_model"].values):
        one = dataset.sel(contact_model=law)
        counts = [(one["flips"].sel(conclusion=name), one["judged"].sel(conclusion=name)) for name in conclusions]
        ratios.append([name_of(law), *(_ratio(one.sel(output=name)) for name in outputs)])
        differing.append([name_of(law), *(_of(*count) for count in counts)])
    return [
        heading("On equal terms", "equal-terms"),
        paragraph(str(dataset.attrs["finding"])),
        paragraph(f"From `pounding-risk compare` of “{dataset.attrs['title']}”."),
        table(
            f"Ratio to {name_of(baseline)}: median (16 to 84 %) over the cases in which that has contact.",
            [("contact model", "l"), *((name, "r") for name in outputs)],
            ratios,
        ),
        table(
            f"In how many of the judged cases a conclusion differs from that under {name_of(baseline)}.",
            [("contact model", "l"), *((name, "r") for name in conclusions)],
            differing,
        ),
    ]


def _ratio(one: Any) -> Cell:
    low, median, high = (float(one[f"ratio_{each}"]) for each in ("low", "median", "high"))
    return middle((low, median, high), "1")


def _of(count: Any, judged: Any) -> Cell:
    return {"text": f"{int(count)} of {int(judged)}", "parts": [float(count), float(judged)]}


def accuracy(material: Material) -> list[Block]:
    """The tolerance, the runs made again and how far they moved, energy left over, and runs that failed."""
    results = material.results
    simulated = int((results["simulated"] == 1).sum())
    total = results["status"].size
    told: list[tuple[str, Cell | str]] = [
        ("relative tolerance of the solver", number(results.attrs["rtol"])),
        ("cases", count(total)),
        ("with a run of their own", count(simulated)),
        ("known exactly without one", count(total - simulated)),
        *_again(results),
        *_residuals(results),
        *_failed(results),
    ]
    blocks = [
        facts("Tolerance, runs made again, energy and failures.", told),
        paragraph(
            "Between contacts the motion is exact for a ground acceleration that is linear between samples; in contact "
            "the integration keeps the tolerance and lands on every event. A case without a run of its own has exactly "
            "the answer of another, such as the motion without contact."
        ),
    ]
    if "accuracy" in material.others:
        blocks += _ladder(material.others["accuracy"])
    return blocks


def _again(results: xr.Dataset) -> list[tuple[str, Cell | str]]:
    """What was made again at a tighter tolerance, and how far it moved."""
    if "sensitive" not in results or not (results["sensitive"] >= 0).any():
        return [("made again at a tighter tolerance", "none")]
    flags = results["sensitive"]
    told: list[tuple[str, Cell | str]] = [
        ("made again at a tighter tolerance", count((flags >= 0).sum())),
        ("of these sensitive: an answer moves by more than the tolerance", count((flags == 1).sum())),
    ]
    for name, words in MOVED.items():
        values = results[name].values
        values = values[np.isfinite(values)]
        if values.size:
            told.append((f"{words} moved by, median", number(np.median(values), digits=2)))
            told.append((f"{words} moved by, largest", number(values.max(), digits=2)))
    told += [(f"runs whose {words} changed", count((results[name] > 0).sum())) for name, words in COUNTED.items()]
    return told


def _residuals(results: xr.Dataset) -> list[tuple[str, Cell | str]]:
    """Energy that contacts leave unaccounted for, over the runs of their own that touched."""
    if "energy_residual" not in results:
        return []
    own = ((results["simulated"] == 1) & (results["impact_count"] > 0)).values
    values = results["energy_residual"].values[own]
    values = values[np.isfinite(values)]
    if not values.size:
        return []
    words = "energy that a run's contacts leave unaccounted for, over the largest energy"
    return [
        (f"{words}, median", number(np.median(values), digits=2)),
        ("the same, largest", number(values.max(), digits=2)),
    ]


def _failed(results: xr.Dataset) -> list[tuple[str, Cell | str]]:
    """Runs that did not complete, by what happened to them."""
    status = results["status"]
    codes = np.atleast_1d(status.attrs.get("flag_values", []))
    meanings = str(status.attrs.get("flag_meanings", "")).split()
    counts = [
        (f"failed: {slug.replace('_', ' ')}", int((status.values == code).sum()))
        for code, slug in zip(codes, meanings, strict=True)
        if code != 0
    ]
    found: list[tuple[str, Cell | str]] = [(words, count(times)) for words, times in counts if times]
    return found or [("failed", count(0))]


def _ladder(dataset: xr.Dataset) -> list[Block]:
    """What each digit costs: this solver's settings from a dataset of `accuracy`."""
    heads = [
        ("setting", "l"),
        ("time a run [ms]", "r"),
        ("peak displacement off by, worst", "r"),
        ("peak force off by, worst", "r"),
    ]
    rows: list[list[Cell | str]] = []
    for setting in map(str, dataset["setting"].values):
        one = dataset.sel(setting=setting)
        outputs = ("peak_relative_displacement", "peak_contact_force")
        time = float(one["time"].sel(output=outputs[0]))
        errors = [one["error"].sel(output=name).values for name in outputs]
        worst = [each[~np.isnan(each)].max(initial=-np.inf) for each in errors]
        if all(np.isfinite(worst)):
            shown = {"text": rounded(time * 1e3, 3), "raw": time}
            rows.append([setting, shown, *(number(each, digits=2) for each in worst)])
    return [
        heading("What accuracy costs", "accuracy-cost"),
        paragraph(str(dataset.attrs["finding"])),
        paragraph(f"From `pounding-risk accuracy` of “{dataset.attrs['title']}”, {dataset.sizes['case']} cases."),
        table("Time and largest error against the reference, by method and setting.", heads, rows),
    ]


def effects(material: Material) -> list[Block]:
    """The effects that the scene names, and what each changes and costs where a dataset of `effects` tells."""
    named = material.scene.get("effects", {})
    blocks: list[Block]
    if named:
        blocks = [listing(f"{name_of(name)}: {_options(options)}" for name, options in named.items())]
    else:
        blocks = [
            paragraph("The scene names no effects, and none was simulated: no dents, no strain rate, no passing wave.")
        ]
    if "effects" not in material.others:
        blocks.append(paragraph("What each effect would change and cost: `pounding-risk effects`, given with --with."))
        return blocks
    return blocks + _costs(material.others["effects"])


def _options(options: dict[str, Any]) -> str:
    return ", ".join(f"{key} {value}" for key, value in options.items()) or "no options"


def _named(effects: str) -> str:
    """The effects of an attribute (JSON) with their options."""
    return "; ".join(f"{name_of(name)} ({_options(options)})" for name, options in json.loads(effects).items())


def _costs(dataset: xr.Dataset) -> list[Block]:
    heads = [
        ("effects", "l"),
        ("time of a run [ms]", "r"),
        ("over that without", "r"),
        ("median change of the peak displacement [%]", "r"),
    ]
    rows: list[list[Cell | str]] = []
    output = "peak_relative_displacement"
    yields = dataset["yield_exceedance"].sel(effects=EFFECTS_FREE).values == 1
    before = dataset[output].sel(effects=EFFECTS_FREE).values
    for name in map(str, dataset["effects"].values):
        one = dataset.sel(effects=name)
        acted = (yields | bool(one["acts_on_all"])) & (before > 0.0)
        change = (one[output].values[acted] - before[acted]) / before[acted]
        change = change[np.isfinite(change)]
        time = float(one["time"])
        change_words = number(np.median(change), "%", 3) if name != EFFECTS_FREE and change.size else number(np.nan)
        rows.append(
            [
                name_of(name),
                {"text": rounded(time * 1e3, 3), "raw": time},
                number(one["time_ratio"], digits=3),
                change_words,
            ]
        )
    return [
        heading("What they change and cost", "effects-cost"),
        paragraph(str(dataset.attrs["finding"])),
        paragraph(f"From `pounding-risk effects` of “{dataset.attrs['title']}”: {_named(dataset.attrs['effects'])}."),
        table("Processor time of a run, and the change in the cases that the effects act on.", heads, rows),
    ]
