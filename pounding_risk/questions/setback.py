"""Sheet of `assess --setback`: the distance from a property line that each building requires."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pounding_risk.assessment.options import NO_LOWER, NO_UPPER
from pounding_risk.assessment.setback import ASSUMED
from pounding_risk.questions.adequacy import bounds_cell, enough, marks
from pounding_risk.render.sheet import Block, head, listing, number, table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from pounding_risk.assessment.setback import Setback

NO_BOUND = {
    NO_LOWER: "no lower bound above 0",
    NO_UPPER: "the upper one is the largest seen: so few recordings do not bound this percentile",
}


def sheet(found: Sequence[Setback]) -> list[Block]:
    """Table of the setbacks by percentile, and what they take for granted.

    Parameters
    ----------
    found : sequence of Setback
        An answer of `setbacks`.
    """
    heads = ["building", "sufficient for [%]", head("setback", "m")]
    heads += [head("bounds by recording", "m")]
    every = [(one.building, required) for one in found for required in one.required]
    rows = [[name, number(each.percentile), enough(each.gap), bounds_cell(each)] for name, each in every]
    explained = [*marks((each for _, each in every), NO_BOUND), *(f"{sentence}." for sentence in ASSUMED)]
    return [
        table(f"Setback from a property line, {found[0].motions} motions {found[0].at}.", heads, rows),
        listing(explained, mark=""),
    ]
