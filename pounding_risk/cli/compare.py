"""The command `compare`: a scene under many contact models on equal terms."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from pounding_risk.cli._common.files import announce, draw
from pounding_risk.cli._common.options import (
    NONE,
    RUN_FAILED,
    Dataset,
    Figure,
    New,
    Overrides,
    Scene,
    Select,
    Strict,
    chosen_scene,
    option,
    read_optional,
)
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.render.terminal import print_sheet

ORDER = 60


def compare(
    scene: Scene,
    out: Dataset = None,
    overrides: Overrides = NONE,
    law: Annotated[list[str] | None, option("Contact model; repeat for several.", "the grid's, or all")] = None,
    baseline: Annotated[str | None, option("The law to set the others beside.", "the interface's")] = None,
    same: Annotated[str | None, option("Calibrate to equal: peak force, or penetration.", "peak force")] = None,
    speed: Annotated[str | None, option("Approach speed of the reference impact.", "0.5 m/s")] = None,
    relation: Annotated[str | None, option("Damping from e: exact, so that e is equal, or published.", "exact")] = None,
    interface: Annotated[
        str | None, option("Of a row, whose tables: left | right.", "where the laws differ most")
    ] = None,
    select: Select = NONE,
    new: New = False,
    figure: Figure = None,
    strict: Strict = False,
) -> None:
    """Run a scene under many contact models on equal terms."""
    from pounding_risk.questions.compare import sheet
    from pounding_risk.results.summary import failures
    from pounding_risk.studies.compare import compare as run
    from pounding_risk.studies.compare_along import check_drawn, is_along
    from pounding_risk.studies.compare_findings import index_of_interface
    from pounding_risk.units import SPEED

    terms: dict[str, Any] = {"same": same, "speed": read_optional("--speed", speed, SPEED), "relation": relation}
    study = chosen_scene(scene, overrides, select)
    if interface is not None:
        index_of_interface(study.interface_names, interface)
    if figure is not None:
        check_drawn(study.axes, "--figure")
    with ProgressDisplay("compare") as progress:
        dataset = run(study, out, laws=law or (), baseline=baseline, **terms, new=new, progress=progress)
    print_sheet(sheet(dataset, interface))
    announce(out)
    if is_along(dataset):
        draw(figure, "compare.agreement_along_figure", dataset, interface=interface)
    else:
        draw(figure, "compare.agreement_figure", dataset, interface=interface)
        impacts = figure and figure.with_stem(f"{figure.stem}-impacts")
        draw(impacts, "compare.reference_figure", dataset, interface=interface)
    if strict and failures(dataset):
        raise typer.Exit(RUN_FAILED)
