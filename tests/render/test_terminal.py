"""Tables of the commands on a real terminal: whatever its width, no number and no word is cut."""

import fcntl
import os
import pty
import struct
import subprocess
import sys
import termios
from math import inf, nan

import pytest
from processes import output
from rich.cells import cell_len
from sweeps import sweep

from pounding_risk.render.terminal import _width, engineering, print_table

NUMBERS = ["20000 kN", "0.2431 g", "0.043, 0.094", "63.9 mm", "12 of 44"]
HEADS = ["fragility of", "gap", "F_E", "median sa(left)", "s.e. ln median", "reached in", "by"]
WORDS = ["yielding, viscous_elastoplastic", "exact scaling of linear buildings, one recording at a time"]
PRINT = (
    "from pounding_risk.render.terminal import print_table\n"
    f"print_table({HEADS!r}, [{[WORDS[0], *NUMBERS, WORDS[1]]!r}] * 3, 'lrrrrrl')\n"
)


def on_terminal(width: int, *arguments: str) -> str:
    """What a Python program prints on a terminal of so many columns."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 50, width, 0, 0))
    settings = {name: value for name, value in os.environ.items() if name not in ("COLUMNS", "FORCE_COLOR")}
    run = subprocess.Popen(
        [sys.executable, *arguments], stdout=theirs, stderr=theirs, stdin=theirs, env=settings | {"TERM": "xterm"}
    )
    os.close(theirs)
    printed = b""
    while True:
        try:
            block = os.read(ours, 65536)
        except OSError:  # EIO: the program has ended, and nobody holds the other end any more
            break
        if not block:
            break
        printed += block
    os.close(ours)
    assert run.wait() == 0, printed
    return printed.decode().replace("\r\n", "\n")


@pytest.mark.parametrize("width", sweep([30, 40, 60, 80, 81, 90, 100, 120, 160, 200], 30, 81, 120))
def test_nothing_is_cut_at_any_width(width):
    text = on_terminal(width, "-c", PRINT)
    for number in NUMBERS:  # whole, on one line
        assert text.count(number) == 3, text
    for words in [*WORDS, *HEADS]:
        for word in words.split():
            assert word in text, (word, text)
    assert "…" not in text
    # A single word or number that is wider than the terminal is left to it; nothing here is.
    assert max(map(len, text.split("\n"))) <= max(width, 32), text


def test_a_wide_terminal_shows_a_table_and_a_narrow_one_blocks():
    assert len(on_terminal(200, "-c", PRINT).strip().split("\n")) == 4
    turned = on_terminal(60, "-c", PRINT)
    assert "fragility of: yielding, viscous_elastoplastic\n" in turned
    assert "  F_E              0.2431 g\n" in turned


def test_piped_tables_have_one_line_a_row():
    assert len(output("-c", PRINT, env=os.environ | {"COLUMNS": "40"}).strip().split("\n")) == 4


@pytest.mark.complete
@pytest.mark.parametrize(
    "command", [("models",), ("separations",), ("records", "list"), ("records", "info", "RSN6-180")]
)
def test_commands_print_the_same_words_on_a_narrow_terminal(command):
    """Every word and number that a pipe gets stands on a terminal of 80 columns, in whatever order."""
    piped = output("-m", "pounding_risk", *command)
    text = on_terminal(80, "-m", "pounding_risk", *command)
    missing = [word for word in piped.split() if word not in text]
    assert missing == []
    assert text.count("…") == piped.count("…")


def column(capsys, values: list[float], unit: str) -> list[str]:
    """The cells of a column of numbers as they are printed."""
    print_table(("what", "number"), [("x", engineering(value, unit)) for value in values], "lr")
    return [line.split(maxsplit=1)[1] for line in capsys.readouterr().out.splitlines()[1:]]


@pytest.mark.parametrize(
    ("values", "unit", "cells"),
    [
        ([0.0009, 0.0575, 1.2], "m", ["0.9 mm", "57.5 mm", "1200 mm"]),
        ([4.5e5, 2e6, 3e7, inf], "N", ["450 kN", "2000 kN", "30000 kN", "inf"]),
        ([0.0, 2.0, 3.0], "m", ["0 m", "2 m", "3 m"]),
        ([999.0, 1001.0, 5e4], "N s", ["0.999 kN s", "1.001 kN s", "50 kN s"]),
        ([nan, 0.35], "m/s", ["–", "0.35 m/s"]),
        ([0.5], "s", ["0.5 s"]),
        ([0.005], "m", ["5 mm"]),
        ([4.903325], "m/s2", ["0.5 g"]),
        ([2.5e5], "N s", ["250 kN s"]),
        ([12.0], "N s", ["12 N s"]),
        ([0.00035], "m/s", ["0.00035 m/s"]),
        ([1307.0], "J", ["1.307 kJ"]),
        ([450e3], "N", ["450 kN"]),
        ([nan], "s", ["–"]),
        ([inf], "N", ["inf"]),
    ],
)
def test_a_column_of_numbers_has_one_unit_as_engineers_write_it(capsys, values, unit, cells):
    assert column(capsys, values, unit) == cells


@pytest.mark.parametrize("text", ["kN/m^1.5", "δ – 3 m/s²", "兵庫県南部 1995", "e\u0301picentre", "Ｗ", "ζ ≤ 5 %", ""])
def test_widths_are_those_of_a_terminal(text):
    """As rich measures them, which the package imports for a progress bar only."""
    assert _width(text) == cell_len(text)
