"""Progress of a long command on standard error: a bar on a terminal, lines of text elsewhere."""

from __future__ import annotations

import sys
from threading import Event, Lock, Thread
from time import monotonic
from typing import Any

from pounding_risk._common.letters import plain

EVERY = 30.0  # s between two lines of progress where there is no terminal


class ProgressDisplay:
    """Progress of a long command: a bar on a terminal, otherwise a line every half minute, even without a report.

    Call it with the numbers done and in all, in ``unit``. On leaving ``with ProgressDisplay("scan") as progress: ...``
    the bar is removed. Of a command that ``resumes`` the first call comes before any work, with the number done by an
    earlier start.
    """

    def __init__(self, what: str, unit: str = "cases", *, resumes: bool = False):
        self.what, self.unit = what, unit
        self._bar: Any = None
        self._task: Any = None
        self._awaits_earlier = resumes
        self.n_earlier = 0  # done by an earlier start
        self._first: tuple[float, int] | None = None  # time and number done of the first report of work
        self._last = 0, 0  # numbers done and in all
        self._state = f"{what}: reading, compiling"
        self._printed_at = self._began = monotonic()
        self._printing = Lock()
        self._is_over = Event()
        self._clock: Thread | None = None

    def __enter__(self) -> ProgressDisplay:
        if sys.stderr.isatty():
            self._bar = _bar()
            self._task = self._bar.add_task(self._state, total=None, pace="")
            self._bar.start()
        else:
            # Long batches and the compiler do not report; a batch system may take silence for a hang.
            self._clock = Thread(target=self._run_clock, name="progress", daemon=True)
            self._clock.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()
        self._is_over.set()
        if self._clock is not None:
            self._clock.join()

    def __call__(self, done: int, total: int) -> None:
        if self._awaits_earlier:
            self._awaits_earlier, self.n_earlier = False, done
            if done:
                self._print(f"{self.what}: {done} of {total} {self.unit} are kept from before")
            self._update(done, total)
            return
        # The first report includes reading and compiling, so that the speed is measured from there on.
        self._last = done, total
        self._first = self._first or (monotonic(), done)
        self._update(done, total, self._pace())
        if done < total:
            self._print_state()

    def _pace(self) -> str:
        """Speed and remaining time at this moment; the speed falls while no report comes."""
        if self._first is None:
            return ""
        (start, before), (done, total), now = self._first, self._last, monotonic()
        return pace((done - before) / (now - start) if now > start else 0.0, total - done)

    def _update(self, done: int, total: int, pace_words: str = "") -> None:
        self._state = f"{self.what}: {done} of {total} {self.unit} ({100 * done // max(total, 1)} %)"
        if self._first is None:  # no work is reported yet
            pace_words = ", compiling or running the next ones"
            self._state += pace_words
        if self._bar is not None:
            text = pace_words.lstrip(", ")
            self._bar.update(self._task, description=self.what, completed=done, total=total, pace=text)

    def _run_clock(self) -> None:
        """Print the state every half minute until the command is done."""
        while not self._is_over.wait(min(max(EVERY / 4.0, 0.005), 1.0)):
            self._print_state()

    def _print_state(self) -> None:
        """Print the last state reported, unless a bar shows it or the last line is too recent."""
        if self._bar is not None:
            return
        with self._printing:
            now = monotonic()
            if now - self._printed_at < EVERY:
                return
            self._printed_at = now
            self._print(self._state + (self._pace() if self._first else f", {span_words(now - self._began)} so far"))

    def _print(self, line: str) -> None:
        if self._bar is not None:
            self._bar.console.print(line, highlight=False)
        else:
            print(plain(line), file=sys.stderr, flush=True)


def pace(speed: float, remaining: float) -> str:
    """The speed [1/s] and the time that the remaining number takes, as words; "" where the speed is not known."""
    if speed <= 0.0:
        return ""
    rate = f"{speed:.0f}" if speed >= 100.0 else f"{speed:.2g}"
    return f", {rate} a second, about {span_words(remaining / speed)} left"


def span_words(seconds: float) -> str:
    """A span of time in convenient units: 80 s, 12 min, 3 h 20 min, 2 d 5 h."""
    if seconds < 119.5:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    if minutes < 120:
        return f"{minutes} min"
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours < 48 else f"{hours // 24} d {hours % 24} h"


def _bar() -> Any:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    # Not rich's own remaining time: it would count what an earlier start has done as work done now.
    return Progress(*columns, TextColumn("{task.fields[pace]}"), console=Console(stderr=True), transient=True)
