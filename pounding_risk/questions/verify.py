"""Sheet of `verify`, and the sections of its page: published values and properties beside ours."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pounding_risk.lab.verification.property import bounds, plain, rounded
from pounding_risk.lab.verification.run import EXACT, PROPERTIES, RUNGS, said, share
from pounding_risk.questions._declaration import File, Option
from pounding_risk.render.sheet import Block, Cell, facts, figure, heading, listing, out_of, paragraph, table, worded

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pounding_risk.lab.verification import Property, Verification

ORDER = 88
FUNCTION = "lab.verification.run"
OPTIONS = {"cases": Option(kind=list[str], metavar="[CASE | PROPERTY | FILE | FOLDER]", is_argument=True)}
FILES = {"out": File((".html", ".pdf"), "", "reports.pages.verification_page")}
FIGURES = {"": "verification.outcome_figure"}
HELP = (
    "Ends with status 1 where a value is unacceptable or a property fails. Of properties alone the figure shows the "
    "first; -o page.html has those of all."
)
DISAGREES = 1  # exit status
HEADS = ("case", "quantity", "source", "kind", "published", "ours", "difference", "tolerance effect", "")
MEANING = (
    "exact: ours agrees to the digits that are printed, six at most.",
    "acceptable: within 5 % of the published value, 25 % of an experiment's, or within the uncertainty that the case "
    "states. These are the bounds of CSI's verification manuals (SAP2000, Methodology).",
    "unacceptable: beyond.",
    "tolerance effect: how far our value moves between the tolerances 1e-6, the default, and 1e-9, while the time step "
    "of generated motions falls to an eighth, as a share of the largest of these and the published value; none where a "
    "value has no tolerance. A difference ten times larger is "
    "neither that of our solver nor that of the samples.",
)


def sheet(outcome: Verification) -> list[Block]:
    """Values, properties, whatever is unacceptable or out of its bounds, and the counts."""
    notes = [
        f"{entry.case}, {entry.quantity}: {share(entry.difference)} from {entry.printed} of {entry.source}, "
        f"more than {share(entry.limit)}{'; ours has converged' * entry.is_converged}"
        for entry in outcome.unacceptable
    ]
    notes += [
        f"{entry.name}, {reading.quantity}: {rounded(reading.ours)}, bounds {bounds(reading)}: {reading.reason}"
        for entry in outcome.properties
        for reading in entry.readings
        if not reading.holds
    ]
    return [
        *values(outcome),
        *([_properties_in_short(outcome)] if outcome.properties else []),
        *map(paragraph, notes),
        paragraph(outcome.finding()),
    ]


def status(outcome: Verification) -> int:
    """Exit status of the command."""
    return DISAGREES if outcome.unacceptable or outcome.failing else 0


def sections_of(outcome: Verification) -> list[tuple[str, str, list[Block]]]:
    """Name, title and blocks of each section of the page; without blocks where there is nothing of its kind."""
    return [
        ("values", "Published values and ours", _values(outcome)),
        ("figures", "Figures", _figures(outcome)),
        ("properties", "Published properties and ours", _properties(outcome)),
        ("cases", "The cases and their sources", _cases(outcome)),
        ("unreached", "Published, and not among the cases", _unreached(outcome)),
    ]


def values(outcome: Verification) -> list[Block]:
    """The table of every published value beside ours; nothing without one."""
    rows = [
        (
            *(check.case, check.quantity, check.source, check.kind),
            {"text": check.printed, "raw": check.published, "unit": check.unit},
            {"text": said(check), "raw": check.ours, "unit": check.unit},
            *(_share(check.difference), _share(abs(check.change)), check.word),
        )
        for check in outcome.checks
    ]
    caption = "Every published value, as printed, and ours in the same unit."
    return [table(caption, HEADS, rows, keep=range(len(rows)))] if rows else []


def _share(ratio: float) -> Cell:
    return worded(ratio, share(ratio))


def _properties_in_short(outcome: Verification) -> Block:
    rows = []
    for prop in outcome.properties:
        in_bounds = out_of(sum(reading.holds for reading in prop.readings), len(prop.readings))
        rows.append((prop.name, prop.source, plain(prop.headline), in_bounds, prop.word))
    heads = ("property", "source", "ours", "readings in bounds", "")
    return table("Published properties.", heads, rows, keep=range(len(rows)))


def _values(outcome: Verification) -> list[Block]:
    if not outcome.checks:
        return []
    recalled = ", ".join(f"`{case.name}`" for case in outcome.cases if case.about.basis == "from memory")
    summary = f"{outcome.finding()}."
    if recalled:  # their source was not read, nor a text that quotes it
        summary += f" Known from memory, not read: {recalled}; look the source up before you rely on it."
    return [paragraph(summary), listing(MEANING), *values(outcome), *_ladder(outcome)]


def _ladder(outcome: Verification) -> list[Block]:
    """Where ours differs: its values at every tolerance, as distances from the one at the finest."""
    unequal = [check for check in outcome.checks if check.rungs and check.word != EXACT and check.ours]
    if not unequal:
        return []
    rows = []
    for check in unequal:
        distances = (_share(abs(ours / check.ours - 1.0)) for ours in check.rungs[:-1])
        rows.append((f"{check.source} ({check.case})", check.quantity, _share(check.difference), *distances))
    heads = ("source and case", "quantity", "difference", *(f"{rtol:.0e}" for rtol in RUNGS[:-1]))
    words = (
        f"How far ours at each tolerance is from ours at {RUNGS[-1]:.0e}, where a published value is not met exactly."
    )
    return [table(words, heads, rows, keep=range(len(rows)))]


def _figures(outcome: Verification) -> list[Block]:
    if not outcome.checks:
        return []
    from pounding_risk.figures.verification import verification_differences_figure, verification_figure

    blocks = []
    if any(len(curve.points) > 1 for curve in outcome.curves):
        blocks.append(_figure_block("curves", verification_figure(outcome), "Published points over our curves."))
    caption = "Every difference, and its tolerance effect."
    return [*blocks, _figure_block("differences", verification_differences_figure(outcome), caption)]


def _figure_block(name: str, picture: Figure, caption: str) -> Block:
    return figure(name, lambda: picture, caption, f"{caption} {picture.get_suptitle()}.")


PROPERTY_HEADS = ("reading", "published", "ours", "bounds", "bounds by", "")
MEANING_OF_PROPERTIES = (
    "A property is a published relation without a single number to hit. It holds where each reading of ours lies "
    "within bounds that follow from the tolerance of the runs, the digits printed, or the number of samples and a "
    "fixed seed."
)


def _properties(outcome: Verification) -> list[Block]:
    """A heading, the relation with its source, the readings and the figure of each property."""
    from pounding_risk.figures.verification import property_figure

    blocks: list[Block] = [paragraph(MEANING_OF_PROPERTIES)] if outcome.properties else []
    for prop in outcome.properties:
        blocks.append(heading(f"{prop.title} ({prop.name}): {prop.word}", f"property-{prop.name}"))
        pairs = (
            *(("relation", prop.relation), ("source", prop.citation), ("address", prop.url)),
            ("known", prop.basis if prop.known == prop.basis else f"{prop.basis}: {prop.known}"),
        )
        blocks.append(facts("", [(name, words) for name, words in pairs if words]))
        blocks.append(_figure_block(prop.name, property_figure(prop), f"{prop.source}: {prop.title}."))
        rows = property_rows(prop)
        blocks.append(table(f"{prop.title}.", PROPERTY_HEADS, rows, keep=range(len(rows))))
    return blocks


def property_rows(prop: Property) -> list[tuple[Cell | str, ...]]:
    """The readings of a property as words."""
    return [
        (
            reading.quantity,
            *(worded(value, f"{rounded(value)} {reading.unit}".strip()) for value in (reading.expected, reading.ours)),
            *(bounds(reading), reading.reason, reading.word),
        )
        for reading in prop.readings
    ]


def _unreached(outcome: Verification) -> list[Block]:
    """What is not among the cases, on the page of all that ship."""
    from pounding_risk.lab.verification.unreached import EXPERIMENTS, UNREACHED

    if len(outcome.properties) < len(PROPERTIES):
        return []
    caption = "What is published and not compared, and why."
    return [paragraph(EXPERIMENTS), table(caption, ("what", "why"), UNREACHED, keep=range(len(UNREACHED)))]


def _cases(outcome: Verification) -> list[Block]:
    blocks: list[Block] = []
    for case in outcome.cases:
        about = case.about
        blocks.append(heading(f"{about.title} ({case.name})", f"case-{case.name}"))
        rows = [
            ("source", about.citation),
            ("where", about.where),
            ("address", about.url),
            ("known", about.basis if about.known == about.basis else f"{about.basis}: {about.known}"),
        ]
        rows += [("note", about.note)]
        rows += [(check.quantity.replace("_", " "), check.note) for check in case.published if check.note]
        unique = list(dict.fromkeys((name, words) for name, words in rows if words))
        blocks.append(facts("", unique))
    return blocks
