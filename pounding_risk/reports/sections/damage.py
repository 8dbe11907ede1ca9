"""Section on damage: fragilities of the scene's damage states with pounding and without."""

from __future__ import annotations

from pounding_risk.errors import PoundingError
from pounding_risk.questions.damage import sheet
from pounding_risk.render.sheet import Block, paragraph
from pounding_risk.reports.data import ReportData

TITLE = "Damage"
ORDER = 65


def write(data: ReportData) -> list[Block]:
    """The sheet of `damage` at the report's intensity, confidence and hazard; none where the scene has no states."""
    if "damage" not in data.scene:
        return []
    from pounding_risk.assessment.damage import (
        damage,  # with the reader of states, which a report without them needs not
    )

    same = data.assessment
    try:
        answer = damage(data.results, intensity=same.intensity, hazard=same.hazard_curve, confidence=same.confidence)
    except PoundingError as error:
        return [paragraph(f"The damage states of the scene have no fragilities: {error}.")]
    return sheet(answer)
