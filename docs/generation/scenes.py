"""The pages of a scene's keys and of a dataset's variables."""

from __future__ import annotations

from typing import Any

from generation.markdown import docstring, plain, table
from pounding_risk.models.effects import EFFECTS
from pounding_risk.scene.reader import scene_schema
from pounding_risk.solver.counters import STATUS_SENTENCES
from pounding_risk.solver.pair.outputs import BUILDING, RUN

SCENE = """# Scene keys

A scene is one TOML file. Quantities are text with a unit, of any size: `"44.36 t"`, `"0.208 s"`, `"0.5 g"`. Any unit of
the right dimension will do; the column *unit* is the one in which numbers are kept. A key that is not listed here is an
error that names the nearest one. Every fault of a file is told at once, with its line.

`--set interface.gap="20 mm"` of a command replaces a value. `pounding_risk.scene.reader.scene_schema()` gives this page
as a JSON schema, with which an editor completes keys.

"""
HEADS = ("key", "what", "unit and range", "example", "where it is left out")


def scene_page() -> str:
    """Every key of a scene, from the schema."""
    schema = scene_schema()
    text = SCENE
    for section, found in schema["properties"].items():
        keys = _table_of(schema, found)
        text += f"## {plain(found['title'])}\n\n"
        text += _effects(keys) if section == "effects" else table(HEADS, _rows(keys)) + "\n"
        if section == "interface":
            inner = schema["$defs"]["EqualTermsTable"]["properties"]
            text += f"### equal\\_terms\n\n{table(HEADS, _rows(inner))}\n"
    return text


def _table_of(schema: dict[str, Any], found: dict[str, Any]) -> dict[str, Any]:
    """The keys of a section, which is a table or a list of tables."""
    place = found.get("$ref") or found["items"]["$ref"]
    return schema["$defs"][place.rpartition("/")[2]]["properties"]


def _rows(keys: dict[str, Any]) -> list[tuple[str, ...]]:
    return [
        (f"`{name}`", plain(_words(key)), plain(_range(key)), f"`{key['x-example']}`", plain(key["x-absent"]))
        for name, key in keys.items()
    ]


def _words(key: dict[str, Any]) -> str:
    choices = ", ".join(f"`{word}`" for word in key.get("enum", ()))
    return f"{key.get('description', '')} {choices}".strip()


def _range(key: dict[str, Any]) -> str:
    unit = key.get("x-unit", "")
    return f"{unit}, {key['x-range']}".removeprefix("1, ") if unit else ""


def _effects(keys: dict[str, Any]) -> str:
    """One part an effect."""
    text = "None acts unless the scene names it. [What each does](effects.md).\n\n"
    for name, key in keys.items():
        text += f"### {plain(name)}\n\n{plain(key['description'])}\n\n"
        text += table(HEADS, _rows(key["properties"])) + "\n" if EFFECTS[name].options else f"`{name} = {{}}`\n\n"
    return text


OUTPUTS = """# Results

`scan` writes one netCDF file, an xarray dataset. SI units throughout. Where a run failed its numbers are NaN and its
counts −1, and `status` says why: such a run is never counted as one without contact.

"""


def outputs_page(dataset: dict[str, dict[str, Any]]) -> str:
    """Every variable, coordinate and attribute of a scan."""
    heads = ("variable", "unit", "what")
    run = [(f"`{name}`", plain(each.unit), plain(each.words + _whole(each))) for name, each in RUN.items()]
    buildings = [
        (f"`{name}`, `{name}_free`", plain(unit), plain(f"{words}; `_free` is the same without contact"))
        for name, (unit, words, _) in BUILDING.items()
    ]
    known = {*RUN, *BUILDING, *(f"{name}_free" for name in BUILDING)}
    more = {name: about for name, about in dataset["variables"].items() if name not in known}
    attributes = [(f"`{name}`", f"`{_short(value)}`" if value else "") for name, value in dataset["attributes"].items()]
    return (
        f"{OUTPUTS}## Of every run\n\nAlong every dimension but `building`.\n\n{table(heads, run)}\n"
        f"## Of every building\n\nAlong every dimension; those without contact only along those of the motion.\n\n"
        f"{table(heads, buildings)}\n"
        f"## About the runs and the motions\n\n`change_` and `sensitive` are there where `--check-fraction` is above 0."
        f"\n\n{_labels(more)}\n"
        f"## How a run may end\n\n{table(('status', 'what it says'), _endings())}\n"
        "## Dimensions and labels\n\n`pga` is a dimension where a scene has several.\n\n"
        f"{_labels(dataset['coordinates'])}\n"
        f"## Attributes\n\nEnough to run the study again. As in a scan of the paper's pair:\n\n"
        f"{table(('attribute', 'for example'), attributes)}\n"
        f"## Jumps\n\n{docstring(_jumps())}"
    )


def _endings() -> list[tuple[str, str]]:
    return [(str(code), plain(sentence)) for code, sentence in sorted(STATUS_SENTENCES.items())]


def _whole(each: Any) -> str:
    return "; a whole number" if each.whole else ""


def _labels(found: dict[str, Any]) -> str:
    rows = [(f"`{name}`", plain(unit), plain(words), _along(dims)) for name, (dims, unit, words) in found.items()]
    return table(("name", "unit", "what", "along"), rows)


def _along(dims: list[str]) -> str:
    """The dimensions of a variable; those of a run are not listed."""
    return "every run" if {"gap", "yield_force"} < set(dims) else ", ".join(f"`{dim}`" for dim in dims)


def _short(value: str) -> str:
    text = " ".join(value.split()).replace("`", "'")
    return text if len(text) <= 70 else f"{text[:67]}..."


def _jumps() -> str:
    """What the module says of models whose velocities jump, its second part."""
    from pounding_risk.solver.pair import outputs

    return (outputs.__doc__ or "").partition("\n\n")[2].partition("\n\n")[2]
