"""The command `records list`: the records of the catalogue, of a set, or of a folder; kinds of generated motions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pounding_risk.cli._common.options import option
from pounding_risk.cli.records._options import Set, Step, Unit, find_sources, stated_facts
from pounding_risk.errors import PoundingError
from pounding_risk.render.terminal import engineering, one_line, print_left_out, print_table

if TYPE_CHECKING:
    from pounding_risk.motions.record import Source

ORDER = 10
HEADS = ("record", "event", "date", "station", "component", "state", "PGA", "duration", "dt")


def list(
    set: Set = None,
    folder: Annotated[
        Path | None,
        option("A folder of record files, or a grid of sites (EventGrid.csv, or EventGrid.csv#23.73,37.98)."),
    ] = None,
    unit: Unit = None,
    dt: Step = None,
    generated: Annotated[
        bool, typer.Option("--generated", help="Kinds of generated motions, with their keys.", show_default=False)
    ] = False,
) -> None:
    """The records of the catalogue, of a set, or of a folder; or the kinds of generated motions."""
    if generated:
        return print_kinds()
    if set is None and folder is None:
        from pounding_risk.motions.catalogue import entries

        cells = [_cells(asdict(entry), entry.pga, entry.duration, entry.dt) for entry in entries()]
        return print_table(HEADS, cells, "llllllrrr")
    if folder is not None and not folder.is_dir():
        from pounding_risk.motions.formats import split_component
        from pounding_risk.motions.sites.event_grid import is_grid

        if not is_grid(split_component(folder)[0]):
            raise PoundingError(f"--folder: {folder} is not a folder, nor a grid of sites; check the name")
    sources = find_sources([str(folder)] if folder else [], set, stated_facts(unit, dt), lenient=True)
    print_sources([source for group in sources.groups for source in group])
    print_left_out(sources.left_out)


def print_kinds() -> None:
    """Print the kinds of generated motions: what each is, and its keys, those that it needs with an example."""
    from pounding_risk.motions.generated import motion_kinds

    rows = []
    for name, kind in motion_kinds().items():
        other_keys = ", ".join(key for key in kind.options if key not in kind.needed)
        needed_keys = ", ".join(f"{key} = {kind.options[key].example}" for key in kind.needed)
        rows.append((name, kind.words, needed_keys, other_keys))
    print_table(("kind", "what it is", "needs", "takes"), rows, "llll")


def print_sources(sources: Sequence[Source]) -> None:
    """Print records that were read, one line each; those of a site with the factor of its table in the PGA."""
    from pounding_risk.motions.read import file_name
    from pounding_risk.motions.record import FACTOR_OF_SITE

    rows = []
    for source in sources:
        stats = source.trace.stats
        facts = {**source.record, "id": file_name(source)}
        pga = source.record["pga_recorded"] * source.record.get(FACTOR_OF_SITE, 1.0)
        rows.append(_cells(facts, pga, (stats.npts - 1) * stats.delta, stats.delta))
    print_table(HEADS, rows, "llllllrrr")


def _cells(facts: Mapping[str, Any], pga: float, duration: float, dt: float) -> tuple[str, ...]:
    """Cells of a record, from its facts, PGA [m/s2], duration [s] and time step [s]."""
    words = [one_line(facts.get(key) or "") for key in ("id", "event", "date", "station", "component", "state")]
    return *words, engineering(pga, "m/s2", 3), f"{duration:.4g} s", f"{dt:.4g} s"
