"""The command `separations`: the rules of building codes, alone, of given displacements, or beside a dataset's gaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pounding_risk.cli._common.files import draw
from pounding_risk.cli._common.options import NONE, Figure, Select, chosen_results, option, read_option, read_optional
from pounding_risk.errors import PoundingError
from pounding_risk.render.terminal import engineering, print_pairs, print_table

if TYPE_CHECKING:
    from pounding_risk.assessment.separations.table import CodeTable, Comparison, SeparationRow

ORDER = 120
SIDES = "left, then right"


def separations(
    results: Annotated[
        Path | None,
        typer.Argument(metavar="[RESULTS]", help="Dataset of a scan (.nc or .zarr).", show_default="list the rules"),
    ] = None,
    displacement: Annotated[
        list[str], option("Elastic design displacement, left=45mm; twice.", "a dataset", metavar="SIDE=LENGTH")
    ] = NONE,
    behaviour_factor: Annotated[
        list[str], option("Of these: q, Cd / Ie, μ, 3 or left=3; once or twice.", "1", metavar="[SIDE=]NUMBER")
    ] = NONE,
    percentile: Annotated[str, option('Percentile of the gap needed, "84 %".')] = "84 %",
    height: Annotated[list[str], option(f"Height of a building; twice: {SIDES}.")] = NONE,
    factor: Annotated[
        list[float], option(f"Code's displacement over the linear one, such as Cd / R; twice: {SIDES}.", "1")
    ] = NONE,
    aligned: Annotated[bool, typer.Option("--aligned", help="Floors are at the same levels.")] = False,
    alike: Annotated[bool, typer.Option("--alike", help="Same height and kind of structure too.")] = False,
    zone: Annotated[str | None, option("Of Mexico City: I, II or III.")] = None,
    intensity: Annotated[int | None, option("In China: 6 to 9.")] = None,
    structure: Annotated[str, option("In China: frame, frame and walls, or walls.")] = "frame",
    ground: Annotated[str | None, option("Design acceleration a_g S, in Italy.")] = None,
    interface: Annotated[str | None, option('Of a row, "left | right".', "every one")] = None,
    select: Select = NONE,
    figure: Figure = None,
) -> None:
    """Separations of building codes, beside those needed."""
    if results is None and figure is not None:
        raise PoundingError("--figure: needs a dataset to draw; name one, such as results.nc")
    if results is None and not (displacement or behaviour_factor):
        return print_rules()
    from pounding_risk.assessment.demands import interfaces
    from pounding_risk.assessment.options import percentile_of
    from pounding_risk.assessment.separations.rules import Site
    from pounding_risk.assessment.separations.table import code_table
    from pounding_risk.results.check import check_scan
    from pounding_risk.results.files import open_results
    from pounding_risk.results.selected_axes import with_axes
    from pounding_risk.units import PGA, Quantity

    required = percentile_of(percentile, "--percentile")
    surface = read_optional("--ground", ground, PGA)
    length = Quantity("m", 0.0, inf, "height of a building", open_low=True, open_high=True, example="12 m")
    heights = _pair("--height", [read_option("--height", text, length) for text in height], '"12 m"', '"20 m"')
    if results is None:
        if factor:
            raise PoundingError("--factor: is of a dataset's displacements; of given ones write --behaviour-factor 3")
        given, factors = _given(displacement), _behaviour(behaviour_factor)
        return print_given(given, Site(heights, factors, aligned, alike, zone, intensity, structure, surface))
    if displacement or behaviour_factor:
        name = "--displacement" if displacement else "--behaviour-factor"
        raise PoundingError(
            f"{name}: is for given displacements, without a dataset; leave {results} out, or scale the dataset's own "
            "with --factor"
        )
    factors = _pair("--factor", factor, "0.8", "1") or (1.0, 1.0)
    site = Site(heights, factors, aligned, alike, zone, intensity, structure, surface)
    chosen = chosen_results(results, select)
    dataset = with_axes(open_results(chosen) if isinstance(chosen, Path) else chosen, str(results))
    check_scan(dataset, str(results), names=("building", "building_period", "building_damping"))
    parts = _chosen(interfaces(dataset), interface)
    if len(parts) > 1 and figure is not None:
        raise PoundingError(f'--figure: shows one of {len(parts)} interfaces; add --interface "{parts[0][0]}"')
    for name, part in parts:
        table = code_table(part, required, site)
        if len(parts) > 1:
            print(f"{name}\n")
        print_code_table(table)
        if len(parts) > 1:
            print()
    draw(figure, "separations.separations_figure", table)


def _pair(option: str, values: Sequence[float], left: str, right: str) -> tuple[float, float] | None:
    """The values of an option given twice, None where it is not given; raises PoundingError for another number."""
    if values and len(values) != 2:
        example = f"{option} {left} {option} {right}"
        raise PoundingError(f"{option}: is given {len(values)} times; give it twice, such as {example}")
    return (values[0], values[1]) if values else None


def _by_side(option: str, texts: Sequence[str], example: str) -> dict[str, str]:
    """Texts of an option of the form SIDE=TEXT by side; raises PoundingError for what is not of it."""
    sides: dict[str, str] = {}
    for text in texts:
        side, equals, value = text.partition("=")
        if not equals or side.strip() not in ("left", "right") or side.strip() in sides:
            raise PoundingError(f'{option}: "{text}" is not one of left and right once each; write {example}')
        sides[side.strip()] = value.strip()
    missing = [side for side in ("left", "right") if side not in sides]
    if missing:
        raise PoundingError(f"{option}: has none for {' and '.join(missing)}; write {example}")
    return sides


def _given(texts: Sequence[str]) -> tuple[float, float]:
    """The two displacements [m] that are given, left and right."""
    from pounding_risk.assessment.separations.table import DISPLACEMENT

    example = "--displacement left=45mm --displacement right=30mm"
    sides = _by_side("--displacement", texts, example)
    quantity = DISPLACEMENT._replace(low=0.0, open_high=True)
    left, right = (read_option(f"--displacement {side}", sides[side], quantity) for side in ("left", "right"))
    return left, right


def _behaviour(texts: Sequence[str]) -> tuple[float, float]:
    """The factors of the two displacements; 1 where none is given, and one number for both."""
    from pounding_risk.units import Quantity

    number = Quantity("1", 0.0, inf, "behaviour factor", open_low=True, open_high=True, example="3")
    if len(texts) == 1 and "=" not in texts[0]:
        both = read_option("--behaviour-factor", texts[0], number)
        return both, both
    if not texts:
        return 1.0, 1.0
    example = "--behaviour-factor 3, or --behaviour-factor left=3 --behaviour-factor right=2"
    sides = _by_side("--behaviour-factor", texts, example)
    left, right = (read_option(f"--behaviour-factor {side}", sides[side], number) for side in ("left", "right"))
    return left, right


def print_given(displacements: tuple[float, float], site: Any) -> None:
    """Print each rule's separation of given elastic design displacements, with its factor, level and clause."""
    from pounding_risk.assessment.separations.rules import NOT_REDUCED, RULES, SUPERSEDED
    from pounding_risk.assessment.separations.table import separations as rows_of

    rows = rows_of(("left", "right"), displacements, site=site)
    heads = ("rule", "separation", "factor is", "clause", "text", "ground motion of the clause", "note")
    cells = []
    for row in rows:
        rule = RULES[row.rule]
        note = "; ".join(part for part in own_note(row).split("; ") if part != NOT_REDUCED) or "–"
        cells.append(
            (
                row.rule,
                _length(row.separation),
                rule.factor or "–",
                row.clause,
                row.verification,
                rule.level or "–",
                note,
            )
        )
    print_table(heads, cells, "lrlllll")
    left, right = (_length(each) for each in displacements)
    print(
        f"\nOf elastic design displacements of {left} and {right}, times {site.factors[0]:g} and {site.factors[1]:g}."
    )
    if site.factors == (1.0, 1.0):
        print("No --behaviour-factor is given: they are taken to be the design displacements of every rule.")
    else:
        print("Every rule takes the same factor: only rows whose own factor it is hold; run again for another.")
    print("Displacements belong to the ground motion of the clause, and to the height at which the two can touch.")
    plain = [replace(row, note=row.note.replace(NOT_REDUCED, "")) for row in rows]
    print("\n".join(footnotes(plain)))
    print(f"Factors and ground motions are from memory. {SUPERSEDED}:")
    print_in_force()


def print_in_force() -> None:
    """Print what is known of which edition is in force, one line for rules that share it."""
    from pounding_risk.assessment.separations.rules import RULES

    known: dict[str, list[str]] = {}
    for rule in RULES.values():
        if rule.in_force:
            known.setdefault(rule.in_force, []).append(rule.name)
    print_pairs((", ".join(names), words) for words, names in known.items())


def _chosen(parts: list[tuple[str, Any]], name: str | None) -> list[tuple[str, Any]]:
    """The part of the dataset of the interface of this name, or all; raises PoundingError for an unknown name."""
    chosen = [part for part in parts if name in (None, part[0])]
    if not chosen:
        names = ", ".join(part[0] for part in parts)
        raise PoundingError(f"--interface: {name!r} is not in the dataset, which has {names}")
    return chosen


def print_rules() -> None:
    """Print every rule with its clause, its formula and how its text is known; then the texts, and later editions."""
    from pounding_risk.assessment.separations.rules import (
        FROM_MEMORY,
        QUOTED_ONLY,
        RATIONAL,
        RULES,
        SHARED,
        SUPERSEDED,
    )

    heads = ("rule", "clause", "year", "text", "superseded", "needs", "what it is and how it is found", "ground motion")
    lines = [
        (
            rule.name,
            rule.clause,
            "–" if rule.year is None else str(rule.year),
            rule.verification,
            "yes" if rule.superseded else "–",
            " and ".join(rule.needs) or "–",
            f"{rule.title}: {rule.formula}",
            rule.level or "–",
        )
        for rule in RULES.values()
    ]
    print_table(heads, lines, "llrlllll")
    print(f"\n{SHARED[FROM_MEMORY]}. {SHARED[QUOTED_ONLY]}. The texts:\n")
    print_pairs((rule.name, f"{rule.verification}: {rule.source}") for rule in RULES.values() if rule.source)
    print("\nSuperseded, as far as it is known here, from memory:\n")
    print_pairs((rule.name, f"{rule.clause}, by {rule.superseded}") for rule in RULES.values() if rule.superseded)
    print(f"\n{SUPERSEDED}:\n")
    print_in_force()
    print(f"\nGround motions are from memory. {RATIONAL}.")


def footnotes(rows: Sequence[SeparationRow]) -> list[str]:
    """Sentences for the parts of notes that many rows share, which `own_note` leaves out."""
    from pounding_risk.assessment.separations.rules import SHARED

    return [f"{words}." for note, words in SHARED.items() if any(note in row.note for row in rows)]


def own_note(row: SeparationRow) -> str:
    """A row's note without the parts that `footnotes` explains."""
    from pounding_risk.assessment.separations.rules import SHARED

    return "; ".join(part for part in row.note.split("; ") if part not in SHARED) or "–"


def print_code_table(table: CodeTable) -> None:
    """Print each rule beside what the motions need, then the finding."""
    from pounding_risk.assessment.separations.rules import OWN_PEAKS
    from pounding_risk.statistics.required_gap import rounded_up

    left, right = table.buildings
    percentile = f"{table.percentile:g} %"
    heads = ("rule", "text", "median", percentile, "over the gap needed", "falls short in", "note")
    print_table(heads, [_cells(comparison, table.motions) for comparison in table.rules], "llrrrrl")
    print()
    notes = footnotes([comparison.row for comparison in table.rules])
    print("\n".join([f"Separations are {OWN_PEAKS}.", *notes, "`pounding-risk separations` lists the clauses."]))
    print()
    still = f"; {table.without} more close no gap" if table.without else ""
    correlation = "–, one is rigid" if table.correlation is None else f"{table.correlation:.3f}"
    median, upper = (_length(rounded_up(gap)) for gap in (table.demand_median, table.demand))
    print_pairs(
        [
            ("motions", f"{table.motions} {table.at}, each a record and a polarity{still}"),
            ("gap needed", f"{median} in the median, {upper} in {percentile} of the motions"),
            (f"displacement, {left}", f"{_length(table.displacements[0])} in the median"),
            (f"displacement, {right}", f"{_length(table.displacements[1])} in the median"),
            ("correlation", f"{correlation} under white noise"),
            ("finding", table.finding),
        ]
    )


def _cells(comparison: Comparison, n_motions: int) -> tuple[str, ...]:
    """Cells of a rule: its text, separations, ratio to the gap needed, and motions in which it falls short."""
    row = comparison.row
    if comparison.exceeded is None:
        return row.rule, row.verification, _length(row.separation), "–", "–", "–", own_note(row)
    ratio = f"{comparison.ratio_median:.2f} ({comparison.ratio_low:.2f} to {comparison.ratio_high:.2f})"
    short = f"{round(comparison.exceeded * n_motions)} of {n_motions}"
    lengths = _length(comparison.middle), _length(comparison.upper)
    return row.rule, row.verification, *lengths, ratio, short, own_note(row)


def _length(value: float | None) -> str:
    return "–" if value is None else engineering(value, "m")
