"""The rules of building codes: alone, applied to given displacements, or beside the gaps that motions need."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf
from typing import Any, NamedTuple

from pounding_risk.assessment.options import percentile_of
from pounding_risk.assessment.separations import table as code
from pounding_risk.assessment.separations.rules import (
    FROM_MEMORY,
    NOT_REDUCED,
    OWN_PEAKS,
    QUOTED_ONLY,
    RATIONAL,
    RULES,
    SHARED,
    SUPERSEDED,
    Site,
)
from pounding_risk.assessment.separations.table import CodeTable, SeparationRow
from pounding_risk.errors import PoundingError
from pounding_risk.questions._declaration import Option
from pounding_risk.questions.adequacy import Row, compared, length
from pounding_risk.render.sheet import MISSING, Block, Cell, count, facts, head, heading, number, paragraph, table
from pounding_risk.results.check import check_scan
from pounding_risk.results.files import open_with_axes
from pounding_risk.statistics.required_gap import rounded_up
from pounding_risk.statistics.separations import white_noise_correlation
from pounding_risk.units import DAMPING, PERIOD, PGA, Quantity, parse, si

ORDER = 120
FIGURES = {"": "separations.separations_figure"}
OPTIONS = {
    "displacement": Option(metavar="SIDE=LENGTH"),
    "behaviour_factor": Option(metavar="[SIDE=]NUMBER"),
    "period": Option(metavar="SIDE=TIME"),
    "damping": Option(metavar="[SIDE=]NUMBER"),
    "factor": Option(kind=list[float]),
}
HEIGHT = Quantity("m", 0.0, inf, "height of a building", open_low=True, open_high=True, example="12 m")
FACTOR = Quantity("1", 0.0, inf, "behaviour factor", open_low=True, open_high=True, example="3")
BOTH_DISPLACEMENTS = "--displacement left=45mm --displacement right=30mm"
BOTH_PERIODS = "--period left=0.4s --period right=0.7s"
USUAL_DAMPING = 0.05
# Options that say something of given displacements, and where a dataset has the same.
OF_GIVEN = {
    "displacement": "scale its own with --factor",
    "behaviour_factor": "scale its own with --factor",
    "period": "keep the periods and damping ratios that it has",
    "damping": "keep the periods and damping ratios that it has",
}


class Given(NamedTuple):
    """Separations of two given displacements, under the facts of a site."""

    rows: tuple[SeparationRow, ...]
    displacements: tuple[float, float]  # m, elastic
    site: Site
    periods: tuple[float, float] | None = None  # s
    dampings: tuple[float, float] | None = None  # with the periods


class Beside(NamedTuple):
    """Separations beside the gaps that the motions of a dataset need, by interface."""

    tables: tuple[tuple[str, CodeTable], ...]


def separations(
    results: Any = None,
    *,
    displacement: Sequence[str] = (),
    behaviour_factor: Sequence[str] = (),
    period: Sequence[str] = (),
    damping: Sequence[str] = (),
    percentile: float | str = 84.0,
    height: Sequence[float | str] = (),
    factor: Sequence[float] = (),
    aligned: bool = False,
    alike: bool = False,
    zone: str | None = None,
    intensity: int | None = None,
    structure: str = "frame",
    ground: float | str | None = None,
    interface: str | None = None,
) -> Given | Beside | None:
    """Separations of building codes, beside those needed.

    Parameters
    ----------
    results : xarray.Dataset, str or Path, optional
        Dataset of a scan; the rules alone by default.
    displacement : sequence of str
        Elastic design displacement, left=45mm; twice, in place of a dataset.
    behaviour_factor : sequence of str
        Of these displacements: q, Cd / Ie, μ, 3 or left=3; once or twice. 1 by default.
    period : sequence of str
        Period of each building, left=0.4s; twice, for the double difference of given displacements.
    damping : sequence of str
        Damping ratio beside the periods, 0.05 or left=0.05; once or twice. 0.05 by default.
    percentile : float or str
        Percentile of the gap needed, "84 %".
    height : sequence of float or str
        Height of a building [m, or text with a unit]; twice: left, then right.
    factor : sequence of float
        Code's displacement over the linear one of a dataset, such as Cd / R; twice: left, then right. 1 by default.
    aligned : bool
        Floors are at the same levels.
    alike : bool
        Same height and kind of structure too.
    zone : str, optional
        Of Mexico City: I, II or III.
    intensity : int, optional
        In China: 6 to 9.
    structure : str
        In China: frame, frame and walls, or walls.
    ground : float or str, optional
        Design acceleration a_g S [m/s2, or text with a unit], in Italy.
    interface : str, optional
        Of a row, "left | right"; every one by default.

    Returns
    -------
    Given, Beside or None
        None for the rules alone.

    Raises
    ------
    PoundingError
        For a number out of its range, and for what is given once or has no side.
    """
    if results is None and not (displacement or behaviour_factor or period or damping):
        return None
    site = _site(height, behaviour_factor, factor, ground)
    site = site._replace(aligned=aligned, alike=alike, zone=zone, intensity=intensity, structure=structure)
    if results is None:
        bounds = code.DISPLACEMENT._replace(low=0.0, open_high=True)
        displacements = _by_side("displacement", displacement, bounds, BOTH_DISPLACEMENTS)
        moving = _moving(period, damping)
        return Given(
            code.separations(("left", "right"), displacements, *moving, site=site), displacements, site, *moving
        )
    share = percentile_of(percentile)
    opened = open_with_axes(results)
    check_scan(opened.dataset, opened.name, names=("building", "building_period", "building_damping"))
    pairs = opened.interfaces
    chosen = {name: pair.dataset for name, pair in pairs if interface in (None, name)}
    if not chosen:
        names = ", ".join(name for name, _ in pairs)
        raise PoundingError(f"interface: {interface!r} is not in the dataset, which has {names}")
    return Beside(tuple((name, code.code_table(pair, share, site)) for name, pair in chosen.items()))


def check(options: Mapping[str, Any]) -> None:
    """Raise PoundingError for options that do not go together, and for numbers out of their range."""
    if "percentile" in options:
        percentile_of(options["percentile"])
    height, behaviour, factor = (options.get(name) or () for name in ("height", "behaviour_factor", "factor"))
    _site(height, behaviour, factor, options.get("ground"))
    if options.get("results") is None:
        if "figure" in options:
            raise PoundingError("figure: needs a dataset to draw; name one, such as results.nc")
        if "factor" in options and any(name in options for name in OF_GIVEN):
            raise PoundingError("factor: is of a dataset's displacements; of given ones write --behaviour-factor 3")
        return
    for name, repair in OF_GIVEN.items():
        if name in options:
            raise PoundingError(
                f"{name}: is for given displacements, without a dataset; leave the dataset out, or {repair}"
            )


def drawn(answer: Beside) -> CodeTable:
    """The table of the only interface; raises PoundingError where there are several."""
    if len(answer.tables) > 1:
        raise PoundingError(
            f'figure: shows one of {len(answer.tables)} interfaces; add --interface "{answer.tables[0][0]}"'
        )
    return answer.tables[0][1]


def _site(
    height: Sequence[float | str], behaviour_factor: Sequence[str], factor: Sequence[float], ground: float | str | None
) -> Site:
    """Heights, factors and design acceleration of a site; raises PoundingError for what is out of its range."""
    heights = _pair("height", [si(text, HEIGHT, "height") for text in height], '"12 m"', '"20 m"')
    factors = _pair("factor", factor, "0.8", "1") or (1.0, 1.0)
    if behaviour_factor and not factor:
        factors = _by_side_or_both("behaviour_factor", behaviour_factor, FACTOR, (3, 2))
    return Site(heights=heights, factors=factors, ground=None if ground is None else si(ground, PGA, "ground"))


def _pair(name: str, numbers: Sequence[float], left: str, right: str) -> tuple[float, float] | None:
    """The values of an option that is given twice, None where it is not given."""
    if numbers and len(numbers) != 2:
        example = f"--{name} {left} --{name} {right}"
        times = "once" if len(numbers) == 1 else f"{len(numbers)} times"
        raise PoundingError(f"{name}: is given {times}; give it twice, such as {example}")
    return (numbers[0], numbers[1]) if numbers else None


def _by_side(name: str, texts: Sequence[str], quantity: Quantity, example: str) -> tuple[float, float]:
    """Numbers of texts such as left=45mm, left and right."""
    sides: dict[str, float] = {}
    for text in texts:
        side, equals, value = (word.strip() for word in text.partition("="))
        if not equals or side not in ("left", "right") or side in sides:
            raise PoundingError(f'{name}: "{text}" is not one of left and right once each; write {example}')
        try:
            sides[side] = parse(value, quantity)
        except PoundingError as error:
            raise PoundingError(f"{name}: {side}: {error}") from None
    missing = [side for side in ("left", "right") if side not in sides]
    if missing:
        raise PoundingError(f"{name}: has none for {' and '.join(missing)}; write {example}")
    return sides["left"], sides["right"]


def _moving(periods: Sequence[str], dampings: Sequence[str]) -> tuple[Any, Any]:
    """Periods and damping ratios of the two buildings; None, twice, where no period is given."""
    default = (USUAL_DAMPING, USUAL_DAMPING)
    ratios = _by_side_or_both("damping", dampings, DAMPING, (0.05, 0.02)) if dampings else default
    if periods:
        return _by_side("period", periods, PERIOD, BOTH_PERIODS), ratios
    if dampings:
        raise PoundingError(f"damping: enters together with the periods alone; write {BOTH_PERIODS} too")
    return None, None


def _by_side_or_both(
    name: str, texts: Sequence[str], quantity: Quantity, example: tuple[float, float]
) -> tuple[float, float]:
    """As `_by_side`, or one number for both."""
    if len(texts) == 1 and "=" not in texts[0]:
        value = si(texts[0], quantity, name)
        return value, value
    option = f"--{name.replace('_', '-')}"
    left, right = example
    return _by_side(name, texts, quantity, f"{option} {left}, or {option} left={left} {option} right={right}")


# ------------------------------------------------------------------------------------------------------- sheets


def sheet(answer: Given | Beside | None) -> list[Block]:
    """The rules with their clauses; with displacements or a dataset the separation that each requires."""
    if answer is None:
        return _rules()
    if isinstance(answer, Given):
        return _given_blocks(answer)
    blocks: list[Block] = []
    for place, (name, codes) in enumerate(answer.tables, start=1):
        blocks += [heading(name, f"interface-{place}")] if len(answer.tables) > 1 else []
        blocks += _code_blocks(codes)
    return blocks


def _rules() -> list[Block]:
    """Every rule with its clause, its formula and how its text is known; then the texts, and later editions."""
    rules = RULES.values()
    heads = ["rule", "clause", "year", "text", "superseded", "needs", "what it is and how it is found", "ground motion"]
    rows: list[Row] = []
    for rule in rules:
        row: Row = [rule.name, rule.clause, MISSING if rule.year is None else count(rule.year), rule.verification]
        row += ["yes" if rule.superseded else MISSING, " and ".join(rule.needs) or MISSING]
        rows.append([*row, f"{rule.title}: {rule.formula}", rule.level or MISSING])
    return [
        table("Rules of building codes.", heads, rows, keep=range(len(rows))),
        paragraph(f"{SHARED[FROM_MEMORY]}. {SHARED[QUOTED_ONLY]}."),
        facts("The texts.", [(rule.name, f"{rule.verification}: {rule.source}") for rule in rules if rule.source]),
        facts(
            "Superseded, as far as it is known here, from memory.",
            [(rule.name, f"{rule.clause}, by {rule.superseded}") for rule in rules if rule.superseded],
        ),
        facts(f"{SUPERSEDED}.", _in_force()),
        paragraph(f"Ground motions are from memory. {RATIONAL}."),
    ]


def _in_force() -> list[tuple[str, str]]:
    """What is known of which edition is in force, once for rules that share it."""
    names_of: dict[str, list[str]] = {}
    for rule in RULES.values():
        if rule.in_force:
            names_of.setdefault(rule.in_force, []).append(rule.name)
    return [(", ".join(names), words) for words, names in names_of.items()]


def _given_blocks(answer: Given) -> list[Block]:
    """Each rule's separation of given elastic design displacements, with its factor, level and clause."""
    heads = ["rule", head("separation", "m"), "factor is", "clause", "text", "ground motion of the clause", "note"]
    plain_rows = [replace(row, note="; ".join(_parts(row, (NOT_REDUCED,)))) for row in answer.rows]
    rows: list[Row] = []
    for row in plain_rows:
        rule = RULES[row.rule]
        cells: Row = [row.rule, length(row.separation), rule.factor or MISSING, row.clause, row.verification]
        rows.append([*cells, rule.level or MISSING, _own_note(row)])
    left, right = (number(peak, "m")["text"] for peak in answer.displacements)
    factors = answer.site.factors
    if factors == (1.0, 1.0):
        factor_note = "No --behaviour-factor is given: they are taken to be the design displacements of every rule."
    else:
        factor_note = "Every rule takes the same factor: only rows whose own factor it is hold; run again for another."
    lines = [
        f"Of elastic design displacements of {left} mm and {right} mm, times {factors[0]:g} and {factors[1]:g}.",
        factor_note,
        *_period_notes(answer),
        "Displacements belong to the ground motion of the clause, and to the height at which the two can touch.",
        *_footnotes(plain_rows),
        "Factors and ground motions are from memory.",
    ]
    return [
        table("Separations of given displacements.", heads, rows, keep=range(len(rows))),
        paragraph("\n".join(lines)),
        facts(f"{SUPERSEDED}.", _in_force()),
    ]


def _period_notes(answer: Given) -> list[str]:
    """What the double difference was found from."""
    if answer.periods is None or answer.dampings is None:
        return []
    correlation = white_noise_correlation(answer.periods, answer.dampings)
    periods, ratios = (" and ".join(f"{value:g}" for value in pair) for pair in (answer.periods, answer.dampings))
    note = "" if answer.dampings != (USUAL_DAMPING, USUAL_DAMPING) else f" {USUAL_DAMPING} is taken without --damping."
    return [
        f"The double difference (cqc) is of periods of {periods} s and damping ratios of {ratios}: a correlation of "
        f"{correlation:.3f} under white noise.{note}"
    ]


def _code_blocks(one: CodeTable) -> list[Block]:
    """Each rule beside what the motions need, then the finding."""
    share = f"{one.percentile:g} %"
    heads = ["rule", "text", head("median", "m"), head(share, "m"), "over the gap needed", "insufficient for", "note"]
    rows = [
        [rule.row.rule, rule.row.verification, *compared(rule, one.motions), _own_note(rule.row)] for rule in one.rules
    ]
    notes = [f"Separations are {OWN_PEAKS}.", *_footnotes([comparison.row for comparison in one.rules])]
    rest = f"; {one.without} more close no gap" if one.without else ""
    median, upper = (number(rounded_up(gap), "m")["text"] for gap in (one.demand_median, one.demand))
    pairs: list[tuple[str, Cell | str]] = [
        ("motions", f"{one.motions} {one.at}, each a record and a polarity{rest}"),
        ("gap needed", f"{median} mm in the median, {upper} mm in {share} of the motions"),
        *(
            (f"displacement, {building}", f"{number(peak, 'm')['text']} mm in the median")
            for building, peak in zip(one.buildings, one.displacements, strict=True)
        ),
        ("correlation", "–, one is rigid" if one.correlation is None else f"{one.correlation:.3f} under white noise"),
        ("finding", one.finding),
    ]
    return [
        table(
            "Separations that rules require beside the gaps that the motions need.", heads, rows, keep=range(len(rows))
        ),
        paragraph("\n".join([*notes, "`pounding-risk separations` lists the clauses."])),
        facts("", pairs),
    ]


def _parts(row: SeparationRow, excluded: Sequence[str] | Mapping[str, str]) -> list[str]:
    return [clause for clause in row.note.split("; ") if clause not in excluded]


def _own_note(row: SeparationRow) -> str:
    """A row's note without the parts that `_footnotes` explains."""
    return "; ".join(_parts(row, SHARED)) or MISSING


def _footnotes(rows: Sequence[SeparationRow]) -> list[str]:
    """Sentences for the parts of notes that many rows share."""
    return [f"{words}." for note, words in SHARED.items() if any(note in row.note for row in rows)]
