"""Protection of existing results: a file is replaced only by results of the same command and the same scene."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from pounding_risk.ensemble.identity import HISTORY, difference
from pounding_risk.errors import PoundingError
from pounding_risk.results.attributes import from_text
from pounding_risk.results.check import kind_of_names
from pounding_risk.results.files import head_of
from pounding_risk.scene.overrides import WITHOUT_RUNS

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
    """Refuse to replace a file that is not of the same command and the same scene.

    Parameters
    ----------
    target
        Where results are about to be written; nothing is refused where there is no file.
    command
        That writes them, as `check.kind_of` has it.
    identity
        Tables of `identity.identity`, of which those that the file tells too are compared; None compares none.
    new
        Whether whoever asks wants to have it replaced, whatever it is.
    choice
        What whoever asks may do, for the sentence.

    Raises
    ------
    PoundingError
        With what the file is, or with every difference.
    """
    if new or not target.exists():
        return
    finished = read_finished(target)
    if finished.command != command:
        what = f"the results of {finished.command}" if finished.command else "no results of pounding-risk"
        raise PoundingError(f"{target}: is there already and holds {what}, not those of {command}; {choice}")
    if identity is None:
        return
    recorded, requested = recorded_identity(finished.attrs), comparable(identity)
    both = recorded.keys() & requested.keys()
    recorded, requested = ({name: tables[name] for name in both} for tables in (recorded, requested))
    if changes := difference(recorded, requested):
        listed = "".join(f"\n  - {sentence}" for sentence in changes)
        raise PoundingError(f"{target}: holds the finished {command} of a study that was another:{listed}\n{choice}")


def check_replaceable_scene(target: Path, command: str, study: Scene, new: bool = False) -> None:
    """Refuse to replace results of another scene or command: raises PoundingError."""
    scene = {key: table for key, table in study.resolved().items() if key not in WITHOUT_RUNS}
    check_replaceable(target, command, {"scene": scene}, new)


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
        return {key: table for key, table in tomllib.loads(text).items() if key not in WITHOUT_RUNS}
    except (TypeError, AttributeError, tomllib.TOMLDecodeError):
        return None


def _records(attrs: Mapping[str, Any]) -> list[dict[str, Any]] | None:
    records, digests, steps = (from_text(attrs.get(name)) for name in ("records", "motions_sha256", "processing"))
    if not isinstance(records, list) or not isinstance(digests, dict) or not isinstance(steps, dict):
        return None
    return [
        {
            "name": record["name"],
            "sha256": str(record.get("sha256", "")),
            "samples": digests.get(record["name"], ""),
            "processing": steps.get(record["name"], []),
            **{key: record[key] for key in (HISTORY,) if key in record},
        }
        for record in records
        if isinstance(record, dict) and "name" in record
    ]


def _program(attrs: Mapping[str, Any]) -> dict[str, str] | None:
    versions = from_text(attrs.get("versions"))
    if not isinstance(versions, dict) or "kernels_digest" not in attrs:
        return None
    from pounding_risk.ensemble.identity import LIBRARIES

    python = ".".join(str(versions.get("python", "")).split(".")[:2])
    libraries = {name: str(versions[name]) for name in LIBRARIES if name in versions}
    return {"python": python, **libraries, "source": str(attrs["kernels_digest"])}
