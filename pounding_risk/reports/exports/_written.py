"""The options of an export, and what it says of the files that it wrote."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple


class Options(NamedTuple):
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
    notes: tuple[str, ...]
