"""The checkpoint of a scan: a folder beside its results from which a run that was stopped or killed goes on.

``results.nc`` has ``results.study`` beside it:

- ``study.json``: identity of the scan and its digest, batches, cases per batch, title, command, time of beginning;
- ``parts/<start>-<stop>.npz``: results of these batches (see `checkpoint.chunks`);
- ``log.jsonl``: one JSON object per event, with time, machine and process, for people and for `status`;
- ``lock``: the writing processes; the lock is held by the system (see `checkpoint.lock`).
"""

from __future__ import annotations

import errno
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

from pounding_risk._common import files
from pounding_risk._common.dates import now
from pounding_risk.ensemble.checkpoint.chunks import CHUNK, Damaged, batches_of, chunk_name, read_chunk, write_chunk
from pounding_risk.ensemble.checkpoint.lock import Held, Lock
from pounding_risk.ensemble.chunks import Chunk, assembled, merged
from pounding_risk.ensemble.identity import difference_lines, digest
from pounding_risk.errors import PoundingError

STUDY, CHUNKS, LOG, LOCK = "study.json", "parts", "log.jsonl", "lock"
OWN = (STUDY, CHUNKS, LOG, LOCK)
FORMAT = "pounding_risk study 1"


class About(NamedTuple):
    """Facts on a scan that are no part of its identity."""

    batches: int
    width: int  # cases per batch
    title: str = ""
    command: str = ""

    def table(self) -> dict[str, Any]:
        """The fields under their names in ``study.json``."""
        return {"lines": self.batches, "width": self.width, "title": self.title, "command": self.command}


def folder_of(results: str | Path) -> Path:
    """The folder of the checkpoint of a results file: ``results.study`` for ``results.nc``.

    For a symbolic link it is that of the target. Raises PoundingError for a name that is no file, such as ".".
    """
    path = Path(results)
    if path.name in ("", ".."):
        raise PoundingError(f'"{results}" is a folder; name the results, such as {path / "results.nc"}')
    return path if path.suffix == files.CHECKPOINT else files.led_to(path).with_suffix(files.CHECKPOINT)


def read_study(folder: Path) -> dict[str, Any] | None:
    """The content of ``study.json``, None where there is none; raises PoundingError where it is not of a scan."""
    file = folder / STUDY
    try:
        study = json.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    except (ValueError, RecursionError):
        study = None
    except OSError as error:
        raise PoundingError(f"{file}: cannot be read ({error.strerror}); check its permissions") from None
    expected = {"identity": dict, "lines": int, "width": int, "title": str, "command": str, "begun": str}
    is_complete = isinstance(study, dict) and all(isinstance(study.get(key), kind) for key, kind in expected.items())
    if is_complete and study.get("format") == FORMAT:
        return study
    raise PoundingError(
        f"{file}: is not a study of this version of pounding-risk; it was left as it is: move the folder "
        f"{folder.name} away, or write the results under another name (-o)"
    )


class Checkpoint(AbstractContextManager["Checkpoint"]):
    """A checkpoint that is open for writing, by one process or by several that share it.

    Use it as a context manager, or `close` it. ``path`` is the folder, ``about`` has facts on the scan.
    """

    def __init__(self, path: Path, lock: Lock, is_alone: bool, about: About, digest: str):
        self.path, self.about = path, about
        self._lock, self._alone, self._digest = lock, is_alone, digest
        self.again = "the same command"  # words for what continues the scan
        self.begun = ""  # time at which the scan was begun
        self._sound: dict[range, tuple[int, int]] = {}  # verified chunks: batches, size and time of the file

    @classmethod
    def open(
        cls, path: str | Path, identity: Mapping[str, Any], about: About, *, new: bool = False, shared: bool = False
    ) -> Checkpoint:
        """Begin a scan in a folder, or continue the one that is there.

        ``new`` discards the results of an earlier scan, and nothing else in the folder; ``shared`` lets other processes
        share the folder, each with its own batches. Raises PoundingError where the folder is not a
        study's, where another run writes it, where it cannot be written, and, with the differences, where it
        holds chunks of a study of another identity.
        """
        folder = Path(path)
        check_ours(folder)
        try:
            folder.mkdir(exist_ok=True)
            lock = Lock(folder / LOCK)
        except OSError as error:
            raise _unwritable_error(folder, error, "") from None
        try:
            is_alone = lock.take(shared)
            checkpoint = cls(folder, lock, is_alone and not shared, about, digest(identity))
            checkpoint._begin(identity, new, is_alone)
            if shared and is_alone:
                lock.share()
        except BaseException as error:
            lock.close()
            if isinstance(error, Held):
                names = " and ".join(f"{holder}, since {holder.since}" for holder in error.holders) or "another process"
                raise PoundingError(
                    f"{folder}: another run is writing this study: {names}; wait for it, or stop it, and run the same "
                    "command again"
                ) from None
            if isinstance(error, OSError):
                raise _unwritable_error(folder, error, "") from None
            raise
        if new:
            checkpoint.again += " without --new"
        checkpoint.log("start", shared=shared, command=about.command)
        return checkpoint

    def _begin(self, identity: Mapping[str, Any], new: bool, is_alone: bool) -> None:
        """Prepare the folder for the scan of this identity, or raise PoundingError."""
        study = read_study(self.path)
        is_same = study is not None and digest(study["identity"]) == self._digest
        if study is not None and is_same and not new:
            self.begun = study["begun"]
            (self.path / CHUNKS).mkdir(exist_ok=True)
            return
        if not is_alone:
            raise PoundingError(
                f"{self.path}: other runs are writing {'this' if is_same else 'another'} study here; wait for them, or "
                "stop them, and run the same command again" + _differences(study, identity, is_same)
            )
        if study and not new and self._spans():
            raise PoundingError(
                f"{self.path}: holds {_cases(self._spans(), study['width'])} cases of a study that was another; "
                "put back what differs to go on with it, write --new to discard it, or write the results under another "
                f"name (-o):{_differences(study, identity, is_same)}"
            )
        # The files of an earlier scan, and no others.
        for file in (self.path / STUDY, *map(self._chunk_path, self._spans()), self.path / LOG):
            file.unlink(missing_ok=True)
        self._write_study(identity)

    def _write_study(self, identity: Mapping[str, Any]) -> None:
        self.begun = now()
        facts = {"format": FORMAT, "begun": self.begun, "digest": self._digest, **self.about.table()}
        text = json.dumps({**facts, "working_folder": os.getcwd(), "identity": identity}, ensure_ascii=False, indent=1)
        files.write_whole(self.path / STUDY, lambda file: file.write(text.encode(errors="backslashreplace")))
        (self.path / CHUNKS).mkdir(exist_ok=True)
        files.sync(self.path)
        self.log("begin", **self.about.table())

    def __exit__(self, *_: object) -> None:
        self.close()

    def done(self) -> list[range]:
        """The batches with a sound chunk, in as few ranges as possible.

        Damaged files, and those that killed processes left aside, are removed with a line in the log, unless other
        processes share the folder and may be writing them.
        """
        if self._alone:
            self._remove_leftovers()
        sound = {}
        for batches in self._spans():
            state = self._state(batches)
            if state is not None and (self._sound.get(batches) == state or self._is_sound(batches)):
                sound[batches] = state
        self._sound = sound
        return merged(sound)

    def keep(self, batches: range, chunk: Mapping[str, Any], seconds: float) -> None:
        """Write the results of these batches to disk, where they survive the process.

        ``seconds`` is the time that they took, for the log. Raises PoundingError where they cannot be written, as on a
        full disk, and ValueError for arrays that are not numbers with the batches as their first axis.
        """
        try:
            write_chunk(self.path / CHUNKS, batches, chunk, self._digest)
            state = self._state(batches)
        except OSError as error:
            raise _unwritable_error(self.path, error, f"{self.kept()} are kept; ", self.again) from None
        if state is not None:
            self._sound[batches] = state
        self.log("kept", start=batches.start, stop=batches.stop, seconds=round(seconds, 3))

    def chunks(self, blocks: Iterable[range]) -> Iterator[Chunk]:
        """The arrays of the batches of each block, in order, assembled from the chunks.

        Only batches that the last `done` has returned, or that were kept since, are available. Memory is bounded by a
        block and a chunk. Raises PoundingError for batches without a chunk, and for a chunk that was damaged since.
        """
        return assembled(blocks, self._sound, self._read, self.path)

    def log(self, event: str, **facts: Any) -> None:
        """Add a line to the log; a full disk loses the line and nothing else."""
        write_line(self.path / LOG, event, **facts)

    def clear(self) -> None:
        """Remove the chunks when the results are in place; ``study.json`` and the log stay."""
        for file in map(self._chunk_path, self._spans()):
            file.unlink(missing_ok=True)
        self._sound = {}
        if self._alone:
            self._remove_leftovers()
        self.log("complete")

    def close(self) -> None:
        """Release the lock; a second call does nothing."""
        if self._lock.is_open:
            self.log("stop")
            self._lock.close()

    def _spans(self) -> list[range]:
        """The batches of every chunk file, from its name."""
        names = [entry.name for entry in entries_of(self.path / CHUNKS)]
        return [batches for name in names if (batches := batches_of(name)) is not None]

    def _chunk_path(self, batches: range) -> Path:
        return self.path / CHUNKS / chunk_name(batches)

    def _state(self, batches: range) -> tuple[int, int] | None:
        """Size and time of a chunk file, which tell whether it has changed; None where it does not exist."""
        try:
            stat = self._chunk_path(batches).stat()
        except FileNotFoundError:
            return None
        return stat.st_size, stat.st_mtime_ns

    def _is_sound(self, batches: range) -> bool:
        file = self._chunk_path(batches)
        try:
            read_chunk(file, self._digest)
        except FileNotFoundError:  # another process has removed it since
            return False
        except Damaged as damage:
            if self._alone:
                self._remove(file, str(damage))
            return False
        except OSError as error:
            raise PoundingError(f"{file}: cannot be read ({error.strerror}); check the disk and its rights") from None
        return True

    def _read(self, batches: range) -> Chunk:
        file = self._chunk_path(batches)
        try:
            return read_chunk(file, self._digest)[1]
        except Damaged as damage:
            raise PoundingError(f"{file}: was damaged since: {damage}; run the same command again") from None
        except OSError as error:
            raise PoundingError(f"{file}: cannot be read ({error.strerror}); run the same command again") from None

    def _remove_leftovers(self) -> None:
        """Remove files that killed processes left aside."""
        for folder, pattern in ((self.path, r"study\.json"), (self.path / CHUNKS, CHUNK)):
            for entry in entries_of(folder):
                if files.is_aside(entry.name, pattern):
                    self._remove(Path(entry.path), "a process was killed while it wrote this file")

    def _remove(self, file: Path, why: str) -> None:
        file.unlink(missing_ok=True)
        self.log("removed", file=file.name, why=why)

    def kept(self) -> str:
        """How many cases have a chunk, in words; from the names of the files."""
        return f"{_cases(self._spans(), self.about.width)} of {self.about.batches * self.about.width} cases"


def is_begun(folder: Path, identity: Mapping[str, Any]) -> bool:
    """True where a folder has chunks of the scan of this identity; raises PoundingError as `read_study`."""
    study = read_study(folder)
    if study is None or digest(study["identity"]) != digest(identity):
        return False
    return any(batches_of(entry.name) is not None for entry in entries_of(folder / CHUNKS))


def _cases(chunks: Iterable[range], width: int) -> int:
    return sum(map(len, merged(chunks))) * width


def entries_of(folder: Path) -> list[os.DirEntry[str]]:
    """The entries of a folder by name; none of one that is not there."""
    try:
        return sorted(os.scandir(folder), key=lambda entry: entry.name)
    except FileNotFoundError:
        return []


def check_ours(folder: Path) -> None:
    """Raise PoundingError where the name is that of a file, or of a folder of the user's own."""
    if not folder.exists() and not folder.is_symlink():
        return
    if not folder.is_dir():
        raise PoundingError(
            f"{folder}: is a file; a study is kept in a folder of that name: move it away, or choose another -o"
        )
    entries = entries_of(folder)
    names = {entry.name for entry in entries}
    if links := [entry.name for entry in entries if entry.name in OWN and entry.is_symlink()]:
        raise PoundingError(
            f"{folder}: {links[0]} in it is a symbolic link, and a study is kept in files of its own; nothing was "
            "touched: remove the link, or choose another -o"
        )
    if STUDY in names:
        read_study(folder)
        return
    our_files = {name for name in names if name in OWN or files.is_aside(name, r"study\.json")}
    strangers = sorted(names - our_files)
    # A scan that was killed as it began has left a lock at least.
    if strangers or (names and LOCK not in names):
        raise PoundingError(
            f"{folder}: is not a study's folder ({', '.join((strangers or sorted(names))[:3])} in it), and a study is "
            "kept under that name; nothing was touched: move it away, or choose another -o"
        )


def _differences(study: Mapping[str, Any] | None, identity: Mapping[str, Any], is_same: bool) -> str:
    return "" if study is None or is_same else difference_lines(study["identity"], identity)


def _unwritable_error(folder: Path, error: OSError, kept_text: str, command: str = "the same command") -> PoundingError:
    """The error to raise where the system refuses to write; ``kept_text`` says what is kept."""
    if error.errno == errno.EFBIG:
        repair = files.raised(f"{kept_text}free space and run {command} again")
        return PoundingError(f"{folder}: cannot be written ({error.strerror}{files.limit_words()}); {repair}")
    if error.errno in files.FULL:
        return PoundingError(
            f"{folder}: no space is left there ({error.strerror}); {kept_text}free space and run {command} again"
        )
    return PoundingError(f"{folder}: cannot be written ({error.strerror}); {kept_text}choose another place (-o)")


def write_line(path: Path, event: str, **facts: Any) -> None:
    """Add an event to a log; it is lost where it cannot be written, as on a full disk."""
    time = datetime.now(UTC).isoformat(timespec="milliseconds")
    line = json.dumps({"time": time, "event": event, "host": files.host(), "pid": os.getpid(), **facts}, default=str)
    with suppress(OSError):
        handle = os.open(path, os.O_RDWR | os.O_APPEND | os.O_CREAT | files.OWN_FILE, 0o666)
        try:
            size = os.fstat(handle).st_size
            # A process that was killed while it wrote may have left half a line.
            is_torn = size > 0 and os.pread(handle, 1, size - 1) != b"\n" if hasattr(os, "pread") else False
            os.write(handle, f"{chr(10) if is_torn else ''}{line}\n".encode())
        finally:
            os.close(handle)


def read_lines(path: Path) -> Iterator[dict[str, Any]]:
    """The complete lines of a log, in order; none where there is no log."""
    with suppress(FileNotFoundError), open(path, "rb") as file:
        for line in file:
            with suppress(ValueError):  # half a line
                event = json.loads(line)
                if isinstance(event, dict) and {"time", "event"} <= set(event):
                    yield event
