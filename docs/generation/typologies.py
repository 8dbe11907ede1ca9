"""The page of typologies, from their registry."""

from __future__ import annotations

from generation.markdown import docstring, plain, table
from pounding_risk.models.structures import typologies
from pounding_risk.models.structures.storeys import generated
from pounding_risk.models.structures.typologies import TYPOLOGIES


def typologies_page() -> str:
    """Every typology: period, mode shape, yield accelerations, and whether its clause was verified."""
    heads = ("typology", "what", "T [s], h in m", "mode shape", "yields at [g]", "verified", "clause")
    rows = [
        (
            f"`{kind.name}`",
            plain(kind.words),
            plain(kind.period_words),
            plain(kind.shape_words),
            plain(kind.yield_words),
            "yes" if kind.code.verified else "**NO**",
            plain(f"{kind.code.reference}; {kind.code.source}"),
        )
        for kind in TYPOLOGIES.values()
    ]
    text = f"# Typologies\n\n{docstring(typologies)}\n{table(heads, rows)}\n"
    return text + f"## How a building is generated\n\n{docstring(generated)}\n"
