"""Errors for input that cannot be used.

Every message names the file, the key or the line, what was found, what is allowed and the likely
repair. The command line prints it and exits with status 2; nothing has been written by then.
"""

from __future__ import annotations


class PoundingError(Exception):
    """An input that cannot be used; the text is meant for the user, without a traceback."""


class RecordError(PoundingError):
    """A strong-motion record that cannot be read or trusted."""


MOST_FAULTS = 50  # of a file that its error says; `faults` has them all


class SceneError(PoundingError):
    """A scene file with one or more faults; ``faults`` holds one sentence each."""

    def __init__(self, source: str, faults: list[str]):
        self.source = source
        self.faults = list(faults)
        count = len(self.faults)
        head = f"{source}: {count} fault{'s' if count != 1 else ''}"
        more = [f"and {count - MOST_FAULTS} more faults"] if count > MOST_FAULTS else []
        super().__init__("\n".join([head, *(f"  - {fault}" for fault in [*self.faults[:MOST_FAULTS], *more])]))


class Stopped(KeyboardInterrupt):
    """Ctrl-C ended a long piece of work; the text says what is kept and how to go on."""
