"""Subjects of questions: a scene, a dataset, either, or records, with the arguments and options that belong to each."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from pounding_risk.cli._common import options as shared
from pounding_risk.cli._common.options import NONE, REQUIRED, Fields, argument, option, read_optional
from pounding_risk.cli.records import _options as options
from pounding_risk.errors import PoundingError
from pounding_risk.units import TAIL

if TYPE_CHECKING:
    from pounding_risk.motions.request import RecordRequest

SCENE = ".toml"
SOURCE = f"A scene file (TOML); or {options.WORDS}, or a record set."
EXPORTED = "Datasets of scan or damage (.nc or .zarr); a scene (.toml) for opensees."
UNCERTAIN = "A scene with [uncertain] (.toml), or a dataset of its scan (.nc)."
TREATMENT = {
    "pga": options.Pga, "scale": options.Scale, "sa": options.SpectralAcceleration, "processing": options.Processing,
    "window": options.Window, "direction": options.Direction,
    "tail": Annotated[str | None, option("Free vibration after each record, at least.", "none")],
    "unit": options.Unit, "dt": options.Step,
}  # fmt: skip
OVERRIDES: Fields = {"overrides": (shared.Overrides, NONE)}
SELECT: Fields = {"select": (shared.Select, NONE)}


class Subject(NamedTuple):
    """Arguments and options that state the subject of a question, and the function that opens it from their values."""

    fields: Fields
    open: Any


def _results(arguments: dict[str, Any]) -> Any:
    select = arguments.pop("select")
    results = arguments.pop("results")
    return None if results is None else shared.opened_results(results, select)


def _file(source: Path, select: list[str], overrides: list[str]) -> Any:
    """A scene with its overrides; or a file of results, and its dataset where values are selected."""
    if source.suffix.lower() == SCENE:
        from pounding_risk.scene.reader import read_scene

        if select:
            raise PoundingError(f"--select: is of results, and {source} is a scene; write --set")
        return read_scene(source, overrides)
    if overrides:
        raise PoundingError(f"--set: changes a value of a scene, and {source} holds results; leave it out")
    return shared.chosen_results(source, select)


def _scene(arguments: dict[str, Any], name: str = "scene") -> Any:
    return shared.chosen_scene(arguments.pop(name), arguments.pop("overrides"), arguments.pop("select"))


def _records(arguments: dict[str, Any]) -> Any:
    """The scene, or the request for the records that are named; raises PoundingError for what does not go together."""
    source, overrides = arguments.pop("source"), arguments.pop("overrides")
    treatment = {name: arguments.pop(name) for name in TREATMENT}
    if source[0].lower().endswith(SCENE):
        from pounding_risk.scene.reader import read_scene

        _refuse_beside_scene(source, [f"--{name}" for name, value in treatment.items() if value is not None])
        return read_scene(source[0], overrides)
    if overrides:
        raise PoundingError("--set: changes a value of a scene, and records are named; leave it out")
    scaling = {name: treatment[name] for name in ("window", "pga", "scale", "sa", "direction")}
    request = options.record_request(treatment["processing"], (), **scaling)
    facts = options.stated_facts(treatment["unit"], treatment["dt"])
    tail = read_optional("--tail", treatment["tail"], TAIL) or 0.0
    return _request_of_words(source, request._replace(unit=facts["unit"] or "", dt=facts["dt"], tail=tail))


def _refuse_beside_scene(source: Sequence[str], flags: Sequence[str]) -> None:
    """Raise PoundingError for further words and for options of records beside a scene."""
    if len(source) > 1:
        raise PoundingError(f"{source[1]}: stands beside the scene {source[0]}, which names its records; leave one out")
    if flags:
        example = "--set records.pga='0.5 g'"
        raise PoundingError(
            f"{flags[0]}: is of records, and {source[0]} states how its own are treated; write {example}"
        )


def _request_of_words(words: Sequence[str], request: RecordRequest) -> RecordRequest:
    """The request with the records that the words name, in both polarities."""
    from pounding_risk.motions.catalogue import entries
    from pounding_risk.motions.formats import matching
    from pounding_risk.motions.generated import is_recipe, recipe_of
    from pounding_risk.motions.read import open_source
    from pounding_risk.motions.record_sets import SETS
    from pounding_risk.motions.request import POLARITIES

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


def _argument(name: str, kind: Any, metavar: str, words: str) -> Fields:
    """An argument that must be given."""
    return {name: (Annotated[kind, argument(metavar, words)], REQUIRED)}


RESULTS: Fields = {"results": (shared.Results, REQUIRED)}
# By the name that a question gives; without one by the name of the function's first parameter.
SUBJECTS: dict[str, Subject] = {
    "results": Subject(RESULTS | SELECT, _results),
    "results in part": Subject(
        RESULTS | SELECT, lambda values: shared.chosen_results(values.pop("results"), values.pop("select"))
    ),
    "results of rows": Subject(
        _argument("results", list[Path], "RESULTS...", "What scan wrote; or a run of simulate.") | SELECT,
        lambda values: [shared.chosen_results(file, values["select"]) for file in values.pop("results")],
    ),
    "results or scenes": Subject(
        _argument("source", list[Path], "SOURCE...", EXPORTED) | SELECT | OVERRIDES,
        lambda values: [_file(file, values["select"], values["overrides"]) for file in values.pop("source")],
    ),
    "results file": Subject(
        _argument("results", Path, "RESULTS", "What scan or demo wrote (.nc)."), lambda values: values.pop("results")
    ),
    "optional results": Subject({"results": (shared.OptionalResults, None), **SELECT}, _results),
    "study": Subject(
        {"study": (shared.Scene, REQUIRED), **OVERRIDES, **SELECT}, lambda values: _scene(values, "study")
    ),
    "scene": Subject({"scene": (shared.Scene, REQUIRED), **OVERRIDES, **SELECT}, _scene),
    "scene or results": Subject(
        _argument("source", Path, "SOURCE", UNCERTAIN) | SELECT | OVERRIDES,
        lambda values: _file(values.pop("source"), values.pop("select"), values.pop("overrides")),
    ),
    "records": Subject(
        {
            "source": (Annotated[list[str], typer.Argument(metavar="SOURCE...", help=SOURCE)], REQUIRED),
            **OVERRIDES,
            **{name: (annotation, None) for name, annotation in TREATMENT.items()},
        },
        _records,
    ),
}
