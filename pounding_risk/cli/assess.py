"""The command `assess`: the verdict on each gap with its evidence, and the tables behind it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.files import draw, write_text
from pounding_risk.cli._common.options import (
    NONE,
    Amplitude,
    Confidence,
    Figure,
    Gmfs,
    Hazard,
    Intensity,
    IntensityLevel,
    JudgedGap,
    Percentile,
    Results,
    Select,
    Site,
    Target,
    TargetRate,
    at_site,
    opened_results,
    out_option,
    read_optional,
)
from pounding_risk.errors import PoundingError
from pounding_risk.render.terminal import print_sheet

ORDER = 130
SAMPLE = "sample"  # the axis of uncertain numbers


def assess(
    results: Results,
    gap: JudgedGap = None,
    percentile: Percentile = None,
    confidence: Confidence = "95 %",
    target: Target = None,
    intensity: Intensity = None,
    pga: Amplitude = None,
    intensity_level: IntensityLevel = None,
    hazard: Hazard = None,
    gmfs: Gmfs = None,
    site: Site = None,
    target_rate: TargetRate = None,
    setback: Annotated[
        bool, typer.Option("--setback", help="Instead: distance of each building from a property line.")
    ] = False,
    select: Select = NONE,
    out: Annotated[Path | None, out_option("Write it all", ".json")] = None,
    figure: Figure = None,
) -> None:
    """Is this gap enough? Probabilities, required gaps, a verdict."""
    from pounding_risk.assessment.annual_rates import read_target_rate
    from pounding_risk.assessment.assess import assess as run
    from pounding_risk.assessment.options import read_criterion
    from pounding_risk.questions.assess import sheet
    from pounding_risk.results.scene_axes import check_settled, open_axes
    from pounding_risk.units import GAP, PGA

    if setback:
        idle = {
            "--gap": gap, "--intensity": intensity, "--hazard": hazard, "--gmfs": gmfs, "--site": site,
            "--target-rate": target_rate, "--figure": figure,
        }  # fmt: skip
        for name, value in idle.items():
            if value is not None:
                raise PoundingError(f"{name}: is not taken with --setback, which no neighbour enters; leave it out")
    hazard, gmfs = (at_site(hazard, site), gmfs) if gmfs is None else (hazard, at_site(gmfs, site))
    criterion = read_criterion(target, percentile, confidence, prefix="--")
    rate = read_target_rate(target_rate, hazard is not None, prefix="--")
    chosen = opened_results(results, select)
    if setback:
        amplitude = {"pga": read_optional("--pga", pga, PGA), "intensity_level": intensity_level}
        return _assess_setbacks(chosen, out, **criterion._asdict(), **amplitude)
    if not isinstance(chosen, Path) and [axis.name for axis in open_axes(chosen)] == [SAMPLE]:
        judged = read_optional("--gap", gap, GAP), read_optional("--pga", pga, PGA)
        if hazard is not None or gmfs is not None:
            option = "--gmfs" if hazard is None else "--hazard"
            raise PoundingError(
                f"{option}: is not joined with samples of uncertain numbers; choose one with --select sample=0"
            )
        return _assess_samples(
            chosen, out, figure, gap=judged[0], pga=judged[1], intensity=intensity, **criterion._asdict()
        )
    if not isinstance(chosen, Path) and open_axes(chosen):
        if hazard is not None or intensity is not None or gmfs is not None:
            check_settled(chosen, str(results))
        judged = read_optional("--gap", gap, GAP), read_optional("--pga", pga, PGA)
        amplitude = {"pga": judged[1], "intensity_level": intensity_level}
        return _assess_along(chosen, out, figure, gap=judged[0], **amplitude, **criterion._asdict())
    assessment = run(
        chosen,
        gap=read_optional("--gap", gap, GAP),
        hazard=hazard,
        **criterion._asdict(),
        intensity=intensity,
        pga=read_optional("--pga", pga, PGA),
        intensity_level=intensity_level,
        target_rate=rate,
        gmfs=gmfs,
    )
    # Files first: a reader of the first lines alone, such as `head`, ends the printing.
    if out is not None:
        write_text(out, json.dumps(assessment.as_dict(), ensure_ascii=False, indent=1) + "\n")
    draw(figure, "assess.assessment_figure", assessment)
    print_sheet(sheet(assessment))


def _assess_setbacks(results: Any, out: Path | None, **options: Any) -> None:
    """Print and write the setback from a property line that each building requires."""
    from dataclasses import asdict

    from pounding_risk.assessment.assess import plain
    from pounding_risk.assessment.setback import ASSUMED, setbacks
    from pounding_risk.questions.setback import sheet

    found = setbacks(results, **options)
    if out is not None:
        facts = plain({"assumed": ASSUMED, "setbacks": [asdict(one) for one in found]})
        write_text(out, json.dumps(facts, ensure_ascii=False, indent=1) + "\n")
    print_sheet(sheet(found))


def _assess_samples(results: Any, out: Path | None, figure: Path | None, **options: Any) -> None:
    """Print what `uncertainty` says of a dataset whose cases lie along samples of uncertain numbers."""
    from pounding_risk.assessment.uncertain import uncertainty
    from pounding_risk.questions.uncertainty import sheet

    if out is not None:
        raise PoundingError(
            f"{out}: samples of uncertain numbers are written by `pounding-risk uncertainty RESULTS -o uncertainty.nc`"
        )
    assessed = uncertainty(results, **options)
    draw(figure, "uncertainty.uncertainty_figure", assessed)
    print_sheet(sheet(assessed))
    print("`pounding-risk uncertainty` has more of this; `--select sample=0` gives the whole assessment of one sample")


def _assess_along(results: Any, out: Path | None, figure: Path | None, **options: Any) -> None:
    """Print, write and draw contact and required gap at every place along the axes."""
    from pounding_risk.assessment.along import IDLE, OWN, assess_along
    from pounding_risk.questions.along import sheet

    assessed = assess_along(results, **options)
    table = assessed.to_dataframe().reset_index()
    if out is not None:
        rows = table.astype(object).where(table.notna(), None).to_dict("records")
        facts = dict(assessed.attrs) | {name: json.loads(assessed.attrs[name]) for name in (OWN, IDLE)}
        write_text(out, json.dumps(facts | {"places": rows}, ensure_ascii=False, indent=1) + "\n")
    draw(figure, "along.along_figure", assessed)
    print_sheet(sheet(assessed))
