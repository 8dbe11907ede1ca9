"""Errors for input that cannot be used.

Every message names the file, the key or the line, what was found, what is allowed and the likely
repair. The command line prints it and exits with status 2; nothing has been written by then.
"""

from __future__ import annotations


class PoundingError(Exception):
    """An input that cannot be used; the text is meant for the user, without a traceback."""


class RecordError(PoundingError):
    """A strong-motion record that cannot be read or trusted."""


class SceneError(PoundingError):
    """A scene file with one or more faults; ``faults`` holds one sentence each."""

    def __init__(self, source: str, faults: list[str]):
        self.source = source
        self.faults = list(faults)
        count = len(self.faults)
        head = f"{source}: {count} fault{'s' if count != 1 else ''}"
        super().__init__("\n".join([head, *(f"  - {fault}" for fault in self.faults)]))


class Stopped(KeyboardInterrupt):
    """Ctrl-C ended a long piece of work; the text says what is kept and how to go on."""
