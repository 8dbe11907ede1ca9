"""Files that a command writes: checked before any work, written whole."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

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


def results_file(scene: Path, out: Path | None, new: bool = False) -> Path:
    """Where a scan goes: ``out``, or the scene's name in this folder, which is never made again unasked."""
    if out is None and Path(f"{scene.stem}.nc").exists() and not new:
        name = f"{scene.stem}.nc"
        raise PoundingError(
            f"{name} exists already; write -o {name} to make the same study again, --new to replace it whatever it "
            "is, or -o and another name"
        )
    return writable("-o", out or Path(f"{scene.stem}.nc"), (".nc", ".zarr")) or Path()


def check_folder(folder: Path) -> None:
    """A folder that is there or can be made; raises PoundingError."""
    existing = next(each for each in (folder, *folder.absolute().parents) if each.exists())
    if not existing.is_dir():
        raise PoundingError(f"--out: {existing} is a file, not a folder; choose another name")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise PoundingError(f"--out: the folder {existing} cannot be written to; choose another one")


def make_folder(folder: Path) -> None:
    """The folder, with those above it; raises PoundingError where it cannot be made."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PoundingError(f"--out: {folder} cannot be made ({error.strerror}); choose another one") from None


def draw(figure: Any, target: Path) -> None:
    """Write a figure under a temporary name and move it into place; raises PoundingError where that fails."""
    from pounding_risk.errors import PoundingError
    from pounding_risk.figures.style import write

    partial = target.with_name(f".{target.stem}.{os.getpid()}.partial{target.suffix}")
    try:
        write(figure, partial)
        os.replace(partial, target)
    except OSError as error:
        raise PoundingError(f"{target}: cannot be written ({error.strerror}); choose another place") from None
    finally:
        partial.unlink(missing_ok=True)
    print(f"written: {target}")
