"""The options of an export, and what it says of the files that it wrote."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO, NamedTuple

from pounding_risk._common.files import not_written, write_together
from pounding_risk.errors import PoundingError


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
    told: tuple[str, ...]


Content = str | bytes


def write_file(target: Path, content: Content) -> Path:
    """Write a file, text as UTF-8, whole or not at all; raises PoundingError where that fails."""
    return write_files([(target, content)])[0]


def write_folder(folder: Path, contents: Iterable[tuple[str, Content]]) -> tuple[Path, ...]:
    """Write files by name into a folder, all of them or none, and make the folder where there is none.

    Raises PoundingError where that fails; a folder that was made for them is removed then.
    """
    if folder.is_file():
        raise PoundingError(f"{folder} is a file, and the tables go to a folder; choose another name")
    missing = [place for place in (folder, *folder.absolute().parents) if not place.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PoundingError(f"{folder}: cannot be made ({error.strerror}); choose another place") from None
    try:
        return write_files((folder / name, content) for name, content in contents)
    except BaseException:  # Ctrl-C as well
        with suppress(OSError):
            for place in missing:
                place.rmdir()
        raise


def write_files(contents: Iterable[tuple[Path, Content]]) -> tuple[Path, ...]:
    """Write files, text as UTF-8, all of them or none; raises PoundingError where that fails."""
    targets: list[Path] = []

    def writers() -> Iterator[tuple[Path, Callable[[BinaryIO], object]]]:
        for target, content in contents:
            data = content.encode() if isinstance(content, str) else content
            targets.append(target)
            yield target, lambda file, data=data: file.write(data)  # type: ignore[misc]

    try:
        write_together(writers())
    except OSError as error:
        raise not_written(targets[-1], error) from None
    return tuple(targets)
