"""What each key of a scene file means, in words: for the schema that an editor reads, and for the docs.

Units and ranges stand beside the keys' readers; here is what a reader cannot know: meaning, an example, and what
holds where the key is left out.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from pounding_risk.models.effects import EFFECTS, PerInterface, default_example
from pounding_risk.units import EXAMPLES, Quantity, bounds, shown

REQUIRED = "required"


class Key(NamedTuple):
    """A key in words, an example as a scene file has it, and what holds where the key is left out."""

    words: str
    example: str
    absent: str = "nothing"


_STOREYS = "a list from the ground up, or one value for all storeys"
_RANGE = "a list in ascending order, or {start, stop, num}; a dimension of the dataset"

KEYS: dict[str, dict[str, Key]] = {
    "scene": {"name": Key("What reports and figures call the study.", '"Frame beside masonry"', "the file's name")},
    "building": {
        "name": Key("What tables and figures call the building; each has its own.", '"frame"', REQUIRED),
        "mass": Key("Its mass.", '"44.36 t"', "required, unless rigid or of storeys"),
        "period": Key(
            "Its natural period; or write stiffness.", '"0.208 s"', "required, unless stiffness, storeys or rigid"
        ),
        "stiffness": Key("Its lateral stiffness, in place of period.", '"40.5 MN/m"', "from mass and period"),
        "rigid": Key("true for a wall that moves with the ground.", "true", "false"),
        "damping": Key("Its viscous damping, as a ratio of critical.", "0.05", "0.05"),
        "floor_length": Key(
            "Length of its floor along the row.", '"20 m"', "none; contact model distributed_mass needs it"
        ),
        "wave_speed": Key("Speed of a wave along its floor.", '"3500 m/s"', '"3500 m/s", concrete'),
        "height": Key(
            "Height of its roof above the ground: level of a single mass, or what storeys are generated from.",
            '"12 m"',
            "a single mass or wall is as tall as its neighbour",
        ),
        "floor_depth": Key(
            "Depth of its floors below their levels; with it floors of neighbours that overlap in height meet floor to "
            "floor, others meet columns.",
            '"0.3 m"',
            "0.25 m, a slab of 6 m span (ACI 318-19, table 7.3.1.1: span / 24); a quarter of the lowest storey at most",
        ),
        "floor_masses": Key(
            f"Mass of each floor, in place of mass: {_STOREYS}.", '["210 t", "210 t", "180 t"]', "a single mass"
        ),
        "storey_stiffnesses": Key(f"Lateral stiffness of each storey: {_STOREYS}.", '"350 MN/m"', "a single mass"),
        "storey_heights": Key(f"Height of each storey: {_STOREYS}.", '["4 m", "3 m", "3 m"]', "a single mass"),
        "storey_strengths": Key(
            f"Yield shear of each storey, for inelastic_storeys: {_STOREYS}.", '"1400 kN"', "storeys stay elastic"
        ),
        "storeys": Key("How many storeys, where no list tells it.", "4", "as many as the lists have values"),
        "typology": Key(
            "What storeys are generated from, with height, storeys and floor_mass: a code's approximate period, or "
            "that of period, and a stated shape of the first mode.",
            '"concrete_frame"',
            "storeys are not generated",
        ),
        "floor_mass": Key("Mass of every floor of generated storeys.", '"200 t"', "storeys are not generated"),
        "damping_rule": Key(
            "How storeys are damped: the same ratio in every mode, by mass and stiffness, or by stiffness alone.",
            '"rayleigh"',
            '"modal"',
        ),
    },
    "interface": {
        "gap": Key(
            "Clear distance between the buildings at rest; one [[interface]] between each two neighbours of a row.",
            '"25 mm"',
            "the first of grid.gap",
        ),
        "contact_model": Key("The contact model.", '"jankowski"', "the first of grid.contact_model"),
        "stiffness": Key(
            "Stiffness of the contact, k in N/m or β in N/m^1.5 as the contact model has it.",
            '"4.2e7 kN/m^1.5"',
            "required, unless no contact model takes one",
        ),
        "restitution": Key(
            'Coefficient of restitution e, a named relation e(v), or {value = 0.65, relation = "exact"}, where damping '
            "follows from e by the exact relation instead of the published one. A damping ratio ξ of a law, as papers "
            'give it, is written "xi 0.35 of jankowski": e follows from the published relation.',
            '"concrete"',
            "required by models that damp or rebound by it",
        ),
        "yield_force": Key("Force F_E at which the contact yields; inf never yields.", '"450 kN"', '"inf"'),
        "column_yield_force": Key(
            "Force at which a column that is hit part-way up yields: its shear strength.", '"200 kN"', '"inf"'
        ),
        "contact": Key(
            "Where the two meet, instead of where their levels say: storey 2 is the floor on top of it, "
            "column 3 at 0.5 half-way up storey 3.",
            '[{left = "storey 2", right = "storey 2"}, {left = "storey 3", right = "column 3 at 0.5"}]',
            "every floor below the lower roof meets the other's floor at its level, or its column",
        ),
        "tolerance": Key(
            "How far apart the levels of floors may be that meet floor to floor, in place of the floors' depth.",
            '"0.1 m"',
            "floors meet where they overlap in height, by floor_depth",
        ),
        "plastic_exponent": Key("Exponent n of the plastic branch, for van_mier.", "0.5", "0, ideally plastic"),
        "design_penetration": Key(
            "Penetration for which bilinear is set up.", '"10 mm"', "the Hertz spring's at each approach speed"
        ),
        "equal_terms": Key(
            "Calibrates the grid's other laws to this one: what a reference impact has in common, at which approach "
            "speed, and with every_law = true for laws of the same unit too.",
            '{same = "peak force", speed = "0.5 m/s"}',
            "one stiffness for laws of one unit",
        ),
    },
    "equal_terms": {
        "same": Key("What the reference impact has in common under all laws.", '"peak force"', REQUIRED),
        "speed": Key("Approach speed of the reference impact.", '"0.5 m/s"', REQUIRED),
        "every_law": Key("true calibrates laws of the same unit too.", "true", "false"),
    },
    "records": {
        "names": Key("Ids of the catalogue.", '["RSN6-180"]', "one of names, files, set and manifest is required"),
        "files": Key(
            "Files, patterns or folders, from the scene's folder; one component after #.",
            '["my/*.AT2"]',
            "one of names, files, set and manifest is required",
        ),
        "set": Key("A published record set.", '"fema-p695-farfield"', "one of names, files, set and manifest"),
        "manifest": Key("A list of records with their factors.", '"chosen.csv"', "one of names, files, set, manifest"),
        "unit": Key("Unit of the samples of files that state none.", '"cm/s^2"', "the files state it"),
        "dt": Key("Time step of files that state none.", '"0.01 s"', "the files state it"),
        "direction": Key(
            "Direction of the row; both horizontals of each recording are turned to it.",
            '"30 deg"',
            "components as they are",
        ),
        "window": Key("The part of each record that is kept.", '["0 s", "6 s"]', "all of it"),
        "pga": Key("Every motion is scaled to this PGA.", '"0.5 g"', "as recorded"),
        "sa": Key(
            "Every motion is scaled to this spectral acceleration.",
            '{value = "0.4 g", period = "1 s"}',
            "as recorded",
        ),
        "to_median": Key(
            "Every recording is scaled to the ensemble's median PGA, PGV or Sa(T).", '"pgv"', "as recorded"
        ),
        "scale": Key("A factor on every motion, after any other scaling.", "1.5", "as recorded"),
        "polarity": Key(
            "As recorded, reversed, or both; a dimension of the dataset.",
            '["as recorded", "reversed"]',
            '"as recorded"',
        ),
        "processing": Key(
            "Steps from record to motion; auto processes raw records and leaves processed ones alone.",
            '[{step = "mean"}, {step = "bandpass", low = "0.1 Hz"}]',
            '"auto"',
        ),
        "tail": Key("Free vibration after each record.", '"5 s"', '"0 s"'),
    },
    "grid": {
        "gap": Key(f"Gaps: {_RANGE}.", '{start = "0 mm", stop = "100 mm", num = 51}', "that of the interface"),
        "interface": Key(
            "The only interface of a row whose gap varies, by its buildings.", '"frame | masonry"', "all vary alike"
        ),
        "yield_force": Key(f"Yield forces: {_RANGE}.", '["200 kN", "400 kN", "inf"]', "that of the interface"),
        "contact_model": Key(
            "Contact models; a dimension of the dataset.", '["jankowski", "hertz"]', "that of the interface"
        ),
        "pga": Key(f"PGAs: {_RANGE}.", '["0.2 g", "0.5 g"]', "that of the records"),
    },
    "solver": {"rtol": Key("Relative tolerance of every run.", "1e-6", "1e-6")},
}


def described(schema: dict[str, Any]) -> dict[str, Any]:
    """The schema of a scene with the words of every key, and without defaults that no file can state."""
    for section, table in _tables(schema):
        for name, found in table["properties"].items():
            _describe(found, _key(section, name))
            if section == "effects":
                found.update(_options(name))
    for name, found in schema["properties"].items():
        found.pop("default", None)
        found["title"] = f"[[{name}]]" if found.get("type") == "array" else f"[{name}]"
    return schema


def _tables(schema: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Each table of the schema by the name of its section."""
    for name, table in schema["$defs"].items():
        section = name.removesuffix("Table").lower()
        yield "equal_terms" if section == "equalterms" else section, table


def _key(section: str, name: str) -> Key:
    if section != "effects":
        return KEYS[section][name]
    kind: Any = EFFECTS[name]
    options = ", ".join(f"{key} = {option_example(allowed)}" for key, allowed in kind.options.items())
    left_out = "; ".join(f"{key} left out: {default_example(name, key)}" for key in kind.optional)
    return Key(
        (kind.__doc__ or "").partition("\n")[0],
        f"{{{options}}}",
        f"does not act{'; ' if left_out else ''}{left_out}",
    )


def _describe(found: dict[str, Any], key: Key) -> None:
    found.pop("default", None)
    found.pop("title", None)
    found["description"] = key.words
    found["x-example"], found["x-absent"] = key.example, key.absent


def _options(name: str) -> dict[str, Any]:
    """Words for each key of an effect's table of options."""
    kind: Any = EFFECTS[name]
    needed = [key for key in kind.options if key not in kind.optional]
    properties = {key: _option(allowed, default_example(name, key)) for key, allowed in kind.options.items()}
    return {"properties": properties, "required": needed, "additionalProperties": False}


def _option(allowed: Quantity | tuple[str, ...], absent: str) -> dict[str, Any]:
    more = {"x-example": option_example(allowed), "x-absent": absent}
    if not isinstance(allowed, Quantity):
        return {"enum": list(allowed), **more}
    kind = ["number", "string"] if allowed.unit == "1" else "string"
    kind = ["string", "array"] if isinstance(allowed, PerInterface) else kind
    words = f"{allowed.words[0].upper()}{allowed.words[1:]}."
    return {"type": kind, "description": words, **facts(allowed), **more}


def option_example(allowed: Quantity | tuple[str, ...]) -> str:
    """What a scene may write for an option that takes a quantity, or one of these words."""
    if not isinstance(allowed, Quantity):
        return shown(allowed[-1])
    example = allowed.example or EXAMPLES[allowed.unit]
    return example if allowed.unit == "1" else shown(example)


def facts(quantity: Quantity) -> dict[str, str]:
    """Unit and range of a key, for the schema."""
    return {"x-unit": quantity.unit, "x-range": bounds(quantity)}
