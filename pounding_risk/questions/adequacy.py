"""Blocks of `assess`: gaps, contact, yielding, response, influences, fragilities and code rules of each interface.

Every function gives one part, which the command and the report put in their own order.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import isfinite, isnan
from typing import TYPE_CHECKING

from pounding_risk._common.counted import counted
from pounding_risk._common.order import evenly
from pounding_risk._common.words import FIRST
from pounding_risk.assessment.options import NO_BOUND, NO_LOWER, NO_UPPER, PUSHED
from pounding_risk.assessment.sensitivity import NEVER, force_words
from pounding_risk.assessment.separations.rules import OWN_PEAKS, RATIONAL, SHARED
from pounding_risk.assessment.separations.table import Comparison, short_in
from pounding_risk.render.sheet import (
    KEPT,
    MISSING,
    Block,
    Cell,
    Row,
    amount,
    count,
    head,
    joined,
    listing,
    middle,
    name_of,
    noted,
    number,
    out_of,
    paragraph,
    probability,
    strength,
    table,
)
from pounding_risk.results.amplitudes import intensity_unit, intensity_words
from pounding_risk.statistics.proportions import Share
from pounding_risk.statistics.required_gap import RequiredGap, rounded_up

if TYPE_CHECKING:
    from pounding_risk.assessment.assess import Assessment, InterfaceAssessment
    from pounding_risk.assessment.fragility import Fragility
    from pounding_risk.assessment.gmfs import Scenario
    from pounding_risk.assessment.hazard import Rate


GIVEN = 6  # digits of values that a user has given
BOUNDS = "Bounds take every motion for independent; those by recording count components and polarities together."
KEYS = {"yield_force": "F_E", "contact_model": "contact model", "polarity": "polarity"}


def enough(gap: float, unit: bool = False) -> Cell:
    """A required gap [m], in the text rounded up to three digits, so that what is read suffices too."""
    cell = amount if unit else number
    return cell(gap, "m") if isnan(gap) else cell(gap, "m") | {"text": cell(rounded_up(gap), "m")["text"]}


def at_least(cell: Cell, is_least: bool) -> Cell:
    """The cell of a number, with "at least" where it is only a lower bound."""
    return {**cell, "text": f"at least {cell['text']}"} if is_least else cell


def need(required: RequiredGap, unit: bool = False) -> Cell:
    """A required gap, up to what neighbours may push together where that is not known; else a lower bound."""
    cell = at_least(enough(required.gap, unit), required.at_least)
    return joined(cell, enough(required.enough, unit), names=("", "up to")) if required.is_between else cell


def bounds_cell(required: RequiredGap) -> Cell:
    """The bounds of a required gap with the marks that `NO_BOUND` explains, in the unit of the column's head."""
    low = number(required.low, "m") | ({} if required.low > 0.0 else {"text": NO_LOWER})
    bounds = joined(low, enough(required.high))
    return bounds if required.bounded else without_upper(bounds, PUSHED if required.is_pushed else NO_UPPER)


def without_upper(bounds: Cell, mark: str) -> Cell:
    """The bounds of a required gap of which the upper one is none, with the mark of why."""
    return noted(bounds, mark, f"high is {NO_BOUND[mark]}")


def marks(required: Iterable[RequiredGap], words: Mapping[str, str]) -> list[Block]:
    """What each mark in the bounds of these required gaps means: a paragraph, as a list has marks of its own."""
    bounds = " ".join(bounds_cell(gap)["text"] for gap in required)
    explained = [f"{mark} {meaning}." for mark, meaning in words.items() if mark in bounds]
    return [paragraph(" ".join(explained))] if explained else []


def required_gaps(pair: InterfaceAssessment) -> list[Block]:
    """Table of the gaps that percentiles of the motions require, and what the marks of missing bounds mean."""
    heads = ["sufficient for [%]", head("required gap", "m"), head("bounds by recording", "m")]
    heads += [head("lognormal", "m"), "gap / required"]
    rows: list[Row] = []
    for required in pair.required:
        ratio = pair.gap / required.gap if required.gap > 0.0 else float("nan")
        row: Row = [number(required.percentile), need(required), bounds_cell(required)]
        rows.append([*row, number(required.fitted, "m"), number(ratio, digits=3)])
    caption = f"{pair.name}: required gaps, by the closings of {counted(len(pair.closing), 'motion')}."
    return [table(caption, heads, rows), *marks(pair.required, NO_BOUND)]


def contact(assessment: Assessment, pair: InterfaceAssessment) -> list[Block]:
    """Table of the motions with contact against the gap."""
    heads = [head("gap", "m"), "contact in", *_share_heads("P(contact)", assessment)]
    rows = [[number(share.gap, "m", GIVEN), *share_cells(share)] for share in pair.contact]
    partial = [k for k, share in enumerate(pair.contact) if 0 < share.count < share.runs]
    first, last = (max(partial[0] - 1, 0), min(partial[-1] + 2, len(rows))) if partial else (0, len(rows))
    keep = {*(first + k for k in evenly(last - first, KEPT - 1)), pair.contact.index(pair.contact_at_gap())}
    note = "from the widest gap that all motions close to the narrowest that none closes"
    caption = f"{pair.name}: motions with contact against the gap, motions {pair.at}."
    return [table(caption, heads, rows, keep=sorted(keep), note=note), paragraph(BOUNDS)]


def _share_heads(event: str, assessment: Assessment) -> list[str]:
    bounds = f"{100 * assessment.confidence:g} % bounds [%]"
    return ["of", f"{event} [%]", bounds, "by recording [%]"]


def share_cells(share: Share) -> list[Cell]:
    """Count, runs, probability [%] and its bounds [%] by motion and by recording."""
    bounds = [(share.low, share.high), (share.low_recordings, share.high_recordings)]
    cells = [joined(*map(probability, ends)) for ends in bounds]
    return [count(share.count), count(share.runs), probability(share.probability), *cells]


def yielding(assessment: Assessment, pair: InterfaceAssessment) -> list[Block]:
    """Table of the motions in which the force reaches F_E, at the gap of the grid nearest to the assessed one."""
    shares = [share for share in pair.yielding if share.gap == pair.yield_gap]
    if not shares:
        return []
    heads = ["contact model", head("F_E", "N"), "reached in", *_share_heads("P(yield)", assessment), "excluded"]
    rows: list[Row] = []
    for share in shares:
        excluded = count(share.left_out) if share.left_out else MISSING
        rows.append([model_of(share), strength(share.yield_force), *share_cells(share), excluded])
    own_rows = [k for k, share in enumerate(shares) if share.contact_model == pair.own_model]
    keep = [own_rows[k] for k in evenly(len(own_rows), KEPT)]
    caption = f"{pair.name}: probability of reaching F_E at a gap of {_yield_gap(pair)}, motions {pair.at}."
    columns = "F_E is that of floors that meet, or of columns where none meet; `validate` shows both of a scene. "
    columns *= len(assessment.interfaces) > 1
    if pair.column_forces:
        ends = dict.fromkeys((pair.column_forces[0], pair.column_forces[-1]))
        strengths = " to ".join(str(amount(force, "N")["text"]) for force in ends)
        columns = f"Floors meet here and strike columns: F_E is that of floors; columns reach theirs at {strengths}. "
    return [
        table(caption, heads, rows, keep=keep, note="some of the scene's own contact model"),
        paragraph(f"{columns}The scene's own: {_own_force(pair)}."),
    ]


def _own_force(pair: InterfaceAssessment) -> str:
    """The scene's own yield force in words, with whether columns yield where floors have it."""
    return force_words(pair.own_force, any(share.yield_force == pair.own_force for share in pair.yielding))


def _yield_gap(pair: InterfaceAssessment) -> str:
    return str(amount(pair.yield_gap, "m", GIVEN)["text"])


def response(pair: InterfaceAssessment) -> list[Block]:
    """Table of the response under each F_E: medians over the motions with contact, under the scene's contact model."""
    medians = [median for median in pair.response if median.contact_model == pair.own_model and median.motions]
    if not medians:
        return []
    outputs = {median.output: head(median.words, median.unit) for median in medians}
    rows: list[Row] = []
    for force in dict.fromkeys(median.yield_force for median in medians):
        of_force = {median.output: median for median in medians if median.yield_force == force}
        columns_yield = any(share.yield_force == force for share in pair.yielding)
        level = number(force, "N", GIVEN) if isfinite(force) else strength(force) if columns_yield else NEVER
        row: Row = [level, count(max(median.motions for median in of_force.values()))]
        entries = (of_force.get(output) for output in outputs)  # none where no motion has a finite value of an output
        rows.append([*row, *(MISSING if entry is None else number(entry.median, entry.unit, 3) for entry in entries)])
    caption = f"{pair.name}: response against F_E, at a gap of {_yield_gap(pair)}, under {name_of(pair.own_model)}."
    words = "Medians over the motions with contact, the larger of both buildings; the scene's own"
    heads = [head("F_E", "N"), "contact in", *outputs.values()]
    return [table(caption, heads, rows), paragraph(f"{words}: {_own_force(pair)}.")]


def influences(pair: InterfaceAssessment) -> list[Block]:
    """Table of how far each output moves with polarity, F_E and contact model; keys with one level are named below."""
    heads = ["influence of", "on", "from one level to another"]
    rows = [(KEYS[item.key], item.what, item.words) for item in pair.sensitivity if not item.is_single]
    levels = {(name_of(item.key), item.levels[0][0]): None for item in pair.sensitivity if item.is_single}
    single = " and ".join(f"one {key} ({level})" for key, level in levels)
    return [
        *([table(f"{pair.name}: influences on the outputs.", heads, rows)] if rows else []),
        *([paragraph(f"The grid has {single}: scan several to see what they change.")] if single else []),
    ]


def fragilities(assessment: Assessment, pair: InterfaceAssessment) -> list[Block]:
    """Table of the medians and dispersions of fragilities, with standard errors, and why others were not fitted."""
    curves = fitted(pair)
    if not curves:
        return _not_fitted(pair)
    median = head(f"median {intensity_words(assessment.intensity)}", intensity_unit(assessment.intensity))
    heads = [*EVENT_HEADS, median, "dispersion", "s.e. of ln median; by recording", "s.e. of dispersion; by recording"]
    heads += ["method", "scaled by"]
    rows: list[Row] = []
    for curve in curves:
        row = [*event_cells(curve), number(curve.median, curve.unit), number(curve.dispersion, digits=3)]
        row.append(_error(curve.se_median, curve.se_median_recordings))
        row.append(_error(curve.se_dispersion, curve.se_dispersion_recordings))
        rows.append([*row, curve.method, number(curve.factor, digits=3)])
    caption = f"{pair.name}: fragility against {intensity_words(assessment.intensity)}, by maximum likelihood."
    keep = of_gap(pair, curves)
    return [
        table(caption, heads, rows, keep=keep, note=OF_GAP),
        paragraph(
            "Standard errors (s.e.) are those for independent motions, then those by recording. From few recordings "
            "both are too small, and so is the dispersion; bounds of rates count that."
        ),
        *_not_fitted(pair),
    ]


EVENT_HEADS = ["of", head("gap", "m"), "contact model", head("F_E", "N")]
OF_GAP = "contact at the assessed gap, and yielding"


def event_cells(answer: Fragility | Rate | Scenario) -> Row:
    """What a curve or rate is of, as the columns of `EVENT_HEADS`."""
    event = "yielding" if answer.what == "yield" else answer.what
    return [event, number(answer.gap, "m", GIVEN), model_of(answer), strength(answer.yield_force)]


def model_of(answer: Share | Fragility | Rate | Scenario) -> str:
    """The contact model of a result; contact itself depends on none."""
    return name_of(answer.contact_model) if answer.contact_model else "any"


def of_gap(pair: InterfaceAssessment, results: Iterable[Fragility | Rate | Scenario]) -> list[int]:
    """Indices of the results on contact at the assessed gap, and on yielding."""
    return [k for k, answer in enumerate(results) if answer.what == "yield" or answer.gap == pair.gap]


def fitted(pair: InterfaceAssessment) -> list[Fragility]:
    """The fragilities that have a median and a dispersion."""
    return [curve for curve in pair.fragility if isfinite(curve.median) and isfinite(curve.dispersion)]


def _error(independent: float, by_recording: float) -> Cell:
    """A standard error were motions independent, and that by recording."""
    cells = [number(error, digits=3) for error in (independent, by_recording)]
    cell = joined(*cells, names=("", "by recording"))
    return cell | {"text": f"{cells[0]['text']}; {cells[1]['text']}"}


def _not_fitted(pair: InterfaceAssessment) -> list[Block]:
    """Which curves could not be fitted, and why: contact at the assessed gap, yielding, and at how many other gaps."""
    faults: dict[str, list[str]] = {}
    other_count = 0
    for curve in pair.fragility:
        if curve.fault and curve.what == "contact" and curve.gap != pair.gap:
            other_count += 1
        elif curve.fault:
            words = f"{'yielding' if curve.what == 'yield' else curve.what}, gap {amount(curve.gap, 'm')['text']}"
            words += "" if curve.yield_force is None else f", F_E {strength(curve.yield_force, unit=True)['text']}"
            words += f" under {name_of(curve.contact_model)}" if curve.contact_model else ""
            faults.setdefault(curve.fault, []).append(words)
    more_text = {fault: f" and {len(events) - FIRST} more" * (len(events) > FIRST) for fault, events in faults.items()}
    sentences = [f"{'; '.join(events[:FIRST])}{more_text[fault]}: {fault}." for fault, events in faults.items()]
    if other_count:
        sentences.append(f"contact at {counted(other_count, 'other gap')}: `assess -o` writes the reason of each.")
    return [paragraph(f"{pair.name}, not fitted:"), listing(sentences, mark="")] if sentences else []


def rules(percentile: float, pair: InterfaceAssessment) -> list[Block]:
    """What the rules of building codes require, motion by motion, over the gap that the motion needs."""
    bumper = max((rule.bumper for rule in pair.separations), default=0.0)
    motions = sum(closing > bumper for closing in pair.closing)
    given_rows = [k for k, rule in enumerate(pair.separations) if rule.exceeded is not None]
    notes = [rule.row.note for rule in pair.separations]
    # The parts that every note of a separation has are written once, above the table.
    clauses = [rule.row.note.split("; ") for rule in pair.separations if rule.row.separation is not None]
    common = [clause for clause in clauses[0] if all(clause in parts for parts in clauses)] if clauses else []
    sentences = [
        short_in(pair.separations, motions),
        *(f"Everywhere {note}" for note in common if note not in SHARED),
        *(words for shared, words in SHARED.items() if any(shared in note for note in notes)),
        RATIONAL,
        "Insufficient for: motions that need more than the rule requires from them",
        "`separations` lists who quotes the clauses, and applies the rules to design displacements",
    ]
    heads = ["rule", "clause", "text of the clause", head("median", "m"), head(f"{percentile:g} %", "m")]
    heads += ["rule / gap required: median (16 to 84 %)", "insufficient for", f"gap / rule at {percentile:g} %", "note"]
    rows = [_rule_cells(rule, pair.gap, motions, common) for rule in pair.separations]
    caption = f"{pair.name}: separations that rules require, {OWN_PEAKS}."
    return [
        paragraph(" ".join(f"{sentence}." for sentence in sentences)),
        table(caption, heads, rows, keep=given_rows or None, note="those that give a separation" if given_rows else ""),
    ]


def _rule_cells(rule: Comparison, gap: float, motions: int, common: Sequence[str]) -> Row:
    row = rule.row
    explained_clauses = {*common, *SHARED}  # above the table, and in its column of texts
    note = "; ".join(clause for clause in row.note.split("; ") if clause not in explained_clauses) or MISSING
    ratio = number((gap - rule.bumper) / rule.upper, digits=3) if rule.exceeded is not None and rule.upper else MISSING
    return [row.title, row.clause, row.verification, *compared(rule, motions), ratio, note]


def compared(rule: Comparison, motions: int) -> Row:
    """Separations of a rule, their ratio to the gap needed, and for how many motions the rule is insufficient."""
    if rule.exceeded is None:
        return [length(rule.row.separation), MISSING, MISSING, MISSING]
    low, median, high = (ratio or 0.0 for ratio in (rule.ratio_low, rule.ratio_median, rule.ratio_high))
    short_cell = out_of(round(rule.exceeded * motions), motions)
    return [number(rule.middle, "m"), number(rule.upper, "m"), middle((low, median, high), "1"), short_cell]


def length(metres: float | None) -> Cell | str:
    """A length [m] in the unit of the column's head; – for none."""
    return MISSING if metres is None else number(metres, "m")
