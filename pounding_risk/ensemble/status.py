"""The state of a scan, read from its checkpoint: while it runs, after it was stopped, and when it is complete.

The scan is not disturbed: the lock is tested and not kept, and no chunk is read.
"""

from __future__ import annotations

import os
import shlex
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from pounding_risk._common.short_repr import ShortRepr
from pounding_risk.ensemble.checkpoint import folder as checkpoint
from pounding_risk.ensemble.checkpoint.chunks import batches_of
from pounding_risk.ensemble.checkpoint.lock import Holder, running
from pounding_risk.ensemble.chunks import merged

NOT_BEGUN, STOPPED, COMPLETE = "not begun", "stopped", "complete"
WINDOW = 600.0  # s of the log from which the speed is computed
NAMED = 3  # processes, at most, that are named one by one


@dataclass(frozen=True, repr=False)
class Status(ShortRepr):
    """The state of a scan; 0 and "" where something is not known."""

    path: Path  # that was asked for
    state: str  # "running on HOST (pid N)", "stopped", "complete" or "not begun"
    title: str = ""
    cases: int = 0  # kept so far
    total: int = 0
    parts: int = 0  # files of chunks, in the folder ``parts``
    size: int = 0  # of these files [bytes]
    begun: str = ""  # time, UTC
    last_activity: str = ""
    cases_a_second: float = 0.0  # while it runs
    seconds_left: float = 0.0  # while it runs
    shards: int = 0  # that have worked on it, where there were any
    go_on: str = ""  # command that continues it
    note: str = ""

    def facts(self) -> Iterable[tuple[str, str]]:
        """What was asked for, its state, the cases done, and how to go on, as pairs of a name and words."""
        cases = f"{self.cases:,} of {self.total:,}" if self.total else ""
        facts = {"study": str(self.path), "title": self.title, "state": self.state, "cases": cases}
        facts |= {"go on with": self.go_on, "note": self.note}
        yield from ((name, words) for name, words in facts.items() if words)

    @property
    def is_running(self) -> bool:
        """True while a process has the checkpoint open."""
        return self.state.startswith("running")


def status(path: str | Path) -> Status:
    """The state of a scan, which may be running.

    Parameters
    ----------
    path : str or Path
        The results file, ``results.nc`` or ``results.zarr``, or the folder ``results.study`` beside it.

    Returns
    -------
    Status
        Cases done and in all, speed and time left while it runs, and the command that continues it.

    Raises
    ------
    PoundingError
        Where the folder is not that of a scan.
    """
    target = Path(path)
    folder = checkpoint.folder_of(target)
    results = [file for suffix in (".nc", ".zarr") if (file := folder.with_suffix(suffix)).exists()]
    checkpoint.check_ours(folder)
    study = checkpoint.read_study(folder)
    if study is None:
        return _status_without_study(target, folder, results)
    return _study_status(target, folder, study, results)


def _status_without_study(path: Path, folder: Path, results: Sequence[Path]) -> Status:
    if path in results or (path == folder and results):
        note = f"{results[0] if path == folder else path} is whole; no folder {folder.name} describes its run"
        return Status(path, COMPLETE, note=note)
    scene = str(path) if path.suffix == ".toml" else "SCENE"
    command = shlex.join(["pounding-risk", "scan", scene, "-o", str(folder.with_suffix(".nc"))])
    return Status(path, NOT_BEGUN, go_on=command, note=f"there is no study in {folder}")


def _study_status(path: Path, folder: Path, study: dict[str, Any], results: Sequence[Path]) -> Status:
    solved, size = _chunk_files(folder)
    log = list(checkpoint.read_lines(folder / checkpoint.LOG))
    holders = running(folder / checkpoint.LOCK)
    # Shards by their names where the log has them.
    shard_names = {str(line["shard"]) for line in log if "shard" in line}
    sharing = {(line["host"], line["pid"]) for line in log if line["event"] == "start" and line.get("shared")}
    total, cases = study["lines"] * study["width"], sum(map(len, merged(solved))) * study["width"]
    # Those that the scan takes from a finished one of fewer samples.
    cases += next((line["cases"] for line in reversed(log) if line["event"] == "known"), 0)
    facts: dict[str, Any] = {
        "title": study["title"],
        "total": total,
        "parts": len(solved),
        "size": size,
        "begun": study["begun"],
        "last_activity": log[-1]["time"] if log else study["begun"],
        "shards": len(shard_names or sharing),
    }
    if holders:
        speed = _speed(log, holders, study["width"])
        seconds = (total - cases) / speed if speed else 0.0
        count_text = f"running in {len(holders)} processes"
        state = count_text if len(holders) > NAMED else f"running on {' and '.join(map(str, holders))}"
        return Status(path, state, cases=cases, cases_a_second=speed, seconds_left=seconds, **facts)
    events = [line["event"] for line in log if line["event"] in ("begin", "kept", "complete")]
    if not solved and events[-1:] == ["complete"]:
        gone_note = f"its results are not beside {folder.name} any more: moved, or removed"
        return Status(path, COMPLETE, cases=total, **facts, note="" if results else gone_note)
    note = f"{results[0].name} is of an earlier run, and whole" if results else ""
    if cases == total:
        note = "every case is kept, and the results are still to be written"
    return Status(path, STOPPED, cases=cases, **facts, go_on=_command(study, folder), note=note)


def _chunk_files(folder: Path) -> tuple[list[range], int]:
    """The batches of the chunk files, and the bytes of these; files that a run removes meanwhile do not count."""
    spans, size = [], 0
    for entry in checkpoint.entries_of(folder / checkpoint.CHUNKS):
        if (batches := batches_of(entry.name)) is not None:
            with suppress(FileNotFoundError):
                size += entry.stat().st_size
                spans.append(batches)
    return spans, size


def _speed(log: Sequence[dict[str, Any]], holders: Sequence[Holder], width: int) -> float:
    """Cases per second of the processes that run now; 0 while too little is known.

    Counted from the first chunk that is kept: reading and compiling come before it.
    """
    running_now = {(holder.host, holder.pid) for holder in holders}
    chunks: list[tuple[float, int]] = []
    for line in log:
        if line["event"] == "start" and not line.get("shared"):
            chunks = []
        if line["event"] == "kept" and (line.get("host"), line.get("pid")) in running_now:
            seconds = datetime.fromisoformat(line["time"]).timestamp()
            chunks.append((seconds, (line["stop"] - line["start"]) * width))
    chunks = [chunk for chunk in chunks if chunk[0] >= chunks[-1][0] - WINDOW]
    span = chunks[-1][0] - chunks[0][0] if chunks else 0.0
    return sum(cases for _, cases in chunks[1:]) / span if span > 0.0 else 0.0


def _command(study: dict[str, Any], folder: Path) -> str:
    """The command that continues a scan, with the folder in which it was typed where that is another one."""
    if not study["command"]:
        return f"scan the same scene again, with out={str(folder.with_suffix('.nc'))!r}"
    typed_in = study.get("working_folder", "")
    return study["command"] if typed_in in ("", os.getcwd()) else f"cd {shlex.quote(typed_in)} && {study['command']}"
