"""Protection of existing results: a file is replaced only by results of the same command and the same scene."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from pounding_risk.ensemble.identity import difference_lines, program_of, record_of, tables_of_runs
from pounding_risk.errors import PoundingError
from pounding_risk.results.attributes import from_text
from pounding_risk.results.check import kind_of_names
from pounding_risk.results.files import head_of

if TYPE_CHECKING:
    from pounding_risk.scene.scene import Scene

OTHER_NAME = "move it away, or write to another name"
CHOICE = "to replace it say so (--new, or new=True in Python), or write to another name (-o)"


class Finished(NamedTuple):
    """How a file was made, from its attributes."""

    command: str  # that wrote it; "" for a file that is not of this package
    attrs: dict[str, Any]


def check_replaceable(
    target: Path, command: str, identity: Mapping[str, Any] | None = None, new: bool = False, choice: str = CHOICE
) -> None:
    """Raise PoundingError before a file is replaced that is not of the same command and the same scene.

    The sentence says what the file is, or has the first differences, and the ``choice`` of the user. ``command`` is the
    one that writes, as `check.kind_of` has it. The tables of ``identity``, as of `identity.identity`, that the file has
    too are compared; None compares none. Nothing is refused where there is no file, or with ``new``.
    """
    if new or not target.exists():
        return
    finished = read_finished(target)
    if finished.command != command:
        content = f"the results of {finished.command}" if finished.command else "no results of pounding-risk"
        raise PoundingError(f"{target}: is there already and holds {content}, not those of {command}; {choice}")
    if identity is None:
        return
    recorded, requested = recorded_identity(finished.attrs), comparable(identity)
    common_names = recorded.keys() & requested.keys()
    recorded, requested = ({name: tables[name] for name in common_names} for tables in (recorded, requested))
    if lines := difference_lines(recorded, requested):
        raise PoundingError(f"{target}: holds the finished {command} of a study that was another; {choice}:{lines}")


def check_replaceable_scene(target: Path, command: str, study: Scene, new: bool = False) -> None:
    """Refuse to replace results of another scene or command: raises PoundingError."""
    check_replaceable(target, command, {"scene": tables_of_runs(study.resolved())}, new)


def read_finished(target: Path) -> Finished:
    """The command and the attributes of a dataset on disk; for any other file the command is ""."""
    try:
        names, attrs = head_of(target)
    except (OSError, RuntimeError, ValueError):  # no netCDF file, or no JSON: nothing of this package
        return Finished("", {})
    if "versions" not in attrs and "kernels_digest" not in attrs:
        return Finished("", attrs)
    return Finished(kind_of_names(names, names, set(attrs)), attrs)


def recorded_identity(attrs: Mapping[str, Any]) -> dict[str, Any]:
    """The tables of `identity.identity` that can be read from the attributes of a dataset."""
    tables = {
        "scene": _scene(attrs.get("scene_resolved")),
        "records": _records(attrs),
        "options": from_text(attrs.get("options")),
        "program": _program(attrs),
        "laws": from_text(attrs.get("own_laws", "{}")),
    }
    return {name: table for name, table in tables.items() if table is not None}


def comparable(identity: Mapping[str, Any]) -> dict[str, Any]:
    """An identity with the digest of the kernels, which datasets have, in place of that of the package."""
    from pounding_risk._jit.sources import source_digest

    program = identity.get("program")
    return {**identity, **({} if program is None else {"program": {**program, "source": source_digest()}})}


def _scene(text: Any) -> dict[str, Any] | None:
    """The resolved scene without its title and states of damage, which change no number."""
    try:
        return tables_of_runs(tomllib.loads(text))
    except (TypeError, AttributeError, tomllib.TOMLDecodeError):
        return None


def _records(attrs: Mapping[str, Any]) -> list[dict[str, Any]] | None:
    records, digests, steps = (from_text(attrs.get(name)) for name in ("records", "motions_sha256", "processing"))
    if not isinstance(records, list) or not isinstance(digests, dict) or not isinstance(steps, dict):
        return None
    named_records = ((record["name"], record) for record in records if isinstance(record, dict) and "name" in record)
    return [record_of(name, record, digests.get(name, ""), steps.get(name, [])) for name, record in named_records]


def _program(attrs: Mapping[str, Any]) -> dict[str, str] | None:
    versions = from_text(attrs.get("versions"))
    if not isinstance(versions, dict) or "kernels_digest" not in attrs:
        return None
    return program_of(versions, str(attrs["kernels_digest"]))
