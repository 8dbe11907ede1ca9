"""The command `block`: the table of a street as rows, and a scene for each."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pounding_risk.cli._common.files import check_folder
from pounding_risk.cli._common.options import NONE, read_option
from pounding_risk.cli._common.tables import engineering, print_table
from pounding_risk.errors import PoundingError

if TYPE_CHECKING:
    from pounding_risk.scene.street.rows import Block, BlockRow
    from pounding_risk.scene.street.scenes import Contact

ORDER = 210


def block(
    street: Annotated[
        Path, typer.Argument(metavar="STREET", help="Table of a street (.csv or .geojson).", show_default=False)
    ],
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Folder for a scene a row.", show_default="none is written")
    ] = None,
    record: Annotated[
        list[str], typer.Option(help="A record of the scenes; repeat for several.", show_default="all horizontal ones")
    ] = NONE,
    pga: Annotated[str | None, typer.Option(help="Scale the records to it.", show_default="as recorded")] = None,
    limit: Annotated[str, typer.Option(help="Gap from which on buildings are no neighbours.")] = "1 m",
    gap: Annotated[str, typer.Option(help="Gap of neighbours without one.")] = "0 mm",
    storey_height: Annotated[str, typer.Option(help="Where only the height or the storeys are given.")] = "3 m",
    typology: Annotated[str, typer.Option(help="Typology of buildings without one.")] = "masonry",
    floor_load: Annotated[str, typer.Option(help="Weight of a floor, for its mass.")] = "10 kN/m^2",
    floor_area: Annotated[
        str | None, typer.Option(help="Area of floors without one.", show_default="it must be given")
    ] = None,
    floor_depth: Annotated[
        str, typer.Option(help="Depth of floors without one; floors that overlap in height meet floor to floor.")
    ] = "0.25 m",
    least_facing: Annotated[
        str | None,
        typer.Option(
            help='Share of the shorter front over which neighbours face each other, "10 %".', show_default="any"
        ),
    ] = None,
    metres: Annotated[bool, typer.Option("--metres", help="Coordinates are metres, not degrees.")] = False,
    axis: Annotated[
        str | None, typer.Option(help='Direction of the street from north, "30 deg".', show_default="its walls'")
    ] = None,
    contact_model: Annotated[str, typer.Option(help="Contact model of every interface.")] = "jankowski",
    stiffness: Annotated[str, typer.Option(help="Its β or k.")] = "2.75e9 N/m^1.5",
    restitution: Annotated[str, typer.Option(help="e, or concrete.")] = "0.65",
    yield_force: Annotated[
        str | None, typer.Option(help="F_E of floor against floor.", show_default="no yielding")
    ] = None,
    column_yield_force: Annotated[
        str | None, typer.Option(help="F_E of floor against column.", show_default="no yielding")
    ] = None,
    tolerance: Annotated[
        str | None,
        typer.Option(help="Levels of floors that meet may differ by it.", show_default="by the floors' depth"),
    ] = None,
) -> None:
    """Rows and scenes from the table of a street.

    Columns of a CSV, or properties of GeoJSON footprints, each with its unit as in "height [m]": name, street, height,
    storeys, typology, period, damping, floor mass (or floor area and floor load), gap to the building on the right, and
    in a CSV left wall and right wall. What is missing is filled by the rules below, and listed.
    """
    if out is not None:
        check_folder(out)
    from pounding_risk.models.structures.contact_points import FLOOR_DEPTH
    from pounding_risk.scene.street.defaults import LIMIT, Rules
    from pounding_risk.scene.street.rows import read_block, write_block
    from pounding_risk.scene.street.scenes import Contact
    from pounding_risk.scene.street.table import AREA, HEIGHT, LOAD
    from pounding_risk.units import DIRECTION, GAP, PGA, share

    rules = Rules(
        storey_height=read_option("--storey-height", storey_height, HEIGHT),
        typology=typology,
        floor_load=read_option("--floor-load", floor_load, LOAD),
        floor_area=None if floor_area is None else read_option("--floor-area", floor_area, AREA),
        floor_depth=read_option("--floor-depth", floor_depth, FLOOR_DEPTH),
        gap=read_option("--gap", gap, GAP),
        limit=read_option("--limit", limit, LIMIT),
        least_facing=0.0 if least_facing is None else share(least_facing, "--least-facing"),
        metres=metres,
        axis=None if axis is None else read_option("--axis", axis, DIRECTION),
    )
    tables: dict[str, Any] = {}
    if pga is not None:
        read_option("--pga", pga, PGA)
        tables["records"] = {"pga": pga}
    contact = Contact(contact_model, stiffness, _restitution(restitution), yield_force, column_yield_force, tolerance)
    _check(contact)
    records = _known(record) or None
    found = read_block(street, rules)
    print_block(found)
    found.check()
    if out is not None:
        for file in write_block(found, out, records=records, contact=contact, tables=tables):
            typer.echo(f"written: {file}")


def _restitution(text: str) -> str | float:
    """A number where it is one: a scene file has a name of a relation in quotes only."""
    try:
        return float(text)
    except ValueError:
        return text


def _check(contact: Contact) -> None:
    """Raises PoundingError that names the option of a value that no scene takes."""
    from pounding_risk.models.contact.laws import LAWS, stiffness_quantity
    from pounding_risk.scene.scene import known_law
    from pounding_risk.studies.impact import restitution_of
    from pounding_risk.units import GAP, YIELD_FORCE

    law = known_law(contact.contact_model)
    if contact.contact_model not in LAWS:
        laws = ", ".join(LAWS)
        raise PoundingError(f"--contact-model: {contact.contact_model} is for pairs; in a row choose among {laws}")
    if contact.stiffness is not None:
        read_option("--stiffness", contact.stiffness, stiffness_quantity(law))
    restitution_of(str(contact.restitution))
    for option, text, quantity in (
        ("--yield-force", contact.yield_force, YIELD_FORCE),
        ("--column-yield-force", contact.column_yield_force, YIELD_FORCE),
        ("--tolerance", contact.tolerance, GAP),
    ):
        if text is not None:
            read_option(option, text, quantity)


def _known(records: Sequence[str]) -> Sequence[str]:
    """The records, each one of the catalogue; raises PoundingError for another."""
    from pounding_risk.motions.catalogue import entry

    for each in records:
        try:
            entry(each)
        except PoundingError as error:
            raise PoundingError(f"--record: {error}") from None
    return records


def print_block(found: Block) -> None:
    """The rows, the buildings in none, what was filled in, and what a user should know."""
    from pounding_risk.scene.street.scenes import shares

    if found.rows:
        heads = ("row", "buildings", "storeys", "gaps", "from left to right")
        print_table(heads, [_row(row) for row in found.rows], "lrrrl")
    if found.alone:
        names = ", ".join(f"{house.street} {house.name}".strip() for house in found.alone)
        where = "in any direction" if found.has_footprints else "along the street"
        print(f"\nalone, no neighbour within {engineering(found.rules.limit, 'm')} {where}: {names}")
    if not found.has_footprints:
        print("\nwithout footprints it is not known what stands behind the buildings, or across the street's axis")
    if found.close:
        limit = engineering(found.rules.limit, "m")
        print(f"\ncloser than {limit}, and not neighbours in a row: no scene holds what they do to each other\n")
        lines = [(*pair.names, engineering(pair.distance, "m"), pair.reason) for pair in found.close]
        print_table(("building", "and", "clear distance", "why not in a row"), lines, "llrl")
        print("give such buildings a table of their own, and with --axis the direction from one to the other")
    if found.filled:
        print()
        lines = [(each.column, str(each.number), each.values, each.rule) for each in shares(found.filled)]
        print_table(("filled in", "buildings", "value", "rule"), lines, "lrll")
    for note in found.notes:
        print(f"note: {note}")


def _row(row: BlockRow) -> tuple[str, ...]:
    storeys = [house.storeys for house in row.buildings]
    gaps = [engineering(gap, "m") for gap in (min(row.gaps), max(row.gaps))]
    names = ", ".join(house.name for house in row.buildings)
    return row.name, str(len(row.buildings)), _span(*map(str, (min(storeys), max(storeys)))), _span(*gaps), names


def _span(low: str, high: str) -> str:
    return low if low == high else f"{low} to {high}"
