"""Section on uncertain numbers: what a dataset of `uncertainty` says of them, beside the scan of the stated ones."""

from __future__ import annotations

from pounding_risk.questions.uncertainty import sheet
from pounding_risk.render.sheet import Block
from pounding_risk.reports.data import ReportData

TITLE = "Uncertain numbers"
ORDER = 48


def write(data: ReportData) -> list[Block]:
    """The sheet of `uncertainty`; nothing without a dataset of it."""
    return sheet(data.others["uncertainty"], tornado=True) if "uncertainty" in data.others else []
