"""The command `damage`: fragility of damage states with pounding and without."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pounding_risk.cli._common.files import FIGURES, announce, draw
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
from pounding_risk.render.terminal import print_sheet

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
    from pounding_risk.questions.damage import sheet

    if out is not None and out.suffix.lower() == ".nc":
        check_replaceable(out, "damage", None, new)
    hazard, gmfs = (at_site(hazard, site), gmfs) if gmfs is None else (hazard, at_site(gmfs, site))
    dataset = run(
        chosen_results(results, select), states=states, gap=gap, contact_model=contact_model, yield_force=yield_force,
        method=method, intensity=intensity, at=at, hazard=hazard, confidence=confidence,
        gmfs=gmfs,
    )  # fmt: skip
    print_sheet(sheet(dataset))
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
