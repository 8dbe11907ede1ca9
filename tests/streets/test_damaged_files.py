"""Files of streets, maps and inventories that are damaged: a block or an inventory, or sentences in plain letters."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from damaged_tables import survey
from sweeps import sweep
from test_inventory import ASSETS, FEATURES, METADATA, OED, R2D, exposure
from test_maps import in_degrees, made_street, write
from test_street import STREETS

from pounding_risk.streets.inventory import read_inventory
from pounding_risk.streets.rows import Block, read_block
from pounding_risk.streets.table import BlockError

ALONE = ASSETS.format("a", "b").replace("X,Y,TAX", "lon,lat,tax")
INVENTORIES = {"oed.csv": OED, "r2d.csv": R2D, "r2d.geojson": FEATURES, "assets.csv": ALONE, "metadata.xml": METADATA}
# By the name of the file: its reader, and how many copies are made.
FILES = {
    **{
        name: (read_block, 40)
        for name in ("street.csv", "street.geojson", "street.gpkg", "street.fgb", "street.parquet")
    },
    **{name: (read_inventory, 80) for name in INVENTORIES},
}


def sound(path: Path) -> None:
    """Write the file as it should be."""
    if path.name in INVENTORIES:
        exposure(path.parent)
        path.write_text(INVENTORIES[path.name], encoding="utf-8")
    elif path.suffix in (".csv", ".geojson"):
        path.write_bytes((STREETS / path.name).read_bytes())
    else:
        write(path, in_degrees(made_street(), 15.0, 40.0), "EPSG:4326")


def in_words(read: Callable[[Path], Any], path: Path) -> Any:
    try:
        return read(path)
    except BlockError as error:
        assert error.faults and all(len(fault) > 20 and fault.isprintable() for fault in error.faults), error.faults
        raise


@pytest.mark.parametrize("times", sweep([1, 5], 1))
@pytest.mark.parametrize("name", FILES)
def test_damaged_files_are_read_or_refused_in_words(tmp_path, name, times):
    path, (read, count) = tmp_path / name, FILES[name]
    sound(path)

    def check(found: Any) -> None:
        assert not isinstance(found, Block) or found.houses

    found = survey(path, lambda: in_words(read, path), check, count * times, longest=20_000)
    assert found["refused"] >= count * times / 10
