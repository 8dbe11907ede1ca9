"""Standard output and standard error, as they are: closed, full, or of an encoding without our characters."""

from __future__ import annotations

import codecs
import errno
import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from unicodedata import combining, decomposition, name, normalize

# Signs of tables and sentences in ASCII, for encodings that lack them; letters are replaced by their names.
PLAIN = {"–": "-", "—": "-", "−": "-", "’": "'", "“": '"', "”": '"', "…": "...", "·": "*", "×": "x", "±": "+/-"}
PLAIN |= {"≤": "<=", "≥": ">=", "≫": ">>", "→": "->", "√": "sqrt", "∞": "inf", "∫": "integral ", "∂": "d"}
PLAIN |= {"§": "section ", "°": " degrees", "\u0307": "'", "\u0308": "''"}  # the last two: dots over letters
HANDLER = "pounding_risk.plain"


class OutputFull(Exception):
    """Standard output cannot be written; the message says why."""


class _Output(io.TextIOWrapper):
    """Standard output whose faults can be distinguished from those of other files; a reader that has gone is none."""

    def write(self, text: str) -> int:
        with _own_faults(self):
            return super().write(text)

    def flush(self) -> None:
        with _own_faults(self):
            super().flush()


@contextmanager
def _own_faults(stream: io.TextIOWrapper) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        with suppress(OSError, ValueError):  # so that the interpreter does not try once more on its way out
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        if error.errno == errno.EPIPE:
            raise
        raise OutputFull(error.strerror) from None


def prepare_streams() -> None:
    """Give a closed stream somewhere to go, and write characters that a stream's encoding lacks in others.

    A fault of standard output is an `OutputFull` from here on.
    """
    codecs.register_error(HANDLER, _in_plain_words)
    for stream_name in ("stdout", "stderr"):
        stream = getattr(sys, stream_name)
        if stream is None:  # closed by whoever started us
            setattr(sys, stream_name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 # for the whole process
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=HANDLER)
    stream = sys.stdout
    if stream is sys.__stdout__ and isinstance(stream, io.TextIOWrapper):  # none that a caller of ours put there
        stream.flush()
        sys.stdout = _Output(stream.buffer, stream.encoding, HANDLER, line_buffering=stream.line_buffering)


def _in_plain_words(error: UnicodeError) -> tuple[str | bytes, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(in_ascii, error.object[error.start : error.end])), error.end


def in_ascii(character: str) -> str:
    """A character in ASCII: a sign of `PLAIN`, a Greek letter's name, a superscript after ^, a letter without accents.

    Any other is a question mark.

    >>> "".join(in_ascii(character) for character in "δ≤β³é")
    'delta<=beta^3e'
    """
    kind, _, letter = name(character, "").rpartition(" ")
    if kind.startswith("GREEK "):
        return letter.lower() if "SMALL" in kind else letter.title()
    power = "^" if decomposition(character).startswith("<super>") else ""
    plain = normalize("NFKD", character).encode("ascii", "ignore").decode()
    return PLAIN.get(character) or (f"{power}{plain}" if plain or combining(character) else "?")
