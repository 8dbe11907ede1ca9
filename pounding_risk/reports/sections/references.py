"""Section on references: where contact laws, effects and rules of codes are from."""

from __future__ import annotations

from pounding_risk.assessment.separations.rules import RULES, SUPERSEDED
from pounding_risk.render.sheet import Block, listing, paragraph
from pounding_risk.reports.data import ReportData

TITLE = "References"
ORDER = 100


def write(data: ReportData) -> list[Block]:
    """The sources of the contact laws and effects that took part, and of the rules of codes."""
    sources = [source.strip() for source in str(data.results.attrs.get("references", "")).split(";")]
    return [
        paragraph("Contact laws and effects of this study:"),
        listing(dict.fromkeys(source for source in sources if source)),
        paragraph(
            "Rules of codes: clause, formula, how its text is known, and later editions as far as known here. "
            f"{SUPERSEDED}:"
        ),
        listing(_rules()),
    ]


def _rules() -> list[str]:
    rules = []
    for rule in RULES.values():
        basis = f"{rule.verification}: {rule.source}" if rule.source else rule.verification
        later = f"; superseded by {rule.superseded}" if rule.superseded else ""
        level = f"; ground motion from memory: {rule.level}" if rule.level else ""
        holds = f"; in force: {rule.in_force}" if rule.in_force else ""
        rules.append(f"{rule.title}: {rule.clause}; {rule.formula}; {basis}{level}{later}{holds}.")
    return rules
