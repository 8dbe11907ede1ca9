"""The command `block`: the rows of buildings in the table of a street, and a scene for each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from math import isnan
from os.path import relpath
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pounding_risk._common.counted import counted
from pounding_risk._common.words import listed
from pounding_risk.cli._common import options as shared
from pounding_risk.cli._common.files import announce, check_folder
from pounding_risk.errors import PoundingError
from pounding_risk.render.terminal import engineering, print_notes, print_table
from pounding_risk.units import GAP, PGA, YIELD_FORCE, parse, share, shown

if TYPE_CHECKING:
    from pounding_risk.streets.neighbours import BlockRow, Neighbours
    from pounding_risk.streets.rows import Block
    from pounding_risk.streets.scenes import Contact

ORDER = 210
HELP = """Rows and scenes from a street's table or footprints.

Columns of a CSV, or properties of footprints (GeoJSON, GeoPackage, FlatGeobuf, GeoParquet), each with its unit as
in "height [m]": name, street, height, storeys, typology, period, damping, floor mass (or floor area and floor
load), gap to the building on the right, and in a CSV left wall and right wall. Attributes of OpenStreetMap and
Overture are read as they are. What is missing is filled by the rules below, and listed.
"""


def _of(kind: Any, help: str, default: Any = None, absence: str | None = None, flags: tuple[str, ...] = ()) -> Any:
    """An option of a kind, with its default, or with words on what holds in its ``absence``."""
    return Annotated[kind if default is not None else kind | None, shared.option(help, absence, *flags)], default


OPTIONS: shared.Fields = {
    "street": (
        Annotated[
            Path,
            shared.argument("STREET", "Table of a street (.csv), or footprints (.geojson, .gpkg, .fgb, .parquet)."),
        ],
        shared.REQUIRED,
    ),
    "out": _of(Path, "Folder for a scene a row.", None, "none is written", ("--out", "-o")),
    "record": _of(list[str], "A record of the scenes; repeat for several.", shared.NONE, "all horizontal ones"),
    "sites": _of(Path, "EventGrid.csv: motions of the site nearest to each row, in place of records.", absence="none"),
    "unit": _of(str, "Unit of the motions of --sites, g or m/s^2.", absence="as the files say"),
    "pga": _of(str, "Scale the records to it.", absence="as recorded"),
    "limit": _of(str, "Gap from which on buildings are no neighbours.", "1 m"),
    "gap": _of(str, "Gap of neighbours without one.", "0 mm"),
    "storey_height": _of(str, "Where only the height or the storeys are given.", "3 m"),
    "typology": _of(str, "Typology of buildings without one.", "masonry"),
    "floor_load": _of(str, "Weight of a floor, for its mass.", "10 kN/m^2"),
    "floor_area": _of(str, "Area of floors without one.", absence="it must be given"),
    "floor_depth": _of(
        str, "Depth of floors without one; floors that overlap in height meet floor to floor.", "0.25 m"
    ),
    "storeys": _of(int, "Of buildings without height and storeys.", absence="a fault"),
    "chain": _of(str, "Storeys of the typology, or hazus.", "typology"),
    "code_level": _of(str, "Code of storeys by hazus: high, moderate, low, pre.", absence="moderate"),
    "least_facing": _of(
        str, 'Share of the shorter front over which neighbours face each other, "10 %".', absence="any"
    ),
    "metres": _of(bool, "Coordinates are metres east and north, not degrees.", False, flags=("--metres",)),
    "resolution": _of(
        str, 'Measured gaps are uniform within it, "0.5 m".', absence="what the file says, such as its last decimal"
    ),
    "layer": _of(str, "Layer of a GeoPackage.", absence="its only one of polygons"),
    "within": _of(
        str, 'Only buildings in "west, south, east, north" in degrees, or in the polygons of a file.', absence="all"
    ),
    "inventory": _of(
        Path,
        "Values of the buildings of a map: OED, R2D, OpenQuake, or a street's .csv.",
        absence="those of the map",
    ),
    "samples": _of(int, "Samples of uncertain gaps.", absence="128"),
    "axis": _of(str, 'Direction of the street from north, "30 deg".', absence="its walls'"),
    "contact_model": _of(str, "Contact model of every interface.", "jankowski"),
    "stiffness": _of(str, "Its β or k; `advise` says which.", "8e10 N/m^1.5"),
    "restitution": _of(str, "e, or concrete.", "0.65"),
    "yield_force": _of(str, "F_E of floor against floor.", absence="no yielding"),
    "column_yield_force": _of(str, "F_E of floor against column.", absence="no yielding"),
    "tolerance": _of(str, "Levels of floors that meet may differ by it.", absence="by the floors' depth"),
}
AS_THEY_ARE = ("typology", "metres", "storeys", "chain", "code_level")  # of the rules
# The columns that an option fills, and words of the rule that says so.
FILLS = {
    "gap": (("gap",), "stated"),
    "storey_height": (("height", "storeys"), " at {:g} m "),
    "typology": (("typology",), "stated"),
    "floor_load": (("floor load",), "stated"),
    "floor_area": (("floor area",), "stated"),
    "floor_depth": (("floor depth",), "stated"),
    "storeys": (("storeys",), "stated"),
    "code_level": (("code level",), ""),
}
WITHOUT_EFFECT = {  # by whether all buildings have footprints, or none has
    True: {
        "gap": "the gaps of a map are the distances of its footprints; write a measured one as its gap [mm]",
        "floor_area": "the area of a floor is that of its footprint; write another one as its floor area [m^2]",
    },
    False: {
        "axis": "a table has no footprints whose direction matters",
        "least_facing": "a table has no footprints that face each other over a part",
    },
}
NUMBERS = ("storey_height", "floor_load", "floor_area", "floor_depth", "gap", "limit", "axis", "resolution")


def _run(options: dict[str, Any]) -> None:
    """Print the rows of a street, and write a scene for each where a folder is given."""
    out, record, samples, tolerance = (options[name] for name in ("out", "record", "samples", "tolerance"))
    if out is not None:
        check_folder(out)
    from pounding_risk.streets.defaults import RANGES, Rules
    from pounding_risk.streets.rows import read_block, write_block
    from pounding_risk.streets.scenes import Contact

    least_facing = options["least_facing"]
    rule_values = {name: options[name] for name in AS_THEY_ARE}
    rule_values["least_facing"] = 0.0 if least_facing is None else share(least_facing, "--least-facing")
    rule_values |= {
        name: shared.read_optional(f"--{name.replace('_', '-')}", options[name], RANGES[name]) for name in NUMBERS
    }
    rules = Rules(**rule_values)
    tables = _tables(options)
    contact = Contact(**{name: options[name] for name in Contact._fields})
    with suppress(ValueError):  # a number as a scene file has it; otherwise the name of a relation
        contact = contact._replace(restitution=float(options["restitution"]))
    _check_contact(contact)
    _check_records(record)
    rows = read_block(options["street"], rules, **{name: options[name] for name in ("layer", "within", "inventory")})
    if samples is not None and not rows.resolution.size > 0.0:
        repair = "state --resolution" if options["resolution"] is None else "state a --resolution above 0 m"
        raise PoundingError(f"--samples: no gap of this street is uncertain; {repair}, or leave it out")
    unused = _without_effect(options, rows)
    print_block(rows, None if tolerance is None else parse(tolerance, GAP))
    print_notes(unused)
    rows.check()
    if out is not None:
        paths = write_block(rows, out, records=record or None, contact=contact, tables=tables)
        *scenes, _, _, _ = paths
        unnamed = scenes[LISTED:]
        announce(*(path for path in paths if path not in set(unnamed)))
        if unnamed:
            print(f"and {counted(len(unnamed), 'more scene')}, the last of them {unnamed[-1].name}")
        if other_names := sorted(path.name for path in set(out.glob("*.toml")) - set(paths)):
            names = listed(other_names, LISTED)
            print_notes([f"{names} in {out}: not of this street, or of an earlier run; *.toml reads these too"])


block = shared.with_options(_run, OPTIONS, HELP)


def _without_effect(options: Mapping[str, Any], block: Block) -> list[str]:
    """Notes on options for values that no building lacks; raises PoundingError for one that such a file never needs."""
    stated_options = [name for name in options if options[name] != OPTIONS[name][1]]
    kinds = {house.footprint is not None for house in block.houses}
    for name, reason in WITHOUT_EFFECT[kinds.pop()].items() if len(kinds) == 1 else ():
        if name in stated_options:
            raise PoundingError(f"--{name.replace('_', '-')}: {reason}; leave the option out")
    notes = []
    for name in (name for name in FILLS if name in stated_options):
        columns, rule = FILLS[name][0], FILLS[name][1].format(block.rules.storey_height)
        if not any(item.column in columns and rule in item.rule for item in block.filled):
            notes.append(f"--{name.replace('_', '-')}: without effect, as nothing in this street lacks what it states")
    return notes


def _tables(options: Mapping[str, Any]) -> dict[str, Any]:
    """The tables of every scene beside its buildings and contact; raises PoundingError for options that contradict."""
    pga, unit, samples = options["pga"], options["unit"], options["samples"]
    shared.read_optional("--pga", pga, PGA)
    tables: dict[str, Any] = {} if pga is None else {"records": {"pga": pga}}
    if options["sites"] is not None:
        tables["records"] = {"sites": _sites(options)} | ({} if unit is None else {"unit": unit})
    elif unit is not None:
        raise PoundingError("--unit: is that of the motions of --sites, which is not given; leave it out")
    if samples is None:
        return tables
    if samples < 1:
        repair = 'write one such as 128, or --resolution "0 m" for gaps that are known'
        raise PoundingError(f"--samples: {samples} would draw none; {repair}")
    return tables | {"uncertain": {"samples": samples}}


def _sites(options: Mapping[str, Any]) -> str:
    """The grid of sites as the scenes name it; raises PoundingError for records beside it."""
    from pounding_risk.motions.sites.event_grid import read_grid

    for name in ("record", "pga"):
        if options[name]:
            raise PoundingError(f"--sites: the motions of the sites are taken as they are; leave --{name} out")
    read_grid(options["sites"])
    try:
        return Path(relpath(options["sites"], options["out"] or Path())).as_posix()
    except ValueError:  # on different drives
        return str(options["sites"].resolve().as_posix())


def _check_contact(contact: Contact) -> None:
    """Raise PoundingError, which names the option, for a value that no scene takes."""
    from pounding_risk.models.contact.laws import LAWS, stiffness_quantity
    from pounding_risk.models.contact.table import TABULATED
    from pounding_risk.scene.interfaces import known_law
    from pounding_risk.studies.impact import restitution_of

    try:
        law = known_law(contact.contact_model)
    except PoundingError as error:
        raise PoundingError(f"--contact-model: {error}") from None
    if contact.contact_model not in LAWS:
        laws = ", ".join(LAWS)
        raise PoundingError(f"--contact-model: {contact.contact_model} is for pairs; in a row choose among {laws}")
    if contact.contact_model == TABULATED:
        raise PoundingError(
            f"--contact-model: {TABULATED} reads a table, for which there is no option here; choose another model, and "
            "write contact_model and table into the scenes"
        )
    if contact.stiffness is not None:
        shared.read_option("--stiffness", contact.stiffness, stiffness_quantity(law))
    restitution_of(str(contact.restitution))
    for name, text, quantity in (
        ("--yield-force", contact.yield_force, YIELD_FORCE),
        ("--column-yield-force", contact.column_yield_force, YIELD_FORCE),
        ("--tolerance", contact.tolerance, GAP),
    ):
        shared.read_optional(name, text, quantity)


def _check_records(records: Sequence[str]) -> None:
    """Raise PoundingError for a record that is not in the catalogue."""
    from pounding_risk.motions.catalogue import entry

    for record in records:
        if set(record) & set("./*"):
            repair = f"write files = [{shown(record)}] in place of names into [records] of the scenes"
            raise PoundingError(f"--record: {shown(record)} is no id of the catalogue but a file; {repair}")
        try:
            entry(record)
        except PoundingError as error:
            raise PoundingError(f"--record: {error}") from None


LISTED = 40  # lines of a table, or names; what is left out stands in the files of --out


def print_block(block: Block, tolerance: float | None) -> None:
    """Print the rows, the pairs of neighbours, the buildings in no row, the values filled in, and notes.

    ``tolerance`` [m] is that of the levels of floors that meet, None where it is the floors' depth.
    """
    from pounding_risk.streets.neighbours import INSIDE, NO_AXIS
    from pounding_risk.streets.scenes import shares

    limit = engineering(block.rules.limit, "m")
    if block.rows:
        _print_first(
            ("row", "buildings", "storeys", "gaps", "from left to right"), [_row(row) for row in block.rows], "lrrrl"
        )
        print()
        pairs = [pair for row in block.rows for pair in row.pairs]
        heads = ("neighbours", "and", "gap", "shared face", "floors meet", "miss", "largest offset")
        _print_first(heads, [_neighbours(pair, tolerance) for pair in pairs], "llrrrrr")
        print(f"\n{block.gap_words}")
    if block.sides:
        counts = ", ".join(f"{number} on {words}" for words, number in block.sides_adjoined())
        print(f"sides on which another building stands within {limit}, by buildings: {counts}")
    if block.alone:
        direction = "in any direction" if block.has_footprints else "along the street"
        names = [f"{building.street} {building.name}".strip() for building in block.alone]
        print(f"\nalone, no neighbour within {limit} {direction}: {listed(names, LISTED)}")
    if not block.has_footprints:
        print("\nwithout footprints it is not known what stands behind the buildings, or across the street's axis")
    if block.close:
        print(f"\ncloser than {limit}, and not neighbours in a row: no scene holds what they do to each other\n")
        lines = [(*pair.names, engineering(pair.distance, "m"), pair.reason) for pair in block.close]
        _print_first(("building", "and", "clear distance", "why not in a row"), lines, "llrl")
        is_inside = [pair.reason == INSIDE for pair in block.close]
        if not all(is_inside):
            print("give such buildings a table of their own, and with --axis the direction from one to the other")
        if any(is_inside):
            print(f"where {INSIDE}, {NO_AXIS}")
    if block.filled:
        print()
        lines = [(share.column, str(share.number), share.values, share.rule) for share in shares(block.filled)]
        print_table(("filled in", "buildings", "value", "rule"), lines, "lrll")
    print_notes(block.notes[:LISTED])
    if len(block.notes) > LISTED:
        print(f"and {len(block.notes) - LISTED} more notes, as of the first ones")


def _print_first(heads: tuple[str, ...], lines: Sequence[tuple[str, ...]], sides: str) -> None:
    """Print the first lines of a table, and how many are left out."""
    print_table(heads, lines[:LISTED], sides)
    if len(lines) > LISTED:
        print(f"and {len(lines) - LISTED} more, which --out writes to files")


def _neighbours(pair: Neighbours, tolerance: float | None) -> tuple[str, ...]:
    """Cells of two neighbours: their gap, or its range where it is uncertain, shared face and floors."""
    from pounding_risk.streets.neighbours import floors

    meet, miss, offset = floors(pair.left, pair.right, tolerance)
    gap = _range_words(*(engineering(end, "m") for end in pair.gaps))
    face = "not known" if isnan(pair.faced) else engineering(pair.faced, "m")
    return pair.left.name, pair.right.name, gap, face, str(meet), str(miss), engineering(offset, "m")


def _row(row: BlockRow) -> tuple[str, ...]:
    """Cells of a row of buildings: its name, and ranges of storeys and gaps."""
    storeys = [building.storeys for building in row.buildings]
    gaps = [engineering(gap, "m") for gap in (min(row.gaps), max(row.gaps))]
    names = ", ".join(building.name for building in row.buildings)
    return (
        row.name,
        str(len(row.buildings)),
        _range_words(str(min(storeys)), str(max(storeys))),
        _range_words(*gaps),
        names,
    )


def _range_words(low: str, high: str) -> str:
    return low if low == high else f"{low} to {high}"
