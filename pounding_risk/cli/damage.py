"""The command `damage`: fragility of damage states with pounding and without."""

from __future__ import annotations

import json
from math import isnan
from pathlib import Path
from typing import Annotated, Any

from pounding_risk.cli._common.files import FIGURES, announce, draw
from pounding_risk.cli._common.notes import print_notes
from pounding_risk.cli._common.options import (
    NONE,
    Confidence,
    Figure,
    Gmfs,
    Hazard,
    Intensity,
    New,
    Results,
    Select,
    Site,
    at_site,
    chosen_results,
    file_option,
    option,
    out_option,
)
from pounding_risk.render.terminal import engineering, print_table

ORDER = 137


def damage(
    results: Results,
    states: Annotated[
        Path | None, option("File of [[damage]] tables (TOML), in place of those of the scene.", "the scene's")
    ] = None,
    gap: Annotated[str | None, option("One of the grid.", "the nearest to the scene's")] = None,
    contact_model: Annotated[str | None, option("One of the grid.", "the scene's")] = None,
    yield_force: Annotated[str | None, option("One of the grid.", "the nearest to the scene's")] = None,
    method: Annotated[
        str | None, option("stripes, ida or cloud.", "stripes of motions at several levels, else cloud")
    ] = None,
    intensity: Intensity = None,
    at: Annotated[
        str | None, option("Intensity at which probabilities are compared.", "the median without pounding")
    ] = None,
    hazard: Hazard = None,
    gmfs: Gmfs = None,
    site: Site = None,
    confidence: Confidence = "95 %",
    select: Select = NONE,
    out: Annotated[Path | None, out_option("Write the dataset, or a table", ".nc", ".csv")] = None,
    new: New = False,
    figure: Figure = None,
    ida_figure: Annotated[
        Path | None, file_option("Write a figure of demands against intensity", FIGURES, "--ida-figure")
    ] = None,
) -> None:
    """Fragility of damage states with pounding and without."""
    from pounding_risk.assessment.damage import damage as run
    from pounding_risk.ensemble.replacing import check_replaceable

    if out is not None and out.suffix.lower() == ".nc":
        check_replaceable(out, "damage", None, new)
    hazard, gmfs = (at_site(hazard, site), gmfs) if gmfs is None else (hazard, at_site(gmfs, site))
    dataset = run(
        chosen_results(results, select), states=states, gap=gap, contact_model=contact_model, yield_force=yield_force,
        method=method, intensity=intensity, at=at, hazard=hazard, confidence=confidence,
        gmfs=gmfs,
    )  # fmt: skip
    print_damage(dataset)
    _write(dataset, out)
    draw(figure, "damage.damage_figure", dataset)
    draw(ida_figure, "damage.ida_figure", dataset)


def _write(dataset: Any, out: Path | None) -> None:
    """Write the dataset, or its table as CSV."""
    from pounding_risk.assessment.damage_words import damage_table
    from pounding_risk.cli._common.files import write_text
    from pounding_risk.results.files import save

    if out is None:
        return
    if out.suffix.lower() == ".csv":
        write_text(out, damage_table(dataset))
    else:
        save(dataset, out)
        announce(out)


def print_damage(dataset: Any) -> None:
    """Print both curves of each state, what pounding changes, annual rates, and what is told."""
    from pounding_risk.assessment.damage_words import POUNDING, case_words, measure_words

    print(f"{dataset.attrs.get('title', '')}: {case_words(dataset)}\n")
    measure, unit = measure_words(dataset)
    rows = []
    for state in dataset["state"].values:
        for side in POUNDING:
            one = dataset.sel(state=state, pounding=side)
            rows.append(_curve_cells(one, unit))
    heads = ("state", "reached at", "pounding", "reached in", f"median {measure}", "dispersion", "s.e. ln median")
    print_table((*heads, "s.e. disp."), rows, "lllrrrrr")
    print("\nWith pounding over without\n")
    compared = [_ratio_cells(dataset.sel(state=state), unit) for state in dataset["state"].values]
    columns = ("state", "median", "bounds", "at", "P without", "P with", "ratio of P", "bounds")
    print_table(columns, compared, "lrrrrrrr")
    if "annual_rate" in dataset:
        print("\nAnnual rates\n")
        rates = [_rate_cells(dataset.sel(state=state)) for state in dataset["state"].values]
        print_table(("state", "with", "bounds", "without", "bounds", "ratio", "bounds", "left out"), rates, "lrrrrrrr")
        print(
            "left out: the share beyond the ends of the hazard curve, were it continued at the slope of its last rows"
        )
    if "event_probability" in dataset:
        print("\nProbability in an event\n")
        events = [_event_cells(dataset.sel(state=state)) for state in dataset["state"].values]
        print_table(("state", "with", "bounds", "without", "bounds"), events, "lrrrr")
    print(f"\n{dataset.attrs['finding']}\n")
    print_notes(json.loads(dataset.attrs["told"]))


def _curve_cells(one: Any, unit: str) -> tuple[str, ...]:
    return (
        str(one["state"].item()),
        str(one["state_words"].item()),
        str(one["pounding"].item()),
        f"{int(one['reached'].sum())} of {int(one['runs'].sum())}",
        engineering(float(one["median"]), unit, 3),
        *(_number(float(one[name])) for name in ("dispersion", "median_error", "dispersion_error")),
    )


def _ratio_cells(one: Any, unit: str) -> tuple[str, ...]:
    return (
        str(one["state"].item()),
        _number(float(one["median_ratio"])),
        _bounds(one, "median_ratio"),
        engineering(float(one["at_intensity"]), unit, 3),
        *(_number(float(one["probability_at"].sel(pounding=side))) for side in ("without", "with")),
        _number(float(one["probability_ratio_at"])),
        _bounds(one, "probability_ratio_at"),
    )


def _event_cells(one: Any) -> tuple[str, ...]:
    sides = [one.sel(pounding=side) for side in ("with", "without")]
    cells = [(_number(float(side["event_probability"])), _bounds(side, "event_probability")) for side in sides]
    return (str(one["state"].item()), *cells[0], *cells[1])


def _rate_cells(one: Any) -> tuple[str, ...]:
    sides = [one.sel(pounding=side) for side in ("with", "without")]
    rates = [(_number(float(side["annual_rate"])), _bounds(side, "annual_rate")) for side in sides]
    missing = max(float(side["annual_rate_missing"]) for side in sides)
    return (
        str(one["state"].item()),
        *rates[0],
        *rates[1],
        _number(float(one["annual_rate_ratio"])),
        _bounds(one, "annual_rate_ratio"),
        "–" if isnan(missing) else f"{100.0 * missing:.0f} %",
    )


def _number(value: float) -> str:
    return "–" if isnan(value) else f"{value:.3g}"


def _bounds(one: Any, name: str) -> str:
    low, high = (float(one[f"{name}_{end}"]) for end in ("low", "high"))
    return "–" if isnan(low) else f"{low:.2g} to {high:.2g}"
