"""Files that are written whole or not at all: one, several together, a folder of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

from pounding_risk._common.files import not_written, write_together
from pounding_risk.errors import PoundingError

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
    missing = [above for above in (folder, *folder.absolute().parents) if not above.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PoundingError(f"{folder}: cannot be made ({error.strerror}); choose another place") from None
    try:
        return write_files((folder / name, content) for name, content in contents)
    except BaseException:  # Ctrl-C as well
        with suppress(OSError):
            for above in missing:
                above.rmdir()
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
        if not targets:  # an error of the code that makes the contents
            raise
        raise not_written(targets[-1], error) from None
    return tuple(targets)
