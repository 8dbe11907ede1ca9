"""Section on the axes of numbers of the scene: contact and the gap required along them, and what the rest is of."""

from __future__ import annotations

from pounding_risk.assessment.along import along_finding
from pounding_risk.figures.along import along_caption, along_figure
from pounding_risk.figures.style import svg_text
from pounding_risk.questions.along import findings, places
from pounding_risk.render.sheet import Block, figure, paragraph
from pounding_risk.reports.data import ReportData

TITLE = "Along the axes of the scene"
ORDER = 5


def write(data: ReportData) -> list[Block]:
    """Finding, figure and table; nothing where the dataset has one place along every axis."""
    if data.along is None:
        return []
    assessed, place = data.along
    sentences = [
        *findings(assessed),
        f"The other sections are of one place, {place.words}: {place.why}.",
    ]
    return [
        paragraph(" ".join(sentences)),
        figure(
            "along-axes",
            svg_text(along_figure(assessed, titled=False)),
            f"{along_caption(assessed)}.",
            f"P(contact) and the gap required along the axes. {along_finding(assessed)}. The table has the numbers.",
        ),
        places(assessed),
    ]
