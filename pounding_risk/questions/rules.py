"""Blocks of `assess` on code rules: what each requires beside the gaps that the same motions need."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pounding_risk.assessment.separations.rules import FROM_MEMORY, ONE_GROUND, OWN_PEAKS, QUOTED_ONLY, RATIONAL, SHARED
from pounding_risk.assessment.separations.table import short_in
from pounding_risk.questions.adequacy import Row
from pounding_risk.render.sheet import MISSING, Block, Cell, head, middle, number, out_of, paragraph, table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from pounding_risk.assessment.assess import InterfaceAssessment
    from pounding_risk.assessment.separations.table import Comparison

DOUBTS = (FROM_MEMORY, QUOTED_ONLY, ONE_GROUND)


def rules(percentile: float, one: InterfaceAssessment) -> list[Block]:
    """What the rules of building codes require, motion by motion, over the gap that the motion needs."""
    bumper = max((rule.bumper for rule in one.separations), default=0.0)
    motions = sum(closing > bumper for closing in one.closing)
    compared = [at for at, rule in enumerate(one.separations) if rule.exceeded is not None]
    notes = [rule.row.note for rule in one.separations]
    # The parts that every note of a separation has are written once, above the table.
    parts = [rule.row.note.split("; ") for rule in one.separations if rule.row.separation is not None]
    common = [part for part in parts[0] if all(part in others for others in parts)] if parts else []
    sentences = [
        short_in(one.separations, motions),
        *(f"Everywhere {note}" for note in common if note not in DOUBTS),
        *(SHARED[doubt] for doubt in DOUBTS if any(doubt in note for note in notes)),
        RATIONAL,
        "Insufficient for: motions that need more than the rule requires from them",
        "`separations` lists who quotes the clauses, and applies the rules to design displacements",
    ]
    heads = ["rule", "clause", "text of the clause", head("median", "m"), head(f"{percentile:g} %", "m")]
    heads += ["rule / gap required: median (16 to 84 %)", "insufficient for", f"gap / rule at {percentile:g} %", "note"]
    rows = [_rule_cells(rule, one.gap, motions, common) for rule in one.separations]
    caption = f"{one.name}: separations that rules require, {OWN_PEAKS}."
    return [
        paragraph(" ".join(f"{sentence}." for sentence in sentences)),
        table(caption, heads, rows, keep=compared or None, note="those that give a separation" if compared else ""),
    ]


def _rule_cells(rule: Comparison, gap: float, motions: int, common: Sequence[str]) -> Row:
    row = rule.row
    elsewhere = {*common, *DOUBTS}  # above the table, and in its column of texts
    note = "; ".join(part for part in row.note.split("; ") if part not in elsewhere) or MISSING
    over = number((gap - rule.bumper) / rule.upper, digits=3) if rule.exceeded is not None and rule.upper else MISSING
    return [row.title, row.clause, row.verification, *compared(rule, motions), over, note]


def compared(rule: Comparison, motions: int) -> Row:
    """Separations of a rule, their ratio to the gap needed, and for how many motions the rule is insufficient."""
    if rule.exceeded is None:
        return [length(rule.row.separation), MISSING, MISSING, MISSING]
    low, median, high = (value or 0.0 for value in (rule.ratio_low, rule.ratio_median, rule.ratio_high))
    short = out_of(round(rule.exceeded * motions), motions)
    return [number(rule.middle, "m"), number(rule.upper, "m"), middle((low, median, high), "1"), short]


def length(value: float | None) -> Cell | str:
    """A length [m] in the unit of the column's head; – for none."""
    return MISSING if value is None else number(value, "m")
