"""Files and folders that a command writes: checked before any work, and written whole."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

from pounding_risk._common.files import not_written
from pounding_risk.errors import PoundingError

FIGURES = (".png", ".svg", ".pdf")


def writable(option: str, path: Path | None, suffixes: tuple[str, ...]) -> Path | None:
    """A file that can be written, or none where none is asked for; raises PoundingError that names the option."""
    if path is None:
        return None
    from pounding_risk.results.files import check_target

    if not path.name:
        raise PoundingError(f"{option}: {str(path)!r} is not the name of a file; write one that ends in {suffixes[0]}")
    try:
        return check_target(path, suffixes)
    except PoundingError as error:
        raise PoundingError(f"{option}: {error}") from None


def out_or(out: Path | None, name: str, repair: str = "to replace it, or another name", replace: bool = False) -> Path:
    """The file of the option ``--out``, by default one of a given name in the working folder.

    Raises PoundingError with a ``repair`` where the default exists already, unless ``replace`` allows to replace it.
    """
    if out is None and Path(name).exists() and not replace:
        raise PoundingError(f"{name} exists already; write -o {name} {repair}")
    return out or writable("-o", Path(name), (Path(name).suffix,)) or Path(name)


def check_folder(folder: Path) -> None:
    """Raise PoundingError unless a folder is there, or can be made, and can be written to."""
    existing = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not existing.is_dir():
        raise PoundingError(f"--out: {existing} is a file, not a folder; choose another name")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise PoundingError(f"--out: the folder {existing} cannot be written to; choose another one")


def make_folder(folder: Path) -> None:
    """Make a folder and those above it; raises PoundingError where it cannot be made."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PoundingError(f"--out: {folder} cannot be made ({error.strerror}); choose another one") from None


def announce(*paths: Path | None) -> None:
    """Print that files are written; those not asked for are None."""
    for path in paths:
        if path is not None:
            print(f"written: {path}")


@contextmanager
def writing(target: Path) -> Iterator[None]:
    """Write a file; raises PoundingError where that fails."""
    try:
        yield
    except OSError as error:
        raise not_written(target, error) from None


def draw(target: Path | None, name: str, *arguments: Any, quiet: bool = False, **options: Any) -> None:
    """Draw a figure to a file, unless the file is None; raises PoundingError where it cannot be written.

    ``name`` is a function below `pounding_risk.figures`, such as "scan.scan_figure", imported only where a figure is
    drawn, with what it takes. ``quiet`` leaves it to the caller to print that the file is written.
    """
    if target is None:
        return
    from pounding_risk.figures.style import write

    module, _, function = name.rpartition(".")
    figure = getattr(import_module(f"pounding_risk.figures.{module}"), function)(*arguments, **options)
    with writing(target):
        write(figure, target)
    if not quiet:
        announce(target)
