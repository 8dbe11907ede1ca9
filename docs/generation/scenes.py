"""The pages of a scene's keys and of a dataset's variables."""

from __future__ import annotations

from typing import Any

from generation.markdown import docstring, plain, table
from pounding_risk.models.effects import EFFECTS
from pounding_risk.results.run_labels import CONTACT_PLACE, CONTACTS, HISTORIES
from pounding_risk.scene import sections
from pounding_risk.scene.distributions import KINDS, Parameter
from pounding_risk.solver.counters import STATUS_SENTENCES
from pounding_risk.solver.pair.outputs import BUILDING, RUN
from pounding_risk.solver.row.outputs import OF_BUILDINGS, OF_POINTS, OF_RUNS, OF_STOREYS, OF_YIELDING, POINT

SCENE = """# Scene keys

A scene is one TOML file. Quantities are text with a unit, of any size: `"44.36 t"`, `"0.208 s"`, `"0.5 g"`. Any unit of
the right dimension is accepted; the column *unit* is the one used internally. A key that is not listed here is an error
that names the nearest one. All errors of a file are reported at once, with their lines.

`--set interface.gap="20 mm"` of a command replaces a value. `pounding-risk schema` writes this page as a JSON schema,
from which editors complete and check the keys of a scene.

"""
DISTRIBUTIONS = """### Distributions

Each number stands under its address, as `"building.frame.period" = {distribution = "lognormal", dispersion = 0.2}`. All
but `discrete` are cut at the bounds of the number itself, and at `low` and `high` where the scene writes them.

"""
HEADS = ("key", "meaning", "unit and range", "example", "default")


def scene_page() -> str:
    """Every key of a scene, from the schema."""
    schema = sections.schema()
    text = SCENE
    for section, declared in schema["properties"].items():
        keys = _table_of(schema, declared)
        text += f"## {plain(declared['title'])}\n\n"
        text += _effects(keys) if section == "effects" else table(HEADS, _rows(keys)) + "\n"
        for name in sections.INLINE.keys() & keys.keys():
            text += f"### {plain(name)}\n\n{table(HEADS, _rows(_table_of(schema, keys[name])))}\n"
        if section == "uncertain":
            text += f"{DISTRIBUTIONS}{table(('distribution', 'meaning', 'keys', 'example'), _distributions())}\n"
    return text


def _distributions() -> list[tuple[str, ...]]:
    """Every distribution with its keys."""
    return [
        (
            f"`{name}`",
            plain((kind.__doc__ or "").partition("\n")[0]),
            "; ".join(f"`{key}`: {plain(_parameter(one))}" for key, one in kind.takes.items()),
            f"`{kind.example}`",
        )
        for name, kind in KINDS.items()
    ]


def _parameter(one: Parameter) -> str:
    absent = "the scene's own value" if one.is_own else "" if one.is_needed else "may be left out"
    return f"{one.words} ({absent})" if absent else one.words


def _table_of(schema: dict[str, Any], section: dict[str, Any]) -> dict[str, Any]:
    """The keys of a section, which is a table, a list of tables, or either of them."""
    either = section.get("anyOf", [section])[0]
    reference = either.get("$ref") or either["items"]["$ref"]
    return schema["$defs"][reference.rpartition("/")[2]]["properties"]


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
    """A heading and a table of options for each effect."""
    text = "An effect acts only if the scene names it. [Description of each](effects.md).\n\n"
    for name, key in keys.items():
        text += f"### {plain(name)}\n\n{plain(key['description'])}\n\n"
        text += table(HEADS, _rows(key["properties"])) + "\n" if EFFECTS[name].options else f"`{name} = {{}}`\n\n"
    return text


OUTPUTS = """# Results

`scan` writes one netCDF file, an xarray dataset. Units are SI. A failed run has NaN in its
numbers and −1 in its counts, and `status` gives the reason; it is never counted as a run without contact.

Two buildings and a whole row have the same shape of dataset. Its cases are along `record`, `polarity`, `pga`,
`contact_model`, `gap` and `yield_force`; an output lives at the cases alone, or at each `interface`, `contact_point`,
`building` or `storey` of each. Two buildings have one interface: `results.squeeze("interface")` does without, and every
command and call reads what is left.

The attribute `dataset_version` is the version of this shape. A file of another version is refused with the repair: run
the scan again, or upgrade the package.

"""
STOREYS_AND_POINTS = """## Variables of contact points and storeys

Of buildings with storeys, of more than two buildings, and of contact points that the scene gives. Two single masses
that meet mass to mass have none of these: they would repeat those of the interface and of the buildings.

"""
ONE_RUN = """## One run

`simulate` returns one run: its histories, its contacts in the order of their touches, and every output above that the
solver makes, along `interface`, `contact_point`, `building` and `storey` with the coordinates below. What a solver does
not make is absent: the energies are those of two single masses, and of a row the contacts have their times, speed,
force and impulse. The attributes name the case (`record`, `polarity`, `pga`, `contact_model`, `gap`, `yield_force`),
and `status` says how the run ended; after a failure the histories are NaN. `histories` writes displacements, forces and
energies of many runs at the samples of their records, along the axes of the cases.

"""


def outputs_page(dataset: dict[str, dict[str, Any]]) -> str:
    """Every variable, coordinate and attribute of a scan."""
    heads = ("variable", "unit", "meaning")
    run = [(f"`{name}`", plain(each.unit), plain(each.words + _whole(each))) for name, each in RUN.items()]
    buildings = [
        (f"`{name}`, `{name}_free`", plain(unit), plain(f"{words}; `_free` is the value without contact"))
        for name, (unit, words, _) in BUILDING.items()
    ]
    places = [
        (f"`{name}`", plain(each.unit), plain(each.words), _along(list(each.dims)) or "every run")
        for name, each in (OF_STOREYS | OF_YIELDING | {"peak_drift": OF_BUILDINGS["peak_drift"]} | OF_RUNS).items()
    ]
    points = ", ".join(f"`{POINT}{name}`" for name in OF_POINTS)
    known = {*RUN, *BUILDING, *(f"{name}_free" for name in BUILDING)}
    more = {name: about for name, about in dataset["variables"].items() if name not in known}
    attributes = [(f"`{name}`", f"`{_short(value)}`" if value else "") for name, value in dataset["attributes"].items()]
    return (
        f"{OUTPUTS}## Variables of an interface\n\nOf each run, along `interface`; where an interface has several "
        f"contact points, `long_name` says how its value follows from theirs.\n\n{table(heads, run)}\n"
        "## Variables of a building\n\nOf each run, along `building`; those without contact only along the dimensions "
        f"of the motion.\n\n{table(heads, buildings)}\n"
        f"{STOREYS_AND_POINTS}{table((*heads, 'along'), places)}\n"
        f"Along `contact_point`, as for an interface: {points}. Those of storeys and of `building` have a twin without "
        f"contact, with `_free` at its end, and so has `{POINT}peak_closing`.\n\n"
        f"{ONE_RUN}{_labels(HISTORIES)}\nOf each contact, along `contact`:\n\n{table(heads, _contacts())}\n"
        f"## Further variables of runs and motions\n\n`change_` and `sensitive` exist if `--check-fraction` is above 0."
        f"\n\n{_labels(more)}\n"
        f"## Status of a run\n\n{table(('status', 'meaning'), _endings())}\n"
        "## Dimensions and coordinates\n\n`pga` is a dimension if a scene has several amplitudes.\n\n"
        f"{_labels(dataset['coordinates'])}\n"
        f"## Attributes\n\nThey contain all that is needed to repeat the scan. Those of a scan of the paper's pair:\n\n"
        f"{table(('attribute', 'example'), attributes)}\n"
        f"## Instant impacts\n\n{docstring(_jumps())}"
    )


def _contacts() -> list[tuple[str, str, str]]:
    facts = [(f"`contact_{name}`", plain(unit), plain(words)) for name, (unit, words) in CONTACTS.items()]
    return [*facts, ("`contact_place`", "", plain(CONTACT_PLACE["long_name"]))]


def _endings() -> list[tuple[str, str]]:
    return [(str(code), plain(sentence)) for code, sentence in sorted(STATUS_SENTENCES.items())]


def _whole(each: Any) -> str:
    return "; an integer" if each.whole else ""


def _labels(variables: dict[str, Any]) -> str:
    rows = [(f"`{name}`", plain(unit), plain(words), _along(dims)) for name, (dims, unit, words) in variables.items()]
    return table(("name", "unit", "meaning", "along"), rows)


def _along(dims: list[str]) -> str:
    """The dimensions of a variable; "every run" if it has those of a run."""
    return "every run" if {"gap", "yield_force"} < set(dims) else ", ".join(f"`{dim}`" for dim in dims)


def _short(value: str) -> str:
    text = " ".join(value.split()).replace("`", "'")
    return text if len(text) <= 70 else f"{text[:67]}..."


def _jumps() -> str:
    """The paragraphs on instant impacts from the docstring of the module of outputs."""
    from pounding_risk.solver.pair import outputs

    return (outputs.__doc__ or "").partition("\n\n")[2].partition("\n\n")[2]
