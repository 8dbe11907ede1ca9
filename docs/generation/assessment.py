"""The page of what `assess` and `separations` give, from the classes' fields and docstrings."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from generation.markdown import docstring, plain
from pounding_risk.assessment import assess as assessment
from pounding_risk.assessment import fragility, hazard, proportions
from pounding_risk.assessment import required_gap as required_gaps
from pounding_risk.assessment import sensitivity as influences
from pounding_risk.assessment import verdict as verdicts
from pounding_risk.assessment.separations import table as separations

HEAD = """# Assessment

What `pr.assess(results)` and `pr.code_table(results)` give, and `pounding-risk assess -o assessment.json` writes:
tables of these fields, with null where there is no number. [How they are found](../theory/gap.md).

"""
PARTS = (
    assessment.Assessment,
    assessment.InterfaceAssessment,
    verdicts.Verdict,
    verdicts.Governing,
    proportions.Share,
    influences.Response,
    required_gaps.RequiredGap,
    fragility.Fragility,
    fragility.Stripe,
    hazard.Rate,
    influences.Influence,
    separations.Comparison,
    separations.SeparationRow,
    separations.CodeTable,
)


def assessment_page() -> str:
    """Every class of an assessment, and the rule of its verdict."""
    return (
        f"{HEAD}## The verdict's rule\n\n{docstring(verdicts)}\n{''.join(map(_part, PARTS))}"
        f"## Standard errors\n\n{docstring(fragility.Fit)}"
    )


def _part(kind: Any) -> str:
    told = ", ".join(f"`{each.name}` {plain(str(each.type))}" for each in fields(kind))
    return f"## {kind.__name__}\n\n{docstring(kind)}\nFields: {told}.\n\n"
