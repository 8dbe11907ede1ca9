"""Provenance in the attributes of a results file, written and read: scene, options, and digests of the records."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from pounding_risk._jit.sources import source_digest
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.models.contact.impulsive import CONTACT_MODELS
from pounding_risk.motions.motion import Motion
from pounding_risk.results.attributes import SCENE_AXES, as_text, read_attribute
from pounding_risk.results.check import check_scan
from pounding_risk.results.tolerance_check import check_share
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.records import missing_files, named_files
from pounding_risk.scene.scene import Scene, own_laws
from pounding_risk.scene.toml import as_list, table, tables

if TYPE_CHECKING:
    import xarray as xr

NEEDED = ("scene_resolved", "scene_sha256", "options", "records", "motions_sha256")
SHOWN = 12  # digits of a checksum
CHANGED = "the file was changed since; run its scene with scan"


class Recorded(NamedTuple):
    """The scene and the options that a results file was made from."""

    study: Scene
    screening: bool
    check_fraction: float


def provenance(study: Scene, motions: Iterable[Motion], screening: bool, check_fraction: float) -> dict[str, str]:
    """Attributes of a dataset: the scene file, options, and digests of the scene, motions, kernels and own laws.

    `recorded` reads them together with ``scene_resolved``, ``records`` and ``versions``.
    """
    return {
        "scene_file": study.source.encode(errors="backslashreplace").decode(),  # a name need not be text
        "scene_sha256": text_digest(study.to_toml()),
        "options": as_text({"screening": screening, "check_fraction": check_fraction}),
        "motions_sha256": as_text({motion.name: motion.digest for motion in motions}),
        "kernels_digest": source_digest(),
        **({"own_laws": as_text(laws)} if (laws := own_laws(study)) else {}),
    }


def text_digest(text: str) -> str:
    """SHA-256 of a text in UTF-8."""
    return sha256(text.encode()).hexdigest()


def recorded(results: xr.Dataset, path: Path, folder: str | Path | None = None) -> Recorded:
    """The scene and the options of results of a scan that were read from ``path``.

    Record files that the scene names relative to itself are looked for in ``folder``; without one in the folder of the
    scene file, then beside the results. Raises PoundingError for results without what it takes, attributes that were
    changed, a contact law that this process does not know, and records that are not found; SceneError where the scene
    cannot be read by this version.
    """
    attrs = results.attrs
    if "baseline" in attrs:
        raise PoundingError(f"{path}: was written by compare, and only results of scan and demo can be run again")
    if missing := [name for name in NEEDED if name not in attrs]:
        raise PoundingError(
            f"{path}: has no attribute {' nor '.join(missing)}, which it takes to run it again: it was written by "
            "another command or an earlier version; run its scene with scan"
        )
    text = str(attrs["scene_resolved"])
    if text_digest(text) != str(attrs["scene_sha256"]):
        fault = "the attribute scene_resolved is not the one that scene_sha256 was taken of"
        raise PoundingError(f"{path}: {fault}: {CHANGED}")
    screening, fraction = _options(results, path)
    raw = tomllib.loads(text)
    _check_laws(raw, path)
    source = _folder(raw, attrs, path, folder) / Path(str(attrs.get("scene_file", "scene"))).name
    check_scan(results, str(path))
    overrides = tuple(map(str, read_attribute(results, "overrides", [])))
    try:
        if SCENE_AXES in attrs:  # its axes set keys of the scene as written
            return Recorded(parse_scene(str(attrs.get("scene", text)), str(source), overrides), screening, fraction)
        study = parse_scene(text, str(source))
    except SceneError as error:
        raise SceneError(f"{path}, its scene", error.faults) from None
    return Recorded(study.updated(text=str(attrs.get("scene", text)), overrides=overrides), screening, fraction)


def _options(results: xr.Dataset, path: Path) -> tuple[bool, float]:
    options = read_attribute(results, "options", {})
    screening, fraction = (options.get(key) for key in ("screening", "check_fraction"))
    if not isinstance(screening, bool) or isinstance(fraction, bool) or not isinstance(fraction, int | float):
        raise PoundingError(f"{path}: the attribute options holds no screening and check_fraction: {CHANGED}")
    check_share(fraction)
    return screening, fraction


def _check_laws(raw: Mapping[str, Any], path: Path) -> None:
    """Refuse contact laws that are not registered."""
    requested = [element.get("contact_model") for _, element in tables(raw, "interface")]
    requested += as_list(table(raw, "grid").get("contact_model"))
    unknown = [name for name in dict.fromkeys(requested) if name is not None and name not in CONTACT_MODELS]
    if unknown:
        raise PoundingError(
            f"{path}: was run under {', '.join(unknown)}, which is no contact model here; where it is of a plug-in, "
            "install that (the attribute plugins of the results names it); where it is a law of your own, import what "
            "registers it with contact_law, and do the same from Python in that process"
        )


def _folder(raw: Mapping[str, Any], attrs: Mapping[str, Any], path: Path, folder: str | Path | None) -> Path:
    """The folder of the records that the scene names as files."""
    if folder is not None:
        places = [Path(folder)]
    else:
        places = [Path(str(attrs["scene_file"])).parent] if "scene_file" in attrs else []
        places.append(path.parent)
    missing = [list(missing_files(raw, place)) for place in places]
    for place, faults in zip(places, missing, strict=True):
        if not faults:
            return place
    paths = " nor ".join(str(place.resolve()) for place in dict.fromkeys(places))
    records = table(raw, "records")
    names = dict.fromkeys(name for _, name in named_files(raw))
    files = records.get("manifest") or records.get("sites") or ", ".join(names)
    raise PoundingError(
        f"{path}: its scene takes records from {files}, and they are not all in {paths}; name the folder of the scene "
        "with --folder, or folder= in Python"
    )


def check_records(results: xr.Dataset, motions: Sequence[Motion]) -> list[str]:
    """A sentence for each motion whose record is the same, but whose processed samples are not.

    Raises PoundingError, with a sentence for each fault, where records are not those that the results name.
    """
    old = _checksums(results)
    new = dict(file for motion in motions for file in _files_of({"sha256": "", **motion.record, "name": motion.name}))
    faults = list(_changes(old, new))
    if faults:
        raise PoundingError(
            "\n".join(["the records are not those of the results", *(f"  - {fault}" for fault in faults)])
        )
    digests = read_attribute(results, "motions_sha256", {})
    return [
        f"{motion.name}: the same record, but another motion after its processing: was {digest[:SHOWN]}, is "
        f"{motion.digest[:SHOWN]}"
        for motion in motions
        if (digest := str(digests.get(motion.name, ""))) != motion.digest
    ]


def _checksums(results: xr.Dataset) -> dict[str, str]:
    """SHA-256 of the file of each record, by the name of the record, and of the histories under it."""
    try:
        return dict(file for record in read_attribute(results, "records", []) for file in _files_of(record))
    except (TypeError, KeyError, AttributeError):
        what = "the attribute records of the results holds no names and checksums"
        raise PoundingError(f"{what}: {CHANGED}") from None


def _files_of(record: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """What is said of a record's file, and of each displacement_history under it, and the SHA-256."""
    yield str(record["name"]), str(record["sha256"])
    for building, history in record.get("displacement_history", {}).items():
        yield f"the displacement_history of {building} under {record['name']}", str(history["sha256"])


def _changes(before: Mapping[str, str], after: Mapping[str, str]) -> Iterator[str]:
    for name, checksum in before.items():
        if name not in after:
            yield f"{name} was among them and is not; put its file back"
        elif after[name] != checksum:
            was, now = checksum[:SHOWN], after[name][:SHOWN]
            yield f"{name}: the sha256 of its file was {was}..., is {now}...; put the file of then back"
    yield from (f"{name} was not among them; take its file away" for name in after if name not in before)
