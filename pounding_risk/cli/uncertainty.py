"""The command `uncertainty`: contact and required gaps over samples of uncertain numbers, and which numbers matter."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.files import announce, draw
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
from pounding_risk.render.terminal import print_sheet

ORDER = 135
SCENE = ".toml"


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
    from pounding_risk.questions.uncertainty import sheet
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
    print_sheet(sheet(dataset, tornado=tornado))
