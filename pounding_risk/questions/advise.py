"""Sheet of `advise`: what to write for the contact of a scene, and which outputs depend on it."""

from __future__ import annotations

from pounding_risk.render.sheet import Block, Row, amount, listing, milliseconds, paragraph, source, table
from pounding_risk.results.variables import unit_of
from pounding_risk.studies.advice import FACTORS, LITTLE, MUCH, OUTPUTS, Advice
from pounding_risk.studies.advice_stiffness import StiffnessRange

ORDER = 65
FUNCTION = "studies.advice"
FIGURES = {"": "advice.advice_figure"}
UNIT = "scans"


def sheet(advice: Advice) -> list[Block]:
    """The finding, lines to write, ranges of stiffness with the published rules, and what depends on what.

    Without a table of what depends on what where no case has contact.
    """
    return [
        paragraph(f"{advice.finding}."),
        paragraph(f"{advice.scene}: gap {advice.gap}, {advice.touched} of {advice.cases} cases with contact."),
        _lines(advice),
        *map(_rules, advice.ranges),
        *([_influences(advice)] if advice.influences else []),
        *([listing(advice.left_out)] if advice.left_out else []),
    ]


def _lines(advice: Advice) -> Block:
    """The lines as they stand in a file, each below the reason for it."""
    text = []
    for line in advice.lines:
        text.append(f"# {line.why}")
        place = f"   # {line.interface}" if line.interface else ""
        if line.line or place:
            text.append(f"{line.line or '# write nothing'}{place}")
    return source("What to write in [[interface]]", "\n".join(text))


def _rules(span: StiffnessRange) -> Block:
    """The range of an interface, and where the published rules lie."""
    ends = [amount(end, span.unit, 3)["text"] for end in (span.low, span.high)]
    limits = [f"{milliseconds(time)['text']} ms" for time in (span.shortest, span.longest)]
    phrase = "no stiffness gives" if span.is_empty else f"{ends[0]} to {ends[1]} give"
    caption = (
        f"{span.interface}: a reduced mass of {amount(span.mass, 'kg', 3)['text']} strikes at "
        f"{amount(span.speed, 'm/s', 2)['text']}; {phrase} a contact of {limits[0]} (wave through a floor) to "
        f"{limits[1]} (T/10), undamped"
    )
    if span.is_column:
        caption += ". This is of floors that strike each other; columns, which are struck here, are not judged by it"
    heads = ["rule", "published", "equivalent stiffness", "contact lasts [ms]", "verdict", "source"]
    of_scene: Row = ["the scene's", "", amount(span.own, span.unit), milliseconds(span.duration)]
    rows: list[Row] = [[*of_scene, "–" if span.is_column else span.verdict or "–", ""]]
    for rule in span.rules:
        row: Row = [rule.name, amount(rule.published, rule.unit, 3), amount(rule.equivalent, span.unit, 3)]
        verdict = "–" if span.is_column else rule.verdict or "–"
        rows.append([*row, milliseconds(rule.duration), verdict, f"{rule.source} ({rule.known})"])
    return table(f"{caption}.", heads, rows)


def _influences(advice: Advice) -> Block:
    """A row for each output at each place, with a verdict on each factor."""
    rows: list[Row] = []
    for (output, place), median in advice.now.items():
        influences = [advice.influence(factor, output, place) for factor in FACTORS]
        cells = ["–" if influence is None else influence.words for influence in influences]
        rows.append([OUTPUTS[output], place, amount(median, unit_of(output), 3), *cells])
    little, much = (amount(share, "%")["text"] for share in (LITTLE, MUCH))
    caption = (
        f"Sensitivity: median change of the cases with contact. Stiffness: a tenth to ten times the scene's. "
        f"Below {little} an output does not depend on a value, above {much} it does."
    )
    return table(caption, ["output", "of", "now, median", *FACTORS], rows)
