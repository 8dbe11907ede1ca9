"""What the spectra are of: a scene, or records named in any way, with the options that treat these."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from pounding_risk.cli._common.options import read_option
from pounding_risk.cli.records import _options as options
from pounding_risk.errors import PoundingError

if TYPE_CHECKING:
    from pounding_risk.motions.request import RecordRequest

SCENE = ".toml"
SOURCE = f"A scene file (TOML); or {options.WORDS}, or a record set."


def read_subject(source: Sequence[str], overrides: list[str], treatment: Mapping[str, Any]) -> Any:
    """The scene, or the request for the records that are named; ``treatment`` are the options of records by name.

    Raises PoundingError for what does not go together, and as `read_scene`.
    """
    if source[0].lower().endswith(SCENE):
        from pounding_risk.scene.reader import read_scene

        _refuse_beside_scene(source, [f"--{name}" for name, value in treatment.items() if value is not None])
        return read_scene(source[0], overrides)
    if overrides:
        raise PoundingError("--set: changes a value of a scene, and records are named; leave it out")
    from pounding_risk.units import TAIL

    chosen = {name: treatment[name] for name in ("window", "pga", "scale", "sa", "direction")}
    request = options.record_request(treatment["processing"], (), **chosen)
    facts = options.stated_facts(treatment["unit"], treatment["dt"])
    tail = treatment["tail"]
    seconds = 0.0 if tail is None else read_option("--tail", tail, TAIL)
    return _of_words(source, request._replace(unit=facts["unit"] or "", dt=facts["dt"], tail=seconds))


def _refuse_beside_scene(source: Sequence[str], given: Sequence[str]) -> None:
    """Raise PoundingError for further words and for options of records beside a scene."""
    if len(source) > 1:
        raise PoundingError(f"{source[1]}: stands beside the scene {source[0]}, which names its records; leave one out")
    if given:
        example = "--set records.pga='0.5 g'"
        raise PoundingError(
            f"{given[0]}: is of records, and {source[0]} states how its own are treated; write {example}"
        )


def _of_words(words: Sequence[str], request: RecordRequest) -> RecordRequest:
    """The request with the records that the words name, in both polarities."""
    from pathlib import Path

    from pounding_risk.motions.catalogue import entries
    from pounding_risk.motions.generated import is_recipe, recipe_of
    from pounding_risk.motions.record_sets import SETS
    from pounding_risk.motions.request import POLARITIES, matching
    from pounding_risk.motions.source import open_source

    sets = [word for word in words if word in SETS]
    if sets and len(words) > 1:
        other = next(word for word in words if word != sets[0]) if len(set(words)) > 1 else sets[0]
        raise PoundingError(f"{other}: stands beside the record set {sets[0]}, which is used alone; leave one out")
    if sets:
        return request._replace(set=sets[0], polarities=POLARITIES)
    ids = {entry.id for entry in entries()}
    names = tuple(word for word in words if word in ids)
    recipes = tuple(recipe_of(word) for word in words if word not in ids and is_recipe(word))
    files = tuple(word for word in words if word not in ids and not is_recipe(word))
    for word in files:
        if not (Path(word).is_dir() or matching(Path(), word)):
            open_source(word)  # raises, with what the word may have meant
    return request._replace(names=names, files=files, generated=recipes, polarities=POLARITIES)
