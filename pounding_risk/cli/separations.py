"""What `separations` prints: every rule of the codes, or each beside what the motions of a dataset ask for."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pounding_risk.cli._common.files import FIGURES, draw, writable
from pounding_risk.cli._common.options import NONE, Figure, read_option
from pounding_risk.cli._common.tables import engineering, print_pairs, print_table
from pounding_risk.errors import PoundingError

if TYPE_CHECKING:
    from pounding_risk.assessment.separations.table import CodeTable, Comparison, SeparationRow

ORDER = 120
NO_NUMBERS: list[float] = []
ROW_HEADS, ROW_SIDES = ("rule", "clause", "text", "separation", "note"), "lllrl"
SIDES = "left, then right"


def separations(
    results: Annotated[
        Path | None,
        typer.Argument(metavar="[RESULTS]", help="Dataset of a scan (.nc or .zarr).", show_default="list the rules"),
    ] = None,
    percentile: Annotated[str, typer.Option(help='Percentile of the gap needed, "84 %".')] = "84 %",
    height: Annotated[
        list[str], typer.Option(help=f"Height of a building; twice: {SIDES}.", show_default=False)
    ] = NONE,
    factor: Annotated[
        list[float],
        typer.Option(
            help=f"Code's displacement over the linear one, such as Cd / R; twice: {SIDES}.", show_default="1"
        ),
    ] = NO_NUMBERS,
    aligned: Annotated[bool, typer.Option("--aligned", help="Floors are at the same levels.")] = False,
    alike: Annotated[bool, typer.Option("--alike", help="Same height and kind of structure too.")] = False,
    zone: Annotated[str | None, typer.Option(help="Of Mexico City: I, II or III.", show_default=False)] = None,
    intensity: Annotated[int | None, typer.Option(help="In China: 6 to 9.", show_default=False)] = None,
    structure: Annotated[str, typer.Option(help="In China: frame, frame and walls, or walls.")] = "frame",
    ground: Annotated[str | None, typer.Option(help="Design acceleration a_g S, in Italy.", show_default=False)] = None,
    interface: Annotated[str | None, typer.Option(help='Of a row, "left | right".', show_default="every one")] = None,
    figure: Figure = None,
) -> None:
    """Separations of building codes, beside those needed."""
    figure_file = writable("--figure", figure, FIGURES)
    if results is None:
        if figure_file is not None:
            raise PoundingError("--figure: needs a dataset to draw; name one, such as results.nc")
        print_rules()
        return
    from pounding_risk.assessment.demands import interfaces
    from pounding_risk.assessment.options import percentile_of
    from pounding_risk.assessment.separations.table import Site, code_table
    from pounding_risk.results.check import check_scan
    from pounding_risk.results.files import open_results
    from pounding_risk.units import PGA

    required = percentile_of(percentile, "--percentile")
    surface = None if ground is None else read_option("--ground", ground, PGA)
    site = Site(_heights(height), _factors(factor), aligned, alike, zone, intensity, structure, surface)
    dataset = open_results(results)
    check_scan(dataset, str(results), names=("building", "building_period", "building_damping"))
    chosen = _chosen(interfaces(dataset) if "interface" in dataset.dims else [("", dataset)], interface)
    if len(chosen) > 1 and figure_file is not None:
        raise PoundingError(f'--figure: shows one of {len(chosen)} interfaces; add --interface "{chosen[0][0]}"')
    for name, one in chosen:
        table = code_table(one, required, site)
        if len(chosen) > 1:
            print(f"{name}\n")
        print_code_table(table)
        if len(chosen) > 1:
            print()
    if figure_file is not None:
        from pounding_risk.figures.separations import separations_figure

        draw(separations_figure(table), figure_file)


def _chosen(every: list[tuple[str, Any]], asked: str | None) -> list[tuple[str, Any]]:
    """The interface that is asked for, or all; raises PoundingError for one that the dataset has not."""
    if asked is None:
        return every
    found = [each for each in every if each[0] == asked]
    if not found:
        known = ", ".join(name for name, _ in every if name) or "none: it is of a pair"
        raise PoundingError(f"--interface: {asked!r} is not in the dataset, which has {known}")
    return found


def _heights(texts: Sequence[str]) -> tuple[float, float] | None:
    from pounding_risk.units import Quantity

    if not texts:
        return None
    if len(texts) != 2:
        raise PoundingError(
            f'--height: is given {len(texts)} times; give it twice, such as --height "12 m" --height "20 m"'
        )
    quantity = Quantity("m", 0.0, inf, "height of a building", open_low=True, open_high=True, example="12 m")
    left, right = (read_option("--height", text, quantity) for text in texts)
    return left, right


def _factors(values: Sequence[float]) -> tuple[float, float]:
    if not values:
        return 1.0, 1.0
    if len(values) != 2:
        raise PoundingError(f"--factor: is given {len(values)} times; give it twice, such as --factor 0.8 --factor 1")
    return values[0], values[1]


def print_rules() -> None:
    """Every rule: clause, year, how its text is known, needs and formula; then the texts, and later editions."""
    from pounding_risk.assessment.separations.rules import FROM_MEMORY, QUOTED_ONLY, RULES, SHARED

    heads = ("rule", "clause", "year", "text", "superseded", "needs", "what it is and how it is found")
    lines = [
        (
            rule.name,
            rule.clause,
            "–" if rule.year is None else str(rule.year),
            rule.verification,
            "yes" if rule.superseded else "–",
            " and ".join(rule.needs) or "–",
            f"{rule.title}: {rule.formula}",
        )
        for rule in RULES.values()
    ]
    print_table(heads, lines, "llrllll")
    print(f"\n{SHARED[FROM_MEMORY]}. {SHARED[QUOTED_ONLY]}. The texts:\n")
    print_pairs((rule.name, f"{rule.verification}: {rule.source}") for rule in RULES.values() if rule.source)
    print("\nSuperseded, as far as it is known here, from memory:\n")
    print_pairs((rule.name, f"{rule.clause}, by {rule.superseded}") for rule in RULES.values() if rule.superseded)


def separation_rows(rows: Sequence[SeparationRow]) -> list[tuple[str, ...]]:
    """Lines under `ROW_HEADS`: what each rule asks for, by its clause."""
    return [(row.rule, row.clause, row.verification, _length(row.separation), _own_note(row)) for row in rows]


def footnotes(rows: Sequence[SeparationRow]) -> list[str]:
    """What `separation_rows` leaves out of its notes because many rows share it, as sentences to print below them."""
    from pounding_risk.assessment.separations.table import SHARED

    told = [words for note, words in SHARED.items() if any(note in row.note for row in rows)]
    return [f"{words}." for words in told]


def _own_note(row: SeparationRow) -> str:
    """A row's note without what `footnotes` says."""
    from pounding_risk.assessment.separations.table import SHARED

    return "; ".join(part for part in row.note.split("; ") if part not in SHARED) or "–"


def print_code_table(table: CodeTable) -> None:
    """Each rule beside the motions, then the sentence."""
    left, right = table.buildings
    asked = f"{table.percentile:g} %"
    heads = ("rule", "text", "median", asked, "over the gap needed", "falls short in", "note")
    print_table(heads, [_line(each, table.motions) for each in table.rules], "llrrrrl")
    print()
    for sentence in (*footnotes([each.row for each in table.rules]), "`pounding-risk separations` lists the clauses."):
        print(sentence)
    print()
    still = f"; {table.without} more close no gap" if table.without else ""
    correlation = "–, one is rigid" if table.correlation is None else f"{table.correlation:.3f}"
    median, upper = (engineering(each, "m") for each in (table.demand_median, table.demand))
    print_pairs(
        [
            ("motions", f"{table.motions} {table.at}, each a record and a polarity{still}"),
            ("gap needed", f"{median} in the median, {upper} in {asked} of the motions"),
            (f"displacement, {left}", f"{engineering(table.displacements[0], 'm')} in the median"),
            (f"displacement, {right}", f"{engineering(table.displacements[1], 'm')} in the median"),
            ("correlation", f"{correlation} under white noise"),
            ("finding", table.finding),
        ]
    )


def _line(comparison: Comparison, motions: int) -> tuple[str, ...]:
    row = comparison.row
    facts = (row.rule, row.verification)
    if comparison.exceeded is None:
        return (*facts, _length(row.separation), "–", "–", "–", _own_note(row))
    ratio = f"{comparison.ratio_median:.2f} ({comparison.ratio_low:.2f} to {comparison.ratio_high:.2f})"
    short = f"{round(comparison.exceeded * motions)} of {motions}"
    return (*facts, _length(comparison.middle), _length(comparison.upper), ratio, short, _own_note(row))


def _length(value: float | None) -> str:
    return "–" if value is None else engineering(value, "m")
