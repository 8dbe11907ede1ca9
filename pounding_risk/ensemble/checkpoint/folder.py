"""The folder beside a study's results that keeps what is computed: a run that is killed goes on where it was.

``results.nc`` has ``results.study`` beside it:

- ``study.json``: the study's identity and its digest, batches, cases a batch, title, command, when it was begun;
- ``parts/<start>-<stop>.npz``: what these batches of the grid give (see `study_parts`);
- ``log.jsonl``: what happened when, for people and for `status`;
- ``lock``: who writes, held by the system (see `study_lock`).
"""

from __future__ import annotations

import errno
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from pounding_risk._common.dates import now
from pounding_risk._common.files import FULL, is_partial_of, led_to, limit_words, raised, sync_folder, write_whole
from pounding_risk.ensemble.checkpoint.chunks import CHUNK, Damaged, batches_of, chunk_name, read_chunk, write_chunk
from pounding_risk.ensemble.checkpoint.lock import Held, Lock
from pounding_risk.ensemble.checkpoint.log import write_line
from pounding_risk.ensemble.chunks import Chunk, chosen, joined, merged, pieces_of
from pounding_risk.ensemble.identity import difference, digest
from pounding_risk.errors import PoundingError

STUDY, CHUNKS, LOG, LOCK = "study.json", "parts", "log.jsonl", "lock"
OWN = (STUDY, CHUNKS, LOG, LOCK)
FORMAT = "pounding_risk study 1"
SUFFIX = ".study"


class About(NamedTuple):
    """What a study is, for people: beside its identity, and no chunk of it."""

    batches: int
    width: int  # cases in a batch
    title: str = ""
    command: str = ""

    def table(self) -> dict[str, Any]:
        """The fields under their names in ``study.json``."""
        return {"lines": self.batches, "width": self.width, "title": self.title, "command": self.command}


def folder_of(results: str | Path) -> Path:
    """Where the study of a results file is kept: beside it, ``results.study`` for ``results.nc``.

    A name that is a symbolic link has the study of the file that it leads to. Raises PoundingError for what names no
    file, such as "." for this folder.
    """
    path = Path(results)
    if path.name in ("", ".."):
        raise PoundingError(f'"{results}" is a folder; name the results, such as {path / "results.nc"}')
    return path if path.suffix == SUFFIX else led_to(path).with_suffix(SUFFIX)


def read_study(folder: Path) -> dict[str, Any] | None:
    """What ``study.json`` says; None where there is none. Raises PoundingError where it is not a study's."""
    file = folder / STUDY
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    except (ValueError, RecursionError):
        found = None
    except OSError as error:
        raise PoundingError(f"{file}: cannot be read ({error.strerror}); check its permissions") from None
    expected = {"identity": dict, "lines": int, "width": int, "title": str, "command": str, "begun": str}
    whole = isinstance(found, dict) and all(isinstance(found.get(key), kind) for key, kind in expected.items())
    if whole and found.get("format") == FORMAT:
        return found
    raise PoundingError(
        f"{file}: is not a study of this version of pounding-risk; it was left as it is: move the folder "
        f"{folder.name} away, or write the results under another name (-o)"
    )


class Checkpoint:
    """A study's folder, open for writing: by one process, or by several that share it.

    Use as a context manager, or `close` it. ``path`` is the folder, ``about`` what the study is.
    """

    def __init__(self, path: Path, lock: Lock, alone: bool, about: About, digest: str):
        self.path, self.about = path, about
        self._lock, self._alone, self._digest = lock, alone, digest
        self.again = "the same command"  # goes on with what is kept
        self.begun = ""  # when the study was
        self._sound: dict[range, tuple[int, int]] = {}  # batches of the chunks that were verified, and size and time

    @classmethod
    def open(
        cls,
        path: str | Path,
        identity: Mapping[str, Any],
        about: About,
        *,
        new: bool = False,
        shared: bool = False,
    ) -> Checkpoint:
        """Begin a study in a folder, or go on with the one that is there.

        ``new`` discards what an earlier one has computed, and of the folder nothing else; ``shared`` lets other
        processes share the folder, each with batches of its own. Raises PoundingError where the folder is not a
        study's, where another run writes it, where it cannot be written, and, with every difference, where it
        holds chunks of a study of another identity.
        """
        folder = Path(path)
        check_ours(folder)
        try:
            folder.mkdir(exist_ok=True)
            lock = Lock(folder / LOCK)
        except OSError as error:
            raise _unwritable(folder, error, "") from None
        try:
            alone = lock.take(shared)
            found = cls(folder, lock, alone and not shared, about, digest(identity))
            found._begin(identity, new, alone)
            if shared and alone:
                lock.share()
        except BaseException as error:
            lock.close()
            if isinstance(error, Held):
                raise _held(folder, error) from None
            if isinstance(error, OSError):
                raise _unwritable(folder, error, "") from None
            raise
        if new:
            found.again += " without --new"
        found.log("start", shared=shared, command=about.command)
        return found

    def _begin(self, identity: Mapping[str, Any], new: bool, alone: bool) -> None:
        """Have the study of this identity in the folder, or refuse."""
        kept = read_study(self.path)
        same = kept is not None and digest(kept["identity"]) == self._digest
        if kept is not None and same and not new:
            self.begun = kept["begun"]
            (self.path / CHUNKS).mkdir(exist_ok=True)
            return
        if not alone:
            raise PoundingError(
                f"{self.path}: other runs are writing {'this' if same else 'another'} study here; wait for them, or "
                "stop them, and run the same command again" + _differences(kept, identity, same)
            )
        if kept and not new and self._files():
            raise PoundingError(
                f"{self.path}: holds {_cases(self._files(), kept['width'])} cases of a study that was another:"
                f"{_differences(kept, identity, same)}\nput that back to go on with it, write --new to discard "
                "it, or write the results under another name (-o)"
            )
        self._discard()
        self._write_study(identity)

    def _write_study(self, identity: Mapping[str, Any]) -> None:
        self.begun = now()
        facts = {"format": FORMAT, "begun": self.begun, "digest": self._digest, **self.about.table()}
        text = json.dumps({**facts, "working_folder": os.getcwd(), "identity": identity}, ensure_ascii=False, indent=1)
        write_whole(self.path / STUDY, lambda file: file.write(text.encode(errors="backslashreplace")))
        (self.path / CHUNKS).mkdir(exist_ok=True)
        sync_folder(self.path)
        self.log("begin", **self.about.table())

    def __enter__(self) -> Checkpoint:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def done(self) -> list[range]:
        """The batches of which there is a sound chunk, in as few ranges as there can be.

        A damaged file, and one that a killed process has left aside, is removed with a line in the log, where nobody
        else can be writing it; where others share the folder it only does not count.
        """
        if self._alone:
            self._sweep()
        found = {}
        for batches in self._files():
            state = self._state(batches)
            if state is not None and (self._sound.get(batches) == state or self._is_sound(batches)):
                found[batches] = state
        self._sound = found
        return merged(found)

    def keep(self, batches: range, chunk: Mapping[str, Any], seconds: float) -> None:
        """Have what these batches give on disk: after the call it outlives the process.

        ``seconds`` is what it took, for the log. Raises PoundingError where it cannot be written, as on a full disk,
        and ValueError for arrays that are not numbers with the batches as their first axis.
        """
        try:
            write_chunk(self.path / CHUNKS, batches, chunk, self._digest)
            state = self._state(batches)
        except OSError as error:
            raise _unwritable(self.path, error, f"{self.kept()} are kept; ", self.again) from None
        if state is not None:
            self._sound[batches] = state
        self.log("kept", start=batches.start, stop=batches.stop, seconds=round(seconds, 3))

    def chunks(self, blocks: Iterable[range]) -> Iterator[Chunk]:
        """The arrays of the batches of each block, in order, from whatever chunks there are.

        Only batches that the last `done` has found, or that were kept since, are there. Memory is bounded by a block
        and a chunk. Raises PoundingError for batches without a chunk, and for a chunk that was damaged since.
        """
        choice = chosen(self._sound)
        home, whole = range(0), Chunk()
        for block in blocks:
            pieces, end = [], block.start
            for batches, source in pieces_of(block, choice):
                if batches.start != end:
                    break
                if source != home:
                    home, whole = source, self._read(source)
                inside = slice(batches.start - home.start, batches.stop - home.start)
                # A copy of a few batches lets go of all others of their chunk.
                pieces.append({name: array[inside].copy() for name, array in whole.items()})
                end = batches.stop
            if end < block.stop:
                raise PoundingError(
                    f"{self.path}: of the batches from {end} on there is no chunk; run the same command again"
                )
            yield joined(pieces)

    def log(self, event: str, **facts: Any) -> None:
        """Add a line to the log, with the time; a full disk loses the line and nothing else."""
        write_line(self.path / LOG, event, **facts)

    def clear(self) -> None:
        """Remove the chunks: the results are in place. What the study was, and its log, stay."""
        self._remove_parts()
        self.log("complete")

    def close(self) -> None:
        """Let others write the folder; a second time it does nothing."""
        if self._lock.is_open:
            self.log("stop")
            self._lock.close()

    def _files(self) -> list[range]:
        """The batches of every file with the name of a chunk."""
        names = [entry.name for entry in _entries(self.path / CHUNKS)]
        return [batches for name in names if (batches := batches_of(name)) is not None]

    def _file(self, batches: range) -> Path:
        return self.path / CHUNKS / chunk_name(batches)

    def _state(self, batches: range) -> tuple[int, int] | None:
        """Size and time of a chunk's file, by which it is known again; None where it is gone."""
        try:
            found = self._file(batches).stat()
        except FileNotFoundError:
            return None
        return found.st_size, found.st_mtime_ns

    def _is_sound(self, batches: range) -> bool:
        file = self._file(batches)
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
        file = self._file(batches)
        try:
            return read_chunk(file, self._digest)[1]
        except Damaged as damage:
            raise PoundingError(f"{file}: was damaged since: {damage}; run the same command again") from None
        except OSError as error:
            raise PoundingError(f"{file}: cannot be read ({error.strerror}); run the same command again") from None

    def _sweep(self) -> None:
        """Remove what killed processes have left aside."""
        for folder, pattern in ((self.path, r"study\.json"), (self.path / CHUNKS, CHUNK)):
            for entry in _entries(folder):
                if is_partial_of(entry.name, pattern):
                    self._remove(Path(entry.path), "a process was killed while it wrote this file")

    def _remove(self, file: Path, why: str) -> None:
        file.unlink(missing_ok=True)
        self.log("removed", file=file.name, why=why)

    def _remove_parts(self) -> None:
        for batches in self._files():
            self._file(batches).unlink(missing_ok=True)
        self._sound = {}
        if self._alone:
            self._sweep()

    def _discard(self) -> None:
        """Remove what an earlier study has left, and nothing that is not ours."""
        (self.path / STUDY).unlink(missing_ok=True)
        for batches in self._files():
            self._file(batches).unlink(missing_ok=True)
        (self.path / LOG).unlink(missing_ok=True)

    def kept(self) -> str:
        """How many of the study's cases have a chunk, in words; told without a look into the chunks."""
        return f"{_cases(self._files(), self.about.width)} of {self.about.batches * self.about.width} cases"


def is_begun(folder: Path, identity: Mapping[str, Any]) -> bool:
    """Whether a folder keeps chunks of the study of this identity; raises PoundingError as `read_study`."""
    kept = read_study(folder)
    if kept is None or digest(kept["identity"]) != digest(identity):
        return False
    return any(batches_of(entry.name) is not None for entry in _entries(folder / CHUNKS))


def _cases(chunks: Iterable[range], width: int) -> int:
    return sum(map(len, merged(chunks))) * width


def _entries(folder: Path) -> list[os.DirEntry[str]]:
    try:
        return sorted(os.scandir(folder), key=lambda entry: entry.name)
    except FileNotFoundError:
        return []


def check_ours(folder: Path) -> None:
    """Raises PoundingError for a name that something else has: a file, or a folder of the user's own."""
    if not folder.exists() and not folder.is_symlink():
        return
    if not folder.is_dir():
        raise PoundingError(
            f"{folder}: is a file; a study is kept in a folder of that name: move it away, or choose another -o"
        )
    entries = _entries(folder)
    names = {entry.name for entry in entries}
    if links := [entry.name for entry in entries if entry.name in OWN and entry.is_symlink()]:
        raise PoundingError(
            f"{folder}: {links[0]} in it is a symbolic link, and a study is kept in files of its own; nothing was "
            "touched: remove the link, or choose another -o"
        )
    if STUDY in names:
        read_study(folder)
        return
    own = {name for name in names if name in OWN or is_partial_of(name, r"study\.json")}
    strangers = sorted(names - own)
    # Of a study that was killed as it began there is a lock at least.
    if strangers or (names and LOCK not in names):
        raise PoundingError(
            f"{folder}: is not a study's folder ({', '.join((strangers or sorted(names))[:3])} in it), and a study is "
            "kept under that name; nothing was touched: move it away, or choose another -o"
        )


def _differences(kept: Mapping[str, Any] | None, identity: Mapping[str, Any], same: bool) -> str:
    if kept is None or same:
        return ""
    return "".join(f"\n  - {sentence}" for sentence in difference(kept["identity"], identity))


def _held(folder: Path, held: Held) -> PoundingError:
    who = " and ".join(f"{holder}, since {holder.since}" for holder in held.holders) or "another process"
    return PoundingError(
        f"{folder}: another run is writing this study: {who}; wait for it, or stop it, and run the same command again"
    )


def _unwritable(folder: Path, error: OSError, kept: str, again: str = "the same command") -> PoundingError:
    """What is told where the system refuses to write."""
    if error.errno == errno.EFBIG:
        repair = raised(f"{kept}free space and run {again} again")
        return PoundingError(f"{folder}: cannot be written ({error.strerror}{limit_words()}); {repair}")
    if error.errno in FULL:
        return PoundingError(
            f"{folder}: no space is left there ({error.strerror}); {kept}free space and run {again} again"
        )
    return PoundingError(f"{folder}: cannot be written ({error.strerror}); {kept}choose another place (-o)")
