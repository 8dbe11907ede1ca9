"""The page of published cases: every value beside ours, the figures, and each case with its source."""

from __future__ import annotations

from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pounding_risk import __version__
from pounding_risk.figures.style import svg_text
from pounding_risk.figures.verification import (
    property_figure,
    verification_differences_figure,
    verification_figure,
)
from pounding_risk.render.sheet import Block, facts, figure, heading, listing, paragraph, table
from pounding_risk.reports import SUFFIXES
from pounding_risk.reports.document import Document, number_blocks
from pounding_risk.reports.html import page, write_page
from pounding_risk.results.files import check_target

if TYPE_CHECKING:
    from pounding_risk.lab.verification import Check, Property, Verification

HEADS = (
    *(("source and case", "l"), ("quantity", "l"), ("kind", "l"), ("published", "r"), ("ours", "r")),
    *(("difference", "r"), ("ours changes by", "r"), ("", "l")),
)
MEANING = (
    "exact: ours agrees to the digits that are printed, six at most.",
    "acceptable: within 5 % of the published value, 25 % of an experiment's, or within the uncertainty that the case "
    "states. These are the bounds of CSI's verification manuals (SAP2000, Methodology).",
    "unacceptable: beyond.",
    "ours changes by: how far our value moves between the tolerances 1e-6, the default, and 1e-9, while the time step "
    "of generated motions falls to an eighth; none where a value has no tolerance. A difference ten times larger is "
    "neither that of our solver nor that of the samples.",
)


def verification_page(outcome: Verification, out: str | Path) -> Path:
    """Write the page of published cases, as one HTML file or as PDF by the suffix of ``out``.

    Parameters
    ----------
    outcome : Verification
        As `verify` gives it.
    out : str or Path
        The page, .html or .pdf.

    Returns
    -------
    Path
        The file that was written.

    Raises
    ------
    PoundingError
        For a target that cannot be written, and for a PDF without the extra ``pdf``.
    """
    target = check_target(out, SUFFIXES)
    model = build(outcome)
    if target.suffix.lower() == ".pdf":
        from pounding_risk.reports.pdf import document

        return write_page(target, document(model))
    return write_page(target, page(model))


def build(outcome: Verification) -> Document:
    """The document of the page, as dictionaries that JSON holds."""
    sections = [
        {"name": name, "title": title, "blocks": blocks}
        for name, title, blocks in (
            ("values", "Published values and ours", _values(outcome)),
            ("figures", "Figures", _figures(outcome)),
            ("properties", "Published properties and ours", _properties(outcome)),
            ("cases", "The cases and their sources", _cases(outcome)),
            ("unreached", "Published, and not among the cases", _unreached(outcome)),
        )
        if blocks
    ]
    number_blocks(sections)
    return {
        "title": "Verification of published cases",
        "about": "Seismic pounding of adjacent buildings: published values beside ours",
        "signature": [],
        "author": "",
        "program": f"pounding_risk {__version__}",
        "made_from": "from the case files, which it ran",
        "sections": sections,
    }


def _values(outcome: Verification) -> list[Block]:
    if not outcome.checks:
        return []
    rows = [(f"{check.source} ({check.case})", check.quantity, check.kind, *cells(check)) for check in outcome.checks]
    caption = "Every published value, as printed, and ours in the same unit."
    return [
        paragraph(f"{outcome.finding()}. {kinds(outcome)} {recalled(outcome)}".strip()),
        listing(MEANING),
        table(caption, HEADS, rows, keep=range(len(rows))),
        *_ladder(outcome),
    ]


def _ladder(outcome: Verification) -> list[Block]:
    """Where ours differs: its values at every tolerance, as distances from the one at the finest."""
    from pounding_risk.lab.verification.run import EXACT, RUNGS, share

    apart = [check for check in outcome.checks if check.rungs and check.word != EXACT and check.ours]
    if not apart:
        return []
    rows = [
        (
            f"{check.source} ({check.case})",
            check.quantity,
            share(check.difference),
            *(share(abs(value / check.ours - 1.0)) for value in check.rungs[:-1]),
        )
        for check in apart
    ]
    heads = (("source and case", "l"), ("quantity", "l"), ("difference", "r"))
    words = (
        f"How far ours at each tolerance is from ours at {RUNGS[-1]:.0e}, where a published value is not met exactly."
    )
    return [table(words, (*heads, *((f"{rtol:.0e}", "r") for rtol in RUNGS[:-1])), rows, keep=range(len(rows)))]


def kinds(outcome: Verification) -> str:
    """A sentence that counts the values of each kind."""
    counts: dict[str, int] = {}
    for check in outcome.checks:
        counts[check.kind] = counts.get(check.kind, 0) + 1
    return f"By kind: {', '.join(f'{kind} {count}' for kind, count in counts.items())}."


def recalled(outcome: Verification) -> str:
    """A sentence on the cases whose source was not read, nor a text that quotes it."""
    names = ", ".join(f"`{case.name}`" for case in outcome.cases if case.about.basis == "from memory")
    return f"Known from memory, not read: {names}; look the source up before you rely on it." if names else ""


def cells(check: Check) -> tuple[Any, ...]:
    """Published value, ours, difference, change of ours and the word, of one line of the table."""
    from pounding_risk.lab.verification.run import said, share

    return (
        {"text": check.printed, "raw": check.published, "unit": check.unit},
        {"text": said(check), "raw": check.ours, "unit": check.unit},
        share(check.difference),
        share(abs(check.change)),
        check.word,
    )


def _basis(about: Any) -> str:
    """Whether the source was read, and in which words of the case."""
    return about.basis if about.known == about.basis else f"{about.basis}: {about.known}"


def _figures(outcome: Verification) -> list[Block]:
    if not outcome.checks:
        return []
    blocks = []
    if any(len(curve.points) > 1 for curve in outcome.curves):
        drawn = verification_figure(outcome)
        caption = "Published points over our curves."
        blocks.append(figure("curves", svg_text(drawn), caption, f"{caption} {drawn.get_suptitle()}."))
    drawn = verification_differences_figure(outcome)
    caption = "Every difference, and how far ours changes with the tolerance."
    blocks.append(figure("differences", svg_text(drawn), caption, f"{caption} {drawn.get_suptitle()}."))
    return blocks


PROPERTY_HEADS = (
    *(("reading", "l"), ("published", "r"), ("ours", "r"), ("bounds", "r"), ("bounds by", "l"), ("", "l")),
)
MEANING_OF_PROPERTIES = (
    "A property is a published relation without a single number to hit. It holds where each reading of ours lies "
    "within bounds that follow from the tolerance of the runs, the digits printed, or the number of samples and a "
    "fixed seed."
)


def _properties(outcome: Verification) -> list[Block]:
    """A heading, the relation with its source, the readings and the figure of each property."""
    blocks: list[Block] = [paragraph(MEANING_OF_PROPERTIES)] if outcome.properties else []
    for one in outcome.properties:
        blocks.append(heading(f"{one.title} ({one.name}): {one.word}", f"property-{one.name}"))
        about = (
            *(("relation", one.relation), ("source", one.citation), ("address", one.url)),
            ("known", one.basis if one.known == one.basis else f"{one.basis}: {one.known}"),
        )
        blocks.append(facts("", [(name, words) for name, words in about if words]))
        drawn = property_figure(one)
        blocks.append(figure(one.name, svg_text(drawn), f"{one.source}: {one.title}.", f"{drawn.get_suptitle()}."))
        rows = property_rows(one)
        blocks.append(table(f"{one.title}.", PROPERTY_HEADS, rows, keep=range(len(rows))))
    return blocks


def property_rows(one: Property) -> list[tuple[str, ...]]:
    """The readings of a property as words."""
    from pounding_risk.lab.verification.property import bounds

    return [
        (
            reading.quantity,
            *(_number(value, reading.unit) for value in (reading.expected, reading.ours)),
            *(bounds(reading), reading.reason, reading.word),
        )
        for reading in one.readings
    ]


def _number(value: float, unit: str) -> str:
    from pounding_risk.lab.verification.property import rounded

    return f"{rounded(value)} {unit}".strip() if isfinite(value) else ""


def _unreached(outcome: Verification) -> list[Block]:
    """What is not among the cases, on the page of all that ship."""
    from pounding_risk.lab.verification.properties import PROPERTIES
    from pounding_risk.lab.verification.unreached import EXPERIMENTS, UNREACHED

    if len(outcome.properties) < len(PROPERTIES):
        return []
    heads = (("what", "l"), ("why", "l"))
    caption = "What is published and not compared, and why."
    return [paragraph(EXPERIMENTS), table(caption, heads, UNREACHED, keep=range(len(UNREACHED)))]


def _cases(outcome: Verification) -> list[Block]:
    blocks: list[Block] = []
    for case in outcome.cases:
        about = case.about
        blocks.append(heading(f"{about.title} ({case.name})", f"case-{case.name}"))
        rows = [
            ("source", about.citation),
            ("where", about.where),
            ("address", about.url),
            ("known", _basis(about)),
        ]
        rows += [("note", about.note)]
        rows += [(value.quantity.replace("_", " "), value.note) for value in case.published if value.note]
        unique = list(dict.fromkeys((name, words) for name, words in rows if words))
        blocks.append(facts("", unique))
    return blocks
