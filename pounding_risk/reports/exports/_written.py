"""What an export is asked for, and what it says of the files that it wrote."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from pounding_risk._common.files import write_whole
from pounding_risk.errors import PoundingError


class Asked(NamedTuple):
    """Options of `export`, as they were read."""

    of: str | None = None  # what fragilities are of
    gap: float | None = None  # m
    pga: float | None = None  # m/s2
    intensity_level: float | str | None = None
    intensity: str | None = None
    discrete: bool = False
    without: bool = False  # without pounding
    street: Path | None = None  # footprints of a street
    inventory: Path | None = None  # of the buildings, for their taxonomy
    method: str | None = None  # by which curves of damage states follow from demands


class Written(NamedTuple):
    """Files of an export, and sentences on what is assumed and left out."""

    files: tuple[Path, ...]
    told: tuple[str, ...]


def write_file(target: Path, content: str | bytes) -> Path:
    """Write a file, text as UTF-8, whole or not at all; raises PoundingError where that fails."""
    data = content.encode() if isinstance(content, str) else content
    try:
        write_whole(target, lambda file: file.write(data))
    except OSError as error:
        raise PoundingError(f"{target}: cannot be written ({error.strerror}); choose another place") from None
    return target


def make_folder(target: Path) -> None:
    """Make the folder of an export's tables; raises PoundingError where that fails."""
    if target.is_file():
        raise PoundingError(f"{target} is a file, and the tables go to a folder; choose another name")
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PoundingError(f"{target}: cannot be made ({error.strerror}); choose another place") from None
