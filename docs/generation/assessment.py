"""The page of what `assess` and `separations` give, from the classes' fields and docstrings."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from generation.markdown import docstring, plain
from pounding_risk.assessment import (
    assess,
    fragility,
    hazard,
    rates,
    sensitivity,
    verdict,
)
from pounding_risk.assessment.separations import table as separations
from pounding_risk.questions.setback import Setback
from pounding_risk.statistics import fragility as fits
from pounding_risk.statistics import proportions, required_gap

HEAD = """# Assessment

What `pr.assess(results)` and `pr.code_table(results)` give, and `pounding-risk assess -o assessment.json` writes:
tables of these fields, with null where there is no number. [How they are found](../theory/gap.md).

"""
PARTS = (
    assess.Assessment,
    assess.InterfaceAssessment,
    verdict.Verdict,
    verdict.Governing,
    proportions.Share,
    sensitivity.Response,
    required_gap.RequiredGap,
    fragility.Fragility,
    fits.Stripe,
    hazard.Rate,
    rates.GapForRate,
    rates.RateVerdict,
    sensitivity.Influence,
    separations.Comparison,
    separations.SeparationRow,
    separations.CodeTable,
    Setback,
)


def assessment_page() -> str:
    """Every class of an assessment, and the rule of its verdict."""
    return (
        f"{HEAD}## The verdict's rule\n\n{docstring(verdict)}\n{''.join(map(_part, PARTS))}"
        f"## Standard errors\n\n{docstring(fits.Fit)}"
    )


def _part(kind: Any) -> str:
    listed = ", ".join(f"`{field.name}` {plain(str(field.type))}" for field in fields(kind))
    return f"## {kind.__name__}\n\n{docstring(kind)}\nFields: {listed}.\n\n"
