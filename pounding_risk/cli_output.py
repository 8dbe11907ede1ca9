"""What the commands print: aligned tables in engineering units, and progress with the time left.

Nothing here knows a command. Tables go to standard output and read well through a pipe or in a file; progress
and errors go to standard error.
"""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Iterable, Mapping, Sequence
from math import inf, isnan
from pathlib import Path
from time import monotonic
from typing import Any

EVERY = 30.0  # s between two lines of progress where there is no terminal
WIDEST = 400  # columns of a table that is piped: it is never wrapped
SPEEDS = "m/s"


def engineering(value: float, unit: str, digits: int = 4) -> str:
    """A number in SI ``unit`` as an engineer writes it: 1300 kN, 3.2 mm, 0.5 m/s; – for what is not there."""
    from pounding_risk.quantities import Quantity, say

    if isnan(value):
        return "–"
    if unit == "N s":
        unit, value = ("kN s", value / 1e3) if abs(value) >= 1e3 else ("N s", value)
    elif unit == "m/s2":
        unit = "m/s^2"  # in g
    elif unit == SPEEDS:
        return f"{value:.{digits}g} m/s"
    return say(value, Quantity(unit, -inf, inf, ""), digits)


def print_table(heads: Sequence[str], rows: Iterable[Sequence[str]], sides: str) -> None:
    """Columns under their heads; ``sides`` has one letter a column: "l" flush left, "r" flush right (numbers)."""
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, padding=(0, 3, 0, 0), show_header=any(heads))
    for place, (head, side) in enumerate(zip(heads, sides, strict=True)):
        # An id or a number broken in two cannot be copied; only a sentence at the end may be.
        wraps = side == "l" and place == len(sides) - 1
        table.add_column(head, justify="left" if side == "l" else "right", no_wrap=not wraps)
    for row in rows:
        table.add_row(*(Text(cell) for cell in row))
    _show(table, sides.endswith("l"))


def print_pairs(pairs: Iterable[tuple[str, str]]) -> None:
    """One line for each (what, words)."""
    print_table(("", ""), pairs, "ll")


def _show(table: Any, wraps: bool) -> None:
    """Print a table: as wide as it is, unless its last column can be wrapped to a terminal's width."""
    from rich.console import Console

    console = Console(highlight=False)
    if console.is_terminal and wraps:
        console.print(table)
        return
    console.width = WIDEST  # rich would cut columns off that a terminal merely continues on the next line
    with console.capture() as captured:
        console.print(table)
    print("\n".join(line.rstrip() for line in captured.get().splitlines()))


def command_line(aside: Mapping[str, bool] | None = None) -> str:
    """What was typed, for the results, without the options ``aside``, each of which takes a value or does not.

    Nothing where the command was called from another program.
    """
    program = Path(sys.argv[0])
    ours = program.stem == "pounding-risk" or (program.name, program.parent.name) == ("__main__.py", "pounding_risk")
    return shlex.join(["pounding-risk", *_without(sys.argv[1:], aside or {})]) if ours else ""


def _without(words: Sequence[str], aside: Mapping[str, bool]) -> list[str]:
    kept, skip = [], False
    for word in words:
        option, has_value, _ = word.partition("=")
        if skip:
            skip = False
        elif option in aside:
            skip = aside[option] and not has_value
        else:
            kept.append(word)
    return kept


class Watch:
    """Progress of a long command: a bar with the time left on a terminal, otherwise a line now and then.

    Call it with (done, total). ``with Watch("scan") as watch: ...`` takes the bar away at the end.
    """

    def __init__(self, what: str, unit: str = "cases"):
        self.what, self.unit = what, unit
        self._bar: Any = None
        self._task: Any = None
        self._said = monotonic()
        self._first: tuple[float, int] | None = None

    def __enter__(self) -> Watch:
        if sys.stderr.isatty():
            self._bar = _bar()
            self._task = self._bar.add_task(f"{self.what}: reading, compiling", total=None)
            self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()

    def __call__(self, done: int, total: int) -> None:
        if self._bar is not None:
            self._bar.update(self._task, description=self.what, completed=done, total=total)
            return
        now = monotonic()
        # The first report stands for reading and compiling, which say nothing about the rest.
        first, before = self._first = self._first or (now, done)
        if now - self._said < EVERY or done >= total:
            return
        self._said = now
        left = f", about {(total - done) * (now - first) / (done - before):.0f} s left" if done > before else ""
        print(
            f"{self.what}: {done} of {total} {self.unit} ({100 * done // total} %){left}", file=sys.stderr, flush=True
        )


def _bar() -> Any:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
    from rich.progress import TimeRemainingColumn as Left

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    return Progress(*columns, TextColumn("left"), Left(), console=Console(stderr=True), transient=True)


def draw(figure: Any, target: Path) -> None:
    """Write a figure under a temporary name and move it into place; raises PoundingError where that fails."""
    from pounding_risk.errors import PoundingError
    from pounding_risk.figures_style import write

    partial = target.with_name(f".{target.stem}.{os.getpid()}.partial{target.suffix}")
    try:
        write(figure, partial)
        os.replace(partial, target)
    except OSError as error:
        raise PoundingError(f"{target}: cannot be written ({error.strerror}); choose another place") from None
    finally:
        partial.unlink(missing_ok=True)
    print(f"written: {target}")
