"""Section on rates: how often contact and yielding come under a hazard curve."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pounding_risk.reports.blocks import (
    Block,
    Cell,
    amount,
    between,
    head,
    heading,
    name_of,
    number,
    paragraph,
    strength,
    table,
)
from pounding_risk.reports.data import Pair, ReportData

if TYPE_CHECKING:
    from pounding_risk.assessment.hazard import Rate

TITLE = "How often do they touch?"
ORDER = 45
ACCELERATION = "m/s2"


def write(data: ReportData) -> list[Block]:
    """Blocks of every interface, where a hazard curve is given."""
    blocks: list[Block] = []
    for pair in data.pairs:
        rates = _rates(data, pair)
        if rates and len(data.pairs) > 1:
            blocks.append(heading(pair.name, f"{pair.anchor}-rates"))
        blocks += rates
    return blocks


def _rates(data: ReportData, pair: Pair) -> list[Block]:
    """Table of annual rates and 50-year probabilities, where a hazard curve is given."""
    rates = [rate for rate in pair.assessed.rates if np.isfinite(rate.annual)]
    if not rates:
        return []
    heads = [("of", "l"), (head("gap", "m"), "r"), ("contact model", "l"), (head("F_E", "N"), "r")]
    heads += [("a year", "r"), ("bounds", "r"), ("in 50 years [%]", "r"), ("P at the weakest [%]", "r")]
    heads += [("left out [%]", "r")]
    rows: list[list[Cell | str]] = [
        [
            rate.what,
            number(rate.gap, "m"),
            _model(rate),
            strength(rate.yield_force),
            _at_least(number(rate.annual, digits=3), rate),
            between(rate.low, rate.high, "1", 3),
            _at_least(number(rate.fifty_years, "%", 3), rate),
            number(rate.below, "%", 2),
            number(rate.missing, "%", 2),
        ]
        for rate in rates
    ]
    source, curve = data.assessment.hazard, data.assessment.hazard_rows
    weakest, strongest = (amount(im, ACCELERATION)["text"] for im in (curve[0][0], curve[-1][0]))
    stronger = number(curve[-1][1], digits=3)["text"]
    is_cut = any(rate.at_least for rate in rates)
    least = "Where a rate is at least so much, the curve ends where failures do not. " if is_cut else ""
    explained = (
        f"Rates count motions from {weakest} to {strongest}, the range of the curve. {least}Left out is the share of "
        "the failures beyond the curve's ends, were it continued at the slope of its last rows; stronger motions add "
        f"at most {stronger} a year, and of weaker ones the curve says nothing. Bounds carry the fragility's standard "
        "errors and nothing of the curve's own uncertainty."
    )
    return [table(f"{pair.name}: annual rate under the hazard curve {source}.", heads, rows), paragraph(explained)]


def _at_least(cell: Cell, rate: Rate) -> Cell:
    """The cell of a rate, with "at least" where the number is only a lower bound."""
    return {**cell, "text": f"at least {cell['text']}"} if rate.at_least else cell


def _model(rate: Rate) -> str:
    """The contact model of a rate; contact itself depends on none."""
    return name_of(rate.contact_model) if rate.contact_model else "any"
