"""Inventories of buildings in the formats of other tools: a module of this folder for each, recognised by its head.

A module states ``WORDS`` (what the file is), ``recognises(heads)`` for the columns of a table or the properties of
features, in lower case, and ``buildings(sheet, faults, notes)``, which reads them.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from types import ModuleType
from typing import NamedTuple

from pounding_risk._common.counted import counted
from pounding_risk.streets.inventory._lines import Building, Notes, heads_of, sheet_of
from pounding_risk.streets.inventory.openquake import METADATA, metadata_sheet
from pounding_risk.streets.table import BlockError, Entry, Mapped, Table, file_text, need_maps

ENDINGS = (".csv", ".geojson", ".json", METADATA)


class Inventory(NamedTuple):
    """The buildings of an inventory, what its file is, and sentences on what is not read or doubtful."""

    entries: list[Building]
    left_out: list[str]
    kind: str  # "an OED location file"


def formats() -> Mapping[str, ModuleType]:
    """The modules of the formats, by their names."""
    names = sorted(module.name for module in iter_modules(__path__) if not module.name.startswith("_"))
    modules = {name: import_module(f"{__name__}.{name}") for name in names}
    return {name: module for name, module in modules.items() if hasattr(module, "recognises")}


def inventory_format(path: Path, text: str) -> ModuleType | None:
    """The format of a file, recognised by its head; None where it is no inventory."""
    if path.suffix.lower() == METADATA:
        return formats()["openquake"]
    heads = frozenset(heads_of(path, text))
    return next((module for module in formats().values() if module.recognises(heads)), None)


def read_inventory(path: str | Path) -> Inventory:
    """Read an inventory of buildings: OED, SimCenter R2D, or an exposure model of OpenQuake.

    Parameters
    ----------
    path : str or Path
        A location file of OED (.csv), assets of R2D (.csv or .geojson), or an exposure of OpenQuake: its metadata
        (.xml), which name the tables beside them, or one table (.csv).

    Returns
    -------
    Inventory
        ``entries``, each a `Building`: `values` by column as of a street's table (SI), `longitude` and `latitude` in
        degrees (NaN where the file has none), `footprint` as well-known text in degrees ("" for none), `taxonomy` and
        `year`; `derived` lists values that follow from a code or a convention of the format. ``left_out`` are notes,
        ``kind`` is what the file is.

    Raises
    ------
    BlockError
        For a file that is no inventory, and with every fault of one that is.
    """
    file = Path(path)
    if file.suffix.lower() not in ENDINGS:
        raise BlockError(str(file), [f'"{file.suffix}" is no inventory; give one of {", ".join(ENDINGS)}'])
    text = file_text(file)
    module = inventory_format(file, text)
    if module is None:
        formats_text = "; ".join(module.WORDS for module in formats().values())
        raise BlockError(str(file), [f"its head is that of no inventory; known are {formats_text}"])
    faults: list[str] = []
    notes = Notes()
    sheet = metadata_sheet(file, text, faults) if file.suffix.lower() == METADATA else sheet_of(file, text, faults)
    buildings = list(module.buildings(sheet, faults, notes))
    if not faults and not buildings:
        faults.append(f"has no building; write a line for each below the head of {module.WORDS}")
    if faults:
        raise BlockError(str(file), faults)
    return Inventory(buildings, [*notes.sentences()], module.WORDS)


def inventory_table(path: Path, metres: bool = False) -> Table | None:
    """The buildings of an inventory as a table of a street; None where the file is no inventory.

    Raises BlockError where it does not say which buildings are neighbours.
    """
    if path.suffix.lower() not in ENDINGS or not path.is_file() or inventory_format(path, file_text(path)) is None:
        return None
    if metres:
        raise BlockError(str(path), ["an inventory has its coordinates in degrees; leave --metres (metres=True) out"])
    inventory = read_inventory(path)
    if missing := [one for one in inventory.entries if not one.footprint and "left wall" not in one.values]:
        number = counted(len(missing), "building")
        sentence = (
            f"{inventory.kind}: {number} of {len(inventory.entries)}, first {missing[0].place}, without footprint: who "
            "stands beside whom is not known; give the footprints and the inventory beside them, `pounding-risk block "
            f"footprints.gpkg --inventory {path.name}`, or write columns 'left wall [m]' and 'right wall [m]'"
        )
        raise BlockError(str(path), [sentence])
    entries = [
        Entry(one.place, one.values, None, Mapped(one.values.get("name", ""), one.longitude, one.latitude), one.derived)
        for one in inventory.entries
    ]
    notes = [f"read as {inventory.kind}", *inventory.left_out]
    outlines = [one.footprint for one in inventory.entries]
    if not all(outlines):
        return Table(entries, notes)
    need_maps(str(path))
    import shapely

    from pounding_risk.streets.maps import outlined_table

    shapes = [shapely.from_wkt(outline, on_invalid="ignore") for outline in outlines]
    shaped = [entry._replace(footprint=shape) for entry, shape in zip(entries, shapes, strict=True)]
    return outlined_table(path, shaped, notes)
