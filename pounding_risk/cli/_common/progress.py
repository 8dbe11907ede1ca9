"""Progress of a long command: a bar on a terminal, lines elsewhere."""

from __future__ import annotations

import sys
from threading import Event, Lock, Thread
from time import monotonic
from typing import Any

EVERY = 30.0  # s between two lines of progress where there is no terminal


class Watch:
    """Progress of a long command: a bar on a terminal, otherwise a line every half minute, whatever happens meanwhile.

    Call it with (done, total). ``with Watch("scan") as watch: ...`` takes the bar away at the end. With ``resumes`` the
    first call is made before any work, with what is kept from before.
    """

    def __init__(self, what: str, unit: str = "cases", *, resumes: bool = False):
        self.what, self.unit = what, unit
        self._bar: Any = None
        self._task: Any = None
        self._tells_kept = resumes
        self.kept = 0  # cases, from before
        self._first: tuple[float, int] | None = None  # time and cases of the first report of work
        self._last = 0, 0  # cases done and in all
        self._words = f"{what}: reading, compiling"
        self._said = self._began = monotonic()
        self._saying = Lock()
        self._over = Event()
        self._clock: Thread | None = None

    def __enter__(self) -> Watch:
        if sys.stderr.isatty():
            self._bar = _bar()
            self._task = self._bar.add_task(self._words, total=None, pace="")
            self._bar.start()
        else:
            # A long piece of work and a compiler report nothing; a batch system may take silence for a hang.
            self._clock = Thread(target=self._tick, name="progress", daemon=True)
            self._clock.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()
        self._over.set()
        if self._clock is not None:
            self._clock.join()

    def __call__(self, done: int, total: int) -> None:
        if self._tells_kept:
            self._tells_kept, self.kept = False, done
            if done:
                self._tell(f"{self.what}: {done} of {total} {self.unit} are kept from before")
            self._update(done, total, "")
            return
        # The first report stands for reading and compiling, which say nothing about the rest.
        self._last = done, total
        self._first = self._first or (monotonic(), done)
        self._update(done, total, self._pace())
        if done < total:
            self._say()

    def _pace(self) -> str:
        """Speed and time left as they are by now: where nothing comes any more they say so."""
        if self._first is None:
            return ""
        (first, before), (done, total), now = self._first, self._last, monotonic()
        return pace((done - before) / (now - first) if now > first else 0.0, total - done)

    def _update(self, done: int, total: int, words: str) -> None:
        self._words = f"{self.what}: {done} of {total} {self.unit} ({100 * done // max(total, 1)} %)"
        if self._bar is not None:
            self._bar.update(self._task, description=self.what, completed=done, total=total, pace=words.lstrip(", "))

    def _tick(self) -> None:
        """Say how far it is when half a minute went by, without a report too."""
        while not self._over.wait(min(max(EVERY / 4.0, 0.005), 1.0)):
            self._say()

    def _say(self) -> None:
        """The state as it was last told, in a line of its own, where the last line is long enough ago."""
        if self._bar is not None:
            return
        with self._saying:
            now = monotonic()
            if now - self._said < EVERY:
                return
            self._said = now
            words = self._pace() if self._first else f", {span_words(now - self._began)} so far"
            print(self._words + words, file=sys.stderr, flush=True)

    def _tell(self, words: str) -> None:
        if self._bar is not None:
            self._bar.console.print(words, highlight=False)
        else:
            print(words, file=sys.stderr, flush=True)


def pace(speed: float, left: float) -> str:
    """How many a second, and how long the others take; nothing where the speed is not known."""
    if speed <= 0.0:
        return ""
    rate = f"{speed:.0f}" if speed >= 100.0 else f"{speed:.2g}"
    return f", {rate} a second, about {span_words(left / speed)} left"


def span_words(seconds: float) -> str:
    """A span of time in the units that one thinks in: 80 s, 12 min, 3 h 20 min, 2 d 5 h."""
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
    # Not the library's own time left: it takes what is kept from before for work that was quick.
    return Progress(*columns, TextColumn("{task.fields[pace]}"), console=Console(stderr=True), transient=True)
