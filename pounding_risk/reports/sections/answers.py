"""Sections that show one answer each: its sheet, and what the report adds to it.

Every row of `ROWS` is a section: its name, its place in the report, its title, and the function that makes its blocks.
"""

from __future__ import annotations

from functools import partial
from typing import Any

from pounding_risk.assessment.along import along_finding
from pounding_risk.assessment.separations.rules import RULES, SUPERSEDED
from pounding_risk.errors import PoundingError
from pounding_risk.figures.along import along_caption, along_figure
from pounding_risk.figures.assess import draw_rates
from pounding_risk.figures.style import panel
from pounding_risk.questions import along, damage, effects, rates
from pounding_risk.questions.adequacy import enough
from pounding_risk.render.sheet import Block, figure, heading, listing, name_of, paragraph
from pounding_risk.reports.data import Pair, ReportData


def _along(data: ReportData) -> list[Block]:
    """Contact and the gap required along the axes, and which place the rest is of; nothing with one place alone."""
    if data.along is None:
        return []
    assessed, place = data.along
    place_text = f"The other sections are of one place, {place.words}: {place.why}."
    alt = f"P(contact) and the gap required along the axes. {along_finding(assessed)}. The table has the numbers."
    return [
        paragraph(" ".join([*along.findings(assessed), place_text])),
        figure("along-axes", partial(along_figure, assessed, titled=False), f"{along_caption(assessed)}.", alt),
        along.places(assessed),
    ]


def _uncertainty(data: ReportData) -> list[Block]:
    """The sheet of `uncertainty`; nothing without a dataset of it."""
    if "uncertainty" not in data.others:
        return []
    from pounding_risk.questions import uncertainty  # with the scene's checks, which a report without needs not

    return uncertainty.sheet(data.others["uncertainty"], tornado=True)


def _damage(data: ReportData) -> list[Block]:
    """The sheet of `damage` at the report's intensity, confidence and hazard; none where the scene has no states."""
    if "damage" not in data.scene:
        return []
    same = data.assessment
    options: dict[str, Any] = {"intensity": same.intensity, "hazard": same.hazard_curve, "confidence": same.confidence}
    try:
        answer = damage.damage(data.results, **options)
    except PoundingError as error:
        return [paragraph(f"The damage states of the scene have no fragilities: {error}.")]
    return damage.sheet(answer)


def _rates(data: ReportData) -> list[Block]:
    """How often contact and yielding come under a hazard curve or in an event, by interface; nothing without these."""
    assessment, blocks = data.assessment, []
    for pair in data.pairs:
        verdict = pair.assessed.rate_verdict
        paragraphs = [] if verdict is None else [paragraph(sentence) for sentence in verdict.conclusion]
        paragraphs += [*_gaps_for_rates(data, pair), *rates.annual_rates(assessment, pair.assessed)]
        paragraphs += rates.scenario(assessment, pair.assessed)
        if paragraphs and len(data.pairs) > 1:
            blocks.append(heading(pair.name, f"{pair.anchor}-how-often"))
        blocks += paragraphs
    reading = assessment.hazard_reading
    return [paragraph(reading), *blocks] if blocks and reading else blocks


def _gaps_for_rates(data: ReportData, pair: Pair) -> list[Block]:
    """Figure of the rate of contact against the gap, and table of the gaps that keep it to usual rates."""
    assessment, one = data.assessment, pair.assessed
    blocks = rates.gaps_for_rates(assessment, one)
    valid = [gap for gap in one.gaps_for_rates if not gap.fault]
    if not valid:
        return blocks
    sentence = (
        f"{pair.name}: annual rate of contact against the gap under {assessment.hazard}; its "
        f"{100.0 * assessment.confidence:g} % bounds carry nothing of the curve's own uncertainty"
    )
    alt = f"{sentence}; {valid[-1].words} needs {enough(valid[-1].gap, unit=True)['text']}."
    return [figure(f"{pair.anchor}-rates", partial(panel, draw_rates, assessment, one), f"{sentence}.", alt), *blocks]


def _effects(data: ReportData) -> list[Block]:
    """The effects that the scene names, and what each changes and costs where a dataset of `effects` is given."""
    named = data.scene.get("effects", {})
    first = listing(f"{name_of(name)}: {effects.options_words(options)}" for name, options in named.items())
    if not named:
        first = paragraph(
            "The scene names no effects, and none was simulated: no permanent indentation, no strain rate, no passing "
            "wave."
        )
    if "effects" not in data.others:
        return [first, paragraph("What each effect would change and cost: `pounding-risk effects`, given with --with.")]
    return [first, heading("What they change and cost", "effects-cost"), *effects.sheet(data.others["effects"])]


def _references(data: ReportData) -> list[Block]:
    """The sources of the contact laws and effects that took part, and of the rules of codes."""
    sources = [source.strip() for source in str(data.results.attrs.get("references", "")).split(";")]
    rules = []
    for rule in RULES.values():
        basis = f"{rule.verification}: {rule.source}" if rule.source else rule.verification
        later = f"; superseded by {rule.superseded}" if rule.superseded else ""
        level = f"; ground motion from memory: {rule.level}" if rule.level else ""
        holds = f"; in force: {rule.in_force}" if rule.in_force else ""
        rules.append(f"{rule.title}: {rule.clause}; {rule.formula}; {basis}{level}{later}{holds}.")
    return [
        paragraph("Contact laws and effects of this study:"),
        listing(dict.fromkeys(source for source in sources if source)),
        paragraph(
            "Rules of codes: clause, formula, how its text is known, and later editions as far as known here. "
            f"{SUPERSEDED}:"
        ),
        listing(rules),
    ]


ROWS = (
    ("axes", 5, "Along the axes of the scene", _along),
    ("rates", 45, "How often do they touch?", _rates),
    ("uncertainty", 48, "Uncertain numbers", _uncertainty),
    ("damage", 65, "Damage", _damage),
    ("effects", 90, "Effects", _effects),
    ("references", 100, "References", _references),
)
