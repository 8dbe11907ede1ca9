"""Section on effects: those that the scene names, and the sheet of `effects`."""

from __future__ import annotations

from pounding_risk.questions.effects import options_words, sheet
from pounding_risk.render.sheet import Block, heading, listing, name_of, paragraph
from pounding_risk.reports.data import ReportData

TITLE = "Effects"
ORDER = 90


def write(data: ReportData) -> list[Block]:
    """The effects that the scene names, and what each changes and costs where a dataset of `effects` is given."""
    named = data.scene.get("effects", {})
    blocks: list[Block]
    if named:
        blocks = [listing(f"{name_of(name)}: {options_words(options)}" for name, options in named.items())]
    else:
        blocks = [
            paragraph("The scene names no effects, and none was simulated: no dents, no strain rate, no passing wave.")
        ]
    if "effects" not in data.others:
        blocks.append(paragraph("What each effect would change and cost: `pounding-risk effects`, given with --with."))
        return blocks
    return [*blocks, heading("What they change and cost", "effects-cost"), *sheet(data.others["effects"])]
