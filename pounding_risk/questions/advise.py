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
        where = f"   # {line.interface}" if line.interface else ""
        if line.line or where:
            text.append(f"{line.line or '# write nothing'}{where}")
    return source("What to write in [[interface]]", "\n".join(text))


def _rules(one: StiffnessRange) -> Block:
    """The range of one interface, and where the published rules lie."""
    ends = [amount(end, one.unit, 3)["text"] for end in (one.low, one.high)]
    limits = [f"{milliseconds(time)['text']} ms" for time in (one.shortest, one.longest)]
    gives = "no stiffness gives" if one.is_empty else f"{ends[0]} to {ends[1]} give"
    caption = (
        f"{one.interface}: a reduced mass of {amount(one.mass, 'kg', 3)['text']} strikes at "
        f"{amount(one.speed, 'm/s', 2)['text']}; {gives} a contact of {limits[0]} (wave through a floor) to "
        f"{limits[1]} (T/10), undamped"
    )
    if one.is_column:
        caption += ". This is of floors that strike each other; columns, which are struck here, are not judged by it"
    heads = ["rule", "published", "equivalent stiffness", "contact lasts [ms]", "verdict", "source"]
    of_scene: Row = ["the scene's", "", amount(one.own, one.unit), milliseconds(one.duration)]
    rows: list[Row] = [[*of_scene, "–" if one.is_column else one.verdict or "–", ""]]
    for rule in one.rules:
        row: Row = [rule.name, amount(rule.published, rule.unit, 3), amount(rule.equivalent, one.unit, 3)]
        verdict = "–" if one.is_column else rule.verdict or "–"
        rows.append([*row, milliseconds(rule.duration), verdict, f"{rule.source} ({rule.known})"])
    return table(f"{caption}.", heads, rows)


def _influences(advice: Advice) -> Block:
    """A row for each output at each place, with a verdict on each factor."""
    rows: list[Row] = []
    for (output, place), median in advice.now.items():
        ones = [advice.influence(factor, output, place) for factor in FACTORS]
        cells = ["–" if one is None else one.words for one in ones]
        rows.append([OUTPUTS[output], place, amount(median, unit_of(output), 3), *cells])
    little, much = (amount(share, "%")["text"] for share in (LITTLE, MUCH))
    caption = (
        f"Sensitivity: median change of the cases with contact. Stiffness: a tenth to ten times the scene's. "
        f"Below {little} an output does not depend on a value, above {much} it does."
    )
    return table(caption, ["output", "of", "now, median", *FACTORS], rows)
